"""Bridges that hold a piece to its sheet while its contour is cut.

A bridge stands on the table across the kerf of one side. It holds only where it ends in wood that
nothing else cuts away: clear of the corners, where the cutter runs out along the next side, and of
all that is swept around the neighbours. Of many places along a side those nearest to an even
division are taken.

Source: section 4.3 (machining of the actual element).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.errors import MachineError
from ifs_cad.fabrication.convex import Polygons
from ifs_cad.fabrication.machining.flank import FlankCuts
from ifs_cad.fabrication.machining.sweep import meet, near, swept
from ifs_cad.types import BoolArray, FloatArray, IntArray

FEWEST = 2
"""Bridges of a piece; by a single one it could turn."""

PLACES = 9
"""Places that are tried for each bridge."""


class _Candidates(NamedTuple):
    """Places for bridges.

    (k,) side, number of the bridge along it, way along the travel in mm, and distance from the
    middle of its share of the side in mm.
    """

    side: IntArray
    number: IntArray
    middle: FloatArray
    off: FloatArray


def tab_places(cuts: FlankCuts) -> list[FloatArray]:
    """Return for each of (m,) sides the ways along its travel where bridges stand, mm, ascending.

    Raises
    ------
    MachineError
        Names the pieces that too few bridges can hold.
    """
    candidates = _candidates(cuts)
    holds = _holds(cuts, candidates)
    # the candidate nearest to its place in an even division
    order = np.lexsort((candidates.off, candidates.number, candidates.side))
    order = order[holds[order]]
    side, number = candidates.side[order], candidates.number[order]
    is_best = np.ones(len(order), dtype=bool)
    is_best[1:] = (side[1:] != side[:-1]) | (number[1:] != number[:-1])
    best_side, best = side[is_best], candidates.middle[order][is_best]
    _require_enough(cuts, best_side)
    return np.split(best, np.searchsorted(best_side, np.arange(1, len(cuts.flanks))))


def _candidates(cuts: FlankCuts) -> _Candidates:
    settings = cuts.settings
    margin = cuts.lead + cuts.radius + settings.tab_length / 2.0
    start, stop = cuts.flanks.bottoms.T
    room = np.where(stop > start, stop - start, 0.0) - 2.0 * margin
    wanted = np.where(room > 0.0, np.ceil(room / settings.tab_spacing), 0.0).astype(np.int64)
    side = np.repeat(np.arange(len(wanted)), wanted * PLACES)
    first = np.cumsum(wanted * PLACES) - wanted * PLACES
    number, place = np.divmod(np.arange(len(side)) - first[side], PLACES)
    step = room[side] / wanted[side]
    share = (place + 0.5) / PLACES
    middle = start[side] + margin + (number + share) * step
    return _Candidates(side, number, middle, np.abs(share - 0.5) * step)


def _holds(cuts: FlankCuts, candidates: _Candidates) -> BoolArray:
    """Tell which bridges end in wood that no neighbour's contour takes."""
    flanks, settings = cuts.flanks, cuts.settings
    sweeps = swept(cuts, settings.tab_height)
    side = candidates.side
    if not len(side):
        return np.zeros(0, dtype=bool)
    outward = flanks.normals[:, :2] / flanks.axes[:, 2:]
    reaches = np.sum(sweeps.corners * outward[:, None], axis=-1)
    out = np.stack([reaches.min(axis=1), reaches.max(axis=1) + settings.tab_landing], axis=1)
    ends = settings.tab_length / 2.0 * np.array([-1.0, 1.0, 1.0, -1.0])
    ways, outs = candidates.middle[:, None] + ends, out[side][:, [0, 0, 1, 1]]
    corners = ways[..., None] * flanks.travels[side, None, :2]
    corners += outs[..., None] * outward[side, None]
    if settings.direction == "conventional":  # outward lies on the right of the travel
        corners = corners[:, ::-1]
    feet = Polygons.of(list(corners))
    one, other = near(feet, sweeps)
    strange = flanks.pieces[side[one]] != flanks.pieces[other]
    one, other = one[strange], other[strange]
    hit = meet(feet[one], sweeps[other])
    holds = np.ones(len(side), dtype=bool)
    holds[one[hit]] = False
    return holds


def _require_enough(cuts: FlankCuts, sides: IntArray) -> None:
    flanks = cuts.flanks
    counts = np.bincount(flanks.pieces[sides], minlength=len(flanks.placed))
    few = np.flatnonzero(counts < FEWEST)
    if len(few):
        names = [flanks.placed[piece][0].address for piece in few.tolist()]
        raise MachineError(
            f"Fewer than {FEWEST} bridges of {cuts.settings.tab_length:g} mm would hold "
            f"{listed(names)}: the sides are too short, or their neighbours' contours take the "
            "wood behind. Nest with more spacing, use a thinner cutter or shorter bridges, or "
            "hold='skin', or hold='none' for pieces that are screwed down.",
            addresses=names,
        )
