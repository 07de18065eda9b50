"""A browser without a screen, and a viewer for it to open: for tests, pictures and benchmarks."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
# software rendering: the machine may have neither a graphics card nor a screen
OPTIONS = (
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)
PATIENCE = 60.0  # s, within which a viewer serves its page
STUDIO_PATIENCE = 120.0  # s; without a graphics card a studio draws slowly


class NoScreenError(RuntimeError):
    """What is needed to look is not installed."""


@contextmanager
def headless_browser() -> Iterator[Any]:
    """Run Chromium; yield it as Playwright's `Browser`.

    Raises
    ------
    NoScreenError
        There is no Chromium, or no Playwright.
    """
    path = next(filter(None, map(shutil.which, BROWSERS)), None)
    if path is None:
        raise NoScreenError(f"no browser: install one of {', '.join(BROWSERS)}")
    try:
        from playwright.sync_api import sync_playwright
    except ModuleNotFoundError as error:
        raise NoScreenError("playwright is not installed (extra 'test')") from error
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(OPTIONS))
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def running_viewer(home: Path) -> Iterator[int]:
    """Run a standalone OCP viewer that keeps its settings in `home`; yield its port."""
    port = free_port()
    with (home / "viewer.log").open("wb") as log:
        server = subprocess.Popen(
            [sys.executable, "-m", "ocp_viewer", "--host", "127.0.0.1", "--port", str(port)],
            env={**os.environ, "HOME": str(home), "USERPROFILE": str(home)},
            stdout=log,
            stderr=log,
        )
        try:
            _wait_until_served(viewer_page(port), server)
            yield port
        finally:
            server.terminate()
            server.wait(timeout=30)


def viewer_page(port: int) -> str:
    """Return where a viewer's page is."""
    return f"http://127.0.0.1:{port}/viewer"


def open_viewer_page(
    browser: Any, port: int, width: int, height: int, sharpness: float = 1.0
) -> Any:
    """Open the page of a viewer and return it once its splash screen is drawn.

    Parameters
    ----------
    browser : of `headless_browser`
    port : int
    width, height : int
        Of the page, as it measures itself.
    sharpness : float
        Pixels that are drawn for each of these, along each side; what the processor draws takes
        time by the pixel.
    """
    size = {"width": width, "height": height}
    page = browser.new_page(viewport=size, device_scale_factor=sharpness)
    page.set_default_timeout(1000 * PATIENCE)
    page.goto(viewer_page(port))
    page.get_by_text("Eye").wait_for()  # a part of the splash screen
    return page


def open_studio_page(browser: Any, address: str, width: int, height: int) -> Any:
    """Open the page of a studio and return it once its design is drawn and nothing lies over it."""
    page = browser.new_page(viewport={"width": width, "height": height})
    page.set_default_timeout(1000 * STUDIO_PATIENCE)
    page.goto(address)
    page.get_by_text("can be built").wait_for()
    page.get_by_text("Software WebGL").wait_for()
    page.locator(".mantine-Notification-closeButton").click()
    return page


def frames(page: Any, count: int = 10) -> None:
    """Wait until a page has drawn some frames, and so what it was sent before."""
    for _ in range(count):
        page.evaluate("() => new Promise(done => requestAnimationFrame(() => done()))")


def free_port() -> int:
    """Return a port of this machine at which nothing listens."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


def _wait_until_served(url: str, server: subprocess.Popen[bytes]) -> None:
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        if server.poll() is not None:
            raise NoScreenError("the viewer ended at once: is the extra 'view' installed?")
        try:
            with opener.open(url, timeout=5):
                return
        except OSError:
            time.sleep(0.1)
    raise NoScreenError(f"{url} is not served after {PATIENCE:.0f} s")
