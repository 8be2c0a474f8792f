//! Searches for edges of shared meshes at their places.

use crate::edge_list::{Block, CLOSED, COARSE, COLUMNS, EdgeList};
use crate::hull::{Forms, Hull, Leaf, Memory, Region};
use crate::placed::{Place, Placed, SilhouetteInstances};
use crate::tree::Tree;
use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};
use glam::{DMat3, DVec3, Vec3};

/// More than the rounding of planes and corners that are mapped to a mesh's own coordinates, over the numbers that are added up.
const ROUNDING: f64 = 1e-6;

impl Hull {
    /// The same in the own coordinates of a mesh whose corners rounding moves by `blur`: no edge outside of it matters.
    fn at(&self, place: &Place, blur: f32) -> Self {
        let linear = DMat3::from_mat4(place.matrix().as_dmat4());
        let shift = place.matrix().w_axis.truncate().as_dvec3();
        let transposed = linear.transpose();
        let center = place.to_own(self.center);
        // Half the sides of a box around the mapped box.
        let inverse = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| place.direction_to_own(axis).abs());
        let [x, y, z] = inverse;
        let half = self.half.as_dvec3();
        let half = (x * half.x + y * half.y + z * half.z).as_vec3() * 1.000_001 + blur;
        let far = center.abs().element_sum() + half.element_sum() as f64;
        let half = half + (ROUNDING * far) as f32;
        let plane = |(n, offset): (Vec3, f32), margin: f64| {
            let n = n.as_dvec3();
            let (own, offset) = (transposed * n, f64::from(offset) - n.dot(shift));
            let rounding = ROUNDING * (n.abs().dot(shift.abs()) + f64::from(self.reach) + offset.abs());
            let blur = f64::from(blur) * own.abs().element_sum();
            (own.as_vec3(), (offset + margin * (rounding + blur)) as f32)
        };
        let region = match &self.region {
            Region::Shaft(planes) => Region::Shaft(planes.map(|p| plane(p, 1.0))),
            Region::Horizons(planes) => Region::Horizons(planes.iter().map(|p| plane(*p, -1.0)).collect()),
        };
        let radius = (self.radius * place.shrink()).min(half.length()) * 1.000_01 + blur;
        let center = center.as_vec3();
        Self {
            region,
            center,
            half,
            radius,
            reach: (center.abs() + half).element_sum(),
            scales: self.scales.filter(|_| place.is_even()),
        }
    }

    /// No less than the distance from any receiver to any edge of two trees.
    fn farthest(&self, trees: [&Tree; 2]) -> f32 {
        let of_tree = |tree: &Tree| {
            let [low, high] = tree.bounds();
            ((low - self.center).abs().max((high - self.center).abs()) + self.half).length()
        };
        let filled = trees.into_iter().filter(|tree| !tree.nodes().is_empty());
        1.000_01 * filled.map(of_tree).fold(0.0, f32::max)
    }

    /// Appends the edges of instances that may be silhouettes inside the hull, as [`find`](Self::find) does for a mesh; on request without those whose mesh has
    /// forms for a whole sky at their place.
    #[inline(always)]
    pub(crate) fn find_instances<S: Simd>(
        &self,
        simd: S,
        (instances, without_forms): (&SilhouetteInstances, bool),
        base: u32,
        memory: &mut Memory,
        most: &mut usize,
        out: &mut EdgeList,
    ) -> bool {
        let mut places = core::mem::take(&mut memory.places);
        places.clear();
        // Places are no leaves of edges: any number of them.
        let mut all = usize::MAX;
        self.leaves(simd, instances.top(), None, &mut memory.stack, &mut all, &mut places);
        let all = places.iter().flat_map(|leaf| (leaf.first..).take(usize::from(leaf.count)));
        let mut is_whole = true;
        for place in all {
            let (placed, first) = instances.at(place as usize);
            if without_forms && placed.levels().is_some() {
                continue;
            }
            if !self.find_placed(simd, placed, base + first, memory, most, out) {
                is_whole = false;
                break;
            }
        }
        memory.places = places;
        is_whole
    }

    #[inline(always)]
    fn find_placed<S: Simd>(
        &self,
        simd: S,
        placed: Placed<'_>,
        base: u32,
        memory: &mut Memory,
        most: &mut usize,
        out: &mut EdgeList,
    ) -> bool {
        let own = self.at(placed.place, placed.mesh.blur());
        let Some(found) = own.find_leaves(simd, placed.mesh, memory, most) else { return false };
        for (forms, leaves) in &found {
            self.edges_placed(simd, (placed, &own), base, forms.as_ref(), leaves, out);
        }
        true
    }

    /// Appends the edges of leaves, with corners and planes of the world. `own` is the hull in the mesh's own coordinates.
    #[inline(always)]
    fn edges_placed<S: Simd>(
        &self,
        simd: S,
        (placed, own): (Placed<'_>, &Self),
        base: u32,
        forms: Option<&Forms<'_>>,
        leaves: &[Leaf],
        out: &mut EdgeList,
    ) {
        let mark = if forms.is_some_and(|forms| forms.is_coarse) { COARSE } else { 0 };
        let mark = if placed.mesh.is_closed() { mark | CLOSED } else { mark };
        let mut block: Block<COLUMNS> = [[0.0; 8]; COLUMNS];
        let far = own.farthest(placed.mesh.trees());
        let shift = f32x8::splat(simd, 2.0 * placed.mesh.blur());
        for leaf in leaves {
            let first = leaf.first as usize;
            // Most edges go by the mesh's own planes, which are at hand.
            let lanes = placed.mesh.fetch_planes(simd, first, usize::from(leaf.count), &mut block);
            let margin = f32x8::simd_from(simd, placed.mesh.turns(first)) * far + shift;
            let (mut keep, mut sometimes) = (lanes & !own.cancel_within(simd, &block, margin).to_bitmask() as u32, 0);
            if let Some(forms) = forms {
                (keep, sometimes) = forms.drawn(placed.mesh, first, keep);
            }
            if keep == 0 {
                continue;
            }
            placed.fetch_ends(simd, first, keep, [sometimes, mark], base, &mut block);
            keep &= self.meets_edges(simd, &block).to_bitmask() as u32;
            if keep == 0 {
                continue;
            }
            placed.fetch_planes(simd, first, keep, &mut block);
            let keep = mask32x8::from_bitmask(simd, u64::from(keep)) & !self.cancel(simd, &block);
            out.reserve(8);
            self.sift(simd, &block, keep, out);
        }
    }
}
