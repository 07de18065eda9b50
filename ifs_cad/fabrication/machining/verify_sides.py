"""Whether the flanks of the cutters make the sides of the workpieces that were designed.

A motion whose tool does not turn leaves a plane: its normal is square to the tool and to the
motion, and it lies a radius off the axis. A motion counts for a side when the plane that it leaves
is that of the side, wherever the comments place it. What counts must cover the side, over its whole
length and down to the table, but for the bridges or the skin that hold the workpiece.

Terms
-----
u, v : coordinates in the plane of a side: along its travel and up its axis, mm.
excess : by how much the flank ends above the lower edge of a side, along its axis, mm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ifs_cad.fabrication.machining.cuts import Cuts
from ifs_cad.fabrication.machining.fault import Fault
from ifs_cad.fabrication.machining.motions import Kind, Program
from ifs_cad.fabrication.machining.placed import PlacedSheet
from ifs_cad.fabrication.machining.settings import Settings
from ifs_cad.fabrication.machining.tabs import FEWEST
from ifs_cad.fabrication.machining.tool import Tool
from ifs_cad.fabrication.machining.verification import Finding
from ifs_cad.fabrication.machining.verify_kinds import wrong_kinds
from ifs_cad.tolerance import Tolerance
from ifs_cad.types import BoolArray, FloatArray, IntArray
from ifs_cad.vectors import cross, dot, length, unit

NEAR = 25.0
"""A side that was missed by less than this is named with the line that missed it, mm."""

SLANTED = 0.5
"""Sine of the angle between a motion and a side from which it was meant for another."""

THIRDS = np.array([1.0, 2.0]) / 3.0


@dataclass(frozen=True, eq=False)
class _Passes:
    """Flank motions against sides, (m, s) each.

    Attributes
    ----------
    which : (m,) int, the motions
    error : largest distance of the flank from the plane of the side, where it is cut, mm
    angle : between the planes, degrees
    allowed : (m,) float, angle that rounded numbers may make on so short a motion, degrees
    u, v : (m, s, 2), of the tips at start and end
    """

    which: IntArray
    error: FloatArray
    angle: FloatArray
    allowed: FloatArray
    u: FloatArray
    v: FloatArray


def verify_sides(
    program: Program,
    cuts: Cuts,
    sheet: PlacedSheet,
    tools: dict[int, Tool],
    settings: Settings,
    tol: Tolerance,
) -> Finding:
    """Compare the planes that cutters leave with the sides of the workpieces of a sheet."""
    passes = _passes(program, cuts, sheet)
    fits = (passes.error <= tol.machined) & (passes.angle <= passes.allowed[:, None])
    fits &= np.abs(passes.u[..., 1] - passes.u[..., 0]) > tol.machined
    faults: list[Fault] = []
    plane, angle = 0.0, 0.0
    makes = np.zeros((len(cuts), len(sheet.addresses)), dtype=bool)
    bridges = np.zeros(len(sheet.addresses), dtype=np.int64)
    for side, corners in enumerate(sheet.sides.corners):
        coordinates = _flat(corners, sheet, side)
        own = np.flatnonzero(fits[:, side] & _beside(passes.u[:, side], coordinates, tol))
        makes[passes.which[own], sheet.sides.owners[side]] = True
        plane = max(plane, float(passes.error[own, side].max(initial=0.0)))
        long_ = own[passes.allowed[own] <= tol.machined_angle]
        angle = max(angle, float(passes.angle[long_, side].max(initial=0.0)))
        left, held = _side_faults(
            program, cuts, sheet, passes, side, own, coordinates, settings, tol
        )
        faults += left
        bridges[sheet.sides.owners[side]] += held
        faults += _ways_of_cutting(program, cuts, sheet, passes, side, own, settings, tools, tol)
    if settings.hold == "tabs":
        faults += _loose(program, sheet, bridges)
    faults += wrong_kinds(
        program,
        cuts,
        np.flatnonzero(makes.any(axis=1)),
        tools,
        ("end mill",),
        "A side is cut with {tool}, which is no end mill.",
    )
    return Finding(tuple(faults), makes, {"plane": plane, "angle": angle})


def _passes(program: Program, cuts: Cuts, sheet: PlacedSheet) -> _Passes:
    """Compare all motions that may cut flanks with all sides."""
    sides = sheet.sides
    which = np.flatnonzero(
        cuts.feeds
        & cuts.steady
        & (cuts.motions.kinds != Kind.ARC)
        & (cuts.along_axis == 0)
        & (cuts.lowest < sheet.thickness)
    )
    axes, radii = cuts.start_axes[which], cuts.radii[which]
    forward = cuts.ends[which] - cuts.starts[which]
    origins = np.array([corners[0] for corners in sides.corners]).reshape(-1, 3)

    def offsets(points: FloatArray) -> FloatArray:
        return points @ sides.normals.T - dot(origins, sides.normals)

    lean = axes @ sides.normals.T
    errors = []
    for tips in (cuts.starts[which], cuts.ends[which]):
        at_tip = offsets(tips) - radii[:, None]
        height = np.clip((sheet.thickness - tips[:, 2]) / axes[:, 2], 0.0, None)
        errors += [at_tip, at_tip + height[:, None] * lean]
    planes = unit(cross(axes, forward))
    aligned = np.abs(planes @ sides.normals.T)
    aside = length(cross(planes[:, None], sides.normals))
    angle = np.degrees(np.arctan2(aside, aligned))
    # both ends may be off by the last decimal, across the motion
    rounding = 2.0 * np.sqrt(2.0) * program.resolution / length(forward)
    allowed = np.maximum(cuts.tol.machined_angle, np.degrees(np.arctan(rounding)))

    def both(directions: FloatArray) -> FloatArray:
        start = dot(origins, directions)
        ends = [points[which] @ directions.T - start for points in (cuts.starts, cuts.ends)]
        return np.stack(ends, axis=-1)

    error = np.abs(errors).max(axis=0) if len(which) else np.zeros((0, len(origins)))
    return _Passes(which, error, angle, allowed, both(sides.travels), both(sides.axes))


def _flat(corners: FloatArray, sheet: PlacedSheet, side: int) -> FloatArray:
    """Return the (k, 2) corners of a side in its plane."""
    frame = np.stack([sheet.sides.travels[side], sheet.sides.axes[side]])
    return np.asarray((corners - corners[0]) @ frame.T)


def _beside(u: FloatArray, coordinates: FloatArray, tol: Tolerance) -> BoolArray:
    """Return which of (m, 2) motions pass along a side."""
    low, high = coordinates[:, 0].min(), coordinates[:, 0].max()
    overlap = np.minimum(u.max(axis=1), high) - np.maximum(u.min(axis=1), low)
    return np.asarray(overlap > min(tol.machined, (high - low) / 2.0))


def _side_faults(
    program: Program,
    cuts: Cuts,
    sheet: PlacedSheet,
    passes: _Passes,
    side: int,
    own: IntArray,
    coordinates: FloatArray,
    settings: Settings,
    tol: Tolerance,
) -> tuple[list[Fault], int]:
    """Return what is left of one side that should not be, and how many bridges are."""
    if len(own) == 0:
        return [_missed(program, cuts, sheet, passes, side, coordinates)], 0
    knots = _knots(passes.u[own, side], coordinates, tol)
    excess, by = _excess(passes.u[own, side], passes.v[own, side], knots, coordinates)
    widths = np.diff(knots)
    axis_height = float(sheet.sides.axes[side, 2])
    motions = passes.which[own]
    tilt_rise = float(cuts.diameters[motions].max()) * np.sqrt(max(0.0, 1.0 - axis_height**2))
    address = sheet.addresses[sheet.sides.owners[side]]
    faults, bridges = [], 0
    for first, last in _runs(excess * axis_height > tol.machined):
        span = float(widths[first:last].sum())
        left = float(excess[first:last].max()) * axis_height
        line = int(cuts.motions.lines[motions[by[first]]])
        if np.isfinite(left) and _holds(
            left, span, tilt_rise, float(cuts.diameters[motions].max()), settings, tol
        ):
            bridges += 1
            continue
        if not np.isfinite(left):
            line = int(cuts.motions.lines[motions].max())
        amount = f"{left:.3f} mm above the table" if np.isfinite(left) else "all of its height"
        where = f"{knots[first] - coordinates[:, 0].min():.2f} mm from its start"
        message = (
            f"The side{_towards(sheet, side)} is left uncut over {span:.3f} mm, {where}, {amount}."
        )
        faults.append(Fault(line, address, message))
    return faults, bridges


def _loose(program: Program, sheet: PlacedSheet, bridges: IntArray) -> list[Fault]:
    """Return the faults of workpieces that too few bridges hold."""
    return [
        Fault(
            program.line_of("contour", sheet.addresses[piece]),
            sheet.addresses[piece],
            f"{bridges[piece]} bridges hold it, at least {FEWEST} must.",
        )
        for piece in np.flatnonzero(bridges < FEWEST).tolist()
    ]


def _ways_of_cutting(
    program: Program,
    cuts: Cuts,
    sheet: PlacedSheet,
    passes: _Passes,
    side: int,
    own: IntArray,
    settings: Settings,
    tools: dict[int, Tool],
    tol: Tolerance,
) -> list[Fault]:
    """Return the faults of how one side is cut: its direction, the depth of passes, the skin."""
    faults = []
    deepest = 0.0
    for k in own[np.argsort(passes.which[own])].tolist():
        motion = int(passes.which[k])
        line = int(cuts.motions.lines[motion])
        address = program.address_at(line)
        # the workpiece is on the left of whoever goes along the side
        if (passes.u[k, side, 1] > passes.u[k, side, 0]) == (settings.direction == "climb"):
            faults.append(Fault(line, address, f"This is not a {settings.direction} cut."))
        lowest = float(cuts.lowest[motion])
        if settings.hold == "skin" and lowest < settings.skin - tol.machined:
            message = f"The tool goes down to {lowest:.3f} mm: the skin is {settings.skin:g} mm."
            faults.append(Fault(line, address, message))
        tool = tools.get(int(cuts.motions.tools[motion]))
        depth = (sheet.thickness - lowest) / float(cuts.start_axes[motion, 2])
        limit = settings.pass_depth or (tool.pass_depth if tool else np.inf)
        if depth - deepest > limit + tol.machined:
            message = f"A pass takes {depth - deepest:.3f} mm at once: {limit:g} mm are allowed."
            faults.append(Fault(line, address, message))
        deepest = max(deepest, depth)
    return faults


def _holds(
    left: float, span: float, rise: float, diameter: float, settings: Settings, tol: Tolerance
) -> bool:
    """Tell whether what is left is a bridge or a skin that was asked for.

    The end of a leaning cutter is higher on one side than on the other, so that what it leaves is
    thicker on that side; its width lengthens a bridge.
    """
    if settings.hold == "tabs":
        fits = left <= settings.tab_height + rise + tol.machined
        return fits and span <= settings.tab_length + 2.0 * diameter + tol.machined
    return settings.hold == "skin" and left <= settings.skin + rise + tol.machined


def _towards(sheet: PlacedSheet, side: int) -> str:
    neighbour = sheet.sides.neighbours[side]
    return f" towards {neighbour}" if neighbour else " on the border"


def _knots(u: FloatArray, coordinates: FloatArray, tol: Tolerance) -> FloatArray:
    """Return where along a side anything changes: between them all is linear."""
    low, high = coordinates[:, 0].min(), coordinates[:, 0].max()
    knots = np.unique(np.clip(np.concatenate([u.ravel(), coordinates[:, 0]]), low, high))
    keep = np.diff(knots, prepend=-np.inf) > min(tol.machined, (high - low) / 2.0)
    return np.asarray(knots[keep])


def _excess(
    u: FloatArray, v: FloatArray, knots: FloatArray, coordinates: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Return how far above its lower edge a side is cut, between knots, and by which motion.

    Infinite where no motion passes.
    """
    middles = (knots[:-1] + knots[1:]) / 2.0
    passing = (u.min(axis=1)[:, None] <= middles) & (u.max(axis=1)[:, None] >= middles)
    slopes = (v[:, 1] - v[:, 0]) / (u[:, 1] - u[:, 0])
    # linear between knots: two inner points give both ends, clear of the upright edges
    inner = knots[:-1, None] + THIRDS * np.diff(knots)[:, None]
    heights = v[:, None, None, 0] + slopes[:, None, None] * (inner - u[:, None, None, 0])
    above = heights - _lower_edge(coordinates, inner)
    ends = np.stack([2.0 * above[..., 0] - above[..., 1], 2.0 * above[..., 1] - above[..., 0]])
    worst = np.where(passing, ends.max(axis=0), np.inf)
    return worst.min(axis=0), worst.argmin(axis=0)


def _lower_edge(coordinates: FloatArray, u: FloatArray) -> FloatArray:
    """Return v of the lower edge of a convex side at places along it."""
    starts, ends = coordinates, np.roll(coordinates, -1, axis=0)
    across = u[..., None]
    spans = ends[:, 0] - starts[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = (across - starts[:, 0]) / spans
        heights = starts[:, 1] + shares * (ends[:, 1] - starts[:, 1])
    on_edge = (shares >= 0.0) & (shares <= 1.0)
    return np.asarray(np.where(on_edge, heights, np.inf).min(axis=-1))


def _runs(mask: BoolArray) -> list[tuple[int, int]]:
    """Return the stretches where a mask holds, first and past the last."""
    steps = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int64), [0]])))
    return list(zip(steps[::2].tolist(), steps[1::2].tolist(), strict=True))


def _missed(
    program: Program,
    cuts: Cuts,
    sheet: PlacedSheet,
    passes: _Passes,
    side: int,
    coordinates: FloatArray,
) -> Fault:
    """Return the fault of a side that no motion makes, with the line that comes nearest."""
    address = sheet.addresses[sheet.sides.owners[side]]
    what = f"The side{_towards(sheet, side)}"
    u = passes.u[:, side]
    low, high = coordinates[:, 0].min(), coordinates[:, 0].max()
    overlap = np.minimum(u.max(axis=1), high) - np.maximum(u.min(axis=1), low)
    forward = unit(cuts.ends[passes.which] - cuts.starts[passes.which])
    slanted = np.abs(forward @ sheet.sides.normals[side])
    candidates = (overlap > (high - low) / 2.0) & (slanted < SLANTED)
    candidates &= passes.error[:, side] < NEAR
    if not candidates.any():
        return Fault(program.line_of("contour", address), address, f"{what} is not cut.")
    nearest = int(np.argmin(np.where(candidates, passes.error[:, side], np.inf)))
    message = (
        f"{what} is not cut: the nearest pass is {passes.error[nearest, side]:.4f} mm and "
        f"{passes.angle[nearest, side]:.4f} degrees off."
    )
    return Fault(int(cuts.motions.lines[passes.which[nearest]]), address, message)
