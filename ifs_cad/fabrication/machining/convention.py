"""Conventions: what the rotary words of a program mean for the direction of the tool.

Terms
-----
axis : unit vector of the tool, from its tip to its holder.
tilt : the rotary axis that leans the tool, A or B; at 0 the tool is upright.
turn : the rotary axis C, about the vertical.

Source: the kinematics of LinuxCNC (5axiskins), measured on its running joints.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import get_args

import numpy as np

from ifs_cad.errors import InputError
from ifs_cad.fabrication.machining.machine import RotaryAxes
from ifs_cad.fabrication.machining.quantity import choice
from ifs_cad.types import FloatArray


@dataclass(frozen=True)
class Convention:
    """How a controller reads rotary angles and positions.

    Parameters
    ----------
    axes : "BC" or "AC", the rotary words of the machine; "none" when it has none: upright tools
    tilt_sign : 1 or -1; with 1 a positive B leans the tool towards x, a positive A towards -y, as
        the right hand has it, before the turn
    turn_sign : 1 or -1; with 1 a positive C turns counter-clockwise seen from above
    pivot : float or None
        None when positions are those of the tip (tool-centre-point control is on); else the
        distance from the pivot to the gauge line, mm: positions are those of the tip as it would
        be with the tool upright about the same pivot.

    Raises
    ------
    InputError
        Other axes or signs, or a pivot below 0.
    """

    axes: RotaryAxes = "BC"
    tilt_sign: int = -1
    turn_sign: int = 1
    pivot: float | None = None

    def __post_init__(self) -> None:
        if self.axes not in get_args(RotaryAxes):
            raise InputError(f"The rotary axes must be {choice(RotaryAxes)}, got {self.axes!r}.")
        for name, sign in (("tilt_sign", self.tilt_sign), ("turn_sign", self.turn_sign)):
            if sign not in (1, -1):
                raise InputError(f"{name} must be 1 or -1, got {sign!r}.")
        if self.pivot is not None and not 0.0 <= self.pivot < np.inf:
            raise InputError(
                f"The pivot length must be a number of mm from 0, or None, got {self.pivot!r}."
            )

    @property
    def words(self) -> str:
        """The rotary words, tilt first."""
        return "" if self.axes == "none" else self.axes

    def axis(self, angles: FloatArray) -> FloatArray:
        """Return the (..., 3) unit vectors of the tool.

        Parameters
        ----------
        angles : (..., 3) float, degrees, the words A, B and C; what the machine lacks is not read
        """
        if self.axes == "none":
            return np.broadcast_to([0.0, 0.0, 1.0], angles.shape)
        tilt = self.tilt_sign * np.radians(angles[..., "ABC".index(self.axes[0])])
        turn = self.turn_sign * np.radians(angles[..., 2])
        # B leans towards x; A, a quarter turn behind, towards -y
        azimuth = turn if self.axes[0] == "B" else turn - np.pi / 2
        level = np.sin(tilt)
        return np.stack([level * np.cos(azimuth), level * np.sin(azimuth), np.cos(tilt)], axis=-1)

    def tips(self, positions: FloatArray, axes: FloatArray, lengths: FloatArray) -> FloatArray:
        """Return the (..., 3) tips of the tool for the positions in a program.

        Parameters
        ----------
        positions, axes : (..., 3) float, mm and unit vectors
        lengths : (...) float, of the tools below the gauge line, mm
        """
        if self.pivot is None:
            return positions
        upright = np.array([0.0, 0.0, 1.0])
        return np.asarray(positions + (self.pivot + lengths)[..., None] * (upright - axes))

    def lowest(self, heights: FloatArray, angles: FloatArray, lengths: FloatArray) -> FloatArray:
        """Return the (n,) least heights of the tips of tools on their ways, mm.

        Where the control keeps the tip in place it moves evenly, and is lowest at an end. Else it
        swings about a pivot that moves evenly itself, deepest below it where the tool is upright:
        the tip may dip between two ends that are both high.

        Parameters
        ----------
        heights : (n, 2) float, Z in the program at the start and at the end, mm
        angles : (n, 2, 3) float, degrees, the words A, B and C; as `axis` has them
        lengths : (n,) float, of the tools below the gauge line, mm
        """
        if self.pivot is None or self.axes == "none":
            return np.asarray(heights.min(axis=1))
        arms = self.pivot + lengths
        start, end = np.radians(angles[..., "ABC".index(self.axes[0])]).T
        low, high = np.minimum(start, end), np.maximum(start, end)
        rise = heights[:, 1] - heights[:, 0]
        # where Z + arm (1 - cos tilt) does not change: it rises as fast as the swing goes down
        with np.errstate(divide="ignore", invalid="ignore"):
            stationary = np.arcsin(np.clip(-rise / (arms * (end - start)), -1.0, 1.0))
        around = 2.0 * np.pi * np.arange(-1.0, 2.0)
        between = np.clip(stationary[:, None] + around, low[:, None], high[:, None])
        tilts = np.column_stack([start, end, between])
        with np.errstate(divide="ignore", invalid="ignore"):
            shares = (tilts - start[:, None]) / (end - start)[:, None]
        shares[:, :2] = 0.0, 1.0
        ways = heights[:, :1] + shares * rise[:, None] + arms[:, None] * (1.0 - np.cos(tilts))
        return np.asarray(np.fmin.reduce(ways, axis=1))


LINUXCNC = Convention()
"""The BC head of LinuxCNC: axis (-sin B cos C, -sin B sin C, cos B)."""

RIGHT_HANDED_AC = Convention("AC", tilt_sign=1)
"""A right-handed AC head: axis (sin A sin C, -sin A cos C, cos A)."""
