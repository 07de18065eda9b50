"""Equilibrium in the deformed shape against exact solutions.

Sources: K. Mattiasson, "Numerical results from large deflection beam and frame problems analysed
by means of elliptic integrals" (1981); R. von Mises, "Ueber die Stabilitaetsprobleme der
Elastizitaetstheorie" (1923); L. Euler (1744).
"""

import numpy as np
import pytest
from structures import SLENDER, TIMBER, shell_of, strip

from ifs_cad.errors import InstabilityError
from ifs_cad.structure.corotation import corotation_of, rotation_matrices, rotation_vectors
from ifs_cad.structure.kratos import shell_stiffness
from ifs_cad.structure.load import PointLoad
from ifs_cad.structure.model import model_of
from ifs_cad.structure.nonlinear import analyse_nonlinear, deform
from ifs_cad.structure.solver import Solver
from ifs_cad.structure.support import Support

LENGTH, WIDTH = 1000.0, 100.0


def across(force, x, z, points=1):
    """A force spread over a line across a strip as over a mesh of `points` quads."""
    shares = np.full(points + 1, 1 / points)
    shares[[0, -1]] /= 2
    return [
        PointLoad(force=tuple(share * np.array(force)), at=(x, y, z))
        for y, share in zip(np.linspace(0, WIDTH, points + 1), shares, strict=True)
    ]


@pytest.mark.parametrize(
    ("load", "down", "back"),
    [(1, 0.30172, 0.05643), (4, 0.66996, 0.32894), (10, 0.81061, 0.55500)],
)
def test_cantilever_bends_as_the_elastica(load, down, back):
    """Mattiasson: tip of a cantilever under P = load EI / L^2, at 20 quads."""
    thickness = 10.0
    model = model_of(
        strip(LENGTH, WIDTH, thickness, panels=20),
        supports=Support.border("a start", turn="xyz"),
        joints="rigid",
        divisions=1,
        stiffness=SLENDER,
    )
    force = load * 9000 * WIDTH * thickness**3 / 12 / LENGTH**2
    result = deform(model, across((0, 0, -force), LENGTH, 0), steps=8)
    assert result.deflection.value == pytest.approx(down * LENGTH, rel=2e-3)
    assert -result.displacements[:, 0].min() == pytest.approx(back * LENGTH, rel=2e-3)
    assert result.imbalance <= 1e-4 * force


def mises_truss():
    """Two panels hinged at a low ridge, and the load under which they would snap through."""
    half, rise, thickness = 500.0, 25.0, 30.0
    shell = shell_of(
        [(0, 0, 0), (half, 0, rise), (2 * half, 0, 0)], [(0, 0, 0), (0, WIDTH, 0)], thickness
    )
    model = model_of(
        shell, supports=Support.border("a start", "a end"), divisions=2, stiffness=SLENDER
    )
    sag = np.linspace(0, rise, 4001)
    before, now = np.hypot(half, rise), np.hypot(half, rise - sag)
    load = 2 * 9000 * WIDTH * thickness * (before - now) / before * (rise - sag) / now
    return model, (half, rise), sag[: load.argmax() + 1], load[: load.argmax() + 1]


@pytest.mark.parametrize("share", [0.3, 0.8, 0.95])
def test_low_arch_of_two_panels_sags_as_von_mises_says(share):
    """2 E A (l0 - l) / l0 * h / l; the linear answer is up to 43 % off."""
    model, (x, z), sags, loads = mises_truss()
    force = share * loads[-1]
    result = deform(model, across((0, 0, -force), x, z, points=2))
    assert result.nonlinear
    assert result.deflection.value == pytest.approx(np.interp(force, loads, sags), rel=1e-4)


def test_low_arch_snaps_through_at_the_load_of_von_mises():
    model, (x, z), sags, loads = mises_truss()
    force = 1.25 * loads[-1]
    with pytest.raises(InstabilityError, match="buckles or snaps through") as caught:
        deform(model, across((0, 0, -force), x, z, points=2), steps=10)
    reached = 1.25 * caught.value.values["load_share"]
    assert reached == pytest.approx(1, abs=0.01)
    sag = np.interp(reached * loads[-1], loads, sags)
    # where loads are all but level, a load 1e-4 too high is a sag 1e-3 too large
    assert caught.value.values["deflection"] == pytest.approx(sag, rel=5e-3)


def test_straight_strut_buckles_at_the_load_of_euler():
    """pi^2 EI / L^2, found though nothing pushes the strut aside."""
    thickness = 10.0
    euler = np.pi**2 * 9000 * WIDTH * thickness**3 / 12 / LENGTH**2
    with pytest.raises(InstabilityError) as caught:
        analyse_nonlinear(
            strip(LENGTH, WIDTH, thickness, panels=16),
            loads=across((-1.25 * euler, 0, 0), LENGTH, 0),
            supports=[Support.border("a start"), Support.border("a end", hold="yz")],
            joints="rigid",
            divisions=1,
            stiffness=SLENDER,
            steps=10,
        )
    assert 1.25 * caught.value.values["load_share"] == pytest.approx(1, abs=0.01)


def test_small_load_gives_the_linear_answer():
    model = model_of(
        strip(LENGTH, WIDTH, 10.0, panels=2),
        supports=[Support.border("a start"), Support.border("a end", hold="yz")],
        joints=50.0,
        stiffness=TIMBER,
    )
    loads = across((0, 0, -1e-3), LENGTH / 2, 0, points=4)
    linear, large = Solver(model)(loads), deform(model, loads, steps=1)
    assert large.deflection.value == pytest.approx(linear.deflection.value, rel=1e-5)
    np.testing.assert_allclose(
        large.resultants, linear.resultants, atol=1e-4 * np.abs(linear.resultants).max()
    )


def test_quad_carried_along_is_not_strained():
    corners = np.array([[(0, 0, 0), (100, 0, 0), (110, 90, 0), (0, 80, 0)]], dtype=float)
    quads = corotation_of(corners, shell_stiffness(corners, 10.0, TIMBER, np.zeros(1)))
    turn = rotation_matrices(np.array((1.0, -2.0, 0.5)))
    state = quads.state(corners @ turn.T + 700, np.tile(turn, (1, 4, 1, 1)))
    assert np.abs(state.strained).max() <= 1e-11
    assert np.linalg.norm(rotation_vectors(turn) - (1.0, -2.0, 0.5)) <= 1e-12


def test_forces_of_a_quad_are_the_slope_of_its_energy_and_the_tangent_theirs():
    """Central differences about a quad that is bent, warped and turned."""
    random = np.random.default_rng(1)
    corners = np.array([[(0, 0, 0), (100, 0, 0), (110, 90, 0), (0, 80, 0)]], dtype=float)
    matrix = shell_stiffness(corners, 10.0, TIMBER, np.zeros(1))
    quads = corotation_of(corners, matrix)
    turn = rotation_matrices(np.array((1.0, -2.0, 0.5)))
    places = (corners + random.normal(size=(1, 4, 3))) @ turn.T
    rotations = turn @ rotation_matrices(0.02 * random.normal(size=(1, 4, 3)))
    here = quads.state(places, rotations)

    def moved(freedom, by):
        change = np.zeros((4, 2, 3))
        change.flat[freedom] = by
        return quads.state(places + change[:, 0], rotation_matrices(change[:, 1]) @ rotations)

    def energy(state):
        return state.strained[0] @ matrix[0] @ state.strained[0] / 2

    size = np.sqrt(np.diag(matrix[0]))
    slope, tangent = np.empty(24), np.empty((24, 24))
    for freedom in range(24):
        by = 1e-4 if freedom // 3 % 2 == 0 else 1e-6
        more, less = moved(freedom, by), moved(freedom, -by)
        slope[freedom] = (energy(more) - energy(less)) / (2 * by)
        tangent[:, freedom] = (more.forces[0] - less.forces[0]) / (2 * by)
    forces = here.forces[0] / size
    assert np.abs(slope / size - forces).max() <= 1e-6 * np.abs(forces).max()
    symmetric = (tangent + tangent.T) / 2
    error = (here.tangents[0] - symmetric) / np.outer(size, size)
    assert np.abs(error).max() <= 1e-3
