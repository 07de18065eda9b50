"""What a boundary representation says of itself, asked of OpenCascade directly."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.BRepTools import BRepTools
from OCP.GeomAbs import GeomAbs_Cylinder, GeomAbs_Plane
from OCP.GProp import GProp_GProps
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_REVERSED, TopAbs_VERTEX
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopoDS import TopoDS
from OCP.TopTools import TopTools_IndexedDataMapOfShapeListOfShape

from ifs_cad.types import FloatArray


def each(shape: Any, kind: Any) -> list[Any]:
    """Return all parts of a kind; shared ones once for each owner."""
    explorer, found = TopExp_Explorer(shape, kind), []
    while explorer.More():
        found.append(explorer.Current())
        explorer.Next()
    return found


def volume(shape: Any) -> float:
    """Return the volume by the kernel's integration over the surface, mm3."""
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties)
    return float(properties.Mass())


def points(shape: Any) -> FloatArray:
    """Return the (v, 3) places of all vertices, one row for each use."""
    found = [BRep_Tool.Pnt_s(TopoDS.Vertex_s(v)) for v in each(shape, TopAbs_VERTEX)]
    return np.array([(p.X(), p.Y(), p.Z()) for p in found])


def planes(shape: Any) -> list[tuple[FloatArray, float, FloatArray]]:
    """Return outward normal, level and vertices of the outer wire of every plane face."""
    found = []
    for part in each(shape, TopAbs_FACE):
        face = TopoDS.Face_s(part)
        surface = BRepAdaptor_Surface(face)
        if surface.GetType() != GeomAbs_Plane:
            continue
        plane = surface.Plane()
        axis, place = plane.Axis().Direction(), plane.Location()
        normal = np.array([axis.X(), axis.Y(), axis.Z()])
        if not plane.Direct():
            normal = -normal
        if face.Orientation() == TopAbs_REVERSED:
            normal = -normal
        level = float(normal @ [place.X(), place.Y(), place.Z()])
        found.append((normal, level, points(BRepTools.OuterWire_s(face))))
    return found


def cylinders(shape: Any) -> list[tuple[float, FloatArray, FloatArray, FloatArray]]:
    """Return radius, axis point, axis direction and vertices of every cylinder face."""
    found = []
    for part in each(shape, TopAbs_FACE):
        surface = BRepAdaptor_Surface(TopoDS.Face_s(part))
        if surface.GetType() != GeomAbs_Cylinder:
            continue
        cylinder = surface.Cylinder()
        place, axis = cylinder.Location(), cylinder.Axis().Direction()
        found.append(
            (
                float(cylinder.Radius()),
                np.array([place.X(), place.Y(), place.Z()]),
                np.array([axis.X(), axis.Y(), axis.Z()]),
                points(part),
            )
        )
    return found


def assert_solid(shape: Any, expected: float) -> None:
    """Check that a solid is valid, closed, outward-oriented, of planar faces, and of a volume."""
    assert BRepCheck_Analyzer(shape).IsValid()
    owners = TopTools_IndexedDataMapOfShapeListOfShape()
    TopExp.MapShapesAndAncestors_s(shape, TopAbs_EDGE, TopAbs_FACE, owners)
    for k in range(1, owners.Extent() + 1):
        seam = BRepTools.IsReallyClosed_s if owners.FindFromIndex(k).Extent() == 1 else None
        if seam is not None:  # the seam of a bore: both its sides lie in the one wall
            wall = TopoDS.Face_s(owners.FindFromIndex(k).First())
            assert seam(TopoDS.Edge_s(owners.FindKey(k)), wall)
        else:
            assert owners.FindFromIndex(k).Extent() == 2
    senses: dict[int, list[Any]] = {}
    for edge in each(shape, TopAbs_EDGE):
        senses.setdefault(owners.FindIndex(edge), []).append(edge.Orientation())
    assert all(len(both) == 2 and both[0] != both[1] for both in senses.values())
    for normal, level, corners in planes(shape):
        np.testing.assert_allclose(corners @ normal, level, rtol=0, atol=1e-6)
    assert volume(shape) == pytest.approx(expected, rel=1e-9)
