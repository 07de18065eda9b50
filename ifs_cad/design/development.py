"""Development: what can be unrolled into the plane without stretching.

A surface of planar faces can be unrolled around an inner node when the angles of the faces there
sum to 360 degrees. A strip of quads, one row of a mesh, has no inner node, so it always unrolls,
fold by fold about its rulings; it can be cut in one piece when its flat pattern does not cover
itself.

Terms
-----
ruling : an edge between two quads of a strip.
angle defect : 360 degrees less the sum of the angles at an inner node.

Source: the paper, section 3.3 (constraints of production); Pottmann et al., Architectural Geometry,
2007, on developable strips.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ifs_cad.design.connection import inner_nodes
from ifs_cad.design.constraint import ConstraintResult, judged, looks_at, node_faces, positive
from ifs_cad.design.mesh import Mesh
from ifs_cad.errors import InputError
from ifs_cad.types import BoolArray, FloatArray, IntArray
from ifs_cad.vectors import cross, dot, length, unit

FULL_TURN = 360.0
LEAST_DEFECT = 0.01

Along = Literal["rows", "columns"]

__all__ = ["Along", "Developable", "DevelopableStrips", "angle_defects", "flat_strips"]


@dataclass(frozen=True)
class Developable:
    """The whole mesh must unroll into the plane: no inner node may have an angle defect.

    Parameters
    ----------
    defect : float, degrees
        How far the angles at a node may be from 360.
    """

    defect: float = LEAST_DEFECT

    def __post_init__(self) -> None:
        positive(self.defect, "The angle defect")

    def check(self, design: Any) -> ConstraintResult:
        """Return the result of a mesh; offenders are the faces around nodes with a defect."""
        if not isinstance(design, Mesh):
            looks_at(self, design, "meshes")
        inner = inner_nodes(design)
        return judged(
            "angle defect",
            np.abs(angle_defects(design)[inner]),
            "at most",
            self.defect,
            lambda bad: node_faces(design, inner[bad]),
            unit="degrees",
            note=f"{len(inner)} inner nodes",
        )


@dataclass(frozen=True)
class DevelopableStrips:
    """Each strip of quads must unroll into one flat piece that does not cover itself.

    Parameters
    ----------
    along : "rows" or "columns"
        Which way the strips of the vector sum run.
    """

    along: Along = "rows"

    def __post_init__(self) -> None:
        _read_along(self.along)

    def check(self, design: Any) -> ConstraintResult:
        """Return the result of a vector sum; offenders are the faces that would lie on another.

        Raises
        ------
        InputError
            A mesh without rows and columns.
        """
        if not isinstance(design, Mesh):
            looks_at(self, design, "meshes")
        patterns = flat_strips(design, self.along)
        covered = np.array([_covered(pattern, design.tol.coincident) for pattern in patterns])
        faces = _faces(design, self.along)
        return ConstraintResult(
            f"{self.along} that cover themselves when flat",
            not covered.any(),
            float(covered.any(axis=1).sum()),
            0.0,
            "at most",
            "strips",
            tuple(design.names(faces[covered])),
            f"{len(patterns)} strips",
        )


def angle_defects(mesh: Mesh) -> FloatArray:
    """Return (v,) 360 degrees less the angles at each vertex; on borders that says nothing."""
    back = -mesh.directions[mesh.previous]
    angle = np.arctan2(length(cross(mesh.directions, back)), dot(mesh.directions, back))
    sums = np.bincount(mesh.corners, weights=np.degrees(angle), minlength=len(mesh.vertices))
    return np.asarray(FULL_TURN - sums)


def flat_strips(mesh: Mesh, along: Along = "rows") -> FloatArray:
    """Unroll the strips of a vector sum into the plane.

    Parameters
    ----------
    mesh : Mesh
        With rows and columns.
    along : "rows" or "columns"
        Strip i of the rows belongs to segment i of the first curve, strip j of the columns to
        segment j of the second.

    Returns
    -------
    (strips, n, 4, 2) float, mm
        The corners of the quads of each strip, seen from the side that the normals of a vector sum
        point to; neighbours share a ruling. Each strip begins at the origin with its first ruling
        along y and unrolls towards x.

    Raises
    ------
    InputError
        A mesh without rows and columns.
    """
    nodes = _nodes(mesh, along)
    rail, other = mesh.vertices[nodes[:-1]], mesh.vertices[nodes[1:]]
    if along == "rows":  # so that both ways are seen from the same side
        rail, other = other, rail
    start, end = rail[:, :-1], rail[:, 1:]
    ruling, far = other[:, :-1] - start, other[:, 1:] - start
    y = unit(ruling)
    ahead = end - start
    x = unit(ahead - dot(ahead, y)[..., None] * y)

    def seen(arms: FloatArray) -> Any:
        return dot(arms, x) + 1j * dot(arms, y)

    foot, head, across = seen(ahead), seen(far), 1j * length(ruling)
    # the next quad has its first ruling where this one has its last
    turn = (head - foot) / (1j * np.abs(head - foot))
    turned = np.cumprod(np.concatenate([np.ones_like(turn[:, :1]), turn[:, :-1]], axis=1), axis=1)
    moved = np.cumsum(turned * foot, axis=1) - turned * foot
    local = np.stack([np.zeros_like(foot), foot, head, across], axis=-1)
    flat = moved[..., None] + turned[..., None] * local
    return np.stack([flat.real, flat.imag], axis=-1)


def _read_along(along: str) -> None:
    if along not in ("rows", "columns"):
        raise InputError(f'Strips run along "rows" or "columns", got {along!r}.')


def _nodes(mesh: Mesh, along: str) -> IntArray:
    """Return the lattice with strips between its rows."""
    _read_along(along)
    if mesh.lattice is None:
        raise InputError(
            "Strips need the rows and columns of a vector sum; this mesh has none (leaving faces "
            "out gives them up)."
        )
    return mesh.lattice if along == "rows" else mesh.lattice.T


def _faces(mesh: Mesh, along: str) -> IntArray:
    """Return (strips, n) face numbers."""
    rows, columns = np.array(_nodes(mesh, "rows").shape) - 1
    faces = np.arange(len(mesh)).reshape(rows, columns)
    return faces if along == "rows" else faces.T


def _covered(pattern: FloatArray, near: float) -> BoolArray:
    """Return which of (n, 4, 2) convex quads share area with another; neighbours never do."""
    low, high = pattern.min(axis=1), pattern.max(axis=1)
    apart = (low[:, None] >= high).any(axis=-1)
    apart |= apart.T
    one, other = np.nonzero(np.triu(~apart, k=2))
    edges = np.roll(pattern, -1, axis=1) - pattern
    normals = np.stack([edges[..., 1], -edges[..., 0]], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    # convex shapes are apart exactly when a line along an edge of one of them parts them
    directions = np.concatenate([normals[one], normals[other]], axis=1).swapaxes(1, 2)
    a, b = pattern[one] @ directions, pattern[other] @ directions
    depth = np.minimum(a.max(axis=1) - b.min(axis=1), b.max(axis=1) - a.min(axis=1)).min(axis=1)
    covered = np.zeros(len(pattern), dtype=bool)
    covered[one[depth > near]] = covered[other[depth > near]] = True
    return covered
