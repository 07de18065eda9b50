"""Programs, judged by LinuxCNC's interpreter and compared with the workpieces they leave."""

import re
from dataclasses import replace

import numpy as np
import pytest
from machining import (
    BY_NUMBER,
    MACHINE,
    TOOLS,
    alone,
    placed_sides,
    planks,
    prototype,
    random_shell,
)
from rs274 import axis_of, needs_rs274, run

from ifs_cad.elements.arcs import Segments
from ifs_cad.errors import ExportError, InputError, MachineError
from ifs_cad.export.gcode import export_gcode, gcode
from ifs_cad.fabrication.machining.machine_time import machining_time
from ifs_cad.fabrication.machining.orientation import RotaryHead
from ifs_cad.fabrication.machining.post import FANUC, LINUXCNC, Post
from ifs_cad.fabrication.machining.settings import Settings
from ifs_cad.fabrication.machining.toolpath import toolpaths
from ifs_cad.fabrication.machining.verify import verify

NEAR = 1e-3  # mm and degrees


def a_program(settings=None, machine=MACHINE):
    pieces, _ = prototype()
    piece = max(pieces, key=lambda p: max(abs(s.inclination) for s in p.sides))
    sheet = alone(piece, turn=37.5)
    return pieces, sheet, toolpaths(sheet, pieces, TOOLS, machine, settings)


def flank_faults(motions, pieces, sheet, axis=axis_of, climb=True):
    """Return the largest distance and angle of any flank from its side, and sides never cut."""
    radius = {number: tool.diameter / 2 for number, tool in BY_NUMBER.items()}
    found = {}
    for motion in motions:
        if motion.step == "contour" and motion.kind == "feed":
            way = motion.end - motion.start
            tool = axis(motion.head)
            if np.linalg.norm(way - way @ tool * tool) > 1.0:  # along the edge, not along the tool
                number = int(motion.note.split()[1])
                found.setdefault((motion.address, number), []).append((motion, way, tool))
    distance = angle = 0.0
    missing = []
    for address, number, _side, normal, corners in placed_sides(pieces, sheet):
        cuts = found.pop((address, number), [])
        reached = []
        for motion, way, tool in cuts:
            across = np.cross(tool, way) if climb else np.cross(way, tool)
            across /= np.linalg.norm(across)
            contacts = np.array([motion.start, motion.end]) - radius[motion.tool] * across
            far = 200.0 * tool  # the flank goes on upward
            heights = np.concatenate([contacts, contacts + 40.0 / 200.0 * far]) - corners[0]
            distance = max(distance, np.abs(heights @ normal).max())
            cosine, sine = across @ normal, np.linalg.norm(np.cross(across, normal))
            angle = max(angle, np.degrees(np.arctan2(sine, cosine)))
            travel = way / np.linalg.norm(way)
            reached += [contacts @ travel]
        if not cuts:
            missing.append((address, number))
            continue
        ends, along = np.concatenate(reached), corners @ travel
        if ends.min() > along.min() - 1.0 or ends.max() < along.max() + 1.0:
            missing.append((address, number))
    missing += found
    return distance, angle, missing


def hole_and_stroke_faults(motions, pieces, sheet):
    """Return the largest distances of holes and of stroke vertices from where they belong."""
    by_address = {piece.address: piece for piece in pieces}
    hole = stroke = 0.0
    for placement in sheet.placements:
        piece = by_address[placement.address]
        own = [motion for motion in motions if motion.address == piece.address]
        drilled = np.array(
            [m.end for m in own if m.step == "pierce" and m.kind == "feed" and m.end[2] < 0.0]
        )
        wanted = np.concatenate([placement(d.points) for d in piece.drills])
        assert len({tuple(point) for point in drilled[:, :2].tolist()}) == len(wanted)
        gaps = np.linalg.norm(drilled[:, None, :2] - wanted, axis=-1)
        hole = max(hole, gaps.min(axis=0).max(), gaps.min(axis=1).max())
        drawn = [m for m in own if m.step == "engrave" and m.kind != "rapid"]
        level = piece.thickness - piece.engraving.depth
        assert all(abs(m.end[2] - level) < NEAR for m in drawn)
        along = [m for m in drawn if np.abs((m.end - m.start)[:2]).max() > 1e-6]
        paths = piece.engraving.strokes
        ends = np.concatenate([placement(path.ends) for path in paths if len(path.bulges)])
        stroke = max(stroke, np.abs(np.array([m.end[:2] for m in along]) - ends).max())
        sweeps = np.concatenate([path.sweeps for path in paths])
        centres = np.concatenate([placement(path.centres) for path in paths if len(path.bulges)])
        for motion, sweep, centre in zip(along, sweeps, centres, strict=True):
            assert (motion.kind == "arc") == (sweep != 0.0)
            if motion.arc:
                assert motion.arc[2] == np.sign(sweep)
                stroke = max(stroke, np.abs(np.array(motion.arc[:2]) - centre).max())
    return hole, stroke


def assert_is_cut_as_designed(pieces, sheet, folder, settings=None):
    program = toolpaths(sheet, pieces, TOOLS, MACHINE, settings)
    text = gcode(program)
    found = verify(
        text, sheet, pieces, TOOLS, MACHINE, settings=settings, linuxcnc=False, simulate=False
    )
    assert found.ok, str(found)  # no gouge, no collision, nothing left out
    outcome = run(text, TOOLS, folder)
    assert outcome.accepted, outcome.errors
    assert outcome.ended
    assert not outcome.errors.strip() or "executing" in outcome.errors
    motions = outcome.motions
    climb = settings is None or settings.direction == "climb"
    distance, angle, missing = flank_faults(motions, pieces, sheet, climb=climb)
    assert not missing
    assert distance < NEAR
    assert angle < NEAR
    if pieces[0].drills and pieces[0].engraving:
        hole, stroke = hole_and_stroke_faults(motions, pieces, sheet)
        assert hole < NEAR
        assert stroke < NEAR
    assert_moves_are_safe(motions, program)
    steps = [motion.step for motion in motions if motion.step]
    assert steps == sorted(steps, key=["pierce", "engrave", "contour"].index)


def assert_moves_are_safe(motions, program):
    """Cut only with spindle and feed on, turn only high up, never rapid into the sheet."""
    thickness = program.sheet.stock.thickness
    before = np.zeros(3)
    for motion in motions:
        if motion.kind != "rapid":
            assert motion.spindle
            assert motion.feed > 0
        if not np.array_equal(motion.head, before):
            assert motion.kind == "rapid"
            assert motion.end[2] == pytest.approx(program.safe, abs=NEAR)
            assert np.isnan(motion.start[2]) or motion.start[2] == pytest.approx(program.safe)
        if motion.kind == "rapid" and np.abs((motion.end - motion.start)[:2]).max() > 0.0:
            tool = axis_of(motion.head)
            sideways = (motion.end - motion.start) - (motion.end - motion.start) @ tool * tool
            rim = BY_NUMBER[motion.tool].diameter / 2 * np.sqrt(1 - min(tool[2], 1.0) ** 2)
            if np.linalg.norm(sideways) > NEAR:
                assert min(motion.start[2], motion.end[2]) - rim > thickness
        before = motion.head


@needs_rs274
@pytest.mark.parametrize("place", [0, 5, -1])
def test_prototype_is_cut_as_designed(place, tmp_path):
    pieces, sheets = prototype()
    assert_is_cut_as_designed(pieces, sheets[place], tmp_path)


@needs_rs274
@pytest.mark.slow
def test_every_sheet_of_the_prototype_is_cut_as_designed(tmp_path):
    pieces, sheets = prototype()
    for sheet in sheets:
        assert_is_cut_as_designed(pieces, sheet, tmp_path)


@needs_rs274
@pytest.mark.parametrize(
    "settings",
    [
        Settings(hold="none", direction="conventional"),
        Settings(hold="skin", breakthrough=0.0),
        Settings(contour_tool=10, lead=2.0, pass_depth=3.0),
    ],
)
def test_settings_do_not_move_planes(settings, tmp_path):
    pieces, sheet, _ = a_program()
    assert_is_cut_as_designed(pieces, sheet, tmp_path, settings)


@needs_rs274
def test_vault_planks_are_cut_as_designed(tmp_path):
    pieces, sheets = planks()
    for sheet in sheets:
        assert_is_cut_as_designed(pieces, sheet, tmp_path)


def some_shells(count, first=0):
    """Return pieces and sheets of random shells that can be designed."""
    found, seed = [], first
    while len(found) < count:
        shell = random_shell(seed)
        seed += 1
        if shell is not None:
            found.append(shell)
    return found


@needs_rs274
def test_random_shells_are_cut_as_designed(tmp_path):
    for pieces, sheets in some_shells(3, first=9):
        for sheet in sheets:
            assert_is_cut_as_designed(pieces, sheet, tmp_path)


@needs_rs274
@pytest.mark.slow
def test_hundred_random_shells_are_cut_as_designed(tmp_path):
    partial = 0
    for pieces, sheets in some_shells(100):
        for sheet in sheets:
            assert_is_cut_as_designed(pieces, sheet, tmp_path)
        for side in (side for piece in pieces for side in piece.sides):
            low, high = side.corners[:, 2].min(), side.corners[:, 2].max()
            partial += low > NEAR or high < pieces[0].thickness - NEAR
    assert partial > 100  # reliefs and floors that reach one face only are among them


@needs_rs274
def test_flipped_sign_of_the_tilt_is_seen(tmp_path):
    pieces, sheet, program = a_program()
    wrong = replace(LINUXCNC, head=RotaryHead("BC", tilt_sign=1))
    outcome = run(gcode(program, wrong), TOOLS, tmp_path)
    assert outcome.accepted
    steepest = max(abs(side.inclination) for _, _, side, _, _ in placed_sides(pieces, sheet))
    _, angle, _ = flank_faults(outcome.motions, pieces, sheet)
    assert angle > steepest > 40.0


@needs_rs274
def test_fanuc_program_is_the_same_with_other_angles(tmp_path):
    machine = replace(MACHINE, rotary="AC")
    pieces, sheet, program = a_program(machine=machine)
    text = gcode(program, FANUC)
    assert text.startswith("%\nO0001\nN10 (SHEET sheet-01 2500 x 1250 x 10)\n")
    assert text.endswith("M30\n%\n")
    assert "G43.4 H9 G0 Z50." in text
    # without its point a whole number would count in the control's smallest unit
    assert not re.search(r"[XYZACIJR]-?\d+( |$)", text.replace("(", "\n("), re.MULTILINE)
    assert "G81" not in text
    plain = text.replace("G43.4", "G43").replace("O0001\n", "")
    outcome = run(plain, TOOLS, tmp_path)
    assert outcome.accepted, outcome.errors

    def textbook(head):
        a, _, c = np.radians(head)
        return np.array([np.sin(a) * np.sin(c), -np.sin(a) * np.cos(c), np.cos(a)])

    distance, angle, missing = flank_faults(outcome.motions, pieces, sheet, axis=textbook)
    assert not missing
    assert distance < NEAR
    assert angle < NEAR
    assert np.ptp([motion.head[0] for motion in outcome.motions]) > 20.0
    assert not np.any([motion.head[1] for motion in outcome.motions])


@needs_rs274
def test_without_control_of_the_tip_the_axes_carry_it_to_the_same_places(tmp_path):
    pieces, sheet, program = a_program()
    post = replace(LINUXCNC, tool_centre_point=False)
    outcome = run(gcode(program, post), TOOLS, tmp_path)
    assert outcome.accepted
    for motion in outcome.motions:
        # from the crossing of the rotary axes down to the tip
        arm = MACHINE.pivot + BY_NUMBER[motion.tool].length
        shift = arm * (axis_of(motion.head) - [0, 0, 1])
        start = motion.start - shift
        motion.start, motion.end = start, motion.end - shift
    distance, angle, missing = flank_faults(outcome.motions, pieces, sheet)
    assert not missing
    assert distance < NEAR
    assert angle < NEAR
    # while the head turns nothing else moves, and the tip is nowhere below the safe height
    for line in gcode(program, post).splitlines():
        if re.search(r" B", line) and "G0 B0 C0" not in line:
            assert re.fullmatch(r"G0( B\S+)?( C\S+)?", line)


@pytest.mark.parametrize("place", [0, -1])
def test_program_without_control_of_the_tip_is_verified(place):
    pieces, sheets = prototype()
    post = replace(LINUXCNC, tool_centre_point=False)
    text = gcode(toolpaths(sheets[place], pieces, TOOLS, MACHINE), post)
    found = verify(
        text,
        sheets[place],
        pieces,
        TOOLS,
        MACHINE,
        convention=post.convention(MACHINE),
        linuxcnc=False,
        simulate=False,
    )
    assert found.ok, str(found)


def waits_of(machine, settings, folder, post=LINUXCNC):
    """Return the program, and where LinuxCNC waits for a person in it."""
    pieces, sheets = prototype()
    program = toolpaths(sheets[-1], pieces, TOOLS, machine, settings)
    text = gcode(program, post)
    found = verify(
        text,
        sheets[-1],
        pieces,
        TOOLS,
        machine,
        settings=settings,
        convention=post.convention(machine),
        linuxcnc=False,
        simulate=False,
    )
    assert found.ok, str(found)
    outcome = run(text, TOOLS, folder)
    assert outcome.accepted, outcome.errors
    return program, found, outcome


@needs_rs274
@pytest.mark.parametrize("tip", [True, False])
@pytest.mark.parametrize("park", [None, (-420.0, 1310.5)])
def test_head_is_parked_with_a_still_spindle_before_the_pieces_are_screwed_down(
    park, tip, tmp_path
):
    machine, post = replace(MACHINE, park=park), replace(LINUXCNC, tool_centre_point=tip)
    program, found, outcome = waits_of(machine, Settings(hold="none"), tmp_path, post)
    stops = [wait for wait in outcome.waits if wait.name == "PROGRAM_STOP"]
    (stop,) = stops
    x, y = park or (-300.0, -300.0)
    # the length is not in force any more, so LinuxCNC tells the height of the gauge line
    drill = program.steps[0].tool
    np.testing.assert_allclose(stop.place, [x, y, program.safe], atol=NEAR)
    assert not stop.head.any()
    assert not stop.spindle
    assert (stop.step, drill.kind) == ("pierce", "drill")
    # it starts anew before it cuts, and ends aside too, where the pieces are taken off
    after = [m for m in outcome.motions if m.step == "engrave" and m.kind != "rapid"]
    assert all(motion.spindle for motion in after)
    np.testing.assert_allclose(outcome.motions[-1].end, [x, y, program.safe], atol=NEAR)
    assert (found.tool_changes, found.stops) == (3, 1)


@needs_rs274
def test_pieces_that_bridges_hold_need_no_stop(tmp_path):
    _, found, outcome = waits_of(MACHINE, Settings(), tmp_path)
    assert [wait.name for wait in outcome.waits] == 3 * ["CHANGE_TOOL"]
    assert (found.tool_changes, found.stops) == (3, 0)
    over = [wait.place for wait in outcome.waits[1:]]
    assert all(place[0] > 0.0 for place in over)  # a magazine changes where it likes


@needs_rs274
def test_head_is_parked_for_tools_that_a_person_changes(tmp_path):
    machine = replace(MACHINE, change_by_hand=True)
    program, _, outcome = waits_of(machine, Settings(), tmp_path)
    first, *others = [wait for wait in outcome.waits if wait.name == "CHANGE_TOOL"]
    assert np.isnan(first.place).all()  # where it was left before the program
    assert len(others) == 2
    for wait in others:
        np.testing.assert_allclose(wait.place, [-300.0, -300.0, program.safe], atol=NEAR)
        assert not wait.head.any()
        assert not wait.spindle


@needs_rs274
def test_inverse_time_feeds_are_accepted_and_take_as_long(tmp_path):
    _, _, program = a_program()
    text = gcode(program, replace(LINUXCNC, feed_mode="G93"))
    assert "G81" not in text
    outcome = run(text, TOOLS, tmp_path)
    assert outcome.accepted, outcome.errors
    cutting = [line for line in text.splitlines() if re.match(r"G[123] ", line)]
    minutes = sum(1.0 / float(line.split(" F")[1]) for line in cutting)
    feeds = np.concatenate([step.moves.feeds for step in program.steps])
    lengths = np.concatenate([step.moves.lengths for step in program.steps])
    cut = feeds > 0
    assert minutes == pytest.approx((lengths[cut] / feeds[cut]).sum(), rel=1e-3)


@needs_rs274
def test_holes_are_drilled_alike_without_cycles(tmp_path):
    _, _, program = a_program()
    places = []
    for cycles in (True, False):
        outcome = run(gcode(program, replace(LINUXCNC, cycles=cycles)), TOOLS, tmp_path)
        assert outcome.accepted
        places.append(
            [tuple(m.end) for m in outcome.motions if m.step == "pierce" and m.kind == "feed"]
        )
    assert places[0] == places[1]
    assert len(places[0]) == 4


@needs_rs274
def test_deep_holes_are_pecked(tmp_path):
    pieces, sheets = planks()
    program = toolpaths(sheets[0], pieces, TOOLS, MACHINE)
    text = gcode(program)
    assert "G98 G83 " in text
    assert " Q21 " in text
    outcome = run(text, TOOLS, tmp_path)
    drill = program.steps[0].tool
    deepest = min(m.end[2] for m in outcome.motions if m.step == "pierce")
    cone = drill.diameter / 2 / np.tan(np.radians(59))
    assert deepest == pytest.approx(-0.5 - cone, abs=NEAR)


def test_programs_follow_the_rules_of_good_practice():
    pieces, sheets = prototype()
    for sheet in (sheets[0], sheets[-1]):
        text = gcode(toolpaths(sheet, pieces, TOOLS, MACHINE))
        lines = text.splitlines()
        code = [line for line in lines if not line.startswith("(")]
        assert code[0] == "G21 G17 G90 G94 G40 G49 G80 G54 G61"
        assert code[-1] == "M30"
        assert max(map(len, lines)) < 255
        assert text.isascii()
        for line in code:
            assert re.fullmatch(r"([A-Z]-?\d+(\.\d+)?( |$))+", line), line
            assert not re.search(r"-0( |$)|[A-Z]\d+[eE]", line)
        assert lines[0] == f"(SHEET {sheet.name} 2500 x 1250 x 10)"
        steps = [line for line in lines if line.startswith("(STEP")]
        assert steps == [
            "(STEP pierce TOOL 3 D5)",
            "(STEP engrave TOOL 8 D3)",
            "(STEP contour TOOL 9 D6)",
        ]
        named = re.findall(r"\(ADDRESS (\S+)\)", text)
        addresses = sorted(one.address for one in sheet.placements)
        assert sorted(named) == sorted(3 * addresses)


def test_edges_of_one_pass_are_one_line_each():
    _, _, program = a_program(Settings(hold="none", pass_depth=1000.0))
    text = gcode(program).split("(STEP contour")[1]
    for edge in text.split("(EDGE")[1:]:
        assert len(re.findall(r"^G1 ", edge, re.M)) == 2  # down along the tool, and along the edge
        assert len(re.findall(r"^G0 X.* B", edge, re.M)) == 1


def test_time_is_that_of_the_moves():
    _, _, program = a_program(Settings(hold="none"))
    time = machining_time(program)
    seconds = time.seconds
    assert (time.tool_changes, time.stops) == (3, 1)
    by_hand = 0.0
    for step in program.steps:
        moves = step.moves
        for k in range(1, len(moves)):
            way = np.linalg.norm(moves.tips[k] - moves.tips[k - 1])
            if moves.bulges[k]:
                sweep = 4 * np.arctan(abs(moves.bulges[k]))
                way *= sweep / (2 * np.sin(sweep / 2))
            if moves.feeds[k]:
                by_hand += 60 * way / moves.feeds[k]
        by_hand += MACHINE.tool_change
    rapid = seconds - by_hand
    assert 5 < rapid < 30
    faster = replace(MACHINE, rapid=2 * MACHINE.rapid, rotation=2 * MACHINE.rotation)
    half = machining_time(program, faster).seconds
    assert half == pytest.approx(by_hand + rapid / 2, rel=1e-9)
    slower = replace(MACHINE, tool_change=MACHINE.tool_change + 100.0)
    assert machining_time(program, slower).seconds == pytest.approx(seconds + 300.0, rel=1e-9)
    hours, minutes, rest = re.search(
        r"\(TIME (\d+):(\d+):(\d+) WITH 3 TOOL CHANGES AND 1 STOP FOR A PERSON, NOT TIMED\)",
        gcode(program),
    ).groups()
    written = int(hours) * 3600 + int(minutes) * 60 + int(rest)
    assert written == pytest.approx(seconds, abs=0.51)


def test_stroke_lengths_agree_with_the_moves():
    pieces, _, program = a_program()
    (cut,) = program.steps[1].cuts
    piece = next(piece for piece in pieces if piece.address == cut.address)
    drawn = Segments.of(piece.engraving.strokes).lengths.sum()
    level = np.isclose(cut.moves.tips[:, 2], 9.5) & np.isclose(
        np.roll(cut.moves.tips[:, 2], 1), 9.5
    )
    assert cut.moves.lengths[level].sum() == pytest.approx(drawn, rel=1e-9)


def test_file_is_the_text(tmp_path):
    _, _, program = a_program()
    path = export_gcode(program, tmp_path / "new" / "sheet-01.ngc")
    assert path.read_bytes() == gcode(program).encode("ascii")
    (tmp_path / "folder.ngc").mkdir()
    with pytest.raises(ExportError):
        export_gcode(program, tmp_path / "folder.ngc")


def test_post_for_another_head_is_an_error():
    _, _, program = a_program()
    with pytest.raises(MachineError, match=r"Fanuc G43.4 is for AC heads; .* has the axes BC"):
        gcode(program, FANUC)


@pytest.mark.parametrize(
    "values", [{"feed_mode": "G95"}, {"decimals": -1}, {"angle_decimals": 10}, {"line_numbers": -5}]
)
def test_post_that_cannot_be_meant_is_an_error(values):
    with pytest.raises(InputError, match=next(iter(values))):
        Post("x", RotaryHead(), **values)


def test_comments_can_be_left_out_and_never_end_early():
    _, sheet, program = a_program()
    assert "(" not in gcode(program, replace(LINUXCNC, comments=False))
    odd = replace(sheet, stock=replace(sheet.stock, name="ply (old) é"))
    text = gcode(replace(program, sheet=odd))
    assert "(STOCK ply [old] ?)" in text
