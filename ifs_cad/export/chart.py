"""Several shells side by side: a table of their answers and bars of their deflections as SVG."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from html import escape
from pathlib import Path

from ifs_cad.errors import InputError
from ifs_cad.fabrication.table import Cell, Column, Table
from ifs_cad.files import replaced
from ifs_cad.structure.result import Result

COLUMNS = (
    Column("shell", "text"),
    Column("deflection u_z mm"),
    Column("in panel", "text"),
    Column("displacement mm"),
    Column("utilisation"),
    Column("weight kN"),
    Column("load kN"),
    Column("deflection against the first"),
)
WIDTH, BAR, GAP, NAMES, VALUES = 640, 26, 12, 150, 130  # pixels
COLOUR = "#3b528b"


def comparison(results: Mapping[str, Result]) -> Table:
    """Return one row for each shell; deflections are compared with the first shell's.

    Parameters
    ----------
    results : {name: Result}

    Raises
    ------
    InputError
        No shell at all.
    """
    if not results:
        raise InputError("There is nothing to compare. Give the results of shells by name.")
    first = next(iter(results.values())).deflection.value
    return Table("comparison", COLUMNS, tuple(_row(*item, first) for item in results.items()))


def export_chart(results: Mapping[str, Result], path: str | os.PathLike[str]) -> Path:
    """Write bars of the largest deflections as SVG.

    Parameters
    ----------
    results : {name: Result}
    path : path of the file; its folder is made when missing

    Returns
    -------
    Path of the written file.

    Raises
    ------
    InputError
        No shell at all.
    ExportError
        The file could not be written; what stood there before is unchanged.
    """
    if not results:
        raise InputError("There is nothing to plot. Give the results of shells by name.")
    target = Path(path)
    with replaced(target) as scratch:
        scratch.write_text("\n".join(_svg(results)) + "\n", encoding="utf-8")
    return target


def _row(name: str, result: Result, first: float) -> tuple[Cell, ...]:
    used, down = result.largest_utilisation, result.deflection
    return (
        name,
        down.value,
        down.address,
        result.largest_displacement.value,
        None if used is None else used.value,
        result.weight / 1e3,
        -float(result.load[2]) / 1e3,
        down.value / first if first else None,
    )


def _svg(results: Mapping[str, Result]) -> Iterator[str]:
    height = len(results) * (BAR + GAP) + 3 * GAP + BAR
    size = f'width="{WIDTH}" height="{height}" viewBox="0 0 {WIDTH} {height}"'
    yield f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif">'
    yield f'<rect width="{WIDTH}" height="{height}" fill="white"/>'
    yield f'<text x="{GAP}" y="{2 * GAP}" font-size="15">Largest deflection |u_z|, mm</text>'
    first = next(iter(results.values())).deflection.value
    highest = max(result.deflection.value for result in results.values()) or 1.0
    for number, (name, result) in enumerate(results.items()):
        top = 3 * GAP + number * (BAR + GAP)
        value = result.deflection.value
        length = (WIDTH - NAMES - VALUES) * value / highest
        line = f'y="{top + 0.7 * BAR:g}" font-size="14"'
        less = f"  (1/{first / value:.3g})" if 0 < value < first else ""
        yield f'<text x="{NAMES - GAP}" {line} text-anchor="end">{escape(name)}</text>'
        yield (f'<rect x="{NAMES}" y="{top}" width="{length:.2f}" height="{BAR}" fill="{COLOUR}"/>')
        yield f'<text x="{NAMES + length + 6:.2f}" {line}>{value:.4g}{less}</text>'
    yield "</svg>"
