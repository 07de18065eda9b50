"""Filling one sheet, fast: pieces slide to the left until they touch, the snuggest goes first.

Every piece of a window is tried in all its turns, at a grid of heights, as far left as it goes; the
one with most of its outline against others or the edge of the sheet stays, large ones and places
to the left preferred, then slides down and left until it touches. The places where a piece may not
lie are known exactly (`convex.forbidden`), and each new neighbour only adds to them, so that a step
costs a few array operations. Nothing is random.

Terms
-----
window : the next pieces in order, which may be chosen from; the smaller, the closer neighbours
    stay together.
slot : a turn of a piece of the window.
halo : points around a piece; the share of them that is taken tells how snug it lies.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ifs_cad.fabrication.convex import Polygons, blocked, forbidden, stacked
from ifs_cad.fabrication.nesting.poses import Poses
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import FloatArray, IntArray

REACH = 48
"""How many pieces beyond the window are tried when none of it fits any more."""

HEIGHTS = 48
"""At how many heights each piece is tried; it slides on from there."""

CELLS = 128
"""How many cells of the raster that tells what is taken make up the width of the sheet."""

HALO = np.array([1.5, 3.0, 5.5])
"""Distances of the halo, in spacings, or in cells where these are more."""

HALO_STEPS = 6
"""Points of the halo along an edge."""

PULL = 1.25
"""How much snugness, 0 to 1, a piece must gain to lie one width of the sheet farther right."""

SIZE = 0.2
"""How much snugness a piece may lack for each time the mean area that it is larger."""

SLIDES = 3
"""How often a piece slides down and left after it was chosen."""


@dataclass(frozen=True, eq=False)
class Spot:
    """Where a piece lies: its pose, and the lower left corner of its box within the margins, mm."""

    piece: int
    pose: int
    corner: FloatArray


def fill_sheet(
    poses: Poses,
    order: Sequence[int],
    room: FloatArray,
    spacing: float,
    *,
    window: int,
    reach: bool = True,
    taken: Sequence[Spot] = (),
    tol: Tolerance = DEFAULT,
) -> list[Spot]:
    """Fill a sheet with as many of some pieces as go on it.

    Parameters
    ----------
    poses : Poses
    order : sequence of int
        The pieces that are left, neighbours next to each other.
    room : (2,) float
        Length and width of the sheet inside its margins, mm.
    spacing : float
        Least distance of two pieces, mm.
    window : int
        From how many pieces the next one is chosen.
    reach : bool
        Whether pieces beyond the window may be taken when none of it fits any more.
    taken : sequence of Spot
        What already lies on the sheet.

    Returns
    -------
    list of Spot
        Without those that were already taken; their pieces are among `order`.
    """
    table = _Table(poses, room, spacing, tol)
    for spot in taken:
        table.put(spot)
    waiting = list(order)
    table.deal(waiting[:window])
    del waiting[:window]
    spots = []
    while True:
        best = table.snuggest()
        if best is not None:
            spots.append(best)
            table.put(best)
            table.deal(waiting[:1])
            del waiting[:1]
        elif waiting and reach:
            table.clear()
            table.deal(waiting[:REACH])
            waiting = []
        else:
            return spots


class _Table:
    """A sheet being filled, and the slots of the window with the places they may take."""

    def __init__(self, poses: Poses, room: FloatArray, spacing: float, tol: Tolerance) -> None:
        self.poses, self.room, self.spacing, self.tol = poses, room, spacing, tol
        self.areas = poses.polygons.areas[:, 0] / poses.polygons.areas[:, 0].mean()
        self.placed: list[Polygons] = []
        self.raster = _Raster(room, spacing)
        self.clear()

    def clear(self) -> None:
        """Empty the window."""
        self.pieces: IntArray = np.empty(0, dtype=int)
        self.turned: IntArray = np.empty(0, dtype=int)
        self.y: FloatArray = np.empty((0, HEIGHTS))
        self.x: FloatArray = np.empty((0, HEIGHTS))
        self.starts: FloatArray = np.empty((0, HEIGHTS, len(self.placed)))
        self.ends: FloatArray = self.starts
        self.halo: IntArray = np.empty((0, 0), dtype=int)
        self.weights: FloatArray = np.empty((0, 0))

    def deal(self, pieces: Sequence[int]) -> None:
        """Add pieces to the window."""
        if not pieces:
            return
        chosen = np.array(pieces)
        row, turned = np.nonzero(self.poses.allowed[chosen])
        piece = chosen[row]
        polygons = self.poses.polygons[piece, turned]
        y = np.linspace(0.0, self.room[1] - polygons.sizes[:, 1], HEIGHTS, axis=-1)
        if self.placed:
            starts, ends = self._blocked(stacked(self.placed), polygons[:, None], y[:, None])
        else:
            starts = ends = np.empty((len(piece), 0, HEIGHTS))
        halo, weights = self.raster.halo(polygons)
        old = len(self.pieces)
        self.pieces = np.append(self.pieces, piece)
        self.turned = np.append(self.turned, turned)
        self.y = np.concatenate([self.y, y])
        self.x = np.concatenate([self.x, np.zeros_like(y)])
        self.starts = np.concatenate([self.starts, np.swapaxes(starts, 1, 2)])
        self.ends = np.concatenate([self.ends, np.swapaxes(ends, 1, 2)])
        self.halo = np.concatenate([self.halo.reshape(old, halo.shape[1]), halo])
        self.weights = np.concatenate([self.weights.reshape(old, halo.shape[1]), weights])
        if self.placed:
            slots, rows = np.indices(y.shape).reshape(2, -1)
            self._slide(slots + old, rows)

    def snuggest(self) -> Spot | None:
        """Return the best of all places that the window may take, slid until it touches."""
        sizes = self.poses.polygons.sizes[self.pieces, self.turned, 0]
        slots, rows = np.nonzero(self.x <= (self.room[0] - sizes)[:, None] + self.slack)
        if not len(slots):
            return None
        x, y = self.x[slots, rows], self.y[slots, rows]
        pull = PULL / self.room[1]
        snug = self.raster.share(self.halo[slots], self.weights[slots], x, y)
        large = SIZE * self.areas[self.pieces[slots]]
        best = int(np.argmax(snug + large - pull * x))
        slot = slots[best]
        piece, pose = int(self.pieces[slot]), int(self.turned[slot])
        return self._settled(Spot(piece, pose, np.array([x[best], y[best]])))

    def put(self, spot: Spot) -> None:
        """Lay a piece on the sheet and take it out of the window."""
        polygon = self.poses.polygons[spot.piece, spot.pose].moved(spot.corner)
        self.placed.append(polygon)
        self.raster.take(polygon)
        keep = self.pieces != spot.piece
        for name in ("pieces", "turned", "y", "x", "starts", "ends", "halo", "weights"):
            setattr(self, name, getattr(self, name)[keep])
        if not len(self.pieces):
            self.starts = self.ends = np.empty((0, HEIGHTS, len(self.placed)))
            return
        polygons = self.poses.polygons[self.pieces, self.turned]
        start, end = self._blocked(polygon[None], polygons, self.y)
        self.starts = np.concatenate([self.starts, start[..., None]], axis=-1)
        self.ends = np.concatenate([self.ends, end[..., None]], axis=-1)
        inside = (self.x > start + self.slack) & (self.x < end - self.slack)
        self._slide(*np.nonzero(inside))

    @property
    def slack(self) -> float:
        """Half of what counts as one point: what a rounded contact may intrude, mm."""
        return self.tol.coincident / 2.0

    def _blocked(
        self, fixed: Polygons, moving: Polygons, across: FloatArray, axis: int = 0
    ) -> tuple[FloatArray, FloatArray]:
        normals, levels = forbidden(fixed, moving, self.spacing)
        return blocked(normals, levels, across, axis, tol=self.tol)

    def _slide(self, slots: IntArray, rows: IntArray) -> None:
        """Move slots to the right, each on its row, past all that blocks them."""
        while len(slots):
            x = self.x[slots, rows]
            starts, ends = self.starts[slots, rows], self.ends[slots, rows]
            inside = (x[:, None] > starts + self.slack) & (x[:, None] < ends - self.slack)
            moves = inside.any(axis=-1)
            slots, rows = slots[moves], rows[moves]
            self.x[slots, rows] = np.where(inside, ends, -np.inf).max(axis=-1)[moves]

    def _settled(self, spot: Spot) -> Spot:
        """Slide a piece down and left until it touches."""
        if not self.placed:
            return spot
        polygon = self.poses.polygons[spot.piece, spot.pose]
        return replace(spot, corner=settled(self.placed, polygon, spot.corner, self.spacing))


def settled(
    placed: Sequence[Polygons],
    polygon: Polygons,
    corner: FloatArray,
    spacing: float,
    *,
    tol: Tolerance = DEFAULT,
) -> FloatArray:
    """Slide a polygon down and left until it touches.

    Parameters
    ----------
    placed : sequence of Polygons
        At least one, each a single polygon.
    polygon : Polygons
        A single one, the lower left corner of its bounding box at the origin.
    corner : (2,) float
        Where this corner lies at first, with no polygon nearer than `spacing`, mm.
    """
    corner = corner.copy()
    slack = tol.coincident / 4.0
    normals, levels = forbidden(stacked(placed), polygon, spacing)
    for _ in range(SLIDES):
        before = corner.copy()
        for axis in (1, 0):
            # less by what a rounded contact may intrude: along an edge that is almost level with
            # the way, that little would seem to lie deep inside
            line = corner[1 - axis : 2 - axis]
            start, end = blocked(normals, levels - slack, line, axis, tol=tol)
            # whatever begins behind the piece stops it, here at the latest
            behind = (start < end) & (start < corner[axis])
            stops = np.where(behind, np.minimum(end, corner[axis]), 0.0)
            corner[axis] = min(corner[axis], stops.max(initial=0.0))
        if (before == corner).all():
            break
    return corner


class _Raster:
    """Which cells of a sheet are taken; beyond its edges all are, except on the right."""

    def __init__(self, room: FloatArray, spacing: float) -> None:
        self.cell = float(room[1]) / CELLS
        self.distances = HALO * max(spacing, self.cell)
        self.frame = int(np.ceil(self.distances[-1] / self.cell)) + 2
        cells = np.ceil(room / self.cell).astype(int)
        self.taken = np.ones(cells + 2 * self.frame, dtype=np.float32)
        self.taken[self.frame :, self.frame : self.frame + cells[1]] = 0.0

    def take(self, polygon: Polygons) -> None:
        """Mark the cells whose middles lie in a polygon."""
        low = np.floor(polygon.corners.min(axis=0) / self.cell).astype(int)
        high = np.ceil(polygon.corners.max(axis=0) / self.cell).astype(int)
        spans = [np.arange(*span) for span in zip(low, high, strict=True)]
        middles = (np.stack(np.meshgrid(*spans, indexing="ij"), axis=-1) + 0.5) * self.cell
        x, y = (slice(*span) for span in zip(low + self.frame, high + self.frame, strict=True))
        self.taken[x, y][polygon.hold(middles)] = 1.0

    def halo(self, polygons: Polygons) -> tuple[IntArray, FloatArray]:
        """Return the cells around (n,) polygons and what each counts; a row adds up to 1."""
        corners, ends = polygons.corners, np.roll(polygons.corners, -1, axis=1)
        steps = (np.arange(HALO_STEPS)[:, None] + 0.5) / HALO_STEPS
        points = corners[:, :, None] * (1.0 - steps) + ends[:, :, None] * steps
        outward = self.distances[:, None] * polygons.normals[:, :, None, None]
        around = points[:, :, :, None] + outward
        cells = np.floor(around / self.cell).astype(int)
        lengths = np.linalg.norm(ends - corners, axis=-1)
        weights = lengths / lengths.sum(axis=1, keepdims=True) / (HALO_STEPS * len(HALO))
        weights = np.repeat(weights, HALO_STEPS * len(HALO), axis=1)
        flat = cells[..., 0] * self.taken.shape[1] + cells[..., 1]
        return flat.reshape(len(corners), -1), weights.astype(np.float32)

    def share(
        self, halo: IntArray, weights: FloatArray, x: FloatArray, y: FloatArray
    ) -> FloatArray:
        """Return (n,) float, which share of the halo of slots at x, y is taken."""
        column = np.floor(x / self.cell).astype(int) + self.frame
        row = np.floor(y / self.cell).astype(int) + self.frame
        places = (column * self.taken.shape[1] + row)[:, None] + halo
        return np.asarray(np.einsum("nh,nh->n", self.taken.ravel().take(places), weights))
