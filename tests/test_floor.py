"""The floor a shell stands on."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from oracles import corners_by_half_spaces, half_spaces, hull_volume
from strategies import accepted, numbers

from ifs_cad.design.mesh import Mesh
from ifs_cad.design.surface import vector_sum
from ifs_cad.elements.floor import openings, standing_chains
from ifs_cad.elements.polyhedron import Kind
from ifs_cad.elements.thicken import thicken
from ifs_cad.errors import FloorError, InputError
from ifs_cad.types import Plane

FLOOR = Plane((0, 0, 0), (0, 0, 1))
# a gable: two slopes of 3-4-5, 3 m wide at the foot, on walls that lean in by 3-4-5 too
GABLE = np.array([(0, 0, 0), (300, 0, 400), (1500, 0, 1300), (2700, 0, 400), (3000, 0, 0)])
LENGTH = [(0, 0, 0), (0, 1000, 0), (0, 2000, 0)]


def gable(drop=0.0, **options):
    """Return the gable as 4 x 2 panels, normals outwards, sunk into the floor by a drop."""
    return vector_sum(GABLE, LENGTH, origin=(0, 0, -drop), addresses="lexicographic", **options)


@st.composite
def arches(draw):
    """Return arches of random rough panels, both feet near the floor."""
    count = draw(st.integers(3, 6))
    angles = np.linspace(np.pi, 0, count + 1) + draw(numbers(count + 1, -0.1, 0.1))
    arch = 2000 * np.column_stack([np.cos(angles), 0 * angles, np.sin(angles)])
    along = np.arange(draw(st.integers(2, 4)) + 1)
    shake = draw(numbers((len(along), 3), -80, 80))
    fold = 700 * along[:, None] * [0, 1, 0] + shake * [1, 1, draw(st.sampled_from([0.0, 0.5]))]
    return vector_sum(arch - arch[0], fold, addresses="lexicographic")


def moved(mesh, by):
    """Return the mesh moved up by some mm."""
    return Mesh(
        mesh.vertices + np.array([0, 0, by]),
        mesh.polygons(),
        addresses=mesh.addresses,
        lattice=mesh.lattice,
        chain_ends=mesh.chain_ends,
    )


def test_feet_stand_and_ends_are_openings():
    mesh = gable()
    assert sorted(standing_chains(mesh, FLOOR)) == [False, False, True, True]
    ends = openings(mesh, FLOOR)
    assert [sorted(end.addresses) for end in ends] == [
        ["0.0", "1.0", "2.0", "3.0"],
        ["0.1", "1.1", "2.1", "3.1"],
    ]
    assert [end.height for end in ends] == pytest.approx([1300, 1300])


def test_foot_that_leans_in_needs_a_drop_of_its_square_edge():
    # the square edge of 20 mm rises by 20 times the lean, 300 / 500
    with pytest.raises(FloorError, match=r"up to 12\.000 mm above the floor at 0\.0, 0\.1, 3\.0"):
        thicken(gable(), 20, floor=FLOOR)
    with pytest.raises(FloorError, match=r"up to 0\.010 mm above"):
        thicken(gable(11.99), 20, floor=FLOOR)
    shell = thicken(gable(12), 20, floor=FLOOR)
    assert shell.solids.vertices[:, 2].min() == pytest.approx(0, abs=1e-9)


def test_trimmed_foot_has_the_volume_worked_out_by_hand():
    whole, shell = thicken(gable(12), 20), thicken(gable(12), 20, floor=FLOOR)
    # cut off: the parallelogram of 20 mm between the floor and the square edge, of which the
    # panel's inner edge sinks 12 mm, so 15 mm along its slope of 4 in 5: a triangle 15 x 20 / 2
    lost = (whole["0.0"].volume - shell["0.0"].volume) / 1000
    assert lost == pytest.approx(15 * 20 / 2, rel=1e-9)
    assert whole["1.0"].volume == shell["1.0"].volume
    cut = (shell.solids.kinds == Kind.FLOOR).sum()
    assert cut == 4
    assert shell.lost == ()
    assert shell.stubs == ()


def test_inner_panels_of_the_same_foot_need_no_drop():
    shell = thicken(gable(), 20, side="inner", floor=FLOOR)
    assert shell.solids.vertices[:, 2].min() == pytest.approx(0, abs=1e-9)
    below = thicken(gable(), 20, side="inner").solids.vertices[:, 2].min()
    assert below == pytest.approx(-12)


@given(arches(), st.floats(2, 40), st.sampled_from(["outer", "inner", "centre"]))
def test_drop_of_the_error_is_what_is_needed(mesh, thickness, side):
    accepted(thicken, mesh, thickness, side=side)
    drop = 0.0
    for _ in range(8):  # a border that comes down may be one that then stands
        try:
            shell = thicken(moved(mesh, -drop), thickness, side=side, floor=FLOOR)
            break
        except FloorError as error:
            assume(error.values.get("drop", 0) > 0)  # else the arch is gone below the floor
            last, drop = drop, drop + error.values["drop"]
    if drop and drop - last > 1e-5:
        almost = drop - max(0.001 * (drop - last), 2e-6)  # by more than the tolerance of a plane
        with pytest.raises(FloorError):
            thicken(moved(mesh, -almost), thickness, side=side, floor=FLOOR)
    assert shell.solids.vertices[:, 2].min() > -1e-9
    stands = standing_chains(shell.mesh, FLOOR)
    assert any(stands)
    standing = [shell.mesh.chains[k] for k in np.flatnonzero(stands)]
    stands_on = shell.solids.vertices[:, 2] < 1e-9
    feet = {shell.mesh.addresses[f] for c in standing for f in shell.mesh.face[c]}
    on_floor = {shell.addresses[s] for s in shell.solids.solid_of_vertex[stands_on]}
    assert feet - set(shell.lost) <= on_floor


@given(arches(), st.floats(10, 900))
def test_trimmed_panels_are_the_half_space_intersections(mesh, drop):
    try:
        shell = thicken(moved(mesh, -drop), 15, floor=FLOOR)
    except FloorError:
        assume(False)
    whole = thicken(moved(mesh, -drop), 15)
    for panel in shell:
        points = panel.solid.vertices
        if hull_volume(points) < 1:
            continue
        rows = np.vstack([half_spaces(whole, whole[panel.address]), [0, 0, -1, 0]])
        corners = corners_by_half_spaces(rows, points.mean(axis=0))
        apart = np.linalg.norm(points[:, None] - corners, axis=-1)
        assert apart.min(axis=0).max() < 1e-6
        assert apart.min(axis=1).max() < 1e-6
    # what is missing is below the floor
    for address in shell.lost:
        assert whole[address].solid.vertices[:, 2].max() <= 1e-9
    assert set(shell.lost) | set(shell.addresses) == set(whole.addresses)
    assert not set(shell.lost) & set(shell.addresses)


def sunk(drop, **options):
    """Return a shell of the gable with each slope of the roof in four, sunk into the floor."""
    slope = np.linspace(GABLE[1], GABLE[2], 5)
    half = np.vstack([GABLE[:1], slope])
    arch = np.vstack([half, (half * [-1, 1, 1] + [3000, 0, 0])[-2::-1]])
    mesh = vector_sum(arch, LENGTH, origin=(0, 0, -drop), addresses="lexicographic")
    return thicken(mesh, 20, floor=FLOOR, **options)


def test_lost_panels_and_stubs_are_named():
    shell = sunk(450)
    assert shell.lost == ("0.0", "0.1", "9.0", "9.1")
    assert shell.stubs == ()
    # the first row of the roof rises to 400 + 900 / 4 - 450 mm and 16 mm of thickness
    assert sunk(450, min_height=190.9).stubs == ()
    assert sunk(450, min_height=191.1).stubs == ("1.0", "1.1", "8.0", "8.1")
    # lower than twice the thickness by default: walls of 400 mm and 12 mm of thickness, and more
    # where the roof above makes the chamfer rise
    assert sunk(360).stubs == ()
    assert sunk(380).stubs == ("0.0", "0.1", "9.0", "9.1")


def test_part_of_a_shell_has_lost_no_more_than_the_shell():
    shell = sunk(450)
    assert shell.part("1.*").lost == shell.lost
    assert sunk(100).part("1.*").lost == ()


@pytest.mark.parametrize("door", ["0.0", ["0.?", "1.0"], "?.0"])
def test_door_at_the_foot_does_not_raise(door):
    shell = thicken(gable(12), 20, floor=FLOOR)
    opened = shell.without(door)
    assert len(opened) < len(shell)
    assert opened.solids.vertices[:, 2].min() == pytest.approx(0, abs=1e-9)


def test_border_of_a_door_is_no_opening_of_the_design():
    shell = thicken(gable(12), 20, floor=FLOOR).without("1.1")
    assert len(shell.openings) == 2
    assert {a for end in shell.openings for a in end.addresses} == {
        "0.0",
        "1.0",
        "2.0",
        "3.0",
        "0.1",
        "2.1",
        "3.1",
    }


def test_floor_may_be_any_plane():
    # the same gable, turned about the y axis with its floor
    turn = np.radians(25)
    about = np.array([(np.cos(turn), 0, -np.sin(turn)), (0, 1, 0), (np.sin(turn), 0, np.cos(turn))])
    mesh = vector_sum((GABLE - [0, 0, 12]) @ about, LENGTH, addresses="lexicographic")
    floor = Plane(tuple(np.array([5, 7, 0]) @ about), tuple(3 * about[2]))
    shell = thicken(mesh, 20, floor=floor)
    np.testing.assert_allclose(
        shell.volumes, thicken(gable(12), 20, floor=FLOOR).volumes, rtol=1e-9
    )


def test_floating_shell_is_refused_with_the_drop_after_which_its_lowest_border_stands():
    with pytest.raises(FloorError, match="No border reaches") as caught:
        thicken(gable(-250), 20, floor=FLOOR)
    assert caught.value.values["drop"] == pytest.approx(262)
    assert len(thicken(gable(12), 20, floor=FLOOR)) == 8


def test_closed_mesh_is_refused():
    cube = [(x, y, z) for z in (0, 100) for y in (0, 100) for x in (0, 100)]
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]]
    with pytest.raises(FloorError, match="closed mesh has no border"):
        thicken(Mesh(cube, faces), 10, floor=FLOOR)


def test_shell_below_the_floor_is_refused():
    with pytest.raises(FloorError, match="whole shell lies below"):
        thicken(gable(5000), 20, floor=FLOOR)


@pytest.mark.parametrize(
    ("origin", "normal", "message"),
    [
        ((0, 0, 0), (0, 0, 0), "must not be the zero vector"),
        ((0, 0, np.nan), (0, 0, 1), "Plane origin must be finite"),
        ((0, 0), (0, 0, 1), r"Plane origin must be 3 numbers, got shape \(2,\)"),
        ((0, 0, 0), "up", "Plane normal must be 3 numbers"),
    ],
)
def test_bad_floors_are_refused_each_with_its_own_error(origin, normal, message):
    with pytest.raises(InputError, match=message):
        Plane(origin, normal)
