//! The motion of a camera.

use crate::Camera;
use crate::placement::{Clock, sample};
use crate::track::Track;
use glam::Vec3;

/// Times beyond this are refused: eleven days.
pub(crate) const MAX_SECONDS: f32 = 1e6;

/// A camera over time.
#[derive(Clone, Debug)]
pub(crate) struct CameraKeys {
    pub(crate) clock: Clock,
    pub(crate) eye: Track,
    pub(crate) target: Track,
    pub(crate) up: Track,
    pub(crate) fov: Track,
}

impl CameraKeys {
    pub(crate) fn at(&self, time: f32) -> Camera {
        let time = self.clock.local(time);
        let vector = |track| Vec3::from_array(sample(track, time));
        let [vertical_fov] = sample(&self.fov, time);
        Camera { eye: vector(&self.eye), target: vector(&self.target), up: vector(&self.up), vertical_fov }
    }
}
