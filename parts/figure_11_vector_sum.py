"""The vector sum, figure 11: two curves and the surface of parallelograms that they span."""

import cadquery as cq

import ifs_cad as ifs

if "show_object" not in globals():  # injected by CQGI and CQ-editor
    from ifs_cad import show_object

depth = 4

a = ifs.Curve([(0, 0, 0), (500, 0, 1500), (2500, 0, 1500), (3000, 0, 0)], depth=depth)
b = ifs.Curve([(0, 0, 0), (200, 900, 900), (-200, 2000, -500), (0, 3000, 0)], depth=depth)
surface = ifs.vector_sum(a, b)
assembly = cq.Assembly(name="sum")
assembly.add(ifs.mesh_to_faces(surface), name="surface", color=cq.Color(0.87, 0.72, 0.5))
for name, curve, shift in (("a", a, (0, -350, 0)), ("b", b, (-350, 0, 0))):
    wire = ifs.to_wire(curve.points)
    assembly.add(wire, name=name, loc=cq.Location(shift), color=cq.Color(0.75, 0.22, 0.17))
show_object(assembly, name="sum")
