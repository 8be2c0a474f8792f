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
    # Not under the cube, where Cycles is dark and ours repeats what is beside it.
    place = np.abs((np.arange(48) + 0.5) / 12 - 2)
    beside = np.maximum(place[None, :], place[:, None]) > 0.51
    assert np.abs(ours - theirs)[beside].mean() < 0.01 * theirs[beside].mean()


def test_a_turned_sphere_and_the_margin():
    stage.reset()
    ball = stage.sphere(0.5, stage.material("white"), (0, 0, 1), 24, 12)
    ball.scale = (1, 1, -1)
    stage.lamp("SUN", (0, 0, 5), energy=math.pi)
    bpy.context.view_layer.update()
    image = baked(ball, 64)
    light, covered = bake.bake(bpy.context.evaluated_depsgraph_get(), [(ball, [0])], image, margin=4)
    # The upper half is lit by the cosine, the lower one is dark; v of a mirrored sphere grows downward.
    lit, dark = light[20][covered[20]], light[44][covered[44]]
    assert lit.mean() > 0.3 and dark.max() < 1e-3
    rim = ~covered & np.roll(covered, 1, axis=0)
    assert rim.sum() == 0 or (light[rim].sum(axis=1) >= 0).all()


def filtered(image, uv):
    """What a filter of four texels shows at places of an image."""
    rows = values(image)[..., 0]
    at = uv * rows.shape[::-1] - 0.5
    x, y = np.floor(at).astype(int).T
    a, b = (at - np.floor(at)).T
    return (rows[y, x] * (1 - a) + rows[y, x + 1] * a) * (1 - b) + (rows[y + 1, x] * (1 - a) + rows[y + 1, x + 1] * a) * b


def test_both_sides_of_a_seam_are_alike():
    """A coarse image of a round body with a seam from pole to pole; and texels at the edge of a shadow are means."""
    stage.reset()
    bpy.ops.mesh.primitive_cylinder_add(vertices=24, radius=1, depth=2, end_fill_type="NOTHING")
    round_ = bpy.context.object
    round_.data.shade_smooth()
    round_.data.materials.append(stage.material("white"))
    # Its faces in two rows, one beside the other by a quarter of a face: no texel of one is a texel of the other.
    layer = round_.data.uv_layers.active or round_.data.uv_layers.new()
    for polygon in round_.data.polygons:
        k = polygon.index
        corners = [round_.data.vertices[round_.data.loops[loop].vertex_index].co for loop in polygon.loop_indices]
        turns = [np.arctan2(co.y, co.x) / (2 * np.pi) % 1 for co in corners]
        least = min(turns) if max(turns) - min(turns) < 0.5 else max(turns)
        row = int(least * 24 + 0.5) % 2
        for loop, turn, co in zip(polygon.loop_indices, turns, corners):
            across = (turn - least) % 1 if (turn - least) % 1 < 0.5 else 0.0
            u = (int(least * 24 + 0.5) // 2 + 0.1 + 0.8 * across * 24) / 12
            layer.uv[loop].vector = (u, 0.05 + 0.5 * row + (0.36 + 0.03 * row) * (co.z + 1) / 2)
    stage.lamp("POINT", (1.3, 0.2, 0.4), energy=100, shadow_soft_size=0.01)
    image = baked(round_, 96)
    assert bpy.ops.object.cosine_lobes_bake(margin=2) == {"FINISHED"}
    # The places of each vertical edge on its two faces.
    edges = {}
    for polygon in round_.data.polygons:
        loops = {round_.data.loops[loop].vertex_index: np.array(layer.uv[loop].vector) for loop in polygon.loop_indices}
        for edge in polygon.edge_keys:
            low, high = (round_.data.vertices[v].co for v in edge)
            if abs(low.z - high.z) > 1:
                edges.setdefault(edge, []).append([loops[v] for v in edge])
    s = np.linspace(0.1, 0.9, 9)[:, None]
    sides = [[filtered(image, a + (b - a) * s) for a, b in both] for both in edges.values()]
    one, other = np.array(sides).transpose(1, 0, 2)
    assert len(edges) == 24 and np.abs(one - other).mean() < 0.01 * one.mean()


def test_texels_at_the_edge_of_a_shadow_are_means():
    stage.reset()
    made = floor()
    # Hides a half of the sun's light, along the middle of a column of texels.
    edge = 0.25 / 12
    stage.mesh("wall", [(edge, -9, 1), (9, -9, 1), (9, 9, 1), (edge, 9, 1)], [(0, 1, 2, 3)], stage.material("wall"))
    stage.lamp("SUN", (0, 0, 5), energy=math.pi, angle=1e-4)
    image = baked(made)
    assert bpy.ops.object.cosine_lobes_bake(samples=4) == {"FINISHED"}
    row = values(image)[24, :, 0]
    assert np.allclose(row[:24], 1, atol=2e-3) and np.allclose(row[25:], 0, atol=1e-3) and abs(row[24] - 0.25) < 0.02


def test_objects_and_materials_with_one_image_are_baked_together():
    """Two floors in the halves of one image; a second material of one of them has an image of its own."""
    stage.reset()
    looks = [stage.material("left"), stage.material("right"), stage.material("other")]
    halves = [(0, 0, 0.5, 0, 0.5, 1, 0, 1), (0.5, 0, 1, 0, 1, 1, 0.5, 1)]
    floors = [stage.plane(2, look, (4 * k - 2, 0, 0), look.name) for k, look in enumerate(looks[:2])]
    for made, uvs in zip(floors, halves):
        made.data.uv_layers.new(name="uv").uv.foreach_set("vector", uvs)
    two = stage.mesh("two", [(x, y, 0) for x in (5, 6, 7) for y in (0, 1)], [(0, 2, 3, 1), (2, 4, 5, 3)], looks[0])
    two.data.materials.append(looks[2])
    two.data.polygons[1].material_index = 1
    two.data.uv_layers.new(name="uv").uv.foreach_set("vector", [0.2, 0.2, 0.4, 0.2, 0.4, 0.4, 0.2, 0.4] * 2)
    stage.lamp("SUN", (0, 0, 5), energy=math.pi)
    images = [bpy.data.images.new(name, 16, 16, float_buffer=True) for name in ("shared", "own")]
    for look, image in zip(looks, (images[0], images[0], images[1])):
        node = look.node_tree.nodes.new("ShaderNodeTexImage")
        node.image = image
        look.node_tree.nodes.active = node
    bpy.context.view_layer.update()
    for other in bpy.context.view_layer.objects:
        other.select_set(other in floors)
    assert bpy.ops.object.cosine_lobes_bake(margin=0) == {"FINISHED"}
    assert np.allclose(values(images[0]), 1, atol=1e-3)
    assert values(images[1]).max() == 0
    select(two)
    assert bpy.ops.object.cosine_lobes_bake(margin=0) == {"FINISHED"}
    for image in images:
        covered = values(image)[..., 0] > 0.5
        assert 9 <= covered.sum() <= 16 and covered[4, 4]


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
