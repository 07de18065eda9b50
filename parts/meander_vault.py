"""The paper's shape study (figure 15): a meandering vault whose curve moves from layer to layer.

Six control points make a curve with points of inflection, a bench that rises into a canopy. From
layer to layer they wander, each by its own wave, and the planks follow.
"""

from math import pi, sin

import ifs_cad as ifs

if "show_object" not in globals():  # injected by CQGI and CQ-editor
    from ifs_cad import show_object

layers = 32
thickness = 24.0
width = 150.0
depth = 4
swing = 110.0  # how far control points wander
screw = 4.0
screw_spacing = 300.0
engraving_depth = 0.5
cutter = 3.0
nest = 1  # layers are sub-assemblies


def layer(number: int) -> ifs.Curve:
    """Return the curve of one layer; every second one has its joints between its neighbours'."""
    turn = 2 * pi * number / layers
    sway, nod = swing * sin(turn), swing * sin(turn + 0.8)
    return ifs.Curve(
        [
            (0, 0, 0),
            (-200 + 0.5 * sway, 0, 900),
            (1500 + sway, 0, -150 + 0.4 * nod),
            (900 - sway, 0, 2900 + nod),
            (2500 + 0.6 * sway, 0, 3500 + 0.6 * nod),
            (3400 + sway, 0, 2100 + nod),
        ],
        depth=depth,
    )


vault = ifs.vault(
    [layer(number) for number in range(layers)],
    width,
    thickness,
    side="outside",
    stagger=True,
    springing=(ifs.Plane((0, 0, 0), (0, 0, 1)), None),
)
assembly = ifs.to_assembly(
    vault,
    label=ifs.Label(depth=engraving_depth, cutter=cutter),
    holes=ifs.Screws(screw, spacing=screw_spacing),
    nest=nest,
    name="vault",
)
show_object(assembly, name="vault")
