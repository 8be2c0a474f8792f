"""Edits, and what they cost: the renderer's own counters say what was built."""

import numpy as np
import pytest

import cosine_lobes as cl
from conftest import CAMERA, cube, quad, stage

def shift(x, y, z):
    matrix = np.eye(4)
    matrix[:3, 3] = (x, y, z)
    return matrix


def new_counts(renderer, before):
    return {name: count - before[name] for name, count in renderer.upkeep.items() if count != before[name]}


def test_a_light_that_is_dragged_rebuilds_nothing(scene):
    scene.size = (24, 16)
    renderer = cl.Renderer(scene)
    first = renderer.render()
    before, light = renderer.upkeep, renderer.lights[0]
    out = np.empty_like(first)
    for _ in range(100):
        renderer.set_light(light, renderer.light(light).shifted((0.01, 0, 0)))
        assert renderer.stale == {"shading", "lights", "maps"}
        assert renderer.render(out=out) is out
    assert new_counts(renderer, before) == {}
    assert renderer.light(light).center == pytest.approx((-1, 3, 1), abs=1e-4)
    assert not np.array_equal(out, first)

    fresh = stage(size=(24, 16))
    fresh_renderer = cl.Renderer(fresh)
    fresh_renderer.set_light(0, renderer.light(0))
    assert np.array_equal(fresh_renderer.render(), out)


def test_a_moved_object_is_refitted_and_not_built(scene):
    renderer = cl.Renderer(scene)
    first, before = renderer.render(), renderer.upkeep
    renderer.set_transform("cube", shift(0.3, 0, 0))
    assert np.allclose(renderer.transform("cube"), shift(0.3, 0, 0))
    moved = renderer.render()
    counts = new_counts(renderer, before)
    assert counts["hierarchy_refits"] == 1 and counts["silhouette_refits"] == 1
    assert "hierarchy_builds" not in counts and "silhouette_builds" not in counts and "sphere_sets" not in counts
    assert not np.array_equal(first, moved)
    renderer.set_transform("cube", np.eye(4))
    assert np.array_equal(renderer.render(), first)


@pytest.mark.parametrize(
    "words, keys",
    [
        ({"projection": "orthographic", "height": 2.5}, 'projection = "orthographic"\nheight = 2.5'),
        ({"projection": "panoramic"}, 'projection = "panoramic"'),
    ],
)
def test_projections(scene, tmp_path, words, keys):
    renderer = cl.Renderer(scene)
    first = renderer.render()
    camera = cl.Camera(CAMERA.eye, CAMERA.target, **words)
    assert CAMERA.projection == "perspective" and CAMERA.fov == 40 and CAMERA.height is None
    assert camera.projection == words["projection"] and camera.fov is None and camera.height == words.get("height")
    assert eval(repr(camera), {"Camera": cl.Camera}) == camera != CAMERA
    renderer.edit(camera=camera)
    assert renderer.camera == camera
    edited = renderer.render()
    assert not np.array_equal(edited, first)
    scene.camera = camera
    assert scene.camera == camera and np.array_equal(cl.Renderer(scene).render(), edited)
    file = tmp_path / "scene.toml"
    file.write_text(f"[camera]\neye = [1.5, 2, 4]\ntarget = [0, 0.4, 0]\n{keys}\n[[objects]]\nsphere = {{ center = [0, 0, 0], radius = 1 }}\n")
    assert cl.Scene.load(file).camera.projection == camera.projection
    assert cl.Scene.load(file).camera.height == pytest.approx(camera.height)


def test_camera_material_size_and_background(scene):
    renderer = cl.Renderer(scene)
    first = renderer.render()
    camera = cl.Camera((0, 3, 4), (0, 0.4, 0), fov=50)
    renderer.set_camera(camera)
    assert renderer.camera.eye == camera.eye and not np.array_equal(renderer.render(), first)
    renderer.set_camera(CAMERA)
    assert np.array_equal(renderer.render(), first)

    red = renderer.object_material("cube")
    own = renderer.material(red)
    assert own.model == "metallic-roughness"
    before = renderer.upkeep
    renderer.set_material(red, cl.Material.lambert((0, 1, 0)))
    assert renderer.material(red) == cl.Material.lambert((0, 1, 0)) != own
    assert not np.array_equal(renderer.render(), first) and new_counts(renderer, before) == {}
    renderer.set_material(red, own)
    grey = renderer.add_material(cl.Material.lambert(0.5, emission=2))
    renderer.set_object_material("cube", grey)
    assert renderer.object_material("cube") == grey
    glowing = renderer.render()
    assert glowing.max() > 2
    renderer.set_object_material("cube", red)
    assert np.array_equal(renderer.render(), first)

    renderer.set_size(20, 10)
    assert renderer.size == (20, 10) and renderer.render().shape == (10, 20, 3)
    renderer.set_size(48, 32)
    renderer.set_visible("floor", False)
    renderer.set_background((1, 2, 3))
    assert (renderer.render() == np.float32([1, 2, 3])).all(axis=-1).any()


def test_objects_and_lights_come_and_go(scene):
    renderer = cl.Renderer(scene)
    first = renderer.render()
    block = renderer.add_mesh(*cube((-1, 0.3, 0.5), 0.6), name="block", material=0)
    assert renderer.name(block) == "block" and len(renderer.objects) == 4
    pair = renderer.add_spheres(np.array([[0, 1.5, 0, 0.2], [0, 1.8, 0, 0.2]], np.float32), material=cl.Material.lambert(0.9))
    lamp = renderer.add_light(cl.Light.point((0, 3, 2), intensity=5))
    assert not np.array_equal(renderer.render(), first)
    positions, triangles = cube((-1, 0.3, 0.5), 0.2)
    renderer.set_mesh(block, positions, triangles, smooth=True)
    small = renderer.render()
    renderer.set_visibility(block, "rays")
    renderer.set_visibility(block, None)
    assert np.array_equal(renderer.render(), small)
    for item in (block, pair):
        renderer.remove_object(item)
        with pytest.raises(cl.EditError, match="is not in the scene"):
            renderer.name(item)
    assert renderer.remove_light(lamp).kind == "sphere"
    with pytest.raises(cl.EditError, match="is not in the scene"):
        renderer.light(lamp)
    assert np.array_equal(renderer.render(), first)


def test_the_environment_is_replaced(scene):
    renderer = cl.Renderer(scene)
    first = renderer.render()
    sky = np.zeros((16, 32, 3), np.float32)
    sky[:8] = (0.2, 0.3, 0.5)
    renderer.set_environment(cl.Environment(sky, strength=2))
    lit = renderer.render()
    assert lit.mean() > first.mean() and len(renderer.lights) > 2

    same = stage()
    same.set_environment(cl.Environment(sky, strength=2))
    assert np.array_equal(cl.Renderer(same).render(), lit)
    renderer.set_environment(None)
    assert np.array_equal(renderer.render(), first)

    # Ambient light is not seen behind the objects.
    renderer.set_environment(cl.Environment(ambient=0.3))
    ambient = renderer.render()
    behind = renderer.coverage() == 0
    assert behind.any() and np.array_equal(ambient[behind], first[behind]) and ambient.mean() > first.mean()


def test_an_edit_is_made_whole_or_not_at_all(scene):
    renderer = cl.Renderer(scene)
    first = renderer.render()
    light = renderer.light(0)
    camera = cl.Camera((0, 3, 4), (0, 0.4, 0))
    with pytest.raises(cl.EditError, match='object "sphere": transform has unequal scales'):
        renderer.edit(
            lights={0: light.shifted((1, 0, 0))},
            camera=camera,
            transforms={"sphere": np.diag([1.0, 2.0, 1.0, 1.0])},
        )
    assert renderer.light(0) == light and renderer.camera.eye == CAMERA.eye
    assert np.array_equal(renderer.render(), first)

    renderer.edit(
        lights={0: light.shifted((1, 0, 0)), renderer.lights[1]: renderer.light(1).with_radiance(1)},
        transforms={"cube": shift(0, 0.5, 0), renderer.objects[2]: shift(0.1, 0, 0)},
        materials={0: cl.Material.lambert(0.2)},
        object_materials={"sphere": 0},
        visible={"sphere": False},
        visibility={"cube": "rays"},
        camera=camera,
        size=(30, 20),
        time=0,
    )
    edited = renderer.render()
    other = cl.Renderer(stage())
    other.set_light(0, light.shifted((1, 0, 0)))
    other.set_light(1, other.light(1).with_radiance(1))
    other.set_transform("cube", shift(0, 0.5, 0))
    other.set_transform(2, shift(0.1, 0, 0))
    other.set_material(0, cl.Material.lambert(0.2))
    other.set_object_material("sphere", 0)
    other.set_visible("sphere", False)
    other.set_visibility("cube", "rays")
    other.set_camera(camera)
    other.set_size(30, 20)
    assert np.array_equal(other.render(), edited)


def test_settings_are_changed(scene):
    renderer = cl.Renderer(scene, tolerance=0.1, samples=1)
    rough = renderer.render()
    renderer.set_settings(tolerance=0.001)
    assert renderer.settings.tolerance == 0.001 and renderer.settings.samples == 1
    fine = renderer.render()
    assert not np.array_equal(rough, fine)
    assert renderer.stats["tolerance"] == pytest.approx(0.001) and renderer.stats["points"] > 0
    with pytest.raises(ValueError, match="tolerance is 2: expected a number above 0, 1 at most"):
        renderer.set_settings(tolerance=2)
    renderer.set_settings(cl.Settings(samples=1), tolerance=0.1)
    assert np.array_equal(renderer.render(), rough)


def test_what_a_pixel_shows(scene):
    renderer = cl.Renderer(scene)
    pick = renderer.pick(24, 16)
    assert pick.name == "cube" and pick.object == renderer.objects[1] and pick.light is None
    assert pick.material == renderer.object_material("cube")
    assert np.linalg.norm(pick.normal) == pytest.approx(1)
    assert pick.distance == pytest.approx(np.linalg.norm(np.subtract(pick.position, CAMERA.eye)), rel=1e-5)
    assert renderer.pick(0, 99) is None


def test_handles_are_of_one_renderer(scene):
    first, second = cl.Renderer(scene), cl.Renderer(scene)
    assert len({*first.lights, *first.lights}) == 2 and first.lights[0] != second.lights[0]
    with pytest.raises(cl.EditError, match="the light is one of another renderer"):
        second.light(first.lights[0])
    with pytest.raises(cl.EditError, match="the object is one of another renderer"):
        second.name(first.objects[0])
    with pytest.raises(IndexError, match="light 7 is not in the scene: there are 2"):
        first.light(7)
    assert first.light(-1) == first.light(1)
    with pytest.raises(KeyError, match='no object is named "cup"'):
        first.name("cup")
    with pytest.raises(TypeError, match="light is of type str: expected a handle or a number"):
        first.light("key")


def test_two_objects_of_one_name():
    scene = stage()
    scene.add_mesh(*quad((0, 2, 0), (0.1, 0, 0), (0, 0, 0.1)), name="cube")
    with pytest.raises(KeyError, match='several objects are named "cube"'):
        cl.Renderer(scene).transform("cube")


def turned(x, z, angle):
    matrix = shift(x, 0.15, z)
    matrix[0, 0] = matrix[2, 2] = np.cos(angle)
    matrix[0, 2], matrix[2, 0] = np.sin(angle), -np.sin(angle)
    return matrix


def test_a_mesh_at_places_is_the_picture_of_copies():
    places = np.array([turned(x, z, x + z) for x in (-1, 0, 1) for z in (-0.5, 0.5)])
    many, copies = stage(size=(48, 32)), stage(size=(48, 32))
    positions, triangles = cube((0, 0, 0), 0.3)
    many.add_mesh(positions, triangles, name="many", places=places)
    joined = np.concatenate([positions @ m[:3, :3].T + m[:3, 3] for m in places])
    copies.add_mesh(joined, np.concatenate([np.asarray(triangles) + i * len(positions) for i in range(len(places))]), name="copies")
    renderer = cl.Renderer(many)
    assert np.abs(renderer.render() - cl.Renderer(copies).render()).max() < 1e-3
    assert np.allclose(renderer.places("many"), places) and renderer.places("cube") is None

    # Edits prepare nothing of the mesh again, and lead to what a new renderer shows.
    before = renderer.upkeep
    renderer.set_places("many", places[:4] + shift(0, 0.1, 0) - np.eye(4))
    moved = renderer.render()
    assert "silhouette_builds" not in new_counts(renderer, before)
    fresh = stage(size=(48, 32))
    fresh.add_mesh(positions, triangles, name="many", places=list(places[:4] + shift(0, 0.1, 0) - np.eye(4)))
    assert np.array_equal(cl.Renderer(fresh).render(), moved)


@pytest.mark.parametrize(
    "words, message",
    [
        ({"places": 3}, "places is of type int: expected an array of shape"),
        ({"places": []}, "places: "),
        ({"places": [np.eye(4), np.eye(3)]}, r"places\[1\]"),
        ({"places": [np.zeros((4, 4))]}, "last row"),
        ({"places": [np.diag([1, 0, 1, 1])]}, "place 0: its matrix"),
        ({"places": [np.eye(4)], "spheres": 8}, "places are given"),
    ],
)
def test_places_that_cannot_be_are_refused(scene, words, message):
    count = len(cl.Renderer(scene).objects)
    with pytest.raises((TypeError, ValueError), match=message):
        scene.add_mesh(*cube((0, 0, 0), 0.3), **words)
    assert len(cl.Renderer(scene).objects) == count


def test_only_meshes_at_places_have_others(scene):
    with pytest.raises(ValueError, match="cube was not added with places"):
        cl.Renderer(scene).set_places("cube", [np.eye(4)])
