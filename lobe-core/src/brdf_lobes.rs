//! Reflectance as lobes: what a material writes for one receiver, and the lobes of a tile's receivers in columns.

use crate::lanes::{Columns, Kept, WIDTH, row, set_row};
use crate::{Lobe, LobeBuffer, LobeWriter, Receiver, Tile};
use glam::Vec3;

/// Reflectance as a sum of lobes of `f̃ = f_r·(n·v)` (Eq. 6), cosine included.
///
/// ```
/// use glam::Vec3;
/// use lobe_core::{BrdfLobes, Lobe, LobeBuffer, LobeWriter, Receiver};
///
/// /// Reflects back to where the light came from.
/// struct Retro;
///
/// impl BrdfLobes for Retro {
///     fn brdf_lobes(&self, at: &Receiver, out: &mut LobeWriter<'_>) {
///         out.push(Lobe::new(at.view, 40.0, Vec3::splat(2.0)).times_cosine());
///     }
/// }
///
/// let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::new(0.6, 0.0, 0.8));
/// let mut buffer = LobeBuffer::default();
/// Retro.brdf_lobes(&at, &mut buffer.writer());
/// let toward_eye = buffer.lobes().eval(at.normal, at.view).x; // 2·(n·v)
/// assert!((toward_eye - 1.6).abs() < 1e-5);
/// ```
pub trait BrdfLobes {
    /// Appends the lobes of `f̃` as seen from `at.view`. All of them are to be understood as zero below the horizon of
    /// `at.normal`. A Lambert lobe has exponent 1 and *exactly* `at.normal` as its axis: integrators know it by that. Lobes of
    /// [microfacets](Lobe::microfacets) only where [`takes_microfacets`](LobeWriter::takes_microfacets) says so.
    fn brdf_lobes(&self, at: &Receiver, out: &mut LobeWriter<'_>);

    /// The lobes of all receivers of a tile, receiver `i` of material `of[i]`. Provided: one receiver after the other. A set of
    /// models that has something faster overrides it; the lobes are to be the same, in the same order, bit for bit.
    ///
    /// # Panics
    /// When `of`, `at` and `tile` differ in length, or a number in `of` is not that of a material.
    fn tile_lobes(materials: &[Self], of: &[u32], at: &[Receiver], tile: &Tile, out: &mut TileLobes)
    where
        Self: Sized,
    {
        out.one_by_one(materials, of, at, tile);
    }
}

impl<B: BrdfLobes + ?Sized> BrdfLobes for Box<B> {
    fn brdf_lobes(&self, at: &Receiver, out: &mut LobeWriter<'_>) {
        (**self).brdf_lobes(at, out);
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

    /// See [`LobeWriter::takes_microfacets`].
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

    /// The lobes of each receiver, one after the other: [`BrdfLobes::tile_lobes`] of models that have nothing faster.
    ///
    /// # Panics
    /// When `of`, `at` and `tile` differ in length, or a number in `of` is not that of a material.
    pub fn one_by_one<B: BrdfLobes>(&mut self, materials: &[B], of: &[u32], at: &[Receiver], tile: &Tile) {
        assert!(of.len() == at.len() && at.len() == tile.len(), "one material a receiver");
        self.reset(tile, 0);
        for (i, (material, at)) in of.iter().zip(at).enumerate() {
            materials[*material as usize].brdf_lobes(at, &mut self.buffer.writer_of(self.takes_microfacets));
            let lobes = self.buffer.lobes();
            let blocks = self.blocks * lobes.len();
            if self.columns.len() < blocks {
                // Empty places have no flux.
                self.columns.resize(blocks, Kept([[0.0; WIDTH]; 8]));
            }
            for (place, lobe) in lobes.iter().enumerate() {
                set_row(&mut self.columns[place * self.blocks + i / WIDTH].0, i % WIDTH, &bytemuck::cast(lobe));
            }
        }
    }

    /// Writes the lobes of receiver `i` into its places: of a model that has nothing faster, among models that have. The tile has been
    /// [reset](Self::reset) to as many places as the model needs.
    ///
    /// # Panics
    /// When it writes more lobes than there are places, or there is no such receiver.
    pub fn set_row(&mut self, i: usize, at: &Receiver, material: &(impl BrdfLobes + ?Sized)) {
        material.brdf_lobes(at, &mut self.buffer.writer_of(self.takes_microfacets));
        let lobes = self.buffer.lobes();
        assert!(lobes.len() <= self.places(), "{} lobes in {} places", lobes.len(), self.places());
        for (place, lobe) in lobes.iter().enumerate() {
            set_row(&mut self.columns[place * self.blocks + i / WIDTH].0, i % WIDTH, &bytemuck::cast(lobe));
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

// Object-safe.
const _: fn(&dyn BrdfLobes) = |_| {};
