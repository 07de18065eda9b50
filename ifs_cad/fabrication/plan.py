"""Plans: what is cut from which stock. Panels are nested on sheets, planks cut from boards.

A board is a sheet as wide as its planks, so both end in the same layout, and all files that show a
layout show both. Planks are nested like panels where the workshop names sheets for them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ifs_cad.elements.element import Elements
from ifs_cad.elements.fibre import Fibre
from ifs_cad.elements.panel import Face
from ifs_cad.errors import StockError
from ifs_cad.fabrication.boards.cutting_plan import CuttingPlan, cut_boards
from ifs_cad.fabrication.layout import Layout, NestedSheet, Placement
from ifs_cad.fabrication.machining.router import read_router
from ifs_cad.fabrication.machining.setup import Setup, set_up
from ifs_cad.fabrication.nesting.envelope import clearance_reach
from ifs_cad.fabrication.nesting.nest import nest
from ifs_cad.fabrication.stock import Board, Sheet
from ifs_cad.fabrication.stock_file import read_stock
from ifs_cad.fabrication.workpiece import Workpiece
from ifs_cad.fabrication.workshop import Workshop
from ifs_cad.tolerance import DEFAULT
from ifs_cad.types import FloatArray

USUAL_CUTTER, USUAL_BREAKTHROUGH = 12.0, 0.5
"""Diameter of the cutter that sheets are nested for when other software writes the programs, mm,
and how far it reaches below them."""


@dataclass(frozen=True, eq=False)
class Plan:
    """What is cut from which stock.

    Attributes
    ----------
    layout : Layout
    boards : CuttingPlan, of planks cut from boards; None for what is cut from sheets
    setup : Setup, of the router that cuts the sheets; None where no programs are wanted
    """

    layout: Layout
    boards: CuttingPlan | None = None
    setup: Setup | None = None

    @property
    def kind(self) -> Literal["sheets", "boards"]:
        """What is cut."""
        return "sheets" if self.boards is None else "boards"

    def __str__(self) -> str:
        return str(self.layout if self.boards is None else self.boards)


def make_plan(
    elements: Elements,
    pieces: Sequence[Workpiece],
    workshop: Workshop,
    marked: Face | None = None,
) -> Plan:
    """Plan how workpieces are cut.

    Parameters
    ----------
    elements : what the workpieces were made of
    pieces : all of its workpieces, or some
    workshop : Workshop
    marked : "inner" or "outer", the face that is engraved, if any

    Raises
    ------
    StockError
        No stock fits, or there is not enough.
    MachineError
        What the router cannot cut; names the address and the side.
    InputError
        Names of stock that are not known, or numbers that cannot be meant.
    """
    stock = read_stock(workshop.stock)
    chosen = [stock[name] for name in workshop.use]
    if elements.cut_from == "boards" and not any(isinstance(one, Sheet) for one in chosen):
        plan = _cut(pieces, [b for b in chosen or stock.boards if isinstance(b, Board)], workshop)
        return Plan(_as_layout(plan, pieces, workshop), plan)
    sheets = [sheet for sheet in chosen or stock.sheets if isinstance(sheet, Sheet)]
    if marked is not None and marked == workshop.visible:
        # the face that is seen would be engraved: only sheets with a second good face hide it
        one_sided = [sheet.name for sheet in sheets if sheet.good_faces == 1]
        sheets = [sheet for sheet in sheets if sheet.good_faces == 2]
        if not sheets:
            raise StockError(
                f"The {marked} face is to be seen, and it is the one that is engraved; "
                f"{', '.join(one_sided)} have only one good face. Engrave the other face, or use "
                "sheets with two."
            )
    setup, reach = None, 0.0
    if workshop.programs:
        setup = set_up(
            pieces,
            read_router(workshop.tools),
            cutter=workshop.cutter,
            hold=workshop.hold,
            breakthrough=workshop.breakthrough,
        )
        reach = setup.spacing
    else:
        cutter = USUAL_CUTTER if workshop.cutter is None else workshop.cutter
        below = USUAL_BREAKTHROUGH if workshop.breakthrough is None else workshop.breakthrough
        reaches = (clearance_reach(piece, cutter, below) for piece in pieces)
        reach = max(one.beyond for one in reaches)
    rule = getattr(elements, "fibre", None)
    layout = nest(
        pieces,
        sheets,
        spacing=reach + workshop.gap,
        margin=workshop.margin,
        fibre=rule if isinstance(rule, Fibre) else None,
        method=workshop.method,
        seconds=workshop.seconds,
    )
    return Plan(layout, setup=setup)


def _cut(pieces: Sequence[Workpiece], boards: Sequence[Board], workshop: Workshop) -> CuttingPlan:
    sizes = np.array([_size(piece) for piece in pieces])
    width, thickness, material = sizes[:, 1].max(), pieces[0].thickness, pieces[0].material.name
    fitting = [
        board
        for board in boards
        if abs(board.width - width) <= DEFAULT.planar
        and abs(board.thickness - thickness) <= DEFAULT.planar
        and board.material.name == material
    ]
    if not fitting:
        sections = sorted({f"{b.width:g} x {b.thickness:g} mm {b.material.name}" for b in boards})
        raise StockError(
            f"No board has the section {width:g} x {thickness:g} mm of {material}. There are "
            f"{', '.join(sections) or 'none'}. Change the planks, or add boards to a stock file."
        )
    return cut_boards(
        sizes[:, 0],
        fitting,
        kerf=workshop.kerf,
        trim=workshop.trim,
        addresses=[piece.address for piece in pieces],
    )


def _as_layout(plan: CuttingPlan, pieces: Sequence[Workpiece], workshop: Workshop) -> Layout:
    sheets = []
    for board in plan.boards:
        stock = board.stock
        sheet = Sheet(
            stock.name,
            stock.length,
            stock.width,
            stock.thickness,
            stock.material,
            "length",
            stock.price,
            stock.count,
        )
        placements = tuple(
            Placement(pieces[k].address, 0.0, start - float(pieces[k].silhouette[:, 0].min()), 0.0)
            for k, start in zip(board.pieces, board.starts, strict=True)
        )
        used = sum(_area(pieces[k].silhouette) for k in board.pieces)
        rest = np.array([[stock.length - workshop.trim - board.rest, 0, board.rest, stock.width]])
        sheets.append(
            NestedSheet(
                board.number, sheet, placements, used, rest if board.rest else rest[:0], True
            )
        )
    return Layout(tuple(sheets), workshop.kerf, 0.0)


def _size(piece: Workpiece) -> FloatArray:
    return np.asarray(np.ptp(piece.silhouette, axis=0))


def _area(outline: FloatArray) -> float:
    x, y = outline.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
