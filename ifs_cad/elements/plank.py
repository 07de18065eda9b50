"""How segments become planks: offset, mitred on bisector planes, stood on their springing.

In the plane of a layer a plank is a quadrilateral. Its corners at a joint lie where the lines at
the same distance from both segments meet, computed once for both planks, so that their ends are
the same points. Its ends beyond a springing plane are made too long and trimmed by the plane.

Source: section 4.1 (the lengths of the planks correspond to the lengths of the line sections, the
chamfer angle to the bisector angle of two adjacent ones).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Literal, get_args

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.elements.layer import NEVER, Layers
from ifs_cad.elements.material import Material
from ifs_cad.elements.polyhedron import Kind, Polyhedra, Prismatoids, clip
from ifs_cad.errors import FloorError, InputError, ThicknessError
from ifs_cad.tolerance import Tolerance
from ifs_cad.types import BoolArray, FloatArray, IntArray, Plane, number
from ifs_cad.vectors import dot

Side = Literal["outside", "inside", "centre"]
_REACH = {"outside": (0.0, 1.0), "inside": (-1.0, 0.0), "centre": (-0.5, 0.5)}


@dataclass(frozen=True)
class Planking:
    """The recipe for the planks of a vault.

    Parameters
    ----------
    width, thickness : float, mm
    side : "outside", "inside" or "centre"
    springing : planes for the start and the end of the curves; None where it ends square
    clearance : float, how far each end cut is set back, mm
    material : Material
    tol : Tolerance

    Raises
    ------
    InputError
    """

    width: float
    thickness: float
    side: Side
    springing: tuple[Plane | None, Plane | None]
    clearance: float
    material: Material
    tol: Tolerance = field(repr=False)

    def __post_init__(self) -> None:
        for name in ("width", "thickness", "clearance"):
            value = number(getattr(self, name), f"The {name} of planks")
            if not (math.isfinite(value) and value >= 0 and (value or name == "clearance")):
                limit = "not be negative" if name == "clearance" else "be positive"
                raise InputError(f"The {name} of planks must {limit}, got {value} mm.")
        if self.side not in get_args(Side):
            raise InputError(
                f'The side of planks must be "outside", "inside" or "centre", got {self.side!r}.'
            )

        planes = self.springing
        if len(planes) != 2 or not all(p is None or isinstance(p, Plane) for p in planes):
            raise InputError(
                "The springing of a vault must be a Plane, or a pair of planes for the start and "
                f"the end of its curves, got {planes!r}."
            )

    @property
    def reach(self) -> tuple[float, float]:
        """Where planks end inside and outside of the curve, mm; positive is outside."""
        inner, outer = _REACH[self.side]
        return inner * self.width, outer * self.width

    def __call__(self, segments: Layers) -> tuple[Polyhedra, IntArray]:
        """Return the planks, and the segment of each; mates are segments.

        Raises
        ------
        ThicknessError
            The curve is too tight for the width.
        FloorError
            The curves end above their springing plane, or dip below it midway.
        """
        self._require_room(segments)
        made = self._prismatoids(segments)
        planks, left = made.polyhedra(self.tol), np.arange(len(segments.layer))
        start, end = self.springing
        for plane, order in ((start, 1),) if start == end else ((start, 1), (end, -1)):
            if plane is None:
                continue
            _require_above(segments, plane, self.tol)
            # one plane is the floor of everything; of two, each is that of its own end only
            trimmed = np.full(len(segments.layer), start == end)
            trimmed |= segments.is_ring | _foot(segments, made, plane, order)
            level = float(np.dot(plane.normal, plane.origin))
            planks, staying = clip(
                planks,
                np.broadcast_to(np.array(plane.normal), (len(planks), 3)),
                np.where(trimmed[left], level, -np.inf),
                Kind.FLOOR,
                np.full(len(planks), NEVER),
                self.tol,
            )
            left = left[staying]
        return replace(
            planks, mates=np.where(np.isin(planks.mates, left), planks.mates, NEVER)
        ), left

    def _require_room(self, segments: Layers) -> None:
        """Raise unless every plank has a positive length on its inside and on its outside."""
        back = np.flatnonzero((np.cos(segments.turns / 2) <= self.tol.parallel).any(axis=1))
        if len(back):
            names = segments.names(back)
            raise ThicknessError(
                f"The curve turns straight back between {listed(names)}, where no planks can "
                "meet. Move its points apart.",
                addresses=names,
            )
        bend = np.tan(segments.turns / 2).sum(axis=1)
        joined = np.stack([segments.before, segments.after], axis=1) != NEVER
        set_back = np.where(joined, self.clearance / np.cos(segments.turns / 2), 0.0).sum(axis=1)
        free = segments.lengths - set_back
        # the side towards which a plank gets shorter
        depth = np.max([-level * np.sign(bend) for level in self.reach], axis=0)
        left = free - depth * np.abs(bend)
        tight = np.flatnonzero(left <= self.tol.coincident)
        if len(tight) == 0:
            return
        names = segments.names(tight)
        if (free[tight] <= self.tol.coincident).any():
            raise ThicknessError(
                f"A clearance of {self.clearance:g} mm leaves nothing of {listed(names)}. Use a "
                "smaller one, or fewer construction steps.",
                addresses=names,
            )
        radius = free[tight] / np.abs(bend[tight])
        worst = int(np.argmin(radius / depth[tight]))
        widest = float(self.width * (radius / depth[tight])[worst])
        raise ThicknessError(
            f"The curve is too tight for planks {self.width:g} mm wide: at {names[worst]} its "
            f"radius is {radius[worst]:.3f} mm, and the planks reach {depth[tight][worst]:.3f} mm "
            "to the inner side of the bend: only a larger radius fits. Planks less than "
            f"{math.floor(widest * 1000) / 1000:g} mm wide would fit; or draw the curve flatter, "
            f"or lay them on another side of it. Too tight: {listed(names)}.",
            addresses=names,
            radius=float(radius[worst]),
            smallest_radius=float(depth[tight][worst]),
            widest=widest,
        )

    def _prismatoids(self, segments: Layers) -> Prismatoids:
        ahead = segments.directions
        # in the plane, sideways is to the left, since u, v and across are right-handed
        sideways = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
        low, high = sorted(-segments.outside * level for level in self.reach)
        rings, cuts, kinds, mates = [], [], [], []
        for neighbour, point, order in (
            (segments.after, segments.ends, 1.0),
            (segments.before, segments.starts, -1.0),
        ):
            joined = neighbour != NEVER
            both = sideways + np.where(joined[:, None], sideways[neighbour], sideways)
            rise = 2.0 * both / dot(both, both)[:, None]
            tangent = np.stack([both[:, 1], -both[:, 0]], axis=1)
            tangent /= np.hypot(tangent[:, 0], tangent[:, 1])[:, None]
            longer = self._extension(segments, ~joined, order, (low, high))
            longer -= np.where(joined, self.clearance / dot(tangent, ahead), 0.0)
            shift = order * longer[:, None] * ahead
            rings.append([segments.points[point] + level * rise + shift for level in (low, high)])
            cuts.append(-order * tangent)
            kinds.append(np.where(joined, int(Kind.CUT), int(Kind.BORDER)))
            mates.append(neighbour)
        (end_low, end_high), (start_low, start_high) = rings
        border, alone = np.full(len(ahead), int(Kind.BORDER)), np.full(len(ahead), NEVER)
        sides = np.stack([sideways, cuts[0], -sideways, cuts[1]], axis=1).reshape(-1, 2)
        flat = np.stack([end_low, end_high, start_high, start_low], axis=1).reshape(-1, 2)
        base = np.repeat(segments.layer, 4).astype(np.float64)
        return Prismatoids(
            lower=segments.spatial(flat, base * self.thickness),
            upper=segments.spatial(flat, (base + 1) * self.thickness),
            side_normals=sides @ segments.axes[:2],
            kinds=np.stack([border, kinds[0], border, kinds[1]], axis=1).ravel(),
            mates=np.stack([alone, mates[0], alone, mates[1]], axis=1).ravel(),
            solid_offsets=np.arange(0, len(flat) + 1, 4),
            normals=np.tile(segments.across, (len(ahead), 1)),
        )

    def _extension(
        self, segments: Layers, free: BoolArray, order: float, levels: tuple[float, float]
    ) -> FloatArray:
        """Return how much longer each plank is made at its free end to reach the springing, mm."""
        longer = np.zeros(len(free))
        plane = self.springing[1 if order > 0 else 0]
        if plane is None:
            return longer
        normal = segments.axes @ np.array(plane.normal)
        if abs(normal[2]) > self.tol.parallel:
            raise InputError(
                "A springing plane must be square to the layers: its normal "
                f"{np.round(plane.normal, 6).tolist()} leans towards the direction across, "
                f"{np.round(segments.across, 6).tolist()}."
            )
        if not free.any():
            return longer
        ends = np.flatnonzero(free)
        names = segments.names(ends)
        point = segments.points[(segments.ends if order > 0 else segments.starts)[ends]]
        height = plane.height(segments.spatial(point))
        above = np.flatnonzero(height > self.tol.planar)
        if len(above):
            drop, high = float(height.max()), [names[k] for k in above]
            raise FloorError(
                f"The curve ends up to {drop:.3f} mm above its springing plane at "
                f"{listed(high)}. Lower its ends by that much, or raise the plane.",
                addresses=high,
                drop=drop,
            )
        ahead = segments.directions[ends]
        falls = -order * ahead @ normal[:2]
        sideways = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1) @ normal[:2]
        rise = np.max([height + level * sideways for level in levels], axis=0)
        reaches = rise > -self.tol.planar  # else the whole end lies below
        level = np.flatnonzero(reaches & (falls <= self.tol.parallel))
        if len(level):
            flat = [names[k] for k in level]
            raise FloorError(
                f"At {listed(flat)} the curve does not run down to its springing plane, so its "
                "planks cannot stand on it. Turn the plane, or bend the end of the curve.",
                addresses=flat,
            )
        # a little beyond the plane, which makes the cut
        longer[ends[reaches]] = rise[reaches] / falls[reaches] + self.thickness
        return longer


def _foot(segments: Layers, made: Prismatoids, plane: Plane, order: int) -> BoolArray:
    """Tell which planks stand at the start of their layer, or with order -1 at its end.

    Those up to the first joint that lies above the plane with its whole width.
    """
    height = plane.height(made.lower).reshape(-1, 4)  # two corners at the end, two at the start
    above = (height[:, :2] if order > 0 else height[:, 2:]).min(axis=1) > 0
    above, layer = above[::order], order * segments.layer[::order]
    passed = np.cumsum(above) - above
    return np.asarray(passed == passed[np.searchsorted(layer, layer)])[::order]


def _require_above(segments: Layers, plane: Plane, tol: Tolerance) -> None:
    """Raise unless each layer comes up out of the plane once and goes down once, at most."""
    below = plane.height(segments.spatial(segments.points)) < -tol.planar
    rises = below[segments.starts] & ~below[segments.ends]
    falls = ~below[segments.starts] & below[segments.ends]
    sunk = np.bincount(segments.layer, ~(below[segments.starts] & below[segments.ends]))
    if not sunk.all():
        raise FloorError(
            f"Layer {int(np.argmin(sunk))} lies below its springing plane. Lower the plane."
        )
    closed = np.bincount(segments.layer, segments.before == NEVER) == 0
    first_fall, last_rise = np.full(segments.count, np.inf), np.full(segments.count, -np.inf)
    np.minimum.at(first_fall, segments.layer[falls], np.flatnonzero(falls))
    np.maximum.at(last_rise, segments.layer[rises], np.flatnonzero(rises))
    again = ~closed & (last_rise > first_fall)
    again |= np.bincount(segments.layer, rises, segments.count) > 1
    if again.any():
        crossing = np.flatnonzero((rises | falls) & again[segments.layer])
        names = segments.names(crossing)
        raise FloorError(
            f"The curve dips below its springing plane midway, at {listed(names)}. Raise the "
            "curve there, or lower the plane.",
            addresses=names,
        )
