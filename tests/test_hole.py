"""Where fixation holes pierce panels: in their corners, at the inset, on both faces."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import shells
from vaults import GROUND, THICKNESS, hexagon, plate, roof, vault

from ifs_cad.design.mesh import Mesh
from ifs_cad.elements.cutting import cutting_frames
from ifs_cad.elements.hole import Holes, place_holes
from ifs_cad.elements.polyhedron import Kind
from ifs_cad.elements.thicken import thicken
from ifs_cad.errors import HoleError, InputError


def pierced(shell, holes, face="inner"):
    frames = cutting_frames(shell, face)
    return frames, place_holes(shell.addresses, frames, holes)


def room(frames, index, points):
    """Return (points, sides) least distances of places from each side, on either face; and kinds.

    A side is the plane of a face that is not of the sheet; it is nearest on one of the two faces.
    """
    solids = frames.solids
    faces = np.arange(*solids.solid_offsets[index : index + 2])
    faces = faces[solids.kinds[faces] > Kind.UPPER]
    normals, levels = solids.normals[faces], solids.levels[faces]
    inside = levels - points @ normals[:, :2].T
    both = np.stack([inside, inside - frames.thickness * normals[:, 2]])
    return both.min(axis=0) / np.linalg.norm(normals[:, :2], axis=1), solids.kinds[faces]


def test_plate_takes_a_hole_in_each_corner():
    for face in ("inner", "outer"):
        _, places = pierced(plate(400, 300), Holes(6.0, 25.0), face)
        assert places.present.all()
        assert {tuple(p) for p in np.round(places.points[0], 9)} == {
            (25, 25),
            (375, 25),
            (375, 275),
            (25, 275),
        }
        assert places.diameter == 6.0


@pytest.mark.parametrize("face", ["inner", "outer"])
@pytest.mark.parametrize("angle", [10.0, 40.0])
def test_inset_is_kept_on_the_smaller_face(face, angle):
    frames, places = pierced(roof(400, 300, angle), Holes(6.0, 25.0), face)
    for k in range(2):
        x, y = places.points[k][places.present[k]].T
        assert np.ptp(x) == pytest.approx(300 - 50, abs=1e-9)
        assert np.ptp(y) == pytest.approx(400 - 50, abs=1e-9)  # not 400 + t tan(angle) - 50
        distances, _ = room(frames, k, places.points[k])
        assert distances.min() == pytest.approx(25.0, abs=1e-9)


def test_hexagon_takes_six_holes():
    frames, places = pierced(hexagon(200), Holes(5.0, 20.0))
    assert places.present.sum() == 6
    middle = frames.solids.vertices[:, :2].max(axis=0) / 2
    apart = np.linalg.norm(places.points[0] - middle, axis=1)
    # the corners of a hexagon inside by the inset
    np.testing.assert_allclose(apart, 200 - 20 / np.cos(np.pi / 6), rtol=1e-12)


@settings(max_examples=60)
@given(
    shells(),
    st.floats(2.0, 15.0),
    st.floats(1.0, 60.0),
    st.sampled_from(["inner", "outer"]),
)
def test_every_hole_keeps_its_distances_or_is_left_out(shell, diameter, beyond, face):
    holes = Holes(diameter, diameter / 2 + beyond, fewest=0)
    frames, places = pierced(shell, holes, face)
    for k in range(len(shell)):
        points = places.points[k][places.present[k]]
        if len(points) == 0:
            continue
        distances, kinds = room(frames, k, points)
        relief = kinds == Kind.RELIEF
        assert (distances[:, ~relief] >= holes.inset - 1e-5).all()
        assert (distances[:, relief] >= diameter / 2 - 1e-5).all()
        touching = (np.abs(distances[:, ~relief] - holes.inset) < 1e-5).sum(axis=1)
        assert (touching >= 2).all()
        assert len(np.unique(points.round(6), axis=0)) == len(points)
    few = places.present.sum(axis=1) < 2
    if few.any():
        with pytest.raises(HoleError) as caught:
            place_holes(shell.addresses, frames, Holes(diameter, holes.inset))
        assert caught.value.addresses == tuple(np.array(shell.addresses)[few])


def test_relieved_corners_take_holes_like_whole_ones():
    relieved, whole = vault(), vault(nodes="plain")
    assert (relieved.solids.kinds == Kind.RELIEF).any()
    assert not (whole.solids.kinds == Kind.RELIEF).any()
    holes = Holes(5.0, 25.0)
    pierced_in_place = []
    for shell in (relieved, whole):
        frames, places = pierced(shell, holes)
        assert (places.present.sum(axis=1) == 4).all()
        points = [places.points[k][places.present[k]] for k in range(len(shell))]
        # as places in the shell: a relief cut may move the corner of the bounding box
        in_place = [
            np.column_stack([p, np.full(4, THICKNESS)]) @ frames.axes[k] + frames.origins[k]
            for k, p in enumerate(points)
        ]
        pierced_in_place.append([p[np.lexsort(p.round(6).T)] for p in in_place])
    np.testing.assert_allclose(*pierced_in_place, rtol=0, atol=1e-8)


def test_corners_that_the_floor_made_take_holes_and_lost_ones_do_not():
    shell = vault(floor=GROUND)
    frames, places = pierced(shell, Holes(5.0, 25.0, fewest=0))
    feet = 0
    for k in range(len(shell)):
        distances, kinds = room(frames, k, places.points[k][places.present[k]])
        assert (distances[:, kinds != Kind.RELIEF] >= 25 - 1e-6).all()
        feet += int((kinds == Kind.FLOOR).any())
    assert feet == (shell.solids.kinds == Kind.FLOOR).sum() > 0


def test_panel_with_room_for_too_few_holes_is_named():
    corners = [(0, 0, 0), (400, 0, 0), (400, 300, 0), (0, 300, 0), (440, 0, 0), (440, 300, 0)]
    mesh = Mesh(corners, [(0, 1, 2, 3), (1, 4, 5, 2)], addresses=("wide", "narrow"))
    shell = thicken(mesh, THICKNESS)
    with pytest.raises(HoleError, match="fewer than 2 holes 25 mm from their sides: narrow") as err:
        pierced(shell, Holes(5.0, 25.0))
    assert err.value.addresses == ("narrow",)
    _, places = pierced(shell, Holes(5.0, 25.0, fewest=0))
    assert places.present.sum(axis=1).tolist() == [4, 0]
    _, places = pierced(shell, Holes(5.0, 19.0))
    assert places.present.sum(axis=1).tolist() == [4, 4]


def test_holes_of_some_panels_are_taken_as_they_are():
    _, places = pierced(vault(), Holes())
    some = places.take(np.array([3, 1]))
    np.testing.assert_array_equal(some.points, places.points[[3, 1]])
    np.testing.assert_array_equal(some.present, places.present[[3, 1]])
    assert some.diameter == places.diameter


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"diameter": 0.0}, "diameter must be positive"),
        ({"diameter": float("inf")}, "diameter must be positive"),
        ({"diameter": 60.0}, "inset must exceed the radius 30 mm"),
        ({"inset": 2.5}, "inset must exceed the radius 2.5 mm"),
        ({"inset": float("nan")}, "inset must exceed"),
        ({"fewest": -1}, "fewest"),
    ],
)
def test_holes_refuse_what_cannot_be_meant(options, said):
    with pytest.raises(InputError, match=said):
        Holes(**options)
