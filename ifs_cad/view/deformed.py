"""The deformed shell as a picture, coloured by how far it sinks."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

import numpy as np

from ifs_cad.elements.colouring import Colouring
from ifs_cad.files import replaced
from ifs_cad.structure.result import Result
from ifs_cad.types import IntArray
from ifs_cad.view._drawing import drawn
from ifs_cad.view._scene import centred, legend

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


def render_deformed(
    result: Result,
    path: str | os.PathLike[str],
    *,
    scale: float | None = None,
    width: int = 1600,
    height: int = 1000,
    azimuth: float = -60.0,
    elevation: float = 25.0,
) -> None:
    """Write a picture of the deformed shell, coloured by |u_z|, over the lines of its panels.

    Parameters
    ----------
    result : Result
    path : path of a PNG; written beside it and renamed
    scale : float, optional
        How many times larger displacements are drawn; `magnification` by default.
    width, height : int, pixels
    azimuth, elevation : float, degrees, as for `render`

    Raises
    ------
    ViewerError
        Nothing on this machine can draw.
    ExportError
        The file could not be written.
    """
    scale = magnification(result) if scale is None else scale
    scene = _scene(result, scale) | {
        "size": np.array([width, height]),
        "view": np.array([azimuth, elevation, 1.0]),
        "background": np.ones(3),
    }
    picture = drawn(scene)
    with replaced(Path(path)) as scratch:
        scratch.write_bytes(picture)


def _scene(result: Result, scale: float) -> dict[str, Any]:
    grid = result.model.grid
    points = np.concatenate([result.deformed(scale), grid.nodes])
    sunk = np.abs(result.displacements[:, 2])
    triangles = grid.quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    of_triangle = sunk[triangles].mean(axis=1)
    title = f"|u_z|, mm, drawn {scale:g} x"
    colouring = Colouring(title, of_triangle, low=0.0, high=float(sunk.max()) or 1.0)
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


def _none() -> IntArray:
    return np.empty((0, 2), dtype=np.int64)
