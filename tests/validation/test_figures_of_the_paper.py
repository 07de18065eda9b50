"""The paper's own figures: Stotz, Gouaty, Weinand 2009, section 2 (figures 2 to 5) and figure 7."""

import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from ifs_cad.design.attractor import chaos_game
from ifs_cad.design.classics import cantor_set, sierpinski_triangle, von_koch_curve
from ifs_cad.design.curve import Curve
from ifs_cad.design.dimension import germ_distances, hausdorff_distance
from ifs_cad.design.figure import Figure
from ifs_cad.design.germ import Germ

T_1 = np.array([[1, 0.5, 0.25], [0, 0.5, 0.5], [0, 0, 0.25]])
T_2 = np.array([[0.25, 0, 0], [0.5, 0.5, 0], [0.25, 0.5, 1]])
CONTROL = np.array([(0.0, 0, 0), (1, 3, 0), (4, 1, 2)])
CHORD = np.eye(3)[[0, 2]]

FISH = Germ.polygon(
    [(0, 0.3), (0.25, 0.5), (0.6, 0.42), (0.8, 0.32), (1, 0.5), (0.95, 0.3), (1, 0.1), (0.8, 0.28)]
)
LETTER_A = Germ.polylines([[(0, 0), (0.5, 1), (1, 0)], [(0.25, 0.5), (0.75, 0.5)]])
SEGMENT = Germ.polyline([(0, 0), (1, 0)])


def test_figure_2_removes_the_middle_third_of_every_segment():
    figure = cantor_set()
    for depth in range(6):
        before, after = figure.at_depth(depth)[..., 0], figure.at_depth(depth + 1)[..., 0]
        start, end = before.T
        third = (end - start) / 3
        left, right = after[::2], after[1::2]
        assert np.abs(left - np.stack([start, start + third], axis=1)).max() <= 1e-15
        assert np.abs(right - np.stack([end - third, end], axis=1)).max() <= 1e-15


def test_figure_3_makes_four_duplicates_that_each_make_four():
    figure = von_koch_curve()
    # Scaled, rotated and displaced: scales 1/3, turned by 0, 60, -60 and 0 degrees.
    placed = figure.transforms(1)
    turns = np.degrees(np.arctan2(placed.rotations[:, 1, 0], placed.rotations[:, 0, 0]))
    assert turns == pytest.approx([0, 60, -60, 0], abs=1e-12)
    assert placed.scales == pytest.approx([1 / 3] * 4, rel=1e-14)
    assert not placed.mirrored.any()
    assert [len(figure.at_depth(depth)) for depth in range(5)] == [1, 4, 16, 64, 256]


def test_figure_3_has_no_section_of_finite_length():
    figure = von_koch_curve()
    for prefix in ("0", "12", "333"):
        lengths = [
            figure.germ.lengths(figure.at_depth(depth, prefix)).sum() for depth in range(3, 8)
        ]
        growth = np.array(lengths[1:]) / lengths[:-1]
        assert growth == pytest.approx([4 / 3] * 4, rel=1e-12)


@pytest.mark.parametrize(
    ("figure", "germ", "usual"),
    [
        (sierpinski_triangle(), FISH, Germ.polygon([(0, 0), (1, 0), (0.5, math.sqrt(0.75))])),
        (von_koch_curve(), LETTER_A, SEGMENT),
    ],
    ids=["Sierpinski triangle of fishes", "von Koch curve of letters A"],
)
def test_figure_4_ends_with_the_same_figure_whatever_the_primitive(figure, germ, usual):
    found = germ_distances(figure, germ.sampled(0.05), usual.sampled(0.05), range(8))
    assert (found.distances <= found.bounds * (1 + 1e-9)).all()
    assert found.bounds[7] <= found.factor**7
    limit = chaos_game(figure, 50_000)
    depth = 7
    for one in (germ, usual):
        made = figure.with_germ(one).at_depth(depth).reshape(-1, 2)
        # Everything of the limit is near, and every part has points of the limit near it.
        assert cKDTree(made).query(limit)[0].max() <= 1.5 * found.factor**depth
        assert hausdorff_distance(made, limit) <= 0.05


def test_figure_5_is_a_bezier_curve_built_as_a_von_koch_curve_is():
    figure = Figure([T_1, T_2], CONTROL.T, germ=CHORD)
    t = np.linspace(0, 1, 2**6 + 1)[:, None]
    bezier = (1 - t) ** 2 * CONTROL[0] + 2 * t * (1 - t) * CONTROL[1] + t**2 * CONTROL[2]
    assert np.abs(figure.polyline(6) - bezier).max() <= 1e-14
    assert np.abs(figure.polyline(6) - Curve(CONTROL, depth=6).points).max() <= 1e-15


def test_construction_sequence_is_the_papers_union_for_three_steps():
    figure = Figure([T_1, T_2], CONTROL.T, germ=CHORD)
    projection, germ = CONTROL.T, CHORD.T
    expected = {
        0: [projection @ germ],
        1: [projection @ T_1 @ germ, projection @ T_2 @ germ],
        2: [
            projection @ T_1 @ T_1 @ germ,
            projection @ T_1 @ T_2 @ germ,
            projection @ T_2 @ T_1 @ germ,
            projection @ T_2 @ T_2 @ germ,
        ],
    }
    expected[3] = [
        projection @ one @ two @ three @ germ
        for one in (T_1, T_2)
        for two in (T_1, T_2)
        for three in (T_1, T_2)
    ]
    for depth, elements in expected.items():
        found = figure.at_depth(depth).swapaxes(1, 2)
        assert np.abs(found - elements).max() <= 1e-15


def test_figure_7_leads_to_every_element_of_the_curve():
    curve = Curve(CONTROL, depth=3)
    figure = Figure.from_curve(curve)
    tree = figure.tree(3)
    assert str(tree).splitlines()[:5] == [
        "PK",
        "├── 0  PT1K",
        "│   ├── 00  PT1T1K",
        "│   │   ├── 000  PT1T1T1K",
        "│   │   └── 001  PT1T1T2K",
    ]
    leaves = [node for node in tree.walk() if node.is_leaf]
    assert [node.address for node in leaves] == curve.addresses
    for node in leaves:
        matrices = [(T_1, T_2)[digit] for digit in node.word]
        by_hand = CONTROL.T @ matrices[0] @ matrices[1] @ matrices[2] @ CHORD.T
        assert np.abs(figure.at(node.address) - by_hand.T).max() <= 1e-15
    for node in tree.walk("1"):
        part = figure.at_depth(3, node.address)
        first, last = part[0, 0], part[-1, -1]
        ends = figure.at(node.address)
        assert np.abs(ends - [first, last]).max() <= 1e-15
