"""Where addresses stand on panels: inside, clear, upright, and as large as fits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog
from strategies import accepted, shells
from vaults import THICKNESS, hexagon, plate, roof, vault

from ifs_cad.design.mesh import Mesh
from ifs_cad.elements.arcs import bounds, distance_to_strokes
from ifs_cad.elements.cutting import cutting_frames
from ifs_cad.elements.glyph import bar, descent, text_positions
from ifs_cad.elements.hole import HolePlaces, Holes, place_holes
from ifs_cad.elements.label import HEIGHTS, Label, place_labels
from ifs_cad.elements.polyhedron import Kind
from ifs_cad.elements.thicken import thicken
from ifs_cad.errors import InputError, LabelError

labels = st.builds(
    Label,
    face=st.sampled_from(["inner", "outer"]),
    style=st.sampled_from(["engraved", "wire"]),
    depth=st.floats(0.05, 0.9),
    cutter=st.floats(0.5, 5.0),
    margin=st.sampled_from([0.0, 5.0, 30.0]),
    height=st.sampled_from([20.0, 28.0, 80.0]),
)


def placed(shell, label, holes=None):
    frames = cutting_frames(shell, label.face, label.up)
    places = None if holes is None else place_holes(shell.addresses, frames, holes)
    return frames, places, place_labels(shell.addresses, frames, label, places)


def sides_of(frames, index, depth):
    """Return (k, 3) lines a . (x, y) <= level that bound panel and tool, from its side planes."""
    solids = frames.solids
    faces = np.arange(*solids.solid_offsets[index : index + 2])
    faces = faces[solids.kinds[faces] > Kind.UPPER]
    lines = []
    for z in (frames.thickness, frames.thickness - depth):
        levels = solids.levels[faces] - solids.normals[faces, 2] * z
        lines.append(np.column_stack([solids.normals[faces, :2], levels]))
    lines = np.vstack(lines)
    return lines / np.linalg.norm(lines[:, :2], axis=1)[:, None]


def slack(lines, text, height, label):
    """Return by how much more the box of a text could keep from the sides, by linear programming.

    Negative when it does not fit with its margin.
    """
    _, width = text_positions(text)
    (left, below), (right, _) = bounds([bar(width, descent(text))])
    half = (height * np.array([right - left, 1.0 - below]) + label.groove_width) / 2
    room = lines[:, 2] - np.abs(lines[:, :2]) @ half - label.margin
    answer = linprog(
        [0, 0, -1],
        A_ub=np.column_stack([lines[:, :2], np.ones(len(lines))]),
        b_ub=room,
        bounds=(None, None),
        method="highs",
    )
    assert answer.status == 0, answer.message
    return answer.x[2]


@settings(max_examples=40)
@given(shells(), labels)
def test_label_fits_its_panel_and_no_larger_one_would(shell, label):
    frames = cutting_frames(shell, label.face, label.up)
    depth = label.depth if label.style == "engraved" else 0.0
    lines = [sides_of(frames, k, depth) for k in range(len(shell))]
    try:
        result = place_labels(shell.addresses, frames, label)
    except LabelError as error:
        lacking = set(error.addresses)
        assert lacking
        for address, sides in zip(shell.addresses, lines, strict=True):
            least = slack(sides, address, label.heights[0], label)
            assert least < 1e-5 if address in lacking else least > -1e-5
        return
    for k, (sides, height) in enumerate(zip(lines, result.heights, strict=True)):
        low, high = bounds(result.strokes(k)) + result.origins[k]
        corners = np.array([(x, y) for x in (low[0], high[0]) for y in (low[1], high[1])])
        apart = (sides[:, 2] - corners @ sides[:, :2].T).min()
        assert apart >= label.groove_width / 2 + label.margin - 1e-5
        larger = [h for h in label.heights if h > height]
        assert not larger or slack(sides, shell.addresses[k], larger[0], label) < 1e-5


def test_label_stands_in_the_middle_of_its_panel():
    frames, _, result = placed(plate(400, 300), Label(height=80.0))
    assert result.texts == ("f0000",)
    assert result.heights.tolist() == [80.0]
    low, high = bounds(result.strokes(0)) + result.origins[0]
    np.testing.assert_allclose((low + high) / 2, [200, 150], atol=1e-9)
    assert high[0] > low[0] + 80
    assert frames.solids.vertices[:, :2].max(axis=0).tolist() == [400, 300]


def assert_clear_of_holes(shell, label, holes):
    _, places, result = placed(shell, label, holes)
    for k in range(len(shell)):
        centres = places.points[k][places.present[k]] - result.origins[k]
        apart = distance_to_strokes(result.strokes(k), centres)
        assert apart.min() >= (holes.diameter + label.groove_width) / 2 + label.margin - 1e-6
    return result.heights


@pytest.mark.parametrize("shell", [vault(), roof(300, 200, 30), hexagon(150)])
@pytest.mark.parametrize("face", ["inner", "outer"])
def test_labels_keep_clear_of_holes(shell, face):
    label = Label(face=face, margin=8.0, height=80.0)
    heights = assert_clear_of_holes(shell, label, Holes(diameter=12.0, inset=22.0))
    assert (placed(shell, label)[2].heights >= heights).all()


@given(
    st.floats(80.0, 400.0),
    st.floats(80.0, 400.0),
    st.floats(1.0, 30.0),
    st.floats(0.0, 40.0),
    st.floats(0.0, 20.0),
)
def test_labels_between_holes_keep_their_margin(length, width, diameter, beyond, margin):
    holes = Holes(diameter, diameter / 2 + 1 + beyond, fewest=1)
    label = Label(margin=margin, height=80.0, style="wire")
    accepted(assert_clear_of_holes, plate(length, width), label, holes)


def test_holes_make_a_label_smaller_where_they_must():
    shell, label = plate(200, 120), Label(height=80.0)
    _, _, free = placed(shell, label)
    _, _, tight = placed(shell, label, Holes(diameter=10.0, inset=40.0))
    assert tight.heights[0] < free.heights[0]


def holes_at(shell, *places, diameter=10.0):
    points = np.array([places], dtype=float)
    return HolePlaces(points, np.ones(points.shape[:2], dtype=bool), diameter)


def test_label_moves_aside_from_a_hole_in_the_middle():
    shell, label = plate(600, 200), Label(height=56.0)
    frames = cutting_frames(shell, "inner")
    holes = holes_at(shell, (300, 100))
    free = place_labels(shell.addresses, frames, label)
    moved = place_labels(shell.addresses, frames, label, holes)
    assert moved.heights[0] == free.heights[0] == 56.0
    assert not np.allclose(moved.origins, free.origins)
    low, high = bounds(moved.strokes(0)) + moved.origins[0]
    middle, half = (low + high) / 2, (high - low) / 2
    reach = label.groove_width / 2 + label.margin
    assert (low >= reach - 1e-9).all()
    assert (high <= np.array([600, 200]) - reach + 1e-9).all()
    gap = np.maximum(np.abs(middle - [300, 100]) - half - reach, 0.0)
    assert np.hypot(*gap) >= 5.0 - 1e-9
    # it moves as little as one of five steps to a corner or a side of its room allows
    room = np.array([300, 100]) - half - reach
    tried = [
        share * np.array(way) * room
        for share in (0.2, 0.4, 0.6, 0.8, 1.0)
        for way in ((1, 0), (0, 1), (1, 1), (1, -1))
    ]
    clear = [
        np.hypot(*way)
        for way in tried
        if np.hypot(*np.maximum(np.abs(way) - half - reach, 0.0)) >= 5.0
    ]
    assert np.hypot(*(middle - [300, 100])) == pytest.approx(min(clear), abs=1e-9)


@given(
    st.lists(st.tuples(st.floats(20, 580), st.floats(20, 180)), min_size=1, max_size=6),
    st.floats(1.0, 30.0),
)
def test_labels_that_move_aside_keep_their_margin(places, diameter):
    shell, label = plate(600, 200), Label(height=56.0)
    frames, holes = cutting_frames(shell, "inner"), holes_at(shell, *places, diameter=diameter)
    result = accepted(place_labels, shell.addresses, frames, label, holes)
    low, high = bounds(result.strokes(0)) + result.origins[0]
    reach = label.groove_width / 2 + label.margin
    assert (low >= reach - 1e-6).all()
    assert (high <= np.array([600, 200]) - reach + 1e-6).all()
    apart = np.maximum(np.maximum(low - places, places - high) - reach, 0.0)
    assert (np.hypot(*apart.T) >= diameter / 2 - 1e-6).all()


def test_label_that_cannot_move_aside_gets_smaller_or_is_refused():
    shell, label = plate(300, 100), Label(height=56.0)
    frames = cutting_frames(shell, "inner")
    free = place_labels(shell.addresses, frames, label)
    few = holes_at(shell, *[(x, 50) for x in range(30, 300, 120)])
    assert place_labels(shell.addresses, frames, label, few).heights[0] < free.heights[0]
    many = holes_at(shell, *[(x, y) for x in range(10, 300, 20) for y in range(10, 100, 20)])
    with pytest.raises(LabelError, match="between the sides and holes of f0000"):
        place_labels(shell.addresses, frames, label, many)


def test_label_heights_are_a_stepped_series():
    assert Label(height=80.0, cutter=1.0).heights == HEIGHTS[2:]
    assert Label().heights == (14.0, 20.0, 28.0)  # a 3 mm cutter needs 12 mm
    assert Label(min_height=20.0).heights == (20.0, 28.0)
    assert Label(style="wire").heights == HEIGHTS[:8]
    ratios = np.diff(np.log(HEIGHTS))
    assert (np.abs(ratios - np.log(2) / 2) < 0.03).all()


def test_strokes_begin_at_the_origin_and_the_bar_lies_below():
    _, _, result = placed(plate(400, 300), Label())
    *text, under = result.strokes(0)
    (left, below), (_, above) = bounds(text)
    assert left == pytest.approx(0.0, abs=1e-9)
    assert (below, above) == pytest.approx((0.0, 28.0), abs=1e-9)
    assert (under.vertices[:, 1] < -28 * 0.25).all()


def test_label_without_room_names_its_panels():
    corners = [(0, 0, 0), (400, 0, 0), (400, 300, 0), (0, 300, 0), (430, 0, 0), (430, 300, 0)]
    mesh = Mesh(corners, [(0, 1, 2, 3), (1, 4, 5, 2)], addresses=("wide", "narrow"))
    shell = thicken(mesh, THICKNESS)
    with pytest.raises(LabelError, match=r"14 mm high.*narrow") as caught:
        placed(shell, Label())
    assert caught.value.addresses == ("narrow",)
    assert caught.value.values["height"] == 14.0


@pytest.mark.parametrize("depth", [THICKNESS, 2 * THICKNESS])
def test_label_as_deep_as_the_panel_is_an_error(depth):
    with pytest.raises(LabelError, match="cut through panels of 10 mm"):
        placed(plate(400, 300), Label(depth=depth))
    _, _, drawn = placed(plate(400, 300), Label(style="wire", depth=depth))
    assert drawn.heights.tolist() == [28.0]


def test_address_outside_the_alphabet_is_an_error():
    with pytest.raises(LabelError, match="'ä' cannot be engraved"):
        placed(plate(400, 300, addresses=("ä",)), Label())


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"face": "top"}, "face"),
        ({"style": "painted"}, "style"),
        ({"depth": 0.0}, "depth must be positive"),
        ({"depth": float("nan")}, "depth must be positive"),
        ({"cutter": -3.0}, "cutter must be positive"),
        ({"margin": -1.0}, "margin"),
        ({"margin": float("inf")}, "margin"),
        ({"up": (0, 0, 0)}, "up"),
        ({"up": (0, np.nan, 0)}, "up"),
        ({"height": 12.0}, "No cap height"),
        ({"min_height": 29.0}, "No cap height"),
        ({"cutter": 30.0}, "No cap height"),
        ({"height": float("nan")}, "No cap height"),
    ],
)
def test_label_refuses_what_cannot_be_meant(options, said):
    with pytest.raises(InputError, match=said):
        Label(**options)
