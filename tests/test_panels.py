"""Panels as solids with labels and holes, against closed forms and where tools would have been."""

import cadquery as cq
import numpy as np
import pytest
from brep import assert_solid, cylinders, each, planes, points, volume
from hypothesis import given, settings
from hypothesis import strategies as st
from OCP.TopAbs import TopAbs_EDGE
from strategies import accepted, shells
from vaults import GROUND, THICKNESS, hexagon, plate, roof, vault

from ifs_cad import progress
from ifs_cad.elements.cutting import cutting_frames
from ifs_cad.elements.groove import outline
from ifs_cad.elements.hole import Holes, place_holes
from ifs_cad.elements.label import Label, place_labels
from ifs_cad.elements.polyhedron import Kind
from ifs_cad.errors import HoleError, InputError, LabelError
from ifs_cad.kernel import engrave
from ifs_cad.kernel.bore import bore
from ifs_cad.kernel.panels import as_label, make_panels, to_solid

DEPTH = 0.5


def closed_forms(shell, label, holes):
    """Return the volume of each panel less what label and holes take."""
    frames = cutting_frames(shell, label.face, label.up)
    places = place_holes(shell.addresses, frames, holes)
    labels = place_labels(shell.addresses, frames, label, places)
    cylinder = np.pi / 4 * holes.diameter**2 * shell.thickness
    left = shell.volumes - cylinder * places.present.sum(axis=1)
    for k in range(len(shell)):
        left[k] -= label.depth * outline(labels.strokes(k), label.cutter / 2).area
    return left


@pytest.mark.parametrize(
    "shell",
    [
        *(vault(side=side) for side in ("outer", "inner", "centre")),
        vault(floor=GROUND),
        vault(nodes="axis"),
        vault(clearance=0.5),
        vault().without("12"),
        hexagon(200),
        roof(400, 300, 50),
    ],
    ids=["outer", "inner", "centre", "floor", "axis", "clearance", "door", "hexagon", "roof"],
)
@pytest.mark.parametrize("face", ["inner", "outer"])
def test_engraved_and_pierced_panels_are_exact_solids(shell, face):
    label, holes = Label(face=face, depth=DEPTH, cutter=2.0), Holes(6.0, 20.0)
    expected = closed_forms(shell, label, holes)
    for made, left in zip(make_panels(shell, label=label, holes=holes), expected, strict=True):
        assert made.strokes is None
        assert made.volume == pytest.approx(left, rel=1e-9)
        assert_solid(made.solid.wrapped, made.volume)


@settings(max_examples=15)
@given(
    shells(),
    st.sampled_from(["inner", "outer"]),
    st.floats(0.1, 0.95),
    st.floats(0.5, 4.0),
)
def test_engraved_panels_of_any_shell_are_exact_solids(shell, face, share, cutter):
    label = Label(face=face, depth=share * shell.thickness, cutter=cutter, margin=1.0)
    for made in accepted(make_panels, shell, label=label):
        assert_solid(made.solid.wrapped, made.volume)


@pytest.mark.parametrize("face", ["inner", "outer"])
def test_pockets_lie_in_the_upper_face_to_their_depth(face):
    (made,) = make_panels(plate(400, 300, addresses=("8",)), label=Label(face=face, depth=DEPTH))
    levels = {}
    for normal, level, _ in planes(made.solid.wrapped):
        if abs(normal[2]) > 0.5:
            key = (round(normal[2]), round(level * normal[2], 9))
            levels[key] = levels.get(key, 0) + 1
    # the table's side, the face with two islands, the floors of figure and bar
    assert levels == {(-1, 0.0): 1, (1, THICKNESS): 3, (1, THICKNESS - DEPTH): 2}
    for radius, _, axis, corners in cylinders(made.solid.wrapped):
        assert abs(axis[2]) == 1.0
        assert set(corners[:, 2].round(9)) == {THICKNESS - DEPTH, THICKNESS}
        assert radius > 0


def test_holes_go_through_at_their_places_with_their_diameter():
    shell, holes = vault(), Holes(7.0, 30.0)
    frames = cutting_frames(shell)
    places = place_holes(shell.addresses, frames, holes)
    for k, made in enumerate(make_panels(shell, holes=holes)):
        walls = cylinders(made.solid.wrapped)
        expected = places.points[k][places.present[k]]
        assert len(walls) == len(expected) == 4
        for radius, centre, axis, corners in walls:
            assert radius == pytest.approx(3.5, abs=1e-12)
            assert axis.round(12).tolist() == [0, 0, 1]
            assert set(corners[:, 2].round(9)) == {0.0, THICKNESS}
            assert np.abs(expected - centre[:2]).max(axis=1).min() < 1e-9
        assert_solid(made.solid.wrapped, shell.volumes[k] - 4 * np.pi * 3.5**2 * THICKNESS)


def test_wires_lie_on_the_face_and_follow_the_strokes():
    shell = vault()
    label = Label(style="wire")
    frames = cutting_frames(shell)
    labels = place_labels(shell.addresses, frames, label)
    for k, made in enumerate(make_panels(shell, label="wire")):
        low, high = points(made.solid.wrapped).min(axis=0), points(made.solid.wrapped).max(axis=0)
        corners = points(made.strokes.wrapped)
        np.testing.assert_allclose(corners[:, 2], THICKNESS, rtol=0, atol=1e-9)
        assert (corners >= low - 1e-9).all()
        assert (corners <= high + 1e-9).all()
        assert_solid(made.solid.wrapped, shell.volumes[k])
        assert made.volume == pytest.approx(shell.volumes[k], rel=1e-12)
        ends = np.vstack([path.vertices for path in labels.strokes(k)]) + labels.origins[k]
        assert {tuple(p) for p in corners[:, :2].round(6)} == {tuple(p) for p in ends.round(6)}
        kinds = {cq.Shape.cast(edge).geomType() for edge in each(made.strokes.wrapped, TopAbs_EDGE)}
        assert kinds <= {"LINE", "CIRCLE"}


def test_wires_do_not_cut():
    (engraved,) = make_panels(plate(400, 300), label="engraved")
    (drawn,) = make_panels(plate(400, 300), label="wire")
    assert engraved.volume < drawn.volume == pytest.approx(400 * 300 * THICKNESS)


@pytest.mark.parametrize("face", ["inner", "outer"])
def test_location_takes_every_panel_to_its_place(face):
    shell = vault()
    for k, made in enumerate(make_panels(shell, label=Label(face=face))):
        placed = made.solid.moved(made.location)
        corners = shell.solids.vertices[shell.solids.solid_of_vertex == k]
        in_place = points(placed.wrapped)
        apart = np.linalg.norm(corners[:, None] - in_place[None], axis=2).min(axis=1)
        np.testing.assert_allclose(apart, 0.0, atol=1e-7)
        # the engraving lies on the chosen face: the vertices of pockets are near it
        others = np.linalg.norm(in_place[:, None] - corners[None], axis=2).min(axis=1) > 1e-6
        foot = shell.mesh.positions[shell.mesh.offsets[shell.faces[k]]]
        height = (in_place[others] - foot) @ shell.normals[k]
        low, high = (0.0, DEPTH) if face == "inner" else (THICKNESS - DEPTH, THICKNESS)
        assert height.min() == pytest.approx(low, abs=1e-7)
        assert height.max() == pytest.approx(high, abs=1e-7)


def test_panel_of_an_address_is_a_solid_in_its_place():
    shell = vault()
    numbers = {address: k for k, address in enumerate(shell.addresses)}
    made = list(make_panels(shell, label="engraved", holes=Holes()))
    for address in ("00", "12", "33"):
        solid = to_solid(shell[address], label="engraved", holes=Holes())
        assert isinstance(solid, cq.Solid)
        whole = made[numbers[address]]
        twin = whole.solid.moved(whole.location)
        np.testing.assert_allclose(points(solid.wrapped), points(twin.wrapped), atol=1e-9)
        assert_solid(solid.wrapped, whole.volume)
    plain = to_solid(shell["12"])
    assert volume(plain.wrapped) == pytest.approx(shell["12"].volume, rel=1e-9)


def test_labels_and_holes_are_refused_before_the_first_solid():
    with pytest.raises(LabelError):
        make_panels(plate(40, 30), label="engraved")
    with pytest.raises(LabelError, match="cut through"):
        make_panels(plate(400, 300), label=Label(depth=THICKNESS))
    with pytest.raises(HoleError):
        make_panels(plate(40, 30), holes=Holes())
    with pytest.raises(HoleError):
        to_solid(plate(40, 30)["f0000"], holes=Holes())


def test_label_may_be_called_by_its_style():
    assert as_label(None) is None
    assert as_label("engraved") == Label()
    assert as_label("wire") == Label(style="wire")
    assert as_label(Label(depth=1.0)) == Label(depth=1.0)
    for wrong in ("drawn", 1, True):
        with pytest.raises(InputError, match="engraved"):
            as_label(wrong)


def test_every_panel_made_is_reported():
    heard = []
    with progress.listening(lambda *report: heard.append(report)):
        list(make_panels(vault()))
    assert heard == [("making solids", k + 1, 16) for k in range(16)]


def test_panels_share_the_shapes_of_their_glyphs_and_holes():
    engrave.pocket.cache_clear()
    bore.cache_clear()
    list(make_panels(vault(), label="engraved", holes=Holes()))
    assert engrave.pocket.cache_info().misses <= 4 * len(Label().heights)
    assert bore.cache_info().misses == 1
    assert bore(5.0, THICKNESS, Kind.LOWER).volume == pytest.approx(np.pi * 6.25 * THICKNESS)
