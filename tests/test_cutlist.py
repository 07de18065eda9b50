"""Cut lists and plank lists, and what CSV and XLSX readers make of them."""

import csv
import math
from dataclasses import replace

import numpy as np
import pytest
from handmade import box, plank, polygon_piece, turned
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from openpyxl import load_workbook

from ifs_cad.errors import ExportError, InputError
from ifs_cad.export.cutlist import export_csv, export_xlsx
from ifs_cad.fabrication.congruence import congruent_groups
from ifs_cad.fabrication.cutlist import cut_list
from ifs_cad.fabrication.layout import Layout, NestedSheet, Placement
from ifs_cad.fabrication.measure import chord, corner_angles, side_edges
from ifs_cad.fabrication.planklist import end_angles, plank_list
from ifs_cad.fabrication.stock import Sheet
from ifs_cad.fabrication.table import Column, Table
from ifs_cad.fabrication.workpiece import Drill

TRAPS = ["0110", "1e10", "007", "3.2.10", "1/2", "=1+1", "-5", "TRUE", 'a "b", c']


def members(groups):
    return [[member.index for member in group] for group in groups]


def test_edges_of_a_chamfered_box_are_its_faces_edges():
    piece = box("a", 300.0, 200.0, 20.0, inclinations=(45.0, 0.0, -45.0, 0.0))
    edges = side_edges(piece)
    np.testing.assert_allclose(edges.lower_lengths, [300.0, 200.0, 300.0, 200.0], rtol=1e-12)
    np.testing.assert_allclose(edges.upper_lengths, [300.0, 200.0, 300.0, 200.0], rtol=1e-12)
    np.testing.assert_allclose(edges.upper[0] - edges.lower[0], [(0, -20), (0, -20)], atol=1e-12)
    np.testing.assert_allclose(corner_angles(piece), [90.0] * 4, rtol=1e-12)


def test_edges_are_as_long_as_the_outlines_say():
    piece = box("a", 300.0, 200.0, 20.0, inclinations=(30.0, -10.0, 5.0, 20.0))
    edges = side_edges(piece)
    for ends, outline in ((edges.upper, piece.upper), (edges.lower, piece.lower)):
        np.testing.assert_allclose(ends[:, 0], outline, atol=1e-9)
        np.testing.assert_allclose(ends[:, 1], np.roll(outline, -1, axis=0), atol=1e-9)


def test_side_that_misses_a_face_has_no_length_there():
    piece = box("a", 100.0, 100.0, 10.0)
    corner = np.array([(100.0, 90.0, 0.0), (90.0, 100.0, 0.0), (100.0, 100.0, 8.0)])
    normal = np.cross(corner[1] - corner[0], corner[2] - corner[0])
    cut = replace(piece.sides[0], corners=corner, normal=normal / np.linalg.norm(normal))
    edges = side_edges(replace(piece, sides=(*piece.sides, cut)))
    assert edges.upper_lengths[-1] == 0.0
    assert np.isnan(edges.upper[-1]).all()
    assert edges.lower_lengths[-1] == pytest.approx(10 * math.sqrt(2), rel=1e-12)


def test_chord_of_a_triangle():
    triangle = np.array([(0.0, 0.0), (4.0, 0.0), (0.0, 4.0)])
    found = chord(triangle, np.array([1.0, 1.0]), np.array([1.0, 0.0]))
    np.testing.assert_allclose(found, [(0.0, 1.0), (3.0, 1.0)], atol=1e-12)
    found = chord(triangle, np.array([1.0, 0.0]), np.array([0.0, 1.0]))
    np.testing.assert_allclose(found, [(1.0, 0.0), (1.0, 3.0)], atol=1e-12)


@st.composite
def convex_pieces(draw):
    """Pieces around a circle, each side with an inclination of its own."""
    count = draw(st.integers(3, 6))
    gaps = np.array([draw(st.floats(1.0, 2.0)) for _ in range(count)])
    angles = np.cumsum(gaps / gaps.sum() * 2 * math.pi) + draw(st.floats(0.0, 6.0))
    radius = draw(st.floats(150.0, 800.0))
    corners = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    inclinations = [draw(st.floats(-40.0, 40.0)) for _ in range(count)]
    return polygon_piece("one", corners, 20.0, inclinations)


@given(
    piece=convex_pieces(),
    turns=st.lists(st.floats(0.0, 360.0), min_size=1, max_size=5),
    over=st.booleans(),
)
@settings(max_examples=60, deadline=None)
def test_congruent_copies_are_one_group_whose_sides_correspond(piece, turns, over):
    copies = [
        turned(piece, f"copy {k}", turn, over=over, first=k + 1) for k, turn in enumerate(turns)
    ]
    groups = congruent_groups([piece, *copies], 1e-6, turned_over=over)
    assert members(groups) == [list(range(len(copies) + 1))]
    edges = side_edges(piece)
    for member in groups[0][1:]:
        other = side_edges([piece, *copies][member.index])
        upper, lower = other.upper_lengths[member.sides], other.lower_lengths[member.sides]
        if member.turned_over:
            upper, lower = lower, upper
        np.testing.assert_allclose(upper, edges.upper_lengths, atol=1e-6)
        np.testing.assert_allclose(lower, edges.lower_lengths, atol=1e-6)


@given(piece=convex_pieces(), turn=st.floats(0.0, 360.0), shift=st.floats(2.0, 50.0))
@settings(max_examples=60, deadline=None)
def test_piece_with_a_moved_corner_is_another_kind(piece, turn, shift):
    corners = np.array(piece.lower)
    middle = corners.mean(axis=0)
    spoke = corners[0] - middle
    corners[0] += spoke / np.hypot(*spoke) * shift
    inclinations = [side.inclination for side in piece.sides]
    try:
        moved = polygon_piece("two", corners, piece.thickness, inclinations)
    except ValueError:  # no longer convex
        assume(False)
    # A corner off by s cannot be made up for: the areas differ by s w / 2 for a diagonal w, and
    # two outlines within t of each other have areas that differ by at most perimeter t + pi t t.
    tolerance = 1e-3 * shift
    other = turned(moved, "two", turn)
    assert members(congruent_groups([piece, other], tolerance, turned_over=True)) == [[0], [1]]


def test_mirrored_piece_is_the_same_only_when_turned_over():
    corners = np.array([(0.0, 0.0), (400.0, 0.0), (300.0, 200.0), (50.0, 150.0)])
    piece = polygon_piece("a", corners, 20.0, [0.0] * 4)
    other = turned(piece, "b", 30.0, over=True)
    assert members(congruent_groups([piece, other], 1e-6)) == [[0], [1]]
    (group,) = congruent_groups([piece, other], 1e-6, turned_over=True)
    assert [member.turned_over for member in group] == [False, True]


def test_chamfered_piece_upside_down_is_the_same_only_when_turned_over():
    piece = box("a", 300.0, 300.0, 20.0, inclinations=(10.0,) * 4)
    wide = 300.0 + 40.0 * math.tan(math.radians(10.0))
    other = box("b", wide, wide, 20.0, inclinations=(-10.0,) * 4)
    assert members(congruent_groups([piece, other])) == [[0], [1]]
    assert members(congruent_groups([piece, other], turned_over=True)) == [[0, 1]]


def test_holes_fibre_material_and_thickness_tell_pieces_apart():
    piece = box("a", 300.0, 200.0, 20.0, fibre=(1.0, 0.0))
    points = np.array([(50.0, 60.0)])
    through = Drill(points, 5.0, 20.0)
    others = [
        replace(piece, fibre=np.array([-1.0, 0.0])),  # grain runs both ways
        replace(piece, fibre=np.array([0.0, 1.0])),
        replace(piece, fibre=None),
        replace(piece, drills=(through,)),
        replace(piece, drills=(replace(through, diameter=6.0),)),
        replace(piece, drills=(replace(through, depth=10.0),)),
        replace(piece, drills=(Drill(np.array([(250.0, 140.0)]), 5.0, 20.0),)),  # a half turn on
        replace(piece, material=replace(piece.material, name="oak")),
        box("b", 300.0, 200.0, 21.0, fibre=(1.0, 0.0)),
    ]
    pieces = [piece, *others]
    assert members(congruent_groups(pieces)) == [[0, 1], [2], [3], [4, 7], [5], [6], [8], [9]]
    without = congruent_groups(pieces, holes=False)
    assert members(without) == [[0, 1, 4, 5, 6, 7], [2], [3], [8], [9]]


def test_everything_in_a_group_is_within_the_tolerance_of_its_first():
    pieces = [box(str(k), 300.0 + 0.08 * k, 200.0, 20.0) for k in range(6)]
    # Middles of the sides move by half of what the length grows: 0.04 mm a step.
    assert members(congruent_groups(pieces, 0.1)) == [[0, 1, 2], [3, 4, 5]]
    assert members(congruent_groups(pieces, 0.0)) == [[k] for k in range(6)]


def test_no_workpieces_make_no_groups():
    assert congruent_groups([]) == ()


@pytest.mark.parametrize("tolerance", [-0.1, math.nan, math.inf])
def test_tolerance_that_is_none_is_refused(tolerance):
    with pytest.raises(InputError, match="tolerance of equal pieces must be 0 mm or more"):
        congruent_groups([], tolerance)


def layout_of(pieces):
    stock = Sheet("birch", 2500.0, 1250.0, 20.0, pieces[0].material)
    placements = tuple(
        Placement(piece.address, 90.0 * k, 10.0 + 400.0 * k, 20.5) for k, piece in enumerate(pieces)
    )
    return Layout((NestedSheet(1, stock, placements, 1.0, np.zeros((0, 4))),), 10.0, 10.0)


def test_cut_list_measures_a_box_as_by_hand():
    tangent = math.tan(math.radians(30.0))
    piece = box("0110", 300.0, 200.0, 20.0, inclinations=(30.0, 0.0, 0.0, 0.0))
    (entry,) = cut_list([piece], layout_of([piece])).entries
    assert entry.area == pytest.approx(300.0 * (200.0 + 20.0 * tangent), rel=1e-12)
    assert entry.mass == pytest.approx(piece.volume * 1e-9 * 450.0, rel=1e-12)
    assert [edge.inclination for edge in entry.edges] == [30.0, 0.0, 0.0, 0.0]
    assert [edge.neighbour for edge in entry.edges] == ["n0", "n1", "n2", ""]
    assert entry.edges[1].lower == pytest.approx(200.0, rel=1e-12)
    assert entry.edges[1].upper == pytest.approx(200.0 + 20.0 * tangent, rel=1e-12)
    assert (entry.sheet, entry.x, entry.y, entry.turn) == ("sheet-01", 10.0, 20.5, 0.0)


def test_cut_list_without_layout_has_no_places():
    (entry,) = cut_list([box("a", 300.0, 200.0, 20.0)]).entries
    assert (entry.sheet, entry.x, entry.y, entry.turn) == ("", None, None, None)


def test_cut_list_refuses_a_layout_of_other_workpieces():
    pieces = [box(name, 300.0, 200.0, 20.0) for name in ("a", "b")]
    with pytest.raises(InputError, match="places no b") as caught:
        cut_list(pieces, layout_of(pieces[:1]))
    assert caught.value.addresses == ("b",)


def test_address_given_twice_is_refused():
    with pytest.raises(InputError, match="Two workpieces have the address a"):
        cut_list([box("a", 300.0, 200.0, 20.0), box("a", 100.0, 200.0, 20.0)])


def test_groups_number_every_element_once():
    pieces = [box(str(k), 300.0 + 10 * (k % 3), 200.0, 20.0) for k in range(9)]
    listed = cut_list(pieces)
    assert listed.groups == (("0", "3", "6"), ("1", "4", "7"), ("2", "5", "8"))
    assert [entry.group for entry in listed.entries] == [1, 2, 3] * 3


def sixteen(number):
    """All the digits that the format has."""
    return float(f"{number:.16g}")


def read_sheet(path, name):
    rows = list(load_workbook(path)[name].iter_rows(values_only=True))
    return [dict(zip(rows[0], row, strict=True)) for row in rows[1:]]


def test_workbook_keeps_addresses_as_text_and_numbers_whole(tmp_path):
    pieces = [
        replace(box(name, 300.0 + k / 3, 200.0, 20.0), volume=1e6 / 7)
        for k, name in enumerate(TRAPS)
    ]
    listed = cut_list(pieces, layout_of(pieces))
    path = export_xlsx(listed, tmp_path / "new" / "cut.xlsx")
    rows = read_sheet(path, "elements")
    assert [row["address"] for row in rows] == TRAPS
    for row, entry in zip(rows, listed.entries, strict=True):
        assert row["mass (kg)"] == sixteen(entry.mass)
        assert row["area (m2)"] == sixteen(entry.area / 1e6)
        assert row["edge 1 upper (mm)"] == sixteen(entry.edges[0].upper)
        assert row["edge 2 neighbour"] == "n1"
        assert row["edge 4 neighbour"] is None
        assert (row["sheet"], row["x (mm)"], row["turn (deg)"]) == (
            entry.sheet,
            entry.x,
            entry.turn,
        )
    edges = read_sheet(path, "edges")
    assert [row["address"] for row in edges] == [name for name in TRAPS for _ in range(4)]
    assert [row["inclination (deg)"] for row in edges] == [0.0] * 4 * len(TRAPS)
    groups = read_sheet(path, "groups")
    assert " ".join(row["addresses"] for row in groups).split() == " ".join(TRAPS).split()
    (summary,) = read_sheet(path, "summary")
    assert summary["elements"] == len(TRAPS)
    assert summary["mass (kg)"] == pytest.approx(len(TRAPS) * 1e-3 / 7 * 450.0, rel=1e-12)


def test_workbook_has_frozen_titles_formats_and_no_formulas(tmp_path):
    path = export_xlsx(cut_list([box("0110", 300.0, 200.0, 20.0)]), tmp_path / "cut.xlsx")
    book = load_workbook(path)
    assert book.sheetnames == ["elements", "edges", "groups", "summary"]
    for sheet in book:
        assert sheet.freeze_panes == "B2"
        assert all(cell.data_type in "sn" for row in sheet.iter_rows() for cell in row)
        assert all(cell.font.bold for cell in sheet[1])
    sheet = book["elements"]
    assert sheet["A2"].number_format == "@"
    assert sheet["E2"].number_format == "0.0000"
    assert sheet.column_dimensions["C"].width >= len("spruce plywood")


def test_same_list_makes_the_same_workbook(tmp_path):
    listed = cut_list([box("0110", 300.0, 200.0, 20.0)])
    one, other = (export_xlsx(listed, tmp_path / name) for name in ("a.xlsx", "b.xlsx"))
    assert one.read_bytes() == other.read_bytes()


def test_csv_quotes_every_text_and_keeps_every_digit(tmp_path):
    pieces = [box(name, 300.0 + k / 3, 200.0, 20.0) for k, name in enumerate(TRAPS)]
    listed = cut_list(pieces)
    path = export_csv(listed, tmp_path / "cut.csv")
    raw = path.read_bytes()
    assert raw.count(b"\r\n") == raw.count(b"\n") == len(TRAPS) + 1
    assert raw.split(b"\r\n")[1].startswith(b'"0110",1,"spruce plywood",20.0,')
    with path.open(encoding="utf-8", newline="") as handle:
        rows = list(csv.DictReader(handle))
    assert [row["address"] for row in rows] == TRAPS
    for row, entry in zip(rows, listed.entries, strict=True):
        assert float(row["edge 3 lower (mm)"]) == entry.edges[2].lower
        assert float(row["mass (kg)"]) == entry.mass
        assert row["x (mm)"] == ""


def test_elements_with_fewer_sides_leave_cells_empty(tmp_path):
    triangle = polygon_piece("t", np.array([(0.0, 0.0), (300.0, 0.0), (0.0, 300.0)]), 20.0, [0] * 3)
    path = export_csv(cut_list([triangle, box("q", 300.0, 200.0, 20.0)]), tmp_path / "cut.csv")
    with path.open(encoding="utf-8", newline="") as handle:
        rows = list(csv.DictReader(handle))
    assert rows[0]["edge 4 upper (mm)"] == ""
    assert float(rows[1]["edge 4 upper (mm)"]) == pytest.approx(200.0, rel=1e-12)


def test_failed_list_leaves_the_former_file(tmp_path):
    path = tmp_path / "cut.csv"
    path.write_text("old")
    wrong = Table("elements", (Column("a"),), ((object(),),))
    with pytest.raises(TypeError):
        export_csv(wrong, path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]
    with pytest.raises(ExportError, match="it is a folder"):
        export_csv(cut_list([]), tmp_path)


def test_table_refuses_rows_that_do_not_fit_its_columns():
    columns = (Column("address", "text"), Column("length (mm)"))
    with pytest.raises(InputError, match=r"Row 2 of table 'x' has 1 cells for 2 columns"):
        Table("x", columns, (("a", 1.0), ("b",)))
    with pytest.raises(InputError, match=r"has 110 in the column 'address', which holds text"):
        Table("x", columns, ((110, 1.0),))
    with pytest.raises(InputError, match=r"has '1' in the column 'length \(mm\)'"):
        Table("x", columns, (("a", "1"),))


def test_plank_is_measured_as_by_hand():
    # 1000 mm at its lower side; its ends slope inward by 30 and 15 degrees over 100 mm.
    piece = plank("L07-0110", 1000.0, 100.0, 40.0, (15.0, 30.0))
    (kind,) = plank_list([piece]).kinds
    slopes = 100.0 * (math.tan(math.radians(15.0)) + math.tan(math.radians(30.0)))
    assert kind.long == pytest.approx(1000.0, rel=1e-12)
    assert kind.short == pytest.approx(1000.0 - slopes, rel=1e-12)
    assert kind.end_angles == pytest.approx((30.0, 15.0), rel=1e-9)
    assert (kind.width, kind.thickness, kind.count) == (pytest.approx(100.0), 40.0, 1)
    assert end_angles(piece) == pytest.approx((15.0, 30.0), rel=1e-9)


plank_angles = st.tuples(st.floats(-40.0, 40.0), st.floats(-40.0, 40.0))


@given(
    kinds=st.lists(
        st.tuples(st.integers(4, 12), plank_angles),
        min_size=1,
        max_size=5,
        unique_by=lambda k: k[0],
    ),
    copies=st.lists(st.tuples(st.integers(0, 4), st.booleans(), st.booleans()), max_size=12),
)
@settings(max_examples=60, deadline=None)
def test_planks_are_counted_however_they_lie(kinds, copies):
    """Kinds are 100 mm apart in the middle of their length, which no turning makes up for."""
    originals = []
    for k, (hundreds, (left, right)) in enumerate(kinds):
        slope = 80.0 * (math.tan(math.radians(left)) + math.tan(math.radians(right)))
        originals.append(
            plank(f"kind {k}", 100.0 * hundreds + slope / 2, 80.0, 30.0, (left, right))
        )
    pieces = list(originals)
    for k, (which, over, end_for_end) in enumerate(copies):
        original = originals[which % len(originals)]
        turn = 180.0 if end_for_end else 0.0
        pieces.append(turned(original, f"copy {k}", turn, over=over, first=k))
    listed = plank_list(pieces)
    assert len(listed) == sum(kind.count for kind in listed.kinds) == len(pieces)
    expected = [1] * len(originals)
    for which, *_ in copies:
        expected[which % len(originals)] += 1
    assert [kind.count for kind in listed.kinds] == expected
    for kind, (hundreds, angles) in zip(listed.kinds, kinds, strict=True):
        assert (kind.long + kind.short) / 2 == pytest.approx(100.0 * hundreds, rel=1e-9)
        tangents = [math.tan(math.radians(angle)) for angle in angles]
        way = 1.0 if sum(tangents) >= 0 else -1.0
        assert kind.end_angles == pytest.approx(sorted(way * a for a in angles)[::-1], abs=1e-6)


def test_planks_differ_when_their_ends_do():
    pieces = [
        plank("a", 1000.0, 100.0, 40.0, (10.0, 20.0)),
        plank("b", 1000.0, 100.0, 40.0, (20.0, 10.0)),  # turned over
        plank("c", 1000.0, 100.0, 40.0, (10.0, 20.1)),  # 0.2 mm off
        plank("d", 1000.0, 100.0, 41.0, (10.0, 20.0)),
    ]
    kinds = [kind.addresses for kind in plank_list(pieces, 0.05).kinds]
    assert kinds == [("a", "b"), ("c",), ("d",)]
    assert len(plank_list(pieces, 0.2).kinds) == 2


def test_plank_with_two_cuts_at_one_end_has_no_angles():
    corners = np.array([(0.0, 0.0), (1000.0, 0.0), (1000.0, 60.0), (960.0, 100.0), (0.0, 100.0)])
    (kind,) = plank_list([polygon_piece("a", corners, 40.0, [0.0] * 5)]).kinds
    assert kind.end_angles == (None, None)
    assert (kind.long, kind.short) == pytest.approx((1000.0, 960.0), rel=1e-12)


def test_panel_in_a_plank_list_is_refused():
    pieces = [
        plank("a", 1000.0, 100.0, 40.0, (10.0, 20.0)),
        box("b", 300.0, 200.0, 20.0, inclinations=(10.0, 0.0, 0.0, 0.0)),
    ]
    with pytest.raises(InputError, match="b cannot be listed as planks") as caught:
        plank_list(pieces)
    assert caught.value.addresses == ("b",)


def test_plank_list_in_a_workbook(tmp_path):
    pieces = [plank(f"L0{k}-0110", 1000.0 + 50 * (k % 2), 100.0, 40.0, (10, 20)) for k in range(4)]
    path = export_xlsx(plank_list(pieces), tmp_path / "planks.xlsx")
    kinds = read_sheet(path, "kinds")
    assert [(row["kind"], row["count"], row["addresses"]) for row in kinds] == [
        (1, 2, "L00-0110 L02-0110"),
        (2, 2, "L01-0110 L03-0110"),
    ]
    planks = read_sheet(path, "planks")
    lengths = {row["address"]: row["long side (mm)"] for row in planks}
    assert lengths == {
        f"L0{k}-0110": pytest.approx(1000.0 + 50 * (k % 2), rel=1e-12) for k in range(4)
    }


def test_no_planks_make_an_empty_list():
    assert len(plank_list([])) == 0
