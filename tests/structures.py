"""Shells for the tests of the structure room: strips, plates and cylinders of flat panels.

A test module that imports this is skipped where Kratos is not installed.
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest

import ifs_cad as ifs
from ifs_cad.elements.material import Stiffness
from ifs_cad.types import ArrayLike

if find_spec("KratosMultiphysics") is None:
    pytest.skip("Kratos is not installed", allow_module_level=True)

TIMBER = Stiffness.isotropic(9000.0, 0.3)
SLENDER = Stiffness.isotropic(9000.0, 0.0)
"""Without contraction a strip of panels is a beam."""
PLYWOOD = Stiffness(11000.0, 6000.0, 0.05, 600.0, 600.0, 600.0)


def shell_of(a: ArrayLike, b: ArrayLike, thickness: float, **options: Any) -> ifs.Shell:
    """Return the vector sum of two polylines as panels on both sides of it."""
    options = {"side": "centre", "nodes": "plain"} | options
    return ifs.thicken(ifs.vector_sum(a, b), thickness, **options)


def mesh_shell(points: ArrayLike, faces: Any, thickness: float) -> ifs.Shell:
    """Return the panels of a mesh, on both sides of it."""
    mesh = ifs.Mesh(np.array(points, dtype=float), faces)
    return ifs.thicken(mesh, thickness, side="centre", nodes="plain")


def strip(
    length: float, width: float, thickness: float, panels: int = 1, across: int = 1
) -> ifs.Shell:
    """Return level rectangles in a row along x, and `across` of them along y."""
    along = np.linspace((0, 0, 0), (length, 0, 0), panels + 1)
    return shell_of(along, np.linspace((0, 0, 0), (0, width, 0), across + 1), thickness)


def cylinder(
    radius: float, start: float, end: float, panels: int, length: float, rows: int, thickness: float
) -> ifs.Shell:
    """Return flat strips between two angles in degrees (0 is up), along y."""
    turn = np.radians(np.linspace(start, end, panels + 1))
    arc = radius * np.stack([np.sin(turn), 0 * turn, np.cos(turn)], axis=1)
    if np.isclose(abs(end - start), 360):
        arc[-1] = arc[0]
    return shell_of(arc, np.linspace((0, 0, 0), (0, length, 0), rows + 1), thickness)
