"""Sides of workpieces as the flank of a cutter meets them, all sides of a sheet at once.

A cylinder that touches a side's plane from outside, its axis in parallel to the plane and square to
the travel, runs along the side. The workpiece is convex, so all of it lies behind the plane of each
of its sides: however far the cutter runs along a plane, however deep, it takes nothing of the
workpiece. That holds for sides that reach only one face, or none, as floors and reliefs make them,
and it is checked. A side that ends above the table is cut only as deep as it reaches.

Terms
-----
contact : the line where the cutter touches the plane; it ends with the tool, `breakthrough`
    below the lowest corner of the side.
lowest : the height of the lowest point of the cutter's end; where the workpiece is wider at its
    top, the far rim lies below the contact.
lift : how far a cutter is drawn back along its axis from its final depth.

Source: section 4.3 (the contour cut with the chamfer of each edge).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ifs_cad.errors import MachineError
from ifs_cad.fabrication.layout import Placement
from ifs_cad.fabrication.machining.settings import Settings
from ifs_cad.fabrication.machining.tool import Tool
from ifs_cad.fabrication.workpiece import Side, Workpiece
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import FloatArray, IntArray
from ifs_cad.vectors import cross, dot, unit

Placed = tuple[Workpiece, Placement]
"""A workpiece and where it lies on its sheet."""


@dataclass(frozen=True, eq=False)
class Flanks:
    """All sides on a sheet.

    Attributes
    ----------
    placed : workpieces with their places
    pieces, sides : (m,) int, which workpiece, and which of its sides
    normals, travels, axes : (m, 3) float, unit vectors on the sheet: outward, along the feed, and
        of the tool
    levels : (m,) float, of the planes along their normals, mm
    starts, stops : (m,) float, extent of each side along its travel, mm
    lows : (m,) float, height of the lowest corner, mm
    bottoms : (m, 2) float, extent along the travel of what lies on the table, mm; empty where the
        first exceeds the second
    """

    placed: tuple[Placed, ...]
    pieces: IntArray
    sides: IntArray
    normals: FloatArray
    travels: FloatArray
    axes: FloatArray
    levels: FloatArray
    starts: FloatArray
    stops: FloatArray
    lows: FloatArray
    bottoms: FloatArray

    @classmethod
    def of(
        cls, placed: Sequence[Placed], direction: str = "climb", tol: Tolerance = DEFAULT
    ) -> Flanks:
        """Return all sides of workpieces as they lie on their sheet.

        Parameters
        ----------
        placed : workpieces with their places
        direction : "climb" or "conventional"

        Raises
        ------
        MachineError
            A workpiece that is not convex.
        """
        counts = [len(piece.sides) for piece, _ in placed]
        sides = [side for piece, _ in placed for side in piece.sides]
        owner = np.repeat(np.arange(len(placed)), counts)
        turns = np.array([placement.rotation for _, placement in placed])
        shifts = np.array([(placement.x, placement.y) for _, placement in placed])
        normals = np.array([side.normal for side in sides])
        normals[:, :2] = np.einsum("mij,mj->mi", turns[owner], normals[:, :2])
        left = np.stack([-normals[:, 1], normals[:, 0], np.zeros(len(normals))], axis=1)
        left = unit(left)

        sizes = np.array([len(side.corners) for side in sides])
        first = np.cumsum(sizes) - sizes
        side_of = np.repeat(np.arange(len(sides)), sizes)
        corners = np.concatenate([side.corners for side in sides])
        of_corner = owner[side_of]
        corners[:, :2] = (
            np.einsum("kij,kj->ki", turns[of_corner], corners[:, :2]) + shifts[of_corner]
        )
        corners[np.abs(corners[:, 2]) <= tol.planar, 2] = 0.0
        travels = left if direction == "conventional" else -left
        levels = dot(corners[first], normals)
        _require_convex(placed, owner, normals, levels, corners, of_corner, tol)
        along = dot(corners, travels[side_of])
        on_table = corners[:, 2] == 0.0
        return cls(
            placed=tuple(placed),
            pieces=owner,
            sides=np.concatenate([np.arange(count) for count in counts]),
            normals=normals,
            travels=travels,
            axes=cross(normals, left),
            levels=levels,
            starts=np.minimum.reduceat(along, first),
            stops=np.maximum.reduceat(along, first),
            lows=np.minimum.reduceat(corners[:, 2], first),
            bottoms=np.stack(
                [
                    np.minimum.reduceat(np.where(on_table, along, np.inf), first),
                    np.maximum.reduceat(np.where(on_table, along, -np.inf), first),
                ],
                axis=1,
            ),
        )

    def __len__(self) -> int:
        return len(self.pieces)

    @property
    def inclinations(self) -> FloatArray:
        """(m,) float, degrees, positive where the workpiece is wider at its top."""
        return np.degrees(np.arctan2(-self.normals[:, 2], self.axes[:, 2]))

    def address(self, index: int) -> str:
        """Return the address of the workpiece that a side belongs to."""
        piece, _ = self.placed[int(self.pieces[index])]
        return piece.address

    def side(self, index: int) -> Side:
        """Return a side as its workpiece has it."""
        piece, _ = self.placed[int(self.pieces[index])]
        return piece.sides[int(self.sides[index])]

    def name(self, index: int) -> str:
        """Return what messages call a side."""
        side = self.side(index)
        towards = f" towards {side.neighbour}" if side.neighbour else ""
        return f"{side.kind} side {self.sides[index] + 1} of {self.address(index)}{towards}"


def _require_convex(
    placed: Sequence[Placed],
    owner: IntArray,
    normals: FloatArray,
    levels: FloatArray,
    corners: FloatArray,
    of_corner: IntArray,
    tol: Tolerance,
) -> None:
    """Raise MachineError where a side's plane cuts its own workpiece.

    Parameters
    ----------
    owner : (m,) int, the workpiece of each plane
    of_corner : (k,) int, the workpiece of each corner, ascending
    """
    counts = np.bincount(of_corner, minlength=len(placed))
    firsts = np.cumsum(counts) - counts
    # all corners of a workpiece against each of its planes
    repeats = counts[owner]
    plane = np.repeat(np.arange(len(owner)), repeats)
    within = np.arange(len(plane)) - np.repeat(np.cumsum(repeats) - repeats, repeats)
    heights = dot(corners[firsts[owner[plane]] + within], normals[plane]) - levels[plane]
    if heights.max() > tol.coplanar:
        worst = int(np.argmax(heights))
        address = placed[owner[plane[worst]]][0].address
        raise MachineError(
            f"Panel {address} is not convex: it stands {heights[worst]:.3g} mm out over the plane "
            "of one of its sides, so that the flank of a cutter would take some of it.",
            addresses=[address],
            beyond=float(heights[worst]),
        )


@dataclass(frozen=True, eq=False)
class FlankCuts:
    """All sides of a sheet with the cutter that cuts them.

    Parameters
    ----------
    flanks : Flanks
    tool : Tool
    settings : Settings
    thickness : float, of the sheet, mm
    """

    flanks: Flanks
    tool: Tool
    settings: Settings
    thickness: float

    @property
    def radius(self) -> float:
        """Radius of the cutter, mm."""
        return self.tool.diameter / 2.0

    @property
    def lead(self) -> float:
        """How far the cutter runs beyond the ends of a side, mm."""
        return self.radius if self.settings.lead is None else self.settings.lead

    @cached_property
    def sink(self) -> FloatArray:
        """(m,) float, how far the far rim lies below the contact, mm."""
        return self.tool.diameter * np.maximum(-self.flanks.normals[:, 2], 0.0)

    @cached_property
    def lowest(self) -> FloatArray:
        """(m,) float, height of the lowest point of the cutter, mm; negative below the sheet."""
        reached = self.flanks.lows - self.settings.breakthrough - self.sink
        if self.settings.hold == "skin":
            return np.maximum(reached, self.settings.skin)
        return reached

    @cached_property
    def bases(self) -> FloatArray:
        """(m, 3) float, the tip at its final depth where the way along the travel is 0, mm."""
        flanks = self.flanks
        contact = self.lowest + self.sink
        up = (contact - flanks.levels * flanks.normals[:, 2]) / flanks.axes[:, 2]
        out = flanks.levels + self.radius
        return out[:, None] * flanks.normals + up[:, None] * flanks.axes

    @cached_property
    def depths(self) -> FloatArray:
        """(m,) float, how deep the cutter goes along its axis, mm: the flank that it needs."""
        return (self.thickness - self.lowest) / self.flanks.axes[:, 2]

    @cached_property
    def holder_heights(self) -> FloatArray:
        """(m,) float, of the lowest point of the holder above the sheet, mm."""
        rise = self.tool.reach * self.flanks.axes[:, 2]
        rim = self.tool.holder / 2.0 * np.abs(self.flanks.normals[:, 2])
        return self.bases[:, 2] + rise - rim - self.thickness

    def tips(self, index: int, along: FloatArray, lifts: FloatArray) -> FloatArray:
        """Return (n, 3) tips at ways along the travel of one side, drawn back along the tool."""
        flanks = self.flanks
        return np.asarray(
            self.bases[index]
            + np.multiply.outer(along, flanks.travels[index])
            + np.multiply.outer(lifts, flanks.axes[index])
        )
