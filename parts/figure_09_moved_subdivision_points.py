"""Acting on the transformations by moving subdivision points, figure 9: before and after."""

import cadquery as cq
import numpy as np

import ifs_cad as ifs

if "show_object" not in globals():  # injected by CQGI and CQ-editor
    from ifs_cad import show_object

depth = 6
apart = 1300.0

control = [(0, 0), (550, 800), (1100, 0)]
drawn = ifs.Curve(control, depth=depth)
moved = drawn.with_subdivision_point("s2", (140, 560)).with_subdivision_point("s3", (640, 330))
red, blue, brown = cq.Color(0.75, 0.22, 0.17), cq.Color(0.17, 0.44, 0.73), cq.Color(0.4, 0.25, 0.1)
assembly = cq.Assembly(name="subdivision")
for number, curve in enumerate((drawn, moved)):
    panel = cq.Assembly(name=f"panel{number}")
    panel.add(ifs.to_wire(control), name=f"polygon{number}", color=red)
    panel.add(ifs.to_dots(control, 14), name=f"control{number}", color=red)
    handles = np.array(list(curve.subdivision_points.values()))
    panel.add(ifs.to_dots(handles, 14), name=f"handles{number}", color=blue)
    panel.add(ifs.to_wire(curve.points), name=f"curve{number}", color=brown)
    assembly.add(panel, loc=cq.Location((apart * number, 0, 0)))
show_object(assembly, name="subdivision")
