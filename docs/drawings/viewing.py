"""Pictures of pictures: colours by sheet, a moving picture, the viewer's page."""

from __future__ import annotations

import os
import shutil
import sys
from contextlib import suppress
from signal import SIGINT
from socket import socket
from subprocess import DEVNULL, Popen
from tempfile import TemporaryDirectory

import numpy as np

import ifs_cad as ifs
from drawings.gallery import shown
from drawings.style import PICTURES


def sheets() -> None:
    """Draw the prototype in four parts, in the colours of the sheets, with its addresses."""
    ifs.render(
        shown("shell_prototype"),
        PICTURES / "sheets.png",
        width=1200,
        height=750,
        azimuth=-38.0,
        elevation=20.0,
        colour="sheet",
        explode=(0.3,),
        labels=True,
    )


def smooth_to_rough() -> None:
    """Draw a shell whose cross section goes from smooth to rough, as a moving picture."""
    arch = ifs.Curve([(0, 0, 0), (0, 0, 2900), (4500, 0, 2900), (4500, 0, 0)], depth=4)
    fold = ifs.Curve([(0, 0, 0), (0, 1500, 500), (0, 3000, 0)], depth=4)
    surfaces = (ifs.vector_sum(arch, fold.with_roughness(r)) for r in np.linspace(0, 0.45, 16))
    shells = (ifs.thicken(surface, 20.0, side="outer") for surface in surfaces)
    look = {"width": 560, "height": 350, "azimuth": -50.0, "elevation": 18.0}
    ifs.animate(shells, PICTURES / "smooth_to_rough.gif", seconds=3, there_and_back=True, **look)


def preview() -> None:
    """Take a picture of the viewer's page with the prototype in it; needs a viewer and chromium."""
    from playwright.sync_api import Error, sync_playwright

    with socket() as free:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
    with TemporaryDirectory() as home, sync_playwright() as playwright:
        viewer = [sys.executable, "-m", "ocp_viewer", "--host", "127.0.0.1", "--port", port]
        with Popen(viewer, env={**os.environ, "HOME": home}, stdout=DEVNULL) as server:
            browser = playwright.chromium.launch(
                executable_path=shutil.which("chromium"),
                args=["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
            )
            page = browser.new_page(viewport={"width": 1100, "height": 650})
            page.set_default_timeout(120_000)
            while server.poll() is None:  # until it serves the page
                with suppress(Error):
                    page.goto(f"http://127.0.0.1:{port}/viewer")
                    break
            page.get_by_text("Eye").wait_for()
            assembly = shown("shell_prototype")
            ifs.show(assembly, "shell_prototype", colour="area", port=int(port), timeout=120)
            page.screenshot(path=PICTURES / "preview.png")
            browser.close()
            server.send_signal(SIGINT)
