"""Scenes from arrays, their parts, and what is refused."""

import warnings

import numpy as np
import pytest

import cosine_lobes as cl
from conftest import CAMERA, SCENES, cube, quad, stage


def test_arrays_give_the_scene_of_a_file(tmp_path):
    text = """
[image]
width = 48
height = 32
[camera]
eye = [1.5, 2, 4]
target = [0, 0.4, 0]
fov = 40
[materials.red]
model = "metallic-roughness"
base = [0.8, 0.2, 0.1]
metallic = 0.0
roughness = 0.4
ior = 1.5
[[lights]]
kind = "sphere"
center = [-2, 3, 1]
radius = 0.4
radiance = 40
[[lights]]
kind = "rectangle"
center = [2, 2.5, 0]
u = [0, 0, 0.5]
v = [0.4, 0.4, 0]
radiance = [3, 4, 5]
two_sided = true
[[lights]]
kind = "sun"
direction = [-1, -2, 0.5]
irradiance = 2
angle = 2
[[lights]]
kind = "environment"
radiance = [0.1, 0.2, 0.3]
[[objects]]
quad = { center = [0, 0, 0], u = [4, 0, 0], v = [0, 0, -4] }
visibility = "none"
[[objects]]
box = { center = [0, 0.5, 0], size = [1, 1, 1] }
material = "red"
[[objects]]
sphere = { center = [1.2, 0.4, 0.3], radius = 0.4 }
"""
    path = tmp_path / "stage.toml"
    path.write_text(text)
    loaded = cl.Renderer(cl.Scene.load(path)).render()
    scene = stage()
    scene.add_light(cl.Light.sun((-1, -2, 0.5), irradiance=2, angle=2))
    scene.set_environment(cl.Environment((0.1, 0.2, 0.3)))
    own = cl.Renderer(scene).render()
    # The box of a file has other triangles; everything else is the same.
    assert np.allclose(own, loaded, rtol=2e-3, atol=2e-4)
    assert np.mean(own != loaded) < 0.5


def test_coats_and_terminators_are_those_of_a_file(tmp_path):
    text = """
[image]
width = 32
height = 24
[camera]
eye = [1.5, 2, 4]
target = [0, 0.4, 0]
fov = 40
[materials.paint]
model = "metallic-roughness"
base = [0.8, 0.2, 0.1]
metallic = 0.0
roughness = 0.5
clearcoat = 0.8
clearcoat_roughness = 0.2
[[objects]]
mesh = "octahedron.obj"
normals = "smooth"
material = "paint"
terminator = "smooth"
[[lights]]
kind = "sphere"
center = [4, 1.5, 1]
radius = 0.4
radiance = 40
"""
    corners = np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], np.float32)
    sides = np.array([(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)])
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in sides]
    (tmp_path / "octahedron.obj").write_text("\n".join(lines))
    (tmp_path / "paint.toml").write_text(text)
    loaded = cl.Renderer(cl.Scene.load(tmp_path / "paint.toml")).render()

    def own(**coat):
        scene = cl.Scene(size=(32, 24), camera=CAMERA)
        terminator = coat.pop("terminator", "smooth")
        paint = cl.Material.metallic_roughness((0.8, 0.2, 0.1), metallic=0, roughness=0.5, **coat)
        scene.add_mesh(corners, sides, smooth=True, material=paint, terminator=terminator)
        scene.add_light(cl.Light.sphere((4, 1.5, 1), 0.4, radiance=40))
        return cl.Renderer(scene).render()

    coat = {"clearcoat": 0.8, "clearcoat_roughness": 0.2}
    assert np.allclose(own(**coat), loaded, rtol=1e-3, atol=1e-4)
    assert not np.allclose(own(), loaded, rtol=1e-2, atol=1e-3)
    assert not np.allclose(own(terminator="exact", **coat), loaded, rtol=1e-2, atol=1e-3)


def test_from_arrays():
    floor, triangles = quad((0, 0, 0), (4, 0, 0), (0, 0, -4))
    positions, faces = cube()
    red = cl.Material.metallic_roughness((0.8, 0.2, 0.1), metallic=0.0, roughness=0.4, ior=1.5)
    scene = cl.Scene.from_arrays(
        [
            {"positions": floor, "triangles": triangles, "name": "floor", "visibility": "none"},
            {"positions": positions.astype(np.float64), "triangles": faces.astype(np.uint32), "material": red, "name": "cube"},
        ],
        lights=[cl.Light.sphere((-2, 3, 1), 0.4, radiance=40)],
        camera=CAMERA,
        size=(48, 32),
        background=(0.1, 0.1, 0.1),
        environment=cl.Environment(0.2),
    )
    assert scene.objects == ["floor", "cube"] and scene.triangles == 14 and scene.size == (48, 32)
    assert scene.lights[0].kind == "sphere" and scene.camera == CAMERA
    assert [material.model for material in scene.materials] == ["lambert", "metallic-roughness"]
    assert scene.background == pytest.approx((0.1, 0.1, 0.1))
    scene.validate()
    assert cl.Renderer(scene).render().mean() > 0.1
    with pytest.raises(TypeError, match="expected dictionaries of arguments of add_mesh"):
        cl.Scene.from_arrays([3], lights=[], camera=CAMERA)
    with pytest.raises(TypeError, match="colour"):
        cl.Scene.from_arrays([{"positions": floor, "triangles": triangles, "colour": 1}], lights=[], camera=CAMERA)


def test_a_renderer_copies_its_scene(scene):
    renderer = cl.Renderer(scene)
    first = renderer.render()
    scene.add_light(cl.Light.ambient(3))
    scene.size = (10, 10)
    assert np.array_equal(renderer.render(), first)


def test_arrays_of_any_strides_are_read(scene):
    positions, triangles = cube((-1.3, 0.3, 0.4), 0.6)
    wide = np.zeros((16, 6), np.float32)
    wide[::2, ::2] = positions
    turned = np.asfortranarray(triangles)
    scene.add_mesh(wide[::2, ::2], turned, name="block")
    same = stage()
    same.add_mesh(positions, triangles, name="block")
    assert np.array_equal(cl.Renderer(scene).render(), cl.Renderer(same).render())


def test_normals_colors_and_smooth_shading(scene):
    positions, triangles = cube((-1.3, 0.3, 0.4), 0.6)
    out = positions - positions.mean(axis=0)
    renderers = []
    for arguments in ({}, {"smooth": True}, {"normals": 9 * out}, {"colors": np.tile(np.float32([1, 0, 0]), (8, 1))}):
        scene = stage()
        scene.add_mesh(positions, triangles, uvs=np.zeros((8, 2)), **arguments)
        renderers.append(cl.Renderer(scene).render())
    flat, smooth, given, red = renderers
    assert not np.array_equal(flat, smooth)
    assert np.allclose(smooth, given, atol=0.05) and not np.array_equal(flat, red)


def test_spheres_block_for_a_mesh():
    positions, triangles = cube()
    spheres = cl.SphereSet.fit(positions, triangles, count=8, draft=True)
    pictures = []
    for given in (spheres, spheres.spheres):
        scene = stage()
        scene.add_mesh(*cube((-1.3, 0.3, 0.4), 0.6), spheres=given, visibility="spheres")
        pictures.append(cl.Renderer(scene, cache=False).render())
    assert np.array_equal(*pictures)


BAD_MESHES = [
    ({"positions": np.zeros((4, 3))}, "mesh has no triangles"),
    ({"positions": np.full((4, 3), np.nan)}, r"positions\[0\] is \[NaN, NaN, NaN\]: expected finite numbers"),
    ({"positions": np.zeros((4, 3), np.float16)}, "positions has dtype float16: expected float32, float64"),
    ({"positions": "cube"}, "positions is of type str"),
    ({"triangles": np.array([[0, 1, 4]])}, r"triangles\[0\] names a vertex that does not exist: there are 4"),
    ({"triangles": np.array([[0, 1, -1]])}, r"triangles\[0\] names a vertex that does not exist: there are 4"),
    ({"triangles": np.array([[0, 1, 2**40]])}, r"triangles\[0\] names a vertex"),
    ({"triangles": np.array([[0.0, 1.0, 2.0]])}, "triangles has dtype float64: expected int32, int64, uint32, uint64"),
    ({"triangles": np.array([0, 1, 2])}, r"triangles has shape \(3,\): expected \(n, 3\)"),
    ({"normals": np.zeros((4, 3))}, r"normals\[0\] is \[0, 0, 0\]: expected a direction"),
    ({"normals": np.ones((3, 3))}, "normals has 3 rows: expected 4"),
    ({"normals": np.ones((4, 3)), "smooth": True}, "normals are given: smooth has no say"),
    ({"uvs": np.zeros((4, 3))}, r"uvs has shape \(4, 3\): expected \(n, 2\)"),
    ({"colors": np.full((4, 3), 2.0)}, "colour 0 is"),
    ({"material": 5}, "material 5 is not in the scene: there are 0"),
    ({"material": "red"}, "material is of type str: expected a Material or a number"),
    ({"visibility": "magic"}, 'visibility is "magic": expected one of spheres, shadow-map'),
    ({"spheres": -1}, "spheres is -1: expected 0 to 100000"),
    ({"spheres": np.array([[0.0, 0, 0, -1]])}, r"spheres\[0\]: sphere has radius -1"),
    ({"spheres": "many"}, "spheres is of type str"),
    ({"positions": np.array([[0, 0, 0], [2e9, 0, 0], [0, 2e9, 0], [1, 1, 1]])}, "vertex 1 is .*: coordinates must lie within ±1e9"),
]


@pytest.mark.parametrize("change, fault", BAD_MESHES, ids=lambda value: None if isinstance(value, str) else "-".join(value))
@pytest.mark.filterwarnings("ignore::cosine_lobes.LobesWarning")
def test_wrong_meshes_are_refused_by_name(change, fault):
    positions, triangles = quad((0, 0, 0), (1, 0, 0), (0, 0, -1))
    scene = cl.Scene(size=(8, 8), camera=CAMERA)
    with pytest.raises((ValueError, TypeError, IndexError, cl.SceneError), match=fault):
        scene.add_mesh(**{"positions": positions, "triangles": triangles, **change})
    assert scene.objects == []
    renderer = cl.Renderer(stage())
    if "material" not in change:
        with pytest.raises((ValueError, TypeError, cl.SceneError), match=fault):
            renderer.add_mesh(**{"positions": positions, "triangles": triangles, **change})
        assert len(renderer.objects) == 3 and len(renderer.materials) == 2


def test_triangles_without_an_area_are_left_out_with_a_warning():
    positions, triangles = quad((0, 0, 0), (1, 0, 0), (0, 0, -1))
    scene = cl.Scene(camera=CAMERA)
    with pytest.warns(cl.LobesWarning, match="1 triangles without an area are left out"):
        scene.add_mesh(positions, np.concatenate([triangles, [[0, 0, 1]]]))
    assert scene.triangles == 2


def test_lights():
    sphere = cl.Light.sphere((0, 2, 0), 0.5, flux=np.pi)
    assert sphere.kind == "sphere" and sphere.center == (0, 2, 0) and sphere.size == 0.5 and sphere.direction is None
    assert sphere.radiance == pytest.approx(3 * (np.pi / (4 * np.pi**2 * 0.25),))
    assert sphere.shifted((1, 0, 0)).center == (1, 2, 0) and sphere.center == (0, 2, 0)
    assert sphere.resized(1).radiance == pytest.approx(tuple(np.array(sphere.radiance) / 4))
    assert sphere.with_radiance((1, 2, 3)).radiance == (1, 2, 3)
    disc = cl.Light.disc((0, 2, 0), (0, -2, 0), 0.5, radiance=1)
    assert disc.direction == (0, -1, 0)
    assert disc.aimed((1, 0, 0)).direction == pytest.approx((1, 0, 0), abs=1e-6)
    moved = disc.moved(np.array([[0, 0, 1, 0], [0, 1, 0, 5], [-1, 0, 0, 0], [0, 0, 0, 1]]))
    assert moved.center == pytest.approx((0, 7, 0), abs=1e-6)
    polygon = cl.Light.polygon(np.array([[0, 2, 0], [1, 2, 0], [0, 2, 1.0]]), flux=(1, 2, 3))
    tube = cl.Light.tube((0, 2, 0), (1, 2, 0), 0.1, radiance=1)
    spot = cl.Light.spot((0, 3, 0), (0, -1, 0), intensity=4, angle=30, inner=20)
    sun = cl.Light.sun((0, -1, 0), irradiance=3)
    assert sun.center is None and sun.direction == (0, -1, 0)
    assert cl.Light.point((0, 1, 0), intensity=1) == cl.Light.point([0, 1, 0], intensity=(1, 1, 1))
    ranged = cl.Light.point((0, 1, 0), intensity=1, range=5)
    assert ranged != cl.Light.point((0, 1, 0), intensity=1)
    with pytest.raises(ValueError, match="range"):
        cl.Light.point((0, 1, 0), intensity=1, range=0)
    for light in (sphere, disc, polygon, tube, spot, sun, ranged, cl.Light.ambient(0.3)):
        scene = cl.Scene(size=(8, 8), camera=CAMERA)
        scene.add_mesh(*quad((0, 0, 0), (4, 0, 0), (0, 0, -4)))
        scene.add_light(light)
        assert cl.Renderer(scene).render().max() > 0, light


def test_a_sun_is_that_of_its_irradiance():
    scene = cl.Scene(size=(8, 8), camera=CAMERA)
    scene.add_mesh(*quad((0, 0, 0), (9, 0, 0), (0, 0, -9)), material=cl.Material.lambert(0.5))
    scene.add_light(cl.Light.sun((0, -1, 0), irradiance=(1, 2, 3), angle=4))
    picture = cl.Renderer(scene, samples=1).render()
    assert np.allclose(picture[7], np.array([1, 2, 3]) * 0.5 / np.pi, rtol=2e-3)


BAD_VALUES = [
    (lambda: cl.Light.sphere((0, 0), 1, radiance=1), "center has 2 numbers: expected three numbers"),
    (lambda: cl.Light.sphere((0, 0, 0, 0), 1, radiance=1), "center has more than 3 numbers"),
    (lambda: cl.Light.sphere((0, np.nan, 0), 1, radiance=1), r"center is \[0, NaN, 0\]: expected finite numbers"),
    (lambda: cl.Light.sphere(5, 1, radiance=1), "center is of type int: expected three numbers"),
    (lambda: cl.Light.sphere((0, 0, 0), 0, radiance=1), "radius is 0: expected a number above 0"),
    (lambda: cl.Light.sphere((0, 0, 0), np.nan, radiance=1), "radius is NaN: expected a number above 0"),
    (lambda: cl.Light.sphere((0, 0, 0), 1), "expected exactly one of radiance, flux"),
    (lambda: cl.Light.sphere((0, 0, 0), 1, radiance=1, flux=1), "expected exactly one of radiance, flux"),
    (lambda: cl.Light.sphere((0, 0, 0), 1, radiance=-1), "radiance is .*: expected finite numbers of at least 0"),
    (lambda: cl.Light.sphere((0, 0, 0), 1, radiance="red"), "radiance is of type str: expected a number, or three"),
    (lambda: cl.Light.sphere((0, 0, 0), 1, radiance=np.inf), "radiance is"),
    (lambda: cl.Light.rectangle((0, 0, 0), (1, 0, 0), (2, 0, 0), radiance=1), "the light has no area"),
    (lambda: cl.Light.disc((0, 0, 0), (0, 0, 0), 1, radiance=1), r"normal is \[0, 0, 0\]: expected a direction"),
    (lambda: cl.Light.polygon(np.zeros((2, 3)), radiance=1), "expected 3 to 24 corners"),
    (lambda: cl.Light.sun((0, -1, 0), irradiance=1, angle=500), "angle is 500: expected a number from 0.001 to 120"),
    (lambda: cl.Light.spot((0, 0, 0), (0, 1, 0), intensity=1, angle=20, inner=30), "inner is 30: expected a number from 0 to 20"),
    (lambda: cl.Light.ambient(1).moved(np.eye(3)), "matrix has 3 rows of 3 numbers: expected a 4 x 4 matrix"),
    (lambda: cl.Light.ambient(1).moved(np.full((4, 4), np.nan)), "matrix: expected finite numbers"),
    (lambda: cl.Light.ambient(1).moved(np.ones((4, 4))), r"matrix has the last row \[1.0, 1.0, 1.0, 1.0\]: expected"),
    (lambda: cl.Light.ambient(1).moved(7), "matrix is of type int"),
    (lambda: cl.Light.point((0, 1, 0), intensity=1).moved(np.diag([2, 2, 2, 1.0])), "matrix scales or mirrors"),
    (lambda: cl.Light.point((0, 1, 0), intensity=1).moved(np.diag([-1, 1, 1, 1.0])), "matrix scales or mirrors"),
    (lambda: cl.Camera((0, 0, 0), (0, 0, 0)), "camera eye and target are the same point"),
    (lambda: cl.Camera((0, 0, 0), (0, 0, 1), fov=180), "fov is 180: expected a number from 0.001 to 179.9"),
    (lambda: cl.Camera((0, 0, 0), (0, 1, 0)), "camera up is parallel"),
    (lambda: cl.Camera((0, 0, 0), (0, 0, 1), projection="orthographic"), "an orthographic camera needs height"),
    (lambda: cl.Camera((0, 0, 0), (0, 0, 1), projection="orthographic", height=0), "height is 0: expected a number from 0.000000001 to 1000000000"),
    (lambda: cl.Camera((0, 0, 0), (0, 0, 1), projection="orthographic", height=-2), "height is -2"),
    (lambda: cl.Camera((0, 0, 0), (0, 0, 1), projection="orthographic", height=float("nan")), "height is NaN"),
    (lambda: cl.Camera((0, 0, 0), (0, 0, 1), projection="orthographic", height=float("inf")), "height is inf"),
    (lambda: cl.Camera((0, 0, 0), (0, 0, 1), projection="orthographic", height=2, fov=30), "fov is of perspective cameras: this one is orthographic"),
    (lambda: cl.Camera((0, 0, 0), (0, 0, 1), height=2), "height is of orthographic cameras: perspective ones have fov"),
    (lambda: cl.Camera((0, 0, 0), (0, 0, 1), projection="panoramic", height=2), "height is of orthographic cameras: this one is panoramic"),
    (lambda: cl.Camera((0, 0, 0), (0, 0, 1), projection="fisheye"), "projection is 'fisheye': expected 'perspective', 'orthographic' or 'panoramic'"),
    (lambda: cl.Material.lambert(np.nan), "albedo is"),
    (lambda: cl.Material.phong(exponent=-1), "exponent is -1: it must lie in"),
    (lambda: cl.Material.lafortune([{"exponent": 5}]), 'a lobe has no "scale"'),
    (lambda: cl.Material.lafortune([{"exponent": 5, "size": 1}]), "a lobe has 'size': expected exponent, scale, c, matrix"),
    (lambda: cl.Material.half_vector([{"roughness": 2, "f0": 1}]), "roughness is 2: expected a number from 0 to 1"),
    (lambda: cl.Material.metallic_roughness(1, clearcoat=2), "clearcoat"),
    (lambda: cl.Scene().add_mesh(np.eye(3), np.array([[0, 1, 2]]), terminator="round"), 'terminator is "round": expected one of exact, smooth'),
    (lambda: cl.Material.metallic_roughness(1, ior=0.5), "ior is 0.5: expected a number from 1"),
    (lambda: cl.Environment(np.zeros((4, 8))), r"radiance has shape \(4, 8\): expected \(height, width, 3\)"),
    (lambda: cl.Environment(np.full((4, 8, 3), np.nan)), r"radiance\[0, 0\] is .*: expected finite numbers"),
    (lambda: cl.Environment(1, patches=99), "patches is 99: expected 1 to 16"),
    (lambda: cl.Environment(), "an environment without light: expected radiance or ambient"),
    (lambda: cl.Environment(ambient=-1), "ambient is .*: expected finite numbers of at least 0"),
    (lambda: cl.Scene(size=(0, 5)), "image is 0x5: both must lie in 1…16384"),
    (lambda: cl.Scene(background=-1), "background is"),
    (lambda: cl.Settings(visibility="magic"), 'visibility is "magic"'),
    (lambda: cl.Settings(method="magic"), 'method is "magic": expected one of moments, lobes, paper'),
    (lambda: cl.Settings(device="tpu"), 'device is "tpu": expected one of cpu, gpu'),
    (lambda: cl.Settings(tolerance=np.nan), "tolerance is NaN"),
    (lambda: cl.Settings(samples=0), "camera rays a pixel is 0"),
    (lambda: cl.Settings(speed=3), "unexpected keyword argument 'speed'"),
    (lambda: cl.compare(np.zeros((2, 2, 3)), np.zeros((2, 2))), r"reference has shape \(2, 2\): expected \(height, width, 3\)"),
    (lambda: cl.compare(np.zeros((2, 2, 3)), np.zeros((2, 3, 3))), "sizes differ: 2x2 against 3x2"),
    (lambda: cl.compare(np.zeros((0, 2, 3)), np.zeros((0, 2, 3))), "test has shape"),
    (lambda: cl.compare(np.zeros((1, 1, 3)), np.full((1, 1, 3), np.nan)), r"reference\[0, 0\] is"),
    (lambda: cl.compare(np.zeros((1, 1, 3), np.uint8), np.zeros((1, 1, 3))), "test has dtype uint8: expected float32, float64"),
    (lambda: cl.write_exr("/nowhere/x.exr", np.zeros((1, 1, 3))), "/nowhere/x.exr"),
    (lambda: cl.read_exr("/nowhere/x.exr"), "/nowhere/x.exr"),
    (lambda: cl.reference(stage(), geometry="magic"), 'geometry is "magic"'),
    (lambda: cl.reference(stage(), spp=0), "spp is 0"),
    (lambda: cl.SphereSet.load("/nowhere/x.json"), "/nowhere/x.json: cannot read"),
    (lambda: cl.SphereSet.fit(*cube(), count=0), "a sphere set needs at least one sphere"),
]


@pytest.mark.parametrize("number", range(len(BAD_VALUES)))
def test_wrong_values_are_refused_by_name(number):
    make, fault = BAD_VALUES[number]
    with pytest.raises((ValueError, TypeError, cl.LobesError), match=fault) as refused:
        make()
    assert "\n" not in str(refused.value) and str(refused.value)


def test_every_model_of_materials():
    lobes = [{"exponent": 20, "scale": 0.5, "c": (-1, -1, 1)}, {"exponent": 5, "scale": (0.1, 0, 0), "matrix": np.eye(3)}]
    materials = [
        cl.Material.lambert((0.5, 0.4, 0.3)),
        cl.Material.phong(kd=0.2, ks=0.5, exponent=30),
        cl.Material.modified_phong(kd=0.2, ks=0.5, exponent=30),
        cl.Material.neumann(ks=0.5, exponent=30),
        cl.Material.lafortune(lobes, diffuse=0.2),
        cl.Material.half_vector([{"roughness": 0.3, "f0": 0.04}, {"roughness": 0.5, "f0": 0.1, "f90": 0.5}], diffuse=0.4),
        cl.Material.metallic_roughness((1, 0.8, 0.3), roughness=0.3),
    ]
    for material in materials:
        scene = cl.Scene(size=(16, 16), camera=CAMERA)
        scene.add_mesh(*quad((0, 0, 0), (4, 0, 0), (0, 0, -4)), material=material)
        scene.add_light(cl.Light.sphere((-1, 2, -1), 0.4, radiance=10))
        assert cl.Renderer(scene).render().max() > 0, material


@pytest.mark.filterwarnings("ignore:.*emits, but lights no other:cosine_lobes.LobesWarning")
def test_images_are_those_of_files(tmp_path):
    random = np.random.default_rng(2)
    names = ["color", "roughness", "metallic", "normal", "emission"]
    bytes_ = {}
    for name in names:
        grey = name in ("roughness", "metallic")
        image = random.uniform(0, 1, (6, 5, 1) if grey else (6, 5, 3)) * np.ones(3)
        if name == "normal":
            image = 0.2 * image + (0.1, 0.1, 0.8)
        cl.write_png(tmp_path / f"{name}.png", image)
        bytes_[name] = cl.exposed(image)[..., 0] if grey else cl.exposed(image)
    text = """
[image]
width = 32
height = 24
[camera]
eye = [1.5, 2, 4]
target = [0, 0.4, 0]
fov = 40
[materials.m]
model = "metallic-roughness"
base = 0.9
metallic = 0.5
roughness = 0.8
color_map = "color.png"
normal_map = "normal.png"
emission_map = "emission.png"
emission = 0.2
metallic_map = { file = "metallic.png", channel = "red" }
roughness_map = { file = "roughness.png", channel = "red" }
[[lights]]
kind = "sphere"
center = [-2, 3, 1]
radius = 0.4
radiance = 40
[[objects]]
mesh = "quad.obj"
normals = "face"
material = "m"
"""
    (tmp_path / "scene.toml").write_text(text)
    positions, triangles = quad((0, 0, 0), (2, 0, 0), (0, 0, -2))
    uvs = np.array([[0, 0], [2, 0], [2, 2], [0, 2]], np.float32)
    lines = [f"v {x} {y} {z}" for x, y, z in positions] + [f"vt {u} {1 - v}" for u, v in uvs]
    lines += ["f " + " ".join(f"{i + 1}/{i + 1}" for i in t) for t in triangles]
    (tmp_path / "quad.obj").write_text("\n".join(lines) + "\n")
    material = cl.Material.metallic_roughness(0.9, metallic=0.5, roughness=0.8, emission=0.2).with_images(**bytes_)
    scene = cl.Scene(size=(32, 24), camera=CAMERA)
    scene.add_mesh(positions, triangles, uvs=uvs, material=material)
    scene.add_light(cl.Light.sphere((-2, 3, 1), 0.4, radiance=40))
    own, loaded = cl.Renderer(scene).render(), cl.Renderer(cl.Scene.load(tmp_path / "scene.toml")).render()
    assert np.array_equal(own, loaded) and own.max() > 0
    assert len(np.unique(own[own > 0])) > 500
    white = cl.Material.lambert(1)
    with pytest.raises(TypeError, match="color has dtype float64: expected uint8"):
        white.with_images(color=np.zeros((4, 4, 3)))
    with pytest.raises(ValueError, match=r"color has shape \(4, 4\): expected \(height, width, 3\)"):
        white.with_images(color=np.zeros((4, 4), np.uint8))
    with pytest.raises(ValueError, match=r"roughness has shape \(4, 4, 3\): expected \(height, width\)"):
        white.with_images(roughness=np.zeros((4, 4, 3), np.uint8))
    with pytest.raises(ValueError, match="color has 0 x 4 texels: expected 1 to 16384 a side"):
        white.with_images(color=np.zeros((4, 0, 3), np.uint8))


def test_sphere_sets_are_fitted_measured_and_kept(tmp_path):
    positions, triangles = cube()
    heard = []
    spheres = cl.SphereSet.fit(positions, triangles, count=12, draft=True, progress=lambda stage, done: heard.append(done))
    assert len(spheres) == 12 and spheres.spheres.shape == (12, 4) and heard
    assert 0 < spheres.quality["silhouette_error"] < 0.5
    spheres.save(tmp_path / "set.json")
    again = cl.SphereSet.load(tmp_path / "set.json")
    assert np.array_equal(again.spheres, spheres.spheres) and again.quality == spheres.quality
    measured = cl.SphereSet.measure(positions, triangles, spheres.spheres)
    assert measured.quality == pytest.approx(spheres.quality, rel=1e-5)
    moved = np.eye(4)
    moved[0, 3] = 2
    assert np.allclose(spheres.placed(moved).spheres - spheres.spheres, (2, 0, 0, 0), atol=1e-6)
    with pytest.raises(ValueError, match="tolerance goes neither with draft nor with bounding"):
        cl.SphereSet.fit(positions, triangles, tolerance=0.1, draft=True)


def test_models_and_their_warnings(tmp_path):
    path = tmp_path / "bent.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nf 1 2 3\nf 1 2 4\n")
    with pytest.warns(cl.LobesWarning):
        scene = cl.Scene.load(path, size=(16, 16))
    assert len(scene.warnings) == 1 and len(scene.lights) == 3
    assert cl.Renderer(scene).render().max() > 0
    assert "objects" in repr(cl.Scene.load(SCENES / "soft_spheres.toml"))


@pytest.mark.parametrize("pixel, message", [(-1.0, "1 pixel is negative: taken as black"), (1e13, "1 pixel is brighter than 1e12")])
def test_environments_tell_which_pixels_are_no_radiance(pixel, message):
    sky = np.ones((4, 8, 3), np.float32)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        cl.Environment(sky)
    sky[1, 2, 0] = pixel
    with pytest.warns(cl.LobesWarning, match=message):
        cl.Environment(sky)


def test_meshes_far_from_the_origin_get_a_warning():
    corners = np.array([[0, 0, 0], [3, 0, 0], [0, 0, 3.0]])
    triangle = np.array([[0, 2, 1]])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        cl.Scene().add_mesh(corners + 1000, triangle)
    with pytest.warns(cl.LobesWarning, match=r"1\.000e6 from the origin: single precision rounds them by 1\.2e-1"):
        cl.Scene().add_mesh(corners + [1e6, 0, 0], triangle)
