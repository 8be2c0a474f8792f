use crate::library::command::{Key, LightChanges, MaterialKey, Objects, Points, RendererCommand};
use crate::library::fault::Fault;
use crate::library::given::{CameraGiven, SettingsGiven, directions, matrix, strategy};
use crate::library::mail::{Answer, Arrays, Memory};
use crate::library::material::MaterialGiven;
use crate::library::progress::Progress;
use crate::library::reference::reference;
use crate::library::scenes::{SceneItem, light_state, usual};
use bytemuck::cast_slice;
use glam::Vec3;
use lighting::Light;
use lobe_core::{NO_OBJECT, Receiver};
use renderer::{
    EditError, Image, LayerSet, Layers, LightHandle, MaterialHandle, ObjectHandle, RenderError, Renderer, Window,
};
use scene::{Object, Proxy, ShadingPoints, Shape};
use serde_json::{Value, json};
use session::lamp;

/// Spheres that are fitted to a mesh where none are given.
const SPHERES: usize = 64;

/// A renderer, and the handles by the numbers that JavaScript has for them.
#[derive(Debug)]
pub(crate) struct RendererItem {
    renderer: Renderer,
    lights: Numbers<LightHandle>,
    objects: Numbers<ObjectHandle>,
    materials: Numbers<MaterialHandle>,
    seconds: f64,
}

/// Handles in the order in which they came; their places are their numbers, which stay.
#[derive(Debug)]
struct Numbers<H>(Vec<H>);

impl<H: Copy + PartialEq> Numbers<H> {
    /// The numbers of handles, new ones included.
    fn of(&mut self, handles: impl Iterator<Item = H>) -> Vec<usize> {
        handles.map(|handle| self.number(handle)).collect()
    }

    fn number(&mut self, handle: H) -> usize {
        self.0.iter().position(|known| *known == handle).unwrap_or_else(|| {
            self.0.push(handle);
            self.0.len() - 1
        })
    }

    fn handle(&self, kind: &str, number: i64) -> Result<H, Fault> {
        let found = usize::try_from(number).ok().and_then(|place| self.0.get(place)).copied();
        found.ok_or_else(|| Fault::edit(format!("{kind} {number} is not in the scene")))
    }
}

impl RendererItem {
    pub(crate) fn new(item: &SceneItem, settings: &SettingsGiven) -> Result<Self, Fault> {
        let renderer = Renderer::new(item.scene.clone(), item.animation.clone(), settings.settings()?)?;
        let lights = renderer.lights().map(|(handle, _)| handle).collect();
        let objects = renderer.objects().map(|(handle, _)| handle).collect();
        let materials = renderer.materials().map(|(handle, _)| handle).collect();
        let (lights, objects, materials) = (Numbers(lights), Numbers(objects), Numbers(materials));
        Ok(Self { renderer, lights, objects, materials, seconds: 0.0 })
    }

    pub(crate) fn follow(&mut self, command: RendererCommand, arrays: Arrays<'_>) -> Result<Answer, Fault> {
        match command {
            RendererCommand::Render { window, listens } => self.render(window, &Progress::new(listens)),
            RendererCommand::Layers { names, window, listens } => self.layers(&names, window, &Progress::new(listens)),
            RendererCommand::Coverage { window } => {
                let coverage = self.renderer.coverage(&self.window(window)?)?;
                Ok(Answer { head: json!({}), arrays: Memory::Bytes(cast_slice(&coverage).to_vec()) })
            }
            RendererCommand::Reference { spp, seed, listens } => {
                reference(&mut self.renderer, spp, u64::from(seed), &Progress::new(listens))
            }
            RendererCommand::Shade(points) => self.shade(points, arrays),
            RendererCommand::VisibleFraction { point, normal, light } => {
                let light = self.lights.handle("light", light)?;
                let at = Receiver::on_surface(point, normal, normal);
                Ok(Answer::of(json!(self.renderer.visible_fraction(&at, light)?)))
            }
            RendererCommand::Pick { pixel: [x, y] } => Ok(Answer::of(self.pick(x, y))),
            RendererCommand::Exposure => Ok(Answer::of(json!(self.renderer.exposure()))),
            RendererCommand::State => Ok(Answer::of(self.state())),
            RendererCommand::Light { light } => Ok(Answer::of(light_state(self.light(light)?))),
            RendererCommand::Object { object } => self.object_state(&object).map(Answer::of),
            edit => self.edit(edit, arrays).map(Answer::of),
        }
    }

    /// Edits that return numbers, and all others.
    fn edit(&mut self, command: RendererCommand, arrays: Arrays<'_>) -> Result<Value, Fault> {
        match command {
            RendererCommand::AddMesh { mesh, manner, material } => {
                let (mesh, removed) = mesh.mesh(arrays)?;
                let object = manner.mesh(mesh, self.renderer.scene().objects.len(), arrays)?;
                Ok(json!({ "number": self.add(object, material, arrays)?, "removed": removed }))
            }
            RendererCommand::AddSpheres { rows, manner, material } => {
                let object = manner.spheres(rows, self.renderer.scene().objects.len(), arrays)?;
                Ok(json!({ "number": self.add(object, material, arrays)? }))
            }
            RendererCommand::SetMesh { object, mesh } => {
                let handle = self.object(&object)?;
                let proxy = match &self.object_item(handle)?.proxy {
                    Proxy::Count(count) => Proxy::Count(*count),
                    _ => Proxy::Count(SPHERES),
                };
                let (mesh, removed) = mesh.mesh(arrays)?;
                self.renderer.set_shape(handle, Shape::Mesh(mesh), proxy)?;
                Ok(json!({ "removed": removed }))
            }
            RendererCommand::AddLight { light } => {
                let handle = self.renderer.add_light(light.light()?)?;
                Ok(json!({ "number": self.lights.number(handle) }))
            }
            RendererCommand::AddMaterial { material } => {
                let (material, surface) = material.material(arrays)?;
                let handle = self.renderer.add_material(material, surface)?;
                Ok(json!({ "number": self.materials.number(handle) }))
            }
            other => self.change(other, arrays).map(|()| Value::Null),
        }
    }

    /// Changes of what is in the scene.
    fn change(&mut self, command: RendererCommand, arrays: Arrays<'_>) -> Result<(), Fault> {
        match command {
            RendererCommand::SetLight { light, new } => {
                let handle = self.lights.handle("light", light)?;
                self.renderer.set_light(handle, new.light()?)?;
            }
            RendererCommand::ChangeLight { light, changes } => {
                let handle = self.lights.handle("light", light)?;
                let new = changed(self.light(light)?, changes);
                self.renderer.set_light(handle, new)?;
            }
            RendererCommand::RemoveLight { light } => {
                self.renderer.remove_light(self.lights.handle("light", light)?)?;
            }
            RendererCommand::SetEnvironment { environment } => {
                let bounds = self.renderer.scene().bounds();
                let environment = environment.map(|given| given.around(bounds, arrays)).transpose()?;
                self.renderer.set_environment(environment)?;
            }
            RendererCommand::RemoveObject { object } => {
                self.renderer.remove_object(self.object(&object)?)?;
            }
            RendererCommand::SetTransform { object, matrix: columns } => {
                self.renderer.set_transform(self.object(&object)?, matrix(&columns)?)?;
            }
            RendererCommand::SetVisible { object, visible } => {
                self.renderer.set_visible(self.object(&object)?, visible)?;
            }
            RendererCommand::SetVisibility { object, visibility } => {
                let strategy = strategy(visibility.as_deref())?;
                self.renderer.set_object_strategy(self.object(&object)?, strategy)?;
            }
            RendererCommand::SetMaterial { material, new } => {
                let handle = self.materials.handle("material", material)?;
                let (material, surface) = new.material(arrays)?;
                self.renderer.set_material(handle, material, surface)?;
            }
            RendererCommand::SetObjectMaterial { object, material } => {
                let material = self.materials.handle("material", material)?;
                self.renderer.set_object_material(self.object(&object)?, material)?;
            }
            other => return self.change_view(other),
        }
        Ok(())
    }

    /// Changes of how the scene is seen.
    fn change_view(&mut self, command: RendererCommand) -> Result<(), Fault> {
        match command {
            RendererCommand::SetCamera { camera } => {
                self.renderer.set_camera(camera.into())?;
            }
            RendererCommand::SetSize { size: [width, height] } => {
                self.renderer.set_size(width, height)?;
            }
            RendererCommand::SetBackground { background } => {
                self.renderer.set_background(background)?;
            }
            RendererCommand::SetSettings { settings } => {
                self.renderer.set_settings(settings.settings()?)?;
            }
            RendererCommand::Seek { time } => self.renderer.seek(time),
            _ => {}
        }
        Ok(())
    }

    /// A part of the picture: its left column, upper row, width and height; none for all of it.
    fn window(&self, part: Option<[usize; 4]>) -> Result<Window, Fault> {
        let [width, height] = [self.renderer.scene().width, self.renderer.scene().height].map(|side| side as usize);
        let Some([x, y, across, down]) = part else { return Ok(Window::whole(width, height)) };
        let is_inside = |first: usize, count: usize, all: usize| count > 0 && first < all && count <= all - first;
        if !(is_inside(x, across, width) && is_inside(y, down, height)) {
            let given = [x, y, across, down];
            return Err(Fault::range(format!("window is {given:?}: expected a part of {width} x {height} pixels")));
        }
        Ok(Window { image: [width, height], columns: x..x + across, rows: y..y + down })
    }

    fn render(&mut self, part: Option<[usize; 4]>, progress: &Progress) -> Result<Answer, Fault> {
        let window = self.window(part)?;
        let mut pixels = Vec::new();
        pixels.try_reserve_exact(window.pixels()).map_err(RenderError::from)?;
        pixels.resize(window.pixels(), Vec3::ZERO);
        let clock = Clock::start();
        self.renderer.render_into(&window, &mut |event| progress.hear(event), &mut pixels)?;
        self.seconds = clock.seconds();
        Ok(Answer { head: json!({ "size": window.size() }), arrays: Memory::Pixels(pixels) })
    }

    fn layers(&mut self, names: &[String], part: Option<[usize; 4]>, progress: &Progress) -> Result<Answer, Fault> {
        let (set, window) = (layer_set(names)?, self.window(part)?);
        self.renderer.set_layers(set)?;
        let image = self.renderer.render_window(&window, &mut |event| progress.hear(event));
        self.renderer.set_layers(LayerSet::NONE)?;
        let numbers = self.objects.of(self.renderer.objects().map(|(handle, _)| handle));
        Ok(named_layers(&image?, set, &numbers))
    }

    fn shade(&mut self, given: Points, arrays: Arrays<'_>) -> Result<Answer, Fault> {
        let positions = arrays.list::<Vec3>(given.points)?;
        let count = positions.len();
        let normals = directions("normals", given.normals, arrays)?;
        let views = given.views.map(|views| directions("views", views, arrays)).transpose()?;
        let faces = given.faces.map(|faces| directions("faces", faces, arrays)).transpose()?;
        let objects = self.objects_of(given.objects, count, arrays)?;
        let lists = [Some(&normals), views.as_ref(), faces.as_ref()];
        if objects.len() != count || lists.into_iter().flatten().any(|list| list.len() != count) {
            return Err(Fault::range(format!("expected arrays of {count} rows, one for each point")));
        }
        let receiver = |i: usize| Receiver {
            position: positions[i],
            normal: normals[i],
            face: faces.as_ref().map_or(normals[i], |faces| faces[i]),
            view: views.as_ref().map_or(normals[i], |views| views[i]),
            object: objects[i],
        };
        let (number, own) = match given.material {
            None => (0, Some([MaterialGiven::white()])),
            Some(MaterialKey::Own(material)) => (0, Some([material.material(arrays)?.0])),
            Some(MaterialKey::Number(number)) => (self.material_place(number)? as u32, None),
        };
        let points = ShadingPoints {
            receivers: (0..count).map(receiver).collect(),
            materials: vec![number; count],
            ..ShadingPoints::default()
        };
        let layers = LayerSet { unshadowed: given.layers, lights: given.layers, ..LayerSet::NONE };
        let light = self.renderer.shade_points(points, own.as_ref().map(<[_; 1]>::as_slice), layers)?;
        if !given.layers {
            return Ok(Answer { head: json!({}), arrays: Memory::Pixels(light.radiance) });
        }
        let layers = [("beauty", &light.radiance), ("unshadowed", &light.unshadowed)];
        let layers = layers.into_iter().map(|(name, layer)| (name.to_owned(), layer));
        Ok(Answer::named(layers.chain(numbered(&light.lights)).map(|(name, layer)| (name, cast_slice(layer)))))
    }

    /// The place in the scene of the object that each point is on.
    fn objects_of(&self, given: Option<Objects>, count: usize, arrays: Arrays<'_>) -> Result<Vec<u32>, Fault> {
        let place = |handle| {
            let place = self.renderer.objects().position(|(known, _)| known == handle);
            place.map(|place| place as u32).ok_or_else(|| Fault::from(EditError::NoObject(handle)))
        };
        match given {
            None => Ok(vec![NO_OBJECT; count]),
            Some(Objects::All(key)) => Ok(vec![place(self.object(&key)?)?; count]),
            Some(Objects::Each(each)) => {
                let numbers = arrays.list::<i32>(each)?;
                // Most points have their neighbour's object.
                let mut last = (-1, NO_OBJECT);
                let of = |number: i32| {
                    if number < 0 {
                        return Ok(NO_OBJECT);
                    }
                    if number != last.0 {
                        last = (number, place(self.objects.handle("object", i64::from(number))?)?);
                    }
                    Ok(last.1)
                };
                numbers.into_iter().map(of).collect()
            }
        }
    }

    fn pick(&mut self, x: u32, y: u32) -> Value {
        let Some(pick) = self.renderer.pick(x, y) else { return Value::Null };
        let name = self.renderer.objects().find(|(handle, _)| *handle == pick.object).map(|(_, object)| &object.name);
        json!({
            "object": self.objects.number(pick.object),
            "name": name,
            "light": pick.light.map(|light| self.lights.number(light)),
            "material": self.materials.number(pick.material),
            "position": pick.receiver.position,
            "normal": pick.receiver.normal,
            "view": pick.receiver.view,
            "distance": pick.distance,
        })
    }

    fn state(&mut self) -> Value {
        let (renderer, upkeep) = (&self.renderer, self.renderer.upkeep());
        json!({
            "lights": self.lights.of(renderer.lights().map(|(handle, _)| handle)),
            "objects": self.objects.of(renderer.objects().map(|(handle, _)| handle)),
            "materials": self.materials.of(renderer.materials().map(|(handle, _)| handle)),
            "size": [renderer.scene().width, renderer.scene().height],
            "camera": CameraGiven::from(renderer.scene().camera),
            "time": renderer.time(),
            "stale": renderer.stale().names().collect::<Vec<_>>(),
            "seconds": self.seconds,
            "upkeep": {
                "hierarchyBuilds": upkeep.hierarchy_builds,
                "hierarchyRefits": upkeep.hierarchy_refits,
                "silhouetteBuilds": upkeep.silhouette_builds,
                "silhouetteRefits": upkeep.silhouette_refits,
                "sphereSets": upkeep.sphere_sets,
                "sphereUpdates": upkeep.sphere_updates,
                "pointBands": upkeep.point_bands,
                "maps": upkeep.maps,
                "skyTables": upkeep.sky_tables,
            },
        })
    }

    fn object_state(&mut self, key: &Key) -> Result<Value, Fault> {
        let handle = self.object(key)?;
        let object = self.object_item(handle)?;
        let material = self.renderer.materials().nth(object.material).map(|(material, _)| material);
        Ok(json!({
            "number": self.objects.number(handle),
            "name": self.object_item(handle)?.name,
            "material": material.map(|material| self.materials.number(material)),
            "transform": self.renderer.transform(handle).unwrap_or_default().to_cols_array(),
        }))
    }

    fn light(&self, number: i64) -> Result<&Light, Fault> {
        let handle = self.lights.handle("light", number)?;
        let found = self.renderer.lights().find(|(known, _)| *known == handle);
        found.map(|(_, light)| light).ok_or_else(|| Fault::from(EditError::NoLight(handle)))
    }

    /// The object that a key means: a number, or a name that one object alone has.
    fn object(&self, key: &Key) -> Result<ObjectHandle, Fault> {
        let name = match key {
            Key::Number(number) => return self.objects.handle("object", *number),
            Key::Name(name) => name,
        };
        let mut found = self.renderer.objects().filter(|(_, object)| object.name == *name).map(|(handle, _)| handle);
        match (found.next(), found.next()) {
            (Some(handle), None) => Ok(handle),
            (None, _) => Err(Fault::edit(format!("no object is named \"{name}\""))),
            _ => Err(Fault::edit(format!("several objects are named \"{name}\": their numbers are in `objects`"))),
        }
    }

    fn object_item(&self, handle: ObjectHandle) -> Result<&Object, Fault> {
        let found = self.renderer.objects().find(|(known, _)| *known == handle);
        found.map(|(_, object)| object).ok_or_else(|| Fault::from(EditError::NoObject(handle)))
    }

    fn material_place(&self, number: i64) -> Result<usize, Fault> {
        let handle = self.materials.handle("material", number)?;
        let place = self.renderer.materials().position(|(known, _)| known == handle);
        place.ok_or_else(|| Fault::from(EditError::NoMaterial(handle)))
    }

    /// Adds an object with its material, which is taken back where the object is refused; its number.
    fn add(&mut self, object: Object, material: Option<MaterialKey>, arrays: Arrays<'_>) -> Result<usize, Fault> {
        let (place, new) = match material {
            Some(MaterialKey::Number(number)) => (self.material_place(number)?, None),
            own => {
                let own = own.and_then(|own| match own {
                    MaterialKey::Own(own) => Some(own),
                    MaterialKey::Number(_) => None,
                });
                let (material, surface) = usual(own, arrays)?;
                let handle = self.renderer.add_material(material, surface)?;
                (self.renderer.scene().materials.len() - 1, Some(handle))
            }
        };
        match (self.renderer.add_object(Object { material: place, ..object }), new) {
            (Ok(handle), new) => {
                if let Some(material) = new {
                    self.materials.number(material);
                }
                Ok(self.objects.number(handle))
            }
            (Err(error), new) => {
                new.map(|material| self.renderer.remove_material(material)).transpose()?;
                Err(error.into())
            }
        }
    }
}

/// A light with some of its numbers changed; its power stays with another size.
fn changed(light: &Light, changes: LightChanges) -> Light {
    let mut light = light.clone();
    if let Some((before, after)) = lamp::center(&light).zip(changes.center) {
        light = lamp::shifted(&light, after - before);
    }
    if let Some(direction) = changes.direction {
        light = lamp::aimed(&light, direction);
    }
    if let Some(size) = changes.size {
        light = lamp::resized(&light, size);
    }
    changes.radiance.map_or(light.clone(), |radiance| lamp::with_radiance(&light, radiance))
}

/// The layers of some names.
fn layer_set(names: &[String]) -> Result<LayerSet, Fault> {
    let mut set = LayerSet::NONE;
    for name in names {
        let layer = match name.as_str() {
            "unshadowed" => &mut set.unshadowed,
            "lights" => &mut set.lights,
            "normal" => &mut set.normals,
            "depth" => &mut set.depths,
            "object" => &mut set.objects,
            _ => {
                let known = "unshadowed, lights, normal, depth, object";
                return Err(Fault::range(format!("layer \"{name}\": expected some of {known}")));
            }
        };
        *layer = true;
    }
    Ok(set)
}

/// The layers of lights by their names.
fn numbered(lights: &[Vec<Vec3>]) -> impl Iterator<Item = (String, &Vec<Vec3>)> {
    lights.iter().enumerate().map(|(number, light)| (format!("light{number}"), light))
}

/// The layers of a picture by the names that its OpenEXR file has; `numbers` are those of the objects.
fn named_layers(image: &Image, set: LayerSet, numbers: &[usize]) -> Answer {
    let Layers { unshadowed, lights, normals, depths, objects, .. } = &image.layers;
    let number = |place: &u32| numbers.get(*place as usize).map_or(-1.0, |number| *number as f32);
    let objects: Vec<f32> = objects.iter().map(number).collect();
    let mut all: Vec<(String, &[u8])> = vec![("beauty".to_owned(), cast_slice(&image.radiance))];
    for (is_there, name, layer) in [
        (set.unshadowed, "unshadowed", cast_slice(unshadowed)),
        (set.normals, "normal", cast_slice(normals)),
        (set.depths, "depth", cast_slice(depths)),
        (set.objects, "object", cast_slice(&objects)),
    ] {
        all.extend(is_there.then(|| (name.to_owned(), layer)));
    }
    all.extend(numbered(lights).map(|(name, layer)| (name, cast_slice(layer))));
    Answer::named(all)
}

/// Seconds by the clock that the page lends.
struct Clock(f64);

impl Clock {
    fn start() -> Self {
        Self(crate::host::clock())
    }

    fn seconds(&self) -> f64 {
        crate::host::clock() - self.0
    }
}
