"""Heads with two rotary axes: which angles point the tool where it has to point.

The head turns about the vertical (C) and tilts below it (A about x, B about y). By the textbook a
tool that is tilted by B and turned by C points along (sin B cos C, sin B sin C, cos B); by A and C
along (sin A sin C, -sin A cos C, cos A). Some controls count one of the angles the other way
around, LinuxCNC's 5axiskins the tilt.

Every direction is reached twice, with the tilt to either side. Of what the ranges allow, the way
with the least turning is taken; a vertical tool keeps its turn.

Source: section 4.3 (5-axis CNC-machine).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from ifs_cad.errors import InputError, MachineError
from ifs_cad.fabrication.machining.machine import RotaryAxes
from ifs_cad.fabrication.machining.quantity import Span
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import FloatArray

Sign = Literal[-1, 1]


@dataclass(frozen=True)
class RotaryHead:
    """How the angles of a head are counted.

    Parameters
    ----------
    axes : "BC" or "AC", tilt and turn; "none" for a tool that is always upright
    tilt_sign, turn_sign : 1 as in the textbook, -1 for the other way around

    Raises
    ------
    InputError
        Another sign.
    """

    axes: RotaryAxes = "BC"
    tilt_sign: Sign = 1
    turn_sign: Sign = 1

    def __post_init__(self) -> None:
        for name in ("tilt_sign", "turn_sign"):
            if getattr(self, name) not in get_args(Sign):
                raise InputError(f"{name} must be 1 or -1, got {getattr(self, name)!r}.")

    @property
    def letters(self) -> str:
        """The rotary words of a program, tilt first."""
        return "" if self.axes == "none" else self.axes

    def axis(self, tilt: FloatArray, turn: FloatArray) -> FloatArray:
        """Return (..., 3) unit vectors from the tip to the holder for angles in degrees."""
        tilt, turn = self.tilt_sign * np.radians(tilt), self.turn_sign * np.radians(turn)
        if self.axes == "AC":
            turn = turn - np.pi / 2.0
        out = np.sin(tilt)
        return np.stack([out * np.cos(turn), out * np.sin(turn), np.cos(tilt)], axis=-1)

    def angles(self, axes: FloatArray, tol: Tolerance = DEFAULT) -> FloatArray:
        """Return one way to reach each of (n, 3) directions: (n, 2) tilt and turn, degrees.

        The other way is (-tilt, turn + 180). The turn of a vertical tool is NaN.
        """
        level = np.hypot(axes[:, 0], axes[:, 1])
        is_level = level <= tol.parallel
        tilt = np.where(is_level, 0.0, np.degrees(np.arctan2(level, axes[:, 2])))
        turn = np.degrees(np.arctan2(axes[:, 1], axes[:, 0]))
        if self.axes == "AC":
            turn = turn + 90.0
        turns = np.where(is_level, np.nan, self.turn_sign * turn)
        return np.stack([self.tilt_sign * tilt, turns], axis=1)

    def follow(self, axes: FloatArray, tilts: Span, turns: Span, start: float = 0.0) -> FloatArray:
        """Return (n, 2) angles for directions that follow each other, with the least turning.

        Parameters
        ----------
        axes : (n, 3) float, unit vectors
        tilts, turns : ranges, degrees
        start : turn of the head before the first, degrees

        Raises
        ------
        MachineError
            A direction that the ranges do not allow.
        """
        found = np.empty((len(axes), 2))
        here = (0.0, start)
        for row, (tilt, turn) in enumerate(self.angles(axes).tolist()):
            upright = tilt == 0.0
            here = (0.0, here[1]) if upright else _nearest(tilt, turn, here, tilts, turns)
            found[row] = here
        return found


def _nearest(
    tilt: float, turn: float, here: tuple[float, float], tilts: Span, turns: Span
) -> tuple[float, float]:
    """Return the angles within the ranges that are nearest to those of now."""
    slack = np.degrees(DEFAULT.parallel)
    ways = [
        (sign * tilt, turned + 360.0 * around)
        for sign, turned in ((1.0, turn), (-1.0, turn + 180.0))
        if tilts[0] - slack <= sign * tilt <= tilts[1] + slack
        for around in range(
            int(np.ceil((turns[0] - turned) / 360.0)), int((turns[1] - turned) // 360.0) + 1
        )
    ]
    if not ways:
        raise MachineError(
            f"A tilt of {tilt:.2f} and a turn of {turn:.2f} degrees are beyond the head's ranges, "
            f"{tilts[0]:g} to {tilts[1]:g} and {turns[0]:g} to {turns[1]:g}."
        )
    return min(
        ways, key=lambda way: (max(abs(way[0] - here[0]), abs(way[1] - here[1])), abs(way[1]))
    )
