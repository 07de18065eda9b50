"""From elements to workpieces: everything that is done to each, in its cutting frame.

Frames, holes and addresses are placed by the same rules that the solids are made with, so that
what is cut is what was drawn.

Source: section 4.3, figure 19.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.elements.cutting import CuttingFrames, cutting_frames
from ifs_cad.elements.element import Elements
from ifs_cad.elements.glyph import bar, descent, text_paths, text_positions
from ifs_cad.elements.groove import groove, outline
from ifs_cad.elements.hole import HolePattern, HolePlaces
from ifs_cad.elements.label import Label, LabelPlaces, place_labels
from ifs_cad.elements.polyhedron import Kind, Polyhedra
from ifs_cad.errors import FloorError
from ifs_cad.fabrication.workpiece import Drill, Engraving, Side, Workpiece
from ifs_cad.tolerance import Tolerance
from ifs_cad.types import FloatArray, frozen
from ifs_cad.vectors import length, unit

__all__ = ["workpieces"]


def workpieces(
    elements: Elements, *, label: Label | None = None, holes: HolePattern | None = None
) -> tuple[Workpiece, ...]:
    """Lay every element on the machine and say what is done to it.

    Parameters
    ----------
    elements : Shell, Vault, WireFrame or any other elements cut from sheets or boards
    label : Label, optional
        How the address is marked, and which face lies on top; the inner one without a label.
    holes : Holes or any other pattern of through-holes, optional

    Raises
    ------
    LabelError, HoleError
        A label or hole that does not fit.
    FloorError
        Elements that the floor cuts parallel to their sheet; names them.
    """
    frames = (
        cutting_frames(elements)
        if label is None
        else cutting_frames(elements, label.face, label.up)
    )
    names, tol = elements.addresses, elements.tol
    solids, thickness = frames.solids, frames.thickness
    points = frozen(solids.vertices[solids.loops])
    sides = _sides(elements, solids, points)
    hole_places = None if holes is None else holes.place(elements, frames)
    label_places = None if label is None else place_labels(names, frames, label, hole_places, tol)

    marks_outer = label is not None and label.face == "outer"
    bottom, top = (Kind.LOWER, Kind.UPPER) if marks_outer else (Kind.UPPER, Kind.LOWER)
    lowers = [seen_from_below[::-1] for seen_from_below in _outlines(solids, points, bottom)]
    uppers = _outlines(solids, points, top)
    fibres = _fibres(elements, frames)
    axes, origins = frozen(frames.axes), frozen(frames.origins)
    starts = solids.face_offsets[solids.solid_offsets].tolist()
    pieces = []
    for k, volume in enumerate(solids.volumes.tolist()):
        drills = _drills(hole_places, k, thickness)
        engraving, pocket = _engraving(label_places, k)
        bored = math.fsum(len(drill.points) * _bore(drill) for drill in drills)
        pieces.append(
            Workpiece(
                address=names[k],
                thickness=thickness,
                material=elements.material,
                lower=lowers[k],
                upper=uppers[k],
                silhouette=_hull(points[starts[k] : starts[k + 1], :2], tol),
                fibre=None if fibres is None else fibres[k],
                drills=drills,
                engraving=engraving,
                sides=sides[k],
                axes=axes[k],
                origin=origins[k],
                volume=volume - bored - pocket,
            )
        )
    return tuple(pieces)


def _outlines(solids: Polyhedra, points: FloatArray, cap: Kind) -> list[FloatArray]:
    """Return the (k, 2) outline of one face of each sheet; what the floor took whole is empty.

    Parameters
    ----------
    points : (h, 3) float, the points of the loops of all faces, mm
    """
    outlines = [points[:0, :2]] * len(solids)
    faces = np.flatnonzero(solids.kinds == cap)
    for owner, start, stop in zip(
        solids.solid_of_face[faces].tolist(),
        solids.face_offsets[faces].tolist(),
        solids.face_offsets[faces + 1].tolist(),
        strict=True,
    ):
        outlines[owner] = points[start:stop, :2]
    return outlines


def _fibres(elements: Elements, frames: CuttingFrames) -> FloatArray | None:
    """Return the (p, 2) unit vectors along the grain on the machine."""
    if elements.fibres is None:
        return None
    turned = np.einsum("pij,pj->pi", frames.axes, elements.fibres)
    return frozen(unit(turned[:, :2]))


def _sides(elements: Elements, solids: Polyhedra, points: FloatArray) -> list[tuple[Side, ...]]:
    """Return the contour of each element, from its lower left on."""
    side = np.flatnonzero(solids.kinds > Kind.UPPER)
    normals = solids.normals[side]
    level = length(normals[:, :2])
    flat = level <= elements.tol.parallel
    if flat.any():
        owners = np.unique(solids.solid_of_face[side[flat]])
        found = [elements.addresses[k] for k in owners.tolist()]
        raise FloorError(
            f"The floor cuts {listed(found)} parallel to the sheet, which no cutter does along an "
            "edge. Raise or lower the floor, or tilt it.",
            addresses=found,
        )
    inclinations = np.degrees(np.arctan2(0.0 - normals[:, 2], level))  # never -0.0
    # sides that look straight left or down are common: none of them may be where the turn begins
    azimuth = np.mod(np.arctan2(normals[:, 1], normals[:, 0]) + 3 / 4 * np.pi, 2 * np.pi)
    order = np.lexsort((inclinations, azimuth, solids.solid_of_face[side]))
    side, normals = side[order], frozen(normals[order])
    contours: list[list[Side]] = [[] for _ in range(len(solids))]
    names = elements.mate_addresses
    for owner, start, stop, normal, inclination, kind, mate in zip(
        solids.solid_of_face[side].tolist(),
        solids.face_offsets[side].tolist(),
        solids.face_offsets[side + 1].tolist(),
        normals,
        inclinations[order].tolist(),
        solids.kinds[side].tolist(),
        solids.mates[side].tolist(),
        strict=True,
    ):
        neighbour = names[mate] if mate >= 0 else ""
        kind_name = Kind(kind).name.lower()
        contours[owner].append(Side(points[start:stop], normal, inclination, kind_name, neighbour))
    return [tuple(contour) for contour in contours]


def _drills(places: HolePlaces | None, index: int, thickness: float) -> tuple[Drill, ...]:
    """Return the holes of one element."""
    if places is None or not places.present[index].any():
        return ()
    points = frozen(places.points[index][places.present[index]])
    return (Drill(points, places.diameter, thickness),)


def _bore(drill: Drill) -> float:
    """Return the volume of one hole, mm3."""
    return math.pi * (drill.diameter / 2) ** 2 * drill.depth


def _engraving(places: LabelPlaces | None, index: int) -> tuple[Engraving | None, float]:
    """Return the address of one element, and the volume of its pockets, mm3."""
    if places is None:
        return None, 0.0
    label, text = places.label, places.texts[index]
    height, origin = float(places.heights[index]), places.origins[index]
    if label.style == "wire":
        drawn = tuple(path.moved(origin) for path in places.strokes(index))
        return Engraving(text, drawn, 0.0, 0.0), 0.0
    # a cutter makes a dot by plunging: unlike in drawn strokes it stays one vertex
    paths, width = text_paths(text)
    strokes = tuple(
        path.scaled(height).moved(origin) for path in (*paths, bar(width, descent(text)))
    )
    pocket = label.depth * _groove_area(text, height, label.cutter)
    return Engraving(text, strokes, label.depth, label.cutter), pocket


def _groove_area(text: str, height: float, cutter: float) -> float:
    """Return the area that a cutter takes along a text and its bar, mm2."""
    characters = math.fsum(_character_area(character, height, cutter) for character in text)
    return characters + _bar_area(text_positions(text)[1], descent(text), height, cutter)


@lru_cache(maxsize=4096)
def _character_area(character: str, height: float, cutter: float) -> float:
    return groove(character, height, cutter).area


@lru_cache(maxsize=4096)
def _bar_area(width: float, below: float, height: float, cutter: float) -> float:
    return outline([bar(width, below).scaled(height)], cutter / 2).area


def _hull(points: FloatArray, tol: Tolerance) -> FloatArray:
    """Return the convex hull of (n, 2) points, counter-clockwise, without points on its edges.

    By Andrew's monotone chains; a point closer than `tol.planar` to its neighbours' chord is on it.
    """
    ordered = sorted({(x, y) for x, y in points.tolist()})
    ring: list[tuple[float, float]] = []
    for way in (ordered, ordered[::-1]):
        chain: list[tuple[float, float]] = []
        for point in way:
            while len(chain) > 1 and _turn(chain[-2], chain[-1], point) <= 0.0:
                chain.pop()
            chain.append(point)
        ring += chain[:-1]
    place = 0
    while place < len(ring):
        before, here, after = ring[place - 1], ring[place], ring[(place + 1) % len(ring)]
        if _turn(before, here, after) <= tol.planar * math.dist(before, after):
            del ring[place]
        else:
            place += 1
    return frozen(np.array(ring))


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    """Return twice the area of the triangle a, b, c, positive counter-clockwise."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
