"""Whether a STEP file is what a workshop may trust, judged from the file alone.

The file is read back and measured without the design: solids, volumes, planes, thickness, engraved
addresses, mating chamfers, shared volume. Whatever should be equal for all panels is compared with
what is most common among them.
"""

from __future__ import annotations

import math
import os
from collections import Counter
from pathlib import Path

import numpy as np

from ifs_cad import progress
from ifs_cad.design.address import listed
from ifs_cad.elements.boundary import Surface
from ifs_cad.errors import InputError
from ifs_cad.kernel.inspect import MILLIMETRE, Contents, inspect_step
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.workflow.check_fit import check_interference, check_joints
from ifs_cad.workflow.check_labels import check_labels
from ifs_cad.workflow.findings import Findings
from ifs_cad.workflow.verdict import Check, CheckReport, Failure

__all__ = ["Check", "CheckReport", "Failure", "check_step"]


def check_step(
    path: str | os.PathLike[str],
    *,
    tol: Tolerance = DEFAULT,
    clearance: float | None = None,
) -> CheckReport:
    """Read a STEP file back and judge it.

    Parameters
    ----------
    path : path of the file
    tol : Tolerance
    clearance : float, optional
        How far each chamfer should be set back, mm: every joint must gape by twice as much. By
        default by as much as most joints do.

    Raises
    ------
    CheckError
        There is no such file, it is not STEP, it breaks off, or there is no solid in it.
    InputError
        A negative clearance.
    """
    if clearance is not None and not (math.isfinite(clearance) and clearance >= 0):
        raise InputError(f"Clearance must not be negative, got {clearance} mm.")
    found = Findings(inspect_step(path), tol)
    progress.report("comparing panels")
    return CheckReport(
        Path(path).name,
        (
            _file(found.contents),
            _names(found.contents),
            _solids(found.contents),
            _volumes(found),
            _faces(found),
            _thickness(found),
            check_labels(found),
            check_joints(found, clearance),
            check_interference(found),
        ),
    )


def _file(contents: Contents) -> Check:
    units = ", ".join(contents.units) or "none"
    failures = [Failure(f"OpenCascade's reader says: {said}") for said in contents.complaints]
    if contents.units != (MILLIMETRE,):
        failures.append(
            Failure(f"The unit of length must be millimetre, but the file has {units}.")
        )
    finding = f"{contents.schema}, {units}, {len(contents.names)} parts"
    values = {"schema": contents.schema, "units": units, "parts": len(contents.names)}
    return Check("file", finding, values, tuple(failures))


def _names(contents: Contents) -> Check:
    failures = [
        Failure(f"{count} parts are called {name!r}.", (name,))
        for name, count in Counter(contents.names).items()
        if count > 1
    ]
    failures += [
        Failure(f"The name {name!r} is empty or not ASCII.", (name,))
        for name in contents.names
        if not (name.strip() and name.isascii())
    ]
    different = len(set(contents.names))
    finding = f"{different} different names of {len(contents.names)} parts"
    return Check("names", finding, {"different": different}, tuple(failures))


def _solids(contents: Contents) -> Check:
    failures = [Failure(f"{name} holds no closed solid.", (name,)) for name in contents.loose]
    for solid in contents.solids:
        gaping = solid.boundary.open_edges
        if gaping:
            failures.append(
                Failure(f"{solid.name} is open: {gaping} edges lack a face.", (solid.name,))
            )
        elif solid.volume <= 0.0:
            failures.append(Failure(f"{solid.name} is turned inside out.", (solid.name,)))
        elif not solid.valid:
            failures.append(Failure(f"OpenCascade finds {solid.name} not valid.", (solid.name,)))
    good = len(contents.solids) + len(contents.loose) - len(failures)
    finding = f"{good} of {len(contents.solids) + len(contents.loose)} valid and closed"
    values = {"solids": len(contents.solids), "valid_and_closed": good}
    return Check("solids", finding, values, tuple(failures))


def _volumes(found: Findings) -> Check:
    failures, worst, exact = [], 0.0, 0
    changed = []  # shapes with other faces than a panel has, as a user's own booleans make them
    for solid in found.contents.solids:
        volume = solid.boundary.volume(found.tol)
        if volume is None or volume == 0.0:
            changed.append(solid.name)
            continue
        exact += 1
        off = abs(solid.volume / volume - 1)
        worst = max(worst, off)
        if off > found.tol.volume:
            failures.append(
                Failure(
                    f"{solid.name}: OpenCascade finds {solid.volume:.6f} mm3, its faces enclose "
                    f"{volume:.6f} mm3.",
                    (solid.name,),
                )
            )
    chosen = [sheet for sheet in found.sheets if sheet and sheet.hull]
    values = {
        "volume": math.fsum(solid.volume for solid in found.contents.solids),
        "exact": exact,
        "worst": worst,
        "panels": math.fsum(float(sheet.hull.volumes[0]) for sheet in chosen if sheet.hull),
        "pockets": math.fsum(sheet.pocket_volume for sheet in chosen),
        "holes": math.fsum(sheet.hole_volume for sheet in chosen),
        "hole_count": sum(len(sheet.hole_areas) for sheet in chosen),
    }
    finding = f"{exact} of {len(found.names)} in closed form, off by {worst:.1e} at worst"
    if chosen:
        finding += (
            f"; polyhedra {values['panels']:,.0f} mm3, less pockets {values['pockets']:,.0f} and "
            f"{values['hole_count']} holes {values['holes']:,.0f}"
        )
    if changed:
        finding += f"; no longer the shape of a panel: {listed(changed)}"
    return Check("volumes", finding, values, tuple(failures))


def _faces(found: Findings) -> Check:
    bodies = [solid.boundary for solid in found.contents.solids]
    kinds = np.concatenate([body.surfaces for body in bodies]) if bodies else np.empty(0)
    failures, worst = [], 0.0
    for name, body in zip(found.names, bodies, strict=True):
        off = float(body.deviations.max(initial=0.0))
        worst = max(worst, off)
        if off > found.tol.planar:
            count = int((body.deviations > found.tol.planar).sum())
            failures.append(
                Failure(f"{count} faces of {name} are up to {off:.3g} mm off their edges.", (name,))
            )
    values = {
        "planes": int((kinds == Surface.PLANE).sum()),
        "cylinders": int((kinds == Surface.CYLINDER).sum()),
        "others": int((kinds == Surface.OTHER).sum()),
        "worst": worst,
    }
    finding = (
        f"{values['planes']} planes, {values['cylinders']} cylinders, {values['others']} others, "
        f"off by {worst:.1e} mm at worst"
    )
    return Check("faces", finding, values, tuple(failures))


def _thickness(found: Findings) -> Check:
    failures, stubs, worst, common = [], [], 0.0, found.thickness
    for name, sheet in zip(found.names, found.sheets, strict=True):
        if sheet is not None and sheet.is_stub and sheet.thickness <= common + found.tol.planar:
            stubs.append(name)
            continue
        if sheet is None or sheet.is_stub:
            failures.append(Failure(f"{name} has no two parallel faces: it is no panel.", (name,)))
            continue
        off = abs(sheet.thickness - common)
        worst = max(worst, off, sheet.unevenness)
        if sheet.unevenness > found.tol.planar:
            said = f"The two faces of {name} are not parallel: off by {sheet.unevenness:.3g} mm."
            failures.append(Failure(said, (name,)))
        elif off > found.tol.planar:
            said = f"{name} is {sheet.thickness:.6f} mm thick, not {common:.6f} mm."
            failures.append(Failure(said, (name,)))
    if math.isnan(common):
        return Check("thickness", "no panel", {}, tuple(failures))
    finding = f"{common:.6f} mm, off by {worst:.1e} mm at worst"
    if stubs:
        finding += f"; {listed(stubs)} cut down to a stub with one face"
    values = {"thickness": common, "worst": worst, "stubs": stubs}
    return Check("thickness", finding, values, tuple(failures))
