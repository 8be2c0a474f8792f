use glam::{DVec3, Vec3};

/// A body with round ends, relative to the receiver: all points within a radius of a line between two ends.
///
/// Outlines of few corners reach a little beyond it. Lines of sight that pass it by up to [`RIM`](Self::RIM) of the radius therefore end beside it, as
/// if it had a rim there, which begins where they are nearest and grows by a quarter of the way from there on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// The middles of the spheres at its ends.
    pub ends: [Vec3; 2],
    /// Radius.
    pub radius: f32,
}

/// How fast the rim grows.
const GROWTH: f64 = 0.25;

impl Capsule {
    /// The width of the rim, in radii.
    pub const RIM: f32 = 0.06;

    /// How far behind the line of sight's nearest point the rim reaches, in radii.
    pub const RIM_DEPTH: f32 = Self::RIM / GROWTH as f32;

    /// How far a ray from the receiver, which is outside, goes along a unit direction before it enters the body or its rim; none if it passes beside
    /// both or leads away.
    ///
    /// # Cost
    /// Two or three square roots in double precision.
    ///
    /// ```
    /// use glam::Vec3;
    /// use lobe_core::Capsule;
    /// let tube = Capsule { ends: [Vec3::new(-1.0, 0.0, 3.0), Vec3::new(1.0, 0.0, 3.0)], radius: 0.5 };
    /// assert_eq!((tube.entry(Vec3::Z), tube.entry(Vec3::Y)), (Some(2.5), None));
    /// ```
    #[must_use]
    pub fn entry(&self, direction: Vec3) -> Option<f32> {
        let (v, [a, b]) = (direction.as_dvec3(), self.ends.map(|p| p.as_dvec3()));
        let (long, radius) = (b - a, f64::from(self.radius));
        let square = radius * radius;
        // Along the middle line, in its lengths. Distances across it decide whether the body's side is met.
        let all = long.length_squared();
        let [slope, start] = [v, a].map(|p| p.dot(long) / all);
        let [v_across, a_across] = [v - long * slope, a - long * start];
        let speed = v_across.length_squared();
        let along = v_across.dot(a_across) / speed;
        let left = square - (a_across - v_across * along).length_squared();
        if left >= 0.0 {
            let t = along - (left / speed).sqrt();
            if t > 0.0 && (0.0..=1.0).contains(&(slope * t - start)) {
                return Some(t as f32);
            }
        }
        let end = |center: DVec3| {
            let along = v.dot(center);
            let left = square - (center - v * along).length_squared();
            (along > 0.0 && left >= 0.0).then(|| along - left.sqrt())
        };
        let of_end = [a, b].into_iter().filter_map(end).reduce(f64::min);
        let beside = || {
            let far = a.length() + b.length() + radius;
            let (off, behind) = self.passes(v * far);
            let wide = off - radius;
            (behind < far && wide < f64::from(Self::RIM) * radius).then(|| far - behind + wide / GROWTH)
        };
        of_end.or_else(beside).map(|t| t as f32)
    }

    /// By how much the line of sight to a point comes nearer to the middle line than the radius, or, behind its nearest point, than the rim: below zero where the
    /// body hides the point. It changes by at most one and a quarter times as much as the point moves.
    #[must_use]
    pub fn off(&self, p: DVec3) -> f64 {
        let (off, behind) = self.passes(p);
        let radius = f64::from(self.radius);
        off - radius - (GROWTH * behind).min(f64::from(Self::RIM) * radius)
    }

    /// How near the line of sight to a point comes to the middle line, and how far behind the nearest point that is.
    fn passes(&self, p: DVec3) -> (f64, f64) {
        let (off, part) = distance_of_segments([DVec3::ZERO, p], self.ends.map(|p| p.as_dvec3()));
        (off, (1.0 - part) * p.length())
    }

    /// How far its farthest point is from a point.
    pub(super) fn reach_from(&self, p: Vec3) -> f32 {
        self.ends.iter().map(|end| end.distance(p)).fold(0.0, f32::max) + self.radius
    }
}

/// The distance of two segments, and where on the first one it is, from 0 to 1.
#[must_use]
pub fn distance_of_segments([a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> (f64, f64) {
    let (u, v, w) = (b - a, d - c, a - c);
    let [uu, uv, vv, uw, vw] = [u.dot(u), u.dot(v), v.dot(v), u.dot(w), v.dot(w)];
    let part = |over: f64, below: f64| if below > 0.0 { (over / below).clamp(0.0, 1.0) } else { 0.0 };
    let mut s = part(uv * vw - uw * vv, uu * vv - uv * uv);
    let t = (uv * s + vw) / vv;
    if t < 0.0 {
        s = part(-uw, uu);
    } else if t > 1.0 {
        s = part(uv - uw, uu);
    }
    let t = t.clamp(0.0, 1.0);
    ((w + u * s - v * t).length(), s)
}
