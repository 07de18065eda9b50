"""A climbing wall, from the paper's outlook: a rough face of plywood that leans over."""

import ifs_cad as ifs

if "show_object" not in globals():  # injected by CQGI and CQ-editor
    from ifs_cad import show_object

width = 6000.0
height = 4000.0
overhang = 900.0
roughness = 0.45
depth = 4
thickness = 21.0

across = ifs.Curve([(0, 0, 0), (width / 2, 700, 0), (width, 0, 0)], depth=depth)
upwards = ifs.Curve([(0, 0, 0), (0, -0.4 * overhang, height / 2), (0, -overhang, height)], depth=3)
surface = ifs.vector_sum(across.with_roughness(roughness), upwards)
shell = ifs.thicken(surface, thickness, side="inner", clearance=0.3)
assembly = ifs.to_assembly(shell, label=ifs.Label(face="inner"), holes=ifs.Holes(8, 60), nest=1)
show_object(assembly, name="wall")
