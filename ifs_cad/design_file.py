"""Designs in files: TOML that a designer can read, change by hand and keep under version control.

A file has a version, so that a later one is refused with a sentence instead of misread. Numbers
have all their digits: what is read is exactly what was written. What may be left out has the
default of its class. `presets` are files of the same kind inside the package.
"""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping
from dataclasses import fields
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, get_args

from ifs_cad.design_record import MATERIALS, Design, DrawnCurve, SubdivisionPoint
from ifs_cad.design_text import text_of
from ifs_cad.elements.fibre import Fibre, FibreAlongCurve, FibreAlongEdge, FibreTowards, SumCurve
from ifs_cad.elements.hole import Holes
from ifs_cad.elements.label import Label
from ifs_cad.elements.panel import Face
from ifs_cad.elements.thicken import Nodes, Side
from ifs_cad.errors import InputError
from ifs_cad.files import replaced
from ifs_cad.toml import readers
from ifs_cad.toml.table import Table, parse_table, read_table

VERSION = 1
SUFFIX = ".toml"

__all__ = ["SUFFIX", "VERSION", "presets", "read_design", "with_settings", "write_design"]


def read_design(path: str | os.PathLike[str]) -> Design:
    """Read a design file.

    Raises
    ------
    InputError
        The file cannot be read, is not TOML, was made by a newer version, or has a key or value
        that cannot be meant; names the file, the line where it is known, and the key.
    """
    return _design(read_table(Path(path), str(path)))


def parse_design(text: str, name: str) -> Design:
    """Read a design from the text of a file; see `read_design`."""
    return _design(parse_table(text, name))


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
    return _design(Table(name, tables))


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
    keys = [*DESIGN_READERS, *(f"{name}.{key}" for name in ("a", "b") for key in CURVE_READERS)]
    for name in ("a", "b"):
        moved = tables[name]["moved"]
        keys += [f"{name}.moved.{point}.{key}" for point in moved for key in MOVED_READERS]
    for name, inner in TABLES.items():
        keys += [name, *(f"{name}.{key}" for key in inner)]
    return keys


def _value(text: str) -> Any:
    """Read a value as TOML does; what is none is a text."""
    try:
        tables = tomllib.loads(f"value = {text}")
    except tomllib.TOMLDecodeError:
        return text
    return tables["value"] if len(tables) == 1 else text


def _design(file: Table) -> Design:
    _require_version(file)
    values = file.values({**DESIGN_READERS, "version": readers.whole}, ("a", "b", *TABLES))
    del values["version"]
    values |= {key: _curve(file.table(key)) for key in ("a", "b") if key in file}
    for key, kind in (("label", Label), ("holes", Holes)):
        if key in file:
            table = file.table(key)
            values[key] = table.made(kind, table.values(TABLES[key]))
    if "fibre" in file:
        values["fibre"] = _fibre(file.table("fibre"))
    for key in ("a", "b"):
        if key not in file:
            raise file.wrong(f"the curve {key} is missing. Add a table [{key}], see the presets.")
    return file.made(Design, values)


def _require_version(file: Table) -> None:
    version = file.items.get("version")
    if version is None:
        raise file.wrong(f"the version is missing. Add version = {VERSION} at the top.")
    if isinstance(version, bool) or not isinstance(version, int) or version < 1:
        raise file.wrong(f"version must be a whole number from 1 on, got {version!r}.", "version")
    if version > VERSION:
        raise file.wrong(
            f"made by a newer ifs-cad: its version is {version}, and this one reads up to "
            f"{VERSION}. Update ifs-cad.",
            "version",
        )


def _curve(table: Table) -> DrawnCurve:
    values = table.values(CURVE_READERS, ("moved",))
    moved = tuple(
        row.made(SubdivisionPoint, {"name": name} | row.values(MOVED_READERS))
        for name, row in table.table("moved").tables().items()
    )
    return table.made(DrawnCurve, values | {"moved": moved})


def _fibre(table: Table) -> Fibre:
    values = table.values(FIBRE_READERS)
    rules = [rule for rule in FIBRES if rule in values]
    if len(rules) != 1:
        raise table.wrong(
            f"give one of {', '.join(FIBRES)}, got {', '.join(rules) or 'none'}.", *rules[1:2]
        )
    kind, field = FIBRES[rules[0]]
    return table.made(kind, {field: values.pop(rules[0])} | values)


def _edge(value: Any) -> int | str:
    try:
        return value if value == "longest" else readers.whole(value)
    except readers.MismatchError as error:
        raise readers.MismatchError('"longest" or a whole number', value) from error


FIBRES: dict[str, tuple[type[Fibre], str]] = {
    "curve": (FibreAlongCurve, "curve"),
    "edge": (FibreAlongEdge, "edge"),
    "towards": (FibreTowards, "direction"),
}
"""The rules for the fibre direction: key in a file, class, and the field that the key holds."""

_VECTOR = readers.list_of(readers.number, "three numbers in brackets", 3)
DESIGN_READERS: readers.Readers = {
    "title": readers.text,
    "thickness": readers.number,
    "side": readers.one_of(*get_args(Side)),
    "nodes": readers.one_of(*get_args(Nodes)),
    "clearance": readers.number,
    "floor": readers.number,
    "material": readers.one_of(*MATERIALS),
    "nest": readers.whole,
}
CURVE_READERS: readers.Readers = {
    "depth": readers.whole,
    "transformations": readers.whole,
    "closed": readers.flag,
    "symmetric": readers.flag,
    "roughness": readers.number,
    "fold": readers.number,
    "control_points": readers.list_of(_VECTOR, "a list of points [x, y, z] in brackets"),
    "weights": readers.list_of(readers.number, "a list of numbers in brackets"),
}
MOVED_READERS: readers.Readers = {"point": _VECTOR, "weight": readers.number}
FIBRE_READERS: readers.Readers = {
    "curve": readers.one_of(*get_args(SumCurve)),
    "edge": _edge,
    "towards": _VECTOR,
    "tolerance": readers.number,
    "half_turn": readers.flag,
}
LABEL_READERS: readers.Readers = {
    "face": readers.one_of(*get_args(Face)),
    "style": readers.one_of("engraved", "wire"),
    **dict.fromkeys(("depth", "cutter", "margin", "height", "min_height"), readers.number),
    "up": _VECTOR,
}
HOLE_READERS: readers.Readers = {
    "diameter": readers.number,
    "inset": readers.number,
    "fewest": readers.whole,
}
TABLES = {"fibre": FIBRE_READERS, "label": LABEL_READERS, "holes": HOLE_READERS}
