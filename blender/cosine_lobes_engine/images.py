"""Blender's images as arrays of bytes, the upper row first."""

import numpy as np


def _encode(linear):
    """sRGB's curve."""
    linear = np.clip(linear, 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def _decode(value):
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def floats(image):
    """All channels as Blender holds them, `(height, width, channels)`; none where the file is missing."""
    width, height = image.size
    if not width or not height:
        return None
    pixels = np.empty(width * height * image.channels, dtype=np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(height, width, image.channels)[::-1]


def _space(image):
    """Whether the values are encoded by sRGB's curve; those of images with floats are linear."""
    name = image.colorspace_settings.name
    return name == "sRGB" and not image.is_float, name in ("sRGB", "Non-Color", "Linear Rec.709")


def _bytes(values):
    return np.ascontiguousarray(np.clip(np.rint(values * 255), 0, 255).astype(np.uint8))


def _rgb(pixels):
    return pixels[..., :3] if pixels.shape[2] >= 3 else np.repeat(pixels[..., :1], 3, axis=2)


def color(image, notes):
    """Colours, encoded by sRGB's curve, `(height, width, 3)`."""
    pixels = floats(image)
    if pixels is None:
        return None
    is_encoded, is_known = _space(image)
    if not is_known:
        notes.add(image.name, f"its colour space {image.colorspace_settings.name} is taken as linear")
    values = _rgb(pixels)
    if not is_encoded:
        if values.max(initial=0) > 1:
            notes.add(image.name, "values above 1 are cut")
        values = _encode(values)
    return _bytes(values)


def number(image, channel):
    """One channel as numbers, `(height, width)`: 0 to 2 red, green, blue, 3 alpha, None the colour's luminance."""
    pixels = floats(image)
    if pixels is None:
        return None
    if channel == 3:
        return _bytes(pixels[..., 3]) if pixels.shape[2] == 4 else np.full(pixels.shape[:2], 255, np.uint8)
    values = _rgb(pixels)
    if _space(image)[0]:
        values = _decode(values)
    values = values @ np.float32([0.2126, 0.7152, 0.0722]) if channel is None else values[..., channel]
    return _bytes(values)


def normal(image, notes):
    """A normal map in tangent space, `(height, width, 3)`."""
    pixels = floats(image)
    if pixels is None:
        return None
    if _space(image)[0]:
        notes.add(image.name, "is a normal map and has the colour space sRGB: set it to Non-Color")
        return _bytes(_decode(_rgb(pixels)))
    return _bytes(_rgb(pixels))
