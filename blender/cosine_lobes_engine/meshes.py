"""Evaluated meshes as arrays: one for each material of an object, vertices doubled where normals or coordinates differ."""

from dataclasses import dataclass, field
from typing import Optional

import numpy as np


@dataclass(eq=False)
class Part:
    """The triangles of one material slot, in the object's own coordinates."""

    slot: int
    positions: np.ndarray
    triangles: np.ndarray
    # None where faces are flat.
    normals: Optional[np.ndarray] = None
    # None where no image needs them.
    uvs: Optional[np.ndarray] = None
    # Polygons as lists of corners' positions, for what emits.
    polygons: list = field(default_factory=list)

    def same(self, other):
        """Whether all arrays are equal."""
        pairs = [(self.positions, other.positions), (self.triangles, other.triangles), (self.normals, other.normals), (self.uvs, other.uvs)]
        return self.slot == other.slot and all(_equal(a, b) for a, b in pairs)


def _equal(a, b):
    if a is None or b is None:
        return a is b
    return a is b or (a.shape == b.shape and np.array_equal(a, b))


def _read(collection, name, dtype, width):
    values = np.empty(len(collection) * width, dtype=dtype)
    collection.foreach_get(name, values)
    return values.reshape(-1, width) if width > 1 else values


def parts(mesh, uv_layer_of):
    """The parts of an evaluated mesh. `uv_layer_of(slot)` is the name of the coordinates that the slot's material reads: "" for those that are active for
    rendering, None for none."""
    mesh.calc_loop_triangles()
    if not mesh.loop_triangles:
        return []
    loops = _read(mesh.loop_triangles, "loops", np.int32, 3)
    slots = np.zeros(len(loops), dtype=np.int32)
    if len(mesh.polygons) and len(mesh.materials) > 1:
        slots = _read(mesh.loop_triangles, "material_index", np.int32, 1)
    vertex_of = _read(mesh.loops, "vertex_index", np.int32, 1)
    positions = _read(mesh.vertices, "co", np.float32, 3)
    # Normals of corners only where the corners of a vertex differ.
    domain = mesh.normals_domain
    normals = None if domain == "FACE" else _read(mesh.corner_normals, "vector", np.float32, 3)
    made = []
    for slot in np.unique(slots):
        corners = loops[slots == slot].ravel()
        layer = _layer(mesh, uv_layer_of(int(slot)))
        uvs = None if layer is None else _read(layer.uv, "vector", np.float32, 2)
        made.append(_part(int(slot), corners, vertex_of, (positions, normals, uvs), domain == "CORNER"))
    return made


def _layer(mesh, name):
    if name is None or not len(mesh.uv_layers):
        return None
    if name:
        return mesh.uv_layers.get(name)
    return next((layer for layer in mesh.uv_layers if layer.active_render), mesh.uv_layers[0])


def _part(slot, corners, vertex_of, arrays, has_creases):
    positions, normals, uvs = arrays
    vertices = vertex_of[corners]
    ids = vertices.astype(np.int64)
    if has_creases:
        ids = _paired(ids, _numbered(normals[corners]))
    if uvs is not None:
        ids = _paired(ids, _numbered(uvs[corners]))
    _, first, index = np.unique(ids, return_index=True, return_inverse=True)
    # In the order of the corners.
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    first = first[order]
    return Part(
        slot,
        np.ascontiguousarray(positions[vertices[first]]),
        rank[index].reshape(-1, 3).astype(np.uint32),
        None if normals is None else _unit(normals[corners[first]]),
        None if uvs is None else _downward(uvs[corners[first]]),
    )


def _numbered(rows):
    """A number for each row of single-precision numbers: equal rows have equal ones."""
    bits = np.ascontiguousarray(rows).view(np.uint32).astype(np.uint64)
    ids = np.unique(bits[:, 0] << np.uint64(32) | bits[:, 1], return_inverse=True)[1].astype(np.int64)
    return ids if rows.shape[1] == 2 else _paired(ids, np.unique(bits[:, 2], return_inverse=True)[1])


def _paired(a, b):
    """A number for each pair of two numbers."""
    pairs = a.astype(np.int64) * (int(b.max(initial=0)) + 1) + b
    return np.unique(pairs, return_inverse=True)[1].astype(np.int64)


def _unit(normals):
    """Without zeros, which Blender has at loose corners."""
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.where(lengths > 0, normals, np.float32([0, 0, 1])).astype(np.float32)


def _downward(uvs):
    """Blender's v grows upward, the engine's downward."""
    return np.stack([uvs[:, 0], 1 - uvs[:, 1]], axis=1).astype(np.float32)


def faces(mesh, slot, most):
    """The corners of the polygons of a slot, as arrays; None where there are more than `most`."""
    chosen = [p for p in mesh.polygons if p.material_index == slot or len(mesh.materials) <= 1]
    if len(chosen) > most:
        return None
    return [np.array([mesh.vertices[v].co[:] for v in p.vertices], dtype=np.float64) for p in chosen]
