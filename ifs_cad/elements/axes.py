"""Node axes: cut planes that meet in one line at every node of a vector sum.

A *parallel mesh* has edges parallel to those of the design. Its differences l from the design are
*node axes*: the cut plane of an edge holds the edge and the axes at both its ends, which therefore
must be coplanar with the edge - and they are, because l_w - l_v is parallel to it. Then no two
panels share volume, at any thickness. The axes are chosen by least squares so that n . l = 1 for
the faces around each node; what is missing shows as a *lip*, offset edges of neighbours at
slightly different heights. Where a fit without rest exists, the design is conical.

On the lattice of a vector sum the parallel meshes are found by marching: the scales of the edges
along two borders are free, and each quad passes them on to its two other edges.
"""

from __future__ import annotations

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.design.mesh import Mesh
from ifs_cad.errors import GeometryError, InputError, SizeError
from ifs_cad.tolerance import DEFAULT, MEMORY_LIMIT, Tolerance
from ifs_cad.types import FloatArray, IntArray
from ifs_cad.vectors import cross, dot


def node_axes(mesh: Mesh, tol: Tolerance = DEFAULT) -> FloatArray:
    """Return the (v, 3) axes at the vertices of a vector sum, dimensionless.

    A mesh with panels left out takes the axes of the whole, so that the others stay as they are.

    Raises
    ------
    InputError
        The mesh is not a vector sum.
    SizeError
        The fit would take more memory than `tolerance.MEMORY_LIMIT`.
    GeometryError
        An axis lies in a face it should rise from; names the faces.
    """
    whole, vertices = (mesh, None) if mesh.origin is None else mesh.origin
    if whole.lattice is None:
        raise InputError(
            'Node axes need the lattice of a vector sum. Use nodes="relief" for this mesh.'
        )
    axes = _fitted(whole, tol)
    rises = dot(axes[whole.corners], whole.normals[whole.face])
    flat = rises <= tol.parallel
    if flat.any():
        names = whole.names(whole.face[flat])
        raise GeometryError(
            f'No node axes rise from the faces {listed(names)}. Use nodes="relief".',
            addresses=names,
        )
    return axes if vertices is None else axes[vertices]


def _fitted(mesh: Mesh, tol: Tolerance) -> FloatArray:
    assert mesh.lattice is not None
    grid = mesh.lattice
    rows, columns = grid.shape[0] - 1, grid.shape[1] - 1
    unknowns = rows + columns + 3
    needed = 8 * unknowns * (4 * rows * columns + 6 * (rows + 1) * (columns + 1))
    if needed > MEMORY_LIMIT:
        raise SizeError(
            f"Fitting node axes to {rows} x {columns} faces takes {needed / 2**30:.1f} GiB, more "
            f'than the limit of {MEMORY_LIMIT / 2**30:.1f}. Use nodes="relief".',
            bytes=needed,
        )
    basis = _parallel_meshes(mesh, grid)

    normals = mesh.normals.reshape(rows, columns, 1, 1, 3)
    corners = np.stack([basis[:-1, :-1], basis[1:, :-1], basis[1:, 1:], basis[:-1, 1:]], axis=2)
    equations = (normals @ corners).reshape(-1, unknowns)
    closing = [
        (basis[-1] - basis[0])[grid[-1] == grid[0]].reshape(-1, unknowns),
        (basis[:, -1] - basis[:, 0])[grid[:, -1] == grid[:, 0]].reshape(-1, unknowns),
    ]
    free = _null_space(np.concatenate(closing), tol)
    solution = np.linalg.lstsq(equations @ free, np.ones(len(equations)), rcond=tol.rank)[0]
    axes = np.empty((len(mesh.vertices), 3))
    axes[grid] = basis @ (free @ solution)
    return axes


def _parallel_meshes(mesh: Mesh, grid: IntArray) -> FloatArray:
    """Return (rows + 1, columns + 1, 3, unknowns): each node's axis for each free scale."""
    rows, columns = grid.shape[0] - 1, grid.shape[1] - 1
    points = mesh.vertices[grid] / mesh.edge_lengths.mean()
    along_a = points[1:] - points[:-1]
    along_b = points[:, 1:] - points[:, :-1]
    near_a, far_a = along_a[:, :-1], along_a[:, 1:]
    near_b, far_b = along_b[:-1], along_b[1:]
    normal = mesh.normals.reshape(rows, columns, 3)
    area = dot(cross(far_a, far_b), normal)
    # near_scale_a near_a + far_scale_b far_b = near_scale_b near_b + far_scale_a far_a
    a_from_a = dot(cross(near_a, far_b), normal) / area
    a_from_b = -dot(cross(near_b, far_b), normal) / area
    b_from_a = dot(cross(near_a, far_a), normal) / area
    b_from_b = -dot(cross(near_b, far_a), normal) / area

    unknowns = rows + columns + 3
    scale_a = np.zeros((rows, columns + 1, unknowns))
    scale_b = np.zeros((rows + 1, columns, unknowns))
    scale_a[np.arange(rows), 0, np.arange(rows)] = 1.0
    scale_b[0, np.arange(columns), rows + np.arange(columns)] = 1.0
    for diagonal in range(rows + columns - 1):
        i = np.arange(max(0, diagonal - columns + 1), min(rows, diagonal + 1))
        j = diagonal - i
        from_a, from_b = scale_a[i, j], scale_b[i, j]
        scale_a[i, j + 1] = a_from_a[i, j, None] * from_a + a_from_b[i, j, None] * from_b
        scale_b[i + 1, j] = b_from_a[i, j, None] * from_a + b_from_b[i, j, None] * from_b

    basis = np.zeros((rows + 1, columns + 1, 3, unknowns))
    basis[0, 0, :, -3:] = np.eye(3)
    steps = along_a[:, 0, :, None] * scale_a[:, 0, None, :]
    basis[1:, 0] = basis[0, 0] + np.cumsum(steps, axis=0)
    steps = along_b[..., None] * scale_b[:, :, None, :]
    basis[:, 1:] = basis[:, :1] + np.cumsum(steps, axis=1)
    return basis


def _null_space(constraints: FloatArray, tol: Tolerance) -> FloatArray:
    """Return orthonormal columns that span the solutions of constraints @ x = 0."""
    if len(constraints) == 0:
        return np.eye(constraints.shape[1])
    _, singular, rows = np.linalg.svd(constraints)
    rank = int((singular > tol.rank * singular.max(initial=0.0)).sum())
    return np.asarray(rows[rank:].T)
