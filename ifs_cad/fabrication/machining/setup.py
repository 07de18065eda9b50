"""How the pieces of one design are machined: on which router, with which cutter, held by what.

All sheets of a design are cut alike, so that the distance between pieces can be chosen before any
of them is placed.

Source: section 4.3 (multi-part plates; panels are pierced first and screwed to the table).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ifs_cad.errors import MachineError
from ifs_cad.fabrication.machining.router import Router
from ifs_cad.fabrication.machining.settings import Hold, Settings
from ifs_cad.fabrication.machining.sweep import contour_reach
from ifs_cad.fabrication.machining.tool import Tool
from ifs_cad.fabrication.machining.toolpath import contour_mill
from ifs_cad.fabrication.saw import square_workpieces
from ifs_cad.fabrication.workpiece import Workpiece

__all__ = ["Setup", "set_up"]


@dataclass(frozen=True, eq=False)
class Setup:
    """How pieces are machined.

    Attributes
    ----------
    router : Router
    settings : Settings, with the cutter of all contours
    pieces : tuple of Workpiece, as the router leaves them: on a machine of three axes with upright
        sides, which a saw cuts afterwards
    mill : Tool, the cutter of all contours
    reach : float, how far it reaches beyond the silhouette of any piece, mm
    """

    router: Router
    settings: Settings
    pieces: tuple[Workpiece, ...]
    mill: Tool
    reach: float

    @property
    def spacing(self) -> float:
        """The least distance of two pieces, mm: no cutter takes of a neighbour.

        Bridges need more: two cutters beside each other, and wood between them to end in.
        """
        if self.settings.hold == "tabs":
            return 2.0 * self.reach + self.settings.tab_landing
        return self.reach


def set_up(
    pieces: Sequence[Workpiece],
    router: Router,
    *,
    cutter: float | None = None,
    hold: Hold | None = None,
    breakthrough: float | None = None,
) -> Setup:
    """Return how pieces of one material and thickness are machined.

    Parameters
    ----------
    pieces : all that are to be cut
    router : Router
    cutter : float, diameter of the end mill, mm; by default the thinnest that is long enough
    hold : see `Settings`; by default as the router's settings say, or else "none" where every piece
        is pierced and can be screwed to the table, and "tabs" elsewhere
    breakthrough : float, how far contours reach below the sheet, mm; by default as the router's
        settings say

    Raises
    ------
    MachineError
        No end mill of this diameter or length, or a side that the head cannot reach; names the
        address and the side.
    """
    machine = router.machine
    made = tuple(square_workpieces(pieces)) if machine.rotary == "none" else tuple(pieces)
    usual = "none" if all(piece.drills for piece in made) else "tabs"
    asked = {"hold": hold, "breakthrough": breakthrough}
    asked = {name: value for name, value in asked.items() if value is not None}
    settings = Settings(**{"hold": usual, **router.settings, **asked})
    tools = [tool for tool in router.tools if tool.cuts(made[0].material.name)]
    if cutter is not None:
        mills = [tool.diameter for tool in tools if tool.kind == "end mill"]
        if cutter not in mills:
            sizes = ", ".join(f"{diameter:g}" for diameter in sorted(set(mills))) or "none"
            raise MachineError(
                f"There is no end mill of {cutter:g} mm; for {made[0].material.name} there are "
                f"{sizes}. Add one to a file of tools.",
                diameter=cutter,
            )
        tools = [tool for tool in tools if tool.kind != "end mill" or tool.diameter == cutter]
    mill = contour_mill(made, tools, machine, settings)
    settings = replace(settings, contour_tool=mill.number)
    return Setup(router, settings, made, mill, contour_reach(made, mill, settings))
