"""Pictures of panels: a section through chamfers, a node, the foot of the prototype."""

from __future__ import annotations

import numpy as np
from matplotlib.patches import Arc

import ifs_cad as ifs
from drawings.gallery import shown
from drawings.style import (
    CONTROL,
    FOUR,
    HALO,
    INK,
    PICTURES,
    SUBDIVISION,
    WOOD,
    WOOD_DARK,
    save,
    sheet,
)

THICKNESS = 30.0
PROFILE = np.array([(0, 0), (190, 120), (400, 130), (560, -10)], dtype=float)


def section() -> None:
    """Draw a section across three panels: thickness, offset, bisector planes, chamfer angle."""
    profile = np.column_stack([PROFILE[:, 0], np.zeros(4), PROFILE[:, 1]])
    shell = ifs.thicken(ifs.vector_sum(profile, [(0, 0, 0), (0, 100, 0)]), THICKNESS, side="inner")
    if shell.normals[:, 2].mean() < 0:
        shell = ifs.thicken(shell.mesh, THICKNESS, side="outer")
    figure, (axis,) = sheet(1, 9, 3.8)
    for panel, colour in zip(shell, FOUR, strict=False):
        points = panel.solid.vertices
        cut = points[np.abs(points[:, 1]) < 1e-6][:, [0, 2]]
        angles = np.arctan2(*(cut - cut.mean(axis=0)).T[::-1])
        axis.fill(*cut[np.argsort(angles)].T, fc=colour, ec=INK, lw=1.0)
    axis.plot(*PROFILE.T, color=WOOD, lw=3, solid_capstyle="round")
    offsets = _offset_corners()
    for node, offset in zip(PROFILE[1:3], offsets, strict=True):
        ray = (offset - node) / np.linalg.norm(offset - node)
        axis.plot(*np.array([node - 60 * ray, node + 105 * ray]).T, "--", color=CONTROL, lw=1.2)
    _say(axis, "bisector plane", PROFILE[1] + (-118, 48), CONTROL)
    _say(axis, "design face", (285, 137), WOOD_DARK)
    _say(axis, "offset face", (245, 76), INK)
    _mark_thickness(axis)
    _mark_angle(axis, PROFILE[2], PROFILE[1] - PROFILE[2], offsets[1] - PROFILE[2])
    _say(axis, "square border", (-62, -38), INK)
    axis.set(xlim=(-80, 640), ylim=(-70, 205))
    save(figure, "section")


def _offset_corners() -> np.ndarray:
    """Return where the offset lines of neighbouring faces meet."""
    along = np.diff(PROFILE, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    inward = np.column_stack([along[:, 1], -along[:, 0]])
    corners = []
    for k in (1, 2):
        both = np.array([inward[k - 1], inward[k]])
        corners.append(PROFILE[k] + np.linalg.solve(both, [THICKNESS, THICKNESS]))
    return np.array(corners)


def _mark_thickness(axis) -> None:
    along = (PROFILE[1] - PROFILE[0]) / np.linalg.norm(PROFILE[1] - PROFILE[0])
    inward = np.array([along[1], -along[0]])
    foot = PROFILE[0] + 90 * along
    axis.annotate(
        "",
        foot,
        foot + THICKNESS * inward,
        arrowprops={"arrowstyle": "<|-|>", "color": SUBDIVISION, "shrinkA": 0, "shrinkB": 0},
    )
    _say(axis, "thickness", foot + 1.25 * THICKNESS * inward + (4, -10), SUBDIVISION)


def _mark_angle(axis, node, along, cut) -> None:
    """Mark the angle of a chamfer: between the cut and the line square to the face."""
    square = np.array([-along[1], along[0]])
    square *= np.sign(square @ cut) / np.linalg.norm(square)
    tip = node + 85 * square
    axis.plot(*np.array([node, tip]).T, color=SUBDIVISION, lw=1)
    first, second = (np.degrees(np.arctan2(v[1], v[0])) for v in (square, cut))
    low, high = min(first, second), max(first, second)
    axis.add_patch(Arc(node, 150, 150, theta1=low, theta2=high, color=SUBDIVISION, lw=1.4))
    place = node + 84 * np.array([np.cos(np.radians(first)), np.sin(np.radians(first))])
    _say(axis, f"chamfer angle {high - low:.0f}°", place - np.array([150, 22]), SUBDIVISION)


def _say(axis, words, place, colour) -> None:
    axis.text(*place, words, color=colour, fontsize=11, path_effects=[HALO])


def node() -> None:
    """Draw the offset faces around one node, from above: plain, relieved, on node axes."""
    a = np.array([(0, 0, 0), (100, 20, 75), (210, -10, 80)])
    b = np.array([(0, 0, 0), (60, 100, 45), (70, 220, 40)])
    figure, axes = sheet(3, 10, 2.9)
    titles = {
        "plain": "bisector planes only",
        "relief": "relief",
        "axis": "node axes",
    }
    for axis, (nodes, title) in zip(axes, titles.items(), strict=True):
        shell = ifs.thicken(ifs.vector_sum(a, b), 40.0, nodes=nodes)
        up = shell.normals.mean(axis=0)
        up /= np.linalg.norm(up)
        right = np.cross((0, 1, 0), up)
        view = np.array([right, np.cross(up, right)]) / np.linalg.norm(right)
        solids = shell.solids
        rings = [
            solids.vertices[solids.loops[solids.face_offsets[f] : solids.face_offsets[f + 1]]]
            for f in np.flatnonzero(solids.kinds == 1)  # the offset faces
        ]
        middle = shell.mesh.vertices[shell.mesh.lattice[1, 1]]
        at_node = [ring[np.linalg.norm(ring - middle, axis=1).argmin()] for ring in rings]
        centre = np.mean(at_node, axis=0)
        for ring, colour in zip(rings, FOUR, strict=True):
            axis.fill(*(view @ (ring - centre).T), fc=colour, alpha=0.65, ec=INK, lw=1)
        axis.set(xlim=(-14, 14), ylim=(-10, 10))
        axis.plot((-13, -8), (-9.2, -9.2), color=INK, lw=1.5)
        axis.text(-10.5, -8.8, "5 mm", ha="center", va="bottom", fontsize=9, path_effects=[HALO])
        axis.set_title(title)
    save(figure, "node")


def foot() -> None:
    """Draw the first panels of the prototype's foot, seen from inside."""
    shell = shown("shell_prototype").metadata["elements"]
    part = ifs.to_assembly(shell.part(["00*", "01*"]), label="engraved", holes=ifs.Holes())
    ifs.render(part, PICTURES / "foot.png", width=1200, height=900, azimuth=20, elevation=-25)
