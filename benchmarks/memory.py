"""(f) Peak memory, each job in a Python of its own.

Linux tells the peak of a process itself; what `resource` tells elsewhere is the same there, but on
Linux it would count the process that started it as well.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import designs
from table import Line

STATUS = Path("/proc/self/status")
JOBS = ("panels", "step")


def measure() -> list[Line]:
    """Measure all jobs."""
    many, few = 4**designs.FINE_DEPTH, 4**designs.DEPTH
    what = {
        "panels": f"peak memory: curves to {many:,} relieved panels, numpy only",
        "step": f"peak memory: design to STEP file, {few} engraved panels",
    }
    lines = []
    for job in JOBS:
        answer = subprocess.run(
            [sys.executable, __file__, job], capture_output=True, text=True, check=True
        )
        before, peak = (float(number) for number in answer.stdout.split())
        imports = f"{before:.0f} MB after the imports"
        lines.append(Line("f", what[job], f"{peak:.0f} MB", imports, peak - before, " MB more"))
    return lines


def peak() -> float:
    """Return the largest memory that this process has held so far, MB."""
    if STATUS.exists():
        line = next(line for line in STATUS.read_text().splitlines() if line.startswith("VmHWM"))
        return int(line.split()[1]) * 1024 / 1e6
    import resource  # not on Windows

    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6


def _panels() -> None:
    designs.shell(designs.FINE_DEPTH)


def _step() -> None:
    from tempfile import TemporaryDirectory

    import ifs_cad as ifs

    with TemporaryDirectory() as folder:
        assembly = ifs.to_assembly(designs.shell(), label="engraved", validate=False)
        ifs.export_step(assembly, Path(folder) / "shell.step")


if __name__ == "__main__":
    (job,) = sys.argv[1:]
    designs.mesh(1)
    if job == "step":
        import ifs_cad.export.step  # noqa: F401  imports count as what was there before
    before = peak()
    {"panels": _panels, "step": _step}[job]()
    print(before, peak())
