"""Subdivision control: segment lengths and the deviation from the limit at each iteration depth."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import accepted, ifs_curves, numbers

from ifs_cad.design.conic import arc
from ifs_cad.design.curve import Curve
from ifs_cad.design.limit import enclosure
from ifs_cad.design.spline import spline
from ifs_cad.design.subdivision_control import SubdivisionReport, iteration_depths
from ifs_cad.errors import ConstraintError, InputError, SizeError

ROUNDING = 1e-11  # of a few additions of lengths of some metres
PARABOLA = Curve([(0, 0), (3000, 4000), (6000, 0)])
TAKAGI = Curve([(0, 0), (1000, 600), (2000, 0)]).with_roughness(1 / 3)


def distances(points, start, end):
    """Distances of (k, 3) points from one segment each, (k, 3) and (k, 3)."""
    chord = end - start
    share = np.clip(((points - start) * chord).sum(1) / (chord**2).sum(1), 0, 1)
    return np.linalg.norm(points - start - share[:, None] * chord, axis=1)


def sampled_deviation(curve, further):
    """Largest distance of the curve some steps further on from the segments with its words."""
    own, fine = curve.points, curve.with_depth(curve.depth + further).points
    each = (len(fine) - 1) // (len(own) - 1)
    owner = np.minimum(np.arange(len(fine)) // each, len(own) - 2)
    return distances(fine, own[owner], own[owner + 1]).max()


def deviations(report):
    return np.array([row.deviation for row in report.rows])


def errors(report):
    return np.array([row.error for row in report.rows])


def test_deviation_of_a_parabola_is_that_of_its_steepest_parallelogram():
    # Parameter lines are parallel to the axis, so a piece is within |second difference| / 4^(n + 1)
    # of its chord along the axis, and the tangent at the middle is parallel to the chord. Square to
    # the chord that counts by the cosine of its slope, most at the flattest chord.
    report = iteration_depths(PARABOLA)
    for row in report.rows:
        slopes = 4000 / 3000 * (1 - (2 * np.arange(row.segments) + 1) / row.segments)
        along = 8000 / 4 ** (row.depth + 1)
        expected = along * np.cos(np.arctan(slopes)).max()
        assert row.deviation == pytest.approx(expected, abs=row.error + ROUNDING, rel=0)
        assert row.error <= 1e-9


def test_lengths_of_a_parabola_are_those_of_its_chords():
    report = iteration_depths(PARABOLA, deepest=6)
    assert [row.segments for row in report.rows] == [1, 2, 4, 8, 16, 32, 64]
    for row in report.rows:
        slopes = 4000 / 3000 * (1 - (2 * np.arange(row.segments) + 1) / row.segments)
        lengths = 6000 / row.segments * np.hypot(1, slopes)
        assert row.longest == pytest.approx(lengths.max(), abs=ROUNDING)
        assert row.shortest == pytest.approx(lengths.min(), abs=ROUNDING)


@pytest.mark.parametrize("turn", [60, 90, 150])
def test_deviation_of_an_arc_is_the_sagitta_of_its_longest_segment(turn):
    radius = 2000
    report = iteration_depths(arc((100, 200), radius, 10, 10 + turn, spans=1))
    for row in report.rows:
        angle = 2 * math.asin(row.longest / 2 / radius)
        sagitta = radius * (1 - math.cos(angle / 2))
        # the sagitta from the length is the worse conditioned the larger its angle
        assert row.deviation == pytest.approx(sagitta, abs=1e-9 + ROUNDING, rel=0)
    for row in report.rows[:2]:  # equal segments
        sagitta = radius * (1 - math.cos(math.radians(turn / row.segments) / 2))
        assert row.deviation == pytest.approx(sagitta, abs=1e-9 + ROUNDING, rel=0)


def test_deviation_of_a_straight_line_is_zero():
    report = iteration_depths(Curve([(0, 0, 0), (10, 20, 30), (20, 40, 60)]))
    assert deviations(report).max() <= ROUNDING
    assert [row.longest for row in report.rows] == pytest.approx(
        [20 * math.sqrt(14) / 2**depth for depth in range(11)]
    )


def test_deviation_of_a_shape_that_comes_close_to_itself_is_not_hidden():
    """The first half of this curve runs along the second, which is not its own segment."""
    there_and_back = Curve([(0, 0), (3000, 0), (-2000, 0), (1000, 0)])
    row = iteration_depths(there_and_back, deepest=1).rows[1]
    # x(t) / 1000 = 9t - 24t^2 + 16t^3 turns at t = 1/4 with 1 and at t = 3/4 with 0; x(1/2) = 0.5
    assert row.longest == pytest.approx(500)
    assert row.deviation == pytest.approx(500, abs=1e-9 + ROUNDING)


def test_deviation_of_the_takagi_curve_is_two_thirds_of_its_scale():
    """Profile h T(x), whose largest value is 2/3; at even depths there are level segments."""
    report = iteration_depths(TAKAGI, deepest=6)
    for row in report.rows:
        steepest = 600 * 2 / 3 / 2**row.depth
        assert row.deviation <= steepest + row.error
        if row.depth % 2 == 0:
            assert row.deviation >= steepest - ROUNDING
        assert row.error <= row.deviation / 1000


@pytest.mark.parametrize("depth", range(5))
def test_deviation_of_a_rough_curve_bounds_twelve_further_steps(depth):
    row = iteration_depths(TAKAGI, deepest=depth).rows[depth]
    sampled = sampled_deviation(TAKAGI.with_depth(depth), 12)
    remainder = 600 * 2 / 3 / 2 ** (depth + 12)
    assert sampled - ROUNDING <= row.deviation <= sampled + remainder + row.error


@given(numbers((3, 3), -2000, 2000), st.floats(-1, 1), st.integers(2, 3))
def test_deviation_of_conics_falls_with_depth(points, power, transformations):
    # the arc is convex, so a chord of a part is nearer to it than the chord of the whole
    curve = accepted(
        Curve, points, weights=[1, math.exp(power), 1], transformations=transformations
    )
    report = accepted(iteration_depths, curve, deepest=5)
    built = [row.deviation for row in report.rows if not row.obstacle]
    assert (np.diff(built) <= 1e-9 + ROUNDING).all()


@given(st.integers(2, 6).flatmap(lambda m: numbers((m, 3), -2000, 2000)), st.integers(2, 4))
def test_deviation_of_bezier_curves_keeps_to_the_bound_of_second_differences(
    points, transformations
):
    """|x''| h^2 / 8, with x'' = d (d - 1) second differences, is a bound of the textbooks."""
    curve = accepted(Curve, points, transformations=transformations)
    report = accepted(iteration_depths, curve, deepest=4)
    degree = len(points) - 1
    bend = np.linalg.norm(np.diff(points, n=2, axis=0), axis=1).max(initial=0.0)
    for row in (row for row in report.rows if not row.obstacle):
        bound = degree * (degree - 1) * bend / 8 / transformations ** (2 * row.depth)
        assert row.deviation <= bound + row.error + ROUNDING


@given(ifs_curves(0, depths=(0, 3)), st.integers(1, 5))
def test_deviation_bounds_all_sampled_distances(curve, further):
    row = iteration_depths(curve, deepest=curve.depth).rows[curve.depth]
    sampled = accepted(sampled_deviation, curve, further)
    assert row.obstacle == ""
    assert row.deviation >= sampled - ROUNDING


@given(ifs_curves(0, depths=(0, 0)))
def test_enclosure_holds_all_points_of_further_steps(curve):
    corners = enclosure(curve.scheme, curve.projection[0])
    if corners is None:
        return
    words = np.eye(curve.scheme.size)[None]
    for _ in range(9):
        words = (words[:, None] @ curve.scheme.transformations).reshape(-1, *words.shape[1:])
    reached = words @ curve.scheme.ends.T
    mixtures = np.linalg.solve(corners, reached)
    assert (mixtures >= -1e-12 * np.abs(mixtures).max()).all()


def test_deviation_of_a_spline_agrees_with_its_samples():
    curve = spline(3, [(0, 0, 0), (800, 0, 900), (1500, 300, -400), (2300, 0, 800), (3000, 0, 0)])
    report = iteration_depths(curve, deepest=4)
    for row in report.rows:
        sampled = sampled_deviation(curve.with_depth(row.depth), 9)
        assert sampled - ROUNDING <= row.deviation <= sampled * (1 + 1e-4)


def test_deviation_of_a_rough_rational_curve_agrees_with_its_samples():
    curve = Curve([(0, 0), (900, 700), (2000, 0)], weights=[1, 1.7, 0.8]).with_roughness(0.2)
    report = iteration_depths(curve, deepest=4)
    for row in report.rows:
        sampled = sampled_deviation(curve.with_depth(row.depth), 12)
        assert sampled - ROUNDING <= row.deviation <= sampled * (1 + 1e-4)


def test_deviation_of_an_evenly_folded_line_is_the_height_of_its_folds():
    folded = Curve([(0, 0, 0), (1000, 0, 0), (2000, 0, 0)]).with_even_fold(0.75)
    report = iteration_depths(folded, deepest=3)
    for row in report.rows:
        half = 1000 / 2**row.depth  # run of one of the two legs; its length is 5/4 of that
        assert row.segments == 2 ** (row.depth + 1)
        assert row.longest == pytest.approx(1.25 * half)
        # the middle of the chord is the farthest from the legs, by its sine 3/5
        assert row.deviation == pytest.approx(0.6 * half, abs=1e-9 + ROUNDING)


def test_deviation_of_a_germ_is_measured_from_the_germ():
    # the germ of depth 0 has the points of the curve of depth 1
    curve = PARABOLA.with_germ([(0, 0), (3000, 2000), (6000, 0)])
    row = iteration_depths(curve, deepest=0).rows[0]
    assert row.segments == 2
    assert row.longest == pytest.approx(math.hypot(3000, 2000))
    chords = iteration_depths(PARABOLA, deepest=1).rows[1]
    assert row.deviation == pytest.approx(chords.deviation, abs=2e-9)


def test_depths_that_cannot_be_built_say_why():
    circle = arc((0, 0), 1000)
    report = iteration_depths(circle, deepest=2)
    nothing, half, quarter = report.rows
    assert nothing.obstacle.startswith("Segments 0 have no length")
    assert math.isnan(nothing.longest)
    assert half.deviation == pytest.approx(1000)
    assert quarter.deviation == pytest.approx(1000 - math.sqrt(0.5) * 1000, abs=1e-9 + ROUNDING)
    assert report.depth == 1
    assert nothing.obstacle in str(report)


def test_limit_of_a_curve_that_does_not_contract_is_not_bounded():
    report = iteration_depths(PARABOLA.with_roughness(1.0), longest=4000, deepest=3)
    assert np.isinf(deviations(report)).all()
    assert np.isinf(errors(report)).all()
    assert report.remark.startswith("The pieces do not shrink")
    assert report.remark in str(report)
    assert report.depth == 1
    with pytest.raises(ConstraintError, match="The pieces do not shrink"):
        iteration_depths(PARABOLA.with_roughness(1.0), deviation=1000, deepest=3)


@pytest.mark.parametrize(
    ("longest", "deviation", "depth"),
    [
        (None, None, 0),
        (1500, None, 3),
        (None, 120, 2),
        (1500, 120, 3),
        (1500, 10, 4),
        (6000, 2000, 0),
    ],
)
def test_depth_is_the_first_that_suffices(longest, deviation, depth):
    report = iteration_depths(PARABOLA, longest=longest, deviation=deviation)
    assert report.depth == depth
    assert report.row is report.rows[depth]
    assert len(report.rows) == 11


def test_table_has_a_line_for_each_depth_and_marks_the_chosen_one():
    report = iteration_depths(PARABOLA, longest=1500, deepest=4)
    head, *lines = str(report).splitlines()
    assert head.split() == [
        "depth",
        "segments",
        "longest",
        "mm",
        "shortest",
        "mm",
        "deviation",
        "mm",
    ]
    assert [line[0] for line in lines] == [" ", " ", " ", ">", " "]
    assert lines[1].split() == ["1", "2", "3605.551", "3605.551", "416"]
    assert ">" not in str(iteration_depths(PARABOLA, deepest=2))


def test_wish_that_no_depth_meets_is_an_error_with_the_table():
    with pytest.raises(ConstraintError) as caught:
        iteration_depths(PARABOLA, longest=1000, deviation=1, deepest=4)
    message = str(caught.value)
    assert message.startswith(
        "No iteration depth up to 4 has segments of at most 1000 mm and deviates by at most 1 mm"
    )
    assert "3605.551" in message
    assert len(caught.value.values["rows"]) == 5


def test_usual_depths_stay_within_ten_thousand_elements():
    assert len(iteration_depths(Curve(PARABOLA.control_points, transformations=6)).rows) == 6


def test_memory_is_refused_before_anything_is_computed():
    with pytest.raises(SizeError, match="The greatest depth that fits is"):
        iteration_depths(PARABOLA, deepest=60)


@pytest.mark.parametrize(
    "wish",
    [
        {"longest": 0},
        {"longest": math.nan},
        {"longest": "far"},
        {"deviation": -1},
        {"deviation": math.inf},
        {"deepest": -1},
        {"deepest": 2.5},
    ],
)
def test_senseless_wishes_are_refused(wish):
    with pytest.raises(InputError):
        iteration_depths(PARABOLA, **wish)


def test_report_without_depths_is_refused():
    with pytest.raises(InputError, match="at least one depth"):
        SubdivisionReport(())
