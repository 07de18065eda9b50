"""Whether the panels fit together: chamfers mate, and no two panels share volume."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ifs_cad import progress
from ifs_cad.elements.clash import apart, boxes, overlapping, shared_radius
from ifs_cad.elements.joint import find_joints, unmated_chamfers
from ifs_cad.kernel.inspect import bounding_box, common_volume
from ifs_cad.types import FloatArray
from ifs_cad.workflow.findings import Findings, most_common
from ifs_cad.workflow.verdict import Check, Failure


def check_joints(found: Findings, clearance: float | None) -> Check:
    """Compare the gaps between the cut faces that face each other.

    All must be parallel, none may overlap, and all must gape as most do, or by twice the
    clearance. Small set-backs in place of tiny node reliefs may add to it, and so may node reliefs
    themselves and chamfers that the floor cuts short.
    """
    tol, panels = found.tol, found.panels
    if panels is None:
        return Check("joints", "none: no panels", {"joints": 0})
    low, high = boxes(panels)
    near = overlapping(low - found.thickness / 2, high + found.thickness / 2)
    joints = find_joints(panels, near, found.thickness, tol)
    gaps, plain = joints.gaps, ~joints.tapering
    if not plain.any():
        plain[:] = True
    wanted = most_common(gaps[plain], tol.coplanar) if clearance is None else 2 * clearance
    off = gaps - wanted
    crooked = joints.spreads > tol.coplanar
    overlaps = gaps < -tol.coplanar
    tight = off < -tol.coplanar
    wide = plain & (off > 2 * tol.relief)
    set_back = plain & (off > tol.coplanar) & ~wide

    solids = found.convex[joints.solids].tolist()
    names = [(found.names[one], found.names[other]) for one, other in solids]
    failures = []
    for k in np.flatnonzero(crooked | overlaps | tight | wide).tolist():
        pair = " and ".join(names[k])
        if crooked[k]:
            said = f"The cut faces of {pair} are not parallel: off by {joints.spreads[k]:.3g} mm."
        elif overlaps[k]:
            said = f"The cut faces of {pair} overlap by {-gaps[k]:.3g} mm."
        else:
            said = f"The joint of {pair} gapes {_mm(gaps[k])} mm, not {_mm(wanted)} mm."
        failures.append(Failure(said, names[k]))
    unmated = found.convex[panels.solid_of_face[unmated_chamfers(panels, joints)]].tolist()
    values: dict[str, Any] = {
        "joints": int(plain.sum()),
        "smallest_gap": _extreme(np.min, gaps[plain]),
        "median_gap": _extreme(np.median, gaps[plain]),
        "largest_gap": _extreme(np.max, gaps[plain]),
        "not_parallel": _extreme(np.max, joints.spreads),
        "set_back": [" and ".join(names[k]) for k in np.flatnonzero(set_back).tolist()],
        "tapering": int((~plain).sum()),
        "largest_tapering_gap": _extreme(np.max, gaps[~plain]),
        "unmated": [found.names[solid] for solid in unmated],
        "parts_left_out": len(found.names) - len(panels),
    }
    return Check("joints", _joints_finding(values), values, tuple(failures))


def _joints_finding(values: dict[str, Any]) -> str:
    parts = [f"{values['joints']} joints"]
    if values["joints"]:
        low, middle, high = (_mm(values[f"{k}_gap"]) for k in ("smallest", "median", "largest"))
        parts[0] += f" gape {low} to {high} mm, median {middle}"
        parts.append(f"parallel to {values['not_parallel']:.1e} mm")
    if values["set_back"]:
        parts.append(f"{len(values['set_back'])} of them set back in place of a relief")
    if values["tapering"]:
        parts.append(
            f"{values['tapering']} reliefs and trimmed joints gape up to "
            f"{_mm(values['largest_tapering_gap'])} mm"
        )
    if values["unmated"]:
        parts.append(f"{len(values['unmated'])} slanted cut faces without a partner")
    if values["parts_left_out"]:
        parts.append(f"{values['parts_left_out']} parts of other shapes left out")
    return "; ".join(parts)


def _extreme(measure: Callable[[FloatArray], Any], numbers: FloatArray) -> float | None:
    return float(measure(numbers)) if len(numbers) else None


def _mm(length: float) -> str:
    """Write a length to 1e-6 mm, zero without a sign."""
    return f"{round(length, 6) + 0.0:.6f}"


def check_interference(found: Findings) -> Check:
    """Look for pairs of parts that share volume.

    Convex panels count without their pockets and holes; a plane between them proves that two are
    apart, and linear programming decides the rest. Parts of other shapes are intersected.
    """
    low, high = _all_boxes(found)
    pairs = overlapping(low, high)
    place = np.full(len(low), -1)
    place[found.convex] = np.arange(len(found.convex))
    both = (place[pairs] >= 0).all(axis=1)
    failures, deepest, largest = [], 0.0, 0.0
    if found.panels is not None:
        close = place[pairs[both]]
        for one, other in close[~apart(found.panels, close, found.tol)].tolist():
            radius = shared_radius(found.panels, one, other)
            deepest = max(deepest, radius)
            if radius > found.tol.shared_radius:
                names = (found.names[found.convex[one]], found.names[found.convex[other]])
                said = f"{' and '.join(names)} share a ball of {radius:.3g} mm radius."
                failures.append(Failure(said, names))
    others = pairs[~both].tolist()
    for done, (one, other) in enumerate(others, 1):
        progress.report("intersecting parts of other shapes", done, len(others))
        solids = found.contents.solids[one], found.contents.solids[other]
        volume = common_volume(*solids)
        names = (found.names[one], found.names[other])
        if math.isnan(volume):
            failures.append(Failure(f"{' and '.join(names)} cannot be intersected.", names))
            continue
        largest = max(largest, volume)
        if volume > found.tol.volume * min(abs(solid.volume) for solid in solids):
            failures.append(Failure(f"{' and '.join(names)} share {volume:.6g} mm3.", names))
    values = {
        "pairs": len(pairs),
        "intersected": len(others),
        "deepest": deepest,
        "largest_volume": largest,
    }
    finding = f"{len(pairs)} pairs near each other, {len(failures)} share volume"
    if others:
        finding += f"; {len(others)} of them by intersection"
    return Check("interference", finding, values, tuple(failures))


def _all_boxes(found: Findings) -> tuple[FloatArray, FloatArray]:
    corners = np.empty((len(found.names), 2, 3))
    if found.panels is not None:
        corners[found.convex] = np.stack(boxes(found.panels), axis=1)
    for k in np.setdiff1d(np.arange(len(corners)), found.convex).tolist():
        corners[k] = bounding_box(found.contents.solids[k])
    return corners[:, 0], corners[:, 1]
