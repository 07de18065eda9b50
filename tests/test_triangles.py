"""Triangular patches: Bezier triangles that stay connected, six bars in every inner node."""

from itertools import product
from math import factorial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ifs_cad.design.connection import Continuity, NodeValence, inner_nodes
from ifs_cad.design.constraint import check_constraints
from ifs_cad.design.curve import Curve
from ifs_cad.design.transform import Scheme
from ifs_cad.design.triangle_scheme import (
    SIDES,
    TriangleScheme,
    corner_numbers,
    net,
    net_number,
    side_numbers,
)
from ifs_cad.design.triangles import TriangularPatch
from ifs_cad.errors import ContinuityError, InputError, OutOfReachError, SizeError, WeightError

degrees = st.integers(1, 4)


def net_points(degree, heights=0.0):
    """Control points of a net over a triangle with sides of about 1 m."""
    corners = np.array([[0, 0, 0], [1000, 0, 0], [500, 900, 0]])
    points = net(degree) @ corners / degree
    points[:, 2] += heights
    return points


@st.composite
def patches(draw, least=1, weighted=True):
    """Patches of any degree over uneven nets, some of them rougher."""
    degree = draw(st.integers(least, 4))
    count = len(net(degree))
    heights = draw(st.lists(st.floats(-150, 150), min_size=count, max_size=count))
    weights = draw(st.none() | st.lists(st.floats(0.5, 2), min_size=count, max_size=count))
    patch = TriangularPatch(
        net_points(degree, np.round(heights, 3)),
        depth=draw(st.integers(0, 3)),
        weights=weights if weighted else None,
    )
    if degree > 1 and draw(st.booleans()):
        patch = patch.with_roughness(draw(st.floats(-0.3, 0.2)))
    return patch


@st.composite
def moved_schemes(draw, least=2):
    """Schemes with every column moved as far as it may."""
    scheme = TriangleScheme.de_casteljau(draw(st.integers(least, 3)))
    for name in scheme.free_names:
        span = scheme.span(name)
        size = scheme.size if span is None else span.shape[1]
        change = np.array(draw(st.lists(st.floats(-0.1, 0.1), min_size=size, max_size=size)))
        column = scheme.columns[scheme.index(name)] + (change if span is None else span @ change)
        scheme = scheme.with_column(name, column)
    return scheme


def bezier_triangle(points, weights, degree, steps):
    """Return the points of a rational Bezier triangle by Bernstein polynomials, row by row."""
    shares = net(steps)[:, None] / steps
    exponents = net(degree)
    numbers = [factorial(degree) / np.prod([factorial(i) for i in point]) for point in exponents]
    basis = numbers * np.prod(shares**exponents, axis=2) * weights
    return basis @ points / basis.sum(axis=1)[:, None]


def corners_by_words(patch):
    """Return (4^depth, 3, 3) corners of all triangles, each from its own word."""
    own, found = corner_numbers(patch.degree), []
    for word in product(patch.scheme.transformations, repeat=patch.depth):
        piece = patch.projection
        for matrix in word:
            piece = piece @ matrix
        found.append((piece[1:, own] / piece[0, own]).T)
    return np.array(found)


# Nets


@given(st.integers(0, 8))
def test_net_is_numbered_row_by_row_from_a(degree):
    shares = net(degree)
    assert len(shares) == (degree + 1) * (degree + 2) // 2
    assert (shares.sum(axis=1) == degree).all()
    assert net_number(shares).tolist() == list(range(len(shares)))
    if degree:
        assert shares[corner_numbers(degree)].tolist() == (degree * np.eye(3)).tolist()


def test_sides_of_a_net_run_around_it():
    assert [side_numbers(2, side).tolist() for side in SIDES] == [[0, 1, 3], [3, 4, 5], [5, 2, 0]]


# Smooth patches


@given(patches())
def test_smooth_patch_is_the_bezier_triangle(patch):
    patch = patch.with_scheme(TriangleScheme.de_casteljau(patch.degree))
    expected = bezier_triangle(patch.control_points, patch.weights, patch.degree, 2**patch.depth)
    assert np.abs(patch.mesh.vertices - expected).max() <= 1e-12 * 1000


def test_transformations_of_degree_one_halve_the_sides():
    maps = TriangleScheme.de_casteljau(1).transformations
    expected = [
        [[2, 1, 1], [0, 1, 0], [0, 0, 1]],
        [[1, 0, 0], [1, 2, 1], [0, 0, 1]],
        [[1, 0, 0], [0, 1, 0], [1, 1, 2]],
        [[0, 1, 1], [1, 0, 1], [1, 1, 0]],
    ]
    assert (2 * maps == expected).all()


@given(degrees)
def test_columns_sum_to_one_and_corners_stay(degree):
    maps = TriangleScheme.de_casteljau(degree).transformations
    assert np.abs(maps.sum(axis=1) - 1).max() <= 1e-15
    for number, corner in enumerate(corner_numbers(degree)):
        assert maps[number, :, corner].tolist() == np.eye(len(maps[0]))[corner].tolist()


@given(patches())
def test_mesh_has_four_to_the_depth_triangles_and_six_bars_in_each_inner_node(patch):
    mesh, edge = patch.mesh, 2**patch.depth
    assert len(mesh) == 4**patch.depth
    assert (mesh.sizes == 3).all()
    assert len(mesh.vertices) == (edge + 1) * (edge + 2) // 2
    assert len(inner_nodes(mesh)) == (edge - 1) * (edge - 2) // 2
    assert (mesh.valences[inner_nodes(mesh)] == 6).all()
    report = check_constraints(mesh, [NodeValence(6), Continuity()])
    assert report.ok
    assert len(mesh.chains) == 3


def test_addresses_lead_to_the_corners_and_the_middle():
    mesh = TriangularPatch(net_points(1), depth=2).mesh
    assert mesh.addresses[:5] == ("00", "01", "02", "03", "10")
    middles = dict(zip(mesh.addresses, mesh.centroids, strict=True))
    corners = net_points(1)
    for word, corner in (("00", 0), ("11", 1), ("22", 2)):
        expected = corners[corner] * 0.75 + corners.mean(axis=0) * 0.25
        assert np.abs(middles[word] - expected).max() <= 1e-12
    assert np.abs(middles["33"] - corners.mean(axis=0)).max() <= 1e-12


def test_triangles_with_one_prefix_are_connected():
    mesh = TriangularPatch(net_points(2), depth=3).mesh
    for digit in "0123":
        others = [f"{other}*" for other in "0123" if other != digit]
        part = mesh.without(others)
        assert len(part) == 16
        assert Continuity().check(part).ok


@given(patches())
def test_normals_point_where_a_b_c_run_counter_clockwise(patch):
    flat = TriangularPatch(net_points(patch.degree), depth=patch.depth, weights=patch.weights)
    assert (flat.mesh.normals[:, 2] > 0.999).all()


def test_depth_zero_is_one_triangle():
    patch = TriangularPatch(net_points(2), depth=0)
    assert patch.mesh.vertices.tolist() == net_points(2)[[0, 3, 5]].tolist()
    assert patch.addresses == ["0"]


# Sides


@given(patches(), st.sampled_from(SIDES))
def test_border_nodes_are_the_iterated_curve_of_the_side(patch, side):
    curve = patch.side(side)
    border = patch.mesh.vertices[side_numbers(2**patch.depth, side)]
    assert np.abs(curve.points - border).max() <= 1e-9
    assert curve.scheme.symmetric


@given(degrees, st.sampled_from(SIDES))
def test_side_of_a_smooth_patch_is_a_bezier_curve(degree, side):
    patch = TriangularPatch(net_points(degree))
    bezier = Scheme.de_casteljau(degree + 1)
    assert np.abs(patch.side(side).scheme.transformations - bezier.transformations).max() <= 1e-15


@given(st.floats(-0.3, 0.3), st.integers(2, 4))
def test_roughness_of_a_patch_is_the_roughness_of_its_sides(roughness, degree):
    patch = TriangularPatch(net_points(degree)).with_roughness(roughness)
    for side in SIDES:
        expected = Curve(patch.control_points[side_numbers(degree, side)]).with_roughness(roughness)
        found = patch.side(side).scheme.transformations
        assert np.abs(found - expected.scheme.transformations).max() <= 1e-14


def test_patches_with_a_common_side_fit_together():
    left = net_points(3, np.arange(10) * 7.0 % 60)
    right = left * [-1, 1, 1]
    common = side_numbers(3, "CA")  # on x = 500 y / 900, not on the mirror plane
    right[common] = left[common]
    one, other = (
        TriangularPatch(points, depth=4).with_roughness(0.2).mesh.vertices
        for points in (left, right)
    )
    border = side_numbers(16, "CA")
    assert np.abs(one[border] - other[border]).max() <= 1e-12
    assert np.abs(one - other).max() > 100


# Columns that move


@given(moved_schemes(), st.integers(1, 3))
def test_triangles_meet_whatever_columns_are_moved(scheme, depth):
    heights = 37.0 * np.arange(scheme.size) % 90
    patch = TriangularPatch(net_points(scheme.degree, heights), depth=depth, scheme=scheme)
    expected = corners_by_words(patch)
    nodes = patch.homogeneous[:, 1:] / patch.homogeneous[:, :1]
    assert np.abs(nodes[patch._faces] - expected).max() <= 1e-9


@given(moved_schemes(), st.floats(-0.3, 0.3))
def test_roughness_leaves_a_scheme_connected_and_acts_on_its_detail(scheme, roughness):
    rough = scheme.with_roughness(roughness)
    assert (scheme.with_roughness(0).columns == scheme.columns).all()
    own = corner_numbers(scheme.degree)
    shares = net(scheme.degree) / scheme.degree
    for before, after in zip(scheme.transformations, rough.transformations, strict=True):
        flat = before[:, own] @ shares.T
        expected = flat + (1 + 3 * roughness) * (before - flat)
        assert np.abs(after - expected).max() <= 1e-14


def test_kinds_of_a_quadratic_patch():
    scheme = TriangleScheme.de_casteljau(2)
    kinds = scheme.kinds()
    assert [name for name, kind in kinds.items() if kind == "fixed"] == ["s1", "s10", "s18"]
    # the middles of the sides stand in three parts, inner edges in two, s2 and the like in one
    assert [name for name, kind in kinds.items() if kind == "free"] == [
        "s2",
        "s3",
        "s8",
        "s11",
        "s15",
        "s17",
    ]
    assert scheme.side_of("s2") == "AB"
    assert scheme.side_of("s5") is None


def test_moving_a_point_on_a_side_moves_its_mirror_image():
    patch = TriangularPatch(net_points(2, [0, 300, 300, 0, 300, 0]))
    target = patch.subdivision_points["s2"] + [0, 0, 40]
    moved = patch.with_subdivision_point("s2", target)
    assert np.abs(moved.subdivision_points["s2"] - target).max() <= 1e-9
    changed = [
        name
        for name, point in moved.subdivision_points.items()
        if np.abs(point - patch.subdivision_points[name]).max() > 1e-9
    ]
    assert changed == ["s2", "s8"]
    assert (
        np.abs(moved.subdivision_points["s8"] - patch.subdivision_points["s8"] - [0, 0, 40]).max()
        <= 1e-9
    )


def test_points_on_a_side_stay_in_its_plane_and_the_middle_on_its_line():
    patch = TriangularPatch(net_points(2, [0, 300, 300, 0, 300, 0]))
    with pytest.raises(OutOfReachError, match="plane that its column is bound to"):
        patch.with_subdivision_point("s2", patch.subdivision_points["s2"] + [0, 10, 0])
    middle = patch.subdivision_points["s4"]
    with pytest.raises(OutOfReachError, match="line that its column is bound to"):
        patch.with_subdivision_point("s4", middle + np.array([5, 0, 0]))
    raised = patch.with_subdivision_point("s4", middle + np.array([0, 0, 25]))
    assert np.abs(raised.subdivision_points["s4"] - middle - [0, 0, 25]).max() <= 1e-9


def test_inner_points_move_anywhere_with_any_weight():
    patch = TriangularPatch(net_points(2, [0, 300, 300, 0, 200, 0]))
    moved = patch.with_subdivision_point("s5", (400, 500, 260), 1.5)
    assert np.abs(moved.subdivision_points["s5"] - [400, 500, 260]).max() <= 1e-9
    assert moved.subdivision_weights["s5"] == pytest.approx(1.5)
    far = patch.with_control_point(4, (500, 500, 400), 2)
    assert far.weights.tolist() == [1, 1, 1, 1, 2, 1]
    assert far.scheme is patch.scheme


def test_columns_that_would_tear_the_mesh_are_refused():
    scheme = TriangleScheme.de_casteljau(2)
    with pytest.raises(ContinuityError, match=r"s2 .*not on the side AB"):
        scheme.with_column("s2", [0.5, 0.4, 0.1, 0, 0, 0])
    with pytest.raises(ContinuityError, match=r"s4 .*both ends of AB"):
        scheme.with_column("s4", [0.3, 0.5, 0, 0.2, 0, 0])
    columns = scheme.columns.copy()
    columns[1] = [0.4, 0.6, 0, 0, 0, 0]
    with pytest.raises(ContinuityError, match="both ends"):
        TriangleScheme(2, columns)
    columns = scheme.columns.copy()
    columns[0] = [0.5, 0.5, 0, 0, 0, 0]
    with pytest.raises(ContinuityError, match="corners"):
        TriangleScheme(2, columns)


@pytest.mark.parametrize("name", ["s1", "s7", "s99", "x"])
def test_fixed_and_unknown_columns_list_those_that_move(name):
    patch = TriangularPatch(net_points(2))
    with pytest.raises(InputError, match="s2, s3, s4"):
        patch.with_subdivision_point(name, (0, 0, 0))


# Contraction and refusals


def test_contraction_of_flat_and_wild_patches():
    patch = TriangularPatch(net_points(2, [0, 300, 300, 0, 300, 0]))
    assert patch.contraction().contracting
    weighted = TriangularPatch(patch.control_points, weights=[1, 2, 1, 1, 1, 1])
    assert weighted.contraction().contracting
    assert not patch.with_roughness(1).contraction().contracting
    flat = TriangularPatch(net_points(1)).contraction(4)
    assert flat.rate == pytest.approx(0.5, abs=1e-12)


def test_patch_that_does_not_fit_in_memory_is_refused():
    with pytest.raises(SizeError, match="greatest depth"):
        _ = TriangularPatch(net_points(1), depth=40).mesh


def test_weight_that_vanishes_names_the_triangles_around():
    patch = TriangularPatch(net_points(2), depth=1)
    columns = patch.scheme.columns.copy()
    row = patch.scheme.names.index("s4")
    columns[row] = -columns[row]
    with pytest.raises(WeightError, match="weight falls") as caught:
        _ = patch.with_scheme(TriangleScheme(2, columns)).mesh
    assert caught.value.addresses == ("0", "1", "3")


@pytest.mark.parametrize(
    ("make", "error", "match"),
    [
        (lambda: TriangularPatch(np.zeros((4, 3))), InputError, "3, 6, 10"),
        (lambda: TriangularPatch([(0, 0)]), InputError, "3, 6, 10"),
        (
            lambda: TriangularPatch(net_points(2), scheme=TriangleScheme.de_casteljau(1)),
            InputError,
            "3 control points, the patch has 6",
        ),
        (lambda: TriangularPatch(net_points(1), weights=[1, 0, 1]), WeightError, "positive"),
        (lambda: TriangularPatch(net_points(1), depth=-1), InputError, "depth"),
        (lambda: TriangleScheme.de_casteljau(0), InputError, "degree"),
        (lambda: TriangleScheme(2, np.zeros((3, 6))), InputError, "shape"),
        (lambda: TriangleScheme(1, np.full((6, 3), np.nan)), InputError, "finite"),
        (lambda: TriangularPatch(net_points(1)).with_roughness(0.1), InputError, "flat"),
        (lambda: TriangularPatch(net_points(2)).with_roughness(2), InputError, "between"),
        (lambda: TriangularPatch(net_points(2)).side("AC"), InputError, "AB, BC, CA"),
        (
            lambda: TriangularPatch(net_points(2)).with_control_point(6, (0, 0)),
            InputError,
            "0 to 5",
        ),
    ],
)
def test_unsound_patches_are_refused(make, error, match):
    with pytest.raises(error, match=match):
        make()
