"""The documentation builds without a warning, and every block of code on its pages works."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest
from doc_examples import LANGUAGES, TO_READ, languages, run_page
from sphinx.util.inventory import InventoryFile
from sybil.example import SybilFailure

import ifs_cad

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(p for p in DOCS.rglob("*.md") if p.name[0] != "_")]
SLOW = {"README.md", "tutorial.md"}
UNRUN = "<!-- options only: slow -->\n"
PARTS = sorted((ROOT / "parts").glob("*.py"))


def name(page: Path) -> str:
    return str(page.relative_to(ROOT))


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, id=name(page), marks=[pytest.mark.slow] * (page.name in SLOW))
        for page in PAGES
        if languages(page) & {*LANGUAGES}
    ],
)
def test_blocks_of_page_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.setenv("OCP_PORT", "1")  # nothing listens there, so pages show nothing to anybody
    (tmp_path / "parts").symlink_to(ROOT / "parts")
    run_page(page)


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("```python\n1 / 0\n```\n", ZeroDivisionError),
        ("```python\nprint(1)\n```\n\n```output\n2\n```\n", SybilFailure),
        ("<!-- not run: why -->\n```python\nif\n```\n", SyntaxError),
        ("```sh\nfalse\n```\n", SybilFailure),
        (f"{UNRUN}```sh\nifs-cad build a.py --colour red\n```\n", SybilFailure),
        (f"{UNRUN}```sh\nmake coffee\n```\n", SybilFailure),
    ],
    ids=["python", "output", "syntax", "sh", "option", "target"],
)
def test_wrong_block_is_noticed(text, error, tmp_path):
    page = tmp_path / "page.md"
    page.write_text(text, encoding="utf-8")
    with pytest.raises(error):
        run_page(page)


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_blocks_of_page_are_in_known_languages(page):
    assert languages(page) <= {*LANGUAGES, *TO_READ}


@pytest.mark.slow
def test_site_builds_without_warning_and_has_every_public_name(tmp_path):
    site = tmp_path / "site"
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-d", tmp_path, DOCS, site],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    inventory = InventoryFile.loads((site / "objects.inv").read_bytes(), uri="")
    documented = {n for role, names in inventory.data.items() if role[:3] == "py:" for n in names}
    public = {f"ifs_cad.{n}" for n in ifs_cad.__all__} - {"ifs_cad.classics"}
    assert public | {"ifs_cad.design.classics"} <= documented


def test_gallery_shows_every_part_with_its_words_and_picture():
    gallery = (DOCS / "gallery.md").read_text(encoding="utf-8")
    headings = [line[3:] for line in gallery.splitlines() if line.startswith("## ")]
    assert headings == [part.stem for part in PARTS]
    summaries = re.findall(r"^\*(\d+) [a-z]+.*, [\d.]+ x [\d. x]+ m\.\*$", gallery, re.MULTILINE)
    assert len(summaries) == len(PARTS)
    for part in PARTS:
        words = ast.get_docstring(ast.parse(part.read_text(encoding="utf-8")))
        assert words
        assert words in gallery
        assert f"![{part.stem}](gallery/{part.stem}.png)" in gallery
        assert (DOCS / "gallery" / f"{part.stem}.png").is_file()
