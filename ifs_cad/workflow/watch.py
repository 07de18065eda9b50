"""A part script on the screen, shown again whenever it is saved.

The worker stays, and the kernel with it. Folders are watched, not files: most editors save beside a
file and rename, after which the file that was watched is gone.
"""

from __future__ import annotations

import ast
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from ifs_cad.errors import IfsCadError, MissingLibraryError, ViewerError, WorkerError
from ifs_cad.libraries import require
from ifs_cad.workflow.part_job import part_script
from ifs_cad.workflow.supervise import Job, Listener, session

DEBOUNCE_MS = 50  # within which changes count as one save
STEP_MS = 10
LOOK_MS = 500  # after which files are looked at without an event, too

Report = Callable[[str], None]


def watch(
    source: Path,
    *,
    settings: Mapping[str, str],
    port: int | None,
    options: Mapping[str, Any],
    listener: Listener,
    report: Report,
    complain: Report,
) -> None:
    """Show a part script, and again after each save of it or of a module beside it.

    A script that fails is reported, and shown again once it is mended. Ctrl-C ends it.

    Parameters
    ----------
    source : Path
    settings, port, options : of the job "show"
    listener : Listener
    report, complain : functions of a text
        Hear what came of each save: that it is shown, or why not.

    Raises
    ------
    ScriptError
        There is no such script.
    ViewerError, MissingLibraryError
        Nothing can be shown at the beginning; later that is reported, as everything else.
    """
    require("watchfiles", "--watch", extra="view")
    part_script(source)
    arguments = {
        "source": str(source),
        "settings": dict(settings),
        "port": port,
        "options": {**options, "keep_camera": True},
    }
    files = sources(source)
    was_shown = False
    saves = _saves(files)
    try:
        while True:  # once for each life of the worker
            with session(listener) as do:
                for begin in saves:
                    try:
                        report(_shown(do, arguments, files, begin))
                        was_shown = True
                    except WorkerError as error:
                        complain(f"Error: {error}")
                        break
                    except IfsCadError as error:
                        if isinstance(error, ViewerError | MissingLibraryError) and not was_shown:
                            raise
                        complain(f"Error: {error}")
    except KeyboardInterrupt:
        report(f"No longer watching {source}.")


def _shown(do: Job, arguments: dict[str, Any], files: set[Path], begin: float) -> str:
    """Show the script, which may be made of other files than before."""
    files |= sources(Path(arguments["source"]))  # also when it fails, to see it mended
    do("show", arguments)
    seconds = time.monotonic() - begin
    return f"Shown after {seconds:.1f} s. Watching {len(files)} file{'s' * (len(files) > 1)}."


def sources(script: Path) -> set[Path]:
    """Return a part script and the modules beside it that it imports, directly or through them.

    They are read, not run, so that a module which cannot be imported is among them.
    """
    script = script.resolve()
    found: set[Path] = set()
    waiting = [script]
    while waiting:
        file = waiting.pop()
        if file in found or not (file == script or file.is_file()):
            continue
        found.add(file)
        if file.suffix == ".py":
            with suppress(OSError, SyntaxError, ValueError):
                waiting += _imported(ast.parse(file.read_bytes()), script.parent, file)
    return found


def _imported(tree: ast.Module, folder: Path, file: Path) -> Iterator[Path]:
    """Yield where the modules that a file imports are, if they are beside the script."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names, start = [alias.name for alias in node.names], folder
        elif isinstance(node, ast.ImportFrom):
            names = [".".join(filter(None, [node.module, alias.name])) for alias in node.names]
            start = file.parents[node.level - 1] if node.level else folder
        else:
            continue
        for name in names:
            place = start
            for part in name.split("."):
                if place == folder and part == "ifs_cad":  # beside a script in a clone
                    break
                place = place / part
                yield place.with_suffix(".py")
                yield place / "__init__.py"


def _saves(files: set[Path]) -> Iterator[float]:
    """Yield the time now, then that of each change of one of the files; they may become more.

    Events only wake: what counts is the state of the files, so a save is told once, however many
    events it makes, and is not missed while the one before is being shown.
    """
    watchfiles = require("watchfiles", "--watch", extra="view")
    seen = _states(files)
    yield time.monotonic()
    while True:
        folders = {file.parent for file in files}
        events = watchfiles.watch(
            *folders,
            watch_filter=None,
            debounce=DEBOUNCE_MS,
            step=STEP_MS,
            rust_timeout=LOOK_MS,
            yield_on_timeout=True,
            recursive=False,
        )
        while folders == {file.parent for file in files}:
            states = _states(files)
            changed = any(seen.get(file, state) != state for file, state in states.items())
            seen |= states
            if changed:
                yield time.monotonic()
            else:
                next(events)


def _states(files: set[Path]) -> dict[Path, tuple[int, int]]:
    """Return when each file was written, and its size."""
    states = {}
    for file in files:
        with suppress(OSError):
            state = file.stat()
            states[file] = state.st_mtime_ns, state.st_size
    return states
