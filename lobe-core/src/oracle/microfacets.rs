use super::gauss::Gauss;
use core::f64::consts::{PI, TAU};
use glam::{DVec2, DVec3};

/// Microfacets of the GGX distribution, seen from above the horizon of the normal `z`.
#[derive(Clone, Copy, Debug)]
pub struct CapMicrofacets {
    /// Direction to the eye.
    pub view: DVec3,
    /// Roughness `α`.
    pub alpha: f64,
}

impl CapMicrofacets {
    /// `D·W·(1 − s)` and `D·W·s`, see [`Microfacets`](crate::Microfacets).
    #[must_use]
    pub fn value(&self, v: DVec3) -> [f64; 2] {
        if v.z <= 0.0 {
            return [0.0; 2];
        }
        let (h, a2, o) = ((self.view + v).normalize(), self.alpha * self.alpha, self.view);
        let d = a2 / (PI * (a2 * h.z * h.z + h.truncate().length_squared()).powi(2));
        let masking = |a: f64, b: f64| a * (b * b * (1.0 - a2) + a2).sqrt();
        let w = 0.5 * v.z / (masking(v.z, o.z) + masking(o.z, v.z));
        let s = (1.0 - o.dot(h)).max(0.0).powi(5);
        [d * w * (1.0 - s), d * w * s]
    }

    /// The integrals of both over all directions above the horizon, in polar coordinates of slopes about the normal.
    #[must_use]
    pub fn albedo(&self) -> [f64; 2] {
        let (v, rule, sectors) = (self.view, Gauss::new(16), 400);
        let mut sum = [0.0; 2];
        for i in 0..sectors {
            let ray = DVec2::from_angle(PI * (f64::from(i) + 0.5) / f64::from(sectors));
            let vr = v.truncate().dot(ray);
            let horizon = vr / v.z + (vr * vr / (v.z * v.z) + 1.0).sqrt();
            for (part, sum) in sum.iter_mut().enumerate() {
                *sum += rule.composite(0.0, (horizon / self.alpha).atan(), 16, |angle| self.of_slope(ray, angle)[part])
                    * (TAU / f64::from(sectors));
            }
        }
        sum
    }

    /// Both parts at the half vector of slope `α tan ψ` along a ray, by the area of the plane of slopes per angle ψ.
    fn of_slope(&self, ray: DVec2, angle: f64) -> [f64; 2] {
        let r = self.alpha * angle.tan();
        let h = (ray * r).extend(1.0).normalize();
        let vh = self.view.dot(h);
        if vh <= 0.0 {
            return [0.0; 2];
        }
        // dω_h = h_z³ d²s, dω_l = 4 (ω_o·h) dω_h.
        let area = r * self.alpha / angle.cos().powi(2) * h.z.powi(3) * 4.0 * vh;
        self.value(2.0 * vh * h - self.view).map(|value| area * value)
    }

    /// The integrals of both over what of a cone of directions is above the horizon.
    ///
    /// In polar coordinates of the half vector's slopes about the normal, along each of `sectors` rays that meet the light from one end
    /// of it to the other: the cone `l·c > C` is `2(ω_o·h)(c·h) − (ω_o·c + C)|h|² > 0`.
    #[must_use]
    pub fn over_cap(&self, axis: DVec3, half_angle: f64, sectors: u32) -> [f64; 2] {
        let (v, c, rule) = (self.view, axis, Gauss::new(16));
        let k = v.dot(c) + half_angle.cos();
        let mut sum = [0.0; 2];
        for (angle, weight) in rays(v, c, k, sectors) {
            let ray = DVec2::from_angle(angle);
            let (vr, cr) = (v.truncate().dot(ray), c.truncate().dot(ray));
            // a r² + 2 b r + d > 0.
            let (a, b, d) = (2.0 * vr * cr - k, vr * c.z + v.z * cr, 2.0 * v.z * c.z - k);
            let root = (b * b - a * d).max(0.0).sqrt();
            let ends = [(-b - root) / a, (-b + root) / a];
            let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            // The horizon ends it: r² − 2 r v_r/v_z − 1 < 0.
            let horizon = vr / v.z + (vr * vr / (v.z * v.z) + 1.0).sqrt();
            let inside = match (a < 0.0, b * b > a * d) {
                (true, true) => [(low, high), (0.0, 0.0)],
                (true, false) => continue,
                (false, true) => [(0.0, low), (high, horizon)],
                (false, false) => [(0.0, horizon), (0.0, 0.0)],
            };
            for (from, to) in inside.map(|(a, b)| (a.max(0.0), b.min(horizon))) {
                // r = α tan ψ. No range where `to` is less.
                let angles = [from, to.max(from)].map(|r| (r / self.alpha).atan());
                let at = |angle: f64, part: usize| {
                    let h = (ray * self.alpha * angle.tan()).extend(1.0).normalize();
                    let l = 2.0 * v.dot(h) * h - v;
                    if l.dot(c) < half_angle.cos() - 1e-9 { 0.0 } else { self.of_slope(ray, angle)[part] }
                };
                for (part, sum) in sum.iter_mut().enumerate() {
                    *sum += rule.composite(angles[0], angles[1], 4, |angle| at(angle, part)) * weight;
                }
            }
        }
        sum
    }
}

/// Angles and weights of rays that meet the cone: those where the discriminant `b² − ad` is positive, which is
/// `A cos 2φ + B sin 2φ + C`. Towards the ends of a range, where the way through the cone shrinks like a root, they are denser.
/// Where a ray stays in the cone to its end (`a ≥ 0`): all around, in more steps.
fn rays(v: DVec3, c: DVec3, k: f64, sectors: u32) -> Vec<(f64, f64)> {
    let (p, d) = (c.z * v.truncate() + v.z * c.truncate(), 2.0 * v.z * c.z - k);
    let form =
        [p.x * p.x - 2.0 * d * v.x * c.x, p.y * p.y - 2.0 * d * v.y * c.y, p.x * p.y - d * (v.x * c.y + v.y * c.x)];
    let (first, second, mean) = (0.5 * (form[0] - form[1]), form[2], 0.5 * (form[0] + form[1]) + k * d);
    let (middle, most) = (0.5 * second.atan2(first), first.hypot(second));
    let (flat_v, flat_c) = (v.truncate(), c.truncate());
    let stays = flat_v.dot(flat_c) + flat_v.length() * flat_c.length() >= k;
    let sectors = if stays { 20 * sectors } else { sectors };
    let step = |i: u32| (f64::from(i) + 0.5) / f64::from(sectors);
    if stays || mean >= most {
        return (0..sectors).map(|i| (TAU * step(i), TAU / f64::from(sectors))).collect();
    }
    let half = 0.5 * (-mean / most).min(1.0).acos();
    let side = |start: f64| {
        (0..sectors).map(move |i| {
            // The midpoint rule in an angle whose cosine is the place.
            let (sin, cos) = (PI * step(i)).sin_cos();
            (start + half * cos, half * sin * PI / f64::from(sectors))
        })
    };
    side(middle).chain(side(middle + PI)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::Random;
    use super::*;

    /// Against directions drawn from the cone.
    #[test]
    fn integrals_are_those_of_random_directions() {
        let mut random = Random::new(3);
        for (tilt, light, half_angle, alpha) in
            [(0.3, 0.35, 0.1, 0.09), (1.2, 1.1, 0.4, 0.3), (0.9, 1.4, 0.3, 0.2), (1.478, 1.478, 0.382, 0.35)]
        {
            let microfacets = CapMicrofacets { view: DVec3::new(f64::sin(tilt), 0.0, f64::cos(tilt)), alpha };
            let axis = DVec3::new(-f64::sin(light), 0.01, f64::cos(light)).normalize();
            let got = microfacets.over_cap(axis, half_angle, 400);
            let (count, mut sum) = (400_000, [0.0; 2]);
            for _ in 0..count {
                let angle = (1.0 - random.uniform() * (1.0 - half_angle.cos())).acos();
                let f = microfacets.value(random.axis_at(axis, angle));
                sum = [0, 1].map(|i| sum[i] + f[i]);
            }
            let cone = TAU * (1.0 - half_angle.cos()) / f64::from(count);
            for (got, want) in got.iter().zip(sum.map(|s| s * cone)) {
                assert!((got / want - 1.0).abs() < 0.01, "{got} {want}");
            }
        }
    }
}
