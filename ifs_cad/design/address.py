"""Addresses: words over the alphabet of transformations.

An element of an iterated figure is named by the indices of the transformations that built it,
coarsest first: element ``0110`` of a two-map curve is P T_1 T_2 T_2 T_1 K (digits count from 0).
Elements whose addresses share a prefix form a connected part.

Terms
-----
word : the digits of one address, first digit coarsest.
radix : how many values a digit can take.
structure : ``(steps, tail)``, the radices of a curve's digits. `steps` belong to the construction
    steps, `tail` to what follows them (the segments of a polyline germ and their folds).

Source: the paper, sections 3.1 (construction tree, figure 7) and 4.3 (a unique address for each
constructional element).
"""

from __future__ import annotations

import fnmatch
import re
from collections.abc import Iterable, Sequence
from itertools import product

import numpy as np

from ifs_cad.errors import AddressError, InputError
from ifs_cad.types import BoolArray, IntArray

Structure = tuple[tuple[int, ...], tuple[int, ...]]

DECIMAL = 10
NAMED_IN_MESSAGES = 8

__all__ = [
    "Structure",
    "curve_addresses",
    "face_addresses",
    "format_word",
    "is_dotted",
    "lexicographic_addresses",
    "listed",
    "matching",
    "parse_word",
    "surface_addresses",
    "word_at",
]


def is_dotted(radices: Iterable[int]) -> bool:
    """Tell whether words with these radices need dots between their digits (base 11 and up)."""
    return any(radix > DECIMAL for radix in radices)


def format_word(digits: Iterable[int], dotted: bool = False) -> str:
    """Write digits as an address: ``0211``, or ``3.11.0`` when dotted."""
    return ("." if dotted else "").join(str(digit) for digit in digits)


def parse_word(text: str, dotted: bool | None = None) -> tuple[int, ...]:
    """Read the digits of an address.

    Parameters
    ----------
    text : str
        ``0211`` or ``3.11.0``; the empty word has no digits.
    dotted : bool, optional
        Whether dots part the digits; by default when the text has a dot.

    Raises
    ------
    AddressError
        Something that is not a digit.
    """
    if dotted is None:
        dotted = "." in text
    parts = text.split(".") if dotted and text else list(text)
    if not all(part.isascii() and part.isdecimal() for part in parts):
        raise AddressError(
            f"{text!r} is not an address: write digits, coarsest first, with dots between them "
            "from base 11 up (0211 or 3.11.0).",
            addresses=[text],
        )
    return tuple(int(part) for part in parts)


def word_at(index: int, radices: Sequence[int]) -> tuple[int, ...]:
    """Return the digits of element number `index` (any size of integer)."""
    digits: list[int] = []
    for radix in reversed(radices):
        index, digit = divmod(index, radix)
        digits.append(digit)
    return tuple(reversed(digits))


def curve_addresses(steps: Sequence[int], tail: Sequence[int] = ()) -> list[str]:
    """Return the addresses of a curve's segments in the order of the curve.

    Parameters
    ----------
    steps, tail : sequences of int
        The curve's structure. Without any digit the only segment is called ``0``.

    Returns
    -------
    list of n str, n the product of all radices
    """
    radices = _radices((*steps, *tail))
    return _text(_digits(radices), radices)


def surface_addresses(structure_a: Structure, structure_b: Structure) -> list[str]:
    """Return the addresses of the faces of a vector sum, row by row (i of A, then j of B).

    There is one digit per construction step, ``k_a N_b + k_b``. Steps are aligned at the finest:
    when one curve is deeper its extra steps lead, with that curve's digit alone. Tails are aligned
    at the coarsest and follow the steps.

    Parameters
    ----------
    structure_a, structure_b : (steps, tail)
        The radices of the two curves' digits.

    Returns
    -------
    list of n_a n_b str
    """
    (steps_a, tail_a), (steps_b, tail_b) = structure_a, structure_b
    steps, tail = max(len(steps_a), len(steps_b)), max(len(tail_a), len(tail_b))
    radices_a, radices_b = (
        _radices((1,) * (steps - len(own)) + (*own, *end) + (1,) * (tail - len(end)))
        for own, end in ((steps_a, tail_a), (steps_b, tail_b))
    )
    digits = _digits(radices_a)[:, None] * np.array(radices_b) + _digits(radices_b)[None]
    radices = tuple(a * b for a, b in zip(radices_a, radices_b, strict=True))
    return _text(digits.reshape(-1, len(radices)), radices)


def lexicographic_addresses(rows: int, columns: int) -> list[str]:
    """Return ``row.column`` for a grid, row by row, counted from 0, padded with zeros: ``03.11``.

    Rows and columns are each padded to their own widest number, so that sorting the texts sorts
    the grid.
    """
    return [f"{row}.{column}" for row, column in product(_padded(rows, 1), _padded(columns, 1))]


def face_addresses(count: int) -> list[str]:
    """Return ``f0000``, ``f0001``, ... for the faces of a mesh that knows no words."""
    return [f"f{number}" for number in _padded(count, 4)]


def matching(addresses: Sequence[str], pattern: str | Iterable[str]) -> BoolArray:
    """Tell which addresses match a pattern, or any of several.

    Parameters
    ----------
    addresses : (n,) str
    pattern : str or iterable of str
        Shell patterns: ``*`` any text, ``?`` one character, ``[01]`` one of these. ``03*`` is
        everything with the prefix 03.

    Returns
    -------
    (n,) bool

    Raises
    ------
    AddressError
        A pattern that matches nothing.
    """
    patterns = [pattern] if isinstance(pattern, str) else list(pattern)
    found = np.zeros(len(addresses), dtype=bool)
    for one in patterns:
        match = re.compile(fnmatch.translate(one)).match
        hits = np.array([match(text) is not None for text in addresses], dtype=bool)
        if not hits.any():
            raise AddressError(
                f"No element matches {one!r}; there are {len(addresses)}: {listed(addresses)}.",
                addresses=[one],
            )
        found |= hits
    return found


def prefixes(address: str) -> list[str]:
    """Return the growing prefixes of an address, the shortest first and itself last.

    Each holds one digit more: "3.11.0" has "3", "3.11" and "3.11.0". A layer counts as one digit:
    "L07-01" has "L07", "L07-0" and "L07-01".
    """
    layer, dash, word = address.rpartition("-")
    ends = re.finditer(r"[^.]+", word) if "." in word else re.finditer(r".", word)
    grown = [f"{layer}{dash}{word[: end.end()]}" for end in ends]
    return [layer, *grown] if dash else grown


def listed(addresses: Sequence[str]) -> str:
    """Return the first few addresses for a message, and how many more there are."""
    more = len(addresses) - NAMED_IN_MESSAGES
    shown = ", ".join(addresses[:NAMED_IN_MESSAGES])
    return f"{shown} and {more} more" if more > 0 else shown


def _radices(radices: Iterable[int]) -> tuple[int, ...]:
    """Return valid radices; an element without any digit still needs a name, so one of radix 1."""
    checked = tuple(int(radix) for radix in radices) or (1,)
    if min(checked) < 1:
        raise InputError(f"Radices of an address must be 1 or more, got {checked}.")
    return checked


def _digits(radices: tuple[int, ...]) -> IntArray:
    """Return (n, digits) of the numbers 0..n-1, first digit coarsest."""
    return np.indices(radices).reshape(len(radices), -1).T


def _text(digits: IntArray, radices: tuple[int, ...]) -> list[str]:
    """Return the addresses of (n, L) digits."""
    if not is_dotted(radices):
        # One character a digit: the code points side by side already are the text.
        codes = np.ascontiguousarray(digits + ord("0"), dtype=np.uint32)
        return list(codes.view(f"U{len(radices)}")[:, 0].tolist())
    numerals = np.arange(max(radices)).astype(np.str_)
    text = numerals[digits[:, 0]]
    for place in range(1, len(radices)):
        text = np.strings.add(np.strings.add(text, "."), numerals[digits[:, place]])
    return list(text.tolist())


def _padded(count: int, least: int) -> list[str]:
    """Return the numerals 0..count-1, zero-padded to one width of at least `least`."""
    width = max(least, len(str(count - 1)))
    return [f"{number:0{width}}" for number in range(count)]
