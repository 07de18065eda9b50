"""The methods of cadquery.Workplane: panels and surfaces at every point of the stack."""

import subprocess
import sys

import cadquery as cq
import numpy as np
import pytest
from brep import assert_solid, points, volume
from vaults import roof, vault

import ifs_cad as ifs
from ifs_cad.elements.hole import Holes
from ifs_cad.errors import LabelError
from ifs_cad.kernel import plugin
from ifs_cad.kernel.panels import make_panels, to_solid

PLANES = [
    cq.Plane.XY(),
    cq.Plane((100, -50, 700)),
    cq.Plane((100, -50, 700), xDir=(0, 1, 0), normal=(1, 0, 0)),
    cq.Plane.XY().rotated((20, -30, 70)),
]


def in_world(plane, local):
    """Return local points of a plane in the world, from its axes."""
    axes = np.array([d.toTuple() for d in (plane.xDir, plane.yDir, plane.zDir)])
    return np.asarray(local) @ axes + plane.origin.toTuple()


def test_methods_are_those_of_the_plugin():
    assert cq.Workplane.ifsPanels is plugin.ifs_panels
    assert cq.Workplane.ifsSurface is plugin.ifs_surface


@pytest.mark.parametrize("imports", ["import ifs_cad, cadquery", "import cadquery, ifs_cad"])
def test_import_of_both_is_enough_in_any_order(imports):
    program = f"""
{imports}
import ifs_cad as ifs, cadquery as cq
shell = ifs.thicken(ifs.Mesh([(0, 0, 0), (9, 0, 0), (9, 9, 0), (0, 9, 0)], [(0, 1, 2, 3)]), 2)
print(cq.Workplane().ifsPanels(shell["f0000"]).val().Volume())
"""
    answer = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert answer.stderr == ""
    assert float(answer.stdout) == pytest.approx(162.0)


@pytest.mark.parametrize("plane", PLANES)
def test_panel_stands_where_it_would_in_the_shell(plane):
    panel = vault()["12"]
    solid = cq.Workplane(plane).ifsPanels(panel).val()
    assert_solid(solid.wrapped, panel.volume)
    expected = in_world(plane, points(to_solid(panel).wrapped))
    np.testing.assert_allclose(points(solid.wrapped), expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("plane", PLANES)
def test_every_point_of_the_stack_takes_a_panel(plane):
    panel = vault()["03"]
    spots = [(0, 0), (900, 0), (0, 2000), (-50, 70)]
    placed = cq.Workplane(plane).pushPoints(spots).ifsPanels(panel)
    alone = points(to_solid(panel).wrapped)
    assert placed.size() == len(spots)
    for (x, y), solid in zip(spots, placed.vals(), strict=True):
        expected = in_world(plane, np.add(alone, (x, y, 0)))
        np.testing.assert_allclose(points(solid.wrapped), expected, rtol=0, atol=1e-9)
        assert volume(solid.wrapped) == pytest.approx(panel.volume, rel=1e-9)


def test_polar_array_turns_the_panels():
    panel = roof(400, 300, 30)["1"]
    placed = cq.Workplane().polarArray(1000, 0, 360, 4).ifsPanels(panel)
    alone = points(to_solid(panel).wrapped)
    for k, solid in enumerate(placed.vals()):
        cosine, sine = np.cos(k * np.pi / 2), np.sin(k * np.pi / 2)
        turn = np.array([(cosine, sine, 0), (-sine, cosine, 0), (0, 0, 1)])
        expected = np.add(alone, (1000, 0, 0)) @ turn
        np.testing.assert_allclose(points(solid.wrapped), expected, rtol=0, atol=1e-9)


def test_faces_of_other_solids_take_panels():
    panel = vault()["12"]
    table = cq.Workplane().box(100, 100, 50).faces(">X").workplane()
    placed = table.ifsPanels(panel).val()
    expected = in_world(table.plane, points(to_solid(panel).wrapped))
    np.testing.assert_allclose(points(placed.wrapped), expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("plane", PLANES)
def test_whole_shell_stands_together(plane):
    shell = vault()
    placed = cq.Workplane(plane).ifsPanels(shell).val()
    assert isinstance(placed, cq.Compound)
    assert len(placed.Solids()) == len(shell)
    for panel, solid in zip(shell, placed.Solids(), strict=True):
        expected = in_world(plane, points(to_solid(panel).wrapped))
        np.testing.assert_allclose(points(solid.wrapped), expected, rtol=0, atol=1e-9)


def test_part_of_a_shell_of_one_panel_is_a_solid():
    shell = vault()
    placed = cq.Workplane().ifsPanels(shell.part("12")).val()
    assert isinstance(placed, cq.Solid)
    np.testing.assert_allclose(points(placed.wrapped), points(to_solid(shell["12"]).wrapped))


def test_label_and_holes_are_made_as_everywhere():
    shell = vault()
    holes, label = Holes(6.0, 20.0), ifs.Label(depth=1.0)
    volumes = [made.volume for made in make_panels(shell, label=label, holes=holes)]
    one = cq.Workplane().ifsPanels(shell["12"], label=label, holes=holes).val()
    assert_solid(one.wrapped, volumes[shell.addresses.index("12")])
    together = cq.Workplane().ifsPanels(shell, label, holes).val()
    assert volume(together.wrapped) == pytest.approx(sum(volumes), rel=1e-9)
    with pytest.raises(LabelError):
        cq.Workplane().ifsPanels(shell["12"], label=ifs.Label(depth=10.0))


def test_panels_are_combined_when_asked():
    panel = roof(400, 300, 30)["1"]
    block = cq.Workplane().box(10, 10, 10)
    assert len(block.ifsPanels(panel).vals()) == 1
    assert volume(block.ifsPanels(panel).val().wrapped) == pytest.approx(panel.volume, rel=1e-9)
    joined = block.ifsPanels(panel, combine=True)
    overlap = block.val().intersect(to_solid(panel)).Volume()
    assert overlap > 0
    assert joined.val().Volume() == pytest.approx(1000 + panel.volume - overlap, rel=1e-9)
    cut = block.ifsPanels(panel, combine="cut")
    assert cut.val().Volume() == pytest.approx(1000 - overlap, rel=1e-9)


@pytest.mark.parametrize("plane", PLANES)
def test_design_surface_has_the_faces_of_the_mesh(plane):
    shell = vault()
    placed = cq.Workplane(plane).pushPoints([(0, 0), (3000, 0)]).ifsSurface(shell)
    for shift, surface in zip((0, 3000), placed.vals(), strict=True):
        faces = surface.Faces()
        assert len(faces) == len(shell)
        for face, polygon, area in zip(faces, shell.mesh.polygons(), shell.mesh.areas, strict=True):
            assert face.geomType() == "PLANE"
            assert face.Area() == pytest.approx(area, rel=1e-9)
            corners = in_world(plane, np.add(shell.mesh.vertices[polygon], (shift, 0, 0)))
            made = {tuple(p) for p in points(face.wrapped).round(6) + 0.0}
            assert made == {tuple(p) for p in corners.round(6) + 0.0}
