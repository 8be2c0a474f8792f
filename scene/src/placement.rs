//! The placement of a part of a scene, over time.

use crate::origins::Origins;
use crate::track::Track;
use glam::{DQuat, DVec3, Mat4, Quat, Vec3};

/// Keys that end, or start again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// The time of the first key, in seconds.
    pub first: f32,
    /// The time of the last key, in seconds.
    pub last: f32,
    /// Whether the keys start again after the last one.
    pub repeats: bool,
}

impl Clock {
    /// The time on the keys' own clock: after the last key it starts again from the first.
    #[must_use]
    pub fn local(&self, time: f32) -> f32 {
        let period = self.last - self.first;
        if self.repeats && time > self.last && period > 0.0 {
            self.first + (time - self.last).rem_euclid(period)
        } else {
            time
        }
    }
}

/// A rotation over time.
#[derive(Clone, Debug)]
pub enum Turn {
    /// By so many degrees, more than a full turn included, about one unit axis.
    About(Vec3, Track),
    /// Through quaternions.
    Free(Track),
}

/// A matrix over time.
#[derive(Clone, Debug)]
pub enum Placement {
    /// The same at all times.
    Fixed(Mat4),
    /// By key frames.
    Keys(Box<Keyed>),
}

/// Scaled first, then turned, then moved.
#[derive(Clone, Debug)]
pub struct Keyed {
    /// The clock of the keys.
    pub clock: Clock,
    /// Three numbers.
    pub scale: Track,
    /// The rotation.
    pub turn: Turn,
    /// Three numbers, without [`Origins::shift`].
    pub translation: Track,
    /// The origins of these numbers.
    pub origins: Origins,
}

/// The rotation about a unit axis; any finite number of degrees.
#[must_use]
pub fn rotation(axis: Vec3, degrees: f32) -> Quat {
    Quat::from_axis_angle(axis, angle(degrees) as f32)
}

/// The same in double precision.
#[must_use]
pub fn fine_rotation(axis: Vec3, degrees: f32) -> DQuat {
    DQuat::from_axis_angle(axis.as_dvec3().normalize(), angle(degrees))
}

/// Radians. Whole turns go first: in radians and single precision they would cost accuracy.
fn angle(degrees: f32) -> f64 {
    f64::from(degrees).rem_euclid(360.0).to_radians()
}

impl Turn {
    /// The rotation at a time on the clock of the keys, in seconds.
    #[must_use]
    pub fn at(&self, time: f32) -> Quat {
        match self {
            Self::About(axis, degrees) => rotation(*axis, sample::<1>(degrees, time)[0]),
            Self::Free(track) => Quat::from_array(sample(track, time)),
        }
    }

    fn fine(&self, time: f32) -> DQuat {
        match self {
            Self::About(axis, degrees) => fine_rotation(*axis, sample::<1>(degrees, time)[0]),
            Self::Free(_) => self.at(time).as_dquat().normalize(),
        }
    }
}

impl Placement {
    /// Whether lengths are the same at all times.
    #[must_use]
    pub fn keeps_size(&self) -> bool {
        match self {
            Self::Fixed(_) => true,
            Self::Keys(keys) => keys.scale.is_constant(),
        }
    }

    /// The matrix from own coordinates to the world, at a time in seconds.
    #[must_use]
    pub fn at(&self, time: f32) -> Mat4 {
        match self {
            Self::Fixed(matrix) => *matrix,
            Self::Keys(keys) => {
                let time = keys.clock.local(time);
                let (scale, moved) = (sample(&keys.scale, time), sample(&keys.translation, time));
                let turn = keys.turn.at(time);
                let scale = Vec3::from_array(scale);
                let matrix = Mat4::from_scale_rotation_translation(scale, turn, Vec3::from_array(moved));
                keys.origins.place(matrix, |p: DVec3| keys.turn.fine(time) * (scale.as_dvec3() * p))
            }
        }
    }

    /// Whether it is [`Self::Fixed`].
    #[must_use]
    pub const fn is_fixed(&self) -> bool {
        matches!(self, Self::Fixed(_))
    }

    /// Seconds until the last key.
    #[must_use]
    pub fn end(&self) -> f32 {
        match self {
            Self::Fixed(_) => 0.0,
            Self::Keys(keys) => keys.clock.last,
        }
    }
}

/// The value of a track of that width.
pub(crate) fn sample<const N: usize>(track: &Track, time: f32) -> [f32; N] {
    let mut out = [0.0; N];
    track.sample(time, &mut out);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeating_clocks_start_again_after_their_last_key() {
        let clock = Clock { first: 1.0, last: 3.0, repeats: true };
        for (time, local) in [(0.0, 0.0), (1.0, 1.0), (3.0, 3.0), (3.5, 1.5), (5.0, 1.0), (8.0, 2.0)] {
            assert_eq!(clock.local(time), local);
        }
        assert_eq!(Clock { repeats: false, ..clock }.local(8.0), 8.0);
        assert_eq!(Clock { last: 1.0, ..clock }.local(8.0), 8.0);
    }
}
