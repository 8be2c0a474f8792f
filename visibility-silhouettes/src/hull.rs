use crate::edge_list::{Block, CLOSED, COARSE, COLUMNS, ENDS, EdgeList, EdgePacket, PLANES};
use crate::lanes::number;
use crate::mesh::SilhouetteMesh;
use crate::tree::{Node, Tree};
use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};
use glam::Vec3;
use lobe_core::Sphere;
use lobe_core::vec3x8::Vec3x8;
use shading::Shaft;

/// Planes around the hull: eight along the light's path, one behind the receivers, one behind the light.
const SIDES: usize = 10;

/// Error of `n·x + d` in f32, relative to `|d| + |x| + |y| + |z|`: the sign of a smaller value is not known.
pub(crate) const UNSURE: f32 = 6e-7;

/// Where edges matter to some receivers.
#[derive(Clone, Debug)]
pub(crate) enum Region {
    /// Between them and a light: inside of all planes, by outward unit normals and the offsets along them.
    Shaft([(Vec3, f32); SIDES]),
    /// Above any of their horizons: beyond one of the planes.
    Horizons(Vec<(Vec3, f32)>),
}

impl Region {
    /// Which of eight boxes are wholly outside. Loops over all edges have no closures: these are not always inlined.
    #[inline(always)]
    fn misses_boxes<S: Simd>(&self, simd: S, middle: Vec3x8<S>, half: Vec3x8<S>) -> mask32x8<S> {
        match self {
            Self::Shaft(planes) => {
                let mut outside = mask32x8::splat(simd, false);
                for (n, offset) in planes {
                    let least = middle.dot_one(*n) - half.dot_one(n.abs());
                    outside |= least.simd_gt(f32x8::splat(simd, *offset));
                }
                outside
            }
            Self::Horizons(planes) => {
                let mut outside = mask32x8::splat(simd, true);
                for (n, offset) in planes {
                    let most = middle.dot_one(*n) + half.dot_one(n.abs());
                    outside &= most.simd_lt(f32x8::splat(simd, *offset));
                    if !outside.any_true() {
                        break;
                    }
                }
                outside
            }
        }
    }

    /// Which of eight edges are wholly outside.
    #[inline(always)]
    fn misses_edges<S: Simd>(&self, simd: S, a: Vec3x8<S>, b: Vec3x8<S>) -> mask32x8<S> {
        match self {
            Self::Shaft(planes) => {
                let mut outside = mask32x8::splat(simd, false);
                for (n, offset) in planes {
                    outside |= a.dot_one(*n).min(b.dot_one(*n)).simd_gt(f32x8::splat(simd, *offset));
                }
                outside
            }
            Self::Horizons(planes) => {
                let mut outside = mask32x8::splat(simd, true);
                for (n, offset) in planes {
                    outside &= a.dot_one(*n).max(b.dot_one(*n)).simd_lt(f32x8::splat(simd, *offset));
                    if !outside.any_true() {
                        break;
                    }
                }
                outside
            }
        }
    }
}

/// All segments from some receivers to a light, bounded by planes, or all that some receivers see of a sky: no edge outside of it matters to
/// any of the receivers.
#[derive(Clone, Debug)]
pub(crate) struct Hull {
    pub(crate) region: Region,
    /// The places where rays start: in a box, and in a sphere with the same centre.
    pub(crate) center: Vec3,
    pub(crate) half: Vec3,
    pub(crate) radius: f32,
    /// The largest |x| + |y| + |z| of a receiver.
    pub(crate) reach: f32,
    /// The scales of the simplified forms that the receivers may take ([`Fineness::scale`]): least and largest; `None` for exact outlines.
    pub(crate) scales: Option<[f32; 2]>,
}

/// The finest details of outlines: those smaller than this fraction of a light's radius may be left out. 0 for exact outlines.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Fineness(pub(crate) f32);

impl Fineness {
    /// The ratio of a receiver's distance to the size of a detail from which on the detail may be left out.
    #[inline(always)]
    pub(crate) fn scale(self, from: Vec3, light: Sphere) -> f32 {
        from.distance(light.center) / (self.0 * light.radius)
    }

    /// The smallest and the largest of these ratios for receivers in a sphere.
    fn scales(self, center: Vec3, radius: f32, light: Sphere) -> [f32; 2] {
        let all = self.0 * light.radius;
        let distance = center.distance(light.center);
        let rounding = 1e-5 * (distance + center.abs().element_sum());
        [(distance - radius - rounding).max(0.0) / all, (distance + radius + rounding) / all]
    }

    /// Whether simplified forms are never drawn.
    pub(crate) fn is_exact(self, light: Sphere) -> bool {
        !(self.0 > 0.0 && light.radius > 0.0)
    }
}

/// Memory that searches use again.
#[derive(Clone, Debug, Default)]
pub(crate) struct Memory {
    pub(crate) forms: Vec<Option<bool>>,
    pub(crate) stack: Vec<u32>,
    pub(crate) leaves: Vec<Leaf>,
    /// Of the hierarchy over places, or over meshes.
    pub(crate) places: Vec<Leaf>,
    /// The numbers of meshes.
    pub(crate) met: Vec<u32>,
}

/// Some edges of a mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leaf {
    pub(crate) first: u32,
    pub(crate) count: u8,
}

impl Hull {
    /// Of a shaft whose rays start within `margin` of its receivers.
    pub(crate) fn new(shaft: &Shaft, margin: f32, fineness: Fineness) -> Self {
        let Shaft { receivers: Sphere { center, radius }, light, .. } = *shaft;
        let (half, radius) = (shaft.half_extent + margin, radius + margin);
        let outer = (center.abs() + half).element_sum();
        let scales = (!fineness.is_exact(light)).then(|| fineness.scales(center, radius, light));
        let reach = outer + margin;
        // Offsets are differences of long numbers.
        let margin = margin + 2e-6 * (outer + light.center.abs().element_sum() + light.radius);
        let planes = shaft.normals().map(|n| (n, n.dot(center) + shaft.reach(n) + margin));
        Self { region: Region::Shaft(planes), center, half, radius, reach, scales }
    }

    /// Of receivers whose rays start at `origins`, above the horizons that have these unit normals; `scale` is [`Fineness::scale`], the same
    /// for all. None for exact outlines.
    pub(crate) fn of_sky(origins: &[Vec3], normals: &[Vec3], scale: Option<f32>) -> Self {
        let first = origins.first().copied().unwrap_or_default();
        let (low, high) = origins.iter().fold((first, first), |(low, high), p| (low.min(*p), high.max(*p)));
        let center = 0.5 * low + 0.5 * high;
        let rounding = 1e-6 * (low.abs().max(high.abs())).element_sum();
        let half = (high - center).max(center - low) + rounding;
        let mut planes: Vec<(Vec3, f32)> = Vec::with_capacity(normals.len());
        for (origin, normal) in origins.iter().zip(normals) {
            let offset = normal.dot(*origin) - rounding;
            match planes.iter_mut().find(|plane| plane.0 == *normal) {
                Some(plane) => plane.1 = plane.1.min(offset),
                None => planes.push((*normal, offset)),
            }
        }
        let reach = (center.abs() + half).element_sum();
        let scales = scale.map(|scale| [scale; 2]);
        Self { region: Region::Horizons(planes), center, half, radius: half.length(), reach, scales }
    }

    /// The middle of the receivers, and half the sides of a box around them.
    pub(crate) const fn receivers(&self) -> (Vec3, Vec3) {
        (self.center, self.half)
    }

    /// The children of a node that may have silhouettes inside the hull, as bits.
    #[inline(always)]
    pub(crate) fn meets<S: Simd>(&self, simd: S, node: &Node, forms: Option<(&Forms<'_>, &[[f32; 8]; 2])>) -> u32 {
        let middle = node.vectors(simd, 0);
        let half = node.vectors(simd, 3);
        let mut outside = self.region.misses_boxes(simd, middle, half);
        // All normals of the cone on one side for all receivers: none of its edges is a silhouette. For d from any point of
        // the box to any receiver that is axis·d > |d| sin α.
        let axis = node.vectors(simd, 6);
        let to = middle.minus(self.center);
        let wide = half.plus(self.half);
        let far = to.abs() + wide;
        let far = far.dot(far).sqrt();
        let unsure = (far + self.reach) * (2.0 * UNSURE);
        let along = to.dot(axis).abs() - wide.dot(axis.abs()) - unsure;
        outside |= along.simd_gt(far * f32x8::simd_from(simd, node.bounds[9]));
        if let Some((forms, reach)) = forms {
            let away = to.dot(to).sqrt();
            let [reach, detail] = [f32x8::simd_from(simd, reach[0]), f32x8::simd_from(simd, reach[1])];
            let (zero, around) = (f32x8::splat(simd, 0.0), forms.radius + 1e-5 * self.reach);
            outside |= if forms.is_coarse {
                (away * 1.000_01 + reach + detail * forms.scales[0] + around).simd_lt(zero)
            } else {
                (away * 0.999_99 - reach - detail * forms.scales[1] - around).simd_gt(zero)
            };
        }
        !outside.to_bitmask() as u32 & ((1 << node.len) - 1)
    }

    /// Which of eight edges are certainly not silhouettes for any of the receivers.
    #[inline(always)]
    pub(crate) fn cancel<S: Simd>(&self, simd: S, packet: &impl EdgePacket) -> mask32x8<S> {
        let [one, other] = [self.faces(simd, packet, PLANES[0]), self.faces(simd, packet, PLANES[1])];
        (one[0] & other[0]) | (one[1] & other[1])
    }

    /// The same where planes may be off by some distances.
    #[inline(always)]
    pub(crate) fn cancel_within<S: Simd>(&self, simd: S, packet: &impl EdgePacket, margin: f32x8<S>) -> mask32x8<S> {
        let one = self.faces_within(simd, packet, PLANES[0], Some(margin));
        let other = self.faces_within(simd, packet, PLANES[1], Some(margin));
        (one[0] & other[0]) | (one[1] & other[1])
    }

    /// Which of eight edges may lie inside of the hull.
    #[inline(always)]
    pub(crate) fn meets_edges<S: Simd>(&self, simd: S, packet: &impl EdgePacket) -> mask32x8<S> {
        !self.region.misses_edges(simd, vectors(simd, packet, ENDS[0]), vectors(simd, packet, ENDS[1]))
    }

    /// Appends those of eight edges that `keep` has and that may lie inside of the hull; there must be room.
    #[inline(always)]
    pub(crate) fn sift<S: Simd>(&self, simd: S, packet: &impl EdgePacket, keep: mask32x8<S>, out: &mut EdgeList) {
        if !keep.any_true() {
            return;
        }
        let keep = keep & self.meets_edges(simd, packet);
        if keep.any_true() {
            for column in 0..COLUMNS {
                out.put(column, keep, packet.column(simd, column));
            }
            out.end(keep);
        }
    }

    /// Whether all receivers are certainly in front of planes, and whether all are behind them.
    #[inline(always)]
    pub(crate) fn faces<S: Simd>(&self, simd: S, packet: &impl EdgePacket, column: usize) -> [mask32x8<S>; 2] {
        self.faces_within(simd, packet, column, None)
    }

    /// The same where planes may be off by some distances.
    #[inline(always)]
    fn faces_within<S: Simd>(
        &self,
        simd: S,
        packet: &impl EdgePacket,
        column: usize,
        margin: Option<f32x8<S>>,
    ) -> [mask32x8<S>; 2] {
        let (normal, d) = (vectors(simd, packet, column), packet.column(simd, column + 3));
        let middle = normal.dot_one(self.center) + d;
        let unsure = d.abs() * (2.0 * UNSURE) + 2.0 * UNSURE * self.reach;
        let wide = normal.abs().dot_one(self.half).min(f32x8::splat(simd, self.radius));
        let (mut reach, zero) = (wide * 1.000_001 + unsure, f32x8::splat(simd, 0.0));
        if let Some(margin) = margin {
            reach += margin;
        }
        [(middle - reach).simd_gt(zero), (middle + reach).simd_lt(zero)]
    }

    /// Appends the edges of a mesh that may be silhouettes inside the hull. `base` is the number of its first edge. `most` counts
    /// down the leaves that are met; if there are more, the search stops before it reads edges and returns `false`.
    #[inline(always)]
    pub(crate) fn find<S: Simd>(
        &self,
        simd: S,
        mesh: &SilhouetteMesh,
        base: u32,
        memory: &mut Memory,
        most: &mut usize,
        out: &mut EdgeList,
    ) -> bool {
        let Some(found) = self.find_leaves(simd, mesh, memory, most) else { return false };
        for (forms, leaves) in &found {
            self.edges(simd, mesh, base, forms.as_ref(), leaves, out);
        }
        true
    }

    /// The leaves of a mesh that may have silhouettes inside the hull: of the exact form, then of simplified ones, each with the forms that are
    /// drawn if not all are exact. `most` counts down the leaves; `None` if there are more.
    #[inline(always)]
    pub(crate) fn find_leaves<'m, S: Simd>(
        &self,
        simd: S,
        mesh: &SilhouetteMesh,
        memory: &'m mut Memory,
        most: &mut usize,
    ) -> Option<[(Option<Forms<'m>>, &'m [Leaf]); 2]> {
        let Memory { forms, stack, leaves, .. } = memory;
        leaves.clear();
        let [fine, coarse] = mesh.trees();
        let radius = self.radius;
        forms.clear();
        if let Some(scales) = self.scales {
            forms.extend(mesh.patches().iter().map(|patch| patch.is_coarse_from(self.center, radius, scales)));
        }
        let scales = self.scales.unwrap_or_default();
        if forms.iter().all(|form| *form == Some(false)) {
            let found = self.leaves(simd, fine, None, stack, most, leaves);
            return found.then_some([(None, leaves), (None, &[])]);
        }
        let [of_fine, of_coarse] = [false, true].map(|is_coarse| Forms { forms, is_coarse, radius, scales });
        if !self.leaves(simd, fine, Some(&of_fine), stack, most, leaves) {
            return None;
        }
        let fine_leaves = leaves.len();
        if !self.leaves(simd, coarse, Some(&of_coarse), stack, most, leaves) {
            return None;
        }
        let (fine, coarse) = leaves.split_at(fine_leaves);
        Some([(Some(of_fine), fine), (Some(of_coarse), coarse)])
    }

    /// Appends the leaves of a tree that may have silhouettes inside the hull.
    #[inline(always)]
    pub(crate) fn leaves<S: Simd>(
        &self,
        simd: S,
        tree: &Tree,
        forms: Option<&Forms<'_>>,
        stack: &mut Vec<u32>,
        most: &mut usize,
        out: &mut Vec<Leaf>,
    ) -> bool {
        let nodes = tree.nodes();
        stack.clear();
        stack.extend((!nodes.is_empty()).then_some(0));
        while let Some(number) = stack.pop() {
            let node = &nodes[number as usize];
            let mut met = self.meets(simd, node, forms.zip(tree.reach(number as usize)));
            while met != 0 {
                let k = met.trailing_zeros() as usize & 7;
                met &= met - 1;
                let (first, count) = (node.first[k], node.count[k]);
                if count == 0 {
                    stack.push(first);
                    continue;
                }
                let Some(left) = most.checked_sub(1) else { return false };
                *most = left;
                out.push(Leaf { first, count });
            }
        }
        true
    }

    /// Appends the edges of leaves.
    #[inline(always)]
    fn edges<S: Simd>(
        &self,
        simd: S,
        mesh: &SilhouetteMesh,
        base: u32,
        forms: Option<&Forms<'_>>,
        leaves: &[Leaf],
        out: &mut EdgeList,
    ) {
        let mark = if forms.is_some_and(|forms| forms.is_coarse) { COARSE } else { 0 };
        let mark = if mesh.is_closed() { mark | CLOSED } else { mark };
        let mut block: Block<COLUMNS> = [[0.0; 8]; COLUMNS];
        for leaf in leaves {
            let (first, count) = (leaf.first as usize, usize::from(leaf.count));
            let packed = mesh.packed(first);
            let lanes = match packed {
                Some(packet) => packet.lanes,
                None => mesh.fetch_planes(simd, first, count, &mut block),
            };
            let planes = packed.map_or(&block, |packet| &packet.columns);
            let lanes = mask32x8::from_bitmask(simd, u64::from(lanes));
            let mut keep = (lanes & !self.cancel(simd, planes)).to_bitmask() as u32;
            let mut sometimes = 0;
            if let Some(forms) = forms {
                (keep, sometimes) = forms.drawn(mesh, first, keep);
            }
            if keep == 0 {
                continue;
            }
            if let Some(packet) = packed {
                block = packet.columns;
                number(base + leaf.first, [sometimes, mark], &mut block);
            } else {
                mesh.fetch_ends(simd, first, keep, [sometimes, mark], base, &mut block);
            }
            out.reserve(8);
            self.sift(simd, &block, mask32x8::from_bitmask(simd, u64::from(keep)), out);
        }
    }

    /// Appends those edges of a list that may be silhouettes inside the hull.
    #[inline(always)]
    pub(crate) fn narrow<S: Simd>(&self, simd: S, list: &EdgeList, out: &mut EdgeList) {
        out.clear();
        for first in (0..list.len()).step_by(8) {
            // Not for all edges at once, since few edges of a long list are kept.
            out.reserve(8);
            let lanes = mask32x8::from_bitmask(simd, u64::from(list.lanes(first)));
            let keep = lanes & !self.cancel(simd, &(list, first));
            self.sift(simd, &(list, first), keep, out);
        }
    }
}

/// The forms of a mesh's patches that are drawn for the receivers of a hull: `None` for a patch if receivers need both.
pub(crate) struct Forms<'f> {
    pub(crate) forms: &'f [Option<bool>],
    /// Whether the searched tree is that of simplified forms.
    pub(crate) is_coarse: bool,
    /// Radius of a sphere around the receivers.
    pub(crate) radius: f32,
    pub(crate) scales: [f32; 2],
}

impl Forms<'_> {
    /// The edges that are drawn for any of the receivers, and those of them that are not drawn for all.
    #[inline(always)]
    pub(crate) fn drawn(&self, mesh: &SilhouetteMesh, first: usize, mut lanes: u32) -> (u32, u32) {
        let (mut drawn, mut sometimes) = (0, 0);
        while lanes != 0 {
            let lane = lanes.trailing_zeros();
            lanes &= lanes - 1;
            let (mut is_drawn, mut is_sure) = (true, true);
            for (patch, is_coarse) in mesh.tag(first + lane as usize).patches() {
                let form = self.forms[usize::from(patch)];
                is_drawn &= form.is_none_or(|form| form == is_coarse);
                is_sure &= form.is_some();
            }
            drawn |= u32::from(is_drawn) << lane;
            sometimes |= u32::from(is_drawn && !is_sure) << lane;
        }
        (drawn, sometimes)
    }
}

/// Three columns of eight edges.
#[inline(always)]
pub(crate) fn vectors<S: Simd>(simd: S, packet: &impl EdgePacket, column: usize) -> Vec3x8<S> {
    Vec3x8::new(packet.column(simd, column), packet.column(simd, column + 1), packet.column(simd, column + 2))
}
