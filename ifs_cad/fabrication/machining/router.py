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
from ifs_cad.fabrication.machining.machine import Clamp, Machine
from ifs_cad.fabrication.machining.post import LINUXCNC, POSTS, USUAL, Post
from ifs_cad.fabrication.machining.settings import Settings
from ifs_cad.fabrication.machining.tool import Tool, require_unique
from ifs_cad.toml import readers
from ifs_cad.toml.table import Table, read_table

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


_SPAN = readers.list_of(readers.number, "two numbers, the least and the largest", 2)
_PLACE = readers.list_of(readers.number, "two numbers, x and y", 2)
_TEXTS = readers.list_of(readers.text, "a list of texts in quotes")
_TOOL: readers.Readers = {
    "number": readers.whole,
    "name": readers.text,
    "kind": readers.text,
    "materials": _TEXTS,
    **dict.fromkeys(
        ["diameter", "flank", "reach", "length", "holder", "feed", "plunge", "speed", "pass_depth"],
        readers.number,
    ),
    "point": readers.number,
}
_CLAMP: readers.Readers = dict.fromkeys("xyz", _SPAN)
_MACHINE: readers.Readers = {
    "name": readers.text,
    "rotary": readers.text,
    **dict.fromkeys(["x", "y", "z", "tilt", "turn", "spindle"], _SPAN),
    **dict.fromkeys(["pivot", "safe_height", "spoilboard", "spoilboard_depth"], readers.number),
    **dict.fromkeys(["feed", "rapid", "rotation", "tool_change"], readers.number),
    "change_by_hand": readers.flag,
    "park": _PLACE,
}
_POST: readers.Readers = {
    "like": readers.one_of(*POSTS),
    "name": readers.text,
    "tilt_sign": readers.whole,
    "turn_sign": readers.whole,
    "tool_centre_point": readers.flag,
    "tool_offset": readers.text,
    "feed_mode": readers.text,
    "cycles": readers.flag,
    "decimals": readers.whole,
    "angle_decimals": readers.whole,
    "header": _TEXTS,
    "footer": _TEXTS,
    "remarks": _TEXTS,
    "line_numbers": readers.whole,
    "comments": readers.flag,
}
_SETTINGS: readers.Readers = {
    "hold": readers.text,
    "direction": readers.text,
    "contour_tool": readers.whole,
    **dict.fromkeys(
        ["tab_length", "tab_height", "tab_spacing", "tab_landing", "skin", "breakthrough"],
        readers.number,
    ),
    **dict.fromkeys(
        ["drill_breakthrough", "lead", "clearance", "pass_depth", "stroke_depth"], readers.number
    ),
}
_TABLES = ("tools", "machine", "post", "settings")


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
        names the file, the line, the entry and the key.
    """
    library = files("ifs_cad.fabrication.machining").joinpath("tools.toml")
    sources = [read_table(library, "tools.toml")]
    if path is not None:
        sources.append(read_table(Path(path), str(path)))
    tools: dict[int, Tool] = {}
    machine: dict[str, Any] = {}
    post: Post | None = None
    settings: dict[str, Any] = {}
    for file in sources:
        given = file.values({"extend": readers.flag}, _TABLES)
        if not given.get("extend", True):
            tools.clear()
        tools |= _tools(file)
        table = file.table("machine")
        machine |= _machine(table)
        made = table.made(Machine, machine)
        if "post" in file:
            post = _post(file.table("post"), made)
        table = file.table("settings")
        settings |= table.values(_SETTINGS)
        table.made(Settings, settings)  # refuses what cannot be meant, here
    magazine = tuple(tools[number] for number in sorted(tools))
    with sources[-1].table("post").refusals():
        return Router(made, magazine, post or USUAL[made.rotary], settings)


def _tools(file: Table) -> dict[int, Tool]:
    """Return the tools of one file by their numbers."""
    tools: dict[int, Tool] = {}
    places: dict[int, Table] = {}
    for table in file.rows("tools"):
        tool = table.made(Tool, table.values(_TOOL))
        first = places.setdefault(tool.number, table)
        if first is not table:
            raise table.taken("number", first)
        tools[tool.number] = tool
    return tools


def _machine(table: Table) -> dict[str, Any]:
    """Return what one file says of the machine."""
    given = table.values(_MACHINE, ("clamps",))
    if "clamps" in table:
        given["clamps"] = tuple(row.made(Clamp, row.values(_CLAMP)) for row in table.rows("clamps"))
    return given


def _post(table: Table, machine: Machine) -> Post:
    """Return the post that a file describes."""
    given = table.values(_POST)
    name = given.pop("like", None)
    post = USUAL[machine.rotary] if name is None else POSTS[name]
    signs = {key: given.pop(key) for key in ("tilt_sign", "turn_sign") if key in given}
    with table.refusals():
        return replace(post, head=replace(post.head, **signs), **given)
