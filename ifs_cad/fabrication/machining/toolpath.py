"""Programs for a sheet: pierce the fixation holes, engrave the addresses, cut the contours.

Source: section 4.3, figure 19.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.elements.arcs import Path
from ifs_cad.errors import InputError, MachineError
from ifs_cad.fabrication.layout import NestedSheet, Placement
from ifs_cad.fabrication.machining.contour import contours, passes_of
from ifs_cad.fabrication.machining.flank import FlankCuts, Flanks, Placed
from ifs_cad.fabrication.machining.limits import require_within
from ifs_cad.fabrication.machining.machine import Machine
from ifs_cad.fabrication.machining.motion import VERTICAL, Cut, Drilling, Moves, Program, Step
from ifs_cad.fabrication.machining.settings import Settings
from ifs_cad.fabrication.machining.sweep import require_clear
from ifs_cad.fabrication.machining.tool import Tool, ToolKind, require_unique
from ifs_cad.fabrication.workpiece import Drill, Engraving, Workpiece
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import FloatArray

__all__ = ["contour_mill", "toolpaths"]


def toolpaths(
    sheet: NestedSheet,
    workpieces: Iterable[Workpiece],
    tools: Sequence[Tool],
    machine: Machine,
    settings: Settings | None = None,
    *,
    tol: Tolerance = DEFAULT,
) -> Program:
    """Return what a machine does to cut all pieces from one sheet.

    Parameters
    ----------
    sheet : NestedSheet
    workpieces : those on the sheet, and any others
    tools : what is in the magazine
    machine : Machine
    settings : Settings, optional

    Raises
    ------
    MachineError
        What the machine or its tools cannot cut; names the address, and the side or the hole.
    InputError
        A piece that is not among the workpieces, or not as thick as its sheet; an empty sheet.
    """
    settings = settings or Settings()
    require_unique(tools)
    placed = _in_order(_placed(sheet, workpieces, tol))
    thickness = sheet.stock.thickness
    safe = thickness + machine.safe_height
    if machine.safe_height <= settings.clearance:
        raise MachineError(
            f"The safe height of {machine.safe_height:g} mm above the sheet must exceed the "
            f"clearance of {settings.clearance:g} mm."
        )
    material = sheet.stock.material.name
    fitting = [tool for tool in tools if tool.cuts(material)]
    flanks = Flanks.of(placed, settings.direction, tol)
    _require_tilt(flanks, machine, tol)
    cuts = _with_tool(flanks, fitting, settings, thickness)
    require_clear(cuts, tol)
    steps = [
        *_piercing(placed, fitting, machine, settings, safe, thickness, tol),
        *_engraving(placed, fitting, settings, safe, thickness, tol),
    ]
    along = [cut for found in contours(cuts, machine, safe) for cut in found]
    steps.append(Step("contour", cuts.tool, tuple(along)))
    program = Program(sheet, machine, safe, str(settings), tuple(steps))
    require_within(program, tol)
    return program


def contour_mill(
    pieces: Iterable[Workpiece],
    tools: Sequence[Tool],
    machine: Machine,
    settings: Settings | None = None,
    *,
    tol: Tolerance = DEFAULT,
) -> Tool:
    """Return the thinnest end mill that is long enough for all sides of all pieces.

    Parameters
    ----------
    pieces : Workpieces of one thickness
    tools : those for their material
    machine : Machine
    settings : Settings, optional

    Raises
    ------
    MachineError
        None is long enough, or the head does not tilt far enough; names the address and the side.
    """
    settings = settings or Settings()
    placed = [(piece, Placement(piece.address, 0.0, 0.0, 0.0)) for piece in pieces]
    flanks = Flanks.of(placed, settings.direction, tol)
    _require_tilt(flanks, machine, tol)
    return _with_tool(flanks, tools, settings, placed[0][0].thickness).tool


def _placed(sheet: NestedSheet, workpieces: Iterable[Workpiece], tol: Tolerance) -> list[Placed]:
    by_address = {piece.address: piece for piece in workpieces}
    lost = [one.address for one in sheet.placements if one.address not in by_address]
    if lost:
        raise InputError(f"{sheet.name} holds {listed(lost)}, which are not among the workpieces.")
    if not sheet.placements:
        raise InputError(f"{sheet.name} is empty: there is nothing to cut.")
    placed = [(by_address[one.address], one) for one in sheet.placements]
    for piece, _ in placed:
        if abs(piece.thickness - sheet.stock.thickness) > tol.coplanar:
            raise InputError(
                f"{piece.address} is {piece.thickness:g} mm thick and lies on {sheet.name} of "
                f"{sheet.stock.thickness:g} mm."
            )
    return placed


def _in_order(placed: Sequence[Placed]) -> list[Placed]:
    """Return the pieces from the lower left corner on, each time the nearest that is left."""
    middles = np.array([placement(piece.silhouette).mean(axis=0) for piece, placement in placed])
    return [placed[k] for k in _nearest_order(middles, np.zeros(2))]


def _nearest_order(points: FloatArray, start: FloatArray) -> list[int]:
    """Return the order of (n, 2) points in which the next one is always the nearest left."""
    left, here, order = np.arange(len(points)), start, []
    while len(left):
        place = int(np.argmin(np.hypot(*(points[left] - here).T)))
        order.append(int(left[place]))
        here, left = points[left[place]], np.delete(left, place)
    return order


def _require_tilt(flanks: Flanks, machine: Machine, tol: Tolerance) -> None:
    tilts = np.abs(flanks.inclinations)
    worst = int(np.argmax(tilts))
    if np.radians(tilts[worst] - machine.largest_tilt) > tol.parallel:
        raise MachineError(
            f"The {flanks.name(worst)} is inclined by {flanks.inclinations[worst]:.2f} degrees; "
            f"the head of {machine.name} tilts by {machine.largest_tilt:g} at most. Fold less "
            "there, or write no programs and cut it another way.",
            addresses=[flanks.address(worst)],
            angle=float(flanks.inclinations[worst]),
        )


def _with_tool(
    flanks: Flanks, tools: Sequence[Tool], settings: Settings, thickness: float
) -> FlankCuts:
    """Return the sides with the thinnest end mill long enough for all, or the chosen one."""
    mills = sorted(_of_kind(tools, "end mill"), key=lambda tool: tool.diameter)
    if settings.contour_tool is not None:
        mills = [tool for tool in mills if tool.number == settings.contour_tool]
    if not mills:
        wanted = (
            "no end mill"
            if settings.contour_tool is None
            else (f"no end mill with the number {settings.contour_tool}")
        )
        raise MachineError(f"There is {wanted} for this material. Add one to the tools.")
    for tool in mills:
        cuts = FlankCuts(flanks, tool, settings, thickness)
        if not _too_short(cuts):
            return cuts
    raise MachineError(
        f"{_too_short(cuts)} Use a longer end mill.",
        addresses=[flanks.address(int(np.argmax(cuts.depths)))],
        depth=float(cuts.depths.max()),
    )


def _too_short(cuts: FlankCuts) -> str:
    """Say why a cutter is too short; nothing when it is not."""
    deepest, lowest = int(np.argmax(cuts.depths)), int(np.argmin(cuts.holder_heights))
    if cuts.depths[deepest] > cuts.tool.flank:
        return (
            f"The {cuts.flanks.name(deepest)} needs {cuts.depths[deepest]:.1f} mm of flank; "
            f"{cuts.tool} has {cuts.tool.flank:g} mm."
        )
    if cuts.holder_heights[lowest] < cuts.settings.clearance:
        return (
            f"At the {cuts.flanks.name(lowest)} the holder of {cuts.tool} would come "
            f"{cuts.holder_heights[lowest]:.1f} mm above the sheet; the clearance is "
            f"{cuts.settings.clearance:g} mm."
        )
    return ""


def _of_kind(tools: Sequence[Tool], kind: ToolKind) -> list[Tool]:
    return [tool for tool in tools if tool.kind == kind]


def _matching(
    tools: Sequence[Tool], kind: ToolKind, diameter: float, address: str, tol: Tolerance
) -> Tool:
    """Return the tool of a kind and a diameter."""
    there = _of_kind(tools, kind)
    for tool in there:
        if abs(tool.diameter - diameter) <= tol.coplanar:
            return tool
    sizes = ", ".join(f"{tool.diameter:g}" for tool in there) or "none"
    article = "an" if kind[0] in "aeiou" else "a"
    raise MachineError(
        f"{address} needs {article} {kind} of {diameter:g} mm; for this material there are "
        f"{sizes}. Add one to the tools.",
        addresses=[address],
        diameter=diameter,
    )


def _piercing(
    placed: Sequence[Placed],
    tools: Sequence[Tool],
    machine: Machine,
    settings: Settings,
    safe: float,
    thickness: float,
    tol: Tolerance,
) -> list[Step]:
    """Return the steps that pierce the holes, one for each drill."""
    steps: dict[Tool, list[Drilling]] = {}
    here = np.zeros(2)
    for piece, placement in placed:
        for drill in piece.drills:
            tool = _matching(tools, "drill", drill.diameter, piece.address, tol)
            bottom = thickness - drill.depth
            if bottom <= tol.planar:
                bottom = -settings.drill_breakthrough - tool.point_height
            _require_drill(piece.address, drill, tool, thickness, bottom, machine, settings)
            points = placement(drill.points)
            points = points[_nearest_order(points, here)]
            here = points[-1]
            start = thickness + settings.clearance
            steps.setdefault(tool, []).append(
                Drilling(
                    piece.address,
                    points,
                    safe,
                    start,
                    bottom,
                    tool.pass_depth,
                    tool.plunge,
                    f"{len(points)} HOLES",
                )
            )
    ordered = sorted(steps, key=lambda tool: tool.number)
    return [Step("pierce", tool, tuple(steps[tool])) for tool in ordered]


def _require_drill(
    address: str,
    drill: Drill,
    tool: Tool,
    thickness: float,
    bottom: float,
    machine: Machine,
    settings: Settings,
) -> None:
    depth = thickness - bottom
    if depth > min(tool.flank, tool.reach - settings.clearance):
        raise MachineError(
            f"A hole of {drill.diameter:g} mm in {address} takes {tool} {depth:.1f} mm deep; it "
            f"cuts {tool.flank:g} mm and its holder comes at {tool.reach:g} mm. Use a "
            "longer drill.",
            addresses=[address],
            depth=depth,
        )
    if -bottom > machine.spoilboard_depth:
        raise MachineError(
            f"A hole of {drill.diameter:g} mm in {address} takes {tool} {-bottom:.2f} mm below the "
            f"sheet; the spoilboard may be cut {machine.spoilboard_depth:g} mm deep.",
            addresses=[address],
            depth=-bottom,
        )


def _engraving(
    placed: Sequence[Placed],
    tools: Sequence[Tool],
    settings: Settings,
    safe: float,
    thickness: float,
    tol: Tolerance,
) -> list[Step]:
    """Return the steps that engrave the addresses, one for each engraver."""
    steps: dict[Tool, list[Cut]] = {}
    for piece, placement in placed:
        engraving = piece.engraving
        if engraving is None:
            continue
        tool = _engraver(engraving, tools, piece.address, tol)
        depth = engraving.depth or settings.stroke_depth
        if depth > tool.flank:
            raise MachineError(
                f"The address of {piece.address} is {depth:g} mm deep; {tool} cuts "
                f"{tool.flank:g} mm.",
                addresses=[piece.address],
                depth=depth,
            )
        count = passes_of(depth, settings.pass_depth or tool.pass_depth)
        levels = [thickness - depth * (k + 1) / count for k in range(count)]
        start = thickness + settings.clearance
        strokes = [
            _stroke(path, placement(path.vertices), levels, start, tool)
            for path in engraving.strokes
        ]
        tips = np.array([[*strokes[0].tips[0, :2], safe], [*strokes[-1].tips[-1, :2], safe]])
        first, last = (Moves.lines(tips[k : k + 1], VERTICAL, np.zeros(1)) for k in (0, 1))
        moves = Moves.joined([first, *strokes, last])
        steps.setdefault(tool, []).append(Cut(piece.address, moves, f"TEXT {engraving.text}"))
    ordered = sorted(steps, key=lambda tool: tool.number)
    return [Step("engrave", tool, tuple(steps[tool])) for tool in ordered]


def _engraver(engraving: Engraving, tools: Sequence[Tool], address: str, tol: Tolerance) -> Tool:
    if engraving.cutter > 0.0:
        return _matching(tools, "engraver", engraving.cutter, address, tol)
    there = _of_kind(tools, "engraver")
    if not there:
        raise MachineError(f"There is no engraver for the address of {address}. Add one.")
    return min(there, key=lambda tool: tool.diameter)


def _stroke(
    path: Path, vertices: FloatArray, levels: list[float], start: float, tool: Tool
) -> Moves:
    """Return the moves along one stroke, from and to the height where feeding begins."""
    ring = vertices[: len(path.bulges) + 1] if not path.closed else [*vertices, vertices[0]]
    points = np.array(ring)
    count = len(points)
    tips = np.empty((len(levels), count + 2, 3))
    tips[:, 1:-1, :2] = points
    tips[:, 0, :2], tips[:, -1, :2] = points[0], points[-1]
    tips[:, 1:-1, 2] = np.array(levels)[:, None]
    tips[:, [0, -1], 2] = start
    feeds = np.array([0.0, tool.plunge, *[tool.feed] * (count - 1), 0.0])
    bulges = np.array([0.0, 0.0, *path.bulges, 0.0])
    moves = Moves.lines(tips.reshape(-1, 3), VERTICAL, np.tile(feeds, len(levels)))
    return Moves(moves.tips, moves.axes, moves.feeds, np.tile(bulges, len(levels)))
