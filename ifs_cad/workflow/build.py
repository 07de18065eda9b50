"""A part script becomes STEP files in a folder of its own."""

from __future__ import annotations

import os
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.filesize import decimal

from ifs_cad.workflow.part_job import part_script, run_part_job
from ifs_cad.workflow.staging import install, staging
from ifs_cad.workflow.supervise import Listener


@dataclass(frozen=True)
class Written:
    """One file, or one folder of them, that a build wrote.

    Attributes
    ----------
    path : Path
        The file; of flat panels their folder.
    files : int
        How many.
    size : int, bytes
    seconds : float
        Time it took to write.
    """

    path: Path
    files: int
    size: int
    seconds: float

    def __str__(self) -> str:
        count = "" if self.path.suffix == ".step" else f"{self.files} files, "
        return f"{self.path} ({count}{decimal(self.size)}, {self.seconds:.1f} s)"


@dataclass(frozen=True)
class BuildResult:
    """What a build did.

    Attributes
    ----------
    written : tuple of Written
    reports : tuple of str
        The report of each shell that was shown.
    modified : tuple of str
        Addresses of the parts whose shape is no longer their panel's.
    seconds : float
        Of the whole build.
    """

    written: tuple[Written, ...]
    reports: tuple[str, ...]
    modified: tuple[str, ...]
    seconds: float

    def summary(self, heard: str = "") -> str:
        """Return a short account, without the reports that the script has printed itself.

        Parameters
        ----------
        heard : str
            What the script printed.
        """
        lines = [report for report in self.reports if report not in heard]
        if self.modified:
            lines.append(f"No longer the shape of their panel: {', '.join(self.modified)}.")
        lines += [f"Wrote {item}" for item in self.written]
        lines.append(f"Done in {self.seconds:.1f} s.")
        return "\n".join(lines)

    def __str__(self) -> str:
        return self.summary()


def build(
    script: str | os.PathLike[str],
    *,
    settings: Mapping[str, Any] | None = None,
    out: str | os.PathLike[str] = "exports",
    schema: str = "AP214",
    flat_panels: bool = False,
    listener: Listener | None = None,
) -> BuildResult:
    """Run a part script and write what it shows as STEP, in a process of its own.

    One thing shown becomes ``<out>/<script>/<script>.step``, of several each
    ``<script>_<name>.step``. All files arrive, or none does.

    Parameters
    ----------
    script : path
    settings : mapping, optional
        Parameters of the script to change, by name.
    out : path
        Folder of all exports.
    schema : str
        "AP214" or "AP242".
    flat_panels : bool
        Also write every panel alone, lying flat, into ``<script>_panels``. STEP files of an earlier
        build that are there are removed: a workshop must not find panels of two designs.
    listener : Listener, optional
        Hears how far the build has come and what the script prints.

    Raises
    ------
    ScriptError
        The script cannot be read, failed, or showed nothing that can be made.
    InputError
        A setting that the script does not have, or an unknown schema.
    ExportError
        A file could not be written; the old ones are unchanged.
    WorkerError
        The process died; the old files are unchanged.
    KeyboardInterrupt
        With a message: the old files are unchanged.
    """
    begin = time.monotonic()
    script = part_script(script)
    folder = Path(out) / script.stem
    with staging(folder / f"{script.stem}.step") as stage:
        done = run_part_job(
            "build",
            script,
            settings,
            stage,
            folder,
            listener,
            schema=schema,
            flat_panels=flat_panels,
        )
        written = tuple(
            _install(stage, folder, item["places"], item["seconds"]) for item in done["files"]
        )
    return BuildResult(
        written, tuple(done["reports"]), tuple(done["modified"]), time.monotonic() - begin
    )


def _install(stage: Path, folder: Path, places: Iterable[str], seconds: float) -> Written:
    """Move the files of one export from the stage to the folder."""
    targets = [folder / place for place in places]
    for place, target in zip(places, targets, strict=True):
        install(stage / place, target)
    path = targets[0]
    if path.parent != folder:
        path = path.parent
        for old in set(path.glob("*.step")) - set(targets):
            old.unlink()
    size = sum(target.stat().st_size for target in targets)
    return Written(path, len(targets), size, seconds)
