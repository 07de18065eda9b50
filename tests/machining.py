"""Sheets to cut, and what cutters leave of them: shared by the tests of tool paths and programs."""

from __future__ import annotations

from functools import cache

import numpy as np

import ifs_cad as ifs
from ifs_cad.elements.hole import Holes
from ifs_cad.elements.label import Label
from ifs_cad.elements.material import SPRUCE, SPRUCE_PLYWOOD
from ifs_cad.elements.screw import Screws
from ifs_cad.errors import IfsCadError
from ifs_cad.fabrication.layout import NestedSheet, Placement
from ifs_cad.fabrication.machining.router import read_router
from ifs_cad.fabrication.machining.sweep import contour_reach
from ifs_cad.fabrication.nesting.nest import nest
from ifs_cad.fabrication.operations import workpieces
from ifs_cad.fabrication.stock import Sheet

ROUTER = read_router()
TOOLS, MACHINE = ROUTER.tools, ROUTER.machine
BY_NUMBER = {tool.number: tool for tool in TOOLS}
THIN = next(tool for tool in TOOLS if tool.kind == "end mill")


@cache
def prototype():
    """Return the paper's second prototype as workpieces, and the sheets they are nested on."""
    base = ifs.Curve([(0, 0, 0), (0, 1650, 300), (0, 3000, -60)], depth=3)
    fold = base.with_roughness(0.25).with_even_fold(0.85)
    foot = -fold.points[:, 2].max() - 60.0
    arch = ifs.Curve([(0, 0, foot), (-225, 0, 2623), (4275, 0, 2924), (4500, 0, foot)], depth=4)
    shell = ifs.thicken(
        ifs.vector_sum(arch, fold), 10.0, side="outer", floor=ifs.Plane((0, 0, 0), (0, 0, 1))
    )
    pieces = workpieces(shell, label=Label(), holes=Holes(5.0, 25.0))
    stock = Sheet("spruce", 2500.0, 1250.0, 10.0, SPRUCE_PLYWOOD)
    return pieces, nest(pieces, [stock], spacing=20.0, margin=15.0).sheets


@cache
def planks():
    """Return the planks of a small vault on wide sheets."""
    curve = ifs.Curve([(0, 0, 0), (100, 0, 1500), (2300, 0, 1700), (2400, 0, 0)], depth=2)
    vault = ifs.vault(
        curve, 160.0, 40.0, layers=3, stagger=True, springing=ifs.Plane((0, 0, 0), (0, 0, 1))
    )
    pieces = workpieces(vault, label=Label(), holes=Screws(6.0, spacing=350.0))
    stock = Sheet("spruce", 4000.0, 1250.0, 40.0, SPRUCE)
    return pieces, nest(pieces, [stock], spacing=60.0, margin=30.0).sheets


def random_shell(seed: int):
    """Return workpieces and sheets of a random shell, reliefs and floors among them.

    None where the design itself is refused, or a side lies flatter than the head tilts.
    """
    random = np.random.default_rng(seed)
    first, second = (
        np.cumsum(
            np.column_stack(
                [random.uniform(120, 350, count), *random.uniform(-75, 75, (2, count))]
            ),
            axis=0,
        )
        for count in (4, 3)
    )
    thickness = float(random.choice([6.0, 10.0, 18.0]))
    try:
        floor = None
        mesh = ifs.vector_sum(first, second[:, [1, 0, 2]])
        if seed % 3 == 0:
            low = mesh.vertices[:, 2].min()
            floor = ifs.Plane((0, 0, low + 25.0), (*random.uniform(-0.1, 0.1, 2), 1.0))
        shell = ifs.thicken(
            mesh,
            thickness,
            side=str(random.choice(["outer", "inner", "centre"])),
            clearance=float(random.choice([0.0, 0.2])),
            floor=floor,
        )
        pieces = workpieces(shell, label=Label(cutter=2.0), holes=Holes(4.0, 15.0))
    except IfsCadError:
        return None
    if max(abs(side.inclination) for piece in pieces for side in piece.sides) > 59.0:
        return None
    stock = Sheet("large", 2500.0, 1600.0, thickness, SPRUCE_PLYWOOD)
    mill = next(t for t in TOOLS if t.kind == "end mill" and t.flank > thickness * 2)
    spacing = 2 * contour_reach(pieces, mill) + 4
    return pieces, nest(pieces, [stock], spacing=spacing, margin=20.0).sheets


def alone(piece, thickness=None, turn=0.0, material=SPRUCE_PLYWOOD) -> NestedSheet:
    """Return a sheet that holds one piece."""
    stock = Sheet("one", 2500.0, 1250.0, thickness or piece.thickness, material)
    return NestedSheet(
        1, stock, (Placement(piece.address, turn, 700.0, 500.0),), 0.0, np.empty((0, 4))
    )


def placed_sides(pieces, sheet):
    """Yield address, number from 1, side, normal and corners of every side on a sheet."""
    by_address = {piece.address: piece for piece in pieces}
    for placement in sheet.placements:
        turn = np.eye(3)
        turn[:2, :2] = placement.rotation
        for number, side in enumerate(by_address[placement.address].sides, 1):
            yield placement.address, number, side, turn @ side.normal, placement(side.corners)


def inside_swept(points, moves, radius):
    """Tell which of (n, 3) points a flat cutter passes over, moves with one axis each.

    Moves that turn the tool are left out: they are high above everything.
    """
    inside = np.zeros(len(points), dtype=bool)
    for k in range(1, len(moves)):
        axis, start, stop = moves.axes[k], moves.tips[k - 1], moves.tips[k]
        if not np.array_equal(axis, moves.axes[k - 1]):
            continue
        if np.abs(np.cross(stop - start, axis)).max() < 1e-9:  # along the tool: the lower end
            start = stop = start if (start - stop) @ axis < 0 else stop
        rest = points - start
        height = rest @ axis
        flat = rest - height[:, None] * axis
        way = stop - start
        share = np.clip(flat @ way / max(way @ way, 1e-30), 0.0, 1.0)
        off = np.linalg.norm(flat - share[:, None] * way, axis=1)
        inside |= (off < radius) & (height > 0.0)
    return inside
