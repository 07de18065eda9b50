"""Whether holes, strokes and sides are made with tools of the kinds that are for them."""

from __future__ import annotations

from collections.abc import Container

import numpy as np

from ifs_cad.fabrication.machining.cuts import Cuts
from ifs_cad.fabrication.machining.fault import Fault
from ifs_cad.fabrication.machining.motions import Program
from ifs_cad.fabrication.machining.tool import Tool, ToolKind
from ifs_cad.types import IntArray


def wrong_kinds(
    program: Program,
    cuts: Cuts,
    motions: IntArray,
    tools: dict[int, Tool],
    kinds: Container[ToolKind],
    message: str,
) -> list[Fault]:
    """Return the faults of motions made by other kinds of tools, one for each tool.

    Parameters
    ----------
    motions : (k,) int, what is made
    kinds : those that may make it
    message : str, with `{tool}` for the name of the tool
    """
    numbers, firsts = np.unique(cuts.motions.tools[motions], return_index=True)
    return [
        Fault(
            line := int(cuts.motions.lines[motions[first]]),
            program.address_at(line),
            message.format(tool=tools[number]),
        )
        for number, first in zip(numbers.tolist(), firsts.tolist(), strict=True)
        if tools[number].kind not in kinds
    ]
