"""The transformations of a triangular patch, and which of their columns may move.

The control points of a patch of degree d form a triangular net. A construction step makes four
patches of one: at the corners A, B and C, and the middle one, turned by half a turn. The columns
of T_1 to T_4 are the blossom of the patch at the corners of the four, the triangular scheme of
de Casteljau; columns of one value are one column, shared.

A mesh of such patches stays connected, at any depth, when

- columns on a common edge of two of the four are shared;
- what becomes of an edge depends on the control points of that edge alone: the columns on the
  sides AB, BC and CA mix the control points of their side only;
- and is the same from both ends, since neighbours run along their common edge in opposite
  senses: each side has a symmetric scheme of its own (`ifs_cad.design.symmetry`).

All else is free: on each side the inner columns, each tied to its mirror image, and all columns
inside.

Source: the paper, section 3.3 (regular triangular faces), with the constrained schemes of 3.1;
de Casteljau's triangular scheme in Farin, Curves and Surfaces for CAGD.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from ifs_cad.design.reading import whole_number
from ifs_cad.design.symmetry import symmetric_columns
from ifs_cad.design.transform import LEAST_ROUGHNESS, Kind
from ifs_cad.errors import ContinuityError, InputError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import ArrayLike, BoolArray, FloatArray, IntArray, frozen, vector

SIDES = ("AB", "BC", "CA")
INSIDE = -1

# Twice the corners of the four parts, in shares of A, B and C.
PARTS = np.array(
    [
        [[2, 0, 0], [1, 1, 0], [1, 0, 1]],
        [[1, 1, 0], [0, 2, 0], [0, 1, 1]],
        [[1, 0, 1], [0, 1, 1], [0, 0, 2]],
        [[0, 1, 1], [1, 0, 1], [1, 1, 0]],
    ]
)

__all__ = [
    "PARTS",
    "SIDES",
    "TriangleScheme",
    "corner_numbers",
    "net",
    "net_number",
    "side_numbers",
]


def net(degree: int) -> IntArray:
    """Return ((d+1)(d+2)/2, 3) ints: the shares of A, B, C of the points of a triangular net.

    Row by row from A: the first row is A alone, the last runs from B to C.
    """
    return np.array(
        [
            (degree - row, row - place, place)
            for row in range(degree + 1)
            for place in range(row + 1)
        ]
    )


def net_number(shares: IntArray) -> IntArray:
    """Return the numbers of net points, given their (..., 3) shares."""
    row = shares[..., 1] + shares[..., 2]
    return np.asarray(row * (row + 1) // 2 + shares[..., 2])


def corner_numbers(degree: int) -> IntArray:
    """Return (3,) numbers of the net points A, B and C."""
    return net_number(degree * np.eye(3, dtype=np.int64))


def side_numbers(degree: int, side: str) -> IntArray:
    """Return (d + 1,) numbers of the net points along a side, from its first corner.

    Raises
    ------
    InputError
        A side other than AB, BC and CA.
    """
    if side not in SIDES:
        raise InputError(f"The sides of a patch are {', '.join(SIDES)}, got {side!r}.")
    first = SIDES.index(side)
    shares = np.zeros((degree + 1, 3), dtype=np.int64)
    shares[:, first] = degree - np.arange(degree + 1)
    shares[:, (first + 1) % 3] = np.arange(degree + 1)
    return net_number(shares)


@dataclass(frozen=True, eq=False)
class _Structure:
    """What all schemes of one degree have in common.

    Attributes
    ----------
    columns : (q, m) float
        Those of de Casteljau.
    layout : (4, m) int
        Column j of T_k is ``columns[layout[k, j]]``.
    names : q str
    fixed : (q,) bool
        The corners.
    side : (q,) int
        Number of the side that a column lies on, or INSIDE.
    partner : (q,) int
        The column's mirror image on its side; itself inside.
    """

    columns: FloatArray
    layout: IntArray
    names: tuple[str, ...]
    fixed: BoolArray
    side: IntArray
    partner: IntArray


@dataclass(frozen=True, eq=False)
class TriangleScheme:
    """Four transformations of the control points of a triangular patch.

    Parameters
    ----------
    degree : int
        d; the patch has (d+1)(d+2)/2 control points.
    columns : (q, m) float
        The different columns, in the order of T_1 to T_4.
    tol : Tolerance

    Raises
    ------
    InputError
        A wrong shape, or NaN.
    ContinuityError
        Columns that would tear the mesh.
    """

    degree: int
    columns: FloatArray
    tol: Tolerance = DEFAULT

    def __post_init__(self) -> None:
        whole_number(self.degree, "The degree of a triangular patch", 1)
        columns, wanted = np.array(self.columns, dtype=float), self._structure.columns.shape
        if columns.shape != wanted:
            raise InputError(
                f"A triangular patch of degree {self.degree} needs columns of shape {wanted}, got "
                f"{columns.shape}."
            )
        if not np.isfinite(columns).all():
            raise InputError("The columns of a scheme must be finite.")
        object.__setattr__(self, "columns", frozen(columns))
        self._require_continuity()

    @classmethod
    def de_casteljau(cls, degree: int, *, tol: Tolerance = DEFAULT) -> TriangleScheme:
        """Return the scheme of a smooth Bezier triangle.

        Parameters
        ----------
        degree : int
            At least 1.
        """
        return cls(degree, _structure(whole_number(degree, "The degree", 1)).columns, tol)

    @property
    def size(self) -> int:
        """Number m of control points."""
        return int(self.columns.shape[1])

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns: s with the first number it has through T_1 to T_4."""
        return self._structure.names

    @property
    def free_names(self) -> tuple[str, ...]:
        """Names of the subdivision points that can be moved."""
        return tuple(
            name
            for name, fixed in zip(self.names, self._structure.fixed, strict=True)
            if not fixed and self.degree > 1
        )

    @cached_property
    def transformations(self) -> FloatArray:
        """(4, m, m) matrices T_k; column j is ``T[k][:, j]``."""
        placed = self.columns[self._structure.layout]
        return frozen(np.ascontiguousarray(placed.swapaxes(1, 2)))

    def kinds(self) -> dict[str, Kind]:
        """Return what each column may do, by name: "fixed", "shared" or "free"."""
        places = np.bincount(self._structure.layout.ravel())
        free = set(self.free_names)
        return {
            name: "fixed" if name not in free else "shared" if count > 1 else "free"
            for name, count in zip(self.names, places, strict=True)
        }

    def index(self, name: str) -> int:
        """Return the row of a column that can be moved.

        Raises
        ------
        InputError
            An unknown name, or a fixed one; the message lists those that can be moved.
        """
        if name not in self.free_names:
            raise InputError(
                f"There is no subdivision point {name!r} to be moved; these are: "
                f"{', '.join(self.free_names) or 'none'}."
            )
        return self.names.index(name)

    def side_of(self, name: str) -> str | None:
        """Return the side that a column is bound to, or None inside."""
        number = int(self._structure.side[self.index(name)])
        return None if number == INSIDE else SIDES[number]

    def span(self, name: str) -> FloatArray | None:
        """Return orthonormal columns that span what a column may be; None for all columns."""
        row, side = self.index(name), self.side_of(name)
        if side is None:
            return None
        along = np.eye(self.size)[:, side_numbers(self.degree, side)]
        own = self._structure.partner[row] == row
        return along @ symmetric_columns(self.degree + 1) if own else along

    def with_column(self, name: str, column: ArrayLike) -> TriangleScheme:
        """Return the scheme with one column changed, wherever it stands, and its mirror image.

        Parameters
        ----------
        name : str
        column : (m,) float, barycentric

        Raises
        ------
        InputError
            An unknown or fixed name, or a column of the wrong shape.
        ContinuityError
            A column on a side that mixes in other control points than those of the side, or that
            is its own mirror image and does not read alike from both ends.
        """
        row, value = self.index(name), vector(column, "A column", self.size)
        columns, partner = self.columns.copy(), self._structure.partner[row]
        columns[row] = value
        if partner != row:
            columns[partner] = value[_mirror(self.degree, int(self._structure.side[row]))]
        return replace(self, columns=columns)

    def with_roughness(self, roughness: float) -> TriangleScheme:
        """Return the scheme with the columns between the corners of its parts moved off the flat.

        With lin the mixture of the three corner columns of a part that a column would be on a
        flat triangle, ``c -> lin + (1 + 3 r) (c - lin)``, as `Scheme.with_roughness` along curves.

        Parameters
        ----------
        roughness : float
            r, from -1/3 (parts with flat nets) through 0 (nothing changes) to 1.

        Raises
        ------
        InputError
            Out of range, or a patch of degree 1, which has no such columns.
        """
        share = float(vector([roughness], "Roughness", 1)[0])
        if not LEAST_ROUGHNESS <= share <= 1.0:
            raise InputError(f"Roughness must be between -1/3 and 1, got {roughness!r}.")
        if self.degree < 2:
            raise InputError(
                "A patch of three control points is flat, nothing to make rougher; take a net of "
                "degree 2 or more."
            )
        layout = self._structure.layout
        corners = self.columns[layout[:, corner_numbers(self.degree)]]
        flat = net(self.degree) / self.degree @ corners
        placed = self.columns[layout]
        columns = self.columns.copy()
        columns[layout] = placed + 3 * share * (placed - flat)
        columns[self._structure.fixed] = self.columns[self._structure.fixed]
        return replace(self, columns=columns)

    def _require_continuity(self) -> None:
        known, limit = self._structure, self.tol.barycentric
        moved = np.abs(self.columns - known.columns)[known.fixed]
        if moved.max() > limit:
            raise ContinuityError("The corners of a patch stay where its control points are.")
        for number, side in enumerate(SIDES):
            rows = np.flatnonzero(known.side == number)
            off = self.columns[rows].copy()
            off[:, side_numbers(self.degree, side)] = 0.0
            mirrored = self.columns[known.partner[rows]][:, _mirror(self.degree, number)]
            for gaps, what in (
                (np.abs(off), f"mixes in control points that are not on the side {side}"),
                (
                    np.abs(self.columns[rows] - mirrored),
                    f"is not the same from both ends of {side}",
                ),
            ):
                gap = float(gaps.max())
                if gap > limit:
                    name = self.names[rows[gaps.max(axis=1).argmax()]]
                    raise ContinuityError(
                        f"Column {name} would tear the mesh: it {what} (by {gap:.3g}, in "
                        "barycentric coordinates).",
                        gap=gap,
                    )

    @property
    def _structure(self) -> _Structure:
        return _structure(self.degree)


@lru_cache(maxsize=16)
def _structure(degree: int) -> _Structure:
    shares = net(degree)
    # The corners of parts that a blossom is taken at, in any order, tell one column from another.
    keys = [
        tuple(sorted(tuple(part[c].tolist()) for c in range(3) for _ in range(point[c])))
        for part in PARTS
        for point in shares
    ]
    first = {key: number for number, key in reversed(list(enumerate(keys)))}
    row = {key: place for place, key in enumerate(sorted(first, key=first.__getitem__))}
    columns = np.array([_blossom(degree, key) for key in row])
    side, partner = np.full(len(row), INSIDE), np.arange(len(row))
    for key, place in row.items():
        absent = [corner for corner in range(3) if not any(point[corner] for point in key)]
        if absent:
            number = (absent[0] + 1) % 3
            side[place] = number
            one, other = number, (number + 1) % 3
            mirrored = [list(point) for point in key]
            for point in mirrored:
                point[one], point[other] = point[other], point[one]
            partner[place] = row[tuple(sorted(tuple(point) for point in mirrored))]
    fixed = np.array([len(set(key)) == 1 and max(key[0]) == 2 for key in row])
    return _Structure(
        frozen(columns),
        frozen(np.array([row[key] for key in keys]).reshape(len(PARTS), len(shares))),
        tuple(f"s{first[key] + 1}" for key in row),
        frozen(fixed),
        frozen(side),
        frozen(partner),
    )


def _blossom(degree: int, points: tuple[tuple[int, ...], ...]) -> FloatArray:
    """Return the column of the blossom at `degree` points, given twice their shares of A, B, C."""
    column = np.ones(1)
    for level, point in enumerate(points, start=1):
        grown = np.zeros(len(net(level)))
        for corner in range(3):
            step = net(level - 1) + np.eye(3, dtype=np.int64)[corner]
            grown[net_number(step)] += point[corner] / 2 * column
        column = grown
    return column


def _mirror(degree: int, side: int) -> IntArray:
    """Return (m,) numbers of net points with the two corners of a side exchanged."""
    shares = net(degree)
    one, other = side, (side + 1) % 3
    shares[:, [one, other]] = shares[:, [other, one]]
    return net_number(shares)
