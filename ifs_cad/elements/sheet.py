"""A solid read back as a panel: a convex body between two parallel faces, less pockets and holes.

Terms
-----
sheet faces : the two faces of the plywood; all others of the body are cut.
hull : the body without its pockets and holes.
floor : of a pocket; parallel to the sheet faces and between them.
stub : a panel that has lost one sheet face, when the floor of the building left but a corner.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ifs_cad.elements.arcs import Segments
from ifs_cad.elements.boundary import Boundary, place, turn
from ifs_cad.elements.polyhedron import Kind, Polyhedra, offsets
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import BoolArray, FloatArray, IntArray
from ifs_cad.vectors import cross, dot, length

OPPOSITE = 0.995
"""Two faces whose unit normals have at most minus this product may be meant as sheet faces."""


@dataclass(frozen=True, eq=False)
class Sheet:
    """One solid as a panel, in its own frame.

    Attributes
    ----------
    boundary : Boundary
    pair : (2,) int
        The two sheet faces, the larger first; of a stub one.
    thickness : float
        Mean distance between them, mm; of a stub its height.
    unevenness : float
        By how much their distance varies, mm.
    """

    boundary: Boundary
    pair: IntArray
    thickness: float
    unevenness: float
    tol: Tolerance

    @property
    def is_stub(self) -> bool:
        """Whether there is only one sheet face."""
        return len(self.pair) == 1

    @cached_property
    def hull(self) -> Polyhedra | None:
        """The convex polyhedron around the solid; None when it is not one.

        Its faces lie in planes that have the whole solid on one side. Of coplanar faces the
        largest counts: the others are islands within pockets.
        """
        body = self.boundary
        faces = np.flatnonzero(body.outer_loops >= 0)
        normals = body.directions[faces]
        levels = dot(normals, body.points[faces])
        heights = (normals @ body.vertices.T).max(axis=1) - levels
        faces = faces[heights <= self.tol.planar]
        faces = faces[self._largest_in_plane(faces)]
        loops = body.outer_loops[faces]
        rank = np.full(len(body.faces), -1)
        rank[loops] = np.arange(len(loops))
        sides = np.flatnonzero(rank[body.loops] >= 0)
        sides = sides[np.argsort(rank[body.loops[sides]], kind="stable")]
        return self._polyhedron(faces, sides)

    def _largest_in_plane(self, faces: IntArray) -> BoolArray:
        body = self.boundary
        normals, points = body.directions[faces], body.points[faces]
        cosines = normals @ normals.T
        same = (cosines > 0.0) & (1.0 - cosines**2 <= self.tol.parallel**2)
        same &= np.abs(normals @ points.T - dot(normals, points)[:, None]) <= self.tol.planar
        areas = body.loop_areas[body.outer_loops[faces]]
        return np.asarray((areas[:, None] >= np.where(same, areas, 0.0)).all(axis=1))

    def _polyhedron(self, faces: IntArray, sides: IntArray) -> Polyhedra | None:
        """Return the faces as a polyhedron when straight edges close it, else None."""
        body = self.boundary
        sizes = np.bincount(body.face_of_side[sides], minlength=len(body.surfaces))[faces]
        tails, heads = body.tails[sides], body.heads[sides]
        starts = offsets(sizes)
        following = np.arange(1, len(sides) + 1)
        following[starts[1:] - 1] = starts[:-1]
        count = len(body.vertices)
        there = np.sort(tails * count + heads)
        back = np.sort(heads * count + tails)
        if (
            len(faces) < 4
            or (body.curves.sweeps[sides] != 0.0).any()
            or (heads != tails[following]).any()
            or (there != back).any()
        ):
            return None
        used, loops = np.unique(tails, return_inverse=True)
        kinds = np.full(len(faces), int(Kind.CUT))
        kinds[faces == self.pair[0]] = Kind.UPPER
        kinds[np.isin(faces, self.pair[1:])] = Kind.LOWER
        return Polyhedra(
            vertices=body.vertices[used],
            loops=loops,
            face_offsets=starts,
            solid_offsets=np.array([0, len(faces)]),
            normals=body.directions[faces],
            levels=dot(body.directions[faces], body.points[faces]),
            kinds=kinds,
            mates=np.full(len(faces), -1),
        )

    @cached_property
    def floors(self) -> list[IntArray]:
        """The floors of the pockets in each of the sheet faces."""
        body = self.boundary
        faces = np.flatnonzero(body.outer_loops >= 0)
        inside = []
        for face in self.pair:
            normal = body.directions[face]
            depth = (body.points[face] - body.points[faces]) @ normal
            level = length(cross(body.directions[faces], normal)) <= self.tol.parallel
            level &= body.directions[faces] @ normal > 0
            between = (depth > self.tol.planar) & (depth < self.thickness - self.tol.planar)
            inside.append(faces[level & between])
        return inside

    @cached_property
    def pocket_volume(self) -> float:
        """What the pockets take, mm3: their floors times their depths, as if walls were square."""
        body = self.boundary
        total = 0.0
        for face, floors in zip(self.pair, self.floors, strict=True):
            depths = (body.points[face] - body.points[floors]) @ body.directions[face]
            total += float(body.areas[floors] @ depths)
        return total

    @cached_property
    def hole_areas(self) -> FloatArray:
        """(n,) float, mm2, of the holes through the sheet: the openings of its plainer face."""
        body = self.boundary
        openings = [
            -body.loop_areas[(body.faces == face) & (body.loop_areas < 0.0)] for face in self.pair
        ]
        return min(openings, key=len)

    @property
    def hole_volume(self) -> float:
        """What the holes take, mm3, as if they were square to the sheet."""
        return float(self.hole_areas.sum()) * self.thickness

    def outlines(self) -> list[list[Segments]]:
        """Return, for each sheet face, the outline of every floor in it, seen from outside."""
        body = self.boundary
        found = []
        for face, floors in zip(self.pair, self.floors, strict=True):
            seen = body.curves.seen_along(body.directions[face])
            found.append([seen[body.face_of_side == floor] for floor in floors])
        return found


def read_sheet(
    boundary: Boundary, thickness: float | None = None, tol: Tolerance = DEFAULT
) -> Sheet | None:
    """Read a solid as a panel; None when it cannot be one.

    Its sheet faces are two parallel ones at a given distance; or else its two largest faces, if
    they are roughly opposite. A convex solid without them that is not higher may be a stub; the
    last resort is any two parallel faces.

    Parameters
    ----------
    boundary : Boundary
    thickness : float, optional
        The given distance, mm.
    """
    faces = np.flatnonzero(boundary.outer_loops >= 0)
    faces = faces[np.argsort(-boundary.areas[faces], kind="stable")]
    normals, points = boundary.directions[faces], boundary.points[faces]
    apart = dot(normals, points)[:, None] - normals @ points.T  # negative across a slot
    opposite = np.triu((normals @ normals.T < -OPPOSITE) & (apart > 0.0), 1)
    one, other = np.nonzero(opposite)
    order = np.argsort(-boundary.areas[faces[other]], kind="stable")
    pairs = faces[np.stack([one, other], axis=1)[order]]
    sheets = [_between(boundary, pair, tol) for pair in pairs]
    even = [sheet for sheet in sheets if sheet.unevenness <= tol.planar]
    if thickness is not None:
        for sheet in even:
            if abs(sheet.thickness - thickness) <= tol.planar:
                return sheet
    if len(faces) > 1 and opposite[0, 1]:
        return _between(boundary, faces[:2], tol)
    stub = _stub(boundary, faces, tol)
    low = stub is not None and thickness is not None and stub.thickness <= thickness + tol.planar
    return even[0] if even and not low else stub


def _between(boundary: Boundary, pair: IntArray, tol: Tolerance) -> Sheet:
    depths = []
    for face, opposite in (pair, pair[::-1]):
        sides = boundary.face_of_side == opposite
        arms = boundary.points[face] - boundary.curves.starts[sides]
        depths.append(arms @ boundary.directions[face])
    distances = np.concatenate(depths)
    return Sheet(boundary, pair, float(distances.mean()), float(np.ptp(distances)), tol)


def _stub(boundary: Boundary, faces: IntArray, tol: Tolerance) -> Sheet | None:
    """Return a convex solid as a stub on the face above which it is lowest, else None."""
    if len(faces) == 0:
        return None
    normals = boundary.directions[faces]
    depths = dot(normals, boundary.points[faces]) - (normals @ boundary.vertices.T).min(axis=1)
    lowest = int(np.argmin(depths))
    stub = Sheet(boundary, faces[[lowest]], float(depths[lowest]), 0.0, tol)
    return stub if stub.hull else None


def stacked(placements: Sequence[FloatArray], hulls: Sequence[Polyhedra]) -> Polyhedra:
    """Return single polyhedra in their places as one batch."""
    points = [place(where, hull.vertices) for where, hull in zip(placements, hulls, strict=True)]
    normals = [turn(where, hull.normals) for where, hull in zip(placements, hulls, strict=True)]
    levels = [
        hull.levels + normal @ where[:, 3]
        for where, hull, normal in zip(placements, hulls, normals, strict=True)
    ]
    shifts = offsets(np.array([len(hull.vertices) for hull in hulls]))
    sizes = [np.diff(hull.face_offsets) for hull in hulls]
    return Polyhedra(
        vertices=np.concatenate(points),
        loops=np.concatenate([h.loops + k for h, k in zip(hulls, shifts[:-1], strict=True)]),
        face_offsets=offsets(np.concatenate(sizes)),
        solid_offsets=offsets(np.array([len(size) for size in sizes])),
        normals=np.concatenate(normals),
        levels=np.concatenate(levels),
        kinds=np.concatenate([hull.kinds for hull in hulls]),
        mates=np.concatenate([hull.mates for hull in hulls]),
    )
