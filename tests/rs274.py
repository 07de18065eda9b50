"""LinuxCNC's stand-alone interpreter as a judge of programs, and what it understood of them.

`rs274` prints the canonical commands that it would send to a machine. From these alone the flank
planes, holes and strokes are worked out again.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

needs_rs274 = pytest.mark.skipif(
    shutil.which("rs274") is None, reason="rs274 of LinuxCNC is not installed"
)

COMMAND = re.compile(r"N\S* +(\w+)\((.*)\)\s*$")


@dataclass
class Motion:
    """One canonical move: where it ends, how the head stands there, and what the comments say."""

    kind: str  # "rapid", "feed", "arc"
    start: np.ndarray
    end: np.ndarray
    head: np.ndarray  # A, B, C
    feed: float
    spindle: bool
    tool: int
    step: str
    address: str
    note: str
    arc: tuple[float, float, int] | None = None  # centre and turns


@dataclass
class Wait:
    """Where a person acts: a stop of the program, or a change of the tool."""

    name: str  # "PROGRAM_STOP", "CHANGE_TOOL"
    place: np.ndarray
    head: np.ndarray  # A, B, C
    spindle: bool
    step: str


@dataclass
class Outcome:
    accepted: bool
    errors: str
    motions: list[Motion] = field(default_factory=list)
    waits: list[Wait] = field(default_factory=list)
    ended: bool = False


def run(text: str, tools, folder: Path) -> Outcome:
    """Interpret a program; the tool table is in inches."""
    (folder / "program.ngc").write_text(text, encoding="ascii")
    table = [
        f"T{tool.number} P{tool.number} Z{tool.length / 25.4:.9f} D{tool.diameter / 25.4:.9f}"
        for tool in tools
    ]
    (folder / "tool.tbl").write_text("\n".join(table) + "\n")
    (folder / "scratch.var").write_text("")
    done = subprocess.run(
        ["rs274", "-g", "-n", "2", "-t", "tool.tbl", "-v", "scratch.var", "program.ngc"],
        cwd=folder,
        env=os.environ | {"HOME": str(folder)},  # it keeps its tools in ~/.tool.mmap
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=60,
    )
    outcome = Outcome(done.returncode == 0, done.stderr)
    _read(done.stdout, outcome)
    return outcome


def _read(output: str, outcome: Outcome) -> None:
    here, head, feed = np.full(3, np.nan), np.zeros(3), 0.0
    spindle, tool = False, 0
    step = address = note = ""
    for line in output.splitlines():
        match = COMMAND.search(line)
        if not match:
            continue
        name, words = match.groups()
        if name in ("PROGRAM_STOP", "CHANGE_TOOL"):
            outcome.waits.append(Wait(name, here, head, spindle, step))
        if name == "COMMENT":
            word = words.strip('"')
            if word.startswith("STEP "):
                step, address, note = word.split()[1], "", ""
            elif word.startswith("ADDRESS "):
                address, note = word.removeprefix("ADDRESS "), ""
            elif not word.startswith("interpreter"):
                note = word
        elif name == "SET_FEED_RATE":
            feed = float(words)
        elif name in ("START_SPINDLE_CLOCKWISE", "STOP_SPINDLE_TURNING"):
            spindle = name.startswith("START")
        elif name == "CHANGE_TOOL":
            tool = int(words)
        elif name == "PROGRAM_END":
            outcome.ended = True
        elif name in ("STRAIGHT_TRAVERSE", "STRAIGHT_FEED", "ARC_FEED"):
            values = [float(word) for word in words.split(",")]
            arc = None
            if name == "ARC_FEED":
                x, y, *centre, turns, z, a, b, c = values
                arc = (*centre, int(turns))
                values = [x, y, z, a, b, c]
            end, head = np.array(values[:3]), np.array(values[3:])
            kind = {"STRAIGHT_TRAVERSE": "rapid", "STRAIGHT_FEED": "feed", "ARC_FEED": "arc"}[name]
            outcome.motions.append(
                Motion(kind, here, end, head, feed, spindle, tool, step, address, note, arc)
            )
            here = end


def axis_of(head: np.ndarray) -> np.ndarray:
    """Return the tool of LinuxCNC's BC head, as found on running joints."""
    b, c = np.radians(head[1:])
    return np.array([-np.sin(b) * np.cos(c), -np.sin(b) * np.sin(c), np.cos(b)])
