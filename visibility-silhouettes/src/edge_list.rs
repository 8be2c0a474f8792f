use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};

/// Edges that are taken at once.
pub(crate) const LANES: usize = 8;

/// Numbers of an edge: its two ends, the planes of the triangle that runs from the first end to the second and of the one
/// that runs back, and the bits of its number.
pub(crate) const COLUMNS: usize = 15;

/// Where each of them begins.
pub(crate) const ENDS: [usize; 2] = [0, 3];
pub(crate) const PLANES: [usize; 2] = [6, 10];
pub(crate) const ID: usize = 14;

/// Eight edges side by side.
pub(crate) type Block = [[f32; LANES]; COLUMNS];

/// Columns of numbers that are filled eight at a time; what is behind the last one is not read.
#[derive(Clone, Debug)]
pub(crate) struct Columns<const C: usize> {
    columns: [Vec<f32>; C],
    len: usize,
}

pub(crate) type EdgeList = Columns<COLUMNS>;

impl<const C: usize> Default for Columns<C> {
    fn default() -> Self {
        Self { columns: [const { Vec::new() }; C], len: 0 }
    }
}

impl<const C: usize> Columns<C> {
    pub(crate) fn clear(&mut self) {
        self.len = 0;
    }

    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Room for so many more.
    pub(crate) fn reserve(&mut self, count: usize) {
        let wanted = self.len + count + LANES;
        if self.columns[0].len() < wanted {
            self.columns.iter_mut().for_each(|column| column.resize(2 * wanted, 0.0));
        }
    }

    /// Eight of a column.
    #[inline(always)]
    pub(crate) fn load<S: Simd>(&self, simd: S, column: usize, first: usize) -> f32x8<S> {
        f32x8::from_slice(simd, &self.columns[column][first..first + LANES])
    }

    /// One of a column.
    pub(crate) fn get(&self, column: usize, index: usize) -> f32 {
        self.columns[column][index]
    }

    /// Which of the eight from `first` on are there, as bits.
    #[inline(always)]
    pub(crate) fn lanes(&self, first: usize) -> u32 {
        (1 << (self.len - first).min(LANES)) - 1
    }

    /// Appends those of eight that `keep` has; there must be room.
    #[inline(always)]
    pub(crate) fn append<S: Simd>(&mut self, keep: mask32x8<S>, values: &[f32x8<S>; C]) {
        for (column, value) in self.columns.iter_mut().zip(values) {
            value.compress(keep).store_slice(&mut column[self.len..self.len + LANES]);
        }
        self.len += keep.to_bitmask().count_ones() as usize;
    }
}
