"""The classic figures, each with the germ that it is usually drawn with.

All are about one unit large and start at the origin; `Figure.scaled` makes them mm, and
`Figure.with_germ` builds them of anything else. `CLASSICS` lists them all with what is known of
them.

Source: the paper, sections 2.1 and 2.2, figures 2 to 4 (Cantor set, von Koch curve, Sierpinski
triangle). The others are textbook: Barnsley, *Fractals Everywhere*; Falconer, *Fractal Geometry*;
Mandelbrot, *The Fractal Geometry of Nature*.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from types import MappingProxyType

import numpy as np

from ifs_cad.design.affine import homogeneous
from ifs_cad.design.figure import Figure
from ifs_cad.design.generator import from_generator, planar_maps
from ifs_cad.design.germ import Germ
from ifs_cad.design.reading import whole_number
from ifs_cad.errors import InputError
from ifs_cad.types import ArrayLike, FloatArray, vector

UP = math.sqrt(3.0) / 2.0  # height of an equilateral triangle of side 1
TRIANGLE = ((0.0, 0.0), (1.0, 0.0), (0.5, UP))
TETRAHEDRON = (*((x, y, 0.0) for x, y in TRIANGLE), (0.5, UP / 3.0, math.sqrt(2.0 / 3.0)))
TETRAHEDRON_FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
CUBE_FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
SQUARE_RING = (0, 2, 3, 1)  # the corners of `_corners(2)` in the order of the ring

__all__ = [
    "CLASSICS",
    "Classic",
    "barnsley_fern",
    "cantor_dust",
    "cantor_set",
    "heighway_dragon",
    "hilbert_curve",
    "levy_curve",
    "menger_sponge",
    "peano_curve",
    "pythagoras_tree",
    "sierpinski_carpet",
    "sierpinski_tetrahedron",
    "sierpinski_triangle",
    "takagi_curve",
    "twindragon",
    "von_koch_curve",
    "von_koch_outline",
    "von_koch_snowflake",
]


def cantor_set() -> Figure:
    """Return the Cantor set: a segment without its middle third; total length (2/3)^n.

    References
    ----------
    The paper, section 2.1, figure 2.
    """
    return Figure(_scaled_to([(0.0, 0.0), (2 / 3, 0.0)], 1 / 3), name="Cantor set")


def von_koch_curve(angle: float = 60.0) -> Figure:
    """Return the von Koch curve: four segments for each, of the length (4/3)^n at 60 degrees.

    Parameters
    ----------
    angle : float, degrees
        Of the spike at its feet, from 0 (a straight line) to less than 90.

    Raises
    ------
    InputError
        An angle out of range.

    References
    ----------
    The paper, section 2.1, figure 3.
    """
    turn = math.radians(float(vector([angle], "The angle of a von Koch curve", 1)[0]))
    if not 0.0 <= turn < math.pi / 2:
        raise InputError(f"The angle must be from 0 to less than 90 degrees, got {angle!r}.")
    side = 0.5 / (1.0 + math.cos(turn))
    tip = (0.5, side * math.sin(turn))
    return from_generator([(0, 0), (side, 0), tip, (1 - side, 0), (1, 0)], name="von Koch curve")


def von_koch_outline() -> tuple[Figure, Figure, Figure]:
    """Return the outline of the snowflake: three von Koch curves around the unit triangle.

    The area inside is that of the triangle times 1 + 3/5 (1 - (4/9)^n).
    """
    curve, (low, right, top) = von_koch_curve(), TRIANGLE
    sides = ((low, top), (top, right), (right, low))  # clockwise, so that spikes point outwards
    return tuple(  # type: ignore[return-value]
        curve.transformed([[x1 - x0, y0 - y1, x0], [y1 - y0, x1 - x0, y0]])
        for (x0, y0), (x1, y1) in sides
    )


def von_koch_snowflake() -> Figure:
    """Return the snowflake as an area: one copy turned in the middle and six small ones around.

    The scales, 1/sqrt(3) and six times 1/3, are unequal, and the areas of the parts add up to that
    of the whole. The germ is the hexagon of the snowflake's outer tips.
    """
    tips = np.exp(1j * np.pi * np.arange(6) / 3)
    turns = np.concatenate([[np.exp(1j * np.pi / 6) / math.sqrt(3)], np.full(6, 1 / 3)])
    maps = planar_maps(turns, np.concatenate([[0.0], tips * 2 / 3]))
    germ = Germ.polygon(np.stack([tips.real, tips.imag], axis=1))
    return Figure(maps, germ=germ, name="von Koch snowflake")


def sierpinski_triangle(corners: ArrayLike = TRIANGLE) -> Figure:
    """Return the Sierpinski triangle: 3^n triangles of the area (3/4)^n altogether.

    The transformations are barycentric and know nothing of the corners, which are control points:
    T_i goes half-way to the i-th.

    Parameters
    ----------
    corners : (3, 2) or (3, 3) array, mm
        P as rows; the equilateral triangle of side 1 by default.

    References
    ----------
    The paper, section 2.2, figure 4.
    """
    return _gasket(corners, [(0, 1, 2)], "Sierpinski triangle")


def sierpinski_carpet() -> Figure:
    """Return the Sierpinski carpet: a square without its middle ninth; area (8/9)^n."""
    cells = [cell for cell in product(range(3), repeat=2) if cell != (1, 1)]
    return Figure(_scaled_to(np.array(cells) / 3, 1 / 3), germ=_square(), name="Sierpinski carpet")


def heighway_dragon() -> Figure:
    """Return the dragon of a strip of paper folded in half n times and opened to right angles.

    Its 2^n segments have the length sqrt(2)^n; the second half runs backwards.
    """
    return from_generator([(0, 0), (0.5, 0.5), (1, 0)], reversed_parts=[1], name="Heighway dragon")


def levy_curve() -> Figure:
    """Return the Levy C curve: two segments at right angles for each; length sqrt(2)^n."""
    return from_generator([(0, 0), (0.5, 0.5), (1, 0)], name="Levy curve")


def hilbert_curve() -> Figure:
    """Return the Hilbert curve through the 4^n cells of the unit square.

    The germ is the centre of the square; `Figure.polyline` joins the centres of the cells. The
    first and last quarter are mirrored.
    """
    maps = np.array(
        [
            [[0.0, 0.5, 0.0], [0.5, 0.0, 0.0]],
            [[0.5, 0.0, 0.0], [0.0, 0.5, 0.5]],
            [[0.5, 0.0, 0.5], [0.0, 0.5, 0.5]],
            [[0.0, -0.5, 1.0], [-0.5, 0.0, 0.5]],
        ]
    )
    return Figure(maps, germ=[(0.5, 0.5)], name="Hilbert curve")


def peano_curve() -> Figure:
    """Return the Peano curve through the 9^n cells of the unit square, from corner to corner.

    The germ is the centre of the square; `Figure.polyline` joins the centres of the cells. Cells
    in the middle row are mirrored from left to right, those in the middle column upside down.
    """
    across = np.repeat(np.arange(3), 3)
    up = np.array([0, 1, 2, 2, 1, 0, 0, 1, 2])
    flip_x, flip_y = up % 2 == 1, across % 2 == 1
    linear = np.zeros((9, 2, 2))
    linear[:, 0, 0] = np.where(flip_x, -1, 1) / 3
    linear[:, 1, 1] = np.where(flip_y, -1, 1) / 3
    moves = np.stack([across + flip_x, up + flip_y], axis=1) / 3
    return Figure(homogeneous(linear, moves), germ=[(0.5, 0.5)], name="Peano curve")


def takagi_curve(weight: float = 0.5) -> Figure:
    """Return Takagi's curve, the blancmange: the graph of the sum of weight^k s(2^k x).

    s(x) is the distance from x to the nearest whole number. The maps shear, so they are no
    similarities. Weight 1/4 gives a parabola, 1/2 Takagi's own curve, more a rougher one: this is
    the paper's roughness in its simplest form.

    Parameters
    ----------
    weight : float
        Between -1 and 1.

    Raises
    ------
    InputError
        A weight out of range.

    References
    ----------
    The paper, section 3.2.1, figure 10 (smooth and rough).
    """
    share = float(vector([weight], "The weight of a Takagi curve", 1)[0])
    if not -1.0 < share < 1.0:
        raise InputError(f"The weight must be between -1 and 1, got {weight!r}.")
    maps = [[[0.5, 0.0, 0.0], [0.5, share, 0.0]], [[0.5, 0.0, 0.5], [-0.5, share, 0.5]]]
    return Figure(maps, name="Takagi curve")


def twindragon() -> Figure:
    """Return the twindragon: every construction step covers the area of the germ, a unit square.

    Without overlap, since the squares of a step are cells of one grid: numbers written in the base
    1 + i with the digits 0 and 1.
    """
    turn = np.array([0.5 - 0.5j, 0.5 - 0.5j])
    return Figure(planar_maps(turn, turn * [0, 1]), germ=_square(), name="twindragon")


def pythagoras_tree() -> Figure:
    """Return the Pythagoras tree: each square carries two smaller ones on a right angle.

    The tree is all construction steps together (`Figure.construction` of 0, 1, 2, ...); the
    attractor, a Levy curve, is only what its leaves tend to.
    """
    turns = np.array([0.5 + 0.5j, 0.5 - 0.5j])
    return Figure(
        planar_maps(turns, np.array([1j, 0.5 + 1.5j])), germ=_square(), name="Pythagoras tree"
    )


def barnsley_fern() -> Figure:
    """Return Barnsley's fern: stem, everything above, and a leaflet on either side.

    The maps are unequal and no similarities, the first flattens to a line; so construction steps
    converge slowly and `Figure.refined` or the chaos game show it better. The germ is the straight
    line from its foot to its tip.

    References
    ----------
    Barnsley, *Fractals Everywhere*, 1988, table 3.8.3 (the paper's reference 4).
    """
    maps = np.array(
        [
            [[0.0, 0.0, 0.0], [0.0, 0.16, 0.0]],
            [[0.85, 0.04, 0.0], [-0.04, 0.85, 1.6]],
            [[0.2, -0.26, 0.0], [0.23, 0.22, 1.6]],
            [[-0.15, 0.28, 0.0], [0.26, 0.24, 0.44]],
        ]
    )
    tip = np.linalg.solve(np.eye(2) - maps[1, :, :2], maps[1, :, 2])
    return Figure(maps, germ=np.vstack([0.0 * tip, tip]), name="Barnsley's fern")


def menger_sponge() -> Figure:
    """Return the Menger sponge, a cube pierced along its axes: 20^n cubes, volume (20/27)^n."""
    cells = [cell for cell in product(range(3), repeat=3) if cell.count(1) < 2]
    return Figure(_scaled_to(np.array(cells) / 3, 1 / 3), germ=_cube(), name="Menger sponge")


def sierpinski_tetrahedron(corners: ArrayLike = TETRAHEDRON) -> Figure:
    """Return the Sierpinski tetrahedron: 4^n tetrahedra of the volume (1/2)^n, the area staying.

    Parameters
    ----------
    corners : (4, 3) array, mm
        The control points, P as rows; the regular tetrahedron of side 1 by default.
    """
    return _gasket(corners, TETRAHEDRON_FACES, "Sierpinski tetrahedron")


def cantor_dust(ndim: int = 3) -> Figure:
    """Return Cantor dust: the small squares, or cubes, in the corners of the large one.

    Parameters
    ----------
    ndim : int
        2 in the plane, 3 in space: 8^n cubes of the volume (8/27)^n.

    Raises
    ------
    InputError
        Another number.
    """
    size = whole_number(ndim, "The number of dimensions", 2, 3)
    germ = _cube() if size == 3 else _square()
    return Figure(_scaled_to(2 / 3 * _corners(size), 1 / 3), germ=germ, name="Cantor dust")


@dataclass(frozen=True)
class Classic:
    """What is known of a classic figure.

    Attributes
    ----------
    make : callable
        Returns the figure.
    count : int
        N, the number of transformations.
    dimension : float or None
        Hausdorff dimension of the attractor; None where no closed form is known.
    by_similarity : bool
        Whether the maps are similarities that meet the open set condition, so that the dimension
        is that of Moran's equation.
    """

    make: Callable[[], Figure]
    count: int
    dimension: float | None
    by_similarity: bool = True


CLASSICS: Mapping[str, Classic] = MappingProxyType(
    {
        "Cantor set": Classic(cantor_set, 2, math.log(2, 3)),
        "von Koch curve": Classic(von_koch_curve, 4, math.log(4, 3)),
        "von Koch snowflake": Classic(von_koch_snowflake, 7, 2.0),
        "Sierpinski triangle": Classic(sierpinski_triangle, 3, math.log2(3)),
        "Sierpinski carpet": Classic(sierpinski_carpet, 8, math.log(8, 3)),
        "Heighway dragon": Classic(heighway_dragon, 2, 2.0),
        "Levy curve": Classic(levy_curve, 2, 2.0),
        "Hilbert curve": Classic(hilbert_curve, 4, 2.0),
        "Peano curve": Classic(peano_curve, 9, 2.0),
        # Mauldin and Williams, 1986: 1 in spite of the infinite length.
        "Takagi curve": Classic(takagi_curve, 2, 1.0, by_similarity=False),
        "twindragon": Classic(twindragon, 2, 2.0),
        "Pythagoras tree": Classic(pythagoras_tree, 2, 2.0),
        "Barnsley's fern": Classic(barnsley_fern, 4, None, by_similarity=False),
        "Menger sponge": Classic(menger_sponge, 20, math.log(20, 3)),
        "Sierpinski tetrahedron": Classic(sierpinski_tetrahedron, 4, 2.0),
        "Cantor dust": Classic(cantor_dust, 8, math.log(8, 3)),
    }
)
"""The classic figures by name."""


def _scaled_to(places: ArrayLike, scale: float) -> FloatArray:
    """Return the maps that scale and then move the origin to (N, d) places."""
    moves = np.array(places, dtype=float)
    linear = np.tile(scale * np.eye(moves.shape[1]), (len(moves), 1, 1))
    return homogeneous(linear, moves)


def _gasket(corners: ArrayLike, faces: Sequence[Sequence[int]], name: str) -> Figure:
    """Return the figure of maps half-way to each of the control points."""
    rows = np.array(corners, dtype=float)
    unit = np.eye(max(map(max, faces)) + 1)
    if rows.ndim != 2 or len(rows) != len(unit) or rows.shape[1] not in (2, 3):
        raise InputError(
            f"A {name} has {len(unit)} corners of 2 or 3 numbers each, got shape {rows.shape}."
        )
    # T_i moves every control point half-way to control point i: row i gains 1/2 throughout.
    maps = unit / 2 + unit[:, :, None] / 2
    return Figure(maps, rows.T, Germ(unit, faces=faces), name=name)


def _corners(ndim: int) -> FloatArray:
    """Return the corners of the unit square or cube, the last coordinate running fastest."""
    return np.array(list(product((0.0, 1.0), repeat=ndim)))


def _square() -> Germ:
    return Germ(_corners(2), faces=[SQUARE_RING])


def _cube() -> Germ:
    return Germ(_corners(3), faces=CUBE_FACES)
