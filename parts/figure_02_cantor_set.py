"""The Cantor set, figure 2: five construction steps below one another."""

import cadquery as cq

import ifs_cad as ifs

if "show_object" not in globals():  # injected by CQGI and CQ-editor
    from ifs_cad import show_object

length = 900.0
steps = 5
bar = 18.0

cantor = ifs.classics.cantor_set().scaled(length)
assembly = cq.Assembly(name="cantor")
for depth in range(steps + 1):
    segments = cantor.at_depth(depth)
    bars = [[(x0, 0), (x1, 0), (x1, bar), (x0, bar)] for x0, x1 in segments[:, :, 0].tolist()]
    row = cq.Location((0, -3 * bar * depth, 0))
    assembly.add(ifs.to_faces(bars), name=f"K{depth}", loc=row, color=cq.Color(0.36, 0.22, 0.1))
show_object(assembly, name="cantor")
