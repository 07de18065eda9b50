"""The deformed shell as a picture and for the viewer, coloured by what it answers."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any, Literal, get_args

import cadquery as cq
import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.GeomAPI import GeomAPI_PointsToBSplineSurface
from OCP.gp import gp_Pnt
from OCP.TColgp import TColgp_Array2OfPnt

from ifs_cad.elements.colouring import Colouring
from ifs_cad.errors import InputError
from ifs_cad.files import replaced
from ifs_cad.structure.result import Result
from ifs_cad.types import FloatArray, IntArray
from ifs_cad.view._drawing import drawn
from ifs_cad.view._scene import centred, legend

By = Literal["deflection", "utilisation"]
TITLES: dict[By, str] = {"deflection": "|u_z|, mm", "utilisation": "utilisation"}
SEWN = 1e-3  # mm, within which the kernel takes points of a face for one

SEEN = 0.05  # of the shell's size, up to which the largest displacement is magnified
INK = (60, 60, 60, 255)
FORMER = (170, 170, 170, 255)  # of the lines of the shell without load


def magnification(result: Result) -> float:
    """Return a round factor (1, 2 or 5 times a power of ten) that lets the deformation be seen."""
    moved = result.largest_displacement.value
    if not moved:
        return 1.0
    factor = SEEN * float(np.ptp(result.model.grid.nodes, axis=0).max()) / moved
    power = 10.0 ** math.floor(math.log10(factor))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= factor)


def deformed_assembly(
    result: Result, *, by: By = "deflection", scale: float | None = None
) -> cq.Assembly:
    """Return the deformed shell for the viewer: `ifs.show(ifs.deformed_assembly(result))`.

    Parameters
    ----------
    result : Result
    by : "deflection" or "utilisation"
        What colours the panels, each by its largest value, violet for none to yellow for the
        largest of all; grey where nothing is known.
    scale : float, optional
        How many times larger displacements are drawn; `magnification` by default.

    Returns
    -------
    cq.Assembly
        A curved face for every panel, by its address; the name tells scale and largest value. In
        the metadata of each panel "deflection" (mm) and "utilisation".

    Raises
    ------
    InputError
        Another `by`, or no strength is known to use up.
    """
    of_panels = _values(result, by, result.deflections, result.utilisation)
    scale = magnification(result) if scale is None else scale
    grid, model = result.model.grid, result.model
    points = result.deformed(scale)
    faces: dict[int, list[cq.Face]] = {}
    for lattices in grid.blocks:
        for lattice in lattices:
            face = int(grid.face_of_node[lattice[0, 0]])
            faces.setdefault(face, []).append(_face(points[lattice]))
    high = float(np.nanmax(of_panels)) or 1.0
    colours = Colouring(TITLES[by], of_panels, low=0.0, high=high).colours.tolist()
    whole = cq.Assembly(name=f"deformed {scale:g} x, {TITLES[by]} up to {high:.4g}")
    for face, parts in sorted(faces.items()):
        panel = int(model.surface.panels[face])
        whole.add(
            parts[0] if len(parts) == 1 else cq.Compound.makeCompound(parts),
            name=grid.mesh.addresses[face],
            color=cq.Color(*(part / 255 for part in colours[panel])),
            metadata={
                "deflection": float(result.deflections[panel]),
                "utilisation": float(result.utilisation[panel]),
            },
        )
    return whole


def render_deformed(
    result: Result,
    path: str | os.PathLike[str],
    *,
    by: By = "deflection",
    scale: float | None = None,
    width: int = 1600,
    height: int = 1000,
    azimuth: float = -60.0,
    elevation: float = 25.0,
) -> None:
    """Write a picture of the deformed shell, coloured, over the lines of its panels.

    Parameters
    ----------
    result : Result
    path : path of a PNG; written beside it and renamed
    by : "deflection" or "utilisation", what colours it
    scale : float, optional
        How many times larger displacements are drawn; `magnification` by default.
    width, height : int, pixels
    azimuth, elevation : float, degrees, as for `render`

    Raises
    ------
    InputError
        Another `by`, or no strength is known to use up.
    ViewerError
        Nothing on this machine can draw.
    ExportError
        The file could not be written.
    """
    scale = magnification(result) if scale is None else scale
    scene = _scene(result, by, scale) | {
        "size": np.array([width, height]),
        "view": np.array([azimuth, elevation, 1.0]),
        "background": np.ones(3),
    }
    picture = drawn(scene)
    with replaced(Path(path)) as scratch:
        scratch.write_bytes(picture)


def _scene(result: Result, by: By, scale: float) -> dict[str, Any]:
    grid = result.model.grid
    points = np.concatenate([result.deformed(scale), grid.nodes])
    triangles = grid.quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    sunk = np.abs(result.displacements[:, 2])
    used = np.full(len(grid.quads), np.nan)
    used = used if result.quad_utilisation is None else result.quad_utilisation
    values = _values(result, by, sunk[triangles].mean(axis=1), np.repeat(used, 2))
    high = float((sunk if by == "deflection" else used).max()) or 1.0
    title = f"{TITLES[by]}\n(drawn {scale:g} x)"
    colouring = Colouring(title, values, low=0.0, high=high)
    opaque = np.full(len(triangles), 255, np.uint8)
    edges = np.stack([grid.edges[:, :-1], grid.edges[:, 1:]], axis=-1).reshape(-1, 2)
    scene = {
        "points": points,
        "triangles": triangles,
        "triangle_colors": np.column_stack([colouring.colours, opaque]),
        "lines": np.concatenate([edges, edges + len(grid.nodes)]),
        "line_colors": np.repeat(np.array([INK, FORMER], np.uint8), len(edges), axis=0),
        "strokes": _none(),
        "stroke_colors": np.empty((0, 4), np.uint8),
    }
    return centred(scene | legend(colouring), points)


def _values(result: Result, by: str, sunk: FloatArray, used: FloatArray) -> FloatArray:
    """Return one of two arrays.

    Raises
    ------
    InputError
    """
    if by not in get_args(By):
        raise InputError(f'A shell is coloured by "deflection" or "utilisation", not by {by!r}.')
    if by == "utilisation" and result.quad_utilisation is None:
        raise InputError(
            f"The strength of {result.model.shell.material.name} is not known, so its utilisation "
            'is not either. Give the material one, or colour by "deflection".'
        )
    return sunk if by == "deflection" else used


def _face(points: FloatArray) -> cq.Face:
    """Return a curved face through (k, k, 3) points."""
    table = TColgp_Array2OfPnt(1, len(points), 1, points.shape[1])
    for row, line in enumerate(points.tolist(), start=1):
        for column, point in enumerate(line, start=1):
            table.SetValue(row, column, gp_Pnt(*point))
    fitted = GeomAPI_PointsToBSplineSurface()
    fitted.Interpolate(table)
    return cq.Face(BRepBuilderAPI_MakeFace(fitted.Surface(), SEWN).Face())


def _none() -> IntArray:
    return np.empty((0, 2), dtype=np.int64)
