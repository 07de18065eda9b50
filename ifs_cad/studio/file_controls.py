"""The tab of files: presets, save, open, upload, download, script, and what a crash has left."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ifs_cad.design_file import SUFFIX, format_design, parse_design, presets
from ifs_cad.design_script import to_script
from ifs_cad.errors import IfsCadError, InputError
from ifs_cad.studio.bindings import Bindings
from ifs_cad.studio.events import on_click, on_upload
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
        self._to_replace: Path | None = None
        with gui.add_folder("Figures of the paper"):
            self._presets(gui)
        with gui.add_folder("Design file on this machine"):
            self._files(gui)
        with gui.add_folder("Through the browser"):
            self._transfers(gui)
        bindings.follow(self._follow)

    def offer_found(self, gui: Any) -> None:
        """Ask what to do with a design that a crash has left, if there is one."""
        if self._session.aside:
            self._say_moved_aside(gui)
        if self._session.found is None:
            return
        modal = gui.add_modal("A design that was not saved")
        with modal:
            gui.add_markdown(
                "The studio ended the last time without this design being saved. It was kept in "
                f"`{self._session.autosave_file}`."
            )
            back, drop = gui.add_button("Go on with it"), gui.add_button("Remove it", color="gray")

        def take(_: Any) -> None:
            modal.close()
            self._fit()
            self._session.take_found()
            self._bindings.sync()

        def remove(event: Any) -> None:
            modal.close()
            self._try(event.client, self._session.drop_found)

        on_click(back, take)
        on_click(drop, remove)

    def _say_moved_aside(self, gui: Any) -> None:
        modal = gui.add_modal("A design that cannot be read")
        with modal:
            gui.add_html(small_html(self._session.aside))
            on_click(gui.add_button("Go on without it"), lambda _: modal.close())

    def _presets(self, gui: Any) -> None:
        titles = {f"{design.title}": design for design in presets().values()}
        chosen = gui.add_dropdown("Figure", tuple(titles), initial_value=list(titles)[-1])
        take = gui.add_button("Take this figure", hint="Undo brings the present design back.")

        def take_figure(_: Any) -> None:
            self._fit()
            self._bindings.edit(lambda model: model.take(titles[chosen.value]))

        on_click(take, take_figure)

    def _files(self, gui: Any) -> None:
        start = self._session.path or Path(UNTITLED).absolute()
        self._path = gui.add_text("Path", str(start))
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
        design = parse_design(text, file.name)
        self._fit()
        self._session.edit(lambda model: model.take(design))

    def _save(self, client: Any) -> None:
        if self._session.path is None:
            self._save_as(client)
        else:
            self._save_to(client, self._session.path)

    def _save_as(self, client: Any) -> None:
        target = self._target()
        if target.exists() and target != self._session.path and target != self._to_replace:
            self._to_replace = target
            raise InputError(f"{target} exists. Press once more to replace it.")
        self._to_replace = None
        self._save_to(client, target)

    def _save_to(self, client: Any, target: Path) -> None:
        if self._session.found is not None:  # asked of another client, or before a reload
            self.offer_found(client.gui)
        self._tell(client, "Saved", str(self._session.save(target)), True)

    def _open(self, client: Any) -> None:
        self._fit()
        self._session.open(self._target())
        self.offer_found(client.gui)

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
