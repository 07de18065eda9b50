"""Pictures without a screen: a model becomes a PNG.

The faces are triangulated here and drawn by ``_draw.py`` in a process of its own. On Linux that
uses EGL, which needs neither a screen nor a graphics card; elsewhere the system's own window,
never shown. The camera stands far off with a long lens, z is up, the model fills the frame.
"""

from __future__ import annotations

import io
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import cadquery as cq
import numpy as np
from numpy.typing import NDArray

from ifs_cad.errors import InputError, ViewerError
from ifs_cad.files import replaced
from ifs_cad.view._assembly import Part, parts, viewable
from ifs_cad.view._triangulate import triangulate

PLYWOOD = (0.87, 0.72, 0.53, 1.0)
INK = (0.2, 0.15, 0.1, 1.0)  # of lines without a colour
EDGE_DARKNESS = 0.35  # an edge is its part's colour times this
LARGEST = 4000  # pixels: drawn at twice that, it still fits drivers and memory

NO_BACKEND = (
    "Nothing on this machine can draw. On Debian and Ubuntu install the packages libegl1, "
    "libegl-mesa0 and libgl1-mesa-dri (no screen and no graphics card needed)."
    if sys.platform == "linux"
    else "Drawing failed: OpenGL 3.2 is needed, from the graphics driver of this machine."
)


def render(
    thing: Any,
    path: str | os.PathLike[str],
    *,
    width: int = 1600,
    height: int = 1000,
    azimuth: float = -60.0,
    elevation: float = 25.0,
    zoom: float = 1.0,
    background: str = "white",
    edges: bool = True,
) -> None:
    """Write a picture of a model as a PNG file.

    Parameters
    ----------
    thing : cadquery.Assembly, cadquery.Workplane, cadquery.Shape, Shell, Vault or WireFrame
        Parts keep their colours; a part without one is drawn as plywood.
    path : path
        Target, ending in ``.png``. Written beside it and renamed: an error leaves what was there.
    width, height : int, pixels
        16 to 4000.
    azimuth, elevation : float, degrees
        Where the camera stands: about z from the x axis, and above the horizon.
    zoom : float
        1 lets the model and the shadow under it fill the frame; more crops them.
    background : str
        A colour's name or ``#rrggbb``.
    edges : bool
        Draw the edges of the faces.

    Raises
    ------
    InputError
        A thing that cannot be looked at, or a number or colour that cannot be meant.
    ViewerError
        Nothing on this machine can draw; the message names the packages to install.
    ExportError
        The file could not be written.
    """
    target = Path(path)
    paper = _checked(target, width, height, (azimuth, elevation, zoom), background)
    scene = _scene(parts(viewable(thing)), edges)
    scene |= {
        "size": np.array([width, height]),
        "view": np.array([azimuth, elevation, zoom], dtype=float),
        "background": np.array(paper),
    }
    picture = drawn(scene)
    with replaced(target) as scratch:
        scratch.write_bytes(picture)


def _checked(
    target: Path, width: int, height: int, view: tuple[float, float, float], background: str
) -> tuple[float, ...]:
    """Check what was asked for and return the background as RGB."""
    if target.suffix.lower() != ".png":
        raise InputError(f"A picture is a PNG: the name must end in .png, got {target.name!r}.")
    if not all(isinstance(n, int) and 16 <= n <= LARGEST for n in (width, height)):
        raise InputError(
            f"Width and height must be whole pixels from 16 to {LARGEST}, got {width} x {height}."
        )
    if not all(math.isfinite(n) for n in view) or view[2] <= 0:
        raise InputError(
            "Azimuth and elevation must be finite and zoom positive, "
            f"got {view[0]}, {view[1]} and {view[2]}."
        )
    try:
        return tuple(cq.Color(background).toTuple()[:3])
    except (ValueError, TypeError) as error:
        raise InputError(
            f"Unknown background colour {background!r}: give a name, or #rrggbb."
        ) from error


def _scene(shapes: list[Part], edges: bool) -> dict[str, NDArray[Any]]:
    """Triangulate parts into the arrays that ``_draw.py`` reads."""
    meshes = triangulate([shape for shape, _ in shapes])
    starts = np.cumsum([0] + [len(mesh.points) for mesh in meshes[:-1]])
    triangles = [mesh.triangles + start for mesh, start in zip(meshes, starts, strict=True)]
    drawn = [mesh.lines + start for mesh, start in zip(meshes, starts, strict=True)]
    # lines without faces are all there is to see of a part
    bare = [len(mesh.triangles) == 0 for mesh in meshes]
    lines = [
        part[: 0 if alone or not edges else None] for part, alone in zip(drawn, bare, strict=True)
    ]
    strokes = [part[: None if alone else 0] for part, alone in zip(drawn, bare, strict=True)]
    colors = [color.toTuple() if color else PLYWOOD for _, color in shapes]
    rgba = np.array(colors)
    dark = rgba * (EDGE_DARKNESS, EDGE_DARKNESS, EDGE_DARKNESS, 1.0)
    ink = [color.toTuple() if color else INK for _, color in shapes]
    points = np.concatenate([mesh.points for mesh in meshes])
    return {
        "points": points - (points.min(axis=0) + points.max(axis=0)) / 2,
        "triangles": np.concatenate(triangles),
        "triangle_colors": _bytes(rgba, triangles),
        "lines": np.concatenate(lines),
        "line_colors": _bytes(dark, lines),
        "strokes": np.concatenate(strokes),
        "stroke_colors": _bytes(np.array(ink), strokes),
    }


def _bytes(colors: NDArray[Any], cells: list[NDArray[Any]]) -> NDArray[np.uint8]:
    """Repeat each part's colour for each of its cells."""
    as_bytes: NDArray[np.uint8] = np.rint(255 * colors).astype(np.uint8)
    return np.repeat(as_bytes, [len(part) for part in cells], axis=0)


def drawn(scene: dict[str, NDArray[Any]]) -> bytes:
    """Return the PNG of a scene by ``_draw.py``, whose arrays it must hold.

    A process of its own: without a way to draw VTK takes its whole process down.

    Raises
    ------
    ViewerError
    """
    packed = io.BytesIO()
    np.savez(packed, **scene)  # type: ignore[arg-type]
    environment = dict(os.environ)
    if sys.platform == "linux":
        environment.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    program = Path(__file__).with_name("_draw.py")
    done = subprocess.run(
        [sys.executable, "-P", str(program)],
        input=packed.getvalue(),
        capture_output=True,
        env=environment,
        check=False,
    )
    if done.returncode == 1:  # by Python: the last line says why
        reason = done.stderr.decode(errors="replace").strip().splitlines()[-1]
        raise ViewerError(f"Drawing failed with {reason}")
    if not done.stdout.startswith(b"\x89PNG"):
        raise ViewerError(f"{NO_BACKEND} (The drawing process ended with {done.returncode}.)")
    return done.stdout
