"""Verification: a sound program passes, and every broken one is caught at its line."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from broken_programs import (
    SETTINGS,
    THICKNESS,
    broken_programs,
    changed,
    found,
    machine,
    pieces,
    program,
    sheet,
    tools,
    without,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from ifs_cad.errors import AddressError, InputError
from ifs_cad.fabrication.layout import Layout
from ifs_cad.fabrication.machining.convention import RIGHT_HANDED_AC, Convention
from ifs_cad.fabrication.machining.job import Job, read_job, write_job
from ifs_cad.fabrication.machining.settings import Settings
from ifs_cad.fabrication.machining.swept import Solids, Sweeps, depths
from ifs_cad.fabrication.machining.verify import verify, verify_file

BROKEN = broken_programs()


def verified(text: str, **options):
    options = {"settings": SETTINGS, "linuxcnc": False} | options
    held = options.pop("machine", None) or machine()
    magazine = options.pop("tools", None) or tools()
    return verify(text, sheet(), pieces(), magazine, held, **options)


def test_sound_program_is_verified_with_its_numbers():
    found_ = verified(program(), linuxcnc=None)
    assert found_.ok, str(found_)
    assert (found_.holes, found_.strokes, found_.sides) == (4, 8, 9)
    # five decimals of positions, six of angles
    assert found_.plane_error < 2e-5
    assert found_.angle_error < 1e-5
    assert found_.hole_error < 1e-5
    assert found_.stroke_error < 2e-5
    assert "verified" in str(found_)


@pytest.mark.parametrize("broken", BROKEN, ids=[broken.name for broken in BROKEN])
def test_broken_program_is_caught_at_its_line(broken):
    found_ = verified(broken.text, machine=broken.machine, tools=broken.tools, simulate=False)
    at_line = [str(fault) for fault in found_.faults if fault.line == broken.line]
    assert any(re.search(broken.blame, fault) for fault in at_line), str(found_)
    assert not found_.ok


def test_simulation_sees_gouges_and_what_is_left():
    cut = found(r"G0 B\d+\.\d+ C", after=found("STEP contour")) + 3
    across = verified(changed(cut, r"X[-\d.]+ Y[-\d.]+", "X470 Y160"))
    assert any("By simulation" in f.message and f.address == "0212" for f in across.faults)
    lines = program().splitlines()
    del lines[cut - 1]
    left = verified("\n".join(lines) + "\n")
    assert any("left uncut" in fault.message for fault in left.faults)


def test_removed_volume_is_that_of_one_slot():
    """One upright pass of 12 mm: a stadium of known area."""
    lines = [
        "G21 G90 G94", "T12 M6", "S18000 M3", "G43 H12", "G0 Z60", "G0 X100 Y400 B0 C0",
        "G0 Z12", "G1 Z0 F1000", "G1 X400 F5000", "G0 Z60", "M30",
    ]  # fmt: skip
    removed = verified("\n".join(lines) + "\n").removed
    assert removed == pytest.approx((300 * 12 + math.pi * 36) * THICKNESS, rel=5e-3)
    assert math.isnan(verified("\n".join(lines), simulate=False).removed)


def test_bridges_and_skin_are_left_only_where_they_were_asked_for():
    cut = found(r"G0 B0\.0", after=found("STEP contour")) + 3
    lifted = program().splitlines()
    for number in (cut - 1, cut):
        lifted[number - 1] = re.sub(
            r"Z([-\d.]+)", lambda hit: f"Z{float(hit[1]) + 0.9:.5f}", lifted[number - 1]
        )
    text = "\n".join(lifted) + "\n"
    assert not verified(text).ok

    def left(settings):
        faults = verified(text, settings=settings, simulate=False).faults
        return [f.line for f in faults if "left uncut" in f.message]

    assert left(Settings(hold="skin", skin=0.4)) == []
    assert left(Settings(hold="skin", skin=0.3)) == [cut]
    # a bridge is not as long as a side
    assert not verified(text, settings=Settings(hold="tabs")).ok


@pytest.mark.parametrize(
    ("settings", "blame"),
    [
        (Settings(hold="tabs"), "0 bridges hold it, at least 2 must"),
        (Settings(hold="skin"), "the skin is 0.4 mm"),
        (replace(SETTINGS, direction="conventional"), "not a conventional cut"),
        (replace(SETTINGS, pass_depth=4.0), "A pass takes .* 4 mm are allowed"),
    ],
)
def test_program_that_does_not_follow_the_settings_is_caught_at_each_piece(settings, blame):
    found_ = verified(program(), settings=settings, simulate=False)
    blamed = {fault.address for fault in found_.faults if re.search(blame, fault.message)}
    assert blamed == {"0211", "0212"}, str(found_)


@pytest.mark.parametrize("word", ["G21", "G90", "G17"])
def test_program_that_trusts_what_the_machine_was_last_told_is_caught(word):
    text = re.sub(rf"\b{word}\b *", "", program())
    assert word not in text
    assert any(f"{word} is missing" in fault.message for fault in verified(text).faults)


def test_path_that_may_be_rounded_is_caught_at_its_line():
    line = found("G21")
    for mode, amount in (("G64", "any amount"), ("G64 P2", "2 mm")):
        faults = verified(changed(line, "G21", f"G21 {mode}"), simulate=False).faults
        assert [(fault.line, amount in fault.message) for fault in faults] == [(line, True)]
    for mode in ("G61", "G64 P0.001"):
        assert verified(changed(line, "G21", f"G21 {mode}"), simulate=False).ok


@pytest.mark.parametrize("code", ["M0", "M5", "T12 M6"])
def test_stop_or_tool_change_in_the_sheet_is_caught_at_its_line(code):
    cut = found(r"G0 B\d+\.\d+ C", after=found("STEP contour")) + 3
    lines = program().splitlines()
    lines.insert(cut - 1, code)
    faults = verified("\n".join(lines) + "\n", simulate=False).faults
    assert any(f.line == cut and f.message.startswith(code.split()[-1]) for f in faults)


def test_minutes_hold_tool_changes_and_dwells_and_stops_are_counted():
    plain = verified(program(), simulate=False)
    assert (plain.tool_changes, plain.stops) == (3, 1)
    slow = replace(machine(), tool_change=machine().tool_change + 60.0)
    later = verified(program(), machine=slow, simulate=False)
    assert later.minutes == pytest.approx(plain.minutes + 3.0)
    waiting = verified(changed(found("^M0"), "^", "G4 P90\n"), simulate=False)
    assert waiting.minutes == pytest.approx(plain.minutes + 1.5)
    assert "min with 3 tool changes and 1 stop for a person, not timed" in str(plain)
    assert plain.as_dict()["tool_changes"] == 3


def test_stop_between_the_holes_and_the_contour_of_each_piece_is_enough():
    """One piece after the other: pierced, screwed down, cut out."""
    lines = program().splitlines()
    stop = found("^M0")
    later = [*lines[: found("STEP contour") - 1]]
    del later[stop - 1]
    after_engraving = [
        *later,
        "G0 X-150 Y250",
        "M5",
        "M0",
        *lines[found("STEP contour") - 1 :],
    ]
    assert verified("\n".join(after_engraving) + "\n").ok


def test_pieces_held_otherwise_need_no_stop():
    def of_screws(settings):
        text = without(found("^M0"))
        faults = verified(text, settings=settings, simulate=False).faults
        return [fault for fault in faults if "screwed" in fault.message]

    assert len(of_screws(SETTINGS)) == 1
    assert of_screws(Settings(hold="tabs")) == of_screws(Settings(hold="skin")) == []


def test_head_may_wait_anywhere_beside_the_sheet_where_no_place_is_named():
    anywhere = replace(machine(), park=None)
    stop = found("^M0")

    def at(x):
        text = changed(stop - 1, "X-150", f"X{x}")
        return [f.line for f in verified(text, machine=anywhere, simulate=False).faults]

    holder = next(tool.holder for tool in tools() if tool.number == 5)
    assert at(-holder / 2 - 0.1) == at(800 + holder / 2 + 0.1) == []
    assert at(-holder / 2 + 0.1) == at(400) == [stop]


# without control of the tip: from the crossing of the rotary axes to the tip of tool 12
SWINGS = Convention(pivot=200.0)
ARM = 200.0 + 155.0


def turning(height, start, end, rise=0.0):
    """Return a program whose head only turns, of the positions of its axes."""
    lines = [
        "G21 G90 G94", "T12 M6", "S18000 M3", "G43 H12", "G0 Z300", f"G0 X100 Y100 B{start} C0",
        f"G0 Z{height}", f"G0 B{end}" + (f" Z{height + rise}" if rise else ""), "G0 Z300", "G0 B0",
        "M30",
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    ("height", "tilt", "lowest"),
    [
        (5.0, 30.0, "5.000"),  # into the sheet of 10 mm, from 52.56 to 52.56
        (-20.0, 45.0, "-20.000"),  # into the table
        (49.99, 30.0, "49.990"),  # below the safe height by a hair
    ],
)
def test_tip_that_dips_while_the_head_turns_is_caught(height, tilt, lowest):
    ends = height + ARM * (1.0 - math.cos(math.radians(tilt)))
    assert ends > THICKNESS + machine().safe_height
    text = turning(height, -tilt, tilt)
    faults = verified(text, convention=SWINGS, simulate=False).faults
    about = [fault for fault in faults if "swings down" in fault.message]
    assert [fault.line for fault in about] == [8]
    assert f"swings down to {lowest} mm while the head turns" in about[0].message


@pytest.mark.parametrize(
    "text",
    [
        turning(50.0, -30, 30),  # dips to the safe height, and no further
        turning(5.0, 30, 45),  # never upright on the way
        turning(5.0, -30, -40, rise=20.0),
    ],
)
def test_tip_that_does_not_dip_is_not(text):
    faults = verified(text, convention=SWINGS, simulate=False).faults
    assert not [fault for fault in faults if "turns" in fault.message], faults


def test_control_that_keeps_the_tip_in_place_lets_the_head_turn_at_the_safe_height():
    def of_turns(height):
        faults = verified(turning(height, -30, 30), simulate=False).faults
        return [fault.line for fault in faults if "turns at" in fault.message]

    assert (of_turns(50.0), of_turns(49.0)) == ([], [8])


@given(st.integers(0, 2**32 - 1), st.sampled_from(["BC", "AC"]))
@settings(max_examples=60, deadline=None)
def test_lowest_tip_is_that_of_the_way_point_by_point(seed, axes):
    random = np.random.default_rng(seed)
    convention = Convention(axes, pivot=float(random.uniform(0.0, 300.0)))
    length = random.uniform(50.0, 200.0)
    heights = random.uniform(-200.0, 300.0, 2)
    if seed % 3 == 0:
        heights[1] = heights[0]
    angles = random.uniform(-200.0, 200.0, (2, 3)) * (seed % 5 > 0)  # none for some
    shares = np.linspace(0.0, 1.0, 20001)
    along = angles[0] + shares[:, None] * (angles[1] - angles[0])
    positions = np.zeros((len(shares), 3))
    positions[:, 2] = heights[0] + shares * (heights[1] - heights[0])
    tips = convention.tips(positions, convention.axis(along), np.full(len(shares), length))
    found_ = convention.lowest(heights[None], angles[None], np.array([length]))
    assert found_[0] <= tips[:, 2].min() + 1e-9
    assert found_[0] == pytest.approx(tips[:, 2].min(), abs=2e-3)


def test_three_decimals_are_as_true_as_they_can_be_and_two_are_not():
    def rounded(decimals):
        return re.sub(
            r"([XYZIJ])(-?\d+\.\d+)", lambda m: f"{m[1]}{float(m[2]):.{decimals}f}", program()
        )

    assert verified(rounded(3), simulate=False).ok
    assert not verified(rounded(2), simulate=False).ok


def test_missing_workpiece_and_wrong_convention_are_errors():
    with pytest.raises(AddressError, match="0212"):
        verify(program(), sheet(), pieces()[:1], tools(), machine())
    with pytest.raises(InputError, match="rotary axes AC"):
        verified(program(), convention=RIGHT_HANDED_AC)


def test_cylinder_beside_a_box_enters_by_what_its_radius_exceeds():
    box = Solids.boxes(np.zeros((1, 3)), np.full((1, 3), 10.0))

    def deep(start, end, axis, radius):
        one = Sweeps(
            np.array([start], dtype=float), np.array([end], dtype=float),
            np.array([axis], dtype=float), np.zeros(1), np.full(1, 50.0), np.array([radius]),
        )  # fmt: skip
        _, _, found_ = depths(one, box, 1e-3)
        return found_.tolist()

    up = (0, 0, 1)
    assert deep((-5, -20, 0), (-5, 30, 0), up, 5.0) == []
    assert deep((-5, -20, 0), (-5, 30, 0), up, 5.5) == pytest.approx([0.5])
    # past a corner, where no face parts them: the corner is 5 sqrt 2 away
    assert deep((-5, -5, 0), (-5, -5, 5), up, 7.05) == []
    assert len(deep((-5, -5, 0), (-5, -5, 5), up, 7.1)) == 1
    # a flat end above the box, wide as it is
    assert deep((5, -20, 10), (5, 30, 10), up, 40.0) == []
    lean = (math.sin(0.3), 0.0, math.cos(0.3))
    assert len(deep((5, -20, 10), (5, 30, 10), lean, 10.0)) == 1


@given(st.integers(0, 2**32 - 1), st.sampled_from([2e-3, 0.01, 0.5]))
@settings(max_examples=60, deadline=None)
def test_cylinder_that_almost_touches_a_long_solid_does_not_enter_it(seed, gap):
    random = np.random.default_rng(seed)
    corners = random.normal(size=(7, 3)) * [600.0, 40.0, 6.0]
    axis, towards = random.normal(size=(2, 3)) * [0.4, 0.4, 1.0]
    axis /= np.linalg.norm(axis)
    towards /= np.linalg.norm(towards)
    start, end = random.normal(size=(2, 3)) * 200.0
    sweep = Sweeps(
        start[None], end[None], axis[None], np.zeros(1), np.full(1, 42.0), np.full(1, 3.0)
    )
    # moved until its lowest point along one direction lies a gap above the solid's highest
    move = (corners @ towards).max() + gap - sweep.reach(towards[None])[0]
    apart = replace(sweep, starts=sweep.starts + move * towards, ends=sweep.ends + move * towards)
    solid = Solids(corners[None], ConvexHull(corners).equations[None, :, :3])
    assert len(depths(apart, solid, 1e-3)[0]) == 0
    # its end in the middle of the solid it does enter
    there = corners.mean(axis=0) - start
    within = replace(sweep, starts=sweep.starts + there, ends=sweep.ends + there)
    assert len(depths(within, solid, 1e-3)[0]) == 1


@pytest.fixture
def job(tmp_path):
    layout = Layout((sheet(),), 20.0, 15.0)
    write_job(tmp_path / "job.json", Job(layout, pieces(), tools(), machine(), SETTINGS))
    return tmp_path


def test_job_is_read_back_with_all_digits(job):
    read = read_job(job / "job.json")
    assert (read.tools, read.machine, read.settings) == (tools(), machine(), SETTINGS)
    assert read.layout.sheets[0].placements == sheet().placements
    assert read.layout.sheets[0].offcuts.shape == (0, 4)
    for one, other in zip(read.workpieces, pieces(), strict=True):
        assert one.material == other.material
        for a, b in zip(one.sides, other.sides, strict=True):
            np.testing.assert_array_equal(a.corners, b.corners)
            np.testing.assert_array_equal(a.normal, b.normal)
        for a, b in zip(one.engraving.strokes, other.engraving.strokes, strict=True):
            np.testing.assert_array_equal(a.bulges, b.bulges)


@pytest.mark.parametrize("folder", [".", "programs"])
def test_file_is_verified_against_the_job_beside_or_above_it(job, folder):
    path = job / folder / "sheet-01.ngc"
    path.parent.mkdir(exist_ok=True)
    path.write_text(program())
    assert verify_file(path, linuxcnc=False).ok
    path.write_text(changed(found("G21"), "G21", "G20"))
    assert verify_file(path, linuxcnc=False).faults[0].line == found("G21")


def test_file_without_job_or_sheet_is_an_error(job, tmp_path_factory):
    lonely = tmp_path_factory.mktemp("lonely") / "sheet-01.ngc"
    lonely.write_text(program())
    with pytest.raises(InputError, match=r"no job\.json"):
        verify_file(lonely)
    with pytest.raises(InputError, match="cannot be read"):
        verify_file(job / "sheet-09.ngc")
    lonely.write_text(changed(2, "sheet-01", "sheet-07"))
    with pytest.raises(InputError, match=r"no sheet 'sheet-07'\. It has sheet-01"):
        verify_file(lonely, job / "job.json")


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (lambda d: d.update(format="x"), "no job"),
        (lambda d: d.update(version=9), "version 9"),
        (lambda d: d.pop("machine"), "machine missing"),
        (lambda d: d["machine"].update(wings=2), "unknown key 'wings'"),
        (lambda d: d["tools"][0].update(diameter="wide"), r"tools\[0\]\.diameter must be a number"),
        (lambda d: d["tools"][0].update(diameter=-1.0), r"tools\[0\]: .*diameter must be positive"),
        (lambda d: d["workpieces"][0].update(origin=[1, [2]]), r"workpieces\[0\]\.origin"),
        (lambda d: d["settings"].update(hold="glue"), r"settings\.hold must be"),
    ],
)
def test_job_that_cannot_be_meant_is_an_error(job, edit, message):
    path = job / "job.json"
    content = json.loads(path.read_text())
    edit(content)
    path.write_text(json.dumps(content))
    with pytest.raises(InputError, match=message):
        read_job(path)


def test_job_of_another_machine_is_seen_in_the_ranges():
    short = replace(machine(), y=(0.0, 300.0))
    assert any("Y goes to" in fault.message for fault in verified(program(), machine=short).faults)
