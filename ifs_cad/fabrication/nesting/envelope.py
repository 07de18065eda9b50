"""What a tilted cutter sweeps: how far beyond the silhouette, and how deep below the sheet.

A side is cut by the flank of a cylindrical cutter that touches it from outside, its axis in
parallel to the side and square to the edge. The line of contact ends at the cutter's tip, the
*breakthrough* below the sheet. The tip is a disc square to the axis, so the far rim of it lies

- deeper than the line of contact, where the workpiece is wider at its top,
- higher, where it is wider at its bottom.

Spacing between workpieces and the thickness of the spoilboard follow from these, not from the
diameter. What overruns the ends of an edge is the tool path's to know.

Source: section 4.3 (the contour cut with the chamfer of each edge).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ifs_cad.errors import InputError
from ifs_cad.fabrication.workpiece import Workpiece


@dataclass(frozen=True)
class SweptReach:
    """How far a cutter reaches around a workpiece.

    Attributes
    ----------
    beyond : float, beyond the silhouette, between the two faces of the sheet, mm
    below : float, below the lower face of the sheet, mm
    """

    beyond: float
    below: float


def clearance_reach(
    workpiece: Workpiece, cutter_diameter: float, breakthrough: float
) -> SweptReach:
    """Return how far the flank cutter reaches around a workpiece, the most of all its sides.

    Parameters
    ----------
    workpiece : Workpiece
    cutter_diameter : float, mm
    breakthrough : float, how far below the sheet the line of contact ends, mm

    Raises
    ------
    InputError
        A diameter that is not positive, or a negative breakthrough.
    """
    if not 0.0 < cutter_diameter < np.inf:
        raise InputError(f"The diameter of the cutter must be positive, got {cutter_diameter}.")
    if not 0.0 <= breakthrough < np.inf:
        raise InputError(f"The breakthrough must be 0 mm or more, got {breakthrough}.")
    angles = np.radians([side.inclination for side in workpiece.sides])
    sine, cosine, tangent = np.sin(np.abs(angles)), np.cos(angles), np.tan(np.abs(angles))
    across = cutter_diameter / cosine
    sink = cutter_diameter * sine

    # Wider at the bottom, the tip's disc rises from the line of contact: its rim reaches farthest,
    # or the point of it that is level with the upper face, or, where all of it is below the sheet,
    # the far flank at the lower face.
    rising = np.where(sine > 0.0, sine, 1.0)
    along_disc = np.minimum(cutter_diameter, (workpiece.thickness + breakthrough) / rising)
    by_disc = breakthrough * tangent + along_disc * cosine
    beyond = np.where((angles < 0.0) & (sink > breakthrough), by_disc, across)
    below = breakthrough + np.where(angles > 0.0, sink, 0.0)
    return SweptReach(float(beyond.max()), float(below.max()))
