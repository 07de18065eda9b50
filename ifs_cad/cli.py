"""The command line: ``ifs-cad build``, ``check``, ``fabricate``, ``verify``, ``analyse`` and more.

Exit codes: 0 done, 1 an error or a failed check, 2 a wrong command line, 130 interrupted.
"""

from __future__ import annotations

import json
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperGroup

from ifs_cad.errors import IfsCadError

INTERRUPTED = 130  # as a shell reports a program that Ctrl-C ended


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


class _Commands(TyperGroup):
    """Commands whose errors are one clean message."""

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt as stop:
            _end(str(stop) or "Interrupted.", INTERRUPTED)
        except IfsCadError as error:
            _end(f"Error: {error}", 1)


def _end(message: str, code: int) -> NoReturn:
    typer.echo(message, err=True)
    raise typer.Exit(code)


def _setting(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not (equals and name.strip()):
        raise typer.BadParameter(f"give a name and a value, as thickness=12, not {text!r}")
    return name.strip(), value


def _force(text: str) -> tuple[str, float]:
    address, equals, size = text.partition("=")
    try:
        return address.strip(), float(size if equals and address.strip() else "none")
    except ValueError:
        raise typer.BadParameter(
            f"give an address and newtons, as 0211=500, not {text!r}"
        ) from None


def _sweep(text: str) -> tuple[str, str, str]:
    name, value = _setting(text)
    begin, _, end = value.partition(":")
    try:
        float(begin), float(end)
    except ValueError:
        raise typer.BadParameter(f"give two numbers, as {name}=0:0.5, not {text!r}") from None
    return name, begin.strip(), end.strip()


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"ifs-cad {version('ifs-cad')}")
        raise typer.Exit


Script = Annotated[Path, typer.Argument(help="A part script or design file.", show_default=False)]
Model = Annotated[
    Path, typer.Argument(help="A part script, a design file or a STEP file.", show_default=False)
]
Settings = Annotated[
    list[Any] | None,
    typer.Option(
        "--set",
        parser=_setting,
        metavar="NAME=VALUE",
        help="Change a parameter of the script. Can be repeated.",
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")]

app = typer.Typer(
    cls=_Commands,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Free-form surfaces from IFS curves, as exact plywood panels in STEP files.",
)


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_version, is_eager=True, help="Print the version."),
    ] = False,
) -> None:
    pass


@app.command()
def build(
    script: Script,
    settings: Settings = None,
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder of all exports.")] = Path(
        "exports"
    ),
    schema: Annotated[Schema, typer.Option(case_sensitive=False, help="Of STEP.")] = Schema.AP214,
    flat_panels: Annotated[
        bool, typer.Option("--flat-panels", help="Also write every panel alone, lying flat.")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Run a part script and write what it shows as STEP.

    The files go into a folder named after the script.
    """
    from ifs_cad.workflow.build import build as run_build
    from ifs_cad.workflow.display import display

    with display(quiet) as listener:
        result = run_build(
            script,
            settings=dict(settings or ()),
            out=out,
            schema=schema,
            flat_panels=flat_panels,
            listener=listener,
        )
    if not quiet:
        typer.echo(result.summary(listener.heard))


@app.command()
def check(
    file: Annotated[Path, typer.Argument(help="A STEP file.", show_default=False)],
    as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False,
    quiet: Quiet = False,
) -> None:
    """Read a STEP file back and check its panels; exit with 1 when anything fails."""
    from ifs_cad.workflow.display import display
    from ifs_cad.workflow.supervise import run

    with display(quiet or as_json) as listener:
        report = run("check", {"path": str(file)}, listener)
    good = report["data"]["ok"]
    if as_json:
        typer.echo(json.dumps(report["data"], indent=2))
    elif not (quiet and good):
        typer.echo(report["text"], err=quiet)
    if not good:
        raise typer.Exit(1)


@app.command()
def fabricate(
    script: Script,
    settings: Settings = None,
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder of all exports.")] = Path(
        "exports"
    ),
    only: Annotated[
        list[str] | None,
        typer.Option(metavar="PATTERN", help="Make these addresses only, as 03*. Can be repeated."),
    ] = None,
    stock: Annotated[
        Path | None, typer.Option(help="A TOML file of sheets and boards.", show_default=False)
    ] = None,
    use: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="A sheet or board to use. Can be repeated."),
    ] = None,
    visible: Annotated[
        Side | None, typer.Option(help="The face that is seen in the building.")
    ] = None,
    programs: Annotated[
        bool, typer.Option("--programs/--no-programs", help="Write G-code for every sheet.")
    ] = True,
    tools: Annotated[
        Path | None,
        typer.Option(help="A TOML file of tools, machine and control.", show_default=False),
    ] = None,
    cutter: Annotated[
        float | None,
        typer.Option(
            help="Diameter of the contour cutter, mm.", show_default="the thinnest long enough"
        ),
    ] = None,
    hold: Annotated[
        Hold | None,
        typer.Option(
            help="What keeps pieces in place.", show_default="none where all are pierced, or tabs"
        ),
    ] = None,
    margin: Annotated[float, typer.Option(help="Kept free along the edge of sheets, mm.")] = 10.0,
    kerf: Annotated[float, typer.Option(help="Width of the saw cut between planks, mm.")] = 4.0,
    trim: Annotated[float, typer.Option(help="Cut off each end of a board, mm.")] = 10.0,
    thorough: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Look longer for a better nest.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Write all that a workshop needs: solids, nested sheets or boards, programs, drawings, lists.

    The folder is named after the script; open its index.html. It takes the place of the former one
    as a whole.
    """
    from ifs_cad.fabrication.workshop import Workshop
    from ifs_cad.workflow.display import display
    from ifs_cad.workflow.fabricate import fabricate as run_fabricate

    workshop = Workshop(
        stock=None if stock is None else str(stock),
        use=tuple(use or ()),
        only=tuple(only or ()),
        visible=None if visible is None else visible.value,
        programs=programs,
        tools=None if tools is None else str(tools),
        cutter=cutter,
        hold=None if hold is None else hold.value,
        margin=margin,
        kerf=kerf,
        trim=trim,
        method="fast" if thorough is None else "thorough",
        seconds=60.0 if thorough is None else thorough,
    )
    with display(quiet) as listener:
        result = run_fabricate(
            script, settings=dict(settings or ()), out=out, workshop=workshop, listener=listener
        )
    if not quiet:
        typer.echo(result.summary())


@app.command()
def verify(
    files: Annotated[
        list[Path], typer.Argument(help="Programs (G-code) of sheets.", show_default=False)
    ],
    job: Annotated[
        Path | None,
        typer.Option(
            help="What they are to make.", show_default="job.json beside the program or above"
        ),
    ] = None,
    simulate: Annotated[
        bool, typer.Option("--simulate/--no-simulate", help="Also cut the sheet point by point.")
    ] = True,
    as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False,
    quiet: Quiet = False,
) -> None:
    """Replay programs and compare what they leave with the panels; exit with 1 at any fault.

    Every fault is printed with its line. LinuxCNC's rs274 reads them too where it is installed.
    """
    from ifs_cad.workflow.display import display
    from ifs_cad.workflow.verify import verify_programs

    with display(quiet or as_json) as listener:
        found = verify_programs(files, job, simulate=simulate, listener=listener)
    if as_json:
        typer.echo(json.dumps([one.as_dict() for one in found], indent=2))
    else:
        for one in found:
            if not (quiet and one.ok):
                typer.echo(str(one), err=quiet)
    if not all(one.ok for one in found):
        raise typer.Exit(1)


@app.command()
def analyse(
    script: Script,
    settings: Settings = None,
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder of all exports.")] = Path(
        "exports"
    ),
    load: Annotated[
        float | None, typer.Option(help="N/m2 of the ground plan (snow).", show_default=False)
    ] = None,
    surface_load: Annotated[
        float | None, typer.Option(help="N/m2 of the panels (cladding).", show_default=False)
    ] = None,
    half: Annotated[bool, typer.Option("--half", help="Load one half of the span only.")] = False,
    part: Annotated[
        list[str] | None,
        typer.Option(metavar="PATTERN", help="Load these panels only, as 03*. Can be repeated."),
    ] = None,
    point: Annotated[
        list[Any] | None,
        typer.Option(
            parser=_force,
            metavar="ADDRESS=N",
            help="A force down in the middle of a panel. Can be repeated.",
        ),
    ] = None,
    weight: Annotated[bool, typer.Option("--weight", help="Add the weight of the panels.")] = False,
    supports: Annotated[
        list[str] | None,
        typer.Option(
            metavar="BORDERS",
            help="standing, borders, or borders by name: 'a start, a end'. Can be repeated.",
        ),
    ] = None,
    joints: Annotated[
        str | None,
        typer.Option(
            help="hinge, rigid, or a stiffness in N mm/rad per mm of edge.", show_default=False
        ),
    ] = None,
    divisions: Annotated[
        int | None,
        typer.Option(
            help="Quads along each edge of a panel; by default refined until the displacement is "
            "known to 2 %.",
            show_default=False,
        ),
    ] = None,
    nonlinear: Annotated[
        bool, typer.Option("--nonlinear", help="Find equilibrium in the deformed shape.")
    ] = False,
    modes: Annotated[int, typer.Option(help="How many natural frequencies.")] = 0,
    quiet: Quiet = False,
) -> None:
    """Compute how the shells that a part script shows carry a load.

    Loads, supports and joints are those that the script gives (ifs.Analysis), or 1500 N/m2 of the
    ground plan on hinged panels standing on their lowest edges; every option replaces its part.

    Writes the mesh with all results (VTU), an input deck for CalculiX and a picture of the
    deformed shell into the folder analysis of the part, and a comparison of several shells.
    """
    from ifs_cad.workflow.analyse import analyse as run_analyse
    from ifs_cad.workflow.display import display
    from ifs_cad.workflow.question import Question

    question = Question(
        load=load,
        surface_load=surface_load,
        half=half,
        part=tuple(part or ()),
        points=tuple(point or ()),
        weight=weight,
        supports=tuple(supports or ()),
        joints=joints,
        divisions=divisions,
        nonlinear=nonlinear,
        modes=modes,
    )
    with display(quiet) as listener:
        result = run_analyse(
            script, settings=dict(settings or ()), out=out, question=question, listener=listener
        )
    if not quiet:
        typer.echo(result.summary())


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


@app.command()
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


@app.command()
def animate(
    script: Script,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="A .gif or an .mp4.", show_default=False)
    ],
    sweep: Annotated[
        Any,
        typer.Option(
            parser=_sweep, metavar="NAME=FROM:TO", help="The parameter of the script that changes."
        ),
    ],
    frames: Annotated[
        int | None,
        typer.Option(help="How many values; every whole number without it.", show_default="24"),
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

    Whole numbers, as depth=1:5, go one by one: the steps of the iteration.
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
    """Return the values of a sweep as text, whole numbers one by one."""
    try:
        first, last = int(begin), int(end)
    except ValueError:
        low, high = float(begin), float(end)
        count = 24 if frames is None else frames
        steps = max(count - 1, 1)
        return [f"{low + (high - low) * step / steps:.9g}" for step in range(count)]
    count = abs(last - first) + 1 if frames is None else min(frames, abs(last - first) + 1)
    steps = max(count - 1, 1)
    return [str(first + round((last - first) * step / steps)) for step in range(count)]


@app.command()
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
        )
        return
    with display(quiet) as listener:
        arguments = {"source": str(model), "settings": chosen, "port": port, "options": options}
        run("show", arguments, listener)


@app.command()
def studio(
    design: Annotated[
        Path | None, typer.Argument(help="A design file; new if it does not exist.")
    ] = None,
    port: Annotated[
        int | None, typer.Option(help="Where the page is served.", show_default="any free one")
    ] = None,
) -> None:
    """Shape a shell in a page of the browser, until Ctrl-C. This machine only."""
    from ifs_cad.studio.run import run

    run(design, port, typer.echo)


def main() -> None:
    """Run the command line."""
    app()


if __name__ == "__main__":
    main()
