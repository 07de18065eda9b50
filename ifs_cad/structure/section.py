"""Forces in the panels and how far they use up the material's strength.

The mean stress resultants of a quad follow from the forces at its nodes by virtual work: its
nodes are given the displacements of one unit strain, and the work that their forces do is the
resultant times the area. Nothing else of the element need be known.
"""

from __future__ import annotations

import numpy as np

from ifs_cad.elements.material import Strength
from ifs_cad.structure.grid import Grid
from ifs_cad.types import FloatArray
from ifs_cad.vectors import dot

RESULTANTS = (
    *("n_along", "n_across", "n_shear"),
    *("m_along", "m_across", "m_twist"),
    *("q_along", "q_across"),
)
"""Membrane forces, N/mm, positive in tension; bending and twisting moments, N mm/mm, positive where
the outer face is pulled; transverse forces, N/mm."""


def unit_strains(corners: FloatArray, axes: FloatArray) -> FloatArray:
    """Return the displacements of nodes that make one unit strain each, (e, 24, 8).

    Parameters
    ----------
    corners : (e, 4, 3) float, mm
    axes : (e, 3, 3) float, unit vectors in rows: along, across, normal
    """
    apart = corners - corners.mean(axis=1, keepdims=True)
    x = dot(apart, axes[:, None, 0])
    y = dot(apart, axes[:, None, 1])
    local = np.zeros((len(corners), 4, 2, 3, len(RESULTANTS)))  # moves and turns, axes
    local[:, :, 0, 0, 0] = x
    local[:, :, 0, 1, 1] = y
    local[:, :, 0, 0, 2], local[:, :, 0, 1, 2] = y / 2, x / 2
    local[:, :, 1, 1, 3], local[:, :, 0, 2, 3] = x, -(x**2) / 2
    local[:, :, 1, 0, 4], local[:, :, 0, 2, 4] = -y, -(y**2) / 2
    local[:, :, 1, 1, 5], local[:, :, 1, 0, 5], local[:, :, 0, 2, 5] = y / 2, -x / 2, -x * y / 2
    local[:, :, 0, 2, 6] = x
    local[:, :, 0, 2, 7] = y
    turned = np.einsum("eji,enkjr->enkir", axes, local)
    return np.asarray(turned.reshape(len(corners), 24, len(RESULTANTS)))


def resultants(
    grid: Grid, matrices: FloatArray, strained: FloatArray, angles: FloatArray
) -> FloatArray:
    """Return the mean stress resultants of the quads along and across the fibre.

    Parameters
    ----------
    grid : Grid
    matrices : (e, 24, 24) float
    strained : (e, 24) float
        Displacements (mm) and rotations (radians) of the nodes of each quad, with or without a
        small movement as a whole.
    angles : (e,) float, radians, from the first side of each quad to the fibre

    Returns
    -------
    (e, 8) float, in the order of `RESULTANTS`
    """
    first, second, normal = np.moveaxis(grid.frames, 1, 0)
    c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
    axes = np.stack([c * first + s * second, c * second - s * first, normal], axis=1)
    forces = (matrices @ strained[:, :, None])[:, :, 0]
    work = np.einsum("efr,ef->er", unit_strains(grid.corners, axes), forces)
    return np.asarray(work / grid.areas[:, None])


def utilisation(resultant: FloatArray, thickness: float, strength: Strength) -> FloatArray:
    """Return how much of the strength each quad uses; beyond 1 it fails.

    The largest of: bending and membrane force together, along and across the fibre (EN 1995-1-1,
    6.2.3 in tension: the sum of both shares; 6.2.4 in compression: that of the membrane force
    squared); shear in the plane and from twisting together against panel shear; transverse
    shear, 3/2 of the mean, against planar shear.

    Parameters
    ----------
    resultant : (e, 8) float, see `RESULTANTS`
    thickness : float, mm
    strength : Strength
    """
    normal = resultant[:, :2] / thickness
    bending = 6 * np.abs(resultant[:, 3:5]) / thickness**2
    tension = normal / np.array([strength.tension_along, strength.tension_across])
    compression = normal / np.array([strength.compression_along, strength.compression_across])
    membrane = np.where(normal > 0, tension, compression**2)
    bent = bending / np.array([strength.bending_along, strength.bending_across])
    shear = np.abs(resultant[:, 2]) / thickness + 6 * np.abs(resultant[:, 5]) / thickness**2
    planar = 1.5 * np.abs(resultant[:, 6:]) / thickness
    planar = planar / np.array([strength.planar_along, strength.planar_across])
    used = np.column_stack([membrane + bent, shear / strength.shear, planar])
    return np.asarray(used.max(axis=1))
