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
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from OCP.Bnd import Bnd_Box
from OCP.BRepAlgoAPI import BRepAlgoAPI_Common
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.IFSelect import IFSelect_RetDone
from OCP.Standard import Standard_Failure
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.TCollection import TCollection_ExtendedString
from OCP.TColStd import TColStd_SequenceOfAsciiString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_Label, TDF_LabelSequence
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_SOLID
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Shape
from OCP.XCAFDoc import XCAFDoc_DocumentTool, XCAFDoc_ShapeTool

from ifs_cad import progress
from ifs_cad.elements.boundary import Boundary, Curves
from ifs_cad.errors import CheckError
from ifs_cad.kernel.boundary import boundary_of, curves_of, numbers, subshapes
from ifs_cad.kernel.messages import silent
from ifs_cad.types import FloatArray

__all__ = [
    "MILLIMETRE",
    "Contents",
    "ReadSolid",
    "ReadStrokes",
    "bounding_box",
    "common_volume",
    "inspect_step",
]

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
    part : str
        Name of its part.
    name : str
        The same, with a number when the part has several solids.
    placement : (3, 4) float
    boundary : Boundary, in the part's own frame
    valid : bool
        What OpenCascade's own check says.
    volume : float
        By OpenCascade's integration, mm3.
    shape : TopoDS_Shape, in place
    """

    part: str
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
        Names of the parts with faces that bound no solid, or with nothing at all.
    complaints : tuple of str
        What the reader could not make sense of, in its words.
    """

    schema: str
    units: tuple[str, ...]
    names: tuple[str, ...]
    solids: tuple[ReadSolid, ...]
    strokes: tuple[ReadStrokes, ...]
    loose: tuple[str, ...]
    complaints: tuple[str, ...]


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
    reader, document = _read(file)
    parts = list(_parts(XCAFDoc_DocumentTool.ShapeTool_s(document.Main())))
    solids: list[ReadSolid] = []
    strokes: list[ReadStrokes] = []
    loose: list[str] = []
    for done, (name, shape, location) in enumerate(parts, 1):
        bodies = subshapes(shape, TopAbs_SOLID)
        for number, body in enumerate(bodies, 1):
            own_name = name if len(bodies) == 1 else f"{name}#{number}"
            solids.append(_solid(name, own_name, body, location))
        if not bodies:
            if subshapes(shape, TopAbs_FACE) or not subshapes(shape, TopAbs_EDGE):
                loose.append(name)
            else:
                strokes.append(ReadStrokes(name, _placement(location), curves_of(shape)))
        progress.report("checking solids", done, len(parts))
    if not solids and not loose:
        raise CheckError(f"There is no solid in {file}: nothing to check.")
    return Contents(
        schema,
        _units(reader),
        tuple(name for name, *_ in parts),
        tuple(solids),
        tuple(strokes),
        tuple(loose),
        _complaints(reader),
    )


def common_volume(one: ReadSolid, other: ReadSolid) -> float:
    """Return the volume that two solids of any shape share, mm3, by a boolean operation.

    NaN when the operation fails.
    """
    try:
        common = BRepAlgoAPI_Common(one.shape, other.shape)
        return _volume(common.Shape()) if common.IsDone() else math.nan
    except Standard_Failure:
        return math.nan


def bounding_box(solid: ReadSolid) -> FloatArray:
    """Return the (2, 3) lower and upper corners of a box around a solid of any shape, mm."""
    box = Bnd_Box()
    BRepBndLib.Add_s(solid.shape, box, False)
    return np.array([numbers(box.CornerMin()), numbers(box.CornerMax())])


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


def _read(file: Path) -> tuple[STEPCAFControl_Reader, TDocStd_Document]:
    """Read a file with its names.

    Raises
    ------
    CheckError
    """
    reader = STEPCAFControl_Reader()
    reader.SetNameMode(True)
    reader.SetColorMode(False)
    document = TDocStd_Document(TCollection_ExtendedString("check"))
    try:
        with silent():
            done = reader.ReadFile(str(file)) == IFSelect_RetDone and reader.Transfer(document)
    except Standard_Failure as error:
        raise CheckError(f"{file} cannot be read: {error}.") from error
    if not done:
        raise CheckError(f"{file} cannot be read: it is not valid STEP.")
    return reader, document


def _units(reader: STEPCAFControl_Reader) -> tuple[str, ...]:
    lengths, angles, solid_angles = (TColStd_SequenceOfAsciiString() for _ in range(3))
    reader.ChangeReader().FileUnits(lengths, angles, solid_angles)
    return tuple(lengths.Value(k).ToCString() for k in range(1, lengths.Length() + 1))


def _complaints(reader: STEPCAFControl_Reader) -> tuple[str, ...]:
    """Return what is wrong with the text: syntax, and references to what is not there."""
    check = reader.ChangeReader().StepModel().GlobalCheck()
    return tuple(str(check.CFail(k)) for k in range(1, check.NbFails() + 1))


def _parts(tool: XCAFDoc_ShapeTool) -> Iterator[tuple[str, TopoDS_Shape, TopLoc_Location]]:
    """Yield name, shape and location of every part.

    The name is the product's; where several places share a product, it is that of the place.
    """
    free = TDF_LabelSequence()
    tool.GetFreeShapes(free)
    leaves = [
        leaf for k in range(free.Length()) for leaf in _leaves(free.Value(k + 1), TopLoc_Location())
    ]
    uses = Counter(product.Tag() for _, product, _ in leaves)
    for instance, product, location in leaves:
        own = _name(product)
        name = own if own and uses[product.Tag()] == 1 else instance
        yield name, XCAFDoc_ShapeTool.GetShape_s(product), location


def _leaves(
    label: TDF_Label, around: TopLoc_Location
) -> Iterator[tuple[str, TDF_Label, TopLoc_Location]]:
    """Yield the name of each place below a label, the product there, and its location."""
    instance = _name(label)
    location = around.Multiplied(XCAFDoc_ShapeTool.GetLocation_s(label))
    product = TDF_Label()
    if not XCAFDoc_ShapeTool.GetReferredShape_s(label, product):
        product = label
    if not XCAFDoc_ShapeTool.IsAssembly_s(product):
        yield instance, product, location
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


def _solid(part: str, name: str, body: TopoDS_Shape, location: TopLoc_Location) -> ReadSolid:
    return ReadSolid(
        part,
        name,
        _placement(location),
        boundary_of(body),
        BRepCheck_Analyzer(body).IsValid(),
        _volume(body),
        body.Moved(location),
    )


def _volume(shape: TopoDS_Shape) -> float:
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties)
    return float(properties.Mass())
