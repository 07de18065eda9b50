"""Natural frequencies: how a shell swings by itself."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ifs_cad.elements.fibre import Fibre
from ifs_cad.elements.material import Stiffness
from ifs_cad.elements.panel import Shell
from ifs_cad.errors import InputError
from ifs_cad.libraries import require
from ifs_cad.progress import report
from ifs_cad.structure.kratos import PURPOSE
from ifs_cad.structure.model import DIVISIONS, Joints, Model, model_of
from ifs_cad.structure.solve import Factors
from ifs_cad.structure.support import Supports
from ifs_cad.types import FloatArray


@dataclass(frozen=True, eq=False)
class Modes:
    """Natural frequencies and the shapes that belong to them, the slowest first.

    Attributes
    ----------
    model : Model
    frequencies : (k,) float, Hz
    shapes : (k, v, 3) float, displacements of the grid nodes, the largest of each is 1
    """

    model: Model
    frequencies: FloatArray
    shapes: FloatArray = field(repr=False)

    def __str__(self) -> str:
        """Return the table."""
        rows = enumerate(self.frequencies.tolist(), start=1)
        return "\n".join(f"mode {number:<4}{value:10.3f} Hz" for number, value in rows)


def natural_frequencies(
    shell: Shell,
    count: int = 6,
    *,
    supports: Supports = "standing",
    joints: Joints = "hinge",
    divisions: int = DIVISIONS,
    fibre: Fibre | None = None,
    stiffness: Stiffness | None = None,
) -> Modes:
    """Return the lowest natural frequencies of a shell, by its own mass alone.

    Parameters
    ----------
    shell : Shell
    count : int, how many
    supports, joints, divisions, fibre, stiffness
        As for `analyse`.

    Raises
    ------
    MechanismError
        The structure moves without resistance, so that some frequencies are zero.
    InputError, MissingLibraryError
        As for `analyse`.
    """
    model = model_of(
        shell,
        supports=supports,
        joints=joints,
        divisions=divisions,
        fibre=fibre,
        stiffness=stiffness,
    )
    return modes_of(model, count)


def modes_of(model: Model, count: int = 6) -> Modes:
    """Return the lowest natural frequencies of a model; see `natural_frequencies`."""
    linear = require("scipy.sparse.linalg", PURPOSE)
    factors = Factors(model)
    size = len(model.free)
    if not 1 <= count < size:
        raise InputError(f"count must be from 1 to {size - 1}, got {count}.")
    factors.require_stiff()
    report("natural frequencies")
    # in units in which every mass is 1 the matrix is symmetric and needs no second one
    weight = np.sqrt(model.masses[model.free])
    over = weight * factors.scale
    product = linear.LinearOperator(
        (size, size), matvec=lambda x: factors.scaled @ (x.ravel() / over) / over
    )
    inverse = linear.LinearOperator(
        (size, size), matvec=lambda x: over * factors.divide(over * x.ravel())
    )
    start = np.random.default_rng(0).standard_normal(size)
    values, vectors = linear.eigsh(product, k=count, sigma=0.0, OPinv=inverse, v0=start)
    order = np.argsort(values)
    moved = np.zeros((model.size, count))
    moved[model.free] = vectors[:, order] / weight[:, None]
    shapes = np.moveaxis(moved[model.freedoms[:, :3]], 2, 0)
    largest = np.abs(shapes).max(axis=(1, 2), keepdims=True)
    return Modes(model, np.sqrt(values[order]) / (2 * np.pi), shapes / largest)
