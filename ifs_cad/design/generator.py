"""Figures from a generator: a chord is replaced by a polyline, and each of its segments likewise.

Source: the paper, section 2.1: the construction of the von Koch curve, figure 3.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ifs_cad.design.affine import homogeneous
from ifs_cad.design.figure import Figure
from ifs_cad.design.germ import Germ
from ifs_cad.design.reading import whole_number
from ifs_cad.errors import DegenerateSegmentError, InputError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import ArrayLike, BoolArray, FloatArray

ComplexArray = NDArray[np.complex128]

__all__ = ["from_generator", "planar_maps"]


def from_generator(
    points: ArrayLike,
    *,
    reversed_parts: Sequence[int] = (),
    mirrored_parts: Sequence[int] = (),
    name: str = "",
    tol: Tolerance = DEFAULT,
) -> Figure:
    """Return the figure whose chord is replaced by a polyline, again and again.

    Parameters
    ----------
    points : (N + 1, 2) array, mm
        The generator. Each of its N segments is the chord of a smaller copy of the whole.
    reversed_parts : sequence of int
        Segments, from 0, along which the copy runs backwards.
    mirrored_parts : sequence of int
        Segments on whose other side the copy stands.
    name : str
    tol : Tolerance

    Returns
    -------
    Figure
        Of similarities; the germ is the chord.

    Raises
    ------
    InputError
        Points that are no polyline in the plane, or numbers of segments that there are not.
    DegenerateSegmentError
        A generator that ends where it starts.

    References
    ----------
    The paper, section 2.1: the construction of the von Koch curve.
    """
    corners = Germ.polyline(points).points
    if corners.shape[1] != 2 or len(corners) < 2:
        raise InputError(
            f"A generator is a polyline of at least 2 points in the plane, got {corners.shape}."
        )
    count = len(corners) - 1
    flags = np.zeros((2, count), dtype=bool)
    for row, numbers in enumerate((reversed_parts, mirrored_parts)):
        for number in numbers:
            flags[row, whole_number(number, "The number of a segment", 0, count - 1)] = True
    places = corners @ np.array([1.0, 1.0j])
    start, chord = places[0], places[-1] - places[0]
    if abs(chord) <= tol.coincident:
        raise DegenerateSegmentError(
            "The generator ends where it starts, so it has no chord to be put in place of."
        )
    first = np.where(flags[0], places[1:], places[:-1])
    turns = np.where(flags[0], -1.0, 1.0) * np.diff(places) / chord
    # A mirrored copy is mirrored in the chord of the whole before it is turned.
    folds = np.where(flags[1], chord / chord.conjugate(), 1.0)
    base = np.where(flags[1], folds * start.conjugate(), start)
    maps = planar_maps(turns * folds, first - turns * base, flags[1])
    return Figure(maps, germ=corners[[0, -1]], name=name, tol=tol)


def planar_maps(
    factors: ComplexArray, moves: ComplexArray, mirrored: BoolArray | None = None
) -> FloatArray:
    """Return the (N, 3, 3) maps z -> factor z + move of the complex plane.

    Parameters
    ----------
    factors, moves : (N,) complex
    mirrored : (N,) bool, optional
        Maps of the conjugate of z instead.
    """
    side = 1.0 if mirrored is None else np.where(mirrored, -1.0, 1.0)
    rows = [factors.real, -factors.imag * side, factors.imag, factors.real * side]
    linear = np.stack(rows, axis=1).reshape(-1, 2, 2)
    return homogeneous(linear, np.stack([moves.real, moves.imag], axis=1))
