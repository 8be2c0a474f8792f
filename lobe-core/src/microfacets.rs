//! Microfacets: half of their reflectance as a lobe, and its values at a receiver.

use crate::grain::{BrushedAt, Facets, Grain};
use crate::vec3x8::Vec3x8;
use crate::{Lobe, orthonormal_basis};
use core::f32::consts::FRAC_1_PI;
use fearless_simd::{Simd, f32x8, prelude::*};
use glam::Vec3;

/// The light that microfacets of the GGX distribution reflect: `flux·D(h)·W(v)·(1 − s)`, or `·s`, in a direction `v` with the half
/// vector `h` between it and the view `ω_o`.
///
/// `D = α²/π(1 − (n·h)²(1 − α²))²` (GGX; B. Walter et al., *Microfacet Models for Refraction through Rough Surfaces*, 2007, Eq. 33),
/// `W = G₂/(4 n·ω_o)` with Smith's height-correlated `G₂`, and Schlick's `s = (1 − ω_o·h)⁵`. Both [parts](Schlick) together are the
/// reflectance `F·D(h)·W(v)` with `F = f0·(1 − s) + f90·s`.
///
/// `D(h)·(n·h)` is a cosine lobe of exponent 1 about the normal, its half vectors stretched by `α`: the one shape that takes a
/// highlight's long tails and its length at grazing views.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Microfacets {
    /// The direction to the eye `ω_o`, unit length.
    pub view: Vec3,
    /// `2/α² − 2`, the exponent of a cosine lobe about the half vector with the same peak.
    pub exponent: f32,
    /// `f0` or `f90`.
    pub flux: Vec3,
    /// Which of them.
    pub part: Schlick,
    /// The direction along which they are rougher, if they are.
    pub grain: Option<Grain>,
}

/// The two parts of Schlick's reflectance `F = f0·(1 − s) + f90·s`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Schlick {
    /// `1 − s`: the same at all angles but grazing ones.
    F0,
    /// `s`: grows toward grazing angles.
    F90,
}

impl Microfacets {
    /// Views lower than this (cosine to the normal) are taken as at it.
    pub const GRAZING: f32 = 5e-3;

    /// Both parts for a view, a roughness `α` and the reflectances `f0` and `f90`. In a reflectance the second follows the first.
    #[must_use]
    pub fn new(view: Vec3, alpha: f32, [f0, f90]: [Vec3; 2]) -> [Self; 2] {
        let exponent = 2.0 / (alpha * alpha) - 2.0;
        [(f0, Schlick::F0), (f90, Schlick::F90)].map(|(flux, part)| Self { view, exponent, flux, part, grain: None })
    }

    /// The same, rougher along a direction: `α` is that across it.
    #[must_use]
    pub fn with_grain(self, grain: Option<Grain>) -> Self {
        Self { grain, ..self }
    }

    /// The number `D·W·(1 − s)` or `D·W·s` of its part in a direction of unit length, at a receiver of this normal.
    #[must_use]
    pub fn value(&self, normal: Vec3, v: Vec3) -> f32 {
        self.part.of(match self.grain {
            None => self.at(normal).both(v),
            Some(grain) => BrushedAt::new(self, grain, normal).both(v),
        })
    }

    /// The mirrored direction of the eye, and the largest `α`, at a receiver of this normal.
    #[must_use]
    pub fn highlight(&self, normal: Vec3) -> (Vec3, f32) {
        let (mirror, alpha) = self.at(normal).highlight();
        (mirror, self.grain.map_or(alpha, |grain| grain.alpha(alpha)))
    }

    /// Ready to be evaluated at a receiver of this normal, as if there were no grain ([`BrushedAt`] has it).
    #[must_use]
    pub fn at(&self, normal: Vec3) -> MicrofacetsAt {
        MicrofacetsAt::new(normal, self.view, self.exponent, self.part)
    }

    /// The cosine lobe that stands for it where only these are taken: about the mirrored view, a quarter of the exponent, as directions
    /// turn twice as far as half vectors; and the part of the light that a mirror reflects, exact for `α → 0`.
    ///
    /// # Accuracy
    /// Lights about the mirrored view, as wide as the highlight and three times as wide: within 30 % for `α ≤ 0.1`, 40 % for 0.3, since GGX
    /// has longer tails. A model that knows nearer lobes overrides `BrdfLobes::cosine_lobes`.
    #[must_use]
    pub fn mirror_lobe(&self, normal: Vec3) -> Lobe {
        let at = self.at(normal);
        let fifth = schlick(normal.dot(at.view));
        let part = if self.part == Schlick::F90 { fifth } else { 1.0 - fifth };
        Lobe::with_flux(at.highlight().0, 0.25 * self.exponent, self.flux * part)
    }
}

/// [`Microfacets`] at a receiver, ready to be evaluated in many directions.
#[derive(Clone, Copy, Debug)]
pub struct MicrofacetsAt {
    pub(crate) normal: Vec3,
    /// The eye's direction; above the horizon.
    pub(crate) view: Vec3,
    pub(crate) alpha_sq: f32,
    /// `√((n·ω_o)²(1 − α²) + α²)`.
    pub(crate) shadowing: f32,
    pub(crate) part: Schlick,
}

impl Facets for MicrofacetsAt {
    #[inline(always)]
    fn both(&self, v: Vec3) -> [f32; 2] {
        let h = self.view + v;
        let (along, across, square) = (self.normal.dot(h), self.normal.cross(h).length_squared(), h.length_squared());
        // α²(n·h)² + |n×h|² has no cancellation.
        let spread = self.alpha_sq * along * along + across;
        let spread = if spread > 1e-30 { spread } else { 1e-30 };
        let d = self.alpha_sq * FRAC_1_PI * (square / spread) * (square / spread);
        let vh = 0.5 * square.sqrt();
        let fifth = schlick(vh);
        let value = d * masking(self.normal.dot(v), self.normal.dot(self.view), self.alpha_sq, self.shadowing);
        [value * (1.0 - fifth), value * fifth]
    }

    #[inline(always)]
    fn both_of_eight<S: Simd>(&self, simd: S, v: Vec3x8<S>) -> [f32x8<S>; 2] {
        let [zero, one] = [0.0, 1.0].map(|x| f32x8::splat(simd, x));
        let h = v.plus(self.view);
        let (along, across) = (h.dot_one(self.normal), h.cross(Vec3x8::splat(simd, self.normal)).length_squared());
        let square = h.length_squared();
        let spread = (along * self.alpha_sq * along + across).max(f32x8::splat(simd, 1e-30));
        let d = (square / spread) * (self.alpha_sq * FRAC_1_PI) * (square / spread);
        let x = (one - square.sqrt() * 0.5).max(zero);
        let fifth = x * x * x * x * x;
        let (light, view) = (v.dot_one(self.normal).max(zero), self.normal.dot(self.view));
        let shadowed = (light * light * (1.0 - self.alpha_sq) + self.alpha_sq).sqrt();
        let masking = light * 0.5 / (light * self.shadowing + shadowed * view);
        let value = d * masking;
        [value * (one - fifth), value * fifth]
    }
}

impl MicrofacetsAt {
    /// Seen from a direction to the eye, of this exponent.
    #[inline(always)]
    pub(crate) fn new(normal: Vec3, view: Vec3, exponent: f32, part: Schlick) -> Self {
        let (cos, sin, forward) = seen_from(normal, view);
        let alpha_sq = alpha_sq(exponent);
        let shadowing = (cos * cos * (1.0 - alpha_sq) + alpha_sq).sqrt();
        Self { normal, view: normal * cos + forward * sin, alpha_sq, shadowing, part }
    }

    /// The one of them that belongs to the part.
    #[inline(always)]
    #[must_use]
    pub fn value(&self, v: Vec3) -> f32 {
        self.part.of(self.both(v))
    }

    /// The mirrored direction of the eye, and `α`.
    #[must_use]
    pub fn highlight(&self) -> (Vec3, f32) {
        (2.0 * self.normal.dot(self.view) * self.normal - self.view, self.alpha_sq.sqrt())
    }
}

impl Schlick {
    /// This part's one of both.
    #[inline(always)]
    #[must_use]
    pub const fn of(self, [f0, f90]: [f32; 2]) -> f32 {
        match self {
            Self::F0 => f0,
            Self::F90 => f90,
        }
    }
}

/// `(1 − ω_o·h)⁵`.
#[inline(always)]
pub(crate) fn schlick(vh: f32) -> f32 {
    let x = 1.0 - vh;
    let x = if x > 0.0 { x } else { 0.0 };
    x * x * x * x * x
}

/// `W = G₂/(4 n·ω_o) = ½ n·v/(n·v √((n·ω_o)²(1−α²)+α²) + n·ω_o √((n·v)²(1−α²)+α²))`; 0 below the horizon.
#[inline(always)]
pub(crate) fn masking(light: f32, view: f32, alpha_sq: f32, shadowing: f32) -> f32 {
    let light = if light > 0.0 { light } else { 0.0 };
    0.5 * light / (light * shadowing + view * (light * light * (1.0 - alpha_sq) + alpha_sq).sqrt())
}

/// `α²` of a lobe whose distribution falls like a cosine to this power: `2/(e+2)`.
#[inline(always)]
pub(crate) fn alpha_sq(exponent: f32) -> f32 {
    2.0 / (exponent + 2.0)
}

/// Cosine and sine of the eye's direction to the normal, and the tangent toward it; views below the horizon are at it.
#[inline(always)]
pub(crate) fn seen_from(normal: Vec3, view: Vec3) -> (f32, f32, Vec3) {
    let cos = normal.dot(view);
    let cos = if cos > Microfacets::GRAZING { cos } else { Microfacets::GRAZING };
    let cos = if cos < 1.0 { cos } else { 1.0 };
    let aside = view - normal * normal.dot(view);
    let length = aside.length();
    let forward = aside / if length > 1e-6 { length } else { 1.0 };
    let forward = if length > 1e-6 { forward } else { orthonormal_basis(normal).0 };
    // Without the cancellation of 1 − cos² toward the normal.
    let sin = if length < 1.0 { length } else { 1.0 };
    let sin = if normal.dot(view) > Microfacets::GRAZING {
        sin
    } else {
        (1.0 - Microfacets::GRAZING * Microfacets::GRAZING).sqrt()
    };
    (cos, sin, forward)
}

#[cfg(test)]
mod tests {
    use super::Microfacets;
    use crate::Facets;
    use crate::oracle::{CapMicrofacets, Random};
    use crate::vec3x8::Vec3x8;
    use crate::{Cone, Receiver, cap_integral};
    use fearless_simd::{Level, dispatch};
    use glam::{DVec3, Vec3};

    #[test]
    fn eight_directions_are_one_by_one() {
        let mut random = Random::new(21);
        for _ in 0..2000 {
            let [normal, view, v] = [(); 3].map(|()| random.axis().as_vec3());
            let facets = Microfacets::new(view, random.log_uniform(1e-3, 1.0) as f32, [Vec3::ONE; 2])[0].at(normal);
            let got: [[f32; 8]; 2] = dispatch!(Level::new(), simd => {
                facets.both_of_eight(simd, Vec3x8::splat(simd, v)).map(Into::into)
            });
            assert_eq!(got.map(|lanes| lanes[3].to_bits()), facets.both(v).map(f32::to_bits), "{facets:?} {v}");
        }
    }

    /// Lights about the mirrored view, as wide as the highlight and three times as wide: relative to both parts' light.
    #[test]
    fn mirror_lobes_are_near_smooth_surfaces() {
        for (alpha, limit) in [(0.02, 0.3), (0.1, 0.3), (0.3, 0.4)] {
            for tilt in [0.0_f64, 0.5, 1.0] {
                for widths in [1.0, 3.0] {
                    let view = DVec3::new(tilt.sin(), 0.0, tilt.cos());
                    let axis = DVec3::new(-view.x, 0.0, view.z);
                    let half_angle: f64 = 2.0 * alpha * widths / if alpha > 0.2 { 3.0 } else { 1.0 };
                    let want = CapMicrofacets { view, alpha }.over_cap(axis, half_angle, 200);
                    let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, view.as_vec3());
                    let one_minus_cos = (2.0 * (0.5 * half_angle).sin().powi(2)) as f32;
                    let cone = Cone { axis: axis.as_vec3(), one_minus_cos, distance: 1.0 };
                    let lobes = Microfacets::new(view.as_vec3(), alpha as f32, [Vec3::ONE; 2]);
                    let got = lobes.map(|facets| {
                        let lobe = facets.mirror_lobe(Vec3::Z);
                        f64::from(lobe.flux.x * cap_integral(&at, lobe, &cone))
                    });
                    let error = ((got[0] - want[0]).abs() + (got[1] - want[1]).abs()) / (want[0] + want[1]);
                    println!("α {alpha}, {tilt}, {widths} widths: {got:.3?} for {want:.3?}, {error:.3}");
                    assert!(error < limit, "α {alpha}, {tilt}, {widths}: {got:?} for {want:?}");
                }
            }
        }
    }
}
