"""What a design wants to know of itself: its loads, its supports, its joints.

A part script carries it in the metadata of an assembly, for all shells in it:

    question = ifs.Analysis(ifs.AreaLoad(pressure=1500), ifs.Support.border("a start", "a end"))
    assembly = cq.Assembly(name="both", metadata={"analysis": question})

`ifs-cad analyse` answers it without further options.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from ifs_cad.errors import InputError
from ifs_cad.structure.load import AreaLoad, Loads
from ifs_cad.structure.model import Joints
from ifs_cad.structure.support import Supports, read_supports

KEY = "analysis"
"""Under which the metadata of an assembly has it."""
PRESSURE = 1500.0  # N/m2, figure 22


@dataclass(frozen=True)
class Analysis:
    """Loads, supports and joints, for instance of a part.

    Parameters
    ----------
    loads : a load, or several to be added; 1500 N/m2 of the ground plan by default
    supports : Support, "standing", or several of them
    joints : "hinge", "rigid" or float, N mm/rad per mm of edge

    Raises
    ------
    InputError
        No load, or a support that is none.
    """

    loads: Loads = field(default_factory=lambda: AreaLoad(pressure=PRESSURE))
    supports: Supports = "standing"
    joints: Joints = "hinge"

    def __post_init__(self) -> None:
        loads = tuple(self.loads) if isinstance(self.loads, Iterable) else (self.loads,)
        if not loads or not all(hasattr(load, "forces") for load in loads):
            raise InputError(f"An analysis needs loads, such as SelfWeight(); got {self.loads!r}.")
        object.__setattr__(self, "loads", loads)
        object.__setattr__(self, "supports", read_supports(self.supports))
