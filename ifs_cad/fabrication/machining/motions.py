"""Motions: what a program makes a machine do, one row for each straight line or arc.

Terms
-----
label : a comment of a program that names the workpiece; it names faults and nothing else, since
    what is cut follows from the numbers.
resolution : half a unit of the last decimal that a program writes, mm.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property

import numpy as np

from ifs_cad.fabrication.machining.fault import Fault
from ifs_cad.types import BoolArray, FloatArray, IntArray


class Kind(IntEnum):
    """How the machine moves."""

    RAPID = 0
    FEED = 1
    ARC = 2


@dataclass(frozen=True, eq=False)
class Motions:
    """Everything that moves, in order.

    Attributes
    ----------
    lines : (n,) int, of the program, from 1
    kinds : (n,) int, see `Kind`
    starts, ends : (n, 3) float, positions as programmed, mm; NaN where not yet programmed
    start_angles, end_angles : (n, 3) float, A, B and C, degrees; NaN where not yet programmed
    centres : (n, 2) float, of arcs, mm; NaN for lines
    sweeps : (n,) float, of arcs, radians, positive counter-clockwise; 0 for lines
    feeds : (n,) float, mm/min; NaN for rapid motions
    speeds : (n,) float, of the spindle, turns per minute; 0 when it stands, below 0 backwards
    tools : (n,) int, in the spindle; 0 when none was called
    offsets : (n,) int, the tool whose length is in force; 0 when none is
    """

    lines: IntArray
    kinds: IntArray
    starts: FloatArray
    ends: FloatArray
    start_angles: FloatArray
    end_angles: FloatArray
    centres: FloatArray
    sweeps: FloatArray
    feeds: FloatArray
    speeds: FloatArray
    tools: IntArray
    offsets: IntArray

    def __len__(self) -> int:
        return len(self.lines)

    @cached_property
    def lengths(self) -> FloatArray:
        """(n,) float, of the paths of the programmed point, mm; NaN where the start is unknown."""
        steps = self.ends - self.starts
        radii = np.hypot(*(self.starts[:, :2] - self.centres).T)
        level = np.where(self.kinds == Kind.ARC, radii * self.sweeps, np.hypot(*steps[:, :2].T))
        return np.asarray(np.hypot(level, steps[:, 2]))

    @cached_property
    def rotates(self) -> BoolArray:
        """(n,) bool, whether a rotary axis that was placed before moves."""
        moved = np.abs(self.end_angles - self.start_angles) > 0.0  # never with NaN
        return np.asarray(moved.any(axis=1))


@dataclass(frozen=True)
class Label:
    """What a comment says the lines below it are about.

    Attributes
    ----------
    line : int
    step : str, "pierce", "engrave" or "contour"; empty before the first
    address : str, empty before the first of a step
    """

    line: int
    step: str
    address: str


@dataclass(frozen=True)
class Stop:
    """Where a program waits, stands the spindle or changes the tool.

    Attributes
    ----------
    line : int
    code : str, "M0", "M1", "M5" or "M6"
    position : (float, float, float), X, Y and Z as programmed, mm; NaN where not yet programmed
    angles : (float, float, float), A, B and C, degrees; NaN where not yet programmed
    speed : float, of the spindle when it takes effect, turns per minute, below 0 backwards
    tool : int, in the spindle until then; 0 when none was called
    before : int, how many motions come before it
    """

    line: int
    code: str
    position: tuple[float, float, float]
    angles: tuple[float, float, float]
    speed: float
    tool: int
    before: int

    @property
    def height(self) -> float:
        """Z as programmed, mm; NaN where not yet programmed."""
        return self.position[2]


@dataclass(frozen=True, eq=False)
class Program:
    """A program as it was read.

    Attributes
    ----------
    motions : Motions
    labels : in the order of their lines
    faults : what could not be read, by line
    last_line : int, where it ends
    resolution : float, mm
    stops : in the order of their lines
    dwell : float, how long the program waits by itself, seconds
    """

    motions: Motions
    labels: tuple[Label, ...]
    faults: tuple[Fault, ...]
    last_line: int
    resolution: float
    stops: tuple[Stop, ...] = ()
    dwell: float = 0.0

    @cached_property
    def waits(self) -> tuple[Stop, ...]:
        """The stops at which it waits for a person, in order: M0 and M1."""
        return tuple(stop for stop in self.stops if stop.code in ("M0", "M1"))

    @cached_property
    def changes(self) -> tuple[Stop, ...]:
        """The changes of the tool, in order."""
        return tuple(stop for stop in self.stops if stop.code == "M6")

    @cached_property
    def _label_lines(self) -> list[int]:
        return [label.line for label in self.labels]

    def address_at(self, line: int) -> str:
        """Return the address that the comments above a line name; empty when there is none."""
        place = bisect_right(self._label_lines, line)
        return self.labels[place - 1].address if place else ""

    def line_of(self, step: str, address: str) -> int:
        """Return where the comments begin a workpiece in a step; else where the program ends."""
        found = (
            label.line for label in self.labels if (label.step, label.address) == (step, address)
        )
        return next(found, self.last_line)
