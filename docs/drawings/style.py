"""Colours, letters and projections that all pictures share."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from numpy.typing import ArrayLike, NDArray

import ifs_cad as ifs

mpl.use("Agg")
from matplotlib import pyplot as plt

PICTURES = Path(__file__).parent.parent / "pictures"

WOOD, WOOD_LIGHT, WOOD_DARK = "#b07a3c", "#ecd2a6", "#6b4518"
CONTROL, SUBDIVISION, INK, PALE = "#c0392b", "#2c6fbb", "#2b2b2b", "#8f8f8f"
FOUR = ("#e3b778", "#9bbfdd", "#b9d59a", "#dba2a2")  # neighbours that must be told apart

HALO = withStroke(linewidth=2.5, foreground="white")

mpl.rcParams |= {
    "font.family": "DejaVu Sans",
    "font.size": 10,
    "axes.titlesize": 11,
    "svg.hashsalt": "ifs_cad",  # the same picture is the same file
    "savefig.facecolor": "white",
}


def sheet(columns: int, width: float, height: float, rows: int = 1) -> tuple[Figure, list[Axes]]:
    """Return a figure in inches and its plain axes, row by row."""
    figure, axes = plt.subplots(rows, columns, figsize=(width, height), squeeze=False)
    for axis in axes.flat:
        axis.set_aspect("equal")
        axis.axis("off")
    return figure, list(axes.flat)


def save(figure: Figure, name: str) -> None:
    """Write a figure into the pictures of the documentation."""
    figure.tight_layout()
    figure.savefig(
        PICTURES / f"{name}.svg", metadata={"Date": None}, bbox_inches="tight", pad_inches=0.08
    )
    plt.close(figure)


def plot(axis: Axes, points: ArrayLike, *style: str, plane: str = "xy", **options: Any) -> None:
    """Plot a polyline seen along the third axis."""
    x, y = _axes(plane)
    rows = np.asarray(points, dtype=float)
    axis.plot(rows[:, x], rows[:, y], *style, **options)


def control_polygon(axis: Axes, curve: ifs.Curve, plane: str = "xy", names: bool = True) -> None:
    """Draw the control points of a curve, joined and numbered as in the paper."""
    plot(axis, curve.control_points, "--", plane=plane, color=CONTROL, lw=0.8)
    plot(axis, curve.control_points, "o", plane=plane, color=CONTROL, ms=6)
    if names:
        for number, point in enumerate(curve.control_points, 1):
            is_low = point[_axes(plane)[1]] <= curve.control_points[:, _axes(plane)[1]].min()
            offset = (-6, -15) if is_low else (6, 3)
            write_beside(axis, {f"$p_{number}$": point}, plane, CONTROL, offset)


def subdivision_points(axis: Axes, curve: ifs.Curve, plane: str = "xy") -> None:
    """Draw the subdivision points of a curve; those that are joints have their names below."""
    points = curve.subdivision_points
    plot(axis, list(points.values()), "s", plane=plane, color=SUBDIVISION, ms=5)
    for name, point in points.items():
        is_joint = np.abs(curve.with_depth(1).points - point).max(axis=1).min() < 1.0
        offset = (-5, -15) if is_joint else (5, 4)
        write_beside(axis, {f"$s_{name[1:]}$": point}, plane, SUBDIVISION, offset)


def write_beside(
    axis: Axes,
    names: Mapping[str, ArrayLike],
    plane: str,
    colour: str,
    offset: tuple[int, int] = (5, 5),
) -> None:
    """Write names beside points, in points of print."""
    x, y = _axes(plane)
    for name, point in names.items():
        place = np.asarray(point)[[x, y]]
        written = axis.annotate(name, place, offset, textcoords="offset points", color=colour)
        written.set_path_effects([HALO])


def _axes(plane: str) -> tuple[int, int]:
    return "xyz".index(plane[0]), "xyz".index(plane[1])


class Camera:
    """A parallel projection, as that of `ifs.render`."""

    def __init__(self, azimuth: float, elevation: float) -> None:
        a, e = np.radians((azimuth, elevation))
        self.back = np.array([np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)])
        right = np.array([-np.sin(a), np.cos(a), 0.0])
        self.axes = np.array([right, np.cross(self.back, right)])

    def __call__(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return (n, 2) places on paper."""
        return np.asarray(points, dtype=float) @ self.axes.T

    def nearness(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return (n,) how near points are to the eye."""
        return np.asarray(points, dtype=float) @ self.back


def draw_mesh(
    axis: Axes,
    mesh: ifs.Mesh,
    camera: Camera,
    colours: Iterable[str] | None = None,
    edge: str = WOOD_DARK,
) -> NDArray[np.float64]:
    """Draw a quad mesh, lit from above; return (faces, 2) the places of its faces' middles."""
    corners = mesh.vertices[mesh.corners.reshape(-1, 4)]
    middles = corners.mean(axis=1)
    paint = np.array([mpl.colors.to_rgb(c) for c in colours or [WOOD_LIGHT] * len(mesh)])
    light = 0.72 + 0.28 * np.abs(mesh.normals @ np.array([0.3, -0.45, 0.84]))
    for face in np.argsort(camera.nearness(middles)):
        axis.fill(*camera(corners[face]).T, fc=paint[face] * light[face], ec=edge, lw=0.7)
    return camera(middles)
