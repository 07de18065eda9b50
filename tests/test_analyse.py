"""`ifs-cad analyse`: its command line, its files, read back by what did not write them."""

from __future__ import annotations

import base64
import csv
import ctypes.util
import re
import sys
import xml.etree.ElementTree as ET

import cadquery as cq
import numpy as np
import pytest
from structures import TIMBER, mesh_shell, shell_of
from typer.testing import CliRunner

import ifs_cad as ifs
from ifs_cad.cli import app
from ifs_cad.errors import InputError, ScriptError
from ifs_cad.export.chart import comparison, export_chart
from ifs_cad.export.vtu import export_vtu
from ifs_cad.structure.analyse import analyse
from ifs_cad.structure.analysis import Analysis
from ifs_cad.structure.load import AreaLoad, SelfWeight, total_forces
from ifs_cad.structure.model import model_of
from ifs_cad.structure.section import RESULTANTS
from ifs_cad.structure.support import Support
from ifs_cad.view.deformed import deformed_assembly
from ifs_cad.workflow.analysis import asked
from ifs_cad.workflow.question import Question, answer_to, read_supports_text

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
    names = [one.name for one in read_supports_text(["standing, a start", "0, borders"])]
    assert names == ["standing", "border a start", "border 0", "all borders"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({"supports": ["floor"]}, "Unknown support 'floor'"),
        ({"joints": "glue"}, "not 'glue'"),
        ({"fibre": "c"}, '"long", "a" or "b"'),
        ({"load": -1.0}, "0 or more"),
        ({"surface_load": np.inf}, "0 or more"),
        ({"half": True, "part": ["0*"]}, "not both"),
    ],
)
def test_question_that_cannot_be_meant_is_refused_before_anything_runs(words, said):
    with pytest.raises(InputError, match=said):
        Question(**words)


SHELL = shell_of([(0, 0, 0), (300, 0, 0), (600, 0, 0)], [(0, 0, 0), (0, 200, 0)], 12.0)
OWN = Analysis([AreaLoad(pressure=700)], Support.border("a start"), "rigid")


@pytest.mark.parametrize(
    ("words", "force"),
    [
        ({}, 700 * 0.12),
        ({"weight": True}, 700 * 0.12 + 0.12 * 0.012 * 450 * 9.81),
        ({"load": 1000.0}, 1000 * 0.12),
        ({"load": 1000.0, "surface_load": 200.0}, 1200 * 0.12),
        ({"half": True}, 1500 * 0.06),
        ({"part": [SHELL.addresses[0]], "load": 900.0}, 900 * 0.06),
        ({"points": [(SHELL.addresses[1], 50.0), (SHELL.addresses[0], 7.0)]}, 57.0),
        ({"points": [(SHELL.addresses[1], 50.0)], "load": 100.0}, 50 + 100 * 0.12),
    ],
)
def test_question_replaces_loads_and_adds_weight(words, force):
    """Newtons downwards on 600 x 200 mm of plan, 12 mm thick, 450 kg/m3."""
    asked_for = answer_to(SHELL, OWN, Question(**words))
    model = model_of(SHELL, supports=asked_for.supports, divisions=2, stiffness=TIMBER)
    total = total_forces(asked_for.loads, model.grid, model.surface_weight).sum(axis=0)
    np.testing.assert_allclose(total, (0, 0, -force), rtol=1e-9, atol=1e-9)
    assert asked_for.joints == "rigid"
    assert [one.name for one in asked_for.supports] == ["border a start"]


def test_question_replaces_supports_and_joints():
    asked_for = answer_to(SHELL, OWN, Question(supports=("b end", "0"), joints="250"))
    assert [one.name for one in asked_for.supports] == ["border b end", "border 0"]
    assert asked_for.joints == 250.0
    with pytest.raises(InputError, match="Nothing is loaded"):
        answer_to(SHELL, OWN, Question(load=0.0))


def test_part_tells_its_own_analysis_and_the_nearest_counts():
    other = Analysis(SelfWeight())
    inner = cq.Assembly(name="inner", metadata={"elements": SHELL, "analysis": other})
    whole = cq.Assembly(name="whole", metadata={"analysis": OWN})
    whole.add(inner, name="inner")
    whole.add(cq.Assembly(name="outer", metadata={"elements": SHELL}), name="outer")
    found = asked([whole])
    assert found["inner"] == (SHELL, other)
    assert found["outer"] == (SHELL, OWN)
    whole.metadata["analysis"] = "snow"
    with pytest.raises(ScriptError, match="must hold an Analysis"):
        asked([whole])
    with pytest.raises(InputError, match="needs loads"):
        Analysis([])


@draws
def test_command_writes_tables_pictures_meshes_and_decks(tmp_path):
    script = tmp_path / "both.py"
    script.write_text(SCRIPT)
    folder = tmp_path / "out" / "both" / "analysis"
    folder.mkdir(parents=True)
    (folder / "old_result.vtu").write_text("former")
    (folder / "notes.md").write_text("mine")
    held = ("--supports", "a start", "--supports", "a end", "--divisions", "2")
    options = ("--half", *held, "--modes", "2", "-o", tmp_path / "out")
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
    ("options", "code", "said"),
    [
        (["--joints", "glue"], 1, "not 'glue'"),
        (["--supports", "a start", "--supports", "walls"], 1, "Unknown support 'walls'"),
        (["--point", "0211"], 2, "as 0211=500"),
        (["--set", "fold=0", "--supports", "a start, a end"], 1, "without resistance"),
    ],
)
def test_wrong_questions_are_answered_by_a_sentence(options, code, said, tmp_path):
    script = tmp_path / "both.py"
    script.write_text(SCRIPT)
    done = command(script, *options, "-o", tmp_path / "out", "-q")
    assert done.exit_code == code
    assert re.search(said, done.stderr)
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out" / "both").exists()


PLYWOOD = """
import ifs_cad as ifs
arch = ifs.Curve([(0, 0, 0), (1500, 0, 1200), (3000, 0, 0)], depth=2)
shell = ifs.thicken(ifs.vector_sum(arch, [(0, 0, 0), (0, 300, 80), (0, 600, 0)]), 12.0)
show_object(ifs.to_assembly(shell), name="plywood")
"""


@draws
def test_command_gives_plywood_the_fibre_that_it_lacks(tmp_path):
    script = tmp_path / "plywood.py"
    script.write_text(PLYWOOD)
    options = (script, "--supports", "a start, a end", "--divisions", "2", "-o", tmp_path)
    refused = command(*options)
    assert refused.exit_code == 1
    assert "ifs-cad analyse: --fibre a" in refused.stderr
    sags = []
    for curve in "ab":
        done = command(*options, "--fibre", curve)
        assert done.exit_code == 0, done.stderr
        sags += re.findall(r"deflection u_z +([\d.]+) mm", done.stdout)
    along, across = sags
    assert along != across


def test_script_without_shells_is_refused(tmp_path):
    script = tmp_path / "box.py"
    script.write_text("import cadquery as cq\nshow_object(cq.Workplane().box(1, 1, 1))\n")
    done = command(script, "-o", tmp_path / "out", "-q")
    assert done.exit_code == 1
    assert "Only shells of panels are analysed" in done.stderr


@pytest.mark.parametrize("by", ["deflection", "utilisation"])
def test_deformed_shell_for_the_viewer_goes_through_the_moved_nodes(result, by):
    assembly = deformed_assembly(result, by=by, scale=10.0)
    model, points = result.model, result.deformed(10.0)
    values = {"deflection": result.deflections, "utilisation": result.utilisation}[by]
    assert [child.name for child in assembly.children] == list(model.shell.addresses)
    for panel, child in enumerate(assembly.children):
        assert child.metadata[by] == values[panel]
        assert child.obj.isValid()
        own = np.flatnonzero(model.grid.face_of_node == panel)
        away = [child.obj.distance(cq.Vertex.makeVertex(*at)) for at in points[own[::3]].tolist()]
        assert max(away) <= 1e-6
    colours = [child.color.toTuple()[:3] for child in assembly.children]
    np.testing.assert_allclose(
        colours[int(values.argmax())], (253 / 255, 231 / 255, 37 / 255), 1e-2
    )
    assert f"up to {values.max():.4g}" in assembly.name


def test_panels_of_other_shapes_are_deformed_too():
    """A hexagon has a curved face for each of its corners."""
    angle = np.radians(60 * np.arange(6))
    ring = np.column_stack([400 * np.cos(angle), 400 * np.sin(angle), 0 * angle])
    plate = mesh_shell(ring.tolist(), [tuple(range(6))], 10.0)
    sag = analyse(
        plate, loads=SelfWeight(), supports=Support.border(), divisions=4, stiffness=TIMBER
    )
    (child,) = deformed_assembly(sag, scale=1.0).children
    assert len(child.obj.Faces()) == 6
    assert child.obj.Area() == pytest.approx(3 * np.sqrt(3) / 2 * 400**2, rel=1e-4)
    with pytest.raises(InputError, match='"deflection" or "utilisation"'):
        deformed_assembly(sag, by="colour")
    felt = ifs.Material("felt", 100.0, (1, 1, 1), stiffness=TIMBER)
    bare = ifs.thicken(plate.mesh, 10.0, material=felt)
    sag = analyse(bare, loads=SelfWeight(), supports=Support.border(), divisions=2)
    with pytest.raises(InputError, match="strength of felt is not known"):
        deformed_assembly(sag, by="utilisation")
