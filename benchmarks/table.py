"""One line of the result for each thing measured, with its limit and verdict, as Markdown."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.metadata import version

WIDEST = 76  # column of the table, in letters; a longer text stands out of it
HEADINGS = ("", "what", "ours", "against", "ratio or value", "limit", "", "noise")


@dataclass(frozen=True)
class Line:
    """One thing measured.

    Attributes
    ----------
    key : the letter under which the limit is known
    what, ours, against : text
    value : what the limit is about
    unit : text after the value
    limit : the largest value allowed, or the smallest when `at_least`; None when there is none
    noise : median wall time over best time; nan when no time was taken
    """

    key: str
    what: str
    ours: str
    against: str
    value: float
    unit: str = ""
    limit: float | None = None
    at_least: bool = False
    noise: float = float("nan")

    @property
    def passed(self) -> bool:
        """Whether the limit is kept."""
        if self.limit is None:
            return True
        return self.value >= self.limit if self.at_least else self.value <= self.limit

    @property
    def used(self) -> float:
        """The share of the limit that is used: 1 at the limit, more beyond it."""
        if self.limit is None:
            return 0.0
        return self.limit / self.value if self.at_least else self.value / self.limit

    def cells(self) -> tuple[str, ...]:
        """Return the texts of the line."""
        limit = verdict = noise = ""
        if self.limit is not None:
            limit = f"{'≥' if self.at_least else '≤'} {self.limit:g}{self.unit}"
            verdict = "pass" if self.passed else "**FAIL**"
        if self.noise == self.noise:
            noise = f"{self.noise:.1f}"
        value = f"{self.value:.3g}" if self.value < 100 else f"{self.value:.0f}"
        return (
            self.key,
            self.what,
            self.ours,
            self.against,
            value + self.unit,
            limit,
            verdict,
            noise,
        )


def markdown(lines: Iterable[Line]) -> str:
    """Return the lines as a Markdown table, padded so that it reads well in a terminal too."""
    rows = [HEADINGS, *(line.cells() for line in lines)]
    widths = [min(WIDEST, max(3, *(len(row[k]) for row in rows))) for k in range(len(HEADINGS))]
    text = [
        "| " + " | ".join(t.ljust(w) for t, w in zip(row, widths, strict=True)) + " |"
        for row in rows
    ]
    text.insert(1, "|" + "|".join("-" * (width + 2) for width in widths) + "|")
    return "\n".join(text)


def machine() -> str:
    """Return the kind of machine and the versions in words."""
    system = {"Darwin": "macOS"}.get(platform.system(), platform.system())
    libraries = ", ".join(
        f"{name} {version(name)}" for name in ("numpy", "cadquery", "cadquery-ocp")
    )
    return (
        f"{system} on {platform.machine()}, {os.cpu_count()} cores, "
        f"Python {platform.python_version()}, {libraries}"
    )


def milliseconds(seconds: float) -> str:
    """Return a time in ms, or in s when it is long."""
    return f"{seconds * 1e3:.3g} ms" if seconds < 1 else f"{seconds:.3g} s"
