//! Tone maps: radiance without an upper end to the values that screens show.

use crate::srgb::srgb;
use glam::{Mat3, Vec3};

/// How radiance beyond white comes into the range of a screen.
///
/// Input is linear, of the primaries of sRGB, after exposure; 1 is white. Not a number is black, negative is black.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ToneMap {
    /// Values are cut at 1, channel by channel. The one for comparisons: below white nothing changes.
    Linear,
    /// Below 0.8 nothing changes; brighter colours approach white and lose saturation, as in Khronos PBR Neutral. Dark rooms and shadows
    /// stay as they are.
    #[default]
    Soft,
    /// Khronos PBR Neutral (2024): as [`Soft`](Self::Soft) from 0.76 on, after 0.04 is taken off, the reflection at right angles of common
    /// materials under light from all around; below 0.08 less, so that shadows grow darker.
    Neutral,
    /// AgX (Sobotka, 2022) with its base contrast, for light of 16.5 stops: -10 to +6.5 about a grey of 0.18. Saturated colours
    /// lose saturation long before they are white.
    Agx,
}

/// The largest input; beyond it nothing changes that could be seen.
const LARGEST: f32 = 1e9;

impl ToneMap {
    /// The values of a screen, encoded as sRGB, each in [0, 1].
    ///
    /// ```
    /// use glam::Vec3;
    /// use pictures::ToneMap;
    /// let cut = ToneMap::Linear.encode(Vec3::new(2.0, 0.0, f32::NAN));
    /// assert!(cut.abs_diff_eq(Vec3::X, 1e-6));
    /// assert!(ToneMap::Soft.encode(Vec3::splat(2.0)).x < 1.0);
    /// ```
    #[must_use]
    pub fn encode(self, linear: Vec3) -> Vec3 {
        let linear = each(linear, |x| if x.is_nan() { 0.0 } else { x.clamp(0.0, LARGEST) });
        let encoded = match self {
            Self::Linear => each(linear.min(Vec3::ONE), srgb),
            Self::Soft => each(neutral(linear, 0.0).min(Vec3::ONE), srgb),
            Self::Neutral => each(neutral(linear, 0.04).min(Vec3::ONE), srgb),
            Self::Agx => agx(linear),
        };
        encoded.clamp(Vec3::ZERO, Vec3::ONE)
    }
}

fn each(v: Vec3, f: impl Fn(f32) -> f32) -> Vec3 {
    Vec3::from_array(v.to_array().map(f))
}

/// Khronos PBR Neutral, with the constants of its specification but for the reflectance that it takes off, `f0`.
fn neutral(linear: Vec3, f0: f32) -> Vec3 {
    const DESATURATION: f32 = 0.15;
    let start = 0.8 - f0;
    let least = linear.min_element();
    let offset = if least < 2.0 * f0 { least - least * least / (4.0 * f0) } else { f0 };
    let color = linear - offset;
    let peak = color.max_element();
    if peak < start {
        return color;
    }
    let room = 1.0 - start;
    let mapped = 1.0 - room * room / (peak + room - start);
    let white = 1.0 - 1.0 / (DESATURATION * (peak - mapped) + 1.0);
    (color * (mapped / peak)).lerp(Vec3::splat(mapped), white)
}

/// The primaries drawn together, so that saturated light has something left in all channels.
const INSET: Mat3 = Mat3::from_cols(
    Vec3::new(0.842_479_06, 0.042_328_242, 0.042_375_654),
    Vec3::new(0.078_433_6, 0.878_468_64, 0.078_433_6),
    Vec3::new(0.079_223_745, 0.079_166_13, 0.879_143),
);

/// The inverse of [`INSET`].
const OUTSET: Mat3 = Mat3::from_cols(
    Vec3::new(1.196_879, -0.052_896_85, -0.052_971_635),
    Vec3::new(-0.098_020_88, 1.151_903_1, -0.098_043_45),
    Vec3::new(-0.099_029_74, -0.098_961_18, 1.151_073_7),
);

/// AgX without a look: logarithm between its ends, a sigmoid, back to the primaries.
fn agx(linear: Vec3) -> Vec3 {
    /// log₂ of a grey of 0.18, ten stops below and six and a half above.
    const ENDS: [f32; 2] = [-12.473_93, 4.026_069];
    let log = |x: f32| (x.max(1e-10).log2().clamp(ENDS[0], ENDS[1]) - ENDS[0]) / (ENDS[1] - ENDS[0]);
    OUTSET * each(INSET * linear, |x| sigmoid(log(x)))
}

/// AgX's curve through (10/16.5, 0.5) with a slope of 2: on each side `s·t/(1 + tᵖ)^(1/p)`, `t` the tangent over `s`, and `s` such
/// that it ends at 0 and 1; p = 3 below, 3.25 above.
fn sigmoid(x: f32) -> f32 {
    const PIVOT: [f32; 2] = [10.0 / 16.5, 0.5];
    const SLOPE: f32 = 2.0;
    let above = x >= PIVOT[0];
    let (width, power) = if above { (1.0 - PIVOT[0], 3.25_f32) } else { (PIVOT[0], 3.0) };
    let reach = SLOPE * width;
    let scale = reach * ((reach / 0.5).powf(power) - 1.0).powf(-1.0 / power);
    let t = SLOPE * (x - PIVOT[0]).abs() / scale;
    let y = scale * t / (1.0 + t.powf(power)).powf(1.0 / power);
    PIVOT[1] + if above { y } else { -y }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [ToneMap; 4] = [ToneMap::Linear, ToneMap::Soft, ToneMap::Neutral, ToneMap::Agx];

    /// Every input gives values in range; grey stays grey and grows with its input; black is black.
    #[test]
    fn total_and_monotone() {
        let hostile = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, -0.0, f32::MIN_POSITIVE, f32::MAX, 0.5];
        for tone in ALL {
            for r in hostile {
                for g in hostile {
                    for b in hostile {
                        let v = tone.encode(Vec3::new(r, g, b));
                        assert!(v.cmpge(Vec3::ZERO).all() && v.cmple(Vec3::ONE).all(), "{tone:?} {r} {g} {b}: {v}");
                    }
                }
            }
            let mut last = 0.0;
            for step in 0..4000_u16 {
                let x = (f32::from(step) / 4000.0 * 22.0 - 14.0).exp2();
                let v = tone.encode(Vec3::splat(x));
                assert!((v.max_element() - v.min_element()) < 5e-4 && v.x >= last - 1e-6, "{tone:?} {x}: {v}");
                last = v.x;
            }
            assert!(tone.encode(Vec3::ZERO).max_element() < 2e-3 && last > 0.97, "{tone:?} {last}");
        }
    }

    /// Values of the specification's formula worked out by hand: a grey loses 0.04; at 1 the peak is 0.96.
    #[test]
    fn neutral_is_that_of_khronos() {
        let neutral = |v| neutral(v, 0.04);
        assert!((neutral(Vec3::splat(0.5)) - 0.46).abs().max_element() < 1e-6);
        assert!((neutral(Vec3::splat(0.04)) - 0.01).abs().max_element() < 1e-7);
        // 1 - 0.24² / (0.96 + 0.24 - 0.76)
        assert!((neutral(Vec3::ONE).x - (1.0 - 0.0576 / 0.44)).abs() < 1e-6);
        // No offset where a channel is black. peak 4: 1 - 0.0576 / 3.48; white 1 - 1/(0.15 (4 - 0.98345) + 1)
        let (mapped, red) = (1.0 - 0.0576 / 3.48, neutral(Vec3::new(4.0, 0.0, 0.0)));
        let white = 1.0 - 1.0 / (0.15 * (4.0 - mapped) + 1.0);
        assert!((red - Vec3::new(mapped, mapped * white, mapped * white)).abs().max_element() < 1e-6, "{red}");
        let below = Vec3::new(0.7, 0.3, 0.0);
        assert_eq!(neutral(below), below);
    }

    /// Below its start it is linear, to the bit; its slope goes on there without a step.
    #[test]
    fn soft_leaves_shadows_alone() {
        for v in [Vec3::ZERO, Vec3::new(0.001, 0.02, 0.0), Vec3::splat(0.08), Vec3::new(0.799, 0.3, 0.1)] {
            assert_eq!(ToneMap::Soft.encode(v), ToneMap::Linear.encode(v));
        }
        let slope = (neutral(Vec3::splat(0.801), 0.0) - neutral(Vec3::splat(0.8), 0.0)) / 0.001;
        assert!((slope.x - 1.0).abs() < 0.02, "{slope}");
    }

    /// The curve against the polynomial of sixth degree by which other programs approximate it; its ends and its pivot; matrices.
    #[test]
    fn agx_is_that_of_others() {
        let polynomial = |x: f32| {
            let terms = [-0.002_32, 0.1191, 0.4298, -6.868, 31.96, -40.14, 15.5];
            terms.iter().rev().fold(0.0, |sum, c| sum * x + c)
        };
        for step in 0..=1000_u16 {
            let x = f32::from(step) / 1000.0;
            assert!((sigmoid(x) - polynomial(x)).abs() < 0.006, "{x}");
        }
        assert!(sigmoid(0.0).abs() < 1e-6 && (sigmoid(1.0) - 1.0).abs() < 1e-6);
        assert!((agx(Vec3::splat(0.18)) - 0.5).abs().max_element() < 1e-4);
        let identity = INSET * OUTSET;
        assert!((identity - Mat3::IDENTITY).to_cols_array().iter().all(|x| x.abs() < 1e-5), "{identity}");
    }
}
