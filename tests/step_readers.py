"""Programs that did not write our STEP files: gmsh and FreeCAD."""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

FREECAD = """
import json, os
import FreeCAD, Import
preferences = "User parameter:BaseApp/Preferences/Mod/Import"
FreeCAD.ParamGet(preferences + "/hSTEP").SetBool("ReadShapeCompoundMode", False)
FreeCAD.ParamGet(preferences).SetBool("ReduceObjects", False)
document = FreeCAD.newDocument("read")
Import.insert(os.environ["STEP_FILE"], document.Name)
found = {}
for thing in document.Objects:
    if thing.TypeId == "Part::Feature":
        box = thing.Shape.BoundBox
        found[thing.Label] = {
            "group": [parent.Label for parent in thing.InList],
            "solids": len(thing.Shape.Solids),
            "volume": thing.Shape.Volume,
            "placement": list(thing.getGlobalPlacement().toMatrix().A),
            "box": [[box.XMin, box.YMin, box.ZMin], [box.XMax, box.YMax, box.ZMax]],
        }
with open(os.environ["FOUND"], "w") as file:
    json.dump(found, file)
"""


def freecad_command() -> list[str] | None:
    for name in ("freecadcmd", "FreeCADCmd"):
        if shutil.which(name):
            return [name]
    return [sys.executable] if importlib.util.find_spec("FreeCAD") else None


needs_freecad = pytest.mark.skipif(
    freecad_command() is None, reason="neither freecadcmd nor FreeCAD is installed"
)


def read_by_freecad(path: Path, scratch: Path) -> dict[str, dict[str, Any]]:
    """Return what FreeCAD finds in a STEP file, by label; boxes are of the parts in place."""
    command, script, answer = freecad_command(), scratch / "read.py", scratch / "found.json"
    assert command is not None
    script.write_text(FREECAD, encoding="utf-8")
    told = {"STEP_FILE": str(path), "FOUND": str(answer), "HOME": str(scratch)}
    subprocess.run(
        [*command, str(script)],
        env=os.environ | told,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=120,
        check=True,
    )
    return dict(json.loads(answer.read_text(encoding="utf-8")))


@contextmanager
def gmsh_model() -> Iterator[Any]:
    """Give an empty model of gmsh; skip the test where gmsh cannot be loaded."""
    try:
        import gmsh
    except (ImportError, OSError) as error:  # OSError: its own shared object lacks a library
        pytest.skip(f"gmsh cannot be loaded: {error}")
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    try:
        yield gmsh.model
    finally:
        gmsh.finalize()


def read_by_gmsh(model: Any, path: Path) -> dict[str, int]:
    """Return the solids that gmsh finds in a STEP file: the tags by name."""
    model.occ.importShapes(str(path))
    model.occ.synchronize()
    solids = [tag for _, tag in model.getEntities(3)]
    found = {model.getEntityName(3, tag).split("/")[-1]: tag for tag in solids}
    assert len(found) == len(solids)
    return found
