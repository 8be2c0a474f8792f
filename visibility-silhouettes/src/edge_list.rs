use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};
use lobe_core::vec3x8::{LANES, Vec3x8};

/// Number of columns of an edge: its two ends, the planes of the triangle that runs from the first end to the second and of the
/// triangle that runs back, and the bits of the edge's number.
pub(crate) const COLUMNS: usize = 15;
/// First columns of the ends and of the planes.
pub(crate) const ENDS: [usize; 2] = [0, 3];
pub(crate) const PLANES: [usize; 2] = [6, 10];
pub(crate) const ID: usize = 14;
/// Mark in an edge's number: the edge is drawn for some of the receivers only.
pub(crate) const SOMETIMES: u32 = 1 << 31;
/// Mark in an edge's number: the edge belongs to a simplified form.
pub(crate) const COARSE: u32 = 1 << 30;
/// That the surface it is on has no border.
pub(crate) const CLOSED: u32 = 1 << 29;
pub(crate) const MARKS: u32 = SOMETIMES | COARSE | CLOSED;

/// Columns of eight items side by side.
pub(crate) type Block<const C: usize> = [[f32; LANES]; C];

/// Items of a few numbers each, eight side by side; values behind the last item are not read.
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

    pub(crate) fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Makes room for `count` more items.
    #[inline(always)]
    pub(crate) fn reserve(&mut self, count: usize) {
        let wanted = self.len + count + LANES;
        if self.columns[0].len() < wanted {
            self.grow(wanted.next_power_of_two());
        }
    }

    #[cold]
    fn grow(&mut self, len: usize) {
        self.columns.iter_mut().for_each(|column| column.resize(len, 0.0));
    }

    /// Eight values of a column.
    #[inline(always)]
    pub(crate) fn load<S: Simd>(&self, simd: S, column: usize, first: usize) -> f32x8<S> {
        f32x8::from_slice(simd, &self.columns[column][first..first + LANES])
    }

    /// Eight values of three columns.
    #[inline(always)]
    pub(crate) fn load3<S: Simd>(&self, simd: S, column: usize, first: usize) -> Vec3x8<S> {
        Vec3x8::new(
            self.load(simd, column, first),
            self.load(simd, column + 1, first),
            self.load(simd, column + 2, first),
        )
    }

    /// One value of a column.
    pub(crate) fn get(&self, column: usize, index: usize) -> f32 {
        self.columns[column][index]
    }

    /// The items that exist among the eight from `first` on, as bits.
    #[inline(always)]
    pub(crate) fn lanes(&self, first: usize) -> u32 {
        (1 << (self.len - first).min(LANES)) - 1
    }

    /// Appends one column of the items in `keep`; there must be room. Call it for all columns, then [`end`](Self::end).
    #[inline(always)]
    pub(crate) fn put<S: Simd>(&mut self, column: usize, keep: mask32x8<S>, value: f32x8<S>) {
        let len = self.len;
        value.compress(keep).store_slice(&mut self.columns[column][len..len + LANES]);
    }

    #[inline(always)]
    pub(crate) fn put3<S: Simd>(&mut self, column: usize, keep: mask32x8<S>, value: Vec3x8<S>) {
        self.put(column, keep, value.x);
        self.put(column + 1, keep, value.y);
        self.put(column + 2, keep, value.z);
    }

    /// Appends one item.
    pub(crate) fn push(&mut self, numbers: [f32; C]) {
        self.reserve(1);
        let len = self.len;
        self.columns.iter_mut().zip(numbers).for_each(|(column, number)| column[len] = number);
        self.len += 1;
    }

    #[inline(always)]
    pub(crate) fn end<S: Simd>(&mut self, keep: mask32x8<S>) {
        self.len += keep.to_bitmask().count_ones() as usize;
    }
}

/// Eight edges in any storage.
pub(crate) trait EdgePacket {
    fn column<S: Simd>(&self, simd: S, column: usize) -> f32x8<S>;
}

impl EdgePacket for Block<COLUMNS> {
    #[inline(always)]
    fn column<S: Simd>(&self, simd: S, column: usize) -> f32x8<S> {
        f32x8::simd_from(simd, self[column])
    }
}

impl EdgePacket for (&EdgeList, usize) {
    #[inline(always)]
    fn column<S: Simd>(&self, simd: S, column: usize) -> f32x8<S> {
        self.0.load(simd, column, self.1)
    }
}
