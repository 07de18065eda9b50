"""The even fold: a last construction step after which all segments are equally steep.

A planar curve is folded by giving each of its segments a subdivision point of its own. A segment
with the extents (H, Z), H horizontal and Z vertical, is split at h = (H + Z/k)/2 and rise k h;
its two halves then have the slopes k and -k exactly. No fixed transformation does this at every
depth, so it comes after the scheme's steps. In a vector sum with a curve in a perpendicular plane
such folds make every node exact: the offset planes of all panels meet in one point.

Terms
-----
up : the direction that slopes are measured against.
slope : rise over run, k; its sign says whether a segment rises or falls first.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.errors import FoldError, InputError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import BoolArray, FloatArray, vector

__all__ = ["EvenFold"]


@dataclass(frozen=True)
class EvenFold:
    """The fold that gives all segments of a planar curve the same absolute slope.

    Parameters
    ----------
    slope : float
        k, rise over run, not zero; negative begins with a valley.
    up : (3,) floats
        Any length but zero; kept as a unit vector.

    Raises
    ------
    InputError
        A slope or direction that is zero or not finite.
    """

    slope: float
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        slope = float(vector([self.slope], "The slope of an even fold", 1)[0])
        up = vector(self.up, "The up direction of an even fold")
        length = float(np.linalg.norm(up))
        if slope == 0.0 or length == 0.0:
            raise InputError("An even fold needs a slope and an up direction other than zero.")
        object.__setattr__(self, "slope", slope)
        object.__setattr__(self, "up", tuple((up / length).tolist()))

    def applied(
        self,
        homogeneous: FloatArray,
        named: Callable[[BoolArray], list[str]],
        tol: Tolerance = DEFAULT,
    ) -> FloatArray:
        """Return the folded curve.

        Parameters
        ----------
        homogeneous : (n + 1, 4) float
            Points (w, xw, yw, zw) of the curve before the fold.
        named : callable
            Gives the addresses of chosen segments, for messages.

        Returns
        -------
        (2 n + 1, 4) float
            A new point within each segment, its weight the mean of the ends' weights.

        Raises
        ------
        FoldError
            A curve that leaves the plane, runs back, or is as steep as the fold; names the
            segments and the least slope that works.
        """
        weights, up = homogeneous[:, 0], np.array(self.up)
        points = homogeneous[:, 1:] / weights[:, None]
        heights = (points - points[0]) @ up
        forward = self._forward(points - points[0] - heights[:, None] * up, tol)
        runs, rises = np.diff((points - points[0]) @ forward), np.diff(heights)
        self._require_gentler(runs, rises, named, tol)
        share = (runs + rises / self.slope) / 2
        folded = np.empty((2 * len(points) - 1, 4))
        folded[::2] = homogeneous
        folded[1::2, 0] = (weights[1:] + weights[:-1]) / 2
        split = points[:-1] + share[:, None] * (forward + self.slope * up)
        folded[1::2, 1:] = split * folded[1::2, :1]
        return folded

    def _forward(self, level: FloatArray, tol: Tolerance) -> FloatArray:
        """Return the horizontal direction in which the curve runs, from its level offsets."""
        reach = np.linalg.norm(level, axis=1)
        furthest = int(reach.argmax())
        if reach[furthest] <= tol.coincident:
            raise FoldError(
                f"An even fold needs a curve that runs across its up direction {self.up}; this "
                "one stands upright."
            )
        forward = level[furthest] / reach[furthest]
        aside = np.linalg.norm(level - np.outer(level @ forward, forward), axis=1).max()
        if aside > tol.planar:
            raise FoldError(
                "An even fold needs a curve in a plane that contains its up direction "
                f"{self.up}; this one leaves that plane by {aside:.6g} mm.",
                deviation=float(aside),
            )
        return np.asarray(forward if level[-1] @ forward >= 0.0 else -forward)

    def _require_gentler(
        self,
        runs: FloatArray,
        rises: FloatArray,
        named: Callable[[BoolArray], list[str]],
        tol: Tolerance,
    ) -> None:
        """Raise unless all segments run forward and are less steep than the fold."""
        back = runs <= tol.coincident
        if back.any():
            words = named(back)
            raise FoldError(
                f"Segments {listed(words)} run back or stand upright; an even fold needs a curve "
                "that runs one way across its up direction.",
                addresses=words,
            )
        slopes = np.abs(rises) / runs
        steep = slopes >= abs(self.slope)
        if steep.any():
            words = named(steep)
            least = float(slopes.max())
            raise FoldError(
                f"Segments {listed(words)} are as steep as the fold, or steeper. The slope of the "
                f"fold is {abs(self.slope):.6g}; it must be above {least:.6g}.",
                addresses=words,
                least_slope=least,
            )
