"""Whether cutters and holders keep clear of workpieces and clamps.

Cutters are flat-ended cylinders up to their holders. A motion up the axis of its tool cuts nothing
new; a motion that makes a hole or a stroke may enter the workpiece that has it.
"""

from __future__ import annotations

import numpy as np

from ifs_cad.fabrication.machining.cuts import Cuts
from ifs_cad.fabrication.machining.fault import Fault
from ifs_cad.fabrication.machining.machine import Machine
from ifs_cad.fabrication.machining.motions import Program
from ifs_cad.fabrication.machining.placed import PlacedSheet
from ifs_cad.fabrication.machining.swept import Solids, depths
from ifs_cad.tolerance import Tolerance
from ifs_cad.types import BoolArray, FloatArray, IntArray


def verify_clearance(
    program: Program,
    cuts: Cuts,
    sheet: PlacedSheet,
    machine: Machine,
    makes: BoolArray,
    tol: Tolerance,
) -> list[Fault]:
    """Return where a tool enters a workpiece that it should not, or meets a clamp.

    Parameters
    ----------
    makes : (n, p) bool, which motions make holes and strokes of which workpieces
    """
    moving = np.flatnonzero(cuts.steady & (cuts.along_axis != 1))
    low = moving[cuts.lowest[moving] < sheet.thickness - tol.machined]
    motions, pieces, deep = _entered(cuts, low, sheet.solids, tol)
    gouges = ~makes[motions, pieces]
    faults = _gouges(program, cuts, sheet, motions[gouges], pieces[gouges], deep[gouges])
    if machine.clamps:
        clamps = np.array([[clamp.x, clamp.y, clamp.z] for clamp in machine.clamps])
        boxes = Solids.boxes(clamps[..., 0], clamps[..., 1])
        placed = np.flatnonzero(cuts.placed)
        motions, which, deep = _entered(cuts, placed, boxes, tol)
        held, clamped, by = depths(cuts.holder_sweeps(placed), boxes, tol.machined)
        for name, rows in (
            ("tool", (motions, which, deep)),
            ("holder", (placed[held], clamped, by)),
        ):
            faults += _clamped(program, cuts, name, *rows)
    return faults


def _entered(
    cuts: Cuts, which: IntArray, solids: Solids, tol: Tolerance
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return motions, the solids that their cutters enter, and how deep."""
    owners, sweeps = cuts.sweeps(which)
    first, second, deep = depths(sweeps, solids, tol.machined)
    return owners[first], second, deep


def _gouges(
    program: Program,
    cuts: Cuts,
    sheet: PlacedSheet,
    motions: IntArray,
    pieces: IntArray,
    deep: FloatArray,
) -> list[Fault]:
    """Return one fault for each motion and workpiece, with the deepest cut of an arc."""
    order = np.lexsort((-deep, pieces, motions))
    pairs = np.stack([motions[order], pieces[order]], axis=1)
    _, firsts = np.unique(pairs, axis=0, return_index=True)
    return [
        Fault(
            int(cuts.motions.lines[motions[k]]),
            sheet.addresses[pieces[k]],
            f"The tool cuts {deep[k]:.4f} mm into the workpiece.",
        )
        for k in order[firsts].tolist()
    ]


def _clamped(
    program: Program,
    cuts: Cuts,
    name: str,
    motions: IntArray,
    clamps: IntArray,
    deep: FloatArray,
) -> list[Fault]:
    """Return one fault for each clamp that is hit, at the first line."""
    faults = []
    for clamp in np.unique(clamps).tolist():
        hits = np.flatnonzero(clamps == clamp)
        first = hits[np.argmin(motions[hits])]
        line = int(cuts.motions.lines[motions[first]])
        faults.append(
            Fault(
                line,
                program.address_at(line),
                f"The {name} hits clamp {clamp + 1} by {deep[first]:.3f} mm.",
            )
        )
    return faults
