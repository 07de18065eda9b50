"""Geometric constraints: lengths, planes, convexity, and panels against sheets of stock.

Source: the paper, section 3.3 (planar timber panels; constraints of production).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ifs_cad.design.connection import Elements
from ifs_cad.design.constraint import (
    Bound,
    Constraint,
    ConstraintResult,
    curve_names,
    judged,
    looks_at,
    positive,
)
from ifs_cad.design.curve import Curve
from ifs_cad.design.fit import sheet_shares
from ifs_cad.design.mesh import Mesh
from ifs_cad.errors import InputError
from ifs_cad.tolerance import DEFAULT
from ifs_cad.types import BoolArray, FloatArray, vector
from ifs_cad.vectors import dot, length

STRAIGHT = 180.0

__all__ = ["Convexity", "MaximumEdge", "MaximumPart", "MinimumEdge", "Planarity"]


@dataclass(frozen=True)
class MinimumEdge:
    """No edge of a mesh, or segment of a curve, may be shorter.

    Parameters
    ----------
    length : float, mm
    """

    length: float

    def __post_init__(self) -> None:
        positive(self.length, "The minimum edge")

    def check(self, design: Any) -> ConstraintResult:
        """Return the result; offenders are faces with such an edge, or segments."""
        return _edges(self, design, "minimum edge", "at least", self.length)


@dataclass(frozen=True)
class MaximumEdge:
    """No edge of a mesh, or segment of a curve, may be longer: bars and planks have a stock length.

    Parameters
    ----------
    length : float, mm
    """

    length: float

    def __post_init__(self) -> None:
        positive(self.length, "The maximum edge")

    def check(self, design: Any) -> ConstraintResult:
        """Return the result; offenders are faces with such an edge, or segments."""
        return _edges(self, design, "maximum edge", "at most", self.length)


@dataclass(frozen=True)
class MaximumPart:
    """Each panel must fit a sheet of stock.

    The design face is measured by the smallest rectangle of the sheet's proportions around it,
    exactly. Folds make panels larger than their design face; `allowance` is for that and the cut.

    Parameters
    ----------
    length, width : float, mm
        Of the sheet.
    fibre : (3,) floats, optional
        A direction in space that the fibre of the panels must follow, so that they are laid with
        it along the sheet's length; without it they may be turned.
    allowance : float, mm
        Added to the panel on all four sides.

    Raises
    ------
    InputError
        Sizes that are not positive, or an allowance that leaves no sheet.
    """

    length: float
    width: float
    fibre: tuple[float, float, float] | None = None
    allowance: float = 0.0

    def __post_init__(self) -> None:
        sides = [positive(self.length, "The sheet's length"), positive(self.width, "Its width")]
        spare = float(vector([self.allowance], "The allowance", 1)[0])
        if not 0.0 <= 2 * spare < min(sides):
            raise InputError(
                f"An allowance of {spare:g} mm on each side must be at least 0 and leave something "
                f"of a sheet {min(sides):g} mm wide."
            )
        if self.fibre is not None and not vector(self.fibre, "The fibre direction").any():
            raise InputError("The fibre direction must not be the zero vector.")

    def check(self, design: Any) -> ConstraintResult:
        """Return the result of a mesh: the largest share of the sheet's sides that a face takes."""
        if not isinstance(design, Mesh):
            looks_at(self, design, "meshes")
        spare = 2 * self.allowance
        size = (self.length - spare, self.width - spare)
        fibre = None if self.fibre is None else vector(self.fibre, "The fibre direction")
        shares = sheet_shares(design, size, fibre)
        note = f"on sheets of {self.length:g} x {self.width:g} mm"
        if spare:
            note += f" less {self.allowance:g} mm on each side"
        if fibre is not None:
            note += ", fibre along the length"
        return judged(
            "largest part",
            shares,
            "at most",
            1.0,
            lambda bad: design.names(np.flatnonzero(bad)),
            unit="of the sheet",
            slack=design.tol.rank,
            note=note,
        )


@dataclass(frozen=True)
class Planarity:
    """Each face of a mesh must be planar, a curve as a whole.

    Parameters
    ----------
    distance : float, mm
        How far a point may be from the plane.
    """

    distance: float = DEFAULT.planar

    def __post_init__(self) -> None:
        positive(self.distance, "The distance from the plane")

    def check(self, design: Any) -> ConstraintResult:
        """Return the result; offenders are faces, or the segments of a curve that leave its plane.

        The plane of a curve is the one with the smallest sum of squared distances.
        """
        if isinstance(design, Mesh):
            return self._judged(design.planarity, lambda bad: design.names(np.flatnonzero(bad)))
        if not isinstance(design, Curve):
            looks_at(self, design, "curves and meshes")
        off = np.abs(_heights(design.points))
        return self._judged(np.maximum(off[1:], off[:-1]), lambda bad: curve_names(design, bad))

    def _judged(self, off: FloatArray, names: Any) -> ConstraintResult:
        return judged("planarity", off, "at most", self.distance, names, unit="mm")


@dataclass(frozen=True)
class Convexity:
    """Faces must be convex, and a curve must turn one way.

    Parameters
    ----------
    angle : float, degrees
        Largest angle inside a face, or on the hollow side of a curve; 180 by default. Less asks
        for corners that are not nearly straight.
    """

    angle: float = STRAIGHT

    def __post_init__(self) -> None:
        if positive(self.angle, "The largest angle") > STRAIGHT:
            raise InputError(f"The largest angle is at most 180 degrees, got {self.angle!r}.")

    def check(self, design: Any) -> ConstraintResult:
        """Return the result; offenders are faces, or the segments that meet at such an angle.

        A curve is seen square to its best plane.
        """
        if isinstance(design, Mesh):
            return self._judged(
                STRAIGHT - _mesh_turns(design),
                lambda bad: design.names(design.face[bad]),
            )
        if not isinstance(design, Curve):
            looks_at(self, design, "curves and meshes")
        return self._judged(
            STRAIGHT - _curve_turns(design.points, design.is_closed),
            lambda bad: curve_names(design, _either_side(bad, design.segments)),
        )

    def _judged(self, angles: FloatArray, names: Any) -> ConstraintResult:
        slack = float(np.degrees(DEFAULT.parallel))
        return judged(
            "convexity", angles, "at most", self.angle, names, unit="degrees", slack=slack
        )


def _edges(
    constraint: Constraint, design: Any, name: str, bound: Bound, limit: float
) -> ConstraintResult:
    """Judge the lengths of edges, segments, or the strokes of elements."""
    if isinstance(design, Mesh):
        sizes = design.edge_lengths

        def names(bad: BoolArray) -> list[str]:
            return design.names(design.face[bad])
    elif isinstance(design, Curve):
        sizes = length(np.diff(design.points, axis=0))

        def names(bad: BoolArray) -> list[str]:
            return curve_names(design, bad)
    elif isinstance(design, Elements):
        steps = np.linalg.norm(np.diff(design.points, axis=1), axis=2)
        sizes = steps.ravel()

        def names(bad: BoolArray) -> list[str]:
            which = np.flatnonzero(bad.reshape(steps.shape).any(axis=1))
            return [design.addresses[number] for number in which]
    else:
        looks_at(constraint, design, "curves, meshes and elements")
    slack = design.tol.coincident
    return judged(name, sizes, bound, limit, names, unit="mm", slack=slack)


def _plane(points: FloatArray) -> FloatArray:
    """Return the (3,) unit normal of the best plane of (n, 3) points."""
    return np.asarray(np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][-1])


def _heights(points: FloatArray) -> FloatArray:
    """Return (n,) distances of points from their best plane, on both sides of it."""
    return np.asarray((points - points.mean(axis=0)) @ _plane(points))


def _mesh_turns(mesh: Mesh) -> FloatArray:
    """Return (corners,) degrees by which a face turns at each corner, to the left positive."""
    back = mesh.directions[mesh.previous]
    sine = dot(np.cross(back, mesh.directions), mesh.normals[mesh.face])
    return np.degrees(np.arctan2(sine, dot(back, mesh.directions)))


def _curve_turns(points: FloatArray, closed: bool) -> FloatArray:
    """Return degrees by which a curve turns at its inner points, its usual way positive."""
    steps = np.diff(points, axis=0)
    if closed:
        steps = np.vstack([steps, steps[:1]])
    sine = np.cross(steps[:-1], steps[1:]) @ _plane(points)
    turns = np.degrees(np.arctan2(sine, dot(steps[:-1], steps[1:])))
    return turns if turns.sum() >= 0.0 else -turns


def _either_side(bad: BoolArray, segments: int) -> BoolArray:
    """Return (segments,) which of them meet at bad points; point i ends segment i."""
    chosen = np.zeros(segments, dtype=bool)
    at = np.flatnonzero(bad)
    chosen[at] = chosen[(at + 1) % segments] = True
    return chosen
