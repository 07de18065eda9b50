"""Germs: what a figure is made of, and what its construction steps look like.

A germ is points with lines and faces through them. A construction step copies the points and
repeats the lines and faces, so every step K_n is points, lines and faces again and can be a germ.

Terms
-----
copies : the points of many copies of a germ, (n, g, d), as `Figure.at_depth` returns them.
cell : a line or a face, as numbers of points.

Source: the paper, section 2.3 (the germ K), figure 4.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ifs_cad.errors import InputError, SizeError
from ifs_cad.tolerance import MEMORY_LIMIT
from ifs_cad.types import ArrayLike, FloatArray, IntArray, frozen
from ifs_cad.vectors import cross, dot, length

Cells = IntArray | Iterable[Sequence[int] | IntArray]

__all__ = ["Cells", "Germ"]


@dataclass(frozen=True, eq=False, init=False)
class Germ:
    """Points, and the lines and faces through them.

    Parameters
    ----------
    points : (g, c) array
        In the plane (c = 2), in space (c = 3), mm; or barycentric rows on c control points.
    lines : (n, k) ints, or an iterable of int sequences or of such arrays, optional
        Open polylines as numbers of points.
    faces : (n, k) ints, or an iterable of int sequences or of such arrays, optional
        Polygons as numbers of their corners.

    Attributes
    ----------
    lines, faces : tuples of (n, k) int arrays
        Cells of one size together, the smallest first.

    Raises
    ------
    InputError
        No points, NaN, a cell with too few points or a point number out of range.
    """

    points: FloatArray
    lines: tuple[IntArray, ...]
    faces: tuple[IntArray, ...]

    def __init__(self, points: ArrayLike, lines: Cells = (), faces: Cells = ()) -> None:
        rows = _read_rows(points)
        object.__setattr__(self, "points", frozen(rows))
        object.__setattr__(self, "lines", _read_cells(lines, 2, len(rows), "A line"))
        object.__setattr__(self, "faces", _read_cells(faces, 3, len(rows), "A face"))

    @classmethod
    def polyline(cls, points: ArrayLike, *, closed: bool = False) -> Germ:
        """Return a germ of one polyline; a single point is a germ too."""
        rows = _read_rows(points)
        numbers = np.arange(len(rows))
        if closed:
            numbers = np.append(numbers, 0)
        return cls(rows, (numbers,) if len(numbers) > 1 else ())

    @classmethod
    def polylines(cls, several: Iterable[ArrayLike]) -> Germ:
        """Return a germ of several open polylines, such as the strokes of a letter."""
        strokes = [_read_rows(stroke) for stroke in several]
        if len({stroke.shape[1] for stroke in strokes}) != 1:
            raise InputError(
                "The polylines of a germ must all be in the plane or all in space, and at least "
                f"one; got points of {[stroke.shape[1] for stroke in strokes]} numbers."
            )
        ends = np.cumsum([len(stroke) for stroke in strokes])
        numbers = np.split(np.arange(ends[-1]), ends[:-1])
        return cls(np.vstack(strokes), tuple(line for line in numbers if len(line) > 1))

    @classmethod
    def polygon(cls, points: ArrayLike) -> Germ:
        """Return a germ of one face, such as the outline of a fish."""
        rows = _read_rows(points)
        return cls(rows, faces=(np.arange(len(rows)),))

    @classmethod
    def mesh(cls, vertices: ArrayLike, faces: Cells) -> Germ:
        """Return a germ of faces that share vertices."""
        return cls(vertices, faces=faces)

    @property
    def columns(self) -> int:
        """How many numbers a point has."""
        return int(self.points.shape[1])

    @cached_property
    def segments(self) -> IntArray:
        """(s, 2) numbers of the ends of all straight lines and face edges, each once."""
        pairs = [np.empty((0, 2), dtype=np.int64)]
        pairs += [np.stack([line[:, :-1], line[:, 1:]], axis=-1) for line in self.lines]
        pairs += [np.stack([face, np.roll(face, -1, axis=1)], axis=-1) for face in self.faces]
        ends = np.sort(np.concatenate([pair.reshape(-1, 2) for pair in pairs]), axis=1)
        return frozen(np.unique(ends, axis=0))

    def with_points(self, points: ArrayLike) -> Germ:
        """Return the germ with its points elsewhere, as many, with the same lines and faces."""
        rows = _read_rows(points)
        if len(rows) != len(self.points):
            raise InputError(f"The germ has {len(self.points)} points, got {len(rows)}.")
        return Germ(rows, self.lines, self.faces)

    def repeated(self, copies: FloatArray) -> Germ:
        """Return all copies as one germ.

        Parameters
        ----------
        copies : (n, g, c) float

        Returns
        -------
        Germ
            Point p of copy i is number i g + p; cells follow copy by copy.
        """
        count, size, columns = copies.shape
        shifts = size * np.arange(count)[:, None, None]
        lines, faces = (
            tuple((shifts + block).reshape(-1, block.shape[1]) for block in blocks)
            for blocks in (self.lines, self.faces)
        )
        return Germ(copies.reshape(-1, columns), lines, faces)

    def sampled(self, spacing: float) -> Germ:
        """Return bare points along the lines and the edges of the faces.

        Parameters
        ----------
        spacing : float
            Largest distance between neighbours, mm.

        Returns
        -------
        Germ
            The points of this germ first, then those between them.

        Raises
        ------
        InputError
            A spacing that is not positive.
        SizeError
            More points than fit in memory.
        """
        if not spacing > 0.0:
            raise InputError(f"The spacing must be positive, got {spacing!r}.")
        start, end = self.points[self.segments].swapaxes(0, 1)
        exact = np.linalg.norm(end - start, axis=1) / spacing
        needed = 4.0 * exact.itemsize * self.columns * float(exact.sum())
        if needed > MEMORY_LIMIT:
            raise SizeError(
                f"Points every {spacing:g} mm would take {needed / 2**30:.3g} GiB; the limit is "
                f"{MEMORY_LIMIT / 2**30:.3g} GiB. Take them further apart."
            )
        parts = np.maximum(np.ceil(exact), 1.0).astype(np.int64)
        number = np.repeat(np.arange(len(parts)), parts - 1)
        step = 1 + np.arange(len(number)) - np.repeat(np.cumsum(parts - 1) - parts + 1, parts - 1)
        share = (step / parts[number])[:, None]
        return Germ(np.vstack([self.points, (1 - share) * start[number] + share * end[number]]))

    def lengths(self, copies: FloatArray) -> FloatArray:
        """Return the (n,) lengths of all lines of each copy, mm.

        Parameters
        ----------
        copies : (n, g, d) float, mm
        """
        total = np.zeros(len(copies))
        for block in self.lines:
            total += np.linalg.norm(np.diff(copies[:, block], axis=2), axis=-1).sum(axis=(1, 2))
        return total

    def areas(self, copies: FloatArray) -> FloatArray:
        """Return the (n,) areas of all faces of each copy, mm2; faces are taken as planar.

        Parameters
        ----------
        copies : (n, g, d) float, mm
        """
        total = np.zeros(len(copies))
        for _, doubled in self._fans(copies):
            total += length(doubled.sum(axis=2)).sum(axis=1) / 2
        return total

    def volumes(self, copies: FloatArray) -> FloatArray:
        """Return the (n,) volumes within the faces of each copy, mm3.

        Parameters
        ----------
        copies : (n, g, 3) float, mm
            The faces must close each copy and agree about which side is out.
        """
        total = np.zeros(len(copies))
        for corner, doubled in self._fans(copies):
            total += dot(corner, doubled).sum(axis=(1, 2)) / 6
        return np.abs(total)

    def _fans(self, copies: FloatArray) -> Iterable[tuple[FloatArray, FloatArray]]:
        """Return a corner and the doubled vector area of all triangles, by size of face."""
        missing = 3 - copies.shape[-1]
        # About the first point of each copy: far from the origin, products lose digits.
        local = np.pad(copies - copies[:, :1], ((0, 0), (0, 0), (0, missing)))
        for block in self.faces:
            corners = local[:, block]
            arms = corners[:, :, 1:] - corners[:, :, :1]
            yield corners[:, :, :1], cross(arms[:, :, :-1], arms[:, :, 1:])


def _read_rows(value: ArrayLike) -> FloatArray:
    try:
        rows = np.array(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(
            "A germ needs points of as many numbers each; for several polylines take "
            "Germ.polylines."
        ) from error
    if rows.ndim != 2 or len(rows) == 0 or rows.shape[1] < 2:
        raise InputError(
            "A germ needs at least one point, and points of 2 or 3 numbers each (or one number "
            f"for each control point), got shape {rows.shape}."
        )
    if not np.isfinite(rows).all():
        bad = np.flatnonzero(~np.isfinite(rows).all(axis=1)).tolist()
        raise InputError(f"The points of a germ must be finite; rows {bad} are not.")
    return rows


def _read_cells(value: Cells, least: int, count: int, what: str) -> tuple[IntArray, ...]:
    """Read lines or faces, those of one size into one array."""
    blocks: dict[int, list[IntArray]] = {}
    for cell in [value] if isinstance(value, np.ndarray) and value.size else value:
        rows = np.atleast_2d(np.asarray(cell))
        whole = rows.ndim == 2 and rows.size > 0 and rows.dtype.kind in "iu"
        if not whole or rows.shape[1] < least:
            raise InputError(
                f"{what} must be at least {least} whole numbers of points, got {cell!r}."
            )
        if rows.min() < 0 or rows.max() >= count:
            raise InputError(
                f"{what} must use the points 0 to {count - 1}, got {rows.min()} to {rows.max()}."
            )
        blocks.setdefault(rows.shape[1], []).append(rows.astype(np.int64))
    return tuple(frozen(np.concatenate(rows)) for _, rows in sorted(blocks.items()))
