"""The finite element mesh with all results as VTU, for ParaView and its like.

Every quad carries the address of its panel, so what is seen in a picture can be found in the
workshop. Written by VTK, which CadQuery brings.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from ifs_cad.files import replaced
from ifs_cad.libraries import require
from ifs_cad.structure.result import Result
from ifs_cad.structure.section import RESULTANTS

PURPOSE = "writing VTU"


def export_vtu(result: Result, path: str | os.PathLike[str]) -> Path:
    """Write the answer of a structure check as an unstructured grid of VTK.

    Points carry `displacement` (mm), `rotation` (radians) and `load` (N); quads the mean stress
    resultants of `section.RESULTANTS` (N/mm, N mm/mm), `utilisation` where strengths are known,
    and `panel` and `address`.

    Parameters
    ----------
    result : Result
    path : path of the file; its folder is made when missing

    Returns
    -------
    Path of the written file.

    Raises
    ------
    ExportError
        The file could not be written; what stood there before is unchanged.
    """
    target = Path(path)
    core = require("vtkmodules.vtkCommonCore", PURPOSE)
    held = require("vtkmodules.vtkCommonDataModel", PURPOSE)
    files = require("vtkmodules.vtkIOXML", PURPOSE)
    as_array = require("vtkmodules.util.numpy_support", PURPOSE).numpy_to_vtk
    as_numbers = require("vtkmodules.util.numpy_support", PURPOSE).numpy_to_vtkIdTypeArray

    model, grid = result.model, result.model.grid
    points, cells, mesh = core.vtkPoints(), held.vtkCellArray(), held.vtkUnstructuredGrid()
    points.SetData(as_array(grid.nodes, deep=True))
    starts = 4 * np.arange(len(grid.quads) + 1)
    cells.SetData(as_numbers(starts, deep=True), as_numbers(grid.quads.ravel(), deep=True))
    mesh.SetPoints(points)
    mesh.SetCells(held.VTK_QUAD, cells)

    def add(to: Any, name: str, values: Any) -> None:
        array = as_array(np.ascontiguousarray(values), deep=True)
        array.SetName(name)
        to.AddArray(array)

    at_points, at_quads = mesh.GetPointData(), mesh.GetCellData()
    add(at_points, "displacement", result.displacements)
    add(at_points, "rotation", result.rotations)
    add(at_points, "load", result.forces)
    for name, values in zip(RESULTANTS, result.resultants.T, strict=True):
        add(at_quads, name, values)
    if result.quad_utilisation is not None:
        add(at_quads, "utilisation", result.quad_utilisation)
    add(at_quads, "panel", model.surface.panels[grid.face_of_quad])
    addresses = core.vtkStringArray()
    addresses.SetName("address")
    for face in grid.face_of_quad.tolist():
        addresses.InsertNextValue(grid.mesh.addresses[face])
    at_quads.AddArray(addresses)

    with replaced(target) as scratch:
        writer = files.vtkXMLUnstructuredGridWriter()
        writer.SetFileName(str(scratch))
        writer.SetInputData(mesh)
        writer.SetDataModeToBinary()
        writer.SetCompressorTypeToNone()  # so that simple readers can read it
        writer.Write()
    return target
