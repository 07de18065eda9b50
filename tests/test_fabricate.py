"""Whole fabrication folders by the real command line: what is in them, and that none is lost."""

import csv
import hashlib
import itertools
import json
import os
import re
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
from typer.testing import CliRunner

from ifs_cad.cli import app
from ifs_cad.errors import (
    AddressError,
    ExportError,
    InputError,
    MachineError,
    ScriptError,
    StockError,
    WorkerError,
)
from ifs_cad.fabrication.machining.job import read_job
from ifs_cad.fabrication.machining.verify import verify_file
from ifs_cad.fabrication.workshop import Workshop
from ifs_cad.workflow import fabricate as module
from ifs_cad.workflow.fabricate import FORMER, fabricate
from ifs_cad.workflow.manifest import NAME, differences, read_manifest
from ifs_cad.workflow.verify import verify_programs

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
def vault_script(tmp_path_factory):
    path = tmp_path_factory.mktemp("vault") / "barrel.py"
    path.write_text(VAULT)
    return path


@pytest.fixture(scope="module")
def vault_folder(vault_script):
    return fabricate(vault_script, out=vault_script.parent / "exports").folder


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
        "programs/sheet-01.ngc",
        "programs/job.json",
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
    assert facts["workshop"]["margin"] == 10.0


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


def test_every_program_makes_what_was_designed(shell_folder):
    programs = sorted((shell_folder / "programs").glob("*.ngc"))
    assert [p.stem for p in programs] == [
        p.stem for p in sorted((shell_folder / "sheets").glob("*.step"))
    ]
    found = verify_programs(programs)
    assert all(one.ok for one in found), "\n".join(map(str, found))
    assert sum(one.holes for one in found) == 16 * 4
    assert max(one.plane_error for one in found) < 1e-3
    assert max(one.angle_error for one in found) < 1e-3
    # all are pierced, so they are screwed down after piercing, and nothing holds them otherwise
    text = programs[0].read_text()
    assert "(HOLD none)" in text
    assert text.index("STEP pierce") < text.index("\nM0\n") < text.index("STEP engrave")


def test_page_tells_what_holds_the_pieces_and_how_long_the_machine_runs(shell_folder):
    page = (shell_folder / "index.html").read_text(encoding="utf-8")
    assert "programs/sheet-01.ngc" in page
    times = re.findall(
        r'<td class="number">(\d+):(\d\d)</td><td class="number">3</td><td class="number">1</td>',
        page,
    )
    total = re.search(r"<dt>machining</dt><dd>(\d+):(\d\d) h</dd>", page)
    assert len(times) == len(list((shell_folder / "programs").glob("*.ngc")))
    minutes = sum(60 * int(hours) + int(rest) for hours, rest in times)
    assert 60 * int(total[1]) + int(total[2]) == pytest.approx(minutes, abs=len(times))
    assert f"<dt>tool changes</dt><dd>{3 * len(times)}</dd>" in page
    assert f"<dt>stops for a person</dt><dd>{len(times)}, not in the time</dd>" in page


def test_verify_tells_line_and_fault_of_a_program_that_was_changed(shell_folder, tmp_path):
    program = shell_folder / "programs" / "sheet-01.ngc"
    lines = program.read_text().splitlines()
    start = next(k for k, line in enumerate(lines) if "STEP contour" in line)
    turn = next(k for k, line in enumerate(lines) if k > start and re.search(r"B-?[1-9]", line))
    lines[turn] = re.sub(r"B(-?)", lambda hit: "B" if hit[1] else "B-", lines[turn])
    changed = tmp_path / "sheet-01.ngc"
    changed.write_text("\n".join(lines) + "\n")
    job = shell_folder / "programs" / "job.json"
    good = CliRunner().invoke(app, ["verify", str(program), "--no-simulate"])
    assert (good.exit_code, "verified" in good.output) == (0, True)
    bad = CliRunner().invoke(
        app, ["verify", str(changed), "--job", str(job), "--json", "--no-simulate"]
    )
    assert bad.exit_code == 1
    (report,) = json.loads(bad.output)
    assert not report["ok"]
    assert any(turn < fault["line"] < turn + 12 for fault in report["faults"])
    missing = CliRunner().invoke(app, ["verify", str(changed)])
    assert missing.exit_code == 1
    assert "no job.json beside" in missing.output


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


def test_machine_of_three_axes_gets_square_pieces_and_a_saw_list(shell_script, tmp_path):
    tools = tmp_path / "tools.toml"
    tools.write_text("[machine]\nrotary = 'none'\n")
    shop = Workshop(tools=str(tools), only=("0*",), hold="tabs")
    folder = fabricate(shell_script, out=tmp_path, workshop=shop).folder
    for path in sorted((folder / "programs").glob("*.ngc")):
        moving = re.sub(r"\([^)]*\)", "", path.read_text())
        assert not re.search(r"[ABC]-?\d", moving)
        assert verify_file(path).ok
    job = read_job(folder / "programs" / "job.json")
    assert {side.inclination for piece in job.workpieces for side in piece.sides} == {0.0}
    assert len(rows(folder / "lists" / "saw_list.csv")) > 0


def test_no_programs_are_written_where_none_are_wanted(shell_script, tmp_path):
    shop = Workshop(programs=False, only=("00",))
    done = fabricate(shell_script, out=tmp_path, workshop=shop)
    assert not (done.folder / "programs").exists()
    assert "machining" not in done.report


def test_planks_are_cut_from_sheets_where_the_workshop_names_some(vault_script, tmp_path):
    stock = tmp_path / "stock.toml"
    stock.write_text(
        "[[sheets]]\nname = 'panel 27'\nlength = 2500\nwidth = 1250\nthickness = 27\n"
        "material = 'spruce'\n"
    )
    shop = Workshop(stock=str(stock), use=("panel 27",))
    folder = fabricate(vault_script, out=tmp_path, workshop=shop).folder
    programs = sorted((folder / "programs").glob("*.ngc"))
    found = verify_programs(programs, simulate=False)
    assert all(one.ok for one in found), "\n".join(map(str, found))
    assert sum(one.sides for one in found) == 4 * (4 + 5 + 4)
    assert (folder / "sheets" / "sheet-01.step").is_file()
    assert not (folder / "boards").exists()


def test_side_that_the_head_cannot_reach_is_an_error_with_its_angle(shell_script, tmp_path):
    tools = tmp_path / "tools.toml"
    tools.write_text("[machine]\ntilt = [-5, 5]\n")
    with pytest.raises(MachineError, match=r"inclined by .* tilts by 5 at most"):
        fabricate(shell_script, out=tmp_path, workshop=Workshop(tools=str(tools)))
    assert not (tmp_path / "dome").exists()


def test_run_that_dies_leaves_the_former_folder_whole(shell_script, tmp_path, own_worker):
    folder = fabricate(shell_script, out=tmp_path).folder
    with pytest.raises(WorkerError, match=r"Nothing in .* was changed"):
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
    [
        {"cutter": 0},
        {"hold": "glue"},
        {"margin": -1},
        {"kerf": np.nan},
        {"method": "slow"},
        {"visible": "top"},
    ],
)
def test_workshop_refuses_what_cannot_be_meant(wrong):
    with pytest.raises(InputError):
        Workshop(**wrong)
