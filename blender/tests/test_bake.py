"""Baking into image textures."""

import math

import bpy
import numpy as np
import pytest

import stage
from cosine_lobes_engine import bake


def baked(object, size=48, name="light"):
    """Adds an image to an object's material, active, and bakes by the operator."""
    image = bpy.data.images.new(name, size, size, float_buffer=True)
    node = object.data.materials[0].node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    object.data.materials[0].node_tree.nodes.active = node
    select(object)
    return image


def select(object):
    """Selects it alone."""
    bpy.context.view_layer.update()
    for other in bpy.context.view_layer.objects:
        other.select_set(other.name == object.name)
    bpy.context.view_layer.objects.active = object


def values(image):
    pixels = np.empty(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(image.size[1], image.size[0], 4)[..., :3]


def floor():
    made = stage.plane(4, stage.material("floor"))
    made.data.uv_layers.new(name="uv").uv.foreach_set("vector", [0, 0, 1, 0, 1, 1, 0, 1])
    return made


def test_a_floor_under_a_point_by_its_closed_form():
    stage.reset()
    made = floor()
    stage.lamp("POINT", (0, 0, 2), energy=100, shadow_soft_size=0)
    image = baked(made)
    assert bpy.ops.object.cosine_lobes_bake() == {"FINISHED"}
    place = (np.arange(48) + 0.5) / 12 - 2
    squared = place[None, :] ** 2 + place[:, None] ** 2 + 4
    want = 100 / (4 * math.pi**2) * 2 / squared**1.5
    assert np.allclose(values(image)[..., 0], want, rtol=2e-3)


def test_a_floor_with_a_shadow_against_cycles():
    scene = stage.reset(samples=256)
    made = floor()
    stage.cube(look=stage.material("red"))
    stage.lamp("AREA", (1.5, 1, 3), energy=200, size=1)
    image = baked(made)
    bpy.ops.object.cosine_lobes_bake()
    ours = values(image)
    scene.render.engine = "CYCLES"
    # A white floor, as its light is what we bake.
    made.data.materials[0].node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (1, 1, 1, 1)
    bpy.ops.object.bake(type="DIFFUSE", pass_filter={"DIRECT"}, margin=0)
    theirs = values(image)
    # Beside the cube's edges, where a texel's centre is not its mean.
    place = np.abs((np.arange(48) + 0.5) / 12 - 2)
    far = np.maximum(place[None, :], place[:, None]) > 0.6
    assert np.abs(ours - theirs)[far].mean() < 0.01 * theirs[far].mean()


def test_a_turned_sphere_and_the_margin():
    stage.reset()
    ball = stage.sphere(0.5, stage.material("white"), (0, 0, 1), 24, 12)
    ball.scale = (1, 1, -1)
    stage.lamp("SUN", (0, 0, 5), energy=math.pi)
    bpy.context.view_layer.update()
    image = baked(ball, 64)
    light, covered = bake.bake(bpy.context.evaluated_depsgraph_get(), ball, image, margin=4)
    # The upper half is lit by the cosine, the lower one is dark; v of a mirrored sphere grows downward.
    lit, dark = light[20][covered[20]], light[44][covered[44]]
    assert lit.mean() > 0.3 and dark.max() < 1e-3
    rim = ~covered & np.roll(covered, 1, axis=0)
    assert rim.sum() == 0 or (light[rim].sum(axis=1) >= 0).all()


def test_faults_are_said():
    stage.reset()
    made = stage.plane(4, stage.material("floor"))
    stage.lamp("POINT", (0, 0, 2), energy=100)
    select(made)
    with pytest.raises(RuntimeError, match="has no image to bake to"):
        bpy.ops.object.cosine_lobes_bake()
    image = baked(made)
    with pytest.raises(RuntimeError, match="no texture coordinates"):
        bpy.ops.object.cosine_lobes_bake()
    made.data.uv_layers.new(name="uv").uv.foreach_set("vector", [0, 0, 2, 0, 2, 1, 0, 1])
    assert bpy.ops.object.cosine_lobes_bake() == {"FINISHED"} and values(image).max() > 0
