"""Joints: which cut faces of different panels face each other, and how far they gape.

Two cut faces make a joint when they look at each other, the middle of one lies before the other,
closer than a reach, and neither has a nearer partner. Mating chamfers are parallel, so their gap
is one number: twice the clearance.

Terms
-----
gap : distance of the two faces, mm; negative where they overlap.
spread : by how much the distance varies over them, mm; 0 for parallel faces.
tapering : of a face much shorter on one sheet face than on the other, such as a node relief, which
    begins in a point.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ifs_cad.elements.polyhedron import Kind, Polyhedra, ranges
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import BoolArray, FloatArray, IntArray
from ifs_cad.vectors import cross, dot, length

FACING = 0.9
"""Faces look at each other when their unit normals have at most minus this product."""

TAPER = 0.5
"""A face tapers when it is shorter on one sheet face than this share of its length on the other."""


@dataclass(frozen=True, eq=False)
class Joints:
    """Pairs of cut faces that face each other.

    Attributes
    ----------
    faces : (k, 2) int
    solids : (k, 2) int, of these faces
    gaps : (k,) float, mm
    spreads : (k,) float, mm
    tapering : (k,) bool, whether either face tapers
    """

    faces: IntArray
    solids: IntArray
    gaps: FloatArray
    spreads: FloatArray
    tapering: BoolArray

    def __len__(self) -> int:
        """Return the number of joints."""
        return len(self.gaps)


def find_joints(
    panels: Polyhedra, near: IntArray, reach: float, tol: Tolerance = DEFAULT
) -> Joints:
    """Find the joints between panels.

    Parameters
    ----------
    panels : Polyhedra
        All faces but those of kind LOWER and UPPER count as cut.
    near : (n, 2) int
        Pairs of solids that may touch.
    reach : float
        Faces further apart make no joint, mm.
    """
    centres = _centroids(panels)
    faces = _facing(panels, near, centres, reach, tol)
    distances = length(centres[faces[:, 0]] - centres[faces[:, 1]])
    faces = _nearest(faces, distances, len(centres))
    low, high = np.full(len(faces), np.inf), np.full(len(faces), -np.inf)
    for face, other in (faces.T, faces[:, ::-1].T):
        starts = panels.face_offsets[face]
        entries = ranges(starts, panels.face_offsets[face + 1])
        sizes = np.diff(panels.face_offsets)[face]
        seen = np.repeat(other, sizes)
        points = panels.vertices[panels.loops[entries]]
        heights = dot(panels.normals[seen], points) - panels.levels[seen]
        if len(heights):
            first = np.cumsum(sizes) - sizes
            low = np.minimum(low, np.minimum.reduceat(heights, first))
            high = np.maximum(high, np.maximum.reduceat(heights, first))
    tapering = _tapering(panels)
    return Joints(
        faces,
        panels.solid_of_face[faces],
        (low + high) / 2,
        high - low,
        np.asarray(tapering[faces].any(axis=1)),
    )


def unmated_chamfers(panels: Polyhedra, joints: Joints) -> IntArray:
    """Return the cut faces that have no partner though they are not square to their sheet."""
    top = panels.kinds == Kind.UPPER
    sheet = np.zeros((len(panels), 3))
    sheet[panels.solid_of_face[top]] = panels.normals[top]
    lean = np.abs(dot(panels.normals, sheet[panels.solid_of_face]))
    slanted = np.flatnonzero((panels.kinds > Kind.UPPER) & (lean > DEFAULT.parallel))
    return np.setdiff1d(slanted, joints.faces)


def _centroids(panels: Polyhedra) -> FloatArray:
    """Return the (f, 3) centroids of the faces, mm."""
    first = panels.vertices[panels.loops[panels.face_offsets[:-1]]][panels.face_of_loop]
    one, other = panels.vertices[panels.loops], panels.vertices[panels.heads]
    weights = dot(cross(one - first, other - first), panels.normals[panels.face_of_loop])
    moments = weights[:, None] * (first + one + other) / 3
    starts = panels.face_offsets[:-1]
    return np.asarray(np.add.reduceat(moments, starts) / np.add.reduceat(weights, starts)[:, None])


def _facing(
    panels: Polyhedra, near: IntArray, centres: FloatArray, reach: float, tol: Tolerance
) -> IntArray:
    """Return the (k, 2) pairs of cut faces that look at each other within reach."""
    cut = np.flatnonzero(panels.kinds > Kind.UPPER)
    count = np.bincount(panels.solid_of_face[cut], minlength=len(panels))
    starts = np.cumsum(count) - count
    one = ranges(starts[near[:, 0]], (starts + count)[near[:, 0]])
    pair = np.repeat(np.arange(len(near)), count[near[:, 0]])
    second = near[pair, 1]
    other = ranges(starts[second], (starts + count)[second])
    faces = cut[np.stack([np.repeat(one, count[second]), other], axis=1)]
    a, b = faces.T
    facing = dot(panels.normals[a], panels.normals[b]) < -FACING
    faces = faces[facing]
    a, b = faces.T
    over_b, over_a = _heights(panels, centres[a], b), _heights(panels, centres[b], a)
    close = (np.abs(over_b) < reach) & (np.abs(over_a) < reach)
    faces = faces[close]
    a, b = faces.T
    before = _before(panels, centres[a], b, tol) | _before(panels, centres[b], a, tol)
    return faces[before]


def _heights(panels: Polyhedra, points: FloatArray, faces: IntArray) -> FloatArray:
    return dot(panels.normals[faces], points) - panels.levels[faces]


def _before(panels: Polyhedra, points: FloatArray, faces: IntArray, tol: Tolerance) -> BoolArray:
    """Tell whether each point lies before its (convex) face: inside, seen along the normal."""
    sizes = np.diff(panels.face_offsets)[faces]
    entries = ranges(panels.face_offsets[faces], panels.face_offsets[faces + 1])
    tails = panels.vertices[panels.loops[entries]]
    along = panels.vertices[panels.heads[entries]] - tails
    inward = cross(np.repeat(panels.normals[faces], sizes, axis=0), along)
    inside = dot(inward, np.repeat(points, sizes, axis=0) - tails) >= -tol.coplanar
    owners = np.repeat(np.arange(len(faces)), sizes)
    return np.asarray(np.bincount(owners, weights=~inside, minlength=len(faces)) == 0)


def _nearest(faces: IntArray, distances: FloatArray, count: int) -> IntArray:
    """Keep of the (k, 2) pairs those in which each of the `count` faces is the other's nearest."""
    nearest = np.full(count, np.inf)
    np.minimum.at(nearest, faces, distances[:, None])
    return faces[(distances[:, None] <= nearest[faces]).all(axis=1)]


def _tapering(panels: Polyhedra) -> BoolArray:
    """Tell of the (f,) faces which are much shorter on one sheet face than on the other."""
    count = len(panels.vertices)
    key = panels.loops * count + panels.heads
    order = np.argsort(key)
    twin = order[np.searchsorted(key, panels.heads * count + panels.loops, sorter=order)]
    kind = panels.kinds[panels.face_of_loop[twin]]
    lengths = [
        np.bincount(
            panels.face_of_loop,
            weights=np.where(kind == sheet, panels.edge_lengths, 0.0),
            minlength=len(panels.kinds),
        )
        for sheet in (Kind.LOWER, Kind.UPPER)
    ]
    return np.asarray(np.minimum(*lengths) < TAPER * np.maximum(*lengths))
