"""Load cases of one model: the factorisation, which takes most of the time, is done once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ifs_cad.structure.load import Loads, total_forces
from ifs_cad.structure.mechanism import explain_soft
from ifs_cad.structure.model import Model
from ifs_cad.structure.result import Reaction, Result
from ifs_cad.structure.section import resultants
from ifs_cad.structure.solve import Factors
from ifs_cad.types import FloatArray
from ifs_cad.vectors import length


@dataclass(frozen=True, eq=False)
class Solver:
    """A model that answers load cases one after the other."""

    model: Model

    @cached_property
    def _factors(self) -> Factors:
        return Factors(self.model)

    def __call__(self, loads: Loads) -> Result:
        """Return the linear answer to some loads.

        Raises
        ------
        MechanismError
            The structure moves without resistance, or by more than its own size; says where, and
            what would hold it.
        InputError
            Nothing is loaded, or a load cannot be read.
        """
        model = self.model
        forces = total_forces(loads, model.grid, model.surface_weight)
        loaded = model.vector(forces)
        moved = self._factors.solve(loaded)
        of_node = moved[model.freedoms]
        largest = float(length(of_node[:, :3]).max())
        if largest > model.extent:
            raise explain_soft(
                model,
                self._factors.soft_modes(loaded),
                f"A linear answer moves it by {largest:.0f} mm, more than its own size of "
                f"{model.extent:.0f} mm.",
            )
        of_quad = of_node[model.grid.quads].reshape(-1, 24)
        return Result(
            model=model,
            displacements=of_node[:, :3],
            rotations=of_node[:, 3:],
            resultants=resultants(model.grid, model.matrices, of_quad, model.angles),
            forces=forces,
            reactions=reactions(model, model.matrix @ moved - loaded),
        )


def reactions(model: Model, rest: FloatArray) -> tuple[Reaction, ...]:
    """Return what each support gives; where two share a degree of freedom, the first is counted.

    Parameters
    ----------
    model : Model
    rest : (size,) float, forces inside the structure less the loads, N
    """
    left = rest.copy()
    found = []
    for support, held in zip(model.supports, model.held_by, strict=True):
        moves = held[held < 3 * model.grid.points]
        force = np.bincount(moves % 3, left[moves], minlength=3)
        left[moves] = 0.0
        found.append(Reaction(support.name, tuple(force.tolist())))
    return tuple(found)
