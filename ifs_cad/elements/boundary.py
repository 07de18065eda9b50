"""The boundary of any solid as plain numbers, and what follows from them in closed form.

This is how a solid comes back from a file: nothing of the design is known, only faces, the loops
around them, and the edges of the loops. Planes and cylinders bounded by lines and arcs have exact
areas and volumes; a solid with any other face or edge has none here.

Terms
-----
side : an edge as one of the loops runs along it, the face on the left seen from outside. Every
    edge of a closed solid has two sides, of opposite directions.
placement : (3, 4) matrix [R | t] that takes a point p of the solid to R p + t.

Source: the divergence theorem; the volume is a third of the flux of x through the faces.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property

import numpy as np

from ifs_cad.elements.arcs import Segments, as_complex
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import BoolArray, FloatArray, IntArray
from ifs_cad.vectors import cross, dot, length

__all__ = ["Boundary", "Curves", "Surface", "across", "place", "turn"]


class Surface(IntEnum):
    """What a face lies on."""

    PLANE = 0
    CYLINDER = 1
    OTHER = 2


@dataclass(frozen=True, eq=False)
class Curves:
    """Lines and circular arcs in space, as parallel arrays.

    Attributes
    ----------
    starts, ends : (n, 3) float, mm
    sweeps : (n,) float
        Radians, not negative; 0 for a line, NaN for what is neither line nor arc.
    centres, axes : (n, 3) float
        Of the arcs, which sweep counter-clockwise about the unit vectors `axes`; NaN for others.
    """

    starts: FloatArray
    ends: FloatArray
    sweeps: FloatArray
    centres: FloatArray
    axes: FloatArray

    def __len__(self) -> int:
        """Return the number of curves."""
        return len(self.sweeps)

    @property
    def are_arcs(self) -> BoolArray:
        """(n,) bool."""
        return np.asarray(self.sweeps > 0.0)

    def __getitem__(self, which: IntArray | BoolArray) -> Curves:
        return Curves(
            self.starts[which],
            self.ends[which],
            self.sweeps[which],
            self.centres[which],
            self.axes[which],
        )

    def placed(self, placement: FloatArray) -> Curves:
        """Return the curves at a (3, 4) placement."""
        return Curves(
            place(placement, self.starts),
            place(placement, self.ends),
            self.sweeps,
            place(placement, self.centres),
            turn(placement, self.axes),
        )

    def seen_along(self, normal: FloatArray) -> Segments:
        """Return the curves as seen against a unit vector, in any frame across it, mm."""
        x, y = across(normal)
        flat = np.stack([x, y], axis=1)
        arcs = self.are_arcs
        centres = np.where(arcs[:, None], self.centres @ flat, np.nan)
        return Segments(
            as_complex(self.starts @ flat),
            as_complex(self.ends @ flat),
            np.where(arcs, self.sweeps * np.sign(self.axes @ normal), 0.0),
            as_complex(centres),
        )


@dataclass(frozen=True, eq=False)
class Boundary:
    """The faces of one solid.

    Attributes
    ----------
    vertices : (v, 3) float, mm
    tails, heads : (h,) int, the vertices between which each side runs
    curves : h Curves, the sides
    edges : (h,) int, the edge that each side belongs to
    forward : (h,) bool, whether it runs along its edge or against it
    loops : (h,) int, the loop of each side; those of a loop follow each other
    faces : (l,) int, the face of each loop
    surfaces : (f,) int, see `Surface`
    points : (f, 3) float, a point on the plane or on the cylinder's axis, mm
    directions : (f, 3) float, unit vectors: outward normals of planes, axes of cylinders
    radii : (f,) float, of cylinders, mm
    """

    vertices: FloatArray
    tails: IntArray
    heads: IntArray
    curves: Curves
    edges: IntArray
    forward: BoolArray
    loops: IntArray
    faces: IntArray
    surfaces: IntArray
    points: FloatArray
    directions: FloatArray
    radii: FloatArray

    @cached_property
    def face_of_side(self) -> IntArray:
        """(h,) int."""
        return self.faces[self.loops]

    @cached_property
    def planar(self) -> BoolArray:
        """(f,) bool."""
        return np.asarray(self.surfaces == Surface.PLANE)

    @property
    def open_edges(self) -> int:
        """How many edges do not have two faces, one on each side; 0 when the solid is closed."""
        uses = np.bincount(self.edges)
        balance = np.bincount(self.edges, weights=np.where(self.forward, 1.0, -1.0))
        return int(((uses > 0) & ((uses != 2) | (balance != 0.0))).sum())

    @cached_property
    def area_vectors(self) -> FloatArray:
        """(l, 3) float, normal times area of each loop, mm2; NaN for curves without closed form.

        Along the outward normal of its face for an outer loop, against it for an inner one.
        """
        curves = self.curves
        base = self.vertices[self.tails[0]] if len(self.tails) else np.zeros(3)
        swept = cross(curves.starts - base, curves.ends - base) / 2
        radii = length(curves.starts - curves.centres)
        between = radii**2 * (curves.sweeps - np.sin(curves.sweeps)) / 2
        arcs = curves.are_arcs | np.isnan(curves.sweeps)
        swept[arcs] += between[arcs, None] * curves.axes[arcs]
        return _sums(swept, self.loops, len(self.faces))

    @cached_property
    def loop_areas(self) -> FloatArray:
        """(l,) float, mm2, negative for inner loops; of planar faces."""
        return dot(self.area_vectors, self.directions[self.faces])

    @cached_property
    def outer_loops(self) -> IntArray:
        """(f,) int, the loop around each planar face, -1 for others."""
        outer = np.full(len(self.surfaces), -1)
        around = np.flatnonzero(self.planar[self.faces] & (self.loop_areas > 0.0))
        outer[self.faces[around]] = around
        return outer

    @cached_property
    def areas(self) -> FloatArray:
        """(f,) float, of planar faces, mm2."""
        count = len(self.surfaces)
        return np.asarray(np.bincount(self.faces, self.loop_areas, count), dtype=float)

    def volume(self, tol: Tolerance = DEFAULT) -> float | None:
        """Return the volume in closed form, mm3; None where there is none."""
        curves, face = self.curves, self.face_of_side
        on_cylinder = self.surfaces[face] == Surface.CYLINDER
        axes, arms = self.directions[face], curves.centres - self.points[face]
        along = length(cross(curves.ends - curves.starts, axes)) <= tol.planar
        around = length(cross(curves.axes, axes)) <= tol.parallel
        around &= length(cross(arms, axes)) <= tol.planar
        fits = np.where(curves.are_arcs, around, along)
        if (
            (self.surfaces == Surface.OTHER).any()
            or np.isnan(curves.sweeps).any()
            or not fits[on_cylinder].all()
            or self.open_edges
        ):
            return None
        base = self.vertices.mean(axis=0)
        loops = self.planar[self.faces]
        anchors = (self.points - base)[self.faces[loops]]
        flux = dot(self.area_vectors[loops], anchors).sum()

        # Through a cylinder's wall, by Green's theorem in its angle u and height v: each arc adds
        # -v (r^2 sweep + c . axis x (start - end)), with c on the axis; lines along it add nothing.
        arcs = on_cylinder & curves.are_arcs
        wall, axis = face[arcs], axes[arcs]
        sweeps = curves.sweeps[arcs] * np.sign(dot(curves.axes[arcs], axis))
        height = dot(curves.starts[arcs] - self.points[wall], axis)
        lean = dot(self.points[wall] - base, cross(axis, curves.starts[arcs] - curves.ends[arcs]))
        flux -= (height * (self.radii[wall] ** 2 * sweeps + lean)).sum()
        return float(flux) / 3

    @cached_property
    def deviations(self) -> FloatArray:
        """(f,) float, how far each plane or cylinder lies from its edges at worst, mm; else 0."""
        curves, face = self.curves, self.face_of_side
        directions, flat = self.directions[face], self.planar[face]
        arms = curves.starts - self.points[face]
        off_plane = np.abs(dot(arms, directions))
        # an arc in the plane has its centre and its axis there
        arcs = curves.are_arcs & flat
        rise = np.abs(dot(curves.centres - self.points[face], directions))
        radii = length(curves.starts - curves.centres)
        tilt = radii * length(cross(curves.axes, directions))
        off_plane[arcs] = np.maximum(off_plane, rise + tilt)[arcs]
        off_cylinder = np.abs(length(cross(arms, directions)) - self.radii[face])
        off = np.where(flat, off_plane, off_cylinder)
        off[self.surfaces[face] == Surface.OTHER] = 0.0
        worst = np.zeros(len(self.surfaces))
        np.maximum.at(worst, face, off)
        return worst


def place(placement: FloatArray, points: FloatArray) -> FloatArray:
    """Return (..., 3) points at a (3, 4) placement."""
    return np.asarray(points @ placement[:, :3].T + placement[:, 3])


def turn(placement: FloatArray, directions: FloatArray) -> FloatArray:
    """Return (..., 3) directions at a (3, 4) placement."""
    return np.asarray(directions @ placement[:, :3].T)


def across(normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two unit vectors that make a right-handed frame with a unit vector."""
    x = cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    x /= np.sqrt(x @ x)
    return x, cross(normal, x)


def _sums(values: FloatArray, owners: IntArray, count: int) -> FloatArray:
    """Return the sum of the (n, 3) values of each owner."""
    totals = [np.bincount(owners, weights=column, minlength=count) for column in values.T]
    return np.stack(totals, axis=1)
