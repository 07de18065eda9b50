"""A strict reader of programs for routers: what is not understood for certain is a fault.

It knows nothing of how programs are written here, only the common dialect of controllers:

- G0 G1 G2 G3 (with I J or R), G81 and G83 with G98 G99, G80; G4 dwells for P seconds;
- G17, G20 G21, G90, G93 G94, G40, G43 or G43.4 with H, G49, G54, G61 G64;
- T with M6, S with M3 M4 M5, F, M7 M8 M9; M0 and M1, where a person has to act, after all else in
  their line; M2 or M30 at the end;
- comments in round brackets or after a semicolon, N words, % before and after, and a line with O
  and the number of the program.

Parameters, expressions, subroutines, relative positions and exponents are faults.

Source: the LinuxCNC G-code reference, for the order in which the words of a line take effect.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

import numpy as np

from ifs_cad.fabrication.machining.fault import Fault
from ifs_cad.fabrication.machining.motions import Kind, Label, Motions, Program, Stop

__all__ = ["read_program"]

_COMMENT = re.compile(r"\(([^()]*)\)")
_WORD = re.compile(r"\s*([A-Z])\s*([-+]?(?:\d+(?:\.\d*)?|\.\d+))")
_STEP = re.compile(r"\s*STEP\s+(\w+)", re.IGNORECASE)
_NAME = re.compile(r"(?:N\s*\d+\s*)?O\s*\d+")
_ADDRESS = re.compile(r"\s*ADDRESS\s+(.*\S)", re.IGNORECASE)

# Codes that exclude each other on a line.
_GROUPS = {
    "motion": ("0", "1", "2", "3", "80", "81", "83"),
    "dwell": ("4",),
    "plane": ("17",),
    "units": ("20", "21"),
    "compensation": ("40",),
    "length": ("43", "43.4", "49"),
    "place": ("54",),
    "path": ("61", "64"),
    "distance": ("90",),
    "arc distance": ("91.1",),
    "feed mode": ("93", "94"),
    "retract": ("98", "99"),
    "spindle": ("M3", "M4", "M5"),
    "change": ("M6",),
    "cooling": ("M7", "M8", "M9"),
    "stop": ("M0", "M1"),
    "end": ("M2", "M30"),
}
_GROUP_OF = {code: group for group, codes in _GROUPS.items() for code in codes}
_MILLIMETRES = {"20": 25.4, "21": 1.0}
_COORDINATES = "XYZABC"
_CYCLES = ("81", "83")
_EXPECTED = {"units": "G21", "distance": "G90", "plane": "G17"}
_DEVIATION = 1e-3  # mm that the path may be rounded by, as little as planes may be off
_PECK_GAP = 0.254  # mm above the last depth where a peck of G83 begins to feed again
_RADIUS_TOLERANCE = 0.002  # mm by which the two radii of an arc may differ by rounding


class _RefusedLineError(Exception):
    """Why a line cannot be followed."""


@dataclass
class _Machine:
    """All that a controller remembers from line to line, and what it has done."""

    position: list[float] = field(default_factory=lambda: [math.nan] * 6)
    mode: str = ""
    scale: float = 1.0
    inverse_time: bool = False
    feed: float = math.nan
    speed: float = 0.0
    turning: int = 0
    selected: int = 0
    tool: int = 0
    offset: int = 0
    keeps_height: bool = False
    ended: bool = False
    dwell: float = 0.0
    cycle: dict[str, float] = field(default_factory=dict)
    said: set[str] = field(default_factory=set)
    notes: list[str] = field(default_factory=list)
    stops: list[Stop] = field(default_factory=list)
    rows: list[tuple[object, ...]] = field(default_factory=list)

    def stop(self, line: int, code: str) -> None:
        """Write down how the machine stands at a stop."""
        x, y, z, *angles = self.position
        a, b, c = angles
        speed = self.turning * self.speed
        self.stops.append(Stop(line, code, (x, y, z), (a, b, c), speed, self.tool, len(self.rows)))

    def record(
        self,
        line: int,
        kind: Kind,
        target: list[float],
        feed: float = math.nan,
        centre: tuple[float, float] = (math.nan, math.nan),
        sweep: float = 0.0,
    ) -> None:
        """Move to a target and write it down, unless nothing moves."""
        before = self.position
        known = [
            after if math.isnan(old) else old for old, after in zip(before, target, strict=True)
        ]
        same = all(
            a == b or (math.isnan(a) and math.isnan(b)) for a, b in zip(before, target, strict=True)
        )
        self.position = list(target)
        if same and kind != Kind.ARC:
            return
        speed = self.turning * self.speed
        self.rows.append(
            (line, kind, known, target, centre, sweep, feed, speed, self.tool, self.offset)
        )


def read_program(text: str) -> Program:
    """Follow a program line by line.

    Parameters
    ----------
    text : str, the whole program

    Returns
    -------
    Program
        Where a line cannot be followed the fault says so, and reading goes on with the next.
    """
    machine, faults, labels = _Machine(), [], []
    step, decimals, number = "", 0, 0
    percents: list[int] = []
    for number, raw in enumerate(text.splitlines(), 1):
        try:
            for comment in _COMMENT.findall(raw):
                if found := _STEP.match(comment):
                    step = found[1].lower()
                    labels.append(Label(number, step, ""))
                elif found := _ADDRESS.match(comment):
                    labels.append(Label(number, step, found[1]))
            code = _COMMENT.sub(" ", raw).partition(";")[0].strip().upper()
            if code == "%":
                percents.append(number)
                continue
            if not code or _NAME.fullmatch(code):
                continue
            if machine.ended:
                raise _RefusedLineError(f"{code!r} stands after the end of the program.")
            words, places = _words(code)
            decimals = max(decimals, places)
            _follow(machine, number, *_sorted_words(words))
        except _RefusedLineError as refusal:
            machine.notes.append(str(refusal))
        address = labels[-1].address if labels else ""
        faults += [Fault(number, address, note) for note in machine.notes]
        machine.notes.clear()
    last = max(number, 1)
    if not machine.ended:
        faults.append(Fault(last, "", "The program does not end: M2 or M30 is missing."))
    resolution = 0.5 * 10.0**-decimals * machine.scale
    motions = _motions(machine.rows)
    stops = tuple(machine.stops)
    return Program(motions, tuple(labels), tuple(faults), last, resolution, stops, machine.dwell)


def _words(code: str) -> tuple[list[tuple[str, str]], int]:
    """Return the words of a line, letter and number, and the most decimals of a position."""
    words, place, decimals = [], 0, 0
    while place < len(code):
        found = _WORD.match(code, place)
        if found is None:
            rest = code[place:].strip()
            if not rest:
                break
            raise _RefusedLineError(f"{rest[:20]!r} is not a word: a letter and a plain number.")
        letter, number = found[1], found[2]
        if letter in "XYZ":
            decimals = max(decimals, len(number.partition(".")[2]))
        words.append((letter, number))
        place = found.end()
    return words, decimals


def _sorted_words(words: list[tuple[str, str]]) -> tuple[dict[str, str], dict[str, float]]:
    """Return the codes of a line by group, and its other values by letter.

    Raises
    ------
    _RefusedLineError
        A code or a letter that is unknown, or given twice.
    """
    codes: dict[str, str] = {}
    values: dict[str, float] = {}
    for letter, number in words:
        if letter in "GM":
            plain = f"{float(number):g}"
            code = plain if letter == "G" else f"M{plain}"
            group = _GROUP_OF.get(code)
            if group is None:
                raise _RefusedLineError(f"{letter}{plain} is not known to this reader.")
            if group in codes:
                raise _RefusedLineError(f"Two codes for {group} in one line.")
            codes[group] = code
        elif letter in "NXYZABCIJRFSTHPQ":
            if letter in values:
                raise _RefusedLineError(f"{letter} stands twice in one line.")
            values[letter] = float(number)
        elif letter == "E":
            raise _RefusedLineError("E: numbers must be written without exponents.")
        else:
            raise _RefusedLineError(f"{letter} is not known to this reader.")
    return codes, values


def _follow(machine: _Machine, line: int, codes: dict[str, str], values: dict[str, float]) -> None:
    """Take over all settings of a line, then move."""
    values.pop("N", None)
    machine.said |= codes.keys()
    for group in ("change", "spindle"):
        code = codes.get(group, "")
        if code and code not in ("M3", "M4"):
            machine.stop(line, code)
    if "units" in codes:
        machine.scale = _MILLIMETRES[codes["units"]]
    if "feed mode" in codes:
        machine.inverse_time = codes["feed mode"] == "93"
        machine.feed = math.nan
    if "F" in values:
        machine.feed = values.pop("F")
        if not machine.inverse_time:
            machine.feed *= machine.scale
    elif machine.inverse_time:
        machine.feed = math.nan
    if "S" in values:
        machine.speed = values.pop("S")
    if "T" in values:
        machine.selected = _whole(values.pop("T"), "T")
    if "change" in codes:
        if machine.selected == 0:
            raise _RefusedLineError("M6 without a tool: T is missing.")
        machine.tool, machine.turning = machine.selected, 0
    if "spindle" in codes:
        machine.turning = {"M3": 1, "M4": -1, "M5": 0}[codes["spindle"]]
        if machine.turning and machine.speed <= 0.0:
            raise _RefusedLineError(f"{codes['spindle']} without a speed: S is missing.")
    if "dwell" in codes:
        if "P" not in values:
            raise _RefusedLineError("G4 without a time: P is missing.")
        seconds = values.pop("P")
        if seconds < 0.0:
            raise _RefusedLineError(f"G4 cannot wait for {seconds:g} seconds.")
        machine.dwell += seconds
    elif codes.get("path") == "64":
        deviation = values.pop("P", math.inf) * machine.scale
        values.pop("Q", None)
        if deviation > _DEVIATION:
            amount = f"{deviation:g} mm" if math.isfinite(deviation) else "any amount"
            machine.notes.append(
                f"G64 lets the path deviate by {amount}: use G61, or a P of {_DEVIATION:g} mm."
            )
    if "length" in codes:
        _measure(machine, codes["length"], values)
    if "retract" in codes:
        machine.keeps_height = codes["retract"] == "98"
    if "motion" in codes:
        if codes["motion"] != machine.mode:
            machine.cycle = {}
        machine.mode = codes["motion"]
    _move(machine, line, values)
    if "stop" in codes:
        machine.stop(line, codes["stop"])
    if values:
        raise _RefusedLineError(f"{', '.join(values)} has no meaning in this line.")
    if "end" in codes:
        machine.ended, machine.turning = True, 0
    if codes.get("units") == "20":
        raise _RefusedLineError("G20 sets inches: programs are in millimetres (G21).")


def _measure(machine: _Machine, code: str, values: dict[str, float]) -> None:
    """Put the length of a tool in force, or none."""
    if code == "49":
        machine.offset = 0
        return
    if "H" in values:
        machine.offset = _whole(values.pop("H"), "H")
    elif code == "43.4":
        raise _RefusedLineError("G43.4 without a tool: H is missing.")
    else:
        machine.offset = machine.tool
    if machine.offset == 0:
        raise _RefusedLineError(f"G{code} has no tool: call one before, or name it with H.")


def _move(machine: _Machine, line: int, values: dict[str, float]) -> None:
    """Follow the positions of a line in the mode in force."""
    given = [letter for letter in _COORDINATES if letter in values]
    if not given:
        return
    if machine.mode in ("", "80"):
        raise _RefusedLineError(f"{given[0]} without a motion: a code such as G0 or G1 is missing.")
    needed = ["units", "distance"]
    if machine.mode in ("2", "3", *_CYCLES):
        needed.append("plane")
    for group in needed:
        if group not in machine.said:
            machine.said.add(group)
            machine.notes.append(
                f"Nothing says which {group} is meant, so it is what the machine was last told: "
                f"{_EXPECTED[group]} is missing."
            )
    target = list(machine.position)
    for letter in given:
        scale = machine.scale if letter in "XYZ" else 1.0
        target[_COORDINATES.index(letter)] = values.pop(letter) * scale
    if machine.mode == "0":
        machine.record(line, Kind.RAPID, target)
        return
    if any(math.isnan(value) for value in machine.position[:3]) and machine.mode not in _CYCLES:
        machine.position = target
        raise _RefusedLineError("The machine cuts before X, Y and Z are placed by rapid motions.")
    if math.isnan(machine.feed) or machine.feed <= 0.0:
        machine.position = target
        raise _RefusedLineError("The machine cuts without a feed: F is missing.")
    if machine.mode in _CYCLES:
        if "Z" in given:
            machine.cycle["Z"] = target[2]
        for letter in ("R", "Q"):
            if letter in values:
                machine.cycle[letter] = values.pop(letter) * machine.scale
        _drill(machine, line, target)
    elif machine.mode == "1":
        length = math.dist(machine.position[:3], target[:3])
        machine.record(line, Kind.FEED, target, _feed(machine, length))
    else:
        centre, sweep = _arc(machine, target, values)
        radius = math.dist(centre, machine.position[:2])
        length = math.hypot(radius * sweep, target[2] - machine.position[2])
        machine.record(line, Kind.ARC, target, _feed(machine, length), centre, sweep)


def _feed(machine: _Machine, length: float) -> float:
    """Return the feed along a path, mm/min."""
    return machine.feed * length if machine.inverse_time else machine.feed


def _drill(machine: _Machine, line: int, target: list[float]) -> None:
    """Bore one hole by a cycle: over it, down to R, down to Z by feed, and up.

    G83 goes down by steps of Q and clears the chips at R after each.
    """
    code, cycle = f"G{machine.mode}", machine.cycle
    needed = "ZRQ" if machine.mode == "83" else "ZR"
    if missing := [letter for letter in needed if letter not in cycle]:
        raise _RefusedLineError(f"{code} without {' and '.join(missing)}.")
    if machine.inverse_time:
        raise _RefusedLineError(f"{code} cannot be done in inverse time (G93).")
    bottom, clear, peck = cycle["Z"], cycle["R"], cycle.get("Q", math.inf)
    before = machine.position[2]
    if math.isnan(before) or any(map(math.isnan, target[:2])):
        raise _RefusedLineError(f"{code} before X, Y and Z are placed.")
    if bottom > clear or peck <= 0.0:
        raise _RefusedLineError(
            f"{code} ends at Z {bottom:g}, begins at R {clear:g}, by steps of {peck:g}."
        )

    x, y = target[:2]

    def go(kind: Kind, height: float) -> None:
        feed = machine.feed if kind == Kind.FEED else math.nan
        machine.record(line, kind, [x, y, height, *target[3:]], feed)

    if before < clear:
        machine.record(line, Kind.RAPID, [*machine.position[:2], clear, *machine.position[3:]])
    over = max(before, clear)
    go(Kind.RAPID, over)
    go(Kind.RAPID, clear)
    depth = clear
    while depth - peck > bottom:
        depth -= peck
        go(Kind.FEED, depth)
        go(Kind.RAPID, clear)
        go(Kind.RAPID, depth + _PECK_GAP)
    go(Kind.FEED, bottom)
    go(Kind.RAPID, over if machine.keeps_height else clear)


def _arc(
    machine: _Machine, target: list[float], values: dict[str, float]
) -> tuple[tuple[float, float], float]:
    """Return the centre and the sweep of an arc in the plane of X and Y."""
    start, end = complex(*machine.position[:2]), complex(*target[:2])
    clockwise = machine.mode == "2"
    if "R" in values:
        radius = values.pop("R") * machine.scale
        chord = end - start
        if chord == 0:
            raise _RefusedLineError("An arc by R cannot end where it begins: give I and J.")
        squared = radius**2 - abs(chord) ** 2 / 4
        if squared < -_RADIUS_TOLERANCE * abs(radius):
            raise _RefusedLineError(
                f"An arc of radius {abs(radius):g} cannot span {abs(chord):g} mm."
            )
        side = -1.0 if clockwise == (radius > 0.0) else 1.0
        centre = (start + end) / 2 + side * 1j * chord / abs(chord) * math.sqrt(max(squared, 0.0))
    elif "I" in values or "J" in values:
        offset = complex(values.pop("I", 0.0), values.pop("J", 0.0)) * machine.scale
        centre = start + offset
        if abs(abs(offset) - abs(end - centre)) > _RADIUS_TOLERANCE:
            raise _RefusedLineError(
                f"The arc has a radius of {abs(offset):.4f} at its start and "
                f"{abs(end - centre):.4f} at its end."
            )
    else:
        raise _RefusedLineError("An arc without I, J or R.")
    if abs(start - centre) == 0.0:
        raise _RefusedLineError("An arc without a radius.")
    turned = (end - centre) / (start - centre)
    sweep = math.atan2(turned.imag, turned.real)
    if clockwise and sweep >= 0.0:
        sweep -= 2 * math.pi
    if not clockwise and sweep <= 0.0:
        sweep += 2 * math.pi
    return (centre.real, centre.imag), sweep


def _whole(value: float, letter: str) -> int:
    if value != int(value) or value < 0:
        raise _RefusedLineError(f"{letter} must be a whole number, got {value:g}.")
    return int(value)


def _motions(rows: list[tuple[object, ...]]) -> Motions:
    """Return the rows of the machine as arrays."""
    columns = list(zip(*rows, strict=True)) if rows else [()] * 10
    lines, kinds, starts, ends, centres, sweeps, feeds, speeds, tools, offsets = columns
    places = [np.array(column, dtype=float).reshape(-1, 6) for column in (starts, ends)]
    return Motions(
        np.array(lines, dtype=np.int64),
        np.array(kinds, dtype=np.int64),
        places[0][:, :3],
        places[1][:, :3],
        places[0][:, 3:],
        places[1][:, 3:],
        np.array(centres, dtype=float).reshape(-1, 2),
        np.array(sweeps, dtype=float),
        np.array(feeds, dtype=float),
        np.array(speeds, dtype=float),
        np.array(tools, dtype=np.int64),
        np.array(offsets, dtype=np.int64),
    )
