"""Swept cutters: whether a cylinder that moves in a straight line enters a convex solid.

The cylinder keeps its axis while its tip goes from one point to another, so all that it passes
through is convex: the sum of a segment, a piece of its axis and a disc. Two convex bodies are
apart when along some direction one ends before the other begins, and how deep they overlap is the
least that the one must be moved to be apart.

Terms
-----
reach : how far a body extends against a direction, from the origin.
gap : along a direction, what lies between a solid and a sweep; negative where they overlap.

Source: Gilbert, An iterative procedure for computing the minimum of a quadratic form on a convex
set, 1966, for the few pairs whose gap shows along none of the directions tried first. It comes
close slowly where bodies almost touch; a linear program decides those that are left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from ifs_cad.types import BoolArray, FloatArray, IntArray
from ifs_cad.vectors import cross, dot, length

GILBERT_STEPS = 100
"""Steps after which it is left to a linear program whether two bodies can be parted."""

CORNERS = 256
"""Of the polygon that stands around a cutter there: for 20 mm it is less than a micrometre off."""


@dataclass(frozen=True, eq=False)
class Sweeps:
    """Cylinders that move in straight lines without turning.

    Attributes
    ----------
    starts, ends : (n, 3) float, of the tips, mm
    axes : (n, 3) float, unit vectors, from the tip up
    bottoms, tops : (n,) float, where the cylinder begins and ends along its axis, from the tip, mm
    radii : (n,) float, mm
    """

    starts: FloatArray
    ends: FloatArray
    axes: FloatArray
    bottoms: FloatArray
    tops: FloatArray
    radii: FloatArray

    def __len__(self) -> int:
        return len(self.starts)

    def __getitem__(self, which: IntArray | BoolArray) -> Sweeps:
        return Sweeps(*(getattr(self, item.name)[which] for item in fields(self)))

    @property
    def boxes(self) -> tuple[FloatArray, FloatArray]:
        """(n, 3) least and (n, 3) greatest coordinates."""
        low, high = np.minimum(self.starts, self.ends), np.maximum(self.starts, self.ends)
        bottom, top = self.bottoms[:, None] * self.axes, self.tops[:, None] * self.axes
        disc = self.radii[:, None] * _sine(self.axes)
        return low + np.minimum(bottom, top) - disc, high + np.maximum(bottom, top) + disc

    def reach(self, directions: FloatArray) -> FloatArray:
        """Return the least of direction . point of each, (n, ...) for (n, ..., 3) unit vectors."""

        def along(vectors: FloatArray) -> FloatArray:
            shape = (len(self), *(1,) * (directions.ndim - 2), 3)
            return dot(vectors.reshape(shape), directions)

        def spread(values: FloatArray) -> FloatArray:
            return values.reshape(len(self), *(1,) * (directions.ndim - 2))

        cosine = along(self.axes)
        return np.asarray(
            np.minimum(along(self.starts), along(self.ends))
            + np.minimum(spread(self.bottoms) * cosine, spread(self.tops) * cosine)
            - spread(self.radii) * _sine(cosine)
        )

    def furthest(self, directions: FloatArray) -> FloatArray:
        """Return the (n, 3) points where the sweeps reach least along (n, 3) directions."""
        ahead = dot(self.starts, directions) <= dot(self.ends, directions)
        cosine = dot(self.axes, directions)
        height = np.where(cosine >= 0.0, self.bottoms, self.tops)
        level = directions - cosine[:, None] * self.axes
        size = length(level)
        towards = level * (self.radii / np.where(size > 0.0, size, 1.0))[:, None]
        tips = np.where(ahead[:, None], self.starts, self.ends)
        return np.asarray(tips + height[:, None] * self.axes - towards)


def _sine(cosine: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.clip(1.0 - cosine * cosine, 0.0, None)))


@dataclass(frozen=True, eq=False)
class Solids:
    """Convex solids, all with as many corners and normals as the richest: the last are repeated.

    Attributes
    ----------
    corners : (n, v, 3) float, mm
    normals : (n, f, 3) float, outward unit vectors of the faces
    """

    corners: FloatArray
    normals: FloatArray

    @classmethod
    def of(cls, corners: Sequence[FloatArray], normals: Sequence[FloatArray]) -> Solids:
        """Put (k, 3) corners and (m, 3) normals of one or more solids side by side."""
        return cls(_filled(corners), _filled(normals))

    @classmethod
    def boxes(cls, low: FloatArray, high: FloatArray) -> Solids:
        """Return the boxes between (n, 3) least and greatest corners."""
        picks = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, -1).T == 1
        corners = np.where(picks, high[:, None, :], low[:, None, :])
        faces = np.concatenate([np.eye(3), -np.eye(3)])
        return cls(corners, np.broadcast_to(faces, (len(low), 6, 3)))

    def __len__(self) -> int:
        return len(self.corners)


def _filled(rows: Sequence[FloatArray]) -> FloatArray:
    size = max(len(row) for row in rows)
    return np.stack([np.concatenate([row, row[-1:].repeat(size - len(row), 0)]) for row in rows])


def depths(sweeps: Sweeps, solids: Solids, slack: float) -> tuple[IntArray, IntArray, FloatArray]:
    """Return which sweeps enter which solids, and at most how deep.

    Parameters
    ----------
    slack : float, the depth from which an overlap counts, mm

    Returns
    -------
    sweep, solid : (k,) int
    depth : (k,) float, the least along all directions that were tried, mm
    """
    low, high = sweeps.boxes
    least, most = solids.corners.min(axis=1), solids.corners.max(axis=1)
    near = ((low[:, None] < most - slack) & (high[:, None] > least + slack)).all(axis=-1)
    first, second = np.nonzero(near)
    gaps = _widest_gaps(sweeps[first], solids.corners[second], solids.normals[second])
    unclear = gaps < -slack
    first, second, gaps = first[unclear], second[unclear], gaps[unclear]
    gaps = np.maximum(gaps, _corner_gaps(sweeps[first], solids.corners[second]))
    enters = gaps < -slack
    doubtful = enters.copy()
    doubtful[enters] = ~_pierces(sweeps[first[enters]], solids, second[enters], slack)
    enters[doubtful] = ~_parted(sweeps[first[doubtful]], solids.corners[second[doubtful]], slack)
    return first[enters], second[enters], -gaps[enters]


def _pierces(sweeps: Sweeps, solids: Solids, which: IntArray, slack: float) -> BoolArray:
    """Return which of k sweeps have a point of their axes, at either end, within their solids.

    The point is taken halfway up the solid, as near to it as the cylinder reaches.
    """
    corners, normals = solids.corners[which], solids.normals[which]
    levels = np.einsum("kfi,kvi->kfv", normals, corners).max(axis=2)
    middle = corners[..., 2].mean(axis=1)
    rise = np.where(np.abs(sweeps.axes[:, 2]) > slack, sweeps.axes[:, 2], np.inf)
    found = np.zeros(len(sweeps), dtype=bool)
    for tips in (sweeps.starts, sweeps.ends):
        up = np.clip((middle - tips[:, 2]) / rise, sweeps.bottoms, sweeps.tops)
        points = tips + up[:, None] * sweeps.axes
        found |= (np.einsum("kfi,ki->kf", normals, points) < levels - slack).all(axis=1)
    return found


def _widest_gaps(sweeps: Sweeps, corners: FloatArray, normals: FloatArray) -> FloatArray:
    """Return the (k,) widest gaps along the normals of the solids and of the sweeps' own sides."""
    forward = sweeps.ends - sweeps.starts
    side = cross(sweeps.axes, forward)
    size = length(side)[:, None]
    upright = np.broadcast_to([0.0, 0.0, 1.0], side.shape)
    side = np.where(size > 0.0, side / np.where(size > 0.0, size, 1.0), upright)
    ahead = cross(side, sweeps.axes)
    own = np.stack([sweeps.axes, -sweeps.axes, side, -side, ahead, -ahead], axis=1)
    directions = np.concatenate([normals, own], axis=1)
    reached = np.einsum("kfi,kvi->kfv", directions, corners).max(axis=2)
    return np.asarray((sweeps.reach(directions) - reached).max(axis=1, initial=-np.inf))


def _corner_gaps(sweeps: Sweeps, corners: FloatArray) -> FloatArray:
    """Return the (k,) widest gaps along the directions from corners to the axes of the tools."""

    def aside(vectors: FloatArray) -> FloatArray:
        axes = sweeps.axes[:, None]
        return vectors - dot(vectors, axes)[..., None] * axes

    way = aside((sweeps.ends - sweeps.starts)[:, None])
    offsets = aside(corners - sweeps.starts[:, None])
    squares = dot(way, way)
    shares = np.clip(dot(offsets, way) / np.where(squares > 0.0, squares, 1.0), 0.0, 1.0)
    towards = shares[..., None] * way - offsets
    sizes = length(towards)[..., None]
    directions = np.where(sizes > 0.0, towards / np.where(sizes > 0.0, sizes, 1.0), [0.0, 0.0, 1.0])
    reached = np.einsum("kfi,kvi->kfv", directions, corners).max(axis=2, initial=-np.inf)
    return np.asarray((sweeps.reach(directions) - reached).max(axis=1, initial=-np.inf))


def _parted(sweeps: Sweeps, corners: FloatArray, slack: float) -> BoolArray:
    """Return which of k pairs some direction parts up to the slack.

    Gilbert's steps walk to the shortest vector from solid to sweep; each vector on the way is a
    direction to try.
    """
    parted = np.zeros(len(sweeps), dtype=bool)
    vectors = sweeps.starts + sweeps.bottoms[:, None] * sweeps.axes - corners.mean(axis=1)
    for _ in range(GILBERT_STEPS):
        sizes = length(vectors)
        open_ = ~parted & (sizes > slack)
        if not open_.any():
            break
        directions = vectors / np.where(sizes > 0.0, sizes, 1.0)[:, None]
        along = np.einsum("kvi,ki->kv", corners, directions)
        furthest = np.take_along_axis(corners, along.argmax(axis=1)[:, None, None], axis=1)[:, 0]
        points = sweeps.furthest(directions) - furthest
        parted |= open_ & (dot(points, directions) >= -slack)
        steps = points - vectors
        squares = dot(steps, steps)
        shares = np.clip(-dot(vectors, steps) / np.where(squares > 0.0, squares, 1.0), 0.0, 1.0)
        vectors = vectors + shares[:, None] * steps
    for pair in np.flatnonzero(~parted).tolist():
        parted[pair] = _plane_between(sweeps[np.array([pair])], corners[pair], slack)
    return parted


def _plane_between(sweep: Sweeps, corners: FloatArray, slack: float) -> bool:
    """Tell whether a plane lies between (v, 3) corners and one sweep that is thinner by the slack.

    A direction d and a level t are looked for with d . corner <= t - gap and d . point >= t + gap
    for all corners of both bodies, no part of d larger than 1, and the largest gap.
    """
    from scipy.optimize import linprog

    (axis,) = sweep.axes
    across = cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    across /= np.linalg.norm(across)
    turns = np.arange(CORNERS) * (2.0 * np.pi / CORNERS)
    ring = np.outer(np.cos(turns), across) + np.outer(np.sin(turns), cross(axis, across))
    ring *= (sweep.radii[0] - slack) / np.cos(np.pi / CORNERS)
    heights = np.array([sweep.bottoms[0] + slack, sweep.tops[0]])
    tips = np.concatenate([sweep.starts, sweep.ends])
    points = (tips[:, None, None] + heights[:, None, None] * axis + ring).reshape(-1, 3)
    origin = corners.mean(axis=0)
    bodies = np.concatenate(
        [corners - origin, origin - points]
    )  # of the sweep with the sign turned
    sides = np.concatenate([-np.ones(len(corners)), np.ones(len(points))])
    rows = np.column_stack([bodies, sides, np.ones(len(bodies))])
    bounds = [(-1.0, 1.0)] * 3 + [(None, None), (0.0, None)]
    found = linprog([0.0, 0.0, 0.0, 0.0, -1.0], rows, np.zeros(len(rows)), bounds=bounds)
    return bool(found.status == 0 and -found.fun > slack / 10.0)
