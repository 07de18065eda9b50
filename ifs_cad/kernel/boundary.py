"""A shape of the kernel as plain numbers: faces, edges, and what they lie on."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.GeomAbs import GeomAbs_Circle, GeomAbs_Cylinder, GeomAbs_Line, GeomAbs_Plane
from OCP.TopAbs import (
    TopAbs_EDGE,
    TopAbs_FACE,
    TopAbs_FORWARD,
    TopAbs_REVERSED,
    TopAbs_VERTEX,
)
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Face, TopoDS_Iterator, TopoDS_Shape
from OCP.TopTools import TopTools_IndexedMapOfShape

from ifs_cad.elements.boundary import Boundary, Curves, Surface

__all__ = ["boundary_of", "curves_of", "numbers", "subshapes"]

Triple = tuple[float, float, float]

_NOWHERE: Triple = (math.nan, math.nan, math.nan)
_Arc = tuple[float, Triple, Triple]
"""Sweep (0 for a line, NaN for other curves), centre and axis."""


def subshapes(shape: TopoDS_Shape, kind: Any) -> list[TopoDS_Shape]:
    """Return the shapes of a kind within another, each once."""
    found = TopTools_IndexedMapOfShape()
    TopExp.MapShapes_s(shape, kind, found)
    return [found.FindKey(k) for k in range(1, found.Extent() + 1)]


def boundary_of(body: TopoDS_Shape) -> Boundary:
    """Return the faces and edges of a solid."""
    vertices, edges, faces = (TopTools_IndexedMapOfShape() for _ in range(3))
    TopExp.MapShapes_s(body, TopAbs_VERTEX, vertices)
    TopExp.MapShapes_s(body, TopAbs_EDGE, edges)
    TopExp.MapShapes_s(body, TopAbs_FACE, faces)
    points = [
        numbers(BRep_Tool.Pnt_s(TopoDS.Vertex_s(vertices.FindKey(k))))
        for k in range(1, vertices.Extent() + 1)
    ]
    ends = np.empty((edges.Extent(), 2), dtype=np.int64)
    arcs = []
    for k in range(edges.Extent()):
        edge = TopoDS.Edge_s(edges.FindKey(k + 1).Oriented(TopAbs_FORWARD))
        ends[k, 0] = vertices.FindIndex(TopExp.FirstVertex_s(edge)) - 1
        ends[k, 1] = vertices.FindIndex(TopExp.LastVertex_s(edge)) - 1
        arcs.append(_arc(edge))

    used: list[int] = []
    forward: list[bool] = []
    loops: list[int] = []
    loop_faces: list[int] = []
    surfaces = []
    for k in range(faces.Extent()):
        face = TopoDS.Face_s(faces.FindKey(k + 1))
        surfaces.append(_surface(face))
        for wire in _children(face):
            # the edges of a wire that is turned round come in the order of the original
            sides = [side for side in _children(wire) if not _is_point(side)]
            if wire.Orientation() == TopAbs_REVERSED:
                sides.reverse()
            used += [edges.FindIndex(side) - 1 for side in sides]
            forward += [side.Orientation() == TopAbs_FORWARD for side in sides]
            loops += [len(loop_faces)] * len(sides)
            loop_faces.append(k)

    which, along = np.array(used, dtype=np.int64), np.array(forward, dtype=bool)
    tails = np.where(along, ends[which, 0], ends[which, 1])
    heads = np.where(along, ends[which, 1], ends[which, 0])
    positions = np.array(points)
    sweeps, centres, axes = (np.array(column)[which] for column in zip(*arcs, strict=True))
    kinds, anchors, directions, radii = zip(*surfaces, strict=True)
    return Boundary(
        vertices=positions,
        tails=tails,
        heads=heads,
        curves=Curves(
            positions[tails],
            positions[heads],
            sweeps,
            centres,
            np.where(along[:, None], axes, -axes),
        ),
        edges=which,
        forward=along,
        loops=np.array(loops, dtype=np.int64),
        faces=np.array(loop_faces, dtype=np.int64),
        surfaces=np.array(kinds, dtype=np.int64),
        points=np.array(anchors),
        directions=np.array(directions),
        radii=np.array(radii),
    )


def _children(shape: TopoDS_Shape) -> Iterator[TopoDS_Shape]:
    children = TopoDS_Iterator(shape)
    while children.More():
        yield children.Value()
        children.Next()


def numbers(triple: Any) -> Triple:
    """Return the coordinates of a point or a direction."""
    return triple.X(), triple.Y(), triple.Z()


def _is_point(edge: TopoDS_Shape) -> bool:
    """Tell whether an edge is only the pole of a surface: it has one face and no length."""
    return bool(BRep_Tool.Degenerated_s(TopoDS.Edge_s(edge)))


def _arc(edge: TopoDS_Edge) -> _Arc:
    if _is_point(edge):
        return math.nan, _NOWHERE, _NOWHERE
    curve = BRepAdaptor_Curve(edge)
    kind = curve.GetType()
    if kind == GeomAbs_Line:
        return 0.0, _NOWHERE, _NOWHERE
    if kind != GeomAbs_Circle:
        return math.nan, _NOWHERE, _NOWHERE
    circle = curve.Circle()
    sweep = curve.LastParameter() - curve.FirstParameter()
    return sweep, numbers(circle.Location()), numbers(circle.Axis().Direction())


def _surface(
    face: TopoDS_Face,
) -> tuple[Surface, Triple, Triple, float]:
    """Return kind, a point, the outward normal or the axis, and the radius of a face's surface."""
    surface = BRepAdaptor_Surface(face, False)
    kind = surface.GetType()
    if kind == GeomAbs_Plane:
        plane = surface.Plane()
        normal = plane.Axis().Direction()
        if plane.Direct() == (face.Orientation() == TopAbs_REVERSED):
            normal.Reverse()
        return Surface.PLANE, numbers(plane.Location()), numbers(normal), 0.0
    if kind == GeomAbs_Cylinder:
        cylinder = surface.Cylinder()
        axis = cylinder.Axis()
        direction = numbers(axis.Direction())
        return Surface.CYLINDER, numbers(axis.Location()), direction, cylinder.Radius()
    return Surface.OTHER, _NOWHERE, _NOWHERE, math.nan


def curves_of(shape: TopoDS_Shape) -> Curves:
    """Return all edges of a shape, each from its own start to its end."""
    edges = TopExp_Explorer(shape, TopAbs_EDGE)
    starts, ends, arcs = [], [], []
    while edges.More():
        edge = TopoDS.Edge_s(edges.Current().Oriented(TopAbs_FORWARD))
        arcs.append(_arc(edge))
        curve = BRepAdaptor_Curve(edge)
        starts.append(numbers(curve.Value(curve.FirstParameter())))
        ends.append(numbers(curve.Value(curve.LastParameter())))
        edges.Next()
    sweeps, centres, axes = zip(*arcs, strict=True) if arcs else ((), (), ())
    return Curves(
        np.array(starts).reshape(-1, 3),
        np.array(ends).reshape(-1, 3),
        np.array(sweeps, dtype=float),
        np.array(centres, dtype=float).reshape(-1, 3),
        np.array(axes, dtype=float).reshape(-1, 3),
    )
