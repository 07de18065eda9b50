"""(i) Nesting the prototype against spyrrow alone, (j) its folder for the workshop, by stage."""

from __future__ import annotations

import math
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import spyrrow
from table import Line

import ifs_cad as ifs
from ifs_cad.fabrication.nesting.envelope import clearance_reach
from ifs_cad.fabrication.nesting.nest import nest
from ifs_cad.fabrication.stock import Sheet
from ifs_cad.fabrication.stock_file import read_stock
from ifs_cad.fabrication.workpiece import Workpiece
from ifs_cad.kernel.source import run_script

PROTOTYPE = Path(__file__).parent.parent / "parts" / "shell_prototype.py"
SECONDS = 120.0  # for the thorough way, and for spyrrow alone
BEYOND_THE_SOLIDS = 60.0  # seconds that the rest of the folder may take
MARGIN = 10.0


def measure_nesting(quick: bool) -> list[Line]:
    """Nest the prototype's panels on sheets of 2500 x 1250, both ways and by spyrrow alone."""
    (shown,) = run_script(PROTOTYPE, {})
    data = shown.assembly.metadata
    pieces = ifs.workpieces(data["elements"], label=data["label"], holes=data["holes"])
    (sheet,) = read_stock().sheets_of(10.0, "spruce plywood")
    spacing = max(clearance_reach(piece, 12.0, 0.5).beyond for piece in pieces) + 1.0
    budget = SECONDS / 4 if quick else SECONDS
    begin = time.perf_counter()
    fast = nest(pieces, [sheet], spacing=spacing, margin=MARGIN)
    seconds = time.perf_counter() - begin
    thorough = nest(
        pieces, [sheet], spacing=spacing, margin=MARGIN, method="thorough", seconds=budget
    )
    alone = _by_spyrrow(pieces, sheet, spacing, budget)
    shares = [_share_used(layout, pieces, sheet) for layout in (fast, thorough)]
    bound = f"{fast.bound} sheets by area alone"
    return [
        Line(
            "i",
            "nesting 256 panels, fast: used of the sheets, the last one up to its last panel",
            f"{len(fast.sheets)} sheets, {100 * shares[0]:.1f} % in {seconds:.1f} s",
            bound,
            100 * shares[0],
            " %",
        ),
        Line(
            "i",
            f"the same, thorough, {budget:.0f} s, against spyrrow sheet by sheet: points less",
            f"{len(thorough.sheets)} sheets, {100 * shares[1]:.1f} %",
            f"{100 * alone:.1f} % spyrrow alone, {budget:.0f} s",
            100 * (alone - shares[1]),
            " points",
            limit=2.0,
        ),
    ]


def measure_folder() -> list[Line]:
    """Make the folder of the prototype."""
    with TemporaryDirectory() as folder:
        done = ifs.fabricate(PROTOTYPE, out=folder)
    stages = dict(done.stages)
    solids = stages.pop("solids (STEP)")
    rest = sum(stages.values())
    listing = ", ".join(f"{what} {seconds:.1f}" for what, seconds in stages.items())
    return [
        Line(
            "j",
            f"ifs-cad fabricate for 256 panels, beyond the solids: {listing}",
            f"{rest:.1f} s",
            f"{solids:.1f} s the solids",
            rest,
            " s",
            limit=BEYOND_THE_SOLIDS,
        )
    ]


def _share_used(layout: Any, pieces: tuple[Workpiece, ...], sheet: Sheet) -> float:
    """Return the share of the sheets that is used; of the last sheet only its used length."""
    silhouettes = {piece.address: piece.silhouette for piece in pieces}
    lengths = [
        max(float(p(silhouettes[p.address])[:, 0].max()) for p in nested.placements) + MARGIN
        for nested in layout.sheets
    ]
    used = sum(nested.used for nested in layout.sheets)
    full = sheet.length * (len(lengths) - 1) + min(lengths)
    return used / (full * sheet.width)


def _by_spyrrow(
    pieces: tuple[Workpiece, ...], sheet: Sheet, spacing: float, budget: float
) -> float:
    """Return the share that spyrrow uses, sheet by sheet: the most pieces in order that fit."""
    areas = np.array([_area(piece.silhouette) for piece in pieces])
    room = sheet.length - 2 * MARGIN
    share = math.ceil(budget / (3 * sum(areas) / (0.75 * sheet.length * sheet.width)))
    first, full, last = 0, 0.0, 0.0
    while first < len(pieces):
        reach = np.searchsorted(np.cumsum(areas[first:]), 0.76 * sheet.length * sheet.width)
        count, fits, length = int(reach), 0, 0.0
        for _ in range(3):
            count = max(1, min(count, len(pieces) - first))
            width = _strip(pieces[first : first + count], sheet, spacing, share)
            if width <= room:
                if count > fits:
                    fits, length = count, width
                if first + count == len(pieces):
                    break
                count += 1
            else:
                count -= 1
        if fits == 0:  # fewer, until they fit
            while width > room:
                count -= 1
                width = _strip(pieces[first : first + count], sheet, spacing, share)
            fits, length = count, width
        first += fits
        full, last = full + sheet.length, length + 2 * MARGIN
    return float(areas.sum() / ((full - sheet.length + last) * sheet.width))


def _strip(pieces: tuple[Workpiece, ...], sheet: Sheet, spacing: float, seconds: int) -> float:
    items = []
    for piece in pieces:
        assert piece.fibre is not None
        turn = -math.degrees(math.atan2(piece.fibre[1], piece.fibre[0]))
        shape = [tuple(xy) for xy in piece.silhouette.tolist()]
        items.append(spyrrow.Item(piece.address, shape, 1, [turn, turn + 180.0]))
    height = sheet.width + 2 * (spacing - MARGIN)
    instance = spyrrow.StripPackingInstance("sheet", height, items)
    config = spyrrow.StripPackingConfig(
        total_computation_time=seconds, min_items_separation=spacing, seed=0
    )
    return float(instance.solve(config).width) - 2 * spacing


def _area(outline: Any) -> float:
    x, y = outline.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
