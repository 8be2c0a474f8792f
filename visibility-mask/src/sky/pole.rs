use fearless_simd::{Simd, f32x8, prelude::*};
use glam::Vec3;
use lobe_core::vec3x8::Vec3x8;

/// A direction from which [`Meridians`](super::Meridians) start: one of six, the ends of three axes.
///
/// A receiver takes the one that is [nearest](Self::nearest) to its normal, at most 54.8° away, so that all its samples above the horizon are
/// the first ones of their meridians. Because poles are fixed, tables over directions are made once for all receivers.
///
/// None is an axis of the world. An edge that is parallel to the pole lies along a meridian, wherever the receiver is, and its shadow
/// comes in steps as wide as the meridians are apart; people build along the axes (`docs/experiments.md` has figures).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pole {
    number: usize,
}

/// The axes of the world, turned by 39° about (1, −1, 0): the first three poles.
pub(crate) const AXES: [Vec3; 3] = [ninth([8.0, -1.0, 4.0]), ninth([-1.0, 8.0, 4.0]), ninth([-4.0, -4.0, 7.0])];

/// The x, y and z of each pole's frame, in which it is at +z.
const FRAMES: [[Vec3; 3]; 6] = [frame(0), frame(1), frame(2), frame(3), frame(4), frame(5)];

const fn ninth([x, y, z]: [f32; 3]) -> Vec3 {
    Vec3::new(x / 9.0, y / 9.0, z / 9.0)
}

/// Right-handed. The opposite pole has x and y of the other in the other order.
const fn frame(number: usize) -> [Vec3; 3] {
    let [one, other, up] = [AXES[(number + 1) % 3], AXES[(number + 2) % 3], AXES[number % 3]];
    if number < 3 { [one, other, up] } else { [other, one, Vec3::new(-up.x, -up.y, -up.z)] }
}

impl Pole {
    /// All poles, in the order of their [numbers](Self::number).
    pub const ALL: [Self; 6] = [Self::of(0), Self::of(1), Self::of(2), Self::of(3), Self::of(4), Self::of(5)];

    const fn of(number: usize) -> Self {
        Self { number }
    }

    /// The pole that is nearest to a direction of any length. Any pole for a direction without one.
    #[must_use]
    pub fn nearest(normal: Vec3) -> Self {
        let along = Vec3::from_array(AXES.map(|axis| axis.dot(normal)));
        let axis = along.abs().max_position();
        Self::ALL[if along[axis] < 0.0 { axis + 3 } else { axis }]
    }

    /// Its place among [all](Self::ALL).
    #[must_use]
    pub const fn number(self) -> usize {
        self.number
    }

    /// The x, y and z of its frame, in the world.
    pub(crate) const fn frame(self) -> [Vec3; 3] {
        FRAMES[self.number]
    }

    /// A vector of the world in the pole's frame.
    #[must_use]
    pub fn local(self, v: Vec3) -> Vec3 {
        Vec3::from_array(self.frame().map(|axis| axis.dot(v)))
    }

    /// The same of eight vectors.
    #[inline(always)]
    pub(crate) fn local_of<S: Simd>(self, v: Vec3x8<S>) -> Vec3x8<S> {
        let [x, y, z] = self.frame();
        Vec3x8::new(v.dot_one(x), v.dot_one(y), v.dot_one(z))
    }

    /// At most so far from the line along the pole through its middle reaches a box of such half sides along the world's axes.
    #[must_use]
    pub fn reach(self, half: Vec3) -> f32 {
        let [x, y, _] = self.frame().map(|axis| axis.abs().dot(half.abs()));
        (x * x + y * y).min(half.length_squared()).sqrt()
    }

    /// The same of eight boxes.
    #[inline(always)]
    pub(crate) fn reach_of<S: Simd>(self, half: Vec3x8<S>) -> f32x8<S> {
        let [x, y, _] = self.frame();
        let (x, y) = (half.dot_one(x.abs()), half.dot_one(y.abs()));
        (x * x + y * y).min(half.length_squared()).sqrt()
    }

    /// A vector of the pole's frame in the world.
    #[must_use]
    pub fn world(self, v: Vec3) -> Vec3 {
        let [x, y, z] = self.frame();
        x * v.x + y * v.y + z * v.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_right_handed_and_inverse() {
        for (number, pole) in Pole::ALL.into_iter().enumerate() {
            let axes = pole.frame();
            for (k, axis) in axes.into_iter().enumerate() {
                assert!((axis.length() - 1.0).abs() < 1e-6);
                assert!(axes[(k + 1) % 3].cross(axes[(k + 2) % 3]).distance(axis) < 1e-6);
                // No axis of the world is near.
                assert!(axis.abs().max_element() < 0.93);
            }
            assert_eq!((pole.number(), Pole::nearest(axes[2])), (number, pole));
            let v = Vec3::new(0.3, -0.7, 0.2);
            assert!(pole.world(pole.local(v)).distance(v) < 1e-6);
            let corners =
                [v, v * Vec3::new(-1.0, 1.0, 1.0), v * Vec3::new(1.0, -1.0, 1.0), v * Vec3::new(1.0, 1.0, -1.0)];
            assert!(corners.into_iter().all(|corner| pole.local(corner).truncate().length() <= 1.0001 * pole.reach(v)));
        }
    }
}
