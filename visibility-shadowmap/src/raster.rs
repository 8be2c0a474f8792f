//! Draws triangles into depth layers.

use crate::clip::Polygon;
use crate::face::Face;
use crate::fit::{Triangle, extremes};
use crate::layer::EMPTY;
use glam::{DVec2, DVec3, Vec2Swizzles as _};
use rayon::prelude::*;

/// Rows that one task draws.
const BAND: usize = 16;
/// Two surfaces closer to each other than this fraction of the depth range are one: an edge that two triangles share, a sheet that
/// is twice in the mesh.
const SAME: f64 = 1e-6;

/// A projected triangle in texel coordinates.
struct Flat {
    points: [DVec2; 3],
    q: [f64; 3],
    faces_light: bool,
    rows: (f64, f64),
}

/// The two nearest surfaces of each facing by their q; a larger q is nearer.
#[derive(Clone, Copy)]
struct Nearest {
    facing: [[f32; 2]; 2],
}

impl Nearest {
    fn add(&mut self, facing: usize, q: f32, slack: f32) {
        let same = |a: f32| (a - q).abs() <= slack;
        let [first, second] = &mut self.facing[facing];
        if same(*first) || same(*second) {
            return;
        }
        if q > *first {
            (*first, *second) = (q, *first);
        } else if q > *second {
            *second = q;
        }
    }

    /// The first surface; the next surface; the second one with the first's facing, or, if that was next, the nearest of the other
    /// facing; the second one with the other facing.
    fn layers(&self, slack: f32) -> [f32; 4] {
        let [front, back] = self.facing;
        let (own, mut other) = if front[0] >= back[0] { (front, back) } else { (back, front) };
        if (other[0] - own[0]).abs() <= slack {
            // Two coincident sides of a sheet are one surface.
            other = [other[1], EMPTY];
        }
        let (next, third) = if own[1] >= other[0] { (own[1], other[0]) } else { (other[0], own[1]) };
        [own[0], next, third, other[1]]
    }
}

/// Draws triangles into at most `count` layers, 1 to 4, sampled at the texels' centres.
pub(crate) fn draw(face: &Face, triangles: &[Triangle], near: f64, radius: f64, count: usize) -> Vec<Vec<f32>> {
    let flat: Vec<Flat> = triangles.par_iter().flat_map_iter(|t| project(face, t, near)).collect();
    let (low, high) = extremes(flat.iter().flat_map(|t| t.q));
    let slack = (SAME * (high - low)) as f32;
    let mut texels = vec![Nearest { facing: [[EMPTY; 2]; 2] }; face.width * face.height];
    texels.par_chunks_mut(face.width * BAND).enumerate().for_each(|(band, texels)| {
        let (start, end) = (band * BAND, band * BAND + texels.len() / face.width);
        for triangle in &flat {
            if triangle.rows.1 >= start as f64 && triangle.rows.0 <= end as f64 {
                fill(face, triangle, start, radius, slack, texels);
            }
        }
    });
    (0..count).map(|k| texels.par_iter().map(|t| t.layers(slack)[k]).collect()).collect()
}

fn project(face: &Face, triangle: &Triangle, near: f64) -> impl Iterator<Item = Flat> {
    let local = triangle.map(|p| face.frame.local(p));
    // The light is at the origin: the side of the triangle's plane on which it is.
    let faces_light = (local[1] - local[0]).cross(local[2] - local[0]).dot(local[0]) < 0.0;
    let polygon = Polygon::new(&local).clip(|p: DVec3| p.z - near);
    let points = polygon.corners().iter().map(|p| {
        let at = DVec2::new(p.x / p.z - face.left, p.y / p.z - face.bottom) / face.texel;
        (at, face.z0 / p.z - 1.0)
    });
    let points: Vec<(DVec2, f64)> = points.collect();
    (2..points.len()).map(move |k| {
        let fan = [points[0], points[k - 1], points[k]];
        Flat { points: fan.map(|p| p.0), q: fan.map(|p| p.1), faces_light, rows: extremes(fan.iter().map(|p| p.0.y)) }
    })
}

fn fill(face: &Face, triangle: &Flat, first_row: usize, radius: f64, slack: f32, texels: &mut [Nearest]) {
    let [p0, p1, p2] = triangle.points;
    let (e1, e2) = (p1 - p0, p2 - p0);
    let area = e1.perp_dot(e2);
    let [q0, q1, q2] = triangle.q;
    let gradient = (e2.yx() * (q1 - q0) - e1.yx() * (q2 - q0)) * DVec2::new(1.0, -1.0) / area;
    let gradient = if gradient.is_finite() { gradient } else { DVec2::ZERO };
    let (low, high) = extremes(triangle.q.into_iter());
    let end_row = first_row + texels.len() / face.width;
    let from = (triangle.rows.0 - 0.5).ceil().clamp(first_row as f64, end_row as f64) as usize;
    let to = ((triangle.rows.1 - 0.5).floor() + 1.0).clamp(first_row as f64, end_row as f64) as usize;
    for j in from..to {
        let y = j as f64 + 0.5;
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        for (a, b) in [(p0, p1), (p1, p2), (p2, p0)] {
            let (a, b) = if a.y <= b.y { (a, b) } else { (b, a) };
            if a.y <= y && y <= b.y {
                let x = if b.y > a.y { a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)) } else { a.x };
                left = left.min(x);
                right = right.max(x);
            }
        }
        let width = face.width as f64;
        // Both triangles of a shared edge draw a texel on it, so that none is missed.
        let first = (left - 0.5 - 1e-7).ceil().clamp(0.0, width) as usize;
        let end = ((right - 0.5 + 1e-7).floor() + 1.0).clamp(0.0, width) as usize;
        for i in first..end {
            let at = DVec2::new(i as f64 + 0.5, y);
            let q = (q0 + gradient.dot(at - p0)).clamp(low, high);
            let z = face.z0 / (1.0 + q);
            let (u, v) = (face.left + at.x * face.texel, face.bottom + at.y * face.texel);
            if z * z * (1.0 + u * u + v * v) >= radius * radius {
                texels[(j - first_row) * face.width + i].add(usize::from(!triangle.faces_light), q as f32, slack);
            }
        }
    }
}
