"""IFS curves become a free-form surface, exact plywood panels and one STEP file.

The public names are resolved on first use (PEP 562), so `import ifs_cad` loads neither the CAD
kernel nor numpy; and it is enough to have the Workplane methods, which attach themselves when
cadquery is imported, before or after.

The method is that of Stotz, Gouaty and Weinand, *Iterative Geometric Design for Architecture*,
2009.
"""

from __future__ import annotations

from types import ModuleType
from typing import TYPE_CHECKING, Any

from wrapt import when_imported

if TYPE_CHECKING:
    from ifs_cad.design import classics
    from ifs_cad.design.conic import arc, arc_through, conic, ellipse, hyperbola, parabola
    from ifs_cad.design.connection import Continuity, NodeValence
    from ifs_cad.design.constraint import ConstraintReport, check_constraints
    from ifs_cad.design.curve import Curve
    from ifs_cad.design.development import Developable, DevelopableStrips, flat_strips
    from ifs_cad.design.dome import dome
    from ifs_cad.design.figure import Figure
    from ifs_cad.design.form import Convexity, MaximumEdge, MaximumPart, MinimumEdge, Planarity
    from ifs_cad.design.germ import Germ
    from ifs_cad.design.handle import Handle, handles
    from ifs_cad.design.mesh import Mesh
    from ifs_cad.design.meshfile import read_mesh
    from ifs_cad.design.spline import clamped_knots, spline, spline_segment, uniform_knots
    from ifs_cad.design.subdivision import SubdivisionSets
    from ifs_cad.design.subdivision_control import iteration_depths
    from ifs_cad.design.surface import vector_sum
    from ifs_cad.design.transform import Scheme
    from ifs_cad.design.triangles import TriangularPatch
    from ifs_cad.design_file import presets, read_design, write_design
    from ifs_cad.design_record import Design
    from ifs_cad.design_script import to_script
    from ifs_cad.elements.beam import WireFrame
    from ifs_cad.elements.clash import clashes
    from ifs_cad.elements.colouring import Colouring
    from ifs_cad.elements.fibre import FibreAlongCurve, FibreAlongEdge, FibreTowards
    from ifs_cad.elements.hole import Holes
    from ifs_cad.elements.label import Label
    from ifs_cad.elements.material import Material, Stiffness, Strength
    from ifs_cad.elements.panel import Panel, Shell
    from ifs_cad.elements.screw import Screws
    from ifs_cad.elements.thicken import thicken
    from ifs_cad.elements.vault import Vault, vault
    from ifs_cad.errors import IfsCadError
    from ifs_cad.export.btlx import export_btlx
    from ifs_cad.export.chart import export_chart
    from ifs_cad.export.cutlist import export_csv, export_xlsx
    from ifs_cad.export.deck import export_calculix
    from ifs_cad.export.drawing import (
        export_board_drawings,
        export_element_drawings,
        export_sheet_drawings,
    )
    from ifs_cad.export.dxf import export_dxf
    from ifs_cad.export.step import export_panels, export_sheets, export_step
    from ifs_cad.export.vtu import export_vtu
    from ifs_cad.fabrication.boards.cutting_plan import cut_boards
    from ifs_cad.fabrication.cutlist import cut_list
    from ifs_cad.fabrication.nesting.nest import nest
    from ifs_cad.fabrication.operations import workpieces
    from ifs_cad.fabrication.planklist import plank_list
    from ifs_cad.fabrication.saw import saw_list, square_workpieces
    from ifs_cad.fabrication.stock import Board, Sheet, Stock
    from ifs_cad.fabrication.stock_file import read_stock
    from ifs_cad.kernel.assembly import to_assembly
    from ifs_cad.kernel.drawn import mesh_to_faces, to_dots, to_faces, to_wire, to_wires
    from ifs_cad.kernel.instance import place_germ
    from ifs_cad.kernel.panels import to_solid
    from ifs_cad.structure.analyse import analyse
    from ifs_cad.structure.analysis import Analysis
    from ifs_cad.structure.load import AreaLoad, PointLoad, SelfWeight
    from ifs_cad.structure.modes import natural_frequencies
    from ifs_cad.structure.nonlinear import analyse_nonlinear
    from ifs_cad.structure.support import Support
    from ifs_cad.tolerance import Tolerance
    from ifs_cad.types import Plane
    from ifs_cad.view.animate import animate
    from ifs_cad.view.deformed import deformed_assembly, render_deformed
    from ifs_cad.view.preview import show, show_object
    from ifs_cad.view.quantity import colouring
    from ifs_cad.view.render import render
    from ifs_cad.workflow.check import check_step
    from ifs_cad.workflow.fabricate import fabricate

    __version__: str

__all__ = [
    "Analysis",
    "AreaLoad",
    "Board",
    "Colouring",
    "ConstraintReport",
    "Continuity",
    "Convexity",
    "Curve",
    "Design",
    "Developable",
    "DevelopableStrips",
    "FibreAlongCurve",
    "FibreAlongEdge",
    "FibreTowards",
    "Figure",
    "Germ",
    "Handle",
    "Holes",
    "IfsCadError",
    "Label",
    "Material",
    "MaximumEdge",
    "MaximumPart",
    "Mesh",
    "MinimumEdge",
    "NodeValence",
    "Panel",
    "Planarity",
    "Plane",
    "PointLoad",
    "Scheme",
    "Screws",
    "SelfWeight",
    "Sheet",
    "Shell",
    "Stiffness",
    "Stock",
    "Strength",
    "SubdivisionSets",
    "Support",
    "Tolerance",
    "TriangularPatch",
    "Vault",
    "WireFrame",
    "analyse",
    "analyse_nonlinear",
    "animate",
    "arc",
    "arc_through",
    "check_constraints",
    "check_step",
    "clamped_knots",
    "clashes",
    "classics",
    "colouring",
    "conic",
    "cut_boards",
    "cut_list",
    "deformed_assembly",
    "dome",
    "ellipse",
    "export_board_drawings",
    "export_btlx",
    "export_calculix",
    "export_chart",
    "export_csv",
    "export_dxf",
    "export_element_drawings",
    "export_panels",
    "export_sheet_drawings",
    "export_sheets",
    "export_step",
    "export_vtu",
    "export_xlsx",
    "fabricate",
    "flat_strips",
    "handles",
    "hyperbola",
    "iteration_depths",
    "mesh_to_faces",
    "natural_frequencies",
    "nest",
    "parabola",
    "place_germ",
    "plank_list",
    "presets",
    "read_design",
    "read_mesh",
    "read_stock",
    "render",
    "render_deformed",
    "saw_list",
    "show",
    "show_object",
    "spline",
    "spline_segment",
    "square_workpieces",
    "thicken",
    "to_assembly",
    "to_dots",
    "to_faces",
    "to_script",
    "to_solid",
    "to_wire",
    "to_wires",
    "uniform_knots",
    "vault",
    "vector_sum",
    "workpieces",
    "write_design",
]

_HOMES = {
    "Analysis": "structure.analysis",
    "AreaLoad": "structure.load",
    "Board": "fabrication.stock",
    "Colouring": "elements.colouring",
    "ConstraintReport": "design.constraint",
    "Continuity": "design.connection",
    "Convexity": "design.form",
    "Curve": "design.curve",
    "Design": "design_record",
    "Developable": "design.development",
    "DevelopableStrips": "design.development",
    "FibreAlongCurve": "elements.fibre",
    "FibreAlongEdge": "elements.fibre",
    "FibreTowards": "elements.fibre",
    "Figure": "design.figure",
    "Germ": "design.germ",
    "Handle": "design.handle",
    "Holes": "elements.hole",
    "IfsCadError": "errors",
    "Label": "elements.label",
    "Material": "elements.material",
    "MaximumEdge": "design.form",
    "MaximumPart": "design.form",
    "Mesh": "design.mesh",
    "MinimumEdge": "design.form",
    "NodeValence": "design.connection",
    "Panel": "elements.panel",
    "Planarity": "design.form",
    "Plane": "types",
    "PointLoad": "structure.load",
    "Scheme": "design.transform",
    "Screws": "elements.screw",
    "SelfWeight": "structure.load",
    "Sheet": "fabrication.stock",
    "Shell": "elements.panel",
    "Stiffness": "elements.material",
    "Stock": "fabrication.stock",
    "Strength": "elements.material",
    "SubdivisionSets": "design.subdivision",
    "Support": "structure.support",
    "Tolerance": "tolerance",
    "TriangularPatch": "design.triangles",
    "Vault": "elements.vault",
    "WireFrame": "elements.beam",
    "analyse": "structure.analyse",
    "analyse_nonlinear": "structure.nonlinear",
    "animate": "view.animate",
    "arc": "design.conic",
    "arc_through": "design.conic",
    "check_constraints": "design.constraint",
    "check_step": "workflow.check",
    "clamped_knots": "design.spline",
    "clashes": "elements.clash",
    "classics": "design",
    "colouring": "view.quantity",
    "conic": "design.conic",
    "cut_boards": "fabrication.boards.cutting_plan",
    "cut_list": "fabrication.cutlist",
    "deformed_assembly": "view.deformed",
    "dome": "design.dome",
    "ellipse": "design.conic",
    "export_board_drawings": "export.drawing",
    "export_btlx": "export.btlx",
    "export_calculix": "export.deck",
    "export_chart": "export.chart",
    "export_csv": "export.cutlist",
    "export_dxf": "export.dxf",
    "export_element_drawings": "export.drawing",
    "export_panels": "export.step",
    "export_sheet_drawings": "export.drawing",
    "export_sheets": "export.step",
    "export_step": "export.step",
    "export_vtu": "export.vtu",
    "export_xlsx": "export.cutlist",
    "fabricate": "workflow.fabricate",
    "flat_strips": "design.development",
    "handles": "design.handle",
    "hyperbola": "design.conic",
    "iteration_depths": "design.subdivision_control",
    "mesh_to_faces": "kernel.drawn",
    "natural_frequencies": "structure.modes",
    "nest": "fabrication.nesting.nest",
    "parabola": "design.conic",
    "place_germ": "kernel.instance",
    "plank_list": "fabrication.planklist",
    "presets": "design_file",
    "read_design": "design_file",
    "read_mesh": "design.meshfile",
    "read_stock": "fabrication.stock_file",
    "render": "view.render",
    "render_deformed": "view.deformed",
    "saw_list": "fabrication.saw",
    "show": "view.preview",
    "show_object": "view.preview",
    "spline": "design.spline",
    "spline_segment": "design.spline",
    "square_workpieces": "fabrication.saw",
    "thicken": "elements.thicken",
    "to_assembly": "kernel.assembly",
    "to_dots": "kernel.drawn",
    "to_faces": "kernel.drawn",
    "to_script": "design_script",
    "to_solid": "kernel.panels",
    "to_wire": "kernel.drawn",
    "to_wires": "kernel.drawn",
    "uniform_knots": "design.spline",
    "vault": "elements.vault",
    "vector_sum": "design.surface",
    "workpieces": "fabrication.operations",
    "write_design": "design_file",
}


def __getattr__(name: str) -> Any:
    value: Any
    if name == "__version__":
        from importlib.metadata import version

        value = version("ifs-cad")
    elif name in _HOMES:
        from ifs_cad.libraries import load

        home = load(f"{__name__}.{_HOMES[name]}")
        # `classics` is a whole module, named by the package it lies in
        value = getattr(home, name) if hasattr(home, name) else load(f"{home.__name__}.{name}")
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value  # the next access finds it without coming here
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


@when_imported("cadquery")
def _attach_workplane_methods(cadquery: ModuleType) -> None:
    from ifs_cad.kernel import plugin

    plugin.attach(cadquery)


@when_imported("IPython")
def _show_in_notebooks(ipython: ModuleType) -> None:
    from ifs_cad.view import notebook

    notebook.register(ipython)
