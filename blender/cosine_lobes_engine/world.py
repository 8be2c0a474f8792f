"""The world: light from all around, and what the camera sees behind everything."""

import math
from dataclasses import dataclass, replace
from typing import Optional

import numpy as np

from . import images

#: Columns of a sky's picture beyond which it is made smaller: the engine looks at patches of 256 texels.
WIDEST = 2048


@dataclass(frozen=True)
class Sky:
    """Its colour, which multiplies the image if there is one."""

    color: tuple = (0.0, 0.0, 0.0)
    image: Optional[str] = None
    # How far the image is turned about z, in radians.
    turn: float = 0.0

    @property
    def shines(self):
        return any(self.color)


def read(world, notes):
    """The sky of a world."""
    if world is None:
        return Sky()
    tree = world.node_tree
    if tree is None:
        return Sky(tuple(world.color))
    output = tree.get_output_node("ALL") or tree.get_output_node("CYCLES")
    link = output and _link(output.inputs["Surface"])
    if not link:
        return Sky()
    if output.inputs["Volume"].is_linked:
        notes.add(world.name, "volumes are not supported")
    if link.from_node.bl_idname != "ShaderNodeBackground":
        notes.add(world.name, f"node \"{link.from_node.name}\" is not supported: the world is black")
        return Sky()
    return _background(world, link.from_node, notes)


def _link(socket):
    return socket.links[0] if socket.is_linked else None


def _background(world, node, notes):
    color, strength = node.inputs["Color"], node.inputs["Strength"]
    if strength.is_linked:
        notes.add(world.name, f"a link to Strength is not read: {strength.default_value:g} stands")
    factor = max(float(strength.default_value), 0.0)
    link = _link(color)
    if link is None:
        return Sky(tuple(max(float(c), 0.0) * factor for c in color.default_value[:3]))
    node = link.from_node
    if node.bl_idname == "ShaderNodeRGB":
        return Sky(tuple(float(c) * factor for c in link.from_socket.default_value[:3]))
    if node.bl_idname != "ShaderNodeTexEnvironment" or node.image is None:
        notes.add(world.name, f"node \"{node.name}\" is not read: the world is black")
        return Sky()
    if node.projection != "EQUIRECTANGULAR":
        notes.add(world.name, "a mirror ball is taken as latitude and longitude")
    return _placed(world, node, Sky((factor,) * 3, node.image.name), notes)


def _placed(world, node, sky, notes):
    """The turn by a mapping node."""
    link = _link(node.inputs["Vector"])
    if link is None or link.from_node.bl_idname == "ShaderNodeTexCoord":
        return sky
    if link.from_node.bl_idname != "ShaderNodeMapping":
        notes.add(world.name, f"node \"{link.from_node.name}\" is not read: the picture is not turned")
        return sky
    mapping = link.from_node
    x, y, z = mapping.inputs["Rotation"].default_value
    if x or y:
        notes.add(world.name, "a mapping that turns about x or y is not read")
    if tuple(mapping.inputs["Scale"].default_value) != (1, 1, 1):
        notes.add(world.name, "the scale of a mapping is not read")
    return replace(sky, turn=float(-z if mapping.vector_type == "TEXTURE" else z))


def texels(image, notes):
    """Linear radiance of a picture of latitude and longitude, the top row first; none where the file is missing."""
    pixels = images.floats(image)
    if pixels is None:
        notes.add(image.name, "the image has no pixels: its file may be missing")
        return None
    rgb = pixels[..., :3] if pixels.shape[2] >= 3 else np.repeat(pixels[..., :1], 3, axis=2)
    if not image.is_float and image.colorspace_settings.name == "sRGB":
        rgb = images._decode(rgb)
    step = math.ceil(rgb.shape[1] / WIDEST)
    if step > 1:
        height, width = (side // step * step for side in rgb.shape[:2])
        rgb = rgb[:height, :width].reshape(height // step, step, width // step, step, 3).mean(axis=(1, 3))
    return np.ascontiguousarray(np.maximum(rgb, 0), dtype=np.float32)


def environment(cl, sky, picture):
    """The engine's environment; none where it is dark."""
    if not sky.shines:
        return None
    if picture is None:
        return cl.Environment(sky.color, up=(0, 0, 1))
    # The middle of Blender's pictures is toward +x, of the engine's, with z up, toward +y.
    return cl.Environment(picture, strength=sky.color, up=(0, 0, 1), turn=-90 - math.degrees(sky.turn))


def behind(sky, picture, view):
    """The radiance that each pixel of a view would show without surfaces, `(height, width, 3)` or one colour."""
    if picture is None or not sky.shines:
        return np.float32(sky.color)
    toward = view.directions()
    azimuth = np.arctan2(toward[..., 1], toward[..., 0]) + sky.turn
    u = (0.5 - azimuth / (2 * math.pi)) % 1.0
    v = np.arccos(np.clip(toward[..., 2] / np.linalg.norm(toward, axis=2), -1, 1)) / math.pi
    return np.float32(sky.color) * _bilinear(picture, u, v)


def _bilinear(picture, u, v):
    rows, columns = picture.shape[:2]
    x, y = u * columns - 0.5, np.clip(v * rows - 0.5, 0, rows - 1)
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    s, t = (x - left)[..., None].astype(np.float32), (y - top)[..., None].astype(np.float32)
    below = np.minimum(top + 1, rows - 1)
    near, far = left % columns, (left + 1) % columns
    upper = picture[top, near] * (1 - s) + picture[top, far] * s
    lower = picture[below, near] * (1 - s) + picture[below, far] * s
    return upper * (1 - t) + lower * t
