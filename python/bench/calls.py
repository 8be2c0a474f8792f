"""Measures the calls of the package on a scene of arrays: a knot of 28 800 triangles on a floor, under a rectangle and a sphere light.

    python calls.py [--size 480 270]

Prints a table: the shortest of some repetitions, and what each call built anew.
"""

import argparse
import time
from typing import Callable

import numpy as np

import cosine_lobes as cl
from knot import FLOOR, knot


def shortest(work: Callable[[], object], repetitions: int = 7) -> float:
    best = np.inf
    for _ in range(repetitions):
        watch = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - watch)
    return 1e3 * best


def stage(size: tuple[int, int]) -> cl.Scene:
    scene = cl.Scene(size=size, camera=cl.Camera((2.4, 2.6, 4.2), (0, 0.55, 0), fov=38))
    scene.add_mesh(*FLOOR, name="floor", visibility="none")
    scene.add_mesh(*knot(), name="knot", smooth=True, material=cl.Material.metallic_roughness((0.8, 0.3, 0.2), metallic=0, roughness=0.4, ior=1.5))
    scene.add_light(cl.Light.sphere((-2, 3.5, 1.5), 0.5, radiance=20))
    scene.add_light(cl.Light.rectangle((2, 3, 0), (0, 0, 0.5), (0.4, 0.4, 0), radiance=5, two_sided=True))
    return scene


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--size", type=int, nargs=2, default=(480, 270))
    options = parser.parse_args()
    size = (options.size[0], options.size[1])
    rows: list[tuple[str, float, str]] = []

    def measure(name: str, work: Callable[[], object], repetitions: int = 7) -> None:
        before = renderer.upkeep
        milliseconds = shortest(work, repetitions)
        made = {key: (count - before[key]) / repetitions for key, count in renderer.upkeep.items() if count != before[key]}
        rows.append((name, milliseconds, ", ".join(f"{key.replace('_', ' ')} {count:g}" for key, count in made.items()) or "nothing"))

    watch = time.perf_counter()
    scene = stage(size)
    arrays = 1e3 * (time.perf_counter() - watch)
    renderer = cl.Renderer(scene)
    measure("the first picture", renderer.render, 1)
    picture = renderer.render()
    measure("the same picture again", renderer.render)
    measure("… into memory of the caller's (`out`)", lambda: renderer.render(out=picture))
    light, angle = renderer.light(0), iter(np.linspace(0, 1, 1000))

    def drag() -> None:
        renderer.set_light(0, light.shifted((next(angle), 0, 0)))
        renderer.render(out=picture)

    measure("a light moves", drag)

    def move() -> None:
        matrix = np.eye(4)
        matrix[0, 3] = 0.2 * next(angle)
        renderer.set_transform("knot", matrix)
        renderer.render(out=picture)

    measure("an object moves", move)

    def walk() -> None:
        renderer.set_camera(cl.Camera((2.4 + next(angle), 2.6, 4.2), (0, 0.55, 0), fov=38))
        renderer.render(out=picture)

    measure("the camera moves", walk)
    measure("all layers", renderer.layers)
    random = np.random.default_rng(1)
    points = np.stack([random.uniform(-2, 2, 100_000), np.zeros(100_000), random.uniform(-2, 2, 100_000)], axis=-1).astype(np.float32)
    normals = np.tile(np.array([0, 1, 0], np.float32), (100_000, 1))
    measure("100 000 points of the caller's, in no order", lambda: renderer.shade(points, normals), 3)
    measure("`compare` with FLIP", lambda: cl.compare(picture, picture), 3)

    print(f"{size[0]} x {size[1]} pixels, {scene.triangles} triangles; the scene from arrays took {arrays:.0f} ms\n")
    print("| call | ms | built anew |\n|---|---|---|")
    for name, milliseconds, made in rows:
        print(f"| {name} | {milliseconds:.1f} | {made} |")


if __name__ == "__main__":
    main()
