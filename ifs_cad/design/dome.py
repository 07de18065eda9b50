"""Domes: vector sums of which every node is exact.

A *dome* is the weighted vector sum of a *ring*, a horizontal polygon, and a *profile* in a plane
through the z axis. The edges of the ring are all tangent to one circle about the axis, and the
weights are 1/r, r the distance from the axis; so the ring shrinks and grows with the profile, and
all its copies keep their tangent circles about the axis. Then every node is conical: the offset
planes of the faces around it meet in one point at any thickness, and panels need no relief.

Terms
-----
azimuth : angle about the z axis from the plane of the profile, counter-clockwise seen from above,
    degrees.
side : one segment of the ring and the strip of faces over it; all face normals of a side have the
    same azimuth.
meridian : the polyline between two sides; the profile, scaled in its radii.

Source: the paper, section 3.4 (weighted vector sums); section 4.2 builds panels that only such
designs let meet exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ifs_cad.design.address import Structure
from ifs_cad.design.mesh import Mesh
from ifs_cad.design.reading import whole_number
from ifs_cad.design.surface import DiscreteCurve, read_curve, vector_sum
from ifs_cad.errors import DomeError, InputError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import ArrayLike, FloatArray, vector

FULL_TURN = 360.0
RIGHT_ANGLE = 90.0

__all__ = ["dome"]


@dataclass(frozen=True, eq=False)
class _Weighted:
    """A discrete curve of given homogeneous points."""

    homogeneous: FloatArray
    word_structure: Structure


def dome(
    profile: DiscreteCurve | ArrayLike | Any,
    azimuths: ArrayLike | None = None,
    *,
    sides: int | None = None,
    sweep: float = FULL_TURN,
    addresses: Literal["ifs", "lexicographic"] = "ifs",
    tol: Tolerance = DEFAULT,
) -> Mesh:
    """Turn a profile about the z axis into a mesh of which every node is exact.

    The dome begins in the plane of the profile and runs counter-clockwise, seen from above. It
    meets that plane in the profile itself. Row i of the faces is side i, column j segment j of the
    profile. The normals point outwards when the profile is drawn from the foot up.

    Parameters
    ----------
    profile : Curve, (n, 3) array of points in mm, or cadquery Wire of straight edges
        On one side of the z axis, in a plane through it. Its own weights shape the curve, but not
        the dome.
    azimuths : (sides,) array, degrees, optional
        Directions of the sides' normals, each less than 180 from the one before. A meridian lies
        halfway between two of them; the meridians must increase, the azimuths need not, so that
        a dome may be folded.
    sides : int, optional
        Number of equal sides, instead of azimuths.
    sweep : float, degrees
        How far the dome turns, up to 360, which closes it.
    addresses : "ifs" or "lexicographic"
        Words over the transformation alphabet, the side as last digit; or side.segment.

    Returns
    -------
    Mesh

    Raises
    ------
    InputError
        Neither or both of azimuths and sides, numbers that are not finite, a sweep out of range,
        or a profile that is not a curve.
    DomeError
        A profile that leaves its plane, or touches or crosses the axis; neighbouring sides that
        turn by 180 degrees or more; azimuths that leave no room for a side.

    References
    ----------
    The paper, section 3.4. Scale-translational surfaces: Glymph, Shelden, Ceccato, Mussel and
    Schober, A parametric strategy for free-form glass structures, 2004.
    """
    points, structure = read_curve(profile, "profile")
    radii, heights, forward = _radii_and_heights(points[:, 1:] / points[:, :1], tol)
    ring = _ring(azimuths, sides, sweep)
    around = ring @ np.array([forward, [-forward[1], forward[0]]])
    scale = radii[0]  # keeps the weights near 1
    first = around[0]
    weighted_profile = _homogeneous(scale / radii, np.tile(first, (len(radii), 1)), heights, scale)
    weighted_ring = _homogeneous(
        np.ones(len(around)), around, np.full(len(around), heights[0]), scale
    )
    return vector_sum(
        _Weighted(weighted_ring, ((), (len(ring) - 1,))),
        _Weighted(weighted_profile, structure),
        addresses=addresses,
        tol=tol,
    )


def _homogeneous(
    weights: FloatArray, around: FloatArray, heights: FloatArray, scale: float
) -> FloatArray:
    """Return (n, 4) points: with weight scale/r, w times r times (x, y) is scale times (x, y)."""
    return np.column_stack([weights, scale * around, weights * heights])


def _radii_and_heights(
    points: FloatArray, tol: Tolerance
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the radii and heights of a profile, and the (2,) unit vector to its side."""
    level = points[:, :2]
    furthest = level[int(np.argmax(np.linalg.norm(level, axis=1)))]
    reach = float(np.linalg.norm(furthest))
    if reach <= tol.coincident:
        raise DomeError("The profile lies on the z axis. Move it away from the axis.", radius=0.0)
    forward = furthest / reach
    aside = np.abs(level @ np.array([-forward[1], forward[0]]))
    if aside.max() > tol.planar:
        raise DomeError(
            f"The profile leaves its plane through the z axis by {aside.max():.6g} mm at point "
            f"{int(aside.argmax())}. Draw it in such a plane, as points (radius, 0, height).",
            deviation=float(aside.max()),
        )
    radii = level @ forward
    if radii.min() <= tol.coincident:
        raise DomeError(
            f"The profile comes as near to the z axis as {radii.min():.6g} mm at point "
            f"{int(radii.argmin())}. Stay on one side of the axis; leave an opening at the top.",
            radius=float(radii.min()),
        )
    return radii, points[:, 2], forward


def _ring(azimuths: ArrayLike | None, sides: int | None, sweep: float) -> FloatArray:
    """Return (sides + 1, 2) corners of the ring; the first axis meets it at distance 1."""
    turn = float(vector([sweep], "The sweep of a dome", 1)[0])
    if not 0.0 < turn <= FULL_TURN:
        raise InputError(f"The sweep of a dome must be above 0 and at most 360, got {turn:g}.")
    normals = _azimuths_of_normals(azimuths, sides, turn)
    closed = turn == FULL_TURN
    start = (normals[0] + normals[-1] - FULL_TURN) / 2 if closed else 0.0
    meridians = np.array([start, *(normals[1:] + normals[:-1]) / 2, start + turn])
    before, after = normals - meridians[:-1], meridians[1:] - normals
    spread = np.maximum(np.abs(before), np.abs(after))
    if (spread >= RIGHT_ANGLE).any():
        raise DomeError(
            f"Side {int(spread.argmax())} has a border {spread.max():.6g} degrees from its normal; "
            "it must be less than 90, so neighbouring sides turn by less than 180. Add sides.",
            angle=float(spread.max()),
        )
    if (np.diff(meridians) <= 0.0).any():
        side = int(np.diff(meridians).argmin())
        raise DomeError(
            f"Side {side} would run backwards, from {meridians[side]:.6g} to "
            f"{meridians[side + 1]:.6g} degrees. Increase the azimuths, within a sweep of "
            f"{turn:g} degrees."
        )
    # distance 1 is where the profile is: on the side that is met at azimuth 0
    profile = start + (-start % FULL_TURN)
    met = int(np.searchsorted(meridians[1:-1], profile, side="right"))
    inscribed = float(np.cos(np.radians(profile - normals[met])))
    distances = inscribed / np.cos(np.radians(np.append(before, after[-1])))
    angles = np.radians(meridians)
    ring: FloatArray = distances[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    if closed:
        ring[-1] = ring[0]
    return ring


def _azimuths_of_normals(azimuths: ArrayLike | None, sides: int | None, sweep: float) -> FloatArray:
    if (azimuths is None) == (sides is None):
        raise InputError("A dome needs either its number of sides or the azimuths of its sides.")
    if azimuths is not None:
        return vector(azimuths, "The azimuths of a dome", max(np.size(azimuths), 1))
    count = whole_number(sides, "The number of sides of a dome", 1)
    return np.asarray((np.arange(count) + 0.5) * (sweep / count), dtype=float)
