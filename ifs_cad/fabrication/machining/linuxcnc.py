"""Replay by LinuxCNC's own interpreter, where it is installed.

`rs274` reads a program as the controller would and prints what the machine is told, with four
decimals. That is too coarse to measure short edges by, so positions are taken from our own reader;
LinuxCNC judges whether the program is accepted and whether it moves as we read it.

Source: LinuxCNC, the stand-alone interpreter rs274 and its canonical machining functions.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from ifs_cad.errors import MissingLibraryError
from ifs_cad.fabrication.machining.fault import Fault
from ifs_cad.fabrication.machining.motions import Motions
from ifs_cad.types import FloatArray, IntArray

__all__ = ["differences", "interpreter", "replayed"]

PRINTED = 1.01e-4
"""Positions agree when they differ by less than this, mm: LinuxCNC prints four decimals."""

TIME_LIMIT = 300.0
"""Seconds after which the interpreter is given up."""

ATTEMPTS = 3
"""Runs before a crash is believed: once, on a busy machine, it died of a bus error on a program
that it accepted in thirty further runs."""

_NUMBER = re.compile(r"^\s*[Nn]\s*\d+\s*")
_MOTION = re.compile(r"N(\d+)\s*(STRAIGHT_TRAVERSE|STRAIGHT_FEED|ARC_FEED)\(([^)]*)\)")
_QUOTED = re.compile(r"^N(\d+)", re.MULTILINE)


def interpreter() -> str | None:
    """Return where rs274 is installed, or None."""
    return shutil.which("rs274")


def replayed(text: str, tools: dict[int, float]) -> tuple[IntArray, FloatArray, tuple[Fault, ...]]:
    """Let LinuxCNC interpret a program.

    Parameters
    ----------
    text : str, the whole program
    tools : diameters by number, mm

    Returns
    -------
    lines : (n,) int, of the motions that move anything
    places : (n, 6) float, where they end: X, Y, Z, mm, and A, B, C, degrees
    faults : what LinuxCNC refuses; empty when it accepts the program

    Raises
    ------
    MissingLibraryError
        LinuxCNC is not installed.
    """
    program = interpreter()
    if program is None:
        raise MissingLibraryError(
            "LinuxCNC's interpreter rs274 is not installed. On Debian: apt-get install "
            "--no-install-recommends linuxcnc-uspace."
        )
    numbered = [
        raw if raw.strip() in ("", "%") else f"N{number} {_NUMBER.sub('', raw)}"
        for number, raw in enumerate(text.splitlines(), 1)
    ]
    with TemporaryDirectory() as folder:
        source, table = Path(folder) / "program.ngc", Path(folder) / "tools.tbl"
        source.write_text("\n".join(numbered) + "\n", encoding="utf-8")
        # the table is read in inches; only that the tools exist matters
        table.write_text(
            "".join(f"T{n} P{n} Z0 D{size / 25.4:.6f} ;\n" for n, size in sorted(tools.items()))
        )
        options = ["-g", "-n", "2", "-t", str(table), "-v", "parameters.var"]
        for _ in range(ATTEMPTS):
            done = _run([program, *options, str(source)], folder)
            if done.returncode >= 0:
                break
    lines, places = _moves(done.stdout)
    return lines, places, _refusals(done, len(numbered))


def _run(arguments: list[str], folder: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        arguments,
        cwd=folder,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="replace",
        timeout=TIME_LIMIT,
        # it keeps its tools in the home folder: runs at the same time must not share one
        env=os.environ | {"LC_ALL": "C", "HOME": folder},
        check=False,
    )


def _moves(output: str) -> tuple[IntArray, FloatArray]:
    """Return lines and end positions of the motions that move anything."""
    lines, places = [], []
    for number, function, arguments in _MOTION.findall(output):
        values = [float(value) for value in arguments.split(",")]
        if function == "ARC_FEED":
            x, y, _, _, _, z, *angles = values
            values = [x, y, z, *angles]
        lines.append(int(number))
        places.append(values)
    ends = np.array(places, dtype=float).reshape(-1, 6)
    moved = np.ones(len(ends), dtype=bool)
    moved[1:] = (np.diff(ends, axis=0) != 0.0).any(axis=1)
    return np.array(lines, dtype=np.int64)[moved], ends[moved]


def _refusals(done: subprocess.CompletedProcess[str], last: int) -> tuple[Fault, ...]:
    """Return what was refused: LinuxCNC stops at the first, and quotes its line."""
    if done.returncode == 0:
        return ()
    quoted = _QUOTED.search(done.stderr)
    rows = [row.strip() for row in done.stderr.splitlines()]
    said = [row for row in rows if row and row != "executing" and not row.startswith("link (")]
    message = said[0] if said else f"it ended with code {done.returncode}"
    return (Fault(int(quoted[1]) if quoted else last, "", f"LinuxCNC refuses it: {message}."),)


def differences(motions: Motions, lines: IntArray, places: FloatArray) -> tuple[Fault, ...]:
    """Return where LinuxCNC moves otherwise than our own reader; the first place only.

    Parameters
    ----------
    motions : as our own reader has them
    lines, places : as `replayed` returns them
    """
    # LinuxCNC begins at 0 where we begin nowhere, and prints moves that are too small to see
    ends = np.hstack([motions.ends, motions.end_angles])
    ends = np.where(np.isnan(ends), 0.0, ends)
    ours = _last_of_each_line(motions.lines, ends)
    theirs = _last_of_each_line(lines, places)
    for line in sorted(ours.keys() | theirs.keys()):
        mine, other = ours.get(line), theirs.get(line)
        if mine is None or other is None:
            # one of the two does not move: it stays where it was
            before = ours if mine is None else theirs
            earlier = max((known for known in before if known < line), default=None)
            stays = np.zeros(6) if earlier is None else before[earlier]
            mine = stays if mine is None else mine
            other = stays if other is None else other
        if (off := float(np.abs(mine - other).max())) > PRINTED:
            where = ", ".join(f"{value:.4f}" for value in other)
            message = f"LinuxCNC ends at ({where}), {off:.4f} from where our own reader ends."
            return (Fault(line, "", message),)
    return ()


def _last_of_each_line(lines: IntArray, places: FloatArray) -> dict[int, FloatArray]:
    return dict(zip(lines.tolist(), places, strict=True))
