"""How the deflections of figure 22, and their ratio, move with what the paper does not tell.

    python benchmarks/figure_22_sensitivity.py

Prints Markdown. Everything is `parts/figure_22.py` with one thing changed; 4 x 4 quads a panel.
"""

from __future__ import annotations

import itertools
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import ifs_cad as ifs
from ifs_cad.elements.material import SPRUCE_PLYWOOD, Stiffness
from ifs_cad.kernel.source import run_script
from ifs_cad.structure.analyse import analyse
from ifs_cad.structure.load import AreaLoad
from ifs_cad.structure.support import Support
from ifs_cad.workflow.analysis import shells_of

PART = Path(__file__).parent.parent / "parts" / "figure_22.py"
LOADED = ifs.Plane((6000, 0, 0), (-1, 0, 0))
FOLDS = (50, 100, 150, 200, 300, 400)
SPRINGS = (100.0, 1000.0, 10000.0)
MATERIALS: dict[str, dict[str, Any]] = {
    "isotropic, 7000 MPa": {"stiffness": Stiffness.isotropic(7000, 0.3)},
    "isotropic, 11000 MPa": {"stiffness": Stiffness.isotropic(11000, 0.3)},
    "spruce plywood, fibre along the span": {
        "stiffness": SPRUCE_PLYWOOD.stiffness,
        "fibre": ifs.FibreAlongCurve("a"),
    },
    "spruce plywood, fibre across": {
        "stiffness": SPRUCE_PLYWOOD.stiffness,
        "fibre": ifs.FibreAlongCurve("b"),
    },
}


def main() -> None:
    """Print the table."""
    print("| changed | smooth, mm | folded, mm | ratio |")
    print("|---|---|---|---|")
    for what, smooth, folded in rows():
        print(f"| {what} | {smooth:.1f} | {folded:.2f} | {smooth / folded:.1f} |", flush=True)


def rows() -> Iterator[tuple[str, float, float]]:
    """Compute what changed, and both deflections."""
    shells = shells_of([run_script(PART, {})[0].assembly])
    smooth, folded = shells["smooth"], shells["folded"]
    plain = _sag(smooth)
    yield "nothing", plain, _sag(folded)
    for fold in FOLDS:
        higher = shells_of([run_script(PART, {"fold": str(fold)})[0].assembly])["folded"]
        yield f"folds of {fold} mm", plain, _sag(higher)
    for joints in itertools.chain(SPRINGS, ["rigid"]):
        name = joints if isinstance(joints, str) else f"{joints:g} N mm/rad per mm"
        yield f"joints: {name}", _sag(smooth, joints=joints), _sag(folded, joints=joints)
    for name, options in MATERIALS.items():
        yield name, _sag(smooth, **options), _sag(folded, **options)


def _sag(shell: ifs.Shell, **options: Any) -> float:
    load = AreaLoad(pressure=1500.0, on=LOADED)
    held = Support.border("a start", "a end")
    return analyse(shell, loads=load, supports=held, **options).deflection.value


if __name__ == "__main__":
    sys.exit(main())
