"""F12: regions, percentages, transparent films, passes, light groups; and what is left out is said."""

import math

import bpy
import numpy as np
import pytest

import cosine_lobes as cl
import stage
from cosine_lobes_engine import picture as pictures


def simple(width=64, height=48):
    scene = stage.reset(width, height)
    stage.plane(3, look=stage.material(Base_Color=(0.7, 0.7, 0.7)))
    stage.cube(look=stage.material("red", Base_Color=(0.8, 0.2, 0.1)))
    stage.lamp("AREA", (1.5, 1, 3), energy=200, size=1)
    stage.camera()
    return scene


def test_a_region_is_a_part_of_the_picture():
    scene = simple()
    whole = stage.render()
    render = scene.render
    render.use_border = render.use_crop_to_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.125, 0.5
    assert np.array_equal(stage.render(), whole[24:42, 16:48])
    render.use_crop_to_border = False
    part = stage.render()
    assert part.shape == whole.shape and np.array_equal(part[24:42, 16:48], whole[24:42, 16:48])
    assert (part[:24, :, :3] == 0).all()


def test_a_percentage_is_a_smaller_picture():
    scene = simple(128, 96)
    scene.render.resolution_percentage = 50
    half = stage.render()
    assert half.shape[:2] == (48, 64)
    scene = simple()
    assert np.array_equal(half, stage.render())


def test_a_transparent_film():
    scene = simple()
    stage.world((0.3, 0.4, 0.5))
    opaque = stage.render()
    assert (opaque[..., 3] == 1).all() and opaque[0, 0, :3] == pytest.approx([0.3, 0.4, 0.5], rel=1e-3)
    scene.render.film_transparent = True
    scene.cosine_lobes.samples = 4
    clear = stage.render()
    assert (clear[0, 0] == 0).all() and clear[30, 32, 3] == 1
    edges = (clear[..., 3] > 0) & (clear[..., 3] < 1)
    assert edges.any() and (clear[edges][:, :3] >= 0).all()


def test_light_groups_add_up(tmp_path):
    scene = simple()
    layer = bpy.context.view_layer
    for name, owner in (("key", bpy.data.objects["area"]), ("rest", stage.lamp("POINT", (-2, -1, 2), energy=50)), ("sky", stage.world((0.1, 0.1, 0.2)))):
        layer.lightgroups.add(name=name)
        owner.lightgroup = name
    scene.render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    scene.render.engine, scene.render.filepath = "COSINE_LOBES", str(tmp_path / "layers.exr")
    bpy.ops.render.render(write_still=True)
    read = lambda name: cl.read_exr(tmp_path / "layers.exr", layer=f"{layer.name}.{name}")
    groups = [read(f"Combined_{name}") for name in ("key", "rest", "sky")]
    assert all(group.max() > 0.01 for group in groups)
    assert np.allclose(sum(groups), read("Combined"), rtol=1e-4, atol=1e-5)


def test_depth_and_normals():
    simple()
    made, view = stage.live()
    wanted = {"passes": ["Depth", "Normal"], "groups": []}
    passes = pictures.render_passes(made, view, wanted)
    # Along the camera's axis, of the floor in the lower middle.
    pick = made.renderer.pick(32, 44)
    along = np.dot(np.array(pick.position) - view.eye, view.forward)
    assert passes["Depth"][44, 32, 0] == pytest.approx(along, rel=1e-3) and passes["Depth"][0, 0, 0] == 1e10
    assert passes["Normal"][44, 32] == pytest.approx([0, 0, 1], abs=1e-5)


def test_custom_normals():
    """A floor whose custom normals lean by 0.6 is as bright as their cosine says, under a sun from above."""
    stage.reset()
    floor = stage.plane(4, stage.material("grey"))
    floor.data.normals_split_custom_set_from_vertices([(0.6, 0, 0.8)] * 4)
    stage.lamp("SUN", (0, 0, 5), energy=math.pi)
    stage.camera((0, 0, 5), (0, 0, 0))
    assert stage.render()[36, 48, 0] == pytest.approx(0.8 * 0.8, rel=2e-3)


def notes():
    made, _ = stage.live()
    return "\n".join(made.notes.lines)


def test_what_is_not_supported_is_said():
    scene = simple()
    inputs = bpy.data.materials["red"].node_tree.nodes["Principled BSDF"].inputs
    inputs["Sheen Weight"].default_value = 0.5
    inputs["Transmission Weight"].default_value = 1
    area = bpy.data.objects["area"]
    area.data.spread, area.data.use_shadow = 1.0, False
    scene.camera.data.dof.use_dof = True
    scene.render.pixel_aspect_x = 2
    said = notes()
    for line in (
        'red: "Sheen Weight" is not supported',
        'red: "Transmission Weight" is not supported',
        "area: its spread of 57°",
        "area: it casts shadows all the same",
        "camera: depth of field",
        "Output: pixels of 2 : 1",
    ):
        assert line in said, f"{line!r} in {said}"


def test_warnings_of_the_engine_are_said():
    simple()
    stage.mesh("sliver", [(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0)], [(0, 1, 2), (0, 1, 3)])
    assert "1 triangles without an area are left out" in notes()


def failed(capfd):
    with pytest.raises(RuntimeError) as error:
        stage.render()
    return str(error.value) + capfd.readouterr().err


def test_scenes_that_cannot_be_rendered(capfd):
    scene = simple()
    data = scene.camera.data
    data.type = "PANO"
    own = data if hasattr(data, "panorama_type") else data.cycles
    own.panorama_type = "FISHEYE_EQUIDISTANT"
    assert "of type fisheye equidistant: only equirectangular" in failed(capfd)
    own.panorama_type, own.longitude_max = "EQUIRECTANGULAR", 1.0
    assert "no whole part of it" in failed(capfd)
    own.longitude_max = own.longitude_min
    assert "an empty range" in failed(capfd)
    data.type = "PERSP"
    bpy.data.objects.remove(bpy.data.objects["area"])
    assert "the scene has no light" in failed(capfd)
    stage.world((0.2, 0.2, 0.2))
    assert stage.render()[..., :3].max() > 0.1
    bpy.data.objects.remove(scene.camera)
    assert "camera" in failed(capfd)


def test_what_emits_lights_others():
    simple()
    bpy.data.objects.remove(bpy.data.objects["area"])
    lamp = stage.plane(0.5, stage.material("glow", Base_Color=(0.0, 0.0, 0.0), Emission_Color=(1.0, 1.0, 1.0), Emission_Strength=30.0), (0, 0, 2.5), "lamp")
    lamp.rotation_euler = stage.degrees(20, 10, 0)
    where = stage.inside()
    scene = bpy.context.scene
    scene.cycles.samples = 128
    assert stage.error(stage.render(), stage.render("CYCLES"), where) < 0.02
