"""(c), (d), (e) The STEP file: export against OpenCascade's writer, its size, the whole chain."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import cadquery as cq
import designs
from cadquery.occ_impl.assembly import toCAF
from OCP.Interface import Interface_Static
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_AsIs
from solids import forget_glyphs
from table import Line, milliseconds
from timing import interleaved

import ifs_cad as ifs
from ifs_cad.kernel.messages import quiet

COSTLY_DIGITS = "0245"  # the four with the most faces


def measure(rounds: int) -> list[Line]:
    """Time the chain, the export and OpenCascade's writer alone in turns, and weigh the files."""
    with TemporaryDirectory() as folder:
        return _times(Path(folder), rounds) + _sizes(Path(folder))


def _times(folder: Path, rounds: int) -> list[Line]:
    ours, theirs, chained = (folder / f"{name}.step" for name in ("ours", "theirs", "chain"))
    assembly = _assembly(designs.shell())
    _, document = toCAF(assembly, coloredSTEP=True)

    def chain() -> None:
        forget_glyphs()
        ifs.export_step(_assembly(designs.shell()), chained)

    with _writer_settings():
        times = interleaved(
            {
                "chain": chain,
                "export": lambda: ifs.export_step(assembly, ours),
                "writer": lambda: _write(document, theirs),
            },
            rounds,
        )
    if not _content(ours) == _content(theirs) == _content(chained):
        raise AssertionError("The writers did not write the same names, colours and faces.")
    whole, export, writer = (times[name] for name in ("chain", "export", "writer"))
    against = f"{milliseconds(writer.best)} STEPCAFControl_Writer alone"
    count = 4**designs.DEPTH
    return [
        Line(
            "c",
            f"export_step of {count} engraved panels, ready assembly",
            milliseconds(export.best),
            against,
            export.best / writer.best,
            " x",
            limit=1.15,
            noise=export.wall / export.best,
        ),
        Line(
            "e",
            f"design to closed STEP file, {count} engraved panels, glyphs included",
            milliseconds(whole.best),
            against,
            whole.best / writer.best,
            " x",
            limit=1.3,
            noise=whole.wall / whole.best,
        ),
    ]


def _sizes(folder: Path) -> list[Line]:
    shell = designs.shell()
    costly = designs.shell_named_with(COSTLY_DIGITS)
    lines = []
    for what, panels, holes, limit in (
        ("engraved, four digits, relieved", shell, None, 80),
        ("the same with four holes", shell, ifs.Holes(), 100),
        (f"without holes, digits {', '.join(COSTLY_DIGITS)} (most walls)", costly, None, None),
    ):
        path = ifs.export_step(_assembly(panels, holes), folder / "size.step")
        lines.append(
            Line(
                "d",
                f"bytes a panel: {what}",
                f"{path.stat().st_size / 1e6:.1f} MB for {len(panels)}",
                "",
                path.stat().st_size / 1e3 / len(panels),
                " kB",
                limit=limit,
            )
        )
    return lines


def _assembly(shell: ifs.Shell, holes: ifs.Holes | None = None) -> cq.Assembly:
    return ifs.to_assembly(shell, label="engraved", holes=holes, validate=False)


def _write(document: Any, path: Path) -> None:
    """Write a ready XCAF document with OpenCascade alone."""
    writer = STEPCAFControl_Writer()
    writer.SetColorMode(True)
    writer.SetNameMode(True)
    writer.SetLayerMode(True)
    writer.Transfer(document, STEPControl_AsIs)
    writer.Write(str(path))


@contextmanager
def _writer_settings() -> Iterator[None]:
    """Let OpenCascade's writer, too, leave out pcurves and its banner."""
    STEPCAFControl_Writer()  # the parameters exist only after the first writer
    pcurves = Interface_Static.IVal_s("write.surfacecurve.mode")
    try:
        Interface_Static.SetIVal_s("write.surfacecurve.mode", 0)
        with quiet():
            yield
    finally:
        Interface_Static.SetIVal_s("write.surfacecurve.mode", pcurves)


def _content(path: Path) -> dict[str, int]:
    """Return how many entities of each kind a STEP file holds that matters to a reader."""
    counted = re.findall(
        r"=\s*(PRODUCT|STYLED_ITEM|ADVANCED_FACE|MANIFOLD_SOLID_BREP|PCURVE)\s*\(",
        path.read_text("ascii"),
    )
    return {kind: counted.count(kind) for kind in set(counted)}
