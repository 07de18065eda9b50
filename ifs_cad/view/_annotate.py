"""Words over a picture, for the drawing program: a scale of colours, and addresses on faces.

Arrays of the input
-------------------
legend : (k, 3) uint8, optional, colours of a scale from low to high, or of names
legend_title : text
legend_range : (2,) float, the values at the ends of a scale
legend_names : (k,) text, instead of a range
labels : (m,) text, optional
label_points, label_normals : (m, 3) float, the middle of each labelled face and where it faces
label_axes : (m, 3) float, unit vectors along the longest edge of each
label_sizes : (m, 2) float, how long it is, and how wide across that, mm
label_inks : (m, 3) uint8
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import vtkmodules.vtkRenderingFreeType  # noqa: F401  without it VTK draws no letters
from vtkmodules.vtkCommonCore import vtkLookupTable, vtkVariant
from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
from vtkmodules.vtkRenderingCore import vtkCamera, vtkRenderer, vtkTextActor

from ifs_cad.view._photograph import Array, Scene, photograph

MARGIN = 0.14  # share of the width that a legend takes
LETTERS = 0.02  # of a legend, share of the picture's height
LARGEST_LABEL = 0.035  # share of the picture's height
SMALLEST_LABEL = 6.0  # pixels: smaller ones cannot be read and are left out
LETTERS_ROOM = 0.75  # share of a face that letters may take, across and upwards
LETTER_WIDTH = 0.6  # of a digit, share of the letters' height
TOWARDS = 0.15  # least cosine between a labelled face and the line of sight
BEHIND = 2e-4  # how much deeper than the face seen a label's point may lie, share of the range
FINE = 2
INK = (0.15, 0.15, 0.15)
NAMES_SHOWN = 24
NAME_HEIGHT = 0.032  # share of the picture's height


def margin_of(scene: Scene) -> int:
    """Return how many pixels at the right belong to a legend."""
    return int(MARGIN * scene["size"][0]) if "legend" in scene else 0


def annotated(
    picture: Array, scene: Scene, camera: vtkCamera, width: int, depth: Callable[[], Array]
) -> Array:
    """Return an (h, w, 3) picture with the words of a scene over it.

    Parameters
    ----------
    picture : (h, w, 3) float, from 0 to 1
    scene : Scene
    camera : that took the picture
    width : int, pixels of the picture that the camera took
    depth : gives `depths` of the model
    """
    height = len(picture)
    over = []
    if "legend" in scene:
        over.append((_legend(scene), slice(None)))
    if "labels" in scene and (labels := _labels(scene, camera, width, height, depth)):
        over.append((labels, slice(0, width)))
    for renderer, columns in over:
        part = picture[:, columns]
        words, covered = photograph(renderer, vtkCamera(), part.shape[1], height, FINE)
        picture[:, columns] = words + (1.0 - covered)[..., None] * part
    return picture


def _legend(scene: Scene) -> vtkRenderer:
    """Return a scale of colours, or one field for each name, at the right edge."""
    colors = scene["legend"]
    named = "legend_names" in scene
    names = scene["legend_names"].tolist() if named else []
    if len(names) > NAMES_SHOWN:
        names = [*names[:NAMES_SHOWN], f"and {len(names) - NAMES_SHOWN} more"]
        colors = np.concatenate([colors[:NAMES_SHOWN], [(255, 255, 255)]])
    table = vtkLookupTable()
    table.SetNumberOfTableValues(len(colors))
    for number, color in enumerate(colors / 255.0):
        table.SetTableValue(number, (*color.tolist(), 1.0))
    bar = vtkScalarBarActor()
    bar.SetLookupTable(table)
    bar.SetTitle(str(scene["legend_title"]))
    pixels = int(LETTERS * scene["size"][1]) * FINE
    tall = 0.45
    if not named:
        table.SetTableRange(*scene["legend_range"])
        bar.SetNumberOfLabels(5)
        bar.SetLabelFormat("{:.3g}")
    else:
        table.IndexedLookupOn()
        for number, name in enumerate(names):
            table.SetAnnotation(vtkVariant(number), name)
        bar.SetDrawTickLabels(False)
        tall = min(0.9, NAME_HEIGHT * len(colors) + 0.06)
    bar.UnconstrainedFontSizeOn()
    bar.SetWidth(MARGIN * 0.55)
    bar.SetHeight(tall)
    bar.GetPositionCoordinate().SetCoordinateSystemToNormalizedViewport()
    bar.SetPosition(1 - MARGIN * (0.6 if named else 0.85), 0.95 - tall)
    words = (
        bar.GetTitleTextProperty(),
        bar.GetLabelTextProperty(),
        bar.GetAnnotationTextProperty(),
    )
    for letters in words:
        letters.SetColor(*INK)
        letters.SetFontSize(pixels)
        letters.ItalicOff()
        letters.BoldOff()
        letters.ShadowOff()
    renderer = vtkRenderer()
    renderer.AddViewProp(bar)
    return renderer


def _labels(
    scene: Scene, camera: vtkCamera, width: int, height: int, depth: Callable[[], Array]
) -> vtkRenderer | None:
    """Return the labels of the faces that are seen, as large as they fit; None without any."""
    points, normals = scene["label_points"], scene["label_normals"]
    sight = np.array(camera.GetPosition()) - points
    distance = np.linalg.norm(sight, axis=1)
    cosine = (normals * sight).sum(axis=1) / distance
    ground = depth()  # also sets how near and far the camera sees
    matrix = camera.GetCompositeProjectionTransformMatrix(width / height, 0.0, 1.0)
    rows = np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])
    seen = np.column_stack([points, np.ones(len(points))]) @ rows.T
    x, y, z = (seen[:, :3] / seen[:, 3:]).T
    column = np.clip(((x + 1) / 2 * width).astype(int), 0, width - 1)
    row = np.clip(((1 - y) / 2 * height).astype(int), 0, height - 1)
    per_mm = height / (2 * distance * np.tan(np.radians(camera.GetViewAngle() / 2)))
    up = np.array(camera.GetViewUp())
    right = np.cross(up, np.array(camera.GetPosition()) - np.array(camera.GetFocalPoint()))
    sides = np.stack([right / np.linalg.norm(right), up], axis=1)
    axes = scene["label_axes"]
    along, across = axes @ sides, np.cross(normals, axes) @ sides
    drawn = np.stack([np.linalg.norm(side, axis=1) for side in (along, across)], axis=1)
    room = scene["label_sizes"] * drawn * per_mm[:, None]
    is_upright = np.abs(along[:, 1]) > np.abs(along[:, 0])
    room[is_upright] = room[is_upright, ::-1]
    room *= LETTERS_ROOM
    lengths = np.array([len(text) for text in scene["labels"].tolist()])
    size = np.minimum(room[:, 0] / (LETTER_WIDTH * lengths), room[:, 1])
    size = np.minimum(size, LARGEST_LABEL * height)
    is_seen = (np.maximum(np.abs(x), np.abs(y)) < 1) & (cosine > TOWARDS)
    # of a slanting face the next pixel may be much deeper
    around = np.lib.stride_tricks.sliding_window_view(np.pad(ground, 1, mode="edge"), (3, 3))
    is_seen &= z <= around[row, column].max(axis=(-2, -1)) + BEHIND
    is_seen &= size >= SMALLEST_LABEL
    if not is_seen.any():
        return None
    renderer = vtkRenderer()
    for k in np.flatnonzero(is_seen):
        actor = vtkTextActor()
        actor.SetInput(str(scene["labels"][k]))
        actor.SetDisplayPosition(
            round((x[k] + 1) / 2 * width * FINE), round((y[k] + 1) / 2 * height * FINE)
        )
        letters = actor.GetTextProperty()
        letters.SetFontSize(int(size[k] * FINE))
        letters.SetColor(*(scene["label_inks"][k] / 255.0).tolist())
        letters.SetJustificationToCentered()
        letters.SetVerticalJustificationToCentered()
        renderer.AddViewProp(actor)
    return renderer
