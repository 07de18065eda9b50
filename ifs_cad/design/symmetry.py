"""Schemes that look the same from both ends.

The mirror image of a scheme lists its transformations and their columns backwards and turns each
column upside down: T'_{N+1-k} = J T_k J with J the exchange matrix. A symmetric scheme is its own
image, so over control points that are symmetric in space the curve is symmetric too.

Terms
-----
partner : the column that is a column's mirror image; a column may be its own partner, as the
    middle joint is.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from ifs_cad.errors import InputError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import BoolArray, FloatArray, IntArray

__all__ = ["partners", "require_symmetry", "symmetric_columns"]


def partners(layout: IntArray, fixed: BoolArray) -> IntArray:
    """Return (q,) int, the partner of each column of a scheme.

    Parameters
    ----------
    layout : (N, m) int
        Which column stands where.
    fixed : (q,) bool

    Raises
    ------
    InputError
        A layout in which columns are shared, or fixed, otherwise from the two ends.
    """
    mirrored = layout[::-1, ::-1]
    partner = np.arange(len(fixed))
    partner[layout] = mirrored
    if (partner[layout] != mirrored).any() or (fixed[partner] != fixed).any():
        raise InputError(
            "This scheme cannot be symmetric: seen from its two ends, other columns are shared or "
            "fixed. Share and fix them alike."
        )
    return partner


def require_symmetry(
    columns: FloatArray, partner: IntArray, names: tuple[str, ...], tol: Tolerance = DEFAULT
) -> None:
    """Raise unless each column, read backwards, is its partner.

    Raises
    ------
    InputError
        Names the columns that differ most.
    """
    apart = np.abs(columns - columns[partner, ::-1]).max(axis=1)
    if apart.max() > tol.barycentric:
        worst = int(apart.argmax())
        raise InputError(
            f"Column {names[worst]} and its mirror image {names[partner[worst]]} differ by "
            f"{apart.max():.3g}. Move both alike, or take their means with `with_symmetry`."
        )


def symmetric_columns(size: int) -> FloatArray:
    """Return (m, ceil(m/2)) orthonormal columns that span those that read alike backwards."""
    rows = np.arange((size + 1) // 2)
    basis = np.zeros((size, len(rows)))
    basis[rows, rows] = basis[size - 1 - rows, rows] = 1 / sqrt(2)
    if size % 2:
        basis[size // 2, -1] = 1.0
    return basis
