"""Solids and bores built face by face, against closed forms, qhull and the kernel's checks."""

import cadquery as cq
import numpy as np
import pytest
from brep import assert_solid, cylinders, each, planes, points
from hypothesis import given, settings
from hypothesis import strategies as st
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE
from oracles import hull_volume, planes_of, points_of
from strategies import shells
from vaults import GROUND, THICKNESS, plate, roof, vault

from ifs_cad.elements.cutting import cutting_frames
from ifs_cad.elements.polyhedron import Kind
from ifs_cad.kernel.bore import bore
from ifs_cad.kernel.solid import build_solid, location, shift


def assert_all_exact(shell):
    """Check every solid of a shell against its polyhedron, and that against qhull."""
    low, high = shell.thickening.levels
    for panel in shell:
        index = panel.index
        solid = build_solid(shell.solids, index)
        corners = points_of(shell.solids, index)
        expected = float(shell.solids.volumes[index])
        assert expected == pytest.approx(hull_volume(corners), rel=1e-9)
        assert_solid(solid, expected)

        made = np.array([(*normal, level) for normal, level, _ in planes(solid)])
        np.testing.assert_allclose(made, planes_of(shell.solids, index), rtol=0, atol=1e-8)
        sheet = np.abs(made[:, :3] @ panel.normal) > 1 - 1e-12
        assert sheet.sum() == 2
        assert made[sheet, 3].sum() == pytest.approx(shell.thickness, abs=1e-9)
        height = (points(solid) - shell.mesh.positions[panel.half_edges[0]]) @ panel.normal
        assert height.min() == pytest.approx(low, abs=1e-6)
        assert height.max() == pytest.approx(high, abs=1e-6)


@pytest.mark.parametrize("side", ["outer", "inner", "centre"])
def test_relieved_panels_are_exact_solids(side):
    shell = vault(side=side)
    assert (shell.solids.kinds == Kind.RELIEF).any()
    assert_all_exact(shell)


def test_panels_trimmed_by_a_floor_are_exact_solids():
    shell = vault(floor=GROUND)
    assert (shell.solids.kinds == Kind.FLOOR).any()
    assert_all_exact(shell)
    feet = np.concatenate([points(build_solid(shell.solids, k)) for k in range(len(shell))])
    assert feet[:, 2].min() == pytest.approx(GROUND.origin[2], abs=1e-9)


@settings(max_examples=25)
@given(shells())
def test_panels_of_any_shell_are_exact_solids(shell):
    assert_all_exact(shell)


def test_level_plate_is_a_box():
    solid = build_solid(plate(400, 300).solids, 0)
    assert_solid(solid, 400 * 300 * THICKNESS)
    assert {tuple(np.round(p, 9)) for p in points(solid)} == {
        (x, y, z) for x in (0, 400) for y in (0, 300) for z in (0, THICKNESS)
    }


@pytest.mark.parametrize("angle", [5.0, 30.0, 60.0])
def test_panel_of_a_roof_widens_by_the_tangent_of_its_angle(angle):
    shell = roof(400, 300, angle)
    half_wedge = THICKNESS * np.tan(np.radians(angle)) / 2
    for index in range(2):
        assert_solid(build_solid(shell.solids, index), (400 + half_wedge) * 300 * THICKNESS)


def test_edges_are_shared_by_the_faces_they_part():
    solid = build_solid(plate(400, 300).solids, 0)
    assert len(cq.Shape.cast(solid).Edges()) == 12
    assert len(cq.Shape.cast(solid).Vertices()) == 8
    assert len(each(solid, TopAbs_EDGE)) == 24
    assert len(each(solid, TopAbs_FACE)) == 6


def test_location_takes_the_axes_to_the_rows_it_is_given():
    turn = np.array([(0.6, 0.8, 0.0), (0.0, 0.0, 1.0), (0.8, -0.6, 0.0)])
    box = cq.Solid.makeBox(1, 1, 1).moved(cq.Location(location(turn, np.array([5.0, 6.0, 7.0]))))
    expected = [(5, 6, 7) + np.array(corner) @ turn for corner in np.ndindex(2, 2, 2)]
    made = np.unique(np.round(points(box.wrapped), 9), axis=0)
    np.testing.assert_allclose(made, np.unique(np.round(expected, 9), axis=0), atol=1e-9)


@settings(max_examples=30)
@given(
    st.floats(0.5, 40.0), st.floats(0.5, 60.0), st.sampled_from(["inner", "outer"]), st.booleans()
)
def test_bore_leaves_a_plate_less_a_cylinder(diameter, thickness, face, two):
    frames = cutting_frames(plate(400, 300, thickness), face)
    hole = bore(diameter, thickness, Kind.LOWER if face == "inner" else Kind.UPPER)
    assert hole.volume == pytest.approx(np.pi * diameter**2 / 4 * thickness, rel=1e-14)
    places = [(50, 60), (300, 200)] if two else [(50, 60)]
    solid = build_solid(frames.solids, 0, [hole.moved(shift(x, y, thickness)) for x, y in places])
    assert_solid(solid, 400 * 300 * thickness - len(places) * hole.volume)
    walls = cylinders(solid)
    assert [tuple(np.round(place[:2], 9)) for _, place, _, _ in walls] == places
    for radius, _, axis, corners in walls:
        assert radius == pytest.approx(diameter / 2, abs=1e-12)
        assert abs(axis[2]) == 1.0
        assert set(np.round(corners[:, 2], 9)) == {0.0, round(thickness, 9)}


def test_bore_is_made_once_and_moved_as_one():
    assert bore(5.0, 10.0, Kind.UPPER) is bore(5.0, 10.0, Kind.UPPER)
    hole = bore(5.0, 10.0, Kind.UPPER)
    placed = hole.moved(shift(1, 2, 3))
    assert placed.volume == hole.volume
    wall = each(placed.faces[0], TopAbs_EDGE)
    for rims in placed.rims.values():
        for rim in rims:
            (circle,) = each(rim, TopAbs_EDGE)
            partners = [edge for edge in wall if edge.IsSame(circle)]
            assert len(partners) == 1
            assert partners[0].Orientation() != circle.Orientation()
