"""How panels lie on the machine, and where tools may work, against the shapes themselves."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles import points_of
from strategies import shells
from vaults import THICKNESS, plate, roof, vault

from ifs_cad.elements.cutting import cutting_frames, work_faces
from ifs_cad.elements.polyhedron import Kind
from ifs_cad.vectors import dot

faces = st.sampled_from(["inner", "outer"])


@given(shells(), faces)
def test_every_panel_lies_flat_with_its_lower_left_corner_at_the_origin(shell, face):
    frames = cutting_frames(shell, face)
    turned = np.einsum("pij,pkj->pik", frames.axes, frames.axes)
    np.testing.assert_allclose(turned, np.broadcast_to(np.eye(3), turned.shape), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(frames.axes), 1.0, rtol=1e-12)
    for k in range(len(shell)):
        laid, placed = points_of(frames.solids, k), points_of(shell.solids, k)
        np.testing.assert_allclose(laid.min(axis=0), 0.0, rtol=0, atol=1e-9)
        assert laid[:, 2].max() == shell.thickness  # to the last digit
        back = laid @ frames.axes[k] + frames.origins[k]
        np.testing.assert_allclose(back, placed, rtol=0, atol=1e-8)
    np.testing.assert_allclose(frames.solids.volumes, shell.solids.volumes, rtol=1e-9)


@given(shells(), faces)
def test_the_marked_face_lies_on_top_and_all_planes_hold_their_corners(shell, face):
    solids = cutting_frames(shell, face).solids
    upper, lower = (Kind.LOWER, Kind.UPPER) if face == "inner" else (Kind.UPPER, Kind.LOWER)
    for kind, z in ((upper, 1.0), (lower, -1.0)):
        normals = solids.normals[solids.kinds == kind]
        assert len(normals) == len(shell)
        assert (normals == [0.0, 0.0, z]).all()
        in_face = (solids.kinds == kind)[solids.face_of_loop]
        level = shell.thickness if kind == upper else 0.0
        assert set(solids.vertices[solids.loops[in_face], 2]) == {level}  # to the last digit
    height = dot(solids.normals[solids.face_of_loop], solids.vertices[solids.loops])
    np.testing.assert_allclose(height, solids.levels[solids.face_of_loop], rtol=0, atol=1e-7)


@given(shells(), faces)
def test_text_runs_level_and_upwards_on_all_but_level_panels(shell, face):
    axes = cutting_frames(shell, face).axes
    slope = np.hypot(axes[:, 2, 0], axes[:, 2, 1])
    steep, level = slope > 0.1 + 1e-9, slope < 0.1 - 1e-9
    np.testing.assert_allclose(axes[steep, 0, 2], 0.0, atol=1e-12)
    np.testing.assert_allclose(axes[steep, 1, 2], slope[steep], atol=1e-12)
    # level panels follow the y axis of the shell
    np.testing.assert_allclose(axes[level, 0, 1], 0.0, atol=1e-12)
    assert (axes[level, 1, 1] > 0.9).all()


def test_labels_follow_another_direction_when_asked():
    axes = cutting_frames(plate(400, 300), "outer", (-2.0, 0.0, 0.0)).axes
    np.testing.assert_array_equal(axes[0], [(0, 1, 0), (-1, 0, 0), (0, 0, 1)])


def test_panels_square_to_both_directions_follow_the_third():
    upright = plate(400, 300)
    axes = cutting_frames(upright, "outer", (0.0, 0.0, 1.0)).axes
    np.testing.assert_array_equal(axes[0], np.eye(3))
    below = cutting_frames(upright, "inner").axes
    np.testing.assert_array_equal(below[0], [(-1, 0, 0), (0, 1, 0), (0, 0, -1)])


def test_level_plate_seen_from_below_is_turned_over():
    frames = cutting_frames(plate(400, 300), "inner")
    assert frames.thickness == THICKNESS
    np.testing.assert_array_equal(frames.origins[0], [400, 0, THICKNESS])


def test_work_face_of_a_plate_is_its_rectangle_at_any_depth():
    for depth in (0.0, THICKNESS):
        region = work_faces(cutting_frames(plate(400, 300), "outer"), depth)
        assert region.is_side.all()
        assert (region.kinds == Kind.BORDER).all()
        sides = {
            (*np.round(a, 12) + 0.0, c)
            for a, c in zip(region.inward[0], region.limits[0], strict=True)
        }
        assert sides == {(0, 1, 0), (-1, 0, -400), (0, -1, -300), (1, 0, 0)}


@pytest.mark.parametrize("angle", [10.0, 40.0])
@pytest.mark.parametrize("depth", [0.0, 0.5, THICKNESS])
def test_chamfer_narrows_the_work_face_only_where_it_undercuts(angle, depth):
    shell, tangent = roof(400, 300, angle), np.tan(np.radians(angle))
    for face, room in (("inner", 400), ("outer", 400 + (THICKNESS - depth) * tangent)):
        region = work_faces(cutting_frames(shell, face), depth)
        for inward, limits in zip(region.inward, region.limits, strict=True):
            down = np.abs(inward[:, 1]) > 0.5  # the sides across the slope; y runs up it
            assert down.sum() == 2
            assert -limits[down].sum() == pytest.approx(room, abs=1e-9)
            assert -limits[~down].sum() == pytest.approx(300, abs=1e-9)


@given(shells(), faces, st.floats(0.0, 1.0))
def test_work_face_lies_within_the_panel_from_the_face_to_the_depth(shell, face, share):
    frames = cutting_frames(shell, face)
    depth = share * frames.thickness
    region, solids = work_faces(frames, depth), frames.solids
    for k in range(len(shell)):
        first, last = solids.solid_offsets[k : k + 2]
        sides = np.flatnonzero(solids.kinds[first:last] > Kind.UPPER) + first
        assert region.is_side[k].sum() == len(sides)
        inward, limits = region.inward[k][region.is_side[k]], region.limits[k][region.is_side[k]]
        angles = np.unwrap(np.arctan2(inward[:, 1], inward[:, 0]))
        assert (np.diff(angles) > 0).all()
        assert angles[-1] - angles[0] < 2 * np.pi
        # a point on the line of a side touches that side's plane at the face or at the depth
        for a, limit in zip(inward, limits, strict=True):
            gaps = []
            for side in sides:
                normal = solids.normals[side]
                if normal[:2] @ a < -np.linalg.norm(normal[:2]) * (1 - 1e-9):
                    for z in (frames.thickness, frames.thickness - depth):
                        gaps.append(solids.levels[side] - normal @ [*(limit * a), z])
            assert min(gaps) == pytest.approx(0.0, abs=1e-6)


def test_some_work_faces_are_taken_as_they_are():
    region = work_faces(cutting_frames(vault()), 0.5)
    some = region.take(np.array([7, 2]))
    for name in ("inward", "limits", "is_side", "kinds"):
        np.testing.assert_array_equal(getattr(some, name), getattr(region, name)[[7, 2]])
