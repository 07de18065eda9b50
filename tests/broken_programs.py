"""A small program written by hand for a small sheet, and many ways to break it.

The writer below is for tests only and shares nothing with the one that is sold.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from ifs_cad.elements.arcs import Path
from ifs_cad.elements.material import SPRUCE_PLYWOOD
from ifs_cad.fabrication.layout import NestedSheet, Placement
from ifs_cad.fabrication.machining.machine import Clamp, Machine
from ifs_cad.fabrication.machining.router import read_router
from ifs_cad.fabrication.machining.settings import Settings
from ifs_cad.fabrication.machining.tool import Tool
from ifs_cad.fabrication.stock import Sheet
from ifs_cad.fabrication.workpiece import Drill, Engraving, Side, Workpiece

THICKNESS = 10.0
SAFE = THICKNESS + 45.0
DRILL, ENGRAVER, MILL = 5, 8, 12
SETTINGS = Settings(hold="none")
STOCK = Sheet("spruce", 800.0, 500.0, THICKNESS, SPRUCE_PLYWOOD)
CLAMP = Clamp((0.0, 60.0), (440.0, 500.0), (0.0, 45.0))
PARK = (-150.0, 250.0)


def workpiece(address: str, bottom: np.ndarray, inclinations: list[float]) -> Workpiece:
    """Return a prism whose sides lean outward going up by inclinations, degrees."""
    edges = np.roll(bottom, -1, axis=0) - bottom
    level = np.stack([edges[:, 1], -edges[:, 0]], axis=1) / np.linalg.norm(edges, axis=1)[:, None]
    lean = np.radians(inclinations)
    normals = np.column_stack([level * np.cos(lean)[:, None], -np.sin(lean)])
    shift = THICKNESS * np.tan(lean)
    levels = np.einsum("ki,ki->k", level, bottom)
    top = np.array(
        [
            np.linalg.solve(level[[k - 1, k]], (levels + shift)[[k - 1, k]])
            for k in range(len(bottom))
        ]
    )
    low, high = np.pad(bottom, ((0, 0), (0, 1))), np.pad(top, ((0, 0), (0, 1)))
    high[:, 2] = THICKNESS
    sides = []
    for k in range(len(bottom)):
        after = (k + 1) % len(bottom)
        corners = np.array([low[k], low[after], high[after], high[k]])
        sides.append(Side(corners, normals[k], inclinations[k], "cut", f"{address}-{k}"))
    strokes = (
        Path(np.array([(60.0, 60.0), (80.0, 60.0), (80.0, 70.0)]), np.array([0.0, 0.5])),
        Path(np.array([(90.0, 60.0)]), np.zeros(0)),
        Path(np.array([(100.0, 60.0), (110.0, 70.0)]), np.array([-0.4])),
    )
    return Workpiece(
        address=address,
        thickness=THICKNESS,
        material=SPRUCE_PLYWOOD,
        lower=bottom,
        upper=top,
        silhouette=bottom,
        fibre=None,
        drills=(Drill(np.array([(30.0, 30.0), (150.0, 30.0)]), 8.0, THICKNESS),),
        engraving=Engraving("02", strokes, 0.5, 3.0),
        sides=tuple(sides),
        axes=np.eye(3),
        origin=np.zeros(3),
        volume=1.0,
    )


@cache
def pieces() -> tuple[Workpiece, ...]:
    first = np.array([(0.0, 0.0), (200.0, 10.0), (180.0, 120.0), (10.0, 110.0)])
    second = np.array([(0.0, 0.0), (190.0, 0.0), (200.0, 100.0), (100.0, 130.0), (5.0, 100.0)])
    return (
        workpiece("0211", first, [12.0, -8.5, 0.0, 20.25]),
        workpiece("0212", second, [5.0, 5.0, -15.0, 0.0, 9.75]),
    )


@cache
def sheet() -> NestedSheet:
    placements = (Placement("0211", 0.0, 80.0, 60.0), Placement("0212", 30.0, 400.0, 80.0))
    return NestedSheet(1, STOCK, placements, 0.0, np.zeros((0, 4)))


@cache
def tools() -> tuple[Tool, ...]:
    return read_router().tools


@cache
def machine() -> Machine:
    return replace(read_router().machine, rotary="BC", clamps=(CLAMP,), park=PARK)


class Writer:
    """Collects lines; positions with five decimals."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def __call__(self, line: str) -> None:
        self.lines.append(line)

    def move(self, code: str, point: np.ndarray, rest: str = "") -> None:
        x, y, z = (f"{value + 0.0:.5f}" for value in point)
        self(f"{code} X{x} Y{y} Z{z} {rest}".rstrip())


def angles(axis: np.ndarray) -> tuple[float, float]:
    """Return B and C of LinuxCNC's head for an axis."""
    tilt = np.degrees(np.arctan2(np.hypot(axis[0], axis[1]), axis[2]))
    return tilt, np.degrees(np.arctan2(-axis[1], -axis[0])) if tilt > 0 else 0.0


@cache
def program() -> str:
    """Return a sound program for the sheet."""
    by_number = {tool.number: tool for tool in tools()}
    write = Writer()
    write("%")
    write(f"(SHEET sheet-01 800 x 500 x {THICKNESS:g})")
    write("G21 G17 G90 G94 G40 G49 G80 G54")
    placed = list(zip(pieces(), sheet().placements, strict=True))

    def begin(step: str, number: int) -> Tool:
        tool = by_number[number]
        write(f"(STEP {step} TOOL {number} D{tool.diameter:g})")
        write(f"T{number} M6")
        write(f"S{tool.speed:g} M3")
        write(f"G43 H{number}")
        write(f"G0 Z{SAFE:g}")
        write("G0 B0 C0")
        return tool

    tool = begin("pierce", DRILL)
    for piece, placement in placed:
        write(f"(ADDRESS {piece.address})")
        bottom = -tool.point_height - 0.5
        for x, y in placement(piece.drills[0].points):
            write(f"G81 X{x:.5f} Y{y:.5f} Z{bottom:.5f} R{THICKNESS + 5:g} F{tool.plunge:g}")
        write("G80")
    write(f"G0 Z{SAFE:g}")
    write("M5")
    write(f"G0 X{PARK[0]:g} Y{PARK[1]:g}")
    write("M0")
    tool = begin("engrave", ENGRAVER)
    for piece, placement in placed:
        write(f"(ADDRESS {piece.address})")
        for path in piece.engraving.strokes:
            stroke = Path(placement(path.vertices), path.bulges)
            x, y = stroke.vertices[0]
            write(f"G0 X{x:.5f} Y{y:.5f}")
            write(f"G0 Z{THICKNESS + 5:g}")
            write(f"G1 Z{THICKNESS - 0.5:g} F{tool.plunge:g}")
            for k, bulge in enumerate(stroke.bulges):
                x, y = stroke.ends[k]
                if bulge == 0.0:
                    write(f"G1 X{x:.5f} Y{y:.5f} F{tool.feed:g}")
                else:
                    i, j = stroke.centres[k] - stroke.starts[k]
                    code = "G3" if bulge > 0 else "G2"
                    write(f"{code} X{x:.5f} Y{y:.5f} I{i:.5f} J{j:.5f} F{tool.feed:g}")
            write(f"G0 Z{SAFE:g}")
    tool = begin("contour", MILL)
    for piece, placement in placed:
        write(f"(ADDRESS {piece.address})")
        for side in piece.sides:
            contour(write, side, placement, tool)
    write("G0 B0 C0")
    write("M5")
    write("M30")
    write("%")
    return "\n".join(write.lines) + "\n"


def contour(write: Writer, side: Side, placement: Placement, tool: Tool) -> None:
    """Cut one side in one pass, the workpiece on the right."""

    def turned(vector: np.ndarray) -> np.ndarray:
        return np.append(placement.rotation @ vector[:2], vector[2])

    corners = placement(side.corners)
    normal, travel, axis = turned(side.normal), turned(side.travel), turned(side.axis)
    radius = tool.diameter / 2
    along = (corners - corners[0]) @ travel
    contact = -0.5
    rise = (contact - corners[0, 2]) / axis[2]
    ends = [
        corners[0] + u * travel + rise * axis + radius * normal
        for u in (along.max() + radius, along.min() - radius)
    ]
    tilt, turn = angles(axis)
    above = [end + (SAFE - end[2]) / axis[2] * axis for end in ends]
    near = ends[0] + (THICKNESS + 5 - ends[0][2]) / axis[2] * axis
    write(f"G0 X{above[0][0]:.5f} Y{above[0][1]:.5f}")
    write(f"G0 B{tilt:.6f} C{turn:.6f}")
    write.move("G0", near)
    write.move("G1", ends[0], f"F{tool.plunge:g}")
    write.move("G1", ends[1], f"F{tool.feed:g}")
    write.move("G0", above[1])


@dataclass(frozen=True)
class Broken:
    """A broken program.

    Attributes
    ----------
    name : str
    text : str
    line : int, that must be blamed
    blame : str, a pattern of the message expected there
    machine : what is verified against; the sound one by default
    tools : likewise
    """

    name: str
    text: str
    line: int
    blame: str
    machine: Machine | None = None
    tools: tuple[Tool, ...] | None = None


Edit = Callable[[list[str]], None]


def found(pattern: str, nth: int = 0, after: int = 0) -> int:
    """Return the number from 1 of the nth line that matches, after another."""
    lines = program().splitlines()
    hits = [k for k, line in enumerate(lines, 1) if k > after and re.search(pattern, line)]
    return hits[nth]


def changed(line: int, pattern: str, by: str, count: int = 1) -> str:
    """Return the program with one line changed."""
    lines = program().splitlines()
    new, hits = re.subn(pattern, by, lines[line - 1], count=count)
    assert hits, (pattern, lines[line - 1])
    lines[line - 1] = new
    return "\n".join(lines) + "\n"


def without(*numbers: int) -> str:
    """Return the program with lines emptied, so that the others keep their numbers."""
    lines = program().splitlines()
    for number in numbers:
        lines[number - 1] = ""
    return "\n".join(lines) + "\n"


def moved(line: int, to: int) -> str:
    """Return the program with one line standing before another."""
    lines = program().splitlines()
    taken = lines.pop(line - 1)
    lines.insert(to - 1 - (to > line), taken)
    return "\n".join(lines) + "\n"


def everywhere(pattern: str, by: str, after: int = 0) -> str:
    lines = program().splitlines()
    return (
        "\n".join(
            re.sub(pattern, by, line) if k > after else line for k, line in enumerate(lines, 1)
        )
        + "\n"
    )


def shifted(letter: str, by: float, numbers: Iterator[int] | list[int]) -> str:
    """Return the program with a coordinate moved in some lines."""
    lines = program().splitlines()
    for number in numbers:
        lines[number - 1] = re.sub(
            rf"{letter}([-\d.]+)",
            lambda hit: f"{letter}{float(hit[1]) + by:.5f}",
            lines[number - 1],
        )
    return "\n".join(lines) + "\n"


def broken_programs() -> list[Broken]:
    """Return all of them."""
    total = len(program().splitlines())
    contours = found(r"STEP contour")
    turn = found(r"G0 B\d+\.\d+ C", after=contours)  # first side, 12 degrees
    rapid, plunge, cut, out = turn + 1, turn + 2, turn + 3, turn + 4
    graving = found(r"STEP engrave")
    down = found(r"^G1 Z", after=graving)
    stroke = down + 1
    drilled = found("G81")
    spindle = found(r"S\d+ M3", after=contours)
    cutting = list(range(1, total + 1))
    short = tuple(replace(tool, flank=8.0) if tool.number == MILL else tool for tool in tools())
    stubby = tuple(
        replace(tool, flank=9.0, reach=9.0) if tool.number == MILL else tool for tool in tools()
    )
    narrow = replace(machine(), tilt=(-15.0, 15.0))
    tight = replace(machine(), x=(0.0, 500.0), park=None)
    by_hand = replace(machine(), change_by_hand=True)
    stop = found("^M0")
    parking, standing = stop - 1, stop - 2
    second = found(r"ADDRESS 0212")  # pierced after 0211
    engraved = found("T12")
    wide = replace(machine(), clamps=(Clamp((150.0, 200.0), (40.0, 58.0), (0.0, 30.0)),))
    upright = found(r"G0 B0\.0", after=contours) + 3
    axis = found(r"G0 B20\.25")
    far = found(r"G81", 3)
    flipped = everywhere(r"B(\d+\.\d+)", r"B-\1", contours)
    swapped = everywhere(r"X([-\d.]+) Y([-\d.]+)", r"X\2 Y\1")
    return [
        Broken("wrong sign of B", flipped, cut, r"not cut: the nearest pass is .* degrees off"),
        Broken("one wrong sign of B", changed(turn, "B", "B-"), cut, r"24\.\d+ degrees off"),
        Broken("half the tilt", changed(axis, r"B20\.25", "B10.125"), axis + 3, "nearest pass"),
        Broken("C half a turn off", changed(turn, r"C([-\d.]+)", "C0"), cut, "nearest pass"),
        Broken("swapped axes", swapped, drilled, "no workpiece needs it"),
        Broken("no feed", everywhere(r" F[\d.]+", ""), drilled, "without a feed"),
        Broken("feed of zero", changed(cut, r"F\d+", "F0"), cut, "without a feed"),
        Broken("too fast", changed(cut, r"F\d+", "F20000"), cut, "feed of 20000"),
        Broken("plunge too fast", changed(plunge, r"F\d+", "F4900"), plunge, "plunges at 4900"),
        Broken("spindle off", without(spindle), plunge, "spindle stands"),
        Broken("spindle backwards", changed(spindle, "M3", "M4"), plunge, "backwards"),
        Broken("spindle stopped", changed(turn, "^", "M5 "), plunge, "spindle stands"),
        Broken("spindle too fast", changed(spindle, r"S\d+", "S30000"), plunge, "30000 a minute"),
        Broken(
            "no spindle speed",
            changed(found(r"S\d+ M3"), r"S\d+ ", ""),
            found(r"S\d+ M3"),
            "S is missing",
        ),
        Broken("rapid cut", changed(cut, "G1", "G0"), cut, "rapid motion comes down to"),
        Broken("rapid plunge", changed(plunge, "G1", "G0"), plunge, "rapid motion comes down to"),
        Broken(
            "rapid out sideways",
            changed(out, r"X[-\d.]+ Y[-\d.]+", "X300 Y20"),
            out,
            "rapid motion",
        ),
        Broken("into the table", shifted("Z", -12.0, [plunge, cut]), plunge, "into the table"),
        Broken(
            "not deep enough",
            shifted("Z", 2.0, [upright - 1, upright]),
            upright,
            r"uncut over .* 1\.500 mm above the table",
        ),
        Broken("engraved too shallow", changed(down, "Z9.5", "Z9.8"), stroke, r"0\.2000 mm deep"),
        Broken("engraved too deep", changed(down, "Z9.5", "Z8.5"), stroke, r"into the workpiece"),
        Broken("stroke off its place", shifted("Y", 0.01, [stroke]), stroke, "nearest motion"),
        Broken(
            "stroke left out", without(*range(stroke + 6, stroke + 10)), graving + 6, "not engraved"
        ),
        Broken(
            "arc the other way",
            changed(found("^G2 "), "G2", "G3"),
            found("^G2 "),
            "into the workpiece",
        ),
        Broken("hole left out", without(far), found(r"ADDRESS 0212"), "not drilled"),
        Broken("hole off its place", shifted("X", 0.02, [far]), far, r"0\.0200 mm off"),
        Broken("hole not through", changed(far, r"Z[-\d.]+", "Z1"), far, "deep at its full"),
        Broken("hole in the wrong place", shifted("X", 20.0, [far]), far, "into the workpiece"),
        Broken(
            "drilled with a smaller drill", changed(found("T5"), "T5", "T4"), drilled, "with 6 mm"
        ),
        Broken(
            "contour with a thinner mill",
            changed(found("T12"), "T12", "T11"),
            cut,
            r"nearest pass is 1\.0",
        ),
        Broken("no such tool", changed(found("T12"), "T12", "T77"), plunge, "not in the magazine"),
        Broken(
            "length of another tool",
            changed(found("G43 H12"), "H12", "H8"),
            plunge,
            "length of tool 8",
        ),
        Broken("no tool length", without(found("G43 H12")), plunge, "length of tool 8"),
        Broken("tool too short", program(), plunge, "too short", tools=short),
        Broken("holder too low", program(), plunge, "holder comes down", tools=stubby),
        Broken("edge left out", without(plunge, cut), contours + 6, "not cut"),
        Broken("edge not to its end", changed(cut, r"X[-\d.]+", "X150"), cut, "."),
        Broken("edge out of its plane", shifted("Y", 0.002, [plunge, cut]), cut, "nearest pass"),
        Broken("edge turned", shifted("Y", 0.02, [cut]), cut, "nearest pass"),
        Broken("wrong side", shifted("Y", 11.0, [rapid, plunge, cut]), cut, "into the workpiece"),
        Broken("shifted origin", shifted("X", 5.0, cutting), drilled, "mm off"),
        Broken("inches", changed(found("G21"), "G21", "G20"), found("G21"), "inches"),
        Broken("relative", changed(found("G21"), "G90", "G91"), found("G21"), "G91"),
        Broken("exponent", changed(cut, r"Y[-\d.]+", "Y1e-05"), cut, "exponents"),
        Broken("not a number", changed(cut, r"Y[-\d.]+", "Ynan"), cut, "not a word"),
        Broken("word twice", changed(cut, r"$", " F100"), cut, "F stands twice"),
        Broken("no end", without(found("^M30")), total, "does not end"),
        Broken("head turns in the sheet", changed(cut, "F", "B0 F"), cut, "head turns"),
        Broken("head turns low", changed(turn, "^G0", "G0 Z30"), turn, "head turns"),
        Broken("tilts too far", program(), axis, "out of its range", machine=narrow),
        Broken("goes too far", program(), found(r"X5[0-9][0-9]"), "X goes to", machine=tight),
        Broken("hits a clamp", program(), cut, "hits clamp 1", machine=wide),
        Broken(
            "cut across a neighbour",
            changed(cut, r"X[-\d.]+ Y[-\d.]+", "X470 Y160"),
            cut,
            "0212: The tool cuts",
        ),
        Broken(
            "stop for the screws deleted",
            without(stop),
            cut,
            r"0211: The contour of 0211 \(and of 1 more\) is cut before .*: M0 is missing",
        ),
        Broken(
            "stop for the screws before anything is pierced",
            moved(stop, found("STEP pierce")),
            cut,
            "M0 is missing after the holes",
        ),
        Broken(
            "stop for the screws before all is pierced",
            moved(stop, second),
            second,
            rf"0212: M0 comes before the holes of 0212 are pierced, in line {far + 1}",
        ),
        Broken(
            "stop for the screws after the first outline",
            moved(stop, out + 1),
            cut - 1,
            rf"contour of 0211 is cut before .*: M0 comes only in line {out}",
        ),
        Broken(
            "optional stop for the screws",
            changed(stop, "M0", "M1"),
            cut,
            rf"M1, in line {stop}, stops only where a switch is on",
        ),
        Broken("spindle turns at a stop", without(standing), stop, "M0 while the spindle turns"),
        Broken(
            "spindle started before a stop",
            changed(parking, "^", "M3 "),
            stop,
            "M0 while the spindle turns",
        ),
        Broken("not parked at a stop", without(parking), stop, "M0 with the head at .* not parked"),
        Broken(
            "parked elsewhere at a stop",
            changed(parking, "X-150", "X-140"),
            stop,
            r"head at \(-140\.0, 250\.0\): it is not parked, at \(-150, 250\)",
        ),
        Broken("low at a stop", changed(parking, "$", " Z40"), stop, r"M0 at a height of 40\.000"),
        Broken("tool leans at a stop", changed(parking, "$", " B20"), stop, r"tool leans by 20\.0"),
        Broken("tool changed by hand over the sheet", program(), engraved, "by hand with", by_hand),
        Broken(
            "tool changed by hand while it turns",
            program(),
            engraved,
            "M6 by hand while the spindle turns",
            by_hand,
        ),
        Broken(
            "cut in the waste",
            changed(out, "$", "\nG1 X700 Y450 Z5 F1000\nG0 Z60"),
            out + 1,
            "no workpiece needs it",
        ),
    ]
