"""A mesh of planar convex polygons: what every shell is made from.

A *corner* is one face at one vertex; corners are numbered face after face, counter-clockwise seen
from the side the normal points to. The *half-edge* of a corner runs from its vertex to the vertex
of the next corner of the same face; its *twin* is the half-edge of the neighbour across the edge,
-1 on a *border*. A *node* is a vertex where faces meet, its *valence* the number of faces.

Source: section 3.4 (surfaces entirely composed of planar elements). Nothing here knows how the
mesh was made: a vector sum is one way, a file another.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import InitVar, dataclass, field, replace
from functools import cached_property

import numpy as np

from ifs_cad.design.address import face_addresses, listed, matching
from ifs_cad.design.reading import require_in_reach
from ifs_cad.errors import (
    ConvexityError,
    DegenerateFaceError,
    InputError,
    ManifoldError,
    PlanarityError,
)
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import ArrayLike, BoolArray, FloatArray, IntArray, frozen
from ifs_cad.vectors import cross, dot, length

Faces = IntArray | Sequence[Sequence[int] | IntArray]


@dataclass(frozen=True, eq=False, repr=False)
class Mesh:
    """Planar convex polygons that share vertices.

    Parameters
    ----------
    vertices : (v, 3) floats, mm
    faces : (f, k) ints, or a sequence of sequences of ints
        Vertex numbers of each face, counter-clockwise seen from outside.
    addresses : f strings, optional
        What files and messages call the faces; f0000, f0001, ... by default.
    lattice : (rows + 1, columns + 1) ints, optional
        Set by the vector sum: the vertex numbers of its nodes. Face r * columns + c lies between
        rows r and r + 1, columns c and c + 1 of them.
    chain_ends : ints, optional
        Border vertices at which one border ends and the next begins (the four corners of a
        vector sum); without them every border loop is one chain.
    origin : (Mesh, (v,) ints), optional
        Set by `without`: the whole mesh, and which of its vertices these are.
    tol : Tolerance

    Raises
    ------
    InputError
        Wrong shapes, NaN, infinite, a vertex number out of range, addresses not unique.
    DegenerateFaceError
        A face with coincident corners or parallel neighbouring edges.
    PlanarityError, ConvexityError
        A face that leaves its plane by more than `tol.planar`, or is not convex.
    ManifoldError
        An edge of more than two faces, or neighbours that disagree about which side is out.
    """

    vertices: FloatArray
    faces: InitVar[Faces]
    addresses: tuple[str, ...] = ()
    lattice: IntArray | None = field(default=None, repr=False)
    chain_ends: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64), repr=False)
    origin: tuple[Mesh, IntArray] | None = field(default=None, repr=False)
    tol: Tolerance = field(default=DEFAULT, repr=False)
    corners: IntArray = field(init=False, repr=False)
    offsets: IntArray = field(init=False, repr=False)

    def __post_init__(self, faces: Faces) -> None:
        vertices = _read_vertices(self.vertices)
        corners, sizes = _read_faces(faces, len(vertices))
        offsets = np.zeros(len(sizes) + 1, dtype=np.int64)
        np.cumsum(sizes, out=offsets[1:])
        addresses = tuple(self.addresses) or tuple(face_addresses(len(sizes)))
        if len(addresses) != len(sizes) or len(set(addresses)) != len(sizes):
            raise InputError(
                f"{len(sizes)} faces need as many different addresses, got {len(addresses)} of "
                f"which {len(set(addresses))} differ."
            )
        for name, value in (
            ("vertices", vertices),
            ("corners", corners),
            ("offsets", offsets),
            ("chain_ends", np.asarray(self.chain_ends, dtype=np.int64)),
        ):
            object.__setattr__(self, name, frozen(value))
        object.__setattr__(self, "addresses", addresses)
        if self.lattice is not None:
            object.__setattr__(self, "lattice", frozen(self.lattice))
        self._require_sound_faces()
        self.twin  # noqa: B018  raises ManifoldError now rather than on first use

    def __repr__(self) -> str:
        return f"<Mesh of {len(self)} faces, {len(self.vertices)} vertices>"

    def __len__(self) -> int:
        """Return the number of faces."""
        return len(self.offsets) - 1

    @property
    def sizes(self) -> IntArray:
        """(f,) int, corners of each face."""
        return np.diff(self.offsets)

    @cached_property
    def face(self) -> IntArray:
        """(corners,) int, the face of each corner."""
        return np.repeat(np.arange(len(self)), self.sizes)

    @cached_property
    def next(self) -> IntArray:
        """(corners,) int, the following corner of the same face."""
        following = np.arange(1, len(self.corners) + 1)
        following[self.offsets[1:] - 1] = self.offsets[:-1]
        return following

    @cached_property
    def previous(self) -> IntArray:
        """(corners,) int, the preceding corner of the same face."""
        preceding = np.arange(-1, len(self.corners) - 1)
        preceding[self.offsets[:-1]] = self.offsets[1:] - 1
        return preceding

    @cached_property
    def positions(self) -> FloatArray:
        """(corners, 3) float, the point of each corner, mm."""
        return self.vertices[self.corners]

    @cached_property
    def edge_vectors(self) -> FloatArray:
        """(corners, 3) float, each half-edge from its vertex to the next one, mm."""
        return self.positions[self.next] - self.positions

    @cached_property
    def edge_lengths(self) -> FloatArray:
        """(corners,) float, mm."""
        return length(self.edge_vectors)

    @cached_property
    def directions(self) -> FloatArray:
        """(corners, 3) float, unit vectors along the half-edges."""
        return self.edge_vectors / self.edge_lengths[:, None]

    @cached_property
    def _area_vectors(self) -> FloatArray:
        """(f, 3) float, Newell's vectors: normal times area, mm2."""
        arms = self.positions - self.positions[self.offsets[:-1]][self.face]
        return np.add.reduceat(cross(arms, arms[self.next]), self.offsets[:-1]) / 2

    @cached_property
    def areas(self) -> FloatArray:
        """(f,) float, mm2."""
        return length(self._area_vectors)

    @cached_property
    def normals(self) -> FloatArray:
        """(f, 3) float, unit vectors, on the side from which corners run counter-clockwise."""
        return self._area_vectors / self.areas[:, None]

    @cached_property
    def centroids(self) -> FloatArray:
        """(f, 3) float, mean of the corners of each face, mm."""
        sums = np.add.reduceat(self.positions, self.offsets[:-1])
        return np.asarray(sums / self.sizes[:, None])

    @cached_property
    def planarity(self) -> FloatArray:
        """(f,) float, largest distance of a corner from the plane of its face, mm."""
        apart = self.positions - self.centroids[self.face]
        return np.maximum.reduceat(np.abs(dot(apart, self.normals[self.face])), self.offsets[:-1])

    @cached_property
    def twin(self) -> IntArray:
        """(corners,) int, the half-edge across the edge, -1 on a border.

        Raises
        ------
        ManifoldError
        """
        start, end = self.corners, self.corners[self.next]
        key = _edge_keys(start, end)
        order = np.argsort(key, kind="stable")
        same = key[order[1:]] == key[order[:-1]]
        one, other = order[:-1][same], order[1:][same]
        crowded = np.flatnonzero(same[1:] & same[:-1])
        if len(crowded):
            names = self.names(self.face[order[np.unique(crowded[:, None] + [0, 1, 2])]])
            raise ManifoldError(
                f"An edge has more than two faces: {listed(names)}. Remove the extra ones.",
                addresses=names,
            )
        turned = start[one] == start[other]
        if turned.any():
            names = self.names(self.face[one[turned]])
            raise ManifoldError(
                f"Neighbouring faces run in opposite senses at {listed(names)}. Orient all faces "
                "counter-clockwise seen from outside.",
                addresses=names,
            )
        twin = np.full(len(key), -1)
        twin[one], twin[other] = other, one
        return twin

    @cached_property
    def node_pairs(self) -> tuple[IntArray, IntArray]:
        """Two (k,) int arrays: corners of faces that share a node but no edge there."""
        one, other = self.same_node
        twin, before = self.twin, self.previous
        edge = (twin[one] == before[other]) | (twin[other] == before[one])
        return one[~edge], other[~edge]

    @cached_property
    def same_node(self) -> tuple[IntArray, IntArray]:
        """Two (k,) int arrays: every pair of corners at the same vertex."""
        order = np.argsort(self.corners, kind="stable")
        vertex = self.corners[order]
        ones, others = [], []
        for lag in range(1, int(self.valences.max(initial=1))):
            together = np.flatnonzero(vertex[lag:] == vertex[:-lag])
            ones.append(order[together])
            others.append(order[together + lag])
        if not ones:
            return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
        return np.concatenate(ones), np.concatenate(others)

    @cached_property
    def valences(self) -> IntArray:
        """(v,) int, number of faces at each vertex."""
        return np.bincount(self.corners, minlength=len(self.vertices))

    @cached_property
    def chains(self) -> tuple[IntArray, ...]:
        """The designed borders: corners whose half-edges lie on one border, for each chain.

        When faces were left out, what remains of the borders of the whole, perhaps nothing; the
        borders that opened belong to no chain.
        """
        border = np.flatnonzero(self.twin < 0)
        start, end = self.corners[border], self.corners[self.next[border]]
        if self.origin is not None:
            whole, vertices = self.origin
            key = _edge_keys(vertices[start], vertices[end])
            known = _edge_keys(whole.corners, whole.corners[whole.next])
            return tuple(border[np.isin(key, known[chain])] for chain in whole.chains)
        leaving = np.full(len(self.vertices), -1)
        leaving[start] = np.arange(len(border))
        stop = np.zeros(len(self.vertices), dtype=bool)
        stop[self.chain_ends] = True
        follower = np.where(stop[end], -1, leaving[end])
        follower = np.where(follower < 0, np.arange(len(border)), follower)
        label = np.arange(len(border))
        while True:  # every edge takes the smallest label of its chain
            joined = label.copy()
            np.minimum.at(joined, follower, label)
            joined = np.minimum(joined, joined[follower])
            if (joined == label).all():
                break
            label = joined
        return tuple(border[label == value] for value in np.unique(label))

    def names(self, faces: ArrayLike) -> list[str]:
        """Return the addresses of some faces, each once, in order."""
        return [self.addresses[i] for i in np.unique(np.asarray(faces, dtype=np.int64))]

    def neighbours(self, face: int) -> list[str]:
        """Return the addresses across the edges of a face, in the order of its edges."""
        across = self.twin[self.offsets[face] : self.offsets[face + 1]]
        return [self.addresses[self.face[h]] if h >= 0 else "" for h in across]

    def with_addresses(self, addresses: Iterable[str]) -> Mesh:
        """Return the same mesh under other addresses."""
        return replace(self, faces=self.polygons(), addresses=tuple(addresses))

    def flipped(self) -> Mesh:
        """Return the same mesh with the other side out."""
        faces = [polygon[::-1] for polygon in self.polygons()]
        return replace(self, faces=faces)

    def polygons(self) -> list[list[int]]:
        """Return the faces as lists of vertex numbers."""
        return [part.tolist() for part in np.split(self.corners, self.offsets[1:-1])]

    def without(self, patterns: str | Iterable[str]) -> Mesh:
        """Return the mesh with the faces left out whose addresses match (`"03*"`).

        Edges of the faces that stay become borders of their own, not of the designed ones.

        Raises
        ------
        AddressError
            Nothing matches.
        InputError
            Nothing would be left.
        """
        return self.less(matching(self.addresses, patterns))

    def less(self, gone: BoolArray) -> Mesh:
        """Return the mesh without the faces for which the (f,) bools are set; see `without`."""
        if gone.all():
            raise InputError(f"Leaving out all {len(self)} faces leaves no mesh.")
        keep = ~gone[self.face]
        used, corners = np.unique(self.corners[keep], return_inverse=True)
        sizes = self.sizes[~gone]
        whole, vertices = (self, used) if self.origin is None else self.origin
        return replace(
            self,
            vertices=self.vertices[used],
            faces=np.split(corners.astype(np.int64), np.cumsum(sizes)[:-1]),
            addresses=tuple(np.array(self.addresses, dtype=object)[~gone]),
            lattice=None,
            chain_ends=np.empty(0, dtype=np.int64),
            origin=(whole, vertices if self.origin is None else vertices[used]),
        )

    def _require_sound_faces(self) -> None:
        tol = self.tol
        short = self.edge_lengths <= tol.coincident
        if short.any():
            names = self.names(self.face[short])
            raise DegenerateFaceError(
                f"Corners coincide in {listed(names)}. Remove one of the points.", addresses=names
            )
        flat = self.areas <= tol.parallel * np.maximum.reduceat(
            self.edge_lengths, self.offsets[:-1]
        ) * np.minimum.reduceat(self.edge_lengths, self.offsets[:-1])
        if flat.any():
            names = self.names(np.flatnonzero(flat))
            raise DegenerateFaceError(
                f"Faces without area: {listed(names)}. Their edges are parallel; turn one of the "
                "curves.",
                addresses=names,
            )
        apart = self.planarity > tol.planar
        if apart.any():
            names, worst = self.names(np.flatnonzero(apart)), float(self.planarity.max())
            raise PlanarityError(
                f"Faces leave their plane by up to {worst:.3g} mm (allowed {tol.planar:g}): "
                f"{listed(names)}. Planarise them or split them into triangles.",
                addresses=names,
                deviation=worst,
            )
        back = self.directions[self.previous]
        turn_vector = cross(back, self.directions)
        sine = dot(turn_vector, self.normals[self.face])
        straight = np.abs(sine) <= tol.parallel
        if straight.any():
            names = self.names(self.face[straight])
            raise DegenerateFaceError(
                f"Neighbouring edges are parallel in {listed(names)}. Turn one of the curves, or "
                "remove the point between the edges.",
                addresses=names,
            )
        # a star turns left at every corner too, but turns more than once around
        turn = np.arctan2(sine, dot(back, self.directions))
        around = np.add.reduceat(turn, self.offsets[:-1])
        hollow = np.add.reduceat((sine < 0).astype(int), self.offsets[:-1]) > 0
        hollow |= around > 3 * np.pi
        if hollow.any():
            names = self.names(np.flatnonzero(hollow))
            raise ConvexityError(
                f"Faces are not convex: {listed(names)}. Split them into convex ones.",
                addresses=names,
            )


def _edge_keys(start: IntArray, end: IntArray) -> IntArray:
    """Return one number for each edge, the same for both of its senses."""
    return np.asarray(np.minimum(start, end) * (1 << 32) + np.maximum(start, end))


def _read_vertices(value: ArrayLike) -> FloatArray:
    try:
        vertices = np.array(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(f"Vertices must be (v, 3) numbers: {error}.") from error
    if vertices.ndim != 2 or vertices.shape[1] != 3 or len(vertices) < 3:
        raise InputError(f"Vertices must be (v, 3) with v >= 3, got shape {vertices.shape}.")
    require_in_reach(vertices, "Vertices")
    return vertices


def _read_faces(value: Faces, count: int) -> tuple[IntArray, IntArray]:
    if isinstance(value, np.ndarray) and value.ndim == 2:
        numbers, sizes = value.ravel(), np.full(len(value), value.shape[1], dtype=np.int64)
    else:
        try:
            parts = [np.asarray(polygon).ravel() for polygon in value]
        except (TypeError, ValueError) as error:
            raise InputError(f"Faces must be lists of vertex numbers: {error}.") from error
        numbers = np.concatenate(parts) if parts else np.empty(0, dtype=np.int64)
        sizes = np.array([len(part) for part in parts], dtype=np.int64)
    if len(sizes) == 0:
        raise InputError("A mesh needs at least one face.")
    if (sizes < 3).any():
        raise InputError(f"Face {int(np.argmin(sizes))} has fewer than three corners.")
    if numbers.dtype.kind not in "iu":
        raise InputError("Faces must be lists of vertex numbers, whole and counted from 0.")
    corners = np.array(numbers, dtype=np.int64)
    wild = (corners < 0) | (corners >= count)
    if wild.any():
        face = int(np.searchsorted(np.cumsum(sizes), np.argmax(wild), side="right"))
        raise InputError(f"Face {face} names a vertex outside 0..{count - 1}.")
    return corners, sizes
