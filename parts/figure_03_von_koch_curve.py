"""The von Koch curve, figure 3: five construction steps below one another."""

import cadquery as cq

import ifs_cad as ifs

if "show_object" not in globals():  # injected by CQGI and CQ-editor
    from ifs_cad import show_object

length = 900.0
steps = 4

koch = ifs.classics.von_koch_curve().scaled(length)
assembly = cq.Assembly(name="koch")
for depth in range(steps + 1):
    place = cq.Location(((depth % 2) * 1.1 * length, -(depth // 2) * 0.42 * length, 0))
    wire = ifs.to_wire(koch.polyline(depth))
    assembly.add(wire, name=f"K{depth}", loc=place, color=cq.Color(0.36, 0.22, 0.1))
show_object(assembly, name="koch")
