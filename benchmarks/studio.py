"""From a moved control point to what the studio shows: surface alone, and with everything.

Run it: ``python benchmarks/studio.py``. Labels and holes are on 16 x 16 panels only: on 64 x 64
they have no room.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import count
from typing import Any

from timing import interleaved

from ifs_cad.design_file import presets
from ifs_cad.elements.hole import Holes
from ifs_cad.elements.label import Label
from ifs_cad.studio.model import StudioModel

ROUGH = "figure_18_thickened_surface"
EXACT = "figure_21_prototype"


def drag(name: str, depth: int, panels: bool, **changes: Any) -> Callable[[], Any]:
    """Return a job that moves a control point a little further and evaluates the design."""
    model = StudioModel(presets()[name])
    model.set_depth("a", depth)
    model.set_depth("b", depth - (model.design.b.fold is not None))
    model.change(**changes)
    model.begin_drag()
    x, y, z = model.design.a.control_points[1]
    way = count()

    def job() -> Any:
        model.move_control_point("a", 1, (x + 0.1 * next(way), y, z))
        return model.evaluate(panels=panels)

    return job


def main() -> None:
    """Print the times."""
    jobs = {}
    for name in (ROUGH, EXACT):
        short = name.split("_", 2)[2]
        bare = partial(drag, name, label=None, holes=None)
        jobs[f"{short}, 16 x 16, surface"] = bare(4, False)
        jobs[f"{short}, 16 x 16, panels and report"] = bare(4, True)
        jobs[f"{short}, 16 x 16, panels, report, labels, holes"] = drag(
            name, 4, True, label=Label(), holes=Holes()
        )
        jobs[f"{short}, 64 x 64, surface"] = bare(6, False, thickness=3.0)
        jobs[f"{short}, 64 x 64, panels and report"] = bare(6, True, thickness=3.0)
    for what, timing in interleaved(jobs, 9).items():
        print(f"{what:60} {1e3 * timing.best:7.1f} best {1e3 * timing.median:7.1f} median ms")


if __name__ == "__main__":
    main()
