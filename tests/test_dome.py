"""Domes: profiles about the z axis, every node exact."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles import face_normal
from strategies import accepted, numbers

from ifs_cad.design.curve import Curve
from ifs_cad.design.dome import dome
from ifs_cad.errors import DomeError, InputError

QUARTER = np.radians([0, 25, 50, 75])
PROFILE = 3000 * np.stack([np.cos(QUARTER), 0 * QUARTER, np.sin(QUARTER)], axis=1)


@st.composite
def profiles(draw, closed=False):
    """Return points (radius, 0, height), foot first, or a closed ring of them."""
    count = draw(st.integers(3, 6))
    if closed:
        angles = np.arange(count) * 2 * np.pi / count + draw(numbers(count, -0.3, 0.3))
        flat = 500 * draw(numbers(count, 0.5, 1.5)) * [np.cos(angles), np.sin(angles)]
        points = np.column_stack([2000 + flat[0], 0 * angles, flat[1]])
        return np.vstack([points, points[:1]])
    radii, rises = draw(numbers(count, 300, 3000)), draw(numbers(count, 50, 900))
    return np.column_stack([radii, 0 * radii, np.cumsum(rises)])


@st.composite
def rings_of_azimuths(draw, sweep):
    """Return azimuths of normals; every second one may turn back, which folds the dome."""
    count = draw(st.integers(4, 9))
    step = sweep / count
    fold = draw(st.sampled_from([0.0, 0.5, 2.0]))
    middle = (np.arange(count) + 0.5) * step
    turned = middle + draw(numbers(count, -0.2, 0.2)) * step
    turned[1:-1:2] += fold * step
    return turned


def tangent_distances(mesh, level):
    """Return the distances from the axis of the lines through the ring's edges at a level."""
    ring = mesh.vertices[mesh.lattice][:, level, :2]
    start, along = ring[:-1], np.diff(ring, axis=0)
    return (along[:, 1] * start[:, 0] - along[:, 0] * start[:, 1]) / np.linalg.norm(along, axis=1)


def test_square_dome_of_two_levels_is_a_frustum():
    mesh = dome([(2000, 0, 0), (1000, 0, 500)], sides=4)
    np.testing.assert_allclose(
        mesh.vertices[mesh.lattice][:4],
        [
            [(2000, 0, 0), (1000, 0, 500)],
            [(0, 2000, 0), (0, 1000, 500)],
            [(-2000, 0, 0), (-1000, 0, 500)],
            [(0, -2000, 0), (0, -1000, 500)],
        ],
        atol=1e-9,
    )
    assert len(mesh.vertices) == 8


def test_first_meridian_is_the_profile():
    mesh = dome(PROFILE, sides=5, sweep=200)
    np.testing.assert_allclose(mesh.vertices[mesh.lattice][0], PROFILE, atol=1e-9)


def test_profile_may_lie_in_any_plane_through_the_axis():
    turn = np.radians(130)
    turned = PROFILE @ [
        [np.cos(turn), np.sin(turn), 0],
        [-np.sin(turn), np.cos(turn), 0],
        [0, 0, 1],
    ]
    mesh = dome(turned, sides=6)
    np.testing.assert_allclose(mesh.vertices[mesh.lattice][0], turned, atol=1e-9)
    assert mesh.areas.sum() == pytest.approx(dome(PROFILE, sides=6).areas.sum(), rel=1e-12)


@given(profiles(), st.integers(3, 12), st.floats(20, 360))
def test_equal_sides_are_equal_and_tangent_to_one_circle_at_each_level(profile, sides, sweep):
    mesh = accepted(dome, profile, sides=sides, sweep=sweep)
    apothem = np.cos(np.radians(sweep / sides / 2))
    for level, radius in enumerate(profile[:, 0]):
        np.testing.assert_allclose(tangent_distances(mesh, level), radius * apothem, rtol=1e-9)
    areas = mesh.areas.reshape(sides, -1)
    np.testing.assert_allclose(areas, np.tile(areas[0], (sides, 1)), rtol=1e-9)


@given(profiles(), rings_of_azimuths(300))
def test_azimuths_are_those_of_the_normals_and_all_edges_touch_one_circle(profile, azimuths):
    mesh = accepted(dome, profile, azimuths, sweep=300)
    rows = np.array([face_normal(mesh, polygon) for polygon in mesh.polygons()])
    level = rows.reshape(len(azimuths), -1, 3)[..., :2]
    level = level / np.linalg.norm(level, axis=-1, keepdims=True)
    radians = np.radians(azimuths)[:, None]
    wanted = np.stack([np.cos(radians), np.sin(radians)], axis=-1)
    # a side that leans over the axis has its normal on the far side
    np.testing.assert_allclose(np.abs((level * wanted).sum(axis=-1)), 1, atol=1e-9)
    for height in range(len(profile)):
        distances = tangent_distances(mesh, height)
        np.testing.assert_allclose(distances, distances[0], rtol=1e-9)
    np.testing.assert_allclose(mesh.vertices[mesh.lattice][0], profile, atol=1e-8)


@given(profiles(), rings_of_azimuths(360), st.floats(-180, 180))
def test_closed_dome_of_any_azimuths_meets_the_profile_where_it_is_drawn(profile, azimuths, turn):
    mesh = accepted(dome, profile, azimuths + turn)
    assert mesh.lattice[0, 0] == mesh.lattice[-1, 0]
    for height, radius in enumerate(profile[:, 0]):
        ring = mesh.vertices[mesh.lattice][:, height, :2]
        # walk along the x axis: one edge of the ring crosses it, at the radius of the profile
        start, end = ring[:-1], ring[1:]
        crosses = (start[:, 1] <= 1e-9) & (end[:, 1] > 1e-9)
        share = -start[crosses, 1] / (end - start)[crosses, 1]
        met = start[crosses, 0] + share * (end - start)[crosses, 0]
        np.testing.assert_allclose(met.max(), radius, rtol=1e-9)


@given(profiles(), st.integers(3, 12))
def test_closed_dome_has_no_seam(profile, sides):
    mesh = accepted(dome, profile, sides=sides)
    assert len(mesh.vertices) == sides * len(profile)
    assert (mesh.twin < 0).sum() == 2 * sides


@given(profiles(closed=True), st.integers(3, 12))
def test_closed_profile_makes_a_ring_without_a_border(profile, sides):
    mesh = accepted(dome, profile, sides=sides)
    assert (mesh.twin >= 0).all()


def test_normals_point_outwards_when_the_profile_is_drawn_from_the_foot_up():
    mesh = dome(PROFILE, sides=8)
    assert (np.einsum("fi,fi->f", mesh.normals, mesh.centroids) > 0).all()
    mesh = dome(PROFILE[::-1], sides=8)
    assert (np.einsum("fi,fi->f", mesh.normals, mesh.centroids) < 0).all()


def test_profile_may_be_an_iterated_curve_whose_word_leads_the_address():
    curve = Curve([(3000, 0, 0), (3000, 0, 2000), (800, 0, 2500)], depth=2, weights=[1, 2, 1])
    mesh = dome(curve, sides=5)
    np.testing.assert_allclose(mesh.vertices[mesh.lattice][0], curve.points, atol=1e-9)
    assert mesh.addresses[:6] == ("000", "010", "100", "110", "001", "011")


def test_lexicographic_addresses_are_side_and_segment():
    mesh = dome(PROFILE, sides=3, addresses="lexicographic")
    assert mesh.addresses[:4] == ("0.0", "0.1", "0.2", "1.0")


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({}, InputError, "either its number of sides or"),
        ({"sides": 4, "azimuths": [0, 90, 180, 270]}, InputError, "either its number of sides or"),
        ({"sides": 0}, InputError, "whole number of at least 1"),
        ({"sides": 2.5}, InputError, "whole number"),
        ({"sides": 8, "sweep": 0}, InputError, "sweep.*above 0 and at most 360, got 0"),
        ({"sides": 8, "sweep": 361}, InputError, "at most 360, got 361"),
        ({"sides": 8, "sweep": np.nan}, InputError, "sweep of a dome must be finite"),
        ({"sides": 8, "sweep": "half"}, InputError, "sweep of a dome"),
        ({"azimuths": []}, InputError, "azimuths of a dome must be 1 numbers"),
        ({"azimuths": [[0, 90], [180, 270]]}, InputError, "azimuths of a dome"),
        ({"azimuths": [0, np.nan, 240]}, InputError, "azimuths of a dome must be finite"),
        ({"azimuths": ["north"]}, InputError, "azimuths of a dome"),
        ({"sides": 2}, DomeError, "Side 0 has a border 90 degrees from its normal"),
        ({"sides": 1, "sweep": 180}, DomeError, "90 degrees"),
        ({"azimuths": [0, 90, 180]}, DomeError, "90 degrees"),
        ({"azimuths": [0, 180, 270], "sweep": 300}, DomeError, "turn by less than 180"),
        ({"azimuths": [100, 150], "sweep": 200}, DomeError, "Side 0 has a border 100 degrees"),
        ({"azimuths": [0, 120, 60, 240]}, DomeError, "Side 2 would run backwards|90"),
        ({"azimuths": [10, 30, 50], "sweep": 35}, DomeError, "Side 2 would run backwards, from 40"),
    ],
)
def test_bad_sides_are_refused_each_with_its_own_error(options, error, message):
    with pytest.raises(error, match=message):
        dome(PROFILE, **options)


@pytest.mark.parametrize(
    ("profile", "error", "message"),
    [
        ([(0, 0, 0), (0, 0, 9)], DomeError, "lies on the z axis"),
        ([(2000, 0, 0), (1000, 0, 500), (0, 0, 700)], DomeError, "as 0 mm at point 2.*opening"),
        ([(2000, 0, 0), (-100, 0, 500)], DomeError, "as -100 mm at point 1"),
        ([(2000, 0, 0), (1500, 30, 400), (1000, 0, 500)], DomeError, "by 30 mm at point 1"),
        ([(2000, 0, 0), (np.nan, 0, 500)], InputError, "curve profile must be finite"),
        ([(2000, 0, 0)], InputError, "Curve profile must be"),
    ],
)
def test_bad_profiles_are_refused_each_with_its_own_error(profile, error, message):
    with pytest.raises(error, match=message):
        dome(profile, sides=6)
