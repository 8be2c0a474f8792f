"""Pictures against those of Cycles without bounces: the mean error of lit pixels and penumbrae, away from outlines, is at most 1 %.

Cycles' own noise is part of the error. Its shadow rays begin at the surface's own triangle: spheres are fine enough that their terminators agree.
"""

import math

import bpy
import numpy as np
import pytest

import stage

MOST = 0.01


def compared(name):
    """The error. Prints it with the noise of Cycles: two of its pictures with half of the samples each differ by twice the noise of their mean."""
    where, scene = stage.inside(), bpy.context.scene
    test = stage.render()
    scene.cycles.samples //= 2
    first = stage.render("CYCLES")
    scene.cycles.seed = 1
    second = stage.render("CYCLES")
    reference = (first + second) / 2
    error, noise = stage.error(test, reference, where), stage.error(first, second, where) / 2
    bright = test[..., :3][where].mean() / reference[..., :3][where].mean()
    print(f"{name}: {100 * error:.2f} %, of it noise of Cycles {100 * noise:.2f} %, brightness {bright:.4f}")
    return error


def still_life(**settings):
    """A floor and a camera."""
    scene = stage.reset(**settings)
    stage.plane(10, look=stage.material(Base_Color=(0.8, 0.8, 0.8)))
    stage.camera()
    return scene


def test_a_cube_under_an_area_light():
    still_life()
    stage.cube(look=stage.material(Base_Color=(0.8, 0.3, 0.2)))
    stage.lamp("AREA", (1.5, 1, 3), energy=200, size=1)
    assert compared("cube, square light") < MOST


def test_modifiers_instances_and_a_mirrored_scale_under_point_and_spot():
    still_life(samples=256)
    bpy.ops.mesh.primitive_monkey_add(location=(-0.6, 0, 0.8))
    monkey = bpy.context.object
    monkey.data.materials.append(stage.material("monkey", Base_Color=(0.7, 0.5, 0.2)))
    monkey.modifiers.new("smooth", "SUBSURF").render_levels = monkey.modifiers["smooth"].levels = 2
    monkey.data.shade_smooth()
    monkey.scale = (0.7, 0.9, -0.7)
    pair = bpy.data.collections.new("pair")
    small = stage.cube(0.3, stage.material("small", Base_Color=(0.2, 0.4, 0.8)), (0, 0, 0.15))
    bpy.context.scene.collection.objects.unlink(small)
    pair.objects.link(small)
    for x in (0.6, 1.1):
        made = stage.link(f"instance {x}", None)
        made.instance_type, made.instance_collection, made.location = "COLLECTION", pair, (x, -0.5, 0)
        made.scale = (1, 1, 2)
    stage.lamp("POINT", (1, -1.5, 3), energy=200, shadow_soft_size=0.3)
    stage.lamp("SPOT", (-2, -1, 3), energy=300, shadow_soft_size=0.2, spot_size=1.0, spot_blend=0.3, color=(1, 0.8, 0.6))
    assert compared("monkey and instances, point and spot") < MOST


def test_highlights_of_plastic_and_metal_under_a_disc_and_a_sun():
    stage.reset(width=80, height=60, samples=384)
    stage.camera((2, -3, 2.2))
    stage.plane(look=stage.material(Base_Color=(0.5, 0.5, 0.5), Roughness=0.6, Specular_IOR_Level=0.5))
    stage.sphere(0.4, stage.material("plastic", Base_Color=(0.8, 0.2, 0.1), Roughness=0.4, Specular_IOR_Level=0.5), (-0.45, 0, 0.4), 192, 96)
    stage.sphere(0.4, stage.material("metal", Base_Color=(0.9, 0.6, 0.3), Roughness=0.5, Metallic=1.0), (0.5, 0.2, 0.4), 192, 96)
    stage.lamp("AREA", (-1, -1, 3), energy=200, shape="DISK", size=1.2)
    stage.lamp("SUN", (2, -1, 3), energy=1, angle=math.radians(6))
    assert compared("plastic and metal, disc and sun") < MOST


def test_clear_coats_over_plastic_and_metal():
    """One is coloured, and thick enough that its refractive index counts."""
    stage.reset(width=80, height=60, samples=512)
    stage.camera((2, -3, 2.2))
    stage.plane(look=stage.material("floor", Base_Color=(0.5, 0.5, 0.5), Roughness=0.6, Coat_Weight=1.0, Coat_Roughness=0.3))
    paint = stage.material("paint", Base_Color=(0.8, 0.2, 0.1), Roughness=0.5, Coat_Weight=0.7, Coat_Roughness=0.35, Coat_IOR=1.8)
    stage.sphere(0.4, paint, (-0.45, 0, 0.4), 192, 96)
    metal = stage.material("metal", Base_Color=(0.9, 0.6, 0.3), Roughness=0.5, Metallic=1.0, Coat_Weight=1.0, Coat_Roughness=0.25)
    metal.node_tree.nodes["Principled BSDF"].inputs["Coat Tint"].default_value = (0.9, 0.6, 0.5, 1)
    stage.sphere(0.4, metal, (0.5, 0.2, 0.4), 192, 96)
    stage.lamp("AREA", (-1, -1, 3), energy=200, shape="DISK", size=1.2)
    stage.lamp("SUN", (2, -1, 3), energy=1, angle=math.radians(6))
    assert compared("coats, disc and sun") < MOST


def sky(width=128):
    image = bpy.data.images.new("sky", width, width // 2, float_buffer=True)
    v, u = (np.mgrid[0 : width // 2, 0:width] + 0.5) / np.array([width // 2, width])[:, None, None]
    glow = 3 * np.exp(-40 * ((u - 0.2) ** 2 + (v - 0.75) ** 2))
    pixels = np.stack([0.2 + glow, 0.3 + 0.4 * u, 0.2 + 0.6 * v, np.ones_like(u)], axis=-1)
    image.pixels.foreach_set(pixels.astype(np.float32).ravel())
    image.update()
    return image


def test_a_world_that_shows_a_picture():
    still_life(width=64, height=48, samples=512)
    stage.cube(look=stage.material(Base_Color=(0.8, 0.8, 0.8)))
    stage.world(strength=1.5, image=sky())
    assert compared("cube, HDR world") < MOST
    # Behind everything as well.
    bpy.context.scene.cycles.samples = 16
    stage.camera((3, -4, 0.5), (0, 0, 2.5))
    made, reference = stage.render(), stage.render("CYCLES")
    assert np.abs(made[:10, :, :3] - reference[:10, :, :3]).mean() < 0.01 * reference[:10, :, :3].mean()


def image(name, pixels, is_color=True):
    """An image of three channels."""
    made = bpy.data.images.new(name, pixels.shape[1], pixels.shape[0])
    if not is_color:
        made.colorspace_settings.name = "Non-Color"
    made.pixels.foreach_set(np.concatenate([pixels, np.ones((*pixels.shape[:2], 1))], axis=2).astype(np.float32).ravel())
    made.update()
    return made


def test_roughness_and_metalness_of_one_image_and_a_normal_map():
    stage.reset(64, 48, samples=256)
    stage.camera((0.5, -2.5, 2.2), (0, 0, 0))
    look = stage.material("maps", Specular_IOR_Level=0.5, Base_Color=(0.8, 0.7, 0.5))
    stage.plane(3, look).data.uv_layers.new(name="uv").uv.foreach_set("vector", [0, 0, 1, 0, 1, 1, 0, 1])
    n = 64
    v, u = (np.mgrid[0:n, 0:n] + 0.5) / n
    x, y = 0.4 * np.sin(4 * np.pi * u), 0.3 * np.sin(6 * np.pi * v)
    nodes, links = look.node_tree.nodes, look.node_tree.links
    inputs = nodes["Principled BSDF"].inputs
    packed, bent = nodes.new("ShaderNodeTexImage"), nodes.new("ShaderNodeTexImage")
    packed.image = image("packed", np.stack([np.ones_like(u), 0.4 + 0.5 * u, v], axis=-1), False)
    bent.image = image("bent", 0.5 + 0.5 * np.stack([x, y, np.sqrt(1 - x * x - y * y)], axis=-1), False)
    parts, tangent = nodes.new("ShaderNodeSeparateColor"), nodes.new("ShaderNodeNormalMap")
    links.new(packed.outputs["Color"], parts.inputs[0])
    links.new(parts.outputs[1], inputs["Roughness"])
    links.new(parts.outputs[2], inputs["Metallic"])
    links.new(bent.outputs["Color"], tangent.inputs["Color"])
    links.new(tangent.outputs[0], inputs["Normal"])
    stage.lamp("AREA", (-1, -1, 2.5), energy=150, size=1)
    assert compared("roughness, metalness and normals from images") < MOST


def textured():
    """A floor that shows an image of four colours, cut out where alpha is 0, with roughness from another."""
    n = 64
    y, x = np.mgrid[0:n, 0:n] / n
    color = np.stack([0.2 + 0.6 * (x > 0.5), 0.3 + 0.5 * (y > 0.5), np.full_like(x, 0.4), (np.hypot(x - 0.5, y - 0.5) > 0.2)], axis=-1)
    image = bpy.data.images.new("colors", n, n, alpha=True)
    image.pixels.foreach_set(color.astype(np.float32).ravel())
    image.update()
    look = stage.material("textured", Specular_IOR_Level=0.5, Roughness=0.7)
    tree = look.node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    limit = tree.nodes.new("ShaderNodeMath")
    limit.operation = "GREATER_THAN"
    limit.inputs[1].default_value = 0.5
    principled = tree.nodes["Principled BSDF"]
    tree.links.new(node.outputs["Color"], principled.inputs["Base Color"])
    tree.links.new(node.outputs["Alpha"], limit.inputs[0])
    tree.links.new(limit.outputs[0], principled.inputs["Alpha"])
    return look


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO", "PANO"])
def test_the_world_behind(kind):
    still_life(width=64, height=32, samples=64)
    stage.cube(0.1, stage.material(), (0, 0, 0.5))
    stage.world(strength=1.5, image=sky())
    camera = bpy.context.scene.camera.data
    camera.type, camera.ortho_scale = kind, 3.0
    if kind == "PANO":
        (camera if hasattr(camera, "panorama_type") else camera.cycles).panorama_type = "EQUIRECTANGULAR"
    bpy.data.objects.remove(bpy.data.objects["plane"])
    made, view = stage.live()
    where = made.renderer.layers(["object"], window=view.window)["object"] < 0
    error = stage.error(stage.render(), stage.render("CYCLES"), where)
    print(f"world behind, {kind}: {100 * error:.2f} % over {where.sum()} pixels")
    assert where.sum() > 1500 and error < MOST


@pytest.mark.parametrize("fit", ["AUTO", "VERTICAL"])
def test_an_orthographic_camera(fit):
    still_life()
    camera = bpy.context.scene.camera.data
    camera.type, camera.ortho_scale, camera.sensor_fit = "ORTHO", 4.0 if fit == "AUTO" else 3.0, fit
    camera.shift_x, camera.shift_y = 6 / 96, -12 / 96
    stage.cube(look=stage.material(Base_Color=(0.8, 0.3, 0.2)))
    plastic = stage.material("plastic", Base_Color=(0.8, 0.2, 0.1), Roughness=0.4, Specular_IOR_Level=0.5)
    stage.sphere(0.4, plastic, (-0.9, -0.4, 0.4), 192, 96)
    stage.lamp("AREA", (1.5, 1, 3), energy=200, shape="DISK", size=1)
    stage.lamp("POINT", (-1, -2, 3), energy=200, shadow_soft_size=0.3)
    assert compared(f"orthographic camera, {fit}") < MOST


@pytest.mark.parametrize("part", ["all", "window"])
def test_a_panoramic_camera(part):
    still_life(width=96, height=48)
    stage.aim(bpy.context.scene.camera, (0.2, -1.5, 0.8), (0.2, 1, 0.6))
    camera = bpy.context.scene.camera.data
    camera.type = "PANO"
    own = camera if hasattr(camera, "panorama_type") else camera.cycles
    own.panorama_type = "EQUIRECTANGULAR"
    if part == "window":
        own.longitude_min, own.longitude_max = -math.pi / 2, math.pi / 4
        own.latitude_min, own.latitude_max = -math.pi / 2, math.pi / 4
    stage.cube(look=stage.material(Base_Color=(0.8, 0.3, 0.2)), location=(0, 0.4, 0.5))
    plastic = stage.material("plastic", Base_Color=(0.8, 0.2, 0.1), Roughness=0.4, Specular_IOR_Level=0.5)
    stage.sphere(0.4, plastic, (-1.1, -1.4, 0.4), 192, 96)
    stage.lamp("AREA", (1.5, 1, 3), energy=200, size=1)
    stage.lamp("POINT", (-1, -3, 2.5), energy=200, shadow_soft_size=0.3)
    assert compared(f"panoramic camera, {part}") < MOST


def test_images_and_alpha_under_a_shifted_camera():
    scene = still_life()
    card = stage.plane(2, textured(), (0, 0, 0.8), "card")
    card.rotation_euler = stage.degrees(25, 0, 20)
    layer = card.data.uv_layers.new(name="uv")
    layer.uv.foreach_set("vector", [0, 0, 1, 0, 1, 1, 0, 1])
    camera = scene.camera.data
    camera.sensor_fit, camera.shift_x, camera.shift_y = "VERTICAL", 9 / 72, -12 / 72
    stage.lamp("AREA", (-1, -1, 4), energy=300, shape="RECTANGLE", size=1.5, size_y=0.4)
    assert compared("card with an image and a hole, rectangle") < MOST
