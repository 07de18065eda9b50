"""The surface that is analysed: the design faces of the panels that are made.

The *design face* of a panel stands for its middle surface, wherever the panel lies on it: only in
it do neighbours share their edges exactly, as hinge lines. Off by half a thickness, that changes
lengths by the thickness over the radius of curvature. A floor cuts the faces as it cuts the
panels; what it leaves lower than half a thickness is left out, and nodes that low stand on it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ifs_cad.design.mesh import Mesh
from ifs_cad.elements.panel import Shell
from ifs_cad.errors import FloorError
from ifs_cad.types import BoolArray, FloatArray, IntArray
from ifs_cad.vectors import dot


@dataclass(frozen=True, eq=False)
class Surface:
    """Planar polygons, one for each panel that carries.

    Attributes
    ----------
    mesh : Mesh
    mesh_of_shell : Mesh, before the floor cut it
    panels : (f,) int, the panel of the shell that each face stands for
    origin : (corners,) int
        The half-edge of the shell's mesh on which each half-edge lies; -1 along the floor.
    standing : (corners,) bool, the half-edges on which the shell stands
    """

    mesh: Mesh
    mesh_of_shell: Mesh
    panels: IntArray
    origin: IntArray
    standing: BoolArray


def surface_of(shell: Shell) -> Surface:
    """Return the surface of a shell.

    Without a floor, a shell stands on the border edges whose two ends lie no more than half a
    thickness above its lowest point.

    Raises
    ------
    FloorError
        The floor leaves nothing.
    """
    whole, floor = shell.mesh, shell.thickening.floor
    step = shell.thickness / 2
    if floor is None:
        heights = np.full(len(whole.vertices), np.inf)
    else:
        heights = floor.height(whole.vertices)
        heights = np.where(heights < step, np.minimum(heights, 0.0), heights)
    made = np.full(len(whole), -1)
    made[shell.faces] = np.arange(len(shell))
    points, corners, sizes, origin = _cut(whole, heights, made >= 0)
    kept = np.flatnonzero(sizes)
    if not len(kept):
        raise FloorError("The floor leaves nothing of the design faces. Raise the shell.")
    used, renumbered = np.unique(corners, return_inverse=True)
    faces = np.split(renumbered.astype(np.int64), np.cumsum(sizes[kept])[:-1])
    names = tuple(whole.addresses[i] for i in kept)
    mesh = Mesh(points[used], faces, addresses=names, tol=whole.tol)
    if floor is None:
        above = mesh.vertices[:, 2] - mesh.vertices[:, 2].min() - step
    else:
        above = floor.height(mesh.vertices) - step
    low = above[mesh.corners] <= 0
    standing = (mesh.twin < 0) & low & low[mesh.next]
    return Surface(mesh, whole, made[kept], origin, standing)


def _cut(
    mesh: Mesh, heights: FloatArray, made: BoolArray
) -> tuple[FloatArray, IntArray, IntArray, IntArray]:
    """Cut the faces at height zero.

    Returns
    -------
    (v, 3) points, (corners,) their numbers around each face, (f,) sizes (0: nothing left), and
    (corners,) the half-edge of the mesh on which each half-edge lies, -1 along the cut.
    """
    start, end = mesh.corners, mesh.corners[mesh.next]
    low, high = np.minimum(start, end), np.maximum(start, end)
    crossing = (heights[start] < 0) & (heights[end] > 0)
    crossing |= (heights[start] > 0) & (heights[end] < 0)
    edges, edge_of = np.unique(np.stack([low, high])[:, crossing], axis=1, return_inverse=True)
    if edges.shape[1]:
        share = heights[edges[0]] / (heights[edges[0]] - heights[edges[1]])
        new = mesh.vertices[edges[0]]
        new = new + share[:, None] * (mesh.vertices[edges[1]] - new)
    else:
        new = np.empty((0, 3))
    half = np.arange(len(start))
    above = heights[start] >= 0
    leaving = heights[end] < 0  # then what follows is the cut
    keys = np.concatenate([2 * half[above], 2 * half[crossing] + 1])
    numbers = np.concatenate([start[above], len(mesh.vertices) + edge_of.ravel()])
    along = np.concatenate(
        [
            np.where((heights[start] == 0) & leaving, -1, half)[above],
            np.where(leaving, -1, half)[crossing],
        ]
    )
    order = np.argsort(keys)
    face = mesh.face[keys[order] // 2]
    numbers, along = numbers[order], along[order]
    sizes = np.bincount(face, minlength=len(mesh))
    # of a face that only touches the floor from below, an edge or a corner is left
    inside = np.zeros(len(mesh), dtype=bool)
    inside[mesh.face[heights[start] > 0]] = True
    keep = (made & inside)[face]
    return (
        np.concatenate([mesh.vertices, new]),
        numbers[keep],
        np.where(made & inside, sizes, 0),
        along[keep],
    )


def element_frames(corners: FloatArray) -> FloatArray:
    """Return the axes of flat quads: along the first side, square to it, normal.

    Parameters
    ----------
    corners : (..., 4, 3) float, mm

    Returns
    -------
    (..., 3, 3) float, unit vectors in rows
    """
    normal = np.cross(
        corners[..., 2, :] - corners[..., 0, :], corners[..., 3, :] - corners[..., 1, :]
    )
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    first = corners[..., 1, :] - corners[..., 0, :]
    first = first - dot(first, normal)[..., None] * normal
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    return np.stack([first, np.cross(normal, first), normal], axis=-2)
