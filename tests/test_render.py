"""Pictures: their size, framing, colours and what happens when they cannot be made."""

from __future__ import annotations

import ctypes.util
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import cadquery as cq
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

import ifs_cad as ifs
from ifs_cad.elements.colouring import Colouring, numbered
from ifs_cad.errors import ExportError, InputError, ViewerError
from ifs_cad.view import _draw
from ifs_cad.view._assembly import parts, view_of, viewable
from ifs_cad.view._triangulate import triangulate
from ifs_cad.view.render import render

Image = pytest.importorskip("PIL.Image", reason="pillow is not installed")

NO_EGL = sys.platform == "linux" and not ctypes.util.find_library("EGL")
draws = pytest.mark.skipif(NO_EGL, reason="no EGL: install libegl1 libegl-mesa0 libgl1-mesa-dri")

RED, BLUE, WOOD = (0.8, 0.1, 0.1), (0.1, 0.2, 0.8), (0.87, 0.72, 0.53)
SMALL: dict[str, Any] = {"width": 320, "height": 200}


def vault(offset: float = 0.0) -> cq.Assembly:
    """256 boxes nested by row on an arch; rows of three colours."""
    shell = cq.Assembly(name="vault", loc=cq.Location((offset, 0, 0)))
    for i in range(16):
        turn = np.radians(-75 + 10 * i)
        color = cq.Color(*(RED, WOOD, BLUE)[i % 3])
        place = cq.Location((1000 * np.sin(turn), 0, 1000 * np.cos(turn)), (0, 1, 0), -75 + 10 * i)
        row = cq.Assembly(name=f"row{i:02}", loc=place)
        for j in range(16):
            box = cq.Solid.makeBox(160, 90, 10, cq.Vector(-80, 0, 0))
            row.add(box, name=f"panel{i:02}{j:02}", loc=cq.Location((0, 100 * j, 0)), color=color)
        shell.add(row)
    return shell


def pixels(path: Path) -> NDArray[np.int64]:
    with Image.open(path) as image:
        assert image.format == "PNG"
        return np.asarray(image.convert("RGB")).astype(np.int64)


def extent(model: NDArray[np.bool_]) -> tuple[slice, slice]:
    """Rows and columns that the model takes."""
    rows, columns = np.flatnonzero(model.any(axis=1)), np.flatnonzero(model.any(axis=0))
    return slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)


def share(model: NDArray[np.bool_]) -> tuple[float, float]:
    """Share of the picture's height and width that the model's extent takes."""
    rows, columns = extent(model)
    height, width = model.shape
    return (rows.stop - rows.start) / height, (columns.stop - columns.start) / width


def colorful(picture: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Where the picture is neither white nor the grey of the shadow."""
    return np.ptp(picture, axis=-1) > 12


def near(picture: NDArray[np.int64], color: tuple[float, float, float]) -> float:
    """Share of the picture with a colour's hue, however light falls on it."""
    direction = np.array(color) / np.linalg.norm(color)
    lengths = np.linalg.norm(picture, axis=-1)
    cosines = (picture @ direction) / np.maximum(lengths, 1)
    return float(((cosines > 0.99) & (lengths > 80) & colorful(picture)).mean())


@draws
def test_a_vault_fills_the_frame_in_its_colours_and_is_not_cropped(tmp_path: Path) -> None:
    render(vault(), tmp_path / "vault.png", width=800, height=500)
    picture = pixels(tmp_path / "vault.png")
    assert picture.shape == (500, 800, 3)
    model = colorful(picture)
    border = np.concatenate([model[0], model[-1], model[:, 0], model[:, -1]])
    assert not border.any()
    assert max(share(model)) == pytest.approx(0.92, abs=0.01)
    background = (picture == 255).all(axis=-1).mean()
    assert 0.2 < background < 0.8
    for color in (RED, WOOD, BLUE):
        assert near(picture, color) > 0.02


def test_a_box_is_twelve_triangles_and_its_edges_seen_from_both_faces() -> None:
    [box] = triangulate([cq.Solid.makeBox(10, 20, 30)])
    a, b, c = np.moveaxis(box.points[box.triangles], 1, 0)
    assert len(box.triangles) == 12
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 == pytest.approx(2200)
    lengths = np.linalg.norm(np.ptp(box.points[box.lines], axis=1), axis=1)
    assert sorted(lengths) == pytest.approx([10] * 8 + [20] * 8 + [30] * 8)


def test_the_same_shape_in_two_places_is_drawn_in_both() -> None:
    box = cq.Solid.makeBox(10, 20, 30).moved(cq.Location((5, 0, 0)))
    places = [cq.Location((0, 0, 0)), cq.Location((100, 0, 0), (0, 0, 1), 90)]
    here, there = triangulate([box.moved(place) for place in places])
    assert here.points.min(axis=0) == pytest.approx([5, 0, 0])
    assert here.points.max(axis=0) == pytest.approx([15, 20, 30])
    assert there.points.min(axis=0) == pytest.approx([80, 5, 0])
    assert there.points.max(axis=0) == pytest.approx([100, 15, 30])


def test_the_seam_of_a_round_face_is_no_edge() -> None:
    [cylinder] = triangulate([cq.Solid.makeCylinder(10, 30)])
    ends = cylinder.points[cylinder.lines]
    assert np.ptp(ends[..., 2], axis=1).max() == pytest.approx(0)
    assert np.linalg.norm(ends[..., :2], axis=-1) == pytest.approx(np.full(ends.shape[:2], 10.0))


def test_an_edge_without_a_face_is_lines() -> None:
    both = cq.Compound.makeCompound(
        [cq.Edge.makeLine(cq.Vector(0, 0, 50), cq.Vector(0, 7, 50)), cq.Solid.makeBox(1, 1, 1)]
    )
    [mesh] = triangulate([both])
    assert len(mesh.triangles) == 12
    high = mesh.points[mesh.lines[(mesh.points[mesh.lines][..., 2] > 10).all(axis=1)]]
    assert high.tolist() == [[[0, 0, 50], [0, 7, 50]]]


@given(
    points=arrays(float, (5, 3), elements=st.floats(-1e4, 1e4)),
    azimuth=st.floats(-360, 360),
    elevation=st.floats(-90, 90),
    aspect=st.floats(0.2, 5),
)
def test_the_camera_frames_any_points_from_anywhere(
    points: NDArray[np.float64], azimuth: float, elevation: float, aspect: float
) -> None:
    assume(np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[1] > 1)
    camera = _draw.framing_camera(points, azimuth, elevation, 1.0, aspect)
    matrix = camera.GetCompositeProjectionTransformMatrix(aspect, -1.0, 1.0)
    columns = np.array([matrix.MultiplyPoint((*point, 1.0)) for point in points]).T
    seen = columns[:2] / columns[3]
    assert (columns[3] > 0).all()  # in front of the camera
    assert np.abs(seen).max() <= _draw.FILL + 1e-6
    nearest, depth = columns[3].min(), np.ptp(columns[3])
    assert nearest >= depth - 1e-6
    if nearest > depth + 1e-6:
        tighter = np.argmax(np.ptp(seen, axis=1))
        assert seen[tighter].max() == pytest.approx(_draw.FILL, abs=1e-6)
        assert seen[tighter].min() == pytest.approx(-_draw.FILL, abs=1e-6)


@draws
@pytest.mark.parametrize("elevation", [-20.0, 90.0])
def test_a_model_is_framed_from_below_and_from_the_top(tmp_path: Path, elevation: float) -> None:
    render(vault(), tmp_path / "v.png", azimuth=-170.0, elevation=elevation, **SMALL)
    assert max(share(colorful(pixels(tmp_path / "v.png")))) == pytest.approx(0.92, abs=0.02)


@draws
def test_z_is_up_and_the_camera_stands_at_its_azimuth(tmp_path: Path) -> None:
    low = cq.Assembly(cq.Solid.makeBox(100, 100, 40), color=cq.Color(*BLUE))
    low.add(cq.Solid.makeBox(40, 100, 40, cq.Vector(60, 0, 40)), color=cq.Color(*RED))
    for azimuth, red_side in ((-90.0, "right"), (90.0, "left")):
        render(low, tmp_path / "v.png", azimuth=azimuth, elevation=0.0, edges=False, **SMALL)
        picture = pixels(tmp_path / "v.png")
        red, blue = (
            (picture[..., 0] > picture[..., 2] + 50),
            (picture[..., 2] > picture[..., 0] + 50),
        )
        assert extent(red)[0].stop <= extent(blue)[0].start + 2
        red_is_right = np.argwhere(red)[:, 1].mean() > np.argwhere(blue)[:, 1].mean()
        assert ("right" if red_is_right else "left") == red_side


@draws
def test_zoom_enlarges_about_the_middle(tmp_path: Path) -> None:
    ball = cq.Workplane().sphere(10)
    for zoom in (0.5, 0.75):
        render(ball, tmp_path / "v.png", elevation=0.0, zoom=zoom, **SMALL)
        assert share(colorful(pixels(tmp_path / "v.png")))[0] == pytest.approx(
            0.92 * zoom, abs=0.02
        )


@draws
def test_a_model_far_from_the_origin_is_drawn_the_same(tmp_path: Path) -> None:
    render(vault(), tmp_path / "here.png", **SMALL)
    render(vault(offset=1e6), tmp_path / "there.png", **SMALL)
    difference = np.abs(pixels(tmp_path / "here.png") - pixels(tmp_path / "there.png"))
    assert difference.mean() < 2


@draws
@pytest.mark.parametrize(
    "thing",
    [
        cq.Workplane().box(10, 10, 2).faces(">Z").workplane().hole(3),
        cq.Solid.makeCylinder(5, 10),
        cq.Face.makePlane(10, 10),
    ],
    ids=["workplane", "solid", "face"],
)
def test_things_without_a_colour_are_plywood(tmp_path: Path, thing: Any) -> None:
    render(thing, tmp_path / "v.png", **SMALL)
    assert near(pixels(tmp_path / "v.png"), WOOD) > 0.05


@draws
@pytest.mark.parametrize("edges", [True, False])
def test_strokes_without_faces_are_always_drawn(tmp_path: Path, edges: bool) -> None:
    render(cq.Edge.makeCircle(10), tmp_path / "v.png", elevation=90, edges=edges, **SMALL)
    assert share((pixels(tmp_path / "v.png") < 200).any(axis=-1))[0] == pytest.approx(
        0.92, abs=0.02
    )


@draws
def test_edges_are_drawn_or_not(tmp_path: Path) -> None:
    dark = {}
    for edges in (True, False):
        render(cq.Workplane().box(10, 10, 10), tmp_path / "v.png", edges=edges, **SMALL)
        dark[edges] = (pixels(tmp_path / "v.png").max(axis=-1) < 110).mean()
    assert dark[True] > 0.005
    assert dark[False] == 0


@draws
def test_what_is_behind_a_transparent_part_shines_through(tmp_path: Path) -> None:
    inside = cq.Assembly(cq.Workplane().box(4, 4, 4), color=cq.Color(*RED))
    seen = {}
    for alpha in (0.3, 1.0):
        around = cq.Assembly(cq.Workplane().box(10, 10, 10), color=cq.Color(*BLUE, alpha))
        render(around.add(inside), tmp_path / "v.png", edges=False, **SMALL)
        picture = pixels(tmp_path / "v.png")
        seen[alpha] = (picture[..., 0] > picture[..., 2] + 20).mean()
    assert seen[0.3] > 0.02
    assert seen[1.0] == 0


@draws
def test_the_background_is_the_colour_asked_for(tmp_path: Path) -> None:
    render(cq.Workplane().box(1, 1, 1), tmp_path / "v.png", background="#204060", **SMALL)
    corner = pixels(tmp_path / "v.png")[0, 0]
    assert np.abs(corner - [0x20, 0x40, 0x60]).max() <= 1


@draws
def test_nothing_is_left_beside_the_picture(tmp_path: Path) -> None:
    target = tmp_path / "v.PNG"
    target.write_bytes(b"old")
    render(cq.Workplane().box(1, 1, 1), target, **SMALL)
    assert [path.name for path in tmp_path.iterdir()] == ["v.PNG"]
    assert pixels(target).shape == (200, 320, 3)


@draws
def test_an_unwritable_target_is_an_error_and_stays_as_it_was(tmp_path: Path) -> None:
    target = tmp_path / "v.png"
    (target / "inside").mkdir(parents=True)
    with pytest.raises(ExportError, match="Cannot write"):
        render(cq.Workplane().box(1, 1, 1), target, **SMALL)
    assert [path.name for path in tmp_path.iterdir()] == ["v.png"]
    assert (target / "inside").is_dir()


@draws
def test_a_missing_folder_is_made(tmp_path: Path) -> None:
    target = tmp_path / "none" / "v.png"
    render(cq.Workplane().box(1, 1, 1), target, **SMALL)
    assert pixels(target).shape == (200, 320, 3)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux chooses among backends")
@pytest.mark.skipif(bool(ctypes.util.find_library("OSMesa")), reason="OSMesa draws")
def test_a_missing_backend_is_an_error_that_names_the_packages(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkOSOpenGLRenderWindow")
    monkeypatch.delenv("DISPLAY", raising=False)
    target = tmp_path / "v.png"
    target.write_bytes(b"old")
    with pytest.raises(ViewerError, match="libegl1, libegl-mesa0 and libgl1-mesa-dri"):
        render(cq.Workplane().box(1, 1, 1), target, **SMALL)
    assert target.read_bytes() == b"old"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"width": 0}, "whole pixels"),
        ({"height": 10**6}, "whole pixels"),
        ({"width": 320.5}, "whole pixels"),
        ({"azimuth": float("nan")}, "must be finite"),
        ({"elevation": float("inf")}, "must be finite"),
        ({"zoom": 0.0}, "zoom positive"),
        ({"background": "no such colour"}, "Unknown background"),
    ],
)
def test_a_number_or_colour_that_cannot_be_meant_is_an_error(
    tmp_path: Path, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        render(cq.Workplane().box(1, 1, 1), tmp_path / "v.png", **options)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["v.jpg", "v", "png"])
def test_another_format_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match=r"must end in \.png"):
        render(cq.Workplane().box(1, 1, 1), tmp_path / name)


@pytest.mark.parametrize(
    "thing",
    [42, cq.Assembly(), cq.Workplane(), cq.Vertex.makeVertex(1, 2, 3)],
    ids=["number", "assembly", "workplane", "vertex"],
)
def test_a_thing_without_a_shape_is_refused(tmp_path: Path, thing: Any) -> None:
    with pytest.raises(InputError, match=r"looked at|look at"):
        render(thing, tmp_path / "v.png")


def test_a_failure_of_the_drawing_program_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "numpy.py").write_text("raise ImportError('numpy is broken')\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ViewerError, match="Drawing failed with ImportError: numpy is broken"):
        render(cq.Workplane().box(1, 1, 1), tmp_path / "v.png", **SMALL)


@draws
def test_a_shell_is_drawn_as_its_panels(tmp_path: Path) -> None:
    points = np.array([[0, 0, 0], [300, 0, 200], [700, 0, 200], [1000, 0, 0]])
    shell = ifs.thicken(ifs.vector_sum(points, points[:, [1, 0, 2]]), 20.0)
    assert len(parts(viewable(shell))) == len(shell) == 9
    render(shell, tmp_path / "v.png", **SMALL)
    assert near(pixels(tmp_path / "v.png"), WOOD) > 0.1


def fold() -> ifs.Shell:
    """Four panels of different sizes; the two at the back are seen as well."""
    a = [(0, 0, 0), (400, 0, 300), (1000, 0, 0)]
    return ifs.thicken(ifs.vector_sum(a, [(0, 0, 0), (0, 300, 0), (0, 1000, 0)]), 20.0)


@draws
def test_panels_have_the_colours_of_their_values_and_a_legend_beside_them(tmp_path: Path) -> None:
    given = Colouring("area, m2", np.array([1.0, 2.0, 3.0, 4.0]))
    render(fold(), tmp_path / "v.png", colour=given, elevation=60.0, edges=False, **SMALL)
    picture = pixels(tmp_path / "v.png")
    model, legend = picture[:, : int(0.86 * 320)], picture[:, int(0.86 * 320) :]
    for colour in given.colours:
        assert near(model, tuple(colour / 255.0)) > 0.01
    for colour in (given.scale[0], given.scale[-1]):
        assert (np.abs(legend - colour).max(axis=-1) < 12).any()
    # the darkest below, the lightest above
    rows = [np.argwhere(np.abs(legend - c).max(axis=-1) < 12)[:, 0] for c in given.scale[[0, -1]]]
    assert rows[0].mean() > rows[1].mean()


@draws
def test_sheets_are_named_in_the_legend(tmp_path: Path) -> None:
    given = numbered("sheet", ["sheet-01", "sheet-02", "sheet-01", None])
    render(fold(), tmp_path / "v.png", colour=given, elevation=60.0, **SMALL)
    legend = pixels(tmp_path / "v.png")[:, int(0.86 * 320) :]
    for colour in given.scale:
        assert (np.abs(legend - colour).max(axis=-1) < 12).sum() > 20


@draws
def test_addresses_are_written_on_the_faces_that_are_seen(tmp_path: Path) -> None:
    shell = fold()
    look: dict[str, Any] = {"width": 640, "height": 400, "edges": False, "azimuth": -90.0}
    for elevation in (89.0, -89.0):
        pictures = []
        for labels in (False, True):
            render(shell, tmp_path / "v.png", labels=labels, elevation=elevation, **look)
            pictures.append(pixels(tmp_path / "v.png"))
        letters = np.abs(pictures[0] - pictures[1]).max(axis=-1) > 60
        assert pictures[1][letters].max(axis=-1).mean() < 130  # dark on wood
        rows, columns = extent(colorful(pictures[0]))
        middle_column = (columns.start + columns.stop) // 2
        middle_row = (rows.start + rows.stop) // 2
        for half in (letters[:middle_row], letters[middle_row:]):
            assert half[:, :middle_column].any()
            assert half[:, middle_column:].any()
        outside = letters.copy()
        outside[rows, columns] = False
        assert not outside.any()


@draws
def test_an_address_behind_another_panel_is_not_written(tmp_path: Path) -> None:
    """Seen along the ridge line from the side, the far slope is hidden by the near one."""
    roof = ifs.thicken(
        ifs.vector_sum([(0, 0, 0), (500, 0, 500), (1000, 0, 0)], [(0, 0, 0), (0, 1000, 0)]), 20.0
    )
    look: dict[str, Any] = {"width": 640, "height": 400, "edges": False, "elevation": 0.0}
    rows = []
    for labels in (False, True):
        render(roof, tmp_path / "v.png", labels=labels, azimuth=0.0, **look)
        rows.append(pixels(tmp_path / "v.png"))
    letters = np.abs(rows[0] - rows[1]).max(axis=-1) > 60
    columns = np.flatnonzero(letters.any(axis=0))
    assert len(columns)
    assert np.ptp(columns) < 250  # one address, in the middle


@draws
def test_an_exploded_view_shows_the_background_between_pieces(tmp_path: Path) -> None:
    gaps = {}
    for explode in (0.0, 0.5):
        render(fold(), tmp_path / "v.png", elevation=89.0, explode=explode, **SMALL)
        model = colorful(pixels(tmp_path / "v.png"))
        rows, columns = extent(model)
        gaps[explode] = 1 - model[rows, columns].mean()
    assert gaps[0.5] > gaps[0.0] + 0.05


def test_a_model_of_no_elements_has_no_addresses_colours_or_pieces(tmp_path: Path) -> None:
    box = cq.Workplane().box(1, 1, 1)
    for options in ({"labels": True}, {"colour": "area"}, {"explode": 0.5}):
        with pytest.raises(InputError, match="Only panels and planks"):
            render(box, tmp_path / "v.png", **options)


def test_values_for_other_elements_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="4 elements need as many values of x, got 2"):
        render(fold(), tmp_path / "v.png", colour=Colouring("x", np.array([1.0, 2.0])))


def test_looking_leaves_the_assembly_as_it_is() -> None:
    assembly = ifs.to_assembly(fold(), nest=0)
    before = [(name, part.loc.toTuple(), part.color) for name, part in assembly.objects.items()]
    view = view_of(assembly, "area", 0.5)
    assert [
        (name, part.loc.toTuple(), part.color) for name, part in assembly.objects.items()
    ] == before
    moved = [part.loc.toTuple()[0] for name, part in view.assembly.objects.items() if part.obj]
    assert len(moved) == 4
    shifts = np.array(moved) - [part[1][0] for part in before if part[0] != "shell"]
    assert shifts == pytest.approx(view.groups[0].shifts)


def test_several_shells_share_one_scale() -> None:
    both = cq.Assembly()
    both.add(ifs.to_assembly(fold()), name="one")
    both.add(ifs.to_assembly(fold().take([0])), name="two", loc=cq.Location((0, 0, 900)))
    groups = view_of(both, "area").groups
    assert len({group.colouring.range for group in groups if group.colouring}) == 1
    low, high = groups[0].colouring.range  # type: ignore[union-attr]
    areas = fold().areas * 1e-6
    assert (low, high) == pytest.approx((areas.min(), areas.max()))


@draws
def test_drawing_needs_no_screen(tmp_path: Path) -> None:
    code = (
        "import sys, cadquery as cq\n"
        "from ifs_cad.view.render import render\n"
        "render(cq.Workplane().box(1, 1, 1), sys.argv[1], width=64, height=64)\n"
    )
    environment = {
        name: value
        for name, value in os.environ.items()
        if name not in {"DISPLAY", "WAYLAND_DISPLAY", "VTK_DEFAULT_OPENGL_WINDOW"}
    }
    environment["PYTHONPATH"] = os.pathsep.join(sys.path)
    subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "v.png")], env=environment, check=True
    )
    assert pixels(tmp_path / "v.png").shape == (64, 64, 3)
