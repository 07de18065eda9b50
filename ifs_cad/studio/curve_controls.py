"""The tab of one curve: its drawing, depth, roughness, fold, and the selected point."""

from __future__ import annotations

from typing import Any

from ifs_cad.design_record import MOST_TRANSFORMATIONS, DrawnCurve
from ifs_cad.errors import InputError
from ifs_cad.studio.bindings import Bindings
from ifs_cad.studio.evaluation import CurveName, CurveView
from ifs_cad.studio.events import on_click, on_update
from ifs_cad.studio.handles import Key, name_of
from ifs_cad.studio.model import StudioModel
from ifs_cad.studio.plot import curve_plot
from ifs_cad.studio.selection import Place, Selection, handles_of, point_of, shown
from ifs_cad.studio.session import Snapshot

DEEPEST = 8
"""Of the slider; a file may ask for more."""

FIRST_FOLD = 0.5
WEIGHTS = (0.1, 4.0)
LEAST_WEIGHT = 0.001

__all__ = ["CurveControls"]


class CurveControls:
    """Controls of a curve, added to the container that is open.

    Parameters
    ----------
    gui : viser.GuiApi
    bindings : Bindings
    selection : Selection
    curve : "a" or "b"
    """

    def __init__(
        self, gui: Any, bindings: Bindings, selection: Selection, curve: CurveName
    ) -> None:
        self._bindings = bindings
        self._selection = selection
        self._curve = curve
        self._actions = {"Add": self._add, "Remove": self._remove, "Put back": self._put_back}
        self._plotted: tuple[DrawnCurve, int | str] | None = None
        self._plot = gui.add_html("")
        self._depth(gui)
        with gui.add_folder("Selected point"):
            self._point(gui)
        with gui.add_folder("Scheme", expand_by_default=False):
            self._scheme(gui)
        bindings.follow(self._follow)

    def draw(self, view: CurveView, snapshot: Snapshot) -> None:
        """Show the drawing, if it is another."""
        selected = self._selection.of(self._curve, snapshot.design)
        plotted = (self._drawn(snapshot), selected)
        if plotted != self._plotted:
            self._plotted = plotted
            self._plot.content = curve_plot(view, selected)

    def _drawn(self, snapshot: Snapshot) -> DrawnCurve:
        drawn: DrawnCurve = getattr(snapshot.design, self._curve)
        return drawn

    def _depth(self, gui: Any) -> None:
        curve, bind = self._curve, self._bindings.bind
        self._depth_slider = gui.add_slider(
            "Depth", 0, DEEPEST, 1, 4, hint="Construction steps; each doubles the panels."
        )
        bind(
            self._depth_slider,
            lambda now: self._drawn(now).depth,
            lambda model, value: model.set_depth(curve, value),
            f"{curve} depth",
        )
        bind(
            gui.add_slider(
                "Roughness",
                -0.33,
                1.0,
                0.01,
                0.0,
                hint="0 is smooth; -1/3 puts the subdivision points on their chords.",
            ),
            lambda now: self._drawn(now).roughness,
            lambda model, value: model.set_roughness(curve, value),
            f"{curve} roughness",
        )
        bind(
            gui.add_checkbox(
                "Even fold",
                False,
                hint="One more step that folds every segment at the same slope: over a plane "
                "curve square to it, all nodes meet exactly.",
            ),
            lambda now: self._drawn(now).fold is not None,
            lambda model, on: model.set_fold(curve, FIRST_FOLD if on else None),
        )
        self._fold = gui.add_number("Slope", FIRST_FOLD, step=0.01, hint="Rise over run.")
        bind(
            self._fold,
            lambda now: self._drawn(now).fold,
            lambda model, value: model.set_fold(curve, value),
            f"{curve} fold",
        )

    def _point(self, gui: Any) -> None:
        curve, bindings = self._curve, self._bindings
        bind = bindings.bind
        self._chosen = gui.add_dropdown(
            "Point",
            ("p1",),
            hint="Or click a point in the scene.",
        )
        on_update(self._chosen, lambda event: self._choose(event.target.value))

        bind(
            gui.add_vector3("x, y, z (mm)", (0.0, 0.0, 0.0), step=0.1),
            self._place,
            self._move,
            f"{curve} place",
        )
        self._weight = gui.add_slider(
            "Weight", *WEIGHTS, 0.01, 1.0, hint="How strongly the curve is drawn to the point."
        )
        exact = gui.add_number("Exact weight", 1.0, step=0.001, min=LEAST_WEIGHT)
        for handle in (self._weight, exact):
            bind(handle, self._heaviness, self._weigh, f"{curve} weight")
        buttons = gui.add_button_group(
            "Points",
            tuple(self._actions),
            hint="Add a control point, which leaves the shape; remove the selected one; put the "
            "selected subdivision point back to where the roughness has it.",
        )
        on_click(buttons, lambda event: bindings.edit(self._actions[event.target.value]))

    def _choose(self, name: str) -> None:
        drawn = self._drawn(self._bindings.snapshot())
        named = {name_of(handle): handle for handle in handles_of(drawn)}
        self._selection.choose(Key(self._curve, named[name]))

    def _scheme(self, gui: Any) -> None:
        curve, bind = self._curve, self._bindings.bind
        bind(
            gui.add_number("Transformations", 2, min=2, max=MOST_TRANSFORMATIONS, step=1),
            lambda now: self._drawn(now).transformations,
            lambda model, value: model.set_transformations(curve, value),
            f"{curve} transformations",
        )
        bind(
            gui.add_checkbox("Closed", False),
            lambda now: self._drawn(now).closed,
            lambda model, on: model.set_closed(curve, on),
        )
        bind(
            gui.add_checkbox("Symmetric editing", False),
            lambda now: self._drawn(now).symmetric,
            lambda model, on: model.set_symmetric(curve, on),
        )

    def _follow(self, snapshot: Snapshot) -> None:
        """Adapt what the controls offer."""
        drawn = self._drawn(snapshot)
        names = tuple(map(name_of, handles_of(drawn)))
        if tuple(self._chosen.options) != names:
            self._chosen.options = names
        chosen = name_of(self._selection.of(self._curve, snapshot.design))
        if self._chosen.value != chosen:
            self._chosen.value = chosen
        self._fold.visible = drawn.fold is not None
        self._depth_slider.max = max(DEEPEST, drawn.depth)
        weight = self._heaviness(snapshot) or 1.0
        self._weight.min, self._weight.max = min(WEIGHTS[0], weight), max(WEIGHTS[1], weight)

    def _place(self, snapshot: Snapshot) -> Place | None:
        found = self._state(snapshot)
        return None if found is None else shown(found[0])

    def _heaviness(self, snapshot: Snapshot) -> float | None:
        found = self._state(snapshot)
        return None if found is None else found[1]

    def _state(self, snapshot: Snapshot) -> tuple[Place, float] | None:
        """Return the place and the weight of the selected point."""
        handle = self._selection.of(self._curve, snapshot.design)
        return point_of(self._drawn(snapshot), handle)

    def _handle(self, model: StudioModel) -> int | str:
        return self._selection.of(self._curve, model.design)

    def _move(self, model: StudioModel, place: Place) -> None:
        handle = self._handle(model)
        found = point_of(getattr(model.design, self._curve), handle)
        if found is not None:  # what was not typed stays exact, not as it is shown
            kept = zip(place, shown(found[0]), found[0], strict=True)
            x, y, z = (new if new != seen else own for new, seen, own in kept)
            place = (x, y, z)
        if isinstance(handle, str):
            model.move_subdivision_point(self._curve, handle, place)
        else:
            model.move_control_point(self._curve, handle, place)

    def _weigh(self, model: StudioModel, weight: float) -> None:
        model.set_weight(self._curve, self._handle(model), weight)

    def _add(self, model: StudioModel) -> None:
        model.add_control_point(self._curve)

    def _remove(self, model: StudioModel) -> None:
        handle = self._handle(model)
        if isinstance(handle, str):
            raise InputError(f"{handle} is a subdivision point; those cannot be removed.")
        model.remove_control_point(self._curve, handle)

    def _put_back(self, model: StudioModel) -> None:
        handle = self._handle(model)
        if isinstance(handle, int):
            raise InputError(f"{name_of(handle)} is a control point; those do not go back.")
        model.reset_subdivision_point(self._curve, handle)
