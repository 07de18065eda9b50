"""Tables: rows with titled columns, which CSV, XLSX and pages write down alike.

Addresses look like numbers (0110, 1e10) and must stay text, so every column says what it holds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ifs_cad.errors import InputError

Cell = str | float | int | None


@dataclass(frozen=True)
class Column:
    """One column.

    Parameters
    ----------
    title : str, with the unit
    kind : "text" or "number"
    decimals : int, shown of a number; files keep all of them where they can
    """

    title: str
    kind: Literal["text", "number"] = "number"
    decimals: int = 2


@dataclass(frozen=True)
class Table:
    """Rows of cells; None is an empty cell.

    Parameters
    ----------
    name : str
    columns : tuple of Column
    rows : tuple of tuples, one cell for each column

    Raises
    ------
    InputError
        A row whose cells do not fit the columns.
    """

    name: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]

    def __post_init__(self) -> None:
        for number, row in enumerate(self.rows, start=1):
            if len(row) != len(self.columns):
                raise InputError(
                    f"Row {number} of table {self.name!r} has {len(row)} cells for "
                    f"{len(self.columns)} columns."
                )
            for column, cell in zip(self.columns, row, strict=True):
                if cell is not None and isinstance(cell, str) != (column.kind == "text"):
                    raise InputError(
                        f"Row {number} of table {self.name!r} has {cell!r} in the column "
                        f"{column.title!r}, which holds {column.kind}."
                    )
