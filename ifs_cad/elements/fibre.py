"""Fibre direction: how the grain of the outer plies runs in each panel, as the designer wants it.

A rule gives one direction for every panel, in its plane. The panel carries it to the workshop,
which lays the panel on its sheet so that the grain of the sheet follows it.

Terms
-----
fibre direction : a unit vector in the plane of a panel, along the grain of its outer plies.
tolerance : how far the workshop may turn a panel off its fibre direction to save wood.
half turn : whether a panel may lie the other way round; grain runs both ways, a picture does not.

Source: section 4.3 (each element oriented to the fibre direction of the raw material).
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.design.mesh import Mesh
from ifs_cad.errors import InputError
from ifs_cad.types import FloatArray, IntArray, number, vector
from ifs_cad.vectors import dot, length, unit

SumCurve = Literal["long", "a", "b"]

QUARTER_TURN = 90.0
"""Off by more than this, degrees, a direction is nearer to its own reverse."""


@dataclass(frozen=True)
class Fibre(ABC):
    """A rule for the fibre direction of panels.

    Parameters
    ----------
    tolerance : float, degrees
        How far the workshop may turn a panel off the rule.
    half_turn : bool
        Whether it may lay a panel the other way round.

    Raises
    ------
    InputError
        A tolerance below 0 or above 90 degrees.
    """

    tolerance: float = field(default=0.0, kw_only=True)
    half_turn: bool = field(default=True, kw_only=True)

    def __post_init__(self) -> None:
        tolerance = number(self.tolerance, "The tolerance of a fibre direction")
        if not (math.isfinite(tolerance) and 0.0 <= tolerance <= QUARTER_TURN):
            raise InputError(
                f"The tolerance of a fibre direction must lie between 0 and {QUARTER_TURN:g} "
                f"degrees, got {tolerance:g}."
            )

    @abstractmethod
    def directions(self, mesh: Mesh, faces: IntArray) -> FloatArray:
        """Return (n, 3) unit vectors in the planes of some faces.

        Raises
        ------
        InputError
            The rule says nothing about one of them.
        """


@dataclass(frozen=True)
class FibreAlongCurve(Fibre):
    """Along one of the two curves of a vector sum.

    In each panel, halfway between its two design edges that belong to the curve.

    Parameters
    ----------
    curve : "long", "a" or "b"
        The first or the second curve of the sum, or the longer one.
    """

    curve: SumCurve = "long"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.curve not in get_args(SumCurve):
            raise InputError(f'Fibre runs along the curve "long", "a" or "b", got {self.curve!r}.')

    def directions(self, mesh: Mesh, faces: IntArray) -> FloatArray:
        """Return (n, 3) unit vectors in the planes of some faces.

        A mesh with faces left out follows the curves of the whole.

        Raises
        ------
        InputError
            The mesh is no vector sum.
        """
        whole, vertices = (mesh, None) if mesh.origin is None else mesh.origin
        if whole.lattice is None:
            raise InputError(
                "This mesh is no sum of two curves that its fibre could run along. Let the fibre "
                "run along an edge of each panel or towards a direction instead."
            )
        strands = _strands(whole, whole.lattice, self.curve)
        corners = mesh.corners if vertices is None else vertices[mesh.corners]
        heads, count = corners[mesh.next], len(whole.vertices)
        along_curve = strands[:-1].ravel() * count + strands[1:].ravel()
        sense = np.isin(corners * count + heads, along_curve).astype(float)
        sense -= np.isin(heads * count + corners, along_curve)
        total = np.add.reduceat(sense[:, None] * mesh.directions, mesh.offsets[:-1])
        return unit(total[faces])


@dataclass(frozen=True)
class FibreAlongEdge(Fibre):
    """Along one design edge of each panel.

    Parameters
    ----------
    edge : int or "longest"
        The number of the edge in its face, from 0; or the longest edge of each, the first of
        several.
    """

    edge: int | Literal["longest"] = "longest"

    def __post_init__(self) -> None:
        super().__post_init__()
        is_number = isinstance(self.edge, int) and not isinstance(self.edge, bool)
        if self.edge != "longest" and not (is_number and int(self.edge) >= 0):
            raise InputError(
                'Fibre runs along the "longest" edge or along the edge of a number from 0, got '
                f"{self.edge!r}."
            )

    def directions(self, mesh: Mesh, faces: IntArray) -> FloatArray:
        """Return (n, 3) unit vectors in the planes of some faces.

        Raises
        ------
        InputError
            Faces without an edge of this number; names them.
        """
        starts = mesh.offsets[:-1]
        if self.edge == "longest":
            longest = np.maximum.reduceat(mesh.edge_lengths, starts)[mesh.face]
            is_longest = mesh.edge_lengths >= longest - mesh.tol.coincident
            candidates = np.flatnonzero(is_longest)
            chosen = candidates[np.searchsorted(candidates, starts[faces])]
        else:
            lacking = mesh.sizes[faces] <= self.edge
            if lacking.any():
                names = mesh.names(faces[lacking])
                raise InputError(
                    f"Edges count from 0, and fewer than {self.edge + 1} are in {listed(names)}. "
                    'Take a lower number, or "longest".',
                    addresses=names,
                )
            chosen = starts[faces] + self.edge
        return mesh.directions[chosen]


@dataclass(frozen=True)
class FibreTowards(Fibre):
    """Towards a direction in space, as far as the plane of each panel allows.

    Parameters
    ----------
    direction : (3,) floats, of any length but zero
    """

    direction: tuple[float, float, float]

    def __post_init__(self) -> None:
        super().__post_init__()
        direction = vector(self.direction, "Fibre direction")
        if not direction.any():
            raise InputError("The fibre direction must not be the zero vector.")
        object.__setattr__(self, "direction", tuple(direction.tolist()))

    def directions(self, mesh: Mesh, faces: IntArray) -> FloatArray:
        """Return (n, 3) unit vectors in the planes of some faces.

        Raises
        ------
        InputError
            Panels square to the direction; names them.
        """
        towards = unit(np.array(self.direction))
        normals = mesh.normals[faces]
        projected = towards - dot(normals, towards)[:, None] * normals
        square = length(projected) <= mesh.tol.parallel
        if square.any():
            names = mesh.names(faces[square])
            raise InputError(
                f"The fibre direction {self.direction} is square to {listed(names)} and gives "
                "their fibre no direction. Tilt it, or let the fibre run along a curve or an edge.",
                addresses=names,
            )
        return unit(projected)


def fibre_data(fibres: FloatArray | None, count: int) -> list[dict[str, Any]]:
    """Return what the data of each of `count` parts says of its fibre direction; {} without one."""
    return [{}] * count if fibres is None else [{"fibre": fibre} for fibre in fibres.tolist()]


def _strands(mesh: Mesh, lattice: IntArray, curve: SumCurve) -> IntArray:
    """Return the lattice with the edges of a curve between its rows."""
    if curve == "long":
        curve_a, curve_b = (mesh.vertices[line] for line in (lattice[:, 0], lattice[0]))
        length_a, length_b = (length(np.diff(line, axis=0)).sum() for line in (curve_a, curve_b))
        curve = "a" if length_a >= length_b else "b"
    return lattice if curve == "a" else lattice.T
