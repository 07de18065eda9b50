"""Panels as CadQuery solids, with their engraved addresses and fixation holes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import cadquery as cq
from OCP.TopLoc import TopLoc_Location

from ifs_cad import progress
from ifs_cad.elements.cutting import CuttingFrames, cutting_frames
from ifs_cad.elements.element import Elements
from ifs_cad.elements.hole import HolePattern, HolePlaces
from ifs_cad.elements.label import Label, LabelPlaces, place_labels
from ifs_cad.elements.panel import Panel
from ifs_cad.elements.polyhedron import Kind
from ifs_cad.errors import InputError
from ifs_cad.kernel import engrave
from ifs_cad.kernel.bore import bore
from ifs_cad.kernel.solid import Inset, build_solid, location, shift

LabelChoice = Label | Literal["engraved", "wire"] | None


@dataclass(frozen=True)
class MadePanel:
    """The solid of one panel, lying in its cutting frame.

    Attributes
    ----------
    solid : cadquery Solid
    strokes : cadquery Compound or None, the address as edges on the face (style "wire")
    location : cadquery Location, takes both to their place in the shell
    volume : float, mm3, in closed form: the panel less its pockets and holes
    """

    solid: cq.Solid
    strokes: cq.Compound | None
    location: cq.Location
    volume: float


def make_panels(
    elements: Elements, *, label: LabelChoice = None, holes: HolePattern | None = None
) -> Iterator[MadePanel]:
    """Make the solid of every panel or beam, one after the other.

    Raises
    ------
    LabelError, HoleError
        A label or hole that does not fit; raised before the first solid is made.
    """
    chosen, tol = as_label(label), elements.tol
    frames = (
        cutting_frames(elements)
        if chosen is None
        else cutting_frames(elements, chosen.face, chosen.up)
    )
    hole_places = None if holes is None else holes.place(elements, frames)
    label_places = None
    if chosen is not None:
        label_places = place_labels(elements.addresses, frames, chosen, hole_places, tol)
    return _make(frames, label_places, hole_places)


def to_solid(
    panel: Panel, *, label: LabelChoice = None, holes: HolePattern | None = None
) -> cq.Solid:
    """Return one panel as a CadQuery solid, in its place in the shell.

    Raises
    ------
    LabelError, HoleError
        A label or hole that does not fit.
    """
    made = next(make_panels(panel.shell.take([panel.index]), label=label, holes=holes))
    return made.solid.moved(made.location)


def as_label(label: LabelChoice) -> Label | None:
    """Read how panels are to be labelled: a Label, the name of a style, or None.

    Raises
    ------
    InputError
    """
    if label is None or isinstance(label, Label):
        return label
    if label in ("engraved", "wire"):
        return Label(style=label)
    raise InputError(f'A label must be a Label, "engraved", "wire" or None, got {label!r}.')


def _make(
    frames: CuttingFrames, labels: LabelPlaces | None, holes: HolePlaces | None
) -> Iterator[MadePanel]:
    face = Kind.LOWER if labels is None or labels.label.face == "inner" else Kind.UPPER
    volumes = frames.solids.volumes.tolist()
    for index, (volume, axes, origin) in enumerate(
        zip(volumes, frames.axes, frames.origins, strict=True)
    ):
        insets = [] if holes is None else _bores(frames, holes, index, face)
        strokes = None
        if labels is not None:
            x, y = labels.origins[index].tolist()
            place = shift(x, y, frames.thickness)
            if labels.label.style == "engraved":
                insets += _pockets(labels, index, face, place)
            else:
                strokes = cq.Compound(engrave.wire_strokes(labels.strokes(index)).Moved(place))
        yield MadePanel(
            cq.Solid(build_solid(frames.solids, index, insets)),
            strokes,
            cq.Location(location(axes, origin)),
            volume - sum(inset.volume for inset in insets),
        )
        progress.report("making solids", index + 1, len(volumes))


def _bores(frames: CuttingFrames, holes: HolePlaces, index: int, face: Kind) -> list[Inset]:
    bored = bore(holes.diameter, frames.thickness, face)
    points = holes.points[index][holes.present[index]].tolist()
    return [bored.moved(shift(x, y, frames.thickness)) for x, y in points]


def _pockets(labels: LabelPlaces, index: int, face: Kind, place: TopLoc_Location) -> list[Inset]:
    label, height = labels.label, float(labels.heights[index])
    pockets = engrave.engraved_text(labels.texts[index], height, label.cutter, label.depth, place)
    return [Inset({face: pocket.rims}, pocket.faces, pocket.volume) for pocket in pockets]
