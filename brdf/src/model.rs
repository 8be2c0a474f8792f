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
///
/// ```
/// use brdf::{Brdf, Lambert};
/// use glam::Vec3;
/// use lobe_core::{Receiver};
/// let paper = Lambert { albedo: Vec3::splat(0.8) };
/// let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::Z);
/// let drawn = paper.sample(&at, [0.1, 0.2, 0.3]).unwrap();
/// let weight = paper.eval(&at, drawn.direction) / drawn.pdf; // the albedo, for perfect importance sampling
/// assert!((weight.x - 0.8).abs() < 1e-5);
/// ```
pub trait Brdf: BrdfLobes {
    /// `f̃(v) = f_r(v, ω_o)·(n·v)` of Eq. 2, in sr⁻¹; zero where `n·v ≤ 0`.
    fn eval(&self, at: &Receiver, v: Vec3) -> Vec3;

    /// Draws a direction from three uniform numbers in [0, 1); `None` where the drawn direction is below the horizon or
    /// the material reflects nothing.
    fn sample(&self, at: &Receiver, u: [f32; 3]) -> Option<BrdfSample>;

    /// Density with which [`sample`](Self::sample) draws `v`.
    fn pdf(&self, at: &Receiver, v: Vec3) -> f32;
}
