"""The construction tree, figure 7: every node has the address of its word."""

import cadquery as cq

import ifs_cad as ifs

if "show_object" not in globals():  # injected by CQGI and CQ-editor
    from ifs_cad import show_object

depth = 3
width = 420.0
level = 420.0
letter = 60.0

curve = ifs.Curve([(0, 0), (550, 800), (1100, 0)])
tree = ifs.Figure.from_curve(curve).tree(depth)
drawing = tree.drawing()
places = drawing.positions * (width, level)
assembly = cq.Assembly(name="tree")
branches = ifs.to_wires([places[edge] for edge in drawing.edges])
assembly.add(branches, name="branches", color=cq.Color(0.4, 0.25, 0.1))
for address, (x, y) in zip(drawing.addresses, places.tolist(), strict=True):
    text = cq.Workplane().text(tree.node(address).formula, letter, 2.0)
    assembly.add(
        text, name=f"node-{address}", loc=cq.Location((x, y, 4)), color=cq.Color(0.17, 0.44, 0.73)
    )
print(tree)
show_object(assembly, name="tree")
