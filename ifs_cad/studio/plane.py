"""The plane in which a curve is drawn and its points are dragged."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import ArrayLike, FloatArray
from ifs_cad.vectors import cross

UP = np.array([0.0, 0.0, 1.0])
FRONT = np.array([0.0, -1.0, 0.0])
RIGHT = np.array([1.0, 0.0, 0.0])

__all__ = ["CurvePlane", "plane_of"]


@dataclass(frozen=True, eq=False)
class CurvePlane:
    """The plane nearest to some points, seen with z upwards.

    Attributes
    ----------
    origin : (3,) float, mm
    right, up, normal : (3,) float, unit vectors, right-handed
    is_exact : bool
        All points are in it, and in no other plane.
    """

    origin: FloatArray
    right: FloatArray
    up: FloatArray
    normal: FloatArray
    is_exact: bool

    def flat(self, points: FloatArray) -> FloatArray:
        """Return (n, 2) float, mm: points as they are seen along the normal."""
        return np.asarray((points - self.origin) @ np.stack([self.right, self.up], axis=1))


def plane_of(points: ArrayLike, tol: Tolerance = DEFAULT) -> CurvePlane:
    """Return the plane of a curve.

    Points on a line are seen in the vertical plane through it, a single place from the front.

    Parameters
    ----------
    points : (n, 3) float, mm
    tol : Tolerance, optional
    """
    rows = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    origin = rows.mean(axis=0)
    _, sizes, axes = np.linalg.svd(rows - origin)
    sizes = np.pad(sizes, (0, max(0, 3 - len(sizes))))
    spread = (sizes > 0.0) & (sizes > tol.parallel * sizes[0])
    normal = axes[2] if spread[1] else _square_to(axes[0] if spread[0] else RIGHT, tol)
    is_level = abs(normal[2]) > 1.0 - tol.parallel
    right = RIGHT if is_level else cross(UP, normal)
    # the side from which x, or failing that y, grows to the right
    grows = next((value for value in right if abs(value) > tol.parallel), 1.0)
    right = right * np.sign(grows) / np.linalg.norm(right)
    normal = normal * np.sign(normal[2] if is_level else grows)
    is_exact = bool(spread[1] and not spread[2])
    return CurvePlane(origin, right, cross(normal, right), normal, is_exact)


def _square_to(along: FloatArray, tol: Tolerance) -> FloatArray:
    """Return the level direction that is square to a line."""
    level = cross(along, UP)
    size = np.linalg.norm(level)
    return FRONT if size < tol.parallel else np.asarray(level / size)
