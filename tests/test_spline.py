"""B-splines and NURBS: equal to OpenCascade's, over any knots, as one IFS or span by span."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from OCP.Geom import Geom_BSplineCurve
from OCP.gp import gp_Pnt
from OCP.TColgp import TColgp_Array1OfPnt
from OCP.TColStd import TColStd_Array1OfInteger, TColStd_Array1OfReal

from ifs_cad.design.spline import (
    clamped_knots,
    spline,
    spline_scheme,
    spline_segment,
    uniform_knots,
)
from ifs_cad.design.transform import Scheme
from ifs_cad.errors import ContinuityError, InputError, WeightError

SIZE = 3000.0
RELATIVE = 1e-12


@st.composite
def nets(draw, degrees=(1, 6), more=4):
    """Degree, control points and weights (or none) of a spline that advances along x."""
    degree = draw(st.integers(*degrees))
    count = degree + draw(st.integers(1, more))
    places = st.lists(st.floats(-SIZE / 2, SIZE / 2), min_size=3 * count, max_size=3 * count)
    points = np.round(np.reshape(draw(places), (count, 3)), 3)
    points[:, 0] = SIZE * np.arange(count) / count + points[:, 0] / (3 * count)
    weights = draw(st.none() | st.lists(st.floats(0.3, 3), min_size=count, max_size=count))
    return degree, points, weights


@st.composite
def uneven_knots(draw, degree, count):
    """Knots of spans between 0.2 and 2, inner ones sometimes repeated up to the degree."""
    steps = draw(
        st.lists(st.floats(0.2, 2), min_size=count + degree + 1, max_size=count + degree + 1)
    )
    knots = np.cumsum(steps)
    if degree > 1 and count > degree + 2 and draw(st.booleans()):
        knots[degree + 1] = knots[degree + 2]
    return knots


def occt_points(degree, points, knots, weights, parameters):
    """Return OpenCascade's points of a B-spline at some parameters."""
    poles = TColgp_Array1OfPnt(1, len(points))
    shares = TColStd_Array1OfReal(1, len(points))
    for number, point in enumerate(points, start=1):
        poles.SetValue(number, gp_Pnt(*map(float, point)))
        shares.SetValue(number, 1.0 if weights is None else float(weights[number - 1]))
    values, times = np.unique(knots, return_counts=True)
    own, repeats = TColStd_Array1OfReal(1, len(values)), TColStd_Array1OfInteger(1, len(values))
    for number, (value, count) in enumerate(zip(values, times, strict=True), start=1):
        own.SetValue(number, float(value))
        repeats.SetValue(number, int(count))
    curve = Geom_BSplineCurve(poles, shares, own, repeats, degree, False)
    found = [curve.Value(float(parameter)) for parameter in parameters]
    return np.array([[point.X(), point.Y(), point.Z()] for point in found])


@given(nets(), st.booleans(), st.booleans(), st.integers(2, 4))
def test_whole_spline_equals_occt_at_equal_parameters(net, clamped, interpolating, count):
    degree, points, weights = net
    knots = (clamped_knots if clamped else uniform_knots)(degree, len(points))
    curve = spline(
        degree,
        points,
        knots,
        weights=weights,
        transformations=count,
        interpolating=interpolating,
        depth=3,
    )
    parameters = np.linspace(knots[degree], knots[len(points)], count**3 + 1)
    expected = occt_points(degree, points, knots, weights, parameters)
    assert np.abs(curve.points - expected).max() <= RELATIVE * SIZE


@given(nets(), st.booleans(), st.data())
def test_every_span_of_uneven_knots_equals_occt(net, interpolating, data):
    degree, points, weights = net
    knots = data.draw(uneven_knots(degree, len(points)))
    breaks = np.unique(knots[degree : len(points) + 1])
    for span, (start, end) in enumerate(pairwise(breaks)):
        segment = spline_segment(
            degree, points, knots, span, weights=weights, interpolating=interpolating, depth=5
        )
        expected = occt_points(degree, points, knots, weights, np.linspace(start, end, 33))
        assert np.abs(segment.points - expected).max() <= RELATIVE * SIZE


def test_uniform_quadratic_is_the_corner_cutting_of_chaikin():
    scheme = spline_scheme(2, uniform_knots(2, 3))
    expected = np.array([[3, 1, 0, 0], [1, 3, 3, 1], [0, 0, 1, 3]]) / 4
    assert (scheme.transformations == [expected[:, :3], expected[:, 1:]]).all()
    assert scheme.names == ("s1", "s2", "s3", "s6")
    assert set(scheme.kinds().values()) == {"shared", "free"}


def test_uniform_cubic_starts_between_its_control_points():
    scheme = spline_scheme(3, uniform_knots(3, 4))
    assert np.abs(scheme.ends - np.array([[1, 4, 1, 0], [0, 1, 4, 1]]) / 6).max() <= 1e-14
    assert not scheme.is_interpolating
    assert not scheme.fixed.any()


@given(st.integers(1, 6), st.integers(2, 4))
def test_knots_of_a_bezier_curve_give_the_scheme_of_de_casteljau(degree, count):
    scheme = spline_scheme(degree, [0] * (degree + 1) + [1] * (degree + 1), count)
    bezier = Scheme.de_casteljau(degree + 1, count)
    assert np.abs(scheme.transformations - bezier.transformations).max() <= 1e-14
    assert scheme.names == bezier.names
    assert (scheme.fixed == bezier.fixed).all()
    assert scheme.is_interpolating


@given(st.integers(1, 5), st.integers(1, 5), st.integers(2, 4), st.data())
def test_columns_sum_to_one_over_any_knots(degree, spans, count, data):
    knots = data.draw(uneven_knots(degree, degree + 1))
    scheme = spline_scheme(degree, knots, count)
    assert np.abs(scheme.columns.sum(axis=1) - 1).max() <= 1e-12
    whole = spline_scheme(degree, uniform_knots(degree, degree + spans), count)
    assert np.abs(whole.columns.sum(axis=1) - 1).max() <= 1e-12
    # N parts of as many spans over one row of refined control points
    assert len(whole.columns) == count * spans + degree


def test_clamped_spline_starts_and_ends_at_control_points_and_can_be_bent():
    points = [(0, 0), (1, 2), (3, 2), (4, 0), (6, 1)]
    curve = spline(2, points, depth=3)
    assert curve.points[0].tolist() == [0, 0, 0]
    assert curve.points[-1].tolist() == [6, 1, 0]
    moved = curve.with_subdivision_point("s3", (1, 3))
    assert np.abs(moved.subdivision_points["s3"] - [1, 3, 0]).max() <= 1e-12
    assert np.abs(moved.with_roughness(0.2).points - moved.points).max() > 0.01


def test_moving_a_column_of_unclamped_ends_is_refused_and_interpolating_allows_it():
    points = [(0, 0), (1, 2), (3, 2), (4, 0)]
    loose = spline(3, points, uniform_knots(3, 4))
    with pytest.raises(ContinuityError, match="tear"):
        loose.with_subdivision_point("s2", (1, 1))
    held = spline(3, points, uniform_knots(3, 4), interpolating=True)
    assert np.abs(held.points - loose.points).max() <= 1e-14
    assert held.with_subdivision_point("s2", (1, 1)).segments == loose.segments


def test_bezier_points_of_a_uniform_cubic_span_by_hand():
    segment = spline_segment(
        3, [(0, 0), (6, 0), (6, 6), (0, 6)], uniform_knots(3, 4), interpolating=True
    )
    expected = [[5, 1, 0], [6, 2, 0], [6, 4, 0], [5, 5, 0]]
    assert np.abs(segment.control_points - expected).max() <= 1e-14


@given(nets(degrees=(2, 5)), st.integers(2, 3))
def test_closed_spline_is_periodic_and_equals_occt(net, count):
    degree, points, weights = net
    points = points.copy()
    turn = 2 * np.pi * np.arange(len(points)) / len(points)
    points[:, :2] = SIZE * np.column_stack([np.cos(turn), np.sin(turn)])
    curve = spline(degree, points, weights=weights, closed=True, transformations=count, depth=3)
    around = np.arange(len(points) + degree) % len(points)
    knots = uniform_knots(degree, len(around))
    expected = occt_points(
        degree,
        points[around],
        knots,
        None if weights is None else np.array(weights)[around],
        np.linspace(0, len(points), count**3 + 1),
    )
    assert curve.is_closed
    assert (curve.points[0] == curve.points[-1]).all()
    assert np.abs(curve.points - expected).max() <= RELATIVE * SIZE


def test_closed_spline_turns_as_gently_where_it_closes_as_anywhere():
    square = [(0, 0), (2, 0), (2, 2), (0, 2)]
    points = spline(3, square, closed=True, depth=8).points
    steps = np.diff(np.vstack([points, points[1]]), axis=0)
    turns = np.cross(steps[:-1], steps[1:])[:, 2] / np.linalg.norm(steps[1:], axis=1) ** 2
    quarter = len(turns) // 4
    assert np.abs(turns[-1] - turns[quarter - 1]) <= 1e-9
    assert turns.max() < 0.05


def test_closed_interpolating_spline_is_the_same_curve():
    square = [(0, 0, 0), (2, 0, 1), (2, 2, 0), (0, 2, 1)]
    loose = spline(3, square, closed=True)
    held = spline(3, square, closed=True, interpolating=True)
    assert held.closed
    assert held.scheme.is_interpolating
    assert np.abs(held.points - loose.points).max() <= 1e-14
    assert len(held.control_points) == len(square) + 3 - 1


def test_moving_a_control_point_of_a_closed_spline_keeps_it_closed():
    curve = spline(3, [(0, 0), (2, 0), (2, 2), (0, 2)], closed=True)
    moved = curve.with_control_point(0, (-1, -1, 3), 2)
    assert moved.is_closed
    assert np.abs(moved.points[0] - curve.points[0]).max() > 0.1
    assert (moved.points[0] == moved.points[-1]).all()


def test_knot_at_a_third_is_one_ifs_of_three_maps_but_not_of_two():
    knots = [0, 0, 0, 1, 3, 3, 3]
    points = [(0, 0, 0), (1, 2, 0), (3, 2, 0), (4, 0, 0)]
    curve = spline(2, points, knots, transformations=3, depth=2)
    expected = occt_points(2, points, knots, None, np.linspace(0, 3, 10))
    assert np.abs(curve.points - expected).max() <= 1e-14
    with pytest.raises(InputError, match=r"0\.333333 .*0\.666667.*spline_segment"):
        spline(2, points, knots)


@pytest.mark.parametrize(
    ("shares", "count", "one"),
    [
        ([1 / 2], 2, True),
        ([1 / 3, 2 / 3], 2, True),
        ([1 / 4, 1 / 2], 2, True),
        ([1 / 4], 2, False),
        ([1 / 2], 3, True),
        ([1 / 3, 2 / 3, 2 / 3], 2, False),
        ([1 / 3, 1 / 3, 2 / 3, 2 / 3], 2, True),
        ([1 / 5, 2 / 5, 3 / 5, 4 / 5], 2, True),
        ([1 / 5, 2 / 5, 4 / 5], 2, False),
    ],
)
def test_splines_whose_knots_map_onto_knots_are_one_ifs(shares, count, one):
    knots = [0, 0, 0, *shares, 1, 1, 1]
    if one:
        points = np.random.default_rng(3).normal(size=(len(shares) + 3, 3))
        curve = spline(2, points, knots, transformations=count, depth=3)
        expected = occt_points(2, points, knots, None, np.linspace(0, 1, count**3 + 1))
        assert np.abs(curve.points - expected).max() <= 1e-13
    else:
        with pytest.raises(InputError, match="not one IFS"):
            spline_scheme(2, knots, count)


@pytest.mark.parametrize(
    ("degree", "knots", "error", "match"),
    [
        (2, [0, 0, 0, 1, 1], InputError, "6 knots"),
        (2, [0, 0, 0, 1, 0.5, 1], InputError, "never fall"),
        (2, [0, 0, 1, 1, 2, np.nan], InputError, "finite"),
        (2, [0, 1, 1, 1, 2, 3], InputError, "both 1"),
        (2, "abc", InputError, "numbers"),
        (3, [0, 0, 0, 1, 1, 1], InputError, "degree 3 needs at least 4"),
        (0, [0, 1], InputError, "degree"),
    ],
)
def test_unsound_knots_are_refused(degree, knots, error, match):
    with pytest.raises(error, match=match):
        spline_segment(degree, [(0, 0), (1, 1), (2, 0)], knots)


def test_inner_knot_repeated_more_than_the_degree_tears_the_curve():
    points = np.arange(12).reshape(6, 2) ** 2.0
    with pytest.raises(ContinuityError, match="repeated 3 times"):
        spline(2, points, [0, 0, 0, 1, 1, 1, 2, 2, 2])


def test_span_that_there_is_not_and_unsound_weights_are_refused():
    points = [(0, 0), (1, 2), (3, 2), (4, 0)]
    knots = uniform_knots(2, 4)
    last, second = spline_segment(2, points, knots, -1), spline_segment(2, points, knots, 1)
    assert (last.points == second.points).all()
    with pytest.raises(InputError, match="span"):
        spline_segment(2, points, knots, 2)
    with pytest.raises(WeightError):
        spline_segment(2, points, knots, weights=[1, 1, 0, 1])
    with pytest.raises(InputError, match="uniform knots"):
        spline(2, points, knots, closed=True)
    with pytest.raises(InputError, match="at least 3"):
        spline(2, points[:2], closed=True)
