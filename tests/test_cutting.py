"""How panels lie on the machine, and where tools may work, against the shapes themselves."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import points_of
from strategies import accepted, shells
from vaults import THICKNESS, plate, roof, vault

from ifs_cad.design.mesh import Mesh
from ifs_cad.elements.cutting import cutting_frames, work_faces
from ifs_cad.elements.polyhedron import Kind
from ifs_cad.elements.thicken import thicken
from ifs_cad.types import Plane
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
                sine = (normal[0] * a[1] - normal[1] * a[0]) / np.linalg.norm(normal[:2])
                if normal[:2] @ a < 0 and abs(sine) < 1e-12:  # others may be almost parallel
                    for z in (frames.thickness, frames.thickness - depth):
                        gaps.append(solids.levels[side] - normal @ [*(limit * a), z])
            assert min(gaps) == pytest.approx(0.0, abs=1e-6)


def test_some_work_faces_are_taken_as_they_are():
    region = work_faces(cutting_frames(vault()), 0.5)
    some = region.take(np.array([7, 2]))
    for name in ("inward", "limits", "is_side", "kinds"):
        np.testing.assert_array_equal(getattr(some, name), getattr(region, name)[[7, 2]])


def tip(height, side="outer", lean=0.0):
    """Return what a floor at a height leaves of a pyramid 1 m high, 20 mm thick."""
    base = [(-1000, -1000, 0), (1000, -1000, 0), (1000, 1000, 0), (-1000, 1000, 0)]
    mesh = Mesh([*base, (0, 0, 1000)], [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)])
    return thicken(mesh, 20, side=side, floor=Plane((0, 0, height), (lean, 0, 1)))


def assert_laid_where_it_was(shell, face):
    frames = cutting_frames(shell, face)
    np.testing.assert_allclose(frames.solids.volumes, shell.solids.volumes, rtol=1e-9)
    for k in range(len(shell)):
        laid, placed = points_of(frames.solids, k), points_of(shell.solids, k)
        np.testing.assert_allclose(laid @ frames.axes[k] + frames.origins[k], placed, atol=1e-8)
        np.testing.assert_allclose(laid[:, :2].min(axis=0), 0.0, rtol=0, atol=1e-9)
        assert laid[:, 2].min() >= 0.0
        assert laid[:, 2].max() <= shell.thickness
    solids = frames.solids
    height = dot(solids.normals[solids.face_of_loop], solids.vertices[solids.loops])
    np.testing.assert_allclose(height, solids.levels[solids.face_of_loop], rtol=0, atol=1e-7)
    return solids


@pytest.mark.parametrize("face", ["inner", "outer"])
def test_stub_that_lost_its_inner_face_keeps_its_height_in_the_sheet(face):
    shell = tip(1005)  # the tip of the inner faces lies at 1000
    # above the floor the outer pyramid, of slope 1, has height h
    h = 1000 + 20 * 2**0.5 - 1005
    np.testing.assert_allclose(shell.volumes, (2 * h) ** 2 * h / 3 / 4, rtol=1e-9)
    solids = assert_laid_where_it_was(shell, face)
    np.testing.assert_allclose(solids.volumes, 4207.9, atol=0.05)
    # the lowest point is where the outer pyramid's axis meets the floor
    depth = h / 2**0.5
    heights = [points_of(solids, k)[:, 2] for k in range(4)]
    low, high = (20 - depth, 20.0) if face == "outer" else (0.0, depth)
    for z in heights:
        assert z.min() == pytest.approx(low, abs=1e-9)
        assert z.max() == pytest.approx(high, abs=1e-9)


@settings(max_examples=40)
@given(
    st.floats(200, 1027),
    st.floats(-0.5, 0.5),
    faces,
    st.sampled_from(["outer", "inner", "centre"]),
)
def test_stubs_of_any_floor_are_laid_where_they_were(height, lean, face, side):
    shell = accepted(tip, height, side, lean)
    assert_laid_where_it_was(shell, face)
