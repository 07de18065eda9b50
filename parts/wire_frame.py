"""A wire frame over a triangular IFS patch: six bars at every inner node, edges become beams."""

import ifs_cad as ifs

if "show_object" not in globals():  # injected by CQGI and CQ-editor
    from ifs_cad import show_object

depth = 3
side = 6000.0
rise = 2600.0
width = 40.0
height = 70.0

half, tall = side / 2, side * 3**0.5 / 2
net = [
    [(half, tall, 0)],
    [(half / 2, tall / 2, rise), (0.75 * side, tall / 2, 0.8 * rise)],
    [(0, 0, 0), (half, 0, 0.6 * rise), (side, 0, 0)],
]
patch = ifs.TriangularPatch([point for row in net for point in row], depth=depth)
ifs.check_constraints(patch.mesh, [ifs.NodeValence(6), ifs.MinimumEdge(300)]).require()
frame = ifs.WireFrame(patch.mesh, width, height, clearance=5.0)
show_object(ifs.to_assembly(frame, name="frame"), name="frame")
