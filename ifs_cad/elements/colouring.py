"""Elements coloured by a quantity: a value for each becomes a colour, the scale a legend.

Whatever shows elements (pictures, the viewer, pages for the workshop) takes its colours from here,
so one value has one colour everywhere. The scale is viridis, whose equal steps look equal, also to
the colour-blind and in grey print.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ifs_cad.elements.element import Elements
from ifs_cad.elements.panel import Shell
from ifs_cad.elements.vault import Vault
from ifs_cad.errors import InputError
from ifs_cad.types import FloatArray

Bytes = NDArray[np.uint8]

VIRIDIS = np.array(
    [
        (68, 1, 84),
        (71, 44, 122),
        (59, 81, 139),
        (44, 113, 142),
        (33, 144, 141),
        (39, 173, 129),
        (92, 200, 99),
        (170, 220, 50),
        (253, 231, 37),
    ]
)
APART = np.array(  # Okabe and Ito: told apart by the colour-blind too
    [
        (230, 159, 0),
        (86, 180, 233),
        (0, 158, 115),
        (240, 228, 66),
        (0, 114, 178),
        (213, 94, 0),
        (204, 121, 167),
        (153, 153, 153),
    ]
)
PALER = (1.0, 0.65, 0.4)  # rounds of the same colours, mixed with white
UNKNOWN = (190, 190, 190)
SHADES = 64


@dataclass(frozen=True, eq=False)
class Colouring:
    """A value for each element, and how it is coloured.

    Parameters
    ----------
    title : str
        What the legend says, with the unit: "area, m2".
    values : (p,) float
        One for each element; NaN where nothing is known. With names, their numbers.
    names : sequence of str
        What the values number; each gets a colour of its own. Without names they are a scale.
    low, high : float, optional
        The ends of the scale; the extremes of the values by default.

    Raises
    ------
    InputError
        No value at all, or a number that has no name.
    """

    title: str
    values: FloatArray = field(repr=False)
    names: tuple[str, ...] = ()
    low: float | None = None
    high: float | None = None

    def __post_init__(self) -> None:
        values = np.array(self.values, dtype=float)
        known = values[np.isfinite(values)]
        if values.ndim != 1 or not known.size:
            raise InputError(f"Nothing is known of {self.title}: no element has a value.")
        if self.names and not (known.min() >= 0 and known.max() < len(self.names)):
            raise InputError(f"The values of {self.title} must number its {len(self.names)} names.")
        values.setflags(write=False)
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "names", tuple(self.names))
        for name, default in (("low", known.min()), ("high", known.max())):
            given = getattr(self, name)
            object.__setattr__(self, name, float(default if given is None else given))

    @property
    def range(self) -> tuple[float, float]:
        """The values at the ends of the scale."""
        assert self.low is not None
        assert self.high is not None
        return self.low, self.high

    @property
    def colours(self) -> Bytes:
        """(p, 3) uint8, of each element; grey where nothing is known."""
        return self.colours_of(self.values)

    def colours_of(self, values: ArrayLike) -> Bytes:
        """Return (k, 3) uint8, the colours of any values."""
        given = np.asarray(values, dtype=float)
        is_known = np.isfinite(given)
        colours: Bytes
        if self.names:
            colours = distinct(len(self.names))[np.where(is_known, given, 0).astype(int)]
        else:
            low, high = self.range
            share = (given - low) / ((high - low) or 1.0)
            colours = shades(np.where(is_known, np.clip(share, 0.0, 1.0), 0.0))
        colours[~is_known] = UNKNOWN
        return colours

    @property
    def scale(self) -> Bytes:
        """(k, 3) uint8, the colours of the legend, from low to high or in the order of names."""
        return distinct(len(self.names)) if self.names else shades(np.linspace(0, 1, SHADES))

    def ticks(self, count: int = 6) -> list[tuple[str, tuple[int, ...]]]:
        """Return what a legend says, from low to high, each with its colour."""
        if self.names:
            said = list(self.names)
            values = np.arange(len(said), dtype=float)
        else:
            low, high = self.range
            values = np.linspace(low, high, count if high > low else 1)
            said = [f"{value:.3g}" for value in values]
        colours = self.colours_of(values).tolist()
        return [(text, tuple(colour)) for text, colour in zip(said, colours, strict=True)]

    def __str__(self) -> str:
        """Return the legend as a line of text."""
        if self.names:
            return f"{self.title}: {len(self.names)} colours, {self.names[0]} to {self.names[-1]}"
        low, high = self.range
        return f"{self.title}: {low:.4g} (dark) to {high:.4g} (light)"


def shades(shares: ArrayLike) -> Bytes:
    """Return (k, 3) uint8, colours of a scale at shares of its length from 0 to 1."""
    at = np.asarray(shares, dtype=float) * (len(VIRIDIS) - 1)
    columns = [np.interp(at, np.arange(len(VIRIDIS)), column) for column in VIRIDIS.T]
    coloured: Bytes = np.rint(np.column_stack(columns)).astype(np.uint8)
    return coloured


def distinct(count: int) -> Bytes:
    """Return (count, 3) uint8, colours that are told apart; after 24 they begin again."""
    rounds = [255 - paler * (255 - APART) for paler in PALER]
    table = np.rint(np.concatenate(rounds)).astype(np.uint8)
    return np.asarray(table[np.arange(count) % len(table)])


def by_shape(elements: Elements, quantity: str) -> Colouring:
    """Return elements coloured by a quantity that their own shape tells.

    Parameters
    ----------
    elements : Shell, Vault or any others
    quantity : str
        A key of `OF_SHAPE`.

    Raises
    ------
    InputError
        There is no such quantity of such elements.
    """
    title, values, least = OF_SHAPE[quantity]
    found = values(elements)
    if found is None:
        raise InputError(f"A {type(elements).__name__} has no {quantity} to be coloured by.")
    if least is None:
        return Colouring(title, found)
    return Colouring(title, found, low=0.0, high=max(float(found.max()), least(elements)))


def _chamfer(elements: Elements) -> FloatArray | None:
    if isinstance(elements, Vault):
        return np.asarray(np.abs(elements.end_angles).max(axis=1))
    if not isinstance(elements, Shell):
        return None
    mesh = elements.mesh
    steepest = np.maximum.reduceat(np.abs(elements.chamfer_angles), mesh.offsets[:-1])
    return np.asarray(steepest[elements.faces])


def _planarity(elements: Elements) -> FloatArray | None:
    return elements.mesh.planarity[elements.faces] if isinstance(elements, Shell) else None


def _area(elements: Elements) -> FloatArray:
    areas = elements.solids.face_areas
    return np.asarray(np.maximum.reduceat(areas, elements.solids.solid_offsets[:-1]) * 1e-6)


def _mass(elements: Elements) -> FloatArray:
    return np.asarray(elements.solids.volumes * 1e-9 * elements.material.density)


def _length(elements: Elements) -> FloatArray:
    solids = elements.solids
    owner = solids.solid_of_face[solids.face_of_loop]
    longest = np.zeros(len(solids))
    np.maximum.at(longest, owner, solids.edge_lengths)
    return longest


def _tolerated(elements: Elements) -> float:
    return elements.tol.planar


Values = Callable[[Any], FloatArray | None]
OF_SHAPE: Mapping[str, tuple[str, Values, Callable[[Elements], float] | None]] = {
    "chamfer": ("steepest chamfer, degrees", _chamfer, None),
    "area": ("area, m2", _area, None),
    "length": ("longest edge, mm", _length, None),
    "mass": ("mass, kg", _mass, None),
    # less than is tolerated is no difference worth a colour
    "planarity": ("out of plane, mm", _planarity, _tolerated),
}
"""By name: the title of the legend, the function of elements that gives their values, and that of
the least end of a scale that begins at zero."""


def numbered(title: str, of_element: Sequence[str | None]) -> Colouring:
    """Return elements coloured by names, such as those of the sheets that they are cut from."""
    names = tuple(sorted({name for name in of_element if name is not None}))
    number = {name: k for k, name in enumerate(names)}
    values = [np.nan if name is None else float(number[name]) for name in of_element]
    return Colouring(title, np.array(values), names)
