"""A shell as a CadQuery assembly: one named, coloured part per panel."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import cadquery as cq

from ifs_cad.design.address import prefixes
from ifs_cad.elements.clash import require_disjoint
from ifs_cad.elements.element import Elements
from ifs_cad.elements.hole import HolePattern
from ifs_cad.errors import InputError
from ifs_cad.kernel.panels import LabelChoice, MadePanel, as_label, make_panels

STROKES_SUFFIX = "-strokes"
"""What the part that holds an address as wires adds to the name of its panel."""


def to_assembly(
    elements: Elements,
    *,
    label: LabelChoice = None,
    holes: HolePattern | None = None,
    nest: int = 0,
    name: str = "shell",
    validate: bool = True,
) -> cq.Assembly:
    """Return a shell, a vault or a wire frame as an assembly whose parts are named by address.

    Parameters
    ----------
    label : Label, "engraved", "wire" or None
        The address on each panel; wires become a part of their own beside it.
    holes : Holes or Screws, optional
    nest : int
        How many digits of the address group the panels into sub-assemblies; 0 is flat.
    name : str
        Of the whole assembly.
    validate : bool
        Check first that no two panels share volume.

    Returns
    -------
    cadquery.Assembly
        Each part is a solid that lies flat in its cutting frame (the marked face up, the corner of
        its bounding box at the origin), and a location that takes it to its place. It carries its
        panel's data in `metadata`: address, area (mm2), thickness (mm),
        volume (mm3), chamfer_angles (degrees) and neighbours, edge by edge, and the made `solid`.
        The assembly carries what it was made of as `elements`, `label` and `holes`.

    Raises
    ------
    SelfIntersectionError, ClashError
        Panels share volume.
    LabelError, HoleError
        A label or hole that does not fit.
    InputError
        `nest` is not a number of digits that the addresses have to spare.
    """
    groupings = _prefixes(elements.addresses, nest)
    if validate:
        require_disjoint(elements, elements.tol)
    red, green, blue = elements.material.colour
    colour = cq.Color(red, green, blue)
    chosen = as_label(label)
    origin = {"elements": elements, "label": chosen, "holes": holes}
    assembly = cq.Assembly(name=name, metadata=origin)
    groups: dict[tuple[str, ...], cq.Assembly] = {(): assembly}
    made = make_panels(elements, label=chosen, holes=holes)
    for address, prefix, part, data in zip(
        elements.addresses, groupings, made, elements.part_data(), strict=True
    ):
        group = _group(groups, prefix, name)
        data |= {"volume": part.volume, "solid": part.solid}
        _add(group, part.solid, part.location, address, colour, data)
        if part.strokes is not None:
            # without a colour: CadQuery cannot read coloured edges back from STEP
            _add(group, part.strokes, part.location, address + STROKES_SUFFIX, None, {})
    _register(assembly)
    return assembly


def extract(assembly: cq.Assembly, addresses: Collection[str]) -> cq.Assembly:
    """Return some parts of an assembly made by `to_assembly`, as they are, without groups."""
    part = cq.Assembly(name=assembly.name, metadata=assembly.metadata)
    for address in addresses:
        for name in (address, address + STROKES_SUFFIX):
            if name in assembly.objects:
                found = assembly.objects[name]
                _add(part, found.obj, found.loc, name, found.color, found.metadata)
    _register(part)
    return part


def modified_parts(assembly: cq.Assembly) -> list[str]:
    """Return the addresses of the parts whose shape is no longer the one made for the panel."""
    return [
        part.name
        for part in assembly.objects.values()
        if "solid" in part.metadata and not _same(part.obj, part.metadata["solid"])
    ]


def _same(shape: Any, made: cq.Solid) -> bool:
    return isinstance(shape, cq.Shape) and shape.isSame(made)


def _add(
    group: cq.Assembly,
    shape: Any,
    place: cq.Location,
    name: str,
    colour: cq.Color | None,
    data: dict[str, Any],
) -> None:
    """Append a part; `Assembly.add` would copy it and search all names each time."""
    part = cq.Assembly(shape, loc=place, name=name, color=colour, metadata=data)
    part.parent = group
    group.children.append(part)


def _group(
    groups: dict[tuple[str, ...], cq.Assembly], prefix: tuple[str, ...], name: str
) -> cq.Assembly:
    """Return the sub-assembly of a prefix, made with those around it when it is first needed."""
    if prefix not in groups:
        parent = _group(groups, prefix[:-1], name)
        group = cq.Assembly(name=f"{name}-{prefix[-1]}")
        group.parent = parent
        parent.children.append(group)
        groups[prefix] = group
    return groups[prefix]


def _register(assembly: cq.Assembly) -> dict[str, cq.Assembly]:
    """Fill in the names that each assembly knows of those below it."""
    for child in assembly.children:
        assembly.objects.update(_register(child))
    return assembly.objects


def _prefixes(addresses: Sequence[str], nest: int) -> list[tuple[str, ...]]:
    """Return for each element the growing prefixes that its groups are named by."""
    grown = [prefixes(address) for address in addresses]
    shortest = min(len(prefix) for prefix in grown)
    if not 0 <= nest < shortest:
        raise InputError(
            f"nest must be from 0 to {shortest - 1} for addresses like {addresses[0]}, got {nest}."
        )
    return [tuple(prefix[:nest]) for prefix in grown]


__all__ = ["STROKES_SUFFIX", "MadePanel", "modified_parts", "to_assembly"]
