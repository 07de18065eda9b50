"""What a flank cutter sweeps along the sides of workpieces, leads included, seen from above.

The swept body between two heights is convex, and so is its plan: a polygon that stands around the
cutter's circle. Neighbours on the sheet, and the bridges that hold them, must lie outside.

Source: section 4.3 (multi-part plates).
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ifs_cad.errors import MachineError
from ifs_cad.fabrication.convex import Polygons, distances, support
from ifs_cad.fabrication.layout import Placement
from ifs_cad.fabrication.machining.flank import FlankCuts, Flanks
from ifs_cad.fabrication.machining.settings import Settings
from ifs_cad.fabrication.machining.tool import Tool
from ifs_cad.fabrication.workpiece import Workpiece
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import BoolArray, FloatArray, IntArray

QUARTER = 8
"""Corners of the polygon around a quarter of the cutter."""


def swept(cuts: FlankCuts, top: float) -> Polygons:
    """Return (m,) plans of what is swept between the table and a height, mm."""
    along, near, far = _profile(cuts, top)
    flanks = cuts.flanks
    starts, stops = flanks.starts - cuts.lead, flanks.stops + cuts.lead
    ahead, behind = along[: QUARTER + 1], along[QUARTER:]
    # around the front from near to far, then around the back
    ways = np.concatenate(
        [
            stops[:, None] + ahead[::-1],
            stops[:, None] + ahead,
            starts[:, None] + behind,
            starts[:, None] + behind[::-1],
        ],
        axis=1,
    )
    outs = np.concatenate(
        [
            near[:, QUARTER::-1],
            far[:, : QUARTER + 1],
            far[:, QUARTER:],
            near[:, : QUARTER - 1 : -1],
        ],
        axis=1,
    )
    outward = flanks.normals[:, :2] / flanks.axes[:, 2:]
    corners = ways[..., None] * flanks.travels[:, None, :2] + outs[..., None] * outward[:, None]
    if cuts.settings.direction == "conventional":  # outward lies on the right of the travel
        corners = corners[:, ::-1]
    return Polygons.of(list(corners))


def _profile(cuts: FlankCuts, top: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the plan of a cutter that stands at its final depth, clipped to heights of 0 to `top`.

    Returns
    -------
    along : (k,) float, places along the travel, from the front to the back, mm
    near, far : (m, k) float, extent outward there, mm
    """
    flanks = cuts.flanks
    angles = np.linspace(0.0, np.pi, 2 * QUARTER + 1)
    radius = cuts.radius / np.cos(np.pi / (4 * QUARTER))  # the polygon stands around the circle
    along, half = radius * np.cos(angles), radius * np.sin(angles)
    slope, rise = flanks.normals[:, 2, None], flanks.axes[:, 2, None]
    # in the upright plane across the travel: the axis leans by -slope outward and by rise upward
    foot = _foot(cuts)[:, None]
    height = cuts.bases[:, 2, None]
    outs = []
    for side in (-half, half):
        raw = np.broadcast_to(side, (len(flanks), len(side)))
        clipped = _clipped(raw, height, slope, top, half)
        for across in (raw, clipped):
            inside = np.where(height + across * slope > top, clipped, across)
            level = height + inside * slope
            for lift in (np.maximum(-level / rise, 0.0), np.maximum((top - level) / rise, 0.0)):
                outs.append(foot + inside * rise - lift * slope)
    return along, np.min(outs, axis=0), np.max(outs, axis=0)


def _foot(cuts: FlankCuts) -> FloatArray:
    """Return (m,) float, how far outward the tip stands in plan, mm."""
    normals = cuts.flanks.normals[:, :2]
    return np.asarray(np.sum(cuts.bases[:, :2] * normals, axis=1) / cuts.flanks.axes[:, 2])


def _clipped(
    across: FloatArray, height: FloatArray, slope: FloatArray, top: float, half: FloatArray
) -> FloatArray:
    """Return places across the tool's end moved to where the end is between 0 and `top`."""
    level = height + across * slope
    wanted = np.clip(level, 0.0, top)
    steep = np.where(slope == 0.0, 1.0, slope)
    moved = np.where(slope == 0.0, across, (wanted - height) / steep)
    return np.clip(moved, -half, half)


def meet(one: Polygons, other: Polygons) -> BoolArray:
    """Tell which of (k,) pairs of polygons overlap."""
    gaps = (-support(other.corners, -one.normals) - one.levels).max(axis=-1)
    back = (-support(one.corners, -other.normals) - other.levels).max(axis=-1)
    return np.asarray(np.maximum(gaps, back) < 0.0)


def near(one: Polygons, other: Polygons) -> tuple[IntArray, IntArray]:
    """Return the pairs of (n,) and (m,) polygons whose bounding boxes overlap."""
    low, high = one.corners.min(axis=1), one.corners.max(axis=1)
    other_low, other_high = other.corners.min(axis=1), other.corners.max(axis=1)
    apart = (low[:, None] > other_high) | (other_low > high[:, None])
    first, second = np.nonzero(~apart.any(axis=-1))
    return first, second


def require_clear(cuts: FlankCuts, tol: Tolerance = DEFAULT) -> None:
    """Check that no cutter sweeps into a neighbour.

    Raises
    ------
    MachineError
        Names the piece that is cut, its side, and the one that would be damaged.
    """
    placed = cuts.flanks.placed
    silhouettes = Polygons.of([placement(piece.silhouette) for piece, placement in placed])
    sweeps = swept(cuts, cuts.thickness)
    side, piece = near(sweeps, silhouettes)
    others = cuts.flanks.pieces[side] != piece
    side, piece = side[others], piece[others]
    hit = meet(sweeps[side], silhouettes[piece])
    side, piece = side[hit], piece[hit]
    if not len(side):
        return
    both = Polygons.of([*sweeps.corners[side], *silhouettes.corners[piece]])
    depths = -distances(both, np.arange(len(side)), len(side) + np.arange(len(side)))
    worst = int(np.argmax(depths))
    if depths[worst] <= tol.planar:
        return
    index, damaged = int(side[worst]), placed[piece[worst]][0].address
    addresses = [cuts.flanks.address(index), damaged]
    raise MachineError(
        f"Cutting the {cuts.flanks.name(index)} with {cuts.tool} would reach "
        f"{depths[worst]:.2f} mm into {damaged}. Nest with a spacing of at least "
        f"{_reach(cuts, sweeps).max():.1f} mm, or use a thinner cutter or a shorter lead.",
        addresses=addresses,
        depth=float(depths[worst]),
    )


def contour_reach(
    pieces: Iterable[Workpiece], tool: Tool, settings: Settings | None = None
) -> float:
    """Return how far the cutter reaches beyond any silhouette, leads included, mm.

    The spacing that nesting has to keep. Twice as much, and what `Settings.tab_landing` asks for,
    makes sure that every bridge ends in what is left of the sheet.
    """
    settings = settings or Settings()
    reach = 0.0
    for piece in pieces:
        flanks = Flanks.of([(piece, Placement(piece.address, 0.0, 0.0, 0.0))], settings.direction)
        cuts = FlankCuts(flanks, tool, settings, piece.thickness)
        reach = max(reach, float(_reach(cuts, swept(cuts, piece.thickness)).max()))
    return reach


def _reach(cuts: FlankCuts, sweeps: Polygons) -> FloatArray:
    """Return (m,) float, how far each sweep reaches beyond its own silhouette, mm."""
    placed = cuts.flanks.placed
    outlines = Polygons.of([placement(piece.silhouette) for piece, placement in placed])
    rings = outlines.corners[cuts.flanks.pieces][:, None]
    edges = np.roll(rings, -1, axis=-2) - rings
    offsets = sweeps.corners[:, :, None] - rings
    squares = np.sum(edges * edges, axis=-1)
    share = np.sum(offsets * edges, axis=-1) / np.where(squares > 0.0, squares, 1.0)
    rest = offsets - np.clip(share, 0.0, 1.0)[..., None] * edges
    return np.asarray(np.hypot(rest[..., 0], rest[..., 1]).min(axis=-1).max(axis=-1))
