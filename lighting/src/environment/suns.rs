//! Small and bright spots in a picture of all directions.

use super::EnvironmentMap;
use crate::SunLight;
use glam::{UVec2, Vec3};
use lobe_core::Sphere;

/// At most so many.
const MOST: usize = 16;
/// Half-angle beyond which a light is a part of the sky, as 1 − cos: 6°.
const WIDEST: f32 = 0.005_478;
/// A sun gives at least this part of all light.
const LEAST: f32 = 0.004;
/// It is so many times as bright as what is beside it, and ends where it is this part of its brightest.
const BRIGHTER: f32 = 8.0;
const RIM: f32 = 0.1;
/// Only what is so many times as bright as the mean can be one of so small a width.
const BRIGHT: f32 = 1.4;
/// Bright places that are looked at.
const TRIES: usize = 64;

/// The map without its suns, and these: the brightest first.
pub(super) fn cut(map: &EnvironmentMap, world: Sphere) -> (EnvironmentMap, Vec<SunLight>) {
    let mut rest = map.clone();
    let UVec2 { x: width, y: height } = map.size();
    // No sun is narrower than a texel.
    let texel = 0.5 * map.solid_angle(height / 2) / core::f32::consts::PI;
    if texel > WIDEST {
        return (rest, Vec::new());
    }
    let row = |y: u32| (0..width).map(|x| f64::from(map.texel(x, y).element_sum())).sum::<f64>();
    let all = (0..height).map(|y| row(y) * f64::from(map.solid_angle(y))).sum::<f64>() as f32;
    let bright = |i: &u32| map.texel(i % width, i / width).element_sum();
    let mean = all / (2.0 * core::f32::consts::TAU);
    let mut order: Vec<u32> = (0..width * height).filter(|i| bright(i) > BRIGHT * mean).collect();
    order.sort_by(|a, b| bright(b).total_cmp(&bright(a)));
    let mut is_seen = vec![false; map.texels().len()];
    let (mut suns, mut tries) = (Vec::new(), 0);
    for start in order {
        if suns.len() == MOST || tries == TRIES {
            break;
        }
        if is_seen[start as usize] {
            continue;
        }
        tries += 1;
        let spot = Spot::grow(map, start, &mut is_seen);
        if spot.is_large || spot.excess.element_sum() < LEAST * all || spot.one_minus_cos() > WIDEST || !spot.is_bright
        {
            continue;
        }
        let one_minus_cos = spot.one_minus_cos().max(texel);
        let sin = (one_minus_cos * (2.0 - one_minus_cos)).sqrt();
        let radiance = spot.excess / (core::f32::consts::TAU * one_minus_cos);
        suns.push(SunLight { toward: spot.mean.normalize_or(Vec3::Y), sin, radiance, world });
        for i in &spot.texels {
            rest.set_texel(i % width, i / width, spot.beside.min(map.texel(i % width, i / width)));
        }
    }
    (rest, suns)
}

/// Connected bright texels.
struct Spot {
    texels: Vec<u32>,
    /// Radiance just outside.
    beside: Vec3,
    /// `∫ (L − L₀) dω` by channel, and its mean direction times its sum.
    excess: Vec3,
    mean: Vec3,
    is_bright: bool,
    /// Whether it is too large for a sun.
    is_large: bool,
}

impl Spot {
    fn grow(map: &EnvironmentMap, start: u32, is_seen: &mut [bool]) -> Self {
        let UVec2 { x: width, y: height } = map.size();
        let bright = |i: u32| map.texel(i % width, i / width).element_sum();
        let rim = RIM * bright(start);
        let (mut texels, mut solid) = (vec![start], 0.0);
        is_seen[start as usize] = true;
        let (mut beside, mut count, mut next) = (Vec3::ZERO, 0.0, 0);
        // All of one that is too large is marked, so that no part of it is taken for another.
        while next < texels.len() {
            let (x, y) = (texels[next] % width, texels[next] / width);
            next += 1;
            solid += map.solid_angle(y);
            let rows = [y.saturating_sub(1), y, y, (y + 1).min(height - 1)];
            let columns = [x, (x + 1) % width, (x + width - 1) % width, x];
            for (x, y) in columns.into_iter().zip(rows) {
                let i = y * width + x;
                if bright(i) < rim {
                    beside += map.texel(x, y);
                    count += 1.0;
                } else if !core::mem::replace(&mut is_seen[i as usize], true) {
                    texels.push(i);
                }
            }
        }
        let is_large = solid > 4.0 * core::f32::consts::TAU * WIDEST;
        let beside = if count > 0.0 { beside / count } else { Vec3::ZERO };
        let (mut excess, mut mean) = (Vec3::ZERO, Vec3::ZERO);
        for i in &texels {
            let (x, y) = (i % width, i / width);
            let over = (map.texel(x, y) - beside).max(Vec3::ZERO) * map.solid_angle(y);
            excess += over;
            mean += map.direction(x as f32 + 0.5, y as f32 + 0.5) * over.element_sum();
        }
        let is_bright = bright(start) > BRIGHTER * beside.element_sum();
        Self { texels, beside, excess, mean, is_bright, is_large }
    }

    /// Of a cap with its mean direction: `|m| = (1 + cos θ)/2`.
    fn one_minus_cos(&self) -> f32 {
        2.0 * (1.0 - self.mean.length() / self.excess.element_sum().max(f32::MIN_POSITIVE)).max(0.0)
    }
}
