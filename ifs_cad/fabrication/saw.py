"""Three axes and a saw: square pieces for a machine that cannot tilt, and the list of what is sawn.

`square_workpieces` gives each piece vertical sides around its silhouette, the least outline that
holds all of it: where all sides lean one way, that of the larger face. Holes and the address stay
where they are, so that every program, drawing and layout takes these pieces as they are. What is
left beyond the designed sides, `saw_list` tells a saw with a tilting blade or table to cut off.
Every side is a plane that bounds a convex body: a cut right through, in any order, takes nothing of
the piece.

Terms
-----
face up : the face on which the piece is wider at an edge. There the edge of the square piece is
    the edge of the finished one: the blade enters along it and leans under it.
blade angle : of the blade from square, degrees; the size of the inclination of the side.
setback : distance of the cut from the edge of the square piece, on the face that lies down, mm.
across : distance from the edge of the square piece to what lies farthest from it, mm: where a stop
    or a fence is set.
by hand : what a saw does not reach: steeper than its blade tilts, shorter than what guides it, or a
    side of a node relief or a floor that misses the face up, so that no edge leads the blade.

Source: section 4.3 (the chamfer of each edge), for workshops without a five-axis machine.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby
from typing import Literal

import numpy as np

from ifs_cad.errors import InputError
from ifs_cad.fabrication.cutlist import require_unique
from ifs_cad.fabrication.measure import outline_area, side_edges
from ifs_cad.fabrication.table import Cell, Column, Table
from ifs_cad.fabrication.workpiece import Side, Workpiece
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import FloatArray
from ifs_cad.vectors import cross, dot


@dataclass(frozen=True)
class SawCut:
    """One side, as a saw sees it. For terms see the module.

    Attributes
    ----------
    address : str
    edge : int, from 1, as in a cut list: counter-clockwise seen on the marked face
    kind, neighbour : str, see `fabrication.workpiece.Side`
    thickness : float, mm
    up : str, "marked" or "back", the face that lies up
    length : float, of the edge on the face up, mm; of the whole side where it misses that face
    angle : float, degrees from square
    setting : float, degrees, the angle on the scale of the saw
    setback, across : float, mm
    obstacle : str, why it is cut by hand; empty where a saw or the outline does it
    """

    address: str
    edge: int
    kind: str
    neighbour: str
    thickness: float
    up: Literal["marked", "back"]
    length: float
    angle: float
    setting: float
    setback: float
    across: float
    obstacle: str


@dataclass(frozen=True)
class SawList:
    """All sides of all pieces.

    Attributes
    ----------
    cuts : tuple of SawCut, in the order of cutting: one setting after the other, at each the pieces
        in their order
    by_hand : tuple of SawCut, in the order of the pieces
    square : tuple of SawCut, what the outline has made already
    """

    cuts: tuple[SawCut, ...]
    by_hand: tuple[SawCut, ...]
    square: tuple[SawCut, ...]

    def __len__(self) -> int:
        """Return the number of cuts for the saw."""
        return len(self.cuts)

    def __str__(self) -> str:
        settings = len({cut.setting for cut in self.cuts})
        metres = sum(cut.length for cut in self.cuts) / 1e3
        return (
            f"{len(self.cuts)} saw cuts, {metres:.1f} m, at {settings} settings; "
            f"{len(self.by_hand)} edges by hand, {len(self.square)} square"
        )

    @cached_property
    def tables(self) -> tuple[Table, ...]:
        """The list as tables: saw, by hand, settings, square."""
        return (
            _table("saw", self.cuts),
            _table("by hand", self.by_hand),
            self._settings,
            _table("square", self.square),
        )

    @property
    def _settings(self) -> Table:
        columns = (
            Column("setting (deg)"),
            Column("cuts", decimals=0),
            Column("length (m)", decimals=3),
        )
        stacks = [
            (setting, list(stack)) for setting, stack in groupby(self.cuts, lambda c: c.setting)
        ]
        rows = tuple(
            (setting, len(stack), sum(cut.length for cut in stack) / 1e3)
            for setting, stack in stacks
        )
        return Table("settings", columns, rows)


def saw_list(
    workpieces: Sequence[Workpiece],
    *,
    step: float = 0.1,
    steepest: float = 45.0,
    shortest: float = 20.0,
    tol: Tolerance = DEFAULT,
) -> SawList:
    """List the cuts that make designed pieces of square ones.

    Parameters
    ----------
    workpieces : sequence of Workpiece
        As designed, not the square ones.
    step : float, degrees
        What the scale of the saw shows. Sides that read 0 on it are left square.
    steepest : float, degrees
        How far the blade tilts.
    shortest : float, mm
        Edges shorter than this are cut by hand.
    tol : Tolerance

    Raises
    ------
    InputError
        A step or a tilt that cannot be meant; two workpieces with one address.
    """
    if not (math.isfinite(step) and step > 0.0):
        raise InputError(f"The step of the saw's scale must be positive, got {step} degrees.")
    if not 0.0 < steepest < 90.0:
        raise InputError(f"A blade tilts by more than 0 and less than 90 degrees, got {steepest}.")
    require_unique(workpieces)
    listed = [
        cut for workpiece in workpieces for cut in _cuts(workpiece, step, steepest, shortest, tol)
    ]
    return SawList(
        cuts=tuple(
            sorted(
                (cut for cut in listed if cut.setting > 0.0 and not cut.obstacle),
                key=lambda cut: cut.setting,
            )
        ),
        by_hand=tuple(cut for cut in listed if cut.obstacle),
        square=tuple(cut for cut in listed if cut.setting == 0.0),
    )


def square_workpieces(
    workpieces: Sequence[Workpiece], *, tol: Tolerance = DEFAULT
) -> tuple[Workpiece, ...]:
    """Return the pieces with vertical sides around their silhouettes.

    They lie as before, with the same holes and addresses, so that the layout of one set is that of
    the other. A side keeps the kind and the neighbour of the designed side that it holds; a short
    one across a corner between sides that lean two ways is a border.
    """
    return tuple(_squared(workpiece, tol) for workpiece in workpieces)


def _cuts(
    workpiece: Workpiece, step: float, steepest: float, shortest: float, tol: Tolerance
) -> list[SawCut]:
    edges = side_edges(workpiece, tol=tol)
    cuts = []
    for number, (side, upper, lower) in enumerate(
        zip(workpiece.sides, edges.upper_lengths, edges.lower_lengths, strict=True), start=1
    ):
        angle = abs(side.inclination)
        setting = round(round(angle / step) * step, 9)
        marked_up = side.inclination >= 0.0
        length = float(upper if marked_up else lower)
        missing = length <= tol.planar
        if missing:
            length = float(np.ptp(side.corners @ side.travel))
        obstacle = ""
        if setting == 0.0:
            pass
        elif angle > steepest:
            obstacle = f"steeper than {steepest:g} deg"
        elif missing:
            obstacle = "no edge on the face up"
        elif length < shortest:
            obstacle = f"shorter than {shortest:g} mm"
        cuts.append(
            SawCut(
                address=workpiece.address,
                edge=number,
                kind=side.kind,
                neighbour=side.neighbour,
                thickness=workpiece.thickness,
                up="marked" if marked_up else "back",
                length=length,
                angle=angle,
                setting=setting,
                setback=workpiece.thickness * math.tan(math.radians(angle)),
                across=float(np.ptp(workpiece.silhouette @ _outward(side))),
                obstacle=obstacle,
            )
        )
    return cuts


def _outward(side: Side) -> FloatArray:
    """Return the (2,) unit vector out of a side, in plan."""
    return np.asarray(side.normal[:2] / np.hypot(*side.normal[:2]))


def _squared(workpiece: Workpiece, tol: Tolerance) -> Workpiece:
    ring = workpiece.silhouette
    ends = np.roll(ring, -1, axis=0)
    along = ends - ring
    outward = np.column_stack([along[:, 1], -along[:, 0]]) / np.hypot(*along.T)[:, None]
    # the contour begins at the lower left, like that of any workpiece
    azimuth = np.mod(np.arctan2(outward[:, 1], outward[:, 0]) + 3 / 4 * np.pi, 2 * np.pi)
    top = workpiece.thickness
    sides = []
    for k in np.argsort(azimuth).tolist():
        start, end, normal = ring[k], ends[k], outward[k]
        kind, neighbour = _held(workpiece.sides, normal, float(start @ normal), tol)
        corners = np.array([(*start, 0.0), (*end, 0.0), (*end, top), (*start, top)])
        sides.append(Side(corners, np.append(normal, 0.0), 0.0, kind, neighbour))
    taken = _bulk(workpiece) - workpiece.volume
    return replace(
        workpiece,
        lower=ring,
        upper=ring,
        sides=tuple(sides),
        volume=outline_area(ring) * workpiece.thickness - taken,
    )


def _held(
    sides: Sequence[Side], normal: FloatArray, reach: float, tol: Tolerance
) -> tuple[str, str]:
    """Return kind and neighbour of the side that touches an edge of the silhouette along it."""
    for side in sides:
        turn = _outward(side) @ np.array([-normal[1], normal[0]])
        touching = abs((side.corners[:, :2] @ normal).max() - reach) <= tol.planar
        if abs(turn) <= tol.parallel and touching:
            return side.kind, side.neighbour
    return "border", ""


def _bulk(workpiece: Workpiece) -> float:
    """Return the volume of a workpiece without its holes and its address, mm3."""
    faces = [side.corners for side in workpiece.sides]
    for outline, height in ((workpiece.lower[::-1], 0.0), (workpiece.upper, workpiece.thickness)):
        faces.append(np.column_stack([outline, np.full(len(outline), height)]))
    return sum(
        float(dot(face[:1], cross(face[1:-1], face[2:])).sum()) / 6.0 for face in faces if len(face)
    )


_COLUMNS = (
    Column("setting (deg)", decimals=1),
    Column("address", "text"),
    Column("edge", decimals=0),
    Column("face up", "text"),
    Column("length (mm)"),
    Column("blade angle (deg)", decimals=3),
    Column("setback (mm)"),
    Column("across (mm)"),
    Column("thickness (mm)"),
    Column("kind", "text"),
    Column("neighbour", "text"),
    Column("obstacle", "text"),
)


def _table(name: str, cuts: Sequence[SawCut]) -> Table:
    return Table(name, _COLUMNS, tuple(_row(cut) for cut in cuts))


def _row(cut: SawCut) -> tuple[Cell, ...]:
    return (
        cut.setting,
        cut.address,
        cut.edge,
        cut.up,
        cut.length,
        cut.angle,
        cut.setback,
        cut.across,
        cut.thickness,
        cut.kind,
        cut.neighbour or None,
        cut.obstacle or None,
    )
