"""Viewports, as far as they go without a window: views from matrices, and pictures that follow edits. Drawing on the screen needs a window."""

import sys
import time
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

import stage
from cosine_lobes_engine import camera as cameras
from cosine_lobes_engine.engine import CosineLobesEngine, live_of
from cosine_lobes_engine.export import Touched
from cosine_lobes_engine.notes import Notes
from cosine_lobes_engine.worker import Worker, reduced

SIZE = (64, 48)


def context_of(camera, size=SIZE):
    """A viewport that looks through a camera."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    window = camera.calc_matrix_camera(depsgraph, x=size[0], y=size[1])
    data = SimpleNamespace(window_matrix=window, view_matrix=camera.matrix_world.inverted())
    return SimpleNamespace(region=SimpleNamespace(width=size[0], height=size[1]), region_data=data, space_data=None)


def simple():
    stage.reset(*SIZE)
    stage.plane(look=stage.material())
    cube = stage.cube(look=stage.material("red", Base_Color=(0.8, 0.2, 0.1)))
    stage.lamp("AREA", (1.5, 1, 3), energy=200, size=1)
    camera = stage.camera()
    bpy.context.view_layer.update()
    return cube, camera


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
@pytest.mark.parametrize("fit", ["AUTO", "HORIZONTAL", "VERTICAL"])
def test_a_view_from_matrices_is_the_camera_s(fit, kind):
    _, camera = simple()
    camera.data.type, camera.data.ortho_scale = kind, 5.0
    camera.data.sensor_fit, camera.data.shift_x, camera.data.shift_y = fit, 0.125, -0.25
    context = context_of(camera)
    made = cameras.of_viewport(context.region_data.window_matrix, context.region_data.view_matrix, SIZE)
    wanted = cameras.of_scene(bpy.context.scene, camera, Notes())
    assert (made.frame, made.window, made.projection) == (wanted.frame, wanted.window, wanted.projection)
    for name in ("eye", "forward", "up", "extent"):
        assert np.allclose(getattr(made, name), getattr(wanted, name), atol=1e-4), name


def test_orthographic_views_begin_behind_the_eye():
    """A viewport's planes are as far behind the eye as before it: all between them is seen."""
    _, camera = simple()
    left, right, low, high, far = -2.0, 4.0, -1.5, 3.0, 100.0
    window = np.diag([2 / (right - left), 2 / (high - low), -1 / far, 1.0])
    window[:2, 3] = -(right + left) / (right - left), -(high + low) / (high - low)
    view = cameras.of_viewport(window, camera.matrix_world.inverted(), SIZE)
    eye, forward = np.array(camera.matrix_world.translation), np.array(view.forward)
    assert view.projection == "orthographic" and np.allclose(view.eye, eye - far * forward, atol=1e-3)
    # 48 pixels are 4.5 units; the axis meets the picture a third of its width from the left, and two thirds of its height from the top.
    assert np.isclose(view.extent / view.frame[1], 4.5 / 48)
    x, y, width, height = view.window
    assert (width, height) == SIZE and abs(view.frame[0] / 2 - x - 64 / 3) <= 0.25 and abs(view.frame[1] / 2 - y - 32) <= 0.25


def test_an_orthographic_viewport_has_a_picture():
    _, camera = simple()
    camera.data.type, camera.data.ortho_scale = "ORTHO", 3.0
    bpy.context.view_layer.update()
    worker = Worker(SimpleNamespace(tag_redraw=lambda: None), *live_of())
    context = context_of(camera)
    worker.update(context, bpy.context.evaluated_depsgraph_get(), Touched())
    first = finished(worker, context)
    assert worker.message == "" and first[..., :3].max() > 0.1
    camera.data.ortho_scale = 4.0
    bpy.context.view_layer.update()
    second = finished(worker, context_of(camera))
    assert not np.array_equal(first, second)
    assert worker._live.renderer.upkeep["hierarchy_builds"] == 1
    worker.stop()


def test_reduced_views_show_the_same_place():
    _, camera = simple()
    view = cameras.of_scene(bpy.context.scene, camera, Notes())
    small = reduced(view, 4)
    assert small.window == (0, 0, 16, 12) and small.frame == (16, 12) and reduced(view, 1) == view


def finished(worker, context):
    """The picture once the thread is done."""
    worker.picture(context, bpy.context.evaluated_depsgraph_get())
    for _ in range(400):
        if not worker._thread.is_alive():
            break
        time.sleep(0.02)
    return worker.picture(context, bpy.context.evaluated_depsgraph_get())


def test_a_viewport_follows_edits_and_equals_a_new_one():
    cube, camera = simple()
    redraws = []
    worker = Worker(SimpleNamespace(tag_redraw=lambda: redraws.append(1)), *live_of())
    context, depsgraph = context_of(camera), bpy.context.evaluated_depsgraph_get()
    worker.update(context, depsgraph, Touched())
    first = finished(worker, context)
    assert first.shape == (SIZE[1], SIZE[0], 4) and len(redraws) == 2 and worker.message == ""
    renderer = worker._live.renderer
    cube.location.x = 0.5
    bpy.context.view_layer.update()
    worker.update(context, bpy.context.evaluated_depsgraph_get(), Touched(everything=False))
    second = finished(worker, context)
    assert worker._live.renderer is renderer and renderer.upkeep["hierarchy_builds"] == 1
    new = Worker(SimpleNamespace(tag_redraw=lambda: None), *live_of())
    new.update(context, bpy.context.evaluated_depsgraph_get(), Touched())
    assert np.array_equal(second, finished(new, context)) and not np.array_equal(first, second)
    # The camera alone.
    camera.location.z += 0.5
    bpy.context.view_layer.update()
    assert not np.array_equal(second, finished(worker, context_of(camera)))
    worker.stop()
    new.stop()


def test_a_scene_without_light_says_so():
    _, camera = simple()
    for made in [o for o in bpy.data.objects if o.type == "LIGHT"]:
        bpy.data.objects.remove(made)
    worker = Worker(SimpleNamespace(tag_redraw=lambda: None), *live_of())
    worker.update(context_of(camera), bpy.context.evaluated_depsgraph_get(), Touched())
    assert worker.picture(context_of(camera), bpy.context.evaluated_depsgraph_get()) is None
    assert "the scene has no light" in worker.message


def test_a_newer_view_stops_the_picture_at_once():
    _, camera = simple()
    size = (1600, 1200)
    worker = Worker(SimpleNamespace(tag_redraw=lambda: None), *live_of(), divisors=(1,))
    worker.update(context_of(camera), bpy.context.evaluated_depsgraph_get(), Touched())
    worker.picture(context_of(camera, size), bpy.context.evaluated_depsgraph_get())
    start = time.monotonic()
    worker.stop()
    assert time.monotonic() - start < 2 and worker._shown is None


def test_the_engine_draws_its_picture(monkeypatch):
    """The calls of drawing, on a graphics module that only listens."""
    _, camera = simple()
    calls, textures = [], []
    texture = lambda size, format, data: textures.append((size, format, len(data))) or "texture"
    gpu = SimpleNamespace(
        types=SimpleNamespace(Buffer=lambda kind, size, data: data if (kind, size) == ("FLOAT", len(data)) else None, GPUTexture=texture),
        state=SimpleNamespace(blend_set=lambda mode: calls.append(mode)),
    )
    presets = SimpleNamespace(draw_texture_2d=lambda *arguments: calls.append(arguments))
    for name, module in (("gpu", gpu), ("gpu_extras", SimpleNamespace(presets=presets)), ("gpu_extras.presets", presets)):
        monkeypatch.setitem(sys.modules, name, module)
    engine = SimpleNamespace(
        _worker=None,
        tag_redraw=lambda: None,
        update_stats=lambda *_: None,
        bind_display_space_shader=lambda scene: calls.append("bind"),
        unbind_display_space_shader=lambda: calls.append("unbind"),
    )
    engine.view_update = lambda *arguments: CosineLobesEngine.view_update(engine, *arguments)
    context, depsgraph = context_of(camera), bpy.context.evaluated_depsgraph_get()
    CosineLobesEngine.view_draw(engine, context, depsgraph)
    finished(engine._worker, context)
    calls.clear()
    for _ in range(2):
        CosineLobesEngine.view_draw(engine, context, depsgraph)
    once = ["ALPHA_PREMULT", "bind", ("texture", (0, 0), *SIZE), "unbind", "NONE"]
    assert calls == 2 * once
    # One texture for one picture, however often it is drawn.
    assert textures[-1] == (SIZE, "RGBA16F", 4 * SIZE[0] * SIZE[1]) and len(textures) <= 2
    engine._worker.stop()
