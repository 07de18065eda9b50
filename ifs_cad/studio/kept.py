"""What the studio keeps beside a design file by itself, so that no crash loses it.

Terms
-----
place : one of the autosave files of a design. There may be several: what a crash has left stays in
    its own until somebody decides about it, and each studio writes to one that no other writes to.
remainder : a design in such a file that no running studio writes to.
"""

from __future__ import annotations

import os
import re
from collections.abc import Collection
from contextlib import suppress
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any

from ifs_cad.design_record import Design
from ifs_cad.errors import ExportError, InputError
from ifs_cad.studio.model import autosave_path, recover

LOCKED = ".lock"
"""Ends the name of the file by which a running studio says that an autosave is its own. The system
lets go of it with the process, so that the lock of a studio that crashed holds nobody up."""

__all__ = ["Beside", "Place", "Remainder", "look_beside", "remaining_files"]


@dataclass(frozen=True)
class Remainder:
    """A design that was kept and not saved.

    Attributes
    ----------
    file : Path
        Where it is kept.
    design : Design
    """

    file: Path
    design: Design


@dataclass(frozen=True)
class Beside:
    """What is kept beside a design file.

    Attributes
    ----------
    remainders : tuple of Remainder
        The newest first, each design once.
    aside : str
        What to tell the user about files that cannot be read and were renamed; empty without one.
    """

    remainders: tuple[Remainder, ...]
    aside: str


class Place:
    """An autosave file that no other studio writes to until it is released.

    Parameters
    ----------
    path : Path
        The design file.
    spared : collection of Path
        Autosave files that are not taken.

    Attributes
    ----------
    file : Path
    is_shared : bool
        Whether another studio keeps the same design.
    """

    def __init__(self, path: Path, spared: Collection[Path] = ()) -> None:
        self.is_shared = any(_is_held(file) for file in _locked_files(path))
        for number in count(1):
            self.file = autosave_path(path, number)
            if self.file not in spared:
                self._lock = _lock(self.file)
                if self._lock.is_locked or not _is_held(self.file):
                    break  # where no lock can be made, nothing can be kept either

    def move_to(self, file: Path) -> None:
        """Write to another autosave file of the same design."""
        self.release()
        self.file, self._lock = file, _lock(file)

    def release(self) -> None:
        """Let other studios have the file."""
        if self._lock.is_locked:
            _remove_lock(self._lock)


def remaining_files(path: Path, own: Path | None = None) -> list[Path]:
    """Return the autosave files of a design that no other studio writes to, the newest first.

    Parameters
    ----------
    path : Path
        The design file.
    own : Path, optional
        The one that the asking studio writes to.
    """
    files = [file for file in _files(path, "") if file == own or not _is_held(file)]
    return sorted(files, key=lambda file: file.stat().st_mtime, reverse=True)


def look_beside(path: Path, own: Path | None = None) -> Beside:
    """Read what is kept beside a design file, and rename what cannot be read.

    Parameters
    ----------
    path, own
        As of `remaining_files`.

    Raises
    ------
    ExportError
        A file can neither be read nor renamed.
    """
    remainders: list[Remainder] = []
    asides: list[str] = []
    for file in remaining_files(path, own):
        try:
            design = recover(file)
        except InputError as error:
            asides.append(_moved_aside(file, error))
            continue
        if design is not None and all(design != other.design for other in remainders):
            remainders.append(Remainder(file, design))
    return Beside(tuple(remainders), "\n".join(asides))


def _files(path: Path, ending: str) -> list[Path]:
    first = autosave_path(path)
    name = re.compile(
        rf"{re.escape(first.stem)}(-[0-9]+)?{re.escape(first.suffix)}{re.escape(ending)}"
    )
    try:
        return [file for file in path.parent.iterdir() if name.fullmatch(file.name)]
    except OSError:  # a folder that is not there holds nothing
        return []


def _locked_files(path: Path) -> list[Path]:
    return [file.with_suffix("") for file in _files(path, LOCKED)]


def _lock(file: Path) -> Any:
    """Return the lock of an autosave file, held unless another studio has it."""
    from filelock import FileLock, Timeout

    lock = FileLock(f"{file}{LOCKED}", blocking=False, thread_local=False)
    try:
        if file.parent.is_dir():  # which the library would make
            lock.acquire()
    except (Timeout, OSError, NotImplementedError):
        pass  # the lock tells by itself that it is not held
    return lock


def _is_held(file: Path) -> bool:
    place = file.with_name(f"{file.name}{LOCKED}")
    if not place.exists():
        return False
    lock = _lock(file)
    if not lock.is_locked:
        return os.access(place, os.W_OK)
    _remove_lock(lock)
    return False


def _remove_lock(lock: Any) -> None:
    with suppress(OSError):  # then an empty file stays behind, which holds nobody up
        Path(lock.lock_file).unlink(missing_ok=True)
    lock.release()


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
