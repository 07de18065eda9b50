"""Raw sheets and boards: what can be meant, the library, and files that add to it."""

import math
import re
from dataclasses import FrozenInstanceError

import pytest

from ifs_cad.elements.material import SPRUCE, SPRUCE_PLYWOOD
from ifs_cad.errors import InputError
from ifs_cad.fabrication.stock import Board, Sheet, Stock
from ifs_cad.fabrication.stock_file import read_stock

LARCH = """
[materials.larch]
density = 590
colour = [0.8, 0.6, 0.4]
"""
SHEET = """
[[sheets]]
name = "larch 12"
length = 2500
width = 1250
thickness = 12
material = "larch"
"""
BOARD = """
[[boards]]
name = "yard"
length = 4200
width = 150
thickness = 27
material = "spruce"
"""


@pytest.fixture
def file(tmp_path):
    def written(text):
        path = tmp_path / "own.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return written


def sheet(**values):
    sizes = {"length": 2500.0, "width": 1250.0, "thickness": 10.0, "material": SPRUCE_PLYWOOD}
    return Sheet(**{"name": "s", **sizes, **values})


def board(**values):
    sizes = {"length": 4000.0, "width": 150.0, "thickness": 27.0, "material": SPRUCE}
    return Board(**{"name": "b", **sizes, **values})


@pytest.mark.parametrize("make", [sheet, board])
@pytest.mark.parametrize("key", ["length", "width", "thickness"])
@pytest.mark.parametrize("size", [0, -1.0, math.nan, math.inf, "12", None, True])
def test_size_that_is_no_positive_number_is_an_error(make, key, size):
    with pytest.raises(InputError, match=rf"{key} must be a positive number of mm, got "):
        make(**{key: size})


@pytest.mark.parametrize("make", [sheet, board])
@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("price", -0.01),
        ("price", math.nan),
        ("price", "2"),
        ("count", 0),
        ("count", 1.0),
        ("count", True),
        ("material", "spruce"),
        ("name", " "),
        ("name", 3),
    ],
)
def test_value_that_cannot_be_meant_is_an_error(make, key, value):
    with pytest.raises(InputError, match=f"{key} must be"):
        make(**{key: value})


@pytest.mark.parametrize("fibre", ["across", "", 0, False])
def test_unknown_fibre_is_an_error(fibre):
    with pytest.raises(InputError, match="fibre must be 'length', 'width' or None"):
        sheet(fibre=fibre)


@pytest.mark.parametrize("faces", [0, 3, "2", True])
def test_sheet_with_other_than_one_or_two_good_faces_is_an_error(faces):
    with pytest.raises(InputError, match="good_faces must be 1 or 2"):
        sheet(good_faces=faces)


def test_free_stock_and_single_pieces_can_be_meant():
    assert board(price=0, count=1).price == 0
    assert sheet(price=0.0, count=1, fibre=None, good_faces=1).fibre is None


def test_stock_finds_by_name_size_and_material():
    thin, thick = sheet(name="thin"), sheet(name="thick", thickness=18)
    plank, turned = board(name="plank"), board(name="turned", width=27.0, thickness=150.0)
    stock = Stock((thin, thick), [plank, turned])
    assert stock["thick"] is thick
    assert stock["plank"] is plank
    assert stock.sheets_of(10) == (thin,)
    assert stock.sheets_of(10, "spruce plywood") == (thin,)
    assert stock.sheets_of(10, SPRUCE) == stock.sheets_of(11) == ()
    assert stock.boards_of(150, 27) == stock.boards_of(150, 27, SPRUCE) == (plank,)
    assert stock.boards_of(27, 150) == (turned,)
    with pytest.raises(FrozenInstanceError):
        stock.sheets = ()


def test_unknown_name_lists_what_there_is():
    with pytest.raises(InputError, match=r"is called 'x'\. There are: 's', 'b'\."):
        _ = Stock((sheet(),), (board(),))["x"]


def test_two_of_one_name_are_an_error_across_sheets_and_boards():
    with pytest.raises(InputError, match="more than one 'b'"):
        Stock((sheet(name="b"),), (board(),))


def test_library_has_the_common_sizes():
    stock = read_stock()
    assert [s.thickness for s in stock.sheets if s.material.name == "spruce plywood"] == [
        *(9, 10, 12, 15, 18, 21)
    ]
    assert {(s.length, s.width) for s in stock.sheets_of(10)} == {(2500, 1250)}
    assert {(s.length, s.width) for s in stock.sheets_of(21, "birch plywood")} == {(3000, 1500)}
    for width, thickness in [(150, 27), (100, 24), (120, 40)]:
        assert [b.length for b in stock.boards_of(width, thickness)] == [3000, 4000, 5000]
    for item in (*stock.sheets, *stock.boards):
        assert item.price is None
        assert item.count is None
        sizes = [float(size) for size in re.findall(r"[\d.]+", item.name)]
        wanted = (item.thickness, item.length, item.width)
        assert sizes == [*(wanted if item in stock.sheets else (*wanted[::2], wanted[1]))]


def test_materials_of_the_library_are_those_of_the_package():
    materials = {item.material for item in (*read_stock().sheets, *read_stock().boards)}
    assert {SPRUCE, SPRUCE_PLYWOOD} <= materials


def test_own_file_adds_to_the_library(file):
    more = 'fibre = "none"\nprice = 62.5\ncount = 40\ngood_faces = 1\n'
    stock, library = read_stock(str(file(LARCH + SHEET + more + BOARD))), read_stock()
    assert stock.sheets[:-1] == library.sheets
    assert stock.boards[:-1] == library.boards
    own = stock["larch 12"]
    assert own == stock.sheets[-1]
    assert (own.fibre, own.price, own.count, own.good_faces) == (None, 62.5, 40, 1)
    assert own.material.density == 590
    assert stock["yard"].length == 4200
    assert stock["yard"].material == SPRUCE


def test_own_file_may_leave_the_library_out(file):
    stock = read_stock(file("extend = false\n" + BOARD))
    assert (len(stock.sheets), len(stock.boards)) == (0, 1)


def test_own_entry_takes_the_place_of_one_of_the_library(file):
    name = "spruce 27x150x4000"
    stock = read_stock(file(BOARD.replace("yard", name) + "price = 9.5"))
    assert stock[name].price == 9.5
    assert stock[name].length == 4200
    assert [b.name for b in stock.boards] == [b.name for b in read_stock().boards]


def test_own_material_takes_the_place_of_one_of_the_library(file):
    stock = read_stock(file(LARCH.replace("larch", "spruce")))
    assert {board.material.density for board in stock.boards} == {590}
    assert {sheet.material.density for sheet in stock.sheets} == {450, 680}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "x = 1",
            "own.toml, line 1: unknown key 'x'. Known are extend, materials, sheets, boards.",
        ),
        ("extend = 1", "own.toml, line 1: extend must be true or false, got 1."),
        ("a = ", "own.toml is not TOML: "),
        (
            "sheets = 3",
            "own.toml, line 1: sheets must be a list of tables: write [[sheets]] before",
        ),
        (
            "boards = [3]",
            "own.toml, line 1: [[boards]] entry 1: must be a table of keys and values, got 3.",
        ),
        (
            "materials = 3",
            "own.toml, line 1: [materials]: must be a table of keys and values, got 3.",
        ),
        (
            LARCH.replace("density", "weight"),
            "own.toml, line 3: [materials.larch]: unknown key 'weight'. Known are density, colour.",
        ),
        (
            "[materials.larch]\ncolour = [0, 0, 1]",
            "own.toml, line 1: [materials.larch]: density missing. Add density = ...",
        ),
        (
            LARCH.replace("590", '"590"'),
            "own.toml, line 3: [materials.larch]: density must be a number, got '590'.",
        ),
        (
            LARCH.replace("590", "-1"),
            "own.toml, line 3: [materials.larch]: Density of larch must be positive, got -1.0.",
        ),
        (
            LARCH.replace("0.4]", "1.4]"),
            "own.toml, line 4: [materials.larch]: Colour of larch must be three numbers from 0 ",
        ),
        (
            LARCH.replace("0.4]", '"x"]'),
            "own.toml, line 4: [materials.larch]: colour entry 3 must be a number, got 'x'.",
        ),
        (
            SHEET,
            "own.toml, line 7: [[sheets]] entry 1 (larch 12): unknown material 'larch'. Known are "
            "'spruce plywood', 'spruce', 'birch plywood'; or add a table [materials.\"larch\"].",
        ),
        (
            LARCH + SHEET + SHEET.replace("larch 12", "other") + "fiber = 1",
            "own.toml, line 19: [[sheets]] entry 2 (other): unknown key 'fiber'. Known are name, "
            "length, width, thickness, material, price, count, fibre, good_faces.",
        ),
        (
            BOARD + "fibre = 'length'",
            "own.toml, line 8: [[boards]] entry 1 (yard): unknown key 'fibre'.",
        ),
        (
            BOARD.replace("width = 150\n", "").replace("length = 4200\n", ""),
            "own.toml, line 2: [[boards]] entry 1 (yard): length, width missing. Add length = ...",
        ),
        (
            BOARD.replace('name = "yard"', ""),
            "own.toml, line 2: [[boards]] entry 1: name missing. Add name = ...",
        ),
        (
            BOARD.replace('"yard"', "7"),
            "own.toml, line 3: [[boards]] entry 1: name must be a text in quotes, got 7.",
        ),
        (
            BOARD.replace("4200", "nan"),
            "own.toml, line 4: [[boards]] entry 1 (yard): length must be a finite number, got nan.",
        ),
        (
            BOARD.replace("4200", "0"),
            "own.toml, line 4: [[boards]] entry 1 (yard): Board yard: length must be a positive",
        ),
        (
            LARCH.replace("[0.8, 0.6, 0.4]", "[0.8, 0.6]"),
            "own.toml, line 4: [materials.larch]: colour must be three numbers from 0 to 1, got "
            "[0.8, 0.6].",
        ),
        (
            BOARD + "count = 2.0",
            "own.toml, line 8: [[boards]] entry 1 (yard): count must be a whole number, got 2.0.",
        ),
        (
            LARCH + SHEET + "fibre = 'across'",
            'own.toml, line 12: [[sheets]] entry 1 (larch 12): fibre must be "length", '
            '"width" or "none", got \'across\'.',
        ),
        (
            LARCH + SHEET + BOARD.replace("yard", "larch 12"),
            "own.toml, line 14: [[boards]] entry 1 (larch 12): the name 'larch 12' is taken by "
            "[[sheets]] entry 1 (larch 12) on line 6. Give one of them another name.",
        ),
    ],
)
def test_file_with_a_mistake_says_where_and_what(file, text, message):
    path = file(text)
    with pytest.raises(InputError) as caught:
        read_stock(path)
    assert str(caught.value).startswith(message.replace("own.toml", str(path), 1))


def test_two_entries_of_one_name_name_both(file):
    with pytest.raises(
        InputError, match=r"\[\[boards\]\] entry 2 \(yard\).*\[\[boards\]\] entry 1"
    ):
        read_stock(file(BOARD + BOARD))


def test_file_that_is_not_there_or_no_text_is_an_error(tmp_path):
    with pytest.raises(InputError, match=r"none.toml cannot be read: No such file or directory"):
        read_stock(tmp_path / "none.toml")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match=r"bytes.toml is not UTF-8 text"):
        read_stock(tmp_path / "bytes.toml")
