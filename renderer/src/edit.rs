//! Edits of the scene and the settings: each is validated first, and returns what it makes stale.

#[cfg(feature = "gpu")]
use crate::Device;
use crate::renderer::check_method;
use crate::{
    Backend, CustomStrategy, EditError, LayerSet, LightHandle, MaterialHandle, ObjectHandle, RenderError, Renderer,
    Settings, Stale,
};
use brdf::Material;
use glam::{Mat4, Vec3, Vec4};
use lighting::{Environment, Light};
use lobe_core::scales_evenly;
use scene::{Camera, KeyFrames, Object, Proxy, Scene, Shape, Strategy, Surface};
use shading::Accuracy;
use std::sync::Arc;

impl Renderer {
    /// The objects and their handles.
    pub fn objects(&self) -> impl Iterator<Item = (ObjectHandle, &Object)> {
        self.rows.revisions().iter().map(|row| ObjectHandle(row.object)).zip(&self.scene.objects)
    }

    /// The lights and their handles.
    pub fn lights(&self) -> impl Iterator<Item = (LightHandle, &Light)> {
        self.light_handles.iter().map(LightHandle).zip(&self.scene.lights)
    }

    /// The materials and their handles.
    pub fn materials(&self) -> impl Iterator<Item = (MaterialHandle, &Material)> {
        self.material_handles.iter().map(MaterialHandle).zip(&self.scene.materials)
    }

    fn object_place(&self, object: ObjectHandle) -> Result<usize, EditError> {
        self.rows.place(object.0).ok_or(EditError::NoObject(object))
    }

    pub(crate) fn light_place(&self, light: LightHandle) -> Result<usize, EditError> {
        self.light_handles.place(light.0).ok_or(EditError::NoLight(light))
    }

    pub(crate) fn material_place(&self, material: MaterialHandle) -> Result<usize, EditError> {
        self.material_handles.place(material.0).ok_or(EditError::NoMaterial(material))
    }

    /// The place of an object, if the animation does not move it.
    pub(crate) fn still_object(&self, object: ObjectHandle) -> Result<usize, EditError> {
        let place = self.object_place(object)?;
        if self.animation.moves_object(place) {
            return Err(EditError::Animated(format!("object \"{}\"", self.scene.objects[place].name)));
        }
        Ok(place)
    }

    /// Adds an object that does not move.
    ///
    /// # Errors
    /// [`RenderError::Scene`] if the object is not valid.
    pub fn add_object(&mut self, object: Object) -> Result<ObjectHandle, RenderError> {
        self.scene.check_object(&object)?;
        self.scene.objects.push(object);
        self.mark(Stale::STRATEGY);
        Ok(ObjectHandle(self.rows.push()))
    }

    /// Removes an object. Lights whose surface it is stay.
    ///
    /// # Errors
    /// [`RenderError::Edit`] if the object is not in the scene.
    pub fn remove_object(&mut self, object: ObjectHandle) -> Result<Object, RenderError> {
        let place = self.object_place(object)?;
        self.rows.remove(place);
        self.animation.remove_object(place);
        self.mark(Stale::STRATEGY | Stale::LIGHTS);
        Ok(self.scene.remove_object(place))
    }

    /// Adds a strategy for the objects that [name](scene::Strategy::Custom) it; replaces one of the same name.
    pub fn put_strategy(&mut self, strategy: Box<dyn CustomStrategy>) -> Stale {
        self.custom.put(strategy);
        self.mark(Stale::STRATEGY)
    }

    /// The matrix that [`set_transform`](Self::set_transform) has set for an object; `None` if the object is not in the scene.
    #[must_use]
    pub fn transform(&self, object: ObjectHandle) -> Option<Mat4> {
        self.object_place(object).ok().map(|place| self.rows.transform(place))
    }

    /// Moves an object: the matrix maps it from the place at which it was added, or got its shape. Spheres, and meshes with a
    /// sphere set as proxy, keep their proportions: the matrix must be a rotation, one scale and a translation. A sphere set is not
    /// fitted again.
    ///
    /// # Errors
    /// [`RenderError::Edit`] if the animation moves the object, or for another matrix; [`RenderError::Scene`] if it ends out of
    /// bounds.
    pub fn set_transform(&mut self, object: ObjectHandle, matrix: Mat4) -> Result<Stale, RenderError> {
        let place = self.still_object(object)?;
        let moved = &mut self.scene.objects[place];
        if let Some(fault) = fault_of(moved, &matrix) {
            return Err(EditError::Transform { object: moved.name.clone(), fault }.into());
        }
        let before = self.rows.transform(place);
        self.rows.put(place, moved, matrix);
        if let Err(error) = self.scene.check_object(&self.scene.objects[place]) {
            self.rows.put(place, &mut self.scene.objects[place], before);
            return Err(error.into());
        }
        Ok(self.mark(Stale::MOVED))
    }

    /// Replaces an object's shape and proxy, both given in world space.
    ///
    /// # Errors
    /// As [`add_object`](Self::add_object); [`RenderError::Edit`] if the animation moves the object.
    pub fn set_shape(&mut self, object: ObjectHandle, shape: Shape, proxy: Proxy) -> Result<Stale, RenderError> {
        let place = self.still_object(object)?;
        let old = &self.scene.objects[place];
        let new = Object { name: old.name.clone(), shape, proxy, ..*old };
        self.scene.check_object(&new)?;
        self.scene.objects[place] = new;
        self.rows.renew(place);
        Ok(self.mark(Stale::STRATEGY | Stale::SURFACES))
    }

    /// Gives an object another material.
    ///
    /// # Errors
    /// [`RenderError::Edit`] if the object or the material is not in the scene; [`RenderError::Scene`] for vertex colours under a model
    /// that takes none.
    pub fn set_object_material(
        &mut self,
        object: ObjectHandle,
        material: MaterialHandle,
    ) -> Result<Stale, RenderError> {
        let (place, material) = (self.object_place(object)?, self.material_place(material)?);
        Scene::check_colors(&self.scene.objects[place], &self.scene.materials[material])?;
        self.scene.objects[place].material = material;
        Ok(self.mark(Stale::SHADING | Stale::POINTS | Stale::SURFACES))
    }

    /// Sets an object's strategy; `None` chooses one by the kind of object.
    ///
    /// # Errors
    /// [`RenderError::Edit`] if the object is not in the scene.
    pub fn set_object_strategy(
        &mut self,
        object: ObjectHandle,
        strategy: Option<Strategy>,
    ) -> Result<Stale, RenderError> {
        let place = self.object_place(object)?;
        self.scene.objects[place].strategy = strategy;
        Ok(self.mark(Stale::STRATEGY))
    }

    /// Shows an object to the camera, or hides it.
    ///
    /// # Errors
    /// [`RenderError::Edit`] if the object is not in the scene; [`RenderError::Scene`] for a sphere that is too near to the camera.
    pub fn set_visible(&mut self, object: ObjectHandle, visible: bool) -> Result<Stale, RenderError> {
        let place = self.object_place(object)?;
        let before = core::mem::replace(&mut self.scene.objects[place].visible, visible);
        if let Err(error) = self.scene.check_object(&self.scene.objects[place]) {
            self.scene.objects[place].visible = before;
            return Err(error.into());
        }
        Ok(self.mark(Stale::STRATEGY))
    }

    /// Moves an object by key frames, relative to its place at the animation's first moment.
    ///
    /// # Errors
    /// As [`Animation::set_keys`](scene::Animation::set_keys).
    pub fn set_keys(&mut self, object: ObjectHandle, keys: &KeyFrames) -> Result<Stale, RenderError> {
        let place = self.object_place(object)?;
        let time = self.time;
        self.seek(0.0);
        let set = self.animation.set_keys(place, keys, &mut self.scene);
        if set.is_ok() {
            self.rows.renew(place);
        }
        self.seek(time);
        set?;
        Ok(self.mark(Stale::STRATEGY))
    }

    /// Adds a light.
    ///
    /// # Errors
    /// [`RenderError::Scene`] if a number is not valid, [`RenderError::PaperLight`] if the method does not support this kind of
    /// light.
    pub fn add_light(&mut self, light: Light) -> Result<LightHandle, RenderError> {
        self.check_light(self.scene.lights.len(), &light)?;
        self.scene.lights.push(light);
        self.mark(LIT);
        Ok(LightHandle(self.light_handles.push()))
    }

    /// Removes a light.
    ///
    /// # Errors
    /// [`RenderError::Edit`] if the light is not in the scene.
    pub fn remove_light(&mut self, light: LightHandle) -> Result<Light, RenderError> {
        let place = self.light_place(light)?;
        self.light_handles.remove(place);
        self.animation.remove_light(place);
        self.mark(LIT);
        Ok(self.scene.lights.remove(place))
    }

    /// Replaces a light.
    ///
    /// # Errors
    /// As [`add_light`](Self::add_light); [`RenderError::Edit`] if the light is not in the scene, or the animation moves it.
    pub fn set_light(&mut self, handle: LightHandle, light: Light) -> Result<Stale, RenderError> {
        let place = self.light_place(handle)?;
        if self.animation.moves_light(place) {
            return Err(EditError::Animated(format!("light {place}")).into());
        }
        self.check_light(place, &light)?;
        self.scene.lights[place] = light;
        Ok(self.mark(LIT))
    }

    /// Replaces or removes the environment. The lights of the new one are appended to the others, with new handles; those of the
    /// old one are removed.
    ///
    /// # Errors
    /// [`RenderError::PaperLight`] if the method does not support this kind of light.
    pub fn set_environment(&mut self, environment: Option<Arc<Environment>>) -> Result<Stale, RenderError> {
        let new = environment.as_ref().map_or(&[][..], |environment| environment.lights());
        let is_sky = |light: &Light| matches!(light, Light::Sky(_));
        let first = self.scene.lights.iter().filter(|light| !is_sky(light)).count();
        new.iter().zip(first..).try_for_each(|(light, number)| self.check_light(number, light))?;
        for place in
            (0..self.scene.lights.len()).rev().filter(|place| is_sky(&self.scene.lights[*place])).collect::<Vec<_>>()
        {
            self.light_handles.remove(place);
            self.animation.remove_light(place);
            self.scene.lights.remove(place);
        }
        for light in new {
            self.scene.lights.push(light.clone());
            self.light_handles.push();
        }
        self.scene.environment = environment;
        Ok(self.mark(LIT | Stale::POINTS))
    }

    pub(crate) fn check_light(&self, number: usize, light: &Light) -> Result<(), RenderError> {
        Scene::check_light(number, light)?;
        check_method(self.settings.method, core::slice::from_ref(light)).map_err(|error| match error {
            RenderError::PaperLight(_, kind) => RenderError::PaperLight(number, kind),
            error => error,
        })
    }

    /// Adds a material with its surface properties.
    ///
    /// # Errors
    /// [`RenderError::Scene`].
    pub fn add_material(&mut self, material: Material, surface: Surface) -> Result<MaterialHandle, RenderError> {
        let before = self.scene.materials.len();
        Scene::check_material(before, &material, &surface)?;
        self.scene.materials.push(material);
        self.put_surface(before, surface);
        self.set_materials_of_points(before);
        Ok(MaterialHandle(self.material_handles.push()))
    }

    /// Replaces a material and its surface properties. Visible points stay valid, unless surfaces have textures.
    ///
    /// # Errors
    /// [`RenderError::Scene`]; [`RenderError::Edit`] if the material is not in the scene.
    pub fn set_material(
        &mut self,
        handle: MaterialHandle,
        material: Material,
        surface: Surface,
    ) -> Result<Stale, RenderError> {
        let place = self.material_place(handle)?;
        Scene::check_material(place, &material, &surface)?;
        let mut users = self.scene.objects.iter().filter(|object| object.material == place);
        users.clone().try_for_each(|object| Scene::check_colors(object, &material))?;
        let varies = self.scene.surface(place).is_some() || !surface.is_plain() || users.any(Object::has_vertex_colors);
        self.scene.materials[place] = material;
        self.put_surface(place, surface);
        self.set_materials_of_points(self.scene.materials.len());
        let points = if varies { Stale::POINTS | Stale::SURFACES } else { Stale::NOTHING };
        Ok(self.mark(Stale::SHADING | points))
    }

    /// Removes a material that no object uses.
    ///
    /// # Errors
    /// [`RenderError::Edit`] if an object uses the material, or it is not in the scene.
    pub fn remove_material(&mut self, material: MaterialHandle) -> Result<Material, RenderError> {
        let place = self.material_place(material)?;
        if let Some(object) = self.scene.objects.iter().find(|o| o.material == place) {
            return Err(EditError::MaterialInUse(object.name.clone()).into());
        }
        self.scene.objects.iter_mut().filter(|o| o.material > place).for_each(|o| o.material -= 1);
        if place < self.scene.surfaces.len() {
            self.scene.surfaces.remove(place);
        }
        self.material_handles.remove(place);
        self.mark(Stale::SHADING | Stale::POINTS);
        Ok(self.scene.materials.remove(place))
    }

    /// Updates the materials of kept points to the scene's; `before` is the earlier number of materials.
    fn set_materials_of_points(&mut self, before: usize) {
        for kept in [&mut self.kept, &mut self.reduced] {
            kept.points.set_materials(&self.scene.materials, before);
        }
    }

    fn put_surface(&mut self, place: usize, surface: Surface) {
        if place >= self.scene.surfaces.len() {
            if surface.is_plain() {
                return;
            }
            self.scene.surfaces.resize(place + 1, Surface::default());
        }
        self.scene.surfaces[place] = surface;
    }

    /// Replaces the camera.
    ///
    /// # Errors
    /// [`RenderError::Scene`] for a camera that sees nothing; [`RenderError::Edit`] if the animation moves it.
    pub fn set_camera(&mut self, camera: Camera) -> Result<Stale, RenderError> {
        if self.animation.moves_camera() {
            return Err(EditError::Animated("the camera".to_owned()).into());
        }
        self.scene.check_camera(&camera)?;
        self.scene.camera = camera;
        Ok(self.mark(Stale::SHADING | Stale::POINTS))
    }

    /// Leaves the camera where it is, and the animation moves it no more: [`set_camera`](Self::set_camera) does.
    pub fn release_camera(&mut self) {
        self.animation.release_camera();
    }

    /// Sets the size of the picture.
    ///
    /// # Errors
    /// [`RenderError::Scene`] for a picture without pixels, or with too many.
    pub fn set_size(&mut self, width: u32, height: u32) -> Result<Stale, RenderError> {
        Scene::check_size(width, height)?;
        (self.scene.width, self.scene.height) = (width, height);
        Ok(self.mark(Stale::SHADING | Stale::POINTS))
    }

    /// Sets the background.
    ///
    /// # Errors
    /// [`RenderError::Scene`] if it is not a radiance.
    pub fn set_background(&mut self, background: Vec3) -> Result<Stale, RenderError> {
        Scene::check_background(background)?;
        self.scene.background = background;
        Ok(self.mark(Stale::SHADING))
    }

    /// Sets the accuracy from the next picture on, and removes a time budget.
    ///
    /// # Errors
    /// [`RenderError::Setting`].
    pub fn set_accuracy(&mut self, accuracy: Accuracy) -> Result<Stale, RenderError> {
        self.set_settings(Settings { accuracy, time_budget: None, ..self.settings.clone() })
    }

    /// Sets the layers of the next pictures; everything that is kept stays.
    ///
    /// # Errors
    /// [`RenderError::NotOnGpu`] for [layers](LayerSet::is_of_cpu) that the device does not make.
    pub fn set_layers(&mut self, layers: LayerSet) -> Result<(), RenderError> {
        let settings = Settings { layers, ..self.settings.clone() };
        settings.check_device(settings.device)?;
        self.settings = settings;
        Ok(())
    }

    /// Replaces all settings: strategy, method, device and the others.
    ///
    /// # Errors
    /// Those of [`new`](Self::new); the settings then stay the same.
    pub fn set_settings(&mut self, settings: Settings) -> Result<Stale, RenderError> {
        settings.check_device(settings.device)?;
        settings.validate()?;
        check_method(settings.method, &self.scene.lights)?;
        let mut stale = Stale::SHADING | Stale::BUDGET;
        if settings.device != self.backend.device() {
            #[cfg(feature = "gpu")]
            let backend = match (&self.gpu, settings.device) {
                (Some(gpu), Device::Gpu) => Backend::on(gpu)?,
                (_, device) => Backend::open(device)?,
            };
            #[cfg(not(feature = "gpu"))]
            let backend = Backend::open(settings.device)?;
            self.upkeep.ray_worlds += self.backend.worlds_followed();
            self.backend = backend;
            stale |= Stale::BACKEND;
        }
        if settings.strategy != self.settings.strategy {
            stale |= Stale::STRATEGY;
        }
        if settings.samples != self.settings.samples {
            stale |= Stale::POINTS;
        }
        if settings.method != self.settings.method {
            stale |= Stale::TABLES;
        }
        self.settings = settings;
        self.chosen = None;
        Ok(self.mark(stale))
    }
}

/// The consequences of a change of a light.
pub(crate) const LIT: Stale = Stale::SHADING.with(Stale::LIGHTS).with(Stale::MAPS);

/// The reason why an object cannot follow a matrix.
fn fault_of(object: &Object, matrix: &Mat4) -> Option<&'static str> {
    if !matrix.is_finite() {
        return Some("is not finite");
    }
    if matrix.row(3) != Vec4::W {
        return Some("is not affine: its last row is not (0, 0, 0, 1)");
    }
    let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.truncate());
    let volume = axes[0].cross(axes[1]).dot(axes[2]);
    if volume == 0.0 {
        return Some("flattens it");
    }
    if matches!(&object.shape, Shape::Instances(all) if all.moved(matrix).is_err()) {
        return Some("flattens it, or moves it too far");
    }
    if object.shape.has_triangles() && object.proxy == Proxy::None {
        return None;
    }
    let is_even = scales_evenly(matrix, axes[0].as_dvec3().length(), 1e-4);
    (!is_even || volume < 0.0).then_some("has unequal scales or mirrors, which its spheres cannot follow")
}
