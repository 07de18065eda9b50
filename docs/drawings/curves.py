"""Pictures of curves: construction steps, subdivision points, roughness, contraction, folds."""

from __future__ import annotations

import numpy as np

import ifs_cad as ifs
from drawings.style import (
    CONTROL,
    INK,
    PALE,
    SUBDIVISION,
    WOOD,
    WOOD_DARK,
    control_polygon,
    plot,
    plt,
    save,
    sheet,
    subdivision_points,
    write_beside,
)

ROOF = [(0, 0), (1500, 1400), (3000, 0)]
SUBSCRIPTS = str.maketrans("0123", "₁₂₃₄")  # word digits count from 0, the paper's from 1


def construction_steps() -> None:
    """Draw the germ and three construction steps, every piece with its word."""
    figure, axes = sheet(2, 8.6, 4.9, rows=2)
    titles = ("germ: P K", "step 1: P Tᵢ K", "step 2: P Tᵢ Tⱼ K", "step 3: P Tᵢ Tⱼ Tₖ K")
    for depth, (axis, title) in enumerate(zip(axes, titles, strict=True)):
        curve = ifs.Curve(ROOF, depth=depth)
        control_polygon(axis, curve, names=depth == 0)
        if depth == 1:
            subdivision_points(axis, curve)
        for number, word in enumerate(curve.addresses):
            piece = curve.at(word) if depth else curve.points
            plot(axis, piece, color=(WOOD, WOOD_DARK)[number % 2], lw=3, solid_capstyle="butt")
            if depth in (1, 2):
                middle = piece.mean(axis=0)[:2]
                outward = np.array([middle[0] - 1500, 1500]) / 1800
                name = "".join("T" + digit.translate(SUBSCRIPTS) for digit in word)
                axis.annotate(
                    name, middle - 300 * outward, ha="center", va="center", fontsize=10, color=INK
                )
        axis.set_title(title)
        axis.set(xlim=(-150, 3250), ylim=(-230, 1650))
    save(figure, "construction_steps")


def subdivision() -> None:
    """Draw one subdivision point, as it was, moved, and with another weight."""
    curve = ifs.Curve(ROOF, depth=6)
    moved = curve.with_subdivision_point("s3", (1500, 1000))
    heavy = curve.with_subdivision_point("s2", weight=3.0)
    figure, axes = sheet(3, 10, 2.9)
    titles = ("a Bezier curve", "s₃ moved up", "s₂ with the weight 3")
    for axis, shown, title in zip(axes, (curve, moved, heavy), titles, strict=True):
        control_polygon(axis, shown)
        if shown is not curve:
            plot(axis, curve.points, color=PALE, lw=0.9, ls=":")
        plot(axis, shown.points, color=WOOD, lw=1.8)
        subdivision_points(axis, shown)
        axis.set_title(title)
        axis.set(xlim=(-200, 3200), ylim=(-260, 1750))
    save(figure, "subdivision")


def roughness() -> None:
    """Draw one curve from smooth to rough."""
    figure, axes = sheet(2, 8.6, 5.9, rows=2)
    for axis, rough in zip(axes, (0.0, 0.2, 0.4, 0.6), strict=True):
        curve = ifs.Curve(ROOF, depth=6).with_roughness(rough)
        control_polygon(axis, curve, names=False)
        plot(axis, curve.points, color=WOOD, lw=1.6)
        subdivision_points(axis, curve)
        axis.set_title(f"roughness {rough:g}")
        axis.set(xlim=(-150, 3250), ylim=(-150, 2200))
    save(figure, "roughness")


def contraction() -> None:
    """Draw a curve whose pieces shrink beside one whose pieces do not."""
    good = ifs.Curve(ROOF, depth=7).with_roughness(0.3)
    bad = ifs.Curve(ROOF, depth=7).with_subdivision_point("s2", (650, 1900))
    figure, axes = plt.subplots(1, 3, figsize=(10, 2.9))
    for axis, curve, title in zip(axes, (good, bad), ("contracts", "does not"), strict=False):
        rate = curve.contraction().rate
        plot(axis, curve.points, color=WOOD, lw=0.9)
        control_polygon(axis, curve, names=False)
        subdivision_points(axis, curve)
        axis.set_title(f"{title}: rate {rate:.2f}")
        axis.set_aspect("equal", adjustable="datalim")
        axis.axis("off")
    plot_ = axes[2]
    for curve, colour, name, offset in (
        (good, WOOD, "contracts", (6, 4)),
        (bad, CONTROL, "does not", (0, 9)),
    ):
        depths = np.arange(8)
        sizes = [
            np.linalg.norm(np.diff(curve.with_depth(int(d)).points, axis=0), axis=1).max()
            for d in depths
        ]
        plot_.semilogy(depths, sizes, "o-", color=colour, ms=4, lw=1.2)
        plot_.annotate(
            name,
            (depths[4], sizes[4]),
            offset,
            textcoords="offset points",
            color=colour,
        )
    plot_.set(xlabel="construction steps", ylabel="longest segment, mm")
    plot_.set_title("the pieces from step to step")
    plot_.spines[["top", "right"]].set_visible(False)
    save(figure, "contraction")


def even_fold() -> None:
    """Draw a rough curve, and the even fold of a smooth one with its two slopes."""
    base = ifs.Curve([(0, 0, 0), (0, 900, 200), (0, 1800, 0)], depth=2)
    figure, axes = sheet(1, 8, 4.0, rows=2)
    rough = base.with_depth(3).with_roughness(0.4)
    even = base.with_even_fold(0.5)
    titles = (
        "roughness 0.4: eight slopes",
        "even fold over four segments: one slope, up and down",
    )
    for axis, curve, title in zip(axes, (rough, even), titles, strict=True):
        plot(axis, base.points, plane="yz", color=PALE, lw=1, ls=":")
        plot(axis, curve.points, plane="yz", color=WOOD, lw=2.4)
        plot(axis, curve.points, "o", plane="yz", color=WOOD_DARK, ms=3.5)
        axis.set_title(title)
        axis.set(xlim=(-60, 1860), ylim=(-60, 330))
    steps = even.points[:2, 1:]
    corner = np.array([steps[1, 0], steps[0, 1]])
    axes[1].plot(*np.array([steps[0], corner, steps[1]]).T, color=SUBDIVISION, lw=1)
    write_beside(axes[1], {"H": (0, *(steps[0] + corner) / 2)}, "yz", SUBDIVISION, (0, -12))
    write_beside(axes[1], {"H / 2": (0, *(corner + steps[1]) / 2)}, "yz", SUBDIVISION, (4, -6))
    save(figure, "even_fold")
