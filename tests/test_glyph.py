"""The alphabet: what can be written, how it is placed, and the paths it is made of."""

import string

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ifs_cad.elements.arcs import Path, area, bounds, perimeter, winding
from ifs_cad.elements.glyph import (
    BAR_DROP,
    CHARACTERS,
    MAX_CUTTER_RATIO,
    SPACING,
    bar,
    descent,
    glyph,
    text_paths,
    text_positions,
)
from ifs_cad.errors import InputError, LabelError

DESCENDING = set("gjpqy")
TALL = set(string.digits + string.ascii_uppercase + "bdfhijklt")


def test_alphabet_holds_letters_digits_and_signs():
    assert set(CHARACTERS) == set(string.ascii_letters + string.digits + ".-_+ ")


@pytest.mark.parametrize("character", CHARACTERS.strip())
def test_glyph_stands_on_the_baseline_at_its_height(character):
    paths = glyph(character).paths
    (left, bottom), (right, top) = bounds(paths)
    assert left == pytest.approx(0, abs=1e-12)
    assert right == pytest.approx(glyph(character).width, abs=1e-12)
    if character in string.ascii_letters + string.digits:
        assert bottom == pytest.approx(-0.35 if character in DESCENDING else 0.0, abs=1e-3)
        assert top == pytest.approx(1.0 if character in TALL else 0.7, abs=1e-3)


@pytest.mark.parametrize("character", ["é", "\u2013", "#", "\n", "/", ",", ":"])
def test_text_names_a_character_that_cannot_be_engraved(character):
    with pytest.raises(LabelError, match="cannot be engraved") as caught:
        text_paths(f"0{character}1")
    assert repr(character) in str(caught.value)
    assert caught.value.values["character"] == character


@pytest.mark.parametrize("text", ["", "  "])
def test_text_without_strokes_is_refused(text):
    with pytest.raises(LabelError, match="nothing to engrave"):
        text_positions(text)


def test_text_positions_leave_the_spacing_between_strokes():
    positions, width = text_positions("01 1")
    zero, one, space = 0.5, 0.25, 0.25
    starts = np.cumsum([0, zero + SPACING, one + SPACING, space + SPACING])
    np.testing.assert_allclose(positions, starts, atol=1e-12)
    assert width == pytest.approx(starts[-1] + one)


@given(st.permutations("0123456789-.f"))
def test_width_does_not_depend_on_the_order_of_characters(shuffled):
    assert text_positions("".join(shuffled))[1] == text_positions("0123456789-.f")[1]


@given(st.text(CHARACTERS.strip(), min_size=1, max_size=6))
def test_text_paths_stay_in_order_and_apart(text):
    paths, width = text_paths(text)
    positions, _ = text_positions(text)
    lefts = np.array([bounds([path])[0, 0] for path in paths])
    rights = np.array([bounds([path])[1, 0] for path in paths])
    owner = np.repeat(np.arange(len(text)), [len(glyph(c).paths) for c in text])
    for k in range(1, len(text)):
        gap = lefts[owner == k].min() - rights[owner == k - 1].max()
        assert gap == pytest.approx(SPACING)
    assert lefts.min() == pytest.approx(0, abs=1e-9)
    assert rights.max() == pytest.approx(width, abs=1e-9)
    assert lefts[owner == len(text) - 1].min() == pytest.approx(positions[-1], abs=1e-9)


def test_spacing_keeps_wood_between_the_widest_grooves():
    land, land_above_bar = SPACING - MAX_CUTTER_RATIO, BAR_DROP - MAX_CUTTER_RATIO
    assert (land, land_above_bar) == pytest.approx((0.1, 0.1))


def test_nine_is_six_turned_by_half():
    size = np.array([glyph("6").width, 1.0])
    turned = [Path(size - path.vertices, path.bulges, path.closed) for path in glyph("9").paths]
    for six, nine in zip(glyph("6").paths, turned, strict=True):
        np.testing.assert_allclose(six.vertices, nine.vertices, atol=1e-12)
        np.testing.assert_allclose(six.bulges, nine.bulges, atol=1e-12)


def test_bar_spans_the_text_below_its_lowest_stroke():
    _, width = text_positions("0123")
    assert bar(width).vertices.tolist() == [[0.0, -BAR_DROP], [width, -BAR_DROP]]
    assert descent("0123") == 0.0
    assert descent("py") == pytest.approx(0.35)
    np.testing.assert_allclose(bar(1.0, 0.35).vertices[:, 1], -0.35 - BAR_DROP)


def test_bar_under_a_narrow_text_is_centred():
    np.testing.assert_allclose(bar(0.0).vertices[:, 0], [-0.25, 0.25])
    np.testing.assert_allclose(bar(0.3).vertices[:, 0], [-0.1, 0.4])


def test_bounds_include_the_belly_of_an_arc():
    half_circle = Path(np.array([(1.0, 0.0), (-1.0, 0.0)]), np.ones(1))
    np.testing.assert_allclose(bounds([half_circle]), [(-1, 0), (1, 1)], atol=1e-15)
    clockwise = Path(np.array([(0.0, 2.0), (0.0, -2.0)]), -np.ones(1))
    np.testing.assert_allclose(bounds([clockwise]), [(0, -2), (2, 2)], atol=1e-15)


def test_area_and_perimeter_of_a_stadium_match_the_closed_form():
    stadium = Path(
        np.array([(0.0, -1.0), (3.0, -1.0), (3.0, 1.0), (0.0, 1.0)]),
        np.array([0.0, 1.0, 0.0, 1.0]),
        closed=True,
    )
    assert area(stadium) == pytest.approx(6 + np.pi, rel=1e-14)
    assert perimeter(stadium) == pytest.approx(6 + 2 * np.pi, rel=1e-14)
    assert perimeter(stadium.scaled(2)) == pytest.approx(12 + 4 * np.pi, rel=1e-14)


def test_winding_counts_points_between_chord_and_arc():
    disc = Path(np.array([(1.0, 0.0), (-1.0, 0.0)]), np.ones(2), closed=True)
    points = [(0.0, 0.0), (0.0, 0.999), (0.5, -0.8), (0.0, 1.001), (0.8, 0.7), (-2.0, 0.0)]
    assert winding(disc, points).tolist() == [1, 1, 1, 0, 0, 0]
    bitten = Path(np.array([(1.0, 0.0), (-1.0, 0.0)]), np.array([1.0, -0.5]), closed=True)
    assert winding(bitten, [(0.0, 0.4), (0.0, 0.6)]).tolist() == [0, 1]


@pytest.mark.parametrize(
    ("vertices", "bulges", "closed"),
    [
        (np.zeros((0, 2)), np.zeros(0), False),
        (np.zeros((2, 3)), np.zeros(1), False),
        (np.array([(0.0, 0.0), (1.0, 0.0)]), np.zeros(2), False),
        (np.array([(0.0, 0.0)]), np.zeros(1), True),
        (np.array([(0.0, 0.0), (np.nan, 0.0)]), np.zeros(1), False),
        (np.array([(0.0, 0.0), (0.0, 0.0)]), np.zeros(1), False),
    ],
)
def test_path_refuses_what_is_no_chain(vertices, bulges, closed):
    with pytest.raises(InputError):
        Path(vertices, bulges, closed)


def test_path_is_read_only_and_copies_its_input():
    vertices = np.array([(0.0, 0.0), (1.0, 0.0)])
    path = Path(vertices, np.zeros(1))
    vertices[0] = 5
    assert path.vertices[0].tolist() == [0, 0]
    with pytest.raises(ValueError, match="read-only"):
        path.vertices[0] = 1
