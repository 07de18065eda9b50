"""The deformed shell as a picture, coloured by how far it sinks."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

import numpy as np

from ifs_cad.files import replaced
from ifs_cad.structure.result import Result
from ifs_cad.types import IntArray
from ifs_cad.view.render import drawn

RAMP = np.array([(68, 1, 84), (59, 82, 139), (33, 145, 140), (94, 201, 98), (253, 231, 37)])
"""Anchors of viridis, which also the colour-blind and printers tell apart."""
SHADES = 64
SEEN = 0.05  # of the shell's size, up to which the largest displacement is magnified
ZOOM = 0.85  # leaves room for the scale of colours
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
    """Write a picture of the deformed shell, coloured by ``|u_z|``, over the lines of its panels.

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
        "view": np.array([azimuth, elevation, ZOOM]),
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
    shades = _shades()
    high = float(sunk.max()) or 1.0
    shade = np.rint(sunk[triangles].mean(axis=1) / high * (SHADES - 1)).astype(int)
    edges = np.stack([grid.edges[:, :-1], grid.edges[:, 1:]], axis=-1).reshape(-1, 2)
    return {
        "points": points - (points.min(axis=0) + points.max(axis=0)) / 2,
        "triangles": triangles,
        "triangle_colors": np.column_stack([shades[shade], np.full(len(shade), 255, np.uint8)]),
        "lines": np.concatenate([edges, edges + len(grid.nodes)]),
        "line_colors": np.repeat(np.array([INK, FORMER], np.uint8), len(edges), axis=0),
        "strokes": _none(),
        "stroke_colors": np.empty((0, 4), np.uint8),
        "legend": shades,
        "legend_range": np.array([0.0, high]),
        "legend_title": np.array(f"|u_z|, mm\n(drawn {scale:g} x)"),
    }


def _shades() -> Any:
    """Return (SHADES, 3) uint8 colours from low to high."""
    at = np.linspace(0, len(RAMP) - 1, SHADES)
    columns = [np.interp(at, np.arange(len(RAMP)), column) for column in RAMP.T]
    return np.rint(np.column_stack(columns)).astype(np.uint8)


def _none() -> IntArray:
    return np.empty((0, 2), dtype=np.int64)
