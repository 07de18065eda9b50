"""The finite element model of a shell: degrees of freedom, stiffness, masses, supports.

Panels share the displacements of the points where they meet. Rotations stay each panel's own at a
hinge; a spring couples those about the edge; a rigid joint shares them too.

Degrees of freedom: three displacements of every point, then three rotations of every *turn*, which
is a grid node (hinges, springs) or a point (rigid joints). N, mm, radians, tonnes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

import numpy as np

from ifs_cad.elements.fibre import Fibre
from ifs_cad.elements.material import Stiffness
from ifs_cad.elements.panel import Shell
from ifs_cad.errors import InputError
from ifs_cad.libraries import require
from ifs_cad.progress import report
from ifs_cad.structure.grid import Grid, divide
from ifs_cad.structure.kratos import PURPOSE, load_kratos, shell_stiffness
from ifs_cad.structure.load import GRAVITY
from ifs_cad.structure.support import AXES, Support, Supports, read_supports
from ifs_cad.structure.surface import Surface, surface_of
from ifs_cad.types import FloatArray, IntArray

Joints = Literal["hinge", "rigid"] | float
DIVISIONS = 4
"""Quads along each edge where nothing else is said and nothing is refined. Against 16, deflections
of smooth hinged shells came out up to 3 % too large, of sharply folded ones with panels four times
as long as wide up to 7 % too small; 8 halved that. `converge` looks whether they are enough."""


@dataclass(frozen=True, eq=False)
class Model:
    """A shell ready to be solved. Made by `model_of`.

    Attributes
    ----------
    shell : Shell
    surface : Surface
    grid : Grid
    stiffness : Stiffness
    fibres : (f, 3) float or None, unit vectors in the planes of the polygons
    joints : "hinge", "rigid", or N mm/rad per mm of edge
    supports : tuple of Support
    angles : (e,) float, radians, from the first side of each quad to the fibre
    matrices : (e, 24, 24) float, of the quads, in global axes
    """

    shell: Shell
    surface: Surface
    grid: Grid
    stiffness: Stiffness
    fibres: FloatArray | None = field(repr=False)
    joints: Joints
    supports: tuple[Support, ...]
    angles: FloatArray = field(repr=False)
    matrices: FloatArray = field(repr=False)

    @property
    def thickness(self) -> float:
        """Thickness of the panels, mm."""
        return self.shell.thickness

    @property
    def surface_mass(self) -> float:
        """Mass of the panels per area, t/mm2."""
        return self.shell.material.density * 1e-12 * self.thickness

    @property
    def surface_weight(self) -> float:
        """Weight of the panels per area, N/mm2."""
        return self.surface_mass * GRAVITY * 1e3

    @cached_property
    def extent(self) -> float:
        """The largest extent of the shell along an axis, mm."""
        return float(np.ptp(self.grid.nodes, axis=0).max())

    @cached_property
    def turn(self) -> IntArray:
        """(v,) int, whose rotations each grid node has."""
        return self.grid.point if self.joints == "rigid" else np.arange(len(self.grid.nodes))

    @cached_property
    def freedoms(self) -> IntArray:
        """(v, 6) int, the degrees of freedom of each grid node."""
        axes = np.arange(3)
        moves = 3 * self.grid.point[:, None] + axes
        turns = 3 * (self.grid.points + self.turn[:, None]) + axes
        return np.concatenate([moves, turns], axis=1)

    @cached_property
    def size(self) -> int:
        """Number of degrees of freedom, held ones included."""
        return int(self.freedoms.max()) + 1

    @cached_property
    def held_by(self) -> tuple[IntArray, ...]:
        """The degrees of freedom that each support holds."""
        found = []
        for support in self.supports:
            nodes = np.asarray(support.select(self.surface, self.grid))
            columns = [AXES.index(letter) for letter in support.hold]
            columns += [3 + AXES.index(letter) for letter in support.turn]
            found.append(np.unique(self.freedoms[nodes][:, columns]))
        return tuple(found)

    @cached_property
    def free(self) -> IntArray:
        """Degrees of freedom that no support holds."""
        is_free = np.ones(self.size, dtype=bool)
        for held in self.held_by:
            is_free[held] = False
        return np.flatnonzero(is_free)

    @cached_property
    def springs(self) -> tuple[IntArray, FloatArray]:
        """Springs of the joints: (s, 2) grid nodes, and (s, 3) axes times sqrt(N mm/rad)."""
        if isinstance(self.joints, str) or not self.joints:
            return np.empty((0, 2), dtype=np.int64), np.empty((0, 3))
        mesh, grid = self.grid.mesh, self.grid
        one = np.flatnonzero(mesh.twin > np.arange(len(mesh.twin)))
        pairs = np.stack([grid.edges[one], grid.edges[mesh.twin[one]][:, ::-1]], axis=-1)
        shares = np.full(grid.divisions + 1, 1 / grid.divisions)
        shares[[0, -1]] /= 2
        size = np.sqrt(self.joints * mesh.edge_lengths[one][:, None] * shares)
        axes = size[:, :, None] * mesh.directions[one][:, None, :]
        return pairs.reshape(-1, 2), axes.reshape(-1, 3)

    @cached_property
    def matrix(self) -> Any:
        """Sparse stiffness matrix of all degrees of freedom."""
        return self.assembled(self.matrices, self.springs[1])

    def assembled(self, matrices: FloatArray, axes: FloatArray) -> Any:
        """Sum (e, 24, 24) matrices of quads and (s, 3) axes of springs into a sparse matrix."""
        sparse = require("scipy.sparse", PURPOSE)
        report("assembly")
        of_quad = self.freedoms[self.grid.quads].reshape(len(matrices), 24)
        total = _sum(sparse, of_quad, matrices, self.size)
        if len(axes):
            pairs = self.springs[0]
            of_spring = self.freedoms[pairs][:, :, 3:].reshape(len(pairs), 6)
            stretch = np.concatenate([-axes, axes], axis=1)
            total = total + _sum(
                sparse, of_spring, stretch[:, :, None] * stretch[:, None, :], self.size
            )
        return total

    @cached_property
    def masses(self) -> FloatArray:
        """(size,) float, lumped masses (t) and moments of inertia (t mm2)."""
        mass = self.surface_mass * self.grid.node_areas
        per_node = np.repeat(mass[:, None], 6, axis=1)
        per_node[:, 3:] *= self.thickness**2 / 12
        return np.asarray(np.bincount(self.freedoms.ravel(), per_node.ravel(), self.size), float)

    def vector(self, forces: FloatArray) -> FloatArray:
        """Sum (v, 3) forces on grid nodes into a vector of all degrees of freedom."""
        moves = self.freedoms[:, :3].ravel()
        return np.asarray(np.bincount(moves, np.asarray(forces).ravel(), self.size), float)


def model_of(
    shell: Shell,
    *,
    supports: Supports = "standing",
    joints: Joints = "hinge",
    divisions: int = DIVISIONS,
    fibre: Fibre | None = None,
    stiffness: Stiffness | None = None,
) -> Model:
    """Make the finite element model of a shell.

    Parameters
    ----------
    shell : Shell
    supports : Support, "standing", or several of them
    joints : "hinge", "rigid" or float
        How panels are joined along shared edges; a number is the stiffness of a spring about the
        edge, N mm/rad per mm of edge. Hinges are the paper's assumption.
    divisions : int, quads along each edge of a panel
    fibre : Fibre, optional
        The rule for the fibre directions, instead of the shell's own. One of the two is needed
        for an orthotropic material.
    stiffness : Stiffness, optional
        Instead of that of the shell's material.

    Raises
    ------
    InputError
        The material has no stiffness, or a fibre direction is missing; wrong joints.
    MissingLibraryError
        Kratos is not installed.
    """
    load_kratos()
    stiffness = stiffness or shell.material.stiffness
    if stiffness is None:
        raise InputError(
            f"The stiffness of {shell.material.name} is not known. Give the material one: "
            "Material(..., stiffness=Stiffness.isotropic(9000, 0.3))."
        )
    if joints not in ("hinge", "rigid"):
        if isinstance(joints, str) or not (math.isfinite(joints) and joints >= 0):
            raise InputError(
                'joints must be "hinge", "rigid" or a stiffness from 0 upwards (N mm/rad per mm),'
                f" got {joints!r}."
            )
        joints = float(joints)
    surface = surface_of(shell)
    grid = divide(surface.mesh, divisions)
    fibres = _fibres(shell, surface, stiffness, fibre)
    along = grid.frames[:, 0] if fibres is None else fibres[grid.face_of_quad]
    angles = grid.angles(along)
    matrices = shell_stiffness(grid.corners, shell.thickness, stiffness, angles)
    return Model(
        shell, surface, grid, stiffness, fibres, joints, read_supports(supports), angles, matrices
    )


def _fibres(
    shell: Shell, surface: Surface, stiffness: Stiffness, rule: Fibre | None
) -> FloatArray | None:
    rule = rule or shell.fibre
    if rule is not None:
        return rule.directions(shell.mesh, shell.faces[surface.panels])
    if stiffness.is_isotropic:
        return None
    raise InputError(
        f"{shell.material.name} is stiffer along its fibre, and the shell has no fibre direction. "
        'Give it one with shell.with_fibre(FibreAlongCurve("a")), pass fibre=FibreAlongEdge() here '
        "(ifs-cad analyse: --fibre a), or pass stiffness=Stiffness.isotropic(...)."
    )


def _sum(sparse: Any, freedoms: IntArray, matrices: FloatArray, size: int) -> Any:
    """Sum (k, m, m) matrices on (k, m) degrees of freedom."""
    width = freedoms.shape[1]
    rows = np.repeat(freedoms, width, axis=1).ravel().astype(np.int32)
    columns = np.tile(freedoms, (1, width)).ravel().astype(np.int32)
    return sparse.csc_matrix((matrices.ravel(), (rows, columns)), shape=(size, size))
