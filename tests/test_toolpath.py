"""Tool paths: what cutters leave and take, bridges, and what a machine cannot do."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from machining import (
    MACHINE,
    TOOLS,
    alone,
    inside_swept,
    placed_sides,
    planks,
    prototype,
    random_shell,
)

from ifs_cad.errors import InputError, MachineError
from ifs_cad.fabrication.layout import NestedSheet, Placement
from ifs_cad.fabrication.machining.contour import passes_of
from ifs_cad.fabrication.machining.flank import FlankCuts, Flanks
from ifs_cad.fabrication.machining.limits import axis_positions
from ifs_cad.fabrication.machining.machine import Clamp
from ifs_cad.fabrication.machining.orientation import RotaryHead
from ifs_cad.fabrication.machining.settings import Settings
from ifs_cad.fabrication.machining.sweep import contour_reach, swept
from ifs_cad.fabrication.machining.toolpath import toolpaths
from ifs_cad.fabrication.nesting.envelope import clearance_reach

FREE = Settings(hold="none")


@cache
def steepest():
    """Return the piece of the prototype whose sides lean most."""
    pieces, _ = prototype()
    return max(pieces, key=lambda p: max(abs(s.inclination) for s in p.sides))


def contour(program):
    return program.steps[-1]


def cut_steepest(settings=FREE, machine=MACHINE, tools=TOOLS):
    piece = steepest()
    return toolpaths(alone(piece, turn=37.5), [piece], tools, machine, settings)


def points_beside(pieces, sheet, off, random):
    """Return points near every side of a sheet, `off` along its outward normal."""
    points = []
    for _, _, _, normal, corners in placed_sides(pieces, sheet):
        weights = random.dirichlet(np.ones(len(corners)), 12)
        points.append(weights @ corners + off * normal)
    return np.concatenate(points)


def shells_to_cut():
    """Return the pieces and first sheets of random shells with reliefs and floors, and more."""
    found = [random_shell(seed) for seed in (0, 4, 10, 13, 43)]
    shells = [(pieces, sheets[0]) for pieces, sheets in filter(None, found)]
    pieces, sheets = prototype()
    return [*shells, (pieces, sheets[-1])]


@pytest.mark.parametrize("direction", ["climb", "conventional"])
def test_cutters_take_all_around_a_piece_and_nothing_of_it(direction):
    random = np.random.default_rng(7)
    settings = replace(FREE, direction=direction)
    partial = 0
    for pieces, sheet in shells_to_cut():
        program = toolpaths(sheet, pieces, TOOLS, MACHINE, settings)
        step = contour(program)
        radius = step.tool.diameter / 2
        inner = points_beside(pieces, sheet, -0.01, random)
        assert not inside_swept(inner, step.moves, radius).any()
        outer = points_beside(pieces, sheet, 0.01, random)
        assert inside_swept(outer, step.moves, radius).all()
        for _, _, side, _, _ in placed_sides(pieces, sheet):
            partial += side.corners[:, 2].min() > 0.1
    assert partial > 10


def test_nothing_but_bridges_is_left_around_a_piece():
    random = np.random.default_rng(8)
    settings = Settings(tab_height=2.0)
    pieces, sheets = prototype()
    step = contour(toolpaths(sheets[0], pieces, TOOLS, MACHINE, settings))
    outer = points_beside(pieces, sheets[0], 0.01, random)
    taken = inside_swept(outer, step.moves, step.tool.diameter / 2)
    left = outer[~taken]
    assert 0 < len(left) < len(outer) / 10
    sink = step.tool.diameter * np.sin(np.radians(41))
    assert left[:, 2].max() < settings.tab_height + sink


@pytest.mark.parametrize("hold", ["tabs", "none"])
def test_bridges_stand_as_long_and_as_high_as_asked(hold):
    tabs_of = {"tab_length": 9.0, "tab_height": 3.0, "tab_spacing": 1000.0}
    settings = Settings(hold=hold, pass_depth=100.0, **tabs_of)
    program = cut_steepest(settings)
    tool = contour(program).tool
    tabs = 0
    for cut in contour(program).cuts:
        moves = cut.moves
        axis = moves.axes[0]
        travel = np.cross([0, 0, 1], axis) if axis[2] < 1 else np.array([1.0, 0, 0])
        travel /= np.linalg.norm(travel)
        lowest = moves.tips[:, 2] - tool.diameter / 2 * np.sqrt(1 - axis[2] ** 2)
        level = np.flatnonzero(
            (moves.feeds == tool.feed)
            & np.isclose(lowest, 3.0)
            & (np.abs(np.diff(moves.tips @ travel, prepend=0.0)) > 1.0)
        )
        tabs += len(level)
        lengths = moves.lengths[level]
        np.testing.assert_allclose(lengths, 9.0 + tool.diameter)  # the cutter is round
    assert tabs == (4 if hold == "tabs" else 0)


def landings(moves):
    """Return points on the table 1 mm behind each bridge of a side, in the rest of the sheet."""
    axis, radius = moves.axes[0], 3.0
    rise = np.diff(moves.tips @ axis, prepend=0.0)
    found = []
    for k in np.flatnonzero((moves.feeds == 3000.0) & (rise > 0.1)):  # up, and along the bridge
        middle = (moves.tips[k] + moves.tips[k + 1]) / 2
        outward = np.cross(axis, moves.tips[k + 1] - moves.tips[k])[:2]
        outward /= np.linalg.norm(outward)
        foot = middle + axis * (0.1 - middle[2]) / axis[2]
        found.append(np.append(foot[:2] + outward * (radius / axis[2] + 1.0), 0.1))
    return found


def test_bridges_end_in_wood_that_no_neighbour_takes():
    pieces, sheets = prototype()
    for sheet in sheets[:3]:
        step = contour(toolpaths(sheet, pieces, TOOLS, MACHINE))
        assert (step.tool.diameter, step.tool.feed) == (6.0, 3000.0)
        owners, points = [], []
        for cut in step.cuts:
            found = landings(cut.moves)
            owners += [cut.address] * len(found)
            points += found
        owners, points = np.array(owners), np.array(points)
        for placement in sheet.placements:
            assert (owners == placement.address).sum() >= 2
        for cut in step.cuts:
            assert not inside_swept(points[owners != cut.address], cut.moves, 3.0).any()


def test_skin_is_left_under_everything():
    program = cut_steepest(Settings(hold="skin", skin=0.6))
    step = contour(program)
    tilt = np.sqrt(1 - step.moves.axes[:, 2] ** 2)
    lowest = step.moves.tips[:, 2] - step.tool.diameter / 2 * tilt
    assert lowest.min() == pytest.approx(0.6)


def test_cutter_ends_the_breakthrough_below_each_side():
    program = cut_steepest(replace(FREE, breakthrough=0.7))
    step = contour(program)
    radius = step.tool.diameter / 2
    for cut in step.cuts:
        deepest = cut.moves.tips[np.argmin(cut.moves.tips[:, 2])]
        way = cut.moves.tips[-2] - cut.moves.tips[-3]
        normal = np.cross(cut.moves.axes[0], way)
        contact = deepest - radius * normal / np.linalg.norm(normal)
        assert contact[2] == pytest.approx(-0.7)


def test_climb_has_the_piece_on_its_right_and_conventional_on_its_left():
    piece = steepest()
    sheet = alone(piece)
    middle = sheet.placements[0](piece.silhouette).mean(axis=0)
    for direction, sign in (("climb", -1.0), ("conventional", 1.0)):
        program = toolpaths(sheet, [piece], TOOLS, MACHINE, replace(FREE, direction=direction))
        for cut in contour(program).cuts:
            feeding = np.flatnonzero(cut.moves.feeds == contour(program).tool.feed)
            for k in feeding:
                way = cut.moves.tips[k, :2] - cut.moves.tips[k - 1, :2]
                to_piece = middle - cut.moves.tips[k, :2]
                assert sign * (way[0] * to_piece[1] - way[1] * to_piece[0]) > 0.0


def test_leads_run_beyond_both_corners():
    piece = steepest()
    sheet = alone(piece)
    for lead, beyond in ((None, 3.0), (0.0, 0.0), (7.5, 7.5)):
        step = contour(toolpaths(sheet, [piece], TOOLS, MACHINE, replace(FREE, lead=lead)))
        assert step.tool.diameter == 6.0
        sides = list(placed_sides([piece], sheet))
        for cut in step.cuts:
            corners = sides[int(cut.note.split()[1]) - 1][4]
            way = cut.moves.tips[-2] - cut.moves.tips[-3]
            travel = way / np.linalg.norm(way)
            along, edge = cut.moves.tips @ travel, corners @ travel
            assert edge.min() - along.min() == pytest.approx(beyond, abs=1e-9)
            assert along.max() - edge.max() == pytest.approx(beyond, abs=1e-9)


def test_passes_are_as_few_as_the_largest_depth_allows():
    assert [passes_of(depth, 7.0) for depth in (0.1, 7.0, 7.1, 14.0, 21.5)] == [1, 1, 2, 2, 4]
    for largest in (3.0, 7.0, 100.0):
        step = contour(cut_steepest(replace(FREE, pass_depth=largest)))
        for cut in step.cuts:
            heights = (cut.moves.tips @ cut.moves.axes[0])[cut.moves.feeds == step.tool.plunge]
            top = (10.0 - cut.moves.tips[0, 2]) / cut.moves.axes[0, 2]
            top += cut.moves.tips[0] @ cut.moves.axes[0]
            tilt = np.sqrt(1 - cut.moves.axes[0, 2] ** 2)
            top += step.tool.diameter / 2 * tilt / cut.moves.axes[0, 2]
            depths = -np.diff(heights, prepend=top)
            np.testing.assert_allclose(depths, depths[0])
            assert depths[0] <= largest + 1e-6
            assert depths.sum() / (len(depths) - 1 or 0.5) > largest or len(depths) == 1


def test_steps_follow_the_paper_and_cover_every_piece():
    pieces, sheets = prototype()
    seen = []
    for sheet in sheets:
        program = toolpaths(sheet, pieces, TOOLS, MACHINE)
        assert [step.name for step in program.steps] == ["pierce", "engrave", "contour"]
        for step in program.steps:
            assert {cut.address for cut in step.cuts} == {one.address for one in sheet.placements}
        seen += [one.address for one in sheet.placements]
    assert sorted(seen) == sorted(piece.address for piece in pieces)


def test_reach_without_leads_is_that_of_the_envelope_or_less_at_vertical_corners():
    tool = next(tool for tool in TOOLS if tool.name == "end mill 6")
    pieces, _ = prototype()
    for piece in pieces[::40]:
        sides = Flanks.of([(piece, Placement(piece.address, 0.0, 0.0, 0.0))])
        cuts = FlankCuts(sides, tool, replace(FREE, lead=0.0), piece.thickness)
        sweeps = swept(cuts, piece.thickness)
        outward = sides.normals[:, :2] / sides.axes[:, 2:]
        edges = np.array([(piece.silhouette @ out).max() for out in outward])
        beyond = ((sweeps.corners * outward[:, None]).sum(axis=-1).max(axis=1) - edges).max()
        assert beyond == pytest.approx(clearance_reach(piece, 6.0, 0.5).beyond, rel=5e-3)
        assert contour_reach([piece], tool) > beyond


@given(
    st.floats(-89, 89),
    st.floats(-720, 720),
    st.sampled_from(["AC", "BC"]),
    st.sampled_from([-1, 1]),
    st.sampled_from([-1, 1]),
)
def test_angles_of_a_head_point_the_tool_back(tilt, turn, axes, tilt_sign, turn_sign):
    head = RotaryHead(axes, tilt_sign, turn_sign)
    axis = head.axis(np.array(tilt), np.array(turn))
    (found,) = head.follow(axis[None], (-90.0, 90.0), (-200.0, 200.0))
    np.testing.assert_allclose(head.axis(*found), axis, atol=3e-6)
    assert -200.0 <= found[1] <= 200.0


def test_head_turns_the_short_way_and_unwinds_at_the_end_of_its_range():
    head = RotaryHead("BC")
    turns = np.radians(np.arange(0.0, 1080.0, 40.0))
    axes = np.stack([0.5 * np.cos(turns), 0.5 * np.sin(turns), np.full(len(turns), 0.75**0.5)], 1)
    angles = head.follow(axes, (-60.0, 60.0), (-360.0, 360.0))
    np.testing.assert_allclose(head.axis(*angles.T), axes, atol=1e-9)
    assert np.abs(angles[:, 1]).max() <= 360.0
    steps = np.abs(np.diff(angles, axis=0)).max(axis=1)
    assert (steps < 40.0 + 1e-6).sum() >= len(steps) - 4
    assert steps.max() <= 180.0
    one_side = head.follow(axes, (0.0, 60.0), (-360.0, 360.0))
    assert (one_side[:, 0] > 0.0).all()
    upright = head.follow(np.array([axes[3], [0.0, 0.0, 1.0], axes[3]]), (-60, 60), (-360, 360))
    assert upright[1].tolist() == [0.0, upright[0, 1]]


def test_axes_of_a_tilted_tool_stand_off_by_the_arm():
    axis = np.array([[0.6, 0.0, 0.8]])
    stands = axis_positions(np.zeros((1, 3)), axis, 100.0)
    np.testing.assert_allclose(stands, [[60.0, 0.0, -20.0]])


def test_pieces_too_close_are_an_error_that_names_both():
    piece = steepest()
    other = replace(piece, address="other")
    width = float(np.ptp(piece.silhouette[:, 0]))
    needed = contour_reach([piece], TOOLS[8], FREE)

    def with_gap(gap):
        places = (
            Placement(piece.address, 0.0, 100.0, 100.0),
            Placement("other", 0.0, 100.0 + width + gap, 100.0),
        )
        sheet = replace(alone(piece), placements=places)
        return toolpaths(sheet, [piece, other], TOOLS, MACHINE, FREE)

    assert with_gap(needed + 0.1).steps
    with pytest.raises(MachineError, match=r"mm into .* Nest with a spacing of at least") as found:
        with_gap(1.0)
    assert set(found.value.addresses) == {piece.address, "other"}
    with pytest.raises(MachineError, match=f"at least {needed:.1f} mm"):
        with_gap(1.0)


def test_bridges_without_room_are_an_error():
    with pytest.raises(MachineError, match="Fewer than 2 bridges of 500 mm would hold") as found:
        cut_steepest(Settings(tab_length=500.0))
    assert found.value.addresses == (steepest().address,)


def test_tilt_beyond_the_head_names_address_side_and_angle():
    with pytest.raises(
        MachineError, match=r"cut side \d of \S+ towards \S+ is inclined by -?40\.32 degrees; .* 40"
    ) as found:
        cut_steepest(machine=replace(MACHINE, tilt=(-40.0, 40.0)))
    assert abs(found.value.values["angle"]) == pytest.approx(40.322, abs=1e-3)
    assert cut_steepest(machine=replace(MACHINE, tilt=(-10.0, 41.0))).steps


def test_spoilboard_bounds_the_depth():
    piece = steepest()
    deepest = 0.5 + 6.0 * np.sin(np.radians(max(s.inclination for s in piece.sides)))
    with pytest.raises(MachineError, match=rf"reaches {deepest:.2f} mm below the sheet") as found:
        cut_steepest(machine=replace(MACHINE, spoilboard_depth=3.0))
    assert found.value.values["depth"] == pytest.approx(deepest)
    flat, sheet = planks_flat()
    with pytest.raises(MachineError, match=r"hole of 5 mm .* 2.00 mm below the sheet"):
        toolpaths(sheet, flat, TOOLS, replace(MACHINE, spoilboard_depth=1.0), FREE)


def planks_flat():
    """Return a piece without chamfers, with holes of 5 mm."""
    pieces, sheets = planks()
    piece = pieces[0]
    drill = replace(piece.drills[0], diameter=5.0)
    piece = replace(piece, drills=(drill,))
    return [piece], replace(alone(piece, material=sheets[0].stock.material), number=1)


def only(name, **changes):
    """Return the tools with one of them changed."""
    return [replace(tool, **changes) if tool.name == name else tool for tool in TOOLS]


def mills(**changes):
    return [replace(t, **changes) for t in TOOLS if t.name == "end mill 6"] + [
        tool for tool in TOOLS if tool.kind != "end mill"
    ]


@pytest.mark.parametrize(
    ("tools", "message"),
    [
        (mills(flank=18.0), r"needs 18\.9 mm of flank; tool 9 \(end mill 6\) has 18 mm"),
        (mills(reach=27.0), r"the holder of tool 9 \(end mill 6\) would come -?\d"),
        (mills(materials=("oak",)), "There is no end mill for this material"),
        ([t for t in TOOLS if t.kind != "drill"], "needs a drill of 5 mm; .* there are none"),
        ([t for t in TOOLS if t.name != "drill 5"], "needs a drill of 5 mm; .* 3, 4, 6"),
        ([t for t in TOOLS if t.kind != "engraver"], "needs an engraver of 3 mm"),
        (only("engraver 3", flank=0.4), r"The address of \S+ is 0.5 mm deep; tool 8"),
        (only("drill 5", flank=11.0), r"hole of 5 mm in \S+ takes tool 3 \(drill 5\) 12.0 mm deep"),
        (only("end mill 6", speed=30000), "Tool 9 .* turns at 30000 1/min; the spindle of"),
        (only("engraver 3", feed=20000), "Tool 8 .* feeds at 20000 mm/min"),
    ],
)
def test_tool_that_does_not_do_is_an_error(tools, message):
    with pytest.raises(MachineError, match=message):
        cut_steepest(tools=tools)


def test_chosen_end_mill_is_taken_or_missed():
    assert contour(cut_steepest(replace(FREE, contour_tool=10))).tool.number == 10
    with pytest.raises(MachineError, match="There is no end mill with the number 3"):
        cut_steepest(replace(FREE, contour_tool=3))


def test_longer_end_mill_is_taken_where_the_thinnest_is_too_short():
    pieces, sheets = planks()
    step = contour(toolpaths(sheets[0], pieces, TOOLS, MACHINE))
    assert step.tool.flank >= 40.5
    assert all(t.flank < 40.5 for t in TOOLS if t.kind == "end mill" and t.diameter < 10)


@pytest.mark.parametrize(
    ("machine", "message"),
    [
        ({"x": (0.0, 600.0)}, r"would take the X axis to \d+\.\d mm; it travels from 0 to 600"),
        ({"z": (-20.0, 700.0)}, r"EDGE .* would take the Z axis to -\d+\.\d mm"),
        ({"safe_height": 4.0}, "safe height of 4 mm above the sheet must exceed the clearance"),
    ],
)
def test_travel_beyond_the_machine_is_an_error(machine, message):
    with pytest.raises(MachineError, match=message):
        cut_steepest(machine=replace(MACHINE, **machine))


def test_clamp_in_the_way_is_an_error():
    program = cut_steepest()
    tips = contour(program).moves.tips
    x, y = tips[:, 0].min(), tips[:, 1].min()

    def clamped(box):
        return cut_steepest(machine=replace(MACHINE, clamps=(box,)))

    assert clamped(Clamp((x - 300, x - 200), (y - 300, y - 200), (0.0, 30.0))).steps
    with pytest.raises(MachineError, match=r"comes within 4 mm of the clamp at x"):
        clamped(Clamp((x - 10, x + 10), (y, y + 400), (0.0, 30.0)))
    with pytest.raises(MachineError, match="raise the safe height"):  # higher than it is flown over
        clamped(Clamp((0.0, 2500.0), (480.0, 490.0), (0.0, 60.0)))


def test_clamp_where_the_head_is_parked_is_an_error():
    high = Clamp((-310.0, -290.0), (-310.0, -290.0), (0.0, 60.0))
    machine = replace(MACHINE, clamps=(high,))
    with pytest.raises(MachineError, match=r"going to where the head is parked: .* or park the"):
        cut_steepest(machine=machine)
    assert cut_steepest(machine=replace(machine, park=(-300.0, 100.0))).steps


def test_piece_that_is_not_convex_is_an_error():
    piece = steepest()
    side = piece.sides[0]
    turned = replace(side, normal=-side.normal)
    with pytest.raises(MachineError, match=r"is not convex: it stands \S+ mm out over"):
        toolpaths(alone(piece), [replace(piece, sides=(turned, *piece.sides[1:]))], TOOLS, MACHINE)


def test_sheet_and_workpieces_must_belong_together():
    piece = steepest()
    with pytest.raises(InputError, match=rf"sheet-01 holds {piece.address}, which are not among"):
        toolpaths(alone(piece), [], TOOLS, MACHINE)
    with pytest.raises(InputError, match=r"is 10 mm thick and lies on sheet-01 of 12 mm"):
        toolpaths(alone(piece, thickness=12.0), [piece], TOOLS, MACHINE)
    empty = NestedSheet(1, alone(piece).stock, (), 0.0, np.empty((0, 4)))
    with pytest.raises(InputError, match="sheet-01 is empty"):
        toolpaths(empty, [piece], TOOLS, MACHINE)


def test_address_that_is_only_drawn_is_engraved_by_the_thinnest_cutter():
    piece = steepest()
    drawn = replace(piece, engraving=replace(piece.engraving, depth=0.0, cutter=0.0))
    program = toolpaths(alone(piece), [drawn], TOOLS, MACHINE, replace(FREE, stroke_depth=0.7))
    step = program.steps[1]
    assert step.tool.name == "engraver 1"
    assert step.moves.tips[:, 2].min() == pytest.approx(9.3)
    levels = np.unique(np.round(step.moves.tips[step.moves.feeds > 0, 2], 9))
    np.testing.assert_allclose(levels, [9.3, 9.65])


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"hold": "glue"}, "hold must be one of tabs, skin, none, got 'glue'"),
        ({"direction": "up"}, "direction must be one of climb, conventional"),
        ({"tab_length": 0.0}, "tab_length must be above 0"),
        ({"skin": np.nan}, "skin must be above 0"),
        ({"clearance": np.inf}, "clearance must be above 0"),
        ({"breakthrough": -0.1}, "breakthrough must be 0 or more"),
        ({"lead": -1.0}, "lead must be 0 or more"),
        ({"pass_depth": 0.0}, "pass_depth must be above 0"),
        ({"stroke_depth": 0.0}, "stroke_depth must be above 0"),
    ],
)
def test_settings_that_cannot_be_meant_are_an_error(values, message):
    with pytest.raises(InputError, match=message):
        Settings(**values)
