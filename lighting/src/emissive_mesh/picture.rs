//! Triangles as a receiver sees them.

use super::lamp::Lamp;
use super::triangle::Triangle;
use core::f64::consts::{PI, TAU};
use glam::{DVec2, DVec3};

/// Cells across a picture of what a receiver sees; one of so many is compared, across and upward.
const SIDE: usize = 192;
const STRIDE: usize = 2;
const HALF: f64 = 0.5 * SIDE as f64;

/// Shows a sphere around triangles from some distance of its middle: each direction counts once, however many triangles it meets.
pub(super) struct Picture {
    eye: DVec3,
    /// Right, up, and away from the middle.
    frame: [DVec3; 3],
    /// Cells a unit of the plane at distance 1.
    scale: f64,
    is_covered: Vec<bool>,
}

impl Picture {
    pub(super) fn new<'a>(
        triangles: impl Iterator<Item = &'a Triangle>,
        center: DVec3,
        radius: f64,
        direction: DVec3,
        distance: f64,
    ) -> Self {
        let eye = center + direction * distance;
        let (right, up) = direction.any_orthonormal_pair();
        let tan = 1.001 * radius / ((distance - radius) * (distance + radius)).sqrt();
        let scale = HALF / tan;
        let mut is_covered = vec![false; SIDE * SIDE];
        for t in triangles {
            let [a, b, c] = t.map(|p| {
                let p = p - eye;
                DVec2::new(right.dot(p), up.dot(p)) * (scale / -direction.dot(p)) + HALF
            });
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            let first = |at: f64| (at - 0.5).ceil().max(0.0) as usize;
            let last = |at: f64| ((at + 0.5).floor().max(0.0) as usize).min(SIDE);
            for y in first(low.y)..last(high.y) {
                for x in first(low.x)..last(high.x) {
                    let p = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                    let sides = [(b - a).perp_dot(p - a), (c - b).perp_dot(p - b), (a - c).perp_dot(p - c)];
                    if sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0) {
                        is_covered[y * SIDE + x] = true;
                    }
                }
            }
        }
        Self { eye, frame: [right, up, direction], scale, is_covered }
    }

    /// Where a cell is on the plane at distance 1.
    fn at(&self, x: usize, y: usize) -> DVec2 {
        (DVec2::new(x as f64 + 0.5, y as f64 + 0.5) - HALF) / self.scale
    }

    /// The irradiance on a surface that faces the middle, over π, of a radiance of 1.
    pub(super) fn irradiance(&self) -> f64 {
        let cells = self.is_covered.iter().enumerate().filter(|(_, is_covered)| **is_covered);
        let sum: f64 = cells.map(|(k, _)| (1.0 + self.at(k % SIDE, k / SIDE).length_squared()).powi(-2)).sum();
        sum / (self.scale * self.scale * PI)
    }

    /// In cells: where lamps are and the triangles are not, or the other way round, each lamp for itself; and where triangles are.
    pub(super) fn difference(&self, lamps: &[Lamp]) -> [f64; 2] {
        let [right, up, back] = self.frame;
        let (mut off, mut all) = (0.0, 0.0);
        for y in (0..SIDE).step_by(STRIDE) {
            for x in (0..SIDE).step_by(STRIDE) {
                let at = self.at(x, y);
                let v = (right * at.x + up * at.y - back).normalize();
                let seen = lamps.iter().filter(|lamp| lamp.is_met(self.eye, v)).count() as f64;
                let truth = f64::from(u8::from(self.is_covered[y * SIDE + x]));
                off += (seen - truth).abs();
                all += truth;
            }
        }
        [off, all]
    }
}

/// The area that triangles in a sphere show along a direction.
pub(super) fn shown(triangles: &[&Triangle], center: DVec3, radius: f64, direction: DVec3) -> f64 {
    let distance = 1e3 * radius;
    let picture = Picture::new(triangles.iter().copied(), center, radius, direction, distance);
    picture.irradiance() * PI * distance * distance
}

/// The mean area that triangles show across an axis.
pub(super) fn shown_across(triangles: &[&Triangle], middle: DVec3, radius: f64, axis: DVec3) -> f64 {
    const TURNS: usize = 4;
    let (u, v) = axis.any_orthonormal_pair();
    let turn = |k: usize| (TAU * (k as f64 + 0.25) / TURNS as f64).sin_cos();
    let area = |k: usize| shown(triangles, middle, radius, u * turn(k).1 + v * turn(k).0);
    (0..TURNS).map(area).sum::<f64>() / TURNS as f64
}
