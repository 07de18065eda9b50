"""The drawing of a sheet: what is cut from it and where it lies, seen from above.

Upper outlines are solid, lower ones dashed; a broad arrow shows the grain, hatching what is left.

Source: section 4.3 (multi-part plates).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ifs_cad.elements.arcs import Path, bounds
from ifs_cad.fabrication.drawing.drafting import (
    BLOCK,
    MARGIN,
    SMALL,
    Paper,
    dimension,
    framed_page,
    grain_arrow,
    hatch,
    require_paper,
    rounded,
    rows_depth,
    scale_name,
    standard_scale,
)
from ifs_cad.fabrication.drawing.page import (
    ENGRAVED,
    LOWER,
    PIERCED,
    SHADE,
    STOCK,
    THIN,
    UPPER,
    Page,
    View,
)
from ifs_cad.fabrication.layout import NestedSheet, Placement
from ifs_cad.fabrication.measure import chord
from ifs_cad.fabrication.workpiece import Workpiece
from ifs_cad.types import FloatArray

_DIMENSIONS = 8.0  # from the sheet to its dimension lines, mm
_HEADING = 6.0


def sheet_page(
    sheet: NestedSheet, workpieces: Mapping[str, Workpiece], *, paper: Paper = "A4"
) -> Page:
    """Draw a sheet with all that lies on it.

    Parameters
    ----------
    sheet : NestedSheet
    workpieces : by address
    paper : "A4" or "A3"
    """
    stock = sheet.stock
    width, height = require_paper(paper)
    band = _DIMENSIONS + rows_depth(1) + 2.0
    room = np.array([width - 2 * MARGIN - 2 * band, height - 2 * MARGIN - BLOCK - band - _HEADING])
    size = np.array([stock.length, stock.width])
    scale = standard_scale(size, room)
    cells = [
        ("stock", stock.name),
        ("size, mm", f"{rounded(stock.length)} x {rounded(stock.width)}"),
        ("thickness, mm", rounded(stock.thickness, 2)),
        ("material", stock.material.name),
        ("grain", f"along the {stock.fibre}" if stock.fibre else "none"),
        ("elements", str(len(sheet.placements))),
        ("used", f"{100 * sheet.utilisation:.1f} %"),
        ("scale", scale_name(scale)),
        ("seen", "marked face up"),
    ]
    page = framed_page(sheet.name, cells, paper)
    corner = np.array([MARGIN + band, MARGIN + BLOCK + band]) + (room - size * scale) / 2
    view = View(scale, *corner.tolist())
    extent = size * scale
    page.box(STOCK, *corner.tolist(), *extent.tolist())
    dimension(page, corner, corner + extent * (1, 0), _DIMENSIONS, [rounded(stock.length)])
    dimension(page, corner + extent * (0, 1), corner, _DIMENSIONS, [rounded(stock.width)])
    _draw_offcuts(page, sheet.offcuts, view)
    _draw_pieces(page, [(workpieces[p.address], p) for p in sheet.placements], view)
    return page


def _draw_offcuts(page: Page, offcuts: FloatArray, view: View) -> None:
    for offcut in np.asarray(offcuts).reshape(-1, 4).tolist():
        x, y = view(np.array(offcut[:2])).tolist()
        long, wide = offcut[2] * view.scale, offcut[3] * view.scale
        hatch(page, x, y, long, wide)
        page.box(THIN, x, y, long, wide)
        label = f"offcut {rounded(offcut[2], 0)} x {rounded(offcut[3], 0)}"
        upright = wide > long
        room = max(long, wide) - 2.0
        across = min(long, wide)
        page.text(
            label,
            x + long / 2 + (SMALL / 3 if upright else 0.0),
            y + wide / 2 - (0.0 if upright else SMALL / 3),
            min(SMALL, 0.8 * across),
            anchor="middle",
            turn=90.0 if upright else 0.0,
            room=room,
        )


def _draw_pieces(page: Page, placed: Sequence[tuple[Workpiece, Placement]], view: View) -> None:
    """Draw layer by layer, so that a format can say what a pen is like once for all."""
    for piece, place in placed:
        page.line(SHADE, view(place(piece.silhouette)), closed=True)
    for piece, place in placed:
        if piece.fibre is not None:
            middle = piece.silhouette.mean(axis=0)
            grain_arrow(page, view(place(chord(piece.silhouette, middle, piece.fibre))))
    for piece, place in placed:
        if len(piece.lower):
            page.line(LOWER, view(place(piece.lower)), closed=True)
    for piece, place in placed:
        if len(piece.upper):
            page.line(UPPER, view(place(piece.upper)), closed=True)
    for piece, place in placed:
        for drill in piece.drills:
            page.circles(PIERCED, view(place(drill.points)), drill.diameter / 2 * view.scale)
    for piece, place in placed:
        if piece.engraving is not None:
            strokes = [
                Path(view(place(path.vertices)), path.bulges, path.closed)
                for path in piece.engraving.strokes
            ]
            page.paths(ENGRAVED, strokes)
    for piece, place in placed:
        _write_address(page, piece, place, view)


def _write_address(page: Page, piece: Workpiece, place: Placement, view: View) -> None:
    """Write the address where the engraving leaves most room, above or below it."""
    low, high = piece.silhouette[:, 1].min(), piece.silhouette[:, 1].max()
    middle = piece.silhouette.mean(axis=0)
    if piece.engraving is not None and piece.engraving.strokes:
        (_, bottom), (_, top) = bounds(piece.engraving.strokes)
        if high - top > bottom - low:
            middle[1] = (high + top) / 2
        else:
            middle[1] = (low + bottom) / 2
    across = chord(piece.silhouette, middle, np.array([1.0, 0.0]))
    middle = across.mean(axis=0)
    turn = (place.turn + 90.0) % 180.0 - 90.0
    size = min(SMALL, 0.25 * (high - low) * view.scale)
    angle = np.radians(turn)
    at = view(place(middle)) - size / 3 * np.array([-np.sin(angle), np.cos(angle)])
    x, y = at.tolist()
    page.text(
        piece.address,
        x,
        y,
        size,
        anchor="middle",
        turn=turn,
        bold=True,
        room=0.9 * float(np.ptp(across[:, 0])) * view.scale,
    )
