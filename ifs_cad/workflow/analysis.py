"""The worker's side of `analyse`: shells out of what a script showed, answers into files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ifs_cad import progress
from ifs_cad.elements.panel import Shell
from ifs_cad.errors import ScriptError
from ifs_cad.export.chart import comparison, export_chart
from ifs_cad.export.cutlist import export_csv
from ifs_cad.export.deck import export_calculix
from ifs_cad.export.vtu import export_vtu
from ifs_cad.fabrication.table import Cell, Table
from ifs_cad.structure.analysis import KEY, Analysis
from ifs_cad.structure.converge import LARGEST, converged
from ifs_cad.structure.model import model_of
from ifs_cad.structure.modes import modes_of
from ifs_cad.structure.nonlinear import deform
from ifs_cad.structure.result import Result
from ifs_cad.structure.solver import Solver
from ifs_cad.view.deformed import render_deformed
from ifs_cad.workflow.question import Question, answer_to, read_fibre

LARGEST_DEFORMED = 50_000  # degrees of freedom; equilibrium is sought some twenty times


def shells_of(assemblies: Sequence[Any]) -> dict[str, Shell]:
    """Return the shells of which assemblies, or assemblies within them, were made, by name.

    Raises
    ------
    ScriptError
        There is none, or two have the same name.
    """
    return {name: shell for name, (shell, _) in asked(assemblies).items()}


def asked(assemblies: Sequence[Any]) -> dict[str, tuple[Shell, Analysis | None]]:
    """Return the same, and with each shell what the nearest assembly around it wants to know.

    Raises
    ------
    ScriptError
    """
    found: dict[str, tuple[Shell, Analysis | None]] = {}
    for whole in assemblies:
        for assembly, analysis in _walk(whole, None):
            shell = assembly.metadata.get("elements")
            if not isinstance(shell, Shell):
                continue
            name = str(assembly.name).rpartition("/")[2]
            if name in found:
                raise ScriptError(
                    f"Two shells are named {name!r}, and their files would be the same. Name "
                    "them: to_assembly(shell, name=...)."
                )
            found[name] = shell, analysis
    if not found:
        raise ScriptError(
            "Only shells of panels are analysed, and the script showed none. Show what "
            "to_assembly(shell) returns."
        )
    return found


def make_analysis(assemblies: Sequence[Any], folder: Path, question: Question) -> dict[str, Any]:
    """Analyse every shell and write the answers into a folder.

    Parameters
    ----------
    assemblies : what a script showed
    folder : Path
    question : Question

    Returns
    -------
    {"reports": {name: table}, "comparison": text}
    """
    results, reports = {}, {}
    shells = asked(assemblies)
    for name, (shell, own) in shells.items():
        prefix = "" if len(shells) == 1 else f"{name}_"
        analysis = answer_to(shell, own or Analysis(), question)
        results[name], reports[name] = _analyse(shell, analysis, folder, prefix, question)
    compared = ""
    if len(results) > 1:
        table = comparison(results)
        export_csv(table, folder / "comparison.csv")
        export_chart(results, folder / "comparison.svg")
        compared = _text(table)
    text = "\n\n".join([f"{name}\n{report}" for name, report in reports.items()] + [compared])
    (folder / "report.txt").write_text(f"{text.strip()}\n", encoding="utf-8")
    return {"reports": reports, "comparison": compared}


def _analyse(
    shell: Shell, asked_for: Analysis, folder: Path, prefix: str, question: Question
) -> tuple[Result, str]:
    held: dict[str, Any] = {
        "supports": asked_for.supports,
        "joints": asked_for.joints,
        "fibre": read_fibre(question.fibre),
    }
    loads = asked_for.loads
    if question.divisions is not None:
        model = model_of(shell, divisions=question.divisions, **held)
        result = None if question.nonlinear else Solver(model)(loads)
    else:
        largest = LARGEST_DEFORMED if question.nonlinear else LARGEST
        result = converged(shell, loads, largest=largest, **held)
        model = result.model
    if question.nonlinear:
        error = None if result is None else result.mesh_error
        result = replace(deform(model, loads), mesh_error=error)
    assert result is not None
    report = str(result)
    if question.modes:
        report += f"\n{modes_of(model, question.modes)}"
    progress.report("writing")
    export_vtu(result, folder / f"{prefix}result.vtu")
    if isinstance(model.joints, str):
        export_calculix(model, loads, folder / f"{prefix}deck.inp")
    else:
        report += "\nnote           no deck: CalculiX has no springs along the edges of shells"
    progress.report("drawing")
    render_deformed(result, folder / f"{prefix}deformed.png")
    return result, report


def _text(table: Table) -> str:
    """Return a table for people: numbers of four digits under short heads."""
    heads = ["", "u_z, mm", "in panel", "|u|, mm", "used", "weight, kN", "load, kN", "of the first"]
    rows = [[_cell(cell) for cell in row] for row in table.rows]
    widths = [max(map(len, column)) for column in zip(heads, *rows, strict=True)]
    lines = []
    for row in (heads, *rows):
        cells = [f"{cell:>{width}}" for cell, width in zip(row[1:], widths[1:], strict=True)]
        lines.append("  ".join([f"{row[0]:<{widths[0]}}", *cells]))
    return "\n".join(lines)


def _cell(cell: Cell) -> str:
    if cell is None:
        return "-"
    return f"{cell:.4g}" if isinstance(cell, float) else str(cell)


def _walk(assembly: Any, above: Analysis | None) -> Iterator[tuple[Any, Analysis | None]]:
    own = assembly.metadata.get(KEY, above)
    if own is not None and not isinstance(own, Analysis):
        raise ScriptError(f'The metadata "{KEY}" must hold an Analysis, got {own!r}.')
    yield assembly, own
    for child in assembly.children:
        yield from _walk(child, own)
