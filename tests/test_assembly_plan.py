"""The order of assembly, and its drawings read back from PDF."""

import re
from dataclasses import replace

import numpy as np
import pytest
import vaults
from hypothesis import given, settings
from hypothesis import strategies as st
from layouts import in_rows
from pypdf import PdfReader

from ifs_cad.design.curve import Curve
from ifs_cad.design.mesh import Mesh
from ifs_cad.design.surface import vector_sum
from ifs_cad.elements.beam import WireFrame
from ifs_cad.elements.polyhedron import Kind, Polyhedra, Prismatoids
from ifs_cad.elements.thicken import thicken
from ifs_cad.elements.vault import vault
from ifs_cad.errors import AddressError, InputError
from ifs_cad.export.drawing import assembly_svg, export_assembly_plan
from ifs_cad.fabrication.assembly_order import HANDFUL, assembly_steps
from ifs_cad.fabrication.drawing.axonometry import (
    camera_at,
    camera_facing,
    faces_seen,
    painters_order,
)
from ifs_cad.fabrication.drawing.draw_assembly import assembly_pages
from ifs_cad.fabrication.drawing.draw_solids import DISC_TEXT
from ifs_cad.fabrication.drawing.page import Trace, Words
from ifs_cad.fabrication.operations import workpieces
from ifs_cad.types import Plane

TAU = 2 * np.pi


def shell_over(profile, *, columns=3):
    """Panels over a profile of (x, z), each row `columns` panels long."""
    points = np.array([(x, 0.0, z) for x, z in profile])
    across = [(0.0, 400.0 * k, 0.0) for k in range(columns + 1)]
    return thicken(vector_sum(points, across, addresses="lexicographic"), 10.0)


def rows_of(steps):
    return [int(re.fullmatch(r"row (\d+) of \d+", step.name)[1]) for step in steps]


def circle(count, radius=1000.0):
    turn = TAU * np.arange(count + 1) / count
    return [(radius * np.sin(t), -radius * np.cos(t)) for t in turn[:-1]] + [(0.0, -radius)]


def planks():
    curve = Curve([(0, 0, 0), (-300, 0, 3000), (4000, 0, 3600), (4500, 0, 0)], depth=3)
    ground = Plane((0, 0, 0), (0, 0, 1))
    return vault(curve, 120.0, 27.0, layers=5, stagger=True, springing=ground)


def rippled():
    """A mesh that knows no lattice: 12 x 12 panels named f0000, f0001, ..."""
    shell = vaults.vault(3)
    mesh = Mesh(shell.mesh.vertices, shell.mesh.polygons())
    return thicken(mesh, 10.0)


ALL = {
    "vector sum": lambda: vaults.vault(3),
    "floor": lambda: vaults.vault(2, floor=vaults.GROUND),
    "door": lambda: vaults.vault(2).without("00*"),
    "part": lambda: vaults.vault(2).part(["0*", "3*"]),
    "mesh": rippled,
    "planks": planks,
    "frame": lambda: WireFrame(vaults.vault(2).mesh, 30.0, 30.0),
}


@pytest.mark.parametrize("make", ALL.values(), ids=ALL.keys())
def test_every_element_is_put_up_once(make):
    elements = make()
    steps = assembly_steps(elements)
    assert sorted(k for step in steps for k in step.elements) == list(range(len(elements)))
    assert [step.number for step in steps] == list(range(1, len(steps) + 1))
    for step in steps:
        assert step.addresses == tuple(elements.addresses[k] for k in step.elements)


def test_rows_of_an_arch_rise_from_both_feet_and_meet_at_the_crown():
    arch = [(0, 0), (200, 700), (900, 1200), (1700, 1200), (2400, 700), (2600, 0)]
    assert rows_of(assembly_steps(shell_over(arch))) == [1, 5, 2, 4, 3]


def test_rows_of_a_wall_rise_from_its_foot():
    wall = [(300, 900), (200, 600), (50, 300), (0, 0)]
    assert rows_of(assembly_steps(shell_over(wall))) == [3, 2, 1]


def test_rows_of_a_butterfly_roof_spread_from_its_valley():
    roof = [(0, 500), (300, 200), (600, 0), (900, 210), (1200, 520)]
    assert rows_of(assembly_steps(shell_over(roof))) == [2, 3, 1, 4]


def test_a_row_that_is_low_but_hangs_waits_for_what_carries_it():
    # the third row dips as low as the second is high, yet touches nothing before the others stand
    dip = [(0, 0), (100, 900), (500, 1500), (900, 700), (1300, 1600), (1400, 2100)]
    assert rows_of(assembly_steps(shell_over(dip))) == [1, 2, 3, 4, 5]


def test_rows_of_a_tube_close_at_its_top():
    steps = rows_of(assembly_steps(shell_over(circle(8))))
    assert sorted(steps) == list(range(1, 9))
    assert sorted(steps[:2]) == [1, 8]
    assert sorted(steps[2:4]) == [2, 7]
    assert sorted(steps[-2:]) == [4, 5]


def test_a_wall_goes_up_by_level_courses_whichever_curve_stands():
    level, standing = ([(0, 400 * k, 0) for k in range(5)], [(0, 0, 400 * k) for k in range(3)])
    for curves, what in (((level, standing), "column"), ((standing, level), "row")):
        wall = thicken(vector_sum(*curves), 10.0)
        steps = assembly_steps(wall)
        assert [step.name for step in steps] == [f"{what} 1 of 2", f"{what} 2 of 2"]
        heights = wall.mesh.centroids[wall.faces, 2]
        for step, height in zip(steps, (200.0, 600.0), strict=True):
            np.testing.assert_allclose(heights[list(step.elements)], [height] * 4)


def test_rows_keep_their_numbers_where_panels_are_left_out():
    arch = [(0, 0), (200, 700), (900, 1200), (1700, 1200), (2400, 800), (2600, 0)]
    whole = shell_over(arch)
    row_of = {a: step.name for step in assembly_steps(whole) for a in step.addresses}
    rest = assembly_steps(whole.without(["0.1", "3.*"]))
    assert rows_of(rest) == [1, 5, 2, 3]
    assert all(row_of[address] == step.name for step in rest for address in step.addresses)


def test_layers_of_a_vault_follow_each_other_along_the_curve():
    elements = planks()
    steps = assembly_steps(elements)
    assert [step.name for step in steps] == [f"layer L{k:02}" for k in range(5)]
    for step in steps:
        numbers = elements.numbers[list(step.elements)]
        assert (np.diff(numbers) > 0).all()


@pytest.mark.parametrize("name", ["mesh", "frame"])
def test_elements_without_rows_share_a_prefix(name):
    for step in assembly_steps(ALL[name]()):
        prefix = step.name.removeprefix("prefix ")
        assert len(step.elements) <= HANDFUL
        assert all(address.startswith(prefix) for address in step.addresses)


def test_a_part_keeps_the_steps_of_the_whole():
    shell = vaults.vault(3)
    steps = assembly_steps(shell, "03*")
    found = [address for step in steps for address in step.addresses]
    assert sorted(found) == sorted(a for a in shell.addresses if a.startswith("03"))
    names = {a: step.name for step in assembly_steps(shell) for a in step.addresses}
    assert all(names[a] == step.name for step in steps for a in step.addresses)


def test_an_unknown_part_is_an_error():
    with pytest.raises(AddressError, match="'9\\*'"):
        assembly_steps(vaults.vault(2), "9*")


def boxes(cells, shares):
    """Boxes within the cells of a cubic grid, so that planes part all of them."""
    corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], dtype=float)
    low = np.array(cells) + 0.5 * (1 - np.array(shares)) ** 2
    size = np.array(shares)
    plan = low[:, None, :2] + corners * size[:, None, :2]
    count = len(cells)
    # the side that ends in corner k, inward
    sides = np.tile([(1.0, 0, 0), (0, 1.0, 0), (-1.0, 0, 0), (0, -1.0, 0)], (count, 1))
    under, over = low[:, 2], low[:, 2] + size[:, 2]
    flat = plan.reshape(-1, 2)
    return Prismatoids(
        lower=np.column_stack([flat, np.repeat(under, 4)]),
        upper=np.column_stack([flat, np.repeat(over, 4)]),
        side_normals=sides,
        kinds=np.full(4 * count, Kind.BORDER),
        mates=np.full(4 * count, -1),
        solid_offsets=4 * np.arange(count + 1),
        normals=np.tile([0.0, 0.0, 1.0], (count, 1)),
    ).polyhedra()


def require_nothing_hidden_wrongly(solids: Polyhedra, camera, order, rays=400):
    """Shoot rays against the view: each must meet the solids in the order in which they are drawn.

    A ray meets a convex solid where it is inside all its planes.
    """
    seen = camera(solids.vertices)
    low, high = seen.min(axis=0), seen.max(axis=0)
    random = np.random.default_rng(1)
    spots = low[:2] + random.random((rays, 2)) * (high - low)[:2]
    starts = np.column_stack([spots, np.zeros(rays)]) @ camera.axes
    slope = solids.normals @ camera.back
    gap = solids.levels - starts @ solids.normals.T
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        reach = gap / slope
    leaving = np.where(slope > 1e-9, reach, np.inf)
    entering = np.where(slope < -1e-9, reach, -np.inf)
    outside = (np.abs(slope) <= 1e-9) & (gap < 0)
    first = solids.solid_offsets[:-1]
    last = np.minimum.reduceat(leaving, first, axis=1)
    begin = np.maximum.reduceat(entering, first, axis=1)
    hit = (last - begin > 1e-6) & ~np.logical_or.reduceat(outside, first, axis=1)
    place = np.empty(len(solids), dtype=int)
    place[order] = np.arange(len(solids))
    met = 0
    for ray in range(rays):
        behind_to_front = sorted(np.flatnonzero(hit[ray]), key=lambda k: last[ray, k])
        drawn = [place[k] for k in behind_to_front]
        assert drawn == sorted(drawn)
        met += len(drawn) > 1
    return met


@settings(max_examples=60)
@given(
    cells=st.lists(st.tuples(*[st.integers(0, 3)] * 3), min_size=1, max_size=14, unique=True),
    share=st.floats(0.3, 1.0),
    azimuth=st.floats(-180, 180),
    elevation=st.floats(-80, 80),
)
def test_painters_order_hides_only_what_is_behind(cells, share, azimuth, elevation):
    shares = share * np.random.default_rng(0).uniform(0.4, 1.0, (len(cells), 3))
    solids, camera = boxes(cells, shares), camera_at(azimuth, elevation)
    order = painters_order(solids, camera)
    assert sorted(order) == list(range(len(solids)))
    require_nothing_hidden_wrongly(solids, camera, order, rays=100)


@pytest.mark.parametrize("azimuth", [-60.0, 20.0, 135.0])
@pytest.mark.parametrize("name", ["vector sum", "planks"])
def test_painters_order_is_right_for_folds_and_layers(name, azimuth):
    solids, camera = ALL[name]().solids, camera_at(azimuth, 25.0)
    order = painters_order(solids, camera)
    assert require_nothing_hidden_wrongly(solids, camera, order, rays=3000) > 100


def test_solids_that_hide_each_other_in_a_circle_are_all_drawn():
    bars = boxes([(0, 0, 0)] * 3, [(4.0, 0.2, 0.2)] * 3)
    # three bars, each over the next, are not what the planes of boxes can be sorted by
    turned = []
    for k in range(3):
        c, s = np.cos(TAU * k / 3), np.sin(TAU * k / 3)
        bar = bars.take(np.array([k]))
        lean = np.array([[1, 0, 0], [0, 1, 0], [0.2, 0, 1]])
        turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        move = turn @ lean
        points = (bar.vertices - bar.vertices.mean(axis=0) + [0, 1.0, 0]) @ move.T
        normals = bar.normals @ np.linalg.inv(move)
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        first = points[bar.loops[bar.face_offsets[:-1]]]
        turned.append(
            replace(bar, vertices=points, normals=normals, levels=(first * normals).sum(1))
        )
    sizes = [len(bar.vertices) for bar in turned]
    solids = Polyhedra(
        vertices=np.concatenate([bar.vertices for bar in turned]),
        loops=np.concatenate([bar.loops + k * sizes[0] for k, bar in enumerate(turned)]),
        face_offsets=np.arange(0, 3 * 6 * 4 + 1, 4),
        solid_offsets=np.arange(0, 19, 6),
        normals=np.concatenate([bar.normals for bar in turned]),
        levels=np.concatenate([bar.levels for bar in turned]),
        kinds=np.concatenate([bar.kinds for bar in turned]),
        mates=np.concatenate([bar.mates for bar in turned]),
    )
    assert sorted(painters_order(solids, camera_at(0.0, 90.0))) == [0, 1, 2]


@given(azimuth=st.floats(-180, 180), elevation=st.floats(-90, 90))
def test_a_camera_is_a_rotation_with_z_upright(azimuth, elevation):
    axes = camera_at(azimuth, elevation).axes
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert axes[0, 2] == pytest.approx(0.0, abs=1e-9)
    assert axes[1, 2] >= -1e-9


def test_a_box_shows_half_of_its_faces():
    solids = boxes([(0, 0, 0)], [(1.0, 1.0, 1.0)])
    seen = faces_seen(solids, camera_facing(np.array([3.0, -2.0, 1.0])))
    np.testing.assert_array_equal(
        np.sort(solids.normals[seen], axis=0), [[0, -1, 0], [0, 0, 0], [1, 0, 1]]
    )


def fills(page):
    """The colours of all shapes on a page, less white, as (n, 3) bytes."""
    colours = [m.pen.fill for m in page.marks if isinstance(m, Trace) and m.pen.fill]
    colours = [c for c in colours if c != "#ffffff"]
    return np.array([[int(c[k : k + 2], 16) for k in (1, 3, 5)] for c in colours])


def test_what_comes_later_is_not_drawn_and_what_stands_is_grey():
    shell = shell_over([(0, 0), (0, 400), (0, 800), (0, 1200)])
    steps = assembly_steps(shell)
    _, *pages = assembly_pages(shell, steps)
    for number, page in enumerate(pages):
        rgb = fills(page)
        grey = np.ptp(rgb, axis=1) < 10
        # three level faces for each row that stands, its ends and top apart
        assert (grey.sum() >= 3) == (number > 0)
        assert grey.sum() < 3 * number + 3
        assert (~grey).sum() >= 6


@pytest.mark.parametrize("make", ALL.values(), ids=ALL.keys())
def test_each_page_names_what_its_step_puts_up(make, tmp_path):
    elements = make()
    steps = assembly_steps(elements)
    path = export_assembly_plan(elements, tmp_path / "deep" / "assembly.pdf")
    reader = PdfReader(path)
    overview, *pages = [page.extract_text() for page in reader.pages]
    assert len(pages) == len(steps)
    assert [mark.title for mark in reader.outline] == [
        "Assembly",
        *(f"Step {step.number}" for step in steps),
    ]
    known = set(elements.addresses)
    for step, text in zip(steps, pages, strict=True):
        assert set(text.split()) & known - {str(k) for k in range(HANDFUL + 1)} <= set(
            step.addresses
        )
        assert set(step.addresses) <= set(text.split())
        assert step.name in text
    assert all(step.name in overview for step in steps)


def test_a_page_gives_mass_sheet_and_what_stands(tmp_path):
    shell = vaults.vault(2)
    layout = in_rows(workpieces(shell))
    path = export_assembly_plan(shell, tmp_path / "a.pdf", layout=layout)
    steps = assembly_steps(shell)
    standing = 0
    for step, page in zip(steps, list(PdfReader(path).pages)[1:], strict=True):
        words = page.extract_text().split()
        assert f"{shell.masses[list(step.elements)].sum():.2f}" in words
        text = " ".join(words)
        assert f"{standing} of 16" in text
        standing += len(step.elements)
        assert f"{standing} of 16" in text
        for address in step.addresses:
            assert layout.homes[address][0].name in words
    size = PdfReader(path).pages[0].mediabox
    assert [round(float(n) * 25.4 / 72) for n in (size.width, size.height)] == [297, 210]


def test_addresses_too_long_for_their_elements_become_numbers():
    shell = shell_over([(0, 0), (0, 400), (0, 800)])
    mesh = shell.mesh.with_addresses(f"{address}-{'x' * 160}" for address in shell.mesh.addresses)
    shell = thicken(mesh, 10.0)
    steps = assembly_steps(shell)
    *_, page = assembly_pages(shell, steps)
    words = [mark for mark in page.marks if isinstance(mark, Words)]
    texts = [mark.text for mark in words]
    discs = [mark.text for mark in words if mark.size == DISC_TEXT]
    assert all(texts.count(address) == 1 for address in steps[-1].addresses)  # in the table
    assert discs == ["1", "2", "3"] * 2  # in both pictures
    assert "numbers: see the table" in texts


def test_two_runs_give_the_same_bytes(tmp_path):
    one, other = (
        export_assembly_plan(vaults.vault(2), tmp_path / name).read_bytes() for name in "ab"
    )
    assert one == other


def test_a_layout_of_other_elements_is_refused(tmp_path):
    shell = vaults.vault(2)
    layout = in_rows(workpieces(shell)[:-1])
    with pytest.raises(InputError, match=shell.addresses[-1]):
        export_assembly_plan(shell, tmp_path / "a.pdf", layout=layout)
    assert list(tmp_path.iterdir()) == []


def test_the_overview_numbers_the_steps_of_a_shell():
    svg = assembly_svg(vaults.vault(2))
    for number in range(1, 5):
        assert f">{number}</text>" in svg
    assert len(svg) < 60_000
