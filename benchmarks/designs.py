"""The designs that are measured: rough in both directions, so that most nodes need relief."""

from __future__ import annotations

from itertools import product

import numpy as np

import ifs_cad as ifs

DEPTH = 4
FINE_DEPTH = 8
THICKNESS = 10.0
PLANK_DEPTH = 5
LAYERS = 30


def mesh(depth: int = DEPTH) -> ifs.Mesh:
    """Return a vault over a rough arch and a rough fold, 4^depth faces.

    It grows with the depth, so that its faces stay as large and its folds as sharp: at every depth
    the panels of 10 mm need as many relief cuts, about one each.
    """
    scale = 2.0 ** (depth - DEPTH)
    across = scale * np.array([(0, 0, 0), (0, 0, 3000), (6000, 0, 3000), (6000, 0, 0)])
    along = scale * np.array([(0, 0, 0), (0, 1500, 700), (0, 3000, 0)])
    arch = ifs.Curve(across, depth=depth).with_roughness(0.2)
    fold = ifs.Curve(along, depth=depth).with_roughness(0.33)
    return ifs.vector_sum(arch, fold)


def shell(depth: int = DEPTH) -> ifs.Shell:
    """Return its panels, relieved."""
    return ifs.thicken(mesh(depth), THICKNESS)


def shell_named_with(digits: str) -> ifs.Shell:
    """Return the same 256 panels under addresses of four digits, each one of the four given."""
    names = ["".join(name) for name in product(digits, repeat=4)]
    return ifs.thicken(mesh().with_addresses(names), THICKNESS)


def vault() -> ifs.Vault:
    """Return 30 layers of 32 planks on a springing plane, all joints on bisector planes."""
    points = [(0, 0, 0), (120, 0, 4000), (6420, 0, 4600), (6000, 0, 0)]
    floor = ifs.Plane((0, 0, 0), (0, 0, 1))
    curve = ifs.Curve(points, depth=PLANK_DEPTH)
    return ifs.vault(curve, 150.0, 27.0, layers=LAYERS, springing=floor)
