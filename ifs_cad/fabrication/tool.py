"""Tools and the machine that holds them.

Common tools and a machine are data, in `tools.toml` beside this file. A user's file of the same
form adds to them:

    extend = true                       # false leaves the tools of the library out

    [[tools]]
    number = 21                         # its place in the magazine; replaces the library's tool 21
    name = "end mill 10"
    kind = "end mill"                   # or "drill", "engraver"
    diameter = 10                       # mm
    flank = 45                          # length that cuts, mm
    reach = 65                          # from the tip to the holder, mm
    length = 145                        # from the tip to the face of the spindle, mm
    holder = 50                         # diameter of the holder, mm
    feed = 4000                         # mm/min
    plunge = 1200                       # mm/min
    speed = 18000                       # of the spindle, revolutions a minute
    pass_depth = 12                     # largest depth of one pass, along the tool, mm
    materials = ["spruce plywood"]      # may be left out: for all
    point = 118                         # angle of the point, degrees; may be left out: 180, flat

    [machine]                           # what is left out is as in the library
    safe_height = 60

    [[machine.clamps]]
    x = [0, 60]
    y = [-40, 25]
    z = [0, 45]

Terms
-----
tilt : the angle of the tool to the vertical, turned by the first letter of `Machine.rotary`.
turn : the angle of the head about the vertical, the second letter.

Source: section 4.3 (the type of machine and the nature of the cutting tools are of the highest
importance).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal, get_args

from ifs_cad.errors import InputError
from ifs_cad.fabrication import entries

__all__ = ["Clamp", "Machine", "Tool", "Workshop", "read_tools"]

ToolKind = Literal["drill", "engraver", "end mill"]
RotaryAxes = Literal["AC", "BC"]
Span = tuple[float, float]
"""The least and the largest value."""


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
                f"Tool {self.number}: kind must be {_choice(ToolKind)}, got {self.kind!r}."
            )
        for name in ("diameter", "flank", "reach", "length", "holder", "feed", "plunge", "speed"):
            _require_positive(getattr(self, name), f"Tool {self.number}: {name}")
        _require_positive(self.pass_depth, f"Tool {self.number}: pass_depth")
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
            _require_span(getattr(self, name), f"Clamp {name}", "mm")


@dataclass(frozen=True)
class Machine:
    """A five-axis router with both rotary axes in its head.

    Parameters
    ----------
    name : str
    rotary : "BC" or "AC", the tilting axis and the one about the vertical
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
    tool_change : float, seconds
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
    clamps: tuple[Clamp, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "clamps", tuple(self.clamps))
        if self.rotary not in get_args(RotaryAxes):
            raise InputError(f"rotary must be {_choice(RotaryAxes)}, got {self.rotary!r}.")
        for name, unit in (("x", "mm"), ("y", "mm"), ("z", "mm"), ("tilt", "degrees")):
            _require_span(getattr(self, name), name, unit)
        _require_span(self.turn, "turn", "degrees")
        _require_span(self.spindle, "spindle", "revolutions a minute")
        for name in ("safe_height", "spoilboard", "feed", "rapid", "rotation"):
            _require_positive(getattr(self, name), name)
        for name in ("pivot", "spoilboard_depth", "tool_change"):
            if not 0.0 <= getattr(self, name) < math.inf:
                raise InputError(f"{name} must be 0 or more, got {getattr(self, name):g}.")
        if not self.spoilboard_depth <= self.spoilboard:
            raise InputError(
                f"spoilboard_depth {self.spoilboard_depth:g} mm exceeds the spoilboard of "
                f"{self.spoilboard:g} mm."
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

    @property
    def largest_tilt(self) -> float:
        """Of the tool from the vertical, to either side, degrees."""
        return max(-self.tilt[0], self.tilt[1])


@dataclass(frozen=True)
class Workshop:
    """A machine with its tools.

    Parameters
    ----------
    machine : Machine
    tools : tuple of Tool, numbers unique

    Raises
    ------
    InputError
        Two tools of one number.
    """

    machine: Machine
    tools: tuple[Tool, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "tools", tuple(self.tools))
        require_unique(self.tools)


def require_unique(tools: Sequence[Tool]) -> None:
    """Raise InputError when two tools have one number."""
    numbers = [tool.number for tool in tools]
    twice = sorted({number for number in numbers if numbers.count(number) > 1})
    if twice:
        raise InputError(f"Two tools have the number {twice[0]}: give each its own.")


def _choice(kind: Any) -> str:
    names = [repr(name) for name in get_args(kind)]
    return f"{', '.join(names[:-1])} or {names[-1]}"


def _require_positive(value: float, what: str) -> None:
    if not 0.0 < value < math.inf:
        raise InputError(f"{what} must be positive, got {value:g}.")


def _require_span(value: Span, what: str, unit: str) -> None:
    if not -math.inf < value[0] < value[1] < math.inf:
        raise InputError(f"{what} must rise from least to largest {unit}, got {value}.")


_TOOL: entries.Readers = {
    "number": entries.whole,
    "name": entries.text,
    "kind": entries.text,
    "materials": entries.texts,
    **dict.fromkeys(
        ["diameter", "flank", "reach", "length", "holder", "feed", "plunge", "speed", "pass_depth"],
        entries.number,
    ),
    "point": entries.number,
}
_CLAMP: entries.Readers = dict.fromkeys("xyz", entries.span)
_MACHINE: entries.Readers = {
    "name": entries.text,
    "rotary": entries.text,
    **dict.fromkeys(["x", "y", "z", "tilt", "turn", "spindle"], entries.span),
    **dict.fromkeys(["pivot", "safe_height", "spoilboard", "spoilboard_depth"], entries.number),
    **dict.fromkeys(["feed", "rapid", "rotation", "tool_change"], entries.number),
}


def read_tools(path: str | Path | None = None) -> Workshop:
    """Read the library of tools and its machine, and a user's file that adds to them.

    Parameters
    ----------
    path : str or Path
        A TOML file of the form shown in this module; None for the library alone.

    Returns
    -------
    Workshop
        Tools by their numbers.

    Raises
    ------
    InputError
        The file cannot be read, is not TOML, or has an entry that cannot be meant; the message
        names the file, the entry and the key.
    """
    library = entries.parsed(files("ifs_cad.fabrication").joinpath("tools.toml"), "tools.toml")
    sources = [("tools.toml", library)]
    if path is not None:
        sources.append((str(path), entries.parsed(Path(path), str(path))))
    tools: dict[int, Tool] = {}
    machine: dict[str, Any] = {}
    for name, tables in sources:
        entries.values(tables, {"extend": _flag, "tools": _any, "machine": _any}, name)
        if not tables.get("extend", True):
            tools.clear()
        tools |= _tools(tables.get("tools", []), name)
        machine |= _machine(tables.get("machine", {}), name)
        made = entries.made(Machine, machine, f"{name}: [machine]")
    return Workshop(made, tuple(tools[number] for number in sorted(tools)))


def _tools(rows: Any, name: str) -> dict[int, Tool]:
    """Return the tools of one file by their numbers."""
    tools: dict[int, Tool] = {}
    for where, row in entries.tables(rows, f"{name}: [[tools]]"):
        tool = entries.made(Tool, entries.values(row, _TOOL, where), where)
        if tool.number in tools:
            raise InputError(
                f"{where}: the number {tool.number} is taken by {tools[tool.number].name!r}. Give "
                "one of them another number."
            )
        tools[tool.number] = tool
    return tools


def _machine(table: Any, name: str) -> dict[str, Any]:
    """Return what one file says of the machine."""
    where = f"{name}: [machine]"
    given = entries.values(table, {**_MACHINE, "clamps": _any}, where)
    if "clamps" in given:
        given["clamps"] = tuple(
            entries.made(Clamp, entries.values(row, _CLAMP, place), place)
            for place, row in entries.tables(given["clamps"], f"{name}: [[machine.clamps]]")
        )
    return given


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise TypeError("true or false")
    return value


def _any(value: Any) -> Any:
    return value
