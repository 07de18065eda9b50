"""Solids of known size, through a STEP file and back into numbers."""

import math

import cadquery as cq
import numpy as np
import pytest
from cadquery import Location
from hypothesis import given, settings
from hypothesis import strategies as st

import ifs_cad as ifs
from ifs_cad.elements.boundary import place
from ifs_cad.elements.sheet import read_sheet
from ifs_cad.kernel.inspect import bounding_box, common_volume, inspect_step


def block():
    return cq.Workplane().box(30, 20, 10)


def round_pockets():
    """Return a block with a stepped bore and its closed form."""
    stepped = block().faces(">Z").workplane().cboreHole(4, 8, 3)
    return stepped, 6000 - math.pi * (16 * 3 + 4 * 7)


# closed forms by hand, mm3; None where an edge or a face has none here
SOLIDS = {
    "block": (block(), 6000.0),
    "hole": (block().faces(">Z").workplane().hole(6), 6000 - 90 * math.pi),
    "stepped bore": round_pockets(),
    "round edges": (block().edges("|Z").fillet(3), 6000 - 10 * (36 - 9 * math.pi)),
    "one round edge": (block().edges(">Z and >Y").fillet(3), 6000 - 30 * (9 - 9 * math.pi / 4)),
    "cylinder": (cq.Workplane().cylinder(7, 2), 28 * math.pi),
    "tube": (cq.Workplane().circle(5).circle(3).extrude(4), 64 * math.pi),
    "hollow": (block().cut(cq.Workplane().box(5, 4, 3)), 6000 - 60.0),
    "slot": (
        block().faces(">Z").workplane().slot2D(12, 4).cutBlind(-2),
        6000 - 2 * (8 * 4 + 4 * math.pi),
    ),
    "wedge": (cq.Workplane().polyline([(0, 0), (3, 0), (0, 4)]).close().extrude(5), 30.0),
    "stepped cylinder": (
        cq.Workplane().cylinder(8, 3).cut(cq.Workplane().box(9, 9, 9, False)),
        (72 - 9) * math.pi,
    ),
    "ball": (cq.Workplane().sphere(4), None),
    "slanted bore": (
        block().cut(cq.Workplane().cylinder(60, 3).rotate((0, 0, 0), (1, 0, 0), 20)),
        None,
    ),
}


def read(shape, path, location=None):
    assembly = cq.Assembly(name="file")
    assembly.add(shape, name="part", loc=location or Location())
    (solid,) = inspect_step(ifs.export_step(assembly, path)).solids
    return solid


@pytest.mark.parametrize("kind", SOLIDS)
def test_volume_is_the_closed_form(kind, tmp_path):
    shape, wanted = SOLIDS[kind]
    solid = read(shape, tmp_path / "part.step")
    assert solid.valid
    assert solid.boundary.open_edges == 0
    assert solid.boundary.deviations.max() < 1e-9
    volume = solid.boundary.volume()
    if wanted is None:
        assert volume is None
    else:
        assert volume == pytest.approx(wanted, rel=1e-12)
        assert solid.volume == pytest.approx(wanted, rel=1e-9)


lengths = st.floats(-2000, 2000)


@settings(max_examples=15)
@given(lengths, lengths, lengths, st.floats(-180, 180), st.floats(-90, 90))
def test_place_of_a_part_is_found_and_its_own_numbers_stay(
    tmp_path_factory, x, y, z, about_z, about_x
):
    where = Location((x, y, z), (0, 0, 1), about_z) * Location((0, 0, 0), (1, 0, 0), about_x)
    shape = block().faces(">Z").workplane().hole(6)
    solid = read(shape, tmp_path_factory.mktemp("placed") / "part.step", where)
    assert solid.boundary.volume() == pytest.approx(6000 - 90 * math.pi, rel=1e-12)
    corners = place(solid.placement, np.array([(15.0, 10.0, 5.0), (-15.0, 10.0, -5.0)]))
    frame = where.wrapped.Transformation()
    wanted = [cq.Vector(*corner).wrapped.XYZ() for corner in ((15, 10, 5), (-15, 10, -5))]
    for found, corner in zip(corners, wanted, strict=True):
        frame.Transforms(corner)
        assert found == pytest.approx((corner.X(), corner.Y(), corner.Z()), abs=1e-9)
    low, high = bounding_box(solid)
    assert (low <= corners.min(axis=0) + 1e-6).all()
    assert (high >= corners.max(axis=0) - 1e-6).all()


def test_sheet_of_a_pierced_and_pocketed_block(tmp_path):
    shape = block().faces(">Z").workplane().pushPoints([(-8, 0), (8, 0)]).hole(4)
    shape = shape.faces(">Z").workplane(origin=(0, 0, 0)).rect(3, 5).cutBlind(-2)
    sheet = read_sheet(read(shape, tmp_path / "part.step").boundary)
    assert sheet.thickness == pytest.approx(10.0, abs=1e-12)
    assert sheet.unevenness < 1e-12
    assert len(sheet.hull) == 1
    assert sheet.hull.volumes[0] == pytest.approx(6000.0, rel=1e-12)
    assert sheet.pocket_volume == pytest.approx(30.0, rel=1e-12)
    assert sheet.hole_areas == pytest.approx([4 * math.pi] * 2, rel=1e-12)
    assert sheet.hole_volume == pytest.approx(80 * math.pi, rel=1e-12)


def test_sheet_prefers_faces_at_the_common_thickness(tmp_path):
    """A stub cut low by the floor may be wider than it is high: its sheet faces are not largest."""
    stub = read(cq.Workplane().box(300, 8, 12), tmp_path / "part.step").boundary
    assert read_sheet(stub).thickness == pytest.approx(8.0)
    assert read_sheet(stub, 12.0).thickness == pytest.approx(12.0)
    assert read_sheet(stub, 11.0).thickness == pytest.approx(8.0)


def test_hull_ignores_the_top_of_an_island(tmp_path):
    ring = cq.Workplane().circle(6).circle(3).extrude(1).translate((0, 0, 4))
    sheet = read_sheet(read(block().cut(ring), tmp_path / "part.step").boundary)
    assert sheet.hull.volumes[0] == pytest.approx(6000.0, rel=1e-12)
    assert sheet.pocket_volume == pytest.approx(27 * math.pi, rel=1e-12)
    assert sheet.hole_volume == 0.0


@pytest.mark.parametrize(
    "shape",
    [
        block().cut(cq.Workplane().box(6, 6, 20).translate((15, 0, 0))),  # a notch in one side
        block().edges("|Z").fillet(2),
        block().union(cq.Workplane().box(10, 10, 16)),
    ],
)
def test_solid_that_is_not_convex_has_no_hull(shape, tmp_path):
    assert read_sheet(read(shape, tmp_path / "part.step").boundary).hull is None


def test_ball_is_no_sheet(tmp_path):
    assert read_sheet(read(cq.Workplane().sphere(4), tmp_path / "part.step").boundary) is None


def tilted_top(degrees):
    """Return a block whose top, 10 mm high at x = 0, falls by an angle along x."""
    fall = 30 * math.tan(math.radians(degrees))
    corners = [(0, 0), (30, 0), (30, 10 - fall), (0, 10)]
    return cq.Workplane("XZ").polyline(corners).close().extrude(-40)


def test_top_that_is_a_little_tilted_is_still_a_sheet_face(tmp_path):
    sheet = read_sheet(read(tilted_top(3), tmp_path / "part.step").boundary, 10.0)
    fall = 30 * math.tan(math.radians(3))
    assert not sheet.is_stub
    # the low edge is as far from the slanted plane as its foot in the bottom is, times the cosine
    assert sheet.thickness == pytest.approx(10 - fall / 2, rel=0.01)
    assert sheet.unevenness == pytest.approx(fall, rel=0.01)


def test_corner_cut_off_a_sheet_is_a_stub(tmp_path):
    sheet = read_sheet(read(tilted_top(18), tmp_path / "part.step").boundary, 12.0)
    assert sheet.is_stub
    assert sheet.thickness == pytest.approx(10 * math.cos(math.radians(18)))
    assert len(sheet.hull) == 1
    assert sheet.floors[0].tolist() == []


def test_common_volume_of_two_blocks(tmp_path):
    assembly = cq.Assembly(name="file")
    assembly.add(block(), name="one").add(block(), name="other", loc=Location((28, 19, 0)))
    one, other = inspect_step(ifs.export_step(assembly, tmp_path / "two.step")).solids
    assert common_volume(one, other) == pytest.approx(2 * 1 * 10)


def test_nested_parts_keep_their_names_and_get_all_locations(tmp_path):
    inner = cq.Assembly(name="inner", loc=Location((100, 0, 0), (0, 0, 1), 90))
    inner.add(block(), name="deep", loc=Location((10, 0, 0)))
    outer = cq.Assembly(name="outer").add(inner).add(block(), name="shallow")
    found = inspect_step(ifs.export_step(outer, tmp_path / "nested.step"))
    places = {solid.name: solid.placement[:, 3] for solid in found.solids}
    assert found.names == ("deep", "shallow")
    assert places["deep"] == pytest.approx((100, 10, 0), abs=1e-12)
    assert places["shallow"] == pytest.approx((0, 0, 0), abs=1e-12)


def test_parts_that_share_a_product_are_named_by_their_places(tmp_path):
    shape = block().val()
    assembly = cq.Assembly(name="file")
    for number in range(3):
        assembly.add(shape, name=f"copy-{number}", loc=Location((50 * number, 0, 0)))
    found = inspect_step(ifs.export_step(assembly, tmp_path / "copies.step"))
    assert sorted(found.names) == ["copy-0", "copy-1", "copy-2"]
