"""Jobs on a part script whose files arrive together or not at all."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ifs_cad.errors import ScriptError, WorkerError
from ifs_cad.workflow.supervise import Listener, run


def part_script(script: str | os.PathLike[str]) -> Path:
    """Return the path of a part script.

    Raises
    ------
    ScriptError
        There is none.
    """
    path = Path(script)
    if not path.is_file():
        raise ScriptError(f"There is no script {path}.")
    return path


def run_part_job(
    job: str,
    script: Path,
    settings: Mapping[str, Any] | None,
    stage: Path,
    folder: Path,
    listener: Listener | None,
    **more: Any,
) -> dict[str, Any]:
    """Run a job that makes files of a part script, in a process of its own.

    Parameters
    ----------
    job : str
        Of `supervise.run`.
    script : Path
    settings : mapping, optional
        Parameters of the script to change, by name.
    stage : Path
        Where the job writes.
    folder : Path
        Where the files will go, for what is said when they do not.
    listener : Listener, optional
    **more
        The other arguments of the job; plain JSON.

    Raises
    ------
    IfsCadError
        Whatever the job raised.
    WorkerError
        The process died; says that the folder is unchanged.
    KeyboardInterrupt
        With the same message.
    """
    plain = {name: str(value) for name, value in (settings or {}).items()}
    arguments = {"script": str(script), "settings": plain, "stage": str(stage), **more}
    try:
        return run(job, arguments, listener or Listener())
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"Interrupted; nothing in {folder} was changed.") from None
    except WorkerError as error:
        raise WorkerError(f"{error}\nNothing in {folder} was changed.") from error
