"""From a pointer on the screen to a place for the point that it holds.

A screen has two dimensions and a place three, so the third comes from a rule: the curve's own
plane by default, which keeps a flat curve flat.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from ifs_cad.studio.plane import CurvePlane
from ifs_cad.types import FloatArray

Rule = Literal["plane of the curve", "plane of the screen", "along x", "along y", "along z"]
RULES: tuple[Rule, ...] = get_args(Rule)

GRAZING = np.sin(np.radians(5.0))
"""Where the line of sight is flatter to a plane or axis than this, it is not followed there."""

FARTHEST = 4.0
"""No point is dragged so many times as far from the eye as it was."""

DECIMALS = 6  # of mm: finer than any hand, and free of the noise of the computation

AXES: dict[Rule, FloatArray] = {
    "along x": np.array([1.0, 0.0, 0.0]),
    "along y": np.array([0.0, 1.0, 0.0]),
    "along z": np.array([0.0, 0.0, 1.0]),
}

__all__ = ["RULES", "Grip", "Rule"]


@dataclass(frozen=True, eq=False)
class Grip:
    """How a point is held from pressing the mouse to releasing it.

    Parameters
    ----------
    start : (3,) float, mm
        Where the point was.
    grabbed : (3,) float, mm
        Where the pointer took its marker.
    plane : CurvePlane
        Of its curve.
    rule : str
    """

    start: FloatArray
    grabbed: FloatArray
    plane: CurvePlane
    rule: Rule = "plane of the curve"

    def place(self, pointer: FloatArray, eye: FloatArray) -> FloatArray:
        """Return (3,) float, mm: where the point goes.

        Parameters
        ----------
        pointer : (3,) float, mm
            On the plane through `grabbed` that is parallel to the screen.
        eye : (3,) float, mm
            Where the camera is.
        """
        target = pointer + (self.start - self.grabbed)
        sight = target - eye
        sight = sight / np.linalg.norm(sight)
        if self.rule in AXES:
            target = self._on_axis(AXES[self.rule], target, eye, sight)
        elif self.rule == "plane of the curve" and self.plane.is_exact:
            target = self._on_plane(target, eye, sight)
        return np.round(target, DECIMALS) + 0.0  # no -0.0 in a design file

    def _on_plane(self, target: FloatArray, eye: FloatArray, sight: FloatArray) -> FloatArray:
        normal = self.plane.normal
        apart = (self.start - eye) @ normal
        away = float(np.linalg.norm(self.start - eye))
        steep = sight @ normal
        # asked at the start, so that one drag is of one kind
        if abs(apart) > GRAZING * away and steep * apart > 0.0:
            way = apart / steep
            if way < FARTHEST * away:
                return np.asarray(eye + way * sight)
        return np.asarray(target - (target - self.start) @ normal * normal)

    def _on_axis(
        self, axis: FloatArray, target: FloatArray, eye: FloatArray, sight: FloatArray
    ) -> FloatArray:
        """Return the place on the axis through the start that is nearest to the line of sight."""
        across = 1.0 - (sight @ axis) ** 2
        if across <= GRAZING**2:
            return np.asarray(self.start + (target - self.start) @ axis * axis)
        away = eye - self.start
        along = (away @ axis - (away @ sight) * (sight @ axis)) / across
        return np.asarray(self.start + along * axis)
