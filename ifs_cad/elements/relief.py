"""Node relief: keep panels apart that share a node but no edge.

Offset planes meet in one point only at a conical node. Elsewhere edge neighbours still meet on
their bisector plane, but the *corner cones* of panels across a node can overlap. Where they do,
both panels are cut by one plane through the node. The paper's construction (section 4.2, figure
17) leaves this overlap in, and section 5 reports the trouble that it makes.

A corner cone is spanned by rays from the node: the two edges of the face and the line in which
the two cut planes meet (one way from the face for "outer" and "inner", both ways for "centre").
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.design.mesh import Mesh
from ifs_cad.errors import SelfIntersectionError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import BoolArray, FloatArray, IntArray
from ifs_cad.vectors import cross, dot, length, unit

MARGIN_SHARE = 0.5  # of the best margin that the plane along the normals' difference must keep


@dataclass(frozen=True, eq=False)
class Reliefs:
    """Relief planes through nodes, one for each side of each colliding pair.

    Attributes
    ----------
    corners : (k,) int, the mesh corner that is cut
    normals : (k, 3) float, unit vectors pointing into the panel that is kept
    mates : (k,) int, the face on the other side
    """

    corners: IntArray
    normals: FloatArray
    mates: IntArray

    @classmethod
    def none(cls) -> Reliefs:
        """Return no reliefs."""
        return cls(np.empty(0, dtype=np.int64), np.empty((0, 3)), np.empty(0, dtype=np.int64))


def find_reliefs(
    mesh: Mesh,
    cuts: FloatArray,
    rises: FloatArray,
    sides: tuple[int, ...],
    tol: Tolerance = DEFAULT,
) -> Reliefs:
    """Return a relief plane for each pair of panels that collide at a node.

    Parameters
    ----------
    mesh : Mesh
    cuts : (corners, 3) float, inward unit normals of the cut planes of the half-edges
    rises : (corners, 3) float
        From each node along the meet of the two cut planes, on the side of the face's normal.
    sides : (1,), (-1,) or (1, -1)
        On which sides of the design face the panels have material.

    Raises
    ------
    SelfIntersectionError
        The design faces themselves overlap at a node.
    """
    one, other = mesh.node_pairs
    upright = unit(rises)
    cones = [_rays(mesh, upright, corners, sides) for corners in (one, other)]
    facets = [_facets(mesh, cuts, corners, sides) for corners in (one, other)]
    unsure = ~_beyond_a_facet(facets[0], cones[1], tol)
    unsure &= ~_beyond_a_facet(facets[1], cones[0], tol)
    one, other = one[unsure], other[unsure]
    collide = _cones_overlap(cones[0][unsure], cones[1][unsure], tol)
    one, other = one[collide], other[collide]
    face_one, face_other = mesh.face[one], mesh.face[other]
    planes, margins = _separating(mesh, one, other, tol)
    crossing = margins <= tol.parallel
    if crossing.any():
        names = mesh.names(np.concatenate([face_one[crossing], face_other[crossing]]))
        raise SelfIntersectionError(
            f"The design crosses itself: faces {listed(names)} overlap at the node they share. "
            "Unfold the curves there.",
            addresses=names,
        )
    return Reliefs(
        corners=np.concatenate([one, other]),
        normals=np.concatenate([planes, -planes]),
        mates=np.concatenate([face_other, face_one]),
    )


def _rays(mesh: Mesh, upright: FloatArray, corners: IntArray, sides: tuple[int, ...]) -> FloatArray:
    """Return (k, 2 + sides, 3) unit rays that span the corner cones."""
    edges = [mesh.directions[corners], -mesh.directions[mesh.previous[corners]]]
    return np.stack([*edges, *(side * upright[corners] for side in sides)], axis=1)


def _facets(mesh: Mesh, cuts: FloatArray, corners: IntArray, sides: tuple[int, ...]) -> FloatArray:
    """Return (k, 2 or 3, 3) inward unit normals of the corner cones."""
    facets = [cuts[corners], cuts[mesh.previous[corners]]]
    if len(sides) == 1:
        facets.append(sides[0] * mesh.normals[mesh.face[corners]])
    return np.stack(facets, axis=1)


def _beyond_a_facet(facets: FloatArray, rays: FloatArray, tol: Tolerance) -> BoolArray:
    """Tell which cones of rays lie wholly beyond one facet of the other cone."""
    return np.asarray(_heights(facets, rays).max(axis=0).min(axis=0) <= tol.cone)


def _cones_overlap(one: FloatArray, other: FloatArray, tol: Tolerance) -> BoolArray:
    """Tell which pairs of cones share interior.

    Two polyhedral cones are apart exactly when a plane spanned by two of their rays separates
    them: the facets of the cone of all differences are spanned so.
    """
    both = np.concatenate([one, -other], axis=1)
    first, second = np.array(list(combinations(range(both.shape[1]), 2))).T
    candidates = cross(both[:, first], both[:, second])
    size = length(candidates)
    valid = size > tol.parallel
    candidates /= np.where(valid, size, 1.0)[..., None]
    margins = _heights(candidates, both)
    # the two rays that span a candidate lie in it; rounding must not decide for them
    pick = np.arange(len(first))
    margins[first, pick] = 0.0
    margins[second, pick] = 0.0
    gap = np.maximum(margins.min(axis=0), -margins.max(axis=0))
    return np.asarray(np.where(valid.T, gap, -1.0).max(axis=0, initial=-1.0) < -tol.cone)


def _heights(normals: FloatArray, rays: FloatArray) -> FloatArray:
    """Return the (r, n, k) heights of (k, r, 3) rays over planes with (k, n, 3) normals.

    The many pairs come last: extrema over a short last axis would take ten times as long.
    """
    return np.ascontiguousarray((normals @ rays.swapaxes(1, 2)).transpose(2, 1, 0))


def _separating(
    mesh: Mesh, one: IntArray, other: IntArray, tol: Tolerance
) -> tuple[FloatArray, FloatArray]:
    """Return the relief planes of colliding pairs, and their smallest margin.

    The margin of a plane is the least sine by which the four edges at the node leave it, each to
    its own side. The plane along the difference of the normals is taken when its margin is at
    least `MARGIN_SHARE` of the best possible one; otherwise it is blended towards the best.
    """
    edges = np.stack(
        [
            mesh.directions[one],
            -mesh.directions[mesh.previous[one]],
            -mesh.directions[other],
            mesh.directions[mesh.previous[other]],
        ],
        axis=1,
    )
    best, best_margin = _widest(edges)
    between = mesh.normals[mesh.face[one]] - mesh.normals[mesh.face[other]]
    size = length(between)[:, None]
    flat = size <= tol.parallel  # parallel normals say nothing: the best plane then
    plain = np.where(flat, best, between / np.where(flat, 1.0, size))
    turned = _margin(-plain, edges) > _margin(plain, edges)
    plain = np.where(turned[:, None], -plain, plain)
    wanted = MARGIN_SHARE * best_margin
    weak = _margin(plain, edges) < wanted
    if weak.any():
        plain[weak] = _blended(plain[weak], best[weak], edges[weak], wanted[weak])
    return plain, best_margin


def _margin(planes: FloatArray, edges: FloatArray) -> FloatArray:
    return np.asarray(_heights(planes[:, None], edges).min(axis=0)[0])


def _widest(edges: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the unit vector w that maximises the smallest edge . w, and that smallest product.

    It points to the point of the edges' convex hull that is nearest to the node; for unit vectors
    this is equally far from two of them or from three, so that all candidates are tried.
    """
    pairs = [edges[:, i] + edges[:, j] for i, j in combinations(range(4), 2)]
    triples = [
        cross(edges[:, j] - edges[:, i], edges[:, k] - edges[:, i])
        for i, j, k in combinations(range(4), 3)
    ]
    candidates = np.stack([*pairs, *triples, *(-triple for triple in triples)], axis=1)
    size = length(candidates)[..., None]
    candidates = candidates / np.where(size > 0, size, 1.0)
    margins = _heights(candidates, edges).min(axis=0)
    pick = np.argmax(margins, axis=0)
    rows = np.arange(len(edges))
    return candidates[rows, pick], margins[pick, rows]


def _blended(
    plain: FloatArray, best: FloatArray, edges: FloatArray, wanted: FloatArray
) -> FloatArray:
    """Turn each plane towards the best one, just until its margin is the wanted one.

    For each edge g and m = plain + s (best - plain), g . m = wanted |m| is quadratic in s; the
    planes good for all edges form a convex cone, so the last root that an edge needs decides.
    """
    turn = best - plain
    start = np.einsum("kri,ki->kr", edges, plain)
    slope = np.einsum("kri,ki->kr", edges, turn)
    square = (wanted**2)[:, None]
    a = slope**2 - square * dot(turn, turn)[:, None]
    b = start * slope - square * dot(plain, turn)[:, None]
    c = start**2 - square * dot(plain, plain)[:, None]
    spread = np.sqrt(np.maximum(b**2 - a * c, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        roots = np.stack([(-b - spread) / a, (-b + spread) / a, -c / (2 * b)])
    # a root counts where the edge is on its own side; squaring brought the other one in
    usable = (roots >= 0) & (roots <= 1) & (start + roots * slope >= 0)
    needed = np.where(usable, roots, np.inf).min(axis=0)
    needed = np.where(start >= wanted[:, None], 0.0, np.where(np.isfinite(needed), needed, 1.0))
    return unit(plain + needed.max(axis=1)[:, None] * turn)
