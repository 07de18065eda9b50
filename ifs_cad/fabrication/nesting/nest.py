"""Nesting: which piece is cut from which sheet, and where.

The true silhouettes are nested, top and bottom together, never turned over. The spacing is the
least distance of two silhouettes; it has to hold the flank cutter, tilted as the chamfers are, see
`envelope`. Pieces come in the order of their addresses, so that neighbours of the assembly lie on
the same sheet, or on the next, where that needs no further sheet.

There are two ways: a fast one, which always gives the same answer (`packing`), and a thorough one,
which takes the time it is given: half of it for the fast way with many windows, the other half for
spyrrow (`thorough`). What either returns is checked: each
piece once, within the margins, true distances, fibre directions.

Source: section 4.3 (each element oriented to the raw sheet and the fibre direction, multi-part
plates).
"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.errors import InputError, StockError
from ifs_cad.fabrication.convex import Polygons, distances
from ifs_cad.fabrication.layout import Layout, NestedSheet
from ifs_cad.fabrication.nesting.offcuts import offcuts
from ifs_cad.fabrication.nesting.packing import Spot, fill_sheet
from ifs_cad.fabrication.nesting.poses import FibreLimits, Piece, poses_on, sheet_angle
from ifs_cad.fabrication.nesting.supply import Fill, Kind, Load, load_sheets, worth
from ifs_cad.fabrication.nesting.thorough import StripFill
from ifs_cad.fabrication.stock import Sheet
from ifs_cad.progress import report
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import FloatArray, frozen

Method = Literal["fast", "thorough"]

Outcome = tuple[list[Load], list[int]]
"""Loaded sheets and the pieces left."""

WINDOWS = ((48, True), (48, False), (24, False), (96, True), (12, False), (36, True))
"""From how many pieces the next one is chosen, and whether others follow when none of them fits."""

MANY_WINDOWS = range(12, 140)
"""The windows that the thorough way tries the fast way with, in half of its time."""

EFFORT = 400
"""The fast way tries further windows while the poses of all pieces add up to less."""


def nest(
    pieces: Sequence[Piece],
    stock: Sequence[Sheet],
    *,
    spacing: float,
    margin: float = 10.0,
    fibre: FibreLimits | None = None,
    method: Method = "fast",
    seconds: float = 60.0,
    seed: int = 0,
    tol: Tolerance = DEFAULT,
) -> Layout:
    """Lay pieces on sheets.

    Parameters
    ----------
    pieces : sequence of Piece
        Workpieces, neighbours next to each other.
    stock : sequence of Sheet
        What there is; a piece goes on sheets of its thickness and material.
    spacing : float
        Least distance of two silhouettes, mm.
    margin : float
        Least distance of a silhouette from the edge of its sheet, mm.
    fibre : FibreLimits, optional
        How far pieces may be turned off their fibre directions, such as the rule that gave them;
        without it not at all but for half turns.
    method : "fast" or "thorough"
    seconds : float
        How long the thorough way may take.
    seed : int
        Of the thorough way. It depends on time as well, so the same seed need not give the same
        answer; the fast way always does.

    Raises
    ------
    StockError
        A piece is larger than any sheet, no sheet has its thickness and material, or there are not
        enough sheets.
    InputError
        An address twice, a silhouette that is not convex, or a number that cannot be meant.
    MissingLibraryError
        The thorough way without spyrrow.
    """
    _check_input(pieces, spacing, margin, method, seconds, tol)
    groups = _groups(pieces, tol)
    choices = [_kinds(group, stock, margin, fibre, tol) for group in groups]  # errors first
    sheets: list[NestedSheet] = []
    for group, kinds in zip(groups, choices, strict=True):
        share = seconds * len(group) / len(pieces)
        fast = _loads_fast(group, kinds, spacing, tol)
        loads, left = fast
        if method == "thorough":
            loads, left = _loads_thorough(group, kinds, spacing, fast, share, seed, tol)
        if left:
            raise _shortage([group[piece] for piece in left], len(group), kinds)
        for load in loads:
            sheets.append(_nested_sheet(load, group, spacing, number=len(sheets) + 1))
    layout = Layout(tuple(sheets), spacing, margin)
    _check_layout(layout, pieces, fibre, tol)
    report("nesting", len(pieces), len(pieces))
    return layout


def _loads_fast(
    group: Sequence[Piece], kinds: Sequence[Kind], spacing: float, tol: Tolerance
) -> Outcome:
    """Load sheets the fast way, with as many windows as the number of poses leaves time for."""
    order = list(range(len(group)))
    poses = sum(int(kind.poses.allowed.sum()) for kind in kinds)
    outcomes = []
    for window, reach in WINDOWS[: max(1, EFFORT // poses)]:
        fill = _fast_fill(spacing, window, reach, tol)
        outcome = load_sheets(kinds, order, fill)
        if outcome[1] and len(kinds) > 1:  # those that fit the fewest kinds of sheets first
            choosy = sorted(order, key=lambda piece: sum(kind.fits[piece] for kind in kinds))
            outcome = load_sheets(kinds, choosy, fill)
        outcomes.append(outcome)
    return _best(outcomes, kinds, order)


def _loads_thorough(
    group: Sequence[Piece],
    kinds: Sequence[Kind],
    spacing: float,
    fast: Outcome,
    seconds: float,
    seed: int,
    tol: Tolerance,
) -> Outcome:
    """Load sheets the fast way with many windows, then the thorough way; return the best."""
    deadline = time.monotonic() + seconds
    strips = StripFill(
        spacing,
        kinds=len(kinds),
        pieces=len(group),
        fast=_fast_fill(spacing, *WINDOWS[0], tol),
        deadline=deadline,
        seed=seed,
        tol=tol,
    )
    order = list(range(len(group)))
    best = fast
    for window in np.random.default_rng(seed).permutation(MANY_WINDOWS).tolist():
        if time.monotonic() > deadline - seconds / 2.0:
            break
        report("nesting", 0, len(group))
        fill = _fast_fill(spacing, window, True, tol)
        best = _best([best, load_sheets(kinds, order, fill)], kinds, order)
    return _best([best, load_sheets(kinds, order, strips)], kinds, order)


def _fast_fill(spacing: float, window: int, reach: bool, tol: Tolerance) -> Fill:
    """Return the fast way to fill one sheet."""

    def fill(kind: Kind, left: list[int]) -> list[Spot]:
        return fill_sheet(kind.poses, left, kind.room, spacing, window=window, reach=reach, tol=tol)

    return fill


def _best(outcomes: Sequence[Outcome], kinds: Sequence[Kind], order: Sequence[int]) -> Outcome:
    """Return the first best outcome; one that leaves nothing is better than any that does."""

    def rank(outcome: Outcome) -> tuple[int, tuple[float, ...]]:
        loads, left = outcome
        return len(left), () if left else worth(loads, kinds, order)

    return min(outcomes, key=rank)


def _groups(pieces: Sequence[Piece], tol: Tolerance) -> list[list[Piece]]:
    """Return the pieces by thickness and material, in their order."""
    groups: list[list[Piece]] = []
    for piece in pieces:
        for group in groups:
            if _same_material(piece, group[0], tol):
                group.append(piece)
                break
        else:
            groups.append([piece])
    return groups


def _same_material(one: Piece | Sheet, other: Piece | Sheet, tol: Tolerance) -> bool:
    alike = abs(one.thickness - other.thickness) <= tol.coplanar
    return alike and one.material.name == other.material.name


def _kinds(
    group: Sequence[Piece],
    stock: Sequence[Sheet],
    margin: float,
    limits: FibreLimits | None,
    tol: Tolerance,
) -> list[Kind]:
    """Return the kinds of sheets for a group of pieces, each of which fits at least one of them.

    Raises
    ------
    StockError
    """
    what = f"{group[0].thickness:g} mm {group[0].material.name}"
    kinds = []
    for sheet in stock:
        room = np.array([sheet.length, sheet.width]) - 2.0 * margin
        if _same_material(sheet, group[0], tol) and sheet.count != 0 and (room > 0.0).all():
            kinds.append(Kind(sheet, poses_on(group, sheet, limits, room), room))
    if not kinds:
        addresses = [piece.address for piece in group]
        there = ", ".join(sheet.name for sheet in stock) or "nothing"
        raise StockError(
            f"No sheet of {what} is in stock for {listed(addresses)}; there is {there}. "
            "Add one to the stock.",
            addresses=addresses,
        )
    lost = np.flatnonzero(~np.any([kind.fits for kind in kinds], axis=0))
    if len(lost):
        sizes = [
            "{} ({:.0f} x {:.0f} mm)".format(group[piece].address, *_size(group[piece].silhouette))
            for piece in lost.tolist()
        ]
        addresses = [group[piece].address for piece in lost.tolist()]
        largest = max(kinds, key=lambda kind: kind.area)
        raise StockError(
            f"{len(lost)} of {len(group)} pieces are larger than any sheet of {what}, however "
            f"they may be turned: {listed(sizes)}. The largest sheet is {largest.sheet.length:g} x "
            f"{largest.sheet.width:g} mm with a margin of {margin:g} mm. Use larger sheets, "
            "let the fibre turn further, or divide the design more finely.",
            addresses=addresses,
        )
    return kinds


def _size(outline: FloatArray) -> tuple[float, float]:
    """Return the sides of the bounding rectangle, the longer one first, mm."""
    longer, shorter = sorted(np.ptp(outline, axis=0).tolist(), reverse=True)
    return longer, shorter


def _shortage(left: Sequence[Piece], total: int, kinds: Sequence[Kind]) -> StockError:
    """Return the error that says what finds no place on the sheets that there are."""
    area = sum(float(Polygons.of([piece.silhouette]).areas[0]) for piece in left)
    there = ", ".join(
        f"{kind.sheet.count} of {kind.sheet.name}" for kind in kinds if kind.sheet.count is not None
    )
    addresses = [piece.address for piece in left]
    return StockError(
        f"{len(left)} of {total} pieces, {area:.0f} mm2, find no place on the sheets there are "
        f"({there}): {listed(addresses)}. Add sheets, or nest with method='thorough'.",
        addresses=addresses,
    )


def _nested_sheet(load: Load, group: Sequence[Piece], spacing: float, number: int) -> NestedSheet:
    """Return a sheet with its placements and offcuts."""
    kind = load.kind
    edge = (np.array([kind.sheet.length, kind.sheet.width]) - kind.room) / 2.0
    spots = sorted(load.spots, key=lambda spot: spot.piece)
    placements = tuple(
        kind.poses.placement(group[spot.piece].address, spot.piece, spot.pose, spot.corner + edge)
        for spot in spots
    )
    outlines = [
        placement(group[spot.piece].silhouette)
        for placement, spot in zip(placements, spots, strict=True)
    ]
    return NestedSheet(
        number,
        kind.sheet,
        placements,
        float(Polygons.of(outlines).areas.sum()),
        frozen(offcuts(outlines, kind.sheet.length, kind.sheet.width, spacing)),
    )


def _check_input(
    pieces: Sequence[Piece],
    spacing: float,
    margin: float,
    method: Method,
    seconds: float,
    tol: Tolerance,
) -> None:
    """Refuse what cannot be meant.

    Raises
    ------
    InputError
    """
    for what, value in (("spacing", spacing), ("margin", margin), ("time", seconds)):
        if not 0.0 <= value < math.inf:
            raise InputError(f"The {what} of nesting must be 0 or more, got {value}.")
    if method not in get_args(Method):
        raise InputError(f"Nesting is one of {', '.join(get_args(Method))}, got {method!r}.")
    if not pieces:
        raise InputError("There are no pieces to nest.")
    addresses = [piece.address for piece in pieces]
    twice = [address for address, count in Counter(addresses).items() if count > 1]
    if twice:
        raise InputError(f"Each address may be nested once: {listed(twice)}.")
    silhouettes = Polygons.of([piece.silhouette for piece in pieces])
    edges = np.sum(silhouettes.normals * silhouettes.corners, axis=-1)
    real = np.any(np.roll(silhouettes.corners, -1, axis=1) != silhouettes.corners, axis=-1)
    beyond = np.where(real, silhouettes.levels - edges, 0.0).max(axis=1)
    bad = ~((beyond <= tol.planar) & (silhouettes.areas > 0.0))
    if bad.any():
        named = listed([addresses[piece] for piece in np.flatnonzero(bad).tolist()])
        raise InputError(
            f"A silhouette must be convex, counter-clockwise, and have an area; not so: {named}."
        )


def _check_layout(
    layout: Layout, pieces: Sequence[Piece], fibre: FibreLimits | None, tol: Tolerance
) -> None:
    """Check what was nested, without any trust in how.

    Raises
    ------
    RuntimeError
        A mistake of this package.
    """
    by_address = {piece.address: piece for piece in pieces}
    placed = [one.address for sheet in layout.sheets for one in sheet.placements]
    faults = [] if sorted(placed) == sorted(by_address) else ["a piece is missing or there twice"]
    for sheet in layout.sheets:
        on_it = [by_address[one.address] for one in sheet.placements]
        outlines = Polygons.of(
            [one(piece.silhouette) for one, piece in zip(sheet.placements, on_it, strict=True)]
        )
        size = np.array([sheet.stock.length, sheet.stock.width])
        beyond = np.maximum(-outlines.corners, outlines.corners - size).max() + layout.margin
        if beyond > tol.coincident:
            faults.append(f"a piece is {beyond:.3g} mm beyond the margins of {sheet.name}")
        gap = nearest(outlines, layout.spacing)
        if gap < layout.spacing - tol.coincident:
            faults.append(f"two pieces are {gap:.6g} mm apart on {sheet.name}")
        limit = fibre.tolerance if fibre else 0.0
        reverse = 180.0 if fibre is None or fibre.half_turn else 360.0
        for one, piece in zip(sheet.placements, on_it, strict=True):
            if piece.fibre is not None and sheet.stock.fibre is not None:
                x, y = one.rotation @ piece.fibre
                off = np.degrees(np.arctan2(y, x)) - sheet_angle(sheet.stock)
                off = abs((off + reverse / 2.0) % reverse - reverse / 2.0)
                if np.radians(off - limit) > tol.parallel:
                    faults.append(f"{piece.address} is turned {off:.3g} degrees off its fibre")
    if faults:
        raise RuntimeError(f"Nesting failed, which is a mistake in ifs_cad: {'; '.join(faults)}.")


def nearest(outlines: Polygons, within: float) -> float:
    """Return the least distance of two of (n,) polygons, mm; infinite where all exceed `within`."""
    low, high = outlines.corners.min(axis=1), outlines.corners.max(axis=1)
    gaps = np.maximum(low[:, None] - high[None], low[None] - high[:, None]).max(axis=-1)
    first, second = np.nonzero(np.triu(gaps <= within, k=1))
    return float(distances(outlines, first, second).min(initial=np.inf))
