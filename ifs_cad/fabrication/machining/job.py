"""Jobs: what programs are verified against, in one file beside them.

`job.json` holds the layout, the workpieces, the tools, the machine and what was asked for, with all
digits, so that a program can be verified long after the design that it was made from has changed.
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ifs_cad.errors import InputError
from ifs_cad.fabrication.layout import Layout, NestedSheet
from ifs_cad.fabrication.machining.convention import LINUXCNC, Convention
from ifs_cad.fabrication.machining.machine import Machine
from ifs_cad.fabrication.machining.plain import from_plain, to_plain
from ifs_cad.fabrication.machining.settings import Settings
from ifs_cad.fabrication.machining.tool import Tool
from ifs_cad.fabrication.workpiece import Workpiece
from ifs_cad.files import replaced

__all__ = ["JOB_FILE", "Job", "find_job", "read_job", "write_job"]

JOB_FILE = "job.json"
FORMAT = "ifs-cad job"
VERSION = 1


@dataclass(frozen=True, eq=False)
class Job:
    """Everything that the programs of one layout follow from.

    Attributes
    ----------
    layout : Layout
    workpieces : all that are placed in it
    tools : tuple of Tool
    machine : Machine
    settings : Settings
    convention : how the controller reads rotary angles and positions
    """

    layout: Layout
    workpieces: tuple[Workpiece, ...]
    tools: tuple[Tool, ...]
    machine: Machine
    settings: Settings
    convention: Convention = LINUXCNC

    def sheet(self, name: str) -> NestedSheet:
        """Return the sheet of a name.

        Raises
        ------
        InputError
            There is none; the message lists those that there are.
        """
        for sheet in self.layout.sheets:
            if sheet.name == name:
                return sheet
        names = ", ".join(sheet.name for sheet in self.layout.sheets)
        raise InputError(f"The job has no sheet {name!r}. It has {names}.")


def write_job(path: str | os.PathLike[str], job: Job) -> Path:
    """Write what the programs of a layout are to be verified against.

    Parameters
    ----------
    path : path of the file; its folder is made when missing
    job : Job

    Returns
    -------
    Path of the written file.

    Raises
    ------
    ExportError
        The file could not be written; what stood there before is unchanged.
    """
    content = {"format": FORMAT, "version": VERSION, **to_plain(job)}
    target = Path(path)
    with replaced(target) as scratch:
        scratch.write_text(json.dumps(content, allow_nan=False), encoding="utf-8", newline="\n")
    return target


def read_job(path: str | os.PathLike[str]) -> Job:
    """Read a job.

    Raises
    ------
    InputError
        The file cannot be read, is no job, is of another version, or has a value that cannot be
        meant; the message names the place.
    """
    source = Path(path)
    try:
        content = json.loads(source.read_text(encoding="utf-8"), parse_constant=_refused)
    except OSError as error:
        raise InputError(f"{source} cannot be read: {error.strerror or error}.") from error
    except ValueError as error:
        raise InputError(f"{source} is not JSON: {error}.") from error
    if not isinstance(content, dict) or content.pop("format", None) != FORMAT:
        raise InputError(f"{source} is no job: its format is not {FORMAT!r}.")
    version = content.pop("version", None)
    if version != VERSION:
        raise InputError(
            f"{source} is of version {version!r}; this program reads version {VERSION}. Make the "
            "programs again."
        )
    job: Job = from_plain(Job, content, source.name)
    return job


def _refused(constant: str) -> Any:
    raise ValueError(f"{constant} is no number")


def find_job(program: str | os.PathLike[str]) -> Path:
    """Return the job of a program: `job.json` in its folder, or in the one above.

    Raises
    ------
    InputError
        There is none.
    """
    folder = Path(program).resolve().parent
    for place in (folder, folder.parent):
        if (place / JOB_FILE).is_file():
            return place / JOB_FILE
    raise InputError(
        f"There is no {JOB_FILE} beside {program} or in the folder above, so there is nothing to "
        "verify it against. Name the job."
    )
