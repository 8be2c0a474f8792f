//! Lobes of a tile over a flat light.

use super::grid::{Grid, Node, Nodes};
use super::integral::{STEEP, integral};
use super::lambert::of_block;
use super::parts::AtNode;
use super::rules::{Before, NONE, Shape, rules, smaller};
use crate::lanes::{Columns, Kept, Lane, Level, WIDTH, map, ones, row};
use crate::tile::Flat;
use crate::{BrdfLobe, PackedLobe, Receiver, TileLobes, is_lambert};
use fearless_simd::dispatch;
use glam::Vec3;

/// Lambert lobes side by side; lobes that vary little over the light, too; others one by one.
pub(crate) fn of_flat(level: Level, (flat, at): (&Flat, &[Kept<9>]), lobes: &TileLobes, out: &mut [f32]) {
    // Not a number where nothing is known yet.
    out.fill(f32::NAN);
    if let Some(grid) = Grid::new(&flat.shape) {
        let light = Shared { grid, normal: flat.shape.normal(), is_two_sided: flat.is_two_sided };
        let mut nodes = None;
        for (block, at) in at.iter().enumerate() {
            for place in 0..lobes.places() {
                light.add(level, &at.0, lobes, (place, block), &mut nodes, out);
            }
        }
    }
    for (block, at) in at.iter().enumerate() {
        let mut lambert = None;
        for j in 0..WIDTH {
            let i = block * WIDTH + j;
            let [x, y, z, u, v, w, _, _, _] = row(&at.0, j);
            let (from, normal) = (Vec3::new(x, y, z), Vec3::new(u, v, w));
            let at_normal = Receiver::on_surface(Vec3::ZERO, normal, normal);
            let mut bright = None;
            for (number, lobe) in lobes.of(i) {
                if matches!(lobe, BrdfLobe::Cosine(lobe) if is_lambert(&at_normal, &lobe)) {
                    let sides = || of_block(level, &flat.shape, flat.is_two_sided, &at.0);
                    let value = lambert.get_or_insert_with(sides)[j];
                    out[number] = if value < 0.0 { 0.0 } else { value };
                }
                if out[number].is_nan() {
                    let seen = || flat.shape.bright_above(from, normal, flat.is_two_sided);
                    let bright = bright.get_or_insert_with(seen).as_ref();
                    out[number] = bright.map_or(0.0, |bright| integral(&at_normal, &lobe, bright));
                }
            }
        }
    }
    out.iter_mut().for_each(|value| *value = if value.is_nan() { 0.0 } else { *value });
}

/// A flat light, and the grid that its receivers share.
#[derive(Clone, Copy)]
struct Shared {
    grid: Grid,
    normal: Vec3,
    is_two_sided: bool,
}

impl Shared {
    /// Sets the integrals of those lobes of a block that a grid is enough for: each by the nodes that it needs itself, whichever lobes are beside it.
    /// The last nodes are kept for the next.
    fn add(
        &self,
        level: Level,
        at: &Columns<9>,
        lobes: &TileLobes,
        (place, block): (usize, usize),
        kept: &mut Option<Nodes>,
        out: &mut [f32],
    ) {
        let stride = lobes.blocks_of_place();
        let number = place * stride + block;
        let lobe = |number: usize, j| bytemuck::cast::<_, PackedLobe>(row(lobes.block(number), j));
        // Most are Lambert's.
        let is_other = |j: usize| {
            let (lobe, [_, _, _, u, v, w, ..]) = (lobe(number, j), row(at, j));
            lobe.flux != Vec3::ZERO && !lobe.is_lambert(Vec3::new(u, v, w))
        };
        if !(0..WIDTH).any(is_other) {
            return;
        }
        let mut wanted = [[0.0; WIDTH]; 3];
        map(level, &Wanted(*self), at, lobes.block(number), &mut wanted);
        let is_open = |j: usize| wanted[0][j] > 0.0 && out[number * WIDTH + j].is_nan();
        let mut rows = (0..WIDTH).filter(|j| is_open(*j)).fold(0_u32, |rows, j| rows | 1 << j);
        while let Some(first) = ones(rows).next() {
            let wants @ [kind, u, v] = row(&wanted, first);
            let alike = ones(rows).filter(|j| row(&wanted, *j) == wants).fold(0, |alike, j| alike | 1 << j);
            rows ^= alike;
            // Of a lobe that is nothing the first rule.
            let rules = [u, v].map(|rule| rule.max(0.0) as usize);
            let nodes = match kept.take() {
                Some(nodes) if nodes.rules == rules => nodes,
                _ => self.grid.nodes(rules),
            };
            let nodes = kept.insert(nodes);
            let sum = if kind == FACETS { sums::<true> } else { sums::<false> };
            let sums = sum(level, self, at, lobes.block(number), nodes.all());
            for j in ones(alike) {
                let own = lobe(number, j);
                out[number * WIDTH + j] = sums[usize::from(own.is_edge())][j];
                // Both halves of a reflectance come together.
                if place + 1 < lobes.places() && own.is_followed_by(&lobe(number + stride, j)) {
                    out[(number + stride) * WIDTH + j] = sums[1][j];
                }
            }
        }
    }

    /// From a receiver to the grid's middle, and the light's plane before it.
    #[inline(always)]
    fn before(&self, from: Vec3, normal: Vec3) -> (Vec3, Before) {
        let toward = self.grid.middle - from;
        let height = self.normal.dot(toward);
        let axis = if height < 0.0 { -self.normal } else { self.normal };
        (toward, Before { normal, axis, height: height.abs() })
    }
}

/// Kinds of lobes that a grid is enough for; zero are others.
const COSINE: f32 = 1.0;
const FACETS: f32 = 2.0;

/// The kind of a lobe, and the rules that it needs.
struct Wanted(Shared);

impl Lane<9, 8, 3> for Wanted {
    #[inline(always)]
    fn value(&self, at: [f32; 9], lobe: [f32; 8]) -> [f32; 3] {
        let Self(light) = self;
        let [x, y, z, u, v, w, ..] = at;
        let (from, normal) = (Vec3::new(x, y, z), Vec3::new(u, v, w));
        let lobe: PackedLobe = bytemuck::cast(lobe);
        let is_facets = lobe.kind >= PackedLobe::MICROFACETS_F0;
        let (toward, before) = light.before(from, normal);
        let corners = light.grid.corners.map(|p| p - from);
        let lowest = |n: Vec3| {
            let [a, b, c, d] = corners.map(|p| n.dot(p));
            smaller(smaller(a, b), smaller(c, d))
        };
        // Not the far side, and no horizon that cuts the light: powers end at one of their own.
        let is_before = light.is_two_sided | (light.normal.dot(toward) < 0.0);
        let is_whole = (lowest(normal) > 0.0) & (is_facets | (lobe.exponent >= STEEP) | (lowest(lobe.axis) > 0.0));
        let [u, v] = rules(corners, &Shape::new(before, &lobe));
        let is_enough = (u < NONE as f32) & (v < NONE as f32);
        let counts = (lobe.kind < PackedLobe::MICROFACETS_GRAIN) & (lobe.flux != Vec3::ZERO);
        let kind = if is_facets { FACETS } else { COSINE };
        [if is_before & is_whole & is_enough & counts { kind } else { 0.0 }, u, v]
    }
}

/// The sums over nodes for all lobes of a block, which are of one kind where they count: of microfacets both parts.
#[inline(never)]
fn sums<const IS_FACETS: bool>(
    level: Level,
    light: &Shared,
    at: &Columns<9>,
    lobes: &Columns<8>,
    nodes: &[Node],
) -> Columns<2> {
    let mut seen = [[0.0; WIDTH]; 12];
    map(level, &ToNodes::<IS_FACETS>(*light), at, lobes, &mut seen);
    dispatch!(level, _simd => {
        let mut sums = [[0.0; WIDTH]; 2];
        for node in nodes {
            let [first, second] = &mut sums;
            for (j, (first, second)) in first.iter_mut().zip(second).enumerate() {
                let value = bytemuck::cast::<_, AtNode>(row(&seen, j)).value::<IS_FACETS>(node);
                *first += value[0];
                *second += value[1];
            }
        }
        sums
    })
}

struct ToNodes<const IS_FACETS: bool>(Shared);

impl<const IS_FACETS: bool> Lane<9, 8, 12> for ToNodes<IS_FACETS> {
    #[inline(always)]
    fn value(&self, [x, y, z, u, v, w, ..]: [f32; 9], lobe: [f32; 8]) -> [f32; 12] {
        let (toward, before) = self.0.before(Vec3::new(x, y, z), Vec3::new(u, v, w));
        bytemuck::cast(AtNode::new::<IS_FACETS>(toward, &before, &bytemuck::cast(lobe)))
    }
}

#[cfg(test)]
mod tests;
