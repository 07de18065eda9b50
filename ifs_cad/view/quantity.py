"""Elements coloured by what has to be worked out first: their sheets, how they carry a load."""

from __future__ import annotations

from typing import Any

import numpy as np

from ifs_cad import progress
from ifs_cad.elements.colouring import OF_SHAPE, Colouring, by_shape, numbered
from ifs_cad.elements.element import Elements
from ifs_cad.elements.panel import Shell
from ifs_cad.errors import InputError

LOAD = 1500.0
"""Of the ground plan, N/m2, when a utilisation or deflection is asked for without a result."""

QUANTITIES = (*OF_SHAPE, "sheet", "utilisation", "deflection")


def colouring(
    elements: Elements,
    quantity: str,
    *,
    layout: Any = None,
    result: Any = None,
    label: Any = None,
    holes: Any = None,
) -> Colouring:
    """Return elements coloured by a quantity.

    Parameters
    ----------
    elements : Shell, Vault or WireFrame
    quantity : str
        "chamfer" (the steepest of each element, degrees), "area" (of the largest face, m2),
        "length" (of the longest edge, mm), "mass" (kg), "planarity" (how far corners lie out of
        plane, mm), "sheet" (or board, that each is cut from), "utilisation" (of the strength) or
        "deflection" (the largest `|u_z|` of each panel, mm).
    layout : Layout, optional
        Of "sheet"; without it the elements are nested on the common sheets or boards.
    result : Result, optional
        Of "utilisation" and "deflection"; without it the shell stands on its lowest border and
        carries 1500 N/m2 of its ground plan.
    label, holes : optional
        What `to_assembly` was told; a nesting turns the engraved face up.

    Raises
    ------
    InputError
        There is no such quantity of such elements.
    StockError, MechanismError, MissingLibraryError, ...
        Whatever working it out meets.
    """
    if quantity in OF_SHAPE:
        return by_shape(elements, quantity)
    if quantity == "sheet":
        homes = (layout or _layout(elements, label, holes)).homes
        places = [homes.get(address) for address in elements.addresses]
        of_element = [place and place[0].name for place in places]
        return numbered(f"{elements.cut_from[:-1]}", of_element)
    if quantity not in QUANTITIES:
        raise InputError(
            f"Nothing is coloured by {quantity!r}. Choose among {', '.join(QUANTITIES)}."
        )
    if not isinstance(elements, Shell):
        raise InputError(
            f"Only shells are analysed, so a {type(elements).__name__} has no {quantity}."
        )
    result = result or _result(elements)
    if quantity == "deflection":
        return Colouring("deflection |u_z|, mm", result.deflections)
    used = result.utilisation
    if np.isnan(used).all():
        raise InputError(
            f"The strength of {elements.material.name} is not known, so nor is the utilisation."
        )
    return Colouring("utilisation of the strength", used, low=0.0)


def _layout(elements: Elements, label: Any, holes: Any) -> Any:
    from ifs_cad.fabrication.operations import workpieces
    from ifs_cad.fabrication.plan import make_plan
    from ifs_cad.fabrication.workshop import Workshop

    progress.report("nesting" if elements.cut_from == "sheets" else "cutting boards")
    pieces = workpieces(elements, label=label, holes=holes)
    return make_plan(elements, pieces, Workshop(), None if label is None else label.face).layout


def _result(shell: Shell) -> Any:
    from ifs_cad.structure.analyse import analyse
    from ifs_cad.structure.load import AreaLoad

    progress.report("analysing the structure")
    return analyse(shell, loads=AreaLoad(pressure=LOAD))
