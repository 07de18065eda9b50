"""Jobs of the studio: one at a time, watched, and ended with their processes."""

from __future__ import annotations

import threading
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from ifs_cad.design_file import presets
from ifs_cad.errors import GeometryError, InputError
from ifs_cad.studio.jobs import JobRunner, JobState, Made, step_file
from ifs_cad.workflow import supervise

SMALL = presets()["figure_17_offset_mesh"]
PATIENCE = 60.0  # seconds
MADE = Made("shell.step", b"ISO-10303-21;", "8 panels")


class Watched:
    """A runner whose states are kept."""

    def __init__(self) -> None:
        self.states: list[JobState] = []
        self.runner = JobRunner(self.states.append)


@pytest.fixture
def watched() -> Watched:
    return Watched()


def test_a_job_says_how_far_it_is_and_gives_what_it_made(watched: Watched) -> None:
    def work(listener: supervise.Listener) -> Made:
        listener.stage("panels", 1, 4)
        listener.stage("writing", 0, None)
        return MADE

    watched.runner.start("STEP file", work)
    assert watched.runner.wait(PATIENCE)
    assert [(state.state, state.stage, state.share) for state in watched.states] == [
        ("running", "starting", None),
        ("running", "panels", 0.25),
        ("running", "writing", None),
        ("done", "", 1.0),
    ]
    assert watched.runner.state.made == MADE


@pytest.mark.parametrize(
    ("error", "message"),
    [(GeometryError("too thick"), "too thick"), (OSError("no space"), "OSError: no space")],
)
def test_a_job_that_fails_says_why(watched: Watched, error: Exception, message: str) -> None:
    def work(listener: supervise.Listener) -> Made:
        raise error

    watched.runner.start("STEP file", work)
    assert watched.runner.wait(PATIENCE)
    assert (watched.runner.state.state, watched.runner.state.message) == ("failed", message)
    watched.runner.start("STEP file", lambda listener: MADE)
    assert watched.runner.wait(PATIENCE)
    assert watched.runner.state.state == "done"


def test_a_second_job_has_to_wait(watched: Watched) -> None:
    go_on = threading.Event()

    def work(listener: supervise.Listener) -> Made:
        assert go_on.wait(PATIENCE)
        return MADE

    watched.runner.start("Workshop folder", work)
    with pytest.raises(InputError, match="Workshop folder is being made"):
        watched.runner.start("STEP file", work)
    go_on.set()
    assert watched.runner.wait(PATIENCE)


def test_a_cancelled_job_ends_its_process_and_leaves_no_folder(
    watched: Watched, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Also while the process says nothing, as in its first seconds."""
    started: list[Any] = []
    begun = threading.Event()

    class Process(supervise.subprocess.Popen):  # type: ignore[name-defined, misc]
        def __init__(self, *arguments: Any, **options: Any) -> None:
            super().__init__(*arguments, **options)
            started.append(self)
            begun.set()

    monkeypatch.setattr(supervise.subprocess, "Popen", Process)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    watched.runner.start("STEP file", partial(step_file, SMALL, "shell"))
    assert begun.wait(PATIENCE)
    watched.runner.cancel()
    assert watched.runner.wait(PATIENCE)
    assert watched.runner.state.state == "cancelled"
    assert watched.runner.state.made is None
    (process,) = started
    assert process.returncode is not None
    assert list(tmp_path.iterdir()) == []
