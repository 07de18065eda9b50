"""What the labels' own modules write is read back, in every place, turn and size."""

import random

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from ifs_cad.elements.arcs import Path, Segments
from ifs_cad.elements.glyph import CHARACTERS, bar, descent, text_paths, text_positions, traced
from ifs_cad.elements.groove import MAX_CUTTER_RATIO, groove, outline
from ifs_cad.elements.label import HEIGHTS
from ifs_cad.elements.reading import Reading, read_drawn, read_engraved

LETTERS = CHARACTERS.replace(" ", "")
EASY_TO_CONFUSE = ("0O", "1Il", "5S", "69", "86", "-_", "__", "--", "...", "i.j", "oO0", "3.11.0")

texts = st.text(st.sampled_from(LETTERS), min_size=1, max_size=6)
heights = st.sampled_from(HEIGHTS)
turns = st.floats(-np.pi, np.pi)
places = st.complex_numbers(max_magnitude=2000.0, allow_nan=False, allow_infinity=False)


def turned(curves, turn, place):
    spin = np.exp(1j * turn)
    return Segments(
        curves.starts * spin + place,
        curves.ends * spin + place,
        curves.sweeps,
        curves.centres * spin + place,
    )


def floors(text, height, cutter):
    """Return the outline of every pocket of a text and of its bar."""
    positions, width = text_positions(text)
    regions = [
        [loop.moved((x * height, 0.0)) for loop in region.loops]
        for letter, x in zip(text, positions, strict=True)
        for region in groove(letter, height, cutter).regions
    ]
    below = outline([bar(width, descent(text)).scaled(height)], cutter / 2).regions[0]
    return [Segments.of(loops) for loops in (*regions, below.loops)]


def lines(text, height):
    paths, width = text_paths(text)
    drawn = traced((*paths, bar(width, descent(text))))
    return Segments.of([path.scaled(height) for path in drawn])


@pytest.mark.parametrize("height", [7.0, 28.0])
@pytest.mark.parametrize("text", [*LETTERS, *EASY_TO_CONFUSE])
def test_every_character_alone_is_read(text, height):
    cutter = MAX_CUTTER_RATIO * height
    assert read_engraved(floors(text, height, cutter)) == Reading(text, height, cutter)
    assert read_drawn(lines(text, height)) == Reading(text, height, 0.0)


@settings(max_examples=60)
@given(texts, heights, st.floats(0.05, MAX_CUTTER_RATIO), turns, places)
def test_any_engraved_text_is_read_in_any_place(text, height, share, turn, place):
    cutter = round(share * height, 3)
    found = read_engraved([turned(floor, turn, place) for floor in floors(text, height, cutter)])
    assert found is not None
    assert found.text == text
    assert found.height == pytest.approx(height, abs=1e-5)
    assert found.cutter == pytest.approx(cutter, abs=1e-6)


@settings(max_examples=60)
@given(texts, st.floats(2.0, 100.0), turns, places, st.randoms(use_true_random=False))
@example("i", 10.0, np.pi / 2, 0j, random.Random(0))
def test_any_drawn_text_is_read_in_any_order(text, height, turn, place, dice):
    strokes = lines(text, height)
    order = np.arange(len(strokes))
    dice.shuffle(order)
    found = read_drawn(turned(strokes[order], turn, place))
    assert found is not None
    assert found.text == text
    assert found.height == pytest.approx(height, abs=1e-5)


@pytest.mark.parametrize("text", ["A 7", "door  03", "x y z"])
def test_spaces_between_letters_are_read(text):
    assert read_engraved(floors(text, 14.0, 2.0)) == Reading(text, 14.0, 2.0)
    assert read_drawn(lines(text, 14.0)) == Reading(text, 14.0, 0.0)


def test_text_seen_from_behind_is_not_read():
    mirrored = [
        Segments(floor.starts.conj(), floor.ends.conj(), -floor.sweeps, floor.centres.conj())
        for floor in floors("0312", 14.0, 2.0)
    ]
    assert read_engraved(mirrored) == Reading("", 0.0, 2.0)


def test_text_is_read_among_other_pockets():
    corners = np.array([(200.0, 0), (230, 0), (230, 20), (200, 20)])
    other = Segments.of([Path(corners, np.zeros(4), closed=True)])
    slot = outline([Path(np.array([(-90.0, -50.0), (-40.0, -50.0)]), np.zeros(1))], 3.0).regions[0]
    pockets = [other, Segments.of(slot.loops), *floors("0312", 14.0, 2.0)]
    assert read_engraved(pockets) == Reading("0312", 14.0, 2.0)


def test_text_without_one_of_its_characters_is_another_or_unreadable():
    whole = floors("0312", 14.0, 2.0)
    assert read_engraved(whole[1:]) == Reading("", 0.0, 2.0)
    assert read_engraved([*whole[:1], *whole[2:]]) == Reading("", 0.0, 2.0)


def test_text_without_its_bar_is_no_label():
    assert read_engraved(floors("0312", 14.0, 2.0)[:-1]) is None
    assert read_engraved([]) is None


def test_bar_with_nothing_above_is_no_label():
    assert read_engraved(floors("0312", 14.0, 2.0)[-1:]) is None


def test_character_a_little_out_of_shape_is_not_read():
    eight = floors("8", 14.0, 2.0)
    stretched = [
        Segments(
            floor.starts.real * 1.01 + 1j * floor.starts.imag,
            floor.ends.real * 1.01 + 1j * floor.ends.imag,
            floor.sweeps,
            floor.centres.real * 1.01 + 1j * floor.centres.imag,
        )
        for floor in eight[:-1]
    ]
    assert read_engraved([*stretched, eight[-1]]) == Reading("", 0.0, 2.0)


def test_six_upside_down_is_read_by_its_bar():
    six = [turned(floor, np.pi, 0j) for floor in floors("6", 14.0, 2.0)]
    assert read_engraved(six) == Reading("6", 14.0, 2.0)
