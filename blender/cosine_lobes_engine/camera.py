"""Cameras: the frame of square pixels around the principal point, and the window of it that is the picture.

The engine's camera looks at the middle of its frame. A shifted camera, a view that is zoomed into and a part of a panorama are windows of
a larger frame, of which nothing else is rendered.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from .notes import Refused

LARGEST = 16384


@dataclass(frozen=True)
class View:
    """Where the camera is, and its picture: all that decides which point a pixel shows."""

    eye: tuple
    forward: tuple
    up: tuple
    # "perspective", "orthographic" or "panoramic".
    projection: str
    # Of the frame: the full vertical field of view in degrees, or the height in units; none of a panorama.
    extent: float | None
    # Of the frame, in pixels.
    frame: tuple
    # Of the picture in the frame: left column, upper row, width, height.
    window: tuple

    @property
    def place(self):
        """All that the engine's camera depends on."""
        return (self.eye, self.forward, self.up, self.projection, self.extent)

    def camera(self, cl):
        """The camera of the engine."""
        # Far enough that the difference of target and eye keeps its digits.
        reach = max(1.0, *(abs(x) for x in self.eye))
        target = tuple(e + reach * f for e, f in zip(self.eye, self.forward))
        number = {"perspective": {"fov": self.extent}, "orthographic": {"height": self.extent}}.get(self.projection, {})
        return cl.Camera(self.eye, target, up=self.up, projection=self.projection, **number)

    def directions(self):
        """A vector along the ray through the middle of each pixel, of any length: `(height, width, 3)`."""
        x, y, width, height = self.window
        forward, up = np.array(self.forward), np.array(self.up)
        right = np.cross(forward, up)
        right /= np.linalg.norm(right)
        up = np.cross(right, forward)
        across = (np.arange(width) + x + 0.5 - self.frame[0] / 2)[None, :, None]
        down = (np.arange(height) + y + 0.5 - self.frame[1] / 2)[:, None, None]
        if self.projection == "orthographic":
            return np.broadcast_to(forward, (height, width, 3))
        if self.projection == "panoramic":
            longitude, fall = across * (2 * math.pi / self.frame[0]), down * (math.pi / self.frame[1])
            return np.cos(fall) * (np.cos(longitude) * forward + np.sin(longitude) * right) - np.sin(fall) * up
        pitch = 2 * math.tan(math.radians(self.extent) / 2) / self.frame[1]
        return forward + across * pitch * right - down * pitch * up


def _axes(matrix):
    """Position, forward and up of a matrix to the world (4 × 4)."""
    matrix = np.asarray(matrix, dtype=np.float64)
    unit = [matrix[:3, k] / np.linalg.norm(matrix[:3, k]) for k in range(3)]
    return tuple(matrix[:3, 3]), tuple(-unit[2]), tuple(unit[1])


def _fits(frame):
    if max(frame) > LARGEST:
        raise Refused(f"the camera's shift needs a frame of {frame[0]} × {frame[1]} pixels: {LARGEST} are possible")


def around(matrix, projection, pitch, middle, size):
    """The view of a camera with a matrix to the world (4 × 4), whose axis meets the picture at `middle`, in pixels from its upper left
    corner. Its pixels are `pitch` apart, at distance 1 where it is a perspective one. Also how far that point was moved, as only half
    pixels are possible."""
    width, height = size
    twice = [round(2 * m) for m in middle]
    moved = max(abs(t - 2 * m) / 2 for t, m in zip(twice, middle))
    frame = tuple(max(t, 2 * n - t) for t, n in zip(twice, size))
    _fits(frame)
    corner = [(f - t) // 2 for f, t in zip(frame, twice)]
    extent = pitch * frame[1]
    if projection == "perspective":
        extent = math.degrees(2 * math.atan(0.5 * extent))
    return View(*_axes(matrix), projection, extent, frame, (*corner, width, height)), moved


def lens(data, size):
    """Projection, pixel pitch (of a perspective camera at distance 1), and the point of the picture that the axis meets, of a camera's data
    for a picture of `size` pixels."""
    width, height = size
    is_wide = data.sensor_fit == "HORIZONTAL" or (data.sensor_fit == "AUTO" and width >= height)
    fitted = width if is_wide else height
    middle = (0.5 * width - data.shift_x * fitted, 0.5 * height + data.shift_y * fitted)
    if data.type == "ORTHO":
        return "orthographic", data.ortho_scale / fitted, middle
    sensor = data.sensor_height if data.sensor_fit == "VERTICAL" else data.sensor_width
    return "perspective", sensor / (data.lens * fitted), middle


def panorama(data, matrix, size):
    """The view of a panoramic camera: the whole sphere has so many pixels that the picture is a window of it."""
    # Older versions keep these with Cycles.
    own = data if hasattr(data, "panorama_type") else data.cycles
    if own.panorama_type != "EQUIRECTANGULAR":
        kind = own.panorama_type.replace("_", " ").lower()
        raise Refused(f"camera \"{data.name}\" is a panoramic one of type {kind}: only equirectangular ones are supported")
    spans = ((own.longitude_min + math.pi, own.longitude_max + math.pi), (math.pi / 2 - own.latitude_max, math.pi / 2 - own.latitude_min))
    frame, corner = [], []
    for pixels, whole, (first, last) in zip(size, (2 * math.pi, math.pi), spans):
        turns = (last - first) / whole
        if not 0 < turns <= 1 + 1e-6:
            raise Refused(f"camera \"{data.name}\" sees an empty range of longitudes or latitudes, or more than all")
        side = pixels / turns
        left = first / whole * side
        if max(abs(side - round(side)), abs(left - round(left))) > 0.01:
            raise Refused(
                f"camera \"{data.name}\" sees a part of the sphere whose pixels are no whole part of it: "
                f"all of it would have {side:.2f} pixels a side, {left:.2f} of them before the picture"
            )
        frame.append(round(side))
        corner.append(round(left))
    _fits(frame)
    return View(*_axes(matrix), "panoramic", None, tuple(frame), (*corner, *size))


def of_scene(scene, camera, notes):
    """The view of the picture that F12 makes, through an evaluated camera object."""
    render, data = scene.render, camera.data
    scale = render.resolution_percentage / 100
    size = (max(1, int(render.resolution_x * scale)), max(1, int(render.resolution_y * scale)))
    if data.type not in ("PERSP", "ORTHO", "PANO"):
        raise Refused(f"camera \"{data.name}\" is of type {data.type.lower()}, which is not supported")
    if abs(render.pixel_aspect_x - render.pixel_aspect_y) > 1e-4:
        notes.add("Output", f"pixels of {render.pixel_aspect_x:g} : {render.pixel_aspect_y:g} are rendered square")
    if data.dof.use_dof:
        notes.add(data.name, "depth of field is not supported: everything is sharp")
    if data.type == "PANO":
        return panorama(data, camera.matrix_world, size)
    view, moved = around(camera.matrix_world, *lens(data, size), size)
    if moved > 0.01:
        notes.add(data.name, f"the shift is rounded to half a pixel ({moved:.2f} pixels off)")
    return view


def cropped(view, part):
    """The view of a part of a picture: left column, upper row, width, height."""
    x, y, _, _ = view.window
    return replace(view, window=(x + part[0], y + part[1], part[2], part[3]))


def of_viewport(window_matrix, view_matrix, size):
    """The view of a 3D viewport of `size` pixels, from its two matrices."""
    window = np.asarray(window_matrix, dtype=np.float64)
    to_world = np.linalg.inv(np.asarray(view_matrix, dtype=np.float64))
    width, height = size
    # The edges are 2/m00 apart; at distance 1 in perspective.
    pitch = 2 / (window[1, 1] * height)
    if abs(window[3, 3]) > 0.5:
        # Clip x is m00·x + m03. What is between the eye and the near plane is seen, too, where that is behind the eye.
        middle = (0.5 * width * (1 + window[0, 3]), 0.5 * height * (1 - window[1, 3]))
        behind = max(0.0, (-1 - window[2, 3]) / window[2, 2])
        to_world[:3, 3] += behind * to_world[:3, 2] / np.linalg.norm(to_world[:3, 2])
        return around(to_world, "orthographic", pitch, middle, size)[0]
    # Clip x is (m00·x + m02·z)/(−z): the axis meets the picture at −m02.
    middle = (0.5 * width * (1 - window[0, 2]), 0.5 * height * (1 + window[1, 2]))
    return around(to_world, "perspective", pitch, middle, size)[0]
