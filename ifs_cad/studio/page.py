"""The page: a scene, a panel of controls, a report, and what happens between them.

Three threads: viser's hears the page and edits the session; `Recomputer`'s evaluates and draws;
a clock ends gestures and keeps the design from being lost.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from ifs_cad.errors import IfsCadError
from ifs_cad.studio.bindings import Bindings
from ifs_cad.studio.curve_controls import CurveControls
from ifs_cad.studio.evaluation import Evaluation
from ifs_cad.studio.events import on_click, on_trigger, on_update
from ifs_cad.studio.file_controls import FileControls
from ifs_cad.studio.grip import RULES
from ifs_cad.studio.handles import CURVES, Handles, Key
from ifs_cad.studio.make_controls import MakeControls
from ifs_cad.studio.recompute import Recomputer
from ifs_cad.studio.scene import Scene
from ifs_cad.studio.selection import Selection
from ifs_cad.studio.session import Session, Snapshot
from ifs_cad.studio.shell_controls import ShellControls
from ifs_cad.studio.words import report_html, status_html

TICK_SECONDS = 0.2
AUTOSAVE_SECONDS = 2.0

__all__ = ["StudioPage"]


class StudioPage:
    """The page of a session.

    Parameters
    ----------
    server : StudioServer
    session : Session
    """

    def __init__(self, server: Any, session: Session) -> None:
        self._server = server
        self._session = session
        self._note = ""
        self._shown: tuple[Snapshot, Evaluation] | None = None
        self._needs_fit = True
        self._ended = threading.Event()
        self._bindings = Bindings(session, self._say)
        self._selection = Selection()
        self._scene = Scene(server)
        self._handles = Handles(server, self._bindings, self._selection.choose)
        self._build()
        self._selection.changed = self._reselect
        self._recomputer = Recomputer(self._show, self._fail)
        session.changed = self._recomputer.request
        server.on_client_connect(self._aim)
        self._clock = threading.Thread(target=self._tick, name="clock", daemon=True)
        self._clock.start()
        self._call(self._bindings.sync)
        self._recomputer.request(session.snapshot())

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until the page shows the newest design, and tell whether it does."""
        return self._recomputer.wait(timeout)

    def select(self, key: Key) -> None:
        """Select a point as a click on it does."""
        self._call(lambda: self._selection.choose(key))

    def close(self) -> None:
        """End all threads and jobs, and keep what was not saved."""
        self._ended.set()
        self._make.runner.close()
        self._recomputer.close()
        self._clock.join(timeout=10.0)
        self._session.settle()
        self._session.autosave()

    def _build(self) -> None:
        gui = self._server.gui
        history = gui.add_button_group("Edit", ("Undo", "Redo", "Fit view"))
        self._status = gui.add_html("")
        tabs = gui.add_tab_group()
        self._curves = {}
        for curve in CURVES:
            with tabs.add_tab(f"Curve {curve.upper()}"):
                self._curves[curve] = CurveControls(gui, self._bindings, self._selection, curve)
        with tabs.add_tab("Panels"):
            ShellControls(gui, self._bindings)
            with gui.add_folder("View"):
                self._view_controls(gui)
        with tabs.add_tab("File"):
            files = FileControls(gui, self._bindings, self._session, self._tell, self._fit_soon)
        with tabs.add_tab("Make"):
            self._make = MakeControls(gui, self._session, self._tell, self._call)
        panel = gui.add_panel()
        with panel.add_tab("Report"):
            self._report = gui.add_html("")
        gui.main_panel.dock_right()
        gui.main_panel.set_width(390)
        panel.float(x=12, y=12, width=350)
        files.tell_beside()
        actions = {"Undo": self._undo, "Redo": self._redo, "Fit view": self._fit}
        on_click(history, lambda event: actions[event.target.value]())
        for label, key, modifier in (
            ("Undo", "Z", "cmd/ctrl"),
            ("Redo", "Y", "cmd/ctrl"),
            ("Fit view", "F", None),
        ):
            self._command(label, key, modifier, actions[label])

    def _command(
        self, label: str, key: str, modifier: str | None, action: Callable[[], None]
    ) -> None:
        command = self._server.gui.add_command(label, hotkey=key, modifier=modifier)
        on_trigger(command, lambda event: action())

    def _view_controls(self, gui: Any) -> None:
        rule = gui.add_dropdown("Drag points in the", RULES)
        boxes = {
            "show_panels": gui.add_checkbox("Panels", True, hint="Off: the surface alone."),
            "show_edges": gui.add_checkbox("Edges", True),
            "show_labels": gui.add_checkbox("Addresses", True),
        }
        names = gui.add_checkbox("Names of points", False)
        on_update(rule, lambda event: setattr(self._handles, "rule", event.target.value))
        self._shows(names, self._handles, "show_names")
        for attribute, box in boxes.items():
            self._shows(box, self._scene, attribute)

    def _shows(self, box: Any, of: Any, attribute: str) -> None:
        def show(event: Any) -> None:
            setattr(of, attribute, event.target.value)
            self._recomputer.request(self._session.snapshot())

        on_update(box, show)

    def _show(self, snapshot: Snapshot, evaluation: Evaluation) -> None:
        """Draw what was computed; on the recomputer's thread."""
        evaluation = self._handles.held(evaluation)
        self._shown = snapshot, evaluation
        with self._server.atomic():
            self._scene.draw(evaluation, snapshot.design)
            self._handles.draw(evaluation, self._selection.active)
            self._draw_panel(snapshot, evaluation)
        self._server.flush()
        if self._needs_fit:
            self._needs_fit = False
            self._fit()
        self._call(self._bindings.sync)

    def _draw_panel(self, snapshot: Snapshot, evaluation: Evaluation) -> None:
        for curve, controls in self._curves.items():
            controls.draw(getattr(evaluation, curve), snapshot)
        status = status_html(evaluation, self._note)
        if self._status.content != status:
            self._status.content = status
        report = report_html(evaluation)
        if not snapshot.gesture and self._report.content != report:
            self._report.content = report

    def _reselect(self) -> None:
        self._bindings.sync()
        if self._shown is not None:
            snapshot, evaluation = self._shown
            self._handles.draw(evaluation, self._selection.active)
            self._draw_panel(snapshot, evaluation)

    def _say(self, note: str) -> None:
        """Show why an edit was refused, or no longer."""
        if note != self._note:
            self._note = note
            if self._shown is not None:
                self._status.content = status_html(self._shown[1], note)

    def _fail(self, text: str) -> None:
        self._call(lambda: self._say(text))

    def _tell(self, client: Any, title: str, text: str, is_good: bool) -> None:
        if client is not None:
            client.add_notification(
                title, text, color="green" if is_good else "red", auto_close_seconds=8.0
            )

    def _undo(self) -> None:
        self._say("" if self._session.undo() else "There is nothing to undo.")
        self._bindings.sync()

    def _redo(self) -> None:
        self._say("" if self._session.redo() else "There is nothing to do again.")
        self._bindings.sync()

    def _fit_soon(self) -> None:
        self._needs_fit = True

    def _fit(self) -> None:
        """Let all cameras see the whole design, also those of pages that are not open yet."""
        if self._shown is None:
            return
        place, middle = self._scene.camera(self._shown[1])
        start = self._server.initial_camera
        start.position, start.look_at = tuple(place.tolist()), tuple(middle.tolist())
        for client in self._server.get_clients().values():
            self._aim(client)

    def _aim(self, client: Any) -> None:
        if self._shown is None:
            return
        place, middle = self._scene.camera(self._shown[1])
        with client.atomic():
            client.camera.up_direction = np.array([0.0, 0.0, 1.0])
            client.camera.position = place
            client.camera.look_at = middle

    def _call(self, action: Callable[[], None]) -> None:
        """Run something on the thread that hears the page."""
        self._server.get_event_loop().call_soon_threadsafe(action)

    def _tick(self) -> None:
        kept = time.monotonic()
        while not self._ended.wait(TICK_SECONDS):
            if self._session.settle_if_quiet():
                self._call(self._bindings.sync)
            if time.monotonic() - kept > AUTOSAVE_SECONDS:
                kept = time.monotonic()
                try:
                    self._session.autosave()
                except IfsCadError as error:
                    self._fail(str(error))
