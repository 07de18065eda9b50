"""Workpieces as BTLx 2.0.0, the exchange format of timber machines (SEMA, cadwork).

Every workpiece is a part: the smallest box around it whose length runs along the grain, its marked
face on reference side 1, and what is done to it in the order of the paper: drillings, the address
as text, the contour. Coordinates on reference side 1 count from the corner of the box: x along the
length, y along the width, z out of the wood. The part's own axes are x along the length, y into the
wood and z along the width; its transformation tells where they lie in the design.

Contour : the sides that reach the marked face, one closed contour, counter-clockwise. Each line has
    an inclination, degrees, that turns the side from the vertical, right-handed about the line:
    positive where the workpiece is wider at its marked face. Sides that miss that face (of a node
    relief or a floor) follow as contours of a single line, where their plane meets that of the
    face.
Boards : what has square sides along its whole length, as the planks of a vault have. These need no
    cut; every other side is a jack rafter cut: `Angle` between the lower edge of reference side 1
    and the cut, `Inclination` between reference side 1 and the cut, both inside the wood.

All sides of a workpiece are planes that bound it as a convex body, so each may be cut as far as
the tool reaches, and no contour needs an associated one (`DualContour`).

Numbers are written with all digits and without exponents. Neither a date nor a user is written:
the same workpieces make the same file.

Source: section 4.3; BTLx 2.0.0 (design2machine).
"""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from uuid import NAMESPACE_OID, uuid5

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.elements.glyph import bar, descent, text_positions
from ifs_cad.errors import ExportError, InputError
from ifs_cad.fabrication.cutlist import require_unique
from ifs_cad.fabrication.measure import mass, side_edges
from ifs_cad.fabrication.workpiece import Drill, Engraving, Side, Workpiece
from ifs_cad.files import replaced
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import FloatArray

VERSION = "2.0.0"
NAMESPACE = "https://www.design2machine.com"

LARGEST_INCLINATION = 89.9
"""Of a side to the vertical, degrees."""

SHARPEST = 0.1
"""Least angle of a jack rafter cut to an edge, degrees."""

LARGEST_BLANK = (100_000.0, 50_000.0, 50_000.0)
"""Length, width and thickness, mm."""

_MARKED_SIDE = "1"
_ROOT = {
    "xmlns": NAMESPACE,
    "xmlns:xsi": "http://www.w3.org/2001/XMLSchema-instance",
    "xsi:schemaLocation": f"{NAMESPACE} {NAMESPACE}/btlx/btlx_2_0_0.xsd",
    "Version": VERSION,
    "Language": "en",
}


def export_btlx(
    workpieces: Sequence[Workpiece],
    path: str | os.PathLike[str],
    *,
    name: str = "ifs_cad",
    tol: Tolerance = DEFAULT,
) -> Path:
    """Write workpieces as the parts of a BTLx project.

    Parameters
    ----------
    workpieces : sequence of Workpiece
    path : path of the file; its folder is made when missing
    name : str
        Of the project; with the address it makes the GUID of a part.
    tol : Tolerance

    Returns
    -------
    Path of the written file.

    Raises
    ------
    InputError
        No workpiece, or two with one address.
    ExportError
        A side flatter or a workpiece larger than the format allows, or a file that could not be
        written; what stood there before is unchanged.
    """
    if not workpieces:
        raise InputError("There is no workpiece to write: a BTLx project needs a part.")
    require_unique(workpieces)
    _require_steep(workpieces)
    root = ET.Element("BTLx", _ROOT)
    ET.SubElement(ET.SubElement(root, "FileHistory"), "InitialExportProgram", ProgramName="ifs_cad")
    project = ET.SubElement(root, "Project", Name=name)
    parts = ET.SubElement(project, "Parts")
    for number, workpiece in enumerate(workpieces, start=1):
        parts.append(_part(number, workpiece, name, tol))
    ET.indent(root)
    target = Path(path)
    with replaced(target) as scratch:
        ET.ElementTree(root).write(scratch, encoding="us-ascii", xml_declaration=True)
    return target


def _require_steep(workpieces: Sequence[Workpiece]) -> None:
    for workpiece in workpieces:
        for number, side in enumerate(workpiece.sides, start=1):
            if abs(side.inclination) > LARGEST_INCLINATION:
                raise ExportError(
                    f"Edge {number} of {workpiece.address} lies {side.inclination:.2f} degrees "
                    f"from the vertical; BTLx allows {LARGEST_INCLINATION}. Change the fold or "
                    "the floor there.",
                    addresses=(workpiece.address,),
                )


@dataclass(frozen=True, eq=False)
class _Blank:
    """The box around a workpiece whose length runs along the grain.

    Attributes
    ----------
    axes : (2, 2) float, rows length and width as directions on the machine
    low : (2,) float, lower left corner along these axes, mm
    size : (3,) float, length, width and thickness, mm
    """

    axes: FloatArray
    low: FloatArray
    size: FloatArray

    @staticmethod
    def around(workpiece: Workpiece, tol: Tolerance) -> _Blank:
        """Return the blank of a workpiece; it lies as on the machine where the grain is free."""
        along = np.array([1.0, 0.0])
        if workpiece.fibre is not None and abs(workpiece.fibre[1]) > tol.parallel:
            along = workpiece.fibre * np.copysign(1.0, workpiece.fibre[0])  # text stays upright
        axes = np.array([along, (-along[1], along[0])])
        turned = workpiece.silhouette @ axes.T
        low = turned.min(axis=0)
        size = np.append(turned.max(axis=0) - low, workpiece.thickness)
        if (size > LARGEST_BLANK).any():
            raise ExportError(
                f"{listed([workpiece.address])} needs a blank of {size[0]:.0f} x {size[1]:.0f} x "
                f"{size[2]:.0f} mm, more than BTLx allows. Divide it.",
                addresses=(workpiece.address,),
            )
        return _Blank(axes, low, size)

    def on_side(self, points: FloatArray) -> FloatArray:
        """Return (..., 2) or (..., 3) points of the machine on reference side 1."""
        placed = np.array(points)
        placed[..., :2] = placed[..., :2] @ self.axes.T - self.low
        placed[..., 2:] -= self.size[2]
        return placed

    def turned(self, vector: FloatArray) -> FloatArray:
        """Return a (3,) direction on the machine along the axes of reference side 1."""
        return np.append(self.axes @ vector[:2], vector[2])


def _part(number: int, workpiece: Workpiece, project: str, tol: Tolerance) -> ET.Element:
    blank = _Blank.around(workpiece, tol)
    cuts = _board_cuts(workpiece, blank, tol)
    length, width, height = (_number(size) for size in blank.size)
    part = ET.Element(
        "Part",
        SingleMemberNumber=str(number),
        OrderNumber=str(number),
        Designation="Plate" if cuts is None else "Beam",
        Annotation=workpiece.address,
        ElementNumber=workpiece.address,
        Material=workpiece.material.name,
        Count="1",
        Length=length,
        Height=height,
        Width=width,
        Weight=_number(mass(workpiece)),
    )
    part.append(_transformations(workpiece, blank, project))
    if workpiece.fibre is not None:
        ET.SubElement(part, "GrainDirection", X="1", Y="0", Z="0", Align="yes")
    ET.SubElement(part, "ReferenceSide", Side=_MARKED_SIDE, Align="yes")
    processings = ET.SubElement(part, "Processings")
    for drill in workpiece.drills:
        processings.extend(_drillings(drill, workpiece, blank))
    if workpiece.engraving is not None:
        processings.append(_text(workpiece.engraving, blank))
    processings.extend(_contours(workpiece, blank, tol) if cuts is None else cuts)
    for identifier, processing in enumerate(processings, start=1):
        processing.set("ProcessID", str(identifier))
    return part


def _transformations(workpiece: Workpiece, blank: _Blank, project: str) -> ET.Element:
    """Return where the part's corner and axes lie in the design."""
    corner = np.append(blank.low @ blank.axes, workpiece.thickness)
    guid = str(uuid5(NAMESPACE_OID, f"{project}/{workpiece.address}")).upper()
    element = ET.Element("Transformations")
    transformation = ET.SubElement(element, "Transformation", GUID=f"{{{guid}}}")
    position = ET.SubElement(transformation, "Position")
    for tag, values in (
        ("ReferencePoint", corner @ workpiece.axes + workpiece.origin),
        ("XVector", blank.axes[0] @ workpiece.axes[:2]),
        ("YVector", -workpiece.axes[2]),
    ):
        position.append(_coordinates(tag, values))
    return element


def _drillings(drill: Drill, workpiece: Workpiece, blank: _Blank) -> Iterator[ET.Element]:
    blind = drill.depth < workpiece.thickness
    for x, y in blank.on_side(drill.points).tolist():
        yield _processing(
            "Drilling",
            StartX=x,
            StartY=y,
            Angle=0.0,
            Inclination=90.0,
            DepthLimited="yes" if blind else "no",
            Depth=drill.depth,
            Diameter=drill.diameter,
        )


def _text(engraving: Engraving, blank: _Blank) -> ET.Element:
    """Return the address where it is engraved: the bar under it tells how high and where."""
    _, width = text_positions(engraving.text)
    drawn = bar(width, descent(engraving.text)).vertices
    placed = engraving.strokes[-1].vertices
    height = np.ptp(placed[:, 0]) / np.ptp(drawn[:, 0])
    start = blank.on_side(placed[0] - height * drawn[0])
    return _processing(
        "Text",
        StartX=start[0],
        StartY=start[1],
        Angle=np.degrees(np.arctan2(blank.axes[1, 0], blank.axes[0, 0])),
        AlignmentVertical="bottom",
        AlignmentHorizontal="left",
        AlignmentMultiline="left",
        StackedMarking="no",
        TextHeightAuto="no",
        TextHeight=height,
        Text=engraving.text,
    )


def _board_cuts(workpiece: Workpiece, blank: _Blank, tol: Tolerance) -> list[ET.Element] | None:
    """Return the jack rafter cuts of a board; None where the workpiece is none. See the module."""
    if workpiece.fibre is None:
        return None
    normals = np.array([blank.turned(side.normal) for side in workpiece.sides])
    lengthwise = np.abs(normals[:, 0]) <= tol.parallel
    kept = normals[lengthwise]
    opposite = len(kept) == 2 and kept[:, 1].prod() < 0.0
    if not (opposite and np.abs(kept[:, 2]).max() <= tol.parallel):
        return None
    cuts = []
    for side, normal in zip(workpiece.sides, normals, strict=True):
        if abs(normal[0]) <= tol.parallel:
            continue
        angle = float(np.degrees(np.arctan2(abs(normal[0]), normal[1])))
        inclination = float(np.degrees(np.arccos(-normal[2])))
        start = float(normal @ blank.on_side(side.corners[0]) / normal[0])
        if min(angle, 180.0 - angle) < SHARPEST or abs(start) > LARGEST_BLANK[0]:
            return None
        cuts.append(
            _processing(
                "JackRafterCut",
                title=_title(side),
                Orientation="start" if normal[0] < 0.0 else "end",
                StartX=start,
                StartY=0.0,
                StartDepth=0.0,
                Angle=angle,
                Inclination=inclination,
            )
        )
    return cuts


def _contours(workpiece: Workpiece, blank: _Blank, tol: Tolerance) -> Iterator[ET.Element]:
    """Yield the closed contour of the marked face, then the lines of sides that miss the face."""
    edges = side_edges(workpiece, tol=tol)
    # a floor may leave nothing of the face but a line
    reaching = (edges.upper_lengths > tol.planar) & (len(workpiece.upper) > 0)
    around = [side for side, reaches in zip(workpiece.sides, reaching, strict=True) if reaches]
    if around:
        ring = edges.upper[reaching, 0]
        yield _contour("contour", np.append(ring, ring[:1], axis=0), around, workpiece, blank)
    for side, reaches in zip(workpiece.sides, reaching, strict=True):
        if not reaches:
            yield _contour(_title(side), _trace(side, workpiece), [side], workpiece, blank)


def _trace(side: Side, workpiece: Workpiece) -> FloatArray:
    """Return the (2, 2) line, as long as a side, where its plane meets that of the marked face."""
    outward = side.normal[:2]
    below = side.corners[0, 2] - workpiece.thickness
    reach = (side.corners[0, :2] @ outward + below * side.normal[2]) / (outward @ outward)
    along = side.travel[:2]
    beside = side.corners[:, :2] @ along
    return np.asarray(reach * outward + np.array([[beside.min()], [beside.max()]]) * along)


def _contour(
    title: str, points: FloatArray, sides: Sequence[Side], workpiece: Workpiece, blank: _Blank
) -> ET.Element:
    """Return lines through (k + 1, 2) points, one for each of k sides, the wood on their left."""
    element = _processing("FreeContour", title=title)
    element.attrib |= {"CounterSink": "no", "ToolPosition": "right"}
    contour = ET.SubElement(
        element, "Contour", DepthBounded="yes", Depth=_number(workpiece.thickness)
    )
    start, *ends = np.column_stack([blank.on_side(points), np.zeros(len(points))])
    contour.append(_coordinates("StartPoint", start))
    for side, end in zip(sides, ends, strict=True):
        line = ET.SubElement(contour, "Line", Inclination=_number(side.inclination))
        line.append(_coordinates("EndPoint", end))
    return element


def _title(side: Side) -> str:
    return f"{side.kind} {side.neighbour}".strip()


def _processing(tag: str, *, title: str | None = None, **values: float | str) -> ET.Element:
    """Return a processing on the marked face with its values as children."""
    element = ET.Element(tag, Name=title or tag, Process="yes", ReferencePlaneID=_MARKED_SIDE)
    for name, value in values.items():
        ET.SubElement(element, name).text = value if isinstance(value, str) else _number(value)
    return element


def _coordinates(tag: str, values: FloatArray) -> ET.Element:
    return ET.Element(tag, dict(zip("XYZ", (_number(value) for value in values), strict=True)))


def _number(value: float) -> str:
    """Return all digits of a number, without exponent and without a negative zero."""
    return np.format_float_positional(value + 0.0, trim="0")
