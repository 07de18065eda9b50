"""Constraints on meshes, curves and elements: worst values, offenders, reports and errors."""

import numpy as np
import pytest
import strategies
from hypothesis import given
from hypothesis import strategies as st

from ifs_cad.design.connection import (
    Continuity,
    Elements,
    NodeValence,
    connected_parts,
    inner_nodes,
)
from ifs_cad.design.constraint import ConstraintResult, check_constraints
from ifs_cad.design.curve import Curve
from ifs_cad.design.development import (
    Developable,
    DevelopableStrips,
    angle_defects,
    flat_strips,
)
from ifs_cad.design.fit import sheet_shares
from ifs_cad.design.form import Convexity, MaximumEdge, MaximumPart, MinimumEdge, Planarity
from ifs_cad.design.mesh import Mesh
from ifs_cad.design.surface import vector_sum
from ifs_cad.errors import ConstraintError, GeometryError, InputError
from ifs_cad.tolerance import Tolerance

# 2 x 3 rectangles of 300 x 200 mm; rows along x, columns along y
STEPS_X, STEPS_Y = [(0, 0), (300, 0), (600, 0)], [(0, 0), (0, 200), (0, 400), (0, 600)]
FLAT = vector_sum(STEPS_X, STEPS_Y)
FOLDED = vector_sum([(0, 0, 0), (300, 0, 100), (600, 0, 0)], [(0, 0, 0), (0, 200, 90), (0, 400, 0)])


def ngon(corners, radius=500.0, turn=0.0):
    """Return a mesh of one regular polygon."""
    angles = turn + 2 * np.pi * np.arange(corners) / corners
    points = radius * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(corners)])
    return Mesh(points, [list(range(corners))])


def rectangle(length, width, degrees=0.0):
    """Return a mesh of one rectangle, turned in a plane that is not level."""
    turn = np.radians(degrees)
    plan = np.array([[0, 0], [length, 0], [length, width], [0, width]]) @ [
        [np.cos(turn), np.sin(turn)],
        [-np.sin(turn), np.cos(turn)],
    ]
    tilted = plan @ np.array([[0.6, 0, 0.8], [0, 1, 0]])
    return Mesh(tilted, [[0, 1, 2, 3]])


def turned(one, other):
    """Return the area that two vectors of the plane span, positive to the left."""
    return one[0] * other[1] - one[1] * other[0]


# Reports


def test_report_reads_line_by_line():
    report = check_constraints(FLAT, [MinimumEdge(250), Planarity(), NodeValence(4)])
    lines = str(report).splitlines()
    assert lines[0] == "2 of 3 constraints are met."
    assert lines[1] == (
        "  NOT MET: minimum edge, 200 mm (at least 250); 6 offenders: 0, 1, 2, 3, 4, 5"
    )
    assert lines[2].startswith("  met: planarity, 0 mm (at most 1e-06)")
    assert lines[3] == "  met: bars at inner nodes, 4 (exactly 4); 2 inner nodes"
    assert not report.ok
    assert [result.name for result in report.failed] == ["minimum edge"]


def test_requirement_raises_with_all_offenders_once():
    report = check_constraints(FLAT, [MinimumEdge(250), NodeValence(6), MaximumEdge(1000)])
    with pytest.raises(ConstraintError, match=r"2 of 3 .*\n.*minimum edge.*\n.*bars") as caught:
        report.require()
    assert sorted(caught.value.addresses) == sorted(FLAT.addresses)
    assert caught.value.values["failed"] == ("minimum edge", "bars at inner nodes")
    assert isinstance(caught.value, GeometryError)


def test_report_of_a_sound_design_requires_nothing():
    report = check_constraints(
        FLAT, [MinimumEdge(200), MaximumEdge(300), Convexity(), Continuity()]
    )
    assert report.ok
    assert report.failed == ()
    report.require()
    assert check_constraints(FLAT, []).ok


def test_own_constraints_can_join_the_report():
    class EvenNumber:
        def check(self, design):
            count = len(design)
            return ConstraintResult("even number", count % 2 == 0, count, 0, "exactly")

    assert check_constraints(FLAT, [EvenNumber()]).ok
    assert not check_constraints(rectangle(3, 4), [EvenNumber()]).ok


@pytest.mark.parametrize(
    ("constraint", "design"),
    [
        (NodeValence(4), Curve([(0, 0), (1, 1)])),
        (MaximumPart(2500, 1250), Curve([(0, 0), (1, 1)])),
        (Developable(), Curve([(0, 0), (1, 1)])),
        (DevelopableStrips(), Curve([(0, 0), (1, 1)])),
        (Planarity(), Elements(np.zeros((1, 2, 3)), ["0"])),
        (Convexity(), "a shell"),
        (MinimumEdge(1), None),
        (Continuity(), 5),
    ],
)
def test_constraints_refuse_designs_that_they_do_not_look_at(constraint, design):
    with pytest.raises(InputError, match=f"{type(constraint).__name__} looks at"):
        check_constraints(design, [constraint])


@pytest.mark.parametrize(
    "make",
    [
        lambda: MinimumEdge(0),
        lambda: MinimumEdge(np.nan),
        lambda: MaximumEdge(-1),
        lambda: Planarity(0),
        lambda: Convexity(181),
        lambda: NodeValence(2),
        lambda: NodeValence(6.0),
        lambda: MaximumPart(0, 100),
        lambda: MaximumPart(100, 100, allowance=50),
        lambda: MaximumPart(100, 100, allowance=-1),
        lambda: MaximumPart(100, 100, fibre=(0, 0, 0)),
        lambda: Developable(0),
        lambda: DevelopableStrips("diagonals"),
        lambda: Elements(np.zeros((2, 3)), ["0", "1"]),
        lambda: Elements(np.zeros((2, 3, 3)), ["0"]),
        lambda: Elements(np.full((1, 2, 3), np.inf), ["0"]),
    ],
)
def test_constraints_that_nothing_could_meet_are_refused(make):
    with pytest.raises(InputError):
        make()


# Edges


def test_edges_of_a_mesh_against_both_limits():
    short = MinimumEdge(250).check(FLAT)
    assert (short.ok, short.value, short.limit) == (False, 200.0, 250.0)
    assert short.addresses == FLAT.addresses
    assert MinimumEdge(200).check(FLAT).ok
    long = MaximumEdge(299.9).check(FLAT)
    assert (long.ok, long.value) == (False, 300.0)


def test_segments_of_a_curve_and_strokes_of_elements_have_lengths():
    curve = Curve([(0, 0), (1000, 1000), (2000, 0)], depth=2)
    lengths = np.linalg.norm(np.diff(curve.points, axis=0), axis=1)
    result = MinimumEdge(float(lengths.mean())).check(curve)
    assert result.addresses == ("01", "10")
    assert result.value == pytest.approx(lengths.min())
    bars = Elements([[(0, 0), (3, 4), (3, 5)], [(0, 0), (6, 8), (6, 14)]], ["0", "1"])
    assert MaximumEdge(5).check(bars).addresses == ("1",)
    assert MinimumEdge(5).check(bars).addresses == ("0",)


# Planarity and convexity


def test_planarity_of_meshes_made_with_a_looser_tolerance():
    points = np.array([[0, 0, 0], [1000, 0, 0], [1000, 1000, 0], [0, 1000, 4.0], [2000, 0, 0]])
    faces = [[0, 1, 2, 3], [1, 4, 2]]
    mesh = Mesh(points, faces, tol=Tolerance(planar=2.0))
    result = Planarity(0.5).check(mesh)
    assert result.addresses == ("f0000",)
    assert result.value == pytest.approx(1.0, rel=1e-4)
    assert Planarity(1.5).check(mesh).ok


def test_planarity_of_curves():
    flat = Curve([(0, 0, 0), (1000, 0, 900), (2000, 0, 0)], depth=4)
    assert Planarity().check(flat).ok
    bent = Curve([(0, 0, 0), (1000, 0, 900), (2000, 300, 0), (3000, 0, 100)], depth=4)
    result = Planarity().check(bent)
    assert not result.ok
    assert 10 < result.value < 100
    assert len(result.addresses) == 16


def test_convexity_asks_for_corners_that_are_not_nearly_straight():
    octagon = ngon(8)
    result = Convexity(130).check(octagon)
    assert result.value == pytest.approx(135)
    assert result.addresses == ("f0000",)
    assert Convexity().check(octagon).ok


def test_convexity_of_curves_names_the_segments_that_turn_back():
    arch = Curve([(0, 0), (1000, 2000), (3000, 0)], depth=4)
    assert Convexity().check(arch).ok
    wave = Curve([(0, 0), (1000, 3000), (2000, -1000), (3000, 200)], depth=3)
    result = Convexity().check(wave)
    assert not result.ok
    assert result.value > 180
    steps = np.diff(wave.points, axis=0)
    right = np.cross(steps[:-1], steps[1:])[:, 2] < 0
    usual = right if right.sum() <= 3 else ~right
    named = np.zeros(8, dtype=bool)
    named[:-1] |= usual
    named[1:] |= usual
    assert result.addresses == tuple(np.array(wave.addresses)[named])
    straight = Curve([(0, 0), (1000, 0), (3000, 0)], depth=3)
    assert Convexity().check(straight).ok


def test_convexity_of_a_closed_curve_looks_at_its_closing_point_too():
    drop = Curve([(0, 0), (2000, 1000), (0, 2500), (-2000, 1000)], closed=True, depth=4)
    assert Convexity().check(drop).ok
    dented = Curve([(0, 900), (2000, -1000), (0, 2500), (-2000, -1000)], closed=True, depth=4)
    result = Convexity().check(dented)
    assert not result.ok
    assert {"0000", "1111"} <= set(result.addresses)


# Continuity


def test_mesh_in_two_pieces_names_the_smaller_one():
    gone = FLAT.without([FLAT.addresses[1], FLAT.addresses[4]])
    result = Continuity().check(gone)
    assert (result.ok, result.value, result.unit) == (False, 2.0, "pieces")
    assert len(result.addresses) == 2


def test_faces_that_meet_only_in_a_node_do_not_hold_each_other():
    kept = np.array(FLAT.addresses)[[0, 4]]
    part = FLAT.without([address for address in FLAT.addresses if address not in kept])
    assert Continuity().check(part).value == 2.0
    assert Continuity().check(FLAT).ok


@given(strategies.ifs_curves(0))
def test_curves_of_schemes_are_continuous(curve):
    result = Continuity().check(curve)
    assert result.ok
    assert result.value <= 1e-9
    assert curve.gaps().shape == (2**curve.depth - 1,)


def cantor(depth):
    """Return Cantor's set after some steps: 2^depth pieces of a segment."""
    starts = np.zeros(1)
    for _ in range(depth):
        starts = np.concatenate([starts / 3, 2 / 3 + starts / 3])
    ends = starts + 3.0**-depth
    points = 1000 * np.stack([starts, ends], axis=1)[..., None] * [1.0, 0.0]
    return Elements(points, [f"{number:0{depth}b}" for number in range(2**depth)])


def koch(depth):
    """Return von Koch's curve after some steps, each element computed by itself."""
    turn = np.exp(1j * np.pi / 3)
    maps = [(1, 0), (turn, 1), (1 / turn, 1 + turn), (1, 2)]
    elements = [np.array([0, 1], dtype=complex)]
    for _ in range(depth):
        elements = [(a * element + b) / 3 for a, b in maps for element in elements]
    points = 1000 * np.stack([np.real(elements), np.imag(elements)], axis=-1)
    return Elements(points, [str(number) for number in range(4**depth)])


@pytest.mark.parametrize("depth", [1, 2, 5])
def test_cantor_is_torn_and_von_koch_is_not(depth):
    torn = Continuity().check(cantor(depth))
    assert (torn.ok, torn.value, len(torn.addresses)) == (False, 2.0**depth, 2**depth - 1)
    whole = Continuity().check(koch(depth))
    assert (whole.ok, whole.value, whole.addresses) == (True, 1.0, ())


@given(
    st.lists(st.tuples(st.integers(0, 3), st.integers(0, 3)), min_size=1, max_size=12),
    st.lists(st.floats(-4e-10, 4e-10), min_size=48, max_size=48),
)
def test_elements_touch_through_rounding_and_nothing_else(places, noise):
    starts = 10.0 * np.array(places)
    points = np.stack([starts, starts + np.array([10, 0])], axis=1)
    shaken = points + np.reshape(noise, (12, 2, 2))[: len(points)]
    exact = {
        frozenset(map(tuple, element)): number for number, element in enumerate(points.tolist())
    }
    # a segment joins two places of a row, so pieces are the runs of occupied places in each row
    joined = {tuple(point) for element in exact for point in element}
    group = {point: point for point in joined}
    for _ in range(5):
        for element in exact:
            least = min(group[point] for point in element)
            for point in element:
                group[point] = least
    names = [str(number) for number in range(len(points))]
    assert Continuity().check(Elements(shaken, names)).value == len(set(group.values()))


@given(st.integers(1, 30), st.data())
def test_connected_parts_are_those_of_a_search(count, data):
    ends = st.lists(st.integers(0, count - 1), min_size=0, max_size=30)
    one = np.array(data.draw(ends), dtype=int)
    other = np.array(
        data.draw(st.lists(st.integers(0, count - 1), min_size=len(one), max_size=len(one))),
        dtype=int,
    )
    labels = connected_parts(count, one, other)
    for start in range(count):
        reached, todo = set(), [start]
        while todo:
            here = todo.pop()
            if here not in reached:
                reached.add(here)
                todo += other[one == here].tolist() + one[other == here].tolist()
        assert labels[start] == min(reached)


# Node valence


def test_valence_names_the_faces_around_other_nodes():
    angles = 2 * np.pi * np.arange(5) / 5
    fan = np.vstack([[0, 0], np.column_stack([np.cos(angles), np.sin(angles)])])
    points = 1000 * np.column_stack([fan, [0.2] + [0] * 5])
    mesh = Mesh(points, [[0, 1 + k, 1 + (k + 1) % 5] for k in range(5)])
    assert inner_nodes(mesh).tolist() == [0]
    result = NodeValence(6).check(mesh)
    assert (result.ok, result.value, result.bound) == (False, 5.0, "exactly")
    assert result.addresses == mesh.addresses
    assert NodeValence(5).check(mesh).ok


def test_mesh_without_inner_nodes_has_no_wrong_valence():
    result = NodeValence(6).check(rectangle(3, 4))
    assert (result.ok, result.value, result.note) == (True, 6.0, "0 inner nodes")


# Parts on sheets


@pytest.mark.parametrize("degrees", [0, 17, 45, 90, 133])
def test_rectangles_fit_their_own_sheet_at_any_angle(degrees):
    mesh = rectangle(2400, 1200, degrees)
    # the tilted plane is an isometry of the plan
    assert MaximumPart(2400, 1200).check(mesh).value == pytest.approx(1, abs=1e-12)
    assert MaximumPart(2400, 1200).check(mesh).ok
    assert MaximumPart(1200, 2400).check(mesh).ok
    assert not MaximumPart(2400, 1199).check(mesh).ok


def test_long_panel_fits_a_square_sheet_only_along_its_diagonal():
    # a bar a x b lies diagonally in the square of side (a + b) / sqrt 2
    side = (1200 + 60) / np.sqrt(2)
    assert MaximumPart(side, side).check(rectangle(1200, 60, 30)).value == pytest.approx(1)


def test_allowance_shrinks_the_sheet():
    mesh = rectangle(2400, 1200)
    assert MaximumPart(2500, 1300, allowance=50).check(mesh).ok
    result = MaximumPart(2500, 1300, allowance=51).check(mesh)
    assert result.value == pytest.approx(1200 / 1198)
    assert "51 mm on each side" in result.note


def test_fibre_keeps_panels_from_turning():
    mesh = vector_sum([(0, 0), (1000, 0)], [(0, 0), (0, 2000)])
    assert MaximumPart(2500, 1250).check(mesh).ok
    assert MaximumPart(2500, 1250, fibre=(0, 1, 0)).check(mesh).ok
    across = MaximumPart(2500, 1250, fibre=(1, 0, 0)).check(mesh)
    assert across.value == pytest.approx(1.6)
    diagonal = MaximumPart(2500, 2500, fibre=(1, 1, 5)).check(mesh)
    assert diagonal.value == pytest.approx(3000 / np.sqrt(2) / 2500)
    # a face square to the fibre may lie anyhow
    assert MaximumPart(2500, 1250, fibre=(0, 0, 1)).check(mesh).ok


def test_parts_that_are_too_large_are_named():
    mesh = vector_sum([(0, 0), (1000, 0), (4000, 0)], [(0, 0), (0, 1250)])
    result = MaximumPart(2500, 1250).check(mesh)
    assert result.addresses == mesh.addresses[1:]
    assert result.value == pytest.approx(3000 / 2500)


def test_share_is_the_factor_by_which_a_part_is_too_large():
    mesh = rectangle(3000, 200)
    share = MaximumPart(2500, 1250).check(mesh).value
    assert 1.1 < share < 1.2  # laid at an angle, more than the 2500 mm fit
    smaller = rectangle(3000 / share, 200 / share, 70)
    assert MaximumPart(2500, 1250).check(smaller).value == pytest.approx(1, abs=1e-12)


@given(st.integers(3, 8), st.floats(0.1, 3.0), st.data())
def test_best_angle_is_as_good_as_any(corners, proportion, data):
    spread = data.draw(st.lists(st.floats(0.05, 1), min_size=corners, max_size=corners))
    angles = 2 * np.pi * np.cumsum(spread) / np.sum(spread)
    stretch = data.draw(st.floats(0.2, 1))
    points = 1000 * np.column_stack([np.cos(angles), stretch * np.sin(angles), 0 * angles])
    mesh = strategies.accepted(Mesh, points, [list(range(corners))])
    size = (1000 * proportion, 1000.0)
    found = sheet_shares(mesh, size)[0]
    turns = np.linspace(0, np.pi, 20001)
    along = np.stack([np.cos(turns), np.sin(turns)])
    across = np.stack([-along[1], along[0]])
    tried = np.maximum(
        np.ptp(points[:, :2] @ along, axis=0) / size[0],
        np.ptp(points[:, :2] @ across, axis=0) / size[1],
    ).min()
    step = turns[1]
    assert found <= tried + 1e-12
    assert tried <= found + 2 * step * 1000 * (1 / size[0] + 1 / size[1])


@given(strategies.meshes(), st.tuples(*[st.floats(-1, 1)] * 3))
def test_fibre_never_makes_a_part_fit_better(mesh, fibre):
    if np.linalg.norm(fibre) < 0.1:
        fibre = (1.0, 0.0, 0.0)
    free, laid = sheet_shares(mesh, (2500, 1250)), sheet_shares(mesh, (2500, 1250), np.array(fibre))
    assert (free <= laid + 1e-12).all()


# Development


def test_flat_and_folded_meshes_have_their_angle_defects():
    assert np.abs(angle_defects(FLAT)[inner_nodes(FLAT)]).max() <= 1e-10
    assert Developable().check(FLAT).ok
    cube_corner = Mesh(
        100.0
        * np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1], [1, 0, 1]]),
        [[0, 1, 2, 3], [0, 3, 4, 5], [0, 5, 6, 1]],
    )
    result = Developable().check(cube_corner)
    assert result.value == pytest.approx(90)
    assert result.addresses == cube_corner.addresses


def test_prism_is_developable_and_a_fold_both_ways_is_not():
    prism = vector_sum([(0, 0, 0), (300, 0, 100), (600, 0, 0), (800, 0, 300)], STEPS_Y)
    assert Developable().check(prism).ok
    result = Developable().check(FOLDED)
    assert not result.ok
    assert len(result.addresses) == 4
    # the edges at the middle node fall by 100 and by 90 mm on both sides, in x and in y
    angle = np.degrees(np.arccos(100 * 90 / (np.hypot(300, 100) * np.hypot(200, 90))))
    assert result.value == pytest.approx(360 - 4 * angle, abs=1e-9)


@given(strategies.vector_sums(), st.sampled_from(["rows", "columns"]))
def test_unrolled_strips_keep_every_length_and_stay_together(mesh, along):
    flat = flat_strips(mesh, along)
    rows, columns = np.array(mesh.lattice.shape) - 1
    faces = np.arange(len(mesh)).reshape(rows, columns)
    faces = faces if along == "rows" else faces.T
    assert flat.shape == (*faces.shape, 4, 2)
    scale = mesh.edge_lengths.max()
    slack = 1e-9 * scale * faces.shape[1]
    shared = flat[:, :-1, [1, 2]] - flat[:, 1:, [0, 3]]
    assert np.abs(shared).max(initial=0) <= slack
    for strip, numbers in zip(flat, faces, strict=True):
        for quad, face in zip(strip, numbers, strict=True):
            corners = mesh.vertices[mesh.corners[mesh.offsets[face] : mesh.offsets[face + 1]]]
            own = np.sort(np.linalg.norm(corners[:, None] - corners, axis=-1), axis=None)
            laid = np.sort(np.linalg.norm(quad[:, None] - quad, axis=-1), axis=None)
            assert np.abs(own - laid).max() <= slack
            assert turned(quad[1] - quad[0], quad[3] - quad[0]) > 0


def test_strips_are_seen_from_the_side_of_the_normals():
    mesh = vector_sum([(0, 0), (300, 0), (700, 0)], [(0, 0), (150, 200)])
    assert mesh.normals[0, 2] > 0
    # seen from above, a strip of columns goes on along a with b to its left, one of rows along b
    # with -a to its left; a . b tells which way the quads lean
    for along, lean in (("columns", 300 * 150), ("rows", -300 * 150)):
        quad = flat_strips(mesh, along)[0, 0]
        assert (quad[1] - quad[0]) @ (quad[3] - quad[0]) == pytest.approx(lean)


def test_flat_strips_of_a_flat_mesh_are_its_plan():
    rows = flat_strips(FLAT, "rows")
    assert rows.shape == (2, 3, 4, 2)
    assert rows[0, :, 0].tolist() == [[0, 0], [200, 0], [400, 0]]
    assert rows[0, 0].tolist() == [[0, 0], [200, 0], [200, 300], [0, 300]]
    assert flat_strips(FLAT, "columns").shape == (3, 2, 4, 2)


def test_strip_around_a_cone_covers_itself_when_flat():
    # a ring of trapezoids: a flat cone unrolls into a ring of little more than a full turn
    def cone(slope, sides=24, turns=1.0):
        angles = 2 * np.pi * np.arange(int(sides * turns) + 1) / sides
        inner, outer = (
            np.column_stack([r * np.cos(angles), r * np.sin(angles), -slope * r + 0 * angles])
            for r in (200.0, 900.0)
        )
        lattice = np.arange(2 * len(angles)).reshape(2, -1)
        corners = [lattice[0, :-1], lattice[1, :-1], lattice[1, 1:], lattice[0, 1:]]
        return Mesh(np.vstack([inner, outer]), np.stack(corners, axis=1), lattice=lattice)

    assert DevelopableStrips("rows").check(cone(0.5)).ok
    wound = DevelopableStrips("rows").check(cone(0.5, turns=1.5))
    assert not wound.ok
    assert wound.value == 1.0
    # 36 sides of 15 degrees turn by about 483 degrees when flat: the excess lies on the start
    assert 0 < len(wound.addresses) < 36
    assert DevelopableStrips("columns").check(cone(0.5, turns=1.5)).ok


def test_strips_need_rows_and_columns():
    with pytest.raises(InputError, match="rows and columns"):
        DevelopableStrips().check(ngon(4))


@given(strategies.vector_sums())
def test_constraints_agree_with_what_a_mesh_guarantees(mesh):
    report = check_constraints(mesh, [Planarity(1e-5), Convexity(), Continuity()])
    assert report.ok, str(report)
