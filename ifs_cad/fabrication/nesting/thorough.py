"""Filling one sheet, thoroughly: spyrrow packs a strip as high as the sheet is wide.

spyrrow makes a strip of given height as short as it can with all of its pieces, within a time. So
it is given the next pieces in order, as many as should fit, then more or fewer, and neighbours stay
together. Its distances are approximate: from the left, each of its pieces is moved to the right
until it is truly free, then slid down and left until it touches; those beyond the sheet are taken
off, and what still fits is added the fast way. Where that is no better than the fast way alone, the
fast way stays.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from threading import Thread
from typing import Any

import numpy as np

from ifs_cad.fabrication.convex import Polygons, blocked, forbidden, stacked
from ifs_cad.fabrication.nesting.packing import Spot, fill_sheet, settled
from ifs_cad.fabrication.nesting.supply import Fill, Kind, Load, loaded_area
from ifs_cad.libraries import require
from ifs_cad.progress import report
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import FloatArray

DENSITY = 0.85
"""Which share of a sheet is expected to be filled, pieces and half of the spacing around them."""

TRIES = 3
"""How many numbers of pieces are tried for a sheet."""

AWAKE = 0.05
"""How often a running solve looks for Ctrl-C, seconds."""


class StripFill:
    """Fills sheets one after the other, until a deadline; the fast way from then on.

    Parameters
    ----------
    spacing : float, mm
    kinds : int, how many kinds of sheets are tried each time
    pieces : int, how many there are
    fast : Fill, what to fall back on
    deadline : float, of the clock `time.monotonic`, for all sheets
    seed : int

    Raises
    ------
    MissingLibraryError
        spyrrow is not installed.
    """

    def __init__(
        self,
        spacing: float,
        *,
        kinds: int,
        pieces: int,
        fast: Fill,
        deadline: float,
        seed: int,
        tol: Tolerance = DEFAULT,
    ) -> None:
        self.spyrrow: Any = require("spyrrow", "thorough nesting", "nesting")
        self.spacing, self.kinds, self.pieces, self.fast = spacing, kinds, pieces, fast
        self.seed, self.tol = seed, tol
        self.deadline = deadline

    def __call__(self, kind: Kind, left: list[int]) -> list[Spot]:
        """Fill the next sheet of a kind."""
        report("nesting", self.pieces - len(left), self.pieces)
        best = self.fast(kind, left)
        if len(best) == len(left):
            return best
        swollen = self._swollen_areas(kind, left)
        capacity = float(np.prod(kind.room + self.spacing)) * DENSITY
        sheets = math.ceil(float(swollen.sum()) / capacity)
        share = (self.deadline - time.monotonic()) / (sheets * self.kinds * TRIES)
        count = max(1, int(np.searchsorted(np.cumsum(swollen), capacity)))
        for _ in range(TRIES):
            if self.deadline - time.monotonic() < 1.0:
                break
            laid = self._lay(kind, left[:count], max(1, round(share)))
            rest = sorted(set(left) - {spot.piece for spot in laid}, key=left.index)
            more = fill_sheet(
                kind.poses, rest, kind.room, self.spacing, window=len(left), taken=laid
            )
            best = max(best, laid + more, key=lambda spots: loaded_area(Load(kind, spots)))
            dropped = count - len(laid)
            count = min(max(1, count - math.ceil(dropped / 2) if dropped else count + 1), len(left))
        return best

    def _swollen_areas(self, kind: Kind, pieces: Sequence[int]) -> FloatArray:
        """Return the areas of pieces with half of the spacing around them, mm2."""
        polygons = kind.poses.polygons[np.array(pieces), 0]
        edges = np.roll(polygons.corners, -1, axis=1) - polygons.corners
        around = np.hypot(edges[..., 0], edges[..., 1]).sum(axis=1)
        return np.asarray(polygons.areas + around * self.spacing / 2.0)

    def _lay(self, kind: Kind, pieces: Sequence[int], seconds: int) -> list[Spot]:
        """Pack a strip of some pieces and return those that lie on the sheet."""
        poses, spacing = kind.poses, self.spacing
        first = np.argmax(poses.allowed, axis=1)
        items = []
        for piece in pieces:
            corners = poses.polygons.corners[piece, first[piece]]
            fresh = np.append((np.diff(corners, axis=0) != 0.0).any(axis=1), True)
            turns = poses.turns[piece, poses.allowed[piece]] - poses.turns[piece, first[piece]]
            items.append(
                self.spyrrow.Item(
                    str(piece), [tuple(xy) for xy in corners[fresh].tolist()], 1, turns.tolist()
                )
            )
        # it keeps the spacing from the edges of the strip as well
        strip = self.spyrrow.StripPackingInstance(
            "sheet", float(kind.room[1]) + 2.0 * spacing, items
        )
        config = self.spyrrow.StripPackingConfig(
            total_computation_time=seconds, min_items_separation=spacing or None, seed=self.seed
        )
        spots = []
        for item in _interruptible(strip, config).placed_items:
            piece = int(item.id)
            off = poses.turns[piece] - poses.turns[piece, first[piece]] - item.rotation
            off = np.abs((off + 180.0) % 360.0 - 180.0)
            pose = int(np.argmin(np.where(poses.allowed[piece], off, np.inf)))
            # the corner of the box of the first pose, turned about the origin as it was
            radians = math.radians(item.rotation)
            x, y = poses.polygons.corners[piece, first[piece]].T
            turned = [
                math.cos(radians) * x - math.sin(radians) * y,
                math.sin(radians) * x + math.cos(radians) * y,
            ]
            corner = np.min(turned, axis=1) + np.array(item.translation) - spacing
            spots.append(Spot(piece, pose, corner))
        return self._true(kind, sorted(spots, key=lambda spot: float(spot.corner[0])))

    def _true(self, kind: Kind, spots: list[Spot]) -> list[Spot]:
        """Move pieces, from the left, until each is free and on the sheet; leave out the others."""
        placed: list[Polygons] = []
        kept: list[Spot] = []
        for spot in spots:
            polygon = kind.poses.polygons[spot.piece, spot.pose]
            spare = kind.room - polygon.sizes
            corner = np.array([max(spot.corner[0], 0.0), np.clip(spot.corner[1], 0.0, spare[1])])
            if placed:
                corner[0] = self._free(placed, polygon, corner)
                corner = settled(placed, polygon, corner, self.spacing, tol=self.tol)
            if corner[0] <= spare[0]:
                placed.append(polygon.moved(corner))
                kept.append(Spot(spot.piece, spot.pose, corner))
        return kept

    def _free(self, placed: list[Polygons], polygon: Polygons, corner: FloatArray) -> float:
        """Return the next x from a corner on where a polygon is free."""
        normals, levels = forbidden(stacked(placed), polygon, self.spacing)
        start, end = blocked(normals, levels, corner[1:], 0, tol=self.tol)
        x, slack = float(corner[0]), self.tol.coincident / 2.0
        while True:
            inside = (x > start + slack) & (x < end - slack)
            if not inside.any():
                return x
            x = float(end[inside].max())


def _interruptible(strip: Any, config: Any) -> Any:
    """Solve on another thread, so that Ctrl-C is heard."""
    outcome: list[Any] = []

    def solve() -> None:
        try:
            outcome.append(strip.solve(config))
        except BaseException as error:  # a panic of Rust is no Exception
            outcome.append(error)

    thread = Thread(target=solve, name="spyrrow", daemon=True)
    thread.start()
    while thread.is_alive():
        thread.join(AWAKE)
    if isinstance(outcome[0], BaseException):
        raise outcome[0]
    return outcome[0]
