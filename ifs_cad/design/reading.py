"""Reading what the designer gives: points, weights and numbers, with errors that say what to do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ifs_cad.errors import InputError, WeightError
from ifs_cad.tolerance import LARGEST_COORDINATE
from ifs_cad.types import ArrayLike, FloatArray

__all__ = ["read_points", "read_weights", "require_in_reach", "whole_number"]


def read_points(value: ArrayLike | Sequence[ArrayLike], what: str) -> FloatArray:
    """Read (n, 2) or (n, 3) finite points as (n, 3); those in the plane get z = 0.

    Raises
    ------
    InputError
        A wrong shape, NaN or infinite; `what` names the value in the message.
    """
    try:
        points = np.array(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"{what} must be points of 2 or 3 numbers each, all of the same size, got {value!r}."
        ) from error
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise InputError(f"{what} must be points of 2 or 3 numbers each, got shape {points.shape}.")
    require_in_reach(points, what)
    if points.shape[1] == 3:
        return points
    return np.column_stack([points, np.zeros(len(points))])


def require_in_reach(points: FloatArray, what: str) -> None:
    """Raise unless all coordinates are finite and within `tolerance.LARGEST_COORDINATE`.

    Raises
    ------
    InputError
    """
    if not np.isfinite(points).all():
        rows = np.flatnonzero(~np.isfinite(points).all(axis=1)).tolist()
        raise InputError(f"{what} must be finite; rows {rows} are not.")
    far = np.abs(points).max(axis=1, initial=0.0) > LARGEST_COORDINATE
    if far.any():
        raise InputError(
            f"{what} must lie within {LARGEST_COORDINATE:g} mm of the origin; rows "
            f"{np.flatnonzero(far).tolist()} do not."
        )


def read_weights(value: ArrayLike | None, count: int) -> FloatArray:
    """Read `count` positive finite weights, all 1 when None.

    Raises
    ------
    InputError
        Not as many numbers.
    WeightError
        A weight that is zero, negative, NaN or infinite.
    """
    if value is None:
        return np.ones(count)
    try:
        weights = np.array(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(f"Weights must be {count} numbers: {error}.") from error
    if weights.shape != (count,):
        raise InputError(f"Weights must be {count} numbers, got shape {weights.shape}.")
    if not (np.isfinite(weights).all() and (weights > 0.0).all()):
        raise WeightError(f"Weights must be positive and finite, got {weights.tolist()}.")
    return weights


def whole_number(value: object, what: str, least: int, most: int | None = None) -> int:
    """Read an integer from `least` to `most`.

    Raises
    ------
    InputError
        Not an integer, or out of range; `what` names the value in the message.
    """
    if isinstance(value, int | np.integer) and not isinstance(value, bool):
        number = int(value)
        if number >= least and (most is None or number <= most):
            return number
    span = f"of at least {least}" if most is None else f"from {least} to {most}"
    raise InputError(f"{what} must be a whole number {span}, got {value!r}.")
