"""Long work on a design: one job at a time, in a process of its own, watched by a thread.

A job works on a copy of the design in a folder that vanishes with it; what it made comes back as
bytes, to be downloaded.
"""

from __future__ import annotations

import shutil
import tempfile
import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from ifs_cad.design_file import SUFFIX, write_design
from ifs_cad.design_record import Design
from ifs_cad.errors import IfsCadError, InputError
from ifs_cad.fabrication.workshop import Workshop
from ifs_cad.workflow.analyse import analyse
from ifs_cad.workflow.build import build
from ifs_cad.workflow.fabricate import fabricate
from ifs_cad.workflow.question import Question
from ifs_cad.workflow.supervise import Listener

State = Literal["none", "running", "done", "failed", "cancelled"]

__all__ = ["JobRunner", "JobState", "Made", "analysis", "fabrication_folder", "step_file"]


@dataclass(frozen=True)
class Made:
    """What a job made.

    Attributes
    ----------
    name : str
        Of the file.
    content : bytes
    summary : str
    picture : bytes
        A PNG, empty when there is none.
    """

    name: str
    content: bytes
    summary: str
    picture: bytes = b""


@dataclass(frozen=True)
class JobState:
    """How far the present or the last job is.

    Attributes
    ----------
    what : str
        What is made, in words.
    state : str
    stage : str
        What is being done.
    share : float or None
        Of the stage, from 0 to 1; None when it is not known.
    message : str
        Why it failed or was cancelled.
    made : Made or None
    """

    what: str = ""
    state: State = "none"
    stage: str = ""
    share: float | None = None
    message: str = ""
    made: Made | None = None


Work = Callable[[Listener], Made]


class JobRunner:
    """Runs one job at a time.

    Parameters
    ----------
    changed : callable
        Takes every new `JobState`, in the thread of the job.
    """

    def __init__(self, changed: Callable[[JobState], None]) -> None:
        self._changed = changed
        self._state = JobState()
        self._lock = threading.Lock()
        self._cancelled = threading.Event()
        self._thread: threading.Thread | None = None

    @property
    def state(self) -> JobState:
        """How far the present or the last job is."""
        return self._state

    def start(self, what: str, work: Work) -> None:
        """Begin a job.

        Parameters
        ----------
        what : str
            What is made, in words.
        work : callable
            Takes a listener and returns what it made; `functools.partial` of a function below.

        Raises
        ------
        InputError
            Another one goes on.
        """
        with self._lock:
            if self._state.state == "running":
                raise InputError(f"{self._state.what} is being made. Wait for it, or cancel it.")
            self._state = JobState(what, "running", "starting")
        self._cancelled.clear()
        self._changed(self._state)
        self._thread = threading.Thread(target=self._run, args=(work,), name="job", daemon=True)
        self._thread.start()

    def cancel(self) -> None:
        """End the job that goes on, if there is one."""
        self._cancelled.set()

    def wait(self, timeout: float | None = None) -> bool:
        """Wait for the job, and tell whether it ended."""
        if self._thread is None:
            return True
        self._thread.join(timeout)
        return not self._thread.is_alive()

    def close(self) -> None:
        """End the job with its process."""
        self.cancel()
        self.wait(10.0)

    def _run(self, work: Work) -> None:
        try:
            made = work(_Ear(self._cancelled, self._hear))
        except KeyboardInterrupt:  # as jobs end when they are interrupted
            self._become(state="cancelled", message="Cancelled; nothing was made.")
        except IfsCadError as error:
            self._become(state="failed", message=str(error))
        except Exception as error:
            self._become(state="failed", message=f"{type(error).__name__}: {error}")
        else:
            self._become(state="done", made=made, share=1.0)

    def _hear(self, stage: str, done: int, total: int | None) -> None:
        self._become(stage=stage, share=done / total if total else None)

    def _become(
        self,
        state: State = "running",
        stage: str = "",
        share: float | None = None,
        message: str = "",
        made: Made | None = None,
    ) -> None:
        self._state = replace(
            self._state, state=state, stage=stage, share=share, message=message, made=made
        )
        self._changed(self._state)


class _Ear(Listener):
    """Passes on how far a job is, and ends it when it was cancelled."""

    def __init__(
        self, cancelled: threading.Event, hear: Callable[[str, int, int | None], None]
    ) -> None:
        super().__init__()
        self._cancelled = cancelled
        self._hear = hear

    def stage(self, name: str, done: int, total: int | None) -> None:
        """Pass it on."""
        self.idle()
        self._hear(name, done, total)

    def idle(self) -> None:
        """End the job if it was cancelled."""
        if self._cancelled.is_set():
            raise KeyboardInterrupt


def step_file(design: Design, stem: str, listener: Listener) -> Made:
    """Build a design as a STEP file; raises what `build` raises."""
    with tempfile.TemporaryDirectory(prefix="ifs-cad-") as scratch:
        result = build(_written(design, stem, scratch), out=Path(scratch, "out"), listener=listener)
        path = result.written[0].path
        return Made(path.name, path.read_bytes(), "\n".join(result.reports))


def fabrication_folder(design: Design, stem: str, workshop: Workshop, listener: Listener) -> Made:
    """Make all that a workshop needs, as a zip file; raises what `fabricate` raises."""
    with tempfile.TemporaryDirectory(prefix="ifs-cad-") as scratch:
        source = _written(design, stem, scratch)
        out = Path(scratch, "out")
        result = fabricate(source, out=out, workshop=workshop, listener=listener)
        listener.stage("packing", 0, None)
        return _packed(result.folder, stem, result.report)


def analysis(design: Design, stem: str, question: Question, listener: Listener) -> Made:
    """Compute whether a design stands, as a zip file; raises what `analyse` raises."""
    with tempfile.TemporaryDirectory(prefix="ifs-cad-") as scratch:
        source = _written(design, stem, scratch)
        result = analyse(source, out=Path(scratch, "out"), question=question, listener=listener)
        picture = next((path for path in result.files if path.suffix == ".png"), None)
        shown = b"" if picture is None else picture.read_bytes()
        packed = _packed(result.folder, f"{stem}_analysis", "\n".join(result.reports.values()))
        return replace(packed, picture=shown)


def _written(design: Design, stem: str, folder: str) -> Path:
    return write_design(design, Path(folder, f"{stem}{SUFFIX}"))


def _packed(folder: Path, name: str, summary: str) -> Made:
    target = folder.parent / name
    made = Path(shutil.make_archive(f"{target}.packed", "zip", folder.parent, folder.name))
    return Made(f"{name}.zip", made.read_bytes(), summary)
