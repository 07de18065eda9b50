"""Boards to buy, and where each piece is cut from them.

Pieces stand one behind the other along a board. The saw takes `kerf` between two neighbours, and
`trim` is cut off at each end of a board first, its own kerf included; so the k pieces on a board
of length S fit when

    sum of the lengths + (k - 1) kerf + 2 trim <= S.

Behind the last piece one more kerf parts it from the rest; where less than a kerf is left there,
the blade takes all of it and there is no rest.

Terms
-----
piece : one length asked for, by its index.
rest : what is left of a board behind its last cut, mm.

Source: section 4.1 (planks from boards of prevalent sizes); see `cutting_stock` for the solver.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ifs_cad import progress
from ifs_cad.design.address import listed
from ifs_cad.errors import InputError, StockError
from ifs_cad.fabrication.boards.cutting_problem import CuttingProblem, CuttingSolution, whole_costs
from ifs_cad.fabrication.boards.cutting_stock import solve
from ifs_cad.fabrication.stock import Board
from ifs_cad.tolerance import DEFAULT, LARGEST_COORDINATE, Tolerance
from ifs_cad.types import ArrayLike, FloatArray, IntArray, number

__all__ = ["CutBoard", "CuttingPlan", "cut_boards"]


@dataclass(frozen=True)
class CutBoard:
    """One board with what is cut from it.

    Attributes
    ----------
    number : int, from 1
    stock : Board
    pieces : tuple of int, indices of the lengths, in the order in which they lie
    starts : tuple of float, mm, where each piece begins
    rest : float, mm, left over behind the last cut
    """

    number: int
    stock: Board
    pieces: tuple[int, ...]
    starts: tuple[float, ...]
    rest: float

    @property
    def name(self) -> str:
        """`board-001` and so on."""
        return f"board-{self.number:03d}"


@dataclass(frozen=True)
class CuttingPlan:
    """All boards to cut; `str()` gives the table.

    Attributes
    ----------
    boards : tuple of CutBoard
        Boards cut alike follow each other.
    lengths : tuple of float, mm, of the pieces
    cost : float
        Price of all boards, or their length in mm when not all prices are known.
    bound : float
        No plan costs less.
    optimal : bool
        It is proven that no plan costs less: cost and bound are equal.
    priced : bool
        Cost and bound are prices; else lengths in mm.
    kerf, trim : float, mm
    """

    boards: tuple[CutBoard, ...]
    lengths: tuple[float, ...]
    cost: float
    bound: float
    optimal: bool
    priced: bool
    kerf: float
    trim: float

    @property
    def waste(self) -> float:
        """Share of the length of all boards that does not end up in a piece, 0 to 1."""
        total = sum(board.stock.length for board in self.boards)
        return 1.0 - sum(self.lengths) / total

    @property
    def gap(self) -> float:
        """Share of the cost by which a cheaper plan might undercut this one, 0 to 1."""
        return 0.0 if self.optimal else 1.0 - self.bound / self.cost

    @property
    def bought(self) -> list[tuple[Board, int]]:
        """Each kind of board that is used, in the order given, and how many of it."""
        counts: dict[Board, int] = {}
        for board in self.boards:
            counts[board.stock] = counts.get(board.stock, 0) + 1
        return [*counts.items()]

    def report(self) -> str:
        """Return a table of the boards to buy, the waste, and how good the plan is."""
        rows = [("pieces", f"{len(self.lengths)}, {sum(self.lengths) / 1000:.2f} m")]
        rows += [
            ("buy" if place == 0 else "", f"{count} x {board.name}, {board.length:g} mm")
            for place, (board, count) in enumerate(self.bought)
        ]
        rests = [board.rest for board in self.boards]
        rows += [
            ("boards", f"{len(self.boards)}"),
            (
                "waste",
                f"{100 * self.waste:.1f} %, longest rest {max(rests):.0f} mm, "
                f"kerf {self.kerf:g} mm, trim {self.trim:g} mm",
            ),
            ("cost" if self.priced else "length", self._shown(self.cost)),
            (
                "lower bound",
                f"{self._shown(self.bound)}: "
                + (
                    "this plan is optimal"
                    if self.optimal
                    else f"at most {100 * self.gap:.1f} % could be saved"
                ),
            ),
        ]
        return "\n".join(f"{name:16}{value}" for name, value in rows)

    def __str__(self) -> str:
        return self.report()

    def _shown(self, cost: float) -> str:
        return f"{cost:.2f}" if self.priced else f"{cost / 1000:.2f} m"


def cut_boards(
    lengths: ArrayLike,
    boards: Sequence[Board],
    *,
    kerf: float = 4.0,
    trim: float = 0.0,
    addresses: Sequence[str] | None = None,
    time_limit: float = 20.0,
    tol: Tolerance = DEFAULT,
) -> CuttingPlan:
    """Plan which piece is cut from which board, at the least price.

    When the price of any board is unknown the total length of the boards is least instead; of
    plans that cost the same, the one with fewest boards that was found is taken.

    Parameters
    ----------
    lengths : (n,) float, mm
        Longest length of each piece.
    boards : sequence of Board
        What may be used, as often as its `count` says; all of one section, which is not looked at.
    kerf : float, mm
        Width of the saw cut.
    trim : float, mm
        Cut off at each end of each board.
    addresses : sequence of str
        Names of the pieces for messages; their numbers, from 0, when None.
    time_limit : float, seconds
        When it is past, the best plan so far is returned, with the bound that is proven.

    Returns
    -------
    CuttingPlan
        Each piece once, no board exceeded; never worse than first fit decreasing. The same input
        gives the same plan unless the time was past.

    Raises
    ------
    InputError
        No pieces, no boards, or numbers that cannot be meant.
    StockError
        Pieces longer than every board, or fewer boards than they need.
    """
    pieces = _read_lengths(lengths)
    names = _read_addresses(addresses, len(pieces))
    boards = tuple(boards)
    kerf, trim = (_at_least_zero(v, what) for v, what in ((kerf, "Kerf"), (trim, "Trim")))
    time_limit = _at_least_zero(time_limit, "Time limit")
    if not boards or len({board.name for board in boards}) < len(boards):
        raise InputError(
            "Boards must be at least one, each with a name of its own, got "
            f"{[board.name for board in boards]}."
        )
    rooms = np.array([board.length for board in boards]) - 2 * trim
    too_long = pieces > rooms.max() + tol.coincident
    if too_long.any():
        longest = boards[int(rooms.argmax())]
        shown = [f"{names[k]} ({pieces[k]:.1f} mm)" for k in np.flatnonzero(too_long)]
        raise StockError(
            f"Longer than every board: {listed(shown)}. The longest board, {longest.name}, leaves "
            f"{rooms.max():.1f} mm. Add longer boards, or divide these pieces.",
            addresses=[names[k] for k in np.flatnonzero(too_long)],
            lengths=pieces[too_long].tolist(),
            longest=float(rooms.max()),
        )

    progress.report("cutting boards")  # then the patterns found, of which no total is known
    useful = np.flatnonzero(rooms >= pieces.min() - tol.coincident)
    boards, rooms = tuple(boards[k] for k in useful), rooms[useful]
    order, offsets = _grouped(pieces, tol)
    prices = [board.price for board in boards if board.price is not None]
    priced = len(prices) == len(boards)
    charged = prices if priced else [board.length for board in boards]
    costs, unit = whole_costs(charged)
    limits = [len(pieces) if board.count is None else board.count for board in boards]
    problem = CuttingProblem(
        sizes=pieces[order[offsets[:-1]]] + kerf,
        demands=np.diff(offsets),
        capacities=rooms + kerf,
        costs=costs,
        limits=np.minimum(limits, len(pieces)),
    )
    solution = solve(problem, time_limit, tol)
    if solution.missing.any():
        _raise_missing(solution, problem, pieces, names, order, offsets, kerf)
    cost = float(sum(charged[stock] for stock in solution.stocks))
    optimal = solution.cost == solution.bound
    return CuttingPlan(
        _laid_out(solution, boards, pieces, order, offsets, kerf, trim),
        tuple(pieces.tolist()),
        cost,
        cost if optimal else float(solution.bound * unit),
        optimal,
        priced,
        kerf,
        trim,
    )


def _read_lengths(lengths: ArrayLike) -> FloatArray:
    try:
        pieces = np.array(lengths, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(f"Lengths must be numbers of mm: {error}.") from error
    if pieces.ndim != 1 or not len(pieces):
        raise InputError(f"Lengths must be a list of at least one, got shape {pieces.shape}.")
    wrong = ~((pieces > 0.0) & (pieces <= LARGEST_COORDINATE))
    if wrong.any():
        raise InputError(
            f"Lengths must be positive and finite; those of pieces "
            f"{listed([str(k) for k in np.flatnonzero(wrong)])} are not."
        )
    return pieces


def _read_addresses(addresses: Sequence[str] | None, count: int) -> tuple[str, ...]:
    names = tuple(map(str, range(count) if addresses is None else addresses))
    if len(names) != count:
        raise InputError(f"Addresses must be one for each of {count} lengths, got {len(names)}.")
    return names


def _at_least_zero(value: float, what: str) -> float:
    size = number(value, what)
    if not (np.isfinite(size) and size >= 0.0):
        raise InputError(f"{what} must be a finite number of at least 0, got {value!r}.")
    return size


def _grouped(pieces: FloatArray, tol: Tolerance) -> tuple[IntArray, IntArray]:
    """Group pieces of equal length, the longest group first.

    Returns
    -------
    order : (n,) int, the pieces, longest first
    offsets : (groups + 1,) int, into `order`; no piece is longer than the first of its group
    """
    order = np.argsort(-pieces, kind="stable")
    falling = pieces[order]
    offsets = [0]
    while offsets[-1] < len(falling):
        shorter = np.searchsorted(-falling, -(falling[offsets[-1]] - tol.coincident), "right")
        offsets.append(int(shorter))
    return order, np.array(offsets, dtype=np.int64)


def _raise_missing(
    solution: CuttingSolution,
    problem: CuttingProblem,
    pieces: FloatArray,
    names: Sequence[str],
    order: IntArray,
    offsets: IntArray,
    kerf: float,
) -> None:
    """Raise StockError for the pieces that found no board."""
    ends = offsets[1:]
    lost = np.concatenate(
        [order[end - n : end] for end, n in zip(ends, solution.missing, strict=True)]
    )
    room = problem.capacities @ problem.limits
    short = problem.sizes @ problem.demands - room
    needed = (
        f"All boards together are {short:.0f} mm too short for all pieces with their kerfs"
        if short > kerf
        else "All boards together are long enough, but no way to cut them was found that serves all"
    )
    raise StockError(
        f"There are not enough boards: {len(lost)} of {len(pieces)} pieces, "
        f"{pieces[lost].sum():.0f} mm in all, found no place: "
        f"{listed([f'{names[k]} ({pieces[k]:.1f} mm)' for k in lost])}. {needed}. Add boards, or "
        "raise their count.",
        addresses=[names[k] for k in lost],
        lengths=pieces[lost].tolist(),
    )


def _laid_out(
    solution: CuttingSolution,
    boards: Sequence[Board],
    pieces: FloatArray,
    order: IntArray,
    offsets: IntArray,
    kerf: float,
    trim: float,
) -> tuple[CutBoard, ...]:
    """Lay the pieces of each pattern on a board, longest first; equal patterns side by side."""
    alike = np.lexsort([*-solution.patterns.T[::-1], solution.stocks])
    waiting = [iter(order[start:end]) for start, end in pairwise(offsets)]
    cut = []
    for place, k in enumerate(alike, 1):
        stock, pattern = boards[solution.stocks[k]], solution.patterns[k]
        members = [
            int(next(waiting[size]))
            for size in np.flatnonzero(pattern)
            for _ in range(pattern[size])
        ]
        cuts = trim + np.cumsum([0.0, *(pieces[members] + kerf)])
        starts, rest = cuts[:-1], max(0.0, stock.length - trim - float(cuts[-1]))
        cut.append(CutBoard(place, stock, tuple(members), tuple(starts.tolist()), rest))
    return tuple(cut)
