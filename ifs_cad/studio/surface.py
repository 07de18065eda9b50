"""The surface that the studio draws: as much of a sum of curves as has a place.

The sum that can be built is `vector_sum`'s; where it refuses, this shows what there is of it.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ifs_cad.design.address import surface_addresses
from ifs_cad.design.curve import Curve
from ifs_cad.design.mesh import Mesh
from ifs_cad.types import FloatArray, IntArray

__all__ = ["Surface", "beside_gaps", "summed", "surface_of"]


@dataclass(frozen=True, eq=False)
class Surface:
    """The grid of a sum, with the faces that have a place, whatever else is wrong with them."""

    shape: tuple[int, int] = (0, 0)
    vertices: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    faces: IntArray = field(default_factory=lambda: np.empty((0, 4), dtype=np.int64))
    addresses: tuple[str, ...] = ()


def surface_of(mesh: Mesh, shape: tuple[int, int]) -> Surface:
    """Return the faces of a sum that can be built."""
    return Surface(shape, mesh.vertices, mesh.corners.reshape(-1, 4), mesh.addresses)


def summed(a: Curve, b: Curve) -> Surface:
    """Sum two curves without asking whether the sum can be built.

    It is the sum of `vector_sum`, face by face as far as weights allow.
    """
    rows_a, rows_b = a.homogeneous, b.homogeneous
    start = rows_a[0, 1:] / rows_a[0, 0]
    moved = rows_b.copy()
    moved[:, 1:] += rows_b[:, :1] * (start - rows_b[0, 1:] / rows_b[0, 0])
    moved *= rows_a[0, 0] / rows_b[0, 0]
    grid = (rows_a[:, None] + (moved - rows_a[0])).reshape(-1, 4)
    good = grid[:, 0] > a.tol.weight * np.abs(grid[:, 0]).max()
    points = np.full((len(grid), 3), np.nan)
    points[good] = grid[good, 1:] / grid[good, :1]
    shape = (len(rows_a) - 1, len(rows_b) - 1)
    faces = _corners(shape)
    whole = good[faces].all(axis=1)
    names = surface_addresses(a.word_structure, b.word_structure)
    if not whole.all():
        names = [names[i] for i in np.flatnonzero(whole)]
    return Surface(shape, points, faces[whole], tuple(names))


def _corners(shape: tuple[int, int]) -> IntArray:
    """Return the (f, 4) corners of all faces of a grid."""
    rows, columns = shape
    number = np.arange((rows + 1) * (columns + 1)).reshape(rows + 1, columns + 1)
    around = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    return np.stack(around, axis=-1).reshape(-1, 4)


def beside_gaps(surface: Surface) -> FloatArray:
    """Return the (n, 3) corners that do have a place of faces that have none, mm."""
    finite = np.isfinite(surface.vertices[:, 0])
    around = _corners(surface.shape)
    missing = around[~finite[around].all(axis=1)]
    return surface.vertices[np.intersect1d(missing, np.flatnonzero(finite))]
