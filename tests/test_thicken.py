"""From a mesh to panels: offset, cut planes, relief; the shells of section 4.2 and figure 17."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import (
    corners_by_half_spaces,
    half_spaces,
    hull_volume,
    pairs_that_share_a_node,
    planes_of,
    points_of,
    shared_balls,
)
from strategies import (
    accepted,
    clearances,
    even_fold_points,
    largest_thickness,
    meshes,
    panel_sides,
    shells,
    thicknesses,
    vector_sums,
)

from ifs_cad.design.mesh import Mesh
from ifs_cad.design.surface import vector_sum
from ifs_cad.elements.polyhedron import Kind, clip
from ifs_cad.elements.thicken import thicken
from ifs_cad.errors import InputError, SelfIntersectionError, ThicknessError
from ifs_cad.tolerance import DEFAULT

CUBE = [(x, y, z) for z in (0, 100) for y in (0, 100) for x in (0, 100)]
CUBE_FACES = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]]


def roof(angle):
    """Return two squares of 1 m that fold up by an angle in degrees along the y axis."""
    rise = np.radians(angle / 2)
    flank = 1000 * np.array([np.cos(rise), 0, np.sin(rise)])
    along = np.array([0, 1000, 0])
    points = [-flank * [1, 0, 1], 0 * flank, flank * [1, 0, -1]]
    return Mesh(
        [*points, *(point + along for point in points)],
        [[0, 1, 4, 3], [1, 2, 5, 4]],
        addresses=("left", "right"),
    )


def require_touching_only(shell):
    """Assert that no two panels that share a node have a ball in common."""
    assert shared_balls(shell.solids, pairs_that_share_a_node(shell)).max(initial=0) <= 1e-6


def caps(panel):
    """Return the numbers of the lower and the upper face of a panel."""
    return [int(np.flatnonzero(panel.solid.kinds == kind)[0]) for kind in (0, 1)]


# what every shell is, whatever it was made from


@settings(max_examples=60)
@given(shells())
def test_panels_that_share_a_node_share_no_volume(shell):
    require_touching_only(shell)


@pytest.mark.slow
@settings(max_examples=150)
@given(shells())
def test_panels_that_share_a_node_share_no_volume_in_many_shells(shell):
    require_touching_only(shell)


@settings(max_examples=50)
@given(shells())
def test_corners_equal_the_intersection_of_the_defining_half_spaces(shell):
    for panel in shell:
        points = panel.solid.vertices
        corners = corners_by_half_spaces(half_spaces(shell, panel), points.mean(axis=0))
        apart = np.linalg.norm(points[:, None] - corners, axis=-1)
        assert apart.min(axis=0).max() < 1e-6
        assert apart.min(axis=1).max() < 1e-6


@settings(max_examples=50)
@given(shells())
def test_volumes_equal_the_convex_hull_of_the_corners(shell):
    for number in range(len(shell)):
        volume = hull_volume(points_of(shell.solids, number))
        assert shell.volumes[number] == pytest.approx(volume, rel=1e-9)


@settings(max_examples=50)
@given(shells())
def test_panels_are_closed_polyhedra_with_planar_faces(shell):
    solids = shell.solids
    for number in range(len(shell)):
        faces = solids.solid_of_face == number
        edges = int(np.isin(solids.face_of_loop, np.flatnonzero(faces)).sum()) / 2
        assert len(points_of(solids, number)) - edges + faces.sum() == 2
    pairs = set(zip(solids.loops.tolist(), solids.heads.tolist(), strict=True))
    assert len(pairs) == len(solids.loops)
    assert pairs == {(head, tail) for tail, head in pairs}
    on_plane = np.einsum(
        "hi,hi->h", solids.normals[solids.face_of_loop], solids.vertices[solids.loops]
    )
    np.testing.assert_allclose(on_plane, solids.levels[solids.face_of_loop], atol=1e-8)
    np.testing.assert_allclose(np.linalg.norm(solids.normals, axis=1), 1, atol=1e-12)
    np.testing.assert_allclose(
        np.linalg.norm(solids.area_vectors, axis=1), solids.face_areas, rtol=1e-6, atol=1e-6
    )


@settings(max_examples=50)
@given(shells())
def test_thickness_is_exact_and_the_design_face_lies_where_the_side_says(shell):
    thickness = shell.thickness
    share = {"outer": 0.0, "inner": 1.0, "centre": 0.5}[shell.thickening.side]
    for panel in shell:
        lower, upper = caps(panel)
        solid = panel.solid
        normal = panel.normal
        assert solid.normals[upper] == pytest.approx(normal, abs=1e-12)
        assert solid.normals[lower] == pytest.approx(-normal, abs=1e-12)
        design = normal @ shell.mesh.centroids[panel.face]
        assert solid.levels[upper] == pytest.approx(design + (1 - share) * thickness, abs=1e-9)
        assert -solid.levels[lower] == pytest.approx(design - share * thickness, abs=1e-9)
        heights = solid.vertices @ normal - design + share * thickness
        assert heights.min() == pytest.approx(0, abs=1e-9)
        assert heights.max() == pytest.approx(thickness, abs=1e-9)
        for face, level in ((lower, 0), (upper, thickness)):
            corners = solid.loops[solid.face_of_loop == face]
            np.testing.assert_allclose(heights[corners], level, atol=1e-9)


@settings(max_examples=50)
@given(shells())
def test_mating_cut_planes_are_parallel_and_twice_the_clearance_apart(shell):
    solids, clearance = shell.solids, shell.thickening.clearance
    owner = shell.faces[solids.solid_of_face]
    cuts = np.flatnonzero(solids.kinds == Kind.CUT)
    number = {(int(owner[f]), int(solids.mates[f])): f for f in cuts}
    assert len(number) == len(cuts)
    for (mine, other), face in number.items():
        mate = number[(other, mine)]
        np.testing.assert_allclose(solids.normals[mate], -solids.normals[face], atol=1e-12)
        gap = -(solids.levels[face] + solids.levels[mate])
        assert 2 * clearance - 1e-9 <= gap <= 2 * (clearance + DEFAULT.relief)
        usual = (shell.set_backs[shell.mesh.face == mine] == clearance).all()
        if usual and (shell.set_backs[shell.mesh.face == other] == clearance).all():
            assert gap == pytest.approx(2 * clearance, abs=1e-9)


@settings(max_examples=50)
@given(shells())
def test_border_edges_are_square(shell):
    solids = shell.solids
    borders = np.flatnonzero(solids.kinds == Kind.BORDER)
    normals = shell.normals[solids.solid_of_face[borders]]
    assert np.abs(np.einsum("fi,fi->f", normals, solids.normals[borders])).max(initial=0) < 1e-12


@settings(max_examples=50)
@given(meshes(), thicknesses, st.sampled_from(["outer", "inner"]))
def test_relief_leaves_the_design_face_whole(mesh, thickness, side):
    shell = accepted(thicken, mesh, thickness, side=side)
    solids = shell.solids
    design = solids.kinds == (Kind.LOWER if side == "outer" else Kind.UPPER)
    areas = solids.face_areas[design]
    backed = np.maximum.reduceat(shell.set_backs, mesh.offsets[:-1]) > 0
    np.testing.assert_allclose(areas[~backed], mesh.areas[~backed], rtol=1e-9)
    perimeters = np.add.reduceat(mesh.edge_lengths, mesh.offsets[:-1])
    assert (areas[backed] >= mesh.areas[backed] - DEFAULT.relief * perimeters[backed]).all()


@settings(max_examples=80)
@given(shells())
def test_relief_in_the_cycle_of_sides_equals_clipping_the_plain_panels(shell):
    clipped = shell.plain.polyhedra()
    whole = shell.whole
    reliefs = np.flatnonzero(whole.kinds == Kind.RELIEF)
    solid = whole.solid_of_face[reliefs]
    while len(reliefs):
        solid, first = np.unique(whole.solid_of_face[reliefs], return_index=True)
        normals, levels = np.zeros((len(whole), 3)), np.full(len(whole), -np.inf)
        normals[solid] = -whole.normals[reliefs[first]]
        levels[solid] = -whole.levels[reliefs[first]]
        clipped, left = clip(clipped, normals, levels, Kind.RELIEF, np.full(len(whole), -1))
        assert left.all()
        reliefs = np.delete(reliefs, first)
    np.testing.assert_allclose(whole.volumes, clipped.volumes, rtol=1e-12)
    for number in range(len(whole)):
        for one, other in ((whole, clipped), (clipped, whole)):
            planes = planes_of(one, number)
            outside = points_of(other, number) @ planes[:, :3].T - planes[:, 3]
            assert outside.max() < 1e-8


@settings(max_examples=50)
@given(shells(), thicknesses)
def test_addresses_survive_a_change_of_thickness(shell, thickness):
    other = accepted(thicken, shell.mesh, thickness)
    assert other.addresses == shell.addresses
    assert len(set(shell.addresses)) == len(shell)


@settings(max_examples=80)
@given(meshes(), panel_sides, clearances)
def test_largest_thickness_of_the_error_fits_and_a_little_more_does_not(mesh, side, clearance):
    largest = largest_thickness(mesh, side=side, clearance=clearance)
    assume(0 < largest < 1000)
    shell = thicken(mesh, largest, side=side, clearance=clearance)
    require_touching_only(shell)
    assert (shell.volumes > 0).all()
    with pytest.raises(ThicknessError, match="cross over"):
        thicken(mesh, (largest + 0.001) * 1.001, side=side, clearance=clearance)


# hand-computed shells


def test_flat_square_becomes_a_box():
    mesh = Mesh([(0, 0, 0), (500, 0, 0), (500, 400, 0), (0, 400, 0)], [[0, 1, 2, 3]])
    shell = thicken(mesh, 10)
    assert shell.volumes.tolist() == [2_000_000.0]
    assert sorted(map(tuple, shell.solids.vertices.tolist())) == [
        (x, y, z) for x in (0, 500) for y in (0, 400) for z in (0, 10)
    ]


def test_clearance_does_set_border_edges_back_too():
    mesh = Mesh([(0, 0, 0), (500, 0, 0), (500, 400, 0), (0, 400, 0)], [[0, 1, 2, 3]])
    assert thicken(mesh, 10, clearance=5).volumes == pytest.approx([490 * 390 * 10])


@pytest.mark.parametrize("angle", [10, 60, 120, -60])
@pytest.mark.parametrize("side", ["outer", "inner", "centre"])
def test_roof_of_two_faces_by_hand(angle, side):
    shell = thicken(roof(angle), 20, side=side)
    tangent = np.tan(np.radians(angle / 2))
    # each panel is 1 m long; its section is a rectangle of 1000 x 20 and the chamfer's triangle
    inner, outer = {"outer": (0, 20), "inner": (-20, 0), "centre": (-10, 10)}[side]
    section = 1000 * 20 + tangent * (outer**2 - inner**2) / 2
    assert shell.volumes == pytest.approx([1000 * section] * 2, rel=1e-12)
    # the ridge is where both meet, in the plane x = 0
    ridge = {
        number: {tuple(p) for p in points_of(shell.solids, number).round(9) if abs(p[0]) < 1e-9}
        for number in (0, 1)
    }
    assert ridge[0] == ridge[1]
    heights = sorted({z for _, _, z in ridge[0]})
    rise = np.cos(np.radians(angle / 2))
    assert heights == pytest.approx([inner / rise, outer / rise], abs=1e-8)


@pytest.mark.parametrize("angle", [1, 45, 90, 170, -45])
def test_chamfer_angle_is_half_the_fold_angle(angle):
    shell = thicken(roof(angle), 1)
    for address in ("left", "right"):
        panel = shell[address]
        across = panel.neighbours.index("right" if address == "left" else "left")
        assert panel.chamfer_angles[across] == pytest.approx(angle / 2, abs=1e-9)
        assert np.delete(panel.chamfer_angles, across) == pytest.approx([0, 0, 0], abs=1e-9)


def test_clearance_opens_the_roof_by_twice_as_much():
    closed, open_ = thicken(roof(60), 20), thicken(roof(60), 20, clearance=3)
    ridge = [np.abs(shell.solids.vertices[:, 0]).min() for shell in (closed, open_)]
    assert ridge == pytest.approx([0, 3], abs=1e-9)


def test_cube_grows_and_shrinks_exactly():
    mesh = Mesh(CUBE, CUBE_FACES)
    for side, volume in (
        ("outer", 120**3 - 100**3),
        ("inner", 100**3 - 80**3),
        ("centre", 110**3 - 90**3),
    ):
        shell = thicken(mesh, 10, side=side)
        assert shell.volumes == pytest.approx([volume / 6] * 6, rel=1e-12)
        assert shell.node_gaps == pytest.approx([0] * 8, abs=1e-12)


def test_cube_is_too_thick_at_half_its_size():
    with pytest.raises(ThicknessError, match="At most 50 mm fit") as caught:
        thicken(Mesh(CUBE, CUBE_FACES), 50.01, side="inner")
    assert caught.value.values["largest_thickness"] == 50.0
    assert len(caught.value.addresses) == 6


def test_panel_may_be_a_wedge_at_exactly_the_largest_thickness():
    # all upper edges of this pyramid's flanks shrink to points at 100 tan(22.5 degrees) or later
    mesh = roof(90)
    with pytest.raises(ThicknessError) as caught:
        thicken(mesh, 1001, side="inner")
    assert caught.value.values["largest_thickness"] == 1000.0
    wedge = thicken(mesh, 999.9999999, side="inner")
    assert wedge.volumes == pytest.approx([1000 * 1000 * 1000 / 2] * 2, rel=1e-6)


def test_edge_too_short_to_give_way_keeps_its_short_relief_cut():
    # an even fold but for 0.1 mm: nearly exact, with reliefs too short to be made; at the largest
    # thickness an edge is left that a set-back would turn around
    fold = even_fold_points([(340, 70), (730, -140), (1030, -290), (1410, -430)], 0.9)
    arch = [(0, 190, 90), (1e-4, 370, 20), (2e-4, 490, 110), (1e-4, 680, -140)]
    mesh = vector_sum(fold, arch)
    largest = largest_thickness(mesh)
    assert largest == pytest.approx(449.453)
    thin, thick = thicken(mesh, 20), thicken(mesh, largest)
    assert 0 < thin.set_backs.max() < DEFAULT.relief
    assert not (thin.solids.kinds == Kind.RELIEF).any()
    for shell in (thin, thick):
        require_touching_only(shell)
        for number in range(len(shell)):
            planes, points = planes_of(shell.solids, number), points_of(shell.solids, number)
            assert (points @ planes[:, :3].T - planes[:, 3]).max() < 1e-8
            assert shell.volumes[number] == pytest.approx(hull_volume(points), rel=1e-9)


# relief on designs that need it

WILD_A = np.array([(0, 0, 0), (400, 0, 300), (800, 0, -100), (1200, 0, 350)])
WILD_B = np.array([(0, 0, 0), (150, 400, -250), (-100, 800, 200), (200, 1200, -150)])


@pytest.mark.parametrize("side", ["outer", "inner", "centre"])
def test_plain_panels_collide_where_relieved_ones_do_not(side):
    mesh = vector_sum(WILD_A, WILD_B)
    plain = thicken(mesh, 20, side=side, nodes="plain")
    assert shared_balls(plain.solids, pairs_that_share_a_node(plain)).max() > 0.1
    relieved = thicken(mesh, 20, side=side)
    require_touching_only(relieved)
    assert (relieved.volumes <= plain.volumes + 1e-6).all()
    assert 0 < relieved.relief_share.max() < 0.02


def test_relief_faces_of_a_pair_lie_in_one_plane():
    shell = thicken(vector_sum(WILD_A, WILD_B), 20)
    solids = shell.solids
    owner = solids.solid_of_face
    number = {
        (int(owner[f]), int(solids.mates[f])): planes_of(solids, owner[f])[
            f - solids.solid_offsets[owner[f]]
        ]
        for f in np.flatnonzero(solids.kinds == Kind.RELIEF)
    }
    both = [key for key in number if key[::-1] in number]
    assert both
    for one, other in both:
        np.testing.assert_allclose(number[(one, other)], -number[(other, one)], atol=1e-9)


# bad input


@pytest.mark.parametrize(
    ("thickness", "options", "error", "message"),
    [
        (0, {}, InputError, "Thickness must be positive, got 0"),
        (-3, {}, InputError, "Thickness must be positive, got -3"),
        (np.nan, {}, InputError, "Thickness must be positive, got nan"),
        (np.inf, {}, InputError, "Thickness must be positive, got inf"),
        (10, {"clearance": -0.1}, InputError, "Clearance must not be negative, got -0.1"),
        (10, {"clearance": np.nan}, InputError, "Clearance must not be negative, got nan"),
        (10, {"side": "middle"}, InputError, "side must be one of outer, inner, centre"),
        (10, {"nodes": "none"}, InputError, "nodes must be one of relief, axis, plain"),
        (10, {"clearance": 500}, ThicknessError, "clearance of 500 mm leaves nothing.*left"),
        (1e5, {"side": "inner"}, ThicknessError, "too thick for the folds of left, right"),
    ],
)
def test_bad_input_is_refused_each_with_its_own_error(thickness, options, error, message):
    with pytest.raises(error, match=message):
        thicken(roof(90), thickness, **options)


def test_knife_fold_is_refused_naming_both_faces():
    mesh = Mesh(
        [(0, 0, 0), (1000, 0, 0), (1000, 500, 0), (0, 500, 0), (1000, 400, 0), (0, 400, 0)],
        [[0, 1, 2, 3], [1, 0, 5, 4]],
    )
    with pytest.raises(SelfIntersectionError, match="fold back flat") as caught:
        thicken(mesh, 10)
    assert caught.value.addresses == ("f0000", "f0001")


def test_design_that_crosses_itself_at_a_node_is_refused_before_it_is_too_thick():
    # a flat fan that winds around its node by 500 degrees
    turns = np.radians([0, 100, 200, 300, 400, 500])
    ring = [(400 * np.cos(t), 400 * np.sin(t), 0) for t in turns]
    faces = [[0, k, k + 1] for k in range(1, 6)]
    for thickness in (10, 1e6):
        with pytest.raises(SelfIntersectionError, match="overlap at the node") as caught:
            thicken(Mesh([(0, 0, 0), *ring], faces), thickness)
        assert caught.value.addresses == ("f0000", "f0001", "f0003", "f0004")


@settings(max_examples=30)
@given(vector_sums(), panel_sides)
def test_shell_is_the_same_when_made_again(mesh, side):
    one, other = (accepted(thicken, mesh, 7, side=side) for _ in range(2))
    np.testing.assert_array_equal(one.solids.vertices, other.solids.vertices)
    np.testing.assert_array_equal(one.solids.loops, other.solids.loops)
