"""The peer: the same panels as a CadQuery user makes them, without ifs_cad's kernel room.

Extrude the outline of the face, wide enough for chamfers that open outwards; cut off what lies
beyond each chamfer and relief plane with one boolean against a box per plane; cut the address into
the inner face with `text()`.
"""

from __future__ import annotations

import cadquery as cq
import numpy as np

import ifs_cad as ifs
from ifs_cad.elements.polyhedron import Kind

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
    sides = solid.kinds > Kind.UPPER
    boxes = []
    for outward, level in zip(solid.normals[sides], solid.levels[sides], strict=True):
        foot = outline[0] + (level - outward @ outline[0]) * outward
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
