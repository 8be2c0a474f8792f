//! The integrals of lobes of microfacets over all directions above the horizon: their directional albedo.

use super::pair::Pair;
use crate::microfacets::{alpha_sq, schlick, seen_from};

/// Cosine and sine of the turns of half vectors about the stretched normal: the midpoint rule in a half turn, of which the other half is
/// the mirror image.
pub(super) const TURNS: [(f32, f32); 8] = [
    (0.980_785_3, 0.195_090_32),
    (0.831_469_6, 0.555_570_23),
    (0.555_570_23, 0.831_469_6),
    (0.195_090_32, 0.980_785_3),
    (-0.195_090_32, 0.980_785_3),
    (-0.555_570_23, 0.831_469_6),
    (-0.831_469_6, 0.555_570_23),
    (-0.980_785_3, 0.195_090_32),
];

/// The same all around, for what is no mirror image.
pub(super) fn all_turns() -> impl Iterator<Item = (f32, f32)> {
    TURNS.into_iter().chain(TURNS.map(|(cos, sin)| (cos, -sin)))
}

/// Places and weights of the Gauss–Legendre rule on [0, 1].
pub(super) const PLACES: [(f32, f32); 8] = [
    (0.019_855_072, 0.050_614_268),
    (0.101_666_76, 0.111_190_52),
    (0.237_233_79, 0.156_853_32),
    (0.408_282_68, 0.181_341_89),
    (0.591_717_3, 0.181_341_89),
    (0.762_766_2, 0.156_853_32),
    (0.898_333_24, 0.111_190_52),
    (0.980_144_9, 0.050_614_268),
];

/// Halvings of the range in which the horizon is.
pub(super) const HALVINGS: usize = 10;

/// Microfacets seen from one direction. Five numbers, so that many of them lie in columns.
///
/// Slopes over `α` make the microfacets those of a sphere, seen from `e = (α ω_x, 0, ω_z)/|·|`. The facets that the eye sees have the
/// half vectors of `e` and of directions `w` that are uniform in the cap `w_z > −e_z` (J. Dupuy, A. Benyoub, *Sampling Visible GGX
/// Normals with Spherical Caps*, 2023, section 3), so that the albedo is the mean over `w` of `G₂/G₁` times a part of Schlick's.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Facets {
    alpha_sq: f32,
    /// The eye's sine and cosine to the normal.
    sin: f32,
    cos: f32,
    /// `e`.
    across: f32,
    up: f32,
}

/// A half vector of any length, in its parts along the eye's direction on the surface, aside of it and up.
struct Half {
    square: f32,
    up: f32,
    /// Its product with the eye's direction.
    seen: f32,
}

impl Facets {
    #[inline(always)]
    pub(super) fn new(pair: &Pair) -> Self {
        let (cos, sin, _) = seen_from(pair.normal, pair.axis);
        let alpha_sq = alpha_sq(pair.exponent);
        let length = 1.0 / (alpha_sq * sin * sin + cos * cos).sqrt();
        Self { alpha_sq, sin, cos, across: alpha_sq.sqrt() * sin * length, up: cos * length }
    }

    #[inline(always)]
    fn half(&self, z: f32, (cos, sin): (f32, f32)) -> Half {
        let rest = (1.0 - z) * (1.0 + z);
        let flat = if rest > 0.0 { rest } else { 0.0 }.sqrt();
        let alpha = self.alpha_sq.sqrt();
        let (x, y, up) = (alpha * (flat * cos + self.across), alpha * flat * sin, z + self.up);
        Half { square: x * x + y * y + up * up, up, seen: self.sin * x + self.cos * up }
    }

    /// The whole cap of a turn: its lowest and highest `w_z`.
    #[inline(always)]
    pub(super) const fn cap(&self) -> [f32; 2] {
        [-self.up, 1.0]
    }

    /// The half of a range in which reflected light passes the horizon: above it `2(ω_o·h)(n·h) > (ω_o·n)|h|²`.
    #[inline(always)]
    pub(super) fn halve(&self, [low, high]: [f32; 2], turn: (f32, f32)) -> [f32; 2] {
        let middle = 0.5 * (low + high);
        let half = self.half(middle, turn);
        let is_above = 2.0 * half.seen * half.up > self.cos * half.square;
        [if is_above { low } else { middle }, if is_above { middle } else { high }]
    }

    /// Both parts at one place between the horizon and the top of the cap, times its weight in the mean.
    #[inline(always)]
    pub(super) fn node(&self, [low, high]: [f32; 2], turn: (f32, f32), (place, weight): (f32, f32)) -> [f32; 2] {
        let range = 1.0 - 0.5 * (low + high);
        let half = self.half(1.0 - range * place, turn);
        let inverse = 1.0 / if half.square > 1e-30 { half.square } else { 1e-30 };
        let light = 2.0 * half.seen * half.up * inverse - self.cos;
        let light = if light > 0.0 { light } else { 0.0 };
        let smith = |cos: f32| (cos * cos * (1.0 - self.alpha_sq) + self.alpha_sq).sqrt();
        let (of_view, of_light) = (smith(self.cos), smith(light));
        // G₂/G₁ of Smith's functions, the first height-correlated.
        let masking = light * (self.cos + of_view) / (light * of_view + self.cos * of_light);
        let fifth = schlick(half.seen * inverse.sqrt());
        let value = masking * weight * range / (1.0 + self.up) * (1.0 / TURNS.len() as f32);
        [value * (1.0 - fifth), value * fifth]
    }
}

#[cfg(test)]
mod tests {
    use crate::oracle::{CapMicrofacets, Random};
    use crate::{Cone, Microfacets, Receiver, cap_integral};
    use glam::{DVec3, Vec3};

    /// The promise of `cap_integral`: mean and largest error of both parts, relative to the whole albedo.
    const PROMISED: [f64; 2] = [0.002, 0.01];

    fn albedo(cos: f32, alpha: f32) -> [f32; 2] {
        let view = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
        let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, view);
        let everywhere = Cone { axis: Vec3::X, one_minus_cos: 2.0, distance: 1.0 };
        Microfacets::new(view, alpha, [Vec3::ONE; 2]).map(|facets| cap_integral(&at, facets, &everywhere))
    }

    #[test]
    fn albedos_are_those_of_quadrature() {
        let (mut sum, mut worst, mut count) = (0.0, 0.0_f64, 0.0);
        for roughness in [0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0_f64] {
            for cos in [0.005, 0.01, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 0.7, 0.9, 0.99, 1.0_f64] {
                let alpha = roughness * roughness;
                let view = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
                let want = CapMicrofacets { view, alpha }.albedo();
                let got = albedo(cos as f32, alpha as f32).map(f64::from);
                let error = ((got[0] + got[1]) - (want[0] + want[1])).abs().max((got[1] - want[1]).abs());
                let error = error / (want[0] + want[1]);
                assert!(error < PROMISED[1], "roughness {roughness}, cosine {cos}: {got:?}, {want:?}");
                sum += error;
                worst = worst.max(error);
                count += 1.0;
            }
        }
        println!("directional albedo: mean {:.1e}, worst {worst:.1e}", sum / count);
        assert!(sum / count < PROMISED[0]);
    }

    #[test]
    fn albedos_are_total_and_conserve_energy() {
        let mut random = Random::new(31);
        for _ in 0..100_000 {
            let (cos, alpha) = (random.log_uniform(1e-9, 1.0) as f32, random.log_uniform(1e-6, 1.0) as f32);
            let [f0, f90] = albedo(cos, alpha);
            assert!(f0 >= 0.0 && f90 >= 0.0 && f0 + f90 < 1.002, "{cos} {alpha}: {f0} {f90}");
        }
    }
}
