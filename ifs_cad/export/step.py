"""Assemblies as STEP files that CAM programs open.

Millimetres; one product per part, named as in the assembly, coloured; without pcurves, which no
reader needs for planes and cylinders and which double the size. Written beside the target and
renamed, so that a good file is never replaced by half of one.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal, get_args

import cadquery as cq
from cadquery.occ_impl.assembly import toCAF
from OCP.IFSelect import IFSelect_RetDone
from OCP.Interface import Interface_Static
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_AsIs

from ifs_cad import progress
from ifs_cad.errors import ExportError, InputError
from ifs_cad.fabrication.layout import Layout
from ifs_cad.files import replaced
from ifs_cad.kernel.assembly import STROKES_SUFFIX
from ifs_cad.kernel.messages import quiet
from ifs_cad.kernel.sheet import sheet_assembly

Schema = Literal["AP214", "AP242"]
_SCHEMAS: dict[str, str] = {"AP214": "AP214IS", "AP242": "AP242DIS"}


def export_step(
    assembly: cq.Assembly,
    path: str | os.PathLike[str],
    *,
    schema: Schema = "AP214",
    pcurves: bool = False,
) -> Path:
    """Write an assembly as one STEP file.

    Parameters
    ----------
    assembly : cadquery.Assembly
        Names must be ASCII; other characters do not survive STEP.
    path : path of the file; its folder is made when missing
    schema : "AP214" or "AP242"
    pcurves : bool
        Write curves in the parameters of their surfaces too.

    Returns
    -------
    Path of the written file.

    Raises
    ------
    InputError
        An unknown schema, a name that is not ASCII, an assembly without any shape.
    ExportError
        The file could not be written; what stood there before is unchanged.
    """
    if schema not in get_args(Schema):
        raise InputError(f'The STEP schema must be "AP214" or "AP242", got {schema!r}.')
    _require_writable_content(assembly)
    target = Path(path)
    progress.report("writing STEP", 0, 1)
    with quiet(), _settings(_SCHEMAS[schema], pcurves), replaced(target) as scratch:
        _, document = toCAF(assembly, coloredSTEP=True)
        writer = STEPCAFControl_Writer()
        writer.SetColorMode(True)
        writer.SetLayerMode(True)
        writer.SetNameMode(True)
        if not writer.Transfer(document, STEPControl_AsIs):
            raise ExportError(f"OpenCascade could not turn {assembly.name} into STEP.")
        if writer.Write(str(scratch)) != IFSelect_RetDone:
            raise ExportError(
                f"OpenCascade could not write {target}. Is the disk full? What stood there before "
                "is unchanged."
            )
    progress.report("writing STEP", 1, 1)
    return target


def export_panels(
    assembly: cq.Assembly, folder: str | os.PathLike[str], *, schema: Schema = "AP214"
) -> list[Path]:
    """Write each panel of an assembly as a STEP file of its own, lying flat for the machine.

    The marked face lies on top, z up, the lower left corner of the bounding box at the origin, x
    along the text. A part that the user modified is written as it is now.

    Parameters
    ----------
    assembly : cadquery.Assembly, made by `to_assembly`
    folder : where the files go, named by address; made when missing

    Raises
    ------
    InputError
        The assembly was not made from a shell.
    ExportError
    """
    elements = assembly.metadata.get("elements")
    if elements is None:
        raise InputError("Only an assembly made by to_assembly knows how its panels lie flat.")
    parts = assembly.objects
    present = [address for address in elements.addresses if address in parts]
    written = []
    for number, address in enumerate(present):
        alone = cq.Assembly(name=f"{address}-flat")
        for name in (address, address + STROKES_SUFFIX):
            if name in parts:
                alone.add(parts[name].obj, name=name, color=parts[name].color)
        written.append(export_step(alone, Path(folder) / f"{address}.step", schema=schema))
        progress.report("writing flat panels", number + 1, len(present))
    return written


def export_sheets(
    layout: Layout,
    assembly: cq.Assembly,
    folder: str | os.PathLike[str],
    *,
    schema: Schema = "AP214",
) -> list[Path]:
    """Write each nested sheet as a STEP file: panels lying in place, named by address.

    The engraved face lies on top, z up, the origin at the lower left corner of the sheet. A part
    that the user modified is written as it is now.

    Parameters
    ----------
    layout : Layout
        Made of workpieces with the same label as the assembly.
    assembly : cadquery.Assembly, made by `to_assembly`
    folder : where the files go, named as the sheets; made when missing

    Returns
    -------
    Paths of the written files, in the order of the sheets.

    Raises
    ------
    InputError
        The layout holds what is not in the assembly; raised before the first file is written.
    ExportError
    """
    assemblies = [sheet_assembly(sheet, assembly) for sheet in layout.sheets]
    written = []
    for number, laid in enumerate(assemblies):
        written.append(export_step(laid, Path(folder) / f"{laid.name}.step", schema=schema))
        progress.report("writing sheets", number + 1, len(assemblies))
    return written


def _require_writable_content(assembly: cq.Assembly) -> None:
    if not isinstance(assembly, cq.Assembly):
        raise InputError(
            f"Only a cadquery Assembly can be written, not a {type(assembly).__name__}; "
            "ifs_cad.to_assembly makes one of a shell."
        )
    names = [part.name for part in assembly.objects.values()]
    foreign = [name for name in names if not name.isascii()]
    if foreign:
        raise InputError(
            f"STEP names must be ASCII; rename {', '.join(foreign[:8])}.", addresses=foreign
        )
    if all(part.obj is None for part in assembly.objects.values()):
        raise InputError(f"The assembly {assembly.name} holds no shape to write.")


@contextmanager
def _settings(schema: str, pcurves: bool) -> Iterator[None]:
    """Set OpenCascade's global STEP parameters and set them back."""
    STEPCAFControl_Writer()  # the parameters exist only after the first writer
    wanted: dict[str, Any] = {
        "write.step.schema": schema,
        "write.surfacecurve.mode": int(pcurves),
        "write.step.unit": "MM",
        "xstep.cascade.unit": "MM",
    }
    before = {name: Interface_Static.CVal_s(name) for name in wanted}
    try:
        for name, value in wanted.items():
            _set(name, value)
        yield
    finally:
        for name, value in before.items():
            _set(name, value)


def _set(name: str, value: str | int) -> None:
    if isinstance(value, int):
        Interface_Static.SetIVal_s(name, value)
    else:
        Interface_Static.SetCVal_s(name, value)
