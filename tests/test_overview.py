"""The overview page: parsed by another's parser, and opened in a browser."""

import base64
import struct
import zlib
from dataclasses import replace
from html.parser import HTMLParser
from urllib.parse import unquote

import numpy as np
import pytest
import vaults
from layouts import STOCK, in_rows

from ifs_cad.design.curve import Curve
from ifs_cad.elements.vault import vault
from ifs_cad.errors import ExportError, InputError
from ifs_cad.export.drawing import assembly_svg, board_svg, sheet_svg
from ifs_cad.export.overview import export_overview
from ifs_cad.fabrication.cutlist import cut_list
from ifs_cad.fabrication.operations import workpieces
from ifs_cad.fabrication.plan import Plan, make_plan
from ifs_cad.fabrication.workshop import Workshop

NASTY = "</title><script>alert('1')</script> \"&amp;\x07"
SHOWN = NASTY.replace("\x07", " ")
VOID = {"meta", "img", "input"}


TIMES = "\N{MULTIPLICATION SIGN}"


class Page(HTMLParser):
    """What a parser finds: elements with their attributes and text, and whether they nest."""

    def __init__(self, text):
        super().__init__()
        self.open, self.found = [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        element = {"tag": tag, "text": "", **dict(attributes)}
        self.found.append(element)
        if tag not in VOID:
            self.open.append(element)

    def handle_startendtag(self, tag, attributes):
        self.found.append({"tag": tag, "text": "", **dict(attributes)})

    def handle_endtag(self, tag):
        assert self.open.pop()["tag"] == tag

    def handle_data(self, data):
        for element in self.open:
            element["text"] += data

    def all(self, tag, **attributes):
        return [
            element
            for element in self.found
            if element["tag"] == tag
            and all(element.get(key.strip("_")) == value for key, value in attributes.items())
        ]

    def section(self, name):
        """The elements between the beginning of a section and the next one."""
        start = next(k for k, e in enumerate(self.found) if e.get("id") == name)
        rest = self.found[start + 1 :]
        end = next((k for k, e in enumerate(rest) if e["tag"] in ("section", "footer")), None)
        part = Page("")
        part.found = rest[:end]
        return part


def png(colour):
    """A picture of one pixel."""

    def chunk(kind, data):
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    header = struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(b"\0" + bytes(colour)))
        + chunk(b"IEND", b"")
    )


def shell_arguments(folder, name="dome"):
    """All that a page of a shell of 16 panels shows, with names that would break a page."""
    shell = vaults.vault(2)
    names = {"11": "<b>&\"'", "12": "1e10"}
    mesh = shell.mesh.with_addresses(names.get(a, a) for a in shell.addresses)
    shell = shell.thickening(mesh)
    pieces = workpieces(shell)
    layout = in_rows(pieces, replace(STOCK, name="ply <9> & more", length=1200.0, price=40.0))
    picture = folder / "dome.png"
    picture.write_bytes(png((200, 150, 100)))
    return {
        "name": name,
        "picture": picture,
        "report": f"{shell.report()}\nand <i>this</i>",
        "plan": Plan(layout),
        "cut_list": cut_list(pieces, layout),
        "workshop": Workshop(only=("<0*>",)),
        "drawings": {sheet.name: sheet_svg(sheet, pieces) for sheet in layout.sheets},
        "assembly": assembly_svg(shell),
    }


def vault_arguments(folder):
    planks = vault(
        Curve([(0, 0, 0), (0, 0, 2000), (3000, 0, 2000), (3000, 0, 0)], depth=3),
        150.0,
        27.0,
        layers=4,
        stagger=True,
    )
    pieces, shop = workpieces(planks), Workshop(kerf=5.0)
    plan = make_plan(planks, pieces, shop)
    picture = folder / "vault.png"
    picture.write_bytes(png((1, 2, 3)))
    return {
        "name": "vault",
        "picture": picture,
        "report": str(planks.report()),
        "plan": plan,
        "cut_list": cut_list(pieces, plan.layout),
        "workshop": shop,
        "drawings": {board.name: board_svg(board, pieces) for board in plan.boards.boards},
    }


@pytest.fixture
def folder(tmp_path):
    """A folder with files, one of a name that no link could hold as it is."""
    for name in (
        "sheets/sheet-01.step",
        "sheets/sheet-01.dxf",
        "drawings/assembly.pdf",
        "lists/a b#c?%<d>.csv",
        "lists/.hidden",
        "x:y.step",
    ):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(b"x" * 2345)
    return tmp_path


def page_of(path):
    return Page(path.read_text(encoding="utf-8"))


@pytest.mark.parametrize("arguments", [shell_arguments, vault_arguments])
def test_the_page_needs_nothing_from_elsewhere(arguments, folder):
    path = export_overview(folder / "index.html", **arguments(folder))
    page = page_of(path)
    targets = {element["id"] for element in page.found if "id" in element}
    assert len(targets) == sum("id" in element for element in page.found)
    for element in page.found:
        assert not {"srcset", "action", "xlink:href", "data", "poster"} & element.keys()
        assert not any(key.startswith("on") for key in element)
        if "src" in element:
            assert element["src"].startswith("data:image/png;base64,")
        link = element.get("href", "#design")
        if link.startswith("#"):
            assert link[1:] in targets
        else:
            assert element["tag"] == "a"
            assert (folder / unquote(link.removeprefix("./"))).is_file()
    assert {"link", "iframe", "object", "base"}.isdisjoint({e["tag"] for e in page.found})
    styles = page.all("style")[0]["text"] + page.all("script")[0]["text"]
    assert "url(" not in styles
    assert "http" not in path.read_text(encoding="utf-8").replace("http-equiv", "")
    (policy,) = page.all("meta", **{"http-equiv": "Content-Security-Policy"})
    assert policy["content"].startswith("default-src 'none'; img-src data:;")


def test_names_stay_text_whatever_they_hold(folder):
    page = page_of(export_overview(folder / "i.html", **shell_arguments(folder, name=NASTY)))
    assert len(page.all("script")) == 1
    assert page.all("i", text="this") == []
    assert page.all("title")[0]["text"] == SHOWN
    assert page.all("h1")[0]["text"] == SHOWN
    (picture,) = page.all("img")
    assert picture["alt"] == f"{SHOWN}, all elements in place"
    texts = [element["text"] for element in page.all("td")]
    assert "and <i>this</i>" in texts
    assert "ply <9> & more" in texts
    assert "<0*>" in texts


def test_the_cut_list_holds_every_element_in_order(folder):
    arguments = shell_arguments(folder)
    page = page_of(export_overview(folder / "i.html", **arguments))
    entries = arguments["cut_list"].entries
    part = page.section("cut-list")
    rows = part.all("tr")[1:]
    assert [head["text"] for head in part.all("th", scope="row")] == [e.address for e in entries]
    assert "<b>&\"'" in [e.address for e in entries]
    numbers = [cell["text"] for cell in part.all("td", class_="number")]
    wanted = [
        text
        for e in entries
        for text in (
            str(e.group),
            f"{e.x:.1f}",
            f"{e.y:.1f}",
            f"{e.turn:.1f}",
            f"{e.area / 1e6:.4f}",
            f"{e.mass:.3f}",
        )
    ]
    assert numbers == wanted
    assert [cell["text"] for cell in part.all("a")] == [e.sheet for e in entries]
    for row, entry in zip(rows, entries, strict=True):
        for edge in entry.edges:
            inclination = f"{edge.inclination:.2f}".replace("-0.00", "0.00")
            beyond = edge.neighbour or edge.kind
            assert f"{edge.upper:.1f} ∠ {inclination}° | {beyond}" in row["text"]


def test_sheets_are_listed_drawn_and_linked(folder):
    arguments = shell_arguments(folder)
    page = page_of(export_overview(folder / "i.html", **arguments))
    sheets = arguments["plan"].layout.sheets
    assert len(sheets) > 1
    listed = page.section("stock")
    bought, *rows = [row["text"] for row in listed.all("tr") if "ply" in row["text"]]
    assert (
        bought == f"ply <9> & more1200 {TIMES} 1250 {TIMES} 10{len(sheets)}{40 * len(sheets):.2f}"
    )
    for sheet, row in zip(sheets, rows, strict=True):
        assert row.startswith(sheet.name)
        assert f"{len(sheet.placements)}{sheet.utilisation:.1%}" in row
        assert f"{sheet.offcuts[0, 2]:.0f} {TIMES} {sheet.offcuts[0, 3]:.0f}" in row
    assert rows[0].endswith("DXF STEP")
    figures = page.section("drawings").all("figure")
    assert [figure["id"] for figure in figures] == [sheet.name for sheet in sheets]
    for sheet, figure in zip(sheets, figures, strict=True):
        assert all(place.address in figure["text"] for place in sheet.placements)
    used = [float(meter["value"]) for meter in listed.all("meter")]
    np.testing.assert_allclose(used, [sheet.utilisation for sheet in sheets], atol=5e-5)


def test_files_are_listed_with_what_they_are(folder):
    page = page_of(export_overview(folder / "i.html", **shell_arguments(folder)))
    links = [link["text"] for link in page.section("files").all("a")]
    assert links == [
        "dome.png",
        "drawings/assembly.pdf",
        "lists/a b#c?%<d>.csv",
        "sheets/sheet-01.dxf",
        "sheets/sheet-01.step",
        "x:y.step",
    ]
    rows = [row["text"] for row in page.section("files").all("tr")]
    assert rows[2] == "drawings/assembly.pdfwhat is put up when, step by step2 kB"
    chosen = export_overview(folder / "i.html", **shell_arguments(folder), files=["x:y.step"])
    assert [a["text"] for a in page_of(chosen).section("files").all("a")] == ["x:y.step"]


def test_a_vault_shows_boards_to_buy_waste_and_bound(folder):
    arguments = vault_arguments(folder)
    page = page_of(export_overview(folder / "i.html", **arguments))
    plan = arguments["plan"].boards
    part = page.section("stock")
    (said,) = (p["text"] for p in part.all("p"))
    assert f"cut from {len(plan.boards)} boards; {plan.waste:.1%} is waste" in said
    assert "5 mm at each cut" in said
    assert plan.optimal
    assert "it is proven that none does with less" in said
    rows = [row["text"] for row in part.all("tr")]
    for stock, count in plan.bought:
        size = f"{stock.length:g} {TIMES} {stock.width:g} {TIMES} {stock.thickness:g}"
        assert any(row.startswith(f"{stock.name}{size}{count}") for row in rows)
    figures = page.section("drawings").all("figure")
    assert [figure["id"] for figure in figures] == [board.name for board in plan.boards]
    assert page.all("section", id="assembly") == []
    assert page.all("a", href="#assembly") == []


def test_a_plan_that_is_not_proven_says_how_much_could_be_saved(folder):
    arguments = vault_arguments(folder)
    boards = arguments["plan"].boards
    open_plan = replace(boards, bound=0.9 * boards.cost, optimal=False)
    arguments["plan"] = replace(arguments["plan"], boards=open_plan)
    page = page_of(export_overview(folder / "i.html", **arguments))
    (said,) = (p["text"] for p in page.section("stock").all("p"))
    assert f"less than {0.9 * boards.cost / 1000:.2f} m of board" in said
    assert "at most 10.0% could be saved" in said


def test_the_picture_is_within_the_page(folder):
    page = page_of(export_overview(folder / "i.html", **shell_arguments(folder)))
    (picture,) = page.all("img")
    coded = picture["src"].removeprefix("data:image/png;base64,")
    assert base64.b64decode(coded, validate=True) == png((200, 150, 100))


def test_two_runs_give_the_same_bytes(folder):
    arguments = shell_arguments(folder)
    one = export_overview(folder / "i.html", **arguments).read_bytes()
    assert export_overview(folder / "i.html", **arguments).read_bytes() == one


def test_a_picture_that_is_none_leaves_the_former_page(folder):
    arguments = shell_arguments(folder)
    path = export_overview(folder / "i.html", **arguments)
    before = path.read_bytes()
    (folder / "dome.png").write_bytes(b"GIF89a")
    with pytest.raises(InputError, match="is no PNG"):
        export_overview(path, **arguments)
    (folder / "dome.png").unlink()
    with pytest.raises(ExportError, match="Cannot read the picture"):
        export_overview(path, **arguments)
    assert path.read_bytes() == before


@pytest.fixture
def opened(browser, folder):
    """The page in a browser, and all that it complains of or asks for."""
    path = export_overview(folder / "index.html", **shell_arguments(folder, name=NASTY))
    page = browser.new_page(viewport={"width": 1200, "height": 800})
    heard = []
    page.on("console", lambda message: heard.append(message.text))
    page.on("pageerror", lambda error: heard.append(str(error)))
    page.on("dialog", lambda dialog: heard.append(dialog.message))
    page.on("request", lambda request: heard.append(request.url))
    page.goto(path.as_uri())
    yield page
    assert [text for text in heard if not text.startswith(("data:image/png", path.as_uri()))] == []
    page.close()


def shown_rows(page):
    return page.locator("#cut-list tbody tr:visible th").all_inner_texts()


@pytest.mark.browser
def test_the_cut_list_is_searched_and_sorted_in_a_browser(opened, folder):
    everything = shown_rows(opened)
    assert len(everything) == 16
    opened.fill("#search", "1E10 Sheet-0")
    found = shown_rows(opened)
    entries = shell_arguments(folder)["cut_list"].entries
    beside = [e.address for e in entries if "1e10" in {edge.neighbour for edge in e.edges}]
    assert sorted(found) == sorted(["1e10", *beside])
    assert opened.inner_text(".search output") == f"{len(found)} of 16"
    opened.fill("#search", "")
    assert shown_rows(opened) == everything
    head = opened.locator("#cut-list th", has_text="mass")
    masses = opened.locator("#cut-list tbody tr td:nth-child(8)")
    given = [float(text) for text in masses.all_inner_texts()]
    assert given != sorted(given)
    for sense, wanted in (("ascending", sorted(given)), ("descending", sorted(given)[::-1])):
        head.locator("button").press("Enter")
        assert head.get_attribute("aria-sort") == sense
        assert [float(text) for text in masses.all_inner_texts()] == wanted


@pytest.mark.browser
@pytest.mark.parametrize("width", [1200, 400])
def test_the_page_is_as_wide_as_its_window(opened, width):
    opened.set_viewport_size({"width": width, "height": 800})
    assert opened.evaluate("document.documentElement.scrollWidth") == width
    picture = opened.locator("img")
    assert picture.evaluate("image => image.naturalWidth") == 1


@pytest.mark.browser
def test_the_list_is_whole_without_script(browser, folder):
    path = export_overview(folder / "index.html", **shell_arguments(folder))
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(path.as_uri())
    assert page.locator("#cut-list tbody tr:visible").count() == 16
    assert not page.locator(".search").is_visible()
    context.close()
