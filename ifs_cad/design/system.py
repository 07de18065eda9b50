"""Iterated function systems: a set of transformations, seen through a projection.

Terms
-----
coordinates : what the maps act on. Affine maps act on points of the plane or of space, barycentric
    ones on mixtures of m control points.
projection P : takes coordinates to points. With barycentric maps its columns are the control
    points; with affine ones it is optional, a view of the figure.
contraction factor : the largest factor by which a single map stretches a length. Below 1, maps
    settle on one attractor whatever they start from.

Source: the paper, sections 2.3 (iterated function systems) and 3.1 (barycentric transformations).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ifs_cad.design.affine import Placements, is_homogeneous, read_maps
from ifs_cad.design.contraction import USUAL_LENGTH, USUAL_WORDS, Contraction
from ifs_cad.design.curve import DEEPEST
from ifs_cad.design.reading import whole_number
from ifs_cad.design.size import require_memory
from ifs_cad.design.tree import ConstructionTree, read_word
from ifs_cad.errors import ContractionError, InputError, WeightError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import ArrayLike, FloatArray, frozen

HOMOGENEOUS = 4  # rows (w, xw, yw, zw) of a projection with weights

__all__ = ["System", "require_sums_of_one"]


@dataclass(frozen=True, eq=False, init=False)
class System:
    """Transformations, and the projection that they are seen through.

    Parameters
    ----------
    maps : (N, d, d + 1), (N, d + 1, d + 1) or (N, m, m) array
        Affine maps [A t] or [[A, t], [0, 1]] of the plane (d = 2) or of space (d = 3), or
        barycentric ones on m control points, whose columns sum to 1 unless weights are in play.
    projection : (2, k), (3, k) or (4, k) array, optional
        P, from the k = d + 1 or k = m coordinates to points in the plane or in space; with four
        rows it is homogeneous, (w, xw, yw, zw). Barycentric maps need it: the columns are the
        control points, as in the paper.
    tol : Tolerance, optional

    Raises
    ------
    InputError
        NaN or infinite numbers, or shapes that do not fit each other.
    """

    maps: FloatArray
    projection: FloatArray | None
    tol: Tolerance = field(repr=False)

    def __init__(
        self, maps: ArrayLike, projection: ArrayLike | None = None, *, tol: Tolerance = DEFAULT
    ) -> None:
        matrices = read_maps(maps, tol=tol)
        view = None if projection is None else _read_projection(projection, matrices)
        if view is None and not is_homogeneous(matrices):
            raise InputError(
                f"Transformations of shape {matrices.shape[1:]} whose last row is not (0, ..., 0, "
                "1) act on control points: give these as the columns of the projection P."
            )
        object.__setattr__(self, "maps", frozen(matrices))
        object.__setattr__(self, "projection", None if view is None else frozen(view))
        object.__setattr__(self, "tol", tol)
        if not (self.is_affine or self.is_weighted):
            require_sums_of_one(matrices.sum(axis=1), "columns of the transformations", tol)

    @property
    def count(self) -> int:
        """Number N of transformations."""
        return len(self.maps)

    @property
    def ndim(self) -> int:
        """2 when the figure is seen in the plane, 3 in space."""
        return len(self._view) - self.is_weighted

    @cached_property
    def is_affine(self) -> bool:
        """Whether the maps act on points; otherwise on control points."""
        return is_homogeneous(self.maps)

    @property
    def is_weighted(self) -> bool:
        """Whether P is homogeneous."""
        return self.projection is not None and len(self.projection) == HOMOGENEOUS

    def seen(self, coordinates: FloatArray) -> FloatArray:
        """Return the points of (..., k) coordinates: what P does.

        Raises
        ------
        WeightError
            A weight that is not positive.
        """
        return self._divided(coordinates @ self._view.T)

    def addresses(self, depth: int, prefix: str | Sequence[int] = ()) -> list[str]:
        """Return the addresses of the elements, all or those with a prefix.

        Without any step the only element is called ``0``.

        Raises
        ------
        AddressError
            A prefix that no element has.
        SizeError
            More addresses than fit in memory.
        """
        return self.tree(depth).level(depth, prefix) if depth != 0 else ["0"]

    def tree(self, depth: int) -> ConstructionTree:
        """Return the construction tree; the paper, figure 7."""
        return ConstructionTree(self.count, depth)

    def transforms(self, depth: int, prefix: str | Sequence[int] = ()) -> Placements:
        """Return the composed maps T_i1 ... T_in of all elements, to place copies of anything.

        Parameters
        ----------
        depth : int
            Number n of construction steps.
        prefix : str or sequence of int
            Only the elements whose addresses begin so.

        Returns
        -------
        Placements
            (N^n) maps of the plane or of space, with addresses.

        Raises
        ------
        InputError
            A depth that is not a whole number from 0, or transformations that are no maps of
            space; see `space_maps`.
        AddressError
            A prefix that no element has.
        SizeError
            More matrices than fit in memory.
        """
        word, maps = self._prefix(depth, prefix), self.space_maps
        size = maps.shape[-1]
        self._require_memory(depth, size**2, len(word))
        products = np.eye(size)[None]
        for digit in word:
            products = products @ maps[digit]
        for _ in range(depth - len(word)):
            products = (products[:, None] @ maps).reshape(-1, size, size)
        return Placements(products, tuple(self.addresses(depth, prefix)), self.tol)

    @property
    def acts_on_space(self) -> bool:
        """Whether the transformations are maps of the plane or space that P leads to."""
        return self._space_maps is not None

    @cached_property
    def space_maps(self) -> FloatArray:
        """(N, d+1, d+1) the maps as homogeneous matrices of the plane or space that P leads to.

        With P barycentric and square these are P T P^-1.

        Raises
        ------
        InputError
            Weights; control points that do not span the space; or maps that take two coordinates
            of one point to different points.
        """
        maps = self._space_maps
        if maps is None:
            raise InputError(
                "These transformations act on coordinates, not on points: the same point seen "
                "through P can go to several places. Maps of space need a projection without "
                f"weights and control points that span it ({self.ndim + 1} that do always work)."
            )
        return maps

    @cached_property
    def linear_parts(self) -> FloatArray:
        """(N, q, q) what the maps do to differences.

        Of points when the maps act on the plane or space, else of barycentric coordinates.

        Raises
        ------
        InputError
            Weights, under which differences mean nothing.
        """
        if self._space_maps is not None:
            return np.asarray(self._space_maps[:, :-1, :-1])
        if self.is_weighted:
            raise InputError(
                "With weights, what a transformation does to a difference depends on where it is. "
                "For a curve ask Curve.contraction()."
            )
        return np.asarray(self.differences @ self.maps @ self.differences.T)

    @cached_property
    def differences(self) -> FloatArray:
        """(k - 1, k) orthonormal rows that span the differences of coordinates."""
        return frozen(np.linalg.svd(self.unit[None])[2][1:])

    @property
    def factors(self) -> FloatArray:
        """(N,) largest factor by which each map stretches a length: largest singular values."""
        return np.asarray(np.linalg.norm(self.linear_parts, ord=2, axis=(1, 2)))

    @property
    def contraction_factor(self) -> float:
        """The largest of the factors: below 1 the distance of two germs shrinks in every step."""
        return float(self.factors.max())

    @property
    def is_similarity(self) -> bool:
        """Whether all maps are similarities of the plane or of space."""
        return self.acts_on_space and self.transforms(1).is_similarity

    @cached_property
    def contraction(self) -> Contraction:
        """Whether the figure settles: the largest ||product||^(1/k) over words of one length k.

        Maps whose contraction factor is 1 or more can contract after a few steps. The words have 8
        digits, fewer when there would be more than 4096.
        """
        maps, length = self.linear_parts, 1
        products = maps
        while length < USUAL_LENGTH and len(products) * self.count <= USUAL_WORDS:
            products = (products[:, None] @ maps).reshape(-1, *maps.shape[1:])
            length += 1
        largest = float(np.linalg.norm(products, ord=2, axis=(1, 2)).max())
        return Contraction(largest ** (1.0 / length), length)

    def require_contracting(self) -> None:
        """Raise unless the maps contract.

        Raises
        ------
        ContractionError
            Names the rate and the worst map.
        """
        if not self.contraction.contracting:
            rate, worst = self.contraction.rate, int(self.factors.argmax())
            raise ContractionError(
                f"These transformations need have no attractor, since they do not contract: "
                f"lengths grow by {rate:.4g} per construction step (words of "
                f"{self.contraction.length}), and T_{worst + 1} alone stretches by "
                f"{self.contraction_factor:.4g}. Make the maps smaller; finite construction steps "
                "can be had without.",
                rate=rate,
                factor=self.contraction_factor,
            )

    @cached_property
    def _view(self) -> FloatArray:
        """(p, k) the projection, or what drops the last coordinate of affine maps."""
        if self.projection is not None:
            return self.projection
        size = self.maps.shape[-1]
        return np.eye(size - 1, size)

    @cached_property
    def unit(self) -> FloatArray:
        """(k,) what the coordinates of a point add up to 1 with."""
        size = self.maps.shape[-1]
        return np.eye(size)[-1] if self.is_affine else np.ones(size)

    @cached_property
    def _space_maps(self) -> FloatArray | None:
        """The maps of space, if the maps are such."""
        if self.projection is None:
            return self.maps
        if self.is_weighted:
            return None
        # Centred and scaled, since coordinates in mm beside a row of ones say nothing about rank.
        view, unit = self.projection, self.unit
        centre = view[:, -1] if self.is_affine else view.mean(axis=1)
        offsets = view - np.outer(centre, unit)
        size = float(np.abs(offsets).max()) or 1.0
        view = np.vstack([offsets / size, unit])
        singular = np.linalg.svd(view, compute_uv=False)
        if singular[-1] <= self.tol.rank * singular[0] or len(view) > view.shape[1]:
            return None
        maps = view @ self.maps @ np.linalg.pinv(view)
        if np.abs(maps @ view - view @ self.maps).max() > self.tol.barycentric:
            return None
        back = np.eye(len(view))
        back[:-1] *= size
        back[:-1, -1] = centre
        maps = back @ maps @ np.linalg.inv(back)
        maps[:, -1] = back[-1]
        return frozen(maps)

    def _divided(self, points: FloatArray) -> FloatArray:
        """Return (..., p) projected coordinates divided by their weights, if any."""
        if not self.is_weighted:
            return points
        weights = points[..., :1]
        if not (weights > self.tol.weight * np.abs(weights).max()).all():
            raise WeightError(
                f"The weight of the figure falls to {weights.min():.3g}; weights must stay "
                "positive. Raise those of the control points or of the transformations' columns.",
                weight=float(weights.min()),
            )
        return np.asarray(points[..., 1:] / weights)

    def _prefix(self, depth: int, prefix: str | Sequence[int]) -> tuple[int, ...]:
        """Return the digits of a prefix of words of a valid depth."""
        return read_word(prefix, self.count, whole_number(depth, "The iteration depth", 0, DEEPEST))

    def _require_memory(self, depth: int, numbers: int, known: int) -> None:
        # Twice: a step needs what was before it and what comes after it.
        require_memory(self.count, depth, 2 * self.maps.itemsize * max(numbers, 1), known=known)


def _read_projection(value: ArrayLike, maps: FloatArray) -> FloatArray:
    """Read P for maps of k coordinates."""
    size = maps.shape[-1]
    try:
        view = np.array(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(f"The projection P must be numbers, got {value!r}.") from error
    if view.ndim != 2 or len(view) not in (2, 3, HOMOGENEOUS) or view.shape[1] != size:
        turned = " Control points are its columns." if len(view) == size else ""
        raise InputError(
            f"The projection P of transformations of {size} coordinates must have the shape (2, "
            f"{size}), (3, {size}) or, with weights, (4, {size}); got {view.shape}.{turned}"
        )
    if not np.isfinite(view).all():
        raise InputError("The projection P must be finite.")
    return view


def require_sums_of_one(sums: FloatArray, what: str, tol: Tolerance) -> None:
    """Raise unless barycentric sums are 1; `what` names them in the message."""
    if np.abs(sums - 1.0).max() > tol.barycentric:
        raise InputError(
            f"The {what} sum to between {sums.min():.6g} and {sums.max():.6g}, not to 1. With "
            "weights, give the projection as rows (w, xw, yw, zw)."
        )
