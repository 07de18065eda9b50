"""A dome whose nodes are all exact: trapezoids over a polygon around one circle."""

import ifs_cad as ifs

if "show_object" not in globals():  # injected by CQGI and CQ-editor
    from ifs_cad import show_object

radius = 3000.0
height = 2200.0
eye = 350.0  # radius of the opening at the top
sides = 20
depth = 3
thickness = 18.0

profile = ifs.Curve(
    [(radius, 0, 0), (radius, 0, 0.8 * height), (0.5 * radius, 0, height), (eye, 0, height)],
    depth=depth,
)
shell = ifs.thicken(ifs.dome(profile, sides=sides), thickness)
assembly = ifs.to_assembly(shell, label="engraved", nest=1, name="dome")
show_object(assembly, name="dome")
