"""Discrete curves from control points, subdivision points and an iteration depth.

A curve is P T_i1 T_i2 ... T_in K over all words i1 i2 ... in of length n, the iteration depth. It
is computed by pieces: the control points of a piece times T_k are those of its k-th part, and the
germ is laid into the last pieces. Points are homogeneous, (w, xw, yw, zw), and divided by w at
the end.

Terms
-----
control point p : moves the shape as a whole; numbered from 0 in code.
subdivision point s : shows a free column c of the transformations as s = P c; moves the local
    aspect, smooth or rough. Named s2, s3, ... as the paper numbers the columns.
germ K : the polyline that each piece becomes; the chord unless given.
element : P T_w K for one word w.
segment : one straight line of the finished curve.

Source: the paper, section 3.1 (equations for PK_n, figures 6 to 10) and section 3.4 (weights of
control and subdivision points).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from operator import index

import numpy as np

from ifs_cad.design.address import Structure, curve_addresses
from ifs_cad.design.continuity import require_closing
from ifs_cad.design.contraction import Contraction, contraction, diameter_contraction
from ifs_cad.design.fold import EvenFold
from ifs_cad.design.iteration import Iteration, projected
from ifs_cad.design.reach import germ_through, subdivision_point, with_subdivision_point
from ifs_cad.design.reading import read_points, read_weights, whole_number
from ifs_cad.design.transform import Scheme
from ifs_cad.errors import InputError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import ArrayLike, FloatArray, frozen, vector

DEEPEST = 1000  # a word of two-map digits below which floating-point numbers have no smaller part

__all__ = ["Curve"]


@dataclass(frozen=True, eq=False, init=False)
class Curve:
    """A discrete curve in the plane or in space.

    Nothing is computed before it is asked for, and what would not fit in memory is refused then.

    Parameters
    ----------
    control_points : (m, 2) or (m, 3) array, mm
        At least two; points in the plane get z = 0.
    depth : int
        Number of construction steps; the curve has N^depth elements.
    weights : (m,) array, optional
        Positive weights of the control points, 1 by default.
    transformations : int
        N; the de Casteljau scheme split at k/N, a Bezier curve until a subdivision point moves.
    closed : bool
        Come back to the start: the first control point is repeated, with its weight, at the end;
        with a scheme for more control points, as many of the first as it needs.
    scheme : Scheme, optional
        Instead of `transformations`.
    germ : (g + 1, m) array, optional
        Barycentric rows from a to b; the chord by default. See `with_germ` for points in space.
    fold : EvenFold, optional
        A last construction step. See `with_even_fold`.
    tol : Tolerance

    Raises
    ------
    InputError
        NaN or infinite points, a wrong shape, too few points, all points in one place.
    WeightError
        Weights that are not positive and finite.
    ContinuityError
        A germ that does not run from a to b.
    """

    control_points: FloatArray
    weights: FloatArray
    depth: int
    closed: bool
    scheme: Scheme
    germ: FloatArray | None
    fold: EvenFold | None
    tol: Tolerance

    def __init__(
        self,
        control_points: ArrayLike,
        *,
        depth: int = 4,
        weights: ArrayLike | None = None,
        transformations: int = 2,
        closed: bool = False,
        scheme: Scheme | None = None,
        germ: ArrayLike | None = None,
        fold: EvenFold | None = None,
        tol: Tolerance = DEFAULT,
    ) -> None:
        points = read_points(control_points, "Control points")
        if len(points) < 2:
            raise InputError(f"A curve needs at least 2 control points, got {len(points)}.")
        if np.abs(points - points[0]).max() <= tol.coincident:
            raise InputError(f"All {len(points)} control points are at {points[0].tolist()}.")
        if closed and np.abs(points[-1] - points[0]).max() <= tol.coincident:
            raise InputError(
                "closed=True repeats the first control point by itself; leave out the last one."
            )
        if scheme is None:
            scheme = Scheme.de_casteljau(len(points) + bool(closed), transformations)
        if closed:
            require_closing(scheme.ends, len(points), scheme.tol)
        elif scheme.size != len(points):
            raise InputError(
                f"The scheme is made for {scheme.size} control points, the curve has {len(points)}."
            )
        values = {
            "control_points": frozen(points),
            "weights": frozen(read_weights(weights, len(points))),
            "depth": whole_number(depth, "The iteration depth", 0, DEEPEST),
            "closed": bool(closed),
            "scheme": scheme,
            "germ": None if germ is None else scheme.germ(germ),
            "fold": fold,
            "tol": tol,
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @cached_property
    def projection(self) -> FloatArray:
        """(4, m) P: homogeneous control points as columns, the first repeated when closed."""
        matrix = np.vstack([self.weights, self.weights * self.control_points.T])
        return frozen(matrix[:, np.arange(self.scheme.size) % len(self.weights)])

    @cached_property
    def germ_columns(self) -> FloatArray:
        """(g + 1, m) barycentric rows of the germ K."""
        return self.scheme.ends if self.germ is None else self.germ

    @property
    def word_structure(self) -> Structure:
        """Radices of a segment's digits: those of the construction steps, and those after them.

        The steps are N, depth times. A germ of several segments and the halves of a fold come
        after them; the fold of a chord germ counts as a construction step.
        """
        return self._iteration.structure

    @property
    def segments(self) -> int:
        """Number of segments, known without computing them."""
        return math.prod(self._iteration.radices)

    @cached_property
    def addresses(self) -> list[str]:
        """The address of each segment, in order; SizeError when they would not fit in memory."""
        self._iteration.require_memory()
        return curve_addresses(*self.word_structure)

    @property
    def homogeneous(self) -> FloatArray:
        """(n + 1, 4) points of the curve, rows (w, xw, yw, zw).

        Raises
        ------
        SizeError
            More points than fit in memory; refused before any is computed.
        WeightError
            A weight along the curve is not positive.
        FoldError
            The even fold is not steep enough, or the curve cannot be folded.
        DegenerateSegmentError
            Consecutive points coincide.
        """
        return self._rows_and_points[0]

    @property
    def points(self) -> FloatArray:
        """(n + 1, 3) points of the curve, mm. Raises what `homogeneous` raises."""
        return self._rows_and_points[1]

    @cached_property
    def _rows_and_points(self) -> tuple[FloatArray, FloatArray]:
        rows = self._iteration.points()
        if self.is_closed:
            rows[-1] = rows[0]
        points = projected(rows)
        self._iteration.require_lengths(points)
        return frozen(rows), frozen(points)

    @cached_property
    def is_closed(self) -> bool:
        """Whether the curve ends where it starts, P a = P b, in position and in weight."""
        if self.closed:
            return True
        (first, *start), (last, *end) = (self.projection @ self.scheme.ends.T).T
        apart = np.abs(np.array(start) / first - np.array(end) / last).max()
        return bool(apart <= self.tol.coincident and abs(last - first) <= self.tol.rank * first)

    @property
    def subdivision_points(self) -> dict[str, FloatArray]:
        """The (3,) points s = P c of all free columns, mm, by name.

        Raises
        ------
        WeightError
            A subdivision point whose weight has vanished.
        """
        return {name: point for name, (_, point) in self._subdivisions()}

    @property
    def subdivision_weights(self) -> dict[str, float]:
        """The weights of the subdivision points, by name."""
        return {name: weight for name, (weight, _) in self._subdivisions()}

    def at(self, word: str | Sequence[int]) -> FloatArray:
        """Return the points of one element, or of any part, without computing the rest.

        Parameters
        ----------
        word : str or sequence of int
            Digits, coarsest first. All digits of the construction steps give one element, fewer
            give the part of the curve with that prefix, more pick a segment of the element.

        Returns
        -------
        (k + 1, 3) float, mm
            The same points as in `points`.

        Raises
        ------
        AddressError
            Too many digits, or a digit that no transformation has.
        """
        return projected(self.homogeneous_at(word))

    def homogeneous_at(self, word: str | Sequence[int]) -> FloatArray:
        """Return the (k + 1, 4) homogeneous points of one element or part; see `at`."""
        return self._iteration.points(self._iteration.digits(word))

    def gaps(self) -> FloatArray:
        """Return the distances, mm, between each element's end and the next one's start.

        They are zero but for rounding, since schemes that tear are refused.
        """
        return self._iteration.gaps()

    def contraction(self, length: int | None = None) -> Contraction:
        """Report whether the pieces shrink from step to step.

        Without weights the products of transformations tell (`contraction.contraction`), with
        weights the diameters of the pieces (`contraction.diameter_contraction`), both over words
        of a given length.
        """
        sums = self.scheme.columns.sum(axis=1)
        weighted = np.ptp(self.weights) > 0.0 or np.abs(sums - 1).max() > self.tol.barycentric
        if weighted:
            return diameter_contraction(self.scheme, self.projection, length, tol=self.tol)
        return contraction(self.scheme, length, tol=self.tol)

    def with_depth(self, depth: int) -> Curve:
        """Return the curve at another iteration depth."""
        return replace(self, depth=depth)

    def with_weights(self, weights: ArrayLike | None) -> Curve:
        """Return the curve with other weights of its control points (all 1 when None)."""
        return replace(self, weights=weights)  # type: ignore[arg-type]

    def with_control_point(
        self, number: int, point: ArrayLike, weight: float | None = None
    ) -> Curve:
        """Return the curve with one control point moved.

        Subdivision points follow, since their barycentric columns stay.

        Parameters
        ----------
        number : int
            From 0, or from the end with -1.
        point : (2,) or (3,) floats, mm
        weight : float, optional
            Its present weight by default.
        """
        count = len(self.control_points)
        if not -count <= index(number) < count:
            raise InputError(f"There are control points 0 to {count - 1}, none {number}.")
        points, weights = self.control_points.copy(), self.weights.copy()
        points[number] = read_points([point], "A control point")[0]
        if weight is not None:
            weights[number] = weight
        return replace(self, control_points=points, weights=weights)

    def with_subdivision_point(
        self,
        name: str,
        point: ArrayLike | None = None,
        weight: float | None = None,
        *,
        project: bool = False,
    ) -> Curve:
        """Return the curve with one subdivision point moved, its weight changed, or both.

        The column takes the least change that puts the point there: c + pinv(P) (s - P c).

        Parameters
        ----------
        name : str
            ``s2``, ``s3``, ...; a shared column moves wherever it stands, and in a symmetric
            scheme its mirror image moves with it.
        point : (2,) or (3,) floats, mm, optional
            Its present place by default.
        weight : float, optional
            Its present weight by default.
        project : bool
            Take the nearest point on the affine hull of the control points, in Euclidean space.

        Raises
        ------
        InputError
            An unknown or fixed name; the message lists those that can be moved.
        OutOfReachError
            A point off the affine hull of the control points, unless `project`.
        WeightError
            A weight that is not positive.
        ContinuityError
            A point that tears the curve; possible only when the scheme does not interpolate.

        References
        ----------
        The paper, section 3.1, figures 8 and 9.
        """
        scheme = with_subdivision_point(
            self.scheme, self.projection, name, point, weight, project=project, tol=self.tol
        )
        return replace(self, scheme=scheme)

    def with_scheme(self, scheme: Scheme) -> Curve:
        """Return the curve of the same control points by other transformations.

        `subdivision.SubdivisionSets` goes from one scheme to another by a single number.
        """
        return replace(self, scheme=scheme)

    def with_symmetry(self) -> Curve:
        """Return the curve with each subdivision point tied to its mirror image.

        From then on moving one moves the other. Over control points that are symmetric in space
        the curve is symmetric. See `Scheme.with_symmetry`, also for what it raises.
        """
        return replace(self, scheme=self.scheme.with_symmetry())

    def with_roughness(self, roughness: float) -> Curve:
        """Return the curve rougher or smoother, by moving subdivision points off their chords.

        See `Scheme.with_roughness`. With three control points and two transformations, detail
        shrinks by (1 + 3 r)/4 from step to step instead of 1/4: r = 0 leaves a smooth Bezier
        curve, r = 1/3 makes the profile of Takagi (halving), towards r = 1 the curve contracts no
        more. It acts on the curve as it is, so factors multiply: r, then q, is (1 + 3 r)(1 + 3 q).

        Parameters
        ----------
        roughness : float
            r, from -1/3 to 1.

        Raises
        ------
        InputError
            Out of range, or a curve of two control points, which has no such points.

        References
        ----------
        The paper, section 3.2.1, figure 10.
        """
        return replace(self, scheme=self.scheme.with_roughness(roughness))

    def with_germ(self, points: ArrayLike) -> Curve:
        """Return the curve with a polyline instead of the chord in each of its pieces.

        Parameters
        ----------
        points : (g + 1, 2) or (g + 1, 3) array, mm
            From the start to the end of the curve. Each point takes the barycentric column of
            least change from the evenly spaced point of the chord, and that point's weight.

        Raises
        ------
        ContinuityError
            A polyline that does not run from the start to the end of the curve.
        OutOfReachError
            A point off the affine hull of the control points.
        """
        polyline = read_points(points, "A germ")
        if len(polyline) < 2:
            raise InputError(f"A germ needs at least 2 points, got {len(polyline)}.")
        germ = germ_through(self.projection, self.scheme.ends, polyline, tol=self.tol)
        return replace(self, germ=germ)

    def with_even_fold(self, slope: float, up: ArrayLike = (0.0, 0.0, 1.0)) -> Curve:
        """Return the curve with an even fold as its last construction step.

        Each segment is split in two of the slopes `slope` and -`slope` against `up`.

        Parameters
        ----------
        slope : float
            Rise over run; negative begins with a valley.
        up : (3,) floats

        Raises
        ------
        FoldError
            A curve that is not in a plane containing `up`, runs back, or is as steep as the fold;
            names the segments and the least slope that works.
        """
        x, y, z = vector(up, "The up direction of an even fold").tolist()
        folded = replace(self, fold=EvenFold(slope, (x, y, z)))
        _ = folded.homogeneous  # so that a fold that cannot be made fails here, not later
        return folded

    @cached_property
    def _iteration(self) -> Iteration:
        return Iteration(
            self.projection, self.scheme, self.depth, self.germ_columns, self.fold, self.tol
        )

    def _subdivisions(self) -> Iterator[tuple[str, tuple[float, FloatArray]]]:
        for name in self.scheme.free_names:
            yield name, subdivision_point(self.scheme, self.projection, name, tol=self.tol)
