"""The command line: ``ifs-cad build``, ``check``, ``fabricate``, ``verify``, ``analyse`` and more.

Exit codes: 0 done, 1 an error or a failed check, 2 a wrong command line, 130 interrupted.
"""

from __future__ import annotations

from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperGroup

from ifs_cad.cli.make import build, check, fabricate, verify
from ifs_cad.cli.see import animate, render, show, studio
from ifs_cad.cli.stand import analyse
from ifs_cad.errors import IfsCadError

INTERRUPTED = 130  # as a shell reports a program that Ctrl-C ended


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


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"ifs-cad {version('ifs-cad')}")
        raise typer.Exit


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


for command in (build, check, fabricate, verify, analyse, render, animate, show, studio):
    app.command()(command)


def main() -> None:
    """Run the command line."""
    app()
