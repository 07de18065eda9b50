"""The structure check in one call.

`analyse` makes the model, as fine as it must be, and solves it. For several load cases make a
`Solver` and call it for each.
"""

from __future__ import annotations

from ifs_cad.elements.fibre import Fibre
from ifs_cad.elements.material import Stiffness
from ifs_cad.elements.panel import Shell
from ifs_cad.structure.converge import converged
from ifs_cad.structure.load import Loads
from ifs_cad.structure.model import Joints, model_of
from ifs_cad.structure.result import Result
from ifs_cad.structure.solver import Solver
from ifs_cad.structure.support import Supports


def analyse(
    shell: Shell,
    *,
    loads: Loads,
    supports: Supports = "standing",
    joints: Joints = "hinge",
    divisions: int | None = None,
    fibre: Fibre | None = None,
    stiffness: Stiffness | None = None,
) -> Result:
    """Return how a shell carries its loads, linearly.

    Parameters
    ----------
    shell : Shell
    loads : a load, or several to be added
        `SelfWeight()`, `AreaLoad(pressure=1500)`, `PointLoad(...)`, multiplied by factors.
    supports : Support, "standing", or several of them
    joints : "hinge", "rigid" or float, N mm/rad per mm of edge
    divisions : int, optional, quads along each edge of a panel
        By default as many as keep the estimated error of the largest displacement within 2 %:
        `Result.mesh_error` says what it is, see `converge`.
    fibre : Fibre, optional
        The rule for the fibre directions, instead of the shell's own.
    stiffness : Stiffness, optional
        Instead of that of the shell's material.

    Raises
    ------
    MechanismError
        The structure moves without resistance; says where, and what would hold it.
    InputError
        Something missing (loads, stiffness, fibre directions) or impossible.
    MissingLibraryError
        Kratos is not installed: `pip install 'ifs-cad[structure]'`.
    """
    if divisions is None:
        return converged(
            shell, loads, supports=supports, joints=joints, fibre=fibre, stiffness=stiffness
        )
    model = model_of(
        shell,
        supports=supports,
        joints=joints,
        divisions=divisions,
        fibre=fibre,
        stiffness=stiffness,
    )
    return Solver(model)(loads)
