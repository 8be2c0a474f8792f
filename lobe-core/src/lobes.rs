use crate::{Lobe, PackedLobe};
use glam::Vec3;

/// Columns of a lobe sum, one entry a lobe: those of [`PackedLobe`].
const COLUMNS: usize = 8;

/// A sum of lobes in the caller's storage, read-only: structure of arrays.
#[derive(Clone, Copy, Debug)]
pub struct Lobes<'a> {
    columns: [&'a [f32]; COLUMNS],
}

impl<'a> Lobes<'a> {
    /// Number of lobes.
    #[must_use]
    pub fn len(&self) -> usize {
        self.columns[0].len()
    }

    /// True when the sum has no lobe, hence is zero.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The lobe at `index`.
    ///
    /// # Panics
    /// When `index` is not below [`len`](Self::len).
    #[must_use]
    pub fn get(&self, index: usize) -> Lobe {
        let c = |k: usize| self.columns[k][index];
        let (axis, flux) = (Vec3::new(c(0), c(1), c(2)), Vec3::new(c(4), c(5), c(6)));
        Lobe { axis, exponent: c(3), flux, has_cosine: c(7) == PackedLobe::COSINE }
    }

    /// Axis x, y, z, exponent, flux of three channels, kind.
    pub(crate) const fn columns(&self) -> [&'a [f32]; COLUMNS] {
        self.columns
    }

    /// Some of the lobes.
    ///
    /// # Panics
    /// When `range` is not inside the sum.
    #[must_use]
    pub fn range(&self, range: core::ops::Range<usize>) -> Self {
        Self { columns: self.columns.map(|column| &column[range.clone()]) }
    }

    /// All lobes in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Lobe> + use<'a> {
        let s = *self;
        (0..self.len()).map(move |i| s.get(i))
    }

    /// Value of the sum in the unit direction `v`, receiver's cosine with respect to `normal` included.
    #[must_use]
    pub fn eval(&self, normal: Vec3, v: Vec3) -> Vec3 {
        self.iter().map(|l| l.eval_at(normal, v)).sum()
    }
}

/// Writes a sum of lobes into a [`LobeBuffer`].
#[derive(Debug)]
pub struct LobeWriter<'a> {
    columns: &'a mut [Vec<f32>; COLUMNS],
}

impl LobeWriter<'_> {
    /// Number of lobes so far.
    #[must_use]
    pub fn len(&self) -> usize {
        self.columns[0].len()
    }

    /// True while the sum has no lobe.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Appends a lobe.
    pub fn push(&mut self, lobe: Lobe) {
        let values: [f32; COLUMNS] = bytemuck::cast(PackedLobe::from(lobe));
        for (column, value) in self.columns.iter_mut().zip(values) {
            column.push(value);
        }
    }
}

impl Extend<Lobe> for LobeWriter<'_> {
    fn extend<T: IntoIterator<Item = Lobe>>(&mut self, lobes: T) {
        lobes.into_iter().for_each(|lobe| self.push(lobe));
    }
}

/// Storage for a lobe sum, one a thread. It keeps its memory when it is written anew, so that only the first points allocate.
///
/// ```
/// use lobe_core::{Lobe, LobeBuffer};
/// let mut buffer = LobeBuffer::default();
/// buffer.writer().push(Lobe::default());
/// assert_eq!(buffer.lobes().len(), 1);
/// ```
#[derive(Clone, Debug, Default)]
pub struct LobeBuffer {
    columns: [Vec<f32>; COLUMNS],
}

impl LobeBuffer {
    /// Empties the sum.
    pub fn clear(&mut self) {
        self.columns.iter_mut().for_each(Vec::clear);
    }

    /// Empties the sum and returns the view to write it anew.
    pub fn writer(&mut self) -> LobeWriter<'_> {
        self.clear();
        LobeWriter { columns: &mut self.columns }
    }

    /// The sum.
    #[must_use]
    pub fn lobes(&self) -> Lobes<'_> {
        Lobes { columns: core::array::from_fn(|k| self.columns[k].as_slice()) }
    }
}

impl From<Lobe> for LobeBuffer {
    fn from(lobe: Lobe) -> Self {
        let mut buffer = Self::default();
        buffer.writer().push(lobe);
        buffer
    }
}
