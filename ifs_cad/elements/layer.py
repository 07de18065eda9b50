"""Layers of a vault: planar polylines that stand side by side, one plank thickness apart.

Every layer is a curve in a plane; all these planes are parallel, and *across* is their common unit
normal, along which the layers follow each other. How far a given curve lies along it does not
matter: the layers stand jointlessly. In the plane, points have coordinates x along `u` and y along
`v`; u, v and across are right-handed.

A *joint* is a point of a polyline where two planks meet. Neighbouring layers are *staggered* when
no joint of one lies on a joint of the other: every second layer then takes the points of one more
construction step that lie between, so that only its end segments are split.

Source: section 4.1 (a series of curves put jointlessly one next to the other).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ifs_cad.design.curve import Curve
from ifs_cad.design.reading import read_points, whole_number
from ifs_cad.errors import DegenerateSegmentError, InputError, PlanarityError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import ArrayLike, BoolArray, FloatArray, IntArray, vector
from ifs_cad.vectors import cross, dot, length, unit

NEVER = -1  # instead of the number of a plank beyond the end of a layer


@dataclass(frozen=True, eq=False)
class Layers:
    """The segments of all layers in flat arrays.

    Attributes
    ----------
    origin : (3,) float, a point of the first layer, mm
    axes : (3, 3) float, rows u, v and across
    points : (n, 2) float, joints and ends of all polylines, mm from the origin
    starts, ends : (p,) int, the points of each segment
    layer : (p,) int, from 0
    before, after : (p,) int, the neighbouring segments in the layer, -1 at its ends
    words : p texts, unique within a layer
    count : number of layers
    """

    origin: FloatArray
    axes: FloatArray
    points: FloatArray
    starts: IntArray
    ends: IntArray
    layer: IntArray
    before: IntArray
    after: IntArray
    words: tuple[str, ...]
    count: int

    @property
    def across(self) -> FloatArray:
        """(3,) float, unit vector from layer to layer."""
        return np.asarray(self.axes[2])

    @cached_property
    def lengths(self) -> FloatArray:
        """(p,) float, of the segments, mm."""
        return length(self.points[self.ends] - self.points[self.starts])

    @cached_property
    def directions(self) -> FloatArray:
        """(p, 2) float, unit vectors along the segments."""
        return unit(self.points[self.ends] - self.points[self.starts])

    @cached_property
    def outside(self) -> float:
        """1.0 when the outside of the vault lies to the right of its curves, else -1.0.

        The outside is the side away from the chords, or of a closed curve the outer one: where
        the area between all curves and their chords does not lie.
        """
        return -1.0 if self.areas.sum() < 0 else 1.0

    @cached_property
    def areas(self) -> FloatArray:
        """(count,) float, twice the area between each layer and its chord, mm2.

        Positive where the layer runs counter-clockwise.
        """
        first = self.points[self.starts[np.searchsorted(self.layer, self.layer)]]
        start, end = self.points[self.starts] - first, self.points[self.ends] - first
        moments = start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]
        return np.asarray(np.bincount(self.layer, moments), dtype=float)

    @cached_property
    def turns(self) -> FloatArray:
        """(p, 2) float, radians by which the curve turns at the start and the end of each segment.

        Positive where planks are longer on the outside; zero at the ends of a layer.
        """
        both = []
        for neighbour, order in ((self.before, -1.0), (self.after, 1.0)):
            other = self.directions[neighbour]
            sine = order * (
                self.directions[:, 0] * other[:, 1] - self.directions[:, 1] * other[:, 0]
            )
            angle = np.arctan2(sine, dot(self.directions, other))
            both.append(np.where(neighbour == NEVER, 0.0, self.outside * angle))
        return np.stack(both, axis=1)

    @cached_property
    def is_ring(self) -> BoolArray:
        """(p,) bool, whether the layer of each segment is closed."""
        return np.asarray((np.bincount(self.layer, self.before == NEVER) == 0)[self.layer])

    def scaled(self, factor: float) -> Layers:
        """Return the layers with all their points scaled."""
        return replace(self, origin=self.origin * factor, points=self.points * factor)

    def names(self, segments: IntArray) -> list[str]:
        """Return the addresses of segments: layer and word, as L07-0110."""
        digits = max(2, len(str(self.count - 1)))
        return [f"L{self.layer[k]:0{digits}}-{self.words[k]}" for k in segments.tolist()]

    def spatial(self, points: FloatArray, along: FloatArray | float = 0.0) -> FloatArray:
        """Return (k, 2) points of the plane in space, moved across, mm."""
        flat = points @ self.axes[:2] + self.origin
        return np.asarray(flat + np.asarray(along)[..., None] * self.across)


def read_layers(
    curves: Curve | Sequence[Any],
    count: int | None,
    stagger: bool,
    across: ArrayLike | None,
    tol: Tolerance = DEFAULT,
) -> Layers:
    """Read the curves of a vault.

    Parameters
    ----------
    curves : Curve, or one curve or (n, 3) array of points for each layer
        When there are fewer than layers, they are gone through again and again.
    count : int or None, number of layers
    stagger : bool, split the end segments of every second layer
    across : (3,) floats or None; None takes the normal of the curves' plane

    Raises
    ------
    InputError
        No layer, curves that are straight and no `across`, or that cannot be staggered; layers
        drawn in opposite directions.
    DegenerateSegmentError
        Points that follow each other coincide.
    PlanarityError
        A curve leaves its plane, or the planes are not parallel.
    """
    given = _as_list(curves)
    total = len(given) if count is None else whole_number(count, "The number of layers", 1)
    if len(given) > total:
        raise InputError(f"{len(given)} curves cannot make {total} layers; give at least as many.")
    polylines = [
        _polyline(given[k % len(given)], stagger and k % 2 == 1, k, tol)
        for k in range(min(total, 2 * len(given)))
    ]
    # with an odd number of curves, each is met staggered as well as not
    period = len(given) * (2 if stagger and len(given) % 2 else 1)
    polylines = [polylines[k % period] for k in range(total)]
    layers = _laid(polylines, _normal(polylines, across, tol), tol)
    _require_one_way(layers)
    return layers


@dataclass(frozen=True, eq=False)
class _Polyline:
    points: FloatArray
    words: list[str]
    closed: bool


def _as_list(curves: Curve | Sequence[Any]) -> list[Any]:
    if isinstance(curves, Curve):
        return [curves]
    if isinstance(curves, np.ndarray) and curves.ndim == 2:
        return [curves]
    found = list(curves)
    if not found:
        raise InputError("A vault needs at least one curve.")
    if not isinstance(found[0], Curve) and np.ndim(found[0]) == 1:
        return [found]  # one polyline, written as a list of points
    return found


def _polyline(curve: Any, split: bool, layer: int, tol: Tolerance) -> _Polyline:
    if not isinstance(curve, Curve):
        if split:
            raise InputError(
                f"Layer {layer} is an array of points: only IFS curves can be staggered by one "
                "more construction step. Give each layer its own points instead."
            )
        points = read_points(curve, f"The points of layer {layer}")
        if len(points) < 2:
            raise InputError(f"Layer {layer} needs at least 2 points, got {len(points)}.")
        digits = len(str(len(points) - 2))
        words = [f"{k:0{digits}}" for k in range(len(points) - 1)]
    elif split:
        points, words = _split(curve, layer, tol)
    else:
        points, words = curve.points, curve.addresses
    steps = length(np.diff(points, axis=0))
    if steps.min() <= tol.coincident:
        where = int(steps.argmin())
        raise DegenerateSegmentError(
            f"Points {where} and {where + 1} of layer {layer} coincide. Leave one out, or move "
            "them apart."
        )
    return _Polyline(points, words, _returns(points, tol))


def _returns(points: FloatArray, tol: Tolerance) -> bool:
    """Tell whether a polyline ends where it starts; weights do not matter to planks."""
    return bool(np.abs(points[-1] - points[0]).max() <= tol.coincident)


def _split(curve: Curve, layer: int, tol: Tolerance) -> tuple[FloatArray, list[str]]:
    """Return the points, and the words of the segments, of a staggered layer."""
    if curve.germ is not None or curve.fold is not None:
        raise InputError(
            f"The curve of layer {layer} has a germ of its own or a fold, so one more construction "
            "step does not split its segments. Give each layer its own curve instead of "
            "stagger=True."
        )
    finer = curve.with_depth(curve.depth + 1)
    parts = len(curve.scheme.transformations)
    inner = np.arange(parts // 2, finer.segments, parts)
    words = [finer.addresses[k] for k in inner]
    if _returns(finer.points, tol):
        return finer.points[np.append(inner, inner[0])], words
    ends = [0, *inner.tolist(), finer.segments]
    return finer.points[ends], [finer.addresses[0], *words]


def _normal(polylines: list[_Polyline], across: ArrayLike | None, tol: Tolerance) -> FloatArray:
    if across is not None:
        given = vector(across, "The direction across a vault")
        if not given.any():
            raise InputError("The direction across a vault must not be the zero vector.")
        return unit(given)
    heights = []  # square to the plane of each curve, as long as it rises above its longest chord
    for polyline in polylines:
        arms = polyline.points - polyline.points[0]
        chord = unit(arms[int(length(arms).argmax())])
        moments = cross(chord[None], arms)
        heights.append(moments[int(length(moments).argmax())])
    highest = heights[int(length(np.array(heights)).argmax())]
    if length(highest) <= tol.planar:
        raise InputError(
            "All curves of the vault are straight, so the direction in which the layers follow "
            "each other is open. Give across=(x, y, z)."
        )
    normal = unit(highest)
    return np.asarray(normal * np.sign(normal[int(np.abs(normal).argmax())]))


def _require_one_way(layers: Layers) -> None:
    """Raise when a layer looks like the one before it, drawn from its end to its start.

    Then its area changes its sign and its chord, of which a ring has none, points the other way.
    """
    steps = (layers.points[layers.ends] - layers.points[layers.starts]).T
    sums = [np.asarray(np.bincount(layers.layer, step), dtype=float) for step in steps]
    chords = np.stack(sums, axis=1)
    ring = np.bincount(layers.layer, layers.is_ring) > 0
    turned = ring[1:] | ring[:-1] | (dot(chords[1:], chords[:-1]) < 0)
    against = np.flatnonzero(turned & (layers.areas[1:] * layers.areas[:-1] < 0))
    if len(against):
        raise InputError(
            f"The curve of layer {against[0] + 1} runs against that of layer {against[0]}. Draw "
            "all of them from the same end, rings the same way around."
        )


def _laid(polylines: list[_Polyline], across: FloatArray, tol: Tolerance) -> Layers:
    least = np.eye(3)[int(np.abs(across).argmin())]
    u = unit(cross(across[None], least[None]))[0]
    v = cross(across[None], u[None])[0]
    axes = np.stack([u, v, across])
    origin = polylines[0].points[0]
    sizes = np.array([len(p.words) for p in polylines])
    first_plank = np.concatenate([[0], np.cumsum(sizes)])
    points: list[FloatArray] = []
    columns: dict[str, list[IntArray]] = {
        name: [] for name in ("starts", "ends", "before", "after")
    }
    base = 0
    for number, polyline in enumerate(polylines):
        local = (polyline.points - origin) @ axes.T
        off = float(np.ptp(local[:, 2]))
        if off > tol.planar:
            raise PlanarityError(
                f"The curve of layer {number} leaves the plane square to "
                f"{np.round(across, 6).tolist()} by {off:.3g} mm. Every layer needs a planar "
                "curve, and all planes must be parallel.",
                layer=number,
                deviation=off,
            )
        size, shift = int(sizes[number]), int(first_plank[number])
        rank = np.arange(size)
        ends = rank + 1
        before, after = rank - 1, rank + 1
        if polyline.closed:
            ends[-1] = 0
            before, after = before % size, after % size
        else:
            after[-1] = before[0] = NEVER - shift  # stays NEVER when moved
        points.append(local[: size + (not polyline.closed), :2])
        for name, column in (
            ("starts", rank + base),
            ("ends", ends + base),
            ("before", before + shift),
            ("after", after + shift),
        ):
            columns[name].append(column)
        base += size + (not polyline.closed)
    return Layers(
        origin=origin,
        axes=axes,
        points=np.concatenate(points),
        layer=np.repeat(np.arange(len(polylines)), sizes),
        words=tuple(word for polyline in polylines for word in polyline.words),
        count=len(polylines),
        **{name: np.concatenate(parts) for name, parts in columns.items()},
    )
