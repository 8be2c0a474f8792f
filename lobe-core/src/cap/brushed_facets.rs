//! The directional albedo of microfacets with a grain, as [`albedo`](super::albedo) without the symmetry.

use super::albedo::TURNS;
use super::pair::Pair;
use crate::PackedLobe;
use crate::grain::Grain;
use crate::microfacets::{alpha_sq, schlick, seen_from};

/// Microfacets with a grain seen from one direction. Eight numbers, so that many of them lie in columns.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct BrushedFacets {
    /// `α` along and across the grain.
    alphas: [f32; 2],
    /// The eye along and across the grain and up.
    view: [f32; 3],
    /// The same where the microfacets are those of a sphere.
    stretched: [f32; 3],
}

/// A half vector of any length: its square, its height, and its product with the eye's direction; and its parts along the surface.
struct Half {
    square: f32,
    up: f32,
    seen: f32,
    flat: [f32; 2],
}

impl BrushedFacets {
    #[inline(always)]
    pub(super) fn new(pair: &Pair) -> Self {
        let (cos, sin, _) = seen_from(pair.normal, pair.axis);
        let grain = PackedLobe::grain(pair.cosine).unwrap_or(Grain::NONE);
        let (turn, fine) = (grain.turn(), alpha_sq(pair.exponent).sqrt());
        let alphas = [grain.alpha(fine), fine];
        let view = [sin * turn.x, -sin * turn.y, cos];
        let [x, y] = [alphas[0] * view[0], alphas[1] * view[1]];
        let length = 1.0 / (x * x + y * y + cos * cos).sqrt();
        Self { alphas, view, stretched: [x * length, y * length, cos * length] }
    }

    #[inline(always)]
    fn half(&self, z: f32, (cos, sin): (f32, f32)) -> Half {
        let rest = (1.0 - z) * (1.0 + z);
        let flat = if rest > 0.0 { rest } else { 0.0 }.sqrt();
        let x = self.alphas[0] * (flat * cos + self.stretched[0]);
        let y = self.alphas[1] * (flat * sin + self.stretched[1]);
        let up = z + self.stretched[2];
        let seen = self.view[0] * x + self.view[1] * y + self.view[2] * up;
        Half { square: x * x + y * y + up * up, up, seen, flat: [x, y] }
    }

    /// The whole cap of a turn: its lowest and highest `w_z`.
    #[inline(always)]
    pub(super) const fn cap(&self) -> [f32; 2] {
        [-self.stretched[2], 1.0]
    }

    /// The half of a range in which reflected light passes the horizon.
    #[inline(always)]
    pub(super) fn halve(&self, [low, high]: [f32; 2], turn: (f32, f32)) -> [f32; 2] {
        let middle = 0.5 * (low + high);
        let half = self.half(middle, turn);
        let is_above = 2.0 * half.seen * half.up > self.view[2] * half.square;
        [if is_above { low } else { middle }, if is_above { middle } else { high }]
    }

    /// Both parts at one place between the horizon and the top of the cap, times its weight in the mean.
    #[inline(always)]
    pub(super) fn node(&self, [low, high]: [f32; 2], turn: (f32, f32), (place, weight): (f32, f32)) -> [f32; 2] {
        let range = 1.0 - 0.5 * (low + high);
        let half = self.half(1.0 - range * place, turn);
        let inverse = 1.0 / if half.square > 1e-30 { half.square } else { 1e-30 };
        let twice = 2.0 * half.seen * inverse;
        let light = twice * half.up - self.view[2];
        let light = if light > 0.0 { light } else { 0.0 };
        let aside = [twice * half.flat[0] - self.view[0], twice * half.flat[1] - self.view[1]];
        let smith = |[x, y]: [f32; 2], z: f32| {
            let (x, y) = (self.alphas[0] * x, self.alphas[1] * y);
            (x * x + y * y + z * z).sqrt()
        };
        let (of_view, of_light) = (smith([self.view[0], self.view[1]], self.view[2]), smith(aside, light));
        // G₂/G₁ of Smith's functions, the first height-correlated.
        let masking = light * (self.view[2] + of_view) / (light * of_view + self.view[2] * of_light);
        let fifth = schlick(half.seen * inverse.sqrt());
        let value = masking * weight * range / (1.0 + self.stretched[2]) * (0.5 / TURNS.len() as f32);
        [value * (1.0 - fifth), value * fifth]
    }
}
