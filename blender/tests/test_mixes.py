"""Colours that nodes mix of images and constants, against Cycles: texel by texel."""

import bpy
import numpy as np
import pytest

import stage
from cosine_lobes_engine import materials
from cosine_lobes_engine.notes import Notes

SIDE = 16


def picture(name, seed):
    """An image of bytes."""
    made = bpy.data.images.new(name, SIDE, SIDE, alpha=True)
    pixels = np.random.default_rng(seed).random((SIDE, SIDE, 4)).astype(np.float32)
    pixels[..., 3] = 1
    made.pixels.foreach_set(pixels.ravel())
    return made


def shown():
    """A square that emits, before an orthographic camera, a texel a pixel; its tree, Emission node, and a maker of nodes."""
    scene = stage.reset(SIDE, SIDE, 1)
    look = bpy.data.materials.new("look")
    tree = look.node_tree
    tree.nodes.remove(tree.nodes["Principled BSDF"])
    emission = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(emission.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    square = stage.plane(1, look)
    square.data.uv_layers.new(name="uv").uv.foreach_set("vector", [0, 0, 1, 0, 1, 1, 0, 1])
    stage.camera((0, 0, 2), (0, 0, 0), type="ORTHO", ortho_scale=1)
    scene.camera.rotation_euler = (0, 0, 0)
    # Something that lights, or the scene is refused; it lights nothing that is seen.
    stage.lamp("POINT", (0, 0, -5), energy=1)

    def node(kind, inputs=(), **settings):
        made = tree.nodes.new(f"ShaderNode{kind}")
        for name, value in settings.items():
            setattr(made, name, value)
        for place, value in dict(inputs).items():
            socket = made.inputs[place]
            if isinstance(value, bpy.types.NodeSocket):
                tree.links.new(value, socket)
            else:
                socket.default_value = value
        return made

    def image(name, seed):
        made = node("TexImage", interpolation="Closest")
        made.image = picture(name, seed)
        return made.outputs["Color"]

    return look, tree, emission, node, image


def mix(node, blend, t, a, b, **settings):
    made = node("Mix", data_type="RGBA", blend_type=blend, **settings)
    for identifier, value in (("Factor_Float", t), ("A_Color", a), ("B_Color", b)):
        socket = next(s for s in made.inputs if s.identifier == identifier)
        if isinstance(value, bpy.types.NodeSocket):
            made.id_data.links.new(value, socket)
        else:
            socket.default_value = value
    return next(s for s in made.outputs if s.identifier == "Result_Color")


def ramp(node, image, kind):
    made = node("ValToRGB", {0: image})
    made.color_ramp.interpolation = kind
    made.color_ramp.elements[0].color, made.color_ramp.elements[0].position = (0.9, 0.2, 0.1, 1), 0.3
    made.color_ramp.elements[1].color, made.color_ramp.elements[1].position = (0.1, 0.3, 0.8, 1), 0.6
    return made.outputs["Color"]


BLENDS = ["MIX", "ADD", "MULTIPLY", "SUBTRACT", "DIVIDE", "SCREEN", "DIFFERENCE", "DARKEN", "LIGHTEN", "OVERLAY", "SOFT_LIGHT", "LINEAR_LIGHT"]
MATHS = ["ADD", "SUBTRACT", "MULTIPLY", "DIVIDE", "MULTIPLY_ADD", "POWER", "SQRT", "ABSOLUTE", "MINIMUM", "MAXIMUM", "LESS_THAN", "GREATER_THAN", "ROUND", "FLOOR", "FRACT"]
GRAPHS = {
    **{f"mix {blend}": lambda n, i, blend=blend: mix(n, blend, 0.7, i("a", 1), i("b", 2), clamp_result=True) for blend in BLENDS},
    **{
        f"math {kind}": lambda n, i, kind=kind: n("Math", {0: i("a", 1), 1: 0.45, 2: 0.2}, operation=kind, use_clamp=True).outputs[0]
        for kind in MATHS
    },
    "a mix by an image": lambda n, i: mix(n, "MIX", i("a", 1), (0.9, 0.1, 0.2, 1), i("b", 2)),
    "a ramp": lambda n, i: ramp(n, i("a", 1), "LINEAR"),
    "a stepped ramp": lambda n, i: ramp(n, i("a", 1), "CONSTANT"),
    "an inverse": lambda n, i: n("Invert", {0: 0.8, 1: i("a", 1)}).outputs[0],
    "gamma": lambda n, i: n("Gamma", {0: i("a", 1), 1: 1.7}).outputs[0],
    "contrast": lambda n, i: n("BrightContrast", {0: i("a", 1), 1: 0.1, 2: -0.4}).outputs[0],
    "hue": lambda n, i: n("HueSaturation", {"Color": i("a", 1), "Hue": 0.73, "Saturation": 0.8, "Value": 0.9, "Fac": 0.85}).outputs[0],
    "grey": lambda n, i: n("RGBToBW", {0: i("a", 1)}).outputs[0],
    "a range": lambda n, i: n("MapRange", {"Value": i("a", 1), "From Min": 0.2, "From Max": 0.7, "To Min": 0.9, "To Max": 0.1}).outputs[0],
    "bounds": lambda n, i: n("Clamp", {0: i("a", 1), 1: 0.3, 2: 0.6}).outputs[0],
    "channels": lambda n, i: n("CombineColor", {0: n("SeparateColor", {0: i("a", 1)}).outputs[2], 1: i("b", 2), 2: 0.3}).outputs[0],
    "a constant": lambda n, i: mix(n, "MULTIPLY", 0.5, (0.2, 0.4, 0.8, 1), (0.5, 0.7, 0.1, 1)),
}


@pytest.mark.parametrize("name", GRAPHS)
def test_texels_are_those_of_cycles(name):
    _, tree, emission, node, image = shown()
    tree.links.new(GRAPHS[name](node, image), emission.inputs["Color"])
    theirs = stage.render("CYCLES")[..., :3]
    made, _ = stage.live()
    assert not [line for line in made.notes.lines if "not read" in line], made.notes.lines
    ours = stage.render()[..., :3]
    # Eight bits by sRGB's curve, whose steps are finer in the dark.
    assert np.abs(ours - theirs).max() < 6e-3, np.abs(ours - theirs).max()
    assert name in ("a constant", "math FLOOR") or theirs.std() > 0.01


def test_nodes_that_are_not_read_are_said():
    _, tree, emission, node, image = shown()
    for graph in (
        node("TexNoise").outputs["Color"],
        node("Math", {0: image("a", 1)}, operation="SINE").outputs[0],
        mix(node, "HUE", 1.0, image("a", 1), image("b", 2)),
        mix(node, "MIX", node("Fresnel").outputs[0], image("a", 1), image("b", 2)),
    ):
        tree.links.new(graph, emission.inputs["Color"])
        made, _ = stage.live()
        assert f"\"Color\" comes from node \"{graph.node.name}\", which is not read" in "\n".join(made.notes.lines)


def test_images_that_lie_otherwise_are_not_mixed():
    _, tree, emission, node, image = shown()
    one, other = image("a", 1), image("b", 2)
    turned = node("Mapping", {"Vector": node("TexCoord").outputs["UV"], "Scale": (2, 2, 2)})
    tree.links.new(turned.outputs[0], other.node.inputs["Vector"])
    tree.links.new(mix(node, "MULTIPLY", 1.0, one, other), emission.inputs["Color"])
    made, _ = stage.live()
    assert "which is not read" in "\n".join(made.notes.lines)


def test_a_painted_image_shows_through_its_mix():
    look, tree, emission, node, image = shown()
    one = image("a", 1)
    tree.links.new(mix(node, "MULTIPLY", 1.0, one, (0.5, 0.5, 0.5, 1)), emission.inputs["Color"])
    before = stage.render()[..., :3]
    one.node.image.pixels.foreach_set(np.ones(4 * SIDE * SIDE, np.float32))
    one.node.image.update()
    after = stage.render()[..., :3]
    assert np.allclose(after, 0.5, atol=3e-3) and np.abs(before - after).max() > 0.1
    read = materials.read(look, Notes())
    assert read.emission_image.images == {"a"} and read == materials.read(look, Notes()) and hash(read)


def test_numbers_of_principled_are_mixed():
    stage.reset()
    look = stage.material("look")
    nodes, links = look.node_tree.nodes, look.node_tree.links
    principled = nodes["Principled BSDF"]
    texture = nodes.new("ShaderNodeTexImage")
    texture.image = picture("a", 1)
    ranged = nodes.new("ShaderNodeMapRange")
    ranged.inputs["To Min"].default_value, ranged.inputs["To Max"].default_value = 0.2, 0.4
    links.new(texture.outputs["Color"], ranged.inputs["Value"])
    links.new(ranged.outputs[0], principled.inputs["Roughness"])
    half = nodes.new("ShaderNodeMath")
    half.operation = "MULTIPLY"
    half.inputs[0].default_value, half.inputs[1].default_value = 0.5, 0.6
    links.new(half.outputs[0], principled.inputs["Metallic"])
    links.new(half.outputs[0], principled.inputs["IOR"])
    notes = Notes()
    read = materials.read(look, notes)
    assert read.metallic == pytest.approx(0.3) and read.metallic_image is None and not notes.lines
    texels = materials.image_of(bpy.data.images, notes)("number", read.roughness_image)
    assert texels.shape == (SIDE, SIDE) and texels.min() >= 0.2 * 255 - 1 and texels.max() <= 0.4 * 255 + 1
    assert texels.std() > 2
