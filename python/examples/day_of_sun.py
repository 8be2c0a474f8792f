"""A day of sun in 24 frames: a courtyard of arrays, a sun on its path, and a sky that follows it.

    python day_of_sun.py [-o FOLDER] [--latitude 48] [--day 100]
"""

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import cosine_lobes as cl

Floats = NDArray[np.float64]


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> tuple[Floats, NDArray[np.int64]]:
    """Positions and triangles of a box."""
    x, y, z = (sorted(sides) for sides in zip(low, high))
    corners = np.array([[a, b, c] for a in x for b in y for c in z], dtype=np.float64)
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])


def courtyard(size: tuple[int, int]) -> cl.Scene:
    """A paved ground, three wings around it, a tower and columns; x is east, z is south."""
    scene = cl.Scene(size=size, camera=cl.Camera((26, 24, 34), (0, 1.5, 1), fov=32))
    ground = np.array([[-400.0, 0, -400], [400, 0, -400], [400, 0, 400], [-400, 0, 400]])
    triangles = np.array([[0, 2, 1], [0, 3, 2]])
    scene.add_mesh(ground, triangles, name="ground", material=cl.Material.lambert((0.42, 0.4, 0.37)), visibility="none")
    wall = scene.add_material(cl.Material.lambert((0.72, 0.66, 0.56)))
    for name, low, high in [
        ("north wing", (-11, 0, -9), (11, 5, -5)),
        ("west wing", (-11, 0, -5), (-7, 4, 8)),
        ("east wing", (7, 0, -5), (11, 4, 8)),
        ("tower", (-3, 5, -9), (3, 10, -5)),
    ]:
        scene.add_mesh(*box(low, high), name=name, material=wall)
    stone = scene.add_material(cl.Material.lambert(0.6))
    for x in np.linspace(-4.5, 4.5, 6):
        scene.add_mesh(*box((x - 0.3, 0, 3.7), (x + 0.3, 3, 4.3)), name="column", material=stone)
    scene.add_mesh(*box((-5.3, 3, 3.5), (5.3, 3.5, 4.5)), name="lintel", material=stone)
    return scene


def toward_sun(hour: float, latitude: float, day: int) -> Floats:
    """Unit direction toward the sun: east, up, south."""
    declination = np.radians(-23.44) * np.cos(2 * np.pi * (day + 10) / 365)
    angle, place = np.radians(15 * (hour - 12)), np.radians(latitude)
    up = np.sin(place) * np.sin(declination) + np.cos(place) * np.cos(declination) * np.cos(angle)
    south = np.sin(place) * np.cos(declination) * np.cos(angle) - np.cos(place) * np.sin(declination)
    return np.array([-np.cos(declination) * np.sin(angle), up, south])


def light_at(height: float) -> tuple[Floats, Floats]:
    """Irradiance of the sun, and radiance of the sky, by the sine of the sun's height: redder and darker toward the horizon."""
    depth = np.exp(-np.array([0.09, 0.17, 0.32]) / max(height + 0.03, 0.02))
    sky = np.array([0.10, 0.16, 0.28]) * (0.08 + 0.92 * np.clip(height * 3 + 0.3, 0, 1))
    return 4.0 * depth * np.clip(height * 20, 0, 1), sky


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("-o", "--output", type=Path, default=Path("day"))
    parser.add_argument("--size", type=int, nargs=2, default=(640, 360))
    parser.add_argument("--latitude", type=float, default=48.0)
    parser.add_argument("--day", type=int, default=100)
    parser.add_argument("-n", "--frames", type=int, default=24)
    options = parser.parse_args()

    scene = courtyard((options.size[0], options.size[1]))
    sun = cl.Light.sun((0, -1, 0), irradiance=1, angle=0.53)
    number = scene.add_light(sun)
    renderer = cl.Renderer(scene)
    options.output.mkdir(parents=True, exist_ok=True)
    # The hours of daylight, and a little of dusk.
    hours = np.linspace(0, 24, 24 * 60)
    bright = [hour for hour in hours if toward_sun(hour, options.latitude, options.day)[1] > -0.05]
    for frame, hour in enumerate(np.linspace(bright[0], bright[-1], options.frames)):
        toward = toward_sun(hour, options.latitude, options.day)
        irradiance, sky = light_at(toward[1])
        # Below the horizon the sun gives nothing.
        renderer.set_light(number, cl.Light.sun(-toward, irradiance=irradiance, angle=0.53))
        renderer.set_environment(cl.Environment(sky))
        cl.write_png(options.output / f"day.{frame:04}.png", renderer.render(), exposure=0.0)
        print(f"{int(hour):02}:{int(60 * (hour % 1)):02}  sun {np.degrees(np.arcsin(toward[1])):5.1f}° high")
    print(f"hierarchies built: {renderer.upkeep['hierarchy_builds']}, in {options.frames} frames")


if __name__ == "__main__":
    main()
