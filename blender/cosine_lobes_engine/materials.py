"""Materials: what the nodes of Blender's say, as far as the engine has it, and a line for all else."""

from dataclasses import dataclass, replace
from typing import Optional

import numpy as np

from . import images, mixes

#: Inputs of Principled that have an effect which is not supported, and the values at which they have none.
_IGNORED = {
    "Diffuse Roughness": 0,
    "Subsurface Weight": 0,
    "Anisotropic": 0,
    "Transmission Weight": 0,
    "Sheen Weight": 0,
    "Thin Film Thickness": 0,
}
#: Nodes that pass a value on.
_THROUGH = {"NodeReroute"}


@dataclass(frozen=True)
class Picture:
    """An image as a node shows it: its name, the channel (None for all), the name of the coordinates ("" for the active ones) and, row by row, the matrix
    (2 × 3) from these to the image's. With a `mix` it is what nodes make of this image and of others that lie alike."""

    image: str
    channel: Optional[int] = None
    layer: str = ""
    place: tuple = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0)
    mix: Optional[tuple] = None

    @property
    def images(self):
        """The names of all of its images."""
        return mixes.names(self.mix) if self.mix else frozenset((self.image,))


@dataclass(frozen=True)
class Look:
    """A material."""

    base: tuple = (0.8, 0.8, 0.8)
    metallic: float = 0.0
    roughness: float = 1.0
    # Refractive index of the dielectric; 1 without a reflection.
    ior: float = 1.0
    # Colour of its reflectance at normal incidence.
    tint: tuple = (1.0, 1.0, 1.0)
    # Whether light that scatters between facets more than once counts.
    scatters: bool = True
    # The clear coat: its weight, roughness, refractive index and colour.
    coat: float = 0.0
    coat_roughness: float = 0.03
    coat_ior: float = 1.5
    coat_tint: tuple = (1.0, 1.0, 1.0)
    emission: tuple = (0.0, 0.0, 0.0)
    color_image: Optional[Picture] = None
    metallic_image: Optional[Picture] = None
    roughness_image: Optional[Picture] = None
    emission_image: Optional[Picture] = None
    normal_image: Optional[Picture] = None
    normal_strength: float = 1.0
    # The image of alpha, and the limit below which the surface is cut away.
    alpha_image: Optional[Picture] = None
    alpha_limit: float = 0.5
    # Alpha without an image hides all of it.
    is_hidden: bool = False

    @property
    def pictures(self):
        own = (self.color_image, self.metallic_image, self.roughness_image, self.emission_image, self.normal_image, self.alpha_image)
        return [picture for picture in own if picture]

    @property
    def layer(self):
        """The name of the coordinates of its images; None without images."""
        return self.pictures[0].layer if self.pictures else None

    @property
    def place(self):
        return self.pictures[0].place if self.pictures else Picture.place

    @property
    def emits(self):
        return any(self.emission) and not self.is_hidden


class _Reader:
    """Reads the inputs of nodes of one material."""

    def __init__(self, material, notes):
        self.name, self.notes = material.name, notes

    def note(self, line):
        self.notes.add(self.name, line)

    def source(self, socket):
        """The socket that a linked input comes from, past reroutes; None where it is not linked."""
        while socket.is_linked:
            link = socket.links[0]
            if link.is_muted or link.from_node.mute:
                self.note(f"a muted node at \"{socket.name}\" is taken as not linked")
                return None
            if link.from_node.bl_idname not in _THROUGH:
                return link.from_socket
            socket = link.from_node.inputs[0]
        return None

    def number(self, node, name, usual=0.0):
        """A number without a texture."""
        socket = node.inputs.get(name)
        if socket is None:
            return usual
        source = self.source(socket)
        if source is None:
            return float(socket.default_value)
        if source.node.bl_idname == "ShaderNodeValue":
            return float(source.default_value)
        value, picture = self.mixed(source, "grey") or (None, None)
        if value is not None and picture is None:
            return value[0]
        self.note(f"\"{name}\" comes from {_called(source.node)}, which is not read: {socket.default_value:g} stands")
        return float(socket.default_value)

    def color(self, node, name):
        """A colour, and the image that it comes from if any."""
        socket = node.inputs[name]
        source = self.source(socket)
        value = tuple(float(x) for x in socket.default_value)[:3]
        if source is None:
            return value, None
        if source.node.bl_idname == "ShaderNodeRGB":
            return tuple(source.default_value)[:3], None
        picture = self.picture(source)
        if picture and picture.channel is None:
            return (1.0, 1.0, 1.0), picture
        mixed = self.mixed(source, "color")
        if mixed:
            return mixed
        self.note(f"\"{name}\" comes from {_called(source.node)}, which is not read: its own colour stands")
        return value, None

    def factor(self, node, name):
        """A number, and the image that it comes from if any."""
        socket = node.inputs[name]
        source = self.source(socket)
        picture = source and self.picture(source)
        if source and not picture:
            picture = (self.mixed(source, "grey") or (None, None))[1]
        return (1.0, picture) if picture else (self.number(node, name), None)

    def mixed(self, source, kind):
        """What nodes mix of constants and images that lie alike, as a "color" or a "grey" number: a value, or white and a picture; None where a node
        is not read."""
        reader = mixes.Reader(self.source, self.picture)
        try:
            mix = (kind, (), reader.output(source))
        except mixes.Unread:
            return None
        if not reader.pictures:
            return tuple(float(x) for x in mixes.evaluate(mix, None).ravel()), None
        first = reader.pictures[0]
        if any((other.layer, other.place) != (first.layer, first.place) for other in reader.pictures):
            return None
        return (1.0, 1.0, 1.0), replace(first, channel=None, mix=mix)

    def picture(self, source):
        """The image behind a socket; None where it is something else."""
        node, channel = source.node, None
        if node.bl_idname in ("ShaderNodeSeparateColor", "ShaderNodeSeparateRGB"):
            if getattr(node, "mode", "RGB") != "RGB":
                return None
            channel = [o.identifier for o in node.outputs].index(source.identifier)
            source = self.source(node.inputs[0])
            node = source and source.node
        if node is None or node.bl_idname != "ShaderNodeTexImage" or node.image is None:
            return None
        if source.identifier == "Alpha":
            channel = 3
        self._note_image(node)
        layer, place = self.coordinates(node)
        return Picture(node.image.name, channel, layer, place)

    def _note_image(self, node):
        name = node.image.name
        if node.image.source not in ("FILE", "GENERATED"):
            self.note(f"image \"{name}\" is of the kind {node.image.source}: its present pixels stand")
        if node.extension != "REPEAT":
            self.note(f"image \"{name}\" is repeated beyond its edge")
        if node.projection != "FLAT":
            self.note(f"image \"{name}\" is projected flat, by the texture coordinates")

    def coordinates(self, node):
        """The name of the texture coordinates, and the matrix from them to the image's."""
        source = self.source(node.inputs["Vector"])
        place = Picture.place
        if source is not None and source.node.bl_idname == "ShaderNodeMapping":
            place = self.mapping(source.node)
            source = self.source(source.node.inputs["Vector"])
        if source is None:
            return "", place
        if source.node.bl_idname == "ShaderNodeUVMap":
            return source.node.uv_map, place
        if source.node.bl_idname == "ShaderNodeTexCoord" and source.identifier == "UV":
            return "", place
        self.note(f"image \"{node.image.name}\" lies by texture coordinates instead of by {_called(source.node)} {source.name}")
        return "", place

    def mapping(self, node):
        if node.vector_type not in ("POINT", "TEXTURE"):
            self.note(f"a mapping of the kind {node.vector_type} is not read")
            return Picture.place
        for name in ("Location", "Rotation", "Scale"):
            if node.inputs[name].is_linked:
                self.note(f"a link to a mapping's {name} is not read")
        location, rotation, scale = (node.inputs[n].default_value for n in ("Location", "Rotation", "Scale"))
        if rotation[0] or rotation[1]:
            self.note("a mapping that turns about x or y is not read")
        c, s = np.cos(rotation[2]), np.sin(rotation[2])
        turned = np.array([[c, -s], [s, c]]) @ np.diag([scale[0], scale[1]])
        matrix = np.vstack([np.hstack([turned, [[location[0]], [location[1]]]]), [0, 0, 1]])
        if node.vector_type == "TEXTURE":
            matrix = np.linalg.inv(matrix)
        return tuple(float(x) for x in matrix[:2].ravel())

    def alpha(self, node, look):
        socket = node.inputs["Alpha"]
        source = self.source(socket)
        if source is None or source.node.bl_idname == "ShaderNodeValue":
            value = self.number(node, "Alpha", 1.0)
            if 0 < value < 1:
                self.note("a part of alpha is not supported: from one half on it is opaque")
            return replace(look, is_hidden=value < 0.5)
        limit, clip = 0.5, source
        if source.node.bl_idname == "ShaderNodeMath" and source.node.operation in ("GREATER_THAN", "ROUND"):
            if source.node.operation == "GREATER_THAN":
                limit = source.node.inputs[1].default_value
            clip = self.source(source.node.inputs[0])
            picture = clip and self.picture(clip)
        else:
            picture = self.picture(clip)
            if picture:
                self.note("alpha is cut at one half where it would blend")
        if not picture:
            self.note(f"alpha comes from {_called(source.node)}, which is not read: it is opaque")
            return look
        return replace(look, alpha_image=picture, alpha_limit=min(max(float(limit), 1e-3), 1.0))

    def normal(self, node, look):
        source = self.source(node.inputs["Normal"])
        if source is None:
            return look
        inner = source.node
        if inner.bl_idname == "ShaderNodeNormalMap" and inner.space == "TANGENT":
            behind = self.source(inner.inputs["Color"])
            picture = behind and self.picture(behind)
            if picture and picture.channel is None:
                return replace(look, normal_image=picture, normal_strength=self.number(inner, "Strength", 1.0))
        self.note(f"the normal comes from {_called(inner)}, which is not read")
        return look


def _called(node):
    return f"node \"{node.label or node.name}\""


def read(material, notes):
    """The look of a material; Blender's grey without one."""
    if material is None:
        return Look()
    reader = _Reader(material, notes)
    tree = material.node_tree
    if tree is None:
        return Look(base=tuple(material.diffuse_color)[:3])
    output = tree.get_output_node("ALL") or tree.get_output_node("CYCLES")
    source = output and reader.source(output.inputs["Surface"])
    if source is None:
        reader.note("has no surface: it is black")
        return Look(base=(0.0, 0.0, 0.0))
    if output.inputs["Displacement"].is_linked:
        reader.note("displacement is not supported")
    if output.inputs["Volume"].is_linked:
        reader.note("volumes are not supported")
    return _surface(reader, source.node)


def _surface(reader, node):
    if node.bl_idname == "ShaderNodeBsdfPrincipled":
        look = _principled(reader, node)
    elif node.bl_idname == "ShaderNodeBsdfDiffuse":
        base, image = reader.color(node, "Color")
        if reader.number(node, "Roughness"):
            reader.note("the roughness of Diffuse BSDF is taken as 0")
        look = reader.normal(node, Look(base=base, color_image=image))
    elif node.bl_idname == "ShaderNodeEmission":
        color, image = reader.color(node, "Color")
        strength = reader.number(node, "Strength")
        look = Look(base=(0.0, 0.0, 0.0), emission=tuple(c * strength for c in color), emission_image=image)
    else:
        reader.note(f"{_called(node)} is not supported: it is grey")
        look = Look()
    return _on_one_place(reader, look)


def _principled(reader, node):
    base, color_image = reader.color(node, "Base Color")
    metallic, metallic_image = reader.factor(node, "Metallic")
    roughness, roughness_image = reader.factor(node, "Roughness")
    emission, emission_image = reader.color(node, "Emission Color")
    strength = reader.number(node, "Emission Strength")
    if strength == 0:
        emission_image = None
    for name, none in _IGNORED.items():
        socket = node.inputs.get(name)
        if socket is not None and (socket.is_linked or abs(socket.default_value - none) > 1e-6):
            reader.note(f"\"{name}\" is not supported")
    tint, tint_image = reader.color(node, "Specular Tint")
    if tint_image:
        reader.note("an image of \"Specular Tint\" is not read")
    if metallic > 0 and tint != (1.0, 1.0, 1.0):
        reader.note("\"Specular Tint\" of metals is not supported")
    look = Look(
        base=_clipped(reader, base),
        metallic=min(max(metallic, 0.0), 1.0),
        roughness=min(max(roughness, 0.0), 1.0),
        ior=_index(reader.number(node, "IOR", 1.5), reader.number(node, "Specular IOR Level", 0.5)),
        tint=tuple(min(max(t, 0.0), 1.0) for t in tint),
        scatters=node.distribution == "MULTI_GGX",
        emission=tuple(max(c * strength, 0.0) for c in emission),
        color_image=color_image,
        metallic_image=metallic_image,
        roughness_image=roughness_image,
        emission_image=emission_image,
    )
    return reader.alpha(node, reader.normal(node, _coated(reader, node, look)))


def _coated(reader, node, look):
    """The clear coat of a Principled."""
    weight = min(max(reader.number(node, "Coat Weight"), 0.0), 1.0)
    if weight == 0:
        return look
    tint, tint_image = reader.color(node, "Coat Tint")
    if tint_image:
        reader.note("an image of \"Coat Tint\" is not read")
    if reader.source(node.inputs["Coat Normal"]) is not None:
        reader.note("\"Coat Normal\" is not supported: the coat has the normal of what is below")
    elif reader.source(node.inputs["Normal"]) is not None:
        reader.note("the coat has the normal of what is below it")
    if any(look.emission):
        reader.note("the coat does not reduce emission")
    return replace(
        look,
        coat=weight,
        coat_roughness=min(max(reader.number(node, "Coat Roughness", 0.03), 0.0), 1.0),
        coat_ior=min(max(reader.number(node, "Coat IOR", 1.5), 1.0), 1e3),
        coat_tint=tuple(min(max(t, 0.0), 1.0) for t in tint),
    )


def _clipped(reader, color):
    if max(color) > 1:
        reader.note("a base colour above 1 is cut")
    return tuple(min(max(c, 0.0), 1.0) for c in color)


def _index(ior, level):
    """The refractive index with twice the level times the reflectance of this one at normal incidence."""
    ior = max(ior, 1 / max(ior, 1e-3))
    root = np.sqrt(min(max(((ior - 1) / (ior + 1)) ** 2 * 2 * level, 0.0), 0.99))
    return float((1 + root) / (1 - root))


def _on_one_place(reader, look):
    """All images of a material lie by the same coordinates: those of the first."""
    if len({(picture.layer, picture.place) for picture in look.pictures}) > 1:
        reader.note("its images lie by different coordinates: those of the first stand for all")
    return look


def placed(uvs, place):
    """Texture coordinates, v downward, as a matrix moves them, v upward."""
    if place == Picture.place:
        return uvs
    a, b, c, d, e, f = place
    u, v = uvs[:, 0], 1 - uvs[:, 1]
    return np.stack([a * u + b * v + c, 1 - (d * u + e * v + f)], axis=1).astype(np.float32)


def made(cl, look, image_of):
    """The engine's material of a look. `image_of(kind, picture)` gives the arrays of images."""
    emission = look.emission if any(look.emission) else None
    if look.metallic == 0 and look.ior == 1 and not look.coat:
        material = cl.Material.lambert(look.base, emission=emission)
    else:
        material = cl.Material.principled(
            look.base,
            metallic=look.metallic,
            roughness=look.roughness,
            ior=look.ior,
            tint=look.tint,
            scatters=look.scatters,
            coat=look.coat,
            coat_roughness=look.coat_roughness,
            coat_ior=look.coat_ior,
            coat_tint=look.coat_tint,
            emission=emission,
        )
    given = {
        "color": look.color_image and image_of("color", look.color_image),
        "emission": look.emission_image and image_of("color", look.emission_image),
        "normal": look.normal_image and image_of("normal", look.normal_image),
        "roughness": look.roughness_image and image_of("number", look.roughness_image),
        "metallic": look.metallic_image and image_of("number", look.metallic_image),
    }
    given = {name: image for name, image in given.items() if image is not None}
    return material.with_images(**given, normal_scale=look.normal_strength) if given else material


def _mixed(bpy_images, kind, picture, notes):
    """The texels of a mix: of colours, or of numbers."""
    values = mixes.evaluate(picture.mix, lambda name, channel: mixes.linear(bpy_images[name], channel))
    if values.max() > 1 or values.min() < 0:
        notes.add(picture.image, "mixed values beyond 0 and 1 are cut")
    return images._bytes(images._encode(values)) if kind == "color" else images._bytes(values[..., 0])


def image_of(bpy_images, notes):
    """A reader of images, each once."""
    known = {}

    def read_image(kind, picture):
        key = (kind, picture)
        if key not in known and picture.mix:
            known[key] = _mixed(bpy_images, kind, picture, notes)
        if key not in known:
            image = bpy_images[picture.image]
            values = {
                "color": lambda: images.color(image, notes),
                "normal": lambda: images.normal(image, notes),
                "number": lambda: images.number(image, picture.channel),
            }[kind]()
            if values is None:
                notes.add(picture.image, "the image has no pixels: its file may be missing")
            known[key] = values
        return known[key]

    return read_image
