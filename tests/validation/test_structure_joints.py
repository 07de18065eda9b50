"""Hinges, springs and mechanisms against statics done by hand.

Sources: equilibrium of bars and beams, and the count of freedoms of linkages (degrees of freedom
less constraints), as in any text on statics; the hinge stiffness formulas of S. Timoshenko,
*Strength of Materials* (1930).
"""

import numpy as np
import pytest
from structures import SLENDER, TIMBER, cylinder, mesh_shell, shell_of, strip

import ifs_cad as ifs
from ifs_cad.errors import MechanismError
from ifs_cad.structure.analyse import analyse
from ifs_cad.structure.load import AreaLoad, PointLoad, SelfWeight
from ifs_cad.structure.model import model_of
from ifs_cad.structure.solve import Factors
from ifs_cad.structure.solver import Solver
from ifs_cad.structure.support import Support

ENDS = Support.border("a start", "a end")


def mechanisms(shell, supports, **options):
    """How many movements meet no resistance, and how many of them are rigid."""
    model = model_of(shell, supports=supports, stiffness=TIMBER, **options)
    modes, rigid = Factors(model).mechanisms()
    return modes.shape[1], rigid


def line_load(force, x, z, width, points=4):
    """A vertical force spread over a line across a strip as over a mesh of `points` quads."""
    shares = np.full(points + 1, 1 / points)
    shares[[0, -1]] /= 2
    places = np.linspace(0, width, points + 1)
    return [
        PointLoad(force=(0, 0, -force * share), at=(x, y, z))
        for y, share in zip(places, shares, strict=True)
    ]


@pytest.mark.parametrize("angle", [15.0, 30.0, 60.0])
def test_three_hinged_arch_gives_way_as_two_bars(angle):
    """w = P L / (2 E A sin^2 a) at the crown, the two panels being bars under compression."""
    length, width, thickness, force = 500.0, 200.0, 20.0, 1e4
    x, z = length * np.cos(np.radians(angle)), length * np.sin(np.radians(angle))
    shell = shell_of([(-x, 0, 0), (0, 0, z), (x, 0, 0)], [(0, 0, 0), (0, width, 0)], thickness)
    # lines in whose middle no panel bends: without contraction they stay straight
    loads = line_load(force, 0, z, width)
    result = analyse(shell, loads=loads, supports=ENDS, divisions=4, stiffness=SLENDER)
    area = width * thickness
    expected = force * length / (2 * 9000 * area * np.sin(np.radians(angle)) ** 2)
    assert result.deflection.value == pytest.approx(expected, rel=1e-6)
    np.testing.assert_allclose(
        result.resultants[:, 0] * width,
        -force / (2 * np.sin(np.radians(angle))),
        rtol=1e-6,
    )


def test_gerber_beam_sags_at_its_hinge():
    """A cantilever that carries, over a hinge, the end of a simple beam: w = P a^3 / (3 EI)."""
    arm, span, width, thickness, force = 800.0, 500.0, 100.0, 20.0, 100.0
    beam = [(0, 0, 0), (arm, 0, 0), (arm + span, 0, 0)]
    shell = shell_of(beam, [(0, 0, 0), (0, width, 0)], thickness)
    result = analyse(
        shell,
        loads=line_load(force, arm, 0, width, points=16),
        supports=[Support.border("a start", turn="xyz"), Support.border("a end", hold="z")],
        divisions=16,
        stiffness=SLENDER,
    )
    inertia = width * thickness**3 / 12
    assert result.deflection.value == pytest.approx(force * arm**3 / (3 * 9000 * inertia), rel=0.01)
    assert result.reactions[0].force[2] == pytest.approx(force, rel=1e-6)
    assert result.reactions[1].force[2] == pytest.approx(0, abs=1e-6 * force)


@pytest.mark.parametrize("share", [0.1, 1.0, 10.0])
def test_spring_at_midspan_adds_its_turning(share):
    """w = P L^3 / (48 EI) + P L^2 / (16 k): a simple beam cut in the middle by a spring."""
    length, width, thickness, force = 1000.0, 100.0, 10.0, 50.0
    rigidity = 9000 * width * thickness**3 / 12
    spring = share * rigidity / length  # N mm/rad
    result = analyse(
        strip(length, width, thickness, panels=2),
        loads=line_load(force, length / 2, 0, width, points=8),
        supports=[Support.border("a start"), Support.border("a end", hold="yz")],
        joints=spring / width,
        divisions=8,
        stiffness=SLENDER,
    )
    expected = force * length**3 / (48 * rigidity) + force * length**2 / (16 * spring)
    assert result.deflection.value == pytest.approx(expected, rel=0.01)


def test_joint_of_endless_stiffness_is_a_rigid_joint():
    """And stiffness zero is a hinge; in between, a stiffer joint sags less. At 8 x 8."""
    arch = ifs.Curve([(0, 0, 0), (1500, 0, 1200), (3000, 0, 0)], depth=2)
    fold = [(0, 0, 0), (0, 300, 80), (0, 600, 0), (0, 900, 80), (0, 1200, 0)]
    shell = shell_of(arch.points, fold, 12.0)
    sags = [
        analyse(
            shell,
            loads=[SelfWeight(), AreaLoad(pressure=1500, on=ifs.Plane((1500, 0, 0), (-1, 0, 0)))],
            supports=ENDS,
            joints=joints,
            divisions=8,
            stiffness=TIMBER,
        ).deflection.value
        for joints in ("hinge", 0.0, 1e3, 1e5, 1e9, "rigid")
    ]
    assert sags[0] == sags[1]
    assert sags[1] > sags[2] > sags[3] > sags[4]
    assert sags[4] == pytest.approx(sags[5], rel=0.01)


@pytest.mark.parametrize("divisions", [1, 2, 4])
def test_free_panel_moves_in_six_ways(divisions):
    """Three displacements and three rotations; the element adds none of its own."""
    assert mechanisms(strip(500, 300, 10), [], divisions=divisions) == (6, 6)


@pytest.mark.parametrize("depth", [1, 2, 3])
def test_free_shell_of_four_valent_nodes_has_one_flex(depth):
    """A smooth vector sum of hinged quads folds in one way; with its ends pinned in none."""
    arch = ifs.Curve([(0, 0, 0), (0, 0, 2000), (4500, 0, 2000), (4500, 0, 0)], depth=depth)
    across = ifs.Curve([(0, 0, 0), (0, 1500, 400), (0, 3000, 0)], depth=depth)
    shell = shell_of(arch, across, 10.0)
    assert mechanisms(shell, []) == (7, 6)
    assert mechanisms(shell, ENDS) == (0, 0)


@pytest.mark.parametrize("strips", [4, 7, 12])
def test_hinged_cylinder_is_a_linkage_of_its_strips(strips):
    """N bars between two fixed points have 2 (N - 1) freedoms less N lengths: N - 2; a ring of N
    has 2 N - N less the 3 of a rigid body in its plane: N - 3.
    """
    vault = cylinder(1000.0, -80.0, 80.0, strips, 700.0, 1, 10.0)
    assert mechanisms(vault, ENDS) == (strips - 2, 0)
    ring = cylinder(1000.0, 0.0, 360.0, strips, 700.0, 1, 10.0)
    assert mechanisms(ring, []) == (6 + strips - 3, 6)


def test_mechanism_is_named_and_what_it_says_to_hold_stops_it():
    """A vault of four hinged strips on pinned edges has two flexes."""
    shell = cylinder(1000.0, -80.0, 80.0, 4, 700.0, 1, 10.0)
    with pytest.raises(MechanismError, match=r"in 2 ways \(2 by folding at its hinges\)") as caught:
        analyse(shell, loads=SelfWeight(), supports=ENDS, stiffness=TIMBER)
    error = caught.value
    assert error.values["count"] == 2
    assert set(error.addresses) <= set(shell.addresses)
    holds = [Support.nodes(place, hold=axis) for place, axis in error.values["holding"]]
    assert mechanisms(shell, [ENDS, *holds]) == (0, 0)


def test_mechanism_is_found_under_a_load_that_does_not_move_it():
    """Symmetric load on a square of four bars' sway: still no answer, but the error."""
    shell = cylinder(1000.0, -60.0, 60.0, 3, 700.0, 1, 10.0)
    model = model_of(shell, supports=ENDS, stiffness=TIMBER)
    with pytest.raises(MechanismError, match="in 1 way "):
        Solver(model)(PointLoad(force=(0, 1, 0), at=(0, 0, 1000)))


def test_hinged_triangles_around_a_node_carry():
    """A pyramid of four triangles on pinned corners is a truss of four bars and more."""
    height, side, force = 300.0, 400.0, 1000.0
    corners = [(-side, -side, 0), (side, -side, 0), (side, side, 0), (-side, side, 0)]
    points = [*corners, (0, 0, height)]
    shell = mesh_shell(points, [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)], 10.0)
    result = analyse(
        shell,
        loads=PointLoad(force=(0, 0, -force), at=points[4]),
        supports=Support.border(),
        stiffness=TIMBER,
    )
    assert result.reactions[0].force == pytest.approx((0, 0, force), abs=1e-6 * force)
