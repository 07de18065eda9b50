"""Lines as flat ribbons of triangles, which a page draws many times faster than lines.

A ribbon lies on the face that the line is drawn on, lifted a little so that it is seen.
"""

from __future__ import annotations

import numpy as np

from ifs_cad.elements.polyhedron import Polyhedra
from ifs_cad.types import FloatArray, IntArray
from ifs_cad.vectors import cross, dot

LIFT = 0.08  # of the width
LEAST_LENGTH = 1e-9  # mm

__all__ = ["face_outlines", "quad_outlines", "ribbons", "strokes"]


def ribbons(
    tails: FloatArray, heads: FloatArray, normals: FloatArray, width: float
) -> tuple[FloatArray, IntArray]:
    """Return lines as ribbons on their left, seen against the normal.

    Parameters
    ----------
    tails, heads, normals : (n, 3) float, mm
    width : float, mm

    Returns
    -------
    vertices : (4 n, 3) float, mm
    triangles : (2 n, 3) int
    """
    along = heads - tails
    lengths = np.sqrt(dot(along, along))
    good = lengths > LEAST_LENGTH
    tails, heads, normals = tails[good], heads[good], normals[good]
    across = cross(normals, along[good] / lengths[good, None]) * width
    lift = normals * (LIFT * width)
    corners = np.stack([tails, heads, heads + across, tails + across], axis=1) + lift[:, None]
    first = 4 * np.arange(len(tails))[:, None]
    triangles = np.concatenate([first + np.array([0, 1, 2]), first + np.array([0, 2, 3])])
    return corners.reshape(-1, 3), triangles


def strokes(lines: FloatArray, normals: FloatArray, width: float) -> tuple[FloatArray, IntArray]:
    """Return (n, 2, 3) lines on faces as ribbons with the line in the middle; see `ribbons`."""
    if not len(lines):
        return np.empty((0, 3)), np.empty((0, 3), dtype=np.int64)
    vertices, triangles = ribbons(lines[:, 0], lines[:, 1], normals, width)
    corners = vertices.reshape(-1, 4, 3)
    middle = (corners[:, 3] - corners[:, 0]) / 2
    return (corners - middle[:, None]).reshape(-1, 3), triangles


def face_outlines(solids: Polyhedra, width: float) -> tuple[FloatArray, IntArray]:
    """Return the edges of solids as ribbons inside all their faces; see `ribbons`."""
    tails, heads = solids.vertices[solids.loops], solids.vertices[solids.heads]
    return ribbons(tails, heads, solids.normals[solids.face_of_loop], width)


def quad_outlines(
    vertices: FloatArray, faces: IntArray, width: float
) -> tuple[FloatArray, IntArray]:
    """Return the edges of (f, 4) quads as ribbons on both sides of them; see `ribbons`."""
    corners = vertices[faces]
    normals = cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    sizes = np.sqrt(dot(normals, normals))
    good = sizes > 0.0
    corners, normals = corners[good], normals[good] / sizes[good, None]
    tails, heads = corners.reshape(-1, 3), np.roll(corners, -1, axis=1).reshape(-1, 3)
    up = np.repeat(normals, 4, axis=0)
    above, upper = ribbons(tails, heads, up, width)
    below, lower = ribbons(heads, tails, -up, width)
    return np.concatenate([above, below]), np.concatenate([upper, lower + len(above)])
