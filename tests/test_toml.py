"""TOML files: where each key stands, however it is written, and errors that tell it."""

import tomllib
from dataclasses import dataclass

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ifs_cad.errors import InputError, WeightError
from ifs_cad.toml import readers
from ifs_cad.toml.lines import line_of
from ifs_cad.toml.table import Table, parse_table, read_table

EVERY_FORM = '''\
# [fake]
title = "# not = a comment"          # 2
"quoted key" = 1                     # 3
'a.b' = 2
fruit.apple.colour = "red"           # 5
fruit . "pear" = { size = 3, kinds = ["x", "y"] }
text = """
fake = 1
[fake]
[[rows]]
"""
last = \'\'\'
"""
\'\'\'                               # 14

points = [
    [0, 1],                          # 17

    [2, 3], [4,                      # 19
        5],                          # ], \'\'\'
]
inline = [
    { name = "a", of = [             # 23
        1,
        2,
    ] },
    { name = """
b""", of = [3] },
]

[fruit.plum]                         # 31
size = 1
[ table . "with space" ]
key = 1

[[rows]]                             # 36
name = "first"
[rows.inner]
deep = 1                             # 39

[[rows]]
name = "second"                      # 42
[[rows.more]]
x = 1
[[rows.more]]                        # 45
x = 2
[table]
late = true                          # 48
'''


@pytest.mark.parametrize(
    ("place", "line"),
    [
        (("title",), 2),
        (("quoted key",), 3),
        (("a.b",), 4),
        (("fruit",), 5),
        (("fruit", "apple"), 5),
        (("fruit", "apple", "colour"), 5),
        (("fruit", "pear"), 6),
        (("fruit", "pear", "size"), 6),
        (("fruit", "pear", "kinds", 1), 6),
        (("text",), 7),
        (("last",), 12),
        (("points",), 16),
        (("points", 0), 17),
        (("points", 0, 1), 17),
        (("points", 1), 19),
        (("points", 2), 19),
        (("points", 2, 0), 19),
        (("points", 2, 1), 20),
        (("inline",), 22),
        (("inline", 0), 23),
        (("inline", 0, "of"), 23),
        (("inline", 0, "of", 1), 25),
        (("inline", 1), 27),
        (("inline", 1, "name"), 27),
        (("inline", 1, "of"), 28),
        (("fruit", "plum"), 31),
        (("fruit", "plum", "size"), 32),
        (("table",), 33),
        (("table", "with space"), 33),
        (("table", "with space", "key"), 34),
        (("rows",), 36),
        (("rows", 0), 36),
        (("rows", 0, "name"), 37),
        (("rows", 0, "inner"), 38),
        (("rows", 0, "inner", "deep"), 39),
        (("rows", 1), 41),
        (("rows", 1, "name"), 42),
        (("rows", 1, "more", 0, "x"), 44),
        (("rows", 1, "more", 1), 45),
        (("table", "late"), 48),
        ((), None),
        (("fake",), None),
        (("rows", 2), None),
        (("title", "x"), None),
        (("points", "x"), None),
    ],
)
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_line_is_that_on_which_a_place_begins(place, line, newline):
    assert line_of(EVERY_FORM.replace("\n", newline), place) == line


def test_line_is_not_misled_by_what_other_formats_take_for_its_end():
    assert line_of('a = "\u2028\u0085" # \u2029\nb = 1', ("b",)) == 2


def test_line_within_more_brackets_than_are_closed_is_that_of_the_outermost_ones():
    text = "a = [\n[\n[\n[\n[\n1,\n2\n]\n]\n]\n]\n]\nb = 1"
    assert line_of(text, ("a", 0, 0, 0)) == 4
    assert line_of(text, ("a", 0, 0, 0, 0, 1)) == 5
    assert line_of(text, ("b",)) == 13


NOISE = ["", "# x = [1", '# """', "  # [t]", "\t# \u2028 }]"]


@dataclass
class Written:
    """A file as it is written, and the line of each place in it."""

    text: str = ""

    def __post_init__(self):
        self.lines = {}

    def begins(self, *place):
        self.lines.setdefault(place, self.text.count("\n") + 1)


KEYS = st.sampled_from(["a", "b-2", '"q.u"', "'[x]'", '"#"'])
PLAIN = st.sampled_from(["1", "-0.5", "true", "1979-05-27", '"]"', '\'"""\'', '"\\""', "'#'"])
TEXTS = st.sampled_from(['"""', "'''"])


def bare(key):
    return key.strip("\"'")


@st.composite
def files(draw):
    """Draw a file with every form of value, table and key, and noise between its lines."""
    file = Written()

    def noise():
        for line in draw(st.lists(st.sampled_from(NOISE), max_size=2)):
            file.text += line + "\n"

    def broken():
        """Write the end of a line in a list, or none."""
        if draw(st.booleans()):
            file.text += draw(st.sampled_from(["\n", " # ]\n", "\n\n", "\n# '''\n  "]))

    def value(place, depth):
        kind = draw(st.sampled_from(["plain", "plain", "text", "list", "inline"]))
        if kind == "text":
            quotes = draw(TEXTS)
            body = "\n".join(draw(st.lists(st.sampled_from(["", "a = 1", "[t]", "]} #"]))))
            file.text += quotes + body + quotes
        elif kind == "list" and depth:
            file.text += "["
            broken()
            for index in range(draw(st.integers(0, 3))):
                file.begins(*place, index)
                value((*place, index), depth - 1)
                broken()
                file.text += ","
                broken()
            file.text += "]"
        elif kind == "inline" and depth:
            file.text += "{ "
            for index, key in enumerate(draw(st.lists(KEYS, max_size=3, unique=True))):
                file.text += ", " if index else ""
                file.begins(*place, bare(key))
                file.text += f"{key} = "
                value((*place, bare(key)), depth - 1)
            file.text += " }"
        else:
            file.text += draw(PLAIN)

    def pairs(place):
        for key in draw(st.lists(KEYS, max_size=3, unique=True)):
            noise()
            dotted = draw(st.lists(KEYS, max_size=2))
            for count in range(len(dotted) + 1):
                file.begins(*place, *map(bare, [key, *dotted][: count + 1]))
            file.text += draw(st.sampled_from(["", "  "])) + " . ".join([key, *dotted]) + " = "
            value((*place, *map(bare, [key, *dotted])), 3)
            file.text += draw(st.sampled_from(["\n", " # = 1\n"]))

    pairs(())
    rows = {}
    for number in range(draw(st.integers(0, 5))):
        noise()
        name = draw(st.sampled_from(["rows", "'more rows'", f"t{number}", f"new.t{number}"]))
        place = tuple(map(bare, name.split(".")))
        if "rows" in name:
            place = (*place, rows.setdefault(name, 0))
            rows[name] += 1
        for count in range(len(place)):
            file.begins(*place[: count + 1])
        file.text += (f"[[{name}]]" if "rows" in name else f"[ {name} ]") + "\n"
        pairs(place)
    return file


@given(files())
@settings(max_examples=40, deadline=None)
def test_line_of_every_place_is_that_where_it_was_written(file):
    tomllib.loads(file.text)  # or the test wrote nonsense
    assert {place: line_of(file.text, place) for place in file.lines} == file.lines


@dataclass(frozen=True)
class Peg:
    """A thing with a rule of its own."""

    name: str
    least_size: float
    size: float = 2.0

    def __post_init__(self):
        if self.size < self.least_size:
            raise WeightError(f"Peg {self.name}: the size is below the least size.")


PEG = {"name": readers.text, "least_size": readers.number, "size": readers.number}


def pegs(text):
    table = parse_table(text, "x.toml")
    table.values({}, ("box", "pegs"))
    return [row.made(Peg, row.values(PEG)) for row in table.table("box").rows("pegs")]


def test_rows_of_a_table_become_dataclasses():
    rows = "[[box.pegs]]\nname = 'p'\nleast_size = 1\n[[box.pegs]]\nname='q'\nleast_size=2\nsize=3"
    assert pegs(rows) == [Peg("p", 1.0), Peg("q", 2.0, 3.0)]
    inline = "{ name = 'p', least_size = 1 },\n{ name = 'q', least_size = 2, size = 3 },\n"
    assert pegs(f"box.pegs = [\n{inline}]") == pegs(rows)
    assert pegs("") == []


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("\nbags = 1", "x.toml, line 2: unknown key 'bags'. Known are box, pegs."),
        ("\nbox = 1", "x.toml, line 2: [box]: must be a table of keys and values, got 1."),
        (
            "box.pegs = 3",
            "x.toml, line 1: [box]: pegs must be a list of tables: write [[box.pegs]] before each.",
        ),
        (
            "[box]\npegs = [\n{ name = 'p', least_size = 1 },\n7,\n]",
            "x.toml, line 4: [[box.pegs]] entry 2: must be a table of keys and values, got 7.",
        ),
        (
            "\n[[box.pegs]]\n\nname = 'p'",
            "x.toml, line 2: [[box.pegs]] entry 1 (p): least_size missing. Add least_size = ...",
        ),
        (
            "[[box.pegs]]\nname = 'p'\nleast_size = 1\n[[box.pegs]]\nname = 'q'\nsize = true",
            "x.toml, line 6: [[box.pegs]] entry 2 (q): size must be a number, got True.",
        ),
        (
            "[[box.pegs]]\nname = 'p'\nleast_size = 3\nsize = 1",
            "x.toml, line 4: [[box.pegs]] entry 1 (p): Peg p: the size is below the least size.",
        ),
        (
            "[[box.pegs]]\nname = 'p'\nleast_size = 3",
            "x.toml, line 3: [[box.pegs]] entry 1 (p): Peg p: the size is below the least size.",
        ),
    ],
)
def test_mistake_names_file_line_table_and_key(text, message):
    with pytest.raises(InputError) as caught:
        pegs(text)
    assert str(caught.value) == message


def test_refusal_that_names_no_key_has_the_line_of_its_table():
    table = parse_table("\n['t.u'.v]\nlength = 1", "x.toml").table("t.u").table("v")
    with (
        pytest.raises(InputError, match=r'^x\.toml, line 2: \["t\.u"\.v\]: Too small\.$'),
        table.refusals(),
    ):
        raise WeightError("Too small.")


def test_table_without_a_text_names_no_line():
    with pytest.raises(InputError, match=r"^settings: \[a\]: size must be a number, got 'x'\.$"):
        Table("settings", {"a": {"size": "x"}}).table("a").values(PEG)


POINTS = readers.list_of(readers.list_of(readers.number, "two numbers", 2), "a list of points")


@pytest.mark.parametrize(
    ("reader", "text", "expected"),
    [
        (readers.text, "1", "must be a text in quotes, got 1"),
        (readers.number, "'1'", "must be a number, got '1'"),
        (readers.number, "true", "must be a number, got True"),
        (readers.number, "inf", "must be a finite number, got inf"),
        (readers.number, "nan", "must be a finite number, got nan"),
        (readers.number, "1" + "0" * 400, "must be a finite number, got 1000"),
        (readers.whole, "1.0", "must be a whole number, got 1.0"),
        (readers.whole, "true", "must be a whole number, got True"),
        (readers.flag, "1", "must be true or false, got 1"),
        (readers.one_of("a", "b", "c"), "'d'", 'must be "a", "b" or "c", got \'d\''),
        (readers.one_of("a"), "['a']", "must be \"a\", got ['a']"),
        (POINTS, "1", "must be a list of points, got 1"),
        (POINTS, "[1, 2]", "entry 1 must be two numbers, got 1"),
        (POINTS, "[\n[1, 2], [3]]", "entry 2 must be two numbers, got [3]"),
        (POINTS, "[\n[1, 2],\n[3,\n'4']\n]", "entry 2 entry 2 must be a number, got '4'"),
    ],
)
def test_value_of_another_kind_is_told_with_its_line(reader, text, expected):
    table = parse_table("\nkey = " + text, "x.toml")
    line = {"[\n[1, 2], [3]]": 3, "[\n[1, 2],\n[3,\n'4']\n]": 5}.get(text, 2)
    with pytest.raises(InputError) as caught:
        table.values({"key": reader})
    assert str(caught.value).startswith(f"x.toml, line {line}: key {expected}")


def test_values_are_read_as_what_they_are():
    kinds = {"n": readers.number, "w": readers.whole, "f": readers.flag, "p": POINTS}
    read = parse_table("n = 3\nw = 4\nf = false\np = [[1, 2]]", "x").values(kinds)
    assert read == {"n": 3.0, "w": 4, "f": False, "p": ((1.0, 2.0),)}
    assert isinstance(read["n"], float)
    assert isinstance(read["p"][0][0], float)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"\xff\xfe\x00", r"x\.toml is not UTF-8 text: .* Save it as UTF-8\."),
        (b"a = 1\nb = ", r"x\.toml is not TOML: .*line 2"),
        (b"a = 1\na = 2", r"x\.toml is not TOML: .*line 2"),
        (b"a = " + b"9" * 5000, r"x\.toml is not TOML: .*digits"),
        (b"a = " + b"[" * 50_000, r"x\.toml has too many brackets"),
    ],
)
def test_file_that_is_no_toml_is_an_error(tmp_path, content, message):
    (tmp_path / "x.toml").write_bytes(content)
    with pytest.raises(InputError, match=message):
        read_table(tmp_path / "x.toml", "x.toml")


def test_file_that_is_not_there_is_an_error(tmp_path):
    with pytest.raises(InputError, match=r"^x\.toml cannot be read: No such file"):
        read_table(tmp_path / "x.toml", "x.toml")
