"""The classic figures against closed forms: counts, lengths, areas, volumes, cells, neighbours."""

import math
from fractions import Fraction
from itertools import pairwise, product

import numpy as np
import pytest
from scipy.spatial import cKDTree

from ifs_cad.design.attractor import chaos_game
from ifs_cad.design.classics import (
    CLASSICS,
    barnsley_fern,
    cantor_dust,
    cantor_set,
    heighway_dragon,
    hilbert_curve,
    levy_curve,
    menger_sponge,
    peano_curve,
    pythagoras_tree,
    sierpinski_carpet,
    sierpinski_tetrahedron,
    sierpinski_triangle,
    takagi_curve,
    twindragon,
    von_koch_curve,
    von_koch_outline,
    von_koch_snowflake,
)
from ifs_cad.design.dimension import hausdorff_distance
from ifs_cad.design.figure import Figure
from ifs_cad.design.generator import from_generator
from ifs_cad.design.germ import Germ
from ifs_cad.errors import DegenerateSegmentError, InputError

ROUNDING = 1e-12


def length(figure, depth):
    return figure.germ.lengths(figure.at_depth(depth)).sum()


def area(figure, depth):
    return figure.germ.areas(figure.at_depth(depth)).sum()


def volume(figure, depth):
    return figure.germ.volumes(figure.at_depth(depth)).sum()


def cells(figure, depth, base):
    """Return the cells of a grid of base^depth that the elements fill, each by its low corner."""
    copies = figure.at_depth(depth) * base**depth
    low = np.rint(copies.min(axis=1)).astype(int)
    assert np.abs(copies.min(axis=1) - low).max() <= 1e-9
    assert np.abs(np.ptp(copies, axis=1) - 1).max() <= 1e-9
    return {tuple(cell) for cell in low.tolist()}


def digits(number, base, depth):
    return [number // base**place % base for place in range(depth)]


@pytest.mark.parametrize("name", CLASSICS)
def test_every_classic_is_what_its_entry_says(name):
    classic, figure = CLASSICS[name], CLASSICS[name].make()
    assert figure.name == name
    assert figure.count == classic.count
    assert figure.contraction.contracting
    assert figure.contraction_factor < 1
    assert figure.is_similarity == classic.by_similarity
    assert len(figure.at_depth(2)) == classic.count**2
    assert figure.acts_on_space


@pytest.mark.parametrize("depth", range(8))
def test_cantor_set_has_two_thirds_of_the_length_each_step(depth):
    figure = cantor_set()
    copies = figure.at_depth(depth)
    assert len(copies) == 2**depth
    assert length(figure, depth) == pytest.approx((2 / 3) ** depth, rel=ROUNDING)
    # The left ends are the numbers whose digits in base 3 are 0 and 2, in rising order.
    ends = [
        sum(Fraction(digit, 3 ** (place + 1)) for place, digit in enumerate(word))
        for word in product((0, 2), repeat=depth)
    ]
    assert np.abs(copies[:, 0, 0] - np.array(ends, dtype=float)).max() <= ROUNDING
    assert not copies[..., 1].any()


@pytest.mark.parametrize("depth", range(7))
def test_von_koch_curve_has_four_thirds_of_the_length_each_step(depth):
    figure = von_koch_curve()
    points = figure.polyline(depth)
    assert points.shape == (4**depth + 1, 2)  # in one piece
    assert length(figure, depth) == pytest.approx((4 / 3) ** depth, rel=ROUNDING)
    assert np.abs(np.linalg.norm(np.diff(points, axis=0), axis=1) * 3**depth - 1).max() <= 1e-9
    if depth:
        assert points[:, 1].max() == pytest.approx(math.sqrt(3) / 6, rel=ROUNDING)


@pytest.mark.parametrize(
    ("angle", "ratio"), [(0, 1 / 4), (60, 1 / 3), (45, 1 / (2 + math.sqrt(2)))]
)
def test_von_koch_curve_of_other_angles(angle, ratio):
    figure = von_koch_curve(angle)
    assert np.abs(figure.transforms(1).scales - ratio).max() <= 1e-15
    assert figure.polyline(2)[-1].tolist() == pytest.approx([1, 0], abs=1e-15)


@pytest.mark.parametrize("depth", range(6))
def test_outline_of_the_snowflake_has_the_area_of_its_closed_form(depth):
    ring = np.concatenate([figure.polyline(depth)[:-1] for figure in von_koch_outline()])
    assert len(ring) == 3 * 4**depth
    edges = np.roll(ring, -1, axis=0) - ring
    assert np.linalg.norm(edges, axis=1).sum() == pytest.approx(3 * (4 / 3) ** depth, rel=ROUNDING)
    inside = Germ.polygon(ring).areas(ring[None])[0]
    expected = math.sqrt(3) / 4 * (1 + 3 / 5 * (1 - (4 / 9) ** depth))
    assert inside == pytest.approx(expected, rel=ROUNDING)


@pytest.mark.parametrize("depth", range(5))
def test_snowflake_keeps_the_area_of_its_germ(depth):
    figure = von_koch_snowflake()
    assert len(figure.at_depth(depth)) == 7**depth
    assert area(figure, depth) == pytest.approx(3 * math.sqrt(3) / 2, rel=ROUNDING)


def test_middle_of_the_snowflake_reaches_the_tips_of_the_parts_around():
    middle, *around = von_koch_snowflake().at_depth(1)
    gaps = cKDTree(np.concatenate(around)).query(middle)[0]
    assert gaps.max() <= 1e-15
    assert np.linalg.norm(middle, axis=1) == pytest.approx([1 / math.sqrt(3)] * 6, rel=1e-14)


def test_snowflake_and_its_outline_are_the_same_figure():
    # The outline of a triangle of side 1, centred and turned, with its tips at distance 1.
    outline = np.vstack([figure.polyline(6) for figure in von_koch_outline()])
    centre = np.array([0.5, math.sqrt(3) / 6])
    ring = (outline - centre) @ [[0, 1], [-1, 0]] * math.sqrt(3)
    points = von_koch_snowflake().at_depth(5).reshape(-1, 2)
    # Every point of the outline is in the area; no point of the area passes its tips.
    assert cKDTree(points).query(ring)[0].max() <= 3.0**-2.5  # the scale of the largest parts
    assert np.linalg.norm(points, axis=1).max() == pytest.approx(1, abs=ROUNDING)
    assert np.linalg.norm(ring, axis=1).max() == pytest.approx(1, abs=ROUNDING)


@pytest.mark.parametrize("depth", range(8))
def test_sierpinski_triangle_has_three_quarters_of_the_area_each_step(depth):
    figure = sierpinski_triangle()
    assert len(figure.at_depth(depth)) == 3**depth
    assert area(figure, depth) == pytest.approx(math.sqrt(3) / 4 * 0.75**depth, rel=ROUNDING)


def test_sierpinski_triangle_is_pascals_odd_numbers():
    figure = sierpinski_triangle([(0, 0), (1, 0), (0, 1)])
    odd = {(k, n - k) for n in range(16) for k in range(n + 1) if math.comb(n, k) % 2}
    assert cells(figure, 4, 2) == odd


def test_sierpinski_triangle_in_space_follows_its_corners():
    corners = np.array([(1, 0, 0), (0, 1, 0), (0, 0, 1)])
    figure = sierpinski_triangle(corners)
    assert np.abs(figure.at_depth(5).sum(axis=2) - 1).max() <= 1e-15
    assert area(figure, 5) == pytest.approx(math.sqrt(3) / 2 * 0.75**5, rel=ROUNDING)


@pytest.mark.parametrize("depth", range(4))
def test_sierpinski_carpet_leaves_out_the_middle_ninth(depth):
    figure = sierpinski_carpet()
    filled = {
        (x, y)
        for x, y in product(range(3**depth), repeat=2)
        if (1, 1) not in zip(digits(x, 3, depth), digits(y, 3, depth), strict=True)
    }
    assert cells(figure, depth, 3) == filled
    assert len(filled) == 8**depth
    assert area(figure, depth) == pytest.approx((8 / 9) ** depth, rel=ROUNDING)


def segments_of_folded_paper(depth):
    """Return the unit segments of a strip folded in half, opened to right angles, turn by turn."""
    turns = []
    for _ in range(depth):
        turns = [*turns, 1, *(-turn for turn in reversed(turns))]
    place, step = 0j, 1 + 0j
    found = []
    for turn in [*turns, 0]:
        found.append({place, place + step})
        place += step
        step *= 1j * turn
    return found, place


@pytest.mark.parametrize("depth", range(1, 9))
def test_dragon_is_the_folded_strip_of_paper(depth):
    figure = heighway_dragon()
    folded, end = segments_of_folded_paper(depth)
    copies = figure.at_depth(depth) @ [1, 1j] * end  # the strip's ends on those of the chord
    rounded = np.rint(copies.real) + 1j * np.rint(copies.imag)
    assert np.abs(copies - rounded).max() <= 1e-9
    found = {frozenset(pair) for pair in rounded.tolist()}
    assert len(found) == 2**depth  # no segment twice
    mirrored = {
        frozenset(place.conjugate() * end / end.conjugate() for place in pair) for pair in folded
    }
    exact = {frozenset(complex(round(p.real), round(p.imag)) for p in pair) for pair in mirrored}
    assert found in ({frozenset(pair) for pair in folded}, exact)
    assert length(figure, depth) == pytest.approx(math.sqrt(2) ** depth, rel=ROUNDING)


@pytest.mark.parametrize("depth", range(9))
def test_levy_curve_is_in_one_piece_and_grows_by_the_root_of_two(depth):
    figure = levy_curve()
    points = figure.polyline(depth)
    assert len(points) == 2**depth + 1
    assert length(figure, depth) == pytest.approx(math.sqrt(2) ** depth, rel=ROUNDING)
    # The direction of segment k has turned by 45 degrees for each 0 of k less each 1.
    steps = np.diff(points @ [1, 1j])
    ones = np.array([bin(number).count("1") for number in range(2**depth)])
    turns = np.exp(1j * np.pi / 4 * (depth - 2 * ones))
    assert np.abs(steps * math.sqrt(2) ** depth - turns).max() <= 1e-9


@pytest.mark.parametrize(("make", "base"), [(hilbert_curve, 2), (peano_curve, 3)])
@pytest.mark.parametrize("depth", range(1, 5))
def test_space_filling_curves_visit_each_cell_once_by_unit_steps(make, base, depth):
    points = make().polyline(depth) * base**depth - 0.5
    visited = np.rint(points).astype(int)
    assert np.abs(points - visited).max() <= 1e-9
    assert {tuple(cell) for cell in visited.tolist()} == set(product(range(base**depth), repeat=2))
    assert len(visited) == base ** (2 * depth)
    assert (np.abs(np.diff(visited, axis=0)).sum(axis=1) == 1).all()
    last = base**depth - 1
    assert visited[0].tolist() == [0, 0]
    assert visited[-1].tolist() == ([last, 0] if base == 2 else [last, last])


@pytest.mark.parametrize("make", [hilbert_curve, peano_curve])
def test_parts_of_space_filling_curves_are_cells(make):
    figure = make()
    for first in range(figure.count):
        part = figure.at_depth(3, [first])[:, 0]
        whole = figure.with_germ([(0, 0), (1, 1)]).at_depth(1)[first]
        assert (part > whole.min(axis=0)).all()
        assert (part < whole.max(axis=0)).all()


def takagi(x, weight, terms=60):
    """Return the sum of weight^k s(2^k x), s the distance to the nearest whole number."""
    total = np.zeros_like(x)
    for k in range(terms):
        total += weight**k * np.abs(2.0**k * x - np.rint(2.0**k * x))
    return total


@pytest.mark.parametrize("weight", [0.5, 0.25, 0.7, -0.5, 0])
@pytest.mark.parametrize("depth", [0, 1, 2, 5, 10])
def test_takagi_curve_is_the_graph_of_its_sum(weight, depth):
    points = takagi_curve(weight).polyline(depth)
    assert points[:, 0].tolist() == [k / 2**depth for k in range(2**depth + 1)]
    assert np.abs(points[:, 1] - takagi(points[:, 0], weight)).max() <= 1e-14
    if weight == 0.25:
        assert np.abs(points[:, 1] - 2 * points[:, 0] * (1 - points[:, 0])).max() <= 1e-15


@pytest.mark.parametrize("depth", range(11))
def test_twindragon_is_made_of_different_squares_of_one_grid(depth):
    figure = twindragon()
    middles = figure.at_depth(depth).mean(axis=1) @ [1, 1j] * (1 + 1j) ** depth - (0.5 + 0.5j)
    grid = np.rint(middles.real) + 1j * np.rint(middles.imag)
    assert np.abs(middles - grid).max() <= 1e-9
    assert len(set(grid.tolist())) == 2**depth
    assert area(figure, depth) == pytest.approx(1, rel=ROUNDING)


def test_each_square_of_the_pythagoras_tree_carries_two_on_a_right_angle():
    figure = pythagoras_tree()
    corners = [figure.at_depth(depth)[:, [0, 2, 3, 1]] for depth in range(6)]  # in ring order
    for below, above in pairwise(corners):
        left, right = above.reshape(-1, 2, 4, 2).swapaxes(0, 1)
        # The bottom sides of the small squares and the top side of the large one: a triangle.
        assert np.abs(left[:, 0] - below[:, 3]).max() <= 1e-14
        assert np.abs(right[:, 1] - below[:, 2]).max() <= 1e-14
        assert np.abs(left[:, 1] - right[:, 0]).max() <= 1e-14
        legs = (left[:, 1] - left[:, 0], right[:, 1] - right[:, 0])
        assert np.abs((legs[0] * legs[1]).sum(axis=1)).max() <= 1e-14
    assert [area(figure, depth) for depth in range(6)] == pytest.approx([1] * 6, rel=ROUNDING)


def test_leaves_of_the_pythagoras_tree_tend_to_a_levy_curve():
    tree, levy = pythagoras_tree(), levy_curve()
    # The similarity that takes the fixed points of the Levy curve to those of the tree.
    ends = [np.linalg.solve(np.eye(2) - m[:2, :2], m[:2, 2]) @ [1, 1j] for m in tree.maps]
    grow = ends[1] - ends[0]
    moved = levy.transformed(
        [[grow.real, -grow.imag, ends[0].real], [grow.imag, grow.real, ends[0].imag]]
    )
    assert np.abs(moved.maps - tree.maps).max() <= 1e-15


@pytest.mark.parametrize("depth", range(3))
def test_menger_sponge_keeps_the_cells_off_the_axes(depth):
    figure = menger_sponge()
    filled = {
        cell
        for cell in product(range(3**depth), repeat=3)
        if all(
            place.count(1) < 2
            for place in zip(*(digits(number, 3, depth) for number in cell), strict=True)
        )
    }
    assert cells(figure, depth, 3) == filled
    assert len(filled) == 20**depth


@pytest.mark.parametrize("depth", range(4))
def test_menger_sponge_has_its_volume(depth):
    figure = menger_sponge()
    assert len(figure.at_depth(depth)) == 20**depth
    assert volume(figure, depth) == pytest.approx((20 / 27) ** depth, rel=ROUNDING)


@pytest.mark.parametrize("depth", range(6))
def test_sierpinski_tetrahedron_halves_its_volume_and_keeps_its_area(depth):
    figure = sierpinski_tetrahedron()
    assert len(figure.at_depth(depth)) == 4**depth
    assert volume(figure, depth) == pytest.approx(math.sqrt(2) / 12 * 0.5**depth, rel=ROUNDING)
    assert area(figure, depth) == pytest.approx(math.sqrt(3), rel=ROUNDING)


@pytest.mark.parametrize("depth", range(4))
def test_cantor_dust_in_space_and_in_the_plane(depth):
    dust, flat = cantor_dust(), cantor_dust(2)
    assert len(dust.at_depth(depth)) == 8**depth
    assert volume(dust, depth) == pytest.approx((8 / 27) ** depth, rel=ROUNDING)
    assert area(flat, depth) == pytest.approx((4 / 9) ** depth, rel=ROUNDING)
    kept = [n for n in range(3**depth) if 1 not in digits(n, 3, depth)]
    assert cells(dust, depth, 3) == set(product(kept, repeat=3))


@pytest.mark.parametrize("figure", [menger_sponge(), cantor_dust(), sierpinski_tetrahedron()])
def test_germs_of_solids_are_closed_and_turn_outwards(figure):
    corners = figure.at_depth(0)[0]
    middle = corners.mean(axis=0)
    sides = []
    for block in figure.germ.faces:
        for face in block.tolist():
            ring = corners[face]
            assert np.cross(ring[1] - ring[0], ring[2] - ring[1]) @ (ring[0] - middle) > 0
            sides += pairwise([*face, face[0]])
    assert len(set(sides)) == len(sides)
    assert {(b, a) for a, b in sides} == set(sides)


def test_fern_by_chance_is_the_fern_by_construction():
    figure = barnsley_fern()
    # Both ends of the germ are on the attractor: foot and tip are the fixed points of T_1 and T_2.
    made = figure.refined(0.1).applied(figure.germ.points).reshape(-1, 2)
    chance = chaos_game(figure, 200_000)
    extent = np.linalg.norm(np.ptp(chance, axis=0))
    # A part is at most 0.1 / germ of the whole, and has two of the made points.
    there = cKDTree(made).query(chance)[0].max()
    assert there <= 0.1 * extent / np.linalg.norm(figure.germ.points[1])
    # Back, only as near as chance has sown its points in the thinnest places.
    assert hausdorff_distance(chance, made) <= 0.25
    for points, near in ((chance, 0.05), (made, 0.005)):
        assert points.min(axis=0) == pytest.approx([-2.182, 0], abs=near)
        assert points.max(axis=0) == pytest.approx([2.656, 9.998], abs=near)


def test_fern_has_the_numbers_of_barnsleys_table():
    rows = np.concatenate(
        [barnsley_fern().maps[:, :2, :2].reshape(4, 4), barnsley_fern().maps[:, :2, 2]], axis=1
    )
    assert rows.tolist() == [  # a, b, c, d, e, f
        [0, 0, 0, 0.16, 0, 0],
        [0.85, 0.04, -0.04, 0.85, 0, 1.6],
        [0.2, -0.26, 0.23, 0.22, 0, 1.6],
        [-0.15, 0.28, 0.26, 0.24, 0, 0.44],
    ]


def test_fern_has_its_stem_its_next_leaflets_and_its_tip():
    figure = barnsley_fern()
    foot, tip = figure.germ.points
    stem, above, left, right = figure.at_depth(1)
    assert stem.tolist() == [[0, 0], [0, pytest.approx(0.16 * tip[1])]]
    assert np.abs(above[1] - tip).max() <= 1e-14
    assert left[1, 0] < 0 < right[1, 0]
    assert foot.tolist() == [0, 0]


# Figures from a generator


def test_parts_of_a_generator_stand_on_its_segments():
    corners = [(1, 1), (2, 3), (4, 2), (5, 1)]
    figure = from_generator(corners, reversed_parts=[1], mirrored_parts=[1, 2])
    ends = figure.at_depth(1)
    assert np.abs(ends[0] - [corners[0], corners[1]]).max() <= 1e-15
    assert np.abs(ends[1] - [corners[2], corners[1]]).max() <= 1e-15
    assert np.abs(ends[2] - [corners[2], corners[3]]).max() <= 1e-15
    placed = figure.transforms(1)
    assert placed.is_similarity
    assert placed.mirrored.tolist() == [False, True, True]
    sides = np.linalg.norm(np.diff(corners, axis=0), axis=1) / 4
    assert np.abs(placed.scales - sides).max() <= 1e-15


def test_generator_in_another_place_is_the_same_figure_there():
    corners = np.array([(0, 0), (0.3, 0.4), (0.7, -0.1), (1, 0)])
    options = {"reversed_parts": [0], "mirrored_parts": [0, 2]}
    turned = corners @ [[2, 1], [-1, 2]] + [5, 7]
    expected = from_generator(corners, **options).at_depth(4) @ [[2, 1], [-1, 2]] + [5, 7]
    assert np.abs(from_generator(turned, **options).at_depth(4) - expected).max() <= 1e-13


def test_mirrored_generator_is_the_figure_mirrored_every_second_step():
    one = from_generator([(0, 0), (0.5, 0.5), (1, 0)], mirrored_parts=[0, 1])
    # T_i mirrored: its steps are the Levy curve's with the signs of the turns alternating.
    points = one.polyline(2)
    assert points.tolist() == [[0, 0], [0.5, 0], [0.5, 0.5], [0.5, 0], [1, 0]]


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda: from_generator([(0, 0)]), InputError, "at least 2 points"),
        (lambda: from_generator([(0, 0, 0), (1, 0, 0)]), InputError, "in the plane"),
        (lambda: from_generator([(0, 0), (1, 1), (0, 0)]), DegenerateSegmentError, "no chord"),
        (lambda: from_generator([(0, 0), (1, 1)], reversed_parts=[1]), InputError, "from 0 to 0"),
        (lambda: von_koch_curve(90), InputError, "less than 90"),
        (lambda: von_koch_curve(-1), InputError, "from 0"),
        (lambda: von_koch_curve(np.nan), InputError, "finite"),
        (lambda: takagi_curve(1), InputError, "between -1 and 1"),
        (lambda: takagi_curve(np.nan), InputError, "finite"),
        (lambda: cantor_dust(4), InputError, "from 2 to 3"),
        (lambda: sierpinski_triangle([(0, 0), (1, 0)]), InputError, "has 3 corners"),
        (lambda: sierpinski_tetrahedron(np.eye(4)), InputError, "of 2 or 3 numbers"),
        (lambda: sierpinski_triangle([(0, 0), (1, 0), (np.nan, 1)]), InputError, "finite"),
    ],
)
def test_classics_refuse_what_cannot_be_meant(make, error, message):
    with pytest.raises(error, match=message):
        make()


def test_classics_scale_to_millimetres():
    figure = menger_sponge().scaled(600)
    assert volume(figure, 1) == pytest.approx(600**3 * 20 / 27, rel=ROUNDING)
    assert isinstance(figure, Figure)
    assert figure.name == "Menger sponge"
