"""Cut lists: what every element measures, which are equal, and where each lies.

A cut list counts the edges of an element counter-clockwise, seen from above as it lies on the
machine, in the order of the sides of its workpiece.

Source: section 4.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from ifs_cad.errors import InputError
from ifs_cad.fabrication.congruence import congruent_groups
from ifs_cad.fabrication.layout import Layout
from ifs_cad.fabrication.measure import larger_area, mass, side_edges
from ifs_cad.fabrication.table import Cell, Column, Table
from ifs_cad.fabrication.workpiece import Workpiece


@dataclass(frozen=True)
class Edge:
    """One side of an element.

    Attributes
    ----------
    upper, lower : float, length at the upper and at the lower face, mm; 0 where it misses the face
    inclination : float, degrees from the vertical, positive when the element is wider at its top
    kind : str, see `elements.polyhedron.Kind`
    neighbour : str, the address on the other side, or empty
    """

    upper: float
    lower: float
    inclination: float
    kind: str
    neighbour: str


@dataclass(frozen=True)
class Entry:
    """One element of a cut list.

    Attributes
    ----------
    address, material : str
    thickness : float, mm
    area : float, of the larger face, mm2
    mass : float, kg
    edges : tuple of Edge
    group : int, from 1; elements of one number are equal
    sheet : str, the name of its sheet; empty when it is not placed
    x, y, turn : float, mm and degrees, its place on the sheet; None when it is not placed
    """

    address: str
    material: str
    thickness: float
    area: float
    mass: float
    edges: tuple[Edge, ...]
    group: int
    sheet: str
    x: float | None
    y: float | None
    turn: float | None


@dataclass(frozen=True)
class CutList:
    """All elements, in the order of their workpieces.

    Attributes
    ----------
    entries : tuple of Entry
    groups : tuple of tuples of str, the addresses of equal elements
    """

    entries: tuple[Entry, ...]
    groups: tuple[tuple[str, ...], ...]

    @cached_property
    def tables(self) -> tuple[Table, ...]:
        """The list as tables: elements, edges, groups, summary."""
        return (self._elements, self._edges, self._groups, self._summary)

    @property
    def _elements(self) -> Table:
        most = max((len(entry.edges) for entry in self.entries), default=0)
        edges = [
            column
            for number in range(1, most + 1)
            for column in (
                Column(f"edge {number} upper (mm)"),
                Column(f"edge {number} lower (mm)"),
                Column(f"edge {number} inclination (deg)"),
                Column(f"edge {number} neighbour", "text"),
            )
        ]
        columns = (
            Column("address", "text"),
            Column("group", decimals=0),
            Column("material", "text"),
            Column("thickness (mm)"),
            Column("area (m2)", decimals=4),
            Column("mass (kg)", decimals=3),
            Column("sheet", "text"),
            Column("x (mm)"),
            Column("y (mm)"),
            Column("turn (deg)"),
            *edges,
        )
        return Table("elements", columns, tuple(_element_row(e, most) for e in self.entries))

    @property
    def _edges(self) -> Table:
        columns = (
            Column("address", "text"),
            Column("edge", decimals=0),
            Column("upper (mm)"),
            Column("lower (mm)"),
            Column("inclination (deg)"),
            Column("kind", "text"),
            Column("neighbour", "text"),
        )
        rows = tuple(
            (entry.address, number, e.upper, e.lower, e.inclination, e.kind, e.neighbour or None)
            for entry in self.entries
            for number, e in enumerate(entry.edges, start=1)
        )
        return Table("edges", columns, rows)

    @property
    def _groups(self) -> Table:
        columns = (
            Column("group", decimals=0),
            Column("count", decimals=0),
            Column("addresses", "text"),
        )
        rows = tuple(
            (number, len(group), " ".join(group))
            for number, group in enumerate(self.groups, start=1)
        )
        return Table("groups", columns, rows)

    @property
    def _summary(self) -> Table:
        columns = (
            Column("material", "text"),
            Column("thickness (mm)"),
            Column("elements", decimals=0),
            Column("area (m2)", decimals=4),
            Column("mass (kg)", decimals=3),
            Column("contour (m)", decimals=3),
        )
        stacks: dict[tuple[str, float], list[Entry]] = {}
        for entry in self.entries:
            stacks.setdefault((entry.material, entry.thickness), []).append(entry)
        rows = tuple(
            (
                material,
                thickness,
                len(stack),
                sum(entry.area for entry in stack) / 1e6,
                sum(entry.mass for entry in stack),
                sum(max(e.upper, e.lower) for entry in stack for e in entry.edges) / 1e3,
            )
            for (material, thickness), stack in stacks.items()
        )
        return Table("summary", columns, rows)


def cut_list(
    workpieces: Sequence[Workpiece], layout: Layout | None = None, *, tolerance: float = 0.1
) -> CutList:
    """List what every element measures.

    Parameters
    ----------
    workpieces : sequence of Workpiece
    layout : Layout, optional
        Where they lie; without one the places stay empty.
    tolerance : float, mm
        Elements whose corners lie closer than this count as equal, see `congruence`.

    Raises
    ------
    InputError
        A layout that does not place every workpiece, two workpieces with one address.
    """
    require_unique(workpieces)
    if layout is not None:
        missing = [w.address for w in workpieces if w.address not in layout.homes]
        if missing:
            raise InputError(
                f"The layout places no {', '.join(missing[:5])}: it was made for other workpieces.",
                addresses=missing,
            )
    groups = congruent_groups(workpieces, tolerance)
    group_of = {m.index: number for number, group in enumerate(groups, start=1) for m in group}
    return CutList(
        entries=tuple(
            _entry(workpiece, group_of[index], layout) for index, workpiece in enumerate(workpieces)
        ),
        groups=tuple(tuple(workpieces[m.index].address for m in group) for group in groups),
    )


def require_unique(workpieces: Sequence[Workpiece]) -> None:
    """Make sure that every address is given once.

    Raises
    ------
    InputError
    """
    seen: set[str] = set()
    for workpiece in workpieces:
        if workpiece.address in seen:
            raise InputError(
                f"Two workpieces have the address {workpiece.address}: a list needs each once.",
                addresses=(workpiece.address,),
            )
        seen.add(workpiece.address)


def _entry(workpiece: Workpiece, group: int, layout: Layout | None) -> Entry:
    meets = side_edges(workpiece)
    sheet, place = layout.homes[workpiece.address] if layout else (None, None)
    return Entry(
        address=workpiece.address,
        material=workpiece.material.name,
        thickness=workpiece.thickness,
        area=larger_area(workpiece),
        mass=mass(workpiece),
        edges=tuple(
            Edge(upper, lower, side.inclination, side.kind, side.neighbour)
            for upper, lower, side in zip(
                meets.upper_lengths.tolist(),
                meets.lower_lengths.tolist(),
                workpiece.sides,
                strict=True,
            )
        ),
        group=group,
        sheet=sheet.name if sheet else "",
        x=place.x if place else None,
        y=place.y if place else None,
        turn=place.turn if place else None,
    )


def _element_row(entry: Entry, most: int) -> tuple[Cell, ...]:
    row: list[Cell] = [
        entry.address,
        entry.group,
        entry.material,
        entry.thickness,
        entry.area / 1e6,
        entry.mass,
        entry.sheet or None,
        entry.x,
        entry.y,
        entry.turn,
    ]
    for edge in entry.edges:
        row += [edge.upper, edge.lower, edge.inclination, edge.neighbour or None]
    row += [None] * (4 * (most - len(entry.edges)))
    return tuple(row)
