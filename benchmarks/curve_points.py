"""(g) A million points of a curve against one matrix product that fills an array of that size."""

from __future__ import annotations

import numpy as np
from table import Line, milliseconds
from timing import interleaved

from ifs_cad.design.curve import Curve

DEPTH = 20
CONTROL = np.array([(0, 0, 0), (400, 900, 200), (1500, 700, -300), (2000, 0, 0)], dtype=float)


def measure(rounds: int) -> list[Line]:
    """Time the points of a cubic curve in turns with (n, 4) @ (4, 3)."""
    basis = np.random.default_rng(0).normal(size=(2**DEPTH + 1, len(CONTROL)))
    times = interleaved(
        {
            "points": lambda: Curve(CONTROL, depth=DEPTH).points,
            "product": lambda: basis @ CONTROL,
        },
        2 * rounds,
    )
    points, product = times["points"], times["product"]
    return [
        Line(
            "g",
            f"{2**DEPTH + 1:,} points of a cubic curve",
            milliseconds(points.best),
            f"{milliseconds(product.best)} one matrix product of that size",
            points.best / product.best,
            " x",
            limit=5.0,
            noise=points.wall / points.best,
        )
    ]
