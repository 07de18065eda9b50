"""An input deck for CalculiX: the same model for a second, independent program.

Every quad becomes an S8R, the shell that CalculiX's manual recommends for thin ones, with nodes
of its own in the middles of its sides. At a hinge each panel keeps its own nodes, and `*EQUATION`
ties their displacements, not their rotations. Where joints are rigid, panels share nodes.

CalculiX makes a solid of every shell: a displacement of a node is then the mean over the
thickness, so that a tied edge turns freely about the middle surface, as a hinge should.

Source: G. Dhondt, *CalculiX CrunchiX User's Manual*, sections on eight-node shells, `*EQUATION`
and `*SHELL SECTION`. N, mm, MPa, tonnes.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ifs_cad.errors import InputError
from ifs_cad.files import replaced
from ifs_cad.structure.grid import Grid
from ifs_cad.structure.load import Loads, total_forces
from ifs_cad.structure.model import Model
from ifs_cad.types import BoolArray, FloatArray, IntArray
from ifs_cad.vectors import cross

AXES = np.arange(3)


def export_calculix(model: Model, loads: Loads, path: str | os.PathLike[str]) -> Path:
    """Write a model and its loads as an input deck; run it with ``ccx <name without .inp>``.

    The answer is the displacement of each node, in the order of the deck, and the stresses.

    Parameters
    ----------
    model : Model
    loads : a load, or several to be added
    path : path of the file; its folder is made when missing

    Returns
    -------
    Path of the written file.

    Raises
    ------
    InputError
        Joints that are springs, which CalculiX does not know between shells; nothing is loaded.
    ExportError
        The file could not be written; what stood there before is unchanged.
    """
    if not isinstance(model.joints, str):
        raise InputError(
            "CalculiX has no springs along the edges of shells: a deck can be written for hinges "
            f'or rigid joints, not for joints={model.joints:g}. Use "hinge" or "rigid".'
        )
    forces = total_forces(loads, model.grid, model.surface_weight)
    deck = _Deck(model)
    target = Path(path)
    with replaced(target) as scratch, scratch.open("w", encoding="ascii", newline="\n") as file:
        for line in deck.lines(forces):
            file.write(line + "\n")
    return target


@dataclass(frozen=True, eq=False)
class _Deck:
    """Nodes of S8R elements: those of the grid, then the middles of its quads' sides."""

    model: Model

    @property
    def grid(self) -> Grid:
        return self.model.grid

    @cached_property
    def _sides(self) -> tuple[IntArray, IntArray]:
        """(m, 2) grid nodes at the ends of sides, sorted, and (e, 4) the sides of each quad."""
        quads = self.grid.quads
        ends = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1), axis=-1)
        sides, number = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)
        return sides, number.reshape(quads.shape)

    @cached_property
    def nodes(self) -> FloatArray:
        """(n, 3) float."""
        return np.concatenate([self.grid.nodes, self.grid.nodes[self._sides[0]].mean(axis=1)])

    @cached_property
    def leader(self) -> IntArray:
        """(n,) int, the first of the nodes that lie at the same point."""
        ends = np.sort(self.grid.point[self._sides[0]], axis=1)
        middle = np.unique(ends, axis=0, return_inverse=True)[1].ravel()
        point = np.concatenate([self.grid.point, self.grid.points + middle])
        _, first, number = np.unique(point, return_index=True, return_inverse=True)
        return np.asarray(first[number])

    @property
    def shared(self) -> bool:
        """Whether the panels share nodes."""
        return self.model.joints == "rigid"

    @cached_property
    def elements(self) -> IntArray:
        """(e, 8) int, nodes."""
        own = np.concatenate([self.grid.quads, len(self.grid.nodes) + self._sides[1]], axis=1)
        return self.leader[own] if self.shared else own

    @cached_property
    def held(self) -> BoolArray:
        """(n, 6) bool, the movements and turns of nodes that supports hold."""
        is_held = np.zeros(self.model.size, dtype=bool)
        for held in self.model.held_by:
            is_held[held] = True
        at_ends = is_held[self.model.freedoms]
        sides = self._sides[0]
        # only along edges of panels: a quad in a corner has sides between two of them as well
        steps = np.stack([self.grid.edges[:, :-1], self.grid.edges[:, 1:]], axis=-1)
        count = len(self.grid.nodes)
        keys = np.sort(steps.reshape(-1, 2), axis=1) @ (count, 1)
        on_edge = np.isin(sides @ (count, 1), keys)
        at_middles = at_ends[sides].all(axis=1) & on_edge[:, None]
        return np.concatenate([at_ends, at_middles])

    def lines(self, forces: FloatArray) -> Iterator[str]:
        model = self.model
        used = np.unique(self.elements)
        yield "*HEADING"
        yield f"{len(self.grid.mesh)} panels, {model.thickness:g} mm, joints: {model.joints}"
        yield "*NODE, NSET=NODES"
        yield from _rows("{:d}, {:.9g}, {:.9g}, {:.9g}", used + 1, *self.nodes[used].T)
        yield from self._panels()
        yield from self._material()
        if not self.shared:
            yield from self._ties()
        yield "*BOUNDARY"
        moves = self.held[:, :3] & (self.leader == np.arange(len(self.nodes)))[:, None]
        turns = self.held[:, 3:]
        if self.shared:
            turns = turns & (self.leader == np.arange(len(self.nodes)))[:, None]
        node, axis = np.nonzero(np.concatenate([moves, turns], axis=1))
        yield from _rows("{0:d}, {1:d}, {1:d}", node + 1, axis + 1)
        yield "*STEP"
        yield "*STATIC"
        yield "*CLOAD"
        total = np.zeros_like(self.nodes)
        np.add.at(total, self.leader[: len(forces)], forces)
        node, axis = np.nonzero(total)
        yield from _rows("{:d}, {:d}, {:.9g}", node + 1, axis + 1, total[node, axis])
        yield from ("*NODE FILE, OUTPUT=2D", "U", "*EL FILE", "S")
        yield from ("*NODE PRINT, NSET=NODES", "U", "*END STEP")

    def _panels(self) -> Iterator[str]:
        order = np.argsort(self.grid.face_of_quad, kind="stable")
        starts = np.searchsorted(self.grid.face_of_quad[order], np.arange(len(self.grid.mesh) + 1))
        for face, address in enumerate(self.grid.mesh.addresses):
            yield f"** panel {address.encode('ascii', 'replace').decode()}"
            yield f"*ELEMENT, TYPE=S8R, ELSET=P{face + 1}"
            quads = order[starts[face] : starts[face + 1]]
            elements = self.elements[quads] + 1
            yield from _rows(", ".join(["{:d}"] * 9), quads + 1, *elements.T)

    def _material(self) -> Iterator[str]:
        given, thickness = self.model.stiffness, self.model.thickness
        yield "*MATERIAL, NAME=SHEET"
        if given.is_isotropic:
            yield "*ELASTIC"
            yield f"{given.e_along:.9g}, {given.poisson:.9g}"
        else:
            # through the thickness nothing is known, and nothing depends on it
            yield "*ELASTIC, TYPE=ENGINEERING CONSTANTS"
            constants = (given.e_along, given.e_across, given.e_across, given.poisson, 0.0, 0.0)
            shears = (given.g_plane, given.g_along)
            yield ", ".join(f"{value:.9g}" for value in (*constants, *shears))
            yield f"{given.g_across:.9g}"
        yield "*DENSITY"
        yield f"{self.model.shell.material.density * 1e-12:.9g}"
        fibres = self.model.fibres
        for face in range(len(self.grid.mesh)):
            name = f"P{face + 1}"
            oriented = ""
            if fibres is not None and not given.is_isotropic:
                across = cross(self.grid.mesh.normals[face], fibres[face])
                yield f"*ORIENTATION, NAME={name}"
                yield ", ".join(f"{value:.9g}" for value in (*fibres[face], *across))
                oriented = f", ORIENTATION={name}"
            yield f"*SHELL SECTION, ELSET={name}, MATERIAL=SHEET{oriented}"
            yield f"{thickness:.9g}"

    def _ties(self) -> Iterator[str]:
        followers = np.flatnonzero(self.leader != np.arange(len(self.nodes)))
        node = np.repeat(followers, 3)
        axis = np.tile(AXES, len(followers)) + 1
        line = "*EQUATION\n2\n{0:d}, {1:d}, 1., {2:d}, {1:d}, -1."
        yield from _rows(line, node + 1, axis, self.leader[node] + 1)


def _rows(pattern: str, *columns: Any) -> Iterator[str]:
    lists = [np.asarray(column).tolist() for column in columns]
    return (pattern.format(*row) for row in zip(*lists, strict=True))
