"""Refusing what would not fit in memory, before any of it is made."""

from __future__ import annotations

import math

from ifs_cad.errors import SizeError
from ifs_cad.tolerance import MEMORY_LIMIT

__all__ = ["require_memory"]

READABLE = 15  # digits up to which a number is written out


def require_memory(count: int, depth: int, bytes_each: int, *, known: int = 0) -> None:
    """Raise when the elements after some construction steps would not fit in memory.

    Parameters
    ----------
    count : int
        N, the number of transformations.
    depth : int
        Number of construction steps.
    bytes_each : int
        What one element takes while it is computed.
    known : int
        Digits that are already chosen, so that only elements with one prefix are made.

    Raises
    ------
    SizeError
        Names the greatest depth that fits.
    """
    # Logarithms, since the count itself may have thousands of digits.
    steps, base, each = depth - known, math.log10(count), math.log10(bytes_each)
    room = math.log10(MEMORY_LIMIT) - each
    if steps * base <= room:
        return
    fits = known + max(0, int(room / base))
    raise SizeError(
        f"Depth {depth} with {count} transformations makes {_power_of_ten(steps * base)} elements "
        f"and would take {_power_of_ten(steps * base + each - math.log10(2**30))} GiB; the limit "
        f"is {MEMORY_LIMIT / 2**30:.3g} GiB. The greatest depth that fits is {fits}.",
        depth=depth,
        greatest_depth=fits,
    )


def _power_of_ten(exponent: float) -> str:
    """Write 10^exponent readably however large it is."""
    return f"about {10**exponent:,.0f}" if exponent < READABLE else f"about 10^{exponent:.0f}"
