"""Discrete curves: control and subdivision points, weights, germs, folds, addresses."""

from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ifs_cad.design.curve import Curve
from ifs_cad.design.transform import Scheme
from ifs_cad.errors import (
    AddressError,
    ContinuityError,
    DegenerateSegmentError,
    FoldError,
    InputError,
    OutOfReachError,
    SizeError,
    WeightError,
)

ARCH = [(0, 0, 0), (0, 0, 2000), (4500, 0, 2000), (4500, 0, 0)]
PLANE = [(0, 0), (1, 2), (3, 0)]
WEIGHTS = st.floats(0.2, 5)
SHARES = st.floats(-0.5, 1.5)


@st.composite
def control_points(draw, least=3, most=6):
    """Points in space that advance along x, so that no curve through them stands still."""
    count = draw(st.integers(least, most))
    jitter = st.tuples(*[st.floats(-400, 400).map(lambda value: round(value, 3))] * 3)
    offsets = draw(st.lists(jitter, min_size=count, max_size=count))
    return np.array(offsets) + np.arange(count)[:, None] * [1000.0, 0, 0]


@st.composite
def curves(draw, weighted=True):
    """Curves of every kind but folded ones, as the designer would make them."""
    points = draw(control_points())
    count = len(points)
    weights = draw(st.lists(WEIGHTS, min_size=count, max_size=count)) if weighted else None
    curve = Curve(
        points,
        depth=draw(st.integers(0, 3)),
        weights=weights,
        transformations=draw(st.integers(2, 4)),
    )
    if draw(st.booleans()):
        curve = curve.with_roughness(draw(st.floats(-0.3, 0.1)))
    if draw(st.booleans()):
        share = draw(st.floats(0.2, 0.8))
        rows = np.zeros((3, count))
        rows[0, 0] = rows[2, -1] = 1.0
        rows[1, [0, 1, -1]] = [(1 - share) / 2, 0.5, share / 2]
        curve = Curve(points, depth=curve.depth, weights=weights, scheme=curve.scheme, germ=rows)
    return curve


def sizes_of(points):
    return np.linalg.norm(np.diff(points, axis=0), axis=1)


# Construction


def test_points_of_a_smooth_curve_lie_on_the_parabola():
    curve = Curve([(0, 0), (1, 2), (2, 0)], depth=5)
    t = np.arange(33) / 32
    expected = np.column_stack([2 * t, 4 * t * (1 - t), np.zeros(33)])
    assert np.abs(curve.points - expected).max() <= 1e-15
    assert curve.segments == 32
    assert curve.homogeneous.shape == (33, 4)


def test_depth_zero_is_the_chord():
    assert Curve(ARCH, depth=0).points.tolist() == [[0, 0, 0], [4500, 0, 0]]


@given(curves())
def test_curve_starts_and_ends_at_its_control_points_exactly(curve):
    assert curve.points[0].tolist() == pytest.approx(curve.control_points[0].tolist(), rel=1e-15)
    assert curve.points[-1].tolist() == pytest.approx(curve.control_points[-1].tolist(), rel=1e-15)
    assert len(curve.points) == curve.segments + 1


@given(curves(), st.lists(st.floats(-2, 2), min_size=12, max_size=12))
def test_affine_maps_of_control_points_map_the_curve(curve, entries):
    linear = np.reshape(entries[:9], (3, 3)) + 5 * np.eye(3)
    shift = 100 * np.array(entries[9:])
    moved = Curve(
        curve.control_points @ linear + shift,
        depth=curve.depth,
        weights=curve.weights,
        scheme=curve.scheme,
        germ=curve.germ,
    )
    assert np.abs(moved.points - (curve.points @ linear + shift)).max() <= 1e-8


@given(curves(), WEIGHTS)
def test_scaling_all_weights_changes_nothing(curve, factor):
    scaled = curve.with_weights(curve.weights * factor)
    assert np.abs(scaled.points - curve.points).max() <= 1e-9


def test_planar_points_get_z_zero():
    assert Curve(PLANE).control_points.tolist() == [[0, 0, 0], [1, 2, 0], [3, 0, 0]]


def test_arrays_are_read_only_copies_and_the_curve_is_frozen():
    given_points = np.array(ARCH, dtype=float)
    curve = Curve(given_points)
    given_points[0] = 99
    assert curve.control_points[0].tolist() == [0, 0, 0]
    for array in (curve.control_points, curve.weights, curve.points, curve.homogeneous):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
    with pytest.raises(FrozenInstanceError):
        curve.depth = 5


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([(0, 0), (1, np.nan)], r"finite; rows \[1\]"),
        ([(0, 0), (np.inf, 1)], r"finite; rows \[1\]"),
        ([(0, 0)], "at least 2"),
        ([], "2 or 3 numbers"),
        ([1, 2, 3], "2 or 3 numbers"),
        ([(0, 0, 0, 0), (1, 1, 1, 1)], "2 or 3 numbers"),
        ([(0, 0), (1, 1, 1)], "2 or 3 numbers"),
        ("points", "2 or 3 numbers"),
        ([(1, 1), (1, 1), (1, 1)], "All 3 control points"),
    ],
)
def test_bad_control_points_are_an_input_error(points, message):
    with pytest.raises(InputError, match=message):
        Curve(points)


@pytest.mark.parametrize("weight", [0, -1, np.nan, np.inf])
def test_weights_that_are_not_positive_are_an_error(weight):
    with pytest.raises(WeightError, match="positive and finite"):
        Curve(PLANE, weights=[1, weight, 1])


def test_wrong_number_of_weights_is_an_error():
    with pytest.raises(InputError, match="3 numbers"):
        Curve(PLANE, weights=[1, 1])
    with pytest.raises(InputError, match="3 numbers"):
        Curve(PLANE, weights="abc")


@pytest.mark.parametrize("depth", [-1, 2.0, True, None, 1001])
def test_depth_must_be_a_whole_number(depth):
    with pytest.raises(InputError, match="depth"):
        Curve(PLANE, depth=depth)


def test_scheme_for_another_number_of_points_is_an_error():
    with pytest.raises(InputError, match="4 control points, the curve has 3"):
        Curve(PLANE, scheme=Scheme.de_casteljau(4))


def test_depth_that_does_not_fit_is_refused_and_the_greatest_named():
    with pytest.raises(SizeError, match=r"1,099,511,627,776 points.*131,072 GiB.*25") as caught:
        _ = Curve([(0, 0), (1, 1)], depth=40).points
    assert caught.value.values["greatest_depth"] == 25
    with pytest.raises(SizeError, match=r"10\^"):
        _ = Curve(PLANE, depth=1000).homogeneous
    with pytest.raises(SizeError):
        _ = Curve(PLANE, depth=1000).addresses


def test_coincident_points_are_named_by_their_segments():
    curve = Curve(PLANE, depth=2).with_subdivision_point("s3", (0, 0))
    with pytest.raises(DegenerateSegmentError, match="no length") as caught:
        _ = curve.points
    assert "00" in caught.value.addresses


def test_weights_that_vanish_along_the_curve_are_named():
    curve = Curve(PLANE, depth=1)
    column = curve.scheme.columns[2] * -1
    torn = Curve(PLANE, depth=1, scheme=curve.scheme.with_column("s3", column))
    with pytest.raises(WeightError, match="falls to -1") as caught:
        _ = torn.points
    assert caught.value.addresses == ("0", "1")


# Closed curves


def test_closed_curve_repeats_the_first_point_and_its_weight():
    curve = Curve([(0, 0), (4, 0), (4, 3)], weights=[2, 1, 1], closed=True, depth=3)
    assert curve.is_closed
    assert curve.scheme.size == 4
    assert curve.homogeneous[-1].tolist() == curve.homogeneous[0].tolist() == [2, 0, 0, 0]
    moved = curve.with_control_point(0, (1, 1), weight=3)
    assert moved.is_closed
    assert moved.homogeneous[-1].tolist() == [3, 3, 3, 0]


def test_closed_in_position_but_not_in_weight_is_open():
    ring = [(0, 0), (4, 0), (4, 3), (0, 0)]
    assert Curve(ring).is_closed
    assert not Curve(ring, weights=[1, 1, 1, 2]).is_closed
    assert not Curve(ARCH).is_closed


def test_closed_with_the_first_point_given_twice_is_an_error():
    with pytest.raises(InputError, match="leave out the last"):
        Curve([(0, 0), (4, 0), (4, 3), (0, 0)], closed=True)


def test_closed_curve_of_depth_zero_has_no_length():
    with pytest.raises(DegenerateSegmentError):
        _ = Curve([(0, 0), (4, 0), (4, 3)], closed=True, depth=0).points


# Elements


@given(curves(), st.data())
def test_at_gives_the_slice_of_the_whole_curve(curve, data):
    steps, tail = curve.word_structure
    radices = steps + tail
    word = [data.draw(st.integers(0, radix - 1)) for radix in radices]
    word = word[: data.draw(st.integers(0, len(word)))]
    count, first = curve.segments, 0
    for digit, radix in zip(word, radices, strict=False):
        count //= radix
        first += digit * count
    part = slice(first, first + count + 1)
    assert np.abs(curve.homogeneous_at(word) - curve.homogeneous[part]).max() <= 1e-10
    assert np.abs(curve.at(word) - curve.points[part]).max() <= 1e-10


def test_at_reads_addresses_of_every_segment_also_dotted_and_folded():
    base = Curve([(0, 0), (10, 3), (20, 0)], depth=2, transformations=12)
    germ = base.with_germ([(0, 0), (8, 1), (20, 0)])
    for curve in (base, base.with_even_fold(2, (0, 1, 0)), germ.with_even_fold(2, (0, 1, 0))):
        assert len(curve.addresses) == curve.segments
        for number in (0, 1, 11, curve.segments - 1):
            ends = curve.at(curve.addresses[number])
            assert np.abs(ends - curve.points[number : number + 2]).max() <= 1e-12
    assert base.addresses[-1] == "11.11"


def test_at_reaches_what_would_never_fit():
    curve = Curve([(0, 0), (1, 2), (2, 0)], depth=40)
    word = "01" * 20
    t = int(word, 2) / 2**40 + np.array([0, 2.0**-40])
    expected = np.column_stack([2 * t, 4 * t * (1 - t), [0, 0]])
    assert np.abs(curve.at(word) - expected).max() <= 1e-15
    assert curve.segments == 2**40


def test_at_only_segment_of_depth_zero_is_called_zero():
    curve = Curve(ARCH, depth=0)
    assert curve.addresses == ["0"]
    assert curve.at("0").tolist() == curve.points.tolist()


def test_at_wrong_words_are_address_errors():
    curve = Curve(PLANE, depth=2)
    for word in ("02", "000", "x", (0, -1)):
        with pytest.raises(AddressError):
            curve.at(word)


def test_word_structure_of_germs_and_folds():
    curve = Curve([(0, 0), (10, 3), (20, 0)], depth=2, transformations=3)
    germ = curve.with_germ([(0, 0), (8, 1), (12, 1), (20, 0)])
    assert curve.word_structure == ((3, 3), ())
    assert germ.word_structure == ((3, 3), (3,))
    assert curve.with_even_fold(2, (0, 1, 0)).word_structure == ((3, 3, 2), ())
    assert germ.with_even_fold(2, (0, 1, 0)).word_structure == ((3, 3), (3, 2))


# Control and subdivision points


def test_with_control_point_moves_one_and_keeps_columns():
    curve = Curve(ARCH).with_roughness(0.2)
    moved = curve.with_control_point(-1, (5000, 0, 100), weight=2)
    assert moved.control_points[3].tolist() == [5000, 0, 100]
    assert moved.control_points[:3].tolist() == curve.control_points[:3].tolist()
    assert moved.weights.tolist() == [1, 1, 1, 2]
    assert moved.scheme is curve.scheme
    with pytest.raises(InputError, match="0 to 3"):
        curve.with_control_point(4, (0, 0, 0))


def test_subdivision_points_are_projections_of_columns():
    points = Curve([(0, 0), (1, 2), (3, 0)]).subdivision_points
    assert {name: point.tolist() for name, point in points.items()} == {
        "s2": [0.5, 1, 0],
        "s3": [1.25, 1, 0],
        "s5": [2, 1, 0],
    }


def test_subdivision_points_of_weighted_curve_carry_weights():
    curve = Curve([(0, 0), (1, 2), (3, 0)], weights=[1, 3, 1])
    assert curve.subdivision_weights == {"s2": 2, "s3": 2, "s5": 2}
    assert curve.subdivision_points["s2"].tolist() == [0.75, 1.5, 0]


@given(control_points(), st.data())
def test_moved_subdivision_point_is_where_it_was_put(points, data):
    count = len(points)
    weights = data.draw(st.lists(WEIGHTS, min_size=count, max_size=count))
    curve = Curve(points, weights=weights)
    name = data.draw(st.sampled_from(curve.scheme.free_names))
    weight = data.draw(st.none() | WEIGHTS)
    shares = np.array(data.draw(st.lists(SHARES, min_size=count - 1, max_size=count - 1)))
    target = points[0] + shares @ (points[1:] - points[0])
    moved = curve.with_subdivision_point(name, target, weight)
    assert np.abs(moved.subdivision_points[name] - target).max() <= 1e-6
    expected = curve.subdivision_weights[name] if weight is None else weight
    assert moved.subdivision_weights[name] == pytest.approx(expected, rel=1e-9)
    others = np.flatnonzero((moved.scheme.columns != curve.scheme.columns).any(axis=1))
    assert set(others) <= {curve.scheme.index(name)}


@given(control_points(), st.data())
def test_moving_without_weights_keeps_columns_summing_to_one(points, data):
    curve = Curve(points)
    name = data.draw(st.sampled_from(curve.scheme.free_names))
    target = points.mean(axis=0) + np.array([0, 1, 0])
    moved = curve.with_subdivision_point(name, target, project=True)
    assert np.abs(moved.scheme.columns.sum(axis=1) - 1).max() <= 1e-9


def test_least_change_is_orthogonal_to_the_kernel_of_the_projection():
    points = [(0, 0), (1, 2), (2, 2), (3, 1), (4, 0)]
    curve = Curve(points, weights=[1, 2, 1, 1, 3])
    moved = curve.with_subdivision_point("s3", (1, 5), 0.7)
    change = moved.scheme.columns[2] - curve.scheme.columns[2]
    kernel = np.linalg.svd(curve.projection)[2][3:]
    assert np.abs(kernel @ change).max() <= 1e-14


def test_least_change_equals_the_raw_pseudo_inverse_where_that_is_well_conditioned():
    curve = Curve([(0, 0, 0), (1, 2, 0), (2, 2, 1), (3, 1, 0), (4, 0, 2)], weights=[1, 2, 1, 1, 3])
    column, s = curve.scheme.columns[3], np.array([1.5, 1.5, 3, 0.5]) * [1, 1.5, 1.5, 1.5]
    expected = column + np.linalg.pinv(curve.projection) @ (s - curve.projection @ column)
    moved = curve.with_subdivision_point("s4", s[1:] / 1.5, 1.5)
    assert np.abs(moved.scheme.columns[3] - expected).max() <= 1e-13


def test_subdivision_point_off_the_plane_is_out_of_reach_by_its_distance():
    curve = Curve([(0, 0, 0), (1000, 2000, 0), (3000, 0, 0)])
    with pytest.raises(OutOfReachError, match="25 mm off the plane") as caught:
        curve.with_subdivision_point("s2", (100, 100, 25))
    assert caught.value.values["distance"] == pytest.approx(25)
    line = Curve([(0, 0, 0), (1, 0, 0), (2, 0, 0)])
    with pytest.raises(OutOfReachError, match="5 mm off the line"):
        line.with_subdivision_point("s2", (1, 3, 4))


@given(control_points(3, 3), st.tuples(*[st.floats(-3000, 3000)] * 3), st.data())
def test_projected_subdivision_point_is_the_nearest_of_the_hull(points, target, data):
    weights = data.draw(st.lists(WEIGHTS, min_size=3, max_size=3))
    sides = points[1:] - points[0]
    if np.linalg.norm(np.cross(*sides)) < 1e5:  # nearly on a line: columns would be huge
        points[1, 1] += 500
        sides = points[1:] - points[0]
    curve = Curve(points, weights=weights).with_subdivision_point("s2", target, project=True)
    shares = np.linalg.lstsq(sides.T, target - points[0])[0]
    nearest = points[0] + shares @ sides
    assert np.abs(curve.subdivision_points["s2"] - nearest).max() <= 1e-6


def test_subdivision_weight_alone_keeps_the_place():
    curve = Curve(PLANE).with_subdivision_point("s3", weight=2)
    assert curve.subdivision_weights["s3"] == pytest.approx(2)
    assert np.abs(curve.subdivision_points["s3"] - [1.25, 1, 0]).max() <= 1e-14
    assert curve.homogeneous[8].tolist() == pytest.approx([2, 2.5, 2, 0])
    for weight in (0, -1, np.nan):
        with pytest.raises(WeightError):
            curve.with_subdivision_point("s3", weight=weight)


def test_subdivision_point_that_lost_its_weight_needs_place_and_weight():
    scheme = Scheme.de_casteljau(3).with_column("s2", [-1, 0, 0])
    curve = Curve(PLANE, scheme=scheme)
    with pytest.raises(WeightError, match="s2"):
        _ = curve.subdivision_points
    with pytest.raises(WeightError, match="s2"):
        curve.with_subdivision_point("s2", (0.5, 1))
    repaired = curve.with_subdivision_point("s2", (0.5, 1), 1)
    assert np.abs(repaired.subdivision_points["s2"] - [0.5, 1, 0]).max() <= 1e-14


def test_subdivision_points_fixed_or_unknown_list_those_there_are():
    with pytest.raises(InputError, match="s2, s3, s5"):
        Curve(PLANE).with_subdivision_point("s1", (0, 0))
    with pytest.raises(InputError, match="s2, s3, s5"):
        Curve(PLANE).with_subdivision_point("s8", (0, 0))


@given(curves(), st.sampled_from(["s2", "s3", "s4"]))
def test_moved_joints_stay_single_points(curve, name):
    curve = curve.with_depth(2).with_subdivision_point(name, curve.control_points.mean(axis=0))
    for number in range(curve.scheme.count - 1):
        left, right = curve.homogeneous_at([number]), curve.homogeneous_at([number + 1])
        assert np.abs(left[-1] - right[0]).max() <= 1e-9


# Roughness and contraction


def test_roughness_one_third_is_the_curve_of_takagi():
    depth = 7
    curve = Curve([(0, 0), (1, 2), (2, 0)], depth=depth).with_roughness(1 / 3)
    t = np.arange(2**depth + 1) / 2**depth
    takagi = sum(np.abs(2**j * t - np.round(2**j * t)) / 2**j for j in range(depth))
    # The first detail lifts the middle from 0 to 1, where the curve of Takagi has 1/2.
    assert np.abs(curve.points[:, 1] - 2 * takagi).max() <= 1e-14
    assert np.abs(curve.points[:, 0] - 2 * t).max() <= 1e-14


@given(curves(), st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
def test_roughness_called_twice_multiplies(curve, first, second):
    twice = curve.with_roughness(first).with_roughness(second)
    factor = (1 + 3 * first) * (1 + 3 * second)
    once = curve.with_roughness((factor - 1) / 3)
    assert np.abs(twice.scheme.columns - once.scheme.columns).max() <= 1e-12


def test_contraction_of_curves_with_and_without_weights():
    smooth = Curve(PLANE)
    assert smooth.contraction().contracting
    assert smooth.with_weights([2, 2, 2]).contraction().rate == smooth.contraction().rate
    weighted = smooth.with_weights([1, 3, 1])
    assert weighted.contraction().contracting
    assert 0.5 <= weighted.contraction().rate < 0.6
    for curve in (smooth, weighted):
        wild = curve.with_roughness(1)
        assert wild.contraction().rate >= 1
        assert "do not shrink" in wild.contraction().warning


# Germs


def test_germ_in_space_is_laid_into_every_piece():
    curve = Curve([(0, 0), (2, 2), (4, 0)], depth=1).with_germ([(0, 0), (1, 1), (4, 0)])
    # (1, 1) is half way from the first to the second control point.
    assert np.abs(curve.germ_columns[1] - [0.5, 0.5, 0]).max() <= 1e-14
    assert (
        np.abs(curve.points[:, :2] - [(0, 0), (0.5, 0.5), (2, 1), (2.5, 1), (4, 0)]).max() <= 1e-14
    )


def test_germ_depth_zero_is_the_polyline_itself():
    polyline = np.array([(0, 0, 0), (100, 0, 900), (2000, 0, 1500), (4500, 0, 0)], dtype=float)
    curve = Curve(ARCH, depth=0, weights=[1, 2, 3, 1.5]).with_germ(polyline)
    assert np.abs(curve.points - polyline).max() <= 1e-9


def test_germ_that_misses_the_ends_or_the_span_is_an_error():
    curve = Curve([(0, 0), (2, 2), (4, 0)])
    with pytest.raises(ContinuityError, match=r"0 mm and 0\.5 mm"):
        curve.with_germ([(0, 0), (1, 1), (4, 0.5)])
    with pytest.raises(OutOfReachError, match="3 mm off the plane"):
        curve.with_germ([(0, 0, 0), (1, 1, 3), (4, 0, 0)])
    with pytest.raises(InputError, match="at least 2"):
        curve.with_germ([(0, 0)])


def test_germ_given_as_columns_must_run_from_end_to_end():
    with pytest.raises(ContinuityError):
        Curve(PLANE, germ=[[1, 0, 0], [0, 1, 0]])


# Even fold


@given(control_points(2, 5), st.floats(1.05, 5), st.booleans(), st.floats(0, 6.3))
def test_even_fold_makes_all_segments_equally_steep(points, excess, valley, turn):
    points = points / 1000
    across = np.array([np.cos(turn), np.sin(turn), 0])
    planar = points[:, :1] * across + points[:, 2:] * [0, 0, 1]
    curve = Curve(planar, depth=3)
    steps = np.diff(curve.points, axis=0)
    steepest = (np.abs(steps[:, 2]) / (steps @ across)).max()
    slope = max(excess * steepest, 0.2) * (-1 if valley else 1)
    folded = curve.with_even_fold(slope)
    steps = np.diff(folded.points, axis=0)
    slopes = steps[:, 2] / (steps @ across)
    signs = np.tile([1.0, -1.0], curve.segments)
    assert (
        np.abs(slopes - slope * signs).max() <= 1e-12 * max(1, abs(slope)) / (steps @ across).min()
    )
    assert (folded.points[::2] == curve.points).all()


def test_even_fold_splits_a_chord_by_hand():
    # H = 4, Z = 1, k = 1: h = (4 + 1)/2.
    curve = Curve([(0, 0, 0), (4, 0, 1)], depth=0, weights=[1, 3])
    folded = curve.with_even_fold(1)
    assert np.abs(folded.points - [(0, 0, 0), (2.5, 0, 2.5), (4, 0, 1)]).max() <= 1e-15
    assert folded.homogeneous[:, 0].tolist() == [1, 2, 3]
    valley = curve.with_even_fold(-1)
    assert np.abs(valley.points[1] - [1.5, 0, -1.5]).max() <= 1e-15


def test_even_fold_follows_a_new_depth_and_other_points():
    curve = Curve([(0, 0), (10, 3), (20, 0)], depth=2).with_even_fold(2, (0, 5, 0))
    assert curve.fold.up == (0, 1, 0)
    deeper = curve.with_depth(3).with_control_point(1, (10, 6))
    steps = np.abs(np.diff(deeper.points, axis=0))
    assert np.abs(steps[:, 1] / steps[:, 0] - 2).max() <= 1e-12


def test_even_fold_too_gentle_names_segments_and_the_least_slope():
    curve = Curve([(0, 0), (1, 2), (2, 0)], depth=2)  # slopes 3/2, 1/2, -1/2, -3/2
    with pytest.raises(FoldError, match=r"00, 11.*above 1\.5") as caught:
        curve.with_even_fold(1.5, (0, 1, 0))
    assert caught.value.addresses == ("00", "11")
    assert caught.value.values["least_slope"] == pytest.approx(1.5)
    assert curve.with_even_fold(1.500001, (0, 1, 0)).segments == 8


def test_even_fold_of_a_curve_that_cannot_be_folded_says_why():
    with pytest.raises(FoldError, match="leaves that plane by"):
        Curve([(0, 0, 0), (1, 1, 0), (2, 0, 0)]).with_even_fold(2)
    with pytest.raises(FoldError, match="stands upright"):
        Curve([(0, 0, 0), (0, 0, 1)]).with_even_fold(2)
    with pytest.raises(FoldError, match="10, 11 run back") as caught:
        Curve([(0, 0), (4, 1), (1, 0)], depth=2).with_even_fold(9, (0, 1, 0))
    assert caught.value.addresses == ("10", "11")


@pytest.mark.parametrize(("slope", "up"), [(0, (0, 0, 1)), (1, (0, 0, 0)), (np.nan, (0, 0, 1))])
def test_even_fold_without_slope_or_direction_is_an_error(slope, up):
    with pytest.raises(InputError):
        Curve(ARCH).with_even_fold(slope, up)


# Schemes that do not interpolate


def test_uniform_b_spline_scheme_gives_the_b_spline():
    five = np.array([[4, 4, 0, 0], [1, 6, 1, 0], [0, 4, 4, 0], [0, 1, 6, 1], [0, 0, 4, 4]]).T / 8.0
    scheme = Scheme.from_transformations([five[:, :4], five[:, 1:]])
    curve = Curve(ARCH, depth=4, scheme=scheme)
    t = np.arange(17) / 16
    basis = [(1 - t) ** 3, 3 * t**3 - 6 * t**2 + 4, -3 * t**3 + 3 * t**2 + 3 * t + 1, t**3]
    assert np.abs(curve.points - np.array(basis).T @ ARCH / 6).max() <= 1e-11
