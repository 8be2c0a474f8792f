//! Spheres that the rays of a packet meet.

use super::super::camera_rays::{Bundle, SIDE};
use super::super::primitive::SceneSphere;
use super::super::triangle_packet::inside;
use super::RayPacket;
use fearless_simd::dispatch;
use glam::Vec3;

impl RayPacket<'_> {
    /// [`SceneSphere::intersect`] for all rays that may meet it.
    pub(super) fn meet_sphere(&mut self, sphere: &SceneSphere, number: u32) {
        if self.rays.bundle == Bundle::Parallel {
            return dispatch!(self.rays.level, _simd => self.meet_parallel_sphere(sphere, number));
        }
        dispatch!(self.rays.level, _simd => self.meet_sphere_simd(sphere, number));
    }

    #[inline(always)]
    fn meet_sphere_simd(&mut self, sphere: &SceneSphere, number: u32) {
        let to = sphere.sphere.center - self.base;
        let r = sphere.sphere.radius;
        let slack = 1e-6 * (to.abs().element_sum() + r);
        if self.sides.iter().any(|n| n.dot(to) < -r - slack) {
            return;
        }
        let [x, y, z] = &self.vectors;
        for row in self.rows_of(to, r) {
            let (x, y, z) = (&x[row], &y[row], &z[row]);
            let (nearest, found) = (&mut self.nearest[row], &mut self.found[row]);
            for i in 0..SIDE {
                let along = to.x * x[i] + to.y * y[i] + to.z * z[i];
                let (ax, ay, az) = (to.x - x[i] * along, to.y - y[i] * along, to.z - z[i] * along);
                let (is_met, t) = sphere_met(r, along, [ax, ay, az]);
                let hit = is_met & (t < nearest[i]);
                nearest[i] = if hit { t } else { nearest[i] };
                found[i] = if hit { number } else { found[i] };
            }
        }
        self.update_far();
    }

    #[inline(always)]
    fn meet_parallel_sphere(&mut self, sphere: &SceneSphere, number: u32) {
        let (to, d) = (sphere.sphere.center - self.base, self.rays.forward);
        let r = sphere.sphere.radius;
        let slack = 1e-6 * (to.abs().element_sum() + r);
        if self.sides.iter().any(|n| n.dot(to) + self.reach < -r - slack) {
            return;
        }
        let [x, y, z] = &self.vectors;
        for row in 0..SIDE {
            let (x, y, z) = (&x[row], &y[row], &z[row]);
            let (nearest, found) = (&mut self.nearest[row], &mut self.found[row]);
            for i in 0..SIDE {
                let (tx, ty, tz) = (to.x - x[i], to.y - y[i], to.z - z[i]);
                let along = tx * d.x + ty * d.y + tz * d.z;
                let (ax, ay, az) = (tx - d.x * along, ty - d.y * along, tz - d.z * along);
                let (is_met, t) = sphere_met(r, along, [ax, ay, az]);
                let hit = is_met & (t < nearest[i]);
                nearest[i] = if hit { t } else { nearest[i] };
                found[i] = if hit { number } else { found[i] };
            }
        }
        self.update_far();
    }

    /// The rows in which a sphere is seen.
    #[inline(always)]
    fn rows_of(&self, to: Vec3, radius: f32) -> core::ops::Range<usize> {
        if self.rays.bundle == Bundle::Sphere {
            return 0..SIDE;
        }
        let pixels = self.rays.to_row.length();
        let (w, y) = (to.dot(self.rays.forward), to.dot(self.rays.to_row) / pixels);
        let room = (w - radius) * (w + radius);
        if w <= 1.1 * radius || room <= 0.0 {
            return 0..SIDE;
        }
        // Slopes of the two planes that touch it.
        let (mid, half) = (y * w, radius * (y * y + room).max(0.0).sqrt());
        let scale = pixels / room;
        let first = self.rays.middle.y - self.first.y;
        let (low, high) = ((mid - half) * scale + first, (mid + half) * scale + first);
        let margin = self.rays.margin + 1e-5 * (low.abs() + high.abs());
        let (low, high) = inside(low - margin, high + margin);
        low as usize..high as usize
    }
}

/// Whether a ray meets a sphere, and where, from the place of its middle: along the ray, and aside.
#[inline(always)]
fn sphere_met(radius: f32, along: f32, [x, y, z]: [f32; 3]) -> (bool, f32) {
    let half_sq = radius * radius - (x * x + y * y + z * z);
    let half = half_sq.max(0.0).sqrt();
    let (enter, leave) = (along - half, along + half);
    let t = if enter >= 0.0 { enter } else { leave };
    ((half_sq >= 0.0) & (t >= 0.0), t)
}
