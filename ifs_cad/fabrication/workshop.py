"""What a workshop decides: stock, router, spacing, saw, and how hard to look for a good nest."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any, Literal, get_args

from ifs_cad.elements.panel import Face, require_face
from ifs_cad.errors import InputError
from ifs_cad.fabrication.machining.settings import Hold

Method = Literal["fast", "thorough"]


@dataclass(frozen=True)
class Workshop:
    """Decisions of the workshop.

    Parameters
    ----------
    stock : str, optional
        A TOML file of sheets and boards beyond the common ones, see `fabrication.stock_file`.
    use : tuple of str
        Names of the sheets or boards to use; all that fit when empty.
    only : tuple of str
        Address patterns such as "03*": a partial prototype, with the chamfers of the whole.
    visible : "inner", "outer" or None
        Which face is seen in the building; sheets with one good face show it there, so it must
        not be engraved.
    programs : bool
        Whether to write programs for the router; without, sheets are nested for the given cutter
        and programs are left to other software.
    tools : str, optional
        A TOML file of tools, the machine and its control beyond the common ones, see
        `fabrication.machining.router`.
    cutter : float, optional
        Diameter of the cutter of contours, mm; by default the thinnest end mill that is long
        enough for all pieces, or 12 mm without programs.
    hold : "tabs", "skin", "none" or None
        What keeps pieces in place, see `fabrication.machining.settings`; by default nothing where
        all are pierced and so can be screwed to the table, the paper's way, and bridges elsewhere.
    breakthrough : float, optional
        How far contours reach below the sheet, mm; by default as the file of tools says, 0.5 mm.
    gap : float
        Wood left between two swept contours, mm.
    margin : float
        Least distance of a piece from the edge of its sheet, mm.
    kerf, trim : float
        Width of the saw cut between planks, and what is cut off each end of a board, mm.
    method : "fast" or "thorough"
        Of nesting.
    seconds : float
        That the thorough way may take.

    Raises
    ------
    InputError
    """

    stock: str | None = None
    use: tuple[str, ...] = ()
    only: tuple[str, ...] = ()
    visible: Face | None = None
    programs: bool = True
    tools: str | None = None
    cutter: float | None = None
    hold: Hold | None = None
    breakthrough: float | None = None
    gap: float = 1.0
    margin: float = 10.0
    kerf: float = 4.0
    trim: float = 10.0
    method: Method = "fast"
    seconds: float = 60.0

    def __post_init__(self) -> None:
        for name in ("use", "only"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        if self.visible is not None:
            require_face(self.visible)
        for name in ("cutter", "seconds"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value > 0):
                raise InputError(f"{name} must be positive, got {value}.")
        for name in ("breakthrough", "gap", "margin", "kerf", "trim"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value >= 0):
                raise InputError(f"{name} must not be negative, got {value} mm.")
        if self.hold not in (None, *get_args(Hold)):
            raise InputError(f"hold must be one of {', '.join(get_args(Hold))}, got {self.hold!r}.")
        if self.method not in get_args(Method):
            raise InputError(f'The method must be "fast" or "thorough", got {self.method!r}.')

    def as_dict(self) -> dict[str, Any]:
        """Return the decisions as plain values."""
        return {field.name: getattr(self, field.name) for field in fields(self)}
