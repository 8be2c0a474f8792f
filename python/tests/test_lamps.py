"""Lamps, windows of pictures, alpha, and Principled."""

import math

import numpy as np
import pytest

import cosine_lobes as cl
from conftest import quad, stage

def square(half):
    """A square on the floor."""
    return quad((0, 0, 0), (half, 0, 0), (0, 0, -half))


FLOOR = ([[0.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])


def irradiance(light, beside=0.0):
    """On a floor beside the origin, without blockers."""
    scene = cl.Scene(size=(8, 8), camera=cl.Camera((0, 5, 5), (0, 0, 0)))
    scene.add_mesh(*square(4), visibility="none")
    scene.add_light(light)
    points, normals = (np.array(rows) for rows in FLOOR)
    return math.pi * cl.Renderer(scene).shade(points + [beside, 0, 0], normals)[0, 0]


def test_a_lamp_that_faces_the_floor_is_a_disc_there():
    # π L times sin² of a sphere, and r²/(d² + r²) of a disc.
    radiance, radius, height = 3 / (math.pi * 0.25), 0.5, 2.0
    sphere = cl.Light.lamp((0, height, 0), intensity=3, radius=radius)
    disc = cl.Light.lamp((0, height, 0), intensity=3, radius=radius, facing=True)
    assert irradiance(sphere) == pytest.approx(math.pi * radiance * radius**2 / height**2, rel=1e-4)
    assert irradiance(disc) == pytest.approx(math.pi * radiance * radius**2 / (height**2 + radius**2), rel=1e-4)


def test_the_cone_of_a_lamp_against_a_mean_over_its_disc():
    half, blend, radius, height = math.radians(30), 0.3, 0.3, 2.0
    light = cl.Light.lamp((0, height, 0), intensity=1, radius=radius, direction=(0, -1, 0), angle=30, blend=blend)
    plain = cl.Light.lamp((0, height, 0), intensity=1, radius=radius)
    n = 200
    u, v = (np.mgrid[0:n, 0:n] + 0.5) / n
    for beside in (0.3, 0.8, 1.0, 1.2, 1.35):
        away = np.array([beside, -height, 0]) / math.hypot(beside, height)
        side, other = np.array([-away[1], away[0], 0]), np.array([0, 0, 1])
        reach = math.tan(math.asin(radius / math.hypot(beside, height)))
        rays = away + reach * np.sqrt(u)[..., None] * (np.cos(2 * np.pi * v)[..., None] * side + np.sin(2 * np.pi * v)[..., None] * other)
        cos = -rays[..., 1] / np.linalg.norm(rays, axis=-1)
        x = np.clip((cos - math.cos(half)) / ((1 - math.cos(half)) * blend), 0, 1)
        want = (x * x * (3 - 2 * x)).mean()
        assert irradiance(light, beside) / irradiance(plain, beside) == pytest.approx(want, abs=5e-3), beside


def test_a_window_is_a_part_of_the_picture(scene):
    renderer = cl.Renderer(scene)
    whole, (width, height) = renderer.render(), renderer.size
    part = renderer.render(window=(8, 4, width - 20, 10))
    assert np.array_equal(part, whole[4:14, 8 : width - 12])
    layers = renderer.layers(["lights"], window=(8, 4, 5, 6))
    assert np.array_equal(layers["beauty"], whole[4:10, 8:13]) and layers["light0"].shape == (6, 5, 3)
    out = np.empty((6, 5, 3), np.float32)
    assert renderer.render(window=(8, 4, 5, 6), out=out) is out
    for wrong in ((0, 0, width + 1, 1), (width, 0, 1, 1), (0, 0, 0, 1)):
        with pytest.raises(ValueError, match="expected a part of"):
            renderer.render(window=wrong)


def test_coverage_is_what_the_background_does_not_show(scene):
    scene.background = (0, 0, 0)
    renderer = cl.Renderer(scene, samples=4)
    dark = renderer.render()
    renderer.set_background((1, 1, 1))
    assert np.allclose(1 - renderer.coverage(), (renderer.render() - dark)[..., 0], atol=1e-5)
    scene.set_environment(cl.Environment(0.5))
    assert np.array_equal(cl.Renderer(scene, samples=4).coverage(), renderer.coverage())


def test_cutting_along_alpha():
    positions, triangles = (np.array(rows) for rows in square(1))
    positions, triangles = positions.astype(np.float32), triangles
    uvs = (positions[:, [0, 2]] - positions[:, [0, 2]].min(0)) / np.ptp(positions[:, [0, 2]], axis=0)
    n = 64
    y, x = (np.mgrid[0:n, 0:n] + 0.5) / n
    alpha = np.where(np.hypot(x - 0.5, y - 0.5) < 0.3, 255, 0).astype(np.uint8)
    left, faces, normals, coordinates = cl.cut_out(positions, triangles, uvs.astype(np.float32), alpha)
    corners = left[faces].astype(np.float64)
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
    whole = np.prod(np.ptp(positions[:, [0, 2]], axis=0))
    assert area == pytest.approx(whole * math.pi * 0.09, rel=0.02) and normals is None and coordinates.shape == (len(left), 2)
    with pytest.raises(ValueError, match="limit"):
        cl.cut_out(positions, triangles, uvs, alpha, limit=0)


def test_objects_without_spheres_take_unequal_scales():
    made = stage()
    number = made.add_mesh(*square(0.3), name="card", spheres=0)
    renderer = cl.Renderer(made)
    renderer.set_transform(number, np.diag([1.0, 2.0, -0.5, 1.0]))
    renderer.render()


def white_furnace(material, cosine):
    """What a surface shows under light of radiance 1 from everywhere."""
    scene = cl.Scene(size=(8, 8), camera=cl.Camera((0, 5, 5), (0, 0, 0)))
    scene.add_mesh(*square(4), visibility="none")
    scene.set_environment(cl.Environment(1.0))
    points, normals = (np.array(rows) for rows in FLOOR)
    view = np.array([[math.sqrt(1 - cosine**2), cosine, 0]])
    return cl.Renderer(scene).shade(points, normals, view, material=material)[0]


@pytest.mark.parametrize("roughness", [0.3, 0.6, 1.0])
def test_principled_gives_back_what_it_gets(roughness):
    # White metal: all of it, however often it scatters. White plastic: the base has what the coat leaves.
    for cosine in (1.0, 0.7, 0.4):
        metal = white_furnace(cl.Material.principled(1.0, metallic=1, roughness=roughness), cosine)
        assert metal == pytest.approx([1, 1, 1], abs=0.02)
        plastic = white_furnace(cl.Material.principled(1.0, roughness=roughness), cosine)
        assert plastic == pytest.approx([1, 1, 1], abs=0.02)
    once = white_furnace(cl.Material.principled(1.0, metallic=1, roughness=roughness, scatters=False), 1.0)
    assert (once <= metal + 0.01).all()


@pytest.mark.parametrize("cosine", [1.0, 0.6, 0.3])
def test_a_coat_of_principled_takes_what_it_reflects(cosine):
    # Over white the sum is all of the light, over black its own part, in proportion to its weight.
    coat = {"coat_roughness": 0.4, "coat_ior": 1.6}
    white = white_furnace(cl.Material.principled(1.0, ior=1, coat=1.0, **coat), cosine)
    assert white == pytest.approx([1, 1, 1], abs=0.01)
    own, half = (white_furnace(cl.Material.principled(0.0, ior=1, coat=weight, **coat), cosine) for weight in (1.0, 0.5))
    assert half == pytest.approx(0.5 * own, rel=1e-3)
    # Beer's law along the refracted view.
    tint = np.array([0.9, 0.5, 0.2])
    tinted = white_furnace(cl.Material.principled(1.0, ior=1, coat=1.0, coat_tint=tint, **coat), cosine)
    through = tint ** (1 / math.sqrt(1 - (1 - cosine**2) / 1.6**2))
    assert tinted - own == pytest.approx((1 - own) * through, abs=0.01)


def test_principled_without_ior_is_diffuse_and_arguments_are_checked():
    assert white_furnace(cl.Material.principled((0.2, 0.4, 0.6), ior=1), 0.6) == pytest.approx([0.2, 0.4, 0.6], rel=5e-3)
    assert cl.Material.principled(0.5).model == "principled"
    with pytest.raises(ValueError, match="base is"):
        cl.Material.principled(1.5)
    with pytest.raises(ValueError, match="coat_ior is 0.5"):
        cl.Material.principled(0.5, coat=1, coat_ior=0.5)
    with pytest.raises(TypeError, match="one of ior, f0"):
        cl.Material.metallic_roughness(0.5, ior=1.5, f0=0.04)
    coat = cl.Material.metallic_roughness(0.5, metallic=0, roughness=0.4, f0=0.04)
    assert np.allclose(white_furnace(coat, 0.8), white_furnace(cl.Material.metallic_roughness(0.5, metallic=0, roughness=0.4), 0.8))
