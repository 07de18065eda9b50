"""Affine maps taken apart: scales, rotations, mirrors, and shapes that copies share."""

import numpy as np
import pytest
from figure_strategies import affine_maps, dimensions, similarities
from hypothesis import given
from hypothesis import strategies as st

from ifs_cad.design.affine import Placements, homogeneous, read_affine, read_maps
from ifs_cad.errors import AddressError, InputError

TURN = np.array([[0.6, -0.8], [0.8, 0.6]])


def placements(maps):
    return Placements(read_maps(maps), tuple(str(number) for number in range(len(maps))))


def mirror(placed):
    """M of each map: the last axis turned round, or nothing."""
    matrices = np.tile(np.eye(placed.ndim), (len(placed), 1, 1))
    matrices[placed.mirrored, -1, -1] = -1
    return matrices


@given(dimensions.flatmap(affine_maps))
def test_every_map_is_rotation_times_mirror_times_stretch(maps):
    placed = placements(maps)
    unit = np.eye(placed.ndim)
    turned, stretches = placed.rotations, placed.stretches
    assert np.abs(turned @ mirror(placed) @ stretches - placed.linear).max() <= 1e-13
    assert np.abs(turned @ turned.swapaxes(1, 2) - unit).max() <= 1e-13
    assert np.abs(np.linalg.det(turned) - 1).max() <= 1e-13
    assert np.abs(stretches - stretches.swapaxes(1, 2)).max() <= 1e-13
    assert np.linalg.eigvalsh(stretches).min() >= -1e-14
    determinants = np.linalg.det(placed.linear)
    volumes = np.where(placed.mirrored, -1, 1) * placed.scales**placed.ndim
    assert np.abs(volumes - determinants).max() <= 1e-13


@given(dimensions.flatmap(similarities))
def test_similarities_tell_their_scale_and_share_one_shape_for_each_scale(drawn):
    maps, scales = drawn
    placed = placements(maps)
    assert placed.is_similarity
    assert np.abs(placed.scales / scales - 1).max() <= 1e-13
    assert np.abs(placed.factors / scales - 1).max() <= 1e-13
    assert (placed.mirrored == (np.linalg.det(maps[:, :, :-1]) < 0)).all()
    same = np.abs(scales[:, None] / scales - 1) <= 1e-12
    same &= placed.mirrored[:, None] == placed.mirrored
    shared = placed.shapes().of
    assert ((shared[:, None] == shared) >= same).all()


@given(dimensions.flatmap(affine_maps), st.data())
def test_a_copy_is_its_shape_turned_and_moved(maps, data):
    order = data.draw(st.permutations([*range(len(maps)), *range(len(maps))]))
    placed = placements(np.array(maps)[order])
    germ = np.vstack([np.zeros(placed.ndim), np.eye(placed.ndim), np.ones(placed.ndim)])
    shapes = placed.shapes()
    assert len(shapes.matrices) <= len(maps)
    made = germ @ shapes.matrices.swapaxes(1, 2)
    put = made[shapes.of] @ placed.rotations.swapaxes(1, 2) + placed.translations[:, None]
    assert np.abs(put - placed.applied(germ)).max() <= 1e-9


def test_shapes_are_numbered_as_they_come_and_mirrored_ones_apart():
    half = 0.5 * np.eye(2)
    linear = np.array([half, 0.5 * TURN, 0.5 * TURN @ np.diag([1, -1]), 0.25 * TURN, half])
    shapes = placements(homogeneous(linear, np.zeros((5, 2)))).shapes()
    assert shapes.of.tolist() == [0, 0, 1, 2, 0]
    expected = [half, np.diag([0.5, -0.5]), 0.25 * np.eye(2)]
    assert np.abs(shapes.matrices - expected).max() <= 1e-15


def test_sheared_copies_share_a_shape_when_only_turned():
    shear = np.array([[1.0, 0.5], [0.0, 1.0]])
    placed = placements(homogeneous(np.array([shear, TURN @ shear, shear @ TURN]), np.ones((3, 2))))
    assert not placed.similar.any()
    assert placed.shapes().of.tolist() == [0, 0, 1]


def test_maps_that_flatten_are_no_similarities():
    flat = np.array([[[0.0, 0.0, 1.0], [0.0, 0.16, 2.0]], [[0.0, 0.0, 3.0], [0.0, 0.0, 4.0]]])
    placed = placements(flat)
    assert placed.similar.tolist() == [False, False]
    assert placed.scales.tolist() == [0, 0]
    assert placed.factors.tolist() == [0.16, 0]
    assert placed.applied([(5, 6)]).tolist() == [[[1, 2.96]], [[3, 4]]]
    assert np.isfinite(placed.shapes().matrices).all()


def test_maps_of_one_point_share_a_shape():
    assert placements(homogeneous(np.zeros((2, 3, 3)), np.eye(2, 3))).shapes().of.tolist() == [0, 0]


@given(similarities(2))
def test_similarities_of_the_plane_stay_such_in_space(drawn):
    placed = placements(drawn[0])
    lifted = placed.in_space()
    assert lifted.is_similarity
    assert lifted.in_space() is lifted
    assert lifted.addresses == placed.addresses
    assert np.abs(lifted.scales / placed.scales - 1).max() <= 1e-13
    points = lifted.applied([(1, 2, 0), (1, 2, 1)])
    assert (
        np.abs(points[:, 0] - np.pad(placed.applied([(1, 2)])[:, 0], ((0, 0), (0, 1)))).max()
        <= 1e-12
    )
    assert np.abs(points[:, 1, 2] - placed.scales).max() <= 1e-14


def test_placements_are_found_by_address():
    placed = Placements(read_maps([np.eye(2, 3), 2 * np.eye(2, 3)]), ("00", "01"))
    assert placed["01"].tolist() == [[2, 0, 0], [0, 2, 0], [0, 0, 1]]
    with pytest.raises(AddressError, match=r"'02'; there are 2, from '00' to '01'"):
        placed["02"]


def test_maps_are_read_with_and_without_their_last_row():
    short = np.arange(12.0).reshape(2, 2, 3)
    full = read_maps(short)
    assert full[:, -1].tolist() == [[0, 0, 1]] * 2
    assert read_maps(full).tolist() == full.tolist()
    assert read_maps(np.ones((1, 3, 4))).shape == (1, 4, 4)


def test_last_row_is_made_exact():
    noisy = read_maps(np.eye(3)[None] + 1e-14)
    assert noisy[0, -1].tolist() == [0, 0, 1]


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (np.eye(3), r"got shape \(3, 3\)"),
        (np.empty((0, 3, 3)), r"got shape \(0, 3, 3\)"),
        (np.zeros((2, 4, 5)), r"got shape \(2, 4, 5\)"),
        (np.zeros((2, 3, 2)), r"got shape \(2, 3, 2\)"),
        (np.zeros((2, 1, 1)), r"got shape \(2, 1, 1\)"),
        ([np.eye(3), np.eye(4)], "not all of one shape"),
        ("maps", "not numbers"),
        ([np.eye(2, 3), np.full((2, 3), np.nan)], "of 2, these are not: T_2"),
    ],
)
def test_maps_of_other_shapes_are_refused(value, message):
    with pytest.raises(InputError, match=message):
        read_maps(value)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (np.eye(3, 4), "of 2 dimensions"),
        ([[1, 0, 0], [0, 1, 0], [1, 0, 1]], "last row"),
        ([[1, 0, 0], [1, 0, 0]], "flattens"),
        ([[0, 0, 0], [0, 0, 0]], "flattens"),
        ([[1, 0, 0], [0, np.inf, 0]], "finite"),
    ],
)
def test_one_map_that_cannot_be_undone_is_refused(value, message):
    with pytest.raises(InputError, match=message):
        read_affine(value, 2)


@pytest.mark.parametrize(
    ("matrices", "addresses", "message"),
    [
        (np.eye(3)[None], ("0", "1"), "1 placements need as many addresses, got 2"),
        (np.full((1, 3, 3), 1 / 3), ("0",), "homogeneous matrices"),
        (np.eye(2)[None], ("0",), "homogeneous matrices"),
    ],
)
def test_placements_refuse_what_does_not_place(matrices, addresses, message):
    with pytest.raises(InputError, match=message):
        Placements(matrices, addresses)


def test_placements_copy_points_of_their_own_dimension():
    with pytest.raises(InputError, match=r"points of 2 numbers each, got shape \(1, 3\)"):
        placements([np.eye(2, 3)]).applied([(1, 2, 3)])
