"""The preview against real viewers, real pages and things that only listen."""

from __future__ import annotations

import contextlib
import http.server
import io
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cadquery as cq
import numpy as np
import pytest

from ifs_cad.errors import InputError, MissingLibraryError, ViewerError
from ifs_cad.view import preview

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
# software rendering: a test machine may have neither a graphics card nor a screen
BROWSER_OPTIONS = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
]
RED = (0.9, 0.1, 0.1)


def vault(rows: int = 16, columns: int = 16) -> cq.Assembly:
    """Boxes named like panels, nested by row, one row red."""
    shell = cq.Assembly(name="vault")
    for i in range(rows):
        row = cq.Assembly(name=f"row{i:02}")
        color = cq.Color(*RED) if i == 0 else cq.Color("burlywood")
        for j in range(columns):
            place = cq.Location((110 * i, 110 * j, -((i - rows / 2) ** 2)), (0, 1, 0), 5 * i)
            box = cq.Solid.makeBox(100, 100, 10)
            row.add(box, name=f"panel{i:02}{j:02}", loc=place, color=color)
        shell.add(row)
    return shell


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


@pytest.fixture(autouse=True)
def nothing_shown_before(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(preview, "_shown", {})
    monkeypatch.delenv("OCP_PORT", raising=False)


@contextlib.contextmanager
def running_viewer(home: Path) -> Iterator[int]:
    """Run a standalone viewer that keeps its settings in `home`; yield its port."""
    pytest.importorskip("ocp_viewer", reason="the viewer is not installed (extra 'view')")
    port = free_port()
    with (home / "viewer.log").open("wb") as log:
        server = subprocess.Popen(
            [sys.executable, "-m", "ocp_viewer", "--host", "127.0.0.1", "--port", str(port)],
            env={**os.environ, "HOME": str(home), "USERPROFILE": str(home)},
            stdout=log,
            stderr=log,
        )
        try:
            wait_until_served(f"http://127.0.0.1:{port}/viewer", server)
            yield port
        finally:
            server.send_signal(signal.SIGINT if os.name == "posix" else signal.SIGTERM)
            server.wait(timeout=30)


def wait_until_served(url: str, server: subprocess.Popen[bytes]) -> None:
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    for _ in range(600):
        assert server.poll() is None, "the viewer ended"
        try:
            with opener.open(url, timeout=5):
                return
        except OSError:
            time.sleep(0.1)
    pytest.fail(f"{url} is not served after a minute")


@pytest.fixture(scope="module")
def viewer(tmp_path_factory: pytest.TempPathFactory) -> Iterator[int]:
    with running_viewer(tmp_path_factory.mktemp("home")) as port:
        yield port


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    path = next(filter(None, map(shutil.which, BROWSERS)), None)
    if path is None:
        pytest.skip(f"no browser: install one of {', '.join(BROWSERS)}")
    with playwright.sync_playwright() as p:
        browser = p.chromium.launch(executable_path=path, args=BROWSER_OPTIONS)
        yield browser
        browser.close()


@pytest.fixture
def page(browser: Any, viewer: int) -> Iterator[Any]:
    """The viewer's page, with the splash screen on it."""
    page = browser.new_page(viewport={"width": 1000, "height": 700})
    page.goto(f"http://127.0.0.1:{viewer}/viewer")
    page.get_by_text("Eye").wait_for()  # a part of the splash screen
    yield page
    page.close()


def share_of_red(page: Any) -> float:
    image = pytest.importorskip("PIL.Image", reason="pillow is not installed")
    pixels = np.asarray(image.open(io.BytesIO(page.screenshot())).convert("RGB")).astype(int)
    red, green, blue = np.moveaxis(pixels, -1, 0)
    return float(((red > 2 * green) & (red > 2 * blue) & (red > 80)).mean())


@pytest.mark.browser
def test_an_assembly_is_on_the_page_when_show_returns(
    page: Any, viewer: int, capfd: pytest.CaptureFixture[str]
) -> None:
    before = share_of_red(page)
    preview.show(vault(), "my shell", port=viewer)
    tree = page.locator("body").inner_text()
    assert "my shell" in tree
    assert "row00" in tree
    assert "row15" in tree
    assert share_of_red(page) > before + 0.005
    assert capfd.readouterr() == ("", "")


@pytest.mark.browser
@pytest.mark.parametrize(
    "thing",
    [cq.Workplane().box(10, 10, 10), cq.Solid.makeBox(10, 10, 10), cq.Edge.makeCircle(5)],
    ids=["workplane", "solid", "edge"],
)
def test_a_single_thing_is_on_the_page_when_show_returns(
    page: Any, viewer: int, thing: Any
) -> None:
    preview.show(thing, "a/b: 100 %", port=viewer)
    assert "a-b: 100 %" in page.locator("body").inner_text()


@pytest.mark.browser
def test_the_client_of_vs_code_reaches_the_standalone_viewer(
    page: Any, viewer: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("ocp_vscode", reason="the client of VS Code is not installed")
    monkeypatch.setitem(sys.modules, "ocp_viewer", None)
    assert preview._client().__name__ == "ocp_vscode"
    preview.show(vault(2, 2), "by the other client", port=viewer)
    assert "by the other client" in page.locator("body").inner_text()


@pytest.mark.browser
def test_a_page_closed_since_the_last_model_is_an_error(page: Any, viewer: int) -> None:
    preview.show(vault(2, 2), port=viewer)
    page.close()
    with pytest.raises(ViewerError, match="did not show the model within 2 s: no page seems"):
        preview.show(vault(2, 2), port=viewer, timeout=2.0)


@pytest.mark.browser
def test_what_one_script_shows_is_on_the_page_together(
    page: Any, viewer: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("OCP_PORT", str(viewer))
    preview.show_object(vault(2, 2), "shell")
    preview.show_object(cq.Workplane().box(500, 20, 20), name="jamb", options={"alpha": 0.5})
    tree = page.locator("body").inner_text()
    assert "shell + jamb" in tree
    assert {"shell", "jamb"} <= set(tree.split("\n"))
    assert capsys.readouterr().out == ""


def test_a_viewer_without_a_page_is_an_error(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with (
        running_viewer(tmp_path) as port,
        pytest.raises(ViewerError, match="no page seems to be open") as error,
    ):
        preview.show(vault(2, 2), port=port)
    assert f"open http://127.0.0.1:{port}/viewer in a browser" in str(error.value)
    assert capfd.readouterr() == ("", "")


def test_no_viewer_is_an_error_that_gives_the_command(capfd: pytest.CaptureFixture[str]) -> None:
    port = free_port()
    with pytest.raises(ViewerError, match=f"No viewer listens on 127.0.0.1:{port}") as error:
        preview.show(vault(2, 2), port=port)
    assert f"python -m ocp_viewer --host 127.0.0.1 --port {port}" in str(error.value)
    assert capfd.readouterr() == ("", "")


@pytest.fixture
def silent_listener() -> Iterator[int]:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        yield listener.getsockname()[1]


@pytest.fixture
def web_server() -> Iterator[int]:
    with http.server.HTTPServer(("127.0.0.1", 0), http.server.BaseHTTPRequestHandler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield server.server_port
        server.shutdown()


@pytest.fixture
def other_websocket() -> Iterator[int]:
    server_of = pytest.importorskip("websockets.sync.server", reason="no viewer is installed")
    with server_of.serve(lambda line: line.send('["hello"]'), "127.0.0.1", 0) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield server.socket.getsockname()[1]
        server.shutdown()


@pytest.mark.parametrize("listening", ["silent_listener", "web_server", "other_websocket"])
def test_something_else_on_the_port_is_an_error(
    listening: str, request: pytest.FixtureRequest
) -> None:
    port = request.getfixturevalue(listening)
    with pytest.raises(ViewerError, match="is not an OCP viewer") as error:
        preview.show(vault(2, 2), port=port)
    assert f"--port {port + 1}" in str(error.value)


@pytest.mark.parametrize("host", ["0.0.0.0", "192.168.1.5", "example.com", ""])
def test_another_machine_is_refused(host: str) -> None:
    with pytest.raises(InputError, match="only spoken to on this machine"):
        preview.show(vault(2, 2), host=host)


@pytest.mark.parametrize("port", [0, -1, 65536])
def test_a_port_that_is_none_is_refused(port: int) -> None:
    with pytest.raises(InputError, match="from 1 to 65535"):
        preview.show(vault(2, 2), port=port)


def test_a_port_in_the_environment_must_be_a_number(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OCP_PORT", "the usual one")
    with pytest.raises(InputError, match="'the usual one'"):
        preview.show(vault(2, 2))


@pytest.mark.parametrize("thing", [42, None, [cq.Workplane().box(1, 1, 1)], "shell.step"])
def test_a_thing_without_a_shape_is_refused(thing: Any) -> None:
    with pytest.raises(InputError, match=f"not a {type(thing).__name__}"):
        preview.show_object(thing)


@pytest.mark.parametrize("empty", [cq.Assembly(), cq.Workplane()], ids=["assembly", "workplane"])
def test_an_empty_model_is_refused(empty: Any) -> None:
    with pytest.raises(InputError, match="nothing to look at"):
        preview.show_object(empty)


def test_a_missing_viewer_package_is_an_error_that_names_the_extra(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "ocp_viewer", None)
    monkeypatch.setitem(sys.modules, "ocp_vscode", None)
    with pytest.raises(MissingLibraryError, match=r"ifs-cad\[view\]"):
        preview.show(vault(2, 2), port=free_port())


def test_a_script_goes_on_without_a_viewer(tmp_path: Path) -> None:
    port = free_port()
    script = tmp_path / "part.py"
    script.write_text(
        "import cadquery as cq\n"
        "if 'show_object' not in globals():\n"
        "    from ifs_cad import show_object\n"
        "pair = cq.Assembly().add(cq.Solid.makeBox(1, 1, 1)).add(cq.Solid.makeBox(2, 2, 2))\n"
        "show_object(pair, name='pair')\n"
        "show_object(cq.Workplane().box(1, 1, 1))\n",
        encoding="utf-8",
    )
    done = subprocess.run(
        [sys.executable, str(script)],
        env={**os.environ, "OCP_PORT": str(port), "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    first, second = done.stdout.splitlines()
    assert first.startswith("pair: 2 parts, not previewed. No viewer listens on 127.0.0.1:")
    assert f"python -m ocp_viewer --host 127.0.0.1 --port {port}" in first
    assert second.startswith("object 2: 1 part, not previewed. ")
