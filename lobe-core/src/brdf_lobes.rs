//! Reflectance as lobes: what a material writes for one receiver, and the lobes of a tile's receivers in columns.

use crate::lanes::{Columns, Kept, WIDTH, row, set_row};
use crate::{BrdfLobe, PackedLobe, Receiver, Tile};
use glam::Vec3;

/// Reflectance as a sum of lobes of `f̃ = f_r·(n·v)` (Eq. 6), cosine included.
///
/// ```
/// use glam::Vec3;
/// use lobe_core::{BrdfLobe, BrdfLobes, Lobe, Receiver};
///
/// /// Reflects back to where the light came from.
/// struct Retro;
///
/// impl BrdfLobes for Retro {
///     fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
///         out.push(Lobe::new(at.view, 40.0, Vec3::splat(2.0)).times_cosine().into());
///     }
/// }
///
/// let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::new(0.6, 0.0, 0.8));
/// let mut lobes = Vec::new();
/// Retro.brdf_lobes(&at, &mut lobes);
/// let toward_eye = lobes[0].eval_at(at.normal, at.view).x; // 2·(n·v)
/// assert!((toward_eye - 1.6).abs() < 1e-5);
/// ```
pub trait BrdfLobes {
    /// Appends the lobes of `f̃` as seen from `at.view`. All of them are to be understood as zero below the horizon of
    /// `at.normal`. A Lambert lobe has exponent 1 and *exactly* `at.normal` as its axis: integrators know it by that.
    fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>);

    /// The same by cosine lobes alone, for methods with visibility as lobes: products have closed forms for no others. Provided: the lobe
    /// of a mirror in the place of each lobe of microfacets. A model that knows nearer ones overrides it.
    fn cosine_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        let first = out.len();
        self.brdf_lobes(at, out);
        out[first..].iter_mut().for_each(|lobe| *lobe = lobe.cosine_lobe(at.normal).into());
    }

    /// The lobes of all receivers of a tile, receiver `i` of material `of[i]`. Provided: one receiver after the other. A set of
    /// models that has something faster overrides it; the lobes are to be the same, in the same order, bit for bit.
    ///
    /// # Panics
    /// When `of`, `at` and `tile` differ in length, or a number in `of` is not that of a material.
    fn tile_lobes(materials: &[Self], of: &[u32], at: &[Receiver], tile: &Tile, out: &mut TileLobes)
    where
        Self: Sized,
    {
        out.one_by_one(materials, of, at, tile, Self::brdf_lobes);
    }

    /// The same of [`cosine_lobes`](Self::cosine_lobes).
    ///
    /// # Panics
    /// As [`tile_lobes`](Self::tile_lobes).
    fn tile_cosine_lobes(materials: &[Self], of: &[u32], at: &[Receiver], tile: &Tile, out: &mut TileLobes)
    where
        Self: Sized,
    {
        out.one_by_one(materials, of, at, tile, Self::cosine_lobes);
    }
}

impl<B: BrdfLobes + ?Sized> BrdfLobes for Box<B> {
    fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        (**self).brdf_lobes(at, out);
    }

    fn cosine_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        (**self).cosine_lobes(at, out);
    }
}

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

    /// The `lobes` of each receiver, one after the other: [`BrdfLobes::tile_lobes`] of models that have nothing faster.
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

// Object-safe.
const _: fn(&dyn BrdfLobes) = |_| {};
