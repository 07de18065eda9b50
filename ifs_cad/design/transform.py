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

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Literal

import numpy as np

from ifs_cad.design.blossom import bezier_columns
from ifs_cad.design.continuity import fixed_ends, read_germ, require_continuity
from ifs_cad.design.reading import whole_number
from ifs_cad.design.symmetry import partners, require_symmetry, symmetric_columns
from ifs_cad.errors import InputError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import ArrayLike, BoolArray, FloatArray, IntArray, frozen, vector

LEAST_ROUGHNESS = -1 / 3

Kind = Literal["fixed", "shared", "free"]

__all__ = ["Kind", "Scheme"]


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
    symmetric : bool
        Tie mirror images together: T_{N+1-k} = J T_k J, and moving one column moves the other.

    Raises
    ------
    InputError
        Shapes that do not fit, NaN, names that repeat, or mirror images that differ.
    ContinuityError
        A scheme that tears the curve.
    """

    columns: FloatArray
    layout: IntArray
    fixed: BoolArray
    names: tuple[str, ...]
    tol: Tolerance = DEFAULT
    symmetric: bool = False

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
        if len(set(self.names)) < count:
            raise InputError(f"Every column needs a name of its own, got {', '.join(self.names)}.")
        if self.symmetric:
            partner = partners(layout, fixed)
            require_symmetry(columns, partner, self.names, self.tol)
            columns = (columns + columns[partner, ::-1]) / 2
        for name, value in (("columns", columns), ("layout", layout), ("fixed", fixed)):
            object.__setattr__(self, name, frozen(value))
        if not self.is_interpolating:
            require_continuity(self.transformations, self.ends, self.tol)

    @staticmethod
    def de_casteljau(control_points: int, transformations: int = 2) -> Scheme:
        """Return the scheme of a Bezier curve split at k/N.

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
        return frozen(fixed_ends(self.transformations))

    def germ(self, columns: ArrayLike) -> FloatArray:
        """Read a germ: (g + 1, m) barycentric rows that run from a to b.

        Raises
        ------
        InputError
            A wrong shape, or NaN.
        ContinuityError
            Rows that start or end elsewhere, so that the elements would not meet.
        """
        return read_germ(columns, self.ends, self.tol)

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

    def kinds(self) -> dict[str, Kind]:
        """Return what each column may do, by name, in the paper's order.

        ``fixed`` columns cannot move, ``shared`` ones move in several transformations at once,
        ``free`` ones in one. See `handle.handles` for the whole table.
        """
        places = np.bincount(self.layout.ravel(), minlength=len(self.columns))
        return {
            name: "fixed" if fixed else "shared" if count > 1 else "free"
            for name, fixed, count in zip(self.names, self.fixed, places, strict=True)
        }

    def partner(self, name: str) -> str | None:
        """Return the name of a column's mirror image in a symmetric scheme; it may be its own."""
        return self.names[self._partners[self.index(name)]] if self.symmetric else None

    def span(self, name: str) -> FloatArray | None:
        """Return orthonormal columns that span what a column may be; None for all columns.

        In a symmetric scheme a column that is its own mirror image must read alike backwards.
        """
        return symmetric_columns(self.size) if self.partner(name) == name else None

    def with_names(self, names: Mapping[str, str]) -> Scheme:
        """Return the scheme with other names of some subdivision points, for the studio's handles.

        Parameters
        ----------
        names : mapping from present to new names
            The paper's numbers go on being understood.
        """
        changed = list(self.names)
        for present, name in names.items():
            changed[self.index(present)] = name
        return replace(self, names=tuple(changed))

    def with_symmetry(self) -> Scheme:
        """Return the symmetric scheme of the means of all columns and their mirror images.

        Raises
        ------
        InputError
            A layout in which columns are shared, or fixed, otherwise from the two ends.
        ContinuityError
            Means that tear the curve; possible only when the scheme does not interpolate.
        """
        mirrored = self.columns[self._partners, ::-1]
        return replace(self, columns=(self.columns + mirrored) / 2, symmetric=True)

    def with_column(self, name: str, column: ArrayLike) -> Scheme:
        """Return the scheme with one free column changed, wherever it stands.

        In a symmetric scheme its mirror image changes too.

        Parameters
        ----------
        name : str
        column : (m,) float, barycentric

        Raises
        ------
        InputError
            An unknown or fixed name, a column of the wrong shape, or one that is its own mirror
            image in a symmetric scheme and does not read alike backwards.
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
        if self.symmetric:
            columns[self._partners[index]] = value[::-1]
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
    def _partners(self) -> IntArray:
        return partners(self.layout, self.fixed)

    @cached_property
    def _places(self) -> dict[str, int]:
        numbered = {f"s{i + 1}": int(row) for i, row in enumerate(self.layout.ravel())}
        return numbered | {name: row for row, name in enumerate(self.names)}


@lru_cache(maxsize=64)
def _de_casteljau(size: int, count: int) -> Scheme:
    columns = bezier_columns(size, count)
    layout = (size - 1) * np.arange(count)[:, None] + np.arange(size)
    fixed = np.zeros(len(columns), dtype=bool)
    fixed[[0, -1]] = True
    numbers = [k * size + j + 1 for k in range(count) for j in range(min(k, 1), size)]
    return Scheme(columns, layout, fixed, tuple(f"s{number}" for number in numbers))
