"""Volumes that simulation removes, against areas of slots computed height by height by shapely."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import shapely
from machining import MACHINE, TOOLS, planks, prototype

from ifs_cad.export.gcode import gcode
from ifs_cad.fabrication.machining.convention import LINUXCNC
from ifs_cad.fabrication.machining.cuts import cuts_of
from ifs_cad.fabrication.machining.placed import placed_sheet
from ifs_cad.fabrication.machining.program_reader import read_program
from ifs_cad.fabrication.machining.settings import Settings
from ifs_cad.fabrication.machining.simulate import simulate
from ifs_cad.fabrication.machining.toolpath import toolpaths
from ifs_cad.fabrication.machining.verify import verify
from ifs_cad.tolerance import DEFAULT

FREE = Settings(hold="none")
AROUND = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)


def slice_of(tip, axis, radius, z):
    """Return the section of a flat cutter at one height: an ellipse, cut off by its end."""
    ring = np.stack([np.cos(AROUND), np.sin(AROUND)], axis=1) * radius
    lean = axis[:2] / axis[2]
    level = np.linalg.norm(axis[:2])
    if level > 0:
        along = axis[:2] / level
        ring = ring + np.outer(ring @ along, along) * (1.0 / axis[2] - 1.0)
    ring = ring + tip[:2] + lean * (z - tip[2])
    heights = (ring - tip[:2]) @ axis[:2] + (z - tip[2]) * axis[2]
    kept = ring[heights >= 0.0]
    # where the end cuts the ring
    for k in np.flatnonzero((heights >= 0.0) != (np.roll(heights, -1) >= 0.0)):
        after = (k + 1) % len(ring)
        share = heights[k] / (heights[k] - heights[after])
        kept = np.vstack([kept, ring[k] + share * (ring[after] - ring[k])])
    return kept


def removed_by_layers(program, layer):
    """Return the volume that feeding motions take from a sheet, mm3; all are level or upright."""
    stock = program.sheet.stock
    area = shapely.box(0, 0, stock.length, stock.width)
    volume = 0.0
    for z in np.arange(layer / 2, stock.thickness, layer):
        slots = []
        for step in program.steps:
            moves, radius = step.moves, step.tool.diameter / 2.0
            for k in np.flatnonzero(~moves.is_rapid):
                start, end, axis = moves.tips[k - 1], moves.tips[k], moves.axes[k]
                ways = [start, end]
                if moves.bulges[k]:
                    sweep = 4 * np.arctan(moves.bulges[k])
                    chord = complex(*(end - start)[:2])
                    centre = complex(*start[:2]) + chord / (1 - np.exp(1j * sweep))
                    turned = centre + (complex(*start[:2]) - centre) * np.exp(
                        1j * sweep * np.linspace(0, 1, 9)
                    )
                    ways = np.stack([turned.real, turned.imag, np.full(9, end[2])], axis=1)
                sections = [slice_of(np.array(way), axis, radius, z) for way in ways]
                for one, other in pairwise(sections):
                    both = np.vstack([one, other])
                    if len(both) > 2:
                        slots.append(shapely.MultiPoint(both).convex_hull)
        volume += shapely.union_all(slots).intersection(area).area * layer
    return volume


@pytest.mark.parametrize(("made", "number"), [(prototype, -1), (planks, -1)])
def test_simulation_removes_what_is_computed(made, number):
    pieces, sheets = made()
    sheet = sheets[number]
    program = toolpaths(sheet, pieces, TOOLS, MACHINE, FREE)
    by_address = {piece.address: piece for piece in pieces}
    placed = placed_sheet(sheet, by_address, FREE.stroke_depth)
    cuts = cuts_of(read_program(gcode(program)).motions, TOOLS, LINUXCNC, DEFAULT)
    nothing = np.zeros((len(cuts), len(sheet.placements)), dtype=bool)
    layer = sheet.stock.thickness / 7.0  # none of them lies at the depth of the engraving
    removed = simulate(cuts, placed, nothing, 0.0, grid=1.0, layer=layer).removed
    assert removed == pytest.approx(removed_by_layers(program, layer), rel=2e-3)


def test_every_sheet_of_the_vault_is_verified():
    """Their holes are deep enough to be drilled in pecks, between which the drill comes back."""
    pieces, sheets = planks()
    for sheet in sheets:
        text = gcode(toolpaths(sheet, pieces, TOOLS, MACHINE))
        assert "G83" in text
        found = verify(text, sheet, pieces, TOOLS, MACHINE, settings=Settings(), simulate=False)
        assert found.ok, str(found)
