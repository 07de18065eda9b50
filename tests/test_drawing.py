"""Drawings, read back from PDF and SVG by libraries that did not write them."""

import math
import re
import sys
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from handmade import box, plank, polygon_piece, turned
from hypothesis import given
from hypothesis import strategies as st
from pypdf import PdfReader
from reportlab.pdfbase.pdfmetrics import stringWidth

from ifs_cad.design.curve import Curve
from ifs_cad.design.surface import vector_sum
from ifs_cad.elements.arcs import Path
from ifs_cad.elements.hole import Holes
from ifs_cad.elements.label import Label
from ifs_cad.elements.thicken import thicken
from ifs_cad.errors import ExportError, InputError, MissingLibraryError
from ifs_cad.export.drawing import (
    board_svg,
    export_board_drawings,
    export_element_drawings,
    export_sheet_drawings,
    sheet_svg,
)
from ifs_cad.fabrication.boards.cutting_plan import cut_boards
from ifs_cad.fabrication.drawing.drafting import hatch, scale_name, standard_scale, write_beside
from ifs_cad.fabrication.drawing.page import PIERCED, STOCK, UPPER, WOOD, Page, text_width
from ifs_cad.fabrication.layout import Layout, NestedSheet, Placement
from ifs_cad.fabrication.operations import workpieces
from ifs_cad.fabrication.stock import Board, Sheet
from ifs_cad.fabrication.workpiece import Drill, Engraving
from ifs_cad.types import Plane

SVG = "{http://www.w3.org/2000/svg}"
NUMBER = re.compile(r"-?(?:\d+\.?\d*|\.\d+)")


def read_steps(text):
    """Absolute steps of a path, as SVG reads them: the first M absolute, all else relative."""
    steps, here, start = [], np.zeros(2), np.zeros(2)
    for letter, tail in re.findall(r"([MmLlCcZz])([^A-Za-z]*)", text):
        points = np.array([float(n) for n in NUMBER.findall(tail)]).reshape(-1, 2)
        if letter in "Zz":
            here = start
            steps.append(("Z", points))
            continue
        if letter.islower():
            points = points + here
        here = points[-1]
        if letter in "Mm":
            start = here
        steps.append((letter.upper(), points))
    return steps


def paths_of(svg, colour, width, fill="none"):
    """The paths that one pen drew."""
    root = ElementTree.fromstring(svg)
    return [
        read_steps(path.get("d"))
        for group in root.iter(f"{SVG}g")
        if (group.get("stroke"), group.get("stroke-width"), group.get("fill"))
        == (colour, width, fill)
        and group.get("stroke-dasharray") is None
        for path in group.iter(f"{SVG}path")
    ]


def drawn_with(svg, pen):
    width = f"{pen.width:g}".removeprefix("0")
    return paths_of(svg, pen.colour, width, pen.fill or "none")


def corners_of(steps):
    return np.concatenate([points for _, points in steps])


def texts_of(svg):
    return [text.text for text in ElementTree.fromstring(svg).iter(f"{SVG}text")]


def pdf_texts(path):
    return [page.extract_text() for page in PdfReader(path).pages]


def placed(pieces, turns, *, length=2500.0, offcuts=()):
    """A sheet with pieces in a row, turned about their origins."""
    stock = Sheet("birch <A&B>", length, 1250.0, pieces[0].thickness, pieces[0].material)
    x, placements = 10.0, []
    for piece, turn in zip(pieces, turns, strict=True):
        spun = Placement(piece.address, turn, 0.0, 0.0)(piece.silhouette)
        low, high = spun.min(axis=0), spun.max(axis=0)
        placements.append(Placement(piece.address, turn, x - low[0], 10.0 - low[1]))
        x += high[0] - low[0] + 15.0
    sheet = NestedSheet(3, stock, tuple(placements), 1e6, np.array(offcuts).reshape(-1, 4))
    return Layout((sheet,), 15.0, 10.0)


def marked(piece):
    """The piece with a stroke, an arc and a dot as its address, and two holes."""
    strokes = (
        Path(np.array([(50.0, 50.0), (50.0, 70.0), (60.0, 70.0)]), np.array([0.0, 1.0])),
        Path(np.array([(70.0, 50.0)]), np.zeros(0)),
    )
    return replace(
        piece,
        engraving=Engraving(piece.address, strokes, 0.5, 3.0),
        drills=(Drill(np.array([(30.0, 40.0), (120.25, 60.5)]), 5.0, piece.thickness),),
    )


@pytest.fixture(scope="module")
def shell_pieces():
    """Panels of a real shell, engraved, pierced, trimmed by the floor."""
    arch = Curve([(0, 0, -250), (0, 0, 2600), (4000, 0, 2600), (4000, 0, -250)], depth=3)
    fold = Curve([(0, 0, 0), (300, 900, 300), (0, 1800, 0)], depth=2).with_roughness(0.3)
    shell = thicken(vector_sum(arch, fold), 12.0, floor=Plane((0, 0, 0), (0, 0, 1)))
    return workpieces(shell, label=Label(face="inner", depth=0.5, cutter=3.0), holes=Holes(5, 25))


@pytest.mark.parametrize(
    ("size", "room", "name"),
    [
        ((100, 100), (100, 100), "1:1"),
        ((100.1, 50), (100, 100), "1:2"),
        ((2500, 1250), (250, 200), "1:10"),
        ((2501, 1250), (250, 200), "1:20"),
        ((100, 1000), (250, 200), "1:5"),
        ((40, 40), (100, 200), "2:1"),
        ((20, 40), (100, 200), "5:1"),
        ((10, 10), (100, 200), "10:1"),
        ((100, 60000), (250, 100), "1:1000"),
    ],
)
def test_scale_is_the_largest_of_the_standard_ones_that_fits(size, room, name):
    scale = standard_scale(np.array(size, dtype=float), np.array(room, dtype=float))
    assert scale_name(scale) == name


@given(size=st.floats(0.1, 1e6), room=st.floats(50.0, 400.0))
def test_any_size_has_a_scale_at_which_it_fills_two_fifths_at_least(size, room):
    scale = standard_scale(np.array([size, size]), np.array([room, room]))
    assert 0.4 * room * (1 - 1e-12) <= size * scale <= room * (1 + 1e-12)
    mantissa = f"{max(scale, 1 / scale):.0e}"
    assert mantissa[0] in "125"


@given(
    text=st.text("0123456789.-LabcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ ", min_size=1)
)
def test_text_is_about_as_long_as_thought_and_seldom_longer(text):
    width = stringWidth(text, "Helvetica-Bold", 10.0)
    assert 0.85 * width <= text_width(text, 10.0) <= 1.7 * width


def test_text_shrinks_to_its_room():
    page = Page("p", 100.0, 100.0)
    page.text("0000", 0.0, 0.0, 10.0)
    page.text("0000", 0.0, 0.0, 10.0, room=text_width("0000", 10.0) / 2)
    page.text("", 0.0, 0.0, 10.0, room=1.0)
    assert [mark.size for mark in page.marks] == [10.0, 5.0, 10.0]


@given(
    x=st.floats(0, 50), y=st.floats(0, 50), width=st.floats(0.5, 200), height=st.floats(0.5, 200)
)
def test_hatching_stays_in_its_box_and_rises_at_45_degrees(x, y, width, height):
    page = Page("p", 300.0, 300.0)
    hatch(page, x, y, width, height)
    for mark in page.marks:
        ends = np.array([numbers for _, numbers in mark.steps]).reshape(-1, 2, 2)
        assert (ends >= np.array([x, y]) - 1e-9).all()
        assert (ends <= np.array([x + width, y + height]) + 1e-9).all()
        spans = ends[:, 1] - ends[:, 0]
        np.testing.assert_allclose(spans[:, 0], spans[:, 1], atol=1e-9)


@given(angle=st.floats(0.0, 2 * math.pi))
def test_text_beside_a_line_reads_from_below_or_from_the_right(angle):
    page = Page("p", 100.0, 100.0)
    outward = np.array([math.cos(angle), math.sin(angle)])
    write_beside(page, np.zeros(2), outward, ["100.00", "second"])
    for words in page.marks:
        assert -75.001 <= words.turn <= 105.001
        up = np.array([-math.sin(math.radians(words.turn)), math.cos(math.radians(words.turn))])
        # The whole height of the letters lies beyond the line.
        base = np.array([words.x, words.y])
        assert base @ outward >= 0.5
        assert (base + up * words.size * 0.72) @ outward >= 0.5


@given(start=st.floats(0.0, 6.0), sweep=st.floats(0.1, 6.1), way=st.sampled_from([1, -1]))
def test_arcs_become_cubics_that_stay_on_their_circle(start, sweep, way):
    centre, radius = np.array([3.0, 4.0]), 10.0
    ends = start, start + way * sweep
    points = [centre + radius * np.array([math.cos(a), math.sin(a)]) for a in ends]
    page = Page("p", 100.0, 100.0)
    page.paths(UPPER, [Path(np.array(points), np.array([math.tan(way * sweep / 4)]))])
    (trace,) = page.marks
    here = np.array(trace.steps[0][1])
    share = np.linspace(0.0, 1.0, 33)[:, None]
    turned_by = 0.0
    for letter, numbers in trace.steps[1:]:
        assert letter == "C"
        one, other, end = np.array(numbers).reshape(3, 2)
        curve = (
            (1 - share) ** 3 * here
            + 3 * (1 - share) ** 2 * share * one
            + 3 * (1 - share) * share**2 * other
            + share**3 * end
        )
        np.testing.assert_allclose(np.hypot(*(curve - centre).T), radius, rtol=3e-4)
        angles = np.unwrap(np.arctan2(*(curve - centre).T[::-1]))
        turned_by += angles[-1] - angles[0]
        here = end
    np.testing.assert_allclose(here, points[1], atol=1e-9)
    assert turned_by == pytest.approx(way * sweep, abs=1e-9)


def test_sheet_shows_every_piece_where_the_layout_puts_it():
    pieces = [
        marked(box("0110", 300.0, 200.0, 20.0, inclinations=(20.0, -10.0, 5.0, 0.0))),
        marked(box("1e10", 400.0, 250.0, 20.0, inclinations=(-20.0, 10.0, 5.0, 0.0))),
        box("007", 350.0, 220.0, 20.0, fibre=(0.6, 0.8)),
    ]
    layout = placed(pieces, [0.0, 90.0, 213.0], offcuts=[(100.0, 800.0, 2000.0, 400.0)])
    svg = sheet_svg(layout.sheets[0], pieces)
    (frame,) = drawn_with(svg, STOCK)
    corners = corners_of(frame)
    # 2500 x 1250 at 1:10; y is down in SVG.
    np.testing.assert_allclose(np.ptp(corners, axis=0), [250.0, 125.0], atol=0.011)
    left, bottom = corners[:, 0].min(), corners[:, 1].max()

    def shown(points, place):
        return place(points) / 10.0 * [1.0, -1.0] + [left, bottom]

    uppers = drawn_with(svg, UPPER)
    assert len(uppers) == 3
    for steps, piece, place in zip(uppers, pieces, layout.sheets[0].placements, strict=True):
        np.testing.assert_allclose(corners_of(steps), shown(piece.upper, place), atol=0.02)
    holes = drawn_with(svg, PIERCED)
    assert len(holes) == 2
    for steps, piece, place in zip(holes, pieces, layout.sheets[0].placements, strict=False):
        ends = np.array([points[-1] for letter, points in steps if letter != "Z"])
        centres = np.array([ends[[k, k + 2]].mean(axis=0) for k in (0, 5)])
        np.testing.assert_allclose(centres, shown(piece.drills[0].points, place), atol=0.02)
    texts = texts_of(svg)
    for piece in pieces:
        assert texts.count(piece.address) == 1
    assert {"birch <A&B>", "2500.0", "1250.0", "1:10", "32.0 %", "offcut 2000 x 400"} <= set(texts)


def test_sheet_svg_is_small_and_well_formed(shell_pieces):
    pieces = list(shell_pieces[:30])
    svg = sheet_svg(placed(pieces, [0.0] * 30, length=25000.0).sheets[0], pieces)
    assert len(svg.encode()) < 60_000
    assert set(texts_of(svg)) >= {piece.address for piece in pieces}
    assert len(drawn_with(svg, UPPER)) == 30
    root = ElementTree.fromstring(svg)
    assert root.get("viewBox") == "0 0 297 210"


def test_names_that_would_break_the_format_are_written_as_text(tmp_path):
    pieces = [box("a<b>&\x07", 300.0, 200.0, 20.0)]
    layout = placed(pieces, [0.0])
    assert "a<b>& " in texts_of(sheet_svg(layout.sheets[0], pieces))
    path = export_sheet_drawings(layout, pieces, tmp_path / "s.pdf")
    assert "a<b>&" in pdf_texts(path)[0]


def test_sheet_pdf_has_a_page_for_each_sheet(tmp_path):
    pieces = [box("0110", 300.0, 200.0, 20.0), box("0111", 300.0, 200.0, 20.0)]
    one, other = (placed([piece], [30.0]).sheets[0] for piece in pieces)
    layout = Layout((replace(one, number=1), replace(other, number=2)), 15.0, 10.0)
    path = export_sheet_drawings(layout, pieces, tmp_path / "new" / "s.pdf")
    texts = pdf_texts(path)
    assert len(texts) == 2
    for text, piece, name in zip(texts, pieces, ("sheet-01", "sheet-02"), strict=True):
        words = text.split()
        assert words.count(piece.address) == words.count(name) == 1
    reader = PdfReader(path)
    assert [mark.title for mark in reader.outline] == ["sheet-01", "sheet-02"]
    box_of = reader.pages[0].mediabox
    np.testing.assert_allclose(
        np.array([float(box_of.width), float(box_of.height)]) * 25.4 / 72, [297, 210], atol=1e-3
    )


def test_layout_of_unknown_pieces_is_refused():
    pieces = [box("a", 300.0, 200.0, 20.0)]
    layout = placed(pieces, [0.0])
    with pytest.raises(InputError, match="places a, which is not among the workpieces"):
        sheet_svg(layout.sheets[0], [])
    with pytest.raises(InputError, match="places a, which is not among the workpieces"):
        export_sheet_drawings(layout, [], "never.pdf")


def test_element_page_gives_lengths_angles_neighbours_and_holes(tmp_path):
    piece = marked(box("0110", 300.0, 200.0, 20.0, inclinations=(30.0, 0.0, -12.5, 0.0)))
    rise = 20.0 * (math.tan(math.radians(30.0)) - math.tan(math.radians(12.5)))
    path = export_element_drawings([piece], tmp_path / "e.pdf")
    (text,) = pdf_texts(path)
    words = re.split(r"[\s,]+", text)
    assert words.count("0110") == 1
    assert {"300.00", "200.00", f"{200.0 + rise:.2f}", "30.00°", "-12.50°", "0.00°"} <= set(words)
    assert {"n0", "n1", "n2", "border"} <= set(words)
    assert {"120.25", "60.50", "5.00", "20.00", "90.00"} <= set(words)
    assert f"{piece.volume * 450e-9:.3f}" in words
    assert {"1:2", "free", "spruce"} <= set(words)


def test_element_drawings_have_a_page_for_each_kind_and_name_all(tmp_path):
    one = marked(box("0110", 300.0, 200.0, 20.0, inclinations=(30.0, 0.0, -12.5, 0.0)))
    pieces = [
        one,
        box("0111", 310.0, 200.0, 20.0),
        turned(one, "0112", 0.0),
        turned(replace(one, drills=(), engraving=None), "0113", 77.0, first=1),
        turned(box("x", 310.0, 200.0, 20.0), "0120", 45.0, first=2),
    ]
    texts = pdf_texts(export_element_drawings(pieces, tmp_path / "e.pdf"))
    named = [sorted(set(re.findall(r"\b01\d\d\b", text))) for text in texts]
    assert named == [["0110", "0112"], ["0111", "0120"], ["0113"]]


def test_equal_elements_beyond_the_page_are_listed_on_the_next(tmp_path):
    piece = plank("L00-0000", 800.0, 100.0, 40.0, (10.0, 20.0))
    pieces = [replace(piece, address=f"L{k // 10:02}-{k % 10:04}") for k in range(130)]
    pages = PdfReader(export_element_drawings(pieces, tmp_path / "e.pdf")).pages
    texts = [page.extract_text() for page in pages]
    assert len(texts) == 3  # 37 rows twice on a page
    assert "130" in texts[0].split()
    found = re.findall(r"L\d\d-\d{4}", "\n".join(texts))
    assert set(found) == {each.address for each in pieces}


def test_many_holes_go_on_on_the_next_page(tmp_path):
    points = np.column_stack([np.linspace(10.0, 590.0, 100), np.full(100, 50.0)])
    piece = box("0110", 600.0, 100.0, 20.0, drills=(Drill(points, 4.0, 20.0),))
    texts = pdf_texts(export_element_drawings([piece], tmp_path / "e.pdf"))
    assert len(texts) == 3
    assert {f"{x:.2f}" for x in points[:, 0]} <= set("\n".join(texts[1:]).split())


def points_drawn_on(page):
    """The points that lines and curves of a page go to, in its own units: mm."""
    points = []

    def see(operator, numbers, *_):
        if operator in (b"m", b"l", b"c"):
            points.append([float(number) for number in numbers[-2:]])

    page.extract_text(visitor_operand_before=see)
    return points


@pytest.mark.parametrize("paper", ["A4", "A3"])
def test_everything_lies_on_the_paper(tmp_path, shell_pieces, paper):
    """Every line of every page ends within its frame."""
    path = export_element_drawings(shell_pieces[:6], tmp_path / "e.pdf", paper=paper)
    sizes = {"A4": (297.0, 210.0), "A3": (420.0, 297.0)}
    for page in PdfReader(path).pages:
        paper_first, points = np.split(np.array(points_drawn_on(page)), [4])
        np.testing.assert_allclose(paper_first.max(axis=0), sizes[paper])
        assert len(points) > 100
        assert (points >= 9.9).all()
        assert (points <= np.array(sizes[paper]) - 9.9).all()


def test_element_drawings_of_a_shell_name_every_panel(tmp_path, shell_pieces):
    path = export_element_drawings(shell_pieces, tmp_path / "e.pdf", tolerance=0.0)
    reader = PdfReader(path)
    assert [mark.title for mark in reader.outline] == [piece.address for piece in shell_pieces]
    page, piece = reader.pages[5], shell_pieces[5]
    words = re.split(r"[\s,]+", page.extract_text())
    assert words.count(piece.address) == 1
    for side in piece.sides:
        assert f"{side.inclination:.2f}" in words
        assert side.neighbour in words


def test_a_piece_whose_upper_face_is_gone_is_drawn(tmp_path):
    piece = replace(box("a", 300.0, 200.0, 20.0), upper=np.zeros((0, 2)))
    svg = sheet_svg(placed([piece], [0.0]).sheets[0], [piece])
    assert drawn_with(svg, UPPER) == []
    assert "a" in texts_of(svg)
    assert len(pdf_texts(export_element_drawings([piece], tmp_path / "e.pdf"))) == 1


def test_short_edge_is_numbered_and_only_the_table_gives_its_length(tmp_path):
    corners = np.array([(0.0, 0.0), (600.0, 0.0), (600.0, 397.0), (597.0, 400.0), (0.0, 400.0)])
    piece = polygon_piece("a", corners, 20.0, [0.0] * 5)
    (text,) = pdf_texts(export_element_drawings([piece], tmp_path / "e.pdf"))
    words = re.split(r"[\s,]+", text)
    assert words.count("4.24") == 2  # upper and lower, both in the table
    assert words.count("597.00") == 3
    assert words.count("3") == 3  # beside the edge, in the table, at the section


@pytest.fixture(scope="module")
def planks():
    return [
        plank(f"L{k // 8:02}-{k % 8:04}", 500.0 + 37.0 * (k % 8), 140.0, 40.0, (5.0, 3.0 * (k % 3)))
        for k in range(40)
    ]


@pytest.fixture(scope="module")
def plan(planks):
    boards = [Board("spruce 5 m", 5000.0, 140.0, 40.0, planks[0].material)]
    lengths = [float(np.ptp(each.upper[:, 0])) for each in planks]
    return cut_boards(lengths, boards, kerf=4.0, trim=10.0)


def test_board_drawings_show_every_plank_once(tmp_path, planks, plan):
    texts = pdf_texts(export_board_drawings(plan, planks, tmp_path / "b.pdf"))
    words = [word for text in texts for word in text.split()]
    for each in planks:
        assert words.count(each.address) == 1
    assert len(texts) == math.ceil(len(plan.boards) / 6)
    assert {"4.00", "10.00", "1:20", "5.00°"} <= set(words)
    for board in plan.boards:
        assert f"{board.rest:.1f}" in words


def test_board_svg_has_planks_where_the_plan_puts_them(planks, plan):
    board = plan.boards[-1]
    svg = board_svg(board, planks)
    (outline,) = drawn_with(svg, STOCK)
    corners = corners_of(outline)
    np.testing.assert_allclose(np.ptp(corners, axis=0), [250.0, 7.0], atol=0.011)
    left, bottom = corners[:, 0].min(), corners[:, 1].max()
    shapes = drawn_with(svg, WOOD)
    assert len(shapes) == len(board.pieces)
    for steps, index, start in zip(shapes, board.pieces, board.starts, strict=True):
        outline = planks[index].upper + np.array([start, 0.0])
        np.testing.assert_allclose(
            corners_of(steps), outline / 20.0 * [1.0, -1.0] + [left, bottom], atol=0.02
        )
    assert f"{board.number}: spruce 5 m, planks {len(board.pieces)}, rest {board.rest:.1f}" in (
        texts_of(svg)
    )


def test_same_design_makes_the_same_bytes(tmp_path, planks, plan):
    pieces = [marked(box("0110", 300.0, 200.0, 20.0))]
    layout = placed(pieces, [0.0])
    for name in ("1", "2"):
        export_element_drawings(pieces, tmp_path / name / "e.pdf")
        export_sheet_drawings(layout, pieces, tmp_path / name / "s.pdf")
        export_board_drawings(plan, planks, tmp_path / name / "b.pdf")
    for each in (tmp_path / "1").iterdir():
        assert each.read_bytes() == (tmp_path / "2" / each.name).read_bytes()


def test_paper_must_be_known():
    with pytest.raises(InputError, match='paper must be "A4" or "A3", got \'A5\''):
        export_element_drawings([box("a", 300.0, 200.0, 20.0)], "never.pdf", paper="A5")


def test_nothing_to_draw_is_an_error(tmp_path):
    with pytest.raises(InputError, match="nothing to draw"):
        export_element_drawings([], tmp_path / "e.pdf")
    with pytest.raises(InputError, match="nothing to draw"):
        export_sheet_drawings(Layout((), 15.0, 10.0), [], tmp_path / "s.pdf")
    assert list(tmp_path.iterdir()) == []


def test_failed_drawing_leaves_the_former_file(tmp_path):
    path = tmp_path / "e.pdf"
    path.write_text("old")
    broken = replace(box("a", 300.0, 200.0, 20.0), silhouette=np.full((4, 2), np.nan))
    with pytest.raises(ValueError, match="NaN"):
        export_element_drawings([broken], path)
    assert path.read_text() == "old"
    with pytest.raises(ExportError, match="it is a folder"):
        export_element_drawings([box("a", 300.0, 200.0, 20.0)], tmp_path)


def test_only_pdf_needs_reportlab(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "reportlab.pdfgen.canvas", None)
    pieces = [box("a", 300.0, 200.0, 20.0)]
    layout = placed(pieces, [0.0])
    assert "a" in texts_of(sheet_svg(layout.sheets[0], pieces))
    with pytest.raises(MissingLibraryError, match=r"pip install 'ifs-cad\[fabrication\]'"):
        export_sheet_drawings(layout, pieces, tmp_path / "s.pdf")
