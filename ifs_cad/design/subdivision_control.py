"""The paper's subdivision control: which iteration depth a curve is built at.

Each segment of the curve becomes a plank. The longest plank must not be longer than the boards
that there are, and the planks should still render the smooth curve; both get better with the
iteration depth.

Terms
-----
limit : the smooth, or rough, curve that further and further construction steps settle on. It does
    not depend on the germ.
deviation : the largest distance, mm, of the limit from the curve as it is built. Each part of the
    limit is measured from the element with the same word, so a curve that comes close to itself
    does not hide it. Germs and even folds belong to what is built at every depth: of a folded
    curve, the deviation is about the height of its folds.

Source: the paper, section 4.1, figure 14.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ifs_cad.design.curve import DEEPEST, Curve
from ifs_cad.design.limit import enclosure, largest_distance
from ifs_cad.design.reading import whole_number
from ifs_cad.design.size import require_memory
from ifs_cad.errors import ConstraintError, GeometryError, InputError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import FloatArray, number

USUAL_DEEPEST = 10
USUAL_ELEMENTS = 10_000
ARRAYS = 12  # as large as the points of the enclosures, that exist at once per segment

__all__ = ["DepthRow", "SubdivisionReport", "iteration_depths"]


@dataclass(frozen=True)
class DepthRow:
    """What one iteration depth yields.

    Attributes
    ----------
    depth : int
    segments : int
    longest, shortest : float, mm
        Segments; NaN when the curve cannot be built at this depth.
    deviation : float, mm
        No point of the limit is farther from the curve than this: an upper bound, proven up to
        rounding. Infinite when nothing bounds the limit, NaN when the curve cannot be built.
    error : float, mm
        By how much the deviation may be too large. At most `Tolerance.coincident` for smooth
        curves of usual size; more for rough curves, of which very many points may be almost
        equally far away.
    obstacle : str
        Why the curve cannot be built at this depth; else nothing.
    """

    depth: int
    segments: int
    longest: float = math.nan
    shortest: float = math.nan
    deviation: float = math.nan
    error: float = math.nan
    obstacle: str = ""

    def __str__(self) -> str:
        counts = f"{self.depth:5} {self.segments:9}"
        if self.obstacle:
            return f"{counts}  {self.obstacle}"
        return f"{counts} {self.longest:12.3f} {self.shortest:12.3f} {self.deviation:13.4g}"


@dataclass(frozen=True)
class SubdivisionReport:
    """What each iteration depth yields, and which is the first that suffices.

    Printed, it is a table of one line per depth, the chosen one marked.

    Attributes
    ----------
    rows : tuple of DepthRow
        Of the depths 0, 1, 2, ...
    longest, deviation : float or None, mm
        What was asked for.
    remark : str
        A sentence when further construction steps need not settle, or nothing bounds where; else
        nothing.
    tol : Tolerance
        Lengths that exceed what was asked for by at most `tol.coincident` suffice.

    Raises
    ------
    InputError
        No rows.
    ConstraintError
        No depth suffices.
    """

    rows: tuple[DepthRow, ...]
    longest: float | None = None
    deviation: float | None = None
    remark: str = ""
    tol: Tolerance = DEFAULT

    def __post_init__(self) -> None:
        if not self.rows:
            raise InputError("A subdivision report needs at least one depth.")
        if not any(self._suffices(row) for row in self.rows):
            raise ConstraintError(
                f"No iteration depth up to {self.rows[-1].depth} {self._asked}. Allow more, go "
                f"deeper, or change the shape; the depths yield:\n{self}",
                longest=self.longest,
                deviation=self.deviation,
                rows=self.rows,
            )

    @property
    def depth(self) -> int:
        """The smallest depth that can be built and keeps to what was asked for."""
        return self.row.depth

    @property
    def row(self) -> DepthRow:
        """What that depth yields."""
        return next(row for row in self.rows if self._suffices(row))

    def __str__(self) -> str:
        asked = self.longest is not None or self.deviation is not None
        chosen = next((row for row in self.rows if asked and self._suffices(row)), None)
        lines = ["  depth  segments   longest mm  shortest mm  deviation mm"]
        lines += [f"{'>' if row is chosen else ' '} {row}" for row in self.rows]
        return "\n".join([*lines, self.remark] if self.remark else lines)

    @property
    def _asked(self) -> str:
        wishes = []
        if self.longest is not None:
            wishes.append(f"has segments of at most {self.longest:.6g} mm")
        if self.deviation is not None:
            wishes.append(f"deviates by at most {self.deviation:.6g} mm from the limit")
        return " and ".join(wishes) or "can be built"

    def _suffices(self, row: DepthRow) -> bool:
        limits = ((row.longest, self.longest), (row.deviation, self.deviation))
        return not row.obstacle and all(
            most is None or value <= most + self.tol.coincident for value, most in limits
        )


def iteration_depths(
    curve: Curve,
    *,
    longest: float | None = None,
    deviation: float | None = None,
    deepest: int | None = None,
) -> SubdivisionReport:
    """Report what each iteration depth yields, and choose the first that suffices.

    ``curve.with_depth(iteration_depths(curve, longest=4000, deviation=20).depth)`` is the design.

    Parameters
    ----------
    curve : Curve
        At any depth. Its germ and its even fold stay the last construction step.
    longest : float, optional
        Length of the longest board that there is, mm.
    deviation : float, optional
        Largest acceptable distance of the limit from the curve as it is built, mm.
    deepest : int, optional
        The last depth to report; by default 10, less when there would be more than 10000 elements.

    Returns
    -------
    SubdivisionReport
        For each depth the deviation is an upper bound with its own error; see `DepthRow` and
        `limit.largest_distance`.

    Raises
    ------
    InputError
        A length that is not positive, a deviation below 0, or a `deepest` out of range.
    ConstraintError
        No depth suffices; the message has the table.
    SizeError
        More points than fit in memory; refused before any is computed.

    References
    ----------
    The paper, section 4.1: the lengths of the planks on the market, and the smooth rendering.
    """
    longest = None if longest is None else number(longest, "The longest segment")
    deviation = None if deviation is None else number(deviation, "The deviation")
    if longest is not None and not 0.0 < longest < math.inf:
        raise InputError(f"The longest segment must have a length above 0, got {longest:g} mm.")
    if deviation is not None and not 0.0 <= deviation < math.inf:
        raise InputError(f"The deviation must be 0 mm or more, got {deviation:g} mm.")
    scheme = curve.scheme
    if deepest is None:
        deepest = min(USUAL_DEEPEST, int(math.log(USUAL_ELEMENTS, scheme.count)))
    whole_number(deepest, "The deepest iteration", 0, DEEPEST)
    numbers = ARRAYS * 3 * (scheme.size + 2) * curve.with_depth(0).segments
    require_memory(scheme.count, deepest, numbers * np.dtype(float).itemsize)
    corners = enclosure(scheme, curve.projection[0])
    pieces = curve.projection[None]
    rows = []
    for depth in range(deepest + 1):
        if depth:
            pieces = scheme.subdivided(pieces)
        rows.append(_row(curve.with_depth(depth), pieces, corners))
    remark = curve.contraction().warning
    if not remark and any(math.isinf(row.deviation) for row in rows):
        remark = (
            "Nothing bounds the limit where the deviation is infinite: the pieces hardly shrink, "
            "or their weights come too close to 0."
        )
    return SubdivisionReport(tuple(rows), longest, deviation, remark, curve.tol)


def _row(curve: Curve, pieces: FloatArray, corners: FloatArray | None) -> DepthRow:
    """Measure the curve at its depth, of whose elements the control points are given."""
    row = DepthRow(curve.depth, curve.segments)
    try:
        points = curve.points
    except GeometryError as error:
        return replace(row, obstacle=error.message)
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    bound, attained = math.inf, 0.0
    if corners is not None:
        per_element = curve.segments // len(pieces)
        joints = per_element * np.arange(len(pieces))[:, None]
        polylines = points[joints + np.arange(per_element + 1)]
        bound, attained = largest_distance(curve.scheme, corners, pieces, polylines, curve.tol)
    return replace(
        row,
        longest=float(lengths.max()),
        shortest=float(lengths.min()),
        deviation=bound,
        error=bound - attained if math.isfinite(bound) else math.inf,
    )
