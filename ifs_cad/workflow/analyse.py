"""A part script becomes an answer: whether it stands, and how far it gives way."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ifs_cad.workflow.part_job import part_script, run_part_job
from ifs_cad.workflow.question import Question
from ifs_cad.workflow.staging import install, staging
from ifs_cad.workflow.supervise import Listener

MADE = {".csv", ".inp", ".png", ".svg", ".txt", ".vtu"}
"""Files of a former analysis, which must not stay beside those of another."""


@dataclass(frozen=True)
class Analysed:
    """The answer.

    Attributes
    ----------
    folder : Path
    files : tuple of Path
    reports : {name of a shell: its table}
    comparison : str, empty for one shell
    seconds : float
    """

    folder: Path
    files: tuple[Path, ...]
    reports: Mapping[str, str]
    comparison: str
    seconds: float

    def summary(self) -> str:
        """Return all tables and where the files are."""
        lines = [f"{name}\n{report}\n" for name, report in self.reports.items()]
        if self.comparison:
            lines.append(f"{self.comparison}\n")
        lines.append(f"Wrote {self.folder}: {', '.join(path.name for path in self.files)}.")
        lines.append(f"Done in {self.seconds:.1f} s.")
        return "\n".join(lines)

    def __str__(self) -> str:
        return self.summary()


def analyse(
    script: str | os.PathLike[str],
    *,
    settings: Mapping[str, Any] | None = None,
    out: str | os.PathLike[str] = "exports",
    question: Question | None = None,
    listener: Listener | None = None,
) -> Analysed:
    """Run a part script and write how its shells stand into ``<out>/<script>/analysis/``.

    In a process of its own. Files of a former analysis there are removed.

    Parameters
    ----------
    script : path
    settings : mapping, optional
        Parameters of the script to change, by name.
    out : path
        Folder of all exports.
    question : Question, optional
    listener : Listener, optional
        Hears how far the analysis has come and what the script prints.

    Raises
    ------
    ScriptError
        The script cannot be read, failed, or showed no shell of panels.
    MechanismError, InstabilityError
        A shell moves without resistance, or buckles below the load.
    MissingLibraryError
        Kratos is not installed.
    InputError, ExportError
        A value that cannot be meant; a file that could not be written.
    WorkerError
        The process died; the old files are unchanged.
    KeyboardInterrupt
        With a message: the old files are unchanged.
    """
    begin = time.monotonic()
    script = part_script(script)
    folder = Path(out) / script.stem / "analysis"
    with staging(folder) as stage:
        asked = asdict(question or Question())
        done = run_part_job("analyse", script, settings, stage, folder, listener, question=asked)
        files = tuple(folder / path.name for path in sorted(stage.iterdir()))
        for target in files:
            install(stage / target.name, target)
    for old in set(folder.iterdir()) - set(files):
        if old.suffix in MADE:
            old.unlink()
    return Analysed(folder, files, done["reports"], done["comparison"], time.monotonic() - begin)
