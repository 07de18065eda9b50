"""Programs for a machine before any post: where the tip of the tool goes, and how the tool stands.

The frame is that of the sheet: x to the right and y up from its lower left corner, z = 0 on the
face of the spoilboard, z = thickness on top of the sheet.

Terms
-----
tip : the middle of the end of a tool.
axis : the direction of a tool, from its tip to its holder.
cut : what is done to one piece in one go, from above the sheet and back.
step : cuts with one tool; piercing, engraving and contours follow each other.
parked : the head waits aside, at the safe height, its tool upright, while a person acts.

Source: section 4.3, figure 19.
"""

from __future__ import annotations

from collections.abc import Sequence
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

    @property
    def park(self) -> FloatArray:
        """(3,) float, where the tip waits while a person acts, mm."""
        stock = self.sheet.stock
        return np.array([*self.machine.parked(stock.length, stock.width), self.safe])

    @property
    def screwed_after(self) -> int | None:
        """The place of the step after which a person screws the pieces down through their holes.

        None where something else holds them, or nothing is pierced.
        """
        pierced = [place for place, step in enumerate(self.steps) if step.name == "pierce"]
        return pierced[-1] if pierced and self.hold == "none" else None

    @property
    def stops(self) -> int:
        """How often the program waits for a person, changes of tools aside."""
        return int(self.screwed_after is not None)

    def parks_after(self, place: int) -> bool:
        """Tell whether the head is parked after a step: for the screws, a tool, or the sheet."""
        last = place == len(self.steps) - 1
        return last or place == self.screwed_after or self.machine.change_by_hand

    def ways(self, place: int) -> tuple[Cut | Drilling, ...]:
        """Return the cuts of a step, with the ways from and to where the head is parked."""
        cuts = self.steps[place].cuts
        still = Moves.lines(self.park[None], VERTICAL, np.zeros(1))
        if place > 0 and self.parks_after(place - 1):
            cuts = (Cut(cuts[0].address, still, "coming from where the head is parked"), *cuts)
        if self.parks_after(place):
            cuts = (*cuts, Cut(cuts[-1].address, still, "going to where the head is parked"))
        return cuts
