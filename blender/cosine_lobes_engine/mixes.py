"""Colours and numbers that nodes mix of images and constants: read as expressions, and evaluated texel by texel.

An expression is a tuple that can be compared: `("image", name, channel)`, `("value", number or colour)`, or the name of an operation, its options, and the
expressions of its inputs.
"""

import numpy as np

from . import images

#: Rec. 709's luminance.
_GREY = np.float32([0.2126, 0.7152, 0.0722])
#: Places at which a ramp is read.
_STEPS = 1024


class Unread(Exception):
    """A node has no expression; its argument is the node."""


def _lerp(a, b, t):
    return a + (b - a) * t


def _overlay(a, b, t):
    return np.where(a < 0.5, a * (1 - t + 2 * t * b), 1 - (1 - t + 2 * t * (1 - b)) * (1 - a))


def _divide(a, b, t):
    return np.where(b != 0, _lerp(a, a / np.where(b != 0, b, 1), t), a)


def _soft(a, b, t):
    screen = 1 - (1 - b) * (1 - a)
    return _lerp(a, (1 - a) * b * a + a * screen, t)


#: How Blender's nodes mix a with b by the factor t.
BLENDS = {
    "MIX": _lerp,
    "ADD": lambda a, b, t: a + b * t,
    "MULTIPLY": lambda a, b, t: a * _lerp(1, b, t),
    "SUBTRACT": lambda a, b, t: a - b * t,
    "DIVIDE": _divide,
    "SCREEN": lambda a, b, t: 1 - (1 - t + t * (1 - b)) * (1 - a),
    "DIFFERENCE": lambda a, b, t: _lerp(a, np.abs(a - b), t),
    "DARKEN": lambda a, b, t: _lerp(a, np.minimum(a, b), t),
    "LIGHTEN": lambda a, b, t: _lerp(a, np.maximum(a, b), t),
    "OVERLAY": _overlay,
    "SOFT_LIGHT": _soft,
    "LINEAR_LIGHT": lambda a, b, t: a + t * (2 * b - 1),
}


def _power(a, b):
    # Of negative numbers to whole powers alone, as Blender.
    is_whole = b == np.floor(b)
    return np.where((a >= 0) | is_whole, np.power(np.where(is_whole, a, np.abs(a)), b), 0)


#: Operations of the node Math, of up to three numbers.
MATHS = {
    "ADD": lambda a, b, c: a + b,
    "SUBTRACT": lambda a, b, c: a - b,
    "MULTIPLY": lambda a, b, c: a * b,
    "DIVIDE": lambda a, b, c: np.where(b != 0, a / np.where(b != 0, b, 1), 0),
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "POWER": lambda a, b, c: _power(a, b),
    "SQRT": lambda a, b, c: np.sqrt(np.maximum(a, 0)),
    "ABSOLUTE": lambda a, b, c: np.abs(a),
    "MINIMUM": lambda a, b, c: np.minimum(a, b),
    "MAXIMUM": lambda a, b, c: np.maximum(a, b),
    "LESS_THAN": lambda a, b, c: np.where(a < b, 1.0, 0.0),
    "GREATER_THAN": lambda a, b, c: np.where(a > b, 1.0, 0.0),
    "ROUND": lambda a, b, c: np.floor(a + 0.5),
    "FLOOR": lambda a, b, c: np.floor(a),
    "FRACT": lambda a, b, c: a - np.floor(a),
}


def _hue(color, hue, saturation, value, factor):
    """Turns the hue, and multiplies saturation and value, of HSV."""
    most, least = color.max(axis=-1), color.min(axis=-1)
    span = most - least
    safe = np.where(span > 0, span, 1)
    r, g, b = ((most - color[..., k]) / safe for k in range(3))
    turn = np.where(most == color[..., 0], b - g, np.where(most == color[..., 1], 2 + r - b, 4 + g - r)) / 6
    h = np.where(span > 0, turn, 0) + hue[..., 0] + 0.5
    s = np.clip(np.where(most > 0, span / np.where(most > 0, most, 1), 0) * saturation[..., 0], 0, 1)
    v = most * value[..., 0]
    rgb = np.clip(np.abs((h[..., None] + np.float32([0, 2, 1]) / 3) % 1 * 6 - 3) - 1, 0, 1)
    new = v[..., None] * (1 - s[..., None] + s[..., None] * rgb)
    return np.maximum(_lerp(color, new, factor), 0)


def _contrast(color, bright, contrast):
    return np.maximum(color * (1 + contrast) + bright - 0.5 * contrast, 0)


def _ramp(factor, table, is_stepped):
    at = np.clip(factor[..., 0], 0, 1) * _STEPS
    table = np.float32(table)
    if is_stepped:
        return table[np.floor(at).astype(int)]
    low = np.minimum(np.floor(at).astype(int), _STEPS - 1)
    return _lerp(table[low], table[low + 1], (at - low)[..., None])


def _range(value, low, high, to_low, to_high, is_clamped):
    part = np.where(high != low, (value - low) / np.where(high != low, high - low, 1), 0)
    return _lerp(to_low, to_high, np.clip(part, 0, 1) if is_clamped else part)


def _grey(color):
    return color if color.shape[-1] == 1 else (color @ _GREY)[..., None]


def _rgb(value):
    return np.broadcast_to(value, (*value.shape[:-1], 3)) if value.shape[-1] == 1 else value


def _invert(color, factor):
    return _lerp(color, 1 - color, factor)


def _gamma(color, gamma):
    return np.where(color > 0, np.power(np.maximum(color, 1e-30), gamma), color)


#: Operations by name, of options and arrays `(height, width, 1 or 3)`.
_OPERATIONS = {
    "grey": lambda options, a: _grey(a),
    "color": lambda options, a: _rgb(a),
    "channel": lambda options, a: a[..., options[0] : options[0] + 1],
    "joined": lambda options, *parts: np.concatenate(np.broadcast_arrays(*parts), axis=-1),
    "clamp": lambda options, a: np.clip(a, 0, 1),
    "blend": lambda options, t, a, b: BLENDS[options[0]](a, b, t),
    "math": lambda options, *abc: MATHS[options[0]](*abc),
    "invert": lambda options, t, a: _invert(a, t),
    "gamma": lambda options, a, g: _gamma(a, g),
    "contrast": lambda options, *given: _contrast(*given),
    "hue": lambda options, *given: _hue(*given),
    "ramp": lambda options, a: _ramp(a, *options),
    "range": lambda options, *given: _range(*given, *options),
    "between": lambda options, a, low, high: np.minimum(np.maximum(a, low), high),
}


def names(expression):
    """The names of the images of an expression."""
    if expression[0] == "image":
        return frozenset((expression[1],))
    if expression[0] == "value":
        return frozenset()
    return frozenset().union(*(names(inner) for inner in expression[2:]))


def evaluate(expression, linear):
    """The array of an expression, `(height, width, 1 or 3)`. `linear(name, channel)` gives the values of images."""
    wanted = {}
    _gather(expression, linear, wanted)
    height, width = (max((a.shape[k] for a in wanted.values()), default=1) for k in (0, 1))
    given = {key: _resized(array, height, width) for key, array in wanted.items()}
    return np.float32(_value(expression, given))


def _gather(expression, linear, wanted):
    if expression[0] == "image":
        if expression[1:] not in wanted:
            wanted[expression[1:]] = linear(*expression[1:])
    elif expression[0] != "value":
        for inner in expression[2:]:
            _gather(inner, linear, wanted)


def _resized(array, height, width):
    """By the nearest texel."""
    rows, columns = ((np.arange(n) * m) // n for n, m in ((height, array.shape[0]), (width, array.shape[1])))
    return array[rows][:, columns]


def _value(expression, given):
    kind = expression[0]
    if kind == "image":
        return given[expression[1:]]
    if kind == "value":
        return np.float32(expression[1]).reshape(1, 1, -1)
    return _OPERATIONS[kind](expression[1], *(_value(inner, given) for inner in expression[2:]))


class Reader:
    """Reads the expression behind sockets. `behind(socket)` is the socket that a linked one comes from, `picture(source)` the image as a plain
    texture, if it is one."""

    def __init__(self, behind, picture):
        self._behind, self._picture = behind, picture
        #: Pictures that were met.
        self.pictures = []

    def _input(self, socket, is_color):
        """An input as a colour or a number."""
        source = self._behind(socket)
        if source is None:
            value = socket.default_value
            value = tuple(float(x) for x in value)[:3] if hasattr(value, "__len__") else (float(value),)
            inner = ("value", value)
        else:
            inner = self.output(source)
        return ("color" if is_color else "grey", (), inner)

    def output(self, source):
        """What a socket gives."""
        node = source.node
        picture = self._picture(source)
        if picture is not None:
            self.pictures.append(picture)
            return ("image", picture.image, picture.channel)
        read = getattr(self, f"_{node.bl_idname[len('ShaderNode'):]}", None)
        if read is None:
            raise Unread(node)
        return read(node, source)

    def _color(self, socket):
        return self._input(socket, True)

    def _number(self, socket):
        return self._input(socket, False)

    def _RGB(self, node, source):
        return ("value", tuple(float(x) for x in source.default_value)[:3])

    def _Value(self, node, source):
        return ("value", (float(source.default_value),))

    def _RGBToBW(self, node, source):
        return ("grey", (), self._color(node.inputs[0]))

    def _Invert(self, node, source):
        return ("invert", (), self._number(node.inputs[0]), self._color(node.inputs[1]))

    def _Gamma(self, node, source):
        return ("gamma", (), self._color(node.inputs[0]), self._number(node.inputs[1]))

    def _BrightContrast(self, node, source):
        return ("contrast", (), self._color(node.inputs[0]), self._number(node.inputs[1]), self._number(node.inputs[2]))

    def _HueSaturation(self, node, source):
        numbers = (self._number(node.inputs[name]) for name in ("Hue", "Saturation", "Value", "Fac"))
        return ("hue", (), self._color(node.inputs["Color"]), *numbers)

    def _Math(self, node, source):
        if node.operation not in MATHS:
            raise Unread(node)
        made = ("math", (node.operation,), *(self._number(socket) for socket in list(node.inputs)[:3]))
        return ("clamp", (), made) if node.use_clamp else made

    def _MixRGB(self, node, source):
        return self._blend(node, node.inputs[0], node.inputs[1:3], node.use_clamp, True)

    def _Mix(self, node, source):
        if node.data_type not in ("FLOAT", "RGBA") or node.factor_mode != "UNIFORM":
            raise Unread(node)
        kind = node.data_type
        sockets = [socket for socket in node.inputs if socket.identifier in (f"A_{'Color' if kind == 'RGBA' else 'Float'}", f"B_{'Color' if kind == 'RGBA' else 'Float'}")]
        factor = next(socket for socket in node.inputs if socket.identifier == "Factor_Float")
        if kind == "RGBA":
            return self._blend(node, factor, sockets, node.clamp_result, node.clamp_factor)
        t = self._number(factor)
        return ("blend", ("MIX",), ("clamp", (), t) if node.clamp_factor else t, *(self._number(socket) for socket in sockets))

    def _blend(self, node, factor, colors, is_clamped, is_factor_clamped):
        if node.blend_type not in BLENDS:
            raise Unread(node)
        t = self._number(factor)
        t = ("clamp", (), t) if is_factor_clamped else t
        made = ("blend", (node.blend_type,), t, *(self._color(socket) for socket in colors))
        return ("clamp", (), made) if is_clamped else made

    def _ValToRGB(self, node, source):
        if source.identifier != "Color":
            raise Unread(node)
        ramp = node.color_ramp
        table = tuple(tuple(ramp.evaluate(k / _STEPS))[:3] for k in range(_STEPS + 1))
        return ("ramp", (table, ramp.interpolation == "CONSTANT"), self._number(node.inputs[0]))

    def _Clamp(self, node, source):
        if node.clamp_type != "MINMAX":
            raise Unread(node)
        return ("between", (), *(self._number(socket) for socket in list(node.inputs)[:3]))

    def _MapRange(self, node, source):
        if node.data_type != "FLOAT" or node.interpolation_type != "LINEAR":
            raise Unread(node)
        numbers = (self._number(node.inputs[name]) for name in ("Value", "From Min", "From Max", "To Min", "To Max"))
        return ("range", (bool(node.clamp),), *numbers)

    def _SeparateColor(self, node, source):
        if node.mode != "RGB":
            raise Unread(node)
        channel = [socket.identifier for socket in node.outputs].index(source.identifier)
        return ("channel", (channel,), self._color(node.inputs[0]))

    def _CombineColor(self, node, source):
        if node.mode != "RGB":
            raise Unread(node)
        return ("joined", (), *(self._number(socket) for socket in list(node.inputs)[:3]))


def linear(image, channel):
    """The linear values of an image of Blender's, the upper row first, `(height, width, 1 or 3)`; black where it has no pixels."""
    pixels = images.floats(image)
    if pixels is None:
        return np.zeros((1, 1, 3 if channel is None else 1), np.float32)
    if channel == 3:
        return pixels[..., 3:4] if pixels.shape[2] == 4 else np.ones((*pixels.shape[:2], 1), np.float32)
    values = images._rgb(pixels)
    if images._space(image)[0]:
        values = images._decode(values).astype(np.float32)
    return values if channel is None else values[..., channel : channel + 1]
