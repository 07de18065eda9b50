"""What panels and planks are made of.

*Along* is the fibre direction (of plywood: of its face veneers), *across* the direction square to
it in the plane of the sheet. Stiffness and strength are needed only for a structure check; a
material without them can still be cut.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from ifs_cad.errors import InputError


@dataclass(frozen=True)
class Stiffness:
    """Elastic constants of a sheet, taken as one homogeneous layer, MPa (N/mm2).

    Parameters
    ----------
    e_along, e_across : float
        Moduli of elasticity.
    poisson : float
        Contraction across for a strain along, dimensionless.
    g_plane : float
        Shear modulus in the plane of the sheet, which also resists its twisting.
    g_along, g_across : float
        Shear moduli through the thickness, for shear along and across the fibre (planar shear;
        across it veneers roll).
    """

    e_along: float
    e_across: float
    poisson: float
    g_plane: float
    g_along: float
    g_across: float

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if not (math.isfinite(value) and (value > 0 or item.name == "poisson")):
                raise InputError(f"Stiffness {item.name} must be positive, got {value} MPa.")
        # beyond this a strain would release energy
        if self.poisson**2 * self.e_across >= self.e_along:
            raise InputError(
                f"A Poisson's ratio of {self.poisson} is impossible with moduli of "
                f"{self.e_along:g} and {self.e_across:g} MPa; its size must stay below "
                f"{math.sqrt(self.e_along / self.e_across):.3g}."
            )

    @classmethod
    def isotropic(cls, modulus: float, poisson: float) -> Stiffness:
        """Return the constants of a material without a fibre direction.

        Parameters
        ----------
        modulus : float, MPa
        poisson : float, above -1 and below 1/2
        """
        if not -1 < poisson <= 0.5:
            raise InputError(f"Poisson's ratio must lie between -1 and 0.5, got {poisson}.")
        shear = modulus / (2 * (1 + poisson))
        return cls(modulus, modulus, poisson, shear, shear, shear)

    @property
    def is_isotropic(self) -> bool:
        """Whether the fibre direction makes no difference."""
        shear = self.e_along / (2 * (1 + self.poisson))
        return (
            self.e_along == self.e_across
            and self.g_plane == shear
            and (self.g_along == self.g_across)
        )


@dataclass(frozen=True)
class Strength:
    """Stresses at which a sheet fails, MPa (N/mm2), of its full cross-section.

    Characteristic values give a utilisation without safety; a design code's factors belong into
    the loads or into these numbers.

    Parameters
    ----------
    bending_along, bending_across : float
    tension_along, tension_across : float
    compression_along, compression_across : float
    shear : float, in the plane of the sheet (panel shear)
    planar_along, planar_across : float, through the thickness (rolling shear)
    """

    bending_along: float
    bending_across: float
    tension_along: float
    tension_across: float
    compression_along: float
    compression_across: float
    shear: float
    planar_along: float
    planar_across: float

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"Strength {item.name} must be positive, got {value} MPa.")


@dataclass(frozen=True)
class Material:
    """A sheet or board material.

    Parameters
    ----------
    name : str
    density : float, kg/m3
    colour : (red, green, blue), each 0 to 1, for previews and STEP
    stiffness : Stiffness, optional
    strength : Strength, optional
    """

    name: str
    density: float
    colour: tuple[float, float, float]
    stiffness: Stiffness | None = None
    strength: Strength | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.density) and self.density > 0):
            raise InputError(f"Density of {self.name} must be positive, got {self.density}.")
        if len(self.colour) != 3 or not all(0 <= part <= 1 for part in self.colour):
            raise InputError(f"Colour of {self.name} must be three numbers from 0 to 1.")


# Stiffness is estimated, not declared: seven equal crossed veneers, each with the mean moduli of
# C24 in EN 338 (11000 along, 370 across, shear 690) and a tenth of that shear modulus in rolling,
# summed in bending by laminate theory (the three veneers across hold 99/343 of the second moment).
# For comparison: "Plywood, sheathing grade" of MatWeb has 8200 to 10300 in bending, 590 to 760 in
# edgewise and 140 to 210 in rolling shear.
#
# Strength: characteristic values of sanded Metsa Wood spruce plywood, declaration of performance
# MW/PW (EN 13986:2004+A1:2015), the sixth of nine thicknesses. The copy that was read (transcribed
# at businessdocbox.com/113578751-Construction/Declaration-of-performance.html) has lost the names
# of its columns. They were told by compression along to across: 16.8 : 13.2 is that of four
# veneers along and three across less a sixth of a veneer sanded off, as the same sixth explains
# seven of the other eight; so the sixth is 21 mm in seven veneers. The declared moduli were not in
# the copy. For a building, take what is declared for the board that is bought.
SPRUCE_PLYWOOD = Material(
    "spruce plywood",
    450.0,
    (0.87, 0.72, 0.50),
    Stiffness(
        e_along=7930.0,
        e_across=3440.0,
        poisson=0.04,
        g_plane=690.0,
        g_along=142.0,
        g_across=112.0,
    ),
    Strength(
        bending_along=20.7,
        bending_across=12.7,
        tension_along=10.1,
        tension_across=7.9,
        compression_along=16.8,
        compression_across=13.2,
        shear=3.5,
        planar_along=1.41,
        planar_across=1.18,
    ),
)
SPRUCE = Material("spruce", 440.0, (0.85, 0.69, 0.46))
