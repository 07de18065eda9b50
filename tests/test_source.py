"""Part scripts and STEP files as the worker reads them."""

import sys

import cadquery as cq
import pytest

from ifs_cad.errors import InputError, ScriptError
from ifs_cad.kernel.source import read_step, run_script, together

PARAMETERS = """
import cadquery as cq
size = 10.0
count = 4
lift = -2.5
name = "box"
hollow = False
spread = (1, -2)
values = dict(size=size, count=count, lift=lift, name=name, hollow=hollow, spread=spread)
show_object(cq.Assembly(cq.Workplane().box(1, 1, 1), metadata=values))
"""
DEFAULTS = {
    "size": 10.0,
    "count": 4,
    "lift": -2.5,
    "name": "box",
    "hollow": False,
    "spread": (1, -2),
}


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Run a script given as text; what it does to the interpreter is undone."""
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setattr(sys, "argv", [*sys.argv])
    path = tmp_path / "part.py"

    def run(text, **settings):
        path.write_text(text, encoding="utf-8")
        return run_script(path, settings)

    run.path = path
    return run


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("size", "12", 12.0),
        ("size", "-1e-3", -0.001),
        ("count", "6", 6),
        ("count", "6.5", 6.5),
        ("lift", "3", 3.0),
        ("lift", "-4", -4.0),
        ("name", "a=b c", "a=b c"),
        ("name", "12", "12"),
        ("hollow", "true", True),
        ("hollow", "No", False),
        ("spread", "-3, 4, 5", (-3, 4, 5)),
    ],
)
def test_setting_replaces_the_parameter_and_keeps_its_type(run, name, text, value):
    [shown] = run(PARAMETERS, **{name: text})
    assert shown.assembly.metadata == DEFAULTS | {name: value}
    assert type(shown.assembly.metadata[name]) is type(value)


@pytest.mark.parametrize(
    ("name", "text", "problem"),
    [
        ("sice", "12", "part.py has no parameter 'sice'."),
        ("size", "wide", "size must be a number, got 'wide'."),
        ("hollow", "2", "hollow must be true or false, got '2'."),
        ("spread", "3", "spread must be values separated by commas, such as 1, -2, got '3'."),
    ],
)
def test_setting_that_cannot_be_meant_lists_the_parameters(run, name, text, problem):
    with pytest.raises(InputError) as caught:
        run(PARAMETERS, **{name: text})
    first, *listing = str(caught.value).removeprefix(f"{run.path.parent}/").splitlines()
    assert first == f"{problem} Its parameters are:"
    assert listing == [f"  {key} = {value!r}" for key, value in DEFAULTS.items()]


def test_setting_of_a_script_without_parameters_says_so(run):
    with pytest.raises(InputError, match=r"no parameter 'x'\. Its parameters are: none\.$"):
        run("sizes = [1, 2]", x="1")


def test_each_shown_object_keeps_its_own_name(run):
    shown = run("""
import cadquery as cq
box = cq.Workplane().box(1, 2, 3)
show_object(box, name="plane")
show_object(box.val(), options={"name": "shape"})
show_object(cq.Assembly(box, name="inside"))
""")
    assert [thing.name for thing in shown] == ["plane", "shape", ""]
    assert [thing.assembly.name for thing in shown] == ["plane", "shape", "inside"]
    assert [thing.assembly.toCompound().Volume() for thing in shown] == pytest.approx([6] * 3)
    assert together(shown).toCompound().Volume() == pytest.approx(18)


def test_shown_wire_has_no_solids(run):
    [line, box] = run("""
import cadquery as cq
show_object(cq.Workplane().lineTo(1, 1))
show_object(cq.Workplane().box(1, 1, 1))
""")
    assert not line.has_solids
    assert box.has_solids


def test_script_sees_its_own_file_and_the_modules_beside_it(run):
    (run.path.parent / "its_neighbour.py").write_text("import cadquery as cq\nside = 2\n")
    [shown] = run("""
from its_neighbour import cq, side
show_object(cq.Workplane().box(side, side, side), name=__file__)
""")
    assert shown.assembly.toCompound().Volume() == pytest.approx(8)
    assert shown.name == str(run.path)


def test_future_imports_of_the_package_do_not_reach_the_script(run):
    with pytest.raises(ScriptError, match="line 1: NameError: name 'Nowhere' is not defined"):
        run("def f(x: Nowhere): pass")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        # through the library and back: the script's own line, not the library's
        (
            "import cadquery as cq\n\ncq.Workplane().box(1, 1, 1).edges('?')\n",
            "line 3: ParseException: ",
        ),
        (
            "def f():\n    raise ValueError('thin')\nf()\n",
            "line 2: ValueError: thin\n    raise Val",
        ),
        ("raise SystemExit(3)\n", "line 1: SystemExit: 3\n    raise SystemExit(3)"),
        ("assert 1 == 2\n", "line 1: AssertionError\n    assert 1 == 2"),
        ("x = 1\ny = (\n", "line 2: SyntaxError: '(' was never closed\n    y = ("),
        ("x = 1\nreturn x\n", "line 2: SyntaxError: 'return' outside function"),
    ],
)
def test_failing_script_is_reported_by_its_own_line(run, text, said):
    with pytest.raises(ScriptError) as caught:
        run(text)
    assert str(caught.value).startswith(f"{run.path}, {said}")


def test_error_of_the_package_in_a_script_keeps_its_addresses(run):
    with pytest.raises(ScriptError, match="line 2: ThicknessError: too thick") as caught:
        run("""from ifs_cad.errors import ThicknessError
raise ThicknessError("too thick", addresses=["03", "12"])
""")
    assert caught.value.addresses == ("03", "12")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x = 1\n", r"showed nothing to make\. Call show_object"),
        ("show_object(3)\n", "something of type int"),
    ],
)
def test_script_that_shows_nothing_to_make_is_an_error(run, text, said):
    with pytest.raises(ScriptError, match=said):
        run(text)


def test_script_that_is_not_text_is_an_error(run):
    run.path.write_bytes(b"\x00\xff\xfe")
    with pytest.raises(ScriptError, match=r"part\.py: SyntaxError: invalid or missing encoding"):
        run_script(run.path, {})
    run.path.write_bytes(b"x = 1\0")
    with pytest.raises(ScriptError, match=r"part\.py.*null bytes"):
        run_script(run.path, {})


def test_read_step_keeps_names_and_colours(tmp_path):
    whole = cq.Assembly(name="whole")
    whole.add(cq.Workplane().box(1, 1, 1), name="left", color=cq.Color(1, 0, 0))
    whole.add(cq.Workplane().box(1, 1, 2), name="right", loc=cq.Location((3, 0, 0)))
    whole.export(str(tmp_path / "whole.step"))
    read = read_step(tmp_path / "whole.step")
    assert {"left", "right"} <= read.objects.keys()
    [red] = [color for _, name, _, color in read if name.endswith("left")]
    assert red.toTuple() == pytest.approx((1, 0, 0, 1))


def test_read_step_takes_a_single_part(tmp_path):
    cq.exporters.export(cq.Workplane().box(1, 2, 3), str(tmp_path / "one.step"))
    assert read_step(tmp_path / "one.step").toCompound().Volume() == pytest.approx(6)


def test_read_step_of_another_file_is_an_error(tmp_path):
    (tmp_path / "other.step").write_text("solid\n")
    with pytest.raises(InputError, match=r"other\.step cannot be read as STEP"):
        read_step(tmp_path / "other.step")
    with pytest.raises(InputError, match=r"There is no file .*none\.step"):
        read_step(tmp_path / "none.step")
