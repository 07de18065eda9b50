"""Exploded views: elements moved apart by the digits of their addresses.

Elements with a common prefix are a connected piece of the whole. Each digit moves the pieces that
it tells apart outwards from the middle of the piece that they make together, so a view shows which
sub-assemblies there are, and of what each is made.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ifs_cad.design.address import prefixes
from ifs_cad.elements.element import Elements
from ifs_cad.errors import InputError
from ifs_cad.types import FloatArray

Explode = float | Sequence[float]


def explosion(elements: Elements, explode: Explode) -> FloatArray:
    """Return how far each element moves in an exploded view.

    Parameters
    ----------
    elements : Elements
    explode : float or sequence of float
        How far pieces move, in parts of the distance of their middle from that of the piece they
        belong to. One for each digit of the address; a single one counts for the first digit and
        is halved from digit to digit. ``(0.5,)`` moves whole sub-assemblies of one digit.

    Returns
    -------
    (p, 3) float, mm

    Raises
    ------
    InputError
        A factor that is negative or no number.
    """
    single = isinstance(explode, int | float)
    factors = [float(explode)] if isinstance(explode, int | float) else [*map(float, explode)]
    if not all(math.isfinite(factor) and factor >= 0 for factor in factors):
        raise InputError(f"Pieces move apart by factors of 0 or more, got {explode}.")
    solids = elements.solids
    owner = solids.solid_of_vertex
    count = np.bincount(owner, minlength=len(solids))
    sums = [np.bincount(owner, column, len(solids)) for column in solids.vertices.T]
    middles = np.stack(sums, axis=1) / count[:, None]
    grown = [prefixes(address) for address in elements.addresses]
    digits = max(len(each) for each in grown)
    if single:
        factors = [factors[0] / 2**digit for digit in range(digits)]
    shifts = np.zeros_like(middles)
    outer = np.broadcast_to(middles.mean(axis=0), middles.shape)
    for digit, factor in enumerate(factors[:digits]):
        # an address that ends earlier is a piece of its own from there on
        names = [each[min(digit, len(each) - 1)] for each in grown]
        _, piece = np.unique(names, return_inverse=True)
        size = np.bincount(piece)
        inner = np.stack([np.bincount(piece, column) / size for column in middles.T], axis=1)[piece]
        shifts += factor * (inner - outer)
        outer = inner
    return shifts
