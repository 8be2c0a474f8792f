"""Lights in Blender's units.

A lamp of P watts has the intensity P/4π in all directions, an area light of area A the radiance P/(πA), a sun of strength E the irradiance E. With
`normalize` off, P is π times the radiance instead, and of suns the radiance. All are multiplied by colour, temperature and 2^exposure.
"""

import math

import numpy as np

#: A lamp without a size has this radius, so small that its shadows have no visible penumbra.
SMALLEST = 1e-3
#: A sun without an angle, in degrees.
NARROWEST = 0.01


def color(light):
    """Colour times temperature times 2^exposure."""
    value = np.array(light.color, dtype=np.float64)
    if getattr(light, "use_temperature", False):
        value = value * np.array(light.temperature_color, dtype=np.float64)
    return value * 2.0 ** getattr(light, "exposure", 0.0)


def is_normalized(light):
    return getattr(light, "normalize", True)


def convert(light, matrix, notes):
    """The engine's light of an evaluated light at a matrix to the world, as a recipe: a name of a constructor, its arguments, and the size of the
    body that the camera sees; none where it gives no light."""
    _note(light, notes)
    strength = color(light) * light.energy
    if (strength < 0).any():
        notes.add(light.name, "negative light is not supported: it is left out")
        return None
    if not (strength > 0).any():
        return None
    matrix = np.asarray(matrix, dtype=np.float64)
    make = {"POINT": _lamp, "SPOT": _lamp, "SUN": _sun, "AREA": _area}[light.type]
    return make(light, matrix, strength, notes)


def _note(light, notes):
    tree = light.node_tree if light.use_nodes else None
    if tree and not _is_plain(tree):
        notes.add(light.name, "its shader nodes are not read: strength and colour of its settings stand")
    if not light.use_shadow:
        notes.add(light.name, "it casts shadows all the same")
    for name in ("diffuse_factor", "specular_factor"):
        if getattr(light, name, 1.0) != 1.0:
            notes.add(light.name, f"its {name} is taken as 1")


def _is_plain(tree):
    """Whether the nodes are those of a new light: an emission of white and strength 1."""
    for node in tree.nodes:
        if node.bl_idname == "ShaderNodeEmission":
            color, strength = node.inputs["Color"], node.inputs["Strength"]
            if color.is_linked or strength.is_linked or tuple(color.default_value)[:3] != (1, 1, 1) or strength.default_value != 1:
                return False
        elif node.bl_idname not in ("ShaderNodeOutputLight", "NodeReroute", "NodeFrame"):
            return False
    return True


def _plain(values):
    return tuple(float(v) for v in values)


def _lamp(light, matrix, strength, notes):
    radius = max(light.shadow_soft_size, SMALLEST)
    intensity = strength / (4 * math.pi)
    if not is_normalized(light):
        # Radiance P/π; without a size the square of the radius is what Blender takes as 1.
        intensity = strength * (radius * radius if light.shadow_soft_size > 0 else 1.0)
    arguments = {
        "center": _plain(matrix[:3, 3]),
        "intensity": _plain(intensity),
        "radius": float(radius),
        "facing": bool(getattr(light, "use_soft_falloff", False)),
    }
    if light.type == "SPOT":
        scale = np.linalg.norm(matrix[:3, :3], axis=0)
        if scale.max() > 1.001 * scale.min():
            notes.add(light.name, "the cone of a scaled spot is taken as round")
        arguments |= {
            "direction": _plain(-matrix[:3, 2] / scale[2]),
            "angle": math.degrees(light.spot_size) / 2,
            "blend": float(light.spot_blend),
        }
    return "lamp", arguments


def _sun(light, matrix, strength, notes):
    half = light.angle / 2
    if half > math.radians(60):
        notes.add(light.name, "a sun of more than 120° is taken as 120°")
        half = math.radians(60)
    arguments = {"direction": _plain(-matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])), "angle": max(2 * math.degrees(half), NARROWEST)}
    if is_normalized(light) or light.angle == 0:
        return "sun", arguments | {"irradiance": _plain(strength)}
    return "sun", arguments | {"irradiance": _plain(strength * math.pi * math.sin(half) ** 2)}


def _area(light, matrix, strength, notes):
    if light.spread < math.pi - 1e-3:
        notes.add(light.name, f"its spread of {math.degrees(light.spread):.0f}° is not supported: it shines to all of its front")
    is_round = light.shape in ("DISK", "ELLIPSE")
    size_y = light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size
    u, v = matrix[:3, 0] * light.size / 2, matrix[:3, 1] * size_y / 2
    area = np.linalg.norm(np.cross(u, v)) * (math.pi if is_round else 4)
    if area <= 0:
        notes.add(light.name, "a light without an area is left out")
        return None
    radiance = _plain(strength / math.pi / (area if is_normalized(light) else 1))
    center, lengths = matrix[:3, 3], [np.linalg.norm(u), np.linalg.norm(v)]
    if np.linalg.det(matrix[:3, :3]) < 0:
        # Mirrored: u × v is −z.
        u, v = v, u
    is_square = abs(np.dot(u, v)) <= 1e-5 * lengths[0] * lengths[1]
    if is_round and is_square and abs(lengths[0] - lengths[1]) <= 1e-6 * lengths[0]:
        normal = -np.cross(u, v)
        arguments = {"center": _plain(center), "normal": _plain(normal / np.linalg.norm(normal)), "radius": float(lengths[0])}
        return "disc", arguments | {"radiance": radiance}
    if not is_round and is_square:
        # It shines along −z, which is v × u.
        return "rectangle", {"center": _plain(center), "u": _plain(v), "v": _plain(u), "radiance": radiance}
    return "polygon", {"corners": _corners(center, u, v, is_round), "radiance": radiance}


def _corners(center, u, v, is_round, sides=24):
    """The corners, against the clock as seen from the side that it shines to."""
    if not is_round:
        signs = [(-1, -1), (-1, 1), (1, 1), (1, -1)]
        return tuple(_plain(center + a * u + b * v) for a, b in signs)
    # As large as the ellipse.
    grow = math.sqrt((2 * math.pi / sides) / math.sin(2 * math.pi / sides))
    angles = [-2 * math.pi * k / sides for k in range(sides)]
    return tuple(_plain(center + grow * (math.cos(a) * u + math.sin(a) * v)) for a in angles)


def made(cl, recipe):
    """The engine's light of a recipe."""
    kind, arguments = recipe
    arguments = dict(arguments)
    if kind == "rectangle":
        return cl.Light.rectangle(arguments.pop("center"), arguments.pop("u"), arguments.pop("v"), **arguments)
    if kind == "disc":
        return cl.Light.disc(arguments.pop("center"), arguments.pop("normal"), arguments.pop("radius"), **arguments)
    if kind == "polygon":
        return cl.Light.polygon(np.array(arguments.pop("corners"), dtype=np.float64), **arguments)
    if kind == "sun":
        return cl.Light.sun(arguments.pop("direction"), **arguments)
    return cl.Light.lamp(arguments.pop("center"), **arguments)
