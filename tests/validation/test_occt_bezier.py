"""OpenCascade's Bezier curves as an independent oracle for iterated ones (paper, section 3.1)."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ifs_cad.design.curve import Curve

pytest.importorskip("OCP")

from OCP.Geom import Geom_BezierCurve
from OCP.gp import gp_Pnt
from OCP.TColgp import TColgp_Array1OfPnt
from OCP.TColStd import TColStd_Array1OfReal

coordinates = st.floats(-4000, 4000).map(lambda value: round(value, 3))


def occt_points(control_points, weights, parameters):
    poles = TColgp_Array1OfPnt(1, len(control_points))
    shares = TColStd_Array1OfReal(1, len(control_points))
    for number, (point, weight) in enumerate(zip(control_points, weights, strict=True), start=1):
        poles.SetValue(number, gp_Pnt(*map(float, point)))
        shares.SetValue(number, float(weight))
    curve = Geom_BezierCurve(poles, shares)
    return np.array([curve.Value(float(t)).Coord() for t in parameters])


@settings(deadline=None)
@given(
    st.lists(st.tuples(*[coordinates] * 3), min_size=2, max_size=8, unique=True),
    st.data(),
)
def test_iterated_curve_equals_the_bezier_curve_of_occt(control_points, data):
    count = len(control_points)
    rational = data.draw(st.booleans())
    weights = (
        data.draw(st.lists(st.floats(0.1, 10), min_size=count, max_size=count))
        if rational
        else [1.0] * count
    )
    maps, depth = data.draw(st.sampled_from([(2, 5), (3, 3), (5, 2)]))
    curve = Curve(control_points, weights=weights, depth=depth, transformations=maps)
    parameters = np.arange(maps**depth + 1) / maps**depth
    expected = occt_points(control_points, weights, parameters)
    assert np.abs(curve.points - expected).max() <= 1e-9


def test_quarter_circle_lies_on_the_circle():
    curve = Curve([(1, 0), (1, 1), (0, 1)], weights=[1, np.sqrt(2) / 2, 1], depth=8)
    assert np.abs(np.hypot(*curve.points[:, :2].T) - 1).max() <= 1e-12
