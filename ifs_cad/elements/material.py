"""What panels and planks are made of."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ifs_cad.errors import InputError


@dataclass(frozen=True)
class Material:
    """A sheet or board material.

    Parameters
    ----------
    name : str
    density : float, kg/m3
    colour : (red, green, blue), each 0 to 1, for previews and STEP
    """

    name: str
    density: float
    colour: tuple[float, float, float]

    def __post_init__(self) -> None:
        if not (math.isfinite(self.density) and self.density > 0):
            raise InputError(f"Density of {self.name} must be positive, got {self.density}.")
        if len(self.colour) != 3 or not all(0 <= part <= 1 for part in self.colour):
            raise InputError(f"Colour of {self.name} must be three numbers from 0 to 1.")


SPRUCE_PLYWOOD = Material("spruce plywood", 450.0, (0.87, 0.72, 0.50))
SPRUCE = Material("spruce", 440.0, (0.85, 0.69, 0.46))
