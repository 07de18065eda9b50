"""Meshes of planar convex polygons."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import fans, meshes, rings, triangle_meshes, vector_sums

from ifs_cad.design.mesh import Mesh
from ifs_cad.design.surface import vector_sum
from ifs_cad.errors import (
    AddressError,
    ConvexityError,
    DegenerateFaceError,
    InputError,
    ManifoldError,
    PlanarityError,
)

SQUARE = [(0, 0, 0), (4, 0, 0), (4, 3, 0), (0, 3, 0)]
# the corners of a cube of 10 mm: x + 2 y + 4 z
CUBE = [(x, y, z) for z in (0, 10) for y in (0, 10) for x in (0, 10)]
CUBE_FACES = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]]


def grid(rows, columns):
    """Return a flat vector sum of 10 mm squares, with normals upwards."""
    return vector_sum(
        [(10 * i, 0, 0) for i in range(rows + 1)],
        [(0, 10 * j, 0) for j in range(columns + 1)],
        addresses="lexicographic",
    )


def edges_of(mesh):
    """Return the set of edges, as sorted pairs of points, and those that are borders."""
    start, end = mesh.positions, mesh.positions[mesh.next]
    keys = [frozenset([tuple(a), tuple(b)]) for a, b in zip(start, end, strict=True)]
    borders = {key for key, twin in zip(keys, mesh.twin, strict=True) if twin < 0}
    return set(keys), borders


def test_twin_joins_the_two_half_edges_of_an_edge():
    mesh = Mesh([*SQUARE, (8, 0, 0), (8, 3, 0)], [[0, 1, 2, 3], [1, 4, 5, 2]])
    assert mesh.twin.tolist() == [-1, 7, -1, -1, -1, -1, -1, 1]
    assert mesh.next.tolist() == [1, 2, 3, 0, 5, 6, 7, 4]
    assert mesh.previous.tolist() == [3, 0, 1, 2, 7, 4, 5, 6]
    assert mesh.face.tolist() == [0, 0, 0, 0, 1, 1, 1, 1]
    assert mesh.neighbours(0) == ["", "f0001", "", ""]


def test_area_normal_and_centroid_of_a_rectangle_are_exact():
    mesh = Mesh(SQUARE, [[0, 1, 2, 3]])
    assert mesh.areas.tolist() == [12.0]
    assert mesh.normals.tolist() == [[0.0, 0.0, 1.0]]
    assert mesh.centroids.tolist() == [[2.0, 1.5, 0.0]]
    assert mesh.edge_lengths.tolist() == [4.0, 3.0, 4.0, 3.0]


def test_faces_of_different_sizes_live_in_one_mesh():
    mesh = Mesh([*SQUARE, (8, 1, 0)], [[0, 1, 2, 3], [1, 4, 2]])
    assert mesh.sizes.tolist() == [4, 3]
    assert mesh.areas.tolist() == [12.0, 6.0]
    assert mesh.polygons() == [[0, 1, 2, 3], [1, 4, 2]]


def test_normals_of_a_cube_point_outwards():
    mesh = Mesh(CUBE, CUBE_FACES)
    outwards = np.sign(mesh.centroids - 5)
    np.testing.assert_allclose(mesh.normals, outwards * (np.abs(mesh.centroids - 5) > 1))
    assert (mesh.valences == 3).all()
    assert (mesh.twin >= 0).all()


def test_node_pairs_are_the_diagonal_neighbours():
    mesh = grid(2, 2)
    one, other = mesh.node_pairs
    faces = np.stack([mesh.face[one], mesh.face[other]], axis=1)
    pairs = {frozenset(mesh.names(pair)) for pair in faces}
    assert pairs == {frozenset(["0.0", "1.1"]), frozenset(["0.1", "1.0"])}
    assert len(one) == 2


def test_node_pairs_of_valence_three_are_none():
    one, _ = Mesh(CUBE, CUBE_FACES).node_pairs
    assert len(one) == 0


@given(fans(valences=(4, 8)))
def test_node_pairs_of_a_fan_are_all_but_its_edges(mesh):
    valence = len(mesh)
    one, other = mesh.node_pairs
    at_the_hub = mesh.corners[one] == 0
    assert at_the_hub.sum() == valence * (valence - 1) // 2 - valence
    assert (mesh.corners[one] == mesh.corners[other]).all()


@given(st.one_of(fans(), vector_sums()))
def test_euler_number_tells_a_disc_from_a_tube(mesh):
    # counted without the neighbourhoods that the mesh works out itself
    edges, _ = edges_of(mesh)
    tube = mesh.lattice is not None and mesh.lattice[0, 0] == mesh.lattice[-1, 0]
    assert len(mesh.vertices) - len(edges) + len(mesh) == (0 if tube else 1)


@given(meshes())
def test_twins_share_the_edge_in_opposite_senses(mesh):
    inner = np.flatnonzero(mesh.twin >= 0)
    np.testing.assert_array_equal(mesh.twin[mesh.twin[inner]], inner)
    np.testing.assert_array_equal(mesh.corners[inner], mesh.corners[mesh.next[mesh.twin[inner]]])
    _, borders = edges_of(mesh)
    assert len(borders) == (mesh.twin < 0).sum()


def test_chains_of_an_open_vector_sum_are_its_four_borders():
    mesh = grid(2, 3)
    lengths = sorted(len(chain) for chain in mesh.chains)
    assert lengths == [2, 2, 3, 3]
    for chain in mesh.chains:
        assert len(np.unique(mesh.directions[chain], axis=0)) == 1


@given(rings(1), st.integers(1, 3))
def test_chains_of_a_tube_are_its_two_ends(ring, segments):
    mesh = vector_sum(ring, [(0, 3000 * k, 0) for k in range(segments + 1)])
    assert [len(chain) for chain in mesh.chains] == [len(ring.points) - 1] * 2


def test_chain_of_a_mesh_without_ends_is_the_whole_border():
    mesh = Mesh([*SQUARE, (8, 0, 0), (8, 3, 0)], [[0, 1, 2, 3], [1, 4, 5, 2]])
    assert [len(chain) for chain in mesh.chains] == [6]


def test_chains_of_a_closed_mesh_are_none():
    assert Mesh(CUBE, CUBE_FACES).chains == ()


def test_without_keeps_the_faces_that_stay_as_they_are():
    mesh = grid(3, 3)
    rest = mesh.without(["1.1", "2.?"])
    assert rest.addresses == ("0.0", "0.1", "0.2", "1.0", "1.2")
    kept = [mesh.addresses.index(address) for address in rest.addresses]
    np.testing.assert_array_equal(rest.centroids, mesh.centroids[kept])
    np.testing.assert_array_equal(rest.normals, mesh.normals[kept])
    assert rest.lattice is None


def test_without_opens_borders_that_belong_to_no_chain():
    mesh = grid(3, 3)
    rest = mesh.without("1.1")
    assert (rest.twin < 0).sum() == 12 + 4
    assert sorted(len(chain) for chain in rest.chains) == [3, 3, 3, 3]
    # a corner panel takes one edge each from two borders and opens two
    rest = mesh.without("0.0")
    assert (rest.twin < 0).sum() == 12 - 2 + 2
    assert sorted(len(chain) for chain in rest.chains) == [2, 2, 3, 3]


def test_without_keeps_a_border_one_chain_where_it_is_interrupted():
    rest = grid(3, 3).without(["1.0", "0.*"])
    lengths = [len(chain) for chain in rest.chains]
    assert sorted(lengths) == [0, 1, 2, 3]
    assert [len(chain) for chain in rest.flipped().chains] == lengths


def test_without_again_equals_without_both():
    twice = grid(3, 3).without("1.1").without("0.*")
    once = grid(3, 3).without(["1.1", "0.*"])
    assert twice.addresses == once.addresses
    np.testing.assert_array_equal(twice.vertices, once.vertices)
    np.testing.assert_array_equal(twice.corners, once.corners)
    for one, other in zip(twice.chains, once.chains, strict=True):
        np.testing.assert_array_equal(one, other)
    assert len(twice.origin[0]) == 9
    np.testing.assert_array_equal(twice.origin[0].vertices[twice.origin[1]], twice.vertices)


@given(meshes())
def test_flipped_turns_normals_and_nothing_else(mesh):
    flipped = mesh.flipped()
    np.testing.assert_allclose(flipped.normals, -mesh.normals, atol=1e-12)
    assert flipped.addresses == mesh.addresses
    assert edges_of(flipped) == edges_of(mesh)
    again = flipped.flipped()
    np.testing.assert_array_equal(again.corners, mesh.corners)


def test_with_addresses_renames_the_faces():
    mesh = grid(1, 2).with_addresses(["left", "right"])
    assert mesh.addresses == ("left", "right")
    assert mesh.neighbours(0).count("right") == 1


def test_mesh_does_not_change_with_the_arrays_it_was_made_from():
    points, faces = np.array(SQUARE, dtype=float), np.array([[0, 1, 2, 3]])
    mesh = Mesh(points, faces)
    points[0], faces[0, 0] = 99, 2
    assert mesh.vertices[0].tolist() == [0, 0, 0]
    assert mesh.corners.tolist() == [0, 1, 2, 3]
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[0] = 1


@given(triangle_meshes())
def test_area_of_a_height_field_is_that_of_its_plan_over_the_slopes(mesh):
    plan = mesh.areas * mesh.normals[:, 2]
    a, b, c = (mesh.vertices[mesh.corners.reshape(-1, 3)[:, k], :2] for k in range(3))
    shadow = np.linalg.det(np.stack([b - a, c - a], axis=1)) / 2
    np.testing.assert_allclose(plan, shadow, rtol=1e-9)


@pytest.mark.parametrize(
    ("vertices", "faces", "error", "message"),
    [
        ([(0, 0, 0), (1, 0, np.nan), (1, 1, 0)], [[0, 1, 2]], InputError, r"rows \[1\] are not"),
        ([(0, 0, 0), (1, 0, 0), (np.inf, 1, 0)], [[0, 1, 2]], InputError, r"rows \[2\] are not"),
        ([(0, 0), (1, 0), (1, 1)], [[0, 1, 2]], InputError, r"\(3, 2\)"),
        ([(0, 0, 0), (1, 0, 0)], [[0, 1, 0]], InputError, "v >= 3"),
        ([(0, 0, 0), (1, 0), (1, 1, 0)], [[0, 1, 2]], InputError, "numbers"),
        ("points", [[0, 1, 2]], InputError, "numbers"),
        (SQUARE, [], InputError, "at least one face"),
        (SQUARE, [[0, 1, 2], [0, 2]], InputError, "Face 1 has fewer than three"),
        (SQUARE, [[0, 1, 2], []], InputError, "Face 1 has fewer than three"),
        (SQUARE, [[0, 1, 2], [0, 2, 4]], InputError, r"Face 1 names a vertex outside 0\.\.3"),
        (SQUARE, [[0, 1, 2], [0, 2, -1]], InputError, "Face 1"),
        (SQUARE, np.array([[0, 1, 2.5]]), InputError, "whole"),
        (SQUARE, [["a", "b", "c"]], InputError, "whole"),
        (SQUARE, 7, InputError, "lists of vertex numbers"),
        (SQUARE, [[0, 1, 2, [3, 0]]], InputError, "lists of vertex numbers"),
        ([*SQUARE, (4, 3, 0)], [[0, 1, 2, 4, 3]], DegenerateFaceError, "coincide in f0000"),
        ([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [[0, 1, 2]], DegenerateFaceError, "f0000"),
        ([*SQUARE, (2, 0, 0)], [[0, 4, 1, 2, 3]], DegenerateFaceError, "parallel in f0000"),
        ([*SQUARE[:3], (0, 3, 0.1)], [[0, 1, 2, 3]], PlanarityError, "f0000"),
        ([*SQUARE[:3], (3, 1, 0)], [[0, 1, 2, 3]], ConvexityError, "f0000"),
        (
            [(*np.cos([k, k - np.pi / 2]), 0) for k in np.arange(5) * 2 * np.pi / 5],
            [[0, 2, 4, 1, 3]],
            ConvexityError,
            "f0000",
        ),
        (
            [*SQUARE, (0, 0, 5), (4, 0, 5), (0, 0, -5), (4, 0, -5)],
            [[0, 1, 2, 3], [1, 0, 4, 5], [1, 0, 6, 7]],
            ManifoldError,
            "more than two faces: f0000, f0001, f0002",
        ),
        (
            [*SQUARE, (8, 0, 0), (8, 3, 0)],
            [[0, 1, 2, 3], [1, 2, 5, 4]],
            ManifoldError,
            "opposite senses",
        ),
    ],
)
def test_bad_meshes_are_refused_each_with_its_own_error(vertices, faces, error, message):
    with pytest.raises(error, match=message):
        Mesh(vertices, faces)


@pytest.mark.parametrize("addresses", [("a",), ("a", "a"), ("a", "b", "c")])
def test_addresses_that_are_not_as_many_or_not_unique_are_refused(addresses):
    with pytest.raises(InputError, match="2 faces need as many different addresses"):
        Mesh(SQUARE, [[0, 1, 2], [0, 2, 3]], addresses=addresses)


def test_planarity_error_gives_the_distance():
    with pytest.raises(PlanarityError) as caught:
        Mesh([(0, 0, 0), (10, 0, 0.4), (10, 10, 0), (0, 10, 0.4)], [[0, 1, 2, 3]])
    assert caught.value.addresses == ("f0000",)
    assert caught.value.values["deviation"] == pytest.approx(0.2, rel=1e-3)


def test_without_everything_or_nothing_is_refused():
    with pytest.raises(InputError, match="leaves no mesh"):
        grid(2, 2).without("*")
    with pytest.raises(AddressError, match=r"7\.7"):
        grid(2, 2).without("7.7")


@given(vector_sums())
def test_lattice_says_which_nodes_bound_a_face(mesh):
    rows, columns = mesh.lattice.shape[0] - 1, mesh.lattice.shape[1] - 1
    polygons = mesh.polygons()
    for face in range(len(mesh)):
        row, column = divmod(face, columns)
        nodes = mesh.lattice[row : row + 2, column : column + 2]
        assert set(polygons[face]) == set(nodes.ravel().tolist())
    assert len(mesh) == rows * columns
