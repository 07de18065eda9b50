"""The process that does a job: loads the kernel, runs scripts, writes files.

It reads requests, each a line of JSON ``{"job": ..., "arguments": {...}}``, from its standard
input, and writes a line of JSON to its standard output for each event: ``stage`` and ``text``
while it works, ``result`` or ``error`` at the end of each job. OpenCascade prints to standard
output too, so the events go through a private copy of it. When the standard input ends, the parent
is gone and the worker ends itself.
"""

from __future__ import annotations

import ctypes
import faulthandler
import io
import json
import os
import queue
import re
import signal
import sys
import threading
import time
import traceback
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from ifs_cad import progress
from ifs_cad.errors import IfsCadError, InputError, ScriptError
from ifs_cad.libraries import load

if TYPE_CHECKING:
    from ifs_cad.export.step import Schema

EVENT_SECONDS = 0.05  # at least, between two reports of the same stage
STEP_SUFFIXES = {".step", ".stp"}
PR_SET_PDEATHSIG = 1  # from Linux's <sys/prctl.h>


class Channel:
    """Where the worker's events go, one line of JSON each."""

    def __init__(self, file: TextIO) -> None:
        self._file = file
        self._lock = threading.Lock()
        self._stage = ""
        self._reported = 0.0

    def send(self, **event: Any) -> None:
        """Send an event."""
        with self._lock:
            self._file.write(json.dumps(event) + "\n")
            self._file.flush()

    def stage(self, name: str, done: int, total: int | None) -> None:
        """Send how far a stage has come: its begin, its end, and now and then between."""
        now = time.monotonic()
        if name != self._stage or done == total or now - self._reported > EVENT_SECONDS:
            self._stage, self._reported = name, now
            self.send(stage=name, done=done, total=total)


class Forwarder(io.TextIOBase):
    """A text stream whose lines become events."""

    def __init__(self, channel: Channel, stream: str) -> None:
        self._channel = channel
        self._stream = stream
        self._begun = ""

    def write(self, text: str) -> int:
        """Send every line that is complete."""
        *lines, self._begun = (self._begun + text).split("\n")
        for line in lines:
            self._channel.send(text=line, stream=self._stream)
        return len(text)

    def finish(self) -> None:
        """Send a last line that was not ended."""
        if self._begun:
            self.write("\n")


def build(
    script: str, settings: Mapping[str, str], stage: str, schema: Schema, flat_panels: bool
) -> dict[str, Any]:
    """Run a part script and write what it shows into the folder `stage`."""
    shown = _shown(script, settings)
    for number, thing in enumerate(shown, 1):
        if not thing.has_solids:
            raise ScriptError(
                f"{script} showed {thing.name or f'object {number}'}, which has no solid in it: "
                "nothing to make."
            )
    from ifs_cad.export.step import export_panels, export_step
    from ifs_cad.kernel.assembly import modified_parts

    files: list[dict[str, Any]] = []
    reports: list[str] = []
    modified: list[str] = []
    for stem, thing in zip(_stems(script, shown), shown, strict=True):
        assembly = thing.assembly
        begin = time.monotonic()
        made = [export_step(assembly, Path(stage, f"{stem}.step"), schema=schema)]
        files.append(_written(stage, made, begin))
        shell = assembly.metadata.get("elements")
        if shell is None:
            continue
        reports.append(str(shell.report()))
        modified += modified_parts(assembly)
        if flat_panels:
            begin = time.monotonic()
            made = export_panels(assembly, Path(stage, f"{stem}_panels"), schema=schema)
            files.append(_written(stage, made, begin))
    if flat_panels and not reports:
        raise InputError(f"{script} showed no panels of a shell, so none can be laid flat.")
    return {"files": files, "reports": reports, "modified": modified}


def fabricate(
    script: str, settings: Mapping[str, str], stage: str, workshop: Mapping[str, Any]
) -> dict[str, Any]:
    """Run a part script and write all that a workshop needs into the folder `stage`."""
    from ifs_cad.fabrication.workshop import Workshop

    shown = _shown(script, settings)
    if len(shown) != 1:
        raise ScriptError(
            f"{script} showed {len(shown)} things; only one can be made at a time. Show one."
        )
    progress.report("loading the tools of the workshop")
    folder = load("ifs_cad.workflow.folder")
    path, name = Path(stage), Path(script).stem
    path.mkdir(parents=True)
    made: dict[str, Any] = folder.make_folder(shown[0].assembly, path, name, Workshop(**workshop))
    progress.report("checksums")
    facts = {"part": Path(script).name, "settings": dict(settings), "workshop": dict(workshop)}
    load("ifs_cad.workflow.manifest").write_manifest(path, facts)
    return made


def analyse(
    script: str, settings: Mapping[str, str], stage: str, question: Mapping[str, Any]
) -> dict[str, Any]:
    """Run a part script and write how the shells that it shows stand into the folder `stage`."""
    from ifs_cad.workflow.question import Question

    shown = _shown(script, settings)
    progress.report("loading the structure check")
    make = load("ifs_cad.workflow.analysis").make_analysis
    made: dict[str, Any] = make(
        [thing.assembly for thing in shown], Path(stage), Question(**question)
    )
    return made


def render(
    source: str, settings: Mapping[str, str], path: str, options: Mapping[str, Any]
) -> dict[str, Any]:
    """Draw what a part script shows, or a STEP file, as a PNG."""
    from ifs_cad.view.render import render as draw

    model = _model(source, settings)
    progress.report("drawing")
    draw(model, path, **options)
    return {}


def animate(
    source: str,
    settings: Mapping[str, str],
    sweep: tuple[str, list[str]],
    path: str,
    options: Mapping[str, Any],
) -> dict[str, Any]:
    """Draw what a part script shows for each value of one parameter, as a GIF or MP4."""
    from ifs_cad.view.animate import animate as draw

    name, values = sweep
    kernel = _kernel()

    def frames() -> Iterator[Any]:
        for number, value in enumerate(values):
            progress.report("making frames", number, len(values))
            with_value = {**settings, name: value}
            try:
                yield kernel.together(kernel.run_script(Path(source), with_value))
            except IfsCadError as error:
                said = f"With {name} = {value}: {error}"
                raise type(error)(said, addresses=error.addresses) from error

    draw(frames(), path, **options)
    return {}


def show(
    source: str, settings: Mapping[str, str], port: int | None, options: Mapping[str, Any]
) -> dict[str, Any]:
    """Send what a part script shows, or a STEP file, to a viewer.

    Of its modules, those beside the script are loaded anew each time.
    """
    from ifs_cad.view.preview import show as send

    folder, before = Path(source).resolve().parent, set(sys.modules)
    try:
        model = _model(source, settings)
    finally:
        for name in set(sys.modules) - before:
            place = getattr(sys.modules[name], "__file__", None)
            # a script in a clone has this package beside it, which is not the script's
            if place and folder in Path(place).resolve().parents and not _is_lasting(name, place):
                del sys.modules[name]
    progress.report("showing")
    send(model, Path(source).stem, port=port, **options)
    return {}


def _is_lasting(module: str, place: str) -> bool:
    return module.partition(".")[0] == "ifs_cad" or "site-packages" in place


def check(path: str) -> dict[str, Any]:
    """Check a STEP file."""
    progress.report("loading the CAD kernel")
    check_step = load("ifs_cad.workflow.check").check_step
    progress.report(f"reading {Path(path).name}")
    report = check_step(path)
    return {"text": str(report), "data": report.as_dict()}


JOBS: dict[str, Callable[..., dict[str, Any]]] = {
    "analyse": analyse,
    "animate": animate,
    "build": build,
    "check": check,
    "fabricate": fabricate,
    "render": render,
    "show": show,
}


def main() -> None:
    """Do the jobs that are asked for, one after the other, until the parent is gone."""
    faulthandler.enable(all_threads=False)
    requests = os.fdopen(_private(0, os.O_RDONLY), encoding="utf-8")
    channel = Channel(os.fdopen(_private(1, os.O_WRONLY), "w", encoding="utf-8"))
    output, complaints = Forwarder(channel, "stdout"), Forwarder(channel, "stderr")
    sys.stdin, sys.stdout, sys.stderr = os.fdopen(0, closefd=False), output, complaints
    warnings.formatwarning = lambda message, *_, **__: f"Warning: {message}\n"
    waiting = _collected(requests)
    while True:
        request = json.loads(waiting.get())
        outcome = _done(request, channel)
        output.finish()
        complaints.finish()
        channel.send(**outcome)


def _done(request: Mapping[str, Any], channel: Channel) -> dict[str, Any]:
    """Do one job and return how it ended."""
    try:
        with progress.listening(channel.stage):
            return {"result": JOBS[request["job"]](**request["arguments"])}
    except IfsCadError as error:
        return _failure(type(error).__name__, str(error), error.addresses)
    except Exception:
        return _failure("WorkerError", f"Nobody foresaw this:\n{traceback.format_exc()}")


def _kernel() -> Any:
    progress.report("loading the CAD kernel")
    return load("ifs_cad.kernel.source")


def _shown(script: str, settings: Mapping[str, str]) -> list[Any]:
    source = _kernel()
    progress.report(f"running {Path(script).name}")
    shown: list[Any] = source.run_script(Path(script), settings)
    return shown


def _model(file: str, settings: Mapping[str, str]) -> Any:
    """Return what a part script shows, or a STEP file holds, as one assembly."""
    if Path(file).suffix.lower() not in STEP_SUFFIXES:
        shown = _shown(file, settings)
        return _kernel().together(shown)
    if settings:
        raise InputError(f"{file} is no script, so it has no parameters to set.")
    source = _kernel()
    progress.report(f"reading {Path(file).name}")
    return source.read_step(Path(file))


def _stems(script: str, shown: list[Any]) -> list[str]:
    """Name a file for each thing that a script showed.

    Raises
    ------
    ScriptError
        Two would get the same name.
    """
    stem = Path(script).stem
    if len(shown) == 1:
        return [stem]
    names = [re.sub(r"[^\w.-]+", "_", thing.name) or str(n) for n, thing in enumerate(shown, 1)]
    if len({name.casefold() for name in names}) < len(names):
        raise ScriptError(
            f"{script} showed {len(names)} things named {', '.join(names)}. Each becomes a file, "
            "so each needs a name of its own: show_object(thing, name=...)."
        )
    return [f"{stem}_{name}" for name in names]


def _written(stage: str, paths: list[Path], begin: float) -> dict[str, Any]:
    """Describe files by their places within the stage and the time they took."""
    places = [path.relative_to(stage).as_posix() for path in paths]
    return {"places": places, "seconds": time.monotonic() - begin}


def _private(descriptor: int, flags: int) -> int:
    """Return a copy of a standard stream, which itself leads nowhere from now on."""
    copy = os.dup(descriptor)
    nowhere = os.open(os.devnull, flags)
    os.dup2(nowhere, descriptor)
    os.close(nowhere)
    return copy


def _collected(requests: TextIO) -> queue.SimpleQueue[str]:
    """Collect the requests while a job goes on; at their end the parent is gone, and so are we."""
    if sys.platform == "linux":  # at once, even while the kernel holds the interpreter lock
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    waiting: queue.SimpleQueue[str] = queue.SimpleQueue()

    def collect() -> None:
        for line in requests:
            waiting.put(line)
        os._exit(1)  # tearing the kernel down takes time and serves nothing

    threading.Thread(target=collect, daemon=True).start()
    return waiting


def _failure(kind: str, message: str, addresses: Iterable[str] = ()) -> dict[str, Any]:
    return {"error": kind, "message": message, "addresses": list(addresses)}
