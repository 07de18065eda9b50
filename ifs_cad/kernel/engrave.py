"""Engraved pockets as exact B-rep, built once and set into any number of faces.

A pocket hangs below the plane z = 0: a vertical wall under every line and arc of the groove's
outline, a floor, and a face on top of every island. Nothing closes it at the top: its rim becomes
an inner wire of the face that is engraved, made of the same edges as the walls, so no boolean is
needed. Shapes are shared between all panels that carry the character; only their location differs.

Terms
-----
rim : the wire, at z = 0, of an outer loop of the outline.
island : what stays standing inside a groove; its top is a face of the panel of its own.

Conventions: the panel lies below z = 0, its face there looks along +z. Everything is oriented so
that the face with the rims as inner wires and the pocket's faces together bound the material.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from OCP.BRep import BRep_Builder
from OCP.Geom import Geom_Circle, Geom_Curve, Geom_CylindricalSurface, Geom_Line, Geom_Plane
from OCP.Geom2d import Geom2d_Line
from OCP.gp import gp_Ax2, gp_Ax3, gp_Dir, gp_Dir2d, gp_Pnt, gp_Pnt2d, gp_Trsf, gp_Vec
from OCP.TopAbs import TopAbs_FORWARD, TopAbs_REVERSED
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import (
    TopoDS_Compound,
    TopoDS_Edge,
    TopoDS_Face,
    TopoDS_Shape,
    TopoDS_Vertex,
    TopoDS_Wire,
)

from ifs_cad.elements import glyph
from ifs_cad.elements.arcs import Path, area, winding
from ifs_cad.elements.groove import Groove, check_cutter, groove, outline
from ifs_cad.errors import InputError
from ifs_cad.tolerance import KERNEL

__all__ = ["Pocket", "bar", "engraved", "engraved_text", "moved", "pocket", "wire_strokes"]

_BUILDER = BRep_Builder()
_HERE = TopLoc_Location()
_UP = gp_Dir(0, 0, 1)
_DOWN = gp_Dir(0, 0, -1)

_Segment = tuple[list[float], list[float], float, list[float]]
"""Start, end, sweep and centre."""


@dataclass(frozen=True, eq=False)
class Pocket:
    """The faces of a pocket and the rims they leave in the engraved face.

    Attributes
    ----------
    rims : tuple of TopoDS_Wire
        Inner wires, ready to be added to the (forward) face that is engraved.
    faces : tuple of TopoDS_Face
        Walls, floors and tops of islands, to be added to the panel's shell.
    volume : float
        What is cut away, mm3, in closed form.
    """

    rims: tuple[TopoDS_Wire, ...]
    faces: tuple[TopoDS_Face, ...]
    volume: float

    @property
    def face_count(self) -> int:
        """How many faces the pocket adds to a panel."""
        return len(self.faces)


@lru_cache(maxsize=4096)
def pocket(character: str, height: float, cutter: float, depth: float) -> Pocket:
    """Return the pocket of one character, its baseline on the x axis, its strokes from x = 0.

    Parameters
    ----------
    character : str
        One character of the alphabet; a space gives a pocket without faces.
    height, cutter, depth : float
        Cap height, cutter diameter and depth of the pocket, mm.

    Raises
    ------
    LabelError
        The character is not in the alphabet, or too low for the cutter.
    InputError
        A length that is not positive.
    """
    return _sunk(groove(character, height, cutter), depth)


@lru_cache(maxsize=4096)
def bar(width: float, height: float, cutter: float, depth: float, descent: float = 0.0) -> Pocket:
    """Return the pocket of the bar under a text whose strokes start at x = 0.

    Parameters
    ----------
    width, height : float
        Width and cap height of the text, mm.
    cutter, depth : float
        Cutter diameter and depth of the pocket, mm.
    descent : float
        How far the text reaches below its baseline, mm.

    Raises
    ------
    LabelError
        The text is too low for the cutter.
    InputError
        A length that is not positive.
    """
    check_cutter(height, cutter)
    return engraved([glyph.bar(width / height, descent / height).scaled(height)], cutter, depth)


def engraved(strokes: Sequence[Path], cutter: float, depth: float) -> Pocket:
    """Return the pocket that a cutter leaves along any strokes, mm.

    Raises
    ------
    LabelError
        Grooves that just touch each other.
    InputError
        No strokes, or a length that is not positive.
    """
    return _sunk(outline(strokes, cutter / 2), depth)


def engraved_text(
    text: str, height: float, cutter: float, depth: float, location: TopLoc_Location
) -> tuple[Pocket, ...]:
    """Return the pockets of a text and of the bar under it, in place.

    Parameters
    ----------
    text : str
    height, cutter, depth : float
        Cap height, cutter diameter and depth of the pockets, mm.
    location : TopLoc_Location
        Takes the left end of the baseline from the origin, the direction of reading from x and
        the normal of the engraved face from z.

    Raises
    ------
    LabelError
        A character is not in the alphabet, or too low for the cutter.
    InputError
        A length that is not positive.
    """
    positions, width = glyph.text_positions(text)
    frame = location.Transformation()
    placed = []
    for character, x in zip(text, positions.tolist(), strict=True):
        shift = gp_Trsf()
        shift.SetTranslation(gp_Vec(x * height, 0, 0))
        here = TopLoc_Location(frame.Multiplied(shift))
        placed.append(moved(pocket(character, height, cutter, depth), here))
    below = bar(width * height, height, cutter, depth, glyph.descent(text) * height)
    return (*placed, moved(below, location))


def moved(pocket: Pocket, location: TopLoc_Location) -> Pocket:
    """Return the pocket at a place; its rims and walls still share their edges."""
    return Pocket(
        tuple(rim.Moved(location) for rim in pocket.rims),
        tuple(face.Moved(location) for face in pocket.faces),
        pocket.volume,
    )


def wire_strokes(paths: Sequence[Path]) -> TopoDS_Compound:
    """Return strokes as edges at z = 0, for CAM that engraves along a line; a dot is a vertex."""
    compound = TopoDS_Compound()
    _BUILDER.MakeCompound(compound)
    for path in paths:
        vertices = _vertices(path, 0.0)
        strokes = _edges(_segments(path), vertices, 0.0)
        for shape in strokes or vertices:
            _BUILDER.Add(compound, shape)
    return compound


def _sunk(groove: Groove, depth: float) -> Pocket:
    """Return the pocket of a given depth below an outline."""
    if not 0 < depth < float("inf"):
        raise InputError(f"The depth of an engraving must be positive, got {depth} mm.")
    faces: list[TopoDS_Face] = []
    rims: list[tuple[Path, TopoDS_Wire]] = []
    tops: list[tuple[Path, TopoDS_Face]] = []
    for region in groove.regions:
        floor = _level_face(-depth)
        faces.append(floor)
        for loop in region.loops:
            rim, foot, walls = _walls(loop, depth)
            faces += walls
            _BUILDER.Add(floor, foot)
            if loop is region.outer:
                rims.append((loop, rim))
            else:
                top = _level_face(0.0)
                _BUILDER.Add(top, rim)
                tops.append((loop, top))
    # A rim lies in the smallest island that stands around it, else in the engraved face.
    tops.sort(key=lambda island: abs(area(island[0])))
    outermost = []
    for loop, rim in rims:
        around = (top for island, top in tops if winding(island, loop.vertices[:1])[0])
        home = next(around, None)
        if home is None:
            outermost.append(rim)
        else:
            _BUILDER.Add(home, rim)
    faces += [top for _, top in tops]
    return Pocket(tuple(outermost), tuple(faces), groove.area * depth)


def _walls(loop: Path, depth: float) -> tuple[TopoDS_Wire, TopoDS_Wire, list[TopoDS_Face]]:
    """Return the reversed loop at z = 0, the loop at z = -depth and the walls between them."""
    above, below = _vertices(loop, 0.0), _vertices(loop, -depth)
    segments = _segments(loop)
    upper, lower = _edges(segments, above, 0.0), _edges(segments, below, -depth)
    upright = []
    for foot, head, (x, y) in zip(below, above, loop.vertices.tolist(), strict=True):
        upright.append(_edge(Geom_Line(gp_Pnt(x, y, -depth), _UP), foot, head, depth))
    faces = []
    for k, (start, end, sweep, centre) in enumerate(segments):
        first, last = upright[k], upright[(k + 1) % len(upright)]
        face = TopoDS_Face()
        if sweep == 0.0:
            into_groove = gp_Dir(start[1] - end[1], end[0] - start[0], 0)
            _BUILDER.MakeFace(face, Geom_Plane(gp_Pnt(*start, 0), into_groove), KERNEL)
        else:
            # The cylinder's angle runs counter-clockwise from 0 on either kind of arc.
            turn = abs(sweep)
            origin = start if sweep > 0 else end
            spoke = gp_Dir(origin[0] - centre[0], origin[1] - centre[1], 0)
            radius = float(np.hypot(start[0] - centre[0], start[1] - centre[1]))
            surface = Geom_CylindricalSurface(gp_Ax3(gp_Pnt(*centre, 0), _UP, spoke), radius)
            _BUILDER.MakeFace(face, surface, KERNEL)
            at_first, at_last, along = (0.0, turn, 1) if sweep > 0 else (turn, 0.0, -1)
            for edge, u, v, du, dv in (
                (upper[k], at_first, 0.0, along, 0),
                (lower[k], at_first, -depth, along, 0),
                (first, at_first, -depth, 0, 1),
                (last, at_last, -depth, 0, 1),
            ):
                image = Geom2d_Line(gp_Pnt2d(u, v), gp_Dir2d(du, dv))
                _BUILDER.UpdateEdge(edge, image, surface, _HERE, KERNEL)
            if sweep > 0:  # the groove, not the wood, is on the side of the axis
                face.Reverse()
        _BUILDER.Add(face, _wire([first, upper[k], last.Reversed(), lower[k].Reversed()]))
        faces.append(face)
    return _wire([edge.Reversed() for edge in reversed(upper)]), _wire(lower), faces


def _segments(path: Path) -> list[_Segment]:
    columns = (path.starts, path.ends, path.sweeps, path.centres)
    return list(zip(*(column.tolist() for column in columns), strict=True))


def _level_face(z: float) -> TopoDS_Face:
    face = TopoDS_Face()
    _BUILDER.MakeFace(face, Geom_Plane(gp_Pnt(0, 0, z), _UP), KERNEL)
    return face


def _vertices(path: Path, z: float) -> list[TopoDS_Vertex]:
    vertices = []
    for x, y in path.vertices.tolist():
        vertex = TopoDS_Vertex()
        _BUILDER.MakeVertex(vertex, gp_Pnt(x, y, z), KERNEL)
        vertices.append(vertex)
    return vertices


def _edges(
    segments: Sequence[_Segment], vertices: Sequence[TopoDS_Vertex], z: float
) -> list[TopoDS_Edge]:
    """Return segments as edges at a height, each from its start to its end."""
    edges = []
    for k, (start, end, sweep, centre) in enumerate(segments):
        if sweep == 0.0:
            chord = gp_Vec(end[0] - start[0], end[1] - start[1], 0)
            curve: Geom_Curve = Geom_Line(gp_Pnt(*start, z), gp_Dir(chord))
            length = chord.Magnitude()
        else:
            spoke = gp_Vec(start[0] - centre[0], start[1] - centre[1], 0)
            axes = gp_Ax2(gp_Pnt(*centre, z), _UP if sweep > 0 else _DOWN, gp_Dir(spoke))
            curve = Geom_Circle(axes, spoke.Magnitude())
            length = abs(sweep)
        edges.append(_edge(curve, vertices[k], vertices[(k + 1) % len(vertices)], length))
    return edges


def _edge(
    curve: Geom_Curve, start: TopoDS_Vertex, end: TopoDS_Vertex, length: float
) -> TopoDS_Edge:
    """Return the edge on a curve from its parameter 0 to `length`."""
    edge = TopoDS_Edge()
    _BUILDER.MakeEdge(edge, curve, KERNEL)
    _BUILDER.Add(edge, start.Oriented(TopAbs_FORWARD))
    _BUILDER.Add(edge, end.Oriented(TopAbs_REVERSED))
    _BUILDER.Range(edge, 0.0, length)
    return edge


def _wire(edges: Sequence[TopoDS_Shape]) -> TopoDS_Wire:
    wire = TopoDS_Wire()
    _BUILDER.MakeWire(wire)
    for edge in edges:
        _BUILDER.Add(wire, edge)
    wire.Closed(True)
    return wire
