"""Screws that join the layers of a vault: where their pilot holes go.

Each screw runs square through a plank into one of the next layer, and both get a pilot hole right
through. A screw keeps its distance from the ends and the edges of both planks, so it never meets a
joint, and from every other screw in either of them. Where there is room, the screws of one pair of
layers stand in one half of the planks' width, those of the next pair in the other.

Source: section 4.1 (the planks are then screwed together). Least distances of screws in predrilled
timber are those of EN 1995-1-1, table 8.2: along the grain 5 d between screws, 7 d from an end
that carries no load, across it 3 d from an edge.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.elements.cutting import CuttingFrames
from ifs_cad.elements.element import Elements
from ifs_cad.elements.hole import HolePlaces
from ifs_cad.elements.polyhedron import Kind, offsets
from ifs_cad.elements.vault import Vault
from ifs_cad.errors import HoleError, InputError
from ifs_cad.tolerance import Tolerance
from ifs_cad.types import BoolArray, FloatArray, IntArray

ASIDE = np.linspace(-1.0, 1.0, 129)  # how far a screw may move, as a share of the overlap
LANES = 9  # lines along a plank on which its screws may stand
END, EDGE, BETWEEN = 7.0, 3.0, 5.0  # least distances, times the diameter of the screw


@dataclass(frozen=True)
class Screws:
    """Pilot holes for the screws that join each layer of a vault to the next.

    Parameters
    ----------
    diameter : float
        Of the screw, mm; it sets the least distances by default.
    pilot : float, optional
        Diameter of the hole, mm; 0.7 times that of the screw by default.
    spacing : float
        Largest distance of two screws along the overlap of two planks, unless another screw is in
        the way, mm.
    end, edge, between : float, optional
        Least distances from the end of a plank, from its edge, and from another screw, mm.
    fewest : int
        Planks with fewer screws to a neighbouring layer are an error.

    Raises
    ------
    InputError
    """

    diameter: float = 6.0
    pilot: float | None = None
    spacing: float = 250.0
    end: float | None = None
    edge: float | None = None
    between: float | None = None
    fewest: int = 2

    def __post_init__(self) -> None:
        defaults = {
            "pilot": 0.7 * self.diameter,
            "end": END * self.diameter,
            "edge": EDGE * self.diameter,
            "between": BETWEEN * self.diameter,
        }
        for name, default in defaults.items():
            if getattr(self, name) is None:
                object.__setattr__(self, name, default)
        for name in ("diameter", "spacing", *defaults):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"{name} of screws must be positive, got {value} mm.")
        for name in ("end", "edge", "between"):
            if getattr(self, name) <= self.hole:
                raise InputError(
                    f"{name} of screws must exceed the diameter of their holes, {self.hole:g} mm, "
                    f"got {getattr(self, name):g} mm."
                )
        if self.fewest < 1:
            raise InputError(f"The fewest screws of a plank must be at least 1, got {self.fewest}.")

    @property
    def hole(self) -> float:
        """Diameter of the pilot holes, mm."""
        assert self.pilot is not None
        return self.pilot

    def place(self, elements: Elements, frames: CuttingFrames) -> HolePlaces:
        """Place the pilot holes of every plank, in its cutting frame.

        Raises
        ------
        InputError
            The elements are not the planks of a vault.
        HoleError
            Planks with room for fewer screws than `fewest`; names them.
        """
        if not isinstance(elements, Vault):
            raise InputError("Only the planks of a vault are joined by screws; use Holes.")
        whole = elements.whole  # a part has the holes that it has in the whole
        number = np.full(len(elements.segments.layer), -1)
        number[elements.numbers] = np.arange(len(elements))
        owner, points = self._pattern(whole)
        owner = number[whole.numbers][owner]
        owner, points = owner[owner >= 0], points[owner >= 0]
        flat = elements.segments.spatial(points)
        frame = np.einsum("kij,kj->ki", frames.axes[owner], flat) + frames.offsets[owner]
        counts = np.bincount(owner, minlength=len(elements))
        present = np.arange(max(int(counts.max(initial=0)), 1)) < counts[:, None]
        placed = np.zeros((*present.shape, 2))
        order = np.argsort(owner, kind="stable")
        placed[present] = frame[order, :2]
        return HolePlaces(placed, present, self.hole)

    def _pattern(self, planks: Vault) -> tuple[IntArray, FloatArray]:
        """Return the plank and the (k, 2) place in the plane of every hole, mm."""
        outlines = _Outlines.of(planks, self)
        owners, points = [], []
        before = np.empty((0, 2))  # the screws that come up from the layer below
        layer = planks.layer
        for lower in range(planks.segments.count - 1):
            one, other = np.flatnonzero(layer == lower), np.flatnonzero(layer == lower + 1)
            pairs = np.stack(np.meshgrid(one, other, indexing="ij"), axis=-1).reshape(-1, 2)
            pair, places = self._between(planks, outlines, pairs, before, lower % 2)
            for side in (0, 1):
                owners.append(pair[:, side])
                points.append(places)
                got = np.bincount(pair[:, side], minlength=len(planks))
                self._require_enough(planks, (one, other)[side], got)
            before = places
        if not owners:
            raise InputError("A vault of one layer has no other to be screwed to.")
        return np.concatenate(owners), np.concatenate(points)

    def _between(
        self,
        planks: Vault,
        outlines: _Outlines,
        pairs: IntArray,
        before: FloatArray,
        lane: int,
    ) -> tuple[IntArray, FloatArray]:
        """Return the pairs of planks and the places of the screws that join two layers."""
        segments, numbers = planks.segments, planks.numbers
        assert self.edge is not None
        assert self.between is not None
        room = planks.width / 2 - self.edge
        if room < 0:
            raise HoleError(
                f"Planks {planks.width:g} mm wide have no room for screws {self.edge:g} mm from "
                "both edges. Use thinner screws or wider planks."
            )
        ahead = segments.directions[numbers][pairs[:, 0]]
        start = segments.points[segments.starts[numbers]][pairs[:, 0]]
        outside = segments.outside * np.stack([ahead[:, 1], -ahead[:, 0]], axis=1)
        middle = sum(planks.planking.reach) / 2
        # the lane that keeps most clear of the screws below, unless the planks overlap elsewhere
        wanted = min(max(self.between, room) / 2, room) * (1 if lane else -1)
        best, low, high = np.full(len(pairs), -np.inf), np.zeros(len(pairs)), np.zeros(len(pairs))
        base = start.copy()
        for lateral in np.linspace(-room, room, LANES):
            line = start + (middle + lateral) * outside
            first, last = outlines.stretch(line, ahead, pairs, planks.tol)
            score = np.where(last >= first, last - first, -np.inf) - abs(lateral - wanted)
            score -= self.spacing if lateral * wanted < 0 else 0.0
            better = score > best
            best[better], low[better], high[better] = score[better], first[better], last[better]
            base[better] = line[better]
        meets = np.flatnonzero(np.isfinite(best))
        pairs, low, high = pairs[meets], low[meets], high[meets]
        base, ahead = base[meets], ahead[meets]

        # evenly along each overlap, or as near to that as no other screw is too near
        wanted_steps = np.maximum(np.ceil((high - low) / self.spacing), 1)
        steps = np.minimum(wanted_steps, (high - low) // self.between).astype(np.int64)
        chosen_pairs, chosen = [], []
        last = np.full(len(pairs), -np.inf)
        for step in range(int(steps.max(initial=0)) + 1):
            even = np.where(steps > 0, step / np.maximum(steps, 1), 0.5)[:, None]
            share = np.clip(even + ASIDE, 0.0, 1.0)
            along = low[:, None] + (high - low)[:, None] * share
            places = base[:, None] + along[..., None] * ahead[:, None]
            open_ = _apart(places, before, self.between)
            open_ &= along >= (last + self.between)[:, None]
            off = np.where(open_, np.abs(share - even), np.inf)
            best = off.argmin(axis=1)
            row = np.arange(len(pairs))
            good = np.flatnonzero((step <= steps) & np.isfinite(off[row, best]))
            last[good] = along[good, best[good]]
            chosen_pairs.append(pairs[good])
            chosen.append(base[good] + last[good, None] * ahead[good])
        places, pairs = np.concatenate(chosen), np.concatenate(chosen_pairs)
        kept = _first_apart(places, self.between)
        return pairs[kept], places[kept]

    def _require_enough(self, planks: Vault, layer: IntArray, got: IntArray) -> None:
        few = layer[got[layer] < self.fewest]
        if len(few):
            names = [planks.addresses[k] for k in few]
            raise HoleError(
                f"Planks with room for fewer than {self.fewest} screws to a neighbouring layer: "
                f"{listed(names)}. Use thinner screws, smaller distances, or layers that overlap "
                "more.",
                addresses=names,
            )


@dataclass(frozen=True, eq=False)
class _Outlines:
    """Where screws may stand in each plank: inward . (x, y) >= limits for each of its sides.

    Attributes
    ----------
    inward : (p, k, 2) float, unit normals in the plane; filled up with zeros
    limits : (p, k) float, mm; filled up with -inf
    """

    inward: FloatArray
    limits: FloatArray

    @classmethod
    def of(cls, planks: Vault, screws: Screws) -> _Outlines:
        assert screws.end is not None
        assert screws.edge is not None
        solids = planks.solids
        side = np.flatnonzero(solids.kinds > Kind.UPPER)
        owner = solids.solid_of_face[side]
        inward = -solids.normals[side] @ planks.segments.axes[:2].T
        levels = -solids.levels[side] + solids.normals[side] @ planks.segments.origin
        ahead = planks.segments.directions[planks.numbers][owner]
        # a long side is parallel to its plank, an end is not
        is_end = np.abs(np.einsum("ki,ki->k", inward, ahead)) > planks.tol.parallel
        levels = levels + np.where(is_end, screws.end, screws.edge)
        counts = np.bincount(owner, minlength=len(planks))
        slot = np.arange(len(side)) - offsets(counts)[owner]
        shape = (len(planks), int(counts.max()))
        filled = np.zeros((*shape, 2)), np.full(shape, -np.inf)
        filled[0][owner, slot] = inward
        filled[1][owner, slot] = levels
        return cls(*filled)

    def stretch(
        self, base: FloatArray, ahead: FloatArray, pairs: IntArray, tol: Tolerance
    ) -> tuple[FloatArray, FloatArray]:
        """Return from where to where lines run inside both planks of each pair, mm."""
        low, high = np.full(len(pairs), -np.inf), np.full(len(pairs), np.inf)
        for plank in pairs.T:
            slope = np.einsum("pki,pi->pk", self.inward[plank], ahead)
            lack = self.limits[plank] - np.einsum("pki,pi->pk", self.inward[plank], base)
            level = np.abs(slope) <= tol.parallel
            place = lack / np.where(level, 1.0, slope)
            low = np.maximum(low, np.where(~level & (slope > 0), place, -np.inf).max(axis=1))
            high = np.minimum(high, np.where(~level & (slope < 0), place, np.inf).min(axis=1))
            shut = (level & (lack > tol.planar)).any(axis=1)
            high = np.where(shut, -np.inf, high)
        return low, high


def _apart(points: FloatArray, others: FloatArray, distance: float) -> BoolArray:
    """Tell which of (m, c, 2) points keep a distance from all of (n, 2) others."""
    free = np.ones(points.shape[:2], dtype=bool)
    for row in range(len(points)):
        low, high = points[row].min(axis=0) - distance, points[row].max(axis=0) + distance
        near = others[((others >= low) & (others <= high)).all(axis=1)]
        if len(near):
            arms = points[row][:, None] - near[None]
            free[row] = (np.hypot(arms[..., 0], arms[..., 1]) >= distance).all(axis=1)
    return free


def _first_apart(points: FloatArray, distance: float) -> IntArray:
    """Return which points to keep so that all are apart; earlier ones win."""
    arms = points[:, None] - points[None]
    near = np.hypot(arms[..., 0], arms[..., 1]) < distance
    np.fill_diagonal(near, False)
    kept = np.ones(len(points), dtype=bool)
    for k in np.flatnonzero(near.any(axis=1)):
        if kept[k]:
            kept[k + 1 :] &= ~near[k, k + 1 :]
    return np.flatnonzero(kept)
