"""Every script in parts/ runs as CQ-editor and `ifs-cad build` run it, and pins a number."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from cadquery import cqgi

PARTS = Path(__file__).parent.parent / "parts"

PINNED = {
    # script: (parts shown, their mass in kg)
    "shell_prototype": (256, 109.22),
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
    solids = [p for p in shown.shape.objects.values() if "solid" in p.metadata]
    count, mass = PINNED[name]
    assert len(solids) == count
    assert sum(p.metadata["mass"] for p in solids) == pytest.approx(mass, abs=0.01)


def test_prototype_takes_parameters() -> None:
    shell = built("shell_prototype", thickness=12.0, depth=3).results[0].shape.metadata["shell"]
    assert shell.thickness == 12.0
    assert len(shell) == 64


def test_prototype_is_the_papers() -> None:
    shell = built("shell_prototype").results[0].shape.metadata["shell"]
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
