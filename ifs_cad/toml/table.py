"""Tables of TOML files whose keys are the fields of a dataclass, every key checked.

An error names the file, the line, the table and the key, says what was expected and what was given.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import MISSING, dataclass, field, fields
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, TypeVar, cast

from ifs_cad.errors import IfsCadError, InputError
from ifs_cad.toml.lines import Place, line_of
from ifs_cad.toml.readers import MismatchError, Readers

__all__ = ["Table", "parse_table", "read_table"]

Made = TypeVar("Made")


@dataclass(frozen=True)
class Table:
    """A table of a TOML file, or all of the file, that knows where it stands.

    Parameters
    ----------
    file : str
        What errors call the file.
    items : mapping
        Its keys with their values as they were parsed.
    content : str, optional
        The text of the file; without it errors name no line.
    place : tuple of str and int
        The keys, and indices in lists of tables, that lead to it; empty for all of the file.
    """

    file: str
    items: Mapping[str, Any]
    content: str | None = field(default=None, repr=False)
    place: Place = ()

    def __contains__(self, key: str) -> bool:
        return key in self.items

    @property
    def label(self) -> str:
        """How errors call it: its header, and of a list of tables its number and name."""
        header = _header(self.place)
        if not (self.place and isinstance(self.place[-1], int)):
            return f"[{header}]" if header else ""
        name = self.items.get("name")
        named = f" ({name})" if isinstance(name, str) else ""
        return f"[[{header}]] entry {self.place[-1] + 1}{named}"

    @property
    def line(self) -> int | None:
        """Where it begins, from 1; None for all of a file, or where it does not stand in it."""
        return self._line(self.place)

    def wrong(self, what: str, *within: str | int) -> InputError:
        """Return the error that something is wrong, with the place of the table before it.

        Parameters
        ----------
        what : str
            A sentence about this table.
        *within
            The key, and entry of its list, that it is about, for the line; none for the table.
        """
        line = self._line((*self.place, *within))
        where = [self.file + (f", line {line}" if line else ""), self.label, what]
        return InputError(": ".join(part for part in where if part))

    def taken(self, key: str, first: Table) -> InputError:
        """Return the error that another table of the file has the same value for a key."""
        line = f" on line {first.line}" if first.line else ""
        return self.wrong(
            f"the {key} {self.items[key]!r} is taken by {first.label}{line}. Give one of them "
            f"another {key}.",
            key,
        )

    def values(self, readers: Readers, tables: tuple[str, ...] = ()) -> dict[str, Any]:
        """Return what the keys say.

        Parameters
        ----------
        readers : mapping of str to Reader
            How each key that there may be is read.
        tables : tuple of str
            Other keys that there may be, which are tables and left alone.

        Raises
        ------
        InputError
            An unknown key, or a value that cannot be read.
        """
        found = {}
        for key, value in self.items.items():
            if key in tables:
                continue
            if key not in readers:
                known = ", ".join([*readers, *tables])
                raise self.wrong(f"unknown key {key!r}. Known are {known}.", key)
            try:
                found[key] = readers[key](value)
            except MismatchError as error:
                entry = "".join(f" entry {index + 1}" for index in error.within)
                raise self.wrong(
                    f"{key}{entry} must be {error.expected}, got {error.value!r}.",
                    key,
                    *error.within,
                ) from error
        return found

    def table(self, key: str) -> Table:
        """Return a table in this one, without keys when it is not there.

        Raises
        ------
        InputError
            The key has another value.
        """
        return self._inner(self.items.get(key, {}), key)

    def tables(self) -> dict[str, Table]:
        """Return the tables in this one, which has nothing else.

        Raises
        ------
        InputError
            A key has another value.
        """
        return {key: self.table(key) for key in self.items}

    def rows(self, key: str) -> list[Table]:
        """Return the tables of a list, none when it is not there.

        Raises
        ------
        InputError
            The key has another value.
        """
        rows = self.items.get(key, [])
        if not isinstance(rows, list):
            header = _header((*self.place, key))
            raise self.wrong(
                f"{key} must be a list of tables: write [[{header}]] before each.", key
            )
        return [self._inner(row, key, index) for index, row in enumerate(rows)]

    def require(self, kind: Callable[..., object], given: Mapping[str, Any]) -> None:
        """Raise InputError unless each field of a dataclass without a default has a value."""
        required = [item.name for item in fields(cast(Any, kind)) if _is_required(item)]
        missing = [key for key in required if key not in given]
        if missing:
            raise self.wrong(f"{', '.join(missing)} missing. Add {missing[0]} = ...")

    def made(self, kind: Callable[..., Made], given: Mapping[str, Any]) -> Made:
        """Return a dataclass made of values.

        Raises
        ------
        InputError
            A field without a default has no value, or the dataclass refuses one.
        """
        self.require(kind, given)
        with self.refusals():
            return kind(**given)

    @contextmanager
    def refusals(self) -> Iterator[None]:
        """Turn an error of this package into one that names the place.

        Raises
        ------
        InputError
            Its line is that of the key of this table that the error names first, else that of
            the table.
        """
        try:
            yield
        except IfsCadError as error:
            raise self.wrong(str(error), *self._named_in(str(error))) from error

    def _named_in(self, message: str) -> tuple[str, ...]:
        """Return the key that a message names first, by its name or the words it is made of."""
        found = {
            key: re.search(rf"\b{re.escape(key).replace('_', '[ _]')}\b", message, re.IGNORECASE)
            for key, value in self.items.items()
            if not isinstance(value, dict)  # a curve called "a" is in every sentence
        }
        starts = {key: match.start() for key, match in found.items() if match}
        return (min(starts, key=starts.__getitem__),) if starts else ()

    def _inner(self, value: Any, *within: str | int) -> Table:
        is_table = isinstance(value, dict)
        inner = Table(self.file, value if is_table else {}, self.content, (*self.place, *within))
        if not is_table:
            raise inner.wrong(f"must be a table of keys and values, got {value!r}.")
        return inner

    def _line(self, place: Place) -> int | None:
        return None if self.content is None else line_of(self.content, place)


def read_table(source: Path | Traversable, name: str) -> Table:
    """Read a TOML file.

    Raises
    ------
    InputError
        It cannot be read, or is not TOML.
    """
    try:
        content = source.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"{name} cannot be read: {error.strerror or error}.") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{name} is not UTF-8 text: {error}. Save it as UTF-8.") from error
    return parse_table(content, name)


def parse_table(content: str, name: str) -> Table:
    """Read the text of a TOML file; see `read_table`."""
    try:
        # without an end its last line would have no number in what tomllib says
        return Table(name, tomllib.loads(content + "\n"), content)
    except RecursionError as error:
        raise InputError(f"{name} has too many brackets within each other to be read.") from error
    except ValueError as error:  # also numbers of thousands of digits
        raise InputError(f"{name} is not TOML: {error}.") from error


def _is_required(item: Any) -> bool:
    return item.default is MISSING and item.default_factory is MISSING


def _header(place: Place) -> str:
    """Return the keys of a place as they are written in a header."""
    keys = (key for key in place if isinstance(key, str))
    return ".".join(key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else f'"{key}"' for key in keys)
