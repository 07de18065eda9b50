"""Figures: K_{n+1} = union of T_i K_n, for any affine maps and any germ.

The transformations make the figure; the germ K is only what each element looks like. After n
construction steps there are N^n elements P T_i1 ... T_in K, one for each word i1 ... in, in the
order of their addresses. When the maps contract, K_n tends to the attractor whatever the germ.

The words coordinates, projection and contraction are those of `ifs_cad.design.system`.

Source: the paper, section 2 (Hutchinson's operator, attractor, germ; figures 2 to 4) and section
3.1 (barycentric transformations, P, construction tree).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ifs_cad.design.address import is_dotted
from ifs_cad.design.affine import Placements, is_homogeneous, read_affine
from ifs_cad.design.curve import DEEPEST, Curve
from ifs_cad.design.germ import Germ
from ifs_cad.design.reach import solve_columns
from ifs_cad.design.reading import read_points
from ifs_cad.design.size import require_memory
from ifs_cad.design.system import System, require_sums_of_one
from ifs_cad.design.tree import read_word
from ifs_cad.errors import InputError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import ArrayLike, FloatArray

__all__ = ["Figure"]


@dataclass(frozen=True, eq=False, init=False)
class Figure(System):
    """Transformations with a germ, to be seen at any number of construction steps.

    Nothing is computed before it is asked for, and what would not fit in memory is refused then.
    Maps that do not contract have construction steps too, but no attractor.

    Parameters
    ----------
    maps, projection
        As for `System`: affine maps of the plane or of space, or barycentric maps on control
        points, which are the columns of the projection P.
    germ : Germ or (g, c) array, optional
        In coordinates: points that affine maps act on, or barycentric rows. An array is an open
        polyline. By default the unit segment of the x axis, or the chord from the first control
        point to the last. See `with_germ` for points in space.
    name : str, optional
    tol : Tolerance, optional

    Raises
    ------
    InputError
        NaN or infinite numbers, or shapes that do not fit each other.

    References
    ----------
    The paper, sections 2.3 and 3.1.
    """

    germ: Germ
    name: str

    def __init__(
        self,
        maps: ArrayLike,
        projection: ArrayLike | None = None,
        germ: Germ | ArrayLike | None = None,
        *,
        name: str = "",
        tol: Tolerance = DEFAULT,
    ) -> None:
        super().__init__(maps, projection, tol=tol)
        object.__setattr__(self, "germ", _read_germ(germ, self.maps))
        object.__setattr__(self, "name", name)
        if not (self.is_affine or self.is_weighted):
            require_sums_of_one(self.germ.points.sum(axis=1), "rows of the germ", tol)

    @classmethod
    def from_curve(cls, curve: Curve) -> Figure:
        """Return a curve as a figure, with its germ; `polyline` at its depth gives its points.

        Raises
        ------
        InputError
            A curve with an even fold, which is no transformation.
        """
        if curve.fold is not None:
            raise InputError(
                "An even fold is no transformation, so a folded curve is no figure. Take the "
                "curve without its fold."
            )
        projection, maps = curve.projection, curve.scheme.transformations
        weights = projection[0]
        sums = np.concatenate([maps.sum(axis=1).ravel(), curve.germ_columns.sum(axis=1)])
        if np.ptp(weights) == 0.0 and np.abs(sums - 1.0).max() <= curve.tol.barycentric:
            projection = projection[1:] / weights
        return cls(maps, projection, curve.germ_columns, tol=curve.tol)

    @cached_property
    def coordinates(self) -> FloatArray:
        """(g, k) coordinates of the germ."""
        points = self.germ.points
        return np.column_stack([points, np.ones(len(points))]) if self.is_affine else points

    def step(self, germ: Germ | None = None) -> Germ:
        """Return one construction step, the union of T_i K.

        Parameters
        ----------
        germ : Germ, optional
            K in coordinates; the figure's own by default. What comes back can be a germ again:
            this is Hutchinson's operator.

        Returns
        -------
        Germ
            Not yet projected; copy i is that of T_i.

        References
        ----------
        The paper, section 2.3.
        """
        start = self if germ is None else replace(self, germ=germ)
        copies = start.coordinates @ self.maps.swapaxes(1, 2)
        return start.germ.repeated(copies[..., : start.germ.columns])

    def at_depth(self, depth: int, prefix: str | Sequence[int] = ()) -> FloatArray:
        """Return the points of K_n, element by element.

        Parameters
        ----------
        depth : int
            Number n of construction steps.
        prefix : str or sequence of int
            Only the elements whose addresses begin so.

        Returns
        -------
        (N^n, g, d) float, mm
            In the order of `addresses`.

        Raises
        ------
        InputError
            A depth that is not a whole number from 0.
        AddressError
            A prefix that no element has.
        SizeError
            More points than fit in memory; refused before any is computed.
        WeightError
            A weight that is not positive.

        References
        ----------
        The paper, section 3.1, equations for PK_n.
        """
        word = self._prefix(depth, prefix)
        widest = max(self.maps.shape[-1], len(self._view))
        self._require_memory(depth, widest * len(self.coordinates), len(word))
        rows, steps = self.coordinates, depth - len(word)
        for _ in range(steps - 1):
            rows = (rows @ self.maps.swapaxes(1, 2)).reshape(-1, rows.shape[1])
        last = self._view
        for digit in word:
            last = last @ self.maps[digit]
        # The last step and the projection are one product.
        last = last @ self.maps if steps else last[None]
        points = self._divided(rows @ last.swapaxes(1, 2))
        return np.asarray(points.reshape(-1, len(self.coordinates), self.ndim))

    def construction(self, depth: int, prefix: str | Sequence[int] = ()) -> Germ:
        """Return K_n with its lines and faces; see `at_depth`."""
        return self.germ.repeated(self.at_depth(depth, prefix))

    def at(self, word: str | Sequence[int]) -> FloatArray:
        """Return the (g, d) points of the element with a word of any length, mm.

        Raises
        ------
        AddressError
            A digit that no transformation has.
        """
        digits = read_word(word, self.count, DEEPEST)
        return np.asarray(self.at_depth(len(digits), digits)[0])

    def polyline(self, depth: int) -> FloatArray:
        """Return the elements strung together in the order of their addresses.

        Points where an element starts as the one before it ends are kept once. This is the curve
        of figures that are curves; one whose germ is a single point becomes the line through all.

        Returns
        -------
        (n, d) float, mm

        Raises
        ------
        InputError
            A germ that is not one polyline or one point.
        """
        size = len(self.germ.points)
        whole = [block.tolist() for block in self.germ.lines] == [[list(range(size))]]
        if self.germ.faces or not (whole or size == 1):
            raise InputError(
                "Only a germ of one polyline or one point can be strung together; this one has "
                f"{size} points and {len(self.germ.segments)} segments."
            )
        copies = self.at_depth(depth)
        keep = np.ones(copies.shape[:2], dtype=bool)
        if size > 1:
            gaps = np.abs(copies[1:, 0] - copies[:-1, -1]).max(axis=1)
            keep[1:, 0] = gaps > self.tol.coincident
        return np.asarray(copies[keep])

    def refined(self, largest: float) -> Placements:
        """Return the composed maps of elements that are all small, whatever their depths.

        Each element is replaced by its N parts until it cannot be larger than wanted: where maps
        are unequal, some words are longer than others.

        Parameters
        ----------
        largest : float
            Largest extent of an element, mm: the diagonal of the germ's box times the stretch.

        Raises
        ------
        InputError
            A size that is not positive.
        ContractionError
            Maps that do not contract.
        SizeError
            More elements than fit in memory.
        """
        if not largest > 0.0:
            raise InputError(f"The largest extent must be positive, got {largest!r}.")
        self.require_contracting()
        maps, count = self.space_maps, self.count
        extent = float(np.linalg.norm(np.ptp(self.at_depth(0)[0], axis=0)))
        matrices, words, sizes = np.eye(maps.shape[-1])[None], np.array([""]), np.array([extent])
        digits = np.array([str(digit) for digit in range(count)])
        following = np.strings.add(".", digits) if is_dotted((count,)) else digits
        while (large := sizes > largest).any():
            parts = np.where(large, count, 1)
            require_memory(int(parts.sum()), 1, 4 * matrices[0].nbytes)
            parent = np.repeat(np.arange(len(parts)), parts)
            place = np.arange(len(parent)) - np.repeat(np.cumsum(parts) - parts, parts)
            split = large[parent]
            longer = np.strings.add(words[parent[split]], digits[place[split]])
            matrices, sizes, words = matrices[parent], sizes[parent], words[parent]
            matrices[split] = matrices[split] @ maps[place[split]]
            stretches = np.linalg.norm(matrices[split, :-1, :-1], ord=2, axis=(1, 2))
            sizes[split] = extent * stretches
            words = words.astype(longer.dtype)
            words[split] = longer
            digits = following
        addresses = words.tolist() if words[0] else ["0"]
        return Placements(matrices, tuple(addresses), self.tol)

    def with_germ(self, germ: Germ | ArrayLike) -> Figure:
        """Return the figure with another germ.

        Parameters
        ----------
        germ : Germ or (g, 2) or (g, 3) array, mm
            In the plane or space of the maps, an array as an open polyline. On control points each
            point takes its barycentric coordinates, those of least change from the centroid.

        Raises
        ------
        OutOfReachError
            A point off the affine hull of the control points.
        """
        germ = germ if isinstance(germ, Germ) else Germ.polyline(germ)
        if self.is_affine:
            return replace(self, germ=germ)
        view, points = self._view, read_points(germ.points, "The points of a germ")
        size = view.shape[1]
        if not self.is_weighted:
            view = np.vstack([np.ones(size), view, np.zeros((3 - len(view), size))])
        middle = np.full((len(points), size), 1.0 / size)
        columns = solve_columns(view, middle, points, middle @ view[0], tol=self.tol)
        return replace(self, germ=Germ(columns, germ.lines, germ.faces))

    def transformed(self, matrix: ArrayLike) -> Figure:
        """Return the figure moved, turned or stretched as a whole, with its germ.

        Parameters
        ----------
        matrix : (d, d + 1) or (d + 1, d + 1) array
            An affine map of the plane or space that the figure is seen in.

        Raises
        ------
        InputError
            A wrong shape, NaN, or a matrix that cannot be undone.
        """
        change = read_affine(matrix, self.ndim, tol=self.tol)
        if self.projection is None:
            maps = change @ self.maps @ np.linalg.inv(change)
            points = (self.coordinates @ change.T)[:, :-1]
            return replace(self, maps=maps, germ=self.germ.with_points(points))
        linear, move = change[:-1, :-1], change[:-1, -1:]
        if self.is_weighted:
            weights, scaled = self.projection[:1], self.projection[1:]
            moved = np.vstack([weights, linear @ scaled + move * weights])
        else:
            moved = linear @ self.projection + move * self.unit
        return replace(self, projection=moved)

    def scaled(self, factor: float) -> Figure:
        """Return the figure larger or smaller by a factor, about the origin."""
        return self.transformed(np.eye(self.ndim, self.ndim + 1) * factor)


def _read_germ(value: Germ | ArrayLike | None, maps: FloatArray) -> Germ:
    """Read the germ of maps of k coordinates, which are points or barycentric."""
    size, affine = maps.shape[-1], is_homogeneous(maps)
    if value is None:
        ends = np.eye(size - affine)
        value = np.vstack([0.0 * ends[0], ends[0]]) if affine else ends[[0, -1]]
    germ = value if isinstance(value, Germ) else Germ.polyline(value)
    wanted = size - 1 if affine else size
    if affine and (germ.columns, wanted) == (2, 3):
        germ = replace(germ, points=np.column_stack([germ.points, np.zeros(len(germ.points))]))
    if germ.columns != wanted:
        kind = "points of" if affine else "barycentric rows on"
        raise InputError(
            f"These transformations need a germ of {kind} {wanted} "
            f"{'numbers each' if affine else 'control points'}, got {germ.columns} columns."
        )
    return germ
