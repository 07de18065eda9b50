"""Equilibrium in the deformed shape, where the linear answer misleads.

Loads grow in steps that keep their directions; each step is solved by Newton's method, and a step
that finds no stable equilibrium is halved. Where no smaller step helps, the shell buckles or snaps
through, and the error says at which share of the load. What comes after is not followed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ifs_cad.elements.fibre import Fibre
from ifs_cad.elements.material import Stiffness
from ifs_cad.elements.panel import Shell
from ifs_cad.errors import InputError, InstabilityError
from ifs_cad.progress import report
from ifs_cad.structure.corotation import (
    Corotation,
    State,
    corotation_of,
    rotation_matrices,
    rotation_vectors,
)
from ifs_cad.structure.load import Loads, total_forces
from ifs_cad.structure.model import DIVISIONS, Joints, Model, model_of
from ifs_cad.structure.result import Result
from ifs_cad.structure.section import resultants
from ifs_cad.structure.solve import Factors, factor
from ifs_cad.structure.solver import reactions
from ifs_cad.structure.support import Supports
from ifs_cad.types import FloatArray

ITERATIONS = 12
HALVINGS = 5
STEPS = 4
LEAP = 4.0  # times the pace of the step before, beyond which a step has snapped through
DIVERGED = 1e6  # times the forces of a step, beyond which an iteration is given up


def analyse_nonlinear(
    shell: Shell,
    *,
    loads: Loads,
    supports: Supports = "standing",
    joints: Joints = "hinge",
    divisions: int = DIVISIONS,
    fibre: Fibre | None = None,
    stiffness: Stiffness | None = None,
    steps: int = STEPS,
) -> Result:
    """Return how a shell carries its loads in equilibrium with its deformed shape.

    Parameters
    ----------
    shell, loads, supports, joints, divisions, fibre, stiffness
        As for `analyse`. Loads keep their directions and sizes.
    steps : int, in how many steps the loads grow at first

    Raises
    ------
    InstabilityError
        The shell buckles or snaps through below the full load; `load_share` is the share of it
        up to which equilibrium was found, to within 1 / (32 steps) of the load, and `deflection`
        (mm) the largest ``|u_z|`` there.
    MechanismError, InputError, MissingLibraryError
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
    return deform(model, loads, steps)


def deform(model: Model, loads: Loads, steps: int = STEPS) -> Result:
    """Return how a model carries its loads in its deformed shape; see `analyse_nonlinear`."""
    if steps < 1:
        raise InputError(f"steps must be 1 or more, got {steps}.")
    forces = total_forces(loads, model.grid, model.surface_weight)
    linear = Factors(model)
    vector = model.vector(forces)
    pace = float(np.linalg.norm(linear.solve(vector)[model.freedoms[:, :3]]))
    path = _Path(model, corotation_of(model.grid.corners, model.matrices), vector, linear.scale)
    shape = _Shape.undeformed(model)
    share, step = 0.0, 1.0 / steps
    while share < 1.0:
        aim = min(1.0, share + step)
        report("load", round(100 * share), 100)
        found = path.equilibrium(shape, aim)
        gone = np.inf if found is None else float(np.linalg.norm(found.moved - shape.moved))
        if found is None or gone > LEAP * pace * (aim - share):
            step /= 2
            if step < 1.0 / steps / 2**HALVINGS:
                raise _instability(model, shape, share)
            continue
        pace = gone / (aim - share)
        shape, share = found, aim
    state = path.state(shape)
    angles, grid = model.angles, model.grid
    return Result(
        model=model,
        displacements=shape.moved,
        rotations=rotation_vectors(shape.turned)[model.turn],
        resultants=resultants(grid, model.matrices, state.strained, angles),
        forces=forces,
        reactions=reactions(model, path.inner(shape, state) - path.forces),
        nonlinear=True,
    )


def _instability(model: Model, shape: _Shape, share: float) -> InstabilityError:
    sunk = np.abs(shape.moved[:, 2])
    node = int(np.argmax(sunk))
    return InstabilityError(
        f"No stable equilibrium beyond {100 * share:.1f} % of the load, where it moves vertically "
        f"by {sunk[node]:.4g} mm in {model.grid.address(node)}: the shell buckles or snaps "
        "through there. Fold it more, make it thicker, stiffen its joints, or load it less.",
        addresses=[model.grid.address(node)],
        load_share=share,
        deflection=float(sunk[node]),
    )


@dataclass(frozen=True, eq=False)
class _Shape:
    """Displacements of the grid nodes, (v, 3) mm, and rotations of the turns, (t, 3, 3)."""

    moved: FloatArray
    turned: FloatArray

    @classmethod
    def undeformed(cls, model: Model) -> _Shape:
        turns = int(model.turn.max()) + 1
        return cls(np.zeros_like(model.grid.nodes), np.tile(np.eye(3), (turns, 1, 1)))

    def changed(self, model: Model, by: FloatArray) -> _Shape:
        """Return the shape after small displacements and spins, (size,)."""
        spins = by[3 * model.grid.points :].reshape(-1, 3)
        return _Shape(
            self.moved + by[model.freedoms[:, :3]], rotation_matrices(spins) @ self.turned
        )


@dataclass(frozen=True, eq=False)
class _Path:
    """What stays the same along the path of loading."""

    model: Model
    quads: Corotation
    forces: FloatArray
    scale: FloatArray

    def state(self, shape: _Shape) -> State:
        grid = self.model.grid
        places = grid.nodes + shape.moved
        turned = shape.turned[self.model.turn]
        return self.quads.state(places[grid.quads], turned[grid.quads])

    def axes(self, shape: _Shape) -> FloatArray:
        """Return the axes of the springs where they are now, (s, 3)."""
        pairs, axes = self.model.springs
        turned = shape.turned[self.model.turn[pairs[:, 0]]]
        return np.asarray(np.einsum("sij,sj->si", turned, axes))

    def inner(self, shape: _Shape, state: State) -> FloatArray:
        """Return the forces that hold all degrees of freedom, (size,)."""
        model = self.model
        of_quad = model.freedoms[model.grid.quads].reshape(-1, 24)
        total = np.asarray(np.bincount(of_quad.ravel(), state.forces.ravel(), model.size), float)
        pairs, still = model.springs
        if len(pairs):
            one, other = np.moveaxis(shape.turned[model.turn[pairs]], 1, 0)
            between = rotation_vectors(one.transpose(0, 2, 1) @ other)
            angle = np.einsum("si,si->s", between, still)
            moment = angle[:, None] * self.axes(shape)
            np.add.at(total, model.freedoms[pairs[:, 1], 3:], moment)
            np.add.at(total, model.freedoms[pairs[:, 0], 3:], -moment)
        return total

    @cached_property
    def _rounding(self) -> float:
        """Scaled forces that numbers cannot tell from zero: positions are rounded."""
        model = self.model
        moves = model.free < 3 * model.grid.points
        reach = float(np.abs(model.grid.nodes).max())
        return float(np.finfo(float).eps * reach * np.linalg.norm(1 / self.scale[moves]))

    def equilibrium(self, start: _Shape, share: float) -> _Shape | None:
        """Return the stable shape under a share of the loads near another, None without one.

        Every shape on the way must be stable too.
        """
        free, tol = self.model.free, self.model.shell.tol.equilibrium
        size = np.linalg.norm(share * self.forces[free] * self.scale)
        shape = start
        for _ in range(ITERATIONS):
            state = self.state(shape)
            rest = (share * self.forces - self.inner(shape, state))[free] * self.scale
            left = np.linalg.norm(rest)
            if not left < DIVERGED * size:
                return None
            factors = self._tangent(shape, state)
            if factors is None or not (factors.U.diagonal() > 0).all():
                return None
            if left <= tol * size + self._rounding:
                return shape
            by = np.zeros(self.model.size)
            by[free] = factors.solve(rest) * self.scale
            shape = shape.changed(self.model, by)
        return None

    def _tangent(self, shape: _Shape, state: State) -> Any:
        free = self.model.free
        matrix = self.model.assembled(state.tangents, self.axes(shape))[free][:, free].tocoo()
        matrix.data *= self.scale[matrix.row] * self.scale[matrix.col]
        try:
            return factor(matrix)
        except RuntimeError:
            return None
