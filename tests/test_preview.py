"""The preview against real viewers, real pages and things that only listen."""

from __future__ import annotations

import base64
import http.server
import io
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cadquery as cq
import numpy as np
import pytest
from screens import free_port, open_viewer_page, running_viewer
from typer.testing import CliRunner

import ifs_cad as ifs
from ifs_cad.cli import app
from ifs_cad.errors import InputError, MissingLibraryError, ViewerError
from ifs_cad.kernel.source import run_script, together
from ifs_cad.view import preview
from ifs_cad.view._assembly import view_of
from ifs_cad.view._viewer_model import NOWHERE, is_plain, tree

RED = (0.9, 0.1, 0.1)
PROTOTYPE = Path(__file__).parents[1] / "parts" / "shell_prototype.py"


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


@pytest.fixture(autouse=True)
def nothing_shown_before(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(preview, "_shown", {})
    monkeypatch.setattr(preview, "_cameras", set())
    monkeypatch.delenv("OCP_PORT", raising=False)


@pytest.fixture(scope="module")
def viewer(tmp_path_factory: pytest.TempPathFactory) -> Iterator[int]:
    pytest.importorskip("ocp_viewer", reason="the viewer is not installed (extra 'view')")
    with running_viewer(tmp_path_factory.mktemp("home")) as port:
        yield port


@pytest.fixture
def page(browser: Any, viewer: int) -> Iterator[Any]:
    """The viewer's page, with the splash screen on it."""
    page = open_viewer_page(browser, viewer, 1000, 700, sharpness=0.5)
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


def small_shell(depth: int = 2) -> cq.Assembly:
    """16 engraved and drilled panels in four groups by the first digit of their addresses."""
    arch = ifs.Curve([(0, 0, 0), (0, 0, 1500), (3000, 0, 1500), (3000, 0, 0)], depth=depth)
    fold = ifs.Curve([(0, 0, 0), (0, 750, 300), (0, 1500, 0)], depth=depth)
    shell = ifs.thicken(ifs.vector_sum(arch, fold), 20.0)
    return ifs.to_assembly(shell, label="engraved", holes=ifs.Holes(), nest=1)


def shares_of_scale(page: Any) -> np.ndarray:
    """Shares of the page in a scale's first, middle and last colour, however lit."""
    image = pytest.importorskip("PIL.Image", reason="pillow is not installed")
    pixels = np.asarray(image.open(io.BytesIO(page.screenshot())).convert("RGB")).astype(int)
    red, green, blue = np.moveaxis(pixels, -1, 0)
    violet = (red > 1.3 * green) & (blue > 1.3 * red)
    yellow = (np.minimum(red, green) > 1.8 * blue) & (red > 120) & (red > 0.9 * green)
    teal = (np.minimum(green, blue) > 1.8 * red) & (np.abs(green - blue) < 0.2 * green)
    return np.array([violet.mean(), teal.mean(), yellow.mean()])


@pytest.mark.browser
def test_a_shell_is_on_the_page_with_its_tree_colours_and_legend(page: Any, viewer: int) -> None:
    assembly = small_shell()
    before = shares_of_scale(page)
    preview.show(assembly, "small", port=viewer, colour="area", explode=(0.3,))
    tree = page.locator("body").inner_text().split("\n")
    for name in ("shell-0", "shell-3", "area, m2", "addresses", "holes"):
        assert any(line.strip().startswith(name) for line in tree), name
    page.wait_for_timeout(300)  # for the next frame
    assert (shares_of_scale(page) > before + 0.002)[[0, 2]].all()


@pytest.mark.browser
@pytest.mark.slow
def test_the_prototype_is_on_the_page_with_its_addresses_and_colours(
    page: Any, viewer: int
) -> None:
    """On software rendering its first frames take seconds, so the colours are waited for."""
    before = shares_of_scale(page)
    prototype = together(run_script(PROTOTYPE, {}))
    preview.show(prototype, "prototype", port=viewer, colour="area", timeout=60.0)
    text = page.locator("body").inner_text()
    tree = {line.strip(" ⚈") for line in text.split("\n")}
    elements = prototype.metadata["elements"]
    assert len(elements) == 256
    assert {f"shell-{address[0]}" for address in elements.addresses} <= tree
    assert len(tree & set(elements.addresses)) > 8  # only lines in sight are made
    assert {"addresses", "holes", "area, m2"} <= tree
    deadline = time.monotonic() + 60
    while not (shares_of_scale(page) > before + np.array([0.0001, 0.002, 0.002])).all():
        assert time.monotonic() < deadline, "violet, teal and yellow are not all on the page"
        page.wait_for_timeout(500)


@pytest.mark.browser
def test_the_same_model_is_shown_again_on_a_page_loaded_anew(page: Any, viewer: int) -> None:
    preview.show(small_shell(), "once", port=viewer, keep_camera=True)
    page.reload()
    page.get_by_text("Eye").wait_for()
    preview.show(small_shell(), "again", port=viewer, keep_camera=True)
    assert "again" in page.locator("body").inner_text()


@pytest.mark.browser
def test_a_shell_among_other_things_keeps_its_place(page: Any, viewer: int) -> None:
    both = cq.Assembly(name="site")
    both.add(small_shell(), name="roof", loc=cq.Location((0, 0, 3000)))
    both.add(cq.Solid.makeBox(3000, 1500, 100), name="ground", color=cq.Color(*RED))
    preview.show(both, "site", port=viewer)
    tree = {line.strip(" ⚈") for line in page.locator("body").inner_text().split("\n")}
    assert {"roof", "ground", "shell-0"} <= tree


def lines_of(node: dict[str, Any]) -> np.ndarray:
    packed = node["shape"]["edges"]
    values = np.frombuffer(base64.b64decode(packed["buffer"]), packed["dtype"])
    return values.reshape(-1, 2, 3)


def test_the_arrays_of_a_preview_are_the_panels_that_the_kernel_makes() -> None:
    wired = ifs.to_assembly(small_shell().metadata["elements"], label="wire", holes=ifs.Holes())
    [group] = view_of(wired).groups
    instances: list[dict[str, Any]] = []
    node = tree(group, "/x", NOWHERE, instances)
    for number, address in enumerate(group.elements.addresses):
        part = wired.objects[address]
        packed = instances[number]["vertices"]
        points = np.frombuffer(base64.b64decode(packed["buffer"]), packed["dtype"]).reshape(-1, 3)
        box = part.obj.moved(part.loc).BoundingBox()
        assert points.min(axis=0) == pytest.approx([box.xmin, box.ymin, box.zmin], abs=0.01)
        assert points.max(axis=0) == pytest.approx([box.xmax, box.ymax, box.zmax], abs=0.01)
    marks = {part["name"]: lines_of(part) for part in node["parts"] if part["type"] == "edges"}
    strokes = [part for name, part in wired.objects.items() if name.endswith("-strokes")]
    boxes = [part.obj.moved(part.loc).BoundingBox() for part in strokes]
    low = np.min([(box.xmin, box.ymin, box.zmin) for box in boxes], axis=0)
    high = np.max([(box.xmax, box.ymax, box.zmax) for box in boxes], axis=0)
    assert marks["addresses"].min(axis=(0, 1)) == pytest.approx(low, abs=0.5)
    assert marks["addresses"].max(axis=(0, 1)) == pytest.approx(high, abs=0.5)
    drilled = sum(1 for face in wired.toCompound().Faces() if face.geomType() == "CYLINDER")
    assert len(marks["holes"]) == 8 * drilled  # circles of 8 lines on the marked face


def test_the_legend_stands_beside_the_model_with_its_values_written() -> None:
    shell = small_shell().metadata["elements"]
    [group] = view_of(shell, "area").groups
    instances: list[dict[str, Any]] = []
    legend = tree(group, "/x", NOWHERE, instances)["parts"][-1]
    *fields, values = legend["parts"]
    assert legend["name"] == "area, m2"
    assert [field["name"] for field in fields] == [text for text, _ in group.colouring.ticks()]
    high = shell.solids.vertices.max(axis=0)
    corners = []
    for made in instances[-len(fields) :]:
        packed = made["vertices"]
        points = np.frombuffer(base64.b64decode(packed["buffer"]), packed["dtype"]).reshape(-1, 3)
        assert (points.min(axis=0)[:2] > high[:2]).all()
        corners.append(points)
    lines = lines_of(values)
    heights = lines[..., 2].mean(axis=1)
    for points in corners:  # a value beside each field, and none through it
        low, top = points[:, 2].min(), points[:, 2].max()
        beside = lines[(heights > low) & (heights < top)]
        assert len(beside)
        assert (beside[..., 1] > points[:, 1].max()).all()


def test_triangles_face_outwards_and_enclose_the_volume_of_the_panel() -> None:
    [group] = view_of(small_shell()).groups
    instances: list[dict[str, Any]] = []
    tree(group, "/x", NOWHERE, instances)

    def array(packed: dict[str, Any]) -> np.ndarray:
        return np.frombuffer(base64.b64decode(packed["buffer"]), packed["dtype"]).reshape(-1, 3)

    for instance, volume in zip(instances, group.elements.volumes, strict=True):
        points, triangles = array(instance["vertices"]), array(instance["triangles"])
        a, b, c = np.moveaxis(points.astype(float)[triangles], 1, 0)
        assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(volume, rel=1e-3)
        normal = array(instance["normals"])[triangles[:, 0]]
        assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), normal) > 0).all()


def test_a_modified_panel_is_sent_as_it_is() -> None:
    assembly = small_shell()
    [group] = view_of(assembly).groups
    assert is_plain(group)
    part = assembly.objects["00"]
    part.obj = part.obj.cut(cq.Solid.makeBox(50, 50, 50))
    assert not is_plain(view_of(assembly).groups[0])


SCRIPT = """
import ifs_cad as ifs
from beside import rise
arch = ifs.Curve([(0, 0, 0), (0, 0, rise), (3000, 0, rise), (3000, 0, 0)], depth=1)
fold = ifs.Curve([(0, 0, 0), (0, 750, 300), (0, 1500, 0)], depth=1)
show_object(ifs.to_assembly(ifs.thicken(ifs.vector_sum(arch, fold), 20.0), nest=0))
"""


def save(path: Path, text: str) -> None:
    """Save as most editors do: beside the file, and rename."""
    beside = path.with_name(f".{path.name}.new")
    beside.write_text(text, encoding="utf-8")
    beside.replace(path)


@pytest.mark.browser
def test_a_script_is_shown_again_after_each_save(page: Any, viewer: int, tmp_path: Path) -> None:
    pytest.importorskip("watchfiles", reason="watchfiles is not installed")
    script, module = tmp_path / "roof.py", tmp_path / "beside.py"
    module.write_text("rise = 1500.0\n", encoding="utf-8")
    script.write_text(SCRIPT, encoding="utf-8")
    command = [sys.executable, "-m", "ifs_cad.cli", "show", str(script), "--watch"]
    with subprocess.Popen(
        [*command, "--port", str(viewer)],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "PYTHONUNBUFFERED": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    ) as watching:
        assert watching.stdout is not None
        said = iter(watching.stdout.readline, "")
        try:
            assert next(said).startswith("Shown after")
            first = page.locator("body").inner_text()
            assert "roof" in first
            save(script, SCRIPT + "# nothing new\n")
            assert next(said).startswith("Shown after")
            second = page.locator("body").inner_text()
            assert second != first  # the time in the title
            save(script, SCRIPT.replace("nest=0", "nest=none"))
            assert "name 'none' is not defined" in next(said)
            next(said)  # the line of the script
            save(module, "rise = 1200.0\n")  # a module beside it, while the script is broken
            assert "name 'none' is not defined" in next(said)
            next(said)
            save(script, SCRIPT)
            line = next(said)
            assert line.startswith("Shown after")
            assert "Watching 2 files" in line
            assert page.locator("body").inner_text() not in (first, second)
            watching.send_signal(signal.SIGINT)
            assert next(said).startswith("No longer watching")
            assert watching.wait(timeout=60) == 0
        finally:
            watching.kill()


def test_watching_without_a_viewer_is_an_error_at_once(tmp_path: Path) -> None:
    pytest.importorskip("watchfiles", reason="watchfiles is not installed")
    script = tmp_path / "box.py"
    script.write_text("import cadquery as cq\nshow_object(cq.Workplane().box(1, 1, 1))\n")
    done = CliRunner().invoke(app, ["show", str(script), "--watch", "--port", str(free_port())])
    assert done.exit_code == 1
    assert "python -m ocp_viewer --host 127.0.0.1" in done.output


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
    preview.show(small_shell(), port=viewer, keep_camera=True)
    page.close()
    with pytest.raises(ViewerError, match="did not show the model within 2 s: no page seems"):
        preview.show(small_shell(), port=viewer, keep_camera=True, timeout=2.0)


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
