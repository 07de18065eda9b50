"""Affine maps as matrices: reading them, and taking them apart to place copies of one shape.

A map x -> A x + t is the homogeneous matrix [[A, t], [0, 1]], as in CadQuery and OpenCascade.

Every linear part is A = R M S, first a stretch S (symmetric, no negative factor), then a mirror M
of the last axis where the map turns right-handed things into left-handed ones, then a proper
rotation R. A *similarity* stretches by one factor in all directions. Copies whose M S agree are the
same shape in other places: make it once, put it there by rotation and translation.

Source: the paper, section 3.1 (transformation matrices); the polar decomposition is textbook.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ifs_cad.errors import AddressError, InputError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import ArrayLike, BoolArray, FloatArray, IntArray, frozen

__all__ = ["Placements", "Shapes", "homogeneous", "is_homogeneous", "read_affine", "read_maps"]


def read_maps(value: ArrayLike, *, tol: Tolerance = DEFAULT) -> FloatArray:
    """Read a set of transformations.

    Parameters
    ----------
    value : (N, d, d + 1) or (N, k, k) array
        Affine maps [A t] in the plane or in space, or square matrices: homogeneous affine ones or
        barycentric ones.
    tol : Tolerance

    Returns
    -------
    (N, k, k) float
        Affine maps with their last row (0, ..., 0, 1).

    Raises
    ------
    InputError
        A wrong shape, NaN or infinite, or no transformation.
    """
    wanted = (
        "Transformations must have the shape (N, d, d+1) with d = 2 or 3, (N, d+1, d+1), or "
        "(N, m, m) on m control points"
    )
    try:
        maps = np.array(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(f"{wanted}; they are not all of one shape, or not numbers.") from error
    if maps.ndim != 3 or len(maps) == 0:
        raise InputError(f"{wanted}, got shape {maps.shape}.")
    count, rows, columns = maps.shape
    if columns == rows + 1 and rows in (2, 3):
        maps = homogeneous(maps[:, :, :-1], maps[:, :, -1])
    elif rows != columns or rows < 2:
        raise InputError(f"{wanted}, got shape {maps.shape}.")
    finite = np.isfinite(maps).all(axis=(1, 2))
    if not finite.all():
        numbers = ", ".join(f"T_{number + 1}" for number in np.flatnonzero(~finite))
        raise InputError(f"Transformations must be finite; of {count}, these are not: {numbers}.")
    last = np.eye(maps.shape[-1])[-1]
    if maps.shape[-1] in (3, 4) and np.abs(maps[:, -1] - last).max() <= tol.barycentric:
        maps[:, -1] = last
    return maps


def read_affine(value: ArrayLike, ndim: int, *, tol: Tolerance = DEFAULT) -> FloatArray:
    """Read one affine map of the plane or of space that can be undone.

    Parameters
    ----------
    value : (d, d + 1) or (d + 1, d + 1) array
    ndim : int
        d, 2 or 3.

    Returns
    -------
    (d + 1, d + 1) float

    Raises
    ------
    InputError
        A wrong shape, NaN, or a map that flattens.
    """
    one: Any = [value]
    matrix = read_maps(one, tol=tol)[0]
    if len(matrix) != ndim + 1 or not is_homogeneous(matrix[None]):
        raise InputError(
            f"An affine map of {ndim} dimensions must have the shape ({ndim}, {ndim + 1}) or "
            f"({ndim + 1}, {ndim + 1}) with the last row (0, ..., 0, 1), got {np.shape(value)}."
        )
    stretches = np.linalg.svd(matrix[:-1, :-1], compute_uv=False)
    if stretches[-1] <= tol.rank * stretches[0]:
        raise InputError(
            f"The map flattens what it moves, so it cannot be undone: it stretches by "
            f"{stretches.tolist()}."
        )
    return np.asarray(matrix)


def homogeneous(linear: FloatArray, translations: FloatArray) -> FloatArray:
    """Return the (n, d+1, d+1) matrices of (n, d, d) linear parts and (n, d) translations."""
    count, size = translations.shape
    matrices = np.zeros((count, size + 1, size + 1))
    matrices[:, :-1, :-1] = linear
    matrices[:, :-1, -1] = translations
    matrices[:, -1, -1] = 1.0
    return matrices


def is_homogeneous(matrices: FloatArray) -> bool:
    """Tell whether square matrices are affine maps of the plane or of space."""
    size = matrices.shape[-1]
    return size in (3, 4) and bool((matrices[:, -1] == np.eye(size)[-1]).all())


@dataclass(frozen=True, eq=False)
class Shapes:
    """The different shapes among copies.

    Attributes
    ----------
    matrices : (k, d, d) float
        M S of each shape: what to do to the germ before it is placed.
    of : (n,) int
        The shape of each copy.
    """

    matrices: FloatArray
    of: IntArray


@dataclass(frozen=True, eq=False)
class Placements:
    """Where the copies of a germ go: one affine map for each element, with its address.

    Parameters
    ----------
    matrices : (n, d+1, d+1) float
        Homogeneous matrices; d is 2 or 3.
    addresses : n str
    tol : Tolerance

    Raises
    ------
    InputError
        Shapes that do not fit, NaN, or a last row that is not (0, ..., 0, 1).
    """

    matrices: FloatArray
    addresses: tuple[str, ...]
    tol: Tolerance = field(default=DEFAULT, repr=False)

    def __post_init__(self) -> None:
        matrices = read_maps(self.matrices, tol=self.tol)
        if not is_homogeneous(matrices):
            raise InputError(
                "Placements are homogeneous matrices of the plane or of space, with the last row "
                f"(0, ..., 0, 1); got matrices of shape {matrices.shape[1:]}."
            )
        if len(self.addresses) != len(matrices):
            raise InputError(
                f"{len(matrices)} placements need as many addresses, got {len(self.addresses)}."
            )
        object.__setattr__(self, "matrices", frozen(matrices))
        object.__setattr__(self, "addresses", tuple(self.addresses))

    def __len__(self) -> int:
        """Return the number of copies."""
        return len(self.matrices)

    def __getitem__(self, address: str) -> FloatArray:
        """Return the matrix of an element.

        Raises
        ------
        AddressError
            No element has this address.
        """
        if address not in self._rows:
            raise AddressError(
                f"No element has the address {address!r}; there are {len(self)}, from "
                f"{self.addresses[0]!r} to {self.addresses[-1]!r}.",
                addresses=[address],
            )
        return np.asarray(self.matrices[self._rows[address]])

    @property
    def ndim(self) -> int:
        """2 in the plane, 3 in space."""
        return int(self.matrices.shape[-1]) - 1

    @property
    def linear(self) -> FloatArray:
        """(n, d, d) linear parts A."""
        return self.matrices[:, :-1, :-1]

    @property
    def translations(self) -> FloatArray:
        """(n, d) translations t, mm."""
        return self.matrices[:, :-1, -1]

    @property
    def factors(self) -> FloatArray:
        """(n,) largest factors by which the maps stretch a length: largest singular values."""
        return self._decomposed[1][:, 0]

    @cached_property
    def scales(self) -> FloatArray:
        """(n,) factors of the similarities; otherwise the geometric mean of the stretches."""
        return frozen(np.prod(self._decomposed[1], axis=1) ** (1.0 / self.ndim))

    @cached_property
    def similar(self) -> BoolArray:
        """(n,) whether a map is a similarity; a map onto one point is none."""
        stretches = self._decomposed[1]
        spread = stretches[:, 0] - stretches[:, -1]
        return frozen((stretches[:, 0] > 0.0) & (spread <= self.tol.rank * stretches[:, 0]))

    @property
    def is_similarity(self) -> bool:
        """Whether all maps are similarities."""
        return bool(self.similar.all())

    @cached_property
    def mirrored(self) -> BoolArray:
        """(n,) whether a map turns right-handed things into left-handed ones."""
        left, _, right = self._decomposed
        return frozen(np.linalg.det(left) * np.linalg.det(right) < 0.0)

    @cached_property
    def rotations(self) -> FloatArray:
        """(n, d, d) proper rotations R."""
        left, _, right = self._decomposed
        turned = left @ right
        # R M with M = diag(1, ..., 1, -1) is R with its last column negated, and back.
        turned[self.mirrored, :, -1] *= -1.0
        return frozen(turned)

    @cached_property
    def stretches(self) -> FloatArray:
        """(n, d, d) symmetric stretches S; the factor times the unit matrix in a similarity."""
        _, singular, right = self._decomposed
        return frozen(right.swapaxes(1, 2) * singular[:, None] @ right)

    def shapes(self) -> Shapes:
        """Return the different shapes M S, so that each need be made only once.

        Copy i is its shape turned by ``rotations[i]`` and moved by ``translations[i]``. Stretches
        that differ by less than `tol.rank` of the largest are the same.
        """
        stretched = self.stretches.copy()
        stretched[self.mirrored, -1] *= -1.0
        grain = max(self.tol.rank * float(self.factors.max(initial=0.0)), np.finfo(float).tiny)
        keys = np.rint(stretched.reshape(len(self), -1) / grain)
        _, first, of = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        # Numbered as they first come, so that shapes keep their numbers when copies are appended.
        order = np.argsort(first)
        rank = np.empty_like(order)
        rank[order] = np.arange(len(order))
        return Shapes(frozen(stretched[first[order]]), frozen(rank[of.ravel()]))

    def applied(self, points: ArrayLike) -> FloatArray:
        """Return the (n, g, d) copies of (g, d) points."""
        copied = np.asarray(points, dtype=float)
        if copied.ndim != 2 or copied.shape[1] != self.ndim:
            raise InputError(
                f"These placements copy points of {self.ndim} numbers each, got shape "
                f"{copied.shape}."
            )
        return np.asarray(copied @ self.linear.swapaxes(1, 2) + self.translations[:, None])

    def in_space(self) -> Placements:
        """Return the placements of a figure in the plane as maps of space.

        The third direction is stretched by the scale, so that similarities stay similarities.
        """
        if self.ndim == 3:
            return self
        linear = np.zeros((len(self), 3, 3))
        linear[:, :2, :2], linear[:, 2, 2] = self.linear, self.scales
        moves = np.column_stack([self.translations, np.zeros(len(self))])
        return Placements(homogeneous(linear, moves), self.addresses, self.tol)

    @cached_property
    def _rows(self) -> dict[str, int]:
        return {address: row for row, address in enumerate(self.addresses)}

    @cached_property
    def _decomposed(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Left vectors, stretches from the largest, and right vectors as rows."""
        left, singular, right = np.linalg.svd(self.linear)
        return left, singular, right
