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
from pathlib import Path

import pytest

from ifs_cad.errors import InputError, MissingLibraryError
from ifs_cad.studio.run import run

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
