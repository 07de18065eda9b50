"""The bounded knapsack: the most valuable pieces that fit one piece of stock.

It is solved on a grid of cells. Where all sizes and capacities lie on one that is coarse enough,
it is exact; else sizes rounded up give patterns that fit, and sizes rounded down give values that
no pattern exceeds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ifs_cad.fabrication.boards.cutting_problem import CuttingProblem
from ifs_cad.tolerance import Tolerance
from ifs_cad.types import BoolArray, FloatArray, IntArray

__all__ = ["MOST_CELLS", "MOST_CELLS_FOR_BOUND", "Grid", "Knapsack"]

MOST_CELLS = 20_000
"""Cells of the largest capacity: a knapsack of a thousand sizes then takes 50 ms and 20 MB."""

MOST_CELLS_FOR_BOUND = 200_000
"""The same for the last and best bound, which is computed once."""


@dataclass(frozen=True, eq=False)
class Grid:
    """Whole numbers for sizes and capacities.

    Attributes
    ----------
    sizes : (m,) int, cells
    capacities : (s,) int, cells
    exact : bool
        Nothing was rounded: what fits on the grid fits, and what does not does not.
    """

    sizes: IntArray
    capacities: IntArray
    exact: bool

    @classmethod
    def of(cls, problem: CuttingProblem, tol: Tolerance, *, up: bool, cells: int) -> Grid:
        """Return the grid that all lengths lie on, or one of so many cells with sizes rounded.

        Parameters
        ----------
        up : bool, round sizes up, for patterns that fit; else down, for bounds that hold
        """
        split = len(problem.sizes)
        lengths = np.concatenate([problem.sizes, problem.capacities])
        for fineness in 10 ** np.arange(4):
            whole = np.rint(lengths * fineness).astype(np.int64)
            if (np.abs(lengths - whole / fineness) <= tol.coincident).all():
                whole //= np.gcd.reduce(whole)
                if whole[split:].max() <= MOST_CELLS:
                    return cls(whole[:split], whole[split:], exact=True)
        step = problem.capacities.max() / cells
        return cls(
            (np.ceil if up else np.floor)(problem.sizes / step).astype(np.int64),
            np.floor((problem.capacities + tol.coincident) / step).astype(np.int64),
            exact=False,
        )


class Knapsack:
    """The most valuable patterns for every capacity, by dynamic programming.

    Parameters
    ----------
    grid : Grid
    values : (m,) float, of one piece of each size
    copies : (m,) int, how many of each size there may be
    with_patterns : bool
        Remember which pieces make the values; without, only `values` can be asked for.

    Attributes
    ----------
    values : (cells + 1,) float, the most that a pattern of so many cells is worth
    """

    def __init__(
        self, grid: Grid, values: FloatArray, copies: IntArray, *, with_patterns: bool
    ) -> None:
        self._sizes = sizes = grid.sizes
        capacity = int(grid.capacities.max())
        self._items: list[tuple[int, int]] = []
        for k in np.flatnonzero((values > 0.0) & (copies > 0) & (sizes <= capacity)).tolist():
            left = min(int(copies[k]), capacity // max(int(sizes[k]), 1))
            share = 1
            while left > 0:  # 1, 2, 4, ... and a rest make every number of copies
                self._items.append((k, min(share, left)))
                left -= share
                share *= 2
        self.values = np.zeros(capacity + 1)
        remembered = len(self._items) if with_patterns else 0
        self._taken: BoolArray = np.zeros((remembered, capacity + 1), dtype=bool)
        for row, (k, share) in enumerate(self._items):
            size = share * int(sizes[k])
            with_it = self.values[: capacity + 1 - size] + share * values[k]
            if with_patterns:
                np.greater(with_it, self.values[size:], out=self._taken[row, size:])
            np.maximum(with_it, self.values[size:], out=self.values[size:])

    def pattern(self, capacity: int) -> IntArray:
        """Return (m,) int, how many of each size make the most of so many cells."""
        pattern = np.zeros(len(self._sizes), dtype=np.int64)
        for taken, (k, share) in zip(self._taken[::-1], self._items[::-1], strict=True):
            if taken[capacity]:
                pattern[k] += share
                capacity -= share * int(self._sizes[k])
        return pattern
