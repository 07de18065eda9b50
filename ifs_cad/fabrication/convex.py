"""Convex polygons side by side: how far apart they are, and where one may slide along others.

Two convex polygons keep a gap when, in some direction, the one ends at least the gap before the
other begins. Looking along the outward normals of both finds every gap across edges exactly. At a
corner the true boundary of the forbidden places is an arc; `COMPASS` cuts it short so that at most
8 % of the gap is given away there, and never less than the gap is kept.

Terms
-----
support : how far a polygon reaches in a direction.
forbidden places : the moves of one polygon that bring it closer to another than the gap; convex,
    here as half-planes normal . move < level.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import BoolArray, FloatArray, IntArray

COMPASS = np.array(
    [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]]
) / np.sqrt([[1.0], [2.0]] * 4)
"""(8, 2) float, the unit vectors of the eight points of the compass."""

OPPOSITE = np.arange(-4, 4)
"""Where the opposite points stand in `COMPASS`."""

STEEPEST = 1e-14
"""A half-plane whose normal has a smaller part than this along a line does not bound the line: over
the length of a sheet the two part by less than rounding."""


@dataclass(frozen=True, eq=False)
class Polygons:
    """Convex polygons, counter-clockwise, filled up to the same number of corners.

    Any array shape (..., v, 2); two `Polygons` are compared as numpy broadcasts their shapes.

    Attributes
    ----------
    corners : (..., v, 2) float, mm; the last one is repeated to fill up
    normals : (..., v, 2) float, outward unit vectors of the edges
    levels : (..., v) float, supports in these directions, mm
    compass : (..., 8) float, supports in the directions of `COMPASS`, mm
    """

    corners: FloatArray
    normals: FloatArray
    levels: FloatArray
    compass: FloatArray

    @classmethod
    def of(cls, outlines: Sequence[FloatArray]) -> Polygons:
        """Make (n,) polygons from outlines of (k, 2) points."""
        size = max(len(outline) for outline in outlines)
        filled = np.arange(size)
        corners = np.stack([line[np.minimum(filled, len(line) - 1)] for line in outlines])
        edges = np.roll(corners, -1, axis=-2) - corners
        lengths = np.hypot(edges[..., 0], edges[..., 1])
        empty = (lengths == 0.0)[..., None]
        outward = np.stack([edges[..., 1], -edges[..., 0]], axis=-1)
        # any direction is true of a filled-up corner
        normals = np.where(empty, COMPASS[0], outward / np.where(empty, 1.0, lengths[..., None]))
        return cls(corners, normals, support(corners, normals), support(corners, COMPASS))

    def __getitem__(self, index: Any) -> Polygons:
        """Return some of the polygons, as numpy would index an array of them."""
        arrays = self.corners, self.normals, self.levels, self.compass
        return Polygons(*(array[index] for array in arrays))

    def reshaped(self, *shape: int) -> Polygons:
        """Return the polygons in another array shape."""
        arrays = self.corners, self.normals, self.levels, self.compass
        parts = [a.reshape(*shape, *a.shape[self.levels.ndim - 1 :]) for a in arrays]
        return Polygons(*parts)

    def moved(self, move: FloatArray) -> Polygons:
        """Return the polygons moved by (2,) or (..., 2) float, mm."""
        move = np.asarray(move)[..., None, :]
        return Polygons(
            self.corners + move,
            self.normals,
            self.levels + np.sum(self.normals * move, axis=-1),
            self.compass + np.sum(COMPASS * move, axis=-1),
        )

    @property
    def sizes(self) -> FloatArray:
        """(..., 2) float, length and width of the bounding boxes, mm."""
        return self.compass[..., [0, 2]] + self.compass[..., [4, 6]]

    @property
    def areas(self) -> FloatArray:
        """(...) float, mm2."""
        x, y = np.moveaxis(self.corners - self.corners[..., :1, :], -1, 0)
        following = np.roll(x, -1, axis=-1), np.roll(y, -1, axis=-1)
        return np.asarray(np.sum(x * following[1] - y * following[0], axis=-1) / 2.0)

    def hold(self, points: FloatArray) -> BoolArray:
        """Return which of (..., 2) points lie in one polygon."""
        return np.asarray((points @ self.normals.T <= self.levels).all(axis=-1))


def stacked(polygons: Sequence[Polygons]) -> Polygons:
    """Return (n,) polygons from n single ones of as many corners."""
    return Polygons(
        np.stack([one.corners for one in polygons]),
        np.stack([one.normals for one in polygons]),
        np.stack([one.levels for one in polygons]),
        np.stack([one.compass for one in polygons]),
    )


def support(corners: FloatArray, directions: FloatArray) -> FloatArray:
    """Return (..., e) float, how far (..., v, 2) corners reach in (..., e, 2) directions."""
    return np.asarray((directions @ np.swapaxes(corners, -1, -2)).max(axis=-1))


def forbidden(fixed: Polygons, moving: Polygons, gap: float) -> tuple[FloatArray, FloatArray]:
    """Return the half-planes of all moves that bring polygons closer than a gap to fixed ones.

    Returns
    -------
    normals : (..., e, 2) float
    levels : (..., e) float, mm
    """
    onto_fixed = fixed.levels + support(moving.corners, -fixed.normals)
    onto_moving = support(fixed.corners, -moving.normals) + moving.levels
    sizes = fixed.levels.shape[-1], moving.levels.shape[-1], len(COMPASS)
    normals = np.empty((*onto_fixed.shape[:-1], sum(sizes), 2))
    levels = np.empty(normals.shape[:-1])
    own, other, compass = slice(sizes[0]), slice(sizes[0], -sizes[2]), slice(-sizes[2], None)
    normals[..., own, :], levels[..., own] = fixed.normals, onto_fixed
    normals[..., other, :], levels[..., other] = -moving.normals, onto_moving
    normals[..., compass, :] = COMPASS
    levels[..., compass] = fixed.compass + moving.compass[..., OPPOSITE]
    return normals, levels + gap


def blocked(
    normals: FloatArray,
    levels: FloatArray,
    across: FloatArray,
    axis: int,
    *,
    tol: Tolerance = DEFAULT,
) -> tuple[FloatArray, FloatArray]:
    """Cut forbidden places by lines along an axis.

    Parameters
    ----------
    normals, levels : see `forbidden`
    across : (..., g) float, where the lines lie on the other axis, mm
    axis : 0 for lines along x, 1 for lines along y

    Returns
    -------
    start, end : (..., g) float, mm; where end <= start, nothing on the line is forbidden
    """
    along, aside = normals[..., axis], normals[..., 1 - axis]
    bounds = np.abs(along) > STEEPEST
    scale = 1.0 / np.where(bounds, along, 1.0)
    at_zero, slopes = levels * scale, (np.where(bounds, aside, 0.0) * scale)[..., None]
    slanted = slopes * across[..., None, :]
    end = (np.where(bounds & (along > 0), at_zero, np.inf)[..., None] - slanted).min(axis=-2)
    start = (np.where(bounds & (along < 0), at_zero, -np.inf)[..., None] - slanted).max(axis=-2)
    # a half-plane level with the lines leaves each of them free or not as a whole
    reach = levels / np.where(bounds, 1.0, aside)
    top = np.where(~bounds & (aside > 0), reach, np.inf).min(axis=-1, keepdims=True)
    bottom = np.where(~bounds & (aside < 0), reach, -np.inf).max(axis=-1, keepdims=True)
    slack = tol.coincident / 2.0
    free = (across >= top - slack) | (across <= bottom + slack)
    return np.where(free, np.inf, start), np.where(free, -np.inf, end)


def distances(polygons: Polygons, first: IntArray, second: IntArray) -> FloatArray:
    """Return the exact distances of (k,) pairs of (n,) polygons, mm; 0 or less on overlap.

    Where two overlap, it is minus the least depth seen along the normals of their edges.
    """
    one, other = polygons[first], polygons[second]
    apart = np.maximum(_separation(one, other), _separation(other, one))
    near = np.minimum(_corners_to_edges(one, other), _corners_to_edges(other, one))
    return np.where(apart > 0.0, near, apart)


def _separation(one: Polygons, other: Polygons) -> FloatArray:
    """Return the widest gap seen along the normals of `one`."""
    return np.asarray((-support(other.corners, -one.normals) - one.levels).max(axis=-1))


def _corners_to_edges(one: Polygons, other: Polygons) -> FloatArray:
    """Return the least distance of the corners of `one` from the edges of `other`."""
    starts = other.corners[..., None, :, :]
    edges = np.roll(other.corners, -1, axis=-2)[..., None, :, :] - starts
    offsets = one.corners[..., :, None, :] - starts
    squares = np.sum(edges * edges, axis=-1)
    along = np.sum(offsets * edges, axis=-1) / np.where(squares > 0.0, squares, 1.0)
    rest = offsets - np.clip(along, 0.0, 1.0)[..., None] * edges
    return np.asarray(np.hypot(rest[..., 0], rest[..., 1]).min(axis=(-1, -2)))
