"""Pictures of surfaces: the vector sum, addresses, folds."""

from __future__ import annotations

import numpy as np

import ifs_cad as ifs
from drawings.style import (
    CONTROL,
    FOUR,
    HALO,
    INK,
    SUBDIVISION,
    WOOD,
    WOOD_LIGHT,
    Camera,
    draw_mesh,
    save,
    sheet,
)

ARCH = [(0, 0, 0), (0, 0, 2400), (3000, 0, 2400), (3000, 0, 0)]
RIDGE = [(0, 0, 0), (0, 900, 450), (0, 1800, 0)]


def vector_sum() -> None:
    """Draw two curves, and the surface with one of its faces as a sum of two segments."""
    a = ifs.Curve(ARCH, depth=3)
    b = ifs.Curve(RIDGE, depth=2).with_roughness(0.4)
    mesh = ifs.vector_sum(a, b)
    camera = Camera(-50, 25)
    figure, axes = sheet(2, 9.5, 4.0)
    for axis in axes:
        if axis is axes[1]:
            colours = [WOOD_LIGHT] * len(mesh)
            draw_mesh(axis, mesh, camera, colours, edge="#c9a56c")
        for curve, colour, name in ((a, CONTROL, "A"), (b, SUBDIVISION, "B")):
            axis.plot(*camera(curve.points).T, "o-", color=colour, lw=2, ms=3.5)
            for k in (0, 1, 2) if name == "B" else (1, 2, 3):
                text = f"${name}_{k}$" if k or name == "A" else "$A_0 = B_0$"
                offset = (-20, -4) if name == "A" else (0, -15)
                axis.annotate(
                    text,
                    camera(curve.points[k]),
                    offset,
                    textcoords="offset points",
                    color=colour,
                    path_effects=[HALO],
                )
    i, j = 3, 2  # the corner M_ij and the two steps that lead to it
    corner = mesh.vertices[mesh.lattice[i, j]]
    face = mesh.vertices[mesh.lattice[[i, i + 1, i + 1, i], [j, j, j + 1, j + 1]]]
    axes[1].fill(*camera(face).T, fc=WOOD, ec=INK, lw=1.2, alpha=0.9)
    for start, colour in (
        (mesh.vertices[mesh.lattice[i, 0]], SUBDIVISION),
        (mesh.vertices[mesh.lattice[0, j]], CONTROL),
    ):
        axes[1].annotate(
            "",
            camera(corner),
            camera(start),
            arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.4, "ls": "--"},
        )
    axes[1].plot(*camera(corner), "o", color=INK, ms=5)
    axes[1].annotate(
        r"$M_{ij}$", camera(corner), (7, 5), textcoords="offset points", path_effects=[HALO]
    )
    axes[0].set_title("two curves with a common start")
    axes[1].set_title(r"$M_{ij} = M_{00} + (A_i - A_0) + (B_j - B_0)$")
    box = camera(mesh.vertices)
    for axis in axes:
        axis.set_xlim(box[:, 0].min() - 250, box[:, 0].max() + 150)
        axis.set_ylim(box[:, 1].min() - 250, box[:, 1].max() + 150)
    save(figure, "vector_sum")


def addresses() -> None:
    """Draw the first digits of the addresses of a surface, coarse to fine."""
    a = [ifs.Curve([(0, 0), (1000, -250), (2000, -150), (2900, 300)], depth=d) for d in (1, 2, 3)]
    b = [ifs.Curve([(0, 0), (-300, 700), (0, 1600)], depth=d) for d in (1, 2, 3)]
    figure, axes = sheet(3, 10.5, 3.0)
    for axis, along, across in zip(axes, a, b, strict=True):
        flat = ifs.vector_sum(along, across)
        colours = [FOUR[int(address[0])] for address in flat.addresses]
        middles = draw_mesh(axis, flat, Camera(-90, 90), colours)
        size = {1: 14, 2: 9, 3: 5}[len(flat.addresses[0])]
        for address, place in zip(flat.addresses, middles, strict=True):
            axis.text(*place, address, ha="center", va="center", fontsize=size, color=INK)
        steps = len(flat.addresses[0])
        axis.set_title(f"{steps} step{'s' * (steps > 1)}: {len(flat)} faces")
    save(figure, "surface_addresses")


def folds() -> None:
    """Draw a rough shell and an evenly folded one, coloured by the gap at their nodes."""
    arch = ifs.Curve(ARCH, depth=3)
    across = ifs.Curve([(0, 0, 0), (0, 900, 200), (0, 1800, 0)], depth=3)
    shells = (
        ifs.thicken(ifs.vector_sum(arch, across.with_roughness(0.4)), 12.0),
        ifs.thicken(ifs.vector_sum(arch, across.with_depth(2).with_even_fold(0.5)), 12.0),
    )
    camera = Camera(-50, 25)
    figure, axes = sheet(2, 9.5, 4.0)
    largest = max(shell.node_gaps.max() for shell in shells)
    for axis, shell, name in zip(axes, shells, ("roughness 0.4", "even fold"), strict=True):
        draw_mesh(axis, shell.mesh, camera)
        gaps = shell.node_gaps
        seen = _nodes_in_front(shell.mesh, camera)
        places = camera(shell.mesh.vertices)[seen]
        axis.scatter(*places.T, s=80 * gaps[seen] / largest, color=CONTROL, zorder=3, lw=0)
        exact = gaps.max() < shell.tol.planar
        said = "every node exact" if exact else f"node gap at most {gaps.max():.1f} mm"
        axis.set_title(f"{name}: {said}")
    save(figure, "folds")


def _nodes_in_front(mesh: ifs.Mesh, camera: Camera) -> np.ndarray:
    """Return the numbers of the nodes with a face that looks at the eye."""
    towards = mesh.normals @ camera.back > 0
    return np.unique(mesh.corners.reshape(-1, 4)[towards])
