"""Shells and panels: what they tell, and what is left when panels are taken out."""

import numpy as np
import pytest
from hypothesis import given, settings
from oracles import face_normal, pairs_that_share_a_node, points_of, shared_balls
from strategies import accepted, fans, shells, vector_sums

from ifs_cad.design.curve import Curve
from ifs_cad.design.mesh import Mesh
from ifs_cad.design.surface import vector_sum
from ifs_cad.elements.material import SPRUCE_PLYWOOD, Material
from ifs_cad.elements.panel import require_face
from ifs_cad.elements.polyhedron import Kind
from ifs_cad.elements.thicken import thicken
from ifs_cad.errors import AddressError, InputError

ROUGH_A = np.array([(0, 0, 0), (400, 0, 300), (800, 50, -100), (1200, 0, 350), (1600, 0, 0)])
ROUGH_B = np.array([(0, 0, 0), (50, 400, -150), (-50, 800, 200), (100, 1200, -50)])


def rough(**options):
    """Return a shell of 4 x 3 panels with relief cuts."""
    return thicken(vector_sum(ROUGH_A, ROUGH_B, addresses="lexicographic"), 20, **options)


def box(**options):
    """Return a shell of one panel, 2 m x 1 m."""
    mesh = Mesh([(0, 0, 0), (2000, 0, 0), (2000, 1000, 0), (0, 1000, 0)], [[0, 1, 2, 3]])
    return thicken(mesh, 10, **options)


def test_area_volume_and_mass_of_a_rectangle():
    panel = box()["f0000"]
    assert panel.area == 2e6
    assert panel.volume == 2e7
    assert panel.mass == pytest.approx(0.02 * SPRUCE_PLYWOOD.density)
    assert panel.thickness == 10
    assert panel.edge_lengths.tolist() == [2000, 1000, 2000, 1000]
    assert panel.neighbours == ["", "", "", ""]
    assert panel.normal.tolist() == [0, 0, 1]


def test_mass_follows_the_material():
    heavy = Material("lead", 11340.0, (0.3, 0.3, 0.3))
    assert box(material=heavy)["f0000"].mass == pytest.approx(0.02 * 11340)


@pytest.mark.parametrize(
    ("density", "colour", "message"),
    [
        (0.0, (0, 0, 0), "Density of ply must be positive"),
        (np.nan, (0, 0, 0), "Density of ply must be positive"),
        (450.0, (0, 0, 2), "numbers from 0 to 1"),
        (450.0, (0, 0), "three numbers"),
    ],
)
def test_bad_materials_are_refused_each_with_its_own_error(density, colour, message):
    with pytest.raises(InputError, match=message):
        Material("ply", density, colour)


def test_area_is_that_of_the_larger_face():
    # an arch widens outwards: 100 mm along the inner face, more along the outer one
    angles = np.linspace(np.pi, 0, 7)
    arch = 1000 * np.stack([np.cos(angles), 0 * angles, np.sin(angles)], axis=1)
    shell = thicken(vector_sum(arch, [(0, 0, 0), (0, 500, 0)]), 30)
    chord = 2000 * np.sin(np.pi / 12)
    widened = chord + 2 * 30 * np.tan(np.pi / 12)
    assert shell["2"].area == pytest.approx(500 * widened, rel=1e-12)
    assert shell["0"].area == pytest.approx(500 * (chord + widened) / 2, rel=1e-12)


@settings(max_examples=50)
@given(shells())
def test_panels_are_views_of_the_shell(shell):
    assert [panel.address for panel in shell] == list(shell.addresses)
    assert len(list(shell)) == len(shell)
    for number, panel in enumerate(shell):
        assert shell[panel.address].index == number
        assert panel.volume == pytest.approx(panel.solid.volumes[0], rel=1e-12)
        np.testing.assert_array_equal(
            np.sort(panel.solid.vertices, axis=0),
            np.sort(points_of(shell.solids, number), axis=0),
        )
    assert shell.volumes.sum() == pytest.approx(shell.solids.volumes.sum(), rel=1e-12)


@settings(max_examples=50)
@given(shells())
def test_chamfer_angles_are_those_of_the_cut_faces(shell):
    mesh, solids = shell.mesh, shell.solids
    for panel in shell:
        for half_edge, angle in zip(panel.half_edges, panel.chamfer_angles, strict=True):
            if mesh.twin[half_edge] < 0:
                assert angle == pytest.approx(0, abs=1e-9)
                continue
            mate = mesh.face[mesh.twin[half_edge]]
            cut = np.flatnonzero((panel.solid.mates == mate) & (panel.solid.kinds == Kind.CUT))
            if len(cut) == 0:
                continue  # cut away by reliefs
            # the angle between the outward normals of cut and panel is 90 degrees and the chamfer
            sine = -panel.solid.normals[cut[0]] @ panel.normal
            assert np.sin(np.radians(angle)) == pytest.approx(sine, abs=1e-9)
    assert solids.kinds.max() <= Kind.FLOOR


@settings(max_examples=50)
@given(vector_sums())
def test_chamfer_angles_of_both_sides_of_an_edge_are_half_the_angle_of_the_normals(mesh):
    shell = accepted(thicken, mesh, 0.001)
    normals = np.array([face_normal(mesh, polygon) for polygon in mesh.polygons()])
    inner = np.flatnonzero(mesh.twin >= 0)
    one, other = normals[mesh.face[inner]], normals[mesh.face[mesh.twin[inner]]]
    fold = np.degrees(
        np.arctan2(np.linalg.norm(np.cross(one, other), axis=1), np.einsum("ei,ei->e", one, other))
    )
    np.testing.assert_allclose(np.abs(shell.chamfer_angles[inner]), fold / 2, atol=1e-6)
    np.testing.assert_allclose(
        shell.chamfer_angles[inner], shell.chamfer_angles[mesh.twin[inner]], atol=1e-9
    )
    # positive at a ridge: the neighbour falls away below the face
    below = np.einsum(
        "ei,ei->e",
        one,
        mesh.centroids[mesh.face[mesh.twin[inner]]] - mesh.centroids[mesh.face[inner]],
    )
    clear = fold > 0.01
    np.testing.assert_array_equal(shell.chamfer_angles[inner][clear] > 0, below[clear] < 0)


@settings(max_examples=50)
@given(fans(valences=(4, 8)))
def test_node_gap_is_the_largest_distance_of_the_offset_corners(mesh):
    thickness = 3.0
    shell = accepted(thicken, mesh, thickness, nodes="plain")
    met = []
    for number in range(len(shell)):
        points = points_of(shell.solids, number)
        far = points[np.abs(points @ shell.normals[number] - thickness) < 1e-9]
        # of the three far corners, the one that goes with the node lies on both cut planes
        cuts = shell.cuts[np.flatnonzero((mesh.face == number) & (mesh.twin >= 0))]
        met.append(far[np.abs(far @ cuts.T).max(axis=1).argmin()])
    apart = np.linalg.norm(np.array(met)[:, None] - np.array(met), axis=-1)
    assert shell.node_gaps[0] == pytest.approx(apart.max(), abs=1e-6)
    assert (shell.node_gaps[1:] == 0).all()


def test_node_gap_grows_with_the_thickness():
    gaps = [rough(side=side).node_gaps.max() for side in ("outer", "inner", "centre")]
    assert gaps[0] == pytest.approx(gaps[1])
    assert gaps[0] == pytest.approx(2 * gaps[2])
    assert gaps[0] > 0.1


def test_conicity_is_zero_at_a_pyramid_and_the_spread_of_tilts_elsewhere():
    ring = [(300, 0, -200), (0, 300, -200), (-300, 0, -200), (0, -300, -200)]
    faces = [[0, 1 + k, 1 + (k + 1) % 4] for k in range(4)]
    pyramid = thicken(Mesh([(0, 0, 0), *ring], faces), 5)
    assert pyramid.conicity.max() == pytest.approx(0, abs=1e-6)
    # a plane of symmetry holds an axis with equal tilts
    ring[0] = (300, 0, 250)
    mirrored = thicken(Mesh([(0, 0, 0), *ring], faces), 5)
    assert mirrored.conicity.max() == pytest.approx(0, abs=1e-6)
    ring[1] = (0, 300, 100)
    skew = thicken(Mesh([(0, 0, 0), *ring], faces), 5)
    assert skew.conicity[0] > 1
    assert skew.node_gaps[0] > 0.1


@settings(max_examples=50)
@given(shells())
def test_relief_share_is_what_the_plain_panel_lost(shell):
    plain = shell.plain.polyhedra().volumes[shell.faces]
    np.testing.assert_allclose(shell.volumes, plain * (1 - shell.relief_share), rtol=1e-9)
    assert shell.relief_share.min() > -1e-12
    assert shell.relief_share.max() < 1


def test_part_keeps_the_chamfers_it_has_in_the_whole():
    shell = rough()
    part = shell.part("1.*")
    assert part.addresses == ("1.0", "1.1", "1.2")
    for address in part.addresses:
        np.testing.assert_array_equal(part[address].chamfer_angles, shell[address].chamfer_angles)
        assert part[address].volume == shell[address].volume
        assert part[address].neighbours == shell[address].neighbours
    assert np.abs(part["1.1"].chamfer_angles).min() > 1
    assert part.relief_share.tolist() == shell.relief_share[3:6].tolist()


def test_without_makes_the_neighbours_edges_square():
    shell = rough()
    door = shell.without("1.1")
    assert "1.1" not in door.addresses
    assert len(door) == 11
    for address in ("0.1", "1.0", "1.2", "2.1"):
        across = shell[address].neighbours.index("1.1")
        assert abs(shell[address].chamfer_angles[across]) > 1
        assert door[address].neighbours[across] == ""
        assert door[address].chamfer_angles[across] == pytest.approx(0, abs=1e-9)
        rest = np.delete(shell[address].chamfer_angles, across)
        assert np.delete(door[address].chamfer_angles, across) == pytest.approx(rest, abs=1e-9)
    for address in ("3.0", "3.2"):
        assert door[address].volume == shell[address].volume
    assert shared_balls(door.solids, pairs_that_share_a_node(door)).max() <= 1e-6


def test_without_keeps_side_clearance_and_material():
    heavy = Material("lead", 11340.0, (0.3, 0.3, 0.3))
    door = rough(side="centre", clearance=0.5, material=heavy).without("0.*")
    assert door.thickening.side == "centre"
    assert door.set_backs.min() == 0.5
    assert door.masses.sum() == pytest.approx(door.volumes.sum() * 11340e-9)


def test_without_a_panel_of_a_part_leaves_a_part():
    shell = rough()
    rest = shell.part("1.*").without("*.1")
    assert rest.addresses == ("1.0", "1.2")
    # panels outside the part stay where they were, and with them the chamfers towards them
    whole = shell.without("1.1")
    for address in rest.addresses:
        assert rest[address].volume == whole[address].volume


def test_take_gives_panels_by_number():
    shell = rough()
    assert shell.take([7, 2]).addresses == ("2.1", "0.2")
    assert shell.take([7, 2])["0.2"].volume == shell["0.2"].volume


def test_prefix_of_iterated_addresses_is_a_connected_part():
    a = Curve([(0, 0, 0), (1000, 0, 900), (2000, 0, 0)], depth=2)
    b = Curve([(0, 0, 0), (0, 900, 500), (0, 2000, 0)], depth=2)
    shell = thicken(vector_sum(a, b), 10)
    part = shell.part("3*")
    assert len(part) == 4
    inside = set(part.addresses)
    assert all(len(inside & set(panel.neighbours)) == 2 for panel in part)


@pytest.mark.parametrize(
    "call",
    [
        lambda s: s["9.9"],
        lambda s: s.part("9*"),
        lambda s: s.without("9*"),
        lambda s: s.part("1.*").without("0*"),
    ],
)
def test_address_that_no_panel_has_is_refused(call):
    with pytest.raises(AddressError, match=r"9|0\*"):
        call(rough())


def test_address_error_shows_what_addresses_look_like():
    with pytest.raises(AddressError, match=r"'1x'.* look like 0\.0, 0\.1, 0\.2"):
        rough()["1x"]


@pytest.mark.parametrize("call", [lambda s: s.without("*"), lambda s: s.part("1.*").without("1*")])
def test_leaving_out_everything_is_refused(call):
    with pytest.raises(InputError, match="leaves no panel"):
        call(rough())


def test_require_face_knows_inner_and_outer_only():
    assert require_face("inner") == "inner"
    assert require_face("outer") == "outer"
    with pytest.raises(InputError, match="'upper'"):
        require_face("upper")
