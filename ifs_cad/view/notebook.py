"""Shells in a Jupyter notebook: turned with the mouse in the cell that names them.

CadQuery's own way of showing an assembly there is used. IPython is told the types by name, so that
nothing is loaded before something is shown.
"""

from __future__ import annotations

from typing import Any

MIME = "application/javascript"
SOLIDS = {
    "ifs_cad.elements.panel": ("Shell", "Panel"),
    "ifs_cad.elements.vault": ("Vault",),
    "ifs_cad.elements.beam": ("WireFrame",),
}
SURFACES = {"ifs_cad.design.mesh": ("Mesh",)}


def register(ipython: Any) -> None:
    """Tell a running IPython how our objects are shown; without one do nothing.

    Parameters
    ----------
    ipython : the module
    """
    running = ipython.get_ipython()
    if running is None:
        return
    formatter = running.display_formatter.formatters[MIME]
    for types, shown in ((SOLIDS, _solids), (SURFACES, _surface)):
        for module, names in types.items():
            for name in names:
                formatter.for_type_by_name(module, name, shown)


def _solids(elements: Any) -> Any:
    from ifs_cad.elements.panel import Panel
    from ifs_cad.kernel.assembly import to_assembly

    if isinstance(elements, Panel):
        elements = elements.shell.take([elements.index])
    return to_assembly(elements)._repr_javascript_()


def _surface(mesh: Any) -> Any:
    from ifs_cad.kernel.drawn import mesh_to_faces

    return mesh_to_faces(mesh)._repr_javascript_()
