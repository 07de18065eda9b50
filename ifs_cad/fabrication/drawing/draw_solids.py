"""Solids on paper: shaded, outlined, and named where their names fit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from ifs_cad.elements.polyhedron import Polyhedra, ranges
from ifs_cad.fabrication.drawing.axonometry import Camera, faces_seen
from ifs_cad.fabrication.drawing.drafting import CAPITAL
from ifs_cad.fabrication.drawing.page import GREY, Page, Pen, View, text_width
from ifs_cad.fabrication.measure import chord
from ifs_cad.types import BoolArray, FloatArray, IntArray
from ifs_cad.vectors import dot

DISC_TEXT = 2.3  # mm

_LEAST_TEXT, _MOST_TEXT = 1.5, 2.8  # mm
_SHARE_ALONG, _SHARE_UP = 0.85, 0.7  # of a face that text may take
_UPRIGHT = 75.0  # degrees: what leans farther to the right is read from the right
_EDGES = {False: (0.1, "#a0a09c"), True: (0.18, "#5a3208")}  # of what is new: width and colour
_GHOST = Pen(0.25, "#c46a10", dash=(0.9, 0.6))
_LIGHT = np.array([-0.4, 0.5, 0.77])  # as the camera sees it: from the upper left
_SHADES = 8  # few, so that files stay small
_DARKEST = 0.62


class Picture:
    """Solids as a camera sees them, in a part of a page.

    Parameters
    ----------
    page : Page
    solids : Polyhedra, convex and disjoint
    mates : (f,) int, the solid on the other side of each face, -1 if none
    camera : Camera
    box : left, bottom, right and top, mm on the page
    framed : the solids that fill the box, all by default
    """

    def __init__(
        self,
        page: Page,
        solids: Polyhedra,
        mates: IntArray,
        camera: Camera,
        box: tuple[float, float, float, float],
        framed: IntArray | None = None,
    ) -> None:
        self.page, self.solids, self.mates, self.camera = page, solids, mates, camera
        seen = camera(solids.vertices)[:, :2]
        shown = seen if framed is None else seen[np.isin(solids.solid_of_vertex, framed)]
        corner, room = np.array(box[:2]), np.array(box[2:]) - box[:2]
        size = np.ptp(shown, axis=0)
        scale = float((room / size).min())
        x, y = corner + (room - size * scale) / 2 - shown.min(axis=0) * scale
        self.paper = View(scale, float(x), float(y))(seen)
        self.seen = faces_seen(solids, camera)

    def outline(self, face: int) -> FloatArray:
        """(k, 2) float, a face on the paper."""
        solids = self.solids
        return self.paper[solids.loops[slice(*solids.face_offsets[face : face + 2])]]

    @cached_property
    def caps(self) -> IntArray:
        """(n,) int, the face of each solid that is seen largest."""
        solids = self.solids
        areas = dot(solids.area_vectors, self.camera.back)
        order = np.lexsort((areas, solids.solid_of_face))
        return np.asarray(order[solids.solid_offsets[1:] - 1])

    @cached_property
    def spots(self) -> FloatArray:
        """(n, 2) float, the middle of these faces on the paper."""
        solids = self.solids
        starts = solids.face_offsets
        sizes = np.diff(starts)[self.caps]
        points = self.paper[solids.loops[ranges(starts[self.caps], starts[self.caps + 1])]]
        ends = np.cumsum(sizes)
        return np.asarray(np.add.reduceat(points, ends - sizes) / sizes[:, None])

    def paint(
        self,
        order: IntArray,
        shown: BoolArray,
        colours: FloatArray,
        new: IntArray | None = None,
    ) -> None:
        """Draw what is shown of the solids, in this order; `new` ones have darker edges."""
        solids, mates = self.solids, self.mates
        covered = (mates >= 0) & shown[mates]
        drawn = self.seen & shown[solids.solid_of_face] & ~covered
        light = np.clip(solids.normals @ self.camera.axes.T @ _LIGHT, 0.0, 1.0)
        steps = np.round(light * (_SHADES - 1)) / (_SHADES - 1)
        shades = _DARKEST + (1.0 - _DARKEST) * steps
        fills = np.round(255 * colours[solids.solid_of_face] * shades[:, None]).astype(np.int64)
        is_new = np.zeros(len(solids), dtype=bool)
        is_new[new if new is not None else []] = True
        starts = solids.solid_offsets
        faces = ranges(starts[order], starts[order + 1])
        faces = faces[drawn[faces]]
        for face, fill, fresh in zip(
            faces.tolist(),
            fills[faces].tolist(),
            is_new[solids.solid_of_face[faces]].tolist(),
            strict=True,
        ):
            tint = "#{:02x}{:02x}{:02x}".format(*fill)
            width, ink = _EDGES[fresh]
            self.page.line(Pen(width, ink, fill=tint), self.outline(face), closed=True)

    def ghost(self, members: IntArray) -> None:
        """Draw the outlines of some solids over all that may hide them."""
        for face in self.caps[members].tolist():
            self.page.line(_GHOST, self.outline(face), closed=True)

    def write(self, members: IntArray, addresses: Sequence[str]) -> bool:
        """Write addresses on solids, or numbers when too small; tell whether all are addresses."""
        spaces = [
            self._space(solid, address)
            for solid, address in zip(members.tolist(), addresses, strict=True)
        ]
        if min(size for size, _ in spaces) < _LEAST_TEXT:
            for number, solid in enumerate(members.tolist(), start=1):
                number_disc(self.page, self.spots[solid], str(number))
            return False
        for address, (x, y), (room, turn) in zip(
            addresses, self.spots[members].tolist(), spaces, strict=True
        ):
            size, angle = min(_MOST_TEXT, room), math.radians(turn)
            x += size * CAPITAL / 2 * math.sin(angle)
            y -= size * CAPITAL / 2 * math.cos(angle)
            self.page.text(address, x, y, size, anchor="middle", turn=turn)
        return True

    def _space(self, solid: int, text: str) -> tuple[float, float]:
        """Return how large a text fits on the face seen of a solid, mm, and its turn, degrees."""
        outline, spot = self.outline(int(self.caps[solid])), self.spots[solid]
        spans = np.roll(outline, -1, axis=0) - outline
        longest = spans[int((spans**2).sum(axis=1).argmax())]
        found = []
        for way in (np.array([1.0, 0.0]), longest / math.hypot(*longest)):
            across = np.array([-way[1], way[0]])
            along, high = (
                float(np.hypot(*np.diff(chord(outline, spot, line), axis=0)[0]))
                for line in (way, across)
            )
            size = min(_SHARE_ALONG * along / text_width(text, 1.0), _SHARE_UP * high / CAPITAL)
            turn = math.degrees(math.atan2(way[1], way[0]))
            found.append((size, (turn + _UPRIGHT) % 180.0 - _UPRIGHT))
        return max(found)


def number_disc(page: Page, spot: FloatArray, text: str) -> None:
    """Write a number on a white disc."""
    size = DISC_TEXT
    radius = 0.62 * max(size, text_width(text, size))
    page.circles(Pen(0.1, GREY, fill="#ffffff"), spot[None], radius)
    page.text(text, float(spot[0]), float(spot[1]) - size * CAPITAL / 2, size, anchor="middle")
