"""Stock: the raw sheets and boards that elements are cut from.

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

Source: section 4.3 (each element oriented to the dimensions of the raw material and to the fibre
direction), section 4.1 (the prevalent planks existing on the market).
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, fields
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ifs_cad.elements.material import SPRUCE, SPRUCE_PLYWOOD, Material
from ifs_cad.errors import InputError
from ifs_cad.tolerance import DEFAULT, Tolerance

__all__ = ["Board", "Sheet", "Stock", "read_stock"]


@dataclass(frozen=True)
class Sheet:
    """A raw sheet, lying with its length along x.

    Parameters
    ----------
    name : str
    length, width, thickness : float, mm
    material : Material
    fibre : "length" or "width", the grain of the outer plies; None where there is none
    price : float, of one sheet, in any currency; None when unknown
    count : int, how many there are; None for any number
    good_faces : 1 or 2, how many of its faces may be seen in the building

    Raises
    ------
    InputError
        A size that is not positive and finite, or another value that cannot be meant.
    """

    name: str
    length: float
    width: float
    thickness: float
    material: Material
    fibre: Literal["length", "width"] | None = "length"
    price: float | None = None
    count: int | None = None
    good_faces: Literal[1, 2] = 2

    def __post_init__(self) -> None:
        _require_stock(self, "Sheet")
        if self.fibre not in ("length", "width", None):
            raise InputError(
                f"Sheet {self.name}: fibre must be 'length', 'width' or None, got {self.fibre!r}."
            )
        if isinstance(self.good_faces, bool) or self.good_faces not in (1, 2):
            raise InputError(
                f"Sheet {self.name}: good_faces must be 1 or 2, got {self.good_faces!r}."
            )


@dataclass(frozen=True)
class Board:
    """A raw board; its grain runs along its length.

    Parameters
    ----------
    name : str
    length, width, thickness : float, mm
    material : Material
    price : float, of one board, in any currency; None when unknown
    count : int, how many there are; None for any number

    Raises
    ------
    InputError
        A size that is not positive and finite, or another value that cannot be meant.
    """

    name: str
    length: float
    width: float
    thickness: float
    material: Material
    price: float | None = None
    count: int | None = None

    def __post_init__(self) -> None:
        _require_stock(self, "Board")


@dataclass(frozen=True)
class Stock:
    """The sheets and boards that there are; `stock["name"]` is one of them.

    Parameters
    ----------
    sheets : tuple of Sheet
    boards : tuple of Board
        Names are unique among sheets and boards together.

    Raises
    ------
    InputError
        Two of the same name.
    """

    sheets: tuple[Sheet, ...]
    boards: tuple[Board, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "sheets", tuple(self.sheets))
        object.__setattr__(self, "boards", tuple(self.boards))
        names = [item.name for item in self._items]
        doubled = sorted({name for name in names if names.count(name) > 1})
        if doubled:
            raise InputError(f"Stock has more than one {_shown(doubled)}: give each its own name.")

    def __getitem__(self, name: str) -> Sheet | Board:
        """Return the sheet or board of this name.

        Raises
        ------
        InputError
            There is none; the message lists those that there are.
        """
        items = {item.name: item for item in self._items}
        if name not in items:
            raise InputError(
                f"No sheet or board is called {name!r}. There are: {_shown([*items])}."
            )
        return items[name]

    @property
    def _items(self) -> tuple[Sheet | Board, ...]:
        return (*self.sheets, *self.boards)

    def sheets_of(
        self,
        thickness: float,
        material: Material | str | None = None,
        *,
        tol: Tolerance = DEFAULT,
    ) -> tuple[Sheet, ...]:
        """Return the sheets of a thickness, mm, and of a material or its name if given."""
        return tuple(
            sheet
            for sheet in self.sheets
            if abs(sheet.thickness - thickness) <= tol.coincident and _made_of(sheet, material)
        )

    def boards_of(
        self,
        width: float,
        thickness: float,
        material: Material | str | None = None,
        *,
        tol: Tolerance = DEFAULT,
    ) -> tuple[Board, ...]:
        """Return the boards of a section, mm, and of a material or its name if given."""
        return tuple(
            board
            for board in self.boards
            if abs(board.width - width) <= tol.coincident
            and abs(board.thickness - thickness) <= tol.coincident
            and _made_of(board, material)
        )


def _made_of(item: Sheet | Board, material: Material | str | None) -> bool:
    name = material.name if isinstance(material, Material) else material
    return name is None or item.material.name == name


def _require_stock(item: Sheet | Board, kind: str) -> None:
    """Raise InputError unless what sheets and boards have in common can be meant."""
    if not (isinstance(item.name, str) and item.name.strip()):
        raise InputError(f"{kind}: name must be a text that is not empty, got {item.name!r}.")
    for key in ("length", "width", "thickness"):
        size = getattr(item, key)
        if not (_is_number(size) and math.isfinite(size) and size > 0):
            raise InputError(
                f"{kind} {item.name}: {key} must be a positive number of mm, got {size!r}."
            )
    if not isinstance(item.material, Material):
        raise InputError(f"{kind} {item.name}: material must be a Material, got {item.material!r}.")
    price, count = item.price, item.count
    if price is not None and not (_is_number(price) and math.isfinite(price) and price >= 0):
        raise InputError(
            f"{kind} {item.name}: price must be a number of at least 0, or None when it is not "
            f"known, got {price!r}."
        )
    if count is not None and not (_is_whole(count) and count >= 1):
        raise InputError(
            f"{kind} {item.name}: count must be a whole number of at least 1, or None for any "
            f"number, got {count!r}."
        )


def _is_number(value: object) -> bool:
    return isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)


def _is_whole(value: object) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool)


def _shown(names: list[str]) -> str:
    return ", ".join(repr(name) for name in names)


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
        names the file, the entry and the key.
    """
    library = _parsed(files("ifs_cad.fabrication").joinpath("stock.toml"), "stock.toml")
    if path is None:
        return _built([library])
    own = _parsed(Path(path), str(path))
    if not own.extend:
        library.entries = []
    return _built([library, own])


_Value = Callable[[Any], Any]


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError("a text in quotes")
    return value


def _number(value: Any) -> float:
    if not _is_number(value):
        raise TypeError("a number")
    return float(value)


def _whole(value: Any) -> int:
    if not _is_whole(value):
        raise TypeError("a whole number")
    return int(value)


def _colour(value: Any) -> tuple[float, ...]:
    if not (isinstance(value, list) and len(value) == 3 and all(map(_is_number, value))):
        raise TypeError("three numbers from 0 to 1")
    return tuple(map(float, value))


def _fibre(value: Any) -> str | None:
    if value not in ("length", "width", "none"):
        raise TypeError('"length", "width" or "none"')
    return None if value == "none" else str(value)


# How each key of a table is read; the keys are fields of the dataclass, required where it has no
# default.
_MATERIAL_KEYS: dict[str, _Value] = {
    "density": _number,
    "colour": _colour,
}
_BOARD_KEYS: dict[str, _Value] = {
    "name": _text,
    "length": _number,
    "width": _number,
    "thickness": _number,
    "material": _text,
    "price": _number,
    "count": _whole,
}
_SHEET_KEYS: dict[str, _Value] = _BOARD_KEYS | {"fibre": _fibre, "good_faces": _whole}


@dataclass(frozen=True)
class _Entry:
    """The values of one sheet or board, and where they stand."""

    where: str
    kind: type[Sheet] | type[Board]
    values: dict[str, Any]


@dataclass
class _File:
    """What a file holds: entries are not built before all materials are known."""

    extend: bool
    materials: dict[str, Material]
    entries: list[_Entry]


def _parsed(source: Any, name: str) -> _File:
    """Read one file (anything with `read_text`), every key checked."""
    try:
        tables = tomllib.loads(source.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{name} cannot be read: {error.strerror or error}.") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{name} is not UTF-8 text: {error}. Save it as UTF-8.") from error
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{name} is not TOML: {error}.") from error
    _require_known(tables, ["extend", "materials", "sheets", "boards"], name)
    extend = tables.get("extend", True)
    if not isinstance(extend, bool):
        raise InputError(f"{name}: extend must be true or false, got {extend!r}.")

    materials = {}
    for material, table in _table(tables.get("materials", {}), f"{name}: materials").items():
        where = f'{name}: [materials."{material}"]'
        values = _read(table, _MATERIAL_KEYS, Material, where, given={"name"})
        materials[material] = _made(Material, where, name=material, **values)

    entries: list[_Entry] = []
    places: dict[str, str] = {}
    for key, kind, keys in (("sheets", Sheet, _SHEET_KEYS), ("boards", Board, _BOARD_KEYS)):
        rows = tables.get(key, [])
        if not isinstance(rows, list):
            raise InputError(f"{name}: {key} must be a list of tables: write [[{key}]].")
        for number, row in enumerate(rows, 1):
            where = f"{name}: [[{key}]] entry {number}"
            if isinstance(row, dict) and isinstance(row.get("name"), str):
                where += f" ({row['name']})"
            values = _read(row, keys, kind, where)
            first = places.setdefault(values["name"], where)
            if first != where:
                raise InputError(
                    f"{where}: the name {values['name']!r} is taken by {first}. Give one of them "
                    "another name."
                )
            entries.append(_Entry(where, kind, values))
    return _File(extend, materials, entries)


def _read(
    table: Any,
    keys: Mapping[str, _Value],
    kind: type[Any],
    where: str,
    given: frozenset[str] | set[str] = frozenset(),
) -> dict[str, Any]:
    """Read the values of one table; those of `given` come from elsewhere."""
    _require_known(_table(table, where), keys, where)
    required = {f.name for f in fields(kind) if f.default is MISSING} - given
    missing = [key for key in keys if key in required and key not in table]
    if missing:
        raise InputError(f"{where}: {', '.join(missing)} missing. Add {missing[0]} = ...")
    values = {}
    for key, value in table.items():
        try:
            values[key] = keys[key](value)
        except TypeError as error:
            raise InputError(f"{where}: {key} must be {error}, got {value!r}.") from error
    return values


def _require_known(table: Mapping[str, Any], keys: Any, where: str) -> None:
    for key in table:
        if key not in keys:
            raise InputError(f"{where}: unknown key {key!r}. Known are {', '.join(keys)}.")


def _table(value: Any, where: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise InputError(f"{where} must be a table of keys and values, got {value!r}.")
    return value


def _made(kind: type[Any], where: str, **values: Any) -> Any:
    try:
        return kind(**values)
    except InputError as error:
        raise InputError(f"{where}: {error}") from error


def _built(sources: list[_File]) -> Stock:
    """Build what the files hold; later files replace what has the same name."""
    materials = {material.name: material for material in (SPRUCE_PLYWOOD, SPRUCE)}
    entries: dict[str, _Entry] = {}
    for source in sources:
        materials |= source.materials
        entries |= {entry.values["name"]: entry for entry in source.entries}
    built = []
    for entry in entries.values():
        name = entry.values["material"]
        if name not in materials:
            raise InputError(
                f"{entry.where}: unknown material {name!r}. Known are {_shown(list(materials))}; "
                f'or add a table [materials."{name}"].'
            )
        built.append(_made(entry.kind, entry.where, **entry.values | {"material": materials[name]}))
    return Stock(
        tuple(item for item in built if isinstance(item, Sheet)),
        tuple(item for item in built if isinstance(item, Board)),
    )
