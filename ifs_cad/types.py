"""Array aliases and the small geometric values that every room shares.

All of it is numpy only. Lengths in mm.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ifs_cad.errors import InputError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

__all__ = [
    "ArrayLike",
    "BoolArray",
    "FloatArray",
    "IntArray",
    "Plane",
    "frozen",
    "number",
    "vector",
]


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """Return a read-only view of an array."""
    view = array.view()
    view.setflags(write=False)
    return view


def vector(value: ArrayLike, what: str, size: int = 3) -> FloatArray:
    """Read a finite vector of `size` numbers.

    Raises
    ------
    InputError
        Wrong shape, NaN or infinite; `what` names the value in the message.
    """
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(f"{what} must be {size} numbers, got {value!r}.") from error
    if array.shape != (size,):
        raise InputError(f"{what} must be {size} numbers, got shape {array.shape}.")
    if not np.isfinite(array).all():
        raise InputError(f"{what} must be finite, got {array.tolist()}.")
    return array


def number(value: Any, what: str) -> float:
    """Read a number.

    Raises
    ------
    InputError
        Not a number; `what` names the value in the message.
    """
    try:
        return float(value)
    except (TypeError, ValueError) as error:
        raise InputError(f"{what} must be a number, got {value!r}.") from error


@dataclass(frozen=True)
class Plane:
    """An oriented plane through `origin`; the material lies on the side of `normal`.

    Parameters
    ----------
    origin : (3,) floats, mm
    normal : (3,) floats, any length but zero; kept as a unit vector
    """

    origin: tuple[float, float, float]
    normal: tuple[float, float, float]

    def __post_init__(self) -> None:
        origin = vector(self.origin, "Plane origin")
        normal = vector(self.normal, "Plane normal")
        length = float(np.linalg.norm(normal))
        if length == 0.0:
            raise InputError("Plane normal must not be the zero vector.")
        object.__setattr__(self, "origin", tuple(origin.tolist()))
        object.__setattr__(self, "normal", tuple((normal / length).tolist()))

    def scaled(self, factor: float) -> Plane:
        """Return the plane with its distances from the origin scaled."""
        x, y, z = self.origin
        return Plane((x * factor, y * factor, z * factor), self.normal)

    def height(self, points: FloatArray) -> FloatArray:
        """Return signed distances of (..., 3) points, mm, positive on the normal's side."""
        return np.asarray((points - np.array(self.origin)) @ np.array(self.normal))
