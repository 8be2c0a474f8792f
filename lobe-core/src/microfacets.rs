//! Lobes of microfacets: a pair of lobes of half vectors, and their values at a receiver.

use crate::{Lobe, orthonormal_basis};
use core::f32::consts::FRAC_1_PI;
use glam::Vec3;

/// A lobe of microfacets at a receiver ([`Lobe::microfacets`]), ready to be evaluated in many directions.
///
/// `f̃(v) = flux·D(h)·W(v)·(1 − s)`, or `·s`, with `h` half-way between `v` and the eye's direction `ω_o`,
/// `D = α²/π(1 − (n·h)²(1 − α²))²` (GGX; B. Walter et al., *Microfacet Models for Refraction through Rough Surfaces*, 2007,
/// Eq. 33), `W = G₂/(4 n·ω_o)` with Smith's height-correlated `G₂`, and Schlick's `s = (1 − ω_o·h)⁵`.
///
/// Frame: x away from the normal toward the eye, z the normal.
#[derive(Clone, Copy, Debug)]
pub struct Microfacets {
    normal: Vec3,
    /// The eye's direction; above the horizon.
    view: Vec3,
    alpha_sq: f32,
    /// `√((n·ω_o)²(1 − α²) + α²)`.
    shadowing: f32,
    is_edge: bool,
}

impl Microfacets {
    /// Views lower than this (cosine to the normal) are taken as at it.
    pub const GRAZING: f32 = 5e-3;

    /// Of a lobe for which [`Lobe::is_microfacets`] holds.
    #[must_use]
    pub fn new(normal: Vec3, lobe: &Lobe) -> Self {
        let (cos, sin, forward) = seen_from(normal, lobe.axis);
        let alpha_sq = alpha_sq(lobe.exponent);
        let shadowing = (cos * cos * (1.0 - alpha_sq) + alpha_sq).sqrt();
        Self { normal, view: normal * cos + forward * sin, alpha_sq, shadowing, is_edge: lobe.factor == Lobe::EDGE }
    }

    /// Both numbers `D·W·(1 − s)` and `D·W·s` in a direction `v` of unit length; 0 below the horizon.
    #[inline(always)]
    #[must_use]
    pub fn both(&self, v: Vec3) -> [f32; 2] {
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

    /// The one of them that the lobe is.
    #[inline(always)]
    #[must_use]
    pub fn value(&self, v: Vec3) -> f32 {
        let [base, edge] = self.both(v);
        if self.is_edge { edge } else { base }
    }

    /// The mirrored direction of the eye, and `α`.
    #[must_use]
    pub fn highlight(&self) -> (Vec3, f32) {
        (2.0 * self.normal.dot(self.view) * self.normal - self.view, self.alpha_sq.sqrt())
    }
}

impl Lobe {
    /// Reflection by microfacets of the GGX distribution: the reflectance `F·D(h)·W(v)` of [`Microfacets`] with Schlick's
    /// `F = f0·(1 − s) + f90·s`, as two lobes of which the second follows the first.
    ///
    /// `D(h)·(n·h)` is a cosine lobe of exponent 1 about the normal, its half vectors stretched by `α`: the one shape that takes
    /// a highlight's long tails and its length at grazing views. Fields: `axis` is `ω_o`, the direction to the eye, `exponent`
    /// is `2/α² − 2`, that of a lobe about the half vector with the same peak, `flux` is `f0` or `f90`.
    #[must_use]
    pub fn microfacets(view: Vec3, alpha: f32, [f0, f90]: [Vec3; 2]) -> [Self; 2] {
        let exponent = 2.0 / (alpha * alpha) - 2.0;
        let lobe = |flux, factor| Self { axis: view, exponent, flux, factor };
        [lobe(f0, Self::MICROFACETS), lobe(f90, Self::EDGE)]
    }

    /// Whether `edge` is the other of a pair of [`microfacets`](Self::microfacets) that begins with this one.
    #[inline(always)]
    #[must_use]
    pub fn has_edge(&self, edge: &Self) -> bool {
        let is_pair = self.factor == Self::MICROFACETS && edge.factor == Self::EDGE;
        let reflects = self.flux != Vec3::ZERO && edge.flux != Vec3::ZERO;
        is_pair && reflects && self.exponent == edge.exponent && self.axis == edge.axis
    }

    /// Value in the unit direction `v` at a receiver of this normal, factor included.
    #[must_use]
    pub fn eval_at(&self, normal: Vec3, v: Vec3) -> Vec3 {
        if self.is_microfacets() {
            self.flux * Microfacets::new(normal, self).value(v)
        } else if self.factor > 0.0 {
            self.eval(v) * normal.dot(v).max(0.0)
        } else {
            self.eval(v)
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
