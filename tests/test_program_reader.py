"""Programs read by our own reader, by hand and against LinuxCNC's interpreter."""

import re

import numpy as np
import pytest
from broken_programs import broken_programs, program, tools

from ifs_cad.errors import InputError
from ifs_cad.fabrication.machining.convention import LINUXCNC, RIGHT_HANDED_AC, Convention
from ifs_cad.fabrication.machining.linuxcnc import differences, interpreter, replayed
from ifs_cad.fabrication.machining.motions import Kind
from ifs_cad.fabrication.machining.program_reader import read_program

HEAD = "G21 G17 G90 G94\nT3 M6\nS9000 M3\nG43 H3\nG0 Z50\nG0 X10 Y20 B0 C0\n"
END = "\nM30\n"
SIZES = {tool.number: tool.diameter for tool in tools()}
needs_linuxcnc = pytest.mark.skipif(interpreter() is None, reason="rs274 is not installed")


def motions(body: str):
    read = read_program(HEAD + body + END)
    assert read.faults == ()
    return read.motions


def refusal(body: str) -> str:
    (fault,) = read_program(HEAD + body + END).faults
    assert fault.line == 7
    return fault.message


def test_line_is_read_with_all_that_is_in_force():
    last = motions("G1 X30.5 Y-.25 Z5 B10 C-20 F600")
    assert last.lines[-1] == 7
    assert last.kinds[-1] == Kind.FEED
    np.testing.assert_array_equal(last.starts[-1], [10.0, 20.0, 50.0])
    np.testing.assert_array_equal(last.ends[-1], [30.5, -0.25, 5.0])
    np.testing.assert_array_equal(last.end_angles[-1, 1:], [10.0, -20.0])
    assert (last.feeds[-1], last.speeds[-1], last.tools[-1], last.offsets[-1]) == (600, 9000, 3, 3)
    assert last.rotates[-1]


def test_words_stay_in_force_until_they_are_changed():
    read = motions("G1 X30 F600\nY40\nG0 Z60")
    assert read.lines[-3:].tolist() == [7, 8, 9]
    np.testing.assert_array_equal(read.ends[-1], [30.0, 40.0, 60.0])
    np.testing.assert_array_equal(read.feeds[-3:], [600.0, 600.0, np.nan])


@pytest.mark.parametrize(
    ("line", "sweep"),
    [
        ("G3 X20 Y30 I0 J10 F500", np.pi / 2),
        ("G2 X20 Y30 I0 J10 F500", -3 * np.pi / 2),
        ("G3 X20 Y30 R10 F500", np.pi / 2),
        ("G3 X20 Y30 R-10 F500", 3 * np.pi / 2),
        ("G2 X20 Y30 R10 F500", -np.pi / 2),
        ("G3 X10 Y20 I0 J10 F500", 2 * np.pi),
    ],
)
def test_arc_has_its_sweep_and_length(line, sweep):
    read = motions(line)
    assert read.sweeps[-1] == pytest.approx(sweep, abs=1e-12)
    assert read.lengths[-1] == pytest.approx(10 * abs(sweep), abs=1e-9)


def test_drilling_cycle_goes_over_down_and_up():
    read = motions("G99 G81 X1 Y2 Z-3 R15 F400\nX5\nG80")
    np.testing.assert_array_equal(read.ends[-7:, 2], [50, 15, -3, 15, 15, -3, 15])
    np.testing.assert_array_equal(read.ends[-7:, 0], [1, 1, 1, 1, 5, 5, 5])
    np.testing.assert_array_equal(read.kinds[-3:], [Kind.RAPID, Kind.FEED, Kind.RAPID])


def test_peck_cycle_clears_chips():
    read = motions("G98 G83 X1 Y2 Z-3 R15 Q8 F400")
    heights = read.ends[-10:, 2]
    np.testing.assert_allclose(heights, [50, 15, 7, 15, 7.254, -1, 15, -0.746, -3, 50], atol=1e-9)


def test_inverse_time_gives_the_feed_along_the_path():
    read = motions("G93 G1 X13 Y24 F50")
    assert read.feeds[-1] == pytest.approx(250.0)


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("G1 X30", "F is missing"),
        ("G1 X1e-05 F100", "exponents"),
        ("G1 Xnan F100", "not a word"),
        ("G1 X1 X2 F100", "X stands twice"),
        ("G0 G1 X1 F100", "Two codes for motion"),
        ("G91 G1 X1 F100", "G91 is not known"),
        ("G20", "G20 sets inches"),
        ("#1=5", "not a word"),
        ("G3 X20 Y30 F500", "without I, J or R"),
        ("G3 X20 Y31 I0 J10 F500", "has a radius of"),
        ("G2 X60 Y20 R10 F500", "cannot span 50 mm"),
        ("G81 X1 Y2 R15 F500", "G81 without Z"),
        ("G81 X1 Y2 Z20 R15 F500", "above|begins"),
        ("G93 G81 X1 Y2 Z2 R15 F500", "inverse time"),
        ("M6 T0", "T is missing"),
        ("S0 M3", "S is missing"),
        ("G80 X5", "without a motion"),
        ("T1.5", "whole number"),
        ("G4", "P is missing"),
        ("G4 P-1", "cannot wait for -1 seconds"),
        ("M98 P1", "M98 is not known"),
        ("I5", "no meaning"),
    ],
)
def test_line_that_cannot_be_followed_is_refused(line, reason):
    assert re.search(reason, refusal(line))


def test_words_after_the_end_and_a_missing_end_are_faults():
    (fault,) = read_program("G21 G90\nM30\nG0 X1\n").faults
    assert (fault.line, "after the end" in fault.message) == (3, True)
    (fault,) = read_program("G21 G90\nG0 Z5\n").faults
    assert (fault.line, "does not end" in fault.message) == (2, True)


def test_stops_know_how_the_machine_stands_when_they_take_effect():
    read = read_program(HEAD + "M5 G0 X30 Y40 M0\nM3 T4 M6 M1\nG4 P2.5\nG4 P0.5\n" + END)
    _, standing, stop, change, optional = read.stops
    # spindle and motion come before a stop in their line, a change of tool before both
    assert [one.code for one in (standing, stop, change, optional)] == ["M5", "M0", "M6", "M1"]
    assert (standing.position, standing.speed) == ((10.0, 20.0, 50.0), 9000.0)
    assert (stop.position, stop.angles[1:], stop.speed) == ((30.0, 40.0, 50.0), (0.0, 0.0), 0.0)
    assert (change.tool, change.speed, optional.tool, optional.speed) == (3, 0.0, 4, 9000.0)
    assert stop.before == standing.before + 1 == len(read.motions)
    assert [one.code for one in read.waits] == ["M0", "M1"]
    assert [one.line for one in read.changes] == [2, 8]
    assert read.dwell == 3.0


def test_comments_name_workpieces():
    read = read_program("(STEP pierce TOOL 1 D8)\n(ADDRESS 0211)\nG0 Z5\n(ADDRESS 0212)\nM30\n")
    addresses = [read.address_at(line) for line in (1, 2, 3, 4, 5)]
    assert addresses == ["", "0211", "0211", "0212", "0212"]
    assert read.line_of("pierce", "0212") == 4
    assert read.line_of("contour", "0212") == 5


def test_conventions_point_the_tool():
    tilt, turn = np.radians(20), np.radians(35)
    angles = np.array([20.0, 20.0, 35.0])
    s, c = np.sin(tilt), np.cos(tilt)
    np.testing.assert_allclose(
        LINUXCNC.axis(angles), [-s * np.cos(turn), -s * np.sin(turn), c], atol=1e-15
    )
    np.testing.assert_allclose(
        RIGHT_HANDED_AC.axis(angles), [s * np.sin(turn), -s * np.cos(turn), c], atol=1e-15
    )
    mirrored = Convention(turn_sign=-1).axis(angles)
    np.testing.assert_allclose(mirrored, [-s * np.cos(turn), s * np.sin(turn), c], atol=1e-15)


def test_positions_without_control_of_the_tip_turn_about_the_pivot():
    head = Convention(tilt_sign=1, pivot=200.0)
    axis = head.axis(np.array([[0.0, 90.0, 0.0]]))
    tips = head.tips(np.array([[0.0, 0.0, 0.0]]), axis, np.array([100.0]))
    np.testing.assert_allclose(tips, [[-300.0, 0.0, 300.0]], atol=1e-12)


@pytest.mark.parametrize(
    "wrong", [{"axes": "AB"}, {"tilt_sign": 0}, {"turn_sign": 2}, {"pivot": -1.0}]
)
def test_convention_that_cannot_be_meant_is_an_error(wrong):
    with pytest.raises(InputError, match="must be"):
        Convention(**wrong)


MANY = (
    HEAD
    + (
        "G1 X30 F600\nG3 X40 Y30 I0 J10\nG2 X60 Y30 R10\nG2 X60 Y30 I4 J3\nG3 X70 Y20 R-10\n"
        "G98 G81 X1 Y2 Z-3 R15\nX5 Y-7\nG99 X9\nG83 X12 Z-4 R14 Q5\nY3\nG80\nG0 B-10 C350\n"
        "G61 G1 Z2 F99.5\nG64 P0.001 X-3.12345 Y0.00004\nG93 X5 F3\nG94 G1 X6 F500"
    )
    + END
)


@needs_linuxcnc
@pytest.mark.parametrize("text", [program(), MANY])
def test_linuxcnc_moves_as_our_own_reader(text):
    read = read_program(text)
    lines, places, refused = replayed(text, SIZES)
    assert (refused, read.faults) == ((), ())
    assert differences(read.motions, lines, places) == ()
    assert len(lines) > 20
    places[-1, 0] += 0.001
    (fault,) = differences(read.motions, lines, places)
    assert fault.line == lines[-1]


@needs_linuxcnc
def test_linuxcnc_names_the_line_that_it_refuses():
    text = HEAD + "G1 X5 F100\nG1 X1e-05\n" + END
    _, _, (fault,) = replayed(text, SIZES)
    assert fault.line == 8
    assert "LinuxCNC refuses" in fault.message


@needs_linuxcnc
def test_what_linuxcnc_refuses_our_own_reader_refuses():
    for broken in broken_programs():
        _, _, refused = replayed(broken.text, SIZES)
        if refused:
            # LinuxCNC names the first line only, and knows relative positions
            lines = {fault.line for fault in read_program(broken.text).faults}
            assert refused[0].line in lines or broken.name in ("relative", "no such tool")
