//! A material at one receiver, for eight directions at once.

use crate::ray_shader::LANES;
use brdf::{Brdf, Material};
use core::f32::consts::{FRAC_1_PI, LOG2_E, TAU};
use glam::Vec3;
use lobe_core::Receiver;

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

    /// Adds what the counted ones of eight directions reflect.
    #[inline(always)]
    pub(super) fn add(&self, v: &[[f32; LANES]; 3], counts: &[bool; LANES], sum: &mut Sum) {
        let n = self.at.normal;
        match self.kind {
            Kind::Phong { ks, mirrored, exponent, cosine, .. } => {
                let mut cos = [0.0f32; LANES];
                for l in 0..LANES {
                    let c = (n.x * v[0][l] + n.y * v[1][l] + n.z * v[2][l]).max(0.0);
                    cos[l] = if counts[l] { c } else { 0.0 };
                    sum.diffuse[l] += cos[l];
                }
                if ks != Vec3::ZERO {
                    let power = power(mirrored, exponent, v);
                    for l in 0..LANES {
                        let weight = if cosine { cos[l] } else { f32::from(u8::from(cos[l] > 0.0)) };
                        sum.glossy[l] += weight * power[l];
                    }
                }
            }
            Kind::Other(material) => {
                for l in (0..LANES).filter(|l| counts[*l]) {
                    sum.other += material.eval(self.at, Vec3::new(v[0][l], v[1][l], v[2][l]));
                }
            }
        }
    }

    pub(super) fn total(&self, sum: &Sum) -> Vec3 {
        match self.kind {
            Kind::Phong { kd, ks, .. } => kd * sum.diffuse.iter().sum::<f32>() + ks * sum.glossy.iter().sum::<f32>(),
            Kind::Other(_) => sum.other,
        }
    }
}

/// What [`Reflectance::add`] adds up.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sum {
    diffuse: [f32; LANES],
    glossy: [f32; LANES],
    other: Vec3,
}

/// `max(a·v, 0)^e` of eight directions, to 1e-6 and 3e-7 of the logarithm. Finite exponents.
#[inline(always)]
fn power(a: Vec3, exponent: f32, v: &[[f32; LANES]; 3]) -> [f32; LANES] {
    const MAGIC: f32 = 12_582_912.0;
    let mut out = [0.0; LANES];
    for (l, out) in out.iter_mut().enumerate() {
        let (x, y, z) = (v[0][l] - a.x, v[1][l] - a.y, v[2][l] - a.z);
        let h = 0.5 * (x * x + y * y + z * z);
        // ln(1 − h): the rounding of 1 − h is put back.
        let u = (1.0 - h).max(1e-30);
        let lost = (1.0 - u) - h;
        let bits = u.to_bits().wrapping_sub(0x3f35_04f3);
        let k = (bits as i32 >> 23) as f32;
        let m = f32::from_bits((bits & 0x007f_ffff) + 0x3f35_04f3);
        let s = (m - 1.0) / (m + 1.0);
        let s2 = s * s;
        let atanh = s * (2.0 + s2 * (2.0 / 3.0 + s2 * (0.4 + s2 * (2.0 / 7.0 + s2 * (2.0 / 9.0)))));
        let ln = k * core::f32::consts::LN_2 + atanh + lost / u;
        let e = (exponent * ln * LOG2_E).max(-126.0);
        let whole = (e + MAGIC) - MAGIC;
        let f = (e - whole) * core::f32::consts::LN_2;
        let exp = 1.0 + f * (1.0 + f * (0.5 + f * (1.0 / 6.0 + f * (1.0 / 24.0 + f * (1.0 / 120.0 + f / 720.0)))));
        let two = f32::from_bits(((whole + MAGIC).to_bits() << 23).wrapping_add(0x3f80_0000));
        *out = if h < 1.0 { exp * two } else { 0.0 };
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_powers() {
        let a = Vec3::new(0.6, 0.0, 0.8);
        for exponent in [0.0f32, 0.5, 1.0, 7.0, 80.0, 2000.0, 1e5] {
            for i in 0..2000 {
                let angle = 1.7 * (i as f32 / 2000.0).powi(3);
                let v = a * angle.cos() + Vec3::Y * angle.sin();
                let got = power(a, exponent, &v.to_array().map(|x| [x; LANES]))[0];
                let want = lobe_core::power(a, v, exponent);
                // Rounding of the logarithm, times the exponent.
                let bound = want * (1e-6 + 3e-7 * (-want.max(1e-37).ln()) + 2e-7 * exponent.min(30.0)) + 1e-30;
                assert!((got - want).abs() <= bound, "{exponent} {angle}: {got} {want}");
            }
        }
    }
}
