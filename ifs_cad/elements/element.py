"""What panels and beams have in common: all that solids, labels and files need to know of them."""

from __future__ import annotations

from typing import Any, Literal, Protocol

from ifs_cad.elements.material import Material
from ifs_cad.elements.polyhedron import Polyhedra
from ifs_cad.tolerance import Tolerance
from ifs_cad.types import FloatArray


class Elements(Protocol):
    """Construction elements cut from sheets or boards of one thickness.

    Attributes
    ----------
    addresses : unique names
    solids : Polyhedra, their exact shapes, mm; UPPER and LOWER faces are those of the sheet
    normals : (p, 3) float, unit vectors from the lower to the upper face
    along : (p, 3) float or None: text runs along it; None where it runs level
    fibres : (p, 3) float or None, unit vectors along the grain; None where it may run as it likes
    mate_addresses : names; what the mates of `solids` number
    cut_from : "sheets" or "boards"
    thickness : float, mm
    material : Material
    tol : Tolerance
    """

    @property
    def addresses(self) -> tuple[str, ...]:
        """Unique names."""

    @property
    def solids(self) -> Polyhedra:
        """Exact shapes, mm."""

    @property
    def normals(self) -> FloatArray:
        """(p, 3) float, unit vectors from the lower to the upper face."""

    @property
    def along(self) -> FloatArray | None:
        """(p, 3) float, or None."""

    @property
    def fibres(self) -> FloatArray | None:
        """(p, 3) float, unit vectors in the planes of the sheets, or None."""

    @property
    def mate_addresses(self) -> tuple[str, ...]:
        """Names that the mates of `solids` number."""

    @property
    def cut_from(self) -> Literal["sheets", "boards"]:
        """What the workshop cuts them from."""

    @property
    def thickness(self) -> float:
        """Thickness in mm."""

    @property
    def material(self) -> Material:
        """What they are made of."""

    @property
    def tol(self) -> Tolerance:
        """Tolerances of the design."""

    def __len__(self) -> int:
        """Return the number of elements."""

    def part_data(self) -> list[dict[str, Any]]:
        """Return for each element what an assembly says of its part."""

    def report(self) -> Any:
        """Return a summary whose `str()` is a table for the user."""
