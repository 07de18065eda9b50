"""De Casteljau's construction, figure 5: a Bezier curve as the limit of broken lines."""

import cadquery as cq
import numpy as np

import ifs_cad as ifs

if "show_object" not in globals():  # injected by CQGI and CQ-editor
    from ifs_cad import show_object

steps = 4
colours = np.linspace(0.15, 0.8, steps + 1).tolist()

control = [(0, 0), (300, 700), (1100, 600)]
assembly = cq.Assembly(name="bezier")
assembly.add(ifs.to_wire(control), name="control", color=cq.Color(0.75, 0.22, 0.17))
assembly.add(ifs.to_dots(control, 12), name="points", color=cq.Color(0.75, 0.22, 0.17))
for depth in range(steps + 1):
    wire = ifs.to_wire(ifs.Curve(control, depth=depth).points)
    shade = 0.8 - colours[depth]
    assembly.add(wire, name=f"K{depth}", color=cq.Color(shade, 0.5 * shade, 0.1))
show_object(assembly, name="bezier")
