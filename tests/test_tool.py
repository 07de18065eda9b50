"""Tools and the machine: what can be meant, the library, and files that add to it."""

import math
from dataclasses import replace

import pytest
from machining import prototype

from ifs_cad.errors import InputError
from ifs_cad.fabrication.machining.machine import Clamp, Machine
from ifs_cad.fabrication.machining.orientation import RotaryHead
from ifs_cad.fabrication.machining.post import FANUC, LINUXCNC, THREE_AXES
from ifs_cad.fabrication.machining.router import Router, read_router
from ifs_cad.fabrication.machining.setup import set_up
from ifs_cad.fabrication.machining.tool import Tool

MILL = Tool(1, "mill", "end mill", 8, 30, 50, 120, 32, 4000, 1200, 18000, 10)
LIBRARY = read_router()
OWN = """
[[tools]]
number = 21
name = "long mill"
kind = "end mill"
diameter = 10
flank = 90
reach = 110
length = 190
holder = 50
feed = 4000
plunge = 1200
speed = 18000
pass_depth = 12
materials = ["larch"]
"""


@pytest.fixture
def file(tmp_path):
    def written(text):
        path = tmp_path / "own.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return written


LENGTHS = ["diameter", "flank", "reach", "length", "holder", "pass_depth"]


@pytest.mark.parametrize("key", [*LENGTHS, "feed", "plunge", "speed"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_number_of_a_tool_that_is_not_positive_is_an_error(key, value):
    with pytest.raises(InputError, match=rf"Tool 1: {key} must be positive, got "):
        replace(MILL, **{key: value})


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"number": 0}, "number of a tool must be 1 or more"),
        ({"kind": "saw"}, "kind must be 'drill', 'engraver' or 'end mill', got 'saw'"),
        ({"flank": 60}, "flank, reach and length must not decrease, got 60, 50 and 120 mm"),
        ({"reach": 130}, "flank, reach and length must not decrease"),
        ({"point": 0.0}, "point must be above 0 and at most 180 degrees"),
        ({"point": 181.0}, "point must be above 0"),
    ],
)
def test_tool_that_cannot_be_meant_is_an_error(values, message):
    with pytest.raises(InputError, match=message):
        replace(MILL, **values)


def test_point_stands_out_by_its_cone():
    assert replace(MILL, point=90.0).point_height == pytest.approx(4.0)
    assert MILL.point_height == pytest.approx(0.0, abs=1e-12)


def test_tool_without_materials_cuts_all():
    assert MILL.cuts("larch")
    oak = replace(MILL, materials=("oak",))
    assert oak.cuts("oak")
    assert not oak.cuts("larch")


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"rotary": "AB"}, "rotary must be 'AC', 'BC' or 'none', got 'AB'"),
        ({"x": (10.0, 10.0)}, "x must rise from least to largest mm"),
        ({"turn": (-math.inf, 0.0)}, "turn must rise from least to largest degrees"),
        ({"spindle": (5.0, 1.0)}, "spindle must rise"),
        ({"safe_height": 0.0}, "safe_height must be positive"),
        ({"rapid": math.nan}, "rapid must be positive"),
        ({"pivot": -1.0}, "pivot must be 0 or more"),
        (
            {"park": (-800.0, 0.0)},
            r"park must be within the travel; its x is -800 mm, and x travels",
        ),
        ({"park": (0.0, 2401.0)}, r"its y is 2401 mm, and y travels from -700 to 2400 mm"),
        ({"park": (0.0, math.nan)}, "park must be within the travel; its y is nan mm"),
        ({"spoilboard_depth": 19.0}, "spoilboard_depth 19 mm exceeds the spoilboard of 18 mm"),
        ({"tilt": (10.0, 60.0)}, "tilt must have 0 in its range"),
        ({"turn": (0.0, 170.0)}, "turn must range over 180 degrees"),
        ({"tilt": (-10.0, 90.0), "turn": (0.0, 350.0)}, "turn must range over 360 degrees"),
    ],
)
def test_machine_that_cannot_be_meant_is_an_error(values, message):
    with pytest.raises(InputError, match=message):
        replace(LIBRARY.machine, **values)


def test_largest_tilt_is_that_of_the_wider_side():
    assert replace(LIBRARY.machine, tilt=(-10.0, 95.0)).largest_tilt == 95.0
    assert replace(LIBRARY.machine, tilt=(-110.0, 95.0)).largest_tilt == 110.0


@pytest.mark.parametrize(
    ("values", "place"),
    [
        ({}, (-300.0, -300.0)),
        ({"park": (12.0, 34.0)}, (12.0, 34.0)),
        ({"x": (-100.0, 4000.0)}, (2800.0, -300.0)),  # to the right there is more room
        ({"x": (0.0, 2500.0), "y": (0.0, 1450.0)}, (25.0, 1425.0)),
        ({"x": (0.0, 2500.0), "y": (0.0, 1250.0)}, (25.0, 25.0)),  # nowhere beside it
    ],
)
def test_head_is_parked_where_it_is_said_or_beside_the_sheet(values, place):
    machine = replace(LIBRARY.machine, **values)
    assert machine.parked(2500.0, 1250.0) == place
    (x_low, x_high), (y_low, y_high) = machine.x, machine.y
    assert x_low <= place[0] <= x_high
    assert y_low <= place[1] <= y_high


def test_clamp_without_extent_is_an_error():
    with pytest.raises(InputError, match="Clamp z must rise"):
        Clamp((0.0, 1.0), (0.0, 1.0), (5.0, 5.0))


def test_two_tools_of_one_number_are_an_error():
    with pytest.raises(InputError, match="Two tools have the number 1"):
        Router(LIBRARY.machine, (MILL, replace(MILL, name="other")))


def test_library_has_tools_of_every_kind_for_every_label_and_hole_by_default():
    by_kind = {kind: set() for kind in ("drill", "engraver", "end mill")}
    for tool in LIBRARY.tools:
        by_kind[tool.kind].add(tool.diameter)
    assert {3.0, 4.0, 5.0, 6.0, 4.2} <= by_kind["drill"]
    assert {1.0, 2.0, 3.0} <= by_kind["engraver"]
    assert {6.0, 8.0, 10.0} <= by_kind["end mill"]
    assert [tool.number for tool in LIBRARY.tools] == sorted(t.number for t in LIBRARY.tools)
    least, most = LIBRARY.machine.spindle
    assert all(least <= tool.speed <= most for tool in LIBRARY.tools)


def test_own_file_adds_and_replaces(file):
    own = read_router(file(OWN))
    added = next(tool for tool in own.tools if tool.number == 21)
    assert (added.flank, added.materials, added.point) == (90.0, ("larch",), 180.0)
    assert set(own.tools) - {added} == set(LIBRARY.tools)
    replaced = read_router(file(OWN.replace("21", "9")))
    assert len(replaced.tools) == len(LIBRARY.tools)
    assert next(tool.name for tool in replaced.tools if tool.number == 9) == "long mill"
    assert [tool.number for tool in read_router(file("extend = false\n" + OWN)).tools] == [21]


def test_own_machine_changes_only_what_it_gives(file):
    clamps = "[[machine.clamps]]\nx = [0, 60]\ny = [-40, 25]\nz = [0, 45]"
    text = "[machine]\nsafe_height = 60\n" + clamps
    machine = read_router(file(text)).machine
    clamp = Clamp((0.0, 60.0), (-40.0, 25.0), (0.0, 45.0))
    assert machine == replace(LIBRARY.machine, safe_height=60.0, clamps=(clamp,))
    assert isinstance(machine, Machine)
    assert (machine.park, machine.change_by_hand) == (None, False)
    text = "[machine]\npark = [-300, 1800]\ntool_change = 120\nchange_by_hand = true"
    machine = read_router(file(text)).machine
    assert (machine.park, machine.tool_change) == ((-300.0, 1800.0), 120.0)
    assert machine.change_by_hand


def test_control_is_the_usual_one_of_the_axes_unless_a_file_says_otherwise(file):
    assert LIBRARY.post == LINUXCNC
    assert read_router(file("[machine]\nrotary = 'AC'")).post == FANUC
    assert read_router(file("[machine]\nrotary = 'none'")).post == THREE_AXES
    post = read_router(
        file(
            "[machine]\nrotary = 'AC'\n[post]\nname = 'ours'\ntilt_sign = -1\ndecimals = 3\n"
            "tool_centre_point = false\nheader = ['%', 'O{number:04}', 'G17']\nline_numbers = 0"
        )
    ).post
    assert post.head == RotaryHead("AC", tilt_sign=-1)
    assert (post.name, post.decimals, post.line_numbers) == ("ours", 3, 0)
    assert post.header == ("%", "O{number:04}", "G17")
    assert post.tool_offset == FANUC.tool_offset
    convention = post.convention(replace(LIBRARY.machine, rotary="AC", pivot=150.0))
    assert (convention.axes, convention.tilt_sign, convention.pivot) == ("AC", -1, 150.0)


def test_file_says_how_sheets_are_cut_and_a_call_may_say_otherwise(file):
    router = read_router(file("[settings]\nhold = 'skin'\nskin = 0.6\ndirection = 'conventional'"))
    pieces, _ = prototype()
    settings = set_up(pieces[:3], router).settings
    assert (settings.hold, settings.skin, settings.direction) == ("skin", 0.6, "conventional")
    settings = set_up(pieces[:3], router, hold="tabs", breakthrough=0.8).settings
    assert (settings.hold, settings.skin, settings.breakthrough) == ("tabs", 0.6, 0.8)
    # pierced, and nothing said: screwed to the table
    assert set_up(pieces[:3], LIBRARY).settings.hold == "none"


def test_machine_of_three_axes_does_not_tilt():
    assert replace(LIBRARY.machine, rotary="none").largest_tilt == 0.0
    with pytest.raises(InputError, match="for rotary axes BC; five-axis router has none"):
        Router(replace(LIBRARY.machine, rotary="none"), LIBRARY.tools, LINUXCNC)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("tools = 3", r"own.toml, line 1: tools must be a list of tables"),
        ("x = [", "own.toml is not TOML"),
        ("speed = 3", "own.toml, line 1: unknown key 'speed'. Known are extend, tools, machine"),
        ("extend = 1", "own.toml, line 1: extend must be true or false, got 1"),
        (
            OWN.replace("flank = 90\n", ""),
            r"line 2: .*entry 1 \(long mill\): flank missing. Add flank = ",
        ),
        (
            OWN.replace("flank = 90", 'flank = "90"'),
            r"line 7: .*flank must be a number, got '90'",
        ),
        (OWN.replace("= 21", "= 2.5"), "line 3: .*number must be a whole number, got 2.5"),
        (
            OWN.replace("flank = 90", "flank = -90"),
            r"line 7: .*\): Tool 21: flank must be positive",
        ),
        (OWN.replace('["larch"]', '"larch"'), "materials must be a list of texts in quotes"),
        (OWN + "teeth = 2", "line 16: .*unknown key 'teeth'"),
        (
            OWN + OWN,
            r"line 18: .* 2 \(long mill\): the number 21 is taken by .* 1 .* on line 2\.",
        ),
        (
            "[machine]\nx = [0]",
            r"line 2: \[machine\]: x must be two numbers, the least and the largest",
        ),
        ("[machine]\nrotary = 'XY'", r"line 2: \[machine\]: rotary must be 'AC', 'BC' or 'none'"),
        ("[machine]\npark = 5", r"line 2: \[machine\]: park must be two numbers, x and y, got 5"),
        ("[machine]\npark = [9000, 0]", r"line 2: .*park must be within the travel; its x is"),
        ("[machine]\nchange_by_hand = 1", r"line 2: .*change_by_hand must be true or false, got 1"),
        ("[machine]\nlegs = 4", r"\[machine\]: unknown key 'legs'"),
        (
            "[post]\nlike = 'heidenhain'",
            r"line 2: \[post\]: like must be .linuxcnc., .fanuc. or .three axes., got 'heid",
        ),
        (
            "[post]\nlike = 'fanuc'",
            r"line 1: \[post\]: .*for rotary axes AC; five-axis router has BC",
        ),
        ("[post]\ntilt_sign = 2", r"line 2: \[post\]: tilt_sign must be 1 or -1, got 2"),
        ("[post]\ndecimals = 12", r"\[post\]: .*decimals must be 3 to 9"),
        ("[settings]\nhold = 'glue'", r"line 2: \[settings\]: Settings: hold must be one of tabs"),
        ("[settings]\nglue = 1", r"\[settings\]: unknown key 'glue'"),
        ("[post]\ndialect = 1", r"\[post\]: unknown key 'dialect'"),
        ("[[machine.clamps]]\nx = [0, 1]", r"line 1: \[\[machine.clamps\]\] entry 1: y, z missing"),
    ],
)
def test_mistake_in_a_file_names_file_line_table_and_key(file, text, message):
    with pytest.raises(InputError, match=message):
        read_router(file(text))


def test_file_that_is_not_there_is_an_error(tmp_path):
    with pytest.raises(InputError, match=r"none.toml cannot be read: No such file"):
        read_router(tmp_path / "none.toml")
