"""Element matrices from Kratos Multiphysics, the only place that imports it.

Kratos' four-node thick shell (Mindlin plate with assumed shear strains, enhanced membrane strains,
drilling stiffness) with one orthotropic layer; an isotropic material is the special case of equal
moduli and gives the same matrices.

Its stabilisation (Stenberg's) divides transverse shear stiffness by 1 + 0.1 (longest side /
thickness)^2, which vanishes with finer quads. Where veneers roll easily that is far too soft, so
the moduli handed over are such that the same flexibility is added as in an isotropic plate. What
is left: a lone panel twisted at its corners is 3 % too soft at 4 x 4 quads and 1 % at 16 x 16; for
whole shells see `model.DIVISIONS`.

Everything else (assembly, hinges, solution) is done by the rest of this room on arrays.
"""

from __future__ import annotations

import os
import sys
from functools import cache
from importlib.util import find_spec
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from ifs_cad.elements.material import Stiffness
from ifs_cad.errors import MissingLibraryError
from ifs_cad.libraries import require
from ifs_cad.progress import report
from ifs_cad.types import FloatArray
from ifs_cad.vectors import length

ELEMENT = "LegacyThickShellElement3D4N"
EXTRA = "structure"
PURPOSE = "the structure check"
STABILISATION = 0.1  # Kratos' own factor, measured on single elements
ELEMENTS_AT_ONCE = 1024  # between two reports of progress


class Kratos(NamedTuple):
    """The modules of Kratos that are used."""

    core: ModuleType
    structure: ModuleType
    laws: ModuleType


@cache
def load_kratos() -> Kratos:
    """Import Kratos without its banner.

    Raises
    ------
    MissingLibraryError
        It is not installed, or its wheel is not made for this system.
    """
    package = "KratosMultiphysics"
    require("scipy", PURPOSE)
    found = find_spec(package)
    try:
        if found is not None and found.submodule_search_locations:
            # Kratos prints a banner while it starts. Its core, which it looks for in this folder
            # itself a moment later, has the switch.
            sys.path.append(os.path.join(found.submodule_search_locations[0], ".libs"))
            logger = require("Kratos", PURPOSE, EXTRA).Logger
            logger.GetDefaultOutput().SetSeverity(logger.Severity.WARNING)
        return Kratos(
            require(package, PURPOSE, EXTRA),
            require(f"{package}.StructuralMechanicsApplication", PURPOSE, EXTRA),
            require(f"{package}.ConstitutiveLawsApplication", PURPOSE, EXTRA),
        )
    except MissingLibraryError:
        raise
    except (ImportError, OSError) as error:  # a wheel of another system
        raise MissingLibraryError(
            f"Kratos is installed but does not start on this system: {error}. Reinstall it with "
            f"pip install --force-reinstall 'ifs-cad[{EXTRA}]'.",
            library=package,
        ) from error


def shell_stiffness(
    corners: FloatArray, thickness: float, stiffness: Stiffness, angles: FloatArray
) -> FloatArray:
    """Return the stiffness matrices of flat four-node shells.

    Parameters
    ----------
    corners : (e, 4, 3) float, mm
    thickness : float, mm
    stiffness : Stiffness
    angles : (e,) float, radians
        From the first side of each element to the fibre direction, about its normal.

    Returns
    -------
    (e, 24, 24) float
        In global axes; per node three displacements (mm) and three rotations (radians). N, mm.

    Raises
    ------
    MissingLibraryError
    """
    kratos = load_kratos()
    core = kratos.core
    model = core.Model()
    part = model.CreateModelPart("panels")
    part.AddNodalSolutionStepVariable(core.DISPLACEMENT)
    part.AddNodalSolutionStepVariable(core.ROTATION)
    matrices = np.empty((len(corners), 24, 24))
    sides = length(corners - np.roll(corners, -1, axis=1)).max(axis=1)
    planar = _planar_moduli(stiffness, STABILISATION * (sides / thickness) ** 2).tolist()
    sections: dict[tuple[float, float], Any] = {}
    for number, (x, y, z) in enumerate(corners.reshape(-1, 3).tolist()):
        part.CreateNewNode(number + 1, x, y, z)
    for axis in "XYZ":
        for variable in ("DISPLACEMENT", "ROTATION"):
            core.VariableUtils().AddDof(getattr(core, f"{variable}_{axis}"), part)
    left, right = core.Matrix(), core.Vector()
    turns = angles.tolist()
    for number, turn in enumerate(turns):
        if number % ELEMENTS_AT_ONCE == 0:
            report("element matrices", number, len(turns))
        nodes = [4 * number + 1, 4 * number + 2, 4 * number + 3, 4 * number + 4]
        key = (planar[number][0], planar[number][1])
        if key not in sections:
            name = len(sections) + 1
            sections[key] = _section(kratos, part, name, thickness, stiffness, key)
        element = part.CreateNewElement(ELEMENT, number + 1, nodes, sections[key])
        element.SetValue(kratos.structure.MATERIAL_ORIENTATION_ANGLE, turn)
        element.Initialize(part.ProcessInfo)
        element.CalculateLocalSystem(left, right, part.ProcessInfo)
        matrices[number] = left
    report("element matrices", len(turns), len(turns))
    return matrices


def _planar_moduli(stiffness: Stiffness, softening: FloatArray) -> FloatArray:
    """Return the shear moduli through the thickness that Kratos is to be given, (e, 2) MPa.

    Kratos divides them by 1 + softening. What should be added to 1 / g is softening / g_plane, a
    flexibility as of an isotropic plate, whatever the planar moduli; g_plane itself for both
    comes out unchanged.
    """
    given = np.array([stiffness.g_along, stiffness.g_across])
    more = softening[:, None]
    return np.asarray(given * (1 + more) / (1 + more * given / stiffness.g_plane))


def _section(
    kratos: Kratos,
    part: Any,
    number: int,
    thickness: float,
    stiffness: Stiffness,
    planar: tuple[float, float],
) -> Any:
    core = kratos.core
    section = part.CreateNewProperties(number)
    layer = (
        thickness,
        0.0,  # turned against the fibre direction
        0.0,  # density; masses are summed elsewhere
        stiffness.e_along,
        stiffness.e_across,
        stiffness.poisson,
        stiffness.g_plane,
        *planar,
    )
    layers = core.Matrix(1, len(layer))
    for column, value in enumerate(layer):
        layers[0, column] = value
    section.SetValue(kratos.structure.SHELL_ORTHOTROPIC_LAYERS, layers)
    section.SetValue(core.CONSTITUTIVE_LAW, kratos.laws.LinearElasticOrthotropic2DLaw())
    return section
