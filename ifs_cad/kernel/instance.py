"""Construction elements as germs: any CadQuery shape, placed by every map of a figure.

Copies whose maps are similarities of one factor are one shape in many places; general affine maps
make shapes of their own, with B-spline surfaces where the germ had planes (OpenCascade transforms
so).

Source: section 2.2 (instead of fishes, construction elements such as beams or panels) and 3.1.
"""

from __future__ import annotations

from collections.abc import Sequence

import cadquery as cq
import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt, gp_Trsf

from ifs_cad import progress
from ifs_cad.design.affine import Placements
from ifs_cad.errors import GeometryError, InputError
from ifs_cad.kernel.solid import location
from ifs_cad.types import FloatArray

Colour = tuple[float, float, float]

WOOD: Colour = (0.87, 0.72, 0.50)


def place_germ(
    germ: cq.Shape | cq.Workplane,
    placements: Placements,
    *,
    name: str = "figure",
    colours: Sequence[Colour] = (WOOD,),
) -> cq.Assembly:
    """Return the copies of a germ as an assembly whose parts are named by address.

    Parameters
    ----------
    germ : cadquery Shape or Workplane
        Drawn where the figure's germ would lie; shapes of any kind.
    placements : Placements
        `figure.placements(depth)`; maps of the plane act in the xy plane and scale z alike.
    name : str
        Of the whole assembly.
    colours : of the parts, red, green and blue from 0 to 1
        The last digit of the address chooses, cyclically.

    Raises
    ------
    InputError
        A germ without any shape, or no colour.
    GeometryError
        Maps that flatten the germ; names the elements.
    """
    shape = _shape(germ)
    if not colours:
        raise InputError("The copies need at least one colour.")
    placements = placements.in_space()
    flat = np.linalg.det(placements.linear) == 0.0
    if flat.any():
        names = [placements.addresses[i] for i in np.flatnonzero(flat)]
        raise GeometryError(
            f"The maps of {len(names)} elements, {names[0]} first, flatten the germ.",
            addresses=names,
        )
    different = placements.shapes()
    similar = np.zeros(len(different.matrices), dtype=bool)
    similar[different.of] = placements.similar
    made = [_stretched(shape, m, s) for m, s in zip(different.matrices, similar, strict=True)]
    paints = [cq.Color(*colour) for colour in colours]
    assembly = cq.Assembly(name=name)
    turned = placements.rotations.swapaxes(1, 2)  # columns of a rotation are its axes
    for k, address in enumerate(placements.addresses):
        place = cq.Location(location(turned[k], placements.translations[k]))
        paint = paints[_last_digit(address) % len(paints)]
        part = cq.Assembly(made[different.of[k]], loc=place, name=address, color=paint)
        part.parent = assembly
        assembly.children.append(part)
        assembly.objects[address] = part
        progress.report("placing germs", k + 1, len(placements))
    return assembly


def _shape(germ: cq.Shape | cq.Workplane) -> cq.Shape:
    shapes = germ.vals() if isinstance(germ, cq.Workplane) else [germ]
    solid = [shape for shape in shapes if isinstance(shape, cq.Shape)]
    if not solid:
        raise InputError("The germ holds no shape. Draw something first.")
    return solid[0] if len(solid) == 1 else cq.Compound.makeCompound(solid)


def _stretched(shape: cq.Shape, matrix: FloatArray, similar: bool) -> cq.Shape:
    """Return the germ under the part of a map that is no motion: a stretch, mirrored or not."""
    if similar:
        scaling = gp_Trsf()
        scaling.SetScaleFactor(float(np.abs(matrix[0, 0])))
        if matrix[2, 2] < 0:
            mirror = gp_Trsf()
            mirror.SetMirror(gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)))
            scaling.PreMultiply(mirror)
        return cq.Shape.cast(BRepBuilderAPI_Transform(shape.wrapped, scaling, True).Shape())
    rows = np.column_stack([matrix, np.zeros(3)]).tolist()
    return shape.transformGeometry(cq.Matrix(rows))


def _last_digit(address: str) -> int:
    digit = address.rsplit(".", 1)[-1][-1:]
    return int(digit) if digit.isdigit() else 0
