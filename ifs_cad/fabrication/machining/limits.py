"""What a machine can reach, and what stands in its way.

Travel is checked where the axes stand, not the tip: a tilted tool of length L below the crossing of
the rotary axes puts them L (axis - vertical) away from its tip.

Source: section 4.3 (the type of machine and the nature of the cutting tools).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ifs_cad.errors import MachineError
from ifs_cad.fabrication.machining.machine import Clamp, Machine
from ifs_cad.fabrication.machining.motion import VERTICAL, Cut, Drilling, Moves, Program, Step
from ifs_cad.fabrication.machining.tool import Tool
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import FloatArray
from ifs_cad.vectors import length

GRAIN = 4.0
"""Distance of the points by which tools are compared with clamps, mm."""


def axis_positions(tips: FloatArray, axes: FloatArray, arm: float) -> FloatArray:
    """Return where the axes of a machine stand, (n, 3), as the tip of the same tool when vertical.

    Parameters
    ----------
    tips, axes : (n, 3) float, mm and unit vectors
    arm : float, from the crossing of the rotary axes to the tip, mm
    """
    return np.asarray(tips + arm * (axes - VERTICAL))


def require_within(program: Program, tol: Tolerance = DEFAULT) -> None:
    """Check a program against its machine.

    Raises
    ------
    MachineError
        Travel, speed or feed beyond the machine's, or a clamp in the way; names the address.
    """
    for place, step in enumerate(program.steps):
        _require_speeds(step.tool, program.machine)
        _require_travel(step, program.machine, tol)
        for clamp in program.machine.clamps:
            _require_clear(step.tool, program.ways(place), clamp)


def _require_speeds(tool: Tool, machine: Machine) -> None:
    least, most = machine.spindle
    if not least <= tool.speed <= most:
        raise MachineError(
            f"{str(tool).capitalize()} turns at {tool.speed:g} 1/min; the spindle of "
            f"{machine.name} at {least:g} to {most:g}."
        )
    if max(tool.feed, tool.plunge) > machine.feed:
        raise MachineError(
            f"{str(tool).capitalize()} feeds at {max(tool.feed, tool.plunge):g} mm/min; "
            f"{machine.name} at {machine.feed:g} at most."
        )


def _require_travel(step: Step, machine: Machine, tol: Tolerance) -> None:
    arm = machine.pivot + step.tool.length
    low, high = np.array([machine.x, machine.y, machine.z]).T
    for cut in step.cuts:
        stands = axis_positions(cut.moves.tips, cut.moves.axes, arm)
        beyond = np.maximum(low - stands, stands - high)
        row, axis = np.unravel_index(np.argmax(beyond), beyond.shape)
        if beyond[row, axis] > tol.planar:
            where = f" ({cut.note})" if cut.note else ""
            raise MachineError(
                f"{cut.address}{where} would take the {'XYZ'[axis]} axis to "
                f"{stands[row, axis]:.1f} mm; it travels from {low[axis]:g} to {high[axis]:g} mm.",
                addresses=[cut.address],
                position=float(stands[row, axis]),
            )


def _require_clear(tool: Tool, cuts: Sequence[Cut | Drilling], clamp: Clamp) -> None:
    """Raise MachineError where the tool or its holder comes within GRAIN of a clamp."""
    low, high = np.array([clamp.x, clamp.y, clamp.z]).T
    reach = np.arange(0.0, tool.length + GRAIN, GRAIN)
    radii = np.where(reach < tool.reach, tool.diameter, tool.holder) / 2.0
    last: Moves | None = None
    for cut in cuts:
        moves = cut.moves if last is None else Moves.joined([last, cut.moves])
        tips, axes = _points_between(moves)
        points = tips[:, None] + reach[:, None] * axes[:, None]
        gaps = length(np.maximum(np.maximum(low - points, points - high), 0.0)) - radii
        if gaps.min() < GRAIN:
            x, y, z = points[np.unravel_index(np.argmin(gaps), gaps.shape)]
            raise MachineError(
                f"{cut.address} {cut.note}: {tool} or its holder comes within {GRAIN:g} mm of the "
                f"clamp at x {clamp.x[0]:g} to {clamp.x[1]:g}, y {clamp.y[0]:g} to {clamp.y[1]:g}, "
                f"near ({x:.0f}, {y:.0f}, {z:.0f}). Move the clamp, raise the safe height or park "
                "the head elsewhere.",
                addresses=[cut.address],
            )
        last = Moves(*(part[-1:] for part in (moves.tips, moves.axes, moves.feeds, moves.bulges)))


def _points_between(moves: Moves) -> tuple[FloatArray, FloatArray]:
    """Return tips and axes all along the moves, GRAIN apart; arcs by their chords."""
    counts = np.maximum(np.ceil(moves.lengths / GRAIN), 1.0).astype(np.int64)
    move = np.repeat(np.arange(len(moves)), counts)
    share = (np.arange(len(move)) - (np.cumsum(counts) - counts)[move] + 1.0) / counts[move]
    before = np.maximum(move - 1, 0)
    tips = moves.tips[before] + share[:, None] * (moves.tips[move] - moves.tips[before])
    axes = moves.axes[before] + share[:, None] * (moves.axes[move] - moves.axes[before])
    return tips, axes / length(axes)[:, None]
