"""The cutting frame of each panel: how it lies on the machine, and where tools may work.

On the machine a panel lies flat, the marked face up: z up from 0 at the table to the thickness, x
along the text of its label, the lower left corner of its bounding box at the origin. Labels and
holes are placed in this frame, and solids are made in it.

Tools reach below the face (a groove, a drill), while chamfers may undercut it. So the *work face*
is bounded, on each side, by the tighter of two lines: where the side meets the face, and where it
meets the plane at the tool's depth.

Source: section 4.3 (each element oriented to the coordinate system of the machine).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ifs_cad.elements.element import Elements
from ifs_cad.elements.panel import Face
from ifs_cad.elements.polyhedron import Kind, Polyhedra
from ifs_cad.types import BoolArray, FloatArray, IntArray
from ifs_cad.vectors import cross, dot, length, unit

LEAST_SLOPE = 0.1  # sine between a face and the horizontal below which "up" says nothing


@dataclass(frozen=True, eq=False)
class CuttingFrames:
    """The panels of a shell, lying on the machine.

    A point q of the shell lies at axes @ q + offsets on the machine.

    Attributes
    ----------
    axes : (p, 3, 3) float, rows x, y and z as directions in the shell
    offsets : (p, 3) float, mm
    solids : Polyhedra, the panels' shapes on the machine
    thickness : float, mm
    """

    axes: FloatArray
    offsets: FloatArray
    solids: Polyhedra
    thickness: float

    @property
    def origins(self) -> FloatArray:
        """(p, 3) float, where the origins of the frames lie in the shell, mm."""
        return np.asarray(-np.einsum("pji,pj->pi", self.axes, self.offsets))


@dataclass(frozen=True, eq=False)
class WorkFaces:
    """The region of every panel where tools may work: inward . (x, y) >= limits for each side.

    Attributes
    ----------
    inward : (p, k, 2) float, unit normals of the sides, counter-clockwise; the first is repeated
        to fill up
    limits : (p, k) float, mm
    is_side : (p, k) bool, False where filled up
    kinds : (p, k) int, see `Kind`
    """

    inward: FloatArray
    limits: FloatArray
    is_side: BoolArray
    kinds: IntArray

    def take(self, panels: IntArray) -> WorkFaces:
        """Return the work faces of some panels."""
        return WorkFaces(
            self.inward[panels], self.limits[panels], self.is_side[panels], self.kinds[panels]
        )


def cutting_frames(
    elements: Elements, face: Face = "inner", up: tuple[float, float, float] = (0.0, 0.0, 1.0)
) -> CuttingFrames:
    """Lay every panel on the machine.

    Parameters
    ----------
    face : "inner" or "outer"
        Which face lies on top.
    up : (3,) floats
        The direction in the shell that y follows as far as the panel allows; nearly horizontal
        panels follow the y axis of the shell instead.
    """
    solids, thickness = elements.solids, elements.thickness
    z = elements.normals if face == "outer" else -elements.normals
    y = _upright(z, np.array(up, dtype=float))
    if elements.along is not None:
        across = cross(z, elements.along)
        y = np.where(dot(across, y)[:, None] < 0, -across, across)
    axes = np.stack([cross(y, z), y, z], axis=1)
    owner = solids.solid_of_vertex
    turned = np.einsum("vij,vj->vi", axes[owner], solids.vertices)
    offsets = np.full((len(elements), 3), np.inf)
    np.minimum.at(offsets, owner, turned)
    offsets = -offsets
    caps = solids.kinds <= Kind.UPPER
    on_top = solids.kinds == (Kind.UPPER if face == "outer" else Kind.LOWER)
    # heights count from the faces of the sheet: the floor may have taken the lower one
    cap = np.flatnonzero(caps)
    anchor = turned[solids.loops[solids.face_offsets[cap]], 2]
    offsets[solids.solid_of_face[cap], 2] = np.where(on_top[cap], thickness, 0.0) - anchor
    vertices = turned + offsets[owner]
    normals = np.einsum("fij,fj->fi", axes[solids.solid_of_face], solids.normals)

    # the two faces of the sheet are level to the last digit
    normals[caps] = np.where(on_top[caps, None], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0])
    in_cap = caps[solids.face_of_loop]
    height = np.where(on_top[solids.face_of_loop[in_cap]], thickness, 0.0)
    vertices[solids.loops[in_cap], 2] = height
    anchors = vertices[solids.loops[solids.face_offsets[:-1]]]
    laid = replace(solids, vertices=vertices, normals=normals, levels=dot(normals, anchors))
    return CuttingFrames(axes, offsets, laid, thickness)


def work_faces(frames: CuttingFrames, depth: float) -> WorkFaces:
    """Return the work faces of tools that reach `depth` mm below the upper face."""
    solids = frames.solids
    side = np.flatnonzero(solids.kinds > Kind.UPPER)
    owner = solids.solid_of_face[side]
    normals = solids.normals[side]
    scale = length(normals * [1.0, 1.0, 0.0])
    inward = -normals[:, :2] / scale[:, None]
    heights = np.array([[frames.thickness], [frames.thickness - depth]])
    limits = (heights * normals[:, 2] - solids.levels[side]).max(axis=0) / scale

    order = np.lexsort((np.arctan2(inward[:, 1], inward[:, 0]), owner))
    count = np.bincount(owner, minlength=len(solids))
    slot = np.arange(count.max())
    is_side = slot < count[:, None]
    pick = order[(np.cumsum(count) - count)[:, None] + np.where(is_side, slot, 0)]
    return WorkFaces(inward[pick], limits[pick], is_side, solids.kinds[side][pick])


def _upright(z: FloatArray, up: FloatArray) -> FloatArray:
    """Return the unit vectors in the planes with normals z that point up as far as possible."""
    rising = up - dot(z, up)[:, None] * z
    level = length(rising) < LEAST_SLOPE * length(up)
    for other in np.eye(3)[[1, 0]]:
        if level.any():
            instead = other - dot(z, other)[:, None] * z
            rising = np.where(level[:, None], instead, rising)
            level &= length(instead) < LEAST_SLOPE
    return unit(rising)
