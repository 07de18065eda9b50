"""Whether a program asks of machine and tools only what they can do.

Every rule gives one fault for each stretch of motions that break it, at its first line.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ifs_cad.fabrication.machining.convention import Convention
from ifs_cad.fabrication.machining.cuts import Cuts
from ifs_cad.fabrication.machining.fault import Fault
from ifs_cad.fabrication.machining.machine import Machine
from ifs_cad.fabrication.machining.motions import Program
from ifs_cad.fabrication.machining.placed import PlacedSheet
from ifs_cad.fabrication.machining.tool import Tool
from ifs_cad.tolerance import Tolerance
from ifs_cad.types import BoolArray, FloatArray

SHARE = 1e-3
"""Share by which a rounded feed may exceed its limit."""


def verify_machine(
    program: Program,
    cuts: Cuts,
    sheet: PlacedSheet,
    tools: dict[int, Tool],
    machine: Machine,
    convention: Convention,
    material: str,
    tol: Tolerance,
) -> list[Fault]:
    """Return what machine and tools cannot do, or must not."""
    if len(cuts) == 0:
        return [Fault(program.last_line, "", "The program moves nothing.")]
    rules = _Rules(program, cuts)
    _tool_rules(rules, tools, machine, material)
    _height_rules(rules, sheet, machine, tol)
    _travel_rules(rules, machine, convention, tol)
    return rules.faults


class _Rules:
    """Collects faults: each rule is a mask of the motions that break it."""

    def __init__(self, program: Program, cuts: Cuts) -> None:
        self.program, self.cuts = program, cuts
        self.faults: list[Fault] = []

    def broken(self, mask: BoolArray, message: Callable[[int], str]) -> None:
        """Add a fault for the first motion of each stretch that breaks a rule."""
        begins = mask & ~np.concatenate([[False], mask[:-1]])
        for motion in np.flatnonzero(begins).tolist():
            line = int(self.cuts.motions.lines[motion])
            self.faults.append(Fault(line, self.program.address_at(line), message(motion)))


def _tool_rules(rules: _Rules, tools: dict[int, Tool], machine: Machine, material: str) -> None:
    """Apply the rules for tools, their lengths, the spindle and the feeds."""
    cuts, motions = rules.cuts, rules.cuts.motions
    known = np.isin(motions.tools, list(tools))
    rules.broken(
        cuts.feeds & ~known,
        lambda k: (
            f"Tool {motions.tools[k]} is not in the magazine."
            if motions.tools[k]
            else "The machine cuts without a tool."
        ),
    )
    rules.broken(
        cuts.feeds & known & (motions.offsets != motions.tools),
        lambda k: (
            f"The length of tool {motions.offsets[k]} is in force while tool {motions.tools[k]} "
            "cuts."
            if motions.offsets[k]
            else "The machine cuts without the length of its tool: G43 is missing."
        ),
    )
    rules.broken(
        cuts.feeds & (motions.speeds <= 0.0),
        lambda k: (
            "The spindle turns backwards (M4)."
            if motions.speeds[k]
            else "The machine cuts while the spindle stands: M3 is missing."
        ),
    )
    low, high = machine.spindle

    def table(name: str) -> FloatArray:
        values = [getattr(tools[number], name) for number in motions.tools[known].tolist()]
        limits = np.full(len(motions), np.inf)
        limits[known] = values
        return limits

    speed = np.minimum(table("speed"), high)
    turning = cuts.feeds & (motions.speeds > 0.0)
    rules.broken(
        turning & ((motions.speeds > speed * (1 + SHARE)) | (motions.speeds < low)),
        lambda k: (
            f"The spindle turns at {motions.speeds[k]:g} a minute: at least {low:g} and at most "
            f"{speed[k]:g} are allowed."
        ),
    )
    feed = np.minimum(table("feed"), machine.feed)
    rises = cuts.along_axis == 1
    feed = np.where(rises, machine.feed, feed)
    with np.errstate(invalid="ignore"):
        fast = cuts.feeds & (motions.feeds > feed * (1 + SHARE))
    rules.broken(
        fast, lambda k: f"The feed of {motions.feeds[k]:g} mm/min exceeds the {feed[k]:g} allowed."
    )
    plunge = table("plunge")
    with np.errstate(invalid="ignore"):
        deep = cuts.feeds & ~fast & (cuts.along_axis == -1) & (motions.feeds > plunge * (1 + SHARE))
    rules.broken(
        deep,
        lambda k: f"The tool plunges at {motions.feeds[k]:g} mm/min: {plunge[k]:g} are allowed.",
    )
    unfit = [number for number, tool in tools.items() if not tool.cuts(material)]
    rules.broken(
        cuts.feeds & np.isin(motions.tools, unfit),
        lambda k: f"{tools[int(motions.tools[k])]} is not for {material}.",
    )


def _height_rules(rules: _Rules, sheet: PlacedSheet, machine: Machine, tol: Tolerance) -> None:
    """Apply the rules for turns of the head, rapid motions, depths and holders."""
    cuts, motions = rules.cuts, rules.cuts.motions
    safe = sheet.thickness + machine.safe_height - tol.machined
    ends = np.fmin(cuts.ends[:, 2], cuts.starts[:, 2])
    between = cuts.lowest_tips
    rules.broken(
        motions.rotates & (np.fmin(ends, between) < safe),
        lambda k: (
            f"The head turns at a height of {ends[k]:.3f} mm, below {safe + tol.machined:g} mm."
            if ends[k] < safe
            else f"The tip swings down to {between[k]:.3f} mm while the head turns, below "
            f"{safe + tol.machined:g} mm: the control does not keep it in place."
        ),
    )
    placed = np.isfinite(np.hstack([motions.ends, motions.starts])).all(axis=1)
    first = np.arange(len(cuts)) <= (int(np.argmax(placed)) if placed.any() else len(cuts))
    # a first motion comes from anywhere, so its height must be safe
    rules.broken(
        first & (cuts.ends[:, 2] < safe),
        lambda k: f"The first motions go down to {cuts.ends[k, 2]:.3f} mm before all is placed.",
    )
    turned = np.isfinite(np.hstack([cuts.start_axes, cuts.end_axes])).all(axis=1)
    rules.broken(
        cuts.feeds & ~turned,
        lambda k: f"The machine cuts before its rotary axes {machine.rotary} are placed.",
    )
    rules.broken(
        ~cuts.feeds & cuts.placed & _in_sheet(cuts, sheet) & _dives(cuts, sheet, tol),
        lambda k: (
            f"A rapid motion comes down to {cuts.lowest[k]:.3f} mm, below the top of the sheet at "
            f"{sheet.thickness:g} mm."
        ),
    )
    rules.broken(
        cuts.placed & (cuts.lowest < -machine.spoilboard_depth - tol.machined),
        lambda k: (
            f"The tool cuts {-cuts.lowest[k]:.3f} mm into the table: "
            f"{machine.spoilboard_depth:g} mm are allowed."
        ),
    )
    lowest_axis = np.minimum(cuts.start_axes[:, 2], cuts.end_axes[:, 2])
    sine = np.sqrt(np.clip(1.0 - lowest_axis**2, 0.0, None))
    depth = (sheet.thickness - np.minimum(cuts.starts[:, 2], cuts.ends[:, 2])) / lowest_axis
    needed = depth + cuts.radii * sine / lowest_axis
    inside = cuts.feeds & cuts.placed & (cuts.lowest < sheet.thickness - tol.machined)
    rules.broken(
        inside & (needed > cuts.flanks + tol.machined),
        lambda k: (
            f"The tool is too short: it cuts over {needed[k]:.2f} mm of its flank and has "
            f"{cuts.flanks[k]:g} mm."
        ),
    )
    holder = np.minimum(cuts.starts[:, 2], cuts.ends[:, 2]) + cuts.reaches * lowest_axis
    holder = holder - cuts.holders / 2.0 * sine
    rules.broken(
        cuts.placed & _in_sheet(cuts, sheet) & (holder < sheet.thickness - tol.machined),
        lambda k: (
            f"The holder comes down to {holder[k]:.2f} mm, below the top of the sheet at "
            f"{sheet.thickness:g} mm."
        ),
    )
    end = cuts.ends[-1, 2]
    last = np.arange(len(cuts)) == len(cuts) - 1
    rules.broken(
        last & (cuts.ends[:, 2] < safe),
        lambda k: f"The program ends with the tool at {end:.3f} mm, below the safe height.",
    )


def _in_sheet(cuts: Cuts, sheet: PlacedSheet) -> BoolArray:
    """Return which motions come over the sheet, holder and all, seen from above."""
    sweeps = cuts.holder_sweeps(np.arange(len(cuts)))
    low, high = sweeps.boxes
    low = np.minimum(low, cuts.starts - cuts.radii[:, None])
    high = np.maximum(high, cuts.starts + cuts.radii[:, None])
    low = np.minimum(low, cuts.ends - cuts.radii[:, None])
    high = np.maximum(high, cuts.ends + cuts.radii[:, None])
    size = np.array([sheet.length, sheet.width])
    return np.asarray((low[:, :2] < size).all(axis=1) & (high[:, :2] > 0.0).all(axis=1))


def _dives(cuts: Cuts, sheet: PlacedSheet, tol: Tolerance) -> BoolArray:
    """Return which motions go below the top of the sheet, but out of or back into their own cut."""
    below = cuts.lowest < sheet.thickness - tol.machined
    below &= cuts.along_axis != 1
    deepest: dict[tuple[int, int, int], float] = {}
    motions = cuts.motions
    for k in np.flatnonzero(cuts.placed & cuts.upright & (cuts.along_axis == -1)).tolist():
        x, y = np.round(cuts.ends[k, :2] / tol.machined).astype(int).tolist()
        place, height = (x, y, int(motions.tools[k])), float(cuts.ends[k, 2])
        if below[k] and height >= deepest.get(place, np.inf):
            below[k] = False
        if cuts.feeds[k]:
            deepest[place] = min(height, deepest.get(place, np.inf))
    return below


def _travel_rules(rules: _Rules, machine: Machine, convention: Convention, tol: Tolerance) -> None:
    """Apply the ranges of the axes."""
    cuts, motions = rules.cuts, rules.cuts.motions
    for letter, (low, high) in zip(convention.words, (machine.tilt, machine.turn), strict=False):
        angles = motions.end_angles[:, "ABC".index(letter)]
        _out_of_range(rules, letter, angles, low, high, tol.machined_angle, "degrees")
    others = [letter for letter in "ABC" if letter not in convention.words]
    foreign = np.isfinite(motions.end_angles[:, ["ABC".index(letter) for letter in others]])
    rules.broken(
        np.asarray(foreign.any(axis=1)),
        lambda k: (
            f"{others[int(np.argmax(foreign[k]))]} is programmed, but the rotary axes are "
            f"{convention.axes}."
        ),
    )
    # the travel is given for an upright tool: a leaning one moves the head aside about the pivot
    upright = np.array([0.0, 0.0, 1.0])
    arms = np.where(np.isnan(cuts.lengths), 0.0, cuts.lengths) + machine.pivot
    lean = np.where(np.isnan(cuts.end_axes), 0.0, cuts.end_axes - upright)
    heads = cuts.ends + arms[:, None] * lean
    for column, letter in enumerate("XYZ"):
        low, high = getattr(machine, letter.lower())
        _out_of_range(rules, letter, heads[:, column], low, high, tol.machined, "mm")


def _out_of_range(
    rules: _Rules,
    letter: str,
    values: FloatArray,
    low: float,
    high: float,
    slack: float,
    unit: str,
) -> None:
    with np.errstate(invalid="ignore"):
        outside = (values < low - slack) | (values > high + slack)
    rules.broken(
        outside,
        lambda k: (
            f"{letter} goes to {values[k]:.3f} {unit}, out of its range from {low:g} to {high:g}."
        ),
    )
