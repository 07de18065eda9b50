"""Which workpieces are the same, so that one drawing or one setting of the saw serves them all.

Two workpieces are congruent when one, turned on the table (and turned over, where that is allowed),
covers the other: the middles of their sides, fitted by least squares, lie within the tolerance, and
so does every corner and hole of one from the nearest of the other; the ends of the grain too. For
convex bodies the corners bound the distance of the whole bodies. Everything in a group lies within
the tolerance of its first member, so that errors never add up along a chain.

Engravings do not count.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ifs_cad.elements.arcs import ComplexArray, as_complex
from ifs_cad.errors import InputError
from ifs_cad.fabrication.workpiece import Workpiece
from ifs_cad.tolerance import LARGEST_COORDINATE
from ifs_cad.types import BoolArray, FloatArray, IntArray, frozen


@dataclass(frozen=True, eq=False)
class Member:
    """A workpiece of a group.

    Attributes
    ----------
    index : int, of the workpiece
    sides : (k,) int, its side that lies where the first member has its first, second ...
    turned_over : bool, whether it has to be turned over to cover the first member
    """

    index: int
    sides: IntArray
    turned_over: bool


def congruent_groups(
    workpieces: Sequence[Workpiece],
    tolerance: float = 0.1,
    *,
    turned_over: bool = False,
    holes: bool = True,
) -> tuple[tuple[Member, ...], ...]:
    """Sort workpieces into groups of equal ones.

    Parameters
    ----------
    workpieces : sequence of Workpiece
    tolerance : float, mm, how far corners may be apart
    turned_over : bool, whether a piece may be turned over to fit
    holes : bool, whether holes must lie alike

    Returns
    -------
    Groups in the order of their first members; each workpiece is in one of them.

    Raises
    ------
    InputError
        A tolerance that is negative or no number.
    """
    if not 0.0 <= tolerance < np.inf:
        raise InputError(f"The tolerance of equal pieces must be 0 mm or more, got {tolerance}.")
    shapes = [_shape(workpiece, holes) for workpiece in workpieces]
    kinds: dict[tuple[int, str], list[int]] = {}
    for index, workpiece in enumerate(workpieces):
        kinds.setdefault((len(workpiece.sides), workpiece.material.name), []).append(index)
    groups = [
        group
        for alike in kinds.values()
        for group in _groups(shapes, np.array(alike), tolerance, turned_over)
    ]
    return tuple(sorted(groups, key=lambda group: group[0].index))


@dataclass(frozen=True, eq=False)
class _Shape:
    """What is compared: middles of sides and points, plan as complex numbers about the centre."""

    thickness: float
    middles: ComplexArray
    heights: FloatArray
    plan: ComplexArray
    rest: FloatArray  # height and kind of each point
    reach: float  # of the corners from the centre
    grain: complex  # direction squared, which is the same for its reverse; 0 where it is free

    def overturned(self) -> _Shape:
        """Return it turned over about x; its sides then run the other way round."""
        return _Shape(
            self.thickness,
            np.conj(self.middles[::-1]),
            self.thickness - self.heights[::-1],
            np.conj(self.plan),
            self.rest * (-1.0, 1.0) + (self.thickness, 0.0),
            self.reach,
            self.grain.conjugate(),
        )


def _shape(workpiece: Workpiece, holes: bool) -> _Shape:
    corners = np.concatenate([side.corners for side in workpiece.sides])
    middles = np.array([side.corners.mean(axis=0) for side in workpiece.sides])
    plan = as_complex(middles)
    centre = plan.mean()
    points = [as_complex(corners) - centre]
    rest = [np.column_stack([corners[:, 2], np.zeros(len(corners))])]
    for drill in workpiece.drills if holes else ():
        # Corners and holes, and holes of two diameters, are never near each other.
        kind = LARGEST_COORDINATE + drill.diameter
        for height in (workpiece.thickness, workpiece.thickness - drill.depth):
            points.append(as_complex(drill.points) - centre)
            rest.append(np.tile((height, kind), (len(drill.points), 1)))
    return _Shape(
        workpiece.thickness,
        plan - centre,
        middles[:, 2],
        np.concatenate(points),
        np.concatenate(rest),
        float(np.abs(points[0]).max()),
        0j if workpiece.fibre is None else complex(*workpiece.fibre.tolist()) ** 2,
    )


def _groups(
    shapes: Sequence[_Shape], indices: IntArray, tolerance: float, turned_over: bool
) -> Iterator[tuple[Member, ...]]:
    """Yield groups of workpieces with the same number of sides."""
    middles = np.array([shapes[i].middles for i in indices])
    heights = np.array([shapes[i].heights for i in indices])
    sides = middles.shape[1]
    spokes = np.abs(middles).sum(axis=1)
    by_size = np.argsort(spokes, kind="stable")
    sorted_spokes = spokes[by_size]
    free = np.ones(len(indices), dtype=np.bool_)
    for leader in range(len(indices)):
        if not free[leader]:
            continue
        # When all middles are within the tolerance, so are their distances from the centre.
        slack = sides * tolerance + np.spacing(spokes[leader]) * sides
        low, high = np.searchsorted(
            sorted_spokes, [spokes[leader] - slack, spokes[leader] + slack], side="left"
        )
        near = np.sort(by_size[low : high + 1])
        near = near[free[near]]
        members: dict[int, Member] = {leader: Member(int(indices[leader]), np.arange(sides), False)}
        for over in (False, True) if turned_over else (False,):
            rest = near[[number not in members for number in near.tolist()]]
            shown = np.conj(middles[rest, ::-1]) if over else middles[rest]
            thick = np.array([shapes[indices[i]].thickness for i in rest]).reshape(-1, 1)
            levels = thick - heights[rest, ::-1] if over else heights[rest]
            order = (np.arange(sides) + np.arange(sides)[:, None]) % sides
            fits, turns = _fits(
                middles[leader], heights[leader], shown[:, order], levels[:, order], tolerance
            )
            for number, shift in zip(*(found.tolist() for found in np.nonzero(fits)), strict=True):
                shape = shapes[indices[rest[number]]]
                shape = shape.overturned() if over else shape
                turn = turns[number, shift]
                member = int(rest[number])
                if member not in members and _cover(
                    shapes[indices[leader]], shape, turn, tolerance
                ):
                    chosen = (sides - 1 - order[shift]) if over else order[shift]
                    members[member] = Member(int(indices[member]), frozen(chosen), over)
        free[list(members)] = False
        yield tuple(members[number] for number in sorted(members))


def _fits(
    middles: ComplexArray,
    heights: FloatArray,
    others: ComplexArray,
    levels: FloatArray,
    tolerance: float,
) -> tuple[BoolArray, ComplexArray]:
    """Turn (m, s, k) middles onto (k,) ones: which fit, and the turns as unit numbers."""
    along = (np.conj(others) * middles).sum(axis=2)
    size = np.abs(along)
    turns = np.where(size > 0.0, along / np.where(size > 0.0, size, 1.0), 1.0)
    apart = np.abs(others * turns[..., None] - middles).max(axis=2, initial=0.0)
    higher = np.abs(levels - heights).max(axis=2, initial=0.0)
    return np.asarray(np.maximum(apart, higher) <= tolerance), turns


def _cover(one: _Shape, other: _Shape, turn: complex, tolerance: float) -> bool:
    """Tell whether every point of each shape is near one of the other, and the grain alike."""
    # Grain at an angle a moves its ends by reach sin a, and squared directions by 2 sin a.
    if abs(one.grain - other.grain * turn**2) / 2 * one.reach > tolerance:
        return False
    flat = np.abs(one.plan[:, None] - other.plan * turn)
    steep = one.rest[:, None] - other.rest
    apart = np.sqrt(flat**2 + (steep**2).sum(axis=2))
    return bool(max(apart.min(axis=0).max(), apart.min(axis=1).max()) <= tolerance)
