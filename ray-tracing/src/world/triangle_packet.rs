//! Eight triangles side by side, made ready for rays from one point.

use super::camera_rays::{Rays, Row, SIDE};
use glam::{Vec2, Vec3};

/// The whole numbers in an interval, of those from 0 to 7: first and one past the last, not negative, equal when there
/// are none.
#[inline(always)]
pub(super) fn inside(low: f32, high: f32) -> (u32, u32) {
    // Adding it leaves a whole number in the low bits: a cast would cost more.
    const MAGIC: f32 = 12_582_912.0;
    let low = (low + 0.499).clamp(0.0, 8.0);
    let high = (high + 0.501).clamp(0.0, 8.0);
    let (low, high) = ((low + MAGIC).to_bits() & 15, (high + MAGIC).to_bits() & 15);
    (low, if high > low { high } else { low })
}

/// A triangle whose longest edge is so many times as long as the distance at which a ray meets it is met in f64: rounding may be
/// larger there than a pixel.
pub(super) const FAR_LARGER: f32 = 256.0;

/// Eight triangles side by side.
#[derive(Default)]
pub(super) struct TrianglePacket {
    /// From the first corner to the eye, and the edges from it.
    pub(super) s: [Row; 3],
    pub(super) e1: [Row; 3],
    pub(super) e2: [Row; 3],
    /// Their products with a direction are the determinant and the barycentric coordinates times it.
    pub(super) det: [Row; 3],
    pub(super) u: [Row; 3],
    pub(super) v: [Row; 3],
    /// The distance times the determinant.
    pub(super) height: Row,
    /// Bound of the rounding error of the barycentric coordinates times the determinant.
    pub(super) blur: Row,
    /// The longest edge of those that may be [giants](FAR_LARGER), seen from the eye; 0 for all others.
    pub(super) giant: Row,
    /// First row in which each may be seen, and one past the last.
    pub(super) rows: [[u32; SIDE]; 2],
}

impl TrianglePacket {
    #[inline(always)]
    pub(super) fn prepare(&mut self, rays: &Rays, first: Vec2) {
        let (f, right, down) = (rays.forward, rays.to_column, rays.to_row);
        let offset = rays.middle - first;
        for l in 0..SIDE {
            let at = |a: &[Row; 3]| [a[0][l], a[1][l], a[2][l]];
            let (s, e1, e2) = (at(&self.s), at(&self.e1), at(&self.e2));
            let cross = |a: [f32; 3], b: [f32; 3]| {
                [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
            };
            let (det, u, v) = (cross(e2, e1), cross(e2, s), cross(s, e1));
            for k in 0..3 {
                (self.det[k][l], self.u[k][l], self.v[k][l]) = (det[k], u[k], v[k]);
            }
            let length = |a: [f32; 3]| (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt();
            self.blur[l] = 1.5e-7 * length(s) * length(e1).max(length(e2));
            self.height[l] = e2[0] * v[0] + e2[1] * v[1] + e2[2] * v[2];

            let size = length(e1).max(length(e2));
            // The eye's distance to the plane is the height over the length of the normal.
            self.giant[l] = if size * length(det) > FAR_LARGER * self.height[l].abs() { size } else { 0.0 };

            let dot = |n: Vec3, a: [f32; 3]| n.x * a[0] + n.y * a[1] + n.z * a[2];
            let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
            let mut before = true;
            let (fs, xs, ys) = (dot(f, s), dot(right, s), dot(down, s));
            let corners = [
                (-fs, -xs, -ys),
                (dot(f, e1) - fs, dot(right, e1) - xs, dot(down, e1) - ys),
                (dot(f, e2) - fs, dot(right, e2) - xs, dot(down, e2) - ys),
            ];
            for (w, x, y) in corners {
                // Larger pixel numbers lose precision: then all rows are tested.
                before &= w * 1e5 > x.abs() + y.abs();
                let inverse = 1.0 / w;
                let (x, y) = (x * inverse + offset.x, y * inverse + offset.y);
                low = [if x < low[0] { x } else { low[0] }, if y < low[1] { y } else { low[1] }];
                high = [if x > high[0] { x } else { high[0] }, if y > high[1] { y } else { high[1] }];
            }
            let columns = inside(low[0] - rays.margin, high[0] + rays.margin);
            let rows = inside(low[1] - rays.margin, high[1] + rays.margin);
            let seen = columns.0 < columns.1;
            self.rows[0][l] = if before { rows.0 } else { 0 };
            self.rows[1][l] = if before { if seen { rows.1 } else { rows.0 } } else { SIDE as u32 };
        }
    }
}
