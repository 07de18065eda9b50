"""The one-dimensional cutting stock problem, in numbers: what is asked for and what is answered.

Terms
-----
pattern : how many of each size are cut from one piece of stock.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from ifs_cad.types import FloatArray, IntArray

__all__ = ["CuttingProblem", "CuttingSolution", "whole_costs"]


@dataclass(frozen=True, eq=False)
class CuttingProblem:
    """Sizes to cut, and stock to cut them from.

    Attributes
    ----------
    sizes : (m,) float, mm, descending; what each takes of a capacity, kerf included
    demands : (m,) int, how many of each are needed, at least 1
    capacities : (s,) float, mm; each size fits at least one
    costs : (s,) int, in any unit, at least 0
    limits : (s,) int, how many of each stock there are; at most as many as there are pieces
    """

    sizes: FloatArray
    demands: IntArray
    capacities: FloatArray
    costs: IntArray
    limits: IntArray

    @property
    def pieces(self) -> int:
        """How many pieces are to be cut."""
        return int(self.demands.sum())

    def joined(self, classes: IntArray) -> CuttingProblem:
        """Return the problem of fewer sizes: each is the largest of its class.

        Parameters
        ----------
        classes : (m,) int, ascending from 0
        """
        _, first = np.unique(classes, return_index=True)
        return replace(
            self,
            sizes=self.sizes[first],
            demands=np.add.reduceat(self.demands, first),
        )


@dataclass(frozen=True, eq=False)
class CuttingSolution:
    """Patterns that cut as much of the demands as was found possible.

    Attributes
    ----------
    stocks : (b,) int, which stock each pattern is cut from
    patterns : (b, m) int, pieces of each size; together they never exceed the demands
    missing : (m,) int, demands that found no place
    cost : int, of the stock used
    bound : int, no solution without missing pieces costs less
    """

    stocks: IntArray
    patterns: IntArray
    missing: IntArray
    cost: int
    bound: int

    @property
    def _rank(self) -> tuple[int, int, int]:
        return int(self.missing.sum()), self.cost, len(self.stocks)

    def better(self, other: CuttingSolution) -> bool:
        """Tell whether this misses fewer pieces than another, costs less or uses less stock."""
        return self._rank < other._rank


def whole_costs(costs: Sequence[float]) -> tuple[IntArray, Fraction]:
    """Return costs, to a millionth, as whole multiples of their largest common unit, and that."""
    millionths = [round(float(cost) * 10**6) for cost in costs]
    unit = math.gcd(*millionths) or 1
    return np.array([cost // unit for cost in millionths], dtype=np.int64), Fraction(unit, 10**6)
