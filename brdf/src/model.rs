use glam::Vec3;
use lobe_core::{BrdfLobes, Receiver};

/// A direction drawn in proportion to a reflectance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrdfSample {
    /// Unit direction, above the receiver's horizon.
    pub direction: Vec3,
    /// Probability density per steradian.
    pub pdf: f32,
}

/// A reflectance model: one definition that gives lobes to the integrators and `eval`, `sample`, `pdf` to the
/// Monte-Carlo reference.
pub trait Brdf: BrdfLobes {
    /// `f̃(v) = f_r(v, ω_o)·(n·v)` of Eq. 2, in sr⁻¹; zero where `n·v ≤ 0`.
    fn eval(&self, at: &Receiver, v: Vec3) -> Vec3;

    /// Draws a direction from three uniform numbers in [0, 1); `None` where the drawn direction is below the horizon or
    /// the material reflects nothing.
    fn sample(&self, at: &Receiver, u: [f32; 3]) -> Option<BrdfSample>;

    /// Density with which [`sample`](Self::sample) draws `v`.
    fn pdf(&self, at: &Receiver, v: Vec3) -> f32;
}
