"""Read labels back from their geometry: the reverse of `label`, `glyph` and `groove`.

The bar beneath a text gives its baseline, its direction and which way is up. Characters stand
apart along it, so each is a cluster of curves; its extent, in cap heights, names the few
characters that it may be, and the distance of its curves from their strokes decides. The cap
height is not known: it is whatever makes the highest character one of the alphabet.

Terms
-----
outline : the boundary of a groove, every point at the cutter's radius from the strokes.
drawn : of strokes without width, dots as small rings.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ifs_cad.elements.arcs import ComplexArray, Path, Segments, bounds
from ifs_cad.elements.glyph import (
    BAR_DROP,
    CHARACTERS,
    DOT_RADIUS,
    MAX_CUTTER_RATIO,
    bar,
    descent,
    glyph,
    text_positions,
    traced,
)
from ifs_cad.elements.groove import groove
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import FloatArray

__all__ = ["Reading", "read_drawn", "read_engraved"]

HEIGHT_DECIMALS = 6
"""Cap heights and radii found, mm, are rounded to these: equal glyphs are then made once."""

TOP_DECIMALS = 4
"""Letters that differ less in height, in cap heights, are meant to be equally high."""

_LETTERS = CHARACTERS.replace(" ", "")


@dataclass(frozen=True)
class Reading:
    """A label that was read.

    Attributes
    ----------
    text : str
        Empty when what stands above a bar is no text of the alphabet.
    height, cutter : float
        Cap height and width of the groove, mm; the width is 0 for drawn strokes.
    """

    text: str
    height: float
    cutter: float


@dataclass(frozen=True, eq=False)
class _Bar:
    """A groove or line that may be the bar under a text, and all other curves."""

    ends: tuple[complex, complex]
    radius: float
    others: Segments

    @property
    def length(self) -> float:
        return abs(self.ends[1] - self.ends[0])


def read_engraved(outlines: Sequence[Segments], tol: Tolerance = DEFAULT) -> Reading | None:
    """Read an engraved label from the outlines of the floors of its pockets.

    Parameters
    ----------
    outlines : sequence of Segments
        One for each floor, its islands included, seen from outside, mm. In any place, turned by
        any angle, among other pockets.

    Returns
    -------
    Reading or None
        None when there is no bar with something above it.
    """
    bars = []
    for k, outline in enumerate(outlines):
        others = [*outlines[:k], *outlines[k + 1 :]]
        if others and _is_stadium(outline, tol):
            caps = np.flatnonzero(~outline.is_line)
            left, right = outline.centres[caps].tolist()
            radius = round(float(outline.radii[caps[0]]), HEIGHT_DECIMALS)
            bars.append(_Bar((left, right), radius, Segments.joined(others)))
    return _read(bars, tol)


def read_drawn(strokes: Segments, tol: Tolerance = DEFAULT) -> Reading | None:
    """Read a label of drawn strokes.

    Parameters
    ----------
    strokes : Segments
        Lines and arcs seen from outside, mm; in any order, place and direction.

    Returns
    -------
    Reading or None
        None when there is no line with something above it.
    """
    numbers = np.arange(len(strokes))
    return _read(
        [
            _Bar((complex(strokes.starts[k]), complex(strokes.ends[k])), 0.0, strokes[numbers != k])
            for k in np.flatnonzero(strokes.is_line)
        ],
        tol,
    )


def _is_stadium(outline: Segments, tol: Tolerance) -> bool:
    """Tell whether an outline is that of a straight stroke: two lines and two half circles."""
    caps = np.abs(outline.sweeps[~outline.is_line])
    return len(outline) == 4 and len(caps) == 2 and bool((np.abs(caps - np.pi) < tol.sliver).all())


def _read(bars: Sequence[_Bar], tol: Tolerance) -> Reading | None:
    """Read the text above the first bar that has one, the longest first, either way up."""
    unreadable = None
    for candidate in sorted(bars, key=lambda bar: -bar.length):
        for left, right in (candidate.ends, candidate.ends[::-1]):
            characters = _characters(candidate, left, right, tol)
            if characters:
                reading = _text(characters, candidate, tol)
                if reading is not None:
                    return reading
                unreadable = Reading("", 0.0, 2 * candidate.radius)
    return unreadable


@dataclass(frozen=True, eq=False)
class _Cluster:
    """The curves of one character, x along the bar and y up from its left end, mm.

    `box` is the extent of the strokes: (left, bottom, right, top).
    """

    curves: Segments
    box: FloatArray


def _characters(bar: _Bar, left: complex, right: complex, tol: Tolerance) -> list[_Cluster]:
    """Return what stands above a bar, parted where a vertical line fits between, left to right."""
    turn = abs(right - left) / (right - left)
    curves = Segments(
        (bar.others.starts - left) * turn,
        (bar.others.ends - left) * turn,
        bar.others.sweeps,
        (bar.others.centres - left) * turn,
    )
    low, high = _extents(curves)
    # the ring of a dot reaches beyond the bar, whose length is at least half a cap height
    slack = bar.radius + 2 * DOT_RADIUS * bar.length + tol.sliver
    above = (low.real > -slack) & (high.real < bar.length + slack) & (low.imag > bar.radius)
    if bar.radius == 0.0 and not above.all():
        return []  # pockets may belong to something else, drawn strokes are all of the label
    order = np.flatnonzero(above)
    order = order[np.argsort(low.real[order])]
    reach = np.maximum.accumulate(high.real[order])
    breaks = np.flatnonzero(low.real[order][1:] > reach[:-1] + tol.sliver) + 1
    clusters = []
    for members in np.split(order, breaks) if len(order) else ():
        corner, opposite = low[members], high[members]
        box = [corner.real.min(), corner.imag.min(), opposite.real.max(), opposite.imag.max()]
        inwards = bar.radius * np.array([1.0, 1.0, -1.0, -1.0])
        clusters.append(_Cluster(curves[members], np.array(box) + inwards))
    return clusters


def _extents(curves: Segments) -> tuple[ComplexArray, ComplexArray]:
    """Return the lower left and upper right corner of the exact box of each curve."""
    xs, ys = ([f(curves.starts), f(curves.ends)] for f in (np.real, np.imag))
    begin = np.angle(curves.starts - curves.centres)
    for quarter in range(4):
        # an arc reaches beyond its ends where it passes east, north, west or south of its centre
        ahead = (quarter * np.pi / 2 - begin) * np.sign(curves.sweeps) % (2 * np.pi)
        with np.errstate(invalid="ignore"):  # lines have infinite radii and no centre
            pole = curves.centres + curves.radii * 1j**quarter
        passed = ~curves.is_line & (ahead < np.abs(curves.sweeps))
        pole = np.where(passed, pole, curves.starts)
        xs.append(pole.real)
        ys.append(pole.imag)
    x, y = np.stack(xs), np.stack(ys)
    return x.min(axis=0) + 1j * y.min(axis=0), x.max(axis=0) + 1j * y.max(axis=0)


def _text(clusters: Sequence[_Cluster], bar: _Bar, tol: Tolerance) -> Reading | None:
    """Read the characters above a bar, at the first cap height that makes sense of them all."""
    boxes = np.array([cluster.box for cluster in clusters])
    alphabet = _alphabet(bar.radius == 0.0)
    for height, baseline in _heights(boxes, alphabet, bar.radius):
        letters = alphabet * height + [0.0, baseline, 0.0, baseline]
        off = np.abs(_shapes(boxes)[:, None] - _shapes(letters)).max(axis=2)
        text, starts = "", []
        for cluster, likely in zip(clusters, off < 2 * tol.sliver, strict=True):
            for k in np.flatnonzero(likely):
                start = cluster.box[0] - letters[k, 0]
                if _is(_LETTERS[k], cluster.curves, (start, baseline), height, bar.radius, tol):
                    text += _LETTERS[k]
                    starts.append(start)
                    break
            else:
                break
        if len(text) == len(clusters):
            text = _with_spaces(text, np.array(starts) / height)
            if _stands(text, starts, height, baseline, bar.length, tol):
                height = bar.length / np.ptp(_bar_ends(text)[:, 0])
                return Reading(text, round(float(height), HEIGHT_DECIMALS), 2 * bar.radius)
    return None


@lru_cache
def _alphabet(drawn: bool) -> FloatArray:
    """Return the extent of the strokes of every letter, cap heights, baseline at y = 0."""
    return np.array([bounds(_strokes(letter, 1.0, drawn)).ravel() for letter in _LETTERS])


@lru_cache(maxsize=4096)
def _strokes(letter: str, height: float, drawn: bool) -> tuple[Path, ...]:
    paths = glyph(letter).paths
    return tuple(path.scaled(height) for path in (traced(paths) if drawn else paths))


def _shapes(boxes: FloatArray) -> FloatArray:
    """Return width, bottom and top of (k, 4) boxes."""
    return np.stack([boxes[:, 2] - boxes[:, 0], boxes[:, 1], boxes[:, 3]], axis=1)


def _heights(
    boxes: FloatArray, alphabet: FloatArray, radius: float
) -> Iterator[tuple[float, float]]:
    """Yield the cap heights at which some letter is as high as the highest character.

    With each the height of the baseline above the bar, mm.
    """
    least = 2 * radius / MAX_CUTTER_RATIO
    for drop in (BAR_DROP, BAR_DROP + descent("g")):
        for top in np.unique(alphabet[:, 3].round(TOP_DECIMALS))[::-1].tolist():
            height = round(float(boxes[:, 3].max()) / (drop + top), HEIGHT_DECIMALS)
            if height > least * (1 - 10**-TOP_DECIMALS):
                height = max(height, least)
                yield height, drop * height


def _is(
    letter: str,
    curves: Segments,
    origin: tuple[float, float],
    height: float,
    radius: float,
    tol: Tolerance,
) -> bool:
    """Tell whether curves are the outline of a letter, or its strokes: no more and no less."""
    strokes = Segments.of(_strokes(letter, height, radius == 0.0))
    points = np.concatenate([curves.starts, curves.middles, curves.ends]) - complex(*origin)
    off = np.abs(strokes.distance(points) - radius).max()
    whole = groove(letter, height, 2 * radius).perimeter if radius else strokes.lengths.sum()
    lacking = np.abs(curves.lengths.sum() - whole)
    return bool(off < 2 * tol.sliver and lacking < 2 * tol.sliver * len(curves))


def _with_spaces(text: str, starts: FloatArray) -> str:
    """Return a text with the spaces that the distances of its letters leave room for."""
    advances = np.array([glyph(letter).advance for letter in text[:-1]])
    spaces = np.rint((np.diff(starts) - advances) / glyph(" ").advance).clip(0)
    return "".join(
        letter + " " * int(count) for letter, count in zip(text, [*spaces.tolist(), 0], strict=True)
    )


def _stands(
    text: str,
    starts: Sequence[float],
    height: float,
    baseline: float,
    bar_length: float,
    tol: Tolerance,
) -> bool:
    """Tell whether the letters of a text, and the bar beneath, stand where they belong."""
    positions, _ = text_positions(text)
    letters = np.array([letter != " " for letter in text])
    (left, level), (right, _) = (height * _bar_ends(text)).tolist()
    off = np.abs(positions[letters] * height - left - starts).max()
    return bool(max(off, abs(right - left - bar_length), abs(baseline + level)) < 4 * tol.sliver)


def _bar_ends(text: str) -> FloatArray:
    """Return the two ends of the bar under a text, cap heights."""
    _, width = text_positions(text)
    return bar(width, descent(text)).vertices
