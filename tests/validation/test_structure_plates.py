"""Plates and patches against closed forms.

Sources: B. M. Irons and A. Razzaque, "Experience with the patch test" (1972); S. Timoshenko and
S. Woinowsky-Krieger, *Theory of Plates and Shells*, 2nd ed. (1959), articles 10, 30 and 85; R. D.
Blevins, *Formulas for Natural Frequency and Mode Shape* (1979), table 11-4.
"""

import numpy as np
import pytest
from structures import PLYWOOD, SLENDER, TIMBER, mesh_shell, strip

from ifs_cad.elements.fibre import FibreTowards
from ifs_cad.elements.material import Stiffness
from ifs_cad.structure.analyse import analyse
from ifs_cad.structure.load import AreaLoad, PointLoad
from ifs_cad.structure.model import model_of
from ifs_cad.structure.modes import natural_frequencies
from ifs_cad.structure.solver import Solver
from ifs_cad.structure.support import Support

LENGTH, WIDTH, THICKNESS = 240.0, 120.0, 6.0
# MacNeal and Harder's patch: a rectangle of five quads whose inner corners sit askew.
PATCH = [(0, 0), (240, 0), (240, 120), (0, 120), (40, 20), (180, 30), (160, 80), (80, 80)]
PATCH_FACES = [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (4, 5, 6, 7)]
SQUARE = 1000.0


def patch():
    return mesh_shell([(x, y, 0) for x, y in PATCH], PATCH_FACES, THICKNESS)


def hard_supports():
    """Edges held as Kirchhoff's simply supported plate is: no twist along them either."""
    return [
        Support.border("a start", "a end", hold="z", turn="x"),
        Support.border("b start", "b end", hold="z", turn="y"),
        Support.nodes([(0, 0, 0)], hold="xy"),
        Support.nodes([(SQUARE, 0, 0)], hold="y"),
    ]


@pytest.mark.parametrize("angle", [0.0, 30.0, 90.0])
def test_membrane_patch_has_the_stress_and_the_modulus_of_a_sheet_turned(angle):
    """Irons and Razzaque; modulus off the fibre after Timoshenko, article 85."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    model = model_of(
        patch(),
        supports=[
            Support.nodes((0, 0, 0)),
            Support.nodes((0, 120, 0), hold="xz"),
            Support.nodes((240, 0, 0), hold="z"),
        ],
        joints="rigid",
        divisions=1,
        fibre=FibreTowards((c, s, 0)),
        stiffness=PLYWOOD,
    )
    pull = 600.0
    ends = [PointLoad(force=(pull, 0, 0), at=(240, y, 0)) for y in (0, 120)]
    ends += [PointLoad(force=(-pull, 0, 0), at=(0, y, 0)) for y in (0, 120)]
    result = Solver(model)(ends)
    force = 2 * pull / WIDTH
    expected = force * np.array([c * c, s * s, -c * s])
    np.testing.assert_allclose(
        result.resultants[:, :3], np.tile(expected, (5, 1)), atol=1e-9 * force
    )
    p = PLYWOOD
    soft = c**4 / p.e_along + s**4 / p.e_across
    soft += c**2 * s**2 * (1 / p.g_plane - 2 * p.poisson / p.e_along)
    stretch = force / THICKNESS * soft * LENGTH
    corner = model.grid.nearest(np.array((240, 0, 0)))
    assert result.displacements[corner, 0] == pytest.approx(stretch, rel=1e-9)


@pytest.mark.parametrize("strain", range(3, 6))
def test_bending_patch_balances_at_inner_nodes_under_constant_curvature(strain):
    """Irons and Razzaque: nodes moved by a constant curvature need no force inside."""
    model = model_of(patch(), joints="rigid", divisions=1, stiffness=TIMBER)
    x, y = model.grid.nodes[:, 0], model.grid.nodes[:, 1]
    moved = np.zeros((len(x), 6))
    k = 1e-4
    if strain == 3:
        moved[:, 2], moved[:, 4] = -k * x**2 / 2, k * x
    elif strain == 4:
        moved[:, 2], moved[:, 3] = -k * y**2 / 2, -k * y
    else:
        moved[:, 2], moved[:, 3], moved[:, 4] = -k * x * y / 2, -k * x / 2, k * y / 2
    vector = np.zeros(model.size)
    vector[model.freedoms] = moved
    forces = (model.matrix @ vector)[model.freedoms]
    inner = (x > 0) & (x < LENGTH) & (y > 0) & (y < WIDTH)
    assert inner.sum() == 12  # four points, three panels at each
    assert np.abs(forces[inner]).max() <= 1e-9 * np.abs(forces).max()


@pytest.mark.parametrize("thickness", [5.0, 10.0, 20.0])
def test_simply_supported_plate_sags_as_navier_says(thickness):
    """Timoshenko, article 30: w = 0.00406 q a^4 / D, at 16 x 16 quads."""
    result = analyse(
        strip(SQUARE, SQUARE, thickness),
        loads=AreaLoad(pressure=1000),
        supports=hard_supports(),
        divisions=16,
        stiffness=TIMBER,
    )
    rigidity = 9000 * thickness**3 / 12 / (1 - 0.3**2)
    assert result.deflection.value == pytest.approx(
        0.00406235 * 1e-3 * SQUARE**4 / rigidity, rel=0.01
    )


@pytest.mark.parametrize("fibre", [(1, 0, 0), (0, 1, 0)])
def test_orthotropic_plate_sags_as_navier_says(fibre):
    """Timoshenko, article 85, equation (i), on a rectangle of 20 x 14 square quads."""
    thickness, width, p = 4.0, 700.0, PLYWOOD
    supports = [
        Support.border("a start", "a end", hold="z", turn="x"),
        Support.border("b start", "b end", hold="z", turn="y"),
        Support.nodes([(0, 0, 0)], hold="xy"),
        Support.nodes([(SQUARE, 0, 0)], hold="y"),
    ]
    result = analyse(
        strip(SQUARE, width, thickness, panels=10, across=7),
        loads=AreaLoad(pressure=1000),
        supports=supports,
        joints="rigid",
        divisions=2,
        fibre=FibreTowards(fibre),
        stiffness=p,
    )
    whole = 1 - p.poisson**2 * p.e_across / p.e_along
    cube = thickness**3 / 12
    along, across = p.e_along / whole * cube, p.e_across / whole * cube
    mixed = p.poisson * across + 2 * p.g_plane * cube
    dx, dy = (along, across) if fibre[0] else (across, along)
    m, n = np.meshgrid(np.arange(1, 40, 2), np.arange(1, 40, 2))
    bottom = dx * (m / SQUARE) ** 4 + 2 * mixed * (m * n / SQUARE / width) ** 2
    bottom = m * n * (bottom + dy * (n / width) ** 4)
    signs = (-1.0) ** ((m + n) // 2 - 1)
    sag = 16e-3 / np.pi**6 * (signs / bottom).sum()
    assert result.deflection.value == pytest.approx(sag, rel=0.01)


def test_square_panel_twists_as_its_shear_modulus_says():
    """Timoshenko, article 11: corner forces make pure twist; w = 3 P a^2 / (G t^3) at the free
    corner of a panel held at the other three. This movement governs hinged shells. At 16 x 16.
    """
    side, thickness, force = 600.0, 4.0, 3.0
    result = analyse(
        strip(side, side, thickness),
        loads=PointLoad(force=(0, 0, -force), at=(side, side, 0)),
        supports=[
            Support.nodes((0, 0, 0)),
            Support.nodes((side, 0, 0), hold="yz"),
            Support.nodes((0, side, 0), hold="z"),
        ],
        divisions=16,
        stiffness=TIMBER,
    )
    shear = 9000 / 2.6
    expected = 3 * force * side**2 / (shear * thickness**3)
    assert result.deflection.value == pytest.approx(expected, rel=0.01)
    twist = np.average(result.resultants[:, 5], weights=result.model.grid.areas)
    assert abs(twist) == pytest.approx(force / 2, rel=1e-6)


def test_panel_whose_veneers_roll_twists_by_its_plane_shear_modulus():
    """The same though planar moduli are a fifth of that in the plane, as those of plywood are: a
    thin panel does not feel them, and coarse quads must not either. At 8 x 8.
    """
    side, thickness, force = 600.0, 4.0, 3.0
    corner = PointLoad(force=(0, 0, -force), at=(side, side, 0))
    result = analyse(
        strip(side, side, thickness),
        loads=corner,
        supports=[
            Support.nodes((0, 0, 0)),
            Support.nodes((side, 0, 0), hold="yz"),
            Support.nodes((0, side, 0), hold="z"),
        ],
        divisions=8,
        fibre=FibreTowards((1, 0, 0)),
        stiffness=Stiffness(8000, 3500, 0.04, 700, 140, 110),
    )
    expected = 3 * force * side**2 / (700 * thickness**3)
    assert result.deflection.value == pytest.approx(expected, rel=0.025)


def test_plate_swings_as_blevins_says():
    """Blevins, table 11-4: f = pi / a^2 sqrt(D / (rho t)), at 16 x 16 quads."""
    thickness = 10.0
    modes = natural_frequencies(
        strip(SQUARE, SQUARE, thickness),
        3,
        supports=hard_supports(),
        divisions=16,
        stiffness=TIMBER,
    )
    rigidity = 9000 * thickness**3 / 12 / (1 - 0.3**2)
    first = np.pi / SQUARE**2 * np.sqrt(rigidity / (450e-12 * thickness))
    assert modes.frequencies[0] == pytest.approx(first, rel=0.01)
    assert modes.frequencies[1:] == pytest.approx([2.5 * first] * 2, rel=0.01)


def test_plate_of_triangles_sags_as_one_of_quads():
    """Timoshenko, article 30, on a square of eight triangles, split from their centroids."""
    thickness, side = 10.0, SQUARE
    points = [(x, y, 0) for x in (0, side / 2, side) for y in (0, side / 2, side)]
    faces = [(0, 3, 4), (0, 4, 1), (1, 4, 5), (1, 5, 2), (3, 6, 7), (3, 7, 4), (4, 7, 8), (4, 8, 5)]
    result = analyse(
        mesh_shell(points, faces, thickness),
        loads=AreaLoad(pressure=1000),
        supports=[
            Support.where(lambda at: at[:, 0] % side == 0, hold="z", turn="x"),
            Support.where(lambda at: at[:, 1] % side == 0, hold="z", turn="y"),
            Support.nodes([(0, 0, 0)], hold="xy"),
            Support.nodes([(side, 0, 0)], hold="y"),
        ],
        joints="rigid",
        divisions=12,
        stiffness=TIMBER,
    )
    rigidity = 9000 * thickness**3 / 12 / (1 - 0.3**2)
    assert result.deflection.value == pytest.approx(0.00406235e-3 * side**4 / rigidity, rel=0.01)


def test_clamped_strip_bends_as_a_beam():
    """Euler and Bernoulli: w = q L^4 / (8 EI); the moment at the root is q L^2 / 2."""
    length, width, thickness = 1000.0, 100.0, 10.0
    result = analyse(
        strip(length, width, thickness, panels=8),
        loads=AreaLoad(pressure=100),
        supports=Support.border("a start", turn="xyz"),
        joints="rigid",
        stiffness=SLENDER,
        fibre=FibreTowards((1, 0, 0)),
    )
    load = 100e-6  # N/mm2
    expected = load * length**4 / (8 * 9000 * thickness**3 / 12)
    assert result.deflection.value == pytest.approx(expected, rel=0.01)
    centres = result.model.grid.corners.mean(axis=1)[:, 0]
    moments = load * (length - centres) ** 2 / 2  # the outer face is pulled
    np.testing.assert_allclose(result.resultants[:, 3], moments, atol=0.01 * load * length**2 / 2)


def test_isotropic_material_knows_no_fibre():
    """The same answer whichever way the fibre runs."""
    stiffness = Stiffness.isotropic(9000, 0.3)
    values = [
        analyse(
            strip(400, 300, 8),
            loads=AreaLoad(pressure=500),
            supports=Support.border(),
            fibre=FibreTowards(fibre),
            stiffness=stiffness,
        ).deflection.value
        for fibre in ((1, 0, 0), (1, 2, 0))
    ]
    assert values[0] == pytest.approx(values[1], rel=1e-9)
