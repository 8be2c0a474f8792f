//! The directions in which a receiver sees a light, in f64.

use core::f64::consts::{FRAC_PI_4, TAU};
use glam::{DVec3, Vec3};
use lobe_core::{Cone, Sphere};

/// A sphere of light seen from a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightCone {
    axis: DVec3,
    basis: (DVec3, DVec3),
    /// From the receiver to the light's centre.
    to_center: DVec3,
    radius: f64,
    distance: f64,
    one_minus_cos: f64,
}

/// Whether a receiver is inside the light and not on its surface.
fn is_inside(distance: f64, radius: f64) -> bool {
    distance <= f64::from(Cone::INSIDE) * radius
}

impl LightCone {
    pub(crate) fn new(position: Vec3, sphere: Sphere) -> Self {
        let to_center = sphere.center.as_dvec3() - position.as_dvec3();
        let (distance, radius) = (to_center.length(), f64::from(sphere.radius));
        let axis = if distance > 0.0 { to_center / distance } else { DVec3::Z };
        let one_minus_cos = if is_inside(distance, radius) {
            2.0
        } else {
            let sin_sq = (radius / distance).powi(2).min(1.0);
            sin_sq / (1.0 + (1.0 - sin_sq).sqrt())
        };
        Self { axis, basis: axis.any_orthonormal_pair(), to_center, radius, distance, one_minus_cos }
    }

    pub(crate) fn axis(&self) -> DVec3 {
        self.axis
    }

    pub(crate) fn one_minus_cos(&self) -> f64 {
        self.one_minus_cos
    }

    /// Half-angle, by way of the sine of its half.
    pub(crate) fn half_angle(&self) -> f64 {
        2.0 * (0.5 * self.one_minus_cos).sqrt().min(1.0).asin()
    }

    /// Density of [`sample`](Self::sample) per steradian.
    pub(crate) fn pdf(&self) -> f64 {
        1.0 / (TAU * self.one_minus_cos)
    }

    /// True when the cap of half-angle 90° around the unit vector `below` holds some of the cone but not all.
    pub(crate) fn cut_by(&self, below: DVec3) -> bool {
        let elevation = -self.axis.dot(below).clamp(-1.0, 1.0).asin();
        elevation.abs() < self.half_angle() + 1e-9
    }

    /// Start and length of the azimuths whose meridians are not wholly in the half-space around the unit vector `below`:
    /// for a light that has nearly set only a few are left.
    pub(crate) fn azimuths_beside(&self, below: DVec3) -> (f64, f64) {
        let b = self.to_frame(below);
        let (across, cos) = (b.x.hypot(b.y), 1.0 - self.one_minus_cos);
        if b.z <= 0.0 || cos <= 0.0 || across == 0.0 {
            return (0.0, TAU);
        }
        // The rim rises above the horizon where cos φ > tan(depth of the axis)/tan θ, φ from the upward direction.
        let sin = (self.one_minus_cos * (2.0 - self.one_minus_cos)).sqrt();
        let half = (b.z * cos / (across * sin)).clamp(-1.0, 1.0).acos();
        ((-b.y).atan2(-b.x) - half, 2.0 * half)
    }

    pub(crate) fn contains(&self, v: DVec3) -> bool {
        0.5 * (self.axis - v).length_squared() <= self.one_minus_cos
    }

    /// A direction uniform in solid angle. The square is mapped to the disc [concentrically](concentric) and the disc to
    /// the cap by `1 − cos = r²(1 − cos θ)`, both area-preserving and without tearing strata apart.
    #[inline]
    pub(crate) fn sample(&self, u: f64, v: f64) -> DVec3 {
        let (r, phi) = concentric(u, v);
        let fall = self.one_minus_cos * r * r;
        let sin = (fall * (2.0 - fall)).max(0.0).sqrt().copysign(r);
        let (s, c) = phi.sin_cos();
        (self.axis * (1.0 - fall) + (self.basis.0 * c + self.basis.1 * s) * sin).normalize()
    }

    /// The direction at azimuth `phi` whose fall `1 − cos` from the axis is the fraction `w` of the cone's.
    #[inline]
    pub(crate) fn on_meridian(&self, w: f64, phi: f64) -> DVec3 {
        let fall = self.one_minus_cos * w;
        let sin = (fall * (2.0 - fall)).max(0.0).sqrt();
        let (s, c) = phi.sin_cos();
        (self.axis * (1.0 - fall) + (self.basis.0 * c + self.basis.1 * s) * sin).normalize()
    }

    /// Components of `v` along the basis and the axis.
    pub(crate) fn to_frame(self, v: DVec3) -> DVec3 {
        DVec3::new(self.basis.0.dot(v), self.basis.1.dot(v), self.axis.dot(v))
    }

    /// Distance along `v` to the light's surface: the near one; from inside the light the only one.
    #[inline]
    pub(crate) fn surface(&self, v: DVec3) -> f64 {
        let along = self.to_center.dot(v);
        let across = (self.to_center - v * along).length_squared();
        let half = (self.radius * self.radius - across).max(0.0).sqrt();
        if is_inside(self.distance, self.radius) { along + half } else { along - half }
    }

    /// Distance of the farthest point of the sphere.
    pub(crate) fn far_side(&self) -> f64 {
        self.distance + self.radius
    }

    /// Largest and smallest value of [`surface`](Self::surface) inside the cone.
    pub(crate) fn surface_range(&self) -> (f64, f64) {
        let (d, r) = (self.distance, self.radius);
        if is_inside(d, r) { (r - d, d + r) } else { ((d - r).max(0.0), ((d - r) * (d + r)).max(0.0).sqrt()) }
    }
}

/// The unit square mapped to the unit disc, area-preserving and without tearing strata apart (P. Shirley, K. Chiu, *A Low
/// Distortion Map Between Disk and Square*, 1997): radius, which may be negative, and angle.
#[inline]
pub(crate) fn concentric(u: f64, v: f64) -> (f64, f64) {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    if a.abs() > b.abs() {
        (a, FRAC_PI_4 * (b / a))
    } else if b != 0.0 {
        (b, FRAC_PI_4 * (2.0 - a / b))
    } else {
        (0.0, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean direction of a uniform cap is its axis times (1 + cos θ)/2, and all samples are inside it; from 1e-6 rad to
    /// a receiver inside the light.
    #[test]
    fn samples_fill_the_cap() {
        for (radius, inside) in [(1e-6f32, false), (0.01, false), (0.5, false), (0.999, false), (1.5, true)] {
            let c = LightCone::new(Vec3::ZERO, Sphere { center: Vec3::new(0.0, 0.6, -0.8), radius });
            let n = 128;
            let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n);
            let mut fall = 0.0;
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let v = c.sample(at(i), at(j));
                assert!(inside || 0.5 * (c.axis() - v).length_squared() <= c.one_minus_cos() * (1.0 + 1e-9));
                fall += 0.5 * (c.axis() - v).length_squared() / f64::from(n * n);
                let (near, far) = c.surface_range();
                let t = c.surface(v);
                assert!(t > near - 1e-9 && t < far + 1e-6, "{near} {t} {far}");
            }
            // Midpoint rule of r² over the disc: error about 1/n².
            assert!((fall / c.one_minus_cos() - 0.5).abs() < 1e-4, "{radius}: {fall}");
        }
    }
}
