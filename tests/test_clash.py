"""Interference between panels."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import pairs_that_share_a_node, shared_balls
from strategies import accepted, meshes, numbers, panel_sides, shells

from ifs_cad.design.mesh import Mesh
from ifs_cad.design.surface import vector_sum
from ifs_cad.elements.clash import (
    apart,
    clashes,
    neighbours_at_nodes,
    require_disjoint,
    shared_radius,
)
from ifs_cad.elements.thicken import thicken
from ifs_cad.errors import ClashError, SelfIntersectionError

SQUARE = np.array([(0, 0, 0), (100, 0, 0), (100, 100, 0), (0, 100, 0)], dtype=float)
WILD_A = np.array([(0, 0, 0), (400, 0, 300), (800, 0, -100), (1200, 0, 350)])
WILD_B = np.array([(0, 0, 0), (150, 400, -250), (-100, 800, 200), (200, 1200, -150)])


def both(one, other):
    """Return one mesh of two squares that share no node."""
    return Mesh(np.vstack([one, other]), [[0, 1, 2, 3], [4, 5, 6, 7]], addresses=("one", "other"))


@st.composite
def doubled(draw):
    """Return shells of two copies of a mesh, one moved a little or much."""
    mesh = draw(meshes())
    move = draw(numbers(3, -1, 1)) * draw(st.sampled_from([30.0, 300.0, 3000.0]))
    turned = mesh.vertices @ np.linalg.qr(draw(numbers((3, 3), -1, 1)) + 2 * np.eye(3))[0]
    polygons = mesh.polygons()
    shifted = [[k + len(mesh.vertices) for k in polygon] for polygon in polygons]
    copy = accepted(Mesh, np.vstack([mesh.vertices, turned + move]), polygons + shifted)
    return accepted(thicken, copy, draw(st.floats(1, 40)), side=draw(panel_sides))


def by_linear_programming(shell):
    """Return the addresses of all pairs that share a ball, and its radius, trying every pair."""
    pairs = list(combinations(range(len(shell)), 2))
    radii = shared_balls(shell.solids, pairs)
    return {
        frozenset(shell.addresses[k] for k in pair): radius
        for pair, radius in zip(pairs, radii, strict=True)
    }


@settings(max_examples=30)
@given(st.one_of(shells(), shells(nodes="plain"), doubled()))
def test_clashes_are_those_of_linear_programming_over_all_pairs(shell):
    wanted = by_linear_programming(shell)
    found = {frozenset(clash.addresses): clash.radius for clash in clashes(shell)}
    for pair, radius in wanted.items():
        if radius > 2e-6:
            assert found[pair] == pytest.approx(radius, rel=1e-4, abs=1e-6)
        elif radius < 0.5e-6:
            assert pair not in found


@settings(max_examples=40)
@given(st.one_of(shells(), doubled()))
def test_shell_is_disjoint_or_refused_with_the_panels_named(shell):
    radii = by_linear_programming(shell)
    deepest = max(radii.values(), default=0)
    if deepest < 0.5e-6:
        require_disjoint(shell)
    elif deepest > 2e-6:
        with pytest.raises((ClashError, SelfIntersectionError)) as caught:
            require_disjoint(shell)
        guilty = {name for pair, radius in radii.items() if radius > 0.5e-6 for name in pair}
        assert set(caught.value.addresses) <= guilty
        assert len(caught.value.addresses) > 1
        assert 1e-6 < caught.value.values["radius"] <= deepest * (1 + 1e-4) + 1e-6


@given(shells())
def test_neighbours_at_nodes_are_all_pairs_with_a_common_vertex(shell):
    found = {tuple(pair) for pair in neighbours_at_nodes(shell).tolist()}
    assert found == set(pairs_that_share_a_node(shell))
    assert len(neighbours_at_nodes(shell)) == len(found)


def test_panels_that_meet_only_through_their_thickness_are_a_clash():
    shell = thicken(both(SQUARE, SQUARE + np.array([0, 0, 6])), 10)
    (clash,) = clashes(shell)
    assert clash.addresses == ("one", "other")
    assert clash.radius == pytest.approx(2.0)  # 4 mm of overlap
    assert not clash.share_node
    assert not clash.faces_cross
    with pytest.raises(ClashError, match="one and other share a ball of up to 2 mm") as caught:
        require_disjoint(shell)
    assert caught.value.addresses == ("one", "other")
    require_disjoint(thicken(both(SQUARE, SQUARE + np.array([0, 0, 6])), 6))


def test_panels_that_touch_share_nothing():
    shell = thicken(both(SQUARE, SQUARE + np.array([0, 0, 10])), 10)
    assert clashes(shell) == ()
    assert shared_radius(shell.solids, 0, 1) == 0.0
    assert apart(shell.solids, np.array([[0, 1]])).all()


def test_design_faces_that_cross_are_a_design_that_crosses_itself():
    upright = SQUARE[:, [2, 0, 1]] + [50, 10, -50]
    shell = thicken(both(SQUARE, upright), 4)
    (clash,) = clashes(shell)
    assert clash.faces_cross
    assert clash.radius == pytest.approx(2.0)  # in the bar of 4 x 4 mm that both share
    with pytest.raises(SelfIntersectionError, match="one and other"):
        require_disjoint(shell)


@pytest.mark.parametrize(("gap", "crosses"), [(1.0, False), (0.01, False), (-0.01, True)])
def test_design_faces_cross_only_when_they_reach_each_other(gap, crosses):
    # an upright square whose foot stands above the level one by a gap
    upright = SQUARE[:, [2, 0, 1]] + [50, 10, gap]
    (clash,) = clashes(thicken(both(SQUARE, upright), 8))
    assert clash.faces_cross == crosses


def test_design_faces_that_overlap_in_one_plane_cross():
    (clash,) = clashes(thicken(both(SQUARE, SQUARE + np.array([50, 50, 0])), 8))
    assert clash.faces_cross
    assert clash.radius == pytest.approx(4.0)


def test_collisions_at_nodes_without_relief_are_named():
    shell = thicken(vector_sum(WILD_A, WILD_B), 20, nodes="plain")
    found = clashes(shell)
    assert found
    assert all(clash.share_node and not clash.faces_cross for clash in found)
    with pytest.raises(ClashError, match=r'share a node.*nodes="relief"'):
        require_disjoint(shell)
    require_disjoint(thicken(vector_sum(WILD_A, WILD_B), 20))


def test_part_of_a_shell_is_checked_by_itself():
    shell = thicken(both(SQUARE, SQUARE + np.array([0, 0, 6])), 10)
    assert clashes(shell.part("one")) == ()


def test_coil_that_runs_through_itself_is_refused():
    turns = np.linspace(0, 4 * np.pi, 17)
    coil = np.stack([900 * np.cos(turns), 900 * np.sin(turns), 20 * turns], axis=1)
    with pytest.raises(SelfIntersectionError, match="crosses itself"):
        require_disjoint(thicken(vector_sum(coil, [(0, 0, 0), (0, 0, 300)]), 5))


def test_coil_too_thick_for_its_pitch_is_refused_and_fits_when_thinner():
    # a spiral whose turns are 100 mm apart
    turns = np.linspace(0, 4 * np.pi, 33)
    radii = 800 + 100 * turns / (2 * np.pi)
    spiral = np.stack([radii * np.cos(turns), radii * np.sin(turns), 0 * turns], axis=1)
    mesh = vector_sum(spiral, [(0, 0, 0), (0, 0, 400)])
    require_disjoint(thicken(mesh, 90))
    with pytest.raises(ClashError, match="through their thickness"):
        require_disjoint(thicken(mesh, 120))
