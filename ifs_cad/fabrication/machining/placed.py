"""What must come out of a sheet: all its workpieces where they lie on it, in arrays.

z = 0 on the table and z = thickness on top, x and y from the lower left corner of the sheet.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ifs_cad.elements.arcs import Segments
from ifs_cad.errors import AddressError
from ifs_cad.fabrication.layout import NestedSheet, Placement
from ifs_cad.fabrication.machining.swept import Solids
from ifs_cad.fabrication.workpiece import Engraving, Side, Workpiece
from ifs_cad.types import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Holes:
    """Holes of all workpieces of a sheet.

    Attributes
    ----------
    owners : (n,) int, index of the workpiece
    points : (n, 2) float, mm
    diameters, depths : (n,) float, mm
    """

    owners: IntArray
    points: FloatArray
    diameters: FloatArray
    depths: FloatArray


@dataclass(frozen=True, eq=False)
class Strokes:
    """Lines and arcs of all engraved addresses of a sheet.

    Attributes
    ----------
    owners : (n,) int, index of the workpiece
    segments : Segments
    depths : (n,) float, mm
    cutters : (n,) float, diameters, mm; 0 for any
    """

    owners: IntArray
    segments: Segments
    depths: FloatArray
    cutters: FloatArray


@dataclass(frozen=True, eq=False)
class Sides:
    """Sides of all workpieces of a sheet.

    Attributes
    ----------
    owners : (n,) int, index of the workpiece
    corners : n arrays of (k, 3) float, mm
    normals, travels, axes : (n, 3) float, unit vectors, see `workpiece.Side`
    neighbours : n addresses on the other side
    """

    owners: IntArray
    corners: tuple[FloatArray, ...]
    normals: FloatArray
    travels: FloatArray
    axes: FloatArray
    neighbours: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class PlacedSheet:
    """A nested sheet with everything at its place.

    Attributes
    ----------
    addresses : of the workpieces
    length, width, thickness : float, of the sheet, mm
    holes, strokes, sides : what must be made
    solids : the workpieces before holes and strokes
    """

    addresses: tuple[str, ...]
    length: float
    width: float
    thickness: float
    holes: Holes
    strokes: Strokes
    sides: Sides
    solids: Solids


def placed_sheet(
    sheet: NestedSheet, workpieces: Mapping[str, Workpiece], stroke_depth: float
) -> PlacedSheet:
    """Lay the workpieces of a sheet at their places.

    Parameters
    ----------
    workpieces : by address
    stroke_depth : float, of strokes that are only drawn, mm

    Raises
    ------
    AddressError
        A placement whose workpiece is not among them.
    """
    addresses = tuple(placement.address for placement in sheet.placements)
    if missing := [address for address in addresses if address not in workpieces]:
        raise AddressError(
            f"{sheet.name} holds {', '.join(missing)}, but no such workpieces were given.",
            addresses=missing,
        )
    pieces = [workpieces[address] for address in addresses]
    sides = _sides(pieces, sheet.placements)
    firsts = np.searchsorted(sides.owners, np.arange(len(pieces) + 1)).tolist()
    caps = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    spans = list(pairwise(firsts))
    return PlacedSheet(
        addresses=addresses,
        length=sheet.stock.length,
        width=sheet.stock.width,
        thickness=sheet.stock.thickness,
        holes=_holes(pieces, sheet.placements),
        strokes=_strokes(pieces, sheet.placements, stroke_depth),
        sides=sides,
        solids=Solids.of(
            [np.concatenate(sides.corners[start:stop]) for start, stop in spans],
            [np.concatenate([caps, sides.normals[start:stop]]) for start, stop in spans],
        ),
    )


def _sides(pieces: list[Workpiece], placements: tuple[Placement, ...]) -> Sides:
    owned: list[tuple[int, Placement, Side]] = [
        (owner, placement, side)
        for owner, (piece, placement) in enumerate(zip(pieces, placements, strict=True))
        for side in piece.sides
    ]

    def turned(name: str) -> FloatArray:
        rows = [_turned(placement, getattr(side, name)) for _, placement, side in owned]
        return np.array(rows).reshape(-1, 3)

    return Sides(
        np.array([owner for owner, _, _ in owned], dtype=np.int64),
        tuple(placement(side.corners) for _, placement, side in owned),
        turned("normal"),
        turned("travel"),
        turned("axis"),
        tuple(side.neighbour for _, _, side in owned),
    )


def _turned(placement: Placement, direction: FloatArray) -> FloatArray:
    return np.append(placement.rotation @ direction[:2], direction[2])


def _holes(pieces: list[Workpiece], placements: tuple[Placement, ...]) -> Holes:
    rows = [
        (owner, *point, drill.diameter, drill.depth)
        for owner, (piece, placement) in enumerate(zip(pieces, placements, strict=True))
        for drill in piece.drills
        for point in placement(drill.points).tolist()
    ]
    table = np.array(rows, dtype=float).reshape(-1, 5)
    return Holes(table[:, 0].astype(np.int64), table[:, 1:3], table[:, 3], table[:, 4])


def _strokes(
    pieces: list[Workpiece], placements: tuple[Placement, ...], drawn_depth: float
) -> Strokes:
    engraved: list[tuple[int, Engraving, Segments]] = []
    for owner, (piece, placement) in enumerate(zip(pieces, placements, strict=True)):
        engraving = piece.engraving
        if engraving is not None and engraving.strokes:
            drawn = Segments.of(engraving.strokes)
            turn = complex(*placement.rotation[:, 0])
            move = complex(placement.x, placement.y)
            placed = Segments(
                drawn.starts * turn + move,
                drawn.ends * turn + move,
                drawn.sweeps,
                drawn.centres * turn + move,
            )
            engraved.append((owner, engraving, placed))
    counts = [len(segments) for *_, segments in engraved]
    empty = np.zeros(0, dtype=complex)
    nothing = Segments(empty, empty, np.zeros(0), empty)
    return Strokes(
        np.repeat(np.array([owner for owner, *_ in engraved], dtype=np.int64), counts),
        Segments.joined([nothing, *(segments for *_, segments in engraved)]),
        np.repeat([each.depth or drawn_depth for _, each, _ in engraved], counts),
        np.repeat([each.cutter for _, each, _ in engraved], counts),
    )
