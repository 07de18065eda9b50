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
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from ifs_cad.design_file import read_design
from ifs_cad.design_record import Design
from ifs_cad.errors import ExportError, IfsCadError, InputError
from ifs_cad.studio.kept import Beside, Place, Remainder, look_beside, remaining_files
from ifs_cad.studio.model import StudioModel, recover
from ifs_cad.studio.replacing import ReplaceGuard, is_same_file

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
        self._guard = ReplaceGuard(self.path)
        exists = self.path is not None and self.path.exists()
        self._model = StudioModel(read_design(self.path) if self.path and exists else None)
        self._found: tuple[Remainder, ...] = ()
        self._left_behind: list[Path] = []
        self._keep_beside(look_beside(self._home))

    @property
    def autosave_file(self) -> Path:
        """Where the design is kept by itself."""
        return self._place.file

    @property
    def stem(self) -> str:
        """What exports are named after."""
        return (self.path or Path(UNTITLED)).stem

    @property
    def found(self) -> tuple[Remainder, ...]:
        """What a crash has left, newest first; `take_found` and `drop_found` decide about it."""
        return self._found

    @property
    def left_behind(self) -> list[Path]:
        """Files that hold what was neither saved nor removed, besides the design as it is."""
        files = [*(remainder.file for remainder in self._found), *self._left_behind]
        own = self.autosave_file
        return [file for file in dict.fromkeys(files) if file != own and file.exists()]

    @property
    def shared(self) -> str:
        """What to tell the user about another studio with the same design; empty without one."""
        if not self._place.is_shared:
            return ""
        name = "A design without a file" if self.path is None else str(self.path)
        return (
            f"{name} is also open in another studio. What is not saved here is kept apart, in "
            f"{self.autosave_file}."
        )

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
            self._guard.withdraw()
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

        A file that holds what was neither read nor written here is replaced only by the second of
        two calls with nothing between them.

        Parameters
        ----------
        path : path, optional
            The file of the session by default.

        Raises
        ------
        InputError
            The file would be replaced and that was not asked for twice, or a crash has left a
            design beside another file than the present one; all is as it was.
        ExportError
            It could not be written; all is as it was.
        """
        with self._lock:
            self._end_gesture()
            target = Path(path or self.path or UNTITLED)
            self._refuse_to_forget(target)
            self._guard.refuse_once(target)
            self._model.save(target)
            self._forget_saved()
            if not is_same_file(target, self._home):
                self._leave()
                self._keep_in(Place(target, remaining_files(target)))
            self.path = target
            self._guard = ReplaceGuard(target)
            self._tell()
            return target

    def withdraw(self) -> None:
        """Forget that replacing a file was asked for once."""
        self._guard.withdraw()

    def open(self, path: str | os.PathLike[str]) -> None:
        """Read a design file, from then on the file of the session.

        It cannot be undone: saving would write the former design over this file. What was not
        saved of that one is kept beside its own file.

        Raises
        ------
        InputError
            It cannot be read; all is as it was.
        ExportError
            What a crash has left beside it cannot be read, nor moved aside; all is as it was.
        """
        with self._lock:
            self._guard.withdraw()
            self._end_gesture()
            self.autosave()
            target = Path(path)
            guard = ReplaceGuard(target)
            read_design(target)  # what lies beside a broken file stays there
            beside = look_beside(target, self.autosave_file)
            was_saved = self._model.is_saved
            self._model.load(target)
            self._leave(was_saved)
            self.path, self._guard = target, guard
            self._keep_beside(beside)
            self._tell()

    def take(self, design: Design) -> None:
        """Go on with another design, which has no file yet; it can be undone.

        Raises
        ------
        ExportError
            The present design could not be kept; all is as it was.
        """
        with self._lock:
            if self.path is not None:
                self._end_gesture()
                self.autosave()
                self._leave()
                self.path, self._guard = None, ReplaceGuard()
                self._keep_in(Place(self._home, remaining_files(self._home)))
            self.edit(lambda model: model.take(design))

    def autosave(self) -> bool:
        """Keep the design where it survives a crash, and tell whether that was needed.

        Never over a design that a crash has left and nobody has decided about: that one has a
        file of its own.

        Raises
        ------
        ExportError
            It could not be written.
        """
        with self._lock:
            return self._model.autosave()

    def close(self) -> None:
        """Let another studio have the file that the design is kept in."""
        with self._lock:
            self._place.release()

    def take_found(self, remainder: Remainder) -> None:
        """Go on with what a crash has left; it can be undone.

        It stays in its file until it is saved. What was shaped before and not saved stays in the
        file of that.

        Raises
        ------
        ExportError
            The present design could not be kept; all is as it was.
        """
        with self._lock:
            if remainder not in self._found:  # decided on another page
                return
            self._end_gesture()
            self.autosave()
            if not self._model.is_saved:
                self._left_behind.append(self.autosave_file)
            self._found = tuple(other for other in self._found if other != remainder)
            self._place.move_to(remainder.file)
            self._model.keep_in(remainder.file, holds=remainder.design)
            self.edit(lambda model: model.take(remainder.design))

    def drop_found(self, remainder: Remainder) -> None:
        """Remove what a crash has left.

        Raises
        ------
        ExportError
            It cannot be removed.
        """
        with self._lock:
            if remainder not in self._found:
                return
            try:
                remainder.file.unlink(missing_ok=True)
            except OSError as error:
                raise ExportError(f"Cannot remove {remainder.file}: {error.strerror}.") from error
            self._found = tuple(other for other in self._found if other != remainder)

    @property
    def _home(self) -> Path:
        """What the autosave files are named after."""
        return self.path or Path(UNTITLED)

    def _keep_beside(self, beside: Beside) -> None:
        self._aside = beside.aside
        self._found = tuple(
            remainder for remainder in beside.remainders if remainder.design != self._model.design
        )
        self._keep_in(Place(self._home, [remainder.file for remainder in self._found]))

    def _keep_in(self, place: Place) -> None:
        self._place = place
        self._model.keep_in(place.file)

    def _leave(self, was_saved: bool | None = None) -> None:
        """Let go of the present file's autosave; what it holds and is not saved stays there."""
        is_saved = self._model.is_saved if was_saved is None else was_saved
        self._left_behind = self.left_behind
        if not is_saved:
            self._left_behind.append(self.autosave_file)
        self._found, self._aside = (), ""
        self._place.release()

    def _forget_saved(self) -> None:
        """Remove what was left behind in this session and is the same as what was saved."""
        for file in self._left_behind:
            with suppress(IfsCadError, OSError):  # what cannot be read is not known to be saved
                if recover(file) == self._model.design:
                    file.unlink(missing_ok=True)

    def _refuse_to_forget(self, target: Path) -> None:
        """Raise an error when a crash has left a design of a file that was not opened."""
        if is_same_file(target, self._home):
            return
        for kept in remaining_files(target):
            if any(is_same_file(kept, own) for own in self._left_behind):
                continue
            way = "Open" if target.exists() else "Start the studio with"
            raise InputError(
                f"A crash has left a design of {target.name} in {kept}. {way} {target} to see it, "
                "save under another name, or move that file away."
            )

    def _step(self, step: Callable[[StudioModel], bool]) -> bool:
        with self._lock:
            self._guard.withdraw()
            self._gesture = ""
            done = step(self._model)
            self._tell()
            return done

    def _end_gesture(self) -> None:
        self._gesture = ""
        self._model.end_drag()

    def _tell(self) -> None:
        self.changed(self.snapshot())
