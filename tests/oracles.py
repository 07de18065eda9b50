"""Answers by other means: linear programming and scipy's half-space intersection.

Nothing here uses the certificates, cut planes or corners that the package computes itself, apart
from the face planes of finished panels, which other tests prove right.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import block_diag
from scipy.spatial import ConvexHull, HalfspaceIntersection

from ifs_cad.design.mesh import Mesh
from ifs_cad.elements.panel import Panel, Shell
from ifs_cad.elements.polyhedron import Kind, Polyhedra
from ifs_cad.types import FloatArray


def planes_of(solids: Polyhedra, number: int) -> FloatArray:
    """Return the (k, 4) face planes of one solid, rows (outward normal, level)."""
    faces = slice(solids.solid_offsets[number], solids.solid_offsets[number + 1])
    return np.column_stack([solids.normals[faces], solids.levels[faces]])


def points_of(solids: Polyhedra, number: int) -> FloatArray:
    """Return the (k, 3) vertices of one solid."""
    return solids.vertices[solids.solid_of_vertex == number]


def shared_balls(solids: Polyhedra, pairs: list[tuple[int, int]]) -> FloatArray:
    """Return the radius of the largest ball in each pair of solids; negative when they are apart.

    All pairs in one linear program, whose blocks do not touch: maximise the sum of the radii r
    under normal . x + r <= level.
    """
    if not pairs:
        return np.empty(0)
    blocks, bounds = [], []
    for one, other in pairs:
        planes = np.vstack([planes_of(solids, one), planes_of(solids, other)])
        middle = points_of(solids, one).mean(axis=0)
        blocks.append(np.column_stack([planes[:, :3], np.ones(len(planes))]))
        bounds.append(planes[:, 3] - planes[:, :3] @ middle)
    answer = linprog(
        c=np.tile([0.0, 0.0, 0.0, -1.0], len(pairs)),
        A_ub=block_diag(blocks, format="csr"),
        b_ub=np.concatenate(bounds),
        bounds=(None, None),
        method="highs",
    )
    assert answer.status == 0, answer.message
    return np.asarray(answer.x[3::4])


def pairs_that_share_a_node(shell: Shell) -> list[tuple[int, int]]:
    """Return every two panels that have a mesh vertex in common, by looking at all of them."""
    polygons = shell.mesh.polygons()
    corners = [set(polygons[face]) for face in shell.faces]
    return [
        (one, other)
        for other in range(len(shell))
        for one in range(other)
        if corners[one] & corners[other]
    ]


def half_spaces(shell: Shell, panel: Panel) -> FloatArray:
    """Return the (k, 4) half-spaces normal . x + d <= 0 that define a panel.

    Slab and bisector planes come from the vertices of the mesh alone; relief and floor planes from
    the panel.
    """
    mesh, low, high = shell.mesh, *shell.thickening.levels
    polygons = mesh.polygons()
    ring = mesh.vertices[polygons[panel.face]]
    normals = [face_normal(mesh, polygon) for polygon in polygons]
    normal = normals[panel.face]
    rows = [[*normal, -normal @ ring[0] - high], [*-normal, normal @ ring[0] + low]]
    starts = mesh.offsets[panel.face]
    for k, (start, end) in enumerate(zip(ring, np.roll(ring, -1, axis=0), strict=True)):
        edge = {polygons[panel.face][k], polygons[panel.face][(k + 1) % len(ring)]}
        others = [
            number
            for number, polygon in enumerate(polygons)
            if number != panel.face and edge <= set(polygon)
        ]
        within = normal + (normals[others[0]] if others else normal)
        outward = np.cross(end - start, within)
        outward /= np.linalg.norm(outward)
        rows.append([*outward, -outward @ start + shell.set_backs[starts + k]])
    solid = panel.solid
    for number in np.flatnonzero((solid.kinds == Kind.RELIEF) | (solid.kinds == Kind.FLOOR)):
        rows.append([*solid.normals[number], -solid.levels[number]])
    return np.array(rows)


def face_normal(mesh: Mesh, polygon: list[int]) -> FloatArray:
    """Return the unit normal of a planar polygon, from its two longest diagonals or edges."""
    ring = mesh.vertices[polygon]
    arms = ring - ring.mean(axis=0)
    normal = np.cross(arms, np.roll(arms, -1, axis=0)).sum(axis=0)
    return np.asarray(normal / np.linalg.norm(normal))


def corners_by_half_spaces(rows: FloatArray, inside: FloatArray) -> FloatArray:
    """Return the corners of the intersection of half-spaces, by scipy (qhull)."""
    shifted = rows.copy()
    shifted[:, 3] += rows[:, :3] @ inside
    return HalfspaceIntersection(shifted, np.zeros(3)).intersections + inside


def hull_volume(points: FloatArray) -> float:
    """Return the volume of the convex hull of points, by scipy (qhull)."""
    return float(ConvexHull(points - points.mean(axis=0)).volume)
