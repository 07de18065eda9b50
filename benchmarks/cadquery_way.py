"""The peer: the same panels and planks as a CadQuery user makes them, without ifs_cad's kernel.

Extrude the outline of the face, wide enough for chamfers that open outwards; cut off what lies
beyond each chamfer and relief plane with one boolean against a box per plane; cut the address into
the inner face with `text()`. A plank is a bar whose two ends are cut off in the same way.
"""

from __future__ import annotations

import cadquery as cq
import numpy as np

import ifs_cad as ifs
from ifs_cad.elements.polyhedron import Kind, Polyhedra
from ifs_cad.types import BoolArray, FloatArray

TEXT_HEIGHT = 28.0
TEXT_DEPTH = 0.5


def plain_panel(panel: ifs.Panel) -> cq.Workplane:
    """Return a panel without its address."""
    solid, normal = panel.solid, panel.normal
    mesh = panel.shell.mesh
    outline = mesh.positions[panel.half_edges]
    x = outline[1] - outline[0]
    plane = cq.Plane(tuple(outline[0]), tuple(x), tuple(normal))
    points = [plane.toLocalCoords(cq.Vector(*point)).toTuple()[:2] for point in outline]
    size = float(np.ptp(solid.vertices, axis=0).max())
    wide = (
        cq.Workplane(plane)
        .polyline(points)
        .close()
        .offset2D(2 * panel.thickness, "intersection")
        .extrude(panel.thickness)
    )
    return trimmed(wide, solid, solid.kinds > Kind.UPPER, outline[0], size)


def trimmed(
    wide: cq.Workplane, solid: Polyhedra, sides: BoolArray, near: FloatArray, size: float
) -> cq.Workplane:
    """Cut off what lies beyond some sides of a solid, with boxes at their feet from a point."""
    boxes = []
    for outward, level in zip(solid.normals[sides], solid.levels[sides], strict=True):
        foot = near + (level - outward @ near) * outward
        beyond = cq.Plane(tuple(foot), normal=tuple(outward))
        boxes.append(cq.Workplane(beyond).rect(3 * size, 3 * size).extrude(2 * size).val())
    return cq.Workplane(obj=wide.val().cut(*boxes))


def engraved_panel(panel: ifs.Panel) -> cq.Workplane:
    """Return a panel with its address cut into the inner face."""
    normal = panel.normal
    middle = panel.shell.mesh.centroids[panel.face]
    level = (-1.0 if abs(normal[2]) > 0.99 else 0.0, 0.0, 1.0)
    x = np.cross(level, -normal)
    inner = cq.Plane(tuple(middle), tuple(x), tuple(-normal))
    workplane = plain_panel(panel).copyWorkplane(cq.Workplane(inner))
    return workplane.text(panel.address, TEXT_HEIGHT, -TEXT_DEPTH)


def plain_plank(vault: ifs.Vault, index: int) -> cq.Workplane:
    """Return a plank without its address."""
    solid = vault.solids.take(np.array([index]))
    length, middle = float(vault.lengths[index]), lower_middle(vault, index)
    plane = cq.Plane(tuple(middle), tuple(vault.directions[index]), tuple(vault.segments.across))
    bar = cq.Workplane(plane).rect(2 * length, vault.width).extrude(vault.thickness)
    along = np.abs(solid.normals @ vault.directions[index])
    return trimmed(bar, solid, along > vault.tol.parallel, middle, 2 * length)


def engraved_plank(vault: ifs.Vault, index: int) -> cq.Workplane:
    """Return a plank with its address cut into the face of the layer below."""
    middle = lower_middle(vault, index)
    face = cq.Plane(tuple(middle), tuple(vault.directions[index]), tuple(-vault.segments.across))
    workplane = plain_plank(vault, index).copyWorkplane(cq.Workplane(face))
    return workplane.text(vault.addresses[index], TEXT_HEIGHT, -TEXT_DEPTH)


def lower_middle(vault: ifs.Vault, index: int) -> FloatArray:
    """Return the middle of the corners of a plank's lower face, mm."""
    solid = vault.solids.take(np.array([index]))
    low = solid.vertices @ vault.segments.across
    return np.asarray(solid.vertices[low < low.min() + vault.thickness / 2].mean(axis=0))
