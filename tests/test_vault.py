"""Vaults of planks against closed forms computed from the curves' points alone."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import hull_volume, points_of, shared_balls
from strategies import accepted, numbers

import ifs_cad as ifs
from ifs_cad.elements.material import SPRUCE, SPRUCE_PLYWOOD
from ifs_cad.elements.polyhedron import Kind
from ifs_cad.errors import AddressError, FloorError, InputError, PlanarityError, ThicknessError
from ifs_cad.kernel.panels import make_panels

EXACT = {"rtol": 0, "atol": 1e-9}
FLOOR = ifs.Plane((0, 0, 0), (0, 0, 1))
ARCH = ifs.Curve([(0, 0, 0), (-200, 0, 4000), (6500, 0, 4500), (6000, 0, 0)], depth=4)
WAVE = ifs.Curve(
    [(0, 0, 0), (-200, 0, 900), (1500, 0, -150), (900, 0, 2900), (2500, 0, 3500), (3400, 0, 2100)],
    depth=4,
)
RING = [(900 * math.cos(t), 0, 900 * math.sin(t)) for t in np.linspace(0, 2 * np.pi, 13)]
RING[-1] = RING[0]
sides = st.sampled_from(["outside", "inside", "centre"])
LEVELS = {"outside": (0.0, 1.0), "inside": (-1.0, 0.0), "centre": (-0.5, 0.5)}


def left_of(steps):
    """The unit vectors to the left of steps in the plane x, z."""
    ahead = steps / np.linalg.norm(steps, axis=1)[:, None]
    return np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)


def expected_of(points, width, side, clearance=0.0):
    """Lengths, end angles (k, 2) in degrees and side lengths (k, 2) of an open polyline in x, z.

    From turning angles, positive where the polyline turns to its right, which is the outside's
    opposite when it is drawn so that it goes up, over and down to the right.
    """
    flat = np.asarray(points)[:, [0, 2]]
    steps = np.diff(flat, axis=0)
    lengths = np.hypot(*steps.T)
    heading = np.arctan2(steps[:, 1], steps[:, 0])
    turns = -((np.diff(heading) + np.pi) % (2 * np.pi) - np.pi)
    area = sum(a[0] * b[1] - a[1] * b[0] for a, b in pairwise([*flat, flat[0]]))
    both = (1.0 if area <= 0 else -1.0) * np.stack(
        [np.append(0.0, turns), np.append(turns, 0.0)], axis=1
    )
    back = np.where(both != 0, clearance / np.cos(both / 2), 0.0).sum(axis=1)
    bend = np.tan(both / 2).sum(axis=1)
    levels = width * np.array(LEVELS[side])
    return lengths, np.degrees(both) / 2, (lengths - back)[:, None] + bend[:, None] * levels


def faces_of(solids, plank, kind):
    """The faces of one kind of one plank: pairs of (corner array, number)."""
    own = np.flatnonzero((solids.solid_of_face == plank) & (solids.kinds == kind))
    return [
        (solids.vertices[solids.loops[solids.face_offsets[f] : solids.face_offsets[f + 1]]], f)
        for f in own
    ]


def assert_joints_mate(vault, clearance=0.0):
    """The two ends of every joint are the same polygon, or lie 2 * clearance apart on planes."""
    solids, joints = vault.solids, 0
    number = {segment: k for k, segment in enumerate(vault.numbers.tolist())}
    for k, segment in enumerate(vault.numbers.tolist()):
        for corners, face in faces_of(solids, k, Kind.CUT):
            other = number[int(solids.mates[face])]
            ((theirs, across),) = (
                (c, f) for c, f in faces_of(solids, other, Kind.CUT) if solids.mates[f] == segment
            )
            np.testing.assert_allclose(solids.normals[face], -solids.normals[across], **EXACT)
            gap = -solids.levels[face] - solids.levels[across]
            assert gap == pytest.approx(2 * clearance, abs=1e-9)
            if clearance == 0:
                near = np.linalg.norm(corners[:, None] - theirs, axis=2)
                assert near.min(axis=1).max() <= 1e-9
                assert near.min(axis=0).max() <= 1e-9
            # the plane halves the angle of the two segments
            mirrored = vault.directions[k] - 2 * solids.normals[face] * (
                vault.directions[k] @ solids.normals[face]
            )
            np.testing.assert_allclose(mirrored, -vault.directions[other], atol=1e-9)
            joints += 1
    return joints


def assert_no_shared_volume(vault):
    assert ifs.clashes(vault) == ()
    for layer in range(vault.segments.count):
        own = np.flatnonzero(vault.layer == layer).tolist()
        assert all(shared_balls(vault.solids, list(pairwise(own))) <= 1e-9)


def assert_layers_touch(vault):
    """The upper faces of each layer and the lower ones of the next lie in one plane."""
    solids, across = vault.solids, vault.segments.across
    base = solids.vertices @ across - float(vault.segments.origin @ across)
    lower = vault.layer[solids.solid_of_vertex] * vault.thickness
    off = base - lower
    assert (np.minimum(np.abs(off), np.abs(off - vault.thickness)) <= 1e-9).all()
    for kind, outward, height in ((Kind.LOWER, -1, 0), (Kind.UPPER, 1, vault.thickness)):
        faces = solids.kinds == kind
        assert faces.sum() == len(vault)
        np.testing.assert_allclose(
            solids.normals[faces], np.tile(outward * across, (len(vault), 1))
        )
        in_face = faces[solids.face_of_loop]
        np.testing.assert_allclose(off[solids.loops[in_face]], height, **EXACT)


@pytest.mark.parametrize("side", LEVELS)
@pytest.mark.parametrize(
    "curve", [ARCH, WAVE, ifs.Curve(WAVE.projection[1:].T, depth=3, transformations=3)]
)
@pytest.mark.parametrize("clearance", [0.0, 1.5])
def test_planks_have_the_lengths_and_half_the_turns_of_their_segments(curve, side, clearance):
    vault = ifs.vault(curve, 90, 30, layers=2, side=side, clearance=clearance)
    lengths, angles, both = expected_of(curve.points, 90, side, clearance)
    np.testing.assert_allclose(vault.segment_lengths, np.tile(lengths, 2), **EXACT)
    np.testing.assert_allclose(vault.end_angles, np.tile(angles, (2, 1)), **EXACT)
    np.testing.assert_allclose(vault.side_lengths, np.tile(both, (2, 1)), **EXACT)
    np.testing.assert_allclose(vault.volumes, np.tile(both.mean(axis=1) * 90 * 30, 2), rtol=1e-12)
    assert assert_joints_mate(vault, clearance) == 4 * (curve.segments - 1)
    assert_no_shared_volume(vault)
    assert_layers_touch(vault)


@settings(max_examples=40)
@given(numbers((5, 2), -3000, 3000), st.floats(5, 400), sides, st.integers(1, 3), st.booleans())
def test_any_vault_is_exact(points, width, side, depth, stagger):
    control = np.column_stack([points[:, 0], np.zeros(5), points[:, 1]])
    curve = accepted(ifs.Curve, control, depth=depth)
    assume(np.linalg.norm(np.diff(accepted(lambda: curve.points), axis=0), axis=1).min() > 10.0)
    vault = accepted(
        ifs.vault, curve, width, 25, layers=2, side=side, stagger=stagger, across=(0, 1, 0)
    )
    assume(np.abs(vault.end_angles).max() < 75)  # sharper ones lose digits in tan
    own = vault.layer == 0
    lengths, angles, both = expected_of(curve.points, width, side)
    np.testing.assert_allclose(vault.segment_lengths[own], lengths, **EXACT)
    # the outside of a vault is that of all its layers together
    turned = np.allclose(vault.end_angles[own], angles, **EXACT)
    assert turned or np.allclose(vault.end_angles[own], -angles, **EXACT)
    if turned:
        np.testing.assert_allclose(vault.side_lengths[own], both, rtol=1e-9, atol=1e-8)
    for k in range(len(vault)):
        assert vault.volumes[k] == pytest.approx(hull_volume(points_of(vault.solids, k)), rel=1e-6)
    np.testing.assert_allclose(
        vault.volumes, vault.side_lengths.mean(axis=1) * width * 25, rtol=1e-6
    )
    assert (vault.side_lengths > 0).all()
    assert_layers_touch(vault)
    neighbours = list(pairwise(np.flatnonzero(own).tolist()))
    assert all(shared_balls(vault.solids, neighbours) <= 1e-6)


def test_whole_vault_shares_no_volume_by_the_kernel():
    vault = ifs.vault(ARCH.with_depth(2), 200, 40, layers=3, stagger=True, springing=FLOOR)
    made = [panel.solid.moved(panel.location) for panel in make_panels(vault)]
    for one in range(len(made)):
        for other in range(one):
            assert made[one].intersect(made[other]).Volume() <= 1e-6
    compound = made[0].fuse(*made[1:])
    assert compound.Volume() == pytest.approx(vault.volumes.sum(), rel=1e-9)


@pytest.mark.parametrize("clearance", [0.0, 0.5])
def test_ring_closes(clearance):
    vault = ifs.vault(RING, 120, 30, layers=2, side="outside", clearance=clearance)
    chord, half = 2 * 900 * math.sin(math.pi / 12), math.pi / 12
    back = 2 * clearance / math.cos(half)
    np.testing.assert_allclose(vault.segment_lengths, chord, **EXACT)
    np.testing.assert_allclose(vault.end_angles, 15.0, **EXACT)
    np.testing.assert_allclose(
        vault.side_lengths,
        np.tile([chord - back, chord - back + 2 * 120 * math.tan(half)], (24, 1)),
        **EXACT,
    )
    np.testing.assert_allclose(vault.radii, 900 * math.cos(half), **EXACT)
    assert assert_joints_mate(vault, clearance) == 48
    assert_no_shared_volume(vault)


@pytest.mark.parametrize("side", LEVELS)
@pytest.mark.parametrize("curve", [ARCH, RING])
def test_outside_is_the_same_whichever_way_the_curve_is_drawn(curve, side):
    points = curve.points if isinstance(curve, ifs.Curve) else np.array(curve)
    one = ifs.vault(points, 100, 30, side=side)
    other = ifs.vault(points[::-1], 100, 30, side=side)
    for k in range(len(one)):
        mine, theirs = points_of(one.solids, k), points_of(other.solids, len(one) - 1 - k)
        near = np.linalg.norm(mine[:, None] - theirs, axis=2).min(axis=1)
        assert near.max() <= 1e-8
    np.testing.assert_allclose(one.side_lengths, other.side_lengths[::-1], atol=1e-8)


def test_sides_of_a_ring_lie_where_they_are_called():
    for side, (low, high) in LEVELS.items():
        flat = points_of(ifs.vault(RING, 120, 30, side=side).solids, 0)[:, [0, 2]]
        middle = (np.array(RING[0]) + RING[1])[[0, 2]] / 2
        outward = middle / np.linalg.norm(middle)
        height = (flat - middle) @ outward
        np.testing.assert_allclose([height.min(), height.max()], [120 * low, 120 * high], atol=1e-9)


def floor_faces(vault):
    solids = vault.solids
    return [
        (solids.vertices[solids.loops[solids.face_offsets[f] : solids.face_offsets[f + 1]]], f)
        for f in np.flatnonzero(solids.kinds == Kind.FLOOR)
    ]


def assert_stands(vault, plane, count):
    """Exactly `count` faces lie on the plane, all their corners to 1e-9, looking down."""
    standing = [
        (corners, face)
        for corners, face in floor_faces(vault)
        if np.abs(plane.height(corners)).max() <= 1e-9
    ]
    assert len(standing) == count
    for _, face in standing:
        np.testing.assert_allclose(vault.solids.normals[face], -np.array(plane.normal), **EXACT)


@pytest.mark.parametrize("side", LEVELS)
@pytest.mark.parametrize("stagger", [False, True])
def test_ends_stand_on_one_plane(side, stagger):
    vault = ifs.vault(ARCH, 160, 40, layers=4, side=side, stagger=stagger, springing=FLOOR)
    assert_stands(vault, FLOOR, 8)
    assert len(floor_faces(vault)) == 8
    assert vault.solids.vertices[:, 2].min() >= -1e-9
    assert vault.lost == ()
    assert vault.stubs == ()
    # at the floor the end is cut by what the plank lacks of upright
    first, last = vault.directions[0], vault.directions[ARCH.segments - 1]
    lean = [
        math.degrees(math.atan2(first[0], first[2])),
        math.degrees(math.atan2(last[0], -last[2])),
    ]
    ends = vault.end_angles[0, 0], vault.end_angles[ARCH.segments - 1, 1]
    np.testing.assert_allclose(np.abs(ends), np.abs(lean), **EXACT)
    left, right = vault.side_lengths[0], vault.side_lengths[ARCH.segments - 1]
    inner = expected_of(ARCH.points, 160, side)[2]
    levels = 160 * np.array(LEVELS[side])
    # a level line at the start meets the floor where the end's angle says
    tangents = np.tan(np.radians([ends[0], ends[1]]))
    np.testing.assert_allclose(left, inner[0] + tangents[0] * levels, **EXACT)
    np.testing.assert_allclose(right, inner[-1] + tangents[1] * levels, **EXACT)
    assert_no_shared_volume(vault)


def test_ends_stand_on_walls_of_different_height_and_slope():
    curve = ifs.Curve([(0, 0, 0), (0, 0, 5000), (5000, 0, 4500), (5600, 0, 2000)], depth=4)
    wall = ifs.Plane((5600, 0, 2000), (-0.3, 0, 1))
    vault = ifs.vault(curve, 150, 40, layers=2, springing=(FLOOR, wall))
    assert len(vault) == 32
    assert_stands(vault, FLOOR, 2)
    assert_stands(vault, wall, 2)
    assert len(floor_faces(vault)) == 4
    # the same drawn from the other end
    back = ifs.vault(curve.points[::-1], 150, 40, layers=2, springing=(wall, FLOOR))
    np.testing.assert_allclose(np.sort(back.volumes), np.sort(vault.volumes), rtol=1e-9)


@pytest.mark.parametrize(
    "points", [[(0, 0, 0), (0, 0, 900)], [(0, 0, 0), (100, 0, 900), (0, 0, 1800)]]
)
def test_few_planks_stand_between_two_planes(points):
    ceiling = ifs.Plane(points[-1], (0.1, 0, -1))
    vault = ifs.vault(points, 150, 40, springing=(FLOOR, ceiling), across=(0, 1, 0))
    assert_stands(vault, FLOOR, 1)
    assert_stands(vault, ceiling, 1)
    assert len(vault) == len(points) - 1


@pytest.mark.parametrize("first", [True, False])
def test_none_in_a_pair_lets_an_end_be_square(first):
    points = WAVE.points if first else WAVE.points[::-1]
    planes = (FLOOR, None) if first else (None, FLOOR)
    vault = ifs.vault(points, 100, 30, springing=planes)
    assert_stands(vault, FLOOR, 1)
    free = len(vault) - 1 if first else 0
    assert vault.end_angles[free, 1 if first else 0] == 0.0
    assert len(floor_faces(vault)) == 1


def test_free_end_may_hang_below_the_plane_of_the_other():
    curve = [(0, 0, 0), (100, 0, 1500), (1500, 0, 1500), (1600, 0, -300)]
    vault = ifs.vault(curve, 100, 30, springing=(FLOOR, None))
    assert len(vault) == 3
    assert len(floor_faces(vault)) == 1
    assert vault.solids.vertices[:, 2].min() < -250


def test_high_springing_takes_whole_planks_off():
    # the third joint, exactly, and a bit above it
    level = float(ARCH.points[3, 2])
    plane = ifs.Plane((0, 0, level), (0, 0, 1))
    vault = ifs.vault(ARCH, 100, 30, springing=plane)
    whole = ifs.vault(ARCH, 100, 30)
    assert set(vault.addresses) | set(vault.lost) == set(whole.addresses)
    assert not set(vault.addresses) & set(vault.lost)
    assert {"L00-0000", "L00-0001"} <= set(vault.lost)
    assert vault.solids.vertices[:, 2].min() == pytest.approx(level, abs=1e-9)
    kept = np.isin(whole.addresses, vault.addresses)
    assert (vault.volumes <= whole.volumes[kept] + 1e-6).all()
    assert_no_shared_volume(vault)
    # mates that are lost are none
    made = set(vault.numbers.tolist())
    assert {int(m) for m in vault.solids.mates} <= made | {-1}
    assert "below the springing" in str(vault.report())


def test_plane_through_a_joint_leaves_a_stub_that_is_named():
    curve = [(0, 0, 0), (0, 0, 500), (500, 0, 1000), (1500, 0, 1000), (2000, 0, 500), (2000, 0, 0)]
    vault = ifs.vault(curve, 200, 30, springing=ifs.Plane((0, 0, 500), (0, 0, 1)))
    assert vault.lost == ()
    assert vault.stubs == ("L00-0", "L00-4")
    assert_no_shared_volume(vault)
    # inside of the joint the bisector lies below the plane, outside above: a triangle stays
    corner = 100 * math.tan(math.radians(22.5))
    assert vault.volumes[0] == pytest.approx(corner * 100 / 2 * 30, rel=1e-9)
    assert "no full width" in str(vault.report())


def test_ring_stands_on_a_floor():
    plane = ifs.Plane((0, 0, -450), (0, 0, 1))
    vault = ifs.vault(RING, 120, 30, layers=2, springing=plane)
    assert_stands(vault, plane, len(floor_faces(vault)))
    assert len(floor_faces(vault)) >= 4
    assert vault.solids.vertices[:, 2].min() == pytest.approx(-450, abs=1e-9)
    assert_no_shared_volume(vault)


@pytest.mark.parametrize("side", LEVELS)
@pytest.mark.parametrize("clearance", [0.0, 2.0])
def test_widest_that_the_error_names_is_where_planks_vanish(side, clearance):
    curve = [(0, 0, 0), (100, 0, 300), (300, 0, 400), (500, 0, 300), (450, 0, 0)]
    options = {"side": side, "clearance": clearance}
    try:
        ifs.vault(curve, 1e5, 30, **options)
    except ThicknessError as error:
        widest, said = error.values["widest"], error
    else:
        assert side == "outside"  # an arch turns one way only
        return
    assert "would fit" in str(said)
    for share, fits in ((1 - 1e-9, True), (1 + 1e-9, False)):
        if fits:
            vault = ifs.vault(curve, widest * share, 30, **options)
            assert 0 < vault.side_lengths.min() < 1e-5
            assert assert_joints_mate(vault, clearance) == 6
        else:
            with pytest.raises(ThicknessError) as caught:
                ifs.vault(curve, widest * share, 30, **options)
            assert caught.value.addresses[0] in said.addresses
            # the plank reaches exactly as far as the radius there
            values = caught.value.values
            assert values["radius"] == pytest.approx(values["smallest_radius"], rel=1e-6)
            assert values["smallest_radius"] == pytest.approx(
                widest * (0.5 if side == "centre" else 1.0), rel=1e-6
            )


def test_too_tight_curve_names_its_planks_and_the_radius():
    with pytest.raises(ThicknessError, match=r"at L00-\d+ its radius is 869\.333 mm") as caught:
        ifs.vault(RING, 900, 30, side="inside", layers=2)
    assert len(caught.value.addresses) == 24
    assert caught.value.values["radius"] == pytest.approx(900 * math.cos(math.pi / 12))
    assert caught.value.values["widest"] == pytest.approx(900 * math.cos(math.pi / 12))


def test_clearance_that_leaves_nothing_is_an_error():
    with pytest.raises(ThicknessError, match="clearance of 300 mm leaves nothing of L00-00"):
        ifs.vault(RING, 100, 30, clearance=300)


@pytest.mark.parametrize("side", LEVELS)
def test_curve_that_turns_straight_back_is_refused(side):
    for curve in (
        [(0, 0, 0), (900, 0, 0), (100, 0, 0)],
        ifs.Curve([(0, 0), (900, 0), (900, 0), (0, 0)], depth=1),
    ):
        with pytest.raises(ThicknessError, match=r"straight back between L00-0, L00-1"):
            ifs.vault(
                curve,
                10,
                30,
                side=side,
                across=(0, 0, 1) if isinstance(curve, ifs.Curve) else (0, 1, 0),
            )


def test_end_above_its_springing_names_the_drop():
    with pytest.raises(FloorError, match=r"ends up to 30\.000 mm above.*L00-1111") as caught:
        ifs.vault(ARCH, 100, 30, springing=ifs.Plane((0, 0, -30), (0, 0, 1)))
    assert caught.value.values["drop"] == pytest.approx(30)
    ifs.vault(ARCH, 100, 30, springing=ifs.Plane((0, 0, 0), (0, 0, 1)))


@pytest.mark.parametrize(
    "planes", [FLOOR, (FLOOR, None), (FLOOR, ifs.Plane((0, 0, 0), (0.1, 0, 1)))]
)
def test_curve_that_dips_below_its_springing_midway_is_an_error(planes):
    curve = [(0, 0, 0), (50, 0, 800), (900, 0, -100), (1800, 0, 800), (1850, 0, -200)]
    with pytest.raises(FloorError, match="dips below its springing plane midway") as caught:
        ifs.vault(curve, 50, 30, springing=planes)
    assert set(caught.value.addresses) >= {"L00-1", "L00-2"}


def test_level_end_cannot_stand():
    curve = [(0, 0, 0), (500, 0, 0), (900, 0, 400), (1000, 0, -10)]
    with pytest.raises(FloorError, match="At L00-0 the curve does not run down"):
        ifs.vault(curve, 50, 30, springing=FLOOR)


def test_level_end_below_its_springing_is_cut_off_with_its_plank():
    curve = [(0, 0, 0), (500, 0, 0), (900, 0, 900), (1000, 0, -10)]
    plane = ifs.Plane((0, 0, 100), (0, 0, 1))
    vault = ifs.vault(curve, 50, 30, springing=plane)
    assert vault.lost == ("L00-0",)
    assert_stands(vault, plane, 2)


def test_layer_below_its_springing_is_an_error():
    with pytest.raises(FloorError, match="Layer 0 lies below its springing plane"):
        ifs.vault(ARCH, 100, 30, springing=ifs.Plane((0, 0, 9000), (0, 0, 1)))


@pytest.mark.parametrize("curve", [ARCH, RING])
def test_springing_must_be_square_to_the_layers(curve):
    with pytest.raises(InputError, match="must be square to the layers"):
        ifs.vault(curve, 100, 30, springing=ifs.Plane((0, 0, 0), (0, 0.1, 1)))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"width": 0}, "width of planks must be positive, got 0"),
        ({"width": -5}, "width of planks must be positive"),
        ({"width": math.nan}, "width of planks must be positive, got nan"),
        ({"width": math.inf}, "width of planks must be positive"),
        ({"width": "wide"}, "width of planks must be a number"),
        ({"thickness": 0}, "thickness of planks must be positive"),
        ({"thickness": math.nan}, "thickness of planks must be positive"),
        ({"clearance": -0.1}, "clearance of planks must not be negative"),
        ({"clearance": math.nan}, "clearance of planks must not be negative"),
        ({"side": "outer"}, '"outside", "inside" or "centre", got \'outer\''),
        ({"springing": (FLOOR,)}, "must be a Plane, or a pair"),
        ({"springing": (FLOOR, None, None)}, "must be a Plane, or a pair"),
        ({"springing": 0.0}, "must be a Plane, or a pair"),
        ({"layers": 0}, "number of layers must be a whole number"),
    ],
)
def test_what_cannot_be_meant_is_refused(changes, said):
    options = {"width": 100, "thickness": 30, "layers": 2} | changes
    with pytest.raises(InputError, match=said):
        ifs.vault(ARCH, **options)


def test_curve_in_space_is_refused():
    with pytest.raises(PlanarityError, match="layer 0 leaves the plane"):
        ifs.vault(
            ifs.Curve([(0, 0, 0), (0, 100, 900), (900, 0, 900), (900, 0, 0)], depth=2), 50, 20
        )


def test_layers_may_have_curves_of_their_own():
    curves = [ARCH.with_control_point(2, (6500, 0, 4500 + 100 * k)) for k in range(3)]
    vault = ifs.vault([curves[0], curves[1].points, curves[2]], 100, 30)
    expected = np.concatenate([expected_of(c.points, 100, "centre")[0] for c in curves])
    np.testing.assert_allclose(vault.segment_lengths, expected, **EXACT)
    assert vault.addresses[16] == "L01-00"
    assert_layers_touch(vault)
    assert_no_shared_volume(vault)


def test_curves_at_other_places_across_stand_jointlessly():
    points = ARCH.points
    vault = ifs.vault(
        [points, points + np.array([0, 777, 0]), points - np.array([0, 99, 0])], 100, 30
    )
    assert_layers_touch(vault)
    assert np.ptp(vault.solids.vertices[:, 1]) == pytest.approx(90, abs=1e-9)


@pytest.mark.parametrize("first", [2, 3])
def test_schemes_of_two_and_three_transformations_stagger(first):
    control = ARCH.projection[1:].T
    two, three = ifs.Curve(control, depth=3), ifs.Curve(control, depth=2, transformations=3)
    curves = [two, three] if first == 2 else [three, two]
    vault = ifs.vault(curves, 100, 30, layers=4)
    # joints at eighths and at ninths of the parameter: 1/72 apart at least
    one, other = two.points[1:-1], three.points[1:-1]
    nearest = np.linalg.norm(one[:, None] - other, axis=2).min()
    np.testing.assert_allclose(vault.joint_distances, nearest, **EXACT)
    assert nearest > 30


def test_joint_distances_are_those_of_the_points():
    vault = ifs.vault(ARCH, 100, 30, layers=3, stagger=True)
    fine = ARCH.with_depth(5).points
    nearest = np.linalg.norm(fine[2:-1:2][:, None] - fine[1::2], axis=2).min()
    np.testing.assert_allclose(vault.joint_distances, nearest, **EXACT)
    np.testing.assert_array_equal(ifs.vault(ARCH, 100, 30, layers=2).joint_distances, [0.0])
    single = ifs.vault([(0, 0, 0), (0, 0, 900)], 100, 30, layers=2, across=(0, 1, 0))
    np.testing.assert_array_equal(single.joint_distances, [np.inf])


@pytest.mark.parametrize("factor", [0.1, 3.0])
def test_model_scales_all_but_its_thickness(factor):
    vault = ifs.vault(
        ARCH.points + np.array([50, 60, 0]), 160, 40, layers=3, clearance=1.0, springing=FLOOR
    )
    model = vault.scale(factor, 7.0, SPRUCE_PLYWOOD)
    assert model.addresses == vault.addresses
    assert (model.thickness, model.material) == (7.0, SPRUCE_PLYWOOD)
    assert model.width == pytest.approx(160 * factor)
    expected = vault.solids.vertices * factor
    across = vault.solids.vertices[:, 1] - 60
    expected[:, 1] = 60 * factor + across / 40 * 7.0
    for k in range(len(vault)):
        apart = points_of(model.solids, k)[:, None] - expected[vault.solids.solid_of_vertex == k]
        near = np.linalg.norm(apart, axis=2)
        assert near.shape[0] == near.shape[1]
        assert max(near.min(axis=0).max(), near.min(axis=1).max()) <= 1e-8
    np.testing.assert_allclose(model.end_angles, vault.end_angles, atol=1e-8)
    assert vault.scale(factor, 7.0).material is SPRUCE
    some = vault.part("L01*").scale(factor, 7.0)
    assert some.addresses == vault.part("L01*").addresses


@pytest.mark.parametrize(
    ("factor", "thickness"), [(0, 1), (-1, 1), (math.nan, 1), (0.1, 0), (0.1, math.nan)]
)
def test_impossible_models_are_refused(factor, thickness):
    with pytest.raises(InputError, match="must be positive"):
        ifs.vault(ARCH, 100, 30).scale(factor, thickness)


def test_part_keeps_ends_and_the_names_of_its_mates():
    vault = ifs.vault(ARCH, 100, 30, layers=3, springing=FLOOR)
    part = vault.part(["L01-000*", "L02-1111"])
    assert part.addresses == ("L01-0000", "L01-0001", "L02-1111")
    chosen = [vault.addresses.index(address) for address in part.addresses]
    for name in ("side_lengths", "end_angles", "volumes", "segment_lengths", "directions", "layer"):
        np.testing.assert_array_equal(getattr(part, name), getattr(vault, name)[chosen])
    mates = part.solids.mates[part.solids.kinds == Kind.CUT]
    names = [part.mate_addresses[m] for m in mates]
    assert sorted(names) == ["L01-0000", "L01-0001", "L01-0010", "L02-1110"]
    assert part.whole.addresses == vault.addresses
    with pytest.raises(AddressError, match="L09"):
        vault.part("L09*")


def test_report_says_what_is_to_be_made():
    vault = ifs.vault(ARCH, 160, 40, layers=4, stagger=True, springing=FLOOR, clearance=0.25)
    report = vault.report()
    assert (report.planks, report.layers) == (len(vault), 4) == (66, 4)
    assert report.depth == pytest.approx(160)
    assert report.volume == pytest.approx(vault.volumes.sum() * 1e-9)
    assert report.mass == pytest.approx(report.volume * 440)
    assert report.running == pytest.approx(vault.lengths.sum() / 1000)
    assert report.lengths == (vault.lengths.min(), vault.lengths.max())
    assert report.joint_gap == 0.5
    assert report.joint_distance == pytest.approx(vault.joint_distances.min())
    heaviest = vault.addresses[int(vault.masses.argmax())]
    assert report.heaviest == (heaviest, pytest.approx(vault.masses.max()))
    assert report.warnings == ()
    lines = str(report).splitlines()
    assert lines[0] == "planks          66 of 160 x 40 mm spruce"
    assert lines[1] == "layers          4, 0.16 m in all"
    assert any(line.startswith("tightest        radius") for line in lines)
    assert any(line == "joint gap       0.5 mm" for line in lines)
    (warning,) = ifs.vault(ARCH, 160, 40, layers=2).report().warnings
    assert "joints lie on joints" in warning


def test_lengths_of_boards_are_what_planks_reach_along():
    vault = ifs.vault(ARCH, 160, 40, layers=1)
    lengths, angles, _ = expected_of(ARCH.points, 160, "centre")
    reach = lengths + 80 * np.tan(np.radians(np.abs(angles))).sum(axis=1)
    np.testing.assert_allclose(vault.lengths, reach, **EXACT)


def test_assembly_carries_the_data_of_planks():
    vault = ifs.vault(ARCH.with_depth(2), 160, 40, layers=2, springing=FLOOR)
    assembly = ifs.to_assembly(vault, label=ifs.Label(cutter=2), nest=1, name="vault")
    for k, address in enumerate(vault.addresses):
        part = assembly.objects[address]
        assert part.parent.name == f"vault-{address[:3]}"
        data = part.metadata
        assert data["layer"] == vault.layer[k]
        assert (data["width"], data["thickness"]) == (160, 40)
        assert (data["length_inside"], data["length_outside"]) == tuple(vault.side_lengths[k])
        assert data["end_angles"] == vault.end_angles[k].tolist()
        assert data["mass"] == pytest.approx(vault.volumes[k] * 440e-9)
        assert part.obj.isValid()
        assert data["volume"] < vault.volumes[k]
