"""What can be looked at: the one conversion that `preview` and `render` share."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import cadquery as cq
import numpy as np
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer

from ifs_cad.elements.colouring import Colouring
from ifs_cad.elements.element import Elements
from ifs_cad.elements.explosion import Explode, explosion
from ifs_cad.errors import InputError
from ifs_cad.types import FloatArray
from ifs_cad.view.quantity import colouring

Part = tuple[cq.Shape, cq.Color | None]
MATERIAL = "material"
"""The colouring that leaves parts as they are."""


@dataclass(frozen=True, eq=False)
class Group:
    """An assembly made of elements, as it is looked at.

    Attributes
    ----------
    assembly : cadquery Assembly, in which parts are named by address
    place : cadquery Location, of its coordinates in the whole
    elements : Elements
    shifts : (p, 3) float, how far each part was moved apart, mm
    colouring : Colouring, or None: parts have their own colours
    """

    assembly: cq.Assembly
    place: cq.Location
    elements: Elements
    shifts: FloatArray
    colouring: Colouring | None = None


@dataclass(frozen=True, eq=False)
class View:
    """A model as it is looked at.

    Attributes
    ----------
    assembly : cadquery Assembly
    groups : tuple of Group, its sub-assemblies that were made of elements
    """

    assembly: cq.Assembly
    groups: tuple[Group, ...]

    @property
    def legend(self) -> Colouring | None:
        """What colours mean, None without a quantity."""
        return self.groups[0].colouring if self.groups else None


def viewable(thing: Any) -> cq.Assembly:
    """Return a thing as an assembly.

    Parameters
    ----------
    thing : cadquery.Assembly, cadquery.Workplane, cadquery.Shape, Shell, Vault or WireFrame
        An assembly is returned as it is; of a shell every panel becomes a part.

    Raises
    ------
    InputError
        Anything else, or nothing in it.
    """
    if isinstance(thing, cq.Assembly):
        assembly = thing
    elif isinstance(thing, cq.Workplane | cq.Shape):
        assembly = cq.Assembly(thing)
    else:
        assembly = _shell_assembly(thing)
    if not any(_has_edge(shape) for shape, *_ in assembly):
        raise InputError(
            f"There is nothing to look at in this {type(thing).__name__}: no face and no edge."
        )
    return assembly


def view_of(thing: Any, colour: str | Colouring = MATERIAL, explode: Explode = 0.0) -> View:
    """Return a thing coloured and moved apart; the thing itself stays as it is.

    Parameters
    ----------
    thing : as for `viewable`
    colour : str or Colouring
        "material", or a quantity of `colouring`.
    explode : float or sequence of float, see `explosion`

    Raises
    ------
    InputError
        Colours or an exploded view of something that was not made of elements.
    """
    assembly = viewable(thing)
    is_exploded = bool(np.any(explode))
    if colour == MATERIAL and not is_exploded:
        return View(assembly, tuple(_group(*found, 0.0) for found in _groups(assembly)))
    assembly = _copy(assembly)
    groups = [_group(one, place, explode) for one, place in _groups(assembly)]
    if not groups:
        raise InputError(
            "Only panels and planks are coloured by a quantity or moved apart: give a shell, or "
            "what to_assembly makes of it."
        )
    if colour != MATERIAL:
        groups = _coloured(groups, colour)
    for group in groups:
        _dress(group)
    return View(assembly, tuple(groups))


def parts(assembly: cq.Assembly) -> list[Part]:
    """List the shapes of an assembly where they stand, each with its colour (None: not given)."""
    return [
        (shape.moved(location), color) for shape, _, location, color in assembly if _has_edge(shape)
    ]


def numbered_parts(group: Group) -> Iterator[tuple[int, cq.Assembly]]:
    """Yield the parts of a group's elements, and those of their strokes, with their numbers."""
    from ifs_cad.kernel.assembly import STROKES_SUFFIX

    number = {address: k for k, address in enumerate(group.elements.addresses)}

    def walk(assembly: cq.Assembly) -> Iterator[tuple[int, cq.Assembly]]:
        for part in assembly.children:
            name = str(part.name).removesuffix(STROKES_SUFFIX)
            if name in number and part.obj is not None:
                yield number[name], part
            yield from walk(part)

    return walk(group.assembly)


def _has_edge(shape: cq.Shape) -> bool:
    return bool(TopExp_Explorer(shape.wrapped, TopAbs_ShapeEnum.TopAbs_EDGE).More())


def _copy(assembly: cq.Assembly) -> cq.Assembly:
    """Return an assembly of the same shapes; `Assembly.add` would search all names each time."""
    made = cq.Assembly(
        assembly.obj,
        loc=assembly.loc,
        name=assembly.name,
        color=assembly.color,
        metadata=assembly.metadata,
    )
    for child in assembly.children:
        copied = _copy(child)
        copied.parent = made
        made.children.append(copied)
        made.objects.update(copied.objects)
    return made


def _groups(
    assembly: cq.Assembly, place: cq.Location | None = None
) -> list[tuple[cq.Assembly, cq.Location]]:
    here = assembly.loc if place is None else place * assembly.loc
    if "elements" in assembly.metadata:
        return [(assembly, here)]
    return [found for child in assembly.children for found in _groups(child, here)]


def _group(assembly: cq.Assembly, place: cq.Location, explode: Explode) -> Group:
    elements = assembly.metadata["elements"]
    return Group(assembly, place, elements, explosion(elements, explode))


def _coloured(groups: list[Group], colour: str | Colouring) -> list[Group]:
    """Give all groups one scale of colours."""
    if len(groups) == 1:
        group = groups[0]
        given = colour if isinstance(colour, Colouring) else _worked_out(group, colour)
        if len(given.values) != len(group.elements):
            raise InputError(
                f"{len(group.elements)} elements need as many values of {given.title}, got "
                f"{len(given.values)}."
            )
        return [replace(group, colouring=given)]
    if isinstance(colour, Colouring):
        raise InputError(f"Values were given for one shell, but there are {len(groups)}.")
    each = [_worked_out(group, colour) for group in groups]
    if any(one.names for one in each):
        raise InputError(f"{colour} colours one shell at a time, but there are {len(groups)}.")
    low, high = min(one.range[0] for one in each), max(one.range[1] for one in each)
    return [
        replace(group, colouring=replace(one, low=low, high=high))
        for group, one in zip(groups, each, strict=True)
    ]


def _worked_out(group: Group, quantity: str) -> Colouring:
    data = group.assembly.metadata
    return colouring(group.elements, quantity, label=data.get("label"), holes=data.get("holes"))


def _dress(group: Group) -> None:
    """Move and colour the parts of a copied assembly."""
    colours = None if group.colouring is None else group.colouring.colours / 255.0
    for number, part in numbered_parts(group):
        shift = group.shifts[number]
        if shift.any():
            part.loc = cq.Location(tuple(shift.tolist())) * part.loc
        if colours is not None and _is_solid(part):
            part.color = cq.Color(*colours[number].tolist())


def _is_solid(part: cq.Assembly) -> bool:
    return "address" in part.metadata


def _shell_assembly(thing: Any) -> cq.Assembly:
    # only a shell needs the rooms that make solids of it
    from ifs_cad.elements.beam import WireFrame
    from ifs_cad.elements.panel import Shell
    from ifs_cad.elements.vault import Vault

    if not isinstance(thing, Shell | Vault | WireFrame):
        raise InputError(
            "Only a cadquery Assembly, Workplane or Shape, or a shell can be looked at, "
            f"not a {type(thing).__name__}."
        )
    from ifs_cad.kernel.assembly import to_assembly

    return to_assembly(thing)
