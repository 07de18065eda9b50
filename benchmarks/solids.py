"""(b) Engraved solids, glyphs included, against the same panels by CadQuery's own means."""

from __future__ import annotations

import cadquery_way
import designs
import numpy as np
from table import Line, milliseconds
from timing import interleaved

import ifs_cad as ifs
from ifs_cad.elements import glyph, groove
from ifs_cad.kernel import bore, engrave
from ifs_cad.kernel.panels import MadePanel, make_panels

SAMPLE = 12


def forget_glyphs() -> None:
    """Empty the caches, so that the making of glyphs and holes counts every time."""
    for cache in (glyph.glyph, groove.groove, engrave.pocket, engrave.bar, bore.bore):
        cache.cache_clear()


def engraved(shell: ifs.Shell) -> list[MadePanel]:
    """Make the engraved solids of a shell, from the first glyph on."""
    forget_glyphs()
    return list(make_panels(shell, label="engraved"))


def measure(rounds: int) -> list[Line]:
    """Time all solids in turns with a sample of the peer's."""
    shell = designs.shell()
    sample = [panel for panel in shell if panel.index % (len(shell) // SAMPLE) == 0][:SAMPLE]
    require_same_panels(sample)
    times = interleaved(
        {
            "ours": lambda: engraved(shell),
            "peer": lambda: [cadquery_way.engraved_panel(panel) for panel in sample],
        },
        rounds,
        {"ours": 3},
    )
    ours, peer = times["ours"], times["peer"]
    scaled = peer.best * len(shell) / len(sample)
    return [
        Line(
            "b",
            f"{len(shell)} engraved solids, glyphs included, against CadQuery extrude, cut, text()",
            milliseconds(ours.best),
            f"{milliseconds(scaled)} (scaled from {len(sample)} panels)",
            scaled / ours.best,
            " x faster",
            limit=150,
            at_least=True,
            noise=peer.wall / peer.best,
        )
    ]


def require_same_panels(sample: list[ifs.Panel]) -> None:
    """Raise unless the peer's panels have the volumes of ours before their text, and then less."""
    for panel in sample:
        made = cadquery_way.plain_panel(panel).val().Volume()
        marked = cadquery_way.engraved_panel(panel).val().Volume()
        if not (np.isclose(made, panel.volume, rtol=1e-6) and marked < made * (1 - 1e-4)):
            raise AssertionError(
                f"{panel.address}: CadQuery {made} mm3, with text {marked} mm3; ours before the "
                f"engraving {panel.volume} mm3."
            )
