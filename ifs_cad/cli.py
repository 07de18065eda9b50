"""The command line.

``ifs-cad build``, ``check``, ``analyse``, ``fabricate``, ``render``, ``show``, ``studio``.

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
    cutter: Annotated[float, typer.Option(help="Diameter of the contour cutter, mm.")] = 12.0,
    margin: Annotated[float, typer.Option(help="Kept free along the edge of sheets, mm.")] = 10.0,
    kerf: Annotated[float, typer.Option(help="Width of the saw cut between planks, mm.")] = 4.0,
    trim: Annotated[float, typer.Option(help="Cut off each end of a board, mm.")] = 10.0,
    thorough: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Look longer for a better nest.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Write all that a workshop needs: solids, nested sheets or boards, drawings, lists.

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
        cutter=cutter,
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
def analyse(
    script: Script,
    settings: Settings = None,
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder of all exports.")] = Path(
        "exports"
    ),
    load: Annotated[float, typer.Option(help="N/m2 of the ground plan.")] = 1500.0,
    half: Annotated[bool, typer.Option("--half", help="Load one half of the span only.")] = False,
    weight: Annotated[bool, typer.Option("--weight", help="Add the weight of the panels.")] = False,
    supports: Annotated[
        str, typer.Option(help="standing, borders, or borders by name: 'a start, a end'.")
    ] = "standing",
    joints: Annotated[
        str, typer.Option(help="hinge, rigid, or a stiffness in N mm/rad per mm of edge.")
    ] = "hinge",
    divisions: Annotated[int, typer.Option(help="Quads along each edge of a panel.")] = 4,
    nonlinear: Annotated[
        bool, typer.Option("--nonlinear", help="Find equilibrium in the deformed shape.")
    ] = False,
    modes: Annotated[int, typer.Option(help="How many natural frequencies.")] = 0,
    quiet: Quiet = False,
) -> None:
    """Compute how the shells that a part script shows carry a load.

    Writes the mesh with all results (VTU), an input deck for CalculiX and a picture of the
    deformed shell into the folder analysis of the part, and a comparison of several shells.
    """
    from ifs_cad.workflow.analyse import Question
    from ifs_cad.workflow.analyse import analyse as run_analyse
    from ifs_cad.workflow.display import display

    question = Question(load, half, weight, supports, joints, divisions, nonlinear, modes)
    with display(quiet) as listener:
        result = run_analyse(
            script, settings=dict(settings or ()), out=out, question=question, listener=listener
        )
    if not quiet:
        typer.echo(result.summary())


@app.command()
def render(
    model: Model,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="The picture, a PNG.", show_default=False)
    ],
    settings: Settings = None,
    azimuth: Annotated[float, typer.Option(help="Degrees about z, from the x axis.")] = -60.0,
    elevation: Annotated[float, typer.Option(help="Degrees above the horizon.")] = 25.0,
    width: Annotated[int, typer.Option(help="Pixels.")] = 1600,
    height: Annotated[int, typer.Option(help="Pixels.")] = 1000,
    quiet: Quiet = False,
) -> None:
    """Draw a model as a PNG; no screen is needed."""
    from ifs_cad.workflow.display import display
    from ifs_cad.workflow.staging import install, staging
    from ifs_cad.workflow.supervise import run

    view = {"azimuth": azimuth, "elevation": elevation, "width": width, "height": height}
    with display(quiet) as listener, staging(output) as stage:
        made = stage / output.name
        arguments = {
            "source": str(model),
            "settings": dict(settings or ()),
            "path": str(made),
            "options": view,
        }
        run("render", arguments, listener)
        install(made, output)
    if not quiet:
        typer.echo(f"Wrote {output}")


@app.command()
def show(
    model: Model,
    settings: Settings = None,
    port: Annotated[
        int | None, typer.Option(help="Where the viewer listens.", show_default="3939")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Send a model to a running OCP viewer."""
    from ifs_cad.workflow.display import display
    from ifs_cad.workflow.supervise import run

    with display(quiet) as listener:
        arguments = {"source": str(model), "settings": dict(settings or ()), "port": port}
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
