"""Exact OpenCascade solids, built directly from the faces that are already known.

No booleans: every face of a panel is a plane whose corners and edges the arrays give, so the
boundary representation is put together from shared vertices and edges. Pockets and holes bring
their own walls; their rims become inner wires of the panel's faces, with the same edges.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from OCP.BRep import BRep_Builder
from OCP.Geom import Geom_Line, Geom_Plane
from OCP.gp import gp_Ax3, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec
from OCP.TopAbs import TopAbs_FORWARD, TopAbs_REVERSED
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import (
    TopoDS_Edge,
    TopoDS_Face,
    TopoDS_Shape,
    TopoDS_Shell,
    TopoDS_Solid,
    TopoDS_Vertex,
    TopoDS_Wire,
)

from ifs_cad.elements.polyhedron import Kind, Polyhedra
from ifs_cad.tolerance import KERNEL
from ifs_cad.types import FloatArray


@dataclass(frozen=True)
class Inset:
    """What is cut into a face without touching its outline.

    Attributes
    ----------
    rims : for each kind of panel face, the wires that bound it from inside
    faces : the walls, floors and islands
    volume : float, what is removed, mm3
    """

    rims: dict[Kind, Sequence[TopoDS_Shape]]
    faces: Sequence[TopoDS_Shape]
    volume: float

    def moved(self, place: TopLoc_Location) -> Inset:
        """Return the inset in place; rims and walls keep sharing their edges."""
        return Inset(
            {kind: [rim.Moved(place) for rim in rims] for kind, rims in self.rims.items()},
            [face.Moved(place) for face in self.faces],
            self.volume,
        )


def location(axes: FloatArray, origin: FloatArray) -> TopLoc_Location:
    """Return the location that takes x, y and z to the rows of `axes`, at `origin`."""
    transformation = gp_Trsf()
    x, y, z = axes.tolist()
    a, b, c = origin.tolist()
    transformation.SetValues(x[0], y[0], z[0], a, x[1], y[1], z[1], b, x[2], y[2], z[2], c)
    return TopLoc_Location(transformation)


def shift(x: float, y: float, z: float) -> TopLoc_Location:
    """Return the location that moves by (x, y, z), mm."""
    transformation = gp_Trsf()
    transformation.SetTranslation(gp_Vec(x, y, z))
    return TopLoc_Location(transformation)


def build_solid(solids: Polyhedra, index: int, insets: Iterable[Inset] = ()) -> TopoDS_Solid:
    """Build one polyhedron with its insets as a closed, outward-oriented solid.

    Parameters
    ----------
    solids : Polyhedra
    index : int, which of them
    insets : Insets, already in place
    """
    builder = BRep_Builder()
    insets = tuple(insets)
    first, last = solids.solid_offsets[index : index + 2].tolist()
    bounds = solids.face_offsets[first : last + 1].tolist()
    loops = solids.loops[bounds[0] : bounds[-1]].tolist()
    numbers = sorted(set(loops))
    points = dict(zip(numbers, solids.vertices[numbers].tolist(), strict=True))
    vertices = {}
    for number, point in points.items():
        vertex = TopoDS_Vertex()
        builder.MakeVertex(vertex, gp_Pnt(*point), KERNEL)
        vertices[number] = vertex

    shell = TopoDS_Shell()
    builder.MakeShell(shell)
    edges: dict[tuple[int, int], TopoDS_Edge] = {}
    normals = solids.normals[first:last].tolist()
    kinds = solids.kinds[first:last].tolist()
    for k, (normal, kind) in enumerate(zip(normals, kinds, strict=True)):
        ring = loops[bounds[k] - bounds[0] : bounds[k + 1] - bounds[0]]
        wire = TopoDS_Wire()
        builder.MakeWire(wire)
        for start, end in zip(ring, ring[1:] + ring[:1], strict=True):
            if (end, start) in edges:
                builder.Add(wire, edges[end, start].Reversed())
                continue
            edge = _edge(builder, vertices[start], vertices[end], points[start], points[end])
            edges[start, end] = edge
            builder.Add(wire, edge)
        wire.Closed(True)
        face = TopoDS_Face()
        plane = Geom_Plane(gp_Ax3(gp_Pnt(*points[ring[0]]), gp_Dir(*normal)))
        builder.MakeFace(face, plane, KERNEL)
        builder.Add(face, wire)
        for inset in insets:
            for rim in inset.rims.get(Kind(kind), ()):
                builder.Add(face, rim)
        builder.Add(shell, face)
    for inset in insets:
        for part in inset.faces:
            builder.Add(shell, part)
    shell.Closed(True)
    solid = TopoDS_Solid()
    builder.MakeSolid(solid)
    builder.Add(solid, shell)
    return solid


def _edge(
    builder: BRep_Builder,
    start: TopoDS_Vertex,
    end: TopoDS_Vertex,
    start_point: list[float],
    end_point: list[float],
) -> TopoDS_Edge:
    along = [b - a for a, b in zip(start_point, end_point, strict=True)]
    edge = TopoDS_Edge()
    builder.MakeEdge(edge, Geom_Line(gp_Pnt(*start_point), gp_Dir(*along)), KERNEL)
    builder.Add(edge, start.Oriented(TopAbs_FORWARD))
    builder.Add(edge, end.Oriented(TopAbs_REVERSED))
    builder.Range(edge, 0.0, sum(part * part for part in along) ** 0.5)
    return edge
