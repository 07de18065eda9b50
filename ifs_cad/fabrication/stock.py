"""Stock: the raw sheets and boards that elements are cut from; `stock_file` reads them.

Source: section 4.3 (each element oriented to the dimensions of the raw material and to the fibre
direction), section 4.1 (the prevalent planks existing on the market).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ifs_cad.elements.material import Material
from ifs_cad.errors import InputError
from ifs_cad.tolerance import DEFAULT, Tolerance

__all__ = ["Board", "Sheet", "Stock"]


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
