"""The machine that holds the tools.

Terms
-----
tilt : the angle of the tool to the vertical, turned by the first letter of `Machine.rotary`.
turn : the angle of the head about the vertical, the second letter.

Source: section 4.3 (the type of machine is of the highest importance).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

from ifs_cad.errors import InputError
from ifs_cad.fabrication.machining.quantity import Span, choice, require_positive, require_span

__all__ = ["Clamp", "Machine", "RotaryAxes"]

RotaryAxes = Literal["AC", "BC", "none"]

BESIDE = 300.0
"""How far beside the sheet, both ways, the head waits when nothing says where, mm: room for a hand
with a screwdriver."""

INSET = 25.0
"""How far it stays from the ends of its travel then, mm: no sheet lies to the millimetre where the
travel is counted from."""


@dataclass(frozen=True)
class Clamp:
    """A box on the table that nothing may touch, in the frame of the sheet.

    Parameters
    ----------
    x, y, z : (float, float), least and largest, mm; x and y from the lower left corner of the
        sheet, z from the face of the spoilboard

    Raises
    ------
    InputError
        A least value that is not below the largest.
    """

    x: Span
    y: Span
    z: Span

    def __post_init__(self) -> None:
        for name in "xyz":
            require_span(getattr(self, name), f"Clamp {name}", "mm")


@dataclass(frozen=True)
class Machine:
    """A router: of five axes with both rotary axes in its head, or of three axes.

    Parameters
    ----------
    name : str
    rotary : "BC" or "AC", the tilting axis and the one about the vertical; "none" for a machine of
        three axes, for which tilt, turn and pivot mean nothing
    x, y, z : (float, float)
        Travel of the axes, mm, as where the tip of the tool stands when it is vertical: x and y
        from the lower left corner of the sheet, z from the face of the spoilboard.
    tilt, turn : (float, float), range of the rotary axes, degrees
    pivot : float, from the crossing of the rotary axes to the face of the spindle, mm
    safe_height : float, of the tip above the sheet where the head may turn, mm
    spoilboard : float, thickness of the spoilboard, mm
    spoilboard_depth : float, how deep it may be cut, mm
    spindle : (float, float), revolutions a minute
    feed : float, largest, mm/min
    rapid : float, speed of rapid moves, mm/min
    rotation : float, speed of the rotary axes, degrees a minute
    tool_change : float, that one takes, seconds
    change_by_hand : bool, whether a person changes the tools, so that the head is parked for it
    park : (float, float) or None
        Where the tip waits while a person acts, at the safe height, mm, counted as x and y are; by
        default beside a corner of the sheet, as far as the travel goes and 300 mm at most.
    clamps : tuple of Clamp

    Raises
    ------
    InputError
        A number that cannot be meant.
    """

    name: str
    rotary: RotaryAxes
    x: Span
    y: Span
    z: Span
    tilt: Span
    turn: Span
    pivot: float
    safe_height: float
    spoilboard: float
    spoilboard_depth: float
    spindle: Span
    feed: float
    rapid: float
    rotation: float
    tool_change: float
    change_by_hand: bool = False
    park: tuple[float, float] | None = None
    clamps: tuple[Clamp, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "clamps", tuple(self.clamps))
        if self.rotary not in get_args(RotaryAxes):
            raise InputError(f"rotary must be {choice(RotaryAxes)}, got {self.rotary!r}.")
        for name, unit in (("x", "mm"), ("y", "mm"), ("z", "mm"), ("tilt", "degrees")):
            require_span(getattr(self, name), name, unit)
        require_span(self.turn, "turn", "degrees")
        require_span(self.spindle, "spindle", "revolutions a minute")
        for name in ("safe_height", "spoilboard", "feed", "rapid", "rotation"):
            require_positive(getattr(self, name), name)
        for name in ("pivot", "spoilboard_depth", "tool_change"):
            if not 0.0 <= getattr(self, name) < math.inf:
                raise InputError(f"{name} must be 0 or more, got {getattr(self, name):g}.")
        if not self.spoilboard_depth <= self.spoilboard:
            raise InputError(
                f"spoilboard_depth {self.spoilboard_depth:g} mm exceeds the spoilboard of "
                f"{self.spoilboard:g} mm."
            )
        for letter, span, place in zip("xy", (self.x, self.y), self.park or (), strict=False):
            if not span[0] <= place <= span[1]:
                raise InputError(
                    f"park must be within the travel; its {letter} is {place:g} mm, and {letter} "
                    f"travels from {span[0]:g} to {span[1]:g} mm."
                )
        if not self.tilt[0] <= 0.0 <= self.tilt[1]:
            raise InputError(f"tilt must have 0 in its range, got {self.tilt}.")
        # with both signs of the tilt, half a turn reaches every direction
        both = -self.tilt[0] == self.tilt[1]
        if self.turn[1] - self.turn[0] < (180.0 if both else 360.0):
            raise InputError(
                f"turn must range over {180 if both else 360} degrees to reach every direction, "
                f"got {self.turn}."
            )

    def parked(self, length: float, width: float) -> tuple[float, float]:
        """Return where the head waits while a person acts, mm.

        Parameters
        ----------
        length, width : float, of the sheet, mm
        """
        if self.park is not None:
            return self.park

        def aside(place: tuple[float, float]) -> float:
            x, y = place
            return math.hypot(max(-x, x - length, 0.0), max(-y, y - width, 0.0))

        across, along = (
            (max(low + INSET, -BESIDE), min(high - INSET, size + BESIDE))
            for (low, high), size in ((self.x, length), (self.y, width))
        )
        return max(((x, y) for x in across for y in along), key=aside)

    @property
    def largest_tilt(self) -> float:
        """Of the tool from the vertical, to either side, degrees."""
        return 0.0 if self.rotary == "none" else max(-self.tilt[0], self.tilt[1])
