"""Control points (red) and subdivision points (blue) of a curve, figure 8."""

import cadquery as cq
import numpy as np

import ifs_cad as ifs

if "show_object" not in globals():  # injected by CQGI and CQ-editor
    from ifs_cad import show_object

depth = 6

control = [(0, 0), (550, 800), (1100, 0)]
curve = ifs.Curve(control, depth=depth)
red, blue, brown = cq.Color(0.75, 0.22, 0.17), cq.Color(0.17, 0.44, 0.73), cq.Color(0.4, 0.25, 0.1)
assembly = cq.Assembly(name="handles")
assembly.add(ifs.to_wire(control), name="polygon", color=red)
assembly.add(ifs.to_dots(control, 14), name="control", color=red)
handles = np.array(list(curve.subdivision_points.values()))
assembly.add(ifs.to_dots(handles, 14), name="subdivision", color=blue)
assembly.add(ifs.to_wire(curve.points), name="curve", color=brown)
show_object(assembly, name="handles")
