"""Conics: every point on its conic, ends and tangents where they belong."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ifs_cad.design.conic import arc, arc_through, conic, ellipse, hyperbola, parabola
from ifs_cad.errors import InputError

RELATIVE = 1e-12

radii = st.floats(0.1, 20000)
angles = st.floats(-400, 400).map(lambda value: round(value, 3))
coordinates = st.floats(-5000, 5000).map(lambda value: round(value, 3))
places = st.tuples(coordinates, coordinates, coordinates)
maps = st.integers(2, 4)


@st.composite
def frames(draw):
    """Centre and two half-diameters that are well apart."""
    turned = np.linalg.qr(np.reshape(draw(st.lists(coordinates, min_size=9, max_size=9)), (3, 3)))
    across, along = turned.Q[:, 1], turned.Q[:, 0]
    lean = draw(st.floats(-0.5, 0.5))
    return np.array(draw(places)), draw(radii) * along, draw(radii) * (across + lean * along)


def coordinates_in(points, centre, first, second):
    """Return the (n, 2) coordinates of points along two half-diameters, and how far off plane."""
    basis = np.column_stack([first, second])
    found = np.linalg.lstsq(basis, (points - centre).T)[0]
    off = (points - centre).T - basis @ found
    return found.T, np.abs(off).max()


@given(places, radii, angles, st.floats(1, 360), maps, st.booleans(), st.data())
def test_points_of_an_arc_lie_on_its_circle(centre, radius, start, sweep, count, back, data):
    least = int(sweep // 180) + 1
    spans = data.draw(st.none() | st.integers(least, least + 3))
    end = start - sweep if back else start + sweep
    curve = arc(
        centre, radius, start, end, spans=spans, transformations=count, depth=4 if count < 3 else 3
    )
    from_centre = curve.points - centre
    size = radius + np.abs(centre).max()
    assert np.abs(np.linalg.norm(from_centre, axis=1) - radius).max() <= RELATIVE * size
    for place, angle in ((0, start), (-1, end)):
        expected = radius * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle)), 0])
        assert np.abs(from_centre[place] - expected).max() <= RELATIVE * size
    # one way around, by the sweep in all
    along = np.unwrap(np.arctan2(from_centre[:, 1], from_centre[:, 0]))
    assert (np.diff(along) * (-1 if back else 1) > 0).all()
    assert abs(np.degrees(along[-1] - along[0]) - (end - start)) <= 1e-6


@given(frames(), angles, st.floats(1, 360))
def test_points_of_an_ellipse_satisfy_its_equation(frame, start, sweep):
    centre, first, second = frame
    points = ellipse(centre, first, second, start, start + sweep, depth=5).points
    size = max(np.linalg.norm(first), np.linalg.norm(second)) + np.abs(centre).max()
    least = min(np.linalg.norm(first), np.linalg.norm(second))
    found, off = coordinates_in(points, centre, first, second)
    assert off <= RELATIVE * size
    assert np.abs((found**2).sum(axis=1) - 1).max() <= 10 * RELATIVE * size / least


@given(frames(), st.floats(-2, 2), st.floats(0.1, 3), st.integers(1, 3))
def test_points_of_a_hyperbola_satisfy_its_equation(frame, start, length, spans):
    centre, first, second = frame
    points = hyperbola(centre, first, second, start, start + length, spans=spans).points
    size = np.abs(points).max() + np.abs(centre).max()
    least = min(np.linalg.norm(first), np.linalg.norm(second))
    found, off = coordinates_in(points, centre, first, second)
    assert off <= RELATIVE * size
    apart = np.abs(found[:, 0] ** 2 - found[:, 1] ** 2 - 1)
    assert apart.max() <= 10 * RELATIVE * (1 + found.max() ** 2) * size / least
    assert (found[:, 0] > 0).all()
    for place, t in ((0, start), (-1, start + length)):
        expected = centre + first * np.cosh(t) + second * np.sinh(t)
        assert np.abs(points[place] - expected).max() <= RELATIVE * size


@given(frames(), st.floats(-3, 3), st.floats(0.1, 3))
def test_points_of_a_parabola_are_evenly_spread_over_its_parameter(frame, start, length):
    vertex, first, second = frame
    points = parabola(vertex, first, second, start, start + length).points
    t = np.linspace(start, start + length, 17)[:, None]
    expected = vertex + first * t + second * t**2
    assert np.abs(points - expected).max() <= RELATIVE * (np.abs(expected).max() + 1)


@given(st.floats(0.01, 0.99))
def test_conic_passes_at_rho_between_chord_and_apex(rho):
    curve = conic((0, 0), (1000, 2000), (4000, 0), rho, depth=3)
    middle = np.array([2000, 0, 0])
    expected = middle + rho * (np.array([1000, 2000, 0]) - middle)
    assert np.abs(curve.points[4] - expected).max() <= RELATIVE * 4000


def test_full_circle_is_closed_and_its_quarters_are_equal():
    curve = arc((100, 200), 500, depth=4)
    assert curve.closed
    assert curve.is_closed
    assert (curve.points[0] == curve.points[-1]).all()
    assert len(curve.control_points) == 8
    expected = [[600, 200], [100, 700], [-400, 200], [100, -300]]
    assert np.abs(curve.points[[0, 4, 8, 12], :2] - expected).max() <= 1e-12 * 600
    octagon = arc((0, 0), 500, depth=3).points
    sides = np.linalg.norm(np.diff(octagon, axis=0), axis=1)
    assert np.abs(sides - 1000 * np.sin(np.pi / 8)).max() <= 1e-12 * 500


def test_full_circle_across_the_rounding_of_degrees_is_closed():
    curve = arc((0, 0), 1000, 0.1, 360.1)
    assert curve.closed
    assert len(curve.control_points) == 8


def test_segments_of_default_spans_differ_by_less_than_a_fifth():
    sides = np.linalg.norm(np.diff(arc((0, 0), 1000, depth=10).points, axis=0), axis=1)
    assert sides.max() / sides.min() < 1.18
    thirds = np.linalg.norm(np.diff(arc((0, 0), 1000, spans=3, depth=10).points, axis=0), axis=1)
    assert thirds.max() / thirds.min() < 1.34


def test_arc_of_less_than_half_a_turn_can_be_one_quadratic_of_the_known_weight():
    curve = arc((0, 0), 1000, 30, 150, spans=1)
    assert len(curve.control_points) == 3
    assert np.abs(curve.weights - [1, 0.5, 1]).max() <= 1e-15
    assert np.abs(curve.control_points[1] - [0, 2000, 0]).max() <= 1e-12 * 2000


def test_upright_arc_stands_in_its_plane():
    curve = arc((0, 500, 0), 2000, 180, 0, x=(1, 0, 0), y=(1, 0, 5), depth=2)
    expected = [[-2000, 500, 0], [0, 500, 2000], [2000, 500, 0]]
    assert np.abs(curve.points[::2] - expected).max() <= 1e-12 * 2000


@given(places, st.floats(100, 5000), angles, st.floats(5, 355), st.floats(0.02, 0.98))
def test_arc_through_three_points_of_a_circle_is_that_arc(centre, radius, start, sweep, share):
    angle = np.radians(start + sweep * np.array([0, share, 1]))
    turned = np.linalg.qr(np.array([[1, 2, 3], [0, 1, 4], [5, 6, 0.0]])).Q
    x, y = turned[:, 0], turned[:, 1]
    given_points = centre + radius * (np.outer(np.cos(angle), x) + np.outer(np.sin(angle), y))
    curve = arc_through(*given_points)
    # the centre of three near points is ill-conditioned; the ends and the middle are not
    steps = np.linalg.norm(np.diff(given_points[[0, 1, 2, 0]], axis=0), axis=1)
    slack = (radius / steps.min()) ** 2 * (radius + np.abs(centre).max())
    assert np.abs(curve.points[[0, -1]] - given_points[[0, 2]]).max() <= RELATIVE * slack
    distances = np.linalg.norm(curve.points - centre, axis=1)
    assert np.abs(distances - radius).max() <= 10 * RELATIVE * slack
    along = np.unwrap(np.arctan2((curve.points - centre) @ y, (curve.points - centre) @ x))
    assert abs(along[-1] - along[0] - np.radians(sweep)) <= 1e-6


def test_moved_subdivision_point_of_a_circle_keeps_it_closed():
    curve = arc((0, 0), 1000)
    bent = curve.with_subdivision_point("s4", (600, 900))
    assert bent.is_closed
    assert np.abs(bent.points - curve.points).max() > 1


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda: arc((0, 0), -5), "positive"),
        (lambda: arc((0, 0), np.nan), "radius"),
        (lambda: arc((0, 0), 5, 10, 10), "more than 0"),
        (lambda: arc((0, 0), 5, 0, 361), "at most 360"),
        (lambda: arc((0, 0), 5, 0, 180, spans=1), "less than 180"),
        (lambda: arc((0, 0), 5, 0, 90, spans=0), "spans"),
        (lambda: arc((0, 0), 5, y=(2, 0, 0)), "span no plane"),
        (lambda: arc((0, 0, np.inf), 5), "centre"),
        (lambda: arc_through((0, 0), (1, 1), (3, 3)), "on a line"),
        (lambda: conic((0, 0), (1, 1), (2, 0), 1.0), "rho"),
        (lambda: conic((0, 0), (1, 1), (2, 0), 0.0), "rho"),
        (lambda: parabola((0, 0), (1, 0), (0, 1), 2, 2), "differ"),
        (lambda: hyperbola((0, 0), (1, 0), (0, 1), 2, 2), "differ"),
        (lambda: hyperbola((0, 0), (1, 0), (0, 1), 0, np.inf), "parameters"),
    ],
)
def test_conics_that_there_are_not_are_refused(make, match):
    with pytest.raises(InputError, match=match):
        make()
