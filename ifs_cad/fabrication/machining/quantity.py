"""Checks of the numbers and words that tools and machines are described by."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, get_args

from ifs_cad.errors import InputError

Span = tuple[float, float]
"""The least and the largest value."""


def choice(kind: Any) -> str:
    """Return the words of a literal type, for messages."""
    return choice_of(get_args(kind))


def choice_of(words: Iterable[str]) -> str:
    """Return words to choose from, for messages."""
    names = [repr(word) for word in words]
    return f"{', '.join(names[:-1])} or {names[-1]}"


def require_positive(value: float, what: str) -> None:
    """Raise InputError unless a number is finite and above 0."""
    if not 0.0 < value < math.inf:
        raise InputError(f"{what} must be positive, got {value:g}.")


def require_span(value: Span, what: str, unit: str) -> None:
    """Raise InputError unless a span rises between finite ends."""
    if not -math.inf < value[0] < value[1] < math.inf:
        raise InputError(f"{what} must rise from least to largest {unit}, got {value}.")
