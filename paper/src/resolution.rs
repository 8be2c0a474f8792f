use core::f64::consts::PI;

/// Powers of ten that bound the intervals after [0, 1]: up to 1e5.
const INTERVALS: usize = 6;

/// How finely the tables of the paper sample exponents and angles (§4.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resolution {
    /// Angles, linearly spaced over [0, π], both ends included.
    ///
    /// The paper prints [0, 2π]; axes are never more than π apart, so all samples go into the useful half.
    pub angles: usize,
    /// Exponents in each of [0, 1], [1, 10], …, [1e4, 1e5], linearly spaced, both ends included (and shared).
    pub per_interval: usize,
}

impl Resolution {
    /// The paper's: 128 angles, 16 exponents an interval.
    pub const PAPER: Self = Self { angles: 128, per_interval: 16 };

    /// Number of distinct exponents: 91 for the paper's table.
    #[must_use]
    pub const fn exponents(&self) -> usize {
        INTERVALS * (self.per_interval - 1) + 1
    }

    /// The exponent of the given index.
    #[must_use]
    pub fn exponent(&self, index: usize) -> f64 {
        let steps = self.per_interval - 1;
        let (interval, step) = (index / steps, index % steps);
        let fraction = step as f64 / steps as f64;
        if interval == 0 {
            return fraction;
        }
        let start = 10f64.powi(interval as i32 - 1);
        start + fraction * 9.0 * start
    }

    /// The angle of the given index, radians.
    #[must_use]
    pub fn angle(&self, index: usize) -> f64 {
        PI * index as f64 / (self.angles - 1) as f64
    }

    /// Index of the sample below an exponent and the fraction of the way to the next; clamped to the table.
    pub(crate) fn locate_exponent(&self, exponent: f32) -> (usize, f32) {
        let e = exponent.clamp(0.0, 1e5);
        let steps = (self.per_interval - 1) as f32;
        let (mut base, mut start, mut length) = (0, 0.0, 1.0);
        if e >= 1.0 {
            (base, start, length) = (1, 1.0, 9.0);
            while e >= start * 10.0 && base < INTERVALS - 1 {
                (base, start, length) = (base + 1, start * 10.0, length * 10.0);
            }
        }
        let position = (e - start) / length * steps;
        let step = (position as usize).min(self.per_interval - 2);
        (base * (self.per_interval - 1) + step, position - step as f32)
    }

    /// As [`locate_exponent`](Self::locate_exponent), for an angle in radians.
    pub(crate) fn locate_angle(&self, angle: f32) -> (usize, f32) {
        let position =
            angle.clamp(0.0, core::f32::consts::PI) * (core::f32::consts::FRAC_1_PI * (self.angles - 1) as f32);
        let step = (position as usize).min(self.angles - 2);
        (step, position - step as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_as_printed() {
        let r = Resolution::PAPER;
        assert_eq!(r.exponents(), 91);
        assert_eq!((r.exponent(0), r.exponent(15), r.exponent(30), r.exponent(90)), (0.0, 1.0, 10.0, 1e5));
        assert!((0..91).map(|i| r.exponent(i)).is_sorted());
        assert_eq!(r.angle(127), PI);
    }

    #[test]
    fn location_inverts_sampling() {
        for r in [Resolution::PAPER, Resolution { angles: 7, per_interval: 2 }] {
            for i in 0..r.exponents() {
                let (index, fraction) = r.locate_exponent(r.exponent(i) as f32);
                assert!((index as f32 + fraction - i as f32).abs() < 1e-4, "{i} {index} {fraction}");
            }
            for i in 0..r.angles {
                let (index, fraction) = r.locate_angle(r.angle(i) as f32);
                assert!((index as f32 + fraction - i as f32).abs() < 1e-4, "{i} {index} {fraction}");
            }
            for e in [-1.0, f32::NAN, 1e9, f32::INFINITY] {
                assert!(r.locate_exponent(e).0 + 2 <= r.exponents());
            }
        }
    }
}
