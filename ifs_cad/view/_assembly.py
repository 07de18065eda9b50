"""What can be looked at: the one conversion that `preview` and `render` share."""

from __future__ import annotations

from typing import Any

import cadquery as cq
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer

from ifs_cad.errors import InputError

Part = tuple[cq.Shape, cq.Color | None]


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
    if not parts(assembly):
        raise InputError(
            f"There is nothing to look at in this {type(thing).__name__}: no face and no edge."
        )
    return assembly


def parts(assembly: cq.Assembly) -> list[Part]:
    """List the shapes of an assembly where they stand, each with its colour (None: not given)."""
    return [
        (shape.moved(location), color)
        for shape, _, location, color in assembly
        if TopExp_Explorer(shape.wrapped, TopAbs_ShapeEnum.TopAbs_EDGE).More()
    ]


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
