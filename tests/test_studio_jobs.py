"""Jobs of the studio: one at a time, watched, and ended with their processes."""

from __future__ import annotations

import hashlib
import json
import threading
import zipfile
from functools import partial
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest

from ifs_cad.design_file import presets
from ifs_cad.design_record import Design, DrawnCurve
from ifs_cad.elements.fibre import FibreAlongEdge
from ifs_cad.errors import GeometryError, InputError
from ifs_cad.fabrication.workshop import Workshop
from ifs_cad.studio.jobs import (
    JobRunner,
    JobState,
    Made,
    analysis,
    fabrication_folder,
    step_file,
)
from ifs_cad.workflow import supervise
from ifs_cad.workflow.question import Question

SMALL = presets()["figure_17_offset_mesh"]
TINY = Design(
    a=DrawnCurve(((0, 0, 0), (400, 0, 900), (1600, 0, 900), (2000, 0, 0)), depth=1),
    b=DrawnCurve(((0, 0, 0), (0, 700, 300), (0, 1500, 0)), depth=1),
    thickness=12.0,
    side="inner",
    fibre=FibreAlongEdge(),
)
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
    watched: Watched, own_worker: None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
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


@pytest.mark.slow
def test_a_workshop_folder_comes_whole_with_sheets_and_programs() -> None:
    heard: list[str] = []

    class Ear(supervise.Listener):
        def stage(self, name: str, done: int, total: int | None) -> None:
            heard.append(name)

    made = fabrication_folder(TINY, "tiny", Workshop(), Ear())
    assert made.name == "tiny.zip"
    assert made.summary.startswith("panels          4\n")
    assert len(set(heard)) > 1
    assert heard[-1] == "packing"
    with zipfile.ZipFile(BytesIO(made.content)) as packed:
        assert packed.testzip() is None
        files = {name for name in packed.namelist() if not name.endswith("/")}
        listed = json.loads(packed.read("tiny/manifest.json"))["files"]
        assert files == {"tiny/manifest.json", *(f"tiny/{entry['path']}" for entry in listed)}
        for entry in listed:
            content = packed.read(f"tiny/{entry['path']}")
            assert hashlib.sha256(content).hexdigest() == entry["sha256"]
    sheets = {Path(name).stem for name in files if name.endswith(".dxf")}
    programs = {Path(name).stem for name in files if name.endswith(".ngc")}
    assert sheets == programs
    assert f"4 pieces on {len(sheets)} sheets" in made.summary
    assert {"tiny/tiny.step", "tiny/index.html", "tiny/drawings/assembly.pdf"} <= files


@pytest.mark.slow
def test_an_analysis_comes_with_its_picture_and_table() -> None:
    if find_spec("KratosMultiphysics") is None:
        pytest.skip("Kratos is not installed")
    made = analysis(
        TINY, "tiny", Question(load=2000.0, supports=("a start, a end",)), supervise.Listener()
    )
    assert made.name == "tiny_analysis.zip"
    assert made.picture.startswith(b"\x89PNG\r\n\x1a\n")
    assert "(0.000, 0.000, -6.000) kN" in made.summary, "2 kN/m2 on 3 m2 of ground"
    with zipfile.ZipFile(BytesIO(made.content)) as packed:
        contents = {packed.read(name) for name in packed.namelist()}
    assert made.picture in contents
