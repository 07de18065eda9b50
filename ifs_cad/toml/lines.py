"""Where the keys and tables of a TOML text stand, for errors that name a line.

No TOML library of Python tells positions, so they are found with the parser alone: the first lines
of a file, with what is open at their end closed, are TOML too, and what they say only grows from
line to line. So a few readings find the line on which something appears; they are made when there
is an error to tell, never in reading.
"""

from __future__ import annotations

import tomllib
from bisect import bisect_left
from functools import cache
from itertools import product
from typing import Any

Place = tuple[str | int, ...]
"""The keys that lead to a value, and the index, from 0, of each entry of a list on the way."""

DEEPEST = 4
"""Brackets open at the end of a line that are closed; a line inside more is told as their first."""

QUOTES = ("", '"""', "'''")
"""What closes the text that may be open at the end of a line."""

__all__ = ["Place", "line_of"]


def line_of(text: str, place: Place) -> int | None:
    """Return the line, from 1, on which a table, key or entry of a list begins.

    Parameters
    ----------
    text : str
        TOML that can be read.
    place : tuple of str and int
        A table that is written in pieces begins at its first.

    Returns
    -------
    int or None
        None when the text does not have it, or it is the whole.
    """
    if not place or not _has(tomllib.loads(text), place):
        return None
    # only these end a line of TOML; str.splitlines would cut strings and comments elsewhere too
    lines = text.split("\n")

    @cache
    def said(count: int) -> dict[str, Any] | None:
        return _read("\n".join([*lines[:count], ""]))

    def begun(count: int) -> tuple[int, bool]:
        """Return how many of the first lines can be read, and whether they have the place."""
        while (tables := said(count)) is None:
            count -= 1
        return count, _has(tables, place)

    first = bisect_left(range(len(lines) + 1), True, key=lambda count: begun(count)[1])
    return begun(first - 1)[0] + 1


def _read(beginning: str) -> dict[str, Any] | None:
    """Return what the first lines of a file say, None when too much is open at their end."""
    for depth in range(DEEPEST + 1):
        for quotes, *brackets in product(QUOTES, *["]}"] * depth):
            try:
                return tomllib.loads("".join([beginning, quotes, *brackets]))
            except tomllib.TOMLDecodeError:
                continue  # something else is open
    return None


def _has(value: Any, place: Place) -> bool:
    for key in place:
        if isinstance(value, dict):
            if key not in value:
                return False
        elif not (isinstance(value, list) and isinstance(key, int) and key < len(value)):
            return False
        value = value[key]
    return True
