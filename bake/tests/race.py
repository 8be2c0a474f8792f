"""Bakes the direct diffuse light of room.toml in Cycles, beside maps that `lobes bake` made of it: processor seconds and mean errors.

    pip install bpy==5.0.1                    # Python 3.11
    lobes bake bake/tests/room.toml -o room.glb --density 40 --as lightmap
    lobes bake bake/tests/room.toml -o fine.glb --density 40 --as lightmap --samples 4 --tolerance 0.0005
    python bake/tests/race.py room.glb fine.lightmap0.exr 8 32 128 -- room.lightmap0.exr

Errors are mean absolute differences from the second file over its mean, at texels whose eight neighbours are lit as well.
"""

import math
import sys
import time

import bpy
import numpy as np
from mathutils import Matrix, Vector

numbers = sys.argv[1:]
maps = numbers[numbers.index("--") + 1 :] if "--" in numbers else []
glb, fine, *samples = numbers[: numbers.index("--")] if "--" in numbers else numbers


def load(path):
    """The pixels of an image, row by row from the top."""
    image = bpy.data.images.load(path)
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(height, width, 4)[::-1, :, :3].copy()


def up(v):
    """From y up to z up."""
    return Vector((v[0], -v[2], v[1]))


def add(name, light, radiance, area):
    """A light of a radiance, whose power is that of a diffuse emitter: π · area · radiance."""
    most = max(radiance)
    light.color, light.energy = [c / most for c in radiance], math.pi * area * most
    lamp = bpy.data.objects.new(name, light)
    bpy.context.scene.collection.objects.link(lamp)
    return lamp


def rectangle(center, u, v, radiance):
    """Shines along u × v; Blender's along its −z."""
    light = bpy.data.lights.new("rectangle", "AREA")
    light.shape = "RECTANGLE"
    u, v = up(u), up(v)
    light.size, light.size_y = 2 * u.length, 2 * v.length
    lamp = add("rectangle", light, radiance, 4 * u.length * v.length)
    x, y = u.normalized(), v.normalized()
    matrix = Matrix((x, -y, -x.cross(y))).transposed().to_4x4()
    matrix.translation = up(center)
    lamp.matrix_world = matrix


def sphere(center, radius, radiance):
    light = bpy.data.lights.new("sphere", "POINT")
    light.shadow_soft_size = radius
    add("sphere", light, radiance, 4 * math.pi * radius**2).location = up(center)


bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=glb)
scene = bpy.context.scene
scene.render.engine, scene.cycles.device = "CYCLES", "CPU"
scene.render.threads_mode, scene.render.threads = "FIXED", 2
scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
scene.cycles.max_bounces = 0
# The lights of room.toml.
rectangle((0.2, 2.45, 0.1), (0.45, 0, 0), (0, 0, 0.3), (9.0, 8.0, 6.6))
rectangle((-2.6, 1.5, -0.2), (0, 0, -0.9), (0, 0.7, 0), (5.0, 6.6, 9.0))
sphere((1.45, 1.62, -1.80), 0.06, (60.0, 36.0, 14.0))

# Irradiance over π, as Cycles bakes it.
fine = load(fine) / math.pi
height, width = fine.shape[:2]
target = bpy.data.images.new("bake", width, height, float_buffer=True, is_data=True)
for thing in bpy.data.objects:
    thing.select_set(False)
meshes = [thing for thing in bpy.data.objects if thing.type == "MESH"]
for thing in meshes:
    thing.data.uv_layers.active_index = len(thing.data.uv_layers) - 1
    for slot in thing.material_slots:
        nodes = slot.material.node_tree.nodes
        nodes.active = nodes.new("ShaderNodeTexImage")
        nodes.active.image = target
    thing.select_set(True)
bpy.context.view_layer.objects.active = meshes[0]
bake = scene.render.bake
bake.use_pass_direct, bake.use_pass_indirect, bake.use_pass_color, bake.margin = True, False, False, 0

results = []
for count in map(int, samples):
    scene.cycles.samples = count
    start = time.process_time()
    bpy.ops.object.bake(type="DIFFUSE")
    seconds = time.process_time() - start
    pixels = np.empty(width * height * 4, np.float32)
    target.pixels.foreach_get(pixels)
    results.append((f"Cycles, {count} samples: {seconds:.1f} s", pixels.reshape(height, width, 4)[::-1, :, :3].copy()))
inside = results[-1][1].sum(2) > 0
for shift in [(x, y) for x in (-1, 0, 1) for y in (-1, 0, 1)]:
    inside = inside & np.roll(results[-1][1].sum(2) > 0, shift, (0, 1))
for name, pixels in results + [(path, load(path) / math.pi) for path in maps]:
    error = np.abs(pixels - fine)[inside].mean() / fine[inside].mean()
    print(f"{name}: mean error {100 * error:.2f} % at {inside.sum()} texels")
