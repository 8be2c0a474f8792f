"""Light at points of the caller's."""

import numpy as np
import pytest

import cosine_lobes as cl
from conftest import CAMERA, stage


def picture_points(renderer):
    """The points that the picture shows, pixel by pixel."""
    width, height = renderer.size
    picks = [(x, y, renderer.pick(x, y)) for y in range(height) for x in range(width)]
    return [pick for pick in picks if pick[2] is not None]


def test_points_of_the_picture_have_its_light():
    renderer = cl.Renderer(stage(size=(24, 16)), samples=1)
    layers = renderer.layers()
    seen = [(x, y, pick) for x, y, pick in picture_points(renderer) if pick.name == "cube"]
    assert len(seen) > 10
    points, normals, views = (np.array([getattr(p, name) for *_, p in seen], np.float32) for name in ("position", "normal", "view"))
    material = renderer.object_material("cube")
    light = renderer.shade_layers(points, normals, views, material=material, objects="cube")
    rows, columns = [y for _, y, _ in seen], [x for x, *_ in seen]
    # Normals come back from Python as unit vectors to rounding.
    for name in ("beauty", "unshadowed", "light0", "light1"):
        assert light[name].shape == (len(seen), 3)
        assert np.allclose(light[name], layers[name][rows, columns], rtol=1e-4, atol=1e-6), name
    number = renderer.materials.index(material)
    alone = renderer.shade(points, normals, views, material=number, objects=np.full(len(seen), 1))
    assert np.array_equal(alone, light["beauty"])
    assert np.allclose(light["light0"] + light["light1"], light["beauty"], rtol=1e-5)


def test_white_points_have_the_irradiance_over_pi():
    scene = cl.Scene(size=(8, 8), camera=CAMERA)
    scene.add_spheres(np.array([[50.0, 0.5, 0, 0.5]]))
    scene.add_light(cl.Light.sphere((0, 2, 0), 0.5, radiance=(3, 6, 9)))
    renderer = cl.Renderer(scene)
    heights = np.linspace(0, 1, 5)
    points = np.stack([0 * heights, heights, 0 * heights], axis=-1)
    normals = np.tile([0.0, 7.0, 0.0], (5, 1))
    irradiance = np.pi * renderer.shade(points, normals)
    want = np.pi * (0.5 / (2 - heights[:, None])) ** 2 * np.array([3, 6, 9])
    assert np.allclose(irradiance, want, rtol=1e-4)
    dark = renderer.shade(points, -normals)
    assert (dark == 0).all()


def test_order_and_strides_have_no_say():
    renderer = cl.Renderer(stage())
    random = np.random.default_rng(1)
    points = np.concatenate([random.uniform(-2, 2, (500, 1)), np.zeros((500, 1)), random.uniform(-2, 2, (500, 1))], axis=1)
    normals = np.tile([0.0, 1.0, 0.0], (500, 1))
    light = renderer.shade(points, normals)
    assert light.dtype == np.float32 and light.max() > 0
    assert np.array_equal(renderer.shade(points[::-1], normals[::-1]), light[::-1])
    wide = np.zeros((500, 9), np.float32)
    wide[:, 1:9:3] = points
    assert np.array_equal(renderer.shade(wide[:, 1:9:3], normals), light)
    assert np.array_equal(renderer.shade(np.asfortranarray(points, np.float32), np.broadcast_to(np.float32([0, 1, 0]), (500, 3))), light)
    assert renderer.shade(points[:0], normals[:0]).shape == (0, 3)


def test_a_mirror_depends_on_the_view():
    renderer = cl.Renderer(stage())
    point, normal = np.array([[-1.0, 0, 1.5]]), np.array([[0.0, 1, 0]])
    mirror = cl.Material.metallic_roughness(1, metallic=1, roughness=0.2)
    lamp = np.array([[-1.0, 3, -0.5]])
    toward = lamp * (-1, 1, -1)
    assert renderer.shade(point, normal, toward, material=mirror).max() != renderer.shade(point, normal, material=mirror).max()


def test_visible_fractions():
    renderer = cl.Renderer(stage())
    assert renderer.visible_fraction((-2, 0, 1), (0, 1, 0), 0) == pytest.approx((1, 1, 1), abs=1e-3)
    hidden = renderer.visible_fraction((0.9, 0.0, -0.5), (0, 1, 0), renderer.lights[0])
    assert hidden == (0, 0, 0)


@pytest.mark.parametrize(
    "change, fault",
    [
        ({"points": np.zeros((2, 2))}, r"points has shape \(2, 2\): expected \(n, 3\)"),
        ({"points": np.zeros(3)}, r"points has shape \(3,\): expected \(n, 3\)"),
        ({"points": np.zeros((2, 3), np.int32)}, "points has dtype int32: expected float32, float64"),
        ({"points": np.zeros((2, 3), ">f4")}, "points has dtype >f4: expected float32, float64"),
        ({"points": [[0, 0, 0]]}, "points is of type list: expected a numpy array"),
        ({"points": np.array([[0, 0, 0], [0, np.nan, 0]])}, r"points\[1\] is \[0.0, NaN, 0.0\]: expected finite numbers"),
        ({"points": np.array([[0, 0, 0], [0, 1e300, 0]])}, r"points\[1\] is \[0.0, inf, 0.0\]: expected finite numbers"),
        ({"normals": np.zeros((3, 3))}, "normals has 3 rows: expected 2, one for each point"),
        ({"normals": np.zeros((2, 3))}, r"normals\[0\] is \[0, 0, 0\]: expected a direction"),
        ({"views": np.ones((1, 3))}, "views has 1 rows: expected 2"),
        ({"faces": np.full((2, 3), np.inf)}, r"faces\[0\] is"),
        ({"material": "red"}, "material is of type str: expected a handle or a number"),
        ({"material": 99}, "material 99 is not in the scene"),
        ({"objects": np.zeros(5, np.int64)}, "objects has 5 rows: expected 2"),
        ({"objects": np.zeros(2)}, "objects has dtype float64: expected int32, int64"),
        ({"objects": np.array([0, 77])}, "expected an object of the scene, or none"),
    ],
)
def test_wrong_points_are_refused_by_name(change, fault):
    given = {"points": np.zeros((2, 3)), "normals": np.tile([0.0, 1.0, 0.0], (2, 1)), **change}
    renderer = cl.Renderer(stage())
    with pytest.raises((ValueError, TypeError, IndexError), match=fault):
        renderer.shade(**given)
