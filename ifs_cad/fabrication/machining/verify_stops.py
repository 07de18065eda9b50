"""Whether a program waits for a person where one has to act, and only where that is safe.

Pieces that nothing but screws holds are screwed down through their holes while the program waits:
after the last hole of a piece, before the first cut of its contour. A person reaches under the
spindle then: it stands, its tool upright and high, the head aside. The same holds for changes of
the tool by hand. M1 stops only where a switch of the control is on, so it does for nobody's safety.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ifs_cad.fabrication.machining.convention import Convention
from ifs_cad.fabrication.machining.cuts import Cuts
from ifs_cad.fabrication.machining.fault import Fault
from ifs_cad.fabrication.machining.machine import Machine
from ifs_cad.fabrication.machining.motions import Program, Stop
from ifs_cad.fabrication.machining.placed import PlacedSheet
from ifs_cad.fabrication.machining.settings import Settings
from ifs_cad.fabrication.machining.tool import Tool
from ifs_cad.tolerance import Tolerance
from ifs_cad.types import BoolArray, FloatArray

ASIDE = 1.0
"""How near to its place a head counts as parked, mm."""


@dataclass(frozen=True, eq=False)
class _Unscrewed:
    """A workpiece whose contour is begun before anyone could screw it down.

    Attributes
    ----------
    contour : int, the motion that begins it
    pierced : int, the motion that makes its last hole; -1 where none is made
    piece : int, index of the workpiece
    """

    contour: int
    pierced: int
    piece: int


def verify_stops(
    program: Program,
    sheet: PlacedSheet,
    tools: dict[int, Tool],
    machine: Machine,
    convention: Convention,
    tol: Tolerance,
) -> list[Fault]:
    """Return where spindle or tool change in the sheet, or a person has to act near the tool."""
    safe = sheet.thickness + machine.safe_height
    faults = []
    for stop in program.stops:
        by_hand = stop.code == "M6" and machine.change_by_hand
        person = by_hand or stop.code in ("M0", "M1")
        least = safe if person else sheet.thickness
        said = []
        if stop.height < least - tol.machined:
            said.append(f"at a height of {stop.height:.3f} mm, below {least:g} mm")
        if person:
            said += _in_the_way(stop, sheet, tools, machine, convention, tol)
        what = f"{stop.code} by hand" if by_hand else stop.code
        address = program.address_at(stop.line)
        faults += [Fault(stop.line, address, f"{what} {how}.") for how in said]
    return faults


def _in_the_way(
    stop: Stop,
    sheet: PlacedSheet,
    tools: dict[int, Tool],
    machine: Machine,
    convention: Convention,
    tol: Tolerance,
) -> list[str]:
    """Return in what way the head endangers a person who acts at a stop."""
    said = []
    if stop.speed:
        said.append("while the spindle turns: M5 is missing before it")
    axis = convention.axis(np.array(stop.angles))
    if np.hypot(axis[0], axis[1]) > tol.parallel:  # never where the angles are not yet known
        said.append(f"while the tool leans by {np.degrees(np.arccos(axis[2])):.3f} degrees")
    tool = tools.get(stop.tool)
    length = np.array(tool.length if tool else 0.0)
    tip = convention.tips(np.array(stop.position), np.nan_to_num(axis), length)
    if np.isfinite(tip[:2]).all() and not _aside(tip, tool, sheet, machine):
        x, y = machine.parked(sheet.length, sheet.width)
        said.append(
            f"with the head at ({tip[0]:.1f}, {tip[1]:.1f}): it is not parked, at ({x:g}, {y:g})"
        )
    return said


def _aside(tip: FloatArray, tool: Tool | None, sheet: PlacedSheet, machine: Machine) -> bool:
    """Tell whether the head is parked; anywhere beside the sheet, where no place is named."""
    place = np.array(machine.parked(sheet.length, sheet.width))
    if np.abs(tip[:2] - place).max() <= ASIDE:
        return True
    beyond = np.maximum(-tip[:2], tip[:2] - np.array([sheet.length, sheet.width]))
    away = float(np.hypot(*np.maximum(beyond, 0.0)))
    return machine.park is None and away > (tool.holder / 2.0 if tool else 0.0)


def verify_screwing(
    program: Program,
    cuts: Cuts,
    sheet: PlacedSheet,
    settings: Settings,
    pierces: BoolArray,
    contours: BoolArray,
) -> list[Fault]:
    """Return where pieces are cut out that nobody could screw down before.

    Parameters
    ----------
    pierces, contours : (n, p) bool, which motions make holes and sides of which workpieces
    """
    if settings.hold != "none":
        return []
    waits = np.array([stop.before for stop in program.waits if stop.code == "M0"], dtype=np.int64)
    loose = []
    for piece in np.unique(sheet.holes.owners).tolist():
        around = np.flatnonzero(contours[:, piece])
        bored = np.flatnonzero(pierces[:, piece] & cuts.feeds)
        if len(around) == 0:
            continue  # not cut out at all
        pierced = int(bored[-1]) if len(bored) else -1
        # a stop comes between two motions: after as many as it counts
        if not ((waits > pierced) & (waits <= around[0])).any():
            loose.append(_Unscrewed(int(around[0]), pierced, piece))
    if not loose:
        return []
    first = min(loose, key=lambda one: one.contour)
    begun = int(np.argmax((pierces & cuts.feeds[:, None]).any(axis=1)))
    return [_unscrewed(program, cuts, sheet, first, len(loose) - 1, begun)]


def _unscrewed(
    program: Program, cuts: Cuts, sheet: PlacedSheet, first: _Unscrewed, others: int, begun: int
) -> Fault:
    """Return the fault of pieces that come loose, at the stop that is misplaced or the cut.

    Parameters
    ----------
    first : the piece that comes loose before all others
    others : int, how many come loose after it
    begun : int, the motion that pierces the first hole of all; a stop before it is for the sheet
    """
    address = sheet.addresses[first.piece]
    contour = int(cuts.motions.lines[first.contour])
    pierced = int(cuts.motions.lines[first.pierced]) if first.pierced >= 0 else 0
    also = f" (and of {others} more)" if others else ""
    loose = f"The contour of {address}{also} is cut before it is screwed down through its holes"
    stops = [stop for stop in program.waits if stop.code == "M0"]
    early = [stop.line for stop in stops if begun < stop.before <= first.pierced]
    late = [stop.line for stop in stops if stop.before > first.contour]
    optional = [stop for stop in program.waits if first.pierced < stop.before <= first.contour]
    if early:
        message = (
            f"M0 comes before the holes of {address} are pierced, in line {pierced}, so that "
            f"nobody can screw it down before its contour is cut, in line {contour}."
        )
        return Fault(early[-1], address, message)
    if late:
        message = f"{loose}: M0 comes only in line {late[0]}."
    elif optional:
        line = optional[-1].line
        message = f"{loose}: M1, in line {line}, stops only where a switch is on; use M0."
    else:
        message = f"{loose}: M0 is missing after the holes."
    return Fault(contour, address, message)
