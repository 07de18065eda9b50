"""Stock in files: the library of common sheets and boards, and what a workshop has itself.

Common sizes are data, in `stock.toml` beside this file. A user's file of the same form adds to
them:

    extend = true                       # false leaves the sheets and boards of the library out

    [materials."larch plywood"]
    density = 560                       # kg/m3
    colour = [0.80, 0.60, 0.40]         # red, green, blue, each 0 to 1

    [[sheets]]
    name = "larch 12"
    length = 2500                       # mm
    width = 1250
    thickness = 12
    material = "larch plywood"
    fibre = "length"                    # may be left out; or "width", or "none"
    price = 62.50                       # may be left out: unknown
    count = 40                          # may be left out: any number
    good_faces = 1                      # may be left out: 2

    [[boards]]
    name = "yard 27x150x4200"
    length = 4200
    width = 150
    thickness = 27
    material = "spruce"

What has the name of something in the library takes its place, materials for the library's own
sheets and boards too. The materials of the library and of `elements.material` are known in every
file.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from ifs_cad.elements.material import SPRUCE, SPRUCE_PLYWOOD, Material
from ifs_cad.fabrication.stock import Board, Sheet, Stock
from ifs_cad.toml import readers
from ifs_cad.toml.table import Table, read_table

__all__ = ["read_stock"]


def read_stock(path: str | Path | None = None) -> Stock:
    """Read the library of common sheets and boards, and a user's file that adds to it.

    Parameters
    ----------
    path : str or Path
        A TOML file of the form shown in this module; None for the library alone.

    Returns
    -------
    Stock
        First what the library has, then what the file adds.

    Raises
    ------
    InputError
        The file cannot be read, is not TOML, or has an entry that cannot be meant; the message
        names the file, the line, the entry and the key.
    """
    library = _read(files("ifs_cad.fabrication").joinpath("stock.toml"), "stock.toml")
    if path is None:
        return _built([library])
    own = _read(Path(path), str(path))
    if not own.extend:
        library.items = []
    return _built([library, own])


def _fibre(value: Any) -> str | None:
    fibre: str = readers.one_of("length", "width", "none")(value)
    return None if fibre == "none" else fibre


_MATERIAL: readers.Readers = {
    "density": readers.number,
    "colour": readers.list_of(readers.number, "three numbers from 0 to 1", 3),
}
_BOARD: readers.Readers = {
    "name": readers.text,
    "length": readers.number,
    "width": readers.number,
    "thickness": readers.number,
    "material": readers.text,
    "price": readers.number,
    "count": readers.whole,
}
_SHEET: readers.Readers = {**_BOARD, "fibre": _fibre, "good_faces": readers.whole}


@dataclass(frozen=True)
class _Item:
    """The values of one sheet or board, and where they stand."""

    table: Table
    kind: type[Sheet] | type[Board]
    values: dict[str, Any]


@dataclass
class _File:
    """What a file holds: items are not built before all materials are known."""

    extend: bool
    materials: dict[str, Material]
    items: list[_Item]


def _read(source: Path | Traversable, name: str) -> _File:
    """Read one file, every key checked."""
    file = read_table(source, name)
    given = file.values({"extend": readers.flag}, ("materials", "sheets", "boards"))
    materials = {
        material: table.made(Material, {"name": material} | table.values(_MATERIAL))
        for material, table in file.table("materials").tables().items()
    }
    items: dict[str, _Item] = {}
    for key, kind, keys in (("sheets", Sheet, _SHEET), ("boards", Board, _BOARD)):
        for table in file.rows(key):
            values = table.values(keys)
            table.require(kind, values)
            first = items.setdefault(values["name"], _Item(table, kind, values)).table
            if first is not table:
                raise table.taken("name", first)
    return _File(given.get("extend", True), materials, list(items.values()))


def _built(sources: list[_File]) -> Stock:
    """Build what the files hold; later files replace what has the same name."""
    materials = {material.name: material for material in (SPRUCE_PLYWOOD, SPRUCE)}
    items: dict[str, _Item] = {}
    for source in sources:
        materials |= source.materials
        items |= {item.values["name"]: item for item in source.items}
    built = []
    for item in items.values():
        name = item.values["material"]
        if name not in materials:
            raise item.table.wrong(
                f"unknown material {name!r}. Known are {', '.join(map(repr, materials))}; "
                f'or add a table [materials."{name}"].',
                "material",
            )
        built.append(item.table.made(item.kind, item.values | {"material": materials[name]}))
    return Stock(
        tuple(item for item in built if isinstance(item, Sheet)),
        tuple(item for item in built if isinstance(item, Board)),
    )
