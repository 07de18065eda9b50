"""Node axes: cut planes that meet in one line at every node of a vector sum."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import pairs_that_share_a_node, shared_balls
from strategies import (
    accepted,
    even_fold_points,
    largest_thickness,
    panel_sides,
    rings,
    shells,
    vector_sums,
)

from ifs_cad.design.mesh import Mesh
from ifs_cad.design.surface import vector_sum
from ifs_cad.elements import axes
from ifs_cad.elements.axes import node_axes
from ifs_cad.elements.polyhedron import Kind
from ifs_cad.elements.thicken import thicken
from ifs_cad.errors import GeometryError, InputError, SizeError

ROUGH_A = np.array([(0, 0, 0), (400, 0, 300), (800, 50, -100), (1200, 0, 350), (1600, 0, 0)])
ROUGH_B = np.array([(0, 0, 0), (50, 400, -150), (-50, 800, 200), (100, 1200, -50)])


def inner_half_edges(mesh):
    return np.flatnonzero(mesh.twin >= 0)


@settings(max_examples=60)
@given(shells(nodes="axis"))
def test_panels_between_node_axes_share_no_volume(shell):
    assert shared_balls(shell.solids, pairs_that_share_a_node(shell)).max(initial=0) <= 1e-6


@settings(max_examples=40)
@given(vector_sums(), panel_sides)
def test_no_thickness_that_fits_makes_panels_collide_or_need_relief(mesh, side):
    thickness = min(500.0, largest_thickness(mesh, side=side, nodes="axis"))
    assume(thickness > 0)
    shell = thicken(mesh, thickness, side=side, nodes="axis")
    assert not (shell.solids.kinds == Kind.RELIEF).any()
    assert shared_balls(shell.solids, pairs_that_share_a_node(shell)).max(initial=0) <= 1e-6


@given(vector_sums())
def test_axes_are_a_mesh_with_parallel_edges(mesh):
    towards = accepted(node_axes, mesh)
    change = towards[mesh.corners[mesh.next]] - towards[mesh.corners]
    aside = np.cross(change, mesh.directions)
    assert np.abs(aside).max() < 1e-7 * max(1.0, np.abs(towards).max())


@given(vector_sums())
def test_axes_fit_the_normals_best_among_parallel_meshes(mesh):
    towards = accepted(node_axes, mesh)
    normals = mesh.normals[mesh.face]
    rest = np.einsum("ci,ci->c", normals, towards[mesh.corners]) - 1
    # moved by any vector, scaled, or moved towards the design itself, they would fit no better
    middle = mesh.vertices.mean(axis=0)
    scaled = (mesh.vertices - middle) / np.abs(mesh.vertices - middle).max()
    for other in (*np.eye(3)[:, None] * np.ones((len(scaled), 1)), towards, scaled):
        slope = rest @ np.einsum("ci,ci->c", normals, other[mesh.corners])
        assert abs(slope) < 1e-7 * len(rest) * max(1.0, np.abs(other).max() ** 2)


@given(vector_sums())
def test_cut_planes_hold_the_axes_at_both_ends_of_their_edge(mesh):
    shell = accepted(thicken, mesh, 0.001, nodes="axis")
    towards = node_axes(mesh)
    inner = inner_half_edges(mesh)
    cuts = shell.cuts[inner]
    scale = max(1.0, np.abs(towards).max())
    for node in (mesh.corners[inner], mesh.corners[mesh.next[inner]]):
        heights = np.einsum("ci,ci->c", cuts, towards[node])
        assert np.abs(heights).max(initial=0) < 1e-7 * scale
    along = np.einsum("ci,ci->c", cuts, mesh.directions[inner])
    assert np.abs(along).max(initial=0) < 1e-9


def test_axes_of_an_exact_design_fit_without_rest_and_leave_no_lip():
    arch = np.array([(0, 0, 0), (0, 300, 900), (0, 1400, 1400), (0, 2400, 800)])
    fold = even_fold_points([(0, 0), (700, 250), (1500, 100)], 0.8)
    mesh = vector_sum(arch, fold)
    towards = node_axes(mesh)
    heights = np.einsum("ci,ci->c", mesh.normals[mesh.face], towards[mesh.corners])
    np.testing.assert_allclose(heights, 1, atol=1e-9)
    assert thicken(mesh, 20, nodes="axis").node_gaps.max() < 1e-8


def test_axes_leave_a_lip_but_no_relief_where_bisectors_need_it():
    mesh = vector_sum(ROUGH_A, ROUGH_B)
    bisected, shell = (thicken(mesh, 21, nodes=nodes) for nodes in ("relief", "axis"))
    assert (bisected.solids.kinds == Kind.RELIEF).any()
    assert not (shell.solids.kinds == Kind.RELIEF).any()
    assert shell.node_gaps.max() > 0.01
    assert shared_balls(shell.solids, pairs_that_share_a_node(shell)).max() <= 1e-6


@given(rings(1), st.booleans())
def test_axes_of_a_tube_have_no_seam(ring, torus):
    angles = np.arange(6) * 2 * np.pi / 5
    other = 150 * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    other[-1] = other[0]
    line = other if torus else [(0, 0, 0), (0, 700, 0), (0, 1500, 200)]
    mesh = accepted(vector_sum, ring, line)
    towards = accepted(node_axes, mesh)
    change = towards[mesh.corners[mesh.next]] - towards[mesh.corners]
    aside = np.cross(change, mesh.directions)
    assert np.abs(aside).max() < 1e-7 * max(1.0, np.abs(towards).max())


def test_shell_without_a_panel_keeps_the_cut_planes_of_the_others():
    mesh = vector_sum(ROUGH_A, ROUGH_B, addresses="lexicographic")
    whole = thicken(mesh, 21, nodes="axis")
    door = whole.without(["1.1", "2.1"])
    assert shared_balls(door.solids, pairs_that_share_a_node(door)).max() <= 1e-6
    kept = [mesh.addresses.index(address) for address in door.addresses]
    corners = np.concatenate([np.flatnonzero(mesh.face == face) for face in kept])
    inner = door.mesh.twin >= 0
    np.testing.assert_allclose(door.cuts[inner], whole.cuts[corners][inner], atol=1e-12)
    # and so on: without a further panel
    smaller = door.without("0.0")
    assert len(smaller) == len(mesh) - 3
    assert smaller["3.2"].volume == pytest.approx(whole["3.2"].volume, rel=1e-12)


@given(vector_sums())
def test_flipped_mesh_has_the_same_panels_on_its_other_side(mesh):
    shell = accepted(thicken, mesh, 5, nodes="axis", side="outer")
    flipped = accepted(thicken, mesh.flipped(), 5, nodes="axis", side="inner")
    # nearly flat designs leave the axes undetermined, which magnifies rounding
    np.testing.assert_allclose(flipped.volumes, shell.volumes, rtol=1e-6)


def test_mesh_that_is_no_vector_sum_is_refused():
    mesh = Mesh([(0, 0, 0), (100, 0, 0), (0, 100, 0)], [[0, 1, 2]])
    with pytest.raises(InputError, match="lattice of a vector sum"):
        thicken(mesh, 1, nodes="axis")


def test_fit_that_does_not_fit_in_memory_is_refused_before_it_starts(monkeypatch):
    monkeypatch.setattr(axes, "MEMORY_LIMIT", 2**10)
    with pytest.raises(SizeError, match="4 x 3 faces") as caught:
        node_axes(vector_sum(ROUGH_A, ROUGH_B))
    assert caught.value.values["bytes"] > 2**10


def test_design_whose_axes_would_lie_in_a_face_is_refused_naming_it():
    mesh = vector_sum(
        [(0, 0, 0), (500, 0, 0), (500, 200, -100), (1000, 200, 300)],
        [(0, 0, 0), (600, 600, -100), (-300, 800, -200)],
    )
    with pytest.raises(GeometryError, match="No node axes rise") as caught:
        thicken(mesh, 1, nodes="axis")
    assert caught.value.addresses == ("2",)
