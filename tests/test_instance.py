from __future__ import annotations

import cadquery as cq
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ifs_cad as ifs
from ifs_cad.design.affine import Placements, homogeneous
from ifs_cad.errors import GeometryError, InputError
from ifs_cad.kernel.instance import place_germ


def placed(assembly: cq.Assembly, name: str) -> cq.Shape:
    part = assembly.objects[name]
    return part.obj.moved(part.loc)


def similarity(rng: np.random.Generator, mirrored: bool) -> np.ndarray:
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    if (np.linalg.det(turn) < 0) != mirrored:
        turn[:, 0] *= -1
    return rng.uniform(0.2, 2.0) * turn


@settings(max_examples=12)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_similarity_puts_every_vertex_where_the_matrix_does(seed: int, mirrored: bool) -> None:
    rng = np.random.default_rng(seed)
    linear = similarity(rng, mirrored)[None]
    move = rng.normal(size=(1, 3)) * 100
    germ = cq.Workplane().box(3, 2, 1, centered=False).faces(">Z").chamfer(0.3)
    made = placed(place_germ(germ, Placements(homogeneous(linear, move), ("0",))), "0")
    wanted = np.array([v.toTuple() for v in germ.val().Vertices()]) @ linear[0].T + move
    got = np.array([v.toTuple() for v in made.Vertices()])
    apart = np.linalg.norm(wanted[:, None] - got[None], axis=2)
    assert apart.min(axis=1).max() < 1e-9
    assert made.isValid()
    assert made.Volume() == pytest.approx(
        germ.val().Volume() * abs(np.linalg.det(linear[0])), rel=1e-9
    )


def test_similar_copies_share_one_shape() -> None:
    linear = np.stack([0.5 * np.eye(3)] * 4)
    moves = np.arange(12.0).reshape(4, 3)
    figure = Placements(homogeneous(linear, moves), ("0", "1", "2", "3"))
    assembly = place_germ(cq.Workplane().box(1, 1, 1), figure)
    shapes = [assembly.objects[a].obj.wrapped for a in figure.addresses]
    assert all(shape.IsSame(shapes[0]) for shape in shapes)
    centres = [placed(assembly, a).Center().toTuple() for a in figure.addresses]
    np.testing.assert_allclose(centres, moves, atol=1e-12)


def test_affine_copy_has_the_volume_of_its_determinant() -> None:
    linear = np.array([[[1.0, 0.4, 0.0], [0.0, 0.5, 0.2], [0.1, 0.0, 2.0]]])
    figure = Placements(homogeneous(linear, np.zeros((1, 3))), ("0",))
    made = placed(place_germ(cq.Workplane().box(1, 2, 3), figure), "0")
    assert made.Volume() == pytest.approx(6 * np.linalg.det(linear[0]), rel=1e-9)


def test_plane_figure_scales_the_height_of_its_germ_alike() -> None:
    figure = Placements(homogeneous(np.array([np.eye(2) / 3]), np.zeros((1, 2))), ("0",))
    made = placed(place_germ(cq.Workplane().box(3, 3, 3), figure), "0")
    assert made.Volume() == pytest.approx(1.0, rel=1e-12)


def test_colours_follow_the_last_digit() -> None:
    figure = Placements(homogeneous(np.stack([np.eye(3)] * 4), np.zeros((4, 3))), tuple("0123"))
    assembly = place_germ(cq.Workplane().box(1, 1, 1), figure, colours=[(1, 0, 0), (0, 1, 0)])
    reds = [assembly.objects[a].color.toTuple()[0] for a in "0123"]
    assert reds == pytest.approx([1.0, 0.0, 1.0, 0.0])


def test_bad_germs_and_maps_are_errors() -> None:
    one = Placements(homogeneous(np.eye(3)[None], np.zeros((1, 3))), ("7",))
    flat = Placements(homogeneous(np.diag([1.0, 1.0, 0.0])[None], np.zeros((1, 3))), ("7",))
    with pytest.raises(InputError, match="no shape"):
        place_germ(cq.Workplane(), one)
    with pytest.raises(GeometryError, match="flatten"):
        place_germ(cq.Workplane().box(1, 1, 1), flat)
    with pytest.raises(InputError, match="colour"):
        place_germ(cq.Workplane().box(1, 1, 1), one, colours=[])


def test_copies_are_written_under_their_addresses(tmp_path) -> None:
    figure = ifs.classics.menger_sponge().scaled(90.0)
    cell = cq.Workplane().box(90, 90, 90, centered=False)
    assembly = place_germ(cell, figure.transforms(1))
    file = ifs.export_step(assembly, tmp_path / "sponge.step")
    read = cq.Assembly.importStep(str(file))
    leaves = [part for part in read.objects.values() if part.obj is not None]
    assert len(leaves) == 20
    volume = sum(
        part.obj.val().Volume() if isinstance(part.obj, cq.Workplane) else part.obj.Volume()
        for part in leaves
    )
    assert volume == pytest.approx(20 * 30**3, rel=1e-9)
    assert {f"{name}" for name in figure.addresses(1)} <= set(read.objects)
