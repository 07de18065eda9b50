"""How the deflections of figure 22, and their ratio, move with what the paper does not tell.

    python benchmarks/figure_22_sensitivity.py [picture.png]

Prints Markdown, and draws a picture when given its path (needs matplotlib). Everything is
`parts/figure_22.py` with one thing changed; 4 x 4 quads a panel, linear.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import ifs_cad as ifs
from ifs_cad.elements.material import SPRUCE_PLYWOOD, Stiffness
from ifs_cad.kernel.source import run_script
from ifs_cad.structure.analyse import analyse
from ifs_cad.workflow.analysis import asked

PART = Path(__file__).parent.parent / "parts" / "figure_22.py"
PAPER = 17.7
FOLDS = (50, 100, 150, 200, 250, 300, 400)
SPRINGS = (100.0, 1000.0, 10000.0)  # N mm/rad per mm
RIGID = 1e5  # where the picture draws rigid joints
SHEET = {"stiffness": SPRUCE_PLYWOOD.stiffness}
MATERIALS: dict[str, dict[str, Any]] = {
    "isotropic, 7000 MPa": {"stiffness": Stiffness.isotropic(7000, 0.3)},
    "isotropic, 11000 MPa": {"stiffness": Stiffness.isotropic(11000, 0.3)},
    "spruce plywood, fibre along": {**SHEET, "fibre": ifs.FibreAlongCurve("a")},
    "spruce plywood, fibre across": {**SHEET, "fibre": ifs.FibreAlongCurve("b")},
    "that plywood, G as if isotropic": {
        "stiffness": Stiffness(7930.0, 3440.0, 0.04, 3460.0, 142.0, 112.0),
        "fibre": ifs.FibreAlongCurve("a"),
    },
}


def _on(point: tuple[float, float, float], normal: tuple[float, float, float]) -> dict[str, Any]:
    return {"loads": ifs.AreaLoad(pressure=1500.0, on=ifs.Plane(point, normal))}


LOADS: dict[str, dict[str, Any]] = {
    "on all": {"loads": ifs.AreaLoad(pressure=1500.0)},
    "on a third of the span": _on((4000, 0, 0), (-1, 0, 0)),
    "on the half y < 4.5 m": _on((0, 4500, 0), (0, -1, 0)),
}
SUPPORTS: dict[str, dict[str, Any]] = {
    "ends clamped": {"supports": ifs.Support.border("a start", "a end", turn="xyz")},
    "all borders pinned": {"supports": ifs.Support.border()},
    "one end slides along x": {
        "supports": [ifs.Support.border("a start"), ifs.Support.border("a end", hold="yz")]
    },
}


class Row(NamedTuple):
    """What was changed, to what, and both deflections in mm."""

    kind: str
    value: str
    smooth: float
    rough: float

    @property
    def ratio(self) -> float:
        return self.smooth / self.rough


def rows() -> Iterator[Row]:
    """Compute all rows, the unchanged shells first."""
    shells = asked([run_script(PART, {})[0].assembly])

    def both(kind: str, value: str, **options: Any) -> Row:
        return Row(kind, value, *(_sag(*shells[name], options) for name in ("smooth", "rough")))

    plain = both("nothing", "")
    yield plain
    for fold in FOLDS:
        other = asked([run_script(PART, {"fold": str(fold)})[0].assembly])
        yield Row("fold height", f"{fold} mm", plain.smooth, _sag(*other["rough"], {}))
    for stiffness in SPRINGS:
        yield both("joints", f"{stiffness:g} N mm/rad per mm", joints=stiffness)
    yield both("joints", "rigid", joints="rigid")
    for kind, several in (("material", MATERIALS), ("load", LOADS), ("supports", SUPPORTS)):
        for value, options in several.items():
            yield both(kind, value, **options)


def _sag(shell: ifs.Shell, own: ifs.Analysis, options: dict[str, Any]) -> float:
    asked_for = {"loads": own.loads, "supports": own.supports, "divisions": 4} | options
    return analyse(shell, **asked_for).deflection.value


def draw(found: list[Row], path: str) -> None:
    """Draw the ratio against fold height and joints, and bars for all else."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(
        1, 3, figsize=(13, 4.2), width_ratios=(1, 1, 1.3), layout="constrained"
    )
    plain = found[0]
    folds = [row for row in found if row.kind == "fold height"]
    joints = [row for row in found if row.kind == "joints"]
    others = [row for row in found if row.kind in {"material", "load", "supports"}][::-1]
    axes[0].plot(FOLDS, [row.ratio for row in folds], "o-", color="#3b528b")
    axes[0].set(xlabel="height of the folds, mm", ylabel="smooth / rough")
    places = [10.0, *SPRINGS, RIGID]
    axes[1].plot(places, [plain.ratio, *(row.ratio for row in joints)], "o-", color="#3b528b")
    axes[1].set(xscale="log", xlabel="joints, N mm/rad per mm")
    axes[1].set_xticks(places, ["hinge", *(f"{one:g}" for one in SPRINGS), "rigid"])
    axes[1].minorticks_off()
    axes[1].tick_params(axis="x", labelsize=8)
    names = [f"{row.kind}: {row.value}" for row in others]
    bars = axes[2].barh(names, [row.ratio for row in others], color="#3b528b")
    axes[2].bar_label(bars, [_sags(row) for row in others], padding=3, fontsize=8)
    axes[2].set(xlabel="smooth / rough", xlim=(0, 1.6 * max(row.ratio for row in others)))
    axes[2].tick_params(axis="y", labelsize=8)
    for axis in axes[:2]:
        axis.axhline(PAPER, color="#c0392b", ls="--", lw=1)
        axis.set_ylim(bottom=0)
    axes[0].annotate("the paper, 17.7", (FOLDS[0], PAPER), (0, 4), textcoords="offset points")
    axes[2].axvline(PAPER, color="#c0392b", ls="--", lw=1)
    figure.savefig(path, dpi=110)


def _sags(row: Row) -> str:
    smooth, rough = (
        f"{sag:.0f}" if sag >= 100 else f"{sag:.1f}" for sag in (row.smooth, row.rough)
    )
    return f"{smooth} / {rough} mm"


def main(picture: str | None = None) -> None:
    """Print the table; draw the picture if asked for."""
    print("| changed | to | smooth, mm | rough, mm | ratio |")
    print("|---|---|---|---|---|")
    found = []
    for row in rows():
        found.append(row)
        text = f"| {row.kind} | {row.value} | {row.smooth:.1f} | {row.rough:.2f} |"
        print(f"{text} {row.ratio:.1f} |", flush=True)
    if picture is not None:
        draw(found, picture)


if __name__ == "__main__":
    main(*sys.argv[1:2])
