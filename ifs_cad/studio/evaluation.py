"""What a design looks like, and what is wrong with it, as far as it can be told.

`evaluate` never fails because of the design: what cannot be built becomes a `Problem` that marks
the place, and everything before it is still there to be drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Literal

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.design.curve import Curve
from ifs_cad.design.mesh import Mesh
from ifs_cad.design.surface import vector_sum
from ifs_cad.design_record import Design, DrawnCurve, Point, SubdivisionPoint
from ifs_cad.elements.clash import apart, boxes, neighbours_at_nodes, overlapping, shared_radius
from ifs_cad.elements.cutting import cutting_frames
from ifs_cad.elements.label import place_labels
from ifs_cad.elements.panel import Shell
from ifs_cad.elements.report import Report
from ifs_cad.errors import FloorError, HoleError, IfsCadError, WeightError
from ifs_cad.studio.display import MOST_FACES, PanelView, label_lines, panel_view
from ifs_cad.studio.surface import Surface, beside_gaps, summed, surface_of
from ifs_cad.types import FloatArray, IntArray

CurveName = Literal["a", "b"]

MOST_CLASHES = 64
"""So many pairs of panels that may run into each other are looked at closely."""

__all__ = ["CurveName", "CurveView", "Evaluation", "Problem", "SupersededError", "evaluate"]


class SupersededError(Exception):
    """Nobody waits for an evaluation any more."""


@dataclass(frozen=True, eq=False)
class Problem:
    """One thing that is wrong with a design, and where.

    Attributes
    ----------
    message : str
        What is wrong, where, and what to do.
    severity : "error" or "warning"
        An error keeps the design from being built.
    curve : "a", "b" or None
        The curve that it is about.
    addresses : tuple of str
        The faces or panels that it is about.
    faces : (n,) int, the same as faces of the evaluation
    points : (n, 3) float, mm, places to mark
    """

    message: str
    severity: Literal["error", "warning"] = "error"
    curve: CurveName | None = None
    addresses: tuple[str, ...] = ()
    faces: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    points: FloatArray = field(default_factory=lambda: np.empty((0, 3)))


@dataclass(frozen=True, eq=False)
class CurveView:
    """One curve with its handles.

    Attributes
    ----------
    control_points : (m, 3) float, mm
    weights : (m,) float
    closed : bool, whether the control polygon is
    subdivision_points : tuple of SubdivisionPoint, all that can be moved
    points : (n + 1, 3) float, mm, or None where the curve cannot be made
    shift : (3,) float, mm; what moves the curve to the border of the surface that it spans
    """

    control_points: FloatArray
    weights: FloatArray
    closed: bool
    subdivision_points: tuple[SubdivisionPoint, ...]
    points: FloatArray | None
    shift: FloatArray = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True, eq=False)
class Evaluation:
    """What there is to see of a design.

    Attributes
    ----------
    a, b : CurveView
    shape : (rows, columns) of the surface, (0, 0) without one
    vertices : (v, 3) float, mm; NaN where a weight is not positive
    faces : (f, 4) int, those without NaN, row by row
    addresses : tuple of f str
    shell : Shell or None
    panels : PanelView or None
    labels : (n, 2, 3) float, mm, strokes as lines
    label_normals : (n, 3) float, of the faces that they are on
    report : Report or None
    problems : tuple of Problem
    """

    a: CurveView
    b: CurveView
    shape: tuple[int, int]
    vertices: FloatArray
    faces: IntArray
    addresses: tuple[str, ...]
    shell: Shell | None
    panels: PanelView | None
    labels: FloatArray
    label_normals: FloatArray
    report: Report | None
    problems: tuple[Problem, ...]

    @cached_property
    def extent(self) -> tuple[FloatArray, FloatArray]:
        """The lowest and the highest coordinates of what is drawn, mm."""
        curves = [view.control_points + view.shift for view in (self.a, self.b)]
        points = np.concatenate([*curves, self.vertices])
        points = points[np.isfinite(points).all(axis=1)]
        return points.min(axis=0), points.max(axis=0)

    @property
    def can_be_built(self) -> bool:
        """Whether no problem is an error."""
        return all(problem.severity != "error" for problem in self.problems)


def evaluate(
    design: Design, *, panels: bool = True, superseded: Callable[[], bool] = lambda: False
) -> Evaluation:
    """Return what a design looks like and what is wrong with it.

    Parameters
    ----------
    design : Design
    panels : bool
        Also make panels, labels and the report; without, only curves and surface, which is what
        can follow a mouse.
    superseded : callable
        Tells whether nobody waits for the answer any more; asked between the longer parts.

    Raises
    ------
    SupersededError
        Nobody does.
    """
    view_a, curve_a, wrong_a = _curve_view("a", design.a)
    view_b, curve_b, wrong_b = _curve_view("b", design.b)
    problems = [*wrong_a, *wrong_b]
    surface, shell, labels = Surface(), None, _no_labels()
    mesh: Mesh | None = None
    if curve_a is not None and curve_b is not None:
        view_b = replace(view_b, shift=curve_a.points[0] - curve_b.points[0])
        if curve_a.segments * curve_b.segments > MOST_FACES:
            problems.append(
                Problem(
                    f"{curve_a.segments:,} x {curve_b.segments:,} faces are too many to draw here; "
                    f"{MOST_FACES:,} can be. Take a smaller depth; ifs-cad build may make more.",
                    "warning",
                )
            )
        else:
            try:
                mesh = vector_sum(curve_a, curve_b)
                surface = surface_of(mesh, (curve_a.segments, curve_b.segments))
            except WeightError as error:
                surface = summed(curve_a, curve_b)
                marked = beside_gaps(surface)
                problems.append(Problem(str(error), "error", None, error.addresses, points=marked))
            except IfsCadError as error:
                surface = summed(curve_a, curve_b)
                problems.append(_at(surface, error))
    # none of a curve that only stands in for the drawn one
    drawn = all(problem.severity != "error" for problem in problems)
    if mesh is not None and drawn and panels:
        _go_on(superseded)
        shell = _shell(design, mesh, surface, problems)
        if shell is not None:
            _go_on(superseded)
            _find_clashes(shell, surface, problems)
            _go_on(superseded)
            labels = _labels(design, shell, surface, problems)
            _go_on(superseded)
    return Evaluation(
        view_a,
        view_b,
        surface.shape,
        surface.vertices,
        surface.faces,
        surface.addresses,
        shell,
        None if shell is None else panel_view(shell.solids),
        *labels,
        None if shell is None else shell.report(),
        tuple(problems),
    )


def _go_on(superseded: Callable[[], bool]) -> None:
    if superseded():
        raise SupersededError


@lru_cache(2)  # one of the curves stays while the other is dragged
def _curve_view(
    name: CurveName, drawn: DrawnCurve
) -> tuple[CurveView, Curve | None, tuple[Problem, ...]]:
    """Return how a curve is drawn, the curve if the surface can be made of it, what is wrong."""
    problems: list[Problem] = []
    view, curve = _drawn_curve(name, drawn, problems)
    return view, curve, tuple(problems)


def _drawn_curve(
    name: CurveName, drawn: DrawnCurve, problems: list[Problem]
) -> tuple[CurveView, Curve | None]:
    control, weights = np.array(drawn.control_points), np.array(drawn.weights)
    view = CurveView(control, weights, drawn.closed, drawn.moved, None)
    curve = None
    try:
        base = curve = drawn.base()
        places, own_weights = base.subdivision_points, base.subdivision_weights
        handles = (
            SubdivisionPoint(key, _point(place), own_weights[key]) for key, place in places.items()
        )
        view = replace(view, subdivision_points=tuple(handles))
        shrinking = base.contraction()
        if shrinking.warning:
            marked = np.array([*places.values()]) if places else control
            problems.append(
                Problem(f"Curve {name}: {shrinking.warning}", "warning", name, points=marked)
            )
        if base.segments > MOST_FACES:
            problems.append(
                Problem(
                    f"Curve {name} has too many segments to draw. Take a smaller depth.",
                    curve=name,
                    points=control,
                )
            )
            return view, None
        view = replace(view, points=base.points)
        curve = drawn.curve()
        return replace(view, points=curve.points), curve
    except IfsCadError as error:
        marked = control if view.points is None or curve is None else _marked(curve, error)
        problems.append(
            Problem(f"Curve {name}: {error}", "error", name, error.addresses, points=marked)
        )
        return view, None if view.points is None else curve


def _point(place: FloatArray) -> Point:
    x, y, z = place.tolist()
    return x, y, z


def _marked(curve: Curve, error: IfsCadError) -> FloatArray:
    """Return the (n, 3) starts of the segments that an error names, mm."""
    named = np.isin(curve.addresses, error.addresses)
    return curve.points[:-1][named]


def _shell(design: Design, mesh: Mesh, surface: Surface, problems: list[Problem]) -> Shell | None:
    thickening = design.thickening
    try:
        shell = thickening(mesh)
    except FloorError as error:
        problems.append(_at(surface, error))
        try:  # the panels as they are without it show where the floor has to go
            shell = replace(thickening, floor=None)(mesh)
        except IfsCadError as other:
            problems.append(_at(surface, other))
            return None
    except IfsCadError as error:
        problems.append(_at(surface, error))
        return None
    try:
        shell = shell.with_fibre(design.fibre)
    except IfsCadError as error:
        problems.append(_at(surface, error))
    for text, addresses in (
        ("Below the floor, and not made", shell.lost),
        ("The floor leaves little of", shell.stubs),
    ):
        if addresses:
            problems.append(
                _marking(surface, f"{text}: {listed(addresses)}.", addresses, "warning")
            )
    return shell


def _find_clashes(shell: Shell, surface: Surface, problems: list[Problem]) -> None:
    """Name panels that share volume, without looking at all pairs of a design gone wild."""
    solids = shell.solids
    near, far = neighbours_at_nodes(shell), overlapping(*boxes(solids))
    pairs = np.unique(np.concatenate([near, far]), axis=0)
    doubtful = pairs[~apart(solids, pairs, shell.tol)]
    radii = {
        (one, other): shared_radius(solids, one, other)
        for one, other in doubtful[:MOST_CLASHES].tolist()
    }
    found = [pair for pair, radius in radii.items() if radius > shell.tol.shared_radius]
    if found:
        names = [" and ".join(shell.addresses[i] for i in pair) for pair in found]
        more = " More pairs were not looked at." if len(doubtful) > MOST_CLASHES else ""
        message = (
            f"Panels run into each other: {listed(names)} share a ball of up to "
            f"{max(radii.values()):.3g} mm radius. The design crosses itself there, or is too "
            f"thick.{more}"
        )
        clashing = np.unique(found)
        problems.append(_marking(surface, message, [shell.addresses[i] for i in clashing], "error"))


def _no_labels() -> tuple[FloatArray, FloatArray]:
    return np.empty((0, 2, 3)), np.empty((0, 3))


def _labels(
    design: Design, shell: Shell, surface: Surface, problems: list[Problem]
) -> tuple[FloatArray, FloatArray]:
    """Return the strokes of the labels, and say where labels or holes have no room."""
    label = design.label
    if label is None and design.holes is None:
        return _no_labels()
    face = "inner" if label is None else label.face
    frames = cutting_frames(shell, face, (0.0, 0.0, 1.0) if label is None else label.up)
    holes = None
    try:
        if design.holes is not None:
            holes = design.holes.place(shell, frames)
    except HoleError as error:
        problems.append(_at(surface, error))
    if label is None:
        return _no_labels()
    try:
        return label_lines(frames, place_labels(shell.addresses, frames, label, holes, shell.tol))
    except IfsCadError as error:
        problems.append(_at(surface, error))
        return _no_labels()


def _at(surface: Surface, error: IfsCadError) -> Problem:
    return _marking(surface, str(error), error.addresses, "error")


def _marking(
    surface: Surface,
    message: str,
    addresses: Iterable[str],
    severity: Literal["error", "warning"],
) -> Problem:
    """Return a problem that marks some faces."""
    named = tuple(addresses)
    faces = np.flatnonzero(np.isin(surface.addresses, named)) if named else np.empty(0, np.int64)
    centres = surface.vertices[surface.faces[faces]].mean(axis=1)
    return Problem(message, severity, None, named, faces, centres)
