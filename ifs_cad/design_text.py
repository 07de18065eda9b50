"""The text of a design file: TOML with a comment for what its name does not tell."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import tomlkit
from tomlkit.items import Array, Item, Table

__all__ = ["text_of"]

HEADER = """\
A shell made from two curves, for ifs-cad: `ifs-cad build` makes it, `ifs-cad studio` edits it.
Lengths in mm, angles in degrees; weights have no unit. What is left out has its default."""

COMMENTS = {
    ("thickness",): "of the sheet, mm",
    ("side",): '"outer", "inner" or "centre": where panels lie about the surface',
    ("nodes",): '"relief", "axis" or "plain": how panels keep clear of each other at nodes',
    ("clearance",): "how far each chamfer is set back, mm",
    ("floor",): "height of the floor that trims the panels, mm; leave out for none",
    ("nest",): "digits of the address that group panels into sub-assemblies",
    ("depth",): "construction steps",
    ("transformations",): "parts that a step makes of each piece",
    ("closed",): "come back to the first control point",
    ("symmetric",): "tie subdivision points to their mirror images",
    ("roughness",): "from -1/3 to 1, of the subdivision points that are not moved",
    ("fold",): "slope of an even fold, rise over run; leave out for none",
    ("control_points",): "x, y, z",
    ("weights",): "of the control points",
    ("fibre", "curve"): '"long", "a" or "b"',
    ("fibre", "tolerance"): "how far a panel may be turned off it on its sheet, degrees",
    ("fibre", "half_turn"): "whether a panel may lie the other way round",
    ("label", "depth"): "of the groove, mm",
    ("label", "cutter"): "diameter, mm",
    ("label", "margin"): "least distance from sides and holes, mm",
    ("label", "height"): "largest cap height, mm",
    ("label", "min_height"): "smallest cap height, mm; 0 for what the cutter allows",
    ("label", "up"): "direction that labels point to",
    ("holes", "diameter"): "mm",
    ("holes", "inset"): "distance of the axis from the two sides of its corner, mm",
    ("holes", "fewest"): "that a panel must have room for",
}
TITLES = {
    "a": "the first curve",
    "b": "the second curve",
    "moved": "subdivision points that were moved",
    "fibre": "direction of the outer plies",
    "label": "the address on each panel",
    "holes": "through-holes in the corners of each panel",
}


def text_of(tables: Mapping[str, Any]) -> str:
    """Return tables of plain values as the text of a design file."""
    document = tomlkit.document()
    for line in HEADER.splitlines():
        document.add(tomlkit.comment(line))
    document.add(tomlkit.nl())
    order = ("version", "title", *tables)  # what a reader looks for first
    for key in dict.fromkeys(key for key in order if key in tables):
        if not isinstance(tables[key], dict):
            document.add(key, _commented(tables[key], key, ()))
    for key, value in tables.items():
        if isinstance(value, dict):
            document.add(tomlkit.nl())
            document.add(key, _table(value, (key,)))
    return tomlkit.dumps(document)


def _table(values: Mapping[str, Any], place: tuple[str, ...]) -> Table:
    table = tomlkit.table()
    table.comment(TITLES[place[-1]])
    for key, value in values.items():
        if not isinstance(value, dict):
            table.add(key, _commented(value, key, place))
    for key, value in values.items():
        if isinstance(value, dict) and value:
            inner = tomlkit.table()
            inner.comment(TITLES[key])
            for name, row in value.items():
                line = tomlkit.inline_table()
                line.update(row)
                inner.add(name, line)
            table.add(tomlkit.nl())
            table.add(key, inner)
    return table


def _commented(value: Any, key: str, place: tuple[str, ...]) -> Item:
    """Return a value with its comment; points stand one below the other."""
    item: Item = tomlkit.item(value)
    if isinstance(item, Array) and value and isinstance(value[0], list):
        item.multiline(True)
    curve = place in (("a",), ("b",))
    comment = COMMENTS.get((key,) if curve or not place else (*place, key))
    return item.comment(comment) if comment else item
