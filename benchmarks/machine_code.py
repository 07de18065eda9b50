"""(k) Programs for 256 panels: from nested sheets to checked G-code, and four times as many."""

from __future__ import annotations

from collections.abc import Iterator

import designs
from table import Line
from timing import interleaved

import ifs_cad as ifs
from ifs_cad.export.gcode import gcode
from ifs_cad.fabrication.layout import Layout
from ifs_cad.fabrication.machining.router import read_router
from ifs_cad.fabrication.machining.setup import Setup, set_up
from ifs_cad.fabrication.machining.toolpath import toolpaths
from ifs_cad.fabrication.machining.verify import verify
from ifs_cad.fabrication.stock_file import read_stock

SECONDS = 10.0
"""That the programs of 256 panels may take."""


def measure(repetitions: int) -> Iterator[Line]:
    """Write the programs of 256 and of 1,024 panels, and read the former back."""
    small, large = _nested(designs.DEPTH), _nested(designs.DEPTH + 1)
    counts = [len(setup.pieces) for setup, _ in (small, large)]
    times = interleaved(
        {"small": lambda: _programs(*small), "large": lambda: _programs(*large)}, repetitions
    )
    one, four = times["small"], times["large"]
    sheets = len(small[1].sheets)
    yield Line(
        "k",
        f"programs of {sheets} sheets, {counts[0]} panels: tool paths and G-code",
        f"{one.best:.2f} s",
        "",
        one.best,
        " s",
        limit=SECONDS,
        noise=one.wall / one.best,
    )
    yield Line(
        "k",
        f"the same for {counts[1]:,} panels, per panel",
        f"{1e3 * four.best / counts[1]:.2f} ms a panel",
        f"{1e3 * one.best / counts[0]:.2f} ms a panel at {counts[0]}",
        (four.best / counts[1]) / (one.best / counts[0]),
        " x",
        limit=1.5,
        noise=four.wall / four.best,
    )
    read = interleaved({"read": lambda: _verified(*small)}, 1)["read"]
    yield Line(
        "k",
        f"reading the programs of {counts[0]} panels back and comparing them with the panels",
        f"{read.best:.2f} s",
        f"{one.best:.2f} s to write them",
        read.best / one.best,
        " x",
        noise=read.wall / read.best,
    )


def _nested(depth: int) -> tuple[Setup, Layout]:
    pieces = ifs.workpieces(designs.shell(depth), label=ifs.Label(), holes=ifs.Holes())
    setup = set_up(pieces, read_router())
    stock = read_stock().sheets_of(designs.THICKNESS, pieces[0].material.name)
    return setup, ifs.nest(pieces, stock, spacing=setup.spacing + 1.0, margin=10.0)


def _programs(setup: Setup, layout: Layout) -> list[str]:
    router = setup.router
    return [
        gcode(toolpaths(sheet, setup.pieces, router.tools, router.machine, setup.settings))
        for sheet in layout.sheets
    ]


def _verified(setup: Setup, layout: Layout) -> None:
    router = setup.router
    for sheet, text in zip(layout.sheets, _programs(setup, layout), strict=True):
        found = verify(
            text,
            sheet,
            setup.pieces,
            router.tools,
            router.machine,
            settings=setup.settings,
            linuxcnc=False,
            simulate=False,
        )
        assert found.ok, str(found)
