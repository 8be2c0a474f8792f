//! The silhouettes of forms of a mesh that one receiver sees before a whole sky.

use crate::edge_list::{Block, CLOSED, COARSE, COLUMNS, Columns, ENDS};
use crate::hull::{UNSURE, vectors};
use crate::levels::Levels;
use crate::select::steps;
use crate::sky::{KNOWN, NAME, STEP, in_halves};
use crate::tree::Node;
use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};
use glam::Vec3;
use lobe_core::vec3x8::Vec3x8;
use visibility_mask::sky::{Horizon, Meridians, SkyWindow};

/// Memory that receivers use one after the other.
#[derive(Clone, Debug, Default)]
pub(crate) struct LookMemory {
    list: Vec<u16>,
    seen: Vec<bool>,
    pub(crate) stack: Vec<u32>,
    /// Places of shared meshes.
    pub(crate) places: Vec<u32>,
}

impl LookMemory {
    /// Which forms a receiver sees.
    pub(crate) fn seen(&mut self, levels: &Levels, from: Vec3, scale: f32) -> &[bool] {
        levels.choose(from, scale, &mut self.list, &mut self.seen);
        &self.seen
    }
}

/// How a mesh's own vectors lie in the world.
pub(crate) trait Space {
    /// A vector.
    fn vector<S: Simd>(&self, v: Vec3x8<S>) -> Vec3x8<S>;

    /// Half the sides of a box around one of such half sides.
    fn half<S: Simd>(&self, half: Vec3x8<S>) -> Vec3x8<S>;

    /// The same for one box.
    fn half_of(&self, half: Vec3) -> Vec3;

    /// Whether left and right are exchanged.
    fn is_mirrored(&self) -> bool;
}

/// The mesh's coordinates are the world's.
pub(crate) struct World;

impl Space for World {
    #[inline(always)]
    fn vector<S: Simd>(&self, v: Vec3x8<S>) -> Vec3x8<S> {
        v
    }

    #[inline(always)]
    fn half<S: Simd>(&self, half: Vec3x8<S>) -> Vec3x8<S> {
        half
    }

    fn half_of(&self, half: Vec3) -> Vec3 {
        half
    }

    fn is_mirrored(&self) -> bool {
        false
    }
}

/// A receiver before a sky, as a mesh has it in its own coordinates.
pub(crate) struct Looker<'a, T> {
    pub(crate) space: T,
    pub(crate) origin: Vec3,
    /// The horizon's normal.
    pub(crate) normal: Vec3,
    /// In the world.
    pub(crate) horizon: Horizon,
    pub(crate) window: SkyWindow,
    pub(crate) meridians: &'a Meridians,
    /// [`Fineness::scale`](crate::hull::Fineness::scale).
    pub(crate) scale: f32,
}

impl<T: Space> Looker<'_, T> {
    /// Lists the silhouettes that may cross a meridian of the window above the horizon.
    #[inline(always)]
    pub(crate) fn find<S: Simd>(&self, simd: S, levels: &Levels, memory: &mut LookMemory, out: &mut Columns<KNOWN>) {
        let LookMemory { list, seen, stack, .. } = memory;
        levels.choose(self.origin, self.scale, list, seen);
        out.clear();
        let closed = if levels.is_closed() { CLOSED } else { 0 };
        for form in list {
            let nodes = levels.tree(*form).nodes();
            stack.clear();
            stack.extend((!nodes.is_empty()).then_some(0));
            let is_coarse = levels.is_coarse(*form);
            while let Some(number) = stack.pop() {
                let node = &nodes[number as usize];
                let mut met = self.meets(simd, node);
                while met != 0 {
                    let k = met.trailing_zeros() as usize & 7;
                    met &= met - 1;
                    let (first, count) = (node.first[k], node.count[k]);
                    if count == 0 {
                        stack.push(first);
                        continue;
                    }
                    let (block, [_, other]) = levels.leaf(first);
                    if seen[usize::from(*other)] {
                        let is_coarse = is_coarse || levels.is_coarse(*other);
                        let name = closed | if is_coarse { COARSE } else { 0 };
                        self.silhouettes(simd, (levels, block), (first, count), name, out);
                    }
                }
            }
        }
    }

    /// The children of a node that may have silhouettes above the horizon that cross a meridian of the window, as bits.
    #[inline(always)]
    pub(crate) fn meets<S: Simd>(&self, simd: S, node: &Node) -> u32 {
        let half = node.vectors(simd, 3);
        let to = node.vectors(simd, 0).minus(self.origin);
        let reach = self.origin.abs().element_sum();
        let far = to.abs() + half;
        let far = far.dot(far).sqrt();
        let unsure = (far + reach) * (2.0 * UNSURE);
        let most = to.dot_one(self.normal) + half.dot_one(self.normal.abs());
        let mut outside = most.simd_lt(-unsure);
        let axis = node.vectors(simd, 6);
        let along = to.dot(axis).abs() - half.dot(axis.abs()) - unsure;
        outside |= along.simd_gt(far * f32x8::simd_from(simd, node.bounds[9]));
        let there = (1 << node.len) - 1;
        if outside.to_bitmask() as u32 & there == there {
            return 0;
        }
        let (to, half) = (self.space.vector(to), self.space.half(half));
        outside |= !self.meridians.may_cross_boxes(simd, (&self.horizon, &self.window), to, (half, 0.0));
        !outside.to_bitmask() as u32 & there
    }

    /// Appends the silhouettes among eight edges.
    #[inline(always)]
    fn silhouettes<S: Simd>(
        &self,
        simd: S,
        (levels, block): (&Levels, &Block<COLUMNS>),
        (first, count): (u32, u8),
        name: u32,
        out: &mut Columns<KNOWN>,
    ) {
        let x = self.origin;
        let zero = f32x8::splat(simd, 0.0);
        let lanes = mask32x8::from_bitmask(simd, (1 << count) - 1);
        let step = steps(simd, block, lanes, x, |lane| levels.sides(first + lane as u32, x));
        // To the right as the receiver sees it; masks are seen from the light.
        let step = if self.space.is_mirrored() { step } else { -step };
        let keep = lanes & !step.simd_eq(zero);
        if !keep.any_true() {
            return;
        }
        out.reserve(8);
        let name = f32x8::splat(simd, f32::from_bits(name));
        // Closures would be compiled without wide instructions.
        let [a, b] = [vectors(simd, block, ENDS[0]), vectors(simd, block, ENDS[1])];
        out.put3(0, keep, self.space.vector(a.minus(x)));
        out.put3(3, keep, self.space.vector(b.minus(x)));
        out.put(STEP, keep, in_halves(simd, step, name));
        out.put(NAME, keep, name);
        out.end(keep);
    }
}
