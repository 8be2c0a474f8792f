use std::ops::Range;

/// A rectangle of an image: all of it, or the part that one of several runs makes.
///
/// ```
/// use pictures::Window;
/// let part = Window { image: [640, 360], columns: 0..640, rows: 0..120 };
/// assert_eq!((part.size(), part.is_whole()), ([640, 120], false));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Window {
    /// Width and height of the image.
    pub image: [usize; 2],
    /// Columns of the part.
    pub columns: Range<usize>,
    /// Rows of the part, from the top.
    pub rows: Range<usize>,
}

impl Window {
    /// All of an image.
    #[must_use]
    pub const fn whole(width: usize, height: usize) -> Self {
        Self { image: [width, height], columns: 0..width, rows: 0..height }
    }

    /// Width and height of the part.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        [self.columns.len(), self.rows.len()]
    }

    /// Whether it covers the whole image.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        *self == Self::whole(self.image[0], self.image[1])
    }
}
