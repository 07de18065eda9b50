"""A curve with its points, drawn in its own plane as SVG."""

from __future__ import annotations

import numpy as np

from ifs_cad.studio.evaluation import CurveView
from ifs_cad.studio.look import CONTROL, CURVE, SELECTED, SUBDIVISION, css
from ifs_cad.studio.plane import plane_of
from ifs_cad.types import FloatArray

WIDTH, HEIGHT, MARGIN = 320.0, 190.0, 26.0  # px
RULER = 72.0  # px, at most
LEAST_SIZE = 1e-6  # mm

__all__ = ["curve_plot"]


def curve_plot(view: CurveView, selected: int | str | None = None) -> str:
    """Return a drawing of a curve.

    Parameters
    ----------
    view : CurveView
    selected : int or str, optional
        Number of a control point, or name of a subdivision point, to stand out.

    Returns
    -------
    str
        An ``svg`` element; its ruler tells the scale.
    """
    plane = plane_of(view.control_points)
    control = plane.flat(view.control_points)
    handles = np.array([item.point for item in view.subdivision_points]).reshape(-1, 3)
    subdivision = plane.flat(handles)
    curve = np.empty((0, 2)) if view.points is None else plane.flat(view.points)
    everything = np.concatenate([control, subdivision, curve])
    everything = everything[np.isfinite(everything).all(axis=1)]
    low, high = everything.min(axis=0), everything.max(axis=0)
    size = np.maximum(high - low, LEAST_SIZE)
    scale = float(((WIDTH - 2 * MARGIN, HEIGHT - 2 * MARGIN) / size).min())

    def placed(points: FloatArray) -> FloatArray:
        shifted = (points - (low + high) / 2) * (scale, -scale)
        return np.asarray(shifted + np.array([WIDTH / 2, HEIGHT / 2]))

    polygon = np.concatenate([control, control[:1]]) if view.closed else control
    parts = [
        _line(placed(polygon), f'stroke="{css(CONTROL)}" stroke-width="1" stroke-dasharray="3 3"'),
        _line(placed(curve), f'stroke="{css(CURVE)}" stroke-width="2" stroke-linejoin="round"'),
        _ruler(scale),
    ]
    for number, place in enumerate(placed(control)):
        parts.append(_dot(place, f"p{number + 1}", css(CONTROL), 4.5, number == selected))
    for item, place in zip(view.subdivision_points, placed(subdivision), strict=True):
        parts.append(_dot(place, item.name, css(SUBDIVISION), 3.5, item.name == selected))
    return (
        f'<svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}" '
        f'style="display:block;width:94%;margin:0 auto 0.6em;'
        f'background:#faf8f5;border:1px solid #e8e2d9;border-radius:6px" '
        f'font-family="system-ui,sans-serif" font-size="11">{"".join(parts)}</svg>'
    )


def _line(points: FloatArray, style: str) -> str:
    good = points[np.isfinite(points).all(axis=1)]
    return f'<polyline fill="none" {style} points="{_pairs(good)}"/>' if len(good) > 1 else ""


def _pairs(points: FloatArray) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points.tolist())


def _dot(place: FloatArray, name: str, colour: str, radius: float, is_selected: bool) -> str:
    if not np.isfinite(place).all():
        return ""
    x, y = place.tolist()
    ring = ""
    if is_selected:
        ring = (
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius + 4:g}" fill="none" '
            f'stroke="{css(SELECTED)}" stroke-width="2.5"/>'
        )
    return (
        f'{ring}<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:g}" fill="{colour}" stroke="#fff"/>'
        f'<text x="{x + 7:.1f}" y="{y - 6:.1f}" fill="{colour}">{name}</text>'
    )


def _ruler(scale: float) -> str:
    """Return a bar of a round length, mm."""
    longest = RULER / scale
    ten = 10.0 ** np.floor(np.log10(longest))
    length = next(step * ten for step in (5.0, 2.0, 1.0) if step * ten <= longest)
    y, end = HEIGHT - 8.0, 10.0 + length * scale
    return (
        f'<path d="M10 {y - 4:g}V{y:g}H{end:.1f}V{y - 4:g}" fill="none" stroke="#8a8178"/>'
        f'<text x="{end + 5:.1f}" y="{y:g}" fill="#8a8178">{length:g} mm</text>'
    )
