"""A part script becomes a folder with everything that a workshop needs.

The folder is made beside the former one and takes its place as a whole. Files in the former folder
that no run made, the user's own, come along.
"""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.filesize import decimal

from ifs_cad.errors import ExportError
from ifs_cad.fabrication.workshop import Workshop
from ifs_cad.workflow.manifest import NAME, read_manifest
from ifs_cad.workflow.part_job import part_script, run_part_job
from ifs_cad.workflow.staging import staging
from ifs_cad.workflow.supervise import Listener

FORMER = ".former"
"""What is added to the name of a folder while the new one takes its place."""


@dataclass(frozen=True)
class Fabricated:
    """What a run wrote.

    Attributes
    ----------
    folder : Path
    files : int
    size : int, bytes
    stages : (what, seconds) of each kind of file
    report : str
    modified : addresses of the parts whose shape is no longer their panel's
    seconds : float, of the whole run
    """

    folder: Path
    files: int
    size: int
    stages: tuple[tuple[str, float], ...]
    report: str
    modified: tuple[str, ...]
    seconds: float

    def summary(self) -> str:
        """Return a short account."""
        lines = [self.report]
        if self.modified:
            lines.append(
                "No longer the shape of their panel, so drawings, lists and programs do not show "
                f"what was changed: {', '.join(self.modified)}."
            )
        stages = ", ".join(f"{what} {seconds:.1f} s" for what, seconds in self.stages)
        lines += [
            f"Wrote {self.folder} ({self.files} files, {decimal(self.size)}): {stages}.",
            f"Look at {self.folder / 'index.html'}.",
            f"Done in {self.seconds:.1f} s.",
        ]
        return "\n".join(lines)

    def __str__(self) -> str:
        return self.summary()


def fabricate(
    script: str | os.PathLike[str],
    *,
    settings: Mapping[str, Any] | None = None,
    out: str | os.PathLike[str] = "exports",
    workshop: Workshop | None = None,
    listener: Listener | None = None,
) -> Fabricated:
    """Run a part script and write all that a workshop needs into ``<out>/<script>/``.

    Parameters
    ----------
    script : path
    settings : mapping, optional
        Parameters of the script to change, by name.
    out : path
        Folder of all exports.
    workshop : Workshop, optional
        Stock, cutter and the other decisions of the workshop.
    listener : Listener, optional
        Hears how far the run has come and what the script prints.

    Raises
    ------
    ScriptError
        The script cannot be read, failed, or did not show one assembly made by `to_assembly`.
    StockError
        No stock fits, or there is not enough of it.
    ExportError
        A file could not be written; the former folder is unchanged.
    WorkerError
        The process died; the former folder is unchanged.
    KeyboardInterrupt
        With a message: the former folder is unchanged.
    """
    begin = time.monotonic()
    script, workshop = part_script(script), workshop or Workshop()
    folder = Path(out) / script.stem
    _recover(folder)
    with staging(folder) as stage:
        new = stage / folder.name
        done = run_part_job(
            "fabricate", script, settings, new, folder, listener, workshop=workshop.as_dict()
        )
        made = read_manifest(new)
        _take_along(folder, new)
        _swap(new, folder)
    return Fabricated(
        folder,
        len(made) + 1,
        sum(entry["bytes"] for entry in made.values()),
        tuple(done["seconds"].items()),
        done["report"],
        tuple(done["modified"]),
        time.monotonic() - begin,
    )


def _take_along(former: Path, new: Path) -> None:
    """Copy the files of the former folder that no run made, unless a new one has their place."""
    if not former.is_dir():
        return
    made = {*read_manifest(former), NAME}
    try:
        for path in sorted(former.rglob("*")):
            place = path.relative_to(former)
            if path.is_dir() or place.as_posix() in made or (new / place).exists():
                continue
            (new / place).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(path, new / place, follow_symlinks=False)
    except OSError as error:
        raise ExportError(
            f"{path} could not be taken along into the new folder: {error.strerror}. Move it away; "
            "nothing was changed."
        ) from error


def _swap(new: Path, folder: Path) -> None:
    former = folder.with_name(folder.name + FORMER)
    try:
        if folder.exists():
            folder.rename(former)
        new.rename(folder)
    except OSError as error:
        _recover(folder)
        raise ExportError(
            f"The new folder could not take the place of {folder}: {error.strerror}. Is a file in "
            "it open? The former folder is unchanged."
        ) from error
    shutil.rmtree(former, ignore_errors=True)


def _recover(folder: Path) -> None:
    """Put back the former folder when an earlier run died while the new one took its place."""
    former = folder.with_name(folder.name + FORMER)
    if former.exists() and not folder.exists():
        former.rename(folder)
    elif former.exists():
        shutil.rmtree(former, ignore_errors=True)
