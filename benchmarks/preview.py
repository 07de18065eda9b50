"""(n) From a saved script to the viewer: the prototype run again, made and sent.

It is the job that `ifs-cad show --watch` gives its worker after each save, the kernel being loaded,
with a real viewer and its page in a browser without a screen. Processor times count, since without
a graphics card the page draws on the same cores: that of the job, that of the page's script, and
that of the drawing, which a graphics card would do.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import psutil
from screens import frames, headless_browser, open_viewer_page, running_viewer
from table import Line, milliseconds
from timing import interleaved

from ifs_cad.workflow.worker import JOBS

SCRIPT = Path(__file__).resolve().parents[1] / "parts" / "shell_prototype.py"
PICTURE = "preview.png"
KINDS = ("--type=renderer", "--type=gpu-process")  # of Chromium's processes


def measure(rounds: int, pictures: Path | None) -> Iterator[Line]:
    """Measure a save of the prototype, and once the same with the solids as they are cut."""
    with shown() as (show, page):
        timing = interleaved({"flat": show}, rounds)["flat"]
        frames(page)
        before = work_of_browser()
        show()
        frames(page)
        script, drawing = (work_of_browser()[kind] - before[kind] for kind in KINDS)
        if pictures is not None:
            page.screenshot(path=pictures / PICTURE)
        page_does = f"{milliseconds(script)} the page, {milliseconds(drawing)} drawing in software"
        yield Line(
            "n",
            "ifs-cad show --watch: a save of the prototype, run again, made and sent",
            milliseconds(timing.best),
            page_does,
            timing.best,
            " s",
            limit=1.0,
            noise=timing.median / timing.best,
        )
        begin = time.process_time()
        show(exact=True)
        exact = time.process_time() - begin
        yield Line(
            "n",
            "the same, against the viewer's own client triangulating the solids",
            milliseconds(timing.best),
            milliseconds(exact),
            exact / timing.best,
            " x faster",
            limit=10.0,
            at_least=True,
        )


def work_of_browser() -> dict[str, float]:
    """Return the processor time, s, of the processes that run pages and of those that draw them."""
    took = dict.fromkeys(KINDS, 0.0)
    for process in psutil.Process().children(recursive=True):
        with suppress(psutil.Error):
            kind = next((kind for kind in KINDS if kind in process.cmdline()), None)
            if kind is not None:
                times = process.cpu_times()
                took[kind] += times.user + times.system
    return took


@contextmanager
def shown() -> Iterator[tuple[Callable[..., Any], Any]]:
    """Open a viewer; yield what shows the prototype in it, and its page."""
    with (
        TemporaryDirectory() as home,
        running_viewer(Path(home)) as port,
        headless_browser() as browser,
    ):
        page = open_viewer_page(browser, port, 1100, 650)
        options = {"colour": "area", "keep_camera": True, "timeout": 300.0}

        def show(**more: Any) -> Any:
            return JOBS["show"](str(SCRIPT), {}, port, options | more)

        yield show, page


if __name__ == "__main__":
    for line in measure(5, None):
        print(" | ".join(line.cells()))
