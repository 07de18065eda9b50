"""VTK's windows as arrays, for the drawing program."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from vtkmodules.util import numpy_support
from vtkmodules.vtkRenderingCore import (
    vtkCamera,
    vtkRenderer,
    vtkRenderWindow,
    vtkWindowToImageFilter,
)

Array = NDArray[Any]
Scene = Mapping[str, Array]

from_vtk: Callable[[Any], Array] = numpy_support.vtk_to_numpy
to_vtk: Callable[..., Any] = numpy_support.numpy_to_vtk
to_vtk_ids: Callable[..., Any] = numpy_support.numpy_to_vtkIdTypeArray


def photograph(
    renderer: vtkRenderer, camera: vtkCamera, width: int, height: int, fine: int
) -> tuple[Array, Array]:
    """Return colours (h, w, 3) over black and coverage (h, w), from 0 to 1, top row first.

    Each pixel is the mean of `fine` x `fine` drawn ones.
    """
    renderer.SetBackground(0.0, 0.0, 0.0)
    renderer.SetBackgroundAlpha(0.0)
    window = _window(renderer, camera, width * fine, height * fine)
    values = _grabbed(window, lambda grab: grab.SetInputBufferTypeToRGBA())
    drawn = values.reshape(height, fine, width, fine, 4)[::-1]
    image = sum(
        (drawn[:, i, :, j] for i in range(fine) for j in range(fine)),
        start=np.zeros((height, width, 4), dtype=np.uint16),
    ) * np.float32(1 / (255 * fine * fine))
    return image[..., :3], image[..., 3]


def depths(renderer: vtkRenderer, camera: vtkCamera, width: int, height: int) -> Array:
    """Return (h, w) how deep what is seen lies, from 0 (nearest) to 1, top row first."""
    window = _window(renderer, camera, width, height)
    values = _grabbed(window, lambda grab: grab.SetInputBufferTypeToZBuffer())
    return values.reshape(height, width)[::-1]


def _window(renderer: vtkRenderer, camera: vtkCamera, width: int, height: int) -> vtkRenderWindow:
    renderer.SetActiveCamera(camera)
    renderer.ResetCameraClippingRange()
    window = vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetAlphaBitPlanes(True)
    window.SetMultiSamples(0)
    window.SetSize(width, height)
    window.AddRenderer(renderer)
    window.Render()
    return window


def _grabbed(window: vtkRenderWindow, choose: Callable[[Any], None]) -> Array:
    grab = vtkWindowToImageFilter()
    grab.SetInput(window)
    choose(grab)
    grab.ReadFrontBufferOff()
    grab.ShouldRerenderOff()  # it is drawn already
    grab.Update()
    return from_vtk(grab.GetOutput().GetPointData().GetScalars())
