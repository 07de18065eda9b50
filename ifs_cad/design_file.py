"""Designs in files: TOML that a designer can read, change by hand and keep under version control.

A file has a version, so that a later one is refused with a sentence instead of misread. Numbers
have all their digits: what is read is exactly what was written. What may be left out has the
default of its class. `presets` are files of the same kind inside the package.
"""

from __future__ import annotations

import math
import os
import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, get_args

from ifs_cad.design_record import MATERIALS, Design, DrawnCurve, SubdivisionPoint
from ifs_cad.design_text import text_of
from ifs_cad.elements.fibre import FibreAlongCurve, FibreAlongEdge, FibreTowards, SumCurve
from ifs_cad.elements.hole import Holes
from ifs_cad.elements.label import Label
from ifs_cad.elements.panel import Face
from ifs_cad.elements.thicken import Nodes, Side
from ifs_cad.errors import IfsCadError, InputError
from ifs_cad.files import replaced

VERSION = 1
SUFFIX = ".toml"

__all__ = ["SUFFIX", "VERSION", "presets", "read_design", "with_settings", "write_design"]

Reader = Callable[[Any], Any]
"""Turns a value of a file into a field, or raises TypeError with what it must be."""


def read_design(path: str | os.PathLike[str]) -> Design:
    """Read a design file.

    Raises
    ------
    InputError
        The file cannot be read, is not TOML, was made by a newer version, or has a key or value
        that cannot be meant; names the file, the line where it is known, and the key.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror or error}.") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is not UTF-8 text: {error}. Save it as UTF-8.") from error
    return parse_design(text, str(path))


def parse_design(text: str, name: str) -> Design:
    """Read a design from the text of a file; see `read_design`."""
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{name} is not TOML: {error}.") from error
    return _Reading(name, _lines(text)).design(tables)


def write_design(design: Design, path: str | os.PathLike[str]) -> Path:
    """Write a design file, with comments that explain it; an old one stays whole until then.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ExportError
        It could not be written; what stood there is unchanged.
    """
    target = Path(path)
    with replaced(target) as scratch:
        scratch.write_text(format_design(design), encoding="utf-8")
    return target


def format_design(design: Design) -> str:
    """Return the text of a design file."""
    return text_of({"version": VERSION} | tables_of(design))


def with_settings(design: Design, settings: Mapping[str, str], name: str) -> Design:
    """Return the design with some values changed, as ``ifs-cad build --set`` does.

    Parameters
    ----------
    design : Design
    settings : mapping of str to str
        By the keys of the file, those in tables with a dot (``thickness``, ``a.depth``,
        ``label.face``), and values as in the file; texts need no quotes, ``none`` leaves out.
    name : str
        What errors call the design.

    Raises
    ------
    InputError
        No such key, or not a value for it; the message lists the keys.
    """
    tables = {"version": VERSION} | tables_of(design)
    for key, text in settings.items():
        known = _known_keys(tables)
        if key not in known:
            near = [other for other in known if other.split(".")[-1] == key]
            hint = f" Say which: {', '.join(near)}." if near else ""
            raise InputError(
                f"{name} has no value {key!r}.{hint} Its values are: {', '.join(known)}."
            )
        *path, last = key.split(".")
        table = tables
        for part in path:
            table = table.setdefault(part, {})
        if text.strip().lower() == "none":
            table.pop(last, None)
        else:
            table[last] = _value(text)
    return _Reading(name, {}).design(tables)


@cache
def presets() -> dict[str, Design]:
    """Return the designs of the paper's figures, by the names of their files.

    Source: the paper, figures 8 to 13, 17, 18 and 21.
    """
    folder = files("ifs_cad").joinpath("presets")
    found = sorted((item for item in folder.iterdir()), key=lambda item: item.name)
    return {
        item.name.removesuffix(SUFFIX): parse_design(item.read_text(encoding="utf-8"), item.name)
        for item in found
        if item.name.endswith(SUFFIX)
    }


def tables_of(design: Design) -> dict[str, Any]:
    """Return a design as nested dicts and lists of plain values, what is None left out."""
    tables: dict[str, Any] = _plain(design)
    for name in ("a", "b"):
        drawn: DrawnCurve = getattr(design, name)
        tables[name]["moved"] = {
            item.name: {"point": list(item.point), "weight": item.weight} for item in drawn.moved
        }
    if design.fibre is not None:
        rule = next(key for key, (kind, _) in FIBRES.items() if isinstance(design.fibre, kind))
        value = tables["fibre"].pop(FIBRES[rule][1])
        tables["fibre"] = {rule: value} | tables["fibre"]
    return tables


def _plain(thing: Any) -> Any:
    if isinstance(thing, tuple):
        return [_plain(item) for item in thing]
    if not hasattr(thing, "__dataclass_fields__"):
        return thing
    values = {item.name: getattr(thing, item.name) for item in fields(thing)}
    return {name: _plain(value) for name, value in values.items() if value is not None}


def _known_keys(tables: Mapping[str, Any]) -> list[str]:
    keys = [key for key in DESIGN_READERS if key not in ("a", "b")]
    keys += [f"{name}.{key}" for name in ("a", "b") for key in CURVE_READERS if key != "moved"]
    for name in ("a", "b"):
        moved = tables[name]["moved"]
        keys += [f"{name}.moved.{point}.{key}" for point in moved for key in MOVED_READERS]
    for name, readers in TABLES.items():
        keys += [name, *(f"{name}.{key}" for key in readers)]
    return keys


def _value(text: str) -> Any:
    """Read a value as TOML does; what is none is a text."""
    try:
        tables = tomllib.loads(f"value = {text}")
    except tomllib.TOMLDecodeError:
        return text
    return tables["value"] if len(tables) == 1 else text


class _Reading:
    """Reads the tables of one file; its errors name the file, the line and the key."""

    def __init__(self, name: str, lines: Mapping[tuple[str, ...], int]) -> None:
        self.name = name
        self.lines = lines

    def design(self, tables: dict[str, Any]) -> Design:
        self._require_version(tables)
        readers = DESIGN_READERS | dict.fromkeys((*TABLES, "version"), _table)
        readers["version"] = _whole
        for key in tables:
            self._require_known(key, (), readers)
        own = {key: value for key, value in tables.items() if key in DESIGN_READERS}
        values = self._values(own, (), DESIGN_READERS)
        for key in ("a", "b"):
            if key in values:
                values[key] = self._curve(values[key], (key,))
        for key, kind in (("label", Label), ("holes", Holes)):
            if key in tables:
                given = self._values(tables[key], (key,), TABLES[key])
                values[key] = self._made(kind, given, (key,))
        if "fibre" in tables:
            values["fibre"] = self._fibre(self._values(tables["fibre"], ("fibre",), FIBRE_READERS))
        made: Design = self._made(Design, values, ())
        return made

    def _require_version(self, tables: Mapping[str, Any]) -> None:
        version = tables.get("version")
        if version is None:
            raise self._wrong((), f"the version is missing. Add version = {VERSION} at the top.")
        if isinstance(version, bool) or not isinstance(version, int) or version < 1:
            raise self._wrong(
                ("version",), f"version must be a whole number from 1 on, got {version!r}."
            )
        if version > VERSION:
            raise self._wrong(
                ("version",),
                f"made by a newer ifs-cad: its version is {version}, and this one reads up to "
                f"{VERSION}. Update ifs-cad.",
            )

    def _curve(self, table: dict[str, Any], place: tuple[str, ...]) -> DrawnCurve:
        values = self._values(table, place, CURVE_READERS)
        moved = []
        for name, row in values.pop("moved", {}).items():
            where = (*place, "moved", name)
            given = self._values(row, where, MOVED_READERS)
            moved.append(self._made(SubdivisionPoint, {"name": name} | given, where))
        made: DrawnCurve = self._made(DrawnCurve, values | {"moved": tuple(moved)}, place)
        return made

    def _fibre(self, values: dict[str, Any]) -> Any:
        rules = [rule for rule in FIBRES if rule in values]
        if len(rules) != 1:
            raise self._wrong(
                ("fibre",), f"give one of {', '.join(FIBRES)}, got {', '.join(rules) or 'none'}."
            )
        kind, field = FIBRES[rules[0]]
        return self._made(kind, {field: values.pop(rules[0])} | values, ("fibre",))

    def _values(
        self, table: Any, place: tuple[str, ...], readers: Mapping[str, Reader]
    ) -> dict[str, Any]:
        if not isinstance(table, dict):
            raise self._wrong(place, f"must be a table of keys and values, got {table!r}.")
        read = {}
        for key, value in table.items():
            self._require_known(key, place, readers)
            try:
                read[key] = readers[key](value)
            except TypeError as error:
                raise self._wrong((*place, key), f"must be {error}, got {value!r}.") from error
        return read

    def _require_known(
        self, key: str, place: tuple[str, ...], readers: Mapping[str, Reader]
    ) -> None:
        if key not in readers:
            raise self._wrong((*place, key), f"unknown key. Known are {', '.join(readers)}.")

    def _made(self, kind: type[Any], values: dict[str, Any], place: tuple[str, ...]) -> Any:
        required = [item.name for item in fields(kind) if _is_required(item)]
        missing = [key for key in required if key not in values]
        if missing:
            raise self._wrong(
                place, f"{', '.join(missing)} missing. Add {missing[0]}, see the presets."
            )
        try:
            return kind(**values)
        except IfsCadError as error:
            raise self._wrong(place, str(error)) from error

    def _wrong(self, place: tuple[str, ...], what: str) -> InputError:
        line = self.lines.get(place)
        where = self.name + (f", line {line}" if line else "")
        return InputError(f"{where}: {'.'.join(place)}{': ' if place else ''}{what}")


def _is_required(item: Any) -> bool:
    return item.default is MISSING and item.default_factory is MISSING


def _lines(text: str) -> dict[tuple[str, ...], int]:
    """Return where tables and keys stand, as far as one can tell line by line."""
    found: dict[tuple[str, ...], int] = {}
    table: tuple[str, ...] = ()
    for line, content in enumerate(text.splitlines(), 1):
        if header := re.match(r"\s*\[{1,2}([\w\s.\"'-]+)\]", content):
            table = _parts(header[1])
            found.setdefault(table, line)
        elif key := re.match(r"\s*([\w.\"'-]+)\s*=", content):
            found.setdefault((*table, *_parts(key[1])), line)
    return found


def _parts(key: str) -> tuple[str, ...]:
    return tuple(part.strip(" \t\"'") for part in key.split("."))


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError("a text in quotes")
    return value


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise TypeError("a finite number")
    return float(value)


def _whole(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise TypeError("a whole number")
    return value


def _switch(value: Any) -> bool:
    if not isinstance(value, bool):
        raise TypeError("true or false")
    return value


def _vector(value: Any) -> tuple[float, ...]:
    if not isinstance(value, list) or len(value) != 3:
        raise TypeError("three numbers in brackets")
    return tuple(_number(item) for item in value)


def _list(read: Reader, what: str) -> Reader:
    def reader(value: Any) -> tuple[Any, ...]:
        if not isinstance(value, list):
            raise TypeError(f"a list of {what} in brackets")
        return tuple(read(item) for item in value)

    return reader


def _one_of(*options: str) -> Reader:
    def reader(value: Any) -> str:
        if value not in options:
            raise TypeError("one of " + ", ".join(f'"{option}"' for option in options))
        return str(value)

    return reader


def _table(value: Any) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise TypeError("a table of keys and values")
    return value


def _edge(value: Any) -> int | str:
    if value == "longest":
        return "longest"
    try:
        return _whole(value)
    except TypeError:
        raise TypeError('"longest" or a whole number') from None


FIBRES: dict[str, tuple[type[Any], str]] = {
    "curve": (FibreAlongCurve, "curve"),
    "edge": (FibreAlongEdge, "edge"),
    "towards": (FibreTowards, "direction"),
}
"""The rules for the fibre direction: key in a file, class, and the field that the key holds."""

DESIGN_READERS: dict[str, Reader] = {
    "title": _text,
    "thickness": _number,
    "side": _one_of(*get_args(Side)),
    "nodes": _one_of(*get_args(Nodes)),
    "clearance": _number,
    "floor": _number,
    "material": _one_of(*MATERIALS),
    "nest": _whole,
    "a": _table,
    "b": _table,
}
CURVE_READERS: dict[str, Reader] = {
    "depth": _whole,
    "transformations": _whole,
    "closed": _switch,
    "symmetric": _switch,
    "roughness": _number,
    "fold": _number,
    "control_points": _list(_vector, "points [x, y, z]"),
    "weights": _list(_number, "numbers"),
    "moved": _table,
}
MOVED_READERS: dict[str, Reader] = {"point": _vector, "weight": _number}
FIBRE_READERS: dict[str, Reader] = {
    "curve": _one_of(*get_args(SumCurve)),
    "edge": _edge,
    "towards": _vector,
    "tolerance": _number,
    "half_turn": _switch,
}
LABEL_READERS: dict[str, Reader] = {
    "face": _one_of(*get_args(Face)),
    "style": _one_of("engraved", "wire"),
    **dict.fromkeys(("depth", "cutter", "margin", "height", "min_height"), _number),
    "up": _vector,
}
HOLE_READERS: dict[str, Reader] = {"diameter": _number, "inset": _number, "fewest": _whole}
TABLES = {"fibre": FIBRE_READERS, "label": LABEL_READERS, "holes": HOLE_READERS}
