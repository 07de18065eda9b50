"""Arguments and options that several commands share, and how their words are read."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer


class Schema(StrEnum):
    """The STEP schemas that can be chosen."""

    AP214 = "AP214"
    AP242 = "AP242"


class Side(StrEnum):
    """The two faces of a panel."""

    inner = "inner"
    outer = "outer"


class Hold(StrEnum):
    """What keeps pieces in place while they are cut."""

    tabs = "tabs"
    skin = "skin"
    none = "none"


def read_setting(text: str) -> tuple[str, str]:
    """Read NAME=VALUE."""
    name, equals, value = text.partition("=")
    if not (equals and name.strip()):
        raise typer.BadParameter(f"give a name and a value, as thickness=12, not {text!r}")
    return name.strip(), value


def read_force(text: str) -> tuple[str, float]:
    """Read ADDRESS=NEWTONS."""
    address, equals, size = text.partition("=")
    try:
        return address.strip(), float(size if equals and address.strip() else "none")
    except ValueError:
        raise typer.BadParameter(
            f"give an address and newtons, as 0211=500, not {text!r}"
        ) from None


def read_sweep(text: str) -> tuple[str, str, str]:
    """Read NAME=FROM:TO, two numbers."""
    name, value = read_setting(text)
    begin, _, end = value.partition(":")
    try:
        float(begin), float(end)
    except ValueError:
        raise typer.BadParameter(f"give two numbers, as {name}=0:0.5, not {text!r}") from None
    return name, begin.strip(), end.strip()


Script = Annotated[Path, typer.Argument(help="A part script or design file.", show_default=False)]
Model = Annotated[
    Path, typer.Argument(help="A part script, a design file or a STEP file.", show_default=False)
]
Settings = Annotated[
    list[Any] | None,
    typer.Option(
        "--set",
        parser=read_setting,
        metavar="NAME=VALUE",
        help="Change a parameter of the script. Can be repeated.",
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")]


Colour = Annotated[
    str,
    typer.Option(
        help="material, chamfer, area, length, mass, planarity, sheet, utilisation or deflection."
    ),
]
Explode = Annotated[
    str,
    typer.Option(
        metavar="FACTOR[,FACTOR...]",
        help="Move pieces apart: a factor for each digit of the address, or one for all.",
    ),
]
Azimuth = Annotated[float, typer.Option(help="Degrees about z, from the x axis.")]
Elevation = Annotated[float, typer.Option(help="Degrees above the horizon.")]
Labels = Annotated[bool, typer.Option("--labels", help="Write the addresses on the parts.")]
Edges = Annotated[bool, typer.Option("--edges/--no-edges", help="Draw the edges of faces.")]
Pixels = Annotated[int, typer.Option(help="Pixels.")]
