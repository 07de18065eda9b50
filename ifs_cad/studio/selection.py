"""Which point of each curve the page's boxes are about."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from ifs_cad.design_record import Design, DrawnCurve
from ifs_cad.errors import IfsCadError
from ifs_cad.studio.bindings import DECIMALS
from ifs_cad.studio.evaluation import CurveName
from ifs_cad.studio.handles import CURVES, Key

Place = tuple[float, float, float]

__all__ = ["Place", "Selection", "handles_of", "point_of", "shown"]


class Selection:
    """One selected point a curve, and the last one of all.

    Attributes
    ----------
    active : Key or None
        What stands out in the scene.
    changed : callable
        Called after every change.
    """

    def __init__(self) -> None:
        self.active: Key | None = None
        self.changed: Callable[[], None] = lambda: None
        self._chosen: dict[CurveName, int | str] = dict.fromkeys(CURVES, 0)

    def choose(self, key: Key) -> None:
        """Select a point."""
        if (self.active, self._chosen[key.curve]) != (key, key.handle):
            self.active, self._chosen[key.curve] = key, key.handle
            self.changed()

    def of(self, curve: CurveName, design: Design) -> int | str:
        """Return the selected point of a curve; the first one when it is gone."""
        drawn: DrawnCurve = getattr(design, curve)
        handle = self._chosen[curve]
        return handle if handle in handles_of(drawn) else 0


@lru_cache(64)
def handles_of(drawn: DrawnCurve) -> tuple[int | str, ...]:
    """Return the points of a curve: numbers of control points, then names of subdivision points."""
    scheme = drawn.plain_scheme.with_symmetry() if drawn.symmetric else drawn.plain_scheme
    names = [n for n, fixed in zip(scheme.names, scheme.fixed, strict=True) if not fixed]
    return (*range(len(drawn.control_points)), *dict.fromkeys(names))


@lru_cache(64)
def point_of(drawn: DrawnCurve, handle: int | str) -> tuple[Place, float] | None:
    """Return where a point of a curve is, mm, and its weight; None where that cannot be told."""
    if isinstance(handle, int):
        return drawn.control_points[handle], drawn.weights[handle]
    try:
        base = drawn.base()
        x, y, z = base.subdivision_points[handle].tolist()
        return (x, y, z), base.subdivision_weights[handle]
    except (IfsCadError, KeyError):
        return None


def shown(place: Place) -> Place:
    """Return a place as the boxes show it."""
    x, y, z = (round(value, DECIMALS) + 0.0 for value in place)
    return x, y, z
