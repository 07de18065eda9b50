"""Axonometry: convex solids seen from afar, drawn from the back to the front.

Terms
-----
camera : its axes point to the right, up and back towards whoever looks.
painter's order : solids in an order in which each hides only those before it.

Two solids that share no volume lie on two sides of a face of one of them, nearly always; the side
on which the camera stands is in front. That holds where the order of centres fails, as between the
panels of a steep fold.
"""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass

import numpy as np

from ifs_cad.elements.polyhedron import Polyhedra, offsets, ranges
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import BoolArray, FloatArray, IntArray
from ifs_cad.vectors import cross, dot, unit

_UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class Camera:
    """Where one looks from; all rays are parallel.

    Attributes
    ----------
    axes : (3, 3) float, rows right, up and back, unit vectors
    """

    axes: FloatArray

    @property
    def back(self) -> FloatArray:
        """(3,) float, unit vector towards whoever looks."""
        return np.asarray(self.axes[2])

    def __call__(self, points: FloatArray) -> FloatArray:
        """Return (n, 3) points as they are seen: right, up and near, mm."""
        return np.asarray(points @ self.axes.T)


def camera_at(azimuth: float, elevation: float) -> Camera:
    """Return the camera at an azimuth from the x axis and above the horizon, degrees."""
    turn, lift = math.radians(azimuth), math.radians(elevation)
    level = math.cos(lift)
    return camera_facing(np.array([level * math.cos(turn), level * math.sin(turn), math.sin(lift)]))


def camera_facing(direction: FloatArray, *, tol: Tolerance = DEFAULT) -> Camera:
    """Return the camera that looks against a (3,) direction, z upright; from above, y upright."""
    back = unit(np.asarray(direction, dtype=float))
    right = cross(_UP, back)
    if math.hypot(*right) <= tol.parallel:
        right = np.array([1.0, 0.0, 0.0])
    right = unit(right)
    return Camera(np.array([right, cross(back, right), back]))


def painters_order(solids: Polyhedra, camera: Camera, *, tol: Tolerance = DEFAULT) -> IntArray:
    """Return the (s,) numbers of disjoint convex solids from the back to the front.

    Where solids hide each other in a circle, or are parted by none of their faces, the one whose
    middle is farther away comes first.
    """
    seen = camera(solids.vertices)
    count = len(solids)
    near = centres(solids, seen)[:, 2]
    behind, before = _hidden_pairs(solids, camera, _overlaps(solids, seen), tol)
    hides: list[list[int]] = [[] for _ in range(count)]
    for one, other in zip(behind.tolist(), before.tolist(), strict=True):
        hides[one].append(other)
    return np.array(_sorted_by(hides, np.bincount(before, minlength=count).tolist(), near.tolist()))


def _sorted_by(hides: list[list[int]], hidden: list[int], near: list[float]) -> list[int]:
    """Return solids in an order in which each comes before all it is hidden by, far ones first."""
    ready = [(near[k], k) for k in range(len(near)) if hidden[k] == 0]
    heapq.heapify(ready)
    rest = sorted(range(len(near)), key=lambda k: (near[k], k), reverse=True)
    done = [False] * len(near)
    order: list[int] = []
    while len(order) < len(near):
        if ready:
            _, solid = heapq.heappop(ready)
        else:  # a circle
            solid = rest.pop()
        if done[solid]:
            continue
        done[solid] = True
        order.append(solid)
        for other in hides[solid]:
            hidden[other] -= 1
            if hidden[other] == 0:
                heapq.heappush(ready, (near[other], other))
    return order


def _overlaps(solids: Polyhedra, seen: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the pairs of solids whose boxes overlap on the picture."""
    owner, count = solids.solid_of_vertex, len(solids)
    low, high = np.full((count, 2), np.inf), np.full((count, 2), -np.inf)
    np.minimum.at(low, owner, seen[:, :2])
    np.maximum.at(high, owner, seen[:, :2])
    order = np.argsort(low[:, 0], kind="stable")
    begin = np.arange(1, count + 1)
    end = np.searchsorted(low[order, 0], high[order, 0])
    end = np.maximum(end, begin)
    one = order[np.repeat(np.arange(count), end - begin)]
    other = order[ranges(begin, end)]
    meet = (low[one, 1] < high[other, 1]) & (low[other, 1] < high[one, 1])
    return one[meet], other[meet]


def _hidden_pairs(
    solids: Polyhedra, camera: Camera, pairs: tuple[IntArray, IntArray], tol: Tolerance
) -> tuple[IntArray, IntArray]:
    """Return of each pair that overlaps the one behind and the one before it."""
    one, other = pairs
    other_before, one_before = (np.zeros(len(one), dtype=bool) for _ in range(2))
    for first, second, sense in ((one, other, 1.0), (other, one, -1.0)):
        pair, face = _parting_faces(solids, first, second, tol)
        towards = sense * dot(solids.normals[face], camera.back)
        # an edge-on face parts the two on the picture, as do two faces of opposite verdicts:
        # then both are set, and none hides the other
        other_before[pair[towards > -tol.parallel]] = True
        one_before[pair[towards < tol.parallel]] = True
    ahead, hind = other_before & ~one_before, one_before & ~other_before
    return (
        np.concatenate([one[ahead], other[hind]]),
        np.concatenate([other[ahead], one[hind]]),
    )


def _parting_faces(
    solids: Polyhedra, first: IntArray, second: IntArray, tol: Tolerance
) -> tuple[IntArray, IntArray]:
    """Return for pairs of solids the faces of the first beyond which all of the second lies.

    Returns
    -------
    pairs, faces : (k,) int
    """
    vertices = np.argsort(solids.solid_of_vertex, kind="stable")
    starts = offsets(np.bincount(solids.solid_of_vertex, minlength=len(solids)))
    faces = ranges(solids.solid_offsets[first], solids.solid_offsets[first + 1])
    pair = np.repeat(np.arange(len(first)), np.diff(solids.solid_offsets)[first])
    seconds = second[pair]
    sizes = np.diff(starts)[seconds]
    points = solids.vertices[vertices[ranges(starts[seconds], starts[seconds + 1])]]
    beyond = dot(points, np.repeat(solids.normals[faces], sizes, axis=0))
    beyond -= np.repeat(solids.levels[faces], sizes)
    if len(beyond) == 0:
        return pair, faces
    parts = np.minimum.reduceat(beyond, offsets(sizes)[:-1]) >= -tol.planar
    return pair[parts], faces[parts]


def centres(solids: Polyhedra, points: FloatArray) -> FloatArray:
    """Return the mean of the (v, d) points that belong to the vertices of each solid."""
    owner, count = solids.solid_of_vertex, len(solids)
    sums = [np.bincount(owner, column, count) for column in points.T]
    return np.asarray(np.stack(sums, axis=1) / np.bincount(owner, minlength=count)[:, None])


def faces_seen(solids: Polyhedra, camera: Camera, *, tol: Tolerance = DEFAULT) -> BoolArray:
    """Return the (f,) bools that tell which faces look towards the camera."""
    return np.asarray(dot(solids.normals, camera.back) > tol.parallel)
