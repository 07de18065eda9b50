"""The points of both curves as balls in the scene, to be clicked and dragged."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from ifs_cad.studio import look
from ifs_cad.studio.evaluation import CurveName, CurveView, Evaluation
from ifs_cad.studio.events import on_click, on_drag
from ifs_cad.studio.grip import Grip, Rule
from ifs_cad.studio.model import StudioModel
from ifs_cad.studio.plane import plane_of
from ifs_cad.studio.scene import METRES, put
from ifs_cad.types import FloatArray

CONTROL_RADIUS, SUBDIVISION_RADIUS = 0.011, 0.0085  # of the size of the design
CURVES: tuple[CurveName, ...] = ("a", "b")

__all__ = ["CURVES", "Handles", "Key", "name_of"]


@dataclass(frozen=True)
class Key:
    """A point of a curve: a control point by its number, a subdivision point by its name."""

    curve: CurveName
    handle: int | str


class Editor(Protocol):
    """Changes the design, or says why not."""

    def edit(
        self, change: Callable[[StudioModel], object], gesture: str = "", *, held: bool = False
    ) -> None:
        """Change it."""

    def settle(self) -> None:
        """End a gesture."""


def name_of(handle: int | str) -> str:
    """Return how the page calls a point: p1, p2, ... and s2, s3, ..."""
    return handle if isinstance(handle, str) else f"p{handle + 1}"


class Handles:
    """All points that can be dragged.

    Parameters
    ----------
    server : viser.ViserServer
    editor : Editor
    selected : callable
        Takes the key of a point that was clicked or taken.

    Attributes
    ----------
    rule : str
        How a place on the screen becomes one in space.
    show_names : bool
    """

    def __init__(self, server: Any, editor: Editor, selected: Callable[[Key], None]) -> None:
        self.rule: Rule = "plane of the curve"
        self.show_names = False
        self._lock = threading.RLock()  # the mouse is heard on one thread, and drawn from another
        self._server = server
        self._editor = editor
        self._selected = selected
        self._balls: dict[Key, Any] = {}
        self._names: dict[Key, Any] = {}
        self._places: dict[Key, FloatArray] = {}
        self._radius = 0.0
        self._views: dict[str, CurveView] = {}
        self._grips: dict[int, tuple[Key, Grip, FloatArray]] = {}

    def held(self, evaluation: Evaluation) -> Evaluation:
        """Return the evaluation with a curve that is being dragged staying where it was taken.

        A curve is shown at the border that it spans, and would run away from the mouse when its
        own first point is dragged.
        """
        with self._lock:
            for key, _, shift in self._grips.values():
                view: CurveView = getattr(evaluation, key.curve)
                changed: dict[str, Any] = {key.curve: replace(view, shift=shift)}
                evaluation = replace(evaluation, **changed)
            return evaluation

    def draw(self, evaluation: Evaluation, selection: Key | None) -> None:
        """Show the points of an evaluation where the model has them."""
        with self._lock:
            self._draw(evaluation, selection)

    def _draw(self, evaluation: Evaluation, selection: Key | None) -> None:
        places: dict[Key, FloatArray] = {}
        for curve, view in zip(CURVES, (evaluation.a, evaluation.b), strict=True):
            for number, point in enumerate(view.control_points):
                places[Key(curve, number)] = point + view.shift
            for item in view.subdivision_points:
                places[Key(curve, item.name)] = np.array(item.point) + view.shift
            self._views[curve] = view
        self._resize(evaluation)
        for key in self._balls.keys() - places.keys():
            self._balls.pop(key).remove()
        for key in self._names.keys() - (places.keys() if self.show_names else set()):
            self._names.pop(key).remove()
        for key, place in places.items():
            x, y, z = (place * METRES).tolist()
            ball = self._balls.get(key)
            if ball is None:
                ball = self._add(key)
                put(ball, (x, y, z))
            elif not np.array_equal(place, self._places[key]):
                ball.position = (x, y, z)
            colour = _colour(key, selection)
            if ball.color != colour:
                ball.color = colour
            if self.show_names:
                self._label(key, (x, y, z))
        self._places = places

    def _resize(self, evaluation: Evaluation) -> None:
        """Fit the balls to a design that has become much larger or smaller."""
        low, high = evaluation.extent
        size = float(np.linalg.norm(high - low)) * METRES
        if self._grips or 0.7 < self._radius / max(size, 1e-9) < 1.4:
            return
        self._radius = max(size, 1e-9)
        for key, ball in self._balls.items():
            ball.scale = self._radius * _share(key)

    def _add(self, key: Key) -> Any:
        ball = self._server.scene.add_icosphere(
            f"/points/{key.curve}_{name_of(key.handle)}",
            1.0,
            _colour(key, None),
            subdivisions=2,
            cast_shadow=False,
            receive_shadow=False,
            scale=self._radius * _share(key),
        )
        self._balls[key] = ball

        on_click(ball, lambda event: self._selected(key))
        on_drag(ball, lambda event: self._drag(key, event))
        return ball

    def _drag(self, key: Key, event: Any) -> None:
        with self._lock:
            self._follow(key, event)

    def _follow(self, key: Key, event: Any) -> None:
        pointer = np.array(event.end_position) / METRES
        eye = np.array(event.client.camera.position) / METRES
        if event.phase == "start":
            view = self._views[key.curve]
            start = self._places[key]
            grabbed = np.array(event.start_position) / METRES
            plane = plane_of(view.control_points + view.shift)
            self._grips[event.client_id] = (key, Grip(start, grabbed, plane, self.rule), view.shift)
            self._selected(key)
        held = self._grips.get(event.client_id)
        if held is None:
            return
        _, grip, shift = held
        if not np.allclose(pointer, grip.grabbed):
            place = grip.place(pointer, eye) - shift
            gesture = f"drag {key.curve} {name_of(key.handle)}"
            self._editor.edit(lambda model: _move(model, key, place), gesture, held=True)
        if event.phase == "end":
            del self._grips[event.client_id]
            self._editor.settle()

    def _label(self, key: Key, position: tuple[float, float, float]) -> None:
        label = self._names.get(key)
        if label is None:
            label = self._names[key] = self._server.scene.add_label(
                f"/names/{key.curve}_{name_of(key.handle)}",
                f"{key.curve.upper()} {name_of(key.handle)}",
                anchor="bottom-left",
            )
            put(label, position)
        else:
            label.position = position


def _move(model: StudioModel, key: Key, place: FloatArray) -> None:
    if isinstance(key.handle, str):
        model.move_subdivision_point(key.curve, key.handle, place)
    else:
        model.move_control_point(key.curve, key.handle, place)


def _share(key: Key) -> float:
    """Return the radius of a ball, as a share of the size of the design."""
    return CONTROL_RADIUS if isinstance(key.handle, int) else SUBDIVISION_RADIUS


def _colour(key: Key, selection: Key | None) -> look.Colour:
    if key == selection:
        return look.SELECTED
    return look.CONTROL if isinstance(key.handle, int) else look.SUBDIVISION
