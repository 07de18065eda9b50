"""Verification: whether a program, followed exactly, leaves the workpieces that were designed.

It knows nothing of how programs are written here: it reads the program as a controller does, with
LinuxCNC's own interpreter as a second reader where it is installed, and compares what the tools
leave with the geometry of the workpieces. Comments name what a fault is about; they prove nothing.

What is looked at: planes of the contour, holes and strokes; that every one is made and nothing else
is cut; cutters and holders against workpieces, sheet, table and clamps; heights of rapid motions
and of turns of the head; ranges of all axes; spindle, feeds, tools and their lengths; the order;
stops for a person, and where the head is meanwhile.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ifs_cad.errors import InputError
from ifs_cad.fabrication.layout import NestedSheet
from ifs_cad.fabrication.machining.convention import LINUXCNC, Convention
from ifs_cad.fabrication.machining.cuts import Cuts, cuts_of
from ifs_cad.fabrication.machining.fault import Fault
from ifs_cad.fabrication.machining.job import Job, find_job, read_job
from ifs_cad.fabrication.machining.linuxcnc import differences, interpreter, replayed
from ifs_cad.fabrication.machining.machine import Machine
from ifs_cad.fabrication.machining.motions import Program
from ifs_cad.fabrication.machining.placed import PlacedSheet, placed_sheet
from ifs_cad.fabrication.machining.program_reader import read_program
from ifs_cad.fabrication.machining.settings import Settings
from ifs_cad.fabrication.machining.simulate import BESIDE
from ifs_cad.fabrication.machining.simulate import simulate as simulated
from ifs_cad.fabrication.machining.tool import Tool
from ifs_cad.fabrication.machining.verification import Verification
from ifs_cad.fabrication.machining.verify_clearance import verify_clearance
from ifs_cad.fabrication.machining.verify_holes import verify_holes
from ifs_cad.fabrication.machining.verify_machine import verify_machine
from ifs_cad.fabrication.machining.verify_sides import verify_sides
from ifs_cad.fabrication.machining.verify_stops import verify_screwing, verify_stops
from ifs_cad.fabrication.machining.verify_strokes import verify_strokes
from ifs_cad.fabrication.workpiece import Workpiece
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import BoolArray

__all__ = ["verify", "verify_file"]

ROUNDINGS = 4.0
"""How many halves of the last decimal may add up in one comparison: two ends, two coordinates."""

COARSEST = 2e-3
"""That programs of three decimals may be off, mm; fewer decimals are faults."""

_SHEET = re.compile(r"\(\s*SHEET\s+(\S+)", re.IGNORECASE)

_FOREIGN = re.compile(r"^[^(;]*(?:G43\.4|\bO\d)", re.MULTILINE)
"""Words that LinuxCNC does not know: tool-centre-point control by code, and program numbers."""


def verify(
    text: str,
    sheet: NestedSheet,
    workpieces: Iterable[Workpiece],
    tools: Sequence[Tool],
    machine: Machine,
    *,
    settings: Settings | None = None,
    convention: Convention = LINUXCNC,
    linuxcnc: bool | None = None,
    simulate: bool = True,
    tol: Tolerance = DEFAULT,
) -> Verification:
    """Compare a program with what it should make.

    Parameters
    ----------
    text : str, the whole program
    sheet : what lies where on it
    workpieces : at least all that are placed on the sheet
    tools : that the machine holds
    machine : Machine
    settings : Settings, what may hold the workpieces and how deep drawn strokes are; by default
        nothing is said of these, so the defaults of `Settings` hold
    convention : how the controller reads rotary angles and positions
    linuxcnc : bool, whether LinuxCNC's interpreter must accept the program and move alike; by
        default where it is installed and the program is in its dialect
    simulate : bool, whether to take from the sheet all that the cutters pass over, point by point,
        as a second look at gouges and at what is left, and for the volume that is removed
    tol : Tolerance

    Raises
    ------
    AddressError
        A placement whose workpiece is not given.
    InputError
        Rotary axes that the machine does not have.
    MissingLibraryError
        LinuxCNC is asked for but not installed.
    """
    if convention.axes != machine.rotary:
        raise InputError(
            f"The convention is for rotary axes {convention.axes}, the machine has "
            f"{machine.rotary}: give a convention that fits it."
        )
    settings = settings or Settings()
    magazine = {tool.number: tool for tool in tools}
    placed = placed_sheet(
        sheet, {piece.address: piece for piece in workpieces}, settings.stroke_depth
    )
    program = read_program(text)
    # a program cannot be truer than its last decimal, nor may it be much coarser
    rounded = min(ROUNDINGS * program.resolution, COARSEST)
    tol = replace(tol, machined=max(tol.machined, rounded))
    cuts = cuts_of(program.motions, tools, convention, tol)
    second, reader = _second_reading(text, program, magazine, linuxcnc)

    holes = verify_holes(program, cuts, placed, magazine, tol)
    strokes = verify_strokes(program, cuts, placed, magazine, tol)
    sides = verify_sides(program, cuts, placed, magazine, settings, tol)
    inside = holes.makes | strokes.makes
    removed, gouges = (
        _simulated(program, cuts, placed, inside, settings) if simulate else (math.nan, [])
    )
    faults = [
        *program.faults,
        *second,
        *gouges,
        *verify_machine(
            program, cuts, placed, magazine, machine, convention, sheet.stock.material.name, tol
        ),
        *verify_stops(program, placed, magazine, machine, convention, tol),
        *verify_screwing(program, cuts, placed, settings, holes.makes, sides.makes),
        *holes.faults,
        *strokes.faults,
        *sides.faults,
        *verify_clearance(program, cuts, placed, machine, inside, tol),
        *_late(cuts, placed, inside, sides.makes),
        *_without_purpose(program, cuts, placed, inside | sides.makes, tol),
    ]
    return Verification(
        name=sheet.name,
        faults=tuple(sorted(set(faults))),
        holes=len(placed.holes.owners),
        strokes=len(placed.strokes.owners),
        sides=len(placed.sides.owners),
        plane_error=sides.measured["plane"],
        angle_error=sides.measured["angle"],
        hole_error=holes.measured.get("hole", 0.0),
        stroke_error=strokes.measured.get("stroke", 0.0),
        spoilboard_depth=float(-np.nanmin(cuts.lowest, initial=0.0)),
        minutes=_minutes(program, cuts, machine),
        tool_changes=len(program.changes),
        stops=len(program.waits),
        removed=removed,
        interpreter=reader,
    )


def verify_file(
    program: str | os.PathLike[str],
    job: Job | str | os.PathLike[str] | None = None,
    *,
    linuxcnc: bool | None = None,
    simulate: bool = True,
    tol: Tolerance = DEFAULT,
) -> Verification:
    """Verify a program in a file.

    Parameters
    ----------
    program : path of the program; it is for the sheet that its comment `(SHEET name ...)` names, or
        else its own name
    job : what to verify it against, or its path; by default `job.json` in the program's folder or
        the one above
    linuxcnc, simulate : see `verify`
    tol : Tolerance

    Raises
    ------
    InputError
        A file that cannot be read, or a job that does not hold the sheet.
    """
    source = Path(program)
    try:
        text = source.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise InputError(f"{source} cannot be read: {error.strerror or error}.") from error
    against = job if isinstance(job, Job) else read_job(find_job(source) if job is None else job)
    named = _SHEET.search(text)
    return verify(
        text,
        against.sheet(named[1] if named else source.stem),
        against.workpieces,
        against.tools,
        against.machine,
        settings=against.settings,
        convention=against.convention,
        linuxcnc=linuxcnc,
        simulate=simulate,
        tol=tol,
    )


def _second_reading(
    text: str,
    program: Program,
    tools: dict[int, Tool],
    wanted: bool | None,
) -> tuple[tuple[Fault, ...], str]:
    """Return what LinuxCNC refuses or does otherwise, and who has read the program."""
    installed = interpreter() is not None
    foreign = _FOREIGN.search(text) is not None
    if not ((installed and not foreign) if wanted is None else wanted):
        return (), "our own reader"
    lines, places, refused = replayed(
        text, {number: tool.diameter for number, tool in tools.items()}
    )
    # where one of the two stops early there is nothing to compare
    apart = () if refused or program.faults else differences(program.motions, lines, places)
    return (*refused, *apart), "rs274 and our own reader"


def _simulated(
    program: Program, cuts: Cuts, sheet: PlacedSheet, inside: BoolArray, settings: Settings
) -> tuple[float, list[Fault]]:
    """Return the volume removed, mm3, and the workpieces of which too much or too little is."""
    simulation = simulated(cuts, sheet, inside, _held(cuts, settings))
    faults = []
    for volumes, what in (
        (simulation.gouged, "of the workpiece are cut away"),
        (simulation.left, "beside the workpiece are left uncut"),
    ):
        for piece in np.flatnonzero(volumes).tolist():
            address = sheet.addresses[piece]
            message = f"By simulation, {volumes[piece]:.0f} mm3 {what}."
            faults.append(Fault(program.line_of("contour", address), address, message))
    return simulation.removed, faults


def _held(cuts: Cuts, settings: Settings) -> float:
    """Return the height of what may hold the workpieces, mm.

    The end of a leaning cutter is higher on one side than on the other.
    """
    feeding = cuts.steady & cuts.feeds
    level = np.hypot(*cuts.start_axes[feeding, :2].T)
    if settings.hold == "none":
        return float((level / cuts.start_axes[feeding, 2]).max(initial=0.0)) * BESIDE
    height = settings.tab_height if settings.hold == "tabs" else settings.skin
    return height + float((level * cuts.diameters[feeding]).max(initial=0.0))


def _late(cuts: Cuts, sheet: PlacedSheet, inside: BoolArray, around: BoolArray) -> list[Fault]:
    """Return the faults of holes and strokes made after the contour: the piece is loose by then."""
    faults = []
    for piece, address in enumerate(sheet.addresses):
        contour = np.flatnonzero(around[:, piece])
        inner = np.flatnonzero(inside[:, piece] & cuts.feeds)
        late = inner[inner > contour[0]] if len(contour) else inner[:0]
        if len(late):
            message = "A hole or a stroke is made after the contour was begun."
            faults.append(Fault(int(cuts.motions.lines[late[0]]), address, message))
    return faults


def _without_purpose(
    program: Program, cuts: Cuts, sheet: PlacedSheet, makes: BoolArray, tol: Tolerance
) -> list[Fault]:
    """Return the faults of cuts into the sheet that make no part of any workpiece.

    A cut goes from where the tool enters the sheet to where it leaves it, leads and all.
    """
    top = sheet.thickness - tol.machined
    begins = cuts.placed & cuts.feeds & (cuts.lowest < top) & (cuts.lowest_at_start >= top)
    numbers = np.cumsum(begins)
    useful = np.zeros(len(cuts) + 1, dtype=bool)
    useful[numbers[makes.any(axis=1)]] = True
    faults = []
    for motion in np.flatnonzero(begins & ~useful[numbers]).tolist():
        line = int(cuts.motions.lines[motion])
        message = "The tool cuts into the sheet where no workpiece needs it."
        faults.append(Fault(line, program.address_at(line), message))
    return faults


def _minutes(program: Program, cuts: Cuts, machine: Machine) -> float:
    """Return how long the program takes, without speeding up, slowing down and stops."""
    motions = cuts.motions
    ways = np.nan_to_num(motions.lengths)
    speeds = np.where(cuts.feeds, motions.feeds, machine.rapid)
    turned = np.abs(motions.end_angles - motions.start_angles)
    turns = np.nan_to_num(turned).max(axis=1, initial=0.0) / machine.rotation
    still = program.dwell + len(program.changes) * machine.tool_change
    return float(np.maximum(ways / speeds, turns).sum()) + still / 60.0
