"""The same bits as the command's files."""

import json
import subprocess

import numpy as np
import pytest

import cosine_lobes as cl
from conftest import SCENES, command

SIZE = (48, 27)
FILES = [SCENES / f"{name}.toml" for name in ("soft_spheres", "lights", "sky", "textures", "window-room")]
OPTIONS = [{"visibility": "rays", "samples": 2}, {"tolerance": 0.05}, {"method": "lobes", "threshold": 0.01}]
CASES = [(path, {}) for path in FILES] + [(FILES[0], options) for options in OPTIONS]


def assert_channels(path, names, image):
    """Compares channels of an OpenEXR file as the library of others reads them, where that is installed."""
    try:
        import OpenEXR
    except ImportError:
        return
    own = OpenEXR.File(str(path), separate_channels=True).channels()
    pixels = np.stack([own[name].pixels for name in names], axis=-1)
    assert np.array_equal(image, pixels.reshape(image.shape)), names


@pytest.mark.parametrize("path, options", CASES, ids=str)
def test_pictures_are_those_of_the_command(lobes, tmp_path, path, options):
    words = [word for name, value in options.items() for word in (f"--{name}", value)]
    file = tmp_path / "picture.exr"
    lobes("render", path, "--size", "48x27", "-o", file, "--quiet", *words)
    picture = cl.Renderer(cl.Scene.load(path, size=SIZE), **options).render()
    assert picture.dtype == np.float32 and picture.shape == (27, 48, 3)
    assert np.array_equal(picture, cl.read_exr(file))
    assert_channels(file, "RGB", picture)
    assert picture.max() > 0


def test_layers_are_those_of_the_command(lobes, tmp_path):
    path, file = FILES[0], tmp_path / "picture.exr"
    lobes("render", path, "--size", "48x27", "-o", file, "--layers", "--quiet")
    renderer = cl.Renderer(cl.Scene.load(path, size=SIZE))
    layers = renderer.layers()
    assert np.array_equal(layers["beauty"], cl.read_exr(file))
    assert np.array_equal(layers["beauty"], renderer.render())
    for name in ["unshadowed", *(f"light{i}" for i in range(len(renderer.lights)))]:
        assert np.array_equal(layers[name], cl.read_exr(file, layer=name)), name
        assert_channels(file, [f"{name}.{c}" for c in "RGB"], layers[name])
    assert_channels(file, [f"normal.{c}" for c in "XYZ"], layers["normal"])
    for name, letter in [("depth", "Z"), ("lobes", "N"), ("products", "N")]:
        assert_channels(file, [f"{name}.{letter}"], layers[name])
    assert np.array_equal(renderer.unshadowed(), layers["unshadowed"])
    assert set(renderer.layers(["depth", "object"])) == {"beauty", "depth", "object"}


MODEL = """
v 1 0 0
v -1 0 0
v 0 1 0
v 0 -1 0
v 0 0 1
v 0 0 -1
s off
f 1 3 5
f 3 2 5
f 2 4 5
f 4 1 5
f 3 1 6
f 2 3 6
f 4 2 6
f 1 4 6
"""
LOADS = [
    {"normals": "smooth"},
    {"normals": "smooth", "crease": 60.0},
    {"normals": "smooth", "terminator": "smooth"},
    {"normals": "face", "studio": "key"},
]


def test_models_are_loaded_as_the_command_loads_them(lobes, tmp_path):
    model, file = tmp_path / "model.obj", tmp_path / "picture.exr"
    model.write_text(MODEL)
    pictures = []
    for options in LOADS:
        words = [word for name, value in options.items() for word in (f"--{name}", value)]
        lobes("render", model, "--size", "32x24", "-o", file, "--quiet", *words)
        pictures.append(cl.Renderer(cl.Scene.load(model, size=(32, 24), **options)).render())
        assert np.array_equal(pictures[-1], cl.read_exr(file)), options
    # Each of them has a say.
    assert all(not np.array_equal(a, b) for i, a in enumerate(pictures) for b in pictures[:i])


def test_emission_is_seen_alone_or_lights_others(lobes, tmp_path):
    path, file = tmp_path / "lamp.toml", tmp_path / "picture.exr"
    path.write_text(
        "[camera]\neye = [0, 2, 5]\ntarget = [0, 0, 0]\n[materials.lamp]\nmodel = \"lambert\"\nalbedo = 0\nemission = 9\n"
        "[[lights]]\nkind = \"sphere\"\ncenter = [3, 3, 3]\nradius = 0.2\nradiance = 9\n"
        "[[objects]]\nquad = { center = [0, 0, 0], u = [3, 0, 0], v = [0, 0, -3] }\n"
        "[[objects]]\nquad = { center = [0, 1, 0], u = [0.5, 0, 0], v = [0, 0, 0.5] }\nmaterial = \"lamp\"\n"
    )
    means = []
    for emission in ("lights", "seen"):
        lobes("render", path, "--size", "32x24", "-o", file, "--quiet", "--emission", emission)
        picture = cl.Renderer(cl.Scene.load(path, size=(32, 24), emission=emission)).render()
        assert np.array_equal(picture, cl.read_exr(file))
        means.append(picture.mean())
    assert means[0] > 1.1 * means[1]


@pytest.mark.parametrize(
    "options, fault",
    [
        ({"normals": "flat"}, "normals is \"flat\": expected one of file, face, smooth"),
        ({"crease": 0}, "crease is 0: expected degrees above 0, at most 180"),
        ({"crease": 181}, "crease is 181: expected a number from 0 to 180"),
        ({"terminator": "soft"}, "terminator is \"soft\": expected one of exact, smooth"),
        ({"emission": "glows"}, "emission is \"glows\": expected one of lights, seen"),
        ({"studio": "dark"}, "studio is \"dark\": expected one of soft, key"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_wrong_choices_of_loading_are_refused_by_name(options, fault):
    with pytest.raises(ValueError, match=fault):
        cl.Scene.load(FILES[0], **options)


def test_the_built_in_scene_and_its_exposure(lobes, tmp_path):
    file, png = tmp_path / "picture.exr", tmp_path / "own.png"
    lobes("render", "--size", "48x27", "-o", file, "-o", tmp_path / "picture.png", "--quiet")
    renderer = cl.Renderer(cl.Scene.builtin(size=SIZE))
    picture = renderer.render()
    assert np.array_equal(picture, cl.read_exr(file))
    cl.write_png(png, picture, exposure=renderer.exposure())
    assert png.read_bytes() == (tmp_path / "picture.png").read_bytes()
    bytes_ = cl.exposed(picture, exposure=renderer.exposure())
    assert bytes_.dtype == np.uint8 and bytes_.shape == picture.shape


def test_the_reference_is_that_of_the_command(lobes, tmp_path):
    path, file = FILES[0], tmp_path / "reference.exr"
    lobes("reference", path, "--size", "16x9", "--spp", 16, "--samples", 1, "-o", file, "--quiet")
    done = []
    pictures = cl.reference(
        cl.Scene.load(path, size=(16, 9)), spp=16, samples=1, progress=lambda stage, part: done.append((stage, part))
    )
    assert np.array_equal(pictures["beauty"], cl.read_exr(file))
    for name in ["unshadowed", "stderr"]:
        assert np.array_equal(pictures[name], cl.read_exr(file, layer=name)), name
    assert done and done[-1] == ("sampling", 1.0)


def test_comparisons_are_those_of_the_command(lobes, tmp_path):
    renderer = cl.Renderer(cl.Scene.builtin(size=SIZE), tolerance=0.1)
    rough, unshadowed = renderer.render(), renderer.unshadowed()
    renderer.set_settings(tolerance=0.001)
    fine = renderer.render()
    for name, picture in [("rough", rough), ("fine", fine), ("unshadowed", unshadowed)]:
        cl.write_exr(tmp_path / f"{name}.exr", picture)
        assert np.array_equal(cl.read_exr(tmp_path / f"{name}.exr"), picture)
    files = [tmp_path / f"{name}.exr" for name in ("rough", "fine", "unshadowed")]
    text = lobes("compare", *files[:2], "--unshadowed", files[2], "--json")
    report = cl.compare(rough, fine, unshadowed=unshadowed)
    assert report == json.loads(text)
    assert 0 < report["mae"] < report["max"] and report["penumbra"]["pixels"] > 0
    assert cl.compare(fine, fine)["mae"] == 0


def test_animations_are_those_of_the_command(lobes, tmp_path):
    text = """
[image]
width = 32
height = 18
[camera]
eye = [0, 2, 8]
target = [0, 1, 0]
[[lights]]
kind = "sphere"
center = [0, 5, 1]
radius = 1
radiance = 9
[[objects]]
plane = { point = [0, 0, 0], normal = [0, 1, 0] }
[[objects]]
name = "roll"
sphere = { center = [0, 1, 0], radius = 1 }
keys = [{ time = 0 }, { time = 1, translate = [2, 0, 0] }]
"""
    path, file = tmp_path / "roll.toml", tmp_path / "roll.exr"
    path.write_text(text)
    scene = cl.Scene.load(path)
    assert (scene.duration, scene.fps) == (1.0, 24.0)
    renderer = cl.Renderer(scene)
    for time in [0.25, 1.0]:
        lobes("render", path, "--time", time, "-o", file, "--quiet")
        renderer.seek(time)
        assert renderer.time == time
        assert np.array_equal(renderer.render(), cl.read_exr(file)), time
    with pytest.raises(cl.EditError, match='object "roll" is moved by the animation'):
        renderer.set_transform("roll", np.eye(4))


def test_refusals_have_the_lines_of_the_command(tmp_path):
    for name, text in [("a.toml", "x = 1"), ("b.obj", "v 1 2"), ("c.toml", '[[lights]]\nkind = "candle"\n')]:
        path = tmp_path / name
        path.write_text(text)
        if not command().is_file():
            pytest.skip("the command is not built")
        words = [str(command()), "render", str(path), "-o", str(tmp_path / "x.exr")]
        done = subprocess.run(words, check=False, capture_output=True, text=True)
        with pytest.raises(cl.SceneError) as refused:
            cl.Scene.load(path)
        message = str(refused.value)
        assert done.returncode == 2 and message in done.stderr and "\n" not in message
    with pytest.raises(cl.SceneError, match="cannot read"):
        cl.Scene.load(tmp_path / "missing.toml")
