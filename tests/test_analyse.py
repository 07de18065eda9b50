"""`ifs-cad analyse`: its command line, its files, read back by what did not write them."""

from __future__ import annotations

import base64
import csv
import ctypes.util
import re
import sys
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from structures import TIMBER, shell_of
from typer.testing import CliRunner

import ifs_cad as ifs
from ifs_cad.cli import app
from ifs_cad.errors import InputError
from ifs_cad.export.chart import comparison, export_chart
from ifs_cad.export.vtu import export_vtu
from ifs_cad.structure.analyse import analyse
from ifs_cad.structure.load import AreaLoad
from ifs_cad.structure.section import RESULTANTS
from ifs_cad.structure.support import Support
from ifs_cad.workflow.analysis import read_supports_text

TYPES = {"Float64": np.float64, "Int64": np.int64, "Int32": np.int32, "UInt8": np.uint8}

NO_EGL = sys.platform == "linux" and not ctypes.util.find_library("EGL")
draws = pytest.mark.skipif(NO_EGL, reason="no EGL: install libegl1 libegl-mesa0 libgl1-mesa-dri")

SCRIPT = """
import cadquery as cq
import ifs_cad as ifs
from ifs_cad.elements.material import Stiffness
fold = 80.0
timber = ifs.Material("timber", 450.0, (1, 1, 0), Stiffness.isotropic(9000.0, 0.3))
whole = cq.Assembly(name="both")
for name, rise in (("low", 40.0), ("rough", fold)):
    a = ifs.Curve([(0, 0, 0), (1500, 0, 1200), (3000, 0, 0)], depth=2)
    across = [(0, 0, 0), (0, 300, rise), (0, 600, 0)]
    shell = ifs.thicken(ifs.vector_sum(a, across), 12.0, material=timber)
    whole.add(ifs.to_assembly(shell, name=name), name=name)
show_object(whole, name="both")
"""


@pytest.fixture(scope="module")
def result():
    curve = ifs.Curve([(0, 0, 0), (1500, 0, 1200), (3000, 0, 0)], depth=2)
    return analyse(
        shell_of(curve.points, [(0, 0, 0), (0, 300, 80), (0, 600, 0)], 12.0),
        loads=AreaLoad(pressure=1500),
        supports=Support.border("a start", "a end"),
        stiffness=TIMBER,
    )


def command(*arguments):
    return CliRunner().invoke(app, ["analyse", *(str(argument) for argument in arguments)])


def vtu_arrays(path):
    """Every array of a VTU file by name, read as XML by its published layout."""
    root = ET.parse(path).getroot()
    assert root.get("header_type", "UInt32") == "UInt32"
    found = {}
    for array in root.iter():
        if array.tag not in {"DataArray", "Array"}:
            continue
        data = base64.b64decode("".join((array.text or "").split()))
        size = int(np.frombuffer(data[:4], np.uint32)[0])
        body = data[4 : 4 + size]
        if array.get("type") == "String":
            found[array.get("Name")] = body.decode().split("\0")[:-1]
        else:
            values = np.frombuffer(body, TYPES[array.get("type")])
            width = int(array.get("NumberOfComponents", 1))
            found[array.get("Name")] = values.reshape(-1, width) if width > 1 else values
    return found


def test_vtu_holds_the_mesh_and_all_results(result, tmp_path):
    grid = result.model.grid
    read = vtu_arrays(export_vtu(result, tmp_path / "new" / "result.vtu"))
    np.testing.assert_array_equal(read["Points"], grid.nodes)
    np.testing.assert_array_equal(read["connectivity"].reshape(-1, 4), grid.quads)
    np.testing.assert_array_equal(read["offsets"], 4 * np.arange(1, len(grid.quads) + 1))
    assert set(read["types"].tolist()) == {9}  # VTK_QUAD
    np.testing.assert_array_equal(read["displacement"], result.displacements)
    np.testing.assert_array_equal(read["rotation"], result.rotations)
    np.testing.assert_array_equal(read["load"], result.forces)
    for number, name in enumerate(RESULTANTS):
        np.testing.assert_array_equal(read[name], result.resultants[:, number])
    np.testing.assert_array_equal(read["utilisation"], result.quad_utilisation)
    np.testing.assert_array_equal(read["panel"], grid.face_of_quad)
    assert read["address"] == [grid.mesh.addresses[face] for face in grid.face_of_quad]


def test_chart_has_a_bar_in_proportion_for_each_shell(result, tmp_path):
    softer = analyse(
        result.model.shell,
        loads=AreaLoad(pressure=3000),
        supports=Support.border("a start", "a end"),
        stiffness=TIMBER,
    )
    both = {"stiff": result, "soft <2>": softer}
    root = ET.parse(export_chart(both, tmp_path / "bars.svg")).getroot()
    space = "{http://www.w3.org/2000/svg}"
    bars = [float(bar.get("width")) for bar in root.iter(f"{space}rect")][1:]
    assert bars[0] / bars[1] == pytest.approx(0.5, rel=1e-3)
    words = [text.text for text in root.iter(f"{space}text")]
    assert {"stiff", "soft <2>"} <= set(words)
    assert comparison(both).rows[1][-1] == pytest.approx(2.0, rel=1e-9)


def test_nothing_to_compare_is_an_error(tmp_path):
    with pytest.raises(InputError, match="nothing to compare"):
        comparison({})
    with pytest.raises(InputError, match="nothing to plot"):
        export_chart({}, tmp_path / "bars.svg")


def test_supports_are_read_from_words():
    names = [one.name for one in read_supports_text("standing, a start,0, borders")]
    assert names == ["standing", "border a start", "border 0", "all borders"]
    with pytest.raises(InputError, match="Unknown support 'floor'"):
        read_supports_text("floor")


@draws
def test_command_writes_tables_pictures_meshes_and_decks(tmp_path):
    script = tmp_path / "both.py"
    script.write_text(SCRIPT)
    folder = tmp_path / "out" / "both" / "analysis"
    folder.mkdir(parents=True)
    (folder / "old_result.vtu").write_text("former")
    (folder / "notes.md").write_text("mine")
    options = ("--half", "--supports", "a start, a end", "--modes", "2", "-o", tmp_path / "out")
    done = command(script, *options)
    assert done.exit_code == 0, done.stderr
    kinds = ("deck.inp", "deformed.png", "result.vtu")
    made = {f"{name}_{kind}" for name in ("low", "rough") for kind in kinds}
    made |= {"comparison.csv", "comparison.svg", "report.txt"}
    assert {path.name for path in folder.iterdir()} == made | {"notes.md"}
    sags = [float(text) for text in re.findall(r"deflection u_z +([\d.]+) mm", done.stdout)]
    with (folder / "comparison.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["shell"] for row in rows] == ["low", "rough"]
    assert [float(row["deflection u_z mm"]) for row in rows] == pytest.approx(sags, abs=0.005)
    assert [float(row["load kN"]) for row in rows] == pytest.approx([1.35, 1.35])  # half of it
    assert done.stdout.count("mode 2") == 2
    image = pytest.importorskip("PIL.Image").open(folder / "low_deformed.png").convert("RGB")
    colours = {colour for _, colour in image.getcolors(image.width * image.height)}
    legend = {(68, 1, 84), (253, 231, 37)}  # both ends of the scale are drawn, unlit
    assert legend <= colours


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--joints", "glue"], "not 'glue'"),
        (["--set", "fold=0"], "without resistance"),
        (["--load", "0"], "Nothing is loaded"),
        (["--supports", "walls"], "Unknown support 'walls'"),
    ],
)
def test_wrong_questions_are_answered_by_a_sentence(options, said, tmp_path):
    script = tmp_path / "both.py"
    script.write_text(SCRIPT)
    if "--supports" not in options:
        options = [*options, "--supports", "a start, a end"]
    done = command(script, *options, "-o", tmp_path / "out", "-q")
    assert done.exit_code == 1
    assert re.search(said, done.stderr)
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out" / "both").exists()


def test_script_without_shells_is_refused(tmp_path):
    script = tmp_path / "box.py"
    script.write_text("import cadquery as cq\nshow_object(cq.Workplane().box(1, 1, 1))\n")
    done = command(script, "-o", tmp_path / "out", "-q")
    assert done.exit_code == 1
    assert "Only shells of panels are analysed" in done.stderr
