"""Pages: drawings as a neutral list of lines and words, which PDF and SVG both write down.

Everything on a page is in mm of paper, the origin at its lower left corner, y up. Curves are cubic:
both formats speak them, and a quarter of a circle is off by less than a line is wide.

Terms
-----
pen : how a line is drawn and what fills it.
step : one word of a trace, as in PDF and SVG: M moves, L draws a line, C a cubic, Z closes.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from ifs_cad.elements.arcs import Path, Segments
from ifs_cad.types import FloatArray

Step = tuple[Literal["M", "L", "C", "Z"], tuple[float, ...]]
Anchor = Literal["start", "middle", "end"]

QUARTER = np.pi / 2
GREY = "#606060"

# Widths of Helvetica as shares of its size; all other characters are about as wide as a digit.
_DIGIT_WIDTH = 0.556
_OTHER_WIDTHS = {
    **dict.fromkeys("ABCDEGHKNOPQRSUVXY&", 0.75),
    **dict.fromkeys("mwMW@%", 0.95),
    **dict.fromkeys(" .,:;|!'()[]-/ijlftrI", 0.34),
}


@dataclass(frozen=True)
class Pen:
    """How a line is drawn.

    Parameters
    ----------
    width : float, mm; 0 for a filled shape without outline
    colour : str, "#rrggbb"
    dash : lengths of lines and gaps in turn, mm; empty for a solid line
    fill : str, "#rrggbb", or empty
    """

    width: float
    colour: str = "#000000"
    dash: tuple[float, ...] = ()
    fill: str = ""


OUTLINE = Pen(0.5)
UPPER = Pen(0.3)  # where there are many on a page
FRAME = Pen(0.35)
LOWER = Pen(0.18, dash=(1.6, 0.8))
THIN = Pen(0.18)
RULE = Pen(0.13, GREY)
ENGRAVED = Pen(0.25, "#a02818")
PIERCED = Pen(0.25, "#1a4f8a")
ORIGIN = Pen(0.5, "#1a4f8a")
GRAIN = Pen(0.7, "#dcc594")
HATCH = Pen(0.1, "#909090")
STOCK = Pen(0.35, fill="#fbf8f1")
WOOD = Pen(0.35, fill="#f1e4c8")
SHADE = Pen(0.0, fill=WOOD.fill)
PAPER = Pen(0.0, fill="#ffffff")


@dataclass(frozen=True)
class Trace:
    """A line or a shape."""

    pen: Pen
    steps: tuple[Step, ...]


@dataclass(frozen=True)
class Words:
    """A line of text.

    Parameters
    ----------
    text : str
    x, y : float, mm, where its baseline starts, has its middle or ends
    size : float, mm, of the font
    anchor : "start", "middle" or "end"
    turn : float, degrees, counter-clockwise
    bold : bool
    colour : str, "#rrggbb"
    """

    text: str
    x: float
    y: float
    size: float
    anchor: Anchor = "start"
    turn: float = 0.0
    bold: bool = False
    colour: str = "#000000"

    @property
    def printable(self) -> str:
        """The text without control characters, which no format can hold."""
        return "".join(letter if letter.isprintable() else " " for letter in self.text)


@dataclass(frozen=True)
class View:
    """How what is drawn lies on the paper: scaled, then moved.

    Parameters
    ----------
    scale : float
    x, y : float, mm, where the origin of what is drawn lies on the paper
    """

    scale: float
    x: float
    y: float

    def __call__(self, points: FloatArray) -> FloatArray:
        """Return (..., 2) points on the paper."""
        return np.asarray(np.asarray(points)[..., :2] * self.scale + (self.x, self.y))


@dataclass(frozen=True, eq=False)
class Page:
    """One page, drawn upon from the back to the front.

    Parameters
    ----------
    title : str, for tables of contents
    width, height : float, mm
    """

    title: str
    width: float
    height: float
    marks: list[Trace | Words] = field(default_factory=list)

    def line(self, pen: Pen, points: FloatArray, *, closed: bool = False) -> None:
        """Draw a line through (n, 2) points."""
        self.lines(pen, np.asarray(points)[None], closed=closed)

    def lines(self, pen: Pen, points: FloatArray, *, closed: bool = False) -> None:
        """Draw (k, n, 2) lines with one stroke of the pen."""
        steps: list[Step] = []
        for (x, y), *rest in np.asarray(points, dtype=float).tolist():
            steps.append(("M", (x, y)))
            steps.extend(("L", (x, y)) for x, y in rest)
            if closed:
                steps.append(("Z", ()))
        if steps:
            self.marks.append(Trace(pen, tuple(steps)))

    def box(self, pen: Pen, x: float, y: float, width: float, height: float) -> None:
        """Draw a rectangle by its lower left corner and size."""
        corners = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
        self.line(pen, corners * (width, height) + (x, y), closed=True)

    def circles(self, pen: Pen, centres: FloatArray, radius: float) -> None:
        """Draw circles of one radius around (n, 2) points."""
        opposite = np.array([(-radius, 0.0), (radius, 0.0)])
        self.paths(pen, [Path(centre + opposite, np.ones(2), closed=True) for centre in centres])

    def paths(self, pen: Pen, paths: Iterable[Path]) -> None:
        """Draw chains of lines and arcs."""
        steps = tuple(step for path in paths for step in _steps(path))
        if steps:
            self.marks.append(Trace(pen, steps))

    def text(
        self,
        text: str,
        x: float,
        y: float,
        size: float,
        *,
        anchor: Anchor = "start",
        turn: float = 0.0,
        bold: bool = False,
        colour: str = "#000000",
        room: float = np.inf,
    ) -> None:
        """Write a line of text, smaller where it would be longer than the room, mm."""
        long = text_width(text, size)
        size *= min(1.0, room / long) if long > 0.0 else 1.0
        self.marks.append(Words(text, x, y, size, anchor, turn, bold, colour))


def text_width(text: str, size: float) -> float:
    """Return about how long a text is, mm."""
    return size * sum(_OTHER_WIDTHS.get(letter, _DIGIT_WIDTH) for letter in text)


def _steps(path: Path) -> list[Step]:
    if len(path.vertices) == 1:  # a dot: a line without length and with round ends
        x, y = path.vertices[0].tolist()
        return [("M", (x, y)), ("L", (x, y))]
    segments = Segments.of([path])
    pieces = np.maximum(1, np.ceil(np.abs(segments.sweeps) / QUARTER)).astype(np.int64)
    each = segments[np.repeat(np.arange(len(segments)), pieces)]
    part = np.arange(len(each)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    count = np.repeat(pieces, pieces)
    starts, ends = each.at(part / count), each.at((part + 1) / count)
    reach = 4 / 3 * np.tan(each.sweeps / count / 4) * 1j
    rounds = np.column_stack(
        [starts + reach * (starts - each.centres), ends - reach * (ends - each.centres), ends]
    )
    numbers = np.stack([rounds.real, rounds.imag], axis=-1).reshape(-1, 6).tolist()
    x, y = path.vertices[0].tolist()
    steps: list[Step] = [("M", (x, y))]
    steps.extend(
        ("L", (point.real, point.imag)) if straight else ("C", tuple(cubic))
        for straight, point, cubic in zip(
            each.is_line.tolist(), ends.tolist(), numbers, strict=True
        )
    )
    return [*steps, ("Z", ())] if path.closed else steps
