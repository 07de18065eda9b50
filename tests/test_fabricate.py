"""Whole fabrication folders by the real command line: what is in them, and that none is lost."""

import csv
import hashlib
import itertools
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import cadquery as cq
import numpy as np
import openpyxl
import pytest
from cadquery.occ_impl.importers.assembly import importStep

from ifs_cad.errors import AddressError, ExportError, InputError, ScriptError, StockError
from ifs_cad.fabrication.workshop import Workshop
from ifs_cad.workflow import fabricate as module
from ifs_cad.workflow.fabricate import FORMER, fabricate
from ifs_cad.workflow.manifest import NAME, differences, read_manifest

SHELL = """
import ifs_cad as ifs
thickness = 10.0
depth = 2
die = False
arch = ifs.Curve([(0, 0, 0), (0, 0, 1500), (2500, 0, 1500), (2500, 0, 0)], depth=depth)
fold = ifs.Curve([(0, 0, 0), (0, 600, 300), (0, 1500, 0)], depth=depth)
shell = ifs.thicken(ifs.vector_sum(arch, fold), thickness).with_fibre(ifs.FibreAlongCurve("a"))
if die:  # when the first files are there
    from ifs_cad.export import step
    import os, signal
    def sheets(*args, **options):
        os.kill(os.getpid(), signal.SIGKILL)
    step.export_sheets = sheets
show_object(ifs.to_assembly(shell, label=ifs.Label(), holes=ifs.Holes()), name="shell")
"""

VAULT = """
import ifs_cad as ifs
curve = ifs.Curve([(0, 0, 0), (0, 0, 1500), (2000, 0, 1500), (2000, 0, 0)], depth=2)
vault = ifs.vault(curve, 150, 27, layers=3, stagger=True)
show_object(ifs.to_assembly(vault, label=ifs.Label(), holes=ifs.Screws(5)), name="vault")
"""

BOX = "import cadquery as cq\nshow_object(cq.Workplane().box(1, 1, 1))\n"

pytest.importorskip("reportlab")
pytest.importorskip("xlsxwriter")


@pytest.fixture(scope="module")
def shell_script(tmp_path_factory):
    path = tmp_path_factory.mktemp("shell") / "dome.py"
    path.write_text(SHELL)
    return path


@pytest.fixture(scope="module")
def shell_folder(shell_script):
    return fabricate(shell_script, out=shell_script.parent / "exports").folder


@pytest.fixture(scope="module")
def vault_folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("vault") / "barrel.py"
    path.write_text(VAULT)
    return fabricate(path, out=path.parent / "exports").folder


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def column(row: dict[str, str], *words: str) -> str:
    (name,) = [name for name in row if all(word in name.lower() for word in words)]
    return row[name].strip("'=\"")


def test_folder_holds_all_that_a_workshop_needs(shell_folder):
    places = {p.relative_to(shell_folder).as_posix() for p in shell_folder.rglob("*.*")}
    assert {
        "dome.step",
        "dome.btlx",
        "dome.png",
        "index.html",
        NAME,
        "sheets/sheet-01.step",
        "sheets/sheet-01.dxf",
        "drawings/sheets.pdf",
        "drawings/elements.pdf",
        "drawings/assembly.pdf",
        "lists/cut_list.csv",
        "lists/cut_list.xlsx",
        "lists/saw_list.csv",
        "lists/saw_list.xlsx",
    } <= places
    assert len([p for p in places if p.endswith(".part")]) == 0


def test_manifest_lists_every_file_with_its_checksum(shell_folder):
    listed = read_manifest(shell_folder)
    found = {
        p.relative_to(shell_folder).as_posix(): hashlib.sha256(p.read_bytes()).hexdigest()
        for p in shell_folder.rglob("*")
        if p.is_file() and p.name != NAME
    }
    assert {place: entry["sha256"] for place, entry in listed.items()} == found
    assert differences(shell_folder) == []
    facts = json.loads((shell_folder / NAME).read_text())
    assert facts["part"] == "dome.py"
    assert facts["workshop"]["cutter"] == 12.0


def test_differences_name_what_was_changed_or_lost(shell_folder, tmp_path):
    copy = tmp_path / "copy"
    shutil.copytree(shell_folder, copy)
    (copy / "dome.png").unlink()
    with (copy / "index.html").open("a") as file:
        file.write(" ")
    assert differences(copy) == ["dome.png is missing", "index.html was changed"]


def test_every_panel_lies_once_on_a_sheet_and_its_numbers_are_those_of_the_solids(shell_folder):
    volumes, areas = {}, {}
    for path in sorted((shell_folder / "sheets").glob("*.step")):
        sheet = cq.Assembly(name=path.stem)
        importStep(sheet, str(path))
        for shape, name, _, _ in sheet:
            address = name.split("/")[-1]
            assert address not in volumes
            volumes[address] = shape.Volume()
            faces = [f for f in shape.Faces() if abs(abs(f.normalAt().z) - 1) < 1e-9]
            box = shape.BoundingBox()
            assert box.zmin == pytest.approx(0, abs=1e-6)
            assert box.zmax == pytest.approx(10, abs=1e-6)
            areas[address] = max(cq.Face.makeFromWires(f.outerWire()).Area() for f in faces)
    listed = rows(shell_folder / "lists" / "cut_list.csv")
    listed = [row for row in listed if any(row.values())]
    assert {column(row, "address") for row in listed} == set(volumes)
    assert len(listed) == len(volumes) == 16
    for row in listed:
        address = column(row, "address")
        assert float(column(row, "mass")) == pytest.approx(volumes[address] * 450e-9, rel=1e-9)
        scale = 1e-6 if "m2" in next(k for k in row if "area" in k.lower()) else 1.0
        if "mm2" in next(k for k in row if "area" in k.lower()):
            scale = 1.0
        assert float(column(row, "area")) == pytest.approx(areas[address] * scale, rel=1e-9)


def test_addresses_stay_text_in_the_spreadsheet(shell_folder):
    book = openpyxl.load_workbook(shell_folder / "lists" / "cut_list.xlsx")
    cells = [row[0] for row in book.worksheets[0].iter_rows(min_row=2, values_only=True)]
    assert {"00", "01", "33"} <= set(cells)


def test_vault_gets_boards_and_a_list_of_planks(vault_folder):
    assert (vault_folder / "drawings" / "boards.pdf").is_file()
    assert (vault_folder / "lists" / "planks.xlsx").is_file()
    boards = sorted((vault_folder / "boards").glob("board-*.step"))
    found = []
    for path in boards:
        board = cq.Assembly(name=path.stem)
        importStep(board, str(path))
        laid = [shape.moved(place).BoundingBox() for shape, _, place, _ in board]
        boxes = sorted(laid, key=lambda box: box.xmin)
        found += [name.split("/")[-1] for _, name, _, _ in board]
        for box in boxes:
            assert box.ymin == pytest.approx(0, abs=1e-6)
            assert box.ymax == pytest.approx(150, abs=1e-6)
        gaps = [b.xmin - a.xmax for a, b in itertools.pairwise(boxes)]
        assert min(gaps, default=4.0) >= 4.0 - 1e-6  # the kerf
        assert boxes[-1].xmax <= 5000 - 10 + 1e-6
    assert len(found) == len(set(found)) == 4 + 5 + 4


def test_part_of_a_shell_keeps_the_chamfers_of_the_whole(shell_script, shell_folder, tmp_path):
    done = fabricate(shell_script, out=tmp_path, workshop=Workshop(only=("0*", "33")))
    whole = {column(r, "address"): r for r in rows(shell_folder / "lists" / "cut_list.csv")}
    listed = rows(done.folder / "lists" / "cut_list.csv")
    assert [column(r, "address") for r in listed] == ["00", "01", "02", "03", "33"]
    for row in listed:
        for name, value in row.items():
            if "angle" in name.lower() or "inclination" in name.lower() or "length" in name.lower():
                assert value == whole[column(row, "address")][name]
    model = cq.Assembly(name="part")
    importStep(model, str(done.folder / "dome.step"))
    assert len(list(model)) == 5


def test_rerun_takes_the_place_of_the_folder_and_keeps_the_users_files(shell_script, tmp_path):
    first = fabricate(shell_script, out=tmp_path)
    (first.folder / "notes.txt").write_text("mine")
    (first.folder / "sheets" / "photo.jpg").write_bytes(b"jpeg")
    second = fabricate(
        shell_script, out=tmp_path, settings={"thickness": 12}, workshop=Workshop(only=("00",))
    )
    assert second.folder == first.folder
    assert (first.folder / "notes.txt").read_text() == "mine"
    assert (first.folder / "sheets" / "photo.jpg").read_bytes() == b"jpeg"
    listed = rows(first.folder / "lists" / "cut_list.csv")
    assert [column(r, "address") for r in listed] == ["00"]
    assert "notes.txt" not in read_manifest(first.folder)
    assert {p.name for p in tmp_path.iterdir()} == {"dome"}


def test_run_that_dies_leaves_the_former_folder_whole(shell_script, tmp_path):
    folder = fabricate(shell_script, out=tmp_path).folder
    with pytest.raises(module.WorkerError, match=r"Nothing in .* was changed"):
        fabricate(shell_script, out=tmp_path, settings={"die": True})
    assert differences(folder) == []
    assert {p.name for p in tmp_path.iterdir()} == {"dome"}


def test_run_that_died_in_the_swap_is_made_good_by_the_next(shell_script, tmp_path):
    folder = tmp_path / "dome"
    folder.mkdir()
    (folder / "mine.txt").write_text("kept")
    folder.rename(tmp_path / f"dome{FORMER}")
    with pytest.raises(StockError):
        fabricate(shell_script, out=tmp_path, settings={"thickness": 11})
    assert (folder / "mine.txt").read_text() == "kept"
    assert not (tmp_path / f"dome{FORMER}").exists()


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_interrupt_ends_the_command_and_changes_nothing(shell_script, tmp_path):
    command = [sys.executable, "-m", "ifs_cad.cli", "fabricate", str(shell_script), "-o", "out"]
    process = subprocess.Popen(
        command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    for line in process.stdout:
        if "running" in line:
            break
    time.sleep(0.2)
    process.send_signal(signal.SIGINT)
    _, complaint = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "nothing in out/dome was changed" in complaint.lower()
    assert not (tmp_path / "out" / "dome").exists()


def test_swap_that_fails_puts_the_former_folder_back(tmp_path, monkeypatch):
    new, folder = tmp_path / "stage", tmp_path / "x"
    folder.mkdir()
    (folder / "old").write_text("old")
    with pytest.raises(ExportError, match="former folder is unchanged"):
        module._swap(new, folder)  # there is no new folder
    assert (folder / "old").read_text() == "old"


def test_errors_say_what_to_do(shell_script, tmp_path):
    box = tmp_path / "box.py"
    box.write_text(BOX)
    with pytest.raises(ScriptError, match="to_assembly"):
        fabricate(box, out=tmp_path)
    with pytest.raises(ScriptError, match="no script"):
        fabricate(tmp_path / "none.py", out=tmp_path)
    with pytest.raises(AddressError, match="9"):
        fabricate(shell_script, out=tmp_path, workshop=Workshop(only=("9*",)))
    with pytest.raises(StockError, match="11"):
        fabricate(shell_script, out=tmp_path, settings={"thickness": 11})
    with pytest.raises(InputError, match="plywood 7"):
        fabricate(shell_script, out=tmp_path, workshop=Workshop(use=("plywood 7",)))
    assert not (tmp_path / "dome").exists()


def test_face_that_is_seen_is_not_engraved_on_sheets_with_one_good_face(shell_script, tmp_path):
    stock = tmp_path / "stock.toml"
    stock.write_text(
        "extend = false\n[[sheets]]\nname = 'B/C'\nlength = 2500\nwidth = 1250\nthickness = 10\n"
        "material = 'spruce plywood'\ngood_faces = 1\n"
    )
    shop = Workshop(stock=str(stock), visible="inner", only=("00",))
    with pytest.raises(StockError, match="only one good face"):
        fabricate(shell_script, out=tmp_path, workshop=shop)
    shop = Workshop(stock=str(stock), visible="outer", only=("00",))
    assert fabricate(shell_script, out=tmp_path, workshop=shop).files > 5


@pytest.mark.parametrize(
    "wrong",
    [{"cutter": 0}, {"margin": -1}, {"kerf": np.nan}, {"method": "slow"}, {"visible": "top"}],
)
def test_workshop_refuses_what_cannot_be_meant(wrong):
    with pytest.raises(InputError):
        Workshop(**wrong)
