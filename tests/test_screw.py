"""Screws that join the layers of a vault, against the planks' outlines by shapely."""

import math
from itertools import combinations, pairwise

import numpy as np
import pytest
from shapely.geometry import LineString, Point, Polygon

import ifs_cad as ifs
from ifs_cad.elements.cutting import cutting_frames
from ifs_cad.elements.hole import Holes
from ifs_cad.elements.polyhedron import Kind
from ifs_cad.elements.screw import Screws
from ifs_cad.errors import HoleError, InputError
from ifs_cad.kernel.panels import make_panels

FLOOR = ifs.Plane((0, 0, 0), (0, 0, 1))
ARCH = ifs.Curve([(0, 0, 0), (-200, 0, 4000), (6500, 0, 4500), (6000, 0, 0)], depth=4)
STRAIGHT = [(0, 0, 0), (0, 0, 1000)]
BARE = {"end": 40.0, "edge": 20.0, "between": 30.0}


def pair(length=1000.0, width=160.0, layers=2):
    return ifs.vault([(0, 0, 0), (0, 0, length)], width, 40, layers=layers, across=(0, 1, 0))


def holes_of(vault, screws, face="inner"):
    """The (k, 2) places of the holes of each plank in the plane x, z of the vault."""
    frames = cutting_frames(vault, face)
    places = screws.place(vault, frames)
    found = []
    for k in range(len(vault)):
        flat = places.points[k][places.present[k]]
        local = np.column_stack([flat, np.zeros(len(flat))])
        found.append((local @ frames.axes[k] + frames.origins[k])[:, [0, 2]])
    return found


def lines_of(vault, plank):
    """The outline of a plank in x, z, and its ends and long sides as lines."""
    solids = vault.solids
    own = np.flatnonzero(solids.solid_of_face == plank)
    loops = {
        int(f): solids.vertices[solids.loops[solids.face_offsets[f] : solids.face_offsets[f + 1]]]
        for f in own
    }
    (cap,) = (f for f in loops if solids.kinds[f] == Kind.UPPER)
    ends, edges = [], []
    for face, corners in loops.items():
        if solids.kinds[face] <= Kind.UPPER:
            continue
        line = LineString(sorted({tuple(p) for p in np.round(corners[:, [0, 2]], 6)}))
        along = abs(solids.normals[face] @ vault.directions[plank])
        (edges if along < 1e-9 else ends).append(line)
    return Polygon(loops[cap][:, [0, 2]]), ends, edges


def assert_pattern(vault, screws):
    """Every demand on screws, for a whole vault; returns the places between each two layers."""
    holes = holes_of(vault, screws)
    for k, places in enumerate(holes):
        outline, ends, edges = lines_of(vault, k)
        for x, z in places:
            assert outline.contains(Point(x, z))
            assert min(line.distance(Point(x, z)) for line in ends) >= screws.end - 1e-5
            assert min(line.distance(Point(x, z)) for line in edges) >= screws.edge - 1e-5
        for one, other in combinations(places, 2):
            assert math.dist(one, other) >= screws.between - 1e-6
    # each hole has its partner at the same place in one of the next layers
    joined = []
    by_layer = [
        np.concatenate([holes[k] for k in np.flatnonzero(vault.layer == layer)])
        for layer in range(vault.segments.count)
    ]
    left = [set(range(len(places))) for places in by_layer]
    for lower in range(len(by_layer) - 1):
        apart = np.linalg.norm(by_layer[lower][:, None] - by_layer[lower + 1], axis=2)
        near = np.argwhere(apart <= 1e-8)
        assert len(set(near[:, 0])) == len(set(near[:, 1])) == len(near) > 0
        left[lower] -= set(near[:, 0])
        left[lower + 1] -= set(near[:, 1])
        joined.append(by_layer[lower][near[:, 0]])
    assert not any(left)
    return holes, joined


@pytest.mark.parametrize("side", ["outside", "inside", "centre"])
@pytest.mark.parametrize("diameter", [4.0, 8.0])
def test_screws_keep_their_distances_and_join_layers(side, diameter):
    vault = ifs.vault(ARCH, 160, 40, layers=4, side=side, stagger=True, springing=FLOOR)
    screws = Screws(diameter, spacing=300)
    assert (screws.end, screws.edge, screws.between) == (7 * diameter, 3 * diameter, 5 * diameter)
    assert screws.hole == pytest.approx(0.7 * diameter)
    holes, joined = assert_pattern(vault, screws)
    # two to each neighbouring layer
    for k, places in enumerate(holes):
        for other in (vault.layer[k] - 1, vault.layer[k]):
            if 0 <= other < 3:
                near = np.linalg.norm(places[:, None] - joined[other], axis=2).min(axis=1)
                assert (near <= 1e-8).sum() >= 2
    # no screw near a joint of the two layers that it joins
    for k in range(len(vault)):
        for end in lines_of(vault, k)[1]:
            for layer in (vault.layer[k] - 1, vault.layer[k]):
                if 0 <= layer < 3:
                    nearest = min(end.distance(Point(place)) for place in joined[layer])
                    assert nearest >= screws.end - 1e-5


@pytest.mark.parametrize("seed", range(4))
def test_screws_of_wandering_layers_keep_their_distances(seed):
    rng = np.random.default_rng(seed)
    control = ARCH.projection[1:].T
    curves = [
        ifs.Curve(control + rng.uniform(-40, 40, (4, 1)) * [1, 0, 1], depth=3 + k % 2)
        for k in range(4)
    ]
    floor = ifs.Plane((0, 0, 60), (0, 0, 1))
    vault = ifs.vault(curves, 200, 40, springing=floor, across=(0, 1, 0), clearance=1)
    assert_pattern(vault, Screws(5.0, spacing=rng.uniform(90, 400), fewest=1, **BARE))


@pytest.mark.parametrize("spacing", [60.0, 100.0, 131.0, 250.0, 920.0, 5000.0])
def test_spacing_is_the_largest_distance(spacing):
    screws = Screws(5.0, spacing=spacing, **BARE)
    (places, again) = holes_of(pair(), screws)
    along = np.sort(places[:, 1])
    np.testing.assert_allclose(again[np.argsort(again[:, 1])], places[np.argsort(places[:, 1])])
    # evenly from end to end, as few as keep to it
    np.testing.assert_allclose(along[[0, -1]], [40, 960], atol=1e-9)
    count = math.ceil(920 / spacing) + 1
    np.testing.assert_allclose(along, np.linspace(40, 960, count), atol=1e-9)
    assert np.ptp(places[:, 0]) <= 1e-9


def test_screws_stand_no_closer_than_between_whatever_the_spacing():
    places, _ = holes_of(pair(), Screws(5.0, spacing=10.0, **BARE))
    assert np.diff(np.sort(places[:, 1])).min() >= 30 - 1e-9
    assert len(places) == 31  # 920 // 30 distances


def test_screws_of_the_next_pair_of_layers_stand_on_the_other_half():
    vault = pair(layers=4)
    holes = holes_of(vault, Screws(5.0, spacing=400, **BARE))
    assert [len(places) for places in holes] == [4, 8, 8, 4]
    first, second = holes[0][:, 0], holes[3][:, 0]
    assert first[0] * second[0] > 0  # layers 0-1 and 2-3 alike
    assert abs(first[0]) >= 15
    middle = set(np.round(holes[1][:, 0], 6))
    assert len(middle) == 2
    assert min(middle) < 0 < max(middle)


def test_narrow_planks_have_screws_in_one_line_that_stay_apart():
    vault = pair(width=41.0, layers=3)
    holes = holes_of(vault, Screws(5.0, spacing=400, **BARE))
    along = np.sort(holes[1][:, 1])
    assert len(along) == 8
    assert np.diff(along).min() >= 30 - 2.0  # on lines up to 1 mm apart
    for one, other in pairwise(sorted(map(tuple, holes[1]), key=lambda p: p[1])):
        assert math.dist(one, other) >= 30 - 1e-9


def test_planks_exactly_as_wide_as_two_edges_take_screws():
    places, _ = holes_of(pair(width=40.0), Screws(5.0, spacing=400, **BARE))
    np.testing.assert_allclose(places[:, 0], 0.0, atol=1e-9)
    assert len(places) == 4


def test_short_overlap_takes_one_screw_in_its_middle():
    places, _ = holes_of(pair(length=100.0), Screws(5.0, fewest=1, **BARE))
    np.testing.assert_allclose(places[:, 1], [50.0], atol=1e-9)


@pytest.mark.parametrize(("length", "width"), [(100.0, 160.0), (79.0, 160.0)])
def test_too_few_screws_name_the_planks(length, width):
    with pytest.raises(HoleError, match=r"fewer than 2 screws.*L00-0") as caught:
        holes_of(pair(length, width), Screws(5.0, **BARE))
    assert caught.value.addresses == ("L00-0",)


def test_planks_that_nothing_overlaps_are_named():
    far = ifs.vault(
        [STRAIGHT, np.array(STRAIGHT) + np.array([400, 0, 0])], 160, 40, across=(0, 1, 0)
    )
    with pytest.raises(HoleError, match=r"fewer than 1 screws.*overlap more"):
        holes_of(far, Screws(fewest=1))


def test_planks_narrower_than_two_edges_are_an_error():
    with pytest.raises(HoleError, match="39 mm wide have no room for screws 20 mm from both edges"):
        holes_of(pair(width=39.0), Screws(5.0, **BARE))


def test_part_has_the_holes_that_it_has_in_the_whole():
    vault = ifs.vault(ARCH, 160, 40, layers=4, stagger=True, springing=FLOOR)
    screws = Screws(5.0, spacing=300)
    whole = dict(zip(vault.addresses, holes_of(vault, screws), strict=True))
    for pattern in ("L02*", ["L00-0000", "L03-1*"]):
        part = vault.part(pattern)
        for address, places in zip(part.addresses, holes_of(part, screws), strict=True):
            assert sorted(map(tuple, np.round(places, 6))) == sorted(
                map(tuple, np.round(whole[address], 6))
            )


def test_holes_are_the_same_whichever_face_lies_up():
    vault = ifs.vault(ARCH, 160, 40, layers=2, stagger=True)
    for one, other in zip(
        holes_of(vault, Screws()), holes_of(vault, Screws(), "outer"), strict=True
    ):
        np.testing.assert_allclose(one, other, atol=1e-8)


def test_solids_have_the_holes_and_a_clear_label():
    vault = ifs.vault(ARCH.with_depth(3), 160, 40, layers=2, stagger=True, springing=FLOOR)
    screws = Screws(6.0, spacing=300)
    holes = holes_of(vault, screws)
    made = make_panels(vault, label=ifs.Label(cutter=3), holes=screws)
    for k, panel in enumerate(made):
        assert panel.solid.isValid()
        bored = [f for f in panel.solid.Faces() if f.geomType() == "CYLINDER"]
        through = [f for f in bored if abs(f.BoundingBox().zlen - 40) < 1e-6]
        radius, area = 0.7 * 6 / 2, sum(f.Area() for f in through)
        assert area == pytest.approx(len(holes[k]) * 2 * math.pi * radius * 40, rel=1e-6)
        assert panel.solid.Volume() == pytest.approx(panel.volume, rel=1e-9)


def test_shells_have_no_screws():
    curve = ifs.Curve([(0, 0, 0), (0, 0, 900), (900, 0, 900)], depth=1)
    shell = ifs.thicken(ifs.vector_sum(curve, [(0, 0, 0), (0, 500, 0)]), 10)
    with pytest.raises(InputError, match="Only the planks of a vault"):
        Screws().place(shell, cutting_frames(shell))


def test_single_layer_has_nothing_to_be_screwed_to():
    with pytest.raises(InputError, match="vault of one layer"):
        holes_of(pair(layers=1), Screws())


def test_planks_may_have_fixation_holes_instead():
    vault = pair()
    places = Holes(5.0, 25.0).place(vault, cutting_frames(vault))
    assert places.present.all()
    assert places.points.shape == (2, 4, 2)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"diameter": 0}, "diameter of screws must be positive"),
        ({"diameter": math.nan}, "diameter of screws must be positive"),
        ({"pilot": -1.0}, "pilot of screws must be positive"),
        ({"spacing": 0}, "spacing of screws must be positive"),
        ({"spacing": math.inf}, "spacing of screws must be positive"),
        ({"end": math.nan}, "end of screws must be positive"),
        ({"edge": 4.0}, "edge of screws must exceed the diameter of their holes, 4.2 mm"),
        ({"between": 0.0}, "between of screws must be positive"),
        ({"fewest": 0}, "fewest screws of a plank must be at least 1"),
    ],
)
def test_screws_that_cannot_be_meant_are_refused(changes, said):
    with pytest.raises(InputError, match=said):
        Screws(**changes)
