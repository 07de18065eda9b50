"""Thicken a planar mesh into panels of constant thickness.

Each panel is the part of the slab between its face and its *offset face* that lies inside its
*cut planes*. Between two faces the cut plane is the *bisector plane*, which holds the edge and the
sum of the normals; a border edge is square. *Clearance* sets every cut plane back, so that joints
gape by twice as much. Lengths in mm.

Source: section 4.2 and figure 17 (offset surface, bisector planes). Node relief, node axes and the
floor go beyond the paper; see `relief` and `axes`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.design.mesh import Mesh
from ifs_cad.elements.axes import node_axes
from ifs_cad.elements.floor import require_standing
from ifs_cad.elements.material import SPRUCE_PLYWOOD, Material
from ifs_cad.elements.panel import Shell
from ifs_cad.elements.polyhedron import Kind, Polyhedra, Prismatoids, clip, joined, offsets
from ifs_cad.elements.relief import Reliefs, find_reliefs
from ifs_cad.errors import FloorError, InputError, SelfIntersectionError, ThicknessError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import FloatArray, IntArray, Plane, number
from ifs_cad.vectors import cross, dot, length, unit

Side = Literal["outer", "inner", "centre"]
Nodes = Literal["relief", "axis", "plain"]


def thicken(
    mesh: Mesh,
    thickness: float,
    *,
    side: Side = "outer",
    clearance: float = 0.0,
    nodes: Nodes = "relief",
    floor: Plane | None = None,
    min_height: float | None = None,
    material: Material = SPRUCE_PLYWOOD,
    tol: Tolerance = DEFAULT,
) -> Shell:
    """Turn every face of a mesh into a panel.

    Parameters
    ----------
    mesh : Mesh
    thickness : float, mm
    side : "outer", "inner" or "centre"
        Where the panels lie: from the face along its normal, against it, or half and half.
    clearance : float, mm
        How far each cut plane is set back.
    nodes : "relief", "axis" or "plain"
        Relief cuts where panels would collide at a node; cut planes through common node axes
        (vector sums only); or the paper's construction, which leaves collisions in.
    floor : Plane, optional
        Trims every panel it crosses; the shell stands on the side of its normal.
    min_height : float, mm
        Panels that the floor leaves lower than this are named in the report; twice the thickness
        by default.
    material : Material

    Raises
    ------
    InputError
        Thickness not positive, clearance negative, an unknown side or treatment of nodes.
    ThicknessError
        Faces too small for the thickness at their folds; gives the largest that fits.
    SelfIntersectionError
        Faces that fold back onto each other or overlap at a node.
    FloorError
        A standing border that does not reach the floor, with the drop needed.
    """
    recipe = Thickening(
        number(thickness, "Thickness"),
        side,
        number(clearance, "Clearance"),
        nodes,
        floor,
        2.0 * thickness if min_height is None else number(min_height, "min_height"),
        material,
        tol,
    )
    return recipe(mesh)


@dataclass(frozen=True)
class Thickening:
    """How panels are made from a mesh: what a shell remembers to make itself anew."""

    thickness: float
    side: Side
    clearance: float
    nodes: Nodes
    floor: Plane | None
    min_height: float
    material: Material
    tol: Tolerance

    def __post_init__(self) -> None:
        if not (math.isfinite(self.thickness) and self.thickness > 0):
            raise InputError(f"Thickness must be positive, got {self.thickness} mm.")
        if not (math.isfinite(self.min_height) and self.min_height >= 0):
            raise InputError(f"min_height must not be negative, got {self.min_height} mm.")
        if not (math.isfinite(self.clearance) and self.clearance >= 0):
            raise InputError(f"Clearance must not be negative, got {self.clearance} mm.")
        for value, options, what in (
            (self.side, get_args(Side), "side"),
            (self.nodes, get_args(Nodes), "nodes"),
        ):
            if value not in options:
                raise InputError(f"{what} must be one of {', '.join(options)}, got {value!r}.")

    @property
    def levels(self) -> tuple[float, float]:
        """Heights of the lower and the upper face above the design face, mm."""
        if self.side == "outer":
            return 0.0, self.thickness
        if self.side == "inner":
            return -self.thickness, 0.0
        return -self.thickness / 2, self.thickness / 2

    def __call__(self, mesh: Mesh) -> Shell:
        """Make the shell."""
        axes = node_axes(mesh, self.tol) if self.nodes == "axis" else None
        cuts = _cut_normals(mesh, axes, self.tol)
        set_backs = np.full(len(mesh.corners), self.clearance)
        corners = _Corners.between_cuts(mesh, cuts, set_backs)
        reliefs = Reliefs.none()
        if self.nodes != "plain":  # first: no thickness helps a design that crosses itself
            sides = {"outer": (1,), "inner": (-1,), "centre": (1, -1)}[self.side]
            reliefs = find_reliefs(mesh, cuts, corners.rise, sides, self.tol)
        self._require_room(mesh, corners)
        if self.floor is not None:
            lower, upper = (corners.at(level) for level in self.levels)
            require_standing(mesh, self.floor, lower, upper, self.tol)

        if len(reliefs.corners):
            reliefs, set_backs, corners = self._with_small_set_backs(
                mesh, cuts, set_backs, corners, reliefs
            )
        plain = self._prismatoids(mesh, corners)
        if len(reliefs.corners):
            whole = self._relieved(mesh, cuts, set_backs, reliefs, corners, plain)
        else:
            whole = plain.polyhedra(self.tol)
        solids, faces = (whole, np.arange(len(mesh)))
        if self.floor is not None:
            solids, faces = self._trimmed(whole)
        return Shell(
            mesh=mesh,
            thickening=self,
            faces=faces,
            solids=solids,
            plain=plain,
            whole=whole,
            cuts=cuts,
            set_backs=set_backs,
            lost=tuple(mesh.names(np.setdiff1d(np.arange(len(mesh)), faces))),
        )

    def _require_room(self, mesh: Mesh, corners: _Corners) -> None:
        """Raise unless every offset edge keeps its direction."""
        along = mesh.directions
        spread = dot(corners.rise[mesh.next] - corners.rise, along)
        start = dot(corners.base[mesh.next] - corners.base, along)
        low, high = self.levels
        if (start <= 0).any():
            names = mesh.names(mesh.face[start <= 0])
            raise ThicknessError(
                f"A clearance of {self.clearance:g} mm leaves nothing of the edges of "
                f"{listed(names)}. Use a smaller one.",
                addresses=names,
            )
        crossed = (start + low * spread <= 0) | (start + high * spread <= 0)
        if crossed.any():
            shrinking = {"outer": -spread, "inner": spread, "centre": np.abs(spread) / 2}[self.side]
            fits = (start[shrinking > 0] / shrinking[shrinking > 0]).min()
            largest = math.floor(float(fits) * 1000) / 1000
            names = mesh.names(mesh.face[crossed])
            raise ThicknessError(
                f"Panels of {self.thickness:g} mm are too thick for the folds of {listed(names)}: "
                f"their offset corners cross over. At most {largest:g} mm fit this design; or make "
                "the faces larger or the folds flatter.",
                addresses=names,
                largest_thickness=largest,
            )

    def _prismatoids(self, mesh: Mesh, corners: _Corners) -> Prismatoids:
        low, high = self.levels
        return Prismatoids(
            lower=corners.at(low),
            upper=corners.at(high),
            side_normals=corners.ending,
            kinds=corners.kinds,
            mates=corners.mates,
            solid_offsets=corners.solid_offsets,
            normals=mesh.normals,
        )

    def _with_small_set_backs(
        self,
        mesh: Mesh,
        cuts: FloatArray,
        set_backs: FloatArray,
        corners: _Corners,
        reliefs: Reliefs,
    ) -> tuple[Reliefs, FloatArray, _Corners]:
        """Replace relief cuts too short to be made by a small set-back of the two cut planes."""
        low, high = self.levels
        at = reliefs.corners
        normals = reliefs.normals
        before, after = cuts[mesh.previous[at]], cuts[at]
        up = mesh.normals[mesh.face[at]]
        inward = corners.per_set_back[at]
        rise = corners.rise[at]
        level = np.where(dot(rise, normals) < 0, high, low)
        # how far the corner at the far face reaches beyond the relief plane, set back by clearance
        beyond = self.clearance - dot(self.clearance * inward + level[:, None] * rise, normals)
        # the ends of the cut, along the two sides from the corner at the far face
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = [
                side * (beyond / dot(side, normals))[:, None]
                for side in (cross(before, up), cross(after, up))
            ]
            cut_length = np.where(beyond > 0, length(ends[0] - ends[1]), 0.0)
        short = cut_length < self.tol.relief
        needed = np.where(short & (beyond > 0), beyond / dot(inward, normals), 0.0)
        short &= needed < self.tol.relief
        if needed[short].any():
            set_backs = self._set_backs(mesh, at[short], needed[short])
            corners = _Corners.between_cuts(mesh, cuts, set_backs)
            panels = self._prismatoids(mesh, corners)
            turned = (panels.side_lengths < -self.tol.coincident).any(axis=0)
            if turned.any():  # an edge too short to give way: there the cut is made all the same
                short &= ~np.isin(mesh.face[at], panels.solid[turned])
                set_backs = self._set_backs(mesh, at[short], needed[short])
                corners = _Corners.between_cuts(mesh, cuts, set_backs)
        keep = ~short
        return Reliefs(at[keep], normals[keep], reliefs.mates[keep]), set_backs, corners

    def _set_backs(self, mesh: Mesh, corners: IntArray, more: FloatArray) -> FloatArray:
        """Return the set-back of each cut plane: the clearance, and more at some corners."""
        set_backs = np.full(len(mesh.corners), self.clearance)
        np.maximum.at(set_backs, corners, self.clearance + more)
        np.maximum.at(set_backs, mesh.previous[corners], self.clearance + more)
        return set_backs

    def _relieved(
        self,
        mesh: Mesh,
        cuts: FloatArray,
        set_backs: FloatArray,
        reliefs: Reliefs,
        corners: _Corners,
        plain: Prismatoids,
    ) -> Polyhedra:
        """Return the panels with their relief cuts.

        Almost always the relief planes only join the cycle of sides at their corner. Where that
        would turn a side around, the plain panel is clipped by one plane after the other.
        """
        # through the corner where it is set back far enough: no sliver is left beside it
        back = np.maximum(
            self.clearance,
            dot(corners.base[reliefs.corners] - mesh.positions[reliefs.corners], reliefs.normals),
        )
        with np.errstate(divide="ignore", invalid="ignore"):  # equal planes meet nowhere
            cycle = self._prismatoids(
                mesh, _Corners.with_reliefs(mesh, cuts, set_backs, reliefs, back)
            )
            turned = ~(cycle.side_lengths >= -self.tol.coincident).all(axis=0)
        wild = np.zeros(len(mesh), dtype=bool)
        wild[cycle.solid[turned]] = True
        if not wild.any():
            return cycle.polyhedra(self.tol)
        chosen = np.flatnonzero(wild)
        solids = plain.take(wild).polyhedra(self.tol)
        mine = np.flatnonzero(wild[mesh.face[reliefs.corners]])
        rank = _rank_within(mesh.face[reliefs.corners[mine]])
        place = np.searchsorted(chosen, mesh.face[reliefs.corners[mine]])
        for turn in range(int(rank.max()) + 1):
            now, where = mine[rank == turn], place[rank == turn]
            normals = np.zeros((len(chosen), 3))
            levels = np.full(len(chosen), -np.inf)
            mates = np.full(len(chosen), -1)
            normals[where] = reliefs.normals[now]
            levels[where] = back[now] + dot(
                reliefs.normals[now], mesh.positions[reliefs.corners[now]]
            )
            mates[where] = reliefs.mates[now]
            solids, _ = clip(solids, normals, levels, Kind.RELIEF, mates, self.tol)
        tame = np.flatnonzero(~wild)
        order = np.empty(len(mesh), dtype=np.int64)
        order[np.concatenate([tame, chosen])] = np.arange(len(mesh))
        if len(tame) == 0:
            return solids
        regular = cycle.take(~wild).polyhedra(self.tol)
        return joined(regular, solids, order)

    def _trimmed(self, panels: Polyhedra) -> tuple[Polyhedra, IntArray]:
        assert self.floor is not None
        normal = np.array(self.floor.normal)
        left_panels, left = clip(
            panels,
            np.broadcast_to(normal, (len(panels), 3)),
            np.full(len(panels), float(normal @ np.array(self.floor.origin))),
            Kind.FLOOR,
            np.full(len(panels), -1),
            self.tol,
        )
        if not left.any():
            raise FloorError("The whole shell lies below the floor. Lower the floor.")
        return left_panels, np.flatnonzero(left)


@dataclass(frozen=True, eq=False)
class _Corners:
    """Where the neighbouring sides of each panel meet: base + level * rise."""

    base: FloatArray
    rise: FloatArray
    per_set_back: FloatArray
    ending: FloatArray
    kinds: IntArray
    mates: IntArray
    solid_offsets: IntArray

    def at(self, level: float) -> FloatArray:
        """Return the corner points at a height above the design face."""
        return self.base + level * self.rise

    @classmethod
    def between_cuts(cls, mesh: Mesh, cuts: FloatArray, set_backs: FloatArray) -> _Corners:
        return cls.with_reliefs(mesh, cuts, set_backs, Reliefs.none(), np.empty(0))

    @classmethod
    def with_reliefs(
        cls,
        mesh: Mesh,
        cuts: FloatArray,
        set_backs: FloatArray,
        reliefs: Reliefs,
        relief_set_backs: FloatArray,
    ) -> _Corners:
        """Meet the sides pair by pair, around each panel.

        At a mesh corner with r reliefs the cycle is: the cut before, relief 1, ..., relief r, the
        cut after; so r + 1 pairs.
        """
        before = mesh.previous
        edge_kinds = np.where(mesh.twin < 0, Kind.BORDER, Kind.CUT)
        edge_mates = np.where(mesh.twin < 0, -1, mesh.face[mesh.twin])
        if len(reliefs.corners) == 0:
            corner = np.arange(len(mesh.corners))
            ending, starting = cuts[before], cuts
            back_ending, back_starting = set_backs[before], set_backs
            kinds, mates = edge_kinds[before], edge_mates[before]
            solid_offsets = mesh.offsets
        else:
            order = np.lexsort((_turn(mesh, cuts, reliefs), reliefs.corners))
            count = np.bincount(reliefs.corners, minlength=len(mesh.corners))
            sides = offsets(count + 1)
            corner = np.repeat(np.arange(len(count)), count + 1)
            is_cut = np.zeros(len(corner), dtype=bool)
            is_cut[sides[:-1]] = True
            last = sides[1:] - 1
            ending = np.empty((len(corner), 3))
            ending[is_cut], ending[~is_cut] = cuts[before], reliefs.normals[order]
            back_ending = np.empty(len(corner))
            back_ending[is_cut] = set_backs[before]
            back_ending[~is_cut] = relief_set_backs[order]
            starting = np.roll(ending, -1, axis=0)
            starting[last] = cuts
            back_starting = np.roll(back_ending, -1)
            back_starting[last] = set_backs
            kinds = np.full(len(corner), int(Kind.RELIEF))
            kinds[is_cut] = edge_kinds[before]
            mates = np.empty(len(corner), dtype=np.int64)
            mates[is_cut], mates[~is_cut] = edge_mates[before], reliefs.mates[order]
            solid_offsets = sides[mesh.offsets]
        normal = mesh.normals[mesh.face[corner]]
        rise = cross(ending, starting)
        height = dot(rise, normal)[:, None]
        rise /= height
        from_ending = cross(starting, normal) / height
        from_starting = cross(normal, ending) / height
        base = mesh.positions[corner] + (
            back_ending[:, None] * from_ending + back_starting[:, None] * from_starting
        )
        return cls(base, rise, from_ending + from_starting, ending, kinds, mates, solid_offsets)


def _turn(mesh: Mesh, cuts: FloatArray, reliefs: Reliefs) -> FloatArray:
    """Return the angle by which each relief turns from the cut before it, seen from above."""
    first = cuts[mesh.previous[reliefs.corners]]
    up = mesh.normals[mesh.face[reliefs.corners]]
    flat = first - dot(first, up)[:, None] * up
    return np.arctan2(dot(cross(flat, reliefs.normals), up), dot(flat, reliefs.normals))


def _cut_normals(mesh: Mesh, axes: FloatArray | None, tol: Tolerance) -> FloatArray:
    """Return (corners, 3) unit normals of the cut planes, pointing into the panel."""
    own = mesh.normals[mesh.face]
    twin = mesh.twin
    if axes is None:
        within = own + np.where(twin[:, None] < 0, own, own[twin])
    else:
        within = axes[mesh.corners] + axes[mesh.corners[mesh.next]]
    size = np.sqrt(dot(within, within))
    folded = size <= tol.parallel
    if folded.any():
        names = mesh.names(mesh.face[folded])
        raise SelfIntersectionError(
            f"Faces fold back flat onto their neighbours: {listed(names)}. Open the fold.",
            addresses=names,
        )
    if axes is not None:  # a border stays square
        within = np.where(twin[:, None] < 0, own, within)
    return unit(cross(within, mesh.directions))


def _rank_within(owners: IntArray) -> IntArray:
    """Return the running number of each entry among those of the same owner."""
    order = np.argsort(owners, kind="stable")
    ordered = owners[order]
    first = np.searchsorted(ordered, ordered)
    rank = np.empty(len(owners), dtype=np.int64)
    rank[order] = np.arange(len(owners)) - first
    return rank
