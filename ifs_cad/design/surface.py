"""The weighted vector sum of two discrete curves: a surface of planar quads.

In homogeneous coordinates (w, xw, yw, zw), M_ij = M_00 + (A_i - A_0) + (B_j - B_0), then divided
by w. Opposite sides of each quad differ by the same four-vector, so its corners are linearly
dependent and the projected quad is exactly planar, for space curves and any weights.

Source: section 3.4, figures 11 to 13 and the equation of M_ij.
"""

from __future__ import annotations

from typing import Any, Literal, Protocol, runtime_checkable

import numpy as np

from ifs_cad.design.address import (
    Structure,
    lexicographic_addresses,
    listed,
    surface_addresses,
)
from ifs_cad.design.mesh import Mesh
from ifs_cad.design.reading import require_in_reach
from ifs_cad.errors import InputError, SizeError, WeightError
from ifs_cad.tolerance import DEFAULT, MEMORY_LIMIT, Tolerance
from ifs_cad.types import ArrayLike, FloatArray, IntArray, vector


@runtime_checkable
class DiscreteCurve(Protocol):
    """Anything with homogeneous points and a word for each of its segments."""

    @property
    def homogeneous(self) -> FloatArray:
        """(n + 1, 4) float, rows (w, xw, yw, zw)."""

    @property
    def word_structure(self) -> Structure:
        """Radices of the construction steps and of the germ; their product is n."""


def vector_sum(
    a: DiscreteCurve | ArrayLike | Any,
    b: DiscreteCurve | ArrayLike | Any,
    *,
    origin: ArrayLike | None = None,
    addresses: Literal["ifs", "lexicographic"] = "ifs",
    tol: Tolerance = DEFAULT,
) -> Mesh:
    """Sum two discrete curves into a mesh of planar quads.

    B is first moved so that B_0 = A_0 and scaled to the weight of A_0 there, which makes the
    surface independent of where the curves lie; A and the moved B are two of its borders. Row i of
    the faces belongs to segment i of A, column j to segment j of B. The normals point along
    (segment of A) x (segment of B).

    Parameters
    ----------
    a, b : Curve, (n, 2) or (n, 3) array of points in mm, or cadquery Wire of straight edges
    origin : (3,) floats, optional
        Where M_00 lies, mm; the first point of A by default. Placing never changes the shape.
    addresses : "ifs" or "lexicographic"
        Words over the transformation alphabet, or row.column.

    Returns
    -------
    Mesh
        With its `lattice`. A curve closed in position and weight closes the mesh in its direction.

    Raises
    ------
    InputError
        Points that are not finite, too few, or of a wrong shape; a wire with curved edges.
    WeightError
        A weight of the sum is not positive; names the faces around it.
    DegenerateFaceError
        Segments of a and b are parallel.
    SizeError
        More faces than fit in memory; refused before any is computed.
    """
    points_a, structure_a = read_curve(a, "a")
    points_b, structure_b = read_curve(b, "b")
    shape = (len(points_a) - 1, len(points_b) - 1)
    _require_memory(*shape)
    if addresses == "ifs":
        names = surface_addresses(structure_a, structure_b)
    elif addresses == "lexicographic":
        names = lexicographic_addresses(*shape)
    else:
        raise InputError(f'addresses must be "ifs" or "lexicographic", got {addresses!r}.')

    start = points_a[0, 1:] / points_a[0, 0]
    moved_b = _placed(points_b, start) * (points_a[0, 0] / points_b[0, 0])
    summed = points_a[:, None] + (moved_b - points_a[0])
    lattice = _lattice(shape, _closed(points_a, tol), _closed(points_b, tol))
    corners = _quads(lattice)
    grid = summed.reshape(-1, 4)
    weights = grid[:, 0]
    bad = weights <= tol.weight * np.abs(weights).max()
    if bad.any():
        faces = [names[i] for i in np.flatnonzero(bad[corners].any(axis=1))]
        raise WeightError(
            f"The weights of the two curves sum to {weights.min():.3g} at {listed(faces)}; every "
            "weight of the surface must be positive. Raise the lowest weights of one curve.",
            addresses=faces,
            weight=float(weights.min()),
        )
    points = grid[:, 1:] / weights[:, None]
    if origin is not None:
        points = points + (vector(origin, "origin") - start)
    chain_ends = lattice[[0, 0, -1, -1], [0, -1, 0, -1]]
    used, renumbered = np.unique(lattice, return_inverse=True)
    if len(used) < len(points):  # closed directions leave the repeated end points unused
        points, lattice = points[used], renumbered.reshape(lattice.shape)
        chain_ends = np.empty(0, dtype=np.int64)
    return Mesh(
        points,
        _quads(lattice),
        addresses=tuple(names),
        lattice=lattice,
        chain_ends=chain_ends,
        tol=tol,
    )


BYTES_OF_A_FACE = 1500  # points, mesh arrays and address, measured at 65,536 faces


def _require_memory(rows: int, columns: int) -> None:
    """Raise when a surface of so many faces would not fit in memory.

    Raises
    ------
    SizeError
    """
    needed = rows * columns * BYTES_OF_A_FACE
    if needed > MEMORY_LIMIT:
        raise SizeError(
            f"A surface of {rows:,} x {columns:,} faces would take {needed / 2**30:,.1f} GiB; the "
            f"limit is {MEMORY_LIMIT / 2**30:.3g} GiB. Take a smaller iteration depth or fewer "
            "points.",
            bytes=needed,
        )


def _lattice(shape: tuple[int, int], closed_a: bool, closed_b: bool) -> IntArray:
    """Return (rows + 1, columns + 1) vertex numbers; a closed direction ends where it began."""
    rows, columns = shape
    number = np.arange((rows + 1) * (columns + 1)).reshape(rows + 1, columns + 1)
    if closed_a:
        number[-1] = number[0]
    if closed_b:
        number[:, -1] = number[:, 0]
    return number


def _quads(lattice: IntArray) -> IntArray:
    """Return the (f, 4) vertex numbers of the quads of a lattice, row by row."""
    around = [lattice[:-1, :-1], lattice[1:, :-1], lattice[1:, 1:], lattice[:-1, 1:]]
    return np.stack(around, axis=-1).reshape(-1, 4)


def _closed(points: FloatArray, tol: Tolerance) -> bool:
    """Tell whether a curve ends where it began, in position and in weight."""
    ends = points[[0, -1], 1:] / points[[0, -1], :1]
    same_place = float(np.abs(ends[0] - ends[1]).max()) <= tol.coincident
    same_weight = abs(points[0, 0] - points[-1, 0]) <= tol.rank * abs(points[0, 0])
    return same_place and bool(same_weight)


def _placed(points: FloatArray, start: FloatArray) -> FloatArray:
    """Move homogeneous points so that the first lies at `start`."""
    placed = points.copy()
    placed[:, 1:] += points[:, :1] * (start - points[0, 1:] / points[0, 0])
    return placed


def read_curve(curve: Any, name: str) -> tuple[FloatArray, Structure]:
    """Return the (n + 1, 4) homogeneous points of a curve of any kind, and its word structure.

    Raises
    ------
    InputError
        See `vector_sum`.
    """
    if isinstance(curve, DiscreteCurve):
        return np.asarray(curve.homogeneous, dtype=float), curve.word_structure
    if hasattr(curve, "val"):  # a Workplane with the wire on its stack
        curve = curve.val()
    if hasattr(curve, "geomType"):  # a cadquery shape, without importing cadquery here
        curve = _wire_points(curve, name)
    try:
        points = np.array(curve, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"Curve {name} must be a Curve, an array of points or a cadquery Wire: {error}."
        ) from error
    if points.ndim != 2 or points.shape[1] not in (2, 3) or len(points) < 2:
        raise InputError(
            f"Curve {name} must be (n, 2) or (n, 3) points with n >= 2, got shape {points.shape}."
        )
    require_in_reach(points, f"Points of curve {name}")
    same = np.flatnonzero(~np.diff(points, axis=0).any(axis=1))
    if len(same):
        raise InputError(
            f"Points {same.tolist()} of curve {name} coincide with the points after them. "
            "Remove them."
        )
    homogeneous = np.zeros((len(points), 4))
    homogeneous[:, 0] = 1.0
    homogeneous[:, 1 : 1 + points.shape[1]] = points
    return homogeneous, ((), (len(points) - 1,))


def _wire_points(wire: Any, name: str) -> list[tuple[float, float, float]]:
    """Chain the straight edges of a cadquery Wire (or one Edge) into points."""
    edges = [wire] if wire.ShapeType() == "Edge" else list(wire)
    if wire.ShapeType() not in ("Edge", "Wire") or any(e.geomType() != "LINE" for e in edges):
        raise InputError(
            f"Curve {name} is a {wire.ShapeType()} that is not made of straight edges. Sample it "
            "first: wire.positions(numpy.linspace(0, 1, 17))."
        )
    ends = [(e.startPoint().toTuple(), e.endPoint().toTuple()) for e in edges]
    if len(ends) > 1 and _apart(ends[0][1], ends[1]) > _apart(ends[0][0], ends[1]):
        ends[0] = ends[0][::-1]
    points = [ends[0][0], ends[0][1]]
    for first, last in ends[1:]:
        ahead = _apart(points[-1], (first,)) <= _apart(points[-1], (last,))
        points.append(last if ahead else first)
    if wire.ShapeType() == "Wire" and wire.IsClosed():
        points[-1] = points[0]
    return points


def _apart(point: tuple[float, ...], others: tuple[tuple[float, ...], ...]) -> float:
    """Return the distance from a point to the nearest of some others."""
    return min(float(np.linalg.norm(np.subtract(point, other))) for other in others)
