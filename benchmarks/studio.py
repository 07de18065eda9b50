"""(m) From a moved control point to what the studio sends to its page: surface, and everything.

It goes the way that the page goes: the session is edited
as by a mouse, the recomputer evaluates and the scene is encoded; only the browser is missing.
Labels and holes are on 16 x 16 panels only: on 64 x 64 they have no room.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from itertools import count
from pathlib import Path
from typing import Any

from screens import frames, headless_browser, open_studio_page
from table import Line, milliseconds
from timing import interleaved

from ifs_cad.elements.hole import Holes
from ifs_cad.elements.label import Label
from ifs_cad.studio.handles import Key
from ifs_cad.studio.run import Studio, opened

ROUGH = "figure_18_thickened_surface"
EXACT = "figure_21_prototype"

BARE: dict[str, Any] = {"label": None, "holes": None}
THIN = BARE | {"thickness": 3.0}
CASES: tuple[tuple[str, float | None, int, bool, dict[str, Any]], ...] = (
    ("16 x 16, surface", 10.0, 4, False, BARE),
    ("16 x 16, panels and report", 100.0, 4, True, BARE),
    ("16 x 16, panels, report, labels, holes", None, 4, True, {"label": Label(), "holes": Holes()}),
    ("64 x 64, surface", 30.0, 6, False, THIN),
    ("64 x 64, panels and report", None, 6, True, THIN),
)
"""What is sent, its limit in ms, the depth, whether panels are made, what else is changed."""

PICTURED = "16 x 16, panels, report, labels, holes, prototype"
PICTURE = "studio.png"


def drag(studio: Studio, name: str, depth: int, panels: bool, **changes: Any) -> Callable[[], Any]:
    """Return a job that moves a control point a little further and waits for the page.

    Without panels as while the mouse button is held, with them as when it was released.
    """
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


def measure(rounds: int, pictures: Path | None) -> list[Line]:
    """Measure a rough and an exact surface in two sizes, all in turns."""
    jobs: dict[str, Callable[[], Any]] = {}
    studios: dict[str, Studio] = {}
    limits: dict[str, float | None] = {}
    calls: dict[str, int] = {}
    with tempfile.TemporaryDirectory() as folder, ExitStack() as open_studios:
        for name in (ROUGH, EXACT):
            for part, limit, depth, panels, changes in CASES:
                what = f"{part}, {name.split('_', 2)[2].replace('_', ' ')}"
                studio = open_studios.enter_context(opened(Path(folder, f"{len(jobs)}.toml")))
                studios[what] = studio
                jobs[what] = drag(studio, name, depth, panels, **changes)
                limits[what] = limit
                calls[what] = 1 if panels else 8  # short ones meet a quiet moment more rarely
        timings = interleaved(jobs, rounds, calls)
        if pictures is not None:
            _photograph(studios[PICTURED], pictures / PICTURE)
    return [
        Line(
            "m",
            f"studio, a dragged point: {what}",
            milliseconds(timing.best),
            f"median {milliseconds(timing.median)}",
            1e3 * timing.best,
            " ms",
            limits[what],
            noise=timing.wall / timing.best,
        )
        for what, timing in timings.items()
    ]


def _photograph(studio: Studio, path: Path) -> None:
    """Take a picture of a studio's page after a control point was dragged."""
    with headless_browser() as browser:
        page = open_studio_page(browser, studio.address, 1100, 650)
        studio.page.select(Key("a", 1))
        frames(page)
        page.screenshot(path=path)


if __name__ == "__main__":
    for line in measure(9, None):
        print(" | ".join(line.cells()))
