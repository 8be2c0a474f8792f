//! A material at one receiver, for eight directions at once.

use brdf::{Brdf, Material};
use core::f32::consts::{FRAC_1_PI, LN_2, LOG2_E, TAU};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, i32x8, mask32x8, u32x8};
use glam::Vec3;
use lobe_core::Receiver;
use lobe_core::vec3x8::{LANES, Vec3x8};

/// `f̃` of a material at a receiver, summed over directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reflectance<'m> {
    at: &'m Receiver,
    kind: Kind<'m>,
}

#[derive(Clone, Copy, Debug)]
enum Kind<'m> {
    /// `kd·max(n·v, 0) + ks·max(r·v, 0)^e`, the latter times `max(n·v, 0)` or not.
    Phong { kd: Vec3, ks: Vec3, mirrored: Vec3, exponent: f32, cosine: bool },
    /// Direction by direction.
    Other(&'m Material),
}

impl<'m> Reflectance<'m> {
    #[inline(always)]
    pub(super) fn new(material: &'m Material, at: &'m Receiver) -> Self {
        let mirrored = 2.0 * at.normal.dot(at.view) * at.normal - at.view;
        let kind = match material {
            Material::Lambert(m) => {
                Kind::Phong { kd: m.albedo * FRAC_1_PI, ks: Vec3::ZERO, mirrored, exponent: 0.0, cosine: false }
            }
            Material::Phong(m) => Kind::Phong { kd: m.kd, ks: m.ks, mirrored, exponent: m.exponent, cosine: false },
            Material::ModifiedPhong(m) => {
                let ks = m.ks * ((m.exponent + 2.0) / TAU);
                Kind::Phong { kd: m.kd * FRAC_1_PI, ks, mirrored, exponent: m.exponent, cosine: true }
            }
            _ => Kind::Other(material),
        };
        Self { at, kind }
    }

    /// Adds the reflection of those of eight directions whose bits are set.
    #[inline(always)]
    pub(super) fn add<S: Simd>(&self, v: Vec3x8<S>, counted: u64, sum: &mut Sum<S>) {
        match self.kind {
            Kind::Phong { ks, mirrored, exponent, cosine, .. } => {
                let simd = v.x.token();
                let (none, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
                let cos = v.dot_one(self.at.normal);
                let counted = mask32x8::from_bitmask(simd, counted) & cos.simd_gt(0.0);
                sum.diffuse += counted.select(cos, none);
                if ks != Vec3::ZERO {
                    let weight = counted.select(if cosine { cos } else { one }, none);
                    sum.glossy += weight * power(mirrored, exponent, v);
                }
            }
            Kind::Other(material) => {
                for l in (0..LANES).filter(|l| counted >> l & 1 != 0) {
                    sum.other += material.eval(self.at, v.get(l));
                }
            }
        }
    }

    #[inline(always)]
    pub(super) fn total<S: Simd>(&self, sum: &Sum<S>) -> Vec3 {
        match self.kind {
            Kind::Phong { kd, ks, .. } => kd * sum.diffuse.reduce_sum() + ks * sum.glossy.reduce_sum(),
            Kind::Other(_) => sum.other,
        }
    }
}

/// The sums of [`Reflectance::add`].
#[derive(Clone, Copy)]
pub(super) struct Sum<S: Simd> {
    diffuse: f32x8<S>,
    glossy: f32x8<S>,
    other: Vec3,
}

impl<S: Simd> Sum<S> {
    #[inline(always)]
    pub(super) fn new(simd: S) -> Self {
        Self { diffuse: f32x8::splat(simd, 0.0), glossy: f32x8::splat(simd, 0.0), other: Vec3::ZERO }
    }
}

/// `max(a·v, 0)^e` of eight directions, to 1e-6 and 3e-7 of the logarithm. Finite exponents.
#[inline(always)]
fn power<S: Simd>(a: Vec3, exponent: f32, v: Vec3x8<S>) -> f32x8<S> {
    /// Adding it leaves a whole number in the low bits.
    const MAGIC: f32 = 12_582_912.0;
    /// Bits of √½, where the mantissa's range begins.
    const ROOT: u32 = 0x3f35_04f3;
    let simd = v.x.token();
    let h = v.minus(a).length_squared() * 0.5;
    // ln(1 − h): the rounding of 1 − h is put back.
    let u = (1.0 - h).max(1e-30);
    let lost = (1.0 - u) - h;
    let bits = u.to_bits() - u32x8::splat(simd, ROOT);
    let k: f32x8<S> = (bits.bitcast::<i32x8<S>>() >> 23).to_float();
    let m = f32x8::from_bits((bits & u32x8::splat(simd, 0x007f_ffff)) + u32x8::splat(simd, ROOT));
    let s = (m - 1.0) / (m + 1.0);
    let s2 = s * s;
    let atanh = s * (2.0 + s2 * (2.0 / 3.0 + s2 * (0.4 + s2 * (2.0 / 7.0 + s2 * (2.0 / 9.0)))));
    let ln = k * LN_2 + atanh + lost / u;
    let e = (ln * (exponent * LOG2_E)).max(-126.0);
    let whole = (e + MAGIC) - MAGIC;
    let f = (e - whole) * LN_2;
    let exp = 1.0 + f * (1.0 + f * (0.5 + f * (1.0 / 6.0 + f * (1.0 / 24.0 + f * (1.0 / 120.0 + f * (1.0 / 720.0))))));
    let two = f32x8::from_bits(((whole + MAGIC).to_bits() << 23) + u32x8::splat(simd, 0x3f80_0000));
    h.simd_lt(1.0).select(exp * two, f32x8::splat(simd, 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn powers_are_powers() {
        let a = Vec3::new(0.6, 0.0, 0.8);
        for exponent in [0.0f32, 0.5, 1.0, 7.0, 80.0, 2000.0, 1e5] {
            for i in 0..2000 {
                let angle = 1.7 * (i as f32 / 2000.0).powi(3);
                let v = a * angle.cos() + Vec3::Y * angle.sin();
                let got = dispatch!(Level::new(), simd => power(a, exponent, Vec3x8::splat(simd, v))[3]);
                let want = lobe_core::power(a, v, exponent);
                // Rounding of the logarithm, times the exponent.
                let bound = want * (1e-6 + 3e-7 * (-want.max(1e-37).ln()) + 2e-7 * exponent.min(30.0)) + 1e-30;
                assert!((got - want).abs() <= bound, "{exponent} {angle}: {got} {want}");
            }
        }
    }
}
