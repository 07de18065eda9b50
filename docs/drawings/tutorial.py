"""Pictures of the tutorial, made from the same lines."""

from __future__ import annotations

import ifs_cad as ifs
from drawings.style import (
    CONTROL,
    FOUR,
    INK,
    PICTURES,
    WOOD,
    Camera,
    control_polygon,
    draw_mesh,
    plot,
    save,
    sheet,
    subdivision_points,
)
from ifs_cad.export.drawing import sheet_svg

ARCH = ifs.Curve([(0, 0, 0), (0, 0, 2400), (3000, 0, 2400), (3000, 0, 0)], depth=3)
SMOOTH = ifs.Curve([(0, 0, 0), (0, 900, 450), (0, 1800, 0)], depth=2)
FOLD = SMOOTH.with_roughness(0.7)
LABEL, HOLES = ifs.Label(depth=0.5, cutter=3), ifs.Holes(5)


def _shell() -> ifs.Shell:
    return ifs.thicken(ifs.vector_sum(ARCH, FOLD), 12.0, side="outer")


def tutorial_curves() -> None:
    """Draw the arch, and the curve across: smooth and rough."""
    figure, axes = sheet(3, 10, 2.9)
    control_polygon(axes[0], ARCH, "xz")
    plot(axes[0], ARCH.points, "o-", plane="xz", color=WOOD, lw=2.2, ms=3.5)
    axes[0].set_title("the arch: 8 segments")
    for axis, curve, title in (
        (axes[1], SMOOTH, "across, smooth: 4 segments"),
        (axes[2], FOLD, "across, roughness 0.7"),
    ):
        control_polygon(axis, curve, "yz")
        plot(axis, curve.points, "o-", plane="yz", color=WOOD, lw=2.2, ms=3.5)
        subdivision_points(axis, curve, "yz")
        axis.set_title(title)
        axis.set(xlim=(-120, 1920), ylim=(-160, 640))
    save(figure, "tutorial_curves")


def tutorial_surface() -> None:
    """Draw the surface, every face with its address."""
    mesh, camera = ifs.vector_sum(ARCH, FOLD), Camera(-50, 35)
    figure, (axis,) = sheet(1, 8, 5)
    middles = draw_mesh(axis, mesh, camera, [FOUR[int(a[1])] for a in mesh.addresses])
    seen = mesh.normals @ camera.back > 0.15
    for number in seen.nonzero()[0]:
        axis.text(
            *middles[number],
            mesh.addresses[number],
            ha="center",
            va="center",
            fontsize=9,
            color=INK,
        )
    axis.plot(*camera(ARCH.points).T, color=CONTROL, lw=2)
    axis.plot(*camera(FOLD.points).T, color=CONTROL, lw=2)
    save(figure, "tutorial_surface")


def tutorial_shell() -> None:
    """Draw the panels."""
    assembly = ifs.to_assembly(_shell(), label=LABEL, holes=HOLES)
    ifs.render(assembly, PICTURES / "tutorial_shell.png", azimuth=-50, width=1200, height=800)


def tutorial_sheet() -> None:
    """Draw the drawing of the first nested sheet."""
    pieces = ifs.workpieces(_shell(), label=LABEL, holes=HOLES)
    layout = ifs.nest(pieces, ifs.read_stock().sheets_of(12), spacing=15)
    text = sheet_svg(layout.sheets[0], pieces)
    (PICTURES / "tutorial_sheet.svg").write_text(text, encoding="utf-8")
