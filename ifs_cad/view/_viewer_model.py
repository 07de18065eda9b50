"""Panels and planks as the OCP viewer draws them, straight from their arrays.

The viewer's client asks the kernel for every triangle of every engraved digit: a minute for the
prototype. A preview needs flat faces, and the addresses and holes as lines: some milliseconds. What
is made here follows the format of three-cad-viewer, version 3, which all OCP viewers draw.
"""

from __future__ import annotations

import base64
from collections.abc import Iterable, Iterator
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ifs_cad.elements.arcs import Path, Segments
from ifs_cad.elements.colouring import Colouring
from ifs_cad.elements.cutting import CuttingFrames, cutting_frames
from ifs_cad.elements.glyph import CHARACTERS, bar, descent, text_paths, traced
from ifs_cad.elements.label import place_labels
from ifs_cad.elements.polyhedron import Polyhedra
from ifs_cad.kernel.assembly import STROKES_SUFFIX, modified_parts
from ifs_cad.types import FloatArray
from ifs_cad.view._assembly import Group

Node = dict[str, Any]

NOWHERE = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))  # a place: shift, and turn as a quaternion
MARKS = "#5c4326"
MARK_WIDTH = 1
ARC_PARTS = 6
CIRCLE_PARTS = 8  # a prototype has a thousand holes, and software draws lines slowly
KNOWN_TEXTS = 4096  # addresses stay the same from one save of a script to the next
SWATCH = 0.03  # height of a field of the legend, share of the model's size


def is_plain(group: Group) -> bool:
    """Whether an assembly holds what `to_assembly` made, and nothing else."""
    if modified_parts(group.assembly):
        return False
    addresses = set(group.elements.addresses)
    return all(
        name.removesuffix(STROKES_SUFFIX) in addresses
        for name, part in group.assembly.objects.items()
        if part.obj is not None
    )


def tree(group: Group, path: str, place: Any, instances: list[Node]) -> Node:
    """Return an assembly as a node of the viewer's tree.

    Parameters
    ----------
    group : Group
    path : str
        Of the node in the tree.
    place : (shift, quaternion)
    instances : list
        Geometries so far; those of the panels are appended.
    """
    solids = group.elements.solids
    moved = solids.vertices + group.shifts[solids.solid_of_vertex]
    refs = {}
    for number, made in enumerate(_instances(solids, moved)):
        refs[group.elements.addresses[number]] = len(instances)
        instances.append(made)
    node = _node(group.assembly, path, refs)
    node["loc"] = place
    node["parts"] += list(_marks(group, path))
    if group.colouring is not None:
        node["parts"].append(_legend(group.colouring, path, moved, instances))
    return node


def graft(shapes: Node, group: Group, stand_in: str, instances: list[Node]) -> bool:
    """Put a group in the place of the part that stands in for it; return whether it was found.

    Parameters
    ----------
    shapes : dict
        The tree that the client made; changed.
    group : Group
    stand_in : str
        The name of the part.
    instances : list
        Geometries so far; those of the panels are appended.
    """
    for number, part in enumerate(shapes["parts"]):
        if "parts" in part:
            if part["name"] == stand_in:
                path = f"{shapes['id']}/{str(group.assembly.name).rpartition('/')[2]}"
                shapes["parts"][number] = tree(group, path, part["loc"], instances)
                return True
            if graft(part, group, stand_in, instances):
                return True
        elif part["name"] == stand_in:  # it was all that there is
            shapes["parts"] = tree(group, shapes["id"], NOWHERE, instances)["parts"]
            return True
    return False


def _node(assembly: Any, path: str, refs: dict[str, int]) -> Node:
    parts = []
    for child in assembly.children:
        name = str(child.name)
        if name in refs:
            parts.append(_leaf(name, f"{path}/{name}", refs[name], child.color))
        elif child.children:
            parts.append(_node(child, f"{path}/{name}", refs))
    return _branch(path, parts)


def _branch(path: str, parts: list[Node]) -> Node:
    name = path.rpartition("/")[2]
    return {"version": 3, "id": path, "name": name, "loc": NOWHERE, "parts": parts}


def _leaf(name: str, path: str, ref: int, color: Any) -> Node:
    *rgb, alpha = (0.87, 0.72, 0.53, 1.0) if color is None else color.toTuple()
    return {
        "id": path,
        "name": name,
        "type": "shapes",
        "subtype": "solid",
        "shape": {"ref": ref},
        "state": [1, 1],
        "color": "#" + "".join(f"{round(255 * part):02x}" for part in rgb),
        "alpha": alpha,
        "texture": None,
        "loc": NOWHERE,
        "renderback": False,
        "accuracy": None,
        "bb": None,
    }


def _instances(solids: Polyhedra, vertices: FloatArray) -> Iterator[Node]:
    """Yield the geometry of each solid; faces share no points, so that they are shaded flat."""
    corners = vertices[solids.loops]
    normals = solids.normals[solids.face_of_loop]
    first = solids.face_offsets[:-1][solids.face_of_loop]
    last = solids.face_offsets[1:][solids.face_of_loop] - 1
    here = np.arange(len(solids.loops))
    spoke = (here != first) & (here != last)
    fans = np.stack([first, here, here + 1], axis=1)[spoke]
    once = solids.loops < solids.heads
    edges = np.stack([corners, vertices[solids.heads]], axis=1)[once]
    owner = solids.solid_of_face[solids.face_of_loop]
    corner_ends = np.searchsorted(owner, np.arange(len(solids) + 1))
    fan_ends = np.searchsorted(owner[spoke], np.arange(len(solids) + 1))
    edge_ends = np.searchsorted(owner[once], np.arange(len(solids) + 1))
    sizes = np.diff(solids.face_offsets) - 2
    for k, start in enumerate(corner_ends[:-1].tolist()):
        stop = corner_ends[k + 1]
        faces = slice(solids.solid_offsets[k], solids.solid_offsets[k + 1])
        lines = edges[edge_ends[k] : edge_ends[k + 1]]
        yield _instance(
            corners[start:stop],
            normals[start:stop],
            fans[fan_ends[k] : fan_ends[k + 1]] - start,
            lines,
            sizes[faces],
        )


def _instance(
    points: FloatArray, normals: FloatArray, triangles: Any, edges: FloatArray, sizes: Any
) -> Node:
    return {
        "vertices": _packed(points, np.float32),
        "normals": _packed(normals, np.float32),
        "triangles": _packed(triangles, np.int32),
        "triangles_per_face": _packed(sizes, np.int32),
        "face_types": _packed(np.zeros(len(sizes)), np.int32),
        "obj_vertices": _packed(np.empty(0), np.float32),
        **_edges(edges),
    }


def _edges(edges: FloatArray) -> Node:
    """Return (n, 2, 3) lines, each an edge of its own."""
    return {
        "edges": _packed(edges, np.float32),
        "edge_types": _packed(np.zeros(len(edges)), np.int32),
        "segments_per_edge": _packed(np.ones(len(edges)), np.int32),
    }


def _packed(values: Any, kind: Any) -> Node:
    flat = np.ascontiguousarray(values, dtype=kind).ravel()
    return {
        "shape": flat.shape,
        "dtype": str(flat.dtype),
        "buffer": base64.b64encode(flat.tobytes()).decode(),
        "codec": "b64",
    }


def _marks(group: Group, path: str) -> Iterator[Node]:
    """Yield the addresses, and the holes, of all elements as lines on their marked faces."""
    elements, data = group.elements, group.assembly.metadata
    label, holes = data.get("label"), data.get("holes")
    if label is None and holes is None:
        return
    frames = (
        cutting_frames(elements)
        if label is None
        else cutting_frames(elements, label.face, label.up)
    )
    placed = None if holes is None else holes.place(elements, frames)
    if label is not None:
        places = place_labels(elements.addresses, frames, label, placed, elements.tol)
        strokes = [
            height * _text_lines(text)
            for text, height in zip(places.texts, places.heights.tolist(), strict=True)
        ]
        flat = np.concatenate(strokes) + places.origins[_owners(strokes), None]
        yield _lines("addresses", path, _laid(group, frames, flat, _owners(strokes)))
    if placed is not None:
        owners, _ = np.nonzero(placed.present)
        turns = np.exp(2j * np.pi * np.arange(CIRCLE_PARTS + 1) / CIRCLE_PARTS)
        ring = placed.diameter / 2 * np.stack([turns.real, turns.imag], axis=1)
        circle = np.stack([ring[:-1], ring[1:]], axis=1)
        rings = placed.points[placed.present][:, None, None] + circle
        flat, owners = rings.reshape(-1, 2, 2), np.repeat(owners, CIRCLE_PARTS)
        yield _lines("holes", path, _laid(group, frames, flat, owners))


def _owners(strokes: list[FloatArray]) -> NDArray[np.int64]:
    return np.repeat(np.arange(len(strokes)), [len(lines) for lines in strokes])


@lru_cache(KNOWN_TEXTS)
def _text_lines(text: str) -> FloatArray:
    """Return (n, 2, 2) float: a text and its bar as straight lines, cap height 1."""
    paths, width = text_paths(text)
    return _straight((*paths, bar(width, descent(text))))


def _straight(paths: Iterable[Path]) -> FloatArray:
    """Return (n, 2, 2) float: strokes as straight lines."""
    segments = Segments.of(traced(tuple(paths)))
    parts = np.where(segments.is_line, 1, ARC_PARTS)
    which = np.repeat(np.arange(len(segments)), parts)
    step = np.arange(len(which)) - np.repeat(np.cumsum(parts) - parts, parts)
    each = segments[which]
    ends = [each.at((step + more) / parts[which]) for more in (0, 1)]
    return np.stack([np.stack([end.real, end.imag], axis=1) for end in ends], axis=1)


def _laid(group: Group, frames: CuttingFrames, flat: FloatArray, owners: Any) -> FloatArray:
    """Return lines on the marked faces where they are in the exploded shell, (n, 2, 3)."""
    height = np.full((*flat.shape[:2], 1), frames.thickness)
    laid = np.concatenate([flat, height], axis=2) - frames.offsets[owners, None]
    turned = np.einsum("nji,nkj->nki", frames.axes[owners], laid)
    return np.asarray(turned + group.shifts[owners, None])


def _lines(name: str, path: str, lines: FloatArray) -> Node:
    return {
        "id": f"{path}/{name}",
        "name": name,
        "type": "edges",
        "shape": _edges(lines) | {"obj_vertices": _packed(np.empty(0), np.float32)},
        "state": [3, 1],
        "color": MARKS,
        "width": MARK_WIDTH,
        "loc": None,
    }


def _legend(colouring: Colouring, path: str, points: FloatArray, instances: list[Node]) -> Node:
    """Return a column of coloured fields with their values, right of the model as first seen.

    The first view is from the side of +x and -y: the corner of most x and most y is on the right.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    side = SWATCH * float(np.linalg.norm(high - low))
    here = f"{path}/{colouring.title.replace('/', ' per ')}"
    ticks = colouring.ticks()
    front, right, up = (side * axis for axis in np.eye(3))
    corner = np.array([high[0] + side, high[1] + side, low[2]])
    fields, written = [], []
    for number, (text, colour) in enumerate(ticks):
        made = _box(corner, side)
        leaf = _leaf(text, f"{here}/{number} {text}", len(instances), None)
        leaf["color"] = "#" + "".join(f"{part:02x}" for part in colour)
        instances.append(made)
        fields.append(leaf)
        written.append(_upright(text, corner + front + 1.4 * right + 0.2 * up, 0.6 * side))
        corner = corner + 1.2 * up
    written.append(_upright(colouring.title, corner + front + 0.9 * up, 0.6 * side))
    return _branch(here, [*fields, _lines("values", here, np.concatenate(written))])


def _upright(text: str, corner: FloatArray, height: float) -> FloatArray:
    """Return (n, 2, 3) float: a text along y, standing along z, as far as there are strokes."""
    known = "".join(letter for letter in text if letter in CHARACTERS).strip()
    if not known:
        return np.empty((0, 2, 3))
    flat = height * _straight(text_paths(known)[0])
    return np.asarray(corner + np.concatenate([np.zeros((*flat.shape[:2], 1)), flat], axis=-1))


def _box(corner: FloatArray, side: float) -> Node:
    """Return a cube."""
    grid = np.indices((2, 2, 2)).reshape(3, -1).T
    quads, normals = [], []
    for axis in range(3):
        for end in (0, 1):
            face = grid[grid[:, axis] == end][[0, 1, 3, 2]]
            outward = np.eye(3)[axis] * (2 * end - 1)
            area = np.cross(face[1] - face[0], face[2] - face[0])
            quads.append(face if area @ outward > 0 else face[::-1])
            normals += [outward] * 4
    points = corner + side * np.concatenate(quads)
    halves = np.array([(0, 1, 2), (0, 2, 3)])
    triangles = 4 * np.arange(6)[:, None, None] + halves
    rims = points.reshape(6, 4, 3)
    edges = np.stack([rims, np.roll(rims, -1, axis=1)], axis=2).reshape(-1, 2, 3)
    return _instance(points, np.array(normals), triangles, edges, np.full(6, 2))
