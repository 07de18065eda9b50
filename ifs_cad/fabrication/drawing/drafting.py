"""The draughtsman's habits: standard scales, frames, title blocks, tables, dimensions, hatching."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np

from ifs_cad.errors import InputError
from ifs_cad.fabrication.drawing.page import (
    FRAME,
    GRAIN,
    GREY,
    HATCH,
    PAPER,
    RULE,
    Page,
    text_width,
)
from ifs_cad.fabrication.table import Cell, Table
from ifs_cad.types import FloatArray

Paper = Literal["A4", "A3"]
SIZES: dict[str, tuple[float, float]] = {"A4": (297.0, 210.0), "A3": (420.0, 297.0)}

MARGIN = 10.0
BLOCK = 14.0  # height of the title block, mm
SMALL, NORMAL, LARGE = 2.1, 2.8, 6.0  # sizes of fonts, mm
CAPITAL = 0.72  # height of a capital as a share of the size

_DIMENSION_GAP, _TICK = 1.0, 1.2
_ARROW_ENDS = np.array([[0.12], [0.88]])  # shares of the line that a grain arrow lies within
_STEPS = (1, 2, 5)
_READING = np.array([np.cos(np.pi / 12), np.sin(np.pi / 12)])  # text turns from -75 to 105


def standard_scale(size: FloatArray, room: FloatArray) -> float:
    """Return the largest of 1:1, 1:2, 1:5, 1:10 ... (2:1, 5:1 ...) at which a size fits a room.

    Parameters
    ----------
    size, room : (2,) float, mm
    """
    limit = float((room / size).min())
    reduced = limit < 1.0
    factor = 1.0 / limit if reduced else limit
    decade = 10.0 ** math.floor(math.log10(factor))
    if reduced:
        return 1.0 / min(step * decade for step in (*_STEPS, 10) if step * decade >= factor)
    return max(step * decade for step in _STEPS if step * decade <= factor)


def scale_name(scale: float) -> str:
    """Return how a scale is written."""
    return f"{scale:.0f}:1" if scale > 1.0 else f"1:{1.0 / scale:.0f}"


def require_paper(paper: str) -> tuple[float, float]:
    """Return width and height of a paper lying on its long side, mm.

    Raises
    ------
    InputError
    """
    if paper not in get_args(Paper):
        raise InputError(f'The paper must be "A4" or "A3", got {paper!r}.')
    return SIZES[paper]


def framed_page(title: str, cells: Sequence[tuple[str, str]], paper: str) -> Page:
    """Return a page with a frame and, along its foot, a title block of labelled cells."""
    width, height = require_paper(paper)
    page = Page(title, width, height)
    page.box(PAPER, 0.0, 0.0, width, height)
    page.box(FRAME, MARGIN, MARGIN, width - 2 * MARGIN, height - 2 * MARGIN)
    page.line(FRAME, np.array([(MARGIN, MARGIN + BLOCK), (width - MARGIN, MARGIN + BLOCK)]))
    inside = width - 2 * MARGIN
    lead = min(text_width(title, LARGE) * 1.1 + 6.0, inside / 3)
    page.text(title, MARGIN + 3.0, MARGIN + 4.5, LARGE, bold=True, room=(lead - 5.0) / 1.1)
    wanted = [
        max(text_width(name, SMALL), text_width(value, NORMAL)) + 4.0 for name, value in cells
    ]
    share = (inside - lead) / sum(wanted)
    x = MARGIN + lead
    for (name, value), want in zip(cells, wanted, strict=True):
        page.line(RULE, np.array([(x, MARGIN), (x, MARGIN + BLOCK)]))
        room = want * share - 3.0
        page.text(name, x + 1.5, MARGIN + BLOCK - 4.0, SMALL, colour=GREY, room=room)
        page.text(value, x + 1.5, MARGIN + 3.5, NORMAL, room=room)
        x += want * share
    return page


def draw_table(
    page: Page, table: Table, x: float, top: float, width: float, room: float, *, row: float = 4.2
) -> float:
    """Draw a table and return where it ends; its rows are pressed together to fit the room, mm."""
    shown = [[column.title for column in table.columns]] + [
        [_shown(cell, column.decimals) for cell, column in zip(cells, table.columns, strict=True)]
        for cells in table.rows
    ]
    row = min(row, room / (len(shown) + 1))
    size = min(NORMAL, 0.62 * row)
    wanted = [
        max(text_width(cells[k], size) for cells in shown) + 2.0 for k in range(len(shown[0]))
    ]
    share = width / sum(wanted)
    page.text(table.name, x, top - 0.7 * row, size, bold=True)
    rules = np.arange(1, len(shown) + 2) * row
    lines = [[(x, top - y), (x + width, top - y)] for y in rules.tolist()]
    page.lines(RULE, np.array(lines))
    for number, cells in enumerate(shown):
        y = top - (number + 1.7) * row
        right = x
        for cell, column, want in zip(cells, table.columns, wanted, strict=True):
            room_here = want * share - 1.5
            right += want * share
            colour = "#000000" if number else GREY
            if column.kind == "text":
                left = right - want * share + 0.8
                page.text(cell, left, y, size, colour=colour, room=room_here)
            else:
                page.text(cell, right - 0.8, y, size, anchor="end", colour=colour, room=room_here)
    return top - (len(shown) + 1) * row


def dimension(
    page: Page, start: FloatArray, end: FloatArray, offset: float, rows: Sequence[str]
) -> None:
    """Dimension a distance on the paper, to the right of the way from start to end.

    Parameters
    ----------
    start, end : (2,) float, mm on the paper
    offset : float, mm, from the points to the dimension line
    rows : what is written beyond the line: the length, and more
    """
    along = end - start
    span = float(np.hypot(*along))
    along = along / span
    outward = np.array([along[1], -along[0]])
    line = np.array([start, end]) + outward * offset
    feet = np.array([start, end]) + outward * _DIMENSION_GAP
    page.lines(RULE, np.stack([feet, line + outward * _TICK], axis=1))
    slash = (along + outward) * (_TICK / 2)
    page.lines(RULE, np.stack([line - slash, line + slash], axis=1))
    page.line(RULE, line)
    write_beside(page, line.mean(axis=0), outward, rows)


def write_beside(page: Page, at: FloatArray, outward: FloatArray, rows: Sequence[str]) -> None:
    """Write rows along a line, readable from below or from the right, on its outer side."""
    along = np.array([-outward[1], outward[0]])
    # What runs nearly straight up or down is read from the right, wherever it leans.
    upright = along if along @ _READING > 0.0 else -along
    up = np.array([-upright[1], upright[0]])
    outside = float(up @ outward) > 0
    turn = math.degrees(math.atan2(upright[1], upright[0]))
    reach = 0.8
    for number, text in enumerate(rows):
        size = NORMAL if number == 0 else SMALL
        low = reach if outside else reach + size * CAPITAL
        x, y = at + outward * low
        page.text(
            text,
            float(x),
            float(y),
            size,
            anchor="middle",
            turn=turn,
            bold=number == 0,
            colour="#000000" if number == 0 else GREY,
        )
        reach += size * CAPITAL + 1.0


def rows_depth(rows: int) -> float:
    """Return how far rows reach beyond the line they are written beside, mm."""
    return 0.8 + NORMAL * CAPITAL + (rows - 1) * (1.0 + SMALL * CAPITAL)


def grain_arrow(page: Page, line: FloatArray) -> None:
    """Draw a broad double arrow within a (2, 2) line on the paper, to lie behind all else."""
    start, end = line[0] + (line[1] - line[0]) * _ARROW_ENDS
    span = float(np.hypot(*(end - start)))
    along = (end - start) / span
    side = np.array([-along[1], along[0]])
    barb = min(span / 6, 4.0)
    heads = [
        [tip + barb * (way * along + side / 2), tip, tip + barb * (way * along - side / 2)]
        for tip, way in ((start, 1.0), (end, -1.0))
    ]
    page.line(GRAIN, np.array([start, end]))
    page.lines(GRAIN, np.array(heads))


def hatch(page: Page, x: float, y: float, width: float, height: float, *, gap: float = 3.0) -> None:
    """Hatch a rectangle with lines that rise at 45 degrees."""
    # The lines y - x = c cross the box for c from -width to height.
    offsets = np.arange(-width + gap, height, gap)
    left = np.maximum(0.0, -offsets)
    right = np.minimum(width, height - offsets)
    lines = np.stack(
        [
            np.column_stack([left, left + offsets]),
            np.column_stack([right, right + offsets]),
        ],
        axis=1,
    )
    page.lines(HATCH, lines + np.array([x, y]))


def rounded(value: float, decimals: int = 1) -> str:
    """Return a number for a drawing, without a negative zero."""
    text = f"{value:.{decimals}f}"
    return text.lstrip("-") if float(text) == 0.0 else text


def _shown(cell: Cell, decimals: int) -> str:
    if cell is None:
        return ""
    return cell if isinstance(cell, str) else rounded(cell, decimals)
