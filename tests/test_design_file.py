"""Saved designs: what is read is what was written, and every mistake is a sentence."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import cadquery as cq
import numpy as np
import pytest
from cadquery import cqgi
from hypothesis import given, settings
from hypothesis import strategies as st

from ifs_cad.design.fold import EvenFold
from ifs_cad.design_file import (
    format_design,
    parse_design,
    presets,
    read_design,
    with_settings,
    write_design,
)
from ifs_cad.design_record import MATERIALS, Design, DrawnCurve, SubdivisionPoint
from ifs_cad.design_script import to_script
from ifs_cad.elements.fibre import FibreAlongCurve, FibreAlongEdge, FibreTowards
from ifs_cad.elements.hole import Holes
from ifs_cad.elements.label import Label
from ifs_cad.errors import ExportError, InputError, OutOfReachError, WeightError
from ifs_cad.kernel.source import run_script

ARCH = DrawnCurve([(0, 0, 0), (1000, 0, 1600), (2000, 0, 0)], depth=2)
FOLD = DrawnCurve([(0, 0, 0), (0, 700, 300), (0, 1500, 0)], depth=2)
PLAIN = Design(ARCH, FOLD, 12.0)
TEXT = format_design(replace(PLAIN, label=Label(), floor=-200.0))

lengths = st.floats(-1e6, 1e6)
points = st.tuples(lengths, lengths, lengths)
weights = st.floats(1e-3, 1e3)
sizes = st.floats(0.01, 1e3)


@st.composite
def drawn_curves(draw):
    count = draw(st.integers(2, 5))
    plain = DrawnCurve(
        draw(st.lists(points, min_size=count, max_size=count)),
        weights=tuple(draw(st.lists(weights, min_size=count, max_size=count))),
        depth=draw(st.integers(0, 1000)),
        transformations=draw(st.integers(2, 4)),
        closed=draw(st.booleans()),
        symmetric=draw(st.booleans()),
        roughness=draw(st.floats(-1 / 3, 1.0)) if count > 2 else 0.0,
        fold=draw(st.none() | st.floats(0.01, 3.0) | st.floats(-3.0, -0.01)),
    )
    scheme = plain.plain_scheme.with_symmetry()
    firsts = [n for n in scheme.free_names if scheme.index(n) <= scheme.index(scheme.partner(n))]
    names = draw(st.lists(st.sampled_from(firsts), unique=True))
    return replace(
        plain, moved=tuple(SubdivisionPoint(name, draw(points), draw(weights)) for name in names)
    )


rules = st.one_of(
    st.none(),
    st.builds(FibreAlongCurve, curve=st.sampled_from(["long", "a", "b"]), half_turn=st.booleans()),
    st.builds(FibreAlongEdge, edge=st.just("longest") | st.integers(0, 9)),
    st.builds(FibreTowards, direction=points.filter(any), tolerance=st.floats(0.0, 90.0)),
)
labels = st.builds(
    Label,
    face=st.sampled_from(["inner", "outer"]),
    style=st.sampled_from(["engraved", "wire"]),
    depth=sizes,
    cutter=st.floats(0.1, 4.0),
    margin=st.floats(0.0, 50.0),
    up=points.filter(any),
)
designs = st.builds(
    Design,
    drawn_curves(),
    drawn_curves(),
    sizes,
    side=st.sampled_from(["outer", "inner", "centre"]),
    nodes=st.sampled_from(["relief", "axis", "plain"]),
    clearance=st.floats(0.0, 10.0),
    floor=st.none() | lengths,
    material=st.sampled_from(sorted(MATERIALS)),
    fibre=rules,
    label=st.none() | labels,
    holes=st.none() | st.builds(Holes, diameter=st.floats(0.1, 9.0), inset=st.floats(5.0, 99.0)),
    nest=st.integers(0, 9),
    title=st.text(st.characters(categories=["L", "N", "P", "S"]), max_size=20),
)


@given(designs)
@settings(max_examples=60, deadline=None)
def test_what_is_read_is_what_was_written(design):
    assert parse_design(format_design(design), "x.toml") == design


def test_file_survives_a_second_writing_unchanged(tmp_path):
    path = write_design(PLAIN, tmp_path / "new" / "design.toml")
    first = path.read_bytes()
    write_design(read_design(path), path)
    assert path.read_bytes() == first
    assert [entry.name for entry in path.parent.iterdir()] == ["design.toml"]


def test_file_explains_its_units():
    assert "# Lengths in mm, angles in degrees; weights have no unit." in TEXT
    assert "thickness = 12.0 # of the sheet, mm" in TEXT


def test_failed_writing_leaves_the_old_file(tmp_path):
    (tmp_path / "file").write_text("old")
    with pytest.raises(ExportError):
        write_design(PLAIN, tmp_path / "file" / "design.toml")
    assert (tmp_path / "file").read_text() == "old"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("version = 1", "version = 2", r"x\.toml, line 4: made by a newer ifs-cad.*Upd"),
        ("version = 1", "", r"x\.toml: the version is missing\. Add version = 1"),
        ("version = 1", "version = 0", r"line 4: version must be a whole number"),
        ("thickness = 12.0", "thicknes = 12.0", r"line 6: unknown key .thicknes.\. Known are "),
        ("thickness = 12.0", "", r"x\.toml: thickness missing\. Add thickness"),
        ("thickness = 12.0", 'thickness = "12"', r"line 6: thickness must be a number, got .12."),
        ("thickness = 12.0", "thickness = nan", r"line 6: thickness must be a finite number"),
        ("thickness = 12.0", "thickness = -1", r"x\.toml, line 6: Thickness must be positive"),
        ("thickness = 12.0", "thickness = 12 mm", r"x\.toml is not TOML: .*line 6"),
        ('side = "outer"', 'side = "out"', r"line 7: side must be .outer., .inner. or .centre."),
        ("nest = 0", "nest = 0.5", r"line 12: nest must be a whole number"),
        ("closed = false", "closed = 0", r"line 23: \[a\]: closed must be true or false"),
        ("depth = 2", "depth = -2", r"line 21: \[a\]: The iteration depth must be a whole"),
        ("roughness = 0.0", "roughness = 2", r"line 25: \[a\]: Roughness must be between -1/3"),
        ("[0.0, 0.0, 0.0]", "[0.0, 0.0]", r"line 16: \[a\]: control_points entry 1 must be three"),
        ("weights = [1.0,", "weights = [0.0,", r"line 20: \[a\]: Weights must be positive"),
        ("[b]", "[b.moved]\ns99 = {point = [0, 0, 0]}\n[b]", r"line 27: \[b\]: .* point 's99'"),
        ("[b]", "[b.moved]\ns1 = {point = [0, 0, 0]}\n[b]", r"Subdivision point 's1' is fixed"),
        ("[b]", "[b.moved]\ns2 = {weight = 1}\n[b]", r"line 28: \[b\.moved\.s2\]: point missing"),
        ('face = "inner"', 'face = "in"', r"line 41: \[label\]: face must be .inner. or .outer."),
        ("cutter = 3.0", "cutter = 0", r"line 44: \[label\]: Label cutter must be positive"),
        ("[label]", '[fibre]\ntolerance = 1\n[label]', r"line 40: \[fibre\]: give one of curve"),
        ("[b]", "[c]", r"x\.toml, line 27: unknown key .c.\. Known are "),
        ("[b]", "[a.moved]", r"x\.toml, line 28: \[a\.moved\.control_points\]: must be a table"),
        ("[b]", "[fibre]", r"x\.toml, line 28: \[fibre\]: unknown key .control_points."),
        ("[label]", "[fibre]\nedge = 0.5\n[label]", r"line 41: \[fibre\]: edge must be .long"),
        ('material = "spruce plywood"', 'material = "oak"', r"line 11: material must be"),
    ],
)  # fmt: skip
def test_mistake_in_a_file_is_named_with_its_place(old, new, said):
    assert old in TEXT
    with pytest.raises(InputError, match=said):
        parse_design(TEXT.replace(old, new, 1), "x.toml")


def test_file_that_cannot_be_read_is_named(tmp_path):
    with pytest.raises(InputError, match=r"gone\.toml cannot be read: No such file"):
        read_design(tmp_path / "gone.toml")
    (tmp_path / "latin.toml").write_bytes(b'title = "\xe9"')
    with pytest.raises(InputError, match=r"latin\.toml is not UTF-8"):
        read_design(tmp_path / "latin.toml")


def test_curve_is_that_of_the_same_calls():
    moved = SubdivisionPoint("s2", (300.0, 0.0, 700.0), 1.5)
    drawn = replace(ARCH, roughness=0.25, moved=(moved,), weights=(1, 2, 1), fold=None)
    by_hand = (
        replace(ARCH.base(), weights=[1, 2, 1])
        .with_roughness(0.25)
        .with_subdivision_point("s2", (300, 0, 700), 1.5)
    )
    assert np.array_equal(drawn.curve().points, by_hand.points)
    assert replace(ARCH, fold=5.0).curve().fold == EvenFold(5.0)


def test_subdivision_point_off_the_plane_is_out_of_reach():
    drawn = replace(ARCH, moved=(SubdivisionPoint("s2", (300, 5, 700)),))
    with pytest.raises(OutOfReachError, match="5 mm off the plane"):
        drawn.curve()


def test_subdivision_point_and_its_image_cannot_both_be_placed():
    both = (SubdivisionPoint("s2", (300, 0, 700)), SubdivisionPoint("s5", (1700, 0, 700)))
    assert replace(ARCH, moved=both).curve().depth == 2
    with pytest.raises(InputError, match="or its mirror image, which is placed already"):
        replace(ARCH, symmetric=True, moved=both)


@pytest.mark.parametrize(
    ("values", "error"),
    [
        ({"thickness": 0.0}, InputError),
        ({"floor": float("inf")}, InputError),
        ({"material": "oak"}, InputError),
        ({"nest": -1}, InputError),
        ({"title": "two\nlines"}, InputError),
        ({"side": "up"}, InputError),
    ],
)
def test_design_refuses_what_cannot_be_meant(values, error):
    with pytest.raises(error):
        replace(PLAIN, **values)


def test_curve_refuses_weights_that_are_not_positive():
    with pytest.raises(WeightError):
        replace(ARCH, weights=(1.0, 0.0, 1.0))


@pytest.mark.parametrize("name", sorted(presets()))
def test_preset_can_be_built(name):
    shell = presets()[name].shell()
    assert len(shell) == len(shell.mesh)
    assert shell.report().warnings == ()


def test_presets_are_the_figures_of_the_paper():
    assert [name[:9] for name in presets()] == [
        f"figure_{number:02}" for number in (8, 9, 10, 11, 12, 13, 17, 18, 21)
    ]


@pytest.mark.parametrize("name", ["figure_18_thickened_surface", "figure_21_prototype"])
def test_preset_is_the_part_of_the_same_figure(name):
    parts = {"figure_21_prototype": "shell_prototype"}
    path = Path(__file__).parent.parent / "parts" / f"{parts.get(name, name)}.py"
    (result,) = cqgi.parse(path.read_text(encoding="utf-8")).build().results
    made = result.shape.metadata["elements"]
    assert np.abs(made.solids.vertices - presets()[name].shell().solids.vertices).max() < 1e-9


CURVED = replace(
    PLAIN,
    a=replace(
        ARCH,
        control_points=((0, 0, 0), (500, 0, 1600), (1500, 0, 1600), (2000, 0, 0)),
        weights=(1.0, 1.1, 1.0, 1.2),
        transformations=3,
        depth=1,
        symmetric=True,
        roughness=0.1,
        moved=(SubdivisionPoint("s3", (300.0, 0.0, 900.0), 1.05),),
    ),
    b=replace(FOLD, depth=1, fold=-0.9),
    side="centre",
    nodes="axis",
    clearance=0.1,
    material="spruce",
    fibre=FibreTowards((1.0, 0.5, 0.0), tolerance=5.0),
    label=Label("outer", "wire", up=(0.0, 1.0, 0.0)),
    holes=Holes(6.0, 40.0, 0),
    title='A "shell" \\ of two curves',
)


@pytest.mark.parametrize("design", [PLAIN, CURVED, *presets().values()], ids=lambda d: d.title)
def test_script_makes_the_same_shell(design):
    script = to_script(design)
    assert max(map(len, script.splitlines())) <= 100
    result = cqgi.parse(script).build()
    assert result.success, result.exception
    assembly = result.results[0].shape
    shell = assembly.metadata["elements"]
    expected = design.shell()
    assert shell.addresses == expected.addresses
    assert np.abs(shell.solids.vertices - expected.solids.vertices).max() <= 1e-9
    assert shell.fibre == design.fibre
    assert shell.thickening == expected.thickening
    assert assembly.metadata["label"] == design.label
    assert assembly.metadata["holes"] == design.holes


def test_script_takes_parameters():
    parameters = {"thickness": 9.0, "a_depth": 3, "floor": 210.0}
    model = cqgi.parse(to_script(replace(PLAIN, floor=200.0)))
    assert {"side", "nodes", "clearance", "b_depth", "nest"} | parameters.keys() <= set(
        model.metadata.parameters
    )
    shell = run_with(model, parameters)
    assert (len(shell), shell.thickness, shell.thickening.floor.origin[2]) == (32, 9.0, 210.0)


def run_with(model, parameters):
    result = model.build(build_parameters=parameters)
    assert result.success, result.exception
    return result.results[0].shape.metadata["elements"]


def test_settings_change_values_by_the_keys_of_the_file():
    design = replace(PLAIN, floor=0.0, holes=Holes())
    changed = with_settings(
        design,
        {"thickness": "15", "side": "inner", "a.depth": "3", "floor": "none", "holes": "none",
         "label.depth": "0.4", "fibre.curve": "b", "b.weights": "[1, 2, 1]", "title": "My shell"},
        "x",
    )  # fmt: skip
    expected = replace(
        PLAIN,
        thickness=15.0,
        side="inner",
        a=replace(ARCH, depth=3),
        b=replace(FOLD, weights=(1, 2, 1)),
        label=Label(depth=0.4),
        fibre=FibreAlongCurve("b"),
        title="My shell",
    )
    assert changed == expected


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("width", "3", r"x\.toml has no value 'width'\. Its values are: title, thickness, "),
        ("depth", "3", r"no value 'depth'\. Say which: a\.depth, b\.depth, label\.depth\."),
        ("thickness", "thick", r"x\.toml: thickness must be a number, got 'thick'"),
        ("a.depth", "2.5", r"x\.toml: \[a\]: depth must be a whole number, got 2\.5"),
        ("thickness", "none", r"x\.toml: thickness missing"),
    ],
)
def test_wrong_setting_is_named_with_what_there_is(key, value, said):
    with pytest.raises(InputError, match=said):
        with_settings(PLAIN, {key: value}, "x.toml")


def test_design_file_is_run_like_a_script(tmp_path):
    design = replace(PLAIN, label=Label(), holes=Holes(), nest=1)
    path = write_design(design, tmp_path / "design.toml")
    (shown,) = run_script(path, {"thickness": "9", "a.depth": "1"})
    shell = shown.assembly.metadata["elements"]
    assert (shell.thickness, len(shell)) == (9.0, 8)
    assert shown.assembly.metadata["label"] == Label()
    assert shown.assembly.metadata["holes"] == Holes()
    assert shown.has_solids


def test_command_line_builds_a_design_file(tmp_path):
    path = write_design(replace(PLAIN, label=Label()), tmp_path / "vault.toml")
    options = [str(path), "--set", "thickness=9", "--set", "a.depth=1", "--out", str(tmp_path)]
    result = subprocess.run(
        [sys.executable, "-m", "ifs_cad.cli", "build", "--quiet", *options],
        capture_output=True,
        text=True,
    )
    assert (result.returncode, result.stderr) == (0, "")
    assembly = cq.Assembly.importStep(str(tmp_path / "vault" / "vault.step"))
    assert sum(bool(shape.Solids()) for shape, *_ in assembly) == 8
