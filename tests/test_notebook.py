"""Shells in a notebook that is really run."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

CELLS = (
    "import sys\n"
    "import ifs_cad as ifs\n"
    "arch = [(0, 0, 0), (0, 0, 100), (100, 0, 150)]\n"
    "shell = ifs.thicken(ifs.vector_sum(arch, [(0, 0, 0), (0, 50, 30), (0, 100, 0)]), 5)\n"
    "print('OCP' in sys.modules)",
    "shell",
    "shell['0']",
    "shell.mesh",
)


def test_a_notebook_shows_shells_panels_and_meshes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    nbformat = pytest.importorskip("nbformat", reason="nbclient is not installed")
    nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed")
    pytest.importorskip("ipykernel", reason="ipykernel is not installed")
    for name in ("HOME", "IPYTHONDIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR"):
        monkeypatch.setenv(name, str(tmp_path))
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(Path(__file__).parents[1])]))
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in CELLS])
    nbclient.NotebookClient(book, timeout=300).execute()
    first, *shown = [cell.outputs[0] for cell in book.cells]
    assert first.text == "False\n"  # the kernel is loaded when something is shown
    scripts = [output.data["application/javascript"] for output in shown]
    # CadQuery's script holds two files of VTK for each part: its faces and its edges
    assert [script.count("<VTKFile") for script in scripts] == [4 * 2, 2, 2]
    assert all("text/plain" in output.data for output in shown)
