"""Blossoms: control points of any part of a polynomial curve, in Bezier and in B-spline form.

The blossom f of a polynomial of degree d takes d numbers in any order, is affine in each, and
gives the polynomial where they are equal. Its values at runs of d knots are the control points:
f(0, .., 0, 1, .., 1) those of the Bezier form, f(t_{i+1}, .., t_{i+d}) those of a B-spline. So the
control points of a part are barycentric combinations of those of the whole, read off by de Boor's
triangular scheme with another number in each of its steps.

Terms
-----
knots : the full vector of n + d + 1 for n control points; the curve runs from t_d to t_n, counted
    from 0.
span : between two neighbouring knots that differ.

Source: the paper, section 3.1, de Casteljau's matrices; Ramshaw, Blossoms are polar forms, 1989.
"""

from __future__ import annotations

import math

import numpy as np

from ifs_cad.types import FloatArray, IntArray

__all__ = ["bezier_columns", "knot_change"]


def bezier_columns(size: int, count: int) -> FloatArray:
    """Return the columns of a Bezier curve split at k/N.

    Entry i of column j of T_k is the coefficient of z^i in ``((1-u) + u z)^(d-j) ((1-v) + v z)^j``
    with d = m-1, u = (k-1)/N, v = k/N: the blossom at d-j times u and j times v.

    Parameters
    ----------
    size : int
        m, number of control points.
    count : int
        N, number of parts.

    Returns
    -------
    (N d + 1, m) float
        Of all parts in their order, each joint once.
    """
    degree = size - 1
    return np.array(
        [
            np.convolve(_bernstein(degree - j, k / count), _bernstein(j, (k + 1) / count))
            for k in range(count)
            for j in range(min(k, 1), size)
        ]
    )


def knot_change(degree: int, knots: FloatArray, wanted: FloatArray) -> FloatArray:
    """Return what mixes the control points of a spline into those over other knots.

    Parameters
    ----------
    degree : int
    knots : (n + degree + 1,) float
        Of the spline as it is.
    wanted : (k + degree + 1,) float
        Of the same curve or a part of it. Within the part, every knot of the spline must be among
        them, as often; else the wanted knots cannot carry the curve, and the result is wrong.

    Returns
    -------
    (k, n) float
        Row j mixes control point j; rows sum to 1.
    """
    number = np.arange(len(wanted) - degree - 1)
    inside = np.flatnonzero(np.diff(wanted[degree : len(number) + 1]) > 0) + degree
    # control point j belongs to spans j to j + d; the middle one reaches least far beyond its ends
    nearest = np.abs(inside - (number[:, None] + degree / 2)).argmin(axis=1)
    span = inside[nearest]
    home = _spans(degree, knots, (wanted[span] + wanted[span + 1]) / 2)
    arguments = wanted[number[:, None] + np.arange(1, degree + 1)]
    return _rows(degree, knots, home, arguments)


def _spans(degree: int, knots: FloatArray, parameters: FloatArray) -> IntArray:
    """Return (k,) int, i with t_i <= t < t_{i+1}; the last span has its end too."""
    last = np.searchsorted(knots, knots[-degree - 1], side="left") - 1
    found = np.searchsorted(knots, parameters, side="right") - 1
    return np.clip(found, degree, last).astype(np.int64)


def _rows(degree: int, knots: FloatArray, spans: IntArray, arguments: FloatArray) -> FloatArray:
    """Return (k, n) rows of the blossoms of given spans at (k, degree) arguments."""
    size = degree + 1
    own = spans[:, None] + np.arange(1 - degree, size)  # the 2 d knots that shape a span
    local = knots[own]
    mixed = np.tile(np.eye(size), (len(spans), 1, 1))
    for step in range(degree):
        left, right = local[:, step:degree], local[:, degree : 2 * degree - step]
        share = ((arguments[:, step, None] - left) / (right - left))[..., None]
        mixed = (1 - share) * mixed[:, :-1] + share * mixed[:, 1:]
    rows = np.zeros((len(spans), len(knots) - size))
    np.put_along_axis(rows, spans[:, None] + np.arange(-degree, 1), mixed[:, 0], axis=1)
    return rows


def _bernstein(degree: int, t: float) -> FloatArray:
    """Return the coefficients of ((1-t) + t z)^degree."""
    i = np.arange(degree + 1)
    binomials = np.array([math.comb(degree, k) for k in range(degree + 1)], dtype=float)
    return np.asarray(binomials * t**i * (1.0 - t) ** (degree - i))
