"""Pictures of pictures: colours by sheet, a moving one, the pages of the viewer and the studio."""

from __future__ import annotations

from contextlib import chdir
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from screens import (
    frames,
    headless_browser,
    open_studio_page,
    open_viewer_page,
    running_viewer,
)

import ifs_cad as ifs
from drawings.gallery import shown
from drawings.style import PICTURES
from ifs_cad.studio.handles import Key
from ifs_cad.studio.run import opened


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
    """Take a picture of the viewer's page with the prototype in it; needs a viewer and Chromium."""
    with (
        TemporaryDirectory() as home,
        running_viewer(Path(home)) as port,
        headless_browser() as browser,
    ):
        page = open_viewer_page(browser, port, 1100, 650)
        assembly = shown("shell_prototype")
        ifs.show(assembly, "shell_prototype", colour="area", port=port, timeout=120)
        frames(page)
        page.screenshot(path=PICTURES / "preview.png")


def studio() -> None:
    """Take a picture of the studio with the prototype in it; needs Chromium."""
    with (
        TemporaryDirectory() as folder,
        chdir(folder),  # designs without a file are kept in the current folder
        opened() as studio,
        headless_browser() as browser,
    ):
        page = open_studio_page(browser, studio.address, 1400, 880)
        studio.page.select(Key("a", 1))
        frames(page)
        page.screenshot(path=PICTURES / "studio.png")
