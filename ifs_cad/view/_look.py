"""How a picture is taken: its size, where the camera stands, what is drawn."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import cadquery as cq
import numpy as np

from ifs_cad.errors import InputError
from ifs_cad.view._scene import Scene

LARGEST = 4000  # pixels: drawn at twice that, it still fits drivers and memory


@dataclass(frozen=True)
class Look:
    """What was asked of a picture, checked.

    Raises
    ------
    InputError
        A number or colour that cannot be meant.
    """

    width: int = 1600
    height: int = 1000
    azimuth: float = -60.0
    elevation: float = 25.0
    zoom: float = 1.0
    background: str = "white"
    edges: bool = True
    labels: bool = False
    _paper: tuple[float, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        width, height = self.width, self.height
        if not all(isinstance(n, int) and 16 <= n <= LARGEST for n in (width, height)):
            raise InputError(
                f"Width and height must be whole pixels from 16 to {LARGEST}, got {width} x "
                f"{height}."
            )
        view = (self.azimuth, self.elevation, self.zoom)
        if not all(math.isfinite(n) for n in view) or self.zoom <= 0:
            raise InputError(
                "Azimuth and elevation must be finite and zoom positive, "
                f"got {view[0]}, {view[1]} and {view[2]}."
            )
        try:
            paper = tuple(cq.Color(self.background).toTuple()[:3])
        except (ValueError, TypeError) as error:
            raise InputError(
                f"Unknown background colour {self.background!r}: give a name, or #rrggbb."
            ) from error
        object.__setattr__(self, "_paper", paper)

    def camera(self) -> Scene:
        """Return the arrays of a scene that say how it is looked at."""
        return {
            "size": np.array([self.width, self.height]),
            "view": np.array([self.azimuth, self.elevation, self.zoom], dtype=float),
            "background": np.array(self._paper),
        }
