"""The parent of jobs: starts the worker, passes on what it says, ends it at once.

The parent loads no kernel. Whatever ends the wait for the worker (an error, Ctrl-C) kills it,
with every process that it started.
"""

from __future__ import annotations

import contextlib
import json
import os
import queue
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from typing import IO, Any

from ifs_cad import errors
from ifs_cad.errors import IfsCadError, WorkerError

# The worker imports from where we do, wherever it is started: not from its current folder.
START = "import sys; sys.path[:] = sys.argv[1:]; from ifs_cad.workflow.worker import main; main()"
POLL_SECONDS = 0.1
LAST_WORDS = 10  # lines


class Listener:
    """Hears what a job says; this one keeps it to itself.

    Attributes
    ----------
    heard : str
        What the script printed so far.
    """

    def __init__(self) -> None:
        self.heard = ""

    def stage(self, name: str, done: int, total: int | None) -> None:
        """Hear how far a stage has come; see `ifs_cad.progress.report`."""

    def text(self, line: str, stream: str) -> None:
        """Hear a line that a script printed to "stdout" or "stderr"."""
        self.heard += f"{line}\n"

    def idle(self) -> None:
        """Hear nothing for a moment; whoever wants the job to end raises an exception here."""


Job = Callable[[str, dict[str, Any]], dict[str, Any]]


def run(job: str, arguments: dict[str, Any], listener: Listener) -> dict[str, Any]:
    """Run a job of `worker` in a process of its own and return its result.

    Parameters
    ----------
    job : str
        A key of `worker.JOBS`.
    arguments : dict
        Of the job's function; plain JSON.
    listener : Listener

    Raises
    ------
    IfsCadError
        Whatever the job raised.
    WorkerError
        The process died, or the job raised something else.
    """
    with session(listener) as do:
        return do(job, arguments)


@contextlib.contextmanager
def session(listener: Listener) -> Iterator[Job]:
    """Keep one process for several jobs, so that the kernel is loaded once.

    Gives a function that does a job as `run` does. After a WorkerError the process may be gone:
    then begin another session.
    """
    with tempfile.TemporaryFile() as complaints, _worker(complaints) as process:
        answers = _answers(process)

        def do(job: str, arguments: dict[str, Any]) -> dict[str, Any]:
            assert process.stdin is not None
            # a worker that is dead already breaks the pipe: its silence tells enough
            with contextlib.suppress(OSError):
                process.stdin.write(json.dumps({"job": job, "arguments": arguments}) + "\n")
                process.stdin.flush()  # and left open: its end tells the worker that we are gone
            for event in _events(answers, listener):
                match event:
                    case {"stage": name, "done": done, "total": total}:
                        listener.stage(name, done, total)
                    case {"text": line, "stream": stream}:
                        listener.text(line, stream)
                    case {"error": kind, "message": message, "addresses": addresses}:
                        raised: type[IfsCadError] = getattr(errors, kind, IfsCadError)
                        raise raised(message, addresses=addresses)
                    case {"result": result}:
                        return dict(result)
            complaints.seek(0)
            raise _death(process.wait(), complaints.read().decode(errors="replace"))

        yield do


@contextlib.contextmanager
def _worker(complaints: IO[bytes]) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        [sys.executable, "-c", START, *sys.path],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=complaints,
        encoding="utf-8",
        # A group of its own: Ctrl-C reaches the parent only, and the whole group can be killed.
        start_new_session=True,
        creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
    )
    try:
        yield process
    finally:
        _kill(process)
        process.wait()
        assert process.stdin is not None
        with contextlib.suppress(OSError):
            process.stdin.close()


def _kill(process: subprocess.Popen[str]) -> None:
    if sys.platform == "win32":
        process.kill()
    else:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)


def _answers(process: subprocess.Popen[str]) -> queue.SimpleQueue[str | None]:
    """Collect the lines that a worker sends, and None when it falls silent."""
    lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()

    def listen() -> None:
        assert process.stdout is not None
        with contextlib.suppress(OSError), process.stdout as answers:
            for line in answers:
                lines.put(line)
        lines.put(None)

    threading.Thread(target=listen, daemon=True).start()
    return lines


def _events(answers: queue.SimpleQueue[str | None], listener: Listener) -> Iterator[dict[str, Any]]:
    """Yield the events of a worker until it falls silent."""
    while True:
        try:
            # not a read of the pipe, which Ctrl-C cannot interrupt on Windows
            line = answers.get(timeout=POLL_SECONDS)
        except queue.Empty:
            listener.idle()
            continue
        if line is None:
            return
        yield json.loads(line)


def _death(code: int, said: str) -> WorkerError:
    how = f"ended with {code}"
    if code < 0:
        name = signal.Signals(-code).name
        how = f"died of {name}" + (" (did memory run out?)" if name == "SIGKILL" else "")
    # what Python says of a crash begins with its cause and ends with a page of modules
    _, crash, trace = said.partition("Fatal Python error")
    lines = f"{crash}{trace}".splitlines()[:LAST_WORDS] or said.splitlines()[-LAST_WORDS:]
    words = "".join(f"\n  {line}" for line in lines)
    return WorkerError(f"The worker process {how}." + (f" It said:{words}" if words else ""))
