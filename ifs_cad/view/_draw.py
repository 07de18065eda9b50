"""Draw triangles and lines as PNGs: a program of its own, run by `render`.

Asking VTK for a window that the machine cannot make ends the whole process, so the drawing
happens in a process that may die. Its arguments are ``.npz`` files of arrays; beside each it
writes the PNG, and then prints the name of the file. It knows nothing of CAD.

Arrays of the input
-------------------
points : (n, 3) float, mm
triangles : (t, 3) int, into points; what shares a point is smooth there
triangle_colors : (t, 4) uint8, RGBA
lines : (l, 2) int, into points
line_colors : (l, 4) uint8, RGBA
strokes, stroke_colors : the same for parts that have no faces
frame : (k, 3) float, optional, what the camera must see instead of the points
floor : float, optional, height of the floor under the model instead of its lowest point, mm
size : (2,) int, width and height in pixels
view : (3,) float, azimuth and elevation in degrees, zoom
background : (3,) float, RGB from 0 to 1
and those of ``_annotate.py``
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkImageData, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals
from vtkmodules.vtkImagingGeneral import vtkImageGaussianSmooth
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkCamera,
    vtkLight,
    vtkPolyDataMapper,
    vtkRenderer,
)
from vtkmodules.vtkRenderingOpenGL2 import vtkRenderStepsPass, vtkSSAOPass

from ifs_cad.view._annotate import annotated, margin_of
from ifs_cad.view._photograph import Array, Scene, depths, from_vtk, photograph, to_vtk, to_vtk_ids

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
SHADOW_BLUR = 0.012  # share of the picture's width


def draw(scene: Scene) -> bytes:
    """Return the PNG of a scene: the model over a background, with a soft shadow on the floor."""
    width, height = (int(pixels) for pixels in scene["size"])
    margin = margin_of(scene)
    width -= margin
    azimuth, elevation, zoom = scene["view"]
    on_floor = scene["points"].copy()
    on_floor[:, 2] = scene.get("floor", on_floor[:, 2].min())
    framed = scene.get("frame", scene["points"])
    floor_is_seen = bool(np.sin(np.radians(elevation)) > 0)
    if floor_is_seen:
        under = framed.copy()
        under[:, 2] = on_floor[0, 2]
        framed = np.concatenate([framed, under])
    camera = framing_camera(framed, azimuth, elevation, zoom, width / height)
    color, coverage = photograph(model_renderer(scene), camera, width, height, SUPERSAMPLING)
    color *= dimming(scene, camera, width, height)[..., None]
    floor = np.ones_like(coverage)
    if floor_is_seen:
        shadow = shadow_renderer(on_floor, scene["triangles"])
        _, covered = photograph(shadow, camera, width, height, 1)
        floor -= SHADOW * blurred(covered, SHADOW_BLUR * width)
    picture = color + ((1.0 - coverage) * floor)[..., None] * scene["background"]

    def depth() -> Array:
        return depths(faces_renderer(scene), camera, width, height)

    paper = np.broadcast_to(scene["background"], (height, margin, 3))
    picture = annotated(np.concatenate([picture, paper], axis=1), scene, camera, width, depth)
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


def model_renderer(scene: Scene) -> vtkRenderer:
    """Return the lit model."""
    renderer = vtkRenderer()
    renderer.AutomaticLightCreationOff()
    for place, strength in LIGHTS:
        light = vtkLight()
        light.SetLightTypeToCameraLight()
        light.SetPosition(*place)
        light.SetIntensity(strength)
        renderer.AddLight(light)

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


def dimming(scene: Scene, camera: vtkCamera, width: int, height: int) -> Array:
    """Return (h, w) factors from 0 to 1 that darken folds and corners.

    The kernel of the pass blurs them, so they need no finer pixels than the picture: at those of
    the model they would take most of the time of it all.
    """
    renderer = faces_renderer(scene)
    if not renderer.GetActors().GetNumberOfItems():
        return np.ones((height, width), dtype=np.float32)
    reach = OCCLUSION * float(np.linalg.norm(np.ptp(scene["points"], axis=0)))
    occlusion = vtkSSAOPass()
    occlusion.SetRadius(reach)
    occlusion.SetBias(OCCLUSION_BIAS * reach)
    occlusion.SetKernelSize(OCCLUSION_RAYS)
    occlusion.BlurOn()
    occlusion.SetDelegatePass(vtkRenderStepsPass())
    renderer.SetPass(occlusion)
    white, covered = photograph(renderer, camera, width, height, 1)
    return np.asarray(np.where(covered > 0, white[..., 0], 1.0))


def faces_renderer(scene: Scene) -> vtkRenderer:
    """Return the opaque faces, all of them white."""
    renderer = vtkRenderer()
    opaque = scene["triangle_colors"][:, 3] == 255
    if opaque.any():
        actor = actor_of(mesh(scene["points"], scene["triangles"][opaque]))
        actor.GetProperty().SetAmbient(1.0)  # not without lighting: that switches occlusion off
        actor.GetProperty().SetDiffuse(0.0)
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


def blurred(picture: Array, deviation: float) -> Array:
    """Return an (h, w) picture smoothed by a Gaussian of a standard deviation in pixels."""
    smooth = vtkImageGaussianSmooth()
    smooth.SetInputData(image_of(picture.astype(np.float32)[..., None]))
    smooth.SetDimensionality(2)
    smooth.SetStandardDeviation(deviation)
    smooth.SetRadiusFactor(4.0)
    smooth.Update()
    return from_vtk(smooth.GetOutput().GetPointData().GetScalars()).reshape(picture.shape)


def image_of(picture: Array) -> vtkImageData:
    """Return an (h, w, channels) picture as VTK holds it, in the same order of rows."""
    height, width, channels = picture.shape
    image = vtkImageData()
    image.SetDimensions(width, height, 1)
    image.GetPointData().SetScalars(to_vtk(picture.reshape(-1, channels), deep=True))
    return image


def png(picture: Array) -> bytes:
    """Return an (h, w, 3) uint8 picture as the bytes of a PNG file."""
    writer = vtkPNGWriter()
    writer.WriteToMemoryOn()
    writer.SetInputData(image_of(picture[::-1]))
    writer.Write()
    return from_vtk(writer.GetResult()).tobytes()


def main() -> None:
    """Draw the scenes that the command line names."""
    for name in sys.argv[1:]:
        with np.load(name) as arrays:
            picture = draw(dict(arrays))
        Path(name).with_suffix(".png").write_bytes(picture)
        print(name, flush=True)
