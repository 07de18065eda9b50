"""Where a shell is held, and against what.

A support holds displacements of some points along the global axes, and rotations about them when
asked: `hold="xyz"` pins, with `turn="xyz"` it clamps, `hold="z"` lets slide.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ifs_cad.design.mesh import Mesh
from ifs_cad.errors import AddressError, InputError
from ifs_cad.structure.grid import Grid
from ifs_cad.structure.surface import Surface
from ifs_cad.types import ArrayLike, BoolArray, FloatArray, IntArray

AXES = "xyz"
SIDES: dict[str, Any] = {
    "a start": np.s_[0, :],
    "a end": np.s_[-1, :],
    "b start": np.s_[:, 0],
    "b end": np.s_[:, -1],
}
"""Borders of a vector sum and where its lattice has them."""
Selection = Callable[[Surface, Grid], IntArray]
"""Takes the surface and its grid, returns numbers of grid nodes."""


@dataclass(frozen=True)
class Support:
    """Points that are held. Made by `standing`, `border`, `edges`, `nodes` or `where`.

    Parameters
    ----------
    name : str
        What results and messages call it.
    select : callable
    hold : str
        The displacements that are held: some of "xyz".
    turn : str
        The rotations that are held: some of "xyz".

    Raises
    ------
    InputError
        Other letters, or nothing held.
    """

    name: str
    select: Selection = field(repr=False)
    hold: str = AXES
    turn: str = ""

    def __post_init__(self) -> None:
        for letters, what in ((self.hold, "hold"), (self.turn, "turn")):
            if not set(letters) <= set(AXES):
                raise InputError(f'{what} must be some of the letters "xyz", got {letters!r}.')
        if not self.hold + self.turn:
            raise InputError(f"The support {self.name!r} holds nothing.")

    @classmethod
    def standing(cls, *, hold: str = AXES, turn: str = "") -> Support:
        """Hold the edges on the floor; without a floor, the lowest border edges."""

        def select(surface: Surface, grid: Grid) -> IntArray:
            found = np.flatnonzero(surface.standing)
            if not len(found):
                raise InputError(
                    "The shell stands on no edge, only on points. Give it a floor, or hold a "
                    'border: Support.border("a start", "a end").'
                )
            return np.unique(grid.edges[found])

        return cls("standing", select, hold, turn)

    @classmethod
    def border(cls, *borders: int | str, hold: str = AXES, turn: str = "") -> Support:
        """Hold designed borders; without any named every border edge.

        Parameters
        ----------
        *borders : str or int
            Of a vector sum of the curves a and b: "a start" is the border on which the first
            curve starts (it runs like b), "a end" that on which it ends; "b start" and "b end"
            likewise. Of any mesh: a number as in `Mesh.chains`.
        """

        def select(surface: Surface, grid: Grid) -> IntArray:
            if not borders:
                return np.unique(grid.edges[surface.mesh.twin < 0])
            chosen = np.concatenate([_border(surface.mesh_of_shell, one) for one in borders])
            found = np.isin(surface.origin, chosen)
            if not found.any():
                raise InputError(f"Nothing is left of the border {borders}: the floor took it.")
            return np.unique(grid.edges[found])

        name = "all borders" if not borders else "border " + ", ".join(map(str, borders))
        return cls(name, select, hold, turn)

    @classmethod
    def edges(
        cls, edges: Mapping[str, int | Sequence[int]], *, hold: str = AXES, turn: str = ""
    ) -> Support:
        """Hold some edges of panels.

        Parameters
        ----------
        edges : {address: number or numbers}
            The edges of each panel's design face, counted from 0 as in `Panel.edge_lengths`.
        """

        def select(surface: Surface, grid: Grid) -> IntArray:
            whole = surface.mesh_of_shell
            face = {address: number for number, address in enumerate(whole.addresses)}
            chosen = []
            for address, sides in edges.items():
                if address not in face:
                    raise AddressError(
                        f"No panel has the address {address!r}.", addresses=[address]
                    )
                number = face[address]
                for side in np.atleast_1d(np.asarray(sides, dtype=np.int64)).tolist():
                    if not 0 <= side < whole.sizes[number]:
                        raise InputError(
                            f"Panel {address} has {whole.sizes[number]} edges, got {side}."
                        )
                    chosen.append(int(whole.offsets[number]) + side)
            found = np.isin(surface.origin, chosen)
            if not found.any():
                raise InputError("None of the edges is left above the floor.")
            return np.unique(grid.edges[found])

        return cls("edges", select, hold, turn)

    @classmethod
    def nodes(cls, places: ArrayLike, *, hold: str = AXES, turn: str = "") -> Support:
        """Hold the points of the finite element mesh nearest to some places.

        Parameters
        ----------
        places : (k, 3) or (3,) float, mm
        """
        points = np.atleast_2d(np.array(places, dtype=float))
        if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
            raise InputError(f"Places must be (k, 3) finite numbers, got shape {points.shape}.")

        def select(surface: Surface, grid: Grid) -> IntArray:
            return np.array([grid.nearest(place) for place in points])

        return cls("nodes", select, hold, turn)

    @classmethod
    def where(
        cls, test: Callable[[FloatArray], BoolArray], *, hold: str = AXES, turn: str = ""
    ) -> Support:
        """Hold the points of the finite element mesh that pass a test.

        Parameters
        ----------
        test : callable
            Takes (v, 3) points, mm; returns (v,) bool.
        """

        def select(surface: Surface, grid: Grid) -> IntArray:
            found = np.flatnonzero(test(grid.nodes))
            if not len(found):
                raise InputError("No point of the finite element mesh passes the support's test.")
            return found

        return cls("where", select, hold, turn)


def _border(mesh: Mesh, border: int | str) -> IntArray:
    """Return the half-edges of a designed border."""
    if isinstance(border, int):
        if not 0 <= border < len(mesh.chains):
            raise InputError(f"There are {len(mesh.chains)} borders, counted from 0; got {border}.")
        return mesh.chains[border]
    whole, vertices = mesh.origin or (mesh, np.arange(len(mesh.vertices)))
    if border not in SIDES:
        raise InputError(f"A border is a number or one of {', '.join(SIDES)}; got {border!r}.")
    if whole.lattice is None:
        raise InputError(
            f"Only a vector sum has the border {border!r}. Give the number of a border, from 0 to "
            f"{len(mesh.chains) - 1}."
        )
    on_side = np.isin(vertices, whole.lattice[SIDES[border]])
    ends = on_side[mesh.corners] & on_side[mesh.corners[mesh.next]]
    found = np.flatnonzero(ends & (mesh.twin < 0))
    if not len(found):
        raise InputError(f"There is no border {border!r}: the curve is closed, or it was left out.")
    return found


Supports = Support | str | Iterable[Support | str]


def read_supports(supports: Supports) -> tuple[Support, ...]:
    """Read one support or several; "standing" stands for `Support.standing()`.

    Raises
    ------
    InputError
    """
    several = [supports] if isinstance(supports, Support | str) else list(supports)
    for one in several:
        if one != "standing" and not isinstance(one, Support):
            raise InputError(f'A support must be a Support or "standing", got {one!r}.')
    return tuple(Support.standing() if isinstance(one, str) else one for one in several)
