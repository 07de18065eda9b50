"""Contours: the moves of a cutter's flank along each side of a piece.

For each side, at one orientation of the tool: above the start at the safe height, down to the
clearance, then for each pass down along the tool, along the side, up along the tool and back above
the sheet; after the last pass up to the safe height, where the head may turn to the next side. A
bridge is left by drawing the tool back along its axis, so that the plane stays the same.

Source: section 4.3, figure 19 (contour cut).
"""

from __future__ import annotations

import math

import numpy as np

from ifs_cad.errors import MachineError
from ifs_cad.fabrication.machining.flank import FlankCuts
from ifs_cad.fabrication.machining.machine import Machine
from ifs_cad.fabrication.machining.motion import Cut, Moves
from ifs_cad.fabrication.machining.tabs import tab_places
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import FloatArray


def contours(cuts: FlankCuts, machine: Machine, safe: float) -> list[list[Cut]]:
    """Return the cuts of each workpiece on a sheet, side by side along the direction of travel.

    Parameters
    ----------
    cuts : FlankCuts
    machine : Machine
    safe : float, height of the tip where the head may turn, mm

    Raises
    ------
    MachineError
        Deeper into the spoilboard than allowed, or too few bridges.
    """
    _require_spoilboard(cuts, machine)
    flanks = cuts.flanks
    tabs = tab_places(cuts) if cuts.settings.hold == "tabs" else [np.empty(0)] * len(flanks)
    order = range(len(flanks))
    angles = flanks.inclinations.tolist()
    found: list[list[Cut]] = [[] for _ in flanks.placed]
    for side in reversed(order) if cuts.settings.direction == "climb" else order:
        moves = _moves(cuts, side, tabs[side].tolist(), safe)
        edge = flanks.side(side)
        note = f"EDGE {flanks.sides[side] + 1} {edge.kind} {angles[side]:.3f} DEG"
        if edge.neighbour:
            note += f" TO {edge.neighbour}"
        found[flanks.pieces[side]].append(Cut(flanks.address(side), moves, note))
    return found


def _moves(cuts: FlankCuts, side: int, tabs: list[float], safe: float) -> Moves:
    """Return the moves along one side, as ways along the travel and lifts along the tool."""
    settings, tool, flanks = cuts.settings, cuts.tool, cuts.flanks
    rise = float(flanks.axes[side, 2])
    start, stop = float(flanks.starts[side]) - cuts.lead, float(flanks.stops[side]) + cuts.lead
    depth, lowest = float(cuts.depths[side]), float(cuts.lowest[side])
    clear = depth + settings.clearance / rise
    above = (safe - float(cuts.bases[side, 2])) / rise
    half = settings.tab_length / 2.0 + cuts.radius

    rows = [(start, above, 0.0)]
    passes = passes_of(depth, settings.pass_depth or tool.pass_depth)
    for number in range(1, passes + 1):
        lift = depth * (passes - number) / passes
        rows += [(start, clear, 0.0), (start, lift, tool.plunge)]
        over = (settings.tab_height - lowest) / rise  # the lift that clears a bridge
        if over > lift:
            for middle in tabs:
                rows += [
                    (middle - half, lift, tool.feed),
                    (middle - half, over, tool.feed),
                    (middle + half, over, tool.feed),
                    (middle + half, lift, tool.plunge),
                ]
        rows += [(stop, lift, tool.feed), (stop, clear if number < passes else above, 0.0)]
    along, lifts, feeds = np.array(rows).T
    return Moves.lines(cuts.tips(side, along, lifts), flanks.axes[side], feeds)


def passes_of(depth: float, largest: float, tol: Tolerance = DEFAULT) -> int:
    """Return how many passes of a largest depth a depth takes."""
    return max(1, math.ceil(depth / largest - tol.planar))


def _require_spoilboard(cuts: FlankCuts, machine: Machine) -> None:
    depths: FloatArray = -cuts.lowest
    worst = int(np.argmax(depths))
    if depths[worst] > machine.spoilboard_depth:
        raise MachineError(
            f"Cutting the {cuts.flanks.name(worst)}, {cuts.flanks.inclinations[worst]:.2f} "
            f"degrees, with {cuts.tool} reaches {depths[worst]:.2f} mm below the sheet; the "
            f"spoilboard may be cut {machine.spoilboard_depth:g} mm deep. Use a thinner cutter, "
            "less breakthrough or a thicker spoilboard.",
            addresses=[cuts.flanks.address(worst)],
            depth=float(depths[worst]),
        )
