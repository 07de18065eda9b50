"""(a) Curves to relieved panels with numpy alone: how long, and how it grows."""

from __future__ import annotations

import designs
from table import Line, milliseconds
from timing import interleaved

from ifs_cad.elements.polyhedron import Kind


def measure(rounds: int) -> list[Line]:
    """Time 256 panels in turns with 65,536."""
    few, many = 4**designs.DEPTH, 4**designs.FINE_DEPTH
    times = interleaved(
        {"few": designs.shell, "many": lambda: designs.shell(designs.FINE_DEPTH)},
        rounds,
        {"few": 40},
    )
    small, large = times["few"], times["many"]
    cuts = [
        int((designs.shell(depth).solids.kinds == Kind.RELIEF).sum())
        for depth in (designs.DEPTH, designs.FINE_DEPTH)
    ]
    each, each_of_many = small.best / few, large.best / many
    return [
        Line(
            "a",
            f"curves to {few} relieved panels ({cuts[0]} relief cuts), numpy only",
            milliseconds(small.best),
            "",
            small.best * 1e3,
            " ms",
            limit=5.0,
            noise=small.wall / small.best,
        ),
        Line(
            "a",
            f"the same for {many:,} panels ({cuts[1]:,} relief cuts), per panel",
            f"{each_of_many * 1e6:.3g} µs a panel",
            f"{each * 1e6:.3g} µs a panel at {few}",
            each_of_many / each,
            " x",
            limit=1.5,
            noise=large.wall / large.best,
        ),
    ]
