"""What a job looks like on the terminal: moving bars, or plain lines for a file or a pipe."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    ProgressColumn,
    SpinnerColumn,
    Task,
    TaskID,
    TextColumn,
)
from rich.text import Text

from ifs_cad.workflow.supervise import Listener


class Terminal(Listener):
    """Prints what a script prints."""

    def __init__(self, console: Console) -> None:
        super().__init__()
        self.console = console

    def text(self, line: str, stream: str) -> None:
        """Print a line of the script."""
        super().text(line, stream)
        style = "yellow" if stream == "stderr" else None
        self.console.print(line, style=style, soft_wrap=True)


class Lines(Terminal):
    """Prints a line when a stage begins."""

    def __init__(self, console: Console) -> None:
        super().__init__(console)
        self._begin = time.monotonic()
        self._stages: set[str] = set()

    def stage(self, name: str, done: int, total: int | None) -> None:
        """Print the stage the first time."""
        if name not in self._stages:
            self._stages.add(name)
            elapsed = time.monotonic() - self._begin
            self.console.print(f"[{elapsed:6.1f} s] {name}", soft_wrap=True)


class Bars(Terminal):
    """Shows a bar for each stage."""

    def __init__(self, console: Console, progress: Progress) -> None:
        super().__init__(console)
        self._progress = progress
        self._tasks: dict[str, TaskID] = {}
        self._current = ""

    def stage(self, name: str, done: int, total: int | None) -> None:
        """Move the stage's bar; another stage that was going on has ended."""
        if name != self._current:
            self.finish()
            self._current = name
        if name not in self._tasks:
            self._tasks[name] = self._progress.add_task(name, total=total)
        self._progress.update(self._tasks[name], completed=done, total=total)

    def finish(self) -> None:
        """End the stage that goes on, when it does not know itself how far it is."""
        if self._current:
            task = self._tasks[self._current]
            if self._progress.tasks[task].total is None:
                self._progress.update(task, completed=1, total=1)


class _Count(ProgressColumn):
    def render(self, task: Task) -> Text:
        return Text(f"{task.completed:.0f}/{task.total:.0f}" if (task.total or 0) > 1 else "")


class _Seconds(ProgressColumn):
    def render(self, task: Task) -> Text:
        elapsed = task.finished_time if task.finished else task.elapsed
        return Text(f"{elapsed or 0.0:.1f} s", justify="right")


def plain(quiet: bool) -> Listener:
    """Return a listener that prints what scripts print, and no stages."""
    return Listener() if quiet else Terminal(_console())


def _console() -> Console:
    return Console(highlight=False, markup=False, emoji=False)


@contextmanager
def display(quiet: bool) -> Iterator[Listener]:
    """Give the listener that suits the standard output; a quiet one shows nothing."""
    console = _console()
    if quiet:
        yield Listener()
    elif not console.is_terminal:
        yield Lines(console)
    else:
        columns = (
            SpinnerColumn(finished_text="+"),
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            _Count(),
            _Seconds(),
        )
        with Progress(*columns, console=console) as progress:
            bars = Bars(console, progress)
            yield bars
            bars.finish()
