use glam::Vec2;

/// A square image of one bit a pixel; pixel `(i, j)` has its centre at `(i + ½, j + ½)`.
#[derive(Clone)]
pub(crate) struct BitImage {
    size: usize,
    /// 64-bit words a row.
    words: usize,
    data: Vec<u64>,
}

impl BitImage {
    pub(crate) fn new(size: usize) -> Self {
        let words = size.div_ceil(64);
        Self { size, words, data: vec![0; words * size] }
    }

    pub(crate) fn clear(&mut self) {
        self.data.fill(0);
    }

    pub(crate) fn get(&self, x: usize, y: usize) -> bool {
        self.data[y * self.words + x / 64] >> (x % 64) & 1 == 1
    }

    pub(crate) fn count(&self) -> u32 {
        self.data.iter().map(|word| word.count_ones()).sum()
    }

    /// Number of pixels in which two images of equal size differ.
    pub(crate) fn differences(&self, other: &Self) -> u32 {
        self.data.iter().zip(&other.data).map(|(a, b)| (a ^ b).count_ones()).sum()
    }

    /// Calls `each(cell, pixels set)` for the cells of four pixels of a row that have any.
    pub(crate) fn count_cells(&self, row: usize, mut each: impl FnMut(usize, u32)) {
        for (i, word) in self.data[row * self.words..(row + 1) * self.words].iter().enumerate() {
            if *word != 0 {
                (0..16).for_each(|k| each(16 * i + k, (word >> (4 * k) & 15).count_ones()));
            }
        }
    }

    /// Sets pixels `start..end` of a row.
    pub(crate) fn fill(&mut self, row: usize, start: usize, end: usize) {
        if start >= end {
            return;
        }
        let (first, last) = (start / 64, (end - 1) / 64);
        let head = !0_u64 << (start % 64);
        let tail = !0_u64 >> (63 - (end - 1) % 64);
        let row = &mut self.data[row * self.words..(row + 1) * self.words];
        if first == last {
            row[first] |= head & tail;
        } else {
            row[first] |= head;
            row[first + 1..last].fill(!0);
            row[last] |= tail;
        }
    }

    /// Sets the pixels whose centres a disc holds.
    pub(crate) fn disc(&mut self, center: Vec2, radius: f32) {
        for_disc(self.size, center, radius, |row, start, end| self.fill(row, start, end));
    }

    /// Sets the pixels whose centres a triangle holds.
    pub(crate) fn triangle(&mut self, corners: [Vec2; 3]) {
        let [a, b, c] = corners;
        let top = a.y.min(b.y).min(c.y);
        let bottom = a.y.max(b.y).max(c.y);
        for row in pixels(self.size, top, bottom) {
            let y = row as f32 + 0.5;
            let (mut lo, mut hi) = (f32::INFINITY, f32::NEG_INFINITY);
            for (p, q) in [(a, b), (b, c), (c, a)] {
                if (p.y <= y) != (q.y <= y) {
                    let x = p.x + (y - p.y) / (q.y - p.y) * (q.x - p.x);
                    (lo, hi) = (lo.min(x), hi.max(x));
                }
            }
            let span = pixels(self.size, lo, hi);
            self.fill(row, span.start, span.end);
        }
    }
}

/// The pixels whose centres lie in `[lo, hi)`, clipped to the image.
fn pixels(size: usize, lo: f32, hi: f32) -> core::ops::Range<usize> {
    round_up(lo - 0.5).min(size)..round_up(hi - 0.5).min(size)
}

/// `max(⌈x⌉, 0)`, without a call into the mathematics library. NaN gives 0.
#[inline]
pub(crate) fn round_up(x: f32) -> usize {
    // A cast from a negative number saturates at 0.
    let below = x as u32;
    below as usize + usize::from(below as f32 - x < 0.0)
}

/// Calls `span(row, start, end)` for each row of a disc's pixels.
#[inline]
pub(crate) fn for_disc(size: usize, center: Vec2, radius: f32, mut span: impl FnMut(usize, usize, usize)) {
    for row in pixels(size, center.y - radius, center.y + radius) {
        let y = row as f32 + 0.5 - center.y;
        let half = (radius * radius - y * y).max(0.0).sqrt();
        let columns = pixels(size, center.x - half, center.x + half);
        if columns.start < columns.end {
            span(row, columns.start, columns.end);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    /// A disc and a triangle against the definition, pixel by pixel.
    #[test]
    fn spans_hold_the_pixel_centres() {
        for i in 0..60 {
            let at = |k: usize| (shapes::scattered(3 * i + k).truncate() + Vec2::splat(0.5)) * 100.0;
            let (center, radius) = (at(0), shapes::scattered(i).z.abs() * 90.0);
            let mut disc = BitImage::new(100);
            disc.disc(center, radius);
            let mut triangle = BitImage::new(100);
            let corners = [at(0), at(1), at(2)];
            triangle.triangle(corners);
            let mut wrong = 0;
            for y in 0..100 {
                for x in 0..100 {
                    let p = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                    wrong += usize::from(disc.get(x, y) != (p.distance(center) < radius));
                    let side = |a: Vec2, b: Vec2| (b - a).perp_dot(p - a);
                    let s = [side(corners[0], corners[1]), side(corners[1], corners[2]), side(corners[2], corners[0])];
                    let inside = s.iter().all(|s| *s > 0.0) || s.iter().all(|s| *s < 0.0);
                    wrong += usize::from(triangle.get(x, y) != inside);
                }
            }
            // Rounding may decide a pixel centre that lies on an edge.
            assert!(wrong <= 2, "{wrong} pixels");
        }
    }

    #[test]
    fn far_away_and_empty_shapes_set_nothing() {
        let mut image = BitImage::new(70);
        image.disc(Vec2::new(-50.0, 10.0), 20.0);
        image.disc(Vec2::new(10.0, 200.0), 20.0);
        image.disc(Vec2::new(10.0, 20.0), 0.0);
        image.triangle([Vec2::splat(10.0); 3]);
        assert_eq!(image.count(), 0);
        image.disc(Vec2::splat(35.0), 1000.0);
        assert_eq!(image.count(), 4900);
    }
}
