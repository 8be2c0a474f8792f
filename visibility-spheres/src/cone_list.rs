//! The cones of directions that spheres block of one receiver's light.

use crate::block::LANES;
use crate::blocked_cones::BlockedCones;
use crate::ellipse::Ellipses;
use crate::rim::SIDES;
use crate::splat::{BlockedCone, Front};
use crate::wide_cone::splat_wide;
use fearless_simd::{Simd, f32x8, prelude::*};
use glam::Vec3;
use lobe_core::Cone;
use visibility_mask::{Edges, LitArea, Mask, UnitSquare};

/// Numbers of a cone: to the centre; `d sin β`; the cosine of a wide cone, else 1; the radius of a sphere that meets the
/// light, else 0.
const COLUMNS: usize = 6;

/// More rims than this are not given to others, who would look at each two of their sides.
const MOST_RIMS: usize = 64;

/// All of them, in the order in which they came.
#[derive(Clone, Debug, Default)]
pub(crate) struct ConeList {
    /// With room for eight more.
    columns: [Vec<f32>; COLUMNS],
    len: usize,
}

impl ConeList {
    /// None, with room for so many.
    pub(crate) fn clear(&mut self, room: usize) {
        self.len = 0;
        for column in self.columns.iter_mut().filter(|column| column.len() < room + LANES) {
            column.resize(room + LANES, 0.0);
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.len == 0
    }

    #[cfg(test)]
    pub(crate) fn iter(&self) -> impl Iterator<Item = BlockedCone> + '_ {
        (0..self.len).map(|k| self.get(k))
    }

    #[cfg(test)]
    pub(crate) fn push(&mut self, cone: &BlockedCone) {
        self.columns.iter_mut().for_each(|column| column.resize(self.len + 2 * LANES, 0.0));
        let wide = if cone.cos > 0.0 { 1.0 } else { cone.cos };
        let meeting = if cone.meets_light { cone.radius } else { 0.0 };
        let row = [cone.to.x, cone.to.y, cone.to.z, cone.tangent_radius, wide, meeting];
        self.columns.iter_mut().zip(row).for_each(|(column, value)| column[self.len] = value);
        self.len += 1;
    }

    /// Those of eight cones that hide something; lanes behind them are zero.
    #[inline(always)]
    pub(crate) fn extend<S: Simd>(&mut self, cones: &BlockedCones<S>) {
        let [x, y, z] = cones.to;
        let of = [x, y, z, cones.tangent_radius, cones.wide, cones.meeting];
        for (column, of) in self.columns.iter_mut().zip(of) {
            if let Some(lanes) = column[self.len..].first_chunk_mut::<LANES>() {
                of.compress(cones.hides).store_slice(lanes);
            }
        }
        self.len += cones.hides.to_bitmask().count_ones() as usize;
    }

    /// Makes the lanes behind the last cone zero.
    #[inline(always)]
    pub(crate) fn end(&mut self) {
        for column in &mut self.columns {
            if let Some(lanes) = column[self.len..].first_chunk_mut::<LANES>() {
                *lanes = [0.0; LANES];
            }
        }
    }

    /// A column of the eight cones from `first` on.
    #[inline(always)]
    fn column<S: Simd>(&self, simd: S, column: usize, first: usize) -> f32x8<S> {
        let lanes = self.columns[column].get(first..).and_then(<[f32]>::first_chunk);
        f32x8::simd_from(simd, lanes.copied().unwrap_or_default())
    }

    fn get(&self, k: usize) -> BlockedCone {
        let [x, y, z, tangent_radius, wide, meeting] = core::array::from_fn(|column| self.columns[column][k]);
        BlockedCone::new(Vec3::new(x, y, z), tangent_radius, wide, meeting)
    }

    /// Adds their rims where those cross the light's disc, as if the spheres were small and far: the turn of a mask need
    /// not be exact, only without steps.
    #[inline(always)]
    pub(crate) fn add_edges<S: Simd>(&self, simd: S, light: &Cone, edges: &mut Edges) {
        let (u, tan) = (light.axis, light.tan());
        for first in (0..self.len).step_by(LANES) {
            let [x, y, z, tangent_radius] = core::array::from_fn(|column| self.column(simd, column, first));
            let along = x * u.x + y * u.y + z * u.z;
            let of_disc = f32x8::splat(simd, 1.0) / (along * tan).abs().max(f32x8::splat(simd, f32::MIN_POSITIVE));
            edges.add_circles(simd, [x * of_disc, y * of_disc, z * of_disc], tangent_radius * of_disc);
        }
    }

    /// Adds polygons around the directions in a window that they block. `false` where they are many, or where one is wide or meets the light.
    pub(crate) fn add_rims(&self, window: &UnitSquare, lit: &mut LitArea) -> bool {
        (0..self.len).all(|k| self.get(k).add_rim(window, lit) && lit.hidden().len() <= MOST_RIMS * SIDES)
    }

    /// Splats them, until nothing is lit any more. `light` is what some of them meet.
    #[inline(always)]
    pub(crate) fn splat<S: Simd>(&self, simd: S, light: &Front, mask: &mut Mask) {
        let square = *mask.square();
        let zero = f32x8::splat(simd, 0.0);
        for first in (0..self.len).step_by(LANES) {
            let lit = mask.lit_bounds(simd);
            if lit.is_empty() {
                return;
            }
            let [x, y, z, tangent_radius, wide, meeting] =
                core::array::from_fn(|column| self.column(simd, column, first));
            let (u, v, w) = (square.right, square.up, square.axis);
            let local = [x * u.x + y * u.y + z * u.z, x * v.x + y * v.y + z * v.z, x * w.x + y * w.y + z * w.z];
            let ellipses = Ellipses::new(simd, local, tangent_radius, mask);
            let meets = meeting.simd_gt(zero).to_bitmask() as u32;
            let narrow = ellipses.are_in_front() & wide.simd_gt(zero).to_bitmask() as u32;
            let all = (1 << (self.len - first).min(LANES)) - 1;
            let mut left = all & !(narrow & ellipses.misses(simd, &lit));
            let whole = narrow & !meets;
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                if whole >> lane & 1 != 0 {
                    ellipses.splat(simd, lane, mask);
                    continue;
                }
                let cone = self.get(first + lane);
                if cone.meets_light {
                    cone.splat_in_front(light, mask);
                } else {
                    splat_wide(simd, square.local(cone.to), cone.cos, mask);
                }
            }
        }
    }
}
