"""The render engine: F12, animations and viewports."""

import bpy

from . import camera, draw, picture
from .export import Exporter, Touched
from .live import Live
from .notes import Notes, Refused
from .worker import Worker

#: The renderer of an animation, kept from frame to frame: the name of the scene and of the view layer, and the renderer.
_kept = {}


def engine_settings(scene, is_viewport):
    """The settings of the engine's renderer, by their keywords."""
    own = scene.cosine_lobes
    tolerance = own.viewport_tolerance if is_viewport else own.tolerance
    return {"tolerance": round(tolerance, 6), "samples": 1 if is_viewport else own.samples or None}


def live_of(key=None):
    """A renderer with its exporter; with a key the one that is kept under it."""
    import cosine_lobes as cl

    if key in _kept:
        return _kept[key]
    exporter = Exporter(bpy.data.images)
    pair = (exporter, Live(cl, exporter))
    if key is not None:
        _kept.clear()
        _kept[key] = pair
    return pair


class _Stopped(Exception):
    """The person has pressed Escape."""


class CosineLobesEngine(bpy.types.RenderEngine):
    """Direct light with exact soft shadows."""

    bl_idname = "COSINE_LOBES"
    bl_label = "Cosine Lobes"
    bl_use_preview = False
    bl_use_postprocess = True
    bl_use_eevee_viewport = True
    bl_use_shading_nodes_custom = False
    bl_use_spherical_stereo = False

    _worker = None

    def __del__(self):
        worker = getattr(self, "_worker", None)
        if worker is not None:
            worker.stop()

    def update_render_passes(self, scene, layer):
        self.register_pass(scene, layer, "Combined", 4, "RGBA", "COLOR")
        for name, width, chans, kind in passes_of(layer):
            self.register_pass(scene, layer, name, width, chans, kind)

    def render(self, depsgraph):
        try:
            self._render(depsgraph)
        except _Stopped:
            pass
        except Refused as error:
            self._fail(str(error))
        except ImportError as error:
            self._fail(f"the package cosine_lobes cannot be loaded: {error}")
        except Exception as error:
            import cosine_lobes as cl

            if not isinstance(error, (cl.LobesError, ValueError, MemoryError)):
                raise
            self._fail(str(error))

    def _fail(self, message):
        self.report({"ERROR"}, message)
        self.error_set(message)

    def _render(self, depsgraph):
        scene, layer = depsgraph.scene_eval, depsgraph.view_layer_eval
        notes = Notes()
        viewed = self.camera_override or scene.camera
        if viewed is None:
            raise Refused("the scene has no camera")
        view = camera.of_scene(scene, viewed.evaluated_get(depsgraph), notes)
        if scene.render.use_motion_blur:
            notes.add(scene.name, "motion blur is not supported")
        self.update_stats("", "Reading the scene")
        exporter, live = live_of((scene.name_full, layer.name) if self.is_animation else None)
        live.show(exporter.snapshot(depsgraph), view, engine_settings(scene, is_viewport=False))
        wanted = [entry[0] for entry in passes_of(layer)]
        for name, width, chans, _ in passes_of(layer):
            self.add_pass(name, width, chans, layer=layer.name)
        part = border(scene, view)
        made = self._pictures(live, camera.cropped(view, part), wanted, scene.render.film_transparent)
        self._write(part[2:], made, layer)
        notes.extend(live.notes)
        for line in notes.lines:
            self.report({"WARNING"}, line)

    def _pictures(self, live, view, wanted, is_transparent):
        def progress(stage, done):
            self.update_stats("", stage.capitalize())
            self.update_progress(done)
            if self.test_break():
                raise _Stopped

        if not wanted:
            return {"Combined": picture.render(live, view, is_transparent=is_transparent, progress=progress)}
        groups = [name.removeprefix("Combined_") for name in wanted if name.startswith("Combined_")]
        return picture.render_passes(
            live, view, {"passes": wanted, "groups": groups}, is_transparent=is_transparent, progress=progress
        )

    def _write(self, size, made, layer):
        # Of a region Blender keeps the region alone.
        result = self.begin_result(0, 0, *size, layer=layer.name)
        if (result.resolution_x, result.resolution_y) != size:
            self.end_result(result, cancel=True)
            raise Refused(f"Blender's picture has {result.resolution_x} × {result.resolution_y} pixels instead of {size[0]} × {size[1]}")
        for name, pixels in made.items():
            into = result.layers[0].passes.get(name)
            if into is not None:
                into.rect.foreach_set(picture.flat(pixels))
        self.end_result(result)

    # Viewports.

    def view_update(self, context, depsgraph):
        try:
            if self._worker is None:
                self._worker = Worker(self, *live_of())
            self._worker.update(context, depsgraph, touched_of(depsgraph))
        except ImportError as error:
            self.update_stats("Cosine Lobes", f"the package cosine_lobes cannot be loaded: {error}")

    def view_draw(self, context, depsgraph):
        if self._worker is None:
            self.view_update(context, depsgraph)
        if self._worker is None:
            return
        shown = self._worker.picture(context, depsgraph)
        self.update_stats("Cosine Lobes", self._worker.message)
        if shown is not None:
            self._drawn = draw.show(self, depsgraph.scene, context.region, shown, getattr(self, "_drawn", None))


def touched_of(depsgraph):
    """The meshes and images that a depsgraph says have changed."""
    meshes, images = set(), set()
    for update in depsgraph.updates:
        kind = type(update.id)
        if kind is bpy.types.Image:
            images.add(update.id.name)
        elif update.is_updated_geometry:
            meshes.add(update.id.name_full)
    return Touched(everything=False, meshes=frozenset(meshes), images=frozenset(images))


def passes_of(layer):
    """Passes of a view layer beside the picture: name, channels, their letters, kind."""
    named = []
    if layer.use_pass_z:
        named.append(("Depth", 1, "Z", "VALUE"))
    if layer.use_pass_normal:
        named.append(("Normal", 3, "XYZ", "VECTOR"))
    named += [(f"Combined_{group.name}", 3, "RGB", "COLOR") for group in layer.lightgroups]
    return named


def border(scene, view):
    """The part of the picture that is rendered: left column, upper row, width, height."""
    _, _, width, height = view.window
    render = scene.render
    if not render.use_border:
        return (0, 0, width, height)
    # As Blender rounds it.
    left, right = int(render.border_min_x * width), int(render.border_max_x * width)
    low, high = int(render.border_min_y * height), int(render.border_max_y * height)
    if right <= left or high <= low:
        raise Refused("the render region is empty")
    return (left, height - high, right - left, high - low)
