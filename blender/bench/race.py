"""Figures of docs/blender.md: python blender/bench/race.py [FOLDER]. Races F12 against Cycles at equal error, in processor seconds, and
writes a picture of both. Run it in a Python that has bpy, with the release build of the package.
"""

import sys
import time
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parents[1] / "tests"), str(Path(__file__).parents[1])]

import bpy
import numpy as np

import cosine_lobes as cl
import cosine_lobes_engine
import stage

SIZE = (160, 90)
#: Pixels of the picture, and the samples of Cycles.
PICTURE, SAMPLES = (240, 170), 64


def cube_and_square(width, height):
    stage.reset(width, height)
    stage.plane(10, look=stage.material(Base_Color=(0.8, 0.8, 0.8)))
    stage.camera((2.4, -3.2, 2.2), (0, 0, 0.4))
    stage.cube(look=stage.material(Base_Color=(0.8, 0.3, 0.2)))
    stage.lamp("AREA", (1.5, 1, 3), energy=200, size=1)


def monkey_and_lamp(width, height):
    stage.reset(width, height)
    stage.plane(10, look=stage.material(Base_Color=(0.8, 0.8, 0.8)))
    stage.camera((1.6, -2.6, 1.8), (0, 0, 0.5))
    monkey((0, 0, 0.72))
    stage.lamp("POINT", (1, -1.2, 3), energy=300, shadow_soft_size=0.3)


def monkey(location, look=None):
    bpy.ops.mesh.primitive_monkey_add(size=1.3, location=location, rotation=stage.degrees(-20, 0, 25))
    made = bpy.context.object
    made.data.materials.append(look or stage.material("monkey", Base_Color=(0.75, 0.5, 0.25)))
    made.modifiers.new("smooth", "SUBSURF").render_levels = made.modifiers["smooth"].levels = 2
    made.data.shade_smooth()
    return made


def checks(n=256):
    y, x = np.mgrid[0:n, 0:n] * 8 // n
    tiles = ((x + y) % 2)[..., None]
    color = tiles * [0.75, 0.72, 0.66] + (1 - tiles) * [0.32, 0.38, 0.42]
    image = bpy.data.images.new("tiles", n, n)
    image.pixels.foreach_set(np.concatenate([color, np.ones((n, n, 1))], axis=2).astype(np.float32).ravel())
    image.update()
    return image


def still_life(width, height):
    """Materials and lights of several kinds: the picture of the guide."""
    stage.reset(width, height)
    floor = stage.plane(8, stage.material("floor", Roughness=0.5, Specular_IOR_Level=0.5), name="floor")
    floor.data.uv_layers.new(name="uv").uv.foreach_set("vector", [0, 0, 3, 0, 3, 3, 0, 3])
    tree = floor.data.materials[0].node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = checks()
    tree.links.new(node.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
    wall = stage.plane(8, stage.material("wall", Base_Color=(0.7, 0.68, 0.62)), (0, 2, 0), "wall")
    wall.rotation_euler = stage.degrees(90, 0, 0)
    monkey((-0.15, 0.2, 0.74), stage.material("clay", Base_Color=(0.7, 0.33, 0.2), Roughness=0.6, Specular_IOR_Level=0.5))
    stage.sphere(0.42, stage.material("gold", Base_Color=(0.9, 0.65, 0.3), Roughness=0.35, Metallic=1.0), (1.15, -0.35, 0.42), 192, 96)
    stage.sphere(0.32, stage.material("plastic", Base_Color=(0.1, 0.3, 0.6), Roughness=0.3, Specular_IOR_Level=0.5), (-1.3, -0.5, 0.32), 192, 96)
    stage.lamp("AREA", (-2, -1.5, 3), (0, 0, 0.5), energy=160, shape="RECTANGLE", size=1.6, size_y=0.5)
    stage.lamp("SPOT", (2.2, -1.8, 2.6), (0.4, 0, 0.3), energy=260, spot_size=0.8, spot_blend=0.4, shadow_soft_size=0.15, color=(1, 0.75, 0.5))
    stage.world((0.03, 0.04, 0.06))
    stage.camera((0.4, -4.2, 1.9), (0, 0.3, 0.62), lens=42)


def timed(engine):
    start = time.process_time()
    picture = stage.render(engine)
    return picture, time.process_time() - start


def penumbra():
    """Pixels that see a part of the lights."""
    made, view = stage.live()
    layers = made.renderer.layers(["unshadowed"], window=view.window)
    part = layers["beauty"].mean(axis=2) / np.maximum(layers["unshadowed"].mean(axis=2), 1e-9)
    return (part > 0.02) & (part < 0.98)


def race(name, make):
    """A row: processor seconds of F12 here, and of Cycles until its noise in penumbrae is 1 %."""
    make(*SIZE)
    cycles, where = bpy.context.scene.cycles, stage.inside() & penumbra()
    ours, seconds = timed("COSINE_LOBES")
    cycles.samples = SAMPLES
    pictures = []
    for cycles.seed in (1, 2, 3, 4):
        pictures.append(timed("CYCLES"))
    others = np.mean([time for _, time in pictures])
    # Pictures of Cycles differ by √2 times the noise of one; their mean has half of it.
    noise = stage.error(pictures[0][0], pictures[1][0], where) / np.sqrt(2)
    error = stage.error(ours, np.mean([picture for picture, _ in pictures], axis=0), where)
    needed = others * (noise / 0.01) ** 2
    print(f"| {name} | {100 * error:.2f} % | {50 * noise:.2f} % | {seconds:.2f} s | {needed:.1f} s | {needed / seconds:.0f} |", flush=True)


def picture(folder):
    """Both engines' pictures of the still life, side by side, with the same exposure and sRGB."""
    still_life(*PICTURE)
    scene = bpy.context.scene
    scene.cosine_lobes.samples = 0
    scene.cycles.samples = SAMPLES
    ours, seconds = timed("COSINE_LOBES")
    theirs, others = timed("CYCLES")
    print(f"still life: {seconds:.1f} s, and {others:.1f} s with {SAMPLES} samples", flush=True)
    both = np.concatenate([ours[..., :3], np.ones((PICTURE[1], 6, 3), np.float32), theirs[..., :3]], axis=1)
    cl.write_png(folder / "blender.png", np.ascontiguousarray(both), tone="linear")


if __name__ == "__main__":
    cosine_lobes_engine.register()
    target = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    print("| scene | difference | noise in it | F12 | Cycles | ratio |\n|---|---|---|---|---|---|", flush=True)
    race("cube, square light", cube_and_square)
    race("monkey of 15 744 triangles, lamp", monkey_and_lamp)
    if "--race" not in sys.argv:
        picture(target)
