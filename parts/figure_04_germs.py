"""Fishes and letters, figure 4: the germ does not matter, the transformations make the figure.

A Sierpinski triangle from fishes and a von Koch curve from the letter A, beside the same figures
from their usual germs. With every step both come nearer to the same limit.
"""

import cadquery as cq

import ifs_cad as ifs

if "show_object" not in globals():  # injected by CQGI and CQ-editor
    from ifs_cad import show_object

size = 900.0
steps = 6

triangle = ifs.classics.sierpinski_triangle().scaled(size)
koch = ifs.classics.von_koch_curve().scaled(size)
fish = (
    cq.Workplane()
    .moveTo(0.1, 0.3)
    .threePointArc((0.4, 0.5), (0.7, 0.3))
    .lineTo(0.9, 0.45)
    .lineTo(0.9, 0.15)
    .lineTo(0.7, 0.3)
    .threePointArc((0.4, 0.1), (0.1, 0.3))
    .close()
    .extrude(0.02)
    .val()
    .scale(size)
)
letter = cq.Workplane().text("A", 0.5 * size, 0.02 * size, valign="bottom").val()
letter = letter.moved(cq.Location((0.5 * size, 0, 0)))
plain = cq.Workplane().polyline([(0, 0), (size, 0), (size / 2, size * 3**0.5 / 2)]).close()
plain = plain.extrude(0.02 * size).val()
blue = (0.24, 0.42, 0.62)

assembly = cq.Assembly(name="germs")
for column, depth in enumerate((0, 1, 3, steps)):
    for row, (figure, germ, colour) in enumerate(
        [
            (triangle, fish, (0.85, 0.45, 0.2)),
            (triangle, plain, blue),
            (koch, letter, (0.6, 0.25, 0.3)),
        ]
    ):
        if row == 2 and depth == steps:
            depth = steps - 2  # four transformations instead of three
        made = ifs.place_germ(
            germ, figure.transforms(depth), name=f"row{row}-K{depth}-{column}", colours=[colour]
        )
        assembly.add(made, loc=cq.Location((1.1 * size * column, -1.0 * size * row, 0)))
show_object(assembly, name="germs")
