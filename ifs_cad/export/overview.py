"""The overview of a folder as one page of HTML.

The page holds all it shows: the picture, the drawings, the style and a few lines of script; it asks
nothing of any network, and a policy within it forbids that. Without the script it is complete. Only
its links to the files of the folder lead elsewhere, by relative paths. Nothing in it depends on the
date or the machine.
"""

from __future__ import annotations

import base64
import os
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from fnmatch import fnmatchcase
from html import escape
from importlib.resources import files as resources
from pathlib import Path, PurePosixPath
from urllib.parse import quote

from ifs_cad.errors import ExportError, InputError
from ifs_cad.fabrication.boards.cutting_plan import CuttingPlan
from ifs_cad.fabrication.cutlist import CutList, Edge, Entry
from ifs_cad.fabrication.layout import NestedSheet
from ifs_cad.fabrication.machining.machine_time import MachineTime, hours
from ifs_cad.fabrication.plan import Plan
from ifs_cad.fabrication.workshop import Workshop
from ifs_cad.files import replaced

_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'"
_FORMATS = {".step": "STEP", ".dxf": "DXF", ".btlx": "BTLx", ".ngc": "G-code"}
_CONTENTS = (
    ("sheets/*.step", "the pieces as they lie on the sheet or board, marked face up"),
    ("sheets/*.dxf", "outlines, holes, engraving and chamfer angles of a sheet or board"),
    ("programs/*.ngc", "the program of a sheet: pierce, engrave, cut the contours"),
    ("programs/job.json", "what the programs are verified against"),
    ("drawings/sheets.pdf", "a drawing of every sheet"),
    ("drawings/boards.pdf", "a drawing of every board"),
    ("drawings/elements.pdf", "a drawing of every kind of element, with all its measures"),
    ("drawings/assembly.pdf", "what is put up when, step by step"),
    ("lists/cut_list.*", "every element: measures, neighbours, place on its sheet or board"),
    ("lists/planks.*", "planks by what the saw is set to"),
    ("lists/saw_list.*", "chamfers for a saw, where the router has upright tools only"),
    ("*/*", ""),
    ("*.step", "all elements in place, exact"),
    ("*.png", "the picture above"),
)
_FOR_SHEETS = (
    ("visible", "face that is seen", ""),
    ("gap", "wood left between two cuts", " mm"),
    ("margin", "kept free along the edge of sheets", " mm"),
    ("method", "way of nesting", ""),
)
_FOR_BOARDS = (
    ("kerf", "width of the saw cut", " mm"),
    ("trim", "cut off each end of a board", " mm"),
)


def export_overview(
    path: str | os.PathLike[str],
    *,
    name: str,
    picture: str | os.PathLike[str],
    report: str,
    plan: Plan,
    cut_list: CutList,
    workshop: Workshop,
    drawings: Mapping[str, str],
    assembly: str = "",
    times: Mapping[str, MachineTime] | None = None,
    files: Iterable[str] | None = None,
) -> Path:
    """Write the overview of a folder.

    Parameters
    ----------
    path : path of the page; its folder is made when missing
    name : str, of the design
    picture : path of a PNG
    report : str, of the design: lines of a name, two spaces or more, and what there is to say
    plan : Plan
    cut_list : CutList
    workshop : Workshop
    drawings : SVG of each sheet or board, by its name; those it lacks are not drawn
    assembly : SVG of the order of assembly, optional
    times : how long the program of each sheet takes, by its name, optional
    files : paths of what to link to, relative to the page's folder, with "/" between their parts;
        by default all that the folder holds

    Returns
    -------
    Path of the written page.

    Raises
    ------
    InputError
        The picture is no PNG.
    ExportError
        The picture cannot be read, or the page not be written; what stood there is unchanged.
    """
    target = Path(path)
    linked = _found(target) if files is None else [*files]
    image = _picture(Path(picture), name)
    parts = [
        _header(name, plan, cut_list, bool(assembly), times or {}),
        "<main>",
        f'<section id="design"><h2>Design</h2><div class="pair">{image}{_report(report)}</div>'
        "</section>",
        _stock(plan, linked, times or {}),
        _drawings(plan, drawings),
        _assembly(assembly, linked),
        _cut_list(cut_list, plan),
        _settings(workshop, plan),
        _files(linked, target.parent),
        "</main>",
        "<footer>Lengths in mm, angles in degrees. Checksums of all files are in the manifest."
        "</footer>",
    ]
    html = (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{_text(name)}</title>\n"
        f"<style>\n{_resource('overview.css')}</style>\n</head>\n<body>\n"
        + "\n".join(parts)
        + f"\n<script>\n{_resource('overview.js')}</script>\n</body>\n</html>\n"
    )
    with replaced(target) as scratch:
        scratch.write_text(html, encoding="utf-8", newline="\n")
    return target


def _header(
    name: str, plan: Plan, cut_list: CutList, with_assembly: bool, times: Mapping[str, MachineTime]
) -> str:
    entries = cut_list.entries
    stacks = sorted({(entry.thickness, entry.material) for entry in entries})
    facts = [
        ("elements", f"{len(entries)}"),
        ("different", f"{len(cut_list.groups)}"),
        ("mass", f"{sum(entry.mass for entry in entries):.1f} kg"),
        ("material", ", ".join(f"{thickness:g} mm {material}" for thickness, material in stacks)),
    ]
    if plan.boards is None:
        facts.append(("sheets", f"{len(plan.layout.sheets)}"))
        facts.append(("used of the sheets", f"{plan.layout.utilisation:.1%}"))
        if times:
            total = MachineTime.total(times.values())
            facts.append(("machining", f"{hours(total.seconds)} h"))
            facts.append(("tool changes", f"{total.tool_changes}"))
            facts.append(("stops for a person", f"{total.stops}, not in the time"))
    else:
        facts.append(("boards", f"{len(plan.boards.boards)}"))
        facts.append(("waste", f"{plan.boards.waste:.1%}"))
    stock = plan.kind
    links = [
        ("design", "Design"),
        ("stock", stock.capitalize()),
        ("drawings", "Drawings"),
        *([("assembly", "Assembly")] if with_assembly else []),
        ("cut-list", "Cut list"),
        ("settings", "Settings"),
        ("files", "Files"),
    ]
    items = "".join(f'<li><a href="#{place}">{title}</a></li>' for place, title in links)
    cards = "".join(f"<div><dt>{_text(k)}</dt><dd>{_text(v)}</dd></div>" for k, v in facts)
    return (
        f'<nav aria-label="Parts of this page"><ul>{items}</ul></nav>\n'
        f'<header><h1>{_text(name)}</h1><dl class="facts">{cards}</dl></header>'
    )


def _picture(path: Path, name: str) -> str:
    try:
        content = path.read_bytes()
    except OSError as error:
        raise ExportError(f"Cannot read the picture {path}: {error.strerror}.") from error
    if not content.startswith(b"\x89PNG"):
        raise InputError(f"{path} is no PNG, which the picture of an overview must be.")
    coded = base64.b64encode(content).decode("ascii")
    return (
        f'<img class="picture" alt="{_text(name)}, all elements in place" '
        f'src="data:image/png;base64,{coded}">'
    )


def _report(report: str) -> str:
    rows = []
    for line in report.splitlines():
        parted = re.match(r"(\S.*?)\s{2,}(.*)", line)
        if parted:
            head, said = parted.groups()
            rows.append(f'<tr><th scope="row">{_text(head)}</th><td>{_text(said)}</td></tr>')
        elif line.strip():
            rows.append(f"<tr><th></th><td>{_text(line.strip())}</td></tr>")
    return _table("Report", (), rows)


def _stock(plan: Plan, linked: Sequence[str], times: Mapping[str, MachineTime]) -> str:
    kind = plan.kind
    made: dict[str, list[str]] = {}
    for file in linked:
        place = PurePosixPath(file)
        if place.suffix in _FORMATS and str(place.parent) in (kind, "programs"):
            made.setdefault(place.stem, []).append(file)
    rows = []
    for sheet in plan.layout.sheets:
        links = " ".join(
            f'<a href="{_link(file)}">{_FORMATS[PurePosixPath(file).suffix]}</a>'
            for file in made.get(sheet.name, ())
        )
        offcuts = ", ".join(f"{x:.0f} &times; {y:.0f}" for x, y in sheet.offcuts[:, 2:]) or "none"
        rows.append(
            f'<tr><th scope="row"><a href="#{sheet.name}">{sheet.name}</a></th>'
            f"<td>{_text(sheet.stock.name)}</td>"
            f'<td class="number">{sheet.stock.length:g} &times; {sheet.stock.width:g}</td>'
            f'<td class="number">{len(sheet.placements)}</td>'
            f'<td class="number"><meter min="0" max="1" value="{sheet.utilisation:.4f}"></meter>'
            f"{sheet.utilisation:.1%}</td>"
            f"<td>{offcuts}</td>"
            + (_time(times[sheet.name]) if times else "")
            + f"<td>{links}</td></tr>"
        )
    timed = ("time (h)#", "tool changes#", "stops#") if times else ()
    heads = (
        kind[:-1],
        "stock",
        "size (mm)#",
        "pieces#",
        "used#",
        "left over (mm)",
        *timed,
        "files",
    )
    return (
        f'<section id="stock"><h2>{kind.capitalize()}</h2>{_bought(plan)}'
        f"{_table(f'All {kind}', heads, rows)}</section>"
    )


def _time(time: MachineTime) -> str:
    return (
        f'<td class="number">{hours(time.seconds)}</td><td class="number">{time.tool_changes}</td>'
        f'<td class="number">{time.stops}</td>'
    )


def _bought(plan: Plan) -> str:
    """Return what to buy, and how good the plan is."""
    counts = Counter(sheet.stock for sheet in plan.layout.sheets)
    priced = any(stock.price is not None for stock in counts)
    rows = [
        f'<tr><th scope="row">{_text(stock.name)}</th><td class="number">'
        f"{stock.length:g} &times; {stock.width:g} &times; {stock.thickness:g}</td>"
        f'<td class="number">{count}</td>'
        + (f'<td class="number">{_price(stock.price, count)}</td>' if priced else "")
        + "</tr>"
        for stock, count in counts.items()
    ]
    said = f"{plan.layout}." if plan.boards is None else _cutting(plan.boards)
    heads = ("stock", "size (mm)#", "count#", *(("price#",) if priced else ()))
    return f"<p>{_text(said)}</p>{_table('To buy', heads, rows)}"


def _cutting(plan: CuttingPlan) -> str:
    def shown(cost: float) -> str:
        return f"{cost:.2f}" if plan.priced else f"{cost / 1000:.2f} m of board"

    proof = (
        "it is proven that none does with less"
        if plan.optimal
        else f"none does with less than {shown(plan.bound)}, so that at most {plan.gap:.1%} could "
        "be saved"
    )
    return (
        f"{len(plan.lengths)} pieces, {sum(plan.lengths) / 1000:.2f} m in all, are cut from "
        f"{len(plan.boards)} boards; {plan.waste:.1%} is waste. The plan takes {shown(plan.cost)}; "
        f"{proof}. The saw takes {plan.kerf:g} mm at each cut, and {plan.trim:g} mm are trimmed "
        "off each end."
    )


def _drawings(plan: Plan, drawings: Mapping[str, str]) -> str:
    figures = [
        f'<figure id="{sheet.name}"><figcaption><strong>{sheet.name}</strong> '
        f"{_text(_caption(sheet))}</figcaption>{_inline(drawings.get(sheet.name, ''))}</figure>"
        for sheet in plan.layout.sheets
    ]
    return f'<section id="drawings"><h2>Drawings</h2>{"".join(figures)}</section>'


def _caption(sheet: NestedSheet) -> str:
    return f"{sheet.stock.name}, {len(sheet.placements)} pieces, {sheet.utilisation:.1%} used"


def _assembly(drawing: str, linked: Sequence[str]) -> str:
    if not drawing:
        return ""
    steps = [file for file in linked if fnmatchcase(file, "*assembly.pdf")]
    more = "".join(f' Every step is drawn in <a href="{_link(f)}">{_text(f)}</a>.' for f in steps)
    return (
        f'<section id="assembly"><h2>Assembly</h2><p>From light to dark in the order in which '
        f"it is put up.{more}</p><figure>{_inline(drawing)}</figure></section>"
    )


def _cut_list(cut_list: CutList, plan: Plan) -> str:
    measures = ("x#", "y#", "turn#", "area (m2)#", "mass (kg)#")
    heads = ("address", "group#", plan.kind[:-1], *measures, "edges")
    rows = map(_row, cut_list.entries)
    return (
        '<section id="cut-list"><h2>Cut list</h2>'
        "<p>Elements of one group are equal. Each edge is given by its length on the upper face, "
        "its inclination (positive where the element is wider at its top) and its neighbour.</p>"
        '<form class="search" role="search" hidden><label for="search">Search</label>'
        '<input id="search" type="search" placeholder="address, neighbour, sheet ..." '
        'autocomplete="off"><output for="search" aria-live="polite"></output></form>'
        f"{_table(f'{len(cut_list.entries)} elements', heads, rows)}</section>"
    )


def _row(entry: Entry) -> str:
    numbers = (
        f"{entry.x:.1f}" if entry.x is not None else "",
        f"{entry.y:.1f}" if entry.y is not None else "",
        f"{entry.turn:.1f}" if entry.turn is not None else "",
        f"{entry.area / 1e6:.4f}",
        f"{entry.mass:.3f}",
    )
    return (
        f'<tr><th scope="row">{_text(entry.address)}</th><td class="number">{entry.group}</td>'
        f'<td class="name"><a href="#{entry.sheet}">{entry.sheet}</a></td>'
        + "".join(f'<td class="number">{number}</td>' for number in numbers)
        + f'<td class="edges">{"".join(map(_edge, entry.edges))}</td></tr>'
    )


def _edge(edge: Edge) -> str:
    inclination = f"{edge.inclination:.2f}".replace("-0.00", "0.00")
    beyond = _text(edge.neighbour) if edge.neighbour else f"<i>{_text(edge.kind)}</i>"
    return f"<span>{edge.upper:.1f} <i>∠</i> {inclination}° <i>|</i> {beyond}</span>"


def _settings(workshop: Workshop, plan: Plan) -> str:
    used = _FOR_SHEETS if plan.boards is None else _FOR_BOARDS
    values = workshop.as_dict()
    shown = [
        ("file of stock", Path(workshop.stock).name if workshop.stock else "none, common sizes"),
        ("stock to use", ", ".join(workshop.use) or "all that fits"),
        ("elements to make", ", ".join(workshop.only) or "all"),
        *_router(plan, workshop),
        *((said, _value(values[key], unit)) for key, said, unit in used),
    ]
    rows = [
        f'<tr><th scope="row">{_text(key)}</th><td>{_text(value)}</td></tr>' for key, value in shown
    ]
    return (
        '<section id="settings"><h2>Settings</h2>'
        f"{_table('What the workshop decided', (), rows)}</section>"
    )


def _router(plan: Plan, workshop: Workshop) -> list[tuple[str, str]]:
    """Return what the router is set to, or what sheets are nested for without programs."""
    setup = plan.setup
    if setup is None:
        return [("diameter of the contour cutter", _value(workshop.cutter, " mm"))]
    return [
        ("file of tools", Path(workshop.tools).name if workshop.tools else "none, common tools"),
        ("router", f"{setup.router.machine.name}, {setup.router.post.name}"),
        ("contours", str(setup.mill)),
        ("what holds the pieces", str(setup.settings)),
        ("how far contours reach below the sheet", f"{setup.settings.breakthrough:g} mm"),
    ]


def _files(linked: Sequence[str], folder: Path) -> str:
    rows = [
        f'<tr><th scope="row"><a href="{_link(file)}">{_text(file)}</a></th>'
        f'<td>{_content(file)}</td><td class="number">{_size(folder / file)}</td></tr>'
        for file in linked
    ]
    heads = ("file", "what it is", "size#")
    return (
        '<section id="files"><h2>Files</h2>'
        f"{_table('What this folder holds', heads, rows)}</section>"
    )


def _table(caption: str, heads: Sequence[str], rows: Iterable[str]) -> str:
    """Return a table of rows; a head that ends in "#" stands over numbers."""
    cells = "".join(
        f'<th scope="col" class="number">{head[:-1]}</th>'
        if head.endswith("#")
        else f'<th scope="col">{head}</th>'
        for head in heads
    )
    head = f"<thead><tr>{cells}</tr></thead>" if cells else ""
    body = "\n".join(rows)
    return (
        f'<div class="scroll" role="region" aria-label="{caption}" tabindex="0"><table>'
        f"<caption>{caption}</caption>{head}<tbody>\n{body}\n</tbody></table></div>"
    )


def _text(text: str) -> str:
    """Return a text that no markup can hide in."""
    return escape("".join(letter if letter.isprintable() else " " for letter in text), quote=True)


def _link(file: str) -> str:
    """Return the relative address of a file."""
    # the dot keeps a name with a colon from being read as a scheme
    return escape("./" + quote(file), quote=True)


def _inline(svg: str) -> str:
    """Return an SVG for use within HTML, which knows its name space."""
    return svg.replace(' xmlns="http://www.w3.org/2000/svg"', ' role="img"', 1)


def _price(price: float | None, count: int) -> str:
    return "" if price is None else f"{price * count:.2f}"


def _value(value: object, unit: str) -> str:
    if value is None:
        return "not said"
    return f"{value:g}{unit}" if isinstance(value, float) else str(value)


def _content(file: str) -> str:
    return next((said for pattern, said in _CONTENTS if fnmatchcase(file, pattern)), "")


def _size(path: Path) -> str:
    if not path.is_file():
        return ""
    size = path.stat().st_size
    return f"{size / 1e6:.1f} MB" if size >= 1e6 else f"{max(1, round(size / 1e3))} kB"


def _found(target: Path) -> list[str]:
    """Return the files of the folder beside the page, less hidden ones."""
    folder = target.parent
    paths = (path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    return sorted(
        path.as_posix()
        for path in paths
        if path.as_posix() != target.name and not any(p.startswith(".") for p in path.parts)
    )


def _resource(name: str) -> str:
    return resources("ifs_cad.export").joinpath(name).read_text(encoding="utf-8")
