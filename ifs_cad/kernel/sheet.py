"""A nested sheet as an assembly: the panels of a shell lying in place, as they are cut.

Source: section 4.3 (multi-part plates).
"""

from __future__ import annotations

import cadquery as cq
import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.errors import InputError
from ifs_cad.fabrication.layout import NestedSheet, Placement
from ifs_cad.kernel.assembly import STROKES_SUFFIX
from ifs_cad.kernel.solid import location


def sheet_assembly(sheet: NestedSheet, assembly: cq.Assembly) -> cq.Assembly:
    """Return the parts of one sheet, lying in place.

    The marked face lies on top, z up from 0 on the table, the origin at the lower left corner of
    the sheet. A part that the user modified is placed as it is now; an address that is drawn as
    wires comes along.

    Parameters
    ----------
    sheet : NestedSheet
        Made of workpieces that lie as the parts do: with the same label as the assembly.
    assembly : cadquery.Assembly, made by `to_assembly`

    Returns
    -------
    cadquery.Assembly
        Named as the sheet, its parts as in the given assembly, in their colours, with their
        metadata.

    Raises
    ------
    InputError
        A part on the sheet is not in the assembly.
    """
    parts = assembly.objects
    missing = [place.address for place in sheet.placements if place.address not in parts]
    if missing:
        raise InputError(
            f"{sheet.name} holds {listed(missing)}, but the assembly has no such parts. Nest only "
            "what is in the assembly.",
            addresses=missing,
        )
    laid = cq.Assembly(name=sheet.name)
    for placement in sheet.placements:
        for name in (placement.address, placement.address + STROKES_SUFFIX):
            if name in parts:
                part = parts[name]
                laid.add(
                    part.obj,
                    loc=_location(placement),
                    name=name,
                    color=part.color,
                    metadata=part.metadata,
                )
    return laid


def _location(placement: Placement) -> cq.Location:
    axes, origin = np.eye(3), np.array([placement.x, placement.y, 0.0])
    axes[:2, :2] = placement.rotation.T
    return cq.Location(location(axes, origin))
