"""Pieces that a floor leaves with sides that end between the two faces of the sheet."""

from dataclasses import replace

import numpy as np
from vaults import plate

from ifs_cad.fabrication.operations import workpieces
from ifs_cad.fabrication.workpiece import Side, Workpiece

LONG, WIDE, THICK = 300.0, 200.0, 10.0


def nipped(depth: float = 4.0) -> Workpiece:
    """A plate that lost its lower right edge to a floor at 45 degrees."""
    left, inner = LONG, LONG - depth
    ring = [(0, 0), (inner, 0), (left, depth), (left, THICK), (0, THICK)]
    names = ["", "floor", "border", "", "border"]
    lower = np.array([(0, 0), (inner, 0), (inner, WIDE), (0, WIDE)], dtype=float)
    upper = np.array([(0, 0), (left, 0), (left, WIDE), (0, WIDE)], dtype=float)
    return prism(ring, names, "nipped", lower, upper)


def wedge() -> Workpiece:
    """A plate of whose upper face a floor left nothing but an edge."""
    ring = [(0, 0), (LONG, 0), (0, THICK)]
    lower = np.array([(0, 0), (LONG, 0), (LONG, WIDE), (0, WIDE)], dtype=float)
    return prism(ring, ["", "floor", "border"], "wedge", lower, lower[:0])


def prism(ring, kinds, address, lower, upper) -> Workpiece:
    """A piece of a section (x, z), the wood on its left, as wide as the plate; "" is no side."""
    (piece,) = workpieces(plate(LONG, WIDE, THICK))
    section = np.array(ring, dtype=float)
    near = np.insert(section, 1, 0.0, axis=1)
    far = near + np.array([0.0, WIDE, 0.0])
    sides = [
        Side(near, np.array([0.0, -1.0, 0.0]), 0.0, "border", ""),
        Side(far[::-1], np.array([0.0, 1.0, 0.0]), 0.0, "border", ""),
    ]
    for k, kind in enumerate(kinds):
        if kind:
            after = (k + 1) % len(section)
            run, rise = section[after] - section[k]
            normal = np.array([rise, 0.0, -run]) / np.hypot(run, rise)
            inclination = float(np.degrees(np.arctan2(-normal[2], abs(normal[0]))))
            corners = np.array([near[k], far[k], far[after], near[after]])
            sides.append(Side(corners, normal, inclination, kind, ""))
    azimuths = [
        (np.arctan2(side.normal[1], side.normal[0]) + 3 / 4 * np.pi) % (2 * np.pi) for side in sides
    ]
    x, z = section.T
    area = float(x @ np.roll(z, -1) - z @ np.roll(x, -1)) / 2
    return replace(
        piece,
        address=address,
        lower=lower,
        upper=upper,
        sides=tuple(sides[k] for k in np.argsort(azimuths, kind="stable")),
        volume=area * WIDE,
    )
