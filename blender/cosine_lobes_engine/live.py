"""A renderer that follows snapshots: each change becomes the smallest edit, so that nothing is built again that stays the same."""

import warnings

import numpy as np

from . import lights, materials, world
from .notes import Notes, Refused


class Live:
    """The engine's renderer of one scene, and what it shows."""

    def __init__(self, cl, exporter):
        self._cl, self._exporter = cl, exporter
        self._renderer = None
        self._settings = None
        self.notes = Notes()

    @property
    def renderer(self):
        return self._renderer

    def show(self, snapshot, view, settings):
        """Makes the renderer show a snapshot through a view; builds it where edits would not give the same picture to the bit."""
        self.notes = Notes()
        self.notes.extend(snapshot.notes)
        self._sky_picture = self._exporter.sky_picture(snapshot.sky, self.notes)
        lamps = self._lamps(snapshot)
        if not lamps and not snapshot.sky.shines and not any(look.emits for look in snapshot.looks):
            raise Refused("the scene has no light: add a light, or a world with a colour and strength")
        if not snapshot.things:
            raise Refused("the scene has no surface that can be rendered")
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", self._cl.LobesWarning)
            self._apply(snapshot, lamps, view, settings)
        for warning in caught:
            self.notes.add("Engine", str(warning.message))
        self._snapshot, self._settings = snapshot, settings

    def _apply(self, snapshot, lamps, view, settings):
        try:
            if self._renderer is None or settings != self._settings or not self._follows(snapshot):
                self._build(snapshot, lamps, view, settings)
            else:
                self._edit(snapshot, lamps, view)
        except Exception:
            # Half of the edits may be done.
            self._renderer = None
            raise

    def look(self, view):
        """Moves the camera alone."""
        self._set_view(view)

    @property
    def groups(self):
        """The light groups of the renderer's lights, in their order; those of the sky come last."""
        named = [lamp.group for lamp in self._lamp_records.values()]
        return named + [self._snapshot.sky_group] * (len(self._renderer.lights) - len(named))

    @property
    def sky_group(self):
        return self._snapshot.sky_group if self._snapshot.sky.shines else ""

    def behind(self, view):
        """What pixels without a surface show."""
        return world.behind(self._snapshot.sky, self._sky_picture, view)

    def _lamps(self, snapshot):
        """The lights that the engine takes, by their keys."""
        made = {}
        for key, lamp in snapshot.lamps.items():
            try:
                made[key] = (lamp, lights.made(self._cl, lamp.recipe))
            except (ValueError, self._cl.LobesError) as error:
                self.notes.add(lamp.name, f"gives no light: {error}")
        return made

    def _follows(self, snapshot):
        """Whether edits lead to the order that a new renderer would have: what stays, in its order, and then what is new. A mesh at many
        places cannot change."""
        kept = [key for key in self._things if key in snapshot.things]
        pairs = [(snapshot.things[key], self._things[key][1]) for key in kept]
        if any(thing.places is not None and not thing.part.same(before.part) for thing, before in pairs):
            return False
        new = [key for key in snapshot.things if key not in self._things]
        return kept + new == list(snapshot.things)

    def _build(self, snapshot, lamps, view, settings):
        cl = self._cl
        self._renderer = None
        scene = cl.Scene(size=view.frame, camera=view.camera(cl), background=0)
        self._looks = {}
        for look in snapshot.looks:
            self._looks[look] = scene.add_material(self._material(snapshot, look))
        for thing in snapshot.things.values():
            scene.add_mesh(**_arrays(thing.part), material=self._looks[snapshot.looks[thing.look]], **_manner(thing))
        for _, light in lamps.values():
            scene.add_light(light)
        scene.set_environment(world.environment(cl, snapshot.sky, self._sky_picture))
        self._renderer = renderer = cl.Renderer(scene, **settings)
        self._place = view.place
        self._looks = dict(zip(self._looks, renderer.materials))
        self._things = dict(zip(snapshot.things, zip(renderer.objects, snapshot.things.values())))
        self._handles = dict(zip(lamps, renderer.lights))
        self._lamp_records = {key: lamp for key, (lamp, _) in lamps.items()}
        renderer.edit(transforms={handle: thing.matrix for handle, thing in self._things.values() if thing.places is None})

    def _material(self, snapshot, look):
        try:
            return materials.made(self._cl, look, snapshot.image_of)
        except (ValueError, self._cl.LobesError) as error:
            self.notes.add("Material", f"is grey: {error}")
            return self._cl.Material.lambert(0.8)

    def _edit(self, snapshot, lamps, view):
        self._set_view(view)
        self._edit_looks(snapshot)
        self._edit_things(snapshot)
        self._edit_lamps(snapshot, lamps)
        if snapshot.sky != self._snapshot.sky or snapshot.sky.image in snapshot.touched_images:
            self._renderer.set_environment(world.environment(self._cl, snapshot.sky, self._sky_picture))

    def _set_view(self, view):
        renderer = self._renderer
        if view.frame != renderer.size:
            renderer.set_size(*view.frame)
        if view.place != self._place:
            renderer.set_camera(view.camera(self._cl))
            self._place = view.place

    def _edit_looks(self, snapshot):
        """New materials, and changed images of old ones. Materials that nothing uses stay until the renderer is built again."""
        for look in snapshot.looks:
            is_touched = any(picture.images & snapshot.touched_images for picture in look.pictures)
            if look not in self._looks:
                self._looks[look] = self._renderer.add_material(self._material(snapshot, look))
            elif is_touched:
                self._renderer.set_material(self._looks[look], self._material(snapshot, look))

    def _edit_things(self, snapshot):
        renderer, old = self._renderer, self._snapshot
        for key in [key for key in self._things if key not in snapshot.things]:
            renderer.remove_object(self._things.pop(key)[0])
        transforms = {}
        for key, thing in snapshot.things.items():
            look = self._looks[snapshot.looks[thing.look]]
            if key not in self._things:
                handle = renderer.add_mesh(**_arrays(thing.part), material=look, **_manner(thing))
                if thing.places is None:
                    transforms[handle] = thing.matrix
            else:
                handle, before = self._things[key]
                if self._edit_thing(handle, before, thing, look, old):
                    transforms[handle] = thing.matrix
            self._things[key] = (handle, thing)
        if transforms:
            renderer.edit(transforms=transforms)

    def _edit_thing(self, handle, before, thing, look, old):
        """Edits one object; returns whether its transform must be set."""
        renderer, part = self._renderer, thing.part
        is_new = part is not before.part and not part.same(before.part)
        if is_new:
            renderer.set_mesh(handle, **_arrays(part))
        if look != self._looks[old.looks[before.look]]:
            renderer.set_object_material(handle, look)
        if thing.visible != before.visible:
            renderer.set_visible(handle, thing.visible)
        if thing.blocks != before.blocks:
            renderer.set_visibility(handle, None if thing.blocks else "none")
        if thing.places is not None:
            if not np.array_equal(thing.places, before.places):
                renderer.set_places(handle, thing.places)
            return False
        return is_new or not np.array_equal(thing.matrix, before.matrix)

    def _edit_lamps(self, snapshot, lamps):
        renderer = self._renderer
        if list(self._handles) != list(lamps):
            # Lights are free to make: in the order of a new renderer.
            for handle in self._handles.values():
                renderer.remove_light(handle)
            renderer.set_environment(None)
            self._handles = {key: renderer.add_light(light) for key, (_, light) in lamps.items()}
            renderer.set_environment(world.environment(self._cl, snapshot.sky, self._sky_picture))
        else:
            for key, (lamp, light) in lamps.items():
                if lamp.recipe != self._lamp_records[key].recipe:
                    renderer.set_light(self._handles[key], light)
        self._lamp_records = {key: lamp for key, (lamp, _) in lamps.items()}


def _arrays(part):
    return {"positions": part.positions, "triangles": part.triangles, "normals": part.normals, "uvs": part.uvs}


def _manner(thing):
    manner = {"name": thing.name, "visible": thing.visible, "visibility": None if thing.blocks else "none"}
    # Without spheres: they could not follow unequal scales.
    return {**manner, "spheres": 0} if thing.places is None else {**manner, "places": thing.places}
