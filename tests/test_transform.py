"""Schemes, their continuity, and contraction by products."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ifs_cad.design.contraction import contraction, diameter_contraction
from ifs_cad.design.transform import Scheme
from ifs_cad.errors import ContinuityError, InputError, SizeError

SPLINE_POINTS = (
    np.array(
        # Midpoint subdivision of a uniform cubic B-spline: five points out of four.
        [[4, 4, 0, 0], [1, 6, 1, 0], [0, 4, 4, 0], [0, 1, 6, 1], [0, 0, 4, 4]]
    ).T
    / 8.0
)
SPLINE = np.array([SPLINE_POINTS[:, :4], SPLINE_POINTS[:, 1:]])

sizes = st.tuples(st.integers(2, 9), st.integers(2, 6))
barycentric = st.floats(-2, 2)


@given(sizes)
def test_de_casteljau_columns_sum_to_one(size):
    scheme = Scheme.de_casteljau(*size)
    m, n = size
    assert scheme.transformations.shape == (n, m, m)
    assert np.abs(scheme.transformations.sum(axis=1) - 1).max() <= 1e-13


@given(sizes)
def test_de_casteljau_shares_joints_and_fixes_ends(size):
    m, n = size
    scheme = Scheme.de_casteljau(m, n)
    maps = scheme.transformations
    assert (maps[:-1, :, -1] == maps[1:, :, 0]).all()
    assert maps[0, :, 0].tolist() == np.eye(m)[0].tolist()
    assert maps[-1, :, -1].tolist() == np.eye(m)[-1].tolist()
    assert len(scheme.columns) == m * n - (n - 1)
    assert scheme.fixed.nonzero()[0].tolist() == [0, len(scheme.columns) - 1]
    assert scheme.ends.tolist() == np.eye(m)[[0, -1]].tolist()


def test_de_casteljau_thirds_of_a_line():
    maps = Scheme.de_casteljau(2, 3).transformations
    expected = [
        [[1, 2 / 3], [0, 1 / 3]],
        [[2 / 3, 1 / 3], [1 / 3, 2 / 3]],
        [[1 / 3, 0], [2 / 3, 1]],
    ]
    assert np.abs(maps - expected).max() <= 1e-15


@pytest.mark.parametrize(("size", "count"), [(1, 2), (3, 1), (2.5, 2), (3, True), ("3", 2)])
def test_de_casteljau_refuses_what_is_not_a_number_of_points_or_maps(size, count):
    with pytest.raises(InputError, match="whole number"):
        Scheme.de_casteljau(size, count)


def test_names_follow_the_paper_and_accept_the_shared_number():
    scheme = Scheme.de_casteljau(3)
    assert scheme.names == ("s1", "s2", "s3", "s5", "s6")
    assert scheme.free_names == ("s2", "s3", "s5")
    assert scheme.index("s4") == scheme.index("s3")


def test_unknown_and_fixed_names_list_those_that_move():
    scheme = Scheme.de_casteljau(3)
    with pytest.raises(InputError, match=r"'s7'.*s2, s3, s5"):
        scheme.with_column("s7", [1, 0, 0])
    with pytest.raises(InputError, match=r"'s6' is fixed.*s2, s3, s5"):
        scheme.with_column("s6", [1, 0, 0])


@given(st.lists(barycentric, min_size=3, max_size=3), st.sampled_from(["s2", "s3", "s4", "s5"]))
def test_moving_any_column_keeps_the_joint(column, name):
    scheme = Scheme.de_casteljau(3).with_column(name, column)
    first, second = scheme.transformations
    assert (first[:, -1] == second[:, 0]).all()
    numbered = np.concatenate([first, second], axis=1)
    assert numbered[:, int(name[1]) - 1].tolist() == column


def test_with_column_wrong_length_or_nan_is_an_error():
    scheme = Scheme.de_casteljau(3)
    with pytest.raises(InputError, match="3 entries"):
        scheme.with_column("s2", [1, 0])
    with pytest.raises(InputError, match="finite"):
        scheme.with_column("s2", [np.nan, 0, 0])


def test_from_transformations_gives_back_the_same_scheme():
    original = Scheme.de_casteljau(4, 3).with_column("s3", [0.1, 0.2, 0.3, 0.4])
    read = Scheme.from_transformations(original.transformations)
    assert read.names == original.names
    assert (read.fixed == original.fixed).all()
    assert (read.layout == original.layout).all()
    assert (read.transformations == original.transformations).all()


def test_from_transformations_b_spline_starts_and_ends_between_control_points():
    scheme = Scheme.from_transformations(SPLINE)
    expected = np.array([[1, 4, 1, 0], [0, 1, 4, 1]]) / 6
    assert np.abs(scheme.ends - expected).max() <= 1e-14
    assert not scheme.is_interpolating
    assert not scheme.fixed.any()


def test_b_spline_column_that_tears_the_curve_is_refused():
    with pytest.raises(ContinuityError):
        Scheme.from_transformations(SPLINE).with_column("s2", [0.3, 0.6, 0.1, 0.0])


def test_from_transformations_open_joint_is_refused_with_its_gap():
    maps = np.array([[[1, 0.5], [0, 0.5]], [[0.4, 0], [0.6, 1]]])
    with pytest.raises(ContinuityError, match="T_1 b and T_2 a"):
        Scheme.from_transformations(maps)


def test_from_transformations_without_fixed_point_is_refused():
    maps = np.array([[[0.5, 0.5], [0, 0.5]], [[0.5, 0], [0.5, 1]]])
    with pytest.raises(ContinuityError, match=r"T_1 has no fixed point.*eigenvalue 1"):
        Scheme.from_transformations(maps)


@pytest.mark.parametrize(
    "maps", [np.eye(3), np.ones((2, 3, 2)), np.full((2, 2, 2), np.inf), np.eye(2)[None]]
)
def test_from_transformations_wrong_shape_or_not_finite_is_an_error(maps):
    with pytest.raises(InputError):
        Scheme.from_transformations(maps)


def test_scheme_with_parts_that_do_not_fit_is_an_error():
    scheme = Scheme.de_casteljau(3)
    with pytest.raises(InputError, match="shape"):
        Scheme(scheme.columns[:, :2], scheme.layout, scheme.fixed, scheme.names)
    with pytest.raises(InputError, match="names"):
        Scheme(scheme.columns, scheme.layout, scheme.fixed, scheme.names[:-1])
    with pytest.raises(InputError, match=r"0\.\.4"):
        Scheme(scheme.columns, scheme.layout + 1, scheme.fixed, scheme.names)


def test_scheme_arrays_are_read_only():
    scheme = Scheme.de_casteljau(3)
    for array in (scheme.columns, scheme.layout, scheme.fixed, scheme.transformations, scheme.step):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_subdivided_orders_parts_within_pieces():
    scheme = Scheme.de_casteljau(3, 3)
    pieces = np.random.default_rng(1).normal(size=(2, 4, 3))
    parts = scheme.subdivided(pieces)
    for i, k in product(range(2), range(3)):
        expected = pieces[i] @ scheme.transformations[k]
        assert np.abs(parts[3 * i + k] - expected).max() <= 1e-15


def test_roughness_quarter_of_detail_becomes_its_share():
    scheme = Scheme.de_casteljau(3)
    detail = scheme.columns[1] - (scheme.columns[0] + scheme.columns[2]) / 2
    rough = scheme.with_roughness(1 / 3)
    assert np.abs(rough.columns[1] - scheme.columns[1] - detail).max() <= 1e-16
    assert (scheme.with_roughness(0).columns == scheme.columns).all()
    assert (rough.columns[[0, 2, 4]] == scheme.columns[[0, 2, 4]]).all()


def test_roughness_of_minus_one_third_puts_the_points_on_the_chords():
    scheme = Scheme.de_casteljau(4, 3).with_roughness(-1 / 3)
    maps = scheme.transformations
    first, last = maps[:, :, 0], maps[:, :, -1]
    assert np.abs(maps[:, :, 1] - (2 * first + last) / 3).max() <= 1e-15
    assert np.abs(maps[:, :, 2] - (first + 2 * last) / 3).max() <= 1e-15


@pytest.mark.parametrize("value", [-0.34, 1.01, np.nan, np.inf])
def test_roughness_out_of_range_is_an_error(value):
    with pytest.raises(InputError):
        Scheme.de_casteljau(3).with_roughness(value)


def test_roughness_of_two_control_points_is_an_error():
    with pytest.raises(InputError, match="two control points"):
        Scheme.de_casteljau(2).with_roughness(0.2)


def test_germ_of_the_scheme_must_run_from_a_to_b():
    scheme = Scheme.de_casteljau(3)
    assert scheme.germ([[1, 0, 0], [0, 1, 0], [0, 0, 1]]).shape == (3, 3)
    with pytest.raises(ContinuityError, match=r"a = \[1.0, 0.0, 0.0\]"):
        scheme.germ([[0, 1, 0], [0, 0, 1]])
    for wrong in ([[1, 0, 0]], [[1, 0], [0, 1]], [[1, 0, 0], [np.nan, 0, 0], [0, 0, 1]]):
        with pytest.raises(InputError):
            scheme.germ(wrong)


@pytest.mark.parametrize("length", [1, 2, 5])
def test_contraction_of_a_line_is_one_half(length):
    report = contraction(Scheme.de_casteljau(2), length)
    assert report.rate == pytest.approx(0.5, abs=1e-15)
    assert report.contracting
    assert report.warning == ""
    assert "0.5" in report.message


def test_contraction_sees_products_that_grow_though_each_map_shrinks():
    # Subdivision points (0,-1), (2,2), (3,1) over the control points (0,0), (1,2), (2,0).
    inverse = np.linalg.inv([[0, 1, 2], [0, 2, 0], [1, 1, 1]])
    scheme = Scheme.de_casteljau(3)
    for name, point in (("s2", (0, -1, 1)), ("s3", (2, 2, 1)), ("s5", (3, 1, 1))):
        scheme = scheme.with_column(name, inverse @ point)
    for matrix in scheme.transformations:
        assert sorted(abs(np.linalg.eigvals(matrix)))[1] < 0.78
    growth = max(abs(np.linalg.eigvals(scheme.transformations[0] @ scheme.transformations[1])))
    assert growth == pytest.approx((1 + np.sqrt(2)) / 2)
    report = contraction(scheme)
    assert report.rate >= growth**0.5
    assert not report.contracting
    assert report.warning == report.message


@given(
    st.lists(st.floats(-1.5, 1.5), min_size=6, max_size=6),
    st.integers(1, 4),
)
def test_contraction_bounds_every_product(entries, length):
    scheme = Scheme.de_casteljau(3)
    for name, (x, y) in zip(("s2", "s3", "s5"), np.reshape(entries, (3, 2)), strict=True):
        scheme = scheme.with_column(name, [x, y, 1 - x - y])
    rate = contraction(scheme.transformations, length).rate
    difference = np.array([1.0, -2.0, 1.0]) / np.sqrt(6)
    for word in product(scheme.transformations, repeat=length):
        moved = np.linalg.multi_dot([*word, difference]) if length > 1 else word[0] @ difference
        assert np.linalg.norm(moved) <= rate**length * (1 + 1e-9) + 1e-12


def test_contraction_refuses_columns_that_do_not_sum_to_one():
    with pytest.raises(InputError, match=r"Curve\.contraction"):
        contraction(Scheme.de_casteljau(3).with_column("s3", [0.5, 1.0, 0.5]))


def test_contraction_refuses_more_words_than_fit():
    with pytest.raises(SizeError, match=r"2\^60 words"):
        contraction(Scheme.de_casteljau(3), 60)
    with pytest.raises(InputError, match="length of words"):
        contraction(Scheme.de_casteljau(3), 0)


def test_diameter_contraction_of_a_weighted_line_by_hand():
    # From 0 to 1 with the weights 1 and 3. After one step the pieces are (0, 3/4) with the weights
    # 1, 2 and (3/4, 1) with 2, 3; their larger parts are 2/3 and 3/5 of them.
    projection = np.array([[1, 3], [0, 3], [0, 0], [0, 0]], dtype=float)
    report = diameter_contraction(Scheme.de_casteljau(2), projection, 2)
    assert report.rate == pytest.approx(2 / 3, abs=1e-15)


def test_diameter_contraction_without_weight_bounds_nothing():
    scheme = Scheme.de_casteljau(3).with_column("s2", [-1.0, 0.0, 0.0])
    report = diameter_contraction(scheme, np.eye(4)[:, [0, 1, 2]] + np.eye(4)[:, [0, 0, 0]], 4)
    assert report.rate == np.inf
    assert not report.contracting
    assert "lost its weight" in report.warning
