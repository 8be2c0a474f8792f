//! Eight triangles side by side, made ready for parallel rays.

use super::camera_rays::{Rays, Row, SIDE};
use super::triangle_packet::inside;
use glam::Vec3;
use scene::rounding::{EDGE, WIDEST};

/// A triangle whose longest edge, or distance from the base, has so many pixels is met in f64: rounding may be larger there than a pixel.
const GIANT: f32 = 65536.0;

/// Eight triangles side by side.
///
/// A ray starts at `base + w` and has the direction `d`. For a triangle with the corner `a` and the edges `e₁` and `e₂` from it, `s` from
/// the corner to the base, and `D = d·(e₂ × e₁)`, it meets the plane at
///
/// ```text
/// u = (w·(d × e₂) + d·(e₂ × s)) / D     v = (w·(e₁ × d) + d·(s × e₁)) / D     t = (w·(e₁ × e₂) + e₂·(s × e₁)) / D
/// ```
#[derive(Default)]
pub(super) struct ParallelTriangles {
    /// From the first corner to the base of the rays, and the edges from it.
    s: [Row; 3],
    e1: [Row; 3],
    e2: [Row; 3],
    /// Their products with a start, and the next three added, are the barycentric coordinates and the distance.
    u: [Row; 3],
    v: [Row; 3],
    t: [Row; 3],
    at_base: [Row; 3],
    /// Bound of the rounding error of the barycentric coordinates.
    edge: Row,
    pub(super) is_giant: [bool; SIDE],
    /// First row in which each may be seen, and one past the last.
    pub(super) rows: [[u32; SIDE]; 2],
}

impl ParallelTriangles {
    #[inline(always)]
    pub(super) fn put(&mut self, l: usize, s: Vec3, e1: Vec3, e2: Vec3) {
        for k in 0..3 {
            (self.s[k][l], self.e1[k][l], self.e2[k][l]) = (s[k], e1[k], e2[k]);
        }
    }

    /// For the rays of a tile around the base.
    #[inline(always)]
    pub(super) fn prepare(&mut self, rays: &Rays) {
        let (d, right, down) = (rays.forward.to_array(), rays.to_column, rays.to_row);
        let pixels = down.length();
        for l in 0..SIDE {
            let at = |a: &[Row; 3]| [a[0][l], a[1][l], a[2][l]];
            let (s, e1, e2) = (at(&self.s), at(&self.e1), at(&self.e2));
            let cross = |a: [f32; 3], b: [f32; 3]| {
                [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
            };
            let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            let length = |a: [f32; 3]| dot(a, a).sqrt();
            let (u, v, t) = (cross(d, e2), cross(e1, d), cross(e1, e2));
            let inverse = -1.0 / dot(d, t);
            for k in 0..3 {
                (self.u[k][l], self.v[k][l], self.t[k][l]) = (u[k] * inverse, v[k] * inverse, t[k] * inverse);
            }
            // d·(e₂ × s) = s·(d × e₂), and so on.
            self.at_base[0][l] = dot(s, u) * inverse;
            self.at_base[1][l] = dot(s, v) * inverse;
            self.at_base[2][l] = dot(s, t) * inverse;
            let size = length(e1).max(length(e2));
            let far = length(s) + 6.0 / pixels;
            self.edge[l] = (EDGE + 1.5e-7 * far * size * inverse.abs()).min(WIDEST);
            self.is_giant[l] = size.max(far) * pixels > GIANT;

            let place = |n: Vec3, e: [f32; 3]| {
                let n = n.to_array();
                dot(n, e) - dot(n, s) + 0.5 * (SIDE - 1) as f32
            };
            let corners = [[0.0; 3], e1, e2];
            let span = |n: Vec3| {
                let [a, b, c] = corners.map(|e| place(n, e));
                (a.min(b).min(c), a.max(b).max(c))
            };
            let ((left, right), (top, low)) = (span(right), span(down));
            let margin = rays.margin + 1e-6 * pixels * (far + size);
            let columns = inside(left - margin, right + margin);
            let rows = inside(top - margin, low + margin);
            self.rows[0][l] = rows.0;
            self.rows[1][l] = if columns.0 < columns.1 { rows.1 } else { rows.0 };
        }
    }

    /// Lets a row of rays meet a triangle.
    #[inline(always)]
    pub(super) fn meet(&self, l: usize, [x, y, z]: [&Row; 3], number: u32, nearest: &mut Row, found: &mut [u32; SIDE]) {
        let along = |a: &[Row; 3], at_base: f32| {
            let (ax, ay, az) = (a[0][l], a[1][l], a[2][l]);
            let mut out = [0.0f32; SIDE];
            for i in 0..SIDE {
                out[i] = x[i] * ax + y[i] * ay + z[i] * az + at_base;
            }
            out
        };
        let [u0, v0, t0] = [0, 1, 2].map(|k| self.at_base[k][l]);
        let (u, v, t, edge) = (along(&self.u, u0), along(&self.v, v0), along(&self.t, t0), self.edge[l]);
        for i in 0..SIDE {
            // An inverse of ±∞ or NaN (rays in the plane) fails one of the comparisons.
            let hit =
                (u[i] >= -edge) & (v[i] >= -edge) & (u[i] + v[i] <= 1.0 + edge) & (t[i] >= 0.0) & (t[i] < nearest[i]);
            nearest[i] = if hit { t[i] } else { nearest[i] };
            found[i] = if hit { number } else { found[i] };
        }
    }
}
