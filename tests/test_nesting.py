"""Nested pieces, judged by shapely and by hand."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull
from shapely import LineString, Polygon, box

from ifs_cad import Curve, thicken, vector_sum
from ifs_cad.elements.cutting import cutting_frames
from ifs_cad.elements.material import SPRUCE, SPRUCE_PLYWOOD, Material
from ifs_cad.errors import InputError, MissingLibraryError, StockError
from ifs_cad.fabrication.convex import Polygons, distances
from ifs_cad.fabrication.layout import Layout
from ifs_cad.fabrication.nesting.nest import nest
from ifs_cad.fabrication.nesting.offcuts import LEAST, offcuts
from ifs_cad.fabrication.stock import Sheet
from ifs_cad.progress import listening
from ifs_cad.types import FloatArray

SHEET = Sheet("big", 2500.0, 1250.0, 10.0, SPRUCE_PLYWOOD)
X = np.array([1.0, 0.0])


@dataclass(frozen=True, eq=False)
class Piece:
    address: str
    silhouette: FloatArray
    fibre: FloatArray | None = None
    thickness: float = 10.0
    material: Material = SPRUCE_PLYWOOD


@dataclass(frozen=True)
class Limits:
    tolerance: float = 0.0
    half_turn: bool = True


def rectangle(address: str, length: float, width: float, **rest: object) -> Piece:
    corners = np.array([[0.0, 0.0], [length, 0.0], [length, width], [0.0, width]])
    return Piece(address, corners + np.array([30.0, -70.0]), **rest)  # type: ignore[arg-type]


def off_fibre(layout: Layout, piece: Piece) -> float:
    """How far a piece is turned off the grain of its sheet, degrees, up to half a turn."""
    sheet, placement = layout.homes[piece.address]
    grain = 90.0 if sheet.stock.fibre == "width" else 0.0
    assert piece.fibre is not None
    origin, tip = placement(np.array([[0.0, 0.0], piece.fibre]))
    turned = np.degrees(np.arctan2(*(tip - origin)[::-1]))
    return float(abs((turned - grain + 180.0) % 360.0 - 180.0))


def judge(layout: Layout, pieces: Sequence[Piece]) -> None:
    """Each piece once, on its sheet, apart from every other, and no offcut that is not free."""
    placed = [one.address for sheet in layout.sheets for one in sheet.placements]
    assert sorted(placed) == sorted(piece.address for piece in pieces)
    by_address = {piece.address: piece for piece in pieces}
    for number, sheet in enumerate(layout.sheets, start=1):
        assert sheet.number == number
        stock, margin = sheet.stock, layout.margin
        outlines = [Polygon(p(by_address[p.address].silhouette)) for p in sheet.placements]
        inside = box(margin, margin, stock.length - margin, stock.width - margin).buffer(1e-9)
        assert all(inside.covers(outline) for outline in outlines)
        for one, other in combinations(outlines, 2):
            assert one.distance(other) >= layout.spacing - 1e-9
            assert layout.spacing > 0.0 or one.intersection(other).area <= 1e-6
        assert sheet.used == pytest.approx(sum(outline.area for outline in outlines))
        rectangles = [box(x, y, x + a, y + b) for x, y, a, b in sheet.offcuts]
        whole = box(0.0, 0.0, stock.length, stock.width).buffer(1e-9)
        for rest in rectangles:
            assert whole.covers(rest)
            assert all(rest.distance(one) >= layout.spacing - 1e-9 for one in outlines)
        assert all(
            one.intersection(other).area == 0.0 for one, other in combinations(rectangles, 2)
        )


@st.composite
def convex_pieces(draw: st.DrawFn, most: int = 25, largest: float = 400.0) -> list[Piece]:
    """Convex hulls of points on ellipses, from slivers to nearly round, somewhere on a plane."""
    seed, count = draw(st.integers(0, 2**32 - 1)), draw(st.integers(1, most))
    random = np.random.default_rng(seed)
    pieces = []
    for number in range(count):
        angles = np.sort(random.uniform(0.0, 2.0 * np.pi, random.integers(3, 9)))
        radii = random.uniform(20.0, largest / 2.0, 2)
        points = np.column_stack([np.cos(angles), np.sin(angles)]) * radii
        hull = points[ConvexHull(points).vertices] + random.uniform(-1e3, 1e3, 2)
        fibre = random.normal(size=2)
        pieces.append(Piece(f"{number:03}", hull, fibre / np.hypot(*fibre)))
    return pieces


@pytest.fixture(scope="module")
def prototype() -> list[Piece]:
    """Two hundred and fifty-six quads of an arch over an evenly folded curve."""
    base = Curve([(0, 0, 0), (0, 1650, 300), (0, 3000, -60)], depth=3)
    fold = base.with_roughness(0.25).with_even_fold(0.85)
    arch = Curve([(0, 0, 0), (-225, 0, 2600), (4275, 0, 2900), (4500, 0, 0)], depth=4)
    frames = cutting_frames(thicken(vector_sum(arch, fold), 10.0), "inner")
    shell = frames.solids
    pieces = []
    for number in range(len(shell)):
        points = shell.vertices[shell.solid_of_vertex == number, :2]
        outline = points[ConvexHull(points).vertices]
        pieces.append(Piece(f"{number:03}", outline, X))
    return pieces


def test_prototype_lies_apart_and_along_the_grain(prototype: list[Piece]) -> None:
    layout = nest(prototype, [SHEET], spacing=15.0)
    judge(layout, prototype)
    assert len(prototype) == 256
    for piece in prototype:
        assert off_fibre(layout, piece) in (0.0, 180.0)
    # bounding boxes alone would leave 57 % of the wood in the pieces, before any loss by packing
    assert layout.utilisation > 0.57


def test_same_input_gives_the_same_layout(prototype: list[Piece]) -> None:
    one, other = (nest(prototype[:60], [SHEET], spacing=15.0) for _ in range(2))
    assert [sheet.placements for sheet in one.sheets] == [
        sheet.placements for sheet in other.sheets
    ]


def test_neighbours_share_a_sheet_where_that_costs_nothing() -> None:
    pieces = [rectangle(f"{number:02}", 1200.0, 600.0, fibre=X) for number in range(12)]
    layout = nest(pieces, [SHEET], spacing=15.0)
    at_home = [[one.address for one in sheet.placements] for sheet in layout.sheets]
    assert at_home == [["00", "01", "02", "03"], ["04", "05", "06", "07"], ["08", "09", "10", "11"]]


@given(convex_pieces(), st.sampled_from([0.0, 3.0, 20.0]), st.sampled_from([0.0, 10.0]))
@settings(max_examples=25, deadline=None)
def test_random_pieces_lie_apart(pieces: list[Piece], spacing: float, margin: float) -> None:
    judge(nest(pieces, [SHEET], spacing=spacing, margin=margin), pieces)


@given(
    convex_pieces(most=8),
    st.sampled_from(["length", "width"]),
    st.floats(0.0, 90.0),
    st.booleans(),
)
@settings(max_examples=25, deadline=None)
def test_fibre_stays_within_its_limits(
    pieces: list[Piece], grain: str, tolerance: float, half_turn: bool
) -> None:
    sheet = replace(SHEET, fibre=grain)
    layout = nest(pieces, [sheet], spacing=5.0, fibre=Limits(tolerance, half_turn))
    judge(layout, pieces)
    for piece in pieces:
        off = off_fibre(layout, piece)
        off = min(off, 180.0 - off) if half_turn else off
        assert off <= tolerance + 1e-6


def test_tolerance_squares_the_longest_edge_where_only_that_fits() -> None:
    turn = np.radians(4.0)
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    board = rectangle("a", 2470.0, 1200.0, fibre=X)
    aslant = replace(board, silhouette=board.silhouette @ rotation.T)
    with pytest.raises(StockError, match="larger than any sheet"):
        nest([aslant], [SHEET], spacing=15.0, fibre=Limits(3.0))
    layout = nest([aslant], [SHEET], spacing=15.0, fibre=Limits(5.0))
    judge(layout, [aslant])
    assert off_fibre(layout, aslant) == pytest.approx(4.0)


def test_piece_without_fibre_turns_by_quarters() -> None:
    tall = rectangle("tall", 1000.0, 2400.0)
    layout = nest([tall], [SHEET], spacing=15.0)
    judge(layout, [tall])
    with pytest.raises(StockError, match=r"tall \(2400 x 1000 mm\)"):
        nest([replace(tall, fibre=X)], [SHEET], spacing=15.0)
    judge(nest([replace(tall, fibre=X)], [replace(SHEET, fibre=None)], spacing=15.0), [tall])


def test_piece_longer_than_the_sheet_lies_aslant() -> None:
    lath = rectangle("lath", 2600.0, 60.0)
    judge(nest([lath], [SHEET], spacing=15.0), [lath])


def test_grain_along_the_width_turns_the_pieces() -> None:
    piece = rectangle("a", 1200.0, 2400.0, fibre=np.array([0.0, 1.0]))
    (sheet,) = nest([piece], [replace(SHEET, length=1250.0, width=2500.0, fibre="width")],
                    spacing=0.0).sheets  # fmt: skip
    assert sheet.placements[0].turn == 0.0


def test_touching_rectangles_fill_a_sheet_to_the_last_one() -> None:
    pieces = [rectangle(f"{number:02}", 300.0, 200.0, fibre=X) for number in range(16)]
    exact = replace(SHEET, length=20.0 + 4 * 300.0 + 3 * 7.0, width=20.0 + 4 * 200.0 + 3 * 7.0)
    layout = nest(pieces, [exact], spacing=7.0)
    judge(layout, pieces)
    assert len(layout.sheets) == layout.bound == 1


@pytest.mark.parametrize("method", ["fast", "thorough"])
def test_oversize_pieces_are_named_with_their_sizes(method: str) -> None:
    pieces = [rectangle("ok", 100.0, 100.0), rectangle("0.1", 2490.0, 1240.0),
              rectangle("0.2", 3000.0, 500.0)]  # fmt: skip
    with pytest.raises(StockError) as caught:
        nest(pieces, [SHEET], spacing=15.0, method=method)
    assert caught.value.addresses == ("0.1", "0.2")
    assert "0.1 (2490 x 1240 mm), 0.2 (3000 x 500 mm)" in str(caught.value)


def test_counts_are_respected_and_shortage_tells_how_much() -> None:
    pieces = [rectangle(f"{number}", 1200.0, 1200.0) for number in range(5)]
    small = replace(SHEET, name="small", length=1250.0, count=2)
    layout = nest(pieces, [replace(SHEET, count=2), small], spacing=15.0)
    judge(layout, pieces)
    names = [sheet.stock.name for sheet in layout.sheets]
    assert names.count("big") == 2
    assert names.count("small") == 1
    with pytest.raises(StockError, match="1 of 5 pieces, 1440000 mm2") as caught:
        nest(pieces, [replace(SHEET, count=2)], spacing=15.0)
    assert len(caught.value.addresses) == 1


def test_scarce_large_sheets_are_kept_for_large_pieces() -> None:
    pieces = [rectangle(f"{number}", 1000.0, 1000.0) for number in range(3)]
    pieces.append(rectangle("large", 2400.0, 1200.0))
    cheap_large = replace(SHEET, price=1.0, count=1)
    small = replace(SHEET, name="small", length=1100.0, width=1100.0, price=50.0)
    layout = nest(pieces, [cheap_large, small], spacing=15.0)
    judge(layout, pieces)
    assert layout.homes["large"][0].stock.name == "big"


def test_price_decides_between_two_sizes() -> None:
    pieces = [rectangle(f"{number}", 1200.0, 1200.0) for number in range(4)]
    half = replace(SHEET, name="half", length=1250.0, price=20.0)
    for price, name in ((39.0, "big"), (41.0, "half")):
        layout = nest(pieces, [replace(SHEET, price=price), half], spacing=15.0)
        judge(layout, pieces)
        assert {sheet.stock.name for sheet in layout.sheets} == {name}


def test_last_sheet_is_the_small_one_where_it_suffices() -> None:
    pieces = [rectangle(f"{number}", 1200.0, 1200.0) for number in range(3)]
    half = replace(SHEET, name="half", length=1250.0)
    layout = nest(pieces, [SHEET, half], spacing=15.0)
    assert sum(sheet.stock.length for sheet in layout.sheets) == 3750.0


def test_thickness_and_material_choose_the_sheets() -> None:
    pieces = [rectangle("a", 500.0, 500.0), rectangle("b", 500.0, 500.0, thickness=21.0),
              rectangle("c", 500.0, 500.0)]  # fmt: skip
    thick = replace(SHEET, name="thick", thickness=21.0)
    layout = nest(pieces, [SHEET, thick], spacing=15.0)
    judge(layout, pieces)
    assert layout.homes["b"][0].stock is thick
    assert layout.homes["a"][0] is layout.homes["c"][0]
    with pytest.raises(StockError, match="No sheet of 21 mm spruce plywood"):
        nest(pieces, [SHEET, replace(thick, material=SPRUCE)], spacing=15.0)


def test_report_tells_sheets_utilisation_bound_and_offcuts() -> None:
    layout = nest([rectangle("a", 1230.0, 1230.0)], [SHEET], spacing=20.0)
    assert layout.bound == 1
    assert str(layout) == (
        "1 pieces on 1 sheet, 48.4% used; by area alone 1; 1.55 m2 of offcuts worth keeping"
    )
    assert "sheet-01: big, 2500 x 1250 mm, 1 pieces, 48.4% used, offcuts 1240 x 1250" in (
        layout.report()
    )


def test_offcuts_reach_the_pieces_exactly() -> None:
    triangle = np.array([[0.0, 0.0], [1000.0, 0.0], [0.0, 1000.0]])
    found = offcuts([triangle], 2000.0, 1000.0, 10.0)
    assert found[0] == pytest.approx([1010.0, 0.0, 990.0, 1000.0])
    assert (found[:, 2:].min(axis=1) >= LEAST).all()
    slope = LineString(triangle[1:])
    assert box(*found[1, :2], *(found[1, :2] + found[1, 2:])).distance(slope) >= 10.0 - 1e-9


def test_offcuts_of_a_narrow_sheet_are_none() -> None:
    assert offcuts([np.array([[0.0, 0.0], [9.0, 0.0], [0.0, 9.0]])], 150.0, 900.0, 5.0).size == 0


@given(convex_pieces(most=6))
def test_distances_are_those_of_shapely(pieces: list[Piece]) -> None:
    outlines = [piece.silhouette for piece in pieces]
    pairs = np.array(list(combinations(range(len(pieces)), 2)), dtype=int).reshape(-1, 2)
    own = distances(Polygons.of(outlines), pairs[:, 0], pairs[:, 1])
    for (one, other), distance in zip(pairs, own, strict=True):
        shapely = Polygon(outlines[one]).distance(Polygon(outlines[other]))
        assert max(distance, 0.0) == pytest.approx(shapely, abs=1e-9)


@pytest.mark.parametrize(
    ("pieces", "settings_", "message"),
    [
        ([], {}, "no pieces"),
        ([rectangle("a", 9.0, 9.0)] * 2, {}, "once: a"),
        ([Piece("a", rectangle("a", 9.0, 9.0).silhouette[::-1])], {}, "counter-clockwise.*: a"),
        ([rectangle("a", 9.0, 9.0)], {"margin": -1.0}, "margin of nesting"),
        ([rectangle("a", 9.0, 9.0)], {"spacing": np.nan}, "spacing of nesting"),
        ([rectangle("a", 9.0, 9.0)], {"method": "slow"}, "fast, thorough, got 'slow'"),
    ],
)
def test_what_cannot_be_meant_is_refused(
    pieces: list[Piece], settings_: dict[str, object], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        nest(pieces, [SHEET], **{"spacing": 5.0, **settings_})  # type: ignore[arg-type]


def test_thorough_way_is_no_worse_and_tells_how_far_it_is(prototype: list[Piece]) -> None:
    pytest.importorskip("spyrrow")
    pieces = prototype[64:100]
    told: list[tuple[str, int, int | None]] = []
    with listening(lambda *step: told.append(step)):
        layout = nest(pieces, [SHEET], spacing=15.0, method="thorough", seconds=4.0)
    judge(layout, pieces)
    assert all(off_fibre(layout, piece) in (0.0, 180.0) for piece in pieces)
    assert len(layout.sheets) <= len(nest(pieces, [SHEET], spacing=15.0).sheets)
    assert told[-1] == ("nesting", 36, 36)


def test_thorough_way_without_spyrrow_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "spyrrow", None)
    with pytest.raises(MissingLibraryError, match=r"pip install 'ifs-cad\[nesting\]'"):
        nest([rectangle("a", 9.0, 9.0)], [SHEET], spacing=5.0, method="thorough")


@pytest.mark.slow
@given(
    convex_pieces(most=30, largest=600.0),
    st.sampled_from([0.0, 8.0]),
    st.sampled_from([None, "length"]),
)
@settings(max_examples=3, deadline=None)
def test_thorough_random_pieces_lie_apart(
    pieces: list[Piece], spacing: float, grain: str | None
) -> None:
    pytest.importorskip("spyrrow")
    small = replace(SHEET, length=900.0, width=800.0, fibre=grain)
    layout = nest(
        pieces, [small], spacing=spacing, fibre=Limits(4.0), method="thorough", seconds=4.0
    )
    judge(layout, pieces)
    if grain:
        assert all(min(off_fibre(layout, p), 180.0 - off_fibre(layout, p)) < 4.001 for p in pieces)


@given(st.integers(0, 2**32 - 1), st.sampled_from([1e-8, 1e-7, 1e-6, 1e-4]))
@settings(max_examples=12, deadline=None)
def test_pieces_with_edges_almost_square_to_the_sheet_never_slide_through_each_other(seed, skew):
    """A rounded contact along such an edge must not count as lying deep inside the neighbour."""
    random = np.random.default_rng(seed)
    pieces = []
    for number in range(45):
        length, width = random.uniform(150.0, 420.0, 2)
        corners = np.array([[0.0, 0.0], [length, 0.0], [length, width], [0.0, width]])
        corners += np.array([length, width]) * random.uniform(-skew, skew, (4, 2))
        pieces.append(Piece(f"{number:02}", corners, X))
    judge(nest(pieces, [SHEET], spacing=11.344, margin=10.0), pieces)
