"""Cameras: the frame of square pixels around the principal point, and the window of it that is the picture.

The engine's camera looks at the middle of its frame. A shifted camera and a view that is zoomed into are windows beside the middle of a
larger frame, of which nothing else is rendered.
"""

import math
from dataclasses import dataclass

import numpy as np

from .notes import Refused

LARGEST = 16384


@dataclass(frozen=True)
class View:
    """Where the camera is, and its picture: all that decides which point a pixel shows."""

    eye: tuple
    forward: tuple
    up: tuple
    # Full vertical field of view of the frame, in degrees.
    fov: float
    # Of the frame, in pixels.
    frame: tuple
    # Of the picture in the frame: left column, upper row, width, height.
    window: tuple

    def camera(self, cl):
        """The camera of the engine."""
        # Far enough that the difference of target and eye keeps its digits.
        reach = max(1.0, *(abs(x) for x in self.eye))
        target = tuple(e + reach * f for e, f in zip(self.eye, self.forward))
        return cl.Camera(self.eye, target, up=self.up, fov=self.fov)


def around(matrix, pitch, middle, size):
    """The view of a camera with a matrix to the world (4 × 4), whose pixels are `pitch` apart at distance 1 and whose axis meets the
    picture at `middle`, in pixels from its upper left corner. Also how far that point was moved, as only half pixels are possible."""
    width, height = size
    twice = [round(2 * m) for m in middle]
    moved = max(abs(t - 2 * m) / 2 for t, m in zip(twice, middle))
    frame = tuple(max(t, 2 * n - t) for t, n in zip(twice, size))
    if max(frame) > LARGEST:
        raise Refused(f"the camera's shift needs a frame of {frame[0]} × {frame[1]} pixels: {LARGEST} are possible")
    corner = [(f - t) // 2 for f, t in zip(frame, twice)]
    fov = math.degrees(2 * math.atan(0.5 * pitch * frame[1]))
    matrix = np.asarray(matrix, dtype=np.float64)
    unit = [matrix[:3, k] / np.linalg.norm(matrix[:3, k]) for k in range(3)]
    view = View(tuple(matrix[:3, 3]), tuple(-unit[2]), tuple(unit[1]), fov, frame, (*corner, width, height))
    return view, moved


def lens(data, size, notes, aspect=(1.0, 1.0)):
    """Pixel pitch at distance 1, and the point of the picture that the axis meets, of a camera's data for a picture of `size` pixels."""
    width, height = size
    if data.type != "PERSP":
        kind = {"ORTHO": "orthographic", "PANO": "panoramic"}.get(data.type, data.type)
        raise Refused(f"camera \"{data.name}\" is {kind}: only perspective cameras are supported")
    if abs(aspect[0] - aspect[1]) > 1e-4:
        notes.add("Output", f"pixels of {aspect[0]:g} : {aspect[1]:g} are rendered square")
    if data.dof.use_dof:
        notes.add(data.name, "depth of field is not supported: everything is sharp")
    is_wide = data.sensor_fit == "HORIZONTAL" or (data.sensor_fit == "AUTO" and width >= height)
    sensor = data.sensor_height if data.sensor_fit == "VERTICAL" else data.sensor_width
    fitted = width if is_wide else height
    middle = (0.5 * width - data.shift_x * fitted, 0.5 * height + data.shift_y * fitted)
    return sensor / (data.lens * fitted), middle


def of_scene(scene, camera, notes):
    """The view of the picture that F12 makes, through an evaluated camera object."""
    render = scene.render
    scale = render.resolution_percentage / 100
    size = (max(1, int(render.resolution_x * scale)), max(1, int(render.resolution_y * scale)))
    pitch, middle = lens(camera.data, size, notes, (render.pixel_aspect_x, render.pixel_aspect_y))
    view, moved = around(camera.matrix_world, pitch, middle, size)
    if moved > 0.01:
        notes.add(camera.data.name, f"the shift is rounded to half a pixel ({moved:.2f} pixels off)")
    return view


def cropped(view, part):
    """The view of a part of a picture: left column, upper row, width, height."""
    x, y, _, _ = view.window
    return View(view.eye, view.forward, view.up, view.fov, view.frame, (x + part[0], y + part[1], part[2], part[3]))


def of_viewport(window_matrix, view_matrix, size):
    """The view of a 3D viewport of `size` pixels, from its two matrices."""
    window = np.asarray(window_matrix, dtype=np.float64)
    if abs(window[3, 3]) > 0.5:
        raise Refused("orthographic views are not supported: press 5 on the number pad for perspective")
    width, height = size
    # Clip x is (m00·x + m02·z)/(−z): the axis meets the picture at −m02, and the edges are 2/m00 apart at distance 1.
    pitch = 2 / (window[1, 1] * height)
    middle = (0.5 * width * (1 - window[0, 2]), 0.5 * height * (1 + window[1, 2]))
    return around(np.linalg.inv(np.asarray(view_matrix, dtype=np.float64)), pitch, middle, size)[0]
