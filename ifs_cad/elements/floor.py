"""The floor a shell stands on: which borders stand, and whether they reach it.

A floor is a half-space that trims the panels it crosses; nothing is extended. So a border that
stands must lie on the floor or below it everywhere. A border *stands* when at least half of its
nodes do; the others are openings, such as the faces of an arch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.design.mesh import Mesh
from ifs_cad.errors import FloorError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import BoolArray, FloatArray, IntArray, Plane

STANDING_SHARE = 0.5  # of the nodes of a border that must be down for it to stand


@dataclass(frozen=True)
class Opening:
    """A designed border that does not stand.

    Attributes
    ----------
    addresses : the panels along it, in no order
    height : float, how high its highest node lies above the floor, mm
    """

    addresses: tuple[str, ...]
    height: float


def standing_chains(mesh: Mesh, floor: Plane, tol: Tolerance = DEFAULT) -> list[bool]:
    """Tell for each chain of the mesh whether it stands; panels left out do not change that."""
    whole = mesh if mesh.origin is None else mesh.origin[0]
    below = floor.height(whole.positions) <= tol.planar
    return [_share_down(whole, below, chain) >= STANDING_SHARE for chain in whole.chains]


def openings(mesh: Mesh, floor: Plane, tol: Tolerance = DEFAULT) -> tuple[Opening, ...]:
    """Return the borders that do not stand."""
    height = floor.height(mesh.positions)
    return tuple(
        Opening(tuple(mesh.names(mesh.face[chain])), float(height[chain].max()))
        for chain, stands in zip(mesh.chains, standing_chains(mesh, floor, tol), strict=True)
        if len(chain) and not stands
    )


def require_standing(
    mesh: Mesh, floor: Plane, lower: FloatArray, upper: FloatArray, tol: Tolerance = DEFAULT
) -> None:
    """Raise unless every standing border lies below the floor through the panels' thickness.

    Parameters
    ----------
    lower, upper : (corners, 3) float, corner points on the two faces of the panels, mm

    Raises
    ------
    FloorError
        Gives the drop needed and the panels above the floor; or no border stands at all.
    """
    ends = [np.union1d(chain, mesh.next[chain]) for chain in mesh.chains]
    if not any(len(corners) for corners in ends):
        raise FloorError("A closed mesh has no border to stand on. Leave the floor out.")
    stands = standing_chains(mesh, floor, tol)
    heights = np.maximum(floor.height(lower), floor.height(upper))
    if not any(stands):
        lowest = min(float(heights[corners].max()) for corners in ends if len(corners))
        raise FloorError(
            "No border reaches the floor with half of its nodes. Lower the shell, or raise the "
            f"floor: by {lowest:.3f} mm the lowest border would stand.",
            drop=lowest,
        )
    feet = np.concatenate([c for c, s in zip(ends, stands, strict=True) if s])
    above = heights[feet] > tol.planar
    if above.any():
        names, drop = mesh.names(mesh.face[feet[above]]), float(heights[feet].max())
        raise FloorError(
            f"A standing border lies up to {drop:.3f} mm above the floor at {listed(names)}. Lower "
            "the shell by that much, or raise the floor; nothing is extended.",
            addresses=names,
            drop=drop,
        )


def _share_down(mesh: Mesh, below: BoolArray, chain: IntArray) -> float:
    """Return the share of the nodes of a chain that are down, its last one included."""
    nodes = np.union1d(mesh.corners[chain], mesh.corners[mesh.next[chain]])
    is_down = np.zeros(len(mesh.vertices), dtype=bool)
    is_down[mesh.corners] = below
    return float(is_down[nodes].mean())
