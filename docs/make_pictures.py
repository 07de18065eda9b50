"""Make the pictures of the documentation, and the gallery of all parts.

python docs/make_pictures.py [name ...] makes all of them, or those of these names. It needs
matplotlib; the preview and the studio also Playwright and Chromium.
"""

from __future__ import annotations

import sys
from pathlib import Path

# the browser without a screen that the tests use
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

from drawings import curves, gallery, panels, structure, surfaces, tutorial, viewing
from drawings.style import PICTURES

DRAWINGS = (
    curves.construction_steps,
    curves.subdivision,
    curves.roughness,
    curves.contraction,
    curves.even_fold,
    surfaces.vector_sum,
    surfaces.addresses,
    surfaces.folds,
    panels.section,
    panels.node,
    panels.foot,
    tutorial.tutorial_curves,
    tutorial.tutorial_surface,
    tutorial.tutorial_shell,
    tutorial.tutorial_sheet,
    structure.deformed,
    viewing.sheets,
    viewing.smooth_to_rough,
    viewing.preview,
    viewing.studio,
    gallery.gallery_pictures,
    gallery.gallery_page,
)

if __name__ == "__main__":
    PICTURES.mkdir(exist_ok=True)
    names = {draw.__name__ for draw in DRAWINGS}
    if unknown := set(sys.argv[1:]) - names:
        sys.exit(f"No such picture: {', '.join(sorted(unknown))}. There are {', '.join(names)}.")
    for draw in DRAWINGS:
        if not sys.argv[1:] or draw.__name__ in sys.argv[1:]:
            draw()
            print(f"{draw.__name__}: done")
