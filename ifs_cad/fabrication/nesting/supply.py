"""Which sheets to take: the one whose price buys most, sheet after sheet, while there are any.

Terms
-----
kind : one stock of sheets with the poses of all pieces on them.
fill : how one sheet is filled, see `packing.fill_sheet`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ifs_cad.fabrication.nesting.packing import Spot
from ifs_cad.fabrication.nesting.poses import Poses
from ifs_cad.fabrication.stock import Sheet
from ifs_cad.types import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class Kind:
    """A stock of sheets.

    Attributes
    ----------
    sheet : Sheet
    poses : Poses, of all pieces
    room : (2,) float, length and width inside the margins, mm
    """

    sheet: Sheet
    poses: Poses
    room: FloatArray

    @property
    def area(self) -> float:
        """In mm2."""
        return self.sheet.length * self.sheet.width

    @property
    def fits(self) -> BoolArray:
        """(n,) bool, which pieces fit at all."""
        return np.asarray(self.poses.allowed.any(axis=1))


@dataclass(frozen=True, eq=False)
class Load:
    """A sheet and what lies on it."""

    kind: Kind
    spots: list[Spot]


Fill = Callable[[Kind, list[int]], list[Spot]]
"""Takes a kind and the pieces left, in order; returns what lies on the next sheet of that kind."""


def load_sheets(
    kinds: Sequence[Kind], order: Sequence[int], fill: Fill
) -> tuple[list[Load], list[int]]:
    """Fill sheets until no piece is left, or no sheet.

    Returns
    -------
    loads : list of Load
    left : list of int, the pieces that are left
    """
    left = list(order)
    stores = [np.inf if kind.sheet.count is None else kind.sheet.count for kind in kinds]
    loads: list[Load] = []
    while left:
        trials = []
        for index, kind in enumerate(kinds):
            suitable = [piece for piece in left if kind.fits[piece]]
            if stores[index] > 0 and suitable:
                spots = fill(kind, suitable)
                trials.append((_expense(kind, spots, kinds), index, Load(kind, spots)))
        if not trials:
            break
        _, index, load = min(trials, key=lambda trial: trial[:2])
        loads.append(load)
        stores[index] -= 1
        done = {spot.piece for spot in load.spots}
        left = [piece for piece in left if piece not in done]
    return loads, left


def price(kind: Kind, kinds: Sequence[Kind]) -> float:
    """Return what a sheet costs: its area, unless every kind has a price."""
    prices = [one.sheet.price for one in kinds]
    return kind.area if None in prices else float(kind.sheet.price or 0.0)


def worth(loads: Sequence[Load], kinds: Sequence[Kind], order: Sequence[int]) -> tuple[float, ...]:
    """Return by what loads are compared, the less the better.

    The price of all sheets, their number, how often the order leaves a sheet, and which share of
    its length the emptiest one uses.
    """
    home = {spot.piece: number for number, load in enumerate(loads) for spot in load.spots}
    leaves = sum(home[one] != home[other] for one, other in pairwise(order))
    used = [
        max(spot.corner[0] + _length(load.kind, spot) for spot in load.spots) / load.kind.room[0]
        for load in loads
    ]
    return sum(price(load.kind, kinds) for load in loads), len(loads), leaves, min(used)


def loaded_area(load: Load) -> float:
    """Return the area of the pieces on a sheet, mm2."""
    areas = load.kind.poses.polygons.areas
    return float(sum(areas[spot.piece, spot.pose] for spot in load.spots))


def _length(kind: Kind, spot: Spot) -> float:
    return float(kind.poses.polygons.sizes[spot.piece, spot.pose, 0])


def _expense(kind: Kind, spots: list[Spot], kinds: Sequence[Kind]) -> tuple[float, float]:
    """Return the price and the area of sheet for each mm2 of pieces."""
    area = loaded_area(Load(kind, spots))
    return price(kind, kinds) / area, kind.area / area
