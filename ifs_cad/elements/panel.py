"""Panels: the elements of a shell, as planes and corners.

A `Shell` holds all its panels in flat arrays; a `Panel` is a view of one of them. The *inner* face
of a panel lies on the negative side of its normal, the *outer* face on the positive side. The
*chamfer angle* of an edge is the angle between its cut plane and the square one, positive when the
panel widens along its normal.

Source: section 4.2 (panels with chamfers) and 4.3 (addresses).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal, cast, get_args

import numpy as np

from ifs_cad.design.address import matching
from ifs_cad.design.mesh import Mesh
from ifs_cad.elements.fibre import Fibre, fibre_data
from ifs_cad.elements.floor import Opening, openings
from ifs_cad.elements.material import Material
from ifs_cad.elements.polyhedron import Kind, Polyhedra, Prismatoids, ranges
from ifs_cad.elements.report import ReliefCut, Report
from ifs_cad.errors import AddressError, InputError
from ifs_cad.tolerance import Tolerance
from ifs_cad.types import ArrayLike, FloatArray, IntArray
from ifs_cad.vectors import cross, dot, length, unit

Face = Literal["inner", "outer"]


@dataclass(frozen=True, eq=False)
class Shell:
    """Panels made from the faces of a mesh. Made by `thicken`.

    Attributes
    ----------
    mesh : Mesh
    thickening : Thickening
        What made it: thickness, side, clearance, nodes, floor, material, tolerance.
    faces : (p,) int, the mesh face of each panel; the floor may have taken some
    solids : Polyhedra
        The panels' exact shapes; mates are mesh faces.
    plain : Prismatoids
        All faces of the mesh as panels without relief cuts and floor.
    whole : Polyhedra
        The same with relief cuts, before the floor trimmed them.
    cuts : (corners, 3) float, inward unit normals of the cut planes of the mesh's half-edges
    set_backs : (corners,) float, how far each is set back, mm
    lost : addresses of the panels that lie below the floor and are not made
    fibre : Fibre, the rule for the grain of the outer plies; None where it may run as it likes
    """

    mesh: Mesh
    thickening: Any = field(repr=False)
    faces: IntArray = field(repr=False)
    solids: Polyhedra = field(repr=False)
    plain: Prismatoids = field(repr=False)
    whole: Polyhedra = field(repr=False)
    cuts: FloatArray = field(repr=False)
    set_backs: FloatArray = field(repr=False)
    lost: tuple[str, ...] = ()
    fibre: Fibre | None = None

    def __len__(self) -> int:
        """Return the number of panels."""
        return len(self.faces)

    def __iter__(self) -> Iterator[Panel]:
        """Iterate over the panels."""
        return (Panel(self, i) for i in range(len(self)))

    def __getitem__(self, address: str) -> Panel:
        """Return the panel at an address.

        Raises
        ------
        AddressError
        """
        if address not in self._number:
            near = ", ".join(self.addresses[:3])
            raise AddressError(
                f"No panel has the address {address!r}; addresses look like {near}.",
                addresses=(str(address),),
            )
        return Panel(self, self._number[address])

    @cached_property
    def _number(self) -> dict[str, int]:
        return {address: i for i, address in enumerate(self.addresses)}

    @cached_property
    def addresses(self) -> tuple[str, ...]:
        """The panels' addresses."""
        return tuple(self.mesh.addresses[i] for i in self.faces)

    @property
    def cut_from(self) -> Literal["sheets"]:
        """Panels are cut from sheets."""
        return "sheets"

    @property
    def thickness(self) -> float:
        """Thickness of every panel, mm."""
        return float(self.thickening.thickness)

    @property
    def along(self) -> None:
        """No direction of their own: text runs level on panels."""
        return None

    @cached_property
    def fibres(self) -> FloatArray | None:
        """(p, 3) float, unit vectors in the planes of the panels; None without a rule."""
        return None if self.fibre is None else self.fibre.directions(self.mesh, self.faces)

    @property
    def mate_addresses(self) -> tuple[str, ...]:
        """What the mates of the panels' faces are called: the faces of the mesh."""
        return self.mesh.addresses

    @property
    def material(self) -> Material:
        """What the panels are made of."""
        return cast(Material, self.thickening.material)

    @property
    def tol(self) -> Tolerance:
        """Tolerances of the design."""
        return self.mesh.tol

    @cached_property
    def normals(self) -> FloatArray:
        """(p, 3) float, unit normals, from the inner to the outer face."""
        return self.mesh.normals[self.faces]

    @cached_property
    def volumes(self) -> FloatArray:
        """(p,) float, mm3, in closed form."""
        return self.solids.volumes

    @cached_property
    def areas(self) -> FloatArray:
        """(p,) float, the larger of the two faces of each panel, mm2."""
        caps = self.solids.kinds <= Kind.UPPER
        areas = np.where(caps, self.solids.face_areas, 0.0)
        return np.maximum.reduceat(areas, self.solids.solid_offsets[:-1])

    @cached_property
    def masses(self) -> FloatArray:
        """(p,) float, kg."""
        return self.volumes * 1e-9 * self.material.density

    @cached_property
    def relief_share(self) -> FloatArray:
        """(p,) float, share of the volume of each panel that relief cuts took."""
        share = 1.0 - self.whole.volumes / self.plain.polyhedra(self.mesh.tol).volumes
        return np.asarray(share[self.faces])

    @cached_property
    def chamfer_angles(self) -> FloatArray:
        """(corners,) float, degrees, of the mesh's half-edges."""
        normal = self.mesh.normals[self.mesh.face]
        square = cross(normal, self.mesh.directions)
        return np.degrees(np.arctan2(dot(self.cuts, normal), dot(self.cuts, square)))

    @cached_property
    def corner_rises(self) -> FloatArray:
        """(corners, 3) float, from a node along the meet of two cut planes, per mm of height."""
        rise = cross(self.cuts[self.mesh.previous], self.cuts)
        return rise / dot(rise, self.mesh.normals[self.mesh.face])[:, None]

    @cached_property
    def node_gaps(self) -> FloatArray:
        """(v,) float, largest distance of the offset corners of each node, mm.

        Zero at a conical node. With node axes this is the lip. Borders with one face have none.
        """
        one, other = self.mesh.same_node
        reach = max(abs(level) for level in self.thickening.levels)
        apart = reach * length(self.corner_rises[one] - self.corner_rises[other])
        gaps = np.zeros(len(self.mesh.vertices))
        inside = ~self._on_border[self.mesh.corners[one]]
        np.maximum.at(gaps, self.mesh.corners[one[inside]], apart[inside])
        return gaps

    @cached_property
    def _on_border(self) -> np.ndarray:
        on_border = np.zeros(len(self.mesh.vertices), dtype=bool)
        edge = self.mesh.twin < 0
        on_border[self.mesh.corners[edge]] = True
        on_border[self.mesh.corners[self.mesh.next[edge]]] = True
        return on_border

    @cached_property
    def conicity(self) -> FloatArray:
        """(v,) float, degrees, how far each inner node is from conical: 0 is exact.

        The half-angle between the face normals and the one axis that fits them best, at worst.
        """
        total = np.zeros((len(self.mesh.vertices), 3, 3))
        towards = np.zeros((len(self.mesh.vertices), 3))
        normal = self.mesh.normals[self.mesh.face]
        np.add.at(total, self.mesh.corners, normal[:, :, None] * normal[:, None, :])
        np.add.at(towards, self.mesh.corners, normal)
        inner = ~self._on_border & (self.mesh.valences > 3)
        axis = np.zeros_like(towards)
        # the axis l with n . l = 1 for every face around the node, by least squares
        axis[inner] = (np.linalg.pinv(total[inner]) @ towards[inner, :, None])[..., 0]
        axis[inner] = unit(axis[inner])
        tilt = np.degrees(np.arccos(np.clip(dot(axis[self.mesh.corners], normal), -1, 1)))
        highest, lowest = np.full((2, len(axis)), np.nan)
        np.fmax.at(highest, self.mesh.corners, tilt)
        np.fmin.at(lowest, self.mesh.corners, tilt)
        return np.where(inner, highest - lowest, 0.0)

    @cached_property
    def stubs(self) -> tuple[str, ...]:
        """Addresses of the panels that the floor leaves lower than the minimum height."""
        floor = self.thickening.floor
        if floor is None:
            return ()
        top = np.full(len(self), -np.inf)
        np.maximum.at(top, self.solids.solid_of_vertex, floor.height(self.solids.vertices))
        return tuple(self.addresses[i] for i in np.flatnonzero(top < self.thickening.min_height))

    @cached_property
    def openings(self) -> tuple[Opening, ...]:
        """Designed borders that do not stand on the floor."""
        floor = self.thickening.floor
        return () if floor is None else openings(self.mesh, floor, self.mesh.tol)

    @cached_property
    def relief_cuts(self) -> tuple[ReliefCut, ...]:
        """Every relief cut, panel by panel."""
        solids = self.solids
        cut = np.flatnonzero(solids.kinds == Kind.RELIEF)
        longest = np.maximum.reduceat(solids.edge_lengths, solids.face_offsets[:-1])[cut]
        owner = solids.solid_of_face[cut]
        return tuple(
            ReliefCut(self.addresses[panel], self.mesh.addresses[mate], size, share)
            for panel, mate, size, share in zip(
                owner.tolist(),
                solids.mates[cut].tolist(),
                longest.tolist(),
                self.relief_share[owner].tolist(),
                strict=True,
            )
        )

    def part_data(self) -> list[dict[str, Any]]:
        """Return for each panel what an assembly says of its part.

        address, thickness (mm), area (mm2), mass (kg), edge by edge chamfer_angles (degrees) and
        neighbours, and the fibre direction as a unit vector where there is a rule for it.
        """
        angles, starts = self.chamfer_angles.tolist(), self.mesh.offsets.tolist()
        return [
            {
                "address": address,
                "thickness": self.thickness,
                "area": area,
                "mass": mass,
                "chamfer_angles": angles[starts[face] : starts[face + 1]],
                "neighbours": self.mesh.neighbours(face),
                **fibre,
            }
            for address, area, mass, face, fibre in zip(
                self.addresses,
                self.areas.tolist(),
                self.masses.tolist(),
                self.faces.tolist(),
                fibre_data(self.fibres, len(self)),
                strict=True,
            )
        ]

    def report(self) -> Report:
        """Return the numbers that a designer and a workshop look at first."""
        mesh = self.mesh
        heaviest = int(np.argmax(self.masses))
        made = np.isin(mesh.face, self.faces)
        joint = made & (mesh.twin >= 0)
        gaps = (self.set_backs + self.set_backs[mesh.twin])[joint]
        nodes = mesh.corners[made]
        return Report(
            panels=len(self),
            area=float(self.areas.sum()) / 1e6,
            mass=float(self.masses.sum()),
            heaviest=(self.addresses[heaviest], float(self.masses[heaviest])),
            thickness=self.thickness,
            material=self.material.name,
            chamfer_angles=_extent(np.abs(self.chamfer_angles[joint])),
            edges=_extent(mesh.edge_lengths[made]),
            node_gap=float(self.node_gaps[nodes].max()),
            node_gap_name="lip" if self.thickening.nodes == "axis" else "node gap",
            least_conical=float(self.conicity[nodes].max()),
            relief_cuts=self.relief_cuts,
            joint_gap=_extent(gaps),
            lost=self.lost,
            stubs=self.stubs,
            openings=self.openings,
        )

    def with_fibre(self, rule: Fibre | None) -> Shell:
        """Return the same panels with a rule for their fibre direction, or with none.

        Raises
        ------
        InputError
            The rule says nothing about some panels; names them.
        """
        ruled = replace(self, fibre=rule)
        ruled.fibres  # noqa: B018  raises now rather than in the workshop
        return ruled

    def without(self, patterns: str | Iterable[str]) -> Shell:
        """Leave panels out (a door): their neighbours' edges become square borders.

        Raises
        ------
        AddressError
            No address matches.
        InputError
            Nothing would be left.
        """
        remake: Callable[[Mesh], Shell] = self.thickening
        leaving = matching(self.addresses, patterns)
        if leaving.all():
            raise InputError(f"Leaving out {patterns!r} leaves no panel.")
        gone = np.zeros(len(self.mesh), dtype=np.bool_)
        gone[self.faces[leaving]] = True
        rest = replace(remake(self.mesh.less(gone)), fibre=self.fibre)
        made = np.zeros(len(self.mesh), dtype=np.bool_)
        made[self.faces] = True
        kept = made[~gone][rest.faces]  # a part stays a part
        return rest if kept.all() else rest.take(np.flatnonzero(kept))

    def part(self, patterns: str | Iterable[str]) -> Shell:
        """Take some panels out as they are, with the chamfers they have in the whole.

        Raises
        ------
        AddressError
            No address matches.
        """
        return self.take(np.flatnonzero(matching(self.addresses, patterns)))

    def take(self, numbers: ArrayLike) -> Shell:
        """Return the panels of these numbers as they are."""
        chosen = np.asarray(numbers, dtype=np.int64)
        return replace(self, faces=self.faces[chosen], solids=self.solids.take(chosen))


@dataclass(frozen=True, eq=False)
class Panel:
    """One panel of a shell."""

    shell: Shell = field(repr=False)
    index: int

    @property
    def address(self) -> str:
        """What files and messages call the panel."""
        return self.shell.addresses[self.index]

    @property
    def face(self) -> int:
        """The mesh face it is made from."""
        return int(self.shell.faces[self.index])

    @cached_property
    def solid(self) -> Polyhedra:
        """Its shape."""
        return self.shell.solids.take(np.array([self.index]))

    @property
    def normal(self) -> FloatArray:
        """(3,) float, from the inner to the outer face."""
        return np.asarray(self.shell.normals[self.index])

    @property
    def thickness(self) -> float:
        """Thickness in mm."""
        return self.shell.thickness

    @property
    def area(self) -> float:
        """Area of the larger face, mm2."""
        return float(self.shell.areas[self.index])

    @property
    def volume(self) -> float:
        """Volume in mm3, closed form."""
        return float(self.shell.volumes[self.index])

    @property
    def mass(self) -> float:
        """Mass in kg."""
        return float(self.shell.masses[self.index])

    @cached_property
    def half_edges(self) -> IntArray:
        """(k,) int, its half-edges in the mesh."""
        starts = self.shell.mesh.offsets
        return ranges(starts[[self.face]], starts[[self.face + 1]])

    @property
    def chamfer_angles(self) -> FloatArray:
        """(k,) float, degrees, in the order of the edges of the design face."""
        return self.shell.chamfer_angles[self.half_edges]

    @property
    def edge_lengths(self) -> FloatArray:
        """(k,) float, edges of the design face, mm."""
        return self.shell.mesh.edge_lengths[self.half_edges]

    @property
    def neighbours(self) -> list[str]:
        """Addresses across its edges, in their order; empty text at a border."""
        return self.shell.mesh.neighbours(self.face)


def require_face(face: str) -> Face:
    """Read the name of a face.

    Raises
    ------
    InputError
    """
    if face not in get_args(Face):
        raise InputError(f'A face must be "inner" or "outer", got {face!r}.')
    return cast(Face, face)


def _extent(values: FloatArray) -> tuple[float, float]:
    """Return the smallest and the largest of some values, zeros when there are none."""
    return (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)
