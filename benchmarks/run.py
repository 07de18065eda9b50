"""Measure what ifs_cad promises, side by side with its peers, and print it as a table.

    python benchmarks/run.py                 all of it, a few minutes
    python benchmarks/run.py --only ab       some of it, by letter
    python benchmarks/run.py --quick         fewer repetitions
    python benchmarks/run.py --strict        exit with 1 when a limit is missed
    python benchmarks/run.py --write FILE    keep the table as Markdown, its pictures beside it

Times are the best of repetitions taken in turns (A B A B ...) in one run, so ratios hold on a busy
machine, too; "noise" is the median wall time over the best time.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

from table import Line, machine, markdown

# for the browser without a screen that the tests use
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

PREAMBLE = """\
# Benchmarks

Made by `python benchmarks/run.py --write benchmarks/results.md` on: {machine}.

Best of repetitions taken in turns (A B A B ...) in one run; the time of a repetition is the smaller
of its wall and its processor time. Noise is the median wall time over the best time: 1 on a quiet
machine. The panels are {thickness:g} mm thick, over a rough arch and a rough fold; the planks
follow a Bezier curve.

![The limits, and how much of each is used](pictures/limits.png)

"""

PICTURES = """
The studio of line m after a control point was dragged, and the viewer's page of line n, both in a
browser without a screen, in the run that made the table:

![The studio](pictures/studio.png)

![The preview](pictures/preview.png)
"""


def main() -> int:
    """Run what was asked for; return the exit code."""
    parser = argparse.ArgumentParser(
        description="Measure ifs_cad side by side with its peers.",
    )
    parser.add_argument("--only", default="abcdefghijklmn", metavar="LETTERS", help="from a to n")
    parser.add_argument("--quick", action="store_true", help="fewer repetitions")
    parser.add_argument("--strict", action="store_true", help="exit with 1 when a limit is missed")
    parser.add_argument("--write", type=Path, metavar="FILE", help="keep the table, and pictures")
    arguments = parser.parse_args()
    lines = []
    pictures = None
    if arguments.write is not None:
        pictures = arguments.write.parent / "pictures"
        pictures.mkdir(parents=True, exist_ok=True)
    for line in measured(set(arguments.only), arguments.quick, pictures):
        print(f"{line.key}: {line.what}: {' '.join(line.cells()[4:])}", file=sys.stderr)
        lines.append(line)
    lines.sort(key=lambda line: line.key)
    table = markdown(lines)
    print(f"{machine()}\n\n{table}")
    if pictures is not None:
        import designs
        from chart import draw_limits

        draw_limits(lines, pictures / "limits.png")
        head = PREAMBLE.format(machine=machine(), thickness=designs.THICKNESS)
        arguments.write.write_text(f"{head}{table}\n{PICTURES}", encoding="utf-8")
    missed = [line for line in lines if not line.passed]
    print(f"\n{len(missed)} of {sum(line.limit is not None for line in lines)} limits missed.")
    return int(bool(missed) and arguments.strict)


def measured(letters: set[str], quick: bool, pictures: Path | None) -> Iterator[Line]:
    """Measure topic after topic; the numpy one first, before the kernel is loaded."""
    if "a" in letters:
        import curves_to_panels

        yield from curves_to_panels.measure(2 if quick else 6)
    if "g" in letters:
        import curve_points

        yield from curve_points.measure(2 if quick else 6)
    if "b" in letters:
        import solids

        yield from solids.measure(1 if quick else 4)
    if "h" in letters:
        import solids

        yield from solids.measure_planks(1 if quick else 4)
    if letters & set("cde"):
        import step_file

        yield from (x for x in step_file.measure(1 if quick else 5) if x.key in letters)
    if "i" in letters:
        import workshop

        yield from workshop.measure_nesting(quick)
    if "j" in letters:
        import workshop

        yield from workshop.measure_folder()
    if "k" in letters:
        import machine_code

        yield from machine_code.measure(1 if quick else 3)
    if "l" in letters:
        import structure

        yield from structure.measure("l")
    if "m" in letters:
        import studio

        yield from studio.measure(2 if quick else 9, pictures)
    if "n" in letters:
        import preview

        yield from preview.measure(2 if quick else 9, pictures)
    if "f" in letters:
        import memory

        yield from memory.measure()


if __name__ == "__main__":
    sys.exit(main())
