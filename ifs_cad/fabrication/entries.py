"""Entries of TOML files: tables whose keys are the fields of a dataclass, every key checked.

An error names the file, the table and the key, and says what was expected.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from ifs_cad.errors import InputError

Reader = Callable[[Any], Any]
"""Turns a value of a TOML file into that of a field, or raises TypeError with what it must be."""

Readers = Mapping[str, Reader]
"""How the keys of a table are read; a key is required where its field has no default."""


def parsed(source: Path | Traversable, name: str) -> dict[str, Any]:
    """Return the tables of a TOML file.

    Raises
    ------
    InputError
        It cannot be read, or is not TOML.
    """
    try:
        return tomllib.loads(source.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{name} cannot be read: {error.strerror or error}.") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{name} is not UTF-8 text: {error}. Save it as UTF-8.") from error
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{name} is not TOML: {error}.") from error


def text(value: Any) -> str:
    """Read a text."""
    if not isinstance(value, str):
        raise TypeError("a text in quotes")
    return value


def number(value: Any) -> float:
    """Read a finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise TypeError("a number")
    return float(value)


def whole(value: Any) -> int:
    """Read a whole number."""
    if isinstance(value, bool) or not isinstance(value, int):
        raise TypeError("a whole number")
    return value


def flag(value: Any) -> bool:
    """Read true or false."""
    if not isinstance(value, bool):
        raise TypeError("true or false")
    return value


def span(value: Any) -> tuple[float, float]:
    """Read a least and a largest number."""
    if not isinstance(value, list) or len(value) != 2:
        raise TypeError("two numbers, the least and the largest")
    return number(value[0]), number(value[1])


def place(value: Any) -> tuple[float, float]:
    """Read x and y."""
    if not isinstance(value, list) or len(value) != 2:
        raise TypeError("two numbers, x and y")
    return number(value[0]), number(value[1])


def texts(value: Any) -> tuple[str, ...]:
    """Read a list of texts."""
    if not (isinstance(value, list) and all(isinstance(item, str) for item in value)):
        raise TypeError("a list of texts in quotes")
    return tuple(value)


def tables(value: Any, where: str) -> list[tuple[str, Any]]:
    """Return the rows of a list of tables, each with what errors call it.

    Raises
    ------
    InputError
        It is not a list.
    """
    if not isinstance(value, list):
        raise InputError(f"{where} must be a list of tables: write [[...]] before each.")
    rows = []
    for place, row in enumerate(value, 1):
        label = f"{where} entry {place}"
        if isinstance(row, dict) and isinstance(row.get("name"), str):
            label += f" ({row['name']})"
        rows.append((label, row))
    return rows


def values(table: Any, readers: Readers, where: str) -> dict[str, Any]:
    """Return the values of one table.

    Raises
    ------
    InputError
        It is not a table, has an unknown key, or a value that cannot be read.
    """
    if not isinstance(table, dict):
        raise InputError(f"{where} must be a table of keys and values, got {table!r}.")
    read = {}
    for key, value in table.items():
        if key not in readers:
            raise InputError(f"{where}: unknown key {key!r}. Known are {', '.join(readers)}.")
        try:
            read[key] = readers[key](value)
        except TypeError as error:
            raise InputError(f"{where}: {key} must be {error}, got {value!r}.") from error
    return read


def made(kind: type[Any], given: Mapping[str, Any], where: str) -> Any:
    """Return a dataclass made of the values of one table.

    Raises
    ------
    InputError
        A key is missing, or the dataclass refuses a value.
    """
    required = [f.name for f in fields(kind) if f.default is MISSING]
    missing = [key for key in required if key not in given]
    if missing:
        raise InputError(f"{where}: {', '.join(missing)} missing. Add {missing[0]} = ...")
    try:
        return kind(**given)
    except InputError as error:
        raise InputError(f"{where}: {error}") from error
