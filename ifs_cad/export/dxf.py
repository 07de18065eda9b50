"""Nested sheets and single workpieces as DXF drawings, for CAM, CAD and laser cutters.

Millimetres, seen from above, the origin at the lower left corner of the sheet or of the workpiece.
Everything is flat, at z = 0; what kind of thing an entity is, its layer says:

SHEET : the raw sheet, a closed polyline.
OUTLINE_TOP, OUTLINE_BOTTOM : the outlines at z = thickness and z = 0, closed polylines.
HOLES : circles.
ENGRAVING : the strokes of the address, polylines with arcs; points where the cutter only plunges.
FIBRE : an arrow along the grain, a polyline that starts with the tail and the tip.
TEXT : the address, once for each workpiece.
ANGLES : the inclination of each side of the contour, along the side: degrees to the vertical,
    positive where the workpiece is wider at its top.
OFFCUTS : what of the sheet is worth keeping, closed polylines.

Texts are for people: an angle is rounded to a tenth. For programs, each entity of a workpiece
carries extended data of the application IFS_CAD: the address (group code 1000), then pairs of a
name (1000) and a value in full precision (1040 for numbers, 1000 for words):

OUTLINE_TOP, OUTLINE_BOTTOM : z, mm above the table
HOLES : depth, mm
ENGRAVING : depth and cutter (its diameter), mm
ANGLES : inclination, degrees; kind; neighbour, empty at borders and floors

Source: section 4.3, figure 19.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from ezdxf.document import Drawing
from ezdxf.entities.dxfgfx import DXFGraphic
from ezdxf.enums import TextEntityAlignment
from ezdxf.filemanagement import new
from ezdxf.layouts.layout import Modelspace
from ezdxf.units import MM

from ifs_cad.design.address import listed
from ifs_cad.elements import arcs
from ifs_cad.errors import InputError
from ifs_cad.fabrication.layout import NestedSheet, Placement
from ifs_cad.fabrication.workpiece import Side, Workpiece
from ifs_cad.files import replaced
from ifs_cad.types import FloatArray

APPLICATION = "IFS_CAD"
"""The name under which entities carry extended data."""

COLOURS = {
    "SHEET": 8,
    "OUTLINE_TOP": 1,
    "OUTLINE_BOTTOM": 5,
    "HOLES": 3,
    "ENGRAVING": 6,
    "FIBRE": 30,
    "TEXT": 7,
    "ANGLES": 4,
    "OFFCUTS": 9,
}
"""The layers and their colours, numbers of the AutoCAD Color Index."""

TEXT_HEIGHT = 6.0
ANGLE_HEIGHT = 4.0
"""Cap heights, mm."""

ARROW_SHARE = 0.15
"""Length of a fibre arrow as a share of the workpiece's length along the grain."""

ARROW_HEAD = 0.2
"""Length of its head as a share of its own; the head is half as wide to either side."""

_VERSION = "R2010"  # the first of the versions in use that keeps text as UTF-8 everywhere


def export_dxf(
    sheet: NestedSheet, workpieces: Mapping[str, Workpiece], path: str | os.PathLike[str]
) -> Path:
    """Draw one sheet with all that is cut from it.

    Parameters
    ----------
    sheet : NestedSheet
    workpieces : Mapping of address to Workpiece, at least of those on the sheet
    path : path of the file; its folder is made when missing

    Returns
    -------
    Path of the written file.

    Raises
    ------
    InputError
        A workpiece on the sheet is not among those given.
    ExportError
        The file could not be written; what stood there before is unchanged.
    """
    missing = [place.address for place in sheet.placements if place.address not in workpieces]
    if missing:
        raise InputError(
            f"{sheet.name} holds {listed(missing)}, but these are not among the workpieces. Draw "
            "a layout with the workpieces that it was made for.",
            addresses=missing,
        )
    size = np.array([sheet.stock.length, sheet.stock.width])
    document, space = _blank(size)
    _outline(space, "SHEET", _rectangle(np.zeros(2), size))
    for offcut in sheet.offcuts:
        _outline(space, "OFFCUTS", _rectangle(offcut[:2], offcut[2:]))
    for placement in sheet.placements:
        _draw(space, workpieces[placement.address], placement)
    return _written(document, path)


def export_workpiece_dxf(workpiece: Workpiece, path: str | os.PathLike[str]) -> Path:
    """Draw one workpiece alone, its corner at the origin.

    Raises
    ------
    ExportError
        The file could not be written; what stood there before is unchanged.
    """
    document, space = _blank(workpiece.silhouette.max(axis=0))
    _draw(space, workpiece, Placement(workpiece.address, 0.0, 0.0, 0.0))
    return _written(document, path)


def _blank(size: FloatArray) -> tuple[Drawing, Modelspace]:
    """Return a drawing with the layers, opened with (2,) `size` from the origin in view."""
    document = new(_VERSION, units=MM)
    document.header["$MEASUREMENT"] = 1  # metric patterns, as the units are
    document.appids.add(APPLICATION)
    for name, colour in COLOURS.items():
        document.layers.add(name, color=colour)
    length, width = size.tolist()
    document.set_modelspace_vport(height=1.1 * max(length, width), center=(length / 2, width / 2))
    return document, document.modelspace()


def _written(document: Drawing, path: str | os.PathLike[str]) -> Path:
    target = Path(path)
    with replaced(target) as scratch:
        document.saveas(scratch)
    return target


def _draw(space: Modelspace, workpiece: Workpiece, placement: Placement) -> None:
    """Draw a workpiece where it lies."""
    address = workpiece.address
    for layer, outline, z in (
        ("OUTLINE_TOP", workpiece.upper, workpiece.thickness),
        ("OUTLINE_BOTTOM", workpiece.lower, 0.0),
    ):
        if len(outline):  # a floor may leave nothing of one face
            _tag(_outline(space, layer, placement(outline)), address, z=z)
    for drill in workpiece.drills:
        for point in placement(drill.points).tolist():
            circle = space.add_circle(point, drill.diameter / 2, {"layer": "HOLES"})
            _tag(circle, address, depth=drill.depth)
    if workpiece.engraving is not None:
        cut = {"depth": workpiece.engraving.depth, "cutter": workpiece.engraving.cutter}
        for stroke in workpiece.engraving.strokes:
            _tag(_stroke(space, stroke, placement), address, **cut)
    if workpiece.fibre is not None:
        arrow = placement(_arrow(workpiece, workpiece.fibre))
        entity = space.add_lwpolyline(arrow.tolist(), dxfattribs={"layer": "FIBRE"})
        _tag(entity, address)
    _tag(_text(space, workpiece, placement), address)
    for side in workpiece.sides:
        angle = _angle(space, side, placement)
        told = {"kind": side.kind, "neighbour": side.neighbour}
        _tag(angle, address, inclination=side.inclination, **told)


def _tag(entity: DXFGraphic, address: str, **values: float | str) -> None:
    """Let an entity carry its address and values for programs."""
    data: list[tuple[int, float | str]] = [(1000, address)]
    for name, value in values.items():
        data += [(1000, name), (1000, value) if isinstance(value, str) else (1040, float(value))]
    entity.set_xdata(APPLICATION, data)


def _outline(space: Modelspace, layer: str, points: FloatArray) -> DXFGraphic:
    return space.add_lwpolyline(points.tolist(), close=True, dxfattribs={"layer": layer})


def _stroke(space: Modelspace, stroke: arcs.Path, placement: Placement) -> DXFGraphic:
    vertices = placement(stroke.vertices)
    if len(vertices) == 1:
        return space.add_point(vertices[0].tolist(), {"layer": "ENGRAVING"})
    bulges = np.append(stroke.bulges, np.zeros(len(vertices) - len(stroke.bulges)))
    return space.add_lwpolyline(
        np.column_stack([vertices, bulges]).tolist(),
        format="xyb",
        close=stroke.closed,
        dxfattribs={"layer": "ENGRAVING"},
    )


def _text(space: Modelspace, workpiece: Workpiece, placement: Placement) -> DXFGraphic:
    """Write the address under the engraving, or in the middle where there is none."""
    spot, align = _middles(workpiece)[0], TextEntityAlignment.MIDDLE_CENTER
    if workpiece.engraving is not None:
        vertices = np.concatenate([stroke.vertices for stroke in workpiece.engraving.strokes])
        left, right = vertices[:, 0].min(), vertices[:, 0].max()
        spot = np.array([(left + right) / 2, vertices[:, 1].min() - TEXT_HEIGHT])
        align = TextEntityAlignment.TOP_CENTER
    text = space.add_text(
        workpiece.address,
        height=TEXT_HEIGHT,
        rotation=placement.turn,
        dxfattribs={"layer": "TEXT"},
    )
    return text.set_placement(placement(spot).tolist(), align=align)


def _angle(space: Modelspace, side: Side, placement: Placement) -> DXFGraphic:
    """Write an inclination abreast of the middle of its side, inside both outlines."""
    plan = side.corners[:, :2]
    inward = -side.normal[:2] / np.hypot(*side.normal[:2])
    along = np.array([inward[1], -inward[0]])  # the contour runs so, its inside on the left
    reach, depths = plan @ along, plan @ inward
    middle, depth = (reach.min() + reach.max()) / 2, depths.max() + ANGLE_HEIGHT / 2
    heading = np.degrees(np.arctan2(along[1], along[0])) + placement.turn
    legible = bool(np.cos(np.radians(heading)) >= 0.0)
    text = space.add_text(
        f"{side.inclination:z.1f}",
        height=ANGLE_HEIGHT,
        rotation=float(heading if legible else heading - 180.0) % 360.0,
        dxfattribs={"layer": "ANGLES"},
    )
    spot = placement(middle * along + depth * inward)
    inside = TextEntityAlignment.BOTTOM_CENTER if legible else TextEntityAlignment.TOP_CENTER
    return text.set_placement(spot.tolist(), align=inside)


def _arrow(workpiece: Workpiece, fibre: FloatArray) -> FloatArray:
    """Return tail, tip, barb, tip and barb of the fibre arrow, to the right of the address.

    Half-way from the middle to the rim there is room for half of what fits about the middle.
    """
    length = ARROW_SHARE * np.ptp(workpiece.silhouette @ fibre)
    across = np.array([-fibre[1], fibre[0]])
    tip = np.mean(_middles(workpiece), axis=0) + length / 2 * fibre
    neck, half = tip - ARROW_HEAD * length * fibre, ARROW_HEAD / 2 * length * across
    return np.array([tip - length * fibre, tip, neck + half, tip, neck - half])


def _middles(workpiece: Workpiece) -> tuple[FloatArray, FloatArray]:
    """Return the centroid of the rim seen from above, and the middle of its edge on the right."""
    rim = workpiece.silhouette
    edges = np.roll(rim, -1, axis=0) - rim
    lengths, middles = np.hypot(*edges.T), rim + edges / 2
    centre = lengths @ middles / lengths.sum()
    # the short edge of a relief cut may lie further out than the side it belongs to
    return centre, middles[np.argmax(lengths * (middles - centre)[:, 0])]


def _rectangle(corner: FloatArray, size: FloatArray) -> FloatArray:
    return corner + np.array([(0, 0), (1, 0), (1, 1), (0, 1)]) * size
