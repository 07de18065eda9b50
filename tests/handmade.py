"""Workpieces made by hand, for the tests of lists and drawings."""

import math
from dataclasses import replace

import numpy as np
from scipy.spatial import ConvexHull

from ifs_cad.elements.material import SPRUCE_PLYWOOD
from ifs_cad.fabrication.workpiece import Side, Workpiece


def area_of(outline):
    x, y = outline.T
    return float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2)


def polygon_piece(address, corners, thickness, inclinations, **changes):
    """A piece on a (k, 2) counter-clockwise lower outline; ValueError where it is not convex."""
    lower = np.asarray(corners, dtype=float)
    spans = np.roll(lower, -1, axis=0) - lower
    along = spans / np.hypot(*spans.T)[:, None]
    outward = np.column_stack([along[:, 1], -along[:, 0]])
    slopes = np.tan(np.radians(inclinations))
    levels = (outward * lower).sum(axis=1) + thickness * slopes
    pairs = np.stack([np.roll(outward, 1, axis=0), outward], axis=1)
    sines = np.linalg.det(pairs)
    upper = np.linalg.solve(pairs, np.stack([np.roll(levels, 1), levels], axis=1)[..., None])[
        ..., 0
    ]
    growth = ((np.roll(upper, -1, axis=0) - upper) * along).sum(axis=1)
    if sines.min() < 0.01 or growth.min() < 1.0:
        raise ValueError("not convex")
    shift = np.concatenate([lower, upper]).min(axis=0)
    lower, upper = lower - shift, upper - shift
    both = np.concatenate([lower, upper])
    normals = np.column_stack([outward, -slopes]) / np.hypot(1.0, slopes)[:, None]
    below = np.column_stack([lower, np.zeros(len(lower))])
    above = np.column_stack([upper, np.full(len(upper), thickness)])
    count = len(lower)
    sides = tuple(
        Side(
            corners=np.array([below[k], below[k - count + 1], above[k - count + 1], above[k]]),
            normal=normals[k],
            inclination=float(inclinations[k]),
            kind="cut" if k < count - 1 else "border",
            neighbour=f"n{k}" if k < count - 1 else "",
        )
        for k in range(count)
    )
    piece = Workpiece(
        address=address,
        thickness=thickness,
        material=SPRUCE_PLYWOOD,
        lower=lower,
        upper=upper,
        silhouette=both[ConvexHull(both).vertices],
        fibre=None,
        drills=(),
        engraving=None,
        sides=sides,
        axes=np.eye(3),
        origin=np.zeros(3),
        volume=thickness / 6 * (area_of(lower) + 4 * area_of((lower + upper) / 2) + area_of(upper)),
    )
    return replace(piece, **changes)


def box(address, long, wide, thickness, *, inclinations=(0.0,) * 4, fibre=None, **changes):
    """A rectangle below, its sides leaning: lower, right, upper, left."""
    corners = np.array([(0.0, 0.0), (long, 0.0), (long, wide), (0.0, wide)])
    grain = None if fibre is None else np.array(fibre)
    return polygon_piece(address, corners, thickness, inclinations, fibre=grain, **changes)


def plank(address, long, width, thickness, end_angles, **changes):
    """A trapezoid with its side at y = 0 `long`; its ends slope inward by degrees."""
    left, right = (width * math.tan(math.radians(angle)) for angle in end_angles)
    corners = np.array([(0.0, 0.0), (long, 0.0), (long - right, width), (left, width)])
    grain = np.array([1.0, 0.0])
    return polygon_piece(address, corners, thickness, [0.0] * 4, fibre=grain, **changes)


def turned(piece, address, turn, *, over=False, first=0):
    """The piece turned on the table, maybe turned over before, its sides counted from another."""
    angle = math.radians(turn)
    spin = np.array(
        [
            (math.cos(angle), -math.sin(angle), 0.0),
            (math.sin(angle), math.cos(angle), 0.0),
            (0.0, 0.0, 1.0),
        ]
    )
    if over:
        spin = spin @ np.diag([1.0, -1.0, -1.0])
    raised = np.array([0.0, 0.0, piece.thickness if over else 0.0])

    def flat(outline):
        return np.column_stack([outline, np.zeros(len(outline))]) @ spin.T

    shift = -np.append(flat(piece.silhouette)[:, :2].min(axis=0), 0.0) + raised
    sides = [
        replace(
            side,
            corners=np.roll(side.corners @ spin.T + shift, first, axis=0),
            normal=spin @ side.normal,
            inclination=-side.inclination if over else side.inclination,
        )
        for side in piece.sides
    ]
    lower, upper = ((flat(outline) + shift)[:, :2] for outline in (piece.lower, piece.upper))
    if over:
        lower, upper, sides = upper[::-1], lower[::-1], sides[::-1]
    start = first % len(sides)
    silhouette = (flat(piece.silhouette) + shift)[:, :2]
    return replace(
        piece,
        address=address,
        lower=lower,
        upper=upper,
        silhouette=silhouette[::-1] if over else silhouette,
        sides=(*sides[start:], *sides[:start]),
        fibre=None if piece.fibre is None else (spin @ np.append(piece.fibre, 0.0))[:2],
    )
