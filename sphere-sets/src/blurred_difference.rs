use glam::{Vec2, Vec4};

use crate::bits::BitImage;
use crate::view::{CELL, View};

/// Half the side of the square over which silhouettes are averaged, in units of D: the penumbra of a light of some
/// degrees, half of D away.
const BLUR: f32 = 0.05;

/// Imbalance at which the force is full, as a fraction of the square's area.
const FULL: f32 = 0.03;

/// The regions where a set's silhouette is too large or too small *on average*, as in a soft shadow. A hard shadow shows
/// the outline itself, where misses and excesses do not cancel. A set is judged by both.
pub(crate) struct BlurredDifference {
    image: BitImage,
    /// Cells a side.
    side: usize,
    cells: Vec<f32>,
    rows: Vec<f32>,
    sums: Vec<f32>,
}

impl BlurredDifference {
    /// For views of `size`² pixels.
    pub(crate) fn new(size: usize) -> Self {
        let side = size / CELL;
        let (cells, rows) = (vec![0.0; side * side], vec![0.0; side * side]);
        Self { image: BitImage::new(size), side, cells, rows, sums: vec![0.0; side] }
    }

    /// Area of the blurred silhouettes' difference, in pixels.
    pub(crate) fn error(&mut self, view: &View, spheres: &[Vec4]) -> f32 {
        self.compare(view, spheres);
        self.cells.iter().map(|d| d.abs()).sum::<f32>() * (CELL * CELL) as f32
    }

    /// Prepares [`Self::force`].
    pub(crate) fn weigh(&mut self, view: &View, spheres: &[Vec4]) {
        self.compare(view, spheres);
        for d in &mut self.cells {
            *d = (*d / FULL).clamp(-1.0, 1.0);
        }
        self.blur(reach(view));
    }

    /// The effect on the difference of moving a piece of the set's outline outward here, in −1 … 1.
    pub(crate) fn force(&self, p: Vec2) -> f32 {
        let q = (p / CELL as f32 - 0.5).clamp(Vec2::ZERO, Vec2::splat(self.side as f32 - 1.001));
        let (x, y) = (q.x as usize, q.y as usize);
        let (fx, fy) = (q.x - x as f32, q.y - y as f32);
        let row = |at: usize| self.cells[at] + (self.cells[at + 1] - self.cells[at]) * fx;
        let (top, bottom) = (row(y * self.side + x), row((y + 1) * self.side + x));
        top + (bottom - top) * fy
    }

    /// The blurred silhouette of the spheres minus that of the mesh.
    fn compare(&mut self, view: &View, spheres: &[Vec4]) {
        self.image.clear();
        view.frame.draw_spheres(spheres, &mut self.image);
        for (cell, mesh) in self.cells.iter_mut().zip(&view.cells) {
            *cell = -mesh;
        }
        for y in 0..view.size {
            let cells = &mut self.cells[y / CELL * self.side..][..self.side];
            self.image.count_cells(y, |x, count| cells[x] += count as f32 * (1.0 / (CELL * CELL) as f32));
        }
        self.blur(reach(view));
    }

    /// Mean over the squares of `2 reach + 1` cells a side.
    fn blur(&mut self, reach: usize) {
        let side = self.side;
        let share = 1.0 / (2 * reach + 1) as f32;
        for (row, out) in self.cells.chunks_exact(side).zip(self.rows.chunks_exact_mut(side)) {
            let mut sum: f32 = row[..reach].iter().sum();
            for x in 0..side {
                sum += row.get(x + reach).copied().unwrap_or(0.0);
                out[x] = sum * share;
                sum -= if x >= reach { row[x - reach] } else { 0.0 };
            }
        }
        self.sums.fill(0.0);
        let rows = &self.rows;
        let row = |y: usize| &rows[y * side..(y + 1) * side];
        for y in 0..reach {
            self.sums.iter_mut().zip(row(y)).for_each(|(sum, r)| *sum += r);
        }
        for y in 0..side {
            if y + reach < side {
                self.sums.iter_mut().zip(row(y + reach)).for_each(|(sum, r)| *sum += r);
            }
            let out = &mut self.cells[y * side..(y + 1) * side];
            out.iter_mut().zip(&self.sums).for_each(|(out, sum)| *out = sum * share);
            if y >= reach {
                self.sums.iter_mut().zip(row(y - reach)).for_each(|(sum, r)| *sum -= r);
            }
        }
    }
}

/// Half the width of the mean around a cell, in cells.
fn reach(view: &View) -> usize {
    (BLUR * view.frame.scale / CELL as f32 + 0.5) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;
    use glam::Vec3;

    fn view() -> View {
        let (positions, triangles) = shapes::sphere(16);
        let mesh: Vec<[Vec3; 3]> = triangles.iter().map(|t| t.map(|i| positions[i as usize] * 0.3)).collect();
        View::new(Vec3::Z, &mesh, 0.04, 192)
    }

    #[test]
    fn the_mesh_itself_is_balanced() {
        let view = view();
        let mut blurred = BlurredDifference::new(192);
        let area = 1.0 / view.inverse_area;
        // The polyhedron is up to 1 % smaller than the sphere.
        assert!(blurred.error(&view, &[Vec4::new(0.0, 0.0, 0.0, 0.3)]) < 0.01 * area);
        // Without spheres everything is missing. Blurring preserves areas, except at the picture's edge.
        let missing = blurred.error(&view, &[]) / area;
        assert!((0.99..1.001).contains(&missing), "{missing}");
        blurred.weigh(&view, &[Vec4::new(0.0, 0.0, 0.0, 0.33)]);
        let at = |x: f32| view.frame.project(Vec3::new(x, 0.0, 0.0));
        assert!(blurred.force(at(0.3)) > 0.3 && blurred.force(at(0.0)).abs() < 1e-6);
        blurred.weigh(&view, &[Vec4::new(0.0, 0.0, 0.0, 0.27)]);
        assert!(blurred.force(at(0.3)) < -0.3);
    }

    /// The running sums against the definition.
    #[test]
    fn blur_is_the_mean_of_a_square() {
        let mut blurred = BlurredDifference::new(48);
        let side = 12;
        let image: Vec<f32> = (0..side * side).map(|i| shapes::scattered(i).x).collect();
        for reach in [0, 1, 3] {
            blurred.cells.clone_from(&image);
            blurred.blur(reach);
            for y in 0..side {
                for x in 0..side {
                    let near = |a: usize, b: usize| a.abs_diff(b) <= reach;
                    let all = (0..side * side).filter(|i| near(i % side, x) && near(i / side, y));
                    let mean = all.map(|i| image[i]).sum::<f32>() / ((2 * reach + 1) * (2 * reach + 1)) as f32;
                    assert!((blurred.cells[y * side + x] - mean).abs() < 1e-5);
                }
            }
        }
    }
}
