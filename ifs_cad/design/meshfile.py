"""Meshes from elsewhere: planar-faced polygons out of OBJ, PLY, OFF and STL files.

`compas` reads the files, with all digits and with faces of any size; here they are oriented in one
sense and become a `Mesh`, whose faces are called f0000, f0001, ... in the order of the file.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from ifs_cad import libraries
from ifs_cad.design.address import face_addresses, listed
from ifs_cad.design.mesh import Mesh
from ifs_cad.errors import InputError, ManifoldError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import FloatArray, IntArray
from ifs_cad.vectors import cross, dot

FORMATS = (".obj", ".off", ".ply", ".stl")
UNSEEN = -1


def read_mesh(
    path: str | os.PathLike[str],
    *,
    scale: float = 1.0,
    triangulate: bool = False,
    tol: Tolerance = DEFAULT,
) -> Mesh:
    """Read a mesh of planar convex polygons.

    Parameters
    ----------
    path : file ending in .obj, .ply, .off or .stl
        Points of an STL file that agree in their first three decimals are one.
    scale : float
        Millimetres per unit of the file: 1000 for metres.
    triangulate : bool
        Split faces that are not planar or not convex into triangles around their first corner,
        called f0042a, f0042b, ...

    Returns
    -------
    Mesh
        With all faces in one sense; the first face of each connected part decides, and a closed
        part has its faces looking outwards.

    Raises
    ------
    InputError
        No such file, an unknown format, a file without faces or one that cannot be read.
    PlanarityError, ConvexityError, DegenerateFaceError, ManifoldError
        As for `Mesh`, naming the faces by their place in the file; a surface with one side only
        (a Moebius strip) is a ManifoldError.
    MissingLibraryError
        `compas` is not installed.
    """
    source = Path(path)
    if source.suffix.lower() not in FORMATS:
        raise InputError(f"{source}: a mesh file must end in one of {', '.join(FORMATS)}.")
    if not source.is_file():
        raise InputError(f"{source}: there is no such file.")
    if not (np.isfinite(scale) and scale > 0):
        raise InputError(f"scale must be positive, got {scale}.")
    vertices, faces = _read(source)
    if not faces:
        raise InputError(f"{source}: the file holds no faces.")
    names = face_addresses(len(faces))
    points = np.array(vertices, dtype=float).reshape(-1, 3) * scale
    if triangulate:
        faces, names = _with_triangles(points, faces, names, tol)
    used, renumbered = np.unique(np.concatenate(faces), return_inverse=True)
    sizes = np.array([len(face) for face in faces])
    corners = _oriented(points[used], renumbered, sizes, names)
    polygons = np.split(corners, np.cumsum(sizes)[:-1])
    return Mesh(points[used], polygons, addresses=tuple(names), tol=tol)


def _read(source: Path) -> tuple[Any, list[list[int]]]:
    files = libraries.require("compas.files", "reading mesh files", extra="mesh")
    reader = getattr(files, source.suffix[1:].upper())
    try:
        file = reader(str(source))
        if source.suffix.lower() == ".obj":
            file.read()
            return file.vertices, list(file.faces or ())
        part = file.reader if source.suffix.lower() == ".off" else file.parser
        return part.vertices, list(part.faces)
    except (ValueError, IndexError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{source}: cannot be read as a mesh: {error}.") from error


def _oriented(points: FloatArray, corners: IntArray, sizes: IntArray, names: list[str]) -> IntArray:
    """Return the corners with the faces of each connected part turned into one sense."""
    face = np.repeat(np.arange(len(sizes)), sizes)
    ends = np.cumsum(sizes)
    following = np.arange(1, len(corners) + 1)
    following[ends - 1] = ends - sizes
    start, end = corners, corners[following]
    key = np.minimum(start, end) * len(points) + np.maximum(start, end)
    order = np.argsort(key, kind="stable")
    pair = np.flatnonzero(key[order[1:]] == key[order[:-1]])
    one, other = order[pair], order[pair + 1]
    opposed = start[one] == start[other]  # both run the same way, so one face must turn
    sides = np.concatenate([face[one], face[other]])
    across = np.concatenate([face[other], face[one]])
    turns = np.concatenate([opposed, opposed]).astype(np.int64)

    turned = np.full(len(sizes), UNSEEN)
    part = np.full(len(sizes), UNSEEN)
    while (turned == UNSEEN).any():
        seed = int(np.argmax(turned == UNSEEN))
        turned[seed], part[seed] = 0, seed
        while True:  # one ring of neighbours after the other
            reached = (turned[sides] != UNSEEN) & (turned[across] == UNSEEN)
            if not reached.any():
                break
            turned[across[reached]] = turned[sides[reached]] ^ turns[reached]
            part[across[reached]] = seed
    torn = (turned[sides] ^ turns) != turned[across]
    if torn.any():
        both = sorted({names[i] for i in sides[torn]})
        raise ManifoldError(
            f"The faces cannot be turned into one sense: the surface has one side only, at "
            f"{listed(both)}. Cut it open there.",
            addresses=both,
        )
    turned ^= _inside_out(points, corners, face, ends - sizes, turned, part, sides)
    mirror = (2 * ends - sizes - 1)[face] - np.arange(len(corners))
    return np.where(turned[face] == 1, corners[mirror], corners)


def _inside_out(
    points: FloatArray,
    corners: IntArray,
    face: IntArray,
    starts: IntArray,
    turned: IntArray,
    part: IntArray,
    sides: IntArray,
) -> IntArray:
    """Return 1 for the faces of closed parts that look inwards, else 0."""
    size = np.bincount(face)
    following = np.arange(1, len(corners) + 1)
    following[starts + size - 1] = starts
    position = points[corners] - points.mean(axis=0)
    anchor = position[starts][face]
    triples = dot(anchor, cross(position, position[following]))
    volume = np.bincount(face, weights=triples) * np.where(turned == 1, -1.0, 1.0)
    closed = np.bincount(sides, minlength=len(size)) == size
    open_part = np.zeros(len(size), dtype=bool)
    open_part[part[~closed]] = True
    inwards = np.bincount(part, weights=volume, minlength=len(size)) < 0
    return (inwards & ~open_part)[part].astype(np.int64)


def _with_triangles(
    points: FloatArray, faces: list[list[int]], names: list[str], tol: Tolerance
) -> tuple[list[list[int]], list[str]]:
    """Split the faces that are not planar or not convex into triangles."""
    result, called = [], []
    for ring, name in zip(faces, names, strict=True):
        if len(ring) == 3 or _planar_and_convex(points[ring], tol):
            result.append(ring)
            called.append(name)
            continue
        for k in range(1, len(ring) - 1):
            result.append([ring[0], ring[k], ring[k + 1]])
            called.append(f"{name}{_letters(k - 1)}")
    return result, called


def _planar_and_convex(ring: FloatArray, tol: Tolerance) -> bool:
    arms = np.roll(ring, -1, axis=0) - ring
    area = cross(ring - ring[0], np.roll(ring, -1, axis=0) - ring[0]).sum(axis=0)
    normal = area / np.linalg.norm(area)
    flat = np.abs((ring - ring.mean(axis=0)) @ normal).max() <= tol.planar
    return bool(flat and (cross(np.roll(arms, 1, axis=0), arms) @ normal > 0).all())


def _letters(number: int) -> str:
    """Return a, b, ..., z, aa, ab, ... for 0, 1, ..."""
    word = chr(ord("a") + number % 26)
    return word if number < 26 else _letters(number // 26 - 1) + word
