//! GGX reflection as moment lobes: the rows of a table over the view's angle.

use core::f64::consts::{FRAC_PI_2, PI};

/// The families that `D` is split into: exponent of `n·h` times α², and scale times πα². A three-term fit of the GGX
/// distribution for small α, and a fourth term for the haze that its tail, falling only as `tan⁻⁴`, leaves around a
/// highlight. As *shares* of the exact distribution they lose nothing for any α.
const FAMILIES: [(f64, f64); 4] = [(4.344, 0.7216), (1.079, 0.2580), (0.1829, 0.0172), (0.012, 1e-4)];

/// The family that is all of the constant distribution of α = 1.
const BROAD: usize = 2;

/// α from which on the haze is none of its own.
const NO_HAZE: f64 = 0.3;

/// Number of families.
pub(crate) const FAMILY_COUNT: usize = FAMILIES.len();

/// Parts of a family that is spread over three lobes, and the moment `Σ w k²` of their places −1, 0, 1.
pub(crate) const SPREAD: [f32; 3] = [0.25, 0.5, 0.25];
const SPREAD_MOMENT: f64 = 0.5;

/// Families whose lobes are spread along the plane of incidence. The others are broad enough without.
const SPREAD_FAMILIES: usize = 2;

/// Largest distance of spread lobes, in units of their width `1/√(e+2)`: farther apart they would be beads.
const BEADS: f64 = 2.6;

/// Below this ratio of the exponents across and of the whole, one round lobe does.
const ROUND: f64 = 1.25;

/// Nodes in `t`, `tan θ_h = α t/(1−t)`, and in azimuth over half a turn (the other half mirrors it).
const RINGS: usize = 40;
const SECTORS: usize = 48;

/// One family seen under one angle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Family {
    /// `∫ f̃ (1 − s) dv` and `∫ f̃ s dv` with `F = 1`, `s = (1 − v·h)⁵`, over what of the lobes is above the horizon.
    pub(crate) flux: [f32; 2],
    /// Angle of the mean direction from the mirrored view, in the plane of incidence, positive away from the normal.
    pub(crate) tilt: f32,
    /// Angle between the lobes that it is spread over; 0 for one.
    pub(crate) spread: f32,
    /// Their exponent.
    pub(crate) exponent: f32,
}

/// The reflection at one angle of the view.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Row {
    pub(crate) families: [Family; FAMILY_COUNT],
}

impl Row {
    /// Between two rows.
    pub(crate) fn lerp(&self, other: &Self, t: f32) -> Self {
        let mix = |a: f32, b: f32| a + (b - a) * t;
        let families = core::array::from_fn(|k| {
            let (a, b) = (&self.families[k], &other.families[k]);
            Family {
                flux: [mix(a.flux[0], b.flux[0]), mix(a.flux[1], b.flux[1])],
                tilt: mix(a.tilt, b.tilt),
                spread: mix(a.spread, b.spread),
                exponent: mix(a.exponent, b.exponent),
            }
        });
        Self { families }
    }

    /// The row for `α` and the view at `sin`, `cos` to the normal; the lobes' shapes are those for the reflectance `f0`.
    ///
    /// Each family keeps its flux, its mean direction and its width across the plane of incidence. Along that plane a
    /// highlight is longer by `1/cos θ`: there the lobe is spread over three until the length of the mean vector is
    /// right too, or until they would be beads.
    pub(crate) fn new(alpha: f64, [sin, cos]: [f64; 2], f0: f64) -> Self {
        let mut sums = [Sums::default(); FAMILY_COUNT];
        let a2 = alpha * alpha;
        let shares: [f64; FAMILY_COUNT] = core::array::from_fn(|k| {
            let part = match k {
                BROAD => 1.0,
                0..BROAD => 1.0 - a2,
                _ => (1.0 - alpha / NO_HAZE).max(0.0),
            };
            FAMILIES[k].1 * part
        });
        let split = |c2: f64| {
            let ln = 0.5 * c2.ln() / a2;
            let mut parts: [f64; FAMILY_COUNT] = core::array::from_fn(|k| shares[k] * (FAMILIES[k].0 * ln).exp());
            let all: f64 = parts.iter().sum();
            parts.iter_mut().for_each(|p| *p /= all);
            if all <= 0.0 {
                // Beyond f64's range: where no family reaches, the tail is the broadest one's.
                let last = if alpha < NO_HAZE { FAMILY_COUNT - 1 } else { BROAD };
                parts = core::array::from_fn(|k| if k == last { 1.0 } else { 0.0 });
            }
            parts
        };
        half_vectors(alpha, [sin, cos], [RINGS, SECTORS], split, |parts, value, schlick, l| {
            for (sum, part) in sums.iter_mut().zip(parts) {
                sum.add(value * part, schlick, f0, l);
            }
        });
        let angle = sin.atan2(cos);
        Self { families: core::array::from_fn(|k| sums[k].family(angle, k < SPREAD_FAMILIES)) }
    }
}

/// Visits half vectors by rings: for each that reflects the view above the horizon what a ring gave, `D·W·dv`, `(1 − v·h)⁵` and the
/// direction that is reflected to (x away from the viewer, z the normal).
fn half_vectors<T>(
    alpha: f64,
    [sin, cos]: [f64; 2],
    [rings, sectors]: [usize; 2],
    ring: impl Fn(f64) -> T,
    mut visit: impl FnMut(&T, f64, f64, [f64; 3]),
) {
    let a2 = alpha * alpha;
    let turns: Vec<(f64, f64)> = (0..sectors).map(|j| (PI * (j as f64 + 0.5) / sectors as f64).sin_cos()).collect();
    for i in 0..rings {
        // Denser toward the ends: t = u²(3 − 2u).
        let u = (i as f64 + 0.5) / rings as f64;
        let t = u * u * (3.0 - 2.0 * u);
        let tan = alpha * t / (1.0 - t);
        let c2 = 1.0 / (1.0 + tan * tan);
        let (c, s) = (c2.sqrt(), tan * c2.sqrt());
        // dω = sin θ dθ dφ, dθ = cos²θ dtan.
        let area =
            s * c2 * alpha / ((1.0 - t) * (1.0 - t)) * 6.0 * u * (1.0 - u) / rings as f64 * (2.0 * PI / sectors as f64);
        let d = a2 / (PI * (c2 * (a2 - 1.0) + 1.0).powi(2));
        let of_ring = ring(c2);
        for &(sp, cp) in &turns {
            // x away from the viewer, y across, z the normal.
            let (hx, hy, hz) = (s * cp, s * sp, c);
            let vh = hz * cos - hx * sin;
            let (lx, ly, lz) = (2.0 * vh * hx + sin, 2.0 * vh * hy, 2.0 * vh * hz - cos);
            if vh <= 0.0 || lz <= 0.0 {
                continue;
            }
            // ω_h to ω_l is 4 v·h; f̃ = D·W.
            let smith = lz * (cos * cos * (1.0 - a2) + a2).sqrt() + cos * (lz * lz * (1.0 - a2) + a2).sqrt();
            visit(&of_ring, d * 0.5 * lz / smith * 4.0 * vh * area, (1.0 - vh).powi(5), [lx, ly, lz]);
        }
    }
}

/// The fraction of light that a view reflects, with `F = 1 − s` and with `F = s`, `s = (1 − v·h)⁵`.
pub(crate) fn reflected(alpha: f64, view: [f64; 2]) -> [f64; 2] {
    let mut sums = [0.0; 2];
    half_vectors(
        alpha,
        view,
        [24, 24],
        |_| (),
        |(), value, schlick, _| {
            sums[0] += value * (1.0 - schlick);
            sums[1] += value * schlick;
        },
    );
    sums
}

/// Moments of one family.
#[derive(Clone, Copy, Default)]
struct Sums {
    flux: [f64; 2],
    /// With `F = f0 + (1 − f0) s`.
    total: f64,
    mean: [f64; 2],
    across: f64,
}

impl Sums {
    fn add(&mut self, value: f64, schlick: f64, f0: f64, [x, y, z]: [f64; 3]) {
        self.flux[0] += value * (1.0 - schlick);
        self.flux[1] += value * schlick;
        let value = value * (f0 + (1.0 - f0) * schlick);
        self.total += value;
        self.mean[0] += value * x;
        self.mean[1] += value * z;
        self.across += value * y * y;
    }

    fn family(&self, view_angle: f64, spread: bool) -> Family {
        let [x, z] = self.mean;
        let length = x.hypot(z) / self.total;
        if length.is_nan() || length <= 0.0 {
            return Family::default();
        }
        let tilt = x.atan2(z);
        // A lobe has |M|/P = (e+1)/(e+2) and ⟨y²⟩ = 1/(e+3).
        let round = (1.0 / (1.0 - length) - 2.0).clamp(0.0, 1e7);
        let across = (self.total / self.across - 3.0).clamp(0.0, 1e7);
        let ratio = (across + 2.0) / (round + 2.0);
        let (mut exponent, mut apart) = (round, 0.0);
        if spread && ratio > ROUND {
            // From 1 at ROUND on, without a step.
            let ratio = ratio - (ROUND - 1.0) / (1.0 + ratio - ROUND);
            let ratio = ratio.min(1.0 + 0.5 * SPREAD_MOMENT * BEADS * BEADS);
            exponent = (ratio * (round + 2.0) - 2.0).min(1e7);
            // ½ + ½ cos δ is what the shares leave of the mean vector's length.
            let cos = 2.0 * length * (exponent + 2.0) / (exponent + 1.0) - 1.0;
            apart = cos.clamp(0.5, 1.0).acos();
        }
        let above: f64 = (-1..=1)
            .map(|k| f64::from(SPREAD[(k + 1) as usize]) * above_horizon(tilt + f64::from(k) * apart, exponent))
            .sum();
        Family {
            flux: self.flux.map(|f| (f / above) as f32),
            tilt: (tilt - view_angle) as f32,
            spread: apart as f32,
            exponent: exponent as f32,
        }
    }
}

/// Part of a lobe's flux above the horizon, its axis at an angle to the normal: `∫ cos^e` up to `π/2 − |tilt|` over
/// all of it, since a lobe is the same in every plane through the line in which both are cut.
fn above_horizon(tilt: f64, exponent: f64) -> f64 {
    let reach = (10.0 / (exponent + 1.0).sqrt()).min(FRAC_PI_2);
    let end = FRAC_PI_2 - tilt.abs();
    if end >= reach {
        return 1.0;
    }
    // Simpson's rule.
    let integral = |to: f64| {
        let n = 128;
        let step = (to + reach) / f64::from(n);
        let value = |i: i32| {
            let weight = if i == 0 || i == n { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
            weight * (-reach + f64::from(i) * step).cos().max(0.0).powf(exponent)
        };
        (0..=n).map(value).sum::<f64>() * step
    };
    integral(end.max(-reach)) / integral(reach)
}
