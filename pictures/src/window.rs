use std::ops::Range;

/// A rectangle of an image: all of it, or the part that one of several runs makes.
///
/// ```
/// use pictures::Window;
/// let part = Window { image: [640, 360], columns: 0..640, rows: 0..120 };
/// assert_eq!((part.size(), part.is_whole()), ([640, 120], false));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
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

    /// The window cut into rectangles of at most so many columns and rows (1 at least), row by row. They are cut at multiples of these
    /// numbers in the image, so parts of windows that meet fit together.
    ///
    /// ```
    /// use pictures::Window;
    /// let parts: Vec<Window> = Window::whole(100, 40).parts([64, 32]).collect();
    /// assert_eq!(parts.len(), 4);
    /// assert_eq!((parts[1].columns.clone(), parts[3].size()), (64..100, [36, 8]));
    /// ```
    pub fn parts(&self, size: [usize; 2]) -> impl Iterator<Item = Self> + use<> {
        let [across, down] = size.map(|side| side.max(1));
        let cut = |range: &Range<usize>, step: usize| {
            let Range { start, end } = range.clone();
            (start / step..end.div_ceil(step)).map(move |k| (k * step).max(start)..((k + 1) * step).min(end))
        };
        let (image, columns) = (self.image, cut(&self.columns, across));
        cut(&self.rows, down)
            .flat_map(move |rows| columns.clone().map(move |columns| Self { image, columns, rows: rows.clone() }))
    }

    /// The number of its pixels.
    #[must_use]
    pub fn pixels(&self) -> usize {
        self.columns.len() * self.rows.len()
    }

    /// Whether it is a part of its image.
    #[must_use]
    pub fn is_inside(&self) -> bool {
        let inside = |range: &Range<usize>, size| range.start <= range.end && range.end <= size;
        inside(&self.columns, self.image[0]) && inside(&self.rows, self.image[1])
    }

    /// Whether a pixel is in both.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        let meet = |a: &Range<usize>, b: &Range<usize>| a.start.max(b.start) < a.end.min(b.end);
        meet(&self.columns, &other.columns) && meet(&self.rows, &other.rows)
    }

    /// Whether it covers the whole image.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        *self == Self::whole(self.image[0], self.image[1])
    }
}

#[cfg(test)]
mod tests {
    use super::Window;

    /// Every pixel is in one part, and no part is larger than requested.
    #[test]
    fn parts_cover_a_window_once() {
        let window = Window { image: [50, 40], columns: 3..47, rows: 5..33 };
        for size in [[1, 1], [8, 8], [16, 100], [44, 7], [0, 0]] {
            let mut seen = [[0; 50]; 40];
            for part in window.parts(size) {
                assert!(part.is_inside() && part.overlaps(&window) && part.pixels() > 0);
                assert!(part.size()[0] <= size[0].max(1) && part.size()[1] <= size[1].max(1));
                for row in part.rows.clone() {
                    seen[row][part.columns.clone()].iter_mut().for_each(|count| *count += 1);
                }
            }
            for (y, row) in seen.iter().enumerate() {
                for (x, count) in row.iter().enumerate() {
                    let inside = window.columns.contains(&x) && window.rows.contains(&y);
                    assert_eq!(*count, u32::from(inside), "{size:?}: {x} {y}");
                }
            }
        }
    }
}
