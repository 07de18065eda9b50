"""From a shell to a finite element model: surface, grid, supports, loads, fibres, material."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from structures import PLYWOOD, TIMBER, mesh_shell, shell_of, strip
from vaults import GROUND, hexagon, vault

import ifs_cad as ifs
from ifs_cad.elements.fibre import FibreTowards
from ifs_cad.elements.material import SPRUCE_PLYWOOD, Material, Stiffness, Strength
from ifs_cad.errors import AddressError, InputError
from ifs_cad.structure.grid import divide
from ifs_cad.structure.load import AreaLoad, PointLoad, SelfWeight, total_forces
from ifs_cad.structure.model import model_of
from ifs_cad.structure.support import Support
from ifs_cad.structure.surface import surface_of

# A square, a triangle and a pentagon that share edges.
MIXED = [
    (0, 0, 0),
    (10, 0, 0),
    (10, 10, 0),
    (0, 10, 0),
    (20, 5, 0),
    (9, 17, 0),
    (5, 20, 0),
    (0, 16, 0),
]
MIXED_FACES = [(0, 1, 2, 3), (1, 4, 2), (3, 2, 5, 6, 7)]


def held_nodes(shell, support, divisions=2):
    """Places of the nodes that a support holds."""
    surface = surface_of(shell)
    grid = divide(surface.mesh, divisions)
    return grid.nodes[support.select(surface, grid)]


@pytest.mark.parametrize("divisions", [2, 4, 6])
def test_grid_of_mixed_polygons_matches_along_every_edge(divisions):
    mesh = ifs.Mesh(MIXED, MIXED_FACES)
    grid = divide(mesh, divisions)
    steps = np.linspace(0, 1, divisions + 1)[None, :, None]
    along = mesh.positions[:, None] + steps * mesh.edge_vectors[:, None]
    np.testing.assert_allclose(grid.nodes[grid.edges], along, atol=1e-12)
    places = np.full((grid.points, 3), np.nan)
    places[grid.point] = grid.nodes
    np.testing.assert_allclose(places[grid.point], grid.nodes, atol=1e-12)
    assert len(np.unique(places.round(9), axis=0)) == grid.points
    blocks = 1 * divisions**2 + (3 + 5) * (divisions // 2) ** 2
    assert len(grid.quads) == blocks
    per_face = np.bincount(grid.face_of_quad, grid.areas)
    np.testing.assert_allclose(per_face, mesh.areas, rtol=1e-12)
    assert grid.node_areas.sum() == pytest.approx(mesh.areas.sum(), rel=1e-12)
    np.testing.assert_allclose(grid.frames[:, 2], np.tile((0, 0, 1), (blocks, 1)), atol=1e-12)


def test_grid_needs_even_divisions_for_other_polygons_than_quads():
    mesh = ifs.Mesh(MIXED, MIXED_FACES)
    with pytest.raises(InputError, match=r"f0001, f0002 have not four sides.*even, got 3"):
        divide(mesh, 3)
    assert len(divide(ifs.Mesh(MIXED[:4], MIXED_FACES[:1]), 3).quads) == 9


@pytest.mark.parametrize("divisions", [0, -2, 1.5])
def test_grid_refuses_impossible_divisions(divisions):
    with pytest.raises(InputError, match="whole number from 1"):
        divide(ifs.Mesh(MIXED[:4], MIXED_FACES[:1]), divisions)


def test_surface_without_floor_is_the_design_mesh():
    shell = vault()
    surface = surface_of(shell)
    assert surface.mesh.areas.sum() == pytest.approx(shell.mesh.areas.sum(), rel=1e-12)
    np.testing.assert_array_equal(surface.origin, np.arange(len(shell.mesh.corners)))
    np.testing.assert_array_equal(surface.panels, np.arange(len(shell)))


def test_surface_is_cut_by_the_floor_and_stands_on_it():
    shell = vault(floor=GROUND)
    surface = surface_of(shell)
    heights = GROUND.height(surface.mesh.vertices)
    assert heights.min() >= -1e-9
    standing = surface.mesh.positions[surface.standing]
    assert np.abs(GROUND.height(standing)).max() <= shell.thickness / 2
    assert (surface.mesh.twin[surface.standing] < 0).all()
    assert (surface.origin == -1).any()
    kept = surface.origin >= 0
    start, other = shell.mesh.positions[surface.origin[kept]], surface.mesh.positions[kept]
    along = shell.mesh.directions[surface.origin[kept]]
    off = other - start
    off -= np.einsum("ij,ij->i", off, along)[:, None] * along
    assert np.abs(off).max() <= 1e-9
    assert len(surface.mesh) == len(set(surface.panels.tolist()))


def test_panel_left_out_takes_its_edges_along():
    shell = strip(300, 100, 10, panels=3).without("1*")
    assert len(shell) == 2
    held = held_nodes(shell, Support.border("a start"))
    np.testing.assert_array_equal(np.unique(held[:, 0]), [0])


def test_closed_curve_has_no_start_to_hold():
    ring = [(0, 0, 0), (100, 0, 0), (100, 0, 100), (0, 0, 0)]
    tube = shell_of(ring, [(0, 0, 0), (0, 90, 0)], 1.0)
    with pytest.raises(InputError, match="the curve is closed"):
        held_nodes(tube, Support.border("a end"))
    assert len(held_nodes(tube, Support.border("b end"))) == 9


@pytest.mark.parametrize(
    ("border", "axis", "value"),
    [("a start", 0, 0), ("a end", 0, 300), ("b start", 1, 0), ("b end", 1, 200)],
)
@pytest.mark.parametrize("panels", [(1, 1), (3, 1), (1, 2), (3, 2)])
def test_borders_of_a_vector_sum_have_names(border, axis, value, panels):
    held = held_nodes(strip(300, 200, 10, *panels), Support.border(border))
    np.testing.assert_array_equal(np.unique(held[:, axis]), [value])
    assert np.ptp(held[:, 1 - axis]) == (200, 300)[axis]


def test_supports_by_edge_place_test_and_number_find_their_nodes():
    shell = strip(300, 200, 10, panels=3)
    first = shell.addresses[0]
    sides = [held_nodes(shell, Support.edges({first: side})) for side in range(4)]
    assert {tuple(np.ptp(side, axis=0)) for side in sides} == {(100, 0, 0), (0, 200, 0)}
    place = held_nodes(shell, Support.nodes((149, 99, 5)))
    np.testing.assert_allclose(place, [(150, 100, 0)])
    test = held_nodes(shell, Support.where(lambda at: at[:, 0] > 250))
    np.testing.assert_array_equal(np.unique(test[:, 0]), [300])
    everything = held_nodes(shell, Support.border())
    numbered = held_nodes(shell, Support.border(*range(4)))
    np.testing.assert_array_equal(everything, numbered)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Support.border(hold="xw"), "letters"),
        (lambda: Support.border(hold=""), "holds nothing"),
        (lambda: Support.border(7), "There are 4 borders"),
        (lambda: Support.border("left"), "one of a start"),
        (lambda: Support.nodes((1, 2)), "Places must be"),
        (lambda: Support.where(lambda at: at[:, 2] > 1), "No point"),
        (lambda: Support.edges({"0": 9}), "has 4 edges"),
    ],
)
def test_support_that_cannot_be_meant_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        held_nodes(strip(300, 200, 10, panels=3), make())


def test_support_names_an_unknown_panel():
    with pytest.raises(AddressError, match="'nowhere'"):
        held_nodes(strip(300, 200, 10), Support.edges({"nowhere": 0}))


@given(st.floats(0, 80), st.floats(10, 2000))
def test_snow_weighs_on_the_plan_and_cladding_on_the_panels(angle, pressure):
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    corners = [(0, 0, 0), (500 * c, 0, 500 * s), (500 * c, 300, 500 * s), (0, 300, 0)]
    grid = divide(ifs.Mesh(corners, [(0, 1, 2, 3)]), 2)
    area = 500 * 300e-6
    snow = AreaLoad(pressure=pressure).forces(grid, 0.0).sum(axis=0)
    np.testing.assert_allclose(snow, (0, 0, -pressure * area * c), atol=1e-9 * pressure)
    cladding = AreaLoad(pressure=pressure, per="surface").forces(grid, 0.0).sum(axis=0)
    np.testing.assert_allclose(cladding, (0, 0, -pressure * area), atol=1e-9 * pressure)
    wind = AreaLoad(pressure=pressure, per="surface", direction="normal").forces(grid, 0.0)
    expected = pressure * area * np.array((s, 0, -c))
    np.testing.assert_allclose(wind.sum(axis=0), expected, atol=1e-9 * pressure)


def test_load_on_a_part_is_the_share_of_that_part():
    shell = strip(400, 200, 10, panels=4)
    grid = divide(shell.mesh, 4)
    whole = AreaLoad(pressure=1000).forces(grid, 0.0)[:, 2].sum()
    half = AreaLoad(pressure=1000, on=ifs.Plane((200, 0, 0), (-1, 0, 0))).forces(grid, 0.0)
    assert half[:, 2].sum() == pytest.approx(whole / 2, rel=1e-12)
    assert grid.nodes[half[:, 2] != 0][:, 0].max() == 200
    named = AreaLoad(pressure=1000, on=shell.addresses[:1]).forces(grid, 0.0)
    assert named[:, 2].sum() == pytest.approx(whole / 4, rel=1e-12)
    tested = AreaLoad(pressure=1000, on=lambda at: at[..., 1] > 100).forces(grid, 0.0)
    assert tested[:, 2].sum() == pytest.approx(whole / 2, rel=1e-12)
    moment = (tested[:, 2] * grid.nodes[:, 1]).sum()
    assert moment == pytest.approx(whole / 2 * 150, rel=1e-12)


def test_point_load_at_an_address_acts_in_the_middle_of_that_panel():
    shell = strip(400, 200, 10, panels=4)
    grid = divide(shell.mesh, 4)
    forces = PointLoad(force=(0, 1, -7), at=shell.addresses[2]).forces(grid, 0.0)
    (node,) = np.flatnonzero(forces.any(axis=1))
    np.testing.assert_allclose(grid.nodes[node], (250, 100, 0), atol=1e-9)
    np.testing.assert_array_equal(forces[node], (0, 1, -7))
    with pytest.raises(AddressError, match="'99'"):
        PointLoad(force=(0, 0, -1), at="99").forces(grid, 0.0)


def test_loads_add_up_with_their_factors():
    grid = divide(strip(400, 200, 10).mesh, 2)
    loads = [1.35 * SelfWeight(), 1.5 * AreaLoad(pressure=1000) * 2, PointLoad(force=(7, 0, 0))]
    total = total_forces(loads, grid, 1e-4).sum(axis=0)
    weight = 1.35 * 1e-4 * 400 * 200
    np.testing.assert_allclose(total, (7, 0, -weight - 3 * 1000e-6 * 400 * 200), rtol=1e-12)


@pytest.mark.parametrize(
    ("loads", "message"),
    [
        ([], "Nothing is loaded"),
        (AreaLoad(), "Nothing is loaded"),
        (AreaLoad(pressure=1, on=lambda at: np.ones(3, dtype=bool)), "one answer for each"),
    ],
)
def test_load_that_loads_nothing_is_refused(loads, message):
    with pytest.raises(InputError, match=message):
        total_forces(loads, divide(strip(400, 200, 10).mesh, 2), 0.0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"pressure": np.nan}, "pressure must be finite"),
        ({"per": "slope"}, '"plan" or "surface"'),
        ({"direction": (0, 0, 0)}, "zero vector"),
        ({"factor": np.inf}, "factor"),
    ],
)
def test_area_load_that_cannot_be_meant_is_refused(options, message):
    with pytest.raises(InputError, match=message):
        AreaLoad(**options)


def test_self_weight_is_volume_times_density():
    model = model_of(hexagon(400), supports=Support.border(), stiffness=TIMBER, divisions=2)
    area = 3 * np.sqrt(3) / 2 * 400**2
    assert model.surface_weight * area == pytest.approx(area * 10 * 450e-9 * 9.81, rel=1e-12)
    masses = model.masses[0 : 3 * model.grid.points : 3]
    assert masses.sum() == pytest.approx(area * 10 * 450e-12, rel=1e-12)


def test_orthotropic_material_asks_for_a_fibre_direction():
    shell = strip(400, 200, 10)
    with pytest.raises(InputError, match=r"spruce plywood is stiffer along.*with_fibre"):
        model_of(shell)
    along = model_of(shell, fibre=FibreTowards((3, 4, 99)))
    np.testing.assert_allclose(along.fibres, [(0.6, 0.8, 0)], atol=1e-12)
    np.testing.assert_allclose(along.angles, np.arctan2(4, 3), atol=1e-12)
    assert model_of(shell, stiffness=TIMBER).fibres is None


def test_shells_own_fibre_directions_are_used():
    shell = strip(400, 200, 10, panels=2).with_fibre(FibreTowards((1.0, 1.0, 0.0)))
    np.testing.assert_array_equal(model_of(shell).fibres, shell.fibres)
    np.testing.assert_allclose(
        model_of(shell, fibre=FibreTowards((0, 1, 0))).fibres, [(0, 1, 0)] * 2, atol=1e-12
    )


@pytest.mark.parametrize("joints", ["glue", -1.0, np.nan])
def test_joint_that_cannot_be_meant_is_refused(joints):
    with pytest.raises(InputError, match="joints must be"):
        model_of(strip(400, 200, 10), joints=joints, stiffness=TIMBER)


def test_material_without_stiffness_says_so():
    bare = Material("felt", 100.0, (0.5, 0.5, 0.5))
    plate = ifs.thicken(strip(400, 200, 10).mesh, 10.0, material=bare)
    with pytest.raises(InputError, match="stiffness of felt is not known"):
        model_of(plate)


def test_stiffness_and_strength_refuse_impossible_numbers():
    with pytest.raises(InputError, match="e_across must be positive"):
        Stiffness(9000, 0, 0.3, 600, 60, 60)
    with pytest.raises(InputError, match=r"below 0\.5"):
        Stiffness(1000, 4000, 0.6, 600, 60, 60)
    with pytest.raises(InputError, match=r"between -1 and 0\.5"):
        Stiffness.isotropic(9000, 0.7)
    with pytest.raises(InputError, match="bending_along must be positive"):
        Strength(0, 1, 1, 1, 1, 1, 1, 1, 1)
    assert Stiffness.isotropic(9000, 0.3).is_isotropic
    assert not PLYWOOD.is_isotropic
    assert SPRUCE_PLYWOOD.stiffness is not None
    assert SPRUCE_PLYWOOD.strength is not None


def test_model_of_mixed_polygons_has_one_panel_for_each():
    model = model_of(
        mesh_shell([(50 * x, 50 * y, 0) for x, y, _ in MIXED], MIXED_FACES, 5.0), stiffness=TIMBER
    )
    assert model.size == 3 * (model.grid.points + len(model.grid.nodes))
