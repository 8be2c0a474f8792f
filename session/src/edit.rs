use brdf::Material;
use glam::Mat4;
use lighting::Light;
use renderer::{LightHandle, MaterialHandle, ObjectHandle, RenderError, Renderer, Settings, TakenLight, TakenObject};
use scene::{Camera, Object, Strategy, Surface};

/// One change of a scene, of the camera or of how it is drawn. Objects and lights that go and come back have the handles that they had.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Edit {
    /// Another light in the place of one.
    Light(LightHandle, Box<Light>),
    /// Where an object stands, from where it stood when it came.
    Transform(ObjectHandle, Mat4),
    /// Another material in the place of one, and what surfaces show beside it.
    Material(MaterialHandle, Material, Box<Surface>),
    /// The material of an object.
    MaterialOf(ObjectHandle, MaterialHandle),
    /// How an object blocks light.
    Strategy(ObjectHandle, Option<Strategy>),
    /// Whether the camera sees an object.
    Visible(ObjectHandle, bool),
    /// The camera.
    Camera(Camera),
    /// Width and height of the picture.
    Size(u32, u32),
    /// Accuracy, strategy, method, device and all else but the [layers](crate::Session::set_layers).
    Settings(Box<Settings>),
    /// The moment of the animation, in seconds.
    Seek(f32),
    /// A new light, behind the others.
    AddLight(Box<Light>),
    /// A light goes.
    TakeLight(LightHandle),
    /// A light comes back at its place.
    PutLight(Box<TakenLight>),
    /// A new object, behind the others.
    AddObject(Box<Object>),
    /// An object goes, and with it the lights that its material's emission stands for.
    TakeObject(ObjectHandle),
    /// An object goes, and with it these lights: what takes the coming of an object back.
    TakeObjectAnd(ObjectHandle, Vec<LightHandle>),
    /// An object comes back at its place, with its lights.
    PutObject(Box<TakenObject>),
    /// Several, one after the other, as one step: all of them or none.
    All(Vec<Edit>),
}

impl Edit {
    /// Makes the change; returns the one that takes it back.
    ///
    /// # Errors
    /// Those of the renderer's own edits; nothing has changed then.
    pub fn apply(self, renderer: &mut Renderer) -> Result<Self, RenderError> {
        match self {
            Self::Light(handle, light) => Self::set_light(renderer, handle, light),
            Self::Transform(handle, matrix) => {
                let before = renderer.transform(handle).unwrap_or(Mat4::IDENTITY);
                renderer.set_transform(handle, matrix)?;
                Ok(Self::Transform(handle, before))
            }
            Self::Material(handle, material, surface) => Self::set_material(renderer, handle, material, surface),
            Self::MaterialOf(handle, material) => Self::set_material_of(renderer, handle, material),
            Self::Strategy(handle, strategy) => {
                let before = object(renderer, handle).and_then(|object| object.strategy);
                renderer.set_object_strategy(handle, strategy)?;
                Ok(Self::Strategy(handle, before))
            }
            Self::Visible(handle, visible) => {
                let before = object(renderer, handle).map(|object| object.visible);
                renderer.set_visible(handle, visible)?;
                Ok(Self::Visible(handle, before.unwrap_or(visible)))
            }
            Self::Camera(camera) => {
                let before = renderer.scene().camera;
                renderer.set_camera(camera)?;
                Ok(Self::Camera(before))
            }
            Self::Size(width, height) => {
                let before = Self::Size(renderer.scene().width, renderer.scene().height);
                renderer.set_size(width, height)?;
                Ok(before)
            }
            Self::Settings(settings) => {
                let before = renderer.settings().clone();
                renderer.set_settings(Settings { layers: before.layers, ..*settings })?;
                Ok(Self::Settings(Box::new(before)))
            }
            Self::Seek(time) => {
                let before = renderer.time();
                renderer.seek(time);
                Ok(Self::Seek(before))
            }
            Self::AddLight(light) => Ok(Self::TakeLight(renderer.add_light(*light)?)),
            Self::TakeLight(handle) => Ok(Self::PutLight(Box::new(renderer.take_light(handle)?))),
            Self::PutLight(taken) => {
                renderer.put_light(&taken)?;
                Ok(Self::TakeLight(taken.handle()))
            }
            Self::AddObject(object) => Ok(Self::TakeObjectAnd(renderer.add_object(*object)?, Vec::new())),
            Self::TakeObject(handle) => Ok(Self::PutObject(Box::new(renderer.take_object(handle)?))),
            Self::TakeObjectAnd(handle, lights) => {
                Ok(Self::PutObject(Box::new(renderer.take_object_and(handle, &lights)?)))
            }
            Self::PutObject(taken) => {
                renderer.put_object(&taken)?;
                Ok(Self::TakeObjectAnd(taken.handle(), taken.lights().collect()))
            }
            Self::All(edits) => Self::apply_all(renderer, edits),
        }
    }

    fn set_light(renderer: &mut Renderer, handle: LightHandle, light: Box<Light>) -> Result<Self, RenderError> {
        let before = renderer.lights().find(|(known, _)| *known == handle).map(|(_, light)| light.clone());
        renderer.set_light(handle, (*light).clone())?;
        Ok(Self::Light(handle, before.map_or(light, Box::new)))
    }

    fn set_material_of(
        renderer: &mut Renderer,
        handle: ObjectHandle,
        material: MaterialHandle,
    ) -> Result<Self, RenderError> {
        let number = object(renderer, handle).map(|object| object.material);
        let before = number.and_then(|number| renderer.materials().nth(number)).map(|(handle, _)| handle);
        renderer.set_object_material(handle, material)?;
        Ok(Self::MaterialOf(handle, before.unwrap_or(material)))
    }

    fn set_material(
        renderer: &mut Renderer,
        handle: MaterialHandle,
        material: Material,
        surface: Box<Surface>,
    ) -> Result<Self, RenderError> {
        let scene = renderer.scene();
        let place = renderer.materials().position(|(known, _)| known == handle);
        let before = place.map(|place| {
            let surface = scene.surfaces.get(place).cloned().unwrap_or_default();
            (scene.materials[place].clone(), Box::new(surface))
        });
        renderer.set_material(handle, material.clone(), (*surface).clone())?;
        let (material, surface) = before.unwrap_or((material, surface));
        Ok(Self::Material(handle, material, surface))
    }

    /// Makes changes one after the other; takes those before back where one fails.
    fn apply_all(renderer: &mut Renderer, edits: Vec<Self>) -> Result<Self, RenderError> {
        let mut inverses = Vec::with_capacity(edits.len());
        for edit in edits {
            match edit.apply(renderer) {
                Ok(inverse) => inverses.push(inverse),
                Err(error) => {
                    inverses.into_iter().rev().try_for_each(|inverse| inverse.apply(renderer).map(drop))?;
                    return Err(error);
                }
            }
        }
        inverses.reverse();
        Ok(Self::All(inverses))
    }

    /// Whether the other one changes the same thing, so that both together are one step.
    pub(crate) fn is_of(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Light(a, _), Self::Light(b, _)) => a == b,
            (Self::Transform(a, _), Self::Transform(b, _)) => a == b,
            (Self::Material(a, ..), Self::Material(b, ..)) => a == b,
            (Self::Camera(_), Self::Camera(_))
            | (Self::Size(..), Self::Size(..))
            | (Self::Settings(_), Self::Settings(_))
            | (Self::Seek(_), Self::Seek(_)) => true,
            _ => false,
        }
    }
}

fn object(renderer: &Renderer, handle: ObjectHandle) -> Option<&Object> {
    renderer.objects().find(|(known, _)| *known == handle).map(|(_, object)| object)
}
