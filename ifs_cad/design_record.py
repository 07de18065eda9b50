"""A design as it is saved: two curves, and how panels are made of their vector sum.

Only what the designer set is kept, in plain numbers; curves, surface and panels are built from it
on demand, the same ones every time.

Terms
-----
moved subdivision point : one that the designer put somewhere. It is kept as its place and weight;
    the others stand where the scheme of de Casteljau and the roughness put them.

Source: the paper, sections 3.1 to 3.4 (what a designer edits), 4.2 and 4.3 (panels).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from ifs_cad.design.curve import DEEPEST, Curve
from ifs_cad.design.mesh import Mesh
from ifs_cad.design.reading import read_points, read_weights, whole_number
from ifs_cad.design.surface import vector_sum
from ifs_cad.design.transform import Scheme
from ifs_cad.elements.fibre import Fibre
from ifs_cad.elements.hole import Holes
from ifs_cad.elements.label import Label
from ifs_cad.elements.material import SPRUCE, SPRUCE_PLYWOOD, Material
from ifs_cad.elements.panel import Shell
from ifs_cad.elements.thicken import Nodes, Side, Thickening
from ifs_cad.errors import InputError
from ifs_cad.tolerance import DEFAULT
from ifs_cad.types import ArrayLike, Plane, number

Point = tuple[float, float, float]

MATERIALS = {material.name: material for material in (SPRUCE_PLYWOOD, SPRUCE)}
"""The materials that a design can name."""

UP = (0.0, 0.0, 1.0)

MOST_TRANSFORMATIONS = 64
"""A curve split in more parts by one step has no use, and its scheme would fill the memory."""

__all__ = ["MATERIALS", "Design", "DrawnCurve", "Point", "SubdivisionPoint"]


@dataclass(frozen=True)
class SubdivisionPoint:
    """A subdivision point that the designer moved.

    Parameters
    ----------
    name : str
        ``s2``, ``s3``, ... as `Curve` names them.
    point : (3,) floats, mm
    weight : float
    """

    name: str
    point: Point
    weight: float = 1.0

    def __post_init__(self) -> None:
        what = f"Subdivision point {self.name}"
        object.__setattr__(self, "point", _points([self.point], what)[0])
        object.__setattr__(self, "weight", read_weights([self.weight], 1).tolist()[0])


@dataclass(frozen=True)
class DrawnCurve:
    """One of the two curves as the designer drew it.

    Parameters
    ----------
    control_points : (m, 3) floats, mm
        At least two; those in the plane get z = 0.
    weights : m floats, optional
        Of the control points, 1 by default.
    depth : int
        Number of construction steps; an even fold adds one.
    transformations : int
        N, how many parts one step makes of each piece.
    closed : bool
        Come back to the first control point.
    symmetric : bool
        Tie each subdivision point to its mirror image; one of the two is kept.
    roughness : float
        Of the subdivision points that were not moved, see `Curve.with_roughness`.
    fold : float, optional
        Slope of the even fold, rise over run.
    moved : SubdivisionPoint, any number
        The subdivision points that were moved.

    Raises
    ------
    InputError
        A value that cannot be meant, or a subdivision point that the curve does not have.
    WeightError
        A weight that is not positive.
    """

    control_points: tuple[Point, ...]
    weights: tuple[float, ...] = ()
    depth: int = 4
    transformations: int = 2
    closed: bool = False
    symmetric: bool = False
    roughness: float = 0.0
    fold: float | None = None
    moved: tuple[SubdivisionPoint, ...] = ()

    def __post_init__(self) -> None:
        points = _points(self.control_points, "Control points")
        if len(points) < 2:
            raise InputError(f"A curve needs at least 2 control points, got {len(points)}.")
        values = {
            "control_points": points,
            "weights": tuple(
                read_weights(self.weights if len(self.weights) else None, len(points)).tolist()
            ),
            "depth": whole_number(self.depth, "The iteration depth", 0, DEEPEST),
            "transformations": whole_number(
                self.transformations, "The number of transformations", 2, MOST_TRANSFORMATIONS
            ),
            "roughness": _finite(self.roughness, "Roughness"),
            "fold": None if self.fold is None else _finite(self.fold, "The slope of a fold"),
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)
        if self.fold == 0.0:
            raise InputError("The slope of a fold must not be 0; leave it out for no fold.")
        if self.roughness:
            self.plain_scheme.with_roughness(self.roughness)  # raises what it refuses
        object.__setattr__(self, "moved", self._in_order(self.moved))

    @property
    def plain_scheme(self) -> Scheme:
        """The scheme before roughness and moved points."""
        size = len(self.control_points) + bool(self.closed)
        return Scheme.de_casteljau(size, self.transformations)

    def base(self) -> Curve:
        """Return the curve before its fold, which has the handles.

        Raises
        ------
        GeometryError
            A subdivision point out of reach, or without a weight.
        InputError
            Control points all in one place.
        """
        curve = Curve(
            self.control_points,
            weights=self.weights,
            depth=self.depth,
            transformations=self.transformations,
            closed=self.closed,
        )
        if self.roughness:
            curve = curve.with_roughness(self.roughness)
        if self.symmetric:
            curve = curve.with_symmetry()
        for item in self.moved:
            curve = curve.with_subdivision_point(item.name, item.point, item.weight)
        return curve

    def curve(self) -> Curve:
        """Return the curve.

        Raises
        ------
        GeometryError
            As `base`, or a fold that is not steep enough.
        """
        base = self.base()
        return base if self.fold is None else base.with_even_fold(self.fold, UP)

    def _in_order(self, moved: Iterable[SubdivisionPoint]) -> tuple[SubdivisionPoint, ...]:
        """Return moved points by their first names in the order of the scheme, each once."""
        scheme = self.plain_scheme
        placed: dict[int, SubdivisionPoint] = {}
        if self.symmetric:
            scheme = scheme.with_symmetry()
        for item in moved:
            row = scheme.free_index(item.name)
            own = scheme.names[row]
            taken = {own, scheme.partner(own)} & {scheme.names[other] for other in placed}
            if taken:
                raise InputError(
                    f"Subdivision point {item.name} is {taken.pop()}, or its mirror image, which "
                    "is placed already. Leave one of the two out."
                )
            placed[row] = replace(item, name=own)
        return tuple(placed[row] for row in sorted(placed))


@dataclass(frozen=True)
class Design:
    """A shell of two curves.

    Parameters
    ----------
    a, b : DrawnCurve
    thickness : float, mm
    side, nodes, clearance
        As of `thicken`.
    floor : float, optional
        Height of a level floor that trims the panels, mm.
    material : str
        A name in `MATERIALS`.
    fibre : Fibre, optional
    label : Label, optional
    holes : Holes, optional
    nest : int
        How many digits of the address group the panels into sub-assemblies.
    title : str
        One line.

    Raises
    ------
    InputError
        A value that cannot be meant.
    """

    a: DrawnCurve
    b: DrawnCurve
    thickness: float
    side: Side = "outer"
    nodes: Nodes = "relief"
    clearance: float = 0.0
    floor: float | None = None
    material: str = SPRUCE_PLYWOOD.name
    fibre: Fibre | None = None
    label: Label | None = None
    holes: Holes | None = None
    nest: int = 0
    title: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "thickness", number(self.thickness, "Thickness"))
        object.__setattr__(self, "clearance", number(self.clearance, "Clearance"))
        if self.floor is not None:
            object.__setattr__(self, "floor", _finite(self.floor, "The height of the floor"))
        object.__setattr__(self, "nest", whole_number(self.nest, "nest", 0))
        if self.material not in MATERIALS:
            raise InputError(
                f"There is no material {self.material!r}; a design can name "
                f"{', '.join(map(repr, MATERIALS))}."
            )
        if not (isinstance(self.title, str) and self.title.isprintable()):
            raise InputError(f"The title must be one line of text, got {self.title!r}.")
        _ = self.thickening  # raises what it refuses

    @property
    def sheet_material(self) -> Material:
        """What the panels are made of."""
        return MATERIALS[self.material]

    @property
    def thickening(self) -> Thickening:
        """How the panels are made."""
        return Thickening(
            self.thickness,
            self.side,
            self.clearance,
            self.nodes,
            None if self.floor is None else Plane((0.0, 0.0, self.floor), UP),
            2.0 * self.thickness,
            self.sheet_material,
            DEFAULT,
        )

    def curves(self) -> tuple[Curve, Curve]:
        """Return the two curves; raises what `DrawnCurve.curve` raises."""
        return self.a.curve(), self.b.curve()

    def surface(self) -> Mesh:
        """Return the vector sum of the two curves; raises what `vector_sum` raises."""
        return vector_sum(*self.curves())

    def shell(self) -> Shell:
        """Return the panels; raises what `thicken` and `Shell.with_fibre` raise."""
        return self.thickening(self.surface()).with_fibre(self.fibre)


def _points(points: ArrayLike, what: str) -> tuple[Point, ...]:
    return tuple((x, y, z) for x, y, z in read_points(points, what).tolist())


def _finite(value: float, what: str) -> float:
    read = number(value, what)
    if not np.isfinite(read) or isinstance(value, bool):
        raise InputError(f"{what} must be a finite number, got {value!r}.")
    return read
