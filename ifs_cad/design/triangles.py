"""Triangular patches: iterated surfaces of triangles with six bars in every inner node.

A patch is a triangular net of control points with the four transformations of a `TriangleScheme`.
After n construction steps it is a mesh of 4^n triangles, each with its word for an address: digits
0, 1 and 2 lead to the corners A, B and C, digit 3 to the middle. The three sides are iterated
curves of the net's sides; patches with the same points on a side fit together there.

Source: the paper, section 3.3: to fix the number of bars in a node to six, surfaces are composed
of regular triangular faces.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import isqrt
from operator import index

import numpy as np

from ifs_cad.design.address import curve_addresses, listed
from ifs_cad.design.contraction import Contraction, contraction, diameter_contraction
from ifs_cad.design.curve import DEEPEST, Curve
from ifs_cad.design.mesh import Mesh
from ifs_cad.design.reach import solve_columns
from ifs_cad.design.reading import read_points, read_weights, whole_number
from ifs_cad.design.size import require_memory
from ifs_cad.design.transform import Scheme
from ifs_cad.design.triangle_scheme import (
    PARTS,
    TriangleScheme,
    corner_numbers,
    net_number,
    side_numbers,
)
from ifs_cad.errors import InputError, WeightError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import ArrayLike, FloatArray, IntArray, frozen

BYTES_OF_A_TRIANGLE = 1024  # corners, mesh arrays and address

__all__ = ["TriangularPatch"]


@dataclass(frozen=True, eq=False, init=False)
class TriangularPatch:
    """A discrete surface of triangles over a triangular net of control points.

    Parameters
    ----------
    control_points : (m, 2) or (m, 3) array, mm
        m = 3, 6, 10, 15, ...: row by row from the corner A, one point, then two, then three; the
        last row runs from B to C. Normals point to the side from which A, B, C run
        counter-clockwise.
    depth : int
        Number of construction steps; there are 4^depth triangles.
    weights : (m,) array, optional
        Positive weights of the control points, 1 by default.
    scheme : TriangleScheme, optional
        De Casteljau's by default, a smooth Bezier triangle.
    tol : Tolerance

    Raises
    ------
    InputError
        Points that are not finite, or not of a triangular number; a scheme of another degree.
    WeightError
        Weights that are not positive and finite.
    """

    control_points: FloatArray
    weights: FloatArray
    depth: int
    scheme: TriangleScheme
    tol: Tolerance

    def __init__(
        self,
        control_points: ArrayLike,
        *,
        depth: int = 3,
        weights: ArrayLike | None = None,
        scheme: TriangleScheme | None = None,
        tol: Tolerance = DEFAULT,
    ) -> None:
        points = read_points(control_points, "Control points")
        degree = (isqrt(8 * len(points) + 1) - 3) // 2
        if degree < 1 or (degree + 1) * (degree + 2) != 2 * len(points):
            raise InputError(
                f"A triangular net has 3, 6, 10, 15, ... control points, got {len(points)}."
            )
        scheme = TriangleScheme.de_casteljau(degree, tol=tol) if scheme is None else scheme
        if scheme.degree != degree:
            raise InputError(
                f"The scheme is made for {scheme.size} control points, the patch has {len(points)}."
            )
        values = {
            "control_points": frozen(points),
            "weights": frozen(read_weights(weights, len(points))),
            "depth": whole_number(depth, "The iteration depth", 0, DEEPEST),
            "scheme": scheme,
            "tol": tol,
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @property
    def degree(self) -> int:
        """Degree d of the patch: its sides have d + 1 control points."""
        return self.scheme.degree

    @cached_property
    def projection(self) -> FloatArray:
        """(4, m) P: homogeneous control points as columns (w, xw, yw, zw)."""
        return frozen(np.vstack([self.weights, self.weights * self.control_points.T]))

    @cached_property
    def addresses(self) -> list[str]:
        """The address of each triangle, in order."""
        self._require_memory()
        return curve_addresses((len(PARTS),) * self.depth)

    @cached_property
    def homogeneous(self) -> FloatArray:
        """(v, 4) nodes of the mesh, rows (w, xw, yw, zw), row by row from A as the net.

        Raises
        ------
        SizeError
            More triangles than fit in memory; refused before any is computed.
        WeightError
            A node without a positive weight; names the triangles around it.
        """
        self._require_memory()
        coarse = self.depth // 2
        pieces, maps = self.projection[None], self.scheme.transformations
        for _ in range(coarse):
            pieces = (pieces[:, None] @ maps).reshape(-1, *self.projection.shape)
        rows = np.eye(self.scheme.size)[corner_numbers(self.degree)]
        for _ in range(self.depth - coarse):
            rows = (rows @ maps.swapaxes(1, 2)).reshape(-1, self.scheme.size)
        corners = rows @ np.ascontiguousarray(pieces.swapaxes(1, 2))
        numbers, first = np.unique(self._faces, return_index=True)
        nodes = corners.reshape(-1, 4)[first]
        bad = nodes[:, 0] <= self.tol.weight * np.abs(nodes[:, 0]).max()
        if bad.any():
            around = np.flatnonzero(np.isin(self._faces, numbers[bad]).any(axis=1))
            names = [self.addresses[number] for number in around]
            raise WeightError(
                f"The weight falls to {nodes[:, 0].min():.3g} at triangles {listed(names)}; "
                "weights must stay positive. Raise those of the control or subdivision points.",
                addresses=names,
                weight=float(nodes[:, 0].min()),
            )
        return frozen(nodes)

    @cached_property
    def mesh(self) -> Mesh:
        """The patch as a mesh of triangles; inner nodes have six bars.

        Raises what `homogeneous` raises, and DegenerateFaceError for triangles without area.
        """
        nodes = self.homogeneous
        return Mesh(
            nodes[:, 1:] / nodes[:, :1],
            self._faces,
            addresses=tuple(self.addresses),
            chain_ends=corner_numbers(2**self.depth),
            tol=self.tol,
        )

    def side(self, side: str) -> Curve:
        """Return a side as an iterated curve, whose points are the border nodes of the mesh.

        Parameters
        ----------
        side : "AB", "BC" or "CA"
        """
        own = side_numbers(self.degree, side)
        first = "ABC".index(side[0])
        parts = self.scheme.transformations[[first, (first + 1) % 3]]
        within = parts[:, own[:, None], own]
        return Curve(
            self.control_points[own],
            weights=self.weights[own],
            depth=self.depth,
            scheme=Scheme.from_transformations(within, tol=self.scheme.tol).with_symmetry(),
            tol=self.tol,
        )

    @property
    def subdivision_points(self) -> dict[str, FloatArray]:
        """The (3,) points s = P c of the columns that can be moved, mm, by name."""
        return {name: point for name, (_, point) in self._subdivisions().items()}

    @property
    def subdivision_weights(self) -> dict[str, float]:
        """The weights of the subdivision points, by name."""
        return {name: weight for name, (weight, _) in self._subdivisions().items()}

    def with_depth(self, depth: int) -> TriangularPatch:
        """Return the patch at another iteration depth."""
        return replace(self, depth=depth)

    def with_scheme(self, scheme: TriangleScheme) -> TriangularPatch:
        """Return the patch of the same control points by other transformations."""
        return replace(self, scheme=scheme)

    def with_roughness(self, roughness: float) -> TriangularPatch:
        """Return the patch rougher or smoother; see `TriangleScheme.with_roughness`."""
        return replace(self, scheme=self.scheme.with_roughness(roughness))

    def with_control_point(
        self, number: int, point: ArrayLike, weight: float | None = None
    ) -> TriangularPatch:
        """Return the patch with one control point moved.

        Parameters
        ----------
        number : int
            Row by row from A, from 0.
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
    ) -> TriangularPatch:
        """Return the patch with one subdivision point moved, its weight changed, or both.

        Points on a side stay within the span of the control points of that side and take their
        mirror image with them, so that the mesh stays connected at every depth.

        Parameters
        ----------
        name : str
        point : (2,) or (3,) floats, mm, optional
            Its present place by default.
        weight : float, optional
            Its present weight by default.
        project : bool
            Take the nearest point that can be reached.

        Raises
        ------
        InputError
            An unknown or fixed name; the message lists those that can be moved.
        OutOfReachError
            A point that the column cannot reach, unless `project`.
        WeightError
            A weight that is not positive.
        """
        row = self.scheme.index(name)
        if point is None or weight is None:
            present_weight, present_point = self._subdivision(name)
            weight = present_weight if weight is None else weight
            point = present_point if point is None else point
        column = solve_columns(
            self.projection,
            self.scheme.columns[[row]],
            read_points([point], f"Subdivision point {name}"),
            read_weights([weight], 1),
            span=self.scheme.span(name),
            project=project,
            tol=self.tol,
        )
        return replace(self, scheme=self.scheme.with_column(name, column[0]))

    def contraction(self, length: int | None = None) -> Contraction:
        """Report whether the pieces shrink from step to step; see `Curve.contraction`."""
        maps, tol = self.scheme.transformations, self.tol
        sums = self.scheme.columns.sum(axis=1)
        if np.ptp(self.weights) > 0.0 or np.abs(sums - 1).max() > tol.barycentric:
            return diameter_contraction(maps, self.projection, length, tol=tol)
        return contraction(maps, length, tol=tol)

    @cached_property
    def _faces(self) -> IntArray:
        """(4^depth, 3) node numbers of the triangles."""
        shares = 2**self.depth * np.eye(3, dtype=np.int64)[None]
        for _ in range(self.depth):
            shares = (PARTS @ shares[:, None] // 2).reshape(-1, 3, 3)
        return net_number(shares)

    def _require_memory(self) -> None:
        require_memory(len(PARTS), self.depth, BYTES_OF_A_TRIANGLE)

    def _subdivision(self, name: str) -> tuple[float, FloatArray]:
        weight, *scaled = self.projection @ self.scheme.columns[self.scheme.index(name)]
        if not weight > self.tol.weight * self.weights.max():
            raise WeightError(
                f"Subdivision point {name} has the weight {weight:.3g}, so it has no place. Give "
                "it a place and a positive weight.",
                weight=float(weight),
            )
        return float(weight), np.array(scaled) / weight

    def _subdivisions(self) -> dict[str, tuple[float, FloatArray]]:
        return {name: self._subdivision(name) for name in self.scheme.free_names}
