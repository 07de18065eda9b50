"""How pieces may be turned on a sheet.

A piece with a fibre direction follows the grain of the sheet: along it, the other way round where
half turns are allowed, and turned off it, within the tolerance, until its longest edge that can be
is square to the sheet. A piece without, or on a sheet without grain, is turned by quarters from
where its bounding rectangle is smallest. A piece is never turned over: its marked face is up.

Source: section 4.3 (each element oriented to the fibre direction of the raw material).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ifs_cad.elements.material import Material
from ifs_cad.fabrication.convex import Polygons, support
from ifs_cad.fabrication.layout import Placement
from ifs_cad.fabrication.stock import Sheet
from ifs_cad.types import BoolArray, FloatArray

QUARTERS = np.array([0.0, 90.0, 180.0, 270.0])

ALIKE = 0.01
"""Two turns of a piece count as one when its outlines differ by less than this share of its size:
most panels are nearly parallelograms, which half a turn hardly changes."""


ASLANT = 90
"""How many steps are tried on either side for a piece that is too large square to the sheet."""


class Piece(Protocol):
    """What nesting must know of a workpiece, see `workpiece.Workpiece`."""

    @property
    def address(self) -> str:
        """What it is called."""

    @property
    def silhouette(self) -> FloatArray:
        """(n, 2) float, convex, counter-clockwise, mm."""

    @property
    def fibre(self) -> FloatArray | None:
        """(2,) float, unit vector along the grain."""

    @property
    def thickness(self) -> float:
        """In mm."""

    @property
    def material(self) -> Material:
        """What it is made of."""


class FibreLimits(Protocol):
    """How far a piece may be turned off its fibre direction, see `elements.fibre.Fibre`."""

    @property
    def tolerance(self) -> float:
        """In degrees."""

    @property
    def half_turn(self) -> bool:
        """Whether it may lie the other way round."""


@dataclass(frozen=True, eq=False)
class Poses:
    """All turns of n pieces on one kind of sheet, up to m of each.

    Attributes
    ----------
    polygons : (n, m) Polygons, turned, lower left corners of their bounding boxes at the origin
    turns : (n, m) float, degrees
    corners : (n, m, 2) float, where these lower left corners lie when a piece is turned about its
        own origin, mm
    allowed : (n, m) bool, False where a piece has fewer turns or is too large for the sheet
    """

    polygons: Polygons
    turns: FloatArray
    corners: FloatArray
    allowed: BoolArray

    def placement(self, address: str, piece: int, pose: int, spot: FloatArray) -> Placement:
        """Return how a piece lies with the lower left corner of its box at a (2,) spot."""
        x, y = (spot - self.corners[piece, pose]).tolist()
        return Placement(address, float(self.turns[piece, pose]), x, y)


def poses_on(
    pieces: Sequence[Piece], sheet: Sheet, limits: FibreLimits | None, room: FloatArray
) -> Poses:
    """Return the turns of pieces on a sheet.

    Parameters
    ----------
    pieces : sequence of Piece
    sheet : Sheet
    limits : FibreLimits or None
        None for exact fibre directions with half turns.
    room : (2,) float
        Length and width of the sheet inside its margins, mm.
    """
    turns = [_turns(piece, sheet, limits, room) for piece in pieces]
    most = max(len(choice) for choice in turns)
    filled = np.array([np.pad(choice, (0, most - len(choice)), mode="edge") for choice in turns])
    outlines = [
        Placement(piece.address, turn, 0.0, 0.0)(piece.silhouette)
        for piece, choice in zip(pieces, filled, strict=True)
        for turn in choice.tolist()
    ]
    corners = np.array([outline.min(axis=0) for outline in outlines])
    polygons = Polygons.of(
        [outline - corner for outline, corner in zip(outlines, corners, strict=True)]
    ).reshaped(len(pieces), most)
    fits: BoolArray = np.asarray((polygons.sizes <= room).all(axis=-1))
    allowed = fits & ~_repeats(polygons, fits)
    return Poses(polygons, filled, corners.reshape(len(pieces), most, 2), allowed)


def sheet_angle(sheet: Sheet) -> float:
    """Return the angle of the grain of a sheet to its length, degrees."""
    return 90.0 if sheet.fibre == "width" else 0.0


def _turns(piece: Piece, sheet: Sheet, limits: FibreLimits | None, room: FloatArray) -> FloatArray:
    """Return the angles that a piece may be turned by, degrees."""
    edges = np.roll(piece.silhouette, -1, axis=0) - piece.silhouette
    angles = np.degrees(np.arctan2(edges[:, 1], edges[:, 0]))
    if piece.fibre is None or sheet.fibre is None:
        square = -angles
        areas = _extents(piece.silhouette, square).prod(axis=-1)
        turns, tolerance = square[np.argmin(areas)] + QUARTERS, 90.0
    else:
        x, y = piece.fibre
        exact = sheet_angle(sheet) - np.degrees(np.arctan2(y, x))
        tolerance, half_turn = (limits.tolerance, limits.half_turn) if limits else (0.0, True)
        turns = exact + np.array([0.0, 180.0] if half_turn else [0.0])
        lengths = np.hypot(edges[:, 0], edges[:, 1])
        off = (angles + exact + 45.0) % 90.0 - 45.0  # the turned edges, off square to the sheet
        reachable = (np.abs(off) <= tolerance) & (lengths > 0.0)
        if reachable.any():
            squaring = off[np.argmax(np.where(reachable, lengths, 0.0))]
            turns = np.append(turns, turns - squaring)
    fits = (_extents(piece.silhouette, turns) <= room).all(axis=-1)
    if tolerance > 0.0 and not fits.any():  # aslant it may
        aslant = turns[:, None] + np.linspace(-tolerance, tolerance, 2 * ASLANT + 1)
        spare = (room - _extents(piece.silhouette, aslant.ravel())).min(axis=-1)
        turns = np.append(turns, aslant.ravel()[np.argmax(spare)])
    return np.asarray(turns % 360.0)


def _extents(outline: FloatArray, turns: FloatArray) -> FloatArray:
    """Return (t, 2) float, length and width of an outline turned by (t,) angles, mm."""
    radians = -np.radians(turns)
    x = np.column_stack([np.cos(radians), np.sin(radians)])
    axes = np.stack([x, np.column_stack([-x[:, 1], x[:, 0]])], axis=1)
    return np.asarray(np.ptp(axes @ outline.T, axis=-1))


def _repeats(polygons: Polygons, fits: BoolArray) -> BoolArray:
    """Return which of (n, m) turned pieces look like an earlier one that fits."""
    one, other = polygons[:, :, None], polygons[:, None, :]
    differences = np.abs(support(other.corners, one.normals) - one.levels).max(axis=-1)
    apart = np.maximum(differences, np.swapaxes(differences, 1, 2))
    alike = apart < ALIKE * polygons.sizes.max(axis=-1)[:, :, None]
    earlier = np.tri(alike.shape[1], k=-1, dtype=bool)
    return np.asarray((alike & earlier & fits[:, None, :]).any(axis=-1))
