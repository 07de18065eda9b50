"""Shapes as triangles and lines, for `render`.

A point belongs to one face only, so whoever averages normals over the triangles at a point gets
smooth faces and crisp edges. An edge comes with each of its faces, the seam of a round face not at
all. Edges without a face come too.

Most faces of a panel are flat, and the edges of a flat face are where its triangles have no
neighbour: read as arrays, that takes a tenth of asking the kernel for every edge.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import cadquery as cq
import numpy as np
from numpy.typing import NDArray
from OCP.BRep import BRep_Tool
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.Geom import Geom_Plane
from OCP.IMeshTools import IMeshTools_MeshAlgoType, IMeshTools_Parameters
from OCP.Poly import Poly_Triangulation
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Face, TopoDS_Shape, TopoDS_TShape

DEVIATION = 1e-4  # of a chord from its curve, share of the model's size
TURN = 1.1  # radians between chords of a curve too small for its deviation to be seen

EDGE, FACE = TopAbs_ShapeEnum.TopAbs_EDGE, TopAbs_ShapeEnum.TopAbs_FACE
NOWHERE = TopAbs_ShapeEnum.TopAbs_SHAPE

Rows = NDArray[Any]
NO_POINTS = np.empty((0, 3))
NO_TRIANGLES = np.empty((0, 3), dtype=np.int64)
NO_LINES = np.empty((0, 2), dtype=np.int64)


@dataclass(frozen=True)
class Triangulation:
    """Triangles and lines.

    Attributes
    ----------
    points : (n, 3) float, mm
    triangles : (t, 3) int, into points
    lines : (l, 2) int, into points
    """

    points: Rows
    triangles: Rows
    lines: Rows


NOTHING = Triangulation(NO_POINTS, NO_TRIANGLES, NO_LINES)


def triangulate(shapes: list[cq.Shape], fineness: float = 1.0) -> list[Triangulation]:
    """Triangulate shapes, as finely as the size of them all together asks for.

    Parameters
    ----------
    shapes : list of cadquery.Shape
    fineness : float
        How many times closer than usual they are looked at.
    """
    everything = cq.Compound.makeCompound(shapes)
    parameters = IMeshTools_Parameters()
    parameters.Deflection = DEVIATION * everything.BoundingBox().DiagonalLength / fineness
    parameters.Angle = TURN
    parameters.InParallel = True
    # twice as fast as the other for a face with an engraved address
    parameters.MeshAlgo = IMeshTools_MeshAlgoType.IMeshTools_MeshAlgoType_Delabella
    BRepMesh_IncrementalMesh(everything.wrapped, parameters)
    known: dict[TopoDS_TShape, Triangulation] = {}
    return [_collected(shape, known) for shape in shapes]


def _collected(shape: cq.Shape, known: dict[TopoDS_TShape, Triangulation]) -> Triangulation:
    """Collect what the mesher has left in the faces of a shape, and in edges without a face.

    The same digit is engraved in many panels, so each geometry is read once and placed often.
    """
    points, triangles, lines = [NO_POINTS], [NO_TRIANGLES], [NO_LINES]
    start = 0
    for matrix, together in groupby(_located(shape.wrapped), key=lambda pair: pair[0]):
        here = []
        for _, entity in together:
            geometry = entity.TShape()
            if geometry not in known:
                known[geometry] = _read(entity)
            piece = known[geometry]
            here.append(piece.points)
            triangles.append(piece.triangles + start)
            lines.append(piece.lines + start)
            start += len(piece.points)
        move = np.array(matrix).reshape(3, 4)
        points.append(np.concatenate(here) @ move[:, :3].T + move[:, 3])
    return Triangulation(np.concatenate(points), np.concatenate(triangles), np.concatenate(lines))


def _located(shape: TopoDS_Shape) -> Iterator[tuple[tuple[float, ...], TopoDS_Shape]]:
    """Yield all faces, then the edges without a face, each with the matrix of its place."""
    last: TopLoc_Location | None = None
    matrix: tuple[float, ...] = ()
    for kind, outside in ((FACE, NOWHERE), (EDGE, FACE)):
        explorer = TopExp_Explorer(shape, kind, outside)
        while explorer.More():
            entity = explorer.Current()
            place = entity.Location()
            if last is None or not place.IsEqual(last):  # few of them differ
                last, matrix = place, _matrix(place)
            yield matrix, entity
            explorer.Next()


def _matrix(place: TopLoc_Location) -> tuple[float, ...]:
    move = place.Transformation()
    return tuple(move.Value(i, j) for i in range(1, 4) for j in range(1, 5))


def _read(entity: TopoDS_Shape) -> Triangulation:
    """Read a face with its edges, or an edge, where it is defined and not where it is placed."""
    if entity.ShapeType() == FACE:
        return _read_face(TopoDS.Face_s(entity))
    return _read_edge(TopoDS.Edge_s(entity))


def _read_face(face: TopoDS_Face) -> Triangulation:
    place = TopLoc_Location()
    mesh = BRep_Tool.Triangulation_s(face, place)
    if mesh is None:  # a face without extent
        return NOTHING
    nodes = np.array([mesh.Node(i).Coord() for i in range(1, mesh.NbNodes() + 1)])
    corners = np.array([mesh.Triangle(i).Get() for i in range(1, mesh.NbTriangles() + 1)]) - 1
    is_flat = isinstance(BRep_Tool.Surface_s(face), Geom_Plane)
    lines = _rim(corners) if is_flat else _edges(face, mesh, place)
    return Triangulation(nodes, corners, lines)


def _rim(triangles: Rows) -> Rows:
    """Return the lines that belong to one triangle only."""
    sides = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    keys = sides[:, 0] * (triangles.max() + 1) + sides[:, 1]
    _, first, count = np.unique(keys, return_index=True, return_counts=True)
    return np.asarray(sides[first[count == 1]])


def _edges(face: TopoDS_Face, mesh: Poly_Triangulation, place: TopLoc_Location) -> Rows:
    """Return the lines along the edges of a face that are no seams."""
    lines = [NO_LINES]
    explorer = TopExp_Explorer(face, EDGE)
    while explorer.More():
        edge = TopoDS.Edge_s(explorer.Current())
        if not BRep_Tool.IsClosed_s(edge, face):
            chain = BRep_Tool.PolygonOnTriangulation_s(edge, mesh, place)
            lines.append(_chained([chain.Node(i) - 1 for i in range(1, chain.NbNodes() + 1)]))
        explorer.Next()
    return np.concatenate(lines)


def _read_edge(edge: TopoDS_Edge) -> Triangulation:
    polygon = BRep_Tool.Polygon3D_s(edge, TopLoc_Location())
    if polygon is None:  # an edge without extent
        return NOTHING
    nodes = [polygon.Nodes().Value(i).Coord() for i in range(1, polygon.NbNodes() + 1)]
    return Triangulation(np.array(nodes), NO_TRIANGLES, _chained(range(len(nodes))))


def _chained(along: Sequence[int]) -> Rows:
    """Return the lines from each point of a chain to the next."""
    return np.stack([along[:-1], along[1:]], axis=1).astype(np.int64)
