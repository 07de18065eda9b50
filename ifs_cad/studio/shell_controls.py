"""The tab of the panels: sheet, side, nodes, floor, labels."""

from __future__ import annotations

from typing import Any, get_args

from ifs_cad.elements.hole import Holes
from ifs_cad.elements.label import Label
from ifs_cad.elements.thicken import Nodes, Side
from ifs_cad.studio.bindings import Bindings
from ifs_cad.studio.session import Snapshot

THICKNESSES = (2.0, 60.0)  # mm, of the slider

__all__ = ["ShellControls"]


class ShellControls:
    """Controls of the panels, added to the container that is open.

    Parameters
    ----------
    gui : viser.GuiApi
    bindings : Bindings
    """

    def __init__(self, gui: Any, bindings: Bindings) -> None:
        bind = bindings.bind
        self._thickness = gui.add_slider("Thickness (mm)", *THICKNESSES, 0.5, 10.0)
        exact = gui.add_number("Measured (mm)", 10.0, min=0.001, step=0.01)
        for handle in (self._thickness, exact):
            bind(
                handle,
                lambda now: now.design.thickness,
                lambda model, value: model.set_thickness(value),
                "thickness",
            )
        bind(
            gui.add_dropdown("Side", get_args(Side), hint="Where panels lie about the surface."),
            lambda now: now.design.side,
            lambda model, value: model.set_side(value),
        )
        bind(
            gui.add_dropdown(
                "Nodes",
                get_args(Nodes),
                hint="relief cuts panels apart where only corners meet; axis tilts their edges.",
            ),
            lambda now: now.design.nodes,
            lambda model, value: model.change(nodes=value),
        )
        bind(
            gui.add_number(
                "Clearance (mm)", 0.0, min=0.0, step=0.05, hint="How far chamfers are set back."
            ),
            lambda now: now.design.clearance,
            lambda model, value: model.change(clearance=value),
            "clearance",
        )
        bind(
            gui.add_checkbox("Stands on a floor", False),
            lambda now: now.design.floor is not None,
            lambda model, on: model.set_floor(0.0 if on else None),
        )
        self._floor = gui.add_number("Floor at z (mm)", 0.0, step=1.0)
        bind(
            self._floor,
            lambda now: now.design.floor,
            lambda model, value: model.set_floor(value),
            "floor",
        )
        bind(
            gui.add_checkbox("Addresses engraved", False),
            lambda now: now.design.label is not None,
            lambda model, on: model.change(label=Label() if on else None),
        )
        bind(
            gui.add_checkbox("Holes for screws", False),
            lambda now: now.design.holes is not None,
            lambda model, on: model.change(holes=Holes() if on else None),
        )
        bind(
            gui.add_text("Title", ""),
            lambda now: now.design.title,
            lambda model, value: model.change(title=value),
            "title",
        )
        bindings.follow(self._follow)

    def _follow(self, snapshot: Snapshot) -> None:
        thickness = snapshot.design.thickness
        self._floor.visible = snapshot.design.floor is not None
        self._thickness.min = min(THICKNESSES[0], thickness)
        self._thickness.max = max(THICKNESSES[1], thickness)
