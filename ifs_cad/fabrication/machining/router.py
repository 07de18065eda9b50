"""A router: the machine, its tools, and the control that its programs are written for.

Common tools, a machine and its control are data, in `tools.toml` beside this file. A user's file of
the same form adds to them:

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
    rotary = "AC"                       # or "BC"; "none" for a machine of three axes
    safe_height = 60
    park = [-300, 1800]                 # where the head waits while a person acts, x and y, mm
    tool_change = 120                   # that one takes, seconds
    change_by_hand = true               # the head is parked for it

    [[machine.clamps]]
    x = [0, 60]
    y = [-40, 25]
    z = [0, 45]

    [post]                              # see `post.Post`; what is left out is as in `like`
    like = "fanuc"                      # or "linuxcnc", "three axes"; the usual one of the axes
    tilt_sign = 1
    decimals = 3
    header = ["%", "O{number:04}"]

    [settings]                          # see `settings.Settings`; what is left out is as there
    direction = "conventional"
    tab_length = 12

Source: section 4.3 (the type of machine and the nature of the cutting tools are of the highest
importance).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

from ifs_cad.errors import InputError
from ifs_cad.fabrication import entries
from ifs_cad.fabrication.machining.machine import Clamp, Machine
from ifs_cad.fabrication.machining.post import LINUXCNC, POSTS, USUAL, Post
from ifs_cad.fabrication.machining.quantity import choice_of
from ifs_cad.fabrication.machining.settings import Settings
from ifs_cad.fabrication.machining.tool import Tool, require_unique

__all__ = ["Router", "read_router"]


@dataclass(frozen=True)
class Router:
    """A machine with its tools and its control.

    Parameters
    ----------
    machine : Machine
    tools : tuple of Tool, numbers unique
    post : Post, for the rotary axes of the machine
    settings : mapping, of `Settings`: those that are not as usual, by name

    Raises
    ------
    InputError
        Two tools of one number, or a post for other axes.
    """

    machine: Machine
    tools: tuple[Tool, ...]
    post: Post = LINUXCNC
    settings: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "tools", tuple(self.tools))
        require_unique(self.tools)
        if self.post.head.axes != self.machine.rotary:
            raise InputError(
                f"The post {self.post.name} is for rotary axes {self.post.head.axes}; "
                f"{self.machine.name} has {self.machine.rotary}. Name another post."
            )


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
    "change_by_hand": entries.flag,
    "park": entries.place,
}
_POST: entries.Readers = {
    "like": entries.text,
    "name": entries.text,
    "tilt_sign": entries.whole,
    "turn_sign": entries.whole,
    "tool_centre_point": entries.flag,
    "tool_offset": entries.text,
    "feed_mode": entries.text,
    "cycles": entries.flag,
    "decimals": entries.whole,
    "angle_decimals": entries.whole,
    "header": entries.texts,
    "footer": entries.texts,
    "remarks": entries.texts,
    "line_numbers": entries.whole,
    "comments": entries.flag,
}
_SETTINGS: entries.Readers = {
    "hold": entries.text,
    "direction": entries.text,
    "contour_tool": entries.whole,
    **dict.fromkeys(
        ["tab_length", "tab_height", "tab_spacing", "tab_landing", "skin", "breakthrough"],
        entries.number,
    ),
    **dict.fromkeys(
        ["drill_breakthrough", "lead", "clearance", "pass_depth", "stroke_depth"], entries.number
    ),
}
_TABLES = ("extend", "tools", "machine", "post", "settings")


def read_router(path: str | Path | None = None) -> Router:
    """Read the library of tools with its machine, and a user's file that adds to them.

    Parameters
    ----------
    path : str or Path
        A TOML file of the form shown in this module; None for the library alone.

    Returns
    -------
    Router
        Tools by their numbers.

    Raises
    ------
    InputError
        The file cannot be read, is not TOML, or has an entry that cannot be meant; the message
        names the file, the entry and the key.
    """
    library = entries.parsed(
        files("ifs_cad.fabrication.machining").joinpath("tools.toml"), "tools.toml"
    )
    sources = [("tools.toml", library)]
    if path is not None:
        sources.append((str(path), entries.parsed(Path(path), str(path))))
    tools: dict[int, Tool] = {}
    machine: dict[str, Any] = {}
    post: Post | None = None
    settings: dict[str, Any] = {}
    for name, tables in sources:
        entries.values(tables, dict.fromkeys(_TABLES, _any) | {"extend": entries.flag}, name)
        if not tables.get("extend", True):
            tools.clear()
        tools |= _tools(tables.get("tools", []), name)
        machine |= _machine(tables.get("machine", {}), name)
        made: Machine = entries.made(Machine, machine, f"{name}: [machine]")
        if "post" in tables:
            post = _post(tables["post"], made, f"{name}: [post]")
        where = f"{name}: [settings]"
        settings |= entries.values(tables.get("settings", {}), _SETTINGS, where)
        entries.made(Settings, settings, where)  # refuses what cannot be meant, here
    magazine = tuple(tools[number] for number in sorted(tools))
    return Router(made, magazine, post or USUAL[made.rotary], settings)


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


def _post(table: Any, machine: Machine, where: str) -> Post:
    """Return the post that a file describes."""
    given = entries.values(table, _POST, where)
    name = given.pop("like", None)
    if name is not None and name not in POSTS:
        raise InputError(f"{where}: like must be {choice_of(POSTS)}, got {name!r}.")
    post = USUAL[machine.rotary] if name is None else POSTS[name]
    signs = {key: given.pop(key) for key in ("tilt_sign", "turn_sign") if key in given}
    try:
        return replace(post, head=replace(post.head, **signs), **given)
    except InputError as error:
        raise InputError(f"{where}: {error}") from error


def _any(value: Any) -> Any:
    return value
