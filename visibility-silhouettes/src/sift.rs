//! Edges that near receivers share before a whole sky.

use crate::edge_list::{CLOSED, COARSE, Columns, ENDS, EdgeList, EdgePacket, ID, PLANES, SOMETIMES};
use crate::hull::{Hull, vectors};
use crate::levels::Levels;
use crate::look::Space;
use crate::sky::{KNOWN, NAME, STEP, in_halves};
use crate::tree::Node;
use fearless_simd::{Simd, f32x8, mask32x8, prelude::*, u32x8};
use glam::Vec3;
use lobe_core::vec3x8::Vec3x8;
use visibility_mask::sky::{Horizon, Meridians, SkyWindow};

/// Edges that may matter to some receivers: silhouettes for all of them, and those that may be silhouettes for some.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shared {
    pub(crate) known: Columns<KNOWN>,
    pub(crate) open: EdgeList,
}

impl Shared {
    fn clear(&mut self) {
        self.known.clear();
        self.open.clear();
    }
}

/// Memory of [`Sift::list_forms`].
#[derive(Clone, Debug, Default)]
pub(crate) struct FormMemory {
    list: Vec<u16>,
    seen: Vec<bool>,
    /// Forms that any of the receivers sees, and those that all see.
    any: Vec<bool>,
    all: Vec<bool>,
    stack: Vec<u32>,
}

/// On which side of a plane all receivers are, 0 where there is no plane, and whether that is known.
#[inline(always)]
fn known_side<S: Simd>(simd: S, [front, behind]: [mask32x8<S>; 2], normal: Vec3x8<S>) -> (f32x8<S>, mask32x8<S>) {
    let zero = f32x8::splat(simd, 0.0);
    let is_absent = normal.abs().dot_one(Vec3::ONE).simd_eq(zero);
    let plus = front.select(f32x8::splat(simd, 1.0), zero);
    (behind.select(f32x8::splat(simd, -1.0), plus), front | behind | is_absent)
}

/// Finds the edges of meshes that matter to a part of a tile's receivers; these are in the meshes' coordinates.
pub(crate) struct Sift<'a, T> {
    space: T,
    hull: &'a Hull,
    meridians: &'a Meridians,
    window: SkyWindow,
    /// A horizon, where all receivers have one pole, and how far receivers are from the middle, seen along the pole.
    horizon: Option<(Horizon, f32)>,
}

impl<'a, T: Space> Sift<'a, T> {
    pub(crate) fn new<'h>(
        space: T,
        hull: &'a Hull,
        meridians: &'a Meridians,
        mut horizons: impl Iterator<Item = &'h Horizon>,
    ) -> Self {
        let horizon = horizons.next().filter(|first| horizons.all(|other| other.pole() == first.pole()));
        let (_, half) = hull.receivers();
        let half = space.half_of(half);
        let horizon = horizon.map(|horizon| (*horizon, horizon.pole().reach(half) * 1.01));
        Self { space, hull, meridians, window: SkyWindow::whole(meridians.resolution()), horizon }
    }

    /// Divides the edges of a list that may matter to the part.
    #[inline(always)]
    pub(crate) fn narrow<S: Simd>(&self, simd: S, list: &EdgeList, out: &mut Shared) {
        out.clear();
        for first in (0..list.len()).step_by(8) {
            self.add(simd, &(list, first), (list.lanes(first), 0), out);
        }
    }

    /// Divides the edges of forms of a mesh that may matter to the part, whose rays start at some places.
    #[inline(always)]
    pub(crate) fn list_forms<S: Simd>(
        &self,
        simd: S,
        (levels, scale): (&Levels, f32),
        origins: impl Iterator<Item = Vec3>,
        memory: &mut FormMemory,
        out: &mut Shared,
    ) {
        out.clear();
        let FormMemory { list, seen, any, all, stack } = memory;
        any.clear();
        all.clear();
        for origin in origins {
            levels.choose(origin, scale, list, seen);
            any.resize(seen.len(), false);
            all.resize(seen.len(), true);
            for ((seen, any), all) in seen.iter().zip(&mut *any).zip(&mut *all) {
                *any |= *seen;
                *all &= *seen;
            }
        }
        let closed = if levels.is_closed() { CLOSED } else { 0 };
        for form in (1..any.len()).filter(|form| any[*form]).map(|form| form as u16) {
            let nodes = levels.tree(form).nodes();
            stack.clear();
            stack.extend((!nodes.is_empty()).then_some(0));
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
                    if any[usize::from(*other)] {
                        let is_sure = all[usize::from(form)] && all[usize::from(*other)];
                        let is_coarse = [form, *other].into_iter().any(|form| levels.is_coarse(form));
                        let mark = closed | if is_coarse { COARSE } else { 0 } | if is_sure { 0 } else { SOMETIMES };
                        self.add(simd, block, ((1 << count) - 1, mark), out);
                    }
                }
            }
        }
    }

    /// The children of a node that may have silhouettes which cross a meridian above any of the horizons, as bits.
    #[inline(always)]
    pub(crate) fn meets<S: Simd>(&self, simd: S, node: &Node) -> u32 {
        let met = self.hull.meets(simd, node, None);
        let Some((horizon, off)) = self.horizon.as_ref().filter(|_| met != 0) else { return met };
        let (center, _) = self.hull.receivers();
        let to = self.space.vector(node.vectors(simd, 0).minus(center));
        let half = self.space.half(node.vectors(simd, 3));
        met & self.meridians.may_cross_boxes(simd, (horizon, &self.window), to, (half, *off)).to_bitmask() as u32
    }

    /// Divides those of eight edges that may matter to the part; `mark` is set in the numbers of all.
    #[inline(always)]
    fn add<S: Simd>(&self, simd: S, packet: &impl EdgePacket, (lanes, mark): (u32, u32), out: &mut Shared) {
        let one = self.hull.faces(simd, packet, PLANES[0]);
        let other = self.hull.faces(simd, packet, PLANES[1]);
        let lanes = mask32x8::from_bitmask(simd, u64::from(lanes));
        let mut keep = lanes & !((one[0] & other[0]) | (one[1] & other[1]));
        if !keep.any_true() {
            return;
        }
        keep &= self.hull.meets_edges(simd, packet);
        if keep.any_true()
            && let Some((horizon, off)) = &self.horizon
        {
            keep &= self.crosses(simd, packet, horizon, *off);
        }
        if !keep.any_true() {
            return;
        }
        let one = known_side(simd, one, vectors(simd, packet, PLANES[0]));
        let other = known_side(simd, other, vectors(simd, packet, PLANES[1]));
        let names = packet.column(simd, ID).bitcast::<u32x8<S>>() | u32x8::splat(simd, mark);
        let sometimes = names.simd_ge(u32x8::splat(simd, SOMETIMES));
        let names = names.bitcast::<f32x8<S>>();
        let is_known = one.1 & other.1 & !sometimes;
        let (sure, unsure) = (keep & is_known, keep & !is_known);
        if sure.any_true() {
            let known = &mut out.known;
            known.reserve(8);
            known.put3(0, sure, vectors(simd, packet, ENDS[0]));
            known.put3(3, sure, vectors(simd, packet, ENDS[1]));
            known.put(STEP, sure, in_halves(simd, other.0 - one.0, names));
            known.put(NAME, sure, names);
            known.end(sure);
        }
        if unsure.any_true() {
            let open = &mut out.open;
            open.reserve(8);
            for column in 0..ID {
                open.put(column, unsure, packet.column(simd, column));
            }
            open.put(ID, unsure, names);
            open.end(unsure);
        }
    }

    /// Which of eight edges may cross a meridian of any of the receivers.
    #[inline(always)]
    fn crosses<S: Simd>(&self, simd: S, packet: &impl EdgePacket, horizon: &Horizon, off: f32) -> mask32x8<S> {
        let (center, _) = self.hull.receivers();
        // Closures would be compiled without wide instructions.
        let [a, b] = [vectors(simd, packet, ENDS[0]), vectors(simd, packet, ENDS[1])];
        let ends = [self.space.vector(a.minus(center)), self.space.vector(b.minus(center))];
        self.meridians.may_cross(simd, horizon, ends, f32x8::splat(simd, off))
    }
}
