//! Receivers that are shaded together, and what they exchange, in columns.

use crate::lanes::{Columns, Kept, Lane, Level, WIDTH, map, row, set_row};
use crate::{BrdfLobes, Cone, LightTerm, Lobe, LobeBuffer, LobesFull, Outline, Receiver, Sphere};
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

/// A light as the receivers of a [`Tile`] see it.
#[derive(Clone, Debug, Default)]
pub struct TileLight {
    cones: Vec<Kept<5>>,
    pub(crate) seen: Vec<Kept<10>>,
    /// The same for all receivers, where `each` is empty.
    same: Vec3,
    each: Vec<Kept<3>>,
    /// Of flat lights, one a receiver; of others none.
    outlines: Vec<Option<Outline>>,
}

/// The radiance of a light toward the receivers of a tile.
#[derive(Clone, Copy, Debug)]
pub(crate) enum TileRadiance<'a> {
    Same(Vec3),
    Each(&'a [Kept<3>]),
}

impl TileLight {
    /// A ball of the same radiance toward all: the cones are those of [`Cone::of_sphere`], bit for bit.
    pub fn ball(&mut self, tile: &Tile, ball: Sphere, radiance: Vec3) {
        let level = Level::new();
        self.same = radiance;
        self.each.clear();
        self.outlines.clear();
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

    /// What each receiver sees.
    ///
    /// # Panics
    /// When there are not as many as receivers of the tile.
    pub fn one_by_one(&mut self, tile: &Tile, seen: impl IntoIterator<Item = LightTerm>) {
        self.outlines.clear();
        let mut is_flat = false;
        self.cones.resize(tile.blocks(), Kept::default());
        self.each.resize(tile.blocks(), Kept::default());
        let mut count = 0;
        for (i, term) in seen.into_iter().enumerate() {
            is_flat |= term.outline.is_some();
            let [.., x, y, z, _, _, _] = row(&tile.blocks[i / WIDTH].0, i % WIDTH);
            let LightTerm { cone, radiance, outline } = term.above(Vec3::new(x, y, z));
            self.outlines.push(outline);
            let last = if i + 1 == tile.len() { WIDTH } else { i % WIDTH + 1 };
            // The rows that are too many repeat the last one, as the tile's do.
            for j in i % WIDTH..last {
                set_row(&mut self.cones[i / WIDTH].0, j, &bytemuck::cast(cone));
                set_row(&mut self.each[i / WIDTH].0, j, &radiance.to_array());
            }
            count = i + 1;
        }
        assert_eq!(count, tile.len(), "one cone a receiver");
        if !is_flat {
            self.outlines.clear();
        }
        self.see(Level::new(), tile);
    }

    /// The light's radiance toward receiver `i`.
    ///
    /// # Panics
    /// When the tile has no such receiver's block.
    #[must_use]
    pub fn radiance(&self, i: usize) -> Vec3 {
        match self.radiances() {
            TileRadiance::Same(radiance) => radiance,
            TileRadiance::Each(each) => Vec3::from_array(row(&each[i / WIDTH].0, i % WIDTH)),
        }
    }

    /// All that receiver `i` sees of the light.
    ///
    /// # Panics
    /// When the tile has no such receiver.
    #[must_use]
    pub fn term(&self, i: usize) -> LightTerm {
        LightTerm { cone: self.cone(i), radiance: self.radiance(i), outline: self.outline(i).copied() }
    }

    /// What of its cone receiver `i` sees bright above its horizon, where that is not all.
    pub(crate) fn outline(&self, i: usize) -> Option<&Outline> {
        self.outlines.get(i)?.as_ref()
    }

    /// What of their cones receivers see bright above their horizons, of a flat light: none where it faces away. Empty of others.
    pub(crate) fn outlines(&self) -> &[Option<Outline>] {
        &self.outlines
    }

    pub(crate) fn radiances(&self) -> TileRadiance<'_> {
        if self.each.is_empty() { TileRadiance::Same(self.same) } else { TileRadiance::Each(&self.each) }
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
    /// One receiver's.
    buffer: LobeBuffer,
    takes_microfacets: bool,
}

impl TileLobes {
    /// Whether lobes of [microfacets](Lobe::microfacets) may be among them from now on; not at first.
    pub fn take_microfacets(&mut self, takes_microfacets: bool) {
        self.takes_microfacets = takes_microfacets;
    }

    /// See [`LobesMut::takes_microfacets`](crate::LobesMut::takes_microfacets).
    #[must_use]
    pub const fn takes_microfacets(&self) -> bool {
        self.takes_microfacets
    }

    /// So many places for the lobes of each receiver of a tile. Every block of every place is then to be
    /// [written](Self::block_mut).
    pub fn reset(&mut self, tile: &Tile, places: usize) {
        self.blocks = tile.blocks();
        self.columns.resize(self.blocks * places, Kept::default());
    }

    /// The lobes of each receiver, asked for one after the other: [`BrdfLobes::tile_lobes`] of models that have nothing faster.
    ///
    /// # Errors
    /// [`LobesFull`] when a material has more lobes than its `max_lobes`.
    ///
    /// # Panics
    /// When `of`, `at` and `tile` differ in length, or a number in `of` is not that of a material.
    pub fn one_by_one<B: BrdfLobes>(
        &mut self,
        materials: &[B],
        of: &[u32],
        at: &[Receiver],
        tile: &Tile,
    ) -> Result<(), LobesFull> {
        assert!(of.len() == at.len() && at.len() == tile.len(), "one material a receiver");
        let places = of.iter().map(|m| materials[*m as usize].max_lobes()).max().unwrap_or(0);
        self.reset(tile, places);
        self.columns.iter_mut().for_each(|block| block.0 = [[0.0; WIDTH]; 8]);
        if self.buffer.capacity() < places {
            self.buffer = LobeBuffer::with_capacity(places);
        }
        for (i, (material, at)) in of.iter().zip(at).enumerate() {
            let material = &materials[*material as usize];
            material.brdf_lobes(at, &mut self.buffer.writer_of(self.takes_microfacets))?;
            let lobes = self.buffer.lobes();
            if lobes.len() > material.max_lobes() {
                return Err(LobesFull);
            }
            for (place, lobe) in lobes.iter().enumerate() {
                set_row(&mut self.columns[place * self.blocks + i / WIDTH].0, i % WIDTH, &bytemuck::cast(lobe));
            }
        }
        Ok(())
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
