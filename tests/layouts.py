"""Layouts made by hand: workpieces in rows, turned in every way, for tests of what is written."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ifs_cad.elements.material import SPRUCE_PLYWOOD
from ifs_cad.fabrication.layout import Layout, NestedSheet, Placement
from ifs_cad.fabrication.stock import Sheet
from ifs_cad.fabrication.workpiece import Workpiece

SPACING, MARGIN = 20.0, 15.0
STOCK = Sheet("spruce", 2500.0, 1250.0, 10.0, SPRUCE_PLYWOOD)
TURNS = (0.0, 180.0, 90.0, 37.5, 270.0)


def in_rows(
    pieces: Sequence[Workpiece], stock: Sheet = STOCK, turns: Sequence[float] = TURNS
) -> Layout:
    """Lay workpieces side by side, row above row, sheet after sheet."""
    sheets: list[NestedSheet] = []
    placed: list[Placement] = []
    x = y = MARGIN
    used = height = 0.0

    def finish() -> None:
        free = [(MARGIN, y + height + SPACING, stock.length / 2, 40.0)]
        sheets.append(NestedSheet(len(sheets) + 1, stock, tuple(placed), used, np.array(free)))

    for number, piece in enumerate(pieces):
        turn = turns[number % len(turns)]
        turned = Placement(piece.address, turn, 0.0, 0.0)(piece.silhouette)
        low, size = turned.min(axis=0), np.ptp(turned, axis=0)
        if x + size[0] > stock.length - MARGIN:
            x, y, height = MARGIN, y + height + SPACING, 0.0
        if y + size[1] > stock.width - MARGIN:
            finish()
            placed, x, y, used, height = [], MARGIN, MARGIN, 0.0, 0.0
        placed.append(Placement(piece.address, turn, x - low[0], y - low[1]))
        x += size[0] + SPACING
        height = max(height, size[1])
        used += area(piece.silhouette)
    finish()
    return Layout(tuple(sheets), SPACING, MARGIN)


def area(ring: np.ndarray) -> float:
    """Return the area of a counter-clockwise (k, 2) ring."""
    x, y = ring.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
