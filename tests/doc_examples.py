"""What runs the blocks of a page of the documentation, in order and in one namespace.

- ``python`` runs; ``sh`` runs too, and its ``ifs-cad`` is the one of this interpreter.
- ``output`` is what the block before it must have printed; ``...`` stands for anything.
- A block with a caption is the content of a file of that name, and it does not run.
- Under the comment ``<!-- options only: why -->``, commands are read but not obeyed.
- Under ``<!-- needs: freecadcmd -->`` a block, and the output below it, is passed over where that
  program is not installed.
- Under ``<!-- not run: why -->`` a block is passed over too, but for its syntax when it is Python.
- Other languages (``text``, ``ini``, ``json``) are there to be read.
"""

from __future__ import annotations

import contextlib
import doctest
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import cast

import typer
from sybil import Document, Example
from sybil.evaluators.python import PythonEvaluator
from sybil.parsers.myst import CodeBlockParser
from typer.core import TyperGroup

from ifs_cad import cli

MAKEFILE = Path(__file__).parent.parent / "Makefile"
LANGUAGES = ("python", "sh", "output", "toml")
TO_READ = {"text", "ini", "json"}
FENCE = re.compile(r"^```+(?:\{code-block\} *)?([\w-]+) *$", re.MULTILINE)
CAPTION = re.compile(r"\A```+.*\n:caption: *(.+)\n")
OPTIONS_ONLY = re.compile(r"^<!-- options only: \S.* -->\s*\Z", re.MULTILINE)
PRINTED = (
    "_printed"  # in the namespace of a page: what its last block printed; None when it did not run
)
NEEDS = re.compile(r"^<!-- needs: (\S+) -->\s*\Z", re.MULTILINE)
NOT_RUN = re.compile(r"^<!-- not run: \S.* -->\s*\Z", re.MULTILINE)
CHECKER = doctest.OutputChecker()
LAX = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def languages(page: Path) -> set[str]:
    """Languages of all fenced blocks of a page."""
    return set(FENCE.findall(page.read_text(encoding="utf-8")))


def examples(page: Path) -> Iterator[Example]:
    """Blocks of a page that can be tested."""
    parsers = [CodeBlockParser(language, evaluate) for language in LANGUAGES]
    yield from Document.parse(str(page), *parsers).examples()


def run_page(page: Path) -> None:
    """Run the blocks of a page in the present folder; raise at the first that is wrong."""
    for example in examples(page):
        example.evaluate()


def evaluate(example: Example) -> str | None:
    """Run, read or compare one block; return what is wrong with it."""
    block = example.document.text[example.start : example.end]
    if file := CAPTION.match(block):
        Path(file.group(1)).write_text(example.parsed, encoding="utf-8")
        return None
    language, before = example.region.lexemes["arguments"], example.document.text[: example.start]
    needs = NEEDS.search(before)
    if NOT_RUN.search(before) or (needs and shutil.which(needs[1]) is None):
        if language == "python":
            compile(example.parsed, example.path, "exec")
        example.namespace[PRINTED] = None
        return None
    match language:
        case "python":
            return run_python(example)
        case "sh":
            return run_shell(example)
        case "output":
            return compare(example)
    return None


def run_python(example: Example) -> None:
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        PythonEvaluator()(example)
    example.namespace[PRINTED] = said.getvalue()


def run_shell(example: Example) -> str | None:
    if OPTIONS_ONLY.search(example.document.text[: example.start]):
        lines = str(example.parsed).replace("\\\n", " ").splitlines()
        faults = [read_command(shlex.split(line, comments=True)) for line in lines]
        return "\n".join(filter(None, faults)) or None
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", example.parsed],
        capture_output=True,
        text=True,
        env=os.environ | {"PATH": path, "COLUMNS": "100"},
        timeout=300,
    )
    example.namespace[PRINTED] = done.stdout
    return None if done.returncode == 0 else f"exit code {done.returncode}\n{done.stderr}"


def read_command(words: list[str]) -> str | None:
    """Return what `ifs-cad` or `make` would not understand in a command line of theirs."""
    match words:
        case ["ifs-cad", name, *rest]:
            group = cast(TyperGroup, typer.main.get_command(cli.app))
            context = group.make_context("ifs-cad", [name])
            command = group.get_command(context, name)
            if command is None:
                return f"ifs-cad has no command {name}"
            try:
                command.make_context(name, rest, parent=context)
            except Exception as error:  # of a class that depends on the version of typer
                return f"ifs-cad {name}: {error}"
        case ["make", target]:
            if not re.search(rf"^{target}:", MAKEFILE.read_text(encoding="utf-8"), re.MULTILINE):
                return f"The Makefile has no target {target}"
    return None


def compare(example: Example) -> str | None:
    got = example.namespace[PRINTED]
    if got is None or CHECKER.check_output(example.parsed, got, LAX):
        return None
    return f"Expected:\n{example.parsed}\nGot:\n{got}"
