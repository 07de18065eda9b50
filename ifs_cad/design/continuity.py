"""Where an iterated curve starts and ends, and whether its parts meet.

The transformations decide it alone: with a and b the fixed points of T_1 and T_N, the curve is in
one piece exactly when T_k b = T_{k+1} a for each k.

Source: the paper, sections 3.1 and 3.3 (continuity as a topological constraint).
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ifs_cad.errors import ContinuityError, InputError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import ArrayLike, FloatArray, frozen

__all__ = ["fixed_ends", "read_germ", "require_closing", "require_continuity"]


def fixed_ends(transformations: FloatArray) -> FloatArray:
    """Return (2, m): a and b, of sum 1, that come nearest to keeping the curve in one piece.

    T_1 may have other fixed points; the joints tell which of them the curve starts at.

    Parameters
    ----------
    transformations : (N, m, m) float
    """
    size = transformations.shape[1]
    zero, unit = np.zeros((size, size)), np.eye(size)
    rows = [
        np.hstack([transformations[0] - unit, zero]),
        np.hstack([zero, transformations[-1] - unit]),
        *(np.hstack([-after, before]) for before, after in pairwise(transformations)),
        np.kron(np.eye(2), np.ones(size)),
    ]
    system = np.vstack(rows)
    wanted = np.zeros(len(system))
    wanted[-2:] = 1.0
    return np.asarray(np.linalg.lstsq(system, wanted)[0].reshape(2, size))


def require_continuity(
    transformations: FloatArray, ends: FloatArray, tol: Tolerance = DEFAULT
) -> None:
    """Raise unless T_1 a = a, T_N b = b and T_k b = T_{k+1} a.

    Parameters
    ----------
    transformations : (N, m, m) float
    ends : (2, m) float
        a and b.

    Raises
    ------
    ContinuityError
        Says which of these does not hold, and by how much.
    """
    count, size = transformations.shape[:2]
    unit = np.eye(size)
    for number, end in ((1, transformations[0]), (count, transformations[-1])):
        if np.linalg.svd(end - unit, compute_uv=False)[-1] > tol.barycentric:
            raise ContinuityError(
                f"T_{number} has no fixed point for the curve to "
                f"{'start' if number == 1 else 'end'} at: it needs the eigenvalue 1."
            )
    a, b = ends
    gaps = {"a is not a fixed point of T_1": transformations[0] @ a - a}
    gaps[f"b is not a fixed point of T_{count}"] = transformations[-1] @ b - b
    for k, (before, after) in enumerate(pairwise(transformations), start=1):
        gaps[f"T_{k} b and T_{k + 1} a are apart"] = before @ b - after @ a
    worst = max(gaps, key=lambda what: float(np.abs(gaps[what]).max()))
    gap = float(np.abs(gaps[worst]).max())
    if gap > tol.barycentric or abs(a.sum() - 1) + abs(b.sum() - 1) > tol.barycentric:
        raise ContinuityError(
            f"These transformations tear the curve: {worst} (by {gap:.3g}, in barycentric "
            "coordinates). Continuity needs T_k b = T_k+1 a for each k, with a and b the fixed "
            f"points of T_1 and T_{count}.",
            gap=gap,
        )


def require_closing(ends: FloatArray, count: int, tol: Tolerance = DEFAULT) -> None:
    """Raise unless a curve closes when its first control points are repeated at the end.

    Parameters
    ----------
    ends : (2, m) float
        a and b.
    count : int
        Number of control points without the repeated ones.

    Raises
    ------
    InputError
    """
    size = ends.shape[1]
    repeated = np.eye(count)[np.arange(size) % count]
    gap = float(np.abs((ends[1] - ends[0]) @ repeated).max())
    if size <= count or gap > tol.barycentric:
        raise InputError(
            f"The scheme is made for {size} control points; repeating the first of {count} does "
            "not close its curve. A Bezier curve needs one more than there are, a uniform B-spline "
            "as many more as its degree."
        )


def read_germ(value: ArrayLike, ends: FloatArray, tol: Tolerance = DEFAULT) -> FloatArray:
    """Read a germ: (g + 1, m) barycentric rows that run from a to b.

    Parameters
    ----------
    ends : (2, m) float
        a and b.

    Raises
    ------
    InputError
        A wrong shape, or NaN.
    ContinuityError
        Rows that start or end elsewhere, so that the elements would not meet.
    """
    germ = np.array(value, dtype=float)
    size = ends.shape[1]
    if germ.ndim != 2 or len(germ) < 2 or germ.shape[1] != size:
        raise InputError(
            f"A germ needs at least 2 rows of {size} barycentric numbers, got shape {germ.shape}."
        )
    if not np.isfinite(germ).all():
        raise InputError("A germ must be finite.")
    gap = float(np.abs(germ[[0, -1]] - ends).max())
    if gap > tol.barycentric:
        raise ContinuityError(
            f"A germ must run from a = {ends[0].tolist()} to b = {ends[1].tolist()}; it is "
            f"{gap:.3g} off.",
            gap=gap,
        )
    return frozen(germ)
