"""Smooth and rough, figure 10: one curve, its roughness set by its subdivision points."""

import cadquery as cq
import numpy as np

import ifs_cad as ifs

if "show_object" not in globals():  # injected by CQGI and CQ-editor
    from ifs_cad import show_object

depth = 7
apart = 1250.0

control = [(0, 0), (550, 800), (1100, 0)]
red, blue, brown = cq.Color(0.75, 0.22, 0.17), cq.Color(0.17, 0.44, 0.73), cq.Color(0.4, 0.25, 0.1)
assembly = cq.Assembly(name="roughness")
for number, roughness in enumerate((0.0, 0.25, 0.45, 0.65)):
    curve = ifs.Curve(control, depth=depth).with_roughness(roughness)
    panel = cq.Assembly(name=f"panel{number}")
    panel.add(ifs.to_wire(control), name=f"polygon{number}", color=red)
    handles = np.array(list(curve.subdivision_points.values()))
    panel.add(ifs.to_dots(handles, 14), name=f"handles{number}", color=blue)
    panel.add(ifs.to_wire(curve.points), name=f"curve{number}", color=brown)
    assembly.add(panel, loc=cq.Location((apart * (number % 2), -1000 * (number // 2), 0)))
show_object(assembly, name="roughness")
