//! Visible fractions between the receivers of a tile, interpolated where nothing can hide between them.

use crate::{Coverage, LightVisibility, TileContributions, TileInteraction, Visibility};
use core::ops::Range;
use glam::Vec3;
use lobe_core::{BrdfLobe, Sphere};

/// Receivers a row.
const SIDE: usize = 8;
/// A block is interpolated where no penumbra is narrower than its diagonal: its corners and its middle are half of that apart.
const NARROW: f32 = 1.0;
/// And where the fractions at its corners differ by so many times the allowed error at most.
const SPREAD: f32 = 12.0;
/// The largest exponent times `1 − cos θ` of a lobe that counts as even over a light.
const EVEN: f32 = 0.25;
/// The least cosine between two normals of a block.
const ALONG: f32 = 0.7;

/// The visible fractions of a tile, 8 rows of 8 receivers on one face.
pub(crate) struct Blocks {
    unshadowed: [Vec3; Self::COUNT],
    fractions: [Vec3; Self::COUNT],
    /// Receivers with a query of their own, as bits.
    queried: u64,
}

/// Columns and rows of a block's corners.
type Block = [usize; 4];

impl Blocks {
    pub(crate) const COUNT: usize = SIDE * SIDE;

    /// None if something else than blockers may part two neighbours: another face, a horizon through the light, or a lobe that is
    /// narrower than it.
    pub(crate) fn new(tile: &TileInteraction<'_>, out: &TileContributions) -> Option<Self> {
        let first = tile.at[0];
        let unshadowed = core::array::from_fn(|i| out.radiance(i));
        let is_even = |i: usize| {
            let (at, seen) = (&tile.at[i], tile.light.seen_by(i));
            let cone = seen.cone;
            at.object == first.object
                && at.face == first.face
                && at.normal.dot(first.normal) > ALONG
                && unshadowed[i].max_element() > 0.0
                && seen.outline.is_none()
                && at.normal.dot(cone.axis).min(at.face.dot(cone.axis)) > cone.sin_sq().sqrt()
                && tile.lobes.of(i).all(|(_, lobe)| exponent(&lobe, at.normal) * cone.one_minus_cos <= EVEN)
        };
        (0..Self::COUNT).all(is_even).then_some(Self { unshadowed, fractions: [Vec3::ONE; Self::COUNT], queried: 0 })
    }

    /// Sets the contributions of all receivers; `ask` sets that of one by its own mask.
    pub(crate) fn spread<V: Visibility + ?Sized>(
        &mut self,
        tile: &TileInteraction<'_>,
        visibility: &mut LightVisibility<'_, V>,
        ask: &mut impl FnMut(usize, &mut LightVisibility<'_, V>, &mut TileContributions),
        out: &mut TileContributions,
    ) {
        let mut blocks: Vec<Block> = Vec::with_capacity(32);
        blocks.push([0, 0, SIDE - 1, SIDE - 1]);
        let mut even: Vec<(Block, [Vec3; 4])> = Vec::new();
        while let Some(block) = blocks.pop() {
            let [left, top, right, bottom] = block;
            let (x, y) = ((left + right).div_ceil(2), (top + bottom).div_ceil(2));
            let is_pair = right - left < 2 && bottom - top < 2;
            let width = if is_pair { 0.0 } else { self.narrowest(tile, block, visibility) };
            if width == f32::INFINITY {
                // All see the same.
                let fraction = self.get(place(left, top), visibility, ask, out);
                even.push((block, [fraction; 4]));
                continue;
            }
            let corners = [place(left, top), place(right, top), place(left, bottom), place(right, bottom)];
            let fractions = corners.map(|i| self.get(i, visibility, ask, out));
            if is_pair {
                continue;
            }
            let [low, high] = [Vec3::min, Vec3::max].map(|f| fractions.into_iter().reduce(f).unwrap_or_default());
            let is_smooth = diagonal(tile, block) <= NARROW * width
                && (high - low).max_element() <= SPREAD * tile.slack
                && (self.get(place(x, y), visibility, ask, out) - mix(block, &fractions, [x, y])).abs().max_element()
                    <= tile.slack;
            if is_smooth {
                even.push((block, fractions));
                continue;
            }
            let split = |low: usize, middle: usize, high: usize| {
                if high - low < 2 { [Some([low, high]), None] } else { [Some([low, middle]), Some([middle, high])] }
            };
            for [top, bottom] in split(top, y, bottom).into_iter().flatten() {
                for [left, right] in split(left, x, right).into_iter().flatten() {
                    blocks.push([left, top, right, bottom]);
                }
            }
        }
        for (block, corners) in &even {
            let [left, top, right, bottom] = *block;
            for (row, column) in (top..=bottom).flat_map(|row| (left..=right).map(move |column| (row, column))) {
                let i = place(column, row);
                if self.queried & 1 << i == 0 {
                    self.fractions[i] = mix(*block, corners, [column, row]);
                    out.set(i, self.unshadowed[i] * self.fractions[i], [0, 0]);
                }
            }
        }
    }

    /// Coverages of some receivers, without those that had a query.
    pub(crate) fn interpolated(&self, of: Range<usize>) -> impl Iterator<Item = Coverage> {
        of.filter(|i| self.queried & 1 << i == 0).map(|i| match self.fractions[i] {
            Vec3::ONE => Coverage::Lit,
            Vec3::ZERO => Coverage::Dark,
            _ => Coverage::Partial,
        })
    }

    fn get<V: Visibility + ?Sized>(
        &mut self,
        i: usize,
        visibility: &mut LightVisibility<'_, V>,
        ask: &mut impl FnMut(usize, &mut LightVisibility<'_, V>, &mut TileContributions),
        out: &mut TileContributions,
    ) -> Vec3 {
        if self.queried & 1 << i == 0 {
            self.queried |= 1 << i;
            ask(i, visibility, out);
            let (radiance, unshadowed) = (out.radiance(i), self.unshadowed[i]);
            let fraction = |c: usize| if unshadowed[c] > 0.0 { radiance[c] / unshadowed[c] } else { 1.0 };
            self.fractions[i] = Vec3::new(fraction(0), fraction(1), fraction(2));
        }
        self.fractions[i]
    }

    /// The width of the narrowest penumbra on a block.
    fn narrowest<V: Visibility + ?Sized>(
        &self,
        tile: &TileInteraction<'_>,
        block: Block,
        visibility: &mut LightVisibility<'_, V>,
    ) -> f32 {
        let corners = positions(tile, block);
        let center = 0.25 * corners.iter().sum::<Vec3>();
        let radius = corners.into_iter().map(|p| p.distance(center)).fold(0.0, f32::max);
        visibility.narrowest_penumbra(&tile.at[place(block[0], block[1])], Sphere { center, radius: 1.000_1 * radius })
    }
}

/// The corners of a block, opposite ones at 0 and 3.
fn positions(tile: &TileInteraction<'_>, [left, top, right, bottom]: Block) -> [Vec3; 4] {
    [place(left, top), place(right, top), place(left, bottom), place(right, bottom)].map(|i| tile.at[i].position)
}

fn diagonal(tile: &TileInteraction<'_>, block: Block) -> f32 {
    let [a, b, c, d] = positions(tile, block);
    a.distance(d).max(b.distance(c))
}

fn place(column: usize, row: usize) -> usize {
    row * SIDE + column
}

/// Between the corners of a block.
fn mix([left, top, right, bottom]: Block, corners: &[Vec3; 4], [column, row]: [usize; 2]) -> Vec3 {
    let part = |low: usize, high: usize, at: usize| (at - low) as f32 / (high - low).max(1) as f32;
    let (s, t) = (part(left, right, column), part(top, bottom, row));
    corners[0].lerp(corners[1], s).lerp(corners[2].lerp(corners[3], s), t)
}

/// The exponent of a lobe, or of the one that stands for it.
fn exponent(lobe: &BrdfLobe, normal: Vec3) -> f32 {
    lobe.cosine_lobe(normal).exponent
}
