"""(b), (h) Engraved solids, glyphs included, against the same made by CadQuery's own means."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import cadquery as cq
import cadquery_way
import designs
import numpy as np
from table import Line, milliseconds
from timing import interleaved

from ifs_cad.elements import glyph, groove
from ifs_cad.elements.element import Elements
from ifs_cad.kernel import bore, engrave
from ifs_cad.kernel.panels import MadePanel, make_panels

SAMPLE = 12


def forget_glyphs() -> None:
    """Empty the caches, so that the making of glyphs and holes counts every time."""
    for cache in (glyph.glyph, groove.groove, engrave.pocket, engrave.bar, bore.bore):
        cache.cache_clear()


def engraved(elements: Elements) -> list[MadePanel]:
    """Make the engraved solids of a shell or a vault, from the first glyph on."""
    forget_glyphs()
    return list(make_panels(elements, label="engraved"))


def measure(rounds: int) -> list[Line]:
    """Time all panels of a shell in turns with a sample of the peer's."""
    shell = designs.shell()
    panels = list(shell)
    return _measured(
        "b",
        f"{len(shell)} engraved solids",
        shell,
        lambda k: cadquery_way.plain_panel(panels[k]),
        lambda k: cadquery_way.engraved_panel(panels[k]),
        rounds,
    )


def measure_planks(rounds: int) -> list[Line]:
    """Time all planks of a vault in turns with a sample of the peer's."""
    vault = designs.vault()
    return _measured(
        "h",
        f"{len(vault)} engraved planks ({vault.segments.count} layers)",
        vault,
        lambda k: cadquery_way.plain_plank(vault, k),
        lambda k: cadquery_way.engraved_plank(vault, k),
        rounds,
    )


def _measured(
    key: str,
    what: str,
    elements: Elements,
    plain: Callable[[int], cq.Workplane],
    marked: Callable[[int], cq.Workplane],
    rounds: int,
) -> list[Line]:
    step = len(elements) // SAMPLE
    sample = range(0, step * SAMPLE, step)
    require_same(elements, sample, plain, marked)
    times = interleaved(
        {
            "ours": lambda: engraved(elements),
            "peer": lambda: [marked(index) for index in sample],
        },
        rounds,
        {"ours": 3},
    )
    ours, peer = times["ours"], times["peer"]
    scaled = peer.best * len(elements) / len(sample)
    return [
        Line(
            key,
            f"{what}, glyphs included, against CadQuery extrude, cut, text()",
            milliseconds(ours.best),
            f"{milliseconds(scaled)} (scaled from {len(sample)})",
            scaled / ours.best,
            " x faster",
            limit=150,
            at_least=True,
            noise=peer.wall / peer.best,
        )
    ]


def require_same(
    elements: Elements,
    sample: Sequence[int],
    plain: Callable[[int], cq.Workplane],
    marked: Callable[[int], cq.Workplane],
) -> None:
    """Raise unless the peer's have the volumes of ours before their text, and then less."""
    for index in sample:
        own = float(elements.solids.volumes[index])
        made, less = plain(index).val().Volume(), marked(index).val().Volume()
        if not (np.isclose(made, own, rtol=1e-6) and less < made * (1 - 1e-4)):
            raise AssertionError(
                f"{elements.addresses[index]}: CadQuery {made} mm3, with text {less} mm3; ours "
                f"before the engraving {own} mm3."
            )
