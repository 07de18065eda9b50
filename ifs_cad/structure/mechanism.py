"""Mechanisms: movements without resistance, found, counted and explained.

A hinged shell is a linkage. What moves without any force is in the null space of the stiffness
matrix, found here by inverse iteration on a block of vectors that grows until it holds more.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.errors import MechanismError
from ifs_cad.libraries import require
from ifs_cad.progress import report
from ifs_cad.structure.kratos import PURPOSE
from ifs_cad.structure.model import Model
from ifs_cad.types import FloatArray

SHIFT = 1e-9  # added to the scaled stiffness, so that it can be factorised
ITERATIONS = 4
FIRST_BLOCK = 12
MOVING_SHARE = 0.5  # of the largest displacement of a mode, beyond which a panel is named


def zero_modes(model: Model, scaled: Any, scale: FloatArray) -> tuple[FloatArray, int]:
    """Return the movements that meet no resistance.

    Parameters
    ----------
    model : Model
    scaled : sparse matrix, stiffness of the free degrees of freedom with a diagonal of ones
    scale : (free,) float, what it was multiplied by on both sides

    Returns
    -------
    (size, k) float, k independent movements of all degrees of freedom; and how many combinations
    of them move the structure as a whole.
    """
    sparse = require("scipy.sparse", PURPOSE)
    linear = require("scipy.sparse.linalg", PURPOSE)
    report("looking for mechanisms")
    size = len(scale)
    factors = linear.splu(
        (scaled + SHIFT * sparse.identity(size)).tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    random = np.random.default_rng(0)
    count = FIRST_BLOCK
    while True:
        count = min(count, size)
        block = np.linalg.qr(random.standard_normal((size, count)))[0]
        for _ in range(ITERATIONS):
            block = np.linalg.qr(factors.solve(block))[0]
        values, turn = np.linalg.eigh(block.T @ (scaled @ block))
        found = values <= model.shell.tol.mechanism
        if not found.all() or count == size:
            break
        count *= 2
    modes = np.zeros((model.size, int(found.sum())))
    modes[model.free] = scale[:, None] * (block @ turn[:, found])
    return modes, _rigid_modes(model)


def _rigid_modes(model: Model) -> int:
    """Return in how many ways the supports let the structure move as a whole."""
    places = model.grid.nodes - model.grid.nodes.mean(axis=0)
    reach = float(np.abs(places).max())
    rigid = np.zeros((model.size, 6))
    for axis in range(3):
        spin = np.zeros(3)
        spin[axis] = 1 / reach
        rigid[model.freedoms[:, axis], axis] = 1.0
        rigid[model.freedoms[:, :3], 3 + axis] = np.cross(spin, places)
        rigid[model.freedoms[:, 3 + axis], 3 + axis] = 1 / reach
    held = np.setdiff1d(np.arange(model.size), model.free)
    if not len(held):
        return 6
    # a held rotation counts as much as a held displacement at the far end
    turns = held >= 3 * model.grid.points
    rows = rigid[held] * np.where(turns, reach, 1.0)[:, None]
    return 6 - int(np.linalg.matrix_rank(rows, tol=model.shell.tol.rank * len(held)))


def explain(model: Model, modes: FloatArray, rigid: int) -> MechanismError:
    """Return the error that says what moves and what would hold it.

    Parameters
    ----------
    model : Model
    modes : (size, k) float
    rigid : int, how many of them move the structure as a whole
    """
    linear = require("scipy.linalg", PURPOSE)
    grid = model.grid
    points = 3 * grid.points
    moves = modes[:points]
    size = np.linalg.norm(moves.reshape(grid.points, 3, -1), axis=(1, 2))
    of_node = size[grid.point]
    largest = np.zeros(len(grid.mesh))
    np.maximum.at(largest, grid.face_of_node, of_node)
    moving = largest > MOVING_SHARE * largest.max()
    names = [grid.mesh.addresses[i] for i in np.argsort(-largest) if moving[i]]
    # the displacements that tell the modes apart best are those whose holding stops them all
    _, _, order = linear.qr(moves.T, mode="economic", pivoting=True)
    node_of = np.zeros(grid.points, dtype=np.int64)
    node_of[grid.point] = np.arange(len(grid.nodes))
    holds, holding = [], []
    for freedom in order[: modes.shape[1]].tolist():
        node, axis = int(node_of[freedom // 3]), "xyz"[freedom % 3]
        place = grid.nodes[node]
        holding.append((tuple(place.tolist()), axis))
        x, y, z = place
        holds.append(f"{axis} at ({x:.0f}, {y:.0f}, {z:.0f}) mm in {grid.address(node)}")
    kinds = []
    if rigid:
        kinds.append(f"{rigid} as a whole")
    if modes.shape[1] > rigid:
        kinds.append(f"{modes.shape[1] - rigid} by folding at its hinges")
    return MechanismError(
        f"The structure moves without resistance in {modes.shape[1]} "
        f"{'ways' if modes.shape[1] > 1 else 'way'} ({', '.join(kinds)}), "
        f"most at {listed(names)}. Holding {listed(holds)} would stop it; so may another support, "
        "a joint with stiffness (joints=...), or folds.",
        addresses=names,
        modes=modes,
        count=modes.shape[1],
        rigid=rigid,
        holding=tuple(holding),
    )
