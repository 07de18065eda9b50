"""Readers of the values of TOML files: each says what it reads when it is given something else."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

__all__ = [
    "MismatchError",
    "Reader",
    "Readers",
    "flag",
    "list_of",
    "number",
    "one_of",
    "text",
    "whole",
]

Reader = Callable[[Any], Any]
"""Turns a value of a TOML file into that of a field, or raises MismatchError."""

Readers = Mapping[str, Reader]
"""How the keys of a table are read."""


class MismatchError(Exception):
    """A value is not what a reader reads; `Table.values` makes an InputError of it.

    Parameters
    ----------
    expected : str
        What it must be.
    value
        What was given.
    within : tuple of int
        The entries of lists, from 0, that lead to it.
    """

    def __init__(self, expected: str, value: Any, within: tuple[int, ...] = ()) -> None:
        super().__init__(expected)
        self.expected = expected
        self.value = value
        self.within = within


def text(value: Any) -> str:
    """Read a text."""
    if not isinstance(value, str):
        raise MismatchError("a text in quotes", value)
    return value


def number(value: Any) -> float:
    """Read a finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise MismatchError("a number", value)
    try:
        read = float(value)
    except OverflowError:
        read = math.inf
    if not math.isfinite(read):
        raise MismatchError("a finite number", value)
    return read


def whole(value: Any) -> int:
    """Read a whole number."""
    if isinstance(value, bool) or not isinstance(value, int):
        raise MismatchError("a whole number", value)
    return value


def flag(value: Any) -> bool:
    """Read true or false."""
    if not isinstance(value, bool):
        raise MismatchError("true or false", value)
    return value


def one_of(*options: str) -> Reader:
    """Return a reader of one of some texts."""

    def reader(value: Any) -> str:
        if not (isinstance(value, str) and value in options):
            *most, last = (f'"{option}"' for option in options)
            raise MismatchError(" or ".join(filter(None, [", ".join(most), last])), value)
        return value

    return reader


def list_of(item: Reader, what: str, count: int | None = None) -> Reader:
    """Return a reader of a list, of any length or of a certain one.

    Parameters
    ----------
    item : Reader
        Reads each entry.
    what : str
        What the list must be.
    count : int, optional
        How many entries it must have.
    """

    def reader(value: Any) -> tuple[Any, ...]:
        if not isinstance(value, list) or count not in (None, len(value)):
            raise MismatchError(what, value)
        found = []
        for index, entry in enumerate(value):
            try:
                found.append(item(entry))
            except MismatchError as error:
                error.within = (index, *error.within)
                raise
        return tuple(found)

    return reader
