"""Baking: the direct light of diffuse surfaces, into the image texture that is active in an object's material."""

import warnings

import bpy
import numpy as np

from . import camera, materials, meshes
from .export import Exporter
from .live import Live
from .notes import Notes, Refused


def surface(mesh, matrix, layer, wanted):
    """Positions, normals and texture coordinates of the corners of triangles in the world, `(n, 3, …)`: of those whose material slot is wanted."""
    mesh.calc_loop_triangles()
    loops = meshes._read(mesh.loop_triangles, "loops", np.int32, 3)
    slots = np.zeros(len(loops), dtype=np.int32)
    if len(mesh.materials) > 1:
        slots = np.minimum(meshes._read(mesh.loop_triangles, "material_index", np.int32, 1), len(mesh.materials) - 1)
    loops = loops[np.isin(slots, wanted)]
    if np.linalg.det(matrix[:3, :3]) < 0:
        # Mirrored triangles go round the other way.
        loops = loops[:, ::-1]
    vertices = meshes._read(mesh.loops, "vertex_index", np.int32, 1)[loops]
    positions = meshes._read(mesh.vertices, "co", np.float32, 3)[vertices] @ matrix[:3, :3].T + matrix[:3, 3]
    normals = meshes._read(mesh.corner_normals, "vector", np.float32, 3)[loops] @ np.linalg.inv(matrix[:3, :3])
    return positions, normals, meshes._read(layer.uv, "vector", np.float32, 2)[loops]


def targets(object, notes):
    """The images of the active image textures of an object's materials, each with the material slots that are baked to it."""
    found, bare = {}, []
    for number, slot in enumerate(object.material_slots):
        tree = slot.material and slot.material.node_tree
        node = tree and tree.nodes.active
        if node is not None and node.bl_idname == "ShaderNodeTexImage" and node.image is not None:
            found.setdefault(node.image.name, (node.image, []))[1].append(number)
        else:
            bare.append(slot.material.name if slot.material else f"slot {number}")
    if not found:
        raise Refused(f"\"{object.name}\" has no image to bake to: add an Image Texture node with an image, and make it active")
    for name in bare:
        notes.add(object.name, f"faces of \"{name}\" are not baked: it has no active Image Texture node with an image")
    return list(found.values())


def _corners(depsgraph, object, slots):
    """The arrays of an object's corners that are baked to one image."""
    evaluated = object.evaluated_get(depsgraph)
    mesh = evaluated.to_mesh(preserve_all_data_layers=True, depsgraph=depsgraph)
    try:
        layer = mesh.uv_layers.active if mesh is not None else None
        if layer is None:
            raise Refused(f"\"{object.name}\" has no texture coordinates: unwrap it first")
        return surface(mesh, np.array(object.matrix_world, dtype=np.float64), layer, slots)
    finally:
        evaluated.to_mesh_clear()


def bake(depsgraph, surfaces, image, *, margin=16, samples=2, settings=None, notes=None, progress=None):
    """Lights the texels of an image: the radiance that a white diffuse surface would have, `(height, width, 3)`, the lower row first; and which
    texels lie on a surface. `surfaces` are objects with the material slots that show the image. Texels outside repeat the edge up to `margin`
    away."""
    import cosine_lobes as cl

    notes = notes if notes is not None else Notes()
    each = [_corners(depsgraph, object, slots) for object, slots in surfaces]
    positions, normals, uvs = (np.concatenate(arrays).reshape(-1, arrays[0].shape[2]) for arrays in zip(*each))
    names = ", ".join(object.name for object, _ in surfaces)
    if not len(positions):
        raise Refused(f"\"{names}\" has no face for \"{image.name}\"")
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.where(lengths > 0, normals, np.float32([0, 0, 1]))
    exporter = Exporter(bpy.data.images)
    live = Live(cl, exporter)
    # Baking looks from nowhere: any view will do.
    view = camera.View((0, 0, 0), (0, 0, -1), (0, 1, 0), "perspective", 40.0, (8, 8), (0, 0, 8, 8))
    live.show(exporter.snapshot(depsgraph), view, settings or {})
    notes.extend(live.notes)
    with warnings.catch_warnings():
        # Faces without an area are nothing to bake.
        warnings.simplefilter("ignore", cl.LobesWarning)
        made = live.renderer.bake(
            positions.astype(np.float32),
            np.arange(len(positions), dtype=np.uint32).reshape(-1, 3),
            np.stack([uvs[:, 0], 1 - uvs[:, 1]], axis=1).astype(np.float32),
            tuple(image.size),
            normals=normals.astype(np.float32),
            samples=samples,
            padding=margin,
            progress=progress,
        )
    if made["overlaps"]:
        notes.add(names, f"{made['overlaps']} texels are covered more than once: texture coordinates overlap, and show a mean")
    if made["beyond"]:
        notes.add(names, f"{made['beyond']} triangles reach beyond the image and are cut there")
    covered = made["covered"][::-1]
    if not covered.any():
        raise Refused(f"\"{names}\" covers no texel of \"{image.name}\"")
    return made["irradiance"][::-1] / np.float32(np.pi), covered


def _note_reliefs(object, notes):
    for slot in object.material_slots:
        look = slot.material and materials.read(slot.material, Notes())
        if look and look.normal_image:
            notes.add(object.name, f"the normal map of \"{slot.material.name}\" is not in its light")


def _chosen(context):
    """The selected meshes, with and without a window."""
    return [object for object in context.view_layer.objects if object.type == "MESH" and object.select_get()]


class OBJECT_OT_cosine_lobes_bake(bpy.types.Operator):
    """Bake the direct light of white diffuse surfaces into the active image texture of the selected meshes"""

    bl_idname = "object.cosine_lobes_bake"
    bl_label = "Bake Direct Light"
    bl_options = {"REGISTER", "UNDO"}

    margin: bpy.props.IntProperty(name="Margin", description="Texels around the edges", default=16, min=0, max=256)
    samples: bpy.props.IntProperty(
        name="Samples", description="Points along the side of a texel, which is the mean over their square", default=2, min=1, max=8
    )

    @classmethod
    def poll(cls, context):
        return bool(_chosen(context))

    def execute(self, context):
        import cosine_lobes as cl

        from .engine import engine_settings

        notes = Notes()
        depsgraph = context.evaluated_depsgraph_get()
        settings = engine_settings(context.scene, is_viewport=False)
        window = context.window_manager
        window.progress_begin(0, 1)
        try:
            # Objects that show one image are baked to it together.
            images = {}
            for object in _chosen(context):
                _note_reliefs(object, notes)
                for image, slots in targets(object, notes):
                    images.setdefault(image.name, (image, []))[1].append((object, slots))
            for number, (image, surfaces) in enumerate(images.values()):
                tell = lambda stage, done: window.progress_update((number + done) / len(images))
                options = {"margin": self.margin, "samples": self.samples, "settings": settings}
                light, _ = bake(depsgraph, surfaces, image, **options, notes=notes, progress=tell)
                write(image, light)
        except (Refused, ValueError, cl.LobesError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            window.progress_end()
        for line in notes.lines:
            self.report({"WARNING"}, line)
        return {"FINISHED"}


def write(image, light):
    """Writes linear radiance into an image; one of bytes gets sRGB's curve, cut at 1."""
    from .images import _encode

    values = light if image.is_float or image.colorspace_settings.name == "Non-Color" else _encode(light)
    pixels = np.ones((*values.shape[:2], image.channels), dtype=np.float32)
    pixels[..., : min(3, image.channels)] = values[..., : image.channels]
    image.pixels.foreach_set(pixels.ravel())
    image.update()


classes = (OBJECT_OT_cosine_lobes_bake,)
