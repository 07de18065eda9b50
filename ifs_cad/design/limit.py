"""How far the limit of a curve lies from its construction steps, with a bound that is proven.

The limit is what further and further construction steps settle on. All of it that belongs to a
piece P T_w lies in the hull of the points P T_w c over the corners c of an enclosure, and the
distance from a segment is a convex function, so the farthest corner bounds the distance of the
limit. Points of the limit that are known, P T_w a and P T_w b, bound it from the other side. Both
bounds close in on each other as pieces are split; what is certainly nearer than a point already
found is split no more (branch and bound).

Terms
-----
enclosure : a cone of barycentric columns, spanned by m corners, that no word of some length leads
    out of; so the limit never leaves it. Where no column of a scheme has a negative entry, as in
    de Casteljau's and the splines', the corners are the control points. Otherwise they are those
    of the simplex of the control points, moved and enlarged until it holds.
owner : the polyline, an element of the curve, from which a part of the limit is measured.

Source: the paper, section 2.3 (the limit does not depend on the germ) and section 4.1.
"""

from __future__ import annotations

import numpy as np

from ifs_cad.design.contraction import USUAL_WORDS
from ifs_cad.design.transform import Scheme
from ifs_cad.tolerance import Tolerance
from ifs_cad.types import FloatArray

ENLARGEMENTS = (1.0, 1.1, 1.25, 1.5, 2.0, 3.0, 5.0, 10.0, 30.0, 100.0)
MOST_STEPS = 60  # halved so often, a piece is below the resolution of floating-point numbers
MOST_PIECES = 2**15
ROUNDING = 64 * float(np.finfo(float).eps)  # share of a number that sums and products lose

__all__ = ["enclosure", "largest_distance"]


def enclosure(scheme: Scheme, weights: FloatArray) -> FloatArray | None:
    """Return barycentric columns whose hull the limit never leaves.

    Parameters
    ----------
    scheme : Scheme
    weights : (m,) float
        Of the control points, as the columns of the scheme meet them.

    Returns
    -------
    (m, m) float or None
        Columns c, the corners: the limit of the piece P T_w is in the hull of P T_w c, as long as
        these have positive weights. None when none was found: the transformations do not contract,
        or hardly.
    """
    if (scheme.columns >= -ROUNDING).all():
        return np.eye(scheme.size)
    # Scaled so that control points weigh 1, a column's sum is the weight of its point. Where that
    # leads nowhere, barycentric columns as they are may do: most schemes keep their sums at 1.
    for scale in (weights, np.ones_like(weights)):
        maps = scale[:, None] * scheme.transformations / scale
        corners = _simplex(maps, scheme.ends * scale)
        if corners is not None:
            return np.asarray(corners / scale[:, None])
    return None


def largest_distance(
    scheme: Scheme,
    corners: FloatArray,
    pieces: FloatArray,
    polylines: FloatArray,
    tol: Tolerance,
) -> tuple[float, float]:
    """Return the largest distance of the limits of pieces from their polylines, mm.

    Parameters
    ----------
    scheme : Scheme
    corners : (m, m) float
        The enclosure.
    pieces : (n, 4, m) float
        Homogeneous control points as columns.
    polylines : (n, s + 1, 3) float, mm
        Of each piece.
    tol : Tolerance

    Returns
    -------
    bound : float
        No point of the limit is farther than this, up to rounding; infinite when pieces have
        corners without positive weight.
    attained : float
        Some point of the limit is as far as this. Less than the bound by at most `tol.coincident`
        and the rounding of the coordinates, or by more where very many parts of the curve are
        almost equally far away, or the pieces hardly shrink.
    """
    starts, chords = polylines[:, :-1], np.diff(polylines, axis=1)
    settled = tol.coincident + ROUNDING * float(np.abs(polylines).max())
    probes = np.column_stack([scheme.ends.T, corners])
    owners = np.arange(len(pieces))
    bounds = np.full(len(pieces), np.inf)
    attained = nearer = 0.0
    for _ in range(MOST_STEPS):
        rows = (pieces @ probes).swapaxes(1, 2)
        distances = _distances(rows, starts[owners], chords[owners], tol)
        attained = max(attained, float(distances[:, :2].min(axis=2).max()))
        # An enclosure may leave its parent's, which bounds the limit too.
        bounds = np.minimum(bounds, distances[:, 2:].max(axis=1).min(axis=1))
        kept = bounds > attained + settled
        nearer = max(nearer, float(bounds[~kept].max(initial=0.0)))
        pieces, owners, bounds = pieces[kept], owners[kept], bounds[kept]
        if not 0 < len(pieces) <= MOST_PIECES / scheme.count:
            break
        pieces = scheme.subdivided(pieces)
        owners, bounds = owners.repeat(scheme.count), bounds.repeat(scheme.count)
    return max(attained, nearer, float(bounds.max(initial=0.0))), attained


def _simplex(maps: FloatArray, ends: FloatArray) -> FloatArray | None:
    """Return as columns the corners of a simplex ``x_i >= floor_i sum(x)`` that holds the limit."""
    size = maps.shape[1]
    words = np.eye(size)[None]
    lowest = np.full(size, np.inf)
    while len(words) * len(maps) <= USUAL_WORDS:
        words = (words[:, None] @ maps).reshape(-1, size, size)
        reached = words @ ends.T
        sums = reached.sum(axis=1, keepdims=True)
        if not (sums > 0.0).all():
            return None
        lowest = np.minimum(lowest, (reached / sums).min(axis=(0, 2)))
    room = (1.0 - lowest.sum()) / size
    for enlargement in ENLARGEMENTS:
        floor = lowest - (enlargement - 1.0) * room
        corners = floor[:, None] + (1.0 - floor.sum()) * np.eye(size)
        if _holds(corners, floor, words):
            return np.asarray(corners)
    return None


def _holds(corners: FloatArray, floor: FloatArray, words: FloatArray) -> bool:
    """Return whether (n, m, m) words lead no corner out of ``x_i >= floor_i sum(x)``."""
    images = words @ corners
    above = images - floor[:, None] * images.sum(axis=1, keepdims=True)
    return bool((above >= -ROUNDING * np.abs(corners).max()).all())


def _distances(
    rows: FloatArray, starts: FloatArray, chords: FloatArray, tol: Tolerance
) -> FloatArray:
    """Return (n, q, s) distances of (n, q, 4) homogeneous points from (n, s, 3) segments, mm.

    Infinite for points without positive weight.
    """
    weights = rows[..., :1]
    positive = weights > tol.weight * np.abs(weights).max()
    points = np.divide(rows[..., 1:], weights, out=np.zeros_like(rows[..., 1:]), where=positive)
    across = points[:, :, None] - starts[:, None]
    squares = (chords**2).sum(axis=2)
    shares = np.clip((across * chords[:, None]).sum(axis=3) / squares[:, None], 0.0, 1.0)
    across -= shares[..., None] * chords[:, None]
    return np.where(positive, np.linalg.norm(across, axis=3), np.inf)
