"""The one-dimensional cutting stock problem: which sizes are cut together from which stock.

Columns (patterns) are generated as Gilmore and Gomory do: the linear program over the patterns
known so far prices the sizes, a knapsack over these prices finds the patterns that would lower it.
Any prices give a lower bound (Farley). The integer solution is the best of first fit and best fit
decreasing, of filling one board after the other as well as can be, of a dive (take the patterns
that the linear program likes most, solve it for what is left, and so on) and of the integer
program over all patterns found.

Terms
-----
pattern : how many of each size are cut from one piece of stock.
price : of a size, what the linear program would pay for room for one more piece.

Source: Gilmore and Gomory, *A linear programming approach to the cutting stock problem*, 1961
and 1963; Farley, *A note on bounding a class of linear programming problems*, 1990.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ifs_cad import progress
from ifs_cad.fabrication.boards.cutting_problem import CuttingProblem, CuttingSolution
from ifs_cad.fabrication.boards.knapsack import MOST_CELLS, MOST_CELLS_FOR_BOUND, Grid, Knapsack
from ifs_cad.tolerance import SOLVER, Tolerance
from ifs_cad.types import FloatArray, IntArray

__all__ = ["solve"]

PATTERNS_AT_ONCE = 12
"""Patterns sought with one set of prices; each leaves out the sizes of those before."""

FILL_SHARE, COARSE_SHARE, ROOT_SHARE, DIVE_SHARE, TIE_SHARE = 0.3, 0.5, 0.5, 0.5, 0.1
"""What each step may take of the time that is left: full boards, fewer sizes, the first linear
program, the dive, and, once the cost is proven, fewer pieces of stock at the same cost."""

FEWEST_TO_JOIN, SIZES_IN_CLASS = 64, 4
"""Above so many sizes, that many neighbours are joined to one for a first solution."""

MOST_TO_TRY = 20_000
"""Beginnings of patterns tried before not all patterns are wanted any more."""

LIKED = 0.75
"""A dive rounds up from this fraction on how often the linear program uses a pattern; where that
leaves nothing it takes the one used most."""


def solve(problem: CuttingProblem, time_limit: float, tol: Tolerance) -> CuttingSolution:
    """Cut all pieces at the least cost, and of equal costs from the fewest pieces of stock.

    Parameters
    ----------
    problem : CuttingProblem
    time_limit : float, seconds
    tol : Tolerance

    Returns
    -------
    CuttingSolution
        Proven to be the cheapest when its cost is its bound. Never worse than first fit
        decreasing from any of the stocks.
    """
    return _solved(problem, time.monotonic() + time_limit, tol).best


def _solved(problem: CuttingProblem, end: float, tol: Tolerance) -> _Search:
    """Search until the cost is proven, nothing more can be found, or `end` is past."""
    search = _Search(problem, Grid.of(problem, tol, up=True, cells=MOST_CELLS), tol)
    search.pack(problem.demands, problem.limits, [])
    search.raise_bound(problem.sizes, MOST_CELLS)  # what the material alone demands
    if len(problem.sizes) > FEWEST_TO_JOIN:
        search.fill(_share(end, FILL_SHARE))
    if len(problem.sizes) > FEWEST_TO_JOIN and not search.proven:
        # fewer sizes, each the largest of its class, give good patterns and prices in little time
        classes = np.arange(len(problem.sizes)) // SIZES_IN_CLASS
        coarse = _solved(problem.joined(classes), _share(end, COARSE_SHARE), tol)
        search.take_over(coarse, classes)
    search.generate(problem.demands, problem.limits, _share(end, ROOT_SHARE), root=True)
    search.dive(_share(end, DIVE_SHARE))
    complete = not search.proven and search.add_all()
    search.integer_program(_share(end, TIE_SHARE) if search.proven else end, complete)
    return search


def _share(end: float, share: float) -> float:
    """Return when a share of the time that is left until `end` will be past."""
    now = time.monotonic()
    return now + share * max(end - now, 0.0)


@dataclass(eq=False)
class _Search:
    """The patterns found so far, the best solution and the best bound."""

    problem: CuttingProblem
    grid: Grid  # for patterns
    tol: Tolerance
    bound: int = 0
    prices: FloatArray | None = None  # of the first linear program
    columns: dict[tuple[int, bytes], IntArray] = field(default_factory=dict)
    _best: CuttingSolution | None = None

    @property
    def best(self) -> CuttingSolution:
        assert self._best is not None  # `pack` comes first
        best = self._best
        return CuttingSolution(best.stocks, best.patterns, best.missing, best.cost, self.bound)

    @property
    def proven(self) -> bool:
        return (
            self._best is not None
            and not self._best.missing.any()
            and (self._best.cost == self.bound)
        )

    # Heuristics

    def pack(self, demands: IntArray, limits: IntArray, fixed: list[tuple[int, IntArray]]) -> None:
        """Pack demands by first fit and best fit, and offer the results with what is fixed."""
        problem = self.problem
        per_length = problem.costs / problem.capacities
        by_price = sorted(range(len(limits)), key=lambda s: (per_length[s], s))
        for first in by_price:
            order = [first, *(s for s in by_price if s != first)]
            for best_fit in (False, True):
                self.offer([*fixed, *self._fit(demands, limits, order, best_fit)])

    def _fit(
        self, demands: IntArray, limits: IntArray, order: Sequence[int], best_fit: bool
    ) -> list[tuple[int, IntArray]]:
        """Pack sizes, largest first, into stock opened in a given order."""
        problem, slack = self.problem, self.tol.coincident
        left = limits.copy()
        room = np.full(int(demands.sum()), -np.inf)
        packed: list[tuple[int, IntArray]] = []
        for k in np.flatnonzero(demands).tolist():
            size = problem.sizes[k]
            for _ in range(int(demands[k])):
                fitting = np.flatnonzero(room[: len(packed)] >= size - slack)
                if len(fitting):
                    place = int(fitting[np.argmin(room[fitting])] if best_fit else fitting[0])
                else:
                    stock = next(
                        (s for s in order if left[s] > 0 and problem.capacities[s] >= size - slack),
                        None,
                    )
                    if stock is None:
                        break  # the same size would not fit again
                    left[stock] -= 1
                    place = len(packed)
                    room[place] = problem.capacities[stock]
                    packed.append((stock, np.zeros(len(demands), dtype=np.int64)))
                packed[place][1][k] += 1
                room[place] -= size
        return packed

    def fill(self, end: float) -> None:
        """Offer a solution that puts the largest piece left on a board and fills it best."""
        problem, cells = self.problem, self.grid
        demands, limits = problem.demands.copy(), problem.limits.copy()
        fixed: list[tuple[int, IntArray]] = []
        while demands.any() and not self.proven and time.monotonic() < end:
            first = int(np.argmax(demands > 0))
            usable = (limits > 0) & (cells.capacities >= cells.sizes[first])
            if not usable.any():
                break
            copies = demands - (np.arange(len(demands)) == first)
            knapsack = Knapsack(cells, problem.sizes, copies, with_patterns=True)
            room = np.maximum(cells.capacities - cells.sizes[first], 0)
            per_length = problem.costs / (problem.sizes[first] + knapsack.values[room])
            stock = int(np.argmin(np.where(usable, per_length, np.inf)))
            pattern = knapsack.pattern(int(room[stock]))
            pattern[first] += 1
            times = int((demands[pattern > 0] // pattern[pattern > 0]).min())
            times = min(times, int(limits[stock]))
            demands -= times * pattern
            limits[stock] -= times
            fixed += [(stock, pattern)] * times
        self.pack(demands, limits, fixed)

    def offer(self, chosen: Sequence[tuple[int, IntArray]]) -> None:
        """Keep a solution if it is the best; what it cuts too much is left out."""
        problem = self.problem
        missing = problem.demands.copy()
        stocks, patterns = [], []
        for stock, pattern in chosen:
            needed = np.minimum(pattern, missing)
            if needed.any():
                missing -= needed
                stocks.append(stock)
                patterns.append(needed)
        self._change_for_cheaper(stocks, patterns)
        for stock, pattern in zip(stocks, patterns, strict=True):
            self.add(stock, pattern)
        solution = CuttingSolution(
            np.array(stocks, dtype=np.int64),
            np.array(patterns, dtype=np.int64).reshape(-1, len(missing)),
            missing,
            int(problem.costs[stocks].sum()) if stocks else 0,
            0,
        )
        if self._best is None or solution.better(self._best):
            self._best = solution

    def _change_for_cheaper(self, stocks: list[int], patterns: list[IntArray]) -> None:
        """Cut each pattern from the cheapest stock that it fits and that is left."""
        problem = self.problem
        left = problem.limits - np.bincount(stocks, minlength=len(problem.limits))
        cheapest = np.lexsort([problem.capacities, problem.costs]).tolist()
        for place, pattern in enumerate(patterns):
            for stock in cheapest[: cheapest.index(stocks[place])]:
                if left[stock] > 0 and self.fits(pattern, stock):
                    left[stocks[place]] += 1
                    left[stock] -= 1
                    stocks[place] = stock
                    break

    def fits(self, pattern: IntArray, stock: int) -> bool:
        used = pattern @ self.problem.sizes
        return bool(used <= self.problem.capacities[stock] + self.tol.coincident)

    def add(self, stock: int, pattern: IntArray) -> bool:
        """Remember a pattern; tell whether it was new."""
        key = (stock, pattern.tobytes())
        if key in self.columns:
            return False
        self.columns[key] = pattern
        return True

    def take_over(self, coarse: _Search, classes: IntArray) -> None:
        """Take solution and prices over from the problem of joined sizes."""
        problem, best = self.problem, coarse.best
        pieces = np.repeat(np.arange(len(classes)), problem.demands)
        waiting = [
            list(members) for members in np.split(pieces, np.cumsum(coarse.problem.demands)[:-1])
        ]
        chosen = []
        for stock, pattern in zip(best.stocks.tolist(), best.patterns, strict=True):
            members = [
                waiting[k].pop() for k in np.flatnonzero(pattern) for _ in range(int(pattern[k]))
            ]
            chosen.append((stock, np.bincount(members, minlength=len(classes))))
        self.offer(chosen)
        if coarse.prices is not None:
            for prices in (
                coarse.prices[classes],
                np.interp(problem.sizes, coarse.problem.sizes[::-1], coarse.prices[::-1]),
            ):
                self.raise_bound(prices, MOST_CELLS)
                self._add_patterns(prices, np.zeros(len(problem.costs)), problem.demands)

    # Linear program

    def generate(
        self, demands: IntArray, limits: IntArray, end: float, root: bool = False
    ) -> FloatArray:
        """Add patterns until none lowers the linear program, or `end` is past.

        Returns
        -------
        (columns,) float, how often each pattern is used; none when there was no time
        """
        used = np.zeros(0)
        while not self.proven and time.monotonic() < end:
            program = self._linear_program(demands, limits, end)
            if program is None:
                break
            used, prices, scarcity = program
            if root:
                self.prices = prices
                self.raise_bound(prices, MOST_CELLS)
                progress.report("cutting boards", len(self.columns))
            if not self._add_patterns(prices, scarcity, demands):
                break
        if root and self.prices is not None and not (self.proven or self.grid.exact):
            self.raise_bound(self.prices, MOST_CELLS_FOR_BOUND)
        return used

    def _matrix(self) -> tuple[Any, IntArray]:
        """Return the sparse (m + s, columns) patterns above the stock they use, and that stock."""
        from scipy.sparse import csc_array  # only here: importing it takes longer than the rest

        stocks = np.array([stock for stock, _ in self.columns], dtype=np.int64)
        table = np.array([*self.columns.values()]).reshape(len(stocks), -1)
        rows = np.column_stack([table, stocks[:, None] == np.arange(len(self.problem.costs))])
        return csc_array(rows.astype(float).T), stocks

    def _linear_program(
        self, demands: IntArray, limits: IntArray, end: float
    ) -> tuple[FloatArray, FloatArray, FloatArray] | None:
        """Return use of the patterns, prices of the sizes and of scarce stock; None at `end`."""
        from scipy.optimize import linprog
        from scipy.sparse import block_array, eye_array

        matrix, stocks = self._matrix()
        m = len(demands)
        scale = max(int(self.problem.costs.max()), 1)
        # a piece left over is dearer than all solutions without
        dear = np.full(m, float(self.problem.pieces + 1))
        result = linprog(
            np.concatenate([self.problem.costs[stocks] / scale, dear]),
            A_ub=block_array([[-matrix[:m], -eye_array(m)], [matrix[m:], None]], format="csc"),
            b_ub=np.concatenate([-demands, limits]).astype(float),
            method="highs",
            options={"time_limit": max(end - time.monotonic(), 0.0)},
        )
        if result.status != 0:
            return None
        duals = -scale * np.asarray(result.ineqlin.marginals)
        duals = np.maximum(duals, 0.0)
        return np.asarray(result.x[: len(stocks)]), duals[:m], duals[m:]

    def _add_patterns(self, prices: FloatArray, scarcity: FloatArray, demands: IntArray) -> bool:
        """Add patterns worth more than they cost; tell whether there was any."""
        grid, copies, found = self.grid, demands.copy(), False
        costs = self.problem.costs + scarcity
        worth = costs + self.tol.cost * max(int(self.problem.costs.max()), 1)
        for _ in range(PATTERNS_AT_ONCE):
            knapsack = Knapsack(grid, prices, copies, with_patterns=True)
            gains = knapsack.values[grid.capacities] - worth
            added = np.zeros(len(copies), dtype=bool)
            for stock in np.flatnonzero(gains > 0.0).tolist():
                pattern = knapsack.pattern(int(grid.capacities[stock]))
                if self.add(stock, pattern):
                    added |= pattern > 0
            if not added.any():
                break
            found = True
            copies[added] = 0
        return found

    def raise_bound(self, prices: FloatArray, cells: int) -> None:
        """Raise the bound to what prices of the sizes prove.

        With K_s the most that a pattern of stock s is worth, and any t >= 0, every solution costs
        at least t prices.demands - sum over s of limit_s max(0, t K_s - cost_s). This is concave
        in t with corners where t K_s = cost_s; without limits the first corner is Farley's bound.
        """
        problem = self.problem
        grid = Grid.of(problem, self.tol, up=False, cells=cells)
        knapsack = Knapsack(grid, prices, problem.demands, with_patterns=False)
        # sizes rounded down let too much in; a full board of the dearest size is a limit, too
        full = (problem.capacities + self.tol.coincident) * (prices / problem.sizes).max()
        most = np.minimum(knapsack.values[grid.capacities], full)
        corners = problem.costs[most > 0.0] / most[most > 0.0]
        over = np.maximum(0.0, np.outer(corners, most) - problem.costs)
        proofs = corners * (prices @ problem.demands) - over @ problem.limits
        least = float(proofs.max(initial=0.0))
        self.bound = max(self.bound, math.ceil(least * (1.0 - self.tol.cost)))

    # Integer solutions

    def dive(self, end: float) -> None:
        """Fix the patterns that the linear program likes most, until all demands are met."""
        demands, limits = self.problem.demands.copy(), self.problem.limits.copy()
        fixed: list[tuple[int, IntArray]] = []
        while demands.any() and not self.proven and time.monotonic() < end:
            used = self.generate(demands, limits, end)
            if not len(used):
                return
            columns = [(stock, pattern) for (stock, _), pattern in self.columns.items()]
            times = np.floor(used + (1.0 - LIKED)).astype(np.int64)
            if not times.any():
                times[np.argmax(used)] = 1
            before = len(fixed)
            for k in np.argsort(-used, kind="stable")[: np.count_nonzero(times)].tolist():
                stock, pattern = columns[k]
                for _ in range(int(times[k])):
                    needed = np.minimum(pattern, demands)
                    # what others have taken since is better filled by the next linear program
                    spoilt = len(fixed) > before and (needed < pattern).any()
                    if limits[stock] == 0 or spoilt or not needed.any():
                        break
                    demands -= needed
                    limits[stock] -= 1
                    fixed.append((stock, needed))
            if len(fixed) == before:
                return
            self.pack(demands, limits, fixed)

    def add_all(self) -> bool:
        """Add every pattern that has no room for another piece; tell whether that was few enough.

        Few long sizes have few patterns, and with all of them the integer program is exact.
        """
        problem, slack = self.problem, self.tol.coincident
        tried, found = 0, []
        for stock, capacity in enumerate(problem.capacities.tolist()):
            # how many of the first sizes, and the room behind them
            begun: list[tuple[tuple[int, ...], float]] = [((), capacity)]
            while begun:
                pattern, room = begun.pop()
                tried += 1
                if tried > MOST_TO_TRY:
                    return False
                k = len(pattern)
                if k < len(problem.sizes):
                    size = float(problem.sizes[k])
                    most = min(int(problem.demands[k]), int((room + slack) // size))
                    begun += [((*pattern, n), room - n * size) for n in range(most + 1)]
                    continue
                left = problem.demands > pattern
                if not (left & (problem.sizes <= room + slack)).any():
                    found.append((stock, np.array(pattern, dtype=np.int64)))
        for stock, whole in found:
            self.add(stock, whole)
        return True

    def integer_program(self, end: float, complete: bool) -> None:
        """Choose the best of all patterns found, as far as there is time.

        When they are complete, what this proves is a bound for all solutions.
        """
        from scipy.optimize import Bounds, LinearConstraint, milp

        problem, seconds = self.problem, end - time.monotonic()
        if seconds <= 0.0 or (self.proven and not self._may_use_less()):
            return
        matrix, stocks = self._matrix()
        m, scale = len(problem.demands), max(int(problem.costs.max()), 1)
        # of equal costs the fewest pieces of stock: together they weigh less than one unit
        several = len(problem.costs) > 1
        costs = problem.costs[stocks] + (0.5 / (problem.pieces + 1) if several else 0.0)
        result = milp(
            costs / scale,
            constraints=[
                LinearConstraint(matrix[:m], lb=problem.demands),
                LinearConstraint(matrix[m:], ub=problem.limits),
            ],
            integrality=np.ones(len(stocks)),
            bounds=Bounds(0, np.inf),
            options={"time_limit": seconds, "mip_rel_gap": 0.0},
        )
        if complete and result.mip_dual_bound is not None and np.isfinite(result.mip_dual_bound):
            # costs are whole; what was added for the fewest pieces is less than a half
            least = scale * (result.mip_dual_bound - SOLVER) - 0.5
            self.bound = max(self.bound, math.ceil(least))
        if result.x is not None:
            times = np.rint(result.x).astype(np.int64)
            self.offer(
                [
                    (stock, pattern)
                    for ((stock, _), pattern), n in zip(self.columns.items(), times, strict=True)
                    for _ in range(int(n))
                ]
            )

    def _may_use_less(self) -> bool:
        """Tell whether fewer pieces of stock could do at the same cost."""
        problem = self.problem
        total = problem.sizes @ problem.demands
        fewest = math.ceil(total / problem.capacities.max() * (1.0 - self.tol.cost))
        return len(set(problem.costs.tolist())) > 1 and len(self.best.stocks) > fewest
