"""The weighted vector sum of two curves."""

import cadquery as cq
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import WeightedPoints, accepted, ifs_curves, numbers, polylines, rings, vector_sums

from ifs_cad.design.curve import Curve
from ifs_cad.design.surface import vector_sum
from ifs_cad.errors import DegenerateFaceError, InputError, SizeError, WeightError

ARCH = np.array([(0, 0, 0), (1000, 0, 800), (2500, 0, 900), (3000, 0, 100)])
FOLD = np.array([(0, 0, 0), (100, 700, 300), (0, 1500, 0)])


def as_grid(mesh):
    """Return (rows + 1, columns + 1, 3) points."""
    return mesh.vertices[mesh.lattice]


def test_unweighted_sum_is_the_sum_of_positions():
    mesh = vector_sum(ARCH, FOLD)
    np.testing.assert_allclose(as_grid(mesh), ARCH[:, None] + FOLD - FOLD[0], atol=1e-12)


def test_weighted_sum_of_one_quad_is_the_closed_form():
    # homogeneous: (1,0,0,0), (2,2000,0,0), (3,0,3000,0) sum to (4,2000,3000,0)
    a = WeightedPoints(np.array([(0, 0, 0), (1000, 0, 0)]), np.array([1, 2]))
    b = WeightedPoints(np.array([(0, 0, 0), (0, 1000, 0)]), np.array([1, 3]))
    np.testing.assert_allclose(
        as_grid(vector_sum(a, b)),
        [[(0, 0, 0), (0, 1000, 0)], [(1000, 0, 0), (500, 750, 0)]],
        atol=1e-12,
    )


@given(vector_sums())
def test_every_face_is_planar(mesh):
    assert mesh.planarity.max() < 1e-9
    # the volume of the tetrahedron on the four corners, without the package's own normals
    corners = mesh.vertices[mesh.corners.reshape(-1, 4)]
    arms = corners[:, 1:] - corners[:, :1]
    base = np.linalg.norm(np.cross(arms[:, 0], arms[:, 2]), axis=1)
    assert np.abs(np.linalg.det(arms) / base).max() < 1e-9


@given(st.one_of(polylines(0), ifs_curves(0)), st.one_of(polylines(1), ifs_curves(1)))
def test_two_borders_are_the_drawn_curves(a, b):
    grid = as_grid(accepted(vector_sum, a, b))
    np.testing.assert_allclose(grid[:, 0], a.points, atol=1e-9)
    if np.ptp(b.homogeneous[:, 0]) == 0:  # a weight that varies is kept as a ratio
        np.testing.assert_allclose(grid[0], b.points - b.points[0] + a.points[0], atol=1e-9)
    weights = a.homogeneous[0, 0] * b.homogeneous[:, 0] / b.homogeneous[0, 0]
    moved = WeightedPoints(b.points - b.points[0] + a.points[0], weights)
    np.testing.assert_allclose(grid[0], moved.points, atol=1e-9)


@given(polylines(0), polylines(1), numbers(3, -5000, 5000), st.floats(0.1, 10))
def test_shape_depends_neither_on_place_nor_on_scale_of_b(a, b, move, factor):
    mesh = accepted(vector_sum, a, b)
    np.testing.assert_allclose(vector_sum(a, b.moved(move)).vertices, mesh.vertices, atol=1e-8)
    scaled = vector_sum(a, b.scaled_weights(factor))
    np.testing.assert_allclose(scaled.vertices, mesh.vertices, atol=1e-8)


@given(polylines(0), polylines(1), numbers(3, -5000, 5000), st.floats(0.1, 10))
def test_shape_depends_neither_on_place_nor_on_scale_of_a(a, b, move, factor):
    mesh = accepted(vector_sum, a, b)
    moved = vector_sum(a.moved(move), b)
    np.testing.assert_allclose(moved.vertices, mesh.vertices + move, atol=1e-8)
    scaled = vector_sum(a.scaled_weights(factor), b)
    np.testing.assert_allclose(scaled.vertices, mesh.vertices, atol=1e-8)


@given(polylines(0), polylines(1), numbers(3, -5000, 5000))
def test_origin_only_translates(a, b, origin):
    mesh = accepted(vector_sum, a, b)
    placed = vector_sum(a, b, origin=origin)
    np.testing.assert_allclose(
        placed.vertices, mesh.vertices - mesh.vertices[0] + origin, atol=1e-9
    )


@given(polylines(0), numbers((4, 3), -300, 300))
def test_weights_on_one_curve_make_trapezoids(a, b):
    b = b + 600 * np.arange(4)[:, None] * [0, 1, 0]
    grid = as_grid(accepted(vector_sum, a, b))
    along = np.diff(grid, axis=1)
    sine = np.linalg.norm(np.cross(along[:-1], along[1:]), axis=-1)
    lengths = np.linalg.norm(along, axis=-1)
    assert (sine / (lengths[:-1] * lengths[1:])).max() < 1e-9


@given(rings(1), polylines(1))
def test_closed_curve_makes_a_tube_without_a_seam(ring, line):
    mesh = accepted(vector_sum, ring, line)
    around, along = len(ring.points) - 1, len(line.points) - 1
    assert len(mesh.vertices) == around * (along + 1)
    assert (mesh.twin < 0).sum() == 2 * around
    np.testing.assert_allclose(as_grid(mesh)[:, 0], ring.points, atol=1e-9)


@given(rings(1, segments=(4, 6)), rings(2, segments=(4, 6)))
def test_two_closed_curves_make_a_torus_without_a_border(one, other):
    small = WeightedPoints(0.2 * other.points, other.weights)
    mesh = accepted(vector_sum, one, small)
    assert (mesh.twin >= 0).all()
    edges = len(mesh.corners) // 2
    assert len(mesh.vertices) - edges + len(mesh) == 0
    assert mesh.chains == ()


def test_curve_closed_in_place_but_not_in_weight_stays_open():
    angles = np.arange(6) * 2 * np.pi / 5
    ring = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1) * 1000
    ring[-1] = ring[0]
    weights = np.array([1, 1, 1, 1, 1, 1.1])
    mesh = vector_sum(WeightedPoints(ring, weights), [(0, 0, 0), (0, 0, 500)])
    assert len(mesh.vertices) == 12
    assert (mesh.twin < 0).sum() == 12


def test_points_in_the_plane_get_z_zero():
    mesh = vector_sum([(0, 0), (1, 0)], [(0, 0), (0, 1)])
    assert (mesh.vertices[:, 2] == 0).all()


def test_normals_point_along_a_cross_b():
    mesh = vector_sum([(0, 0, 0), (1, 0, 0)], [(0, 0, 0), (0, 1, 0)])
    assert mesh.normals.tolist() == [[0.0, 0.0, 1.0]]


def test_addresses_of_iterated_curves_are_words_of_both():
    a = Curve([(0, 0, 0), (1000, 0, 900), (2000, 0, 0)], depth=2)
    b = Curve([(0, 0, 0), (0, 900, 500), (0, 2000, 0)], depth=2)
    mesh = vector_sum(a, b)
    assert len(mesh) == 16
    assert mesh.addresses[:5] == ("00", "01", "10", "11", "02")
    # the prefix is the quarter in which the face lies
    quarter = {address[0] for address in mesh.addresses if mesh.addresses.index(address) % 4 < 2}
    assert quarter == {"0", "2"}


def test_lexicographic_addresses_are_row_and_column():
    mesh = vector_sum(ARCH, FOLD, addresses="lexicographic")
    assert mesh.addresses == ("0.0", "0.1", "1.0", "1.1", "2.0", "2.1")


@pytest.mark.parametrize(
    "wire",
    [
        cq.Wire.makePolygon([cq.Vector(*p) for p in ARCH.tolist()]),
        cq.Workplane("XY").polyline([tuple(p) for p in ARCH.tolist()]).wire(),
    ],
    ids=["wire", "workplane"],
)
def test_cadquery_wire_equals_its_points(wire):
    mesh = vector_sum(wire, FOLD)
    np.testing.assert_allclose(mesh.vertices, vector_sum(ARCH, FOLD).vertices, atol=1e-9)
    assert len(mesh) == 6


def test_cadquery_wire_of_edges_drawn_either_way_is_chained():
    ends = [(1, 0), (1, 2), (3, 2)]
    lines = [cq.Edge.makeLine(*(cq.Vector(*ARCH[k]) for k in pair)) for pair in ends]
    mesh = vector_sum(cq.Wire.assembleEdges(lines), FOLD)
    # the kernel lets the wire run the way of its last edge
    np.testing.assert_allclose(mesh.vertices, vector_sum(ARCH[::-1], FOLD).vertices, atol=1e-9)


def test_cadquery_edge_equals_its_two_points():
    edge = cq.Edge.makeLine(cq.Vector(*ARCH[0]), cq.Vector(*ARCH[1]))
    np.testing.assert_allclose(
        vector_sum(edge, FOLD).vertices, vector_sum(ARCH[:2], FOLD).vertices, atol=1e-9
    )


def test_closed_cadquery_wire_makes_a_tube():
    square = [(0, 0, 0), (1000, 0, 0), (1000, 1000, 0), (0, 1000, 0)]
    wire = cq.Wire.makePolygon([cq.Vector(*p) for p in square], close=True)
    mesh = vector_sum(wire, [(0, 0, 0), (0, 0, 500)])
    assert len(mesh) == 4
    assert len(mesh.vertices) == 8


@pytest.mark.parametrize(
    "shape",
    [cq.Wire.makeCircle(100, cq.Vector(), cq.Vector(0, 0, 1)), cq.Solid.makeBox(1, 1, 1)],
    ids=["circle", "solid"],
)
def test_cadquery_shape_that_is_not_straight_edges_is_refused(shape):
    with pytest.raises(InputError, match="not made of straight edges"):
        vector_sum(shape, FOLD)


@pytest.mark.parametrize(
    ("curve", "message"),
    [
        ([(0, 0, 0), (np.nan, 0, 0)], r"Points of curve a must be finite; rows \[1\] are not"),
        ([(0, 0, 0), (0, -np.inf, 0)], r"Points of curve a must be finite; rows \[1\] are not"),
        ([(0, 0, 0)], r"n >= 2, got shape \(1, 3\)"),
        ([], "n >= 2"),
        ([(0, 0, 0, 1), (1, 0, 0, 1)], r"got shape \(2, 4\)"),
        ([0, 1, 2], r"got shape \(3,\)"),
        ([(0, 0, 0), (1, 0)], "array of points"),
        ("curve", "array of points"),
        (None, "n >= 2"),
        ([(0, 0, 0), (1, 0, 0), (1, 0, 0)], r"Points \[1\] of curve a coincide"),
    ],
)
def test_bad_curves_are_refused_each_with_its_own_error(curve, message):
    with pytest.raises(InputError, match=message):
        vector_sum(curve, FOLD)


def test_bad_curve_b_is_named_b():
    with pytest.raises(InputError, match="Points of curve b must be finite"):
        vector_sum(ARCH, [(0, 0, 0), (0, np.nan, 0)])


def test_unknown_kind_of_address_is_refused():
    with pytest.raises(InputError, match="'alphabetic'"):
        vector_sum(ARCH, FOLD, addresses="alphabetic")


@pytest.mark.parametrize("origin", [(0, 0), (0, 0, np.nan), "here"])
def test_bad_origin_is_refused(origin):
    with pytest.raises(InputError, match="origin"):
        vector_sum(ARCH, FOLD, origin=origin)


def test_parallel_curves_are_refused_naming_the_faces():
    with pytest.raises(DegenerateFaceError, match="parallel") as caught:
        vector_sum([(0, 0, 0), (1, 0, 0), (1, 0, 1)], [(0, 0, 0), (2, 0, 0), (3, 1, 0)])
    assert caught.value.addresses == ("0",)


def test_weights_that_sum_to_nothing_are_refused_naming_the_faces():
    # 1 + (0.4 - 1) + (0.4 - 1) = -0.2, only at the last corner of the last face
    line = np.array([(0, 0, 0), (1, 0, 0), (2, 0, 0)]) * 1000
    a = WeightedPoints(line, np.array([1, 1, 0.4]))
    b = WeightedPoints(line[:, [1, 0, 2]], np.array([1, 1, 0.4]))
    with pytest.raises(WeightError, match=r"sum to -0\.2") as caught:
        vector_sum(a, b)
    assert caught.value.addresses == ("3",)
    assert caught.value.values["weight"] == pytest.approx(-0.2)


def test_surface_that_does_not_fit_in_memory_is_refused_at_once():
    line = np.arange(120_003.0).reshape(-1, 3)
    with pytest.raises(SizeError, match="40,000 x 40,000 faces"):
        vector_sum(line, line)


def test_points_beyond_what_doubles_can_hold_are_refused():
    with pytest.raises(InputError, match=r"within 1e\+09 mm"):
        vector_sum([(0, 0, 0), (1e200, 0, 0)], [(0, 0, 0), (0, 1, 0)])
