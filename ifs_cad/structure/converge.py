"""Quads as fine as they must be: a mesh is halved until that changes little.

The error that is left is estimated from the change itself: when errors shrink by a factor r with
every halving, what is left after a change c is c / (r - 1). Two meshes tell the change, three the
factor too. Until it is known it is taken as 2, the slowest that a sound element shows.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from ifs_cad.elements.panel import Shell
from ifs_cad.structure.load import Loads
from ifs_cad.structure.model import DIVISIONS, model_of
from ifs_cad.structure.result import MESH_ERROR, Result
from ifs_cad.structure.solver import Solver

FINEST = 16
LARGEST = 200_000
"""Degrees of freedom that a finer mesh may have: about 1.4 GB and half a minute."""
SLOWEST, FASTEST = 2.0, 4.0  # factors by which errors shrink, linear and quadratic convergence


def converged(
    shell: Shell,
    loads: Loads,
    *,
    close: float = MESH_ERROR,
    finest: int = FINEST,
    largest: int = LARGEST,
    **options: Any,
) -> Result:
    """Return the linear answer on a mesh that is fine enough, and how far it is off.

    Starts with half of `DIVISIONS` and with `DIVISIONS`; goes on until the estimated error of the
    largest displacement is small, or the next mesh would exceed `finest` or `largest`.

    Parameters
    ----------
    shell : Shell
    loads : a load, or several to be added
    close : float, error of the largest displacement that is good enough, as a share of it
    finest : int, most quads along each edge of a panel
    largest : int, most degrees of freedom of a mesh finer than `DIVISIONS`
    **options
        As for `model_of`, without `divisions`.

    Raises
    ------
    MechanismError, InputError, MissingLibraryError
        As for `analyse`.
    """
    loads = tuple(loads) if isinstance(loads, Iterable) else loads
    factor, former, divisions = SLOWEST, None, DIVISIONS
    coarse = Solver(model_of(shell, divisions=divisions // 2, **options))(loads)
    while True:
        fine = Solver(model_of(shell, divisions=divisions, **options))(loads)
        change = fine.largest_displacement.value - coarse.largest_displacement.value
        if former is not None and change:
            factor = min(max(former / change, SLOWEST), FASTEST)
        error = abs(change) / (factor - 1) / fine.largest_displacement.value
        divisions *= 2
        # points and nodes of the finer mesh grow no faster than its quads
        if error <= close or divisions > finest or 4 * fine.model.size > largest:
            return replace(fine, mesh_error=error)
        coarse, former = fine, change
