use crate::special::{exp, ln_1p};
use glam::Vec3;

/// One cosine lobe `c(v) = s·max(a·v, 0)^e` (Eq. 4), optionally times the receiver's cosine.
///
/// Stored by its *flux* `∫ c(v) dv = 2π s/(e+1)` (steradians times the unit of `s`) and not by its scale `s`, so that
/// `e = ∞` with finite flux, a point light, is a value like any other.
///
/// With [`has_cosine`](Self::has_cosine) the function is `s·max(a·v, 0)^e·max(n·v, 0)` with the normal `n` of the [`Receiver`] at which
/// the lobe is used: the form that the modified Phong and Lafortune models need. `flux` is that of the lobe without the cosine.
///
/// [`Receiver`]: crate::Receiver
///
/// ```
/// use glam::Vec3;
/// let lambert = lobe_core::Lobe::new(Vec3::Z, 1.0, Vec3::splat(0.5));
/// assert!((lambert.flux.x - 0.5 * core::f32::consts::PI).abs() < 1e-6);
/// assert!((lambert.eval(Vec3::new(0.6, 0.0, 0.8)).x - 0.4).abs() < 1e-6);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lobe {
    /// Axis `a`, unit length.
    pub axis: Vec3,
    /// Exponent `e ≥ 0`; infinity is a delta function.
    pub exponent: f32,
    /// Integral over the sphere, per colour channel: `2π s/(e+1)`.
    pub flux: Vec3,
    /// Whether the receiver's cosine `max(n·v, 0)` multiplies the power.
    pub has_cosine: bool,
}

impl Lobe {
    /// The lobe `scale·max(axis·v, 0)^exponent` (Eq. 4), for a finite exponent.
    #[must_use]
    pub fn new(axis: Vec3, exponent: f32, scale: Vec3) -> Self {
        Self::with_flux(axis, exponent, scale * (core::f32::consts::TAU / (exponent + 1.0)))
    }

    /// The lobe of the given exponent (∞ allowed) that integrates to `flux`.
    #[must_use]
    pub const fn with_flux(axis: Vec3, exponent: f32, flux: Vec3) -> Self {
        Self { axis, exponent, flux, has_cosine: false }
    }

    /// The same lobe times the receiver's cosine `max(n·v, 0)`.
    #[must_use]
    pub const fn times_cosine(self) -> Self {
        Self { has_cosine: true, ..self }
    }

    /// Scale `s = flux·(e+1)/2π`: the lobe's value along its axis. Infinite for an infinite exponent.
    #[must_use]
    pub fn scale(&self) -> Vec3 {
        self.flux * ((self.exponent + 1.0) * core::f32::consts::FRAC_1_PI * 0.5)
    }

    /// Value `s·max(a·v, 0)^e` in the unit direction `v`, without the receiver's cosine: see [`eval_at`](Self::eval_at).
    ///
    /// Zero where the power underflows, also for `e = ∞`; on the axis that is infinite.
    ///
    /// Uses `e·ln(1 − |a−v|²/2)`: near the axis `a·v` itself has lost the digits that a large exponent needs (1 % of a
    /// lobe at e = 1e5).
    #[must_use]
    pub fn eval(&self, v: Vec3) -> Vec3 {
        let power = power(self.axis, v, self.exponent);
        // Beside the axis of an infinite exponent the scale is infinite and the power 0.
        if power > 0.0 { self.scale() * power } else { Vec3::ZERO }
    }

    /// Value in the unit direction `v` at a receiver of this normal, the receiver's cosine included.
    #[must_use]
    pub fn eval_at(&self, normal: Vec3, v: Vec3) -> Vec3 {
        if self.has_cosine { self.eval(v) * normal.dot(v).max(0.0) } else { self.eval(v) }
    }
}

/// `max(a·v, 0)^e` for unit vectors without the cancellation of `a·v` near 1.
///
/// Relative error ≤ 2e-5·(1 + |ln of the result|) for exponents up to 1e5; 1 for `e = 0` wherever `a·v > 0`.
#[must_use]
pub fn power(a: Vec3, v: Vec3, exponent: f32) -> f32 {
    let half_chord_sq = 0.5 * (a - v).length_squared();
    if half_chord_sq >= 1.0 {
        return 0.0;
    }
    // An infinite exponent is 1 on the axis and 0 beside it.
    exp(exponent.min(f32::MAX) * ln_1p(-half_chord_sq))
}
