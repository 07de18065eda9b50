"""The drawing of the assembly: a page that shows the order of all steps, then one for each step.

On the page of a step, what stands already is grey and what is put up now is coloured; what comes
later is not drawn. Where the step is hidden by what stands in front, its outline still shows. Below
it is drawn once more, alone and seen square on from its upper face. Where an address does not fit
on its element, the number by which the table lists it is written instead.

Source: section 4.3, figure 20.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.elements.element import Elements
from ifs_cad.elements.polyhedron import Polyhedra
from ifs_cad.elements.vault import Vault
from ifs_cad.errors import InputError
from ifs_cad.fabrication.assembly_order import Step
from ifs_cad.fabrication.drawing.axonometry import (
    Camera,
    camera_at,
    camera_facing,
    centres,
    painters_order,
)
from ifs_cad.fabrication.drawing.drafting import (
    BLOCK,
    MARGIN,
    SMALL,
    Paper,
    draw_table,
    framed_page,
)
from ifs_cad.fabrication.drawing.draw_solids import DISC_TEXT, Picture, number_disc
from ifs_cad.fabrication.drawing.page import GREY, Page
from ifs_cad.fabrication.layout import Layout
from ifs_cad.fabrication.table import Cell, Column, Table
from ifs_cad.tolerance import DEFAULT
from ifs_cad.types import FloatArray, IntArray

_AZIMUTHS = (-60.0, -120.0, -30.0, -150.0, 60.0, 120.0, 30.0, 150.0)
_ELEVATION = 25.0
_PAD = 5.0
_TABLE = 68.0  # width, mm
_ROWS = 42  # of a table in one column
_CAPTION = 4.5
_STRIP = (24.0, 76.0)  # least and greatest height of the picture seen square on, mm
_STANDING = (0.86, 0.86, 0.85)
_NEW = (0.96, 0.68, 0.32)
_FIRST, _LAST = (0.99, 0.91, 0.68), (0.72, 0.33, 0.20)  # of the steps on the first page


def assembly_pages(
    elements: Elements,
    steps: Sequence[Step],
    layout: Layout | None = None,
    *,
    paper: Paper = "A4",
) -> Iterator[Page]:
    """Draw all steps on one page, then each on its own.

    Parameters
    ----------
    elements : what is put up
    steps : of `assembly_steps`, at least one
    layout : Layout, optional
        What says from which sheet each element comes.
    paper : "A4" or "A3"

    Raises
    ------
    InputError
        The layout misses what is put up.
    """
    if layout is not None:
        missing = [name for step in steps for name in step.addresses if name not in layout.homes]
        if missing:
            raise InputError(
                f"The layout places no {listed(missing)}: it was made for other elements.",
                addresses=missing,
            )
    scene = _Scene.of(elements, steps)
    yield _overview_page(scene, paper)
    for step in steps:
        yield _step_page(scene, step, layout, paper)


def overview_page(elements: Elements, steps: Sequence[Step], *, paper: Paper = "A4") -> Page:
    """Draw the page that shows the order of all steps."""
    return _overview_page(_Scene.of(elements, steps), paper)


@dataclass(frozen=True, eq=False)
class _Scene:
    """What all pages show.

    Attributes
    ----------
    solids : of all elements that are put up, in the order of the steps
    normals : (n, 3) float, of their upper faces
    mates : (f,) int, the solid on the other side of each face, -1 if none
    masses : (n,) float, kg
    steps : their elements counted as in `solids`: members of step k begin at starts[k - 1]
    starts : (steps + 1,) int
    camera : Camera
    """

    solids: Polyhedra
    normals: FloatArray
    mates: IntArray
    masses: FloatArray
    steps: tuple[Step, ...]
    starts: IntArray
    camera: Camera

    @classmethod
    def of(cls, elements: Elements, steps: Sequence[Step]) -> _Scene:
        """Return the scene of some steps."""
        chosen = np.array([k for step in steps for k in step.elements], dtype=np.int64)
        starts = np.cumsum([0, *(len(step.elements) for step in steps)])
        solids = elements.solids.take(chosen)
        place = {elements.addresses[k]: n for n, k in enumerate(chosen.tolist())}
        # the last entry serves the mate -1
        mate_of = np.array([place.get(name, -1) for name in elements.mate_addresses] + [-1])
        return cls(
            solids,
            elements.normals[chosen],
            mate_of[solids.mates],
            elements.solids.volumes[chosen] * 1e-9 * elements.material.density,
            tuple(steps),
            starts,
            _chosen_camera(elements, solids),
        )

    @cached_property
    def order(self) -> IntArray:
        """(n,) int, from the back to the front."""
        return painters_order(self.solids, self.camera)

    def members(self, step: Step) -> IntArray:
        """(k,) int, the solids of a step."""
        return np.arange(*self.starts[[step.number - 1, step.number]])


def _chosen_camera(elements: Elements, solids: Polyhedra) -> Camera:
    """Return the camera to which the fewest elements hide each other.

    A vault is seen from where its last layer is, so that every new layer lies in front.
    """
    azimuths: tuple[float, ...] = _AZIMUTHS
    if isinstance(elements, Vault):
        x, y, _ = elements.segments.across.tolist()
        if math.hypot(x, y) > elements.tol.parallel:
            azimuths = (math.degrees(math.atan2(y, x)) + 30.0,)
    middles = centres(solids, solids.vertices)
    cell = float(np.ptp(solids.vertices, axis=0).max()) / (2.0 * math.sqrt(len(solids)))

    def cells_met(camera: Camera) -> int:
        return len(np.unique(np.round(camera(middles)[:, :2] / cell), axis=0))

    return max((camera_at(azimuth, _ELEVATION) for azimuth in azimuths), key=cells_met)


def _overview_page(scene: _Scene, paper: Paper) -> Page:
    total = len(scene.solids)
    cells = [
        ("steps", str(len(scene.steps))),
        ("elements", str(total)),
        ("mass, kg", f"{scene.masses.sum():.1f}"),
        ("colour", "from light to dark in the order of assembly"),
    ]
    page = framed_page("Assembly", cells, paper)
    columns = (
        Column("step", decimals=0),
        Column("what", "text"),
        Column("elements", decimals=0),
        Column("mass (kg)"),
    )
    rows = tuple(
        (step.number, step.name, len(step.elements), float(scene.masses[scene.members(step)].sum()))
        for step in scene.steps
    )
    left = _draw_list(page, Table("steps", columns, rows))
    box = (MARGIN + _PAD, MARGIN + BLOCK + _PAD, left - _PAD, page.height - MARGIN - _PAD)
    picture = Picture(page, scene.solids, scene.mates, scene.camera, box)
    shares = np.repeat(
        np.linspace(0.0, 1.0, len(scene.steps)) if len(scene.steps) > 1 else [0.5],
        np.diff(scene.starts),
    )
    colours = np.array(_FIRST) + shares[:, None] * (np.array(_LAST) - _FIRST)
    everything = np.ones(total, dtype=bool)
    picture.paint(scene.order, everything, colours)
    numbered = np.empty((0, 2))
    for step in scene.steps:
        spots = picture.spots[scene.members(step)]
        middle = spots[((spots - spots.mean(axis=0)) ** 2).sum(axis=1).argmin()]
        # where thin layers crowd, every few are numbered
        if (np.hypot(*(numbered - middle).T) > 2 * DISC_TEXT).all():
            numbered = np.vstack([numbered, middle])
            number_disc(page, middle, str(step.number))
    return page


def _step_page(scene: _Scene, step: Step, layout: Layout | None, paper: Paper) -> Page:
    members = scene.members(step)
    before, total = int(members[0]), len(scene.solids)
    mass = float(scene.masses[members].sum())
    cells = [
        ("what", step.name),
        ("step", f"{step.number} of {len(scene.steps)}"),
        ("elements", str(len(members))),
        ("mass, kg", f"{mass:.2f}"),
        ("standing before", f"{before} of {total}"),
        ("standing after", f"{before + len(members)} of {total}"),
    ]
    page = framed_page(f"Step {step.number}", cells, paper)
    left = _draw_list(page, _listing(scene, step, layout))
    bottom = MARGIN + BLOCK
    own = scene.solids.take(members)
    facing = scene.normals[members].mean(axis=0)
    # beams around a node may face all ways at once
    alone = scene.camera if math.hypot(*facing) <= DEFAULT.parallel else camera_facing(facing)
    extent = np.ptp(alone(own.vertices)[:, :2], axis=0)
    room = left - MARGIN - 2 * _PAD
    high = float(np.clip(room * extent[1] / extent[0], *_STRIP))
    split = bottom + high + _CAPTION + 2 * _PAD

    sides = MARGIN + _PAD, left - _PAD
    box = (sides[0], split + _PAD, sides[1], page.height - MARGIN - _PAD)
    picture = Picture(page, scene.solids, scene.mates, scene.camera, box)
    standing = np.arange(total) < before
    colours = np.where(standing[:, None], _STANDING, _NEW)
    shown = np.arange(total) < before + len(members)
    picture.paint(scene.order, shown, colours, members)
    picture.ghost(members)
    names = picture.write(members, step.addresses)

    box = (sides[0], bottom + _PAD, sides[1], split - _CAPTION - _PAD)
    square_on = Picture(page, scene.solids, scene.mates, alone, box, members)
    caption = "seen square on, from the upper face"
    page.text(caption, sides[0], split - _CAPTION, SMALL, colour=GREY)
    only = np.zeros(total, dtype=bool)
    only[members] = True
    square_on.paint(members[painters_order(own, alone)], only, colours, members)
    if not (square_on.write(members, step.addresses) and names):
        note = "numbers: see the table"
        page.text(note, sides[1], split - _CAPTION, SMALL, anchor="end", colour=GREY)
    return page


def _listing(scene: _Scene, step: Step, layout: Layout | None) -> Table:
    columns = [Column("no.", decimals=0), Column("address", "text"), Column("mass (kg)")]
    if layout is not None:
        columns.append(Column("from", "text"))
    rows: list[tuple[Cell, ...]] = []
    masses = scene.masses[scene.members(step)].tolist()
    for number, (address, mass) in enumerate(zip(step.addresses, masses, strict=True), start=1):
        row: tuple[Cell, ...] = (number, address, mass)
        rows.append(row if layout is None else (*row, layout.homes[address][0].name))
    return Table(step.name, tuple(columns), tuple(rows))


def _draw_list(page: Page, table: Table) -> float:
    """Draw a table along the right edge, in as many columns as it needs; return its left end."""
    parts = max(1, math.ceil(len(table.rows) / _ROWS))
    width = _TABLE if parts == 1 else min(1.6 * _TABLE, page.width / 2)
    left = page.width - MARGIN - _PAD - width
    each = math.ceil(len(table.rows) / parts)
    room = page.height - 2 * MARGIN - BLOCK - 2 * _PAD
    for part in range(parts):
        rows = table.rows[part * each : (part + 1) * each]
        x = left + part * width / parts
        draw_table(
            page,
            Table(table.name if part == 0 else "", table.columns, rows),
            x,
            page.height - MARGIN - _PAD,
            width / parts - (2.0 if parts > 1 else 0.0),
            room,
            row=3.9,
        )
    return left - _PAD / 2
