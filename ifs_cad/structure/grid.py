"""The finite element mesh: every panel divided into quads, matching along shared edges.

A four-sided panel becomes n x n quads; any other polygon is first split from its centroid into
one block for each corner, each n/2 x n/2, so that every edge of every panel carries n divisions.

A *grid node* belongs to one panel; a *point* is a place in space where nodes of several panels
meet. Points are found from the topology of the mesh, never by comparing coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.design.mesh import Mesh
from ifs_cad.errors import AddressError, InputError
from ifs_cad.structure.surface import element_frames
from ifs_cad.types import FloatArray, IntArray
from ifs_cad.vectors import cross, dot, length

GAUSS = 1 / np.sqrt(3)
SQUARE = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], dtype=float)
"""Corners of the reference square."""
SHAPES = (
    (1 + GAUSS * SQUARE[:, None, 0] * SQUARE[:, 0])
    * (1 + GAUSS * SQUARE[:, None, 1] * SQUARE[:, 1])
    / 4
)
"""(4, 4) float, values of the four bilinear shape functions at each of the four Gauss points."""


@dataclass(frozen=True, eq=False)
class Grid:
    """Quads of all panels.

    Attributes
    ----------
    mesh : Mesh
        The polygons that were divided.
    divisions : int, quads along every edge of a polygon
    nodes : (v, 3) float, mm
    quads : (e, 4) int, nodes, counter-clockwise seen from outside
    face_of_node, face_of_quad : (v,) and (e,) int, the polygon of each
    point : (v,) int, the point at which each node lies
    edges : (corners, divisions + 1) int, the nodes along each half-edge of the mesh, in order
    """

    mesh: Mesh
    divisions: int
    nodes: FloatArray
    quads: IntArray
    face_of_node: IntArray
    face_of_quad: IntArray
    point: IntArray
    edges: IntArray

    @cached_property
    def points(self) -> int:
        """Number of points."""
        return int(self.point.max()) + 1

    @cached_property
    def corners(self) -> FloatArray:
        """(e, 4, 3) float, the corners of the quads, mm."""
        return self.nodes[self.quads]

    @cached_property
    def frames(self) -> FloatArray:
        """(e, 3, 3) float, axes of the quads: along the first side, square to it, normal."""
        return element_frames(self.corners)

    @cached_property
    def gauss_points(self) -> FloatArray:
        """(e, 4, 3) float, the points at which quads are integrated, mm."""
        return np.asarray(SHAPES @ self.corners)

    @cached_property
    def gauss_areas(self) -> FloatArray:
        """(e, 4) float, the area that belongs to each of them, mm2."""
        corners = self.corners
        ahead, up = corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0]
        twist = corners[:, 2] - corners[:, 1] - up
        s, t = (1 + GAUSS * SQUARE[:, :, None, None].transpose(1, 0, 2, 3)) / 2
        along = ahead + t * twist  # (4, e, 3)
        across = up + s * twist
        return length(cross(along, across)).T / 4

    @cached_property
    def blocks(self) -> tuple[IntArray, IntArray]:
        """Nodes in rows and columns: of four-sided polygons, of the corners of others.

        (k, n + 1, n + 1) and (c, n / 2 + 1, n / 2 + 1) int.
        """
        inside = int((self.mesh.sizes == 4).sum()) * self.divisions**2
        return (
            _lattices(self.quads[:inside], self.divisions),
            _lattices(self.quads[inside:], max(self.divisions // 2, 1)),
        )

    @cached_property
    def areas(self) -> FloatArray:
        """(e,) float, mm2."""
        return np.asarray(self.gauss_areas.sum(axis=1))

    @cached_property
    def node_areas(self) -> FloatArray:
        """(v,) float, the share of its panel that belongs to each node, mm2."""
        shares = self.gauss_areas @ SHAPES
        return np.asarray(
            np.bincount(self.quads.ravel(), shares.ravel(), len(self.nodes)), dtype=float
        )

    def angles(self, directions: FloatArray) -> FloatArray:
        """Return how far the first side of each quad turns to a direction, (e,) radians.

        Parameters
        ----------
        directions : (e, 3) float, in the planes of the quads
        """
        first, second, _ = np.moveaxis(self.frames, 1, 0)
        return np.arctan2(dot(directions, second), dot(directions, first))

    def nearest(self, place: FloatArray) -> int:
        """Return the node nearest to a (3,) point."""
        return int(np.argmin(length(self.nodes - place)))

    def middle(self, address: str) -> int:
        """Return the node of a panel nearest to its centroid.

        Raises
        ------
        AddressError
            No panel has the address.
        """
        if address not in self.mesh.addresses:
            raise AddressError(f"No panel has the address {address!r}.", addresses=[address])
        face = self.mesh.addresses.index(address)
        own = np.flatnonzero(self.face_of_node == face)
        return int(own[np.argmin(length(self.nodes[own] - self.mesh.centroids[face]))])

    def address(self, node: int) -> str:
        """Return the address of the panel of a node."""
        return self.mesh.addresses[int(self.face_of_node[node])]


def divide(mesh: Mesh, divisions: int) -> Grid:
    """Divide every polygon of a mesh into quads.

    Raises
    ------
    InputError
        `divisions` below 1, or odd where a polygon has not four sides.
    """
    if divisions < 1 or divisions != int(divisions):
        raise InputError(f"divisions must be a whole number from 1 upwards, got {divisions}.")
    four = mesh.sizes == 4
    if divisions % 2 and not four.all():
        names = [mesh.addresses[i] for i in np.flatnonzero(~four)]
        raise InputError(
            f"{listed(names)} have not four sides and are split from their centroids: divisions "
            f"must be even, got {divisions}.",
            addresses=names,
        )
    labels = _Labels(mesh, divisions)
    blocks = [_quad_blocks(mesh, labels, np.flatnonzero(four))]
    if not four.all():
        blocks.append(_corner_blocks(mesh, labels, np.flatnonzero(~four[mesh.face])))
    keys, places, faces, quads = [], [], [], []
    count = labels.count
    start = 0
    for label, corners, face in blocks:
        size = label.shape[1] - 1
        inner = label[:, 1:-1, 1:-1]
        inner[...] = count + np.arange(inner.size).reshape(inner.shape)
        count += inner.size
        s = np.arange(size + 1) / size
        s, t = s[:, None, None], s[None, :, None]
        a, b, c, d = np.moveaxis(corners, 1, 0)[:, :, None, None]
        places.append((1 - s) * (1 - t) * a + s * (1 - t) * b + s * t * c + (1 - s) * t * d)
        keys.append(label)
        faces.append(np.broadcast_to(face[:, None, None], label.shape))
        number = start + np.arange(label.size).reshape(label.shape)
        start += label.size
        around = [number[:, :-1, :-1], number[:, 1:, :-1], number[:, 1:, 1:], number[:, :-1, 1:]]
        quads.append(np.stack(around, axis=-1).reshape(-1, 4))
    label = np.concatenate([key.ravel() for key in keys])
    face = np.concatenate([one.ravel() for one in faces])
    place = np.concatenate([one.reshape(-1, 3) for one in places])
    unique, first, node = np.unique(face * count + label, return_index=True, return_inverse=True)
    quad = node[np.concatenate(quads)]
    along = mesh.face[:, None] * count + labels.along(np.arange(len(mesh.corners)))
    return Grid(
        mesh=mesh,
        divisions=divisions,
        nodes=place[first],
        quads=quad,
        face_of_node=face[first],
        face_of_quad=face[first][quad[:, 0]],
        point=np.unique(label[first], return_inverse=True)[1],
        edges=np.searchsorted(unique, along),
    )


def _lattices(quads: IntArray, count: int) -> IntArray:
    """Return the nodes of blocks of count x count quads, (b, count + 1, count + 1)."""
    blocks = quads.reshape(-1, count, count, 4)
    lattice = np.empty((len(blocks), count + 1, count + 1), dtype=np.int64)
    lattice[:, :-1, :-1] = blocks[..., 0]
    lattice[:, -1, :-1] = blocks[:, -1, :, 1]
    lattice[:, -1, -1] = blocks[:, -1, -1, 2]
    lattice[:, :-1, -1] = blocks[:, :, -1, 3]
    return lattice


class _Labels:
    """Numbers for points: vertices, then along edges, along spokes to centroids, centroids."""

    def __init__(self, mesh: Mesh, divisions: int) -> None:
        half = np.arange(len(mesh.corners))
        twin = np.where(mesh.twin < 0, half, mesh.twin)
        _, self._edge = np.unique(np.minimum(half, twin), return_inverse=True)
        self._mesh, self._divisions = mesh, divisions
        self._spokes = len(mesh.vertices) + (int(self._edge.max()) + 1) * (divisions - 1)
        inside = max(divisions // 2 - 1, 0)
        self._centroids = self._spokes + len(half) * inside
        self.count = self._centroids + len(mesh)

    def along(self, half: IntArray) -> IntArray:
        """(k, n + 1) int, along half-edges."""
        mesh, n = self._mesh, self._divisions
        start, end = mesh.corners[half], mesh.corners[mesh.next[half]]
        step = np.arange(1, n)
        step = np.where((start < end)[:, None], step, n - step)
        middle = len(mesh.vertices) + self._edge[half][:, None] * (n - 1) + step - 1
        return np.concatenate([start[:, None], middle, end[:, None]], axis=1)

    def spoke(self, half: IntArray) -> IntArray:
        """(k, n / 2 + 1) int, from the middles of half-edges to the centroids of their faces."""
        inside = self._divisions // 2 - 1
        middle = self.along(half)[:, self._divisions // 2]
        between = self._spokes + half[:, None] * inside + np.arange(inside)
        centroid = self._centroids + self._mesh.face[half]
        return np.concatenate([middle[:, None], between, centroid[:, None]], axis=1)


_Block = tuple[IntArray, FloatArray, IntArray]


def _quad_blocks(mesh: Mesh, labels: _Labels, faces: IntArray) -> _Block:
    """Return labels (inner ones unset), corner points and faces of four-sided polygons."""
    corner = mesh.offsets[faces][:, None] + np.arange(4)
    n = labels.along(corner[:0, 0]).shape[1]
    label = np.empty((len(faces), n, n), dtype=np.int64)
    label[:, :, 0] = labels.along(corner[:, 0])
    label[:, -1, :] = labels.along(corner[:, 1])
    label[:, ::-1, -1] = labels.along(corner[:, 2])
    label[:, 0, ::-1] = labels.along(corner[:, 3])
    return label, mesh.positions[corner], faces


def _corner_blocks(mesh: Mesh, labels: _Labels, half: IntArray) -> _Block:
    """Return the same for one block at each of some corners of other polygons."""
    before = mesh.previous[half]
    ahead, back = labels.along(half), labels.along(before)[:, ::-1]
    n = (ahead.shape[1] - 1) // 2 + 1
    label = np.empty((len(half), n, n), dtype=np.int64)
    label[:, :, 0] = ahead[:, :n]
    label[:, 0, :] = back[:, :n]
    label[:, -1, :] = labels.spoke(half)
    label[:, :, -1] = labels.spoke(before)
    middle = mesh.positions + mesh.edge_vectors / 2
    corners = [mesh.positions[half], middle[half], mesh.centroids[mesh.face[half]], middle[before]]
    return label, np.stack(corners, axis=1), mesh.face[half]
