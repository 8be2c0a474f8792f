"""A light moves along a line above a scene: one renderer, one picture a place, nothing is built twice.

    python light_sweep.py [SCENE] [-n 24] [-o FOLDER]
"""

import argparse
import time
from pathlib import Path

import numpy as np

import cosine_lobes as cl


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("scene", nargs="?", type=Path, help="scene file or model; the built-in scene when left out")
    parser.add_argument("-n", "--pictures", type=int, default=24)
    parser.add_argument("-o", "--output", type=Path, default=Path("sweep"))
    parser.add_argument("--size", type=int, nargs=2, default=(640, 360))
    parser.add_argument("--reach", type=float, default=2.0, help="length of the line, in units of the scene")
    options = parser.parse_args()

    size = (options.size[0], options.size[1])
    scene = cl.Scene.load(options.scene, size=size) if options.scene else cl.Scene.builtin(size=size)
    renderer = cl.Renderer(scene)
    options.output.mkdir(parents=True, exist_ok=True)

    lamp = renderer.lights[0]
    start = renderer.light(lamp)
    picture = renderer.render()
    exposure, before = renderer.exposure(), renderer.upkeep
    watch = time.perf_counter()
    for number, shift in enumerate(np.linspace(-0.5, 0.5, options.pictures)):
        renderer.set_light(lamp, start.shifted((shift * options.reach, 0, 0)))
        renderer.render(out=picture)
        cl.write_png(options.output / f"sweep.{number:04}.png", picture, exposure=exposure)
    seconds = time.perf_counter() - watch

    built = {name: count - before[name] for name, count in renderer.upkeep.items() if count != before[name]}
    print(f"{options.pictures} pictures in {seconds:.2f} s, {1e3 * seconds / options.pictures:.0f} ms each with the file")
    print(f"built anew since the first picture: {built or 'nothing'}")


if __name__ == "__main__":
    main()
