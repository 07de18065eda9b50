"""Labels: the address of each panel, placed on one of its faces.

Every label stands upright in the same sense, with a bar beneath, as large as a stepped series of
heights allows and its panel has room for: few different heights mean few different glyphs.

Source: section 4.3 (a unique address for each element, engraved).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import Literal

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.elements.arcs import Path
from ifs_cad.elements.cutting import CuttingFrames, WorkFaces, work_faces
from ifs_cad.elements.glyph import (
    MAX_CUTTER_RATIO,
    bar,
    descent,
    text_paths,
    text_positions,
    traced,
)
from ifs_cad.elements.hole import HolePlaces
from ifs_cad.elements.panel import Face, require_face
from ifs_cad.errors import InputError, LabelError
from ifs_cad.tolerance import DEFAULT, Tolerance
from ifs_cad.types import BoolArray, FloatArray, vector

HEIGHTS = (2.5, 3.5, 5.0, 7.0, 10.0, 14.0, 20.0, 28.0, 40.0, 56.0, 80.0)
"""Cap heights in mm, each about the square root of two times the one before (as in ISO 3098)."""


ASIDE = (0.2, 0.4, 0.6, 0.8, 1.0)
"""How far a label may move from the middle to the corners of its room, to get clear of holes."""


@dataclass(frozen=True)
class Label:
    """How addresses are marked on panels.

    Parameters
    ----------
    face : "inner" or "outer"
    style : "engraved" or "wire"
        Pockets of true depth and width, or strokes as edges on the face for CAM that engraves
        along a line.
    depth : float, mm
    cutter : float
        Diameter of the engraving cutter, mm.
    margin : float
        Least distance of the groove from the sides of the panel and from holes, mm.
    height, min_height : float
        Largest and smallest cap height, mm. The smallest that the cutter allows by default.
    up : (3,) floats
        The direction that all labels point to as far as their face allows.
    """

    face: Face = "inner"
    style: Literal["engraved", "wire"] = "engraved"
    depth: float = 0.5
    cutter: float = 3.0
    margin: float = 5.0
    height: float = 28.0
    min_height: float = 0.0
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        require_face(self.face)
        if self.style not in ("engraved", "wire"):
            raise InputError(f'Label style must be "engraved" or "wire", got {self.style!r}.')
        for name in ("depth", "cutter"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"Label {name} must be positive, got {value} mm.")
        if not (math.isfinite(self.margin) and self.margin >= 0):
            raise InputError(f"Label margin must not be negative, got {self.margin} mm.")
        if not np.any(vector(self.up, "Label direction up")):
            raise InputError("Label direction up must not be the zero vector.")
        if not self.heights:
            raise InputError(
                f"No cap height lies between {self._smallest:g} mm (a {self.cutter:g} mm cutter "
                f"needs {self.cutter / MAX_CUTTER_RATIO:g} mm) and {self.height:g} mm; the heights "
                f"are {', '.join(f'{height:g}' for height in HEIGHTS)}."
            )

    @property
    def _smallest(self) -> float:
        least = self.cutter / MAX_CUTTER_RATIO if self.style == "engraved" else 0.0
        return max(self.min_height, least)

    @property
    def heights(self) -> tuple[float, ...]:
        """The cap heights in use, mm, the smallest first."""
        return tuple(h for h in HEIGHTS if self._smallest <= h <= self.height)

    @property
    def groove_width(self) -> float:
        """Width of what is cut along a stroke, mm; 0 for strokes that are only drawn."""
        return self.cutter if self.style == "engraved" else 0.0


@dataclass(frozen=True, eq=False)
class LabelPlaces:
    """Where each panel's address stands, in its cutting frame; text runs along x.

    Attributes
    ----------
    label : Label
    texts : p texts
    heights : (p,) float, cap heights, mm
    origins : (p, 2) float, left end of the baseline, mm
    """

    label: Label
    texts: tuple[str, ...] = field(repr=False)
    heights: FloatArray = field(repr=False)
    origins: FloatArray = field(repr=False)

    def strokes(self, index: int) -> tuple[Path, ...]:
        """Return the strokes of one label and of its bar, in its frame, mm; dots are rings."""
        text = self.texts[index]
        paths, width = text_paths(text)
        height = float(self.heights[index])
        lines = traced((*paths, bar(width, descent(text))))
        return tuple(path.scaled(height) for path in lines)


def place_labels(
    addresses: Sequence[str],
    frames: CuttingFrames,
    label: Label,
    holes: HolePlaces | None = None,
    tol: Tolerance = DEFAULT,
) -> LabelPlaces:
    """Place the address of every panel on its upper face, clear of sides and holes.

    Raises
    ------
    LabelError
        Panels where it does not fit at the smallest height; a character outside the alphabet; a
        pocket deeper than the panel.
    """
    if label.style == "engraved" and label.depth >= frames.thickness:
        raise LabelError(
            f"A label {label.depth:g} mm deep would cut through panels of {frames.thickness:g} mm."
        )
    texts = tuple(addresses)
    region = work_faces(frames, label.depth if label.style == "engraved" else 0.0)
    low, high = _boxes(texts)
    heights = np.zeros(len(texts))
    centres = np.zeros((len(texts), 2))
    for height in reversed(label.heights):
        todo = np.flatnonzero(heights == 0)
        size = height * (high - low)[todo] + label.groove_width
        corners, kept = _corners(region.take(todo), size / 2, label.margin, tol)
        middle, fits = _middles(corners, kept)
        if holes is not None:
            half, near = size / 2 + label.margin, holes.take(todo)
            met = np.flatnonzero(fits & ~_clear_of_holes(middle, half, near))
            middle[met], fits[met] = _moved_aside(
                middle[met], corners[met], kept[met], half[met], near.take(met)
            )
        heights[todo[fits]] = height
        centres[todo[fits]] = middle[fits]
    lacking = np.flatnonzero(heights == 0)
    if len(lacking):
        names = [texts[i] for i in lacking]
        raise LabelError(
            f"The address does not fit {label.heights[0]:g} mm high, the smallest height, between "
            f"the sides and holes of {listed(names)}. Use a thinner cutter, a smaller margin or "
            "smaller holes, or the wire style.",
            addresses=names,
            height=label.heights[0],
        )
    return LabelPlaces(label, texts, heights, centres - heights[:, None] * (low + high) / 2)


def _boxes(texts: tuple[str, ...]) -> tuple[FloatArray, FloatArray]:
    """Return the (p, 2) lower left and upper right corners of text and bar, in cap heights."""
    boxes = {}
    for text in set(texts):  # addresses of one length differ in few widths, but each is exact
        _, width = text_positions(text)
        below = bar(width, descent(text)).vertices
        boxes[text] = (below[:, 0].min(), below[:, 1].min(), below[:, 0].max(), 1.0)
    both = np.array([boxes[text] for text in texts])
    return both[:, :2], both[:, 2:]


def _corners(
    region: WorkFaces, half: FloatArray, margin: float, tol: Tolerance
) -> tuple[FloatArray, BoolArray]:
    """Return the (p, c, 2) corners of where boxes of (p, 2) half sizes may be centred.

    The centres that keep a box inside all sides form a convex polygon; its corners are meetings of
    two sides that no other side cuts off, so all pairs are tried. The bools tell which hold.
    """
    a = region.inward
    limits = region.limits + margin + np.einsum("pki,pi->pk", np.abs(a), half)
    first, second = np.array(list(combinations(range(a.shape[1]), 2))).T
    one, other = a[:, first], a[:, second]
    turn = one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
    meet = (np.abs(turn) > tol.parallel) & region.is_side[:, first] & region.is_side[:, second]
    at_one, at_other = limits[:, first], limits[:, second]
    corners = (
        np.stack(
            [
                at_one * other[..., 1] - at_other * one[..., 1],
                at_other * one[..., 0] - at_one * other[..., 0],
            ],
            axis=-1,
        )
        / np.where(meet, turn, 1.0)[..., None]
    )
    slack = np.einsum("pki,pci->pck", a, corners) - limits[:, None]
    return corners, meet & (slack >= -tol.planar).all(axis=2)


def _middles(corners: FloatArray, kept: BoolArray) -> tuple[FloatArray, BoolArray]:
    """Return the (p, 2) middle of the corners of each panel that hold, and whether any does."""
    count = kept.sum(axis=1)
    total = np.where(kept[..., None], corners, 0.0).sum(axis=1)
    return total / np.maximum(count, 1)[:, None], count > 0


def _moved_aside(
    middle: FloatArray, corners: FloatArray, kept: BoolArray, half: FloatArray, holes: HolePlaces
) -> tuple[FloatArray, BoolArray]:
    """Return the place nearest to the middle that no hole touches, and whether there is one.

    Places on the way out to the corners are tried, and to halfway between two of them.
    """
    first, second = np.triu_indices(corners.shape[1])
    targets = (corners[:, first] + corners[:, second]) / 2
    open_ = kept[:, first] & kept[:, second]
    best, found = middle.copy(), np.zeros(len(middle), dtype=bool)
    nearest = np.full(len(middle), np.inf)
    for share in ASIDE:
        places = middle[:, None] + share * (targets - middle[:, None])
        for k in range(places.shape[1]):
            away = np.hypot(*(places[:, k] - middle).T)
            good = open_[:, k] & (away < nearest) & _clear_of_holes(places[:, k], half, holes)
            best[good], nearest[good], found[good] = places[good, k], away[good], True
    return best, found


def _clear_of_holes(centres: FloatArray, half: FloatArray, holes: HolePlaces) -> BoolArray:
    """Tell which boxes of (p, 2) half sizes around the centres no hole touches."""
    apart = np.maximum(np.abs(holes.points - centres[:, None]) - half[:, None], 0.0)
    clear = np.hypot(apart[..., 0], apart[..., 1]) >= holes.diameter / 2
    return np.asarray((clear | ~holes.present).all(axis=1))
