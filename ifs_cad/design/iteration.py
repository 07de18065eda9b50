"""The construction tree: P T_i1 T_i2 ... T_in K, a part of it at a time.

A piece of the curve is known by its own m control points. Those of its k-th part are its own times
T_k, so a construction step is one matrix product for all pieces, and any part can be reached
through its word without the rest. Matrix products may be bracketed anywhere: of a word u v, the
control points P T_u are made from the left, the germ's places T_v K from the right, and one
product of the two gives all points at the cost of writing them down.

Source: the paper, section 3.1, equations for PK_n and figure 7.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from operator import index

import numpy as np

from ifs_cad.design.address import (
    Structure,
    format_word,
    is_dotted,
    listed,
    parse_word,
    word_at,
)
from ifs_cad.design.fold import EvenFold
from ifs_cad.design.transform import Scheme
from ifs_cad.errors import AddressError, DegenerateSegmentError, SizeError, WeightError
from ifs_cad.tolerance import DEFAULT, MEMORY_LIMIT, Tolerance
from ifs_cad.types import BoolArray, FloatArray

NUMBERS_PER_SEGMENT = 16  # homogeneous, Euclidean, their differences, and what tests them

__all__ = ["Iteration", "projected"]


@dataclass(frozen=True, eq=False)
class Iteration:
    """Everything that determines a discrete curve, ready to compute any part of it.

    Parameters
    ----------
    projection : (4, m) float
        P, homogeneous control points as columns (w, xw, yw, zw).
    scheme : Scheme
    depth : int
        Number of construction steps.
    germ : (g + 1, m) float
        Barycentric rows.
    fold : EvenFold or None
        A last construction step.
    tol : Tolerance
    """

    projection: FloatArray
    scheme: Scheme
    depth: int
    germ: FloatArray
    fold: EvenFold | None = None
    tol: Tolerance = DEFAULT

    @property
    def structure(self) -> Structure:
        """Radices of a segment's digits: those of the construction steps, and those after them.

        The steps are N, depth times. A germ of several segments and the halves of its fold come
        after them; the fold of a chord germ counts as a construction step.
        """
        steps = (self.scheme.count,) * self.depth
        halves = () if self.fold is None else (2,)
        germ_segments = len(self.germ) - 1
        return (steps + halves, ()) if germ_segments == 1 else (steps, (germ_segments, *halves))

    @property
    def radices(self) -> tuple[int, ...]:
        """Radices of all digits of a segment."""
        steps, tail = self.structure
        return steps + tail

    @property
    def element_segments(self) -> int:
        """Number of segments of one element."""
        return (len(self.germ) - 1) * (1 if self.fold is None else 2)

    def points(self, word: Sequence[int] = ()) -> FloatArray:
        """Return the homogeneous points of the part with a given prefix.

        Parameters
        ----------
        word : sequence of int
            Valid digits, coarsest first; the empty word is the whole curve.

        Returns
        -------
        (k + 1, 4) float, rows (w, xw, yw, zw)

        Raises
        ------
        SizeError
            More points than fit in memory; refused before any is computed.
        WeightError
            A weight along the part is not positive; names the segments.
        FoldError
            The even fold cannot be made; names the segments.
        """
        path = tuple(word[: self.depth])
        self.require_memory(len(path))
        # The end of an element is the start of the next: each joint is kept once.
        rows = self._laid(path, self.germ[:-1], self.germ[-1])
        self._require_positive(rows[:, 0], path)
        if self.fold is not None:
            rows = self.fold.applied(rows, partial(self.named, path, folded=False), self.tol)
        first, count = 0, len(rows) - 1
        for digit, radix in zip(word[self.depth :], self.radices[self.depth :], strict=False):
            count //= radix
            first += digit * count
        return rows[first : first + count + 1]

    def gaps(self) -> FloatArray:
        """Return the distances between the end of each element and the start of the next.

        Returns
        -------
        (N^depth - 1,) float, mm

        Raises
        ------
        SizeError
            More elements than fit in memory; refused before any is computed.
        WeightError
            A weight along the curve is not positive; names the segments.
        """
        self.require_memory()
        self._require_positive(self._laid((), self.germ[:-1], self.germ[-1])[:, 0], ())
        points = projected(self._laid((), self.germ[[0, -1]], self.germ[-1])[:-1])
        return np.asarray(np.linalg.norm(points[2::2] - points[1:-1:2], axis=1))

    def _laid(self, path: tuple[int, ...], rows: FloatArray, last: FloatArray) -> FloatArray:
        """Lay barycentric rows into all pieces below a path, and a last row into the last piece.

        Returns
        -------
        (pieces len(rows) + 1, 4) float, homogeneous
        """
        piece = self.projection
        for digit in path:
            piece = piece @ self.scheme.transformations[digit]
        steps = self.depth - len(path)
        coarse = steps // 2
        pieces = piece[None]
        for _ in range(coarse):
            pieces = self.scheme.subdivided(pieces)
        parts = self.scheme.transformations.swapaxes(1, 2)
        for _ in range(steps - coarse):
            rows = (rows @ parts).reshape(-1, self.scheme.size)
            last = last @ parts[-1]
        pieces = np.ascontiguousarray(pieces.swapaxes(1, 2))  # far faster to multiply than a view
        laid = np.empty((len(pieces) * len(rows) + 1, 4))
        np.matmul(rows, pieces, out=laid[:-1].reshape(len(pieces), len(rows), 4))
        laid[-1] = last @ pieces[-1]
        return laid

    def require_memory(self, known: int = 0) -> None:
        """Raise when the part below a word of `known` digits would not fit in memory.

        Raises
        ------
        SizeError
            Names the greatest depth that fits.
        """
        per_piece = NUMBERS_PER_SEGMENT * self.element_segments * np.dtype(float).itemsize
        # Logarithms, since the count itself may have millions of digits.
        levels, base = self.depth - known, math.log10(self.scheme.count)
        if levels * base + math.log10(per_piece) <= math.log10(MEMORY_LIMIT):
            return
        fits = known + max(0, int(math.log10(MEMORY_LIMIT / per_piece) / base))
        points = _power_of_ten(levels * base + math.log10(self.element_segments))
        gibibytes = _power_of_ten(levels * base + math.log10(per_piece / 2**30))
        raise SizeError(
            f"Depth {self.depth} with {self.scheme.count} transformations makes {points} points "
            f"and would take {gibibytes} GiB; the limit is {MEMORY_LIMIT / 2**30:.3g} GiB. The "
            f"greatest depth that fits is {fits}.",
            depth=self.depth,
            greatest_depth=fits,
        )

    def require_lengths(self, points: FloatArray) -> None:
        """Raise unless all segments of the whole curve have a length.

        Parameters
        ----------
        points : (n + 1, 3) float, mm

        Raises
        ------
        DegenerateSegmentError
            Consecutive points coincide; names the segments.
        """
        # one coordinate clears almost all segments: that in which the curve goes farthest
        middle = points[len(points) // 2]
        axis = int(np.argmax(np.abs(middle - points[0]) + np.abs(points[-1] - middle)))
        close = np.flatnonzero(np.abs(np.diff(points[:, axis])) <= self.tol.coincident)
        apart = np.linalg.norm(points[close + 1] - points[close], axis=1)
        short = np.zeros(len(points) - 1, dtype=bool)
        short[close[apart <= self.tol.coincident]] = True
        if short.any():
            words = self.named((), short)
            raise DegenerateSegmentError(
                f"Segments {listed(words)} have no length: consecutive points coincide. Move the "
                "control or subdivision points apart, or take another depth.",
                addresses=words,
            )

    def digits(self, word: str | Sequence[int]) -> tuple[int, ...]:
        """Read the word of a segment, or a prefix of one.

        Raises
        ------
        AddressError
            Too many digits, or a digit that no transformation has.
        """
        radices = self.radices or (1,)  # a curve of one segment calls it 0
        if isinstance(word, str):
            digits = parse_word(word, is_dotted(radices))
        else:
            digits = tuple(index(digit) for digit in word)
        if len(digits) > len(radices):
            raise AddressError(
                f"{word!r} has {len(digits)} digits; the words of this curve have {len(radices)}.",
                addresses=[str(word)],
            )
        for place, (digit, radix) in enumerate(zip(digits, radices, strict=False)):
            if not 0 <= digit < radix:
                raise AddressError(
                    f"Digit {place + 1} of {word!r} must be from 0 to {radix - 1}.",
                    addresses=[str(word)],
                )
        return digits

    def named(
        self, prefix: tuple[int, ...], chosen: BoolArray, *, folded: bool = True
    ) -> list[str]:
        """Return the addresses of chosen segments of a part, with or without their fold."""
        radices = self.radices if folded or self.fold is None else self.radices[:-1]
        below, dotted = radices[len(prefix) :], is_dotted(radices)
        return [
            format_word((*prefix, *word_at(number, below)), dotted) or "0"
            for number in np.flatnonzero(chosen).tolist()
        ]

    def _require_positive(self, weights: FloatArray, prefix: tuple[int, ...]) -> None:
        least, most = weights.min(), weights.max()
        if not least > self.tol.weight * max(most, -least):
            low = ~(weights > self.tol.weight * np.abs(weights).max())
            words = self.named(prefix, low[1:] | low[:-1], folded=False)
            raise WeightError(
                f"The weight falls to {least:.3g} at segments {listed(words)}; weights "
                "must stay positive along the curve. Raise the weights of the subdivision points "
                "or of the control points there, or move the subdivision points back.",
                addresses=words,
                weight=float(least),
            )


def projected(rows: FloatArray) -> FloatArray:
    """Return the (n, 3) points, mm, of (n, 4) homogeneous rows (w, xw, yw, zw)."""
    points = np.empty((len(rows), 3))
    for axis in range(3):  # twice as fast as one division with the weight spread over a row
        np.divide(rows[:, axis + 1], rows[:, 0], out=points[:, axis])
    return points


def _power_of_ten(exponent: float) -> str:
    """Write 10^exponent readably however large it is."""
    return f"about {10**exponent:,.0f}" if exponent < 15 else f"about 10^{exponent:.0f}"
