"""Measures of workpieces that lists and drawings share: edges, areas, masses.

Source: section 4.3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ifs_cad.fabrication.workpiece import Workpiece
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import FloatArray


@dataclass(frozen=True, eq=False)
class SideEdges:
    """Where the sides of a workpiece meet its two faces, counter-clockwise.

    Attributes
    ----------
    upper, lower : (k, 2, 2) float, first and last point, mm; NaN where a side misses the face
    """

    upper: FloatArray
    lower: FloatArray

    @property
    def upper_lengths(self) -> FloatArray:
        """(k,) float, mm; 0 where a side misses the upper face."""
        return _lengths(self.upper)

    @property
    def lower_lengths(self) -> FloatArray:
        """(k,) float, mm; 0 where a side misses the lower face."""
        return _lengths(self.lower)


def side_edges(workpiece: Workpiece, *, tol: Tolerance = DEFAULT) -> SideEdges:
    """Return the edges of the sides of a workpiece at its two faces."""
    sides = workpiece.sides
    corners = np.concatenate([side.corners for side in sides])
    counts = [len(side.corners) for side in sides]
    first = np.cumsum([0, *counts[:-1]])
    outward = np.array([side.normal[:2] for side in sides])
    outward /= np.hypot(outward[:, 0], outward[:, 1])[:, None]
    along = np.column_stack([-outward[:, 1], outward[:, 0]])
    far = (corners[:, :2] * np.repeat(outward, counts, axis=0)).sum(axis=1)
    beside = (corners[:, :2] * np.repeat(along, counts, axis=0)).sum(axis=1)

    def at(height: float) -> FloatArray:
        # A side is planar, so that at one height its points lie on one line across `outward`.
        there = np.abs(corners[:, 2] - height) <= tol.planar
        begin = np.minimum.reduceat(np.where(there, beside, np.inf), first)
        end = np.maximum.reduceat(np.where(there, beside, -np.inf), first)
        off = np.maximum.reduceat(np.where(there, far, -np.inf), first)
        meets = np.isfinite(off)
        edges = np.full((len(sides), 2, 2), np.nan)
        reach = np.column_stack([begin, end])[meets, :, None]
        edges[meets] = (off[meets, None] * outward[meets])[:, None] + reach * along[meets, None]
        return edges

    return SideEdges(upper=at(workpiece.thickness), lower=at(0.0))


def corner_angles(workpiece: Workpiece) -> FloatArray:
    """Return the (k,) angles inside, in plan, between each side and the next, degrees."""
    ways = np.array([complex(side.normal[0], side.normal[1]) for side in workpiece.sides])
    return np.asarray(180.0 - np.degrees(np.angle(np.roll(ways, -1) / ways)))


def outline_area(outline: FloatArray) -> float:
    """Return the area inside a (k, 2) counter-clockwise outline, mm2."""
    following = np.roll(outline, -1, axis=0)
    return float((outline[:, 0] * following[:, 1] - outline[:, 1] * following[:, 0]).sum() / 2)


def larger_area(workpiece: Workpiece) -> float:
    """Return the area of the larger of the two faces, mm2."""
    return max(outline_area(workpiece.lower), outline_area(workpiece.upper))


def mass(workpiece: Workpiece) -> float:
    """Return the mass, kg."""
    return workpiece.volume * 1e-9 * workpiece.material.density


def extent(workpiece: Workpiece) -> FloatArray:
    """(2,) float, length and width of the bounding box, mm."""
    return np.asarray(np.ptp(workpiece.silhouette, axis=0))


def chord(outline: FloatArray, through: FloatArray, direction: FloatArray) -> FloatArray:
    """Return the (2, 2) ends of the line through a point that a convex outline cuts off.

    Parameters
    ----------
    outline : (k, 2) float, mm
    through : (2,) float, mm, a point inside
    direction : (2,) float, unit vector
    """
    spokes = outline - through
    ahead = spokes @ direction
    aside = spokes @ np.array([-direction[1], direction[0]])
    rise = np.roll(aside, -1) - aside
    crosses = (np.minimum(aside, aside + rise) <= 0.0) & (np.maximum(aside, aside + rise) >= 0.0)
    crosses &= rise != 0.0
    reach = (ahead - aside / np.where(crosses, rise, 1.0) * (np.roll(ahead, -1) - ahead))[crosses]
    return np.asarray(through + np.array([[reach.min()], [reach.max()]]) * direction)


def _lengths(edges: FloatArray) -> FloatArray:
    spans = edges[:, 1] - edges[:, 0]
    return np.nan_to_num(np.hypot(spans[:, 0], spans[:, 1]), nan=0.0)
