"""Plane geometry of lines and circular arcs: the strokes and outlines of engraving.

Terms
-----
path : a chain of lines and arcs; a dot when it has a single vertex.
loop : a closed path.
bulge : tan(sweep / 4) of an arc, positive counter-clockwise, 0 for a line (as in DXF).
share : a place on a segment as a fraction of its length.

Inside the functions points are complex numbers: products rotate, and conj(a) b holds the dot
product (real) and the cross product (imaginary) of a and b.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ifs_cad.errors import InputError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import ArrayLike, BoolArray, FloatArray, IntArray, frozen

__all__ = [
    "ComplexArray",
    "Path",
    "Segments",
    "area",
    "as_complex",
    "bounds",
    "crossings",
    "distance_to_strokes",
    "perimeter",
    "winding",
]

ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Path:
    """A chain of lines and arcs in the plane.

    Parameters
    ----------
    vertices : (k, 2) floats
        One vertex is a dot.
    bulges : (k,) floats when closed, else (k - 1,)
        tan(sweep / 4) of the segment that leaves each vertex; what is below `tol.parallel`
        becomes a line.
    closed : bool
        Whether a last segment returns to the first vertex.

    Raises
    ------
    InputError
        Shapes that do not fit, values that are not finite, or a segment without length.
    """

    vertices: FloatArray
    bulges: FloatArray
    closed: bool = False

    def __post_init__(self) -> None:
        vertices = np.array(self.vertices, dtype=float)
        bulges = np.array(self.bulges, dtype=float)
        if vertices.ndim != 2 or vertices.shape[1] != 2 or len(vertices) < 1 + self.closed:
            raise InputError(
                f"A path needs (k, 2) vertices, two or more when closed, got {vertices.shape}."
            )
        if bulges.shape != (len(vertices) - (not self.closed),):
            raise InputError(
                f"A path of {len(vertices)} vertices cannot have bulges of shape {bulges.shape}: "
                "give one for each segment."
            )
        if not (np.isfinite(vertices).all() and np.isfinite(bulges).all()):
            raise InputError("The vertices and bulges of a path must be finite.")
        # The centre of so flat an arc would be too far away to tell its points apart.
        bulges[np.abs(bulges) < DEFAULT.parallel] = 0.0
        object.__setattr__(self, "vertices", frozen(vertices))
        object.__setattr__(self, "bulges", frozen(bulges))
        if (self.starts == self.ends).all(axis=1).any():
            raise InputError("A path must not repeat a vertex: its segments need a length.")

    @property
    def starts(self) -> FloatArray:
        """(s, 2) first points of the segments."""
        return self.vertices[: len(self.bulges)]

    @property
    def ends(self) -> FloatArray:
        """(s, 2) last points of the segments."""
        return np.roll(self.vertices, -1, axis=0)[: len(self.bulges)]

    @property
    def sweeps(self) -> FloatArray:
        """(s,) angles swept by the segments, radians, positive counter-clockwise."""
        return np.asarray(4.0 * np.arctan(self.bulges))

    @property
    def centres(self) -> FloatArray:
        """(s, 2) centres of the arcs, NaN for lines."""
        bulges = np.where(self.bulges == 0.0, np.nan, self.bulges)[:, None]
        chords = self.ends - self.starts
        to_the_left = chords[:, ::-1] * (-1.0, 1.0)
        return np.asarray(self.starts + chords / 2 + to_the_left * (1 / bulges - bulges) / 4)

    def moved(self, shift: ArrayLike) -> Path:
        """Return the path moved by (2,) `shift`."""
        return Path(self.vertices + np.asarray(shift, dtype=float), self.bulges, self.closed)

    def scaled(self, factor: float) -> Path:
        """Return the path enlarged about the origin."""
        return Path(self.vertices * factor, self.bulges, self.closed)


@dataclass(frozen=True, eq=False)
class Segments:
    """Lines and arcs as parallel arrays, for computing with many at once.

    Attributes
    ----------
    starts, ends : (n,) complex
    sweeps : (n,) floats
        Radians, positive counter-clockwise; 0 for a line.
    centres : (n,) complex
        NaN for a line.
    """

    starts: ComplexArray
    ends: ComplexArray
    sweeps: FloatArray
    centres: ComplexArray

    @staticmethod
    def of(paths: Sequence[Path]) -> Segments:
        """Return the segments of all paths, a dot as a line without length."""
        dots = [path.vertices for path in paths if len(path.vertices) == 1]
        no_centre = np.full((len(dots), 2), np.nan)
        return Segments(
            as_complex(np.concatenate([path.starts for path in paths] + dots)),
            as_complex(np.concatenate([path.ends for path in paths] + dots)),
            np.concatenate([path.sweeps for path in paths] + [np.zeros(len(dots))]),
            as_complex(np.concatenate([path.centres for path in paths] + [no_centre])),
        )

    @staticmethod
    def joined(parts: Sequence[Segments]) -> Segments:
        """Return all segments of the parts, in order."""
        return Segments(
            np.concatenate([part.starts for part in parts]),
            np.concatenate([part.ends for part in parts]),
            np.concatenate([part.sweeps for part in parts]),
            np.concatenate([part.centres for part in parts]),
        )

    def __getitem__(self, which: IntArray | BoolArray) -> Segments:
        return Segments(
            self.starts[which], self.ends[which], self.sweeps[which], self.centres[which]
        )

    def __len__(self) -> int:
        return len(self.starts)

    @property
    def is_line(self) -> BoolArray:
        """(n,) which segments are straight."""
        return np.asarray(self.sweeps == 0.0)

    @property
    def radii(self) -> FloatArray:
        """(n,) radii, infinite for lines."""
        return np.where(self.is_line, np.inf, np.abs(self.starts - self.centres))

    @property
    def lengths(self) -> FloatArray:
        """(n,) lengths along the segments."""
        chords = np.abs(self.ends - self.starts)
        arcs = np.abs(self.starts - self.centres) * np.abs(self.sweeps)
        return np.where(self.is_line, chords, arcs)

    @property
    def middles(self) -> ComplexArray:
        """(n,) points half-way along."""
        return self.at(np.full(len(self), 0.5))

    def at(self, shares: FloatArray) -> ComplexArray:
        """Return one point on each segment, at (n,) shares of the lengths."""
        on_line = self.starts + shares * (self.ends - self.starts)
        on_arc = self.centres + (self.starts - self.centres) * np.exp(1j * shares * self.sweeps)
        return np.where(self.is_line, on_line, on_arc)

    def locate(self, points: ComplexArray) -> tuple[FloatArray, FloatArray]:
        """Return the share of its segment beside which each of (n,) points lies, and how far off.

        Shares below 0 and above 1 lie before the start and after the end.
        """
        chords = self.ends - self.starts
        with np.errstate(divide="ignore", invalid="ignore"):
            beside_line = (points - self.starts) / chords
            spokes = points - self.centres
            turned = np.angle(spokes / (self.middles - self.centres))
            shares = np.where(self.is_line, beside_line.real, 0.5 + turned / self.sweeps)
            off_line = np.abs(beside_line.imag * chords)
            off_arc = np.abs(np.abs(spokes) - self.radii)
        return shares, np.where(self.is_line, off_line, off_arc)

    def distance(self, points: ComplexArray) -> FloatArray:
        """Return the distance of (k,) points to the nearest segment."""
        each = self[np.repeat(np.arange(len(self)), len(points))]
        repeated = np.tile(points, len(self))
        shares, off = each.locate(repeated)
        to_ends = np.minimum(np.abs(repeated - each.starts), np.abs(repeated - each.ends))
        beside = (shares > 0.0) & (shares < 1.0)
        return np.asarray(np.where(beside, off, to_ends).reshape(len(self), -1).min(axis=0))


def bounds(paths: Iterable[Path]) -> FloatArray:
    """Return the exact extent ((x_min, y_min), (x_max, y_max)) of strokes, without the cutter."""
    points = []
    compass = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])
    for path in paths:
        points.append(path.vertices)
        spokes = path.starts - path.centres
        begin = np.arctan2(spokes[:, 1], spokes[:, 0])[:, None]
        sweeps = path.sweeps[:, None]
        # An arc reaches beyond its ends where it passes east, north, west or south of its centre.
        ahead = (np.arange(4) * (np.pi / 2) - begin) * np.sign(sweeps) % (2 * np.pi)
        arc, side = np.nonzero(ahead < np.abs(sweeps))
        radii = np.hypot(spokes[arc, 0], spokes[arc, 1])[:, None]
        points.append(path.centres[arc] + radii * compass[side])
    stacked = np.concatenate(points)
    return np.array([stacked.min(axis=0), stacked.max(axis=0)])


def area(loop: Path) -> float:
    """Return the signed area enclosed by a loop, mm2, positive counter-clockwise."""
    curves = Segments.of([loop])
    polygon = _cross(curves.starts, curves.ends).sum() / 2
    arcs = ~curves.is_line
    sweeps = curves.sweeps[arcs]
    segments = curves.radii[arcs] ** 2 * (sweeps - np.sin(sweeps)) / 2
    return float(polygon + segments.sum())


def perimeter(loop: Path) -> float:
    """Return the length of a path, mm."""
    return float(Segments.of([loop]).lengths.sum())


def winding(loop: Path, points: ArrayLike) -> IntArray:
    """Return how often a loop runs counter-clockwise around (n, 2) points, exactly for arcs."""
    curves = Segments.of([loop])
    point = as_complex(np.asarray(points, dtype=float))[:, None]
    to_start, to_end = curves.starts - point, curves.ends - point
    turns = np.angle(to_end * np.conj(to_start)) / (2 * np.pi)
    # Between an arc and its chord, the arc goes round the other side of the point.
    side = np.sign(curves.sweeps)
    in_circle = np.abs(point - curves.centres) < curves.radii
    between = (turns * side < 0) & in_circle
    return np.asarray(np.rint((turns + between * side).sum(axis=1)), dtype=np.int64)


def distance_to_strokes(strokes: Sequence[Path], points: ArrayLike) -> FloatArray:
    """Return the distance of (n, 2) points to the nearest stroke, mm."""
    return Segments.of(strokes).distance(as_complex(np.asarray(points, dtype=float)))


def as_complex(points: FloatArray) -> ComplexArray:
    """Return (..., 2) points as complex numbers."""
    return np.asarray(points[..., 0] + 1j * points[..., 1])


def _cross(a: ComplexArray, b: ComplexArray) -> FloatArray:
    return np.asarray(np.imag(np.conj(a) * b))


def _dot(a: ComplexArray, b: ComplexArray) -> FloatArray:
    return np.asarray(np.real(np.conj(a) * b))


def crossings(a: Segments, b: Segments, tol: Tolerance) -> ComplexArray:
    """Return (2, n) points where the full line or circle under a_k meets that under b_k, or NaN.

    Where one of the two is a line, it must be a.
    """
    points = np.full(len(a.starts), np.nan, dtype=complex)
    to_sides = np.zeros(len(a.starts), dtype=complex)
    with np.errstate(divide="ignore", invalid="ignore"):
        both = a.is_line & b.is_line
        one, other = a[both], b[both]
        direction, chord = one.ends - one.starts, other.ends - other.starts
        share = _cross(other.starts - one.starts, chord) / _cross(direction, chord)
        points[both] = one.starts + share * direction

        mixed = a.is_line & ~b.is_line
        one, other = a[mixed], b[mixed]
        direction = (one.ends - one.starts) / np.abs(one.ends - one.starts)
        foot = one.starts + direction * _dot(direction, other.centres - one.starts)
        points[mixed] = foot
        distance = np.abs(foot - other.centres)
        to_sides[mixed] = direction * _half_chord(other.radii, distance, tol)

        arcs = ~a.is_line & ~b.is_line
        one, other = a[arcs], b[arcs]
        apart = np.abs(other.centres - one.centres)
        direction = (other.centres - one.centres) / apart
        distance = (apart + (one.radii - other.radii) * (one.radii + other.radii) / apart) / 2
        points[arcs] = one.centres + direction * distance
        to_sides[arcs] = 1j * direction * _half_chord(one.radii, distance, tol)
    return np.stack([points - to_sides, points + to_sides])


def _half_chord(radii: FloatArray, distance: FloatArray, tol: Tolerance) -> FloatArray:
    """Return half the length of chords at a distance from the centre, NaN outside the circle."""
    squared = (radii - distance) * (radii + distance)
    # Curves that touch meet in one point; the square root would blur it.
    return np.asarray(np.sqrt(np.where(np.abs(squared) < tol.sliver**2, 0.0, squared)))
