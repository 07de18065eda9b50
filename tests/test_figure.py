"""Figures: construction steps, projection, composed maps, contraction and the attractor."""

from itertools import product

import numpy as np
import pytest
from figure_strategies import affine_maps, dimensions
from hypothesis import given
from hypothesis import strategies as st

from ifs_cad.design.attractor import chaos_game
from ifs_cad.design.curve import Curve
from ifs_cad.design.dimension import hausdorff_distance
from ifs_cad.design.figure import Figure
from ifs_cad.design.germ import Germ
from ifs_cad.design.system import System
from ifs_cad.design.transform import Scheme
from ifs_cad.errors import (
    AddressError,
    ContractionError,
    InputError,
    OutOfReachError,
    SizeError,
    WeightError,
)

HALVES = [[[0.5, 0, 0], [0, 0.5, 0]], [[0.5, 0, 0.5], [0, 0.5, 0]]]
TRIANGLE = np.array([(0.0, 0), (4, 0), (1, 3)])
# Half-way to each of three control points.
GASKET = np.eye(3) / 2 + np.eye(3)[:, :, None] / 2
# Bilinear: half-way to each of the four corners (0, 0), (0, 1), (1, 1), (1, 0) of a square.
QUARTERS = np.array([np.eye(4) / 2 + np.outer(corner, np.ones(4)) / 2 for corner in np.eye(4)])
STRETCHING = [[[1.0, 0, 0], [0, 2.0, 0]], [[0.5, 0, 0], [0, 0.5, 1]]]
# Each step may stretch by more than 2, eight of them cannot.
SHEARING = [[[0.5, 2.0, 0], [0, 0.5, 0]], [[0.5, 0.0, 1], [0, 0.5, 0]]]

germs = st.integers(1, 4).flatmap(
    lambda size: st.lists(st.tuples(*[st.floats(-5, 5)] * 2), min_size=size, max_size=size)
)
figures = dimensions.flatmap(affine_maps).map(lambda maps: Figure(maps, germ=[(0, 0), (3, 1)]))


def by_words(maps, germ, depth):
    """K_n as the union over all words, each composed on its own; independent of the package."""
    maps = np.array(maps, dtype=float)
    elements = []
    for word in product(range(len(maps)), repeat=depth):
        points = np.array(germ, dtype=float)
        for digit in reversed(word):
            points = points @ maps[digit, :, :-1].T + maps[digit, :, -1]
        elements.append(points)
    return np.array(elements)


# Construction steps


def test_first_steps_of_two_halves_by_hand():
    figure = Figure(HALVES, germ=[(0, 0), (1, 2)])
    assert figure.at_depth(0).tolist() == [[[0, 0], [1, 2]]]
    assert figure.at_depth(1).tolist() == [[[0, 0], [0.5, 1]], [[0.5, 0], [1, 1]]]
    second = figure.at_depth(2)
    assert second[:, 0].tolist() == [[0, 0], [0.25, 0], [0.5, 0], [0.75, 0]]


@given(affine_maps(2), germs, st.integers(0, 4))
def test_elements_are_the_union_over_words_in_order(maps, germ, depth):
    points = Figure(maps, germ=germ).at_depth(depth)
    assert points.shape == (len(maps) ** depth, len(germ), 2)
    assert np.abs(points - by_words(maps, germ, depth)).max() <= 1e-12


@given(figures, st.integers(0, 3))
def test_repeated_steps_of_the_operator_are_the_construction(figure, depth):
    germ = figure.germ
    for _ in range(depth):
        germ = figure.step(germ)
    whole = figure.construction(depth)
    assert np.abs(germ.points - whole.points).max() <= 1e-12
    assert [block.tolist() for block in germ.lines] == [block.tolist() for block in whole.lines]


@given(figures, st.integers(0, 3), st.data())
def test_any_part_is_found_by_its_prefix(figure, depth, data):
    word = data.draw(st.lists(st.integers(0, figure.count - 1), max_size=depth))
    addresses = figure.addresses(depth)
    text = "".join(map(str, word))
    chosen = [address.startswith(text) or depth == 0 for address in addresses]
    assert np.abs(figure.at_depth(depth, word) - figure.at_depth(depth)[chosen]).max() <= 1e-12
    below = figure.transforms(depth, text)
    assert np.abs(below.matrices - figure.transforms(depth).matrices[chosen]).max() <= 1e-12
    if depth:
        kept = [address for address, keep in zip(addresses, chosen, strict=True) if keep]
        assert list(below.addresses) == figure.addresses(depth, word) == kept


def test_one_element_is_found_by_its_word_however_long():
    figure = Figure(HALVES, germ=[(0, 0), (1, 0)])
    assert figure.at("1" * 50).tolist() == [[1 - 2.0**-50, 0], [1, 0]]
    assert figure.at("").tolist() == [[0, 0], [1, 0]]


@given(figures, st.integers(0, 3))
def test_composed_maps_place_the_germ_where_the_elements_are(figure, depth):
    placed = figure.transforms(depth)
    assert np.abs(placed.applied(figure.at_depth(0)[0]) - figure.at_depth(depth)).max() <= 1e-12
    assert len(placed) == figure.count**depth
    assert list(placed.addresses) == figure.addresses(depth)


def test_composed_maps_are_products_with_the_first_digit_outermost():
    figure = Figure([[[0, -1, 5], [1, 0, 0]], [[2, 0, 0], [0, 3, 1]]])
    first, second = figure.maps
    placed = figure.transforms(2)
    assert placed["01"].tolist() == (first @ second).tolist()
    assert placed["10"].tolist() == (second @ first).tolist()


def test_addresses_are_those_of_the_tree():
    figure = Figure(HALVES)
    assert figure.addresses(0) == ["0"]
    assert figure.addresses(2) == ["00", "01", "10", "11"]
    assert figure.addresses(3, "01") == ["010", "011"]
    assert figure.tree(3).level(3) == figure.addresses(3)


def test_homogeneous_and_short_matrices_are_the_same_maps():
    full = np.concatenate([HALVES, np.tile([[[0, 0, 1]]], (2, 1, 1))], axis=1)
    assert Figure(full).at_depth(3).tolist() == Figure(HALVES).at_depth(3).tolist()


def test_germ_in_the_plane_lies_on_the_ground_of_a_figure_in_space():
    figure = Figure([np.eye(3, 4) / 2], germ=[(2, 4)])
    assert figure.at_depth(1).tolist() == [[[1, 2, 0]]]


def test_germ_by_default_is_the_unit_segment_or_the_chord():
    assert Figure(HALVES).germ.points.tolist() == [[0, 0], [1, 0]]
    assert Figure([np.eye(3, 4)]).germ.points.tolist() == [[0, 0, 0], [1, 0, 0]]
    assert Figure(GASKET, TRIANGLE.T).at_depth(0).tolist() == [TRIANGLE[[0, 2]].tolist()]


def test_construction_repeats_lines_and_faces():
    germ = Germ([(0, 0), (1, 0), (0, 1)], lines=[(0, 1)], faces=[(0, 1, 2)])
    whole = Figure(HALVES, germ=germ).construction(2)
    assert whole.lines[0].tolist() == [[0, 1], [3, 4], [6, 7], [9, 10]]
    assert whole.faces[0].tolist() == [[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 10, 11]]


def test_flattening_map_is_welcome():
    figure = Figure([[[0, 0, 1], [0, 0, 2]], HALVES[1]], germ=[(0, 0), (1, 1)])
    assert figure.at_depth(2)[0].tolist() == [[1, 2], [1, 2]]


# Strung together


def test_polyline_keeps_joints_once():
    assert Figure(HALVES).polyline(2)[:, 0].tolist() == [0, 0.25, 0.5, 0.75, 1]


def test_polyline_jumps_where_elements_do_not_meet():
    apart = Figure([[[0.25, 0, 0], [0, 0.25, 0]], [[0.25, 0, 0.75], [0, 0.25, 0]]])
    assert apart.polyline(1)[:, 0].tolist() == [0, 0.25, 0.75, 1]


def test_polyline_of_a_point_goes_through_all_elements():
    assert Figure(HALVES, germ=[(0.5, 0)]).polyline(2)[:, 0].tolist() == [
        0.125,
        0.375,
        0.625,
        0.875,
    ]


@pytest.mark.parametrize(
    "germ",
    [
        Germ.polygon([(0, 0), (1, 0), (0, 1)]),
        Germ.polylines([[(0, 0), (1, 0)], [(0, 1), (1, 1)]]),
        Germ([(0, 0), (1, 0)]),
        Germ.polyline([(0, 0), (1, 0), (0, 1)], closed=True),
    ],
)
def test_other_germs_cannot_be_strung_together(germ):
    with pytest.raises(InputError, match="one polyline or one point"):
        Figure(HALVES, germ=germ).polyline(1)


# Curves as figures


CONTROL = [(0, 0, 0), (1, 2, 0), (3, 2, 1), (4, 0, 0)]
CURVES = {
    "smooth": Curve(CONTROL, depth=5),
    "plane": Curve([(0, 0), (1, 2), (3, 2), (4, 0)], depth=4, transformations=3),
    "rough": Curve(CONTROL, depth=4).with_roughness(0.3),
    "weights": Curve(CONTROL, depth=4, weights=[1, 2, 3, 1]),
    "equal weights": Curve(CONTROL, depth=3, weights=[2, 2, 2, 2]),
    "weighted subdivision point": Curve(CONTROL, depth=3).with_subdivision_point("s2", weight=2),
    "closed": Curve(CONTROL, depth=4, closed=True),
    "germ": Curve(CONTROL, depth=3).with_germ([(0, 0, 0), (1, 1, 1), (4, 0, 0)]),
    "spline": Curve(
        CONTROL,
        depth=4,
        scheme=Scheme.from_transformations(
            np.array(
                [
                    [[4, 1, 0, 0], [4, 6, 4, 1], [0, 1, 4, 6], [0, 0, 0, 1]],
                    [[1, 0, 0, 0], [6, 4, 1, 0], [1, 4, 6, 4], [0, 0, 1, 4]],
                ]
            )
            / 8
        ),
    ),
}


@pytest.mark.parametrize("name", CURVES)
def test_a_curve_is_a_figure_with_the_same_points_and_addresses(name):
    curve = CURVES[name]
    figure = Figure.from_curve(curve)
    points = figure.polyline(curve.depth)
    assert points.shape == curve.points.shape
    assert np.abs(points - curve.points).max() <= 1e-13
    for address in figure.addresses(curve.depth)[::7]:
        assert np.abs(figure.at(address) - curve.at(address)).max() <= 1e-13
    if len(figure.germ.points) == 2:
        assert figure.addresses(curve.depth) == curve.addresses


@pytest.mark.parametrize("name", ["plane", "rough", "smooth", "spline"])
def test_contraction_of_a_figure_is_that_of_its_curve_when_it_is_barycentric(name):
    curve = CURVES[name]
    figure = System(curve.scheme.transformations, np.ones((2, 4)))  # seen as one point: no maps
    assert not figure.acts_on_space
    assert figure.contraction.rate == pytest.approx(curve.contraction().rate, rel=1e-12)
    assert figure.contraction.length == curve.contraction().length


def test_curve_with_an_even_fold_is_no_figure():
    folded = Curve([(0, 0, 0), (1, 0, 0.2), (2, 0, 0)], depth=2).with_even_fold(2.0)
    with pytest.raises(InputError, match="no transformation"):
        Figure.from_curve(folded)


# Projection


def test_control_points_move_a_barycentric_figure():
    figure = Figure(GASKET, TRIANGLE.T, germ=np.eye(3))
    moved = Figure(GASKET, (TRIANGLE @ [[1, 2], [0, 3]] + 5).T, germ=np.eye(3))
    expected = figure.at_depth(3) @ [[1, 2], [0, 3]] + 5
    assert np.abs(moved.at_depth(3) - expected).max() <= 1e-14


def test_barycentric_maps_of_a_triangle_are_maps_of_the_plane():
    figure = Figure(GASKET, TRIANGLE.T)
    expected = [[[0.5, 0, x / 2], [0, 0.5, y / 2], [0, 0, 1]] for x, y in TRIANGLE]
    assert np.abs(figure.space_maps - expected).max() <= 1e-14
    assert figure.is_similarity
    same = Figure(expected, germ=TRIANGLE[[0, 2]])
    assert np.abs(figure.at_depth(4) - same.at_depth(4)).max() <= 1e-14


@given(affine_maps(3), st.data())
def test_barycentric_form_of_any_maps_of_space_gives_them_back(maps, data):
    corners = np.array([(0, 0, 0), (3, 0, 1), (0, 2, 0), (1, 1, 4.0)])
    view = np.vstack([corners.T, np.ones(4)])
    spatial = Figure(maps)
    figure = Figure(np.linalg.inv(view) @ spatial.maps @ view, corners.T)
    assert np.abs(figure.space_maps - spatial.maps).max() <= 1e-12
    assert (figure.space_maps[:, -1] == [0, 0, 0, 1]).all()
    assert figure.contraction_factor == pytest.approx(spatial.contraction_factor, abs=1e-12)


def test_four_corners_act_on_the_plane_when_they_are_a_parallelogram():
    square = np.array([(0, 0), (0, 1), (1, 1), (1, 0)])
    figure = Figure(QUARTERS, square.T)
    assert np.abs(figure.space_maps[2] - [[0.5, 0, 0.5], [0, 0.5, 0.5], [0, 0, 1]]).max() <= 1e-15
    thirds = Scheme.de_casteljau(4).transformations
    bezier = Figure(thirds, [(0, 1, 3, 4), (0, 2, 2, 0)])
    assert not bezier.acts_on_space
    with pytest.raises(InputError, match=r"span it \(3 that do always work\)"):
        bezier.transforms(1)


def test_plan_of_a_figure_in_space():
    maps = np.random.default_rng(1).uniform(-0.4, 0.4, (3, 3, 4))
    solid, plan = Figure(maps), Figure(maps, [[1, 0, 0, 0], [0, 1, 0, 0]])
    assert plan.ndim == 2
    assert np.abs(plan.at_depth(4) - solid.at_depth(4)[..., :2]).max() <= 1e-15
    assert not plan.acts_on_space  # what is behind a point of the plan goes elsewhere
    assert plan.contraction_factor == pytest.approx(solid.contraction_factor, rel=1e-14)


def test_perspective_divides_by_the_depth():
    maps = [0.5 * np.eye(3, 4) + np.eye(3, 4, 3)]
    picture = [[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]]  # w = z
    figure = Figure(maps, picture, germ=[(1, 3, 2)])
    assert figure.ndim == 3
    assert figure.at_depth(0).tolist() == [[[0.5, 1.5, 0.5]]]
    assert figure.at_depth(1).tolist() == [[[1.5 / 1, 1.5 / 1, 1.0]]]
    with pytest.raises(WeightError, match="falls to 0"):
        Figure(maps, picture, germ=[(1, 3, 0)]).at_depth(1)


def test_weights_leave_no_maps_of_space_and_no_contraction_factor():
    figure = Figure.from_curve(CURVES["weights"])
    assert not figure.is_similarity
    for ask in (lambda: figure.space_maps, lambda: figure.transforms(1)):
        with pytest.raises(InputError, match="without weights"):
            ask()
    with pytest.raises(InputError, match=r"Curve\.contraction\(\)"):
        _ = figure.contraction_factor


# Another germ, another place


def test_germ_of_points_in_space_takes_barycentric_rows():
    figure = Figure(GASKET, TRIANGLE.T).with_germ([(1, 1), (2, 0.5), (5, 5)])
    assert np.abs(figure.coordinates.sum(axis=1) - 1).max() <= 1e-14
    assert np.abs(figure.at_depth(0)[0] - [(1, 1), (2, 0.5), (5, 5)]).max() <= 1e-14
    germ = Germ.polygon([(1, 1), (2, 0.5), (2, 2)])
    assert figure.with_germ(germ).germ.faces[0].tolist() == [[0, 1, 2]]


def test_germ_on_weighted_control_points_is_where_it_was_put():
    figure = Figure.from_curve(CURVES["weights"]).with_germ([(1, 1, 1), (2, 0, 1)])
    assert np.abs(figure.at_depth(0)[0] - [(1, 1, 1), (2, 0, 1)]).max() <= 1e-13
    weights = figure.coordinates @ figure.projection[0]
    assert weights == pytest.approx([7 / 4] * 2, rel=1e-13)  # that of the centroid


def test_germ_off_the_plane_of_the_control_points_is_out_of_reach():
    flat = np.column_stack([TRIANGLE, np.zeros(3)])
    with pytest.raises(OutOfReachError, match=r"2 mm off the plane"):
        Figure(GASKET, flat.T).with_germ([(1, 1, 2)])


@pytest.mark.parametrize(
    "figure",
    [
        Figure(SHEARING, germ=[(0, 0), (3, 1)]),
        Figure(GASKET, TRIANGLE.T),
        Figure(np.random.default_rng(2).uniform(-0.4, 0.4, (2, 3, 4)), germ=[(0, 1, 2), (3, 4, 5)]),
        Figure.from_curve(CURVES["weights"]),
        Figure(np.full((1, 3, 4), 0.2), [[1, 0, 0, 0], [0, 1, 1, 2]]),
    ],
)
def test_transformed_figure_is_each_step_transformed(figure):
    ndim = figure.ndim
    change = np.eye(ndim, ndim + 1, 1) + np.eye(ndim, ndim + 1) * 3 - np.eye(ndim, ndim + 1, -1)
    moved = figure.transformed(change)
    expected = figure.at_depth(3) @ change[:, :-1].T + change[:, -1]
    assert np.abs(moved.at_depth(3) - expected).max() <= 1e-12
    larger = figure.scaled(1000).at_depth(3)
    assert np.abs(larger - 1000 * figure.at_depth(3)).max() <= 1e-10


# Contraction


@given(dimensions.flatmap(affine_maps))
def test_contraction_factor_bounds_every_stretch_and_is_reached(maps):
    figure = Figure(maps)
    rows = np.random.default_rng(0).normal(size=(500, maps.shape[1]))
    stretched = np.linalg.norm(rows @ maps[:, :, :-1].swapaxes(1, 2), axis=2)
    ratios = stretched / np.linalg.norm(rows, axis=1)
    assert (ratios.max(axis=1) <= figure.factors + 1e-14).all()
    best = np.linalg.svd(maps[:, :, :-1])[2][:, 0]
    reached = np.linalg.norm(np.einsum("nij,nj->ni", maps[:, :, :-1], best), axis=1)
    assert np.abs(reached - figure.factors).max() <= 1e-14
    assert figure.contraction_factor == figure.factors.max()
    assert figure.contraction.rate <= figure.contraction_factor + 1e-14


def test_maps_that_stretch_have_steps_but_no_attractor():
    figure = Figure(STRETCHING, germ=[(1, 1)])
    assert figure.at_depth(3)[0].tolist() == [[1, 8]]
    assert not figure.contraction.contracting
    assert figure.contraction.rate == 2.0
    for ask in (lambda: chaos_game(figure, 10), lambda: figure.refined(1)):
        with pytest.raises(ContractionError, match=r"by 2 per .* T_1 alone stretches by 2"):
            ask()


def test_maps_that_contract_after_some_steps_have_an_attractor():
    figure = Figure(SHEARING)
    assert figure.contraction_factor == pytest.approx(2.118, abs=1e-3)
    assert figure.contraction.contracting
    points = chaos_game(figure, 500)
    assert hausdorff_distance(points, by_words(SHEARING, [(0, 0)], 12)) <= 0.1


# Parts that are all small


@pytest.mark.parametrize("largest", [10, 1.1, 0.3, 0.05])
def test_refined_elements_are_small_and_their_parents_are_not(largest):
    maps = np.array(
        [[[0.8, 0.1, 0], [-0.1, 0.8, 0]], [[0.3, 0, 0], [0, -0.2, 1]], [[0, 0, 1], [0, 0.1, 0]]]
    )
    figure = Figure(maps, germ=[(0, 0), (0.6, 0.8)])
    placed = figure.refined(largest)
    extents = placed.factors  # the germ is 1 mm long
    assert extents.max() <= largest
    words = placed.addresses
    assert list(words) == sorted(set(words))
    if words == ("0",):
        return
    assert sum(3.0 ** -len(word) for word in words) == pytest.approx(1, abs=1e-12)
    for word in words:
        assert np.abs(placed[word] - figure.transforms(len(word), word).matrices[0]).max() <= 1e-14
        parent = figure.transforms(len(word) - 1, word[:-1]).factors[0]
        assert parent > largest


def test_refined_equal_maps_are_those_of_one_depth():
    figure = Figure(HALVES)
    placed = figure.refined(0.125)
    assert placed.addresses == tuple(figure.addresses(3))
    assert placed.matrices.tolist() == figure.transforms(3).matrices.tolist()


def test_refined_addresses_of_many_maps_are_dotted():
    maps = [[[1 / 12, 0, k / 12], [0, 1 / 12, 0]] for k in range(12)]
    assert Figure(maps).refined(0.01).addresses[-2:] == ("11.10", "11.11")


@pytest.mark.parametrize("largest", [0, -1, np.nan])
def test_refined_needs_a_size(largest):
    with pytest.raises(InputError, match="must be positive"):
        Figure(HALVES).refined(largest)


# Attractor


def test_chaos_game_and_construction_reach_the_same_set():
    figure = Figure(GASKET, TRIANGLE.T, germ=np.eye(3))
    points = chaos_game(figure, 20000)
    assert points.shape == (20000, 2)
    # Depth 8: pieces of at most 5 / 256 mm, and every corner of one is on the attractor.
    assert hausdorff_distance(points, figure.at_depth(8)) <= 5 / 128
    inside = np.linalg.solve(
        np.vstack([TRIANGLE.T, np.ones(3)]), np.vstack([points.T, np.ones(20000)])
    )
    # In no level do all three coordinates stay below one half: the middle is empty.
    for _ in range(20):
        assert (inside.max(axis=0) >= 0.5 - 1e-9).all()
        corner = inside.argmax(axis=0)
        inside = 2 * inside - np.eye(3)[corner].T


@given(dimensions.flatmap(lambda ndim: affine_maps(ndim, count=(2, 3), largest=0.6)))
def test_points_of_the_attractor_are_near_every_construction_step(maps):
    points = chaos_game(Figure(maps), 50)
    # From any germ p, K_n is within factor^n / (1 - factor) max|T_i p - p| of the attractor.
    step = np.linalg.norm(maps[:, :, -1], axis=1).max()
    for depth in (1, 3, 5):
        nodes = by_words(maps, [np.zeros(maps.shape[1])], depth)[:, 0]
        gaps = np.linalg.norm(points[:, None] - nodes, axis=2).min(axis=1)
        assert gaps.max() <= 0.6**depth / 0.4 * step + 1e-12


def test_chaos_game_repeats_itself_by_its_seed():
    figure = Figure(HALVES)
    assert chaos_game(figure, 100, seed=3).tolist() == chaos_game(figure, 100, seed=3).tolist()
    assert chaos_game(figure, 100, seed=3).tolist() != chaos_game(figure, 100, seed=4).tolist()


def test_chaos_game_spreads_evenly_by_the_determinants():
    # A square in four cells of areas 9/16, 3/16, 3/16, 1/16.
    cells = [
        (0, 0, 0.75, 0.75),
        (0.75, 0, 0.25, 0.75),
        (0, 0.75, 0.75, 0.25),
        (0.75, 0.75, 0.25, 0.25),
    ]
    maps = [[[w, 0, x], [0, h, y]] for x, y, w, h in cells]
    points = chaos_game(Figure(maps), 40000)
    counts = np.histogram2d(*points.T, bins=5, range=[(0, 1), (0, 1)])[0]
    # 1600 points in each of 25 bins, five standard deviations of 40 to either side.
    assert np.abs(counts - 1600).max() <= 200


def test_points_of_the_chaos_game_do_not_show_where_they_began():
    first = chaos_game(Figure(HALVES), 10_000)[:100]
    assert len(np.unique(first[:, 0])) == 100
    assert np.histogram(first[:, 0], bins=4, range=(0, 1))[0].min() >= 10


def test_chaos_game_takes_given_probabilities():
    points = chaos_game(Figure(HALVES), 10000, probabilities=[3, 1])
    assert (points[:, 0] < 0.5).mean() == pytest.approx(0.75, abs=0.03)
    assert chaos_game(Figure(HALVES), 10, probabilities=[1, 0]).tolist() == [[0, 0]] * 10


def test_attractor_of_a_single_map_is_its_fixed_point():
    points = chaos_game(Figure([[[0.5, 0, 1], [0, 0.25, 3]]]), 7)
    assert np.abs(points - (2, 4)).max() <= 1e-15


def test_attractor_of_maps_onto_points_is_these_points():
    points = chaos_game(Figure([[[0, 0, 1], [0, 0, 2]], [[0, 0, 3], [0, 0, 4]]]), 100)
    assert {tuple(point) for point in points.tolist()} == {(1, 2), (3, 4)}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"count": 0}, "number of points"),
        ({"count": 10, "seed": -1}, "seed"),
        ({"count": 10, "probabilities": [1]}, "2 numbers"),
        ({"count": 10, "probabilities": [1, -1]}, "from 0"),
        ({"count": 10, "probabilities": [0, 0]}, "not all 0"),
        ({"count": 10, "probabilities": [np.nan, 1]}, "numbers"),
    ],
)
def test_chaos_game_refuses_what_cannot_be_meant(options, message):
    with pytest.raises(InputError, match=message):
        chaos_game(Figure(HALVES), **options)


# Refusals


@pytest.mark.parametrize(
    "ask",
    [Figure.at_depth, Figure.transforms, Figure.addresses, Figure.construction, Figure.polyline],
)
def test_what_would_not_fit_is_refused_before_it_is_made(ask):
    figure = Figure(HALVES)
    with pytest.raises(SizeError, match=r"Depth 1000 .* about 10\^301 elements") as caught:
        ask(figure, 1000)
    greatest = caught.value.values["greatest_depth"]
    assert 20 <= greatest <= 30
    with pytest.raises(SizeError):
        ask(figure, greatest + 1)


def test_part_of_a_depth_that_would_not_fit_can_be_had():
    figure = Figure(HALVES, germ=[(0, 0), (1, 0)])
    part = figure.at_depth(40, "1" * 39)
    assert part[:, 0, 0].tolist() == [1 - 2.0**-39, 1 - 2.0**-40]
    with pytest.raises(SizeError, match=r"greatest depth that fits is 3\d"):
        figure.at_depth(60, "1" * 10)


def test_refined_and_chaos_game_refuse_what_would_not_fit():
    with pytest.raises(SizeError, match="greatest depth"):
        Figure(np.tile(HALVES, (150, 1, 1))).refined(0.01)
    with pytest.raises(SizeError, match=r"10000000000 points would take"):
        chaos_game(Figure(HALVES), 10**10)


@pytest.mark.parametrize("depth", [-1, 1001, 1.5, "2", None, True])
def test_depth_must_be_a_number_of_steps(depth):
    for ask in (Figure.at_depth, Figure.transforms, Figure.tree):
        with pytest.raises(InputError, match="iteration depth"):
            ask(Figure(HALVES), depth)


@pytest.mark.parametrize("word", ["2", "0012", (0, 5)])
def test_prefix_must_be_one_of_the_words(word):
    with pytest.raises(AddressError):
        Figure(HALVES).at_depth(3, word)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Figure(GASKET), "columns of the projection P"),
        (lambda: Figure(np.eye(2)[None]), "columns of the projection P"),
        (lambda: Figure(GASKET, TRIANGLE), "Control points are its columns"),
        (lambda: Figure(GASKET, np.ones((1, 3))), r"got \(1, 3\)"),
        (lambda: Figure(GASKET, np.ones((2, 4))), r"got \(2, 4\)"),
        (lambda: Figure(GASKET, [[0, 1, np.nan], [0, 1, 2]]), "must be finite"),
        (lambda: Figure(GASKET, "P"), "must be numbers"),
        (lambda: Figure(1.01 * GASKET, TRIANGLE.T), "columns of the transformations sum"),
        (lambda: Figure(GASKET, TRIANGLE.T, germ=[(1, 0, 0), (1, 1, 0)]), "rows of the germ sum"),
        (lambda: Figure(GASKET, TRIANGLE.T, germ=[(1, 0)]), "barycentric rows on 3 control"),
        (lambda: Figure(HALVES, germ=[(0, 0, 0)]), "points of 2 numbers each, got 3"),
        (lambda: Figure([[[np.inf, 0, 0], [0, 1, 0]]]), "not: T_1"),
        (lambda: Figure(HALVES).transformed(np.eye(3, 4)), "of 2 dimensions"),
        (lambda: Figure(HALVES).scaled(0), "flattens"),
    ],
)
def test_figure_refuses_what_cannot_be_meant(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_figure_is_frozen_and_read_only():
    figure = Figure(HALVES)
    with pytest.raises(AttributeError):
        figure.maps = None
    with pytest.raises(ValueError, match="read-only"):
        figure.maps[0, 0, 0] = 1
