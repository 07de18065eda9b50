"""Hypothesis strategies for sets of affine maps.

Every map is made of its singular values, so how much it stretches is known beforehand.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import strategies as st

from ifs_cad.types import FloatArray

angles = st.floats(-180.0, 180.0)


@st.composite
def rotations(draw: Any, ndim: int) -> FloatArray:
    """Return proper rotations of the plane or of space."""
    matrix = np.eye(ndim)
    for one, other in [(0, 1)] if ndim == 2 else [(0, 1), (1, 2), (0, 1)]:
        turn = np.radians(draw(angles))
        plane = np.eye(ndim)
        plane[[one, one, other, other], [one, other, one, other]] = [
            np.cos(turn),
            -np.sin(turn),
            np.sin(turn),
            np.cos(turn),
        ]
        matrix = matrix @ plane
    return matrix


@st.composite
def affine_maps(
    draw: Any, ndim: int, count: tuple[int, int] = (1, 4), largest: float = 0.9
) -> FloatArray:
    """Return (N, d, d + 1) maps that stretch by at most `largest`; some flatten, some mirror."""
    maps = []
    for _ in range(draw(st.integers(*count))):
        left, right = draw(rotations(ndim)), draw(rotations(ndim))
        stretches = [draw(st.floats(-largest, largest)) for _ in range(ndim)]
        move = [draw(st.floats(-10.0, 10.0)) for _ in range(ndim)]
        maps.append(np.column_stack([left * stretches @ right, move]))
    return np.array(maps)


@st.composite
def similarities(
    draw: Any, ndim: int, count: tuple[int, int] = (2, 4), scales: tuple[float, float] = (0.1, 0.8)
) -> tuple[FloatArray, FloatArray]:
    """Return (N, d, d + 1) similarities, some of them mirrored, and their (N,) scales."""
    number = draw(st.integers(*count))
    factors = np.array([draw(st.floats(*scales)) for _ in range(number)])
    maps = []
    for factor in factors:
        linear = factor * draw(rotations(ndim))
        linear[-1] *= draw(st.sampled_from([-1.0, 1.0]))
        maps.append(np.column_stack([linear, [draw(st.floats(-10.0, 10.0)) for _ in range(ndim)]]))
    return np.array(maps), factors


dimensions = st.sampled_from([2, 3])


def numbers_of(shape: tuple[int, ...], low: float, high: float) -> st.SearchStrategy[FloatArray]:
    """Return arrays of floats."""
    size = int(np.prod(shape))
    drawn = st.lists(st.floats(low, high), min_size=size, max_size=size)
    return drawn.map(lambda numbers: np.array(numbers).reshape(shape))
