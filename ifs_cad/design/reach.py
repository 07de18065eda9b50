"""Which barycentric columns put subdivision points where the designer wants them.

Source: the paper, section 3.1, c_i = P^-1 s_i, and section 3.4 for homogeneous coordinates.
"""

from __future__ import annotations

import numpy as np

from ifs_cad.design.reading import read_points, read_weights
from ifs_cad.design.transform import Scheme
from ifs_cad.errors import ContinuityError, OutOfReachError, WeightError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import ArrayLike, FloatArray

__all__ = ["germ_through", "solve_columns", "subdivision_point", "with_subdivision_point"]


def solve_columns(
    projection: FloatArray,
    columns: FloatArray,
    points: FloatArray,
    weights: FloatArray,
    *,
    span: FloatArray | None = None,
    project: bool = False,
    tol: Tolerance = DEFAULT,
) -> FloatArray:
    """Return the columns that P takes to given points, with the least change.

    Solves P c = s in homogeneous coordinates: c + pinv(P) (s - P c). Only points of the affine
    hull of the control points can be reached. The hull is found on centred and scaled points,
    since raw coordinates in mm next to a row of weights say nothing about rank; the least change
    is the same.

    Parameters
    ----------
    projection : (4, m) float
        Homogeneous control points as columns (w, xw, yw, zw).
    columns : (r, m) float
        The present columns.
    points : (r, 3) float, mm
    weights : (r,) float
    span : (m, k) float, optional
        Orthonormal columns, none of them negative, that span what the columns may be.
    project : bool
        Take the nearest point of the hull instead of refusing a point off it.

    Returns
    -------
    (r, m) float

    Raises
    ------
    OutOfReachError
        A point further than `tol.planar` off the hull.

    References
    ----------
    The paper, section 3.1: c_i = P^-1 s_i.
    """
    if span is not None:
        projection, columns = projection @ span, columns @ span
    positions = (projection[1:] / projection[0]).T
    centre = positions.mean(axis=0)
    offsets = positions - centre
    scale = np.abs(offsets).max() or 1.0
    _, singular, axes = np.linalg.svd(offsets / scale, full_matrices=False)
    axes = axes[singular > tol.rank * singular[0]]
    local = (points - centre) @ axes.T
    distances = np.linalg.norm(points - centre - local @ axes, axis=1)
    furthest = int(distances.argmax())
    if not project and distances[furthest] > tol.planar:
        hull = ("place", "line", "plane")[len(axes)]
        bound = "of the control points" if span is None else "that its column is bound to"
        raise OutOfReachError(
            f"The point {points[furthest].tolist()} is {distances[furthest]:.6g} mm off the {hull} "
            f"{bound}, which this point cannot leave. Move a control point out of it, or take the "
            "nearest point (project=True).",
            distance=float(distances[furthest]),
        )
    reduced = np.vstack([projection[0], projection[0] * (offsets @ axes.T / scale).T])
    wanted = weights * np.vstack([np.ones(len(points)), local.T / scale])
    change = np.linalg.lstsq(reduced, wanted - reduced @ columns.T)[0].T
    return np.asarray(columns + change if span is None else (columns + change) @ span.T)


def subdivision_point(
    scheme: Scheme, projection: FloatArray, name: str, *, tol: Tolerance = DEFAULT
) -> tuple[float, FloatArray]:
    """Return weight and (3,) place, mm, of the subdivision point s = P c.

    Raises
    ------
    InputError
        An unknown name.
    WeightError
        Its weight has vanished.
    """
    weight, *scaled = projection @ scheme.columns[scheme.index(name)]
    if not weight > tol.weight * projection[0].max():
        raise WeightError(
            f"Subdivision point {name} has the weight {weight:.3g}, so it has no place. Give "
            "it a place and a positive weight.",
            weight=float(weight),
        )
    return float(weight), np.array(scaled) / weight


def with_subdivision_point(
    scheme: Scheme,
    projection: FloatArray,
    name: str,
    point: ArrayLike | None = None,
    weight: float | None = None,
    *,
    project: bool = False,
    tol: Tolerance = DEFAULT,
) -> Scheme:
    """Return the scheme with the column that puts a subdivision point where it is wanted.

    Parameters and errors are those of `Curve.with_subdivision_point`.

    Parameters
    ----------
    projection : (4, m) float
    """
    row = scheme.free_index(name)
    if weight is None or point is None:
        present_weight, present_point = subdivision_point(scheme, projection, name, tol=tol)
        weight = present_weight if weight is None else weight
        point = present_point if point is None else point
    column = solve_columns(
        projection,
        scheme.columns[[row]],
        read_points([point], f"Subdivision point {name}"),
        read_weights([weight], 1),
        span=scheme.span(name),
        project=project,
        tol=tol,
    )
    return scheme.with_column(name, column[0])


def germ_through(
    projection: FloatArray, ends: FloatArray, points: FloatArray, *, tol: Tolerance = DEFAULT
) -> FloatArray:
    """Return the barycentric rows of a germ given as a polyline in space.

    Each point takes the column of least change from the evenly spaced point of the chord, and that
    point's weight.

    Parameters
    ----------
    projection : (4, m) float
    ends : (2, m) float
        a and b, where the curve starts and ends.
    points : (g + 1, 3) float, mm

    Returns
    -------
    (g + 1, m) float

    Raises
    ------
    ContinuityError
        A polyline that does not run from the start to the end of the curve.
    OutOfReachError
        A point off the affine hull of the control points.
    """
    weights, *coordinates = projection @ ends.T
    gaps = np.linalg.norm(points[[0, -1]] - (np.array(coordinates) / weights).T, axis=1)
    if gaps.max() > tol.coincident:
        raise ContinuityError(
            "The germ must run from the start to the end of the curve; it misses them by "
            f"{gaps[0]:.6g} mm and {gaps[1]:.6g} mm.",
            gap=float(gaps.max()),
        )
    share = np.linspace(0.0, 1.0, len(points))[:, None]
    chord = (1 - share) * ends[0] + share * ends[1]
    solved = solve_columns(projection, chord, points, chord @ projection[0], tol=tol)
    return np.vstack([ends[0], solved[1:-1], ends[1]])
