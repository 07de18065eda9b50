"""Nested sheets as STEP files: every panel in its place, the engraved face up."""

import re
from dataclasses import replace

import cadquery as cq
import numpy as np
import pytest
from brep import assert_solid, planes, points, volume
from layouts import STOCK, in_rows
from step_readers import gmsh_model, needs_freecad, read_by_freecad, read_by_gmsh
from vaults import GROUND, THICKNESS, vault

from ifs_cad import progress
from ifs_cad.elements.hole import Holes
from ifs_cad.elements.label import Label
from ifs_cad.errors import InputError
from ifs_cad.export.step import export_sheets, export_step
from ifs_cad.fabrication.operations import workpieces
from ifs_cad.kernel.assembly import STROKES_SUFFIX, to_assembly
from ifs_cad.kernel.panels import make_panels
from ifs_cad.kernel.sheet import sheet_assembly

SHELL = vault(floor=GROUND)
DEPTH = 0.5
MADE = {"inner": {"label": Label(), "holes": Holes()}, "outer": {"label": Label(face="outer")}}


@pytest.fixture(scope="module", params=MADE)
def made(request):
    """An assembly of nested groups, its workpieces, and a layout of them."""
    options = MADE[request.param]
    pieces = {piece.address: piece for piece in workpieces(SHELL, **options)}
    assembly = to_assembly(SHELL, **options, nest=1)
    return options, assembly, pieces, in_rows(list(pieces.values()))


@pytest.fixture(scope="module")
def written(made, tmp_path_factory):
    """The files of the sheets."""
    _, assembly, _, layout = made
    return export_sheets(layout, assembly, tmp_path_factory.mktemp("sheets") / "new")


@pytest.fixture(scope="module")
def read(written):
    """What CadQuery reads from them."""
    return [cq.Assembly.importStep(str(path)) for path in written]


def solids_of(sheet):
    """Return the one solid of each part in place, by name."""
    found = {}
    for child in sheet.children:
        (found[child.name],) = child.obj.moved(sheet.loc * child.loc).Solids()
    return found


def box(piece, place):
    """Return the lower and upper corner of a placed piece."""
    outline = place(piece.silhouette)
    return np.array([[*outline.min(axis=0), 0.0], [*outline.max(axis=0), piece.thickness]])


def same_points(some, others):
    apart = np.linalg.norm(some[:, None] - others[None], axis=2)
    return max(apart.min(axis=0).max(), apart.min(axis=1).max())


def test_files_are_named_as_the_sheets_and_hold_their_parts(made, written, read):
    _, assembly, _, layout = made
    assert [path.name for path in written] == ["sheet-01.step", "sheet-02.step"]
    for sheet, found in zip(layout.sheets, read, strict=True):
        assert found.name == sheet.name
        assert [c.name for c in found.children] == [place.address for place in sheet.placements]
        for child in found.children:
            wanted = assembly.objects[child.name].color.toTuple()
            assert child.color.toTuple() == pytest.approx(wanted, abs=1e-3)


def test_volumes_and_outlines_are_those_of_the_placed_workpieces(made, read):
    options, _, pieces, layout = made
    closed_form = dict(
        zip(SHELL.addresses, (p.volume for p in make_panels(SHELL, **options)), strict=True)
    )
    for sheet, file in zip(layout.sheets, read, strict=True):
        found = solids_of(file)
        for place in sheet.placements:
            piece, solid = pieces[place.address], found[place.address]
            assert_solid(solid.wrapped, closed_form[place.address])
            assert piece.volume == pytest.approx(closed_form[place.address], rel=1e-9)
            corners = points(solid.wrapped)
            spanned = np.array([corners.min(axis=0), corners.max(axis=0)])
            np.testing.assert_allclose(spanned, box(piece, place), rtol=0, atol=1e-6)
            assert (spanned[0] >= 0).all()
            assert (spanned[1, :2] <= [STOCK.length, STOCK.width]).all()
            for up, level, outline in ((1, THICKNESS, piece.upper), (-1, 0.0, piece.lower)):
                faces = [
                    ring[:, :2]
                    for normal, at, ring in planes(solid.wrapped)
                    if normal[2] * up > 1 - 1e-9 and abs(up * at - level) < 1e-6
                ]
                largest = max(faces, key=lambda ring: np.ptp(ring, axis=0).sum())
                assert same_points(largest, place(outline)) < 1e-6


def test_pockets_open_upwards(read):
    for sheet in read:
        for solid in solids_of(sheet).values():
            floors = {
                (round(float(normal[2])), round(float(level * normal[2]), 6))
                for normal, level, _ in planes(solid.wrapped)
                if abs(normal[2]) > 1 - 1e-9
            }
            assert floors == {(-1, 0.0), (1, THICKNESS - DEPTH), (1, THICKNESS)}


def test_gmsh_finds_every_part_with_its_name_place_and_volume(made, written):
    _, assembly, pieces, layout = made
    for sheet, path in zip(layout.sheets, written, strict=True):
        with gmsh_model() as model:
            found = read_by_gmsh(model, path)
            assert found.keys() == {place.address for place in sheet.placements}
            for place in sheet.placements:
                part, tag = assembly.objects[place.address], found[place.address]
                mass = part.metadata["volume"]
                assert model.occ.getMass(3, tag) == pytest.approx(mass, rel=1e-9)
                flat = np.array([part.obj.Center().toTuple()])
                middle = model.occ.getCenterOfMass(3, tag)
                np.testing.assert_allclose(middle, place(flat)[0], rtol=0, atol=1e-6)
                spanned = np.reshape(model.occ.getBoundingBox(3, tag), (2, 3))
                wanted = box(pieces[place.address], place)
                np.testing.assert_allclose(spanned, wanted, rtol=0, atol=1e-6)


@needs_freecad
def test_freecad_finds_every_part_with_its_label_place_and_volume(made, written, tmp_path):
    _, assembly, pieces, layout = made
    sheet, path = layout.sheets[1], written[1]
    found = read_by_freecad(path, tmp_path)
    assert found.keys() == {place.address for place in sheet.placements}
    for place in sheet.placements:
        here = found[place.address]
        assert here["group"] == [sheet.name]
        assert here["solids"] == 1
        mass = assembly.objects[place.address].metadata["volume"]
        assert here["volume"] == pytest.approx(mass, rel=1e-9)
        wanted = box(pieces[place.address], place)
        np.testing.assert_allclose(here["box"], wanted, rtol=0, atol=1e-6)
        frame = np.reshape(here["placement"], (4, 4))
        np.testing.assert_allclose(frame[:2, :2], place.rotation, rtol=0, atol=1e-12)
        np.testing.assert_allclose(frame[:3, 3], [place.x, place.y, 0.0], rtol=0, atol=1e-9)


def test_products_of_all_files_together_are_the_addresses_once_each(written):
    text = "".join(path.read_text("ascii") for path in written)
    names = re.findall(r"PRODUCT\('([^']*)'", text)
    assert sorted(names) == sorted([*SHELL.addresses, *(path.stem for path in written)])


def test_wires_lie_on_top_of_their_panels(tmp_path):
    shell = vault().part("0*")
    pieces = workpieces(shell, label=Label(style="wire"))
    (sheet,) = in_rows(pieces).sheets
    laid = sheet_assembly(sheet, to_assembly(shell, label="wire"))
    read = cq.Assembly.importStep(str(export_step(laid, tmp_path / "wires.step")))
    found = {child.name: child.obj.moved(child.loc) for child in read.children}
    assert found.keys() == {a + end for a in shell.addresses for end in ("", STROKES_SUFFIX)}
    for piece, place in zip(pieces, sheet.placements, strict=True):
        strokes = points(found[piece.address + STROKES_SUFFIX].wrapped)
        np.testing.assert_allclose(strokes[:, 2], THICKNESS, rtol=0, atol=1e-6)
        engraved = np.concatenate([place(s.vertices) for s in piece.engraving.strokes])
        assert same_points(strokes[:, :2], engraved) < 1e-6


def test_modified_part_lies_on_its_sheet_as_it_is_now():
    shell = vault()
    assembly = to_assembly(shell, label="engraved")
    layout = in_rows(workpieces(shell, label=Label()))
    part = assembly.objects["12"]
    part.obj = part.obj.cut(cq.Solid.makeBox(80, 60, 50))
    sheet, place = layout.homes["12"]
    laid = sheet_assembly(sheet, assembly).objects["12"]
    left = volume(part.obj.wrapped)
    assert left < part.metadata["volume"] * 0.99
    assert volume(laid.obj.wrapped) == pytest.approx(left, rel=1e-12)
    middle = place(np.array([part.obj.Center().toTuple()]))[0]
    found = laid.obj.moved(laid.loc).Center().toTuple()
    np.testing.assert_allclose(found, middle, rtol=0, atol=1e-6)


def test_assembly_keeps_its_places_when_its_parts_are_laid_out(made):
    _, assembly, pieces, layout = made
    for sheet in layout.sheets:
        sheet_assembly(sheet, assembly)
    for address, piece in pieces.items():
        frame = assembly.objects[address].loc.wrapped.Transformation()
        found = np.array([[frame.Value(i, j) for j in range(1, 5)] for i in range(1, 4)])
        wanted = np.column_stack([piece.axes.T, piece.origin])
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9)


def test_part_that_is_not_in_the_assembly_is_an_error_before_any_file(made, tmp_path):
    _, assembly, _, layout = made
    last = layout.sheets[-1]
    stray = replace(last.placements[0], address="nowhere")
    broken = replace(last, placements=(*last.placements, stray))
    with pytest.raises(InputError, match="sheet-02 holds nowhere, but the assembly") as caught:
        export_sheets(replace(layout, sheets=(layout.sheets[0], broken)), assembly, tmp_path)
    assert caught.value.addresses == ("nowhere",)
    assert list(tmp_path.iterdir()) == []


def test_progress_counts_the_sheets(made, tmp_path):
    _, assembly, _, layout = made
    told = []
    with progress.listening(lambda *report: told.append(report)):
        export_sheets(layout, assembly, tmp_path)
    assert [report for report in told if report[0] == "writing sheets"] == [
        ("writing sheets", 1, 2),
        ("writing sheets", 2, 2),
    ]
