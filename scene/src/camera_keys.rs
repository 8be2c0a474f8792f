//! The motion of a camera.

use crate::Camera;
use crate::placement::{Clock, sample};
use crate::track::Track;
use glam::Vec3;

/// Times beyond this are refused: eleven days.
pub const MAX_SECONDS: f32 = 1e6;

/// A camera over time.
#[derive(Clone, Debug)]
pub struct CameraKeys {
    /// The clock of the keys.
    pub clock: Clock,
    /// As [`Camera::eye`]: three numbers.
    pub eye: Track,
    /// As [`Camera::target`]: three numbers.
    pub target: Track,
    /// As [`Camera::up`]: three numbers.
    pub up: Track,
    /// As [`Camera::vertical_fov`]: one number.
    pub fov: Track,
}

impl CameraKeys {
    /// The camera at a time in seconds. Not every camera between two keys is [valid](Camera::validate).
    #[must_use]
    pub fn at(&self, time: f32) -> Camera {
        let time = self.clock.local(time);
        let vector = |track| Vec3::from_array(sample(track, time));
        let [vertical_fov] = sample(&self.fov, time);
        Camera { eye: vector(&self.eye), target: vector(&self.target), up: vector(&self.up), vertical_fov }
    }
}
