"""Addresses: words over the alphabet of transformations."""

from itertools import product
from math import prod

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ifs_cad.design.address import (
    curve_addresses,
    face_addresses,
    format_word,
    is_dotted,
    lexicographic_addresses,
    listed,
    matching,
    parse_word,
    prefixes,
    surface_addresses,
    word_at,
)
from ifs_cad.errors import AddressError, InputError

radices = st.lists(st.integers(1, 4), max_size=2).map(tuple)
structures = st.tuples(radices, radices)


def expected_surface_words(structure_a, structure_b):
    """Spell out the rule of surface addresses digit by digit."""
    (steps_a, tail_a), (steps_b, tail_b) = structure_a, structure_b
    words = []
    for i, j in product(range(prod(steps_a + tail_a)), range(prod(steps_b + tail_b))):
        a, b = list(word_at(i, steps_a + tail_a)), list(word_at(j, steps_b + tail_b))
        word = []
        for place in range(-max(len(steps_a), len(steps_b)), 0):
            if -place > len(steps_a):
                word.append(b[place + len(steps_b)])
            elif -place > len(steps_b):
                word.append(a[place + len(steps_a)])
            else:
                digit_b = b[place + len(steps_b)]
                word.append(a[place + len(steps_a)] * steps_b[place] + digit_b)
        for place in range(max(len(tail_a), len(tail_b))):
            if place >= len(tail_a):
                word.append(b[len(steps_b) + place])
            elif place >= len(tail_b):
                word.append(a[len(steps_a) + place])
            else:
                digit_b = b[len(steps_b) + place]
                word.append(a[len(steps_a) + place] * tail_b[place] + digit_b)
        words.append(word)
    return words


def test_curve_addresses_two_maps_count_in_base_two():
    assert curve_addresses((2, 2)) == ["00", "01", "10", "11"]


def test_curve_addresses_germ_adds_a_last_digit():
    assert curve_addresses((2,), (3,)) == ["00", "01", "02", "10", "11", "12"]


def test_curve_addresses_base_ten_has_no_dots():
    assert curve_addresses((10,))[-1] == "9"
    assert curve_addresses((10, 10))[-2:] == ["98", "99"]


def test_curve_addresses_base_eleven_has_dots():
    addresses = curve_addresses((11, 2))
    assert addresses[:3] == ["0.0", "0.1", "1.0"]
    assert addresses[-1] == "10.1"


def test_curve_addresses_without_digits_still_name_the_only_segment():
    assert curve_addresses(()) == ["0"]
    assert surface_addresses(((), ()), ((), ())) == ["0"]


def test_curve_addresses_radix_zero_is_an_error():
    with pytest.raises(InputError, match="1 or more"):
        curve_addresses((2, 0))


def test_surface_addresses_two_map_curves_use_digits_0_to_3():
    addresses = surface_addresses(((2, 2), ()), ((2, 2), ()))
    # Row 01 and column 10: digits 0*2+1 and 1*2+0.
    assert addresses[1 * 4 + 2] == "12"
    assert sorted(addresses) == [f"{a}{b}" for a in range(4) for b in range(4)]


def test_surface_addresses_deeper_curve_leads_with_its_own_digit():
    deeper_a = surface_addresses(((2, 2), ()), ((2,), ()))
    assert deeper_a == ["00", "01", "02", "03", "10", "11", "12", "13"]
    deeper_b = surface_addresses(((2,), ()), ((2, 2), ()))
    assert deeper_b == ["00", "01", "10", "11", "02", "03", "12", "13"]


def test_surface_addresses_tails_follow_the_steps():
    addresses = surface_addresses(((2,), (3,)), ((2, 2), ()))
    # Row 1 of A with germ segment 2, column 01 of B: lead 0, then 1*2+1, then 2.
    assert addresses[(1 * 3 + 2) * 4 + 1] == "032"


def test_surface_addresses_four_maps_are_dotted():
    addresses = surface_addresses(((4, 4, 4), ()), ((4, 4, 4), ()))
    row, column = 0 * 16 + 2 * 4 + 0, 3 * 16 + 3 * 4 + 0
    assert addresses[row * 64 + column] == "3.11.0"


@given(structures, structures)
def test_surface_addresses_follow_the_rule_and_are_unique(structure_a, structure_b):
    words = expected_surface_words(structure_a, structure_b)
    (steps_a, tail_a), (steps_b, tail_b) = structure_a, structure_b
    ones_a = (1,) * (len(steps_b) - len(steps_a)) + steps_a
    ones_b = (1,) * (len(steps_a) - len(steps_b)) + steps_b
    ends_a = tail_a + (1,) * (len(tail_b) - len(tail_a))
    ends_b = tail_b + (1,) * (len(tail_a) - len(tail_b))
    dotted = is_dotted(a * b for a, b in zip(ones_a + ends_a, ones_b + ends_b, strict=True))
    addresses = surface_addresses(structure_a, structure_b)
    assert addresses == [format_word(word, dotted) or "0" for word in words]
    assert len(set(addresses)) == len(addresses)
    assert len({len(parse_word(address, dotted)) for address in addresses}) == 1


@given(st.lists(st.integers(0, 40), max_size=8).map(tuple))
def test_parse_word_reads_what_format_word_writes(digits):
    assert parse_word(format_word(digits, dotted=True), dotted=True) == digits
    if max(digits, default=0) < 10:
        assert parse_word(format_word(digits)) == digits


@pytest.mark.parametrize("text", ["0a", "1..2", "-1", "1.2.", "²"])
def test_parse_word_refuses_what_is_not_a_digit(text):
    with pytest.raises(AddressError, match="not an address"):
        parse_word(text)


def test_word_at_gives_the_first_digit_coarsest():
    assert word_at(7, (2, 3, 2)) == (1, 0, 1)
    assert word_at(2**70 - 1, (2,) * 70) == (1,) * 70


def test_lexicographic_addresses_pad_to_the_widest():
    addresses = lexicographic_addresses(16, 16)
    assert addresses[3 * 16 + 11] == "03.11"
    assert addresses == sorted(addresses)
    assert lexicographic_addresses(4, 200)[3 * 200 + 11] == "3.011"


def test_face_addresses_have_at_least_four_digits():
    assert face_addresses(43)[42] == "f0042"
    assert face_addresses(10001)[42] == "f00042"


def test_matching_prefix_takes_the_part():
    addresses = curve_addresses((4, 4))
    assert matching(addresses, "03*").tolist() == [word == "03" for word in addresses]
    assert matching(addresses, ["0*", "?1"]).sum() == 4 + 3


def test_matching_dot_is_only_a_dot():
    assert matching(["1.0", "110"], "1.0").tolist() == [True, False]


def test_matching_nothing_is_an_error_that_shows_addresses():
    with pytest.raises(AddressError, match=r"'9\*'.*00, 01, 10, 11") as caught:
        matching(curve_addresses((2, 2)), ["0*", "9*"])
    assert caught.value.addresses == ("9*",)


def test_listed_names_the_first_few():
    assert listed(["a", "b"]) == "a, b"
    assert listed([str(i) for i in range(11)]) == "0, 1, 2, 3, 4, 5, 6, 7 and 3 more"


@pytest.mark.parametrize(
    ("address", "grown"),
    [
        ("0312", ["0", "03", "031", "0312"]),
        ("3.11.0", ["3", "3.11", "3.11.0"]),
        ("7", ["7"]),
        ("f0042", ["f", "f0", "f00", "f004", "f0042"]),
        ("L07-01", ["L07", "L07-0", "L07-01"]),
        ("L07-3.11", ["L07", "L07-3", "L07-3.11"]),
        ("L007-1", ["L007", "L007-1"]),
    ],
)
def test_prefixes_grow_by_one_digit_and_a_layer_is_one(address, grown):
    assert prefixes(address) == grown


@given(st.lists(st.integers(0, 40), min_size=1, max_size=8).map(tuple), st.booleans())
def test_prefixes_are_the_words_of_the_steps_before(digits, layered):
    dotted, layer = max(digits) > 9, "L12" if layered else ""
    dash = "-" if layered else ""
    words = [f"{layer}{dash}{format_word(digits[: k + 1], dotted)}" for k in range(len(digits))]
    if not (dotted and len(digits) == 1):  # a lone digit of two figures looks like two digits
        assert prefixes(words[-1]) == ([layer, *words] if layered else words)
