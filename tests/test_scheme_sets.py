"""Handles, named sets of subdivision points, and symmetric and closed schemes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ifs_cad.design.curve import Curve
from ifs_cad.design.handle import Handle, handles
from ifs_cad.design.spline import spline_scheme, uniform_knots
from ifs_cad.design.subdivision import SubdivisionSets
from ifs_cad.design.transform import Scheme
from ifs_cad.errors import InputError, OutOfReachError

GABLE = [(0, 0), (1, 2), (2, 0)]
sizes = st.tuples(st.integers(2, 6), st.integers(2, 5))
shares = st.floats(0, 1)


@st.composite
def moved_schemes(draw, least=2):
    """De Casteljau's scheme with free columns moved at random."""
    m, n = draw(st.tuples(st.integers(least, 5), st.integers(2, 4)))
    scheme = Scheme.de_casteljau(m, n)
    change = draw(
        st.lists(st.floats(-0.3, 0.3), min_size=scheme.columns.size, max_size=scheme.columns.size)
    )
    columns = scheme.columns + np.reshape(change, scheme.columns.shape) * ~scheme.fixed[:, None]
    return Scheme(columns, scheme.layout, scheme.fixed, scheme.names)


# Handles


def test_handles_of_the_papers_scheme():
    assert handles(Scheme.de_casteljau(3)) == (
        Handle("s1", "fixed", ((1, 1),)),
        Handle("s2", "free", ((1, 2),)),
        Handle("s3", "shared", ((1, 3), (2, 1))),
        Handle("s5", "free", ((2, 2),)),
        Handle("s6", "fixed", ((2, 3),)),
    )


def test_handle_reads_as_a_sentence():
    plain, tied = (
        handles(scheme)[2]
        for scheme in (Scheme.de_casteljau(3), Scheme.de_casteljau(3).with_symmetry())
    )
    assert str(plain) == "s3: shared, column 3 of T_1 = column 1 of T_2"
    assert str(tied) == f"{plain}, mirror image itself"
    assert str(handles(Scheme.de_casteljau(3).with_symmetry())[1]).endswith("mirror image s5")


@given(sizes)
def test_handles_stand_everywhere_once(size):
    m, n = size
    scheme = Scheme.de_casteljau(m, n)
    places = [place for handle in handles(scheme) for place in handle.places]
    assert sorted(places) == [(k, j) for k in range(1, n + 1) for j in range(1, m + 1)]
    for handle in handles(scheme):
        for k, j in handle.places:
            column = scheme.transformations[k - 1][:, j - 1]
            assert (column == scheme.columns[scheme.index(handle.name)]).all()


def test_uniform_spline_shares_all_columns_but_the_outermost():
    kinds = spline_scheme(3, uniform_knots(3, 4)).kinds()
    assert kinds == {"s1": "free", "s2": "shared", "s3": "shared", "s4": "shared", "s8": "free"}


def test_names_of_the_studios_handles():
    scheme = Scheme.de_casteljau(3).with_names({"s2": "shoulder", "s4": "ridge"})
    assert scheme.names == ("s1", "shoulder", "ridge", "s5", "s6")
    assert scheme.free_names == ("shoulder", "ridge", "s5")
    assert scheme.index("s2") == scheme.index("shoulder")
    curve = Curve(GABLE, scheme=scheme).with_subdivision_point("ridge", (1, 1.5))
    assert np.abs(curve.subdivision_points["ridge"] - [1, 1.5, 0]).max() <= 1e-14
    with pytest.raises(InputError, match="shoulder, ridge, s5"):
        scheme.index("eaves")
    with pytest.raises(InputError, match="name of its own"):
        scheme.with_names({"shoulder": "ridge"})


# Sets


def rough_and_smooth():
    smooth = Curve(GABLE, depth=4)
    rough = smooth.with_subdivision_point("s2", (0.2, 1.5)).with_subdivision_point("s5", (1.6, 1))
    return smooth, rough, SubdivisionSets({"smooth": smooth.scheme, "rough": rough.scheme})


def test_between_takes_every_point_its_share_of_the_way():
    smooth, rough, sets = rough_and_smooth()
    halfway = smooth.with_scheme(sets.between("smooth", "rough", 0.25))
    for name, point in halfway.subdivision_points.items():
        expected = 0.75 * smooth.subdivision_points[name] + 0.25 * rough.subdivision_points[name]
        assert np.abs(point - expected).max() <= 1e-14


def test_between_begins_and_ends_exactly_at_the_sets():
    smooth, rough, sets = rough_and_smooth()
    assert (sets.between("smooth", "rough", 0).columns == smooth.scheme.columns).all()
    assert (sets.between("smooth", "rough", 1).columns == rough.scheme.columns).all()
    backwards = sets.between("rough", "smooth", 0.3).columns
    assert np.abs(backwards - sets.between("smooth", "rough", 0.7).columns).max() <= 1e-15


@given(moved_schemes(least=3), st.floats(-0.3, 1), shares)
def test_roughness_is_the_way_to_a_rougher_set(scheme, roughness, share):
    sets = SubdivisionSets({"now": scheme, "rougher": scheme.with_roughness(roughness)})
    expected = scheme.with_roughness(share * roughness).columns
    assert np.abs(sets.between("now", "rougher", share).columns - expected).max() <= 1e-13


@given(moved_schemes(), shares)
def test_joints_stay_shared_between_any_sets(scheme, share):
    start = Scheme.de_casteljau(scheme.size, scheme.count)
    maps = SubdivisionSets({"a": start, "b": scheme}).between("a", "b", share).transformations
    assert (maps[:-1, :, -1] == maps[1:, :, 0]).all()


def test_a_set_keeps_its_meaning_when_control_points_move():
    _, rough, sets = rough_and_smooth()
    control = np.array(GABLE) * [3, 1] + [5, 7]
    moved = Curve(control, scheme=sets["rough"])
    expected = rough.subdivision_points["s2"] * [3, 1, 1] + [5, 7, 0]
    assert np.abs(moved.subdivision_points["s2"] - expected).max() <= 1e-13


def test_sets_are_found_by_name_and_more_can_be_added():
    smooth, _, sets = rough_and_smooth()
    more = sets.with_set("wild", smooth.scheme.with_roughness(0.8))
    assert sets.names == ("smooth", "rough")
    assert more.names == ("smooth", "rough", "wild")
    with pytest.raises(InputError, match=r"'bumpy'.*smooth, rough"):
        sets.between("smooth", "bumpy", 0.5)
    for share in (-0.1, 1.1, np.nan):
        with pytest.raises(InputError):
            sets.between("smooth", "rough", share)


@pytest.mark.parametrize(
    ("other", "match"),
    [
        (Scheme.de_casteljau(4), "numbers"),
        (Scheme.de_casteljau(3, 3), "numbers"),
        (spline_scheme(2, uniform_knots(2, 3)), "share"),
        (Scheme.de_casteljau(3).with_symmetry(), "symmetry"),
        (Scheme.de_casteljau(3).with_names({"s2": "eaves"}), "names"),
        (
            Scheme(
                Scheme.de_casteljau(3).columns,
                Scheme.de_casteljau(3).layout,
                [True, True, False, False, True],
                Scheme.de_casteljau(3).names,
            ),
            "fixed",
        ),
    ],
)
def test_sets_of_another_structure_are_refused(other, match):
    with pytest.raises(InputError, match=match):
        SubdivisionSets({"a": Scheme.de_casteljau(3), "b": other})


def test_no_set_at_all_is_refused():
    with pytest.raises(InputError, match="at least one"):
        SubdivisionSets({})


# Symmetric schemes


def is_symmetric(scheme):
    maps = scheme.transformations
    return (maps == maps[::-1, ::-1, ::-1]).all()


@given(sizes)
def test_de_casteljau_is_symmetric_already(size):
    scheme = Scheme.de_casteljau(*size)
    assert np.abs(scheme.with_symmetry().columns - scheme.columns).max() <= 1e-15
    assert is_symmetric(scheme.with_symmetry())


@given(moved_schemes())
def test_symmetry_is_the_mean_of_mirror_images(scheme):
    even = scheme.with_symmetry()
    maps = scheme.transformations
    assert np.abs(even.transformations - (maps + maps[::-1, ::-1, ::-1]) / 2).max() <= 1e-15
    assert is_symmetric(even)
    assert (even.with_symmetry().columns == even.columns).all()


@given(moved_schemes(least=3), st.floats(-0.3, 1), st.data())
def test_moves_and_roughness_keep_symmetry(scheme, roughness, data):
    even = scheme.with_symmetry()
    name = data.draw(st.sampled_from(even.free_names))
    column = np.array(data.draw(st.lists(st.floats(-1, 1), min_size=even.size, max_size=even.size)))
    if even.partner(name) == name:
        column = (column + column[::-1]) / 2
    moved = even.with_column(name, column)
    assert (moved.columns[moved.index(name)] == column).all()
    assert is_symmetric(moved)
    assert is_symmetric(moved.with_roughness(roughness))
    sets = SubdivisionSets({"a": even, "b": moved})
    assert is_symmetric(sets.between("a", "b", 0.3))


def test_moving_one_point_of_a_symmetric_curve_moves_its_mirror_image():
    curve = Curve(GABLE, depth=5).with_symmetry().with_subdivision_point("s2", (0.3, 1.4))
    assert np.abs(curve.subdivision_points["s5"] - [1.7, 1.4, 0]).max() <= 1e-14
    assert np.abs(curve.points[::-1] - ([2, 0, 0] + curve.points * [-1, 1, 1])).max() <= 1e-13
    assert curve.scheme.partner("s2") == "s5"
    assert curve.scheme.partner("s3") == "s3"
    assert Curve(GABLE).scheme.partner("s2") is None


def test_symmetric_ridge_moves_only_on_its_axis():
    curve = Curve(GABLE).with_symmetry()
    raised = curve.with_subdivision_point("s3", (1, 1.7))
    assert np.abs(raised.subdivision_points["s3"] - [1, 1.7, 0]).max() <= 1e-14
    with pytest.raises(OutOfReachError, match=r"0\.2 mm off the line"):
        curve.with_subdivision_point("s3", (1.2, 1.7))
    nearest = curve.with_subdivision_point("s3", (1.2, 1.7), project=True)
    assert np.abs(nearest.subdivision_points["s3"] - [1, 1.7, 0]).max() <= 1e-14


def test_symmetric_joint_of_two_points_stays_in_the_middle():
    line = Curve([(0, 0), (2, 0)]).with_symmetry()
    with pytest.raises(OutOfReachError, match="place"):
        line.with_subdivision_point("s2", (0.5, 0))
    heavier = line.with_subdivision_point("s2", weight=3)
    assert heavier.points[8].tolist() == [1, 0, 0]
    assert heavier.homogeneous[8, 0] == pytest.approx(3)


def test_column_that_is_its_own_image_must_read_alike_backwards():
    even = Scheme.de_casteljau(3).with_symmetry()
    assert is_symmetric(even.with_column("s3", [0.3, 0.4, 0.3]))
    with pytest.raises(InputError, match=r"s3 and its mirror image s3 differ by 0\.2"):
        even.with_column("s3", [0.2, 0.4, 0.4])


def test_schemes_that_differ_from_their_image_are_refused():
    scheme = Scheme.de_casteljau(3).with_column("s2", [0.2, 0.6, 0.2])
    with pytest.raises(InputError, match="s2 and its mirror image s5 differ"):
        Scheme(scheme.columns, scheme.layout, scheme.fixed, scheme.names, symmetric=True)
    one_end = np.array([False, False, False, False, True])
    with pytest.raises(InputError, match="two ends"):
        Scheme(scheme.columns, scheme.layout, one_end, scheme.names).with_symmetry()
    uneven = np.array([[0, 1, 2], [2, 2, 4]])
    with pytest.raises(InputError, match="two ends"):
        Scheme(scheme.columns, uneven, scheme.fixed, scheme.names).with_symmetry()


def test_symmetric_uniform_spline_is_continuous():
    scheme = spline_scheme(3, uniform_knots(3, 5), 3).with_symmetry()
    assert is_symmetric(scheme)
    assert np.abs(scheme.ends[0] - scheme.ends[1][::-1]).max() <= 1e-14


# Closed schemes


def test_closed_curve_repeats_as_many_points_as_its_scheme_needs():
    square = [(0, 0), (2, 0), (2, 2), (0, 2)]
    bezier = Curve(square, closed=True)
    assert bezier.projection.shape == (4, 5)
    uniform = Curve(square, closed=True, scheme=spline_scheme(3, uniform_knots(3, 7)))
    assert uniform.projection.shape == (4, 7)
    assert (uniform.projection[:, 4:] == uniform.projection[:, :3]).all()
    assert uniform.is_closed
    # the middle of the square and its corner, 1 : 4 : 1
    assert np.abs(uniform.points[0] - [5 / 3, 1 / 3, 0]).max() <= 1e-14


def test_scheme_that_does_not_close_its_curve_is_refused():
    square = [(0, 0), (2, 0), (2, 2), (0, 2)]
    for size in (4, 6, 7):
        with pytest.raises(InputError, match="does not close"):
            Curve(square, closed=True, scheme=Scheme.de_casteljau(size))
    with pytest.raises(InputError, match="does not close"):
        Curve(square, closed=True, scheme=spline_scheme(3, uniform_knots(3, 6)))
