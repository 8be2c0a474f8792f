//! Receivers that are shaded together, and what they exchange, in columns.

use crate::lanes::{Columns, Kept, Lane, Level, WIDTH, map, row, set_row};
use crate::{Cone, Lobe, Receiver, Sphere};
use glam::Vec3;

/// Position, normal and view of receivers, sixteen to a block.
///
/// The rows of the last block that are too many repeat the last receiver.
#[derive(Clone, Debug, Default)]
pub struct Tile {
    blocks: Vec<Kept<9>>,
    len: usize,
}

impl Tile {
    /// Takes other receivers.
    pub fn set(&mut self, receivers: &[Receiver]) {
        self.len = receivers.len();
        self.blocks.resize(self.len.div_ceil(WIDTH), Kept::default());
        let set = |block: &mut Kept<9>, receivers: &[Receiver; WIDTH]| {
            for (j, r) in receivers.iter().enumerate() {
                let (p, n, v) = (r.position, r.normal, r.view);
                set_row(&mut block.0, j, &[p.x, p.y, p.z, n.x, n.y, n.z, v.x, v.y, v.z]);
            }
        };
        let (full, rest) = receivers.as_chunks();
        self.blocks.iter_mut().zip(full).for_each(|(block, receivers)| set(block, receivers));
        if let (Some(block), [.., last]) = (self.blocks.get_mut(full.len()), rest) {
            set(block, &core::array::from_fn(|j| *rest.get(j).unwrap_or(last)));
        }
    }

    /// Number of receivers.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// True when there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Number of blocks.
    #[must_use]
    pub fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// Columns of a block: position, normal, view.
    ///
    /// # Panics
    /// When `block` is not below [`blocks`](Self::blocks).
    #[must_use]
    pub fn block(&self, block: usize) -> &Columns<9> {
        &self.blocks[block].0
    }

    /// A ball around the box of the receivers' positions.
    #[must_use]
    pub fn ball(&self) -> Sphere {
        let positions = || self.blocks.iter().map(|block| &block.0);
        let extreme = |c: usize, start: f32, better: fn(f32, f32) -> bool| {
            let mut best = [start; WIDTH];
            for block in positions() {
                for (best, x) in best.iter_mut().zip(&block[c]) {
                    *best = if better(*x, *best) { *x } else { *best };
                }
            }
            best.into_iter().fold(start, |a, b| if better(b, a) { b } else { a })
        };
        if self.is_empty() {
            return Sphere::default();
        }
        let low = Vec3::from_array([0, 1, 2].map(|c| extreme(c, f32::INFINITY, |a, b| a < b)));
        let high = Vec3::from_array([0, 1, 2].map(|c| extreme(c, f32::NEG_INFINITY, |a, b| a > b)));
        let center = 0.5 * (low + high);
        let mut square = [0.0; WIDTH];
        for [x, y, z, ..] in positions() {
            for (j, square) in square.iter_mut().enumerate() {
                let d = (Vec3::new(x[j], y[j], z[j]) - center).length_squared();
                *square = if d > *square { d } else { *square };
            }
        }
        let radius = square.into_iter().fold(0.0, f32::max).sqrt();
        Sphere { center, radius: radius * 1.000_01 }
    }
}

/// A ball of light as the receivers of a [`Tile`] see it.
#[derive(Clone, Debug, Default)]
pub struct TileLight {
    cones: Vec<Kept<5>>,
    pub(crate) seen: Vec<Kept<10>>,
}

impl TileLight {
    /// Takes another light or other receivers: the cones are those of [`Cone::of_sphere`], bit for bit.
    pub fn set(&mut self, tile: &Tile, ball: Sphere) {
        let level = Level::new();
        self.cones.resize(tile.blocks(), Kept::default());
        for (at, cones) in tile.blocks.iter().zip(&mut self.cones) {
            map(level, &ToCone(ball), &at.0, &[], &mut cones.0);
        }
        self.see(level, tile);
    }

    fn see(&mut self, level: Level, tile: &Tile) {
        self.seen.resize(tile.blocks(), Kept::default());
        for ((at, cones), seen) in tile.blocks.iter().zip(&self.cones).zip(&mut self.seen) {
            map(level, &ToSeen, &at.0, &cones.0, &mut seen.0);
        }
    }

    /// Any cones.
    #[cfg(test)]
    pub(crate) fn of_cones(tile: &Tile, cones: &[Cone]) -> Self {
        let mut light = Self { cones: vec![Kept::default(); tile.blocks()], seen: Vec::new() };
        for (i, cone) in cones.iter().enumerate() {
            set_row(&mut light.cones[i / WIDTH].0, i % WIDTH, &bytemuck::cast(*cone));
        }
        light.see(Level::new(), tile);
        light
    }

    /// The cone that receiver `i` sees.
    ///
    /// # Panics
    /// When the tile has no such receiver's block.
    #[must_use]
    pub fn cone(&self, i: usize) -> Cone {
        bytemuck::cast(row(&self.cones[i / WIDTH].0, i % WIDTH))
    }
}

struct ToCone(Sphere);
impl Lane<9, 0, 5> for ToCone {
    #[inline(always)]
    fn value(&self, [x, y, z, ..]: [f32; 9], []: [f32; 0]) -> [f32; 5] {
        bytemuck::cast(Cone::of_sphere(Vec3::new(x, y, z), self.0))
    }
}

struct ToSeen;
impl Lane<9, 5, 10> for ToSeen {
    #[inline(always)]
    fn value(&self, [_, _, _, x, y, z, ..]: [f32; 9], cone: [f32; 5]) -> [f32; 10] {
        bytemuck::cast(crate::cap::Seen::new(Vec3::new(x, y, z), &bytemuck::cast(cone)))
    }
}

/// Reflectance lobes of the receivers of a [`Tile`]: each receiver has as many places as any, of which some may be empty
/// (their flux is zero, as no lobe's is that counts).
#[derive(Clone, Debug, Default)]
pub struct TileLobes {
    blocks: usize,
    columns: Vec<Kept<8>>,
}

impl TileLobes {
    /// So many places for the lobes of each receiver of a tile. Every block of every place is then to be
    /// [written](Self::block_mut).
    pub fn reset(&mut self, tile: &Tile, places: usize) {
        self.blocks = tile.blocks();
        self.columns.resize(self.blocks * places, Kept::default());
    }

    /// Number of blocks, of all places together: those of the first place come first.
    #[must_use]
    pub fn blocks(&self) -> usize {
        self.columns.len()
    }

    /// Number of places of each receiver.
    #[must_use]
    pub fn places(&self) -> usize {
        self.columns.len() / self.blocks.max(1)
    }

    /// Number of blocks of one place.
    #[must_use]
    pub fn blocks_of_place(&self) -> usize {
        self.blocks
    }

    /// Columns of a block, a [`Lobe`] a row.
    ///
    /// # Panics
    /// When there is no such place or block.
    pub fn block_mut(&mut self, place: usize, block: usize) -> &mut Columns<8> {
        assert!(block < self.blocks, "a block of the tile");
        &mut self.columns[place * self.blocks + block].0
    }

    /// Block `number` of all.
    ///
    /// # Panics
    /// When `number` is not below [`blocks`](Self::blocks).
    #[must_use]
    pub fn block(&self, number: usize) -> &Columns<8> {
        &self.columns[number].0
    }

    /// The lobes of receiver `i`, in order, and the row of each, counted through all blocks.
    pub fn of(&self, i: usize) -> impl Iterator<Item = (usize, Lobe)> {
        let (first, j) = (i / WIDTH, i % WIDTH);
        let blocks = (first..self.columns.len()).step_by(self.blocks.max(1));
        let lobes =
            blocks.map(move |block| (block * WIDTH + j, bytemuck::cast::<_, Lobe>(row(&self.columns[block].0, j))));
        lobes.filter(|(_, lobe)| lobe.flux != Vec3::ZERO)
    }
}
