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
    """Tell for each chain of the mesh whether it stands."""
    below = floor.height(mesh.positions) <= tol.planar
    return [_share_down(mesh, below, chain) >= 0.5 for chain in mesh.chains]


def openings(mesh: Mesh, floor: Plane, tol: Tolerance = DEFAULT) -> tuple[Opening, ...]:
    """Return the borders that do not stand."""
    height = floor.height(mesh.positions)
    return tuple(
        Opening(tuple(mesh.names(mesh.face[chain])), float(height[chain].max()))
        for chain, stands in zip(mesh.chains, standing_chains(mesh, floor, tol), strict=True)
        if not stands
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
    if not mesh.chains:
        raise FloorError("A closed mesh has no border to stand on. Leave the floor out.")
    stands = standing_chains(mesh, floor, tol)
    if not any(stands):
        lowest = min(float(floor.height(mesh.positions[c]).max()) for c in mesh.chains)
        raise FloorError(
            "No border reaches the floor with half of its nodes. Lower the shell, or raise the "
            f"floor: by {lowest:.3f} mm the lowest border would stand.",
            drop=lowest,
        )
    feet = np.concatenate([c for c, s in zip(mesh.chains, stands, strict=True) if s])
    ends = np.concatenate([feet, mesh.next[feet]])
    height = np.maximum(floor.height(lower[ends]), floor.height(upper[ends]))
    above = height > tol.planar
    if above.any():
        names, drop = mesh.names(mesh.face[ends[above]]), float(height.max())
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
