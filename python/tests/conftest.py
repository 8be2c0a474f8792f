"""What several tests use."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

import cosine_lobes as cl

ROOT = Path(__file__).resolve().parents[2]
SCENES = ROOT / "scenes"


def command() -> Path:
    """The command `lobes` of this repository: that of LOBES, or the one that is built."""
    return Path(os.environ.get("LOBES", ROOT / "target" / "debug" / "lobes"))


@pytest.fixture(scope="session")
def lobes():
    """Runs the command."""
    path = command()
    if not path.is_file():
        pytest.skip(f"{path} is not built (cargo build)")

    def run(*arguments: object) -> str:
        words = [str(path), *map(str, arguments)]
        done = subprocess.run(words, check=False, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


def quad(center, u, v):
    """Positions and triangles of a parallelogram."""
    center, u, v = (np.asarray(x, np.float32) for x in (center, u, v))
    positions = np.stack([center - u - v, center + u - v, center + u + v, center - u + v])
    return positions, np.array([[0, 1, 2], [0, 2, 3]], np.int32)


def cube(center=(0.0, 0.5, 0.0), size=1.0):
    """Positions and triangles of a cube."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float32)
    positions = corners * np.float32(0.5 * size) + np.asarray(center, np.float32)
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return positions, np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))], np.int64)


CAMERA = cl.Camera((1.5, 2.0, 4.0), (0, 0.4, 0), fov=40)


def stage(size=(48, 32)) -> cl.Scene:
    """A cube and a sphere on a floor, under a sphere light and a rectangle."""
    scene = cl.Scene(size=size, camera=CAMERA)
    scene.add_mesh(*quad((0, 0, 0), (4, 0, 0), (0, 0, -4)), name="floor", visibility="none")
    red = cl.Material.metallic_roughness((0.8, 0.2, 0.1), metallic=0.0, roughness=0.4, ior=1.5)
    scene.add_mesh(*cube(), name="cube", material=red)
    scene.add_spheres(np.array([[1.2, 0.4, 0.3, 0.4]]), name="sphere")
    scene.add_light(cl.Light.sphere((-2, 3, 1), 0.4, radiance=40))
    scene.add_light(cl.Light.rectangle((2, 2.5, 0), (0, 0, 0.5), (0.4, 0.4, 0), radiance=(3, 4, 5), two_sided=True))
    return scene


@pytest.fixture
def scene() -> cl.Scene:
    return stage()
