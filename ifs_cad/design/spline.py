"""B-splines and NURBS as iterated curves: exact at every iteration depth.

Any polynomial curve is self-similar: stretch a part of it to full length, and the same basis
describes it. So with the control points of one span of a B-spline as they are, the control points
of its k-th part, over the span's own knots shrunk into the part, are fixed mixtures of them: the
blossom at those knots. That is T_k, for any knots and any number N of transformations. For
uniform knots it is the spline's refinement (the two-scale relation), and neighbouring parts share
columns; for knots that repeat 0, .., 0, 1, .., 1 it is de Casteljau's scheme. In homogeneous
coordinates the same holds for rational splines (NURBS).

A spline of several spans is one IFS when its parts have their knots where the whole has: scaled to
run from 0 to 1, each inner knot x must go to another one, N x mod 1, at least as often repeated,
or to an end. Equal spans do for every N; the knot at 1/3 alone does for N = 3 but not for N = 2.
Knots beyond the ends are free. All other splines are taken a span at a time.

A spline that does not start and end at control points has no columns that can be moved one by one:
its ends would move apart. `interpolating=True` gives the same curve over clamped ends, with other
control points, where every subdivision point between the ends is free.

Source: the paper, section 3.1; Boehm and Prautzsch on knots and blossoms.
"""

from __future__ import annotations

import numpy as np

from ifs_cad.design.blossom import knot_change
from ifs_cad.design.curve import Curve
from ifs_cad.design.reading import read_points, read_weights, whole_number
from ifs_cad.design.transform import Scheme
from ifs_cad.errors import ContinuityError, InputError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import ArrayLike, FloatArray

__all__ = ["clamped_knots", "spline", "spline_scheme", "spline_segment", "uniform_knots"]


def uniform_knots(degree: int, count: int) -> FloatArray:
    """Return (count + degree + 1,) knots one apart; the curve runs from 0 to count - degree."""
    _read_sizes(degree, count)
    return np.arange(-degree, count + 1, dtype=float)


def clamped_knots(degree: int, count: int) -> FloatArray:
    """Return (count + degree + 1,) knots one apart, repeated at the ends: the usual in CAD.

    The curve starts and ends at its first and last control point.
    """
    return np.clip(uniform_knots(degree, count), 0.0, count - degree)


def spline(
    degree: int,
    control_points: ArrayLike,
    knots: ArrayLike | None = None,
    *,
    weights: ArrayLike | None = None,
    closed: bool = False,
    interpolating: bool = False,
    depth: int = 4,
    transformations: int = 2,
    tol: Tolerance = DEFAULT,
) -> Curve:
    """Return a B-spline or NURBS curve of any number of spans as one iterated curve.

    Parameters
    ----------
    degree : int
        At least 1.
    control_points : (n, 2) or (n, 3) array, mm
        More than `degree`; closed curves need 3.
    knots : (n + degree + 1,) array, optional
        Never falling; the curve runs from knot number `degree` to number n, from 0. By default
        `clamped_knots`; a closed curve has uniform ones.
    weights : (n,) array, optional
        1 by default.
    closed : bool
        A periodic curve, as smooth where it closes as anywhere.
    interpolating : bool
        The same curve over the control points of clamped ends, so that subdivision points can be
        moved.
    depth, transformations, tol
        See `Curve`.

    Returns
    -------
    Curve
        Its point number i is that of the spline at share i / N^depth of its parameters.

    Raises
    ------
    InputError
        Too few points, knots that fall or do not fit in number, or knots that do not make one IFS
        (see the module).
    ContinuityError
        An inner knot repeated more often than the degree.
    """
    points = read_points(control_points, "Control points")
    shares = read_weights(weights, len(points))
    if closed:
        if knots is not None:
            raise InputError("A closed spline has uniform knots; leave the knots out.")
        if len(points) < 3:
            raise InputError(f"A closed spline needs at least 3 control points, got {len(points)}.")
        around = np.arange(len(points) + whole_number(degree, "The degree of a spline", 1))
        own = uniform_knots(degree, len(around))
        around %= len(points)
    else:
        around = np.arange(len(points))
        given = clamped_knots(degree, len(points)) if knots is None else knots
        own = _read_knots(degree, given, len(points), tol)
    if interpolating:
        own, points, shares = _clamped(degree, own, points[around], shares[around])
        points, shares = (points[:-1], shares[:-1]) if closed else (points, shares)
    return Curve(
        points,
        weights=shares,
        closed=closed,
        scheme=spline_scheme(degree, own, transformations, tol=tol),
        depth=depth,
        tol=tol,
    )


def spline_segment(
    degree: int,
    control_points: ArrayLike,
    knots: ArrayLike,
    span: int = 0,
    *,
    weights: ArrayLike | None = None,
    interpolating: bool = False,
    depth: int = 4,
    transformations: int = 2,
    tol: Tolerance = DEFAULT,
) -> Curve:
    """Return one span of a B-spline or NURBS curve, over any knots, as an iterated curve.

    Parameters
    ----------
    degree, control_points, knots, weights
        Of the whole spline; see `spline`.
    span : int
        Among the spans of the curve that are not empty, from 0, or from the end with -1.
    interpolating : bool
        The control points of the span's Bezier form instead of the degree + 1 that shape it in
        the spline. The only difference is which points the designer holds.
    depth, transformations, tol
        See `Curve`.

    Returns
    -------
    Curve
        Its point number i is that of the spline at share i / N^depth of the span.

    Raises
    ------
    InputError
        As `spline`, but for the self-similarity of the knots; or a span that there is not.
    ContinuityError
        An inner knot repeated more often than the degree; or neighbouring spans that differ more
        than a thousandfold, for which numbers are too short: take `interpolating`.
    """
    points = read_points(control_points, "Control points")
    shares = read_weights(weights, len(points))
    whole = _read_knots(degree, knots, len(points), tol)
    filled = np.flatnonzero(np.diff(whole[degree : len(points) + 1]) > 0)
    number = whole_number(span, "The span", -len(filled), len(filled) - 1)
    start = int(filled[number])
    own = whole[start : start + 2 * degree + 2]
    shaping = slice(start, start + degree + 1)
    return spline(
        degree,
        points[shaping],
        own,
        weights=shares[shaping],
        interpolating=interpolating,
        depth=depth,
        transformations=transformations,
        tol=tol,
    )


def spline_scheme(
    degree: int, knots: ArrayLike, transformations: int = 2, *, tol: Tolerance = DEFAULT
) -> Scheme:
    """Return the scheme that splits splines over given knots into N equal parts.

    Column j of T_k is the blossom at the knots j+1 to j+degree shrunk into part k. Columns at the
    same knots are one column, shared.

    Parameters
    ----------
    degree : int
    knots : (n + degree + 1,) array
    transformations : int
        N.

    Returns
    -------
    Scheme
        For n control points.

    Raises
    ------
    InputError, ContinuityError
        See `spline`.
    """
    count = whole_number(transformations, "The number of transformations", 2)
    own = _read_knots(degree, knots, np.size(knots) - degree - 1, tol)
    size = len(own) - degree - 1
    start, end = own[degree], own[size]
    _require_one_system(own[degree + 1 : size], start, end, count, tol)
    joints = np.linspace(start, end, count + 1)
    inner = start + (own - start + np.arange(count)[:, None] * (end - start)) / count
    # at the joints of the parts exactly, so that neighbours find their common column
    parts = np.where(own == start, joints[:-1, None], inner)
    parts = np.where(own == end, joints[1:, None], parts)
    windows = np.arange(size)[:, None] + np.arange(1, degree + 1)
    marks = np.round((parts[:, windows] - start) / ((end - start) * tol.barycentric))
    _, first, layout = np.unique(
        marks.reshape(count * size, degree), axis=0, return_index=True, return_inverse=True
    )
    order = np.argsort(first)
    rows = np.concatenate([knot_change(degree, own, part) for part in parts])
    columns, places = rows[first[order]], np.argsort(order)[layout.reshape(count, size)]
    fixed = np.zeros(len(columns), dtype=bool)
    for place, unit in ((places[0, 0], 0), (places[-1, -1], -1)):
        fixed[place] = columns[place, unit] == 1.0
    names = tuple(f"s{number + 1}" for number in first[order])
    return Scheme(columns, places, fixed, names, tol)


def _clamped(
    degree: int, knots: FloatArray, points: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return knots with repeated ends, and the control points and weights over them."""
    start, end = knots[degree], knots[len(points)]
    inner = knots[(knots > start) & (knots < end)]
    clamped = np.concatenate([np.full(degree + 1, start), inner, np.full(degree + 1, end)])
    rows = knot_change(degree, knots, clamped)
    mixed = rows @ weights
    return clamped, rows @ (weights[:, None] * points) / mixed[:, None], mixed


def _read_sizes(degree: int, count: int) -> None:
    whole_number(degree, "The degree of a spline", 1)
    if count <= degree:
        raise InputError(
            f"A spline of degree {degree} needs at least {degree + 1} control points, got {count}."
        )


def _read_knots(degree: int, value: ArrayLike, count: int, tol: Tolerance) -> FloatArray:
    """Read the knots of a spline of `count` control points."""
    _read_sizes(degree, count)
    try:
        knots = np.array(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(f"Knots must be numbers: {error}.") from error
    if knots.shape != (count + degree + 1,):
        raise InputError(
            f"{count} control points of degree {degree} need {count + degree + 1} knots, got "
            f"shape {knots.shape}."
        )
    if not np.isfinite(knots).all() or (np.diff(knots) < 0).any():
        raise InputError("Knots must be finite and never fall.")
    start, end = knots[degree], knots[count]
    if not end > start:
        raise InputError(
            f"The curve runs from knot {degree} to knot {count}, which are both {start:g}; spread "
            "the knots."
        )
    inner = knots[(knots > start) & (knots < end)]
    values, times = np.unique(inner, return_counts=True)
    if len(values) and times.max() > degree:
        raise ContinuityError(
            f"The knot {values[times.argmax()]:g} is repeated {times.max()} times, which tears a "
            f"curve of degree {degree}; repeat it at most {degree} times."
        )
    return knots


def _require_one_system(
    inner: FloatArray, start: float, end: float, count: int, tol: Tolerance
) -> None:
    """Raise unless all parts have their knots where the whole has."""
    values, times = np.unique(
        (inner[(inner > start) & (inner < end)] - start) / (end - start), return_counts=True
    )
    image = values * count % 1.0
    at_joint = np.minimum(image, 1.0 - image) <= tol.barycentric
    same = np.abs(image[:, None] - values) <= tol.barycentric
    missing = ~at_joint & ~(same & (times >= times[:, None])).any(axis=1)
    if missing.any():
        number = int(missing.argmax())
        raise InputError(
            f"A spline over these knots is not one IFS of {count} transformations: the inner knot "
            f"at share {values[number]:.6g} of the curve would need another at "
            f"{image[number]:.6g}, repeated {times[number]} times. Take equal spans, or one span "
            "with spline_segment."
        )
