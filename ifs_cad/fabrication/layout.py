"""Layouts: which workpiece lies where on which sheet.

Source: section 4.3 (multi-part plates).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ifs_cad.fabrication.stock import Sheet
from ifs_cad.types import FloatArray


@dataclass(frozen=True)
class Placement:
    """Where a workpiece lies on its sheet: turned about its origin, then moved.

    Attributes
    ----------
    address : str
    turn : float, degrees, counter-clockwise seen from above
    x, y : float, mm, of the workpiece's origin from the lower left corner of the sheet
    """

    address: str
    turn: float
    x: float
    y: float

    @cached_property
    def rotation(self) -> FloatArray:
        """(2, 2) float; exact for whole quarter turns."""
        quarters, rest = divmod(self.turn, 90.0)
        if rest == 0.0:
            sine, cosine = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][int(quarters) % 4]
        else:
            angle = np.radians(self.turn)
            sine, cosine = float(np.sin(angle)), float(np.cos(angle))
        return np.array([[cosine, -sine], [sine, cosine]])

    def __call__(self, points: FloatArray) -> FloatArray:
        """Return (k, 2) or (k, 3) points of the workpiece as they lie on the sheet."""
        placed = np.array(points, dtype=float)
        placed[..., :2] = placed[..., :2] @ self.rotation.T + [self.x, self.y]
        return placed


@dataclass(frozen=True, eq=False)
class NestedSheet:
    """One sheet with what is cut from it.

    Attributes
    ----------
    number : int, from 1
    stock : Sheet
    placements : in the order of the workpieces
    used : float, area of all silhouettes on it, mm2
    offcuts : (n, 4) float, rectangles worth keeping: x, y of the lower left corner, length, width,
        mm; they do not overlap each other
    is_board : bool
        Planks stand one behind the other on it, as wide as the board.
    """

    number: int
    stock: Sheet
    placements: tuple[Placement, ...]
    used: float
    offcuts: FloatArray
    is_board: bool = False

    @property
    def name(self) -> str:
        """What files call the sheet or board."""
        return f"board-{self.number:03}" if self.is_board else f"sheet-{self.number:02}"

    @property
    def utilisation(self) -> float:
        """Share of the sheet that becomes workpieces."""
        return self.used / (self.stock.length * self.stock.width)


@dataclass(frozen=True, eq=False)
class Layout:
    """All sheets.

    Attributes
    ----------
    sheets : tuple of NestedSheet
    spacing : float, least distance of two silhouettes, mm
    margin : float, least distance of a silhouette from the edge of its sheet, mm
    """

    sheets: tuple[NestedSheet, ...]
    spacing: float
    margin: float

    @property
    def utilisation(self) -> float:
        """Share of all sheets that becomes workpieces."""
        total = sum(sheet.stock.length * sheet.stock.width for sheet in self.sheets)
        return sum(sheet.used for sheet in self.sheets) / total

    @property
    def bound(self) -> int:
        """How many of the sheets would do if no wood were lost, the largest first."""
        kinds = {(sheet.stock.thickness, sheet.stock.material.name) for sheet in self.sheets}
        return sum(self._bound(*kind) for kind in kinds)

    def _bound(self, thickness: float, material: str) -> int:
        alike = [
            sheet
            for sheet in self.sheets
            if (sheet.stock.thickness, sheet.stock.material.name) == (thickness, material)
        ]
        areas = np.sort([sheet.stock.length * sheet.stock.width for sheet in alike])[::-1]
        return int(np.searchsorted(np.cumsum(areas), sum(sheet.used for sheet in alike))) + 1

    def report(self) -> str:
        """Return what is used, sheet by sheet, as lines of text."""
        lines = [str(self)]
        for sheet in self.sheets:
            size = f"{sheet.stock.length:g} x {sheet.stock.width:g}"
            offcuts = ", ".join(f"{x:.0f} x {y:.0f}" for x, y in sheet.offcuts[:, 2:]) or "none"
            lines.append(
                f"{sheet.name}: {sheet.stock.name}, {size} mm, {len(sheet.placements)} pieces, "
                f"{sheet.utilisation:.1%} used, offcuts {offcuts}"
            )
        return "\n".join(lines)

    def __str__(self) -> str:
        pieces = sum(len(sheet.placements) for sheet in self.sheets)
        offcuts = sum(float(sheet.offcuts[:, 2:].prod(axis=1).sum()) for sheet in self.sheets)
        count = f"{len(self.sheets)} sheet" + ("s" if len(self.sheets) > 1 else "")
        return (
            f"{pieces} pieces on {count}, {self.utilisation:.1%} used; by area "
            f"alone {self.bound}; {offcuts / 1e6:.2f} m2 of offcuts worth keeping"
        )

    @cached_property
    def homes(self) -> dict[str, tuple[NestedSheet, Placement]]:
        """The sheet and the place of every address."""
        return {
            placement.address: (sheet, placement)
            for sheet in self.sheets
            for placement in sheet.placements
        }
