"""Make the pictures of the documentation and the gallery of all parts.

python docs/make_pictures.py (needs matplotlib)
"""

from __future__ import annotations

import ast
from pathlib import Path
from runpy import run_path
from tempfile import TemporaryDirectory

import cadquery as cq
import matplotlib as mpl
import numpy as np

import ifs_cad as ifs
from ifs_cad.workflow.analysis import asked

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


def deformed() -> None:
    """Draw the three shells of figure 22 under their load, side by side."""
    figure, axes = plt.subplots(1, 3, figsize=(16, 3.6), layout="constrained")
    with TemporaryDirectory() as folder:
        for axis, (name, (shell, asked_for)) in zip(
            axes, asked([shown("figure_22")]).items(), strict=True
        ):
            path = Path(folder) / f"{name}.png"
            result = ifs.analyse(
                shell, loads=asked_for.loads, supports=asked_for.supports, divisions=4
            )
            ifs.render_deformed(result, path, width=1000, height=620)
            axis.imshow(plt.imread(path))
            axis.set_title(f"{name.replace('_', ' ')}: {result.deflection.value:.3g} mm")
            axis.axis("off")
    figure.savefig(PICTURES / "figure_22_deformed.png", dpi=90)
    plt.close(figure)


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
    for make in (curves, node, prototype, deformed, gallery):
        make()
        print(f"{make.__name__}: done")
