"""(l) The structure check: seconds and memory, beside the solution of its equations alone."""

from __future__ import annotations

import subprocess
import sys
import time

from memory import peak
from table import Line

LIMITS = {4: 5.0, 5: 25.0}  # s, by depth: 256 and 1024 panels


def measure(letter: str) -> list[Line]:
    """Measure both sizes, each in a Python of its own, so that peaks are their own."""
    lines = []
    for depth, limit in LIMITS.items():
        answer = subprocess.run(
            [sys.executable, __file__, str(depth)], capture_output=True, text=True, check=True
        )
        seconds, solution, before, most = (float(number) for number in answer.stdout.split())
        what = f"structure check of {4**depth:,} hinged panels, 4 x 4 quads each"
        against = f"{solution:.3g} s to factorise and solve once, SciPy alone"
        lines.append(Line(letter, what, f"{seconds:.3g} s", against, seconds, " s", limit))
        lines.append(
            Line(
                letter,
                f"the same, against that solution ({4**depth:,} panels)",
                f"{seconds:.3g} s",
                against,
                seconds / solution,
                " x",
            )
        )
        lines.append(
            Line(
                letter,
                f"peak memory of the same ({4**depth:,} panels)",
                f"{most:.0f} MB",
                f"{before:.0f} MB after the imports",
                most - before,
                " MB more",
            )
        )
    return lines


def _shell(depth: int) -> object:
    import ifs_cad as ifs

    along = ifs.Curve([(0, 0, 0), (6000, 0, 5000), (12000, 0, 0)], depth=depth)
    across = ifs.Curve([(0, 0, 0), (0, 4500, 2000), (0, 9000, 0)], depth=depth).points.copy()
    across[1::2, 2] += 4000.0 / 2**depth
    return ifs.thicken(ifs.vector_sum(along, across), 20.0)


def _main(depth: int) -> None:
    from ifs_cad.elements.material import Stiffness
    from ifs_cad.structure.kratos import load_kratos
    from ifs_cad.structure.load import AreaLoad, total_forces
    from ifs_cad.structure.model import model_of
    from ifs_cad.structure.solve import factor
    from ifs_cad.structure.solver import Solver
    from ifs_cad.structure.support import Support

    load_kratos()
    shell, load = _shell(depth), AreaLoad(pressure=1500.0)
    before = peak()
    begin = _now()
    model = model_of(
        shell,
        supports=Support.border("a start", "a end"),
        stiffness=Stiffness.isotropic(9000.0, 0.3),
    )
    Solver(model)(load)
    seconds, most = _since(begin), peak()
    forces = model.vector(total_forces(load, model.grid, model.surface_weight))[model.free]
    matrix = model.matrix[model.free][:, model.free]
    begin = _now()
    factor(matrix).solve(forces)
    print(seconds, _since(begin), before, most)


def _now() -> tuple[float, float]:
    return time.perf_counter(), time.process_time()


def _since(begin: tuple[float, float]) -> float:
    """Return the smaller of wall and processor time, s, as `timing` does."""
    return min(end - start for start, end in zip(begin, _now(), strict=True))


if __name__ == "__main__":
    _main(int(sys.argv[1]))
