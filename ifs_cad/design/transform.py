"""Barycentric transformations and the constrained schemes that keep a curve in one piece.

With m control points P, a construction step replaces each piece by N smaller ones, P -> P T_k,
k = 1..N. Each T_k is an m x m matrix whose columns are barycentric: column j says how to mix the
control points of a piece into control point j of its k-th part. Columns sum to 1 unless weights
are in play.

Terms
-----
scheme : the general constrained scheme of the paper as data. Columns that must stay equal are one
    column in several places, so moving it can never tear the curve; columns that must not move
    are fixed.
ends : a and b, the fixed points of T_1 and T_N, where a curve starts and ends. In the
    interpolating case, the paper's, they are the first and the last control point.
joint : a curve is continuous when T_k b = T_{k+1} a for each k.

Source: the paper, section 3.1 (the two matrices, the general scheme, c = P^-1 s) and section 3.3
(continuity as a constraint).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np

from ifs_cad.design.reading import whole_number
from ifs_cad.errors import ContinuityError, InputError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import ArrayLike, BoolArray, FloatArray, IntArray, frozen, vector

LEAST_ROUGHNESS = -1 / 3

__all__ = ["Scheme"]


@dataclass(frozen=True, eq=False)
class Scheme:
    """N transformations of m control points, as columns and where they stand.

    Parameters
    ----------
    columns : (q, m) float
        The different columns, one a row.
    layout : (N, m) int
        Column j of T_k is ``columns[layout[k, j]]``.
    fixed : (q,) bool
        Columns that the designer cannot move.
    names : q str
        The subdivision points' names. The paper numbers the columns c_1, c_2, ... through T_1 to
        T_N; s_i is the projection of c_i, and a shared column bears its first number (its others
        are accepted too).
    tol : Tolerance

    Raises
    ------
    InputError
        Shapes that do not fit, or NaN.
    ContinuityError
        A scheme that tears the curve.
    """

    columns: FloatArray
    layout: IntArray
    fixed: BoolArray
    names: tuple[str, ...]
    tol: Tolerance = DEFAULT

    def __post_init__(self) -> None:
        columns = np.array(self.columns, dtype=float)
        layout = np.array(self.layout, dtype=np.int64)
        fixed = np.array(self.fixed, dtype=bool)
        if columns.ndim != 2 or layout.ndim != 2 or columns.shape[1] != layout.shape[1]:
            raise InputError(
                "A scheme needs columns of shape (q, m) and a layout of shape (N, m), got "
                f"{columns.shape} and {layout.shape}."
            )
        count, width = columns.shape
        if len(layout) < 2 or width < 2:
            raise InputError(
                "A scheme needs at least 2 transformations and 2 control points, got "
                f"{len(layout)} and {width}."
            )
        if fixed.shape != (count,) or len(self.names) != count:
            raise InputError(
                f"{count} columns need as many names and fixed flags, got {len(self.names)} and "
                f"{fixed.size}."
            )
        if layout.min() < 0 or layout.max() >= count:
            raise InputError(f"The layout must point at the columns 0..{count - 1}.")
        if not np.isfinite(columns).all():
            raise InputError("The columns of a scheme must be finite.")
        for name, value in (("columns", columns), ("layout", layout), ("fixed", fixed)):
            object.__setattr__(self, name, frozen(value))
        if not self.is_interpolating:
            self._require_continuity()

    @staticmethod
    def de_casteljau(control_points: int, transformations: int = 2) -> Scheme:
        """Return the scheme of a Bezier curve split at k/N.

        Entry i of column j of T_k is the coefficient of z^i in
        ``((1-u) + u z)^(d-j) ((1-v) + v z)^j`` with d = m-1, u = (k-1)/N, v = k/N (the blossom
        of the curve at d-j times u and j times v).

        Parameters
        ----------
        control_points : int
            m, at least 2.
        transformations : int
            N, at least 2.

        References
        ----------
        The paper, section 3.1: m = 3 and N = 2 give its two matrices.
        """
        return _de_casteljau(
            whole_number(control_points, "The number of control points", 2),
            whole_number(transformations, "The number of transformations", 2),
        )

    @classmethod
    def from_transformations(
        cls, transformations: ArrayLike, *, tol: Tolerance = DEFAULT
    ) -> Scheme:
        """Return the scheme of given matrices, joints shared and ends fixed where they agree.

        Parameters
        ----------
        transformations : (N, m, m) float
            T_1 to T_N; barycentric columns are ``T[k][:, j]``. Schemes that do not interpolate
            their control points (B-splines) are welcome.

        Raises
        ------
        InputError
            A wrong shape, or NaN.
        ContinuityError
            T_1 or T_N without a fixed point, or a joint that does not close.
        """
        matrices = np.array(transformations, dtype=float)
        if matrices.ndim != 3 or matrices.shape[1] != matrices.shape[2]:
            raise InputError(
                f"Transformations must have the shape (N, m, m), got {matrices.shape}."
            )
        if not np.isfinite(matrices).all():
            raise InputError("Transformations must be finite.")
        placed = matrices.swapaxes(1, 2)
        size = placed.shape[-1]
        joint = (np.abs(placed[:-1, -1] - placed[1:, 0]) <= tol.barycentric).all(axis=1)
        new = np.ones(placed.shape[:2], dtype=bool)
        new[1:, 0] = ~joint
        columns = placed[new]
        fixed = np.zeros(len(columns), dtype=bool)
        for place, unit in ((0, 0), (-1, size - 1)):
            end = np.eye(size)[unit]
            if (np.abs(columns[place] - end) <= tol.barycentric).all():
                columns[place], fixed[place] = end, True
        layout = new.ravel().cumsum().reshape(new.shape) - 1
        names = tuple(f"s{number + 1}" for number in np.flatnonzero(new))
        return cls(columns, layout, fixed, names, tol)

    @property
    def size(self) -> int:
        """Number m of control points."""
        return int(self.columns.shape[1])

    @property
    def count(self) -> int:
        """Number N of transformations."""
        return len(self.layout)

    @cached_property
    def transformations(self) -> FloatArray:
        """(N, m, m) matrices T_k; column j is ``T[k][:, j]``."""
        return frozen(np.ascontiguousarray(self.columns[self.layout].swapaxes(1, 2)))

    @cached_property
    def step(self) -> FloatArray:
        """(m, N m): T_1 to T_N side by side, one construction step in one product."""
        return frozen(np.ascontiguousarray(self.columns[self.layout.ravel()].T))

    def subdivided(self, pieces: FloatArray) -> FloatArray:
        """Return the pieces after one construction step.

        Parameters
        ----------
        pieces : (n, 4, m) float
            Control points of the pieces, homogeneous columns.

        Returns
        -------
        (n N, 4, m) float
            Part k of piece i is number i N + k.
        """
        parts = pieces.reshape(-1, self.size) @ self.step
        parts = parts.reshape(-1, 4, self.count, self.size).swapaxes(1, 2)
        return np.asarray(parts.reshape(-1, 4, self.size))

    @cached_property
    def is_interpolating(self) -> bool:
        """Whether the curve starts and ends at its control points with all joints shared."""
        first, last = self.columns[self.layout[0, 0]], self.columns[self.layout[-1, -1]]
        return bool(
            first[0] == 1.0
            and last[-1] == 1.0
            and not first[1:].any()
            and not last[:-1].any()
            and (self.layout[:-1, -1] == self.layout[1:, 0]).all()
        )

    @cached_property
    def ends(self) -> FloatArray:
        """(2, m): a and b, the barycentric places where the curve starts and ends."""
        if self.is_interpolating:
            return frozen(np.eye(self.size)[[0, -1]])
        size, matrices = self.size, self.transformations
        zero, unit = np.zeros((size, size)), np.eye(size)
        rows = [
            np.hstack([matrices[0] - unit, zero]),
            np.hstack([zero, matrices[-1] - unit]),
            *(np.hstack([-after, before]) for before, after in pairwise(matrices)),
            np.kron(np.eye(2), np.ones(size)),
        ]
        system = np.vstack(rows)
        wanted = np.zeros(len(system))
        wanted[-2:] = 1.0
        return frozen(np.linalg.lstsq(system, wanted)[0].reshape(2, size))

    def germ(self, columns: ArrayLike) -> FloatArray:
        """Read a germ: (g + 1, m) barycentric rows that run from a to b.

        Raises
        ------
        InputError
            A wrong shape, or NaN.
        ContinuityError
            Rows that start or end elsewhere, so that the elements would not meet.
        """
        germ = np.array(columns, dtype=float)
        if germ.ndim != 2 or len(germ) < 2 or germ.shape[1] != self.size:
            raise InputError(
                f"A germ needs at least 2 rows of {self.size} barycentric numbers, got shape "
                f"{germ.shape}."
            )
        if not np.isfinite(germ).all():
            raise InputError("A germ must be finite.")
        gap = float(np.abs(germ[[0, -1]] - self.ends).max())
        if gap > self.tol.barycentric:
            raise ContinuityError(
                f"A germ must run from a = {self.ends[0].tolist()} to b = "
                f"{self.ends[1].tolist()}; it is {gap:.3g} off.",
                gap=gap,
            )
        return frozen(germ)

    @property
    def free_names(self) -> tuple[str, ...]:
        """Names of the subdivision points that can be moved."""
        return tuple(name for name, fixed in zip(self.names, self.fixed, strict=True) if not fixed)

    def index(self, name: str) -> int:
        """Return the row of a subdivision point's column.

        Raises
        ------
        InputError
            An unknown name; the message lists those there are.
        """
        if name not in self._places:
            raise InputError(
                f"There is no subdivision point {name!r}; these can be moved: "
                f"{', '.join(self.free_names) or 'none'}."
            )
        return self._places[name]

    def free_index(self, name: str) -> int:
        """Return the row of a column that can be moved.

        Raises
        ------
        InputError
            An unknown name, or a fixed one; the message lists those that can be moved.
        """
        index = self.index(name)
        if self.fixed[index]:
            raise InputError(
                f"Subdivision point {name!r} is fixed: the curve begins or ends there (move the "
                f"control point). These can be moved: {', '.join(self.free_names) or 'none'}."
            )
        return index

    def with_column(self, name: str, column: ArrayLike) -> Scheme:
        """Return the scheme with one free column changed, wherever it stands.

        Parameters
        ----------
        name : str
        column : (m,) float, barycentric

        Raises
        ------
        InputError
            An unknown or fixed name, or a column of the wrong shape.
        ContinuityError
            A column that tears the curve; possible only when the scheme does not interpolate.
        """
        index = self.free_index(name)
        value = np.array(column, dtype=float)
        if value.shape != (self.size,):
            raise InputError(
                f"A column of this scheme has {self.size} entries, got shape {value.shape}."
            )
        columns = self.columns.copy()
        columns[index] = value
        return replace(self, columns=columns)

    def with_roughness(self, roughness: float) -> Scheme:
        """Return the scheme with its free columns that are not joints moved off their chords.

        With lin_j the column at share j/(m-1) between the first and the last column of T_k,
        ``c_j -> lin_j + (1 + 3 r) (c_j - lin_j)``.

        Parameters
        ----------
        roughness : float
            r, from -1/3 (columns on the chords) through 0 (nothing changes) to 1.

        Raises
        ------
        InputError
            Out of range, or a scheme of two control points, which has no such columns.
        """
        share = float(vector([roughness], "Roughness", 1)[0])
        if not LEAST_ROUGHNESS <= share <= 1.0:
            raise InputError(f"Roughness must be between -1/3 and 1, got {roughness!r}.")
        if self.size < 3:
            raise InputError(
                "A curve of two control points has only joints as subdivision points, nothing to "
                "make rougher; add a control point, or move the joints."
            )
        columns, inner = self.columns.copy(), self.layout[:, 1:-1]
        first, last = columns[self.layout[:, :1]], columns[self.layout[:, -1:]]
        along = np.arange(1, self.size - 1)[:, None] / (self.size - 1)
        detail = columns[inner] - ((1 - along) * first + along * last)
        columns[inner] += 3 * share * detail * ~self.fixed[inner][..., None]
        return replace(self, columns=columns)

    @cached_property
    def _places(self) -> dict[str, int]:
        numbered = {f"s{i + 1}": int(row) for i, row in enumerate(self.layout.ravel())}
        return numbered | {name: row for row, name in enumerate(self.names)}

    def _require_continuity(self) -> None:
        """Raise unless T_1 a = a, T_N b = b and T_k b = T_{k+1} a."""
        matrices, unit = self.transformations, np.eye(self.size)
        for number, end in ((1, matrices[0]), (self.count, matrices[-1])):
            if np.linalg.svd(end - unit, compute_uv=False)[-1] > self.tol.barycentric:
                raise ContinuityError(
                    f"T_{number} has no fixed point for the curve to "
                    f"{'start' if number == 1 else 'end'} at: it needs the eigenvalue 1."
                )
        a, b = self.ends
        gaps = {"a is not a fixed point of T_1": matrices[0] @ a - a}
        gaps[f"b is not a fixed point of T_{self.count}"] = matrices[-1] @ b - b
        for k in range(self.count - 1):
            joint = f"T_{k + 1} b and T_{k + 2} a are apart"
            gaps[joint] = matrices[k] @ b - matrices[k + 1] @ a
        worst = max(gaps, key=lambda what: float(np.abs(gaps[what]).max()))
        gap = float(np.abs(gaps[worst]).max())
        if gap > self.tol.barycentric or abs(a.sum() - 1) + abs(b.sum() - 1) > self.tol.barycentric:
            raise ContinuityError(
                f"These transformations tear the curve: {worst} (by {gap:.3g}, in barycentric "
                "coordinates). Continuity needs T_k b = T_k+1 a for each k, with a and b the fixed "
                f"points of T_1 and T_{self.count}.",
                gap=gap,
            )


@lru_cache(maxsize=64)
def _de_casteljau(size: int, count: int) -> Scheme:
    degree = size - 1
    columns = [
        np.convolve(_bernstein(degree - j, k / count), _bernstein(j, (k + 1) / count))
        for k in range(count)
        for j in range(min(k, 1), size)
    ]
    layout = degree * np.arange(count)[:, None] + np.arange(size)
    fixed = np.zeros(len(columns), dtype=bool)
    fixed[[0, -1]] = True
    numbers = [k * size + j + 1 for k in range(count) for j in range(min(k, 1), size)]
    return Scheme(np.array(columns), layout, fixed, tuple(f"s{number}" for number in numbers))


def _bernstein(degree: int, t: float) -> FloatArray:
    """Return the coefficients of ((1-t) + t z)^degree."""
    i = np.arange(degree + 1)
    binomials = np.array([math.comb(degree, k) for k in range(degree + 1)], dtype=float)
    return np.asarray(binomials * t**i * (1.0 - t) ** (degree - i))
