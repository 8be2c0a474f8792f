//! The visible fraction of a sphere light in f64, from the triangles alone.

use core::f64::consts::PI;
use glam::DVec3;
use lobe_core::{Receiver, Sphere};
use scene::{Scene, Shape};

/// Scan lines across the light's disc.
const LINES: usize = 512;

pub(crate) struct Truth {
    triangles: Vec<[DVec3; 3]>,
    objects: Vec<u32>,
    /// Circumscribed about each triangle: centre and radius.
    bounds: Vec<(DVec3, f64)>,
}

/// The light of one receiver, unshadowed and visible, as Lambert reflects it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Light {
    pub(crate) whole: f64,
    pub(crate) visible: f64,
    /// The facet's plane hides a part that the shading normal does not.
    pub(crate) is_cut: bool,
}

impl Truth {
    pub(crate) fn new(scene: &Scene) -> Self {
        let mut truth = Self { triangles: Vec::new(), objects: Vec::new(), bounds: Vec::new() };
        for (number, object) in scene.objects.iter().enumerate() {
            let Shape::Mesh(mesh) = &object.shape else { panic!("triangles only") };
            for corners in &mesh.triangles {
                let t = corners.map(|i| mesh.positions[i as usize].as_dvec3());
                let center = (t[0] + t[1] + t[2]) / 3.0;
                let radius = t.map(|p| p.distance(center)).into_iter().fold(0.0, f64::max);
                truth.triangles.push(t);
                truth.objects.push(number as u32);
                truth.bounds.push((center, radius));
            }
        }
        truth
    }

    /// The receiver's own facet: the nearest of its object's triangles that faces the same way or the opposite one.
    fn facet(&self, at: &Receiver) -> (usize, DVec3) {
        let p = at.position.as_dvec3();
        let mut best = (f64::INFINITY, 0, DVec3::ZERO);
        for (k, [a, b, c]) in self.triangles.iter().enumerate() {
            let (center, radius) = self.bounds[k];
            if self.objects[k] != at.object || p.distance(center) - radius > best.0.min(1e-3) {
                continue;
            }
            let n = (*b - *a).cross(*c - *a).normalize_or_zero();
            let n = if n.dot(at.face.as_dvec3()) < 0.0 { -n } else { n };
            // How far beside its edges the point lies, and off its plane.
            let beside = [(*a, *b), (*b, *c), (*c, *a)].map(|(from, to)| {
                let inward = n.cross(to - from).normalize_or_zero();
                let inward = if inward.dot(center - from) < 0.0 { -inward } else { inward };
                -inward.dot(p - from)
            });
            let beside = beside.into_iter().fold(0.0, f64::max);
            let off = beside + n.dot(p - *a).abs() + n.distance(at.face.as_dvec3());
            if off < best.0 {
                best = (off, k, n);
            }
        }
        (best.1, best.2)
    }

    /// Integrates `max(n·v, 0)` over the light, all of it and the part that neither the facet's plane nor another triangle
    /// hides. A triangle hides an exact interval of each scan line. The light is behind all triangles.
    pub(crate) fn light(&self, at: &Receiver, light: Sphere) -> Light {
        let (own, face) = self.facet(at);
        // Onto the facet: the rounding of the position is no fault of the method that is tested.
        let p = at.position.as_dvec3();
        let p = p + face * face.dot(self.triangles[own][0] - p);
        let to = light.center.as_dvec3() - p;
        let distance = to.length();
        let (axis, sin) = (to / distance, f64::from(light.radius) / distance);
        let tan = sin / (1.0 - sin * sin).sqrt();
        // Scan lines across the facet's edge.
        let right = (face - axis * face.dot(axis)).try_normalize().unwrap_or_else(|| axis.any_orthonormal_vector());
        let up = axis.cross(right);
        let local = |v: DVec3| DVec3::new(v.dot(right), v.dot(up), v.dot(axis));
        let (normal, plane) = (local(at.normal.as_dvec3()), local(face));
        let mut hidden: Vec<Vec<(f64, f64)>> = vec![Vec::new(); LINES];
        let line = |k: usize| tan * ((2 * k + 1) as f64 / LINES as f64 - 1.0);
        for (k, triangle) in self.triangles.iter().enumerate() {
            let (center, radius) = self.bounds[k];
            let c = center - p;
            let (along, aside) = (c.dot(axis), (c - axis * c.dot(axis)).length());
            let is_beside = aside > radius * 1.1 + (along + radius).max(0.0) * tan;
            if k == own || is_beside || along < -radius || along - radius > distance {
                continue;
            }
            let v = triangle.map(|corner| local(corner - p));
            if v.iter().all(|v| v.dot(plane) <= 1e-13 * v.length()) {
                continue;
            }
            let det = v[0].dot(v[1].cross(v[2]));
            if det.abs() <= 1e-13 * v[0].length() * v[1].length() * v[2].length() {
                continue;
            }
            let edges = [v[0].cross(v[1]), v[1].cross(v[2]), v[2].cross(v[0])].map(|e| e * det.signum());
            let (mut first, mut end) = (0, LINES);
            if v.iter().all(|v| v.z > 0.0) {
                let y = v.map(|v| (v.y / v.z / tan + 1.0) * 0.5 * LINES as f64);
                first = (y.into_iter().fold(f64::INFINITY, f64::min) - 1.0).clamp(0.0, LINES as f64) as usize;
                end = (y.into_iter().fold(0.0, f64::max) + 1.0).clamp(0.0, LINES as f64) as usize;
            }
            for (j, hidden) in hidden.iter_mut().enumerate().take(end).skip(first) {
                let ends = edges.iter().fold((-tan, tan), |ends, e| above(*e, line(j), ends));
                if ends.0 < ends.1 {
                    hidden.push(ends);
                }
            }
        }
        let mut sum = Light { whole: 0.0, visible: 0.0, is_cut: false };
        for (j, hidden) in hidden.iter_mut().enumerate() {
            let y = line(j);
            let half = (tan * tan - y * y).max(0.0).sqrt();
            let emits = above(normal, y, (-half, half));
            let part = |(from, to): (f64, f64)| if from < to { integral(normal, y, from, to) } else { 0.0 };
            sum.whole += part(emits);
            let open = above(plane, y, emits);
            sum.is_cut |= open != emits;
            hidden.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut reached = open.0;
            for (from, to) in hidden.iter() {
                sum.visible += part((reached, from.min(open.1)));
                reached = reached.max(*to);
            }
            sum.visible += part((reached, open.1));
        }
        let scale = 2.0 * tan / LINES as f64 / PI;
        Light { whole: sum.whole * scale, visible: sum.visible * scale, ..sum }
    }
}

/// The part of an interval of x where `n·(x, y, 1) ≥ 0`.
fn above(n: DVec3, y: f64, (from, to): (f64, f64)) -> (f64, f64) {
    let rest = n.y * y + n.z;
    if n.x > 0.0 {
        (from.max(-rest / n.x), to)
    } else if n.x < 0.0 {
        (from, to.min(-rest / n.x))
    } else if rest >= 0.0 {
        (from, to)
    } else {
        (0.0, 0.0)
    }
}

/// `∫ n·v dω/dy` over an interval of x, v the unit vector of (x, y, 1): three points of Gauss.
fn integral(n: DVec3, y: f64, from: f64, to: f64) -> f64 {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let at = |x: f64| n.dot(DVec3::new(x, y, 1.0)) / (1.0 + x * x + y * y).powi(2);
    let outer = half * 0.6_f64.sqrt();
    half / 9.0 * (8.0 * at(middle) + 5.0 * (at(middle - outer) + at(middle + outer)))
}
