"""What a depsgraph shows, as records that can be compared: the engine's scene before it is made."""

from dataclasses import dataclass, field, replace
from typing import Any, Optional

import numpy as np

from . import lights, materials, meshes, places, world
from .notes import Notes

#: Kinds of objects that are surfaces.
_SURFACES = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
#: Kinds that are nothing to see, or are handled elsewhere.
_SILENT = {"EMPTY", "CAMERA", "ARMATURE", "LATTICE", "SPEAKER", "LIGHT_PROBE"}
#: Emitting objects of more polygons give no light.
MOST_EMITTING = 24


@dataclass(eq=False)
class Thing:
    """An object of the engine: one part of one instance, or of many alike."""

    name: str
    part: meshes.Part
    matrix: np.ndarray
    look: int
    # Whether the camera sees it, and whether it casts shadows.
    visible: bool = True
    blocks: bool = True
    # Matrices of all instances where it stands for many.
    places: Optional[np.ndarray] = None


@dataclass
class Lamp:
    """A light, and the group that it belongs to."""

    name: str
    recipe: Any
    group: str = ""


@dataclass
class Snapshot:
    """All of a scene but camera and size."""

    things: dict = field(default_factory=dict)
    lamps: dict = field(default_factory=dict)
    looks: list = field(default_factory=list)
    # Arrays of images by kind and picture, for the looks.
    image_of: Any = None
    sky: world.Sky = field(default_factory=world.Sky)
    sky_group: str = ""
    notes: Notes = field(default_factory=Notes)
    # Names of images whose pixels were touched since the last snapshot.
    touched_images: frozenset = frozenset()


@dataclass
class Touched:
    """The data that has changed since the last snapshot; `everything` where that is not known."""

    everything: bool = True
    meshes: frozenset = frozenset()
    images: frozenset = frozenset()


class Exporter:
    """Makes snapshots, and reads again only the meshes that were touched."""

    def __init__(self, images):
        self._images = images
        self._parts = {}
        self._pictures = {}
        # Of the present snapshot: looks and their numbers, and parts that were used and read.
        self._numbers, self._seen, self._read_now = {}, set(), set()

    def snapshot(self, depsgraph, touched=Touched(), viewport=None):
        """The scene of an evaluated depsgraph. `viewport` is a 3D viewport whose local view and hidden objects count."""
        notes = Notes()
        if touched.everything or touched.images:
            self._pictures = {k: v for k, v in self._pictures.items() if not (touched.everything or k[2] & touched.images)}
        snapshot = Snapshot(notes=notes, image_of=self._image_of(notes), touched_images=touched.images)
        self._numbers, self._seen, self._read_now = {}, set(), set()
        for instance in depsgraph.object_instances:
            if instance.show_self and (viewport is None or instance.object.visible_in_viewport_get(viewport)):
                self._add(snapshot, instance, depsgraph, touched)
        self._parts = {key: parts for key, parts in self._parts.items() if key in self._seen}
        snapshot.things = places.gathered(snapshot.things)
        scene = depsgraph.scene_eval
        snapshot.sky = world.read(scene.world, notes)
        snapshot.sky_group = getattr(scene.world, "lightgroup", "") if scene.world else ""
        return snapshot

    def _image_of(self, notes):
        read = materials.image_of(self._images, notes)

        def image_of(kind, picture):
            key = (kind, picture, picture.images)
            if key not in self._pictures:
                self._pictures[key] = read(kind, picture)
            return self._pictures[key]

        return image_of

    def sky_picture(self, sky, notes):
        """The picture of a sky; none without one."""
        if sky.image is None:
            return None
        key = ("sky", sky.image, frozenset((sky.image,)))
        if key not in self._pictures:
            self._pictures[key] = world.texels(self._images[sky.image], notes)
        return self._pictures[key]

    def _add(self, snapshot, instance, depsgraph, touched):
        object = instance.object
        key = (object.name_full, tuple(instance.persistent_id) if instance.is_instance else ())
        if instance.is_instance and instance.parent is not None:
            key = (instance.parent.name_full, *key)
        matrix = np.array(instance.matrix_world, dtype=np.float64)
        if object.type == "LIGHT":
            if object.visible_camera:
                snapshot.notes.add(object.name, "the camera does not see lights")
            self._note_linking(object, snapshot.notes)
            recipe = lights.convert(object.data, matrix, snapshot.notes)
            if recipe is not None:
                snapshot.lamps[key] = Lamp(object.name, recipe, getattr(object, "lightgroup", ""))
        elif object.type in _SURFACES:
            self._add_surface(snapshot, key, object, matrix, depsgraph, touched)
        elif object.type not in _SILENT:
            snapshot.notes.add(object.name, f"objects of the kind {object.type} are not supported")

    def _add_surface(self, snapshot, key, object, matrix, depsgraph, touched):
        notes = snapshot.notes
        scale = np.linalg.det(matrix[:3, :3])
        if not np.isfinite(matrix).all() or scale == 0:
            notes.add(object.name, "is scaled to nothing and left out")
            return
        if not object.visible_camera and not object.visible_shadow:
            return
        for name in ("is_holdout", "is_shadow_catcher"):
            if getattr(object, name, False):
                notes.add(object.name, f"{name[3:].replace('_', ' ')} is not supported: it is rendered as any surface")
        looks = [self._look(snapshot, slot.material) for slot in object.material_slots] or [self._look(snapshot, None)]
        for part in self._parts_of(object, looks, snapshot, depsgraph, touched):
            look = looks[min(part.slot, len(looks) - 1)]
            if look.is_hidden:
                continue
            thing = Thing(object.name, part, matrix, self._number(snapshot, look), object.visible_camera, object.visible_shadow)
            snapshot.things[(*key, part.slot)] = thing
            if look.emits:
                self._emit(snapshot, key, object, part, look, matrix)

    @staticmethod
    def _note_linking(object, notes):
        linking = getattr(object, "light_linking", None)
        if linking and (linking.receiver_collection or linking.blocker_collection):
            notes.add(object.name, "light linking is not supported: it lights everything")

    def _look(self, snapshot, material):
        name = material.name_full if material else None
        known = self._numbers.get(("material", name))
        if known is None:
            known = self._numbers[("material", name)] = materials.read(material, snapshot.notes)
        return known

    def _number(self, snapshot, look):
        # By identity of value: equal materials are one.
        number = self._numbers.get(look)
        if number is None:
            number = self._numbers[look] = len(snapshot.looks)
            snapshot.looks.append(look)
        return number

    def _parts_of(self, object, looks, snapshot, depsgraph, touched):
        """The parts of an object's mesh in its own coordinates, read once for all of its instances."""
        wanted = tuple((look.layer, look.place, look.alpha_image, look.alpha_limit, look.emits) for look in looks)
        data = object.data.name_full if object.data else object.name_full
        # Modifiers and shapes make one mesh of their own for each object.
        is_own = object.type != "MESH" or object.modifiers or object.data.shape_keys
        key = (object.name_full if is_own else None, data, wanted)
        self._seen.add(key)
        cut_by_touched = any(look.alpha_image and look.alpha_image.images & touched.images for look in looks)
        is_touched = touched.everything or cut_by_touched or not touched.meshes.isdisjoint((object.name_full, data))
        if key in self._parts and (not is_touched or key in self._read_now):
            return self._parts[key]
        self._read_now.add(key)
        mesh = object.to_mesh(preserve_all_data_layers=True, depsgraph=depsgraph)
        try:
            parts = [] if mesh is None else self._read(mesh, looks, snapshot, object.name)
        finally:
            object.to_mesh_clear()
        old = self._parts.get(key)
        if old is not None and len(old) == len(parts) and all(a.same(b) for a, b in zip(old, parts)):
            parts = old
        self._parts[key] = parts
        return parts

    def _read(self, mesh, looks, snapshot, name):
        of_slot = lambda slot: looks[min(slot, len(looks) - 1)]
        parts = meshes.parts(mesh, lambda slot: of_slot(slot).layer)
        made = []
        for part in parts:
            look = of_slot(part.slot)
            if look.layer is not None and part.uvs is None:
                snapshot.notes.add(name, "has no texture coordinates: its images show one texel")
                part = replace(part, uvs=np.zeros((len(part.positions), 2), np.float32))
            if part.uvs is not None:
                part = replace(part, uvs=materials.placed(part.uvs, look.place))
            if look.alpha_image is not None:
                part = self._cut(part, look, snapshot, name)
            if look.emits:
                part = replace(part, polygons=meshes.faces(mesh, part.slot, MOST_EMITTING))
            if len(part.triangles):
                made.append(part)
        return made

    def _cut(self, part, look, snapshot, name):
        """Without what alpha hides."""
        import cosine_lobes as cl

        alpha = snapshot.image_of("number", look.alpha_image)
        if alpha is None:
            return part
        try:
            cut = cl.cut_out(part.positions, part.triangles, part.uvs, alpha, limit=look.alpha_limit, normals=part.normals)
        except ValueError as error:
            snapshot.notes.add(name, str(error))
            return part
        positions, triangles, normals, uvs = cut
        return replace(part, positions=positions, triangles=triangles, normals=normals, uvs=uvs)

    def _emit(self, snapshot, key, object, part, look, matrix):
        """Flat lights for the faces of what emits."""
        if look.emission_image is not None:
            snapshot.notes.add(object.name, "emits an image, which lights no other object")
            return
        if not part.polygons:
            snapshot.notes.add(object.name, f"emits, but has more than {MOST_EMITTING} faces: it lights no other object")
            return
        for number, corners in enumerate(part.polygons):
            corners = corners @ matrix[:3, :3].T + matrix[:3, 3]
            arguments = {"corners": tuple(map(tuple, corners)), "radiance": look.emission, "two_sided": True}
            lamp = Lamp(object.name, ("polygon", arguments), getattr(object, "lightgroup", ""))
            snapshot.lamps[(*key, part.slot, "face", number)] = lamp
