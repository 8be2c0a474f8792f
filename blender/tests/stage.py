"""Scenes in Blender for the tests, and pictures of them by both engines."""

import math
import os
import tempfile

import bpy
import numpy as np


def reset(width=96, height=72, samples=256):
    """An empty scene with Cycles set to direct light: no bounces, no clamping, no denoising, a box as pixel filter."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    cycles = scene.cycles
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = 0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.samples, cycles.pixel_filter_type = samples, "BOX"
    render = scene.render
    render.threads_mode, render.threads = "FIXED", 2
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.view_settings.view_transform = "Standard"
    scene.cosine_lobes.samples = 1
    return scene


def link(name, data):
    made = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(made)
    return made


def aim(thing, location, target=(0, 0, 0)):
    """Places an object so that its −z axis points at a target."""
    from mathutils import Vector

    thing.location = location
    toward = Vector(target) - Vector(location)
    thing.rotation_euler = toward.to_track_quat("-Z", "Y").to_euler()
    return thing


def camera(location=(3, -4, 3), target=(0, 0, 0.4), **settings):
    made = aim(link("camera", bpy.data.cameras.new("camera")), location, target)
    for name, value in settings.items():
        setattr(made.data, name, value)
    bpy.context.scene.camera = made
    return made


def lamp(kind, location, target=(0, 0, 0), **settings):
    made = aim(link(kind.lower(), bpy.data.lights.new(kind.lower(), kind)), location, target)
    for name, value in settings.items():
        setattr(made.data, name, value)
    return made


def material(name="material", **inputs):
    """Principled with inputs by their names, `_` for a space; without highlights unless they are given."""
    made = bpy.data.materials.new(name)
    node = made.node_tree.nodes["Principled BSDF"]
    for key, value in ({"Specular_IOR_Level": 0} | inputs).items():
        value = (*value, 1) if isinstance(value, tuple) and len(value) == 3 else value
        node.inputs[key.replace("_", " ")].default_value = value
    return made


def mesh(name, vertices, faces, look=None, location=(0, 0, 0)):
    data = bpy.data.meshes.new(name)
    data.from_pydata(vertices, [], faces)
    data.update()
    made = link(name, data)
    made.location = location
    if look is not None:
        data.materials.append(look)
    return made


def plane(size=10.0, look=None, location=(0, 0, 0), name="plane"):
    h = size / 2
    return mesh(name, [(-h, -h, 0), (h, -h, 0), (h, h, 0), (-h, h, 0)], [(0, 1, 2, 3)], look, location)


def cube(size=1.0, look=None, location=(0, 0, 0.5), name="cube"):
    h = size / 2
    vertices = [(x, y, z) for x in (-h, h) for y in (-h, h) for z in (-h, h)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return mesh(name, vertices, faces, look, location)


def sphere(radius=0.5, look=None, location=(0, 0, 0.5), segments=96, rings=48, name="sphere"):
    """A smooth sphere."""
    bpy.ops.mesh.primitive_uv_sphere_add(radius=radius, location=location, segments=segments, ring_count=rings)
    made = bpy.context.object
    made.name = name
    made.data.shade_smooth()
    if look is not None:
        made.data.materials.append(look)
    return made


def world(color=(0, 0, 0), strength=1.0, image=None):
    made = bpy.data.worlds.new("world")
    bpy.context.scene.world = made
    nodes = made.node_tree.nodes
    background = nodes["Background"]
    background.inputs["Color"].default_value = (*color, 1)
    background.inputs["Strength"].default_value = strength
    if image is not None:
        node = nodes.new("ShaderNodeTexEnvironment")
        node.image = image
        made.node_tree.links.new(node.outputs["Color"], background.inputs["Color"])
    return made


def render(engine="COSINE_LOBES"):
    """The picture that F12 makes, `(height, width, 4)`, linear, the top row first."""
    scene = bpy.context.scene
    scene.render.engine = engine
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "picture.exr")
        scene.render.filepath = path
        bpy.ops.render.render(write_still=True)
        return load(path)


def load(path):
    image = bpy.data.images.load(path)
    try:
        width, height = image.size
        pixels = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(pixels)
        return pixels.reshape(height, width, image.channels)[::-1]
    finally:
        bpy.data.images.remove(image)


def live(viewport=False):
    """The renderer of the present scene without F12, the view, and what was left out."""
    import cosine_lobes as cl

    from cosine_lobes_engine import camera as cameras
    from cosine_lobes_engine.engine import engine_settings
    from cosine_lobes_engine.export import Exporter
    from cosine_lobes_engine.live import Live

    scene = bpy.context.scene
    depsgraph = bpy.context.evaluated_depsgraph_get()
    exporter = Exporter(bpy.data.images)
    made = Live(cl, exporter)
    snapshot = exporter.snapshot(depsgraph)
    view = cameras.of_scene(scene, scene.camera.evaluated_get(depsgraph), snapshot.notes)
    made.show(snapshot, view, engine_settings(scene, viewport))
    return made, view


def inside():
    """Pixels whose neighbours show the same smooth surface: those without outlines and creases."""
    made, view = live()
    layers = made.renderer.layers(["object", "normal"], window=view.window)
    objects, normals = layers["object"], layers["normal"]
    same = objects >= 0
    for axis in (0, 1):
        for shift in (-1, 1):
            flat = (np.roll(normals, shift, axis) * normals).sum(axis=2) > 0.97
            same &= (np.roll(objects, shift, axis) == objects) & flat
    same[[0, -1]] = False
    same[:, [0, -1]] = False
    return same


def error(test, reference, where):
    """The mean difference over the mean radiance, of lit pixels and penumbrae: where the reference is above a thousandth of its brightest."""
    test, reference = test[..., :3], reference[..., :3]
    bright = reference[where].mean(axis=1)
    lit = where & (reference.mean(axis=2) > 1e-3 * bright.max())
    return np.abs(test - reference)[lit].mean() / reference[lit].mean()


def degrees(*angles):
    return tuple(math.radians(angle) for angle in angles)
