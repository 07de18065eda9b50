"""The commands that show models: render, animate, show, studio."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from ifs_cad.cli.options import (
    Azimuth,
    Colour,
    Edges,
    Elevation,
    Explode,
    Labels,
    Model,
    Pixels,
    Quiet,
    Script,
    Settings,
    read_sweep,
)


def render(
    model: Model,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="The picture, a PNG.", show_default=False)
    ],
    settings: Settings = None,
    azimuth: Azimuth = -60.0,
    elevation: Elevation = 25.0,
    zoom: Annotated[float, typer.Option(help="1 fills the frame, more crops.")] = 1.0,
    width: Pixels = 1600,
    height: Pixels = 1000,
    background: Annotated[str, typer.Option(help="A colour's name, or #rrggbb.")] = "white",
    edges: Edges = True,
    labels: Labels = False,
    colour: Colour = "material",
    explode: Explode = "0",
    quiet: Quiet = False,
) -> None:
    """Draw a model as a PNG; no screen is needed."""
    options = {
        "azimuth": azimuth,
        "elevation": elevation,
        "zoom": zoom,
        "width": width,
        "height": height,
        "background": background,
        "edges": edges,
        "labels": labels,
        "colour": colour,
        "explode": _explode(explode),
    }
    arguments = {"source": str(model), "settings": dict(settings or ()), "options": options}
    _draw("render", arguments, output, quiet)


def animate(
    script: Script,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="A .gif or an .mp4.", show_default=False)
    ],
    sweep: Annotated[
        Any,
        typer.Option(
            parser=read_sweep,
            metavar="NAME=FROM:TO",
            help="The parameter of the script that changes.",
        ),
    ],
    frames: Annotated[
        int | None,
        typer.Option(
            help="How many values, evenly; without it whole numbers go one by one.",
            show_default="24",
        ),
    ] = None,
    seconds: Annotated[float, typer.Option(help="How long it runs.")] = 4.0,
    back: Annotated[bool, typer.Option("--back", help="Run back to the beginning.")] = False,
    settings: Settings = None,
    azimuth: Azimuth = -60.0,
    elevation: Elevation = 25.0,
    width: Pixels = 800,
    height: Pixels = 500,
    edges: Edges = True,
    labels: Labels = False,
    colour: Colour = "material",
    explode: Explode = "0",
    quiet: Quiet = False,
) -> None:
    """Draw a part script as a GIF or MP4 while one of its parameters changes.

    Whole numbers, as depth=1:5, go one by one: the steps of the iteration. Write roughness=0:1.0,
    or give --frames, for values between.
    """
    options = {
        "seconds": seconds,
        "there_and_back": back,
        "azimuth": azimuth,
        "elevation": elevation,
        "width": width,
        "height": height,
        "edges": edges,
        "labels": labels,
        "colour": colour,
        "explode": _explode(explode),
    }
    name, begin, end = sweep
    arguments = {
        "source": str(script),
        "settings": dict(settings or ()),
        "sweep": [name, _values(begin, end, frames)],
        "options": options,
    }
    _draw("animate", arguments, output, quiet)


def _draw(job: str, arguments: dict[str, Any], output: Path, quiet: bool) -> None:
    """Do a job that makes one file, beside its target."""
    from ifs_cad.workflow.display import display
    from ifs_cad.workflow.staging import install, staging
    from ifs_cad.workflow.supervise import run

    with display(quiet) as listener, staging(output) as stage:
        made = stage / output.name
        run(job, {**arguments, "path": str(made)}, listener)
        install(made, output)
    if not quiet:
        typer.echo(f"Wrote {output}")


def _explode(text: str) -> float | list[float]:
    """Read one factor for all digits, or a factor for each."""
    try:
        factors = [float(part) for part in text.removesuffix(",").split(",")]
    except ValueError:
        raise typer.BadParameter(
            f"--explode takes numbers with commas between, not {text!r}."
        ) from None
    return factors if "," in text else factors[0]


def _values(begin: str, end: str, frames: int | None) -> list[str]:
    """Return the values of a sweep as text; whole numbers one by one where no count is given."""
    low, high = float(begin), float(end)
    if frames is None:
        is_whole = all(text.lstrip("+-").isdecimal() for text in (begin, end))
        frames = int(abs(high - low)) + 1 if is_whole else 24
    steps = max(frames - 1, 1)
    return [f"{low + (high - low) * step / steps:.9g}" for step in range(frames)]


def show(
    model: Model,
    settings: Settings = None,
    watch: Annotated[
        bool, typer.Option("--watch", "-w", help="Show it again whenever it is saved.")
    ] = False,
    colour: Colour = "material",
    explode: Explode = "0",
    exact: Annotated[
        bool, typer.Option("--exact", help="Send the solids as they are cut; slow.")
    ] = False,
    port: Annotated[
        int | None, typer.Option(help="Where the viewer listens.", show_default="3939")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Send a model to a running OCP viewer."""
    from ifs_cad.workflow.display import display, plain
    from ifs_cad.workflow.supervise import run

    chosen = dict(settings or ())
    options = {"colour": colour, "explode": _explode(explode), "exact": exact}
    if watch:
        from ifs_cad.workflow.watch import watch as watch_script

        watch_script(
            model,
            settings=chosen,
            port=port,
            options=options,
            listener=plain(quiet),
            report=lambda text: None if quiet else typer.echo(text),
            complain=lambda text: typer.echo(text, err=True),
        )
        return
    with display(quiet) as listener:
        arguments = {"source": str(model), "settings": chosen, "port": port, "options": options}
        run("show", arguments, listener)
    if not quiet:
        typer.echo(f"Shown: {model}")


def studio(
    design: Annotated[
        Path | None, typer.Argument(help="A design file; new if it does not exist.")
    ] = None,
    port: Annotated[
        int | None, typer.Option(help="Where the page is served.", show_default="any free one")
    ] = None,
) -> None:
    """Shape a shell in a page of the browser, until Ctrl-C. This machine only."""
    from ifs_cad.design_file import SUFFIX
    from ifs_cad.studio.run import run

    if design is not None and design.suffix.lower() != SUFFIX:
        raise typer.BadParameter(f"A design file ends in {SUFFIX}: {design}{SUFFIX}.")

    run(design, port, typer.echo)
