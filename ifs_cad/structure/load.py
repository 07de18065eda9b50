"""What a shell carries.

Loads are added by listing them and scaled by multiplying: `[1.35 * SelfWeight(), 1.5 * snow]`.
Forces act at the points of the finite element mesh, integrated with its shape functions, so their
sum is exactly the load.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Literal, Protocol, Self, get_args

import numpy as np

from ifs_cad.design.address import matching
from ifs_cad.errors import InputError
from ifs_cad.structure.grid import SHAPES, Grid
from ifs_cad.types import BoolArray, FloatArray, Plane, vector

GRAVITY = 9.81
"""m/s2."""
DOWN = (0.0, 0.0, -1.0)
Part = str | tuple[str, ...] | Plane | Callable[[FloatArray], BoolArray] | None
"""Addresses, a plane (the side of its normal) or a test of (..., 3) points; None for all."""
Per = Literal["plan", "surface"]


class Load(Protocol):
    """What all loads can do."""

    def forces(self, grid: Grid, weight: float) -> FloatArray:
        """Return the forces on the grid nodes.

        Parameters
        ----------
        grid : Grid
        weight : float, of the panels per surface area, N/mm2

        Returns
        -------
        (v, 3) float, N
        """


@dataclass(frozen=True)
class _Scaled:
    factor: float = 1.0

    def __post_init__(self) -> None:
        if not math.isfinite(self.factor):
            raise InputError(f"The factor of a load must be finite, got {self.factor}.")

    def __mul__(self, factor: float) -> Self:
        """Return the load times a factor."""
        return replace(self, factor=self.factor * factor)

    __rmul__ = __mul__


@dataclass(frozen=True)
class SelfWeight(_Scaled):
    """The weight of the panels themselves, along -z."""

    def forces(self, grid: Grid, weight: float) -> FloatArray:
        """Return the forces on the grid nodes, (v, 3) N."""
        return np.asarray(self.factor * weight * grid.node_areas[:, None] * np.array(DOWN))


@dataclass(frozen=True)
class AreaLoad(_Scaled):
    """A load spread over panels.

    Parameters
    ----------
    factor : float
    pressure : float, N/m2
    per : "plan" or "surface"
        Per area of the ground plan (snow) or of the panels (cladding, wind).
    direction : (3,) float, or "normal"
        Down by default; "normal" presses against the outer faces.
    on : addresses, Plane, test or None
        The loaded part: an address pattern or several, the side of a plane's normal, or what
        passes a test of points; all by default. A quad cut by a plane is loaded in part.
    """

    pressure: float = 0.0
    per: Per = "plan"
    direction: tuple[float, float, float] | Literal["normal"] = DOWN
    on: Part = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if not math.isfinite(self.pressure):
            raise InputError(f"The pressure must be finite, got {self.pressure} N/m2.")
        if self.per not in get_args(Per):
            raise InputError(f'A load is per "plan" or "surface", got {self.per!r}.')
        if self.direction != "normal":
            given = vector(self.direction, "The direction of a load")
            if not given.any():
                raise InputError("The direction of a load must not be the zero vector.")
            object.__setattr__(self, "direction", tuple((given / np.linalg.norm(given)).tolist()))

    def forces(self, grid: Grid, weight: float) -> FloatArray:
        """Return the forces on the grid nodes, (v, 3) N."""
        normals = grid.frames[:, 2]
        areas = np.where(_chosen(grid, self.on), grid.gauss_areas, 0.0)
        if self.per == "plan":
            areas = areas * np.abs(normals[:, 2:])
        size = self.factor * self.pressure * 1e-6 * (areas @ SHAPES)  # (e, 4)
        along = -normals if self.direction == "normal" else np.array(self.direction)[None]
        forces = size[:, :, None] * along[:, None, :]
        result = np.zeros((len(grid.nodes), 3))
        np.add.at(result, grid.quads.ravel(), forces.reshape(-1, 3))
        return result


@dataclass(frozen=True)
class PointLoad(_Scaled):
    """A force at the point of the finite element mesh nearest to a place.

    Parameters
    ----------
    factor : float
    force : (3,) float, N
    at : (3,) float, mm; or the address of a panel, for the point nearest to its middle
    """

    force: tuple[float, float, float] = (0.0, 0.0, 0.0)
    at: tuple[float, float, float] | str = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("force", "at"):
            value = getattr(self, name)
            if name == "at" and isinstance(value, str):
                continue
            value = vector(value, f"{name} of a point load")
            object.__setattr__(self, name, tuple(value.tolist()))

    def forces(self, grid: Grid, weight: float) -> FloatArray:
        """Return the forces on the grid nodes, (v, 3) N.

        Raises
        ------
        AddressError
            No panel has the address.
        """
        result = np.zeros((len(grid.nodes), 3))
        node = grid.middle(self.at) if isinstance(self.at, str) else grid.nearest(np.array(self.at))
        result[node] = self.factor * np.array(self.force)
        return result


def _chosen(grid: Grid, part: Part) -> BoolArray:
    """Return which Gauss points are loaded, (e, 4)."""
    if part is None:
        return np.ones(grid.quads.shape, dtype=bool)
    if isinstance(part, Plane):
        return np.asarray(part.height(grid.gauss_points) > 0)
    if callable(part):
        chosen = np.asarray(part(grid.gauss_points), dtype=bool)
        if chosen.shape != grid.quads.shape:
            raise InputError(
                f"The test of a load must return one answer for each of {grid.quads.shape} "
                f"points, got shape {chosen.shape}."
            )
        return chosen
    faces = matching(grid.mesh.addresses, part)
    return np.broadcast_to(faces[grid.face_of_quad][:, None], grid.quads.shape)


Loads = Load | Iterable[Load]


def total_forces(loads: Loads, grid: Grid, weight: float) -> FloatArray:
    """Return the sum of some loads, (v, 3) N; see `Load.forces`.

    Raises
    ------
    InputError
        Nothing is loaded.
    """
    several = list(loads) if isinstance(loads, Iterable) else [loads]
    forces = np.zeros((len(grid.nodes), 3))
    for load in several:
        forces += load.forces(grid, weight)
    if not forces.any():
        raise InputError("Nothing is loaded. Give loads=[SelfWeight()] or an AreaLoad.")
    return forces
