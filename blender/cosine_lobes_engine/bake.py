"""Baking: the direct light of diffuse surfaces, into the image texture that is active in an object's material."""

import bpy
import numpy as np

from . import camera, meshes
from .export import Exporter
from .live import Live
from .notes import Notes, Refused

#: Points that are lit at once.
BATCH = 1 << 18


class Texels:
    """The texels of an image whose centres lie on triangles: where they are, and how often they are covered."""

    def __init__(self, width, height):
        self.size = (width, height)
        self.triangle = np.full((height, width), -1, dtype=np.int64)
        self.weights = np.zeros((height, width, 3))
        self.twice = self.outside = 0

    def add(self, number, corners):
        """Rasterises a triangle of texture coordinates (3 × 2), v upward; rows are from below."""
        width, height = self.size
        p = corners * (width, height) - 0.5
        low, high = np.ceil(p.min(axis=0) - 1e-9).astype(int), np.floor(p.max(axis=0) + 1e-9).astype(int)
        if (low < 0).any() or high[0] >= width or high[1] >= height:
            self.outside += 1
            low, high = np.maximum(low, 0), np.minimum(high, (width - 1, height - 1))
        (a, b, c), twice = p, np.cross(p[1] - p[0], p[2] - p[0])
        if twice == 0 or (high < low).any():
            return
        y, x = np.mgrid[low[1] : high[1] + 1, low[0] : high[0] + 1]
        edge = lambda q, r: ((r[0] - q[0]) * (y - q[1]) - (r[1] - q[1]) * (x - q[0])) / twice
        weights = np.stack([edge(b, c), edge(c, a), edge(a, b)], axis=-1)
        inside = (weights >= -1e-9).all(axis=-1)
        part = np.s_[low[1] : high[1] + 1, low[0] : high[0] + 1]
        # On the edge between two triangles is no overlap.
        self.twice += int((inside & (self.triangle[part] >= 0) & (weights > 1e-6).all(axis=-1) & (self.weights[part] > 1e-6).all(axis=-1)).sum())
        self.triangle[part] = np.where(inside, number, self.triangle[part])
        self.weights[part] = np.where(inside[..., None], weights, self.weights[part])


def surface(mesh, matrix, layer):
    """Positions, normals and texture coordinates of the corners of all triangles in the world, `(n, 3, …)`."""
    mesh.calc_loop_triangles()
    loops = meshes._read(mesh.loop_triangles, "loops", np.int32, 3)
    vertices = meshes._read(mesh.loops, "vertex_index", np.int32, 1)[loops]
    positions = meshes._read(mesh.vertices, "co", np.float32, 3)[vertices] @ matrix[:3, :3].T + matrix[:3, 3]
    normals = meshes._read(mesh.corner_normals, "vector", np.float32, 3)[loops] @ np.linalg.inv(matrix[:3, :3])
    return positions, normals, meshes._read(layer.uv, "vector", np.float32, 2)[loops].astype(np.float64)


def target(object):
    """The image of the active image texture in an object's material."""
    for slot in object.material_slots:
        tree = slot.material and slot.material.node_tree
        node = tree and tree.nodes.active
        if node is not None and node.bl_idname == "ShaderNodeTexImage" and node.image is not None:
            return node.image
    raise Refused(f"\"{object.name}\" has no image to bake to: add an Image Texture node with an image, and make it active")


def bake(depsgraph, object, image, *, margin=16, settings=None, notes=None):
    """Lights the texels of an image: the radiance that a white diffuse surface would have, `(height, width, 3)`, the lower row first; and which
    texels lie on the object. Texels outside repeat the nearest ones up to `margin` away."""
    import cosine_lobes as cl

    notes = notes if notes is not None else Notes()
    evaluated = object.evaluated_get(depsgraph)
    mesh = evaluated.to_mesh(preserve_all_data_layers=True, depsgraph=depsgraph)
    try:
        layer = mesh.uv_layers.active if mesh is not None else None
        if layer is None:
            raise Refused(f"\"{object.name}\" has no texture coordinates: unwrap it first")
        positions, normals, uvs = surface(mesh, np.array(object.matrix_world, dtype=np.float64), layer)
    finally:
        evaluated.to_mesh_clear()
    texels = Texels(*image.size)
    for number, corners in enumerate(uvs):
        texels.add(number, corners)
    if texels.twice:
        notes.add(object.name, f"{texels.twice} texels are covered more than once: its texture coordinates overlap")
    if texels.outside:
        notes.add(object.name, f"{texels.outside} triangles reach beyond the image and are cut there")
    covered = texels.triangle >= 0
    if not covered.any():
        raise Refused(f"\"{object.name}\" covers no texel of \"{image.name}\"")
    exporter = Exporter(bpy.data.images)
    live = Live(cl, exporter)
    # Baking looks from nowhere: any view will do.
    view = camera.View((0, 0, 0), (0, 0, -1), (0, 1, 0), "perspective", 40.0, (8, 8), (0, 0, 8, 8))
    live.show(exporter.snapshot(depsgraph), view, settings or {})
    notes.extend(live.notes)
    light = _lit(live, positions, normals, texels, covered)
    return _dilated(light, covered, margin), covered


def _lit(live, positions, normals, texels, covered):
    triangles, weights = texels.triangle[covered], texels.weights[covered][..., None]
    points = (positions[triangles] * weights).sum(axis=1)
    shading = (normals[triangles] * weights).sum(axis=1)
    shading /= np.maximum(np.linalg.norm(shading, axis=1, keepdims=True), 1e-12)
    flat = np.cross(positions[:, 1] - positions[:, 0], positions[:, 2] - positions[:, 0])[triangles]
    # Mirrored objects turn their triangles over.
    flat *= np.sign((flat * shading).sum(axis=1, keepdims=True)) + 1e-30
    flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-30)
    light = np.zeros((*covered.shape, 3), dtype=np.float32)
    lit = [
        live.renderer.shade(points[i : i + BATCH], shading[i : i + BATCH], faces=flat[i : i + BATCH])
        for i in range(0, len(points), BATCH)
    ]
    light[covered] = np.concatenate(lit)
    return light


def _dilated(light, covered, margin):
    """Fills texels beside the covered ones with the mean of their known neighbours, ring by ring."""
    light, known = light.copy(), covered.copy()
    for _ in range(margin):
        if known.all():
            break
        padded, count = np.pad(light * known[..., None], ((1, 1), (1, 1), (0, 0))), np.pad(known.astype(np.float32), 1)
        shifts = [(y, x) for y in (0, 1, 2) for x in (0, 1, 2) if (y, x) != (1, 1)]
        height, width = known.shape
        total = sum(padded[y : y + height, x : x + width] for y, x in shifts)
        number = sum(count[y : y + height, x : x + width] for y, x in shifts)
        ring = ~known & (number > 0)
        light[ring] = total[ring] / number[ring][:, None]
        known |= ring
    return light


def _chosen(context):
    """The selected meshes, with and without a window."""
    return [object for object in context.view_layer.objects if object.type == "MESH" and object.select_get()]


class OBJECT_OT_cosine_lobes_bake(bpy.types.Operator):
    """Bake the direct light of white diffuse surfaces into the active image texture of the selected meshes"""

    bl_idname = "object.cosine_lobes_bake"
    bl_label = "Bake Direct Light"
    bl_options = {"REGISTER", "UNDO"}

    margin: bpy.props.IntProperty(name="Margin", description="Texels around the edges", default=16, min=0, max=256)

    @classmethod
    def poll(cls, context):
        return bool(_chosen(context))

    def execute(self, context):
        import cosine_lobes as cl

        from .engine import engine_settings

        notes = Notes()
        depsgraph = context.evaluated_depsgraph_get()
        settings = engine_settings(context.scene, is_viewport=False)
        try:
            for object in _chosen(context):
                image = target(object)
                light, _ = bake(depsgraph, object, image, margin=self.margin, settings=settings, notes=notes)
                write(image, light)
        except (Refused, ValueError, cl.LobesError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
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
