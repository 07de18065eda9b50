"""Whether a program engraves the strokes that were designed.

A motion makes part of a stroke when all of it lies on one line or arc of the design at its depth;
together they must cover it from end to end. A dot is made by a plunge.
"""

from __future__ import annotations

import numpy as np

from ifs_cad.elements.arcs import ComplexArray, as_complex
from ifs_cad.fabrication.machining.cuts import Cuts
from ifs_cad.fabrication.machining.fault import Fault
from ifs_cad.fabrication.machining.motions import Kind, Program
from ifs_cad.fabrication.machining.placed import PlacedSheet
from ifs_cad.fabrication.machining.tool import Tool
from ifs_cad.fabrication.machining.verification import Finding
from ifs_cad.fabrication.machining.verify_kinds import wrong_kinds
from ifs_cad.tolerance import Tolerance
from ifs_cad.types import BoolArray, FloatArray, IntArray

NEAR = 5.0
"""A stroke that was missed by less than this is named with the line that missed it, mm."""

SAMPLES = np.linspace(0.0, 1.0, 5)
"""Shares of a motion where it is compared: an arc with two ends and three more points in common
with another is the same arc."""


def verify_strokes(
    program: Program, cuts: Cuts, sheet: PlacedSheet, tools: dict[int, Tool], tol: Tolerance
) -> Finding:
    """Compare what is engraved with the strokes of a sheet."""
    strokes = sheet.strokes
    makes = np.zeros((len(cuts), len(sheet.addresses)), dtype=bool)
    if len(strokes.owners) == 0:
        return Finding((), makes, {})
    low = np.minimum(cuts.starts[:, 2], cuts.ends[:, 2])
    graving = np.flatnonzero(
        cuts.placed & cuts.upright & cuts.steady & (low < sheet.thickness - tol.machined)
    )
    samples = _samples(cuts, graving)
    motions, segments = _near(samples, sheet, NEAR)
    off, shares = _compared(samples[motions], sheet, segments)
    floors = sheet.thickness - strokes.depths[segments]
    heights = np.stack([cuts.starts[graving[motions], 2], cuts.ends[graving[motions], 2]])
    placed = off <= tol.machined
    harmless = placed & (heights.min(axis=0) >= floors - tol.machined)
    cutters = strokes.cutters[segments]
    sizes = cuts.diameters[graving[motions]]
    harmless &= (cutters == 0.0) | (sizes <= cutters + tol.machined)
    makes[graving[motions[harmless]], strokes.owners[segments[harmless]]] = True

    deep = (np.abs(heights - floors) <= tol.machined).all(axis=0)
    plunged = np.abs(heights[1] - floors) <= tol.machined
    dots = (strokes.segments.lengths == 0.0)[segments]
    fits = (cutters == 0.0) | (np.abs(sizes - cutters) <= tol.machined)
    good = placed & fits & np.where(dots, plunged, deep) & cuts.feeds[graving[motions]]
    open_ = _uncovered(shares[good], segments[good], sheet, tol)
    faults = []
    reported: set[int] = set()
    for stroke in np.flatnonzero(open_).tolist():
        owner = int(strokes.owners[stroke])
        if owner in reported:  # one engraver off its place misses all strokes of an address
            continue
        reported.add(owner)
        near = segments == stroke
        faults.append(
            _missing(
                program, cuts, sheet, stroke, graving[motions[near]], off[near], heights[:, near]
            )
        )
    faults += wrong_kinds(
        program,
        cuts,
        graving[motions[good]],
        tools,
        ("engraver", "end mill"),
        "A stroke is engraved with {tool}.",
    )
    return Finding(tuple(faults), makes, {"stroke": float(off[good].max(initial=0.0))})


def _samples(cuts: Cuts, which: IntArray) -> ComplexArray:
    """Return (k, s) points along motions, seen from above."""
    lines = cuts.starts[which, None] + SAMPLES[:, None] * (cuts.ends - cuts.starts)[which, None]
    arcs = cuts.motions.kinds[which] == Kind.ARC
    lines[arcs] = cuts.arc_points(which[arcs], SAMPLES)
    return as_complex(lines[..., :2])


def _near(samples: ComplexArray, sheet: PlacedSheet, reach: float) -> tuple[IntArray, IntArray]:
    """Return pairs of motions and strokes whose boxes come within reach."""
    segments = sheet.strokes.segments
    along = np.stack([segments.at(np.full(len(segments), share)) for share in SAMPLES], axis=1)

    def box(points: ComplexArray) -> tuple[FloatArray, FloatArray]:
        flat = np.stack([points.real, points.imag], axis=-1)
        return flat.min(axis=1), flat.max(axis=1)

    low, high = box(samples)
    least, most = box(along)
    near = (low[:, None] < most + reach) & (high[:, None] > least - reach)
    first, second = np.nonzero(near.all(axis=-1))
    return first.astype(np.int64), second.astype(np.int64)


def _compared(
    samples: ComplexArray, sheet: PlacedSheet, segments: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Return how far motions leave their strokes, (k,), and the shares they begin and end at."""
    strokes = sheet.strokes.segments
    off, shares = np.zeros(samples.shape), np.zeros(samples.shape)
    for column in range(samples.shape[1]):
        points = samples[:, column]
        chosen = strokes[segments]
        share, beside = chosen.locate(points)
        dot = chosen.starts == chosen.ends
        share = np.where(dot, 0.0, share)
        to_start, to_end = np.abs(points - chosen.starts), np.abs(points - chosen.ends)
        ends = np.minimum(to_start, to_end)
        within = (share >= 0.0) & (share <= 1.0) & ~dot
        off[:, column] = np.where(within, beside, ends)
        shares[:, column] = np.where(within, share, to_end < to_start)
    return off.max(axis=1), shares[:, [0, -1]]


def _uncovered(
    shares: FloatArray, segments: IntArray, sheet: PlacedSheet, tol: Tolerance
) -> BoolArray:
    """Return which strokes the motions on them leave open somewhere."""
    lengths = sheet.strokes.segments.lengths
    open_ = np.ones(len(lengths), dtype=bool)
    low, high = shares.min(axis=1, initial=np.inf), shares.max(axis=1, initial=-np.inf)
    order = np.lexsort((low, segments))
    reached = np.zeros(len(lengths))
    for stroke, begin, end in zip(
        segments[order].tolist(), low[order].tolist(), high[order].tolist(), strict=True
    ):
        slack = tol.machined / lengths[stroke] if lengths[stroke] > 0.0 else 1.0
        if begin <= reached[stroke] + slack:
            reached[stroke] = max(reached[stroke], end)
            open_[stroke] = reached[stroke] < 1.0 - slack
    return open_


def _missing(
    program: Program,
    cuts: Cuts,
    sheet: PlacedSheet,
    stroke: int,
    motions: IntArray,
    off: FloatArray,
    heights: FloatArray,
) -> Fault:
    """Return the fault of a stroke that is not made, with the line that comes nearest."""
    strokes = sheet.strokes
    address = sheet.addresses[strokes.owners[stroke]]
    start, end = strokes.segments.starts[stroke], strokes.segments.ends[stroke]
    what = (
        f"The stroke from ({start.real:.3f}, {start.imag:.3f}) to ({end.real:.3f}, {end.imag:.3f})"
    )
    if len(motions) == 0:
        return Fault(program.line_of("engrave", address), address, f"{what} is not engraved.")
    floor = sheet.thickness - strokes.depths[stroke]
    nearest = int(np.argmin(off + np.abs(heights - floor).max(axis=0)))
    motion, height = motions[nearest], float(heights[:, nearest].max())
    cutter = float(strokes.cutters[stroke])
    with_what = f" of {cutter:g} mm" if cutter else ""
    message = (
        f"{what} is not engraved{with_what} at {strokes.depths[stroke]:g} mm from end to end: the "
        f"nearest motion is {off[nearest]:.4f} mm off, {sheet.thickness - height:.4f} mm deep, "
        f"{cuts.diameters[motion]:g} mm wide."
    )
    return Fault(int(cuts.motions.lines[motion]), address, message)
