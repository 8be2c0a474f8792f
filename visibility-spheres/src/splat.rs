//! One sphere on the mask.

use crate::ellipse::Ellipse;
use fearless_simd::Simd;
use glam::{DVec3, Vec3};
use lighting::{Edges, MAX_DEPTH, Mask};
use lobe_core::Coverage;

/// An edge that runs along more than so many cells within one row is taken by area.
const FLAT: f32 = 4.0;

/// The directions that a sphere blocks, seen from a receiver: a cone about its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BlockedCone {
    /// From the receiver to the sphere's centre.
    pub(crate) to: Vec3,
    /// Its radius.
    radius: f32,
    /// Radius of the ball about the same centre whose tangent cone it is: `d sin β`.
    tangent_radius: f32,
    /// `cos β` of the half-angle.
    cos: f32,
    /// Centre and radius of the light, where the two intersect.
    pub(crate) meets_light: Option<(Vec3, f32)>,
}

impl BlockedCone {
    /// The cone that a sphere blocks under the self-distance τ; `None` if it is empty.
    #[inline]
    pub(crate) fn new(to: Vec3, radius: f32, tau: f32) -> Option<Self> {
        let d_sq = to.length_squared();
        let power = d_sq - radius * radius;
        let d = d_sq.sqrt();
        if power > 0.0 && tau * tau <= power {
            let cos = (power / d_sq).sqrt();
            return Some(Self { to, radius, tangent_radius: radius, cos, meets_light: None });
        }
        if tau <= 0.0 {
            // Inside the sphere of another object.
            return Some(Self { to, radius, tangent_radius: 0.0, cos: -1.0, meets_light: None });
        }
        // 1 − cos β = (r² − (d − τ)²)/(2τd).
        let above = (radius - (d - tau)) * (radius + (d - tau));
        if above <= 0.0 {
            return None;
        }
        let one_minus_cos = if d > 0.0 { (above / (2.0 * tau * d)).min(2.0) } else { 2.0 };
        let sin_sq = one_minus_cos * (2.0 - one_minus_cos);
        Some(Self { to, radius, tangent_radius: d * sin_sq.sqrt(), cos: 1.0 - one_minus_cos, meets_light: None })
    }

    /// How the cone covers a light's cone (axis, sin θ, cos θ). Says `Partial` when in doubt.
    #[inline]
    pub(crate) fn cover(&self, axis: Vec3, sin: f32, cos: f32) -> Coverage {
        if self.cos <= -1.0 {
            return if self.meets_light.is_some() { Coverage::Partial } else { Coverage::Dark };
        }
        let along = self.to.dot(axis);
        let aside = (self.to - axis * along).length();
        if self.cos >= 0.0 {
            // d sin(γ − θ) and d cos(γ − θ), γ the angle between the two axes.
            let (outside, toward) = (aside * cos - along * sin, along * cos + aside * sin);
            if outside >= self.tangent_radius || toward <= 0.0 {
                return Coverage::Lit;
            }
            let (far, far_toward) = (aside * cos + along * sin, along * cos - aside * sin);
            if self.meets_light.is_none() && far_toward > 0.0 && far <= self.tangent_radius {
                return Coverage::Dark;
            }
        } else {
            // Wider than a hemisphere: d cos(γ ∓ θ) against d cos β.
            let edge = self.cos * self.to.length();
            if along * sin <= aside * cos && along * cos + aside * sin <= edge {
                return Coverage::Lit;
            }
            if self.meets_light.is_none() && aside * cos + along * sin >= 0.0 && along * cos - aside * sin > edge {
                return Coverage::Dark;
            }
        }
        Coverage::Partial
    }

    /// `1 − cos β`.
    #[cfg(test)]
    pub(crate) fn one_minus_cos(&self) -> f32 {
        1.0 - self.cos
    }

    /// Adds its rim where that crosses the light's disc, as if the sphere were small and far: the turn of a mask need not be
    /// exact, only without steps.
    #[inline]
    pub(crate) fn add_edge(&self, axis: Vec3, tan: f32, edges: &mut Edges) {
        let along = self.to.dot(axis);
        let aside = self.to - axis * along;
        let disc = (along * tan).abs().max(f32::MIN_POSITIVE);
        edges.add_circle(aside, self.tangent_radius / disc, aside.length() / disc);
    }

    /// Whether a unit direction is in the cone.
    pub(crate) fn contains(&self, v: Vec3) -> bool {
        let along = self.to.dot(v);
        if self.cos > 0.0 {
            // Not by the cosine, which for a small cone has lost its digits.
            along > 0.0 && (self.to - v * along).length_squared() <= self.tangent_radius * self.tangent_radius
        } else {
            self.cos <= -1.0 || along >= self.cos * self.to.length()
        }
    }

    /// Blocks what of the mask is in the cone.
    #[inline(always)]
    pub(crate) fn splat<S: Simd>(&self, simd: S, mask: &mut Mask) {
        let local = mask.square().local(self.to);
        if self.cos > 0.0 && local.z > 1.001 * self.tangent_radius {
            Ellipse::new(local, self.tangent_radius, mask).splat(simd, mask);
        } else {
            self.splat_wide(local.as_dvec3(), mask);
        }
    }

    #[inline(never)]
    fn splat_wide(&self, local: DVec3, mask: &mut Mask) {
        if self.cos <= -1.0 {
            mask.block_all();
        } else {
            self.splat_rows(local, mask);
        }
    }

    /// Blocks where the ball is in front of the light that it meets (centre and radius): runs of cell centres, their ends
    /// found between two centres by bisection.
    pub(crate) fn splat_in_front(&self, light: Vec3, light_radius: f32, mask: &mut Mask) {
        let square = *mask.square();
        for j in 0..mask.side() {
            if mask.is_row_dark(j) {
                continue;
            }
            let hides = |x: f32| {
                let v = square.world(Vec3::new(x, mask.row_y(j), 1.0)).normalize();
                self.contains(v) && order_by_ray(v, self, light, light_radius)
            };
            let center = |i: usize| mask.cell_center(i, j).x;
            let mut spans = [(0.0, 0.0); 2];
            let (mut count, mut start) = (0, hides(center(0)).then_some(f32::NEG_INFINITY));
            for i in 1..mask.side() {
                if hides(center(i)) == start.is_some() {
                    continue;
                }
                let (mut before, mut after) = (center(i - 1), center(i));
                for _ in 0..8 {
                    let middle = 0.5 * (before + after);
                    if hides(middle) == start.is_some() { before = middle } else { after = middle }
                }
                let edge = 0.5 * (before + after);
                match start.take() {
                    None => start = Some(edge),
                    Some(from) if count < spans.len() => {
                        spans[count] = (from, edge);
                        count += 1;
                    }
                    Some(_) => {}
                }
            }
            for &(from, to) in &spans[..count] {
                mask.block_span(j, from, to);
            }
            if let Some(from) = start {
                mask.block_span(j, from, f32::INFINITY);
            }
        }
    }

    /// Any cone: in each row the blocked cells are between, or outside, the roots of a quadratic.
    fn splat_rows(&self, c: DVec3, mask: &mut Mask) {
        let d = c.length();
        let (m, cos) = (c / d.max(f64::MIN_POSITIVE), f64::from(self.cos));
        let flat = 2.0 * FLAT * mask.cell();
        let side = mask.side();
        let mut spans = [[(0.0, 0.0); 2]; 1 << MAX_DEPTH];
        for (j, spans) in spans[..side].iter_mut().enumerate() {
            *spans = row_spans(m, cos, mask.row_y(j));
        }
        for j in 0..side {
            if mask.is_row_dark(j) {
                continue;
            }
            let (below, above) = (spans[j.saturating_sub(1)], spans[(j + 1).min(side - 1)]);
            for k in 0..2 {
                // An edge that is farther than the window on both sides of the row moves there unseen.
                if (below[k].0 - above[k].0).abs() > flat || (below[k].1 - above[k].1).abs() > flat {
                    mask.block_area(j, |y| row_spans(m, cos, y)[k]);
                } else {
                    mask.block_span(j, spans[j][k].0, spans[j][k].1);
                }
            }
        }
    }
}

/// The one or two spans of the row `y` in which `m·p ≥ cos|p|`, `p = (x, y, 1)`, from left to right; empty ones else.
fn row_spans(m: DVec3, cos: f64, y: f32) -> [(f32, f32); 2] {
    const LIMIT: f64 = 1e9;
    let y = f64::from(y);
    let (along, e) = (m.y * y + m.z, y * y + 1.0);
    let inside = |x: f64| m.x * x + along >= cos * (x * x + e).sqrt();
    // (m·p)² = cos²|p|² as a x² + 2b x + c = 0.
    let (a, b, c) = (m.x * m.x - cos * cos, m.x * along, along * along - cos * cos * e);
    let mut roots = [-LIMIT, LIMIT];
    let discriminant = b * b - a * c;
    if discriminant > 0.0 {
        let q = -(b + discriminant.sqrt().copysign(b));
        let (r1, r2) = (q / a, if q == 0.0 { f64::NAN } else { c / q });
        let finite = |r: f64| if r.is_nan() { LIMIT } else { r.clamp(-LIMIT, LIMIT) };
        roots = [finite(r1).min(finite(r2)), finite(r1).max(finite(r2))];
    }
    let [left, right] = roots;
    let span =
        |from: f64, to: f64| if to > from && inside(0.5 * (from + to)) { Some((from as f32, to as f32)) } else { None };
    let empty = (0.0, 0.0);
    match (span(-LIMIT, left), span(left, right), span(right, LIMIT)) {
        (Some(a), None, c) => [a, c.unwrap_or(empty)],
        (None, None, Some(c)) => [empty, c],
        (None, Some(b), None) => [b, empty],
        (Some(a), Some(_), None) => [(a.0, right as f32), empty],
        (None, Some(b), Some(_)) => [empty, (b.0, LIMIT as f32)],
        (Some(_), Some(_), Some(_)) => [(-LIMIT as f32, LIMIT as f32), empty],
        (None, None, None) => [empty; 2],
    }
}

/// Whether, along the unit direction `v`, the ball is entered before the light (both seen from the origin). Inside the
/// ball counts as entered at 0.
pub(crate) fn order_by_ray(v: Vec3, ball: &BlockedCone, light: Vec3, light_radius: f32) -> bool {
    let entry = |center: Vec3, radius: f32| {
        let along = center.dot(v);
        // The distance of ray and centre directly: as a difference of squares it drowns a few hundred radii away.
        let half_sq = radius * radius - (center - v * along).length_squared();
        (along - half_sq.max(0.0).sqrt()).max(0.0)
    };
    entry(ball.to, ball.radius) < entry(light, light_radius)
}
