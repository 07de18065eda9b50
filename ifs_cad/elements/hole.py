"""Fixation holes: through-holes by which each panel is screwed to the machine's table.

Source: section 4.3, figure 19 (piercing of the fixation holes).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.elements.cutting import CuttingFrames, work_faces
from ifs_cad.elements.element import Elements
from ifs_cad.elements.polyhedron import Kind
from ifs_cad.errors import HoleError, InputError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import BoolArray, FloatArray, IntArray


class HolePattern(Protocol):
    """A rule that says where the through-holes of elements go."""

    def place(self, elements: Elements, frames: CuttingFrames) -> HolePlaces:
        """Place the holes of every element in its cutting frame; HoleError where they cannot."""


@dataclass(frozen=True)
class Holes:
    """A through-hole in each corner of a panel, square to it.

    Parameters
    ----------
    diameter : float, mm
    inset : float, mm
        Distance of the hole's axis from the two sides of its corner, on the face where the panel
        is smaller.
    fewest : int
        Panels with fewer corners that can take a hole are an error.
    """

    diameter: float = 5.0
    inset: float = 25.0
    fewest: int = 2

    def __post_init__(self) -> None:
        if not (math.isfinite(self.diameter) and self.diameter > 0):
            raise InputError(f"Hole diameter must be positive, got {self.diameter} mm.")
        if not (math.isfinite(self.inset) and self.inset > self.diameter / 2):
            raise InputError(
                f"Hole inset must exceed the radius {self.diameter / 2:g} mm, got {self.inset} mm."
            )
        if self.fewest < 0:
            raise InputError(f"The fewest holes must not be negative, got {self.fewest}.")

    def place(self, elements: Elements, frames: CuttingFrames) -> HolePlaces:
        """Place the holes of every element, see `place_holes`."""
        return place_holes(elements.addresses, frames, self, elements.tol)


@dataclass(frozen=True, eq=False)
class HolePlaces:
    """Where the holes pierce each panel, in its cutting frame.

    Attributes
    ----------
    points : (p, k, 2) float, mm
    present : (p, k) bool
    diameter : float, mm
    """

    points: FloatArray
    present: BoolArray
    diameter: float

    def take(self, panels: IntArray) -> HolePlaces:
        """Return the holes of some panels."""
        return HolePlaces(self.points[panels], self.present[panels], self.diameter)


def place_holes(
    addresses: Sequence[str], frames: CuttingFrames, holes: Holes, tol: Tolerance = DEFAULT
) -> HolePlaces:
    """Place the holes of every panel.

    A corner takes a hole when the hole keeps `inset` from every side; corners cut off by the floor
    or too sharp take none.

    Raises
    ------
    HoleError
        Panels with room for fewer than `holes.fewest`; names them.
    """
    region = work_faces(frames, frames.thickness)
    # a relief cut is no side of its own: the corner it belongs to counts as whole
    sides = region.is_side & (region.kinds != Kind.RELIEF)
    limits = region.limits + np.where(region.kinds == Kind.RELIEF, 0.0, holes.inset)
    following = _next_true(sides)
    rows = np.arange(len(addresses))[:, None]
    a, b = region.inward, region.inward[rows, following]
    turn = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    meets = sides & (turn > tol.parallel)
    safe = np.where(meets, turn, 1.0)
    at_a, at_b = limits, limits[rows, following]
    points = np.stack(
        [
            (at_a * b[..., 1] - at_b * a[..., 1]) / safe,
            (at_b * a[..., 0] - at_a * b[..., 0]) / safe,
        ],
        axis=-1,
    )
    slack = np.einsum("pki,pji->pjk", region.inward, points) - limits[:, None, :]
    slack -= np.where(region.kinds == Kind.RELIEF, holes.diameter / 2, 0.0)[:, None, :]
    present = meets & (slack >= -tol.planar).all(axis=2)
    few = present.sum(axis=1) < holes.fewest
    if few.any():
        names = [addresses[i] for i in np.flatnonzero(few).tolist()]
        raise HoleError(
            f"Panels with room for fewer than {holes.fewest} holes {holes.inset:g} mm from their "
            f"sides: {listed(names)}. Use a smaller inset.",
            addresses=names,
        )
    return HolePlaces(points, present, holes.diameter)


def _next_true(chosen: BoolArray) -> IntArray:
    """Return, for each entry of (p, k) bools, the place of the next True after it, in a cycle."""
    count = chosen.shape[1]
    place = np.where(chosen, np.arange(count), 2 * count)
    doubled = np.concatenate([place, place + count], axis=1)
    after = np.minimum.accumulate(doubled[:, ::-1], axis=1)[:, ::-1]
    return np.asarray(after[:, 1 : count + 1] % count)
