use glam::Vec3;

/// The end of an axis of the world from which [`Meridians`](super::Meridians) start: one of six.
///
/// A receiver takes the one that is [nearest](Self::nearest) to its normal, at most 54.8° away, so that all its samples above the horizon are
/// the first ones of their meridians. Because poles are fixed, tables over directions are made once for all receivers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pole {
    /// The world's axes that are the x, y and z of the pole's own frame, in which it is at +z.
    axes: [usize; 3],
    /// Whether z is the world's axis turned round.
    is_negative: bool,
}

impl Pole {
    /// All poles, in the order of their [numbers](Self::number).
    pub const ALL: [Self; 6] = [Self::of(0), Self::of(1), Self::of(2), Self::of(3), Self::of(4), Self::of(5)];

    const fn of(number: usize) -> Self {
        let axis = number % 3;
        let [one, other] = [(axis + 1) % 3, (axis + 2) % 3];
        // Right-handed.
        let is_negative = number >= 3;
        Self { axes: if is_negative { [other, one, axis] } else { [one, other, axis] }, is_negative }
    }

    /// The pole that is nearest to a direction of any length. Any pole for a direction without one.
    #[must_use]
    pub fn nearest(normal: Vec3) -> Self {
        let axis = normal.abs().max_position();
        Self::ALL[if normal[axis] < 0.0 { axis + 3 } else { axis }]
    }

    /// Its place among [all](Self::ALL).
    #[must_use]
    pub const fn number(self) -> usize {
        self.axes[2] + if self.is_negative { 3 } else { 0 }
    }

    /// The world's axes that are x, y and z of its frame, and the sign of z.
    #[must_use]
    pub(crate) const fn axes(self) -> ([usize; 3], f32) {
        (self.axes, if self.is_negative { -1.0 } else { 1.0 })
    }

    /// A vector of the world in the pole's frame.
    #[must_use]
    pub fn local(self, v: Vec3) -> Vec3 {
        let ([x, y, z], sign) = self.axes();
        Vec3::new(v[x], v[y], sign * v[z])
    }

    /// A vector of the pole's frame in the world.
    #[must_use]
    pub fn world(self, v: Vec3) -> Vec3 {
        let ([x, y, z], sign) = self.axes();
        let mut out = Vec3::ZERO;
        (out[x], out[y], out[z]) = (v.x, v.y, sign * v.z);
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_right_handed_and_inverse() {
        for (number, pole) in Pole::ALL.into_iter().enumerate() {
            let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|v| pole.world(v));
            assert_eq!(axes[0].cross(axes[1]), axes[2]);
            assert_eq!((pole.number(), Pole::nearest(axes[2])), (number, pole));
            let v = Vec3::new(0.3, -0.7, 0.2);
            assert_eq!(pole.world(pole.local(v)), v);
        }
    }
}
