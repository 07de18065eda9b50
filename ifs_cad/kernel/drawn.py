"""Arrays of points as CadQuery wires, faces and germs: what figures are drawn with."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import cadquery as cq
import numpy as np

from ifs_cad.design.mesh import Mesh
from ifs_cad.errors import InputError
from ifs_cad.types import ArrayLike, FloatArray


def to_wire(points: ArrayLike, *, closed: bool = False) -> cq.Wire:
    """Return a polyline through (n, 2) or (n, 3) points, mm; points in the plane get z = 0."""
    return cq.Wire.makePolygon([cq.Vector(*p) for p in _in_space(points).tolist()], close=closed)


def to_wires(polylines: Iterable[ArrayLike], *, closed: bool = False) -> cq.Compound:
    """Return several polylines as one compound of wires."""
    return cq.Compound.makeCompound([to_wire(points, closed=closed) for points in polylines])


def to_faces(polygons: Iterable[ArrayLike]) -> cq.Compound:
    """Return planar polygons as one compound of faces.

    Raises
    ------
    InputError
        A polygon that OpenCascade cannot fill: not planar, or crossing itself.
    """
    faces = []
    for number, polygon in enumerate(polygons):
        try:
            faces.append(cq.Face.makeFromWires(to_wire(polygon, closed=True)))
        except Exception as error:  # the kernel raises classes of its own
            raise InputError(f"Polygon {number} cannot be filled: {error}.") from error
    return cq.Compound.makeCompound(faces)


def mesh_to_faces(mesh: Mesh) -> cq.Compound:
    """Return the design surface as one compound of planar faces."""
    return to_faces(mesh.vertices[ring] for ring in mesh.polygons())


def to_dots(points: ArrayLike, radius: float) -> cq.Compound:
    """Return small spheres at points: control and subdivision points in a picture."""
    balls: Sequence[cq.Shape] = [
        cq.Solid.makeSphere(radius, cq.Vector(*p), angleDegrees1=-90) for p in _in_space(points)
    ]
    return cq.Compound.makeCompound(balls)


def _in_space(points: ArrayLike) -> FloatArray:
    array = np.asarray(points, dtype=float)
    if array.ndim != 2 or array.shape[1] not in (2, 3) or len(array) == 0:
        raise InputError(f"Points must be (n, 2) or (n, 3), got shape {array.shape}.")
    return np.pad(array, ((0, 0), (0, 3 - array.shape[1])))
