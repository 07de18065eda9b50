"""Everything a workshop needs of one design, written into one folder.

Each *maker* writes one kind of file; they run in order and none knows of another. What they show
is one plan of one set of workpieces.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ifs_cad import progress
from ifs_cad.design.address import matching
from ifs_cad.elements.element import Elements
from ifs_cad.errors import CheckError, ScriptError
from ifs_cad.export.btlx import export_btlx
from ifs_cad.export.cutlist import export_csv, export_xlsx
from ifs_cad.export.drawing import (
    assembly_svg,
    board_svg,
    export_assembly_plan,
    export_board_drawings,
    export_element_drawings,
    export_sheet_drawings,
    sheet_svg,
)
from ifs_cad.export.dxf import export_dxf
from ifs_cad.export.gcode import export_gcode
from ifs_cad.export.overview import export_overview
from ifs_cad.export.step import export_sheets, export_step
from ifs_cad.fabrication.cutlist import CutList, cut_list
from ifs_cad.fabrication.machining.job import JOB_FILE, Job, read_job, write_job
from ifs_cad.fabrication.machining.machine_time import (
    MachineTime,
    machining_summary,
    machining_time,
)
from ifs_cad.fabrication.machining.toolpath import toolpaths
from ifs_cad.fabrication.machining.verify import verify_file
from ifs_cad.fabrication.operations import workpieces
from ifs_cad.fabrication.plan import Plan, make_plan
from ifs_cad.fabrication.planklist import plank_list
from ifs_cad.fabrication.saw import saw_list
from ifs_cad.fabrication.workpiece import Workpiece
from ifs_cad.fabrication.workshop import Workshop
from ifs_cad.kernel.assembly import extract, modified_parts
from ifs_cad.view.render import render

OVERVIEW = "index.html"


@dataclass(frozen=True, eq=False)
class Folder:
    """What the makers of a folder work from.

    Attributes
    ----------
    path : Path
    name : str, of the design
    workshop : Workshop
    assembly : cadquery Assembly, what is to be made of the design, in place
    elements : the whole design
    pieces : by address, what is to be made of it
    plan : Plan
    list : CutList
    times : how long the program of each sheet takes, by name; filled as programs are written
    """

    path: Path
    name: str
    workshop: Workshop
    assembly: Any
    elements: Elements
    pieces: Mapping[str, Workpiece]
    plan: Plan
    list: CutList
    times: dict[str, MachineTime] = field(default_factory=dict)

    @property
    def stock(self) -> Path:
        """Where the files of each sheet or board are."""
        return self.path / self.plan.kind

    @property
    def programs(self) -> Path:
        """Where the programs of the sheets are, with the job that they are verified against."""
        return self.path / "programs"

    @property
    def picture(self) -> Path:
        """Where the picture of the design is."""
        return self.path / f"{self.name}.png"


def make_folder(assembly: Any, path: Path, name: str, workshop: Workshop) -> dict[str, Any]:
    """Write the folder of one design.

    Returns
    -------
    dict
        "seconds" of each maker by what it made, "report" for the user, "modified" addresses.

    Raises
    ------
    ScriptError
        The assembly was not made by `to_assembly`.
    AddressError
        No address matches `workshop.only`.
    StockError
        No stock fits, or there is not enough.
    """
    begin = time.perf_counter()
    folder = _planned(assembly, path, name, workshop)
    seconds = {"plan": time.perf_counter() - begin}
    for what, make in MAKERS.items():
        progress.report(what)
        begin = time.perf_counter()
        make(folder)
        seconds[what] = time.perf_counter() - begin
    report = [str(folder.elements.report()), "", str(folder.plan)]
    if folder.times:
        report += ["", machining_summary(folder.times)]
    return {
        "seconds": seconds,
        "report": "\n".join(report),
        "modified": modified_parts(folder.assembly),
    }


def _planned(assembly: Any, path: Path, name: str, workshop: Workshop) -> Folder:
    elements = assembly.metadata.get("elements")
    if elements is None:
        raise ScriptError(
            f"{name} shows an assembly that was not made by to_assembly, so nothing is known of "
            "its panels or planks. Show what to_assembly returns."
        )
    progress.report("laying out elements")
    label, holes = assembly.metadata["label"], assembly.metadata["holes"]
    pieces = workpieces(elements, label=label, holes=holes)
    if workshop.only:
        chosen = np.flatnonzero(matching(elements.addresses, workshop.only))
        pieces = tuple(pieces[k] for k in chosen)
        assembly = extract(assembly, [piece.address for piece in pieces])
    progress.report("planning the cuts")
    plan = make_plan(elements, pieces, workshop, None if label is None else label.face)
    by_address = {piece.address: piece for piece in pieces}
    listed = cut_list(pieces, plan.layout)
    return Folder(path, name, workshop, assembly, elements, by_address, plan, listed)


def _solids(folder: Folder) -> None:
    export_step(folder.assembly, folder.path / f"{folder.name}.step")


def _sheets(folder: Folder) -> None:
    export_sheets(folder.plan.layout, folder.assembly, folder.stock)


def _outlines(folder: Folder) -> None:
    sheets = folder.plan.layout.sheets
    for number, sheet in enumerate(sheets):
        progress.report("outlines (DXF)", number, len(sheets))
        export_dxf(sheet, folder.pieces, folder.stock / f"{sheet.name}.dxf")


def _programs(folder: Folder) -> None:
    setup, layout = folder.plan.setup, folder.plan.layout
    if setup is None:
        return
    router, settings = setup.router, setup.settings
    post, machine = router.post, router.machine
    for number, sheet in enumerate(layout.sheets):
        progress.report("programs (G-code)", number, len(layout.sheets))
        program = toolpaths(sheet, setup.pieces, router.tools, machine, settings)
        export_gcode(program, folder.programs / f"{sheet.name}.ngc", post)
        folder.times[sheet.name] = machining_time(program)
    job = Job(layout, setup.pieces, router.tools, machine, settings, post.convention(machine))
    write_job(folder.programs / JOB_FILE, job)


def _verification(folder: Folder) -> None:
    """Read every program back and compare it with the pieces; simulating is left to `verify`."""
    setup, sheets = folder.plan.setup, folder.plan.layout.sheets
    if setup is None:
        return
    job = read_job(folder.programs / JOB_FILE)
    for number, sheet in enumerate(sheets):
        progress.report("verification", number, len(sheets))
        found = verify_file(folder.programs / f"{sheet.name}.ngc", job, simulate=False)
        if not found.ok:
            raise CheckError(
                f"The program that was written for {sheet.name} does not make what was designed, "
                "so nothing was kept. Check the post in the file of tools; with a common one this "
                f"is a mistake of ifs_cad.\n{found}"
            )


def _drawings(folder: Folder) -> None:
    pieces, drawings = tuple(folder.pieces.values()), folder.path / "drawings"
    if folder.plan.boards is None:
        export_sheet_drawings(folder.plan.layout, pieces, drawings / "sheets.pdf")
    else:
        export_board_drawings(folder.plan.boards, pieces, drawings / "boards.pdf")
    export_element_drawings(pieces, drawings / "elements.pdf")


def _btlx(folder: Folder) -> None:
    target = folder.path / f"{folder.name}.btlx"
    export_btlx(tuple(folder.pieces.values()), target, name=folder.name)


def _lists(folder: Folder) -> None:
    lists = folder.path / "lists"
    export_csv(folder.list, lists / "cut_list.csv")
    export_xlsx(folder.list, lists / "cut_list.xlsx")
    if folder.plan.boards is not None:
        planks = plank_list(tuple(folder.pieces.values()))
        export_csv(planks, lists / "planks.csv")
        export_xlsx(planks, lists / "planks.xlsx")
    else:
        cuts = saw_list(tuple(folder.pieces.values()))
        export_csv(cuts, lists / "saw_list.csv")
        export_xlsx(cuts, lists / "saw_list.xlsx")


def _assembly_plan(folder: Folder) -> None:
    export_assembly_plan(
        folder.elements,
        folder.path / "drawings" / "assembly.pdf",
        only=folder.workshop.only or None,
        layout=folder.plan.layout,
    )


def _picture(folder: Folder) -> None:
    render(folder.assembly, folder.picture)


def _overview(folder: Folder) -> None:
    pieces, boards = tuple(folder.pieces.values()), folder.plan.boards
    if boards is None:
        drawings = {sheet.name: sheet_svg(sheet, pieces) for sheet in folder.plan.layout.sheets}
    else:
        drawings = {board.name: board_svg(board, pieces) for board in boards.boards}
    export_overview(
        folder.path / OVERVIEW,
        name=folder.name,
        picture=folder.picture,
        report=str(folder.elements.report()),
        plan=folder.plan,
        cut_list=folder.list,
        workshop=folder.workshop,
        drawings=drawings,
        assembly=assembly_svg(folder.elements, only=folder.workshop.only or None),
        times=folder.times,
    )


MAKERS: dict[str, Callable[[Folder], None]] = {
    "solids (STEP)": _solids,
    "sheets (STEP)": _sheets,
    "outlines (DXF)": _outlines,
    "parts (BTLx)": _btlx,
    "programs (G-code)": _programs,
    "verification": _verification,
    "drawings": _drawings,
    "lists": _lists,
    "assembly plan": _assembly_plan,
    "picture": _picture,
    "overview": _overview,
}
