use glam::Vec3;

/// A [`lobe_core::Random`] that draws and shuffles.
pub(crate) struct Random(lobe_core::Random);

impl Random {
    pub(crate) const fn new(seed: u64) -> Self {
        Self(lobe_core::Random::new(seed))
    }

    pub(crate) fn bits(&mut self) -> u64 {
        self.0.bits()
    }

    /// Uniform in `[0, 1)`.
    pub(crate) fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1_u64 << 24) as f32
    }

    /// Uniform in `0..end`, `end ≥ 1`; the bias of the product form is below 2⁻³² × end.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        (((self.bits() >> 32) * end as u64) >> 32) as usize
    }

    pub(crate) fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}

/// Point `i` of the additive recurrence on the generalised golden ratio, in the unit cube (M. Roberts, *The Unreasonable
/// Effectiveness of Quasirandom Sequences*, 2018).
pub(crate) fn quasi_random(i: usize) -> Vec3 {
    // Powers of 1/φ₃ with φ₃⁴ = φ₃ + 1.
    const STEP: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_3];
    Vec3::from_array(STEP.map(|step| (0.5 + (i + 1) as f64 * step).fract() as f32))
}

/// Direction `i` of `n` on a Fibonacci spiral over the whole sphere.
pub(crate) fn fibonacci(i: usize, n: usize) -> Vec3 {
    let z = 1.0 - 2.0 * (i as f64 + 0.5) / n as f64;
    let turn = std::f64::consts::PI * (1.0 + 5.0_f64.sqrt()) * (i as f64 + 0.5);
    let s = (1.0 - z * z).max(0.0).sqrt();
    glam::DVec3::new(s * turn.cos(), s * turn.sin(), z).as_vec3()
}
