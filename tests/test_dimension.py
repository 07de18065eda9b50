"""Dimensions, Hausdorff distances, and how fast the germ is forgotten."""

import math

import numpy as np
import pytest
from figure_strategies import affine_maps, dimensions, numbers_of, similarities
from hypothesis import given
from hypothesis import strategies as st

from ifs_cad.design.attractor import chaos_game
from ifs_cad.design.classics import CLASSICS, cantor_set, takagi_curve, von_koch_curve
from ifs_cad.design.curve import Curve
from ifs_cad.design.dimension import (
    box_counting_dimension,
    germ_distances,
    hausdorff_distance,
    similarity_dimension,
    step_distances,
)
from ifs_cad.design.figure import Figure
from ifs_cad.design.germ import Germ
from ifs_cad.errors import ContractionError, GeometryError, InputError

MORAN = [name for name, classic in CLASSICS.items() if classic.by_similarity]
# The sponge, nearly solid, takes millions of points.
COUNTABLE = [
    name for name, classic in CLASSICS.items() if classic.dimension and classic.dimension < 2.5
]
germs = st.integers(1, 5).flatmap(lambda size: numbers_of((size, 2), -10, 10))


def diagonal(scales, ndim=2):
    """Return similarities of given scales, without translations."""
    return [scale * np.eye(ndim, ndim + 1) for scale in scales]


def apart(a, b):
    """Return the Hausdorff distance by all pairs."""
    gaps = np.linalg.norm(np.asarray(a)[:, None] - np.asarray(b), axis=2)
    return max(gaps.min(axis=0).max(), gaps.min(axis=1).max())


# Similarity dimension


@pytest.mark.parametrize("name", MORAN)
def test_dimension_of_every_similar_classic_is_its_closed_form(name):
    classic = CLASSICS[name]
    assert similarity_dimension(classic.make()) == pytest.approx(classic.dimension, rel=1e-12)


def test_best_known_dimensions_to_the_letter():
    names = ["Cantor set", "von Koch curve", "Sierpinski triangle", "Menger sponge"]
    expected = [math.log(2, 3), math.log(4, 3), math.log(3, 2), math.log(20, 3)]
    assert [CLASSICS[name].dimension for name in names] == pytest.approx(expected, rel=1e-15)


def test_unequal_scales_solve_moran():
    # x + x^2 = 1 with x = 2^-s: the golden ratio.
    golden = (1 + math.sqrt(5)) / 2
    figure = Figure(diagonal([0.5, 0.25]))
    assert similarity_dimension(figure) == pytest.approx(math.log2(golden), rel=1e-14)


@given(dimensions.flatmap(similarities))
def test_powers_of_the_scales_add_up_to_one(drawn):
    maps, scales = drawn
    dimension = similarity_dimension(Figure(maps))
    assert (scales**dimension).sum() == pytest.approx(1, abs=1e-12)


def test_single_map_has_dimension_zero():
    assert similarity_dimension(Figure(diagonal([0.3]))) == 0.0


def test_barycentric_maps_have_the_dimension_they_have_where_they_are_seen():
    gasket = CLASSICS["Sierpinski triangle"].make()
    assert similarity_dimension(gasket) == pytest.approx(math.log2(3), rel=1e-14)
    stretched = gasket.transformed([[3, 1, 0], [0, 1, 0]])
    assert similarity_dimension(stretched) == pytest.approx(math.log2(3), rel=1e-12)


@pytest.mark.parametrize(
    ("figure", "error", "message"),
    [
        (takagi_curve(), GeometryError, "are not: T_1, T_2. Estimate"),
        (CLASSICS["Barnsley's fern"].make(), GeometryError, "T_1, T_3, T_4"),
        (Figure(diagonal([0.5, 1.0])), ContractionError, "no attractor"),
        (Figure.from_curve(Curve([(0, 0), (1, 2), (3, 2), (4, 0)])), InputError, "coordinates"),
    ],
)
def test_similarity_dimension_refuses_what_has_none(figure, error, message):
    with pytest.raises(error, match=message):
        similarity_dimension(figure)


# Box counting


@pytest.mark.parametrize("name", COUNTABLE)
def test_box_counting_finds_the_dimension_within_twice_its_error(name):
    classic, figure = CLASSICS[name], CLASSICS[name].make()
    found = box_counting_dimension(chaos_game(figure, 200_000 if figure.ndim == 3 else 50_000))
    assert abs(found.dimension - classic.dimension) <= 2 * found.error
    assert found.error <= 0.4
    assert (np.diff(found.counts) >= 0).all()


def test_box_counting_ranks_takagi_curves_by_their_roughness():
    found = [
        box_counting_dimension(takagi_curve(weight).at_depth(14)).dimension
        for weight in (0.25, 0.6, 0.7, 0.8)
    ]
    assert found == sorted(found)
    # 2 + log2(weight) from weight 1/2 on; on steep graphs points are sparse, so estimates are low.
    expected = [1.0, *(2 + math.log2(weight) for weight in (0.6, 0.7, 0.8))]
    assert found == pytest.approx(expected, abs=0.2)
    assert found[:2] == pytest.approx(expected[:2], abs=0.05)


def test_box_counting_takes_given_sizes():
    rows, columns = np.divmod(np.arange(256**2), 256)
    points = np.stack([rows, columns], axis=1) + 0.5
    found = box_counting_dimension(points, [64, 32, 16, 8])
    assert found.sizes.tolist() == [64, 32, 16, 8]
    # Cells of grids that do not start at the edge of the square reach one further.
    assert found.counts.tolist() == [25, 81, 289, 1089]
    assert found.dimension == pytest.approx(2, abs=0.2)


def test_box_counting_of_few_places_ends():
    found = box_counting_dimension(np.repeat([(0.0, 0.0), (1.0, 1.0)], 1000, axis=0))
    assert found.dimension == 0
    assert found.error == 0


@pytest.mark.parametrize(
    ("points", "sizes", "message"),
    [
        ([(1, 1)] * 5, None, "all points|All points"),
        ([(0, 0), (1, 1)], None, "too few"),
        ([(0, 0), (1, np.nan)], None, "finite"),
        ([1, 2], None, "shape"),
        (np.empty((0, 2)), None, "shape"),
        ([(0, 0), (1, 1)], [0.1, 0.2], "three or more"),
        ([(0, 0), (1, 1)], [0.1, 0.2, 0.2], "three or more"),
        ([(0, 0), (1, 1)], [0.1, 0.2, -1], "three or more"),
        ([(0, 0), (1, 1)], [0.1, 0.2, np.nan], "three or more"),
        ([(0, 0), (1, 1)], [0.1, 0.2, 1e-7], "of the extent"),
    ],
)
def test_box_counting_refuses_what_cannot_be_counted(points, sizes, message):
    with pytest.raises(InputError, match=message):
        box_counting_dimension(points, sizes)


# Hausdorff distance


def test_hausdorff_distance_by_hand():
    assert hausdorff_distance([(0, 0)], [(3, 4)]) == 5
    assert hausdorff_distance([(0, 0), (10, 0)], [(0, 0)]) == 10  # in one direction it is 0
    assert hausdorff_distance([(0, 0)], [(0, 0), (10, 0)]) == 10
    assert hausdorff_distance([[(0, 0, 0)], [(1, 0, 0)]], [(1, 0, 2)]) == math.sqrt(5)


@given(germs, germs)
def test_hausdorff_distance_is_that_of_all_pairs(a, b):
    assert hausdorff_distance(a, b) == pytest.approx(apart(a, b), rel=1e-14)
    assert hausdorff_distance(a, b) == hausdorff_distance(b, a)
    assert hausdorff_distance(a, a[::-1]) == 0


def test_hausdorff_distance_of_different_spaces_is_refused():
    with pytest.raises(InputError, match="got 2 and 3"):
        hausdorff_distance([(0, 0)], [(0, 0, 0)])
    with pytest.raises(InputError, match="finite"):
        hausdorff_distance([(0, 0)], [(0, np.inf)])


# The germ is forgotten


@given(affine_maps(2, count=(1, 3)), germs, germs)
def test_figures_of_two_germs_come_closer_by_the_contraction_factor(maps, a, b):
    figure = Figure(maps)
    found = germ_distances(figure, a, b, range(5))
    first = apart(a, b)
    factor = np.linalg.svd(maps[:, :, :-1], compute_uv=False).max()
    assert found.factor == pytest.approx(factor, rel=1e-12)
    for depth, distance, bound in zip(found.depths, found.distances, found.bounds, strict=True):
        assert bound == pytest.approx(first * factor**depth, rel=1e-12)
        assert distance <= bound + 1e-12
    steps = found.distances[1:] <= factor * found.distances[:-1] + 1e-12
    assert steps.all()


@given(similarities(2), numbers_of((2,), -5, 5), st.floats(0.1, 3))
def test_figures_of_a_single_point_and_of_the_attractor_come_closer_exactly(drawn, place, shift):
    # With one map every K_n is one point: the distance falls by the factor, no more and no less.
    maps, scales = drawn
    found = germ_distances(Figure(maps[:1]), [place], [place + np.array([shift, 0])], range(6))
    assert np.abs(found.distances / (shift * scales[0] ** np.arange(6)) - 1).max() <= 1e-9


def test_germs_one_above_the_other_keep_the_factor_exactly():
    # Every part of the Cantor set is level, so the heights of the germs fall by 1/3 each step.
    germ = cantor_set().germ.points
    found = germ_distances(cantor_set(), germ, germ + np.array([0, 0.7]), range(9))
    assert np.abs(found.distances / (0.7 / 3.0 ** np.arange(9)) - 1).max() <= 1e-9
    assert np.abs(found.distances / found.bounds - 1).max() <= 1e-9


@pytest.mark.parametrize("name", MORAN)
def test_germs_closer_than_the_parts_are_apart_keep_the_factor_exactly(name):
    # One germ the fixed point of T_1, the other so close that no other part is nearer to any.
    figure = CLASSICS[name].make()
    maps = figure.space_maps
    first = np.linalg.solve(np.eye(figure.ndim) - maps[0, :-1, :-1], maps[0, :-1, -1])
    other = first + 1e-6 / math.sqrt(figure.ndim)
    found = germ_distances(figure, [first], [other], range(4))
    assert np.abs(found.distances / found.bounds - 1).max() <= 1e-6


@pytest.mark.parametrize("name", ["von Koch curve", "Sierpinski triangle", "Heighway dragon"])
def test_a_fish_makes_the_same_figure_as_the_germ_of_the_book(name):
    figure = CLASSICS[name].make()
    fish = Germ.polygon([(0, 0.3), (0.25, 0.5), (0.8, 0.3), (1, 0.5), (1, 0.1), (0.25, 0.1)])
    usual = Germ(figure.at_depth(0)[0], figure.germ.lines, figure.germ.faces)
    found = germ_distances(figure, fish.sampled(0.04), usual.sampled(0.04), range(7))
    assert (found.distances <= found.bounds * (1 + 1e-9)).all()
    assert found.distances[6] <= 0.6 * found.factor**6


@pytest.mark.parametrize("name", CLASSICS)
def test_consecutive_steps_come_closer_by_the_contraction_factor(name):
    figure = CLASSICS[name].make()
    found = step_distances(figure, range(4 if figure.count < 10 else 3))
    by_hand = [
        hausdorff_distance(figure.at_depth(depth), figure.at_depth(depth + 1))
        for depth in found.depths
    ]
    assert np.abs(found.distances - by_hand).max() <= 1e-12
    assert (found.distances <= found.bounds * (1 + 1e-9)).all()
    assert (found.distances[1:] <= found.factor * found.distances[:-1] * (1 + 1e-9)).all()


def test_consecutive_steps_of_the_von_koch_curve_fall_by_a_third_exactly():
    # The tip of each new spike is sqrt(3)/6 of its segment away, nearest to the segment's ends.
    found = step_distances(von_koch_curve(), range(7))
    first = math.hypot(0.5, math.sqrt(3) / 6)
    assert found.distances == pytest.approx(first / 3.0 ** np.arange(7), rel=1e-9)


def test_bound_holds_on_more_control_points_than_the_plane_needs():
    curve = Curve([(0, 0, 0), (1, 2, 0), (3, 2, 0), (4, 0, 0)])
    figure = Figure.from_curve(curve)
    assert not figure.acts_on_space
    found = germ_distances(figure, [(0, 0, 0)], [(2, 1, 0), (4, 0, 0)], range(10))
    assert (found.distances <= found.bounds).all()
    assert found.distances[9] < 0.05 * found.distances[0]


def test_distances_need_depths_and_no_weights():
    with pytest.raises(InputError, match="A depth must be"):
        germ_distances(cantor_set(), [(0, 0)], [(1, 0)], [-1])
    weighted = Figure.from_curve(Curve([(0, 0), (1, 2), (4, 0)], weights=[1, 2, 1]))
    with pytest.raises(InputError, match="weights"):
        germ_distances(weighted, [(0, 0, 0)], [(1, 0, 0)], [0])
