"""DXF drawings: what ezdxf and GDAL read from them."""

import json
import shutil
import subprocess
from collections import Counter
from dataclasses import replace

import ezdxf
import numpy as np
import pytest
from layouts import STOCK, area, in_rows
from shapely import LineString, Point, Polygon
from vaults import GROUND, THICKNESS, roof, vault

from ifs_cad.elements.arcs import Path, Segments
from ifs_cad.elements.cutting import cutting_frames
from ifs_cad.elements.hole import Holes
from ifs_cad.elements.label import Label
from ifs_cad.elements.polyhedron import Kind
from ifs_cad.errors import ExportError, InputError
from ifs_cad.export.dxf import APPLICATION, COLOURS, export_dxf, export_workpiece_dxf
from ifs_cad.fabrication.layout import Placement
from ifs_cad.fabrication.operations import workpieces

SHELL = vault(floor=GROUND)
GRAIN = np.array([0.8, 0.6])


def engraving_of(pieces):
    return sum(Segments.of(piece.engraving.strokes).lengths.sum() for piece in pieces)


@pytest.fixture(scope="module")
def pieces():
    """Relieved, trimmed, engraved and pierced panels; one of them may lie as it likes."""
    made = workpieces(SHELL, label=Label(), holes=Holes())
    free = SHELL.addresses[1]
    return {p.address: replace(p, fibre=None if p.address == free else GRAIN) for p in made}


@pytest.fixture(scope="module")
def layout(pieces):
    return in_rows(list(pieces.values()))


@pytest.fixture(scope="module")
def drawn(pieces, layout, tmp_path_factory):
    """Every sheet with the file that shows it."""
    folder = tmp_path_factory.mktemp("dxf")
    return [(s, export_dxf(s, pieces, folder / f"{s.name}.dxf")) for s in layout.sheets]


def told(entity):
    """Return the address and the values that an entity carries."""
    (_, address), *pairs = [tag for tag in entity.get_xdata(APPLICATION) if tag.code != 1001]
    return address, {pairs[k].value: pairs[k + 1].value for k in range(0, len(pairs), 2)}


def by_address(space, layer):
    """Return the entities of a layer, and what they carry, for each address."""
    found = {}
    for entity in space.query(f'*[layer=="{layer}"]'):
        address, values = told(entity)
        found.setdefault(address, []).append((entity, values))
    return found


def corners(polyline):
    return np.array(polyline.get_points("xy"))


def same_ring(ring, other):
    """Tell how far two rings are apart that begin at the same corner."""
    assert ring.shape == other.shape
    return np.abs(ring - other).max()


def test_layout_needs_several_sheets_and_lays_every_piece(pieces, layout):
    assert len(layout.sheets) == 2
    assert layout.homes.keys() == pieces.keys() == set(SHELL.addresses)


def test_auditor_finds_no_errors_and_millimetres_and_layers_are_set(drawn):
    for _, path in drawn:
        document = ezdxf.readfile(path)
        audit = document.audit()
        assert (audit.errors, audit.fixes) == ([], [])
        assert document.acad_release == "R2010"
        assert document.units == ezdxf.units.MM == document.header["$INSUNITS"]
        assert {n: document.layers.get(n).color for n in COLOURS} == COLOURS
        assert len(set(COLOURS.values())) == len(COLOURS)


def test_every_entity_is_there_once_on_its_layer(drawn, pieces):
    for sheet, path in drawn:
        here = [pieces[place.address] for place in sheet.placements]
        strokes = [stroke for piece in here for stroke in piece.engraving.strokes]
        expected = {
            ("SHEET", "LWPOLYLINE"): 1,
            ("OFFCUTS", "LWPOLYLINE"): 1,
            ("OUTLINE_TOP", "LWPOLYLINE"): len(here),
            ("OUTLINE_BOTTOM", "LWPOLYLINE"): len(here),
            ("HOLES", "CIRCLE"): sum(len(p.drills[0].points) for p in here if p.drills),
            ("ENGRAVING", "LWPOLYLINE"): len(strokes),
            ("FIBRE", "LWPOLYLINE"): sum(piece.fibre is not None for piece in here),
            ("TEXT", "TEXT"): len(here),
            ("ANGLES", "TEXT"): sum(len(piece.sides) for piece in here),
        }
        space = ezdxf.readfile(path).modelspace()
        assert Counter((e.dxf.layer, e.dxftype()) for e in space) == expected
        assert {e.dxf.color for e in space} == {ezdxf.const.BYLAYER}


def test_outlines_lie_where_the_pieces_are_placed(drawn, pieces):
    frames = cutting_frames(SHELL)
    areas = frames.solids.face_areas
    for sheet, path in drawn:
        space = ezdxf.readfile(path).modelspace()
        raw, offcut = (space.query(f'*[layer=="{n}"]').first for n in ("SHEET", "OFFCUTS"))
        assert corners(raw).tolist() == [[0, 0], [2500, 0], [2500, 1250], [0, 1250]]
        x, y, length, width = sheet.offcuts[0]
        rectangle = [[x, y], [x + length, y], [x + length, y + width], [x, y + width]]
        assert corners(offcut).tolist() == rectangle
        for layer, name, z, kind in (
            ("OUTLINE_TOP", "upper", THICKNESS, Kind.LOWER),  # the inner face is marked
            ("OUTLINE_BOTTOM", "lower", 0.0, Kind.UPPER),
        ):
            found = by_address(space, layer)
            assert found.keys() == {place.address for place in sheet.placements}
            for place in sheet.placements:
                [(outline, values)] = found[place.address]
                assert outline.closed
                assert values == {"z": z}
                ring = corners(outline)
                piece = pieces[place.address]
                assert same_ring(ring, place(getattr(piece, name))) < 1e-9
                number = SHELL.addresses.index(place.address)
                face = (frames.solids.solid_of_face == number) & (frames.solids.kinds == kind)
                assert area(ring) == pytest.approx(areas[face].item(), rel=1e-9)


def test_quarter_turns_take_x_to_y(tmp_path):
    """A plate of 300 x 200 turned by hand."""
    (piece,) = workpieces(vault(floor=GROUND).take([0]))
    ring = np.array([(0.0, 0.0), (300.0, 0.0), (300.0, 200.0), (0.0, 200.0)])
    plain = replace(piece, address="a", upper=ring, lower=ring, silhouette=ring, sides=())
    sheet = replace(in_rows([plain]).sheets[0], placements=(Placement("a", 90.0, 210.0, 7.0),))
    space = ezdxf.readfile(export_dxf(sheet, {"a": plain}, tmp_path / "a.dxf")).modelspace()
    (outline,) = space.query('*[layer=="OUTLINE_TOP"]')
    assert corners(outline).tolist() == [[210, 7], [210, 307], [10, 307], [10, 7]]


def test_holes_are_circles_of_their_diameter_and_depth(drawn, pieces):
    for sheet, path in drawn:
        found = by_address(ezdxf.readfile(path).modelspace(), "HOLES")
        for place in sheet.placements:
            (drill,) = pieces[place.address].drills
            circles = found[place.address]
            centres = np.array([circle.dxf.center.xyz for circle, _ in circles])
            np.testing.assert_allclose(centres[:, :2], place(drill.points), rtol=0, atol=1e-9)
            assert {circle.dxf.radius for circle, _ in circles} == {2.5}
            assert [values for _, values in circles] == [{"depth": THICKNESS}] * len(circles)


def test_engraving_has_the_length_and_the_arcs_of_the_strokes(drawn, pieces):
    """Lines and arcs as ezdxf understands the bulges."""
    for sheet, path in drawn:
        found = by_address(ezdxf.readfile(path).modelspace(), "ENGRAVING")
        for place in sheet.placements:
            strokes = pieces[place.address].engraving.strokes
            assert len(found[place.address]) == len(strokes)
            for stroke, (polyline, values) in zip(strokes, found[place.address], strict=True):
                assert values == {"depth": 0.5, "cutter": 3.0}
                segments = list(polyline.virtual_entities())
                lengths = [
                    s.dxf.start.distance(s.dxf.end)
                    if s.dxftype() == "LINE"
                    else s.dxf.radius * np.radians((s.dxf.end_angle - s.dxf.start_angle) % 360)
                    for s in segments
                ]
                ours = Segments.of([stroke]).lengths
                np.testing.assert_allclose(lengths, ours, rtol=1e-9)
                arcs = [s.dxf.center.xyz[:2] for s in segments if s.dxftype() == "ARC"]
                centres = place(stroke.centres[stroke.bulges != 0.0])
                np.testing.assert_allclose(np.reshape(arcs, (-1, 2)), centres, rtol=0, atol=1e-6)


def test_engraving_stays_inside_the_upper_outline(drawn, pieces):
    for sheet, path in drawn:
        found = by_address(ezdxf.readfile(path).modelspace(), "ENGRAVING")
        for place in sheet.placements:
            outline = Polygon(place(pieces[place.address].upper)).buffer(-1.5)
            for polyline, _ in found[place.address]:
                assert outline.contains(LineString(corners(polyline)))


def test_dot_is_a_point_and_a_closed_stroke_is_closed(tmp_path, pieces):
    dot = Path(np.array([(30.0, 40.0)]), np.zeros(0))
    ring = Path(np.array([(50.0, 40.0), (54.0, 40.0)]), np.ones(2), closed=True)
    piece = next(iter(pieces.values()))
    piece = replace(piece, engraving=replace(piece.engraving, strokes=(dot, ring)))
    space = ezdxf.readfile(export_workpiece_dxf(piece, tmp_path / "dot.dxf")).modelspace()
    [(point, values), (circle, _)] = by_address(space, "ENGRAVING")[piece.address]
    assert point.dxftype() == "POINT"
    assert point.dxf.location.xyz == (30.0, 40.0, 0.0)
    assert values == {"depth": 0.5, "cutter": 3.0}
    arcs = list(circle.virtual_entities())
    assert [(arc.dxftype(), arc.dxf.radius) for arc in arcs] == [("ARC", 2.0)] * 2
    assert [arc.dxf.center.xyz for arc in arcs] == [(52.0, 40.0, 0.0)] * 2


def test_fibre_arrow_points_along_the_grain_inside_the_piece(drawn, pieces):
    for sheet, path in drawn:
        found = by_address(ezdxf.readfile(path).modelspace(), "FIBRE")
        for place in sheet.placements:
            piece = pieces[place.address]
            if piece.fibre is None:
                assert place.address not in found
                continue
            [(arrow, _)] = found[place.address]
            points = corners(arrow)
            tail, tip = points[:2]
            turn = np.radians(place.turn + np.degrees(np.arctan2(0.6, 0.8)))
            along = (tip - tail) / np.hypot(*(tip - tail))
            np.testing.assert_allclose(along, [np.cos(turn), np.sin(turn)], atol=1e-12)
            assert ((points[2:] - tip) @ along <= 0).all()
            assert Polygon(place(piece.silhouette)).contains(LineString(points))


def test_addresses_are_written_once_and_inside_their_piece(drawn, pieces):
    for sheet, path in drawn:
        space = ezdxf.readfile(path).modelspace()
        texts = {text.dxf.text: text for text in space.query('*[layer=="TEXT"]')}
        assert texts.keys() == {place.address for place in sheet.placements}
        for place in sheet.placements:
            text = texts[place.address]
            assert told(text) == (place.address, {})
            assert text.dxf.rotation == place.turn
            spot = Point(text.get_placement()[1].xyz)
            assert Polygon(place(pieces[place.address].silhouette)).contains(spot)


def test_angles_are_exact_for_programs_and_rounded_for_people(drawn, pieces):
    for sheet, path in drawn:
        found = by_address(ezdxf.readfile(path).modelspace(), "ANGLES")
        for place in sheet.placements:
            piece = pieces[place.address]
            written = found[place.address]
            assert [values for _, values in written] == [
                {"inclination": side.inclination, "kind": side.kind, "neighbour": side.neighbour}
                for side in piece.sides
            ]
            for side, (text, values) in zip(piece.sides, written, strict=True):
                assert abs(float(text.dxf.text) - values["inclination"]) <= 0.05 + 1e-9
                # abreast of the middle of the side, inside both outlines, running along it
                spot = np.array(text.get_placement()[1].xyz[:2])
                outward = place.rotation @ side.normal[:2] / np.hypot(*side.normal[:2])
                along = np.array([-outward[1], outward[0]])
                plan = place(side.corners[:, :2])
                assert spot @ along == pytest.approx(
                    ((plan @ along).min() + (plan @ along).max()) / 2
                )
                assert spot @ outward == pytest.approx((plan @ outward).min() - 2.0)
                turn = np.radians(text.dxf.rotation)
                assert abs(outward @ [np.cos(turn), np.sin(turn)]) < 1e-9


def test_angle_stands_upright_and_inside_on_every_side(tmp_path):
    """A roof bent by 2 x 20 degrees, its inner face up: narrower at the top at its ridge."""
    piece = workpieces(roof(400.0, 300.0, 20.0), label=Label())[1]
    space = ezdxf.readfile(export_workpiece_dxf(piece, tmp_path / "roof.dxf")).modelspace()
    angles = list(space.query('*[layer=="ANGLES"]'))
    assert sorted(text.dxf.text for text in angles) == ["-20.0", "0.0", "0.0", "0.0"]
    (ridge,) = [text for text in angles if text.dxf.text == "-20.0"]
    _, values = told(ridge)
    assert values["inclination"] == pytest.approx(-20.0, abs=1e-9)
    assert (values["kind"], values["neighbour"]) == (
        "cut",
        workpieces(roof(400, 300, 20))[0].address,
    )
    middle = piece.silhouette.mean(axis=0)
    for text in angles:
        turn = np.radians(text.dxf.rotation)
        assert np.cos(turn) > -1e-9
        align, spot, _ = text.get_placement()
        rise = np.array([-np.sin(turn), np.cos(turn)])
        if align.name == "TOP_CENTER":
            rise = -rise
        else:
            assert align.name == "BOTTOM_CENTER"
        assert (middle - spot.xyz[:2]) @ rise > 0


def test_zero_has_no_sign(tmp_path, pieces):
    piece = next(iter(pieces.values()))
    piece = replace(piece, sides=(replace(piece.sides[0], inclination=-0.04),))
    space = ezdxf.readfile(export_workpiece_dxf(piece, tmp_path / "zero.dxf")).modelspace()
    (text,) = space.query('*[layer=="ANGLES"]')
    assert text.dxf.text == "0.0"
    assert told(text)[1]["inclination"] == -0.04


def test_piece_alone_is_drawn_in_its_own_frame_without_a_sheet(tmp_path, pieces):
    piece = pieces[SHELL.addresses[5]]
    document = ezdxf.readfile(export_workpiece_dxf(piece, tmp_path / "new" / "one.dxf"))
    assert not document.audit().has_errors
    space = document.modelspace()
    assert {e.dxf.layer for e in space} == COLOURS.keys() - {"SHEET", "OFFCUTS"}
    [(outline, _)] = by_address(space, "OUTLINE_TOP")[piece.address]
    assert corners(outline).tolist() == piece.upper.tolist()
    assert {told(e)[0] for e in space} == {piece.address}


def test_face_that_a_floor_took_whole_has_no_outline(tmp_path, pieces):
    piece = replace(next(iter(pieces.values())), lower=np.empty((0, 2)))
    space = ezdxf.readfile(export_workpiece_dxf(piece, tmp_path / "a.dxf")).modelspace()
    assert len(space.query('*[layer=="OUTLINE_BOTTOM"]')) == 0
    assert len(space.query('*[layer=="OUTLINE_TOP"]')) == 1


def test_missing_workpieces_are_named_and_nothing_is_written(tmp_path, pieces, layout):
    sheet = layout.sheets[0]
    lacking = sheet.placements[2].address
    some = {address: piece for address, piece in pieces.items() if address != lacking}
    with pytest.raises(InputError, match=rf"sheet-01 holds {lacking}") as caught:
        export_dxf(sheet, some, tmp_path / "sheet.dxf")
    assert caught.value.addresses == (lacking,)
    assert list(tmp_path.iterdir()) == []


def test_failing_export_keeps_the_good_file(tmp_path, pieces, monkeypatch):
    target = tmp_path / "a.dxf"
    target.write_text("a good file")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(ezdxf.document.Drawing, "saveas", full)
    with pytest.raises(ExportError, match=r"a\.dxf: No space left"):
        export_workpiece_dxf(next(iter(pieces.values())), target)
    assert target.read_text() == "a good file"
    assert list(tmp_path.iterdir()) == [target]


# --- GDAL has a reader of its own -------------------------------------------------------------


# nothing rounded, arcs as chords of a tenth of a degree
FORMAT = ["-f", "GeoJSON", "-lco", "COORDINATE_PRECISION=12"]
ARCS = ["--config", "OGR_ARC_STEPSIZE", "0.1"]


@pytest.mark.skipif(shutil.which("ogr2ogr") is None, reason="ogr2ogr (gdal-bin) is not installed")
def test_gdal_finds_the_same(drawn, pieces):
    for sheet, path in drawn:
        answer = subprocess.run(
            ["ogr2ogr", *FORMAT, *ARCS, "/vsistdout/", str(path), "entities"],
            capture_output=True,
            text=True,
            check=True,
        )
        assert answer.stderr == ""
        here = {place.address: pieces[place.address] for place in sheet.placements}
        layers = {name: [] for name in COLOURS}
        for feature in json.loads(answer.stdout)["features"]:
            text = feature["properties"].get("Text")
            points = np.array(feature["geometry"]["coordinates"])
            layers[feature["properties"]["Layer"]].append((text, points[..., :2]))

        [(_, raw)] = layers["SHEET"]
        assert Polygon(raw).bounds == (0, 0, STOCK.length, STOCK.width)
        for layer, name in (("OUTLINE_TOP", "upper"), ("OUTLINE_BOTTOM", "lower")):
            assert len(layers[layer]) == len(here)
            for place, (_, ring) in zip(sheet.placements, layers[layer], strict=True):
                assert ring[0].tolist() == ring[-1].tolist()
                assert same_ring(ring[:-1], place(getattr(here[place.address], name))) < 1e-9
        drilled = np.concatenate(
            [p(d.points) for p in sheet.placements for d in here[p.address].drills]
        )
        circles = [Polygon(ring) for _, ring in layers["HOLES"]]
        assert len(circles) == len(drilled)
        centres = [(circle.centroid.x, circle.centroid.y) for circle in circles]
        np.testing.assert_allclose(centres, drilled, rtol=0, atol=1e-6)
        np.testing.assert_allclose([c.area for c in circles], np.pi * 2.5**2, rtol=1e-5)
        engraved = sum(LineString(line).length for _, line in layers["ENGRAVING"])
        assert engraved == pytest.approx(engraving_of(here.values()), rel=1e-6)
        assert sorted(text for text, _ in layers["TEXT"]) == sorted(here)
        sides = [side for piece in here.values() for side in piece.sides]
        assert [text for text, _ in layers["ANGLES"]] == [f"{s.inclination:z.1f}" for s in sides]
        assert len(layers["FIBRE"]) == sum(piece.fibre is not None for piece in here.values())
