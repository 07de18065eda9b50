"""The engraving alphabet: characters as single strokes of lines and arcs.

A cutter follows a *stroke*, the centre line of a groove. Drawing strokes with straight lines and
circular arcs only, joined without a corner where the letter allows it, keeps an engraved
character down to a few exact faces: every line or arc of a groove's outline is one wall. The
proportions follow the lettering of technical drawings (ISO 3098: capitals and digits 1, small
letters 0.7 high), with round letters drawn as full circles, which are the cheapest walls and set
O apart from the narrow 0.

Terms
-----
cap height : the unit of this module; the baseline is y = 0, capitals and digits reach y = 1.
bulge : tan(sweep / 4) of an arc, positive counter-clockwise, 0 for a line (as in DXF).
spacing : the distance between the strokes of neighbouring characters.
bar : a straight stroke under the text that tells which way is up (6, 9, 8, 1).

The table below writes a stroke as its vertices: ``x,y`` is reached along a straight line,
``x,y<90`` along an arc of that sweep in degrees, ``x,y~`` along the arc that leaves without a
corner. A stroke that returns to its first vertex is closed, ``;`` begins another stroke, and a
single vertex is a dot: the cutter plunges.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache

import numpy as np

from ifs_cad.elements.arcs import Path, bounds
from ifs_cad.errors import LabelError
from ifs_cad.types import FloatArray

__all__ = [
    "BAR_DROP",
    "CHARACTERS",
    "DOT_RADIUS",
    "MAX_CUTTER_RATIO",
    "SPACING",
    "Glyph",
    "bar",
    "descent",
    "glyph",
    "text_paths",
    "text_positions",
    "traced",
]

MAX_CUTTER_RATIO = 0.25
"""Widest cutter in cap heights: every counter of the alphabet stays open up to here."""

SPACING = MAX_CUTTER_RATIO + 0.1
"""Distance between the strokes of neighbours, cap heights: a tenth of wood stays between."""

BAR_DROP = SPACING
"""Distance from the lowest stroke of the text to the bar, cap heights."""

DOT_RADIUS = 0.05
"""Radius of the ring that stands for a dot where strokes are only drawn, cap heights."""

_DESCENT = 0.35
_DESCENDING = frozenset("gjpqy")
_SHORTEST_BAR = 0.5
_SPACE_WIDTH = 0.25

_STROKES = {
    "0": "0,.25 .5,.25<180 .5,.75 0,.75<180 0,.25",
    "1": "0,.75 .25,1 .25,0",
    "2": ".5,0 0,0 .45,.6 0,.75~",
    "3": ".042154,.88 .25,.52<-240 .024833,.13<-240",
    "4": ".2,1 0,.3 .5,.3 ; .5,.65 .5,0",
    "5": ".45,1 .04,1 0,.523607 0,.076393<-263.6206",
    "6": "0,.28 .56,.28<-180 0,.28<-180 .45,1~",
    "7": "0,1 .5,1 .15,0",
    "8": ".27,.54 .27,0<180 .27,.54<180 ; .27,.54 .27,1<180 .27,.54<180",
    "9": ".56,.72 0,.72<-180 .56,.72<-180 .11,0~",
    ".": "0,0",
    "-": "0,.5 .4,.5",
    "_": "0,0 .5,0",
    "+": "0,.5 .5,.5 ; .25,.25 .25,.75",
    "A": "0,0 .35,1 .7,0 ; .105,.3 .595,.3",
    "B": "0,.54 .28,.54 .28,0<-180 0,0 0,1 .25,1 .25,.54<-180",
    "C": ".853553,.853553 .853553,.146447<270",
    "D": "0,0 0,1 .2,1 .2,0<-180 0,0",
    "E": ".5,1 0,1 0,0 .5,0 ; 0,.5 .4,.5",
    "F": ".5,1 0,1 0,0 ; 0,.5 .4,.5",
    "G": ".853553,.853553 1,.5<315 .6,.5",
    "H": "0,0 0,1 ; .6,0 .6,1 ; 0,.5 .6,.5",
    "I": "0,0 .4,0 ; 0,1 .4,1 ; .2,0 .2,1",
    "J": ".5,1 .5,.25 0,.25~",
    "K": "0,0 0,1 ; .5,1 0,.4 ; .15,.58 .55,0",
    "L": "0,1 0,0 .5,0",
    "M": "0,0 0,1 .4,.3 .8,1 .8,0",
    "N": "0,0 0,1 .6,0 .6,1",
    "O": "0,.5 1,.5<180 0,.5<180",
    "P": "0,0 0,1 .27,1 .27,.46~ 0,.46",
    "Q": "0,.5 1,.5<180 0,.5<180 ; .6,.4 1,0",
    "R": "0,0 0,1 .27,1 .27,.46~ 0,.46 ; .27,.46 .55,0",
    "S": ".466506,.875 .25,.5<240 .033494,.125~",
    "T": "0,1 .6,1 ; .3,1 .3,0",
    "U": "0,1 0,.3 .6,.3~ .6,1",
    "V": "0,1 .35,0 .7,1",
    "W": "0,1 .25,0 .5,.8 .75,0 1,1",
    "X": "0,0 .6,1 ; 0,1 .6,0",
    "Y": "0,1 .3,.5 .6,1 ; .3,.5 .3,0",
    "Z": "0,1 .55,1 0,0 .55,0",
    "a": "0,.35 .7,.35<180 0,.35<180 ; .7,.7 .7,0",
    "b": "0,.35 .7,.35<180 0,.35<180 ; 0,1 0,0",
    "c": ".597487,.597487 .597487,.102513<270",
    "d": "0,.35 .7,.35<180 0,.35<180 ; .7,1 .7,0",
    "e": "0,.35 .7,.35 0,.35<180 .525,.046891~",
    "f": ".45,1 .2,.75<90 .2,0 ; 0,.6 .4,.6",
    "g": "0,.35 .7,.35<180 0,.35<180 ; .7,.7 .7,0 .05,-.18~",
    "h": "0,1 0,0 ; 0,.4 .6,.4<-180 .6,0",
    "i": "0,.7 0,0 ; 0,1",
    "j": ".25,.7 .25,-.1 0,-.35~ ; .25,1",
    "k": "0,1 0,0 ; .45,.7 0,.25 ; .14,.39 .5,0",
    "l": "0,1 0,.2 .2,0~",
    "m": "0,.7 0,0 ; 0,.5 .4,.5<-180 .4,0 ; .4,.5 .8,.5<-180 .8,0",
    "n": "0,.7 0,0 ; 0,.4 .6,.4<-180 .6,0",
    "o": "0,.35 .7,.35<180 0,.35<180",
    "p": "0,.35 .7,.35<180 0,.35<180 ; 0,.7 0,-.35",
    "q": "0,.35 .7,.35<180 0,.35<180 ; .7,.7 .7,-.35",
    "r": "0,.7 0,0 ; 0,.4 .3,.7<-90 .512132,.612132~",
    "s": ".326554,.6125 .175,.35<240 .023446,.0875~",
    "t": ".2,1 .2,.2 .4,0~ ; 0,.7 .4,.7",
    "u": "0,.7 0,.3 .6,.3~ ; .6,.7 .6,0",
    "v": "0,.7 .3,0 .6,.7",
    "w": "0,.7 .22,0 .44,.6 .66,0 .88,.7",
    "x": "0,0 .5,.7 ; 0,.7 .5,0",
    "y": "0,.7 .3,0 ; .6,.7 .15,-.35",
    "z": "0,.7 .5,.7 0,0 .5,0",
}

CHARACTERS = "".join(_STROKES) + " "
"""Every character that can be engraved."""


@dataclass(frozen=True, eq=False)
class Glyph:
    """The strokes of one character, the leftmost point at x = 0.

    Attributes
    ----------
    paths : tuple of Path
        Cap height 1, baseline y = 0.
    width : float
        Extent of the strokes in x, cap heights.
    """

    paths: tuple[Path, ...]
    width: float

    @property
    def advance(self) -> float:
        """Distance to the origin of the next character, cap heights."""
        return self.width + SPACING


@cache
def glyph(character: str) -> Glyph:
    """Return the strokes of one character.

    Raises
    ------
    LabelError
        The character is not in the alphabet.
    """
    if character == " ":
        return Glyph((), _SPACE_WIDTH)
    if character not in _STROKES:
        raise LabelError(
            f"The character {character!r} cannot be engraved; use letters A-Z and a-z, digits, "
            "'.', '-', '_', '+' and space.",
            character=character,
        )
    paths = [_read_stroke(stroke) for stroke in _STROKES[character].split(";")]
    (left, _), (right, _) = bounds(paths)
    return Glyph(tuple(path.moved((-left, 0.0)) for path in paths), float(right - left))


def text_positions(text: str) -> tuple[FloatArray, float]:
    """Place the characters of a text along x.

    Returns
    -------
    positions : (k,) floats
        Origin of each character, cap heights.
    width : float
        From the leftmost to the rightmost stroke, cap heights.

    Raises
    ------
    LabelError
        An empty text, or a character that is not in the alphabet.
    """
    if not text.strip():
        raise LabelError(f"The text {text!r} has nothing to engrave.")
    advances = [glyph(character).advance for character in text]
    # Texts of the same characters in any order get the same width to the last bit, and one bar.
    return np.cumsum([0.0, *advances[:-1]]), math.fsum([*advances, -SPACING])


def text_paths(text: str) -> tuple[tuple[Path, ...], float]:
    """Return the strokes of a text placed along x, and its width, cap heights.

    Raises
    ------
    LabelError
        An empty text, or a character that is not in the alphabet.
    """
    positions, width = text_positions(text)
    paths = tuple(
        path.moved((x, 0.0))
        for character, x in zip(text, positions, strict=True)
        for path in glyph(character).paths
    )
    return paths, width


def descent(text: str) -> float:
    """Return how far the strokes of a text reach below the baseline, cap heights."""
    return _DESCENT if _DESCENDING.intersection(text) else 0.0


def bar(width: float, descent: float = 0.0) -> Path:
    """Return the bar under a text, which tells which way is up.

    Parameters
    ----------
    width : float
        Width of the text, cap heights. A text narrower than half a cap height gets a bar of that
        length, centred.
    descent : float
        How far the text reaches below the baseline, cap heights.
    """
    overhang = max(0.0, _SHORTEST_BAR - width) / 2
    y = -descent - BAR_DROP
    return Path(np.array([(-overhang, y), (width + overhang, y)]), np.zeros(1))


def traced(paths: Iterable[Path]) -> tuple[Path, ...]:
    """Return strokes of cap height 1 with every dot as a small ring.

    STEP has no place for a lone point among drawn curves, and no tool follows one.
    """
    return tuple(_ring(path) if len(path.vertices) == 1 else path for path in paths)


def _ring(dot: Path) -> Path:
    poles = dot.vertices + np.array([(DOT_RADIUS, 0.0), (-DOT_RADIUS, 0.0)])
    return Path(poles, np.ones(2), closed=True)


def _read_stroke(notation: str) -> Path:
    """Read one stroke of the table (see the module's docstring)."""
    vertices: list[complex] = []
    sweeps: list[float] = []
    heading = 0.0
    for token in notation.split():
        x, y, arc = re.fullmatch(r"([-.\d]+),([-.\d]+)(~|<[-.\d]+)?", token).groups()  # type: ignore[union-attr]
        vertices.append(complex(float(x), float(y)))
        if len(vertices) == 1:
            continue
        chord = vertices[-1] - vertices[-2]
        direction = math.atan2(chord.imag, chord.real)
        if arc == "~":
            sweep = 2 * math.remainder(direction - heading, 2 * math.pi)
        else:
            sweep = math.radians(float(arc[1:])) if arc else 0.0
        sweeps.append(sweep)
        heading = direction + sweep / 2
    closed = len(vertices) > 1 and vertices[0] == vertices[-1]
    points = np.array(vertices[: len(vertices) - closed])
    return Path(np.stack([points.real, points.imag], axis=1), np.tan(np.array(sweeps) / 4), closed)
