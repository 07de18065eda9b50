"""Draw triangles and lines as a PNG: a program of its own, run by `render`.

Asking VTK for a window that the machine cannot make ends the whole process, so the drawing
happens in a process that may die. It reads an ``.npz`` of arrays on stdin and writes the PNG to
stdout; it knows nothing of CAD.

Arrays of the input
-------------------
points : (n, 3) float, mm
triangles : (t, 3) int, into points; what shares a point is smooth there
triangle_colors : (t, 4) uint8, RGBA
lines : (l, 2) int, into points
line_colors : (l, 4) uint8, RGBA
strokes, stroke_colors : the same for parts that have no faces
size : (2,) int, width and height in pixels
view : (3,) float, azimuth and elevation in degrees, zoom
background : (3,) float, RGB from 0 to 1
legend : (k, 3) uint8, optional, colours of a scale from low to high
legend_range : (2,) float, the values at its ends
legend_title : text
"""

from __future__ import annotations

import io
import sys
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import vtkmodules.vtkRenderingFreeType  # noqa: F401  without it VTK draws no letters
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter
from vtkmodules.util import numpy_support
from vtkmodules.vtkCommonCore import vtkLookupTable, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkImageData, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkCamera,
    vtkLight,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkRenderWindow,
    vtkWindowToImageFilter,
)
from vtkmodules.vtkRenderingOpenGL2 import vtkRenderStepsPass, vtkSSAOPass

Array = NDArray[Any]
Scene = Mapping[str, Array]

from_vtk: Callable[[Any], Array] = numpy_support.vtk_to_numpy
to_vtk: Callable[..., Any] = numpy_support.numpy_to_vtk
to_vtk_ids: Callable[..., Any] = numpy_support.numpy_to_vtkIdTypeArray

SUPERSAMPLING = 2
FIELD_OF_VIEW = 18.0  # degrees, vertically: a long lens keeps parallels nearly parallel
FILL = 0.92  # share of the frame that the model takes in the tighter direction
LINE_WIDTH = 1.0  # pixels, of the edges of faces
STROKE_WIDTH = 2.0  # pixels, of lines that are all there is of a part
AMBIENT = 0.4
LIGHTS = (  # where from, as the camera sees it (right, up, towards it), and how strong
    ((-0.7, 1.0, 0.8), 0.5),
    ((0.6, 0.2, 1.0), 0.36),
    ((0.0, -1.0, 0.3), 0.12),
)
OCCLUSION = 0.07  # reach of the dimming in folds and corners, share of the model's size
OCCLUSION_BIAS = 0.05  # share of that reach within which a flat face does not dim itself
OCCLUSION_RAYS = 24
SHADOW = 0.25  # darkness of the floor under the model
LETTERS = 0.02  # of a legend, share of the picture's height
INK = (0.15, 0.15, 0.15)
SHADOW_BLUR = 0.012  # share of the picture's width


def draw(scene: Scene) -> bytes:
    """Return the PNG of a scene: the model over a background, with a soft shadow on the floor."""
    width, height = (int(pixels) for pixels in scene["size"])
    azimuth, elevation, zoom = scene["view"]
    on_floor = scene["points"].copy()
    on_floor[:, 2] = on_floor[:, 2].min()
    floor_is_seen = np.sin(np.radians(elevation)) > 0
    framed = np.concatenate([scene["points"], on_floor]) if floor_is_seen else scene["points"]
    camera = framing_camera(framed, azimuth, elevation, zoom, width / height)
    color, coverage = photograph(model_renderer(scene), camera, width, height, SUPERSAMPLING)
    floor = np.ones_like(coverage)
    if floor_is_seen:
        shadow = shadow_renderer(on_floor, scene["triangles"])
        _, covered = photograph(shadow, camera, width, height, 1)
        floor -= SHADOW * gaussian_filter(covered, SHADOW_BLUR * width)
    picture = color + ((1.0 - coverage) * floor)[..., None] * scene["background"]
    if "legend" in scene:
        scale, covered = photograph(legend_renderer(scene), vtkCamera(), width, height, 2)
        picture = scale + (1.0 - covered)[..., None] * picture
    return png(np.rint(255.0 * np.clip(picture, 0.0, 1.0)).astype(np.uint8))


def framing_camera(
    points: Array, azimuth: float, elevation: float, zoom: float, aspect: float
) -> vtkCamera:
    """Return a perspective camera that sees all points, as large as FILL allows.

    In the camera's directions a point (x, y, z) is in the frame when |x - cx| <= t (d - z), with t
    the tangent of half the angle of view. That is linear in the camera's place (cx, cy, d), so the
    nearest place follows from the extremes of x + t z and -x + t z, and likewise for y. It is never
    nearer than the model is deep.
    """
    a, e = np.radians([azimuth, elevation])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    back = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    basis = np.array([right, np.cross(back, right), back])
    place = points @ basis.T
    tangent = np.tan(np.radians(FIELD_OF_VIEW / 2)) * FILL * np.array([aspect, 1.0])
    above = (place[:, :2] + tangent * place[:, 2:]).max(axis=0)
    below = (-place[:, :2] + tangent * place[:, 2:]).max(axis=0)
    z = place[:, 2]
    # seen end-on, a long thin model would otherwise reach up to the lens
    distance = max(((above + below) / (2 * tangent)).max(), z.max() + np.ptp(z))
    center = (above - below) / 2
    camera = vtkCamera()
    camera.SetPosition(*(np.array([*center, distance]) @ basis))
    camera.SetFocalPoint(*(np.array([*center, z.mean()]) @ basis))
    camera.SetViewUp(*basis[1])
    camera.SetViewAngle(FIELD_OF_VIEW)
    camera.Zoom(zoom)
    return camera


def photograph(
    renderer: vtkRenderer, camera: vtkCamera, width: int, height: int, fine: int
) -> tuple[Array, Array]:
    """Return colours (h, w, 3) over black and coverage (h, w), from 0 to 1, top row first.

    Each pixel is the mean of `fine` x `fine` drawn ones.
    """
    renderer.SetBackground(0.0, 0.0, 0.0)
    renderer.SetBackgroundAlpha(0.0)
    renderer.SetActiveCamera(camera)
    renderer.ResetCameraClippingRange()
    window = vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetAlphaBitPlanes(True)
    window.SetMultiSamples(0)
    window.SetSize(width * fine, height * fine)
    window.AddRenderer(renderer)
    window.Render()
    grab = vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.SetInputBufferTypeToRGBA()
    grab.ReadFrontBufferOff()
    grab.Update()
    values = from_vtk(grab.GetOutput().GetPointData().GetScalars())
    drawn = values.reshape(height, fine, width, fine, 4)[::-1]
    image = drawn.mean(axis=(1, 3), dtype=np.float32) / 255.0
    return image[..., :3], image[..., 3]


def model_renderer(scene: Scene) -> vtkRenderer:
    """Return the lit model, dimmed in its folds."""
    renderer = vtkRenderer()
    renderer.AutomaticLightCreationOff()
    for place, strength in LIGHTS:
        light = vtkLight()
        light.SetLightTypeToCameraLight()
        light.SetPosition(*place)
        light.SetIntensity(strength)
        renderer.AddLight(light)

    reach = OCCLUSION * float(np.linalg.norm(np.ptp(scene["points"], axis=0)))
    dimming = vtkSSAOPass()
    dimming.SetRadius(reach)
    dimming.SetBias(OCCLUSION_BIAS * reach)
    dimming.SetKernelSize(OCCLUSION_RAYS)
    dimming.BlurOn()
    dimming.SetDelegatePass(vtkRenderStepsPass())
    renderer.SetPass(dimming)

    opaque = scene["triangle_colors"][:, 3] == 255
    for drawn_together in (opaque, ~opaque):
        if drawn_together.any():
            renderer.AddActor(faces_actor(scene, drawn_together))
    for lines, width in (("line", LINE_WIDTH), ("stroke", STROKE_WIDTH)):
        cells, colors = scene[f"{lines}s"], scene[f"{lines}_colors"]
        if len(cells):
            actor = actor_of(mesh(scene["points"], cells, colors))
            actor.GetProperty().LightingOff()
            actor.GetProperty().SetLineWidth(width * SUPERSAMPLING)
            renderer.AddActor(actor)
    return renderer


def faces_actor(scene: Scene, of_triangles: Array) -> vtkActor:
    """Return some of the triangles, smooth where they share points."""
    triangles, colors = scene["triangles"][of_triangles], scene["triangle_colors"][of_triangles]
    normals = vtkPolyDataNormals()
    normals.SetInputData(mesh(scene["points"], triangles, colors))
    normals.SplittingOff()
    normals.ConsistencyOff()
    normals.Update()
    faces = actor_of(normals.GetOutput())
    faces.GetMapper().SetResolveCoincidentTopologyToPolygonOffset()  # edges win over their faces
    faces.GetMapper().SetRelativeCoincidentTopologyPolygonOffsetParameters(1.0, 1.0)
    faces.GetProperty().SetAmbient(AMBIENT)
    return faces


def shadow_renderer(on_floor: Array, triangles: Array) -> vtkRenderer:
    """Return the model pressed flat onto the floor under it."""
    renderer = vtkRenderer()
    renderer.AddActor(actor_of(mesh(on_floor, triangles)))
    return renderer


def legend_renderer(scene: Scene) -> vtkRenderer:
    """Return a scale of colours at the right edge, with its title and values."""
    colors = scene["legend"]
    table = vtkLookupTable()
    table.SetNumberOfTableValues(len(colors))
    table.SetTableRange(*scene["legend_range"])
    for number, color in enumerate(colors / 255.0):
        table.SetTableValue(number, (*color.tolist(), 1.0))
    bar = vtkScalarBarActor()
    bar.SetLookupTable(table)
    bar.SetTitle(str(scene["legend_title"]))
    bar.SetNumberOfLabels(5)
    bar.SetLabelFormat("{:.3g}")
    bar.UnconstrainedFontSizeOn()
    bar.SetWidth(0.07)
    bar.SetHeight(0.45)
    bar.GetPositionCoordinate().SetCoordinateSystemToNormalizedViewport()
    bar.SetPosition(0.9, 0.5)
    pixels = int(LETTERS * scene["size"][1]) * 2
    for words in (bar.GetTitleTextProperty(), bar.GetLabelTextProperty()):
        words.SetColor(*INK)
        words.SetFontSize(pixels)
        words.ItalicOff()
        words.BoldOff()
        words.ShadowOff()
    renderer = vtkRenderer()
    renderer.AddViewProp(bar)
    return renderer


def actor_of(data: vtkPolyData) -> vtkActor:
    """Return an actor that draws a mesh in the colours of its cells."""
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(data)
    actor = vtkActor()
    actor.SetMapper(mapper)
    return actor


def mesh(points: Array, cells: Array, colors: Array | None = None) -> vtkPolyData:
    """Return lines (n, 2) or triangles (n, 3) as VTK holds them."""
    count, corners = cells.shape
    connected = vtkCellArray()
    connected.SetData(
        to_vtk_ids(np.arange(count + 1) * corners, deep=True),
        to_vtk_ids(cells.ravel(), deep=True),
    )
    held = vtkPoints()
    held.SetData(to_vtk(points, deep=True))
    data = vtkPolyData()
    data.SetPoints(held)
    (data.SetLines if corners == 2 else data.SetPolys)(connected)
    if colors is not None:
        data.GetCellData().SetScalars(to_vtk(colors, deep=True))
    return data


def png(picture: Array) -> bytes:
    """Return an (h, w, 3) uint8 picture as the bytes of a PNG file."""
    height, width, _ = picture.shape
    image = vtkImageData()
    image.SetDimensions(width, height, 1)
    image.GetPointData().SetScalars(to_vtk(picture[::-1].reshape(-1, 3), deep=True))
    writer = vtkPNGWriter()
    writer.WriteToMemoryOn()
    writer.SetInputData(image)
    writer.Write()
    return from_vtk(writer.GetResult()).tobytes()


if __name__ == "__main__":
    with np.load(io.BytesIO(sys.stdin.buffer.read())) as arrays:
        sys.stdout.buffer.write(draw(arrays))
