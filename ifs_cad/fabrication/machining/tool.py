"""Tools in their holders.

Source: section 4.3 (the nature of the cutting tools is of the highest importance).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from ifs_cad.errors import InputError
from ifs_cad.fabrication.machining.quantity import choice, require_positive

__all__ = ["Tool", "ToolKind", "require_unique"]

ToolKind = Literal["drill", "engraver", "end mill"]


@dataclass(frozen=True)
class Tool:
    """A tool in its holder.

    Parameters
    ----------
    number : int, its place in the magazine
    name : str
    kind : "drill", "engraver" or "end mill"
    diameter : float, mm
    flank : float, length that cuts, from the tip, mm
    reach : float, from the tip to the holder, mm
    length : float, from the tip to the face of the spindle, mm: the tool length offset
    holder : float, diameter of the holder, mm
    feed, plunge : float, speed across and along the tool, mm/min
    speed : float, of the spindle, revolutions a minute, clockwise seen from above
    pass_depth : float, largest depth of one pass, along the tool, mm
    materials : names of the materials that it is for; none for all
    point : float, angle of the point, degrees; 180 for a flat end

    Raises
    ------
    InputError
        A number that cannot be meant.
    """

    number: int
    name: str
    kind: ToolKind
    diameter: float
    flank: float
    reach: float
    length: float
    holder: float
    feed: float
    plunge: float
    speed: float
    pass_depth: float
    materials: tuple[str, ...] = ()
    point: float = 180.0

    def __post_init__(self) -> None:
        if isinstance(self.number, bool) or self.number < 1:
            raise InputError(f"The number of a tool must be 1 or more, got {self.number}.")
        if self.kind not in get_args(ToolKind):
            raise InputError(
                f"Tool {self.number}: kind must be {choice(ToolKind)}, got {self.kind!r}."
            )
        for name in ("diameter", "flank", "reach", "length", "holder", "feed", "plunge", "speed"):
            require_positive(getattr(self, name), f"Tool {self.number}: {name}")
        require_positive(self.pass_depth, f"Tool {self.number}: pass_depth")
        if not self.flank <= self.reach <= self.length:
            raise InputError(
                f"Tool {self.number}: flank, reach and length must not decrease, got "
                f"{self.flank:g}, {self.reach:g} and {self.length:g} mm."
            )
        if not 0.0 < self.point <= 180.0:
            raise InputError(
                f"Tool {self.number}: point must be above 0 and at most 180 degrees, got "
                f"{self.point:g}."
            )

    @property
    def point_height(self) -> float:
        """How far the point stands out below the full diameter, mm."""
        return self.diameter / 2.0 / math.tan(math.radians(self.point) / 2.0)

    def cuts(self, material: str) -> bool:
        """Tell whether it is for a material."""
        return not self.materials or material in self.materials

    def __str__(self) -> str:
        return f"tool {self.number} ({self.name})"


def require_unique(tools: Sequence[Tool]) -> None:
    """Raise InputError when two tools have one number."""
    numbers = [tool.number for tool in tools]
    twice = sorted({number for number in numbers if numbers.count(number) > 1})
    if twice:
        raise InputError(f"Two tools have the number {twice[0]}: give each its own.")
