"""A model as the arrays that the drawing program reads."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ifs_cad.elements.colouring import Colouring
from ifs_cad.elements.polyhedron import Kind
from ifs_cad.errors import InputError
from ifs_cad.types import FloatArray
from ifs_cad.view._assembly import Group, Part, View, numbered_parts, parts
from ifs_cad.view._triangulate import triangulate

PLYWOOD = (0.87, 0.72, 0.53, 1.0)
INK = (0.2, 0.15, 0.1, 1.0)  # of lines without a colour
EDGE_DARKNESS = 0.35  # an edge is its part's colour times this
DARK, LIGHT = (30, 30, 30), (255, 255, 255)  # letters
LUMINANCE = (0.299, 0.587, 0.114)

Scene = dict[str, NDArray[Any]]


def scene_of(
    view: View, *, edges: bool, labels: bool, fineness: float = 1.0, centre: bool = True
) -> Scene:
    """Return a model as triangles, lines, labels and a legend.

    Parameters
    ----------
    view : View
    edges : bool
        With the edges of faces.
    labels : bool
        With addresses written on the elements.
    fineness : float
        How many times closer than usual it is looked at.
    centre : bool
        Move its middle to the origin, where numbers are finest.

    Raises
    ------
    InputError
        Labels of something that was not made of elements.
    """
    scene = _shapes(parts(view.assembly), edges, fineness)
    if view.legend is not None:
        scene |= legend(view.legend)
    if labels:
        if not view.groups:
            raise InputError(
                "Only panels and planks have addresses to be written on them: give a shell, or "
                "what to_assembly makes of it."
            )
        written = [_labels(group) for group in view.groups]
        scene |= {key: np.concatenate([each[key] for each in written]) for key in written[0]}
    return centred(scene, scene["points"]) if centre else scene


def centred(scene: Scene, about: FloatArray) -> Scene:
    """Return a scene moved so that the middle of some points is the origin."""
    middle = (about.min(axis=0) + about.max(axis=0)) / 2
    moved = {key: scene[key] - middle for key in ("points", "label_points") if key in scene}
    return scene | moved


def legend(colouring: Colouring) -> Scene:
    """Return the arrays of a legend."""
    says = {"legend": colouring.scale, "legend_title": np.array(_broken(colouring.title))}
    if colouring.names:
        return says | {"legend_names": np.array(colouring.names)}
    return says | {"legend_range": np.array(colouring.range)}


def _broken(title: str) -> str:
    """Return a title on two lines, what it is and its unit, for a narrow column."""
    return title.replace(", ", ",\n", 1)


def _shapes(shapes: list[Part], edges: bool, fineness: float) -> Scene:
    meshes = triangulate([shape for shape, _ in shapes], fineness)
    starts = np.cumsum([0] + [len(mesh.points) for mesh in meshes[:-1]])
    triangles = [mesh.triangles + start for mesh, start in zip(meshes, starts, strict=True)]
    drawn = [mesh.lines + start for mesh, start in zip(meshes, starts, strict=True)]
    # lines without faces are all there is to see of a part
    bare = [len(mesh.triangles) == 0 for mesh in meshes]
    lines = [
        part[: 0 if alone or not edges else None] for part, alone in zip(drawn, bare, strict=True)
    ]
    strokes = [part[: None if alone else 0] for part, alone in zip(drawn, bare, strict=True)]
    colors = [color.toTuple() if color else PLYWOOD for _, color in shapes]
    rgba = np.array(colors)
    dark = rgba * (EDGE_DARKNESS, EDGE_DARKNESS, EDGE_DARKNESS, 1.0)
    ink = [color.toTuple() if color else INK for _, color in shapes]
    return {
        "points": np.concatenate([mesh.points for mesh in meshes]),
        "triangles": np.concatenate(triangles),
        "triangle_colors": _bytes(rgba, triangles),
        "lines": np.concatenate(lines),
        "line_colors": _bytes(dark, lines),
        "strokes": np.concatenate(strokes),
        "stroke_colors": _bytes(np.array(ink), strokes),
    }


def _bytes(colors: FloatArray, cells: list[NDArray[Any]]) -> NDArray[np.uint8]:
    """Repeat each part's colour for each of its cells."""
    as_bytes: NDArray[np.uint8] = np.rint(255 * colors).astype(np.uint8)
    return np.repeat(as_bytes, [len(part) for part in cells], axis=0)


def _labels(group: Group) -> Scene:
    """Return the address of each element twice: on its upper and on its lower face."""
    solids = group.elements.solids
    inks = np.full((len(solids), 3), DARK, dtype=np.uint8)
    for number, part in numbered_parts(group):
        if part.color is not None and np.dot(part.color.toTuple()[:3], LUMINANCE) < 0.5:
            inks[number] = LIGHT
    faces = np.flatnonzero(solids.kinds <= Kind.UPPER)
    owner = solids.solid_of_face[faces]
    corners = solids.vertices[solids.loops]
    sizes = np.diff(solids.face_offsets)
    middles = np.add.reduceat(corners, solids.face_offsets[:-1]) / sizes[:, None]
    areas = solids.face_areas[faces]
    longest = np.maximum.reduceat(solids.edge_lengths, solids.face_offsets[:-1])[faces]
    # the first edge of each face that is as long as its longest
    by_length = np.lexsort((-solids.edge_lengths, solids.face_of_loop))
    first = by_length[solids.face_offsets[:-1]][faces]
    along = solids.vertices[solids.heads[first]] - corners[first]
    move = group.place.wrapped.Transformation()
    matrix = np.array([[move.Value(i, j) for j in range(1, 5)] for i in range(1, 4)])
    turn, shift = matrix[:, :3], matrix[:, 3]
    return {
        "labels": np.array(group.elements.addresses)[owner],
        "label_points": (middles[faces] + group.shifts[owner]) @ turn.T + shift,
        "label_normals": solids.normals[faces] @ turn.T,
        "label_axes": along / longest[:, None] @ turn.T,
        "label_sizes": np.stack([longest, areas / longest], axis=1),
        "label_inks": inks[owner],
    }
