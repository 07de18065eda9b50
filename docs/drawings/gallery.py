"""The gallery: every part with its picture, the words of its script and its numbers."""

from __future__ import annotations

import ast
from pathlib import Path
from runpy import run_path

import cadquery as cq

import ifs_cad as ifs

DOCS = Path(__file__).parent.parent
GALLERY = DOCS / "gallery"
PARTS = DOCS.parent / "parts"

FLAT = 0.05  # of its length: a drawing, seen from above
FROM_ABOVE, ASLANT = (-90.0, 90.0), (-60.0, 25.0)
VIEWS = {
    "shell_prototype": (-38.0, 20.0),
    "climbing_wall": (-75.0, 12.0),
    "figure_11_vector_sum": (-125.0, 25.0),
}
HEAD = """# Gallery

Every picture is one script in `parts/`, drawn by `ifs.render`, and every script is a start for a
design of your own: `ifs-cad build parts/dome.py --set sides=30`. This page and its
pictures are made by `make pictures`.
"""


def gallery_pictures() -> None:
    """Draw every part."""
    GALLERY.mkdir(exist_ok=True)
    for name in names():
        _draw(shown(name), name)


def gallery_page() -> None:
    """Write the page that shows them."""
    page = [HEAD]
    for name in names():
        words = ast.get_docstring(ast.parse((PARTS / f"{name}.py").read_text(encoding="utf-8")))
        picture = f"![{name}](gallery/{name}.png)"
        page += [f"## {name}", "", words or "", "", picture, "", numbers(shown(name)), ""]
    (DOCS / "gallery.md").write_text("\n".join(page), encoding="utf-8")


def names() -> list[str]:
    """Return the names of all parts."""
    return sorted(script.stem for script in PARTS.glob("*.py"))


def shown(name: str) -> cq.Assembly:
    """Return what a part script shows."""
    results: list[cq.Assembly] = []
    run_path(
        str(PARTS / f"{name}.py"),
        init_globals={"show_object": lambda thing, **_: results.append(thing)},
    )
    return results[0]


def numbers(assembly: cq.Assembly) -> str:
    """Return what a part is, in one line: how many pieces, of what, how heavy, how large."""
    parts = [part for part in assembly.objects.values() if part.obj is not None]
    box = assembly.toCompound().BoundingBox()
    lengths = (box.xlen, box.ylen, box.zlen)
    size = " x ".join(f"{n / 1000:.2f}" for n in lengths if n > FLAT * max(lengths))
    mass = sum(part.metadata.get("mass", 0.0) for part in parts)
    elements = assembly.metadata.get("elements")
    words = f"{len(parts)} parts"
    if elements is not None:
        kind = {ifs.Shell: "panels", ifs.Vault: "planks", ifs.WireFrame: "beams"}[type(elements)]
        words = f"{len(parts)} {kind} of {elements.material.name}"
    weight = f", {mass:.0f} kg" if mass else ""
    return f"*{words}{weight}, {size} m.*"


def _draw(assembly: cq.Assembly, name: str) -> None:
    box = assembly.toCompound().BoundingBox()
    is_flat = box.zlen < FLAT * max(box.xlen, box.ylen)
    azimuth, elevation = VIEWS.get(name, FROM_ABOVE if is_flat else ASLANT)
    path = GALLERY / f"{name}.png"
    ifs.render(assembly, path, width=1200, height=750, azimuth=azimuth, elevation=elevation)
