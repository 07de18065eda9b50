"""Workpieces: elements as they lie on the machine, and all that is done to them.

A workpiece lies in the cutting frame of its element: the marked face up, z = 0 on the table and
z = thickness on top, x along the text, the lower left corner of its bounding box at the origin.
What is done to it is a neutral list, in the order of the paper: pierce the fixation holes, engrave
the address, cut the contour with the chamfer of each edge. Every file format and every program for
a machine writes these down; none invents a geometry of its own.

Terms
-----
silhouette : the outline of a workpiece seen from above, bottom and top together; convex.
side : one face of the contour, cut by the flank of the cutter.
inclination : the angle of a side to the vertical, degrees, positive when the workpiece is wider at
    its top.

Source: section 4.3, figure 19.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ifs_cad.elements.arcs import Path
from ifs_cad.elements.material import Material
from ifs_cad.types import FloatArray
from ifs_cad.vectors import cross, unit


@dataclass(frozen=True, eq=False)
class Drill:
    """Holes of one diameter, square to the face.

    Attributes
    ----------
    points : (n, 2) float, mm
    diameter : float, mm
    depth : float, mm, below the upper face; the thickness for a through-hole
    """

    points: FloatArray
    diameter: float
    depth: float


@dataclass(frozen=True, eq=False)
class Engraving:
    """Single strokes along which a cutter engraves the address into the upper face.

    Attributes
    ----------
    text : str
    strokes : paths of lines and arcs, mm
    depth : float, mm, below the upper face
    cutter : float, diameter of the cutter, mm; 0 for strokes that are only drawn
    """

    text: str
    strokes: tuple[Path, ...]
    depth: float
    cutter: float


@dataclass(frozen=True, eq=False)
class Side:
    """One planar face of the contour.

    Attributes
    ----------
    corners : (k, 3) float, mm, counter-clockwise seen from outside
    normal : (3,) float, unit vector, outward
    inclination : float, degrees, see the module
    kind : str, "cut", "border", "relief" or "floor", see `elements.polyhedron.Kind`
    neighbour : str, the address on the other side; empty at borders and floors
    """

    corners: FloatArray
    normal: FloatArray
    inclination: float
    kind: str
    neighbour: str

    @property
    def travel(self) -> FloatArray:
        """(3,) float, level unit vector along which the flank runs, the workpiece on its left."""
        return unit(np.array([-self.normal[1], self.normal[0], 0.0]))

    @property
    def axis(self) -> FloatArray:
        """(3,) float, unit vector of the tool: in the side, square to `travel`, pointing up."""
        return cross(self.normal, self.travel)


Operation = Drill | Engraving | Side
"""One thing done to a workpiece."""


@dataclass(frozen=True, eq=False)
class Workpiece:
    """One element on the machine, with its operations in order.

    Attributes
    ----------
    address : str
    thickness : float, mm
    material : Material
    lower, upper : (k, 2), (m, 2) float, outlines at z = 0 and z = thickness, counter-clockwise, mm
    silhouette : (n, 2) float, convex, counter-clockwise, mm
    fibre : (2,) float, unit vector along the grain of the outer plies, or None where it is free
    drills : holes, done first
    engraving : the address, done second; None when it is not marked
    sides : the contour, done last, counter-clockwise seen from above
    axes : (3, 3) float, rows x, y and z of the cutting frame as directions in the design
    origin : (3,) float, where the origin of the cutting frame lies in the design, mm
    volume : float, mm3, of the element less its holes and its pocketed address
    """

    address: str
    thickness: float
    material: Material
    lower: FloatArray
    upper: FloatArray
    silhouette: FloatArray
    fibre: FloatArray | None
    drills: tuple[Drill, ...]
    engraving: Engraving | None
    sides: tuple[Side, ...]
    axes: FloatArray
    origin: FloatArray
    volume: float

    def operations(self) -> Iterator[Operation]:
        """Yield what is done to it, in order: holes, the address, the contour side by side."""
        yield from self.drills
        if self.engraving is not None:
            yield self.engraving
        yield from self.sides
