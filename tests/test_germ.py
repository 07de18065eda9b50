"""Germs: points, lines and faces, and their lengths, areas and volumes."""

import numpy as np
import pytest

from ifs_cad.design.germ import Germ
from ifs_cad.errors import InputError, SizeError

SQUARE = [(0, 0), (2, 0), (2, 2), (0, 2)]
# A pyramid of height 3 over the square of side 2: volume 4, slanted faces of height sqrt(10).
PYRAMID = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (1, 1, 3)]
PYRAMID_FACES = [(0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
# A rectangle of 4 by 2 with a notch of area 1 on its left.
ARROW = [(1, 1), (0, 0), (4, 0), (4, 2), (0, 2)]


def test_polyline_joins_its_points_and_closes_on_demand():
    assert Germ.polyline(SQUARE).segments.tolist() == [[0, 1], [1, 2], [2, 3]]
    closed = Germ.polyline(SQUARE, closed=True)
    assert closed.segments.tolist() == [[0, 1], [0, 3], [1, 2], [2, 3]]
    assert closed.lengths(closed.points[None]).tolist() == [8.0]


def test_single_point_is_a_germ_without_cells():
    germ = Germ.polyline([(3, 4)])
    assert germ.lines == germ.faces == ()
    assert germ.segments.shape == (0, 2)


def test_polylines_keep_their_own_points_and_drop_no_dot():
    germ = Germ.polylines([[(0, 0), (1, 1), (2, 0)], [(0.5, 0.5), (1.5, 0.5)], [(1, 2)]])
    assert len(germ.points) == 6
    assert [block.tolist() for block in germ.lines] == [[[3, 4]], [[0, 1, 2]]]


def test_measures_of_a_pyramid_of_two_sizes_of_face():
    germ = Germ.mesh(PYRAMID, PYRAMID_FACES)
    copies = np.stack([germ.points, 10 * germ.points + 1000])
    assert np.abs(germ.volumes(copies) / [4.0, 4000.0] - 1).max() <= 1e-14
    areas = np.array([1.0, 100.0]) * (4 + 4 * np.sqrt(10))
    assert np.abs(germ.areas(copies) / areas - 1).max() <= 1e-14
    assert len(germ.segments) == 8


def test_volume_of_a_mirrored_copy_is_positive():
    germ = Germ.mesh(PYRAMID, PYRAMID_FACES)
    assert np.abs(germ.volumes((germ.points * [1, 1, -1])[None]) - 4).max() <= 1e-14


def test_area_of_a_concave_polygon_in_the_plane_and_in_space():
    germ = Germ.polygon(ARROW)
    upright = np.column_stack([np.zeros(5), germ.points])
    assert germ.areas(germ.points[None]).tolist() == [7.0]
    assert germ.areas(upright[None]).tolist() == [7.0]


def test_measures_far_from_the_origin_keep_their_digits():
    germ = Germ.mesh(PYRAMID, PYRAMID_FACES)
    far = 7 * germ.points + 3.0**32  # whole numbers still, but products of them lose digits
    assert germ.volumes(far[None]) == pytest.approx([4 * 7**3], rel=1e-14)
    assert germ.areas(far[None]) == pytest.approx([(4 + 4 * np.sqrt(10)) * 7**2], rel=1e-14)


def test_repeated_shifts_the_cells_copy_by_copy():
    germ = Germ([(0, 0), (1, 0), (0, 1)], lines=[(0, 1)], faces=[(0, 1, 2)])
    both = germ.repeated(np.stack([germ.points, germ.points + 5]))
    assert both.points[3:].tolist() == [[5, 5], [6, 5], [5, 6]]
    assert both.lines[0].tolist() == [[0, 1], [3, 4]]
    assert both.faces[0].tolist() == [[0, 1, 2], [3, 4, 5]]


def test_sampled_points_are_as_near_as_wanted_and_on_the_edges():
    germ = Germ.polygon([(0, 0), (1, 0), (1, 0.3)])
    points = germ.sampled(0.11).points
    # 1 / 0.11 -> 10 parts, 0.3 / 0.11 -> 3, 1.044 / 0.11 -> 10.
    assert points[:3].tolist() == germ.points.tolist()
    assert len(points) == 3 + 9 + 2 + 9
    below = points[points[:, 1] == 0]
    assert np.sort(below[:, 0]) == pytest.approx(np.arange(11) / 10, abs=1e-15)
    slanted = points[(points[:, 0] < 1) & (points[:, 1] > 0)]
    assert np.abs(slanted[:, 1] - 0.3 * slanted[:, 0]).max() <= 1e-15


def test_cells_come_from_arrays_or_lists_alike():
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    one, other = Germ.mesh(SQUARE, triangles), Germ.mesh(SQUARE, triangles.tolist())
    assert [f.tolist() for f in one.faces] == [f.tolist() for f in other.faces]
    assert Germ.mesh(SQUARE, np.empty((0, 3), dtype=int)).faces == ()


def test_germ_is_read_only():
    germ = Germ.polygon(SQUARE)
    with pytest.raises(ValueError, match="read-only"):
        germ.points[0] = 1
    with pytest.raises(ValueError, match="read-only"):
        germ.faces[0][0] = 1


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Germ([]), "at least one point"),
        (lambda: Germ([1, 2]), "at least one point"),
        (lambda: Germ([[(0, 0)], [(0, 0), (1, 1)]]), r"Germ\.polylines"),
        (lambda: Germ([(0, 0), (np.nan, 0)]), r"rows \[1\]"),
        (lambda: Germ(SQUARE, lines=[(0,)]), "A line must be at least 2"),
        (lambda: Germ(SQUARE, faces=[(0, 1)]), "A face must be at least 3"),
        (lambda: Germ(SQUARE, faces=[(0.0, 1.0, 2.0)]), "whole numbers"),
        (lambda: Germ(SQUARE, faces=[(0, 1, 4)]), "points 0 to 3, got 0 to 4"),
        (lambda: Germ(SQUARE, lines=[(-1, 1)]), "points 0 to 3, got -1 to 1"),
        (lambda: Germ.polylines([]), "at least one"),
        (
            lambda: Germ.polylines([[(0, 0)], [(0, 0, 0)]]),
            "must all be in the plane or all in space",
        ),
        (lambda: Germ.polygon(SQUARE).sampled(0), "must be positive"),
        (lambda: Germ.polygon(SQUARE).sampled(np.nan), "must be positive"),
        (lambda: Germ.polygon(SQUARE).with_points(SQUARE[:3]), "has 4 points, got 3"),
    ],
)
def test_germ_refuses_what_cannot_be_meant(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_sampling_too_fine_for_memory_is_refused():
    with pytest.raises(SizeError, match="further apart"):
        Germ.polygon(SQUARE).sampled(1e-12)
