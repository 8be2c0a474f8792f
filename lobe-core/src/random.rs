use core::f64::consts::TAU;
use glam::DVec3;

/// A small deterministic generator: SplitMix64 (G. Steele, D. Lea, C. Flood, *Fast Splittable Pseudorandom Number Generators*,
/// OOPSLA 2014). The same seed gives the same numbers everywhere.
#[derive(Clone, Debug)]
pub struct Random {
    state: u64,
}

impl Random {
    /// A generator of the given seed.
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// 64 random bits.
    #[inline]
    pub fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in [from, to).
    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.uniform()
    }

    /// Log-uniform in [from, to), both positive.
    pub fn log_uniform(&mut self, from: f64, to: f64) -> f64 {
        self.between(from.ln(), to.ln()).exp()
    }

    /// A lobe exponent in [0, max]: mostly log-uniform from 1e-2 on, one in eight a value that breaks things (0, 1e-6,
    /// 1, `max`).
    pub fn exponent(&mut self, max: f64) -> f64 {
        if self.bits().is_multiple_of(8) {
            [0.0, 1e-6, 1.0, max][(self.bits() % 4) as usize]
        } else {
            self.log_uniform(1e-2, max)
        }
    }

    /// A unit vector, uniform over the sphere.
    pub fn axis(&mut self) -> DVec3 {
        let z = self.between(-1.0, 1.0);
        let (sin, cos) = (TAU * self.uniform()).sin_cos();
        let r = ((1.0 - z) * (1.0 + z)).sqrt();
        DVec3::new(r * cos, r * sin, z)
    }

    /// A unit vector at the given angle from the unit vector `from`, in a random direction.
    pub fn axis_at(&mut self, from: DVec3, angle: f64) -> DVec3 {
        let (u, w) = from.any_orthonormal_pair();
        let (sin, cos) = (TAU * self.uniform()).sin_cos();
        (from * angle.cos() + (u * cos + w * sin) * angle.sin()).normalize()
    }

    /// A unit vector nearly parallel to `from`: its angle is log-uniform in [1e-8, 0.1), one in eight exactly 0.
    pub fn axis_near(&mut self, from: DVec3) -> DVec3 {
        if self.bits().is_multiple_of(8) {
            return from;
        }
        let angle = self.log_uniform(1e-8, 0.1);
        self.axis_at(from, angle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_unit_and_centred() {
        let mut random = Random::new(1);
        let mut sum = DVec3::ZERO;
        for _ in 0..4096 {
            let a = random.axis();
            assert!((a.length() - 1.0).abs() < 1e-12);
            let b = random.axis_near(a);
            assert!(a.angle_between(b) < 0.1 + 1e-9);
            sum += a;
        }
        // Standard deviation of the mean of each component: 1/√(3·4096) = 0.009.
        assert!(sum.length() / 4096.0 < 0.06);
    }
}
