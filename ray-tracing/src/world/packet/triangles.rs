//! Triangles that the rays of a packet meet.

use super::super::World;
use super::super::camera_rays::{Bundle, Row, SIDE};
use super::super::parallel::ParallelTriangles;
use super::super::triangle_packet::{FAR_LARGER, TrianglePacket};
use super::RayPacket;
use fearless_simd::dispatch;
use glam::Vec3;
use scene::rounding::{EDGE, WIDEST};

impl RayPacket<'_> {
    /// Lets the rays meet eight triangles at most.
    pub(super) fn meet_triangles(&mut self, numbers: &[u32], world: &World<'_>) {
        if self.rays.bundle == Bundle::Parallel {
            return dispatch!(self.rays.level, _simd => self.meet_parallel_triangles(numbers, world));
        }
        dispatch!(self.rays.level, _simd => self.meet_triangles_simd(numbers, world));
    }

    #[inline(always)]
    fn meet_triangles_simd(&mut self, numbers: &[u32], world: &World<'_>) {
        let mut t = TrianglePacket::default();
        for (l, number) in numbers.iter().enumerate().take(SIDE) {
            let c = world.triangle(*number);
            let (s, e1, e2) = (self.base - Vec3::from(c.v0), Vec3::from(c.e1), Vec3::from(c.e2));
            for k in 0..3 {
                (t.s[k][l], t.e1[k][l], t.e2[k][l]) = (s[k], e1[k], e2[k]);
            }
        }
        t.prepare(self.rays, self.first);
        if self.rays.bundle == Bundle::Sphere {
            t.rows = self.rows_between_planes(&t);
        }
        for (l, number) in numbers.iter().enumerate().take(SIDE) {
            for row in t.rows[0][l] as usize..t.rows[1][l] as usize {
                if t.giant[l] == 0.0 || !self.meet_giant(&t, l, row & 7, *number, world) {
                    self.meet_triangle(&t, l, row & 7, *number);
                }
            }
        }
        self.update_far();
    }

    /// The rows of a panorama in which triangles may be seen: none for those that lie beyond one of the planes around the rays.
    #[inline(always)]
    fn rows_between_planes(&self, t: &TrianglePacket) -> [[u32; SIDE]; 2] {
        let mut rows = [[0; SIDE], [SIDE as u32; SIDE]];
        for l in 0..SIDE {
            let at = |a: &[Row; 3]| Vec3::new(a[0][l], a[1][l], a[2][l]);
            let (s, e1, e2) = (at(&t.s), at(&t.e1), at(&t.e2));
            let slack = 1e-6 * (s.abs() + e1.abs() + e2.abs()).element_sum();
            let is_beyond = |n: &Vec3| n.dot(-s).max(n.dot(e1 - s)).max(n.dot(e2 - s)) < -slack;
            if self.sides.iter().any(is_beyond) {
                rows[1][l] = 0;
            } else if let Some(around) = &self.around
                && let Some([low, high]) = around.span([-s, e1 - s, e2 - s])
            {
                let may_meet = |row: &[f32; 2]| row[0] <= high && row[1] >= low;
                let first = around.rows.iter().position(may_meet).unwrap_or(0);
                let end = around.rows.iter().rposition(may_meet).map_or(0, |last| last + 1);
                (rows[0][l], rows[1][l]) = (first as u32, end as u32);
            }
        }
        rows
    }

    /// Lets parallel rays meet eight triangles at most.
    #[inline(always)]
    fn meet_parallel_triangles(&mut self, numbers: &[u32], world: &World<'_>) {
        let mut t = ParallelTriangles::default();
        for (l, number) in numbers.iter().enumerate().take(SIDE) {
            let c = world.triangle(*number);
            t.put(l, self.base - Vec3::from(c.v0), Vec3::from(c.e1), Vec3::from(c.e2));
        }
        t.prepare(self.rays);
        for (l, number) in numbers.iter().enumerate().take(SIDE) {
            for row in t.rows[0][l] as usize..t.rows[1][l] as usize {
                if t.is_giant[l] {
                    self.meet_parallel_giant(row & 7, *number, world);
                } else {
                    let [x, y, z] = &self.vectors;
                    let row = row & 7;
                    t.meet(l, [&x[row], &y[row], &z[row]], *number, &mut self.nearest[row], &mut self.found[row]);
                }
            }
        }
        self.update_far();
    }

    /// The same in f64, for a triangle that is large beside a pixel.
    #[cold]
    fn meet_parallel_giant(&mut self, row: usize, number: u32, world: &World<'_>) {
        let exact = world.exact(&world.triangle(number));
        let (base, direction) = (self.base.as_dvec3(), self.rays.forward.as_dvec3());
        for i in 0..SIDE {
            let start = Vec3::from_array(core::array::from_fn(|k| self.vectors[k][row][i]));
            let Some(along) = exact.meet(base + start.as_dvec3(), direction) else { continue };
            let along = along as f32;
            if along >= 0.0 && along < self.nearest[row][i] {
                (self.nearest[row][i], self.found[row][i]) = (along, number);
            }
        }
    }

    /// [`Corners::intersect`](super::primitive::Corners::intersect) for a row of rays: all that does not depend on their directions is in `t`.
    #[inline(always)]
    fn meet_triangle(&mut self, t: &TrianglePacket, l: usize, row: usize, number: u32) {
        let [x, y, z] = &self.vectors;
        let (x, y, z) = (&x[row], &y[row], &z[row]);
        let (nearest, found) = (&mut self.nearest[row], &mut self.found[row]);
        let dot = |a: &[Row; 3]| {
            let (ax, ay, az) = (a[0][l], a[1][l], a[2][l]);
            let mut out = [0.0f32; SIDE];
            for i in 0..SIDE {
                out[i] = x[i] * ax + y[i] * ay + z[i] * az;
            }
            out
        };
        let (det, u, v, height, blur) = (dot(&t.det), dot(&t.u), dot(&t.v), t.height[l], t.blur[l]);
        for i in 0..SIDE {
            let inverse = 1.0 / det[i];
            let (u, v, along) = (u[i] * inverse, v[i] * inverse, height * inverse);
            let edge = (EDGE + blur * inverse.abs()).min(WIDEST);
            // An inverse of ±∞ or NaN (ray in the plane) fails one of the comparisons.
            let hit = (u >= -edge) & (v >= -edge) & (u + v <= 1.0 + edge) & (along >= 0.0) & (along < nearest[i]);
            nearest[i] = if hit { along } else { nearest[i] };
            found[i] = if hit { number } else { found[i] };
        }
    }

    /// The same in f64, if a ray of the row meets the triangle's plane so near that the triangle is a giant there. Returns whether it does.
    #[cold]
    fn meet_giant(&mut self, t: &TrianglePacket, l: usize, row: usize, number: u32, world: &World<'_>) -> bool {
        let at = |i: usize| Vec3::from_array(core::array::from_fn(|k| self.vectors[k][row][i]));
        let det = Vec3::from_array(core::array::from_fn(|k| t.det[k][l]));
        let along = |i: usize| t.height[l] / det.dot(at(i));
        if !(0..SIDE).any(|i| t.giant[l] > FAR_LARGER * along(i).abs()) {
            return false;
        }
        let exact = world.exact(&world.triangle(number));
        let eye = self.rays.eye.as_dvec3();
        for i in 0..SIDE {
            let Some(along) = exact.meet(eye, at(i).as_dvec3()) else { continue };
            let along = along as f32;
            if along >= 0.0 && along < self.nearest[row][i] {
                (self.nearest[row][i], self.found[row][i]) = (along, number);
            }
        }
        true
    }
}
