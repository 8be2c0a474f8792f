//! The reflectance lobes of a tile's receivers, in columns.

use crate::lanes::{Columns, Kept, WIDTH, row, set_row};
use crate::{BrdfLobe, PackedLobe, Receiver, Tile};
use glam::Vec3;

/// Reflectance lobes of the receivers of a [`Tile`]: each receiver has as many places as any, of which some may be empty
/// (their flux is zero, as no lobe's is that counts).
#[derive(Clone, Debug, Default)]
pub struct TileLobes {
    blocks: usize,
    columns: Vec<Kept<8>>,
    /// One receiver's.
    buffer: Vec<BrdfLobe>,
}

impl TileLobes {
    /// So many places for the lobes of each receiver of a tile. Every block of every place is then to be
    /// [written](Self::block_mut).
    pub fn reset(&mut self, tile: &Tile, places: usize) {
        self.blocks = tile.blocks();
        self.columns.resize(self.blocks * places, Kept::default());
    }

    /// The `lobes` of each receiver, one after the other: for models that have nothing faster.
    ///
    /// # Panics
    /// When `of`, `at` and `tile` differ in length, or a number in `of` is not that of a material.
    pub fn one_by_one<B>(
        &mut self,
        materials: &[B],
        of: &[u32],
        at: &[Receiver],
        tile: &Tile,
        lobes: impl Fn(&B, &Receiver, &mut Vec<BrdfLobe>),
    ) {
        assert!(of.len() == at.len() && at.len() == tile.len(), "one material a receiver");
        self.reset(tile, 0);
        for (i, (material, at)) in of.iter().zip(at).enumerate() {
            self.buffer.clear();
            lobes(&materials[*material as usize], at, &mut self.buffer);
            let blocks = self.blocks * self.buffer.len();
            if self.columns.len() < blocks {
                // Empty places have no flux.
                self.columns.resize(blocks, Kept([[0.0; WIDTH]; 8]));
            }
            for (place, lobe) in self.buffer.iter().enumerate() {
                let row = bytemuck::cast(PackedLobe::from(*lobe));
                set_row(&mut self.columns[place * self.blocks + i / WIDTH].0, i % WIDTH, &row);
            }
        }
    }

    /// Writes the lobes of receiver `i` into its places: of a model that has nothing faster, among models that have. The tile has been
    /// [reset](Self::reset) to as many places as it needs.
    ///
    /// # Panics
    /// When there are more lobes than places, or there is no such receiver.
    pub fn set_row(&mut self, i: usize, lobes: impl FnOnce(&mut Vec<BrdfLobe>)) {
        self.buffer.clear();
        lobes(&mut self.buffer);
        assert!(self.buffer.len() <= self.places(), "{} lobes in {} places", self.buffer.len(), self.places());
        for (place, lobe) in self.buffer.iter().enumerate() {
            let row = bytemuck::cast(PackedLobe::from(*lobe));
            set_row(&mut self.columns[place * self.blocks + i / WIDTH].0, i % WIDTH, &row);
        }
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

    /// Columns of a block, a [`PackedLobe`] a row.
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

    /// Empties a place, by the row that [`of`](Self::of) gives: that lobe was summed elsewhere.
    ///
    /// # Panics
    /// When there is no such row.
    pub fn remove(&mut self, number: usize) {
        set_row(&mut self.columns[number / WIDTH].0, number % WIDTH, &[0.0; 8]);
    }

    /// The lobes of receiver `i`, in order, and the row of each, counted through all blocks.
    pub fn of(&self, i: usize) -> impl Iterator<Item = (usize, BrdfLobe)> {
        let (first, j) = (i / WIDTH, i % WIDTH);
        let blocks = (first..self.columns.len()).step_by(self.blocks.max(1));
        let lobes = blocks
            .map(move |block| (block * WIDTH + j, bytemuck::cast::<_, PackedLobe>(row(&self.columns[block].0, j))));
        lobes.filter(|(_, lobe)| lobe.flux != Vec3::ZERO).map(|(number, lobe)| (number, lobe.into()))
    }
}
