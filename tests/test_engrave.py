"""Pockets set into a box: closed valid solids, exact volumes, shared edges, small STEP files."""

import cadquery as cq
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
from OCP.BRepTools import BRepTools
from OCP.Geom import Geom_Plane
from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec
from OCP.GProp import GProp_GProps
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_FORWARD, TopAbs_VERTEX, TopAbs_WIRE
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Face, TopoDS_Shell, TopoDS_Solid
from OCP.TopTools import TopTools_IndexedDataMapOfShapeListOfShape

from ifs_cad.elements.arcs import Path
from ifs_cad.elements.glyph import BAR_DROP, CHARACTERS, text_paths, text_positions
from ifs_cad.elements.groove import groove
from ifs_cad.errors import InputError, LabelError
from ifs_cad.kernel.engrave import (
    bar,
    engraved,
    engraved_text,
    moved,
    pocket,
    wire_strokes,
)

WRITTEN = CHARACTERS.strip()
HERE = TopLoc_Location()
LOW, HIGH, THICKNESS = (-30.0, -40.0), (170.0, 60.0), 12.0
BOX_VOLUME = 200.0 * 100.0 * THICKNESS


def tilted():
    turn, shift = gp_Trsf(), gp_Trsf()
    turn.SetRotation(gp_Ax1(gp_Pnt(1, 2, 3), gp_Dir(1, -2, 3)), 0.7)
    shift.SetTranslation(gp_Vec(1200, -300, 2500))
    return TopLoc_Location(shift.Multiplied(turn))


def each(shape, kind):
    explorer = TopExp_Explorer(shape, kind)
    found = []
    while explorer.More():
        found.append(explorer.Current())
        explorer.Next()
    return found


def engraved_box(pockets, location=HERE):
    """Return a box whose upper face, at z = 0 before it is moved, carries the placed pockets."""
    builder = BRep_Builder()
    maker = BRepPrimAPI_MakeBox(gp_Pnt(*LOW, -THICKNESS), gp_Pnt(*HIGH, 0))
    top, shell = maker.TopFace(), TopoDS_Shell()
    builder.MakeShell(shell)
    for face in each(maker.Shell(), TopAbs_FACE):
        if not face.IsSame(top):
            builder.Add(shell, face.Moved(location))
    outline = BRepTools.OuterWire_s(TopoDS.Face_s(top)).Oriented(TopAbs_FORWARD)
    lid = TopoDS_Face()
    builder.MakeFace(lid, Geom_Plane(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), 1e-7)
    builder.Add(lid, outline)
    lid = lid.Moved(location)
    for each_pocket in pockets:
        for rim in each_pocket.rims:
            builder.Add(lid, rim)
        for face in each_pocket.faces:
            builder.Add(shell, face)
    builder.Add(shell, lid)
    shell.Closed(True)
    solid = TopoDS_Solid()
    builder.MakeSolid(solid)
    builder.Add(solid, shell)
    return solid


def volume(shape):
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties)
    return properties.Mass()


def assert_exact(solid, pockets):
    """Check that a box with pockets is a closed valid solid of exactly the volume that is left."""
    assert BRepCheck_Analyzer(solid).IsValid()
    owners = TopTools_IndexedDataMapOfShapeListOfShape()
    TopExp.MapShapesAndAncestors_s(solid, TopAbs_EDGE, TopAbs_FACE, owners)
    assert {owners.FindFromIndex(k).Extent() for k in range(1, owners.Extent() + 1)} == {2}
    left = BOX_VOLUME - sum(p.volume for p in pockets)
    assert volume(solid) == pytest.approx(left, rel=1e-9)
    # The box is large: see to it that the pockets themselves are exact, too.
    cut = BOX_VOLUME - volume(solid)
    assert cut == pytest.approx(sum(p.volume for p in pockets), rel=1e-7)


def height_span(shape):
    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(shape, box, False, False)
    _, _, low, _, _, high = box.Get()
    return low, high


@pytest.mark.parametrize("character", WRITTEN)
def test_pocket_of_every_character_leaves_an_exact_solid(character):
    location = tilted()
    placed = moved(pocket(character, 20.0, 3.0, 0.5), location)
    assert_exact(engraved_box([placed], location), [placed])


@pytest.mark.parametrize("ratio", [0.02, 0.15, 0.25])
@pytest.mark.parametrize("depth", [0.1, 0.5, 8.0])
def test_pockets_of_all_digits_are_exact_at_any_depth_and_width(ratio, depth):
    digits = engraved_text("0123456789", 20.0, 20.0 * ratio, depth, HERE)
    assert_exact(engraved_box(digits), digits)


@settings(max_examples=15)
@given(
    st.text(CHARACTERS.strip(), min_size=1, max_size=5),
    st.floats(4.0, 20.0),
    st.floats(0.02, 0.25),
    st.floats(0.05, 11.0),
)
def test_any_text_is_engraved_exactly(text, height, ratio, depth):
    location = tilted()
    pockets = engraved_text(text, height, ratio * height, depth, location)
    assert_exact(engraved_box(pockets, location), pockets)


def test_pocket_has_the_faces_of_its_outline():
    eight = groove("8", 15.0, 3.0)
    result = pocket("8", 15.0, 3.0, 0.5)
    assert result.face_count == eight.wall_count + 1 + 2
    assert result.volume == pytest.approx(eight.area * 0.5, rel=1e-15)
    assert len(result.rims) == 1
    assert len(pocket("i", 15.0, 3.0, 0.5).rims) == 2


def test_pocket_reaches_from_the_face_to_its_depth():
    for face in pocket("8", 15.0, 3.0, 0.7).faces:
        low, high = height_span(face)
        assert (round(low, 6), round(high, 6)) in {(-0.7, 0.0), (-0.7, -0.7), (0.0, 0.0)}


def test_moved_pocket_shares_the_edges_of_rim_and_walls():
    location = tilted()
    placed = moved(pocket("A", 15.0, 3.0, 0.5), location)
    walls = [edge for face in placed.faces for edge in each(face, TopAbs_EDGE)]
    for rim in placed.rims:
        for edge in each(rim, TopAbs_EDGE):
            partners = [wall for wall in walls if wall.IsSame(edge)]
            assert len(partners) == 1
            assert partners[0].Orientation() != edge.Orientation()


def test_space_has_an_empty_pocket():
    empty = pocket(" ", 15.0, 3.0, 0.5)
    assert (empty.rims, empty.faces, empty.volume) == ((), (), 0.0)


def test_pocket_is_made_once():
    assert pocket("7", 15.0, 3.0, 0.5) is pocket("7", 15.0, 3.0, 0.5)
    assert bar(40.0, 15.0, 3.0, 0.5) is bar(40.0, 15.0, 3.0, 0.5)


def test_bar_is_a_stadium_under_the_text():
    result = bar(40.0, 16.0, 3.0, 0.5)
    assert result.face_count == 5
    assert result.volume == pytest.approx(0.5 * (40 * 3 + np.pi * 1.5**2), rel=1e-12)
    assert_exact(engraved_box([result]), [result])
    ends = [BRep_Tool.Pnt_s(TopoDS.Vertex_s(v)) for v in each(result.rims[0], TopAbs_VERTEX)]
    assert {round(p.X(), 9) for p in ends} == {0.0, 40.0}
    assert {round(p.Y() + 16 * BAR_DROP, 9) for p in ends} == {-1.5, 1.5}
    lowered = bar(40.0, 16.0, 3.0, 0.5, 5.6)
    y = [BRep_Tool.Pnt_s(TopoDS.Vertex_s(v)).Y() for v in each(lowered.rims[0], TopAbs_VERTEX)]
    assert np.mean(y) == pytest.approx(-16 * BAR_DROP - 5.6)


def test_engraved_text_places_every_character_and_the_bar():
    pockets = engraved_text("0.1", 20.0, 3.0, 0.5, HERE)
    positions, width = text_positions("0.1")
    assert len(pockets) == 4
    for placed, character, x in zip(pockets, "0.1", positions, strict=False):
        shift = placed.rims[0].Location().Transformation().TranslationPart()
        assert (shift.X(), shift.Y(), shift.Z()) == pytest.approx((20 * x, 0, 0), abs=1e-12)
        assert placed.volume == pocket(character, 20.0, 3.0, 0.5).volume
    assert pockets[-1].volume == bar(20 * width, 20.0, 3.0, 0.5).volume


def test_strokes_within_an_island_are_cut_into_its_top():
    def circle(radius):
        return Path(np.array([(radius, 0.0), (-radius, 0.0)]), np.ones(2), closed=True)

    rings = engraved([circle(25.0), circle(15.0), circle(5.0)], 3.0, 0.5)
    assert len(rings.rims) == 1
    assert rings.volume == pytest.approx(0.5 * 2 * np.pi * 3 * (25 + 15 + 5), rel=1e-12)
    assert_exact(engraved_box([rings]), [rings])


def test_wire_strokes_are_lines_and_arcs_on_the_face():
    paths, _ = text_paths("i03")
    wires = wire_strokes([path.scaled(10) for path in paths])
    kinds = [cq.Shape.cast(edge).geomType() for edge in each(wires, TopAbs_EDGE)]
    assert sorted(kinds) == ["CIRCLE"] * 4 + ["LINE"] * 3
    assert len(each(wires, TopAbs_WIRE)) == 0
    loose = TopExp_Explorer(wires, TopAbs_VERTEX, TopAbs_EDGE)
    dot = BRep_Tool.Pnt_s(TopoDS.Vertex_s(loose.Current()))
    assert (dot.X(), dot.Y(), dot.Z()) == (0, 10, 0)
    length = GProp_GProps()
    BRepGProp.LinearProperties_s(wires, length)
    stadium = 10 * (2 * 0.5 + np.pi * 0.5)
    three = 10 * np.radians(240) * (0.24 + 0.26)
    assert length.Mass() == pytest.approx(7 + stadium + three, rel=1e-6)
    assert BRepCheck_Analyzer(wires).IsValid()
    placed = wires.Moved(tilted())
    again = GProp_GProps()
    BRepGProp.LinearProperties_s(placed, again)
    assert again.Mass() == pytest.approx(length.Mass(), rel=1e-12)


def test_engraved_box_reads_back_the_same_from_step_without_pcurves(tmp_path):
    location = tilted()
    pockets = engraved_text("0123456789.-ABCXYZf", 10.0, 2.0, 0.5, location)
    solid = engraved_box(pockets, location)
    file = tmp_path / "box.step"
    cq.Assembly(name="box").add(cq.Shape.cast(solid), name="panel").export(
        str(file), write_pcurves=False
    )
    (read,) = cq.importers.importStep(str(file)).solids().vals()
    assert read.isValid()
    assert len(read.Faces()) == 6 + sum(p.face_count for p in pockets)
    assert read.Volume() == pytest.approx(volume(solid), rel=1e-9)


def test_label_of_four_digits_stays_small_in_step(tmp_path):
    def size(name, pockets):
        file = tmp_path / f"{name}.step"
        shape = cq.Shape.cast(engraved_box(pockets, location))
        cq.Assembly(name="box").add(shape, name="panel").export(str(file), write_pcurves=False)
        return file.stat().st_size

    location = tilted()
    label = size("label", engraved_text("0123", 20.0, 3.0, 0.5, location)) - size("plain", [])
    assert label < 70_000


@pytest.mark.parametrize("depth", [0.0, -1.0, np.nan, np.inf])
def test_pocket_refuses_a_depth_that_is_not_positive(depth):
    with pytest.raises(InputError, match="depth"):
        pocket("1", 15.0, 3.0, depth)


def test_pocket_and_bar_refuse_a_cutter_too_wide_for_the_height():
    with pytest.raises(LabelError, match="at least 12 mm"):
        pocket("1", 10.0, 3.0, 0.5)
    with pytest.raises(LabelError, match="at least 12 mm"):
        bar(30.0, 10.0, 3.0, 0.5)
