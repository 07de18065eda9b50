"""Files of good shells pass with the right numbers; each kind of damage is found and named."""

import json
import re

import cadquery as cq
import numpy as np
import pytest
from cadquery import Location
from OCP.BRep import BRep_Builder
from OCP.TopoDS import TopoDS_Shell, TopoDS_Solid

import ifs_cad as ifs
from ifs_cad import progress
from ifs_cad.errors import CheckError, InputError
from ifs_cad.tolerance import DEFAULT
from ifs_cad.types import Plane
from ifs_cad.workflow.check import check_step

THICKNESS = 15.0


def folded_shell(depth=2, feet=0.0, **how):
    """Return a small vault of 4 ** depth panels, rough enough to need reliefs."""
    rise = 700.0
    arch = ifs.Curve([(0, 0, feet), (0, 0, rise), (1400, 0, rise), (1400, 0, feet)], depth=depth)
    fold = ifs.Curve([(0, 0, 0), (0, 500, 150), (0, 1000, 0)], depth=depth).with_roughness(0.3)
    return ifs.thicken(ifs.vector_sum(arch, fold), THICKNESS, **how)


def checked(assembly, path, schema="AP214", **how):
    ifs.export_step(assembly, path, schema=schema)
    return check_step(path, **how)


def failed(report):
    return {check.name for check in report.checks if not check.ok}


LABEL = ifs.Label(cutter=2.0)
GOOD = {
    "plain": ({}, {}),
    "engraved": ({}, {"label": LABEL}),
    "engraved outside": ({}, {"label": ifs.Label(face="outer", cutter=1.0, depth=1.5)}),
    "drawn": ({}, {"label": "wire"}),
    "pierced": ({}, {"holes": ifs.Holes(6.0, 20.0)}),
    "labelled, pierced, set back, nested": (
        {"clearance": 0.2},
        {"label": LABEL, "holes": ifs.Holes(6.0, 20.0), "nest": 1},
    ),
    "inner side": ({"side": "inner"}, {"label": LABEL}),
    "centre": ({"side": "centre", "clearance": 0.1}, {"label": LABEL}),
    "node axes": ({"nodes": "axis", "clearance": 0.05}, {"label": LABEL}),
    "on a floor": (
        {"feet": -90.0, "floor": Plane((0, 0, 0), (0, 0, 1)), "clearance": 0.1},
        {"label": LABEL},
    ),
}


@pytest.mark.parametrize("kind", GOOD)
def test_good_shell_passes_with_the_right_numbers(kind, tmp_path):
    design, making = GOOD[kind]
    shell = folded_shell(**design)
    assembly = ifs.to_assembly(shell, **making)
    report = checked(assembly, tmp_path / "shell.step", clearance=shell.thickening.clearance)
    assert report.ok, str(report)

    parts = {name: assembly.objects[name] for name in shell.addresses}
    volumes = report["volumes"].values
    assert volumes["exact"] == len(shell)
    assert volumes["panels"] == pytest.approx(shell.volumes.sum(), rel=DEFAULT.volume)
    closed_form = sum(part.metadata["volume"] for part in parts.values())
    assert volumes["volume"] == pytest.approx(closed_form, rel=DEFAULT.volume)
    left = volumes["panels"] - volumes["pockets"] - volumes["holes"]
    assert left == pytest.approx(closed_form, rel=DEFAULT.volume)

    assert report["file"].values["schema"] == "AP214"
    assert report["solids"].values == {"solids": len(shell), "valid_and_closed": len(shell)}
    assert report["thickness"].values["thickness"] == pytest.approx(THICKNESS, abs=1e-9)

    label, holes = making.get("label"), making.get("holes")
    style = "none" if label is None else "drawn" if label == "wire" else "engraved"
    labels = report["labels"].values
    assert labels["right"] == (0 if label is None else len(shell))
    assert labels["engraved"] == (len(shell) if style == "engraved" else 0)
    assert labels["drawn"] == (len(shell) if style == "drawn" else 0)
    assert labels["not_labelled"] == (len(shell) if label is None else 0)
    assert (volumes["pockets"] > 0) == (style == "engraved")
    bore = np.pi * 9 * THICKNESS
    assert volumes["holes"] == pytest.approx(bore * volumes["hole_count"], rel=1e-12)
    assert (volumes["hole_count"] >= 2 * len(shell)) == (holes is not None)

    gap = 2 * shell.thickening.clearance
    joints = report["joints"].values
    made = np.isin(np.arange(len(shell.mesh)), shell.faces)
    one, other = shell.mesh.face, shell.mesh.face[shell.mesh.twin]
    inside = (shell.mesh.twin >= 0) & made[one] & made[other]
    joined = joints["joints"] + (joints["tapering"] if kind == "on a floor" else 0)
    assert joined >= inside.sum() / 2 if kind == "on a floor" else joined == inside.sum() / 2
    assert joints["median_gap"] == pytest.approx(gap, abs=DEFAULT.coplanar)
    assert joints["smallest_gap"] == pytest.approx(gap, abs=DEFAULT.coplanar)
    assert joints["largest_gap"] - gap <= 2 * DEFAULT.relief
    assert report["interference"].values["deepest"] <= DEFAULT.shared_radius


def test_good_shell_passes_in_ap242(tmp_path):
    report = checked(ifs.to_assembly(folded_shell(1)), tmp_path / "shell.step", "AP242")
    assert report.ok
    assert report["file"].values["schema"] == "AP242"


def test_door_and_test_piece_pass(tmp_path):
    shell = folded_shell()
    door = checked(ifs.to_assembly(shell.without("11")), tmp_path / "door.step")
    piece = checked(ifs.to_assembly(shell.part("0*")), tmp_path / "piece.step")
    assert door.ok
    assert piece.ok
    assert len(piece["joints"].values["unmated"]) > 0
    assert door["joints"].values["unmated"] == []


def test_stub_that_the_floor_left_without_one_face_passes(tmp_path):
    assembly = two_plates(0.4)
    wedge = cq.Workplane("XZ").polyline([(0, 0), (40, 0), (0, 8)]).close().extrude(-100)
    assembly.add(wedge, name="stub", loc=Location((200.8, 0, 0)))
    report = checked(assembly, tmp_path / "plates.step")
    assert report.ok
    assert report["thickness"].values["stubs"] == ["stub"]
    assert report["joints"].values["parts_left_out"] == 0


def test_wedge_higher_than_the_sheet_is_no_stub(tmp_path):
    assembly = two_plates(0.4)
    wedge = cq.Workplane("XZ").polyline([(0, 0), (40, 0), (0, 30)]).close().extrude(-100)
    assembly.add(wedge, name="wedge", loc=Location((500, 0, 0)))
    report = checked(assembly, tmp_path / "plates.step")
    assert failed(report) == {"thickness"}
    assert report["thickness"].addresses == ("wedge",)


def test_tilted_face_is_found(tmp_path):
    assembly = two_plates(0.4)
    corners = [(0, 0), (100, 0), (100, 10.001), (0, 10)]
    tilted = cq.Workplane("XZ").polyline(corners).close().extrude(-100)
    assembly.add(tilted, name="tilted", loc=Location((500, 0, 0)))
    report = checked(assembly, tmp_path / "plates.step")
    assert failed(report) == {"thickness"}
    assert report["thickness"].failures[0].message == (
        "The two faces of tilted are not parallel: off by 0.001 mm."
    )


def test_one_flat_panel_passes(tmp_path):
    assembly = ifs.to_assembly(folded_shell(1), label=LABEL, holes=ifs.Holes())
    path = ifs.export_panels(assembly, tmp_path)[2]
    report = check_step(path)
    assert report.ok
    assert report["labels"].values["right"] == 1
    assert report["volumes"].values["hole_count"] == 4


@pytest.mark.parametrize("style", ["engraved", "wire"])
def test_dots_dashes_and_letters_of_addresses_are_read(style, tmp_path):
    names = ("3.11.0", "L07-0110", "f0042", "jig_Qy+")
    shell = folded_shell(1)
    named = ifs.thicken(shell.mesh.with_addresses(names), THICKNESS)
    report = checked(ifs.to_assembly(named, label=style), tmp_path / "shell.step")
    assert report.ok
    assert report["labels"].values["right"] == 4


def test_small_set_back_is_reported_and_passes(tmp_path):
    """A joint that gapes by less than a relief more than the others was set back on purpose."""
    assembly = two_plates(0.4)
    assembly.add(plate(), name="c", loc=Location((200.8 + 1e-3, 0, 0)))
    report = checked(assembly, tmp_path / "plates.step", clearance=0.2)
    assert report.ok
    assert report["joints"].values["set_back"] == ["b and c"]


def plate(width=100.0):
    return cq.Workplane().box(width, 100, 10, centered=False)


def two_plates(gap, **where):
    assembly = cq.Assembly(name="plates")
    assembly.add(plate(), name="a")
    return assembly.add(plate(), name="b", loc=Location((100 + gap, 0, 0)))


@pytest.mark.parametrize(("gap", "clearance"), [(0.0, 0.0), (0.4, 0.2), (3.0, 1.5)])
def test_gap_of_two_plates_is_twice_the_clearance(gap, clearance, tmp_path):
    report = checked(two_plates(gap), tmp_path / "plates.step", clearance=clearance)
    assert report.ok
    assert report["joints"].values["median_gap"] == pytest.approx(gap, abs=1e-9)


def test_gap_other_than_twice_the_clearance_fails(tmp_path):
    path = tmp_path / "plates.step"
    report = checked(two_plates(0.4), path, clearance=0.1)
    assert failed(report) == {"joints"}
    assert report["joints"].failures[0].message == (
        "The joint of a and b gapes 0.400000 mm, not 0.200000 mm."
    )
    assert check_step(path).ok


# --- damage -------------------------------------------------------------------------------------


@pytest.fixture
def assembly():
    return ifs.to_assembly(folded_shell(clearance=0.2), label=LABEL, holes=ifs.Holes())


def part(assembly, name):
    """Return a part of a flat assembly, to be changed in place."""
    return next(child for child in assembly.children if child.name == name)


@pytest.mark.parametrize("direction", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 2, -1)])
def test_part_moved_by_a_hundredth_is_found(assembly, direction, tmp_path):
    shift = 0.01 * np.array(direction) / np.linalg.norm(direction)
    moved = part(assembly, "12")
    moved.loc = Location(tuple(shift)) * moved.loc
    report = checked(assembly, tmp_path / "shell.step")
    assert failed(report) == {"joints"}
    assert all("12" in failure.addresses for failure in report["joints"].failures)


def test_part_turned_by_a_little_is_found(assembly, tmp_path):
    turned = part(assembly, "12")
    turned.loc = turned.loc * Location((0, 0, 0), (0, 0, 1), 0.01)
    report = checked(assembly, tmp_path / "shell.step")
    assert failed(report) == {"joints"}
    assert "are not parallel" in report["joints"].failures[0].message
    assert all("12" in failure.addresses for failure in report["joints"].failures)


def test_part_out_of_place_leaves_chamfers_without_partner(assembly, tmp_path):
    moved = part(assembly, "12")
    moved.loc = Location((0, 0, 500)) * moved.loc
    report = checked(assembly, tmp_path / "shell.step")
    assert set(report["joints"].values["unmated"]) >= {"12", "10", "13"}


def test_scaled_part_is_found(assembly, tmp_path):
    scaled = part(assembly, "21")
    scaled.obj = scaled.obj.scale(1.0001)
    report = checked(assembly, tmp_path / "shell.step")
    assert failed(report) == {"joints", "thickness"}
    assert report["thickness"].addresses == ("21",)
    assert "15.001500 mm thick, not 15.000000 mm" in report["thickness"].failures[0].message


def test_swapped_names_are_found(assembly, tmp_path):
    one, other = part(assembly, "03"), part(assembly, "30")
    one.name, other.name = other.name, one.name
    report = checked(assembly, tmp_path / "shell.step")
    assert failed(report) == {"labels"}
    assert {failure.message for failure in report["labels"].failures} == {
        "30 has '03' engraved on it.",
        "03 has '30' engraved on it.",
    }
    assert set(report["labels"].addresses) == {"03", "30"}
    assert report["labels"].values["right"] == 14


def test_wrong_text_is_found(assembly, tmp_path):
    shell = folded_shell(clearance=0.2)
    texts = ["86" if name == "22" else name for name in shell.addresses]
    renamed = ifs.thicken(shell.mesh.with_addresses(texts), THICKNESS, clearance=0.2)
    part(assembly, "22").obj = ifs.to_assembly(renamed, label=LABEL).objects["86"].obj
    report = checked(assembly, tmp_path / "shell.step")
    assert failed(report) == {"labels"}
    assert report["labels"].addresses == ("22", "86")


def test_label_with_a_missing_character_is_found(assembly, tmp_path):
    damaged = part(assembly, "22")
    solid = damaged.obj
    floors = solid.faces(cq.selectors.BoxSelector((-1e4, -1e4, 14.4), (1e4, 1e4, 14.6)))
    first = min(floors.Faces(), key=lambda face: face.BoundingBox().xmin)
    box = first.BoundingBox()
    filling = cq.Solid.makeBox(box.xlen + 2, box.ylen + 2, 0.5).moved(
        Location((box.xmin - 1, box.ymin - 1, 14.5))
    )
    damaged.obj = solid.fuse(filling).clean()
    report = checked(assembly, tmp_path / "shell.step")
    assert "labels" in failed(report)
    assert report["labels"].addresses[0] == "22"


def test_swapped_strokes_are_found(tmp_path):
    assembly = ifs.to_assembly(folded_shell(1), label="wire")
    one, other = part(assembly, "0-strokes"), part(assembly, "3-strokes")
    one.name, other.name = other.name, one.name
    report = checked(assembly, tmp_path / "shell.step")
    assert failed(report) == {"labels"}
    assert report["labels"].failures[0].message == "3-strokes does not lie on a face of 3."
    assert set(report["labels"].addresses) == {"0", "3"}


def test_strokes_of_another_text_are_found(tmp_path):
    shell = folded_shell(1)
    renamed = ifs.thicken(shell.mesh.with_addresses(("0", "1", "7", "3")), THICKNESS)
    assembly = ifs.to_assembly(shell, label="wire")
    wrong = ifs.to_assembly(renamed, label="wire").objects["7-strokes"]
    part(assembly, "2-strokes").obj = wrong.obj
    report = checked(assembly, tmp_path / "shell.step")
    assert [failure.message for failure in report["labels"].failures] == ["2 has '7' drawn on it."]


def test_strokes_without_a_panel_are_found(tmp_path):
    assembly = ifs.to_assembly(folded_shell(1), label="wire")
    part(assembly, "1-strokes").name = "7-strokes"
    report = checked(assembly, tmp_path / "shell.step")
    assert report["labels"].addresses == ("7",)
    assert report["labels"].values["not_labelled"] == 1


def test_parts_that_share_volume_are_found(assembly, tmp_path):
    pushed = part(assembly, "12")
    pushed.loc = Location((0, 3, 0)) * pushed.loc
    report = checked(assembly, tmp_path / "shell.step")
    assert "interference" in failed(report)
    assert all("12" in failure.addresses for failure in report["interference"].failures)
    assert 1.0 < report["interference"].values["deepest"] < 1.5


def test_panels_that_collide_at_nodes_are_found(tmp_path):
    shell = folded_shell(nodes="plain")
    named = {frozenset(clash.addresses) for clash in ifs.clashes(shell)}
    report = checked(ifs.to_assembly(shell, validate=False), tmp_path / "shell.step")
    assert failed(report) == {"interference"}
    assert {frozenset(f.addresses) for f in report["interference"].failures} == named
    assert named


def test_modified_part_passes_and_is_left_out_of_the_joints(assembly, tmp_path):
    modified = part(assembly, "12")
    notch = cq.Solid.makeBox(40, 40, 40).moved(Location((0, 0, -10)))
    modified.obj = modified.obj.cut(notch)
    report = checked(assembly, tmp_path / "shell.step")
    assert report.ok
    assert report["joints"].values["parts_left_out"] == 1
    assert report["volumes"].values["exact"] == 16


def test_modified_part_that_shares_volume_is_found_by_intersection(tmp_path):
    assembly = cq.Assembly(name="plates")
    assembly.add(plate(), name="a")
    rounded = plate().edges("|Z").fillet(5).val()
    assembly.add(rounded, name="b", loc=Location((99, 0, 0)))
    report = checked(assembly, tmp_path / "plates.step")
    assert failed(report) == {"interference"}
    assert report["interference"].failures[0].addresses == ("a", "b")
    # a strip 1 mm wide, whose corners the fillet has rounded off: segments of a circle
    chord = 5 * 5 * np.arccos(4 / 5) / 2 - 4 * 3 / 2
    wanted = 90 * 1 * 10 + 2 * chord * 10
    assert report["interference"].values["largest_volume"] == pytest.approx(wanted, rel=1e-6)


@pytest.mark.parametrize("as_solid", [False, True])
def test_open_shell_is_found(assembly, as_solid, tmp_path):
    damaged = part(assembly, "02")
    builder = BRep_Builder()
    shell = TopoDS_Shell()
    builder.MakeShell(shell)
    for face in damaged.obj.Faces()[1:]:
        builder.Add(shell, face.wrapped)
    made = cq.Shell(shell)
    if as_solid:
        solid = TopoDS_Solid()
        builder.MakeSolid(solid)
        builder.Add(solid, shell)
        made = cq.Solid(solid)
    damaged.obj = made
    report = checked(assembly, tmp_path / "shell.step")
    assert "solids" in failed(report)
    assert report["solids"].addresses == ("02",)


# --- damaged text ---------------------------------------------------------------------------------


def tampered(path, old, new, count=1):
    text = path.read_text(encoding="ascii")
    assert old in text
    path.write_text(text.replace(old, new, count), encoding="ascii")
    return check_step(path)


@pytest.fixture
def plates(tmp_path):
    path = tmp_path / "plates.step"
    ifs.export_step(two_plates(0.4), path)
    return path


def test_moved_vertex_is_found(plates):
    report = tampered(plates, "(100.,100.,10.)", "(100.,100.,10.01)", -1)
    assert "faces" in failed(report)
    assert set(report["faces"].addresses) == {"a", "b"}
    assert report["faces"].values["worst"] == pytest.approx(0.01, rel=0.1)


def test_broken_syntax_is_found(plates):
    report = tampered(plates, "\nDATA;", "\nDATA; #1 = (((")
    assert failed(report) == {"file"}
    assert "Incorrect syntax" in report["file"].failures[0].message


def test_missing_entity_and_the_part_that_it_empties_are_found(plates):
    text = plates.read_text(encoding="ascii")
    report = tampered(plates, re.findall(r"#\d+ = CARTESIAN_POINT.*;\n", text)[20], "")
    assert failed(report) == {"file", "solids"}
    assert "Unresolved Reference" in report["file"].failures[0].message
    assert report["solids"].failures[0].message == "a holds no closed solid."


def test_other_unit_is_found(plates):
    report = tampered(plates, "SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT(.CENTI.,.METRE.)", -1)
    assert failed(report) == {"file"}
    assert "centimetre" in report["file"].failures[0].message
    assert report["thickness"].values["thickness"] == pytest.approx(100.0)


def test_name_used_twice_is_found(plates):
    report = tampered(plates, "'b'", "'a'", -1)
    assert failed(report) == {"names"}
    assert report["names"].failures[0].message == "2 parts are called 'a'."


def test_foreign_name_is_found(plates):
    report = tampered(plates, "'b'", r"'\X2\00E9\X0\'", -1)
    assert failed(report) == {"names"}
    assert report["names"].addresses == ("é",)


def test_hole_of_another_radius_is_found(tmp_path):
    assembly = cq.Assembly(name="plates")
    pierced = plate().faces(">Z").workplane(origin=(50, 50, 0)).hole(8.0)
    assembly.add(pierced, name="a")
    path = tmp_path / "plates.step"
    ifs.export_step(assembly, path)
    assert check_step(path)["volumes"].values["holes"] == pytest.approx(160 * np.pi, rel=1e-12)
    text = path.read_text(encoding="ascii")
    start = text.index("CYLINDRICAL_SURFACE")
    assert ",4.);" in text[start : start + 60]
    path.write_text(text[:start] + text[start:].replace(",4.);", ",4.001);", 1), encoding="ascii")
    report = check_step(path)
    assert "faces" in failed(report)


# --- reports and errors ---------------------------------------------------------------------------


def test_report_is_a_table_and_json(plates):
    report = check_step(plates)
    lines = str(report).splitlines()
    assert lines[0] == "plates.step"
    assert [line.split()[0] for line in lines[1:-1]] == ["pass"] * 9
    assert lines[-1] == "All checks passed."
    data = json.loads(json.dumps(report.as_dict(), allow_nan=False))
    assert data["ok"] is True
    assert [check["name"] for check in data["checks"]] == [
        "file",
        "names",
        "solids",
        "volumes",
        "faces",
        "thickness",
        "labels",
        "joints",
        "interference",
    ]


def test_failures_stand_under_their_line(plates):
    report = check_step(plates, clearance=0.0)
    lines = str(report).splitlines()
    place = next(k for k, line in enumerate(lines) if line.split()[0] == "FAIL")
    assert lines[place].split()[1] == "joints"
    assert lines[place + 1].strip() == "The joint of a and b gapes 0.400000 mm, not 0.000000 mm."
    assert lines[-1] == "1 of 9 checks failed."
    failure = report.as_dict()["checks"][7]["failures"][0]
    assert failure["addresses"] == ["a", "b"]


def test_solids_of_any_kind_give_a_report(tmp_path):
    assembly = cq.Assembly(name="odd")
    odd = {
        "ball": cq.Workplane().sphere(10),
        "ring": cq.Workplane(obj=cq.Solid.makeTorus(20, 5)),
        "cone": cq.Workplane(obj=cq.Solid.makeCone(10, 3, 8)),
        "loop": cq.Workplane().spline([(0, 0), (10, 5), (20, 0)]).close().extrude(5),
        "hollow": cq.Workplane().box(30, 30, 10).cut(cq.Workplane().box(5, 5, 5)),
        "slotted": cq.Workplane().box(60, 30, 10).faces(">Z").workplane().slot2D(9, 4).cutBlind(-2),
    }
    for number, (name, shape) in enumerate(odd.items()):
        assembly.add(shape, name=name, loc=Location((100 * number, 0, 0)))
    pair = [cq.Solid.makeBox(30, 30, 10).moved(Location((x, -50, 0))) for x in (0, 50)]
    assembly.add(cq.Compound.makeCompound(pair), name="pair")
    report = checked(assembly, tmp_path / "odd.step")
    assert report["solids"].values == {"solids": 8, "valid_and_closed": 8}
    assert report["volumes"].values["exact"] == 4
    assert set(report["thickness"].addresses) == {"ball", "ring", "cone", "loop"}
    assert failed(report) == {"thickness"}


def test_progress_is_reported(plates):
    heard = []
    with progress.listening(lambda *news: heard.append(news)):
        check_step(plates)
    assert ("reading plates.step", 0, None) in heard
    assert ("checking solids", 2, 2) in heard
    assert ("reading labels", 2, 2) in heard


def test_nothing_is_printed(plates, capfd):
    check_step(plates)
    assert capfd.readouterr() == ("", "")


def test_missing_file_is_an_error(tmp_path):
    with pytest.raises(CheckError, match=r"There is no file .*nowhere\.step"):
        check_step(tmp_path / "nowhere.step")


def test_folder_is_an_error(tmp_path):
    with pytest.raises(CheckError, match="cannot be read"):
        check_step(tmp_path)


@pytest.mark.parametrize("content", [b"", b"solid stl\n", bytes(range(256))])
def test_file_that_is_not_step_is_an_error(content, tmp_path):
    path = tmp_path / "other.step"
    path.write_bytes(content)
    with pytest.raises(CheckError, match="is not a STEP file"):
        check_step(path)


def test_truncated_file_is_an_error(plates, capfd):
    plates.write_bytes(plates.read_bytes()[:5000])
    with pytest.raises(CheckError, match="breaks off before its end"):
        check_step(plates)


def test_text_that_is_no_step_is_an_error_and_prints_nothing(tmp_path, capfd):
    path = tmp_path / "other.step"
    path.write_text("Not ISO-10303-21;\nwhatever this is\nEND-ISO-10303-21;\n", encoding="ascii")
    with pytest.raises(CheckError, match="not valid STEP"):
        check_step(path)
    assert capfd.readouterr() == ("", "")


def test_file_without_solids_is_an_error(tmp_path):
    assembly = cq.Assembly(cq.Wire.makeCircle(5, (0, 0, 0), (0, 0, 1)), name="line")
    path = ifs.export_step(assembly, tmp_path / "line.step")
    with pytest.raises(CheckError, match="no solid"):
        check_step(path)


def test_negative_clearance_is_an_error(plates):
    with pytest.raises(InputError, match="Clearance"):
        check_step(plates, clearance=-0.1)


def test_a_part_that_its_user_changed_is_named(tmp_path):
    surface = ifs.vector_sum([(0, 0), (400, 0), (800, 0)], [(0, 0, 0), (0, 400, 90), (0, 800, 0)])
    assembly = ifs.to_assembly(ifs.thicken(surface, 20.0))
    part = next(part for part in assembly.objects.values() if part.obj is not None)
    middle = cq.Workplane().sphere(30).val().moved(cq.Location((200, 200, 20)))
    part.obj = part.obj.cut(middle)
    report = check_step(ifs.export_step(assembly, tmp_path / "cut.step"))
    assert report.ok, str(report)
    assert f"no longer the shape of a panel: {part.name}" in report["volumes"].finding
