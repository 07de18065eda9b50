"""How fast figures settle, and how much space they fill.

Terms
-----
Hausdorff distance : the farthest that a point of one set is from the other set, either way.
similarity dimension : the s of Moran's equation, sum of r_i^s = 1 over the scales of all maps.
open set condition : the parts of some open set lie in it without overlap. Then the Hausdorff
    dimension of the attractor is its similarity dimension; otherwise it can only be smaller.
box-counting dimension : how the number of boxes that meet a set grows as they get smaller.

Source: the paper, section 2.3 (K_n tends to the attractor whatever the germ); Hutchinson 1981 (its
reference 3) for the bounds; Falconer, *Fractal Geometry*, for the dimensions.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from ifs_cad.design.figure import Figure
from ifs_cad.design.germ import Germ
from ifs_cad.design.reading import whole_number
from ifs_cad.design.system import System
from ifs_cad.errors import GeometryError, InputError
from ifs_cad.types import ArrayLike, FloatArray, IntArray, frozen

SHIFTS = 4  # grids tried for each size of box
POINTS_IN_A_BOX = 16  # on average; with fewer, boxes stay empty for want of points
SIZES_IN_AN_OCTAVE = 2
LARGEST_BOX = 1 / 4  # of the extent; larger ones see nothing of a figure
SMALLEST_BOX = 2.0**-20  # of the extent; three numbers of boxes still fit in one integer

__all__ = [
    "BoxCounting",
    "Convergence",
    "box_counting_dimension",
    "germ_distances",
    "hausdorff_distance",
    "similarity_dimension",
    "step_distances",
]


def similarity_dimension(system: System) -> float:
    """Return the dimension s at which the scales of all maps give sum of r_i^s = 1.

    It is the Hausdorff dimension of the attractor where the open set condition holds, as for all
    classics that say so; where parts overlap it is only a bound from above.

    Parameters
    ----------
    system : System
        A figure, or transformations without a germ; similarities all.

    Raises
    ------
    InputError
        Transformations that are no maps of space.
    GeometryError
        A map that is no similarity; box counting estimates there.
    ContractionError
        A map that does not shrink.

    References
    ----------
    Moran 1946; Hutchinson 1981 (the paper's reference 3).
    """
    placed = system.transforms(1)
    if not placed.is_similarity:
        numbers = ", ".join(f"T_{number + 1}" for number in np.flatnonzero(~placed.similar))
        raise GeometryError(
            f"The similarity dimension needs similarities, which these are not: {numbers}. "
            "Estimate with box_counting_dimension."
        )
    system.require_contracting()
    logarithms = np.log(placed.scales)
    if (logarithms == logarithms[0]).all():
        return math.log(system.count) / -float(logarithms[0])
    dimension, change = 0.0, math.inf
    # The sum is convex and falls, so Newton's steps from 0 rise to the root and never pass it.
    while change > np.finfo(float).eps * dimension:
        powers = np.exp(logarithms * dimension)
        change = float((powers.sum() - 1.0) / -(powers @ logarithms))
        dimension += change
    return dimension


@dataclass(frozen=True, eq=False)
class BoxCounting:
    """An estimate of the box-counting dimension.

    Attributes
    ----------
    dimension : float
        Slope of log(counts) against -log(sizes) over the finer half of the sizes.
    error : float
        Standard error of that slope, and by how much it differs from the slope of the coarser
        half: large boxes see the outline of a figure more than what it fills, so slopes drift.
        What smaller boxes than these would tell is not known.
    sizes : (k,) float, mm
        Sides of the boxes.
    counts : (k,) int
        Numbers of boxes that meet the points, the least over a few places of the grid.
    """

    dimension: float
    error: float
    sizes: FloatArray
    counts: IntArray


def box_counting_dimension(points: ArrayLike, sizes: ArrayLike | None = None) -> BoxCounting:
    """Estimate the box-counting dimension of a set from points spread all over it.

    Parameters
    ----------
    points : (..., d) array, mm
        Many: the attractor by the chaos game, or the points of a deep construction step.
    sizes : (k,) array, optional
        Sides of the boxes, mm, at least three different ones, the smallest a millionth (2^-20) of
        the extent. By default from a quarter of the
        extent down by factors of sqrt(2), as long as a box holds 16 points on average.

    Returns
    -------
    BoxCounting

    Raises
    ------
    InputError
        NaN, all points in one place, sizes too few or too small, or points too few to choose sizes
        by.
    """
    rows = _read_set(points)
    extent = float(np.ptp(rows, axis=0).max())
    if extent == 0.0:
        raise InputError("All points are in one place, which has no boxes to count.")
    if sizes is not None:
        chosen = np.unique(np.array(sizes, dtype=float).ravel())[::-1]
        if len(chosen) < 3 or not (chosen >= SMALLEST_BOX * extent).all():
            raise InputError(
                f"Box sizes must be three or more different numbers from {SMALLEST_BOX:.3g} of the "
                f"extent, {SMALLEST_BOX * extent:.3g} mm, got {chosen.tolist()}."
            )
        counts = [_boxes(rows, float(size)) for size in chosen]
    else:
        octaves = math.log2(LARGEST_BOX / SMALLEST_BOX)
        steps = np.arange(octaves * SIZES_IN_AN_OCTAVE) / SIZES_IN_AN_OCTAVE
        chosen, counts = LARGEST_BOX * extent * 0.5**steps, []
        for side in chosen.tolist():
            boxes = _boxes(rows, side)
            if POINTS_IN_A_BOX * boxes > len(rows):
                break
            counts.append(boxes)
        chosen = chosen[: len(counts)]
        if len(counts) < 3:
            raise InputError(
                f"{len(rows)} points are too few to see three sizes of box with "
                f"{POINTS_IN_A_BOX} points each; take more."
            )
    found = np.array(counts, dtype=np.int64)
    across, up, half = -np.log(chosen), np.log(found), len(found) // 2
    coarse, fine = _slope(across[: half + 1], up[: half + 1]), _slope(across[half:], up[half:])
    drift = abs(fine[0] - coarse[0])
    return BoxCounting(fine[0], fine[1] + drift, frozen(chosen), frozen(found))


def hausdorff_distance(a: ArrayLike, b: ArrayLike) -> float:
    """Return the Hausdorff distance of two finite sets of points, exactly.

    Parameters
    ----------
    a, b : (..., d) arrays, mm

    Raises
    ------
    InputError
        No points, NaN, or points of different dimensions.
    """
    from scipy.spatial import cKDTree  # only here: importing it takes longer than all of design

    one, other = _read_set(a), _read_set(b)
    if one.shape[1] != other.shape[1]:
        raise InputError(
            f"The sets must have points of the same dimension, got {one.shape[1]} and "
            f"{other.shape[1]}."
        )
    there = cKDTree(other).query(one)[0].max()
    back = cKDTree(one).query(other)[0].max()
    return float(max(there, back))


@dataclass(frozen=True, eq=False)
class Convergence:
    """Distances measured at several construction steps, and what they cannot exceed.

    Attributes
    ----------
    depths : (k,) int
    distances : (k,) float, mm
    bounds : (k,) float, mm
        The first distance times the contraction factor to the power of the steps.
    factor : float
        The contraction factor of the maps.
    """

    depths: IntArray
    distances: FloatArray
    bounds: FloatArray
    factor: float


def germ_distances(
    figure: Figure, a: Germ | ArrayLike, b: Germ | ArrayLike, depths: Iterable[int]
) -> Convergence:
    """Measure how the figures of two germs come closer to each other.

    Distances are between the points; let `Germ.sampled` stand in for lines and edges.

    Parameters
    ----------
    figure : Figure
        Its own germ plays no part.
    a, b : Germ or (g, d) arrays, mm
        In the plane or in space, as for `Figure.with_germ`.
    depths : iterable of int

    Returns
    -------
    Convergence
        At each depth n the Hausdorff distance of the two K_n is at most that of the germs times
        factor^n.

    Raises
    ------
    InputError
        Weights, with which no factor bounds the distances.
    SizeError
        More points than fit in memory.

    References
    ----------
    The paper, section 2.3 and figure 4: the result does not depend on the germ.
    """
    return _convergence(figure.with_germ(a), figure.with_germ(b), depths)


def step_distances(figure: Figure, depths: Iterable[int]) -> Convergence:
    """Measure how consecutive construction steps K_n and K_{n+1} come closer to each other.

    Parameters
    ----------
    figure : Figure
    depths : iterable of int
        n.

    Returns
    -------
    Convergence
        At each depth the distance is at most that of K_0 and K_1 times factor^n.

    Raises
    ------
    InputError, SizeError
        As `germ_distances`.

    References
    ----------
    The paper, section 2.3: the limit of K_n is the attractor.
    """
    # K_{n+1} is what n steps make of the germ K_1.
    return _convergence(figure, replace(figure, germ=figure.step()), depths)


def _convergence(one: Figure, other: Figure, depths: Iterable[int]) -> Convergence:
    levels = np.array([whole_number(depth, "A depth", 0) for depth in depths], dtype=np.int64)
    factor = one.contraction_factor
    if one.acts_on_space:
        first = hausdorff_distance(one.at_depth(0), other.at_depth(0))
    else:
        # Measured between coordinates, where the factor holds, and then seen through P.
        apart = hausdorff_distance(one.coordinates, other.coordinates)
        first = apart * float(np.linalg.norm(one.seen(one.differences), ord=2))
    distances = [
        hausdorff_distance(one.at_depth(depth), other.at_depth(depth)) for depth in levels.tolist()
    ]
    return Convergence(
        frozen(levels), frozen(np.array(distances)), frozen(first * factor**levels), factor
    )


def _boxes(rows: FloatArray, side: float) -> int:
    """Return the least number of boxes that meet the points, over a few places of the grid."""
    low = rows.min(axis=0)
    least = len(rows)
    for shift in range(SHIFTS):
        # Multiples of irrational numbers, so that no grid falls in with one that the set has.
        offset = np.sqrt([2.0, 3.0, 5.0][: rows.shape[1]]) * (shift + 1) % 1.0
        cells = np.floor((rows - low) / side + offset).astype(np.int64)
        keys = np.ravel_multi_index(cells.T, cells.max(axis=0) + 1)
        least = min(least, len(np.unique(keys)))
    return least


def _slope(x: FloatArray, y: FloatArray) -> tuple[float, float]:
    """Return the slope of the regression line and its standard error."""
    x, y = x - x.mean(), y - y.mean()
    square = float(x @ x)
    slope = float(x @ y) / square
    rest = y - slope * x
    return slope, math.sqrt(float(rest @ rest) / max(len(x) - 2, 1) / square)


def _read_set(value: ArrayLike) -> FloatArray:
    """Read a set of points of any arrangement as (n, d)."""
    points = np.array(value, dtype=float)
    if points.ndim < 2 or points.size == 0:
        raise InputError(f"A set of points must have the shape (..., d), got {points.shape}.")
    if not np.isfinite(points).all():
        raise InputError("The points of a set must be finite.")
    return points.reshape(-1, points.shape[-1])
