"""Whether the construction steps settle: the contraction report.

Finite construction steps always exist; the limit (the attractor) only when the transformations
contract. Eigenvalues of single T_i do not tell, since a product can grow where each factor
shrinks; products do.

Terms
-----
word : a product of transformations, here all of one length.
rate : by which factor pieces shrink per construction step; 1 or more does not settle.
sum-zero space : differences of barycentric columns; what a transformation does to a difference
    of two points of a piece.

Source: the paper, sections 2.3 (the attractor) and 3 (finite construction states).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ifs_cad.design.reading import whole_number
from ifs_cad.design.transform import Scheme
from ifs_cad.errors import InputError, SizeError
from ifs_cad.tolerance import DEFAULT, MEMORY_LIMIT, Tolerance
from ifs_cad.types import ArrayLike, FloatArray

USUAL_LENGTH = 8
USUAL_WORDS = 4096
TOO_MANY = 300  # logarithm of a number of words that no memory holds

__all__ = ["Contraction", "contraction", "diameter_contraction"]


@dataclass(frozen=True)
class Contraction:
    """How the pieces of a curve shrink.

    Attributes
    ----------
    rate : float
        Factor per construction step; infinite when nothing bounds the pieces.
    length : int
        Length of the words looked at.
    """

    rate: float
    length: int

    @property
    def contracting(self) -> bool:
        """Whether the pieces shrink, so that further steps settle on a limit."""
        return self.rate < 1.0

    @property
    def message(self) -> str:
        """One sentence for the designer."""
        if math.isinf(self.rate):
            return (
                f"After {self.length} construction steps a control point of a piece has lost its "
                "weight, so nothing bounds the pieces. This depth exists, but further steps need "
                "not settle; give the subdivision points more even weights or lower the roughness."
            )
        shown = f"a factor of {self.rate:.4g} per construction step (words of {self.length})"
        if self.contracting:
            return f"The pieces shrink by {shown}."
        return (
            f"The pieces do not shrink: {shown}. This depth exists, but further steps need not "
            "settle; bring the subdivision points closer to the chords or lower the roughness."
        )

    @property
    def warning(self) -> str:
        """The message when the pieces do not shrink, else nothing."""
        return "" if self.contracting else self.message


def contraction(
    transformations: Scheme | ArrayLike, length: int | None = None, *, tol: Tolerance = DEFAULT
) -> Contraction:
    """Report the contraction of transformations whose columns sum to 1.

    The rate is the largest, over all words of one length k, of ``||product||^(1/k)``, the spectral
    norm on the sum-zero space. Below 1 the limit exists for certain. The longer the words, the
    closer the rate comes to the true one from above.

    Parameters
    ----------
    transformations : Scheme or (N, m, m) float
    length : int, optional
        k; by default 8, less when there would be more than 4096 words.

    Raises
    ------
    InputError
        A wrong shape, or columns that do not sum to 1 (with weights, ask the curve:
        `Curve.contraction`).
    SizeError
        More words than fit in memory.
    """
    matrices = _matrices(transformations)
    sums = matrices.sum(axis=1)
    if (np.abs(sums - 1.0) > tol.barycentric).any():
        raise InputError(
            f"The columns sum to between {sums.min():.6g} and {sums.max():.6g}, not to 1: with "
            "weights, contraction depends on the control points too. Use Curve.contraction()."
        )
    length = _length(matrices, length)
    across = np.linalg.svd(np.ones((1, matrices.shape[1])))[2][1:]  # rows span the sum-zero space
    maps = across @ matrices @ across.T
    products = maps
    for _ in range(length - 1):
        products = (products[:, None] @ maps).reshape(-1, *maps.shape[1:])
    # the spectral norm by a symmetric eigenvalue takes half the time of a singular value
    squared = np.linalg.eigvalsh(np.swapaxes(products, 1, 2) @ products).max(initial=0.0)
    return Contraction(float(squared ** (0.5 / length)), length)


def diameter_contraction(
    transformations: Scheme | ArrayLike,
    projection: FloatArray,
    length: int | None = None,
    *,
    tol: Tolerance = DEFAULT,
) -> Contraction:
    """Report the contraction of a weighted curve or patch by the diameters of its pieces.

    With weights the same product shrinks one piece and not another, so norms of products say
    nothing; sizes in space do. The diameter d(w) of a piece is the largest distance between its
    control points, in whose hull it lies while their weights are positive. With k the length and
    h half of it, the rate is the largest ``(d(uv) / d(u))^(1/(k-h))`` over all words u of length h
    and v of length k-h: by h steps the weights within a piece have evened out. From there on no
    piece of h steps shrinks by a worse factor per step over the next k-h.

    Parameters
    ----------
    transformations : Scheme or (N, m, m) float
    projection : (4, m) float
        Homogeneous control points as columns (w, xw, yw, zw).
    length : int, optional
        k; by default 8, less when there would be more than 4096 words.

    Returns
    -------
    Contraction
        With an infinite rate when a control point of a piece has no positive weight, since nothing
        bounds that piece.

    Raises
    ------
    SizeError
        More words than fit in memory.
    """
    matrices = _matrices(transformations)
    length = _length(matrices, length)
    half = length // 2
    pieces = projection[None]
    for level in range(length + 1):
        if level:
            pieces = (pieces[:, None] @ matrices).reshape(-1, *projection.shape)
        if (pieces[:, 0] <= tol.weight * np.abs(pieces[:, 0]).max()).any():
            return Contraction(math.inf, level)
        if level == half:
            parents = _diameters(pieces)
    parts = _diameters(pieces).reshape(len(parents), -1).max(axis=1)
    # A piece that is a single point already has nothing left to shrink.
    ratios = np.divide(parts, parents, out=np.zeros_like(parts), where=parents > 0.0)
    return Contraction(float(ratios.max() ** (1.0 / (length - half))), length)


def _diameters(pieces: FloatArray) -> FloatArray:
    """Return (n,) largest distances between the control points of (n, 4, m) pieces, mm."""
    points = pieces[:, 1:] / pieces[:, :1]
    spans = points[:, :, :, None] - points[:, :, None]
    return np.asarray(np.sqrt((spans**2).sum(axis=1).max(axis=(1, 2))))


def _matrices(transformations: Scheme | ArrayLike) -> FloatArray:
    """Return (N, m, m) matrices."""
    if isinstance(transformations, Scheme):
        return transformations.transformations
    matrices = np.array(transformations, dtype=float)
    if matrices.ndim != 3 or matrices.shape[1] != matrices.shape[2]:
        raise InputError(f"Transformations must have the shape (N, m, m), got {matrices.shape}.")
    return matrices


def _length(matrices: FloatArray, length: int | None) -> int:
    """Return the length of words to look at, within memory."""
    count, size = matrices.shape[:2]
    if length is None:
        length = 1
        while length < USUAL_LENGTH and count ** (length + 1) <= USUAL_WORDS:
            length += 1
        return length
    length = whole_number(length, "The length of words", 1)
    words = math.exp(min(length * math.log(count), TOO_MANY))
    needed = words * size**2 * 3 * np.dtype(float).itemsize * 2
    if needed > MEMORY_LIMIT:
        raise SizeError(
            f"There are {count}^{length} words of length {length}; that would take about "
            f"{needed / 2**30:.3g} GiB, and the limit is {MEMORY_LIMIT / 2**30:.3g} GiB. Take "
            "shorter words."
        )
    return length
