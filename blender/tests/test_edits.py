"""Edits lead to the picture of a new renderer, bit for bit, and rebuild nothing that stays the same."""

import bpy
import numpy as np

import stage
from cosine_lobes_engine import camera as cameras
from cosine_lobes_engine.engine import engine_settings, touched_of
from cosine_lobes_engine.export import Touched


class Session:
    """A renderer that follows the scene by what the depsgraph says has changed."""

    def __init__(self):
        self.live, _ = stage.live()
        self.touched = None
        bpy.app.handlers.depsgraph_update_post.append(self.hear)
        self.follow(Touched())

    def hear(self, _scene, depsgraph):
        """What a viewport hears by view_update."""
        self.touched = touched_of(depsgraph)

    def follow(self, touched=None):
        bpy.context.view_layer.update()
        touched, self.touched = touched or self.touched or Touched(everything=False), None
        depsgraph = bpy.context.evaluated_depsgraph_get()
        scene = bpy.context.scene
        snapshot = self.live._exporter.snapshot(depsgraph, touched)
        view = cameras.of_scene(scene, scene.camera.evaluated_get(depsgraph), snapshot.notes)
        self.live.show(snapshot, view, engine_settings(scene, False))
        return self.live.renderer.render(window=view.window)


def scene_of_edits():
    stage.reset(64, 48)
    stage.plane(look=stage.material("floor", Base_Color=(0.7, 0.7, 0.7)))
    first = stage.cube(0.8, stage.material("red", Base_Color=(0.8, 0.2, 0.1), Specular_IOR_Level=0.5))
    ball = stage.sphere(0.4, first.data.materials[0], (0.9, 0.3, 0.4), 24, 12)
    area = stage.lamp("AREA", (1.5, 1, 3), energy=200, size=1)
    point = stage.lamp("POINT", (-2, -1, 2), energy=80, shadow_soft_size=0.2)
    stage.world((0.05, 0.06, 0.1))
    stage.camera()
    return first, ball, area, point


def test_twenty_edits_in_a_row_equal_a_new_renderer():
    first, ball, area, point = scene_of_edits()
    red, scene = first.data.materials[0], bpy.context.scene
    principled = red.node_tree.nodes["Principled BSDF"].inputs
    background = scene.world.node_tree.nodes["Background"].inputs
    session = Session()
    made = []

    def new_lamp():
        made.append(stage.lamp("SPOT", (0, -3, 3), energy=150, spot_size=0.8, shadow_soft_size=0.1))

    def new_mesh():
        made.append(stage.cube(0.3, red, (-0.8, -0.6, 0.15), "small"))

    edits = [
        lambda: setattr(first, "location", (0.1, 0.2, 0.5)),
        lambda: setattr(first, "rotation_euler", (0.1, 0.2, 0.3)),
        lambda: setattr(first, "scale", (1.2, 0.7, 1)),
        lambda: setattr(area, "location", (1.2, 1.1, 2.8)),
        lambda: setattr(area.data, "energy", 250),
        lambda: setattr(point.data, "shadow_soft_size", 0.3),
        lambda: setattr(point.data, "color", (1, 0.5, 0.2)),
        lambda: setattr(principled["Base Color"], "default_value", (0.2, 0.6, 0.3, 1)),
        lambda: setattr(principled["Roughness"], "default_value", 0.3),
        lambda: setattr(scene.camera, "location", (2.8, -4, 3.1)),
        lambda: setattr(scene.camera.data, "shift_x", 0.125),
        lambda: setattr(background["Strength"], "default_value", 2),
        new_lamp,
        new_mesh,
        lambda: setattr(ball.data.vertices[5], "co", (0.1, 0.1, 0.5)) or ball.data.update(),
        lambda: setattr(ball.modifiers.new("array", "ARRAY"), "count", 2),
        lambda: setattr(made[1], "location", (-0.9, -0.6, 0.4)),
        lambda: bpy.data.objects.remove(point),
        lambda: setattr(ball, "visible_shadow", False),
        lambda: bpy.data.objects.remove(first),
    ]
    assert len(edits) == 20
    before = session.follow()
    for number, edit in enumerate(edits):
        edit()
        picture = session.follow()
        new, view = stage.live()
        assert np.array_equal(picture, new.renderer.render(window=view.window)), f"edit {number}"
        assert not np.array_equal(picture, before), f"edit {number} shows nothing"
        before = picture


def test_what_stays_is_not_built_again():
    first, _, area, _ = scene_of_edits()
    session = Session()
    renderer, counts = session.live.renderer, lambda: dict(session.live.renderer.upkeep)
    session.follow()
    start = counts()
    area.location.x += 0.2
    session.follow()
    assert counts() == start and session.live.renderer is renderer
    first.location.x += 0.2
    session.follow()
    assert counts()["hierarchy_builds"] == start["hierarchy_builds"] and counts()["hierarchy_refits"] > start["hierarchy_refits"]
    assert session.live.renderer is renderer


def test_images_that_are_painted_show():
    stage.reset(48, 36)
    stage.camera((0.5, -2.5, 2.2), (0, 0, 0))
    stage.lamp("AREA", (-1, -1, 2.5), energy=150, size=1)
    look = stage.material("painted")
    stage.plane(3, look).data.uv_layers.new(name="uv").uv.foreach_set("vector", [0, 0, 1, 0, 1, 1, 0, 1])
    image = bpy.data.images.new("paint", 16, 16, alpha=True)
    node = look.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    inputs = look.node_tree.nodes["Principled BSDF"].inputs
    look.node_tree.links.new(node.outputs["Color"], inputs["Base Color"])
    look.node_tree.links.new(node.outputs["Alpha"], inputs["Alpha"])
    pixels = np.ones((16, 16, 4), np.float32)
    image.pixels.foreach_set(pixels.ravel())
    session = Session()
    first = session.follow()
    # A red half, of which a part is cut away.
    pixels[:8, :, 1:3], pixels[:4, :8, 3] = 0.1, 0
    image.pixels.foreach_set(pixels.ravel())
    second = session.follow(Touched(everything=False, images=frozenset({"paint"})))
    new, view = stage.live()
    assert np.array_equal(second, new.renderer.render(window=view.window)) and not np.array_equal(first, second)
    assert (second[..., 0] > 2 * second[..., 1]).any() and ((second == 0).all(axis=2) & (first > 0).all(axis=2)).any()


def test_an_animation_keeps_its_renderer(tmp_path):
    first, *_ = scene_of_edits()
    scene = bpy.context.scene
    for frame, x in ((1, 0.0), (3, 0.6)):
        first.location.x = x
        first.keyframe_insert("location", frame=frame)
    scene.frame_start, scene.frame_end = 1, 3
    scene.render.engine = "COSINE_LOBES"
    scene.render.filepath = str(tmp_path / "frame_")
    bpy.ops.render.render(animation=True)
    from cosine_lobes_engine import engine

    ((_, live),) = engine._kept.values()
    assert live.renderer.upkeep["hierarchy_builds"] == 1
    for frame in (1, 2, 3):
        scene.frame_set(frame)
        assert np.array_equal(stage.load(str(tmp_path / f"frame_{frame:04}.exr")), stage.render())


def test_a_mesh_that_is_shown_many_times_is_stored_once(monkeypatch):
    first, ball, _, _ = scene_of_edits()
    bpy.data.objects.remove(first)
    big = stage.sphere(0.2, ball.data.materials[0], (-1.2, -1, 0.2), 96, 48)
    copies = [big]
    for number in range(1, 15):
        made = big.copy()
        made.location = (-1.2 + 0.5 * (number % 5), -1 + 0.6 * (number // 5), 0.2)
        made.rotation_euler, made.scale = (0.1 * number, 0, 0.3 * number), (1, 1, 0.6 + 0.02 * number)
        bpy.context.scene.collection.objects.link(made)
        copies.append(made)
    # Too flat to be a place of a shared mesh.
    copies[3].scale = (1, 1, 1e-5)
    session = Session()
    renderer = session.live.renderer
    places = [renderer.places(handle) for handle in renderer.objects]
    assert sorted(len(found) for found in places if found is not None) == [14] and len(places) == 4
    picture = session.follow()
    with monkeypatch.context() as patch:
        patch.setattr("cosine_lobes_engine.places.LEAST_SAVED", 10**9)
        alone, view = stage.live()
        assert len(alone.renderer.objects) == 17
        assert np.abs(alone.renderer.render(window=view.window) - picture).max() < 2e-3 * picture.max()

    # Moved, gone, and changed: as a new renderer has it, and without new silhouettes where the mesh stays.
    builds = renderer.upkeep["silhouette_builds"]
    for edit in (
        lambda: setattr(copies[5], "location", (0.3, -0.8, 0.5)),
        lambda: bpy.data.objects.remove(copies.pop()),
        lambda: setattr(big.data.vertices[0], "co", (0, 0, 0.4)) or big.data.update(),
    ):
        edit()
        before, picture = picture, session.follow()
        new, view = stage.live()
        assert np.array_equal(picture, new.renderer.render(window=view.window)) and not np.array_equal(before, picture)
        if session.live.renderer is renderer:
            assert renderer.upkeep["silhouette_builds"] == builds
    assert session.live.renderer is not renderer
