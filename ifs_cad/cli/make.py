"""The commands that make files and check them: build, check, fabricate, verify."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from ifs_cad.cli.options import Hold, Quiet, Schema, Script, Settings, Side


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
