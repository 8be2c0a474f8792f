use crate::{Edit, LightItem, ObjectItem, Picture, Session, Snapshot};
use brdf::Material;
use glam::Mat4;
use lighting::Light;
use renderer::{LightHandle, MaterialHandle, ObjectHandle, RenderError, Settings};
use scene::{Camera, Object, Strategy};
use std::sync::Arc;

/// A session beside the scene with all changes so far, also those that no picture shows yet.
///
/// Changes are made to [`scene`](Self::scene) at once, so that handles and sliders follow the pointer and not the pictures; where the
/// session refuses one, the scene is right again with the [next picture](Self::follow).
#[derive(Debug)]
pub struct Editor {
    session: Session,
    picture: Arc<Picture>,
    scene: Snapshot,
}

impl Editor {
    /// An editor of a session, which is changed through it alone.
    #[must_use]
    pub fn new(session: Session) -> Self {
        let picture = session.picture();
        let scene = (*picture.scene).clone();
        Self { session, picture, scene }
    }

    /// The session.
    #[must_use]
    pub const fn session(&self) -> &Session {
        &self.session
    }

    /// The scene with all changes so far.
    #[must_use]
    pub const fn scene(&self) -> &Snapshot {
        &self.scene
    }

    /// The picture that was the newest at the last call of [`follow`](Self::follow).
    #[must_use]
    pub const fn picture(&self) -> &Arc<Picture> {
        &self.picture
    }

    /// Takes the newest picture, and the scene as it shows it where no change is under way. Whether there was a new one.
    pub fn follow(&mut self) -> bool {
        let picture = self.session.picture();
        if Arc::ptr_eq(&picture, &self.picture) {
            return false;
        }
        if picture.edits >= self.session.edits() {
            self.scene = (*picture.scene).clone();
        }
        self.picture = picture;
        true
    }

    /// Whether changes are under way that no picture shows.
    #[must_use]
    pub fn is_waiting(&self) -> bool {
        self.picture.edits < self.session.edits()
    }

    /// Whether the picture is the whole one with all changes.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        self.picture.is_whole() && !self.is_waiting()
    }

    /// Another light in the place of one.
    pub fn set_light(&mut self, handle: LightHandle, light: Light) {
        if let Some(item) = self.scene.lights.iter_mut().find(|item| item.handle == handle) {
            item.light = light.clone();
            self.session.edit(Edit::Light(handle, Box::new(light)));
        }
    }

    /// Puts an object where the matrix takes it from where it stood when it came.
    pub fn set_transform(&mut self, handle: ObjectHandle, transform: Mat4) {
        if let Some(item) = self.object_mut(handle) {
            // A box around the box: until the next picture.
            let step = transform * item.transform.inverse();
            item.bounds = moved(item.bounds, step);
            item.transform = transform;
            self.session.edit(Edit::Transform(handle, transform));
        }
    }

    /// Another material in the place of one; its textures and emission stay.
    pub fn set_material(&mut self, handle: MaterialHandle, material: Material) {
        if let Some(item) = self.scene.materials.iter_mut().find(|item| item.handle == handle) {
            item.material = material.clone();
            self.session.edit(Edit::Material(handle, material, Box::new(item.surface.clone())));
        }
    }

    /// How an object blocks light.
    pub fn set_strategy(&mut self, handle: ObjectHandle, strategy: Option<Strategy>) {
        if let Some(item) = self.object_mut(handle) {
            item.strategy = strategy;
            self.session.edit(Edit::Strategy(handle, strategy));
        }
    }

    /// Another camera.
    pub fn set_camera(&mut self, camera: Camera) {
        self.scene.camera = camera;
        self.session.edit(Edit::Camera(camera));
    }

    /// Leaves the camera where it is, and the animation moves it no more. Steps so far are forgotten.
    pub fn release_camera(&mut self) {
        self.scene.is_camera_animated = false;
        drop(self.session.change(renderer::Renderer::release_camera));
    }

    /// Shows an object, or hides it so that it is neither seen nor blocks light; both in one step.
    pub fn show(&mut self, handle: ObjectHandle, visible: bool, strategy: Option<Strategy>) {
        if let Some(item) = self.object_mut(handle) {
            (item.visible, item.strategy) = (visible, strategy);
            self.session.edit(Edit::All(vec![Edit::Visible(handle, visible), Edit::Strategy(handle, strategy)]));
        }
    }

    /// A new light, which is there with the next picture; a step of its own.
    pub fn add_light(&mut self, light: Light) {
        self.step(Edit::AddLight(Box::new(light)));
    }

    /// A light goes; a step of its own.
    pub fn remove_light(&mut self, handle: LightHandle) {
        self.scene.lights.retain(|item| item.handle != handle);
        self.step(Edit::TakeLight(handle));
    }

    /// A new object, which is there with the next picture; a step of its own.
    pub fn add_object(&mut self, object: Object) {
        self.step(Edit::AddObject(Box::new(object)));
    }

    /// An object goes, with the lights that its material's emission stands for; a step of its own.
    pub fn remove_object(&mut self, handle: ObjectHandle) {
        self.scene.objects.retain(|item| item.handle != handle);
        self.step(Edit::TakeObject(handle));
    }

    fn step(&self, edit: Edit) {
        self.session.close_step();
        self.session.edit(edit);
        self.session.close_step();
    }

    /// Another size of the picture.
    pub fn set_size(&mut self, size: [u32; 2]) {
        if size != self.scene.size {
            self.scene.size = size;
            self.session.edit(Edit::Size(size[0], size[1]));
        }
    }

    /// Other settings.
    pub fn set_settings(&mut self, settings: Settings) {
        self.scene.settings = settings.clone();
        self.session.edit(Edit::Settings(Box::new(settings)));
    }

    /// Goes to a moment of the animation, in seconds.
    pub fn seek(&mut self, time: f32) {
        self.scene.time = time;
        self.session.edit(Edit::Seek(time));
    }

    /// A step is over: a drag has ended.
    pub fn close_step(&self) {
        self.session.close_step();
    }

    /// Takes the latest step back.
    pub fn undo(&self) {
        self.session.undo();
    }

    /// Makes the step again that was taken back last.
    pub fn redo(&self) {
        self.session.redo();
    }

    /// The errors since the last call.
    #[must_use]
    pub fn take_errors(&self) -> Vec<RenderError> {
        self.session.take_errors()
    }

    /// A light of the scene.
    #[must_use]
    pub fn light(&self, handle: LightHandle) -> Option<&LightItem> {
        self.scene.light(handle)
    }

    /// An object of the scene.
    #[must_use]
    pub fn object(&self, handle: ObjectHandle) -> Option<&ObjectItem> {
        self.scene.object(handle)
    }

    fn object_mut(&mut self, handle: ObjectHandle) -> Option<&mut ObjectItem> {
        self.scene.objects.iter_mut().find(|item| item.handle == handle)
    }
}

/// The box around a box that is moved.
fn moved(bounds: scene::Bounds, by: Mat4) -> scene::Bounds {
    if bounds.is_empty() {
        return bounds;
    }
    let corner = |i: u32| {
        let pick = |k: usize| if i >> k & 1 == 0 { bounds.min[k] } else { bounds.max[k] };
        by.transform_point3(glam::Vec3::new(pick(0), pick(1), pick(2)))
    };
    (0..8).map(corner).fold(scene::Bounds::EMPTY, scene::Bounds::with_point)
}
