//! The spheres that meet one receiver's light cone.

use crate::block::{LANES, bits};
use crate::ellipse::Ellipses;
use crate::looks::Looks;
use crate::splat::BlockedCone;
use crate::wide::splat_wide;
use fearless_simd::{Simd, f32x8, prelude::*};
use glam::Vec3;
use lighting::{Edges, Mask};
use lobe_core::Cone;

/// Eight of them, side by side: the numbers of a [`BlockedCone`]. Lanes without one are zero.
#[derive(Clone, Copy, Debug, Default)]
struct Hit {
    to: [[f32; LANES]; 3],
    radius: [f32; LANES],
    tangent_radius: [f32; LANES],
    cos: [f32; LANES],
    meets_light: [bool; LANES],
}

/// All of them, in the order in which they came.
#[derive(Clone, Debug, Default)]
pub(crate) struct Hits {
    blocks: Vec<Hit>,
    len: usize,
}

impl Hits {
    pub(crate) fn clear(&mut self) {
        self.blocks.clear();
        self.len = 0;
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.len == 0
    }

    #[cfg(test)]
    pub(crate) fn iter(&self) -> impl Iterator<Item = BlockedCone> + '_ {
        (0..self.len).map(|k| self.blocks[k / LANES].get(k % LANES))
    }

    pub(crate) fn push(&mut self, cone: &BlockedCone) {
        let lane = self.len % LANES;
        if lane == 0 {
            self.blocks.push(Hit::default());
        }
        if let Some(hit) = self.blocks.last_mut() {
            for (column, value) in hit.to.iter_mut().zip(cone.to.to_array()) {
                column[lane] = value;
            }
            hit.radius[lane] = cone.radius;
            hit.tangent_radius[lane] = cone.tangent_radius;
            hit.cos[lane] = cone.cos;
            hit.meets_light[lane] = cone.meets_light;
        }
        self.len += 1;
    }

    /// Those of eight looks whose bits are set.
    #[inline(always)]
    pub(crate) fn extend<S: Simd>(&mut self, looks: &Looks<S>, mut which: u32) {
        let [x, y, z] = looks.to;
        let (x, y, z): ([f32; LANES], [f32; LANES], [f32; LANES]) = (x.into(), y.into(), z.into());
        let radius: [f32; LANES] = looks.radius.into();
        let tangent_radius: [f32; LANES] = looks.tangent_radius.into();
        let cos: [f32; LANES] = looks.cos.into();
        while which != 0 {
            let lane = which.trailing_zeros() as usize;
            which &= which - 1;
            self.push(&BlockedCone {
                to: Vec3::new(x[lane], y[lane], z[lane]),
                radius: radius[lane],
                tangent_radius: tangent_radius[lane],
                cos: cos[lane],
                meets_light: looks.meets >> lane & 1 != 0,
            });
        }
    }

    /// Adds their rims where those cross the light's disc, as if the spheres were small and far: the turn of a mask need
    /// not be exact, only without steps.
    #[inline(always)]
    pub(crate) fn add_edges<S: Simd>(&self, simd: S, light: &Cone, edges: &mut Edges) {
        let (u, tan) = (light.axis, light.tan());
        for hit in &self.blocks {
            let [x, y, z] = hit.to(simd);
            let along = x * u.x + y * u.y + z * u.z;
            let aside = [x - along * u.x, y - along * u.y, z - along * u.z];
            let disc = (along * tan).abs().max(f32x8::splat(simd, f32::MIN_POSITIVE));
            let distance = (aside[0] * aside[0] + aside[1] * aside[1] + aside[2] * aside[2]).sqrt();
            edges.add_circles(simd, aside, f32x8::simd_from(simd, hit.tangent_radius) / disc, distance / disc);
        }
    }

    /// Splats them, until nothing is lit any more. `light` is the cone of the ball that some of them meet.
    #[inline(always)]
    pub(crate) fn splat<S: Simd>(&self, simd: S, light: &Cone, mask: &mut Mask) {
        let square = *mask.square();
        for (number, hit) in self.blocks.iter().enumerate() {
            let lit = mask.lit_bounds(simd);
            if lit.is_empty() {
                return;
            }
            let [x, y, z] = hit.to(simd);
            let (u, v, w) = (square.right, square.up, square.axis);
            let local = [x * u.x + y * u.y + z * u.z, x * v.x + y * v.y + z * v.z, x * w.x + y * w.y + z * w.z];
            let ellipses = Ellipses::new(simd, local, f32x8::simd_from(simd, hit.tangent_radius), mask);
            let wide = f32x8::simd_from(simd, hit.cos).simd_le(f32x8::splat(simd, 0.0)).to_bitmask() as u32;
            let narrow = ellipses.are_in_front() & !wide & !bits(hit.meets_light);
            let all = (1 << (self.len - number * LANES).min(LANES)) - 1;
            let mut left = all & !(narrow & ellipses.misses(simd, &lit));
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                if narrow >> lane & 1 != 0 {
                    ellipses.splat(simd, lane, mask);
                } else if hit.meets_light[lane] {
                    hit.get(lane).splat_in_front(light, mask);
                } else {
                    splat_wide(simd, square.local(hit.get(lane).to), hit.cos[lane], mask);
                }
            }
        }
    }
}

impl Hit {
    #[inline(always)]
    fn to<S: Simd>(&self, simd: S) -> [f32x8<S>; 3] {
        let [x, y, z] = self.to;
        [f32x8::simd_from(simd, x), f32x8::simd_from(simd, y), f32x8::simd_from(simd, z)]
    }

    fn get(&self, lane: usize) -> BlockedCone {
        BlockedCone {
            to: Vec3::from_array(self.to.map(|column| column[lane])),
            radius: self.radius[lane],
            tangent_radius: self.tangent_radius[lane],
            cos: self.cos[lane],
            meets_light: self.meets_light[lane],
        }
    }
}
