"""What was read from a STEP file, understood as panels as far as it can be."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ifs_cad.elements.polyhedron import Polyhedra
from ifs_cad.elements.sheet import Sheet, read_sheet, stacked
from ifs_cad.kernel.inspect import Contents
from ifs_cad.tolerance import Tolerance
from ifs_cad.types import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Findings:
    """The solids of a file, understood as panels as far as they are."""

    contents: Contents
    tol: Tolerance

    @cached_property
    def names(self) -> list[str]:
        """Of the solids."""
        return [solid.name for solid in self.contents.solids]

    @cached_property
    def sheets(self) -> list[Sheet | None]:
        """Each solid as a panel, if possible one of the common thickness."""
        bodies = [solid.boundary for solid in self.contents.solids]
        first = self._common_thickness([read_sheet(body, tol=self.tol) for body in bodies])
        return [read_sheet(body, first, self.tol) for body in bodies]

    @cached_property
    def thickness(self) -> float:
        """The most common one, mm; NaN without any."""
        return self._common_thickness(self.sheets)

    def _common_thickness(self, sheets: Sequence[Sheet | None]) -> float:
        known = [sheet for sheet in sheets if sheet and not sheet.is_stub]
        even = [sheet for sheet in known if sheet.unevenness <= self.tol.planar]
        return most_common([sheet.thickness for sheet in even or known], self.tol.planar)

    @cached_property
    def convex(self) -> IntArray:
        """Numbers of the solids that are convex polyhedra but for their pockets and holes."""
        return np.array(
            [k for k, sheet in enumerate(self.sheets) if sheet and sheet.hull], dtype=np.int64
        )

    @cached_property
    def panels(self) -> Polyhedra | None:
        """The convex ones, in their places."""
        chosen = [(self.contents.solids[k].placement, self.sheets[k]) for k in self.convex]
        hulls = [sheet.hull for _, sheet in chosen if sheet and sheet.hull]
        return stacked([where for where, _ in chosen], hulls) if hulls else None


def most_common(values: Sequence[float] | FloatArray, width: float) -> float:
    """Return the value that most others equal within a width; NaN when there are none."""
    if len(values) == 0:
        return math.nan
    ordered = np.sort(values)
    count = np.searchsorted(ordered, ordered + width, "right")
    count -= np.searchsorted(ordered, ordered - width, "left")
    return float(ordered[count.argmax()])
