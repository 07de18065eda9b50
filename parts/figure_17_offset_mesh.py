"""Thickening, figure 17: the surface, its offset, and the panels between on bisector planes."""

import cadquery as cq

import ifs_cad as ifs

if "show_object" not in globals():  # injected by CQGI and CQ-editor
    from ifs_cad import show_object

thickness = 60.0
lift = 700.0
apart = 1.12  # of the exploded panels

a = ifs.Curve([(0, 0, 0), (400, 0, 900), (1600, 0, 900), (2000, 0, 0)], depth=2)
b = ifs.Curve([(0, 0, 0), (0, 700, 500), (0, 1500, 0)], depth=1).with_even_fold(0.9)
surface = ifs.vector_sum(a, b)
shell = ifs.thicken(surface, thickness)
assembly = cq.Assembly(name="offset")
assembly.add(ifs.mesh_to_faces(surface), name="surface", color=cq.Color(0.6, 0.7, 0.8))
panels = ifs.to_assembly(shell, name="panels")
middle = surface.vertices.mean(axis=0)
for part in panels.children:
    out = (apart - 1) * (shell[part.name].solid.vertices.mean(axis=0) - middle)
    part.loc = cq.Location((*out[:2], out[2] + lift)) * part.loc
assembly.add(panels)
show_object(assembly, name="offset")
