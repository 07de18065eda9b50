"""What the page shows without a page: planes, places under the mouse, ribbons, plots, words."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ifs_cad.design_file import presets
from ifs_cad.design_record import Design, DrawnCurve
from ifs_cad.studio.evaluation import Evaluation, evaluate
from ifs_cad.studio.grip import RULES, Grip
from ifs_cad.studio.handles import Key, name_of
from ifs_cad.studio.plane import plane_of
from ifs_cad.studio.plot import curve_plot
from ifs_cad.studio.ribbon import face_outlines, quad_outlines, strokes
from ifs_cad.studio.scene import panels_of_faces
from ifs_cad.studio.selection import Selection, handles_of, point_of, shown
from ifs_cad.studio.words import report_html, status_html

FLAT = presets()["figure_17_offset_mesh"]
ARCH = [(0.0, 0.0, 0.0), (400.0, 0.0, 900.0), (1600.0, 0.0, 900.0), (2000.0, 0.0, 0.0)]
NOWHERE = DrawnCurve(((1, 1, 1),) * 3)
TOO_THICK = replace(FLAT, side="inner", thickness=2000.0)


@cache
def seen(design: Design) -> Evaluation:
    return evaluate(design)


@pytest.mark.parametrize(
    ("points", "right", "up", "is_exact"),
    [
        (ARCH, (1, 0, 0), (0, 0, 1), True),
        ([(0, 0, 0), (0, 700, 500), (0, 1500, 0)], (0, 1, 0), (0, 0, 1), True),
        ([(0, 0, 5), (9, 0, 5), (9, 9, 5)], (1, 0, 0), (0, 1, 0), True),
        ([(0, 0, 0), (10, 0, 10)], (1, 0, 0), (0, 0, 1), False),
        ([(0, 0, 0), (0, 0, 10)], (1, 0, 0), (0, 0, 1), False),
        ([(3, 3, 3), (3, 3, 3)], (1, 0, 0), (0, 0, 1), False),
    ],
    ids=["facing y", "facing x", "level", "line", "upright line", "one place"],
)
def test_a_curve_is_seen_in_its_plane_with_z_upwards(points, right, up, is_exact):
    plane = plane_of(points)
    assert plane.right == pytest.approx(right, abs=1e-12)
    assert plane.up == pytest.approx(up, abs=1e-12)
    assert plane.is_exact == is_exact


def test_a_curve_in_space_is_seen_in_the_nearest_plane():
    plane = plane_of([*ARCH, (1000.0, 50.0, 500.0)])
    assert not plane.is_exact
    assert abs(plane.normal[1]) > 0.99


EYE = np.array([-1500.0, -2500.0, 1800.0])


def pointer_at(place, screen_through):
    """Where a pointer over a place is, on a plane parallel to the screen."""
    ahead = np.array([0.5, 0.8, -0.3])
    ahead /= np.linalg.norm(ahead)
    sight = np.asarray(place) - EYE
    return EYE + sight * ((screen_through - EYE) @ ahead) / (sight @ ahead)


@given(
    st.tuples(st.floats(-300, 300), st.floats(-300, 300)),
    st.tuples(*[st.floats(-20, 20)] * 3),
)
@settings(max_examples=50, deadline=None)
def test_a_point_stays_in_its_plane_and_under_the_pointer(move, off):
    start = np.array(ARCH[1])
    grabbed = start + off
    grip = Grip(start, grabbed, plane_of(ARCH))
    assert grip.place(grabbed, EYE) == pytest.approx(start, abs=1e-6)
    wanted = start + np.array([move[0], 0.0, move[1]])
    place = grip.place(pointer_at(wanted, start) + off, EYE)
    assert place == pytest.approx(wanted, abs=1e-5)
    assert place[1] == 0.0


def test_a_plane_seen_from_its_edge_is_not_followed_into_the_distance():
    start = np.array(ARCH[1])
    eye = np.array([400.0, -0.0, 5000.0])
    place = Grip(start, start, plane_of(ARCH)).place(start + np.array([30.0, 40.0, 0.0]), eye)
    assert place == pytest.approx(start + np.array([30.0, 0.0, 0.0]), abs=1e-9)


@pytest.mark.parametrize(("rule", "axis"), [("along x", 0), ("along y", 1), ("along z", 2)])
def test_a_point_moves_along_one_axis_only(rule, axis):
    start = np.array(ARCH[1])
    wanted = start.copy()
    wanted[axis] += 120.0
    place = Grip(start, start, plane_of(ARCH), rule).place(pointer_at(wanted, start), EYE)
    assert place == pytest.approx(wanted, abs=1e-5)


def test_on_the_screen_a_point_goes_where_the_pointer_is():
    start = np.array(ARCH[1])
    grip = Grip(start, start + 7.0, plane_of(ARCH), "plane of the screen")
    assert "plane of the screen" in RULES
    assert grip.place(start + np.array([17.0, 27.0, 37.0]), EYE) == pytest.approx(
        start + np.array([10, 20, 30])
    )


def normals_of(vertices, triangles):
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    across = np.cross(b - a, c - a)
    return across / np.linalg.norm(across, axis=1)[:, None]


def test_outlines_lie_on_their_faces_and_look_outwards():
    solids = seen(FLAT).shell.solids
    vertices, triangles = face_outlines(solids, 4.0)
    assert len(triangles) == 2 * len(solids.loops)
    normals = np.tile(solids.normals[solids.face_of_loop], (2, 1))
    assert np.einsum("ij,ij->i", normals_of(vertices, triangles), normals) == pytest.approx(1.0)
    levels = np.repeat(solids.levels[solids.face_of_loop], 4)
    heights = np.einsum(
        "ij,ij->i", vertices, np.repeat(solids.normals[solids.face_of_loop], 4, axis=0)
    )
    assert heights - levels == pytest.approx(0.08 * 4.0)
    centres = np.add.reduceat(solids.vertices[solids.loops], solids.face_offsets[:-1])
    centres /= np.diff(solids.face_offsets)[:, None]
    middle = vertices.reshape(-1, 4, 3).mean(axis=1)
    edge = (solids.vertices[solids.loops] + solids.vertices[solids.heads]) / 2
    inwards = centres[solids.face_of_loop] - edge
    assert (np.einsum("ij,ij->i", middle - edge, inwards) > 0).all()


def test_outlines_of_a_surface_are_seen_from_both_sides():
    evaluation = seen(FLAT)
    vertices, triangles = quad_outlines(evaluation.vertices, evaluation.faces, 2.0)
    assert len(triangles) == 2 * 2 * 4 * len(evaluation.faces)
    normals = normals_of(vertices, triangles)
    assert np.abs(normals.sum(axis=0)).max() < 1e-6


def test_strokes_have_the_line_in_their_middle():
    lines = np.array([[(0, 0, 0), (10, 0, 0)], [(5, 5, 0), (5, 5, 0)]], dtype=float)
    vertices, triangles = strokes(lines, np.array([[0, 0, 1.0]] * 2), 2.0)
    assert len(triangles) == 2  # of the line without a length nothing
    assert vertices.min(axis=0) == pytest.approx((0, -1, 0.16))
    assert vertices.max(axis=0) == pytest.approx((10, 1, 0.16))
    assert len(strokes(lines[:0], np.empty((0, 3)), 2.0)[1]) == 0


def test_a_plot_shows_all_points_and_its_scale():
    svg = ET.fromstring(curve_plot(seen(FLAT).a, 1))
    texts = [item.text for item in svg.iter("text")]
    names = [name_of(handle) for handle in handles_of(FLAT.a)]
    assert sorted(texts[1:]) == sorted(names)
    assert texts[0].endswith(" mm")
    rings = [item for item in svg.iter("circle") if item.get("fill") == "none"]
    assert len(rings) == 1
    curve = [item for item in svg.iter("polyline") if item.get("stroke-width") == "2"]
    assert len(curve[0].get("points").split()) == len(seen(FLAT).a.points)


@pytest.mark.parametrize("name", presets())
def test_every_figure_can_be_plotted(name):
    evaluation = evaluate(presets()[name], panels=False)
    for view in (evaluation.a, evaluation.b):
        ET.fromstring(curve_plot(view))


def test_a_curve_of_one_place_is_plotted_too():
    nowhere = replace(FLAT, a=NOWHERE)
    evaluation = evaluate(nowhere)
    ET.fromstring(curve_plot(evaluation.a))
    assert "in the way" in status_html(evaluation)


def test_what_is_wrong_is_counted_and_told():
    good, bad = seen(FLAT), seen(TOO_THICK)
    assert "can be built" in status_html(good)
    assert "mass" in report_html(good)
    assert "1 thing in the way" in status_html(bad)
    assert "can be built" not in status_html(bad)
    assert "too thick" in report_html(bad)


def test_words_are_no_markup():
    note = status_html(seen(FLAT), "<script>alert('x')</script>")
    assert "<script>" not in note


def test_panels_of_faces_are_found_when_some_are_missing():
    evaluation = seen(FLAT)
    part = replace(evaluation, shell=evaluation.shell.without(evaluation.addresses[0]))
    assert panels_of_faces(part, np.array([0])).tolist() == []
    assert panels_of_faces(part, np.array([1, 2])).tolist() == [0, 1]


def test_a_selected_point_that_is_gone_gives_way_to_the_first():
    selection = Selection()
    told = []
    selection.changed = lambda: told.append(selection.active)
    selection.choose(Key("a", "s3"))
    selection.choose(Key("a", "s3"))
    assert told == [Key("a", "s3")]
    assert selection.of("a", FLAT) == "s3"
    fewer = replace(FLAT, a=DrawnCurve(FLAT.a.control_points[:2]))
    assert selection.of("a", fewer) == 0


@pytest.mark.parametrize("name", presets())
def test_all_points_of_all_figures_have_a_place_and_a_weight(name):
    design = presets()[name]
    for drawn in (design.a, design.b):
        for handle in handles_of(drawn):
            place, weight = point_of(drawn, handle)
            assert np.isfinite(place).all()
            assert weight > 0


def test_a_point_that_cannot_be_told_is_none():
    assert point_of(NOWHERE, "s2") is None
    assert point_of(NOWHERE, 0) == ((1.0, 1.0, 1.0), 1.0)
    assert shown((1 / 3, -1e-9, 2.0)) == (0.3333, 0.0, 2.0)
