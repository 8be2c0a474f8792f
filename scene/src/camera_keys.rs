//! The motion of a camera.

use crate::placement::{Clock, sample};
use crate::track::Track;
use crate::{Camera, Projection};
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
    /// As [`Camera::projection`].
    pub projection: ProjectionKeys,
}

/// A projection over time: it keeps its kind.
#[derive(Clone, Debug)]
pub enum ProjectionKeys {
    /// The full vertical field of view in radians: one number.
    Perspective(Track),
    /// The height in units of the scene: one number.
    Orthographic(Track),
    /// Without a number.
    Panoramic,
}

impl ProjectionKeys {
    /// The projection at a time of the keys' clock, in seconds.
    #[must_use]
    pub fn at(&self, time: f32) -> Projection {
        let number = |track| -> f32 {
            let [number] = sample(track, time);
            number
        };
        match self {
            Self::Perspective(track) => Projection::perspective(number(track)),
            Self::Orthographic(track) => Projection::Orthographic { height: number(track) },
            Self::Panoramic => Projection::Panoramic,
        }
    }

    /// Its numbers over time, where it has any.
    #[must_use]
    pub const fn track(&self) -> Option<&Track> {
        match self {
            Self::Perspective(track) | Self::Orthographic(track) => Some(track),
            Self::Panoramic => None,
        }
    }
}

impl CameraKeys {
    /// The camera at a time in seconds. Not every camera between two keys is [valid](Camera::validate).
    #[must_use]
    pub fn at(&self, time: f32) -> Camera {
        let time = self.clock.local(time);
        let vector = |track| Vec3::from_array(sample(track, time));
        let projection = self.projection.at(time);
        Camera { eye: vector(&self.eye), target: vector(&self.target), up: vector(&self.up), projection }
    }
}
