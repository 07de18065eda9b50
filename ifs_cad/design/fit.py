"""How much of a sheet a panel takes, at the best angle or with the fibre along the sheet.

A convex polygon fits a sheet when its extents at some angle are at most the sheet's. Between two
angles at which an edge lies along or across the sheet, each extent is the length of one diagonal
times a cosine, so the larger of the two shares is smallest at such an angle, or where both are
equal. Looking at these few angles is exact.

Source: the paper, section 4.3 (panels are cut from sheets).
"""

from __future__ import annotations

import numpy as np

from ifs_cad.design.mesh import Mesh
from ifs_cad.types import FloatArray
from ifs_cad.vectors import cross

__all__ = ["sheet_shares"]


def sheet_shares(
    mesh: Mesh, size: tuple[float, float], fibre: FloatArray | None = None
) -> FloatArray:
    """Return by which factor each face would have to shrink to fit a sheet; up to 1 it fits.

    Parameters
    ----------
    mesh : Mesh
    size : (length, width) of the sheet, mm
    fibre : (3,) float, optional
        A direction in space. Each face is then laid with the nearest direction in its plane along
        the sheet; a face square to it may be laid anyhow. Without it every angle is tried.

    Returns
    -------
    (f,) float
    """
    shares = np.empty(len(mesh))
    for corners in np.unique(mesh.sizes):
        faces = np.flatnonzero(mesh.sizes == corners)
        ring = mesh.positions[mesh.offsets[faces, None] + np.arange(corners)]
        x = mesh.directions[mesh.offsets[faces]]
        frame = np.stack([x, cross(mesh.normals[faces], x)], axis=-1)
        flat = (ring - ring[:, :1]) @ frame
        shares[faces] = _at_angles(flat, _best_angles(flat, size), size).min(axis=1)
        if fibre is not None:
            along = np.einsum("fij,i->fj", frame, fibre / np.linalg.norm(fibre))
            laid = np.linalg.norm(along, axis=1) > mesh.tol.parallel
            angle = np.arctan2(along[:, 1], along[:, 0])[:, None]
            shares[faces[laid]] = _at_angles(flat, angle, size)[laid, 0]
    return shares


def _at_angles(flat: FloatArray, angles: FloatArray, size: tuple[float, float]) -> FloatArray:
    """Return (f, a) shares of (f, k, 2) polygons with the sheet's length at (f, a) angles."""
    along = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    extents = (np.ptp(flat @ direction, axis=1) for direction in (along, across))
    shares = [extent / side for extent, side in zip(extents, size, strict=True)]
    return np.asarray(np.maximum(shares[0], shares[1]))


def _best_angles(flat: FloatArray, size: tuple[float, float]) -> FloatArray:
    """Return (f, 4 k) angles, among which is the best."""
    edges = np.roll(flat, -1, axis=1) - flat
    aligned = np.arctan2(edges[..., 1], edges[..., 0])
    turns = np.sort(np.concatenate([aligned, aligned + np.pi / 2], axis=1) % np.pi, axis=1)
    middles = (turns + np.roll(turns, -1, axis=1)) / 2
    middles[:, -1] += np.pi / 2  # from the last angle to the first of the next half turn
    along = np.stack([np.cos(middles), np.sin(middles)], axis=-1)
    across = np.stack([-along[..., 1], along[..., 0]], axis=-1)
    spans = []
    for direction in (along, across):
        heights = flat @ direction.swapaxes(1, 2)
        high, low = heights.argmax(axis=1), heights.argmin(axis=1)
        spans.append(
            np.take_along_axis(flat, high[..., None], axis=1)
            - np.take_along_axis(flat, low[..., None], axis=1)
        )
    one, other = spans[0] / size[0], spans[1] / size[1]
    equal = np.arctan2(other[..., 1] - one[..., 0], one[..., 1] + other[..., 0])
    return np.concatenate([turns, equal], axis=1)
