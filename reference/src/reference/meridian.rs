//! Exact visibility along a meridian of the light's cone.
//!
//! The horizon of the receiver hides a cap of directions, and so does each sphere wholly between receiver and light.
//! A half-plane through the cone's axis cuts a cap in one interval of polar angles, known in closed form: of the two
//! dimensions of the light only the azimuth has to be sampled, and the discontinuity of V, which makes shadow rays
//! converge slowly, is integrated away.

use crate::cone::LightCone;
use core::f64::consts::{PI, TAU};
use glam::DVec3;

/// A cap of hidden directions in the frame of the light's cone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cap {
    /// Unit direction of its centre: components along the cone's basis and axis.
    center: DVec3,
    cos_half_angle: f64,
}

impl Cap {
    /// The cap around the unit direction `center`.
    pub(crate) fn new(cone: &LightCone, center: DVec3, cos_half_angle: f64) -> Self {
        Self { center: cone.to_frame(center), cos_half_angle }
    }

    /// Interval of polar angles that it hides at an azimuth, unclipped; `None` where it hides none.
    fn interval(&self, sin: f64, cos: f64) -> Option<(f64, f64)> {
        // Hidden where a·cos θ + b·sin θ ≥ cos σ, that is A·cos(θ − δ) ≥ cos σ.
        let (a, b) = (self.center.z, self.center.x * cos + self.center.y * sin);
        let amplitude = a.hypot(b);
        if amplitude <= self.cos_half_angle {
            return None;
        }
        let half = (self.cos_half_angle / amplitude).acos();
        let middle = b.atan2(a);
        // A cap behind the axis reaches into this half-plane from the far side.
        let middle = if middle < half - PI { middle + TAU } else { middle };
        Some((middle - half, middle + half))
    }
}

/// The visible part of one meridian, in the coordinate `w = (1 − cos)/(1 − cos θ)` of [0, 1] in which the cone is uniform.
#[derive(Debug, Default)]
pub(crate) struct Meridian {
    hidden: Vec<(f64, f64)>,
    visible: f64,
}

impl Meridian {
    /// Collects the intervals that the caps hide at the azimuth.
    pub(crate) fn set<'c>(&mut self, cone: &LightCone, caps: impl Iterator<Item = &'c Cap>, azimuth: f64) {
        let (sin, cos) = azimuth.sin_cos();
        self.hidden.clear();
        let w = |theta: f64| {
            let s = (0.5 * theta.clamp(0.0, PI)).sin();
            (2.0 * s * s / cone.one_minus_cos()).min(1.0)
        };
        self.hidden.extend(caps.filter_map(|c| c.interval(sin, cos)).map(|(from, to)| (w(from), w(to))));
        self.hidden.retain(|(from, to)| from < to);
        self.hidden.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let (mut end, mut visible) = (0.0f64, 0.0);
        for (from, to) in &self.hidden {
            visible += (from - end).max(0.0);
            end = end.max(*to);
        }
        self.visible = visible + (1.0 - end).max(0.0);
    }

    /// Visible fraction of the meridian; exactly 0 or 1 at the limits.
    pub(crate) fn visible(&self) -> f64 {
        self.visible
    }

    /// The visible point with the fraction `u` of the visible part below it; `u` itself when nothing is hidden.
    pub(crate) fn point(&self, u: f64) -> f64 {
        let mut left = u * self.visible;
        let mut end = 0.0f64;
        for (from, to) in &self.hidden {
            let gap = (from - end).max(0.0);
            if left < gap {
                return end + left;
            }
            left -= gap;
            end = end.max(*to);
        }
        (end + left).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use lobe_core::Sphere;

    /// Against point-by-point tests of the caps: small and large lights, caps anywhere, a receiver inside the light.
    #[test]
    fn agrees_with_point_tests() {
        let mut state = 3u64;
        let mut r = || {
            state = crate::sobol::mix(state, 1);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let mut partial = 0;
        for _ in 0..3000 {
            let light = Sphere { center: Vec3::new(0.3, -0.5, 1.0), radius: (2.0 * r() * r()) as f32 };
            let cone = LightCone::new(Vec3::ZERO, light);
            let spread = cone.half_angle().max(0.01);
            let caps: Vec<Cap> = (0..3)
                .map(|_| {
                    let off = DVec3::new(r() - 0.5, r() - 0.5, r() - 0.5) * (4.0 * spread);
                    Cap::new(&cone, (cone.axis() + off).normalize(), (spread * r()).min(1.57).cos())
                })
                .collect();
            let azimuth = TAU * r();
            let mut meridian = Meridian::default();
            meridian.set(&cone, caps.iter(), azimuth);
            let hidden = |w: f64| {
                let v = cone.to_frame(cone.on_meridian(w, azimuth));
                caps.iter().any(|c| c.center.dot(v) >= c.cos_half_angle)
            };
            let n = 2000;
            let count = (0..n).filter(|i| !hidden((f64::from(*i) + 0.5) / f64::from(n))).count();
            // Each of at most six ends is off by half a cell.
            assert!((count as f64 / f64::from(n) - meridian.visible()).abs() < 3.5 / f64::from(n));
            if meridian.visible() > 1e-3 && meridian.visible() < 1.0 {
                partial += 1;
                for i in 0..20 {
                    // Not at the ends themselves, where rounding decides.
                    assert!(!hidden(meridian.point((f64::from(i) + 0.5) / 20.0)));
                }
            }
        }
        assert!(partial > 500, "{partial}");
    }
}
