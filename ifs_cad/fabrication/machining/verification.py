"""What a verification says."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from ifs_cad.fabrication.machining.fault import Fault
from ifs_cad.fabrication.machining.machine_time import interruptions
from ifs_cad.types import BoolArray

SHOWN = 20
"""Faults that the summary lists; the others are counted."""


@dataclass(frozen=True, eq=False)
class Finding:
    """What one part of the verification found.

    Attributes
    ----------
    faults : tuple of Fault
    makes : (n, p) bool, which motions make part of which workpieces
    measured : numbers by name, mm and degrees
    """

    faults: tuple[Fault, ...]
    makes: BoolArray
    measured: Mapping[str, float]


@dataclass(frozen=True)
class Verification:
    """What was found in one program.

    Attributes
    ----------
    name : str, of the sheet
    faults : tuple of Fault, by line; empty when the program makes what was designed
    holes, strokes, sides : int, how many were compared
    plane_error : float, largest distance of a side from its plane, mm
    angle_error : float, largest angle between a side and its plane, degrees
    hole_error, stroke_error : float, largest distance from their places, mm
    spoilboard_depth : float, how deep the table is cut, mm
    minutes : float, by the programmed feeds, the rapid speed, the speed of the rotary axes, dwells
        and the tool changes; stops take as long as the person takes, and are only counted
    tool_changes, stops : int, how often a tool is changed, and a person waited for (M0 and M1)
    removed : float, volume taken from the sheet, mm3; NaN when it was not simulated
    interpreter : str, what read the program: "rs274" and our own reader, or our own alone
    """

    name: str
    faults: tuple[Fault, ...]
    holes: int
    strokes: int
    sides: int
    plane_error: float
    angle_error: float
    hole_error: float
    stroke_error: float
    spoilboard_depth: float
    minutes: float
    tool_changes: int
    stops: int
    removed: float
    interpreter: str

    @property
    def ok(self) -> bool:
        """Whether there is no fault."""
        return not self.faults

    def as_dict(self) -> dict[str, Any]:
        """Return all of it as plain values, for JSON."""
        values = asdict(self)
        values["removed"] = None if math.isnan(self.removed) else self.removed
        return {"ok": self.ok, **values}

    def __str__(self) -> str:
        verdict = "verified" if self.ok else f"{len(self.faults)} faults"
        head = (
            f"{self.name}: {verdict}; {self.sides} sides within {self.plane_error:.6f} mm and "
            f"{self.angle_error:.6f} degrees, {self.holes} holes within {self.hole_error:.6f} mm, "
            f"{self.strokes} strokes within {self.stroke_error:.6f} mm; "
            f"{self.spoilboard_depth:.2f} mm into the table, {self.minutes:.1f} min "
            f"{interruptions(self.tool_changes, self.stops)}"
        )
        if not math.isnan(self.removed):
            head += f"; {self.removed / 1000:.1f} cm3 removed"
        head += f"; read by {self.interpreter}"
        lines = [head, *map(str, self.faults[:SHOWN])]
        if len(self.faults) > SHOWN:
            lines.append(f"and {len(self.faults) - SHOWN} more")
        return "\n".join(lines)
