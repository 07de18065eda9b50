"""Hypothesis strategies for curves, meshes and shells, shared by the tests.

Lengths in mm. Everything drawn here is a design that somebody could make: what our own code refuses
with a named error is drawn again, so that a test sees only what was accepted. Other exceptions pass
through and fail the test.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from hypothesis import reject
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial import ConvexHull, Delaunay

from ifs_cad.design.curve import Curve
from ifs_cad.design.mesh import Mesh
from ifs_cad.design.surface import vector_sum
from ifs_cad.elements.panel import Shell
from ifs_cad.elements.thicken import thicken
from ifs_cad.errors import IfsCadError, ThicknessError
from ifs_cad.types import FloatArray

# Hypothesis prints dataclasses field by field; these have an InitVar and very long arrays.
for shown in (Mesh, Shell):
    shown._repr_pretty_ = lambda self, printer, cycle: printer.text(repr(self))

thicknesses = st.floats(1.0, 60.0)
panel_sides = st.sampled_from(["outer", "inner", "centre"])
clearances = st.one_of(st.just(0.0), st.floats(0.05, 2.0))


def numbers(shape: Any, low: float, high: float) -> st.SearchStrategy[FloatArray]:
    """Return arrays of floats, without the tiny ones that say nothing about lengths in mm.

    Half of them repeat many elements, which makes flat, parallel and symmetric places.
    """
    grain, elements = (high - low) / 2**20, st.integers(0, 2**20)
    steps = st.one_of(
        arrays(np.int64, shape, elements=elements),
        arrays(np.int64, shape, elements=elements, fill=st.nothing()),
    )
    return steps.map(lambda drawn: low + grain * drawn)


@dataclass(frozen=True)
class WeightedPoints:
    """A discrete curve of points with weights."""

    points: FloatArray
    weights: FloatArray

    @property
    def homogeneous(self) -> FloatArray:
        return np.column_stack([self.weights, self.weights[:, None] * self.points])

    @property
    def word_structure(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        return (), (len(self.points) - 1,)

    def moved(self, by: FloatArray) -> WeightedPoints:
        return WeightedPoints(self.points + by, self.weights)

    def scaled_weights(self, factor: float) -> WeightedPoints:
        return WeightedPoints(self.points, self.weights * factor)


@st.composite
def polylines(draw: Any, along: int, segments: tuple[int, int] = (2, 5)) -> WeightedPoints:
    """Return weighted polylines in space that run along an axis, gently or in strong folds."""
    count = draw(st.integers(*segments)) + 1
    step, fold = draw(st.floats(100, 800)), draw(st.sampled_from([0.05, 0.3, 0.8]))
    spread = draw(st.sampled_from([0.0, 0.05, 0.2]))
    points = draw(numbers((count, 3), -fold, fold))
    points[:, along] += np.arange(count)
    weights = np.exp(draw(numbers(count, -1, 1)) * spread)
    return WeightedPoints(step * points, weights)


@st.composite
def rings(draw: Any, along: int, segments: tuple[int, int] = (4, 7)) -> WeightedPoints:
    """Return closed weighted polylines about an axis, closed in weight too."""
    count = draw(st.integers(*segments))
    spread = draw(st.sampled_from([0.0, 0.05, 0.2]))
    angles = 2 * np.pi * (np.arange(count) + draw(numbers(count, -0.2, 0.2))) / count
    radii = draw(numbers(count, 0.7, 1.3))
    points = np.roll(
        np.stack(
            [radii * np.cos(angles), radii * np.sin(angles), draw(numbers(count, -0.3, 0.3))], 1
        ),
        along + 1,
        axis=1,
    )
    weights = np.exp(draw(numbers(count, -1, 1)) * spread)
    around = np.append(np.arange(count), 0)
    return WeightedPoints(1000 * points[around], weights[around])


@st.composite
def ifs_curves(draw: Any, along: int, depths: tuple[int, int] = (1, 2)) -> Curve:
    """Return iterated curves of random control points, weights, roughness and depth."""
    count = draw(st.integers(2, 4))
    points = draw(numbers((count, 3), -0.4, 0.4))
    points[:, along] += np.arange(count)
    curve = Curve(
        draw(st.floats(200, 1500)) * points,
        weights=np.exp(draw(numbers(count, -0.3, 0.3))),
        depth=draw(st.integers(*depths)),
    )
    return curve.with_roughness(draw(st.floats(-0.3, 0.3))) if count > 2 else curve


def accepted(make: Callable[..., Any], *arguments: Any, **options: Any) -> Any:
    """Return what our code makes of a draw; draw again when it refuses with an error of its own."""
    try:
        return make(*arguments, **options)
    except IfsCadError:
        reject()


@st.composite
def vector_sums(draw: Any) -> Mesh:
    """Return sums of two curves of all kinds, open ones and tubes."""
    first = draw(st.one_of(polylines(0), rings(1), ifs_curves(0)))
    second = draw(st.one_of(polylines(1), ifs_curves(1)))
    return accepted(vector_sum, first, second)


@st.composite
def nearly_exact_sums(draw: Any) -> Mesh:
    """Return even folds summed with a curve that is not quite in a perpendicular plane."""
    count = draw(st.integers(2, 4))
    runs, slopes = draw(numbers(count, 150, 700)), draw(numbers(count, -0.6, 0.6))
    base = np.column_stack([np.cumsum(runs), np.cumsum(runs * slopes)])
    arch = np.column_stack(
        [
            10.0 ** -draw(st.integers(0, 7)) * draw(numbers(count, -100, 100)),
            np.cumsum(draw(numbers(count, 150, 700))),
            draw(numbers(count, -200, 200)),
        ]
    )
    return accepted(vector_sum, even_fold_points(base, draw(st.floats(0.7, 1.5))), arch)


@st.composite
def triangle_meshes(draw: Any) -> Mesh:
    """Return random height fields of triangles; nodes of valence 3 to 8."""
    count = draw(st.integers(3, 5))
    steepness = draw(st.sampled_from([0.05, 0.3, 0.8]))
    rows, columns = np.divmod(np.arange(count**2), count)
    plan = np.stack([rows, columns], axis=1) + draw(numbers((count**2, 2), -0.35, 0.35))
    triangles = Delaunay(plan).simplices
    arms = np.diff(plan[triangles], axis=1)
    area = np.abs(arms[:, 0, 0] * arms[:, 1, 1] - arms[:, 0, 1] * arms[:, 1, 0])
    heights = steepness * draw(numbers(count**2, -1, 1))
    points = 400 * np.column_stack([plan, heights])
    return accepted(Mesh, points, _upward(points, triangles[area > 0.2]))


def _upward(points: FloatArray, triangles: Any) -> Any:
    a, b, c = (points[triangles[:, k], :2] for k in range(3))
    clockwise = (b - a)[:, 0] * (c - a)[:, 1] < (b - a)[:, 1] * (c - a)[:, 0]
    return np.where(clockwise[:, None], triangles[:, ::-1], triangles)


@st.composite
def hexagon_meshes(draw: Any) -> Mesh:
    """Return upper envelopes of random planes, mostly hexagons; all nodes have valence 3.

    The plane of each site is tangent to a paraboloid, moved a little; three neighbouring planes
    meet in a node where the lifted sites have a facet.
    """
    count = draw(st.integers(4, 5))
    rows, columns = np.divmod(np.arange(count**2), count)
    sites = np.stack([columns + 0.5 * (rows % 2), 0.87 * rows], axis=1)
    sites = sites - sites.mean(axis=0) + draw(numbers(sites.shape, -0.15, 0.15))
    levels = draw(numbers(len(sites), -0.05, 0.05)) - (sites**2).sum(axis=1)
    lifted = np.column_stack([sites, -levels])
    hull = ConvexHull(lifted)
    lower = hull.simplices[hull.equations[:, 2] < -1e-3]
    planes = np.column_stack([2 * sites, -np.ones(len(sites))])
    nodes = np.linalg.solve(planes[lower], -levels[lower][..., None])[..., 0]
    rim = {int(i) for edge in _rim(lower) for i in edge}
    polygons = []
    for site in set(range(len(sites))) - rim:
        around = np.flatnonzero((lower == site).any(axis=1))
        apart = nodes[around, :2] - sites[site]
        middle = apart - apart.mean(axis=0)
        polygons.append(around[np.argsort(np.arctan2(middle[:, 1], middle[:, 0]))])
    polygons = [polygon for polygon in polygons if len(polygon) > 2]
    bend = draw(st.sampled_from([0.1, 0.3, 1.0]))
    scale = draw(st.floats(200, 600))
    shape = Mesh if draw(st.booleans()) else lambda *given: Mesh(*given).flipped()
    return accepted(shape, scale * nodes * [1, 1, bend], polygons)


def _rim(triangles: Any) -> list[tuple[int, int]]:
    """Return the edges that belong to one triangle only."""
    seen: dict[tuple[int, int], int] = {}
    for triangle in triangles.tolist():
        for one, other in pairwise([*triangle, triangle[0]]):
            key = (min(one, other), max(one, other))
            seen[key] = seen.get(key, 0) + 1
    return [key for key, times in seen.items() if times == 1]


@st.composite
def fans(draw: Any, valences: tuple[int, int] = (3, 8)) -> Mesh:
    """Return triangles all around one node, folded weakly or strongly."""
    count = draw(st.integers(*valences))
    steepness = draw(st.sampled_from([0.1, 0.5, 1.5]))
    angles = 2 * np.pi * (np.arange(count) + draw(numbers(count, -0.3, 0.3))) / count
    radii, heights = draw(numbers(count, 0.5, 1.5)), steepness * draw(numbers(count, -1, 1))
    ring = np.stack([radii * np.cos(angles), radii * np.sin(angles), heights], axis=1)
    points = 400 * np.vstack([np.zeros(3), ring])
    around = np.arange(count)
    triangles = np.stack([0 * around, 1 + around, 1 + (around + 1) % count], axis=1)
    return accepted(Mesh, points, triangles)


def meshes() -> st.SearchStrategy[Mesh]:
    """Return meshes of every kind."""
    return st.one_of(
        vector_sums(), nearly_exact_sums(), triangle_meshes(), hexagon_meshes(), fans()
    )


@st.composite
def shells(draw: Any, nodes: str = "relief") -> Shell:
    """Return shells of every kind of mesh, side, thickness and clearance, some with a door."""
    mesh = draw(vector_sums() if nodes == "axis" else meshes())
    shell = accepted(
        thicken,
        mesh,
        draw(thicknesses),
        side=draw(panel_sides),
        clearance=draw(clearances),
        nodes=nodes,
    )
    if len(mesh) > 3 and draw(st.integers(0, 3)) == 0:
        doors = st.lists(st.sampled_from(shell.addresses), min_size=1, max_size=3)
        shell = accepted(shell.without, draw(doors))
    return shell


def largest_thickness(mesh: Mesh, **options: Any) -> float:
    """Return the largest thickness that the error names, inf when any fits, 0 when none does."""
    try:
        thicken(mesh, 1e6, **options)
    except ThicknessError as error:
        return float(error.values.get("largest_thickness", 0.0))
    except IfsCadError:
        reject()
    return float("inf")


def even_fold_points(base: Any, slope: float) -> FloatArray:
    """Return a planar (n, 2) base curve, (x, z), folded evenly: (2 n - 1, 3) points in y = 0.

    In closed form: a chord (H, Z) is split at h = (H + Z / slope) / 2, at the rise slope h.
    """
    start, chord = np.asarray(base)[:-1], np.diff(base, axis=0)
    split = (chord[:, 0] + chord[:, 1] / slope) / 2
    folded = np.empty((2 * len(base) - 1, 2))
    folded[::2] = base
    folded[1::2] = start + np.stack([split, slope * split], axis=1)
    return np.column_stack([folded[:, 0], np.zeros(len(folded)), folded[:, 1]])
