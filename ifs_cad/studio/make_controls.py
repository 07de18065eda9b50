"""The tab of making: STEP file, the workshop's folder, and whether the shell stands."""

from __future__ import annotations

import base64
import os
from collections.abc import Callable
from functools import partial
from html import escape
from typing import Any

from ifs_cad.design_record import Design
from ifs_cad.errors import IfsCadError
from ifs_cad.fabrication.workshop import Workshop
from ifs_cad.studio.events import on_click
from ifs_cad.studio.file_controls import Tell
from ifs_cad.studio.jobs import (
    JobRunner,
    JobState,
    Made,
    Work,
    analysis,
    fabrication_folder,
    step_file,
)
from ifs_cad.studio.look import WRONG, css
from ifs_cad.studio.session import Session
from ifs_cad.studio.words import GREY, PADDING, table_html
from ifs_cad.workflow.question import Question

SUPPORTS = ("standing", "a start, a end", "b start, b end", "borders")
JOINTS = ("hinge", "rigid")
OWN_FILE = "A TOML file of {} on this machine; empty: the common ones."

__all__ = ["MakeControls"]


class MakeControls:
    """Controls of jobs, added to the container that is open.

    Parameters
    ----------
    gui : viser.GuiApi
    session : Session
    tell : callable
    call : callable
        Runs a function on the thread of the page's events.
    """

    def __init__(
        self, gui: Any, session: Session, tell: Tell, call: Callable[[Callable[[], None]], None]
    ) -> None:
        self._session = session
        self._tell = tell
        self._client: Any = None
        self._shown: Made | None = None
        self.runner = JobRunner(lambda state: call(lambda: self._show(state)))
        with gui.add_folder("Files to cut from"):
            step = gui.add_button("STEP file", hint="Every panel as an exact solid.")
            folder = gui.add_button(
                "Workshop folder", hint="Solids, nested sheets, programs and lists, as a zip."
            )
            self._stock = gui.add_text("Own stock", "", hint=OWN_FILE.format("sheets and boards"))
            self._tools = gui.add_text("Own router", "", hint=OWN_FILE.format("tools and machine"))
        with gui.add_folder("Does it stand?"):
            self._question(gui)
            check = gui.add_button("Analyse")
        self._stage = gui.add_html("", visible=False)
        self._bar = gui.add_progress_bar(0.0, visible=False)
        self._cancel = gui.add_button("Cancel", color="gray", visible=False)
        self._again = gui.add_button("Download again", color="gray", visible=False)
        self._result = gui.add_html("", visible=False)
        self._starts(step, "STEP file", self._step_file)
        self._starts(folder, "Workshop folder", self._workshop_folder)
        self._starts(check, "Analysis", self._analysis)
        on_click(self._cancel, lambda event: self.runner.cancel())
        on_click(self._again, lambda event: self._send(event.client))

    def _question(self, gui: Any) -> None:
        self._load = gui.add_number("Load (N/m²)", 1500.0, min=0.0, step=50.0)
        self._half = gui.add_checkbox("On one half only", False)
        self._weight = gui.add_checkbox("Add own weight", True)
        self._supports = gui.add_dropdown("Supports", SUPPORTS)
        self._joints = gui.add_dropdown("Joints", JOINTS)

    def _starts(self, button: Any, what: str, work: Callable[[], Work]) -> None:
        def start(event: Any) -> None:
            try:
                self.runner.start(what, work())
            except IfsCadError as error:
                self._tell(event.client, "Not now", str(error), False)
            else:
                self._client = event.client

        on_click(button, start)

    def _step_file(self) -> Work:
        return partial(step_file, *self._what())

    def _workshop_folder(self) -> Work:
        workshop = Workshop(stock=_own(self._stock), tools=_own(self._tools))
        return partial(fabrication_folder, *self._what(), workshop)

    def _analysis(self) -> Work:
        question = Question(
            load=self._load.value,
            half=self._half.value,
            weight=self._weight.value,
            supports=(self._supports.value,),
            joints=self._joints.value,
        )
        return partial(analysis, *self._what(), question)

    def _what(self) -> tuple[Design, str]:
        return self._session.snapshot().design, self._session.stem

    def _show(self, state: JobState) -> None:
        """Show how far a job is; on the thread of the page's events."""
        running = state.state == "running"
        self._stage.visible = self._bar.visible = self._cancel.visible = running
        self._again.visible = state.state == "done"
        self._result.visible = not running
        if running:
            said = f"<b>{escape(state.what)}</b>: {escape(state.stage)}"
            self._stage.content = f'<div style="padding:{PADDING}">{said}</div>'
            self._bar.animated = state.share is None
            self._bar.value = 100.0 * (1.0 if state.share is None else state.share)
        elif state.made is not None and state.made is not self._shown:
            self._shown = state.made
            self._result.content = _made_html(state.what, state.made)
            self._send(self._client)
        elif state.made is None:
            self._result.content = _failed_html(state)

    def _send(self, client: Any) -> None:
        if self._shown is not None and client is not None:
            client.send_file_download(self._shown.name, self._shown.content, save_immediately=True)


def _own(box: Any) -> str | None:
    """Return the path of a file that is named in a box."""
    named = box.value.strip()
    return os.path.expanduser(named) if named else None


def _made_html(what: str, made: Made) -> str:
    size = len(made.content) / 1e6
    picture = ""
    if made.picture:
        data = base64.b64encode(made.picture).decode()
        picture = (
            f'<img alt="deformed shell" style="width:100%" src="data:image/png;base64,{data}">'
        )
    return (
        f'<div style="padding:{PADDING}"><b>{escape(what)}</b>: {escape(made.name)}, '
        f"{size:.1f} MB{picture}</div>{table_html(made.summary)}"
    )


def _failed_html(state: JobState) -> str:
    colour = GREY if state.state == "cancelled" else css(WRONG)
    return (
        f'<div style="padding:{PADDING};color:{colour};font-size:0.85em;overflow-wrap:anywhere">'
        f"<b>{escape(state.what)}</b>: {escape(state.message)}</div>"
    )
