"""Vaults of planks: each segment of a layer's curve becomes a plank.

A plank has its width in the plane of its layer, its thickness across. Its ends are cut on the
planes that bisect the angles of adjacent segments, so the planks of one layer meet on their
joints without gap, and the layers touch face to face. The first and the last plank of a layer end
square, or stand on a springing plane: there they are lengthened or trimmed until the cut lies on
it.

Terms
-----
outside : the side away from the chord of the curve, see `Layers.outside`.
side : where the planks lie, seen from the curve: outside, inside or centred on it.
springing plane : what the ends of a vault stand on; the floor, or the top of a wall. The vault
    lies on the side of its normal.
end angle : of an end cut, from square, degrees; positive when the plank is longer on the outside.

Source: section 4.1, figures 14 to 16.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from ifs_cad.design.address import matching
from ifs_cad.design.curve import Curve
from ifs_cad.elements.layer import NEVER, Layers, read_layers
from ifs_cad.elements.material import SPRUCE, Material
from ifs_cad.elements.plank import Planking, Side
from ifs_cad.elements.polyhedron import Kind, Polyhedra
from ifs_cad.elements.vault_report import VaultReport
from ifs_cad.errors import InputError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import ArrayLike, FloatArray, IntArray, Plane, number
from ifs_cad.vectors import dot


def vault(
    curves: Curve | Sequence[Any],
    width: float,
    thickness: float,
    *,
    layers: int | None = None,
    side: Side = "centre",
    stagger: bool = False,
    springing: Plane | tuple[Plane | None, Plane | None] | None = None,
    clearance: float = 0.0,
    across: ArrayLike | None = None,
    material: Material = SPRUCE,
    tol: Tolerance = DEFAULT,
) -> Vault:
    """Make a vault of planks from planar curves.

    Parameters
    ----------
    curves : Curve, or a sequence with a curve or (n, 3) array of points for each layer
        Fewer curves than layers are gone through again and again.
    width : float
        Of the planks, in the plane of the curve, mm.
    thickness : float
        Of the planks, across, mm.
    layers : int, optional
        By default as many as there are curves.
    side : "outside", "inside" or "centre"
    stagger : bool
        Split the end segments of every second layer, so that no joint lies on its neighbour's.
    springing : Plane, or a pair for the start and the end of the curves, optional
        One plane is the floor of all planks; of a pair, each trims only the planks at its end.
        None in a pair lets that end be square.
    clearance : float
        How far each end cut is set back, mm.
    across : (3,) floats, optional
        The direction in which the layers follow each other; by default the normal of the curves'
        plane, its largest coordinate positive.
    material : Material
    tol : Tolerance

    Raises
    ------
    InputError
        A width or thickness that is not positive, a negative clearance, no layer.
    PlanarityError
        A curve that is not planar, or planes that are not parallel.
    ThicknessError
        A curve too tight for the width; names the planks, and the radius and width that fit.
    FloorError
        The curves end above their springing plane, or dip below it midway.

    References
    ----------
    The paper, section 4.1, figures 14 to 16.
    """
    planes = springing if isinstance(springing, tuple) else (springing, springing)
    planking = Planking(width, thickness, side, planes, clearance, material, tol)
    segments = read_layers(curves, layers, stagger, across, tol)
    return _planked(segments, planking)


def _planked(segments: Layers, planking: Planking) -> Vault:
    solids, numbers = planking(segments)
    gone = np.setdiff1d(np.arange(len(segments.layer)), numbers)
    return Vault(segments, planking, numbers, solids, tuple(segments.names(gone)))


@dataclass(frozen=True, eq=False)
class Vault:
    """Planks along the segments of layers. Made by `vault`.

    Attributes
    ----------
    segments : Layers
        The segments of all layers.
    planking : Planking
        What made it: width, thickness, side, springing, clearance, material, tolerance.
    numbers : (p,) int, the segment of each plank; a springing plane may have taken some
    solids : Polyhedra
        The planks' exact shapes; mates are segments.
    lost : addresses of the planks that lie below their springing and are not made
    """

    segments: Layers = field(repr=False)
    planking: Planking
    numbers: IntArray = field(repr=False)
    solids: Polyhedra = field(repr=False)
    lost: tuple[str, ...] = ()

    def __len__(self) -> int:
        """Return the number of planks."""
        return len(self.numbers)

    @cached_property
    def addresses(self) -> tuple[str, ...]:
        """Layer and word of each plank, as L07-0110; the word is that of its first segment."""
        return tuple(self.segments.names(self.numbers))

    @property
    def cut_from(self) -> Literal["boards"]:
        """Planks are cut from boards."""
        return "boards"

    @property
    def width(self) -> float:
        """Width of every plank in the plane of its layer, mm."""
        return self.planking.width

    @property
    def thickness(self) -> float:
        """Thickness of every plank across, mm."""
        return self.planking.thickness

    @property
    def material(self) -> Material:
        """What the planks are made of."""
        return self.planking.material

    @property
    def tol(self) -> Tolerance:
        """Tolerances of the design."""
        return self.planking.tol

    @property
    def layer(self) -> IntArray:
        """(p,) int, the layer of each plank, from 0."""
        return self.segments.layer[self.numbers]

    @property
    def normals(self) -> FloatArray:
        """(p, 3) float, unit vectors across, from layer to layer."""
        return np.tile(self.segments.across, (len(self), 1))

    @cached_property
    def directions(self) -> FloatArray:
        """(p, 3) float, unit vectors along the planks."""
        return np.asarray(self.segments.directions[self.numbers] @ self.segments.axes[:2])

    @property
    def along(self) -> FloatArray:
        """(p, 3) float, the direction of the planks: text runs along it."""
        return self.directions

    @property
    def fibres(self) -> FloatArray:
        """(p, 3) float, the grain runs along the planks."""
        return self.directions

    @cached_property
    def segment_lengths(self) -> FloatArray:
        """(p,) float, of the curve's segments that the planks stand for, mm."""
        return self.segments.lengths[self.numbers]

    @cached_property
    def end_angles(self) -> FloatArray:
        """(p, 2) float, degrees, of the cuts at the start and the end of each plank.

        Half the turning angle at a joint; at a springing plane the angle between it and the
        square cut.
        """
        half = np.degrees(self.segments.turns[self.numbers]) / 2
        floor = np.flatnonzero(self.solids.kinds == Kind.FLOOR)
        owner = self.solids.solid_of_face[floor]
        outward = self.solids.normals[floor]
        forward = dot(outward, self.directions[owner])
        outside = dot(outward, self._outside[owner])
        at_end = (forward > 0).astype(np.int64)
        half[owner, at_end] = np.degrees(np.arctan2(-outside, np.abs(forward)))
        return half

    @cached_property
    def side_lengths(self) -> FloatArray:
        """(p, 2) float, of the planks on the inside and on the outside, as cut, mm."""
        solids = self.solids
        owner = solids.solid_of_vertex
        start = self.segments.points[self.segments.starts[self.numbers]]
        arms = solids.vertices - self.segments.spatial(start)[owner]
        height = dot(arms, self._outside[owner])
        along = dot(arms, self.directions[owner])
        both = []
        for level in self.planking.reach:
            there = np.abs(height - level) <= self.tol.planar
            first, last = np.full(len(self), np.inf), np.full(len(self), -np.inf)
            np.minimum.at(first, owner[there], along[there])
            np.maximum.at(last, owner[there], along[there])
            both.append(np.maximum(last - first, 0.0))
        return np.stack(both, axis=1)

    @cached_property
    def lengths(self) -> FloatArray:
        """(p,) float, of the boards that the planks are cut from: all they reach along, mm."""
        owner = self.solids.solid_of_vertex
        along = dot(self.solids.vertices, self.directions[owner])
        first, last = np.full(len(self), np.inf), np.full(len(self), -np.inf)
        np.minimum.at(first, owner, along)
        np.maximum.at(last, owner, along)
        return np.asarray(last - first)

    @cached_property
    def radii(self) -> FloatArray:
        """(p,) float, mm, how tightly the curve turns along each plank; infinite when straight.

        At this distance from the curve, on the inner side of the turn, nothing would be left of
        the plank.
        """
        bend = np.abs(np.tan(self.segments.turns[self.numbers] / 2).sum(axis=1))
        with np.errstate(divide="ignore"):
            return np.asarray(self.segment_lengths / bend)

    @cached_property
    def volumes(self) -> FloatArray:
        """(p,) float, mm3."""
        return self.solids.volumes

    @cached_property
    def masses(self) -> FloatArray:
        """(p,) float, kg."""
        return self.volumes * 1e-9 * self.material.density

    @cached_property
    def joint_distances(self) -> FloatArray:
        """(layers - 1,) float, least distance of a joint from one in the next layer, mm.

        Infinite where one of the two has no joint.
        """
        segments = self.segments
        joined = segments.before != NEVER
        places = segments.points[segments.starts[joined]]
        layer = segments.layer[joined]
        found = np.full(segments.count - 1, np.inf)
        for lower in range(segments.count - 1):
            one, other = places[layer == lower], places[layer == lower + 1]
            if len(one) and len(other):
                apart = one[:, None] - other[None]
                found[lower] = np.hypot(apart[..., 0], apart[..., 1]).min()
        return found

    @cached_property
    def stubs(self) -> tuple[str, ...]:
        """Addresses of the planks of which a springing plane leaves no full width."""
        trimmed = np.zeros(len(self), dtype=bool)
        trimmed[self.solids.solid_of_face[self.solids.kinds == Kind.FLOOR]] = True
        short = self.side_lengths.min(axis=1) <= self.tol.planar
        return tuple(self.addresses[k] for k in np.flatnonzero(trimmed & short))

    @cached_property
    def mate_addresses(self) -> tuple[str, ...]:
        """What the mates of the planks' faces are called: the segments."""
        return tuple(self.segments.names(np.arange(len(self.segments.layer))))

    def part_data(self) -> list[dict[str, Any]]:
        """Return for each plank what an assembly says of its part.

        address, layer, thickness and width (mm), mass (kg), lengths inside and outside (mm), and
        end_angles (degrees).
        """
        return [
            {
                "address": address,
                "layer": layer,
                "thickness": self.thickness,
                "width": self.width,
                "mass": mass,
                "length_inside": inside,
                "length_outside": outside,
                "end_angles": angles,
            }
            for address, layer, mass, (inside, outside), angles in zip(
                self.addresses,
                self.layer.tolist(),
                self.masses.tolist(),
                self.side_lengths.tolist(),
                self.end_angles.tolist(),
                strict=True,
            )
        ]

    def report(self) -> VaultReport:
        """Return the numbers that a designer and a workshop look at first."""
        inner = np.flatnonzero(self.segments.before[self.numbers] != NEVER)
        heaviest = int(self.masses.argmax())
        tightest = int(self.radii.argmin())
        return VaultReport(
            planks=len(self),
            layers=self.segments.count,
            width=self.width,
            thickness=self.thickness,
            material=self.material.name,
            depth=self.segments.count * self.thickness,
            volume=float(self.volumes.sum()) * 1e-9,
            running=float(self.lengths.sum()) / 1000,
            mass=float(self.masses.sum()),
            heaviest=(self.addresses[heaviest], float(self.masses[heaviest])),
            lengths=(float(self.lengths.min()), float(self.lengths.max())),
            end_angles=(
                float(np.abs(self.end_angles).min()),
                float(np.abs(self.end_angles).max()),
            ),
            joint_gap=2 * self.planking.clearance if len(inner) else 0.0,
            tightest=(self.addresses[tightest], float(self.radii[tightest])),
            joint_distance=float(self.joint_distances.min(initial=np.inf)),
            lost=self.lost,
            stubs=self.stubs,
        )

    def part(self, patterns: str | Iterable[str]) -> Vault:
        """Take some planks out as they are, with the ends they have in the whole.

        Raises
        ------
        AddressError
            No address matches.
        """
        return self.take(np.flatnonzero(matching(self.addresses, patterns)))

    def take(self, numbers: ArrayLike) -> Vault:
        """Return the planks of these numbers as they are."""
        chosen = np.asarray(numbers, dtype=np.int64)
        return replace(self, numbers=self.numbers[chosen], solids=self.solids.take(chosen))

    @property
    def whole(self) -> Vault:
        """The vault with all its planks, of which this may be a part."""
        return _planked(self.segments, self.planking)

    def scale(self, factor: float, thickness: float, material: Material | None = None) -> Vault:
        """Return a reduced model of these planks, made of a material with a thickness of its own.

        Curves, width, clearance and springing planes are scaled, the number of layers stays.

        Parameters
        ----------
        factor : float
            0.1 for a model 1:10.
        thickness : float
            Of the model's planks, mm.
        material : Material, optional

        Raises
        ------
        InputError
            A factor or thickness that is not positive.

        References
        ----------
        The paper, section 4.1, figure 16.
        """
        factor = number(factor, "The scale of a model")
        if not (math.isfinite(factor) and factor > 0):
            raise InputError(f"The scale of a model must be positive, got {factor}.")
        recipe = self.planking
        start, end = (plane and plane.scaled(factor) for plane in recipe.springing)
        planking = replace(
            recipe,
            width=recipe.width * factor,
            thickness=thickness,
            springing=(start, end),
            clearance=recipe.clearance * factor,
            material=material or recipe.material,
        )
        model = _planked(self.segments.scaled(factor), planking)
        return model.take(np.flatnonzero(np.isin(model.numbers, self.numbers)))

    @cached_property
    def _outside(self) -> FloatArray:
        """(p, 3) float, unit vectors in the plane, square to the planks, to the outside."""
        return np.cross(self.directions, self.segments.across) * self.segments.outside
