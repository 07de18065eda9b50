"""Plank lists: the two lengths and the two end cuts that a saw is set to, and how many of each.

A plank lies along x and is cut square to its face. Most are trapezoids seen from above, with one
cut at each end; where a springing plane takes the corner of an end there are more, and the list
gives no angles: such a plank is cut by its drawing. The *end angle* is that of an end to the square
cut, positive when the end slopes inward from the long side to the short one. Of two ends the one
with the larger angle comes first; with both sides of one length the plank is a parallelogram and
its angles are opposite.

Source: section 4.1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.errors import InputError
from ifs_cad.fabrication.congruence import congruent_groups
from ifs_cad.fabrication.cutlist import require_unique
from ifs_cad.fabrication.measure import extent, side_edges
from ifs_cad.fabrication.table import Cell, Column, Table
from ifs_cad.fabrication.workpiece import Workpiece
from ifs_cad.tolerance import DEFAULT, Tolerance


@dataclass(frozen=True)
class PlankKind:
    """Planks that are cut with one setting.

    Attributes
    ----------
    addresses : tuple of str
    material : str
    long, short : float, lengths of the two sides, mm
    end_angles : (float, float), degrees, the larger first; None where an end has several cuts
    width, thickness : float, mm
    """

    addresses: tuple[str, ...]
    material: str
    long: float
    short: float
    end_angles: tuple[float, float] | tuple[None, None]
    width: float
    thickness: float

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.addresses)


@dataclass(frozen=True)
class PlankList:
    """All kinds of planks, in the order of their first planks.

    Attributes
    ----------
    kinds : tuple of PlankKind
    """

    kinds: tuple[PlankKind, ...]

    def __len__(self) -> int:
        """Return the number of planks."""
        return sum(kind.count for kind in self.kinds)

    @cached_property
    def tables(self) -> tuple[Table, ...]:
        """The list as tables: kinds, planks."""
        measures = (
            Column("material", "text"),
            Column("long side (mm)"),
            Column("short side (mm)"),
            Column("first end (deg)"),
            Column("second end (deg)"),
            Column("width (mm)"),
            Column("thickness (mm)"),
        )
        kinds = Table(
            "kinds",
            (
                Column("kind", decimals=0),
                Column("count", decimals=0),
                *measures,
                Column("addresses", "text"),
            ),
            tuple(
                (number, kind.count, *_measures(kind), " ".join(kind.addresses))
                for number, kind in enumerate(self.kinds, start=1)
            ),
        )
        planks = Table(
            "planks",
            (Column("address", "text"), Column("kind", decimals=0), *measures),
            tuple(
                (address, number, *_measures(kind))
                for number, kind in enumerate(self.kinds, start=1)
                for address in kind.addresses
            ),
        )
        return (kinds, planks)


def plank_list(
    workpieces: Sequence[Workpiece], tolerance: float = 0.1, *, tol: Tolerance = DEFAULT
) -> PlankList:
    """List planks by what a saw is set to.

    Parameters
    ----------
    workpieces : sequence of Workpiece
        Cut square to their face, with a side along x.
    tolerance : float, mm
        Planks whose corners lie closer than this are of one kind, also when turned end for end or
        over. Holes and engravings do not count. A kind has the measures of its first plank.
    tol : Tolerance

    Raises
    ------
    InputError
        A workpiece that is no plank; two with one address.
    """
    require_unique(workpieces)
    odd = [workpiece.address for workpiece in workpieces if not _is_plank(workpiece, tol)]
    if odd:
        raise InputError(
            f"{listed(odd)} cannot be listed as planks, which are cut square to their face and "
            "have a side along x. Use cut_list for other elements.",
            addresses=odd,
        )
    return PlankList(
        tuple(
            _kind(workpieces[group[0].index], [workpieces[m.index].address for m in group], tol)
            for group in congruent_groups(workpieces, tolerance, turned_over=True, holes=False)
        )
    )


def end_angles(plank: Workpiece, *, tol: Tolerance = DEFAULT) -> tuple[float, float] | None:
    """Return the end angles of a plank as it lies: of its left and of its right end, degrees.

    None when one of its ends has several cuts. See the module.
    """
    normals = np.array([side.normal[:2] for side in plank.sides])
    ends = normals[np.abs(normals[:, 0]) > tol.parallel]
    if len(ends) != 2 or ends[:, 0].min() > 0.0 or ends[:, 0].max() < 0.0:
        return None
    left, right = ends[ends[:, 0].argsort()]
    # An end whose normal looks up makes the side at y = 0 the longer one.
    one, other = math.atan2(left[1], -left[0]), math.atan2(right[1], right[0])
    way = 1.0 if math.tan(one) + math.tan(other) >= 0.0 else -1.0
    return way * math.degrees(one), way * math.degrees(other)


def _is_plank(workpiece: Workpiece, tol: Tolerance) -> bool:
    normals = np.array([side.normal for side in workpiece.sides])
    square = np.abs(normals[:, 2]) <= tol.parallel
    return bool(square.all() and (np.abs(normals[:, 0]) <= tol.parallel).any())


def _kind(plank: Workpiece, addresses: Sequence[str], tol: Tolerance) -> PlankKind:
    normals = np.array([side.normal[:2] for side in plank.sides])
    edges = side_edges(plank)
    along = np.abs(normals[:, 0]) <= tol.parallel
    near, far = (
        float(edges.upper_lengths[along & (normals[:, 1] * way > 0.0)].sum()) for way in (-1.0, 1.0)
    )
    angles = end_angles(plank, tol=tol)
    return PlankKind(
        addresses=tuple(addresses),
        material=plank.material.name,
        long=max(near, far),
        short=min(near, far),
        end_angles=(max(angles), min(angles)) if angles else (None, None),
        width=float(extent(plank)[1]),
        thickness=plank.thickness,
    )


def _measures(kind: PlankKind) -> tuple[Cell, ...]:
    return (
        kind.material,
        kind.long,
        kind.short,
        *kind.end_angles,
        kind.width,
        kind.thickness,
    )
