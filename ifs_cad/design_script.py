"""A saved design written out as an ordinary part script.

The script has the numbers that a designer turns most as parameters at its top, makes the same
shell, and can be changed from there by hand.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import fields
from typing import Any

from ifs_cad.design_record import Design, DrawnCurve
from ifs_cad.elements.material import SPRUCE_PLYWOOD

__all__ = ["to_script"]

WIDTH = 100
INDENT = 4

PARAMETERS = ("depth", "cutter", "diameter", "inset")
"""What a script has as parameters of labels and holes."""


def to_script(design: Design) -> str:
    """Return the text of a part script that makes the same shell.

    Thickness, side, depths, roughness, folds, floor, label and holes become parameters at the top
    level, so that ``ifs-cad build --set`` can change them.

    Parameters
    ----------
    design : Design

    Returns
    -------
    str
        Python source.
    """
    title = design.title or "A shell of two curves"
    escaped = title.replace("\\", "\\\\").replace('"', '\\"')
    blocks = [
        [f'"""{escaped}{"" if escaped.endswith((".", "!", "?")) else "."}"""'],
        ["import ifs_cad as ifs"],
        [
            'if "show_object" not in globals():  # injected by CQGI and CQ-editor',
            "    from ifs_cad import show_object",
        ],
        list(_parameters(design)),
        list(_curve("a", design.a)),
        list(_curve("b", design.b)),
        list(_shell(design)),
    ]
    if design.material != SPRUCE_PLYWOOD.name:
        blocks[1].append("from ifs_cad.design_record import MATERIALS")
    return "\n\n".join("\n".join(block) for block in blocks) + "\n"


def _parameters(design: Design) -> Iterator[str]:
    for name, curve in (("a", design.a), ("b", design.b)):
        yield f"{name}_depth = {curve.depth}"
        if curve.roughness:
            yield f"{name}_roughness = {curve.roughness!r}"
        if curve.fold is not None:
            yield f"{name}_fold = {curve.fold!r}  # slope of every segment, rise over run"
    yield f"thickness = {design.thickness!r}"
    yield f'side = "{design.side}"'
    yield f'nodes = "{design.nodes}"'
    yield f"clearance = {design.clearance!r}  # how far each chamfer is set back"
    if design.floor is not None:
        yield f"floor = {design.floor!r}  # height of the floor that trims the panels"
    for prefix, part in (("label_", design.label), ("hole_", design.holes)):
        for key in PARAMETERS if part is not None else ():
            if hasattr(part, key):
                yield f"{prefix}{key} = {getattr(part, key)!r}"
    yield f"nest = {design.nest}  # digits of the address that group panels"


def _curve(name: str, drawn: DrawnCurve) -> Iterator[str]:
    yield f"{name} = ifs.Curve("
    yield "    ["
    yield from (f"        {point!r}," for point in drawn.control_points)
    yield "    ],"
    if any(weight != 1.0 for weight in drawn.weights):
        yield from _wrapped("weights=[", map(repr, drawn.weights), "],")
    if drawn.transformations != 2:
        yield f"    transformations={drawn.transformations},"
    if drawn.closed:
        yield "    closed=True,"
    yield f"    depth={name}_depth,"
    yield ")"
    if drawn.roughness:
        yield f"{name} = {name}.with_roughness({name}_roughness)"
    if drawn.symmetric:
        yield f"{name} = {name}.with_symmetry()"
    for item in drawn.moved:
        arguments = (f'"{item.name}"', repr(item.point), f"weight={item.weight!r}")
        yield from _wrapped(f"{name} = {name}.with_subdivision_point(", arguments, ")", 0)
    if drawn.fold is not None:
        yield f"{name} = {name}.with_even_fold({name}_fold)"


def _shell(design: Design) -> Iterator[str]:
    yield "surface = ifs.vector_sum(a, b)"
    yield "shell = ifs.thicken("
    yield "    surface,"
    yield "    thickness,"
    yield from (f"    {name}={name}," for name in ("side", "clearance", "nodes"))
    if design.floor is not None:
        yield "    floor=ifs.Plane((0, 0, floor), (0, 0, 1)),"
    if design.material != SPRUCE_PLYWOOD.name:
        yield f"    material=MATERIALS[{design.material!r}],"
    yield ")"
    if design.fibre is not None:
        yield from _call("shell = shell.with_fibre(ifs.", design.fibre, ")", "", 0)
    yield "assembly = ifs.to_assembly("
    yield "    shell,"
    yield from _call("label=ifs.", design.label, ",", "label_", INDENT)
    yield from _call("holes=ifs.", design.holes, ",", "hole_", INDENT)
    yield "    nest=nest,"
    yield '    name="shell",'
    yield ")"
    yield 'show_object(assembly, name="shell")'


def _call(start: str, thing: Any, end: str, prefix: str, indent: int) -> Iterator[str]:
    """Write a dataclass as a call; what is a parameter of the script by its name with a prefix."""
    if thing is None:
        return
    arguments = []
    for item in fields(thing):
        value = getattr(thing, item.name)
        if prefix and item.name in PARAMETERS:
            arguments.append(f"{item.name}={prefix}{item.name}")
        elif value != item.default:
            arguments.append(f"{item.name}={_literal(value)}")
    yield from _wrapped(f"{start}{type(thing).__name__}(", arguments, f"){end}", indent)


def _literal(value: Any) -> str:
    return f'"{value}"' if isinstance(value, str) else repr(value)


def _wrapped(start: str, items: Iterable[str], end: str, indent: int = INDENT) -> Iterator[str]:
    """Write a list on one line if it fits, else an item a line."""
    items, space = list(items), " " * indent
    line = f"{space}{start}{', '.join(items)}{end}"
    if len(line) <= WIDTH:
        yield line
        return
    yield space + start
    yield from (f"{space}    {item}," for item in items)
    yield space + end
