"""The tab of files: presets, save, open, upload, download, script, and what a crash has left."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ifs_cad.design_file import SUFFIX, format_design, parse_design, presets
from ifs_cad.design_record import Design
from ifs_cad.design_script import to_script
from ifs_cad.errors import IfsCadError, InputError
from ifs_cad.studio.bindings import Bindings
from ifs_cad.studio.events import on_click, on_update, on_upload
from ifs_cad.studio.session import UNTITLED, Session, Snapshot
from ifs_cad.studio.words import small_html

Tell = Callable[[Any, str, str, bool], None]
"""Shows a notification to a client: title, text, and whether it is about something good."""

__all__ = ["FileControls"]


class FileControls:
    """Controls of files, added to the container that is open.

    Parameters
    ----------
    gui : viser.GuiApi
    bindings : Bindings
    session : Session
    tell : callable
    fit : callable
        Called when another design is about to come, for the cameras to find it.
    """

    def __init__(
        self, gui: Any, bindings: Bindings, session: Session, tell: Tell, fit: Callable[[], None]
    ) -> None:
        self._bindings = bindings
        self._session = session
        self._tell = tell
        self._fit = fit
        self._gui = gui
        self._asked: Any = None
        with gui.add_folder("Figures of the paper"):
            self._presets(gui)
        with gui.add_folder("Design file on this machine"):
            self._files(gui)
        with gui.add_folder("Through the browser"):
            self._transfers(gui)
        bindings.follow(self._follow)

    def tell_beside(self) -> None:
        """Say what was found beside the file that is open now, and ask what to do with it."""
        if self._session.shared:
            self._say("Open in another studio", self._session.shared, "Go on beside it")
        if self._session.aside:
            self._say("A design that cannot be read", self._session.aside, "Go on without it")
        self._offer_found()

    def _offer_found(self) -> None:
        """Ask about a design that a crash has left, on every page until somebody decides."""
        if self._asked is not None:
            self._asked.close()
            self._asked = None
        if not self._session.found:
            return
        found, *others = self._session.found
        self._asked = self._gui.add_modal("A design that was not saved")
        with self._asked:
            self._gui.add_markdown(
                "The studio ended, or another file was opened, without this design being saved. "
                f"It was kept in `{found.file}`."
            )
            for other in others:
                self._gui.add_markdown(f"The next question is about `{other.file}`, an older one.")
            back = self._gui.add_button("Go on with it")
            drop = self._gui.add_button("Remove it", color="gray")

        def take() -> None:
            self._fit()
            self._session.take_found(found)

        def decide(client: Any, decision: Callable[[], None]) -> None:
            self._try(client, decision)
            self._offer_found()

        on_click(back, lambda event: decide(event.client, take))
        on_click(drop, lambda event: decide(event.client, lambda: self._session.drop_found(found)))

    def _say(self, title: str, text: str, answer: str) -> None:
        modal = self._gui.add_modal(title)
        with modal:
            self._gui.add_html(small_html(text))
            on_click(self._gui.add_button(answer), lambda _: modal.close())

    def _presets(self, gui: Any) -> None:
        titles = {f"{design.title}": design for design in presets().values()}
        chosen = gui.add_dropdown("Figure", tuple(titles), initial_value=list(titles)[-1])
        take = gui.add_button("Take this figure", hint="Undo brings the present design back.")
        on_click(
            take,
            lambda event: self._try(event.client, lambda: self._take(titles[chosen.value])),
        )

    def _take(self, design: Design) -> None:
        self._fit()
        self._session.take(design)
        self._offer_found()

    def _files(self, gui: Any) -> None:
        start = self._session.path or Path(UNTITLED).absolute()
        self._path = gui.add_text("Path", str(start))
        on_update(self._path, lambda _: self._session.withdraw())
        self._saved = gui.add_html("")
        buttons = gui.add_button_group("File", ("Save", "Save as", "Open"))
        buttons.hint = "Save writes the file that is open; the others use the path above."
        actions = {"Save": self._save, "Save as": self._save_as, "Open": self._open}

        def act(event: Any) -> None:
            self._try(event.client, lambda: actions[event.target.value](event.client))

        on_click(buttons, act)

    def _transfers(self, gui: Any) -> None:
        upload = gui.add_upload_button("Upload a design file", mime_type=".toml")
        design = gui.add_button("Download the design file")
        script = gui.add_button(
            "Download as CadQuery script", hint="A part script that makes the same shell."
        )

        def take(event: Any) -> None:
            self._try(event.client, lambda: self._take_upload(event.target.value))

        on_upload(upload, take)
        on_click(design, lambda event: self._send(event.client, SUFFIX, format_design))
        on_click(script, lambda event: self._send(event.client, ".py", to_script))

    def _send(self, client: Any, suffix: str, write: Callable[[Any], str]) -> None:
        text = write(self._session.snapshot().design)
        client.send_file_download(
            f"{self._session.stem}{suffix}", text.encode(), save_immediately=True
        )

    def _take_upload(self, file: Any) -> None:
        try:
            text = file.content.decode("utf-8")
        except UnicodeDecodeError as error:
            raise InputError(f"{file.name} is not UTF-8 text: {error}.") from error
        self._take(parse_design(text, file.name))

    def _save(self, client: Any) -> None:
        if self._session.path is None:
            self._save_as(client)
        else:
            self._save_to(client, self._session.path)

    def _save_as(self, client: Any) -> None:
        self._save_to(client, self._target())

    def _save_to(self, client: Any, target: Path) -> None:
        self._tell(client, "Saved", str(self._session.save(target)), True)
        if self._asked is not None and not self._session.found:
            self._offer_found()

    def _open(self, client: Any) -> None:
        self._fit()
        self._session.open(self._target())
        self.tell_beside()

    def _target(self) -> Path:
        text = self._path.value.strip()
        if not text:
            raise InputError(f"Give the path of a design file, such as shell{SUFFIX}.")
        target = Path(text).expanduser()
        return target if target.suffix else target.with_suffix(SUFFIX)

    def _try(self, client: Any, action: Callable[[], None]) -> None:
        try:
            action()
        except IfsCadError as error:
            self._tell(client, "That was not possible", str(error), False)
        self._bindings.sync()

    def _follow(self, snapshot: Snapshot) -> None:
        name = "no file yet" if self._session.path is None else self._session.path.name
        state = "saved" if snapshot.is_saved and self._session.path else "not saved"
        text = small_html(f"{name}: {state}")
        if self._saved.content != text:
            self._saved.content = text
