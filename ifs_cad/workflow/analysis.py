"""The worker's side of `analyse`: shells out of what a script showed, answers into files."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from ifs_cad import progress
from ifs_cad.elements.panel import Shell
from ifs_cad.errors import InputError, ScriptError
from ifs_cad.export.chart import comparison, export_chart
from ifs_cad.export.cutlist import export_csv
from ifs_cad.export.deck import export_calculix
from ifs_cad.export.vtu import export_vtu
from ifs_cad.structure.analyse import Solver
from ifs_cad.structure.load import AreaLoad, Load, SelfWeight
from ifs_cad.structure.model import Joints, model_of
from ifs_cad.structure.modes import modes_of
from ifs_cad.structure.nonlinear import deform
from ifs_cad.structure.result import Result
from ifs_cad.structure.support import SIDES, Support
from ifs_cad.types import Plane
from ifs_cad.view.deformed import render_deformed
from ifs_cad.workflow.analyse import Question


def shells_of(assemblies: Sequence[Any]) -> dict[str, Shell]:
    """Return the shells of which assemblies, or assemblies within them, were made, by name.

    Raises
    ------
    ScriptError
        There is none, or two have the same name.
    """
    found: dict[str, Shell] = {}
    for assembly in (one for whole in assemblies for one in _walk(whole)):
        shell = assembly.metadata.get("elements")
        if not isinstance(shell, Shell):
            continue
        name = str(assembly.name).rpartition("/")[2]
        if name in found:
            raise ScriptError(
                f"Two shells are named {name!r}, and their files would be the same. Name them: "
                "to_assembly(shell, name=...)."
            )
        found[name] = shell
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
    shells = shells_of(assemblies)
    for name, shell in shells.items():
        prefix = "" if len(shells) == 1 else f"{name}_"
        results[name], reports[name] = _analyse(shell, folder, prefix, question)
    compared = ""
    if len(results) > 1:
        table = comparison(results)
        export_csv(table, folder / "comparison.csv")
        export_chart(results, folder / "comparison.svg")
        compared = "\n".join(
            f"{row[0]}: {row[1]:.4g} mm, {row[-1]:.4g} of the first" for row in table.rows
        )
    text = "\n\n".join([f"{name}\n{report}" for name, report in reports.items()] + [compared])
    (folder / "report.txt").write_text(f"{text.strip()}\n", encoding="utf-8")
    return {"reports": reports, "comparison": compared}


def _analyse(shell: Shell, folder: Path, prefix: str, question: Question) -> tuple[Result, str]:
    model = model_of(
        shell,
        supports=read_supports_text(question.supports),
        joints=_joints(question.joints),
        divisions=question.divisions,
    )
    loads = _loads(shell, question)
    result = deform(model, loads) if question.nonlinear else Solver(model)(loads)
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


def read_supports_text(text: str) -> list[Support]:
    """Read supports: "standing", "borders" for all of them, names and numbers of borders.

    Raises
    ------
    InputError
    """
    supports = []
    for word in (part.strip() for part in text.split(",")):
        if word == "standing":
            supports.append(Support.standing())
        elif word == "borders":
            supports.append(Support.border())
        elif word in SIDES:
            supports.append(Support.border(word))
        elif word.isdecimal():
            supports.append(Support.border(int(word)))
        else:
            raise InputError(
                f"Unknown support {word!r}. Give standing, borders, the number of a border, or "
                f'some of {", ".join(SIDES)}, with commas between: "a start, a end".'
            )
    return supports


def _joints(text: str) -> Joints:
    named: dict[str, Joints] = {"hinge": "hinge", "rigid": "rigid"}
    if text in named:
        return named[text]
    try:
        return float(text)
    except ValueError:
        raise InputError(
            f"Joints are hinge, rigid or a stiffness in N mm/rad per mm of edge, not {text!r}."
        ) from None


def _loads(shell: Shell, question: Question) -> list[Load]:
    if not math.isfinite(question.load) or question.load < 0:
        raise InputError(f"The load must be 0 or more, got {question.load} N/m2.")
    loads: list[Load] = []
    if question.load:
        half = _first_half(shell) if question.half else None
        loads.append(AreaLoad(pressure=question.load, on=half))
    if question.weight:
        loads.append(SelfWeight())
    return loads


def _first_half(shell: Shell) -> Plane:
    """Return the plane across the longer side in its middle; the lower x or y is above it."""
    low, high = shell.mesh.vertices.min(axis=0), shell.mesh.vertices.max(axis=0)
    along_y = bool((high - low)[1] > (high - low)[0])
    x, y, z = ((low + high) / 2).tolist()
    return Plane((x, y, z), (0.0, -1.0, 0.0) if along_y else (-1.0, 0.0, 0.0))


def _walk(assembly: Any) -> Iterator[Any]:
    yield assembly
    for child in assembly.children:
        yield from _walk(child)
