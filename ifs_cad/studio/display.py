"""What a page draws of panels: triangles, edges and the strokes of labels, in flat arrays."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np

from ifs_cad.elements.arcs import Segments
from ifs_cad.elements.cutting import CuttingFrames
from ifs_cad.elements.glyph import bar, descent, glyph, text_positions, traced
from ifs_cad.elements.label import LabelPlaces
from ifs_cad.elements.polyhedron import Polyhedra
from ifs_cad.types import FloatArray, IntArray

MOST_FACES = 256 * 256
"""More faces than this the studio does not draw; `ifs-cad build` may still make them."""

ARC_PARTS = 8
"""Straight pieces that an arc of a label is drawn with."""

__all__ = ["MOST_FACES", "PanelView", "label_lines", "panel_view"]


@dataclass(frozen=True, eq=False)
class PanelView:
    """Panels as triangles.

    Attributes
    ----------
    vertices : (v, 3) float, mm; panels never share any
    triangles : (t, 3) int, counter-clockwise seen from outside
    panel_of_triangle : (t,) int
    edges : (e, 2) int, vertices of each edge of a panel
    """

    vertices: FloatArray
    triangles: IntArray
    panel_of_triangle: IntArray
    edges: IntArray


def panel_view(solids: Polyhedra) -> PanelView:
    """Return solids as triangles, each face as a fan about its first vertex."""
    first = np.repeat(solids.face_offsets[:-1], np.diff(solids.face_offsets))
    place = np.arange(len(solids.loops))
    last = np.repeat(solids.face_offsets[1:] - 1, np.diff(solids.face_offsets))
    spoke = (place != first) & (place != last)
    corners = [solids.loops[first], solids.loops, solids.heads]
    once = solids.loops < solids.heads
    return PanelView(
        solids.vertices,
        np.stack(corners, axis=1)[spoke],
        solids.solid_of_face[solids.face_of_loop[spoke]],
        np.stack([solids.loops, solids.heads], axis=1)[once],
    )


def label_lines(frames: CuttingFrames, places: LabelPlaces) -> tuple[FloatArray, FloatArray]:
    """Return the strokes of all labels as short straight lines in the shell.

    Parameters
    ----------
    frames : CuttingFrames
    places : LabelPlaces
        The labels placed in them.

    Returns
    -------
    lines : (n, 2, 3) float, mm
    normals : (n, 3) float, outward unit vectors of the faces that the lines are on
    """
    owners: dict[str, list[int]] = {}
    shifts: dict[str, list[float]] = {}
    drawn: list[FloatArray] = []
    numbers: list[IntArray] = []
    for number, text in enumerate(places.texts):
        positions, _ = _layout(text)
        for character, x in zip(text, positions, strict=True):
            owners.setdefault(character, []).append(number)
            shifts.setdefault(character, []).append(x)
    drawn.append(np.stack([_layout(text)[1] for text in places.texts]))
    numbers.append(np.arange(len(places.texts)))
    for character, panels in owners.items():
        lines = _lines(character)
        moved = lines + np.array(shifts[character])[:, None, None, None] * (1.0, 0.0)
        drawn.append(moved.reshape(-1, 2, 2))
        numbers.append(np.repeat(panels, len(lines)))
    panel = np.concatenate(numbers)
    flat = np.concatenate(drawn) * places.heights[panel, None, None]
    flat += places.origins[panel, None]
    height = np.full((*flat.shape[:2], 1), frames.thickness)
    laid = np.concatenate([flat, height], axis=2)
    offsets = frames.offsets[panel, None]
    axes = frames.axes[panel]
    return np.asarray(np.einsum("nji,nkj->nki", axes, laid - offsets)), axes[:, 2]


@lru_cache(MOST_FACES)
def _layout(text: str) -> tuple[list[float], FloatArray]:
    """Return where the characters of a text begin, and the (2, 2) ends of its bar."""
    positions, width = text_positions(text)
    return positions.tolist(), bar(width, descent(text)).vertices


@cache
def _lines(character: str) -> FloatArray:
    """Return (n, 2, 2) float: a character as straight lines, cap height 1."""
    paths = traced(glyph(character).paths)
    if not paths:
        return np.empty((0, 2, 2))
    segments = Segments.of(paths)
    parts = np.where(segments.is_line, 1, ARC_PARTS)
    which = np.repeat(np.arange(len(segments)), parts)
    step = np.arange(len(which)) - np.repeat(np.cumsum(parts) - parts, parts)
    each = segments[which]
    ends = [each.at((step + more) / parts[which]) for more in (0, 1)]
    return np.stack([np.stack([end.real, end.imag], axis=1) for end in ends], axis=1)
