"""How a sheet is cut: holding, direction, depths and leads.

Source: section 4.3, figure 19.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

from ifs_cad.errors import InputError

Hold = Literal["tabs", "skin", "none"]
Direction = Literal["climb", "conventional"]


@dataclass(frozen=True)
class Settings:
    """How a sheet is cut.

    Parameters
    ----------
    hold : "tabs", "skin" or "none"
        What keeps a piece in place while its contour is cut: bridges to the rest of the sheet, a
        thin layer below all of it, or nothing, for pieces screwed to the table through their holes
        (the paper's way) or held by a vacuum.
    tab_length, tab_height : float
        Of a bridge, mm; its height is that above the table where it is lowest.
    tab_spacing : float
        Largest distance of the bridges of one side, mm.
    tab_landing : float
        How much of the sheet must be left behind a bridge, mm.
    skin : float
        Thickness of the layer where it is thinnest, mm.
    direction : "climb" or "conventional"
        Climb: the workpiece on the right of a cutter that turns clockwise seen from above.
    breakthrough : float
        How far below a face of the contour, and so below the sheet, the cutter reaches, mm.
    drill_breakthrough : float
        How far a drill's full diameter comes out below the sheet, mm.
    lead : float
        How far the cutter runs beyond both ends of an edge, mm; its radius by default, so that all
        of it has passed the corner.
    clearance : float
        Height above the sheet where feeding begins, and at least that of the holder, mm.
    pass_depth : float
        Largest depth of one pass along the tool, mm; by default the tool's.
    stroke_depth : float
        How deep an address is engraved that is only drawn, mm.
    contour_tool : int
        Number of the end mill; by default the thinnest that is long enough.

    Raises
    ------
    InputError
        A number or a word that cannot be meant.
    """

    hold: Hold = "tabs"
    tab_length: float = 8.0
    tab_height: float = 2.0
    tab_spacing: float = 400.0
    tab_landing: float = 2.0
    skin: float = 0.4
    direction: Direction = "climb"
    breakthrough: float = 0.5
    drill_breakthrough: float = 0.5
    lead: float | None = None
    clearance: float = 5.0
    pass_depth: float | None = None
    stroke_depth: float = 0.5
    contour_tool: int | None = None

    def __post_init__(self) -> None:
        for name, kind in (("hold", Hold), ("direction", Direction)):
            if getattr(self, name) not in get_args(kind):
                raise InputError(
                    f"Settings: {name} must be one of {', '.join(get_args(kind))}, got "
                    f"{getattr(self, name)!r}."
                )
        for name in ("tab_length", "tab_height", "tab_spacing", "skin", "clearance"):
            self._require(name, above_zero=True)
        self._require("stroke_depth", above_zero=True)
        for name in ("tab_landing", "breakthrough", "drill_breakthrough"):
            self._require(name, above_zero=False)
        if self.lead is not None:
            self._require("lead", above_zero=False)
        if self.pass_depth is not None:
            self._require("pass_depth", above_zero=True)

    def _require(self, name: str, *, above_zero: bool) -> None:
        value = getattr(self, name)
        if not (0.0 < value < math.inf if above_zero else 0.0 <= value < math.inf):
            least = "above 0" if above_zero else "0 or more"
            raise InputError(f"Settings: {name} must be {least}, got {value:g} mm.")

    def __str__(self) -> str:
        """Return what holds the pieces, for comments."""
        if self.hold == "tabs":
            return f"tabs {self.tab_length:g} x {self.tab_height:g}"
        return f"skin {self.skin:g}" if self.hold == "skin" else "none"
