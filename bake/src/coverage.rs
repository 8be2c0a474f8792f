//! The parts of a texel that lie on a triangle.

use glam::{DVec2, Vec2};

/// A part of a texel that lies on a triangle, as one point: its centroid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Piece {
    /// Column and row of the texel.
    pub(crate) texel: [u32; 2],
    /// Its area, in texels.
    pub(crate) area: f64,
    /// Its centroid, as the weights of the second and the third corner.
    pub(crate) at: [f64; 2],
}

/// The area of the pieces that stand for a triangle without one, in texels: nothing beside any other, and all where there is no other.
pub(crate) const SLIVER: f64 = 1e-9;

/// The most corners of a triangle that is cut along four lines.
const CORNERS: usize = 8;

/// A convex polygon.
#[derive(Clone, Copy)]
struct Polygon {
    corners: [DVec2; CORNERS],
    count: usize,
}

impl Polygon {
    fn corners(&self) -> &[DVec2] {
        &self.corners[..self.count]
    }

    /// The part of it where `side` is at least 0 (I. Sutherland, G. Hodgman, *Reentrant Polygon Clipping*, 1974).
    fn clipped(&self, side: impl Fn(DVec2) -> f64) -> Self {
        let mut out = Self { corners: [DVec2::ZERO; CORNERS], count: 0 };
        let mut push = |p: DVec2| {
            if out.count < CORNERS {
                out.corners[out.count] = p;
                out.count += 1;
            }
        };
        for (i, &p) in self.corners().iter().enumerate() {
            let q = self.corners[(i + 1) % self.count];
            let (a, b) = (side(p), side(q));
            if a >= 0.0 {
                push(p);
            }
            if (a > 0.0 && b < 0.0) || (a < 0.0 && b > 0.0) {
                push(p + (q - p) * (a / (a - b)));
            }
        }
        out
    }

    /// Twice the area, and the centroid.
    fn moments(&self) -> (f64, DVec2) {
        let Some(&origin) = self.corners().first() else { return (0.0, DVec2::ZERO) };
        let (mut area, mut sum) = (0.0, DVec2::ZERO);
        for pair in self.corners().windows(2) {
            let (a, b) = (pair[0] - origin, pair[1] - origin);
            let twice = a.perp_dot(b);
            area += twice;
            sum += (a + b) * (twice / 3.0);
        }
        if area == 0.0 { (0.0, origin) } else { (area, origin + sum / area) }
    }

    fn bounds(&self, axis: usize) -> [f64; 2] {
        let each = self.corners().iter().map(|p| p[axis]);
        each.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    }
}

/// A page of texels, and the rows of it that are looked at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    /// Width and height.
    pub(crate) size: [u32; 2],
    /// First row, and the one after the last.
    pub(crate) rows: [u32; 2],
    /// Cells along a texel's side: each makes a piece of its own.
    pub(crate) cells: u32,
}

impl Grid {
    /// The range of whole cells along an axis that an interval touches, within the grid.
    fn range(&self, axis: usize, [low, high]: [f64; 2]) -> core::ops::Range<i64> {
        let cells = i64::from(self.cells);
        let [first, end] = if axis == 0 { [0, self.size[0]] } else { self.rows };
        let [first, end] = [first, end].map(|k| i64::from(k) * cells);
        let scale = self.cells as f64;
        let from = ((low * scale).floor() as i64).clamp(first, end);
        let to = ((high * scale).ceil() as i64).clamp(first, end);
        from..to
    }

    /// The pieces of a triangle, of texture coordinates, on the texels of these rows: row by row, from left to right.
    ///
    /// The pieces' areas add up to the triangle's, in f64 to 1e-12 of a texel; a triangle without an area is one piece of [`SLIVER`] at its
    /// middle.
    pub(crate) fn pieces(&self, corners: [Vec2; 3], mut each: impl FnMut(Piece)) {
        let scale = DVec2::new(f64::from(self.size[0]), f64::from(self.size[1]));
        let [a, b, c] = corners.map(|p| p.as_dvec2() * scale);
        let twice = (b - a).perp_dot(c - a);
        if twice.abs() <= 2.0 * SLIVER {
            let middle = (a + b + c) / 3.0;
            let texel = [0, 1].map(|axis| middle[axis].max(0.0).min(f64::from(self.size[axis]) - 1.0) as u32);
            if (self.rows[0]..self.rows[1]).contains(&texel[1]) {
                each(Piece { texel, area: SLIVER, at: [1.0 / 3.0; 2] });
            }
            return;
        }
        let mut triangle = Polygon { corners: [DVec2::ZERO; CORNERS], count: 3 };
        // Counter-clockwise, so that areas are positive.
        triangle.corners[..3].copy_from_slice(&if twice > 0.0 { [a, b, c] } else { [a, c, b] });
        let side = 1.0 / self.cells as f64;
        let place = |p: DVec2| {
            let (v, w) = ((p - a).perp_dot(c - a) / twice, (b - a).perp_dot(p - a) / twice);
            let (v, w) = (v.clamp(0.0, 1.0), w.clamp(0.0, 1.0));
            // Rounding must not lead beyond the far edge.
            let over = (v + w).max(1.0);
            [v / over, w / over]
        };
        for row in self.range(1, triangle.bounds(1)) {
            let (low, high) = (row as f64 * side, (row + 1) as f64 * side);
            let strip = triangle.clipped(|p| p.y - low).clipped(|p| high - p.y);
            if strip.count < 3 {
                continue;
            }
            for column in self.range(0, strip.bounds(0)) {
                let (left, right) = (column as f64 * side, (column + 1) as f64 * side);
                let (area, center) = strip.clipped(|p| p.x - left).clipped(|p| right - p.x).moments();
                if area > 0.0 {
                    let texel = [column, row].map(|k| (k / i64::from(self.cells)) as u32);
                    each(Piece { texel, area: 0.5 * area, at: place(center) });
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_core::Random;

    fn all(grid: Grid, corners: [Vec2; 3]) -> Vec<Piece> {
        let mut found = Vec::new();
        grid.pieces(corners, |piece| found.push(piece));
        found
    }

    /// Areas add up, centroids are inside of triangle and texel, and first moments are the triangle's: for triangles of all shapes, over
    /// bands of rows as over the whole.
    #[test]
    fn pieces_are_the_triangle() {
        let mut random = Random::new(5);
        let mut point = || Vec2::new(random.uniform() as f32, random.uniform() as f32);
        for case in 0..400 {
            let shrink = [1.0, 0.05, 1e-3][case % 3];
            let middle = point() * 0.8 + 0.1;
            let corners = [0; 3].map(|_| (middle + shrink * (point() - 0.5)).clamp(Vec2::ZERO, Vec2::ONE));
            let grid = Grid { size: [23, 17], rows: [0, 17], cells: 1 + case as u32 % 3 };
            let pieces = all(grid, corners);
            let scale = DVec2::new(23.0, 17.0);
            let [a, b, c] = corners.map(|p| p.as_dvec2() * scale);
            let want = 0.5 * (b - a).perp_dot(c - a).abs();
            let area: f64 = pieces.iter().map(|p| p.area).sum();
            assert!((area - want).abs() < 2.0 * SLIVER, "{area} {want}");
            let mut moment = DVec2::ZERO;
            for piece in &pieces {
                let [v, w] = piece.at;
                assert!(v >= 0.0 && w >= 0.0 && v + w <= 1.0 + 1e-12);
                let p = a + (b - a) * v + (c - a) * w;
                let [x, y] = piece.texel.map(f64::from);
                assert!(p.x > x - 1e-6 && p.x < x + 1.0 + 1e-6 && p.y > y - 1e-6 && p.y < y + 1.0 + 1e-6);
                moment += p * piece.area;
            }
            assert!(want < 1e-6 || (moment / area - (a + b + c) / 3.0).length() < 1e-6);
            let mut bands = Vec::new();
            for rows in [[0, 5], [5, 6], [6, 17]] {
                bands.extend(all(Grid { rows, ..grid }, corners));
            }
            assert_eq!(bands, pieces);
        }
    }

    #[test]
    fn triangles_without_an_area_are_one_piece() {
        let grid = Grid { size: [8, 8], rows: [0, 8], cells: 2 };
        let line = all(grid, [Vec2::splat(0.2), Vec2::splat(0.9), Vec2::splat(0.55)]);
        assert_eq!(line, [Piece { texel: [4, 4], area: SLIVER, at: [1.0 / 3.0; 2] }]);
        assert_eq!(all(grid, [Vec2::ONE; 3]).len(), 1);
        assert!(all(Grid { rows: [0, 2], ..grid }, [Vec2::ONE; 3]).is_empty());
    }
}
