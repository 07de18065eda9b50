"""Outlines of grooves against closed forms, distances to the strokes and shapely."""

import itertools
import string

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import LineString, Point, Polygon, union_all
from shapely.affinity import translate

from ifs_cad.elements.arcs import Path, area, distance_to_strokes, perimeter, winding
from ifs_cad.elements.glyph import CHARACTERS, MAX_CUTTER_RATIO, glyph
from ifs_cad.elements.groove import Groove, groove, outline
from ifs_cad.errors import InputError, LabelError
from ifs_cad.tolerance import DEFAULT

WRITTEN = CHARACTERS.strip()
RATIOS = (0.02, 0.1, 0.15, 0.175, 0.2, MAX_CUTTER_RATIO)
STEPS = 256
"""Chords of a full turn in polygons."""


def line(*points):
    return Path(np.array(points, dtype=float), np.zeros(len(points) - 1))


def circle(radius, centre=(0.0, 0.0)):
    poles = np.array([(radius, 0.0), (-radius, 0.0)]) + centre
    return Path(poles, np.ones(2), closed=True)


def segments(path):
    following = np.roll(path.vertices, -1, axis=0)
    return [
        Path(np.array([start, end]), np.array([bulge]))
        for start, end, bulge in zip(path.vertices, following, path.bulges, strict=False)
    ]


def polyline(path):
    """Return the points of a path with arcs in chords, by plain complex arithmetic."""
    points = [complex(*path.vertices[0])]
    for segment in segments(path):
        start, end = (complex(*vertex) for vertex in segment.vertices)
        sweep = 4 * np.arctan(segment.bulges[0])
        if sweep == 0:
            points.append(end)
            continue
        centre = (start + end) / 2 + 0.5j * (end - start) / np.tan(sweep / 2)
        count = int(np.ceil(abs(sweep) / (2 * np.pi) * STEPS))
        turns = np.exp(1j * sweep * np.arange(1, count + 1) / count)
        points.extend(centre + (start - centre) * turns)
    return [(point.real, point.imag) for point in points]


def buffered(strokes, radius):
    """Return shapely's polygon of all points within the radius of the strokes.

    One segment at a time: shapely leaves out the round end where a path turns straight back.
    """
    shapes = [Point(s.vertices[0]) for s in strokes if len(s.vertices) == 1]
    shapes += [LineString(polyline(part)) for s in strokes for part in segments(s)]
    return union_all([shape.buffer(radius, quad_segs=STEPS // 4) for shape in shapes])


def as_polygons(groove):
    return union_all(
        [
            Polygon(polyline(region.outer), [polyline(island) for island in region.islands])
            for region in groove.regions
        ]
    )


def assert_outline(result, strokes, radius):
    """Check the outline against everything it must be."""
    assert isinstance(result, Groove)
    middles = []
    for region in result.regions:
        assert area(region.outer) > 0
        for island in region.islands:
            assert area(island) < 0
            assert winding(region.outer, island.vertices[:1]).tolist() == [1]
        for loop in region.loops:
            lengths = [perimeter(segment) for segment in segments(loop)]
            assert min(lengths) >= DEFAULT.sliver
            sweeps = np.abs(loop.sweeps)
            assert (sweeps < 2 * np.pi).all()
            chord = np.diff(np.vstack([loop.vertices, loop.vertices[:1]]), axis=0)
            sagitta = chord[:, ::-1] * (1, -1) * loop.bulges[:, None] / 2
            middles.append(loop.vertices + chord / 2 + sagitta)
            middles.append(loop.vertices)
    on_outline = np.concatenate(middles)
    off = np.abs(distance_to_strokes(strokes, on_outline) - radius)
    assert off.max() < DEFAULT.sliver
    # A polygon with n chords a turn lacks less than (pi/n)^2 of an arc's radius in depth.
    depth = 2 * (np.pi / STEPS) ** 2 * (radius + 20)
    wanted = buffered(strokes, radius)
    assert abs(result.area - wanted.area) <= depth * result.perimeter
    assert len(result.regions) == len(getattr(wanted, "geoms", [wanted]))


def inside(groove, points):
    return sum(winding(loop, points) for loop in groove.loops) == 1


def face_count(groove):
    islands = sum(len(region.islands) for region in groove.regions)
    return groove.wall_count + len(groove.regions) + islands


def test_outline_of_a_line_is_a_stadium():
    (region,) = outline([line((1, 2), (4, 6))], 0.5).regions
    assert region.islands == ()
    assert sorted(region.outer.bulges.round(12).tolist()) == [0, 0, 1, 1]
    assert area(region.outer) == pytest.approx(5 + np.pi / 4, rel=1e-14)
    assert perimeter(region.outer) == pytest.approx(10 + np.pi, rel=1e-14)


def test_outline_of_a_dot_is_a_circle_of_two_arcs():
    result = outline([Path(np.array([(3.0, 4.0)]), np.zeros(0))], 1.5)
    assert result.wall_count == 2
    assert result.area == pytest.approx(2.25 * np.pi, rel=1e-14)


def test_outline_of_a_circle_is_a_ring_with_an_island():
    result = outline([circle(5)], 1)
    (region,) = result.regions
    (island,) = region.islands
    assert result.wall_count == 4
    assert area(region.outer) == pytest.approx(36 * np.pi, rel=1e-14)
    assert area(island) == pytest.approx(-16 * np.pi, rel=1e-14)
    assert result.perimeter == pytest.approx(20 * np.pi, rel=1e-14)


@pytest.mark.parametrize("radius", [1.0, 1.2, 3.0])
def test_island_vanishes_under_a_cutter_as_wide_as_the_circle(radius):
    (region,) = outline([circle(1)], radius).regions
    assert region.islands == ()
    assert area(region.outer) == pytest.approx(np.pi * (1 + radius) ** 2, rel=1e-14)


@pytest.mark.parametrize("radius", [1.0, 1.3])
def test_island_vanishes_between_straight_strokes(radius):
    square = Path(np.array([(0.0, 0.0), (2, 0), (2, 2), (0, 2)]), np.zeros(4), closed=True)
    (region,) = outline([square], radius).regions
    assert region.islands == ()
    wanted = 4 + 8 * radius + np.pi * radius**2
    assert area(region.outer) == pytest.approx(wanted, rel=1e-14)


def test_corner_is_rounded_outside_and_sharp_inside():
    result = outline([line((0, 4), (0, 0), (6, 0))], 1)
    assert result.wall_count == 7
    assert result.area == pytest.approx(20 - 1 + np.pi / 4 + np.pi, rel=1e-14)


def test_crossing_strokes_count_their_overlap_once():
    result = outline([line((-5, 0), (5, 0)), line((0, -3), (0, 3))], 1)
    assert result.wall_count == 12
    assert result.area == pytest.approx(20 + 12 - 4 + 2 * np.pi, rel=1e-14)


def test_stroke_that_ends_on_another_leaves_its_far_wall_whole():
    result = outline([line((0, -3), (0, 3)), line((0, 0), (5, 0))], 1)
    assert result.wall_count == 3 + 2 + 2 + 1
    assert result.area == pytest.approx(12 + np.pi + 2 * 4 + np.pi / 2, rel=1e-14)


def test_repeated_and_overlapping_strokes_change_nothing():
    once = outline([line((0, 0), (5, 0))], 1)
    again = outline([line((0, 0), (5, 0)), line((4, 0), (1, 0)), line((0, 0), (3, 0))], 1)
    assert again.wall_count == once.wall_count
    assert again.area == pytest.approx(once.area, rel=1e-14)


def test_ring_within_a_ring_is_a_region_of_its_own():
    result = outline([circle(8), circle(3)], 1)
    small, large = result.regions
    assert area(small.outer) == pytest.approx(16 * np.pi)
    assert area(large.outer) == pytest.approx(81 * np.pi)
    assert area(small.islands[0]) == pytest.approx(-4 * np.pi)
    assert area(large.islands[0]) == pytest.approx(-49 * np.pi)


@pytest.mark.parametrize(
    "strokes",
    [
        [line((0, 0), (5, 0)), line((0, 2), (5, 2))],
        [line((0, 0), (5, 0)), line((0, 2), (0, 5))],
    ],
)
def test_grooves_that_just_touch_are_refused(strokes):
    with pytest.raises(LabelError, match="just touch"):
        outline(strokes, 1)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("character", WRITTEN)
def test_outline_of_every_character_agrees_with_shapely(character, ratio):
    height = 20.0
    strokes = [path.scaled(height) for path in glyph(character).paths]
    result = groove(character, height, ratio * height)
    assert_outline(result, strokes, ratio * height / 2)
    wanted = buffered(strokes, ratio * height / 2)
    apart = as_polygons(result).symmetric_difference(wanted).area
    assert apart < 2e-3 * result.area


points = st.tuples(*[st.integers(0, 8).map(float)] * 2)
bulges = st.sampled_from([0.0, 0.0, np.tan(np.pi / 8), -np.tan(np.pi / 8), 1.0, -1.0, 0.3, -2.0])


@st.composite
def paths(draw):
    """Draw strokes on a grid: full of tangencies, retraced lines and shared ends."""
    vertices = draw(st.lists(points, min_size=1, max_size=4))
    kept = [vertices[0]]
    kept += [b for a, b in itertools.pairwise(vertices) if a != b]
    closed = len(kept) > 2 and kept[0] != kept[-1] and draw(st.booleans())
    count = len(kept) - (not closed)
    return Path(np.array(kept), np.array([draw(bulges) for _ in range(count)]), closed)


@given(st.lists(paths(), min_size=1, max_size=3), st.sampled_from([0.1, 0.37, 0.5, 0.77, 1.5]))
def test_outline_of_any_strokes_is_exact_or_refused(strokes, radius):
    try:
        result = outline(strokes, radius)
    except LabelError as refusal:
        where = [refusal.values["point"]]
    else:
        assert_outline(result, strokes, radius)
        where = [result.regions[0].outer.vertices[0]]
    (distance,) = distance_to_strokes(strokes, where)
    assert distance == pytest.approx(radius, abs=DEFAULT.sliver)


@given(
    st.sampled_from(WRITTEN),
    st.floats(0.02, MAX_CUTTER_RATIO),
    st.lists(st.tuples(st.floats(-3, 13), st.floats(-6, 13)), min_size=20, max_size=40),
)
def test_point_is_inside_exactly_when_a_stroke_is_nearer_than_the_radius(character, ratio, points):
    strokes = [path.scaled(10) for path in glyph(character).paths]
    distance = distance_to_strokes(strokes, points)
    decided = np.abs(distance - 5 * ratio) > DEFAULT.sliver
    found = inside(groove(character, 10.0, 10 * ratio), points)
    np.testing.assert_array_equal(found[decided], (distance < 5 * ratio)[decided])


@given(st.sampled_from(WRITTEN), st.floats(0.02, MAX_CUTTER_RATIO), st.floats(3.0, 80.0))
def test_counters_stay_open_under_every_permitted_cutter(character, ratio, height):
    thin, wide = groove(character, 10.0, 0.2), groove(character, height, ratio * height)
    assert len(wide.regions) == len(thin.regions)
    assert len(wide.loops) == len(thin.loops)


@given(st.floats(0.02, MAX_CUTTER_RATIO), st.floats(3.0, 80.0))
def test_digits_take_few_faces_under_every_permitted_cutter(ratio, height):
    counts = [face_count(groove(digit, height, ratio * height)) for digit in string.digits]
    assert counts == [10, 8, 10, 8, 12, 11, 8, 8, 9, 8]


@pytest.mark.parametrize("pair", ["0O", "1I", "1l", "17", "Il", "5S", "2Z", "8B", "69", "0D", "4A"])
def test_characters_that_are_often_confused_differ_clearly(pair):
    height = 10.0
    one, other = (as_polygons(groove(c, height, MAX_CUTTER_RATIO * height)) for c in pair)
    apart = min(
        one.symmetric_difference(translate(other, shift)).area
        for shift in np.linspace(-height, height, 81)
    )
    assert apart > 0.15 * min(one.area, other.area)


def test_widest_grooves_of_neighbours_keep_a_tenth_of_the_height_apart():
    height = 10.0
    grooves = {c: groove(c, height, MAX_CUTTER_RATIO * height) for c in WRITTEN}
    shapes = {c: as_polygons(g) for c, g in grooves.items()}
    for left in WRITTEN:
        for right in WRITTEN:
            placed = translate(shapes[right], glyph(left).advance * height)
            assert shapes[left].distance(placed) > 0.1 * height - 1e-3


def test_space_has_no_groove():
    assert groove(" ", 10.0, 1.0).regions == ()
    assert groove(" ", 10.0, 1.0).area == 0


def test_groove_names_the_smallest_height_for_a_wide_cutter():
    with pytest.raises(LabelError, match="at least 12 mm high") as caught:
        groove("8", 11.9, 3.0)
    assert caught.value.values["smallest_height"] == 12
    assert groove("8", 12.0, 3.0).area > 0


@pytest.mark.parametrize(
    ("height", "cutter"), [(0, 1), (-1, 1), (10, 0), (np.nan, 1), (10, np.inf)]
)
def test_groove_refuses_lengths_that_are_not_positive(height, cutter):
    with pytest.raises(InputError, match="positive"):
        groove("8", height, cutter)


@pytest.mark.parametrize(("strokes", "radius"), [([], 1.0), ([line((0, 0), (1, 0))], 0.0)])
def test_outline_refuses_nothing_to_do(strokes, radius):
    with pytest.raises(InputError, match="outline needs strokes"):
        outline(strokes, radius)


def test_groove_is_made_once():
    assert groove("8", 15.0, 3.0) is groove("8", 15.0, 3.0)


def test_polyline_oracle_follows_an_arc():
    ring = LineString(polyline(circle(2)))
    assert ring.length == pytest.approx(4 * np.pi, rel=1e-4)
