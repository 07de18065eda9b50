from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ifs_cad as ifs
from ifs_cad.design.meshfile import read_mesh
from ifs_cad.errors import InputError, ManifoldError, PlanarityError

pytest.importorskip("compas")

CUBE = np.array([(x, y, z) for z in (0, 400) for y in (0, 400) for x in (0, 400)], dtype=float)
SIDES = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]]


def obj(path: Path, vertices: np.ndarray, faces: list[list[int]]) -> Path:
    lines = ["v {:.17g} {:.17g} {:.17g}".format(*v) for v in vertices]
    lines += ["f " + " ".join(str(i + 1) for i in face) for face in faces]
    path.write_text("\n".join(lines) + "\n")
    return path


def off(path: Path, vertices: np.ndarray, faces: list[list[int]]) -> Path:
    lines = ["OFF", f"{len(vertices)} {len(faces)} 0"]
    lines += ["{:.17g} {:.17g} {:.17g}".format(*v) for v in vertices]
    lines += [f"{len(face)} " + " ".join(map(str, face)) for face in faces]
    path.write_text("\n".join(lines) + "\n")
    return path


def ply(path: Path, vertices: np.ndarray, faces: list[list[int]]) -> Path:
    lines = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}"]
    lines += [f"property double {axis}" for axis in "xyz"]
    lines += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    lines += ["{:.17g} {:.17g} {:.17g}".format(*v) for v in vertices]
    lines += [f"{len(face)} " + " ".join(map(str, face)) for face in faces]
    path.write_text("\n".join(lines) + "\n")
    return path


def stl(path: Path, vertices: np.ndarray, faces: list[list[int]]) -> Path:
    lines = ["solid x"]
    for ring in faces:
        for k in range(1, len(ring) - 1):
            lines += ["facet normal 0 0 0", "outer loop"]
            corners = (vertices[ring[i]] for i in (0, k, k + 1))
            lines += ["vertex {:.9g} {:.9g} {:.9g}".format(*corner) for corner in corners]
            lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid x"]) + "\n")
    return path


@pytest.mark.parametrize(("write", "faces"), [(obj, 6), (off, 6), (ply, 6), (stl, 12)])
def test_cube_reads_back_whole_from_every_format(tmp_path, write, faces) -> None:
    mesh = read_mesh(write(tmp_path / f"cube.{write.__name__}", CUBE, SIDES))
    assert len(mesh) == faces
    assert mesh.addresses[0] == "f0000"
    assert (mesh.twin >= 0).all()
    assert mesh.areas.sum() == pytest.approx(6 * 400**2)
    outward = np.einsum("ij,ij->i", mesh.normals, mesh.centroids - 200)
    assert (outward > 0).all()


def test_digits_survive_so_that_planar_faces_stay_planar(tmp_path) -> None:
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    mesh = read_mesh(obj(tmp_path / "turned.obj", CUBE @ turn.T + 1234.5, SIDES))
    assert mesh.planarity.max() < 1e-9


@pytest.mark.parametrize("seed", range(8))
def test_faces_in_any_sense_are_turned_outwards(tmp_path, seed) -> None:
    flips = np.random.default_rng(seed).integers(0, 2, len(SIDES))
    mixed = [ring[::-1] if flip else ring for ring, flip in zip(SIDES, flips, strict=True)]
    mesh = read_mesh(obj(tmp_path / "mixed.obj", CUBE, mixed))
    outward = np.einsum("ij,ij->i", mesh.normals, mesh.centroids - 200)
    assert (outward > 0).all()


def test_open_mesh_follows_its_first_face(tmp_path) -> None:
    grid = np.array([(x, y, 0) for y in range(3) for x in range(3)], dtype=float)
    quads = [[0, 1, 4, 3], [2, 1, 4, 5], [3, 4, 7, 6], [4, 7, 8, 5]]
    up = read_mesh(obj(tmp_path / "a.obj", grid, quads))
    down = read_mesh(obj(tmp_path / "b.obj", grid, [quads[0][::-1], *quads[1:]]))
    np.testing.assert_allclose(up.normals, [[0, 0, 1]] * 4)
    np.testing.assert_allclose(down.normals, [[0, 0, -1]] * 4)


def test_scale_turns_metres_into_millimetres(tmp_path) -> None:
    mesh = read_mesh(obj(tmp_path / "m.obj", CUBE / 1000, SIDES), scale=1000)
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), 400)


def test_moebius_strip_is_refused(tmp_path) -> None:
    count = 9
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    across = np.stack(
        [np.cos(angle / 2) * np.cos(angle), np.cos(angle / 2) * np.sin(angle), np.sin(angle / 2)],
        axis=1,
    )
    middle = 5 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    points = np.concatenate([middle - across, middle + across])
    faces = []
    for i in range(count):
        j = (i + 1) % count
        near, far = (j, j + count) if j else (j + count, j)
        faces += [[i, near, i + count], [near, far, i + count]]
    with pytest.raises(ManifoldError, match="one side"):
        read_mesh(obj(tmp_path / "moebius.obj", points, faces))


def test_three_faces_at_one_edge_are_refused_by_name(tmp_path) -> None:
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1)], dtype=float)
    with pytest.raises(ManifoldError, match="f0000, f0001, f0002"):
        read_mesh(obj(tmp_path / "fin.obj", points, [[0, 1, 2], [1, 0, 3], [0, 1, 4]]))


def test_warped_quad_is_refused_and_can_be_split(tmp_path) -> None:
    warped = CUBE.copy()
    warped[7, 2] += 5
    file = obj(tmp_path / "warped.obj", warped, SIDES)
    with pytest.raises(PlanarityError, match="f0001"):
        read_mesh(file)
    mesh = read_mesh(file, triangulate=True)
    assert {"f0001a", "f0001b"} <= set(mesh.addresses)
    assert len(mesh) == 7  # the two other sides at the moved corner stay planar


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("x.obj", "", "no faces"),
        ("x.obj", "v 1 2 3\nf 1 2 9\n", "cannot be read|vertex"),
        ("x.off", "OFF\n1 1", "cannot be read|no faces"),
        ("x.step", "ISO", "must end in"),
    ],
)
def test_bad_file_says_so(tmp_path, name, text, message) -> None:
    file = tmp_path / name
    file.write_text(text)
    with pytest.raises(InputError, match=message):
        read_mesh(file)


def test_missing_file_says_so(tmp_path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_mesh(tmp_path / "nowhere.obj")


def test_mesh_from_a_file_becomes_panels_like_any_other(tmp_path) -> None:
    shell = ifs.thicken(read_mesh(obj(tmp_path / "cube.obj", CUBE, SIDES)), 15.0, side="inner")
    np.testing.assert_allclose(np.abs(shell.chamfer_angles), 45.0)
    assert shell.volumes.sum() == pytest.approx(400**3 - 370**3, rel=1e-12)
    assert ifs.clashes(shell) == ()


def test_mesh_from_a_file_is_labelled_written_and_checked_like_any_other(tmp_path) -> None:
    shell = ifs.thicken(read_mesh(obj(tmp_path / "cube.obj", CUBE, SIDES)), 15.0, side="inner")
    file = ifs.export_step(ifs.to_assembly(shell, label="engraved"), tmp_path / "cube.step")
    report = ifs.check_step(file)
    assert report.ok, str(report)
    assert "6 of 6 parts carry their name" in report["labels"].finding
