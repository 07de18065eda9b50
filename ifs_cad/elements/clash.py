"""Interference: which panels share volume, and how much.

Two convex panels share volume when a ball fits into both; its largest radius is the measure, mm.
A plane of one panel that has the whole other panel on its far side proves that there is none; what
is left after that proof is decided by linear programming.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog
from scipy.spatial import cKDTree

from ifs_cad.design.address import listed
from ifs_cad.elements.element import Elements
from ifs_cad.elements.panel import Shell
from ifs_cad.elements.polyhedron import Polyhedra
from ifs_cad.errors import ClashError, SelfIntersectionError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import BoolArray, FloatArray, IntArray
from ifs_cad.vectors import cross, length

PAIRS_AT_ONCE = 20_000


@dataclass(frozen=True)
class Clash:
    """Two panels that share volume.

    Attributes
    ----------
    addresses : the two panels
    radius : float, of the largest ball inside both, mm
    share_node : bool, whether they have a node in common
    faces_cross : bool, whether their design faces cross as well
    """

    addresses: tuple[str, str]
    radius: float
    share_node: bool
    faces_cross: bool


def clashes(elements: Elements, tol: Tolerance = DEFAULT) -> tuple[Clash, ...]:
    """Return every pair of elements that share volume; none in a design that can be built."""
    shell = elements if isinstance(elements, Shell) else None
    near = np.empty((0, 2), dtype=np.int64) if shell is None else neighbours_at_nodes(shell)
    far = overlapping(*boxes(elements.solids))
    known = near[:, 0] * len(elements) + near[:, 1]
    far = far[~np.isin(far[:, 0] * len(elements) + far[:, 1], known)]
    found = []
    for pairs, share_node in ((near, True), (far, False)):
        for one, other in pairs[~apart(elements.solids, pairs, tol)]:
            radius = shared_radius(elements.solids, int(one), int(other))
            if radius > tol.shared_radius:
                names = (elements.addresses[one], elements.addresses[other])
                crossing = (
                    shell is not None
                    and not share_node
                    and _faces_cross(shell, int(one), int(other))
                )
                found.append(Clash(names, radius, share_node, crossing))
    return tuple(found)


def require_disjoint(elements: Elements, tol: Tolerance = DEFAULT) -> None:
    """Raise when any two elements share volume.

    Raises
    ------
    SelfIntersectionError
        Design faces cross.
    ClashError
        Panels meet only through their thickness, or at a node that has no relief.
    """
    found = clashes(elements, tol)
    crossing = [clash for clash in found if clash.faces_cross]
    at_nodes = [clash for clash in found if clash.share_node]
    for error, some, what, advice in (
        (SelfIntersectionError, crossing, "The design crosses itself", "Move the curves apart."),
        (
            ClashError,
            at_nodes,
            "Panels that share a node run into each other",
            'Thicken with nodes="relief".',
        ),
        (
            ClashError,
            list(found),
            "Panels run into each other through their thickness, though the design does not cross "
            "itself",
            "Use thinner panels, the other side, or more distance.",
        ),
    ):
        if some:
            names = [" and ".join(clash.addresses) for clash in some]
            deepest = max(clash.radius for clash in some)
            raise error(
                f"{what}: {listed(names)} share a ball of up to {deepest:.3g} mm radius. {advice}",
                addresses=sorted({name for clash in some for name in clash.addresses}),
                radius=deepest,
            )


def neighbours_at_nodes(shell: Shell) -> IntArray:
    """Return the (k, 2) pairs of panels, smaller number first, that share a node or an edge."""
    number = np.full(len(shell.mesh), -1)
    number[shell.faces] = np.arange(len(shell))
    one, other = (number[shell.mesh.face[side]] for side in shell.mesh.same_node)
    made = (one >= 0) & (other >= 0) & (one != other)
    pairs = np.sort(np.stack([one[made], other[made]], axis=1), axis=1)
    return np.unique(pairs, axis=0)


def apart(solids: Polyhedra, pairs: IntArray, tol: Tolerance = DEFAULT) -> BoolArray:
    """Tell for (k, 2) pairs of solids whether a face plane of one keeps them apart."""
    planes, points = _padded(solids)
    result = np.empty(len(pairs), dtype=bool)
    for start in range(0, len(pairs), PAIRS_AT_ONCE):
        one, other = pairs[start : start + PAIRS_AT_ONCE].T
        gap = np.maximum(
            _widest_gap(planes[one], points[other]), _widest_gap(planes[other], points[one])
        )
        result[start : start + PAIRS_AT_ONCE] = gap >= -tol.shared_radius
    return result


def shared_radius(solids: Polyhedra, one: int, other: int) -> float:
    """Return the radius of the largest ball inside two solids, mm; 0 when they are apart.

    A linear program: maximise r under normal . x + r <= level for every face of both.
    """
    faces = np.isin(solids.solid_of_face, (one, other))
    origin = solids.vertices[solids.solid_of_vertex == one].mean(axis=0)
    normals = solids.normals[faces]
    answer = linprog(
        c=[0.0, 0.0, 0.0, -1.0],
        A_ub=np.column_stack([normals, np.ones(len(normals))]),
        b_ub=solids.levels[faces] - normals @ origin,
        bounds=[(None, None)] * 4,
        method="highs",
    )
    return max(0.0, float(answer.x[3])) if answer.status == 0 else 0.0


def _widest_gap(planes: FloatArray, points: FloatArray) -> FloatArray:
    """Return the widest gap between (k, f, 4) planes and (k, v, 3) points, for each k."""
    heights = planes[..., :3] @ points.swapaxes(1, 2) - planes[..., 3:]
    return np.asarray(heights.min(axis=2).max(axis=1))


def _padded(solids: Polyhedra) -> tuple[FloatArray, FloatArray]:
    """Return (s, f, 4) face planes and (s, v, 3) vertices, filled up with the first of each."""
    first, sizes = solids.solid_offsets[:-1], np.diff(solids.solid_offsets)
    slot = np.arange(sizes.max())
    faces = first[:, None] + np.where(slot < sizes[:, None], slot, 0)
    planes = np.concatenate([solids.normals, solids.levels[:, None]], axis=1)[faces]
    order = np.argsort(solids.solid_of_vertex, kind="stable")
    sizes = np.bincount(solids.solid_of_vertex, minlength=len(solids))
    first = np.cumsum(sizes) - sizes
    slot = np.arange(sizes.max())
    vertices = order[first[:, None] + np.where(slot < sizes[:, None], slot, 0)]
    return planes, solids.vertices[vertices]


def boxes(solids: Polyhedra) -> tuple[FloatArray, FloatArray]:
    """Return the (s, 3) lower and upper corners of the solids' bounding boxes, mm."""
    low = np.full((len(solids), 3), np.inf)
    high = -low
    np.minimum.at(low, solids.solid_of_vertex, solids.vertices)
    np.maximum.at(high, solids.solid_of_vertex, solids.vertices)
    return low, high


def overlapping(low: FloatArray, high: FloatArray) -> IntArray:
    """Return the (k, 2) pairs of (s, 3) boxes, smaller number first, that overlap or touch."""
    reach = float(length(high - low).max(initial=0.0))
    pairs = cKDTree((low + high) / 2).query_pairs(reach, output_type="ndarray")
    one, other = pairs[:, 0], pairs[:, 1]
    overlap = ((low[one] <= high[other]) & (low[other] <= high[one])).all(axis=1)
    return np.sort(pairs[overlap].astype(np.int64), axis=1)


def _faces_cross(shell: Shell, one: int, other: int) -> bool:
    """Tell whether two design faces have a point in common."""
    mesh = shell.mesh
    pair = shell.faces[[one, other]]
    sides = np.isin(mesh.face, pair)
    inward = cross(mesh.normals[mesh.face[sides]], mesh.directions[sides])
    origin = mesh.centroids[pair[0]]
    answer = linprog(
        c=np.zeros(3),
        A_ub=-inward,
        b_ub=-np.einsum("ij,ij->i", inward, mesh.positions[sides] - origin),
        A_eq=mesh.normals[pair],
        b_eq=np.einsum("ij,ij->i", mesh.normals[pair], mesh.centroids[pair] - origin),
        bounds=[(None, None)] * 3,
        method="highs",
    )
    return bool(answer.status == 0)
