"""Assembly order: which elements are put up together, and in which order.

A *step* is what is put up between two looks at the plan: a layer of a vault; a row or a column of a
vector sum, whichever are more level; else the elements whose addresses share a prefix. A *row* lies
between two neighbouring lines across the first curve, a *column* across the second. An arch over
its first curve goes up by rows, a dome by the rings around its axis.

Layers follow each other. The steps of a shell grow from the ground: next comes the lowest of those
that stand on the ground or touch what stands already. So the rows of an arch rise from both feet
in turn and meet at the crown, those of a wall from its foot, those of a canopy from its support.
A step *stands on the ground* when it reaches down to within a thickness of the lowest point of all.
Beams, which have no faces in common, follow their addresses.

Source: section 4.3 (a unique address for each constructional element), figures 20 and 21.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ifs_cad.design.address import matching, prefixes
from ifs_cad.design.mesh import Mesh
from ifs_cad.elements.element import Elements
from ifs_cad.elements.panel import Shell
from ifs_cad.elements.vault import Vault
from ifs_cad.types import BoolArray, FloatArray, IntArray

HANDFUL = 32
"""Elements in a step that is made by prefix, at most: as many as a page can name legibly."""


@dataclass(frozen=True)
class Step:
    """What is put up together.

    Attributes
    ----------
    number : int, from 1
    name : str, such as "row 3 of 16", "layer L07" or "prefix 02"
    elements : tuple of int, their numbers, in the order in which they are put up
    addresses : tuple of str, of these
    """

    number: int
    name: str
    elements: tuple[int, ...]
    addresses: tuple[str, ...]


def assembly_steps(elements: Elements, only: str | Iterable[str] | None = None) -> tuple[Step, ...]:
    """Return the steps of assembly.

    Parameters
    ----------
    elements : a shell, a vault or a frame
    only : address patterns such as "03*", optional
        A partial prototype: the same steps, less all other elements.

    Returns
    -------
    tuple of Step
        Each element in one step.

    Raises
    ------
    AddressError
        A pattern matches nothing.
    """
    addresses = elements.addresses
    chosen = (
        np.arange(len(addresses)) if only is None else np.flatnonzero(matching(addresses, only))
    )
    groups, names = _groups(elements, chosen)
    present = np.unique(groups).tolist()
    if isinstance(elements, Shell):
        present = _grown(elements, chosen, groups, present)
    steps = []
    for number, group in enumerate(present, start=1):
        members = tuple(chosen[groups == group].tolist())
        own = tuple(addresses[k] for k in members)
        steps.append(Step(number, names[group], members, own))
    return tuple(steps)


def _groups(elements: Elements, chosen: IntArray) -> tuple[IntArray, list[str]]:
    """Return the group of each of the elements chosen, and what all groups are called."""
    if isinstance(elements, Vault):
        digits = max(2, len(str(elements.segments.count - 1)))
        return elements.layer[chosen], [
            f"layer L{layer:0{digits}}" for layer in range(elements.segments.count)
        ]
    courses = _courses(elements)
    if courses is not None:
        what, count, course = courses
        return course[chosen], [f"{what} {place} of {count}" for place in range(1, count + 1)]
    grown = [prefixes(elements.addresses[k]) for k in chosen]
    length = 1
    while True:
        heads, groups, counts = np.unique(
            [each[:length][-1] for each in grown], return_inverse=True, return_counts=True
        )
        if counts.max() <= HANDFUL:
            return groups.ravel(), [f"prefix {head}" for head in heads.tolist()]
        length += 1


def _courses(elements: Elements) -> tuple[str, int, IntArray] | None:
    """Return whether a vector sum goes up by rows, how many, and that of each panel.

    None for what is no vector sum.
    """
    if not isinstance(elements, Shell):
        return None
    mesh = elements.mesh
    whole, vertices = (mesh, np.arange(len(mesh.vertices))) if mesh.origin is None else mesh.origin
    if whole.lattice is None:
        return None
    count, columns = (size - 1 for size in whole.lattice.shape)
    quads = np.sort(whole.corners.reshape(-1, 4), axis=1)
    own = np.sort(vertices[mesh.corners].reshape(-1, 4), axis=1)[elements.faces]
    _, number = np.unique(np.concatenate([quads, own]), axis=0, return_inverse=True)
    number = number.ravel()
    face_of = np.zeros(number.max() + 1, dtype=np.int64)
    face_of[number[: len(quads)]] = np.arange(len(quads))
    row, column = np.divmod(face_of[number[len(quads) :]], columns)
    heights = whole.centroids[:, 2].reshape(count, columns)
    uneven_rows, uneven_columns = (float(np.ptp(heights, axis=axis).mean()) for axis in (1, 0))
    if uneven_rows <= uneven_columns + mesh.tol.planar:
        return "row", count, row
    return "column", columns, column


def _grown(shell: Shell, chosen: IntArray, groups: IntArray, present: list[int]) -> list[int]:
    """Return the groups of a shell in the order in which they grow from the ground."""
    heights, bottoms = _heights(shell, chosen, groups)
    standing = bottoms <= bottoms[present].min() + shell.thickness
    touching = _touching(shell.mesh, shell.faces[chosen], groups)
    waiting = [(heights[k], k) for k in present if standing[k]]
    heapq.heapify(waiting)
    reached = {group for _, group in waiting}
    order: list[int] = []
    while len(order) < len(present):
        if not waiting:  # a part that touches nothing: it hangs, so it comes last
            rest = [(heights[k], k) for k in present if k not in reached]
            waiting = [min(rest)]
            reached.add(waiting[0][1])
        _, group = heapq.heappop(waiting)
        order.append(group)
        for near in np.flatnonzero(touching[group]).tolist():
            if near not in reached:
                reached.add(near)
                heapq.heappush(waiting, (heights[near], near))
    return order


def _heights(shell: Shell, chosen: IntArray, groups: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the mean and the least height of the corners of each group, mm."""
    solids = shell.solids
    group_of = np.full(len(solids), -1)
    group_of[chosen] = groups
    owner = group_of[solids.solid_of_vertex]
    taken = owner >= 0
    owner, z = owner[taken], solids.vertices[taken, 2]
    count = int(groups.max()) + 1
    many = np.maximum(np.bincount(owner, minlength=count), 1)
    mean = np.bincount(owner, z, minlength=count) / many
    lowest = np.full(count, np.inf)
    np.minimum.at(lowest, owner, z)
    # equal rows differ by rounding: what cannot be measured must not decide
    return np.round(mean / shell.tol.planar) * shell.tol.planar, lowest


def _touching(mesh: Mesh, faces: IntArray, groups: IntArray) -> BoolArray:
    """Return the (g, g) bools that tell which groups of faces share an edge."""
    group_of = np.full(len(mesh), -1)
    group_of[faces] = groups
    inner = np.flatnonzero(mesh.twin >= 0)
    one, other = group_of[mesh.face[inner]], group_of[mesh.face[mesh.twin[inner]]]
    both = (one >= 0) & (other >= 0)
    count = int(groups.max()) + 1
    touching = np.zeros((count, count), dtype=bool)
    touching[one[both], other[both]] = True
    return touching
