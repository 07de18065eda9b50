"""Smooth, half rough and rough shells over twelve metres, figure 22: what folds do for stiffness.

The paper tells the span (12 m), the panels (20 mm spruce plywood, joined by hinges), the load
(1500 N/m2, asymmetrical) and the largest deflections, 266 mm smooth and 15 mm rough. Everything
else is assumed here, rises and width so that the smooth shell comes near 266 mm, the height of the
folds so that the rough one comes near 15 mm; so both numbers only show that some such shell exists:

- a surface of translation, 9 m wide, of two parabolas with rises of 2.5 m along the span and 1 m
  across, in 16 x 16 panels;
- folds: every second point of the curve across lies 0.25 m higher, so that the folds run along
  the span; half rough means half as high;
- plywood as stiff in all directions, 9000 MPa and a Poisson's ratio of 0.3; as strong as that of
  `ifs_cad.elements.material`, its fibre along the span;
- both ends of the span pinned, the other borders free, the load on half the span.

`ifs-cad analyse parts/figure_22.py` compares the three; `docs/structure.md` tells how far the
answer depends on what is assumed.
"""

from dataclasses import replace

import cadquery as cq

import ifs_cad as ifs
from ifs_cad.elements.material import SPRUCE_PLYWOOD

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
load = 1500.0  # N/m2 of the ground plan, on half the span
apart = 2000.0

plywood = replace(
    SPRUCE_PLYWOOD,
    name="spruce plywood, isotropic",
    stiffness=ifs.Stiffness.isotropic(modulus, poisson),
)
along = ifs.Curve([(0, 0, 0), (span / 2, 0, 2 * rise), (span, 0, 0)], depth=depth)
across = ifs.Curve([(0, 0, 0), (0, width / 2, 2 * rise_across), (0, width, 0)], depth=depth)
question = ifs.Analysis(
    loads=ifs.AreaLoad(pressure=load, on=ifs.Plane((span / 2, 0, 0), (-1, 0, 0))),
    supports=[ifs.Support.border("a start"), ifs.Support.border("a end")],
)
whole = cq.Assembly(name="figure_22", metadata={"analysis": question})
for number, (name, roughness) in enumerate((("smooth", 0.0), ("half_rough", 0.5), ("rough", 1.0))):
    curve = across.points.copy()
    curve[1::2, 2] += roughness * fold
    surface = ifs.vector_sum(along, curve, addresses="lexicographic")
    shell = ifs.thicken(surface, thickness, material=plywood)
    shell = shell.with_fibre(ifs.FibreAlongCurve("a"))
    part = ifs.to_assembly(shell, name=name)
    whole.add(part, name=name, loc=cq.Location((0, number * (width + apart), 0)))
show_object(whole, name="figure_22")
