"""Conics as iterated curves: arcs, ellipses, parabolas and branches of hyperbolas.

A conic section is a rational quadratic: three control points, the outer two on the conic, the
middle one where their tangents meet, with the weight w. Below 1 it is an ellipse, 1 a parabola,
above 1 a hyperbola. Subdivision keeps it exactly, so every point of the discrete curve lies on the
conic. What turns by 180 degrees or more has no such tangents; it is made of several spans that are
one IFS together (`spline`), a full ellipse as a closed curve.

The points are evenly spread over the parameter, not over the angle. With spans of 90 degrees, the
most by default, the longest segment of a circle is at most 1.18 times the shortest (120 degrees:
1.34); one or two segments a span are equal.

Source: the paper, section 3.4 (weights of control points); Piegl and Tiller, The NURBS Book.
"""

from __future__ import annotations

import math

import numpy as np

from ifs_cad.design.curve import Curve
from ifs_cad.design.reading import whole_number
from ifs_cad.design.spline import spline_scheme
from ifs_cad.errors import InputError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import ArrayLike, FloatArray, vector

FULL_TURN = 360.0
HALF_TURN = 180.0
USUAL_SPAN = 90.0

__all__ = ["arc", "arc_through", "conic", "ellipse", "hyperbola", "parabola"]


def conic(
    start: ArrayLike,
    apex: ArrayLike,
    end: ArrayLike,
    rho: float,
    *,
    depth: int = 4,
    transformations: int = 2,
    tol: Tolerance = DEFAULT,
) -> Curve:
    """Return a conic by its ends, the meeting point of its tangents there, and its fullness.

    Parameters
    ----------
    start, apex, end : (2,) or (3,) floats, mm
    rho : float
        Between 0 and 1: how far the curve rises from the middle of its chord towards the apex.
        Below 1/2 an ellipse, 1/2 a parabola, above it a hyperbola.
    depth, transformations, tol
        See `Curve`.

    Raises
    ------
    InputError
        Points that are not finite, or rho out of range.
    """
    share = float(vector([rho], "rho of a conic", 1)[0])
    if not 0.0 < share < 1.0:
        raise InputError(f"rho of a conic must be between 0 and 1, got {share:g}.")
    points = [_point(point, "A point of a conic") for point in (start, apex, end)]
    weights = [1.0, share / (1.0 - share), 1.0]
    return Curve(points, weights=weights, depth=depth, transformations=transformations, tol=tol)


def arc(
    centre: ArrayLike,
    radius: float,
    start: float = 0.0,
    end: float = FULL_TURN,
    *,
    x: ArrayLike = (1.0, 0.0, 0.0),
    y: ArrayLike = (0.0, 1.0, 0.0),
    spans: int | None = None,
    depth: int = 4,
    transformations: int = 2,
    tol: Tolerance = DEFAULT,
) -> Curve:
    """Return a circular arc, or a full circle as a closed curve.

    Parameters
    ----------
    centre : (2,) or (3,) floats, mm
    radius : float, mm
    start, end : float, degrees
        Counter-clockwise from the x direction towards y when `end` is the larger.
    x, y : (3,) floats
        Directions of 0 and about 90 degrees, of any length; the arc lies in their plane. Take
        y = (0, 0, 1) for an upright arc.
    spans : int, optional
        See `ellipse`.
    depth, transformations, tol
        See `Curve`.

    Raises
    ------
    InputError
        A radius that is not positive, parallel directions, and as `ellipse`.
    """
    size = float(vector([radius], "The radius of an arc", 1)[0])
    if not size > 0.0:
        raise InputError(f"The radius of an arc must be positive, got {size:g} mm.")
    first, second = vector(x, "The x direction of an arc"), vector(y, "The y direction of an arc")
    normal = np.cross(first, second)
    lengths = np.linalg.norm(first) * np.linalg.norm(second)
    if not np.linalg.norm(normal) > tol.parallel * lengths:
        raise InputError(f"The directions {first.tolist()} and {second.tolist()} span no plane.")
    second = np.cross(normal, first)
    return ellipse(
        centre,
        size * first / np.linalg.norm(first),
        size * second / np.linalg.norm(second),
        start,
        end,
        spans=spans,
        depth=depth,
        transformations=transformations,
        tol=tol,
    )


def arc_through(
    start: ArrayLike,
    middle: ArrayLike,
    end: ArrayLike,
    *,
    spans: int | None = None,
    depth: int = 4,
    transformations: int = 2,
    tol: Tolerance = DEFAULT,
) -> Curve:
    """Return the circular arc from a point through another to a third.

    Parameters
    ----------
    start, middle, end : (2,) or (3,) floats, mm
    spans, depth, transformations, tol
        See `ellipse`.

    Raises
    ------
    InputError
        Points on one line.
    """
    a, b, c = (_point(point, "A point of an arc") for point in (start, middle, end))
    ab, ac = b - a, c - a
    normal = np.cross(ab, ac)
    square = float(normal @ normal)
    if not square > (tol.parallel**2) * float(ab @ ab) * float(ac @ ac):
        raise InputError(
            f"No arc runs through {a.tolist()}, {b.tolist()} and {c.tolist()}: they lie on a line."
        )
    to_centre = (np.cross(normal, ab) * (ac @ ac) + np.cross(ac, normal) * (ab @ ab)) / (2 * square)
    centre, first = a + to_centre, -to_centre
    second = np.cross(normal, first) / math.sqrt(square)
    far = c - centre
    sweep = math.degrees(math.atan2(far @ second, far @ first)) % FULL_TURN
    return ellipse(
        centre,
        first,
        second,
        0.0,
        sweep,
        spans=spans,
        depth=depth,
        transformations=transformations,
        tol=tol,
    )


def ellipse(
    centre: ArrayLike,
    first: ArrayLike,
    second: ArrayLike,
    start: float = 0.0,
    end: float = FULL_TURN,
    *,
    spans: int | None = None,
    depth: int = 4,
    transformations: int = 2,
    tol: Tolerance = DEFAULT,
) -> Curve:
    """Return the points centre + first cos t + second sin t; a full turn is a closed curve.

    Parameters
    ----------
    centre : (2,) or (3,) floats, mm
    first, second : (2,) or (3,) floats, mm
        Conjugate half-diameters: the half-axes when they are perpendicular.
    start, end : float, degrees
        The angle t; a turn of at most 360, backwards when `end` is the smaller.
    spans : int, optional
        Number of rational quadratics, each of less than 180 degrees; by default as few as stay
        within 90. The curve has 2 spans + 1 control points, a closed one without the last.
    depth, transformations, tol
        See `Curve`.

    Raises
    ------
    InputError
        No turn, one above 360 degrees, or too few spans.
    """
    t = vector([start, end], "The angles of an arc", 2)
    turn = abs(float(t[1] - t[0]))
    closed = abs(turn - FULL_TURN) <= tol.rank * FULL_TURN
    if not (closed or 0.0 < turn < FULL_TURN):
        raise InputError(f"An arc turns by more than 0 and at most 360 degrees, got {turn:g}.")
    usual = math.ceil(turn / USUAL_SPAN - tol.rank)
    count = usual if spans is None else whole_number(spans, "The number of spans", 1)
    if turn / count >= HALF_TURN:
        raise InputError(
            f"{count} spans of a turn of {turn:g} degrees have {turn / count:g} each; it must be "
            "less than 180. Take more spans."
        )
    angles = np.radians(np.linspace(t[0], t[1], 2 * count + 1))
    weights = np.ones(2 * count + 1)
    weights[1::2] = math.cos(math.radians(turn / count / 2))
    return _spans(
        _combined(centre, first, second, np.cos(angles) / weights, np.sin(angles) / weights),
        weights,
        closed,
        depth,
        transformations,
        tol,
    )


def hyperbola(
    centre: ArrayLike,
    first: ArrayLike,
    second: ArrayLike,
    start: float,
    end: float,
    *,
    spans: int = 1,
    depth: int = 4,
    transformations: int = 2,
    tol: Tolerance = DEFAULT,
) -> Curve:
    """Return the points centre + first cosh t + second sinh t of one branch.

    Parameters
    ----------
    centre : (2,) or (3,) floats, mm
        Where the asymptotes meet.
    first : (2,) or (3,) floats, mm
        From the centre to the branch's vertex, when perpendicular to `second`.
    second : (2,) or (3,) floats, mm
        The asymptotes run along first + second and first - second.
    start, end : float
        The parameter t, dimensionless.
    spans : int
        Number of rational quadratics; more spread the points more evenly.
    depth, transformations, tol
        See `Curve`.

    Raises
    ------
    InputError
        Equal parameters, or numbers that are not finite.
    """
    t = _parameters(start, end, "a hyperbola")
    count = whole_number(spans, "The number of spans", 1)
    values = np.linspace(t[0], t[1], 2 * count + 1)
    weights = np.ones(2 * count + 1)
    weights[1::2] = math.cosh((t[1] - t[0]) / count / 2)
    return _spans(
        _combined(centre, first, second, np.cosh(values) / weights, np.sinh(values) / weights),
        weights,
        False,
        depth,
        transformations,
        tol,
    )


def parabola(
    vertex: ArrayLike,
    first: ArrayLike,
    second: ArrayLike,
    start: float,
    end: float,
    *,
    depth: int = 4,
    transformations: int = 2,
    tol: Tolerance = DEFAULT,
) -> Curve:
    """Return the points vertex + first t + second t^2.

    Parameters
    ----------
    vertex : (2,) or (3,) floats, mm
    first, second : (2,) or (3,) floats, mm
        The tangent at the vertex and the axis, when they are perpendicular.
    start, end : float
        The parameter t, dimensionless.
    depth, transformations, tol
        See `Curve`.

    Raises
    ------
    InputError
        Equal parameters, or numbers that are not finite.
    """
    t = _parameters(start, end, "a parabola")
    along = np.array([t[0], (t[0] + t[1]) / 2, t[1]])
    up = np.array([t[0] ** 2, t[0] * t[1], t[1] ** 2])
    points = _combined(vertex, first, second, along, up)
    return Curve(points, depth=depth, transformations=transformations, tol=tol)


def _combined(
    centre: ArrayLike, first: ArrayLike, second: ArrayLike, a: FloatArray, b: FloatArray
) -> FloatArray:
    """Return (n, 3) points centre + a first + b second."""
    middle = _point(centre, "The centre of a conic")
    one, other = (_point(value, "A half-diameter of a conic") for value in (first, second))
    return np.asarray(middle + np.outer(a, one) + np.outer(b, other))


def _spans(
    points: FloatArray,
    weights: FloatArray,
    closed: bool,
    depth: int,
    transformations: int,
    tol: Tolerance,
) -> Curve:
    """Return rational quadratics that follow each other as one curve."""
    count = len(points) // 2
    knots = np.concatenate([[0], np.repeat(np.arange(count + 1), 2), [count]])
    scheme = spline_scheme(2, knots, transformations, tol=tol)
    stop = -1 if closed else None
    return Curve(
        points[:stop], weights=weights[:stop], closed=closed, scheme=scheme, depth=depth, tol=tol
    )


def _point(value: ArrayLike, what: str) -> FloatArray:
    """Read 2 or 3 numbers; points of the plane get z = 0."""
    return vector(np.append(value, 0.0) if np.size(value) == 2 else value, what)


def _parameters(start: float, end: float, what: str) -> FloatArray:
    values = vector([start, end], f"The parameters of {what}", 2)
    if values[0] == values[1]:
        raise InputError(f"The parameters of {what} must differ, got {start:g} twice.")
    return values
