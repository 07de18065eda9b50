"""Pictures without a screen: a model becomes a PNG.

The faces are triangulated here and drawn by ``_draw.py`` in a process of its own. On Linux that
uses EGL, which needs neither a screen nor a graphics card; elsewhere the system's own window,
never shown. The camera stands far off with a long lens, z is up, the model fills the frame.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from ifs_cad.elements.colouring import Colouring
from ifs_cad.elements.explosion import Explode
from ifs_cad.errors import InputError
from ifs_cad.files import replaced
from ifs_cad.view._assembly import MATERIAL, view_of
from ifs_cad.view._drawing import drawn
from ifs_cad.view._look import Look
from ifs_cad.view._scene import scene_of


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
    labels: bool = False,
    colour: str | Colouring = MATERIAL,
    explode: Explode = 0.0,
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
    labels : bool
        Write its address on each panel or plank that is seen, as large as it fits.
    colour : str or Colouring
        "material", or a quantity of `colouring` ("area", "chamfer", "sheet", "utilisation" ...),
        or any values of one's own; with a legend at the right.
    explode : float or sequence of float
        How far sub-assemblies move apart, see `explosion`.

    Raises
    ------
    InputError
        A thing that cannot be looked at, or a number or colour that cannot be meant; colours,
        labels or an exploded view of what is no shell, vault or frame.
    ViewerError
        Nothing on this machine can draw; the message names the packages to install.
    ExportError
        The file could not be written.
    """
    target = Path(path)
    if target.suffix.lower() != ".png":
        raise InputError(f"A picture is a PNG: the name must end in .png, got {target.name!r}.")
    look = Look(width, height, azimuth, elevation, zoom, background, edges, labels)
    view = view_of(thing, colour, explode)
    scene = scene_of(view, edges=edges, labels=labels, fineness=max(1.0, zoom)) | look.camera()
    picture = drawn(scene)
    with replaced(target) as scratch:
        scratch.write_bytes(picture)
