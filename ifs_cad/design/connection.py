"""Topological constraints: what hangs together, and how many bars meet in a node.

Terms
-----
bar : an edge of the mesh, as a beam of a wire frame.
inner node : a node with faces all around it; it has as many bars as faces.

Source: the paper, section 3.3 (continuity; the number of bars coinciding in one node).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ifs_cad.design.constraint import (
    ConstraintResult,
    curve_names,
    judged,
    looks_at,
    node_faces,
)
from ifs_cad.design.curve import Curve
from ifs_cad.design.mesh import Mesh
from ifs_cad.design.reading import whole_number
from ifs_cad.errors import InputError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import BoolArray, FloatArray, IntArray, frozen

FEWEST_BARS = 3

__all__ = ["Continuity", "Elements", "NodeValence", "connected_parts", "inner_nodes"]


@dataclass(frozen=True, eq=False)
class Elements:
    """The elements of a figure at some construction step, to be checked.

    Parameters
    ----------
    points : (n, g, 2) or (n, g, 3) array, mm
        The points of each element.
    addresses : n strings
    tol : Tolerance

    Raises
    ------
    InputError
        Wrong shapes, points that are not finite, or not an address for each element.
    """

    points: FloatArray
    addresses: tuple[str, ...]
    tol: Tolerance = DEFAULT

    def __post_init__(self) -> None:
        points = np.array(self.points, dtype=float)
        if points.ndim != 3 or points.shape[2] not in (2, 3) or 0 in points.shape:
            raise InputError(
                f"Elements must be (n, g, 2) or (n, g, 3) points, got shape {points.shape}."
            )
        if not np.isfinite(points).all():
            raise InputError("The points of elements must be finite.")
        if len(self.addresses) != len(points):
            raise InputError(
                f"{len(points)} elements need as many addresses, got {len(self.addresses)}."
            )
        object.__setattr__(self, "points", frozen(points))
        object.__setattr__(self, "addresses", tuple(self.addresses))


@dataclass(frozen=True)
class Continuity:
    """Everything must hang together.

    A curve may not gape between its elements by more than the coincidence tolerance. A mesh must
    be in one piece across edges; faces that meet only in a node do not hold each other. Elements
    must be in one piece through points that they share: von Koch's curve is, Cantor's set is not.
    """

    def check(self, design: Any) -> ConstraintResult:
        """Return the result; offenders are the faces or elements outside the largest piece.

        Of a curve, they are the segments that begin with a gap.
        """
        if isinstance(design, Curve):
            return self._gaps(design)
        if isinstance(design, Mesh):
            edges = np.flatnonzero(design.twin >= 0)
            parts = connected_parts(
                len(design), design.face[edges], design.face[design.twin[edges]]
            )
        elif isinstance(design, Elements):
            parts = _touching(design.points, design.tol.coincident)
        else:
            looks_at(self, design, "curves, meshes and elements")
        labels, sizes = np.unique(parts, return_counts=True)
        outside = parts != labels[sizes.argmax()]
        names = tuple(design.addresses[number] for number in np.flatnonzero(outside))
        return ConstraintResult(
            "continuity", len(labels) == 1, float(len(labels)), 1.0, "exactly", "pieces", names
        )

    def _gaps(self, curve: Curve) -> ConstraintResult:
        gaps = curve.gaps()
        each = curve.segments // (len(gaps) + 1)

        def names(bad: BoolArray) -> list[str]:
            chosen = np.zeros(curve.segments, dtype=bool)
            chosen[each::each] = bad
            return curve_names(curve, chosen)

        return judged("continuity", gaps, "at most", curve.tol.coincident, names, unit="mm gap")


@dataclass(frozen=True)
class NodeValence:
    """Each inner node must join the same number of bars, six in regular triangular faces.

    Parameters
    ----------
    bars : int
        At least 3.
    """

    bars: int

    def __post_init__(self) -> None:
        whole_number(self.bars, "The number of bars of a node", FEWEST_BARS)

    def check(self, design: Any) -> ConstraintResult:
        """Return the result of a mesh; offenders are the faces around nodes of another number."""
        if not isinstance(design, Mesh):
            looks_at(self, design, "meshes")
        inner = inner_nodes(design)
        return judged(
            "bars at inner nodes",
            design.valences[inner].astype(float),
            "exactly",
            float(self.bars),
            lambda bad: node_faces(design, inner[bad]),
            note=f"{len(inner)} inner nodes",
        )


def inner_nodes(mesh: Mesh) -> IntArray:
    """Return the numbers of the vertices with faces all around."""
    border = np.flatnonzero(mesh.twin < 0)
    inner = mesh.valences > 0
    inner[mesh.corners[border]] = False
    inner[mesh.corners[mesh.next[border]]] = False
    return np.flatnonzero(inner)


def connected_parts(count: int, one: IntArray, other: IntArray) -> IntArray:
    """Return a label for each of `count` things: the smallest number of its connected part.

    Parameters
    ----------
    count : int
    one, other : (k,) int
        Pairs that are connected.
    """
    label = np.arange(count)
    while True:
        joined = label.copy()
        np.minimum.at(joined, label[one], label[other])
        np.minimum.at(joined, label[other], label[one])
        joined = joined[joined]
        if (joined == label).all():
            return label
        label = joined


def _touching(points: FloatArray, near: float) -> IntArray:
    """Return labels of (n, g, d) elements that share points, up to rounding.

    Points nearer than `near` fall into one cell of a grid of cells 2 (d + 1) times as large, or of
    the same grid moved along its diagonal by one of d other shares of a cell.
    """
    count, each, dimensions = points.shape
    owner = np.repeat(np.arange(count), each)
    scaled = points.reshape(-1, dimensions) / (2 * (dimensions + 1) * near)
    ones, others, total = [], [], count
    for number in range(dimensions + 1):
        cells = np.floor(scaled + number / (dimensions + 1))
        _, cell = np.unique(cells, axis=0, return_inverse=True)
        ones.append(owner)
        others.append(total + cell.ravel())
        total += int(cell.max()) + 1
    labels = connected_parts(total, np.concatenate(ones), np.concatenate(others))
    return labels[:count]
