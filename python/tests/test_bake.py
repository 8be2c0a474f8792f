"""Baked light: files as the command bakes them, and maps of meshes."""

import json

import numpy as np
import pytest

import cosine_lobes as cl
from conftest import CAMERA, quad, stage

ROOM = """
[image]
width = 32
height = 24
[camera]
eye = [0, 3, 5]
target = [0, 0, 0]
[[lights]]
kind = "sphere"
center = [0, 3, 0]
radius = 0.1
radiance = 100
[[objects]]
name = "floor"
quad = { center = [0, 0, 0], u = [2, 0, 0], v = [0, 0, -2] }
[[objects]]
name = "card"
quad = { center = [0, 0.5, 0], u = [0.3, 0, 0], v = [0, 0, -0.3] }
keys = [{ time = 0 }, { time = 2, translate = [1, 0, 0] }]
"""


@pytest.mark.filterwarnings("ignore::cosine_lobes.LobesWarning")
@pytest.mark.parametrize(
    "options",
    [
        {"page": 64},
        {"page": 64, "form": "lightmap", "per_light": True, "both_sides": True, "samples": 1, "time": 1.0},
        {"form": "vertex-colors", "subdivide": 0.1, "vertices": 900, "tolerance": 0.02},
    ],
    ids=lambda options: options.get("form", "emission"),
)
def test_files_are_those_of_the_command(lobes, tmp_path, options):
    path = tmp_path / "room.toml"
    path.write_text(ROOM)
    words = []
    for name, value in options.items():
        words += [f"--{'as' if name == 'form' else name.replace('_', '-')}", *([] if value is True else [value])]
    said = json.loads(lobes("bake", path, "-o", tmp_path / "out.glb", "--json", "--quiet", *words))
    names = sorted(file.name for file in tmp_path.glob("out.*"))
    theirs = [(tmp_path / name).read_bytes() for name in names]
    for name in names:
        (tmp_path / name).unlink()
    heard = []
    report = cl.bake(path, tmp_path / "out.glb", **options, progress=lambda stage, done: heard.append((stage, done)))
    assert sorted(file.name for file in tmp_path.glob("out.*")) == names
    assert [(tmp_path / name).read_bytes() for name in names] == theirs
    assert report == {key: value for key, value in said.items() if not key.endswith("_seconds")}
    assert heard[-1][0] == "light" and all(0 <= done <= 1 for _, done in heard)


@pytest.mark.filterwarnings("ignore::cosine_lobes.LobesWarning")
def test_what_cannot_be_baked_is_refused(tmp_path):
    path = tmp_path / "room.toml"
    path.write_text(ROOM)
    for options, fault in [
        ({"form": "texture"}, "form is \"texture\": expected one of emission, lightmap, vertex-colors"),
        ({"page": 8}, "page is 8: expected 16 to 16384 texels a side"),
        ({"page": 16384, "per_light": True}, "take"),
        ({"tolerance": float("nan")}, "tolerance is NaN"),
        ({"time": 3.0}, "time is 3: expected seconds from 0 to 2"),
        ({"normals": "flat"}, "normals is \"flat\": expected one of file, face, smooth"),
        ({"subdivide": 0.1}, "colours of vertices, which alone are subdivided"),
        ({"output": tmp_path / "out.png"}, "the name must end in .glb"),
        ({"output": tmp_path / "none" / "out.glb"}, "out.glb"),
    ]:
        with pytest.raises((ValueError, cl.LobesError), match=fault):
            cl.bake(path, options.pop("output", tmp_path / "out.glb"), **options)
    dark = tmp_path / "dark.glb"
    dark.write_bytes(b"no model")
    with pytest.raises(ValueError, match="both read and written"):
        cl.bake(dark, tmp_path / "." / "dark.glb")
    with pytest.raises(cl.SceneError, match="dark.glb"):
        cl.bake(dark, tmp_path / "out.glb")
    assert sorted(file.name for file in tmp_path.iterdir()) == ["dark.glb", "room.toml"]

    def stop(stage, done):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        cl.bake(path, tmp_path / "out.glb", page=256, progress=stop)
    assert not (tmp_path / "out.glb").exists()


def lit(*lights):
    """A renderer of a floor far below with these lights."""
    scene = cl.Scene(size=(8, 8), camera=CAMERA)
    scene.add_mesh(*quad((0, -9, 0), (1, 0, 0), (0, 0, -1)))
    for light in lights:
        scene.add_light(light)
    return cl.Renderer(scene)


UNIT = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], np.float32)


def test_a_map_of_a_floor_by_its_closed_form():
    renderer = lit(cl.Light.point((0.3, 1, 0), intensity=5, radius=1e-3), cl.Light.sun((0, -1, 0), irradiance=2, angle=0.1))
    positions, triangles = quad((0, 0, 0), (2, 0, 0), (0, 0, -1))
    made = renderer.bake(positions, triangles, UNIT, (48, 24), per_light=True)
    light = made["irradiance"]
    assert light.shape == (24, 48, 3) and light.dtype == np.float32
    assert made["covered"].shape == (24, 48) and made["covered"].dtype == bool and made["covered"].all()
    assert made["overlaps"] == 0 and made["beyond"] == 0
    # The upper row is at the far side, z = −1.
    x, z = (np.arange(96) + 0.5) / 24 - 2, (np.arange(48) + 0.5) / 24 - 1
    point = 5 / (1 + (x[None, :] - 0.3) ** 2 + z[:, None] ** 2) ** 1.5
    want = point.reshape(24, 2, 48, 2).mean(axis=(1, 3)) + 2
    assert np.allclose(light[..., 0], want, rtol=3e-3)
    assert np.allclose(made["light0"] + made["light1"], light, rtol=1e-5)
    # From below nothing is lit.
    assert renderer.bake(positions, triangles[:, ::-1].copy(), UNIT, (8, 8))["irradiance"].max() == 0


def test_texels_are_of_the_mesh_alone_and_faults_are_counted():
    renderer = lit(cl.Light.sun((0, -1, 0), irradiance=3, angle=0.1))
    positions, triangles = quad((0, 0, 0), (1, 0, 0), (0, 0, -1))
    half = UNIT * np.float32(0.5)
    made = renderer.bake(positions, triangles, half, (32, 32), padding=3)
    assert made["covered"].sum() == 256 and made["covered"][:16, :16].all()
    near = np.zeros((32, 32), bool)
    near[:19, :19] = True
    # As bright at the edge as inside, and three texels further.
    assert np.allclose(made["irradiance"][near], 3, rtol=2e-3) and (made["irradiance"][~near] == 0).all()
    twice = np.concatenate([triangles, triangles])
    made = renderer.bake(positions, twice, 3 * half, (32, 32))
    assert made["beyond"] == 4 and made["overlaps"] == 1024


def test_a_callback_that_raises_stops_a_map():
    renderer = lit(cl.Light.point((0, 1, 0), intensity=1, radius=0.1))
    positions, triangles = quad((0, 0, 0), (1, 0, 0), (0, 0, -1))
    heard = []

    def stop(stage, done):
        heard.append((stage, done))
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        renderer.bake(positions, triangles, UNIT, (2048, 2048), progress=stop)
    assert len(heard) == 1 and heard[0][0] == "light" and heard[0][1] < 1
    # It works on.
    assert renderer.bake(positions, triangles, UNIT, (8, 8))["irradiance"].max() > 0


def test_both_sides_of_a_seam_are_alike():
    renderer = lit(cl.Light.point((0, 0.5, 0), intensity=1, radius=1e-3))
    positions, _ = quad((0, 0, 0), (1, 0, 0), (0, 0, -1))
    # Two charts for the halves of a square, of unlike sizes.
    positions = positions[[0, 1, 2, 0, 2, 3]]
    uvs = np.array([[0.05, 0.05], [0.45, 0.07], [0.43, 0.44], [0.55, 0.95], [0.92, 0.55], [0.95, 0.96]], np.float32)
    made = renderer.bake(positions, np.array([[0, 1, 2], [3, 4, 5]]), uvs, (32, 32))

    def filtered(uv):
        x, y = uv * 32 - 0.5
        i, j = int(x), int(y)
        a, b = x - i, y - j
        t = made["irradiance"][..., 0]
        return (t[j, i] * (1 - a) + t[j, i + 1] * a) * (1 - b) + (t[j + 1, i] * (1 - a) + t[j + 1, i + 1] * a) * b

    ends = np.linspace(0, 1, 41)[:, None]
    one, other = (uvs[a] + (uvs[b] - uvs[a]) * ends for a, b in ((0, 2), (3, 4)))
    values = np.array([[filtered(p), filtered(q)] for p, q in zip(one, other)])
    assert np.abs(values[:, 0] - values[:, 1]).mean() < 0.01 * values.mean()


def test_an_object_of_the_scene_is_baked_with_its_shadows():
    renderer = cl.Renderer(stage())
    positions, triangles = quad((0, 0, 0), (4, 0, 0), (0, 0, -4))
    made = renderer.bake(positions, triangles, UNIT, (64, 64), object="floor", normals=np.tile([0.0, 1.0, 0.0], (4, 1)))
    # Under the cube no light is; beside it a texel far from shadows is as points are.
    x = (np.arange(64) + 0.5) / 8 - 4
    place = np.array([[x[50], 0, x[50]]])
    point = np.pi * renderer.shade(place, np.array([[0.0, 1.0, 0.0]]))[0]
    assert np.allclose(made["irradiance"][50, 50], point, rtol=0.02)
    assert made["irradiance"].min() < 0.2 * point.min()


@pytest.mark.parametrize(
    "change, fault",
    [
        ({"size": (0, 8)}, "size is 0 x 8: expected 1 to 16384 texels a side"),
        ({"size": (16384, 16384), "per_light": True}, "expected a map that takes at most 4 GB"),
        ({"samples": 9}, "points along a texel is 9: expected 1 to 8"),
        ({"padding": 300}, "padding is 300: expected at most 256 texels"),
        ({"uvs": UNIT[:3]}, "uvs has 3 rows: expected 4"),
        ({"uvs": UNIT * np.nan}, r"uvs\[0\] is \[NaN, NaN\]"),
        ({"uvs": UNIT.astype(np.int32)}, "uvs has dtype int32"),
        ({"positions": np.zeros((4, 3))}, "none has an area"),
        ({"object": "nothing"}, "nothing"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
@pytest.mark.filterwarnings("ignore::cosine_lobes.LobesWarning")
def test_wrong_maps_are_refused_by_name(change, fault):
    positions, triangles = quad((0, 0, 0), (1, 0, 0), (0, 0, -1))
    given = {"positions": positions, "triangles": triangles, "uvs": UNIT, "size": (8, 8)} | change
    with pytest.raises((ValueError, TypeError, KeyError, cl.LobesError), match=fault):
        lit(cl.Light.ambient(1)).bake(**given)

