"""Named sets of subdivision points, and one number to go from one to another.

A scheme is a set of subdivision points without their places: barycentric columns, which keep their
meaning when the control points move. Between two of them every mixture is a scheme again, so a
single number leads from a smooth set to a rough one, and a shared column stays shared on the way.

`Curve.with_roughness` is such a path without a drawn end: between ``scheme`` and
``scheme.with_roughness(r)``, the share q is the roughness q r.

Source: the paper, section 3.2.1 and figure 10.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ifs_cad.design.transform import Scheme
from ifs_cad.errors import InputError
from ifs_cad.types import vector

__all__ = ["SubdivisionSets"]


@dataclass(frozen=True, eq=False)
class SubdivisionSets:
    """Sets of subdivision points by name.

    Parameters
    ----------
    sets : mapping of str to Scheme
        At least one; all of the same transformations and control points, with the same columns
        shared and fixed. The scheme of a curve is its `Curve.scheme`.

    Raises
    ------
    InputError
        No set, or sets of different structure.

    Examples
    --------
    >>> smooth = Curve([(0, 0), (1, 2), (2, 0)])
    >>> rough = smooth.with_subdivision_point("s2", (0.2, 1.5))
    >>> sets = SubdivisionSets({"smooth": smooth.scheme, "rough": rough.scheme})
    >>> halfway = smooth.with_scheme(sets.between("smooth", "rough", 0.5))
    """

    sets: Mapping[str, Scheme]

    def __post_init__(self) -> None:
        object.__setattr__(self, "sets", dict(self.sets))
        if not self.sets:
            raise InputError("There must be at least one set of subdivision points.")
        first, *others = self.sets
        for other in others:
            difference = _difference(self.sets[first], self.sets[other])
            if difference:
                raise InputError(
                    f"The sets {first!r} and {other!r} differ in {difference}; sets to go between "
                    "need the same structure and may differ only in where the points are."
                )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the sets."""
        return tuple(self.sets)

    def __getitem__(self, name: str) -> Scheme:
        """Return a set by its name.

        Raises
        ------
        InputError
            An unknown name; the message lists those there are.
        """
        if name not in self.sets:
            raise InputError(
                f"There is no set of subdivision points {name!r}, only {', '.join(self.names)}."
            )
        return self.sets[name]

    def with_set(self, name: str, scheme: Scheme) -> SubdivisionSets:
        """Return the sets with one more, or another of this name."""
        return SubdivisionSets({**self.sets, name: scheme})

    def between(self, start: str, end: str, share: float) -> Scheme:
        """Return the set at a share of the way from one to another.

        Each column takes that share of its way; the subdivision points of equal weights then move
        on straight lines.

        Parameters
        ----------
        start, end : str
        share : float
            From 0, the start, to 1, the end.

        Raises
        ------
        InputError
            An unknown name, or a share out of range.
        ContinuityError
            A mixture that tears the curve; possible only when the schemes do not interpolate.
        """
        one, other = self[start], self[end]
        part = float(vector([share], "The share between two sets", 1)[0])
        if not 0.0 <= part <= 1.0:
            raise InputError(f"The share between two sets must be from 0 to 1, got {part:g}.")
        return replace(one, columns=(1.0 - part) * one.columns + part * other.columns)


def _difference(one: Scheme, other: Scheme) -> str:
    """Return in what the structures of two schemes differ, or nothing."""
    if one.layout.shape != other.layout.shape:
        return "their numbers of transformations and control points"
    if not np.array_equal(one.layout, other.layout):
        return "the columns that they share"
    if not np.array_equal(one.fixed, other.fixed):
        return "the columns that are fixed"
    if one.names != other.names:
        return "the names of their columns"
    return "their symmetry" if one.symmetric != other.symmetric else ""
