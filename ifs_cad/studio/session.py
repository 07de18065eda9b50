"""A studio model that a page's callbacks, its clock and its workers share.

Terms
-----
gesture : edits that belong together, such as all positions of a slider that is being drawn. They
    become one step of the history. A gesture ends with another one, by `settle`, or when nothing
    was edited for a while.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ifs_cad.design_file import read_design
from ifs_cad.design_record import Design
from ifs_cad.errors import ExportError, InputError
from ifs_cad.studio.model import StudioModel, autosave_path, recover

QUIET_SECONDS = 0.6
"""A gesture without a mouse button ends after so long without an edit."""

UNTITLED = "untitled.toml"

__all__ = ["Session", "Snapshot"]


@dataclass(frozen=True)
class Snapshot:
    """A state of the session.

    Attributes
    ----------
    design : Design
    gesture : str, empty between gestures
    can_undo, can_redo, is_saved : bool
    """

    design: Design
    gesture: str
    can_undo: bool
    can_redo: bool
    is_saved: bool


class Session:
    """A model with a file and a lock.

    Parameters
    ----------
    path : path, optional
        The design file. When it does not exist yet, saving makes it. Without one the design has
        no file, and its autosave is in the current folder.
    changed : callable
        Called with the newest `Snapshot` after every change, by the thread that made it.
    quiet : float, seconds
        How long a gesture lasts without an edit.

    Raises
    ------
    InputError
        The file cannot be read.
    ExportError
        What a crash has left beside it cannot be read, nor moved aside.
    """

    def __init__(
        self,
        path: str | os.PathLike[str] | None = None,
        changed: Callable[[Snapshot], None] = lambda snapshot: None,
        quiet: float = QUIET_SECONDS,
    ) -> None:
        self.path = None if path is None else Path(path)
        self.changed = changed
        self._quiet = quiet
        self._lock = threading.RLock()
        self._gesture = ""
        self._is_held = False
        self._edited = 0.0
        exists = self.path is not None and self.path.exists()
        self._model = StudioModel(read_design(self.path) if self.path and exists else None)
        self._found: Design | None = None
        self._aside = ""
        self._keep_beside(self.path, _left(self.autosave_file))

    @property
    def autosave_file(self) -> Path:
        """Where the design is kept by itself."""
        return autosave_path(self.path or UNTITLED)

    @property
    def stem(self) -> str:
        """What exports are named after."""
        return (self.path or Path(UNTITLED)).stem

    @property
    def found(self) -> Design | None:
        """What a crash has left, until `take_found` or `drop_found` decides about it."""
        return self._found

    @property
    def aside(self) -> str:
        """What to tell the user about a kept design that cannot be read; empty without one."""
        return self._aside

    def snapshot(self) -> Snapshot:
        """Return the state as it is."""
        with self._lock:
            model = self._model
            return Snapshot(
                model.design, self._gesture, model.can_undo, model.can_redo, model.is_saved
            )

    def edit(
        self,
        change: Callable[[StudioModel], object],
        gesture: str = "",
        *,
        held: bool = False,
    ) -> None:
        """Change the model.

        Parameters
        ----------
        change : callable
            Takes the model; what it raises is passed on and leaves the design as it was.
        gesture : str, optional
            What the edit is a part of; none by default.
        held : bool
            The gesture lasts until `settle`, as long as the mouse button is held.
        """
        with self._lock:
            if gesture != self._gesture or not gesture:
                self._end_gesture()
                if gesture:
                    self._model.begin_drag()
                    self._gesture, self._is_held = gesture, held
            self._edited = time.monotonic()
            change(self._model)
            self._tell()

    def settle(self) -> None:
        """End the gesture that goes on, if there is one."""
        with self._lock:
            if self._gesture:
                self._end_gesture()
                self._tell()

    def settle_if_quiet(self) -> bool:
        """End a gesture that nothing was heard of for a while, and tell whether one ended."""
        with self._lock:
            is_quiet = time.monotonic() - self._edited > self._quiet
            if not self._gesture or self._is_held or not is_quiet:
                return False
            self.settle()
            return True

    def undo(self) -> bool:
        """Take one step back, and tell whether there was one."""
        return self._step(StudioModel.undo)

    def redo(self) -> bool:
        """Do an undone step again, and tell whether there was one."""
        return self._step(StudioModel.redo)

    def save(self, path: str | os.PathLike[str] | None = None) -> Path:
        """Write the design file, from then on this one.

        Parameters
        ----------
        path : path, optional
            The file of the session by default.

        Raises
        ------
        InputError
            A crash has left a design that saving would remove or forget; all is as it was.
        ExportError
            It could not be written; all is as it was.
        """
        with self._lock:
            self._end_gesture()
            target = Path(path or self.path or UNTITLED)
            self._refuse_to_lose(target)
            self._model.save(target)
            self.path = target
            self._model.keep_in(autosave_path(target))
            self._tell()
            return target

    def open(self, path: str | os.PathLike[str]) -> None:
        """Read a design file, from then on the file of the session; it can be undone.

        Raises
        ------
        InputError
            It cannot be read; all is as it was.
        ExportError
            What a crash has left beside it cannot be read, nor moved aside; all is as it was.
        """
        with self._lock:
            self.autosave()
            target = Path(path)
            read_design(target)  # what lies beside a broken file stays there
            left = _left(autosave_path(target))
            self._end_gesture()
            self._model.load(target)
            self.path = target
            self._keep_beside(target, left)
            self._tell()

    def autosave(self) -> bool:
        """Keep the design where it survives a crash, and tell whether that was needed.

        Never over a design that a crash has left and nobody has decided about.

        Raises
        ------
        ExportError
            It could not be written.
        """
        with self._lock:
            return self._found is None and self._model.autosave()

    def take_found(self) -> None:
        """Go on with what a crash has left; it can be undone."""
        with self._lock:
            if self._found is not None:
                found, self._found = self._found, None
                self.edit(lambda model: model.take(found))

    def drop_found(self) -> None:
        """Remove what a crash has left."""
        with self._lock:
            self._found = None
            self._model.discard_autosave()

    def _keep_beside(self, path: Path | None, left: tuple[Design | None, str]) -> None:
        found, self._aside = left
        self._found = found if found != self._model.design else None
        self._model.keep_in(autosave_path(path or UNTITLED))

    def _refuse_to_lose(self, target: Path) -> None:
        """Raise an error when saving would remove, or later write over, what a crash has left."""
        if self._found is not None:
            raise InputError(
                f"A crash has left a design in {self.autosave_file} that saving would remove. "
                "First go on with it, or remove it."
            )
        kept = autosave_path(target)
        if kept.resolve() != self.autosave_file.resolve() and kept.exists():
            way = "Open" if target.exists() else "Start the studio with"
            raise InputError(
                f"A crash has left a design of {target.name} in {kept}. {way} {target} to see it, "
                "save under another name, or move that file away."
            )

    def _step(self, step: Callable[[StudioModel], bool]) -> bool:
        with self._lock:
            self._gesture = ""
            done = step(self._model)
            self._tell()
            return done

    def _end_gesture(self) -> None:
        self._gesture = ""
        self._model.end_drag()

    def _tell(self) -> None:
        self.changed(self.snapshot())


def _left(kept: Path) -> tuple[Design | None, str]:
    """Return what a crash has left, and what to say when it had to be moved aside."""
    try:
        return recover(kept), ""
    except InputError as error:
        return None, _moved_aside(kept, error)


def _moved_aside(kept: Path, error: InputError) -> str:
    """Rename a kept design that cannot be read, for the next one to have its place; say so."""
    place = kept.with_suffix(f".bad{kept.suffix}")
    number = 1
    while place.exists():
        number += 1
        place = kept.with_suffix(f".bad{number}{kept.suffix}")
    try:
        kept.rename(place)
    except OSError as failure:
        raise ExportError(
            f"{error}\nIt is what a crash has left, and cannot be moved aside: "
            f"{failure.strerror}. Move {kept} away."
        ) from error
    return f"What a crash has left cannot be read, and was moved to {place}. {error}"
