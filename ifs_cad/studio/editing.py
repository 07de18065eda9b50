"""Changes to one drawn curve, each a new curve.

Terms
-----
following : when control points move, subdivision points keep their barycentric columns, so they
    move along, the moved ones too.
mirror : in symmetric editing, the plane halfway between the first pair of control points that
    mirror each other, square to their connection. Control points move in pairs.

Source: the paper, sections 3.1 and 3.4.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ifs_cad.design.curve import Curve
from ifs_cad.design.reach import subdivision_point
from ifs_cad.design.reading import read_points, read_weights
from ifs_cad.design.transform import LEAST_ROUGHNESS, Scheme
from ifs_cad.design_record import DrawnCurve, SubdivisionPoint
from ifs_cad.errors import GeometryError, InputError
from ifs_cad.types import ArrayLike, FloatArray, IntArray

__all__ = [
    "moved_control_point",
    "moved_subdivision_point",
    "reset_subdivision_point",
    "with_control_point_added",
    "with_control_point_removed",
    "with_roughness",
    "with_symmetry",
    "with_transformations",
]


def moved_control_point(
    drawn: DrawnCurve, index: int, point: ArrayLike | None = None, weight: float | None = None
) -> DrawnCurve:
    """Return the curve with one control point elsewhere, or of another weight.

    In symmetric editing its mirror image moves too; one that is its own stays on the mirror.

    Raises
    ------
    InputError
        No such point, or a place that cannot be meant.
    WeightError
        A weight that is not positive, or one that leaves a subdivision point without any.
    """
    points, weights = np.array(drawn.control_points), np.array(drawn.weights)
    _require_index(drawn, index)
    if point is not None:
        points[index] = read_points([point], "A control point")[0]
    if weight is not None:
        weights[index] = read_weights([weight], 1)[0]
    if drawn.symmetric:
        partner = _partners(drawn)[index]
        image = _mirrored(drawn, points[index])
        weights[partner] = weights[index]
        if partner == index:
            image = (points[index] + image) / 2
        points[partner] = image
    return _followed(drawn, points, weights)


def moved_subdivision_point(
    drawn: DrawnCurve, name: str, point: ArrayLike | None = None, weight: float | None = None
) -> DrawnCurve:
    """Return the curve with one subdivision point elsewhere, or of another weight.

    It goes to the nearest point that it can reach, on the affine hull of the control points.

    Raises
    ------
    InputError, GeometryError
        What `Curve.with_subdivision_point` raises.
    """
    changed = drawn.base().with_subdivision_point(name, point, weight, project=True)
    own = drawn.plain_scheme.names[drawn.plain_scheme.free_index(name)]
    others = (own, changed.scheme.partner(own))
    kept = [item.name for item in drawn.moved if item.name not in others]
    return replace(drawn, moved=_read(changed, [*kept, own]))


def reset_subdivision_point(drawn: DrawnCurve, name: str) -> DrawnCurve:
    """Return the curve with one subdivision point back where the roughness has it."""
    scheme = drawn.plain_scheme.with_symmetry() if drawn.symmetric else drawn.plain_scheme
    own = scheme.names[scheme.free_index(name)]
    gone = (own, scheme.partner(own))
    return replace(drawn, moved=tuple(item for item in drawn.moved if item.name not in gone))


def with_roughness(drawn: DrawnCurve, roughness: float) -> DrawnCurve:
    """Return the curve rougher or smoother, the moved subdivision points too.

    Their distance from their chords grows as that of the others does; from a roughness of -1/3,
    where there is none, they stay.
    """
    after = replace(drawn, roughness=roughness, moved=())
    if not drawn.moved or drawn.roughness <= LEAST_ROUGHNESS:
        return replace(after, moved=drawn.moved)
    factor = (1 + 3 * after.roughness) / (1 + 3 * drawn.roughness)
    base = drawn.base()
    scaled = base.with_scheme(_roughened(base.scheme, factor))
    return replace(after, moved=_read(scaled, [item.name for item in drawn.moved]))


def with_symmetry(drawn: DrawnCurve, symmetric: bool) -> DrawnCurve:
    """Return the curve with or without symmetric editing.

    Going symmetric takes the mean of each point and its mirror image.

    Raises
    ------
    InputError
        No two control points are apart that mirror each other.
    """
    if symmetric == drawn.symmetric:
        return drawn
    base = drawn.base()
    partner = base.scheme.with_symmetry().partner
    names = dict.fromkeys(item.name for item in drawn.moved)
    images = {name: str(partner(name)) for name in names}
    if not symmetric:
        both = dict.fromkeys((*names, *images.values()))
        return replace(drawn, symmetric=False, moved=_read(base, list(both)))
    order = _partners(drawn)
    points, weights = np.array(drawn.control_points), np.array(drawn.weights)
    points = (points + _mirrored(drawn, points)[order]) / 2
    weights = (weights + weights[order]) / 2
    paired = _with_control(base, points, weights).with_symmetry()
    kept = [name for name in names if images[name] not in names or _is_first(paired, name)]
    plain = replace(drawn, control_points=_rows(points), weights=tuple(weights), moved=())
    return replace(plain, symmetric=True, moved=_read(paired, kept))


def with_transformations(
    drawn: DrawnCurve, *, transformations: int | None = None, closed: bool | None = None
) -> DrawnCurve:
    """Return the curve with another number of transformations, or closed, or opened.

    Its subdivision points become others, so those that were moved go back.
    """
    count = drawn.transformations if transformations is None else transformations
    is_closed = drawn.closed if closed is None else closed
    if (count, is_closed) == (drawn.transformations, drawn.closed):
        return drawn
    return replace(drawn, transformations=count, closed=is_closed, moved=())


def with_control_point_added(drawn: DrawnCurve) -> DrawnCurve:
    """Return the curve over one control point more, by raising its degree.

    The shape stays exactly, also a rough one, as long as the control points are affinely
    independent (at most three in a plane, four in space). Beyond that the curves of de Casteljau's
    scheme still stay, and of the others the control and subdivision points of the first step.
    """
    base = drawn.base()
    size = base.scheme.size
    raised = _raising(size)
    columns = (base.projection @ raised).T[: size + 1 - drawn.closed]
    after = replace(
        drawn,
        control_points=_rows(columns[:, 1:] / columns[:, :1]),
        weights=tuple(columns[:, 0].tolist()),
        roughness=0.0,
        moved=(),
    )
    if not drawn.moved and not drawn.roughness:
        return after
    scheme = after.plain_scheme.with_symmetry() if drawn.symmetric else after.plain_scheme
    placed = np.empty((len(scheme.columns), 4))
    parts = base.projection @ base.scheme.transformations @ raised
    placed[scheme.layout] = parts.swapaxes(1, 2)
    moved = [
        SubdivisionPoint(name, tuple((row[1:] / row[0]).tolist()), float(row[0]))
        for name, row, fixed in zip(scheme.names, placed, scheme.fixed, strict=True)
        if not fixed and (not drawn.symmetric or _is_first(scheme, name))
    ]
    return replace(after, moved=tuple(moved))


def with_control_point_removed(drawn: DrawnCurve, index: int) -> DrawnCurve:
    """Return the curve without one control point, in symmetric editing without its image too.

    The shape changes, and moved subdivision points go back: the scheme is another.

    Raises
    ------
    InputError
        No such point, or fewer than two would be left.
    """
    _require_index(drawn, index)
    gone = {index, int(_partners(drawn)[index])} if drawn.symmetric else {index}
    left = [i for i in range(len(drawn.control_points)) if i not in gone]
    if len(left) < 2:
        raise InputError(
            f"The curve has {len(drawn.control_points)} control points, and 2 must stay."
        )
    roughness = drawn.roughness if len(left) + drawn.closed > 2 else 0.0
    return replace(
        drawn,
        control_points=tuple(drawn.control_points[i] for i in left),
        weights=tuple(drawn.weights[i] for i in left),
        roughness=roughness,
        moved=(),
    )


def _followed(drawn: DrawnCurve, points: FloatArray, weights: FloatArray) -> DrawnCurve:
    """Return the curve over other control points, subdivision points following."""
    after = replace(drawn, control_points=_rows(points), weights=tuple(weights.tolist()))
    if not drawn.moved:
        return after
    try:
        changed = _with_control(drawn.base(), points, weights)
    except (GeometryError, InputError):  # a curve that cannot be built must stay repairable
        return after
    return replace(after, moved=_read(changed, [item.name for item in drawn.moved]))


def _with_control(base: Curve, points: FloatArray, weights: FloatArray) -> Curve:
    return replace(base, control_points=points, weights=weights)


def _read(curve: Curve, names: list[str]) -> tuple[SubdivisionPoint, ...]:
    """Return where a curve has its subdivision points of these names."""
    found = []
    for name in names:
        weight, point = subdivision_point(curve.scheme, curve.projection, name, tol=curve.tol)
        found.append(SubdivisionPoint(name, tuple(point.tolist()), weight))
    return tuple(found)


def _roughened(scheme: Scheme, factor: float) -> Scheme:
    """Return the scheme with its columns farther off their chords by a factor.

    Factors multiply, so larger ones than `Scheme.with_roughness` takes are made in steps.
    """
    largest = 4.0  # of a roughness of 1
    while factor > largest:
        scheme, factor = scheme.with_roughness(1.0), factor / largest
    return scheme.with_roughness(max((factor - 1) / 3, LEAST_ROUGHNESS))


def _raising(size: int) -> FloatArray:
    """Return the (m, m + 1) matrix that raises the degree of a Bezier curve by one."""
    raised = np.zeros((size, size + 1))
    number = np.arange(1, size + 1)
    raised[number - 1, number] = number / size
    raised[number - 1, number - 1] = 1 - (number - 1) / size
    return raised


def _is_first(scheme: Curve | Scheme, name: str) -> bool:
    """Tell whether a subdivision point comes before its mirror image, or is its own."""
    own = scheme.scheme if isinstance(scheme, Curve) else scheme
    return own.index(name) <= own.index(str(own.partner(name)))


def _partners(drawn: DrawnCurve) -> IntArray:
    """Return (m,) int, the control point that mirrors each one."""
    count = len(drawn.control_points)
    number = np.arange(count)
    return (-number) % count if drawn.closed else number[::-1].copy()


def _mirrored(drawn: DrawnCurve, points: FloatArray) -> FloatArray:
    """Return (..., 3) points seen in the mirror of a curve."""
    control = np.array(drawn.control_points)
    across = control[_partners(drawn)] - control
    lengths = np.linalg.norm(across, axis=1)
    apart = np.flatnonzero(lengths > 0.0)
    if not len(apart):
        raise InputError(
            "Symmetric editing needs two control points that mirror each other and are apart. "
            "Move the ends of the curve apart, or add a control point."
        )
    first = apart[0]
    normal = across[first] / lengths[first]
    middle = control[first] + across[first] / 2
    offset = np.asarray((points - middle) @ normal)
    return np.asarray(points - 2 * offset[..., None] * normal)


def _rows(points: FloatArray) -> tuple[tuple[float, float, float], ...]:
    return tuple((x, y, z) for x, y, z in points.tolist())


def _require_index(drawn: DrawnCurve, index: int) -> None:
    count = len(drawn.control_points)
    if not 0 <= index < count:
        raise InputError(f"There are control points 0 to {count - 1}, none {index}.")
