"""Methods that ifs_cad adds to `cadquery.Workplane`, in CadQuery's plugin convention.

They are attached when cadquery is imported, before or after `import ifs_cad`. Each works at every
point of the stack: the panels are moved into the local coordinates there.
"""

from __future__ import annotations

from typing import Any

import cadquery as cq

from ifs_cad.elements.hole import HolePattern
from ifs_cad.elements.panel import Panel, Shell
from ifs_cad.kernel.drawn import mesh_to_faces
from ifs_cad.kernel.panels import LabelChoice, make_panels, to_solid


def ifs_panels(
    workplane: cq.Workplane,
    what: Shell | Panel,
    label: LabelChoice = None,
    holes: HolePattern | None = None,
    combine: Any = False,
    clean: bool = False,
) -> cq.Workplane:
    """Place panels at every point of the stack: `Workplane.ifsPanels(shell["0211"])`.

    Parameters
    ----------
    what : Shell or Panel
    label : Label, "engraved", "wire" or None
        Wires are left out here; an assembly has a place for them.
    holes : Holes, optional
    combine, clean : as in other Workplane methods
        Panels stay apart by default.
    """
    if isinstance(what, Panel):
        shapes = [to_solid(what, label=label, holes=holes)]
    else:
        made = make_panels(what, label=label, holes=holes)
        shapes = [panel.solid.moved(panel.location) for panel in made]
    shape = shapes[0] if len(shapes) == 1 else cq.Compound.makeCompound(shapes)
    return workplane.eachpoint(lambda place: shape.moved(place), True, combine, clean)


def ifs_surface(workplane: cq.Workplane, what: Shell) -> cq.Workplane:
    """Place the design surface at every point of the stack, as a shell of planar faces."""
    surface = mesh_to_faces(what.mesh)
    return workplane.eachpoint(lambda place: surface.moved(place), True, False, False)


def attach(cadquery: Any) -> None:
    """Add the methods to `cadquery.Workplane`."""
    cadquery.Workplane.ifsPanels = ifs_panels
    cadquery.Workplane.ifsSurface = ifs_surface
