"""Points of the attractor by the chaos game, a way there that has nothing to do with a germ.

A point of the attractor stays on it under every map, so maps picked at random lead it all over.
Many points are moved at once, each on its own random way.

Source: Barnsley, *Fractals Everywhere* (the paper's reference 4); the attractor, the paper, section
2.3.
"""

from __future__ import annotations

import math

import numpy as np

from ifs_cad.design.reading import whole_number
from ifs_cad.design.system import System
from ifs_cad.errors import InputError, SizeError
from ifs_cad.tolerance import MEMORY_LIMIT
from ifs_cad.types import ArrayLike, FloatArray

LEAST_SHARE = 0.01  # of the maps that flatten; by their determinants they would never be picked

__all__ = ["chaos_game"]


def chaos_game(
    system: System, count: int, *, seed: int = 0, probabilities: ArrayLike | None = None
) -> FloatArray:
    """Return random points of the attractor.

    Every point lies on the attractor up to rounding: the ways start in the fixed point of T_1.

    Parameters
    ----------
    system : System
        A figure, or transformations without a germ.
    count : int
        Number of points.
    seed : int
        The same seed gives the same points.
    probabilities : (N,) array, optional
        How often each map is picked, in any unit; by default the determinants, which spread the
        points evenly over figures that have an area (a volume), and at least 1 % of their sum.

    Returns
    -------
    (count, d) float, mm

    Raises
    ------
    InputError
        A count or seed that is not a whole number, or probabilities that are none.
    ContractionError
        Transformations that have no attractor.
    SizeError
        More points than fit in memory.
    """
    whole_number(count, "The number of points", 1)
    whole_number(seed, "The seed", 0)
    system.require_contracting()
    needed = 4 * system.maps.itemsize * system.maps.shape[-1] * count
    if needed > MEMORY_LIMIT:
        raise SizeError(
            f"{count} points would take {needed / 2**30:.3g} GiB; the limit is "
            f"{MEMORY_LIMIT / 2**30:.3g} GiB."
        )
    shares = _shares(system, probabilities)
    random = np.random.default_rng(seed)
    ways = math.ceil(math.sqrt(count))
    # So many steps that where a way began is no longer seen in its place.
    unseen = math.log(np.finfo(float).eps) / math.log(max(system.contraction.rate, LEAST_SHARE))
    before, steps = math.ceil(unseen), math.ceil(count / ways)
    rows = np.tile(_fixed_point(system), (ways, 1))
    reached = np.empty((steps, *rows.shape))
    for step in range(-before, steps):
        picked = random.choice(system.count, size=ways, p=shares)
        rows = np.einsum("nij,nj->ni", system.maps[picked], rows)
        if step >= 0:
            reached[step] = rows
    return system.seen(reached.reshape(-1, rows.shape[1])[:count])


def _fixed_point(system: System) -> FloatArray:
    """Return the (k,) coordinates that T_1 leaves where they are."""
    first = system.maps[0]
    equations = np.vstack([first - np.eye(len(first)), system.unit])
    fixed = np.linalg.lstsq(equations, np.eye(len(equations))[-1])[0]
    return np.asarray(fixed / (system.unit @ fixed))


def _shares(system: System, given: ArrayLike | None) -> FloatArray:
    """Return how often each map is picked, with the sum 1."""
    if given is None:
        # By the stretches: numpy.linalg.det warns of some maps that flatten.
        sizes = np.prod(np.linalg.svd(system.linear_parts, compute_uv=False), axis=1)
        shares = np.maximum(sizes, LEAST_SHARE * sizes.sum()) if sizes.any() else sizes + 1.0
    else:
        shares = np.array(given, dtype=float)
        wrong = shares.shape != (system.count,) or not np.isfinite(shares).all()
        if wrong or shares.min() < 0.0 or shares.max() <= 0.0:
            raise InputError(
                f"Probabilities must be {system.count} numbers from 0, not all 0, got {given!r}."
            )
    return np.asarray(shares / shares.sum())
