"""A thickened IFS surface, figure 18: every face replaced by a construction element."""

import ifs_cad as ifs

if "show_object" not in globals():  # injected by CQGI and CQ-editor
    from ifs_cad import show_object

thickness = 30.0
depth = 4
roughness = 0.5

a = ifs.Curve([(0, 0, 0), (200, 300, 1800), (3200, -300, 1500), (3600, 0, 200)], depth=depth)
b = ifs.Curve([(0, 0, 0), (300, 1400, 900), (0, 3000, 0)], depth=depth).with_roughness(roughness)
shell = ifs.thicken(ifs.vector_sum(a, b), thickness)
show_object(ifs.to_assembly(shell, nest=1), name="shell")
