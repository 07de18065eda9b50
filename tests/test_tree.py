"""The construction tree: words, branches, print and drawing."""

import numpy as np
import pytest

from ifs_cad.design.tree import ConstructionTree, read_word
from ifs_cad.errors import AddressError, InputError, SizeError

TWO_STEPS = """\
PK
├── 0  PT1K
│   ├── 00  PT1T1K
│   └── 01  PT1T2K
└── 1  PT2K
    ├── 10  PT2T1K
    └── 11  PT2T2K"""


def test_text_is_drawn_like_the_command_tree():
    assert str(ConstructionTree(2, 2)) == TWO_STEPS


def test_text_of_a_branch_and_of_some_levels():
    tree = ConstructionTree(2, 5)
    assert tree.text("10", levels=1) == "10  PT2T1K\n├── 100  PT2T1T1K\n└── 101  PT2T1T2K"
    assert tree.text(levels=0) == "PK"
    assert tree.text(levels=2) == TWO_STEPS


def test_text_of_one_transformation_a_thousand_deep():
    lines = ConstructionTree(1, 1000).text().splitlines()
    assert len(lines) == 1001
    assert lines[-1].endswith(f"{'0' * 1000}  P{'T1' * 1000}K")


def test_walk_goes_through_each_node_before_its_children():
    tree = ConstructionTree(3, 2)
    addresses = [node.address for node in tree.walk()]
    assert addresses == sorted(addresses)  # as a dictionary does, the shorter first
    assert len(addresses) == len(set(addresses)) == len(tree) == 1 + 3 + 9
    assert [node.address for node in tree.walk("2")] == ["2", "20", "21", "22"]


def test_walk_of_an_endless_tree_is_made_as_it_is_asked_for():
    walk = ConstructionTree(20, 1000).walk()
    assert [next(walk).level for _ in range(4)] == [0, 1, 2, 3]


def test_parent_and_children_lead_back():
    tree = ConstructionTree(3, 3)
    for node in tree.walk():
        assert all(child.parent == node for child in node.children)
        assert len(node.children) == (0 if node.is_leaf else 3)
    assert tree.root.parent is None
    assert tree.node("012").parent == tree.node((0, 1))
    assert tree.node("012").formula == "PT1T2T3K"


def test_digits_from_base_11_up_are_dotted():
    tree = ConstructionTree(20, 2)
    assert tree.node((19, 3)).address == "19.3"
    assert tree.node("19.3").word == (19, 3)
    assert tree.level(2, "19")[:2] == ["19.0", "19.1"]
    assert tree.node("3").children[-1].address == "3.19"


def test_level_holds_the_addresses_below_a_prefix():
    tree = ConstructionTree(2, 3)
    assert tree.level(0) == [""]
    assert tree.level(1, "1") == ["1"]
    assert tree.level(3, "10") == ["100", "101"]
    assert tree.level(3) == [node.address for node in tree.walk() if node.is_leaf]


def test_drawing_puts_nodes_over_the_middle_of_their_leaves():
    drawing = ConstructionTree(3, 2).drawing()
    assert drawing.addresses[:5] == ("", "0", "1", "2", "00")
    assert drawing.positions[:4].tolist() == [[4, 0], [1, -1], [4, -1], [7, -1]]
    assert drawing.positions[4:, 0].tolist() == list(range(9))
    assert drawing.edges[:4].tolist() == [[0, 1], [0, 2], [0, 3], [1, 4]]
    parents = [drawing.addresses[parent] for parent, _ in drawing.edges]
    children = [drawing.addresses[child] for _, child in drawing.edges]
    assert parents == [child[:-1] for child in children]
    assert children == list(drawing.addresses[1:])


def test_drawing_of_a_branch():
    drawing = ConstructionTree(2, 9).drawing("01", levels=1)
    assert drawing.addresses == ("01", "010", "011")
    assert drawing.positions.tolist() == [[0.5, 0], [0, -1], [1, -1]]
    lone = ConstructionTree(2, 2).drawing("11")
    assert lone.addresses == ("11",)
    assert lone.positions.tolist() == [[0, 0]]
    assert lone.edges.shape == (0, 2)


def test_positions_lie_exactly_in_the_middle_of_the_children():
    drawing = ConstructionTree(4, 5).drawing()
    across = drawing.positions[:, 0]
    sums = np.zeros(len(across))
    np.add.at(sums, drawing.edges[:, 0], across[drawing.edges[:, 1]])
    inner = drawing.positions[:, 1] > -5
    assert (sums[inner] / 4 == across[inner]).all()


@pytest.mark.parametrize("ask", ["text", "drawing"])
def test_more_nodes_than_memory_are_refused_and_some_levels_are_not(ask):
    tree = ConstructionTree(4, 40)
    with pytest.raises(SizeError, match=r"Depth 40 with 4 .* greatest depth that fits is 11\."):
        getattr(tree, ask)()
    assert getattr(tree, ask)("0123", levels=1)
    with pytest.raises(SizeError, match=r"about 10\^24 elements"):
        tree.level(40)


@pytest.mark.parametrize(("count", "depth"), [(0, 1), (2, -1), (2, 1001), (2.0, 1), (True, 1)])
def test_tree_refuses_what_is_no_number_of_maps_or_steps(count, depth):
    with pytest.raises(InputError, match="whole number"):
        ConstructionTree(count, depth)


@pytest.mark.parametrize(
    ("word", "message"),
    [
        ("012", "Digit 3 of '012' must be from 0 to 1"),
        ((0, -1), "must be from 0 to 1"),
        ("0000", "'0000' has 4 digits; words of this depth have at most 3"),
        ("0a", "not an address"),
    ],
)
def test_words_of_other_trees_are_refused(word, message):
    with pytest.raises(AddressError, match=message):
        read_word(word, 2, 3)
    with pytest.raises(AddressError, match=message):
        ConstructionTree(2, 3).node(word)


def test_level_out_of_range_is_refused():
    with pytest.raises(InputError, match="from 2 to 3, got 1"):
        ConstructionTree(2, 3).level(1, "01")
