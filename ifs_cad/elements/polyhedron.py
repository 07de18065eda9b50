"""Many convex polyhedra at once, in CSR arrays: build them as prismatoids, clip them by planes.

A *solid* here is one convex polyhedron. Faces are loops of vertex numbers, counter-clockwise seen
from outside; all arrays are flat, with offsets that say where each face and each solid begins.
The *kind* of a face says what it is for; its *mate* is the element on the other side, -1 if none.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum
from functools import cached_property

import numpy as np

from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import BoolArray, FloatArray, IntArray
from ifs_cad.vectors import cross, dot


class Kind(IntEnum):
    """What a face of an element is."""

    LOWER = 0  # the face of the slab on the negative side of the panel's normal
    UPPER = 1  # the face of the slab on the positive side
    CUT = 2  # a chamfer that mates with an edge neighbour
    BORDER = 3  # a square edge
    RELIEF = 4  # a cut that keeps two panels apart that share only a node
    FLOOR = 5  # trimmed by the floor


@dataclass(frozen=True, eq=False)
class Polyhedra:
    """Convex polyhedra in CSR arrays.

    Attributes
    ----------
    vertices : (v, 3) float, mm
    loops : (h,) int, vertex numbers, face after face
    face_offsets : (f + 1,) int, where each face begins in `loops`
    solid_offsets : (s + 1,) int, where each solid begins in the faces
    normals : (f, 3) float, outward unit vectors
    levels : (f,) float, normal . x for the points x of the face, mm
    kinds : (f,) int, see `Kind`
    mates : (f,) int
    """

    vertices: FloatArray
    loops: IntArray
    face_offsets: IntArray
    solid_offsets: IntArray
    normals: FloatArray
    levels: FloatArray
    kinds: IntArray
    mates: IntArray

    def __len__(self) -> int:
        """Return the number of solids."""
        return len(self.solid_offsets) - 1

    @cached_property
    def face_of_loop(self) -> IntArray:
        """(h,) int, the face of each entry of `loops`."""
        return np.repeat(np.arange(len(self.kinds)), np.diff(self.face_offsets))

    @cached_property
    def solid_of_face(self) -> IntArray:
        """(f,) int."""
        return np.repeat(np.arange(len(self)), np.diff(self.solid_offsets))

    @cached_property
    def solid_of_vertex(self) -> IntArray:
        """(v,) int; solids never share vertices."""
        owner = np.empty(len(self.vertices), dtype=np.int64)
        owner[self.loops] = self.solid_of_face[self.face_of_loop]
        return owner

    @cached_property
    def heads(self) -> IntArray:
        """(h,) int, the vertex that follows each entry of `loops` in its face."""
        following = np.arange(1, len(self.loops) + 1)
        following[self.face_offsets[1:] - 1] = self.face_offsets[:-1]
        return self.loops[following]

    @cached_property
    def area_vectors(self) -> FloatArray:
        """(f, 3) float, normal times area of each face, mm2."""
        first = self.vertices[self.loops[self.face_offsets[:-1]]][self.face_of_loop]
        arms = cross(self.vertices[self.loops] - first, self.vertices[self.heads] - first)
        return np.add.reduceat(arms, self.face_offsets[:-1]) / 2

    @cached_property
    def face_areas(self) -> FloatArray:
        """(f,) float, mm2."""
        return dot(self.area_vectors, self.normals)

    @cached_property
    def volumes(self) -> FloatArray:
        """(s,) float, mm3, by the divergence theorem about a vertex of each solid."""
        first_face = self.solid_offsets[:-1]
        base = self.vertices[self.loops[self.face_offsets[first_face]]]
        points = self.vertices[self.loops[self.face_offsets[:-1]]] - base[self.solid_of_face]
        return np.add.reduceat(dot(self.area_vectors, points), first_face) / 3

    @cached_property
    def edge_lengths(self) -> FloatArray:
        """(h,) float, mm; each edge counts in both of its faces."""
        along = self.vertices[self.heads] - self.vertices[self.loops]
        return np.asarray(np.sqrt(dot(along, along)))

    def take(self, solids: IntArray) -> Polyhedra:
        """Return some solids, in the order asked for; mates keep their numbers."""
        faces = ranges(self.solid_offsets[solids], self.solid_offsets[solids + 1])
        entries = ranges(self.face_offsets[faces], self.face_offsets[faces + 1])
        # a solid asked for twice gets vertices of its own each time
        order = np.repeat(np.arange(len(solids)), np.diff(self.solid_offsets)[solids]).repeat(
            np.diff(self.face_offsets)[faces]
        )
        keys, loops = np.unique(
            order * len(self.vertices) + self.loops[entries], return_inverse=True
        )
        return replace(
            self,
            vertices=self.vertices[keys % len(self.vertices)],
            loops=loops,
            face_offsets=offsets(np.diff(self.face_offsets)[faces]),
            solid_offsets=offsets(np.diff(self.solid_offsets)[solids]),
            normals=self.normals[faces],
            levels=self.levels[faces],
            kinds=self.kinds[faces],
            mates=self.mates[faces],
        )


def offsets(sizes: IntArray) -> IntArray:
    """Return the (n + 1,) starts of n parts of the given sizes, laid one after the other."""
    starts = np.zeros(len(sizes) + 1, dtype=np.int64)
    np.cumsum(sizes, out=starts[1:])
    return starts


def ranges(starts: IntArray, stops: IntArray) -> IntArray:
    """Return arange(starts[0], stops[0]), arange(starts[1], stops[1]), ... in one array."""
    sizes = stops - starts
    ends = np.cumsum(sizes)
    total = int(ends[-1]) if len(ends) else 0
    return np.asarray(np.arange(total) + np.repeat(starts - ends + sizes, sizes))


def joined(first: Polyhedra, second: Polyhedra, order: IntArray) -> Polyhedra:
    """Return two batches as one, its solids taken in `order` (numbers of the second follow)."""
    return Polyhedra(
        vertices=np.concatenate([first.vertices, second.vertices]),
        loops=np.concatenate([first.loops, second.loops + len(first.vertices)]),
        face_offsets=offsets(
            np.concatenate([np.diff(first.face_offsets), np.diff(second.face_offsets)])
        ),
        solid_offsets=offsets(
            np.concatenate([np.diff(first.solid_offsets), np.diff(second.solid_offsets)])
        ),
        normals=np.concatenate([first.normals, second.normals]),
        levels=np.concatenate([first.levels, second.levels]),
        kinds=np.concatenate([first.kinds, second.kinds]),
        mates=np.concatenate([first.mates, second.mates]),
    ).take(order)


@dataclass(frozen=True, eq=False)
class Prismatoids:
    """Slabs between two parallel planes, bounded all around by a cycle of side planes.

    Corner k of a solid lies where sides k and k + 1 of its cycle meet; it has one point on the
    lower plane and one on the upper. A side may vanish to a point on one of the two planes.

    Attributes
    ----------
    lower, upper : (c, 3) float, the two points of each corner, mm
    side_normals : (c, 3) float, inward unit vectors of the side that ends in corner k
    kinds, mates : (c,) int, of these sides
    solid_offsets : (s + 1,) int, where the corners of each solid begin
    normals : (s, 3) float, the common normal of the two planes
    """

    lower: FloatArray
    upper: FloatArray
    side_normals: FloatArray
    kinds: IntArray
    mates: IntArray
    solid_offsets: IntArray
    normals: FloatArray

    @cached_property
    def solid(self) -> IntArray:
        """(c,) int, the solid of each corner."""
        return np.repeat(np.arange(len(self.normals)), np.diff(self.solid_offsets))

    @cached_property
    def previous(self) -> IntArray:
        """(c,) int, the corner at which the side that ends in corner k begins."""
        before = np.arange(-1, len(self.lower) - 1)
        before[self.solid_offsets[:-1]] = self.solid_offsets[1:] - 1
        return before

    @cached_property
    def side_lengths(self) -> FloatArray:
        """(2, c) float, signed lengths of each side on the lower and on the upper plane, mm."""
        along = cross(self.side_normals, self.normals[self.solid])
        along /= np.sqrt(dot(along, along))[:, None]
        both = np.stack([self.lower, self.upper])
        return dot(both - both[:, self.previous], along)

    def take(self, wanted: BoolArray) -> Prismatoids:
        """Return the solids for which the (s,) bools are set."""
        corner = wanted[self.solid]
        return Prismatoids(
            lower=self.lower[corner],
            upper=self.upper[corner],
            side_normals=self.side_normals[corner],
            kinds=self.kinds[corner],
            mates=self.mates[corner],
            solid_offsets=offsets(np.diff(self.solid_offsets)[wanted]),
            normals=self.normals[wanted],
        )

    def polyhedra(self, tol: Tolerance = DEFAULT) -> Polyhedra:
        """Return the solids; every side length must be positive, or zero within tolerance."""
        count, solids = len(self.lower), len(self.normals)
        fresh = self.side_lengths > tol.coincident
        # a point that coincides with the one before it takes its number, around the cycle
        number = np.cumsum(fresh, axis=1) - 1
        total = number[:, -1] + 1
        first, last = self.solid_offsets[:-1], self.solid_offsets[1:] - 1
        wraps = ~fresh & (number == np.where(first > 0, number[:, first - 1], -1)[:, self.solid])
        number = np.where(wraps, number[:, last][:, self.solid], number)
        points = np.concatenate([self.lower[fresh[0]], self.upper[fresh[1]]])
        low, high = number[0], number[1] + total[0]

        # side loops: along the lower edge, up, back along the upper edge, down
        quads = np.stack([low[self.previous], low, high, high[self.previous]], axis=1)
        keep = np.ones((count, 4), dtype=bool)
        keep[:, 0] = fresh[0]
        keep[:, 3] = fresh[1]
        present = keep.sum(axis=1) > 2
        # cap loops, the lower one reversed so that it runs counter-clockwise seen from outside
        low_ids, low_sizes = self._ring(low, fresh[0])
        high_ids, high_sizes = self._ring(high, fresh[1])
        flip = offsets(low_sizes)
        low_ids = low_ids[np.repeat(flip[:-1] + flip[1:] - 1, low_sizes) - np.arange(len(low_ids))]

        sizes = np.concatenate([low_sizes, high_sizes, keep.sum(axis=1)[present]])
        entries = np.concatenate([low_ids, high_ids, quads[present][keep[present]]])
        owner = np.concatenate([np.arange(solids), np.arange(solids), self.solid[present]])
        normals = np.concatenate([-self.normals, self.normals, -self.side_normals[present]])
        caps = np.repeat([Kind.LOWER, Kind.UPPER], solids)
        kinds = np.concatenate([caps, self.kinds[present]])
        mates = np.concatenate([np.full(2 * solids, -1), self.mates[present]])
        anchor = entries[offsets(sizes)[:-1]]

        order = np.argsort(owner, kind="stable")
        starts = offsets(sizes)
        return Polyhedra(
            vertices=points,
            loops=entries[ranges(starts[:-1][order], starts[1:][order])],
            face_offsets=offsets(sizes[order]),
            solid_offsets=offsets(np.bincount(owner, minlength=solids)),
            normals=normals[order],
            levels=dot(normals, points[anchor])[order],
            kinds=kinds[order],
            mates=mates[order],
        )

    def _ring(self, numbers: IntArray, fresh: BoolArray) -> tuple[IntArray, IntArray]:
        return numbers[fresh], np.bincount(self.solid[fresh], minlength=len(self.normals))


def clip(
    solids: Polyhedra,
    normals: FloatArray,
    levels: FloatArray,
    kind: Kind,
    mates: IntArray,
    tol: Tolerance = DEFAULT,
) -> tuple[Polyhedra, BoolArray]:
    """Cut each solid by one plane and keep what lies inside.

    Parameters
    ----------
    normals : (s, 3) float, unit vectors pointing into the part that is kept
    levels : (s,) float, kept points have normal . x >= level, mm; -inf leaves a solid as it is
    kind : Kind of the new faces
    mates : (s,) int, mates of the new faces

    Returns
    -------
    Polyhedra, (s,) bool
        What is left, and which of the solids are left; the others are gone from the first.
    """
    owner = solids.solid_of_vertex
    height = dot(normals[owner], solids.vertices) - levels[owner]
    height[np.abs(height) <= tol.coincident] = 0.0
    left = np.zeros(len(solids), dtype=bool)
    left[owner[height > 0]] = True
    if not left.all():
        survivors = np.flatnonzero(left)
        if len(survivors) == 0:
            return solids.take(survivors), left
        rest, _ = clip(solids.take(survivors), normals[left], levels[left], kind, mates[left], tol)
        return rest, left
    if (height >= 0).all():
        return solids, left

    tail, head = solids.loops, solids.heads
    from_height, to_height = height[tail], height[head]
    leaves = (from_height > 0) & (to_height < 0)
    enters = (from_height < 0) & (to_height > 0)

    # each crossed edge gets one new vertex, numbered where its half-edge leaves
    count = len(solids.vertices)
    share = (from_height[leaves] / (from_height[leaves] - to_height[leaves]))[:, None]
    start, end = solids.vertices[tail[leaves]], solids.vertices[head[leaves]]
    vertices = np.concatenate([solids.vertices, start + share * (end - start)])
    crossing = np.full(len(tail), -1)
    crossing[leaves] = count + np.arange(int(leaves.sum()))
    key = tail[leaves] * count + head[leaves]
    sorting = np.argsort(key)
    wanted = head[enters] * count + tail[enters]
    crossing[enters] = crossing[leaves][sorting[np.searchsorted(key, wanted, sorter=sorting)]]

    # what stays of each face: its kept vertices and the crossings, in order
    slots = np.stack([tail, crossing], axis=1)
    stays = np.stack([from_height >= 0, crossing >= 0], axis=1)
    face = solids.face_of_loop
    sizes = np.bincount(face, weights=stays.sum(axis=1), minlength=len(solids.kinds)).astype(int)
    kept = sizes >= 3
    loops = slots[stays & kept[face][:, None]]

    # the cap runs, in each cut face, from where the loop comes back to where it went out
    out = (from_height >= 0) & (to_height < 0)
    back = (from_height < 0) & (to_height >= 0)
    went, came = np.full((2, len(solids.kinds)), -1)
    went[face[out]] = np.where(from_height[out] > 0, crossing[out], tail[out])
    came[face[back]] = np.where(to_height[back] > 0, crossing[back], head[back])
    open_faces = np.flatnonzero((went >= 0) & (went != came))
    follower = np.full(len(vertices), -1)
    follower[came[open_faces]] = went[open_faces]
    solid = solids.solid_of_face[open_faces]
    cap_sizes = np.bincount(solid, minlength=len(solids))
    cap_solids = np.flatnonzero(cap_sizes >= 3)
    cap_sizes = cap_sizes[cap_solids]
    ring = np.empty((len(cap_solids), int(cap_sizes.max(initial=0))), dtype=np.int64)
    first = np.full(len(solids), -1)
    first[solid] = came[open_faces]
    current = first[cap_solids]
    for step in range(ring.shape[1]):
        ring[:, step] = current
        current = follower[current]
    cap_loops = ring[np.arange(ring.shape[1]) < cap_sizes[:, None]]

    faces_owner = np.concatenate([solids.solid_of_face[kept], cap_solids])
    all_sizes = np.concatenate([sizes[kept], cap_sizes])
    order = np.argsort(faces_owner, kind="stable")
    starts = offsets(all_sizes)
    loops = np.concatenate([loops, cap_loops])[ranges(starts[:-1][order], starts[1:][order])]
    used, loops = np.unique(loops, return_inverse=True)
    cap_normals = -normals[cap_solids]
    return (
        Polyhedra(
            vertices=vertices[used],
            loops=loops,
            face_offsets=offsets(all_sizes[order]),
            solid_offsets=offsets(np.bincount(faces_owner, minlength=len(solids))),
            normals=np.concatenate([solids.normals[kept], cap_normals])[order],
            levels=np.concatenate([solids.levels[kept], -levels[cap_solids]])[order],
            kinds=np.concatenate([solids.kinds[kept], np.full(len(cap_solids), kind)])[order],
            mates=np.concatenate([solids.mates[kept], mates[cap_solids]])[order],
        ),
        left,
    )
