"""Cut lists as CSV (RFC 4180) and as XLSX.

Addresses look like numbers: in CSV every text is quoted and no number is, which is all that the
format can say; in XLSX the cells have types, so that "0110" and "1e10" come back as they are.
"""

from __future__ import annotations

import csv
import os
from datetime import datetime
from pathlib import Path
from typing import Any, Protocol

from ifs_cad.fabrication.table import Cell, Column, Table
from ifs_cad.files import replaced
from ifs_cad.libraries import require

_WIDEST = 60  # of a column, in characters
_HEADER_HEIGHT = 30  # points
_EVERYWHERE = "A1:XFD1048576"
_BEGINNING = datetime(1980, 1, 1)  # the same list always makes the same file


class Tabular(Protocol):
    """What has tables: a cut list, a plank list."""

    @property
    def tables(self) -> tuple[Table, ...]:
        """The most important one first."""


def export_csv(tables: Tabular | Table, path: str | os.PathLike[str]) -> Path:
    """Write one table as comma-separated values, UTF-8, with a header.

    Parameters
    ----------
    tables : a cut list or a plank list, of which the first table is written, or any table
    path : path of the file; its folder is made when missing

    Returns
    -------
    Path of the written file.

    Raises
    ------
    ExportError
        The file could not be written; what stood there before is unchanged.
    """
    table = tables if isinstance(tables, Table) else tables.tables[0]
    target = Path(path)
    with (
        replaced(target) as scratch,
        scratch.open("w", encoding="utf-8", newline="") as handle,
    ):
        writer = csv.writer(handle, quoting=csv.QUOTE_NONNUMERIC, lineterminator="\r\n")
        writer.writerow([column.title for column in table.columns])
        writer.writerows([_plain(cell) for cell in row] for row in table.rows)
    return target


def export_xlsx(tables: Tabular, path: str | os.PathLike[str]) -> Path:
    """Write all tables as one workbook, a sheet for each.

    Parameters
    ----------
    tables : a cut list or a plank list
    path : path of the file; its folder is made when missing

    Returns
    -------
    Path of the written file.

    Raises
    ------
    ExportError
        The file could not be written; what stood there before is unchanged.
    MissingLibraryError
        xlsxwriter is not installed.
    """
    xlsxwriter = require("xlsxwriter", "spreadsheets", "fabrication")
    target = Path(path)
    with replaced(target) as scratch, xlsxwriter.Workbook(scratch) as book:
        book.set_properties({"created": _BEGINNING})
        for table in tables.tables:
            _write_sheet(book, table)
    return target


def _write_sheet(book: Any, table: Table) -> None:
    sheet = book.add_worksheet(table.name)
    sheet.freeze_panes(1, 1)
    sheet.set_row(0, _HEADER_HEIGHT)  # two lines: not every program finds that out by itself
    sheet.ignore_errors({"number_stored_as_text": _EVERYWHERE})  # that is what they are
    header = book.add_format({"bold": True, "text_wrap": True, "valign": "top", "bottom": 1})
    for place, column in enumerate(table.columns):
        sheet.write_string(0, place, column.title, header)
        cells = [row[place] for row in table.rows]
        shown = book.add_format({"num_format": _number_format(column)})
        sheet.set_column(place, place, _width(column, cells), shown)
        write = sheet.write_string if column.kind == "text" else sheet.write_number
        for number, cell in enumerate(cells, start=1):
            if cell is not None:
                write(number, place, cell, shown)
    if table.rows:
        sheet.autofilter(0, 0, len(table.rows), len(table.columns) - 1)


def _number_format(column: Column) -> str:
    if column.kind == "text":
        return "@"
    return f"0.{'0' * column.decimals}" if column.decimals else "0"


def _width(column: Column, cells: list[Cell]) -> int:
    longest = max(
        (
            len(cell) if isinstance(cell, str) else len(f"{cell:.{column.decimals}f}")
            for cell in cells
            if cell is not None
        ),
        default=0,
    )
    words = max(len(word) for word in column.title.split())
    return min(_WIDEST, max(longest, words) + 3)


def _plain(cell: Cell) -> Any:
    """Return a number as Python's own, of which all digits are written."""
    return cell if cell is None or isinstance(cell, str | int) else float(cell)
