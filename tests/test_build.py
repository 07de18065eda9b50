"""Whole builds by the real command line: what arrives, and that nothing else is ever lost."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import cadquery as cq
import pytest
from typer.testing import CliRunner

from ifs_cad.cli import app
from ifs_cad.errors import ScriptError
from ifs_cad.workflow import worker
from ifs_cad.workflow.build import build

BOX = """
import cadquery as cq
size = 1.0
show_object(cq.Workplane().box(size, size, size))
"""

# Dies half way: with `pid_file` the export writes half a file and then sleeps holding the
# interpreter lock, as the kernel does, until somebody kills it.
HALF = f"""
import ctypes, os
from pathlib import Path
from ifs_cad.export import step
pid_file = ""
def half(assembly, path, **options):
    path.write_text("ISO-10303-21;")
    Path(pid_file + ".new").write_text(str(os.getpid()))
    Path(pid_file + ".new").rename(pid_file)
    ctypes.PyDLL(None).sleep(600)
if pid_file:
    step.export_step = half
{BOX}
"""

SHELL = """
import ifs_cad as ifs
thickness = 10.0
depth = 2
modify = False
report_early = False
arch = ifs.Curve([(0, 0, 0), (0, 0, 2000), (4500, 0, 2000), (4500, 0, 0)], depth=depth)
fold = ifs.Curve([(0, 0, 0), (0, 1500, 400), (0, 3000, 0)], depth=depth)
shell = ifs.thicken(ifs.vector_sum(arch, fold), thickness)
assembly = ifs.to_assembly(shell)
if report_early:
    print(shell.report())
if modify:
    import cadquery as cq
    part = assembly.objects["03"]
    part.obj = part.obj.cut(cq.Workplane().sphere(300).val())
show_object(assembly, name="shell")
"""

TWO = """
import cadquery as cq
import resource
limit = 0
size = 1.0
if limit:  # a full disk: no file can grow beyond it
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.getrlimit(resource.RLIMIT_FSIZE)[1]))
box = cq.Workplane().box(size, size, size)
show_object(box, name="small")
show_object(box.rarray(3, 3, 8, 8).box(1, 1, 1, combine=False), name="large")
"""

posix = pytest.mark.skipif(os.name != "posix", reason="signals and limits of POSIX")
linux = pytest.mark.skipif(sys.platform != "linux", reason="processes are looked up in /proc")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty current folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def command(*arguments):
    return [sys.executable, "-m", "ifs_cad.cli", *arguments]


def environment():
    root = Path(__file__).parent.parent
    return os.environ | {"PYTHONPATH": os.pathsep.join([str(root), *sys.path])}


def ifs_cad(*arguments):
    return subprocess.run(
        command(*arguments), capture_output=True, text=True, timeout=300, env=environment()
    )


def invoked(*arguments):
    """Run the command in this process: for what it says and writes, not for how it ends."""
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def contents(folder):
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in Path(folder).rglob("*")
        if path.is_file()
    }


def is_alive(pid):
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return False
    return state not in "ZX"


def wait_until(condition, seconds=120):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.05)


@pytest.fixture(scope="module")
def good_build(tmp_path_factory):
    """A folder with the script HALF and the good file that a whole build of it wrote."""
    folder = tmp_path_factory.mktemp("good")
    (folder / "half.py").write_text(HALF)
    result = ifs_cad("build", folder / "half.py", "-o", folder / "exports", "--quiet")
    assert result.returncode == 0, result.stderr
    return folder


@pytest.fixture
def half_done(folder, good_build):
    """A good file, and a build that was about to replace it: (parent, worker's pid, old files)."""
    shutil.copytree(good_build, folder, dirs_exist_ok=True)
    old = contents("exports")
    assert old.keys() == {"half/half.step"}
    pid_file = folder / "worker.pid"
    parent = subprocess.Popen(
        command("build", "half.py", "--set", f"pid_file={pid_file}"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment(),
    )
    with parent:
        try:
            wait_until(lambda: pid_file.exists() or parent.poll() is not None)
            assert parent.poll() is None, parent.communicate()[1]
            assert len(contents("exports")) == 2  # the good file and half of the next
            yield parent, int(pid_file.read_text()), old
        finally:
            parent.kill()


@linux
def test_killed_worker_leaves_the_old_file_and_nothing_else(half_done):
    parent, child, old = half_done
    os.kill(child, signal.SIGKILL)
    _, said = parent.communicate(timeout=60)
    assert parent.returncode == 1
    assert said == (
        "Error: The worker process died of SIGKILL (did memory run out?).\n"
        "Nothing in exports/half was changed.\n"
    )
    assert contents("exports") == old


@linux
def test_interrupted_build_ends_at_once_and_changes_nothing(half_done):
    parent, child, old = half_done
    parent.send_signal(signal.SIGINT)
    _, said = parent.communicate(timeout=60)
    assert parent.returncode == 130
    assert said == "Interrupted; nothing in exports/half was changed.\n"
    assert not is_alive(child)
    assert contents("exports") == old


@linux
def test_worker_ends_with_its_parent_and_the_next_build_cleans_up(half_done):
    parent, child, old = half_done
    parent.kill()
    parent.wait()
    wait_until(lambda: not is_alive(child))
    left = contents("exports")
    assert left.keys() > old.keys()
    assert left["half/half.step"] == old["half/half.step"]
    assert ifs_cad("build", "half.py", "--quiet").returncode == 0
    assert contents("exports").keys() == old.keys()


@posix
def test_full_disk_at_the_second_of_two_files_keeps_both_old_ones(folder):
    (folder / "two.py").write_text(TWO)
    assert ifs_cad("build", "two.py", "--quiet").returncode == 0
    old = contents("exports")
    assert old.keys() == {"two/two_small.step", "two/two_large.step"}
    limit = 3 * len(old["two/two_small.step"])
    assert limit < len(old["two/two_large.step"])
    full = ifs_cad("build", "two.py", "--set", "size=2", "--set", f"limit={limit}")
    assert full.returncode == 1
    assert "could not write exports/two/two_large.step. Is the disk full?" in full.stderr
    assert contents("exports") == old


@pytest.mark.parametrize("obstacle", ["exports", "exports/box", "exports/box/box.step/x"])
def test_target_that_cannot_be_written_is_an_error(folder, obstacle):
    (folder / "box.py").write_text(BOX)
    Path(obstacle).parent.mkdir(parents=True, exist_ok=True)
    Path(obstacle).write_text("in the way")
    result = invoked("build", "box.py", "--quiet")
    assert result.exit_code == 1
    assert result.stderr.startswith("Error: ")
    assert "exports/box" in result.stderr
    assert "Traceback" not in result.stderr
    assert (
        contents("exports" if obstacle != "exports" else ".").get(obstacle.removeprefix("exports/"))
        == b"in the way"
    )
    assert len([p for p in folder.rglob("*") if p.name.startswith(".")]) == 0


def test_build_says_where_it_is_and_what_it_wrote(folder):
    (folder / "box.py").write_text(BOX + "print('[bold]six[/bold] faces')")
    result = invoked("build", "box.py", "--set", "size=-2", "-o", "out", "--schema", "AP242")
    assert result.exit_code == 1  # a box of negative size
    assert "box.py, line 4: " in result.stderr
    assert not (folder / "out" / "box").exists()
    result = invoked("build", "box.py", "--set", "size=2", "-o", "out", "--schema", "AP242")
    assert result.exit_code == 0, result.stderr
    assert result.stderr == ""
    written = Path("out/box/box.step")
    said = [re.sub(r"[\d.]+", "#", line) for line in result.stdout.splitlines()]
    assert said == [
        "[   # s] loading the CAD kernel",
        "[   # s] running box#py",
        "[bold]six[/bold] faces",
        "[   # s] writing STEP",
        re.sub(r"[\d.]+", "#", f"Wrote {written} (8.4 kB, 0.0 s)"),
        "Done in # s#",
    ]
    assert cq.importers.importStep(str(written)).val().Volume() == pytest.approx(8)
    assert "AP242" in written.read_text()
    assert contents("out").keys() == {"box/box.step"}


def test_failing_script_is_a_message_and_no_file(folder):
    (folder / "thin.py").write_text("import warnings\nwarnings.warn('beware')\n1 / 0\n")
    result = invoked("build", "thin.py")
    assert result.exit_code == 1
    assert result.stderr == (
        "Error: thin.py, line 3: ZeroDivisionError: division by zero\n    1 / 0\n"
    )
    assert "Warning: beware" in result.stdout.splitlines()
    assert contents(".").keys() == {"thin.py"}


@pytest.mark.parametrize(
    ("shown", "said"),
    [
        ("show_object(cq.Workplane().lineTo(1, 1), name='axis')", "showed axis, which has no sol"),
        ("for n in 'aA': show_object(cq.Workplane().box(1, 1, 1), name=n)", "named a, A. Each bec"),
    ],
)
def test_what_cannot_become_a_file_is_an_error(folder, monkeypatch, shown, said):
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setattr(sys, "argv", [*sys.argv])
    (folder / "part.py").write_text(f"import cadquery as cq\n{shown}\n")
    with pytest.raises(ScriptError, match=said):
        worker.build("part.py", {}, str(folder), "AP214", flat_panels=False)
    assert contents(".").keys() == {"part.py"}


def test_build_of_a_shell_reports_it_and_its_modified_parts(folder):
    (folder / "vault.py").write_text(SHELL)
    result = build("vault.py", settings={"modify": True, "thickness": 21}, flat_panels=True)
    assert result.modified == ("03",)
    [report] = result.reports
    assert "16" in report
    assert report in str(result)
    assert "No longer the shape of their panel: 03." in str(result)
    assert report not in result.summary(heard=f"{report}\n")
    step, flat = result.written
    assert step.path == Path("exports/vault/vault.step")
    assert step.size == step.path.stat().st_size
    assert flat.path == Path("exports/vault/vault_panels")
    assert flat.files == 16
    assert flat.size == sum(path.stat().st_size for path in flat.path.iterdir())
    # flat: the thickness stands along z, from the table up
    box = cq.importers.importStep(str(flat.path / "12.step")).val().BoundingBox()
    assert (box.xmin, box.ymin, box.zmin, box.zmax) == pytest.approx((0, 0, 0, 21), abs=1e-5)


def test_flat_panels_of_an_earlier_design_are_removed(folder):
    (folder / "vault.py").write_text(SHELL)
    panels = Path("exports/vault/vault_panels")
    panels.mkdir(parents=True)
    (panels / "0312.step").write_text("of an earlier design")
    (panels / "notes.txt").write_text("keep me")
    build("vault.py", settings={"depth": 1}, flat_panels=True)
    assert contents(panels).keys() == {"0.step", "1.step", "2.step", "3.step", "notes.txt"}
