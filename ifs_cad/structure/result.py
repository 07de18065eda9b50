"""What the structure check answers: deflections, reactions, utilisation, weight."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ifs_cad.structure.load import GRAVITY
from ifs_cad.structure.model import Model
from ifs_cad.structure.section import utilisation
from ifs_cad.types import FloatArray, IntArray
from ifs_cad.vectors import length

MESH_ERROR = 0.02
"""Estimated share of the largest displacement by which a mesh may be off."""
LARGE_MOVEMENT = 0.01  # of the largest extent of a shell, from which linear answers were 20 % off


@dataclass(frozen=True)
class Extreme:
    """A largest value and where it is.

    Attributes
    ----------
    value : float
    address : str, of the panel
    place : (3,) float, mm, before deformation
    """

    value: float
    address: str
    place: tuple[float, float, float]


@dataclass(frozen=True)
class Reaction:
    """What a support gives to the shell.

    Attributes
    ----------
    support : str, its name
    force : (3,) float, N
    """

    support: str
    force: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Result:
    """The shell under its loads.

    Attributes
    ----------
    model : Model
        With `model.grid.nodes`, (v, 3) mm, and `model.grid.quads`, (e, 4).
    displacements : (v, 3) float, of the grid nodes, mm
    rotations : (v, 3) float, radians
    resultants : (e, 8) float
        Mean membrane forces, moments and transverse forces of the quads along and across the
        fibre; see `section.RESULTANTS`.
    forces : (v, 3) float, the loads on the grid nodes, N
    reactions : of each support
    nonlinear : bool, whether equilibrium was found in the deformed shape
    mesh_error : float or None
        By which share of itself the largest displacement may still change with finer quads, as
        `converge` estimates; None where nobody looked.
    """

    model: Model
    displacements: FloatArray = field(repr=False)
    rotations: FloatArray = field(repr=False)
    resultants: FloatArray = field(repr=False)
    forces: FloatArray = field(repr=False)
    reactions: tuple[Reaction, ...]
    nonlinear: bool = False
    mesh_error: float | None = None

    @cached_property
    def deflection(self) -> Extreme:
        """The largest vertical displacement, |u_z|, mm: the number of figure 22."""
        return self._extreme(np.abs(self.displacements[:, 2]))

    @cached_property
    def largest_displacement(self) -> Extreme:
        """The largest displacement in any direction, |u|, mm."""
        return self._extreme(length(self.displacements))

    @cached_property
    def load(self) -> FloatArray:
        """(3,) float, the sum of all loads, N."""
        return np.asarray(self.forces.sum(axis=0))

    @cached_property
    def imbalance(self) -> float:
        """What loads and reactions together fail to cancel, N."""
        given = sum((np.array(one.force) for one in self.reactions), np.zeros(3))
        return float(np.linalg.norm(self.load + given))

    @cached_property
    def weight(self) -> float:
        """Weight of the panels as analysed, N."""
        return self.model.surface_weight * float(self.model.grid.areas.sum())

    @cached_property
    def quad_utilisation(self) -> FloatArray | None:
        """(e,) float, how much of its strength each quad uses; None where none is known."""
        strength = self.model.shell.material.strength
        if strength is None:
            return None
        return utilisation(self.resultants, self.model.thickness, strength)

    @cached_property
    def utilisation(self) -> FloatArray:
        """(p,) float, the largest in each panel, in the order of `model.shell.addresses`.

        Beyond 1 the material fails. NaN where no strength is known, and for panels of which the
        floor leaves too little to be analysed.
        """
        if self.quad_utilisation is None:
            return np.full(len(self.model.shell), np.nan)
        return self._of_panels(self.quad_utilisation, self.model.grid.face_of_quad)

    @cached_property
    def deflections(self) -> FloatArray:
        """(p,) float, the largest |u_z| in each panel, mm; ordered as `utilisation`, NaN alike."""
        return self._of_panels(np.abs(self.displacements[:, 2]), self.model.grid.face_of_node)

    @cached_property
    def largest_utilisation(self) -> Extreme | None:
        """The largest utilisation; beyond 1 the material fails. None where no strength is known."""
        if self.quad_utilisation is None:
            return None
        worst = int(np.argmax(self.quad_utilisation))
        grid = self.model.grid
        place = grid.corners[worst].mean(axis=0)
        address = grid.mesh.addresses[int(grid.face_of_quad[worst])]
        return Extreme(float(self.quad_utilisation[worst]), address, tuple(place.tolist()))

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """What an engineer should look at before believing the numbers."""
        found = []
        size = self.model.extent
        moved = self.largest_displacement.value
        if not self.nonlinear and moved > LARGE_MOVEMENT * size:
            found.append(
                f"it moves by {moved:.0f} mm, {100 * moved / size:.0f} % of its size, where a "
                "linear answer misleads: use analyse_nonlinear"
            )
        if self.mesh_error is not None and self.mesh_error > MESH_ERROR:
            divisions = 2 * self.model.grid.divisions
            found.append(
                f"the mesh is coarse: displacements may be off by {100 * self.mesh_error:.2g} %; "
                f"give divisions={divisions}, which takes some five times as long"
            )
        used = self.largest_utilisation
        if used is not None and used.value > 1:
            found.append("the material fails: more than its strength is used")
        return tuple(found)

    def deformed(self, scale: float = 1.0) -> FloatArray:
        """Return the (v, 3) grid nodes moved by their displacements times a scale, mm."""
        return self.model.grid.nodes + scale * self.displacements

    def __str__(self) -> str:
        """Return the table."""
        model, down = self.model, self.deflection
        most, used = self.largest_displacement, self.largest_utilisation
        joints = model.joints if isinstance(model.joints, str) else f"{model.joints:g} N mm/rad/mm"
        rows = [
            (
                "model",
                f"{len(model.grid.mesh)} panels of {model.grid.divisions} x "
                f"{model.grid.divisions} quads, {model.size} degrees of freedom, joints: {joints}",
            ),
            ("mesh error", _share(self.mesh_error)),
            ("analysis", "in the deformed shape" if self.nonlinear else "linear"),
            ("weight", f"{self.weight / 1e3:.2f} kN, {self.weight / GRAVITY:.0f} kg"),
            ("load", _force(self.load)),
            ("deflection u_z", f"{down.value:.2f} mm in {down.address} {_place(down.place)}"),
            ("displacement", f"{most.value:.2f} mm in {most.address} {_place(most.place)}"),
        ]
        rows += [(f"reaction {one.support}", _force(np.array(one.force))) for one in self.reactions]
        if used is None:
            rows.append(("utilisation", "the strength of the material is not known"))
        else:
            rows.append(("utilisation", f"{used.value:.2f} in {used.address} {_place(used.place)}"))
        rows += [("warning", text) for text in self.warnings]
        width = max(len(name) for name, _ in rows) + 2
        return "\n".join(f"{name:{width}}{value}" for name, value in rows)

    def _of_panels(self, values: FloatArray, faces: IntArray) -> FloatArray:
        """Return the largest value in each panel of the shell, NaN without one."""
        panels = np.full(len(self.model.shell), np.nan)
        np.fmax.at(panels, self.model.surface.panels[faces], values)
        return panels

    def _extreme(self, values: FloatArray) -> Extreme:
        node = int(np.argmax(values))
        grid = self.model.grid
        return Extreme(float(values[node]), grid.address(node), tuple(grid.nodes[node].tolist()))


def _share(error: float | None) -> str:
    if error is None:
        return "not estimated; leave divisions away to have it estimated"
    return f"about {100 * error:.1f} % of the displacement"


def _force(force: FloatArray) -> str:
    x, y, z = force / 1e3
    return f"({x:.3f}, {y:.3f}, {z:.3f}) kN"


def _place(place: tuple[float, float, float]) -> str:
    x, y, z = place
    return f"at ({x:.0f}, {y:.0f}, {z:.0f}) mm"
