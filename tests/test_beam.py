from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

import ifs_cad as ifs
from ifs_cad.design.mesh import Mesh
from ifs_cad.elements.beam import WireFrame
from ifs_cad.elements.clash import shared_radius
from ifs_cad.errors import InputError, ThicknessError


def square(size: float = 1000.0) -> Mesh:
    return Mesh([(0, 0, 0), (size, 0, 0), (size, size, 0), (0, size, 0)], [[0, 1, 2, 3]])


def test_beams_of_a_square_stop_where_the_diagonals_do() -> None:
    frame = WireFrame(square(), 40, 60)
    assert len(frame) == 4
    np.testing.assert_allclose(frame.set_backs, 20.0)  # half the width, at right angles
    np.testing.assert_allclose(frame.lengths, 960.0)
    np.testing.assert_allclose(frame.volumes, 960 * 40 * 60, rtol=1e-12)
    np.testing.assert_allclose(frame.masses, 960 * 40 * 60 * 440e-9, rtol=1e-12)
    heights = frame.solids.vertices[:, 2]
    assert set(np.round(heights, 9)) == {-30.0, 30.0}


def test_clearance_sets_every_end_back() -> None:
    frame = WireFrame(square(), 40, 60, clearance=3.0)
    np.testing.assert_allclose(frame.lengths, 954.0)


def test_regular_triangles_give_six_bars_per_node_and_cot_thirty_set_back() -> None:
    rows = 5
    points = [
        (1000 * (i + j / 2), 1000 * j * 3**0.5 / 2, 0) for j in range(rows) for i in range(rows)
    ]
    number = np.arange(rows * rows).reshape(rows, rows)
    faces = []
    for j in range(rows - 1):
        for i in range(rows - 1):
            a, b, c, d = number[j, i], number[j, i + 1], number[j + 1, i], number[j + 1, i + 1]
            faces += [[a, b, c], [b, d, c]]
    frame = WireFrame(Mesh(points, faces), 40, 60)
    inner = number[1:-1, 1:-1].ravel()
    assert (frame.bars_per_node[inner] == 6).all()
    np.testing.assert_allclose(frame.set_backs.max(), 20 / np.tan(np.radians(30)))


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1))
def test_no_two_beams_at_a_node_share_volume(seed: int) -> None:
    rng = np.random.default_rng(seed)
    flat = np.stack(np.meshgrid(range(3), range(3)), -1).reshape(-1, 2) * 1000.0
    flat = flat + rng.uniform(-200, 200, flat.shape)
    points = np.column_stack([flat, rng.normal(0, 400, len(flat))])
    mesh = Mesh(points, Delaunay(flat).simplices)
    try:
        frame = WireFrame(mesh, 30, 50)
    except ThicknessError:
        assume(False)  # slivers of triangles are too sharp for beams
    ends = np.stack([mesh.corners[frame.edges], mesh.corners[mesh.next[frame.edges]]])
    for node in range(len(points)):
        there = np.flatnonzero((ends == node).any(axis=0))
        for one, other in combinations(there.tolist(), 2):
            assert shared_radius(frame.solids, one, other) <= 1e-6


def test_edges_too_short_are_named() -> None:
    with pytest.raises(ThicknessError, match=r"b0000.*slimmer") as caught:
        WireFrame(square(100), 100, 60)
    assert len(caught.value.addresses) == 4


@pytest.mark.parametrize("section", [(0, 60), (40, -1), (np.nan, 60), (40, np.inf)])
def test_bad_section_is_refused(section: tuple[float, float]) -> None:
    with pytest.raises(InputError, match="must be positive"):
        WireFrame(square(), *section)


def test_wire_frame_becomes_an_assembly_with_labels_like_panels() -> None:
    frame = WireFrame(square(), 40, 60)
    assembly = ifs.to_assembly(frame, label=ifs.Label(face="outer", cutter=2, margin=2))
    for address, data in zip(frame.addresses, frame.part_data(), strict=True):
        part = assembly.objects[address]
        assert part.obj.isValid()
        assert part.obj.Volume() == pytest.approx(part.metadata["volume"], rel=1e-9)
        assert part.metadata["volume"] < 960 * 40 * 60
        assert data["length"] == pytest.approx(960.0)
    assert "960.0 to 960.0 mm" in frame.report()
