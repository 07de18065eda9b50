"""Offcuts: rectangles that a sheet still yields when its pieces are cut.

The largest free rectangle of a coarse raster is found first, then grown on all four sides until it
touches; the next one keeps its distance from it as well. What is found is exactly free, but a
rectangle little larger than the least one worth keeping may be overlooked.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ifs_cad.fabrication.convex import Polygons, blocked, forbidden
from ifs_cad.types import BoolArray, FloatArray

LEAST = 200.0
"""The short side of an offcut worth keeping, mm."""

FINENESS = 5
"""How many cells of the raster make up the least short side."""

CELL = LEAST / FINENESS


def offcuts(
    outlines: Sequence[FloatArray], length: float, width: float, spacing: float
) -> FloatArray:
    """Return the rectangles worth keeping of a sheet, the largest first.

    Parameters
    ----------
    outlines : sequence of (k, 2) float
        The convex pieces where they lie on the sheet, mm.
    length, width : float, mm
    spacing : float, least distance from the pieces and of the rectangles from each other, mm

    Returns
    -------
    (n, 4) float, x and y of the lower left corner, length and width, mm
    """
    found: list[FloatArray] = []
    size = np.array([length, width])
    fixed = list(outlines)
    while True:
        pieces = Polygons.of(fixed)
        coarse = _largest(_free(pieces, size, spacing))
        if coarse is None:
            return np.array(found).reshape(-1, 4)
        grown = _grown(coarse * CELL, pieces, size, spacing)
        found.append(np.concatenate([grown[0], grown[1] - grown[0]]))
        fixed.append(_corners(grown))


def _corners(box: FloatArray) -> FloatArray:
    """Return the (4, 2) corners of a box of lowest and highest corner, counter-clockwise."""
    return np.column_stack([box[[0, 1, 1, 0], 0], box[[0, 0, 1, 1], 1]])


def _free(pieces: Polygons, size: FloatArray, spacing: float) -> BoolArray:
    """Return (columns, rows) bool, which cells lie on the sheet and clear of all pieces."""
    columns, rows = int(size[0] // CELL), int(size[1] // CELL)
    places = np.indices((columns, rows)).reshape(2, -1).T * CELL
    cell = Polygons.of([_corners(np.array([[0.0, 0.0], [CELL, CELL]]))])
    normals, levels = forbidden(pieces, cell, spacing)
    hit = (normals @ places.T < levels[..., None]).all(axis=1).any(axis=0)
    return np.asarray(~hit.reshape(columns, rows))


def _largest(free: BoolArray) -> FloatArray | None:
    """Return lowest and highest corner, in cells, of the largest free rectangle worth keeping."""
    columns, rows = free.shape
    best, found = 0, None
    if columns < FINENESS:
        return None
    along = np.arange(columns)[:, None]
    for row in range(rows - FINENESS + 1):
        band = np.logical_and.accumulate(free[:, row:], axis=1)
        runs = along - np.maximum.accumulate(np.where(band, -1, along), axis=0)
        heights = np.arange(1, rows - row + 1)
        areas = np.where((runs >= FINENESS) & (heights >= FINENESS), runs * heights, 0)
        end, height = np.unravel_index(np.argmax(areas), areas.shape)
        if areas[end, height] > best:
            best = int(areas[end, height])
            low = [end + 1 - runs[end, height], row]
            found = np.array([low, [end + 1, row + heights[height]]], dtype=float)
    return found


def _grown(box: FloatArray, pieces: Polygons, size: FloatArray, spacing: float) -> FloatArray:
    """Move each side of a free box outward until it touches."""
    for axis in (0, 1):
        normals, levels = forbidden(pieces, Polygons.of([_corners(box)]), spacing)
        start, end = blocked(normals, levels, np.zeros(1), axis)
        ahead = start > -end  # by the middle: what touches may start a rounding before 0
        up = start[ahead & (start < end)].min(initial=size[axis] - box[1, axis])
        down = end[~ahead & (start < end)].max(initial=-box[0, axis])
        box = box + np.outer([min(down, 0.0), max(up, 0.0)], np.eye(2)[axis])
    return box
