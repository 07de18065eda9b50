"""The studio in a real browser: the mouse drags, the keyboard types, files arrive."""

from __future__ import annotations

import http.server
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from screens import frames

from ifs_cad.design_file import read_design, write_design
from ifs_cad.design_record import Design, DrawnCurve
from ifs_cad.elements.label import Label
from ifs_cad.studio.model import autosave_path
from ifs_cad.studio.session import Session

viser = pytest.importorskip("viser", reason="the studio's page is not installed (extra 'studio')")
run = pytest.importorskip("ifs_cad.studio.run")

pytestmark = pytest.mark.browser

PATIENCE = 120.0  # seconds; a busy machine without a graphics card draws slowly
DESIGN = Design(
    a=DrawnCurve(((0, 0, 0), (400, 0, 900), (1600, 0, 900), (2000, 0, 0)), depth=1),
    b=DrawnCurve(((0, 0, 0), (0, 700, 300), (0, 1500, 0)), depth=1),
    thickness=20.0,
    side="inner",
    label=Label(),
    title="A small shell",
)


class Page:
    """A page of the studio with a mouse and a keyboard."""

    def __init__(self, studio: Any, page: Any) -> None:
        self.studio = studio
        self.session: Session = studio.session
        self.page = page

    @property
    def design(self) -> Design:
        return self.session.snapshot().design

    def start(self, design: Design) -> None:
        """Take a design and let the camera find it."""
        self.studio.page._fit_soon()
        self.session.edit(lambda model: model.take(design))
        self.wait_for(lambda: self.shown == design)
        self.settle()

    @property
    def shown(self) -> Design | None:
        shown = self.studio.page._shown
        return None if shown is None else shown[0].design

    def settle(self) -> None:
        """Wait until the page has drawn what it was sent, and its camera rests."""
        assert self.studio.page.wait(PATIENCE)
        frames(self.page, 3)

    def wait_for(self, condition: Callable[[], Any]) -> None:
        end = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < end, "nothing happened"
            self.page.wait_for_timeout(50)

    def marker(self, name: str) -> np.ndarray:
        """Where on the page a point is, px, by the camera that the page reports."""
        ball = self.studio.server.scene.get_handle_by_name(f"/points/{name}")
        camera = self.studio.server.get_clients()[max(self.studio.server.get_clients())].camera
        box = self.page.locator("canvas").first.bounding_box()
        w, x, y, z = camera.wxyz
        turn = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )
        right, down, ahead = turn.T @ (np.array(ball.position) - camera.position)
        scale = box["height"] / 2 / np.tan(camera.fov / 2) / ahead
        middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        return np.array([middle[0] + scale * right, middle[1] + scale * down])

    def drag(self, name: str, right: float, down: float) -> None:
        """Drag a point with the real mouse, px."""
        x, y = self.marker(name)
        mouse = self.page.mouse
        mouse.move(x, y)
        mouse.down()
        mouse.move(x + right / 4, y + down / 4, steps=3)
        mouse.move(x + right, y + down, steps=5)
        mouse.up()
        self.wait_for(lambda: not self.session.snapshot().gesture)
        self.settle()

    def tab(self, name: str) -> None:
        self.page.get_by_role("tab", name=name, exact=True).click()

    def box(self, label: str) -> Any:
        """The box to type into beside a label."""
        named = self.page.get_by_text(label, exact=True).locator("visible=true")
        return named.locator("xpath=ancestor::*[.//input][1]").locator("input:visible").last

    def type(self, label: str, text: str) -> None:
        box = self.box(label)
        box.click()
        box.press("Control+a")
        box.press_sequentially(text, delay=20)

    def press(self, name: str) -> None:
        self.page.get_by_role("button", name=name, exact=True).click()


@pytest.fixture(scope="module")
def studio(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    path = tmp_path_factory.mktemp("designs") / "small.toml"
    write_design(DESIGN, path)
    with run.opened(path) as studio:
        yield studio


@pytest.fixture(scope="module")
def open_page(browser: Any, studio: Any) -> Iterator[Page]:
    page = browser.new_context(
        viewport={"width": 760, "height": 520}, device_scale_factor=0.5
    ).new_page()
    page.set_default_timeout(1000 * PATIENCE)
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto(studio.address)
    page.get_by_text("can be built").wait_for()
    opened = Page(studio, page)
    opened.wait_for(studio.server.get_clients)
    yield opened
    here = ("http://127.0.0.1:", "data:", "blob:")
    assert [url for url in asked if not url.startswith(here)] == [], "the page goes outside"


@pytest.fixture
def page(open_page: Page) -> Page:
    open_page.start(DESIGN)
    return open_page


def test_a_control_point_follows_the_mouse_in_the_plane_of_its_curve(page: Page) -> None:
    at = page.marker("a_p2")
    page.drag("a_p2", 25, -35)
    before, after = DESIGN.a.control_points, page.design.a.control_points
    assert after[1] != before[1]
    assert after[1][1] == pytest.approx(0.0, abs=1e-6)
    assert [after[0], *after[2:]] == [before[0], *before[2:]]
    assert page.marker("a_p2") == pytest.approx(at + np.array([25, -35]), abs=3.0)
    assert page.design.b == DESIGN.b
    dragged = page.design
    page.press("Undo")
    page.wait_for(lambda: page.design != dragged)
    assert page.design == DESIGN, "the whole drag is one step"
    page.press("Redo")
    page.wait_for(lambda: page.design == dragged)


def test_a_subdivision_point_is_dragged_and_stays_in_its_span(page: Page) -> None:
    at = page.marker("b_s3")
    page.drag("b_s3", -15, -25)
    (moved,) = page.design.b.moved
    assert moved.name == "s3"
    assert moved.point[0] == pytest.approx(0.0, abs=1e-6)
    assert page.marker("b_s3") == pytest.approx(at + np.array([-15, -25]), abs=3.0)


def test_a_weight_is_typed_and_undone(page: Page) -> None:
    page.tab("Curve A")
    x, y = page.marker("a_p2")
    page.page.mouse.click(x, y)
    page.box("Point").and_(page.page.locator('[value="p2"]')).wait_for()
    page.type("Exact weight", "0.5")
    page.wait_for(lambda: page.design.a.weights == (1.0, 0.5, 1.0, 1.0))
    page.wait_for(lambda: not page.session.snapshot().gesture)
    page.press("Undo")
    page.wait_for(lambda: page.design == DESIGN)


def test_a_floor_is_typed_with_its_decimals(page: Page) -> None:
    page.tab("Panels")
    page.page.get_by_label("Stands on a floor").check()
    page.wait_for(lambda: page.design.floor == 0.0)
    page.type("Floor at z (mm)", "-12.375")
    page.wait_for(lambda: page.design.floor == -12.375)
    page.wait_for(lambda: page.box("Floor at z (mm)").input_value() == "-12.375")


def test_a_depth_makes_more_panels(page: Page) -> None:
    page.tab("Curve B")
    page.type("Depth", "2")
    page.wait_for(lambda: page.design.b.depth == 2)
    page.page.get_by_text("2 x 4 = 8 panels").wait_for()


def test_what_cannot_be_built_is_said_and_marked(page: Page) -> None:
    page.tab("Panels")
    page.type("Measured (mm)", "2000")
    page.wait_for(lambda: page.design.thickness == 2000.0)
    page.page.get_by_text("in the way").wait_for()
    page.settle()
    marks = page.studio.server.scene.get_handle_by_name("/marks/error")
    wrong = page.studio.server.scene.get_handle_by_name("/shell/wrong")
    assert len(marks.points)
    assert wrong.visible
    assert len(wrong.faces)
    page.page.get_by_text("thick").first.wait_for()


def test_a_refused_value_is_said_and_the_design_stays(page: Page) -> None:
    page.tab("Panels")
    page.type("Clearance (mm)", "-1")
    page.page.get_by_text("learance must").wait_for()
    assert page.design == DESIGN
    page.wait_for(lambda: page.box("Clearance (mm)").input_value() in ("0", "0.00"))


def test_a_saved_design_is_back_after_a_reload(page: Page) -> None:
    page.session.edit(lambda model: model.set_roughness("a", 0.25))
    page.tab("File")
    page.press("Save")
    page.wait_for(lambda: page.session.snapshot().is_saved)
    assert page.session.path is not None
    assert read_design(page.session.path) == page.design
    page.page.reload()
    page.page.get_by_text("can be built").wait_for()
    page.tab("Curve A")
    page.wait_for(lambda: page.box("Roughness").input_value() == "0.25")


def test_what_a_crash_left_is_asked_about_until_it_is_decided(page: Page) -> None:
    before = page.session.path
    assert before is not None
    other = write_design(DESIGN, before.with_name("other.toml"))
    kept = write_design(replace(DESIGN, thickness=25.0), autosave_path(other))
    page.tab("File")
    page.type("Path", str(other))
    page.wait_for(lambda: page.box("Path").input_value() == str(other))
    page.press("Open")
    asked = page.page.get_by_role("dialog")
    asked.wait_for()
    page.session.edit(lambda model: model.set_thickness(50.0))
    own = autosave_path(other, 2)
    page.wait_for(own.exists)
    assert read_design(own).thickness == 50.0
    page.page.reload()
    page.page.get_by_text("can be built").wait_for()
    asked.wait_for()
    assert read_design(kept).thickness == 25.0
    asked.get_by_role("button", name="Go on with it").click()
    page.wait_for(lambda: page.design.thickness == 25.0)
    asked.wait_for(state="hidden")
    page.page.reload()
    page.page.get_by_text("can be built").wait_for()
    page.tab("File")
    assert asked.count() == 0
    page.press("Save")
    page.wait_for(lambda: not kept.exists())
    assert read_design(other).thickness == 25.0
    assert read_design(own).thickness == 50.0
    page.session.open(before)


def test_a_figure_does_not_replace_the_open_file(
    page: Page, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # where a design without a file is kept
    before = page.session.path
    assert before is not None
    text = before.read_bytes()
    page.tab("File")
    page.type("Path", str(before))
    page.press("Take this figure")
    page.page.get_by_text("no file yet: not saved").wait_for()
    figure = page.design
    assert figure != DESIGN
    page.press("Save")
    page.page.get_by_text("Press once more to replace it").wait_for()
    assert before.read_bytes() == text
    page.press("Undo")
    page.wait_for(lambda: page.design == DESIGN)
    page.session.open(before)


def test_a_rest_of_a_crash_that_cannot_be_read_is_said(page: Page) -> None:
    before = page.session.path
    assert before is not None
    other = write_design(DESIGN, before.with_name("unread.toml"))
    autosave_path(other).write_text("version = 99\n")
    page.tab("File")
    page.type("Path", str(other))
    page.wait_for(lambda: page.box("Path").input_value() == str(other))
    page.press("Open")
    asked = page.page.get_by_role("dialog")
    asked.get_by_text(".unread.autosave.bad.toml").wait_for()
    asked.get_by_role("button", name="Go on without it").click()
    asked.wait_for(state="hidden")
    page.session.open(before)


FOREIGN_PAGE = """<html><body><script>
async function attempt(port, key) {
    const tried = [];
    for (const host of [`127.0.0.1:${port}`, `localhost:${port}`])
        tried.push(await new Promise(done => {
            const socket = new WebSocket(`ws://${host}`, ["viser-v%s"]);
            socket.onmessage = () => done("read");
            socket.onopen = () => socket.send("write");
            socket.onerror = socket.onclose = () => done("refused");
        }));
    tried.push(await fetch(`http://127.0.0.1:${port}/?key=${key}`, {credentials: "include"})
        .then(answer => answer.text(), () => "refused"));
    return tried;
}
</script></body></html>"""


def test_a_page_of_another_origin_reads_and_writes_nothing(page: Page) -> None:
    """In the browser that holds the cookie, from another port of this machine."""

    class Foreign(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write((FOREIGN_PAGE % viser.__version__).encode())

        def log_message(self, *_: Any) -> None:
            pass

    clients = set(page.studio.server.get_clients())
    port, _, key = page.studio.address.rpartition(":")[2].partition("/?key=")
    with http.server.HTTPServer(("127.0.0.1", 0), Foreign) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        foreign = page.page.context.new_page()
        foreign.goto(f"http://127.0.0.1:{server.server_port}/")
        tried = foreign.evaluate("([port, key]) => attempt(port, key)", [port, key])
        foreign.close()
        server.shutdown()
    assert tried == ["refused"] * 3
    assert set(page.studio.server.get_clients()) == clients
    assert page.design == DESIGN


def test_the_workshop_folder_is_made_of_own_stock(page: Page, tmp_path: Path) -> None:
    stock = tmp_path / "own.toml"
    stock.write_text('[[sheets]]\nname = "thin"\nlength = "2500"\n', encoding="utf-8")
    page.tab("Make")
    page.type("Own stock", str(stock))
    page.press("Workshop folder")
    said = page.page.get_by_text("line 3: [[sheets]] entry 1 (thin): length must be a number")
    said.wait_for()
    page.box("Own stock").fill("")


def test_the_step_file_that_is_downloaded_passes_the_check(page: Page, tmp_path: Path) -> None:
    page.tab("Make")
    with page.page.expect_download() as download:
        page.press("STEP file")
    assert download.value.suggested_filename == "small.step"
    target = tmp_path / "small.step"
    download.value.save_as(target)
    check = [sys.executable, "-m", "ifs_cad.cli", "check", str(target)]
    done = subprocess.run(check, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
