"""The studio without its page: every change, its history, and problems marked where they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, reject, settings
from hypothesis import strategies as st
from strategies import numbers

from ifs_cad.design_file import presets, read_design
from ifs_cad.design_record import Design, DrawnCurve, SubdivisionPoint
from ifs_cad.elements.fibre import FibreTowards
from ifs_cad.elements.hole import Holes
from ifs_cad.elements.label import Label
from ifs_cad.errors import IfsCadError, InputError, WeightError
from ifs_cad.studio import model as studio
from ifs_cad.studio.display import panel_view
from ifs_cad.studio.editing import (
    moved_control_point,
    moved_subdivision_point,
    reset_subdivision_point,
    with_control_point_added,
    with_control_point_removed,
    with_roughness,
    with_symmetry,
    with_transformations,
)
from ifs_cad.studio.evaluation import evaluate
from ifs_cad.studio.model import StudioModel, autosave_path, recover

ARCH = DrawnCurve([(0, 0, 0), (1000, 0, 1600), (2000, 0, 0)], depth=2)
FOLD = DrawnCurve([(0, 0, 0), (0, 700, 300), (0, 1500, 0)], depth=2)
DESIGN = Design(ARCH, FOLD, 12.0)


@st.composite
def drawn_curves(draw, sizes=(2, 5), moves=True):
    count = draw(st.integers(*sizes))
    turn = 1.2 * np.arange(count)  # a helix, so that no three are nearly on a line
    helix = np.stack([600 * turn, 900 * np.sin(turn), 900 * np.cos(turn)], axis=1)
    places = helix + draw(numbers((count, 3), -100, 100))
    drawn = DrawnCurve(
        places,
        weights=np.exp(draw(numbers(count, -0.3, 0.3))),
        depth=draw(st.integers(0, 3)),
        transformations=draw(st.integers(2, 3)),
        roughness=draw(st.floats(-0.2, 0.4)) if count > 2 else 0.0,
    )
    for name in draw(st.lists(st.sampled_from(drawn.plain_scheme.free_names), max_size=3 * moves)):
        near = np.array(drawn.base().subdivision_points[name])
        drawn = moved_subdivision_point(drawn, name, near + draw(numbers(3, -60, 60)))
    return drawn


def place(drawn, name):
    return drawn.base().subdivision_points[name]


def test_subdivision_points_follow_a_control_point():
    drawn = moved_subdivision_point(ARCH, "s2", (300, 0, 700))
    moved = moved_control_point(drawn, 1, (1000, 0, 2000))
    expected = drawn.base().with_control_point(1, (1000, 0, 2000))
    assert np.abs(moved.base().points - expected.points).max() < 1e-9


def test_subdivision_point_goes_to_the_nearest_place_that_it_can_reach():
    drawn = moved_subdivision_point(ARCH, "s2", (300, 77, 700))
    assert place(drawn, "s2") == pytest.approx([300, 0, 700], abs=1e-9)
    assert drawn.moved[0].point == pytest.approx((300, 0, 700), abs=1e-9)


@given(drawn_curves(), st.data())
@settings(max_examples=40, deadline=None)
def test_a_moved_subdivision_point_leaves_the_others(drawn, data):
    name = data.draw(st.sampled_from(drawn.plain_scheme.free_names))
    before = drawn.base().subdivision_points
    after = moved_subdivision_point(drawn, name, before[name] + data.draw(numbers(3, -50, 50)))
    places = after.base().subdivision_points
    apart = [np.abs(places[other] - before[other]).max() for other in before if other != name]
    assert max(apart, default=0.0) < 1e-6
    back = reset_subdivision_point(after, name)
    assert {item.name for item in back.moved} == {m.name for m in after.moved} - {name}


def test_weight_of_a_subdivision_point_leaves_its_place():
    drawn = moved_subdivision_point(ARCH, "s3", weight=2.5)
    assert drawn.moved[0].point == pytest.approx((1000, 0, 800), abs=1e-9)
    assert drawn.base().subdivision_weights["s3"] == pytest.approx(2.5)


def test_roughness_takes_moved_points_with_it():
    drawn = moved_subdivision_point(ARCH, "s2", (500, 0, 900))  # its chord's middle: (500, 400)
    rough = with_roughness(drawn, 1 / 3)
    assert place(rough, "s2") == pytest.approx([500, 0, 400 + 2 * 500], abs=1e-9)
    assert place(rough, "s5") == pytest.approx([1500, 0, 400 + 2 * 400], abs=1e-9)
    assert with_roughness(rough, 0.0).moved[0].point == pytest.approx((500, 0, 900), abs=1e-9)
    flat = with_roughness(drawn, -1 / 3)
    assert place(flat, "s2") == pytest.approx([500, 0, 400], abs=1e-9)
    assert place(with_roughness(flat, 1.0), "s2") == pytest.approx([500, 0, 400], abs=1e-9)
    smooth = with_roughness(
        moved_subdivision_point(with_roughness(ARCH, -0.3), "s2", (500, 0, 410)), 1
    )
    assert place(smooth, "s2") == pytest.approx([500, 0, 400 + 10 * 4 / 0.1], rel=1e-9)


@given(drawn_curves(sizes=(2, 3)))
@settings(max_examples=50, deadline=None)
def test_added_control_point_leaves_the_shape(drawn):
    more = with_control_point_added(drawn)
    assert len(more.control_points) == len(drawn.control_points) + 1
    assert np.abs(more.base().points - drawn.base().points).max() < 1e-6


@given(drawn_curves(sizes=(3, 5), moves=False), st.booleans())
@settings(max_examples=40, deadline=None)
def test_added_control_point_leaves_bezier_curves_of_any_degree(drawn, closed):
    plain = replace(drawn, roughness=0.0, closed=closed, depth=2)
    more = with_control_point_added(plain)
    assert more.closed is closed
    assert np.abs(more.base().points - plain.base().points).max() < 1e-6


def test_removed_control_point_leaves_the_others():
    drawn = moved_subdivision_point(replace(ARCH, roughness=0.2), "s2", (300, 0, 700))
    less = with_control_point_removed(drawn, 1)
    assert less.control_points == ((0, 0, 0), (2000, 0, 0))
    assert (less.moved, less.roughness) == ((), 0.0)
    with pytest.raises(InputError, match="2 must stay"):
        with_control_point_removed(less, 0)
    with pytest.raises(InputError, match="control points 0 to 1, none 2"):
        with_control_point_removed(less, 2)


def test_other_transformations_put_moved_points_back():
    drawn = moved_subdivision_point(ARCH, "s2", (300, 0, 700))
    assert with_transformations(drawn, transformations=2) is drawn
    assert with_transformations(drawn, transformations=3).moved == ()
    assert with_transformations(drawn, closed=True).base().is_closed


@given(drawn_curves(sizes=(2, 5)), st.data())
@settings(max_examples=40, deadline=None)
def test_symmetric_editing_keeps_the_curve_its_mirror_image(drawn, data):
    drawn = with_symmetry(drawn, True)
    count = len(drawn.control_points)
    drawn = moved_control_point(drawn, data.draw(st.integers(0, count - 1)), weight=1.3)
    index = data.draw(st.integers(1, count - 1))
    goal = np.array(drawn.control_points[index]) + data.draw(numbers(3, -100, 100))
    drawn = moved_control_point(drawn, index, goal)
    name = data.draw(st.sampled_from(drawn.plain_scheme.free_names))
    drawn = moved_subdivision_point(
        drawn, name, place(drawn, name) + data.draw(numbers(3, -100, 100))
    )
    try:
        rows = drawn.base().points
    except WeightError:
        reject()
    assume(np.abs(rows).max() < 1e5)  # weights near zero send points away, with their last digits
    across = rows[-1] - rows[0]
    across /= np.linalg.norm(across)
    offsets = (rows - (rows[0] + rows[-1]) / 2) @ across
    images = rows - 2 * offsets[:, None] * across
    assert np.abs(images[::-1] - rows).max() < 1e-6
    free = with_symmetry(drawn, False)
    assert np.abs(free.base().points - rows).max() < 1e-6


def test_symmetric_editing_keeps_one_of_two_mirror_images():
    both = replace(
        ARCH,
        moved=(SubdivisionPoint("s2", (300, 0, 700)), SubdivisionPoint("s5", (1500, 0, 900))),
    )
    drawn = with_symmetry(both, True)
    assert [item.name for item in drawn.moved] == ["s2"]
    assert place(drawn, "s2") == pytest.approx([400, 0, 800], abs=1e-9)  # means of both
    moved = moved_subdivision_point(drawn, "s5", (1700, 0, 600))
    assert [item.name for item in moved.moved] == ["s5"]
    assert place(moved, "s2") == pytest.approx([300, 0, 600], abs=1e-9)
    assert [item.name for item in with_symmetry(moved, False).moved] == ["s2", "s5"]


def test_symmetric_editing_of_a_closed_curve_mirrors_about_its_first_point():
    ring = DrawnCurve([(0, 0, 0), (1000, 500, 0), (0, 1200, 0), (-900, 500, 0)], closed=True)
    drawn = with_symmetry(ring, True)
    assert drawn.control_points == ((50, 0, 0), (1000, 500, 0), (50, 1200, 0), (-900, 500, 0))
    moved = moved_control_point(drawn, 1, (800, 700, 50))
    assert moved.control_points[3] == pytest.approx((-700, 700, 50))
    assert moved_control_point(drawn, 0, (70, 9, 0)).control_points[0] == pytest.approx((50, 9, 0))


def test_symmetric_editing_needs_two_points_apart():
    with pytest.raises(InputError, match="two control points that mirror each other"):
        with_symmetry(DrawnCurve([(0, 0, 0), (5, 0, 9), (0, 0, 0)]), True)


def model(**options):
    return StudioModel(DESIGN, **options)


def test_every_change_is_one_step_back_and_forth():
    state = model()
    changes = [
        lambda: state.move_control_point("a", 1, (900, 0, 1500)),
        lambda: state.move_subdivision_point("a", "s2", (400, 0, 900)),
        lambda: state.set_weight("a", 1, 1.5),
        lambda: state.set_weight("b", "s3", 0.8),
        lambda: state.reset_subdivision_point("b", "s3"),
        lambda: state.set_depth("b", 3),
        lambda: state.set_roughness("b", 0.2),
        lambda: state.set_fold("b", 2.0),
        lambda: state.set_symmetric("a", True),
        lambda: state.add_control_point("a"),
        lambda: state.remove_control_point("b", 1),
        lambda: state.set_transformations("b", 3),
        lambda: state.set_closed("b", True),
        lambda: state.set_thickness(9.0),
        lambda: state.set_side("inner"),
        lambda: state.set_floor(-50.0),
        lambda: state.change(label=Label(), nodes="axis"),
        lambda: state.load_preset("figure_11_vector_sum"),
    ]
    seen = [state.design]
    for change in changes:
        change()
        assert state.design != seen[-1]
        seen.append(state.design)
    for expected in seen[-2::-1]:
        assert state.undo()
        assert state.design == expected
    assert not state.can_undo
    assert not state.undo()
    for expected in seen[1:]:
        assert state.redo()
        assert state.design == expected
    assert not state.can_redo
    assert not state.redo()


def test_change_after_undo_forgets_what_was_undone():
    state = model()
    state.set_thickness(9.0)
    state.undo()
    state.set_thickness(8.0)
    assert not state.can_redo


def test_change_to_the_same_is_no_step():
    state = model()
    state.set_thickness(12.0)
    state.move_control_point("a", 0, (0, 0, 0))
    assert not state.can_undo


def test_history_is_bounded():
    state = model()
    for number in range(studio.MOST_STEPS + 50):
        state.set_thickness(1.0 + number)
    steps = 0
    while state.undo():
        steps += 1
    assert steps == studio.MOST_STEPS


def test_drag_is_one_step_and_leaves_no_trace_of_its_way():
    state = model()
    state.move_subdivision_point("a", "s2", (400, 0, 900))
    before = state.design
    state.begin_drag()
    for z in (1200, 0, -800, 0, 1700):  # at 0 all control points lie on one line
        state.move_control_point("a", 1, (1000, 0, z))
    assert state.is_dragging
    state.end_drag()
    straight = model()
    straight.move_subdivision_point("a", "s2", (400, 0, 900))
    straight.move_control_point("a", 1, (1000, 0, 1700))
    assert state.design == straight.design
    state.undo()
    assert state.design == before


def test_drag_that_comes_back_is_no_step():
    state = model()
    state.begin_drag()
    state.set_thickness(9.0)
    state.set_thickness(12.0)
    state.end_drag()
    assert not state.can_undo


def test_undo_in_a_drag_takes_the_drag_back():
    state = model()
    state.begin_drag()
    state.set_thickness(9.0)
    assert state.can_undo
    state.undo()
    assert state.design == DESIGN
    assert not state.is_dragging


@pytest.mark.parametrize(
    ("change", "error"),
    [
        (lambda state: state.set_weight("a", 1, -1.0), WeightError),
        (lambda state: state.set_weight("a", "s2", 0.0), WeightError),
        (lambda state: state.set_weight("a", 3, 1.0), InputError),
        (lambda state: state.move_control_point("a", 1, (0, 0, float("nan"))), InputError),
        (lambda state: state.move_control_point("c", 1, (0, 0, 0)), InputError),
        (lambda state: state.move_subdivision_point("a", "s1", (0, 0, 0)), InputError),
        (lambda state: state.set_depth("a", -1), InputError),
        (lambda state: state.set_roughness("a", 1.1), InputError),
        (lambda state: state.set_thickness(0.0), InputError),
        (lambda state: state.set_side("up"), InputError),
        (lambda state: state.load_preset("figure_99"), InputError),
    ],
)
def test_refused_change_leaves_the_design(change, error):
    state = model()
    with pytest.raises(error):
        change(state)
    assert state.design is DESIGN
    assert not state.can_undo


def test_first_design_is_the_prototype():
    assert StudioModel().design == presets()["figure_21_prototype"]


def test_save_and_load(tmp_path):
    state = model()
    state.set_thickness(9.0)
    assert not state.is_saved
    path = state.save(tmp_path / "design.toml")
    assert state.is_saved
    other = StudioModel()
    other.load(path)
    assert other.design == state.design
    assert other.is_saved
    other.set_thickness(8.0)
    assert not other.is_saved


def test_the_history_ends_where_a_file_is_read(tmp_path):
    path = model().save(tmp_path / "design.toml")
    other = StudioModel()
    other.set_thickness(9.0)
    other.undo()
    other.load(path)
    assert not other.can_undo
    assert not other.can_redo
    assert not other.undo()
    assert other.design == read_design(path)


def test_autosave_survives_until_the_design_is_saved(tmp_path):
    target = tmp_path / "design.toml"
    kept = autosave_path(target)
    state = model(autosave=kept)
    assert not state.autosave()
    assert recover(kept) is None
    state.set_thickness(9.0)
    assert state.autosave()
    assert not state.autosave()
    assert recover(kept) == state.design
    assert read_design(kept).thickness == 9.0
    state.save(target)
    assert recover(kept) is None
    assert [entry.name for entry in tmp_path.iterdir()] == ["design.toml"]


def messages(evaluation):
    return " ".join(problem.message for problem in evaluation.problems)


def test_sound_design_is_shown_without_problems():
    design = presets()["figure_21_prototype"]
    seen = evaluate(design)
    shell = design.shell()
    assert seen.problems == ()
    assert seen.can_be_built
    assert seen.shape == (16, 16)
    assert seen.addresses == shell.mesh.addresses
    assert np.abs(seen.vertices[seen.faces] - shell.mesh.positions.reshape(-1, 4, 3)).max() < 1e-9
    assert seen.a.points == pytest.approx(design.a.curve().points)
    assert str(seen.report) == str(shell.report())
    assert [item.name for item in seen.a.subdivision_points] == list(
        design.a.base().scheme.free_names
    )
    border = seen.vertices.reshape(17, 17, 3)
    assert np.abs(seen.b.points + seen.b.shift - border[0]).max() < 1e-9
    assert np.abs(seen.a.points + seen.a.shift - border[:, 0]).max() < 1e-9


def test_surface_alone_comes_without_panels():
    seen = evaluate(DESIGN, panels=False)
    assert seen.faces.shape == (16, 4)
    assert (seen.shell, seen.panels, seen.report, len(seen.labels)) == (None, None, None, 0)


def test_triangles_enclose_the_volume_of_the_panels():
    solids = presets()["figure_18_thickened_surface"].shell().solids
    view = panel_view(solids)
    corners = view.vertices[view.triangles]
    sixfold = np.einsum("ti,ti->t", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    volumes = np.bincount(view.panel_of_triangle, sixfold) / 6
    assert volumes == pytest.approx(solids.volumes, rel=1e-6)
    faces, edges = len(solids.kinds), len(view.edges)
    assert len(view.vertices) - edges + faces == 2 * len(solids)  # Euler, for each solid


@pytest.mark.parametrize("face", ["inner", "outer"])
def test_labels_lie_on_the_marked_face(face):
    design = replace(DESIGN, label=Label(face), holes=Holes())
    seen = evaluate(design)
    assert seen.problems == ()
    shell = seen.shell
    heights = np.einsum("nki,pi->nkp", seen.labels, shell.normals)
    planes = np.einsum("pi,pi->p", shell.mesh.centroids, shell.normals)
    level = 12.0 if face == "outer" else 0.0
    on = np.abs(heights - planes - level).max(axis=1) < 1e-6
    assert on.any(axis=1).all()
    assert on.any(axis=0).all()


def test_bad_weights_leave_the_faces_that_have_a_place():
    flat = DrawnCurve(
        [(0, 0, 0), (300, 0, 0), (600, 0, 0), (900, 0, 0)], weights=(1, 0.01, 0.01, 1)
    )
    other = DrawnCurve(
        [(0, 0, 0), (0, 300, 0), (0, 600, 0), (0, 900, 0)], weights=(1, 0.01, 0.01, 1)
    )
    seen = evaluate(Design(flat, other, 5.0))
    (problem,) = seen.problems
    assert "every weight of the surface must be positive" in problem.message
    assert 0 < len(seen.faces) < 256
    assert np.isfinite(seen.vertices[seen.faces]).all()
    assert len(seen.addresses) == len(seen.faces)
    assert set(problem.addresses).isdisjoint(seen.addresses)
    assert not seen.can_be_built
    border = {tuple(point) for point in seen.vertices[seen.faces].reshape(-1, 3).tolist()}
    assert len(problem.points) > 0
    assert {tuple(point) for point in problem.points.tolist()} <= border, "beside the gap"
    assert len(problem.points) < len(border)


def test_bad_weights_that_leave_no_face_mark_the_corners_around():
    curve = [(0, 0, 0), (300, 0, 0), (600, 0, 0), (900, 0, 0)]
    flat = DrawnCurve(curve, weights=(1, 0.01, 0.01, 1), depth=1)
    other = replace(flat, control_points=[(y, x, z) for x, y, z in curve])
    seen = evaluate(Design(flat, other, 5.0))
    (problem,) = seen.problems
    assert len(seen.faces) == 0, "all four meet in the middle, which has no place"
    assert len(problem.points) == 8
    assert np.isfinite(problem.points).all()


def test_too_thick_is_marked_on_the_surface():
    seen = evaluate(replace(DESIGN, thickness=2000.0, side="inner"))
    (problem,) = seen.problems
    assert "too thick for the folds" in problem.message
    assert [seen.addresses[i] for i in problem.faces] == sorted(
        problem.addresses, key=seen.addresses.index
    )
    assert len(problem.faces) == len(problem.addresses) == len(problem.points) > 0
    assert problem.points == pytest.approx(seen.vertices[seen.faces[problem.faces]].mean(axis=1))
    assert seen.shell is None
    assert len(seen.faces) == 16


def test_not_contracting_is_a_warning_and_everything_is_shown():
    design = presets()["figure_18_thickened_surface"]
    wild = moved_subdivision_point(replace(design.b, depth=1), "s2", (300, 1400, 9000))
    seen = evaluate(replace(design, b=wild, thickness=1.0))
    assert [(p.severity, p.curve) for p in seen.problems] == [("warning", "b")]
    assert "do not shrink" in seen.problems[0].message
    handles = [handle.point for handle in seen.b.subdivision_points]
    assert len(handles) > 0
    assert seen.problems[0].points == pytest.approx(np.array(handles))
    assert seen.can_be_built
    assert seen.panels is not None


def test_out_of_reach_shows_the_other_curve():
    astray = replace(ARCH, moved=(SubdivisionPoint("s2", (300, 5, 700)),))
    seen = evaluate(replace(DESIGN, a=astray))
    (problem,) = seen.problems
    assert problem.message.startswith("Curve a: ")
    assert "5 mm off the plane" in problem.message
    assert seen.a.points is None
    assert seen.a.subdivision_points == astray.moved
    assert seen.b.points is not None
    assert len(seen.faces) == 0


def test_fold_that_is_too_flat_shows_the_curve_without_it():
    seen = evaluate(replace(DESIGN, b=replace(FOLD, fold=0.1)))
    (problem,) = seen.problems
    assert "as steep as the fold" in problem.message
    assert problem.curve == "b"
    assert len(problem.points) == len(problem.addresses) > 0
    assert seen.b.points == pytest.approx(FOLD.curve().points)
    assert len(seen.faces) == 16
    assert seen.shell is None


def test_floor_out_of_reach_shows_panels_without_it():
    seen = evaluate(replace(DESIGN, floor=-100.0))
    assert "No border reaches the floor" in messages(seen)
    assert len(seen.shell) == 16
    assert not seen.can_be_built
    high = evaluate(replace(DESIGN, floor=250.0))
    assert high.can_be_built


def test_what_the_floor_takes_is_a_warning_with_its_place():
    low = presets()["figure_21_prototype"]
    seen = evaluate(replace(low, floor=900.0))
    lost = next(problem for problem in seen.problems if "not made" in problem.message)
    assert lost.severity == "warning"
    assert lost.addresses == seen.shell.lost
    assert (lost.points[:, 2] < 900).all()


def test_crossed_panels_are_marked():
    loop = DrawnCurve([(0, 0, 0), (4000, 0, 3000), (-2000, 0, 3000), (2000, 0, 0)], depth=4)
    straight = DrawnCurve([(0, 0, 0), (0, 1000, 0)], depth=1)
    seen = evaluate(Design(loop, straight, 5.0))
    (problem,) = seen.problems
    assert "run into each other" in problem.message
    centres = seen.vertices[seen.faces[problem.faces]].mean(axis=1)
    assert np.abs(centres[:, 0] - 1000).max() < 200  # the curve crosses itself on its axis
    assert seen.panels is not None
    assert not seen.can_be_built


def test_parallel_curves_are_a_problem():
    seen = evaluate(replace(DESIGN, b=ARCH))
    assert not seen.can_be_built
    assert seen.faces.shape == (16, 4)


def test_labels_holes_and_fibre_without_room_are_marked():
    small = replace(DESIGN, label=Label(cutter=16.0, height=80.0), holes=Holes(20.0, 400.0))
    seen = evaluate(replace(small, fibre=FibreTowards((0, 0, 1))))
    assert "smaller inset" in messages(seen)
    assert all(len(problem.faces) for problem in seen.problems)
    assert seen.panels is not None


def test_too_many_faces_are_not_drawn():
    seen = evaluate(replace(DESIGN, a=replace(ARCH, depth=9), b=replace(FOLD, depth=9)))
    assert [problem.severity for problem in seen.problems] == ["warning"]
    assert "512 x 512 faces are too many to draw here" in messages(seen)
    assert len(seen.a.points) == 513
    deep = evaluate(replace(DESIGN, a=replace(ARCH, depth=1000)))
    assert "too many segments" in messages(deep)
    assert deep.problems[0].curve == "a"
    assert len(deep.problems[0].points) > 0


def test_control_points_in_one_place_are_a_problem_that_can_be_repaired():
    state = StudioModel(replace(DESIGN, a=DrawnCurve([(0, 0, 0), (9, 0, 0)])))
    state.move_subdivision_point("a", "s2", (4, 0, 0))
    state.move_control_point("a", 1, (0, 0, 0))
    assert "All 2 control points are at" in messages(state.evaluate())
    state.move_control_point("a", 1, (2000, 0, 0))
    assert state.evaluate(panels=False).a.points is not None


@st.composite
def wild_curves(draw):
    count = draw(st.integers(2, 4))
    drawn = DrawnCurve(
        draw(numbers((count, 3), -3000, 3000)),
        weights=np.exp(draw(numbers(count, -4, 4))),
        depth=draw(st.integers(0, 3)),
        closed=draw(st.booleans()),
        roughness=draw(st.floats(-1 / 3, 1)) if count > 2 else 0.0,
        fold=draw(st.none() | st.sampled_from([-0.7, 0.5, 3.0])),
    )
    names = draw(st.lists(st.sampled_from(drawn.plain_scheme.free_names), max_size=2))
    for name in names:
        try:
            drawn = moved_subdivision_point(
                drawn, name, draw(numbers(3, -9000, 9000)), draw(st.floats(0.01, 50))
            )
        except IfsCadError:
            continue
    return drawn


@given(
    st.builds(
        Design,
        wild_curves(),
        wild_curves(),
        st.floats(0.1, 300.0),
        side=st.sampled_from(["outer", "inner", "centre"]),
        nodes=st.sampled_from(["relief", "axis", "plain"]),
        floor=st.none() | st.floats(-2000, 2000),
        label=st.none() | st.just(Label()),
        holes=st.none() | st.just(Holes()),
        fibre=st.none() | st.just(FibreTowards((0.0, 0.0, 1.0))),
    )
)
@settings(max_examples=80, deadline=None)
def test_evaluation_never_fails(design):
    seen = evaluate(design)
    assert seen.panels is not None or not seen.can_be_built
    for problem in seen.problems:
        assert problem.message
        # of faces that have no place the corners beside them are marked
        has_gaps = not np.isfinite(seen.vertices).all()
        assert len(problem.faces) == len(problem.points) or problem.curve or has_gaps
    if seen.can_be_built:
        assert len(design.shell()) == len(seen.shell)
