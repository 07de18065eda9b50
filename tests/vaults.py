"""Shells for the tests of kernel and export: small, folded, rough, with relief cuts."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

import ifs_cad as ifs
from ifs_cad.types import Plane

THICKNESS = 10.0
GROUND = Plane((0, 0, 120), (0, 0, 1))
"""Trims the feet of the vault of depth 2."""


@cache
def vault(depth: int = 2, **options: Any) -> ifs.Shell:
    """Return a vault of 4^depth panels of about 375 x 190 x 10 mm, most nodes relieved."""
    scale = 2.0 ** (depth - 4)
    across = scale * np.array([(0, 0, 0), (0, 0, 3000), (6000, 0, 3000), (6000, 0, 0)])
    along = scale * np.array([(0, 0, 0), (0, 1500, 700), (0, 3000, 0)])
    arch = ifs.Curve(across, depth=depth).with_roughness(0.2)
    fold = ifs.Curve(along, depth=depth).with_roughness(0.33)
    return ifs.thicken(ifs.vector_sum(arch, fold), THICKNESS, **options)


def roof(length: float, width: float, angle: float, thickness: float = THICKNESS) -> ifs.Shell:
    """Return two rectangles that fall away from a ridge along y, at an angle in degrees.

    Panel f0001 lies on the side of positive x. On its outer face it is wider by thickness times
    the tangent of the angle.
    """
    x, z = length * np.cos(np.radians(angle)), -length * np.sin(np.radians(angle))
    points = np.array([(-x, 0, z), (0, 0, 0), (x, 0, z)])
    return ifs.thicken(
        ifs.vector_sum(points, [(0, 0, 0), (0, width, 0)], addresses="ifs"), thickness
    )


def plate(length: float, width: float, thickness: float = THICKNESS, **options: Any) -> ifs.Shell:
    """Return one level rectangle, its outer face up."""
    corners = [(0, 0, 0), (length, 0, 0), (length, width, 0), (0, width, 0)]
    return ifs.thicken(ifs.Mesh(corners, [(0, 1, 2, 3)], **options), thickness)


def hexagon(radius: float, thickness: float = THICKNESS) -> ifs.Shell:
    """Return one level regular hexagon, its outer face up."""
    turn = np.pi / 3 * np.arange(6)
    corners = radius * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    return ifs.thicken(ifs.Mesh(corners, [range(6)]), thickness)
