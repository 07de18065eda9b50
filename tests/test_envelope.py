"""The reach of a tilted cutter, against a cylinder made of points."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ifs_cad.elements.material import SPRUCE_PLYWOOD
from ifs_cad.errors import InputError
from ifs_cad.fabrication.nesting.envelope import SweptReach, clearance_reach
from ifs_cad.fabrication.workpiece import Side, Workpiece

SQUARE = np.array([[0.0, 0.0], [300.0, 0.0], [300.0, 300.0], [0.0, 300.0]])


def workpiece(*inclinations: float, thickness: float = 10.0) -> Workpiece:
    sides = tuple(
        Side(np.zeros((4, 3)), np.array([1.0, 0.0, 0.0]), inclination, "cut", "")
        for inclination in inclinations
    )
    return Workpiece(
        "a", thickness, SPRUCE_PLYWOOD, SQUARE, SQUARE, SQUARE, None, (), None, sides,
        np.eye(3), np.zeros(3), 1.0,
    )  # fmt: skip


def sampled(diameter: float, breakthrough: float, inclination: float, height: float) -> SweptReach:
    """A solid cylinder as points, standing on the side: x outward, y along the edge, z up."""
    angle = np.radians(inclination)
    axis = np.array([np.sin(angle), 0.0, np.cos(angle)])
    outward = np.array([np.cos(angle), 0.0, -np.sin(angle)])
    contact = np.array([-breakthrough * np.tan(angle), 0.0, -breakthrough])
    turns = np.linspace(0.0, 2.0 * np.pi, 73)
    radii = np.linspace(0.0, diameter / 2.0, 401)[:, None]
    disc = (
        contact
        + (diameter / 2.0 + radii * np.cos(turns))[..., None] * outward
        + (radii * np.sin(turns))[..., None] * np.array([0.0, 1.0, 0.0])
    ).reshape(-1, 3)
    # how high along the axis each point of the disc may rise before it leaves the sheet
    up = np.clip((np.array([[0.0], [height]]) - disc[:, 2]) / axis[2], 0.0, None)
    ends = disc + up[..., None] * axis
    within = (ends[..., 2] >= -1e-9) & (ends[..., 2] <= height + 1e-9)
    silhouette = max(0.0, height * np.tan(angle))
    return SweptReach(float(ends[within][:, 0].max()) - silhouette, float(-disc[:, 2].min()))


def test_upright_side_reaches_the_diameter_and_the_breakthrough() -> None:
    assert clearance_reach(workpiece(0.0), 12.0, 0.5) == SweptReach(12.0, 0.5)


def test_side_wider_at_the_top_sinks_the_far_rim() -> None:
    reach = clearance_reach(workpiece(20.0), 12.0, 0.5)
    assert reach.beyond == pytest.approx(12.770, abs=1e-3)  # 12 / cos 20
    assert reach.below == pytest.approx(4.604, abs=1e-3)  # 0.5 + 12 sin 20


def test_side_wider_at_the_bottom_lifts_the_far_rim() -> None:
    reach = clearance_reach(workpiece(-20.0), 12.0, 0.5)
    assert reach.beyond == pytest.approx(11.458, abs=1e-3)  # 12 cos 20 + 0.5 tan 20
    assert reach.below == 0.5


def test_workpiece_takes_the_most_of_its_sides() -> None:
    reach = clearance_reach(workpiece(-30.0, 0.0, 10.0), 8.0, 1.0)
    assert reach.beyond == pytest.approx(8.0 / np.cos(np.radians(10.0)))
    assert reach.below == pytest.approx(1.0 + 8.0 * np.sin(np.radians(10.0)))


@given(
    diameter=st.floats(3.0, 25.0),
    breakthrough=st.floats(0.0, 5.0),
    inclination=st.floats(-60.0, 60.0),
    height=st.floats(3.0, 60.0),
)
def test_reach_is_that_of_a_cylinder_of_points(
    diameter: float, breakthrough: float, inclination: float, height: float
) -> None:
    reach = clearance_reach(workpiece(inclination, thickness=height), diameter, breakthrough)
    points = sampled(diameter, breakthrough, inclination, height)
    step = diameter / 400.0  # between two points of the disc
    assert points.beyond <= reach.beyond + 1e-9
    assert reach.beyond == pytest.approx(points.beyond, abs=2.0 * step)
    assert reach.below == pytest.approx(points.below, abs=1e-9)


@pytest.mark.parametrize(("diameter", "breakthrough"), [(0.0, 1.0), (12.0, -1.0), (np.nan, 1.0)])
def test_sizes_that_cannot_be_meant_are_refused(diameter: float, breakthrough: float) -> None:
    with pytest.raises(InputError, match="must be"):
        clearance_reach(workpiece(0.0), diameter, breakthrough)
