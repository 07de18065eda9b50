"""Programs for a machine before any post: where the tip of the tool goes, and how the tool stands.

The frame is that of the sheet: x to the right and y up from its lower left corner, z = 0 on the
face of the spoilboard, z = thickness on top of the sheet.

Terms
-----
tip : the middle of the end of a tool.
axis : the direction of a tool, from its tip to its holder.
cut : what is done to one piece in one go, from above the sheet and back.
step : cuts with one tool; piercing, engraving and contours follow each other.

Source: section 4.3, figure 19.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np

from ifs_cad.fabrication.layout import NestedSheet
from ifs_cad.fabrication.machining.machine import Machine
from ifs_cad.fabrication.machining.tool import Tool
from ifs_cad.types import BoolArray, FloatArray, frozen
from ifs_cad.vectors import length

StepName = Literal["pierce", "engrave", "contour"]

VERTICAL = frozen(np.array([0.0, 0.0, 1.0]))
"""The axis of a tool that is not tilted."""


@dataclass(frozen=True, eq=False)
class Moves:
    """Moves in order, each from where the one before ended.

    Attributes
    ----------
    tips : (n, 3) float, where each ends, mm
    axes : (n, 3) float, unit vectors of the tool; while it cuts the tool never turns
    feeds : (n,) float, mm/min; 0 for a rapid move
    bulges : (n,) float, tan(sweep / 4) of a level arc, positive counter-clockwise; 0 for a line
    """

    tips: FloatArray
    axes: FloatArray
    feeds: FloatArray
    bulges: FloatArray

    @classmethod
    def lines(cls, tips: FloatArray, axis: FloatArray, feeds: FloatArray) -> Moves:
        """Return straight moves with the tool in one direction."""
        return cls(tips, np.broadcast_to(axis, tips.shape), feeds, np.zeros(len(tips)))

    @classmethod
    def joined(cls, parts: Sequence[Moves]) -> Moves:
        """Return all moves of the parts, in order."""
        if not parts:
            return cls(np.empty((0, 3)), np.empty((0, 3)), np.empty(0), np.empty(0))
        return cls(
            np.concatenate([part.tips for part in parts]),
            np.concatenate([part.axes for part in parts]),
            np.concatenate([part.feeds for part in parts]),
            np.concatenate([part.bulges for part in parts]),
        )

    def __len__(self) -> int:
        return len(self.tips)

    @property
    def is_rapid(self) -> BoolArray:
        """(n,) bool."""
        return np.asarray(self.feeds == 0.0)

    @property
    def lengths(self) -> FloatArray:
        """(n,) float, mm, of the tip's way; 0 for the first, of which the start is not known."""
        chords = length(np.diff(self.tips, axis=0, prepend=self.tips[:1]))
        quarter = np.arctan(np.abs(self.bulges))  # of the sweep; an arc is longer than its chord
        sine = np.where(self.bulges == 0.0, 1.0, np.sin(2.0 * quarter))
        return chords * np.where(self.bulges == 0.0, 1.0, 2.0 * quarter / sine)


@dataclass(frozen=True, eq=False)
class Cut:
    """Moves around one piece; the first is a rapid one to the safe height above its start.

    Attributes
    ----------
    address : str
    moves : Moves
    note : str, what is cut, for comments
    """

    address: str
    moves: Moves
    note: str = ""


@dataclass(frozen=True, eq=False)
class Drilling:
    """Holes of one piece, drilled straight down.

    Attributes
    ----------
    address : str
    points : (n, 2) float, in order, mm
    safe, start, bottom : float, heights of the tip: between holes, where feeding begins, and at the
        bottom, mm
    peck : float, depth after which chips are cleared, mm
    feed : float, mm/min
    note : str
    """

    address: str
    points: FloatArray
    safe: float
    start: float
    bottom: float
    peck: float
    feed: float
    note: str = ""

    @property
    def depths(self) -> FloatArray:
        """(k,) float, heights of the tip at the end of each peck, mm."""
        return np.append(np.arange(self.start - self.peck, self.bottom, -self.peck), self.bottom)

    @cached_property
    def moves(self) -> Moves:
        """The same without a cycle of the control: down, and up to clear the chips."""
        heights = [self.safe]
        for depth in self.depths.tolist():
            heights += [self.start, depth]
        heights.append(self.safe)
        feeds = np.zeros(len(heights))
        feeds[2::2] = self.feed
        feeds[-1] = 0.0
        tips = np.empty((len(self.points), len(heights), 3))
        tips[..., :2] = self.points[:, None]
        tips[..., 2] = heights
        return Moves.lines(tips.reshape(-1, 3), VERTICAL, np.tile(feeds, len(self.points)))


@dataclass(frozen=True, eq=False)
class Step:
    """What is done with one tool.

    Attributes
    ----------
    name : "pierce", "engrave" or "contour"
    tool : Tool
    cuts : in order
    """

    name: StepName
    tool: Tool
    cuts: tuple[Cut | Drilling, ...]

    @cached_property
    def moves(self) -> Moves:
        """All moves of all cuts."""
        return Moves.joined([cut.moves for cut in self.cuts])


@dataclass(frozen=True, eq=False)
class Program:
    """What is done to one sheet: all piercing, then all engraving, then the contours.

    Attributes
    ----------
    sheet : NestedSheet
    machine : Machine
    safe : float, height of the tip where the head may turn, mm
    hold : str, what keeps the pieces in place
    steps : in order
    """

    sheet: NestedSheet
    machine: Machine
    safe: float
    hold: str
    steps: tuple[Step, ...] = field(repr=False)


def machining_time(program: Program, machine: Machine | None = None) -> float:
    """Estimate how long a program takes, in seconds.

    Ways by their feeds, the head's turns and the rapid moves by their speeds, and the tool changes;
    without the time to speed up and slow down.

    Parameters
    ----------
    program : Program
    machine : Machine, optional
        The program's own by default.
    """
    machine = machine or program.machine
    return sum(machine.tool_change + _minutes(step.moves, machine) * 60.0 for step in program.steps)


def machining_summary(times: Mapping[str, float]) -> str:
    """Return the times of programs as text.

    Parameters
    ----------
    times : seconds that each program takes, by the name of its sheet
    """
    listed = ", ".join(f"{name} {hours(seconds)}" for name, seconds in times.items())
    programs = "1 program" if len(times) == 1 else f"{len(times)} programs"
    return f"{programs}, {hours(sum(times.values()))} h of machining: {listed}"


def hours(seconds: float) -> str:
    """Return a time as hours and minutes."""
    whole, minutes = divmod(round(seconds / 60.0), 60)
    return f"{whole}:{minutes:02}"


def _minutes(moves: Moves, machine: Machine) -> float:
    ways = moves.lengths
    speeds = np.where(moves.is_rapid, machine.rapid, moves.feeds)
    return float(np.maximum(ways / speeds, _turns(moves.axes) / machine.rotation).sum())


def _turns(axes: FloatArray) -> FloatArray:
    """Return how far the head turns for each move, the larger of tilt and turn, degrees."""
    level = np.hypot(axes[:, 0], axes[:, 1])
    tilts = np.degrees(np.arctan2(level, axes[:, 2]))
    # while the tool is vertical, the turn stays
    last = np.maximum.accumulate(np.where(level > 0.0, np.arange(len(axes)), 0))
    turns = np.degrees(np.arctan2(axes[last, 1], axes[last, 0]))
    turned = np.abs((np.diff(turns, prepend=turns[:1]) + 180.0) % 360.0 - 180.0)
    return np.asarray(np.maximum(np.abs(np.diff(tilts, prepend=tilts[:1])), turned))
