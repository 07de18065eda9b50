"""Curved shells of flat panels against the obstacle course.

Source: T. Belytschko et al., "Stress projection for membrane and shear locking in shell finite
elements" (1985), as used since; R. H. MacNeal and R. L. Harder, "A proposed standard set of
problems to test finite element accuracy" (1985). Lengths, loads and moduli are those of the
sources, read as mm, N and MPa.
"""

import numpy as np
import pytest
from structures import cylinder

from ifs_cad.elements.material import Stiffness
from ifs_cad.structure.load import AreaLoad, PointLoad
from ifs_cad.structure.model import model_of
from ifs_cad.structure.solver import Solver
from ifs_cad.structure.support import Support


def test_scordelis_lo_roof_sags_by_its_known_amount():
    """MacNeal and Harder, 0.3024 at the middle of the free edge, at 16 x 16 quads a quarter."""
    shell = cylinder(25.0, 0.0, 40.0, 16, 25.0, 16, 0.25)
    model = model_of(
        shell,
        supports=[
            Support.border("b start", hold="xz"),  # the diaphragm
            Support.border("b end", hold="y", turn="xz"),  # symmetry along
            Support.border("a start", hold="x", turn="yz"),  # symmetry across
        ],
        joints="rigid",
        divisions=1,
        stiffness=Stiffness.isotropic(4.32e8, 0.0),
    )
    result = Solver(model)(AreaLoad(pressure=90e6, per="surface"))
    edge = 25.0 * np.array((np.sin(np.radians(40)), 1, np.cos(np.radians(40))))
    sag = -result.displacements[model.grid.nearest(edge), 2]
    assert sag == pytest.approx(0.3024, rel=0.01)


def test_pinched_cylinder_gives_way_by_its_known_amount():
    """Belytschko, 1.8248e-5 under the load, at 24 x 24 quads an eighth."""
    count = 24
    shell = cylinder(300.0, 0.0, 90.0, count, 300.0, count, 3.0)
    model = model_of(
        shell,
        supports=[
            Support.border("b start", hold="xz"),  # the diaphragm
            Support.border("b end", hold="y", turn="xz"),
            Support.border("a start", hold="x", turn="yz"),
            Support.border("a end", hold="z", turn="xy"),
        ],
        joints="rigid",
        divisions=1,
        stiffness=Stiffness.isotropic(3e6, 0.3),
    )
    top = (0.0, 300.0, 300.0)
    result = Solver(model)(PointLoad(force=(0, 0, -0.25), at=top))
    assert -result.displacements[model.grid.nearest(np.array(top)), 2] == pytest.approx(
        1.8248e-5, rel=0.02
    )
