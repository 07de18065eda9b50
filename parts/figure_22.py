"""A smooth and a folded shell over twelve metres, figure 22: what folds do for stiffness.

The paper tells the span (12 m), the panels (20 mm spruce plywood, joined by hinges), the load
(1500 N/m2, asymmetrical) and the largest deflections, 266 mm smooth and 15 mm folded. Everything
else is assumed here, so that the smooth shell comes near 266 mm:

- a surface of translation, 9 m wide, of two parabolas with rises of 2.5 m along the span and 1 m
  across, in 16 x 16 panels;
- folds: every second point of the curve across lies 0.25 m higher, so that the folds run along
  the span;
- plywood without a fibre direction, 9000 MPa and a Poisson's ratio of 0.3;
- both ends of the span pinned, the other borders free, the load on half the span.

`ifs-cad analyse parts/figure_22.py --half --supports "a start, a end"` computes both.
"""

import cadquery as cq

import ifs_cad as ifs
from ifs_cad.elements.material import Stiffness

if "show_object" not in globals():  # injected by CQGI and CQ-editor
    from ifs_cad import show_object

thickness = 20.0
span = 12000.0
width = 9000.0
rise = 2500.0  # along the span
rise_across = 1000.0
fold = 250.0
depth = 4
modulus = 9000.0  # MPa
poisson = 0.3
apart = 2000.0

plywood = ifs.Material(
    "spruce plywood, isotropic", 450.0, (0.87, 0.72, 0.50), Stiffness.isotropic(modulus, poisson)
)
along = ifs.Curve([(0, 0, 0), (span / 2, 0, 2 * rise), (span, 0, 0)], depth=depth)
across = ifs.Curve([(0, 0, 0), (0, width / 2, 2 * rise_across), (0, width, 0)], depth=depth)
folded = across.points.copy()
folded[1::2, 2] += fold

assembly = cq.Assembly(name="figure_22")
for name, curve, offset in (
    ("smooth", across.points, 0.0),
    ("folded", folded, width + apart),
):
    surface = ifs.vector_sum(along, curve, addresses="lexicographic")
    shell = ifs.thicken(surface, thickness, material=plywood)
    part = ifs.to_assembly(shell, name=name)
    assembly.add(part, name=name, loc=cq.Location((0, offset, 0)))
show_object(assembly, name="figure_22")
