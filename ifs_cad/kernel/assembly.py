"""A shell as a CadQuery assembly: one named, coloured part per panel."""

from __future__ import annotations

from typing import Any

import cadquery as cq

from ifs_cad.design.address import digits
from ifs_cad.elements.clash import require_disjoint
from ifs_cad.elements.hole import Holes
from ifs_cad.elements.panel import Shell
from ifs_cad.errors import InputError
from ifs_cad.kernel.panels import LabelChoice, MadePanel, make_panels

STROKES_SUFFIX = "-strokes"
"""What the part that holds an address as wires adds to the name of its panel."""

INK = cq.Color(0.1, 0.1, 0.1)


def to_assembly(
    shell: Shell,
    *,
    label: LabelChoice = None,
    holes: Holes | None = None,
    nest: int = 0,
    name: str = "shell",
    validate: bool = True,
) -> cq.Assembly:
    """Return a shell as an assembly whose parts are named by the panels' addresses.

    Parameters
    ----------
    label : Label, "engraved", "wire" or None
        The address on each panel; wires become a part of their own beside it.
    holes : Holes, optional
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
        The assembly carries the `shell`.

    Raises
    ------
    SelfIntersectionError, ClashError
        Panels share volume.
    LabelError, HoleError
        A label or hole that does not fit.
    InputError
        `nest` is not a number of digits that the addresses have to spare.
    """
    prefixes = _prefixes(shell, nest)
    if validate:
        require_disjoint(shell, shell.mesh.tol)
    red, green, blue = shell.thickening.material.colour
    colour = cq.Color(red, green, blue)
    assembly = cq.Assembly(name=name, metadata={"shell": shell})
    groups: dict[tuple[str, ...], cq.Assembly] = {(): assembly}
    made = make_panels(shell, label=label, holes=holes)
    for address, prefix, part, data in zip(
        shell.addresses, prefixes, made, _panel_data(shell), strict=True
    ):
        group = _group(groups, prefix, name)
        data |= {"volume": part.volume, "solid": part.solid}
        _add(group, part.solid, part.location, address, colour, data)
        if part.strokes is not None:
            _add(group, part.strokes, part.location, address + STROKES_SUFFIX, INK, {})
    _register(assembly)
    return assembly


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
    shape: cq.Shape,
    place: cq.Location,
    name: str,
    colour: cq.Color,
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


def _prefixes(shell: Shell, nest: int) -> list[tuple[str, ...]]:
    """Return for each panel the growing prefixes that its groups are named by."""
    words = [digits(address) for address in shell.addresses]
    shortest = min(len(word) for word in words)
    if not 0 <= nest < shortest:
        raise InputError(
            f"nest must be from 0 to {shortest - 1} for addresses like {shell.addresses[0]}, "
            f"got {nest}."
        )
    join = "." if "." in shell.addresses[0] else ""
    return [tuple(join.join(word[: k + 1]) for k in range(nest)) for word in words]


def _panel_data(shell: Shell) -> list[dict[str, Any]]:
    mesh = shell.mesh
    angles = shell.chamfer_angles.tolist()
    return [
        {
            "address": address,
            "thickness": shell.thickness,
            "area": area,
            "mass": mass,
            "chamfer_angles": angles[mesh.offsets[face] : mesh.offsets[face + 1]],
            "neighbours": mesh.neighbours(face),
        }
        for address, area, mass, face in zip(
            shell.addresses,
            shell.areas.tolist(),
            shell.masses.tolist(),
            shell.faces.tolist(),
            strict=True,
        )
    ]


__all__ = ["STROKES_SUFFIX", "MadePanel", "modified_parts", "to_assembly"]
