"""The exact outline of an engraved groove: all points within a cutter's radius of its strokes.

The outline consists of offset lines, offset arcs and circles about the vertices, nothing else.
All of them are drawn with the groove on their left, cut where they meet, and the pieces that no
stroke comes closer to than a radius are chained into loops: outer boundaries counter-clockwise,
islands (what stays standing inside an A or an 8) clockwise.

Terms
-----
stroke : a `Path` that the cutter's axis follows.
loop : a closed `Path`.
region : one connected pocket, an outer loop and its islands; an i has two.

Source: the usual offset-and-trim construction (X.-Z. Liu et al., An offset algorithm for polyline
curves, Computers in Industry 58, 2007), with the distance to the strokes as the only test.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ifs_cad.elements.arcs import (
    ComplexArray,
    Path,
    Segments,
    area,
    as_complex,
    crossings,
    perimeter,
    winding,
)
from ifs_cad.elements.glyph import MAX_CUTTER_RATIO, glyph
from ifs_cad.errors import InputError, LabelError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import FloatArray, IntArray

__all__ = [
    "MAX_CUTTER_RATIO",
    "Groove",
    "Region",
    "check_cutter",
    "groove",
    "outline",
]


@dataclass(frozen=True, eq=False)
class Region:
    """One connected pocket.

    Attributes
    ----------
    outer : Path
        Closed, counter-clockwise.
    islands : tuple of Path
        Closed, clockwise.
    """

    outer: Path
    islands: tuple[Path, ...] = ()

    @property
    def loops(self) -> tuple[Path, ...]:
        """The outer loop, then the islands."""
        return (self.outer, *self.islands)


@dataclass(frozen=True, eq=False)
class Groove:
    """The outline of what a cutter removes along strokes.

    Attributes
    ----------
    regions : tuple of Region
        Disjoint pockets.
    """

    regions: tuple[Region, ...]

    @property
    def loops(self) -> tuple[Path, ...]:
        """All loops of all regions."""
        return tuple(loop for region in self.regions for loop in region.loops)

    @property
    def area(self) -> float:
        """Area of the groove, mm2, in closed form."""
        return math.fsum(area(loop) for loop in self.loops)

    @property
    def perimeter(self) -> float:
        """Length of all walls, mm, in closed form."""
        return math.fsum(perimeter(loop) for loop in self.loops)

    @property
    def wall_count(self) -> int:
        """Number of lines and arcs, one wall each."""
        return sum(len(loop.bulges) for loop in self.loops)


@lru_cache(maxsize=4096)
def groove(character: str, height: float, cutter: float) -> Groove:
    """Return the groove of one character, its baseline on y = 0, its strokes from x = 0.

    Parameters
    ----------
    character : str
        One character of the alphabet; a space gives a groove without regions.
    height : float
        Cap height, mm.
    cutter : float
        Cutter diameter, mm, at most `MAX_CUTTER_RATIO` times the height.

    Raises
    ------
    LabelError
        The character is not in the alphabet, or too low for the cutter.
    InputError
        Height or cutter is not a positive number.
    """
    paths = glyph(character).paths
    check_cutter(height, cutter)
    if not paths:
        return Groove(())
    return outline([path.scaled(height) for path in paths], cutter / 2)


def check_cutter(height: float, cutter: float) -> None:
    """Refuse a cutter too wide for the cap height, both in mm.

    Raises
    ------
    LabelError
        The cutter is wider than `MAX_CUTTER_RATIO` cap heights.
    InputError
        Height or cutter is not a positive number.
    """
    if not (0 < height < math.inf and 0 < cutter < math.inf):
        raise InputError(
            f"Label height and cutter must be positive lengths, got {height} and {cutter} mm."
        )
    smallest = cutter / MAX_CUTTER_RATIO
    if height < smallest * (1 - DEFAULT.coincident):
        raise LabelError(
            f"A {cutter:g} mm cutter would close up characters {height:g} mm high: make them at "
            f"least {smallest:g} mm high, or take a cutter of at most "
            f"{height * MAX_CUTTER_RATIO:g} mm.",
            cutter=cutter,
            height=height,
            smallest_height=smallest,
        )


def outline(strokes: Sequence[Path], radius: float, tol: Tolerance = DEFAULT) -> Groove:
    """Return the exact outline of all points within `radius` of the strokes.

    Segments shorter than `tol.sliver` are left out and the gap is closed by their neighbours, so
    the outline may be off by a few times that much there; elsewhere it is exact.

    Parameters
    ----------
    strokes : sequence of Path
        One or more, mm.
    radius : float
        Radius of the cutter, mm.

    Raises
    ------
    LabelError
        Grooves that just touch each other: no solid has such an edge.
    InputError
        No strokes, or a radius not larger than a sliver.
    """
    if not strokes or not tol.sliver < radius < math.inf:
        raise InputError(
            f"An outline needs strokes and a radius above {tol.sliver} mm, "
            f"got {len(strokes)} strokes and {radius} mm."
        )
    pieces = _cut(_offsets(strokes, radius, tol), tol)
    clear = Segments.of(strokes).distance(pieces.middles) >= radius - tol.coincident
    pieces = _without_doubles(pieces[clear], tol)
    loops = [_merged(pieces[order], tol) for order in _chains(pieces, tol)]
    areas = np.array([area(loop) for loop in loops])
    outers = sorted((k for k in range(len(loops)) if areas[k] > 0), key=lambda k: float(areas[k]))
    islands: dict[int, list[Path]] = {k: [] for k in outers}
    for k in np.flatnonzero(areas < 0):
        corner = loops[k].vertices[:1]
        # The smallest outer loop around an island is its own: regions may stand inside islands.
        home = next(outer for outer in outers if winding(loops[outer], corner)[0] == 1)
        islands[home].append(loops[k])
    return Groove(tuple(Region(loops[k], tuple(islands[k])) for k in outers))


def _offsets(strokes: Sequence[Path], radius: float, tol: Tolerance) -> Segments:
    """Return both sides of every stroke, its caps and rounded corners, the groove on the left."""
    offsets = []
    for path in strokes:
        if len(path.vertices) == 1:
            opposite = radius * np.array([-1.0, 1.0])
            centre = as_complex(path.vertices[[0, 0]])
            offsets.append(
                Segments(centre + opposite, centre - opposite, np.array([np.pi, np.pi]), centre)
            )
            continue
        curves = Segments.of([path])
        chords = curves.ends - curves.starts
        half_turns = np.exp(0.5j * curves.sweeps)
        leaving = chords / np.abs(chords) / half_turns
        arriving = chords / np.abs(chords) * half_turns
        # Both sides are right sides: the left one is followed backwards.
        backwards = Segments(curves.ends, curves.starts, -curves.sweeps, curves.centres)
        for way, first, last in ((curves, leaving, arriving), (backwards, -arriving, -leaving)):
            side = Segments(
                way.starts - 1j * radius * first,
                way.ends - 1j * radius * last,
                way.sweeps,
                way.centres,
            )
            # The inner side of an arc tighter than the cutter lies within the groove.
            offsets.append(side[way.radii + np.sign(way.sweeps) * radius > tol.sliver])
        # A corner is rounded on the side that opens; an open path turns back at its ends.
        if path.closed:
            before, after, corners = arriving, np.roll(leaving, -1), curves.ends
        else:
            before = np.append(arriving, -leaving[0])
            after = np.concatenate([leaving[1:], -arriving[-1:], leaving[:1]])
            corners = np.append(curves.ends, curves.starts[0])
        turns = np.angle(after / before)
        opens_right = turns > 0
        from_ = np.where(opens_right, -1j * before, 1j * after)
        to = np.where(opens_right, -1j * after, 1j * before)
        rounded = Segments(corners + radius * from_, corners + radius * to, np.abs(turns), corners)
        offsets.append(rounded[np.abs(turns) > tol.parallel])
    return Segments.joined(offsets)


def _cut(curves: Segments, tol: Tolerance) -> Segments:
    """Cut curves where they meet and where one ends on another, leaving out slivers."""
    curves = curves[np.argsort(~curves.is_line, kind="stable")]
    count = len(curves)
    i, j = np.triu_indices(count, 1)
    meeting = crossings(curves[i], curves[j], tol).ravel()
    i, j = np.tile(i, 2), np.tile(j, 2)
    slack = tol.sliver / curves.lengths
    share_i, share_j = curves[i].locate(meeting)[0], curves[j].locate(meeting)[0]
    met = (np.abs(share_i - 0.5) < 0.5 + slack[i]) & (np.abs(share_j - 0.5) < 0.5 + slack[j])
    # Curves that lie on each other do not cross; they part where one of them ends.
    all_ends = np.concatenate([curves.starts, curves.ends])
    k = np.repeat(np.arange(count), len(all_ends))
    share_k, off = curves[k].locate(np.tile(all_ends, count))
    touched = off < tol.coincident

    every = np.arange(count)
    owner = np.concatenate([i[met], j[met], k[touched], every, every])
    share = np.concatenate(
        [share_i[met], share_j[met], share_k[touched], np.zeros(count), np.ones(count)]
    )
    inside = (share >= 0.0) & (share <= 1.0)
    owner, share = owner[inside], share[inside]
    order = np.lexsort((share, owner))
    owner, share = owner[order], share[order]
    long_enough = (owner[1:] == owner[:-1]) & (np.diff(share) > slack[owner[1:]])
    owner, first, last = owner[1:][long_enough], share[:-1][long_enough], share[1:][long_enough]
    whole = curves[owner]
    return Segments(whole.at(first), whole.at(last), whole.sweeps * (last - first), whole.centres)


def _without_doubles(pieces: Segments, tol: Tolerance) -> Segments:
    """Keep one of several pieces that lie on each other."""
    marks = np.stack([pieces.starts, pieces.middles, pieces.ends])
    same = (np.abs(marks[:, :, None] - marks[:, None, :]) < tol.sliver).all(axis=0)
    doubled = np.asarray(np.triu(same, 1).any(axis=0))
    return pieces[~doubled]


def _chains(pieces: Segments, tol: Tolerance) -> list[IntArray]:
    """Return, for each loop, its pieces in order.

    Raises
    ------
    LabelError
        More than one piece leaves a point, or none arrives there.
    """
    gaps = np.abs(pieces.ends[:, None] - pieces.starts[None, :])
    following = gaps.argmin(axis=1)
    between_starts = np.abs(pieces.starts[:, None] - pieces.starts[None, :])
    np.fill_diagonal(between_starts, np.inf)
    loose = (gaps.min(axis=1) > 4 * tol.sliver) | (between_starts.min(axis=1) < tol.sliver)
    loose |= np.bincount(following, minlength=len(following))[following] != 1
    if loose.any():
        point = pieces.starts[loose][0]
        raise LabelError(
            f"Two edges of the groove just touch at ({point.real:.3f}, {point.imag:.3f}) mm; "
            "take a slightly smaller cutter.",
            point=(float(point.real), float(point.imag)),
        )
    chains = []
    waiting = np.ones(len(following), dtype=bool)
    for first in range(len(following)):
        chain = []
        piece = first
        while waiting[piece]:
            waiting[piece] = False
            chain.append(piece)
            piece = int(following[piece])
        if chain:
            chains.append(np.array(chain))
    return chains


def _merged(chain: Segments, tol: Tolerance) -> Path:
    """Return a chain as a loop, with neighbours on one line or circle made one segment."""
    before = chain[np.roll(np.arange(len(chain)), 1)]
    directions = np.sign(chain.sweeps)
    chords, chords_before = chain.ends - chain.starts, before.ends - before.starts
    straight = np.abs(np.angle(chords / chords_before)) < tol.parallel
    concentric = np.abs(chain.centres - before.centres) < tol.sliver
    level = np.abs(np.abs(chain.starts - before.centres) - before.radii) < tol.sliver
    goes_on = np.where(chain.is_line, straight, concentric & level)
    corners = np.flatnonzero(~goes_on | (directions != np.sign(before.sweeps)))
    if len(corners) < 2:
        poles = chain.centres[0] + chain.radii[0] * np.array([1.0, -1.0])
        return _loop(poles, np.repeat(directions[0], 2))
    starts, centres, directions = chain.starts[corners], chain.centres[corners], directions[corners]
    with np.errstate(invalid="ignore"):
        turns = np.angle((np.roll(starts, -1) - centres) / (starts - centres))
    sweeps = np.where(directions == 0.0, 0.0, directions * (turns * directions % (2 * np.pi)))
    return _loop(starts, np.tan(sweeps / 4))


def _loop(vertices: ComplexArray, bulges: FloatArray) -> Path:
    return Path(np.stack([vertices.real, vertices.imag], axis=1), bulges, closed=True)
