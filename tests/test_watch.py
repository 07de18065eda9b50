"""Which saves are told, and how often."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from pathlib import Path

import pytest

from ifs_cad.workflow.watch import LOOK_MS, _saves, sources

pytest.importorskip("watchfiles", reason="watchfiles is not installed")

SURELY_TOLD = 60.0  # s, on a busy machine
SURELY_SILENT = 3 * LOOK_MS / 1000


@pytest.fixture
def script(tmp_path: Path) -> Path:
    path = tmp_path / "roof.py"
    path.write_text("depth = 1\n", encoding="utf-8")
    return path


@pytest.fixture
def pool() -> Iterator[ThreadPoolExecutor]:
    with ThreadPoolExecutor(1) as pool:
        yield pool


def told(save: Future[float]) -> bool:
    return not wait([save], SURELY_TOLD).not_done


def test_a_save_is_told_once_and_from_new_folders_too(
    script: Path, tmp_path: Path, pool: ThreadPoolExecutor
) -> None:
    module = tmp_path / "parts" / "beside.py"
    module.parent.mkdir()
    module.write_text("rise = 1\n", encoding="utf-8")
    files = {script}
    saves = _saves(files)
    next(saves)
    files.add(module)  # found while the script is shown
    coming = pool.submit(next, saves)
    assert not wait([coming], SURELY_SILENT).done
    module.write_text("rise = 20\n", encoding="utf-8")
    assert told(coming)
    coming = pool.submit(next, saves)
    assert not wait([coming], SURELY_SILENT).done
    script.write_text("depth = 20\n", encoding="utf-8")
    assert told(coming)


def test_a_save_while_another_is_shown_is_not_missed(
    script: Path, pool: ThreadPoolExecutor
) -> None:
    saves = _saves({script})
    next(saves)
    for depth in (20, 300):
        script.write_text(f"depth = {depth}\n", encoding="utf-8")
        assert told(pool.submit(next, saves))


def test_a_file_that_is_gone_is_awaited(script: Path, pool: ThreadPoolExecutor) -> None:
    saves = _saves({script})
    next(saves)
    coming = pool.submit(next, saves)
    script.unlink()
    assert not wait([coming], SURELY_SILENT).done
    script.write_text("depth = 20\n", encoding="utf-8")
    assert told(coming)


def test_the_files_of_a_script_are_what_it_imports_from_beside_it(tmp_path: Path) -> None:
    files = {
        "roof.py": "import ifs_cad, numpy\nfrom walls import brick\nimport kit.rib as rib\n",
        "walls.py": "def broken(:\n",
        "kit/__init__.py": "from . import edge\n",
        "kit/rib.py": "def later():\n    from .deep import core\n    import roof\n",
        "kit/edge.py": "",
        "kit/deep/__init__.py": "",
        "kit/deep/core.py": "from ..edge import nothing\n",
        "kit/unused.py": "",
        "other.py": "",
        "ifs_cad/__init__.py": "",
    }
    for name, text in files.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    found = {path.relative_to(tmp_path).as_posix() for path in sources(tmp_path / "roof.py")}
    assert found == files.keys() - {"kit/unused.py", "other.py", "ifs_cad/__init__.py"}


def test_a_script_that_is_broken_or_missing_is_still_awaited(tmp_path: Path) -> None:
    script = tmp_path / "roof.py"
    assert sources(script) == {script}
    script.write_text("def broken(:\n", encoding="utf-8")
    assert sources(script) == {script}
