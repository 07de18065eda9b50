"""The paper's own matrices: Stotz, Gouaty, Weinand 2009, section 3.1 and figure 6."""

import numpy as np

from ifs_cad.design.curve import Curve
from ifs_cad.design.transform import Scheme

T_1 = [[1, 0.5, 0.25], [0, 0.5, 0.5], [0, 0, 0.25]]
T_2 = [[0.25, 0, 0], [0.5, 0.5, 0], [0.25, 0.5, 1]]


def test_de_casteljau_for_three_points_is_the_papers_pair_to_the_letter():
    assert Scheme.de_casteljau(3).transformations.tolist() == [T_1, T_2]


def test_scheme_of_the_papers_pair_has_its_free_and_fixed_columns():
    scheme = Scheme.from_transformations([T_1, T_2])
    assert scheme.free_names == ("s2", "s3", "s5")
    assert scheme.index("s3") == scheme.index("s4")


def test_construction_sequence_of_figure_6_is_the_union_over_words():
    control = np.array([(0.0, 0, 0), (1, 3, 0), (4, 1, 2)])
    maps, germ = [np.array(T_1), np.array(T_2)], np.eye(3)[:, [0, 2]]
    elements = [
        control.T @ maps[i] @ maps[j] @ maps[k] @ germ
        for i in range(2)
        for j in range(2)
        for k in range(2)
    ]
    points = Curve(control, depth=3).points
    for number, element in enumerate(elements):
        assert np.abs(points[number : number + 2] - element.T).max() <= 1e-15


def test_column_of_a_moved_subdivision_point_is_the_inverse_projection():
    # c_i = P^-1 s_i, with a row of ones for the sum.
    control = np.array([(0.0, 0), (1, 3), (4, 1)])
    projection = np.vstack([control.T, np.ones(3)])
    curve = Curve(control).with_subdivision_point("s2", (0.3, 2.2))
    expected = np.linalg.solve(projection, [0.3, 2.2, 1])
    assert np.abs(curve.scheme.transformations[0][:, 1] - expected).max() <= 1e-14
