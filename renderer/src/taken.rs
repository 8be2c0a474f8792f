//! Objects and lights that are taken out of a scene, and put back as they were.

use crate::edit::LIT;
use crate::rows::Row;
use crate::{EditError, LightHandle, MaterialHandle, ObjectHandle, RenderError, Renderer, Stale};
use lighting::Light;
use lobe_core::NO_OBJECT;
use scene::{Object, Surface};
use shading::LightLobes;

/// A light that was [taken out](Renderer::take_light): [`Renderer::put_light`] puts it back with the same handle.
#[derive(Clone, Debug)]
pub struct TakenLight {
    handle: LightHandle,
    light: Light,
    /// The object that it is inside of.
    inside: Option<ObjectHandle>,
}

/// An object that was [taken out](Renderer::take_object): [`Renderer::put_object`] puts it back with the same handle.
#[derive(Clone, Debug)]
pub struct TakenObject {
    handle: ObjectHandle,
    object: Object,
    material: MaterialHandle,
    row: Row,
    lights: Vec<TakenLight>,
}

impl TakenLight {
    /// Its handle.
    #[must_use]
    pub const fn handle(&self) -> LightHandle {
        self.handle
    }
}

impl TakenObject {
    /// Its handle.
    #[must_use]
    pub const fn handle(&self) -> ObjectHandle {
        self.handle
    }

    /// Those of the lights that went with it.
    pub fn lights(&self) -> impl Iterator<Item = LightHandle> + '_ {
        self.lights.iter().map(TakenLight::handle)
    }
}

/// A point is on a light if it is within this fraction of the light's radius.
const ON_LIGHT: f32 = 1e-3;

impl Renderer {
    /// Takes a light out, so that it can come back as it was.
    ///
    /// ```
    /// use renderer::{Renderer, Settings};
    /// let mut renderer = Renderer::new(scene::builtin(), scene::Animation::default(), Settings::default())?;
    /// let (first, _) = renderer.lights().next().expect("a light");
    /// let taken = renderer.take_light(first)?;
    /// assert!(renderer.lights().all(|(handle, _)| handle != first));
    /// renderer.put_light(&taken)?;
    /// assert_eq!(renderer.lights().next().map(|(handle, _)| handle), Some(first));
    /// # Ok::<(), renderer::RenderError>(())
    /// ```
    ///
    /// # Errors
    /// [`RenderError::Edit`] if the light is not in the scene, if the animation moves it, or if it is a patch of the environment.
    pub fn take_light(&mut self, light: LightHandle) -> Result<TakenLight, RenderError> {
        let place = self.light_place(light)?;
        self.check_taking(place)?;
        let (light, inside) = (self.scene.lights[place].clone(), self.object_around(place));
        let handle = LightHandle(self.light_handles.at(place));
        self.remove_light(handle)?;
        Ok(TakenLight { handle, light, inside })
    }

    /// Puts a light back at its place among the others, with its handle.
    ///
    /// # Errors
    /// [`RenderError::Edit`] if it is in the scene; those of [`add_light`](Self::add_light).
    pub fn put_light(&mut self, taken: &TakenLight) -> Result<Stale, RenderError> {
        let mut light = taken.light.clone();
        if let Light::Enclosed(inside) = &mut light {
            let around = taken.inside.and_then(|object| self.rows.place(object.0));
            inside.object = around.map_or(NO_OBJECT, |place| place as u32);
        }
        let place = self.gap_of(taken)?;
        self.light_handles.put(place, taken.handle.0);
        self.animation.insert_light(place);
        self.scene.lights.insert(place, light);
        Ok(self.mark(LIT))
    }

    /// Takes an object out, so that it can come back as it was, and with it the lights that its material's emission stands for.
    ///
    /// # Errors
    /// [`RenderError::Edit`] if the object is not in the scene, or if the animation moves it or one of these lights.
    ///
    /// # Cost
    /// For an object that emits the distances of its triangles from all flat lights.
    pub fn take_object(&mut self, object: ObjectHandle) -> Result<TakenObject, RenderError> {
        let place = self.still_object(object)?;
        let shining = (0..self.scene.lights.len()).filter(|light| self.stands_for(*light, place));
        let lights: Vec<LightHandle> = shining.map(|light| LightHandle(self.light_handles.at(light))).collect();
        self.take_object_and(object, &lights)
    }

    /// Takes an object out, and with it these lights, whichever stand for it: what takes an addition back.
    ///
    /// # Errors
    /// As [`take_object`](Self::take_object); [`RenderError::Edit`] for a light that is not in the scene.
    pub fn take_object_and(
        &mut self,
        object: ObjectHandle,
        lights: &[LightHandle],
    ) -> Result<TakenObject, RenderError> {
        let place = self.still_object(object)?;
        lights.iter().try_for_each(|light| self.check_taking(self.light_place(*light)?))?;
        let lights = lights.iter().map(|light| self.take_light(*light)).collect::<Result<_, _>>()?;
        let row = self.rows.remove(place);
        self.animation.remove_object(place);
        self.mark(Stale::STRATEGY | Stale::LIGHTS);
        let taken = self.scene.remove_object(place);
        let material = MaterialHandle(self.material_handles.at(taken.material));
        Ok(TakenObject { handle: object, object: taken, material, row, lights })
    }

    /// Puts an object back at its place among the others, with its handle, the place from which it was moved, and its lights.
    ///
    /// # Errors
    /// [`RenderError::Edit`] if it is in the scene, or its material is no longer; those of [`add_object`](Self::add_object) and
    /// [`put_light`](Self::put_light).
    pub fn put_object(&mut self, taken: &TakenObject) -> Result<Stale, RenderError> {
        let object = Object { material: self.material_place(taken.material)?, ..taken.object.clone() };
        self.scene.check_object(&object)?;
        taken.lights.iter().try_for_each(|light| self.gap_of(light).map(drop))?;
        let fault = || EditError::Present(format!("object \"{}\"", object.name));
        let place = self.rows.insert(taken.row.clone()).ok_or_else(fault)?;
        self.animation.insert_object(place);
        self.scene.insert_object(place, object);
        let mut stale = self.mark(Stale::STRATEGY | Stale::LIGHTS);
        for light in &taken.lights {
            stale |= self.put_light(light)?;
        }
        Ok(stale)
    }

    /// The place to which a light may come back.
    fn gap_of(&self, taken: &TakenLight) -> Result<usize, RenderError> {
        self.check_light(self.scene.lights.len(), &taken.light)?;
        let number = taken.handle.0;
        self.light_handles.gap(number).ok_or_else(|| EditError::Present(format!("light {number}")).into())
    }

    /// Checks that a light may go by itself.
    fn check_taking(&self, place: usize) -> Result<(), EditError> {
        match &self.scene.lights[place] {
            _ if self.animation.moves_light(place) => Err(EditError::Animated(format!("light {place}"))),
            Light::Sky(_) => Err(EditError::Patch(place)),
            _ => Ok(()),
        }
    }

    fn object_around(&self, light: usize) -> Option<ObjectHandle> {
        let Light::Enclosed(inside) = &self.scene.lights[light] else { return None };
        self.rows.revisions().get(inside.object as usize).map(|row| ObjectHandle(row.object))
    }

    /// Whether an object's emission is the reason for a light.
    fn stands_for(&self, light: usize, object: usize) -> bool {
        let light = &self.scene.lights[light];
        let own = &self.scene.objects[object];
        match light {
            Light::Enclosed(inside) => inside.object as usize == object,
            Light::Flat(_) if self.scene.surface(own.material).is_some_and(Surface::emits) => {
                let near = ON_LIGHT * light.bounds().radius;
                let is_on = |point| light.distance_to(point).is_some_and(|distance| distance <= near);
                let mut corners = (0..own.shape.triangle_count()).filter_map(|triangle| own.shape.corners(triangle));
                corners.any(|[a, b, c]| is_on((a + b + c) / 3.0))
            }
            _ => false,
        }
    }
}
