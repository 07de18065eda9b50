"""Simulation: what a program takes from a sheet, sampled on a grid of points.

Every point that a cutter passes over is gone. The test of a point is exact, so a point of a
workpiece that is gone is a gouge, whatever the comparison of planes says; between the points
nothing is seen. Volumes are those of the cells around the points.

Terms
-----
layer : the points of one height.
stretch : a piece of a sweep, short enough that the box around it is not mostly empty.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ifs_cad.fabrication.machining.cuts import Cuts
from ifs_cad.fabrication.machining.placed import PlacedSheet
from ifs_cad.fabrication.machining.swept import Sweeps
from ifs_cad.types import BoolArray, FloatArray

GRID = 2.0
"""Distance of the points, mm."""

LAYER = 1.0
"""Largest distance of the layers, mm."""

BESIDE = 1.0
"""All points up to this distance from a workpiece should be gone, mm: at acute corners, and below
the end of a leaning cutter, no more is needed to free it."""

STRETCH = 40.0
"""Largest length of a stretch, mm."""


@dataclass(frozen=True, eq=False)
class Simulation:
    """What is left of a sheet.

    Attributes
    ----------
    removed : float, volume taken from the sheet, mm3
    gouged : (p,) float, volume taken from each workpiece where it has no hole and no stroke, mm3
    left : (p,) float, volume that still holds to the sides of each workpiece, mm3
    """

    removed: float
    gouged: FloatArray
    left: FloatArray


class _Grid:
    """Points of a sheet, and which of them are gone: layers, rows, columns."""

    def __init__(self, sheet: PlacedSheet, grid: float, layer: float) -> None:
        sizes = np.array([sheet.thickness, sheet.width, sheet.length])
        counts = np.ceil(sizes / [layer, grid, grid]).astype(int)
        self.z, self.y, self.x = (
            (np.arange(count) + 0.5) * size / count
            for count, size in zip(counts.tolist(), sizes.tolist(), strict=True)
        )
        self.cell = float(np.prod(sizes / counts))
        self.gone = np.zeros(counts, dtype=bool)

    def box(self, low: FloatArray, high: FloatArray) -> tuple[slice, slice, slice]:
        """Return the points between two corners."""
        x, y, z = (
            slice(*np.searchsorted(points, [low[axis], high[axis]]).tolist())
            for axis, points in enumerate((self.x, self.y, self.z))
        )
        return z, y, x

    def cut(self, sweeps: Sweeps) -> None:
        """Take away all points that cylinders pass over."""
        sweeps = _stretches(sweeps)
        lows, highs = sweeps.boxes
        for k in range(len(sweeps)):
            where = self.box(lows[k], highs[k])
            if all(part.start < part.stop for part in where):
                self.gone[where] |= self._inside(where, sweeps, k)

    def _inside(self, where: tuple[slice, slice, slice], sweeps: Sweeps, k: int) -> BoolArray:
        """Return which points of a box one cylinder passes over.

        A point is inside from when its distance from the axis falls to the radius until it rises
        again; then it must at some time lie above the end of the cutter.
        """
        axis, way = sweeps.axes[k], sweeps.ends[k] - sweeps.starts[k]
        rise = float(way @ axis)
        level = way - rise * axis
        squared = float(level @ level)
        z, y, x = np.ix_(self.z[where[0]], self.y[where[1]], self.x[where[2]])
        start = sweeps.starts[k]
        offset = (x - start[0], y - start[1], z - start[2])

        def along(vector: FloatArray) -> FloatArray:
            return np.asarray(sum(float(vector[i]) * offset[i] for i in range(3)))

        height = along(axis)
        aside = offset[0] ** 2 + offset[1] ** 2 + offset[2] ** 2 - height**2
        room = sweeps.radii[k] ** 2 - aside
        if squared == 0.0:
            return np.asarray((room >= 0.0) & (height >= min(rise, 0.0)))
        middle = along(level) / squared
        spread = middle**2 + room / squared
        half = np.sqrt(np.clip(spread, 0.0, None))
        first, last = np.clip(middle - half, 0.0, 1.0), np.clip(middle + half, 0.0, 1.0)
        meets = (spread >= 0.0) & (middle + half >= 0.0) & (middle - half <= 1.0)
        highest = height - rise * (first if rise > 0.0 else last)
        return np.asarray(meets & (highest >= 0.0))


def _stretches(sweeps: Sweeps) -> Sweeps:
    """Return sweeps cut into stretches of equal length, each."""
    ways = np.linalg.norm(sweeps.ends - sweeps.starts, axis=1)
    counts = np.maximum(np.ceil(ways / STRETCH), 1.0).astype(np.int64)
    owners = np.repeat(np.arange(len(sweeps)), counts)
    places = np.arange(len(owners)) - np.repeat(np.cumsum(counts) - counts, counts)
    whole = sweeps[owners]
    way = (whole.ends - whole.starts) / counts[owners, None]
    starts = whole.starts + places[:, None] * way
    return Sweeps(starts, starts + way, whole.axes, whole.bottoms, whole.tops, whole.radii)


def simulate(
    cuts: Cuts,
    sheet: PlacedSheet,
    makes: BoolArray,
    held: float,
    *,
    grid: float = GRID,
    layer: float = LAYER,
) -> Simulation:
    """Take from a sheet all that the cutters pass over.

    Parameters
    ----------
    cuts : of the whole program
    sheet : PlacedSheet
    makes : (n, p) bool, which motions make holes and strokes of which workpieces
    held : float, height below which workpieces may still hold to the sheet, mm
    grid, layer : float, distances of the points, mm
    """
    # back up its axis a cutter takes nothing new
    low = cuts.steady & (cuts.lowest < sheet.thickness) & (cuts.along_axis != 1)
    inner = makes.any(axis=1)
    points = _Grid(sheet, grid, layer)
    points.cut(_sweeps(cuts, low & ~inner))
    slack = 2.0 * cuts.tol.machined  # sweeps are thinner by one tolerance, planes off by another
    counts = [_compared(points, sheet, piece, held, slack) for piece in range(len(sheet.addresses))]
    gouged, left = points.cell * np.array(counts, dtype=float).reshape(-1, 2).T
    points.cut(_sweeps(cuts, low & inner))
    return Simulation(float(points.gone.sum()) * points.cell, gouged, left)


def _sweeps(cuts: Cuts, which: BoolArray) -> Sweeps:
    # one within tolerance of a workpiece does not gouge it
    _, sweeps = cuts.sweeps(np.flatnonzero(which))
    return Sweeps(
        sweeps.starts,
        sweeps.ends,
        sweeps.axes,
        sweeps.bottoms,
        sweeps.tops,
        sweeps.radii - cuts.tol.machined,
    )


def _compared(
    points: _Grid, sheet: PlacedSheet, piece: int, held: float, slack: float
) -> tuple[int, int]:
    """Return how many points of a workpiece are gone, and how many beside it are not."""
    corners, normals = sheet.solids.corners[piece], sheet.solids.normals[piece]
    where = points.box(corners.min(axis=0) - BESIDE, corners.max(axis=0) + BESIDE)
    z, y, x = np.ix_(points.z[where[0]], points.y[where[1]], points.x[where[2]])
    gone = points.gone[where]
    outside = np.full(gone.shape, -np.inf)
    for normal, level in zip(normals, (normals @ corners.T).max(axis=1).tolist(), strict=True):
        np.maximum(outside, normal[0] * x + normal[1] * y + normal[2] * z - level, out=outside)
    beside = (outside > slack) & (outside <= BESIDE) & (z > held)
    return int((gone & (outside <= 0.0)).sum()), int((~gone & beside).sum())
