"""STEP files read back into plain numbers: names, places, faces, edges, and the kernel's opinion.

Nothing here knows what the file should hold. Parts of an assembly keep their own frames, where
numbers are small and planes are level; a placement takes each to where it stands.

Terms
-----
part : a leaf of the assembly tree: solids, or drawn strokes, or something else.
placement : (3, 4) matrix [R | t] that takes a point p of a part to R p + t.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.BRepAlgoAPI import BRepAlgoAPI_Common
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GeomAbs import GeomAbs_Circle, GeomAbs_Cylinder, GeomAbs_Line, GeomAbs_Plane
from OCP.GProp import GProp_GProps
from OCP.IFSelect import IFSelect_RetDone
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.TCollection import TCollection_ExtendedString
from OCP.TColStd import TColStd_SequenceOfAsciiString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_Label, TDF_LabelSequence
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import (
    TopAbs_EDGE,
    TopAbs_FACE,
    TopAbs_FORWARD,
    TopAbs_REVERSED,
    TopAbs_SOLID,
    TopAbs_VERTEX,
)
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Face, TopoDS_Iterator, TopoDS_Shape
from OCP.TopTools import TopTools_IndexedMapOfShape
from OCP.XCAFDoc import XCAFDoc_DocumentTool, XCAFDoc_ShapeTool

from ifs_cad import progress
from ifs_cad.elements.boundary import Boundary, Curves, Surface
from ifs_cad.errors import CheckError
from ifs_cad.kernel.messages import silent
from ifs_cad.types import FloatArray

__all__ = ["Contents", "ReadSolid", "ReadStrokes", "common_volume", "inspect_step"]

MILLIMETRE = "millimetre"
_SEARCHED = 4096  # bytes at either end of the file in which its frame must be
_SCHEMAS = {
    "AUTOMOTIVE_DESIGN": "AP214",
    "AP242": "AP242",
    "CONFIG_CONTROL_DESIGN": "AP203",
    "AP203": "AP203",
}


@dataclass(frozen=True, eq=False)
class ReadSolid:
    """One solid.

    Attributes
    ----------
    name : str
        Of its part; with a number when the part has several solids.
    placement : (3, 4) float
    boundary : Boundary, in the part's own frame
    valid : bool
        What OpenCascade's own check says.
    volume : float
        By OpenCascade's integration, mm3.
    shape : TopoDS_Shape, in place
    """

    name: str
    placement: FloatArray
    boundary: Boundary
    valid: bool
    volume: float
    shape: Any = field(repr=False)


@dataclass(frozen=True, eq=False)
class ReadStrokes:
    """One part that consists of edges only.

    Attributes
    ----------
    name : str
    placement : (3, 4) float
    curves : Curves, in the part's own frame
    """

    name: str
    placement: FloatArray
    curves: Curves


@dataclass(frozen=True, eq=False)
class Contents:
    """What a STEP file holds.

    Attributes
    ----------
    schema : str
        "AP214", "AP242", "AP203", or as the file writes it.
    units : tuple of str
        Of length; "millimetre" alone is as it should be. Numbers here are mm in any case.
    names : tuple of str
        Of all parts.
    solids : tuple of ReadSolid
    strokes : tuple of ReadStrokes
    loose : tuple of str
        Names of the parts with faces that bound no solid.
    """

    schema: str
    units: tuple[str, ...]
    names: tuple[str, ...]
    solids: tuple[ReadSolid, ...]
    strokes: tuple[ReadStrokes, ...]
    loose: tuple[str, ...]


def inspect_step(path: str | os.PathLike[str]) -> Contents:
    """Read a STEP file.

    Raises
    ------
    CheckError
        There is no such file, it is not STEP, it breaks off, or there is no solid in it.
    """
    file = Path(path)
    schema = _schema(file)
    progress.report(f"reading {file.name}")
    with silent():
        reader = STEPCAFControl_Reader()
        reader.SetNameMode(True)
        reader.SetColorMode(False)
        document = TDocStd_Document(TCollection_ExtendedString("check"))
        done = reader.ReadFile(str(file)) == IFSelect_RetDone and reader.Transfer(document)
    if not done:
        raise CheckError(f"{file} cannot be read: it is not valid STEP.")
    parts = list(_parts(XCAFDoc_DocumentTool.ShapeTool_s(document.Main())))
    solids: list[ReadSolid] = []
    strokes: list[ReadStrokes] = []
    loose: list[str] = []
    for done_so_far, (name, shape, location) in enumerate(parts):
        progress.report("checking solids", done_so_far, len(parts))
        bodies = _unique(shape, TopAbs_SOLID)
        for number, body in enumerate(bodies, 1):
            own_name = name if len(bodies) == 1 else f"{name}#{number}"
            solids.append(_solid(own_name, body, location))
        if bodies:
            continue
        if _unique(shape, TopAbs_FACE):
            loose.append(name)
        else:
            strokes.append(ReadStrokes(name, _placement(location), _strokes(shape)))
    progress.report("checking solids", len(parts), len(parts))
    if not solids and not loose:
        raise CheckError(f"There is no solid in {file}: nothing to check.")
    return Contents(
        schema,
        _units(reader),
        tuple(name for name, *_ in parts),
        tuple(solids),
        tuple(strokes),
        tuple(loose),
    )


def common_volume(one: ReadSolid, other: ReadSolid) -> float:
    """Return the volume that two solids of any shape share, mm3, by a boolean operation."""
    common = BRepAlgoAPI_Common(one.shape, other.shape)
    return _volume(common.Shape()) if common.IsDone() else math.nan


def _schema(file: Path) -> str:
    """Return the schema of a STEP file, having looked at both of its ends.

    Raises
    ------
    CheckError
    """
    try:
        size = file.stat().st_size
        with file.open("rb") as stream:
            head = stream.read(_SEARCHED)
            stream.seek(max(0, size - _SEARCHED))
            tail = stream.read()
    except FileNotFoundError as error:
        raise CheckError(f"There is no file {file}.") from error
    except OSError as error:
        raise CheckError(f"{file} cannot be read: {error.strerror}.") from error
    if b"ISO-10303-21" not in head:
        raise CheckError(f"{file} is not a STEP file.")
    if b"END-ISO-10303-21" not in tail:
        raise CheckError(f"{file} breaks off before its end: it was not written completely.")
    found = re.search(rb"FILE_SCHEMA\s*\(\s*\(\s*'\s*([\w]+)", head)
    name = found[1].decode("ascii").upper() if found else "unknown"
    return next((short for long, short in _SCHEMAS.items() if name.startswith(long)), name)


def _units(reader: STEPCAFControl_Reader) -> tuple[str, ...]:
    lengths, angles, solid_angles = (TColStd_SequenceOfAsciiString() for _ in range(3))
    reader.ChangeReader().FileUnits(lengths, angles, solid_angles)
    return tuple(lengths.Value(k).ToCString() for k in range(1, lengths.Length() + 1))


def _parts(tool: XCAFDoc_ShapeTool) -> Iterator[tuple[str, TopoDS_Shape, TopLoc_Location]]:
    """Yield name, shape and location of every part.

    The name is the product's; where several places share a product, it is that of the place.
    """
    free = TDF_LabelSequence()
    tool.GetFreeShapes(free)
    leaves = [
        leaf for k in range(free.Length()) for leaf in _leaves(free.Value(k + 1), TopLoc_Location())
    ]
    uses: dict[str, int] = {}
    for product, *_ in leaves:
        uses[product] = uses.get(product, 0) + 1
    for product, instance, label, location in leaves:
        name = product if uses[product] == 1 and product else instance or product
        yield name, XCAFDoc_ShapeTool.GetShape_s(label), location


def _leaves(
    label: TDF_Label, around: TopLoc_Location
) -> Iterator[tuple[str, str, TDF_Label, TopLoc_Location]]:
    instance = _name(label)
    location = around.Multiplied(XCAFDoc_ShapeTool.GetLocation_s(label))
    product = TDF_Label()
    if not XCAFDoc_ShapeTool.GetReferredShape_s(label, product):
        product = label
    if not XCAFDoc_ShapeTool.IsAssembly_s(product):
        yield _name(product), instance, product, location
        return
    components = TDF_LabelSequence()
    XCAFDoc_ShapeTool.GetComponents_s(product, components)
    for k in range(components.Length()):
        yield from _leaves(components.Value(k + 1), location)


def _name(label: TDF_Label) -> str:
    attribute = TDataStd_Name()
    if not label.FindAttribute(TDataStd_Name.GetID_s(), attribute):
        return ""
    return str(attribute.Get().ToExtString())


def _placement(location: TopLoc_Location) -> FloatArray:
    matrix = location.Transformation()
    return np.array([[matrix.Value(i, j) for j in range(1, 5)] for i in range(1, 4)])


def _solid(name: str, body: TopoDS_Shape, location: TopLoc_Location) -> ReadSolid:
    return ReadSolid(
        name,
        _placement(location),
        _boundary(body),
        BRepCheck_Analyzer(body).IsValid(),
        _volume(body),
        body.Moved(location),
    )


def _volume(shape: TopoDS_Shape) -> float:
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties)
    return float(properties.Mass())


def _unique(shape: TopoDS_Shape, kind: Any) -> list[TopoDS_Shape]:
    """Return the shapes of a kind within another, each once."""
    found = TopTools_IndexedMapOfShape()
    TopExp.MapShapes_s(shape, kind, found)
    return [found.FindKey(k) for k in range(1, found.Extent() + 1)]


def _boundary(body: TopoDS_Shape) -> Boundary:
    vertices, edges, faces = (TopTools_IndexedMapOfShape() for _ in range(3))
    TopExp.MapShapes_s(body, TopAbs_VERTEX, vertices)
    TopExp.MapShapes_s(body, TopAbs_EDGE, edges)
    TopExp.MapShapes_s(body, TopAbs_FACE, faces)
    points = [
        _numbers(BRep_Tool.Pnt_s(TopoDS.Vertex_s(vertices.FindKey(k))))
        for k in range(1, vertices.Extent() + 1)
    ]
    ends = np.empty((edges.Extent(), 2), dtype=np.int64)
    arcs = []
    for k in range(edges.Extent()):
        edge = TopoDS.Edge_s(edges.FindKey(k + 1).Oriented(TopAbs_FORWARD))
        ends[k, 0] = vertices.FindIndex(TopExp.FirstVertex_s(edge)) - 1
        ends[k, 1] = vertices.FindIndex(TopExp.LastVertex_s(edge)) - 1
        arcs.append(_arc(edge))

    used, forward, loops, loop_faces, surfaces = [], [], [], [], []
    for k in range(faces.Extent()):
        face = TopoDS.Face_s(faces.FindKey(k + 1))
        surfaces.append(_surface(face))
        for wire in _children(face):
            # the edges of a wire that is turned round come in the order of the original
            sides = list(_children(wire))
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


def _numbers(triple: Any) -> tuple[float, float, float]:
    return triple.X(), triple.Y(), triple.Z()


_NOWHERE = (math.nan, math.nan, math.nan)
_Arc = tuple[float, tuple[float, float, float], tuple[float, float, float]]
"""Sweep (0 for a line, NaN for other curves), centre and axis."""


def _arc(edge: TopoDS_Edge) -> _Arc:
    if BRep_Tool.Degenerated_s(edge):
        return math.nan, _NOWHERE, _NOWHERE
    curve = BRepAdaptor_Curve(edge)
    kind = curve.GetType()
    if kind == GeomAbs_Line:
        return 0.0, _NOWHERE, _NOWHERE
    if kind != GeomAbs_Circle:
        return math.nan, _NOWHERE, _NOWHERE
    circle = curve.Circle()
    sweep = curve.LastParameter() - curve.FirstParameter()
    return sweep, _numbers(circle.Location()), _numbers(circle.Axis().Direction())


def _surface(
    face: TopoDS_Face,
) -> tuple[Surface, tuple[float, float, float], tuple[float, float, float], float]:
    """Return kind, a point, the outward normal or the axis, and the radius of a face's surface."""
    surface = BRepAdaptor_Surface(face, False)
    kind = surface.GetType()
    if kind == GeomAbs_Plane:
        plane = surface.Plane()
        normal = plane.Axis().Direction()
        if plane.Direct() == (face.Orientation() == TopAbs_REVERSED):
            normal.Reverse()
        return Surface.PLANE, _numbers(plane.Location()), _numbers(normal), 0.0
    if kind == GeomAbs_Cylinder:
        cylinder = surface.Cylinder()
        axis = cylinder.Axis()
        direction = _numbers(axis.Direction())
        return Surface.CYLINDER, _numbers(axis.Location()), direction, cylinder.Radius()
    return Surface.OTHER, _NOWHERE, _NOWHERE, math.nan


def _strokes(shape: TopoDS_Shape) -> Curves:
    edges = TopExp_Explorer(shape, TopAbs_EDGE)
    starts, ends, arcs = [], [], []
    while edges.More():
        edge = TopoDS.Edge_s(edges.Current().Oriented(TopAbs_FORWARD))
        arcs.append(_arc(edge))
        curve = BRepAdaptor_Curve(edge)
        starts.append(_numbers(curve.Value(curve.FirstParameter())))
        ends.append(_numbers(curve.Value(curve.LastParameter())))
        edges.Next()
    sweeps, centres, axes = zip(*arcs, strict=True) if arcs else ((), (), ())
    return Curves(
        np.array(starts).reshape(-1, 3),
        np.array(ends).reshape(-1, 3),
        np.array(sweeps, dtype=float),
        np.array(centres, dtype=float).reshape(-1, 3),
        np.array(axes, dtype=float).reshape(-1, 3),
    )
