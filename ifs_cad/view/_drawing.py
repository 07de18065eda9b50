"""The drawing program's parent: scenes in, PNGs out.

Without a way to draw VTK takes its whole process down, so it draws in one that may die.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ifs_cad.errors import ViewerError
from ifs_cad.view._scene import Scene

# It imports from where we do, wherever it is started: not from its current folder.
START = "import sys; sys.path[:] = {!r}; from ifs_cad.view._draw import main; main()"

NO_BACKEND = (
    "Nothing on this machine can draw. On Debian and Ubuntu install the packages libegl1, "
    "libegl-mesa0 and libgl1-mesa-dri (no screen and no graphics card needed)."
    if sys.platform == "linux"
    else "Drawing failed: OpenGL 3.2 is needed, from the graphics driver of this machine."
)


def drawn(scene: Scene) -> bytes:
    """Return the PNG of a scene, whose arrays are those of ``_draw.py``.

    Raises
    ------
    ViewerError
        Nothing on this machine can draw.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "scene.npz")
        np.savez(file, **scene)  # type: ignore[arg-type]
        [picture] = pictures_of([file])
        return picture.read_bytes()


def pictures_of(files: Sequence[Path]) -> Iterator[Path]:
    """Draw the scenes saved in ``.npz`` files and yield the PNG beside each when it is there.

    Raises
    ------
    ViewerError
        Nothing on this machine can draw.
    """
    environment = dict(os.environ)
    if sys.platform == "linux":
        environment.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    program = [sys.executable, "-c", START.format(sys.path), *map(str, files)]
    with (
        tempfile.TemporaryFile() as complaints,
        subprocess.Popen(
            program, stdout=subprocess.PIPE, stderr=complaints, text=True, env=environment
        ) as process,
    ):
        assert process.stdout is not None
        try:
            made = 0
            waiting = {str(file): file for file in files}
            for line in process.stdout:
                if file := waiting.pop(line.rstrip("\n"), None):
                    made += 1
                    yield file.with_suffix(".png")
        finally:
            process.kill()  # of no effect on one that has ended
        code = process.wait()
        complaints.seek(0)
        said = complaints.read().decode(errors="replace").strip().splitlines()
    if made == len(files):
        return
    if code == 1 and said:  # by Python: the last line says why
        raise ViewerError(f"Drawing failed with {said[-1]}")
    raise ViewerError(f"{NO_BACKEND} (The drawing process ended with {code}.)")
