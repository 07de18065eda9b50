"""A through-hole as an exact cylinder, ready to be set into two parallel faces."""

from __future__ import annotations

import math
from functools import lru_cache

from OCP.BRep import BRep_Builder
from OCP.Geom import Geom_Circle, Geom_CylindricalSurface, Geom_Line
from OCP.Geom2d import Geom2d_Line
from OCP.gp import gp_Ax2, gp_Ax3, gp_Dir, gp_Dir2d, gp_Pnt, gp_Pnt2d
from OCP.TopAbs import TopAbs_FORWARD, TopAbs_REVERSED
from OCP.TopoDS import TopoDS_Edge, TopoDS_Face, TopoDS_Vertex, TopoDS_Wire

from ifs_cad.elements.polyhedron import Kind
from ifs_cad.kernel.solid import Inset
from ifs_cad.tolerance import KERNEL

_OTHER = {Kind.UPPER: Kind.LOWER, Kind.LOWER: Kind.UPPER}


@lru_cache(maxsize=64)
def bore(diameter: float, thickness: float, top: Kind) -> Inset:
    """Return a hole down the z axis from z = 0, where the face `top` lies, to -thickness, mm."""
    builder = BRep_Builder()
    radius = diameter / 2
    surface = Geom_CylindricalSurface(gp_Ax3(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), radius)
    levels = (-thickness, 0.0)
    vertices, circles = [], []
    for level in levels:
        vertex = TopoDS_Vertex()
        builder.MakeVertex(vertex, gp_Pnt(radius, 0, level), KERNEL)
        circle = TopoDS_Edge()
        axis = gp_Ax2(gp_Pnt(0, 0, level), gp_Dir(0, 0, 1))
        builder.MakeEdge(circle, Geom_Circle(axis, radius), KERNEL)
        builder.Add(circle, vertex.Oriented(TopAbs_FORWARD))
        builder.Add(circle, vertex.Oriented(TopAbs_REVERSED))
        builder.Range(circle, 0.0, 2 * math.pi)
        vertices.append(vertex)
        circles.append(circle)
    seam = TopoDS_Edge()
    builder.MakeEdge(seam, Geom_Line(gp_Pnt(radius, 0, -thickness), gp_Dir(0, 0, 1)), KERNEL)
    builder.Add(seam, vertices[0].Oriented(TopAbs_FORWARD))
    builder.Add(seam, vertices[1].Oriented(TopAbs_REVERSED))
    builder.Range(seam, 0.0, thickness)

    wall = TopoDS_Face()
    builder.MakeFace(wall, surface, KERNEL)
    for circle, level in zip(circles, levels, strict=True):
        on_wall = Geom2d_Line(gp_Pnt2d(0, level), gp_Dir2d(1, 0))
        builder.UpdateEdge(circle, on_wall, wall, KERNEL)
    up = gp_Dir2d(0, 1)
    builder.UpdateEdge(
        seam,
        Geom2d_Line(gp_Pnt2d(2 * math.pi, -thickness), up),
        Geom2d_Line(gp_Pnt2d(0, -thickness), up),
        wall,
        KERNEL,
    )
    around = TopoDS_Wire()
    builder.MakeWire(around)
    for edge in (circles[0], seam, circles[1].Reversed(), seam.Reversed()):
        builder.Add(around, edge)
    around.Closed(True)
    builder.Add(wall, around)

    # the wall looks into the hole, so it is turned round, and each rim with it
    return Inset(
        rims={
            top: [_ring(builder, circles[1].Reversed())],
            _OTHER[top]: [_ring(builder, circles[0])],
        },
        faces=[wall.Reversed()],
        volume=math.pi * radius**2 * thickness,
    )


def _ring(builder: BRep_Builder, circle: TopoDS_Edge) -> TopoDS_Wire:
    ring = TopoDS_Wire()
    builder.MakeWire(ring)
    builder.Add(ring, circle)
    ring.Closed(True)
    return ring
