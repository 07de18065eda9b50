"""Whether the marks on the panels say what the panels are called."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ifs_cad import progress
from ifs_cad.elements.boundary import Curves
from ifs_cad.elements.reading import Reading, read_drawn, read_engraved
from ifs_cad.elements.sheet import Sheet
from ifs_cad.kernel.assembly import STROKES_SUFFIX
from ifs_cad.types import FloatArray
from ifs_cad.workflow.findings import Findings
from ifs_cad.workflow.verdict import Check, Failure


@dataclass(frozen=True)
class _Mark:
    """An address found on a part, "engraved" or "drawn"."""

    part: str
    style: str
    reading: Reading


def check_labels(found: Findings) -> Check:
    """Read engraved and drawn addresses and compare them with the names of the parts.

    Parts without a label are counted, no more. So are pockets that might be a label but cannot be
    read, unless some label in the file can.
    """
    marks = list(_engraved(found))
    drawn, failures = _drawn(found)
    marks += drawn
    readable = [mark for mark in marks if mark.reading.text]
    garbled = [mark.part for mark in marks if not mark.reading.text]
    for mark in readable:
        if mark.reading.text != mark.part:
            failures.append(
                Failure(
                    f"{mark.part} has {mark.reading.text!r} {mark.style} on it.",
                    (mark.part, mark.reading.text),
                )
            )
    if readable:
        failures += [Failure(f"The label of {part} cannot be read.", (part,)) for part in garbled]
    right = len({mark.part for mark in readable if mark.reading.text == mark.part})
    parts = {solid.part for solid in found.contents.solids}
    values: dict[str, Any] = {
        "right": right,
        "engraved": sum(mark.style == "engraved" for mark in readable),
        "drawn": sum(mark.style == "drawn" for mark in readable),
        "unreadable": len(garbled),
        "not_labelled": len(parts - {mark.part for mark in marks}),
        "heights": sorted({mark.reading.height for mark in readable}),
    }
    sizes = ", ".join(f"{height:g}" for height in values["heights"])
    finding = (
        f"{right} of {len(parts)} parts carry their name"
        + (f", {sizes} mm high" if sizes else "")
        + f"; {values['not_labelled']} not labelled"
    )
    return Check("labels", finding, values, tuple(failures))


def _engraved(found: Findings) -> Iterator[_Mark]:
    panels = list(zip(found.contents.solids, found.sheets, strict=True))
    for done, (solid, sheet) in enumerate(panels, 1):
        progress.report("reading labels", done, len(panels))
        if sheet is None:
            continue
        for outlines in sheet.outlines():
            reading = read_engraved(outlines, found.tol)
            if reading is not None:
                yield _Mark(solid.part, "engraved", reading)


def _drawn(found: Findings) -> tuple[list[_Mark], list[Failure]]:
    panels = {
        solid.part: (solid.placement, sheet)
        for solid, sheet in zip(found.contents.solids, found.sheets, strict=True)
    }
    marks, failures = [], []
    for strokes in found.contents.strokes:
        part = strokes.name.removesuffix(STROKES_SUFFIX)
        if part == strokes.name:
            continue
        placement, sheet = panels.get(part, (None, None))
        if placement is None or sheet is None:
            failures.append(Failure(f"{strokes.name} belongs to no panel.", (part,)))
            continue
        curves = strokes.curves.placed(strokes.placement).placed(_inverse(placement))
        normal = _face_under(curves, sheet, found.tol.planar)
        if normal is None:
            failures.append(Failure(f"{strokes.name} does not lie on a face of {part}.", (part,)))
            continue
        reading = read_drawn(curves.seen_along(normal), found.tol)
        marks.append(_Mark(part, "drawn", reading or Reading("", 0.0, 0.0)))
    return marks, failures


def _inverse(placement: FloatArray) -> FloatArray:
    turned = placement[:, :3].T
    return np.column_stack([turned, -turned @ placement[:, 3]])


def _face_under(curves: Curves, sheet: Sheet, slack: float) -> FloatArray | None:
    """Return the outward normal of the sheet face that curves lie on, None if on neither."""
    points = np.concatenate([curves.starts, curves.ends])
    body, hull = sheet.boundary, sheet.hull
    if hull is not None and (points @ hull.normals.T > hull.levels + slack).any():
        return None
    for face in sheet.pair:
        normal: FloatArray = body.directions[face]
        if len(points) and (np.abs((points - body.points[face]) @ normal) <= slack).all():
            return normal
    return None
