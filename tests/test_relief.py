"""Node relief: which panels collide at a node, and the plane that keeps them apart."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import pairs_that_share_a_node, shared_balls
from scipy.optimize import linprog, nnls
from scipy.sparse import block_diag
from strategies import accepted, fans, panel_sides, triangle_meshes, vector_sums

from ifs_cad.design.mesh import Mesh
from ifs_cad.design.surface import vector_sum
from ifs_cad.elements.polyhedron import Kind
from ifs_cad.elements.relief import MARGIN_SHARE, find_reliefs
from ifs_cad.elements.thicken import thicken
from ifs_cad.errors import IfsCadError

SIDES = {"outer": (1,), "inner": (-1,), "centre": (1, -1)}


def reliefs_of(shell):
    """Return the reliefs of a shell's mesh."""
    sides = SIDES[shell.thickening.side]
    return find_reliefs(shell.mesh, shell.cuts, shell.corner_rises, sides)


def edges_at(mesh, corner):
    """Return the two unit edges of a face that leave from one of its corners."""
    ring = mesh.positions
    ahead = ring[mesh.next[corner]] - ring[corner]
    back = ring[mesh.previous[corner]] - ring[corner]
    return [ahead / np.linalg.norm(ahead), back / np.linalg.norm(back)]


def pairs_with_corners(mesh):
    """Return (corner, corner) of every two faces that share a node and no edge at it."""
    found = []
    for node in range(len(mesh.vertices)):
        corners = np.flatnonzero(mesh.corners == node)
        for k, one in enumerate(corners):
            for other in corners[k + 1 :]:
                ends = [
                    set(mesh.corners[[mesh.next[c], mesh.previous[c]]].tolist())
                    for c in (one, other)
                ]
                if not ends[0] & ends[1]:
                    found.append((int(one), int(other)))
    return found


def largest(blocks):
    """Return the largest s for each block of rows: row . x >= s for all of them, |x_i| <= 1."""
    if not blocks:
        return np.empty(0)
    answer = linprog(
        c=np.tile([0, 0, 0, -1.0], len(blocks)),
        A_ub=block_diag(
            [np.column_stack([-np.array(rows), np.ones(len(rows))]) for rows in blocks],
            format="csr",
        ),
        b_ub=np.zeros(sum(map(len, blocks))),
        bounds=[(-1, 1), (-1, 1), (-1, 1), (None, None)] * len(blocks),
        method="highs",
    )
    assert answer.status == 0
    return answer.x[3::4]


def depths_of_overlap(shell, pairs):
    """Return how deep each pair of corner cones overlaps: the least height above their facets.

    The cones are those of the design: two cut planes, and the face plane unless "centre".
    """
    mesh, blocks = shell.mesh, []
    for pair in pairs:
        facets = [shell.cuts[c] for corner in pair for c in (corner, mesh.previous[corner])]
        if shell.thickening.side != "centre":
            sign = 1 if shell.thickening.side == "outer" else -1
            facets += [sign * mesh.normals[mesh.face[c]] for c in pair]
        blocks.append(facets)
    return largest(blocks)


def widths_between(shell, pairs):
    """Return how far a plane can keep from the rays of each pair of corner cones."""
    mesh, blocks = shell.mesh, []
    for pair in pairs:
        rays = []
        for sign, corner in zip((1, -1), pair, strict=True):
            rise = shell.corner_rises[corner] / np.linalg.norm(shell.corner_rises[corner])
            upright = [side * rise for side in SIDES[shell.thickening.side]]
            rays += [sign * ray for ray in edges_at(mesh, corner) + upright]
        blocks.append(rays)
    return largest(blocks)


@settings(max_examples=150)
@given(st.one_of(vector_sums(), triangle_meshes(), fans()), panel_sides)
def test_pairs_that_collide_are_those_of_linear_programming(mesh, side):
    shell = accepted(thicken, mesh, 0.001, side=side, nodes="plain")
    try:
        reliefs = reliefs_of(shell)
    except IfsCadError:
        return
    found = {frozenset(pair) for pair in reliefs.corners.reshape(2, -1).T.tolist()}
    pairs = pairs_with_corners(mesh)
    depths, widths = depths_of_overlap(shell, pairs), widths_between(shell, pairs)
    for pair, depth, width in zip(pairs, depths, widths, strict=True):
        if depth > 1e-6:
            assert frozenset(pair) in found
        if width > 1e-6:
            assert frozenset(pair) not in found
    assert found <= {frozenset(pair) for pair in pairs}


@settings(max_examples=100)
@given(st.one_of(vector_sums(), triangle_meshes(), fans()), panel_sides)
def test_relief_plane_keeps_half_of_the_best_margin(mesh, side):
    shell = accepted(thicken, mesh, 0.001, side=side)
    reliefs = reliefs_of(shell)
    half = len(reliefs.corners) // 2
    np.testing.assert_array_equal(reliefs.normals[:half], -reliefs.normals[half:])
    np.testing.assert_allclose(np.linalg.norm(reliefs.normals, axis=1), 1, atol=1e-12)
    for one, other, plane in zip(
        reliefs.corners[:half], reliefs.corners[half:], reliefs.normals[:half], strict=True
    ):
        edges = np.array([*edges_at(mesh, one), *(-e for e in edges_at(mesh, other))])
        margin = (edges @ plane).min()
        # the best margin of any plane is the distance of the edges' convex hull from the node
        best = hull_distance(edges)
        assert margin >= MARGIN_SHARE * best - 1e-9
        between = mesh.normals[mesh.face[one]] - mesh.normals[mesh.face[other]]
        if np.linalg.norm(between) > 1e-5:
            plain = between / np.linalg.norm(between)
            of_plain = max((edges @ plain).min(), (-edges @ plain).min())
            if of_plain >= MARGIN_SHARE * best + 1e-9:
                assert abs(plain @ plane) == pytest.approx(1, abs=1e-12)
            elif of_plain < MARGIN_SHARE * best - 1e-6:
                assert margin == pytest.approx(MARGIN_SHARE * best, abs=1e-7)


def hull_distance(points):
    """Return the distance from the origin to the convex hull of points.

    That is the reciprocal length of the shortest w with w . point >= 1 for all of them: Lawson and
    Hanson's least distance programming, by non-negative least squares.
    """
    rest = np.append(np.zeros(3), -1.0)
    rows = np.vstack([points.T, np.ones(len(points))])
    rest = rows @ nnls(rows, -rest)[0] + rest
    size = np.linalg.norm(rest[:3])
    return float(-rest[3] / size) if size > 1e-12 else 0.0


def test_opposite_faces_with_equal_normals_are_parted_by_the_best_plane():
    # two level triangles meet in a node between two valleys that fall away steeply
    ring = [
        (-300, 400, 0),
        (-300, -400, 0),
        (0, -500, -900),
        (300, -400, 0),
        (300, 400, 0),
        (0, 500, -900),
    ]
    faces = [[0, 1 + k, 1 + (k + 1) % 6] for k in range(6)]
    mesh = Mesh([(0, 0, 0), *ring], faces)
    plain = thicken(mesh, 20, nodes="plain")
    assert shared_balls(plain.solids, [(0, 3)])[0] > 1
    np.testing.assert_array_equal(mesh.normals[0], mesh.normals[3])
    shell = thicken(mesh, 20)
    assert shared_balls(shell.solids, pairs_that_share_a_node(shell)).max() <= 1e-6
    reliefs = reliefs_of(shell)
    level = reliefs.normals[mesh.face[reliefs.corners] == 0]
    assert (np.abs(level @ [1, 0, 0]) > 1 - 1e-12).any()
    # the face of the design is whole
    lower = (shell.solids.kinds == Kind.LOWER) & (shell.solids.solid_of_face % 3 == 0)
    assert shell.solids.face_areas[lower] == pytest.approx([300 * 400, 300 * 400], rel=1e-12)


def test_plane_along_the_difference_of_normals_is_left_where_it_would_cut_a_face():
    mesh = vector_sum(
        [(0, 0, 0), (100, 200, -600), (600, -100, -400)],
        [(0, 0, 0), (-100, 800, 100), (0, 800, -600)],
    )
    shell = thicken(mesh, 10)
    reliefs = reliefs_of(shell)
    assert len(reliefs.corners) == 2
    one, other = reliefs.corners
    edges = np.array([*edges_at(mesh, one), *(-edge for edge in edges_at(mesh, other))])
    between = mesh.normals[mesh.face[one]] - mesh.normals[mesh.face[other]]
    between /= np.linalg.norm(between)
    assert max((edges @ between).min(), (-edges @ between).min()) < -0.8
    assert (edges @ reliefs.normals[0]).min() > 0.1
    lower = shell.solids.kinds == Kind.LOWER
    assert shell.solids.face_areas[lower] == pytest.approx(mesh.areas, rel=1e-12)
    assert shared_balls(shell.solids, pairs_that_share_a_node(shell)).max() <= 1e-6


@settings(max_examples=200)
@given(fans(valences=(4, 7)), st.sampled_from(["outer", "inner"]))
def test_strong_folds_leave_the_design_faces_whole(mesh, side):
    shell = accepted(thicken, mesh, 5, side=side)
    kind = Kind.LOWER if side == "outer" else Kind.UPPER
    areas = shell.solids.face_areas[shell.solids.kinds == kind]
    perimeters = np.add.reduceat(mesh.edge_lengths, mesh.offsets[:-1])
    slack = np.where(np.maximum.reduceat(shell.set_backs, mesh.offsets[:-1]) > 0, 0.001, 0)
    assert (np.abs(areas - mesh.areas) <= slack * perimeters + 1e-9 * mesh.areas).all()


@pytest.mark.parametrize(
    ("roughness", "of_most", "of_all"), [(40, 1e-4, 1e-3), (80, 1e-3, 1e-2), (120, 1e-2, 0.25)]
)
def test_relief_takes_little_of_rough_shells(roughness, of_most, of_all):
    # sums of 12 x 12 faces of 330 mm whose corners are shaken; at 120 mm some all but cross
    rng = np.random.default_rng(2009)
    shares, refused = [], 0
    for _ in range(60):
        curves = []
        for axis in (0, 1):
            steps = rng.normal(0, roughness, (13, 3))
            steps[:, axis] += 330
            curves.append(np.cumsum(steps, axis=0))
        try:
            shares.append(thicken(vector_sum(*curves), 21).relief_share)
        except IfsCadError:
            refused += 1
    shares = np.concatenate(shares)
    assert refused < 15
    assert (shares > 0).mean() > 0.3
    assert np.quantile(shares, 0.99) < of_most
    assert shares.max() < of_all
