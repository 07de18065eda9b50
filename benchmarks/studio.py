"""From a moved control point to what the studio sends to its page: surface alone, and everything.

Run it: ``python benchmarks/studio.py``. It goes the way that the page goes: the session is edited
as by a mouse, the recomputer evaluates and the scene is encoded; only the browser is missing.
Labels and holes are on 16 x 16 panels only: on 64 x 64 they have no room.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from itertools import count
from typing import Any

from timing import interleaved

from ifs_cad.elements.hole import Holes
from ifs_cad.elements.label import Label
from ifs_cad.studio.run import opened

ROUGH = "figure_18_thickened_surface"
EXACT = "figure_21_prototype"


def drag(
    open_studios: ExitStack, name: str, depth: int, panels: bool, **changes: Any
) -> Callable[[], Any]:
    """Return a job that moves a control point a little further and waits for the page.

    Without panels as while the mouse button is held, with them as when it was released.
    """
    studio = open_studios.enter_context(opened())
    session, page = studio.session, studio.page
    session.edit(lambda model: model.load_preset(name))
    session.edit(lambda model: model.set_depth("a", depth))
    session.edit(lambda model: model.set_depth("b", depth - (model.design.b.fold is not None)))
    session.edit(lambda model: model.change(**changes))
    page.wait()
    x, y, z = session.snapshot().design.a.control_points[1]
    way = count(1)

    def job() -> Any:
        place = (x + 0.1 * next(way), y, z)
        gesture = "" if panels else "drag"
        session.edit(lambda model: model.move_control_point("a", 1, place), gesture, held=True)
        page.wait()

    return job


def main() -> None:
    """Print the times."""
    jobs = {}
    with tempfile.TemporaryDirectory() as folder, ExitStack() as open_studios:
        os.chdir(folder)  # where designs without a file are kept

        def job(*arguments: Any, **changes: Any) -> Callable[[], Any]:
            return drag(open_studios, *arguments, **changes)

        for name in (ROUGH, EXACT):
            short = name.split("_", 2)[2]
            bare = {"label": None, "holes": None}
            thin = bare | {"thickness": 3.0}
            jobs[f"{short}, 16 x 16, surface"] = job(name, 4, False, **bare)
            jobs[f"{short}, 16 x 16, panels and report"] = job(name, 4, True, **bare)
            jobs[f"{short}, 16 x 16, panels, report, labels, holes"] = job(
                name, 4, True, label=Label(), holes=Holes()
            )
            jobs[f"{short}, 64 x 64, surface"] = job(name, 6, False, **thin)
            jobs[f"{short}, 64 x 64, panels and report"] = job(name, 6, True, **thin)
        for what, timing in interleaved(jobs, 9).items():
            print(f"{what:60} {1e3 * timing.best:7.1f} best {1e3 * timing.median:7.1f} median ms")


if __name__ == "__main__":
    main()
