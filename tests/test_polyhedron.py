"""Convex polyhedra in arrays: prismatoids and clipping."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles import corners_by_half_spaces, hull_volume, planes_of, points_of
from strategies import numbers

from ifs_cad.elements.polyhedron import Kind, Prismatoids, clip, joined, offsets, ranges

TOP = np.array([0.0, 0.0, 1.0])


def boxes(*sizes, at=(0.0, 0.0, 0.0)):
    """Return axis-parallel boxes with one corner at a point each, as prismatoids."""
    square = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], dtype=float)
    base, tops = [], []
    for size in sizes:
        plan = np.column_stack([square * size[:2], np.zeros(4)]) + at
        base.append(plan)
        tops.append(plan + np.array([0, 0, size[2]]))
    count = len(sizes)
    # the side that ends in corner k comes from corner k - 1
    inward = np.array([(1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0)], dtype=float)
    return Prismatoids(
        lower=np.concatenate(base),
        upper=np.concatenate(tops),
        side_normals=np.tile(inward, (count, 1)),
        kinds=np.full(4 * count, int(Kind.BORDER)),
        mates=np.full(4 * count, -1),
        solid_offsets=np.arange(count + 1) * 4,
        normals=np.tile(TOP, (count, 1)),
    )


def require_closed(solids):
    """Assert what every closed convex polyhedron fulfils."""
    for number in range(len(solids)):
        planes, points = planes_of(solids, number), points_of(solids, number)
        heights = points @ planes[:, :3].T - planes[:, 3]
        assert heights.max() < 1e-9 * max(1, np.abs(points).max())
        faces = np.flatnonzero(solids.solid_of_face == number)
        edges = np.isin(solids.face_of_loop, faces)
        assert len(points) - edges.sum() / 2 + len(faces) == 2
        assert solids.volumes[number] == pytest.approx(hull_volume(points), rel=1e-9)
    pairs = set(zip(solids.loops.tolist(), solids.heads.tolist(), strict=True))
    assert len(pairs) == len(solids.loops)
    assert pairs == {(head, tail) for tail, head in pairs}


def test_box_has_the_volume_areas_and_planes_of_a_box():
    box = boxes((2, 3, 5)).polyhedra()
    assert box.volumes.tolist() == [30.0]
    assert sorted(box.face_areas) == [6, 6, 10, 10, 15, 15]
    assert len(box.vertices) == 8
    assert box.kinds.tolist().count(Kind.BORDER) == 4
    np.testing.assert_allclose(
        sorted(map(tuple, np.column_stack([box.normals, box.levels]))),
        sorted(
            [(-1, 0, 0, 0), (1, 0, 0, 2), (0, -1, 0, 0), (0, 1, 0, 3), (0, 0, -1, 0), (0, 0, 1, 5)]
        ),
        atol=1e-12,
    )
    require_closed(box)


def test_side_lengths_are_those_of_both_planes():
    np.testing.assert_allclose(boxes((2, 3, 5)).side_lengths, [[3, 2, 3, 2]] * 2)


@pytest.mark.parametrize("start", range(4))
def test_side_that_vanishes_on_one_plane_makes_a_triangle(start):
    # a wedge: the upper face of a box of 2 x 2 x 2 shrinks to its edge at x = 0
    box = boxes((2, 2, 2))
    lower, upper = box.lower.copy(), box.upper.copy()
    upper[1], upper[2] = upper[0], upper[3]
    slope = np.array([-1, 0, -1]) / np.sqrt(2)
    normals = box.side_normals.copy()
    normals[2] = slope
    turn = np.roll(np.arange(4), start)
    wedge = Prismatoids(
        lower[turn],
        upper[turn],
        normals[turn],
        box.kinds,
        box.mates,
        box.solid_offsets,
        box.normals,
    ).polyhedra()
    assert wedge.volumes == pytest.approx([4.0])
    # the upper face has no area: two of its four points are the others
    assert len(wedge.vertices) == 6
    assert sorted(np.bincount(wedge.face_of_loop).tolist())[-3:] == [4, 4, 4]


def test_clip_of_a_box_by_a_plane_through_its_corners_is_a_prism():
    box = boxes((2, 2, 2)).polyhedra()
    normal = np.array([[-1, -1, 0]]) / np.sqrt(2)
    half, left = clip(box, normal, np.array([-np.sqrt(2)]), Kind.RELIEF, np.array([7]))
    assert left.tolist() == [True]
    assert half.volumes == pytest.approx([4.0])
    assert len(half.vertices) == 6
    cut = half.kinds == Kind.RELIEF
    assert cut.sum() == 1
    assert half.face_areas[cut] == pytest.approx([4 * np.sqrt(2)])
    assert half.mates[cut].tolist() == [7]
    require_closed(half)


def test_clip_of_a_corner_leaves_a_triangle():
    box = boxes((2, 2, 2)).polyhedra()
    normal = -np.ones((1, 3)) / np.sqrt(3)
    rest, _ = clip(box, normal, np.array([-5 / np.sqrt(3)]), Kind.FLOOR, np.array([-1]))
    assert rest.volumes == pytest.approx([8 - 1 / 6])
    assert len(rest.vertices) == 10
    require_closed(rest)


@pytest.mark.parametrize("level", [0.0, -1.0, -np.inf])
def test_clip_by_a_plane_that_touches_or_misses_changes_nothing(level):
    box = boxes((2, 2, 2)).polyhedra()
    same, left = clip(box, TOP[None], np.array([level]), Kind.FLOOR, np.array([-1]))
    assert same is box
    assert left.all()


@pytest.mark.parametrize("level", [2.0, 3.0])
def test_clip_by_a_plane_beyond_leaves_nothing(level):
    solids = boxes((2, 2, 2), (2, 2, 9)).polyhedra()
    rest, left = clip(solids, np.tile(TOP, (2, 1)), np.full(2, level), Kind.FLOOR, np.full(2, -1))
    assert left.tolist() == [False, True]
    assert rest.volumes == pytest.approx([4 * (9 - level)])
    nothing, left = clip(
        solids.take(np.array([0])), TOP[None], np.array([level]), Kind.FLOOR, np.array([-1])
    )
    assert len(nothing) == 0
    assert not left.any()


@given(st.data(), st.integers(1, 4), st.integers(1, 6))
def test_clips_equal_the_intersection_of_half_spaces(data, count, cuts):
    sizes = data.draw(numbers((count, 3), 50, 500))
    solids = boxes(*sizes).polyhedra()
    owner = np.arange(count)
    rows = [planes_of(solids, number) * [1, 1, 1, -1] for number in range(count)]
    for _ in range(cuts):
        normals = data.draw(numbers((len(solids), 3), -1, 1))
        normals[np.linalg.norm(normals, axis=1) < 0.1] = [0, 0, 1]
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        share = data.draw(numbers((len(solids), 3), 0.1, 0.9))
        levels = np.einsum("si,si->s", normals, share * sizes[owner])
        for number, normal, level in zip(owner, normals, levels, strict=True):
            rows[number] = np.vstack([rows[number], [*-normal, level]])
        solids, left = clip(solids, normals, levels, Kind.RELIEF, np.full(len(solids), -1))
        owner = owner[left]
        if len(solids) == 0:
            return
    require_closed(solids)
    for number, mine in enumerate(owner):
        points = points_of(solids, number)
        if hull_volume(points) < 1:
            continue
        corners = corners_by_half_spaces(rows[mine], points.mean(axis=0))
        apart = np.linalg.norm(points[:, None] - corners, axis=-1)
        assert apart.min(axis=0).max() < 1e-6
        assert apart.min(axis=1).max() < 1e-6


def test_take_gives_solids_in_the_order_asked_for_even_twice():
    solids = boxes((1, 1, 1), (2, 1, 1), (3, 1, 1)).polyhedra()
    taken = solids.take(np.array([2, 0, 2]))
    assert taken.volumes.tolist() == [3, 1, 3]
    assert len(taken.vertices) == 24
    require_closed(taken)


def test_joined_takes_the_solids_of_both_in_order():
    one, other = boxes((1, 1, 1), (2, 1, 1)).polyhedra(), boxes((3, 1, 1)).polyhedra()
    assert joined(one, other, np.array([1, 2, 0])).volumes.tolist() == [2, 3, 1]


def test_ranges_and_offsets_by_hand():
    assert offsets(np.array([2, 0, 3])).tolist() == [0, 2, 2, 5]
    assert ranges(np.array([5, 1, 7]), np.array([7, 1, 10])).tolist() == [5, 6, 7, 8, 9]
    assert ranges(np.array([], dtype=int), np.array([], dtype=int)).tolist() == []
