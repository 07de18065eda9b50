"""Workshop drawings as PDF, and as SVG for pages of the web.

Both formats write down the same pages, see `fabrication.drawing.page`. Nothing in them depends on
the date or the machine, so that the same design always gives the same bytes.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache
from itertools import groupby, pairwise
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

from ifs_cad import progress
from ifs_cad.elements.element import Elements
from ifs_cad.errors import InputError
from ifs_cad.fabrication.assembly_order import assembly_steps
from ifs_cad.fabrication.boards.cutting_plan import CutBoard, CuttingPlan
from ifs_cad.fabrication.congruence import congruent_groups
from ifs_cad.fabrication.cutlist import require_unique
from ifs_cad.fabrication.drawing.drafting import Paper, require_paper
from ifs_cad.fabrication.drawing.draw_assembly import assembly_pages, overview_page
from ifs_cad.fabrication.drawing.draw_board import board_page, board_pages
from ifs_cad.fabrication.drawing.draw_element import element_pages
from ifs_cad.fabrication.drawing.draw_sheet import sheet_page
from ifs_cad.fabrication.drawing.page import Page, Pen, Step, Trace, Words
from ifs_cad.fabrication.layout import Layout, NestedSheet
from ifs_cad.fabrication.workpiece import Workpiece
from ifs_cad.files import replaced
from ifs_cad.libraries import require

_PURPOSE, _EXTRA = "drawings as PDF", "fabrication"
_POINTS = 72 / 25.4  # of a PDF in one mm
_DECIMALS = 2  # of mm on paper, in SVG


def export_sheet_drawings(
    layout: Layout,
    workpieces: Sequence[Workpiece],
    path: str | os.PathLike[str],
    *,
    paper: Paper = "A4",
) -> Path:
    """Write the drawings of all sheets as one PDF, a page for each.

    Parameters
    ----------
    layout : Layout
    workpieces : sequence of Workpiece
        All that the layout places, and maybe more.
    path : path of the file; its folder is made when missing
    paper : "A4" or "A3"

    Returns
    -------
    Path of the written file.

    Raises
    ------
    InputError
        The layout places what is not among the workpieces, or no sheet at all.
    ExportError
        The file could not be written; what stood there before is unchanged.
    MissingLibraryError
        reportlab is not installed.
    """
    require_paper(paper)
    pieces = _by_address(workpieces, layout.homes)
    pages = (sheet_page(sheet, pieces, paper=paper) for sheet in layout.sheets)
    return _write_pdf(pages, len(layout.sheets), path, "Sheets")


def export_element_drawings(
    workpieces: Sequence[Workpiece],
    path: str | os.PathLike[str],
    *,
    tolerance: float = 0.1,
    paper: Paper = "A4",
) -> Path:
    """Write the drawings of all elements as one PDF; equal elements share a page.

    Parameters
    ----------
    workpieces : sequence of Workpiece
    path : path of the file; its folder is made when missing
    tolerance : float, mm, of what is equal, see `fabrication.congruence`
    paper : "A4" or "A3"

    Returns
    -------
    Path of the written file.

    Raises
    ------
    InputError
        No workpieces, or two with one address.
    ExportError
        The file could not be written; what stood there before is unchanged.
    MissingLibraryError
        reportlab is not installed.
    """
    require_paper(paper)
    require_unique(workpieces)
    groups = congruent_groups(workpieces, tolerance)
    pages = (page for group in groups for page in element_pages(workpieces, group, paper=paper))
    return _write_pdf(pages, len(groups), path, "Elements")


def export_board_drawings(
    plan: CuttingPlan,
    workpieces: Sequence[Workpiece],
    path: str | os.PathLike[str],
    *,
    paper: Paper = "A4",
) -> Path:
    """Write the drawings of all boards as one PDF, several boards to a page.

    Parameters
    ----------
    plan : CuttingPlan
    workpieces : the sequence of planks that the plan was made for
    path : path of the file; its folder is made when missing
    paper : "A4" or "A3"

    Returns
    -------
    Path of the written file.

    Raises
    ------
    InputError
        A plan without boards.
    ExportError
        The file could not be written; what stood there before is unchanged.
    MissingLibraryError
        reportlab is not installed.
    """
    require_paper(paper)
    pages = board_pages(plan, workpieces, paper=paper)
    return _write_pdf(pages, len(plan.boards), path, "Boards")


def export_assembly_plan(
    elements: Elements,
    path: str | os.PathLike[str],
    *,
    only: str | Iterable[str] | None = None,
    layout: Layout | None = None,
    paper: Paper = "A4",
) -> Path:
    """Write the order of assembly as one PDF: all steps on a page, then a page for each.

    Parameters
    ----------
    elements : a shell, a vault or a frame
    path : path of the file; its folder is made when missing
    only : address patterns such as "03*", optional
        A partial prototype: only these are put up.
    layout : Layout, optional
        What says from which sheet each element comes.
    paper : "A4" or "A3"

    Returns
    -------
    Path of the written file.

    Raises
    ------
    AddressError
        A pattern matches nothing.
    InputError
        The layout misses what is put up.
    ExportError
        The file could not be written; what stood there before is unchanged.
    MissingLibraryError
        reportlab is not installed.
    """
    require_paper(paper)
    steps = assembly_steps(elements, only)
    pages = assembly_pages(elements, steps, layout, paper=paper)
    return _write_pdf(pages, len(steps) + 1, path, "Assembly")


def assembly_svg(elements: Elements, *, only: str | Iterable[str] | None = None) -> str:
    """Return the drawing that shows the order of all steps as SVG, in mm of paper.

    Raises
    ------
    AddressError
        A pattern matches nothing.
    """
    return _svg(overview_page(elements, assembly_steps(elements, only)))


def sheet_svg(sheet: NestedSheet, workpieces: Sequence[Workpiece], *, paper: Paper = "A4") -> str:
    """Return the drawing of a sheet as SVG, in mm of paper.

    Raises
    ------
    InputError
        The sheet holds what is not among the workpieces.
    """
    pieces = _by_address(workpieces, [placement.address for placement in sheet.placements])
    return _svg(sheet_page(sheet, pieces, paper=paper))


def board_svg(board: CutBoard, workpieces: Sequence[Workpiece]) -> str:
    """Return the drawing of one board as SVG, in mm of paper."""
    return _svg(board_page(board, workpieces))


def _by_address(workpieces: Sequence[Workpiece], needed: Iterable[str]) -> dict[str, Workpiece]:
    pieces = {workpiece.address: workpiece for workpiece in workpieces}
    missing = [address for address in needed if address not in pieces]
    if missing:
        raise InputError(
            f"The layout places {', '.join(missing[:5])}, which is not among the workpieces.",
            addresses=missing,
        )
    return pieces


def _write_pdf(pages: Iterable[Page], count: int, path: str | os.PathLike[str], title: str) -> Path:
    if count == 0:
        raise InputError(f"There is nothing to draw: a PDF of {title.lower()} needs one at least.")
    canvas_module = require("reportlab.pdfgen.canvas", _PURPOSE, _EXTRA)
    target = Path(path)
    with replaced(target) as scratch:
        canvas = canvas_module.Canvas(str(scratch), pageCompression=1, invariant=1)
        canvas.setTitle(title)
        canvas.setCreator("ifs_cad")
        for number, page in enumerate(pages, start=1):
            progress.report(f"drawing {title.lower()}", number, max(number, count))
            canvas.setPageSize((page.width * _POINTS, page.height * _POINTS))
            canvas.bookmarkPage(str(number))
            canvas.addOutlineEntry(page.title, str(number))
            canvas.scale(_POINTS, _POINTS)
            canvas.setLineCap(1)
            canvas.setLineJoin(1)
            _draw(page, canvas)
            canvas.showPage()
        canvas.save()
    return target


def _draw(page: Page, canvas: Any) -> None:
    pen: Pen | None = None
    for mark in page.marks:
        if isinstance(mark, Words):
            _write(mark, canvas)
            pen = None
            continue
        if mark.pen != pen:
            pen = mark.pen
            canvas.setLineWidth(pen.width)
            canvas.setDash(*(pen.dash,) if pen.dash else ())
            canvas.setStrokeColor(_ink(pen.colour))
            if pen.fill:
                canvas.setFillColor(_ink(pen.fill))
        way = canvas.beginPath()
        draw: dict[str, Callable[..., None]] = {
            "M": way.moveTo,
            "L": way.lineTo,
            "C": way.curveTo,
            "Z": way.close,
        }
        for word, numbers in mark.steps:
            draw[word](*numbers)
        canvas.drawPath(way, stroke=int(mark.pen.width > 0.0), fill=int(bool(mark.pen.fill)))


def _write(words: Words, canvas: Any) -> None:
    canvas.setFillColor(_ink(words.colour))
    canvas.setFont("Helvetica-Bold" if words.bold else "Helvetica", words.size)
    put = {
        "start": canvas.drawString,
        "middle": canvas.drawCentredString,
        "end": canvas.drawRightString,
    }[words.anchor]
    if words.turn == 0.0:
        put(words.x, words.y, words.printable)
        return
    canvas.saveState()
    canvas.translate(words.x, words.y)
    canvas.rotate(words.turn)
    put(0.0, 0.0, words.printable)
    canvas.restoreState()


@lru_cache(maxsize=64)
def _ink(colour: str) -> Any:
    return require("reportlab.lib.colors", _PURPOSE, _EXTRA).HexColor(colour)


def _svg(page: Page) -> str:
    """Write a page as SVG: neighbouring marks of one pen share a group."""
    width, height = _short(page.width), _short(page.height)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        f'width="{width}mm" height="{height}mm" font-family="Helvetica,Arial,sans-serif" '
        'stroke-linecap="round" stroke-linejoin="round">',
        f"<title>{escape(page.title)}</title>",
    ]
    for style, marks in groupby(page.marks, key=_style):
        parts.append(f"<g {style}>")
        parts += [
            _svg_words(mark, page.height)
            if isinstance(mark, Words)
            else f'<path d="{_svg_steps(mark.steps, page.height)}"/>'
            for mark in marks
        ]
        parts.append("</g>")
    return "\n".join([*parts, "</svg>"])


def _style(mark: Trace | Words) -> str:
    if isinstance(mark, Words):
        weight = ' font-weight="bold"' if mark.bold else ""
        return f'fill="{mark.colour}" text-anchor="{mark.anchor}"{weight}'
    pen = mark.pen
    dashes = " ".join(map(_short, pen.dash))
    dashed = f' stroke-dasharray="{dashes}"' if pen.dash else ""
    stroke = f'stroke="{pen.colour}" stroke-width="{_short(pen.width)}"' if pen.width else ""
    return f'fill="{pen.fill or "none"}" {stroke}{dashed}'


def _svg_words(words: Words, height: float) -> str:
    x, y = _short(words.x), _short(height - words.y)
    turn = f' transform="rotate({_short(-words.turn)} {x} {y})"' if words.turn else ""
    return (
        f'<text x="{x}" y="{y}" font-size="{_short(words.size)}"{turn}>'
        f"{escape(words.printable)}</text>"
    )


def _svg_steps(steps: Sequence[Step], height: float) -> str:
    """Write a trace in steps from point to point, which are short numbers.

    Points are rounded before their differences are taken, so that errors do not add up.
    """
    words = []
    here = start = (0, 0)  # in hundredths of a mm, y down
    for letter, numbers in steps:
        units = [round(n * 10**_DECIMALS) for n in _flipped(numbers, height)]
        points = list(zip(units[::2], units[1::2], strict=True))
        words.append(letter.lower())
        for x, y in points:
            words += [_hundredths(x - here[0]), _hundredths(y - here[1])]
        here = points[-1] if points else start
        if letter == "M":
            start = here
    text = "".join(
        word if last.isalpha() or word.isalpha() or word[0] == "-" else f" {word}"
        for last, word in pairwise(["m", *words])
    )
    return text.replace("m", "M", 1)


def _flipped(numbers: Sequence[float], height: float) -> list[float]:
    return [height - n if place % 2 else n for place, n in enumerate(numbers)]


def _hundredths(number: int) -> str:
    return _short(number / 10**_DECIMALS)


def _short(number: float) -> str:
    """Return a number with two decimals and nothing that could be left out."""
    text = f"{number:.{_DECIMALS}f}".rstrip("0").rstrip(".")
    if text in ("-0", ""):
        return "0"
    return text.replace("0.", ".", 1) if text.startswith(("0.", "-0.")) else text
