use super::gauss::Gauss;
use core::f64::consts::TAU;
use glam::DVec3;

/// A zone of the sphere about an axis and how finely [`brute_force`] samples it.
#[derive(Clone, Copy, Debug)]
pub struct Zone {
    /// Unit axis.
    pub axis: DVec3,
    /// Lowest `axis·v`, in [−1, 1].
    pub from: f64,
    /// Highest `axis·v`, in [−1, 1].
    pub to: f64,
    /// Rings; rounded up to a multiple of 8.
    pub rings: usize,
    /// Points on each ring.
    pub points: usize,
}

impl Zone {
    /// The whole sphere with `rings` rings of `2·rings` points.
    #[must_use]
    pub const fn sphere(axis: DVec3, rings: usize) -> Self {
        Self { axis, from: -1.0, to: 1.0, rings, points: 2 * rings }
    }
}

/// `∫ f(v) dv` over a zone of the unit sphere: 8-point Gauss–Legendre panels in `z = axis·v` times the midpoint rule in
/// longitude.
///
/// Exponentially convergent for smooth `f`; about `1/rings` where `f` jumps. Cost: `rings·points` evaluations.
#[must_use]
pub fn brute_force(f: impl Fn(DVec3) -> f64, zone: &Zone) -> f64 {
    let (u, w) = zone.axis.any_orthonormal_pair();
    let gauss = Gauss::new(8);
    let panels = zone.rings.div_ceil(8).max(1);
    let step = TAU / zone.points as f64;
    let ring = |z: f64| {
        let r = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
        let at = |i: usize| {
            let (sin, cos) = ((i as f64 + 0.5) * step).sin_cos();
            f(zone.axis * z + (u * cos + w * sin) * r)
        };
        step * (0..zone.points).map(at).sum::<f64>()
    };
    gauss.composite(zone.from, zone.to, panels, ring)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn area_and_cosine() {
        let zone = Zone::sphere(DVec3::new(0.6, 0.0, 0.8), 16);
        assert!((brute_force(|_| 1.0, &zone) - 2.0 * TAU).abs() < 1e-12);
        assert!((brute_force(|v| v.y * v.y, &zone) - 2.0 * TAU / 3.0).abs() < 1e-12);
        let half = Zone { from: 0.0, ..zone };
        assert!((brute_force(|v| zone.axis.dot(v), &half) - 0.5 * TAU).abs() < 1e-12);
    }
}
