"""Dataclasses as plain values that JSON can hold, and back, every value checked by its annotation.

Numbers keep their full precision. An array is a list of lists; one without entries is
`{"shape": [0, 2]}`, since lists would lose how wide it is.
"""

from __future__ import annotations

from dataclasses import MISSING, fields, is_dataclass
from functools import lru_cache
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np

from ifs_cad.errors import InputError

__all__ = ["from_plain", "to_plain"]


def to_plain(value: Any) -> Any:
    """Return dataclasses as dicts, tuples and arrays as lists."""
    if is_dataclass(value) and not isinstance(value, type):
        return {item.name: to_plain(getattr(value, item.name)) for item in fields(value)}
    if isinstance(value, np.ndarray):
        return value.tolist() if value.size else {"shape": list(value.shape)}
    if isinstance(value, tuple | list):
        return [to_plain(item) for item in value]
    return value.item() if isinstance(value, np.generic) else value


def from_plain(kind: Any, value: Any, where: str) -> Any:
    """Return a plain value as what an annotation says.

    Parameters
    ----------
    kind : a dataclass, a tuple type, an array type, a union, a literal, or float, int, str or bool
    value : as `to_plain` returns it
    where : what errors call it

    Raises
    ------
    InputError
        The value is not of that kind; names the place in it.
    """
    origin = get_origin(kind)
    if is_dataclass(kind):
        return _dataclass(kind, value, where)
    if origin in (Union, UnionType):
        return _union(kind, value, where)
    if origin is tuple:
        return _tuple(get_args(kind), value, where)
    if origin is Literal:
        return _checked(value in get_args(kind), value, get_args(kind), where)
    if origin is np.ndarray:
        return _array(value, where)
    if kind is float:
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        return float(_checked(is_number, value, "a number", where))
    if kind is int:
        is_whole = isinstance(value, int) and not isinstance(value, bool)
        return _checked(is_whole, value, "a whole number", where)
    return _checked(isinstance(value, kind), value, f"of type {kind.__name__}", where)


def _checked(right: bool, value: Any, expected: object, where: str) -> Any:
    if not right:
        raise InputError(f"{where} must be {expected}, got {str(value)[:60]!r}.")
    return value


@lru_cache(maxsize=64)
def _annotations(kind: type[Any]) -> dict[str, Any]:
    return get_type_hints(kind)


def _dataclass(kind: Any, value: Any, where: str) -> Any:
    _checked(isinstance(value, dict), value, "a table of keys and values", where)
    hints = _annotations(kind)
    known = {item.name: item for item in fields(kind)}
    if unknown := sorted(value.keys() - known.keys()):
        raise InputError(f"{where}: unknown key {unknown[0]!r}. Known are {', '.join(known)}.")
    missing = [
        name
        for name, item in known.items()
        if name not in value and item.default is MISSING and item.default_factory is MISSING
    ]
    if missing:
        raise InputError(f"{where}: {', '.join(missing)} missing.")
    given = {
        name: from_plain(hints[name], entry, f"{where}.{name}") for name, entry in value.items()
    }
    try:
        return kind(**given)
    except InputError as error:
        raise InputError(f"{where}: {error}") from error


def _union(kind: Any, value: Any, where: str) -> Any:
    choices = [choice for choice in get_args(kind) if choice is not NoneType]
    if value is None:
        return _checked(NoneType in get_args(kind), value, "given", where)
    if len(choices) == 1:
        return from_plain(choices[0], value, where)
    for choice in choices:
        try:
            return from_plain(choice, value, where)
        except InputError:
            continue
    return _checked(False, value, kind, where)


def _tuple(kinds: tuple[Any, ...], value: Any, where: str) -> tuple[Any, ...]:
    _checked(isinstance(value, list), value, "a list", where)
    if kinds[-1] is ...:
        kinds = (kinds[0],) * len(value)
    _checked(len(kinds) == len(value), value, f"a list of {len(kinds)}", where)
    return tuple(
        from_plain(kind, item, f"{where}[{place}]")
        for place, (kind, item) in enumerate(zip(kinds, value, strict=True))
    )


def _array(value: Any, where: str) -> Any:
    try:
        if isinstance(value, dict):
            array = np.zeros(value["shape"])
        else:
            array = np.array(value, dtype=float)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{where} must be numbers in lists of equal lengths.") from error
    right = isinstance(value, dict | list) and bool(np.isfinite(array).all())
    _checked(right, value, "finite numbers in lists", where)
    return array
