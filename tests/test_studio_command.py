"""``ifs-cad studio`` as a user runs it."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
import threading
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from ifs_cad.design_file import presets, write_design
from ifs_cad.errors import InputError, MissingLibraryError
from ifs_cad.studio import run as studio_run
from ifs_cad.studio.model import autosave_path
from ifs_cad.studio.run import run
from ifs_cad.studio.session import Session

PLAIN = presets()["figure_17_offset_mesh"]
PATIENCE = 120  # seconds


@pytest.fixture
def starts(tmp_path: Path) -> Iterator[list[subprocess.Popen[str]]]:
    processes: list[subprocess.Popen[str]] = []
    yield processes
    for process in processes:
        process.kill()
        process.wait()


def start(processes: list[subprocess.Popen[str]], folder: Path, *arguments: str) -> str:
    """Start the command and return what it says up to its last line."""
    pytest.importorskip("viser", reason="the studio's page is not installed (extra 'studio')")
    process = subprocess.Popen(
        [sys.executable, "-m", "ifs_cad.cli", "studio", *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    processes.append(process)
    assert process.stdout is not None
    timer = threading.Timer(PATIENCE, process.kill)
    timer.start()
    said = ""
    for line in process.stdout:
        said += line
        if "Ctrl-C ends it" in line:
            break
    timer.cancel()
    return said


@pytest.mark.skipif(os.name != "posix", reason="sends SIGINT")
def test_it_serves_until_it_is_interrupted(
    starts: list[subprocess.Popen[str]], tmp_path: Path
) -> None:
    said = start(starts, tmp_path, "new.toml")
    assert "new.toml does not exist yet" in said
    found = re.search(r"http://127\.0\.0\.1:\d+/\?key=\S+", said)
    assert found is not None, said
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    with opener.open(found[0], timeout=PATIENCE) as page:
        assert page.status == 200
    (process,) = starts
    process.send_signal(signal.SIGINT)
    rest, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0
    assert rest.strip() == "The studio has ended."
    assert list(tmp_path.iterdir()) == []


def test_what_it_says_at_the_end_is_where_everything_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("viser", reason="the studio's page is not installed (extra 'studio')")
    path = write_design(PLAIN, tmp_path / "shell.toml")
    left = write_design(replace(PLAIN, thickness=12.0), autosave_path(path))
    said: list[str] = []
    opened = studio_run.opened

    @contextmanager
    def edited(*arguments: Any) -> Iterator[studio_run.Studio]:
        with opened(*arguments) as studio:
            studio.session.edit(lambda model: model.set_thickness(50.0))
            yield studio

    def say(text: str) -> None:
        said.append(text)
        if "Ctrl-C ends it" in text:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(studio_run, "opened", edited)
    run(path, say=say)
    own = autosave_path(path, 2)
    assert said[0] == f"A design that was not saved is in {left}; the page asks."
    assert said[-2] == f"Not saved; the next start offers it from {own}."
    assert f"still in {left}" in said[-1]
    assert {file.name for file in tmp_path.iterdir()} == {path.name, left.name, own.name}
    offered = {found.file: found.design.thickness for found in Session(path).found}
    assert offered == {own: 50.0, left: 12.0}


def test_a_port_that_is_taken_is_a_clear_error(
    starts: list[subprocess.Popen[str]], tmp_path: Path
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        said = start(starts, tmp_path, "--port", str(port))
    (process,) = starts
    assert process.wait(PATIENCE) == 1
    assert f"Error: Port {port} of this machine cannot be had" in said
    assert "Traceback" not in said


def test_a_broken_design_is_a_clear_error(tmp_path: Path) -> None:
    broken = tmp_path / "broken.toml"
    broken.write_text("version = 99\n")
    with pytest.raises(InputError, match="made by a newer ifs-cad"):
        run(broken)


def test_a_missing_package_is_an_error_that_names_the_extra(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(MissingLibraryError, match=r"ifs-cad\[studio\]"):
        run(tmp_path / "shell.toml")
