"""The drawing of boards: which planks are cut from each, where, and what is left.

Source: section 4.1 (the prevalent planks existing on the market).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby

import numpy as np

from ifs_cad.fabrication.boards.cutting_plan import CutBoard, CuttingPlan
from ifs_cad.fabrication.drawing.drafting import (
    BLOCK,
    CAPITAL,
    MARGIN,
    NORMAL,
    SMALL,
    Paper,
    framed_page,
    hatch,
    require_paper,
    rounded,
    scale_name,
    standard_scale,
)
from ifs_cad.fabrication.drawing.page import GREY, PAPER, STOCK, THIN, WOOD, Page, View
from ifs_cad.fabrication.planklist import end_angles
from ifs_cad.fabrication.workpiece import Workpiece

_PAD = 6.0
_TITLE = 6.0  # above a board, mm
_NOTES = 12.0  # below a board: lengths, angles, cuts
_LEAST_TEXT = 1.2


def board_pages(
    plan: CuttingPlan, workpieces: Sequence[Workpiece], *, paper: Paper = "A4"
) -> Iterator[Page]:
    """Draw all boards, several to a page, each page of one stock at one scale.

    Parameters
    ----------
    plan : CuttingPlan
    workpieces : the planks that the plan numbers
    paper : "A4" or "A3"
    """
    width, height = require_paper(paper)
    room = np.array([width - 2 * MARGIN - 2 * _PAD, (height - 2 * MARGIN - BLOCK) / 2])
    for stock, alike in groupby(plan.boards, key=lambda board: board.stock):
        boards = list(alike)
        scale = standard_scale(np.array([stock.length, stock.width]), room)
        pitch = stock.width * scale + _TITLE + _NOTES
        fits = int((height - 2 * MARGIN - BLOCK - _PAD) / pitch)
        for first in range(0, len(boards), fits):
            shown = boards[first : first + fits]
            title = (
                f"Boards {shown[0].number} to {shown[-1].number}"
                if len(shown) > 1
                else f"Board {shown[0].number}"
            )
            cells = [
                ("stock", stock.name),
                (
                    "board, mm",
                    " x ".join(map(rounded, (stock.length, stock.width, stock.thickness))),
                ),
                ("material", stock.material.name),
                ("saw cut, mm", rounded(plan.kerf, 2)),
                ("trimmed, mm", rounded(plan.trim, 2)),
                ("scale", scale_name(scale)),
                ("units", "mm, degrees"),
            ]
            page = framed_page(title, cells, paper)
            top = height - MARGIN - _PAD / 2
            for place, board in enumerate(shown):
                low = top - place * pitch - _TITLE - stock.width * scale
                _draw_board(page, board, workpieces, View(scale, MARGIN + _PAD, low))
            yield page


def board_page(board: CutBoard, workpieces: Sequence[Workpiece], *, paper: Paper = "A4") -> Page:
    """Draw one board on a strip as long as the paper and as high as it needs.

    Parameters
    ----------
    board : CutBoard
    workpieces : the planks that the plan numbers
    paper : "A4" or "A3"
    """
    width, height = require_paper(paper)
    size = np.array([board.stock.length, board.stock.width])
    scale = standard_scale(size, np.array([width - 2 * _PAD, height / 2]))
    high = board.stock.width * scale
    page = Page(f"Board {board.number}", width, high + _TITLE + _NOTES)
    page.box(PAPER, 0.0, 0.0, page.width, page.height)
    _draw_board(page, board, workpieces, View(scale, _PAD, _NOTES))
    return page


def _draw_board(page: Page, board: CutBoard, workpieces: Sequence[Workpiece], view: View) -> None:
    stock, scale = board.stock, view.scale
    high, end = stock.width * scale, view.x + stock.length * scale
    heading = (
        f"{board.number}: {stock.name}, planks {len(board.pieces)}, rest {rounded(board.rest)}"
    )
    page.text(heading, view.x, view.y + high + 1.5, NORMAL, bold=True, room=stock.length * scale)
    page.box(STOCK, view.x, view.y, stock.length * scale, high)
    trim = board.starts[0]
    if board.rest > 0.0:
        hatch(page, end - (trim + board.rest) * scale, view.y, board.rest * scale, high)
    pieces = [workpieces[index] for index in board.pieces]
    for piece, start in zip(pieces, board.starts, strict=True):
        page.line(WOOD, view(piece.upper + np.array([start, 0.0])), closed=True)
    for piece, start in zip(pieces, board.starts, strict=True):
        _write_plank(page, piece, start, view)


def _write_plank(page: Page, piece: Workpiece, start: float, view: View) -> None:
    """Write address, length and ends of a plank, and where on the board it begins."""
    low, high = piece.upper.min(axis=0), piece.upper.max(axis=0)
    left, right = (view.x + (start + x) * view.scale for x in (low[0], high[0]))
    wide, room = (high[1] - low[1]) * view.scale, right - left - 1.0
    middle = (left + right) / 2
    size = min(NORMAL, 0.7 * wide)
    size = max(_LEAST_TEXT, size)
    page.text(
        piece.address,
        middle,
        view.y + wide / 2 - size * CAPITAL / 2,
        size,
        anchor="middle",
        bold=True,
        room=room * 0.85,
    )
    page.lines(THIN, np.array([[(left, view.y - 0.5), (left, view.y - 3.0)]]))
    angles = end_angles(piece)
    rows = (
        f"{rounded(high[0] - low[0], 2)}",
        "see its drawing" if angles is None else " / ".join(f"{rounded(a, 2)}°" for a in angles),
        f"at {rounded(start, 1)}",
    )
    for number, text in enumerate(rows):
        y = view.y - 3.0 - number * 3.0
        colour = "#000000" if number == 0 else GREY
        page.text(text, middle, y, SMALL, anchor="middle", colour=colour, room=room)
