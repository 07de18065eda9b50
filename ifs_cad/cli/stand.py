"""The command that asks whether shells stand: analyse."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from ifs_cad.cli.options import Quiet, Script, Settings, read_force


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
            parser=read_force,
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
    fibre: Annotated[
        str | None,
        typer.Option(
            metavar="CURVE",
            help="Fibre along curve a or b of a vector sum, or the long one: a, b, long.",
            show_default="that of the shell",
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
    Plywood needs a fibre direction: the shell's own, or --fibre.

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
        fibre=fibre,
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
