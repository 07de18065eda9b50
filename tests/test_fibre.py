"""Fibre directions, against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from strategies import accepted, hexagon_meshes, meshes, panel_sides, vector_sums
from vaults import hexagon, plate, roof, vault

import ifs_cad as ifs
from ifs_cad.design.surface import vector_sum
from ifs_cad.elements.beam import WireFrame
from ifs_cad.elements.fibre import Fibre, FibreAlongCurve, FibreAlongEdge, FibreTowards
from ifs_cad.errors import InputError
from ifs_cad.types import BoolArray
from ifs_cad.vectors import cross, dot, length, unit

SLOPE = np.array([np.cos(np.radians(30)), 0, np.sin(np.radians(30))])
"""Up the half of a roof on the side of negative x, which falls by 30 degrees."""


def close(found, expected) -> None:
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("rule", "first", "second"),
    [
        (FibreAlongCurve("a"), SLOPE, SLOPE * [1, 0, -1]),
        (FibreAlongCurve("b"), [0, 1, 0], [0, 1, 0]),
        (FibreAlongCurve(), SLOPE, SLOPE * [1, 0, -1]),  # 2 x 400 mm against 500
        (FibreAlongEdge(), [0, 1, 0], [0, 1, 0]),  # 500 mm against 400
        (FibreAlongEdge(0), SLOPE, SLOPE * [1, 0, -1]),
        (FibreAlongEdge(3), [0, -1, 0], [0, -1, 0]),
        (FibreTowards((0, 0, 7.0)), SLOPE, SLOPE * [-1, 0, 1]),
        (FibreTowards((0, -1, 0)), [0, -1, 0], [0, -1, 0]),
    ],
)
def test_fibre_of_a_roof_follows_its_rule(rule: Fibre, first, second) -> None:
    shell = roof(400, 500, 30).with_fibre(rule)
    assert shell.addresses == ("0", "1")
    close(shell.fibres, [first, second])


def test_long_curve_is_the_longer_one_in_all_not_in_one_panel() -> None:
    points = [(0, 0, 0), (300, 0, 0), (600, 0, 30)]
    for width, curve in ((599, "a"), (605, "b")):
        shell = ifs.thicken(vector_sum(points, [(0, 0, 0), (0, width, 0)]), 10)
        close(
            shell.with_fibre(FibreAlongCurve("long")).fibres,
            shell.with_fibre(FibreAlongCurve(curve)).fibres,
        )


def is_in_plane(shell: ifs.Shell) -> BoolArray:
    fibres = shell.fibres
    return (np.abs(dot(fibres, shell.normals)) < 1e-9) & (np.abs(length(fibres) - 1) < 1e-12)


@given(vector_sums(), panel_sides, st.sampled_from(["a", "b"]))
def test_fibre_along_a_curve_halves_the_angle_of_its_two_edges(mesh, side, curve) -> None:
    shell = accepted(ifs.thicken, mesh, 1.0, side=side).with_fibre(FibreAlongCurve(curve))
    points = mesh.vertices[mesh.lattice]
    axis = 0 if curve == "a" else 1
    edges = unit(np.diff(points, axis=axis))
    one, other = (edges[:, :-1], edges[:, 1:]) if axis == 0 else (edges[:-1], edges[1:])
    to_one, to_other = (dot(shell.fibres, edge.reshape(-1, 3)) for edge in (one, other))
    np.testing.assert_allclose(to_one, to_other, rtol=0, atol=1e-9)
    assert (to_one > 0).all()
    assert is_in_plane(shell).all()


def test_fibre_runs_around_a_tube_and_along_it() -> None:
    turn = 2 * np.pi * np.append(np.arange(6), 0) / 6
    ring = 500 * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    shell = ifs.thicken(vector_sum(ring, [(500, 0, 0), (500, 0, 900)]), 10)
    close(shell.with_fibre(FibreAlongCurve("b")).fibres, [[0, 0, 1]] * 6)
    middle = np.pi / 6 + np.pi / 3 * np.arange(6)
    around = np.stack([-np.sin(middle), np.cos(middle), 0 * middle], axis=1)
    close(shell.with_fibre(FibreAlongCurve("long")).fibres, around)


def test_fibre_of_a_flipped_mesh_still_runs_along_its_curves() -> None:
    mesh = vault().mesh
    shell, flipped = (
        ifs.thicken(one, 5).with_fibre(FibreAlongCurve("b")) for one in (mesh, mesh.flipped())
    )
    close(flipped.fibres, shell.fibres)


@given(meshes())
def test_longest_edge_is_no_shorter_than_any_other(mesh) -> None:
    faces = np.arange(len(mesh))
    along = FibreAlongEdge().directions(mesh, faces)
    spans = dot(along[mesh.face], mesh.edge_vectors)
    reach = np.maximum.reduceat(spans, mesh.offsets[:-1])
    longest = np.maximum.reduceat(mesh.edge_lengths, mesh.offsets[:-1])
    np.testing.assert_allclose(reach, longest, rtol=0, atol=1e-6)


@given(meshes(), st.tuples(*[st.integers(-3, 3)] * 3))
def test_fibre_towards_a_direction_is_as_near_to_it_as_the_plane_allows(mesh, direction) -> None:
    assume(any(direction))
    towards = unit(np.array(direction, dtype=float))
    lean = length(cross(mesh.normals, np.broadcast_to(towards, mesh.normals.shape)))
    assume((lean > 1e-3).all())
    found = FibreTowards(direction).directions(mesh, np.arange(len(mesh)))
    np.testing.assert_allclose(found @ towards, lean, rtol=0, atol=1e-9)
    np.testing.assert_allclose(dot(found, mesh.normals), 0, atol=1e-9)


def test_direction_square_to_panels_names_them() -> None:
    with pytest.raises(InputError, match=r"square to f0000.*Tilt it") as caught:
        plate(300, 200).with_fibre(FibreTowards((0, 0, 1)))
    assert caught.value.addresses == ("f0000",)


def test_square_panel_that_is_not_made_needs_no_direction() -> None:
    shell = roof(400, 500, 0.0).part("0")
    with pytest.raises(InputError, match="square to 0 "):
        shell.with_fibre(FibreTowards((0, 0, 1)))
    tilted = roof(400, 500, 30)
    up_the_first = tuple(tilted.normals[1].tolist())
    with pytest.raises(InputError, match="square to 1 "):
        tilted.with_fibre(FibreTowards(up_the_first))
    assert is_in_plane(tilted.part("0").with_fibre(FibreTowards(up_the_first))).all()


def test_curve_of_a_mesh_that_is_no_sum_names_the_way_out() -> None:
    with pytest.raises(InputError, match=r"no sum of two curves.*along an edge"):
        plate(300, 200).with_fibre(FibreAlongCurve("a"))


@given(hexagon_meshes(), st.integers(3, 8))
def test_edge_that_faces_lack_names_them(mesh, edge) -> None:
    lacking = mesh.sizes <= edge
    rule, faces = FibreAlongEdge(edge), np.arange(len(mesh))
    if lacking.any():
        with pytest.raises(InputError, match="Edges count from 0") as caught:
            rule.directions(mesh, faces)
        assert caught.value.addresses == tuple(mesh.names(lacking.nonzero()[0]))
    else:
        close(rule.directions(mesh, faces), mesh.directions[mesh.offsets[:-1] + edge])


@pytest.mark.parametrize(
    "rule",
    [FibreAlongCurve("a"), FibreAlongEdge("longest"), FibreAlongEdge(2), FibreTowards((1, 2, 3))],
)
def test_fibre_survives_doors_parts_and_choices(rule: Fibre) -> None:
    whole = vault().with_fibre(rule)
    known = dict(zip(whole.addresses, whole.fibres, strict=True))
    door, part, taken = whole.without("12"), whole.part("0*"), whole.take([5, 3])
    assert len(door) == 15
    assert len(part) == 4
    for shell in (door, part, taken, part.without("03"), door.without("0*"), door.part("2*")):
        assert shell.fibre == rule
        close(shell.fibres, [known[address] for address in shell.addresses])


def test_fibre_of_a_door_survives_new_addresses() -> None:
    mesh = vault().mesh.without("12")
    named = mesh.with_addresses([f"x{k:02}" for k in range(len(mesh))])
    rule = FibreAlongCurve("b")
    faces = np.arange(len(mesh))
    close(rule.directions(named, faces), rule.directions(mesh, faces))


def test_part_data_tells_the_fibre_only_where_there_is_a_rule() -> None:
    shell = roof(400, 500, 30)
    assert shell.fibres is None
    assert all("fibre" not in data for data in shell.part_data())
    ruled = shell.with_fibre(FibreAlongCurve("a"))
    assert [data["fibre"] for data in ruled.part_data()] == ruled.fibres.tolist()
    free = ruled.with_fibre(None)
    assert free.fibres is None
    assert free.part_data() == shell.part_data()


def test_fibre_of_beams_runs_along_them() -> None:
    frame = WireFrame(hexagon(500).mesh, 40, 60)
    close(frame.fibres, frame.directions)


@pytest.mark.parametrize("tolerance", [-0.1, 90.1, np.nan, np.inf, "much"])
def test_tolerance_out_of_range_is_refused(tolerance) -> None:
    with pytest.raises(InputError, match="tolerance of a fibre direction must"):
        FibreAlongEdge(tolerance=tolerance)


def test_tolerance_and_half_turn_are_kept() -> None:
    rule = FibreTowards((0, 0, 1), tolerance=15.0, half_turn=False)
    assert (rule.tolerance, rule.half_turn) == (15.0, False)
    assert (FibreAlongCurve().tolerance, FibreAlongCurve().half_turn) == (0.0, True)
    assert replace(rule, tolerance=5.0).direction == (0.0, 0.0, 1.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: FibreAlongCurve("c"), '"long", "a" or "b"'),
        (lambda: FibreAlongEdge(-1), "number from 0"),
        (lambda: FibreAlongEdge(True), "number from 0"),
        (lambda: FibreAlongEdge("shortest"), "number from 0"),
        (lambda: FibreTowards((0, 0, 0)), "zero vector"),
        (lambda: FibreTowards((0, np.nan, 0)), "must be finite"),
    ],
)
def test_rules_that_cannot_be_meant_are_refused(make, message) -> None:
    with pytest.raises(InputError, match=message):
        make()
