//! The integrals of lobes of microfacets over a light's cone: in the plane of half vectors a cosine lobe over an ellipse.

use super::brushed::{masked, sheared};
use super::ellipse::{above_zero, chords_of, moments, root_of};
use super::pair::Pair;
use crate::microfacets::{alpha_sq, masking, schlick, seen_from};
use crate::special::atan2;
use core::f32::consts::FRAC_1_PI;
use glam::Vec3;

/// An end of a chord that reaches down to the plane of the surface.
pub(super) const FAR: f32 = 1e4;

/// `cos τ` and `weight·sin τ` of the Gauss–Legendre rule for τ in (0, π), which takes square-root edges and none alike: one half,
/// the other mirrors it.
pub(super) const TEN: [(f32, f32); 5] = [
    (0.999_160_1, 0.004_291_303),
    (0.977_620_9, 0.049_387_01),
    (0.875_859_5, 0.166_070_36),
    (0.629_396_15, 0.328_678_17),
    (0.231_725_67, 0.451_573_16),
];
pub(super) const THIRTY_TWO: [(f32, f32); 16] = [
    (0.999_990_76, 4.7383545e-05),
    (0.999_744_6, 0.00057772718),
    (0.998_468_5, 0.002_206_602_4),
    (0.994_777_1, 0.005_495_235),
    (0.986_767_9, 0.010_909_787),
    (0.972_137_6, 0.018_778_106),
    (0.948_343_3, 0.029_243_98),
    (0.912_808_5, 0.042_224_581),
    (0.863_166_4, 0.057_379_32),
    (0.797_525_16, 0.074_099_58),
    (0.714_728_97, 0.091_527_925),
    (0.614_582_84, 0.108_612_01),
    (0.498_006_13, 0.124_192_77),
    (0.367_083_52, 0.137_119_41),
    (0.224_993_17, 0.146_377_13),
    (0.075_808_704, 0.151_208_44),
];

/// The nodes of a whole light, or of one that the horizon crosses.
#[inline(always)]
pub(super) fn nodes<const IS_CUT: bool>() -> impl Iterator<Item = (f32, f32)> {
    let half: &[(f32, f32)] = if IS_CUT { &THIRTY_TWO } else { &TEN };
    half.iter().map(|(cos, weight)| (-cos, *weight)).chain(half.iter().rev().copied())
}

/// The numbers that all chords share. Twelve numbers, so that many of them lie in columns.
///
/// The slopes of half vectors over α, `σ = h_xy/(α h_z)`, turn `D(h)·(n·h) dω_h` into `d²σ/π(1+|σ|²)²`, a cosine lobe seen
/// through a plane, and the light's cone into an ellipse. Frame: x and y along and across the chords, z the normal. The rest of the reflectance changes most
/// toward and away from the lobe's middle, and so chords run across that.
///
/// Nodes are even in `y/√(w² + y²)`: w is α where the ellipse reaches the lobe's middle, and grows with the gap between both, as what a chord at y adds
/// falls ever more slowly with y then.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Ellipse {
    view: Vec3,
    light: Vec3,
    one_minus_cos: f32,
    alpha_sq: f32,
    /// `w/α`.
    width: f32,
    /// Middle and half of the chords' places, `y/√(w² + y²)`.
    middle: f32,
    half: f32,
    shadowing: f32,
}

/// The slopes between which chords meet the light: `a·z² − 2b·z − d ≤ 0` about the half vector of the light's middle.
#[inline(always)]
fn ends(view: Vec3, light: Vec3, omc: f32) -> (f32, f32) {
    let ([_, v2, vz], [_, c2, cz]) = (view.to_array(), light.to_array());
    let (height, sin_sq) = (vz + cz, omc * (2.0 - omc));
    let y0 = (v2 + c2) / above_zero(height);
    let tilt = v2 - y0 * vz;
    let a = height * height - 2.0 * omc * vz * cz - sin_sq;
    let b = omc * tilt * (vz - cz) + sin_sq * y0;
    let d = omc * ((2.0 - omc) * (1.0 + y0 * y0) - 2.0 * tilt * tilt);
    let root = root_of(b * b + a * d);
    (y0 + (b - root) / a, y0 + (b + root) / a)
}

/// The same of the part of the light above the horizon. `flat` is the squared length of the light's direction along the surface.
#[inline(always)]
fn ends_above(view: Vec3, light: Vec3, omc: f32, flat: f32, ends: (f32, f32)) -> (f32, f32) {
    let ([_, v2, vz], [c1, c2, cz]) = (view.to_array(), light.to_array());
    let (height, sin_sq) = (vz + cz, omc * (2.0 - omc));
    let (low, high) = if height > 0.05 {
        ends
    } else {
        // About the normal: near the horizon the half vector of the middle may be below it.
        let across = v2 + c2;
        let a = height * height - 2.0 * omc * vz * cz - sin_sq;
        let b = omc * (v2 * cz + c2 * vz) - across * height;
        let d = across * across - 2.0 * omc * v2 * c2 - sin_sq;
        let root = root_of(b * b - a * d);
        let q = -b - if b < 0.0 { -root } else { root };
        (q / a, d / if q.abs() > 1e-30 { q } else { 1e-30 })
    };
    // Where a line of half vectors touches the light: is that one direction above the horizon?
    let touches = |y: f32| {
        let over = 1.0 / (1.0 + y * y);
        let (mu, nu) = (v2 - y * vz, c2 - y * cz);
        let of_view = root_of(1.0 - mu * mu * over);
        let of_light = root_of(1.0 - nu * nu * over);
        let scale = of_view / if of_light > 1e-6 { of_light } else { 1e-6 };
        // l = −(ω_o·m) m + the rest of the light's direction; its height, and whether it is on the rim.
        let up = y * over * (mu + nu * scale) + cz * scale;
        let inside = of_view * of_light - mu * nu * over;
        up > 0.0 && (inside - (1.0 - omc)).abs() < 1e-3 && y.abs() < FAR
    };
    // Where the rim meets the horizon, and the horizon's own ends where the light has them.
    let cos = 1.0 - omc;
    let along = cos / if flat > 1e-12 { flat } else { 1e-12 };
    let beside = root_of(1.0 - cos * along) / root_of(if flat > 1e-12 { flat } else { 1e-12 });
    let (one, other) = ((v2 + c2 * along + c1 * beside) / vz, (v2 + c2 * along - c1 * beside) / vz);
    let (least, most) = if one < other { (one, other) } else { (other, one) };
    let least = if c2 < -cos { (v2 - 1.0) / vz } else { least };
    let most = if c2 > cos { (v2 + 1.0) / vz } else { most };
    let lower = |a: f32, b: f32| if a < b { a } else { b };
    let upper = |a: f32, b: f32| if a > b { a } else { b };
    let (low_counts, high_counts) = (touches(low), touches(high));
    let least = lower(least, if low_counts { low } else { least });
    let least = lower(least, if high_counts { high } else { least });
    let most = upper(most, if low_counts { low } else { most });
    (least, upper(most, if high_counts { high } else { most }))
}

impl Ellipse {
    #[inline(always)]
    pub(super) fn new<const IS_CUT: bool>(pair: &Pair) -> Self {
        let n = pair.normal;
        let (vz, sin, forward) = seen_from(n, pair.axis);
        let aside = n.cross(forward);
        let (cx, cy, cz) = (forward.dot(pair.light), aside.dot(pair.light), n.dot(pair.light));
        let alpha_sq = alpha_sq(pair.exponent);
        let omc = pair.one_minus_cos;
        let ([ex, ey], gap) = chords_of::<IS_CUT>(&moments([sin, 0.0, vz], [cx, cy, cz], omc));
        let view = Vec3::new(sin * ex, -sin * ey, vz);
        let light = Vec3::new(cx * ex + cy * ey, cy * ex - cx * ey, cz);
        let shadowing = (vz * vz * (1.0 - alpha_sq) + alpha_sq).sqrt();
        Self::between::<IS_CUT>(view, light, omc, (alpha_sq, gap / alpha_sq.sqrt()), (cx * cx + cy * cy, shadowing))
    }

    /// Seen along the chords; `flat` is the squared length of the light's direction along the surface. The gap is in α.
    #[inline(always)]
    pub(super) fn between<const IS_CUT: bool>(
        view: Vec3,
        light: Vec3,
        omc: f32,
        (alpha_sq, gap): (f32, f32),
        (flat, shadowing): (f32, f32),
    ) -> Self {
        let ends = ends(view, light, omc);
        let (low, high) = if IS_CUT { ends_above(view, light, omc, flat, ends) } else { ends };
        let width_sq = 1.0 + gap * gap;
        let place = |y: f32| y / (width_sq * alpha_sq + y * y).sqrt();
        let (low, high) = (place(low), place(high));
        let half = 0.5 * (high - low);
        Self {
            view,
            light,
            one_minus_cos: omc,
            alpha_sq,
            width: width_sq.sqrt(),
            middle: 0.5 * (low + high),
            half: if half > 0.0 { half } else { 0.0 },
            shadowing,
        }
    }

    /// The factor of the sum of all chords.
    #[inline(always)]
    pub(super) fn weight(&self) -> f32 {
        self.half * FRAC_1_PI
    }

    /// One chord of both lobes of a pair, the one that is the same at all angles and the edge, times its weight.
    #[inline(always)]
    pub(super) fn node<const IS_CUT: bool>(&self, cos: f32, weight: f32) -> [f32; 2] {
        self.node_of::<IS_CUT, false>(cos, weight, [self.alpha_sq.sqrt(), 0.0])
    }

    /// The same, with `α` along the chords and the shear of the stretched slopes along them.
    #[inline(always)]
    pub(super) fn node_of<const IS_CUT: bool, const IS_BRUSHED: bool>(
        &self,
        cos: f32,
        weight: f32,
        [along, shear]: [f32; 2],
    ) -> [f32; 2] {
        let ([v1, v2, vz], [c1, c2, cz]) = (self.view.to_array(), self.light.to_array());
        let alpha = self.alpha_sq.sqrt();
        let t = self.middle + self.half * cos;
        let rest = (1.0 - t) * (1.0 + t);
        let y = self.width * t / if rest > 1e-12 { rest } else { 1e-12 }.sqrt();
        let slope = alpha * y;
        // From a step of places to dy, less the chord's own part of the cosine lobe.
        let square = rest + self.width * self.width * (t * t);
        let weight = weight * self.width / (square * square.sqrt());
        let root = (1.0 + slope * slope).sqrt();

        // The plane of half vectors across m = (0, 1, −slope)/root cuts directions by l·m = −ω_o·m: an arc 2φ of the light.
        let over = 1.0 / root;
        let (mu, nu) = ((v2 - slope * vz) * over, (c2 - slope * cz) * over);
        let beside = ((v2 + c2) - slope * (vz + cz)) * over;
        let clear = |x: f32| if x > 1e-12 { x } else { 1e-12 };
        let (of_view, of_light) = (clear(1.0 - mu * mu), clear(1.0 - nu * nu));
        let product = (of_view * of_light).sqrt();
        // 1 − cos φ without cancellation.
        let arc = (self.one_minus_cos - beside * beside / clear(product + 1.0 + mu * nu)) / product;
        let hits = arc > 0.0;
        let all = arc >= 1.9999;
        let arc = if all { 1.9999 } else { arc };
        let tan = (if hits { arc } else { 0.0 } / (2.0 - arc)).sqrt();
        // Half vectors: φ/2 about the middle between eye and light, of which only the tangent counts.
        let (v_up, c_up) = ((slope * v2 + vz) * over, (slope * c2 + cz) * over);
        let (of_view, of_light) = (1.0 / of_view.sqrt(), 1.0 / of_light.sqrt());
        let (vx, vu, cx, cu) = (v1 * of_view, v_up * of_view, c1 * of_light, c_up * of_light);
        let (x, z) = (vx + cx, vu + cu);
        // Where both are about opposite, what is across their difference.
        let is_opposite = IS_CUT && x * x + z * z < 1.0;
        let (x, z) = (if is_opposite { cu - vu } else { x }, if is_opposite { vx - cx } else { z });
        let length = 1.0 / clear(x * x + z * z).sqrt();
        let (x, z) = (x * length, z * length);

        let b = (1.0 + y * y).sqrt();
        let scale = root / (along * b);
        let shift = if IS_BRUSHED { shear * y / b } else { 0.0 };
        let (below, above) = (z + x * tan, z - x * tan);
        let (start, end) = (x - tan * z, x + tan * z);
        let finite = |steep: f32, end: f32| {
            let sign = if (end < 0.0) == (steep < 0.0) { 1.0 } else { -1.0 };
            if steep.abs() > 1e-5 { end / steep } else { sign * FAR }
        };
        let (p, q) = (scale * finite(below, start), scale * finite(above, end));
        let (p, q) = if IS_BRUSHED { (p - shift, q - shift) } else { (p, q) };
        let (p, q) = if all { (-FAR * scale, FAR * scale) } else { (p, q) };
        let is_one = p < q;
        let length = scale * 2.0 * tan / (below * above);
        let length = if all || below * above < 1e-9 { q - p } else { length };
        let part = |p: f32, q: f32, length: f32| {
            self.part::<IS_BRUSHED>([along, b, slope, shear, shift], [p, q], if hits { length } else { 0.0 })
        };
        if !IS_CUT {
            return part(p, q, if is_one { length } else { 0.0 }).map(|part| weight * part);
        }
        let (least, most) = self.above(slope, 1.0 / (along * b));
        let (least, most) = if IS_BRUSHED { (least - shift, most - shift) } else { (least, most) };
        // One range from p to q, in halves by its angle, or all but what is between q and p.
        let low = if p > least { p } else { least };
        let high = if q < most { q } else { most };
        let length = if least > p || most < q { high - low } else { length };
        let (of_low, of_high) = ((1.0 + low * low).sqrt(), (1.0 + high * high).sqrt());
        let before = length * (of_low / (of_low + of_high));
        let middle = low + before;
        let ends = if is_one { [middle, middle] } else { [most, least] };
        let lengths = if is_one { [before, length - before] } else { [most - low, high - least] };
        let (first, second) = (part(low, ends[0], lengths[0]), part(ends[1], high, lengths[1]));
        [weight * (first[0] + second[0]), weight * (first[1] + second[1])]
    }

    /// The part of a chord whose directions are above the horizon, in steps of `unit`.
    #[inline(always)]
    fn above(&self, slope: f32, unit: f32) -> (f32, f32) {
        let [v1, v2, vz] = self.view.to_array();
        let (center, aside) = (v1 / vz, slope - v2 / vz);
        let rest = 1.0 / (vz * vz) - aside * aside;
        let reach = root_of(rest);
        ((center - reach) * unit, (center + reach) * unit)
    }

    /// A range of a chord: closed for the cosine lobe, and the rest of the reflectance at two points with the range's mean and variance.
    #[inline(always)]
    fn part<const IS_BRUSHED: bool>(
        &self,
        [along, b, slope, shear, shift]: [f32; 5],
        [p, q]: [f32; 2],
        length: f32,
    ) -> [f32; 2] {
        let [v1, v2, vz] = self.view.to_array();
        let counts = length > 0.0;
        let length = if counts { length } else { 0.0 };
        // ∫ dX/(1+X²)² = ½ [X/(1+X²) + arctan X] from p to q, without the difference.
        let m = 1.0 + p * q;
        let over = 1.0 / (m * m + length * length);
        let is_short = length < 0.3 * m;
        let ratio = if is_short { length / m } else { 0.0 };
        let sq = ratio * ratio;
        let series = ratio * sq * (2.0 / 3.0 - sq * (0.8 - sq * (6.0 / 7.0 - sq * (8.0 / 9.0))));
        let angle = atan2(length, m);
        let short_angle = ratio * (1.0 - sq * (1.0 / 3.0 - sq * (0.2 - sq / 7.0)));
        let angle = if is_short { short_angle } else { angle };
        let value = 0.5 * if is_short { 2.0 * length * over + series } else { length * (2.0 - m) * over + angle };
        let counts = counts && value > 0.0;
        let inverse = 1.0 / if value > 1e-30 { value } else { 1e-30 };
        let mean = 0.5 * length * (p + q) * over * inverse;
        let variance = (angle - value) * inverse - mean * mean;
        let apart = if variance > 0.0 { variance.sqrt() } else { 0.0 };
        let (first, last) = (mean - apart, mean + apart);
        let (first, last) = (if first > p { first } else { p }, if last < q { last } else { q });

        let rest = |x: f32| {
            let slope_x = along * b * if IS_BRUSHED { x + shift } else { x };
            let u = v1 * slope_x + v2 * slope + vz;
            let u = if u > 0.0 { u } else { 0.0 };
            let square = 1.0 + slope_x * slope_x + slope * slope;
            let vh = u / square.sqrt();
            let fifth = schlick(vh);
            // dω_l = 4 (ω_o·h) dω_h; the cosine lobe has taken n·h.
            let light = 2.0 * u / square - vz;
            let rest = u * if IS_BRUSHED {
                let aside = [2.0 * u * slope_x / square - v1, 2.0 * u * slope / square - v2];
                masked(light, vz, self.shadowing, sheared(aside, [along, shear, self.alpha_sq.sqrt()]))
            } else {
                masking(light, vz, self.alpha_sq, self.shadowing)
            };
            [rest * (1.0 - fifth), rest * fifth]
        };
        let (first, last) = (rest(first), rest(last));
        let both = [value * 2.0 * (first[0] + last[0]), value * 2.0 * (first[1] + last[1])];
        both.map(|value| if counts { value } else { 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use crate::oracle::{CapMicrofacets, Random};
    use crate::{Cone, Microfacets, Receiver, cap_integral};
    use core::f64::consts::{FRAC_PI_2, PI, TAU};
    use glam::{DVec3, Vec3};

    const SECTORS: u32 = 200;

    /// Both lobes' integrals over a light.
    fn integrals(of: &CapMicrofacets, axis: DVec3, half_angle: f64) -> [f64; 2] {
        let view = of.view.as_vec3();
        let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, view);
        let cone = Cone { axis: axis.as_vec3(), one_minus_cos: (1.0 - half_angle.cos()) as f32, distance: 1.0 };
        let both = Microfacets::new(view, of.alpha as f32, [Vec3::ONE; 2]);
        both.map(|facets| f64::from(cap_integral(&at, facets, &cone)))
    }

    /// Mean and largest error over lights of a half-angle, above the horizon or across it, relative to the light in the mirror or, where
    /// that is more, to 50 times the value.
    fn errors(roughness: f64, half_angle: f64, crosses: bool) -> [f64; 2] {
        let mut random = Random::new(7);
        let alpha = roughness * roughness;
        let (mut sum, mut worst, mut count) = (0.0, 0.0_f64, 0);
        while count < 25 {
            let tilt = random.between(0.02, 80f64.to_radians());
            let (light, turn) = if crosses {
                (
                    FRAC_PI_2 + half_angle * random.between(-0.95, 0.95),
                    PI + random.between(-0.5, 0.5) * (1.0 + 2.0 * alpha),
                )
            } else {
                let (aside, at) = (random.uniform() * (half_angle + 3.0 * alpha), random.uniform() * TAU);
                (tilt + aside * at.cos(), PI + aside * at.sin() / tilt.sin().max(0.3))
            };
            let polar =
                |angle: f64, turn: f64| DVec3::new(angle.sin() * turn.cos(), angle.sin() * turn.sin(), angle.cos());
            let (view, axis) = (polar(tilt, 0.0), polar(light, turn));
            if (axis.z < half_angle.sin()) != crosses {
                continue;
            }
            let microfacets = CapMicrofacets { view, alpha };
            let want = microfacets.over_cap(axis, half_angle, SECTORS);
            let mirror = microfacets.over_cap(polar(tilt, PI), half_angle, SECTORS);
            let got = integrals(&microfacets, axis, half_angle);
            let size = if crosses { want[0].max(0.02 * mirror[0]) } else { mirror[0] };
            let error = ((got[0] - want[0]).abs() + (got[1] - want[1]).abs()) / size;
            assert!(error.is_finite(), "{view} {axis}");
            sum += error;
            worst = worst.max(error);
            count += 1;
        }
        [sum / 25.0, worst]
    }

    #[test]
    fn integrals_are_those_of_quadrature() {
        for roughness in [0.1, 0.2, 0.3, 0.5, 0.7, 1.0] {
            for (degrees, limits) in [(1.0, [3e-4, 5e-3]), (5.0, [3e-4, 5e-3]), (25.0, [5e-4, 8e-3])] {
                let got = errors(roughness, f64::to_radians(degrees), false);
                println!("roughness {roughness}, {degrees}°: mean {:.1e}, worst {:.1e}", got[0], got[1]);
                assert!(got[0] < limits[0] && got[1] < limits[1], "{roughness} {degrees}: {got:?}");
            }
            for (degrees, limits) in [(5.0, [5e-5, 5e-4]), (25.0, [3e-3, 0.012])] {
                let got = errors(roughness, f64::to_radians(degrees), true);
                println!(
                    "roughness {roughness}, {degrees}° through the horizon: mean {:.1e}, worst {:.1e}",
                    got[0], got[1]
                );
                assert!(got[0] < limits[0] && got[1] < limits[1], "{roughness} {degrees}: {got:?}");
            }
        }
    }

    /// Views and lights near the horizon, the light where a mirror sees it.
    #[test]
    fn grazing_lights_are_those_of_quadrature() {
        let mut random = Random::new(11);
        let (mut sum, mut worst) = (0.0, 0.0_f64);
        for _ in 0..200 {
            let tilt = random.between(1.2, 1.5);
            let (half_angle, alpha) = (random.log_uniform(0.05, 0.6), random.log_uniform(0.02, 0.8));
            let view = DVec3::new(tilt.sin(), 0.0, tilt.cos());
            let axis = DVec3::new(-tilt.sin(), 0.0, tilt.cos());
            let microfacets = CapMicrofacets { view, alpha };
            let want = microfacets.over_cap(axis, half_angle, SECTORS);
            let got = integrals(&microfacets, axis, half_angle);
            let error = ((got[0] - want[0]).abs() + (got[1] - want[1]).abs()) / (want[0] + want[1]);
            sum += error;
            worst = worst.max(error);
        }
        println!("grazing: mean {:.1e}, worst {worst:.1e}", sum / 200.0);
        assert!(sum / 200.0 < 2e-3 && worst < 0.02);
    }

    /// Lights beside the highlight, at gaps of 1 to 64 α between their nearest half vector and the normal: relative to the value itself.
    #[test]
    fn lights_beside_the_highlight_are_those_of_quadrature() {
        for roughness in [0.03, 0.05, 0.08, 0.1, 0.2] {
            let alpha = roughness * roughness;
            for (degrees, gap) in
                [0.5f64, 9.0, 20.0].into_iter().flat_map(|d| [1.0, 4.0, 16.0, 64.0].map(|gap| (d, gap)))
            {
                let (half_angle, aside) = (degrees.to_radians(), degrees.to_radians() + 2.0 * gap * alpha);
                let (mut sum, mut worst, mut count) = (0.0, 0.0_f64, 0);
                for (tilt, turn) in
                    [0.1f64, 0.7, 1.2].into_iter().flat_map(|tilt| [0.0f64, 1.0, 2.0].map(|turn| (tilt, turn)))
                {
                    let mirror = DVec3::new(-tilt.sin(), 0.0, tilt.cos());
                    let (u, v) = mirror.any_orthonormal_pair();
                    let axis = mirror * aside.cos() + (u * turn.cos() + v * turn.sin()) * aside.sin();
                    if axis.z < half_angle.sin() + 0.01 || aside > 1.0 {
                        continue;
                    }
                    let microfacets = CapMicrofacets { view: DVec3::new(tilt.sin(), 0.0, tilt.cos()), alpha };
                    let want = microfacets.over_cap(axis, half_angle, 1000)[0];
                    let error = (integrals(&microfacets, axis, half_angle)[0] / want - 1.0).abs();
                    (sum, worst, count) = (sum + error, worst.max(error), count + 1);
                }
                let mean = sum / f64::from(count.max(1));
                println!("roughness {roughness}, {degrees}°, {gap} α beside: mean {mean:.1e}, worst {worst:.1e}");
                assert!(mean < 1.5e-4 && worst < 5e-4, "{roughness} {degrees} {gap}: {mean} {worst}");
            }
        }
    }

    /// Lights that the horizon cuts or that are just above it, wherever the highlight is: relative to the value itself, from 1e-4 of the light in the mirror
    /// on. The rest of the reflectance falls to nothing at the horizon, within a few `α` of it.
    #[test]
    fn lights_at_the_horizon_are_those_of_quadrature() {
        let polar = |angle: f64, turn: f64| DVec3::new(angle.sin() * turn.cos(), angle.sin() * turn.sin(), angle.cos());
        for roughness in [0.2, 0.35, 0.8] {
            for (degrees, crosses, limits) in [
                (8.0f64, true, [3e-3, 0.01]),
                (8.0, false, [5e-4, 3e-3]),
                (30.0, true, [8e-3, 0.03]),
                (30.0, false, [5e-4, 3e-3]),
            ] {
                let mut random = Random::new(13);
                let (half_angle, alpha) = (degrees.to_radians(), roughness * roughness);
                let (mut sum, mut worst, mut count) = (0.0, 0.0_f64, 0);
                while count < 16 {
                    let tilt = random.between(0.02, 80f64.to_radians());
                    let below = if crosses { random.between(-0.9, 0.9) } else { random.between(-1.5, -1.0) };
                    let (view, axis) =
                        (polar(tilt, 0.0), polar(FRAC_PI_2 + half_angle * below, random.uniform() * TAU));
                    let microfacets = CapMicrofacets { view, alpha };
                    let mirror = microfacets.over_cap(polar(tilt, PI), half_angle, 50)[0];
                    if microfacets.over_cap(axis, half_angle, 50)[0] < 1e-4 * mirror {
                        continue;
                    }
                    let want = microfacets.over_cap(axis, half_angle, SECTORS)[0];
                    let error = (integrals(&microfacets, axis, half_angle)[0] / want - 1.0).abs();
                    (sum, worst, count) = (sum + error, worst.max(error), count + 1);
                }
                let mean = sum / f64::from(count);
                println!(
                    "roughness {roughness}, {degrees}° at the horizon, cut {crosses}: mean {mean:.1e}, worst {worst:.1e}"
                );
                assert!(mean < limits[0] && worst < limits[1], "{roughness} {degrees} {crosses}: {mean} {worst}");
            }
        }
    }

    /// Finite and not negative, whatever the input.
    #[test]
    fn integrals_are_total() {
        let mut random = Random::new(9);
        let vector = |random: &mut Random| random.axis().as_vec3().normalize();
        for _ in 0..100_000 {
            let normal = vector(&mut random);
            let view = if random.uniform() < 0.1 { normal } else { vector(&mut random) };
            let light =
                if random.uniform() < 0.1 { 2.0 * normal.dot(view) * normal - view } else { vector(&mut random) };
            let light = if random.uniform() < 0.05 { -view } else { light };
            let alpha = random.log_uniform(1e-4, 1.0) as f32;
            let one_minus_cos = random.log_uniform(1e-12, 1.0) as f32;
            let at = Receiver::on_surface(Vec3::ZERO, normal, view);
            for facets in Microfacets::new(view, alpha, [Vec3::ONE; 2]) {
                let value = cap_integral(&at, facets, &Cone { axis: light, one_minus_cos, distance: 1.0 });
                assert!(
                    value.is_finite() && (0.0..1.2).contains(&value),
                    "{value}: {at:?} {facets:?} {light} {one_minus_cos}"
                );
            }
        }
    }
}
