//! Rotations through keys of an axis and degrees.

use glam::{Quat, Vec3};
use scene::motion::{Interpolation, Meaning, Track, Turn, rotation};

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
    Track::new(times, values, width, Interpolation::Linear, meaning)
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
}
