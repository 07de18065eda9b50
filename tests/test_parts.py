"""Every script in parts/ runs as CQ-editor and `ifs-cad build` run it, and pins a number."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from cadquery import cqgi
from shapely.geometry import LineString, Point

import ifs_cad as ifs
from ifs_cad.elements.layer import NEVER
from ifs_cad.elements.polyhedron import Kind

PARTS = Path(__file__).parent.parent / "parts"

PINNED = {
    # script: (parts shown, their mass in kg, or without one the diagonal of their box in mm)
    "bezier_vault": (495, 531.05),
    "climbing_wall": (128, 242.27),
    "dome": (160, 398.38),
    "figure_02_cantor_set": (6, 945.0),
    "figure_03_von_koch_curve": (5, 2145.7),
    "figure_04_germs": (1845, 4648.0),
    "figure_05_bezier_curve": (7, 1337.2),
    "figure_06_construction_steps": (16, 2939.7),
    "figure_07_construction_tree": (16, 3488.2),
    "figure_08_subdivision_points": (4, 1399.6),
    "figure_09_moved_subdivision_points": (8, 2565.5),
    "figure_10_roughness": (12, 2960.3),
    "figure_11_vector_sum": (3, 5060.1),
    "figure_12_point_weights": (2, 7249.8),
    "figure_13_weights_on_surfaces": (4, 10288.7),
    "figure_17_offset_mesh": (17, 131.40),
    "figure_18_thickened_surface": (256, 232.69),
    "figure_22": (768, 3429.31),
    "meander_vault": (528, 261.99),
    "shell_prototype": (256, 109.22),
    "wire_frame": (108, 93.07),
}


def built(name: str, **parameters: float) -> cqgi.BuildResult:
    source = (PARTS / f"{name}.py").read_text(encoding="utf-8")
    result = cqgi.parse(source).build(build_parameters=parameters)
    assert result.success, result.exception
    return result


def test_every_part_is_pinned() -> None:
    assert {path.stem for path in PARTS.glob("*.py")} == set(PINNED)


@pytest.mark.parametrize("name", sorted(PINNED))
def test_part_builds_through_cqgi(name: str) -> None:
    (shown,) = built(name).results
    parts = [p for p in shown.shape.objects.values() if p.obj is not None]
    count, number = PINNED[name]
    assert len(parts) == count
    mass = sum(p.metadata.get("mass", 0.0) for p in parts)
    measured = mass or shown.shape.toCompound().BoundingBox().DiagonalLength
    assert measured == pytest.approx(number, rel=1e-3 if mass else 1e-2)  # fonts differ


def test_prototype_takes_parameters() -> None:
    shell = built("shell_prototype", thickness=12.0, depth=3).results[0].shape.metadata["elements"]
    assert shell.thickness == 12.0
    assert len(shell) == 64


def test_prototype_is_the_papers() -> None:
    shell = built("shell_prototype").results[0].shape.metadata["elements"]
    vertices = shell.mesh.vertices
    assert shell.mesh.lattice.shape == (17, 17)
    assert np.ptp(vertices[:, 0]) == pytest.approx(4500.0, abs=1e-9)  # spans four and a half metres
    assert shell.thickness == 10.0
    assert shell.lost == ()
    assert shell.stubs == ()
    assert shell.solids.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-9)  # flat on the floor
    feet = shell.solids.kinds == 5
    assert feet.sum() == 32  # every panel of both feet stands
    # two curves in perpendicular planes, one of them an even fold: every node is exact
    assert shell.node_gaps.max() < 1e-9
    # all panels differ, also from each other's mirror images
    edges = np.sort(shell.mesh.edge_lengths.reshape(-1, 4), axis=1)
    shape = np.column_stack([edges, shell.mesh.areas])
    assert len(np.unique(shape.round(3), axis=0)) == 256


def planks_of(name: str, **parameters: float) -> ifs.Vault:
    vault = built(name, **parameters).results[0].shape.metadata["elements"]
    assert isinstance(vault, ifs.Vault)
    return vault


@pytest.mark.parametrize(("longest", "deviation"), [(1000.0, 20.0), (1000.0, 80.0), (2500.0, 80.0)])
def test_bezier_vault_has_the_depth_that_boards_and_smoothness_ask_for(longest, deviation):
    build = built("bezier_vault", longest=longest, deviation=deviation, layers=2)
    vault, report = build.results[0].shape.metadata["elements"], build.env["subdivision"]
    assert build.env["vault"].segments.count == 2
    own = vault.segments.lengths[vault.segments.layer == 0]
    assert len(own) == 2**report.depth
    assert own.max() <= longest
    before = report.rows[report.depth - 1]
    assert before.longest > longest or before.deviation > deviation
    # a sample of the smooth curve lies as near to the planks' axes as the report says
    curve = build.env["curve"]
    fine = curve.with_depth(report.depth + 5).points
    coarse = LineString(curve.with_depth(report.depth).points[:, [0, 2]])
    off = max(coarse.distance(Point(x, z)) for x, z in fine[:, [0, 2]])
    assert off <= report.row.deviation <= deviation
    assert off == pytest.approx(report.row.deviation, rel=0.05)


def test_bezier_vault_is_the_papers() -> None:
    vault = planks_of("bezier_vault")
    report = vault.report()
    assert report.warnings == ()
    assert vault.lengths.max() <= 1000.0
    assert report.joint_distance > 7 * 6.0  # no joint lies on its neighbour's
    assert vault.solids.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-9)  # on the floor
    assert (vault.solids.kinds == Kind.FLOOR).sum() == 2 * report.layers
    across = vault.solids.vertices @ vault.segments.across
    assert np.ptp(across) == pytest.approx(report.layers * vault.thickness, abs=1e-9)


def test_bezier_vault_has_a_model_of_a_tenth() -> None:
    vault, model = (
        planks_of("bezier_vault", layers=4),
        planks_of("bezier_vault", layers=4, scale=0.1),
    )
    assert model.addresses == vault.addresses
    np.testing.assert_allclose(model.side_lengths, 0.1 * vault.side_lengths, atol=1e-9)
    np.testing.assert_allclose(model.end_angles, vault.end_angles, atol=1e-8)
    assert model.width == pytest.approx(0.1 * vault.width)
    assert (model.thickness, vault.thickness) == (4.0, 27.0)


def test_meander_vault_is_the_papers() -> None:
    vault = planks_of("meander_vault")
    segments = vault.segments
    assert vault.report().warnings == ()
    # the curve has points of inflection and moves from layer to layer
    for layer in range(segments.count):
        turns = segments.turns[segments.layer == layer, 1]
        assert turns.min() < 0 < turns.max()
    ends = [segments.points[segments.ends[segments.layer == k][-1]] for k in range(segments.count)]
    moves = np.linalg.norm(np.diff(ends, axis=0), axis=1)
    assert (moves > 1.0).all()
    assert (moves < vault.width).all()  # neighbouring layers overlap
    # it stands at one end, the other is free and square
    assert (vault.solids.kinds == Kind.FLOOR).sum() == segments.count
    free = segments.after[vault.numbers] == NEVER
    np.testing.assert_array_equal(vault.end_angles[free, 1], 0.0)


def test_meander_vault_takes_parameters() -> None:
    vault = planks_of("meander_vault", depth=3, thickness=40.0, swing=60.0)
    assert vault.thickness == 40.0
    assert len(vault) == 16 * 8 + 16 * 9
