"""Make the pictures of the documentation and the gallery of all parts.

python docs/make_pictures.py [NAME ...] (needs matplotlib, playwright and chromium)
"""

from __future__ import annotations

import ast
import os
import shutil
import sys
from contextlib import suppress
from pathlib import Path
from runpy import run_path
from signal import SIGINT
from socket import socket
from subprocess import DEVNULL, Popen
from tempfile import TemporaryDirectory

import cadquery as cq
import matplotlib as mpl
import numpy as np
from playwright.sync_api import Error, sync_playwright

import ifs_cad as ifs

mpl.use("Agg")
from matplotlib import pyplot as plt

HERE = Path(__file__).parent
PARTS = HERE.parent / "parts"
PICTURES = HERE / "pictures"
GALLERY = HERE / "gallery"
FLAT = 0.05  # of its length: a drawing, seen from above
FROM_ABOVE, ASLANT = (-90.0, 90.0), (-60.0, 25.0)
VIEWS = {
    "shell_prototype": (-38.0, 20.0),
    "climbing_wall": (-75.0, 12.0),
    "figure_11_vector_sum": (-125.0, 25.0),
}
WOOD, CONTROL, SUBDIVISION = "#b07a3c", "#c0392b", "#2c6fbb"


def curves() -> None:
    """Draw one curve from smooth to rough, with its control and subdivision points."""
    control = [(0, 0), (1500, 1400), (3000, 0)]
    figure, axes = plt.subplots(1, 4, figsize=(13, 2.9), sharey=True)
    for axis, roughness in zip(axes, (0.0, 0.2, 0.4, 0.6), strict=True):
        curve = ifs.Curve(control, depth=6).with_roughness(roughness)
        axis.plot(*np.transpose(control), "o--", color=CONTROL, lw=0.8, ms=5)
        points = curve.subdivision_points
        axis.plot(*np.array(list(points.values()))[:, :2].T, "s", color=SUBDIVISION, ms=5)
        for name, point in points.items():
            axis.annotate(name, point[:2], (4, 5), textcoords="offset points", fontsize=8)
        axis.plot(*curve.points[:, :2].T, color=WOOD, lw=1.6)
        axis.set_title(f"roughness {roughness:g}", fontsize=10)
        axis.set_aspect("equal")
        axis.axis("off")
    figure.tight_layout()
    figure.savefig(PICTURES / "roughness.png", dpi=110)
    plt.close(figure)


def node() -> None:
    """Draw the offset faces around one node, from above: plain, relieved, on node axes."""
    a = np.array([(0, 0, 0), (100, 20, 75), (210, -10, 80)])
    b = np.array([(0, 0, 0), (60, 100, 45), (70, 220, 40)])
    figure, axes = plt.subplots(1, 3, figsize=(13, 4.2))
    titles = {
        "plain": "bisector planes only: two panels overlap",
        "relief": "relief: both are cut by one plane",
        "axis": "node axes: nothing overlaps, edges make a lip",
    }
    for axis, (nodes, title) in zip(axes, titles.items(), strict=True):
        shell = ifs.thicken(ifs.vector_sum(a, b), 40.0, nodes=nodes)
        up = shell.normals.mean(axis=0)
        up /= np.linalg.norm(up)
        right = np.cross((0, 1, 0), up)
        view = np.array([right, np.cross(up, right)]) / np.linalg.norm(right)
        solids = shell.solids
        offset_faces = np.flatnonzero(solids.kinds == 1)
        rings = [
            solids.vertices[solids.loops[solids.face_offsets[f] : solids.face_offsets[f + 1]]]
            for f in offset_faces
        ]
        middle = shell.mesh.vertices[shell.mesh.lattice[1, 1]]
        at_node = [ring[np.linalg.norm(ring - middle, axis=1).argmin()] for ring in rings]
        centre = np.mean(at_node, axis=0)
        for ring, colour in zip(rings, ("#d9a066", "#8fb3d9", "#b6d98f", "#d98f8f"), strict=True):
            axis.fill(*(view @ (ring - centre).T), color=colour, alpha=0.55, ec="black", lw=1)
        axis.set(xlim=(-14, 14), ylim=(-10, 10), aspect="equal", xlabel="mm")
        axis.set_title(title, fontsize=10)
    figure.tight_layout()
    figure.savefig(PICTURES / "node.png", dpi=110)
    plt.close(figure)


def prototype() -> None:
    """Draw the first panels of the prototype's foot, seen from inside."""
    shell = shown("shell_prototype").metadata["elements"]
    foot = ifs.to_assembly(shell.part(["00*", "01*"]), label="engraved", holes=ifs.Holes())
    ifs.render(foot, PICTURES / "addresses.png", width=1200, azimuth=20, elevation=-25)


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


def gallery() -> None:
    """Draw every part, and write the page that shows them."""
    page = ["# Gallery", "", "Every picture is one script in `parts/`, drawn by `ifs.render`.", ""]
    for script in sorted(PARTS.glob("*.py")):
        name = script.stem
        assembly = shown(name)
        box = assembly.toCompound().BoundingBox()
        is_flat = box.zlen < FLAT * max(box.xlen, box.ylen)
        azimuth, elevation = VIEWS.get(name, FROM_ABOVE if is_flat else ASLANT)
        path = GALLERY / f"{name}.png"
        ifs.render(assembly, path, width=1200, height=750, azimuth=azimuth, elevation=elevation)
        words = ast.get_docstring(ast.parse(script.read_text(encoding="utf-8"))) or name
        page += [f"## {name}", "", words, "", f"![{name}](gallery/{name}.png)", ""]
    (HERE / "gallery.md").write_text("\n".join(page), encoding="utf-8")


def shown(name: str) -> cq.Assembly:
    """Return what a part script shows."""
    results: list[cq.Assembly] = []
    run_path(
        str(PARTS / f"{name}.py"),
        init_globals={"show_object": lambda thing, **_: results.append(thing)},
    )
    return results[0]


if __name__ == "__main__":
    for folder in (PICTURES, GALLERY):
        folder.mkdir(exist_ok=True)
    for make in (curves, node, prototype, sheets, smooth_to_rough, preview, gallery):
        if not sys.argv[1:] or make.__name__ in sys.argv[1:]:
            make()
            print(f"{make.__name__}: done")
