"""Colours of the page, each with one meaning everywhere."""

from __future__ import annotations

Colour = tuple[int, int, int]

WOOD: Colour = (214, 172, 114)
SURFACE: Colour = (226, 196, 148)
EDGE: Colour = (92, 64, 38)
ENGRAVED: Colour = (70, 44, 22)
CURVE: Colour = (150, 92, 36)
CONTROL: Colour = (44, 52, 60)
SUBDIVISION: Colour = (44, 111, 187)
SELECTED: Colour = (247, 148, 29)
WRONG: Colour = (214, 36, 36)
DOUBTFUL: Colour = (224, 150, 20)
GRID: Colour = (222, 217, 210)
SECTION: Colour = (196, 189, 180)
BRAND: Colour = (150, 92, 36)


def css(colour: Colour) -> str:
    """Return a colour as style sheets write it."""
    return "#{:02x}{:02x}{:02x}".format(*colour)
