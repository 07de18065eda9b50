"""The drawing of an element: one page for all elements that are equal.

The plan shows the element as it lies on the machine: the upper outline solid, the lower one dashed,
the grain as a broad arrow, holes and the address. Every side has a number, its length at the upper
face, its inclination and its neighbour; sections show the inclinations, the tables say it all once
more with both lengths, and where the holes are. Where the equal elements have other neighbours, a
table says which.

Source: section 4.3, figure 19.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ifs_cad.elements.arcs import Path
from ifs_cad.fabrication.congruence import Member
from ifs_cad.fabrication.drawing.drafting import (
    BLOCK,
    MARGIN,
    NORMAL,
    SMALL,
    Paper,
    dimension,
    draw_table,
    framed_page,
    grain_arrow,
    require_paper,
    rounded,
    rows_depth,
    scale_name,
    standard_scale,
    write_beside,
)
from ifs_cad.fabrication.drawing.page import (
    ENGRAVED,
    GREY,
    LOWER,
    ORIGIN,
    OUTLINE,
    PIERCED,
    RULE,
    SHADE,
    THIN,
    WOOD,
    Page,
    View,
    text_width,
)
from ifs_cad.fabrication.measure import SideEdges, chord, corner_angles, extent, mass, side_edges
from ifs_cad.fabrication.table import Column, Table
from ifs_cad.fabrication.workpiece import Side, Workpiece
from ifs_cad.types import FloatArray

_TABLES = 88.0  # width of the column of tables, mm
_SECTIONS = 30.0  # height of the band of sections, mm
_DIMENSIONS, _ASIDE = 6.0, 2.0
_LEAST_EDGE = 8.0  # shorter on the paper, an edge is only numbered, mm
_ROW, _LEAST_ROW = 4.2, 2.9
_TABLE_ROWS = 3  # that a table takes beside its own: name, titles, gap
_HEADING_ROWS = 3
_PAD = 4.0


def element_pages(
    workpieces: Sequence[Workpiece], group: Sequence[Member], *, paper: Paper = "A4"
) -> Iterator[Page]:
    """Draw one group of equal elements: a page, and more when their list does not fit on it.

    Parameters
    ----------
    workpieces : all elements
    group : Member of them, the first of which is drawn
    paper : "A4" or "A3"
    """
    piece = workpieces[group[0].index]
    edges = side_edges(piece)
    width, height = require_paper(paper)
    left, right = MARGIN + _PAD, width - MARGIN - 2 * _PAD - _TABLES
    low, high = MARGIN + BLOCK + _SECTIONS, height - MARGIN - _PAD
    heading = _wrapped([workpieces[m.index].address for m in group[1:]], right - left)
    if len(heading) > _HEADING_ROWS:
        heading = ["Equal elements: see the table of neighbours."]
    high -= len(heading) * _ROW
    band = _DIMENSIONS + rows_depth(2) + 1.5
    room = np.array([right - left, high - low]) - 2 * band
    size = extent(piece)
    scale = standard_scale(size, room)
    page = framed_page(piece.address, _cells(piece, len(group), scale), paper)
    for number, words in enumerate(heading):
        page.text(words, left, height - MARGIN - _PAD - (number + 0.6) * _ROW, SMALL)
    corner = np.array([left, low]) + band + (room - size * scale) / 2
    origin = piece.silhouette.min(axis=0)
    view = View(scale, *(corner - origin * scale).tolist())
    _draw_plan(page, piece, edges, view)
    _draw_sections(page, piece, left, MARGIN + BLOCK, right - left)

    top, column = height - MARGIN - _PAD, right + _PAD
    page.line(
        RULE, np.array([(right + _PAD / 2, MARGIN + BLOCK), (right + _PAD / 2, height - MARGIN)])
    )
    tables = [_edge_table(piece, edges), *_hole_tables(piece), *_member_tables(workpieces, group)]
    free = top - (MARGIN + BLOCK + _PAD)
    rows = np.cumsum([len(table.rows) + _TABLE_ROWS for table in tables])
    here = max(1, int(np.searchsorted(rows, free / _LEAST_ROW, side="right")))
    row = min(_ROW, free / float(rows[here - 1]))
    for table in tables[:here]:
        top = draw_table(page, table, column, top, _TABLES, free, row=row) - row
    if tables[here:]:
        page.text("Continued on the next page.", column, top - row, SMALL)
    yield page
    for table in tables[here:]:
        yield from _table_pages(piece.address, table, paper)


def _cells(piece: Workpiece, count: int, scale: float) -> list[tuple[str, str]]:
    long, wide = extent(piece).tolist()
    return [
        ("pieces", str(count)),
        ("thickness, mm", rounded(piece.thickness, 2)),
        ("material", piece.material.name),
        ("mass, kg", rounded(mass(piece), 3)),
        ("size, mm", f"{rounded(long)} x {rounded(wide)}"),
        ("grain", "free" if piece.fibre is None else "as the arrow"),
        ("scale", scale_name(scale)),
        ("seen", "marked face up"),
        ("units", "mm, degrees"),
    ]


def _draw_plan(page: Page, piece: Workpiece, edges: SideEdges, view: View) -> None:
    page.line(SHADE, view(piece.silhouette), closed=True)
    if piece.fibre is not None:
        middle = piece.silhouette.mean(axis=0)
        grain_arrow(page, view(chord(piece.silhouette, middle, piece.fibre)))
    if len(piece.lower):
        page.line(LOWER, view(piece.lower), closed=True)
    _draw_arrises(page, piece, view)
    if len(piece.upper):
        page.line(OUTLINE, view(piece.upper), closed=True)
    number = 0
    for drill in piece.drills:
        radius = drill.diameter / 2 * view.scale
        centres = view(drill.points)
        page.circles(PIERCED, centres, radius)
        arm = max(radius * 1.6, 1.0)
        cross = np.array([[(-arm, 0.0), (arm, 0.0)], [(0.0, -arm), (0.0, arm)]])
        page.lines(THIN, (centres[:, None, None] + cross).reshape(-1, 2, 2))
        for x, y in centres.tolist():
            number += 1
            page.text(str(number), x + arm * 0.7, y + arm * 0.5, SMALL, colour=PIERCED.colour)
    if piece.engraving is not None:
        strokes = [
            Path(view(path.vertices), path.bulges, path.closed) for path in piece.engraving.strokes
        ]
        page.paths(ENGRAVED, strokes)
    _draw_origin(page, view)
    for number, (side, upper, lower) in enumerate(
        zip(piece.sides, edges.upper, edges.lower, strict=True), start=1
    ):
        _dimension_side(page, number, side, upper, lower, piece, view)


def _draw_arrises(page: Page, piece: Workpiece, view: View) -> None:
    """Draw the edges between sides, which join the two outlines."""
    corners = [side.corners for side in piece.sides]
    starts = np.concatenate(corners)
    ends = np.concatenate([np.roll(loop, -1, axis=0) for loop in corners])
    rises = ends[:, 2] > starts[:, 2]  # each arris is met from both sides, once upwards
    slopes = ~np.isin(starts[:, 2], (0.0, piece.thickness)) | (ends[:, 2] != starts[:, 2])
    page.lines(RULE, view(np.stack([starts, ends], axis=1)[rises & slopes]))


def _draw_origin(page: Page, view: View) -> None:
    x, y = view(np.zeros(2)).tolist()
    reach = 5.0
    page.lines(ORIGIN, np.array([[(x, y), (x + reach, y)], [(x, y), (x, y + reach)]]))
    page.text("x", x + reach + 0.6, y - 2.2, SMALL, colour=ORIGIN.colour)
    page.text("y", x - 2.0, y + reach + 0.6, SMALL, colour=ORIGIN.colour)


def _dimension_side(
    page: Page,
    number: int,
    side: Side,
    upper: FloatArray,
    lower: FloatArray,
    piece: Workpiece,
    view: View,
) -> None:
    shown = view(lower if np.isnan(upper).any() else upper)
    if np.isnan(shown).any():  # between the faces: only the tables tell
        return
    outward = side.normal[:2] / np.hypot(*side.normal[:2])
    # The dimension line lies clear of the whole piece, not only of the upper outline.
    clear = float((view(piece.silhouette) @ outward).max() - shown[0] @ outward)
    span = float(np.hypot(*(shown[1] - shown[0])))
    label = f"{number}: {rounded(side.inclination, 2)}°"
    if span < _LEAST_EDGE:
        write_beside(page, shown.mean(axis=0) + outward * (clear + _ASIDE), outward, [str(number)])
        return
    length = span / view.scale
    beyond = f"{label}, {side.neighbour or side.kind}"
    if text_width(beyond, SMALL) > span:
        beyond = label
    dimension(page, shown[0], shown[1], clear + _DIMENSIONS, [rounded(length, 2), beyond])


def _draw_sections(page: Page, piece: Workpiece, x: float, y: float, width: float) -> None:
    """Draw a section through every inclination, seen along the side, the inside to the left."""
    alike: dict[str, list[int]] = {}
    for number, side in enumerate(piece.sides, start=1):
        alike.setdefault(rounded(side.inclination, 2), []).append(number)
    cell = min(40.0, width / len(alike))
    high = min(9.0, 0.22 * cell)
    for place, (inclination, numbers) in enumerate(alike.items()):
        left = x + place * cell + 1.0
        bottom = y + 9.0
        slope = high * float(np.tan(np.radians(float(inclination))))
        body = 0.45 * cell
        foot, head = left + body - slope / 2, left + body + slope / 2
        page.line(
            WOOD,
            np.array(
                [(left, bottom), (foot, bottom), (head, bottom + high), (left, bottom + high)]
            ),
            closed=True,
        )
        plumb = [(foot, bottom), (foot, bottom + high * 1.5)]
        page.line(LOWER, np.array(plumb))
        title = ("side " if len(numbers) == 1 else "sides ") + ", ".join(map(str, numbers))
        page.text(title, left, bottom + high * 1.5 + 2.0, SMALL, bold=True, room=cell - 2.0)
        page.text(
            f"{inclination}°", left + body, bottom - 3.6, NORMAL, anchor="middle", room=cell - 2.0
        )
    page.text(
        "sections, not to scale; top = marked face", x + 1.0, y + 1.6, 1.8, colour=GREY, room=width
    )


def _edge_table(piece: Workpiece, edges: SideEdges) -> Table:
    columns = (
        Column("side", decimals=0),
        Column("upper"),
        Column("lower"),
        Column("inclination"),
        Column("to next"),
        Column("kind", "text"),
        Column("neighbour", "text"),
    )
    rows = tuple(
        (number, upper, lower, side.inclination, angle, side.kind, side.neighbour or None)
        for number, (side, upper, lower, angle) in enumerate(
            zip(
                piece.sides,
                edges.upper_lengths.tolist(),
                edges.lower_lengths.tolist(),
                corner_angles(piece).tolist(),
                strict=True,
            ),
            start=1,
        )
    )
    return Table("Sides, counter-clockwise, with the angle in plan to the next", columns, rows)


def _hole_tables(piece: Workpiece) -> Iterator[Table]:
    """Yield the table of the holes, two holes in a row when there are many."""
    holes = [
        (x, y, drill.diameter, drill.depth)
        for drill in piece.drills
        for x, y in drill.points.tolist()
    ]
    if holes:
        columns = (
            Column("hole", decimals=0),
            Column("x"),
            Column("y"),
            Column("diameter"),
            Column("depth"),
        )
        rows = tuple((number, *hole) for number, hole in enumerate(holes, start=1))
        yield Table("Holes", columns, rows)


def _member_tables(workpieces: Sequence[Workpiece], group: Sequence[Member]) -> Iterator[Table]:
    """Yield the neighbours of the equal elements, by the sides of the one that is drawn."""
    if len(group) > 1:
        columns = (
            Column("element", "text"),
            *(Column(f"at {k + 1}", "text") for k in range(len(group[0].sides))),
        )
        pieces = [(workpieces[member.index], member.sides.tolist()) for member in group[1:]]
        rows = tuple(
            (piece.address, *(piece.sides[k].neighbour or None for k in sides))
            for piece, sides in pieces
        )
        yield Table("Neighbours of the equal elements", columns, rows)


def _table_pages(address: str, table: Table, paper: Paper) -> Iterator[Page]:
    """Draw a long table on pages of its own, in two columns."""
    width, height = require_paper(paper)
    top, room = height - MARGIN - _PAD, height - 2 * MARGIN - BLOCK - 2 * _PAD
    fits = int(room / _ROW) - _TABLE_ROWS
    wide = (width - 2 * MARGIN - 3 * _PAD) / 2
    for first in range(0, len(table.rows), 2 * fits):
        page = framed_page(address, [("continued", table.name), ("units", "mm, degrees")], paper)
        for half in range(2):
            rows = table.rows[first + half * fits : first + (half + 1) * fits]
            if rows:
                part = Table(table.name, table.columns, rows)
                draw_table(page, part, MARGIN + _PAD + half * (wide + _PAD), top, wide, room)
        yield page


def _wrapped(addresses: Sequence[str], width: float) -> list[str]:
    """Return rows of text that list addresses."""
    if not addresses:
        return []
    rows = ["Equal:"]
    for address in addresses:
        longer = f"{rows[-1]} {address}"
        if text_width(longer, SMALL) > width:
            rows.append(address)
        else:
            rows[-1] = longer
    return rows
