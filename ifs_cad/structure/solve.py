"""Factorise once, solve often, and never believe a mechanism.

The stiffness matrix is scaled so that its diagonal is 1, which leaves the smallest eigenvalue a
plain number: how stiff the softest movement is, measured by its own degrees of freedom. Sparse
solvers return 1e11 mm without a word where it is zero, so it is looked at first.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ifs_cad.libraries import require
from ifs_cad.progress import report
from ifs_cad.structure.kratos import PURPOSE
from ifs_cad.structure.mechanism import explain, explain_soft, soft_modes, zero_modes
from ifs_cad.structure.model import Model
from ifs_cad.types import FloatArray

LARGE_SHARE = 0.1  # of a shell's extent, from which a single movement is named as too soft
PROBES = 3  # solutions after which a random vector has turned into the softest movement


def factor(matrix: Any) -> Any:
    """Factorise a sparse symmetric positive definite matrix, which keeps its diagonal pivots.

    Raises
    ------
    RuntimeError
        It is exactly singular.
    """
    linear = require("scipy.sparse.linalg", PURPOSE)
    return linear.splu(
        matrix.tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )


@dataclass(frozen=True, eq=False)
class Factors:
    """A model's stiffness, held and factorised.

    Attributes
    ----------
    model : Model
    """

    model: Model

    @cached_property
    def _matrix(self) -> Any:
        free = self.model.free
        return self.model.matrix[free][:, free].tocsc()

    @cached_property
    def scale(self) -> FloatArray:
        """(free,) float, by which each free degree of freedom is multiplied."""
        return np.asarray(1 / np.sqrt(self._matrix.diagonal()))

    @cached_property
    def scaled(self) -> Any:
        """Sparse stiffness of the free degrees of freedom with a diagonal of ones."""
        by = require("scipy.sparse", PURPOSE).diags(self.scale)
        return (by @ self._matrix @ by).tocsc()

    @cached_property
    def _factors(self) -> Any:
        """The factorised matrix.

        Raises
        ------
        MechanismError
        """
        report("factorisation")
        try:
            factors = factor(self.scaled)
        except RuntimeError:
            raise explain(self.model, *self.mechanisms()) from None
        probe = np.random.default_rng(0).standard_normal(len(self.scale))
        for _ in range(PROBES):
            solution = factors.solve(probe)
            stiffness = float(probe @ solution) / float(solution @ solution)
            probe = solution / np.linalg.norm(solution)
        if not stiffness > self.model.shell.tol.mechanism:
            raise explain(self.model, *self.mechanisms())
        return factors

    def require_stiff(self) -> None:
        """Raise `MechanismError` where the structure moves without resistance."""
        self._factors  # noqa: B018

    def divide(self, scaled: FloatArray) -> FloatArray:
        """Return the scaled displacements under scaled forces, (free,) float."""
        return np.asarray(self._factors.solve(scaled))

    def mechanisms(self) -> tuple[FloatArray, int]:
        """Return the movements without resistance, (size, k), and how many are rigid."""
        return zero_modes(self.model, self.scaled, self.scale)

    def solve(self, forces: FloatArray) -> FloatArray:
        """Return what all degrees of freedom do under (size,) forces.

        Raises
        ------
        MechanismError
            The structure moves without resistance, or almost; says where, and what would hold it.
        """
        free = self.model.free
        wanted = forces[free] * self.scale
        moved = np.zeros(len(forces))
        if not wanted.any():
            return moved
        solution = self.divide(wanted)
        solution += self.divide(wanted - self.scaled @ solution)
        rest = np.linalg.norm(wanted - self.scaled @ solution) / np.linalg.norm(wanted)
        if not rest <= self.model.shell.tol.equilibrium:
            modes, rigid = self.mechanisms()
            if modes.shape[1]:
                raise explain(self.model, modes, rigid)
            raise explain_soft(
                self.model,
                self.soft_modes(forces),
                f"The forces fail to balance by {100 * rest:.2g} % of the loads: the structure is "
                "too soft for the precision of numbers, or joints are much stiffer than panels.",
            )
        moved[free] = solution * self.scale
        return moved

    def soft_modes(self, forces: FloatArray) -> FloatArray:
        """Return the movements, (size, k), by which (size,) forces move something too far."""
        model, wanted = self.model, forces[self.model.free] * self.scale
        limit = LARGE_SHARE * model.extent
        return soft_modes(model, self.divide, self.scaled, self.scale, wanted, limit)
