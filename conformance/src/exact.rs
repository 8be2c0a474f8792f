//! The visible fraction of any number of spheres, by quadrature in f64: what strategies are measured against.

use crate::case::{Case, Sphere64};
use core::f64::consts::PI;
use glam::{DVec2, DVec3};

/// Rows over the light's disc; the error of a fraction is below 1e-4.
const ROWS: u32 = 320;
/// Nodes and weights of Gauss and Legendre on [−1, 1].
const NODES: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];
/// A row is cut into so many parts, and at every rim that crosses it.
const PARTS: usize = 8;

/// The cone of directions in which a sphere is seen, in the light's frame.
struct Cap {
    axis: DVec3,
    cos: f64,
}

impl Cap {
    fn contains(&self, p: DVec3) -> bool {
        self.axis.dot(p) >= self.cos * p.length()
    }

    /// Where the rim may cross the row `y`: roots of `(m·p)² = cos²β |p|²`, `p = (x, y, 1)`.
    fn crossings(&self, y: f64) -> [f64; 2] {
        let (m, square) = (self.axis, self.cos * self.cos);
        let along = m.y * y + m.z;
        let (a, b, c) = (m.x * m.x - square, m.x * along, along * along - square * (y * y + 1.0));
        let root = (b * b - a * c).sqrt();
        [(-b + root) / a, (-b - root) / a]
    }
}

impl Case {
    /// Visible fraction of what the lobe reflects: rows of the plane at distance 1 before the light, whose disc has radius
    /// `tan θ` there, cut where something begins or ends.
    pub(crate) fn exact(&self) -> f64 {
        let (axis, theta) = self.cone();
        let (right, up) = axis.any_orthonormal_pair();
        let local = |v: DVec3| DVec3::new(right.dot(v), up.dot(v), axis.dot(v));
        let cap = |sphere: &Sphere64| {
            let to = sphere.center - self.position;
            let sin = sphere.radius / to.length();
            Cap { axis: local(to.normalize()), cos: ((1.0 - sin) * (1.0 + sin)).sqrt() }
        };
        let caps: Vec<Cap> = self.spheres.iter().map(cap).collect();
        let (normal, lobe) = (local(self.normal), local(self.lobe.0));
        let weight = |p: DVec3| {
            let length = p.length();
            let v = p / length;
            if normal.dot(v) <= 0.0 { 0.0 } else { lobe.dot(v).max(0.0).powf(self.lobe.1) / length.powi(3) }
        };
        let disc = theta.tan();
        let (mut whole, mut open) = (0.0, 0.0);
        let mut cuts = Vec::new();
        for row in 0..ROWS {
            // Chords in equal steps of their angle: smooth at the rim.
            let (sin, cos) = (PI * ((f64::from(row) + 0.5) / f64::from(ROWS) - 0.5)).sin_cos();
            let (y, half) = (disc * sin, disc * cos);
            cuts.clear();
            cuts.extend((0..=PARTS).map(|k| half * (2.0 * k as f64 / PARTS as f64 - 1.0)));
            cuts.push(-(normal.y * y + normal.z) / normal.x);
            cuts.extend(caps.iter().flat_map(|cap| cap.crossings(y)));
            cuts.retain(|x| x.abs() <= half);
            cuts.sort_by(f64::total_cmp);
            for pair in cuts.windows(2) {
                let at = |t: f64| DVec2::new(0.5 * (pair[0] + pair[1] + t * (pair[1] - pair[0])), y).extend(1.0);
                let part: f64 = NODES.iter().map(|(t, w)| w * weight(at(*t))).sum::<f64>() * (pair[1] - pair[0]) * cos;
                whole += part;
                if !caps.iter().any(|cap| cap.contains(at(0.0))) {
                    open += part;
                }
            }
        }
        if whole > 0.0 { open / whole } else { 1.0 }
    }
}
