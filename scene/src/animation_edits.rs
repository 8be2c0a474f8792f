//! Animations that are made and changed in code.

use crate::animation::{Body, LightMover, Mover};
use crate::camera_keys::MAX_SECONDS;
use crate::deformer::{BoundSphere, Deformer};
use crate::mesh::MAX_COORDINATE;
use crate::origins::Origins;
use crate::placement::{Clock, Keyed, Placement, Turn};
use crate::track::{Interpolation, Meaning, Track};
use crate::{Animation, Object, Proxy, Scene, SceneError, Shape};
use glam::{Mat4, Quat, Vec3};
use lighting::Light;
use lobe_core::{NO_OBJECT, Sphere};

/// Where an object is at one time: scaled first, then turned, then moved from where it stands in its scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyFrame {
    /// Seconds.
    pub time: f32,
    /// The same along all axes; above 0.
    pub scale: f32,
    /// A unit quaternion; between two keys along the shorter arc.
    pub rotation: Quat,
    /// A shift.
    pub translation: Vec3,
}

/// The motion of one object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KeyFrames {
    /// At least one, in the order of their times.
    pub keys: Vec<KeyFrame>,
    /// Whether velocities are continuous; else straight from key to key.
    pub is_smooth: bool,
    /// Whether it starts again after its last key.
    pub repeats: bool,
}

impl KeyFrame {
    /// Where the object stands in its scene.
    #[must_use]
    pub const fn at(time: f32) -> Self {
        Self { time, scale: 1.0, rotation: Quat::IDENTITY, translation: Vec3::ZERO }
    }
}

impl KeyFrames {
    fn check(&self) -> Result<(), SceneError> {
        let fault = |i: usize, what: String| Err(SceneError::invalid(format!("key {i}: {what}")));
        if self.keys.is_empty() {
            return Err(SceneError::invalid("expected at least one key"));
        }
        for (i, key) in self.keys.iter().enumerate() {
            let KeyFrame { time, scale, rotation, translation } = *key;
            if !(0.0..=MAX_SECONDS).contains(&time) {
                return fault(i, format!("time {time} must lie between 0 and {MAX_SECONDS} seconds"));
            }
            if i > 0 && time <= self.keys[i - 1].time {
                return fault(i, format!("time {time} is not later than that of the key before"));
            }
            if !(scale > 0.0 && scale <= MAX_COORDINATE) {
                return fault(i, format!("scale {scale} must be above 0"));
            }
            if (rotation.length() - 1.0).abs() > 1e-3 || rotation.is_nan() {
                return fault(i, format!("rotation {rotation} is not a unit quaternion"));
            }
            if translation.is_nan() || translation.abs().max_element() > MAX_COORDINATE {
                return fault(i, format!("translation {translation} must lie within ±1e9"));
            }
        }
        Ok(())
    }

    fn track(&self, width: usize, meaning: Meaning, value: impl Fn(&KeyFrame) -> Vec<f32>) -> Track {
        let times: Vec<f32> = self.keys.iter().map(|key| key.time).collect();
        let values: Vec<f32> = self.keys.iter().flat_map(value).collect();
        match self.is_smooth {
            true => Track::smooth(times, &values, width, self.repeats && self.keys.len() > 1, meaning),
            false => Track::new(times, values, width, Interpolation::Linear, meaning),
        }
    }

    fn placement(&self) -> Placement {
        let (first, last) = (self.keys[0].time, self.keys[self.keys.len() - 1].time);
        // Neighbours in one half of the quaternions: the shorter arc.
        let mut turns: Vec<Quat> = Vec::with_capacity(self.keys.len());
        for key in &self.keys {
            let turn = key.rotation.normalize();
            turns.push(if turns.last().is_some_and(|last| last.dot(turn) < 0.0) { -turn } else { turn });
        }
        let near = Self {
            keys: self.keys.iter().zip(turns).map(|(key, rotation)| KeyFrame { rotation, ..*key }).collect(),
            ..*self
        };
        Placement::Keys(Box::new(Keyed {
            clock: Clock { first, last, repeats: self.repeats },
            scale: near.track(3, Meaning::Numbers, |key| vec![key.scale; 3]),
            turn: Turn::Free(near.track(4, Meaning::Rotation, |key| key.rotation.to_array().to_vec())),
            translation: near.track(3, Meaning::Numbers, |key| key.translation.to_array().to_vec()),
            origins: Origins::default(),
        }))
    }
}

impl Animation {
    /// Moves an object of a scene by keys, from where it stands there; keys that it had before are replaced. The object is then posed
    /// as at time 0, and the scene with it is the one that [`seek`](Self::seek) poses.
    ///
    /// ```
    /// use glam::Vec3;
    /// use scene::{Animation, KeyFrame, KeyFrames};
    /// let mut scene = scene::builtin();
    /// let before = scene.objects[1].shape.bounds().center();
    /// let mut animation = Animation::default();
    /// let keys = vec![KeyFrame::at(0.0), KeyFrame { translation: Vec3::X, ..KeyFrame::at(2.0) }];
    /// animation.set_keys(1, &KeyFrames { keys, ..KeyFrames::default() }, &mut scene)?;
    /// animation.seek(1.0, &mut scene);
    /// let moved = scene.objects[1].shape.bounds().center() - before;
    /// assert!(moved.distance(0.5 * Vec3::X) < 1e-5 && animation.duration() == 2.0);
    /// # Ok::<(), scene::SceneError>(())
    /// ```
    ///
    /// # Errors
    /// [`SceneError::Invalid`] for an object that is not there, one with a clip of its file, and keys that are out of order or range.
    pub fn set_keys(&mut self, object: usize, keys: &KeyFrames, scene: &mut Scene) -> Result<(), SceneError> {
        let count = scene.objects.len();
        let Some(moved) = scene.objects.get_mut(object) else {
            return Err(SceneError::invalid(format!("there is no object {object} of {count}")));
        };
        if let Some(Mover { body: Body::Mesh(_, Some(_)), .. }) = self.movers.get(object).and_then(Option::as_ref) {
            return Err(SceneError::invalid(format!("object \"{}\" is moved by a clip of its file", moved.name)));
        }
        let name = |e: SceneError| SceneError::invalid(format!("object \"{}\": {e}", moved.name));
        keys.check().map_err(name)?;
        let body = match &moved.shape {
            Shape::Mesh(mesh) => Body::Mesh(Box::new(Deformer::rigid(mesh)), None),
            Shape::Instances(instances) => {
                let mesh = instances.expanded();
                let body = Body::Mesh(Box::new(Deformer::rigid(&mesh)), None);
                moved.shape = Shape::Mesh(mesh);
                body
            }
            Shape::Spheres(spheres) => Body::Spheres(spheres.clone()),
        };
        let placement = keys.placement();
        let proxy = match &mut moved.proxy {
            Proxy::Spheres(spheres) => {
                let bind = |s: &Sphere| BoundSphere::new(*s, [0; 4], [1.0, 0.0, 0.0, 0.0], &[Mat4::IDENTITY]);
                spheres.iter().map(bind).collect()
            }
            Proxy::File { placement: own, .. } => {
                *own = placement.at(0.0) * *own;
                Vec::new()
            }
            Proxy::None | Proxy::Count(_) => Vec::new(),
        };
        self.movers.resize(self.movers.len().max(object + 1), None);
        self.movers[object] = Some(Mover { placement, body, proxy });
        self.seek(0.0, scene);
        Ok(())
    }

    /// Whether it moves an object.
    #[must_use]
    pub fn moves_object(&self, object: usize) -> bool {
        self.movers.get(object).is_some_and(Option::is_some)
    }

    /// Whether it moves a light.
    #[must_use]
    pub fn moves_light(&self, light: usize) -> bool {
        self.lights.iter().any(|mover| (mover.first..mover.first + mover.lights.len()).contains(&light))
    }

    /// Whether it moves the camera.
    #[must_use]
    pub const fn moves_camera(&self) -> bool {
        self.camera.is_some()
    }

    /// Lets the camera stand still from now on, to be moved by others.
    pub fn release_camera(&mut self) {
        self.camera = None;
    }

    /// Forgets an object that is [taken out](Scene::remove_object) of the scene: those behind it have numbers that are one less.
    pub fn remove_object(&mut self, object: usize) {
        if object < self.movers.len() {
            self.movers.remove(object);
        }
        let lights = self.lights.iter_mut().flat_map(|mover| &mut mover.lights);
        lights.for_each(|light| forget_object(light, object));
    }

    /// Makes room for an object that is [put into](Scene::insert_object) the scene and stands still: those from its number on have
    /// numbers that are one more.
    pub fn insert_object(&mut self, object: usize) {
        if object < self.movers.len() {
            self.movers.insert(object, None);
        }
        let lights = self.lights.iter_mut().flat_map(|mover| &mut mover.lights);
        lights.for_each(|light| make_room(light, object));
    }

    /// Makes room for a light that is put into the scene and stands still: those from its number on have numbers that are one more.
    pub fn insert_light(&mut self, light: usize) {
        let mut parts = Vec::with_capacity(self.lights.len());
        for mut mover in self.lights.drain(..) {
            // A row of lights that move as one becomes two.
            if mover.first < light && light < mover.first + mover.lights.len() {
                let lights = mover.lights.split_off(light - mover.first);
                let placement = mover.placement.clone();
                parts.push(mover);
                parts.push(LightMover { first: light + 1, lights, placement });
                continue;
            }
            if mover.first >= light {
                mover.first += 1;
            }
            parts.push(mover);
        }
        self.lights = parts;
    }

    /// Forgets a light that is taken out of the scene: those behind it have numbers that are one less.
    pub fn remove_light(&mut self, light: usize) {
        let mut parts = Vec::with_capacity(self.lights.len());
        for mut mover in self.lights.drain(..) {
            if mover.first > light {
                mover.first -= 1;
            } else if light < mover.first + mover.lights.len() {
                mover.lights.remove(light - mover.first);
            }
            if !mover.lights.is_empty() {
                parts.push(mover);
            }
        }
        self.lights = parts;
    }
}

impl Scene {
    /// Takes an object out; those behind it have numbers that are one less, for the lights inside them as well.
    ///
    /// # Panics
    /// When there is no such object.
    pub fn remove_object(&mut self, object: usize) -> Object {
        self.lights.iter_mut().for_each(|light| forget_object(light, object));
        self.objects.remove(object)
    }

    /// Puts an object in at a number; those from there on have numbers that are one more, for the lights inside them as well.
    ///
    /// # Panics
    /// When the number is more than that of the objects.
    pub fn insert_object(&mut self, number: usize, object: Object) {
        self.lights.iter_mut().for_each(|light| make_room(light, number));
        self.objects.insert(number, object);
    }
}

/// Keeps a light inside its object when another one is put in.
fn make_room(light: &mut Light, object: usize) {
    let Light::Enclosed(inside) = light else { return };
    if inside.object != NO_OBJECT && inside.object as usize >= object {
        inside.object += 1;
    }
}

/// Keeps a light inside its object when another one is taken out.
fn forget_object(light: &mut Light, object: usize) {
    let Light::Enclosed(inside) = light else { return };
    inside.object = match inside.object as usize {
        own if own == object => NO_OBJECT,
        own if own > object && inside.object != NO_OBJECT => inside.object - 1,
        _ => inside.object,
    };
}
