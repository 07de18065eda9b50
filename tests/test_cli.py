"""The command line: its messages and exit codes."""

import json
import re
import socket
import subprocess
import sys
from importlib.metadata import version

import pytest
from typer.testing import CliRunner

from ifs_cad.cli import app
from ifs_cad.errors import ThicknessError
from ifs_cad.workflow import build as build_module

BOX = "import cadquery as cq\nsize = 10\nshow_object(cq.Workplane().box(size, size, size))\n"


def ifs_cad(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def box(tmp_path):
    path = tmp_path / "box.py"
    path.write_text(BOX)
    return path


def test_help_loads_neither_the_kernel_nor_numpy():
    code = """
import sys
from ifs_cad.cli import app
try:
    app(["build", "--help"])
except SystemExit as end:
    print(end.code, sorted({"cadquery", "OCP", "numpy", "scipy"} & sys.modules.keys()))
"""
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert "--flat-panels" in result.stdout
    assert result.stdout.splitlines()[-1] == "0 []"


def test_version_is_that_of_the_package():
    result = ifs_cad("--version")
    assert result.exit_code == 0
    assert result.stdout == f"ifs-cad {version('ifs-cad')}\n"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["build"], "Missing argument"),
        (["build", "x.py", "--set", "thickness"], "thickness=12"),
        (["build", "x.py", "--set", "=12"], "thickness=12"),
        (["build", "x.py", "--schema", "AP203"], "AP203"),
        (["render", "x.py"], "--output"),
        (["bild", "x.py"], "bild"),
    ],
)
def test_wrong_command_line_exits_with_2(arguments, said):
    result = ifs_cad(*arguments)
    assert result.exit_code == 2
    assert said in result.stderr


def test_missing_script_is_one_line(tmp_path):
    result = ifs_cad("build", tmp_path / "none.py")
    assert result.exit_code == 1
    assert result.stderr == f"Error: There is no script {tmp_path / 'none.py'}.\n"
    assert result.stdout == ""
    assert [*tmp_path.iterdir()] == []


@pytest.mark.parametrize(
    ("raised", "code", "said"),
    [
        (ThicknessError("Too thick at 03.", addresses=["03"]), 1, "Error: Too thick at 03.\n"),
        (KeyboardInterrupt("Interrupted; nothing was changed."), 130, "Interrupted; nothing was"),
        (KeyboardInterrupt(), 130, "Interrupted.\n"),
    ],
)
def test_errors_become_one_message_and_an_exit_code(monkeypatch, raised, code, said):
    def fail(*_, **__):
        raise raised

    monkeypatch.setattr(build_module, "build", fail)
    result = ifs_cad("build", "x.py", "--quiet")
    assert result.exit_code == code
    assert result.stderr.startswith(said)
    assert "Traceback" not in result.stderr


def test_settings_reach_the_build_as_they_were_typed(monkeypatch):
    calls = []
    monkeypatch.setattr(build_module, "build", lambda *a, **k: calls.append(k["settings"]))
    ifs_cad("build", "x.py", "-q", "--set", "a=-1.5", "--set", "b=x=y", "--set", "c=")
    assert calls == [{"a": "-1.5", "b": "x=y", "c": ""}]


def test_quiet_build_prints_nothing(box):
    box.write_text(BOX + "print('loud')\nimport warnings; warnings.warn('louder')\n")
    result = ifs_cad("build", box, "-o", box.parent, "--quiet")
    assert (result.exit_code, result.stdout, result.stderr) == (0, "", "")
    assert (box.parent / "box" / "box.step").stat().st_size > 0


def test_check_tells_good_files_from_bad_ones(box):
    assert ifs_cad("build", box, "-o", box.parent, "-q").exit_code == 0
    good = ifs_cad("check", box.parent / "box" / "box.step", "--json")
    assert good.exit_code == 0, good.stderr
    assert json.loads(good.stdout)["ok"] is True
    box.write_text(
        "import cadquery as cq\n"
        "pair = cq.Assembly(cq.Workplane().box(9, 9, 9), name='one')\n"
        "pair.add(cq.Workplane().box(9, 9, 9), name='two', loc=cq.Location((5, 0, 0)))\n"
        "show_object(pair)\n"
    )
    assert ifs_cad("build", box, "-o", box.parent, "-q").exit_code == 0
    bad = ifs_cad("check", box.parent / "box" / "box.step", "--quiet")
    assert bad.exit_code == 1
    assert bad.stdout == ""
    assert re.search(r"FAIL +interference", bad.stderr)


def test_render_draws_a_script_with_its_settings(box):
    picture = box.parent / "box.png"
    result = ifs_cad("render", box, "-o", picture, "--width", 64, "--height", 48, "--set", "size=2")
    assert result.exit_code == 0, result.stderr
    assert result.stdout.splitlines()[-1] == f"Wrote {picture}"
    header = picture.read_bytes()[:24]
    assert header[:8] == b"\x89PNG\r\n\x1a\n"
    assert (int.from_bytes(header[16:20]), int.from_bytes(header[20:24])) == (64, 48)
    assert sorted(path.name for path in box.parent.iterdir()) == ["box.png", "box.py"]


def test_settings_of_a_step_file_are_an_error(tmp_path):
    (tmp_path / "x.step").touch()
    result = ifs_cad(
        "render", tmp_path / "x.step", "-o", tmp_path / "x.png", "-q", "--set", "size=2"
    )
    assert result.exit_code == 1
    assert "is no script, so it has no parameters" in result.stderr


def test_show_without_a_viewer_says_how_to_start_one(box):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    result = ifs_cad("show", box, "--port", port, "--quiet")
    assert result.exit_code == 1
    assert str(port) in result.stderr
    assert "Traceback" not in result.stderr
