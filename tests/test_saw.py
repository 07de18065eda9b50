"""Three axes and a saw: followed exactly, outline and saw list leave the designed pieces."""

import csv
import math
import runpy
import xml.etree.ElementTree as ET
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from floored import nipped, wedge
from handmade import polygon_piece
from hypothesis import given, settings
from hypothesis import strategies as st
from layouts import in_rows
from scipy.spatial import ConvexHull, HalfspaceIntersection
from strategies import accepted, shells
from vaults import GROUND, THICKNESS, hexagon, plate, roof, vault

import ifs_cad as ifs
from ifs_cad.elements.hole import Holes
from ifs_cad.elements.label import Label
from ifs_cad.errors import InputError
from ifs_cad.export.btlx import NAMESPACE, export_btlx
from ifs_cad.export.cutlist import export_csv
from ifs_cad.export.dxf import export_dxf
from ifs_cad.fabrication.cutlist import cut_list
from ifs_cad.fabrication.measure import outline_area
from ifs_cad.fabrication.operations import workpieces
from ifs_cad.fabrication.saw import SawCut, saw_list, square_workpieces

LABEL = Label(cutter=2.0, margin=2.0)
EXACT = 1e-6


@cache
def relieved():
    """Panels with relief cuts and feet trimmed by a floor."""
    shell = vault(floor=GROUND, clearance=0.2)
    return workpieces(shell, label=LABEL, holes=Holes(4, 12, fewest=0))


def cutting_plane(cut: SawCut, piece):
    """Outward normal and level of the plane that a saw cuts where the list says."""
    side = piece.sides[cut.edge - 1]
    outward = np.append(side.normal[:2] / np.hypot(*side.normal[:2]), 0.0)
    edge = (piece.silhouette @ outward[:2]).max()
    # on the face up the blade enters at the edge, on the other it leaves a setback further in
    up, down = (piece.thickness, 0.0) if cut.up == "marked" else (0.0, piece.thickness)
    slope = cut.setback / (down - up)
    normal = np.array([*outward[:2], slope])
    return normal, edge + slope * up


def all_cuts(found) -> list[SawCut]:
    return [*found.cuts, *found.by_hand, *found.square]


def assert_every_edge_is_listed_once(found, pieces) -> None:
    listed = sorted((cut.address, cut.edge) for cut in all_cuts(found))
    edges = [(p.address, k) for p in pieces for k in range(1, len(p.sides) + 1)]
    assert listed == sorted(edges)


def assert_saw_leaves_the_piece(found, piece) -> None:
    """The square piece, sawn as listed and worked by hand elsewhere, is the designed piece."""
    (square,) = square_workpieces([piece])
    keep = [(0.0, 0.0, -1.0, 0.0), (0.0, 0.0, 1.0, -piece.thickness)]
    keep += [(*side.normal, -side.normal @ side.corners[0]) for side in square.sides]
    for cut in all_cuts(found):
        if cut.address != piece.address:
            continue
        side = piece.sides[cut.edge - 1]
        assert cut.angle == abs(side.inclination)
        if cut.obstacle or cut.setting == 0.0:
            normal, level = side.normal, side.normal @ side.corners[0]
        else:
            normal, level = cutting_plane(cut, piece)
            np.testing.assert_allclose(side.corners @ normal, level, atol=EXACT)
        keep.append((*normal, -level))
    inside = np.concatenate([side.corners for side in piece.sides])
    planes = np.array(keep)
    assert (planes[:, :3] @ inside.T + planes[:, 3:]).max() < EXACT
    corners = HalfspaceIntersection(planes, inside.mean(axis=0)).intersections
    assert ConvexHull(corners).volume == pytest.approx(ConvexHull(inside).volume, rel=1e-6)


def test_pieces_with_relief_and_floor_come_out_of_the_saw() -> None:
    found = saw_list(relieved(), steepest=80.0)
    assert_every_edge_is_listed_once(found, relieved())
    for piece in relieved():
        assert_saw_leaves_the_piece(found, piece)


@settings(max_examples=30, deadline=None)
@given(shells(), st.sampled_from(["inner", "outer"]))
def test_pieces_of_any_shell_come_out_of_the_saw(shell, face) -> None:
    label = Label(face=face, style="wire", min_height=2.5, margin=0.0)
    pieces = accepted(workpieces, shell, label=label)
    found = saw_list(pieces, step=0.01, steepest=80.0, shortest=0.1)
    assert_every_edge_is_listed_once(found, pieces)
    for piece in pieces[:3]:
        assert_saw_leaves_the_piece(found, piece)


@pytest.mark.parametrize(("face", "up"), [("inner", "back"), ("outer", "marked")])
def test_ridge_of_a_roof_is_sawn_from_the_wider_face(face, up) -> None:
    pieces = workpieces(roof(400, 300, 25.0), label=Label(face=face))
    found = saw_list(pieces)
    reach = THICKNESS * math.tan(math.radians(25.0))
    assert [cut.address for cut in found.cuts] == [piece.address for piece in pieces]
    for cut, piece in zip(found.cuts, pieces, strict=True):
        assert piece.sides[cut.edge - 1].kind == cut.kind == "cut"
        assert (cut.up, cut.setting, cut.obstacle) == (up, 25.0, "")
        assert cut.length == pytest.approx(300.0, abs=1e-9)
        assert cut.setback == pytest.approx(reach, abs=1e-9)
        assert cut.across == pytest.approx(400.0 + reach, abs=1e-9)  # the wider, outer face
    assert len(found.square) == 6
    assert not found.by_hand
    assert str(found) == "2 saw cuts, 0.6 m, at 1 settings; 0 edges by hand, 6 square"


def test_saw_is_set_as_rarely_as_can_be() -> None:
    found = saw_list(relieved(), steepest=80.0, step=0.5)
    settings_ = [cut.setting for cut in found.cuts]
    assert settings_ == sorted(settings_)
    order = {piece.address: k for k, piece in enumerate(relieved())}
    for setting in set(settings_):
        places = [(order[c.address], c.edge) for c in found.cuts if c.setting == setting]
        assert places == sorted(places)
    for cut in found.cuts:
        assert abs(cut.setting - cut.angle) <= 0.25 + 1e-9
        assert cut.setting / 0.5 == pytest.approx(round(cut.setting / 0.5), abs=1e-9)
    finer = saw_list(relieved(), steepest=80.0, step=0.1)
    assert len({cut.setting for cut in finer.cuts}) > len(set(settings_))
    table = found.tables[2]
    assert sum(row[1] for row in table.rows) == len(found)
    assert [row[0] for row in table.rows] == sorted(set(settings_))


def test_what_a_saw_cannot_reach_is_named() -> None:
    # the relief cuts are triangles of 1 to 2 mm: no saw is guided along them
    found = saw_list(relieved())
    assert len(found.by_hand) == 8
    assert {(cut.kind, cut.obstacle) for cut in found.by_hand} == {("relief", "shorter than 20 mm")}
    assert max(cut.length for cut in found.by_hand) < 3.0
    steep = polygon_piece("steep", [(0, 0), (300, 0), (300, 200), (0, 200)], 10, [0, 50, 0, -45])
    found = saw_list([steep], steepest=45.0)
    assert [(cut.angle, cut.obstacle) for cut in found.by_hand] == [(50.0, "steeper than 45 deg")]
    assert [(cut.angle, cut.up) for cut in found.cuts] == [(45.0, "back")]
    short = polygon_piece(
        "short", [(0, 0), (300, 0), (300, 190), (290, 200), (0, 200)], 10, [0, 0, 20, 0, 0]
    )
    found = saw_list([short])
    assert [(cut.edge, cut.obstacle) for cut in found.by_hand] == [(3, "shorter than 20 mm")]
    assert len(saw_list([short], shortest=5.0)) == 1


def test_floor_sides_that_end_between_the_faces() -> None:
    # the nip starts on no edge of the square piece: wider at the top, it misses the marked face
    found = saw_list([nipped()])
    (cut,) = found.by_hand
    assert (cut.kind, cut.up, cut.obstacle) == ("floor", "marked", "no edge on the face up")
    assert len(found.square) == 4
    (cut,) = saw_list([wedge()]).by_hand
    assert cut.obstacle == "steeper than 45 deg"
    assert (cut.up, cut.angle) == ("back", pytest.approx(math.degrees(math.atan2(300, 10))))
    assert cut.length == pytest.approx(200.0)
    for piece in (nipped(), wedge()):
        assert_saw_leaves_the_piece(saw_list([piece], steepest=89.0), piece)


def test_what_reads_zero_on_the_scale_is_left_square() -> None:
    ring = [(0, 0), (300, 0), (300, 200), (0, 200)]
    piece = polygon_piece("0", ring, 10, [0.04, 0.06, -0.04, 0])
    found = saw_list([piece])
    assert [cut.setting for cut in found.cuts] == [0.1]
    assert sorted(cut.angle for cut in found.square) == [0.0, 0.04, 0.04]


# --- square pieces ------------------------------------------------------------------------------


def test_square_pieces_hold_the_designed_ones_in_the_same_place() -> None:
    for piece, square in zip(relieved(), square_workpieces(relieved()), strict=True):
        assert square.address == piece.address
        assert square.drills is piece.drills
        assert square.engraving is piece.engraving
        for name in ("axes", "origin", "silhouette", "lower", "upper"):
            expected = getattr(piece, "silhouette" if name in ("lower", "upper") else name)
            np.testing.assert_array_equal(getattr(square, name), expected)
        assert [side.inclination for side in square.sides] == [0.0] * len(square.silhouette)
        taken = ConvexHull(np.concatenate([s.corners for s in piece.sides])).volume - piece.volume
        assert taken > 0
        solid = outline_area(piece.silhouette) * piece.thickness
        assert square.volume == pytest.approx(solid - taken, rel=1e-9)
        cuts = {side.neighbour for side in piece.sides if side.kind == "cut"}
        assert {side.neighbour for side in square.sides if side.kind == "cut"} == cuts


def test_sides_of_square_pieces_close_around_the_outline() -> None:
    for square in square_workpieces(relieved()):
        ring = [side.corners[0, :2] for side in square.sides]
        ends = [side.corners[1, :2] for side in square.sides]
        np.testing.assert_array_equal(np.roll(ring, -1, axis=0), ends)
        for side in square.sides:
            middle = side.corners.mean(axis=0)
            area = np.cross(side.corners - middle, np.roll(side.corners, -1, axis=0) - middle)
            assert area.sum(axis=0) @ side.normal > 0
            np.testing.assert_allclose((side.corners - middle) @ side.normal, 0, atol=1e-9)
        start = np.arctan2(square.sides[0].normal[1], square.sides[0].normal[0])
        assert -3 / 4 * np.pi - 1e-9 <= start < 0


def test_square_pieces_stay_as_they_are() -> None:
    for piece in (*workpieces(plate(300, 200), label=LABEL), *workpieces(hexagon(200))):
        (square,) = square_workpieces([piece])
        assert square.volume == pytest.approx(piece.volume, rel=1e-12)
        assert len(saw_list([piece]).square) == len(piece.sides)
        for side, own in zip(square.sides, piece.sides, strict=True):
            np.testing.assert_allclose(side.normal, own.normal, atol=1e-9)
            assert (side.kind, side.neighbour) == (own.kind, own.neighbour)


def test_a_corner_between_sides_that_lean_two_ways_is_a_border() -> None:
    ring = [(0, 0), (300, 0), (300, 200), (0, 200)]
    piece = polygon_piece("0", ring, 10, [30, -30, 30, -30])
    (square,) = square_workpieces([piece])
    assert len(square.sides) == 8
    short = 10 * math.tan(math.radians(30)) * math.sqrt(2)
    for side in square.sides:
        own = {s.neighbour: s for s in piece.sides}.get(side.neighbour)
        if np.count_nonzero(np.abs(side.normal) > 1e-9) == 2:  # across a corner
            assert (side.kind, side.neighbour) == ("border", "")
            assert np.linalg.norm(side.corners[1] - side.corners[0]) == pytest.approx(short)
        else:
            assert own is not None
            assert side.kind == own.kind


def test_square_pieces_go_the_way_of_all_workpieces(tmp_path) -> None:
    squares = square_workpieces(relieved())
    layout = in_rows(relieved())  # of the designed pieces
    pieces = {square.address: square for square in squares}
    assert export_dxf(layout.sheets[0], pieces, tmp_path / "sheet.dxf").stat().st_size
    export_btlx(squares, tmp_path / "square.btlx")
    lines = list(ET.parse(tmp_path / "square.btlx").iter(f"{{{NAMESPACE}}}Line"))
    assert len(lines) == sum(len(square.silhouette) for square in squares)
    assert {line.get("Inclination") for line in lines} == {"0.0"}
    for entry in cut_list(squares).entries:
        assert [edge.inclination for edge in entry.edges] == [0.0] * len(entry.edges)
        assert [edge.upper for edge in entry.edges] == pytest.approx(
            [edge.lower for edge in entry.edges]
        )


def test_list_is_written_as_csv(tmp_path) -> None:
    found = saw_list(relieved(), steepest=80.0)
    path = export_csv(found, tmp_path / "saw.csv")
    with path.open(newline="") as handle:
        header, *rows = csv.reader(handle, quoting=csv.QUOTE_NONNUMERIC)
    assert header == [column.title for column in found.tables[0].columns]
    assert len(rows) == len(found)
    for row, cut in zip(rows, found.cuts, strict=True):
        told = dict(zip(header, row, strict=True))
        assert told["address"] == cut.address
        assert told["face up"] == cut.up
        assert told["blade angle (deg)"] == cut.angle
        assert told["setback (mm)"] == cut.setback
    assert [table.name for table in found.tables] == ["saw", "by hand", "settings", "square"]
    assert len(found.tables[1].rows) == len(found.by_hand)


def test_settings_that_cannot_be_meant_are_refused() -> None:
    pieces = workpieces(plate(300, 200))
    for step in (0.0, -1.0, math.inf, math.nan):
        with pytest.raises(InputError, match="step of the saw's scale"):
            saw_list(pieces, step=step)
    for steepest in (0.0, 90.0, math.nan):
        with pytest.raises(InputError, match="blade tilts"):
            saw_list(pieces, steepest=steepest)
    with pytest.raises(InputError, match="Two workpieces"):
        saw_list([*pieces, replace(pieces[0])])


def test_prototype_is_sawn(monkeypatch) -> None:
    monkeypatch.setattr(ifs, "to_assembly", lambda *arguments, **options: None)
    part = Path(__file__).parents[1] / "parts" / "shell_prototype.py"
    shell = runpy.run_path(str(part), {"show_object": lambda *shown, **options: None})["shell"]
    pieces = workpieces(shell, label=Label(cutter=3.0), holes=Holes(5.0, 25.0))
    found = saw_list(pieces)
    assert_every_edge_is_listed_once(found, pieces)
    for piece in pieces[::16]:
        assert_saw_leaves_the_piece(found, piece)
    assert not found.by_hand  # its nodes are exact: no relief cuts, and every side is a whole one
    assert len(found) + len(found.square) == 1024
