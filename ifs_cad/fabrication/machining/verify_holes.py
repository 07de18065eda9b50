"""Whether a program drills the holes that were designed.

A hole is made by every feed down an upright tool; what stands in the comments does not count.
"""

from __future__ import annotations

import numpy as np

from ifs_cad.fabrication.machining.cuts import Cuts
from ifs_cad.fabrication.machining.fault import Fault
from ifs_cad.fabrication.machining.motions import Program
from ifs_cad.fabrication.machining.placed import Holes, PlacedSheet
from ifs_cad.fabrication.machining.tool import Tool
from ifs_cad.fabrication.machining.verification import Finding
from ifs_cad.fabrication.machining.verify_kinds import wrong_kinds
from ifs_cad.tolerance import Tolerance
from ifs_cad.types import BoolArray, FloatArray, IntArray

NEAR = 5.0
"""A hole that was missed by less than this is named with the line that missed it, mm."""


def verify_holes(
    program: Program, cuts: Cuts, sheet: PlacedSheet, tools: dict[int, Tool], tol: Tolerance
) -> Finding:
    """Compare what is drilled with the holes of a sheet."""
    holes = sheet.holes
    makes = np.zeros((len(cuts), len(sheet.addresses)), dtype=bool)
    if len(holes.owners) == 0:
        return Finding((), makes, {})
    down = (
        cuts.upright
        & (cuts.along_axis == -1)
        & (cuts.ends[:, 2] < sheet.thickness - tol.machined)
        & (cuts.motions.tools > 0)
    )
    drills = np.flatnonzero(down & cuts.feeds)
    off = _off(cuts, drills, holes)
    bottoms = sheet.thickness - holes.depths
    through = bottoms <= tol.machined
    # through-holes need the full diameter below the sheet; others are as deep as the point goes
    points = np.where(through, cuts.points[drills, None], 0.0)
    too_high = cuts.ends[drills, 2, None] + points - np.where(through, 0.0, bottoms)
    deep_enough = np.where(through, too_high, np.abs(too_high)) <= tol.machined
    fits = np.abs(cuts.diameters[drills, None] - holes.diameters) <= tol.machined
    good = (off <= tol.machined) & deep_enough & fits
    # a hole may be bored in several goes, none of them wider or deeper than the last; between them
    # the drill comes back by rapid motions, which have rules of their own for how deep
    entries = np.flatnonzero(down)
    narrow = cuts.diameters[entries, None] <= holes.diameters + tol.machined
    shallow = through | (cuts.ends[entries, 2, None] - bottoms >= -tol.machined)
    harmless = (_off(cuts, entries, holes) <= tol.machined) & narrow & shallow
    for entry, hole in np.argwhere(harmless):
        makes[entries[entry], holes.owners[hole]] = True
    faults = [
        _missing(program, cuts, sheet, drills, off, hole, tol)
        for hole in np.flatnonzero(~good.any(axis=0)).tolist()
    ]
    faults += wrong_kinds(
        program,
        cuts,
        drills[good.any(axis=1)],
        tools,
        ("drill",),
        "A hole is drilled with {tool}, which is no drill.",
    )
    measured = {"hole": float(off[good].max(initial=0.0))}
    return Finding(tuple(faults), makes, measured)


def _off(cuts: Cuts, motions: IntArray, holes: Holes) -> FloatArray:
    """Return how far (k,) motions end from (h,) holes, seen from above, mm."""
    offsets = cuts.ends[motions, None, :2] - holes.points
    return np.asarray(np.hypot(offsets[..., 0], offsets[..., 1]))


def _missing(
    program: Program,
    cuts: Cuts,
    sheet: PlacedSheet,
    drills: IntArray,
    off: FloatArray,
    hole: int,
    tol: Tolerance,
) -> Fault:
    """Return the fault of a hole that nothing makes, with the line that comes nearest."""
    holes = sheet.holes
    address = sheet.addresses[holes.owners[hole]]
    x, y = holes.points[hole].tolist()
    size = float(holes.diameters[hole])
    what = f"The hole of {size:g} mm at ({x:.3f}, {y:.3f})"
    if len(drills) == 0 or off[:, hole].min() > NEAR:
        return Fault(program.line_of("pierce", address), address, f"{what} is not drilled.")
    # of those that are nearest, the one that goes deepest
    nearest = _nearest(off[:, hole] <= off[:, hole].min() + tol.machined, cuts.ends[drills, 2])
    motion = drills[nearest]
    depth = sheet.thickness - float(cuts.ends[motion, 2] + cuts.points[motion])
    message = (
        f"{what}, {holes.depths[hole]:g} mm deep, is drilled {off[nearest, hole]:.4f} mm off, with "
        f"{cuts.diameters[motion]:g} mm, {depth:.4f} mm deep at its full diameter."
    )
    return Fault(int(cuts.motions.lines[motion]), address, message)


def _nearest(candidates: BoolArray, heights: FloatArray) -> int:
    return int(np.argmin(np.where(candidates, heights, np.inf)))
