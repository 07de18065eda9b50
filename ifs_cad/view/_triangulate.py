"""Shapes as triangles and lines, for `render`.

A point belongs to one face only, so whoever averages normals over the triangles at a point gets
smooth faces and crisp edges. An edge comes with each of its faces, the seam of a round face not at
all. Edges without a face come too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import cadquery as cq
import numpy as np
from numpy.typing import NDArray
from OCP.BRep import BRep_Tool
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_TShape

DEVIATION = 1e-4  # of a chord from its curve, share of the model's size
TURN = 0.5  # radians between chords of a curve

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


def triangulate(shapes: list[cq.Shape]) -> list[Triangulation]:
    """Triangulate shapes, as finely as the size of them all together asks for."""
    everything = cq.Compound.makeCompound(shapes)
    deviation = DEVIATION * everything.BoundingBox().DiagonalLength
    BRepMesh_IncrementalMesh(everything.wrapped, deviation, False, TURN, True)
    known: dict[TopoDS_TShape, Triangulation] = {}
    return [_collected(shape, known) for shape in shapes]


def _collected(shape: cq.Shape, known: dict[TopoDS_TShape, Triangulation]) -> Triangulation:
    """Collect what the mesher has left in the faces of a shape, and in edges without a face.

    The same digit is engraved in many panels, so each geometry is read once and placed often.
    """
    points, triangles, lines = [NO_POINTS], [NO_TRIANGLES], [NO_LINES]
    start = 0
    for entity in [*shape.Faces(), *_edges_without_face(shape)]:
        geometry = entity.wrapped.TShape()
        if geometry not in known:
            known[geometry] = (
                _read_face(entity) if isinstance(entity, cq.Face) else _read_edge(entity)
            )
        piece = known[geometry]
        points.append(_placed(piece.points, entity.wrapped.Location()))
        triangles.append(piece.triangles + start)
        lines.append(piece.lines + start)
        start += len(piece.points)
    return Triangulation(np.concatenate(points), np.concatenate(triangles), np.concatenate(lines))


def _edges_without_face(shape: cq.Shape) -> Iterator[cq.Shape]:
    edge, face = TopAbs_ShapeEnum.TopAbs_EDGE, TopAbs_ShapeEnum.TopAbs_FACE
    explorer = TopExp_Explorer(shape.wrapped, edge, face)
    while explorer.More():
        yield cq.Edge(TopoDS.Edge_s(explorer.Current()))
        explorer.Next()


def _read_face(face: cq.Shape) -> Triangulation:
    """Read a face with its edges, where its geometry is defined and not where it is placed."""
    location = TopLoc_Location()
    mesh = BRep_Tool.Triangulation_s(face.wrapped, location)
    if mesh is None:  # a face without extent
        return NOTHING
    nodes = [mesh.Node(i).Coord() for i in range(1, mesh.NbNodes() + 1)]
    corners = [mesh.Triangle(i).Get() for i in range(1, mesh.NbTriangles() + 1)]
    lines = [NO_LINES]
    for edge in face.Edges():
        if not BRep_Tool.IsClosed_s(edge.wrapped, face.wrapped):
            chain = BRep_Tool.PolygonOnTriangulation_s(edge.wrapped, mesh, location)
            lines.append(_chained([chain.Node(i) - 1 for i in range(1, chain.NbNodes() + 1)]))
    return Triangulation(np.array(nodes), np.array(corners) - 1, np.concatenate(lines))


def _read_edge(edge: cq.Shape) -> Triangulation:
    polygon = BRep_Tool.Polygon3D_s(edge.wrapped, TopLoc_Location())
    if polygon is None:  # an edge without extent
        return NOTHING
    nodes = [polygon.Nodes().Value(i).Coord() for i in range(1, polygon.NbNodes() + 1)]
    return Triangulation(np.array(nodes), NO_TRIANGLES, _chained(range(len(nodes))))


def _chained(along: Sequence[int]) -> Rows:
    """Return the lines from each point of a chain to the next."""
    return np.stack([along[:-1], along[1:]], axis=1).astype(np.int64)


def _placed(points: Rows, location: TopLoc_Location) -> Rows:
    move = location.Transformation()
    matrix = np.array([[move.Value(i, j) for j in range(1, 5)] for i in range(1, 4)])
    moved: Rows = points @ matrix[:, :3].T + matrix[:, 3]
    return moved
