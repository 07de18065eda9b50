"""STEP files: what others read from them, and what happens when they cannot be written."""

import json
import os
import re
import stat
import subprocess
import sys
from pathlib import Path

import cadquery as cq
import numpy as np
import pytest
from brep import assert_solid, planes, points, volume
from OCP.IFSelect import IFSelect_RetError
from OCP.Interface import Interface_Static
from OCP.STEPCAFControl import STEPCAFControl_Writer
from steputils import p21
from vaults import GROUND, THICKNESS, plate, vault

from ifs_cad.elements.cutting import cutting_frames
from ifs_cad.elements.hole import Holes
from ifs_cad.elements.label import Label
from ifs_cad.errors import ExportError, InputError
from ifs_cad.export import step
from ifs_cad.export.step import export_panels, export_step
from ifs_cad.kernel.assembly import STROKES_SUFFIX, modified_parts, to_assembly
from ifs_cad.kernel.panels import to_solid

SETTINGS = (
    "write.step.schema",
    "write.surfacecurve.mode",
    "write.step.unit",
    "xstep.cascade.unit",
)
GOOD = "a good file"


@pytest.fixture(scope="module")
def engraved():
    """A nested assembly of relieved, trimmed, engraved and pierced panels."""
    return to_assembly(vault(floor=GROUND), label="engraved", holes=Holes(), nest=1, name="vault")


@pytest.fixture(scope="module")
def written(engraved, tmp_path_factory):
    """Its STEP file."""
    return export_step(engraved, tmp_path_factory.mktemp("step") / "vault.step")


def settings_now():
    STEPCAFControl_Writer()
    return [Interface_Static.CVal_s(name) for name in SETTINGS]


def parts_of(assembly, place=None):
    """Yield name, shape in the world and colour of every part of an assembly that has a shape."""
    place = assembly.loc if place is None else place * assembly.loc
    if assembly.obj is not None:
        yield assembly.name, assembly.obj.moved(place), assembly.color
    for child in assembly.children:
        yield from parts_of(child, place)


def entities(path):
    """Return the simple entities of a file, read without OpenCascade: (name, parameters)."""
    content = p21.loads(path.read_text("ascii"))
    return [
        (instance.entity.name, instance.entity.params)
        for instance in content.data[0].instances.values()
        if isinstance(instance, p21.SimpleEntityInstance)
    ]


def files_in(folder):
    return sorted(path.name for path in folder.iterdir())


def test_file_reads_back_with_names_places_volumes_and_colours(engraved, written):
    read = {
        name: (shape, colour)
        for name, shape, colour in parts_of(cq.Assembly.importStep(str(written)))
    }
    made = {name: (shape, colour) for name, shape, colour in parts_of(engraved)}
    assert set(read) == set(made) == set(vault(floor=GROUND).addresses)
    for name, (shape, colour) in made.items():
        back, colour_back = read[name]
        (solid,) = back.Solids()
        assert_solid(solid.wrapped, engraved.objects[name].metadata["volume"])
        one, other = (np.unique(points(s.wrapped).round(5), axis=0) for s in (shape, solid))
        np.testing.assert_allclose(one, other, rtol=0, atol=2e-5)
        assert colour_back.toTuple() == pytest.approx(colour.toTuple(), abs=1e-3)


def test_nesting_reads_back(engraved, written):
    read = cq.Assembly.importStep(str(written))
    assert read.name == "vault"
    assert {child.name for child in read.children} == {f"vault-{k}" for k in range(4)}
    for group in read.children:
        names = {child.name for child in group.children}
        assert names == {child.name for child in engraved.objects[group.name].children}


def test_plain_importer_finds_all_solids(engraved, written):
    solids = cq.importers.importStep(str(written)).solids().vals()
    expected = sorted(
        part.metadata["volume"] for part in engraved.objects.values() if "volume" in part.metadata
    )
    assert len(expected) == 16
    assert sorted(volume(s.wrapped) for s in solids) == pytest.approx(expected, rel=1e-9)


def test_file_reads_back_in_gmsh(engraved, written):
    program = """
import gmsh, json, sys
gmsh.initialize(interruptible=False)
gmsh.option.setNumber("General.Terminal", 0)
gmsh.option.setNumber("Geometry.OCCImportLabels", 1)
solids = gmsh.model.occ.importShapes(sys.argv[1])
gmsh.model.occ.synchronize()
print(json.dumps({gmsh.model.getEntityName(*s): gmsh.model.occ.getMass(*s) for s in solids}))
"""
    answer = subprocess.run(
        [sys.executable, "-c", program, str(written)], capture_output=True, text=True, check=True
    )
    read = {name.rpartition("/")[2]: mass for name, mass in json.loads(answer.stdout).items()}
    expected = {
        name: part.metadata["volume"]
        for name, part in engraved.objects.items()
        if "volume" in part.metadata
    }
    assert read == pytest.approx(expected, rel=1e-6)


def test_products_are_named_as_in_the_assembly_and_uniquely(engraved, written):
    names = [params[0] for kind, params in entities(written) if kind == "PRODUCT"]
    assert sorted(names) == sorted(engraved.objects)
    assert len(set(names)) == len(names)
    kinds = [kind for kind, _ in entities(written)]
    assert kinds.count("MANIFOLD_SOLID_BREP") == 16


@pytest.mark.parametrize(
    ("schema", "said"), [("AP214", "AUTOMOTIVE_DESIGN"), ("AP242", "AP242_MANAGED_MODEL_BASED")]
)
def test_schema_and_unit_are_in_the_file(tmp_path, schema, said):
    path = export_step(to_assembly(plate(400, 300)), tmp_path / "plate.step", schema=schema)
    text = path.read_text("ascii")
    assert re.search(r"FILE_SCHEMA\s*\(\s*\(\s*'([^']*)'", text)[1].startswith(said)
    assert "SI_UNIT(.MILLI.,.METRE.)" in text
    (read,) = cq.importers.importStep(str(path)).solids().vals()
    assert_solid(read.wrapped, 400 * 300 * THICKNESS)


def test_pcurves_are_written_only_when_asked(tmp_path):
    assembly = to_assembly(plate(400, 300), label="engraved")
    without = export_step(assembly, tmp_path / "without.step")
    with_them = export_step(assembly, tmp_path / "with.step", pcurves=True)
    assert b"PCURVE" not in without.read_bytes()
    assert b"PCURVE" in with_them.read_bytes()
    for path in (without, with_them):
        (read,) = cq.importers.importStep(str(path)).solids().vals()
        assert_solid(read.wrapped, assembly.objects["f0000"].metadata["volume"])


def test_engraved_panels_of_four_digits_stay_small(tmp_path):
    shell = vault(4).part(["0*", "33*"])
    plain = to_assembly(shell, label="engraved", validate=False)
    pierced = to_assembly(shell, label="engraved", holes=Holes(), validate=False)
    for assembly, limit in ((plain, 80e3), (pierced, 100e3)):
        path = export_step(assembly, tmp_path / "shell.step")
        assert path.stat().st_size / len(shell) <= limit


def test_wires_read_back_beside_their_panels(tmp_path):
    assembly = to_assembly(vault(), label="wire")
    path = export_step(assembly, tmp_path / "wire.step")
    read = {name: shape for name, shape, _ in parts_of(cq.Assembly.importStep(str(path)))}
    assert set(read) == {a + end for a in vault().addresses for end in ("", STROKES_SUFFIX)}
    for name, shape, _ in parts_of(assembly):
        assert len(read[name].Edges()) == len(shape.Edges())
        lengths = [sum(edge.Length() for edge in s.Edges()) for s in (shape, read[name])]
        assert lengths[0] == pytest.approx(lengths[1], rel=1e-9)


def test_modified_part_is_written_as_it_is_and_told(tmp_path):
    assembly = to_assembly(vault())
    part = assembly.objects["12"]
    part.obj = part.obj.cut(cq.Solid.makeBox(80, 60, 50))
    assert modified_parts(assembly) == ["12"]
    path = export_step(assembly, tmp_path / "modified.step")
    read = {name: shape for name, shape, _ in parts_of(cq.Assembly.importStep(str(path)))}
    left = volume(part.obj.wrapped)
    assert left < part.metadata["volume"] * 0.99
    assert volume(read["12"].wrapped) == pytest.approx(left, rel=1e-9)
    (flat,) = [p for p in export_panels(assembly, tmp_path / "flat") if p.stem == "12"]
    (solid,) = cq.importers.importStep(str(flat)).solids().vals()
    assert volume(solid.wrapped) == pytest.approx(left, rel=1e-9)


@pytest.mark.parametrize("face", ["inner", "outer"])
def test_flat_panels_lie_on_the_table_with_the_marked_face_up(tmp_path, face):
    shell = vault(floor=GROUND)
    assembly = to_assembly(shell, label=Label(face=face), holes=Holes(), nest=1)
    files = export_panels(assembly, tmp_path / "new" / "flat")
    assert [path.name for path in files] == [f"{address}.step" for address in shell.addresses]
    frames = cutting_frames(shell, face)
    for k, path in enumerate(files):
        (solid,) = cq.importers.importStep(str(path)).solids().vals()
        assert_solid(solid.wrapped, assembly.objects[path.stem].metadata["volume"])
        np.testing.assert_allclose(points(solid.wrapped).min(axis=0), 0.0, rtol=0, atol=1e-6)
        levels = {
            round(level * normal[2], 6)
            for normal, level, _ in planes(solid.wrapped)
            if abs(normal[2]) > 1 - 1e-9
        }
        assert levels == {0.0, THICKNESS - 0.5, THICKNESS}  # the pocket's floor is near the top
        corners = frames.solids.vertices[frames.solids.solid_of_vertex == k]
        made = points(solid.wrapped)
        apart = np.linalg.norm(corners[:, None] - made[None], axis=2).min(axis=1)
        np.testing.assert_allclose(apart, 0.0, atol=1e-6)
        assert re.search(rf"PRODUCT\('{path.stem}'", path.read_text("ascii"))


def test_flat_panels_carry_their_wires(tmp_path):
    shell = vault().part("0*")
    for path in export_panels(to_assembly(shell, label="wire"), tmp_path):
        read = {name: shape for name, shape, _ in parts_of(cq.Assembly.importStep(str(path)))}
        assert set(read) == {path.stem, path.stem + STROKES_SUFFIX}
        strokes = points(read[path.stem + STROKES_SUFFIX].wrapped)
        np.testing.assert_allclose(strokes[:, 2], THICKNESS, rtol=0, atol=1e-6)


def test_removed_parts_have_no_flat_file(tmp_path):
    assembly = to_assembly(vault().part("0*"))
    assembly.remove("01")
    assert [path.stem for path in export_panels(assembly, tmp_path)] == ["00", "02", "03"]


def test_only_shells_have_flat_panels(tmp_path):
    with pytest.raises(InputError, match="to_assembly"):
        export_panels(cq.Assembly(cq.Workplane().box(1, 1, 1)), tmp_path)


def test_any_assembly_can_be_written(tmp_path):
    assembly = cq.Assembly(name="two")
    assembly.add(cq.Workplane().box(10, 10, 10), name="box", color=cq.Color("red"))
    assembly.add(to_solid(vault()["12"]), name="12")
    path = export_step(assembly, tmp_path / "two.step")
    read = {name: shape.Volume() for name, shape, _ in parts_of(cq.Assembly.importStep(str(path)))}
    assert read == pytest.approx({"box": 1000.0, "12": vault()["12"].volume})


def test_nothing_is_printed_even_when_others_want_it(tmp_path):
    # in a process of its own: OpenCascade prints to a buffer that is emptied when it ends
    program = """
import sys
import ifs_cad as ifs
import cadquery  # turns messages down when it is imported
from OCP.Message import Message, Message_Gravity
(printer,) = Message.DefaultMessenger_s().Printers()
printer.SetTraceLevel(Message_Gravity.Message_Trace)
shell = ifs.thicken(ifs.Mesh([(0, 0, 0), (99, 0, 0), (99, 99, 0), (0, 99, 0)], [(0, 1, 2, 3)]), 9)
assembly = ifs.to_assembly(shell, label="engraved")
for schema in ("AP214", "AP242"):
    ifs.export_step(assembly, sys.argv[1] + "/shell.step", schema=schema)
ifs.export_panels(assembly, sys.argv[1])
assert printer.GetTraceLevel() == Message_Gravity.Message_Trace
"""
    answer = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path)], capture_output=True, text=True, check=True
    )
    assert (answer.stdout, answer.stderr) == ("", "")
    assert files_in(tmp_path) == ["f0000.step", "shell.step"]


def test_global_settings_are_as_before(tmp_path):
    before = settings_now()
    try:
        Interface_Static.SetCVal_s("write.step.schema", "AP203")
        Interface_Static.SetIVal_s("write.surfacecurve.mode", 1)
        Interface_Static.SetCVal_s("write.step.unit", "INCH")
        mine = settings_now()
        assert mine != before
        path = export_step(to_assembly(plate(400, 300)), tmp_path / "a.step", schema="AP242")
        assert settings_now() == mine
        text = path.read_text("ascii")
        assert "AP242" in text
        assert "SI_UNIT(.MILLI.,.METRE.)" in text
        assert "INCH" not in text
    finally:
        for name, value in zip(SETTINGS, before, strict=True):
            Interface_Static.SetCVal_s(name, value)
    assert settings_now() == before


@pytest.mark.parametrize("stage", ["document", "transfer", "write", "raise", "empty"])
def test_failing_export_keeps_the_good_file_and_the_settings(tmp_path, monkeypatch, stage):
    class Writer(STEPCAFControl_Writer):
        def Transfer(self, *given):  # noqa: N802  the kernel's name
            return stage != "transfer" and super().Transfer(*given)

        def Write(self, name):  # noqa: N802  the kernel's name
            if stage == "empty":
                return super().Write(os.devnull)
            Path(name).write_text("ISO-10303-21; and then the disk was fu")
            if stage == "raise":
                raise OSError(28, "No space left on device")
            return IFSelect_RetError

    def broken(*_, **__):
        raise RuntimeError("the kernel gave up")

    target, before = tmp_path / "shell.step", settings_now()
    target.write_text(GOOD)
    assembly = to_assembly(plate(400, 300))
    monkeypatch.setattr(step, "STEPCAFControl_Writer", Writer)
    if stage == "document":
        monkeypatch.setattr(step, "toCAF", broken)
    with pytest.raises(RuntimeError if stage == "document" else ExportError) as caught:
        export_step(assembly, target, schema="AP242", pcurves=True)
    if stage not in ("document", "transfer"):
        assert str(target) in str(caught.value)
    assert target.read_text() == GOOD
    assert files_in(tmp_path) == ["shell.step"]
    assert settings_now() == before
    monkeypatch.undo()
    export_step(assembly, target)
    assert files_in(tmp_path) == ["shell.step"]
    assert len(cq.importers.importStep(str(target)).solids().vals()) == 1


def test_interrupted_export_keeps_the_good_file(tmp_path, monkeypatch):
    class Writer(STEPCAFControl_Writer):
        def Write(self, name):  # noqa: N802  the kernel's name
            Path(name).write_text("ISO-10303-21;")
            raise KeyboardInterrupt

    target = tmp_path / "shell.step"
    target.write_text(GOOD)
    monkeypatch.setattr(step, "STEPCAFControl_Writer", Writer)
    with pytest.raises(KeyboardInterrupt):
        export_step(to_assembly(plate(400, 300)), target)
    assert target.read_text() == GOOD
    assert files_in(tmp_path) == ["shell.step"]


def test_target_that_is_a_folder_is_an_error(tmp_path):
    (tmp_path / "shell.step").mkdir()
    with pytest.raises(ExportError, match=r"Cannot write .*shell\.step"):
        export_step(to_assembly(plate(400, 300)), tmp_path / "shell.step")
    assert files_in(tmp_path) == ["shell.step"]


def test_folder_that_is_a_file_is_an_error(tmp_path):
    (tmp_path / "out").write_text(GOOD)
    with pytest.raises(ExportError, match=r"Cannot write .*shell\.step"):
        export_step(to_assembly(plate(400, 300)), tmp_path / "out" / "shell.step")
    assert (tmp_path / "out").read_text() == GOOD


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root writes anywhere")
def test_folder_that_cannot_be_written_is_an_error(tmp_path):
    tmp_path.chmod(stat.S_IRUSR | stat.S_IXUSR)
    try:
        with pytest.raises(ExportError, match="Permission denied"):
            export_step(to_assembly(plate(400, 300)), tmp_path / "shell.step")
    finally:
        tmp_path.chmod(stat.S_IRWXU)
    assert files_in(tmp_path) == []


def test_missing_folders_are_made_and_old_files_replaced(tmp_path):
    target = tmp_path / "a" / "b" / "plate.step"
    small, large = (to_assembly(plate(side, 300)) for side in (400, 500))
    assert export_step(small, str(target)) == target
    export_step(large, target)
    (read,) = cq.importers.importStep(str(target)).solids().vals()
    assert read.Volume() == pytest.approx(500 * 300 * THICKNESS)
    assert files_in(target.parent) == ["plate.step"]
    assert target.stat().st_mode & 0o444 == 0o444


@pytest.mark.parametrize("where", ["root", "part"])
def test_name_that_is_not_ascii_is_an_error(tmp_path, where):
    assembly = cq.Assembly(name="Hülle" if where == "root" else "shell")
    assembly.add(cq.Workplane().box(1, 1, 1), name="box" if where == "root" else "Größe")
    with pytest.raises(InputError, match=r"ASCII; rename (Hülle|Größe)\.") as caught:
        export_step(assembly, tmp_path / "shell.step")
    assert caught.value.addresses in (("Hülle",), ("Größe",))
    assert files_in(tmp_path) == []


def test_assembly_without_shapes_is_an_error(tmp_path):
    empty = cq.Assembly(name="nothing")
    empty.add(cq.Assembly(name="nothing either"))
    with pytest.raises(InputError, match="nothing holds no shape"):
        export_step(empty, tmp_path / "shell.step")
    assert files_in(tmp_path) == []


@pytest.mark.parametrize("schema", ["AP203", "ap214", ""])
def test_unknown_schema_is_an_error(tmp_path, schema):
    with pytest.raises(InputError, match='"AP214" or "AP242"'):
        export_step(to_assembly(plate(400, 300)), tmp_path / "shell.step", schema=schema)
    assert files_in(tmp_path) == []


def test_a_link_is_followed_and_stays_a_link(tmp_path):
    real, link = tmp_path / "real.step", tmp_path / "link.step"
    real.write_text("old")
    link.symlink_to(real)
    export_step(cq.Assembly(cq.Workplane().box(1, 1, 1), name="box"), link)
    assert link.is_symlink()
    assert real.read_text().startswith("ISO-10303-21")


def test_a_pipe_is_refused_and_stays_a_pipe(tmp_path):
    pipe = tmp_path / "pipe.step"
    os.mkfifo(pipe)
    with pytest.raises(ExportError, match="not a file"):
        export_step(cq.Assembly(cq.Workplane().box(1, 1, 1), name="box"), pipe)
    assert pipe.is_fifo()


def test_only_an_assembly_can_be_written(tmp_path):
    with pytest.raises(InputError, match="to_assembly"):
        export_step(cq.Workplane().box(1, 1, 1), tmp_path / "x.step")
