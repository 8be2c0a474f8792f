use super::tanh_sinh::integrate;
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use glam::DVec3;

/// Integrand below `e^-DROP` of a segment's start is left out.
const DROP: f64 = 50.0;

/// A lobe above a horizon, to be integrated over a disc of light by [`cap`].
#[derive(Clone, Copy, Debug)]
pub struct CapLobe {
    /// Unit axis `a`.
    pub axis: DVec3,
    /// Exponent `e ≥ 0`.
    pub exponent: f64,
    /// Whether the lobe is multiplied by the receiver's cosine `n·v`.
    pub cosine: bool,
    /// Unit normal `n` of the receiver: nothing arrives from below its horizon.
    pub normal: DVec3,
}

/// `∫ max(a·v, 0)^e (n·v)^cosine dv` over `{l·v ≥ cos θ} ∩ {n·v > 0}`: a lobe over a uniform disc of light (flux of a
/// light of radiance 1).
///
/// In polar coordinates about the lobe's axis the integral over the azimuth is closed: each circle meets the disc and
/// the half-space in arcs. One integral remains over the polar angle, piecewise smooth between the angles at
/// which a circle touches the disc or the horizon or passes through a point where those two meet.
///
/// Half-angle θ in (0, π/2], exponents in [0, 1e6] (more works), axes anywhere. Relative error about 1e-11, relative to
/// the value with `a = l` where that is more than 1e5 times larger.
#[must_use]
pub fn cap(lobe: &CapLobe, light_axis: DVec3, half_angle: f64) -> f64 {
    let circles = Circles::new(lobe, light_axis, half_angle);
    let mut cuts = vec![0.0, FRAC_PI_2];
    cuts.extend(circles.light.touching());
    cuts.extend(circles.horizon.touching());
    cuts.extend(corners(lobe.normal, light_axis, half_angle).into_iter().flatten().map(|v| angle(lobe.axis, v)));
    cuts.retain(|x| (0.0..=FRAC_PI_2).contains(x));
    cuts.sort_by(f64::total_cmp);
    cuts.windows(2).map(|pair| segment(&circles, lobe, pair[0], pair[1])).sum()
}

/// Between two polar angles the integrand has no kink inside.
fn segment(circles: &Circles, lobe: &CapLobe, from: f64, to: f64) -> f64 {
    let whole = to - from;
    let power = |rho: f64| if lobe.exponent == 0.0 { 0.0 } else { lobe.exponent * ln_cos(rho) };
    let start = power(from);
    let mut window = whole;
    while window > 0.0 && power(from + 0.5 * window) < start - DROP {
        window *= 0.5;
    }
    let value = integrate(window, |x, _| {
        let rho = from + x;
        (power(rho) - start).exp() * rho.sin() * circles.weight(rho, lobe.cosine)
    });
    if value == 0.0 { 0.0 } else { value * start.exp() }
}

/// `ln cos ρ` without the cancellation of `cos ρ` near 1; ρ in [0, π/2].
fn ln_cos(rho: f64) -> f64 {
    if rho < 1.0 { (-2.0 * (0.5 * rho).sin().powi(2)).ln_1p() } else { (FRAC_PI_2 - rho).max(0.0).sin().ln() }
}

/// Angle between two unit vectors, precise for small and large ones alike.
fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// The points where the rim of the disc meets the horizon.
fn corners(n: DVec3, l: DVec3, half_angle: f64) -> Option<[DVec3; 2]> {
    let across = l.cross(n);
    let (sin_elevation, cos_sq) = (l.dot(n), across.length_squared());
    let excess = (half_angle.sin() - sin_elevation) * (half_angle.sin() + sin_elevation);
    if excess < 0.0 || cos_sq == 0.0 {
        return None;
    }
    let foot = (l - n * sin_elevation) * (half_angle.cos() / cos_sq);
    let side = across * (excess.sqrt() / cos_sq);
    Some([foot + side, foot - side])
}

/// A disc on the sphere, seen from the lobe's axis.
struct Disc {
    /// Angle from the lobe's axis to the disc's centre.
    distance: f64,
    half_angle: f64,
}

impl Disc {
    /// Polar angles of the circles that touch the rim.
    fn touching(&self) -> [f64; 3] {
        let (d, h) = (self.distance, self.half_angle);
        [(d - h).abs(), d + h, TAU - d - h]
    }

    /// Half the azimuth that the circle at polar angle `rho` spends inside: a spherical triangle of three known sides.
    fn half_arc(&self, rho: f64) -> f64 {
        let (d, h) = (self.distance, self.half_angle);
        let (inner, outer) = (0.5 * (h + rho - d), 0.5 * (h + d - rho));
        if inner <= 0.0 || outer <= 0.0 {
            return 0.0;
        }
        let (near, far) = (0.5 * (d + rho - h), 0.5 * (d + rho + h));
        if near <= 0.0 || far >= PI {
            return PI;
        }
        2.0 * (inner.sin() * outer.sin()).sqrt().atan2((far.sin() * near.sin()).sqrt())
    }
}

/// Circles about the lobe's axis and how much of each is lit.
struct Circles {
    light: Disc,
    horizon: Disc,
    /// Azimuth of the normal, counted from that of the light's centre.
    normal_azimuth: f64,
    /// Normal's component along the lobe's axis and across it.
    normal: (f64, f64),
}

impl Circles {
    fn new(lobe: &CapLobe, l: DVec3, half_angle: f64) -> Self {
        let (a, n) = (lobe.axis, lobe.normal);
        let (toward_light, toward_normal) = (l - a * a.dot(l), n - a * a.dot(n));
        Self {
            light: Disc { distance: angle(a, l), half_angle },
            horizon: Disc { distance: angle(a, n), half_angle: FRAC_PI_2 },
            normal_azimuth: a.dot(toward_light.cross(toward_normal)).atan2(toward_light.dot(toward_normal)),
            normal: (a.dot(n), a.cross(n).length()),
        }
    }

    /// `∫ (n·v)^cosine dφ` over the lit arcs of the circle at polar angle `rho`.
    fn weight(&self, rho: f64, cosine: bool) -> f64 {
        let (light, above) = (self.light.half_arc(rho), self.horizon.half_arc(rho));
        let (sin, cos) = rho.sin_cos();
        let arc = |turn: f64| {
            let centre = self.normal_azimuth + turn;
            let (from, to) = ((centre - above).max(-light), (centre + above).min(light));
            if from >= to {
                0.0
            } else if cosine {
                cos * self.normal.0 * (to - from) + sin * self.normal.1 * ((to - centre).sin() - (from - centre).sin())
            } else {
                to - from
            }
        };
        arc(-TAU) + arc(0.0) + arc(TAU)
    }
}

/// Irradiance of a horizontal receiver under a uniform sphere light, for radiance 1: `∫ max(n·v, 0)` over the disc of
/// half-angle σ whose centre stands at the angle β from the normal.
///
/// With `s = sin σ`: `π s² cos β` above the horizon, 0 below it, and where the horizon cuts the disc (|cos β| < s)
/// `s²(cos β·acos y − x·q) + atan(q/x)` with `x = √(1/s²−1)`, `y = −x cot β`, `q = √(1 − (cos β/s)²)`.
///
/// Relative error 1e-10 or below, down to `1 + cos β/s` = 1e-7: where the terms cancel, their series is summed instead.
#[must_use]
pub fn sphere_light_irradiance(cos_beta: f64, half_angle: f64) -> f64 {
    let (s, cos) = half_angle.sin_cos();
    if cos_beta >= s {
        return PI * s * s * cos_beta;
    }
    if cos_beta <= -s {
        return 0.0;
    }
    let q = ((s - cos_beta) * (s + cos_beta)).sqrt() / s;
    let height = cos_beta / s;
    let (u, w) = (s * q / cos, q / (cos * height.abs()));
    if height < 0.0 && w < 0.5 {
        // A sliver: 1/3 − g(w²)(1 + w² + u²) + u²(1 + u²)·D, with atan k = k − k³/3 + k⁵g(k²) and
        // D = (g(u²) − g(w²))/(w² − u²), by the series g(z) = Σ (−z)ⁿ/(2n + 5).
        let (a, b) = (w * w, u * u);
        let (mut g, mut divided, mut powers, mut power) = (0.0, 0.0, 0.0, 1.0);
        for n in 0..40 {
            let coefficient = if n % 2 == 0 { 1.0 } else { -1.0 } / f64::from(2 * n + 5);
            g += coefficient * power;
            divided -= coefficient * powers;
            powers = powers * b + power;
            power *= a;
        }
        let sliver = 1.0 / 3.0 - g * (1.0 + a + b) + b * (1.0 + b) * divided;
        return s * s * u * a * q * q * sliver;
    }
    let lit = s * s * cos_beta * q.atan2(-cos * height);
    if u > 0.3 {
        return lit - s * cos * q + u.atan();
    }
    // For a small light s·cos σ·q = u·(1 − s²) and atan u cancel: sum the series of atan u − u instead.
    let mut power = u;
    let series = (1..20).fold(0.0, |sum, k| {
        power *= -u * u;
        sum + power / f64::from(2 * k + 1)
    });
    lit + s * s * u + series
}

#[cfg(test)]
mod tests {
    use super::super::{Random, Zone, brute_force, lobe_integral, product};
    use super::*;

    fn close(a: f64, b: f64, relative: f64, what: &str) {
        assert!((a - b).abs() <= relative * b.abs(), "{what}: {a:e} {b:e} {:e}", (a / b - 1.0).abs());
    }

    fn lobe(axis: DVec3, exponent: f64, normal: DVec3) -> CapLobe {
        CapLobe { axis, exponent, cosine: false, normal }
    }

    #[test]
    fn on_axis_is_closed() {
        // ∫ from 0 to θ of cos^e sin: 2π(1−cos^(e+1) θ)/(e+1), horizon far away.
        for e in [0.0, 1e-6, 0.5, 1.0, 20.0, 1e3, 1e6] {
            for theta in [1e-6, 1e-3, 0.1, 0.7, FRAC_PI_2] {
                let exact = -lobe_integral(e) * ((e + 1.0) * ln_cos(theta)).exp_m1();
                close(cap(&lobe(DVec3::Z, e, DVec3::Z), DVec3::Z, theta), exact, 1e-11, &format!("{e} {theta}"));
            }
        }
    }

    #[test]
    fn hemisphere_light_gives_the_product() {
        // A hemisphere is a lobe of exponent 0; below no horizon (n = l) that is all.
        let mut random = Random::new(11);
        for _ in 0..100 {
            let (e, a, l) = (random.exponent(1e6), random.axis(), random.axis());
            let (value, exact) = (cap(&lobe(a, e, l), l, FRAC_PI_2), product(e, 0.0, angle(a, l)));
            assert!((value - exact).abs() < 1e-11 * exact + 1e-15 * lobe_integral(e), "{e} {value} {exact}");
        }
        // And with the cosine: a lobe of exponent 1.
        for _ in 0..100 {
            let (e, a, l) = (random.exponent(1e6), random.axis(), random.axis());
            let value = cap(&CapLobe { cosine: true, ..lobe(a, e, l) }, l, FRAC_PI_2);
            let exact = product(e, 1.0, angle(a, l));
            assert!((value - exact).abs() < 1e-11 * exact + 1e-15 * lobe_integral(e), "{e} {value} {exact}");
        }
    }

    #[test]
    fn lambert_is_the_closed_irradiance() {
        let mut random = Random::new(12);
        for _ in 0..300 {
            let theta = random.log_uniform(1e-5, FRAC_PI_2);
            let n = random.axis();
            let beta = (FRAC_PI_2 + random.between(-1.5, 1.2) * theta).clamp(0.0, PI);
            let l = random.axis_at(n, beta);
            let exact = sphere_light_irradiance(n.dot(l), theta);
            let scale = PI * theta.sin().powi(3);
            // Once as a lobe along the normal, once as the cosine of a constant lobe: different arcs.
            let as_lobe = cap(&lobe(n, 1.0, n), l, theta);
            let as_cosine = cap(&CapLobe { cosine: true, ..lobe(l, 0.0, n) }, l, theta);
            assert!((as_lobe - exact).abs() < 1e-8 * exact + 1e-9 * scale, "{theta} {beta} {as_lobe} {exact}");
            assert!((as_cosine - exact).abs() < 1e-8 * exact + 1e-9 * scale, "{theta} {beta} {as_cosine} {exact}");
        }
    }

    /// `∫ z·2φ(z) dz` over the heights of the directions seen, φ half the azimuth that the disc covers at height z: all terms
    /// are positive.
    fn by_heights(elevation: f64, theta: f64) -> f64 {
        let disc = Disc { distance: FRAC_PI_2 - elevation, half_angle: theta };
        let whole = elevation + theta;
        // From the top, where the arc ends with a root, to the horizon.
        integrate(whole, |_, up| {
            let rho = FRAC_PI_2 - up;
            let (inner, outer) = (0.5 * (whole - up), 0.5 * (theta + up - elevation));
            let (near, far) = (0.5 * (disc.distance + rho - theta), 0.5 * (disc.distance + rho + theta));
            let half = if near <= 0.0 {
                PI
            } else {
                2.0 * (inner.sin() * outer.sin()).sqrt().atan2((far.sin() * near.sin()).sqrt())
            };
            2.0 * half * up.sin() * up.cos()
        })
    }

    #[test]
    fn irradiance_by_heights() {
        let mut random = Random::new(15);
        for _ in 0..2000 {
            let theta = random.log_uniform(1e-9, FRAC_PI_2 * 0.999);
            // Within 1e-4 of the whole disc below the horizon, half above, any.
            let share = if random.bits().is_multiple_of(2) { random.log_uniform(1e-4, 1.0) } else { random.uniform() };
            let elevation = (share - 1.0) * theta;
            let (want, got) = (by_heights(elevation, theta), sphere_light_irradiance(elevation.sin(), theta));
            close(got, want, 1e-9, &format!("θ {theta} at {elevation}, {share}"));
        }
    }

    #[test]
    fn agrees_with_the_sphere() {
        // The rim is a border of the zone, so only horizon and lobe edge limit the plain rule: mean spacing squared.
        let mut random = Random::new(13);
        for _ in 0..24 {
            let theta = random.log_uniform(0.01, FRAC_PI_2);
            let l = random.axis();
            let a = random.axis_at(l, 0.0);
            let tilt = random.uniform() * 1.5 * theta;
            let a = random.axis_at(a, tilt);
            let beta = FRAC_PI_2 + random.between(-1.2, 1.0) * theta;
            let n = random.axis_at(l, beta.clamp(0.0, PI));
            let exponent = random.log_uniform(1.0, 20.0 / (theta * theta));
            let lobe = CapLobe { axis: a, exponent, cosine: random.bits().is_multiple_of(2), normal: n };
            let zone = Zone { axis: l, from: theta.cos(), to: 1.0, rings: 480, points: 960 };
            let f = |v: DVec3| {
                let cos = n.dot(v).max(0.0);
                a.dot(v).max(0.0).powf(exponent) * if lobe.cosine { cos } else { f64::from(cos > 0.0) }
            };
            let (sum, value) = (brute_force(f, &zone), cap(&lobe, l, theta));
            let full = cap(&CapLobe { axis: l, normal: l, ..lobe }, l, theta);
            let tolerance = if lobe.cosine { 3e-6 } else { 1e-3 };
            assert!((sum - value).abs() < tolerance * full, "{theta} {lobe:?}: {sum} {value}");
        }
    }

    #[test]
    fn halves_add_up() {
        // Both sides of any horizon together are the whole disc.
        let mut random = Random::new(14);
        for _ in 0..300 {
            let theta = random.log_uniform(1e-4, FRAC_PI_2);
            let (l, e) = (random.axis(), random.exponent(1e6));
            let off = random.log_uniform(1e-3, 2.0) * theta;
            let a = random.axis_at(l, off);
            let tilt = (FRAC_PI_2 + random.between(-1.2, 1.2) * theta).clamp(0.0, PI);
            let n = random.axis_at(l, tilt);
            let (above, below) = (cap(&lobe(a, e, n), l, theta), cap(&lobe(a, e, -n), l, theta));
            // Without a horizon: n = l, below which no part of the disc lies.
            let all = cap(&lobe(a, e, l), l, theta);
            let on_axis = cap(&lobe(l, e, l), l, theta);
            assert!((above + below - all).abs() < 1e-9 * all + 1e-14 * on_axis, "{theta} {e} {above} {below} {all}");
            assert!(above >= 0.0 && below >= 0.0 && all <= on_axis * (1.0 + 1e-9));
        }
    }

    #[test]
    fn degenerate_directions() {
        for e in [0.0, 1.0, 1e6] {
            for (a, l, n) in [
                (DVec3::Z, DVec3::Z, DVec3::NEG_Z),
                (DVec3::Z, DVec3::NEG_Z, DVec3::Z),
                (DVec3::Z, DVec3::NEG_Z, DVec3::NEG_Z),
                (DVec3::Z, DVec3::X, DVec3::Y),
                (DVec3::Z, DVec3::Z, DVec3::X),
            ] {
                for theta in [1e-9, 0.3, FRAC_PI_2] {
                    for cosine in [false, true] {
                        let value = cap(&CapLobe { axis: a, exponent: e, cosine, normal: n }, l, theta);
                        assert!(value.is_finite() && (0.0..=TAU).contains(&value), "{a} {l} {n} {e} {theta}");
                    }
                }
            }
        }
    }
}
