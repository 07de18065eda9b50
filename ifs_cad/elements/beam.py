"""Wire-frame designs: every edge of a mesh becomes a beam.

A beam runs along its edge, its height along the sum of the normals of the faces it joins, its axis
on the edge. Its ends are square and set back from the node just so far that no two beams there
share volume; what remains free is room for the node's connector.

Source: section 3.3 (wire frame structures, the number of bars per node) and section 4 (the line
sections are substituted by linear constructional elements).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.design.mesh import Mesh
from ifs_cad.elements.material import SPRUCE, Material
from ifs_cad.elements.polyhedron import Kind, Polyhedra, Prismatoids
from ifs_cad.errors import InputError, ThicknessError
from ifs_cad.tolerance import Tolerance
from ifs_cad.types import FloatArray, IntArray
from ifs_cad.vectors import cross, dot, length, unit


@dataclass(frozen=True, eq=False)
class WireFrame:
    """Beams along the edges of a mesh.

    Parameters
    ----------
    mesh : Mesh
    width, height : float
        Of the beams' section, mm; the height stands on the surface.
    clearance : float
        How far each end is set back beyond what is needed, mm.
    material : Material

    Raises
    ------
    InputError
        A section that is not positive, a negative clearance.
    ThicknessError
        Edges too short for beams of this section; names them.
    """

    mesh: Mesh
    width: float
    height: float
    clearance: float = 0.0
    material: Material = SPRUCE
    addresses: tuple[str, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        for name in ("width", "height"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"The {name} of a beam must be positive, got {value} mm.")
        if not (math.isfinite(self.clearance) and self.clearance >= 0):
            raise InputError(f"Clearance must not be negative, got {self.clearance} mm.")
        digits = max(4, len(str(len(self.edges) - 1)))
        names = tuple(f"b{k:0{digits}}" for k in range(len(self.edges)))
        object.__setattr__(self, "addresses", names)
        short = self.lengths <= self.mesh.tol.coincident
        if short.any():
            found = [names[k] for k in np.flatnonzero(short)]
            raise ThicknessError(
                f"Edges too short for beams of {self.width:g} x {self.height:g} mm between their "
                f"nodes: {listed(found)}. Use slimmer beams or longer edges.",
                addresses=found,
            )

    def __len__(self) -> int:
        """Return the number of beams."""
        return len(self.edges)

    @cached_property
    def edges(self) -> IntArray:
        """(e,) int, one half-edge of the mesh for each beam."""
        twin = self.mesh.twin
        return np.flatnonzero((twin < 0) | (np.arange(len(twin)) < twin))

    @property
    def cut_from(self) -> Literal["boards"]:
        """Beams are cut from boards."""
        return "boards"

    @property
    def thickness(self) -> float:
        """Height of the section, mm."""
        return self.height

    @property
    def tol(self) -> Tolerance:
        """Tolerances of the design."""
        return self.mesh.tol

    @property
    def along(self) -> FloatArray:
        """(e, 3) float, the direction of the beams: text runs along it."""
        return self.directions

    @property
    def fibres(self) -> FloatArray:
        """(e, 3) float, unit vectors: the grain runs along the beams."""
        return self.directions

    @property
    def mate_addresses(self) -> tuple[str, ...]:
        """What the mates of the beams' faces are called: the beams."""
        return self.addresses

    @cached_property
    def directions(self) -> FloatArray:
        """(e, 3) float, unit vectors along the beams."""
        return self.mesh.directions[self.edges]

    @cached_property
    def normals(self) -> FloatArray:
        """(e, 3) float, unit vectors along the height, out of the surface."""
        twin = self.mesh.twin[self.edges]
        own = self.mesh.normals[self.mesh.face[self.edges]]
        other = self.mesh.normals[self.mesh.face[twin]]
        return unit(own + np.where(twin[:, None] < 0, own, other))

    @cached_property
    def across(self) -> FloatArray:
        """(e, 3) float, unit vectors along the width."""
        return cross(self.normals, self.directions)

    @cached_property
    def set_backs(self) -> FloatArray:
        """(2, e) float, how far the beams keep from the nodes at their start and end, mm.

        Two beams at a node are kept apart by the plane between their axes.
        """
        mesh, count = self.mesh, len(self.edges)
        beam = np.tile(np.arange(count), 2)
        node = np.concatenate([mesh.corners[self.edges], mesh.corners[mesh.next[self.edges]]])
        away = np.concatenate([self.directions, -self.directions])
        order = np.argsort(node, kind="stable")
        needed = np.zeros(2 * count)
        for lag in range(1, int(np.bincount(node).max())):
            together = np.flatnonzero(node[order[lag:]] == node[order[:-lag]])
            one, other = order[together], order[together + lag]
            apart = away[one] - away[other]
            sine = length(apart) / 2  # of half the angle between the axes
            plane = unit(apart)
            for end in (one, other):
                reach = (
                    np.abs(dot(plane, self.across[beam[end]])) * self.width
                    + np.abs(dot(plane, self.normals[beam[end]])) * self.height
                ) / 2
                np.maximum.at(needed, end, reach / sine)
        return needed.reshape(2, count) + self.clearance

    @cached_property
    def lengths(self) -> FloatArray:
        """(e,) float, of the beams, mm; square ends."""
        return np.asarray(self.mesh.edge_lengths[self.edges] - self.set_backs.sum(axis=0))

    @cached_property
    def solids(self) -> Polyhedra:
        """The beams' shapes."""
        start = self.mesh.positions[self.edges] + self.set_backs[0, :, None] * self.directions
        end = start + self.lengths[:, None] * self.directions
        side = self.width / 2 * self.across
        rise = self.height / 2 * self.normals
        ring = np.stack([end - side, end + side, start + side, start - side], axis=1)
        sides = np.stack([self.across, -self.directions, -self.across, self.directions], axis=1)
        count = len(self)
        return Prismatoids(
            lower=(ring - rise[:, None]).reshape(-1, 3),
            upper=(ring + rise[:, None]).reshape(-1, 3),
            side_normals=sides.reshape(-1, 3),
            kinds=np.full(4 * count, int(Kind.BORDER)),
            mates=np.full(4 * count, -1),
            solid_offsets=np.arange(0, 4 * count + 1, 4),
            normals=self.normals,
        ).polyhedra(self.mesh.tol)

    @cached_property
    def volumes(self) -> FloatArray:
        """(e,) float, mm3."""
        return self.solids.volumes

    @cached_property
    def masses(self) -> FloatArray:
        """(e,) float, kg."""
        return self.volumes * 1e-9 * self.material.density

    def part_data(self) -> list[dict[str, Any]]:
        """Return for each beam what an assembly says of its part: lengths in mm, mass in kg."""
        return [
            {
                "address": address,
                "thickness": self.height,
                "width": self.width,
                "length": size,
                "mass": mass,
            }
            for address, size, mass in zip(
                self.addresses, self.lengths.tolist(), self.masses.tolist(), strict=True
            )
        ]

    def report(self) -> str:
        """Return the numbers that a designer and a workshop look at first."""
        inner = self.bars_per_node[self.bars_per_node > 0]
        return "\n".join(
            f"{name:16}{value}"
            for name, value in (
                (
                    "beams",
                    f"{len(self)} of {self.width:g} x {self.height:g} mm {self.material.name}",
                ),
                ("lengths", f"{self.lengths.min():.1f} to {self.lengths.max():.1f} mm"),
                ("length in all", f"{self.lengths.sum() / 1000:.2f} m"),
                ("mass", f"{self.masses.sum():.1f} kg"),
                ("bars per node", f"{inner.min()} to {inner.max()}"),
            )
        )

    @cached_property
    def bars_per_node(self) -> IntArray:
        """(v,) int, how many beams meet at each vertex of the mesh."""
        mesh = self.mesh
        ends = np.concatenate([mesh.corners[self.edges], mesh.corners[mesh.next[self.edges]]])
        return np.bincount(ends, minlength=len(mesh.vertices))
