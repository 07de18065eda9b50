"""Mechanisms: movements without resistance, found, counted and explained.

A hinged shell is a linkage. What moves without any force is in the null space of the stiffness
matrix, found here by inverse iteration on a block of vectors that grows until it holds more. What
hardly resists is no mechanism, but its answers are as useless, and it is explained in the same way.
"""

from __future__ import annotations

from collections.abc import Callable
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
        values, vectors = _softest(factors.solve, scaled, random.standard_normal((size, count)))
        found = values <= model.shell.tol.mechanism
        if not found.all() or count == size:
            break
        count *= 2
    modes = np.zeros((model.size, int(found.sum())))
    modes[model.free] = scale[:, None] * vectors[:, found]
    return modes, _rigid_modes(model)


def soft_modes(
    model: Model,
    divide: Callable[[FloatArray], FloatArray],
    scaled: Any,
    scale: FloatArray,
    wanted: FloatArray,
    limit: float,
) -> FloatArray:
    """Return the movements that give way most: those by which loads move something too far.

    Parameters
    ----------
    model : Model
    divide : function that returns scaled displacements, (free, k), under scaled forces
    scaled, scale : as for `zero_modes`
    wanted : (free,) float, the scaled loads
    limit : float
        Displacement in mm from which on a movement counts.

    Returns
    -------
    (size, k) float, at least one movement.
    """
    report("looking for what gives way")
    count = min(FIRST_BLOCK, len(scale))
    start = np.random.default_rng(0).standard_normal((len(scale), count))
    values, vectors = _softest(divide, scaled, start)
    modes = np.zeros((model.size, count))
    shares = (vectors.T @ wanted) / np.maximum(values, np.finfo(float).eps)
    modes[model.free] = scale[:, None] * vectors * shares
    moves = modes[: 3 * model.grid.points].reshape(model.grid.points, 3, -1)
    largest = np.linalg.norm(moves, axis=1).max(axis=0)
    return modes[:, (largest > limit) | (largest == largest.max())]


def _softest(
    divide: Callable[[FloatArray], FloatArray], scaled: Any, block: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the stiffnesses (k,) of the softest movements, and these, (free, k)."""
    block = np.linalg.qr(block)[0]
    for _ in range(ITERATIONS):
        block = np.linalg.qr(divide(block))[0]
    values, turn = np.linalg.eigh(block.T @ (scaled @ block))
    return values, block @ turn


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
    count = modes.shape[1]
    kinds = []
    if rigid:
        kinds.append(f"{rigid} as a whole")
    if count > rigid:
        kinds.append(f"{count - rigid} by folding at its hinges")
    said = f"The structure moves without resistance in {_ways(count)} ({', '.join(kinds)})"
    return _error(model, modes, said, rigid=rigid)


def explain_soft(model: Model, modes: FloatArray, why: str) -> MechanismError:
    """Return the error for what moves almost without resistance.

    Parameters
    ----------
    model : Model
    modes : (size, k) float, as from `soft_modes`
    why : str, sentence that says how that was seen
    """
    ways = _ways(modes.shape[1])
    return _error(model, modes, f"{why} The structure hardly resists moving in {ways}")


def _ways(count: int) -> str:
    return f"{count} way{'s' * (count > 1)}"


def _error(model: Model, modes: FloatArray, said: str, **values: Any) -> MechanismError:
    """Return the error that goes on with the panels that move and with what would hold them."""
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
    return MechanismError(
        f"{said}, most at {listed(names)}. Holding {listed(holds)} would stop it; so may another "
        "support, a joint with stiffness (joints=...), or folds.",
        addresses=names,
        modes=modes,
        count=modes.shape[1],
        holding=tuple(holding),
        **values,
    )
