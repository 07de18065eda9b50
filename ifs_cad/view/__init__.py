"""Looking at a model: `preview` on a screen, `render` into a PNG.

Both take the same things: a `cadquery.Assembly`, `Workplane` or `Shape`, or a shell.
"""
