use super::view::Values;
use super::{Pole, SkyBlend, SkyHighlight, SkyResolution};
use fearless_simd::{Simd, f32x8, prelude::*};
use glam::Vec3;
use lobe_core::Microfacets;
use lobe_core::vec3x8::{LANES, Vec3x8};

/// The widest step between samples that is good for a streak: the factor by which its width is larger.
pub(crate) const ACROSS: f32 = 1.3;
/// Directions at most that stand for one sample across such a streak.
const MOST_ACROSS: usize = 16;

/// Steps between samples in the width of a lobe across its streak, at an angle from the mirrored view: half vectors turn by half of it, or half a
/// deviation in the mean, and a tail is as wide as it is far.
fn across(samples: SkyResolution, facets: &Microfacets, normal: Vec3, angle: f32) -> f32 {
    let deviation = 1.0 / facets.exponent.sqrt();
    let turn = 0.5 * angle;
    let height = narrowing(facets, normal) + turn.max(0.5 * deviation);
    2.0 * deviation.max(turn) * height / samples.pitch()
}

/// By how much a view makes the highlight's least width smaller than half vectors say.
fn narrowing(facets: &Microfacets, normal: Vec3) -> f32 {
    let cos = facets.view.dot(normal).max(0.0);
    facets.grain.map_or(cos, |grain| grain.narrowing(facets.at(normal).highlight().1, cos))
}

/// Whether samples resolve microfacets across the streak that a low view makes of their highlight.
pub(super) fn is_wide(samples: SkyResolution, facets: &Microfacets, normal: Vec3) -> bool {
    across(samples, facets, normal, 0.0) >= ACROSS
}

/// Directions that stand for one sample of a lobe that is narrower than the samples: spread evenly over its cell.
pub(super) struct Spread {
    /// In parts of a cell along the circle of its height and along its meridian: multiples of two numbers, so that they are even in any direction.
    places: [[f32; 2]; MOST_ACROSS],
    count: usize,
    pole: Pole,
    /// Of azimuth and elevation numbers.
    steps: [f32; 2],
    highlight: SkyHighlight,
    /// The square of the chord to the highlight beyond which the lobe is wide enough.
    reach: f32,
}

impl Spread {
    /// Of the part of a lobe beyond an angle from the mirrored view. None where one direction is enough.
    pub(super) fn new(
        samples: SkyResolution,
        pole: Pole,
        (facets, normal): (&Microfacets, Vec3),
        angle: f32,
    ) -> Option<Self> {
        const GOLDEN: f32 = 0.618_034;
        let across = across(samples, facets, normal, angle);
        if across >= ACROSS {
            return None;
        }
        let height = narrowing(facets, normal);
        let reach = (height * height + 2.0 * ACROSS * samples.pitch()).sqrt() - height;
        let count = ((ACROSS / across).ceil() as usize).clamp(2, MOST_ACROSS);
        let places = core::array::from_fn(|k| {
            let k = k as f32 + 0.5;
            [k / count as f32, (k * GOLDEN).fract()].map(|place| place - 0.5)
        });
        let steps = [4.0 / samples.rows() as f32, 2.0 / samples.samples() as f32];
        let highlight = SkyHighlight::new(&(*facets).into(), normal);
        Some(Self { places, count, pole, steps, highlight, reach: reach * reach })
    }

    /// Whether any of eight directions is so near to the highlight that the lobe is narrow there.
    #[inline(always)]
    pub(super) fn is_near<S: Simd>(&self, simd: S, v: Vec3x8<S>) -> bool {
        self.highlight.square(simd, v).simd_lt(f32x8::splat(simd, self.reach)).any_true()
    }

    /// Steps along the circle of a height and along a meridian, in the world: those of azimuth and elevation numbers times
    /// `dφ/dp = (|x| + |y|)²/ρ²` and `dθ/de = (ρ + |z|)²`.
    #[inline(always)]
    fn sides<S: Simd>(&self, simd: S, v: Vec3x8<S>) -> [Vec3x8<S>; 2] {
        let Vec3x8 { x, y, z } = self.pole.local_of(v);
        let square = (x * x + y * y).max(f32x8::splat(simd, 1e-6));
        let radius = square.sqrt();
        let (sum, all) = (x.abs() + y.abs(), radius + z.abs());
        let around = sum * sum / square * self.steps[0];
        let along = all * all * self.steps[1];
        let beside = along * z / radius;
        let [one, other, up] = self.pole.frame();
        let (one, other, up) = (Vec3x8::splat(simd, one), Vec3x8::splat(simd, other), Vec3x8::splat(simd, up));
        [one * (-y * around) + other * (x * around), one * (x * beside) + other * (y * beside) + up * (-radius * along)]
    }

    /// The mean of the values of a part of a lobe.
    #[inline(always)]
    pub(super) fn values<S: Simd, const P: usize>(
        &self,
        simd: S,
        lobe: &impl Values<P>,
        blend: &SkyBlend,
        v: Vec3x8<S>,
    ) -> Option<[[f32; LANES]; P]> {
        let [around, along] = self.sides(simd, v);
        let mut sums = [f32x8::splat(simd, 0.0); P];
        let mut is_something = false;
        for place in &self.places[..self.count] {
            let [one, other] = place.map(|place| f32x8::splat(simd, place));
            let beside = v + around * one + along * other;
            let beside = beside * (f32x8::splat(simd, 1.0) / beside.dot(beside).sqrt());
            let Some(values) = lobe.values(simd, beside) else { continue };
            is_something = true;
            let part = blend.of_eight(simd, beside).unwrap_or(f32x8::splat(simd, 1.0));
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += f32x8::simd_from(simd, value) * part;
            }
        }
        let part = 1.0 / self.count as f32;
        is_something.then(|| sums.map(|sum| (sum * part).into()))
    }
}
