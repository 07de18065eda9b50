"""Point weights, figure 12: a regular grid, and the same with two weights edited."""

import cadquery as cq

import ifs_cad as ifs

if "show_object" not in globals():  # injected by CQGI and CQ-editor
    from ifs_cad import show_object

depth = 3
apart = 3600.0

assembly = cq.Assembly(name="weights")
for number, (weight_a, weight_b) in enumerate(((1.0, 1.0), (1.6, 1.25))):
    a = ifs.Curve([(0, 0, 0), (1500, 0, 0), (3000, 0, 0)], weights=[1, weight_a, 1], depth=depth)
    b = ifs.Curve([(0, 0, 0), (0, 1500, 0), (0, 3000, 0)], weights=[1, weight_b, 1], depth=depth)
    grid = ifs.mesh_to_faces(ifs.vector_sum(a, b))
    place = cq.Location((apart * number, 0, 0))
    assembly.add(grid, name=f"grid{number}", loc=place, color=cq.Color(0.87, 0.72, 0.5))
show_object(assembly, name="weights")
