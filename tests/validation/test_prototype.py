"""The paper's second prototype (section 4.3, figure 21) as exact solids, all 256 of them."""

from __future__ import annotations

import runpy
from itertools import pairwise
from pathlib import Path
from typing import Any

import cadquery as cq
import numpy as np
import pytest
from OCP.BRep import BRep_Tool
from scipy.optimize import linprog

from ifs_cad.elements.clash import clashes, neighbours_at_nodes

SCRIPT = Path(__file__).parent.parent.parent / "parts" / "shell_prototype.py"


@pytest.fixture(scope="module")
def design() -> dict[str, Any]:
    return runpy.run_path(str(SCRIPT), init_globals={"show_object": lambda *_, **__: None})


@pytest.fixture(scope="module")
def placed(design: dict[str, Any]) -> dict[str, cq.Solid]:
    assembly, shell = design["assembly"], design["shell"]
    return {a: assembly.objects[a].obj.moved(assembly.objects[a].loc) for a in shell.addresses}


@pytest.mark.slow
def test_all_solids_are_valid_closed_and_of_the_closed_forms_volume(
    design: dict[str, Any], placed: dict[str, cq.Solid]
) -> None:
    assert len(placed) == 256
    for address, solid in placed.items():
        assert solid.isValid(), address
        assert all(BRep_Tool.IsClosed_s(shell.wrapped) for shell in solid.Shells()), address
        wanted = design["assembly"].objects[address].metadata["volume"]
        assert solid.Volume() == pytest.approx(wanted, rel=1e-9), address


def test_no_two_panels_share_volume_by_linear_programming(design: dict[str, Any]) -> None:
    solids = design["shell"].solids
    pairs = neighbours_at_nodes(design["shell"])
    assert len(pairs) == 2 * 15 * 16 + 2 * 15 * 15  # across edges, and across nodes
    faces = [np.flatnonzero(solids.solid_of_face == i) for i in range(len(solids))]
    for one, other in pairs:
        both = np.concatenate([faces[one], faces[other]])
        centre = solids.vertices[solids.solid_of_vertex == one].mean(axis=0)
        answer = linprog(
            [0, 0, 0, -1],
            A_ub=np.column_stack([solids.normals[both], np.ones(len(both))]),
            b_ub=solids.levels[both] - solids.normals[both] @ centre,
            bounds=[(None, None)] * 4,
        )
        assert answer.x is None or answer.x[3] <= 1e-6
    assert clashes(design["shell"]) == ()


def test_mating_chamfers_are_coplanar(design: dict[str, Any]) -> None:
    shell = design["shell"]
    solids = shell.solids
    by_pair = {
        (int(solids.solid_of_face[f]), int(solids.mates[f])): f
        for f in np.flatnonzero(solids.kinds == 2)
    }
    assert len(by_pair) == 2 * 2 * 15 * 16
    for (one, other), face in by_pair.items():
        mate = by_pair[other, one]
        loop = solids.loops[solids.face_offsets[mate] : solids.face_offsets[mate + 1]]
        height = solids.vertices[loop] @ solids.normals[face] - solids.levels[face]
        assert np.abs(height).max() <= 1e-6
        assert solids.normals[face] @ solids.normals[mate] == pytest.approx(-1.0, abs=1e-12)


@pytest.mark.slow
def test_kernel_finds_no_common_volume_in_a_sample(
    design: dict[str, Any], placed: dict[str, cq.Solid]
) -> None:
    addresses = design["shell"].mesh.addresses
    row = [addresses[16 * 7 + j] for j in range(6)]
    diagonal = [addresses[17 * k] for k in range(5)]
    for line in (row, diagonal):
        for one, other in pairwise(line):
            common = placed[one].intersect(placed[other])
            assert sum(solid.Volume() for solid in common.Solids()) == 0.0
