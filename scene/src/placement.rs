//! The placement of a part of the scene file, over time.

use crate::origin::Origins;
use crate::track::{Meaning, Track};
use glam::{DQuat, DVec3, Mat4, Quat, Vec3};

/// Keys that end, or start again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Clock {
    pub(crate) first: f32,
    pub(crate) last: f32,
    pub(crate) repeats: bool,
}

impl Clock {
    /// The time on the keys' own clock: after the last key it starts again from the first.
    pub(crate) fn local(&self, time: f32) -> f32 {
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
pub(crate) enum Turn {
    /// By so many degrees, more than a full turn included, about one unit axis.
    About(Vec3, Track),
    /// Through quaternions.
    Free(Track),
}

/// A matrix over time.
#[derive(Clone, Debug)]
pub(crate) enum Placement {
    Fixed(Mat4),
    Keys(Box<Keyed>),
}

/// Scaled first, then turned, then moved.
#[derive(Clone, Debug)]
pub(crate) struct Keyed {
    pub(crate) clock: Clock,
    pub(crate) scale: Track,
    pub(crate) turn: Turn,
    /// Without [`Origins::shift`].
    pub(crate) translation: Track,
    pub(crate) origins: Origins,
}

/// The rotation about a unit axis; any finite number of degrees.
pub(crate) fn rotation(axis: Vec3, degrees: f32) -> Quat {
    Quat::from_axis_angle(axis, angle(degrees) as f32)
}

/// The same in double precision.
pub(crate) fn fine_rotation(axis: Vec3, degrees: f32) -> DQuat {
    DQuat::from_axis_angle(axis.as_dvec3().normalize(), angle(degrees))
}

/// Radians. Whole turns go first: in radians and single precision they would cost accuracy.
fn angle(degrees: f32) -> f64 {
    f64::from(degrees).rem_euclid(360.0).to_radians()
}

impl Turn {
    fn at(&self, time: f32) -> Quat {
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
    pub(crate) fn keeps_size(&self) -> bool {
        match self {
            Self::Fixed(_) => true,
            Self::Keys(keys) => keys.scale.is_constant(),
        }
    }

    /// The matrix from own coordinates to the world.
    pub(crate) fn at(&self, time: f32) -> Mat4 {
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

    pub(crate) const fn is_fixed(&self) -> bool {
        matches!(self, Self::Fixed(_))
    }

    /// Seconds until the last key.
    pub(crate) fn end(&self) -> f32 {
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

/// A rotation through keys of an axis and degrees: about one axis by degrees, so that any number of turns is meant as
/// written; about several along the shorter arc, but for neighbours about one axis, between which it is by degrees too.
pub(crate) fn linear_turn(times: &[f32], keys: &[(Vec3, f32)]) -> Turn {
    if let Some((axis, degrees)) = one_axis(keys) {
        return Turn::About(axis, track(times.to_vec(), degrees, 1, Meaning::Numbers));
    }
    let (mut all, mut values) = (Vec::new(), Vec::new());
    for (i, &(axis, degrees)) in keys.iter().enumerate() {
        all.push(times[i]);
        values.extend(rotation(axis, degrees).to_array());
        let Some(pair) = keys.get(i..i + 2) else { break };
        if let Some((axis, degrees)) = one_axis(pair) {
            // Steps of at most 90° about one axis, so that the shorter arc between two steps is the intended one.
            let steps = ((degrees[1] - degrees[0]).abs() / 90.0).ceil().clamp(1.0, 4096.0) as u32;
            for k in 1..steps {
                let u = k as f32 / steps as f32;
                all.push(times[i] + (times[i + 1] - times[i]) * u);
                values.extend(rotation(axis, degrees[0] + (degrees[1] - degrees[0]) * u).to_array());
            }
        }
    }
    Turn::Free(track(all, values, 4, Meaning::Rotation))
}

/// As [`linear_turn`], with continuous velocity.
pub(crate) fn smooth_turn(times: &[f32], keys: &[(Vec3, f32)], closed: bool) -> Turn {
    if let Some((axis, degrees)) = one_axis(keys) {
        return Turn::About(axis, Track::smooth(times.to_vec(), &degrees, 1, closed, Meaning::Numbers));
    }
    let mut last = Quat::IDENTITY;
    let mut values = Vec::new();
    for &(axis, degrees) in keys {
        let q = rotation(axis, degrees);
        last = if q.dot(last) < 0.0 { -q } else { q };
        values.extend(last.to_array());
    }
    Turn::Free(Track::smooth(times.to_vec(), &values, 4, closed, Meaning::Rotation))
}

fn track(times: Vec<f32>, values: Vec<f32>, width: usize, meaning: Meaning) -> Track {
    Track::new(times, values, width, crate::track::Interpolation::Linear, meaning)
}

/// The axis that all keys turn about, and their degrees about it; 0° is about any axis.
pub(crate) fn one_axis(keys: &[(Vec3, f32)]) -> Option<(Vec3, Vec<f32>)> {
    let axis = keys.iter().find(|(_, degrees)| *degrees != 0.0).map_or(Vec3::Y, |&(axis, _)| axis);
    let about = |&(a, degrees): &(Vec3, f32)| {
        let along = a.dot(axis);
        match degrees {
            0.0 => Some(0.0),
            _ if along > 1.0 - 1e-6 => Some(degrees),
            _ if along < -1.0 + 1e-6 => Some(-degrees),
            _ => None,
        }
    };
    Some((axis, keys.iter().map(about).collect::<Option<Vec<f32>>>()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_are_meant_as_written() {
        let turn = linear_turn(&[0.0, 2.0], &[(Vec3::Y, 0.0), (Vec3::Z, 720.0)]);
        for (time, degrees) in [(0.5_f32, 180.0_f32), (0.75, 270.0), (1.0, 360.0), (1.25, 450.0)] {
            let want = Quat::from_rotation_z(degrees.to_radians());
            assert!(turn.at(time).dot(want).abs() > 1.0 - 1e-6, "{time}");
        }
        // 270° about z, then on to a quarter turn about x: first the long way, then the short one.
        let turn = linear_turn(&[0.0, 1.0, 2.0], &[(Vec3::Z, 0.0), (Vec3::NEG_Z, -270.0), (Vec3::X, 90.0)]);
        let near = |time: f32, want: Quat| turn.at(time).dot(want).abs() > 1.0 - 1e-5;
        assert!(near(0.5, Quat::from_rotation_z(135_f32.to_radians())));
        assert!(near(1.0, Quat::from_rotation_z(270_f32.to_radians())));
        let (from, to) = (Quat::from_rotation_z(-90_f32.to_radians()), Quat::from_rotation_x(90_f32.to_radians()));
        assert!(near(1.5, from.slerp(to, 0.5)) && near(2.0, to));
    }

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
