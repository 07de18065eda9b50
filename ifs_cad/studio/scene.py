"""The design in the 3D scene of the page: curves, surface, panels, labels, and what is wrong.

The scene is in metres, which is what the page's camera is made for; everything else is in mm.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ifs_cad.design_record import Design
from ifs_cad.elements.label import Label
from ifs_cad.elements.panel import Shell
from ifs_cad.studio import look
from ifs_cad.studio.display import PanelView
from ifs_cad.studio.evaluation import CurveView, Evaluation
from ifs_cad.studio.look import Colour
from ifs_cad.studio.ribbon import face_outlines, quad_outlines, strokes
from ifs_cad.types import FloatArray, IntArray

METRES = 1e-3
FINE, BOLD = 1.0, 2.5  # px
MARK_SIZE = 0.012  # of the size of the design
NO_LINES = np.empty((0, 2, 3))
VIEW = np.array([-1.0, -1.0, 0.7])
"""From the design towards the camera."""
DISTANCE = 1.0  # of the size of the design
FADE = 4.0  # of the size of the design
EDGE_WIDTH = 0.0008  # of the size of the design, on each of two faces
MOST_OUTLINED = 4096
"""Of more panels no edges are shown: they would hide the faces."""

MOST_OUTLINED_DRAGGED = 1024
"""Of a surface with more faces none are: it has to follow the mouse."""

__all__ = ["METRES", "Scene", "panels_of_faces", "put"]


class Scene:
    """Draws evaluations into a scene of viser.

    Parameters
    ----------
    server : viser.ViserServer
    """

    def __init__(self, server: Any) -> None:
        self._server = server
        self._meshes: dict[str, Any] = {}
        self._lines: dict[str, Any] = {}
        self._clouds: dict[str, Any] = {}
        self._grid: tuple[Any, ...] = ()
        self.show_panels = True
        self.show_edges = True
        self.show_labels = True
        server.scene.configure_default_lights(True, cast_shadow=False)
        server.gui.configure_theme(
            control_width="large", show_logo=False, show_share_button=False, brand_color=look.BRAND
        )

    def draw(self, evaluation: Evaluation, design: Design) -> None:
        """Show an evaluation in place of the former one."""
        low, high = evaluation.extent
        width = EDGE_WIDTH * float(np.linalg.norm(high - low))
        if evaluation.shell is not None and evaluation.panels is not None and self.show_panels:
            self._shell(evaluation, evaluation.shell, evaluation.panels, width, design.label)
        else:
            self._surface(evaluation, width)
        for name, view in (("a", evaluation.a), ("b", evaluation.b)):
            self._curve(name, view)
        self._marks(evaluation)
        self._ground(evaluation, design.floor)

    def _shell(
        self,
        evaluation: Evaluation,
        shell: Shell,
        panels: PanelView,
        width: float,
        label: Label | None,
    ) -> None:
        wrong, doubtful = _marked_faces(evaluation)
        owners = panels.panel_of_triangle
        is_wrong = np.isin(owners, panels_of_faces(evaluation, wrong))
        is_doubtful = np.isin(owners, panels_of_faces(evaluation, doubtful))
        corners, triangles = panels.vertices, panels.triangles
        self._hide("surface")
        self._mesh("panels", corners, triangles[~(is_wrong | is_doubtful)], look.WOOD)
        self._mesh("wrong", corners, triangles[is_wrong], look.WRONG)
        self._mesh("doubtful", corners, triangles[is_doubtful], look.DOUBTFUL)
        if self.show_edges and len(shell) <= MOST_OUTLINED:
            narrow = min(width, shell.thickness / 4)
            self._mesh("edges", *face_outlines(shell.solids, narrow), look.EDGE)
        else:
            self._hide("edges")
        if self.show_labels and label is not None:
            lines = strokes(evaluation.labels, evaluation.label_normals, label.cutter)
            self._mesh("labels", *lines, look.ENGRAVED)
        else:
            self._hide("labels")

    def _surface(self, evaluation: Evaluation, width: float) -> None:
        wrong, doubtful = _marked_faces(evaluation)
        corners, faces = evaluation.vertices, evaluation.faces
        plain = np.ones(len(faces), dtype=bool)
        plain[wrong], plain[doubtful] = False, False
        for name in ("panels", "labels"):
            self._hide(name)
        self._mesh("surface", corners, _triangles(faces[plain]), look.SURFACE)
        self._mesh("wrong", corners, _triangles(faces[wrong]), look.WRONG)
        self._mesh("doubtful", corners, _triangles(faces[doubtful]), look.DOUBTFUL)
        if self.show_edges and len(faces) <= MOST_OUTLINED_DRAGGED:
            self._mesh("edges", *quad_outlines(corners, faces, width), look.EDGE)
        else:
            self._hide("edges")

    def camera(self, evaluation: Evaluation) -> tuple[FloatArray, FloatArray]:
        """Return where a camera sees all of a design from, and what it looks at, m."""
        low, high = evaluation.extent
        middle = (low + high) / 2 * METRES
        away = VIEW / np.linalg.norm(VIEW) * DISTANCE * float(np.linalg.norm(high - low)) * METRES
        return middle + away, middle

    def _curve(self, name: str, view: CurveView) -> None:
        control = view.control_points + view.shift
        ring = np.concatenate([control, control[:1]]) if view.closed else control
        self._segments(f"curve_{name}/polygon", _chain(ring), look.CONTROL, FINE)
        points = NO_LINES if view.points is None else _chain(view.points + view.shift)
        self._segments(f"curve_{name}/line", points, look.CURVE, BOLD)

    def _marks(self, evaluation: Evaluation) -> None:
        """Put a ball at each place that a problem names."""
        low, high = evaluation.extent
        size = MARK_SIZE * float(np.linalg.norm(high - low)) * METRES
        for severity, colour in (("error", look.WRONG), ("warning", look.DOUBTFUL)):
            places = [
                item.points + (evaluation.b.shift if item.curve == "b" else 0.0)
                for item in evaluation.problems
                if item.severity == severity
            ]
            points = np.concatenate([np.empty((0, 3)), *places]) * METRES
            points = points[np.isfinite(points).all(axis=1)]
            if not len(points):
                if severity in self._clouds:
                    self._clouds.pop(severity).remove()
                continue
            self._clouds[severity] = self._server.scene.add_point_cloud(
                f"/marks/{severity}",
                points.astype(np.float32),
                colour,
                point_size=size,
                point_shape="circle",
                precision="float32",
            )

    def _ground(self, evaluation: Evaluation, floor: float | None) -> None:
        low, high = evaluation.extent
        height = floor if floor is not None else min(0.0, float(low[2]))
        size = float(np.linalg.norm(high - low)) * METRES
        section = float(10.0 ** np.round(np.log10(max(size, 1e-6) / 4.0)))
        fade = 2.0 ** np.ceil(np.log2(FADE * max(size, 1e-6)))
        state = (round(height, 6), section, float(fade))
        if state == self._grid:
            return
        self._grid = state
        grid = self._server.scene.add_grid(
            "/ground",
            infinite_grid=True,
            plane="xy",
            cell_size=section / 2,
            section_size=section,
            cell_color=look.GRID,
            section_color=look.SECTION,
            cell_thickness=0.6,
            section_thickness=0.8,
            fade_distance=float(fade),
            fade_strength=1.5,
            shadow_opacity=0.0,
        )
        put(grid, (0.0, 0.0, height * METRES))

    def _mesh(self, name: str, vertices: FloatArray, triangles: IntArray, colour: Colour) -> None:
        """Show triangles under a name; only what changed is sent."""
        if not len(triangles):
            self._hide(name)
            return
        handle = self._meshes.get(name)
        points = np.nan_to_num(vertices * METRES).astype(np.float32)
        faces = triangles.astype(np.uint32)
        if handle is not None and np.array_equal(handle.faces, faces):
            handle.vertices = points
        else:
            handle = self._meshes[name] = self._server.scene.add_mesh_simple(
                f"/shell/{name}",
                points,
                faces,
                color=colour,
                flat_shading=True,
                side="double",
                cast_shadow=False,
                receive_shadow=False,
            )
        handle.visible = True

    def _hide(self, name: str) -> None:
        if name in self._meshes:
            self._meshes[name].visible = False

    def _segments(self, name: str, segments: FloatArray, colour: Colour, width: float) -> None:
        handle = self._lines.get(name)
        good = segments[np.isfinite(segments).all(axis=(1, 2))]
        if not len(good):
            if handle is not None:
                handle.visible = False
            return
        points = (good * METRES).astype(np.float32)
        if handle is not None and handle.points.shape == points.shape:
            handle.points = points
        else:
            handle = self._lines[name] = self._server.scene.add_line_segments(
                f"/{name}", points, colour, thickness=width, thickness_units="screen"
            )
        handle.visible = True


def put(node: Any, place: tuple[float, float, float]) -> None:
    """Move a node of the scene, m.

    viser does not tell the page of a place that a new node has anyway, the origin; but the page
    remembers where a former node of the same name was.
    """
    x, y, z = place
    if not node.position.any():
        node.position = (x, y, z + 1.0)
    node.position = (x, y, z)


def panels_of_faces(evaluation: Evaluation, faces: IntArray) -> IntArray:
    """Return the panels that were made of some faces of the surface."""
    assert evaluation.shell is not None
    named = [evaluation.addresses[face] for face in faces.tolist()]
    return np.flatnonzero(np.isin(evaluation.shell.addresses, named))


def _marked_faces(evaluation: Evaluation) -> tuple[IntArray, IntArray]:
    """Return the faces that errors are about, and those that only warnings are about."""
    wrong, doubtful = (
        np.unique(np.concatenate([np.empty(0, dtype=np.int64), *named]))
        for named in (
            [item.faces for item in evaluation.problems if item.severity == severity]
            for severity in ("error", "warning")
        )
    )
    return wrong, np.setdiff1d(doubtful, wrong)


def _triangles(faces: IntArray) -> IntArray:
    """Return quads as pairs of triangles."""
    return np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])


def _chain(points: FloatArray) -> FloatArray:
    """Return points as (n, 2, 3) segments from each to the next."""
    return np.stack([points[:-1], points[1:]], axis=1)
