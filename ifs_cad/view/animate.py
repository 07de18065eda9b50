"""Moving pictures: a series of models as a GIF or an MP4, from one camera.

The camera sees all the frames, so it stands still while the model changes.
"""

from __future__ import annotations

import math
import os
import tempfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from ifs_cad import progress
from ifs_cad.elements.colouring import Colouring
from ifs_cad.elements.explosion import Explode
from ifs_cad.errors import ExportError, InputError
from ifs_cad.files import replaced
from ifs_cad.libraries import require
from ifs_cad.types import FloatArray
from ifs_cad.view._assembly import MATERIAL, view_of
from ifs_cad.view._drawing import pictures_of
from ifs_cad.view._look import Look
from ifs_cad.view._scene import Scene, scene_of

GIF_COLOURS = 128
HOLD = 8  # frames for which the first and the last one stand still, when there are many
MANY = 10
FEWEST = 2
MOST = 1000


def animate(
    things: Iterable[Any],
    path: str | os.PathLike[str],
    *,
    seconds: float = 4.0,
    there_and_back: bool = False,
    width: int = 800,
    height: int = 500,
    azimuth: float = -60.0,
    elevation: float = 25.0,
    zoom: float = 1.0,
    background: str = "white",
    edges: bool = True,
    labels: bool = False,
    colour: str | Colouring = MATERIAL,
    explode: Explode = 0.0,
) -> None:
    """Write a series of models as a moving picture.

    Parameters
    ----------
    things : iterable
        What `render` draws, one for each frame; made one after the other, so a generator may
        report what it does or raise.
    path : path
        Target, ending in ``.gif`` (repeats for ever) or ``.mp4``. An error leaves what was there.
    seconds : float
        How long it runs once.
    there_and_back : bool
        Run back to the first frame after the last.
    width, height : int, pixels
        16 to 4000; even ones for MP4.
    azimuth, elevation, zoom, background, edges, labels, colour, explode : as for `render`
        A quantity is scaled anew in each frame; give a Colouring with ends of its own to compare.

    Raises
    ------
    InputError
        Fewer than two frames, or a number that cannot be meant.
    MissingLibraryError
        The library that writes the format is not installed: ``pip install 'ifs-cad[animation]'``.
    ViewerError
        Nothing on this machine can draw.
    ExportError
        The file could not be written.
    """
    target = Path(path)
    write = _writer(target)
    if not (math.isfinite(seconds) and seconds > 0):
        raise InputError(f"An animation runs for more than 0 seconds, got {seconds}.")
    look = Look(width, height, azimuth, elevation, zoom, background, edges, labels)
    if target.suffix.lower() == ".mp4" and (width % 2 or height % 2):
        raise InputError(f"An MP4 has even width and height, got {width} x {height}.")
    with tempfile.TemporaryDirectory() as folder:
        scenes = _saved(things, Path(folder), look, colour, explode)
        pictures = []
        for picture in pictures_of(scenes):
            pictures.append(picture)
            progress.report("drawing frames", len(pictures), len(scenes))
        order = list(range(len(pictures)))
        if there_and_back:
            order += order[-2:0:-1]
        if len(pictures) >= MANY:
            order = _held(order, len(pictures) - 1)
        with replaced(target) as scratch:
            write(pictures, order, seconds, scratch)


Writer = Callable[[Sequence[Path], Sequence[int], float, Path], None]


def _writer(target: Path) -> Writer:
    """Return what writes the format; its library is asked for before anything is drawn."""
    writers = {".gif": (_write_gif, "PIL.Image"), ".mp4": (_write_mp4, "av")}
    if target.suffix.lower() not in writers:
        raise InputError(f"An animation is a .gif or an .mp4, got {target.name!r}.")
    write, library = writers[target.suffix.lower()]
    require(library, "animations", extra="animation")
    return write


def _saved(
    things: Iterable[Any], folder: Path, look: Look, colour: str | Colouring, explode: Explode
) -> list[Path]:
    """Save a scene for each frame, all in one place and with one camera."""
    files: list[Path] = []
    hulls = []
    for number, thing in enumerate(things):
        if number == MOST:
            raise InputError(f"An animation has at most {MOST} frames.")
        view = view_of(thing, colour, explode)
        scene = scene_of(
            view, edges=look.edges, labels=look.labels, fineness=max(1.0, look.zoom), centre=False
        )
        files.append(folder / f"{number:04}.npz")
        _save(files[-1], scene)
        hulls.append(_hull(scene["points"]))
    if len(files) < FEWEST:
        raise InputError(f"An animation has {FEWEST} frames or more, got {len(files)}.")
    frame = _hull(np.concatenate(hulls))
    middle = (frame.min(axis=0) + frame.max(axis=0)) / 2
    common = {"frame": frame - middle, "floor": np.array(frame[:, 2].min() - middle[2])}
    for file in files:
        with np.load(file) as arrays:
            scene = dict(arrays)
        for key in ("points", "label_points"):
            if key in scene:
                scene[key] = scene[key] - middle
        _save(file, scene | common | look.camera())
    return files


def _save(file: Path, scene: Scene) -> None:
    try:
        np.savez(file, **scene)  # type: ignore[arg-type]
    except OSError as error:
        raise ExportError(f"No room for the frames: {file}: {error.strerror}.") from error


def _hull(points: FloatArray) -> FloatArray:
    """Return the points that decide what a camera must see."""
    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except QhullError:  # flat, or fewer points than a body has
        low, high = points.min(axis=0), points.max(axis=0)
        return np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)


def _held(order: list[int], last: int) -> list[int]:
    """Let the first and the last frame stand still for a while."""
    held: list[int] = []
    for number in order:
        held += [number] * (HOLD if number in (0, last) else 1)
    return held


def _write_gif(
    pictures: Sequence[Path], order: Sequence[int], seconds: float, target: Path
) -> None:
    image = require("PIL.Image", "animations", extra="animation")
    frames = []
    for picture in pictures:
        with image.open(picture) as opened:
            frames.append(opened.convert("RGB"))
    # one table of colours for all frames: with one each, still parts would flicker
    sample = image.new("RGB", (frames[0].width, 3 * frames[0].height))
    for row, number in enumerate((0, len(frames) // 2, len(frames) - 1)):
        sample.paste(frames[number], (0, row * frames[0].height))
    table = sample.quantize(GIF_COLOURS)
    reduced = [frame.quantize(palette=table, dither=image.Dither.NONE) for frame in frames]
    # a GIF counts hundredths of a second, and browsers slow down what is shorter than two
    pause = max(20, round(1000 * seconds / len(order) / 10) * 10)
    runs = _runs(order)
    reduced[runs[0][0]].save(
        target,
        format="GIF",
        save_all=True,
        append_images=[reduced[number] for number, _ in runs[1:]],
        duration=[pause * length for _, length in runs],
        loop=0,
        optimize=True,
    )


def _runs(order: Sequence[int]) -> list[tuple[int, int]]:
    """Return each frame with how often it follows itself."""
    runs: list[tuple[int, int]] = []
    for number in order:
        if runs and runs[-1][0] == number:
            runs[-1] = (number, runs[-1][1] + 1)
        else:
            runs.append((number, 1))
    return runs


def _write_mp4(
    pictures: Sequence[Path], order: Sequence[int], seconds: float, target: Path
) -> None:
    av = require("av", "MP4 animations", extra="animation")
    image = require("PIL.Image", "animations", extra="animation")
    rate = max(1, round(len(order) / seconds))
    with av.open(str(target), "w", format="mp4") as film:
        stream = film.add_stream("libx264", rate=rate)
        stream.pix_fmt = "yuv420p"  # the one that every player knows
        stream.options = {"crf": "20"}
        with image.open(pictures[0]) as first:
            stream.width, stream.height = first.size
        for number in order:
            with image.open(pictures[number]) as opened:
                frame = av.VideoFrame.from_image(opened.convert("RGB"))
            film.mux(stream.encode(frame))
        film.mux(stream.encode())
