"""Make the picture of the studio: the prototype in a browser without a screen.

python docs/studio_picture.py (needs the extras studio and test, and Chromium)
"""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

from ifs_cad.studio.handles import Key
from ifs_cad.studio.run import opened

PICTURE = Path(__file__).resolve().parent / "pictures" / "studio.png"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
OPTIONS = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
]
PATIENCE = 120_000  # ms; a machine without a graphics card draws slowly
TWO_FRAMES = """() => new Promise(done =>
    requestAnimationFrame(() => requestAnimationFrame(() => done())))"""


def drawn(page: Page) -> None:
    """Wait until the page has drawn what it was sent."""
    for _ in range(5):
        page.evaluate(TWO_FRAMES)


def main() -> None:
    """Draw the picture."""
    browser_path = next(filter(None, map(shutil.which, BROWSERS)))
    os.chdir(tempfile.mkdtemp())  # designs without a file are kept in the current folder
    with opened() as studio, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=browser_path, args=OPTIONS)
        page = browser.new_page(viewport={"width": 1400, "height": 880})
        page.set_default_timeout(PATIENCE)
        page.goto(studio.address)
        page.get_by_text("can be built").wait_for()
        page.get_by_text("Software WebGL").wait_for()
        page.locator(".mantine-Notification-closeButton").click()
        studio.page.select(Key("a", 1))
        drawn(page)
        page.screenshot(path=PICTURE)
        browser.close()


if __name__ == "__main__":
    main()
