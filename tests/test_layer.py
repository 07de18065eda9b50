"""Layers of a vault: reading curves, cycling, staggering, directions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import accepted, numbers

import ifs_cad as ifs
from ifs_cad.elements.layer import NEVER, read_layers
from ifs_cad.errors import DegenerateSegmentError, InputError, PlanarityError

ARCH = ifs.Curve([(0, 0, 0), (0, 0, 4000), (6000, 0, 4000), (6000, 0, 0)], depth=3)
HALF_RING = [(1000, 0, 0), (0, 0, 1000), (-1000, 0, 0)]
SQUARE = [(0, 0, 0), (900, 0, 0), (900, 0, 900), (0, 0, 900), (0, 0, 0)]


def points_of_layer(layers, number):
    """Points of one layer in space, its end or its start again at the end."""
    own = np.flatnonzero(layers.layer == number)
    return layers.spatial(layers.points[np.append(layers.starts[own], layers.ends[own[-1]])])


def test_points_in_the_plane_are_those_of_the_curve():
    layers = read_layers(ARCH, 2, False, None)
    for number in (0, 1):
        np.testing.assert_allclose(points_of_layer(layers, number), ARCH.points, atol=1e-9)
    np.testing.assert_allclose(layers.axes @ layers.axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(layers.axes) == pytest.approx(1.0)
    np.testing.assert_allclose(layers.across, [0, 1, 0], atol=1e-12)
    moved = layers.spatial(layers.points[:2], np.array([10.0, 20.0]))
    np.testing.assert_allclose(
        moved, ARCH.points[:2] + np.array([[0, 10, 0], [0, 20, 0]]), atol=1e-9
    )


def test_neighbours_follow_each_other_within_a_layer_only():
    layers = read_layers([SQUARE[:4], SQUARE[:3]], None, False, None)
    assert layers.layer.tolist() == [0, 0, 0, 1, 1]
    assert layers.before.tolist() == [NEVER, 0, 1, NEVER, 3]
    assert layers.after.tolist() == [1, 2, NEVER, 4, NEVER]
    assert layers.names(np.array([1, 4])) == ["L00-1", "L01-1"]
    assert not layers.is_ring.any()


def test_single_segments_have_no_neighbours():
    layers = read_layers([(0, 0, 0), (100, 0, 0)], 3, False, (0, 1, 0))
    assert (layers.before == NEVER).all()
    assert (layers.after == NEVER).all()
    np.testing.assert_array_equal(layers.turns, 0.0)
    np.testing.assert_allclose(layers.lengths, 100.0)


@pytest.mark.parametrize("make", [np.array, list, tuple, lambda p: np.array([p]), lambda p: [p]])
def test_points_may_come_in_any_container(make):
    layers = read_layers(make(SQUARE), 2, False, None)
    assert len(layers.layer) == 8
    np.testing.assert_allclose(points_of_layer(layers, 1), SQUARE, atol=1e-9)


def test_points_in_the_plane_z_zero_need_two_numbers():
    layers = read_layers([(0, 0), (500, 300), (1000, 0)], 1, False, None)
    np.testing.assert_allclose(layers.across, [0, 0, 1])


@pytest.mark.parametrize(
    "ring", [SQUARE, ifs.Curve(SQUARE[:1] + SQUARE[1:4] + SQUARE[:1], depth=2)]
)
def test_closed_curves_are_rings(ring):
    layers = read_layers(ring, 2, False, None)
    assert layers.is_ring.all()
    assert layers.before.tolist() == [3, 0, 1, 2, 7, 4, 5, 6]
    assert layers.after.tolist() == [1, 2, 3, 0, 5, 6, 7, 4]
    turned = layers.turns.sum(axis=1).reshape(2, -1).sum(axis=1)
    np.testing.assert_allclose(turned, 4 * np.pi)  # each joint counts in both of its planks


def test_curve_closed_in_position_but_not_in_weight_is_a_ring():
    curve = ifs.Curve([*SQUARE[:4], (0, 0, 0)], weights=[1, 1, 1, 1, 2], depth=3)
    assert not curve.is_closed
    assert read_layers(curve, 1, False, None).is_ring.all()
    staggered = read_layers(curve, 2, True, None)
    assert staggered.is_ring.all()
    assert (staggered.layer == 1).sum() == 8


@pytest.mark.parametrize("count", [2, 4, 5, 7])
def test_curves_are_gone_through_again_and_again(count):
    curves = [ARCH, np.array(ARCH.points) * [1, 1, 1.1]]
    layers = read_layers(curves, count, False, None)
    assert layers.count == count
    for number in range(count):
        expected = ARCH.points if number % 2 == 0 else curves[1]
        np.testing.assert_allclose(points_of_layer(layers, number), expected, atol=1e-9)


def test_odd_number_of_curves_is_met_staggered_and_not():
    curves = [ARCH.with_depth(depth) for depth in (1, 2, 3)]
    layers = read_layers(curves, 12, True, None)
    planks = np.bincount(layers.layer)
    assert planks.tolist() == [2, 5, 8, 3, 4, 9, 2, 5, 8, 3, 4, 9]


@pytest.mark.parametrize("maps", [2, 3])
def test_staggered_layer_splits_its_end_segments_only(maps):
    curve = ifs.Curve(ARCH.projection[1:].T, depth=2, transformations=maps)
    layers = read_layers(curve, 2, True, None)
    finer = curve.with_depth(3)
    chosen = [0, *range(maps // 2, finer.segments, maps), finer.segments]
    np.testing.assert_allclose(points_of_layer(layers, 1), finer.points[chosen], atol=1e-9)
    names = layers.names(np.flatnonzero(layers.layer == 1))
    assert names == [f"L01-{finer.addresses[k]}" for k in chosen[:-1]]
    assert len(set(names)) == len(names) == maps**2 + 1


@given(numbers((4, 2), -3000, 3000), st.integers(0, 4), st.integers(2, 3))
def test_staggered_joints_never_lie_on_joints(points, depth, maps):
    curve = accepted(ifs.Curve, points, depth=depth, transformations=maps)
    layers = accepted(read_layers, curve, 2, True, None)
    joined = layers.before != NEVER
    joints = layers.points[layers.starts[joined]]
    one, other = (joints[layers.layer[joined] == k] for k in (0, 1))
    finer = curve.with_depth(depth + 1).points
    apart = np.linalg.norm(finer[:, None] - finer, axis=2) + np.diag(np.full(len(finer), np.inf))
    if apart.min() > 1.0 and len(one):  # a curve that does not cross itself
        assert np.linalg.norm(one[:, None] - other, axis=2).min() > 1.0 - 1e-9


def test_layers_count_in_two_digits_or_more():
    assert read_layers(HALF_RING, 3, False, None).names(np.array([5])) == ["L02-1"]
    assert read_layers(HALF_RING, 101, False, None).names(np.array([0])) == ["L000-0"]


@pytest.mark.parametrize("turned", [1, -1])
def test_outside_is_away_from_the_chord_whichever_way_the_curve_is_drawn(turned):
    layers = read_layers(HALF_RING[::turned], 1, False, None)
    right = np.stack([layers.directions[:, 1], -layers.directions[:, 0]], axis=1)
    outward = layers.spatial(layers.outside * right) - layers.origin
    np.testing.assert_allclose(
        outward[::turned], [[0.5**0.5, 0, 0.5**0.5], [-(0.5**0.5), 0, 0.5**0.5]], atol=1e-12
    )
    np.testing.assert_allclose(layers.turns.sum(axis=0), np.pi / 2)


def test_scaled_layers_scale_all_points():
    layers = read_layers(ARCH.points + np.array([7, 8, 9]), 2, False, None)
    np.testing.assert_allclose(
        points_of_layer(layers.scaled(0.1), 1), 0.1 * points_of_layer(layers, 1), atol=1e-12
    )


def test_direction_across_comes_from_the_most_bent_curve():
    nearly = [(0, 0, 0), (1000, 8e-7, 0), (2000, 0, 0)]
    layers = read_layers([nearly[::-1], HALF_RING], None, False, None)
    np.testing.assert_allclose(np.abs(layers.across), [0, 1, 0], atol=1e-12)


def test_direction_across_may_be_given():
    layers = read_layers(ARCH, 2, False, (0, -3, 0))
    np.testing.assert_allclose(layers.across, [0, -1, 0])


@pytest.mark.parametrize(
    ("curves", "options", "error", "said"),
    [
        ([], {}, InputError, "at least one curve"),
        ([ARCH, ARCH, ARCH], {"count": 2}, InputError, "3 curves cannot make 2 layers"),
        (ARCH, {"count": 0}, InputError, "whole number of at least 1"),
        (ARCH, {"count": -4}, InputError, "whole number of at least 1"),
        (ARCH, {"count": 2.5}, InputError, "whole number"),
        (ARCH, {"count": float("nan")}, InputError, "whole number"),
        (ARCH, {"across": (0, 0, 0)}, InputError, "zero vector"),
        (ARCH, {"across": (0, np.nan, 0)}, InputError, "finite"),
        (ARCH, {"across": (0, 1, 1e-3)}, PlanarityError, "layer 0 leaves the plane"),
        ([[(0, 0, 0), (1, 1, np.nan)]], {}, InputError, r"layer 0.*finite"),
        ([[(0, 0, 0)]], {}, InputError, "at least 2 points, got 1"),
        (HALF_RING, {"stagger": True, "count": 2}, InputError, "Layer 1 is an array of points"),
        (
            [(0, 0, 0), (9, 0, 0), (9, 0, 0)],
            {},
            DegenerateSegmentError,
            "Points 1 and 2 of layer 0",
        ),
        ([(0, 0, 0), (9, 0, 0), (18, 0, 0)], {}, InputError, "straight.*Give across"),
        ([*HALF_RING, (0, 5, 5)], {}, PlanarityError, r"layer 0.*planar\s*curve"),
    ],
)
def test_curves_that_make_no_layers_are_refused(curves, options, error, said):
    given_ = {"count": None, "stagger": False, "across": None} | options
    with pytest.raises(error, match=said):
        read_layers(curves, **given_)


def test_planes_that_are_not_parallel_are_refused():
    leaning = np.array(HALF_RING) + np.array([(0, 0, 0), (0, 10, 0), (0, 0, 0)])
    with pytest.raises(PlanarityError, match="layer 1 leaves") as caught:
        read_layers([HALF_RING, leaning], None, False, (0, 1, 0))
    assert caught.value.values["layer"] == 1
    assert caught.value.values["deviation"] == pytest.approx(10)


def test_curves_of_their_own_germ_or_fold_are_not_staggered():
    for curve in (
        ARCH.with_even_fold(20.0),
        ARCH.with_germ([(0, 0, 0), (3000, 0, 900), (6000, 0, 0)]),
    ):
        with pytest.raises(InputError, match=r"layer 1 has a germ.*its own curve"):
            read_layers(curve, 2, True, None)


@pytest.mark.parametrize("points", [HALF_RING, SQUARE])
def test_layers_drawn_in_opposite_directions_are_refused(points):
    with pytest.raises(InputError, match=r"layer 2 runs against that of layer 1"):
        read_layers([points, points, points[::-1]], None, False, None)


def test_layers_may_change_their_bulge_or_their_chord_from_one_to_the_next():
    bulging = [(0, 0, 0), (500, 0, 100), (1000, 0, 0)]
    hollow = [(0, 0, 0), (500, 0, -90), (1000, 0, 0)]
    assert read_layers([bulging, hollow], None, False, None).count == 2
    horseshoe = np.array([(10, 0, 0), (900, 0, 900), (-900, 0, 900), (-10, 0, 0)])
    crossed = horseshoe * [(-1, 1, 1), (1, 1, 1), (1, 1, 1), (-1, 1, 1)]
    assert read_layers([horseshoe, crossed], None, False, None).count == 2
