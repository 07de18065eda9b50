"""The first construction steps of a Bezier curve, figure 6, with the subdivision points of each."""

import cadquery as cq

import ifs_cad as ifs

if "show_object" not in globals():  # injected by CQGI and CQ-editor
    from ifs_cad import show_object

steps = 3
apart = 1250.0

control = [(0, 0), (550, 800), (1100, 0)]
red, blue, brown = cq.Color(0.75, 0.22, 0.17), cq.Color(0.17, 0.44, 0.73), cq.Color(0.4, 0.25, 0.1)
assembly = cq.Assembly(name="steps")
for depth in range(steps + 1):
    curve = ifs.Curve(control, depth=depth)
    step = cq.Assembly(name=f"PK{depth}")
    step.add(ifs.to_wire(control), name=f"polygon{depth}", color=red)
    step.add(ifs.to_dots(control, 14), name=f"control{depth}", color=red)
    step.add(ifs.to_wire(curve.points), name=f"curve{depth}", color=brown)
    step.add(
        ifs.to_dots(curve.points[1:-1], 10) if depth else ifs.to_dots(control[:1], 10),
        name=f"joints{depth}",
        color=blue,
    )
    assembly.add(step, loc=cq.Location((apart * (depth % 2), -900 * (depth // 2), 0)))
show_object(assembly, name="steps")
