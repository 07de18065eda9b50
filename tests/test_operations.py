"""Workpieces and their operations, against the shells and solids they come from."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull
from strategies import accepted, shells
from vaults import GROUND, THICKNESS, hexagon, plate, roof, vault

import ifs_cad as ifs
from ifs_cad.elements.beam import WireFrame
from ifs_cad.elements.cutting import cutting_frames
from ifs_cad.elements.fibre import FibreAlongCurve, FibreAlongEdge
from ifs_cad.elements.hole import Holes, place_holes
from ifs_cad.elements.label import Label, place_labels
from ifs_cad.elements.polyhedron import Kind
from ifs_cad.errors import FloorError
from ifs_cad.fabrication.operations import workpieces
from ifs_cad.fabrication.workpiece import Drill, Engraving, Side
from ifs_cad.kernel.panels import make_panels
from ifs_cad.vectors import cross, dot, length

faces = pytest.mark.parametrize("face", ["inner", "outer"])


@cache
def prototype() -> ifs.Shell:
    """Return the vault with all that makes its panels differ."""
    return vault(floor=GROUND, clearance=0.2).without("12").with_fibre(FibreAlongCurve("long"))


def beams() -> WireFrame:
    return WireFrame(vault().mesh, 30, 45)


def signed_area(outline) -> float:
    x, y = outline.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def in_design(piece, points):
    return points @ piece.axes + piece.origin


def assert_pieces_are_the_elements(elements, pieces) -> None:
    """Every face of every element is one side or outline of its workpiece, and nothing else is."""
    solids = elements.solids
    assert [piece.address for piece in pieces] == list(elements.addresses)
    for k, piece in enumerate(pieces):
        np.testing.assert_allclose(piece.axes @ piece.axes.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(piece.axes) > 0
        own = np.flatnonzero((solids.solid_of_face == k) & (solids.kinds > Kind.UPPER))
        loops = [
            solids.vertices[solids.loops[solids.face_offsets[f] : solids.face_offsets[f + 1]]]
            for f in own
        ]
        left = dict(zip(own.tolist(), loops, strict=True))
        for side in piece.sides:
            corners = in_design(piece, side.corners)
            (match,) = (
                f
                for f, loop in left.items()
                if loop.shape == corners.shape and np.abs(loop - corners).max() < 1e-8
            )
            del left[match]
            np.testing.assert_allclose(side.normal @ piece.axes, solids.normals[match], atol=1e-9)
            assert side.kind == Kind(solids.kinds[match]).name.lower()
            middle = side.corners.mean(axis=0)
            np.testing.assert_allclose((side.corners - middle) @ side.normal, 0, atol=1e-6)
            area_vector = cross(
                side.corners - middle, np.roll(side.corners, -1, axis=0) - middle
            ).sum(axis=0)
            assert area_vector @ side.normal > 0
        assert not left


def assert_outlines_are_sound(piece) -> None:
    ring = piece.silhouette
    assert (ring.min(axis=0) > -1e-6).all()
    steps = np.roll(ring, -1, axis=0) - ring
    before = np.roll(steps, 1, axis=0)
    turns = before[:, 0] * steps[:, 1] - before[:, 1] * steps[:, 0]
    assert (turns > 0).all()
    inward = np.stack([-steps[:, 1], steps[:, 0]], axis=1) / length(steps)[:, None]
    points = np.concatenate([side.corners for side in piece.sides])[:, :2]
    for outline in (piece.lower, piece.upper, points):
        reach = inward @ outline.T - (inward * ring).sum(axis=1)[:, None]
        assert (reach > -1e-5).all()
    assert signed_area(ring) == pytest.approx(ConvexHull(points).volume, rel=1e-6, abs=1e-6)
    for outline in (piece.lower, piece.upper):
        assert len(outline) == 0 or signed_area(outline) > 0


def assert_sides_go_around_once(piece) -> None:
    azimuth = np.array([np.arctan2(side.normal[1], side.normal[0]) for side in piece.sides])
    turns = np.degrees(np.roll(azimuth, -1) - azimuth)
    turns = np.mod(turns + 1e-6, 360.0) - 1e-6  # what is not quite 0 is no whole turn
    assert turns.sum() == pytest.approx(360.0, abs=1e-9)
    assert (turns < 180.0).all()


def assert_tool_fits(side) -> None:
    axis, travel = side.axis, side.travel
    for vector in (axis, travel):
        assert length(vector) == pytest.approx(1.0, abs=1e-12)
        assert vector @ side.normal == pytest.approx(0.0, abs=1e-12)
    assert axis @ travel == pytest.approx(0.0, abs=1e-12)
    assert travel[2] == 0.0
    assert axis[2] == pytest.approx(np.cos(np.radians(side.inclination)), abs=1e-12)
    to_the_left = cross(np.array([0.0, 0.0, 1.0]), travel)
    assert to_the_left @ side.normal < 0  # where the workpiece is
    # a piece wider at its top leans over the cutter, so the tool leans outward going up
    assert axis @ to_the_left == pytest.approx(-np.sin(np.radians(side.inclination)), abs=1e-12)


@faces
@pytest.mark.parametrize("make", [prototype, vault, beams, lambda: hexagon(200)])
def test_workpieces_are_the_elements_as_they_lie_on_the_machine(make, face) -> None:
    elements = make()
    label = Label(face=face, cutter=2.0, margin=2.0)
    pieces = workpieces(elements, label=label, holes=Holes(4, 8, fewest=0))
    assert_pieces_are_the_elements(elements, pieces)
    frames = cutting_frames(elements, face)
    np.testing.assert_array_equal([piece.origin for piece in pieces], frames.origins)
    for piece in pieces:
        assert_outlines_are_sound(piece)
        assert_sides_go_around_once(piece)
        assert piece.thickness == elements.thickness
        assert piece.material is elements.material
        for side in piece.sides:
            assert_tool_fits(side)


@settings(max_examples=40)
@given(shells(), st.sampled_from(["inner", "outer"]))
def test_workpieces_of_any_shell_are_its_panels(shell, face) -> None:
    label = Label(face=face, style="wire", min_height=2.5, margin=0.0)
    pieces = accepted(workpieces, shell, label=label)
    assert_pieces_are_the_elements(shell, pieces)
    sign = 1 if face == "outer" else -1
    for piece, mesh_face, volume in zip(pieces, shell.faces, shell.volumes, strict=True):
        assert_outlines_are_sound(piece)
        assert_sides_go_around_once(piece)
        assert piece.volume == pytest.approx(volume, rel=1e-9)
        known = chamfers(shell, int(mesh_face))
        for side in piece.sides:
            assert_tool_fits(side)
            if side.kind == "cut":
                assert side.inclination == pytest.approx(sign * known[side.neighbour], abs=1e-6)
            elif side.kind == "border":
                assert side.inclination == pytest.approx(0.0, abs=1e-6)
                assert side.neighbour == ""


def chamfers(shell, face: int) -> dict[str, float]:
    starts = shell.mesh.offsets
    angles = shell.chamfer_angles[starts[face] : starts[face + 1]].tolist()
    return dict(zip(shell.mesh.neighbours(face), angles, strict=True))


@pytest.mark.parametrize(("face", "sign"), [("inner", -1), ("outer", 1)])
def test_inclination_is_positive_where_the_workpiece_is_wider_at_its_top(face, sign) -> None:
    angle = 25.0  # each half of the roof falls by it: its outer face is wider by t tan(angle)
    pieces = workpieces(roof(400, 300, angle), label=Label(face=face))
    for piece, neighbour in zip(pieces, ("1", "0"), strict=True):
        ridge = [side for side in piece.sides if side.kind == "cut"]
        assert [side.neighbour for side in ridge] == [neighbour]
        assert ridge[0].inclination == pytest.approx(sign * angle, abs=1e-9)
        wider = THICKNESS * np.tan(np.radians(angle)) * 300
        assert signed_area(piece.upper) - signed_area(piece.lower) == pytest.approx(sign * wider)
        larger = piece.upper if sign > 0 else piece.lower
        assert signed_area(piece.silhouette) == pytest.approx(signed_area(larger))
        assert len(piece.silhouette) == 4
        square = [side.inclination for side in piece.sides if side.kind == "border"]
        np.testing.assert_allclose(square, 0.0, atol=1e-9)


def test_contour_of_a_plate_runs_from_its_lower_left_corner() -> None:
    (piece,) = workpieces(plate(300, 200))
    assert [side.normal.round(9).tolist() for side in piece.sides] == [
        [0, -1, 0],
        [1, 0, 0],
        [0, 1, 0],
        [-1, 0, 0],
    ]
    corners = {(0.0, 0.0), (300.0, 0.0), (300.0, 200.0), (0.0, 200.0)}
    for outline in (piece.lower, piece.upper, piece.silhouette):
        assert {tuple(corner) for corner in outline.round(9).tolist()} == corners
    assert [str(side.inclination) for side in piece.sides] == ["0.0"] * 4
    assert piece.volume == pytest.approx(300 * 200 * THICKNESS, rel=1e-12)


def test_points_on_the_edges_of_the_silhouette_are_left_out() -> None:
    # the square borders of both faces fall on the same points; relief and floor add others
    for piece in workpieces(hexagon(200)):
        assert len(piece.silhouette) == 6


@faces
@pytest.mark.parametrize("addresses", ["ifs", "lexicographic"])
@pytest.mark.parametrize("style", ["engraved", "wire"])
def test_volume_is_that_of_the_solid(face, addresses, style) -> None:
    surface = ifs.vector_sum(
        [(0, 0, 0), (400, 0, 90), (800, 0, 0)], [(0, 0, 0), (0, 350, 60)], addresses=addresses
    )
    shell = ifs.thicken(surface, 12.0)
    label, holes = Label(face=face, style=style, cutter=2.0), Holes(6.0, 30.0)
    pieces = workpieces(shell, label=label, holes=holes)
    for piece, made in zip(pieces, make_panels(shell, label=label, holes=holes), strict=True):
        assert piece.volume == pytest.approx(made.volume, rel=1e-9)
    bare = workpieces(shell)
    np.testing.assert_allclose([piece.volume for piece in bare], shell.volumes, rtol=1e-9)
    assert pieces[0].volume < bare[0].volume - 4 * np.pi * 9 * 12 + 1e-6


def test_volume_of_beams_is_that_of_their_solids() -> None:
    frame, label = beams(), Label(face="outer", cutter=2.0, margin=2.0)
    pieces = workpieces(frame, label=label)
    for piece, made in zip(pieces, make_panels(frame, label=label), strict=True):
        assert piece.volume == pytest.approx(made.volume, rel=1e-9)


def test_beams_lie_along_x_with_their_grain() -> None:
    for piece in workpieces(beams()):
        np.testing.assert_allclose(np.abs(piece.fibre), [1, 0], atol=1e-9)
        np.testing.assert_allclose(np.ptp(piece.silhouette[:, 1]), 30.0)
        assert {side.neighbour for side in piece.sides} == {""}


@faces
def test_fibre_of_a_workpiece_is_that_of_its_panel(face) -> None:
    shell = prototype()
    pieces = workpieces(shell, label=Label(face=face))
    level = np.array([[*piece.fibre, 0.0] for piece in pieces])
    turned = [fibre @ piece.axes for fibre, piece in zip(level, pieces, strict=True)]
    np.testing.assert_allclose(turned, shell.fibres, atol=1e-9)
    np.testing.assert_allclose(length(level), 1.0, atol=1e-12)
    assert workpieces(vault())[0].fibre is None


def test_grain_along_the_edge_of_a_level_plate_runs_mirrored_on_its_inner_face() -> None:
    shell = plate(300, 200).with_fibre(FibreAlongEdge(0))
    (seen_from_outside,) = workpieces(shell, label=Label(face="outer"))
    (seen_from_inside,) = workpieces(shell, label=Label(face="inner"))
    np.testing.assert_allclose(seen_from_outside.fibre, [1, 0], atol=1e-12)
    np.testing.assert_allclose(seen_from_inside.fibre, [-1, 0], atol=1e-12)


@faces
def test_holes_and_strokes_stand_where_they_are_placed(face) -> None:
    shell, label, holes = vault(), Label(face=face, depth=0.7), Holes(7.0, 30.0)
    frames = cutting_frames(shell, face, label.up)
    places = place_holes(shell.addresses, frames, holes)
    labels = place_labels(shell.addresses, frames, label, places)
    for k, piece in enumerate(workpieces(shell, label=label, holes=holes)):
        (drill,) = piece.drills
        np.testing.assert_array_equal(drill.points, places.points[k][places.present[k]])
        assert (drill.diameter, drill.depth) == (7.0, THICKNESS)
        engraving = piece.engraving
        assert (engraving.text, engraving.depth, engraving.cutter) == (piece.address, 0.7, 3.0)
        for found, expected in zip(engraving.strokes, labels.strokes(k), strict=True):
            placed = expected.vertices + labels.origins[k]
            np.testing.assert_allclose(found.vertices, placed, atol=1e-9)
            np.testing.assert_array_equal(found.bulges, expected.bulges)


def test_a_dot_is_plunged_when_engraved_and_a_ring_when_drawn() -> None:
    shell = plate(300, 200, addresses=("0.1",))
    sizes = {}
    for style in ("engraved", "wire"):
        (piece,) = workpieces(shell, label=Label(style=style))
        sizes[style] = sorted(len(path.vertices) for path in piece.engraving.strokes)[0]
        if style == "wire":
            assert (piece.engraving.depth, piece.engraving.cutter) == (0.0, 0.0)
    assert sizes == {"engraved": 1, "wire": 2}


def test_operations_come_in_order_holes_address_contour() -> None:
    (piece,) = workpieces(plate(400, 300), label=Label(), holes=Holes())
    assert [type(step) for step in piece.operations()] == [Drill, Engraving] + [Side] * 4
    assert tuple(piece.operations())[2:] == piece.sides
    (bare,) = workpieces(plate(400, 300))
    assert bare.engraving is None
    assert bare.drills == ()
    assert tuple(bare.operations()) == bare.sides


def test_neighbours_of_a_part_are_those_of_the_whole() -> None:
    whole = {piece.address: piece for piece in workpieces(vault())}
    outside = set()
    for piece in workpieces(vault().part("0*")):
        expected = whole[piece.address].sides
        assert [side.neighbour for side in piece.sides] == [side.neighbour for side in expected]
        outside |= {side.neighbour[0] for side in piece.sides if side.neighbour} - {"0"}
        for side, known in zip(piece.sides, expected, strict=True):
            np.testing.assert_allclose(side.corners, known.corners, atol=1e-9)
    assert outside >= {"1", "2"}


def pyramid(height: float, side: str) -> ifs.Shell:
    """Return the tip of a pyramid, 20 mm thick, from a height of the floor on."""
    base = [(-1000, -1000, 0), (1000, -1000, 0), (1000, 1000, 0), (-1000, 1000, 0)]
    sides = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    mesh = ifs.Mesh([*base, (0, 0, 1000)], sides)
    return ifs.thicken(mesh, 20, side=side, floor=ifs.Plane((0, 0, height), (0, 0, 1)))


@faces
def test_stub_that_lost_a_face_of_its_sheet_has_no_outline_there(face) -> None:
    shell = pyramid(1005, "outer")  # the tip of the inner faces lies at 1000
    label = Label(face="outer", style="wire", height=2.5, margin=0)  # the inner faces are gone
    pieces = workpieces(shell, label=label if face == "outer" else None)
    for piece, volume in zip(pieces, shell.volumes, strict=True):
        lost, kept = (piece.upper, piece.lower) if face == "inner" else (piece.lower, piece.upper)
        assert lost.shape == (0, 2)
        assert kept.shape == (3, 2)
        assert piece.volume == pytest.approx(volume, rel=1e-9)
        heights = np.concatenate([side.corners[:, 2] for side in piece.sides])
        assert np.abs(heights - (0 if face == "inner" else 20)).min() < 1e-9
        assert (heights >= 0).all()
        assert (heights <= 20).all()
        assert sorted(side.kind for side in piece.sides) == ["cut", "cut", "floor"]
        assert_outlines_are_sound(piece)
    assert_pieces_are_the_elements(shell, pieces)


def test_floor_parallel_to_a_sheet_is_refused() -> None:
    ring = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    points = [(900 * x, 900 * y, 0) for x, y in ring] + [(400 * x, 400 * y, 500) for x, y in ring]
    quads = [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (4, 5, 6, 7)]
    shell = ifs.thicken(ifs.Mesh(points, quads), 20, floor=ifs.Plane((0, 0, 505), (0, 0, 1)))
    with pytest.raises(FloorError, match=r"f0004 parallel to the sheet.*tilt it") as caught:
        workpieces(shell, label=Label(), holes=Holes())
    assert caught.value.addresses == ("f0004",)


def test_arrays_of_workpieces_cannot_be_changed() -> None:
    (piece,) = workpieces(plate(300, 200).with_fibre(FibreAlongEdge()), holes=Holes())
    side = piece.sides[0]
    for array in (
        piece.lower,
        piece.upper,
        piece.silhouette,
        piece.fibre,
        piece.axes,
        piece.origin,
        piece.drills[0].points,
        side.corners,
        side.normal,
    ):
        assert not array.flags.writeable
    assert float(dot(side.normal, side.normal)) == pytest.approx(1.0)
